"""Where two tables differ: the first cell, what only one of them has, and labels; against a plain comparison of dictionaries."""

from __future__ import annotations

import json
from collections.abc import Mapping
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from fairaudit import InputError, Law
from fairaudit.attestations.table_difference import TableDifference, compare_tables
from fairaudit.certificates.table import Table
from fairaudit.model.utility import Utility

Counts = dict[tuple[str, str, str], int]
"""Decisions by context, group and decision."""

labels = st.sampled_from(["a", "b", "c", "d"])
keys = st.tuples(labels, st.sampled_from(["f", "m", "x"]), st.sampled_from(["no", "yes", "wait"]))
counts = st.dictionaries(keys, st.integers(1, 4), min_size=2, max_size=12).filter(lambda held: len({a for _, a, _ in held}) > 1)
TWO = {("a", "f", "yes"): 1, ("a", "m", "yes"): 1}


def lines(held: Counts, *, as_log: bool = True) -> list[bytes]:
    """The canonical text of a table of counts, with sorted labels as a log has them or in order of appearance."""
    table: dict[str, list[Any]] = {"x": [], "a": [], "u": [], "n": []}
    for (x, a, u), n in held.items():
        for name, value in zip("xaun", (x, a, u, n), strict=True):
            table[name] += [value] * n if as_log else [value]
    columns: Mapping[str, Any] = {"decision": "u", "group": "a", "context": "x"}
    law = Law.from_log(table, **columns) if as_log else Law.from_counts(table, **columns, count="n")
    worth = Utility({"yes": 1, "no": 0, "wait": 0}).on(law)
    return list(Table(worth.law, worth).lines())


def by_cell(held: Counts) -> dict[tuple[str, str], dict[str, int]]:
    cells: dict[tuple[str, str], dict[str, int]] = {}
    for (x, a, u), n in held.items():
        cells.setdefault((x, a), {})[u] = n
    return cells


def check(found: TableDifference, theirs: Counts, ours: Counts) -> None:
    own, other = by_cell(theirs), by_cell(ours)
    different = sorted(cell for cell in {*own, *other} if own.get(cell) != other.get(cell))
    assert found.cells == len(different)
    assert found.missing == sum(cell not in other for cell in different)
    assert found.further == sum(cell not in own for cell in different)
    if not different:
        assert found.first is None
        return
    assert found.first is not None
    cell = (found.first.context["x"], found.first.group["a"])
    assert cell in different
    said = {what: (theirs, ours) for what, theirs, ours in found.first.numbers}
    held = own.get(cell), other.get(cell)
    expected = {}
    for u in ("no", "wait", "yes"):
        pair = tuple(None if side is None else str(side.get(u, 0)) for side in held)
        if len(set(pair)) > 1 and pair not in ((None, "0"), ("0", None)):
            expected[f"decision {u!r}"] = pair
    assert said == expected
    assert found.sentences[0] == f"the first differing cell is {found.first.sentence}"
    assert f"x='{cell[0]}', a='{cell[1]}'" in found.first.sentence


@given(counts, counts)
def test_the_difference_of_logs_is_that_of_their_cells(theirs: Counts, ours: Counts) -> None:
    found = compare_tables(lines(theirs), lines(ours))
    check(found, theirs, ours)
    own, other = by_cell(theirs), by_cell(ours)
    if found.first is not None:  # logs have an order, and the first is the first in it
        assert (found.first.context["x"], found.first.group["a"]) == min(c for c in {*own, *other} if own.get(c) != other.get(c))


@given(counts, counts)
def test_the_difference_of_tables_in_any_order_is_that_of_their_cells(theirs: Counts, ours: Counts) -> None:
    check(compare_tables(lines(theirs, as_log=False), lines(ours, as_log=False)), theirs, ours)


@given(counts)
def test_nothing_differs_from_itself(held: Counts) -> None:
    found = compare_tables(lines(held), lines(held))
    assert found == TableDifference(()) and found.sentences == ()


def test_what_a_header_says_otherwise_is_said() -> None:
    header = {**json.loads(lines(TWO)[0]), "groups": [["f"]], "decisions": ["no", "wait", "yes"], "utility": ["0", "0", "1"]}
    row = b'{"context":0,"group":0,"weights":["0","0","1"]}\n'

    def said(**changes: Any) -> tuple[str, ...]:
        return compare_tables([json.dumps(header).encode(), row], [json.dumps(header | changes).encode(), row]).header

    assert said() == said(salt="1", profiles={}) == ()
    assert said(kind="probabilities") == ("kind: 'counts' in the certificate, 'probabilities' in the log",)
    assert said(utility=["0", "1/2", "1"]) == ("utility of 'wait': 0 in the certificate, 1/2 in the log",)
    assert said(utility=None) == ("utility: one number for each decision in the certificate alone",)
    assert said(decisions=["no", "later", "yes"]) == ("decisions: 'wait' in the certificate alone; 'later' in the log alone",)
    assert said(truths=["t"]) == ("truths: 't' in the log alone",)
    assert said(groups=[["m\x1b"]]) == ("groups: 'f' in the certificate alone; 'm\\x1b' in the log alone",)


def test_rows_of_unknown_group_masses_truths_and_utilities_are_compared() -> None:
    header = {
        "columns": {"context": ["x"], "group": ["a"]},
        "contexts": [["u"]],
        "groups": [["f"]],
        "decisions": ["no", "yes"],
        "truths": ["t"],
    }
    row = {"context": 0, "group": 0, "weights": ["1", "2"], "mass": "1/2", "truth": [["1", "2"]], "utility": ["0", None]}
    unknown = {"context": 0, "unknown": ["0", "3"]}

    def sentence(**changes: Any) -> str:
        texts = [[json.dumps(entry).encode() for entry in ({**header, "utility": None}, own, other)] for own, other in changes["pairs"]]
        found = compare_tables(*texts)
        return "" if found.first is None else found.first.sentence

    assert sentence(pairs=[(row, unknown), (row, unknown)]) == ""
    assert (
        sentence(pairs=[(row, unknown), ({**row, "mass": "1/3"}, unknown)]) == "x='u', a='f': mass 1/2 in the certificate, 1/3 in the log"
    )
    assert "decision 'yes' where 't' is true 2 in the certificate, 1 in the log" in sentence(
        pairs=[(row, unknown), ({**row, "truth": [["1", "1"]]}, unknown)]
    )
    assert "utility of 'yes' none in the certificate, 1 in the log" in sentence(
        pairs=[(row, unknown), ({**row, "utility": ["0", "1"]}, unknown)]
    )
    assert sentence(pairs=[(row, unknown), (row, {**unknown, "unknown": ["0", "4"]})]) == (
        "x='u', group unknown: decision 'yes' 3 in the certificate, 4 in the log"
    )


@pytest.mark.parametrize("text", [b"", b"[]", b"{}", b"nonsense", b'{"decisions":1,"groups":[],"contexts":[]}'])
def test_what_is_no_table_is_refused(text: bytes) -> None:
    good = lines(TWO)
    with pytest.raises(InputError, match="no table of a certificate"):
        compare_tables([text], good)
    with pytest.raises(InputError, match="no table of a certificate"):
        compare_tables([*good, b'{"context":9}'], good)
