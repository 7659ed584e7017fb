"""T6: the supremum of the ratio over utilities."""

from __future__ import annotations

from itertools import permutations
from math import inf

from theorem_oracle import Deployment, F, deployments, ratio, response_rows, table_filter

from fairaudit.measures.ratios import global_supremum, local_supremum


def test_the_supremum_over_utilities_that_ignore_the_group_is_a_ratio_of_probabilities() -> None:
    for rng, d in deployments(150, uses="context"):
        law, _ = d.audited()
        found = local_supremum(law)
        expected = max(
            (ratio(p, q) for x in d.contexts for a, b in permutations(d.groups, 2) for p, q in zip(d.law(x, a), d.law(x, b), strict=True)),
            default=F(1),
        )
        assert found is not None
        assert found.ratio == expected
        assert d.local <= expected
        for _ in range(3):
            d.utility = [[[F(rng.randint(0, 3)) for _ in d.decisions]] * len(d.rows_a) for _ in d.contexts]
            assert d.local <= expected
        attained = []
        for u in d.decisions:
            d.utility = [[[F(int(v == u)) for v in d.decisions]] * len(d.rows_a)] * len(d.rows_x)
            attained.append(d.local)
        assert max(attained) == expected


def test_globally_the_utility_must_depend_on_the_decision_alone() -> None:
    beyond = 0
    for rng, d in deployments(150, uses="decision"):
        law, _ = d.audited()
        found = global_supremum(law)
        rows = [d.mixture(a) for a in d.groups]
        expected = max(ratio(v, w) for p, q in permutations(rows, 2) for v, w in zip(p, q, strict=True))
        assert found is not None
        assert found.ratio == expected
        for _ in range(3):
            base = [F(rng.randint(0, 3)) for _ in d.decisions]
            d.utility = [[base] * len(d.rows_a)] * len(d.rows_x)
            assert d.overall <= expected
        d.utility = [[[F(rng.randint(0, 3)) for _ in d.decisions]] * len(d.rows_a) for _ in d.contexts]
        beyond += d.overall > expected
    assert beyond


def test_a_utility_of_the_group_has_no_finite_supremum() -> None:
    """The paper's class g(u,x,a): one decision, everyone treated alike, and a ratio of any size."""
    rows = response_rows(2, F(1, 2))
    for size in (2, 1000, 10**9):
        d = Deployment([[[F(1)], [F(1)]]], [[F(1)]], rows, [[[F(size)], [F(1)]]], [[F(1), F(1)]], table_filter(rows))
        assert d.local == size
    d.utility = [[[F(1)], [F(0)]]]
    assert d.local == inf
    law, _ = d.audited()
    found = local_supremum(law)
    assert found is not None and found.ratio == 1
