"""T9: less privacy is never fairer, along randomized response."""

from __future__ import annotations

from itertools import pairwise

import pytest
from theorem_oracle import F, deployments, kron, response_rows, table_filter

Table = list[list[F]]


def product(one: Table, two: Table) -> Table:
    return [[sum((v * two[j][k] for j, v in enumerate(row)), F(0)) for k in range(len(two[0]))] for row in one]


@pytest.mark.parametrize("k", [2, 3, 6])
def test_randomized_response_degrades_into_itself(k: int) -> None:
    for keep, less in ((F(9, 10), F(3, 4)), (F(1), F(1, k)), (F(3, 4), F(3, 4)), (F(4, 5), F(1, k) + F(1, 50))):
        # RR(keep) = diagonal·identity + rest: the noise N has diagonal part less'/keep'.
        part, target = ((k * p - 1) / (k - 1) for p in (keep, less))
        scale = target / part
        noise = [[(1 - scale) / k + (scale if i == j else 0) for j in range(k)] for i in range(k)]
        assert all(v >= 0 for row in noise for v in row) and all(sum(row) == 1 for row in noise)
        assert product(noise, response_rows(k, keep)) == response_rows(k, less)


@pytest.mark.parametrize("kind", ["one", "two"])
def test_the_local_ratio_grows_with_the_keep_probability_and_so_does_the_global_one_under_independence(kind: str) -> None:
    for rng, d in deployments(120, uses="context", independent=True):
        k = rng.choice([2, 3]) if kind == "one" else 4
        d.policy = [[rng.choice(block) for _ in range(k)] for block in d.policy]
        d.utility = [[block[0]] * k for block in d.utility]
        masses = [F(rng.randint(1, 4)) for _ in range(k)]
        d.population = [[F(i + 1) * m for m in masses] for i in d.contexts]
        local, overall = [], []
        least = F(1, k) if kind == "one" else F(1, 2)
        for keep in (least, least + (1 - least) / 4, least + (1 - least) / 2, F(1)):
            rows = response_rows(k, keep) if kind == "one" else kron(response_rows(2, keep), response_rows(2, F(3, 4)))
            d.rows_a, d.mechanism = rows, table_filter(rows)
            local.append(d.local)
            overall.append(d.overall)
        assert all(low <= high for low, high in pairwise(local))
        assert all(low <= high for low, high in pairwise(overall))


def test_without_independence_the_global_ratio_can_fall() -> None:
    falls = 0
    for rng, d in deployments(200, uses="context", masses=False):
        k = len(d.rows_a)
        d.policy = [[rng.choice(block) for _ in range(k)] for block in d.policy]
        found = []
        for keep in (F(1, k), F(1)):
            d.rows_a = response_rows(k, keep)
            found.append(d.overall)
        falls += found[1] < found[0]
    assert falls
