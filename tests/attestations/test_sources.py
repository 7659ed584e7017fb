"""Sources before they are read: digests of their bytes, names without folders or servers, and whether they stayed the same."""

from __future__ import annotations

import hashlib
import os
import subprocess
import sys
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st
from needs import POSIX

from fairaudit.attestations.sources import refuse_credentials, take
from fairaudit.audits.origin import database_name
from fairaudit.errors import InputError


def digest(path: Path) -> str:
    return hashlib.sha256(path.read_bytes()).hexdigest()


def test_digests_are_those_of_another_program(tmp_path: Path) -> None:
    path = tmp_path / "log.csv"
    path.write_bytes(os.urandom(3_000_000))
    [source] = take(path).sources
    printed = subprocess.run(["sha256sum", str(path)], capture_output=True, text=True, check=True).stdout
    assert (source.sha256, source.bytes) == (printed.split()[0], 3_000_000)


@pytest.mark.parametrize("change", ["append", "same size", "replace", "remove", "touch back"])
def test_a_change_is_seen(tmp_path: Path, change: str) -> None:
    path = tmp_path / "log.csv"
    path.write_text("a,b\n1,2\n")
    before = path.stat()
    taken = take(path)
    taken.unchanged()
    if change == "append":
        path.write_text("a,b\n1,2\n3,4\n")
    elif change == "replace":
        (tmp_path / "new").write_text("a,b\n1,2\n")
        (tmp_path / "new").replace(path)
    elif change == "remove":
        path.unlink()
    else:
        path.write_text("a,b\n9,2\n")
        os.utime(path, ns=(before.st_atime_ns, before.st_mtime_ns + (change == "same size")))
    with pytest.raises(InputError, match=r"log\.csv was changed while it was read"):
        taken.unchanged()


@pytest.mark.parametrize("inner", ["log.csv", "folder/log.csv"])
def test_a_link_that_led_elsewhere_meanwhile_is_seen(tmp_path: Path, inner: str) -> None:
    for name in ("one", "two"):
        (tmp_path / name / "folder").mkdir(parents=True)
        (tmp_path / name / inner).write_text(f"{name}\n")
    link = tmp_path / Path(inner).parts[0]
    link.symlink_to(tmp_path / "one" / Path(inner).parts[0])
    taken = take(tmp_path / inner)
    taken.unchanged()
    for name in ("two", "one"):
        (tmp_path / "new").symlink_to(tmp_path / name / Path(inner).parts[0])
        (tmp_path / "new").replace(link)
    assert (tmp_path / inner).read_text() == "one\n"
    with pytest.raises(InputError, match=r"log\.csv was changed while it was read"):
        taken.unchanged()


def test_a_pattern_that_comes_to_stand_for_more_is_seen(tmp_path: Path) -> None:
    (tmp_path / "a.csv").write_text("a\n")
    taken = take(str(tmp_path / "*.csv"))
    (tmp_path / "b.csv").write_text("a\n")
    with pytest.raises(InputError, match="stands for other files"):
        taken.unchanged()


def test_the_folder_of_a_delta_table_is_all_its_files(tmp_path: Path) -> None:
    folder = tmp_path / "table"
    (folder / "_delta_log").mkdir(parents=True)
    (folder / "_delta_log" / "0.json").write_text("{}")
    (folder / "part.parquet").write_bytes(b"PAR1")
    for name in (str(folder), f"delta:{folder}"):
        taken = take(name)
        assert [(s.name, s.sha256) for s in taken.sources] == [
            ("0.json", digest(folder / "_delta_log" / "0.json")),
            ("part.parquet", digest(folder / "part.parquet")),
        ]
    (folder / "new.parquet").write_bytes(b"PAR1")
    with pytest.raises(InputError, match="stands for other files"):
        taken.unchanged()


@POSIX
def test_a_pipe_has_no_digest_and_is_not_read(tmp_path: Path) -> None:
    os.mkfifo(tmp_path / "pipe")
    [source] = take(tmp_path / "pipe").sources
    assert (source.sha256, source.bytes, source.name) == (None, None, "a pipe")


def test_a_table_in_memory_has_no_digest() -> None:
    [source] = take({"a": [1]}).sources
    assert (source.sha256, source.name) == (None, "a table in memory")


def test_the_only_source_of_rows_has_their_number(tmp_path: Path) -> None:
    for name in ("a.csv", "b.csv"):
        (tmp_path / name).write_text("x\n")
    one, two = take(tmp_path / "a.csv", beside=[str(tmp_path / "b.csv")]), take([tmp_path / "a.csv", tmp_path / "b.csv"])
    assert [source.rows for source in one.with_rows(7)] == [7, None]
    assert [source.rows for source in two.with_rows(7)] == [None, None]


PARTS = st.text("abcXYZ019._-", min_size=1, max_size=8)


@given(PARTS, st.text("abc019!$%*+,:@/ ", min_size=1, max_size=8), PARTS, PARTS)
def test_no_server_user_or_password_is_part_of_a_name(user: str, password: str, host: str, name: str) -> None:
    secrets = f"U{user}", f"P{password}S", f"H{host}"
    for url in (
        f"postgresql://{secrets[0]}:{secrets[1]}@{secrets[2]}:5432/{name}",
        f"postgresql://{secrets[2]}/{name}?user={secrets[0]}&password={secrets[1]}",
        f"postgresql://{secrets[0]}:{secrets[1]}@{secrets[2]}",
    ):
        found = database_name(url)
        assert found in ("postgresql", f"postgresql:{name}")
    assert database_name(f"sqlite:/home/{user}/{name}") == f"sqlite:{name}"


@pytest.mark.parametrize("url", ["postgresql://u:p/w@h", "x://a:b@c", "x://[::1", "mysql://u:p@h/d;password=x", "x://h/%2Fhome%2Fme"])
def test_what_could_be_a_secret_is_left_out_of_a_name(url: str) -> None:
    assert database_name(url) == url.partition(":")[0]


@pytest.mark.parametrize(
    "text",
    [
        "postgresql://me:hush@h/db",
        "Postgres:/me:hush@h/db",
        "postgres:me:hush@h/db",
        "https://ghp_hush@host/x",
        "x dblink('host=a password=hush')",
        "select 1 /* PGPASSWORD=hush */",
        "select 1 -- password hush",
        "dbpassword=hush",
        "alter user me PASSWORD 'hush'",
        "identified  by hush",
        '{"password": "hush"}',
        '{"secret" : "hush"}',
        "PWD: hush",
        "pw=hush",
        "db_pass=hush",
        "pass = 'hush'",
        "token=hush",
        "secret => 'hush'",
        "secret $$hush$$",
        "read('az://c/x?sv=1&sig=hush')",
        "AccountName=me;AccountKey=hush==",
        "SharedAccessSignature=hush",
        "set api_key = 'hush'",
        "aws_secret_access_key:hush",
        "Authorization: Bearer hush",
        "bearer hushhush",
        "ghp_hushhushhushhush",
        "'eyJhushhushhush.hush'",
        "AKIAhushhushhushhush",
        "-----BEGIN EC PRIVATE KEY----- hush",
        "ｐａｓｓｗｏｒｄ=hush",
        "p%61ssword%3Dhush",
        "postgresql%3A%2F%2Fme%3Ahush%40h",
        "kennwort hush",
    ],
)
def test_credentials_are_refused_and_not_repeated(text: str) -> None:
    with pytest.raises(InputError, match=r"^the query holds what looks like a password") as caught:
        refuse_credentials(text, "the query", query=True)
    assert "hush" not in str(caught.value) and "password (" in str(caught.value)


@pytest.mark.parametrize(
    "text",
    [
        "SELECT 1",
        "WHERE secretary = 'x'",
        "https://example.org/a:b@c",
        "WHERE forward = 1 -- backward: no",
        "SELECT pass, token::text, pwd FROM log WHERE passed = 1 AND passenger = 'x'",
        "SELECT CASE WHEN score > 5 THEN 'pass' ELSE 'fail' END AS outcome",
        "SELECT key, design, assign FROM log WHERE key = 3 AND design = 'x' AND author = 'y'",
        "SELECT hired, sex FROM read_parquet('s3://bucket/log.parquet') WHERE day >= '2025-01-01 10:00:00'",
        "SELECT count(*) FROM log WHERE mail LIKE '%@example.org' AND start::time > '10:00:00'::time",
    ],
)
def test_other_texts_are_no_credentials(text: str) -> None:
    refuse_credentials(text, "the query", query=True)


def test_what_looks_like_a_password_is_named() -> None:
    with pytest.raises(InputError, match=r"password \('pwd'\)"):
        refuse_credentials("SELECT hired FROM log WHERE pwd = 'yes'", "the query", query=True)
    for text in ("pass=1,fail=0", "password_reset", "token: yes"):  # labels and columns are none
        refuse_credentials(text, "--utility")


def test_a_query_over_a_table_in_memory_is_looked_at_too() -> None:
    with pytest.raises(InputError, match="looks like a password"):
        take({"a": [1]}, query="select 'password=hush'")


@pytest.mark.skipif(sys.platform == "win32", reason="names of files are texts there")
def test_a_name_that_is_no_text_is_refused(tmp_path: Path) -> None:
    path = os.fsdecode(os.fsencode(str(tmp_path)) + b"/\xff.csv")
    Path(path).write_text("a\n")
    with pytest.raises(InputError, match="rename the file"):
        take(path)
