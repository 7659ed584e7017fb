"""Ratios of times that the worst-case search promises, measured in one run. Not a test: nothing passes or fails on time.

Run: python tests/benchmarks/worst_case.py
"""

from __future__ import annotations

from typing import Any

import numpy as np
from timing import median

from fairaudit import Law
from fairaudit.model.utility_class import UtilityClass
from fairaudit.worst.methods import worst_case


def bare(table: Any) -> None:
    """Sort the likelihood ratios of all ordered pairs and add up both rows in that order, and nothing else."""
    rows = table / table.sum(axis=-1, keepdims=True)
    for begin in range(0, len(rows), 50):
        block = rows[begin : begin + 50]
        first, second = np.broadcast_arrays(block[:, :, None], block[:, None])
        with np.errstate(divide="ignore", invalid="ignore"):
            order = np.argsort(first / second, axis=-1)
        np.cumsum(np.take_along_axis(first, order, -1), axis=-1)
        np.cumsum(np.take_along_axis(second, order, -1), axis=-1)


def main() -> None:
    generator = np.random.default_rng(1)
    table = generator.integers(0, 1000, (1000, 30, 20))
    law = Law.from_array(table, kind="counts")
    reference = median(lambda: bare(table), 3)
    print(f"1,000 contexts x 30 groups x 20 decisions, all ordered pairs: sorting alone {reference:.3f} s")
    for tau, m in (("0.3", 0), ("0.3", "0.1"), ("0.01", 0), (None, "0.2"), (None, 0)):
        found = worst_case(law, UtilityClass(tau=tau, m=m))
        taken = median(lambda tau=tau, m=m: worst_case(law, UtilityClass(tau=tau, m=m)))
        proof = median(lambda found=found: found.proof(), 3)
        print(f"  tau {tau!s:<5} m {m!s:<4} {taken:.3f} s   {taken / reference:.2f} x sorting (at most 1.5); its proof {proof:.4f} s")
    pair = Law.from_array(generator.integers(1, 1000, (2, 100)), kind="counts")
    many = Law.from_array(generator.integers(1, 1000, (200, 20, 100)), kind="counts")
    order = [(pair.decisions[0], pair.decisions[0])]
    program = median(lambda: worst_case(pair, UtilityClass(tau="0.3", order=order))) / 2
    closed = median(lambda: worst_case(many, UtilityClass(tau="0.3"))) / (200 * 20 * 19)
    alone = median(lambda: solve_lp(pair))
    print(f"one pair at n = 100: closed form {closed * 1e6:.2f} us, bare HiGHS {alone * 1e3:.2f} ms, {alone / closed:.0f} x (at least 100)")
    print(f"one pair at n = 100 as a program of ours: {program * 1e3:.2f} ms, {program / alone:.2f} x bare HiGHS")


def solve_lp(law: Law) -> None:
    from scipy.optimize import linprog

    p, q = (law.weights / law.weights.sum(axis=1, keepdims=True)).tolist()
    n = len(p)
    sides = np.hstack((np.eye(n), -np.ones((n, 1))))
    floor = np.append(-np.array(q), 0.3)
    linprog(-np.append(p, 0.0), A_ub=np.vstack((floor, sides)), b_ub=np.zeros(n + 1), A_eq=[[*q, 0.0]], b_eq=[1.0], method="highs")


if __name__ == "__main__":
    main()
