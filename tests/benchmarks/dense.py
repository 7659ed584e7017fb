"""Dense laws of a hundred million cells against one product of numpy alone. Nothing passes or fails on time.

Run: python tests/benchmarks/dense.py [--contexts 1000] [--groups 100] [--decisions 1000]
"""

from __future__ import annotations

import argparse

import numpy as np
from timing import median

from fairaudit import Law, Utility
from fairaudit.measures.ratios import global_fairness, local_fairness


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    for name, size in (("contexts", 1000), ("groups", 100), ("decisions", 1000)):
        parser.add_argument(f"--{name}", type=int, default=size)
    options = parser.parse_args()
    shape = (options.contexts, options.groups, options.decisions)
    generator = np.random.default_rng(1)
    for kind in (np.float64, np.float32):
        table = generator.random(shape, dtype=kind)
        table /= table.sum(axis=2, keepdims=True)
        same = np.broadcast_to(table[:1, :1], shape).copy()
        g = np.linspace(0, 1, shape[2]).astype(kind)
        for name, array in (("random", table), ("all rows equal", same)):
            law = Law.from_array(array)
            utility = Utility({u: i for i, u in enumerate(law.decisions)}).on(law)
            alone = median(lambda array=array, g=g: np.vecdot(array, g))
            read = median(lambda array=array: Law.from_array(array))
            found = median(lambda law=law, utility=utility: local_fairness(law, utility))
            over = median(lambda law=law, utility=utility: global_fairness(law, utility), 1)
            print(
                f"{shape} {np.dtype(kind).name} {name:<15} vecdot {alone:.3f} s, reading {read:.3f} s, local ratio {found:.3f} s: "
                f"{found / alone:.2f} x; global ratio {over:.3f} s",
                flush=True,
            )


if __name__ == "__main__":
    main()
