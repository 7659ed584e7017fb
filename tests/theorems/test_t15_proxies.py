"""T15, second part: groups that nobody recorded, by the probabilities of their cells.

All of it as often as promised: FAIRAUDIT_FULL=1 pytest -n0 tests/theorems/test_t15_proxies.py
"""

from __future__ import annotations

import random
from collections.abc import Sequence
from fractions import Fraction
from math import inf, isclose

import pytest
import tiers
from proxy_oracle import Program, Row, most_beyond, random_rows, random_shares

from fairaudit.errors import InputError
from fairaudit.theorems.t15_cells import Cells, beyond, level, mixture_means, proxy_cells, ratio
from fairaudit.theorems.t15_proxies import Completion, proxy_ends

TABLES, SMALL, INTERVALS = (500, 120, 500) if tiers.FULL else (60, 12, 40)


def known(rows: Sequence[Row]) -> list[Row]:
    """Groups that are there at all."""
    there = [a for a in range(len(rows[0][1])) if any(low[a] for _, low, _ in rows)]
    return [(gains, tuple(low[a] for a in there), tuple(high[a] for a in there)) for gains, low, high in rows]


def means_by_hand(rows: Sequence[Row], completion: Completion) -> list[Fraction]:
    """The means of groups in a completion, person by person."""
    groups = len(rows[0][1])
    sums, sizes = [Fraction(0)] * groups, [Fraction(0)] * groups
    assert sum(share for share, _ in completion.mixture) == 1
    for i, (gains, low, high) in enumerate(rows):
        size = sum(count for _, count in gains)
        own = completion.rows[i] if completion.rows else tuple(size * share for share in low)
        assert sum(own) == size
        assert all(size * one <= count <= size * other for one, count, other in zip(low, own, high, strict=True))
        for share, order in completion.mixture:
            assert share > 0 and sorted(order) == list(range(groups))
            left = sorted((gain, Fraction(count)) for gain, count in gains if count)
            for a in order:
                wanted = own[a]
                while wanted:
                    gain, count = left.pop(0)
                    taken = min(count, wanted)
                    sums[a] += share * gain * taken
                    wanted -= taken
                    left = [(gain, count - taken), *left] if taken < count else left
        sizes = [one + other for one, other in zip(sizes, own, strict=True)]
    return [total / size for total, size in zip(sums, sizes, strict=True)]


def least_by(program: Program, *, exact: bool) -> Fraction | float:
    """The least greatest ratio by linear programming; where nobody gets anything, all get the same."""
    if not any(gain * count for gains, _, _ in program.rows for gain, count in gains):
        return Fraction(1)
    status, value = (program.exactly if exact else program.highs)(*program.least())
    return inf if status == 2 else value


def pair_by(program: Program, a: int, b: int, sign: int, *, exact: bool) -> Fraction | float | None:
    """An end of a pair's ratio; None where the program says nothing because the second mean can be 0."""
    status, value = (program.exactly if exact else program.highs)(*program.quotient(a, b, sign))
    return {0: -sign * value, 3: inf}.get(status)


def compare_with_programs(rows: list[Row], *, exact: bool) -> bool:
    """Check all ends of known shares against linear programs; whether three or more groups have a least ratio that no pair shows."""
    found, program = proxy_ends(proxy_cells(rows, len(rows[0][1]))), Program(rows)

    def same(one: Fraction | float, other: Fraction | float) -> bool:
        return one == other if exact or inf in (one, other) else isclose(one, other, rel_tol=1e-7, abs_tol=1e-9)

    assert same(found.least.value, least_by(program, exact=exact))
    for (a, b), ((low, low_sharp), (high, high_sharp)) in found.pairs.items():
        assert low_sharp and high_sharp
        up = pair_by(program, a, b, 1, exact=exact)
        if up is not None and found.means[b][0] > 0:
            assert same(high, up)
        down = pair_by(program, a, b, -1, exact=exact)
        if down is not None:
            assert same(low, down)
    pairs = [ratio(low, high) for i, (low, _) in enumerate(found.means) for j, (_, high) in enumerate(found.means) if i != j]
    return found.least.value > max(Fraction(1), *pairs)


def check_attained(rows: list[Row]) -> None:
    """Every end of known shares is that of a constructed completion."""
    cells = proxy_cells(rows, len(rows[0][1]))
    found = proxy_ends(cells)
    for extreme, completion in ((found.least, found.low), (found.greatest, found.high)):
        means = means_by_hand(rows, completion)
        assert ratio(max(means), min(means)) == extreme.value == completion.ratio
        assert extreme.sharp
    for (a, b), ((low, _), (high, _)) in found.pairs.items():
        rest = tuple(c for c in range(cells.groups) if c not in (a, b))
        for order, end in (((a, *rest, b), low), ((b, *rest, a), high)):
            means = means_by_hand(rows, Completion(1, ((Fraction(1), order),)))
            assert ratio(means[a], means[b]) == end


def test_the_example_of_the_page() -> None:
    def cell(successes: int, share: Fraction) -> Row:
        shares = (share, 1 - share)
        return [(Fraction(1), successes), (Fraction(0), 4 - successes)], shares, shares

    found = proxy_ends(proxy_cells([cell(2, Fraction(4, 5)), cell(3, Fraction(1, 5))], 2))
    assert found.means == ((Fraction(3, 10), Fraction(7, 10)), (Fraction(11, 20), Fraction(19, 20)))
    assert found.pairs[0, 1] == ((Fraction(6, 19), True), (Fraction(14, 11), True))
    assert (found.least.value, found.greatest.value) == (1, Fraction(19, 6))


@pytest.mark.parametrize("groups", [2, 3, 4])
def test_ends_are_those_of_linear_programs(groups: int) -> None:
    rng = random.Random(tiers.fresh(groups))
    beyond_pairs = sum(compare_with_programs(random_rows(rng, groups), exact=False) for _ in range(TABLES))
    assert (beyond_pairs > 0) == (groups > 2)


@pytest.mark.parametrize("groups", [2, 3])
def test_ends_are_exactly_those_of_small_programs(groups: int) -> None:
    rng = random.Random(10 + groups)
    for _ in range(SMALL):
        compare_with_programs(random_rows(rng, groups, cells=2), exact=True)


@pytest.mark.parametrize("groups", [2, 3, 4])
def test_each_end_is_attained_by_a_constructed_completion(groups: int) -> None:
    rng = random.Random(20 + groups)
    for _ in range(TABLES):
        check_attained(random_rows(rng, groups))


def test_many_groups_are_levelled() -> None:
    rng = random.Random(tiers.fresh(3))
    for _ in range(5):
        check_attained(random_rows(rng, 6))


def test_what_nobody_gets_is_alike_and_what_only_some_can_get_is_infinite() -> None:
    whole, none = (Fraction(1), Fraction(0)), (Fraction(0), Fraction(1))
    alike = proxy_ends(proxy_cells([([(Fraction(0), 3)], whole, whole), ([(Fraction(0), 2)], none, none)], 2))
    assert (alike.least.value, alike.greatest.value) == (1, 1)
    apart = proxy_ends(proxy_cells([([(Fraction(0), 3)], whole, whole), ([(Fraction(1), 2)], none, none)], 2))
    assert (apart.least.value, apart.greatest.value, apart.low.ratio) == (inf, inf, inf)
    assert apart.pairs[0, 1] == ((Fraction(0), True), (Fraction(0), True))


@pytest.mark.parametrize("groups", [2, 3, 4])
def test_intervals_are_sound_and_their_completions_possible(groups: int) -> None:
    rng = random.Random(30 + groups)
    sharp = 0
    for _ in range(INTERVALS):
        rows = random_rows(rng, groups, intervals=True)
        found = proxy_ends(proxy_cells(rows, groups))
        for extreme, completion in ((found.least, found.low), (found.greatest, found.high)):
            means = means_by_hand(rows, completion)
            assert ratio(max(means), min(means)) == completion.ratio
            assert extreme.sharp == (completion.ratio == extreme.value)
        assert found.least.value <= found.low.ratio <= found.greatest.value
        assert found.least.value <= found.high.ratio <= found.greatest.value
        sharp += found.greatest.sharp
        for _ in range(6):
            shares = [random_shares(rng, row) for row in rows]
            inside = proxy_ends(proxy_cells([(gains, own, own) for (gains, _, _), own in zip(rows, shares, strict=True)], groups))
            assert found.least.value <= inside.least.value and inside.greatest.value <= found.greatest.value
            for pair, ((low, _), (high, _)) in inside.pairs.items():
                assert found.pairs[pair][0][0] <= low and high <= found.pairs[pair][1][0]
            for (low, high), (least, most) in zip(inside.means, found.means, strict=True):
                assert least <= low and high <= most
    assert sharp


@pytest.mark.parametrize("groups", [2, 3, 4])
def test_means_within_intervals_are_those_of_linear_programs_and_sharp_where_two_are_had_at_once(groups: int) -> None:
    rng = random.Random(45 + groups)
    said = set()
    for _ in range(INTERVALS):
        rows = random_rows(rng, groups, intervals=True)
        found = proxy_ends(proxy_cells(rows, groups))
        for a, (least, most) in enumerate(found.means):
            assert abs(most_beyond(rows, [(a, most, 1)])) < 1e-7
            assert abs(most_beyond(rows, [(a, least, -1)])) < 1e-7
        for (a, b), ((_, low_sharp), (_, high_sharp)) in found.pairs.items():
            for higher, lower, sharp in ((a, b, high_sharp), (b, a, low_sharp)):
                together = most_beyond(rows, [(higher, found.means[higher][1], 1), (lower, found.means[lower][0], -1)])
                assert sharp == (together > -1e-7)
                said.add(sharp)
    assert tiers.enough(said == {True, False})


def test_an_end_that_is_called_sharp_is_reached() -> None:
    """By shares on a grid that holds the ends: where the slices fit the greatest ratio is there, and never is it beyond."""
    rng = random.Random(tiers.fresh(40))
    reached = 0
    for _ in range(30):
        rows = random_rows(rng, 2, intervals=True, cells=2)
        found = proxy_ends(proxy_cells(rows, 2))
        for (a, b), ends in found.pairs.items():
            turns = [sorted({low[a], high[a], *(Fraction(k, size) for k in range(size + 1) if low[a] <= Fraction(k, size) <= high[a])})
                     for gains, low, high in rows for size in [sum(count for _, count in gains)]]  # fmt: skip
            options = [[own] for own in turns[0]]
            for turn in turns[1:]:
                options = [[*one, own] for one in options for own in turn]
            inside = []
            for option in options:
                shares = [(own, 1 - own) for own in option]
                inside.append(proxy_ends(proxy_cells([(g, s, s) for (g, _, _), s in zip(rows, shares, strict=True)], 2)).pairs[a, b])
            if ends[1][1]:
                reached += 1
                assert max(high for _, (high, _) in inside) == ends[1][0]
            if ends[0][1]:
                assert min(low for (low, _), _ in inside) == ends[0][0]
    assert reached


def test_known_shares_as_intervals_say_the_same() -> None:
    rng = random.Random(tiers.fresh(50))
    rows = random_rows(rng, 3)
    wider = [(gains, low, tuple(min(Fraction(1), share + Fraction(1, 10**9)) for share in high)) for gains, low, high in rows]
    exact, loose = proxy_ends(proxy_cells(rows, 3)), proxy_ends(proxy_cells(wider, 3))
    assert loose.greatest.value >= exact.greatest.value and loose.least.value <= exact.least.value


def test_levelling_mixes_few_orders() -> None:
    rng = random.Random(tiers.fresh(60))
    for _ in range(20):
        cells: Cells = proxy_cells(random_rows(rng, 5), 5)
        mixture = level(cells)
        assert len(mixture) <= 5
        assert ratio(max(mixture_means(cells, mixture)), min(mixture_means(cells, mixture))) == proxy_ends(cells).least.value


def test_ties_count_with_what_is_beyond_where_they_are_asked_for() -> None:
    [cell] = proxy_cells([([(Fraction(0), 3), (Fraction(1), 2)], (Fraction(1),), (Fraction(1),))], 1).cells
    assert [beyond(cell, Fraction(0), up=False, ties=ties) for ties in (False, True)] == [0, 3]


def test_too_many_groups_are_refused() -> None:
    shares = tuple([Fraction(1, 9)] * 9)
    with pytest.raises(InputError, match="9 groups are too many"):
        proxy_ends(proxy_cells([([(Fraction(1), 9)], shares, shares)], 9))
