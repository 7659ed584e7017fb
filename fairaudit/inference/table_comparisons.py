"""What is compared in a plain table of counts: groups within contexts, or over them."""

from __future__ import annotations

from collections.abc import Mapping
from fractions import Fraction
from functools import partial
from typing import Any

import numpy as np

from fairaudit.errors import InputError, shown
from fairaudit.inference.comparisons import Comparison, Form, normalised_form, stated_masses, unit_form
from fairaudit.inference.draws import SampledUtility, declared_range, range_assumption, unit_columns, unit_notes, unit_profiles
from fairaudit.model.law import Law
from fairaudit.model.utility import UtilityTable
from fairaudit.tables.values import Label
from fairaudit.theorems.assumptions import DECLARED, DRAWS, ONE_ROW, POOLED, POPULATION, UNITS


def local_comparison(law: Law, utility: UtilityTable, limits: tuple[Any, Any] | None = None) -> Comparison:
    """Set up the local ratio of a plain table of counts.

    The draws of a law with sampling units (`Law.from_log` with ``unit=``) are its units: in each cell a unit counts once, with the mean
    of the utility over its rows there, so that dependence inside a unit is allowed for. What is estimated is then the mean over units,
    whatever the number of their rows. Units with rows in several cells make the cells dependent.

    Parameters
    ----------
    law : Law
        Counts, all of them integers.
    utility : UtilityTable
        The utility on it.
    limits : pair of numbers, optional
        The range of g over everything that could be drawn, seen or not; by default from 0 to the greatest value that g has here.

    Returns
    -------
    Comparison
        One cell and one form for each (x,a) that is compared; a block for each context.

    Raises
    ------
    InputError
        If the law holds probabilities or fractional counts: they carry no sample size.

    Examples
    --------
    >>> from fairaudit.model.utility import Utility
    >>> law = Law.from_array([[3, 1], [1, 1]], kind="counts", decisions=["yes", "no"], groups=["f", "m"])
    >>> [cell.mean for cell in local_comparison(law, Utility({"yes": 1}).on(law)).cells]
    [Fraction(3, 4), Fraction(1, 2)]
    >>> law = Law.from_log({"a": list("ffmm"), "u": ["yes", "no", "no", "no"], "run": [1, 1, 1, 2]}, decision="u", group="a", unit="run")
    >>> [(cell.draws, cell.mean) for cell in local_comparison(law, Utility({"yes": 1}).on(law)).cells]
    [(1, Fraction(1, 2)), (2, Fraction(0, 1))]
    """
    declared = None if limits is None else declared_range(limits)
    drawn = SampledUtility(utility, declared)
    cells = drawn.cells(law.compared)
    blocks: list[tuple[Form, ...]] = []
    labels = []
    held = law.cell_group.tolist()
    names_of = {a: law.group_label(a) for a in {*held}}
    first = 0
    for start, end in zip(law.starts[:-1].tolist(), law.starts[1:].tolist(), strict=True):
        if end - start < 2:
            continue
        blocks.append(tuple(unit_form(i) for i in range(first, first + end - start)))
        first += end - start
        labels.append((law.context_label(int(law.cell_context[start])), tuple(names_of[a] for a in held[start:end])))
    draws = (UNITS,) if law.units and law.units.repeated else (DRAWS, *((ONE_ROW,) if law.units else ()))
    assumptions = (*draws, range_assumption(utility, declared), DECLARED, *law.assumptions)
    notes = unit_notes(law.units, cells) if law.units else ()
    dependent = bool(law.units and law.units.spanning)
    tallies, seen = partial(drawn.tallies, law.compared), unit_profiles(utility)
    given = tuple(cells), tuple(blocks), tuple(labels)
    return Comparison(*given, dependent, assumptions, notes, units=law.units, profiles=seen, drawn=tallies)


def global_comparison(
    law: Law, utility: UtilityTable, population: Mapping[tuple[Label, Label], Any] | None = None, limits: tuple[Any, Any] | None = None
) -> Comparison:
    """Set up the global ratio of a plain table of counts.

    Parameters
    ----------
    law : Law
        Counts, all of them integers.
    utility : UtilityTable
        The utility on it.
    population : mapping from (context, group) to number, optional
        P(x,a) up to a common factor, exact. Without one the contexts of each group count as drawn from its population: then the rows
        of a group are independent draws of (x,u) given a, their utilities have the mean Ē(a), and a group is one cell.
    limits : pair of numbers, optional
        As for `local_comparison`.

    Returns
    -------
    Comparison
        A single block with a form for each group.

    Raises
    ------
    InputError
        As for `local_comparison`; if the population names a cell without counts; or if a sampling unit has several rows with one group,
        which are then no independent draws.
    """
    if law.units and not law.units.once_per_group:
        raise InputError(
            f"units of {unit_columns(law.units)} have several rows with the same group, which are no independent draws of it; "
            "an interval for the global ratio needs one row for each unit and group"
        )
    declared = None if limits is None else declared_range(limits)
    drawn = SampledUtility(utility, declared)
    if population is None:
        groups = law.global_groups
        pooled = drawn.pooled(groups)
        labels = ((None, tuple(law.group_label(a) for a in groups)),)
        assumptions = (DRAWS, POOLED, range_assumption(utility, declared), DECLARED, *law.assumptions)
        forms = (tuple(unit_form(i) for i in range(len(pooled))),)
        dependent = bool(law.units and law.units.spanning)
        tallies = partial(drawn.pooled_tallies, groups)
        return Comparison(tuple(pooled), forms, labels, dependent, assumptions, units=law.units, drawn=tallies)
    cells = drawn.cells(np.ones(len(law.weights), dtype=np.bool_))
    place = {cell.label: i for i, cell in enumerate(cells)}
    weights: dict[Label, list[tuple[int, Fraction]]] = {a: [] for a in law.groups}
    for key, mass in stated_masses(population).items():
        if not mass:
            continue
        if key not in place:
            raise InputError(f"the population gives mass to {shown(key)}, for which there are no counts")
        weights[key[1]].append((place[key], mass))
    present = [(law.group_label(k), a) for k, a in enumerate(law.groups) if weights[a]]
    block = tuple(normalised_form(weights[a]) for _, a in present)
    labels = ((None, tuple(label for label, _ in present)),)
    assumptions = (DRAWS, POPULATION, range_assumption(utility, declared), DECLARED, *law.assumptions)
    return Comparison(tuple(cells), (block,), labels, bool(law.units), assumptions, units=law.units)
