"""Where polynomials are nonnegative: against their values at many points."""

from __future__ import annotations

from fractions import Fraction
from math import comb

from hypothesis import given
from hypothesis import strategies as st

from fairaudit.exact.bernstein import coefficients, greatest_nonnegative

F = Fraction
Small = st.fractions(-3, 3, max_denominator=6)


def value(polynomial: list[F], u: F) -> F:
    n = len(polynomial) - 1
    return sum((b * comb(n, i) * u**i * (1 - u) ** (n - i) for i, b in enumerate(polynomial)), F(0))


@given(st.lists(Small, min_size=1, max_size=6))
def test_values_and_coefficients_are_of_one_polynomial(values: list[F]) -> None:
    found = coefficients(values)
    degree = len(values) - 1
    assert [value(found, F(j, max(1, degree))) for j in range(degree + 1)] == values


@given(st.integers(0, 4).flatmap(lambda n: st.lists(st.lists(Small, min_size=n + 1, max_size=n + 1), min_size=1, max_size=4)))
def test_the_greatest_point_is_found_and_none_is_missed(polynomials: list[list[F]]) -> None:
    low, high = F(1, 3), F(2)
    point, settled = greatest_nonnegative(polynomials, low, high)
    good = [n for n in range(241) if all(value(p, F(n, 240)) >= 0 for p in polynomials)]
    if point is None:
        assert not (good and settled)
        return
    u = (point - low) / (high - low)
    assert all(value(p, u) >= 0 for p in polynomials)
    assert not settled or not good or u >= F(good[-1], 240) - F(1, 2**59) or len(polynomials[0]) > 2


def test_double_zeros_are_not_said_to_be_absent() -> None:
    """−(u − 1/3)² is 0 at 1/3 alone, which halving never meets."""
    polynomial = coefficients([-((F(j, 2) - F(1, 3)) ** 2) for j in range(3)])
    assert greatest_nonnegative([polynomial], F(0), F(1)) == (None, False)
    higher = coefficients([-((F(j, 2) - F(1, 4)) ** 2) for j in range(3)])
    assert greatest_nonnegative([higher], F(0), F(1)) == (F(1, 4), True)
