"""One row, once: a file, its copies, its links, what it is packed in and its tallies are never counted together."""

from __future__ import annotations

import bz2
import gzip
import json
import lzma
import os
import re
import shutil
import subprocess
import sys
import zipfile
from collections.abc import Callable
from itertools import combinations
from pathlib import Path
from typing import Any

import pytest

import fairaudit as fa
from fairaudit.tables.engines.logs import read_log, read_parts
from fairaudit.tables.engines.tally_files import KEY

COLUMNS = ("d", "g")
ROWS = [("yes", "f"), ("no", "m"), ("yes", "m"), ("no", "f")]
ROLES = {"decision": "d", "group": "g", "utility": "yes"}


def log(path: Path, times: int = 75) -> Path:
    """300 decisions."""
    path.write_text("d,g\n" + "".join(f"{d},{g}\n" for d, g in ROWS) * times)
    return path


def copied(of: Path) -> Path:
    return Path(shutil.copy(of, of.with_name("copy.csv")))


def symlink(of: Path) -> Path:
    (link := of.with_name("symlink.csv")).symlink_to(of.name)
    return link


def hard_link(of: Path) -> Path:
    (link := of.with_name("hard.csv")).hardlink_to(of)
    return link


def packed(name: str, pack: Callable[[bytes], bytes]) -> Callable[[Path], Path]:
    def make(of: Path) -> Path:
        (path := of.with_name(name)).write_bytes(pack(of.read_bytes()))
        return path

    return make


def zipped(of: Path) -> Path:
    with zipfile.ZipFile(path := of.with_name("log.zip"), "w", zipfile.ZIP_DEFLATED) as archive:
        archive.write(of, "inside.csv")
    return path


SAME: dict[str, Callable[[Path], Path]] = {
    "itself": lambda of: of.parent / "." / ".." / of.parent.name / of.name,
    "copy": copied,
    "symlink": symlink,
    "hard link": hard_link,
    "gzip": packed("log.csv.gz", gzip.compress),
    "bzip2": packed("log.csv.bz2", bz2.compress),
    "xz": packed("log.csv.xz", lzma.compress),
    "zip": zipped,
}


def texts(folder: Path) -> dict[str, Path]:
    """The log under every name, as it lies there."""
    day = log(folder / "day1.csv")
    return {"file": day, **{name: make(day) for name, make in SAME.items()}}


def test_no_two_of_a_file_its_copies_its_links_and_its_archives_are_counted_together(tmp_path: Path) -> None:
    held = texts(tmp_path)
    alone = {name: read_log(path, COLUMNS).rows for name, path in held.items()}
    assert set(alone.values()) == {300}
    for one, other in combinations(held, 2):
        for pair in ((one, other), (other, one)):
            paths = [held[name] for name in pair]
            with pytest.raises(fa.InputError, match="each row is counted once") as refused:
                read_log(paths, COLUMNS)
            assert all(str(path) in str(refused.value) for path in paths), pair
            with pytest.raises(fa.InputError, match="each row is counted once"):
                fa.audit(paths, **ROLES)  # type: ignore[arg-type]
            with pytest.raises(fa.InputError, match="each row is counted once"):
                fa.tally(paths, tmp_path / "both.parquet", COLUMNS)
    assert not (tmp_path / "both.parquet").exists()


def test_no_two_tallies_of_one_log_are_added_up_however_the_log_was_packed(tmp_path: Path) -> None:
    held = texts(tmp_path)
    tallies = {}
    for number, (name, path) in enumerate(held.items()):
        fa.tally(path, made := tmp_path / f"tally{number}.parquet", COLUMNS if number % 2 else COLUMNS[::-1])
        tallies[name] = made
    other = log(tmp_path / "day2.csv", 50)
    fa.tally([held["file"], other], tmp_path / "week.parquet", COLUMNS)
    fa.tally(other, tmp_path / "day2.parquet", COLUMNS)
    tallies["week"] = tmp_path / "week.parquet"
    for one, two in combinations(tallies, 2):
        paths = [tallies[one], tallies[two]]
        with pytest.raises(fa.InputError, match="each row is counted once") as refused:
            fa.audit(paths, **ROLES, count="n")  # type: ignore[arg-type]
        assert all(str(path) in str(refused.value) for path in paths)
    with pytest.raises(fa.InputError, match="each row is counted once"):
        list(read_parts([tallies["file"], tallies["week"]], COLUMNS, ["g"], count="n"))
    with pytest.raises(fa.InputError, match="each row is counted once"):
        fa.audit([tmp_path / "week.parquet", tmp_path / "day2.parquet"], **ROLES, count="n")  # type: ignore[arg-type]
    whole = fa.audit([tallies["zip"], tmp_path / "day2.parquet"], **ROLES, count="n")  # type: ignore[arg-type]
    assert whole.law.totals.sum() == 500


def test_a_tally_is_neither_counted_beside_its_log_nor_counted_again(tmp_path: Path) -> None:
    day = log(tmp_path / "day1.csv")
    fa.tally(day, made := tmp_path / "day1.parquet", COLUMNS)
    shutil.copy(made, tmp_path / "again.parquet")
    for paths in ([day, made], [made, day]):
        with pytest.raises(fa.InputError) as refused:
            fa.audit(paths, **ROLES, count="n")  # type: ignore[arg-type]
        assert str(day) in str(refused.value) and str(made) in str(refused.value)
    with pytest.raises(fa.InputError, match="is a tally"):
        fa.tally(made, tmp_path / "tally-of-tally.parquet", COLUMNS)
    with pytest.raises(fa.InputError, match="have the same content; each row is counted once"):
        fa.audit([made, tmp_path / "again.parquet"], **ROLES, count="n")  # type: ignore[arg-type]


def test_copies_that_are_meant_are_accepted_and_one_file_under_two_names_never(tmp_path: Path) -> None:
    held = texts(tmp_path)
    paths = [held["file"], held["copy"], held["zip"]]
    assert fa.audit(paths, **ROLES, same_content="accept").law.totals.sum() == 900  # type: ignore[arg-type]
    assert read_log(paths[:2], COLUMNS, same_content="accept").notes == (
        f"{paths[0]} and {paths[1]} have the same content, and both are counted, as was asked for",
    )
    for link in ("itself", "symlink", "hard link"):
        with pytest.raises(fa.InputError, match="are one file; each row is counted once"):
            read_log([held["file"], held[link]], COLUMNS, same_content="accept")


def test_a_certificate_does_not_say_that_copies_were_accepted(tmp_path: Path) -> None:
    day = log(tmp_path / "day1.csv")
    both = fa.audit([day, copied(day)], **ROLES, same_content="accept")  # type: ignore[arg-type]
    assert both.certificate.text == fa.audit(log(tmp_path / "double.csv", 150), **ROLES).certificate.text  # type: ignore[arg-type]
    both.attest(tmp_path / "c.json", tmp_path / "a.json")
    stated = json.loads((tmp_path / "a.json").read_text())["predicate"]
    assert stated["options"]["same_content"] == "accept"
    found = fa.verify(tmp_path / "c.json", attestation=tmp_path / "a.json")
    assert found.ok and '"day1.csv" and "copy.csv"' in " ".join(found.attestation.said)  # type: ignore[union-attr]


def test_files_that_are_as_long_or_begin_alike_and_differ_are_counted(tmp_path: Path) -> None:
    one, two = tmp_path / "one.csv", tmp_path / "two.csv"
    start = "d,g\n" + "yes,f\n" * 20_000
    one.write_text(start + "no,m\n")
    two.write_text(start + "no,f\n")
    three = packed("three.csv.gz", gzip.compress)(two)
    two.write_text(start + "no,x\n")
    assert read_log([one, two, three], COLUMNS).rows == 60_003


def test_parts_without_a_row_are_read_however_equal_their_bytes_are(tmp_path: Path) -> None:
    import pyarrow as pa
    import pyarrow.parquet as pq

    kinds = pa.schema([("d", pa.string()), ("g", pa.string())])
    for number in range(3):
        pq.write_table(pa.table({"d": [], "g": []}, schema=kinds), tmp_path / f"part{number}.parquet")
    pq.write_table(pa.table({"d": ["yes"], "g": ["f"]}, schema=kinds), tmp_path / "part3.parquet")
    assert read_log(tmp_path / "*.parquet", COLUMNS).rows == 1


def test_a_tally_of_an_earlier_version_has_no_digests_and_is_added_up(tmp_path: Path) -> None:
    import pyarrow.parquet as pq

    for number, times in enumerate((75, 50)):
        fa.tally(log(tmp_path / f"day{number}.csv", times), tmp_path / f"day{number}.parquet", COLUMNS)
    held = pq.read_table(tmp_path / "day0.parquet")
    said = json.loads(held.schema.metadata[KEY.encode()])
    assert [len(digest) for digest in said.pop("sources")] == [64]
    pq.write_table(held.replace_schema_metadata({KEY: json.dumps(said)}), tmp_path / "day0.parquet")
    days = [tmp_path / f"day{number}.parquet" for number in range(2)]
    assert fa.audit(days, **ROLES, count="n").law.totals.sum() == 500  # type: ignore[arg-type]


def command(*words: str | Path) -> tuple[int, str]:
    found = subprocess.run([sys.executable, "-m", "fairaudit", *map(str, words)], capture_output=True, text=True, env=os.environ)
    return found.returncode, found.stdout + found.stderr


def test_commands_refuse_a_log_that_is_named_twice(tmp_path: Path) -> None:
    held = texts(tmp_path)
    roles = ("--decision", "d", "--group", "g")
    day, copy = held["file"], held["copy"]
    fa.tally(day, tmp_path / "day1.parquet", COLUMNS)
    commands: list[tuple[Any, ...]] = [
        ("certify", day, copy, *roles, "--utility", "yes"),
        ("certify", day, held["symlink"], *roles, "--utility", "yes", "--same-content", "accept"),
        ("tally", day, held["zip"], *roles, "-o", tmp_path / "two.parquet"),
        ("certify", tmp_path / "day1.parquet", copy, *roles, "--utility", "yes", "--keep", tmp_path / "kept.parquet"),
        ("certify", day, copy, *roles, "--utility", "yes", "--keep", tmp_path / "kept.parquet"),
        ("inspect", day, copy),
    ]
    for words in commands:
        code, said = command(*words)
        assert code == 2 and "each row is counted once" in said and len(said.splitlines()) == 1, (words, said)
    assert not (tmp_path / "kept.parquet").exists() and not (tmp_path / "two.parquet").exists()
    code, said = command("certify", day, copy, *roles, "--utility", "yes", "--same-content", "accept")
    assert code == 0 and re.search(r"600\b", said) and "have the same content" in said


def test_logs_that_are_told_apart_by_their_file_may_have_the_same_content(tmp_path: Path) -> None:
    for name in "pq":
        (tmp_path / f"{name}.jsonl").write_text('{"a": {"v": "x"}}\n')
    paths = [tmp_path / "p.jsonl", tmp_path / "q.jsonl"]
    assert read_log(paths, ["a.v", "file"]).rows == 2
    with pytest.raises(fa.InputError, match="each row is counted once"):
        read_log(paths, ["a.v"])
    (tmp_path / "link.jsonl").symlink_to(paths[0])
    with pytest.raises(fa.InputError, match="are one file"):
        read_log([paths[0], tmp_path / "link.jsonl"], ["a.v", "file"])
