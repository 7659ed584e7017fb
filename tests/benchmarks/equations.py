"""Linear equations in rationals: elimination that may lift, and one that may ask FLINT where it is installed, beside fractions alone.

Run: python tests/benchmarks/equations.py
"""

from __future__ import annotations

import random
import time
from collections.abc import Callable
from fractions import Fraction
from functools import partial
from importlib.util import find_spec
from typing import Any
from unittest.mock import patch

from timing import median

from fairaudit.exact import lifting, linear_programs
from fairaudit.exact.linear_programs import eliminate

SIZES = ((10, 10, 10), (20, 20, 10), (20, 20, 60), (40, 40, 20), (80, 80, 10), (80, 80, 60), (100, 4, 20), (100, 8, 20), (200, 6, 20))


def main() -> None:
    rng = random.Random(1)
    patience = linear_programs.PATIENCE
    for unknowns, each, bits in SIZES:
        places = [{i, *rng.sample(range(unknowns), each - 1)} for i in range(unknowns)]
        equations = [({j: Fraction(rng.randint(-(2**bits), 2**bits)) for j in row}, Fraction(rng.randint(-9, 9))) for row in places]
        linear_programs.PATIENCE = 10**12
        fractions = taken(partial(eliminate, equations, {}), 1)
        linear_programs.PATIENCE = patience
        with_flint = taken(partial(eliminate, equations, {}))
        with patch.object(lifting, "_flint", lambda: None):
            ours = taken(partial(eliminate, equations, {}))
        line = f"{unknowns} unknowns, {each} in each equation, {bits} bits: fractions {fractions:.4f} s, lifted 1/{fractions / ours:.1f}"
        print(line + (f", by FLINT 1/{fractions / with_flint:.1f}" if find_spec("flint") else ""), flush=True)


def taken(work: Callable[[], Any], repeats: int = 3) -> float:
    """Processor time."""
    return median(work, repeats, time.process_time)


if __name__ == "__main__":
    main()
