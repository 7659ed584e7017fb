"""The categories of EEO-1 component 1, and which of them a label of a certificate means."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Mapping
from dataclasses import dataclass, field
from pathlib import Path

from fairaudit.errors import InputError, nearest, shown
from fairaudit.tables.labels import read_label_map

__all__ = ["RACES", "SEXES", "Attribute", "attributes"]


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
        raise InputError(
            f"the label {shown(label)} in column {shown(self.column)} is no category of the rule; write which one it means into a file for "
            f"--categories, under the column's name, or name it in --unknown; {nearest(label, self.categories)}"
        )

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
