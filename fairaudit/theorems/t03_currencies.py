"""T3 under Gaussian, Rényi and zero-concentrated privacy: enclosures of real numbers, which no certificate cites."""

from __future__ import annotations

from fractions import Fraction
from math import erfc, inf, isqrt, nextafter, sqrt
from statistics import NormalDist
from typing import Any

from fairaudit.errors import InputError
from fairaudit.exact.enclosures import exp_enclosure, log_enclosure
from fairaudit.exact.rationals import at_least
from fairaudit.theorems.assumptions import FRESH, GROUP_FREE
from fairaudit.theorems.bound import Bound, Floor, floor_terms
from fairaudit.theorems.constants import read_level

BITS = 128
"""Of enclosures: 38 digits, of a bound that is shown with four, so that what rounding up adds is never seen."""

MAX_EXPONENT = 10_000
"""Beyond it e^q is above every 1/t that could be met, and an enclosure would have thousands of digits."""

GAUSS_SLACK = 2.0**-34
"""A relative margin of 6e-11: float64 evaluates erfc and its inverse to about 1e-14, which leaves three digits to spare."""

LEAST_LEVEL = 1e-290
"""Below it float64 nears its least normal number, 2.2e-308, and loses digits."""


def t3_gdp(mu: Any, t: Any, *, floor: Floor = "table") -> Bound:
    """T3 for μ-Gaussian privacy: R ≤ Φ(Φ⁻¹(t) + μ)/t, in floating point, enlarged by a relative 2⁻³⁴ and capped at 1/t.

    Not certified: Φ was evaluated in float64, whose error is far below the margin but is not proved here. Below t = 1e-290, where float64
    has no digits to spare, the value is 1/t.

    Source: T3; Coq `T3_gdp`.

    Parameters
    ----------
    mu : number or str
        μ ≥ 0, for every ordered pair of inputs.
    t, floor
        As in `t3_approx`.

    Returns
    -------
    Bound
        On the local ratio, `certified` false.

    Raises
    ------
    InputError
        If a number is out of range.

    Examples
    --------
    >>> round(float(t3_gdp(1, "0.5").value), 6), t3_gdp(1, "0.5").certified
    (1.682689, False)
    """
    shift, level = at_least("mu", mu, 0), read_level(t)
    value = 1 / level
    rough = float(level)
    if Fraction(rough) < level:
        rough = nextafter(rough, 1.0)
    if shift == 0:
        value = Fraction(1)
    elif LEAST_LEVEL < rough < 1.0 and shift < 100:
        reached = erfc(-(NormalDist().inv_cdf(rough) + float(shift)) / sqrt(2)) / 2
        value = min(value, Fraction(nextafter(reached * (1 + GAUSS_SLACK), inf)) / level)
    scope, extra = floor_terms(floor, f"{level} of the greatest utility", any_filter=True)
    premise = f"the group filter is {shift}-Gaussian differentially private for every ordered pair of its inputs"
    note = "evaluated in floating point and rounded up; not certified"
    return Bound("T3", "local_ratio", value, {"mu": shift, "t": level}, (), (FRESH, GROUP_FREE, premise, *extra), scope, False, note)


def t3_renyi(order: Any, rho: Any, t: Any, *, floor: Floor = "table") -> Bound:
    """T3 for Rényi privacy of order α: the least of e^((α−1)ρ/α)·t^(−1/α), (1 − e^(−ρ)·(1−t)^(α/(α−1)))/t and 1/t, rounded up.

    The value is a rigorous rational upper end, but the exponentials behind it are not among what a certificate can show in integers:
    `certified` is false for that reason alone.

    Source: T3; Coq `T3_renyi`, `T3_renyi_reversed`.

    Parameters
    ----------
    order : number or str
        α > 1.
    rho : number or str
        Rényi divergence of that order in nats, ρ ≥ 0, for every ordered pair of inputs.
    t, floor
        As in `t3_approx`.

    Returns
    -------
    Bound
        On the local ratio.

    Raises
    ------
    InputError
        If a number is out of range.

    Examples
    --------
    >>> round(float(t3_renyi(2, "0.1", "0.5").value), 6)
    1.486722
    """
    alpha, loss, level = at_least("order", order, 1), at_least("rho", rho, 0), read_level(t)
    if alpha == 1:
        raise InputError("the order is 1; an order above 1 is accepted")
    ends = [1 / level]
    if loss == 0:
        ends.append(Fraction(1))
    elif level < 1:
        ends += _exp_up(((alpha - 1) * loss + _log_up(1 / level)) / alpha)
        ends.append((1 - _exp_down(loss + alpha / (alpha - 1) * _log_up(1 / (1 - level)))) / level)
    premise = f"the Rényi divergence of order {alpha} between any two rows of the group filter is at most {loss}"
    return _enclosed(min(ends), {"order": alpha, "rho": loss, "t": level}, premise, floor)


def t3_zcdp(rho: Any, t: Any, *, floor: Floor = "table") -> Bound:
    """T3 for ρ-zCDP: log R ≤ 2√(ρ·log(1/t)) − ρ where ρ < log(1/t), R ≤ (1 − e^(−(√ρ + √log(1/(1−t)))²))/t, and 1/t; the least.

    Rounded up and not certified, for the reason given at `t3_renyi`.

    Source: T3; Coq `T3_zcdp`, `T3_zcdp_reversed`.

    Parameters
    ----------
    rho : number or str
        ρ ≥ 0: the Rényi divergence of every order α is at most ρα, for every ordered pair of inputs.
    t, floor
        As in `t3_approx`.

    Returns
    -------
    Bound
        On the local ratio.

    Raises
    ------
    InputError
        If a number is out of range.

    Examples
    --------
    >>> round(float(t3_zcdp("0.1", "0.1").value), 6)
    2.362464
    """
    loss, level = at_least("rho", rho, 0), read_level(t)
    ends = [1 / level]
    if loss == 0:
        ends.append(Fraction(1))
    elif level < 1:
        depth, other = _log_up(1 / level), _log_up(1 / (1 - level))
        if loss < depth:
            ends += _exp_up(2 * _root_up(loss * depth) - loss)
        ends.append((1 - _exp_down(loss + other + 2 * _root_up(loss * other))) / level)
    premise = f"the group filter is {loss}-zero-concentrated differentially private for every ordered pair of its inputs"
    return _enclosed(min(ends), {"rho": loss, "t": level}, premise, floor)


def _log_up(ratio: Fraction) -> Fraction:
    return Fraction(log_enclosure((ratio.numerator, ratio.denominator))[1])


def _exp_up(exponent: Fraction) -> list[Fraction]:
    """Upper end of e^q, or nothing where q is too large to matter."""
    if exponent > MAX_EXPONENT:
        return []
    return [Fraction(exp_enclosure((exponent.numerator, exponent.denominator), BITS)[1], 1 << BITS)]


def _exp_down(exponent: Fraction) -> Fraction:
    """Lower end of e^(−q)."""
    return 1 / _exp_up(exponent)[0] if exponent <= MAX_EXPONENT else Fraction(0)


def _root_up(value: Fraction) -> Fraction:
    scale = 1 << BITS
    return Fraction(isqrt(value.numerator * scale * scale // value.denominator) + 1, scale)


def _enclosed(value: Fraction, constants: dict[str, Fraction], premise: str, floor: Floor) -> Bound:
    scope, extra = floor_terms(floor, f"{constants['t']} of the greatest utility", any_filter=True)
    note = "the upper end of an enclosure of a real number; the enclosure is not part of the certificate"
    return Bound("T3", "local_ratio", value, constants, (), (FRESH, GROUP_FREE, premise, *extra), scope, False, note)
