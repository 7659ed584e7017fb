"""Columns of samples: where their values stand in a row, beside it or in what a file says of itself, and how values are counted."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from decimal import Decimal
from pathlib import Path as File
from typing import Any

from fairaudit.errors import InputError, nearest, shown
from fairaudit.tables.evaluations.paths import ABSENT, Path, is_path, read_path, written_path

__all__ = ["SAID", "TRUTH", "Column", "clean", "file_names", "known_paths", "meant", "plain"]

SAID = ("file", "eval.model", "eval.task")
"""Columns that a file has as a whole, where its samples do not say otherwise."""

TRUTH = {True: ("true",), False: ("false",)}  # stand for truth values, which to Python are equal to 1 and 0


@dataclass
class Column:
    """A column, and where its values were found: one that comes from two places is refused."""

    name: str
    path: Path | None
    inner: tuple[Any, ...] | None
    found: set[str] = field(default_factory=set)

    @staticmethod
    def named(name: str) -> Column:
        """The column of a name, which may be a path."""
        try:
            path = read_path(name)
        except InputError:  # a column may have any name, and where there is none `reading` says what is wrong
            return Column(name, None, None)
        if path.each is not None:
            return Column(name, path, path.steps[path.each + 1 :])
        return Column(name, path if path.argmax or path.steps != (name,) else None, None)

    def of(self, row: Mapping[str, Any], beside: Mapping[str, Any], said: Mapping[str, Any]) -> Any:
        """The value in a row, or in what was joined to it, or in what the file says of all its rows."""
        value = row.get(self.name, ABSENT)
        if value is not ABSENT:
            self.found.add("column")
            return value
        if self.path is not None and self.inner is None:
            value = self.path.of(row)
            if value is not ABSENT:
                self.found.add("path")
                return value
        if self.name in beside:
            self.found.add("join")
            return beside[self.name]
        if self.name in said:
            self.found.add("file")
            return said[self.name]
        return ABSENT


def clean(value: Any, name: str) -> Any:
    """A value as it is counted: nothing, a text, a number, or what stands for a truth value."""
    kind = type(value)
    if kind is str or kind is int or value is None:
        return value
    if value is ABSENT:
        return None
    if kind is bool:
        return TRUTH[value]
    if kind is float:
        value = Decimal(repr(value))
    if isinstance(value, Decimal):
        if not value.is_finite():
            raise InputError(f"{shown(name, 200)} is {value}, which is not a JSON value")
        return value
    if isinstance(value, list):
        raise InputError(f"{shown(name, 200)} is a list with {len(value)} element{'s' * (len(value) != 1)}{_inside(value, name)}")
    if isinstance(value, Mapping):
        raise InputError(f"{shown(name, 200)} is an object{_inside(value, name)}")
    return value


def _inside(value: Sequence[Any] | Mapping[str, Any], name: str) -> str:
    """How what is in a list or an object is named."""
    held = value[0] if isinstance(value, list) and value else value
    keys = known_paths(held)[:10] if isinstance(held, Mapping) else []
    if held is value:
        return f"; name what is in it: {', '.join(f'{name}.{key}' for key in keys)}" if keys else " with nothing in it"
    which = f"such as {name}[0], {name}[last] or {name}[*]"
    return f"; name an element, {which}" + (f", and what is in it: {', '.join(f'{name}[0].{key}' for key in keys)}" if keys else "")


def plain(value: Any) -> Any:
    """A value as labels have it, of what `clean` gives for it."""
    return value == TRUTH[True] if type(value) is tuple else value


def file_names(paths: Sequence[str]) -> dict[str, str]:
    """What files are called in the column ``file``: the last part of the path, where that tells them apart.

    Examples
    --------
    >>> file_names(["logs/a.eval", "logs/b.eval"]), file_names(["a/log.json", "b/log.json"])
    ({'logs/a.eval': 'a.eval', 'logs/b.eval': 'b.eval'}, {'a/log.json': 'a/log.json', 'b/log.json': 'b/log.json'})
    """
    last = [File(path).name for path in paths]
    return dict(zip(paths, last if len({*last}) == len(last) else paths, strict=True))


def known_paths(row: Mapping[str, Any]) -> list[str]:
    """Paths to the values of a row, through objects only.

    Examples
    --------
    >>> known_paths({"id": 1, "metadata": {"race": "b", "tags": ["x"]}})
    ['id', 'metadata.race', 'metadata.tags']
    """
    found: list[str] = []
    left: list[tuple[tuple[str, ...], Any]] = [((), row)]
    while left:
        steps, value = left.pop()
        if isinstance(value, Mapping) and len(steps) < 20:
            left += reversed([((*steps, str(name)), held) for name, held in value.items()])
        else:
            found.append(written_path(steps))
    return found


def meant(column: Column, known: Sequence[str]) -> str:
    """Name known paths, first those at whose end the name stands that was looked for, in whatever case."""

    def last(path: Path) -> str:
        return next((step.casefold() for step in reversed(path.steps) if isinstance(step, str)), "")

    try:
        meant = read_path(column.name)
    except InputError:
        return nearest(column.name, known)
    ends = [path for path in known if is_path(path) and last(read_path(path)) == last(meant)]
    beside = [path for path in known if is_path(path) and read_path(path).top == meant.top]
    listed = [*dict.fromkeys((*ends, *beside, *known))]
    return f"{nearest('', listed)}; did you mean {shown(ends[0], 200)}?" if ends else nearest(column.name, listed)
