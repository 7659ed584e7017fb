"""A certificate as it stands: well formed, and perhaps untrue."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Mapping
from dataclasses import dataclass, field
from fractions import Fraction

from .claims import (
    HIDDEN_CONTEXTS,
    OVER_UNITS,
    POPULATION,
    RULES,
    UTILITIES,
    WHOEVER,
    WHOEVER_IN_LAW,
    Claim,
    is_about_population,
    is_by_t14,
    without_objection,
)
from .declared import DeclaredIn, read_declared
from .drift import about_drift, read_drifted
from .evaluation import ERROR, NOTHING, Evaluation, read_evaluation
from .figures import EXPECTED_DIFFERENCES
from .header import Positive, Subject, has_truth, is_about_policy, read_positive, read_subject
from .hidden_context import read_frontier, read_hidden
from .intervals import Change, Interval, UnitEvidence, read_change, read_confidence, read_intervals
from .json_values import (
    Labels,
    read_boolean,
    read_choice,
    read_digest,
    read_integer,
    read_list,
    read_object,
    read_object_of_strings,
    read_string,
    read_strings,
)
from .meanings import Undecided, read_undecided
from .metrics import METRICS, Metrics, Rates, read_metric, read_not_compared, read_rates, read_unfiltered
from .policy_evidence import read_attained, read_floored, read_multipliers
from .preparation import MEDIAN, Step, log_digests, read_preparation, read_spellings
from .rates import DIFFERENCES, stated_given_truth
from .rationals import ONE, Rational, at_most, read_extended, read_rational
from .text import malformed, shown
from .undecided import is_by_t19
from .undecided import read_evidence as read_ends
from .unknown_evidence import Share, Tips, read_shares, read_tips
from .unknown_evidence import read_evidence as read_unknown
from .utility_class import UtilityClass, read_class, read_dual

CERTIFICATE_FORMAT = "fairaudit-certificate/1"


@dataclass(frozen=True)
class Target:
    """A limit that was asked for, with the verdict that the certificate states."""

    quantity: str
    limit: Rational
    unit: str
    judged: str
    confidence: Fraction | None  # of what is judged about the population
    verdict: str
    of_units: bool  # whether the mean over units is judged
    under: str = ""  # the objection under which it is judged, if any
    tips: Tips | None = None  # how many decisions of unknown group could not change what the others say

    @property
    def judged_by(self) -> str:
        """The name of the metric, and of the interval, that it limits."""
        return f"{self.quantity}_difference" if self.unit == "difference" else self.quantity


@dataclass(frozen=True)
class Certificate:
    """A certificate as it stands: well formed, and perhaps untrue."""

    subject: Subject
    digest: str
    cells: int
    embedded: tuple[object, ...] | None  # the header and the rows
    constants: dict[str, Rational | bool | None]
    utilities: UtilityClass | None
    privacy: dict[str, dict[str, object] | None] | None  # this, the next and the unfiltered metrics are those of a policy
    declared: dict[str, Rational]
    declared_in: tuple[DeclaredIn, ...]
    metrics: Metrics
    unfiltered: Metrics | None
    not_compared: list[dict[str, object]]
    claims: tuple[Claim, ...]
    targets: tuple[Target, ...]
    verdict: str
    intervals: dict[str, Interval]  # by quantity
    positive: Positive | None  # this, the rates, and some metrics are of counts with true labels
    rates: Rates
    differences: dict[str, Interval]  # of rates, by metric
    preparation: tuple[Step, ...]
    spellings: tuple[tuple[str, Labels], ...]
    change: Change | None = None
    shares: tuple[Share, ...] = ()  # of the decisions of unknown group, as declared
    max_drift: Rational | None = None  # of a table: within which ratios are stated
    evaluation: Evaluation | None = None  # of the log of a model's evaluation, what was read
    undecided: Undecided | None = None  # decisions whose meaning is not known
    log_digests: Mapping[str, str] = field(default_factory=dict)  # of the preparation and of the evaluation

    @property
    def of_differences(self) -> bool:
        """Whether differences of expectations are stated, besides ratios or in their place."""
        return EXPECTED_DIFFERENCES[0] in self.metrics

    @property
    def withdrawn(self) -> frozenset[str]:
        """The ratios of the stream that a change leaves nothing to say about: the mix of contexts is behind one of them only."""
        if self.change is None:
            return frozenset()
        return frozenset(("global",) if self.change.quantity == "global" and self.subject.columns.context else ("local", "global"))


def _read_constants(value: object, where: str) -> dict[str, Rational | bool | None]:
    members = read_object(value, where, ("gamma", "m", "tau", "lipschitz", "depends_on_group"), optional=("burden",))
    if members.get("burden", True) is not True:  # what a utility means is stated, and nothing follows from it
        raise malformed(f"{where}.burden", f"must be true where it is stated, not {shown(members['burden'])}")
    read: dict[str, Rational | bool | None] = {}
    for key in ("gamma", "m", "tau", "lipschitz"):
        absent = key == "tau" and members[key] is None
        read[key] = None if absent else read_rational(members[key], f"{where}.{key}")
    return read | {"depends_on_group": read_boolean(members["depends_on_group"], f"{where}.depends_on_group")}


def _read_privacy(value: object, where: str) -> dict[str, dict[str, object] | None]:
    members = read_object(value, where, ("group", "context"))
    read: dict[str, dict[str, object] | None] = {"context": None}
    for name in ("group", "context"):
        if name == "group" or members[name] is not None:
            place = f"{where}.{name}"
            figures = read_object(members[name], place, ("exp_epsilon", "attributes"))
            attributes = read_list(figures["attributes"], f"{place}.attributes")
            read[name] = {
                "exp_epsilon": read_extended(figures["exp_epsilon"], f"{place}.exp_epsilon"),
                "attributes": [read_extended(item, f"{place}.attributes[{i}]") for i, item in enumerate(attributes)],
            }
    return read


def _read_evaluation(value: object, subject: Subject, intervals: Collection[Interval], embedded: bool) -> Evaluation:
    where = "subject.evaluation"
    read = read_evaluation(value, where, subject, embedded=embedded)
    if not read.unit and any(one.units is not None or isinstance(one.evidence, UnitEvidence) for one in intervals):
        raise malformed(where, "lacks the key 'unit', which intervals rest on")
    if read.drawn == NOTHING and intervals:
        raise malformed(f"{where}.drawn", "says that nothing was drawn, and there are intervals")
    return read


def _read_drift(value: object, where: str) -> Rational:
    drift = read_rational(value, where, nonnegative=True)
    if not at_most(drift, ONE):
        raise malformed(where, "must be at most 1")
    return drift


def _read_claim(value: object, where: str, parameters: int | None, width: int) -> Claim:
    keys = ("quantity", "relation", "value", "scope", "by", "assumptions", "evidence")
    members = read_object(value, where, keys)
    quantity, relation, by, scope = (read_string(members[key], f"{where}.{key}") for key in ("quantity", "relation", "by", "scope"))
    key = quantity, relation, by, scope
    return Claim(
        key,
        read_extended(members["value"], f"{where}.value"),
        read_strings(members["assumptions"], f"{where}.assumptions"),
        _read_evidence(members["evidence"], f"{where}.evidence", key, parameters, width),
    )


def _read_evidence(value: object, where: str, key: tuple[str, str, str, str], parameters: int | None, width: int) -> object:
    if is_by_t14(key):
        name = "frontier" if key[0] in HIDDEN_CONTEXTS else "hidden_context"
        item = read_object(value, where, (name,))[name]
        return read_frontier(item, f"{where}.{name}") if name == "frontier" else read_hidden(item, f"{where}.{name}")
    if is_about_population(key):
        return read_choice(
            read_object(value, where, ("interval",))["interval"],
            f"{where}.interval",
            ("local", "global", *EXPECTED_DIFFERENCES, *DIFFERENCES),
        )
    if (drift := about_drift(key)) is not None:
        return read_drifted(value, where, drift, width)
    if is_by_t19(key):
        return read_ends(value, where, key)
    rule = RULES.get(key)
    if rule is None:  # an unknown claim is found false, whatever is offered as evidence
        return read_object(value, where, (), optional=tuple(value) if isinstance(value, dict) else ())
    if key[3] == WHOEVER_IN_LAW:
        return read_unknown(value, where, key)
    if rule.evidence == "pairs":
        return read_dual(value, where, key[0] == "local_ratio", parameters)
    members = read_object(value, where, (rule.evidence, *rule.beside) if rule.evidence else ())
    if not rule.evidence:
        return None
    if rule.evidence == "attained":
        return read_attained(members["attained"], f"{where}.attained")
    if rule.beside:
        return read_floored(members, where)
    item, place = members[rule.evidence], f"{where}.{rule.evidence}"
    if rule.evidence == "table":
        return read_digest(item, place)
    if rule.evidence != "multipliers":
        return read_extended(item, place)
    multipliers = read_multipliers(item, place)
    if not multipliers and key[3] != UTILITIES:
        raise malformed(place, "must not be empty")
    return multipliers


def _read_target(value: object, where: str) -> Target:
    members = read_object(value, where, ("quantity", "limit", "unit", "judged", "verdict"), optional=("estimand", "tips"))
    judged = read_string(members["judged"], f"{where}.judged")
    about, under = without_objection(judged)
    of_population = about.startswith(POPULATION)
    target = Target(
        read_choice(members["quantity"], f"{where}.quantity", ("local", "global")),
        read_rational(members["limit"], f"{where}.limit", nonnegative=True),
        read_choice(members["unit"], f"{where}.unit", ("log", "ratio", "difference")),
        judged,
        read_confidence(about.removeprefix(POPULATION), f"{where}.judged") if of_population else None,
        read_choice(members["verdict"], f"{where}.verdict", ("within", "exceeds", "inconclusive", "depends", "changed")),
        "estimand" in members and bool(read_choice(members["estimand"], f"{where}.estimand", (OVER_UNITS,))),
        under,
        read_tips(members["tips"], f"{where}.tips", str(members["quantity"])) if "tips" in members else None,
    )
    if target.tips is not None and (target.unit != "ratio" or under != WHOEVER):
        raise malformed(f"{where}.tips", f"goes with a limit on a ratio of the table, {WHOEVER}")
    if target.unit == "ratio" and not at_most(ONE, target.limit):
        raise malformed(f"{where}.limit", "must be at least 1, being the limit of a ratio")
    return target


def _check_estimands(targets: Iterable[Target], intervals: Mapping[str, Interval]) -> None:
    """Make sure that those targets say that the mean over units is judged which are judged by an interval with units."""
    for i, target in enumerate(targets):
        interval = intervals.get(target.judged_by)
        of_units = target.confidence is not None and interval is not None and interval.units is not None
        if of_units and not target.of_units:
            raise malformed(f"targets[{i}]", f"lacks the key 'estimand', being judged by an interval for the {OVER_UNITS}")
        if target.of_units and not of_units:
            raise malformed(f"targets[{i}]", "has the key 'estimand', but is not judged by an interval with units")


def read_certificate(document: object) -> Certificate:
    """Read a certificate so far as no table is needed."""
    keys = ("format", "subject", "metrics", "not_compared", "claims", "targets", "verdict", "versions")
    top = read_object(document, "the certificate", keys, optional=("intervals", "changed"))
    read_choice(top["format"], "format", (CERTIFICATE_FORMAT,))
    of_policy = is_about_policy(top["subject"])
    keys_of_subject = ["kind", "columns", "population", "table", "utility"] + ["privacy", "declared"] * of_policy
    keys_of_subject += ["positive"] * has_truth(top["subject"])
    also = ("preparation", "spellings", "undecided") + (() if of_policy else ("class", "unknown_shares", "max_drift", "evaluation"))
    about = read_object(top["subject"], "subject", keys_of_subject, optional=also)
    utilities = read_class(about["class"], "subject.class") if "class" in about else None
    parameters = None if utilities is None or utilities.family is None else len(utilities.family.lower)
    subject = read_subject(about, "subject")
    if "intervals" in top and (subject.kind == "probabilities" or utilities is not None):
        raise malformed("the certificate", "has intervals, which are for counts and policies without a class of utilities")
    table = read_object(about["table"], "subject.table", ("sha256", "cells"), optional=("header", "rows"))
    embedded: tuple[object, ...] | None = None
    if "header" in table or "rows" in table:
        table = read_object(table, "subject.table", ("sha256", "cells", "header", "rows"))
        embedded = (table["header"], *read_list(table["rows"], "subject.table.rows"))
    rates, differences = stated_given_truth(subject.columns)
    asked = EXPECTED_DIFFERENCES if isinstance(top["metrics"], dict) and top["metrics"].keys() & set(EXPECTED_DIFFERENCES) else ()
    metrics = read_object(top["metrics"], "metrics", [*METRICS, *asked, *rates, *differences] + ["unfiltered"] * of_policy)
    intervals: dict[str, Interval] = {}
    of_differences: dict[str, Interval] = {}
    if "intervals" in top:
        intervals, of_differences = read_intervals(top["intervals"], "intervals", subject, differences)
    change = read_change(top["changed"], "changed", subject) if "changed" in top else None
    read_object_of_strings(top["versions"], "versions")
    targets = tuple(_read_target(item, f"targets[{i}]") for i, item in enumerate(read_list(top["targets"], "targets")))
    _check_estimands(targets, intervals)
    read = Certificate(
        subject,
        read_digest(table["sha256"], "subject.table.sha256"),
        read_integer(table["cells"], "subject.table.cells"),
        embedded,
        _read_constants(about["utility"], "subject.utility"),
        utilities,
        _read_privacy(about["privacy"], "subject.privacy") if of_policy else None,
        *(read_declared(about["declared"], "subject.declared") if of_policy else ({}, ())),
        {name: read_metric(metrics[name], f"metrics.{name}", name, subject.columns) for name in [*METRICS, *asked, *differences]},
        read_unfiltered(metrics["unfiltered"], "metrics.unfiltered", subject.columns) if of_policy else None,
        [
            read_not_compared(item, f"not_compared[{i}]", subject.columns)
            for i, item in enumerate(read_list(top["not_compared"], "not_compared"))
        ],
        tuple(
            _read_claim(item, f"claims[{i}]", parameters, len(subject.columns.group))
            for i, item in enumerate(read_list(top["claims"], "claims"))
        ),
        targets,
        read_choice(top["verdict"], "verdict", ("none", "within", "exceeds", "inconclusive", "depends", "changed")),
        intervals,
        read_positive(about["positive"], "subject.positive") if "positive" in about else None,
        {name: read_rates(metrics[name], f"metrics.{name}", subject.columns) for name in rates},
        of_differences,
        read_preparation(about["preparation"], "subject.preparation", subject) if "preparation" in about else (),
        read_spellings(about["spellings"], "subject.spellings") if "spellings" in about else (),
        change,
        read_shares(about["unknown_shares"], "subject.unknown_shares") if "unknown_shares" in about else (),
        _read_drift(about["max_drift"], "subject.max_drift") if "max_drift" in about else None,
        _read_evaluation(about["evaluation"], subject, (*intervals.values(), *of_differences.values()), embedded is not None)
        if "evaluation" in about
        else None,
        read_undecided(about["undecided"], "subject.undecided") if "undecided" in about else None,
        log_digests(about),
    )
    if read.undecided is not None and (utilities is not None or change or read.of_differences or read.max_drift is not None):
        raise malformed("subject.undecided", "does not go with a class of utilities, differences, a declared drift, or a change over time")
    dropped = [step for step in read.preparation if step.step == "left out" and step.unit != "lines"]
    if embedded is not None and any(step.groups is None for step in dropped):
        raise malformed("subject.preparation", "must say of which groups decisions were left out, the table being disclosed")
    log, kept = read.evaluation, () if read.undecided is None else read.undecided.decisions
    if log is not None and log.errors == "bound" and log.answers[ERROR] and ERROR not in kept:
        raise malformed("subject.undecided", f"must name the decision {shown(ERROR)}, whose meaning is to be bounded")
    if read.withdrawn & intervals.keys():
        raise malformed("intervals", "has an interval of a ratio that changed, which must not be there")
    if (intervals or of_differences or change) and any(step.step == MEDIAN for step in read.preparation):
        raise malformed("intervals", "must not be there where scores were cut at their own median, of which no two are independent")
    return read
