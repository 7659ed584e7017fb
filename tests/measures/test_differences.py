"""Differences of expected utilities, against loops over fractions: every sign, ties, absent cells, floats, and published tables."""

from __future__ import annotations

from fractions import Fraction
from itertools import permutations
from typing import Any

import oracle
import pytest
from hypothesis import given
from hypothesis import strategies as st

import fairaudit as fa
from fairaudit.errors import InputError
from fairaudit.measures.differences import MeanDifference, global_difference, least_signed_expectation, local_difference, outermost_means
from fairaudit.measures.ratios import global_fairness, local_fairness

F = Fraction
NUMBERS = st.sampled_from(["-3", "-1", "-1/3", "0", "1/7", "1", "5/2", "1e-300", "-1e300"])


def brute(law: fa.Law, utility: fa.Utility) -> dict[str, Any]:
    """The greatest differences, and the first pair that attains each: the first greatest, and the first least."""
    plain = oracle.plain(law, utility)
    blocks = [(x, [(a, oracle.expectation(plain, x, a)) for a in groups]) for x, groups in sorted(plain.p.items())]
    means = [(None, [(a, oracle.mean(plain, a)) for a in plain.shared])]
    return {"local": _first([block for block in blocks if len(block[1]) > 1]), "global": _first(means if means[0][1] else [])}


def _first(blocks: list[Any]) -> tuple[Fraction, Any, int, int] | None:
    best = None
    for x, members in blocks:
        pairs = [(one[1] - other[1], i, j) for (i, one), (j, other) in permutations(enumerate(members), 2)]
        value = max(pair[0] for pair in pairs)
        _, i, j = min((pair for pair in pairs if pair[0] == value), key=lambda pair: (pair[1], pair[2]))
        if best is None or value > best[0]:
            best = value, x, members[i][0], members[j][0]
    return best


def agrees(law: fa.Law, found: MeanDifference | None, expected: tuple[Fraction, Any, int, int] | None) -> bool:
    if found is None or expected is None:
        return found is None and expected is None
    value, x, high, low = expected
    witness = found.witness
    named = (None if x is None else law.context_label(x), law.group_label(high), law.group_label(low))
    top, bottom = witness.expectations
    return (found.value, top - bottom, witness.context, witness.higher, witness.lower) == (value, value, *named)


@st.composite
def laws(draw: st.DrawFn) -> fa.Law:
    contexts, groups, decisions = draw(st.integers(1, 3)), draw(st.integers(2, 4)), draw(st.integers(1, 3))
    entry = st.sampled_from([0, 0, 1, 2, 7])
    array = [[[draw(entry) for _ in range(decisions)] for _ in range(groups)] for _ in range(contexts)]
    array[0][0][0] = array[-1][1][-1] = 1
    return fa.Law.from_array(array, kind="counts")


@given(laws(), st.data())
def test_differences_are_those_of_the_definition(law: fa.Law, data: st.DataObject) -> None:
    if data.draw(st.booleans()):
        utility = fa.Utility({u: data.draw(NUMBERS) for u in law.decisions}, signed=True)
    else:
        utility = fa.Utility.from_function(lambda u, x, a: data.draw(NUMBERS), law, signed=True)
    table, expected = utility.on(law), brute(law, utility)
    assert agrees(law, local_difference(law, table), expected["local"])
    assert agrees(law, global_difference(law, table), expected["global"])
    plain = oracle.plain(law, utility)
    compared = [oracle.expectation(plain, x, a) for x, groups in plain.p.items() if len(groups) > 1 for a in groups]
    assert least_signed_expectation(law, table) == min(compared, default=None)


@given(laws(), st.sampled_from(["0", "1/3", "-5", "1e300"]), st.sampled_from(["1", "1/7", "1e-300"]), st.data())
def test_a_difference_does_not_depend_on_the_origin_and_scales_with_the_unit(
    law: fa.Law, shift: str, unit: str, data: st.DataObject
) -> None:
    values = {u: F(data.draw(st.sampled_from(["-1", "0", "1/2", "4"]))) for u in law.decisions}
    moved = {u: F(unit) * (v + F(shift)) for u, v in values.items()}
    for measure in (local_difference, global_difference):
        one, other = (measure(law, fa.Utility(g, signed=True).on(law)) for g in (values, moved))
        assert (one is None) is (other is None)
        assert one is None or other is None or other.value == F(unit) * one.value


@given(st.lists(st.lists(st.floats(0.001, 1), min_size=3, max_size=3), min_size=2, max_size=5), st.data())
def test_floats_are_the_numbers_that_they_store(rows: list[list[float]], data: st.DataObject) -> None:
    law = fa.Law.from_array([[[v / sum(row) for v in row] for row in rows]])
    utility = fa.Utility({u: data.draw(st.sampled_from(["-1", "0.1", "3"])) for u in law.decisions}, signed=True)
    expected = brute(law, utility)
    assert agrees(law, local_difference(law, utility.on(law)), expected["local"])
    assert agrees(law, global_difference(law, utility.on(law)), expected["global"])


def test_departments_of_berkeley() -> None:
    """D is 89/108 − 512/825 in department A, D̄ that of the admission rates of men and women."""
    law = fa.Law.from_counts(fa.example("ucb-admissions").table(), decision="Admit", group="Gender", context="Dept", count="Freq")
    for utility, width in (({"Admitted": 1}, 1), ({"Admitted": 1, "Rejected": -1}, 2), ({"Rejected": "-1/2"}, F(1, 2))):
        table = fa.Utility(utility, signed=True).on(law)
        local, overall = local_difference(law, table), global_difference(law, table)
        assert local is not None and overall is not None
        assert local.value == width * (F(89, 108) - F(512, 825))
        assert (local.witness.context, local.witness.higher) == ({"Dept": "A"}, {"Gender": "Female"})
        assert overall.value == width * (F(1198, 2691) - F(557, 1835))
        assert agrees(law, local, brute(law, fa.Utility(utility, signed=True))["local"])


def test_no_ratio_is_formed_of_a_utility_below_0() -> None:
    law = fa.Law.from_array([[3, 1], [1, 1]], kind="counts")
    table = fa.Utility({"0": 1, "1": -1}, signed=True).on(law)
    for measure in (local_fairness, global_fairness):
        with pytest.raises(InputError, match="ratios depend on the origin"):
            measure(law, table)
    with pytest.raises(InputError, match="is negative; utilities are at least 0"):
        fa.Utility({"0": 1, "1": -1})


@given(
    st.lists(st.lists(st.integers(1, 9), min_size=4, max_size=4), min_size=1, max_size=3),
    st.sampled_from([F(1, 3), F(1, 10**9), F(1, 10**20)]),
    st.integers(1, 5),
    st.booleans(),
)
def test_the_outermost_means_are_those_of_all_groups(tops: list[list[int]], near: Fraction, count: int, greatest: bool) -> None:
    """Four groups, some of them alike and some nearer to each other than floats can tell."""
    table = [[[F(1, 3) + top * near / 100, F(2, 3) - top * near / 100] for top in row] for row in tops]
    law = fa.Law.from_array(table, decisions=["yes", "no"], groups=list("abcd"))
    found = outermost_means(law, fa.Utility({"yes": 1}).on(law), count, greatest=greatest)
    means = [(a, sum(row[a][0] for row in table) / len(table)) for a in range(4)]
    sign = -1 if greatest else 1
    every, own = (sorted(listed, key=lambda entry: sign * entry[1]) for listed in (means, found))
    assert own[:count] == every[:count] and own[-1] == every[-1]
