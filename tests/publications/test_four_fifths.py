"""The four-fifths rule: findings of published examples, of random tables, and where there is little to compare."""

from __future__ import annotations

import json
from fractions import Fraction
from math import comb
from pathlib import Path
from random import Random
from typing import Any

import pytest
import tiers
from scipy.stats import fisher_exact

from fairaudit.errors import InputError
from fairaudit.publications.counts import Decisions
from fairaudit.publications.four_fifths import four_fifths
from fairaudit.publications.publication import Publication


def decisions(counts: dict[str, tuple[int, int]] | dict[tuple[str, ...], tuple[int, int]], columns: tuple[str, ...] = ("g",)) -> Decisions:
    """Selected and applicants of each group."""
    groups = tuple((group,) if isinstance(group, str) else group for group in counts)
    return Decisions(columns, groups, ("yes", "no"), tuple((s, n - s) for s, n in counts.values()), (0, 0))


def groups(found: Publication, table: int = 0) -> dict[str, dict[str, Any]]:
    return {",".join(entry["group"].values()): entry for entry in found.summary["tables"][table]["groups"]}


def test_the_questions_and_answers_of_1979() -> None:
    """60, 45, 48 and 51 % give 75, 80 (not below) and 85 %."""
    found = four_fifths(decisions({"a": (48, 80), "b": (54, 120), "c": (24, 50), "d": (51, 100)}), ["yes"])
    entries = groups(found)
    assert entries["a"]["status"] == "reference" and "findings" not in entries["a"]
    assert [entries[g]["ratio"] for g in "bcd"] == ["3/4", "4/5", "17/20"]
    assert [entries[g]["findings"]["below_four_fifths"] for g in "bcd"] == [True, False, False]
    assert [row[4] for row in found.rows] == ["1.000", "0.750", "0.800", "0.850"] or [
        dict(zip(found.header, row, strict=True))["ratio"] for row in found.rows
    ] == ["1.000", "0.750", "0.800", "0.850"]
    assert found.summary["comparisons"] == 3 and found.summary["below_four_fifths"] == 1


def test_random_tables_are_as_plain_loops_have_them() -> None:
    rng = Random(tiers.fresh("tables"))
    for _ in range(60):
        counts = {g: (rng.randint(0, n), n) for g in "abcd"[: rng.randint(2, 4)] if (n := rng.randint(1, 60))}
        rates = {g: Fraction(s, n) for g, (s, n) in counts.items()}
        top = max(rates.values())
        found = four_fifths(decisions(counts), ["yes"])
        entries = groups(found)
        (reference,) = (g for g, entry in entries.items() if entry["status"] == "reference")
        assert rates[reference] == top
        assert counts[reference][1] == max(counts[g][1] for g in counts if rates[g] == top)
        ps = {}
        for g, entry in entries.items():
            assert Fraction(entry["ratio"]) == (rates[g] / top if top else 1)
            if g != reference:
                (s, n), (h, m) = counts[g], counts[reference]
                low, high = map(Fraction, entry["findings"]["fisher_p"])
                assert high - low <= Fraction(2, 10**12)
                ps[g] = fisher_exact([[s, n - s], [h, m - h]]).pvalue
                assert float(low) - 1e-11 <= ps[g] <= float(high) + 1e-11
                assert entry["findings"]["below_four_fifths"] == (5 * s * m < 4 * h * n)
        order, before = sorted(ps, key=ps.__getitem__), 0.0
        for rank, g in enumerate(order):
            before = max(before, min(1.0, ps[g] * (len(ps) - rank)))
            assert abs(float(entries[g]["findings"]["holm_p"][0]) - before) < 1e-10


def test_little_to_compare_has_one_meaning_each() -> None:
    nobody = four_fifths(decisions({"a": (0, 5), "b": (0, 9)}), ["yes"])
    assert [entry["ratio"] for entry in groups(nobody).values()] == ["1", "1"]
    assert "Nobody of it was selected" in nobody.page.sections[0].tables[0].notes[1]
    alone = four_fifths(decisions({"a": (3, 5), "b": (0, 0)}), ["yes"])
    assert alone.summary["comparisons"] == 0 and alone.page.points == ()
    assert {g: (e["status"], e["rate"], e["ratio"]) for g, e in groups(alone).items()} == {
        "a": ("alone", "3/5", None),
        "b": ("empty", None, None),
    }
    assert "nothing is compared" in alone.page.lead
    empty = four_fifths(decisions({"a": (3, 5), "b": (0, 0), "c": (5, 5)}), ["yes"])
    assert empty.summary["comparisons"] == 1
    assert [row[3] for row in empty.page.sections[0].tables[0].rows] == ["60.0 %", "–", "100.0 %"]
    tie = groups(four_fifths(decisions({"a": (1, 2), "b": (4, 8), "c": (4, 8)}), ["yes"]))
    assert [tie[g]["status"] for g in "abc"] == ["compared", "reference", "compared"]
    assert [tie[g]["ratio"] for g in "abc"] == ["1", "1", "1"]
    assert not tie["a"]["findings"]["one_person"]


def test_exactly_two_deviations_are_not_more_than_two() -> None:
    found = groups(four_fifths(decisions({"a": (0, 2), "b": (2, 2)}), ["yes"]))["a"]["findings"]
    assert (found["squared_deviations"], found["more_than_two_standard_deviations"]) == ("4", False)


def test_columns_are_compared_by_themselves_and_together() -> None:
    counts = {("f", "a"): (1, 9), ("f", "b"): (4, 9), ("m", "a"): (5, 9), ("m", "b"): (6, 9)}
    made = decisions(counts, ("sex", "race"))
    found = four_fifths(made, ["yes"])
    assert [table["columns"] for table in found.summary["tables"]] == [["sex"], ["race"], ["sex", "race"]]
    assert found.summary["comparisons"] == 1 + 1 + 3
    assert [groups(found, 0)[g]["selected"] for g in "fm"] == [5, 11]
    chosen = four_fifths(made, ["yes"], [("race", "sex"), ("race",)])
    assert [table["columns"] for table in chosen.summary["tables"]] == [["race", "sex"], ["race"]]
    assert {row[0] for row in chosen.rows} == {"race and sex", "race"}
    labels = [dict(zip(chosen.header, row, strict=True)) for row in chosen.rows]
    assert {(row["group: sex"], row["group: race"]) for row in labels} == {(s, r) for s, r in counts} | {("", "a"), ("", "b")}
    for bad, said in (([("age",)], "no group column"), ([("sex", "sex")], "does not name different")):
        with pytest.raises(InputError, match=said):
            four_fifths(made, ["yes"], bad)


def test_small_groups_are_named() -> None:
    def notes(n: int) -> str:
        found = four_fifths(decisions({"big": (50, 100 - n), "small": (n, n)}), ["yes"])
        return " ".join(found.page.sections[0].tables[0].notes)

    assert "Less than 2 % of the people of this table each: small." in notes(1)
    assert "Less than" not in notes(2)  # exactly 2 %


def test_unknown_people_are_said_and_in_no_row() -> None:
    made = Decisions(("g",), (("a",), ("b",)), ("yes", "no"), ((3, 4), (5, 5)), (2, 6))
    found = four_fifths(made, ["yes"])
    assert found.summary["tables"][0]["unknown"] == {"applicants": 8, "selected": 2}
    last = dict(zip(found.header, found.rows[-1], strict=True))
    assert (last["applicants"], last["selected"], last["status"], last["group: g"]) == ("8", "2", "unknown", "")


def test_it_never_says_that_a_law_was_kept(tmp_path: Path) -> None:
    from fairaudit.cli import main

    path = tmp_path / "c.json"
    assert main(["certify", "--example", "ucb-admissions", "-o", str(path)]) == 0
    assert main(["publish", str(path), "--rule", "four-fifths", "-o", str(tmp_path / "out")]) == 0
    page = (tmp_path / "out" / "index.html").read_text("utf-8")
    for word in ("complian", "complies", "comply", "lawful", "violat", "pass"):
        assert word not in page.lower()
    for quoted in ("Smaller differences in selection rate may nevertheless", "Greater differences in selection rate may not"):
        assert quoted in page
    assert "summed over Dept" in page
    summary = json.loads((tmp_path / "out" / "summary.json").read_text())
    female = summary["tables"][0]["groups"][1]
    assert (female["applicants"], female["selected"], female["ratio"]) == (1835, 557, str(Fraction(557 * 2691, 1835 * 1198)))


def test_the_same_groups_under_two_names_are_compared_once() -> None:
    """Fisher's p of 33 and 20 of 50 is 0.01574…: of two comparisons, not of four, the adjusted one is twice as much."""
    counts: dict[tuple[str, ...], tuple[int, int]] = {("f", "a"): (20, 50), ("f", "b"): (33, 50), ("f", "c"): (25, 50)}
    ways = [comb(50, k) * comb(50, 53 - k) for k in range(3, 51)]
    p = Fraction(sum(way for way in ways if way <= comb(50, 20) * comb(50, 33)), comb(100, 53))
    for by in ((), (("race", "sex"), ("sex", "race"))):
        found = four_fifths(decisions(counts, ("sex", "race")), ["yes"], by)
        (shown,) = [table["groups"] for table in found.summary["tables"] if len(table["groups"]) > 1]
        (entry,) = (entry["findings"] for entry in shown if entry["group"]["race"] == "a")
        low, high = map(Fraction, entry["holm_p"])
        assert low <= 2 * p <= high and entry["holm_p_at_most_1_20"] and f"{float(2 * p):.4f}" == "0.0315"
        assert found.summary["comparisons"] == 2
        assert any(text.endswith("they are shown once, and count once") for _, text in found.page.facts)
    by_both = four_fifths(decisions(counts | {("m", "a"): (5, 10)}, ("sex", "race")), ["yes"])
    assert len(by_both.summary["tables"]) == 3 and by_both.summary["comparisons"] == 6
