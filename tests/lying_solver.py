"""A solver of linear programs that lies: whatever it says, nothing false may be concluded, and nothing but a refusal be raised."""

from __future__ import annotations

import random
from math import inf, nan
from typing import Any

import numpy as np
import pytest

from fairaudit.exact import linear_programs
from fairaudit.exact.linear_programs import solve_with_highs

LIES = (
    *("raises", "imports", "nothing", "scaled", "zeroed", "sign", "noise", "garbage", "nan", "inf", "huge", "largest"),
    *("shape", "long", "point", "table", "scalar", "words", "one part", "solved"),
)


def corrupt(rng: random.Random, way: str, given: Any, answer: Any) -> Any:
    """An answer, made wrong in one way."""
    if way in ("raises", "imports"):
        raise {"raises": ArithmeticError, "imports": ImportError}[way]("no")
    if way == "solved" and answer is None:
        return np.full(len(given[0]), 0.5), np.full(len(given[2]), 0.5)
    if way == "nothing" or answer is None:
        return None
    x, y = (np.array(part) for part in answer)
    with np.errstate(all="ignore"):
        wrong = {
            "scaled": lambda: (x, y * 10.0 ** rng.randint(-6, 6)),
            "zeroed": lambda: (x, y * np.array([rng.choice([0, 1]) for _ in y])),
            "sign": lambda: (x, y * np.array([rng.choice([-1, 1]) for _ in y])),
            "noise": lambda: (x, y + np.array([rng.gauss(0, 0.1) for _ in y])),
            "garbage": lambda: (np.array([rng.uniform(-10, 10) for _ in x]), np.array([rng.uniform(-10, 10) for _ in y])),
            "nan": lambda: (x, y * nan),
            "inf": lambda: (x * inf, y),
            "huge": lambda: (x * 1e150, y * 1e150),
            "largest": lambda: (x + 1e308, y + 1e308),
            "shape": lambda: (x, y[:-1]),
            "long": lambda: (np.append(x, 0.0), y),
            "point": lambda: (x + np.array([rng.gauss(0, 0.1) for _ in x]), y),
            "table": lambda: (x[:, None], y[:, None]),
            "scalar": lambda: (x.sum(), y.sum()),
            "words": lambda: (["yes"] * len(x), ["no"] * len(y)),
            "one part": lambda: (x,),
            "solved": lambda: (x, y),
        }
        return wrong[way]()


def lying(patch: pytest.MonkeyPatch, rng: random.Random, way: str) -> None:
    """Let every answer of the solver be wrong in one way, until the patch is undone."""

    def solve(*given: Any) -> Any:
        return corrupt(rng, way, given, solve_with_highs(*given))

    patch.setattr(linear_programs, "solve_with_highs", solve)
