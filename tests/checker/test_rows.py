"""Tables line by line: spoiled ones, those of another certificate, and what is needed of them."""

import re
from collections.abc import Callable
from typing import Any

import pytest
from plain_certificates import COUNTS, LIMITS, checker, detached, false_statements, lines_of, make, raw


@pytest.fixture
def good() -> dict[str, Any]:
    return make(COUNTS, ["1", "0"], limits=LIMITS)


def test_table_needed(good: dict[str, Any]) -> None:
    outside, lines = detached(good)
    with pytest.raises(checker.TableNeeded):
        checker.check(raw(outside))
    assert checker.check(raw(outside), iter(lines)).ok


@pytest.mark.parametrize(
    "spoil",
    [
        lambda lines: [*lines[:-1], lines[-1][:-1]],
        lambda lines: [*lines, b"\n"],
        lambda lines: [lines[0], lines[1].replace(b",", b", ", 1), *lines[2:]],
        lambda lines: [lines[0], lines[1].replace(b"\n", b"\r\n"), *lines[2:]],
        lambda lines: [lines[0], lines[2], lines[1], *lines[3:]],
        lambda lines: [lines[0], lines[1], lines[1], *lines[2:]],
        lambda lines: [lines[0].replace(b"x0", b"\xc3\xa9"), *lines[1:]],
        lambda lines: [lines[0].replace(b"x0", b"\\ud800"), *lines[1:]],
        lambda lines: [],
        lambda lines: lines[1:],
    ],
)
def test_spoiled_table(good: dict[str, Any], spoil: Callable[[list[bytes]], list[bytes]]) -> None:
    outside, lines = detached(good)
    with pytest.raises(checker.FormatError, match="table"):
        checker.check(raw(outside), spoil(lines))


def test_another_table(good: dict[str, Any]) -> None:
    outside, lines = detached(good)
    assert any("sha256" in line for line in false_statements(outside, lines[:-1]))
    other = make({(0, 0): ["1/2", "1/4", "1/4"], (0, 1): ["1", "0", "0"]}, ["1", "0", "2"], population="equal")
    assert any("subject.kind" in line for line in false_statements(outside, lines_of(other["subject"]["table"])))


def test_table_given_besides_the_embedded_one(good: dict[str, Any]) -> None:
    lines = lines_of(good["subject"]["table"])
    assert checker.check(raw(good), lines).ok
    assert not checker.check(raw(good), lines[:-1]).ok


@pytest.mark.parametrize("change", [{"mass": "1/3"}, {"weights": ["1/2", "1/3"]}, {"utility": [None, "0"]}])
def test_probabilities(change: dict[str, Any]) -> None:
    utility = {(0, 0): ["1", "0"], (0, 1): ["2", "0"]}
    certificate = make(
        {(0, 0): ["1/2", "1/2"], (0, 1): ["1", "0"]},
        utility,
        population="weights",
        masses={(0, 0): "1/2", (0, 1): "1/2"},
    )
    assert not false_statements(certificate)
    certificate["subject"]["table"]["rows"][0].update(change)
    with pytest.raises(checker.FormatError):
        checker.check(raw(certificate))


@pytest.mark.parametrize("number", [b"0.5", b"1e3", b"-0", b"123456789012345678901"])
def test_odd_numbers_in_a_line_of_the_file_are_refused_in_a_sentence(good: dict[str, Any], number: bytes) -> None:
    outside, lines = detached(good)
    spoiled = [re.sub(rb'"group":[0-9]+', b'"group":' + number, line) for line in lines]
    with pytest.raises(checker.FormatError, match="no place for"):
        checker.check(raw(outside), iter(spoiled))
