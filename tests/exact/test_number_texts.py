"""Texts read many at a time: the same numbers as one at a time, and nothing accepted that is refused there."""

from fractions import Fraction

from hypothesis import example, given, settings
from hypothesis import strategies as st

from fairaudit.exact.number_texts import read_number_texts
from fairaudit.exact.rationals import parse_rational

PIECES = st.sampled_from(
    ["0", "00", "1", "7", "25", "999999999", "123456789012345678", ".", "/", "e", "E", "+", "-", " ", "\0", "_", "١", "x"]
)

HOSTILE = [
    "1\0002",
    "1\0",
    "e5",
    ".e5",
    "1e0000005",
    "1e-999",
    "1e1000",
    "1/0",
    "0/5",
    "1e2/3",
    "1.5/2",
    "1/2.5",
    "1e+",
    "5.",
    ".5",
    ".",
    "",
]


@settings(max_examples=200, deadline=None)
@example(HOSTILE)
@example(["0." + "3" * 18, "0." + "3" * 19, "0" * 38 + "1", "0" * 39 + "1", "0" * 40 + "1", "1" * 41, "9" * 18, "9" * 19])
@given(
    st.lists(
        st.lists(PIECES, max_size=6).map("".join) | st.floats(0).map(repr) | st.fractions(0).map(str) | st.decimals(0).map(str), max_size=6
    )
)
def test_the_numbers_are_those_of_each_text_by_itself(texts: list[str]) -> None:
    found = read_number_texts(texts)
    left = set(found.left.tolist())
    for place, text in enumerate(texts):
        if place in left:
            continue
        top, power, bottom = (int(part[place]) for part in (found.tops, found.powers, found.bottoms))
        assert Fraction(top) * Fraction(10) ** power / bottom == Fraction(*parse_rational(text))


def test_plain_numbers_of_up_to_18_digits_are_not_left() -> None:
    texts = [
        "0.1",
        "1",
        "0",
        "0.000",
        "1e-05",
        "2.5E+3",
        "12.",
        ".5",
        "999999999999999999",
        "0.00012345678901234567",
        "1/3",
        "10/999999999999999999",
    ]
    assert not read_number_texts(texts).left.size


def test_a_sign_or_a_long_number_is_left() -> None:
    texts = ["-1", "+1", "1" * 19, " 1", "1 ", "a", "", "1/0"]
    assert read_number_texts(texts).left.tolist() == list(range(len(texts)))
