"""A class of utilities read against a law: what it names must occur, and what it gives must fit."""

from __future__ import annotations

from collections.abc import Mapping
from fractions import Fraction
from typing import Any

import numpy as np

from fairaudit.errors import InputError, nearest, shown
from fairaudit.exact.extended import ZERO
from fairaudit.exact.rationals import option_value, rational
from fairaudit.measures.limits import Quantity
from fairaudit.model.law import Law
from fairaudit.model.utility_class import LinearRow, UtilityClass, read_number
from fairaudit.tables.label_text import label_text
from fairaudit.tables.values import Label
from fairaudit.worst.layout import Terms
from fairaudit.worst.setting import Setting


def lay_out(law: Law, of: UtilityClass, quantity: Quantity) -> Setting:
    """Lay a class out over a law; refuses one that does not fit it."""
    if quantity not in ("local", "global"):
        raise InputError(f"quantity={shown(quantity)} is not accepted; use 'local' or 'global'")
    by_context: dict[int, list[int]] = {}
    for cell, x in enumerate(law.cell_context.tolist()):
        by_context.setdefault(x, []).append(cell)
    contexts, cells = list(by_context), list(by_context.values())
    places: list[int | None]
    if quantity == "local":
        places = [i for i, listed in enumerate(cells) if len(listed) > 1]
        members = [cells[i] for i in places if i is not None]
        if not members:
            raise InputError("no context has two groups, so nobody is compared within a context")
    else:
        places, members = [None], [list(law.global_groups)]
        if not law.global_groups:
            raise InputError(
                "the global ratio is undefined: fewer than two groups have a population, or one is missing in a context and no population "
                "was given"
            )
    index = {label: u for u, label in enumerate(law.decisions)}
    order = []
    for pair in of.order:
        for label in pair:
            if label not in index:
                raise InputError(f"the order names the decision {shown(label)}, which does not occur; {nearest(label, law.decisions)}")
        order.append((index[pair[0]], index[pair[1]]))
    setting = Setting(law, of, quantity, contexts, cells, members, places, _features(law, of), order, _metric(law, of), [])
    setting.rows.extend(_resolved(setting, row) for row in of.rows)
    return setting


def _metric(law: Law, of: UtilityClass) -> list[list[Fraction]] | None:
    """Distances between groups; an error unless they form a metric."""
    if of.metric is None:
        return None
    if of.lipschitz is None:
        raise InputError("a metric goes with a Lipschitz constant; give lipschitz too")
    size = len(law.groups)
    if callable(of.metric):
        raw = [[of.metric(a, b) for b in law.groups] for a in law.groups]
    else:
        raw = [list(row) for row in of.metric]
        if len(raw) != size or any(len(row) != size for row in raw):
            raise InputError(f"the metric is not a square table over the {size} groups of the law")
    read = rational if isinstance(of.metric, np.ndarray) else option_value
    d = [[read_number("the metric", value, read) for value in row] for row in raw]
    name = law.group_label
    for i in range(size):
        for j in range(size):
            if (d[i][j] <= 0) != (i == j) or d[i][j] < 0:
                raise InputError(
                    f"the metric gives the distance {d[i][j]} from {name(i)} to {name(j)}; it is zero from a group to itself, else positive"
                )
            if d[i][j] != d[j][i]:
                raise InputError(f"the metric is not symmetric: {d[i][j]} from {name(i)} to {name(j)}, but {d[j][i]} back")
    for i in range(size):
        for j in range(size):
            for k in range(size):
                if d[i][k] > d[i][j] + d[j][k]:
                    raise InputError(
                        f"the metric breaks the triangle inequality: {name(i)} to {name(k)} is {d[i][k]}, but through {name(j)} it is "
                        f"{d[i][j]} + {d[j][k]}"
                    )
    return d


def _features(law: Law, of: UtilityClass) -> list[list[list[Fraction]]] | None:
    if of.family is None:
        return None
    features = []
    first: dict[int, list[list[Fraction]]] = {}
    for named in of.family.features.values():
        if isinstance(named, Mapping):
            for label in named:
                if label_text(label) not in law.decisions:
                    raise InputError(
                        f"the family names the decision {shown(label)}, which does not occur; {nearest(str(label), law.decisions)}"
                    )
    for x, a in zip(law.cell_context.tolist(), law.cell_group.tolist(), strict=True):
        rows = [[_feature(name, phi, u, law.contexts[x], law.groups[a]) for name, phi in of.family.features.items()] for u in law.decisions]
        if of.blind and first.setdefault(x, rows) != rows:
            raise InputError(f"the features differ between groups at {law.context_label(x)}, but the class is blind; set blind=False")
        features.append(rows)
    return features


def _feature(name: str, phi: Any, u: str, x: Label, a: Label) -> Fraction:
    value = phi.get(u, 0) if isinstance(phi, Mapping) else phi(u, x, a)
    return read_number(f"the feature {shown(name)} of decision {shown(u)}", value)


def _resolved(setting: Setting, row: LinearRow) -> tuple[Terms, Fraction]:
    """Read the labels of a row as variables."""
    law = setting.law
    terms: Terms = {}
    for context, group, decision, coefficient in row.terms:
        if decision not in law.decisions:
            raise InputError(f"a row names the decision {shown(decision)}, which does not occur; {nearest(decision, law.decisions)}")
        if context is None and len(setting.contexts) > 1:
            raise InputError(f"a row names the decision {shown(decision)} without a context, but there are {len(setting.contexts)}")
        if context is not None and context not in law.contexts:
            raise InputError(f"a row names the context {shown(context)}, which does not occur")
        x = setting.contexts[0] if context is None else law.contexts.index(context)
        if x not in setting.contexts:
            raise InputError(f"a row names the context {shown(context)}, in which no decisions are recorded")
        cells = setting.cells[setting.contexts.index(x)]
        if setting.of.blind == (group is not None):
            raise InputError(
                f"a row names the group {shown(group)}, but the class is blind"
                if setting.of.blind
                else "a row names no group, but the class is not blind to groups"
            )
        found = cells[:1] if group is None else [cell for cell in cells if law.groups[setting.group_of[cell]] == group]
        if not found:
            raise InputError(f"a row names the group {shown(group)}, which has no decisions at {law.context_label(x)}")
        v = setting.variable(found[0], law.decisions.index(decision))
        terms[v] = terms.get(v, ZERO) + coefficient
    return {v: c for v, c in terms.items() if c}, row.bound
