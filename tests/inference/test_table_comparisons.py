"""Plain tables of counts: pooled contexts, sampling units, the range of g."""

from __future__ import annotations

from pathlib import Path
from random import Random

import pytest
from interval_oracle import (
    F,
    by_unit,
    recheck,
)

from fairaudit import Law, Policy, Utility, read_csv
from fairaudit.errors import InputError
from fairaudit.inference.policy_comparisons import policy_comparison
from fairaudit.inference.ratio_intervals import ratio_interval
from fairaudit.inference.table_comparisons import global_comparison, local_comparison
from fairaudit.model.mechanism import Identity


def test_global_ratio_of_a_sample_pools_the_contexts(data: Path) -> None:
    law = Law.from_counts(read_csv(data / "ucb_admissions.csv"), decision="Admit", group="Gender", context="Dept", count="Freq")
    utility = Utility({"Admitted": 1}).on(law)
    pooled = global_comparison(law, utility)
    assert [(c.draws, c.binary) for c in pooled.cells] == [(2691, True), (1835, True)]
    found = ratio_interval(pooled)
    assert found.estimate == F(2198330, 1498887)
    assert 1.25 < found.lower < found.upper < 1.7
    local = ratio_interval(local_comparison(law, utility))
    assert local.estimate == F(24475, 18432)
    assert local.lower <= local.estimate <= local.upper
    equal = {((d,), (g,)): 1 for d in "ABCDEF" for g in ("Male", "Female")}
    stated = ratio_interval(global_comparison(law, utility, equal))
    assert stated.lower == 1
    recheck(stated.evidence, stated.lower, stated.upper)


def test_units_count_once() -> None:
    rows = {"a": [], "u": [], "run": []}
    random = Random(4)
    for run in range(60):
        for a in "fm":
            answer = random.choice(["yes", "no"])
            for _ in range(5):  # five copies of one answer
                rows["a"].append(a)
                rows["u"].append(answer)
                rows["run"].append(f"{run}{a}")
    law = Law.from_log(rows, decision="u", group="a")
    naive = ratio_interval(local_comparison(law, Utility({"yes": 1}).on(law)))
    comparison = by_unit(rows, Utility({"yes": 1}), decision="u", group="a")
    honest = ratio_interval(comparison)
    assert [c.draws for c in comparison.cells] == [60, 60]
    assert not comparison.dependent
    assert honest.estimate == naive.estimate
    assert honest.upper > naive.upper
    recheck(honest.evidence, honest.lower, honest.upper)


def test_units_that_span_cells_are_not_independent() -> None:
    rows = {"a": list("fmfm"), "u": ["yes", "no", "yes", "yes"], "run": [1, 1, 2, 2]}
    comparison = by_unit(rows, Utility({"yes": 1}), decision="u", group="a")
    assert comparison.dependent and all(cell.binary for cell in comparison.cells)
    assert any("2 of 2 units" in note for note in comparison.notes)
    with pytest.raises(InputError, match="not independent"):
        ratio_interval(comparison, independent=True)
    rows["run"][0] = None
    with pytest.raises(InputError, match="row 1: the sampling unit has no label"):
        by_unit(rows, Utility({"yes": 1}), decision="u", group="a")


def test_what_was_not_seen_is_still_possible() -> None:
    law = Law.from_array([[10], [10]], kind="counts", decisions=["yes"], groups=["f", "m"])
    found = ratio_interval(local_comparison(law, Utility({"yes": 1}).on(law)))
    assert found.lower == 1 and found.upper > 1
    values = Law.from_array([[5, 5], [5, 5]], kind="counts", decisions=["slow", "fast"], groups=["f", "m"])
    waiting = Utility({"slow": 4, "fast": 1}).on(values)
    assert not local_comparison(values, waiting).cells[0].binary
    closed = local_comparison(values, waiting, limits=(1, 4))
    # Only 1 and 4 were drawn, but anything between could have been: no binomial ends.
    assert not closed.cells[0].binary and any("between 1 and 4" in text for text in closed.assumptions)
    assert ratio_interval(closed).upper < ratio_interval(local_comparison(values, waiting)).upper
    with pytest.raises(InputError, match="outside the declared limits"):
        local_comparison(values, waiting, limits=(1, 3))
    with pytest.raises(InputError, match="the lower limit comes first"):
        local_comparison(values, waiting, limits=(3, 1))
    with pytest.raises(InputError, match="ratios depend on the origin"):
        ratio_interval(local_comparison(values, waiting, limits=(-1, 4)))


def test_only_whole_counts_carry_a_sample_size() -> None:
    table = {"u": ["yes", "no"] * 2, "a": ["f", "f", "m", "m"], "n": ["2.5", "1", "3", "1"]}
    law = Law.from_counts(table, decision="u", group="a", count="n")
    with pytest.raises(InputError, match="whole counts"):
        local_comparison(law, Utility({"yes": 1}).on(law))
    shares = Law.from_array([[0.5, 0.5], [0.2, 0.8]], decisions=["yes", "no"])
    with pytest.raises(InputError, match="no sample size"):
        local_comparison(shares, Utility({"yes": 1}).on(shares))
    policy = Policy.from_array([[0.5, 0.5], [0.2, 0.8]], decisions=["yes", "no"], groups=["f", "m"])
    with pytest.raises(InputError, match="no sample size"):
        policy_comparison(policy, Utility({"yes": 1}), Identity(["f", "m"]))
