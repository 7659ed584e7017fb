"""`certify`: the one place that decides what is measured, bounded and claimed for an input."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from fractions import Fraction
from typing import TYPE_CHECKING, Any

from fairaudit.audits.declared import ByContext, Constants, read_declared
from fairaudit.audits.differences import bounded, judged_differences, measured_differences, refuse_signed, with_ratios
from fairaudit.audits.drift import refuse_drift, under_drift
from fairaudit.audits.hidden_context import judged_with_hidden_context, read_hidden_context
from fairaudit.audits.population import (
    cut_at_own_median,
    decisions_given_truth,
    intervals_of_stream,
    possible_comparisons,
    ratio_intervals,
    refuse_nothing_drawn,
    without_missing_units,
)
from fairaudit.audits.result import Result, not_compared
from fairaudit.audits.targets import judged, judged_by_window
from fairaudit.audits.undecided import ask_undecided, excluding, judged_whatever, undecided_of_log, whatever, with_meanings
from fairaudit.errors import InputError, shown
from fairaudit.exact.rationals import Number
from fairaudit.inference.comparisons import Comparison, MissingUnits
from fairaudit.inference.ends import Method
from fairaudit.inference.interval import Interval, Selection
from fairaudit.inference.levels import confidence_level, equal_share
from fairaudit.inference.verdicts import foremost_verdict
from fairaudit.measures.differences import least_signed_expectation
from fairaudit.measures.distances import demographic_parity, equalized_odds
from fairaudit.measures.limits import MEASURED, Quantity, difference_limits_of, limits_of, without_bare_limits
from fairaudit.measures.ratios import Ratio, global_fairness, global_supremum, local_fairness, local_supremum
from fairaudit.model.law import Law
from fairaudit.model.utility import Utility, UtilityTable, Values
from fairaudit.tables.values import Label, LabelLike
from fairaudit.theorems.applicable import Guarantees, guarantees
from fairaudit.theorems.bound import ANY_POLICY, NEAR_POLICY
from fairaudit.theorems.t14 import HiddenContext

if TYPE_CHECKING:
    from fairaudit.audits.unknown import Share, Whoever
    from fairaudit.inference.anytime import Arrivals
    from fairaudit.inference.changes import Window
    from fairaudit.model.policy import Deployment
    from fairaudit.theorems.case import Case


__all__ = ["certify", "laid_out"]


@without_bare_limits(MEASURED)
def certify(
    subject: Law | Deployment,
    utility: Utility | Values,
    *,
    max_local_ratio: Number | None = None,
    max_global_ratio: Number | None = None,
    max_local_log: Number | None = None,
    max_global_log: Number | None = None,
    difference: bool = False,
    max_difference: Number | None = None,
    max_global_difference: Number | None = None,
    confidence: Number | None = 0.95,
    interval: Method | None = None,
    independent: bool = False,
    select: Selection = "bonferroni",
    missing_units: MissingUnits = "worst",
    declared: Mapping[str, Number] | None = None,
    declared_in: ByContext | None = None,
    max_drift: Number | None = None,
    hidden_context: HiddenContext | str | Sequence[Number] | None = None,
    all_bounds: bool = False,
    embed_table: bool | None = None,
    arrivals: Arrivals | None = None,
    changed: tuple[Quantity, Window] | None = None,
    positive: LabelLike | None = None,
    burden: bool = False,
    unknown_share: Mapping[LabelLike | Label, Sequence[Number]] | None = None,
    undecided: str | Sequence[str] = (),
    one_sided: bool = False,
) -> Result:
    """Measure a law exactly, say what follows for the population behind it, judge it against targets, and prepare a certificate.

    Parameters
    ----------
    subject : Law or Deployment
        What to audit: a law, or a policy behind filters (`Policy.behind`), which adds what the filters guarantee.
    utility : Utility or mapping
        g; a mapping from decision to value is taken as `Utility(mapping)`.
    max_local_ratio, max_global_ratio : number or str, optional
        Targets for R and R̄, such as ``"5/4"``; one under 1 is least over greatest, so that 0.8 is 5/4.
    max_local_log, max_global_log : number or str, optional
        Targets for L and L̄, their natural logarithms. Floats are read as the decimals that they are printed as.
    difference : bool
        Whether to state differences of expected utilities, too: the greatest within contexts (D), and of group means. They do not depend on
        the origin of the utility, which may then be negative; ratios, and whatever bounds them, are left out of such an audit.
    max_difference, max_global_difference : number or str, optional
        Targets for these differences, on the scale of the utility.
    confidence : float or None
        Targets on counts are judged for the population from which they were drawn, all of them together at this confidence. None judges
        the table itself. Probabilities carry no sample size, and scores above their own median are no independent draws: the table
        itself is judged.
    interval : {"hoeffding-kl", "empirical-bernstein", "intersection"}, optional
        For utilities with more than two values; to be chosen before looking at the draws. By default contrasts of the draws
        ("symmetric-betting") where cells are independent, each utility is the mean of one of them and they are not too many; else
        "hoeffding-kl". Utilities of two values have exact binomial intervals.
    independent : bool
        Whether the draws of different cells are independent of each other, which narrows intervals and is an assumption of the
        certificate. Decisions on the same profiles with only the group exchanged are not.
    select : {"bonferroni", "half-split"}
        How the lower end of many pairs is found, to be chosen before looking: all pairs share the error; or, of `independent` cells of
        draws that are 0 or one positive number, one half of the draws chooses a pair and the other half tests it at the full error. It is
        for the ratios with a target, for all where there is none.
    missing_units : {"worst", "drop"}
        Of a log with sampling units that were seen in several groups of a context, which are then compared within the units: whether a unit
        that was not seen in one of two groups counts as what is worst for each claim, or, because it is missing by design, an assumption of
        the certificate, is left out of that pair.
    declared : mapping, optional
        Constants that hold whatever the table says: ``gamma`` and ``m``, the greatest and least value of g over everything that could be
        drawn, at least 0 unless differences are asked for; for a policy behind filters also ``tau``, a floor of every group's expected
        utility behind the filter, ``global_tau``, a floor of every group's mean, and ``lipschitz``, a bound of the difference of g between
        groups. What is said of every policy that keeps a floor needs a declared floor, and what is said of any utility needs ``gamma`` and
        ``m``.
    declared_in : mapping of label to mapping, optional
        ``gamma``, ``m`` and ``tau`` of single contexts of a policy behind filters.
    max_drift : number or str, optional
        How far things may move, in total variation. Of a table the law of the decision in each cell, each on its own, the contexts of each
        group staying distributed as they are: the certificate then has the worst and the best ratio within that, and targets are judged
        for all of it. Of a policy behind filters the policy, for everything that the filters release: the certificate then has the
        greatest ratio of all policies as near as that.
    hidden_context : str or sequence, optional
        ``"k,m"`` or ``"k,m,direction"``: an unrecorded factor that is at most k times as common in one group as in another of the same
        context, and changes what one of the two gets at most m times (`"inf"` is no limit). Targets for ratios are then judged by what it
        leaves of them at the least; a target that is not exceeded stays open, because how much a fair ratio may hide has no bound. The
        direction is "both"; "higher" limits only how much more common it is in the group that gets more, and m is then about the other;
        "lower" is the reverse.
    all_bounds : bool
        Whether to state bounds that the greatest ratio over policies makes superfluous, too.
    embed_table : bool, optional
        Whether the certificate holds the table; by default if it has at most 100,000 entries. False leaves only a salted digest, and
        needs confidence None, because the ends of intervals disclose the counts.
    arrivals : Arrivals, optional
        The law was counted from a stream, whose cells first appeared in this order: then the intervals hold at every moment at once,
        whenever the counting stopped. Needs ``gamma`` and ``m`` to be declared; `interval` and `independent` have no meaning.
    changed : tuple of (quantity, Window), optional
        With `arrivals`: a window whose interval of that ratio has no ratio in common with the stream's. Its verdict is then "changed", and
        nothing is claimed of the ratios of the whole stream.
    positive : label, optional
        The positive true label of a law with true labels (``truth=``), where the positive decisions do not name it; positive decisions are
        those that are worth more than nothing.
    burden : bool
        Whether the utility counts a burden, such as a fine or a refusal: the group with the higher expectation is then called
        disadvantaged. The figures are the same.
    unknown_share : mapping of label to (number, number), optional
        Of a law with decisions of unknown group (``unknown=``): between which shares of them are of a group, in every context and over all;
        ``"*"`` stands for all who are of none of the groups. Targets are then judged of the table, whoever the unknown are.
    undecided : str or sequence of str
        Decisions whose meaning is not known, such as ``["refused", "unreadable"]``. The figures count them with the utility that they have,
        0 by default; ranges say what the ratios would be whatever each single one of them had meant, between the least and the greatest
        utility (or ``m`` and ``gamma``, where they are declared), and targets are judged by these, those of the population by an interval
        that holds whatever they meant.
    one_sided : bool
        Whether ends of intervals hold each by itself without a target, too; else both hold together.

    Returns
    -------
    Result
        Exact measures with witnesses, intervals, claims, verdict and certificate.

    Raises
    ------
    InputError
        If the utility does not fit the law, a target is not sensible, a declared constant contradicts the table, a target on counts is
        to be judged at a confidence and they are not whole, or nothing at all can be compared.

    Examples
    --------
    >>> law = Law.from_counts(
    ...     {"hired": ["yes", "no", "yes", "no"], "sex": ["f", "f", "m", "m"], "n": [300, 100, 200, 200]},
    ...     decision="hired", group="sex", count="n")
    >>> result = certify(law, {"yes": 1}, max_local_ratio="5/4")
    >>> result.local.ratio, result.verdict
    (Fraction(3, 2), 'exceeds')
    >>> found = result.intervals["local"]
    >>> round(float(found.lower), 2), round(float(found.upper), 2)
    (1.25, 1.76)
    """
    limits = limits_of(
        {
            "max_local_ratio": max_local_ratio,
            "max_global_ratio": max_global_ratio,
            "max_local_log": max_local_log,
            "max_global_log": max_global_log,
        }
    )
    of_differences = difference_limits_of({"max_difference": max_difference, "max_global_difference": max_global_difference})
    difference = difference or bool(of_differences)
    level = None if confidence is None or cut_at_own_median(subject) else confidence_level(confidence)
    utility = utility if isinstance(utility, Utility) else Utility(utility, signed=difference)
    subject, table = laid_out(subject, utility)
    refuse_signed(subject, table, asked=difference, ratios=limits)
    deployment, law = (None, subject) if isinstance(subject, Law) else (subject, subject.law)
    _check_selection(select, subject, arrivals, level)
    if deployment is not None and deployment.policy.law.evaluation is not None:
        raise InputError("the law of a policy is not read from an evaluation log; audit the log itself, without filters")
    if level is not None and law.evaluation is not None:
        refuse_nothing_drawn(law.evaluation)
    shares = _shares(law, unknown_share or {}, difference=difference, drift=max_drift is not None)
    of_table, limits = (limits, []) if law.unknown is not None else ([], limits)
    local, overall = (None, None) if table.signed else _both(law, table)
    differences = measured_differences(law, table) if difference else {}
    if not any((local, overall, *differences.values())):
        raise InputError("no two groups can be compared: no context has two groups, and no two groups have a population")
    measured: dict[Quantity, Ratio | None] = {"local": local, "global": overall}
    beside = {
        "targets for differences": of_differences,
        "a stream": arrivals,
        "decisions of unknown group": law.unknown is not None,
        "max_drift": max_drift,
    }
    hidden = read_hidden_context(hidden_context, subject, measured, limits, beside)
    tau = least_signed_expectation(law, table)
    constants, constants_in = read_declared(
        table, tau, declared or {}, declared_in or {}, max_drift, deployment, signed=difference and deployment is None
    )
    not_undecided = excluding(
        law,
        difference=difference,
        drift=max_drift is not None,
        hidden=hidden is not None,
        stream=arrivals is not None,
        selected=select != "bonferroni",
        units_read=missing_units != "worst",
        beyond_decisions=deployment is not None and not table.by_decision,
    )
    supplied = law if deployment is None else deployment.policy.law
    labels, unbounded = undecided_of_log(undecided, supplied, utility, not_undecided, judged=bool(limits or of_table or of_differences))
    meanings = ask_undecided(labels, table, constants, not_undecided)
    refuse_drift(deployment, table, max_drift, of_differences=difference, stream=arrivals is not None)
    given, said = decisions_given_truth(subject, table, positive, None if arrivals else level, embed_table)
    case = None if deployment is None else _case(deployment, law, table, constants, constants_in)
    found = Guarantees() if case is None else guarantees(case, tau, all_bounds=all_bounds)
    named = {quantity for quantity, _, _ in limits}
    named_differences = {quantity for quantity, _, _ in of_differences}
    comparisons: dict[Quantity, Comparison] = {}
    notes: tuple[str, ...] = ()
    intervals: dict[Quantity, Interval] = {}
    if arrivals is not None and level is not None:
        intervals, notes = intervals_of_stream(law, table, arrivals, measured, constants, 1 - equal_share(1 - level, len(named)), named)
    elif level is not None:
        compared = {quantity: measured[quantity] or differences.get(quantity) for quantity in measured}
        what = "ratio" if not difference else "difference" if table.signed else "ratio or difference"
        comparisons, notes = possible_comparisons(
            subject, utility, table, compared, constants, named | named_differences, embed_table, what
        )
        _check_drawn(select, comparisons, notes)
        comparisons = with_meanings(
            lambda own, valued, limits: possible_comparisons(subject, own, valued, compared, limits, named, embed_table)[0],
            comparisons,
            meanings,
            utility,
            table,
        )
    if missing_units != "worst":
        comparisons = without_missing_units(comparisons, missing_units)
    # A verdict rests on one end. Targets share the error, so that their verdicts hold together; what has no target has all of it.
    judging = sum(quantity in comparisons for quantity, _, _ in (*limits, *of_differences))
    errors = {q: equal_share(1 - Fraction(level or 0), judging if q in named_differences else 1) for q in comparisons}
    chosen: dict[str, Any] = {"method": interval, "independent": independent}
    found_differences = bounded(differences, comparisons, errors, named_differences, **chosen) if difference else None
    of_ratios, said_of_sign = with_ratios(table, comparisons, constants, limits, select)
    notes = (*notes, *said_of_sign)
    chosen |= {"one_sided": one_sided, "select": select}
    found_intervals, said_of_means = ratio_intervals(of_ratios, measured, Fraction(level or 0), judging, named, **chosen)
    intervals, notes = intervals | found_intervals, (*notes, *said_of_means)
    sampled = level if (deployment.policy.law if deployment else law).kind == "counts" else None
    change = None
    if changed is not None:
        if changed[0] not in intervals or arrivals is None:
            raise InputError("a window contradicts the interval of a stream; there is none without arrivals and a confidence")
        from fairaudit.inference.changes import change_of

        change = change_of(intervals[changed[0]], changed[1], changed[0], (constants["m"], constants["gamma"]))
        intervals = {quantity: own for quantity, own in intervals.items() if quantity not in change.withdrawn}
    usable = found.bounds if meanings is None else ()  # they are about the utility at face value
    targets, verdict = judged(measured, limits, sampled, intervals, usable, constants, group_free=not table.depends_on_group)
    if hidden is not None:
        targets = judged_with_hidden_context(hidden, measured, limits, sampled, intervals)
        verdict = foremost_verdict(target.verdict for target in targets)
    if found_differences is not None:
        targets = (*targets, *judged_differences(found_differences, of_differences, sampled))
        verdict = foremost_verdict(target.verdict for target in targets)
    if change is not None:
        targets, verdict = judged_by_window(targets, verdict, change)
    unknown = _whoever(law, table, measured, shares)
    if of_table:
        from fairaudit.audits.unknown import judged_whoever

        targets = judged_whoever(unknown, of_table, law, table, measured)
        verdict = foremost_verdict(target.verdict for target in targets)
    ranges = whatever(meanings, table, measured)
    targets, verdict = judged_whatever(meanings, ranges, targets, verdict)
    without = deployment.unfiltered if deployment else None
    result = Result(
        law=law,
        utility=table,
        local=local,
        global_=overall,
        demographic_parity=demographic_parity(law),
        equalized_odds=equalized_odds(law),
        local_supremum=None if table.signed else local_supremum(law),
        global_supremum=None if table.signed else global_supremum(law),
        tau=tau,
        not_compared=(*not_compared(law), *(given.not_compared if given else ())),
        targets=targets,
        verdict=verdict,
        notes=(
            *law.notes,
            *unbounded,
            *notes,
            *said,
            *(_unseen(deployment) if deployment else ()),
            *(_left_out(case, found, measured) if case else ()),
        ),
        deployment=deployment,
        unfiltered=None if without is None else _both(without, replace(table, law=without)),
        bounds=found.bounds,
        suprema=found.suprema,
        declared=constants,
        declared_in=constants_in,
        intervals=intervals,
        comparisons=of_ratios,
        differences=found_differences,
        embed=embed_table,
        given_truth=given,
        burden=burden,
        changed=change,
        method=interval,
        whoever=unknown,
        unknown_shares=shares if law.unknown is not None else (),
        hidden_context=hidden,
        undecided=meanings,
        whatever=ranges,
    )
    return under_drift(result) if deployment is None and max_drift is not None else result


def laid_out(subject: Law | Deployment, utility: Utility) -> tuple[Law | Deployment, UtilityTable]:
    """Lay a utility out over a law, or over the one that filters induce, all of which then have the decisions that it names.

    Raises
    ------
    InputError
        If it does not fit.
    """
    law = subject if isinstance(subject, Law) else subject.law
    table = utility.on(law)
    if table.law is law:
        return subject, table
    if isinstance(subject, Law):
        return table.law, table
    from fairaudit.model.policy import Policy

    deployment = replace(subject, policy=Policy(utility.over(subject.policy.law)))
    return deployment, replace(table, law=deployment.law)


def _shares(law: Law, given: Mapping[LabelLike | Label, Sequence[Number]], *, difference: bool, drift: bool) -> tuple[Share, ...]:
    """The declared shares of decisions of unknown group; what does not go with these is refused."""
    if law.unknown is None and not given:
        return ()
    from fairaudit.audits.unknown import ask_shares, refuse_beside_unknown_groups

    refuse_beside_unknown_groups(law, difference=difference, drift=drift)
    return ask_shares(given, law)


def _whoever(law: Law, table: UtilityTable, measured: Mapping[Quantity, Ratio | None], shares: tuple[Share, ...]) -> tuple[Whoever, ...]:
    """The range of the ratios, whoever decisions of unknown group are; none where there are no such decisions."""
    if law.unknown is None:
        return ()
    from fairaudit.audits.unknown import whoever

    return whoever(law, table, measured, shares)


def _case(deployment: Deployment, law: Law, table: UtilityTable, constants: Constants, constants_in: Mapping[Label, Constants]) -> Case:
    from fairaudit.theorems.case import Case

    return Case(deployment, law, table, constants, declared_in=constants_in)


def _check_selection(select: Selection, subject: Law | Deployment, arrivals: Arrivals | None, level: Fraction | None) -> None:
    """Refuse a way to choose a pair where nothing is drawn from a table of counts."""
    sampled = isinstance(subject, Law) and subject.kind == "counts" and arrivals is None and level is not None
    if select != "bonferroni" and not sampled:
        raise InputError(f"select {shown(select)} is for the population behind a table or log of counts, at a confidence")


def _check_drawn(select: Selection, comparisons: Mapping[Quantity, Comparison], notes: Sequence[str]) -> None:
    """The same where no interval is possible."""
    if select != "bonferroni" and not comparisons:
        raise InputError(f"select {shown(select)} needs draws of the population: {'; '.join(notes)}")


def _unseen(deployment: Deployment) -> Iterator[str]:
    """What is said of groups and contexts of a policy that its filters neither take nor release: none of the figures is about them."""
    law = deployment.policy.law
    kinds = [("group", law.groups, deployment.group_filter)]
    if deployment.context_filter is not None:
        kinds.append(("context", law.contexts, deployment.context_filter))
    for kind, labels, mechanism in kinds:
        known = {*mechanism.inputs, *mechanism.outputs}
        lost = [label for label in labels if label not in known]
        if lost:
            more = f" and {len(lost) - 1:,} more" if len(lost) > 1 else ""
            said = f"the {kind} {shown(', '.join(lost[0]))}{more} of the policy"
            yield f"{said}: no value of the {kind} filter, and left out of all figures"


def _left_out(case: Case, found: Guarantees, measured: Mapping[Quantity, Ratio | None]) -> Iterator[str]:
    """What is said of guarantees that would take a reader, or this machine, too much."""
    from fairaudit.theorems.case import TOO_WIDE
    from fairaudit.theorems.t13_cases import TOO_MANY, TOO_NEAR

    wanted = {quantity for quantity, ratio in measured.items() if ratio is not None}
    if not case.narrow:
        yield TOO_WIDE
    elif case.utility.given is None and wanted - {one.quantity for one in found.suprema if one.scope == ANY_POLICY}:
        yield TOO_MANY
    if "max_drift" in case.declared and wanted - {one.quantity for one in found.suprema if one.scope == NEAR_POLICY}:
        yield TOO_NEAR


def _both(law: Law, table: UtilityTable) -> tuple[Ratio | None, Ratio | None]:
    return local_fairness(law, table), global_fairness(law, table)
