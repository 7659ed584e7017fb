"""Adverse impact ratios beside a named control group."""

from __future__ import annotations

import csv
import re
import shlex
from fractions import Fraction
from pathlib import Path
from random import Random
from typing import Any

import pytest
import tiers

from fairaudit.cli import main
from fairaudit.errors import InputError
from fairaudit.publications.adverse_impact import adverse_impact
from fairaudit.publications.counts import Decisions

GUIDE = Path(__file__).resolve().parents[2] / "docs" / "publish-credit.md"


def decisions(counts: dict[tuple[str, ...], tuple[int, int]], columns: tuple[str, ...] = ("race",)) -> Decisions:
    """Approved and applicants of each group."""
    return Decisions(columns, tuple(counts), ("approved", "denied"), tuple((s, n - s) for s, n in counts.values()), (0, 0))


def test_the_ratio_may_exceed_one() -> None:
    made = decisions({("white",): (60, 100), ("black",): (45, 90), ("asian",): (33, 50)})
    found = adverse_impact(made, ["approved"], ["white"])
    entries = {entry["group"]["race"]: entry for entry in found.summary["tables"][0]["groups"]}
    assert [entries[g]["ratio"] for g in ("white", "black", "asian")] == ["1", "5/6", "11/10"]
    assert [entries[g]["status"] for g in ("white", "black", "asian")] == ["reference", "compared", "compared"]
    assert entries["asian"]["findings"]["shortfall"] == str(Fraction(50 * 93, 150) - 33)
    assert found.summary["control"] == {"race": "white"}
    assert "1.100" in {cell for row in found.page.sections[0].tables[0].rows for cell in row}
    said = " ".join(text for section in found.page.sections for text in section.paragraphs)
    assert "standardized mean difference" in said and "No lending regulator" in said


def test_random_tables_are_as_plain_fractions_have_them() -> None:
    rng = Random(tiers.fresh("air"))
    for _ in range(60):
        counts = {(g,): (rng.randint(0, n), n) for g in "abc" if (n := rng.randint(1, 40))}
        found = adverse_impact(decisions(counts), ["approved"], ["b"])
        h, m = counts[("b",)]
        for entry in found.summary["tables"][0]["groups"]:
            s, n = counts[(entry["group"]["race"],)]
            expected = Fraction(s * m, n * h) if h else None if s else Fraction(1)
            assert entry["ratio"] == (None if expected is None else str(expected))


COUNTS = {("f", "a"): (1, 9), ("f", "b"): (4, 9), ("m", "a"): (5, 9), ("m", "b"): (6, 9), ("x", "b"): (1, 2)}


def table(found: Any) -> list[Any]:
    return [each["compared_with"] for each in found.summary["tables"]]


def test_the_control_group_has_one_label_of_each_column() -> None:
    made = decisions(COUNTS, ("sex", "race"))
    found = adverse_impact(made, ["approved"], ["m", "a"])
    assert table(found) == [{"sex": "m"}, {"race": "a"}, {"sex": "m", "race": "a"}]
    assert table(adverse_impact(made, ["approved"], ["race=b"], [("race",)])) == [{"race": "b"}]
    same = decisions({("a", "a"): (1, 2), ("b", "a"): (1, 3), ("a=b", "b"): (2, 3)}, ("a", "b"))
    assert table(adverse_impact(same, ["approved"], ["a=a", "b=a"])) == [{"a": "a"}, {"b": "a"}]  # by both: as by a


@pytest.mark.parametrize(
    ("control", "said"),
    [
        (["m"], "no label of the column 'race'; known: 'a', 'b'"),
        (["m", "f", "a"], "'m' and 'f' of the column 'sex'"),
        (["man", "a"], "there is no group 'man'"),
        (["x", "a"], "nobody is of the group 'x, a'"),
    ],
)
def test_a_control_group_that_is_not_one_is_refused(control: list[str], said: str) -> None:
    with pytest.raises(InputError, match=said):
        adverse_impact(decisions(COUNTS, ("sex", "race")), ["approved"], control)


def test_a_label_of_two_columns_is_asked_about() -> None:
    made = decisions({("a", "a"): (1, 2), ("b", "a"): (1, 3)}, ("x", "y"))
    with pytest.raises(InputError, match="write x=a or y=a"):
        adverse_impact(made, ["approved"], ["a", "b"])


def test_a_control_group_without_people_is_refused() -> None:
    with pytest.raises(InputError, match="nobody is of the group 'a'"):
        adverse_impact(decisions({("a",): (0, 0), ("b",): (1, 2)}), ["approved"], ["a"])


def test_the_commands_of_the_guide_run(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    rng = Random(tiers.fresh("credit"))
    rows = [f"{rng.choice(('approved', 'denied'))},{rng.choice(('white', 'black', 'asian'))},{rng.choice('fm')}" for _ in range(300)]
    Path("applications.csv").write_text("decision,race,sex\n" + "\n".join(rows) + "\n")
    (block,) = re.findall(r"^```sh\n(.*?)^```", GUIDE.read_text("utf-8"), re.MULTILINE | re.DOTALL)
    commands = [shlex.split(line)[1:] for line in block.splitlines()]
    assert [main(words) for words in commands] == [0, 0, 0]
    with Path("published/table.csv").open(encoding="utf-8") as file:
        figures = {row["group: race"]: row for row in csv.DictReader(file) if row["table"] == "race"}
    for race, row in figures.items():
        approved = [line.startswith("approved") for line in rows if f",{race}," in line]
        assert (int(row["applicants"]), int(row["selected"])) == (len(approved), sum(approved))
    assert figures["white"]["status"] == "reference"
