"""Paths into rows: what they lead to, and what is no path."""

from __future__ import annotations

from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from fairaudit.errors import InputError
from fairaudit.tables.evaluations.paths import ABSENT, EACH, LAST, is_path, read_path, written_path

ROW = {
    "id": 7,
    "doc": {"race": "b", "a.b": {"c d": 1}, 'q"q': 2, "0": "zero"},
    "tags": ["x", "y", {"z": [10, 20]}],
    "none": None,
    "empty": [],
    "text": "abc",
}


@pytest.mark.parametrize(
    ("path", "value"),
    [
        ("id", 7),
        ("doc.race", "b"),
        ('doc."a.b"."c d"', 1),
        ('doc."q""q"', 2),
        ("doc.0", "zero"),
        ("tags[0]", "x"),
        ("tags[last].z[last]", 20),
        ("tags[2].z[0]", 10),
        ("tags[3]", ABSENT),
        ("empty[last]", ABSENT),
        ("doc.none", ABSENT),
        ("none", None),
        ("none.deeper", ABSENT),
        ("text.deeper", ABSENT),
        ("text[0]", ABSENT),
        ("doc[0]", ABSENT),
        ("nowhere.at.all[0]", ABSENT),
    ],
)
def test_a_path_leads_to_a_value_or_nowhere(path: str, value: Any) -> None:
    assert read_path(path).of(ROW) == value


@pytest.mark.parametrize(
    "path",
    [
        "",
        ".",
        "a.",
        ".a",
        "a..b",
        "[0]",
        "a[",
        "a[-1]",
        "a[1.5]",
        "a[first]",
        "a]b",
        'a"b"',
        '"a',
        "a[0]b",
        "a.[0]",
        "a[*].b[*]",
        "argmax(a)",
    ],
)
def test_what_is_no_path_is_refused(path: str) -> None:
    with pytest.raises(InputError):
        read_path(path)


def test_a_name_into_a_list_says_what_to_write() -> None:
    with pytest.raises(InputError, match=r"name an element, such as \[0\], \[last\] or \[\*\]"):
        read_path("tags.z").of(ROW)


@pytest.mark.parametrize(
    ("numbers", "place"),
    [
        ([0.5, 0.25], 0),
        (["-0.109", "-2.5"], 0),
        ([-1, "0.5", 3], 2),
        (["9007199254740993", 9007199254740992], 0),  # the same float
        ([float("-inf"), -5], 1),
        (["0.1", "0.10000000000000000001"], 1),
        ([7], 0),
        (["-inf", "-1E+2", ".5"], 2),
    ],
)
def test_the_greatest_number_is_found_exactly(numbers: list[Any], place: int) -> None:
    assert read_path("argmax(p[*])").of({"p": numbers}) == place
    assert read_path("argmax(p[*][0])").of({"p": [[number, "False"] for number in numbers]}) == place
    assert read_path("argmax(p[*].value)").of({"p": [{"value": number} for number in numbers]}) == place


@pytest.mark.parametrize("held", [None, [], ABSENT])
def test_no_list_of_numbers_is_no_answer(held: Any) -> None:
    row = {} if held is ABSENT else {"p": held}
    assert read_path("argmax(p[*])").of(row) is ABSENT


@pytest.mark.parametrize(
    "held",
    [
        [1, 1],
        ["0.5", 0.5],
        [1, "x"],
        [1, None],
        [True, 0],
        [float("nan"), 1],
        ["nan", 1],
        ["1_000", 1],
        ["\u0663", 1],
        [[1]],
        "text",
        5,
        {"a": 1},
    ],
)
def test_no_single_greatest_number_is_refused(held: Any) -> None:
    with pytest.raises(InputError, match="argmax"):
        read_path("argmax(p[*])").of({"p": held})


STEPS = st.lists(st.one_of(st.text(min_size=1, max_size=5), st.integers(0, 99), st.just(LAST)), max_size=5)


@given(st.text(min_size=1, max_size=5), STEPS)
def test_what_is_written_is_read(first: str, rest: list[Any]) -> None:
    steps = (first, *rest)
    assert read_path(written_path(steps)).steps == steps


def test_steps_that_take_every_element() -> None:
    path = read_path("resps[0][*].text")
    assert (path.each, path.top, path.steps) == (2, "resps", ("resps", 0, EACH, "text"))
    assert read_path("argmax(a[*])").each is None
    assert [is_path(name) for name in ("race", "last name", "a.b", "a[0]", '"a"', "f(x)")] == [False, False, True, True, True, False]


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("argmin(a.b[*])", "has the function argmin, and argmax is the only one"),
        ("first(a.b)", "has the function first, and argmax is the only one"),
        ("argmax(a.b[*]", "has a parenthesis that is not closed"),
        ("a[0", "has a bracket that is not closed"),
        ("a[*].b[1].c[last", "has a bracket that is not closed"),
        ("a[first]", "cannot be read from '\\[first\\]' on"),
    ],
)
def test_what_is_wrong_with_a_path_is_said(text: str, said: str) -> None:
    with pytest.raises(InputError, match=said):
        read_path(text)


def test_a_name_with_parentheses_is_a_name() -> None:
    assert read_path("pay(eur).gross").steps == ("pay(eur)", "gross")
    assert read_path('"argmin(x)".y').steps == ("argmin(x)", "y")
