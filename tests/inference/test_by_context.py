"""Contexts by themselves: e-values that are fair under the null, flags as e-BH defines them, small contexts that are left out or pooled."""

from __future__ import annotations

from fractions import Fraction
from math import comb
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from envelopes import envelope
from hypothesis import given
from hypothesis import strategies as st

import fairaudit as fa
from fairaudit.cli import main
from fairaudit.errors import InputError
from fairaudit.inference import by_context
from fairaudit.inference.by_context import contexts_by_themselves
from fairaudit.inference.cells import Cell
from fairaudit.inference.comparisons import Comparison, unit_form
from fairaudit.inference.table_comparisons import local_comparison

F = Fraction


def of(rows: Any, utility: Any = None, decisions: Any = ("yes", "no")) -> Comparison:
    law = fa.Law.from_array(rows, kind="counts", decisions=decisions)
    return local_comparison(law, fa.Utility(utility or {"yes": 1}).on(law))


def two_cells(k: int, n: int, j: int, m: int) -> Comparison:
    cells = tuple(Cell(size, F(own), None, F(0), F(1), True) for own, size in ((k, n), (j, m)))
    return Comparison(cells, ((unit_form(0), unit_form(1)),), (({"x": "0"}, ({"a": "0"}, {"a": "1"})),))


@given(st.lists(st.fractions(0, 400), min_size=1, max_size=8), st.sampled_from([F(1, 20), F(1, 5), F(1, 2)]))
def test_flags_are_those_of_the_definition(e_values: list[F], rate: F) -> None:
    m = len(e_values)
    counts = [k for k in range(1, m + 1) if sum(own >= m / (k * rate) for own in e_values) >= k]
    least = by_context._least_flagged(e_values, rate)
    flagged = 0 if least is None else sum(own >= least for own in e_values)
    assert flagged == max(counts, default=0)


@pytest.mark.parametrize(("p", "q", "limit"), [(0.5, 0.4, "5/4"), (0.5, 0.5, "1"), (0.9, 0.9, "1"), (0.3, 0.15, "2"), (0.2, 0.4, "5/4")])
def test_e_values_of_two_cells_have_at_most_the_mean_1(monkeypatch: pytest.MonkeyPatch, p: float, q: float, limit: str) -> None:
    """By all outcomes, where no ratio is above the limit, without the search for pairs that are worth looking at."""
    monkeypatch.setattr(by_context, "PROMISING", -100.0)
    n, m, mean = 9, 7, 0.0
    for k in range(n + 1):
        for j in range(m + 1):
            chance = comb(n, k) * p**k * (1 - p) ** (n - k) * comb(m, j) * q**j * (1 - q) ** (m - j)
            one = two_cells(k, n, j, m)
            mean += chance * float(by_context._of_levels(one.cells[0], one.cells[1], F(limit), F(2, 5), 4))
    assert mean <= 1 + 1e-12


@pytest.mark.parametrize("utility", [None, {"yes": 1, "maybe": "1/2"}])
def test_the_false_discovery_rate_is_kept(utility: Any) -> None:
    """Of twelve contexts, three of which are unequal, at a rate at which errors could be seen."""
    pick, rates, found = np.random.default_rng(6), [], 0
    for _ in range(25):
        rows = []
        for x in range(12):
            shares = [[0.4, 0.2, 0.4], [0.05, 0.1, 0.85]] if x < 3 else [[0.4, 0.2, 0.4]] * 2
            rows.append([pick.multinomial(60, share).tolist() for share in shares])
        compared = of(rows, utility, ("yes", "maybe", "no"))
        made = [
            by_context._e_value(by_context._part(compared, b), F(1), F(1, 2), len(compared.blocks)) for b in range(len(compared.blocks))
        ]
        least = by_context._least_flagged(made, F(1, 2))
        flagged = [b for b, own in enumerate(made) if least is not None and own >= least]
        rates.append(sum(b >= 3 for b in flagged) / max(1, len(flagged)))
        found += sum(b < 3 for b in flagged)
    assert np.mean(rates) <= 0.5
    assert found >= 50  # of 75


def test_what_is_unequal_is_flagged_and_what_is_small_is_not_judged() -> None:
    rows = [[[160, 40], [60, 140]], [[101, 99], [100, 100]], [[8, 2], [1, 9]], [[3, 4], [3, 2]]]
    made = contexts_by_themselves(of(rows), "5/4", min_cell=20)
    assert [own.flagged for own in made.findings] == [True, False] and made.findings[0].draws == 400
    assert [own["context"] for own in made.not_judged] == ["2", "3"] and not made.pooled
    pooled = contexts_by_themselves(of(rows), "5/4", min_cell=15, pool=True)
    assert not pooled.not_judged and [own["context"] for own in pooled.pooled] == ["2", "3"]
    last = pooled.findings[-1]
    assert last.context == {"context": "other (pooled)"} and last.draws == 32 and last.interval.estimate == F(11, 17) / F(4, 15)
    assert any("drawn from its population" in text for text in pooled.assumptions)
    too_few = contexts_by_themselves(of(rows), "5/4", min_cell=50, pool=True)
    assert len(too_few.not_judged) == 2 and len(too_few.findings) == 2


def test_each_interval_is_that_of_the_context_alone() -> None:
    rows = [[[40, 10], [20, 30]], [[25, 25], [30, 20]]]
    made = contexts_by_themselves(of(rows), confidence="0.9")
    for own, alone in zip(made.findings, rows, strict=True):
        law = fa.Law.from_array(alone, kind="counts", decisions=["yes", "no"])
        by_itself = fa.certify(law, {"yes": 1}, independent=True, confidence="0.9").intervals["local"]
        assert (own.interval.lower, own.interval.upper) == (by_itself.lower, by_itself.upper)


TWO = [[[30, 10], [20, 20]], [[30, 10], [29, 11]]]


@pytest.mark.parametrize(
    ("options", "said"),
    [
        ({"rate": 1}, "a rate between 0 and 1"),
        ({"limit": "1/2"}, "a limit of at least 1"),
        ({"min_cell": 0}, "at least 1 draw"),
        ({"min_cell": 41}, "0 contexts have 41 draws in each compared cell"),
    ],
)
def test_what_makes_no_sense_is_refused(options: dict[str, Any], said: str) -> None:
    with pytest.raises(InputError, match=said):
        contexts_by_themselves(of(TWO), **options)


def test_the_command_lists_them(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    lines = [
        f"{x},{a},{u},{n}"
        for x, own in zip("AB", TWO, strict=True)
        for a, row in zip("fm", own, strict=True)
        for u, n in zip(("yes", "no"), row, strict=True)
    ]
    (tmp_path / "log.csv").write_text("\n".join(["x,a,u,n", *lines]), "utf-8")
    asked = ["certify", str(tmp_path / "log.csv"), "--decision", "u", "--group", "a", "--count", "n", "--utility", "yes", "--context", "x"]

    def run(*more: str) -> str:
        main([*asked, *more])
        return "".join(capsys.readouterr())

    found = run("--independent-cells", "--by-context", "0.2", "--max-local-ratio", "5/4")
    assert "0 of 2 flagged for a ratio above 1.25, at a false discovery rate of 20 %" in found and "x=A" in found
    answer = envelope(run("--independent-cells", "--by-context", "0.2", "--max-local-log", "0.1", "--format", "json"))
    (entry,) = answer["details"]["findings"]
    assert entry["test"] == "by context" and len(entry["contexts"]) == 2 and 1.105 < float(F(entry["limit"])) < 1.106
    assert "needs cells that were declared independent" in run("--by-context", "0.2")
    assert "go with --by-context" in run("--independent-cells", "--min-cell", "3")
    assert "--pool-small goes with --min-cell" in run("--independent-cells", "--by-context", "0.2", "--pool-small")


def test_a_pool_has_a_name_of_its_own() -> None:
    rows = {"ctx": [], "g": [], "d": []}
    for context, draws in (("other (pooled)", 50), ("a", 8), ("b", 60), ("c", 8)):
        for group in "xy":
            for i in range(draws):
                rows["ctx"].append(context), rows["g"].append(group), rows["d"].append("yes" if i % 2 else "no")
    law = fa.Law.from_log(rows, decision="d", group="g", context="ctx")
    made = contexts_by_themselves(fa.certify(law, {"yes": 1}).comparisons["local"], min_cell=10, pool=True)
    assert sorted(own.context["ctx"] for own in made.findings if own.context) == ["b", "other (pooled)", "other (pooled) 2"]
