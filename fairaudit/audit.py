"""`certify`: the one place that decides what is measured, bounded and claimed for an input."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from decimal import Decimal
from fractions import Fraction
from functools import cached_property
from html import escape
from itertools import pairwise
from math import inf
from typing import TYPE_CHECKING, Any, Literal

import numpy as np

from fairaudit import __version__, bounds
from fairaudit.bounds import Bound
from fairaudit.certificate import EMBED_LIMIT, FORMAT, Certificate, Table, WrittenTable, column_names, number, with_table
from fairaudit.columns import plain
from fairaudit.exact import InputError, approximate, compare_log, nearest, option_value, rational_text, shown
from fairaudit.fairness import (
    Distance,
    Ratio,
    Witness,
    cell_expectation,
    demographic_parity,
    equalized_odds,
    global_fairness,
    global_supremum,
    least_expectation,
    local_fairness,
    local_supremum,
    most_unequal_distances,
    most_unequal_ratios,
)
from fairaudit.law import Columns, Law
from fairaudit.limits import MEASURED, Limit, Quantity, Unit, limits_of, without_bare_limits
from fairaudit.mechanism import Mechanism
from fairaudit.monitor.bounds import Arrivals, Change, Window, change_of, stream_interval
from fairaudit.policy import Deployment, Policy
from fairaudit.preparation import Entry, said
from fairaudit.privacy import exp_epsilon, joint_ratios
from fairaudit.rates import NAMES, Difference, GivenTruth, Rate, given_truth
from fairaudit.sampling import (
    Comparison,
    Estimand,
    Interval,
    Method,
    Planning,
    confidence_level,
    default_region,
    further_draws,
    global_comparison,
    local_comparison,
    policy_comparison,
    ratio_interval,
)
from fairaudit.sampling import drivers as interval_drivers
from fairaudit.sampling import verdict as interval_verdict
from fairaudit.sentences import (
    THE_INTERVAL,
    Deciding,
    Drivers,
    Sizes,
    caution,
    change_text,
    decide,
    few_of_policy,
    foremost,
    identifier_text,
    place,
    sentence,
    sizes,
    words_for,
)
from fairaudit.tables.labels import spellings
from fairaudit.utility import Utility, UtilityTable

if TYPE_CHECKING:
    import pandas as pd

__all__ = ["Claim", "Result", "Target", "certify", "place"]

Verdict = Literal["none", "within", "exceeds", "inconclusive", "changed"]
ANY_CONTEXT_FILTER = "this policy and group filter, any context filter that releases these contexts"
CONFIRMED = (
    bounds.GROUP_FREE,
    bounds.DECISION_ONLY,
    bounds.INDEPENDENT,
    "the group filter multiplies",
    "the utilities of two groups differ",
)
PARITY_WITHIN = "parity within contexts (the paper's equalized odds)"
PAIR_RATIOS = 500_000
TOO_WIDE = (
    f"the bounds by T1, T3 and T4 for this filter are left out: its pairs of rows have more than {PAIR_RATIOS} joint likelihood ratios, "
    "which no certificate may ask a reader to go through"
)
RANK: dict[Verdict, int] = {"none": 0, "within": 1, "inconclusive": 2, "exceeds": 3, "changed": 4}
WINDOWS = "window i of the stream has 1/(i(i + 1)) of the error that all windows share, and where windows begin was fixed beforehand"


@dataclass(frozen=True)
class Claim:
    """A statement with its scope and evidence, as docs/certificate.md lists them."""

    quantity: str
    relation: Literal["=", "<=", ">="]
    value: Fraction | float
    by: str
    evidence: Mapping[str, Any]
    scope: str = "this law"
    assumptions: tuple[str, ...] = ()


@dataclass(frozen=True)
class Target:
    """A limit on the local or global measure, and how it was judged.

    Attributes
    ----------
    quantity : {"local", "global"}
        What is limited.
    limit : Fraction
        The limit: on L or L̄ (``unit="log"``, nats) or on R or R̄ (``unit="ratio"``).
    unit : {"log", "ratio"}
        Which of the two.
    verdict : {"within", "exceeds", "inconclusive", "changed"}
        Decided exactly; inconclusive when nothing was compared, or the draws do not decide; changed when a window contradicts the stream.
    confidence : Fraction or None
        What was judged: the population behind the draws at this confidence, or, if None, the table itself.
    upper : tuple of (Fraction or float, str) or None
        Of a target about the population, the smallest sound upper end of the ratio, and where it comes from: a theorem, or the interval.
    estimand : {"mean over rows", "mean over units"}
        Of which means the ratio is judged.
    """

    quantity: Quantity
    limit: Fraction
    unit: Unit
    verdict: Verdict
    confidence: Fraction | None = None
    upper: tuple[Fraction | float, str] | None = None
    estimand: Estimand = "mean over rows"


@dataclass(frozen=True, eq=False)
class Passed:
    """What is kept of contexts that were read in parts.

    Attributes
    ----------
    columns : Columns
        The columns of the log.
    pairs : tuple of Ratio
        The most unequal pairs within a context, most unequal first.
    distances : tuple of Distance
        The greatest total variation distances within a context.
    table : WrittenTable
        The table.
    sizes : mapping
        How many decisions were recorded of the groups of those pairs, by `pair_key`.
    """

    columns: Columns
    pairs: tuple[Ratio, ...]
    distances: tuple[Distance, ...]
    table: WrittenTable
    sizes: Mapping[tuple[str, ...], Sizes] = field(default_factory=dict)


@dataclass(frozen=True, eq=False)
class Result:
    """What `certify` found. Ratios and distances are exact.

    Attributes
    ----------
    law : Law
        What was audited.
    utility : UtilityTable
        The utility on it, with its constants ``gamma``, ``m`` and ``lipschitz()``.
    local, global_ : Ratio or None
        Local and global g-fairness with witness; None where nothing can be compared.
    demographic_parity, equalized_odds : Distance or None
        Greatest total variation distances with witness: between groups overall, and, the paper's equalized odds, within a context.
    local_supremum, global_supremum : Ratio or None
        Suprema over utilities that do not depend on the group (T6).
    tau : Fraction or None
        Least expected utility over the compared cells.
    not_compared : tuple of dict
        What was left out, and why.
    targets : tuple of Target
        The limits that were asked for.
    verdict : {"none", "within", "exceeds", "inconclusive", "changed"}
        "changed" before "exceeds" before "inconclusive" before "within"; "none" without targets.
    notes : tuple of str
        What was noticed while reading.
    deployment : Deployment or None
        The policy and its filters, if that is what was audited; `law` is then the law that they induce.
    unfiltered : tuple of (Ratio or None) or None
        Local and global g-fairness without the filters, where the policy knows every true context and group.
    bounds : tuple of Bound
        What theorems guarantee about the deployment, each with its scope and assumptions.
    declared : dict of str to Fraction
        Constants that were declared instead of read off the table.
    intervals : dict
        Intervals of the ratios of the population behind counts, under ``"local"`` and ``"global"`` where there is one.
    passed : Passed or None
        If contexts were read in parts, what was kept of them; `law` is then the law over all contexts together.
    given_truth : GivenTruth or None
        Rates of true and false positives, equal opportunity and equalized odds given the true label, where it is known.
    burden : bool
        Whether the utility counts a burden, so that the group with the higher expectation is disadvantaged.
    changed : Change or None
        A window that contradicts the stream, so that nothing is said of one constant ratio.
    """

    law: Law
    utility: UtilityTable
    local: Ratio | None
    global_: Ratio | None
    demographic_parity: Distance | None
    equalized_odds: Distance | None
    local_supremum: Ratio | None
    global_supremum: Ratio | None
    tau: Fraction | None
    not_compared: tuple[dict[str, Any], ...]
    targets: tuple[Target, ...]
    verdict: Verdict
    notes: tuple[str, ...]
    deployment: Deployment | None = None
    unfiltered: tuple[Ratio | None, Ratio | None] | None = None
    bounds: tuple[Bound, ...] = ()
    declared: Mapping[str, Fraction] = field(default_factory=dict)
    intervals: Mapping[Quantity, Interval] = field(default_factory=dict)
    comparisons: Mapping[Quantity, Comparison] = field(default_factory=dict, repr=False)
    embed: bool | None = field(default=None, repr=False)
    passed: Passed | None = field(default=None, repr=False)
    given_truth: GivenTruth | None = field(default=None, repr=False)
    burden: bool = False
    changed: Change | None = None

    @property
    def exit_code(self) -> int:
        """0 within or no target, 1 a target is exceeded, 3 inconclusive, or changed without an exceeded target."""
        if self.verdict == "changed":
            return 1 if any(target.verdict == "exceeds" for target in self.targets) else 3
        return {"none": 0, "within": 0, "exceeds": 1, "inconclusive": 3}[self.verdict]

    @cached_property
    def sentence(self) -> str:
        """Who is favoured over whom, where, and by what factor: of the pair of groups that decided the verdict.

        Without targets it is the most unequal pair, within a context if there is one. What makes little of it, such as a handful of
        decisions behind it, is said first. Labels are as in the input, unescaped.
        """
        deciding = foremost([target.verdict for target in self.targets], self.deciding)
        mean = "as mean over units" if deciding and self._by_unit(deciding) else "in the table"
        contexts = bool(self.columns.context)
        options: dict[str, Any] = {"sizes_of": self.sizes_of, "contexts": contexts, "mean": mean}
        said = sentence(deciding, self.local, self.global_, words_for(burden=self.burden), **options)
        headline = headline_pair(deciding, self.local, self.global_)
        identifiers = identifier_text(self.law, self.columns, None if self.passed is None else self.passed.table.header["contexts"])
        first = caution(headline, None if headline is None else self.sizes_of(headline), identifiers)
        changed = ""
        if self.changed is not None:
            found = self.changed
            ends = (found.stream.lower, found.stream.upper), (found.part.lower, found.part.upper)
            changed = change_text(found.quantity, found.window.number, *ends, found.confidence)
        return " ".join(text for text in (changed, first, few_of_policy(self.deployment, headline), said) if text)

    @property
    def columns(self) -> Columns:
        """Names of the decision, group and context columns."""
        return self.passed.columns if self.passed else self.law.columns

    @cached_property
    def deciding(self) -> tuple[Deciding | None, ...]:
        """For each target the pair of groups that decided it, or what else did; None where nothing could be compared."""
        found: list[Deciding | None] = []
        for target in self.targets:
            interval = self.intervals.get(target.quantity)
            measured = self.local if target.quantity == "local" else self.global_
            lower = None if interval is None else interval.lower
            found.append(decide(target, measured, lower, self.drivers.get(target.quantity, (None, None))))
        return tuple(found)

    @cached_property
    def drivers(self) -> Mapping[Quantity, Drivers]:
        """For each interval the pairs of groups that drive its lower and its upper end."""
        return {
            quantity: interval_drivers(self.comparisons[quantity], interval.evidence) if quantity in self.comparisons else interval.pairs
            for quantity, interval in self.intervals.items()
        }

    def sizes_of(self, witness: Witness) -> Sizes | None:
        """How many decisions, and sampling units, were recorded of the two groups of a pair; None where probabilities were given."""
        if self.passed is not None and witness.context is not None:
            return self.passed.sizes.get(pair_key(witness))
        return sizes(self.law, [witness])[0]

    def _by_unit(self, deciding: Deciding) -> bool:
        return bool(deciding.quantity == "local" and self.law.units and self.law.units.repeated)

    @property
    def distances(self) -> dict[str, Distance | None]:
        """Total variation distances by what they are called; without context columns there is nothing within a context."""
        columns = self.passed.columns if self.passed else self.law.columns
        within = {PARITY_WITHIN: self.equalized_odds} if columns.context else {}
        return {**within, "demographic parity": self.demographic_parity}

    @property
    def preparation(self) -> tuple[Entry, ...]:
        """What was done to the log before it was counted."""
        return self.law.preparation

    @cached_property
    def spellings(self) -> tuple[dict[str, Any], ...]:
        """Labels of one column that differ in spelling alone, as a certificate lists them."""
        law = self.deployment.policy.law if self.deployment else self.law
        columns = self.passed.columns if self.passed else law.columns
        contexts = self.passed.table.header["contexts"] if self.passed else law.contexts
        return spellings_of(law, columns, contexts)

    def _repr_html_(self) -> str:
        """What a notebook shows: verdict, sentence and figures."""
        rows = []
        for name, measured in (("local ratio", self.local), ("global ratio", self.global_)):
            if measured is None:
                rows.append(f"<tr><td>{name}</td><td>not compared</td><td></td></tr>")
            else:
                rows.append(f"<tr><td>{name}</td><td>{approximate(measured.ratio)}</td><td>{_exactly(measured.ratio)}</td></tr>")
        for name, distance in self.distances.items():
            if distance is not None:
                rows.append(f"<tr><td>{name}</td><td>{approximate(distance.value)}</td><td>{_exactly(distance.value)}</td></tr>")
        for key, found in (self.given_truth.differences if self.given_truth else {}).items():
            if found is not None:
                rows.append(f"<tr><td>{NAMES[key]}</td><td>{approximate(found.value)}</td><td>{_exactly(found.value)}</td></tr>")
        for quantity, interval in self.intervals.items():
            ends = f"{approximate(interval.lower, 'down')} to {approximate(interval.upper, 'up')}"
            of = "" if interval.of_units is None else f" ({interval.estimand}; {approximate(interval.of_units.ratio)} in this log)"
            name = f"{quantity} ratio of the population{of}, at confidence {interval.confidence}"
            rows.append(f"<tr><td>{name}</td><td>{ends}</td><td></td></tr>")
        verdict = "no target was set" if self.verdict == "none" else self.verdict
        noted = said({"spellings": self.spellings, "preparation": self.preparation})
        before = "".join(f"<p><bdi>{escape(plain(text))}</bdi></p>" for text in noted)
        return f"{before}<p><strong>{verdict}</strong>. <bdi>{escape(plain(self.sentence))}</bdi></p><table>{''.join(rows)}</table>"

    @cached_property
    def further_draws(self) -> tuple[tuple[Target, Planning], ...]:
        """For each target that the draws do not decide, an estimate of how many more would: for planning, no guarantee."""
        open_targets = [
            t for t in self.targets if t.verdict == "inconclusive" and t.confidence is not None and t.quantity in self.comparisons
        ]
        planned = []
        for t in open_targets:
            interval = self.intervals[t.quantity]
            limit: dict[str, Any] = {f"max_{t.unit}": t.limit, "interval": interval}
            planned.append((t, further_draws(self.comparisons[t.quantity], interval.confidence, **limit)))
        return tuple(planned)

    def most_unequal(self, count: int = 3) -> dict[str, tuple[Ratio, ...] | tuple[Distance, ...]]:
        """Rank the most unequal pairs of groups, by measure.

        Parameters
        ----------
        count : int
            How many at the most for each measure.

        Returns
        -------
        dict
            ``local``, ``global``, ``equalized_odds`` and ``demographic_parity``, most unequal first.
        """
        if count < 1:
            raise InputError(f"{count} most unequal pairs cannot be listed; ask for at least 1")
        return {
            **self.most_unequal_pairs(count),
            "equalized_odds": self.passed.distances[:count]
            if self.passed
            else most_unequal_distances(self.law, count, within_context=True),
            "demographic_parity": most_unequal_distances(self.law, count, within_context=False),
        }

    def most_unequal_pairs(self, count: int = 3) -> dict[str, tuple[Ratio, ...]]:
        """Rank the most unequal pairs by ratio alone: ``local`` and ``global`` of `most_unequal`."""
        law, utility = self.law, self.utility
        local = self.passed.pairs[:count] if self.passed else most_unequal_ratios(law, utility, count, within_context=True)
        return {"local": local, "global": most_unequal_ratios(law, utility, count, within_context=False)}

    def to_frame(self) -> pd.DataFrame:
        """Tabulate the cells: labels, weight (count or mass), exact expected utility, and the same as a float.

        Returns
        -------
        pandas.DataFrame
            One row per context and group that has a law.
        """
        import pandas as pd

        law, without = self.law, self.unfiltered_expectations
        records = []
        masses = law.cell_mass
        total = law.scale if law.kind == "counts" else sum(masses)
        for cell, (x, a) in enumerate(zip(law.cell_context.tolist(), law.cell_group.tolist(), strict=True)):
            value = Fraction(*cell_expectation(law, self.utility, cell))
            labels = {**law.context_label(x), **law.group_label(a)}
            weight = Fraction(masses[cell], total) if law.population != "equal" else None
            record = {**labels, "weight": weight, "expectation": value, "expectation_float": float(value)}
            if without:
                before = without[cell]
                record |= {"unfiltered_expectation": before, "unfiltered_expectation_float": float(before)}
            records.append(record)
        return pd.DataFrame.from_records(records)

    @cached_property
    def unfiltered_expectations(self) -> list[Fraction] | None:
        """E(x,a) of each cell without the filters, in the order of the law's cells; None where that is undefined."""
        if self.deployment is None or self.deployment.unfiltered is None:
            return None
        law = self.deployment.unfiltered
        return [Fraction(*cell_expectation(law, replace(self.utility, law=law), cell)) for cell in range(len(law.weights))]

    @cached_property
    def claims(self) -> tuple[Claim, ...]:
        """The statements that the certificate makes."""
        return tuple(_claims(self))

    @cached_property
    def certificate(self) -> Certificate:
        """The certificate, ready to be saved."""
        law, deployment = self.law, self.deployment
        document: dict[str, Any] = {
            "format": FORMAT,
            "subject": {
                "kind": "policy" if deployment else law.kind,
                "columns": column_names(self.columns),
                "population": law.population,
                "table": {},
                "utility": {
                    "gamma": number(self.utility.gamma),
                    "m": number(self.utility.m),
                    "tau": None if self.tau is None else number(self.tau),
                    "lipschitz": number(self.utility.lipschitz()),
                    "depends_on_group": self.utility.depends_on_group,
                    **({"burden": True} if self.burden else {}),
                },
            },
            "metrics": {
                "local": _ratio_entry(self.local),
                "global": _ratio_entry(self.global_),
                "demographic_parity": _distance_entry(self.demographic_parity),
                "equalized_odds": _distance_entry(self.equalized_odds),
                "local_supremum": _ratio_entry(self.local_supremum),
                "global_supremum": _ratio_entry(self.global_supremum),
            },
            "not_compared": [_left_out(entry) for entry in self.not_compared],
            "claims": [
                {
                    "quantity": claim.quantity,
                    "relation": claim.relation,
                    "value": number(claim.value),
                    "scope": claim.scope,
                    "by": claim.by,
                    "assumptions": list(claim.assumptions),
                    "evidence": dict(claim.evidence),
                }
                for claim in self.claims
            ],
            "targets": [
                {
                    "quantity": t.quantity,
                    "limit": number(t.limit),
                    "unit": t.unit,
                    "judged": _judged(t),
                    **({} if t.estimand == "mean over rows" else {"estimand": t.estimand}),
                    "verdict": t.verdict,
                }
                for t in self.targets
            ],
            "verdict": self.verdict,
            "versions": {"fairaudit": __version__},
        }
        if self.preparation:
            document["subject"]["preparation"] = [dict(entry) for entry in self.preparation]
        if self.spellings:
            document["subject"]["spellings"] = list(self.spellings)
        if self.intervals:
            document["intervals"] = {
                quantity: _interval_entry(interval, self.comparisons.get(quantity), law if quantity == "local" else None)
                for quantity, interval in self.intervals.items()
            }
        if self.given_truth is not None:
            _add_given_truth(document, self.given_truth)
        if self.changed is not None:
            document["changed"] = _change_entry(self.changed)
        if deployment is None:
            made = with_table(document, self.passed.table if self.passed else Table(law, self.utility), embed=self.embed)
            if self.given_truth is not None and made.table is None:
                document["metrics"] |= {name: [_rate_entry(law, rate) for rate in rates] for name, rates in self.given_truth.rates.items()}
            return made
        context = deployment.context_filter
        document["subject"]["privacy"] = {"group": _privacy(deployment.group_filter), "context": _privacy(context) if context else None}
        document["subject"]["declared"] = {name: number(value) for name, value in self.declared.items()}
        document["metrics"]["unfiltered"] = (
            None if self.unfiltered is None else dict(zip(("local", "global"), map(_ratio_entry, self.unfiltered), strict=True))
        )
        return with_table(document, Table(deployment.policy.law, self.utility, deployment), embed=self.embed)


@without_bare_limits(MEASURED)
def certify(
    subject: Law | Deployment,
    utility: Utility | Mapping[Any, Any],
    *,
    max_local_ratio: Any = None,
    max_global_ratio: Any = None,
    max_local_log: Any = None,
    max_global_log: Any = None,
    confidence: Any = 0.95,
    interval: Method = "hoeffding-kl",
    independent: bool = False,
    declared: Mapping[str, Any] | None = None,
    embed_table: bool | None = None,
    arrivals: Arrivals | None = None,
    changed: tuple[Quantity, Window] | None = None,
    positive: Any = None,
    burden: bool = False,
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
    confidence : float or None
        Targets on counts are judged for the population from which they were drawn, all of them together at this confidence. None judges
        the table itself. Probabilities carry no sample size: the table itself is judged.
    interval : {"hoeffding-kl", "empirical-bernstein", "intersection"}
        For utilities with more than two values; to be chosen before looking at the draws. Others have exact binomial intervals.
    independent : bool
        Whether the draws of different cells are independent of each other, which narrows intervals and is an assumption of the
        certificate. Decisions on the same profiles with only the group exchanged are not.
    declared : mapping, optional
        Constants that hold whatever the table says: ``gamma`` and ``m``, the greatest and least value of g over everything that could be
        drawn; for a policy behind filters also ``tau``, a floor of every group's expected utility behind the filter, and ``lipschitz``, a
        bound of the difference of g between groups. Bounds for every policy that keeps a floor need a declared ``tau``.
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
    (1.25, 1.8)
    """
    limits = limits_of(
        {
            "max_local_ratio": max_local_ratio,
            "max_global_ratio": max_global_ratio,
            "max_local_log": max_local_log,
            "max_global_log": max_global_log,
        }
    )
    deployment = subject if isinstance(subject, Deployment) else None
    law = subject.law if isinstance(subject, Deployment) else subject
    level = None if confidence is None else confidence_level(confidence)
    utility = utility if isinstance(utility, Utility) else Utility(utility)
    table = utility.on(law)
    if table.law is not law:
        law = table.law
        if deployment is not None:
            deployment = replace(deployment, policy=Policy(utility.over(deployment.policy.law)))
            law = deployment.law
            table = replace(table, law=law)
        subject = deployment or law
    local, overall = local_fairness(law, table), global_fairness(law, table)
    if local is None and overall is None:
        raise InputError("no two groups can be compared: no context has two groups, and no two groups have a population")
    measured: dict[Quantity, Ratio | None] = {"local": local, "global": overall}
    tau = least_expectation(law, table)
    constants = _constants(table, tau, declared or {}, deployment)
    given, said = _given_truth(subject, table, positive, None if arrivals else level, embed_table)
    found = () if deployment is None else tuple(_bounds(deployment, table, tau, constants, law))
    too_wide = deployment is not None and joint_ratios(deployment.group_filter) > PAIR_RATIOS
    named = {quantity for quantity, _, _ in limits}
    comparisons: dict[Quantity, Comparison] = {}
    notes: tuple[str, ...] = ()
    intervals: dict[Quantity, Interval] = {}
    if arrivals is not None and level is not None:
        intervals, notes = _stream_intervals(law, table, arrivals, measured, constants, 1 - (1 - level) / max(1, len(named)), named)
    elif level is not None:
        comparisons, notes = _comparisons(subject, utility, table, measured, constants, named, embed_table)
    for quantity, comparison in comparisons.items():
        # Targets on both quantities share the error, so that their verdicts hold together.
        alpha = (1 - (level or 0)) / max(1, len(named & comparisons.keys()))
        region = default_region(comparison, interval, independent=independent)
        intervals[quantity] = ratio_interval(comparison, 1 - alpha, method=interval, region=region, independent=independent)
        notes = (*notes, *_two_means(quantity, measured[quantity], comparison))
    sampled = level if (deployment.policy.law if deployment else law).kind == "counts" else None
    change = None
    if changed is not None:
        if changed[0] not in intervals or arrivals is None:
            raise InputError("a window contradicts the interval of a stream; there is none without arrivals and a confidence")
        change = change_of(intervals[changed[0]], changed[1], changed[0], (constants["m"], constants["gamma"]))
        intervals = {quantity: own for quantity, own in intervals.items() if quantity not in change.withdrawn}
    targets, verdict = judged(measured, limits, sampled, intervals, found, constants)
    if change is not None:
        targets, verdict = _judged_by_window(targets, verdict, change)
    without = deployment.unfiltered if deployment else None
    return Result(
        law=law,
        utility=table,
        local=local,
        global_=overall,
        demographic_parity=demographic_parity(law),
        equalized_odds=equalized_odds(law),
        local_supremum=local_supremum(law),
        global_supremum=global_supremum(law),
        tau=tau,
        not_compared=(*not_compared(law), *(given.not_compared if given else ())),
        targets=targets,
        verdict=verdict,
        notes=(*law.notes, *notes, *said, *((TOO_WIDE,) if too_wide else ())),
        deployment=deployment,
        unfiltered=None if without is None else _both(without, replace(table, law=without)),
        bounds=found,
        declared=constants,
        intervals=intervals,
        comparisons=comparisons,
        embed=embed_table,
        given_truth=given,
        burden=burden,
        changed=change,
    )


def _judged_by_window(targets: tuple[Target, ...], verdict: Verdict, change: Change) -> tuple[tuple[Target, ...], Verdict]:
    """Of ratios that changed, a target is exceeded if it is in the window; nothing else is said."""

    def judge(target: Target) -> Target:
        if target.quantity not in change.withdrawn:
            return target
        own = target.quantity == change.quantity and interval_verdict(change.part, **{f"max_{target.unit}": target.limit}) == "exceeds"
        return replace(target, verdict="exceeds" if own else "changed", upper=None)

    judged_ = {target.quantity for target in targets} or change.withdrawn
    return tuple(map(judge, targets)), "changed" if judged_ & change.withdrawn else verdict


def spellings_of(law: Law, columns: Columns, contexts: Sequence[Any]) -> tuple[dict[str, Any], ...]:
    """Labels of one column of a law that differ in spelling alone."""
    listed: list[tuple[str, list[str]]] = [(columns.decision, list(law.decisions))]
    for names, labels in ((columns.group, law.groups), (columns.context, contexts)):
        listed += [(name, list(dict.fromkeys(label[i] for label in labels))) for i, name in enumerate(names)]
    if law.truth is not None and columns.truth is not None:
        listed.append((columns.truth, list(law.truth.labels)))
    return spellings(listed)


def change_assumptions(change: Change) -> list[str]:
    """What rests on the reader's judgement where a window is said to contradict the stream."""
    return [*change.stream.assumptions, WINDOWS]


def _change_entry(change: Change) -> dict[str, Any]:
    """The change as a certificate stores it: docs/certificate-monitor.md."""
    window = Table(change.window.law, change.window.utility)
    if window.cells > EMBED_LIMIT:
        raise InputError(f"the window has a table of {window.cells} entries; a certificate about a change holds at most {EMBED_LIMIT}")
    return {
        "quantity": change.quantity,
        "window": change.window.number,
        "confidence": number(change.confidence),
        "stream": _interval_entry(change.stream, None, None),
        "table": {"sha256": window.sha256, "cells": window.cells, "header": window.header, "rows": list(window.rows())},
        "ratio": _interval_entry(change.part, None, None),
        "assumptions": change_assumptions(change),
    }


def _given_truth(
    subject: Law | Deployment, table: UtilityTable, positive: Any, confidence: Fraction | None, embed: bool | None
) -> tuple[GivenTruth | None, tuple[str, ...]]:
    """What the decisions are given the true label, with intervals as far as they are possible, and why they are not."""
    if isinstance(subject, Deployment):
        if subject.policy.law.truth is not None or positive is not None:
            raise InputError("true labels go with counts and logs, not with a policy behind filters")
        return None, ()
    found = given_truth(subject, table, positive)
    if found is None or confidence is None:
        return found, ()
    reason = ""
    if subject.units is not None:
        reason = "rows of one sampling unit are no independent draws given their true labels"
    elif not subject.whole:
        reason = "the counts are not whole numbers of draws"
    elif embed is False:
        reason = "the ends of intervals would disclose the counts of a certificate without its table"
    if reason:
        return found, (f"no interval for the rates given the true label is claimed: {reason}",)
    return replace(found, intervals=found.intervals_at(confidence)), ()


def judged(
    measured: Mapping[Quantity, Ratio | None],
    limits: Sequence[Limit],
    confidence: Fraction | None,
    intervals: Mapping[Quantity, Interval],
    found: tuple[Bound, ...] = (),
    declared: Mapping[str, Fraction] | None = None,
) -> tuple[tuple[Target, ...], Verdict]:
    """Judge limits: of the table itself exactly, or, at a confidence, of the population by its intervals and bounds."""
    targets = tuple(
        Target(quantity, limit, unit, _judge(measured[quantity], limit, unit))
        if confidence is None
        else _judge_population(quantity, limit, unit, confidence, intervals.get(quantity), found, declared or {})
        for quantity, unit, limit in limits
    )
    return targets, max((target.verdict for target in targets), key=RANK.__getitem__, default="none")


def measure_entry(measured: Ratio | Distance) -> dict[str, Any]:
    """Write a measure as a certificate stores it."""
    entry = _ratio_entry(measured) if isinstance(measured, Ratio) else _distance_entry(measured)
    return entry or {}


def _exactly(value: Fraction | float) -> str:
    """The rational, where it is short enough to be read."""
    if not isinstance(value, Fraction) or max(value.numerator, value.denominator).bit_length() > 200:
        return ""
    return str(value)


def _judge(measured: Ratio | None, limit: Fraction, unit: str) -> Verdict:
    if measured is None:
        return "inconclusive"
    if unit == "ratio":
        return "within" if measured.ratio <= limit else "exceeds"
    return "within" if compare_log(measured.pair, (limit.numerator, limit.denominator)) <= 0 else "exceeds"


def _judge_population(
    quantity: Quantity,
    limit: Fraction,
    unit: Unit,
    confidence: Fraction,
    interval: Interval | None,
    found: tuple[Bound, ...],
    declared: Mapping[str, Fraction],
) -> Target:
    """Judge a target for whatever law or policy was sampled: by its interval, and by theorems that rest on declared constants only."""
    ends: list[tuple[Fraction | float, str]] = []
    if interval is not None:
        ends.append((interval.upper, THE_INTERVAL))
    ends += [
        (bound.value, bound.theorem)
        for bound in found
        if bound.certified and bound.quantity == f"{quantity}_ratio" and for_any_sampled(bound.theorem, bound.scope, declared)
    ]
    upper = min(ends, key=lambda end: end[0], default=None)
    lower = interval.lower if interval is not None else Fraction(1)
    verdict = interval_verdict((lower, max(lower, upper[0] if upper else inf)), **{f"max_{unit}": limit})
    return Target(quantity, limit, unit, verdict, confidence, upper, interval.estimand if interval is not None else "mean over rows")


def for_any_sampled(theorem: str, scope: str, declared: Mapping[str, Any]) -> bool:
    """Whether a bound holds for whatever policy was sampled, and rests on declared constants only."""
    needs: tuple[str, ...] | None = {"T2": (), "T5": (), "T5-decision": (), "T4": ("gamma", "m")}.get(theorem)
    if scope == bounds.FLOORED:
        needs = ("gamma",)
    elif scope != bounds.ANY_POLICY:
        needs = None
    return needs is not None and all(name in declared for name in needs)


def headline_pair(deciding: Deciding | None, local: Ratio | None, global_: Ratio | None) -> Witness | None:
    """The pair of groups that the sentence of a result is about."""
    if deciding is not None and deciding.pair is not None:
        return deciding.pair
    if deciding is not None:
        measured = local if deciding.quantity == "local" else global_
    else:
        measured = global_ if local is None or (local.ratio == 1 and global_ is not None and global_.ratio > 1) else local
    return None if measured is None else measured.witness


def pair_key(witness: Witness) -> tuple[str, ...]:
    """The labels of a pair, as a key."""
    return (*(witness.context or {}).values(), *witness.higher.values(), *witness.lower.values())


def _stream_intervals(
    law: Law,
    table: UtilityTable,
    arrivals: Arrivals,
    measured: Mapping[Quantity, Ratio | None],
    declared: Mapping[str, Fraction],
    confidence: Fraction,
    named: set[Quantity],
) -> tuple[dict[Quantity, Interval], tuple[str, ...]]:
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


def _comparisons(
    subject: Law | Deployment,
    utility: Utility,
    table: UtilityTable,
    measured: Mapping[Quantity, Ratio | None],
    declared: Mapping[str, Fraction],
    named: set[Quantity],
    embed: bool | None,
) -> tuple[dict[Quantity, Comparison], tuple[str, ...]]:
    """What the draws behind counts say of the population, as far as an interval is possible, and why it is not."""
    law = subject.policy.law if isinstance(subject, Deployment) else subject
    if law.kind != "counts":
        return {}, ()
    limits = (declared.get("m", Fraction(0)), declared.get("gamma", table.gamma)) if {"gamma", "m"} & declared.keys() else None
    made: dict[Quantity, Comparison] = {}
    notes: list[str] = []
    wanted: list[Quantity] = [quantity for quantity, ratio in measured.items() if ratio is not None]
    for quantity in wanted:
        try:
            if utility.observed and "gamma" not in declared:
                raise InputError(
                    "the utility was read from a column, and the greatest value seen there does not bound what could have been drawn; "
                    "declare its range (gamma and m, or --utility-range LOW,HIGH)"
                )
            if embed is False:
                raise InputError("the ends of intervals would disclose the counts of a certificate without its table")
            made[quantity] = _comparison(subject, utility, table, quantity, limits)
            notes += made[quantity].notes
        except InputError as error:
            if quantity in named:
                raise InputError(f"{error}; confidence none (--confidence none) judges the table itself") from None
            notes.append(f"no interval for the {quantity} ratio is claimed: {error}")
    if len(wanted) == 2 and not made:
        notes = [f"no interval is claimed:{notes[0].partition(':')[2]}"]
    return made, tuple(notes)


def _comparison(
    subject: Law | Deployment, utility: Utility, table: UtilityTable, quantity: Quantity, limits: tuple[Fraction, Fraction] | None
) -> Comparison:
    if isinstance(subject, Law):
        compare = local_comparison if quantity == "local" else global_comparison
        return replace(compare(subject, table, limits=limits), limits=limits)
    places = [(x, a) for x in subject.contexts for a in subject.groups]
    population = None if subject.mass is None else dict(zip(places, subject.mass, strict=True))
    context = subject.context_filter
    found = policy_comparison(
        subject.policy, _tabulated(utility, table), subject.group_filter, context, population, local=quantity == "local", limits=limits
    )
    return replace(found, assumptions=(bounds.FRESH, *found.assumptions), limits=limits)


def _two_means(quantity: Quantity, over_rows: Ratio | None, comparison: Comparison) -> tuple[str, ...]:
    """A note, where the mean over units is not the mean over rows."""
    over_units = comparison.of_units
    if over_units is None or over_rows is None or over_units.ratio == over_rows.ratio:
        return ()
    rows, units = approximate(over_rows.ratio), approximate(over_units.ratio)
    said = f"the {quantity} ratio of this log is {rows} as the mean over rows and {units} as the mean over units"
    return (f"{said}; the interval, and a target that is judged by it, is about the mean over units",)


def _tabulated(utility: Utility, table: UtilityTable) -> Utility:
    """The utility without entries for contexts and groups that are not there."""
    if utility.entries is None:
        return utility
    contexts, groups = set(table.law.contexts), set(table.law.groups)
    return replace(utility, entries={key: pair for key, pair in utility.entries.items() if key[1] in contexts and key[2] in groups})


def _constants(
    table: UtilityTable, tau: Fraction | None, declared: Mapping[str, Any], deployment: Deployment | None
) -> dict[str, Fraction]:
    """Declared constants as exact rationals, none of which contradicts the table."""
    measured = {"gamma": table.gamma, "m": table.m, "tau": tau, "lipschitz": table.lipschitz()}
    if deployment is None and declared.keys() & {"tau", "lipschitz"}:
        raise InputError("tau and lipschitz are declared for a policy behind filters; a plain table has its own")
    constants: dict[str, Fraction] = {}
    for name, value in declared.items():
        if name not in measured:
            raise InputError(f"{shown(name)} cannot be declared; {nearest(name, measured)}")
        try:
            constants[name] = Fraction(*option_value(value))
        except InputError as error:
            raise InputError(f"the declared {name}: {error}") from None
        found = measured[name]
        if constants[name] < 0:
            raise InputError(f"the declared {name} is {shown(value)}; it must be at least 0")
        if found is None:
            continue
        if name in ("gamma", "lipschitz") and constants[name] < found:
            raise InputError(f"the declared {name} is {shown(value)}, but the table has {approximate(found)}; declare at least that")
        if name in ("m", "tau") and constants[name] > found:
            raise InputError(f"the declared {name} is {shown(value)}, but the table has only {approximate(found)}; declare at most that")
    return constants


def _bounds(
    deployment: Deployment, table: UtilityTable, tau: Fraction | None, declared: Mapping[str, Fraction], law: Law
) -> Iterator[Bound]:
    """What theorems guarantee about a deployment, as far as it is finite: see docs/certificate-policy.md."""
    group = deployment.group_filter
    gamma, m = declared.get("gamma", table.gamma), declared.get("m", table.m)
    gap = declared.get("lipschitz", table.lipschitz())
    factor, narrow = exp_epsilon(group), joint_ratios(group) <= PAIR_RATIOS
    if gap == 0:
        if factor < inf:
            yield bounds.t2(factor)
        raw = local_fairness(deployment.shown_law, _by_context(table, deployment.shown_law))
        own: Fraction | float = raw.ratio if raw else Fraction(1)
        if min(factor, own) < inf:
            yield bounds.t12(factor, own)
        if m > 0 and narrow:
            yield bounds.t4(group, gamma, m)
        least = _policy_floor(deployment, table)
        if factor < inf and least > 0:
            yield bounds.t3_approx(factor, 0, least / gamma, floor="policy")
    floors: list[tuple[Literal["table", "declared"], Fraction | None]] = [("table", tau), ("declared", declared.get("tau"))]
    for floor, low in floors:
        if low is None or low == 0:
            continue
        cap = bounds.floor_cap(gamma, low, floor=floor)
        cap = replace(cap, theorem="floor", multipliers=(), assumptions=(bounds.FRESH, *cap.assumptions))
        yield cap
        found = [bounds.t1(group, gamma, low, gap, floor=floor)] if narrow else []
        if factor < inf:
            found.append(replace(bounds.t1_paper(factor, 0, gamma, low, gap, floor=floor), theorem="T1-paper", multipliers=()))
        if low <= gamma - gap and narrow:
            found.append(bounds.t3_general(group, gamma, low, gap, floor=floor))
        yield from (bound for bound in found if bound.value < cap.value)
    yield from _global_bounds(deployment, table, gap, factor, law)


def _global_bounds(deployment: Deployment, table: UtilityTable, gap: Fraction, factor: Fraction | float, law: Law) -> Iterator[Bound]:
    if law.global_groups and factor < inf:
        if gap == 0 and law.independent:
            bound = bounds.t5_independent(bounds.t2(factor))
            yield replace(bound, multipliers=(), assumptions=(*bound.assumptions, bounds.POPULATION))
        spread = _composition(deployment, law)
        if table.by_decision and spread < inf:
            bound = bounds.t5_decision(factor, table, released_ratio=spread)
            yield replace(bound, theorem="T5-decision", constants={"composition": Fraction(spread)}, multipliers=())
    released = deployment.filtered_contexts_law
    if released is not None and table.by_decision:
        before = local_fairness(released, replace(table, law=released))
        if before is not None and before.ratio < inf:
            yield Bound("T8", "local_ratio", before.ratio, {}, (), (bounds.FRESH, bounds.DECISION_ONLY), ANY_CONTEXT_FILTER)


def _both(law: Law, table: UtilityTable) -> tuple[Ratio | None, Ratio | None]:
    return local_fairness(law, table), global_fairness(law, table)


def _by_context(table: UtilityTable, law: Law) -> UtilityTable:
    """Lay a utility that does not depend on the group out over other groups in the same contexts."""
    if table.by_decision:
        return replace(table, law=law)
    first = table.law.starts[:-1]
    return replace(table, law=law, values=np.repeat(table.values[first], np.diff(law.starts), axis=0))


def _policy_floor(deployment: Deployment, table: UtilityTable) -> Fraction:
    """Least Σ_u T(u|x̃,ã)·g(u,x,a) over what the policy can be shown: a floor for every filter that releases the same values."""
    law = deployment.policy.law
    least: Fraction | None = None
    utilities = {
        x: {tuple(table.row(cell)) for cell in range(start, end)} for x, (start, end) in enumerate(pairwise(table.law.starts.tolist()))
    }
    for x, cell in deployment.shown_cells:
        row = law.row(cell)
        for values in utilities[x]:
            value = Fraction(sum(w * g for w, g in zip(row, values, strict=True)), sum(row) * table.scale)
            least = value if least is None or value < least else least
    return least if least is not None else Fraction(0)


def _composition(deployment: Deployment, law: Law) -> Fraction | float:
    """Greatest P(x̃|a)/P(x̃|a') over released contexts and ordered pairs of groups of positive mass."""
    mass = np.array(law.cell_mass, dtype=object).reshape(len(law.contexts), len(law.groups))[:, list(law.global_groups)]
    context = deployment.context_filter
    shown_mass = mass if context is None else np.array([context.row(x) for x in law.contexts], dtype=object).T @ mass
    totals = mass.sum(axis=0)
    worst: Fraction | float = Fraction(1)
    for row in shown_mass:
        shares = [Fraction(v, t) for v, t in zip(row.tolist(), totals.tolist(), strict=True)]
        top, low = max(shares), min(shares)
        if top > 0:
            worst = max(worst, top / low if low else inf)
    return worst


def not_compared(law: Law) -> list[dict[str, Any]]:
    present: list[list[int]] = [[] for _ in law.contexts]
    for x, a in zip(law.cell_context.tolist(), law.cell_group.tolist(), strict=True):
        present[x].append(a)
    left_out: list[dict[str, Any]] = []
    for x, groups in enumerate(present):
        if len(groups) < len(law.groups):
            absent = sorted(set(range(len(law.groups))) - set(groups))
            left_out.append(
                {"context": law.context_label(x), "groups": [law.group_label(a) for a in absent], "reason": "no decisions recorded"}
            )
    left_out += [
        {"context": law.context_label(x), "reason": "fewer than two groups"} for x, groups in enumerate(present) if len(groups) < 2
    ]
    positive = {a for a, m in zip(law.cell_group.tolist(), law.cell_mass, strict=True) if m > 0}
    weightless = sorted(set(law.cell_group.tolist()) - positive)
    if weightless:
        left_out.append({"groups": [law.group_label(a) for a in weightless], "reason": "no population"})
    if not law.global_groups:
        incomplete = law.population == "equal" and not law.complete
        reason = "a group is missing in a context and no population was given" if incomplete else "fewer than two groups"
        left_out.append({"quantity": "global", "reason": reason})
    return left_out


def _left_out(entry: Mapping[str, Any]) -> dict[str, Any]:
    """An entry of `not_compared` as a certificate stores it: labels as lists."""
    stored = dict(entry)
    if "context" in entry:
        stored["context"] = list(entry["context"].values())
    if "groups" in entry:
        stored["groups"] = [list(group.values()) for group in entry["groups"]]
    return stored


def _privacy(mechanism: Mechanism) -> dict[str, Any]:
    """Privacy of a filter as a certificate stores it."""
    return {
        "exp_epsilon": number(exp_epsilon(mechanism)),
        "attributes": [number(exp_epsilon(Mechanism((factor,)))) for factor in mechanism.factors],
    }


def _claims(result: Result) -> list[Claim]:
    law = result.law
    assumptions = (*((bounds.FRESH,) if result.deployment else ()), *law.assumptions)
    claims: list[Claim] = []

    def add(
        quantity: str, value: Fraction | float, by: str, *, relation: Literal["=", "<="] = "=", evidence: Mapping[str, str] | None = None
    ) -> None:
        # The digest is filled in when the table is put into the certificate.
        claims.append(Claim(quantity, relation, value, by, evidence or {"table": ""}, assumptions=assumptions))

    if result.local:
        add("local_ratio", result.local.ratio, "enumeration")
    if result.global_:
        add("global_ratio", result.global_.ratio, "enumeration")
    if result.demographic_parity:
        add("demographic_parity", result.demographic_parity.value, "enumeration")
    if result.equalized_odds:
        add("equalized_odds", result.equalized_odds.value, "enumeration")
    for quantity, distance, supremum in (
        ("local_ratio_supremum", "equalized_odds", result.local_supremum),
        ("global_ratio_supremum", "demographic_parity", result.global_supremum),
    ):
        if supremum:
            r = supremum.ratio
            add(quantity, r, "T6")
            bound = Fraction(r - 1, r + 1) if isinstance(r, Fraction) else Fraction(1)
            add(distance, bound, "T7", relation="<=", evidence={"supremum": number(r)})
    if result.local and result.global_ and not result.passed and law.independent:
        add("global_ratio", result.local.ratio, "T5", relation="<=")
    if result.given_truth is not None:
        claims += _claims_given_truth(result.given_truth, assumptions)
    for quantity, interval in result.intervals.items():
        by = next((method for method in interval.methods if method != "binomial"), "binomial")
        scope = f"population at confidence {number(interval.confidence)}"
        evidence = {"interval": quantity}
        claims.append(Claim(f"{quantity}_ratio", ">=", interval.lower, by, evidence, scope, interval.assumptions))
        claims.append(Claim(f"{quantity}_ratio", "<=", interval.upper, by, evidence, scope, interval.assumptions))
    return claims + [_bound_claim(bound, law.assumptions) for bound in result.bounds if bound.certified]


def _claims_given_truth(given: GivenTruth, assumptions: tuple[str, ...]) -> Iterator[Claim]:
    for name, found in given.differences.items():
        if found is not None:
            yield Claim(name, "=", found.value, "enumeration", {"table": ""}, assumptions=assumptions)
    for name, interval in given.intervals.items():
        scope = f"population at confidence {number(interval.confidence)}"
        yield Claim(name, ">=", interval.lower, "binomial", {"interval": name}, scope, interval.assumptions)
        yield Claim(name, "<=", interval.upper, "binomial", {"interval": name}, scope, interval.assumptions)


def _add_given_truth(document: dict[str, Any], given: GivenTruth) -> None:
    """Put what is measured given the true label into a certificate: docs/certificate.md."""
    document["subject"]["positive"] = {"decision": list(given.positive.decision), "truth": given.positive.truth}
    document["metrics"] |= dict.fromkeys(given.rates)  # filled in where the table is in the certificate
    document["metrics"] |= {name: _difference_entry(found) for name, found in given.differences.items()}
    if given.intervals:
        document.setdefault("intervals", {}).update({name: interval.evidence for name, interval in given.intervals.items()})


def _rate_entry(law: Law, rate: Rate) -> dict[str, Any]:
    where = {} if rate.context is None else {"context": law.context_label(rate.context)}
    return {**where, "group": law.group_label(rate.group), "rate": number(rate.value)}


def _difference_entry(measured: Difference | None) -> dict[str, Any] | None:
    if measured is None:
        return None
    entry: dict[str, Any] = {} if measured.context is None else {"context": measured.context}
    entry |= {"rate": measured.kind, "higher": measured.higher, "lower": measured.lower, "rates": [number(v) for v in measured.rates]}
    return {"value": number(measured.value), "witness": entry}


def _interval_entry(interval: Interval, comparison: Comparison | None, law: Law | None) -> dict[str, Any]:
    """An interval as a certificate stores it: docs/certificate-samples.md."""
    entry = {key: value for key, value in interval.evidence.items() if key not in ("cells", "blocks")}
    if comparison is not None:
        entry["limits"] = None if comparison.limits is None else [number(limit) for limit in comparison.limits]
    entry["ratio"] = [number(interval.lower), number(interval.upper)]
    if law is not None and law.units is not None and interval.of_units is not None:
        entry |= {"estimand": interval.estimand, "measured": _ratio_entry(interval.of_units)}
        compared = np.flatnonzero(law.compared).tolist()
        entry["units"] = [[[n, list(rows)] for n, rows in law.units.profiles[cell]] for cell in compared]
    return entry


def _judged(target: Target) -> str:
    return "this table" if target.confidence is None else f"population at confidence {number(target.confidence)}"


def _bound_claim(bound: Bound, assumptions: tuple[str, ...]) -> Claim:
    evidence: dict[str, Any] = {}
    if bound.theorem == "T12":
        evidence["raw_ratio"] = number(bound.constants.get("raw_ratio", inf))
    if bound.theorem == "T5-decision":
        evidence["composition"] = number(bound.constants["composition"])
    if bound.theorem in ("T1", "T3", "T4"):
        evidence["multipliers"] = [number(k) for k in bound.multipliers]
    return Claim(bound.quantity, "<=", bound.value, bound.theorem, evidence, bound.scope, (*to_judge(bound), *assumptions))


def to_judge(bound: Bound) -> tuple[str, ...]:
    """Those assumptions of a bound that no table confirms; the others are checked when the bound is made, and by the checker."""
    return tuple(text for text in bound.assumptions if not text.startswith(CONFIRMED))


def _ratio_entry(measured: Ratio | None) -> dict[str, Any] | None:
    if measured is None:
        return None
    witness = measured.witness
    entry: dict[str, Any] = {}
    if witness.context is not None:
        entry["context"] = witness.context
    if witness.decision is not None:
        entry["decision"] = witness.decision
    entry |= {"higher": witness.higher, "lower": witness.lower}
    entry["expectations" if witness.decision is None else "probabilities"] = [number(v) for v in witness.expectations]
    lo, hi = measured.log
    return {"ratio": number(measured.ratio), "log": [_log_text(lo), _log_text(hi)], "witness": entry}


def _log_text(value: Decimal) -> str:
    return "inf" if value.is_infinite() else format(value, "f")


def _distance_entry(measured: Distance | None) -> dict[str, Any] | None:
    if measured is None:
        return None
    witness = measured.witness
    entry: dict[str, Any] = {} if witness.context is None else {"context": witness.context}
    entry |= {"higher": witness.higher, "lower": witness.lower, "decisions": list(witness.decisions)}
    return {"value": rational_text((measured.value.numerator, measured.value.denominator)), "witness": entry}
