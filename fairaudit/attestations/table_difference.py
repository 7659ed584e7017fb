"""Where two canonical tables differ: labels of the header, cells that only one of them has, and the first cell with other numbers."""

from __future__ import annotations

import json
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from fairaudit.errors import InputError, shown
from fairaudit.words import brief, noun

__all__ = ["DifferentCell", "TableDifference", "compare_tables"]

LISTED = 3  # labels, and numbers of a cell, that are shown
LABELS = ("decisions", "groups", "contexts", "truths")
SAID_OTHERWISE = ("salt", "profiles", "utility", *LABELS)

Row = Mapping[str, Any]

Key = tuple[int, Any, Any]
"""What kind of row it is, and its context and group: their places in an order, or their labels."""


@dataclass(frozen=True)
class DifferentCell:
    """A cell that two tables do not agree on.

    Attributes
    ----------
    context, group : dict of str to str
        Its labels by column; the group is empty where it is not known.
    numbers : tuple of (str, str or None, str or None)
        What differs: of what, in the certificate, and in the log; None where there is no such cell.
    """

    context: dict[str, str]
    group: dict[str, str]
    numbers: tuple[tuple[str, str | None, str | None], ...]

    @property
    def sentence(self) -> str:
        """Where it is, and both numbers."""
        labels = [f"{name}={shown(label)}" for name, label in (*self.context.items(), *self.group.items())]
        where = ", ".join(labels if self.group else [*labels, "group unknown"])
        if None in self.numbers[0][1:]:
            place = "certificate" if self.numbers[0][2] is None else "log"
            listed = [f"{what} {_said(own if other is None else other)}" for what, own, other in self.numbers[:LISTED]]
            return f"{where}, which is in the {place} alone: {', '.join(listed + self._more)}"
        listed = [f"{what} {_said(own)} in the certificate, {_said(other)} in the log" for what, own, other in self.numbers[:LISTED]]
        return f"{where}: {'; '.join(listed + self._more)}"

    @property
    def _more(self) -> list[str]:
        return [f"and {more} more {noun(more, 'number')}"] if (more := len(self.numbers) - LISTED) > 0 else []


@brief
@dataclass(frozen=True, repr=False)
class TableDifference:
    """In what two tables differ.

    Attributes
    ----------
    header : tuple of str
        Sentences about columns, labels and utilities that differ.
    cells : int
        How many cells have other numbers, or are in one of the tables alone.
    missing, further : int
        How many of them are in the certificate alone, and in the log alone.
    first : DifferentCell or None
        The first of them.
    """

    header: tuple[str, ...]
    cells: int = 0
    missing: int = 0
    further: int = 0
    first: DifferentCell | None = None

    @property
    def sentences(self) -> tuple[str, ...]:
        """What differs, in words."""
        if self.first is None:
            return self.header
        alone = [f"{n} of them in the {where} alone" for n, where in ((self.missing, "certificate"), (self.further, "log")) if n]
        count = "1 cell differs" if self.cells == 1 else f"{self.cells} cells differ"
        return (f"the first differing cell is {self.first.sentence}", ", ".join([count, *alone]), *self.header)


def compare_tables(theirs: Iterable[bytes], ours: Iterable[bytes]) -> TableDifference:
    r"""Compare the canonical text of a certificate's table with that of a log.

    Parameters
    ----------
    theirs, ours : iterable of bytes
        The lines of the certificate's table, and of the log's. Where the labels of both are the same, or sorted as those of logs are, a
        line of each is held at a time.

    Raises
    ------
    InputError
        If a line is not one of such a table.

    Examples
    --------
    >>> header = {"columns": {"context": [], "group": ["sex"]}, "contexts": [[]], "groups": [["f"]], "decisions": ["no", "yes"]}
    >>> tables = [[{**header, "utility": None}, {"context": 0, "group": 0, "weights": ["3", str(n)]}] for n in (4, 5)]
    >>> found = compare_tables(*([json.dumps(line).encode() for line in lines] for lines in tables))
    >>> print(found.first.sentence)
    sex='f': decision 'yes' 4 in the certificate, 5 in the log
    """
    left, right = iter(theirs), iter(ours)
    try:
        heads = _Head.of(next(left, b"")), _Head.of(next(right, b""))
        return _compared(left, right, *heads)
    except (KeyError, IndexError, TypeError, ValueError, AttributeError) as error:
        if isinstance(error, InputError):
            raise
        raise InputError("this is no table of a certificate; fairaudit verify says what is wrong with it") from None


@dataclass(frozen=True)
class _Head:
    """The first line of a table, with its labels."""

    held: Mapping[str, Any]
    decisions: Sequence[str]
    groups: Sequence[tuple[str, ...]]
    contexts: Sequence[tuple[str, ...]]

    @staticmethod
    def of(line: bytes) -> _Head:
        held = json.loads(line)
        return _Head(held, held["decisions"], [*map(tuple, held["groups"])], [*map(tuple, held["contexts"])])

    @property
    def sorted(self) -> bool:
        """Whether the order of cells is that of their labels."""
        return list(self.groups) == sorted(self.groups) and list(self.contexts) == sorted(self.contexts)

    def numbers(self, row: Row) -> dict[str, str]:
        """What a row says, by what it is of; zeros are left out, which a decision that another table does not list has, too."""
        found = {name: str(row[name]) for name in ("mass", "draws") if name in row}
        for decision, number in zip(self.decisions, row.get("weights", row.get("unknown", ())), strict=False):
            found[f"decision {shown(decision)}"] = number
        for truth, numbers in zip(self.held.get("truths", ()), row.get("truth", ()), strict=False):
            for decision, number in zip(self.decisions, numbers, strict=True):
                found[f"decision {shown(decision)} where {shown(truth)} is true"] = number
        for decision, number in zip(self.decisions, row.get("utility", ()), strict=False):
            found[f"utility of {shown(decision)}"] = "none" if number is None else number
        return {what: number for what, number in found.items() if number != "0"}

    def labels(self, row: Row) -> tuple[dict[str, str], dict[str, str]]:
        """Labels of the context and of the group of a row, by column."""
        _, x, a = _place(row)
        columns = self.held["columns"]
        group = {} if a < 0 else dict(zip(columns["group"], self.groups[a], strict=True))
        return dict(zip(columns["context"], self.contexts[x], strict=True)), group


def _compared(left: Iterator[bytes], right: Iterator[bytes], theirs: _Head, ours: _Head) -> TableDifference:
    cells = missing = further = 0
    first: DifferentCell | None = None
    for own, other in _paired(left, right, theirs, ours):
        numbers = _differing(None if own is None else theirs.numbers(own), None if other is None else ours.numbers(other))
        if not numbers:
            continue
        cells, missing, further = cells + 1, missing + (other is None), further + (own is None)
        if first is None:
            first = DifferentCell(*(theirs.labels(own) if own is not None else ours.labels(other)), numbers)
    return TableDifference(tuple(_of_header(theirs, ours)), cells, missing, further, first)


def _differing(own: Mapping[str, str] | None, other: Mapping[str, str] | None) -> tuple[tuple[str, str | None, str | None], ...]:
    """The numbers that differ."""
    if own is None or other is None:
        return tuple(
            (what, None if own is None else number, None if other is None else number) for what, number in (own or other or {}).items()
        )
    both = dict.fromkeys((*own, *other))
    return tuple((what, own.get(what, "0"), other.get(what, "0")) for what in both if own.get(what) != other.get(what))


def _paired(left: Iterator[bytes], right: Iterator[bytes], theirs: _Head, ours: _Head) -> Iterator[tuple[Any, Any]]:
    """Rows of one cell; None where one of the tables does not have it, and nothing where the lines are the same."""
    same = all(theirs.held.get(name) == ours.held.get(name) for name in LABELS)
    if same:
        yield from _merged(left, right, _place, _place, alike=True)
    elif theirs.sorted and ours.sorted:
        x = {label: at for at, label in enumerate(sorted({*theirs.contexts, *ours.contexts}))}
        a = {label: at for at, label in enumerate(sorted({*theirs.groups, *ours.groups}))}
        places = [([x[label] for label in head.contexts], [a[label] for label in head.groups]) for head in (theirs, ours)]
        yield from _merged(left, right, *(_at(*own) for own in places), alike=False)
    else:
        keys = [_at(head.contexts, head.groups) for head in (theirs, ours)]
        held = {keys[0](row): row for row in map(json.loads, left)}
        for row in map(json.loads, right):
            yield held.pop(keys[1](row), None), row
        yield from ((row, None) for row in held.values())


def _merged(left: Iterator[bytes], right: Iterator[bytes], of_left: Any, of_right: Any, *, alike: bool) -> Iterator[tuple[Any, Any]]:
    """Rows with the same key side by side, of two tables in the order of keys."""
    one, two = next(left, None), next(right, None)
    while one is not None or two is not None:
        if alike and one == two:
            one, two = next(left, None), next(right, None)
            continue
        own, other = (None if line is None else json.loads(line) for line in (one, two))
        here, there = None if own is None else of_left(own), None if other is None else of_right(other)
        alone = there is None or (here is not None and here < there)
        further = not alone and (here is None or there < here)
        yield None if further else own, None if alone else other
        one, two = one if further else next(left, None), two if alone else next(right, None)


def _place(row: Row) -> tuple[int, int, int]:
    """Which kind of row it is, and the places of its context and group; the group is −1 where it is not known."""
    if "true_context" in row:
        return 2, row["true_context"], row["true_group"]
    return (1, row["context"], -1) if "unknown" in row else (0, row["context"], row["group"])


def _at(contexts: Sequence[Any], groups: Sequence[Any]) -> Any:
    """What tells the rows of a table apart, with other names for its contexts and groups."""

    def key(row: Row) -> Key:
        kind, x, a = _place(row)
        return kind, contexts[x], -1 if a < 0 else groups[a]

    return key


def _of_header(theirs: _Head, ours: _Head) -> Iterator[str]:
    """Say what differs in the first lines."""
    for name in sorted({*theirs.held, *ours.held}.difference(SAID_OTHERWISE)):
        own, other = theirs.held.get(name), ours.held.get(name)
        if own != other:
            yield f"{name}: {shown(own)} in the certificate, {shown(other)} in the log"
    for name in LABELS:
        labels = [[*map(_label, head.held.get(name, ()))] for head in (theirs, ours)]
        sets = [{*labels[0]}, {*labels[1]}]
        alone = [[label for label in labels[0] if label not in sets[1]], [label for label in labels[1] if label not in sets[0]]]
        found = [f"{_listed(these)} in the {where} alone" for these, where in zip(alone, ("certificate", "log"), strict=True) if these]
        if found:
            yield f"{name}: {'; '.join(found)}"
        elif labels[0] != labels[1]:
            yield f"{name}: the same in another order"
    if (theirs.held.get("profiles") or {}) != (ours.held.get("profiles") or {}):
        yield "sampling units: those that were seen in several groups got something else there"
    own, other = theirs.held["utility"], ours.held["utility"]
    if own is None or other is None:
        if own != other:
            yield f"utility: one number for each decision in the {'log' if own is None else 'certificate'} alone"
        return
    worth = dict(zip(theirs.decisions, own, strict=True)), dict(zip(ours.decisions, other, strict=True))
    for decision, number in worth[0].items():
        if decision in worth[1] and worth[1][decision] != number:
            yield f"utility of {shown(decision)}: {_said(number)} in the certificate, {_said(worth[1][decision])} in the log"


def _label(label: Any) -> str:
    return shown(label) if isinstance(label, str) else ", ".join(map(shown, label)) or "(none)"


def _listed(labels: Sequence[str]) -> str:
    return ", ".join(labels[:LISTED]) + (f" and {len(labels) - LISTED} more" if len(labels) > LISTED else "")


def _said(number: str | None) -> str:
    return "nothing" if number is None else number if len(number) <= 60 else f"{number[:59]}…"
