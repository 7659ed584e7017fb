"""Rows of small integers are counted as a plain loop counts them, however many combinations there are, in blocks, pairs and threads."""

from __future__ import annotations

from collections import Counter
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from logs import counts

from fairaudit.tables import coded
from fairaudit.tables.coded import Coded, UnknownValueError, coded_column, count_combinations
from fairaudit.tables.engines.logs import read_log

KINDS = ("i1", "u1", "i2", ">i2", "u2", "i4", ">u4", "i8", ">i8", "u8", "bool")
SPANS = ((1,), (2, 5, 3, 4, 2), (16, 16), (257,), (256, 256), (65537,), (1000, 1000), (2, 2, 2))  # below, at and above a byte and two


@given(st.data())
def test_combinations_are_counted_as_a_loop_counts_them(data: st.DataObject) -> None:
    rows = data.draw(st.integers(1, 40))
    block = data.draw(st.sampled_from([1, 2, 3, 4, 100]))
    columns, plain = [], []
    for span in data.draw(st.sampled_from(SPANS)):
        low = data.draw(st.sampled_from([-1, 0, 3, -200, 2**40]))
        held = np.array(data.draw(st.lists(st.integers(low, low + span - 1), min_size=rows, max_size=rows)))
        fitting = [kind for kind in KINDS if (held.astype(kind) == held).all() and (kind != "bool" or span <= 2)]
        held = held.astype(data.draw(st.sampled_from(fitting)))
        if data.draw(st.booleans()):
            held = np.repeat(held, 2)[::2]  # with gaps in memory
        columns.append(Coded.of(held, list(range(low, low + span)), low))
        plain.append(held.tolist())
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(coded, "BLOCK_ROWS", block)
        found = list(count_combinations(columns))
    assert len({row[:-1] for row in found}) == len(found)
    assert {(*values,): count for *values, count in found} == Counter(zip(*plain, strict=True))


@given(st.data())
def test_categories_that_are_missing_after_the_first_rows_are_counted(data: st.DataObject) -> None:
    import pandas as pd

    rows = data.draw(st.integers(1, 30))
    levels = ["unused", "m", "f", *map(str, range(data.draw(st.sampled_from([0, 130, 300]))))]  # codes of one byte and of two
    places = data.draw(st.lists(st.integers(-1, len(levels) - 1), min_size=rows, max_size=rows))
    numbers = data.draw(st.lists(st.sampled_from([0, 1, -1, 255, -(2**63), 2**63 - 1]), min_size=rows, max_size=rows))
    frame = pd.DataFrame({"a": pd.Categorical.from_codes(places, levels), "n": np.array(numbers, dtype=np.int64)})
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(coded, "SAMPLE", data.draw(st.sampled_from([1, 2, 100])))
        patch.setattr(coded, "BLOCK_ROWS", data.draw(st.sampled_from([1, 2, 100])))
        found = counts(read_log(frame, ["a", "n"]))
        alone = counts(read_log(frame, ["a"]))
    expected = [(None if place < 0 else levels[place], number) for place, number in zip(places, numbers, strict=True)]
    assert found == Counter(expected)
    assert alone == Counter((label,) for label, _ in expected)


@pytest.mark.parametrize("held", [[0, 1, 0, -1], [0, 1, 0, 2], [0, 0, 0, -(2**63)], [3, 4, 3, 2], [3, 4, 3, 5]])
def test_what_a_sample_lacks_is_never_taken_for_something_else(held: list[int], monkeypatch: pytest.MonkeyPatch) -> None:
    import pandas as pd

    monkeypatch.setattr(coded, "SAMPLE", 3)
    columns: list[Any] = [np.array(held)]
    if max(held) < 3 and min(held) == -1:
        columns.append(pd.Series(pd.Categorical.from_codes(held, ["x", "y", "z"])))
    for column in columns:
        with pytest.raises(UnknownValueError):
            list(count_combinations([coded_column(column, sampled=True)]))  # type: ignore[list-item]


def test_two_rows_in_one_step_are_two_rows(monkeypatch: pytest.MonkeyPatch) -> None:
    """In more blocks than cores, the last of an odd length."""
    monkeypatch.setattr(coded, "BLOCK_ROWS", 1 << 10)
    generator = np.random.default_rng(7)
    columns = [generator.integers(0, span, 100_001).astype(np.int8) for span in (2, 5, 3, 4, 2)]
    found = list(count_combinations([coded_column(column) for column in columns]))  # type: ignore[misc]
    assert {(*values,): number for *values, number in found} == Counter(zip(*(column.tolist() for column in columns), strict=True))
