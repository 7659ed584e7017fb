"""Tails and ends of cells in floats, by the formulas of the exact ones: for searches and plans, never for conclusions."""

from __future__ import annotations

from math import exp, lgamma, log, log1p, pi, sqrt
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from fairaudit.exact.dense import Floats
from fairaudit.inference.tails import EXACT_DRAWS

STEPS = 36  # of a bisection of [0, 1], whose last one is far less than what a draw moves an end by

SMALL = 1e-17  # of a sum: what its double does not notice

TOLERANCE = 1e-10  # relative: a thousandth of what an end is rounded to


def float_end(n: float, k: float, level: float, binary: bool, side: Literal["lower", "upper"]) -> float:
    """An end in floats: a guess, from which an exact search starts."""
    if binary and n <= EXACT_DRAWS:
        return _least_mean(int(n), int(k), level) if side == "upper" else 1 - _least_mean(int(n), int(n - k), level)
    if side == "upper":
        return 1 - float_end(n, n - k, level, binary, "lower") if k >= n / 2 else _float_solve(n, k, level, binary, upper=False)
    return _float_solve(n, k, level, binary, upper=True) if k < n else 1.0


def _least_mean(n: int, k: int, level: float) -> float:
    """The mean at which as many successes as k, or more, have probability `level`: Newton's method on the logarithm of the tail.

    The tail is its first term times the sum of the others relative to it. Its logarithm is concave in that of the mean, so that after the
    first step each is nearer, from below.
    """
    if k <= 0:
        return 0.0
    choose = lgamma(n + 1) - lgamma(k + 1) - lgamma(n - k + 1)
    at = (log(level) - choose) / k
    for _ in range(STEPS):
        mean = exp(at)
        odds = mean / (1 - mean)
        total = term = 1.0
        for i in range(k, n):
            term *= (n - i) / (i + 1) * odds
            total += term
            if term < total * SMALL:
                break
        step = (log(level) - choose - k * at - (n - k) * log1p(-mean) - log(total)) * total / k
        at += step
        if abs(step) < TOLERANCE:
            break
    return exp(at)


def _float_solve(n: float, k: float, level: float, binary: bool, *, upper: bool) -> float:
    low, high = (k / n, 1.0) if upper else (0.0, k / n)
    for _ in range(200):
        middle = (low + high) / 2
        if middle in (low, high):
            break
        inside = float_tail(n, k if upper else n - k, middle if upper else 1 - middle, binary) > level
        if inside == upper:
            low = middle
        else:
            high = middle
    return high if upper else low


def float_tail(n: float, k: float, p: float, binary: bool) -> float:
    """P(sum ≤ k) in floats, by the same formulas as `_below`."""
    if k >= n or p <= 0:
        return 1.0
    if p >= 1:
        return 0.0
    if binary and n <= EXACT_DRAWS:
        from scipy.special import bdtr

        return float(bdtr(k, int(n), p))
    if k >= n * p:
        return 1.0
    exponent = (k * log(k / (n * p)) if k else 0.0) + (n - k) * (log((n - k) / n) - log1p(-p))
    value = exp(-max(exponent, 0.0))
    if binary and k:
        ratio = k * (1 - p) / ((n - k + 1) * p)
        if ratio < 1:
            value *= min(1.0, sqrt(n / (2 * pi * k * (n - k))) / (1 - ratio))
    return value


def float_upper_ends(n: Floats, k: Floats, binary: NDArray[np.bool_], level: float) -> Floats:
    """Upper ends of many cells at once, by the formula of `float_tail` for many draws."""
    below, above = k / n, np.ones(len(n))
    for _ in range(STEPS):
        p = (below + above) / 2
        inside = _closed_tails(n, k, p, binary) > level
        below, above = np.where(inside, p, below), np.where(inside, above, p)
    found: Floats = np.where(k < n, above, 1.0)
    return found


def _closed_tails(n: Any, k: Any, p: Any, binary: Any) -> Floats:
    """The formula of `float_tail` for many draws, for arrays."""
    with np.errstate(all="ignore"):
        exponent = np.where(k > 0, k * np.log(k / (n * p)), 0) + np.where(k < n, (n - k) * (np.log((n - k) / n) - np.log1p(-p)), 0)
        ratio = k * (1 - p) / ((n - k + 1) * p)
        factor = np.where(binary & (k > 0) & (ratio < 1), np.minimum(1, np.sqrt(n / (2 * pi * k * (n - k))) / (1 - ratio)), 1)
        found: Floats = np.exp(-np.maximum(exponent, 0)) * factor
    return found


def float_tails(n: float, k: Floats, p: Floats, *, binary: bool) -> Floats:
    """`float_tail` of arrays of sums and of means, one number of draws."""
    if binary and n <= EXACT_DRAWS:
        from scipy.special import bdtr

        tails = bdtr(k, int(n), p)
    else:
        tails = np.where(k >= n * p, 1.0, _closed_tails(n, k, p, binary))
    found: Floats = np.where((k >= n) | (p <= 0), 1.0, np.where(p >= 1, 0.0, tails))
    return found


def float_ends(n: float, k: Floats, level: float, side: Literal["lower", "upper"], *, binary: bool) -> Floats:
    """The lower or the upper end of the mean, by an array of sums, one number of draws."""
    if side == "lower":
        return np.asarray(1 - float_ends(n, n - k, level, "upper", binary=binary))
    if binary and n <= EXACT_DRAWS:
        from scipy.special import betaincinv

        return np.where(k < n, betaincinv(k + 1, np.maximum(n - k, 1), 1 - level), 1.0)
    return float_upper_ends(np.full(len(k), n), k, np.full(len(k), binary), level)


def closed_ends(share: Floats, cost: Floats) -> tuple[Floats, Floats]:
    """Where n·D reaches n·cost by bounds in closed form: D ≥ 2(z − μ)², and D ≥ (z − μ)²/(2·max(z, μ))."""
    square = np.sqrt(cost / 2)
    below = np.maximum(share - square, share - np.sqrt(2 * share * cost))
    above = np.minimum(share + square, share + cost + np.sqrt(2 * share * cost + cost * cost))
    return np.maximum(below, 0.0), np.minimum(above, 1.0)
