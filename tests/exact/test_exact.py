"""Numbers from text, and logarithms, against independent arithmetic."""

from __future__ import annotations

import gc
from decimal import Decimal
from fractions import Fraction

import mpmath
import pytest
from hypothesis import given
from hypothesis import strategies as st

from fairaudit.errors import InputError
from fairaudit.exact.collecting import uncollected
from fairaudit.exact.enclosures import compare_log, log_enclosure
from fairaudit.exact.rationals import (
    at_least,
    common_denominator,
    decimal_text,
    integer_text,
    number,
    option_value,
    parse_rational,
    rational,
    rational_text,
    shortened,
)


@given(st.decimals(allow_nan=False, allow_infinity=False, places=6))
def test_decimals_read_as_they_say(value: Decimal) -> None:
    assert Fraction(*parse_rational(format(value, "f"))) == Fraction(value)
    assert Fraction(*parse_rational(format(value, "e"))) == Fraction(value)


@given(st.fractions())
def test_fractions_read_and_write_back(value: Fraction) -> None:
    text = rational_text((value.numerator, value.denominator))
    assert Fraction(*parse_rational(text)) == value


@given(st.floats(allow_nan=False, allow_infinity=False))
def test_floats_are_dyadic(value: float) -> None:
    assert Fraction(*rational(value)) == Fraction(value)


@pytest.mark.parametrize(
    "text",
    [
        "",
        " ",
        "x",
        "0x10",
        "1_000",
        "1,5",
        "nan",
        "inf",
        "-inf",
        "1/0",
        "1e400000",
        "1e5000",
        "9" * 4001,
        "1/" + "9" * 4001,
        "١٢",
        "1.2.3",
        "--1",
        "1/2/3",
        "1e",
    ],
)
def test_what_is_not_a_number_is_refused(text: str) -> None:
    with pytest.raises(InputError):
        parse_rational(text)


@pytest.mark.parametrize("value", [float("nan"), float("inf"), None, True, object(), Decimal("nan"), Decimal("1e9999"), [1]])
def test_what_is_not_a_finite_number_is_refused(value: object) -> None:
    with pytest.raises(InputError):
        rational(value)


@pytest.mark.parametrize("digits", [1, 4000, 4001, 8000, 8001, 30_000])
def test_long_integers(digits: int) -> None:
    number = 10 ** (digits - 1) + 7 if digits > 1 else 7
    text = integer_text(number)
    assert len(text) == digits
    assert text == ("1" + "0" * (digits - 2) + "7" if digits > 1 else "7")


def test_results_beyond_the_limit_are_refused() -> None:
    with pytest.raises(InputError, match="digits"):
        rational_text((10**100_001, 1))
    with pytest.raises(InputError, match="denominator"):
        common_denominator([(1, 10**60_000 + 1), (1, 10**60_000 + 3)])


@pytest.mark.parametrize("text", ["9" * 4000, "-" + "9" * 4000, "1/" + "9" * 4000, "9" * 4000 + "/7", "1e4000", "1e-4000"])
def test_the_longest_numbers_are_read(text: str) -> None:
    assert Fraction(*parse_rational(text)) == Fraction(text)


@pytest.mark.parametrize("text", ["9" * 4001 + "/7", "1e4001", "1e-4001", "0." + "1" * 4000])
def test_the_shortest_numbers_that_are_too_long_are_refused(text: str) -> None:
    with pytest.raises(InputError, match="more than 4000 digits"):
        parse_rational(text)


def test_the_longest_results_are_written() -> None:
    assert rational_text((1, 10**90_000)) == "1/1" + "0" * 90_000
    assert common_denominator([(2, 1), (-3, 1)]) == ([2, -3], 1)
    assert common_denominator([(1, 10**100_000), (3, 1)])[0] == [1, 3 * 10**100_000]
    with pytest.raises(InputError, match="90000 digits"):
        rational_text((1, 10**90_400))
    with pytest.raises(InputError, match="100000 digits"):
        common_denominator([(1, 10**100_400)])


def test_a_least_value_is_accepted_and_less_is_not() -> None:
    assert at_least("x", 2, 2) == 2
    assert at_least("x", 0.1, 0) == Fraction(1, 10) and at_least("x", 0.5, 0, read=rational) == Fraction(1, 2)
    with pytest.raises(InputError, match=r"^x is 1.99; a number of at least 2 is accepted$"):
        at_least("x", 1.99, 2)
    with pytest.raises(InputError, match=r"^x: "):
        at_least("x", "two", 2)


@given(st.integers(-(10**12), 10**12), st.integers(0, 30))
def test_up_to_30_decimals_are_written_as_such(digits: int, places: int) -> None:
    value = Fraction(digits, 10**places)
    with_point = decimal_text(value)
    assert Fraction(with_point) == value and "/" not in with_point
    assert with_point == format(Decimal(with_point).normalize(), "f")
    assert option_value(with_point) == (value.numerator, value.denominator)


def test_other_rationals_are_written_as_quotients() -> None:
    assert decimal_text(Fraction(1, 10**31)) == number(Fraction(1, 10**31)) == "1/1" + "0" * 31
    assert (decimal_text(Fraction(-2, 3)), decimal_text(Fraction(-5))) == ("-2/3", "-5")


@given(st.integers(1, 10**60), st.integers(1, 10**60))
def test_log_enclosure_contains_the_logarithm(p: int, q: int) -> None:
    top, bottom = max(p, q), min(p, q)
    lo, hi = log_enclosure((top, bottom))
    with mpmath.workdps(120):
        value = mpmath.log(mpmath.mpf(top) / bottom)
        assert mpmath.mpf(lo) <= value <= mpmath.mpf(hi)
    assert Decimal(hi) - Decimal(lo) in (0, Decimal("1e-12"))


@pytest.mark.parametrize("exponent", [1, 12, 13, 400, 3999])
def test_log_close_to_one(exponent: int) -> None:
    lo, _ = log_enclosure((10**exponent + 1, 10**exponent))
    with mpmath.workdps(4100):
        assert int(Decimal(lo) * 10**12) == int(mpmath.floor(mpmath.log1p(mpmath.mpf(10) ** -exponent) * 10**12))


@given(st.integers(1, 10**30), st.integers(1, 10**30), st.integers(5, 60), st.integers(-2, 2))
def test_comparison_is_decided_however_close(p: int, q: int, digits: int, off: int) -> None:
    """Limits that agree with the logarithm to many digits are still told apart."""
    top, bottom = max(p, q) + 1, min(p, q)
    with mpmath.workdps(digits + 120):
        value = mpmath.log(mpmath.mpf(top) / bottom)
        limit = max(0, int(mpmath.floor(value * mpmath.mpf(10) ** digits)) + off)
        expected = 1 if value > mpmath.mpf(limit) / mpmath.mpf(10) ** digits else -1
    assert compare_log((top, bottom), (limit, 10**digits)) == expected


def test_comparison_at_the_ends() -> None:
    assert compare_log((1, 1), (0, 1)) == 0
    assert compare_log((1, 1), (1, 10**4000)) == -1
    assert compare_log((10**4000 + 1, 10**4000), (0, 1)) == 1
    assert compare_log((10**4000 + 1, 10**4000), (1, 10**4000)) == -1
    assert compare_log((10**4000, 1), (10**4000, 1)) == -1
    assert compare_log((1, 0), (10**4000, 1)) == 1


def test_reference_cycles_are_searched_for_again_afterwards() -> None:
    with uncollected():
        assert not gc.isenabled()
    assert gc.isenabled()
    with pytest.raises(InputError), uncollected():
        parse_rational("x")
    assert gc.isenabled()
    gc.disable()
    try:
        with uncollected():
            pass
        assert not gc.isenabled()
    finally:
        gc.enable()


@given(st.integers(-(10**30), 10**30), st.integers(0, 20), st.integers(-1, 1), st.integers(1, 10**6))
def test_what_is_shortened_is_on_the_same_side_of_every_decimal(top: int, places: int, way: int, much: int) -> None:
    """Of decimals, and of numbers next to them."""
    decimal = Fraction(top, 10**places)
    value = decimal + Fraction(way, 10**2000 + much)
    short = shortened(value)
    assert (short > decimal) - (short < decimal) == way
    assert short.denominator <= 2 * 10**400 or short == value
    assert abs(short - value) < Fraction(1, 10**400)
