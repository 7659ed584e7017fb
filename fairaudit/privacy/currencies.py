"""What privacy is stated in: pure ε, (ε, δ), Rényi, zCDP and GDP.

Everything is local privacy: any two values of the alphabet are adjacent, and pairs are ordered, P = M(·|a) against Q = M(·|a').
What is rational is a `Fraction`; what is irrational an enclosure, two decimals rounded outward. Only GDP is not certified.
Units are nats. An e^ε is passed as `exp_epsilon`, because then δ is rational; an ε goes to `delta_at`.

Definitions: hockey-stick divergence and privacy profile, Balle, Barthe and Gaboardi (2018); trade-off functions and GDP, Dong,
Roth and Su (2022); Rényi DP, Mironov (2017); zCDP, Bun and Steinke (2016).
"""

from __future__ import annotations

from dataclasses import dataclass
from decimal import Decimal
from fractions import Fraction

from fairaudit.privacy.pairs import Pair

Enclosure = tuple[Decimal, Decimal]


@dataclass(frozen=True)
class AttributeDP:
    """Pure differential privacy when one attribute changes and the others stay: never the figure of the whole tuple.

    Attributes
    ----------
    column : str
        Name of the column, or its position from 1 if the filter's columns have no names.
    exp_epsilon : Fraction or inf
        e^ε, exact.
    epsilon : tuple of Decimal
        Enclosure of ε, in nats.
    pair : pair of inputs, or None
        Two inputs of the filter's factor that differ in this attribute only and attain e^ε; None if no two do.
    """

    column: str
    exp_epsilon: Fraction | float
    epsilon: Enclosure
    pair: Pair | None


@dataclass(frozen=True)
class PureDP:
    """Pure differential privacy of the whole tuple: any two inputs of the filter are adjacent.

    Attributes
    ----------
    exp_epsilon : Fraction or inf
        e^ε, exact: the greatest likelihood ratio over all ordered pairs; inf if supports differ.
    epsilon : tuple of Decimal
        Enclosure of ε, in nats.
    pair : pair of inputs, or None
        An ordered pair of different inputs that attains it; None if there is only one input.
    attributes : tuple of AttributeDP
        The same when only one attribute changes.

    Examples
    --------
    >>> import fairaudit as fa
    >>> coin = fa.RandomizedResponse(["f", "m"], keep_probability="0.75")
    >>> fa.pure_dp(coin).exp_epsilon
    Fraction(3, 1)
    """

    exp_epsilon: Fraction | float
    epsilon: Enclosure
    pair: Pair | None
    attributes: tuple[AttributeDP, ...]


@dataclass(frozen=True)
class ApproxDP:
    """(ε, δ)-differential privacy at a rational e^ε.

    Attributes
    ----------
    exp_epsilon : Fraction
        e^ε ≥ 1.
    delta : Fraction
        The least δ, exact; the total variation distance at e^ε = 1.
    pair : pair of inputs, or None
        An ordered pair of different inputs that attains it.

    Examples
    --------
    >>> import fairaudit as fa
    >>> from fairaudit.privacy.epsilon_delta import approx_dp
    >>> coin = fa.RandomizedResponse(["f", "m"], keep_probability="0.75")
    >>> approx_dp(coin, 2).delta
    Fraction(1, 4)
    """

    exp_epsilon: Fraction
    delta: Fraction
    pair: Pair | None


@dataclass(frozen=True)
class RenyiDP:
    """Rényi differential privacy.

    Attributes
    ----------
    order : Fraction
        The order, greater than 1.
    epsilon : tuple of Decimal
        Enclosure of the greatest Rényi divergence over all ordered pairs, in nats.
    """

    order: Fraction
    epsilon: Enclosure


@dataclass(frozen=True)
class zCDP:  # noqa: N801
    """Zero-concentrated differential privacy.

    Attributes
    ----------
    rho : tuple of Decimal
        Enclosure of the least ρ with Rényi divergence at most ρ·order at every order above 1.
    """

    rho: Enclosure


@dataclass(frozen=True)
class GDP:
    """Gaussian differential privacy.

    Attributes
    ----------
    mu : float
        The least μ whose Gaussian trade-off curve lies below the filter's, computed in floating point and not certified.
    """

    mu: float
