"""T8: filtering the context."""

from __future__ import annotations

from math import inf

import pytest
from theorem_oracle import Deployment, F, deployments, pure, random_row, response_rows, table_filter

from fairaudit.model.law import Law
from fairaudit.model.mechanism import Mechanism
from fairaudit.model.utility import Utility
from fairaudit.theorems.t08 import t8_applies


def filters(rows: list[list[F]]) -> Mechanism:
    return Mechanism.from_array(rows, [str(i) for i in range(len(rows))], [str(i) for i in range(len(rows[0]))])


def identity(size: int) -> list[list[F]]:
    return [[F(int(i == j)) for j in range(size)] for i in range(size)]


def test_where_it_applies_a_context_filter_never_raises_the_local_ratio() -> None:
    for rng, d in deployments(200, uses="decision", masses=False):
        size = len(d.policy)
        d.rows_x, d.population = identity(size), [[F(1)] * len(d.rows_a)] * size
        d.utility = [d.utility[0]] * size
        law, utility = d.audited()
        before = d.local
        d.rows_x = [random_row(rng, size) for _ in range(size)]
        assert t8_applies(law, utility.on(law), filters(d.rows_x)) == (True, "")
        assert d.local <= before


def test_released_contexts_that_nobody_compares_void_it() -> None:
    """Context 1 exists for group 0 only: nobody is compared there, the filter releases it for context 0, and the ratio becomes infinite."""
    policy = [[[F(1), F(0)]] * 2, [[F(0), F(1)], [F(1), F(0)]]]
    rows_a = identity(2)
    d = Deployment(policy, identity(2), rows_a, [[[F(0), F(1)]] * 2] * 2, [[F(1)] * 2] * 2, table_filter(rows_a))
    law = Law.from_array([[d.law(0, 0), d.law(0, 1)], [d.law(1, 0), [0, 0]]], decisions=["0", "1"])
    utility = Utility({"1": 1}).on(law)
    compared_before = [d.expectation(0, a) for a in d.groups]
    d.rows_x = [[F(1, 2), F(1, 2)], [F(1, 2), F(1, 2)]]
    compared_after = [d.expectation(0, a) for a in d.groups]
    assert compared_before == [0, 0]
    assert compared_after == [F(1, 2), 0]
    applies, why = t8_applies(law, utility, filters(d.rows_x))
    assert not applies
    assert "'1'" in why
    assert t8_applies(law, utility, filters([[F(1), F(0)], [F(1), F(0)]])) == (True, "")


def test_released_labels_that_are_no_contexts_void_it() -> None:
    law = Law.from_array([[[1, 1], [1, 1]]], decisions=["0", "1"], contexts=["0"], kind="counts")
    applies, why = t8_applies(law, Utility({"1": 1}).on(law), Mechanism.from_array([[1]], ["0"], ["elsewhere"]))
    assert not applies
    assert "elsewhere" in why


def test_a_utility_of_the_context_voids_it() -> None:
    """g(u,x): each context alone is fair, but the mixture of policies is weighed by the wrong utility."""
    rows_a = identity(2)
    # In context 0 only decision 0 pays, and everyone gets it half of the time; likewise in context 1 with decision 1.
    policy = [[[F(1, 2), F(1, 2), F(0)], [F(1, 2), F(0), F(1, 2)]], [[F(0), F(1, 2), F(1, 2)], [F(0), F(1, 2), F(1, 2)]]]
    utility = [[[F(1), F(0), F(0)]] * 2, [[F(0), F(1), F(0)]] * 2]
    d = Deployment(policy, identity(2), rows_a, utility, [[F(1)] * 2] * 2, table_filter(rows_a))
    law, g = d.audited()
    before = d.local
    d.rows_x = response_rows(2, F(1, 2))
    assert before == 1
    assert d.local == 2
    assert t8_applies(law, g.on(law), filters(d.rows_x))[0] is False


def test_it_says_nothing_about_the_global_ratio() -> None:
    policy = [[[F(0), F(1)], [F(1), F(0)]], [[F(1), F(0)], [F(0), F(1)]]]
    d = Deployment(policy, identity(2), identity(2), [[[F(0), F(1)]] * 2] * 2, [[F(1, 4)] * 2] * 2, table_filter(identity(2)))
    law, g = d.audited()
    assert (d.local, d.overall) == (inf, 1)
    d.rows_x = [[F(9, 10), F(1, 10)], [F(7, 10), F(3, 10)]]
    assert pure(d.rows_x) == 3
    assert t8_applies(law, g.on(law), filters(d.rows_x))[0]
    assert d.overall == 4


@pytest.mark.parametrize("keep", [F(1, 3), F(2, 3), F(1)])
def test_equality_can_hold_where_the_filter_is_not_the_identity(keep: F) -> None:
    """A constant ratio over the contexts survives every filter: "cannot hold with equality" would be false."""
    policy = [[[F(1, 2), F(1, 2)], [F(3, 4), F(1, 4)]], [[F(0), F(1)], [F(1, 2), F(1, 2)]]]
    d = Deployment(policy, response_rows(2, keep), identity(2), [[[F(0), F(1)]] * 2] * 2, [[F(1)] * 2] * 2, table_filter(identity(2)))
    assert d.local == 2
