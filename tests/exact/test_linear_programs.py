"""Linear programs: weak duality against exact optima, elimination against its own equations, and answers that are none."""

from __future__ import annotations

import random
from fractions import Fraction
from itertools import product
from math import inf
from typing import Any

import numpy as np
import pytest
import tiers
from lying_solver import LIES, lying
from worst_oracle import exact_program

from fairaudit.exact.linear_programs import LARGEST, LinearProgram, eliminate, rounded_multipliers, solver_float

F = Fraction


def some_program(rng: random.Random, simplices: bool) -> LinearProgram:
    n = rng.randint(2, 4)
    parts = [range(n), range(n, 2 * n)] if simplices else []
    n *= 2 if simplices else 1
    rows = [([(j, F(rng.randint(-3, 3))) for j in range(n) if rng.random() < 0.7], F(rng.randint(-2, 5))) for _ in range(rng.randint(1, 5))]
    low = [F(0) if simplices else F(rng.randint(-2, 0)) for _ in range(n)]
    high = [F(1) if simplices else v + rng.randint(0, 3) for v in low]
    return LinearProgram(low, high, rows, parts, range(n) if simplices else range(0))


def optimum(program: LinearProgram, objective: dict[int, Fraction]) -> Any:
    """The exact optimum by another solver; None if there is no point."""
    n = len(program.low)
    box = [({j: F(-1)}, -program.low[j]) for j in range(n)]
    box += [({j: F(1)}, program.high[j]) for j in range(n) if j not in program.unbounded]
    rows = [({j: sum((a for i, a in terms if i == j), F(0)) for j, _ in terms}, bound) for terms, bound in program.rows]
    return exact_program([*rows, *box], [(dict.fromkeys(part, F(1)), F(1)) for part in program.distributions], objective)


@pytest.mark.parametrize("simplices", [False, True])
def test_weak_duality_bounds_every_optimum(simplices: bool) -> None:
    rng = random.Random(tiers.fresh(3))
    tight = empty = 0
    for _ in range(60):
        program = some_program(rng, simplices)
        objective = {j: F(rng.randint(-4, 4)) for j in range(len(program.low))}
        best = optimum(program, objective)
        for _ in range(5):
            multipliers = {i: F(rng.randint(0, 8), 4) for i in range(len(program.rows)) if rng.random() < 0.7}
            bound = program.dual_bound(objective, multipliers)
            assert best is None or best <= bound
            assert best is None or program.emptiness(multipliers) <= 0
        found = program.ask(-np.array([float(v) for v in objective.values()]))
        assert (found is None) == (best is None)
        if found is not None:
            bound = program.dual_bound(objective, rounded_multipliers(found[1]))
            assert best <= bound
            tight += bound - best < F(1, 10**9)
        else:
            empty += 1
    assert tiers.enough(tight > 20)
    assert empty


def test_what_is_unbounded_is_not_bounded() -> None:
    program = LinearProgram([F(0), F(0)], [F(1), F(1)], [([(0, F(1)), (1, F(1))], F(3))], (), range(1, 2))
    assert program.dual_bound({0: F(1), 1: F(1)}, {}) == inf
    assert program.dual_bound({0: F(1), 1: F(1)}, {0: F(1)}) == 3
    assert program.dual_bound({0: F(10) ** 400, 1: F(1)}, {}) == inf
    assert program.emptiness({0: F(1)}) < 0


def test_feasible_is_exact() -> None:
    program = LinearProgram([F(0)] * 2, [F(1)] * 2, [([(0, F(3))], F(1))], [range(2)], range(2))
    assert program.feasible([F(1, 3), F(2, 3)])
    tiny = F(1, 10**400)
    assert not program.feasible([F(1, 3) + tiny, F(2, 3) - tiny])
    assert not program.feasible([F(1, 3) - tiny, F(2, 3)])
    assert not program.feasible([F(-1), F(2)])


def test_elimination_solves_what_it_was_given() -> None:
    rng = random.Random(tiers.fresh(5))
    solved = refused = free = 0
    for _ in range(300):
        n = rng.randint(1, 5)
        equations = [
            ({j: F(rng.randint(-2, 2), rng.randint(1, 3)) for j in range(n)}, F(rng.randint(-2, 2))) for _ in range(rng.randint(1, 6))
        ]
        guess = {j: F(rng.randint(-3, 3)) for j in range(n)}
        found = eliminate(equations, guess)
        if found is None:
            refused += 1
            continue
        solved += 1
        for terms, bound in equations:
            assert sum(a * found[j] for j, a in terms.items()) == bound
        alone = eliminate(equations, {})
        if alone is None or len(alone) < n:
            free += 1
            assert eliminate([*equations, ({0: F(1)}, found[0])], found) == found
        else:
            assert alone == found
    assert tiers.enough(min(solved, refused, free) > 20)


def test_elimination_gives_up_long_numbers() -> None:
    rng = random.Random(tiers.fresh(6))
    equations = [({j: F(rng.randrange(10**40), rng.randrange(1, 10**40)) for j in range(6)}, F(1)) for _ in range(6)]
    assert eliminate(equations, {}, most_bits=300) is None
    assert eliminate(equations, {}) is not None


@pytest.mark.parametrize("way", LIES)
def test_an_answer_is_numbers_of_the_right_shape_or_none(way: str, monkeypatch: pytest.MonkeyPatch) -> None:
    program = LinearProgram([F(0)] * 2, [F(1)] * 2, [([(0, F(1)), (1, F(1))], F(1))])
    lying(monkeypatch, random.Random(tiers.fresh(1)), way)
    found = program.ask(np.array([-1.0, -2.0]))
    if way in ("raises", "imports", "nothing", "nan", "inf", "largest", "shape", "long", "table", "scalar", "words", "one part"):
        assert found is None
    else:
        point, multipliers = found
        assert point.shape == (2,)
        assert multipliers.shape == (1,)
        assert (np.abs(np.append(point, multipliers)) <= 1e200).all()


def test_numbers_beyond_floats_reach_the_solver_as_large_ones() -> None:
    assert [solver_float(s * F(10) ** 5000) for s in (1, -1)] == [1e200, -1e200]
    assert solver_float(F(1, 10**5000)) == 0
    assert float(LARGEST) == 1e200
    for low, bound in product((F(0), F(10) ** 400), (F(1), F(10) ** 400)):
        program = LinearProgram([low], [low + 1], [([(0, F(10) ** 400)], bound)])
        program.ask(np.array([1.0]))
        assert program.dual_bound({0: F(1)}, {}) == low + 1
