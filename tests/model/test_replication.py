"""The test for units that are copies of each other: how often it is wrong, what it finds, and that every face gives one sentence."""

from __future__ import annotations

import random
from collections import Counter
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import tiers
from independent_logs import SHAPES, Rows, persons, runs, winners

import fairaudit as fa
from fairaudit.cli import main
from fairaudit.model import replication
from fairaudit.tables.csv import read_csv
from fairaudit.tables.tally import Tally

NAMES = ("unit", "x", "a", "u")


def law(rows: Rows, order: random.Random | None = None) -> fa.Law:
    listed = list(rows)
    if order:
        order.shuffle(listed)
    table = {name: [str(row[i]) for row in listed] for i, name in enumerate(NAMES)}
    return fa.Law.from_log(table, decision="u", group="a", context="x", unit="unit")


def noticed(rows: Rows) -> list[str]:
    return [note for note in law(rows).notes if "pseudo-replication" in note]


def copied(rows: Rows, times: int) -> Rows:
    """Each unit as often as that."""
    return [(unit * times + copy, x, a, u) for copy in range(times) for unit, x, a, u in rows]


@pytest.mark.parametrize("shape", SHAPES)
def test_independent_units_are_left_alone(shape: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """On the command line, where people meet it; the rate over many logs is measured in tests/validity."""
    path = tmp_path / "log.csv"
    for seed in range(6):
        rows = SHAPES[shape](np.random.default_rng(100 + seed))
        path.write_text("unit,x,a,u\n" + "".join(f"{unit},{x},{a},{'yes' if u else 'no'}{u}\n" for unit, x, a, u in rows))
        options = ["--decision", "u", "--group", "a", "--context", "x", "--unit", "unit", "--utility", "yes1=1,no0=0"]
        assert main(["certify", str(path), *options]) == 0
        assert "pseudo-replication" not in capsys.readouterr().err


MADE: dict[str, Callable[[np.random.Generator], Rows]] = {
    "each of five runs three times": lambda pick: copied(runs(pick, count=5), 3),
    "each of forty persons twice": lambda pick: copied(persons(pick, 40, 10), 2),
    "each of twenty rankings twice": lambda pick: copied(winners(pick, count=20, contexts=5), 2),
    "each of ten runs that ask twice, thrice": lambda pick: copied(runs(pick, count=10, times=2), 3),
}


@pytest.mark.parametrize("case", MADE)
def test_copies_are_found(case: str) -> None:
    found = [noticed(MADE[case](np.random.default_rng(seed))) for seed in range(5)]
    assert sum(len(notes) == 1 for notes in found) >= 4
    assert all(len(notes) <= 1 for notes in found)


def test_the_order_of_the_rows_does_not_matter() -> None:
    """Nor whether equal rows were counted by an engine: a counted log has no order."""
    rows = MADE["each of five runs three times"](np.random.default_rng(1))
    (note,) = noticed(rows)
    for seed in range(3):
        assert note in law(rows, random.Random(tiers.fresh(seed))).notes
    counted = Tally.of("log", NAMES, [(*map(str, row), n) for row, n in Counter(rows).items()])
    assert note in fa.Law.from_log(counted, decision="u", group="a", context="x", unit="unit").notes
    assert "15 pairs of units of 'unit', such as " in note and "a false alarm in at most 1 of 1,000 logs" in note


def test_answers_in_another_order_are_the_same_answers() -> None:
    """Two rows of a unit with one question have no order: yes and no is no and yes."""
    pick = np.random.default_rng(2)
    once = runs(pick, count=12, contexts=8, times=2)
    again = [(unit + 12, x, a, u) for unit, x, a, u in reversed(once)]
    (note,) = noticed(once + again)
    assert note.startswith("pseudo-replication: 12 pairs of units of 'unit', such as ")


def test_nothing_is_said_of_what_cannot_be_seen() -> None:
    """Without units there is nothing to compare; where all units agree on everything, every arrangement is the observed one."""
    rows = MADE["each of five runs three times"](np.random.default_rng(1))
    table = {name: [str(row[i]) for row in rows] for i, name in enumerate(NAMES)}
    assert not fa.Law.from_log(table, decision="u", group="a", context="x").notes
    assert noticed(copied(runs(np.random.default_rng(1), count=1, times=9), 10)) == []
    alike = [(unit, x, a, (x + a) % 2) for unit in range(9) for x in range(8) for a in range(2)]
    assert noticed(alike) == []
    assert noticed([(unit, 0, unit % 2, unit % 3) for unit in range(30)]) == []  # one question each


def test_long_logs_are_judged_by_some_of_their_units(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(replication, "ROWS", 400)
    rows = runs(np.random.default_rng(3), count=60)
    assert len(rows) > 2 * replication.ROWS
    assert noticed(rows) == []
    copies = [(unit, *rest) for unit in range(60) for _, *rest in runs(np.random.default_rng(unit // 30), count=1)]
    assert len(noticed(copies)) == 1  # type: ignore[arg-type]
    assert noticed(runs(np.random.default_rng(3), count=3, times=100)) == []  # units of too many rows


@pytest.mark.parametrize(("name", "group"), [("hiringbias_firstname.csv", "name"), ("hiringbias_placebo.csv", "placebo")])
def test_a_real_log_gets_at_most_one_sentence(name: str, group: str, data: Path) -> None:
    table = read_csv(data / name)
    for unit, context in ((["run"], ["model", "jd"]), (["jd", "run"], ["model"]), (["model", "jd", "run"], []), (["model"], ["jd"])):
        found = fa.Law.from_log(table, decision="recommend_interview", group=group, context=context, unit=unit)
        assert sum("pseudo-replication" in note for note in found.notes) <= 1
    assert not any("pseudo-replication" in note for note in found.notes)


def test_the_winners_of_real_rankings_are_no_copies(data: Path) -> None:
    """One winner for each run and eight groups: many runs have the same winner, as they must."""
    table = read_csv(data / "bloomberg_gpt_rankings.csv")
    shown = [table["ranked_order"][i].split("|")[0] if "|" in table["ranked_order"][i] else table["ranked_order"][i] for i in range(600)]
    groups = sorted({*shown})[:8]
    rows: dict[str, list[Any]] = {"run": [], "a": [], "u": []}
    for i, first in enumerate(shown):
        for group in groups:
            rows["run"].append(i)
            rows["a"].append(group)
            rows["u"].append("first" if first == group else "not")
    assert not any("pseudo" in note for note in fa.Law.from_log(rows, decision="u", group="a", unit="run").notes)
