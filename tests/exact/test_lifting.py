"""Linear equations solved modulo powers of a prime, against Cramer's rule and elimination in fractions."""

from __future__ import annotations

import random
import sys
from fractions import Fraction
from itertools import permutations
from math import prod
from types import SimpleNamespace

import pytest
import tiers

from fairaudit.exact import lifting, linear_programs
from fairaudit.exact.lifting import MOST_UNKNOWNS, PRIME, solve_by_lifting
from fairaudit.exact.linear_programs import eliminate

F = Fraction
SIZES = (1, 3, 2**25, 2**26 - 1, 2**26, 2**52, 10**60)


@pytest.fixture(params=("lifted", "by FLINT"), autouse=True)
def way(request: pytest.FixtureRequest, monkeypatch: pytest.MonkeyPatch) -> None:
    if request.param == "lifted":
        monkeypatch.setattr(lifting, "_flint", lambda: None)
    else:
        pytest.importorskip("flint")
        monkeypatch.setattr(lifting, "_lifted", None)


def determinant(rows: list[list[int]]) -> int:
    """By Leibniz's formula."""
    total = 0
    for order in permutations(range(len(rows))):
        swaps = sum(a > b for i, a in enumerate(order) for b in order[i + 1 :])
        total += (-1) ** swaps * prod(row[j] for row, j in zip(rows, order, strict=True))
    return total


def some_rows(rng: random.Random, height: int, width: int, size: int) -> list[list[int]]:
    return [[rng.choice((0, rng.randint(-size, size))) for _ in range(width)] for _ in range(height)]


def test_square_equations_are_those_of_cramer() -> None:
    rng = random.Random(tiers.fresh(1))
    solved = singular = 0
    for _ in range(150):
        n, size = rng.randint(1, 4), rng.choice(SIZES)
        rows, right = some_rows(rng, n, n, size), [rng.randint(-size, size) for _ in range(n)]
        whole = determinant(rows)
        found = solve_by_lifting(rows, right)
        if whole == 0:
            singular += 1
            assert found is None
        else:
            solved += 1
            replaced = [[[b if k == j else v for k, v in enumerate(row)] for row, b in zip(rows, right, strict=True)] for j in range(n)]
            assert found == [F(determinant(table), whole) for table in replaced]
    assert tiers.enough(min(solved, singular) > 20)


@pytest.mark.parametrize("size", SIZES)
def test_more_equations_than_unknowns_agree_or_have_no_solution(size: int) -> None:
    rng = random.Random(tiers.fresh(size))
    n = 8
    solution = [F(rng.randint(-size, size), rng.randint(1, size)) for _ in range(n)]
    bottom = prod(v.denominator for v in solution)
    rows = some_rows(rng, n + 6, n, size)
    rows[3] = [2 * v for v in rows[1]]
    scaled = [[v * bottom for v in row] for row in rows]
    right = [int(sum(a * x for a, x in zip(row, solution, strict=True))) for row in scaled]
    assert solve_by_lifting(scaled, right) == solution
    for wrong in (3, n + 5):
        assert solve_by_lifting(scaled, [b + (i == wrong) for i, b in enumerate(right)]) is None


def test_what_has_several_solutions_or_is_too_large_is_left_to_others() -> None:
    assert solve_by_lifting([[1, 1]], [1]) is None
    assert solve_by_lifting([[1, 1], [2, 2]], [1, 2]) is None
    assert solve_by_lifting([[0]], [0]) is None
    assert solve_by_lifting([[PRIME]], [1]) is None
    assert solve_by_lifting([[PRIME + 1]], [1]) == [F(1, PRIME + 1)]
    many = MOST_UNKNOWNS + 1
    assert solve_by_lifting([[int(i == j) for j in range(many)] for i in range(many)], [1] * many) is None


def test_long_solutions_are_given_up_where_that_was_asked() -> None:
    long = 10**300 + 7
    assert solve_by_lifting([[long]], [1], most_bits=long.bit_length()) == [F(1, long)]
    assert solve_by_lifting([[long]], [1], most_bits=long.bit_length() - 1) is None
    assert solve_by_lifting([[1]], [long], most_bits=long.bit_length()) == [F(long)]
    assert solve_by_lifting([[1]], [long], most_bits=long.bit_length() - 1) is None
    assert solve_by_lifting([[long]], [1], most_bits=20) is None


def test_elimination_answers_the_same_whether_it_lifts_or_not(monkeypatch: pytest.MonkeyPatch) -> None:
    rng = random.Random(tiers.fresh(4))
    alone = refused = free = dropped = 0
    for _ in range(400):
        n = rng.randint(1, 7)
        height = max(1, n + rng.choice((-2, 0, 0, 2)))
        rows = [{j: F(rng.randint(-3, 3), rng.randint(1, 4)) for j in rng.sample(range(n), rng.randint(1, n))} for _ in range(height)]
        point = [F(rng.randint(-5, 5), rng.randint(1, 5)) for _ in range(n)]
        agreeing = rng.random() < 0.5
        equations = [(row, sum((a * point[j] for j, a in row.items()), F(0)) if agreeing else F(rng.randint(-3, 3))) for row in rows]
        guess = {j: F(rng.randint(-3, 3)) for j in range(n + 1)}
        needed = rng.choice((None, 0, height // 2))
        answers = []
        for patience, most in ((10**9, 500), (0, 0)):
            monkeypatch.setattr(linear_programs, "PATIENCE", patience)
            monkeypatch.setattr(linear_programs, "MOST_UNKNOWNS", most)
            answers.append((eliminate(equations, guess, needed), eliminate(equations, {}, needed)))
        assert answers[0] == answers[1]
        found, without = answers[0]
        refused += found is None
        free += found is not None and (without is None or len(without) < n)
        alone += n > 2 and without is not None and len(without) == n
        dropped += found is not None and any(sum(a * found[j] for j, a in row.items()) != bound for row, bound in equations)
    assert tiers.enough(min(alone, refused, free, dropped) > 20)


def test_full_equations_of_a_size_that_fractions_take_long_for() -> None:
    rng = random.Random(tiers.fresh(8))
    n = 60
    equations = [({j: F(rng.randint(-(2**30), 2**30), 7) for j in range(n)}, F(1)) for _ in range(n)]
    found = eliminate(equations, {})
    assert found is not None
    assert all(sum(a * found[j] for j, a in row.items()) == bound for row, bound in equations)
    assert eliminate(equations, {}, most_bits=100) is None


def test_a_module_of_that_name_is_not_believed(monkeypatch: pytest.MonkeyPatch) -> None:
    rows, right = [[2, 1], [1, 3]], [1, 1]
    flint = pytest.importorskip("flint")
    wrong = SimpleNamespace(nmod_mat=flint.nmod_mat, fmpz_mat=lambda rows: flint.fmpz_mat([[len(row) * v for v in row] for row in rows]))
    monkeypatch.undo()
    monkeypatch.setitem(sys.modules, "flint", wrong)
    assert solve_by_lifting(rows, right) is None
    monkeypatch.setitem(sys.modules, "flint", SimpleNamespace())
    assert solve_by_lifting(rows, right) == [F(2, 5), F(1, 5)]
    monkeypatch.setitem(sys.modules, "flint", None)
    assert solve_by_lifting(rows, right) == [F(2, 5), F(1, 5)]
