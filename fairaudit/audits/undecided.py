"""Decisions of unknown meaning, such as refusals: ranges of ratios whatever they meant (T19), of the table and of the population."""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from itertools import pairwise
from typing import TYPE_CHECKING, Any, TypeVar

import numpy as np

from fairaudit.audits.targets import Target
from fairaudit.errors import InputError, nearest, shown
from fairaudit.exact.extended import Extended
from fairaudit.exact.rationals import common_denominator
from fairaudit.inference.comparisons import Comparison
from fairaudit.inference.verdicts import Verdict, foremost_verdict
from fairaudit.inference.verdicts import verdict as interval_verdict
from fairaudit.measures.expectations import compared_expectations
from fairaudit.measures.limits import Quantity
from fairaudit.measures.ratios import Ratio
from fairaudit.model.law import Law
from fairaudit.model.utility import Utility, UtilityTable
from fairaudit.tables.columns import MISSING_LABEL
from fairaudit.tables.values import INT64, Label
from fairaudit.words import WHATEVER, approximate, brief

if TYPE_CHECKING:
    from fairaudit.theorems.t19 import Pair

__all__ = [
    "Undecided",
    "Whatever",
    "ask_undecided",
    "decisions_by_group",
    "excluding",
    "judged_whatever",
    "undecided_of_log",
    "whatever",
    "whatever_text",
    "with_meanings",
]

Name = TypeVar("Name", bound=str)


def decisions_by_group(law: Law, decisions: Collection[str]) -> dict[Label, tuple[Fraction, Fraction]]:
    """How many decisions on each group were one of these, and how many there were in all; groups without a decision are left out.

    Examples
    --------
    >>> law = Law.from_array([[3, 1], [1, 1]], kind="counts", decisions=["yes", "open"], groups=["f", "m"])
    >>> {group: [str(number) for number in numbers] for (group,), numbers in decisions_by_group(law, ["open"]).items()}
    {'f': ['1', '4'], 'm': ['1', '2']}
    """
    at = [u for u, label in enumerate(law.decisions) if label in decisions]
    own, of = (np.zeros(len(law.groups), dtype=object) for _ in range(2))
    np.add.at(own, law.cell_group, law.weights[:, at].sum(axis=1).astype(object))
    np.add.at(of, law.cell_group, law.totals.astype(object))
    amounts = zip(law.groups, own.tolist(), of.tolist(), strict=True)
    return {label: (Fraction(amount, law.scale), Fraction(all_, law.scale)) for label, amount, all_ in amounts if all_}


Compared = tuple[dict[str, str] | None, dict[str, str], dict[str, str]]
"""Context, higher and lower group."""


@brief
@dataclass(frozen=True, repr=False)
class Undecided:
    """Decisions whose meaning is not known.

    Attributes
    ----------
    decisions : tuple of str
        Their labels.
    least, most : Fraction
        Between which values each single one of them is worth something: the range of the utility over all decisions, or the declared one.

    Examples
    --------
    >>> import fairaudit as fa
    >>> table = {"hired": ["yes", "no", "refused"] * 2, "sex": ["f"] * 3 + ["m"] * 3, "n": [3, 1, 0, 2, 1, 1]}
    >>> fa.audit(table, decision="hired", group="sex", count="n", utility="yes", undecided="refused").undecided
    Undecided(decisions=('refused',), least=Fraction(0, 1), most=Fraction(1, 1))
    """

    decisions: tuple[str, ...]
    least: Fraction
    most: Fraction


@brief
@dataclass(frozen=True, repr=False)
class Whatever:
    """Between which ends a ratio of the table lies, whatever the undecided decisions meant.

    Attributes
    ----------
    quantity : {"local", "global"}
        Of which ratio.
    least, greatest : Fraction or float
        The ends; of a table both are attained.
    least_at, greatest_at : tuple or None
        Where: context (None overall), higher and lower group; None where it is 1.

    Examples
    --------
    >>> import fairaudit as fa
    >>> table = {"hired": ["yes", "no", "refused"] * 2, "sex": ["f"] * 3 + ["m"] * 3, "n": [3, 1, 0, 2, 1, 1]}
    >>> result = fa.audit(table, decision="hired", group="sex", count="n", utility="yes", undecided="refused")
    >>> result.whatever[0].least, result.local.ratio, result.whatever[0].greatest
    (Fraction(1, 1), Fraction(3, 2), Fraction(3, 2))
    """

    quantity: Quantity
    least: Extended
    greatest: Extended
    least_at: Compared | None
    greatest_at: Compared | None


def excluding(
    law: Law,
    *,
    difference: bool,
    drift: bool,
    hidden: bool,
    stream: bool,
    selected: bool,
    units_read: bool,
    beyond_decisions: bool,
) -> dict[str, bool]:
    """What undecided decisions do not go with, by name, and whether an audit has it.

    Parameters
    ----------
    law : Law
        What is audited.
    difference, drift, hidden, stream : bool
        Whether differences, a drift, a hidden context or a stream were asked for.
    selected : bool
        Whether the pair of groups is chosen in another way than by dividing the error.
    units_read : bool
        Whether rows without a unit are anything but the worst.
    beyond_decisions : bool
        Whether a policy stands behind filters and its utility depends on more than the decision.
    """
    return {
        "differences (difference, max_difference)": difference,
        "decisions of unknown group": law.unknown is not None,
        "max_drift (--max-drift)": drift,
        "hidden_context (--hidden-context)": hidden,
        "true labels (truth)": law.truth is not None,
        "a stream": stream,
        "a way to choose a pair (select)": selected,
        "missing_units": units_read,
        "a policy behind filters whose utility depends on more than the decision": beyond_decisions,
    }


def undecided_of_log(
    given: str | Sequence[str], law: Law, utility: Utility, beside: Mapping[str, Any], *, judged: bool
) -> tuple[tuple[str, ...], tuple[str, ...]]:
    """Find which decisions of a log, or of a law that says so, are undecided: those asked for, and all that say so.

    Parameters
    ----------
    given : str or sequence of str
        Labels that were asked for.
    law : Law
        The table.
    utility : Utility
        What decisions are worth; those that it names mean what it says.
    beside : mapping of str to object
        What undecided decisions do not go with, by name.
    judged : bool
        Whether there are targets.

    Returns
    -------
    labels, notes : tuple of str
        The labels, and why some are left as they are.

    Raises
    ------
    InputError
        If errors are to be bounded, or targets judged, together with something that undecided decisions do not go with.
    """
    labels = (given,) if isinstance(given, str) else tuple(given)
    log = law.evaluation
    if log is None and (not law.undecided or (labels and MISSING_LABEL not in law.undecided)):
        return labels, ()
    from fairaudit.tables.evaluations.samples import ERROR, UNDECIDED

    errors = (ERROR,) if log is not None and log.errors == "bound" else ()
    occurring = [label for u, label in enumerate(law.decisions) if law.weights[:, u].any()]
    found = tuple(label for label in occurring if label in (*law.undecided, *(() if log is None else (*UNDECIDED, *errors))))
    found = tuple(label for label in found if label not in utility.values or label in errors)
    other = next((name for name, asked in beside.items() if asked), None)
    if labels or not found or other is None:
        return tuple(dict.fromkeys((*labels, *found))), ()
    if set(found) & {*errors}:
        raise InputError(f"errors that are bounded are decisions of unknown meaning, which do not go with {other}; leave one of them out")
    if MISSING_LABEL in found:
        raise InputError(f"missing decisions that are undecided do not go with {other}; leave it out, or use missing=drop (--missing drop)")
    listed = ", ".join(map(shown, found))
    if found and judged:
        raise InputError(
            f"answers of the log decide nothing ({listed}), so that targets are judged whatever they meant, and that does not go with "
            f"{other}; leave it out, or give these decisions a utility"
        )
    return (), (f"{listed}: what these answers may have meant is not bounded together with {other}",) if found else ()


def ask_undecided(
    given: str | Sequence[str], utility: UtilityTable, declared: Mapping[str, Fraction], beside: Mapping[str, Any]
) -> Undecided | None:
    """Read which decisions are undecided, and refuse them where nothing can be said with them.

    Parameters
    ----------
    given : str or sequence of str
        Labels of decisions; empty if there are none.
    utility : UtilityTable
        The utility on what is audited.
    declared : mapping
        Constants that were declared: the least (``m``) and the greatest utility (``gamma``) are the range.
    beside : mapping of str to object
        What it does not go with, by name.

    Raises
    ------
    InputError
        If a label is no decision, or is named twice; if no other decision is left; or together with something that it does not go with.
    """
    labels = (given,) if isinstance(given, str) else tuple(given)
    law = utility.law
    if not labels:
        return None
    for label in labels:
        if label not in law.decisions:
            raise InputError(
                f"undecided names the decision {shown(str(label))}, which does not occur; {nearest(str(label), law.decisions)}"
            )
    if len(set(labels)) < len(labels):
        raise InputError(f"undecided names the decision {shown(next(one for one in labels if labels.count(one) > 1))} twice")
    if set(labels) == set(law.decisions):
        raise InputError("every decision is undecided, so that nothing was decided; name those alone whose meaning is not known")
    for name, other in beside.items():
        if other:
            raise InputError(f"undecided decisions do not go with {name}; leave one of them out")
    listed = tuple(label for label in law.decisions if label in labels)
    return Undecided(listed, declared.get("m", utility.m), declared.get("gamma", utility.gamma))


def whatever(undecided: Undecided | None, table: UtilityTable, measured: Mapping[Quantity, Ratio | None]) -> tuple[Whatever, ...]:
    """Find between which ends the ratios of a table lie, whatever its undecided decisions meant."""
    if undecided is None:
        return ()
    law = table.law
    extremes = [valued(table, undecided, worth) for worth in (undecided.least, undecided.most)]
    found = []
    from fairaudit.theorems.t19 import ratio_range

    for quantity, ratio in measured.items():
        if ratio is None:
            continue
        low, high = (compared_expectations(law, one, within_context=quantity == "local") for one in extremes)
        ends = ratio_range([list(zip(*both, strict=True)) for both in zip(low, high, strict=True)])
        name = _local_labels(law) if quantity == "local" else _overall_labels(law)
        found.append(
            Whatever(quantity, ends.least, ends.greatest, *(None if at is None else name(at) for at in (ends.least_at, ends.greatest_at)))
        )
    return tuple(found)


def whatever_text(ranges: Sequence[Whatever], *, contexts: bool) -> str:
    """Say between which ends the ratios of a table lie, whatever its undecided decisions meant; empty where none is undecided."""
    named = {"local": "the ratio within contexts", "global": "the ratio over all"} if contexts else {"local": "the ratio"}
    ends = [
        f"{named[one.quantity]} is from {approximate(one.least, 'down')} to {approximate(one.greatest, 'up')}"
        for one in ranges
        if one.quantity in named
    ]
    return f"Whatever the undecided decisions meant, {' and '.join(ends)}, in the table." if ends else ""


def _local_labels(law: Law) -> Callable[[Pair], Compared]:
    """Names of the cells that are compared within contexts."""
    cells = np.flatnonzero(law.compared).tolist()
    contexts = [int(law.cell_context[i]) for i in cells]
    starts = [0, *(i for i, (one, other) in enumerate(pairwise(contexts), 1) if one != other)]

    def named(pair: Pair) -> Compared:
        block, higher, lower = pair
        first = starts[block]
        groups = (law.group_label(int(law.cell_group[cells[first + i]])) for i in (higher, lower))
        return law.context_label(contexts[first]), *groups  # type: ignore[return-value]

    return named


def _overall_labels(law: Law) -> Callable[[Pair], Compared]:
    """Names of the groups whose means are compared."""
    return lambda pair: (None, law.group_label(law.global_groups[pair[1]]), law.group_label(law.global_groups[pair[2]]))


def valued(table: UtilityTable, undecided: Undecided, worth: Fraction) -> UtilityTable:
    """The same utility, every undecided decision being worth so much."""
    at = [table.law.decisions.index(label) for label in undecided.decisions]
    scale = common_denominator([(1, table.scale), (worth.numerator, worth.denominator)])[1]
    values = table.values.astype(object) * (scale // table.scale)
    values[..., at] = worth.numerator * (scale // worth.denominator)
    small = max(map(abs, values.ravel().tolist())) <= INT64
    return replace(table, values=values.astype(np.int64) if small else values, scale=scale)


def with_meanings(
    compare: Callable[[Utility, UtilityTable, Mapping[str, Fraction]], Mapping[Name, Comparison]],
    comparisons: Mapping[Name, Comparison],
    undecided: Undecided | None,
    utility: Utility,
    table: UtilityTable,
) -> dict[Name, Comparison]:
    """The same comparisons, with the cells of either extreme of what undecided decisions may have meant.

    Parameters
    ----------
    compare : callable
        What makes the comparisons of a utility, given its range where that was declared: either extreme has the same.
    comparisons : mapping
        Those at face value.
    undecided : Undecided or None
        Which decisions are undecided, if any.
    utility, table : Utility, UtilityTable
        The utility at face value.
    """
    if undecided is None or not comparisons:
        return dict(comparisons)
    limits = next(iter(comparisons.values())).limits
    declared = {} if limits is None else dict(zip(("m", "gamma"), limits, strict=True))
    extremes = []
    for worth in (undecided.least, undecided.most):
        values = {**utility.values, **dict.fromkeys(undecided.decisions, worth)}
        own = replace(utility, values=values) if utility.entries is None else utility
        extremes.append(compare(own, valued(table, undecided, worth), declared))
    return {
        quantity: replace(one, meanings=(extremes[0][quantity].cells, extremes[1][quantity].cells), profiles=())
        for quantity, one in comparisons.items()
    }


def judged_whatever(
    undecided: Undecided | None, ranges: Sequence[Whatever], targets: tuple[Target, ...], verdict: Verdict
) -> tuple[tuple[Target, ...], Verdict]:
    """The same targets, judged whatever undecided decisions meant: of the table by its ranges; an interval of the population knows."""
    if undecided is None:
        return targets, verdict
    known = {one.quantity: (one.least, one.greatest) for one in ranges}

    def judge(target: Target) -> Target:
        own: Verdict = target.verdict
        if target.confidence is None and target.quantity in known:
            own = interval_verdict(known[target.quantity], **{f"max_{target.unit}": target.limit})
            own = "depends" if own == "inconclusive" else own
        return replace(target, verdict=own, under=WHATEVER)

    judged = tuple(map(judge, targets))
    return judged, foremost_verdict(target.verdict for target in judged)
