"""What `certify` found: exact measures with witnesses, intervals, claims, verdict and certificate."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from fractions import Fraction
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np

from fairaudit.arguments import answered
from fairaudit.audits.claims import Claim, claims_of
from fairaudit.audits.differences import decide_difference, difference_pair, difference_sentence
from fairaudit.audits.drift import DriftedRatio, TableRadius, drifted_of, measures_drift, radius_of
from fairaudit.audits.faces import Faces
from fairaudit.audits.hidden_context import Explanation, Remaining, explanations, remaining_ratios
from fairaudit.audits.sentences import (
    Deciding,
    Drivers,
    Size,
    Sizes,
    caution,
    change_text,
    decide,
    evaluation_of,
    few_of_policy,
    foremost,
    headline_pair,
    identifier_text,
    lost_text,
    sentence,
    sizes,
)
from fairaudit.audits.targets import Target
from fairaudit.audits.undecided import Undecided, Whatever, whatever_text
from fairaudit.errors import InputError
from fairaudit.inference.comparisons import Comparison, draws_of
from fairaudit.inference.ends import Method
from fairaudit.inference.interval import Interval
from fairaudit.inference.ratio_intervals import default_region, ratio_interval
from fairaudit.inference.ratio_intervals import drivers as interval_drivers
from fairaudit.inference.verdicts import Verdict, exit_code
from fairaudit.measures.distances import PARITY_WITHIN, Distance, most_unequal_distances
from fairaudit.measures.expectations import cell_expectation
from fairaudit.measures.limits import Quantity
from fairaudit.measures.ratios import Ratio, Witness, most_unequal_ratios
from fairaudit.model.law import Law
from fairaudit.model.layout import Columns
from fairaudit.model.utility import UtilityTable
from fairaudit.tables.labels import spellings
from fairaudit.tables.preparation import Entry
from fairaudit.tables.values import Label
from fairaudit.theorems.bound import Bound
from fairaudit.theorems.t14 import HiddenContext
from fairaudit.words import DRIFTING, brief, place, words_for

if TYPE_CHECKING:
    import pandas as pd

    from fairaudit.audits.origin import Origin
    from fairaudit.audits.unknown import Share, Whoever
    from fairaudit.certificates.certificate import Certificate
    from fairaudit.certificates.table import WrittenTable
    from fairaudit.inference.bounded_differences import Differences
    from fairaudit.inference.changes import Change
    from fairaudit.inference.planning import Planning
    from fairaudit.inference.rates import GivenTruth
    from fairaudit.model.policy import Deployment
    from fairaudit.theorems.supremum import Supremum
    from fairaudit.theorems.t13_near import DriftRadius
    from fairaudit.theorems.t16 import Moving

__all__ = ["Result"]


FEW_PAIRS = 60
"""Pairs of cells for which it is found in passing what a declaration of independence would give."""

FEW_STEPS = 5_000_000
"""Steps of a reader of contrasts, for the same."""


@brief
@dataclass(frozen=True, eq=False, repr=False)
class Partial:
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


@brief
@dataclass(frozen=True, eq=False, repr=False)
class Result(Faces):
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
    verdict : {"none", "within", "exceeds", "inconclusive", "depends", "changed"}
        "changed" before "exceeds" before "inconclusive" before "within"; "none" without targets.
    notes : tuple of str
        What was noticed while reading.
    warnings : tuple of str
        What to know of how the table was read before any figure is believed, such as labels that look undecided; not in the certificate.
    deployment : Deployment or None
        The policy and its filters, if that is what was audited; `law` is then the law that they induce.
    unfiltered : tuple of (Ratio or None) or None
        Local and global g-fairness without the filters, where the policy knows every true context and group.
    bounds : tuple of Bound
        What theorems guarantee about the deployment, each with its scope and assumptions.
    suprema : tuple of Supremum
        The greatest ratio that any policy of a scope attains behind the filters (T13), each with its scope and assumptions.
    declared : dict of str to Fraction
        Constants that were declared instead of read off the table.
    declared_in : dict of label to dict of str to Fraction
        Those that were declared for one context: greatest and least utility, and floor.
    intervals : dict
        Intervals of the ratios of the population behind counts, under ``"local"`` and ``"global"`` where there is one. Of a ratio with a
        target each end holds by itself at the confidence, of others both together; `two_sided` has the latter of the former.
    partial : Partial or None
        If contexts were read in parts, what was kept of them; `law` is then the law over all contexts together.
    given_truth : GivenTruth or None
        Rates of true and false positives, equal opportunity and equalized odds given the true label, where it is known.
    burden : bool
        Whether the utility counts a burden, so that the group with the higher expectation is disadvantaged.
    changed : Change or None
        A window that contradicts the stream, so that nothing is said of one constant ratio.
    method : {"hoeffding-kl", "empirical-bernstein", "intersection"} or None
        The interval that was asked for, if one was.
    differences : Differences or None
        Differences of expected utilities, with their intervals, where they were asked for.
    whoever : tuple of Whoever
        Where decisions have no recorded group: between which ends each ratio lies, whoever they are.
    unknown_shares : tuple of Share
        Between which shares of them are of a group, as declared.
    hidden_context : HiddenContext or None
        The unrecorded factor that was declared, with which targets are judged; `remaining` is what it leaves of the ratios.
    undecided : Undecided or None
        Which decisions have no known meaning, and between which values each of them may be worth something.
    whatever : tuple of Whatever
        Between which ends each ratio lies then; targets are judged by these, and by intervals that hold whatever they meant.
    origin : Origin or None
        Of what `fairaudit.audit` read: which files, as they were before, and how.

    Examples
    --------
    >>> import fairaudit as fa
    >>> table = {"hired": ["yes", "no", "yes", "no"], "sex": ["f", "f", "m", "m"], "n": [30, 10, 20, 20]}
    >>> result = fa.audit(table, decision="hired", group="sex", count="n", utility="yes", max_local_ratio="5/4")
    >>> result.local.ratio, result.global_.ratio, result.verdict
    (Fraction(3, 2), Fraction(3, 2), 'inconclusive')
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
    suprema: tuple[Supremum, ...] = ()
    declared: Mapping[str, Fraction] = field(default_factory=dict)
    declared_in: Mapping[Label, Mapping[str, Fraction]] = field(default_factory=dict)
    intervals: Mapping[Quantity, Interval] = field(default_factory=dict)
    comparisons: Mapping[Quantity, Comparison] = field(default_factory=dict, repr=False)
    embed: bool | None = field(default=None, repr=False)
    partial: Partial | None = field(default=None, repr=False)
    given_truth: GivenTruth | None = field(default=None, repr=False)
    burden: bool = False
    changed: Change | None = None
    method: Method | None = field(default=None, repr=False)
    differences: Differences | None = None
    whoever: tuple[Whoever, ...] = ()
    unknown_shares: tuple[Share, ...] = ()
    hidden_context: HiddenContext | None = None
    undecided: Undecided | None = None
    whatever: tuple[Whatever, ...] = ()
    origin: Origin | None = field(default=None, repr=False)
    warnings: tuple[str, ...] = ()

    @property
    def exit_code(self) -> int:
        """0 within or no target, 1 a target is exceeded, 3 inconclusive, or changed without an exceeded target."""
        return exit_code(self.verdict, [target.verdict for target in self.targets])

    @cached_property
    def sentence(self) -> str:
        """Who is favoured over whom, where, and by what factor: of the pair of groups that decided the verdict.

        Without targets it is the most unequal pair, within a context if there is one. What makes little of it, such as a handful of
        decisions behind it, or answers of an evaluation log that decide nothing, is said first; between which ends the ratios lie, whatever
        undecided decisions meant, last. Labels are as in the input, unescaped.
        """
        deciding = foremost([target.verdict for target in self.targets], self.deciding)
        mean = "as mean over units" if deciding and self._by_unit(deciding) else "in the table"
        contexts = bool(self.columns.context)
        options: dict[str, Any] = {"sizes_of": self.sizes_of, "contexts": contexts, "mean": mean}
        words = words_for(burden=self.burden)
        if self.differences is not None and (self.utility.signed or (deciding is not None and deciding.unit == "difference")):
            measured = self.differences.measured
            said = difference_sentence(deciding, measured, words, name=place, **options)
            headline = difference_pair(deciding, measured)
        else:
            said = sentence(deciding, self.local, self.global_, words, **options)
            headline = headline_pair(deciding, self.local, self.global_)
        identifiers = identifier_text(self.law, self.columns, None if self.partial is None else self.partial.table.header["contexts"])
        first = caution(headline, None if headline is None else self.sizes_of(headline), identifiers)
        changed = ""
        if self.changed is not None:
            found = self.changed
            ends = (found.stream.lower, found.stream.upper), (found.part.lower, found.part.upper)
            changed = change_text(found.quantity, found.window.number, *ends, found.confidence)
        meant = whatever_text(self.whatever, contexts=contexts)
        listed = (changed, lost_text(evaluation_of(self)), first, few_of_policy(self.deployment, headline), said, meant)
        return " ".join(text for text in listed if text)

    @property
    def columns(self) -> Columns:
        """Names of the decision, group and context columns."""
        return self.partial.columns if self.partial else self.law.columns

    @cached_property
    def deciding(self) -> tuple[Deciding | None, ...]:
        """For each target the pair of groups that decided it, or what else did; None where nothing could be compared."""
        found: list[Deciding | None] = []
        for target in self.targets:
            if target.under == DRIFTING:
                found.append(None)
                continue
            if target.unit == "difference" and self.differences is not None:
                apart, own = self.differences.measured[target.quantity], self.differences.intervals.get(target.quantity)
                ends = None if own is None else (own.lower, own.upper)
                found.append(decide_difference(target, apart, ends, self.differences.drivers.get(target.quantity, (None, None))))
                continue
            interval = self.intervals.get(target.quantity)
            measured = self.local if target.quantity == "local" else self.global_
            lower = None if interval is None else interval.lower
            found.append(decide(target, measured, lower, self.drivers.get(target.quantity, (None, None))))
        return tuple(found)

    @cached_property
    def drift_radii(self) -> tuple[DriftRadius | TableRadius | None, ...]:
        """For each target how far things may move while the verdict on it stands.

        Of a table every cell, each on its own, in total variation and by a factor (T16); of a population where its interval proves ends of
        single cells, in total variation. Of a policy behind filters the policy, in total variation (T13). None for targets on differences,
        those that are inconclusive or judged within a drift, where a utility is not given, and for a policy if the target is about a
        population, one memory sees several releases, or a claim about the policies near this one would take a reader too long.
        """
        return tuple(map(self._drift_radius, self.targets))

    def drift_is_not_given(self, target: Target) -> bool:
        """Whether a verdict on the population of a table rests on an interval that says nothing of single cells."""
        decided = target.verdict in ("within", "exceeds") and not target.under and target.unit != "difference"
        return decided and self.deployment is None and self.partial is None and target.quantity in self.intervals and self.changed is None

    @cached_property
    def moving(self) -> Mapping[Quantity, Moving]:
        """What is compared in the table, as it can drift."""
        return measures_drift(self)

    @cached_property
    def drifted(self) -> tuple[DriftedRatio, ...]:
        """The worst and the best ratio within the declared drift of a table, of the table and, where ends of cells hold, the population."""
        drift = self.declared.get("max_drift")
        return () if drift is None or self.deployment is not None else tuple(drifted_of(self, drift, self.moving))

    def _drift_radius(self, target: Target) -> DriftRadius | TableRadius | None:
        from fairaudit.theorems.t13_cases import NEAR_STEPS
        from fairaudit.theorems.t13_near import drift_radius, near_steps

        at, table = self.deployment, self.utility
        if target.unit == "difference":
            return None
        if at is None:
            return radius_of(self, target, self.moving)
        if at.releases > 1 or target.confidence is not None or near_steps(at, table, target.quantity) > NEAR_STEPS:
            return None
        return drift_radius(at, table, target.quantity, target.limit, target.unit)

    @cached_property
    def explanations(self) -> tuple[Explanation, ...]:
        """How strong an unrecorded factor would have to be to explain each ratio above 1 away, and each lower end (T14)."""
        return tuple(explanations(self))

    @cached_property
    def remaining(self) -> tuple[Remaining, ...]:
        """What the declared hidden context leaves of each ratio, and of each lower end (T14); empty where none was declared."""
        return tuple(remaining_ratios(self))

    @cached_property
    def drivers(self) -> Mapping[Quantity, Drivers]:
        """For each interval the pairs of groups that drive its lower and its upper end."""
        return {
            quantity: interval_drivers(self.comparisons[quantity], interval.evidence, interval.upper, interval.lower)
            if quantity in self.comparisons
            else interval.pairs
            for quantity, interval in self.intervals.items()
        }

    def sizes_of(self, witness: Witness) -> Sizes | None:
        """How many decisions, and sampling units, were recorded of the two groups of a pair; None where probabilities were given."""
        if self.partial is not None and witness.context is not None:
            return self.partial.sizes.get(pair_key(witness)) or self._drawn_of(witness)
        return sizes(self.law, [witness])[0]

    def _drawn_of(self, witness: Witness) -> Sizes | None:
        """Of a pair that was not kept while parts were read: as many as its interval knows."""
        found = draws_of(self.comparisons["local"], witness) if "local" in self.comparisons else None
        return None if found is None else (Size(Fraction(found[0])), Size(Fraction(found[1])))

    def _by_unit(self, deciding: Deciding) -> bool:
        return bool(deciding.quantity == "local" and self.law.units and self.law.units.repeated)

    @property
    def distances(self) -> dict[str, Distance | None]:
        """Total variation distances by what they are called; without context columns there is nothing within a context."""
        columns = self.partial.columns if self.partial else self.law.columns
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
        columns = self.partial.columns if self.partial else law.columns
        contexts = self.partial.table.header["contexts"] if self.partial else law.contexts
        return spellings_of(law, columns, contexts)

    @cached_property
    def if_independent(self) -> Mapping[Quantity, tuple[Fraction, Fraction | float]]:
        """For targets that the draws do not decide: the ends that would hold if the cells had been declared independent.

        They are no statement about the population: whether cells are independent has to be known, and declared, before anybody looks.
        """
        from fairaudit.inference.contrast_region import fits_contrasts

        found: dict[Quantity, tuple[Fraction, Fraction | float]] = {}
        open_targets = [t for t in self.targets if t.verdict == "inconclusive" and t.confidence is not None and t.unit != "difference"]
        for quantity in {target.quantity for target in open_targets if not target.under}:
            compared, interval = self.comparisons.get(quantity), self.intervals.get(quantity)
            if compared is None or interval is None or interval.evidence["independent"] or compared.pairs > FEW_PAIRS:
                continue
            alpha = 1 - interval.confidence
            region = default_region(compared, self.method, independent=True, alpha=alpha)
            if region == "pairs" or (region == "contrasts" and fits_contrasts(compared, FEW_STEPS)):
                other = ratio_interval(compared, interval.confidence, region=region, independent=True, ends=interval.ends)
                found[quantity] = other.lower, other.upper
        return found

    @cached_property
    def two_sided(self) -> Mapping[Quantity, Interval]:
        """Of the ratios with a target, the interval with half of the error on each side, both ends of which hold together.

        It may straddle a limit that one of the ends in `intervals` decides; no verdict rests on it, and no certificate has it.
        """
        found: dict[Quantity, Interval] = {}
        for quantity, own in self.intervals.items():
            if own.ends == "each":
                options = {name: own.evidence[name] for name in ("method", "region", "independent")}
                options["select"] = "half-split" if "split" in own.evidence else "bonferroni"
                found[quantity] = ratio_interval(self.comparisons[quantity], own.confidence, **options)
        return found

    @cached_property
    def further_draws(self) -> tuple[tuple[Target, Planning], ...]:
        """For each target that the draws do not decide, an estimate of how many more would: for planning, no guarantee."""
        from fairaudit.inference.planning import further_draws

        open_targets = [
            t
            for t in self.targets
            if t.verdict == "inconclusive" and t.confidence is not None and t.quantity in self.comparisons
            if t.unit != "difference" and not t.under
        ]
        planned = []
        for t in open_targets:
            interval = self.intervals[t.quantity]
            limit: dict[str, Any] = {f"max_{t.unit}": t.limit, "interval": interval}
            planned.append((t, further_draws(self.comparisons[t.quantity], interval.confidence, **limit)))
        return tuple(planned)

    @answered
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
            "equalized_odds": self.partial.distances[:count]
            if self.partial
            else most_unequal_distances(self.law, count, within_context=True),
            "demographic_parity": most_unequal_distances(self.law, count, within_context=False),
        }

    def most_unequal_pairs(self, count: int = 3) -> dict[str, tuple[Ratio, ...]]:
        """Rank the most unequal pairs by ratio alone: ``local`` and ``global`` of `most_unequal`."""
        law, utility = self.law, self.utility
        if utility.signed:
            return {"local": (), "global": ()}
        local = self.partial.pairs[:count] if self.partial else most_unequal_ratios(law, utility, count, within_context=True)
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
        return tuple(claims_of(self))

    @cached_property
    def certificate(self) -> Certificate:
        """The certificate, ready to be saved."""
        from fairaudit.audits.document import certificate_of

        return certificate_of(self)


def spellings_of(law: Law, columns: Columns, contexts: Sequence[Any]) -> tuple[dict[str, Any], ...]:
    """Labels of one column of a law that differ in spelling alone, and groups that differ so from a label that names none."""
    listed: list[tuple[str, list[str]]] = [(columns.decision, list(law.decisions))]
    for names, labels in ((columns.group, law.groups), (columns.context, contexts)):
        listed += [(name, list(dict.fromkeys(label[i] for label in labels))) for i, name in enumerate(names)]
    if law.truth is not None and columns.truth is not None:
        listed.append((columns.truth, list(law.truth.labels)))
    unknown = {label for entry in law.preparation if entry["step"] == "unknown" for label in entry["labels"]}
    found = spellings((name, {*labels, *(unknown if name in columns.group else ())}) for name, labels in listed)
    own = {name: set(labels) for name, labels in listed}
    return tuple(entry for entry in found if not own[entry["column"]].isdisjoint(entry["labels"]))


def pair_key(witness: Witness) -> tuple[str, ...]:
    """The labels of a pair, as a key."""
    return (*(witness.context or {}).values(), *witness.higher.values(), *witness.lower.values())


def not_compared(law: Law) -> list[dict[str, Any]]:
    """Contexts, groups and quantities of a law that are left out of the comparison, and why."""
    present = np.bincount(law.cell_context, minlength=len(law.contexts))
    ends = np.cumsum(present)
    left_out: list[dict[str, Any]] = []
    for x in np.flatnonzero(present < len(law.groups)).tolist():
        groups = law.cell_group[ends[x] - present[x] : ends[x]].tolist()
        absent = sorted(set(range(len(law.groups))) - set(groups))
        left_out.append(
            {"context": law.context_label(x), "groups": [law.group_label(a) for a in absent], "reason": "no decisions recorded"}
        )
    few = np.flatnonzero(present < 2).tolist()
    left_out += [{"context": law.context_label(x), "reason": "fewer than two groups"} for x in few]
    weightless = sorted({*np.flatnonzero(np.bincount(law.cell_group)).tolist()} - law.groups_with_mass)
    if weightless:
        left_out.append({"groups": [law.group_label(a) for a in weightless], "reason": "no population"})
    if not law.global_groups:
        incomplete = law.population == "equal" and not law.complete
        reason = "a group is missing in a context and no population was given" if incomplete else "fewer than two groups"
        left_out.append({"quantity": "global", "reason": reason})
    return left_out
