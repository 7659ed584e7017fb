"""New York's tables with small counts withheld: the rule's example, classes, the unknown; attacked from the CSV."""

from __future__ import annotations

import csv
import io
import json
import random
from itertools import product
from pathlib import Path
from typing import Any

import pytest
import tiers
from attacker import agreeing, inside

import fairaudit as fa
from fairaudit.cli import main
from fairaudit.publications.counts import Decisions
from fairaudit.publications.ll144.categories import RACES, SEXES
from fairaudit.publications.ll144.page import Part, publish
from fairaudit.publications.ll144.people import read_labels
from fairaudit.publications.ll144.stated import Stated
from fairaudit.publications.ll144.tables import People, Unknown, shown_of, three_tables
from fairaudit.publications.publication import Publication

TABLES = 25

# 6 RCNY 5-301, the selection example: applicants and selected of the intersections, in the rule's order of categories
MALE = ((205, 90), (412, 215), (226, 95), (87, 37), (321, 167), (24, 11), (115, 52))
FEMALE = ((190, 82), (385, 197), (164, 75), (32, 15), (295, 135), (17, 7), (98, 44))


def people_of_rule() -> dict[Any, tuple[int, int]]:
    return {(sex, race): (s, n) for sex, row in zip(SEXES, (MALE, FEMALE), strict=True) for race, (n, s) in zip(RACES, row, strict=True)}


def publication(classes: dict[str | None, tuple[People, Unknown]], least: int, *, every: bool = False) -> Publication:
    decisions = Decisions(("sex", "race"), tuple(product(SEXES, RACES)), ("yes", "no"), ((0, 0),) * 14, (0, 0))
    reading = read_labels({"subject": {}}, decisions, sex="sex", race="race")
    shown = shown_of([*classes.values()], least, sex=True, race=True, every=every)
    parts = [Part((label or "yes",), three_tables(people, apart, shown=shown), label) for label, (people, apart) in classes.items()]
    return publish(Stated(), decisions, reading, parts, least=least)


def rows_of(found: Publication, label: str = "") -> dict[tuple[str, str], tuple[int, int] | None]:
    read: dict[tuple[str, str], tuple[int, int] | None] = {}
    for row in (dict(zip(found.header, row, strict=True)) for row in found.rows):
        if row.get("class", "") != label or (row["sex"], row["race_ethnicity"]) == ("", ""):
            continue
        place = row["sex"], row["race_ethnicity"]
        read[place] = None if row["status"] == "withheld" else (int(row["selected"]), int(row["applicants"]))
    return read


def possible(rows: dict[tuple[str, str], int | None], place: tuple[str, str], value: int) -> bool:
    """Whether counts of the fourteen intersections agree with every count that is shown, and have this one there."""
    cells = [*product(SEXES, RACES)]
    known = [(inside(at, cells), count) for at, count in rows.items() if count is not None]
    return agreeing(cells, [*known, (inside(place, cells), value)]) is not None


def test_the_example_of_the_rule_keeps_its_margins() -> None:
    """Seven Native American women were selected: with another of their row and column four intersections are withheld."""
    found = publication({None: (people_of_rule(), Unknown(100, 150))}, 10)
    rows = rows_of(found)
    native = "Native American or Alaska Native"
    assert {place for place, row in rows.items() if row is None} == {*product(SEXES, (native, "Two or More Races"))}
    assert rows["Male", ""] == (667, 1390) and rows["Female", ""] == (555, 1181) and rows["", native] == (18, 41)
    by_name = {row[0]: row for table in found.page.sections[0].tables for row in table.rows}
    assert by_name["Female"] == ("Female", "1,181", "555", "47.0 %", "0.979")
    assert by_name["Male, White"][3:] == ("52.2 %", "1.000")
    assert by_name[f"Female, {native}"][1:] == ("withheld",) * 4
    assert by_name["Unknown, not in the table"][1:3] == ("250", "100")
    assert any("4 of 14 groups are withheld" in note for table in found.page.sections[0].tables for note in table.notes)


def test_every_small_count_is_open_with_classes_too() -> None:
    rng = random.Random(tiers.fresh(0))
    attacked = 0
    for _ in range(TABLES):
        least = rng.choice((5, 10))
        counted = {cell: [rng.randint(0, rng.choice((4, 40, 200))) for _ in range(3)] for cell in product(SEXES, RACES)}
        names = ["a", "b", "c"][: rng.choice((2, 3))]
        classes: dict[str | None, tuple[People, Unknown]] = {
            name: ({cell: (kinds[i], sum(kinds)) for cell, kinds in counted.items()}, Unknown()) for i, name in enumerate(names)
        }
        found = publication(classes, least, every=len(names) == 3)
        for i, name in enumerate(names):
            read = rows_of(found, name)
            shown = {at: None if row is None else row[0] for at, row in read.items()}
            for place in read:
                true = sum(counted[cell][i] for cell in inside(place, counted))
                assert shown[place] is None or shown[place] == true >= least
                if true < least and rng.random() < 0.3:
                    attacked += 1
                    assert all(possible(shown, place, value) for value in (0, least - 1))
    assert tiers.enough(attacked > 100)


@pytest.mark.parametrize(
    ("unknown", "least", "shown"),
    [
        (Unknown(100, 150), 10, ("250", "100")),
        (Unknown(9, 150), 10, ("", "")),
        (Unknown(100, 150, 3), 10, ("", "")),
        (Unknown(), 10, ("", "")),
    ],
)
def test_the_unknown_are_shown_or_withheld(unknown: Unknown, least: int, shown: tuple[str, str]) -> None:
    found = publication({None: (people_of_rule(), unknown)}, least)
    rows = [dict(zip(found.header, row, strict=True)) for row in found.rows]
    assert {(row["applicants"], row["selected"]) for row in rows if not row["sex"] and not row["race_ethnicity"]} == {shown}


def test_the_command_withholds(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    listed = [(sex, race, out, k) for (sex, race), (s, n) in people_of_rule().items() for out, k in (("yes", s), ("no", n - s))]
    columns = dict(zip(("sex", "race", "out", "n"), map(list, zip(*listed, strict=True)), strict=True))
    chosen: dict[str, Any] = {"confidence": None, "embed_table": False, "utility": "yes"}
    fa.audit(columns, decision="out", group=["sex", "race"], count="n", **chosen).save(tmp_path / "c.json")
    given = [
        "publish",
        str(tmp_path / "c.json"),
        "--table",
        str(tmp_path / "c.table.jsonl"),
        "--rule",
        "ll144",
        "--sex",
        "sex",
        "--race",
        "race",
    ]
    out = tmp_path / "out"
    for refused, said in (
        (["--unknown-in", "available"], "complete"),
        (["--exclude-below-2-percent", "--justification", "few"], "shares of all people"),
    ):
        assert main([*given, "--small", "10", "-o", str(out), *refused]) == 2
        assert said in capsys.readouterr().err and not out.exists()
    assert main([*given, "--small", "10", "-o", str(out), "--tool", "Sorter"]) == 0
    assert sorted(path.name for path in out.iterdir()) == ["index.html", "summary.json", "table.csv"]
    rows = list(csv.DictReader(io.StringIO((out / "table.csv").read_text("utf-8"))))
    assert len([row for row in rows if row["status"] == "withheld"]) == 4 + 3  # four intersections, nobody unknown in three tables
    assert not any(row["share_exact"] for row in rows)
    page = (out / "index.html").read_text("utf-8")
    assert "Results of a bias audit: Sorter" in page and "2571" not in page and "cannot recompute" in page
    summary = json.loads((out / "summary.json").read_text("ascii"))
    assert summary["small"] == 10
    tables = summary["parts"][0]["tables"]
    entries = [entry for table in tables for entry in table["categories"]]
    assert [entry["status"] for entry in entries].count("withheld") == 4 and not any("share" in entry for entry in entries)
    assert [{*table} for table in tables] == [{"table", "unknown", "categories"}] * 3 and not any(table["unknown"] for table in tables)
    assert entries[1]["rate"] == "555/1181" and summary["stated"]["tool"] == "Sorter" and summary["unknown_in"] == "complete"
    capsys.readouterr()
    assert main([*given, "--with-table", "-o", str(tmp_path / "all")]) == 0
    assert "--small 10 withholds" in capsys.readouterr().err
