"""The examples of New York City's rule (6 RCNY 5-300 and following): people, selected, and rate and impact ratio as they are printed.

Of the example of scores the rule prints no numbers of people above the median; these are the only whole numbers that fit its rates.
"""

from __future__ import annotations

from fractions import Fraction

HISPANIC, WHITE, BLACK, PACIFIC, ASIAN, NATIVE, TWO = RACES = (
    "Hispanic or Latino",
    "White",
    "Black or African American",
    "Native Hawaiian or Pacific Islander",
    "Asian",
    "Native American or Alaska Native",
    "Two or More Races",
)

Printed = dict[tuple[str, str], tuple[int, int, str, str]]


def _rows(sex: str, text: str) -> Printed:
    """Rows by race, written as people/selected/rate/ratio."""
    found: Printed = {}
    for race, row in zip(RACES, text.split(), strict=True):
        people, selected, rate, ratio = row.split("/")
        found[sex, race] = int(people), int(selected), rate, ratio
    return found


SELECTION_SEX: Printed = {("Male", ""): (1390, 667, "48%", "1.00"), ("Female", ""): (1181, 555, "47%", "0.979")}

SELECTION_RACE = _rows(
    "",
    "408/204/50%/0.97 797/412/52%/1.00 390/170/44%/0.84 119/52/44%/0.85 616/302/49%/0.95 41/18/44%/0.85 213/96/45%/0.87",
)
"""Not a margin of the intersections: there 395 people are Hispanic or Latino, and 172 of them selected."""

SELECTION_BOTH = _rows(
    "Male",
    "205/90/43.9%/0.841 412/215/52.2%/1.000 226/95/42.0%/0.806 87/37/42.5%/0.815 321/167/52.0%/0.997 24/11/45.8%/0.878 115/52/45.2%/0.866",
) | _rows(
    "Female",
    "190/82/43.2%/0.827 385/197/51.2%/0.981 164/75/45.7%/0.876 32/15/46.9%/0.898 295/135/45.8%/0.877 17/7/41.2%/0.789 98/44/44.9%/0.860",
)

SELECTION_UNKNOWN = 250

SCORING_SEX: Printed = {("Male", ""): (92, 50, "54.3%", "1.00"), ("Female", ""): (76, 34, "44.7%", "0.82")}

SCORING_RACE = _rows(
    "", "28/18/64.2%/1.00 40/15/37.5%/0.58 32/16/50.0%/0.78 8/5/62.5%/0.97 24/10/41.7%/0.65 16/10/62.5%/0.97 20/10/50.0%/0.78"
)
"""The first rate is cut off, not rounded: 18 of 28 are 64.29 %."""

SCORING_BOTH = _rows(
    "Male", "16/12/75%/1.00 20/7/35%/0.47 20/10/50%/0.67 4/3/75%/1.00 12/7/58.3%/0.78 8/5/62.5%/0.83 12/6/50%/0.67"
) | _rows("Female", "12/6/50%/0.67 20/8/40%/0.53 12/6/50%/0.67 4/2/50%/0.67 12/3/25%/0.33 8/5/62.5%/0.83 8/4/50%/0.67")

SCORING_UNKNOWN = 15

CUT_OFF = ("", HISPANIC)
"""The row of `SCORING_RACE` whose printed rate is not rounded half up."""


def rounded(value: Fraction, like: str) -> str:
    """A value with as many digits as a printed one, half up, by integers."""
    percent = like.endswith("%")
    digits = len(like.removesuffix("%").partition(".")[2])
    shifted = value * (100 if percent else 1) * 10**digits
    whole = str((2 * shifted.numerator + shifted.denominator) // (2 * shifted.denominator)).rjust(digits + 1, "0")
    text = f"{whole[:-digits]}.{whole[-digits:]}" if digits else whole
    return f"{text}%" if percent else text
