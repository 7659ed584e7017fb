"""What the draws behind counts say of the population, as far as an interval is possible, and why it is not."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace
from fractions import Fraction
from typing import TYPE_CHECKING, Any, get_args

from fairaudit.errors import InputError, nearest, shown
from fairaudit.inference.comparisons import Comparison, MissingUnits
from fairaudit.inference.draws import unit_columns
from fairaudit.inference.ends import Method
from fairaudit.inference.interval import Interval, Selection
from fairaudit.inference.levels import equal_share
from fairaudit.inference.ratio_intervals import default_region, ratio_interval
from fairaudit.inference.table_comparisons import global_comparison, local_comparison
from fairaudit.measures.differences import MeanDifference
from fairaudit.measures.limits import Quantity
from fairaudit.measures.rates import given_truth
from fairaudit.measures.ratios import Ratio
from fairaudit.model.law import Law
from fairaudit.model.utility import Utility, UtilityTable
from fairaudit.theorems.assumptions import FRESH
from fairaudit.words import approximate

if TYPE_CHECKING:
    from fairaudit.inference.anytime import Arrivals
    from fairaudit.inference.rates import GivenTruth
    from fairaudit.model.policy import Deployment
    from fairaudit.tables.evaluations.samples import Evaluation

DISCLOSED = "the ends of intervals would disclose the counts of a certificate without its table"


def decisions_given_truth(
    subject: Law | Deployment, table: UtilityTable, positive: Any, confidence: Fraction | None, embed: bool | None
) -> tuple[GivenTruth | None, tuple[str, ...]]:
    """What the decisions are given the true label, with intervals as far as they are possible, and why they are not."""
    if not isinstance(subject, Law):
        if subject.policy.law.truth is not None or positive is not None:
            raise InputError("true labels go with counts and logs, not with a policy behind filters")
        return None, ()
    rates = given_truth(subject, table, positive)
    if rates is None:
        return None, ()
    from fairaudit.inference.rates import GivenTruth, with_intervals

    found = GivenTruth(rates.law, rates.positive)
    if confidence is None:
        return found, ()
    reason = ""
    if subject.units is not None:
        reason = "rows of one sampling unit are no independent draws given their true labels"
    elif not subject.whole:
        reason = "the counts are not whole numbers of draws"
    elif embed is False:
        reason = DISCLOSED
    if reason:
        return found, (f"no interval for the rates given the true label is claimed: {reason}",)
    return with_intervals(rates, confidence), ()


def intervals_of_stream(
    law: Law,
    table: UtilityTable,
    arrivals: Arrivals,
    measured: Mapping[Quantity, Ratio | None],
    declared: Mapping[str, Fraction],
    confidence: Fraction,
    named: set[Quantity],
) -> tuple[dict[Quantity, Interval], tuple[str, ...]]:
    """The intervals of a stream that hold at every moment, as far as they are possible, and why they are not."""
    from fairaudit.inference.anytime import stream_interval

    if not declared.keys() >= {"gamma", "m"}:
        raise InputError("intervals of a stream need the range of the utility: declare gamma and m")
    made: dict[Quantity, Interval] = {}
    notes: list[str] = []
    for quantity, ratio in measured.items():
        if ratio is None:
            continue
        try:
            made[quantity] = stream_interval(law, table, arrivals, quantity, (declared["m"], declared["gamma"]), confidence)
        except InputError as error:
            if quantity in named:
                raise
            notes.append(f"no interval for the {quantity} ratio is claimed: {error}")
    return made, tuple(notes)


def possible_comparisons(
    subject: Law | Deployment,
    utility: Utility,
    table: UtilityTable,
    measured: Mapping[Quantity, Ratio | MeanDifference | None],
    declared: Mapping[str, Fraction],
    named: set[Quantity],
    embed: bool | None,
    what: str = "ratio",
    within: UtilityTable | None = None,
) -> tuple[dict[Quantity, Comparison], tuple[str, ...]]:
    """What the draws behind counts say of the population, as far as an interval is possible, and why it is not.

    Where a law is that over all contexts together, `within` is the utility on the law of the contexts that are compared.
    """
    law = subject if isinstance(subject, Law) else subject.policy.law
    if law.kind != "counts":
        return {}, ()
    whole = min(Fraction(0), table.m), max(Fraction(0), table.gamma)
    limits = (declared.get("m", whole[0]), declared.get("gamma", whole[1])) if {"gamma", "m"} & declared.keys() else None
    made: dict[Quantity, Comparison] = {}
    notes: list[str] = []
    wanted: list[Quantity] = [quantity for quantity, ratio in measured.items() if ratio is not None]
    for quantity in wanted:
        try:
            if utility.observed and not declared.keys() >= ({"gamma", "m"} if table.signed else {"gamma"}):
                raise InputError(
                    "the utility was read from a column, and the greatest value seen there does not bound what could have been drawn; "
                    "declare its range (gamma and m, or --utility-range LOW,HIGH)"
                )
            if table.signed and not table.by_decision and not declared.keys() >= {"gamma", "m"}:
                raise InputError(
                    "the utility depends on more than the decision, and can be negative; declare its range (gamma and m, or "
                    "--utility-range LOW,HIGH)"
                )
            if embed is False:
                raise InputError(DISCLOSED)
            held = (subject, table) if within is None or quantity == "global" else (within.law, within)
            made[quantity] = _comparison(held[0], utility, held[1], quantity, limits)
            notes += made[quantity].notes
        except InputError as error:
            if quantity in named:
                raise InputError(f"{error}; confidence none (--confidence none) judges the table itself") from None
            notes.append(f"no interval for the {quantity} {what} is claimed: {error}")
    if len(wanted) == 2 and not made:
        notes = [f"no interval is claimed:{notes[0].partition(':')[2]}"]
    return made, tuple(notes)


def _comparison(
    subject: Law | Deployment, utility: Utility, table: UtilityTable, quantity: Quantity, limits: tuple[Fraction, Fraction] | None
) -> Comparison:
    if isinstance(subject, Law):
        compare = local_comparison if quantity == "local" else global_comparison
        return replace(compare(subject, table, limits=limits), limits=limits, listed=not utility.observed)
    places = [(x, a) for x in subject.contexts for a in subject.groups]
    population = None if subject.mass is None else dict(zip(places, subject.mass, strict=True))
    context = subject.context_filter
    from fairaudit.inference.policy_comparisons import policy_comparison

    found = policy_comparison(
        subject.policy, _tabulated(utility, table), subject.group_filter, context, population, local=quantity == "local", limits=limits
    )
    return replace(found, assumptions=(FRESH, *found.assumptions), limits=limits)


def ratio_intervals(
    comparisons: Mapping[Quantity, Comparison],
    measured: Mapping[Quantity, Ratio | None],
    confidence: Fraction,
    judging: int,
    named: set[Quantity],
    *,
    method: Method | None,
    independent: bool,
    select: Selection = "bonferroni",
    one_sided: bool = False,
) -> tuple[dict[Quantity, Interval], tuple[str, ...]]:
    """The intervals of ratios, and what is to be noted of them.

    Parameters
    ----------
    comparisons, measured
        What is compared, and the ratios of the table.
    confidence : Fraction
        The confidence of all that has a target, together.
    judging : int
        How many targets share its error.
    named : set
        Which ratios have a target; each end of their intervals holds by itself.
    method, independent, select, one_sided
        As for `certify`.
    """
    intervals: dict[Quantity, Interval] = {}
    notes: list[str] = []
    for quantity, comparison in comparisons.items():
        alpha = equal_share(1 - confidence, judging if quantity in named else 1)
        options: dict[str, Any] = {
            "method": method or "hoeffding-kl",
            "independent": independent,
            "ends": "each" if quantity in named or one_sided else "together",
            "select": select if quantity in named or not named else "bonferroni",
            "region": default_region(comparison, method, independent=independent, alpha=alpha),
        }
        intervals[quantity] = own = ratio_interval(comparison, 1 - alpha, **options)
        notes += two_means_note(quantity, measured[quantity], comparison)
        notes += units_note(quantity, comparison, own, method)
        notes += design_note(quantity, comparison, own)
    return intervals, tuple(notes)


def two_means_note(quantity: Quantity, over_rows: Ratio | None, comparison: Comparison) -> tuple[str, ...]:
    """A note, where the mean over units is not the mean over rows."""
    over_units = comparison.of_units
    if over_units is None or over_rows is None or over_units.ratio == over_rows.ratio:
        return ()
    rows, units = approximate(over_rows.ratio), approximate(over_units.ratio)
    said = f"the {quantity} ratio of this log is {rows} as the mean over rows and {units} as the mean over units"
    return (f"{said}; the interval, and a target that is judged by it, is about the mean over units",)


def units_note(quantity: Quantity, comparison: Comparison, interval: Interval, method: Method | None) -> tuple[str, ...]:
    """A note on how groups that were seen in the same units were compared, or why not within them, unless a method was asked for."""
    if not comparison.profiles or comparison.units is None:
        return ()
    total = sum(n for profiles in comparison.profiles for n in profiles.values())
    everywhere = sum(n for profiles in comparison.profiles for values, n in profiles.items() if None not in values)
    of = f"the units of {unit_columns(comparison.units)}"
    if interval.region == "paired":
        worst = comparison.missing == "worst"
        rest = "counts as what is worst for each claim" if worst else "is left out of pairs with that group, as missing by design"
        others = "" if everywhere == total else f"; in a group in which it was not seen, a unit {rest}"
        where = "groups" if quantity == "global" else "groups of a context"
        return (f"the {quantity} ratio compares {where} within {of}, {everywhere} of {total} of which were seen in all of them{others}",)
    if everywhere == total or method is not None:
        return ()
    said = f"the {quantity} ratio does not compare groups within {of}: {total - everywhere} of {total} were not seen in all groups"
    design = "if that is by design, missing_units drop (--missing-units drop) may leave them out of the pairs that they miss"
    return (f"{said}; {design}" if comparison.missing == "worst" else said,)


def design_note(quantity: Quantity, comparison: Comparison, interval: Interval) -> tuple[str, ...]:
    """A note, where units that were left out as missing by design do not seem to be like the others."""
    estimate = interval.estimate
    if interval.region != "paired" or comparison.missing == "worst" or estimate is None or interval.lower <= estimate <= interval.upper:
        return ()
    ends = f"{approximate(interval.lower, 'down')} and {approximate(interval.upper, 'up')}"
    said = f"the {quantity} ratio is {approximate(estimate)} with all units, and between {ends} of those that were seen in both groups"
    unlike = "they do not seem to be like the others, as they would be if units were missing by design"
    return (f"{said}: {unlike}; do not rely on missing_units drop (--missing-units drop) here",)


def without_missing_units(comparisons: Mapping[Quantity, Comparison], missing: MissingUnits) -> dict[Quantity, Comparison]:
    """The same comparisons, units that were not seen in a group being left out of pairs with it.

    Raises
    ------
    InputError
        If the value is none that is accepted, or there are no sampling units.
    """
    if missing not in get_args(MissingUnits):
        raise InputError(f"missing_units is {shown(missing)}; {nearest(str(missing), get_args(MissingUnits))}")
    if not any(comparison.units for comparison in comparisons.values()):
        raise InputError("missing_units is about a log with sampling units, at a confidence; name their column as unit (--unit)")
    return {quantity: replace(comparison, missing=missing) for quantity, comparison in comparisons.items()}


def _tabulated(utility: Utility, table: UtilityTable) -> Utility:
    """The utility without entries for contexts and groups that are not there."""
    if utility.entries is None:
        return utility
    contexts, groups = set(table.law.contexts), set(table.law.groups)
    return replace(utility, entries={key: pair for key, pair in utility.entries.items() if key[1] in contexts and key[2] in groups})


def cut_at_own_median(subject: Law | Deployment) -> bool:
    """Whether decisions say which scores are above the median of the same scores, so that they are no independent draws."""
    law = subject if isinstance(subject, Law) else subject.policy.law
    return any(entry["step"] == "above median" for entry in law.preparation)


def refuse_nothing_drawn(evaluation: Evaluation, spelled: Callable[[str], str] = str) -> None:
    """Refuse to speak of a population of answers where the log says that each question has one answer.

    Raises
    ------
    InputError
        If it does.
    """
    from fairaudit.tables.evaluations.lost import NOTHING as NOTHING_DRAWN
    from fairaudit.tables.evaluations.lost import drawn_said

    if drawn_said(evaluation) == NOTHING_DRAWN:
        raise InputError(
            f"the log says {evaluation.fixed}: the questions are fixed, and the model answers each of them in one way, so that nothing was "
            f"drawn; {spelled('confidence')} none judges the answers that there are, or {spelled('unit')} says that questions were drawn"
        )


def confidence_for(
    subject: Law | Deployment, chosen: Fraction | None, asked: object, others: Mapping[str, object], spelled: Callable[[str], str] = str
) -> Fraction | None:
    """The confidence at which targets are judged: none where there is no sample.

    Parameters
    ----------
    subject : Law or Deployment
        What is audited.
    chosen : Fraction or None
        The confidence, or None to judge the table itself.
    asked : object
        How it was asked for; None if it is the default.
    others : mapping of str to object
        Options that are about a sample only, by name; None or false if they were not given.
    spelled : callable
        How options are written, for messages.

    Raises
    ------
    InputError
        If something was asked for that needs a sample, and there is none.
    """
    law = subject if isinstance(subject, Law) else subject.policy.law
    if law.kind != "counts":
        for name, wanted in (("confidence", asked is not None and chosen is not None), *others.items()):
            if wanted:
                raise InputError(
                    f"{spelled(name)} needs counts or a log: probabilities carry no sample size, so the table itself is judged"
                )
        return None
    if cut_at_own_median(law):
        for name, wanted in (("confidence", asked is not None and chosen is not None), *others.items()):
            if wanted:
                raise InputError(
                    f"{spelled(name)} is about a population, and the scores were cut at their own median: whether one is above it depends "
                    f"on the others, so that decisions are no independent draws; {spelled('above')} with a number that was fixed before "
                    "leaves them independent"
                )
        return None
    if chosen is not None and law.evaluation is not None:
        refuse_nothing_drawn(law.evaluation, spelled)
    if asked is not None and chosen is not None and not law.whole:
        raise InputError(
            f"{spelled('confidence')} {shown(str(asked))} needs whole counts of at most 10^18, and the table has others: weighted counts "
            f"carry no sample size; {spelled('confidence')} none judges the table itself"
        )
    if chosen is None:
        for name, wanted in others.items():
            if wanted:
                raise InputError(f"{spelled(name)} is about the population, and {spelled('confidence')} none leaves that out")
    return chosen
