"""The measures against the oracle, on random laws; and the properties that the theory states."""

from __future__ import annotations

from fractions import Fraction
from itertools import permutations
from math import inf
from random import Random
from typing import Any

import numpy as np
import oracle
import pytest
import tiers
from hypothesis import assume, given
from hypothesis import strategies as st

from fairaudit import Law, Utility, certify
from fairaudit.measures.distances import demographic_parity, equalized_odds, most_unequal_distances
from fairaudit.measures.expectations import least_expectation
from fairaudit.measures.ratios import (
    Ratio,
    global_fairness,
    global_supremum,
    local_fairness,
    local_supremum,
    most_unequal_contexts,
    most_unequal_ratios,
)
from fairaudit.testing import laws, utilities


@st.composite
def audits(draw: st.DrawFn, **options: Any) -> tuple[Law, Utility]:
    law = draw(laws(**options))
    return law, draw(utilities(law))


def place(law: Law, index: int) -> dict[str, str]:
    return law.group_label(index)


@given(audits())
def test_local_ratio_and_witness_equal_the_oracle(audit: tuple[Law, Utility]) -> None:
    law, utility = audit
    expected = oracle.local(oracle.plain(law, utility))
    found = local_fairness(law, utility.on(law))
    assert (found is None) == (expected is None)
    if found is not None:
        value, (x, a, b) = expected
        plain = oracle.plain(law, utility)
        assert found.ratio == value
        assert found.witness.context == law.context_label(x)
        assert (found.witness.higher, found.witness.lower) == (place(law, a), place(law, b))
        assert found.witness.expectations == (oracle.expectation(plain, x, a), oracle.expectation(plain, x, b))


@given(audits())
def test_global_ratio_and_witness_equal_the_oracle(audit: tuple[Law, Utility]) -> None:
    law, utility = audit
    plain = oracle.plain(law, utility)
    expected = oracle.overall(plain)
    found = global_fairness(law, utility.on(law))
    assert (found is None) == (expected is None)
    if found is not None:
        value, (a, b) = expected
        assert found.ratio == value
        assert (found.witness.higher, found.witness.lower) == (place(law, a), place(law, b))
        assert found.witness.expectations == (oracle.mean(plain, a), oracle.mean(plain, b))


@given(audits())
def test_distances_and_witnesses_equal_the_oracle(audit: tuple[Law, Utility]) -> None:
    law, utility = audit
    plain = oracle.plain(law, utility)
    odds, parity = equalized_odds(law), demographic_parity(law)
    expected_odds, expected_parity = oracle.equalized_odds(plain), oracle.demographic_parity(plain)
    assert (odds is None) == (expected_odds is None)
    assert (parity is None) == (expected_parity is None)
    if odds is not None:
        value, (x, a, b) = expected_odds
        assert odds.value == value
        assert (odds.witness.context, odds.witness.higher, odds.witness.lower) == (law.context_label(x), place(law, a), place(law, b))
        chosen = [u for u, p, q in zip(law.decisions, plain.p[x][a], plain.p[x][b], strict=True) if p > q]
        assert list(odds.witness.decisions) == chosen
    if parity is not None:
        value, (a, b) = expected_parity
        assert parity.value == value
        assert (parity.witness.higher, parity.witness.lower) == (place(law, a), place(law, b))


@given(audits())
def test_suprema_and_witnesses_equal_the_oracle(audit: tuple[Law, Utility]) -> None:
    law, utility = audit
    plain = oracle.plain(law, utility)
    found, expected = local_supremum(law), oracle.local_supremum(plain)
    assert (found is None) == (expected is None)
    if found is not None:
        value, (x, u, a, b) = expected
        assert (found.ratio, found.witness.context, found.witness.decision) == (value, law.context_label(x), law.decisions[u])
        assert (found.witness.higher, found.witness.lower) == (place(law, a), place(law, b))
    found, expected = global_supremum(law), oracle.global_supremum(plain)
    assert (found is None) == (expected is None)
    if found is not None:
        value, (u, a, b) = expected
        assert (found.ratio, found.witness.decision) == (value, law.decisions[u])
        assert (found.witness.higher, found.witness.lower) == (place(law, a), place(law, b))


@given(audits(), st.integers(1, 8))
def test_most_unequal_pairs_equal_a_full_sort(audit: tuple[Law, Utility], count: int) -> None:
    law, utility = audit
    plain = oracle.plain(law, utility)
    everything = []
    for x in sorted(plain.p):
        for a in sorted(plain.p[x]):
            for b in sorted(plain.p[x]):
                value = oracle.ratio(oracle.expectation(plain, x, a), oracle.expectation(plain, x, b))
                if a != b and value > 1:
                    everything.append((-value, x, a, b))
    found = most_unequal_ratios(law, utility.on(law), count, within_context=True)
    expected = sorted(everything)[:count]
    if expected:
        assert [(-m.ratio, m.witness.context, m.witness.higher, m.witness.lower) for m in found] == [
            (v, law.context_label(x), place(law, a), place(law, b)) for v, x, a, b in expected
        ]
    else:
        assert all(m.ratio == 1 for m in found)
    distances = sorted(
        (-oracle.distance(plain.p[x][a], plain.p[x][b]), x, a, b) for x in plain.p for a in plain.p[x] for b in plain.p[x] if a < b
    )
    unequal = [entry for entry in distances if entry[0] < 0][:count]
    ranked = most_unequal_distances(law, count, within_context=True)
    if unequal:
        assert [(-d.value, d.witness.context, d.witness.higher, d.witness.lower) for d in ranked] == [
            (v, law.context_label(x), place(law, a), place(law, b)) for v, x, a, b in unequal
        ]


@given(audits())
def test_constants(audit: tuple[Law, Utility]) -> None:
    law, utility = audit
    table, plain = utility.on(law), oracle.plain(*audit)
    values = [v for row in plain.g.values() for v in row]
    assert (table.gamma, table.m) == (max(values), min(values))
    gaps = [abs(v - w) for x in plain.p for a in plain.p[x] for b in plain.p[x] for v, w in zip(plain.g[x, a], plain.g[x, b], strict=True)]
    assert table.lipschitz() == max(gaps)
    assert table.lipschitz(lambda a, b: Fraction(1, 2)) == 2 * max(gaps)
    compared = [oracle.expectation(plain, x, a) for x in plain.p for a in plain.p[x] if len(plain.p[x]) > 1]
    assert least_expectation(law, table) == (min(compared) if compared else None)


# Properties


@given(audits())
def test_ratio_is_one_exactly_at_parity(audit: tuple[Law, Utility]) -> None:
    law, utility = audit
    found = local_fairness(law, utility.on(law))
    assume(found is not None)
    plain = oracle.plain(law, utility)
    parity = all(len({oracle.expectation(plain, x, a) for a in plain.p[x]}) == 1 for x in plain.p)
    assert found.ratio >= 1
    assert (found.ratio == 1) == parity
    assert found.log[0] >= 0
    assert (found.log == (0, 0)) == parity


@given(audits(), st.randoms(use_true_random=False), st.fractions(Fraction(1, 50), 50))
def test_invariant_under_relabelling_and_scaling(audit: tuple[Law, Utility], random: Any, factor: Fraction) -> None:
    law, utility = audit
    table = utility.on(law)
    order = list(range(len(law.decisions)))
    random.shuffle(order)
    shuffled = Law(
        columns=law.columns,
        decisions=tuple(law.decisions[k] for k in order),
        groups=tuple((f"renamed {g[0]}",) for g in law.groups),
        contexts=law.contexts,
        kind=law.kind,
        population=law.population,
        cell_context=law.cell_context,
        cell_group=law.cell_group,
        weights=law.weights[:, order],
        scale=law.scale,
        mass=law.mass,
    )
    values = {
        (law.decisions[k], law.contexts[x], (f"renamed {law.groups[a][0]}",)): Fraction(g) * factor
        for (x, a), row in oracle.plain(law, utility).g.items()
        for k, g in enumerate(row)
    }
    renamed = Utility.from_function(lambda u, x, a: values[u, x, a], shuffled).on(shuffled)
    for measure in (local_fairness, global_fairness):
        before, after = measure(law, table), measure(shuffled, renamed)
        assert (before and before.ratio) == (after and after.ratio)
    for distance in (demographic_parity, equalized_odds):
        before, after = distance(law), distance(shuffled)
        assert (before and before.value) == (after and after.value)


@given(audits(max_groups=4))
def test_leaving_a_group_out_never_raises_a_measure(audit: tuple[Law, Utility]) -> None:
    law, utility = audit
    assume(len(law.groups) > 2 and law.population != "equal")
    keep = law.cell_group < len(law.groups) - 1
    assume(keep.any())
    fewer = Law(
        columns=law.columns,
        decisions=law.decisions,
        groups=law.groups[:-1],
        contexts=law.contexts,
        kind=law.kind,
        population=law.population,
        cell_context=law.cell_context[keep],
        cell_group=law.cell_group[keep],
        weights=law.weights[keep],
        scale=law.scale,
        mass=None if law.mass is None else tuple(m for m, k in zip(law.mass, keep, strict=True) if k),
    )
    for measure in (local_fairness, global_fairness):
        less, more = measure(fewer, utility.on(fewer)), measure(law, utility.on(law))
        assert less is None or (more is not None and less.ratio <= more.ratio)


@given(laws(kinds=("counts",), complete=True, max_groups=4, entries=st.integers(0, 40)), st.data())
def test_pooling_groups_with_fixed_weights_never_raises_local(law: Law, data: Any) -> None:
    utility = data.draw(utilities(law, group_blind=True))
    weights = data.draw(st.lists(st.integers(1, 9), min_size=2, max_size=2))
    plain = oracle.plain(law, utility)
    rows = []
    for x in range(len(law.contexts)):
        p = plain.p[x]
        pooled = [Fraction(weights[0] * v + weights[1] * w, sum(weights)) for v, w in zip(p[0], p[1], strict=True)]
        rows.append([pooled, *(p[a] for a in range(2, len(law.groups)))])
    assume(len(rows[0]) > 1)
    pooled_law = Law.from_array(rows, contexts=list(law.contexts), decisions=law.decisions)
    values = {(u, law.contexts[x]): g for (x, _), row in plain.g.items() for u, g in zip(law.decisions, row, strict=True)}
    blind = Utility.from_function(lambda u, x, a: values[u, x], pooled_law)
    assert local_fairness(pooled_law, blind.on(pooled_law)).ratio <= local_fairness(law, utility.on(law)).ratio


@given(st.data())
def test_t5_global_is_at_most_local_under_independence(data: Any) -> None:
    law = data.draw(laws(independent=True))
    assert law.independent
    utility = data.draw(utilities(law)).on(law)
    assert global_fairness(law, utility).ratio <= local_fairness(law, utility).ratio


def test_t5_fails_without_independence() -> None:
    """Every context is fair, the groups are spread differently: L = 0 < L̄."""
    law = Law.from_array([[[9, 1], [90, 10]], [[10, 90], [1, 9]]], kind="counts", decisions=["yes", "no"])
    utility = Utility({"yes": 1}).on(law)
    assert not law.independent
    assert local_fairness(law, utility).ratio == 1
    assert global_fairness(law, utility).ratio == Fraction(91, 110) / Fraction(19, 110)
    assert "spread differently" in certify(law, {"yes": 1}).sentence


@given(audits())
def test_t6_no_group_blind_utility_exceeds_the_supremum_and_an_indicator_attains_it(audit: tuple[Law, Utility]) -> None:
    law, _ = audit
    found = local_supremum(law)
    assume(found is not None)
    where = found.witness.context
    index = next(i for i in range(len(law.contexts)) if law.context_label(i) == where)
    indicator = Utility.from_function(lambda u, x, a: int(u == found.witness.decision and x == law.contexts[index]), law)
    assert local_fairness(law, indicator.on(law)).ratio == found.ratio
    everywhere = global_supremum(law)
    if everywhere is not None:
        assert global_fairness(law, Utility({everywhere.witness.decision: 1}).on(law)).ratio == everywhere.ratio


@given(laws(), st.data())
def test_t6_bounds_every_group_blind_utility(law: Law, data: Any) -> None:
    utility = data.draw(utilities(law, group_blind=True)).on(law)
    found = local_fairness(law, utility)
    assert found is None or found.ratio <= local_supremum(law).ratio
    blind = data.draw(utilities(law, by_decision=True)).on(law)
    found = global_fairness(law, blind)
    assert found is None or found.ratio <= global_supremum(law).ratio


@given(laws())
def test_t7_distances_are_bounded_by_the_suprema(law: Law) -> None:
    for distance, supremum in ((equalized_odds(law), local_supremum(law)), (demographic_parity(law), global_supremum(law))):
        if distance is not None:
            bound = 1 if supremum.ratio == inf else (supremum.ratio - 1) / (supremum.ratio + 1)
            assert distance.value <= bound


# Conventions


def test_zero_over_zero_is_parity_and_something_over_zero_is_infinite() -> None:
    law = Law.from_array([[[0, 1], [0, 1]], [[1, 1], [0, 2]]], kind="counts", decisions=["yes", "no"], contexts=["p", "q"])
    found = local_fairness(law, Utility({"yes": 1}).on(law))
    assert found.ratio == inf
    assert found.witness.context == {"context": "q"}
    assert found.witness.expectations == (Fraction(1, 2), 0)
    result = certify(law, {"yes": 1})
    assert "exactly 0" in result.sentence
    only_zeros = Law.from_array([[[0, 1], [0, 1]]], kind="counts", decisions=["yes", "no"])
    assert local_fairness(only_zeros, Utility({"yes": 1}).on(only_zeros)).ratio == 1


def test_contexts_with_one_group_and_empty_cells_are_listed() -> None:
    law = Law.from_counts(
        {"u": list("ynynyn"), "a": list("ffmmff"), "x": list("ppppqq"), "n": [1, 2, 3, 4, 5, 6]},
        decision="u",
        group="a",
        context="x",
        count="n",
    )
    result = certify(law, {"y": 1})
    assert list(result.not_compared) == [
        {"context": {"x": "q"}, "groups": [{"a": "m"}], "reason": "no decisions recorded"},
        {"context": {"x": "q"}, "reason": "fewer than two groups"},
    ]
    assert result.global_ is not None


def test_a_target_on_what_was_not_compared_is_inconclusive() -> None:
    law = Law.from_counts(
        {"u": list("ynyn"), "a": list("ffmm"), "x": list("ppqq"), "n": [1, 2, 3, 4]}, decision="u", group="a", context="x", count="n"
    )
    result = certify(law, {"y": 1}, max_local_log="0.5", confidence=None)
    assert result.local is None
    assert result.verdict == "inconclusive"


# The float filter decides nothing


@pytest.mark.parametrize("shape", [(40, 25, 30), (3, 60, 4), (200, 2, 10)])
@pytest.mark.parametrize("kind", ["counts", "probabilities"])
def test_large_tables_equal_the_oracle_on_sampled_contexts(shape: tuple[int, int, int], kind: str) -> None:
    generator = np.random.default_rng(5)
    array = generator.integers(0, 50, shape) if kind == "counts" else generator.dirichlet(np.ones(shape[2]), shape[:2])
    law = Law.from_array(array, kind=kind)
    utility = Utility({u: i % 7 for i, u in enumerate(law.decisions)})
    ranked = most_unequal_ratios(law, utility.on(law), 3, within_context=True)
    best = None
    for x in generator.choice(shape[0], 3, replace=False).tolist():
        part = Law.from_array(array[x : x + 1], kind=kind, contexts=[law.contexts[x]])
        value, _ = oracle.local(oracle.plain(part, utility))
        assert local_fairness(part, utility.on(part)).ratio == value
        assert ranked[0].ratio >= value
        best = value if best is None else max(best, value)
    witness = ranked[0].witness.context["context"]
    part = Law.from_array(array[int(witness) : int(witness) + 1], kind=kind)
    assert oracle.local(oracle.plain(part, utility))[0] == ranked[0].ratio >= best


def test_a_difference_below_float_resolution_is_found() -> None:
    """Two rows whose expectations agree to 30 digits differ, and the difference is the whole result."""
    tiny = Fraction(1, 10**30)
    rows = [[["1/2", "1/2"], ["1/2", "1/2"]], [[str(Fraction(1, 2) + tiny), str(Fraction(1, 2) - tiny)], ["1/2", "1/2"]]]
    law = Law.from_array(np.array(rows, dtype=object), decisions=["yes", "no"], contexts=["p", "q"])
    found = local_fairness(law, Utility({"yes": 1}).on(law))
    assert found.ratio == 1 + 2 * tiny
    assert found.witness.context == {"context": "q"}
    assert equalized_odds(law).value == tiny


def test_subnormal_floats_are_exact() -> None:
    smallest = 5e-324
    law = Law.from_array([[[smallest, 1.0], [2 * smallest, 1.0]]], decisions=["yes", "no"])
    plain = oracle.plain(law, Utility({"yes": 1}))
    found = local_fairness(law, Utility({"yes": 1}).on(law))
    assert found.ratio == oracle.local(plain)[0] == 2 * (1 + Fraction(smallest)) / (1 + 2 * Fraction(smallest))


def test_floats_that_look_equal_may_differ() -> None:
    p = np.array([[[0.1, 0.9], [0.1, 0.9]], [[0.3, 0.7], [np.nextafter(0.3, 1), 0.7]]])
    law = Law.from_array(p, decisions=["yes", "no"])
    plain = oracle.plain(law, Utility({"yes": 1}))
    assert local_fairness(law, Utility({"yes": 1}).on(law)).ratio == oracle.local(plain)[0] > 1
    assert equalized_odds(law).value == oracle.equalized_odds(plain)[0] > 0


def test_ranks_are_those_of_all_pairs_also_among_zeros_and_ties() -> None:
    """Groups of which many get nothing, and ratios that many pairs share: the first in the order of the table count."""
    pick = Random(tiers.fresh(5))
    for _ in range(tiers.size(300, 1500)):
        shape = (pick.choice((1, 1, 2, 3)), pick.choice((2, 5, 9, 40)))
        yes = [[pick.choice((0, 0, 0, 1, 2, 4)) for _ in range(shape[1])] for _ in range(shape[0])]
        times = [[pick.choice((1, 1, 3)) for _ in range(shape[1])] for _ in range(shape[0])]
        weights = [[[k * n, (4 - k) * n] for k, n in zip(*rows, strict=True)] for rows in zip(yes, times, strict=True)]
        law, count = Law.from_array(weights, kind="counts", decisions=["yes", "no"]), pick.choice((1, 2, 3, 7))
        table = Utility({"yes": 1}).on(law)
        places = [
            (-inf if not row[low] else -Fraction(row[high], row[low]), x, high, low)
            for x, row in enumerate(yes)
            for high, low in permutations(range(len(row)), 2)
            if row[high] > row[low]
        ]

        def named(found: tuple[Ratio, ...]) -> list[tuple[object, ...]]:
            return [(-r.ratio, *(int(*of.values()) for of in (r.witness.context or {}, r.witness.higher, r.witness.lower))) for r in found]

        found = most_unequal_ratios(law, table, count, within_context=True)
        assert named(found) == sorted(places)[:count] if places else found[0].ratio == 1
        first = [min(own) for x in range(len(yes)) if (own := [place for place in places if place[1] == x])]
        assert named(most_unequal_contexts(law, table, count)) == sorted(first)[:count]
