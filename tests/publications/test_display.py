"""Rounded figures never say more than the exact ones."""

from __future__ import annotations

from decimal import ROUND_HALF_UP, Decimal, localcontext
from fractions import Fraction
from random import Random

import tiers

from fairaudit.publications.display import deviations_text, half_up, rate_text, ratio_text

PAIRS = 1_000_000 if tiers.FULL else 10_000
FOUR_FIFTHS, ONE = Fraction(4, 5), Fraction(1)


def near(rng: Random) -> Fraction:
    """A ratio of two rates, often one close to 4/5 or 1."""
    m = rng.randint(1, 10 ** rng.randint(1, 7))
    h = rng.randint(1, m)
    n = rng.randint(1, 10 ** rng.randint(1, 7))
    target = rng.choice((FOUR_FIFTHS, FOUR_FIFTHS, ONE, Fraction(rng.randint(0, 10), 10)))
    s = int(target * h * n / m) + rng.randint(-2, 2)
    return Fraction(min(max(s, 0), n) * m, n * h)


def test_no_ratio_is_moved_across_four_fifths_or_one() -> None:
    rng = Random(tiers.fresh("ratios"))
    met = 0
    for _ in range(PAIRS):
        ratio = near(rng)
        text = ratio_text(ratio)
        shown = Fraction(text)
        for limit in (FOUR_FIFTHS, ONE, Fraction(0)):
            assert (shown > limit, shown < limit) == (ratio > limit, ratio < limit)
        digits = len(text.partition(".")[2])
        assert digits >= 3
        assert abs(shown - ratio) * 2 * 10**digits <= 1
        met += digits > 3
    assert tiers.enough(met > PAIRS // 50)  # the case occurs


def test_rounding_is_half_up() -> None:
    rng = Random(tiers.fresh("half up"))
    for _ in range(2_000):
        value, digits = Fraction(rng.randint(-(10**6), 10**6), rng.choice((8, 40, 1000, rng.randint(1, 999)))), rng.randint(0, 4)
        with localcontext(prec=60) as context:
            exact = context.divide(Decimal(value.numerator), Decimal(value.denominator))
            expected = exact.quantize(Decimal(1).scaleb(-digits), ROUND_HALF_UP)
        text = half_up(value, digits)
        assert Decimal(text) == expected
        assert not (text.startswith("-") and Decimal(text) == 0)
    assert [half_up(Fraction(k, 2), 0) for k in (1, 3, 5, -1)] == ["1", "2", "3", "-1"]


def test_rates_are_percentages() -> None:
    assert [rate_text(Fraction(*pair)) for pair in ((205, 412), (667, 1390), (0, 9), (9, 9), (1, 10**5))] == [
        "49.8 %",
        "48.0 %",
        "0.0 %",
        "100.0 %",
        "0.001 %",
    ]
    assert rate_text(None) == ratio_text(None) == deviations_text(None) == "–"


def test_deviations_do_not_cross_two() -> None:
    rng = Random(tiers.fresh("two"))
    for _ in range(2_000):
        square = 4 + Fraction(rng.randint(-100, 100), 10 ** rng.randint(2, 9))
        shown = Fraction(deviations_text(square))
        assert (shown > 2, shown < 2) == (square > 4, square < 4)
        assert abs(float(shown) - float(square) ** 0.5) <= 0.00501
