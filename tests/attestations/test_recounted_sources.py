"""Sources beside the files that are given for a recount: no other file, length, number of rows or audit file passes as the attested one."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from envelopes import envelope

from fairaudit.cli import main

LOG = "hired,sex,dept,race\n" + "".join(
    f"{'yes' if place % 3 else 'no'},{'fm'[place % 2]},d{place % 5},{'ab'[place % 7 > 2]}\n" for place in range(40)
)
ROLES = ["--decision", "hired", "--group", "sex", "--utility", "yes", "--confidence", "none"]
AUDIT = '[law]\ntable = "log.csv"\ndecision = "hired"\ngroup = "sex"\n[utility]\nvalues = { yes = 1 }\n'
MORE = '[targets]\nmax_local_log = "2"\n[confidence]\nlevel = "0.9"\n[attestation]\nissuer = "A. Auditor"\n'

Found = tuple[int, dict[str, tuple[bool | None, str]]]


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "log.csv").write_text(LOG)
    return tmp_path


@pytest.fixture
def check(capsys: pytest.CaptureFixture[str]) -> Callable[..., Found]:
    """Verify with a recount, and give the exit code and what was found of each thing."""

    def run(*words: str) -> Found:
        capsys.readouterr()
        code = main(["verify", "c.json", "--attestation", "a.json", "--format", "json", "--recount", *words])
        said = capsys.readouterr()
        if code == 2:
            return code, {"error": (None, said.err)}
        result = envelope(said.out)["result"]
        return code, {entry["what"]: (entry["equal"], entry["detail"]) for entry in result["recount"]["findings"]}

    return run


def attest(*words: str) -> dict[str, Any]:
    assert main(["certify", *words, "-o", "c.json", "--attest", "a.json"]) in (0, 1, 3)
    return json.loads(Path("a.json").read_text())


def rewrite(statement: dict[str, Any]) -> None:
    Path("a.json").write_text(json.dumps(statement))


def test_an_audit_file_that_was_given_is_compared_with_what_the_attestation_has_of_it(folder: Path, check: Callable[..., Found]) -> None:
    (folder / "audit.toml").write_text(AUDIT + MORE)
    honest = attest("audit.toml")
    assert honest["predicate"]["options"] == {
        "audit": {"law": {"table": "log.csv", "decision": "hired", "group": "sex"}, "utility": {"values": {"yes": 1}}}
    }
    for files in (["audit.toml"], ["audit.toml", "log.csv"]):
        code, found = check(*files)
        assert (code, found["what 'audit.toml' says of the table"]) == (0, (True, ""))
    code, found = check("log.csv")
    assert (code, found["the source 'audit.toml'"][0]) == (0, None)
    # the certificate of one audit file, with another one's digest: the table is the one of options, the file is the one of the digest
    other = AUDIT.replace('"sex"', '"race"')
    (folder / "audit.toml").write_text(other)
    others = attest("audit.toml")
    (folder / "audit.toml").write_text(AUDIT + MORE)
    attest("audit.toml")
    honest["predicate"]["sources"][1] = others["predicate"]["sources"][1]
    assert honest["predicate"]["sources"][1]["name"] == "audit.toml"
    rewrite(honest)
    (folder / "audit.toml").write_text(other)
    code, found = check("audit.toml", "log.csv")
    assert (code, found["the source 'audit.toml'"][0], found["the table"][0]) == (1, True, True)
    assert found["what 'audit.toml' says of the table"] == (False, "the attestation has another section [law] than the file")


@pytest.mark.parametrize(
    ("section", "key"), [("targets", "max_local_log"), ("confidence", "level"), ("law", "hidden_context"), ("utility", "gamma")]
)
def test_what_makes_no_table_has_no_place_in_the_sections_of_an_audit_file(
    folder: Path, check: Callable[..., Found], section: str, key: str
) -> None:
    (folder / "audit.toml").write_text(AUDIT)
    statement = attest("audit.toml")
    statement["predicate"]["options"]["audit"].setdefault(section, {})[key] = "2"
    rewrite(statement)
    code, found = check("log.csv")
    assert code == 2
    assert f"{section!r} of an audit file, which does not make a table" in found["error"][1]


def test_an_audit_file_that_cannot_be_read_is_another_one(folder: Path, check: Callable[..., Found]) -> None:
    (folder / "audit.toml").write_text(AUDIT)
    attest("audit.toml")
    (folder / "audit.toml").write_text("[law\n")
    code, found = check("audit.toml", "log.csv")
    assert (code, found["what 'audit.toml' says of the table"][0]) == (1, False)


def test_of_a_source_that_no_section_names_nothing_was_read(folder: Path, check: Callable[..., Found]) -> None:
    (folder / "audit.toml").write_text(AUDIT)
    (folder / "more.csv").write_text(LOG)
    statement = attest("audit.toml")
    sources = statement["predicate"]["sources"]
    sources.append(sources[0] | {"name": "more.csv"})
    rewrite(statement)
    code, found = check("log.csv", "more.csv")
    assert (code, found["the source 'more.csv'"]) == (0, (None, "no section of the audit file names it, and nothing was read from it"))
    (folder / "more.csv").write_text(LOG + LOG)
    assert check("log.csv", "more.csv")[1]["the source 'more.csv'"][0] is False


def test_a_file_has_the_length_that_is_said(folder: Path, check: Callable[..., Found]) -> None:
    statement = attest("log.csv", *ROLES)
    statement["predicate"]["sources"][0]["bytes"] = 1
    rewrite(statement)
    code, found = check("log.csv")
    assert (code, found["the source 'log.csv'"][0]) == (1, False)
    assert f"has {len(LOG)} bytes" in found["the source 'log.csv'"][1]


def test_files_of_one_name_are_told_apart_by_their_digests(folder: Path, check: Callable[..., Found]) -> None:
    for name, text in (("one", LOG), ("two", LOG.replace("d1", "d9"))):
        (folder / name).mkdir()
        (folder / name / "log.csv").write_text(text)
    attest("one/log.csv", "two/log.csv", *ROLES)
    assert check("one/log.csv", "two/log.csv")[0] == 0
    assert check("two/log.csv", "one/log.csv")[0] == 0
    (folder / "two" / "log.csv").rename(folder / "renamed.csv")
    assert check("renamed.csv", "one/log.csv")[0] == 0
    (folder / "renamed.csv").write_text(LOG)
    assert check("renamed.csv", "one/log.csv")[0] == 1


def test_no_verdict_is_given_where_anything_is_false(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    attest("log.csv", *ROLES, "--max-local-ratio", "4")
    for name in ("one", "two"):
        assert main(["attest", "--new-key", f"{name}.pem"]) == 0
    assert main(["attest", "a.json", "--sign-key", "one.pem", "-o", "signed.json"]) == 0
    words = ["verify", "c.json", "--attestation", "signed.json", "--format", "json"]

    def verdict(code: int, *more: str) -> tuple[bool, str, str]:
        capsys.readouterr()
        assert main([*words, *more]) == code
        answer = envelope(capsys.readouterr().out)
        return answer["result"]["true"], answer["verdict"], answer["result"]["stated_verdict"]

    right, wrong = ("--key", "one.pub.pem"), ("--key", "two.pub.pem")
    assert verdict(0, *right) == verdict(0, *right, "--recount", "log.csv") == (True, "within", "within")
    assert verdict(3) == verdict(3, *right, "--recount", "away.csv") == (True, "within", "within")
    assert verdict(1, *wrong) == (False, "none", "within")
    (folder / "log.csv").write_text(LOG.replace("no", "yes", 1))
    assert verdict(1, *right, "--recount", "log.csv") == (False, "none", "within")


@pytest.mark.parametrize(
    ("rows", "equal"), [((10, None), None), ((39, 2), False), ((41, None), False), ((30, 9), False), ((30, 10), None), ((None, None), True)]
)
def test_rows_of_several_sources_are_no_more_than_were_read(
    folder: Path, check: Callable[..., Found], rows: tuple[int | None, int | None], equal: bool | None
) -> None:
    head, *lines = LOG.splitlines(keepends=True)
    for name, held in (("one.csv", lines[:10]), ("two.csv", lines[10:])):
        (folder / name).write_text(head + "".join(held))
    statement = attest("one.csv", "two.csv", *ROLES)
    for source, count in zip(statement["predicate"]["sources"], rows, strict=True):
        assert source["rows"] is None
        source["rows"] = count
    rewrite(statement)
    code, found = check("one.csv", "two.csv")
    own = {what: result for what, (result, _) in found.items() if " rows of " in what or "the rows" in what}
    assert code == (1 if equal is False else 0)
    if equal is None:
        assert own == {f"the {count} rows of '{name}'": None for name, count in zip(("one.csv", "two.csv"), rows, strict=True) if count}
    else:
        assert own == ({} if equal else {"the rows of the sources": False})


def test_rows_of_an_audit_file_are_not_counted(folder: Path, check: Callable[..., Found]) -> None:
    (folder / "audit.toml").write_text(AUDIT)
    statement = attest("audit.toml")
    assert [source["rows"] for source in statement["predicate"]["sources"]] == [40, None]
    statement["predicate"]["sources"][1]["rows"] = 7
    rewrite(statement)
    code, found = check("audit.toml")
    assert (code, found["the 7 rows of 'audit.toml'"][0]) == (0, None)
    statement["predicate"]["sources"][0]["rows"] = 41
    rewrite(statement)
    assert check("audit.toml")[0] == 1


def test_a_file_is_not_what_a_database_gave(folder: Path, check: Callable[..., Found]) -> None:
    import pandas as pd

    with (folder / "log.csv").open() as file:
        pd.read_csv(file).to_excel(folder / "log.xlsx", sheet_name="first", index=False)
    statement = attest("log.xlsx", *ROLES, "--table", "first")
    assert check("log.xlsx")[0] == 0
    statement["predicate"]["sources"][0] |= {"sha256": None, "bytes": None, "table": "first"}
    rewrite(statement)
    code, found = check("log.xlsx")
    assert (code, found["the source 'log.xlsx'"]) == (1, (False, "it is said to be of a database, and 'log.xlsx' is a file"))
