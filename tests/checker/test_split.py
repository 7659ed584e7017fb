"""The split of draws into halves, as the checker does it again."""

from __future__ import annotations

from fractions import Fraction

import pytest
import split_oracle
from hypothesis import given
from hypothesis import strategies as st

from fairaudit.checker import rows, split, text, work
from fairaudit.checker.intervals import Unproven

F = Fraction
CELL = st.integers(0, 30).flatmap(lambda n: st.tuples(st.integers(0, n), st.just(n)))
SEED = "0123456789abcdef" * 4


@given(st.lists(st.lists(CELL, min_size=2, max_size=4), min_size=1, max_size=3))
def test_it_is_that_of_the_page(counts: list[list[tuple[int, int]]]) -> None:
    names = [[b"%d %d" % (b, i) for i in range(len(block))] for b, block in enumerate(counts)]
    named = [dict(zip(*part, strict=True)) for part in zip(names, counts, strict=True)]
    together = {name: own for block in named for name, own in block.items()}
    seed = split.seed_of(names, counts)
    assert seed == split_oracle.seed(together)
    halves = [[split.halves_of(seed, name, own) for name, own in block.items()] for block in named]
    expected = {name: split_oracle.first_half(seed, name, *own) for name, own in together.items()}
    assert [first for block in halves for first, _ in block] == [*expected.values()]
    whole = [(a + c, b + d) for block in halves for (a, b), (c, d) in block]
    assert whole == [*together.values()]
    chosen = split.chosen_by([[first for first, _ in block] for block in halves], [[F(1)] * len(block) for block in counts], names)
    found = None if chosen is None else (names[chosen[0]][chosen[1]], names[chosen[0]][chosen[2]])
    assert found == split_oracle.choice(named, expected)


def test_what_a_success_is_worth_counts() -> None:
    names = [[b"a", b"b", b"c"]]
    assert split.chosen_by([[(5, 10), (4, 10), (1, 10)]], [[F(1), F(1), F(1)]], names) == (0, 0, 2)
    assert split.chosen_by([[(5, 10), (4, 10), (1, 10)]], [[F(1), F(2), F(1)]], names) == (0, 1, 2)
    assert split.chosen_by([[(5, 10), (4, 10), (1, 10)]], [[F(1), F(1), F(40)]], names) == (0, 2, 1)


def test_ties_go_to_the_first_names_whatever_the_order() -> None:
    halves = [[(5, 10), (1, 10), (5, 10), (1, 10)]]
    assert split.chosen_by(halves, [[F(1)] * 4], [[b"d", b"c", b"b", b"a"]]) == (0, 2, 3)
    assert split.chosen_by(halves, [[F(1)] * 4], [[b"a", b"b", b"c", b"d"]]) == (0, 0, 1)


def test_draws_are_paid_for_before_they_are_split() -> None:
    with pytest.raises(Unproven, match="at most 1000000 draws"):
        split.seed_of([[b"a", b"b"]], [[(0, 10**6), (0, 1)]])
    token = work.CURRENT_WORK.set(work.Work(10**6))
    try:
        with pytest.raises(text.TooMuch):
            split.halves_of(SEED, b"a", (1, 10**6))
    finally:
        work.CURRENT_WORK.reset(token)


def test_long_labels_are_paid_for() -> None:
    """Each cell's name has the label of its context, however long that is."""
    names = [{"context": 0, "group": i, "weights": ["1", "1"]} for i in range(1_000)]
    header = {
        "format": "fairaudit-table/1",
        "kind": "counts",
        "columns": {"decision": "d", "group": ["g"], "context": ["c"]},
        "population": "counts",
        "decisions": ["yes", "no"],
        "groups": [[str(i)] for i in range(1_000)],
        "contexts": [["x" * 300_000]],
        "utility": ["1", "0"],
    }
    table = rows.read_table((f"line {i}", value, None) for i, value in enumerate([header, *names]))
    token = work.CURRENT_WORK.set(work.Work())
    try:
        with pytest.raises(text.TooMuch):
            split.names_of_cells("local", table)
    finally:
        work.CURRENT_WORK.reset(token)
