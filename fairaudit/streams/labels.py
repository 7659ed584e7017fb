"""Which cell and which decision the labels of a line stand for, or why they stand for none."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from decimal import Decimal
from fractions import Fraction
from typing import Any

from fairaudit.errors import InputError, shown
from fairaudit.exact.rationals import rational, rational_text
from fairaudit.streams.settings import OTHER, Settings
from fairaudit.tables.label_text import json_number, label_text
from fairaudit.tables.values import Label

MAX_CELLS = 10_000  # a look at as many takes seconds; a column of identifiers named by mistake has more

MAX_VALUES = 10_001  # as many as the finest utility step gives

CACHED = 200_000  # combinations of labels that are remembered, some 100 MB of them

NO_VALUE = "no value in column "

Resolved = tuple[tuple[Label, Label], int]  # the cell and the number of the decision


class LabelResolver:
    """Turns labels into cells and decisions, and remembers those that it met.

    Parameters
    ----------
    settings : Settings
        What the columns mean.
    decisions : list of (label, utility)
        The decisions that are known, by number.
    cells : mapping of (context, group) to int
        The cells that were seen so far, by rank; it may grow.
    """

    def __init__(self, settings: Settings, decisions: list[tuple[str, str]], cells: Mapping[tuple[Label, Label], int]) -> None:
        self.settings, self.decisions, self._cells = settings, decisions, cells
        self._numbers = {label: number for number, (label, _) in enumerate(decisions)}
        self._resolved: dict[Any, Resolved | str] = {}
        self._new: list[tuple[int, str, str]] = []

    def take_new(self) -> list[tuple[int, str, str]]:
        """Number, label and utility of the decisions that are new since this was last asked."""
        taken, self._new = self._new, []
        return taken

    def resolve(self, key: tuple[Any, ...]) -> Resolved | str:
        """The cell and the decision that labels stand for, or why they stand for none."""
        kinds = (key, *map(type, key))
        try:
            found = self._resolved.get(kinds)
        except TypeError:  # a list or an object instead of a label
            return self._resolve_anew(key)
        if found is None:
            if len(self._resolved) >= CACHED:
                self._resolved.clear()
            found = self._resolved[kinds] = self._resolve_anew(key)
        if not isinstance(found, str) and found[0] not in self._cells and len(self._cells) >= MAX_CELLS:
            return f"more than {MAX_CELLS} combinations of context and group"
        return found

    def room_for(self, new: Collection[tuple[Label, Label]]) -> bool:
        """Whether cells that were not counted yet can all be."""
        return len(self._cells) + len(new) <= MAX_CELLS

    def group(self, key: tuple[Any, ...]) -> Label | None:
        """The group of a line, whatever else it lacks; None if one of its labels is missing or is none."""
        first = len(self.settings.context)
        try:
            labels = [_text(value) for value in key[first : first + len(self.settings.group)]]
        except InputError:
            return None
        found = tuple(text for text in labels if text is not None)
        return found if len(found) == len(self.settings.group) else None

    def _resolve_anew(self, key: tuple[Any, ...]) -> Resolved | str:
        names = (*self.settings.context, *self.settings.group, self.settings.decision)
        labels = []
        for name, value in zip(names, key, strict=True):
            if isinstance(value, (list, dict)):
                return f"column {shown(name)} holds no label"
            try:
                text = _text(value)
            except InputError as error:
                return f"column {shown(name)}: {error}"
            if text is None:
                return f"{NO_VALUE}{shown(name)}"
            labels.append(text)
        contexts = len(self.settings.context)
        cell = tuple(labels[:contexts]), tuple(labels[contexts:-1])
        if self.settings.utility is not None:
            return cell, self._numbers.get(labels[-1], self._numbers[OTHER])
        try:
            return cell, self._value(key[-1], labels[-1])
        except InputError as error:
            return f"column {shown(names[-1])}: {error}"

    def _value(self, value: Any, text: str) -> int:
        """Number of the decision that a utility stands for."""
        exact = Fraction(*rational(text if isinstance(value, (str, float)) else value))
        if self.settings.step is not None:
            step = Fraction(self.settings.step)
            exact = round(exact / step) * step
        low, high = self.settings.limits
        if not low <= exact <= high:
            raise InputError(f"a utility of {shown(text)} is outside the range from {low} to {high}")
        label = rational_text((exact.numerator, exact.denominator))
        if label not in self._numbers:
            if len(self._numbers) >= MAX_VALUES:
                raise InputError(f"more than {MAX_VALUES} different utilities; round them (--utility-step)")
            self._numbers[label] = len(self._numbers)
            self.decisions.append((label, label))
            self._new.append((self._numbers[label], label, label))
        return self._numbers[label]


def _text(value: Any) -> str | None:
    """The text of a label as a line has it; None if it is missing."""
    return label_text(json_number(str(value)) if isinstance(value, Decimal) else value)
