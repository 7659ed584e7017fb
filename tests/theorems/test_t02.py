"""T2: pure privacy and a utility that ignores the group, for every policy."""

from __future__ import annotations

from math import inf

import pytest
from theorem_oracle import F, deployments, distance, pure, ratio, response_rows, stick

from fairaudit.theorems.t02 import t2
from fairaudit.theorems.t10 import t10
from fairaudit.theorems.t11 import t11_refutes


@pytest.mark.parametrize("uses", ["context", "decision"])
def test_no_policy_exceeds_the_bound(uses: str) -> None:
    for _, d in deployments(300, uses=uses):
        bound = t2(pure(d.rows_a))
        assert d.local <= bound.value
        assert bound.scope == "any policy behind this filter"
        for k in bound.multipliers:
            assert all(stick(p, q, k) == 0 for p in d.rows_a for q in d.rows_a)


@pytest.mark.parametrize("k", [2, 3, 5])
def test_attained_by_a_policy_that_favours_one_released_value(k: int) -> None:
    rows = response_rows(k, F(3, 4))
    assert ratio(rows[0][0], rows[1][0]) == t2(pure(rows)).value


def test_false_for_a_utility_of_the_group() -> None:
    """Choosing slot 1 always: with g = 1{this slot is mine} the filter releases nothing and the ratio is still infinite."""
    assert t2(1).value == 1
    assert ratio(F(1), F(0)) == inf
    assert "the utility does not depend on the group" in t2(1).assumptions
    assert "the utility does not depend on the group" not in t10(1).assumptions


def test_a_shared_seed_breaks_the_assumption_that_every_claim_lists() -> None:
    """X̃ = W and Ã = A⊕W with one fair coin W: each filter alone is perfectly private, and U = X̃⊕Ã = A."""
    released = {a: {(w, a ^ w): F(1, 2) for w in (0, 1)} for a in (0, 1)}
    marginal_x = [[sum(p for (x, _), p in released[a].items() if x == v) for v in (0, 1)] for a in (0, 1)]
    marginal_a = [[sum(p for (_, y), p in released[a].items() if y == v) for v in (0, 1)] for a in (0, 1)]
    assert distance(*marginal_x) == distance(*marginal_a) == 0
    means = [sum(p * (x ^ y) for (x, y), p in released[a].items()) for a in (0, 1)]
    measured = ratio(means[1], means[0])
    assert measured == inf
    assert measured > t2(pure(marginal_a)).value == 1
    assert t11_refutes(measured, 1)
    assert any("independent of each other and of everything else" in sentence for sentence in t2(1).assumptions)
