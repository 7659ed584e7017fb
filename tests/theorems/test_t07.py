"""T7: distances between decisions from suprema of ratios."""

from __future__ import annotations

from itertools import permutations
from math import inf
from random import Random

import pytest
import tiers
from theorem_oracle import F, deployments, distance, pure, random_row, ratio

from fairaudit.errors import InputError
from fairaudit.measures.distances import demographic_parity, equalized_odds
from fairaudit.measures.ratios import global_supremum, local_supremum
from fairaudit.theorems.t02 import t2
from fairaudit.theorems.t03 import t3_approx
from fairaudit.theorems.t07 import t7, t7_pair


def one_sided(p: list[F], q: list[F]) -> F | float:
    return max(ratio(v, w) for v, w in zip(p, q, strict=True))


def test_distances_of_laws_are_below() -> None:
    for _, d in deployments(200, uses="decision"):
        law, _ = d.audited()
        local, overall, odds, parity = local_supremum(law), global_supremum(law), equalized_odds(law), demographic_parity(law)
        assert local is not None and overall is not None and odds is not None and parity is not None
        assert odds.value <= t7(local.ratio).value
        assert parity.value <= t7(overall.ratio, quantity="demographic_parity").value
        # Behind a pure filter, for every policy.
        assert odds.value <= t7(t2(pure(d.rows_a))).value
        if local.ratio != inf:
            assert t7(local.ratio).value <= local.ratio - 1


def test_pairs_are_below_the_one_sided_form_and_that_below_the_common_one() -> None:
    rng = Random(tiers.fresh("pairs"))
    for _ in range(600):
        size = rng.randint(1, 4)
        p, q = random_row(rng, size), random_row(rng, size)
        first, second = one_sided(p, q), one_sided(q, p)
        assert distance(p, q) <= t7_pair(first, second) <= t7(max(first, second)).value


def test_attained() -> None:
    p, q = [F(2, 3), F(1, 3)], [F(1, 3), F(2, 3)]
    assert distance(p, q) == t7(2).value == F(1, 3)
    p, q = [F(1, 2), F(1, 2)], [F(1, 4), F(3, 4)]
    assert distance(p, q) == t7_pair(2, F(3, 2)) == F(1, 4)
    p, q = [F(1), F(0)], [F(1, 2), F(1, 2)]
    assert distance(p, q) == t7_pair(2, inf) == t7_pair(inf, 2) == F(1, 2)


def test_ends() -> None:
    assert t7(inf).value == t7_pair(inf, inf) == 1
    assert t7(1).value == t7_pair(1, 1) == t7_pair(1, inf) == 0
    assert [t7_pair(a, b) for a, b in permutations((2, 3), 2)] == [F(2, 5)] * 2


def test_a_bound_for_one_utility_is_not_a_supremum() -> None:
    """T3 with t = 1 says R ≤ 1 for the utility at hand; the decisions may still differ completely."""
    with pytest.raises(InputError):
        t7(t3_approx(inf, 0, 1))
    with pytest.raises(InputError):
        t7(t2(2), quantity="demographic_parity")
    assert t7(t2(2)).multipliers == (2,)
