"""Distances between many laws at once."""

import random
from fractions import Fraction

import pytest
import tiers
from plain_certificates import checker


@pytest.mark.parametrize("decisions", [3, 5])
def test_screen_leaves_out_no_pair_that_matters(decisions: int) -> None:
    for seed in range(40):
        pick = random.Random(tiers.fresh(seed))
        laws = []
        for _ in range(60):
            weights = [pick.choice([0, 1, 2, pick.randint(0, 10**9)]) for _ in range(decisions)]
            weights[pick.randrange(decisions)] += 1
            laws.append(checker.laws.reduced_law(weights, sum(weights)))
        fractions = [[Fraction(w, total) for w in weights] for weights, total in laws]
        distances = {
            (i, j): sum((max(Fraction(0), p - q) for p, q in zip(fractions[i], fractions[j], strict=True)), Fraction(0))
            for i in range(60)
            for j in range(i + 1, 60)
        }
        most = max(distances.values())
        (n, d), i, j = checker.laws.widest_distance(laws)
        assert Fraction(n, d) == most and (i, j) == min(pair for pair, value in distances.items() if value == most)
