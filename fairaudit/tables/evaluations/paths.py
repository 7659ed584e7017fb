"""Paths into the rows of a log: names joined by dots, elements of lists, and the place of the greatest number of a list."""

from __future__ import annotations

import json
import re
from collections.abc import Mapping
from dataclasses import dataclass
from decimal import Decimal, InvalidOperation
from typing import Any, Final

from fairaudit.errors import InputError, shown
from fairaudit.tables.label_text import json_number

__all__ = ["ABSENT", "EACH", "LAST", "Path", "Step", "is_path", "json_value", "read_path", "value_at", "written_path"]

EACH: Final = None
"""The step ``[*]``: every element of a list."""

LAST: Final = -1
"""The step ``[last]``."""

Step = str | int | None
"""A name, the place of an element, or every element."""


class _Absent:
    def __repr__(self) -> str:
        return "ABSENT"


ABSENT: Final = _Absent()
"""What a path leads to where there is no such name or element."""

TOKEN = re.compile(r'"((?:[^"]|"")*)"|([^."\[\]]+)|\[([0-9]{1,9}|last|\*)\]')

NUMBER = re.compile(r"[+-]?(?:(?:[0-9]+\.?[0-9]*|\.[0-9]+)(?:[eE][+-]?[0-9]+)?|inf(?:inity)?)", re.IGNORECASE)
"""A number as programs write it in a text."""

NAN = Decimal("NaN")

FUNCTION = re.compile(r"\s*(\w+)\([^\"]*[.\[].*", re.DOTALL)
"""What looks like a function of a path."""

ARGMAX = re.compile(r"\s*argmax\((.*)\)\s*", re.DOTALL)

EXAMPLES = 'a path is of the form metadata.race, answers[0].text, answers[last], "a name with dots".answer or argmax(scores[*])'


@dataclass(frozen=True)
class Path:
    """A path into a row.

    Attributes
    ----------
    text : str
        As it was written.
    steps : tuple
        Names, places of elements, and None for every element.
    argmax : bool
        Whether it stands for the place of the greatest of the numbers that the steps lead to.

    Examples
    --------
    >>> path = read_path('metadata."job title"[last].id')
    >>> path.steps, path.of({"metadata": {"job title": [{"id": 3}, {"id": 4}]}})
    (('metadata', 'job title', -1, 'id'), 4)
    >>> read_path("argmax(resps[*][0])").of({"resps": [["-3.5", "False"], ["-0.25", "True"]]})
    1
    """

    text: str
    steps: tuple[Step, ...]
    argmax: bool = False

    @property
    def top(self) -> str:
        """The key at the top of a row that it goes through."""
        return str(self.steps[0])

    @property
    def each(self) -> int | None:
        """How many steps lead to the list of which it takes every element; None if it takes one value of a row."""
        return None if self.argmax or EACH not in self.steps else self.steps.index(EACH)

    def of(self, row: Mapping[str, Any]) -> Any:
        """The value in a row, `ABSENT` where it has none.

        Raises
        ------
        InputError
            If the path goes by a name into a list, or the numbers have no single greatest one.
        """
        return self._greatest(row) if self.argmax else value_at(row, self.steps, self.text)

    def _greatest(self, row: Mapping[str, Any]) -> Any:
        at = self.steps.index(EACH)
        held = value_at(row, self.steps[:at], self.text)
        if held is ABSENT or held is None or held == []:
            return ABSENT
        if not isinstance(held, list):
            raise InputError(f"{shown(self.text, 200)} takes the greatest of a list, and there is {shown(held)}")
        steps, text = self.steps[at + 1 :], self.text
        numbers = [_number(value_at(element, steps, text), text) for element in held]
        greatest = max(numbers)
        if numbers.count(greatest) > 1:
            places = ", ".join(str(place) for place, number in enumerate(numbers) if number == greatest)
            raise InputError(f"{shown(self.text, 200)} has no single greatest number: {greatest} stands at the places {places}")
        return numbers.index(greatest)


def is_path(text: str) -> bool:
    """Whether a name of a column could be a path that goes deeper than the columns of a table.

    Examples
    --------
    >>> is_path("race"), is_path("doc.race"), is_path("argmax(resps[*])")
    (False, True, True)
    """
    return any(character in text for character in '."[') or ARGMAX.fullmatch(text) is not None


def read_path(text: str) -> Path:
    """Read a path.

    Raises
    ------
    InputError
        If it is none.

    Examples
    --------
    >>> read_path("resps[0][*]").steps
    ('resps', 0, None)
    """
    inner = ARGMAX.fullmatch(text)
    called = None if inner else FUNCTION.fullmatch(text)
    if called and called[1] == "argmax":
        raise InputError(f"{shown(text, 200)} has a parenthesis that is not closed; write argmax(path[*])")
    if called and text.rstrip().endswith(")"):
        raise InputError(f"{shown(text, 200)} has the function {called[1]}, and argmax is the only one: argmax(path[*])")
    steps = _steps(text, inner[1] if inner else text)
    if steps.count(EACH) > 1:
        raise InputError(f"the path {shown(text, 200)} has [*] more than once; one list can be taken apart")
    if inner and EACH not in steps:
        raise InputError(f"{shown(text, 200)} names no list of numbers; write argmax(path[*])")
    return Path(text, steps, inner is not None)


def _steps(text: str, path: str) -> tuple[Step, ...]:
    steps: list[Step] = []
    position = 0
    while position < len(path):
        dot = path[position] == "."
        position += dot
        token = TOKEN.match(path, position)
        name = None if token is None else token[1].replace('""', '"') if token[1] is not None else token[2]
        if token is None or (name is not None and bool(steps) != dot) or (name is None and (dot or not steps)):
            if "[" in path[position:] and "]" not in path[path.rindex("[") :]:
                raise InputError(f"the path {shown(text, 200)} has a bracket that is not closed; {EXAMPLES}")
            raise InputError(f"the path {shown(text, 200)} cannot be read from {shown(path[position:], 30)} on; {EXAMPLES}")
        steps.append(name if name is not None else EACH if token[3] == "*" else LAST if token[3] == "last" else int(token[3]))
        position = token.end()
    if not steps:
        raise InputError(f"the path {shown(text, 200)} is empty; {EXAMPLES}")
    return tuple(steps)


def written_path(steps: tuple[Step, ...]) -> str:
    """Write steps as a path.

    Examples
    --------
    >>> written_path(("doc", "job title", 0, -1, None))
    'doc."job title"[0][last][*]'
    """
    text = ""
    for step in steps:
        if isinstance(step, str):
            plain = re.fullmatch(r'[^."\[\]\s(),=:]+', step) is not None
            text += ("." if text else "") + (step if plain else '"' + step.replace('"', '""') + '"')
        else:
            text += "[*]" if step is EACH else "[last]" if step == LAST else f"[{step}]"
    return text


def value_at(row: Any, steps: tuple[Step, ...], text: str) -> Any:
    """What steps lead to, `ABSENT` where there is no such name or element.

    Parameters
    ----------
    row : object
        Where they begin.
    steps : tuple
        Names and places of elements.
    text : str
        What messages call them.

    Raises
    ------
    InputError
        If a name is asked of a list.
    """
    value = row
    for step in steps:
        if type(value) is dict or isinstance(value, Mapping):  # the first is asked in no time
            if type(step) is not str:
                return ABSENT
            value = value.get(step, ABSENT)
        elif isinstance(value, list):
            if isinstance(step, str):
                raise InputError(
                    f"{shown(text, 200)} goes by the name {shown(step)} into a list; name an element, such as [0], [last] or [*]"
                )
            if step is EACH or not -len(value) <= step < len(value):
                return ABSENT
            value = value[step]
        else:
            return ABSENT
    return value


def _number(value: Any, text: str) -> Decimal:
    """A number, or a text that is one, as lm-evaluation-harness writes them."""
    if isinstance(value, (str, int, float, Decimal)) and not isinstance(value, bool):
        digits = repr(value) if isinstance(value, float) else value
        if not isinstance(digits, str) or NUMBER.fullmatch(digits):
            try:
                number = Decimal(digits)
            except InvalidOperation:  # of too great an exponent
                number = NAN
            if not number.is_nan():
                return number
    said = "nothing" if value is ABSENT else shown(value)
    raise InputError(f"{shown(text, 200)} takes the greatest of numbers, and one of them is {said}")


def json_value(text: str | None) -> Any:
    """Read the JSON text of a label.

    Raises
    ------
    InputError
        If it is not the text of a text, number or truth value.
    """
    if text is None:
        return None
    try:
        value = json.loads(text, parse_float=json_number, parse_constant=_refuse)
    except (ValueError, RecursionError):
        raise InputError(f"it holds {shown(text)}, which is not a JSON value") from None
    if isinstance(value, (dict, list)):
        known = [f".{written_path((key,))}" for key in list(value)[:10]] if isinstance(value, dict) else ["[0]", "[last]"] if value else []
        inside = f"; name what is in it by a path, which goes on with {', '.join(known)}" if known else ""
        raise InputError(f"it holds {shown(text)}; a label is a text, a number or a truth value{inside}")
    return value


def _refuse(text: str) -> Any:
    raise ValueError(text)
