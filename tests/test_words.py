"""Figures and labels as people read them."""

from __future__ import annotations

import unicodedata
from fractions import Fraction

import pytest
from hypothesis import given
from hypothesis import strategies as st

from fairaudit.words import BENEFIT, BURDEN, approximate, percent, place, plain, words_for

rationals = st.fractions(min_value=Fraction(1, 10**12), max_value=10**12)


@given(rationals)
def test_rounding_down_and_up_encloses_the_value(value: Fraction) -> None:
    low, high = Fraction(approximate(value, "down")), Fraction(approximate(value, "up"))
    assert low <= value <= high
    assert high - low <= value / 1000  # four digits


@given(rationals)
def test_the_nearest_figure_is_off_by_half_a_digit_at_most(value: Fraction) -> None:
    assert abs(Fraction(approximate(value)) - value) <= value / 2000 * (1 + Fraction(1, 10**9))


@pytest.mark.parametrize(("value", "text"), [(Fraction(0), "0"), (Fraction(1, 10**400), "1e-400"), (float("inf"), "infinite")])
def test_figures_that_floats_cannot_hold(value: Fraction | float, text: str) -> None:
    assert approximate(value) == text


@given(st.text())
def test_a_label_cannot_steer_a_terminal(text: str) -> None:
    assert all(character.isprintable() or unicodedata.category(character) == "Zs" for character in plain(text))


def test_a_burden_is_not_a_favour() -> None:
    assert words_for(burden=True) is BURDEN and words_for(burden=False) is BENEFIT
    assert "exactly 0" in BENEFIT.amounts((Fraction(1, 2), Fraction(0)))


def test_places_and_percentages() -> None:
    assert place({"Dept": "A", "Year": "1973"}) == "Dept=A, Year=1973"
    assert percent(Fraction(1, 3)) == "33.3333 %"
