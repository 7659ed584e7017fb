"""Who is counted where by a certificate, and who is unknown: labels of their own, decisions counted apart, and what was left out."""

from __future__ import annotations

import json
import random
from fractions import Fraction
from pathlib import Path
from typing import Any

import pytest
import tiers

import fairaudit as fa
from fairaudit.cli import main
from fairaudit.errors import InputError
from fairaudit.publications.ll144.people import left_out

LOG: dict[str, Any] = {
    "sex": ["Male", "Male", "Female", "Female", None, "Male", None, "declined", "Male"],
    "race": ["White", "Asian", "White", "White", "White", None, None, "Asian", "White"],
    "got": ["yes", "no", "yes", "no", "yes", "no", "yes", "yes", "no"],
}


def published(tmp_path: Path, capsys: pytest.CaptureFixture[str], *more: str, **how: Any) -> Any:
    """The tables by name; of a refusal the sentence."""
    fa.audit(LOG, decision="got", group=["sex", "race"], utility="yes", confidence=None, **how).save(tmp_path / "c.json")
    to = tmp_path / "out"
    columns = () if "--race" in more or "--sex" in more else ("--sex", "sex", "--race", "race")
    if main(["publish", str(tmp_path / "c.json"), "--rule", "ll144", *columns, *more, "-o", str(to)]):
        assert not to.exists()
        return capsys.readouterr().err
    return {table["table"]: table for table in json.loads((to / "summary.json").read_text())["parts"][0]["tables"]}


def counted(table: Any) -> tuple[int, int, int | None]:
    return table["applicants"], table["unknown"]["people"], table["unknown"]["selected"]


def test_a_level_of_its_own_says_which_category_is_unknown(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    complete = published(tmp_path, capsys, "--unknown", "declined", missing="group")
    assert {name: counted(table) for name, table in complete.items()} == dict.fromkeys(("sex", "race", "intersection"), (5, 4, 3))


def test_available_uses_everybody_whose_category_is_known(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    found = published(tmp_path, capsys, "--unknown", "declined", "--unknown-in", "available", missing="group")
    assert {name: counted(table) for name, table in found.items()} == {"sex": (6, 3, 3), "race": (7, 2, 1), "intersection": (5, 4, 3)}


def test_decisions_counted_apart_are_unknown_in_all_tables(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    found = published(tmp_path, capsys, missing="unknown", unknown=["declined"])
    assert {name: counted(table) for name, table in found.items()} == dict.fromkeys(("sex", "race", "intersection"), (5, 4, 3))


def test_decisions_counted_apart_do_not_say_which_category(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    said = published(tmp_path, capsys, "--unknown-in", "available", missing="unknown", unknown=["declined"])
    assert "of 4 people is unknown" in said
    assert "certify again with --missing group" in said


def test_of_people_left_out_not_even_the_decision_is_known(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    found = published(tmp_path, capsys, "--unknown", "declined", missing="drop")
    assert {name: counted(table) for name, table in found.items()} == dict.fromkeys(("sex", "race", "intersection"), (5, 4, None))
    # of the unknown one was selected, and of three more nobody knows: male 1 of 3, female 1 of 2
    tried = [
        min(Fraction(s, n + a) / Fraction(t + 1 + 3 - a, m + 1 + 3 - a) for a in range(4))
        for (s, n), (t, m) in (((1, 3), (1, 2)), ((1, 2), (1, 3)))
    ]
    assert Fraction(found["sex"]["worst_case"]) == min(tried)
    rows = (tmp_path / "out" / "table.csv").read_text().splitlines()
    assert [row for row in rows if row.endswith("unknown")] == [f"{name},,,4,,,,,,,unknown" for name in found]


def test_people_left_out_cannot_be_told_apart(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    said = published(tmp_path, capsys, "--unknown", "declined", "--unknown-in", "available", missing="drop")
    assert "certify again with --missing group" in said


def test_people_without_a_decision_are_said(tmp_path: Path) -> None:
    log = {**LOG, "got": [*LOG["got"][:-1], None]}
    fa.audit(log, decision="got", group=["sex", "race"], utility="yes", missing="group", confidence=None).save(tmp_path / "c.json")
    more = ("--sex", "sex", "--race", "race", "--unknown", "declined", "-o", str(tmp_path / "out"))
    assert main(["publish", str(tmp_path / "c.json"), "--rule", "ll144", *more]) == 0
    assert "Of 1 person no decision is recorded" in (tmp_path / "out" / "index.html").read_text("utf-8")


def test_one_attribute_alone_has_its_own_table(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    found = published(tmp_path, capsys, "--race", "race", missing="group")
    assert {name: counted(table) for name, table in found.items()} == {"race": (7, 2, 1)}
    assert "The rule asks for three tables" in (tmp_path / "out" / "index.html").read_text("utf-8")


@pytest.mark.parametrize(
    ("more", "said"),
    [
        ((), "needs --sex COL and --race COL"),
        (("--sex", "race", "--race", "race"), "both name 'race'"),
        (("--sex", "got"), "no group column 'got'"),
        (("--sex", "sex", "--race", "race"), "the label 'declined' in column 'sex' is no category"),
    ],
)
def test_columns_and_labels_that_do_not_fit_are_refused(
    more: tuple[str, ...], said: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    fa.audit(LOG, decision="got", group=["sex", "race"], utility="yes", missing="group", confidence=None).save(tmp_path / "c.json")
    assert main(["publish", str(tmp_path / "c.json"), "--rule", "ll144", *more, "-o", str(tmp_path / "out")]) == 2
    assert said in capsys.readouterr().err
    assert not (tmp_path / "out").exists()


def entry(columns: dict[str, str], amount: str = "5", **more: str) -> dict[str, Any]:
    return {"step": "left out", "reason": "missing label", "decisions": amount, "of": "9", "columns": columns, **more}


def test_what_was_left_out_for_another_reason_is_said() -> None:
    lines = {"step": "left out", "reason": "unreadable", "lines": "7"}
    people, notes = left_out([entry({"sex": "2", "race": "4"}), entry({"got": "5"}), lines], ["sex", "race"])
    assert people == 5
    assert [note.partition(" ")[0] for note in notes] == ["5", "7"]


@pytest.mark.parametrize(
    ("columns", "amount", "people", "noted"),
    [
        ({"sex": "2", "got": "4"}, "5", 2, ["3"]),
        ({"sex": "2", "race": "1", "got": "4"}, "7", 3, ["4"]),
        ({"got": "3", "team": "3"}, "4", 0, ["4"]),
        ({"sex": "2", "race": "1", "got": "1"}, "3", None, []),
        ({"sex": "5/2"}, "5/2", None, []),
    ],
)
def test_people_left_out_are_counted_where_the_columns_say_how_many(
    columns: dict[str, str], amount: str, people: int | None, noted: list[str]
) -> None:
    if people is None:
        with pytest.raises(InputError, match="left out"):
            left_out([entry(columns, amount)], ["sex", "race"])
    else:
        found, notes = left_out([entry(columns, amount)], ["sex", "race"])
        assert (found, [note.partition(" ")[0] for note in notes]) == (people, noted)


def test_how_many_lack_a_category_is_right_whenever_it_is_said() -> None:
    draw, said = random.Random(tiers.fresh(9)), 0
    for _ in range(300):
        rows = [[draw.random() < 0.2 for _ in range(3)] for _ in range(draw.randint(1, 12))]
        gone = [row for row in rows if any(row)]
        columns = {name: str(n) for i, name in enumerate(("sex", "race", "got")) if (n := sum(row[i] for row in gone))}
        if not gone:
            continue
        try:
            found, _ = left_out([entry(columns, str(len(gone)))], ["sex", "race"])
        except InputError:
            continue
        said += 1
        assert found == sum(row[0] or row[1] for row in gone)
    assert tiers.enough(said > 100)
