"""The categories of EEO-1 component 1, and which of them a label of a certificate means."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path

from fairaudit.errors import InputError, nearest, shown
from fairaudit.tables.labels import read_label_map

__all__ = ["RACES", "SEXES", "Attribute", "UnmappedError", "attributes"]


SEXES = ("Male", "Female")

RACES = (
    "Hispanic or Latino",
    "White",
    "Black or African American",
    "Native Hawaiian or Pacific Islander",
    "Asian",
    "Native American or Alaska Native",
    "Two or More Races",
)
"""Everybody who is Hispanic or Latino is in the first, whatever the race; the others are not Hispanic or Latino."""


class UnmappedError(InputError):
    """Labels that mean nothing that is known; which category is meant nobody but the auditor can say: none is suggested but by upper case.

    Attributes
    ----------
    block : str
        What is to be filled in and given as `--categories`, as TOML.

    Examples
    --------
    >>> print(UnmappedError({"Sex / gender": ["male", "w"]}, {"Sex / gender": SEXES}).block)
    ["Sex / gender"]  # each one of: "Male", "Female"
    "male" = "Male"
    "w" = ""
    """

    def __init__(self, labels: Mapping[str, Sequence[str]], categories: Mapping[str, Sequence[str]]) -> None:
        said = "; ".join(f"{', '.join(map(shown, own))} in column {shown(column)}" for column, own in labels.items() if own)
        one = sum(map(len, labels.values())) == 1
        is_none = f"the label {said} is no category" if one else f"the labels {said} are no categories"
        super().__init__(
            f"{is_none} of the rule; write what is meant into a file for --categories, under the column's name, or name labels that say "
            "nothing with --unknown"
        )
        lines = []
        for column, own in labels.items():
            if own:
                lines += [f"[{quoted(column)}]  # each one of: {', '.join(map(quoted, categories[column]))}"]
                same = {category.casefold(): category for category in categories[column]}
                lines += [f"{quoted(label)} = {quoted(same.get(label.strip().casefold(), ''))}" for label in own]
        self.block = "\n".join(lines)


def quoted(text: str) -> str:
    r"""A text as TOML has it, on one line and without what could steer a terminal.

    Examples
    --------
    >>> print(quoted('a "b"\n'))
    "a \"b\"\U0000000A"
    """
    marks = {'"': '\\"', "\\": "\\\\"}
    return '"' + "".join(marks.get(c, c if c.isprintable() else f"\\U{ord(c):08X}") for c in text) + '"'


@dataclass(frozen=True)
class Attribute:
    """A group column of a certificate whose labels mean categories.

    Attributes
    ----------
    column : str
        The column.
    categories : tuple of str
        Those that there are.
    own : mapping of str to str
        Which category a label means; a label that is spelt as a category means it.
    unknown : collection of str
        Labels that say that the category is unknown.

    Examples
    --------
    >>> sex = Attribute("gender", SEXES, {"w": "Female"}, ["declined"])
    >>> sex.category("w"), sex.category("Male"), sex.category("declined")
    ('Female', 'Male', None)
    """

    column: str
    categories: tuple[str, ...]
    own: Mapping[str, str] = field(default_factory=dict)
    unknown: Collection[str] = ()

    def category(self, label: str) -> str | None:
        """The category that a label means; None where it says that it is unknown.

        Raises
        ------
        InputError
            If it means nothing that is known.
        """
        if label in self.unknown:
            return None
        if label in self.own:
            return self.own[label]
        if label in self.categories:
            return label
        raise UnmappedError({self.column: [label]}, {self.column: self.categories})

    def unmapped(self, labels: Iterable[str]) -> list[str]:
        """Those of some labels that mean nothing that is known.

        Examples
        --------
        >>> Attribute("sex", SEXES, {"w": "Female"}).unmapped(["w", "x", "Male"])
        ['x']
        """
        return sorted({*labels} - {*self.unknown} - {*self.own} - {*self.categories})

    def renamed(self, labels: Iterable[str]) -> dict[str, list[str]]:
        """The categories that labels of another spelling mean, with all labels that mean them.

        Examples
        --------
        >>> Attribute("sex", SEXES, {"w": "Female", "f": "Female"}).renamed(["f", "Male", "w"])
        {'Female': ['f', 'w']}
        """
        found: dict[str, list[str]] = {}
        for label in sorted(labels):
            category = self.category(label)
            if category is not None:
                found.setdefault(category, []).append(label)
        return {category: found[category] for category in self.categories if found.get(category, [category]) != [category]}


def attributes(
    columns: Mapping[str, tuple[str, ...]], map_file: str | Path | None, unknown: Mapping[str, Collection[str]]
) -> tuple[Attribute, ...]:
    """Read what the labels of some columns mean.

    Parameters
    ----------
    columns : mapping of str to tuple of str
        For each column the categories that its labels may mean.
    map_file : path, optional
        A TOML file with a table for each column, own label = category.
    unknown : mapping of str to collection of str
        For each column the labels that say that the category is unknown.

    Raises
    ------
    InputError
        If the file names another column, or a category that there is not, or a label that is unknown.
    """
    given = {} if map_file is None else read_label_map(map_file)
    for name, own in given.items():
        if name not in columns:
            raise InputError(f"{map_file}: [{name}] is no column of sex or race that is published; {nearest(name, columns)}")
        for label, category in own.items():
            if category not in columns[name]:
                raise InputError(
                    f"{map_file}: [{name}] has {shown(label)} = {shown(category)}, which is no category of the rule; "
                    f"{nearest(category, columns[name])}"
                )
            if label in unknown.get(name, ()):
                raise InputError(
                    f"{map_file}: [{name}] has {shown(label)} = {shown(category)}, and the same label says that the category is unknown; "
                    "leave one of them out"
                )
    return tuple(Attribute(name, known, given.get(name, {}), tuple(unknown.get(name, ()))) for name, known in columns.items())
