"""Linear equations in rationals, solved modulo powers of a prime (Dixon).

The inverse of the matrix modulo p gives the solution modulo p, then modulo p², and so on, each time for the price of two products with
a vector, of numbers of the machine's size. Rationals are read off once they are short beside the power, and believed only if they
satisfy every equation in integers: what is returned is the solution, whatever happened on the way to it. Where FLINT is installed
(the extra ``flint``) it is asked for the same solution of the same equations, and believed as little.
"""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction
from importlib import import_module
from math import inf, isqrt, lcm
from typing import Any

import numpy as np
from numpy.typing import NDArray

Integers = NDArray[np.int64]

LIMB = 26
"""Bits of the parts in which integers are multiplied: sums of 2,047 products of two of them are below 2^63."""

PRIME = 2**LIMB - 5

MOST_UNKNOWNS = 500
"""The inverse is dense, and its time grows with the cube of this."""

MOST_LIMBS = 8_000_000
"""Parts of all numbers of the matrix, of 8 bytes each."""

SPARE = 64
"""Bits by which a rational must be shorter than the modulus to be taken for more than chance."""


def solve_by_lifting(rows: Sequence[Sequence[int]], right: Sequence[int], most_bits: float = inf) -> list[Fraction] | None:
    """Solve A·x = b for integers where it has exactly one solution.

    None if it has none or several, if the solution over one denominator has a number longer than `most_bits`, if the matrix is too
    large, or of lower rank modulo the prime; it is for others to say which.

    Examples
    --------
    >>> solve_by_lifting([[2, 1], [1, 3], [3, 4]], [1, 1, 2])
    [Fraction(2, 5), Fraction(1, 5)]
    """
    count = len(rows[0])
    limbs = -(-max(v.bit_length() for row in rows for v in row) // LIMB)
    if not count <= len(rows) < 2 * MOST_UNKNOWNS or count > MOST_UNKNOWNS or limbs * len(rows) * count > MOST_LIMBS:
        return None
    flint = _flint()
    found = _lifted(rows, right, limbs, most_bits) if flint is None else _solved_by(flint, rows, right)
    if found is None or not _satisfied(rows, right, range(len(rows)), *found):
        return None
    tops, bottom = found
    return [Fraction(v, bottom) for v in tops] if max(v.bit_length() for v in (bottom, *tops)) <= most_bits else None


def _flint() -> Any:
    """The library, where a release of it with what is needed is installed; else None."""
    try:
        flint = import_module("flint")
    except ImportError:
        return None
    return flint if hasattr(flint, "fmpz_mat") and hasattr(flint, "nmod_mat") else None


def _solved_by(flint: Any, rows: Sequence[Sequence[int]], right: Sequence[int]) -> tuple[list[int], int] | None:
    """What FLINT says is the solution of as many equations as are independent modulo the prime, over the least denominator."""
    count = len(rows[0])
    echelon, rank = flint.nmod_mat([[v % PRIME for v in column] for column in zip(*rows, strict=True)], PRIME).rref()
    if rank < count:
        return None
    chosen = [next(i for i, v in enumerate(line) if int(v)) for line in echelon.tolist()]
    values = flint.fmpz_mat([list(rows[i]) for i in chosen]).solve(flint.fmpz_mat([[right[i]] for i in chosen])).entries()
    bottom = lcm(*(int(v.q) for v in values))
    return [int(v.p) * (bottom // int(v.q)) for v in values], bottom


def _lifted(rows: Sequence[Sequence[int]], right: Sequence[int], limbs: int, most_bits: float) -> tuple[list[int], int] | None:
    """The solution of as many equations as are independent modulo the prime, over one denominator; None if it is too long."""
    found = _inverse(np.array([[v % PRIME for v in row] for row in rows], dtype=np.int64))
    if found is None:
        return None
    chosen, inverse = found
    parts = _limbs([rows[i] for i in chosen], limbs)
    rest = [right[i] for i in chosen]
    digits: list[Integers] = []
    while True:
        for _ in range(max(4, len(digits))):
            digit = inverse @ np.array([v % PRIME for v in rest], dtype=np.int64) % PRIME
            products = [(part @ digit).tolist() for part in parts]
            for place, product in enumerate(products):
                rest = [v - (w << LIMB * place) for v, w in zip(rest, product, strict=True)]
            rest = [v // PRIME for v in rest]
            digits.append(digit)
        modulus = PRIME ** len(digits)
        read = _rationals(_joined(digits), modulus)
        if read is not None and _satisfied(rows, right, chosen, *read):
            return read
        if modulus.bit_length() > 2 * most_bits + SPARE + 2:
            return None


def _inverse(matrix: Integers) -> tuple[list[int], Integers] | None:
    """Rows that are independent modulo the prime, and the inverse of them; None if there are fewer than columns."""
    height, width = matrix.shape
    table = np.concatenate((matrix, np.eye(height, dtype=np.int64)), axis=1)
    order = list(range(height))
    for j in range(width):
        nonzero = np.flatnonzero(table[j:, j])
        if not len(nonzero):
            return None
        i = j + int(nonzero[0])
        table[[i, j]] = table[[j, i]]
        order[i], order[j] = order[j], order[i]
        table[j] = table[j] * pow(int(table[j, j]), -1, PRIME) % PRIME
        others = np.flatnonzero(table[:, j])
        others = others[others != j]
        places = np.flatnonzero(table[j])
        at = np.ix_(others, places)
        table[at] = (table[at] - table[others, j, None] * table[j, places]) % PRIME
    chosen = order[:width]
    return chosen, np.ascontiguousarray(table[:width, [width + i for i in chosen]])


def _limbs(rows: Sequence[Sequence[int]], limbs: int) -> list[Integers]:
    """Integers as parts of `LIMB` bits with their sign, least first."""
    mask = 2**LIMB - 1
    signs = np.array([[-1 if v < 0 else 1 for v in row] for row in rows], dtype=np.int64)
    return [signs * np.array([[abs(v) >> LIMB * k & mask for v in row] for row in rows], dtype=np.int64) for k in range(limbs)]


def _joined(digits: Sequence[Integers]) -> list[int]:
    """Σ digit·p^k of each unknown, by halves."""
    parts: list[Any] = [digit.astype(object) for digit in digits]
    base = PRIME
    while len(parts) > 1:
        parts = [low + high * base for low, high in zip(parts[::2], parts[1::2], strict=True)]
        base *= base
    found: list[int] = parts[0].tolist()
    return found


def _rationals(residues: Sequence[int], modulus: int) -> tuple[list[int], int] | None:
    """Numerators over one denominator that agree with residues and are much shorter than the modulus; None if there are none."""
    limit = modulus.bit_length() - SPARE
    most = isqrt(modulus) >> SPARE // 2
    bottom, tops = 1, []
    for residue in residues:
        value = residue * bottom % modulus
        value -= modulus if 2 * value > modulus else 0
        factor = 1
        if abs(value) > most:
            before, now, left, factor = modulus, value % modulus, 0, 1
            while now > most:
                quotient = before // now
                before, now, left, factor = now, before - quotient * now, factor, left - quotient * factor
            if factor < 0:
                now, factor = -now, -factor
            value = now
        tops.append((value, bottom * factor))
        bottom *= factor
        if value.bit_length() + bottom.bit_length() > limit:
            return None
    return [value * (bottom // under) for value, under in tops], bottom


def _satisfied(rows: Sequence[Sequence[int]], right: Sequence[int], which: Sequence[int], tops: Sequence[int], bottom: int) -> bool:
    """Whether rationals satisfy equations, exactly."""
    return all(sum(a * v for a, v in zip(rows[i], tops, strict=True) if a) == right[i] * bottom for i in which)
