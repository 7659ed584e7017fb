"""A population that is itself a sample."""

from __future__ import annotations

from random import Random

import pytest
from interval_oracle import (
    F,
    sampled_policy,
)

from fairaudit import RandomizedResponse, Utility
from fairaudit.errors import InputError
from fairaudit.inference.estimated_population import sampled_population_interval
from fairaudit.inference.policy_comparisons import policy_comparison
from fairaudit.inference.ratio_intervals import ratio_interval


def test_estimated_population() -> None:
    policy = sampled_policy()
    group = RandomizedResponse(["f", "m", "o"], keep_probability="0.9")
    comparison = policy_comparison(policy, Utility({"yes": 1}), group)
    counts = [[400, 300, 100], [200, 300, 500]]
    found = sampled_population_interval(comparison, counts)
    assert found.lower <= found.estimate <= found.upper
    table = {
        (x, a): F(counts[i][j], sum(row[j] for row in counts)) for i, x in enumerate([("P",), ("Q",)]) for j, a in enumerate(group.inputs)
    }
    known = ratio_interval(policy_comparison(policy, Utility({"yes": 1}), group, None, table, local=False))
    assert found.estimate == known.estimate
    assert found.upper > known.upper
    more = sampled_population_interval(comparison, [[10**6 * n for n in row] for row in counts])
    assert more.upper < found.upper
    # Every population and every mean within the evidence's ends is covered.
    ends = [(F(a), F(b)) for a, b in found.evidence["ends"]]
    random = Random(1)
    for _ in range(200):
        h = [random.choice(pair) for pair in ends]
        means = []
        for a, shares in enumerate(found.evidence["population"]):
            (lo, hi), other = ((F(v) for v in pair) for pair in shares)
            lo2, hi2 = other
            p = random.choice([max(lo, 1 - hi2), min(hi, 1 - lo2)])
            form = [sum(w * h[i] for i, w in block[a]) for block in comparison.blocks]
            means.append(p * form[0] + (1 - p) * form[1])
        assert max(means) / min(means) <= found.upper
    for bad in ([[1, 2, 3]], [[1, 2], [3, 4]], [[1, 2, 0], [1, 1, 0]], [[1.5, 1, 1], [1, 1, 1]]):
        with pytest.raises(InputError):
            sampled_population_interval(comparison, bad)
