"""Statements made: what was counted, against sums by hand, and what an issuer says."""

from __future__ import annotations

import json
import sqlite3
from contextlib import closing
from datetime import UTC, datetime, timedelta
from fractions import Fraction
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

import fairaudit as fa
from fairaudit.attestations.making import counted_rows, rows_of_source, stated_of
from fairaudit.errors import InputError

ROLES = {"decision": "u", "group": "g"}

LABELS = st.tuples(st.sampled_from(["yes", "no"]), st.sampled_from(["f", "m", "", "n/a"]))

FIXED = [("yes", "f"), ("no", "f"), ("yes", "m"), ("no", "m")]


@given(st.lists(LABELS, max_size=6), st.data())
def test_counts_are_summed_whatever_becomes_of_missing_groups(drawn: list[tuple[str, str]], data: st.DataObject) -> None:
    missing = data.draw(st.sampled_from(["drop", "group", "unknown"]))
    whole = missing == "unknown"
    amounts = st.integers(1, 4).map(Fraction) if whole else st.fractions(0, 50, max_denominator=4)
    rows = [(u, g, Fraction(2)) for u, g in FIXED] + [(u, g, data.draw(amounts)) for u, g in drawn]
    table = {"u": [u for u, _, _ in rows], "g": [g for _, g, _ in rows], "n": [str(n) for _, _, n in rows]}
    labels = ["n/a"] if whole else []
    result = fa.audit(table, **ROLES, count="n", utility="yes", missing=missing, unknown=labels, confidence=None)  # type: ignore[arg-type]
    found = counted_rows(result)
    lost = sum((n for _, g, n in rows if not g), Fraction(0)) if missing == "drop" else Fraction(0)
    assert found.read == sum(n for _, _, n in rows)
    assert found.counted == found.read - lost
    assert found.dropped == ({"missing label": lost} if lost else {})
    assert found.add_up


@given(st.lists(LABELS, max_size=6))
def test_a_log_has_as_many_rows_as_decisions(drawn: list[tuple[str, str]]) -> None:
    rows = FIXED + drawn
    log = {"u": [u for u, _ in rows], "g": [g for _, g in rows]}
    result = fa.audit(log, **ROLES, utility="yes", missing="drop", confidence=None)
    found = counted_rows(result)
    assert (found.read, found.counted) == (len(rows), sum(bool(g) for _, g in rows))
    assert rows_of_source(result, found, {"decision": "u"}) == len(rows)


def test_parts_of_decisions_of_a_policy_are_refused() -> None:
    table = {"u": ["yes", "no", "yes", "no"], "g": ["f", "f", "m", "m"], "n": ["1/2", 1, 1, 1]}
    result = fa.audit(table, **ROLES, count="n", utility="yes", group_filter=fa.Identity(["f", "m"]), confidence=None)
    with pytest.raises(InputError, match="parts of decisions"):
        counted_rows(result)


def test_probabilities_that_nobody_read_are_refused() -> None:
    law = fa.Law.from_array([["1/2", "1/2"], ["1/4", "3/4"]], decisions=["yes", "no"], groups=["f", "m"])
    with pytest.raises(InputError, match="nobody counted the rows"):
        counted_rows(fa.certify(law, {"yes": 1}, confidence=None))


@pytest.mark.parametrize(
    ("given_", "said"),
    [
        ({"issuer": 3}, "issuer is 3"),
        ({"title": "\t"}, "title is"),
        ({"contact": "x"}, "contact goes with issuer"),
        ({"period": "/"}, "day ''"),
    ],
)
def test_what_cannot_be_stated_is_refused(given_: dict[str, object], said: str) -> None:
    with pytest.raises(InputError, match=said):
        stated_of(given_)


@pytest.mark.parametrize("source", ["sqlite:log.json", "sqlite:link.json", "l*.json"])
def test_a_result_writes_over_nothing_that_was_read(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, source: str) -> None:
    monkeypatch.chdir(tmp_path)
    rows = [("yes", "f"), ("no", "f"), ("yes", "m")]
    if source.startswith("sqlite:"):
        with closing(sqlite3.connect("log.json")) as connection, connection:
            connection.execute("create table log (hired, sex)")
            connection.executemany("insert into log values (?, ?)", rows)
        Path("link.json").symlink_to("log.json")
    else:
        Path("log.json").write_text("".join(json.dumps({"hired": hired, "sex": sex}) + "\n" for hired, sex in rows))
    before = Path("log.json").read_bytes()
    table = {"table": "log"} if source.startswith("sqlite:") else {}
    result = fa.audit(source, decision="hired", group="sex", utility="yes", **table)
    for write in (
        lambda: result.attest("c.json", "log.json"),
        lambda: result.attest("log.json", "a.json"),
        lambda: result.save("log.json"),
    ):
        with pytest.raises(InputError, match=r"log\.json is a file that was read"):
            write()
    for names in (("c.json", "key.pem"), ("c.html", "a.json")):
        with pytest.raises(InputError, match=r"does not end in \.json"):
            result.attest(*names)
    assert Path("log.json").read_bytes() == before and {path.name for path in tmp_path.iterdir()} <= {"log.json", "link.json"}
    result.attest("c.json", "a.json")


def _issued(folder: Path) -> str:
    (folder / "log.csv").write_text("u,g\nyes,f\nno,f\nyes,m\n", "utf-8")
    fa.audit(folder / "log.csv", **ROLES, utility="yes", confidence=None).attest(folder / "c.json", folder / "a.json")
    issued: str = json.loads((folder / "a.json").read_text("utf-8"))["predicate"]["issuedAt"]
    return issued


def test_the_moment_can_be_said_so_that_bytes_are_the_same(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("SOURCE_DATE_EPOCH", "1767225600")
    assert _issued(tmp_path) == "2026-01-01T00:00:00Z"
    before = (tmp_path / "a.json").read_bytes()
    _issued(tmp_path)
    assert (tmp_path / "a.json").read_bytes() == before
    monkeypatch.setenv("SOURCE_DATE_EPOCH", "")
    now = datetime.now(UTC)
    assert abs(datetime.fromisoformat(_issued(tmp_path)) - now) < timedelta(days=1)


@pytest.mark.parametrize("said", ["today", "-1", "1.5", "1_0", "9" * 12, "١"])
def test_a_moment_that_is_none_is_refused(said: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("SOURCE_DATE_EPOCH", said)
    with pytest.raises(InputError, match="whole seconds since 1970"):
        _issued(tmp_path)
    assert not (tmp_path / "c.json").exists()
