"""The worst case over the unknown, against every way in which they may belong to categories."""

from __future__ import annotations

import random
from collections.abc import Iterator
from fractions import Fraction
from itertools import product
from typing import Any

import pytest
import tiers

import fairaudit as fa
from fairaudit.publications.ll144.worst_case import WorstCase, worst_case

WORST = ("local_ratio", "<=")

TABLES = 5_000 if tiers.FULL else 600


def splits(people: int, places: int) -> Iterator[tuple[int, ...]]:
    """All ways to send people to places."""
    if places == 1:
        yield (people,)
        return
    for first in range(people + 1):
        for rest in splits(people - first, places - 1):
            yield (first, *rest)


def least_ratio(counts: list[tuple[int, int]]) -> Fraction | None:
    """The least impact ratio of a table by the rule's definition."""
    rates = [Fraction(s, n) for s, n in counts if n]
    if not rates:
        return None
    return min(rates) / max(rates) if max(rates) else Fraction(1)


def enumerated(counts: list[tuple[int, int]], selected: int, unselected: int, undecided: int) -> Fraction | None:
    """The least over everything that could be."""
    found: Fraction | None = None
    for chosen in range(undecided + 1):
        ways = product(splits(selected + chosen, len(counts)), splits(unselected + undecided - chosen, len(counts)))
        for yes, no in ways:
            ratio = least_ratio([(s + y, n + y + x) for (s, n), y, x in zip(counts, yes, no, strict=True)])
            if ratio is not None and (found is None or ratio < found):
                found = ratio
    return found


def random_table(draw: random.Random) -> tuple[list[tuple[int, int]], int, int, int]:
    sizes = [draw.choice([0, 1, 2, 3, 7, 20, 300]) for _ in range(draw.choice([1, 2, 2, 3, 3]))]
    counts = [(draw.choice([0, n, draw.randint(0, n)]), n) for n in sizes]
    known = draw.random() < 0.5
    return counts, draw.randint(0, 3) if known else 0, draw.randint(0, 3) if known else 0, 0 if known else draw.randint(0, 4)


def test_the_worst_case_is_the_least_of_everything_that_could_be() -> None:
    draw, mixed = random.Random(tiers.fresh(144)), 0
    for _ in range(TABLES):
        counts, selected, unselected, undecided = random_table(draw)
        found = worst_case(counts, selected, unselected, undecided)
        assert (None if found is None else found.ratio) == enumerated(counts, selected, unselected, undecided), counts
        mixed += found is not None and 0 < found.ratio < 1
    assert tiers.enough(mixed > TABLES // 10)


def test_people_of_known_and_of_unknown_decision_are_sent_together() -> None:
    draw = random.Random(tiers.fresh(5))
    for _ in range(60):
        counts = [(draw.randint(0, n), n) for n in (draw.randint(0, 6), draw.randint(1, 9))]
        found = worst_case(counts, 1, 2, 3)
        assert found is not None
        assert found.ratio == enumerated(counts, 1, 2, 3)


def test_it_is_the_end_that_theorem_t15_proves_of_a_ratio() -> None:
    draw = random.Random(tiers.fresh(15))
    for _ in range(30):
        sizes = [draw.randint(3, 40) for _ in range(draw.randint(2, 4))]
        counts = [(draw.randint(1, n - 1), n) for n in sizes]
        selected, unselected = draw.randint(0, 4), draw.randint(1, 4)
        groups = [*map(str, range(len(counts))), "?"]
        table: dict[str, Any] = {
            "group": [group for group in groups for _ in "yn"],
            "got": ["y", "n"] * len(groups),
            "n": [part for s, n in counts for part in (s, n - s)] + [selected, unselected],
        }
        document = fa.audit(
            table, decision="got", group="group", count="n", utility="y", unknown=["?"], confidence=None
        ).certificate.document
        ends = [claim["value"] for claim in document["claims"] if claim["by"] == "T15" and (claim["quantity"], claim["relation"]) == WORST]
        found = worst_case(counts, selected, unselected)
        assert found is not None
        assert [Fraction(end) for end in ends] == [1 / found.ratio]


def test_bisection_finds_what_trying_every_split_finds() -> None:
    draw = random.Random(tiers.fresh(7))
    for _ in range(300):
        n, m, undecided = draw.randint(1, 10**4), draw.randint(1, 10**4), draw.randint(1, 300)
        counts = [(draw.randint(1, n), n), (draw.randint(1, m), m)]
        tried = min(
            Fraction(s, k + a) / Fraction(t + undecided - a, r + undecided - a)
            for (s, k), (t, r) in (counts, counts[::-1])
            for a in range(undecided + 1)
        )
        found = worst_case(counts, undecided=undecided)
        assert found is not None
        assert found.ratio == tried


def test_counts_of_many_digits_are_exact() -> None:
    big = 10**60
    found = worst_case([(big, 2 * big), (big, 2 * big)], undecided=big)
    assert found is not None
    by_hand = min(Fraction(big, 2 * big + a) / Fraction(2 * big - a, 3 * big - a) for a in (0, big))
    assert found.ratio <= by_hand
    assert worst_case([(big, 2 * big), (big, 2 * big)], big, big) == WorstCase(Fraction(1, 3) / Fraction(2, 3), (0, 1))


@pytest.mark.parametrize(
    ("counts", "unknown", "ratio"),
    [
        ([(0, 0), (0, 0)], (0, 0, 0), None),
        ([(0, 5), (0, 7)], (0, 3, 0), Fraction(1)),
        ([(0, 5), (0, 7)], (1, 0, 0), Fraction(0)),
        ([(3, 5), (0, 0)], (0, 0, 0), Fraction(1)),
        ([(3, 5), (0, 0)], (0, 1, 0), Fraction(0)),
        ([(3, 5), (0, 0)], (1, 0, 0), Fraction(3, 5)),
        ([(3, 5)], (2, 2, 2), Fraction(1)),
    ],
)
def test_empty_categories_and_rates_of_nothing(
    counts: list[tuple[int, int]], unknown: tuple[int, int, int], ratio: Fraction | None
) -> None:
    found = worst_case(counts, *unknown)
    assert (None if found is None else found.ratio) == ratio
    assert enumerated(counts, *unknown) == ratio
