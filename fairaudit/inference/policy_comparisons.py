"""What is compared where a sampled policy decides behind filters."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace
from fractions import Fraction
from itertools import product
from typing import Any

from fairaudit.errors import InputError, shown
from fairaudit.inference.cells import Cell
from fairaudit.inference.comparisons import Comparison, Form, normalised_form, stated_masses
from fairaudit.inference.draws import declared_range, sampled_cell, scaled_values, whole_counts
from fairaudit.model.law import Law
from fairaudit.model.mechanism import Mechanism
from fairaudit.model.policy import Policy
from fairaudit.model.utility import Utility
from fairaudit.tables.values import Label
from fairaudit.theorems.assumptions import DECLARED, DRAWS, OWN_RANGE, POPULATION, range_said


def policy_comparison(
    policy: Policy,
    utility: Utility,
    group: Mechanism,
    context: Mechanism | None = None,
    population: Mapping[tuple[Label, Label], Any] | None = None,
    *,
    local: bool = True,
    limits: tuple[Any, Any] | None = None,
) -> Comparison:
    """Set up a ratio of the law that a sampled policy induces behind filters.

    Parameters
    ----------
    policy : Policy
        From counts, all of them integers. Pairs (x̃,ã) without draws are allowed: their means are only known to lie in the range of g.
    utility : Utility
        The utility over true contexts and groups.
    group : Mechanism
        The filter of the group; its inputs are the true groups.
    context : Mechanism, optional
        The filter of the context; without one contexts are released as they are.
    population : mapping from (context, group) to number, optional
        P(x,a) up to a common factor, for the global ratio; without one contexts weigh equally.
    local : bool
        Whether to compare groups within each context, or their means over contexts.
    limits : pair of numbers, optional
        As for `local_comparison`.

    Returns
    -------
    Comparison
        One cell for each (x̃,ã) when g depends on the decision alone, else one for each (x,x̃,ã), or (x,x̃,ã,a) when g depends on the
        group; these share draws and are marked as dependent.

    Raises
    ------
    InputError
        If the policy was not sampled, or the utility of a decision is not given.
    """
    law = utility.over(policy.law)
    policy = replace(policy, law=law)
    declared = None if limits is None else declared_range(limits)
    contexts = law.contexts if context is None else context.inputs
    made, forms, shared = _policy_forms(policy, utility, group, context, declared)
    group_names, context_names = law.columns.group, law.columns.context
    a_labels = tuple(dict(zip(group_names, a, strict=True)) for a in group.inputs)
    said = range_said(*(declared or (min(cell.low for cell in made), max(cell.high for cell in made))))
    assumptions = (DRAWS, said if declared or utility.entries is None else OWN_RANGE, DECLARED, *law.assumptions)
    if local:
        blocks = tuple(tuple(forms[x, a] for a in group.inputs) for x in contexts)
        places = tuple((dict(zip(context_names, x, strict=True)), a_labels) for x in contexts)
        return Comparison(tuple(made), blocks, places, shared, assumptions)
    masses = stated_masses(population) if population is not None else {(x, a): Fraction(1) for x in contexts for a in group.inputs}
    for key in masses:
        if key not in forms:
            raise InputError(f"the population names {shown(key)}, which is not a true context and group of the filters")
    means = []
    for a, label in zip(group.inputs, a_labels, strict=True):
        weights: dict[int, Fraction] = {}
        for x in contexts:
            for i, w in forms[x, a]:
                weights[i] = weights.get(i, Fraction(0)) + w * masses.get((x, a), Fraction(0))
        listed = [(i, w) for i, w in weights.items() if w]
        if listed:
            means.append((label, normalised_form(listed)))
    labels = ((None, tuple(label for label, _ in means)),)
    block = tuple(form for _, form in means)
    return Comparison(tuple(made), (block,), labels, shared, (*assumptions, POPULATION))


def _policy_forms(
    policy: Policy, utility: Utility, group: Mechanism, context: Mechanism | None, declared: tuple[Fraction, Fraction] | None
) -> tuple[list[Cell], dict[tuple[Label, Label], Form], bool]:
    """Cells of a sampled policy, E(x,a) as forms in them, and whether cells share draws."""
    law = policy.law
    place = {(law.contexts[x], law.groups[a]): whole_counts(law, i) for i, (x, a) in enumerate(_cell_places(law))}
    nothing = [0] * len(law.decisions)
    by_decision = utility.entries is None
    by_group = not by_decision and _depends_on_group(utility)
    index: dict[tuple[Any, ...], int] = {}
    made: list[Cell] = []
    forms: dict[tuple[Label, Label], Form] = {}
    for x in law.contexts if context is None else context.inputs:
        shown_x = [(x, Fraction(1))] if context is None else _released(context, x)
        for a in group.inputs:
            form = []
            for (seen_x, p), (seen_a, q) in product(shown_x, _released(group, a)):
                key: tuple[Any, ...] = (seen_x, seen_a) if by_decision else (seen_x, seen_a, x, a) if by_group else (seen_x, seen_a, x)
                if key not in index:
                    index[key] = len(made)
                    row = place.get((seen_x, seen_a), nothing)
                    made.append(sampled_cell(row, scaled_values(_utility_row(utility, law.decisions, x, a), declared), key))
                form.append((index[key], p * q))
            forms[x, a] = tuple(form)
    return made, forms, len({key[:2] for key in index}) < len(index)


def _cell_places(law: Law) -> Iterable[tuple[int, int]]:
    return zip(law.cell_context.tolist(), law.cell_group.tolist(), strict=True)


def _released(mechanism: Mechanism, value: Label) -> list[tuple[Label, Fraction]]:
    return [(out, Fraction(w, mechanism.denominator)) for out, w in zip(mechanism.outputs, mechanism.row(value), strict=True) if w]


def _depends_on_group(utility: Utility) -> bool:
    first: dict[tuple[str, Label], tuple[int, int]] = {}
    return any(first.setdefault((u, x), pair) != pair for (u, x, _), pair in (utility.entries or {}).items())


def _utility_row(utility: Utility, decisions: Sequence[str], x: Label, a: Label) -> list[Fraction]:
    if utility.entries is None:
        return [utility.values.get(u, Fraction(0)) for u in decisions]
    for u in decisions:
        if (u, x, a) not in utility.entries:
            raise InputError(f"the utility of decision {shown(u)} in context {x} for group {a} is not given")
    return [Fraction(*utility.entries[u, x, a]) for u in decisions]
