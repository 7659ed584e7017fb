"""Groups and their masses, as they are given."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from fractions import Fraction
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fairaudit.errors import InputError, nearest, shown
from fairaudit.exact.rationals import Number, at_least, common_denominator, option_value, rational
from fairaudit.tables.label_text import label_text
from fairaudit.tables.values import ByGroup, Label, LabelsLike
from fairaudit.words import noun

Groups = int | Sequence[LabelsLike] | Mapping[str, int | Sequence[LabelsLike]]
"""The values of an attribute, their number, or either for each of several attributes by name."""

Masses = ByGroup[Number] | Sequence[Number] | NDArray[np.integer] | NDArray[np.floating]
"""P(a) up to a common factor: by group, or in the order of the groups."""


def read_attributes(groups: Groups, most: int) -> dict[str, tuple[Label, ...]]:
    """The labels of each attribute: two or more, at most `most`, all different."""
    listed = groups if isinstance(groups, Mapping) else {"group": groups}
    result = {}
    for name, values in listed.items():
        given: int | list[Any] | None = None
        if isinstance(values, int) and not isinstance(values, bool):
            given = values
        elif isinstance(values, Iterable) and not isinstance(values, (str, bytes, Mapping)):
            given = list(values)
        if given is None:
            raise InputError(
                f"the values of the attribute {shown(name)} are {shown(values)}; a number of values or a list of labels is accepted"
            )
        count = given if isinstance(given, int) else len(given)
        if count > most:
            raise InputError(f"the attribute {shown(name)} has {count} values; up to {most:,} are accepted")
        labels = tuple(read_label(value) for value in (range(given) if isinstance(given, int) else given))
        if len(labels) < 2 or len(set(labels)) != len(labels) or len({len(label) for label in labels}) > 1:
            raise InputError(f"the attribute {shown(name)} needs at least two values, all different")
        result[name] = labels
    if not result:
        raise InputError("no attribute was given; name at least one")
    return result


def read_masses(population: Masses | None, labels: tuple[Label, ...]) -> list[int]:
    """P(a) in the order of the labels, as integers; equal masses where none are given."""
    if population is None:
        return [1] * len(labels)
    if isinstance(population, Mapping):
        given = {read_label(key): at_least("population", value, 0) for key, value in population.items()}
        for label in given:
            if label not in labels:
                raise InputError(
                    f"the population names the group {shown(', '.join(label))}; {nearest(', '.join(label), map(', '.join, labels))}"
                )
        numbers = [given.get(label, Fraction(0)) for label in labels]
    else:
        numbers = [at_least("population", value, 0, number_reader(population)) for value in population]
        if len(numbers) != len(labels):
            raise InputError(
                f"the population has {len(numbers)} {noun(len(numbers), 'mass', 'masses')} for {len(labels)} groups; give one for each"
            )
    if not any(numbers):
        raise InputError("every mass of the population is zero; at least one must be positive")
    return common_denominator([(v.numerator, v.denominator) for v in numbers])[0]


def number_reader(given: Any) -> Callable[[object], tuple[int, int]]:
    """How numbers are read: entries of an array as what they store, others as options."""
    return rational if isinstance(given, np.ndarray) else option_value


def read_label(value: Any) -> Label:
    """A label, or a tuple of labels for several columns."""
    texts = [label_text(part) for part in (value if isinstance(value, tuple) else (value,))]
    if not texts or None in texts:
        raise InputError(f"{shown(value)} is not a group; a label, or a tuple of labels for several columns, is accepted")
    return tuple(text for text in texts if text is not None)
