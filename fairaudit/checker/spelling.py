"""Labels that differ in spelling alone."""

from __future__ import annotations

import re
import unicodedata
from collections.abc import Iterator

from .header import Header
from .json_values import Labels, read_list, read_object, read_string, read_strings
from .text import malformed

LONGEST_SPELLING = 1000  # characters of labels that are compared with other spellings


def read_spellings(value: object, where: str) -> tuple[tuple[str, Labels], ...]:
    entries = [read_object(item, f"{where}[{i}]", ("column", "labels")) for i, item in enumerate(read_list(value, where))]
    if not entries:
        raise malformed(where, "must not be empty")
    return tuple(
        (read_string(e["column"], f"{where}[{i}].column"), read_strings(e["labels"], f"{where}[{i}].labels")) for i, e in enumerate(entries)
    )


def labels_by_column(header: Header) -> dict[str, list[str]]:
    columns = header.subject.columns
    found = {columns.decision: list(header.decisions)}
    for names, labels in ((columns.group, header.groups), (columns.context, header.contexts)):
        found |= {name: list(dict.fromkeys(label[i] for label in labels)) for i, name in enumerate(names)}
    return found if columns.truth is None else found | {columns.truth: list(header.truths or ())}


def folded_label(text: str) -> str:
    """What labels have in common that differ in case, blanks or Unicode form alone: canonical caseless matching, single blanks."""
    decomposed = unicodedata.normalize("NFD", unicodedata.normalize("NFD", text).casefold())
    return " ".join(decomposed.split())


def is_settled(text: str) -> bool:
    """Whether Unicode 3.2 assigns every code point, of which no later version changes the case or the normal forms.

    Longer texts are not looked at: many combining marks in a row take the square of their number of steps to put into order.
    """
    return len(text) <= LONGEST_SPELLING and all(unicodedata.ucd_3_2_0.category(character) != "Cn" for character in text)


_NUMBER = re.compile(r"([+-]?)(?:([0-9]+)(?:\.([0-9]*))?|\.([0-9]+))(?:e([+-]?[0-9]{1,4}))?")


def _spelling(text: str) -> tuple[str, ...]:
    """What spellings of one label have in common: the number that they say, or else what is folded."""
    folded = folded_label(text)
    match = _NUMBER.fullmatch(folded)
    if match is None:
        return (folded,)
    sign, whole, decimals, only, power = match.groups()
    fraction = decimals or only or ""
    digits = ((whole or "") + fraction).lstrip("0")
    shortened = digits.rstrip("0")
    exponent = int(power or 0) - len(fraction) + len(digits) - len(shortened)
    return ("a number", "-" if sign == "-" else "", shortened, str(exponent)) if shortened else ("a number", "0")


def spellings(header: Header) -> Iterator[tuple[str, Labels]]:
    """List labels of one column that are spellings of one label."""
    for column, labels in labels_by_column(header).items():
        alike: dict[tuple[str, ...], list[str]] = {}
        for label in labels:
            if is_settled(label):
                alike.setdefault(_spelling(label), []).append(label)
        yield from sorted((column, tuple(sorted(several))) for several in alike.values() if len(several) > 1)
