"""What the certificate states of its subject, its metrics and its intervals, against the table."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from itertools import chain, zip_longest

from .boxes import prove_difference
from .certificate import Certificate
from .claims import UTILITIES
from .figures import Maximum
from .findings import Finding, compared, finding_of
from .interval_proofs import prove_interval
from .intervals import Proven, Unproven
from .logarithms import log_enclosure
from .membership import fault_of_membership
from .program import Program
from .rates import DIFFERENCES
from .rationals import as_pair, at_most
from .stated_metrics import SHAPES
from .table import Policy, Table, constants, measure, not_compared
from .text import shown
from .utility_class import Dual
from .work import working_on

# The findings


def check_subject(stated: Certificate, table: Table) -> Iterator[Finding]:
    yield compared("subject.table.sha256", stated.digest, table.digest)
    yield compared("subject.table.cells", stated.cells, table.rows * len(table.header.decisions))
    ours, theirs = stated.subject, table.header.subject
    yield compared("subject.kind", ours.kind, theirs.kind)
    yield compared("subject.population", ours.population, theirs.population)
    for name in ("decision", "group", "context", *(["truth"] if stated.positive or table.header.truths else [])):
        yield compared(f"subject.columns.{name}", getattr(ours.columns, name), getattr(theirs.columns, name))
    actual = constants(table)
    for key, value in stated.constants.items():
        yield compared(f"subject.utility.{key}", value, actual[key])
    for name, figures in (stated.privacy or {}).items():
        used = None if table.policy is None else table.policy.group if name == "group" else table.policy.context
        if figures is None or used is None:
            yield compared(f"subject.privacy.{name}", figures, "a filter" if used else None)
        else:
            yield compared(f"subject.privacy.{name}.exp_epsilon", figures["exp_epsilon"], used.exp_epsilon)
            attributes = [factor.exp_epsilon for factor in used.factors]
            yield compared(f"subject.privacy.{name}.attributes", figures["attributes"], attributes)
    for key, value in stated.declared.items():
        own = actual[key]
        pair = (own, value) if key in ("gamma", "lipschitz") else (value, own)
        true = isinstance(own, tuple) and at_most(*pair)
        yield finding_of(f"subject.declared.{key} is {shown(value)}", true, "" if true else f"the table gives {shown(own)}")


def check_metrics(stated: Mapping[str, dict[str, object] | None], metrics: Mapping[str, Maximum | None], where: str) -> Iterator[Finding]:
    for name, figures in stated.items():
        actual = metrics.get(name)
        if figures is None or actual is None:
            yield compared(f"{where}.{name}", figures, None if actual is None else actual.value)
            continue
        expected: dict[str, object] = {"value": actual.value, "witness": actual.witness}
        if SHAPES[name][0]:
            expected |= {"ratio": actual.value, "log": log_enclosure(actual.value)}
        for key, figure in figures.items():
            yield compared(f"{where}.{name}.{key}", figure, expected[key])


def check_unfiltered(stated: Certificate, policy: Policy) -> Iterator[Finding]:
    if stated.unfiltered is None or policy.unfiltered is None:
        yield compared("metrics.unfiltered", stated.unfiltered, "comparable" if policy.unfiltered else None)
    else:
        yield from check_metrics(stated.unfiltered, measure(policy.unfiltered), "metrics.unfiltered")


def check_not_compared(stated: Certificate, table: Table) -> Finding:
    # One entry at a time: a short table can leave out more pairs of contexts and groups than fit into memory.
    for i, (entry, actual) in enumerate(zip_longest(stated.not_compared, not_compared(table))):
        if entry != actual:
            detail = "the table gives no further entry" if actual is None else f"the table gives {shown(actual)}"
            return finding_of(f"not_compared[{i}] is {'not there' if entry is None else shown(entry)}", False, detail)
    return finding_of(f"not_compared is {shown(stated.not_compared)}", True)


def check_class(stated: Certificate, program: Program, metrics: Mapping[str, Maximum | None]) -> Finding:
    utilities = program.utilities
    key = (f"{utilities.quantity}_ratio", "<=", "lp-dual", UTILITIES)
    evidence = next((claim.evidence for claim in stated.claims if claim.key == key), None)
    fault = fault_of_membership(program, metrics[utilities.quantity], evidence.theta if isinstance(evidence, Dual) else None)
    return finding_of(f"the utility is in subject.class: {utilities.described()}", not fault, fault)


def check_intervals(stated: Certificate, table: Table) -> tuple[list[Finding], dict[str, Proven]]:
    findings: list[Finding] = []
    proven: dict[str, Proven] = {}
    for name, interval in stated.intervals.items():
        fault = ""
        working_on(f"intervals.{name}")
        try:
            local = stated.intervals.get("local")
            units = [] if local is None or name == "local" else local.units or []
            if any(sum(rows) > 1 for cell in units for _, rows in cell) or (units and interval.independent):
                raise Unproven("the units of the local interval are no independent draws of the groups")
            proven[name] = prove_interval(interval, table)
        except Unproven as error:
            fault = str(error)
        ends = " and ".join(map(shown, interval.ratio))
        how = "independent" if interval.independent else "dependent"
        statement = f"intervals.{name}: between {ends} at confidence {shown(interval.confidence)}, by a {interval.region} of {how} cells"
        findings.append(finding_of(statement, not fault, fault))
    return findings, proven


def check_rates(stated: Certificate, table: Table) -> Iterator[Finding]:
    """Compare the rates, which stand in a certificate exactly if its table does."""
    actual = table.given.rates() if table.given is not None and stated.embedded is not None else {}
    for name, rates in stated.rates.items():
        yield compared(f"metrics.{name}", rates, actual.get(name))


def check_differences(stated: Certificate, table: Table) -> tuple[list[Finding], dict[str, Proven]]:
    findings: list[Finding] = []
    proven: dict[str, Proven] = {}
    for name, interval in stated.differences.items():
        fault = ""
        try:
            if any(other.units is not None for other in stated.intervals.values()):
                raise Unproven("the rows of one sampling unit are no independent draws given their true labels")
            lists = [] if table.given is None else [table.given.blocks(rate) for rate in DIFFERENCES[name]]
            if not lists or not all(lists):
                raise Unproven("the table does not give this quantity")
            prove_difference(interval, [*chain.from_iterable(lists)])
            proven[name] = Proven(interval.difference, 1 - interval.confidence, interval.scope, "binomial")
        except Unproven as error:
            fault = str(error)
        ends = " and ".join(map(shown, interval.difference))
        statement = f"intervals.{name}: between {ends} at confidence {shown(as_pair(interval.confidence))}"
        findings.append(finding_of(statement, not fault, fault))
    return findings, proven
