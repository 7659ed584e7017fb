"""The registry of claims: every kind of claim that a certificate can make, what it says, and what makes it true.

A kind of claim that is not here is not written, and no checker accepts it. From these entries the writer takes what a claim is called,
what it is about, what it needs, which assumptions it lists and what its evidence looks like; the tables of docs/claims.md and
docs/proofs.md, the entries of proofs/index.toml, the JSON Schema and the list of claims that the page of a report knows are made from
them. `fairaudit.checker` has rules of its own and imports nothing of this; tests compare the two. CONTRIBUTING.md says how to add a kind.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from fairaudit.theorems.bound import (
    ANY_CONTEXT_FILTER,
    ANY_POLICY,
    ANY_UTILITY,
    ANY_UTILITY_FLOORED,
    FLOORED,
    NEAR_POLICY,
    THIS_LAW,
    THIS_POLICY,
)
from fairaudit.theorems.kind import Kind, later
from fairaudit.words import DRIFTING, HIDDEN, OBJECTIONS, WHATEVER, WHOEVER

EVERY_UTILITY = "every utility of the class"

SAMPLED = "population at confidence "
"""The confidence follows."""

ONE_SIDED = "population, one-sided at confidence "
"""The confidence follows, of each end by itself."""

RATIOS = ("local_ratio", "global_ratio")

EXPECTED_DIFFERENCES = ("local_difference", "global_difference")

DISTANCES = ("demographic_parity", "equalized_odds")

SUPREMA = ("local_ratio_supremum", "global_ratio_supremum")

DIFFERENCES = ("equal_opportunity", "equalized_odds_true_label", "equal_opportunity_overall", "equalized_odds_true_label_overall")

RADII = ("local_ratio_radius", "local_log_radius", "global_ratio_radius", "global_log_radius")
"""How far cells may move, in total variation, while the verdict on such a limit stands."""

FACTORS = ("local_ratio_factor", "local_log_factor", "global_ratio_factor", "global_log_factor")

OF_FLOORS = ("declared-floor", "declared-floor-in", "declared-mean-floor")
"""What claims about policies that keep floors list, as they were declared."""

HIDDEN_CONTEXTS = ("local_hidden_context", "global_hidden_context")

OF_DRAWS = ("draws", "units", "one-row", "paired", "by-design", "pooled", "stated-population", "range", "own-range", "cells", "split")
"""What claims about draws can list besides, as their interval asks for."""


_COVERAGE = "property tests, and simulated coverage"
_LEAST = (
    "That no assignment gives a smaller ratio: of one pair it is T15_greatest in the other order; of all pairs together it is not "
    "machine-checked, the checker decides it anew in integers (written proof in docs/theory.md, property tests against enumeration)."
)
_WRITTEN = f"Not machine-checked: written proofs in docs/certificate-samples.md, {_COVERAGE}."
_BOXES = (
    "Machine-checked, under `draws` below: for every law of the draws, what a program accepts of boxes of ends, "
    "is wrong at most with the probability that is said. Not machine-checked: that this checker computes the same, ends by bounds "
    "for more draws or in closed form, products, policies behind filters and differences (written proofs in docs/certificate-samples.md, "
    f"{_COVERAGE})."
)
_PAIRS = (
    "Machine-checked, under `draws` below: for every law of the draws, what a program accepts of ladders of knots is wrong at most with "
    "the probability that is said, for a pair and for the interval. Not machine-checked: that this checker computes the same, splits and "
    f"differences (written proofs in docs/certificate-samples.md, {_COVERAGE})."
)
_UNITS = (
    "Machine-checked, under `bets` below: whatever the laws of the units are, an end that a program accepts of the profiles of units is "
    "wrong at most with the probability that is said. Not machine-checked: that this checker computes the same (written proofs in "
    f"docs/certificate-samples.md, {_COVERAGE})."
)
_OF_INTERVALS = ("chosen", *OF_DRAWS, "past", "own-past", "mix", "order")


_T16 = (
    *("T16_up", "T16_down", "T16_attained", "T16_attained_down", "T16_within", "T16_exceeds", "T16_before", "T16_worst", "T16_local"),
    *("T16_factor_up", "T16_factor_down", "T16_global", "T16_global_down", "T16_local_partial"),
)


_T19 = tuple(f"T19_{part}" for part in ("mean", "attained", "greatest", "greatest_attained", "least", "level", "equal", "population"))


def _drift(own: str, *, declared: tuple[str, ...] = (), **entry: Any) -> Kind:
    """T16 for a table, or for the population behind it."""
    return Kind(
        id=f"T16-{own}",
        by="T16",
        evidence="pair",
        anchor="theory.md#t16",
        coq=_T16,
        assumes=("same-range", *declared),
        overall=("held-shares",),
        may_assume=("chosen", *OF_DRAWS) if entry["subject"] == "sample" else (),
        **entry,
    )


def _interval(by: str, says: str, how: str, reason: str = _WRITTEN) -> Kind:
    """An interval of a ratio, or of a difference, of the population behind draws."""
    return Kind(
        id=f"{by}-interval",
        by=by,
        says=says,
        how=how,
        quantities=(*RATIOS, *EXPECTED_DIFFERENCES),
        relations=(">=", "<="),
        scopes=(SAMPLED, ONE_SIDED),
        subject="sample",
        evidence="interval",
        code=("fairaudit.inference.ratio_intervals.ratio_interval", "fairaudit.inference.differences.difference_interval"),
        anchor="certificate-samples.md#evidence-of-an-interval",
        reason=reason,
        assumes=("chosen",),
        may_assume=OF_DRAWS,
    )


def _bound(by: str, *, own: str = "", scopes: tuple[str, ...] = (ANY_POLICY,), quantity: str = "local_ratio", **entry: Any) -> Kind:
    """A theorem that bounds a ratio of a policy behind filters; `own` is its id where several kinds share what they cite."""
    return Kind(id=own or by, by=by, quantities=(quantity,), relations=("<=",), scopes=scopes, subject="policy", **entry)


def _over_policies(own: str, scope: str, quantities: tuple[str, ...], **entry: Any) -> Kind:
    """T13 for one of its scopes."""
    return Kind(
        id=f"T13-{own}",
        by="T13",
        quantities=quantities,
        scopes=(scope,),
        subject="policy",
        anchor="theory.md#t13",
        overall=("stated-population",),
        **entry,
    )


KINDS: tuple[Kind, ...] = (
    # Figures of the table
    Kind(
        id="enumeration",
        by="enumeration",
        says="The figure is the one that the table gives.",
        how="counted in the table",
        quantities=(*RATIOS, *EXPECTED_DIFFERENCES, *DISTANCES, *DIFFERENCES),
        relations=("=",),
        scopes=(THIS_LAW,),
        subject="any",
        evidence="table",
        code=(
            "fairaudit.measures.ratios.local_fairness",
            "fairaudit.measures.ratios.global_fairness",
            "fairaudit.measures.differences.local_difference",
            "fairaudit.measures.differences.global_difference",
            "fairaudit.measures.distances.demographic_parity",
            "fairaudit.measures.distances.equalized_odds",
            "fairaudit.measures.rates.given_truth",
        ),
        anchor="certificate.md#metrics",
        reason=(
            "Not a theorem: the checker computes the figure again from the table, and a second computation in the tests, over plain "
            "fractions, agrees."
        ),
    ),
    Kind(
        id="T6",
        by="T6",
        says="The worst utility that ignores the group is that of a single decision.",
        how="the worst utility for this law",
        quantities=SUPREMA,
        relations=("=",),
        scopes=(THIS_LAW,),
        subject="any",
        evidence="table",
        code=("fairaudit.measures.ratios.local_supremum", "fairaudit.measures.ratios.global_supremum"),
        anchor="theory.md#t6",
        coq=(
            *("T6_local", "T6_attained", "T6_exists", "T6_zero_denominator", "T6_global", "T6_global_attained"),
            *("T6_local_partial", "T6_exists_partial", "T6_zero_denominator_partial", "T6_global_partial"),
        ),
    ),
    Kind(
        id="T7",
        by="T7",
        says="Total variation is at most (R* − 1)/(R* + 1), R* being the worst ratio of T6.",
        how="from the worst ratio of probabilities",
        quantities=DISTANCES,
        relations=("<=",),
        scopes=(THIS_LAW,),
        subject="any",
        evidence="supremum",
        code=("fairaudit.theorems.t07.t7",),
        anchor="theory.md#t7",
        coq=(
            *("T7_symmetric", "T7_equalized_odds", "T7_demographic_parity"),
            *("T7_equalized_odds_partial", "T7_demographic_parity_partial"),
        ),
    ),
    Kind(
        id="T5",
        by="T5",
        says="If context and group are independent, the global ratio is at most the local one.",
        how="the local bound, groups being spread alike over contexts",
        quantities=("global_ratio",),
        relations=("<=",),
        scopes=(THIS_LAW,),
        subject="any",
        evidence="table",
        code=("fairaudit.theorems.t05.t5_independent",),
        anchor="theory.md#t5",
        coq=("T5_independent", "T5_independent_partial"),
        needs=("independent",),
    ),
    # Ratios of the table, whatever was not recorded
    Kind(
        id="T15-greatest",
        by="T15",
        says="No assignment of the decisions of unknown group to groups gives a greater ratio, and one gives this.",
        how="the worst that the decisions without a group can do",
        quantities=RATIOS,
        relations=("<=",),
        scopes=(f"{THIS_LAW}, {WHOEVER}",),
        subject="any",
        evidence="completion",
        code=("fairaudit.theorems.t15.greatest",),
        anchor="theory.md#t15",
        coq=("T15_greatest", "T15_greatest_mean", "T15_least_mean"),
        may_assume=("unknown-compared", "unknown-share", "unknown-others"),
    ),
    Kind(
        id="T15-least",
        by="T15",
        says="No assignment of the decisions of unknown group to groups gives a smaller ratio.",
        how="the best that the decisions without a group can do",
        quantities=RATIOS,
        relations=(">=",),
        scopes=(f"{THIS_LAW}, {WHOEVER}",),
        subject="any",
        evidence="proof",
        beside=("reached",),
        code=("fairaudit.theorems.t15.least_apart", "fairaudit.theorems.t15_assignments.least_of_all"),
        anchor="theory.md#t15",
        reason=_LEAST,
        may_assume=("unknown-compared", "unknown-share", "unknown-others"),
    ),
    # Decisions of unknown meaning
    Kind(
        id="T19",
        by="T19",
        says="Whatever each undecided decision meant, the ratio is between these ends.",
        how="whatever the undecided decisions meant",
        quantities=RATIOS,
        relations=("<=", ">="),
        scopes=(f"{THIS_LAW}, {WHATEVER}",),
        subject="any",
        evidence="pair",
        code=("fairaudit.theorems.t19.ratio_range",),
        anchor="theory.md#t19",
        coq=_T19,
        may_assume=("undecided",),
    ),
    Kind(
        id="T19-population",
        by="T19",
        says="So it is in the population, by ends of means that hold at the confidence, of the least and of the most that they can be.",
        how="whatever the undecided decisions meant",
        quantities=RATIOS,
        relations=("<=", ">="),
        scopes=(f"{SAMPLED}, {WHATEVER}", f"{ONE_SIDED}, {WHATEVER}"),
        subject="sample",
        evidence="ends",
        code=("fairaudit.audits.undecided.with_meanings",),
        anchor="theory.md#t19",
        coq=_T19,
        assumes=("chosen",),
        may_assume=("undecided", "undecided-released", *OF_DRAWS),
    ),
    # Theorems about a policy behind filters, in the order in which certificates list them
    _bound(
        "T2",
        says="Behind a group filter with pure ε, for a utility that ignores the group: R ≤ e^ε for every policy.",
        how="privacy alone",
        evidence="",
        code=("fairaudit.theorems.t02.t2",),
        anchor="theory.md#t2",
        coq=("T2_pure", "T2_sharp"),
        needs=("a-free", "finite"),
        applies=later("t02.t2_in"),
    ),
    _bound(
        "T12",
        scopes=(THIS_POLICY,),
        says="A policy's own ratio R0 shrinks behind a filter with pure ε to at most (1 + R0·e^ε)/(R0 + e^ε).",
        how="contraction of the policy's own ratio",
        evidence="raw_ratio",
        code=("fairaudit.theorems.t12.t12",),
        anchor="theory.md#t12",
        coq=("T12_contraction", "T12_any_filter", "T2_pure", "T12_released", "T12_any_filter_released"),
        needs=("a-free",),
        applies=later("t12.t12_in"),
    ),
    _bound(
        "T4",
        says=(
            "For a utility that ignores the group and is never below m > 0: R ≤ k + max(0, (γ − m)·H_k − (k − 1)·m)/m, for every policy."
        ),
        how="privacy and a least utility",
        evidence="multipliers",
        code=("fairaudit.theorems.t04.t4",),
        anchor="theory.md#t4",
        coq=("T4_one_k", "T4_any_policy"),
        needs=("a-free",),
        declares=("gamma", "m"),
        applies=later("t04.t4_in"),
    ),
    _bound(
        "T3",
        own="T3-any-filter",
        scopes=(THIS_POLICY,),
        says="With a floor of the policy and a utility that ignores the group: T3 by ε alone, for every group filter of that ε.",
        how="privacy and a floor, sharp",
        evidence="multipliers",
        code=("fairaudit.theorems.t03.t3_approx",),
        anchor="theory.md#t3",
        coq=("T3_any_filter", "pure_dp_hockey_stick", "T3_any_filter_released"),
        needs=("a-free",),
        applies=later("t03.t3_any_filter_in"),
    ),
    _bound(
        "floor",
        scopes=(THIS_LAW, FLOORED),
        says="Nobody gets more than γ and nobody compared less than τ, so R ≤ γ/τ.",
        how="the floor alone",
        evidence="",
        code=("fairaudit.theorems.t01.floor_cap",),
        anchor="theory.md#t1",
        coq=("T1_cap",),
        declares=("gamma",),
        applies=later("t01.floor_in"),
    ),
    _bound(
        "T1",
        scopes=(THIS_LAW, FLOORED),
        says="Behind a group filter, with a floor τ: R ≤ k + (K + γ·H_k)/τ for every k ≥ 0, hence R ≤ e^ε + (K + δγ)/τ.",
        how="privacy and a floor, any utility",
        evidence="multipliers",
        code=("fairaudit.theorems.t01.t1",),
        anchor="theory.md#t1",
        coq=("T1_one_k", "T1_additive", "T1_filter", "T1_tight"),
        declares=("gamma",),
        applies=later("t01.t1_in"),
    ),
    _bound(
        "T1-paper",
        scopes=(THIS_LAW, FLOORED),
        says="The paper's form of T1, R ≤ e^ε·(1 + (K + δγ)/τ): true, and never less.",
        how="privacy and a floor, in the paper's form",
        evidence="",
        code=("fairaudit.theorems.t01.t1_paper",),
        anchor="theory.md#t1",
        coq=("T1_paper",),
        needs=("finite",),
        declares=("gamma",),
        applies=later("t01.t1_paper_in"),
    ),
    _bound(
        "T3",
        scopes=(THIS_LAW, FLOORED),
        says=(
            "With a floor and a utility that ignores the group, or depends on it by at most K: R ≤ k + (K + (γ − K)·H_k)/τ for every k, "
            "one k for each ordered pair of groups."
        ),
        how="privacy and a floor, sharp",
        evidence="multipliers",
        code=("fairaudit.theorems.t03.t3_general",),
        anchor="theory.md#t3",
        coq=("certificate_one_k", "T3_one_k", "T3_K_one_k"),
        declares=("gamma",),
        applies=later("t03.t3_in"),
    ),
    _bound(
        "T5",
        own="T5-any-policy",
        quantity="global_ratio",
        says="Behind a filter with pure ε, if context and group are independent, the global ratio is at most e^ε.",
        how="the local bound, groups being spread alike over contexts",
        evidence="",
        code=("fairaudit.theorems.t05.t5_independent",),
        anchor="theory.md#t5",
        coq=("T5_independent_filter", "T5_independent_filter_partial"),
        needs=("a-free", "finite", "independent"),
        assumes=("stated-population",),
        applies=later("t05.t5_in"),
    ),
    _bound(
        "T5-decision",
        quantity="global_ratio",
        says="For a utility of the decision alone: the global ratio is at most e^ε times the greatest ratio of P(x̃∣a) to P(x̃∣a').",
        how="privacy, and how groups are spread over contexts",
        evidence="composition",
        code=("fairaudit.theorems.t05.t5_decision",),
        anchor="theory.md#t5",
        coq=("T5_decision", "T5_decision_partial"),
        needs=("g(u)", "finite"),
        assumes=("stated-population",),
        applies=later("t05.t5_decision_in"),
    ),
    _bound(
        "T8",
        scopes=(ANY_CONTEXT_FILTER,),
        says="Filtering the context does not raise the local ratio of a utility of the decision alone.",
        how="the same policy without the context filter",
        evidence="",
        code=("fairaudit.theorems.t08.t8_in",),
        anchor="theory.md#t8",
        coq=("T8_released", "T8_context_filter", "T8_all_compared"),
        needs=("g(u)", "context filter"),
        applies=later("t08.t8_in"),
    ),
    # The greatest ratio over policies
    _over_policies(
        "any-policy",
        ANY_POLICY,
        SUPREMA,
        says="Behind known filters no policy has a greater ratio for this utility, and one has it.",
        how="the worst that any policy can do",
        relations=("=",),
        evidence="attained",
        code=("fairaudit.theorems.t13.greatest_ratio",),
        coq=(
            *("T13_any_policy", "T13_deterministic", "T13_supremum", "T13_infinite"),
            *("T13_local_ratio", "T13_local_supremum", "T13_local_infinite"),
            *("T13_global_ratio", "T13_global_supremum", "T13_global_infinite"),
            *("T13_global_ratio_partial", "T13_global_supremum_partial", "T13_global_infinite_partial", "attained_partial"),
            *("T13_merge_surplus", "T17_releases", "T17_releases_global", "T17_releases_global_partial"),
        ),
        may_assume=("releases",),
        reaches=later("t13_cases.t13_any_policy_in"),
    ),
    _over_policies(
        "near",
        NEAR_POLICY,
        SUPREMA,
        says="So is the greatest ratio of the policies within a total variation of this one.",
        how="the worst that a policy near this one can do",
        relations=("=",),
        evidence="attained",
        code=("fairaudit.theorems.t13_near.greatest_ratio_near",),
        coq=(
            *("T13_near", "T13_near_exists", "T13_near_local", "T13_near_global", "T13_near_attained", "T13_near_attained_global"),
            "attained_partial",
        ),
        needs=("one release",),
        assumes=("drift",),
        reaches=later("t13_cases.t13_near_in"),
    ),
    _over_policies(
        "floored",
        FLOORED,
        SUPREMA,
        says="Multipliers of declared floors bound the ratio of every policy that keeps them; where the relation is =, one of them has it.",
        how="the worst that a policy above the floor can do",
        relations=("=", "<="),
        evidence="multipliers",
        beside=("pairs", "policy"),
        code=("fairaudit.theorems.t13_floors.greatest_ratio_above",),
        coq=(
            *("T13_floor", "T13_floor_local", "T13_floor_global", "T13_floor_one_k", "T13_floor_one_k_global", "T13_mean_floor"),
            *("T13_floor_attained", "T13_floor_attained_global", "attained_partial"),
        ),
        may_assume=(*OF_FLOORS, "releases"),
        reaches=later("t13_cases.t13_floored_in"),
    ),
    _over_policies(
        "range-floored",
        ANY_UTILITY_FLOORED,
        RATIOS,
        says="With a floor the ratio of every policy that keeps it, for every utility of a range, is bounded by one k for each pair.",
        how="privacy, the declared floor and the declared range",
        relations=("<=",),
        evidence="multipliers",
        code=("fairaudit.theorems.t13_range.t13_range",),
        coq=(
            *("T13_range_floor", "T13_range_floor_global", "T13_range_cap", "T13_range_cap_global"),
            *("T13_range_floor_global_partial", "T13_range_cap_global_partial"),
        ),
        declares=("gamma", "m"),
        assumes=("declared-range",),
        may_assume=(*OF_FLOORS, "declared-range-in", "releases"),
        reaches=later("t13_cases.t13_range_floored_in"),
    ),
    _over_policies(
        "range",
        ANY_UTILITY,
        RATIOS,
        says="The ratio of every policy, for every utility of a range, is at most V if K + (γ − K − m)·H_V ≤ m·(V − 1).",
        how="privacy and the declared range",
        relations=("<=",),
        evidence="",
        code=("fairaudit.theorems.t13_range.t13_range",),
        coq=("T13_range", "T13_range_global", "T13_range_global_partial", "T13_range_sharp"),
        declares=("gamma", "m"),
        assumes=("declared-range",),
        may_assume=("declared-range-in", "releases"),
        reaches=later("t13_cases.t13_range_in"),
    ),
    # Cells that drift
    _drift(
        "radius",
        says="The verdict on the limit stands as long as no cell's law moves further, in total variation or by a factor.",
        how="how far every cell may move before the verdict changes",
        quantities=(*RADII, *FACTORS),
        relations=("=", ">="),
        scopes=(THIS_LAW,),
        subject="table",
        beside=("followed", "limit", "verdict"),
        code=("fairaudit.theorems.t16.law_radius",),
    ),
    _drift(
        "radius-population",
        says="So does that on the population, by ends of single cells that its interval proves.",
        how="how far every cell may move before the verdict changes",
        quantities=RADII,
        relations=(">=",),
        scopes=(ONE_SIDED,),
        subject="sample",
        beside=("followed", "limit", "verdict"),
        code=("fairaudit.inference.moving_ends.MovingEnds",),
    ),
    _drift(
        "worst",
        says="Within the declared drift of every cell the ratio is between these ends.",
        how="the worst and the best ratio within the declared drift",
        quantities=RATIOS,
        relations=("<=", ">="),
        scopes=(f"{THIS_LAW}, {DRIFTING}",),
        subject="table",
        beside=("followed",),
        code=("fairaudit.theorems.t16.drifted_extremes",),
        declared=("cell-drift",),
    ),
    _drift(
        "worst-population",
        says="So it is in the population, by ends of single cells that its interval proves.",
        how="the worst and the best ratio within the declared drift",
        quantities=RATIOS,
        relations=("<=", ">="),
        scopes=(f"{ONE_SIDED}, {DRIFTING}",),
        subject="sample",
        beside=("followed",),
        code=("fairaudit.inference.moving_ends.MovingEnds",),
        declared=("cell-drift",),
    ),
    # A class of utilities
    Kind(
        id="T3-class",
        by="T3",
        says="The bound of T3 for two rows of a law in the place of two of a filter, for every utility of a class.",
        how="privacy and a floor, sharp",
        quantities=RATIOS,
        relations=("<=",),
        scopes=(EVERY_UTILITY,),
        subject="class",
        evidence="multipliers",
        code=("fairaudit.worst.methods.worst_case",),
        anchor="certificate-worst-case.md#the-claim",
        coq=("T3_class", "T3_class_no_floor"),
    ),
    Kind(
        id="lp-dual",
        by="lp-dual",
        says="The multipliers prove that no utility of the class gives a greater ratio.",
        how="linear programming, with an exact proof",
        quantities=RATIOS,
        relations=("<=",),
        scopes=(EVERY_UTILITY,),
        subject="class",
        evidence="pairs",
        code=("fairaudit.worst.methods.worst_case",),
        anchor="certificate-worst-case.md#the-claim",
        coq=("lp_check_sound", "worst_case_local", "worst_case_global", "claim_true_sound"),
    ),
    # The population behind draws
    _interval(
        "binomial",
        "The interval of a 0/1 utility holds at its confidence, by exact binomial tails.",
        "exact binomial interval",
        _BOXES,
    ),
    _interval(
        "pair-exact",
        "The interval of a 0/1 utility of independent cells holds at its confidence: each pair of cells is tested exactly by itself.",
        "exact test of each pair",
        _PAIRS,
    ),
    _interval(
        "symmetric-betting",
        "The interval of a bounded utility of independent cells holds at its confidence, by bets on the contrast of each pair of cells.",
        "bets on the contrast of each pair",
    ),
    _interval(
        "paired-betting",
        "The interval of groups that were seen in the same units holds at its confidence: bets compare what a unit gets in two groups.",
        "bets on contrasts within units",
        _UNITS,
    ),
    Kind(
        id="binomial-rates",
        by="binomial",
        says="So does that of a difference of rates given the true label.",
        how="exact binomial interval",
        quantities=DIFFERENCES,
        relations=(">=", "<="),
        scopes=(SAMPLED,),
        subject="labels",
        evidence="interval",
        code=("fairaudit.inference.rates.with_intervals",),
        anchor="certificate-samples.md#differences-of-rates",
        reason=_WRITTEN,
        assumes=("given-labels", "chosen-labels"),
        may_assume=("pooled",),
    ),
    _interval(
        "hoeffding-kl",
        "The interval of a bounded utility holds at its confidence, by the Chernoff bound with the relative entropy.",
        "Hoeffding–Chernoff interval",
    ),
    _interval(
        "empirical-bernstein",
        "The interval of a bounded utility holds at its confidence, by the empirical Bernstein bound.",
        "empirical Bernstein interval",
    ),
    _interval("intersection", "The interval is where two methods agree, each at half the error.", "the better of two intervals"),
    Kind(
        id="betting-interval",
        by="betting",
        says="The interval of a stream holds at every moment, by Ville's inequality for mixtures of bets.",
        how="an interval that holds at every moment of the stream",
        quantities=RATIOS,
        relations=(">=", "<="),
        scopes=(SAMPLED,),
        subject="sample",
        evidence="interval",
        code=("fairaudit.inference.anytime.stream_interval",),
        anchor="certificate-monitor.md#wealth",
        reason="Not machine-checked: written proofs in docs/certificate-monitor.md, property tests, and simulated streams.",
        assumes=("range", "chosen", "order"),
        may_assume=("past", "own-past", "mix"),
    ),
    # What was not recorded
    Kind(
        id="T14-frontier",
        by="T14",
        says=(
            "An unrecorded factor does not bring the ratio down to 1, or to a target, if it is fewer times as common in one group as in "
            "another than the value, and changes what they get fewer times, or both than a pair of the frontier."
        ),
        how="the least strength of an unrecorded factor that could explain it",
        quantities=HIDDEN_CONTEXTS,
        relations=(">=",),
        scopes=(THIS_LAW, SAMPLED, ONE_SIDED),
        subject="any",
        evidence="frontier",
        code=("fairaudit.theorems.t14.frontier",),
        anchor="theory.md#t14",
        coq=("T14_frontier",),
        may_assume=_OF_INTERVALS,
    ),
    Kind(
        id="T14-hidden",
        by="T14",
        says=(
            "Among people who are alike in an unrecorded factor of the declared strength, too, some ratio is at least (m + k)/(1 + mk) "
            "of the one that was seen."
        ),
        how="what an unrecorded factor of the declared strength leaves of it",
        quantities=RATIOS,
        relations=(">=",),
        scopes=tuple(f"{scope}, {HIDDEN}" for scope in (THIS_LAW, SAMPLED, ONE_SIDED)),
        subject="any",
        evidence="hidden_context",
        code=("fairaudit.theorems.t14.least_ratio",),
        anchor="theory.md#t14",
        coq=(
            *("T14_hidden", "T14_exceeds", "T14_any_spread", "T14_local", "T14_local_partial", "T14_sharp"),
            *("T14_one_sided", "T14_one_sided_sharp", "T14_one_sided_reversed", "T14_one_sided_reversed_sharp"),
        ),
        may_assume=("hidden-both", "hidden-higher", "hidden-lower", *_OF_INTERVALS),
    ),
)

BY_ID: dict[str, Kind] = {kind.id: kind for kind in KINDS}

BY_KEY: dict[tuple[str, str, str, str], Kind] = {
    (quantity, relation, kind.by, scope): kind
    for kind in KINDS
    for quantity in kind.quantities
    for relation in kind.relations
    for scope in kind.scopes
}
"""Kinds by the quantity, relation, source and scope of their claims; of a population, the scope without the confidence."""


def kind_of(claim: Mapping[str, Any]) -> Kind | None:
    """The kind of a claim of a certificate, if there is one."""
    about, objection = without_objection(claim["scope"])
    scope = next((opening for opening in (SAMPLED, ONE_SIDED) if about.startswith(opening)), about)
    return BY_KEY.get((claim["quantity"], claim["relation"], claim["by"], under(scope, objection)))


def under(scope: str, objection: str) -> str:
    """What a statement is about, if it takes an objection into account; of a population, `BY_KEY` has it without the confidence."""
    return f"{scope}, {objection}" if objection else scope


def without_objection(scope: str) -> tuple[str, str]:
    """What a statement is about, and the objection that it takes into account, which is empty if there is none.

    Examples
    --------
    >>> without_objection("this law, within the declared drift")
    ('this law', 'within the declared drift')
    """
    about, _, objection = scope.rpartition(", ")
    return (about, objection) if objection in OBJECTIONS else (scope, "")


def is_sampled(scope: str) -> bool:
    """Whether a scope is the population behind draws."""
    return scope.startswith((SAMPLED, ONE_SIDED))


def for_any_sampled(kind: Kind | None, scope: str, declared: Mapping[str, Any], *, group_free: bool) -> bool:
    """Whether a bound holds for whatever policy was sampled, and rests on declared constants only.

    `group_free`: whether the utility of the table does not depend on the group. Where it does, how far the utilities of two groups may
    differ for decisions that were never drawn has to be declared.
    """
    if kind is None or not all(name in declared for name in kind.declares):
        return False
    if scope in (ANY_POLICY, FLOORED):
        return kind.reaches is None
    return scope in (ANY_UTILITY, ANY_UTILITY_FLOORED) and (group_free or "lipschitz" in declared)
