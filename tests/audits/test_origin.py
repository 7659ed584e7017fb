"""A result remembers what it was made of, and attests it later: the same statement as the command's, and nothing of what was changed."""

from __future__ import annotations

import hashlib
import json
import os
import pickle
import tempfile
from pathlib import Path
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

import fairaudit as fa
from fairaudit.attestations.statement import Statement, read_statement
from fairaudit.cli import main
from fairaudit.errors import InputError

LOG = "answer,sex\nyes,f\nno,f\nyes,f\nyes,m\nno,m\nno,\n"

ROLES: dict[str, Any] = {"decision": "answer", "group": "sex", "utility": "yes", "missing": "drop"}

AUDIT = """
[law]
table = "log.csv"
decision = "answer"
group = "sex"
missing = "drop"
[utility]
values = { yes = 1 }
"""


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    (tmp_path / "log.csv").write_text(LOG)
    (tmp_path / "audit.toml").write_text(AUDIT)
    monkeypatch.chdir(tmp_path)
    return tmp_path


def attested(result: fa.Result, **said: str) -> Statement:
    """Attest a result, and check the statement."""
    assert result.attest("c.json", "a.json", **said) == [Path("c.json"), Path("a.json")]
    assert fa.verify("c.json", attestation="a.json").ok
    return read_statement(Path("a.json").read_bytes())


def test_python_attests_what_the_command_attests(folder: Path) -> None:
    said = {"issuer": "Example Audits", "period": "2025-01-01/2025-12-31"}
    made = attested(fa.audit(folder / "log.csv", **ROLES), **said)
    words = ["--decision", "answer", "--group", "sex", "--utility", "yes", "--missing", "drop"]
    stated = [word for name, text in said.items() for word in (f"--{name}", text)]
    assert main(["certify", "log.csv", *words, *stated, "-o", "d.json", "--attest", "b.json"]) == 0
    theirs = read_statement(Path("b.json").read_bytes())
    for name in ("table", "sources", "rows", "options", "versions", "stated"):
        assert getattr(made, name) == getattr(theirs, name)
    assert made.sources[0].sha256 == hashlib.sha256(LOG.encode()).hexdigest()
    assert made.command == ("fairaudit.audit", "log.csv")
    assert main(["verify", "c.json", "--attestation", "a.json", "--recount", "log.csv"]) == 0


def test_an_audit_file_is_attested_with_what_it_names(folder: Path) -> None:
    with Path("audit.toml").open("a") as file:
        file.write('[attestation]\nissuer = "Example Audits"\ntitle = "From the file"\n')
    made = attested(fa.audit("audit.toml"), title="From the call")
    assert (made.stated.issuer, made.stated.title) == ("Example Audits", "From the call")
    assert [source.name for source in made.sources] == ["log.csv", "audit.toml"]
    assert made.options["audit"]["law"]["table"] == "log.csv"
    assert made.command == ("fairaudit.audit", "audit.toml")


def test_a_frame_has_no_digest_and_is_counted_again(folder: Path) -> None:
    frame = {"answer": ["yes", "no", "yes", "no"], "sex": ["f", "f", "m", "m"]}
    made = attested(fa.audit(frame, **ROLES))
    assert [(source.name, source.sha256, source.rows) for source in made.sources] == [("a table in memory", None, 4)]
    assert fa.recount("c.json", "a.json", frame).ok


ROWS = st.lists(
    st.tuples(st.sampled_from(["yes", "no"]), st.sampled_from(["f", "m", "", "n/a"]), st.sampled_from(["a", "b"]), st.integers(0, 9)),
    max_size=8,
)


@given(ROWS, st.data())
def test_the_checker_agrees_with_every_statement_and_the_table_can_be_made_again(rows: list[Any], data: st.DataObject) -> None:
    rows = [("yes", "f", "a", 1), ("no", "m", "a", 2), ("no", "f", "b", 3), ("yes", "m", "b", 4), *rows]
    table = {name: [row[i] for row in rows] for i, name in enumerate(("answer", "sex", "place", "n"))}
    table["true"] = ["yes" if i % 3 else "no" for i in range(len(rows))]
    missing = data.draw(st.sampled_from(["drop", "group", "unknown"]))
    form = data.draw(st.sampled_from(["log", "count", "parts", "unit", "truth"]))
    options: dict[str, Any] = {"missing": missing, "context": data.draw(st.sampled_from([(), ("place",)]))}
    if form == "unit":
        options |= {"unit": "n"}
    elif form == "truth":
        options |= {"truth": "true", "positive": "yes"}
    elif form != "log":
        options |= {"count": "n"}
    if form in ("unit", "truth") and missing == "unknown":
        options["missing"] = "drop"
    if form == "parts" and missing != "unknown":
        table["n"] = [f"{n}/3" for n in table["n"]]
    if options["missing"] == "unknown":
        options["unknown"] = ["n/a"]
    result = fa.audit(table, decision="answer", group="sex", utility={"yes": 1, "no": "1/3"}, confidence=None, **options)
    with tempfile.TemporaryDirectory() as made:
        written = result.attest(Path(made) / "c.json", Path(made) / "a.json")
        found = fa.verify(written[0], attestation=written[1])
        assert found.ok, found.false
        assert fa.recount(written[0], written[1], table).ok


def test_what_cannot_be_made_again_has_no_options(folder: Path) -> None:
    policy = fa.audit("log.csv", **ROLES, group_filter=fa.Identity(["f", "m"]))
    assert attested(policy).options == {}
    law = fa.Law.from_log({"answer": ["yes", "no", "yes"], "sex": ["f", "f", "m"]}, decision="answer", group="sex")
    made = attested(fa.certify(law, {"yes": 1}))
    assert (made.options, made.sources[0].sha256) == ({}, None)


def test_a_file_that_was_changed_since_is_refused(folder: Path) -> None:
    result = fa.audit("log.csv", **ROLES)
    before = Path("log.csv").stat()
    Path("log.csv").write_text(LOG.replace("yes,m", "no,m "))
    os.utime("log.csv", ns=(before.st_atime_ns, before.st_mtime_ns))
    with pytest.raises(InputError, match=r"log\.csv was changed while it was read"):
        result.attest("c.json", "a.json")
    assert not Path("c.json").exists()


@pytest.mark.parametrize(("path", "attestation"), [("c.json", "c.json"), ("log.csv", "a.json"), ("c.json", "log.csv"), ("c.json", ".")])
def test_neither_is_written_where_one_cannot_be(path: str, attestation: str, folder: Path) -> None:
    with pytest.raises(InputError):
        fa.audit("log.csv", **ROLES).attest(path, attestation)
    assert sorted(path.name for path in Path().iterdir()) == ["audit.toml", "log.csv"]
    assert Path("log.csv").read_text() == LOG


def test_a_password_is_not_kept(folder: Path, postgres: str) -> None:
    result = fa.audit(postgres, decision="answer", group="sex", utility="yes", table="logs.Decisions", confidence=None)
    assert not any(secret in pickle.dumps(result) for secret in (b"secret", b"auditor", b"127.0.0.1"))
    [source] = attested(result).sources
    assert (source.name, source.table, source.sha256) == ("postgresql:postgres", "logs.Decisions", None)


def test_a_result_that_was_pickled_is_attested(folder: Path) -> None:
    attested(pickle.loads(pickle.dumps(fa.audit("log.csv", **ROLES))))  # noqa: S301


def test_what_is_missing_is_told_by_the_reader(folder: Path) -> None:
    with pytest.raises(InputError, match=r"none\.csv: there is no such file"):
        fa.audit("none.csv", **ROLES)
    assert json.loads(fa.audit("log.csv", **ROLES).certificate.text)["verdict"] == "none"


def test_a_name_that_is_too_long_is_told_by_the_reader(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    name = "x" * 5_000 + ".csv"
    with pytest.raises(InputError, match="the file cannot be read: File name too long"):
        fa.audit(name, **ROLES)
    words = ["--decision", ROLES["decision"], "--group", ROLES["group"], "--utility", ROLES["utility"]]
    for more in ([], ["-o", "c.json", "--attest", "a.json"]):
        assert main(["certify", name, *words, *more]) == 2
        assert "the file cannot be read: File name too long" in capsys.readouterr().err
