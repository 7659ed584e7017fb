"""Ratios of times that the core promises, measured in one run. Not a test: nothing passes or fails on time.

Run: python tests/benchmarks/core.py
"""

from __future__ import annotations

from typing import Any

import numpy as np
from timing import median

from fairaudit import Law, Utility, certify


def main() -> None:
    generator = np.random.default_rng(1)
    for shape in ((100, 100, 100), (1000, 10, 100), (5000, 100, 2), (50_000, 2, 10)):
        for kind in ("counts", "probabilities"):
            table = generator.integers(0, 1000, shape) if kind == "counts" else generator.dirichlet(np.ones(shape[2]), shape[:2])
            same = np.broadcast_to(table[:1, :1], shape).copy()
            times = [median(lambda array=array, kind=kind: audit(array, kind), 3) for array in (table, same)]
            print(
                f"1e6 cells {shape!s:<16} {kind:<14} random {times[0]:.3f} s, all rows equal {times[1]:.3f} s   "
                f"{times[1] / times[0]:.2f} x (at most 6)"
            )


def audit(array: Any, kind: Any) -> None:
    law = Law.from_array(array, kind=kind)
    certify(law, Utility({u: i for i, u in enumerate(law.decisions)}))


if __name__ == "__main__":
    main()
