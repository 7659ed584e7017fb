"""Ratios of times that `fairaudit.privacy` promises, measured in one run. Not a test: nothing passes or fails on time.

Run: python tests/benchmarks/privacy.py
"""

from __future__ import annotations

from fractions import Fraction
from typing import Any

import numpy as np
from timing import median

from fairaudit.model.mechanism import Mechanism, Product, RandomizedResponse
from fairaudit.privacy.pair_table import per_pair

K = Fraction(3, 2)


def plain(table: list[list[Fraction]]) -> list[tuple[Any, Fraction]]:
    """e^ε and δ of every ordered pair, one fraction at a time."""
    found: list[tuple[Any, Fraction]] = []
    for i, first in enumerate(table):
        for j, second in enumerate(table):
            if i != j:
                ratio: Any = max((p / q if q else float("inf")) for p, q in zip(first, second, strict=True) if p or q)
                found.append((ratio, sum((max(Fraction(0), p - K * q) for p, q in zip(first, second, strict=True)), Fraction(0))))
    return found


def dense(size: int, denominator: int, generator: np.random.Generator) -> Mechanism:
    rows = []
    for _ in range(size):
        weights = [int(v) for v in generator.integers(1, 1000, size)]
        weights = [v * denominator // sum(weights) for v in weights]
        weights[0] += denominator - sum(weights)
        rows.append([Fraction(v, denominator) for v in weights])
    return Mechanism.from_array(rows, list(range(size)))


def main() -> None:
    generator = np.random.default_rng(1)
    part = RandomizedResponse("abcd", keep_probability="0.7")
    for name, mechanism in (
        ("product of three 4-ary responses", Product({"a": part, "b": part, "c": part})),
        ("dense 64 x 64, denominator 10^5", dense(64, 10**5, generator)),
        ("dense 64 x 64, denominator 10^30", dense(64, 10**30, generator)),
    ):
        table = [[Fraction(v, mechanism.denominator) for v in mechanism.row(a)] for a in mechanism.inputs]
        assert [(p.exp_epsilon, p.delta) for p in per_pair(mechanism, K)] == plain(table)
        ours = median(lambda mechanism=mechanism: list(per_pair(mechanism, K)), 5)
        theirs = median(lambda table=table: plain(table), 1)
        print(f"4,032 ordered pairs, {name:<34} {ours:.4f} s, fractions {theirs:.3f} s   {theirs / ours:.0f} x faster (at least 5)")


if __name__ == "__main__":
    main()
