"""Logarithms against decimals of many digits."""

import random
from decimal import Decimal, localcontext
from fractions import Fraction

import pytest
import tiers
from plain_certificates import checker


def scaled_log(value: Fraction, digits: int) -> int:
    with localcontext() as context:
        context.prec = digits + 40
        context.Emax, context.Emin = 10**9, -(10**9)
        log = (Decimal(value.numerator) / Decimal(value.denominator)).ln()
        return int((log.scaleb(digits)).to_integral_value("ROUND_FLOOR"))


@pytest.mark.parametrize("seed", range(60))
def test_log_floor(seed: int) -> None:
    pick = random.Random(tiers.fresh(seed))
    size = 10 ** pick.choice([1, 2, 5, 20, 300])
    d = pick.randint(1, size)
    value = Fraction(d + pick.randint(1, pick.choice([3, size, size**3])), d)
    pair = value.numerator, value.denominator
    for digits in (0, 12, 50):
        assert checker.logarithms.log_floor(pair, 10**digits) == scaled_log(value, digits)
    floor = Fraction(scaled_log(value, 50), 10**50)
    above = floor + Fraction(1, 10**50)
    assert not checker.logarithms.log_at_most(pair, (floor.numerator, floor.denominator))
    assert checker.logarithms.log_at_most(pair, (above.numerator, above.denominator))


def test_log_extremes() -> None:
    tiny = 10**400 + 1, 10**400
    assert checker.logarithms.log_enclosure(tiny) == ("0.000000000000", "0.000000000001")
    assert checker.logarithms.log_at_most(tiny, (1, 10**400))
    assert not checker.logarithms.log_at_most(tiny, (10**400 - 1, 10**800))  # R - 1 - (R - 1)^2
    assert not checker.logarithms.log_at_most(tiny, (1, 10**4000)) and checker.logarithms.log_at_most(tiny, (10**4000, 1))
    assert not checker.logarithms.log_at_most(tiny, (2 * 10**400 - 1, 2 * 10**800))  # R - 1 - (R - 1)^2 / 2, the cubic is above
    assert checker.logarithms.log_at_most(tiny, (6 * 10**800 - 3 * 10**400 + 2, 6 * 10**1200))  # with the cubic, log R is below
    huge = 10**99_999, 1
    assert checker.logarithms.log_floor(huge, 10**12) == scaled_log(Fraction(10), 20) * 99_999 // 10**8
    assert checker.logarithms.log_floor((10**99_999 + 1, 10**99_999), 10**12) == 0
    assert checker.logarithms.log_enclosure((1, 1)) == ("0", "0") and checker.logarithms.log_enclosure((1, 0)) == ("inf", "inf")
    assert checker.logarithms.log_at_most((1, 1), (0, 1)) and not checker.logarithms.log_at_most((2, 1), (0, 1))
    assert not checker.logarithms.log_at_most((1, 0), (10**4000, 1))


def test_close_limit_of_a_thousand_digits() -> None:
    floor = scaled_log(Fraction(24475, 18432), 1000)
    assert not checker.logarithms.log_at_most((24475, 18432), (floor, 10**1000))
    assert checker.logarithms.log_at_most((24475, 18432), (floor + 1, 10**1000))
