"""Checking a certificate: every statement of it, one after the other."""

from __future__ import annotations

import gc
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import replace

from .assumptions import check_assumptions
from .certificate import Certificate, read_certificate
from .declared import check_declared
from .drift import end_moves_of, watches_of
from .drifts import Watch
from .evaluation import ERROR, check_evaluation
from .figures import Watcher
from .header import Header
from .interval_proofs import check_change, check_differences, check_intervals
from .intervals import BoxEvidence, Proven
from .json_values import decoded, other_kind, without_page
from .judgement import Facts, check_claims, faults_of_claims
from .meanings import check_undecided
from .metrics import check_metrics, check_not_compared, check_rates, check_unfiltered
from .outline import outline_of
from .passing import PassingBox, passing_box
from .preparation import MEDIAN, check_log_digests, check_preparation, check_spellings, counted_of
from .program import Program
from .proxies import PROXIES_FORMAT, check_proxies
from .rows import embedded_lines, lines_of_file, read_table
from .subgroup_statement import SUBGROUPS_FORMAT
from .subgroups import check_subgroups
from .table import Table, constants, is_signed, measure
from .tails import tail_rarity
from .targets import check_targets
from .text import Counted, Finding, FormatError, Report, TableNeeded, compared, compared_file, malformed
from .work import CURRENT_WORK, Work, grant_bytes, working_on
from .worst_case import check_class

# What checks documents of other formats, from the decoded document and the lines of its table.
OTHER_FORMATS: dict[str, Callable[[object, Iterable[bytes] | None], Report]] = {
    PROXIES_FORMAT: check_proxies,
    SUBGROUPS_FORMAT: check_subgroups,
}


def check(certificate: bytes, table: Iterable[bytes] | None = None) -> Report:
    """Check every statement of a certificate.

    Parameters
    ----------
    certificate
        The bytes of the certificate file, or of the page of a report, which holds its certificate.
    table
        The lines of the table file, each with its line feed. When the certificate embeds its table this is not needed;
        if given nonetheless, it has to be the canonical text of the same table.

    Returns
    -------
    Report
        A finding for each statement.

    Raises
    ------
    FormatError
        If the certificate or the table is not well formed; `Incomplete` if the certificate keeps back what it assumes, `TooMuch` if
        checking it takes more work than a document of its length is given.
    TableNeeded
        If the table is not embedded and not given.
    """
    token = CURRENT_WORK.set(Work())
    collected = gc.isenabled()
    gc.disable()  # among millions of cells, which refer to each other in no circle, the search for circles takes long
    try:
        return _checked(certificate, table)
    finally:
        if collected:
            gc.enable()
        CURRENT_WORK.reset(token)
        tail_rarity.cache_clear()


def _checked(certificate: bytes, lines: Iterable[bytes] | None) -> Report:
    """Read, compute, compare: in this order, which is that of the findings, and say in short what is true."""
    grant_bytes(len(certificate))
    held = without_page(certificate)
    document = decoded(held, "the certificate")
    other = document.get("format") if isinstance(document, dict) else None
    form = other if isinstance(other, str) and other in OTHER_FORMATS else None
    if (kind := other_kind(document)) not in ("", "a certificate"):
        beside = ", and this one with --attestation" if kind.endswith("attestation") else ", such as the certificate.json beside it"
        raise malformed("the file", f"is {kind}; give the certificate{beside}")
    report = _checked_certificate(document, lines) if form is None else _checked_as(form, document, lines)
    return replace(report, of_page=held is not certificate)


def _checked_certificate(document: object, lines: Iterable[bytes] | None) -> Report:
    """Check a certificate of a table, or of a policy."""
    stated = read_certificate(document)
    working_on("the table")
    findings: list[Finding] = []
    watches = watches_of(stated.claims, stated.max_drift)
    boxes = _passing(stated)
    table = _read_law(stated, lines, findings, watches, boxes)
    _check_sign(stated, table)
    _check_unknown(stated, table)
    if stated.undecided is not None:
        check_undecided(stated.undecided, table)
    working_on("the class of utilities")
    program = None if stated.utilities is None else Program(stated.utilities, table)
    working_on("the metrics")
    metrics = measure(table)
    findings += _check_subject(stated, table)
    findings += check_log_digests(stated.log_digests, (table.header if table.policy is None else table.policy.header).log)
    findings += check_spellings(stated.spellings, stated.preparation, table)
    findings += check_preparation(stated.preparation, table)
    if stated.evaluation is not None:
        findings += check_evaluation(stated.evaluation, stated.preparation, table)
    if program is not None:
        working_on("the class of utilities")
        findings.append(check_class(stated.claims, program, metrics))
    working_on("the metrics")
    if table.given is not None:
        metrics |= table.given.differences()
    findings += check_metrics(stated.metrics, metrics, "metrics")
    findings += check_rates(stated.rates, stated.embedded is not None, table)
    if table.policy is not None:
        findings += check_unfiltered(stated.unfiltered, table.policy)
    findings.append(check_not_compared(stated.not_compared, table))
    proven, window = _check_intervals(stated, table, findings, {} if table.kept is not None else boxes)
    declared = stated.declared, program, proven, stated.declared_in, stated.shares, watches, stated.max_drift, stated.undecided
    facts = Facts(table, metrics, *declared)
    faults = faults_of_claims(stated.claims, facts)
    findings += check_claims(stated.claims, faults)
    findings += check_targets(stated, facts, [claim for claim, fault in zip(stated.claims, faults, strict=True) if not fault], window)
    report = Report(tuple(findings), stated.verdict, counted=_counted(stated, table))
    if not report.ok:
        return report
    check_assumptions(stated, table)
    return replace(report, outline=outline_of(stated, facts))


def _counted(stated: Certificate, table: Table) -> Counted:
    """Say what was counted, and what was left out, errors of an evaluation log among it."""
    counted = counted_of(stated.preparation, table)
    if stated.evaluation is None:
        return counted
    lost = stated.evaluation.dropped
    return replace(counted, dropped=(*(counted.dropped or ()), *([(ERROR, (lost, 1))] if lost else [])), log=stated.evaluation.format)


def _checked_as(form: str, document: object, lines: Iterable[bytes] | None) -> Report:
    """Check a document of another format, and name that in what is wrong with it."""
    try:
        return OTHER_FORMATS[form](document, lines)
    except FormatError as error:
        error.form = form
        raise


def _passing(stated: Certificate) -> dict[str, PassingBox]:
    """What proves the local interval while cells pass by; nothing where cells have to be kept."""
    own = stated.intervals.get("local")
    local = None if own is None else passing_box(own, end_moves_of(stated.claims, stated.max_drift))
    others = [interval for name, interval in stated.intervals.items() if name != "local"]
    pooled = all(isinstance(other.evidence, BoxEvidence) and other.quantity == "global" and not other.difference for other in others)
    return {"local": local} if local is not None and pooled and stated.subject.kind == "counts" else {}


def _read_law(
    stated: Certificate,
    lines: Iterable[bytes] | None,
    findings: list[Finding],
    watches: Sequence[Watch],
    boxes: Mapping[str, PassingBox],
) -> Table:
    """Read the table, wherever it is; the figures of a plain one are all that is kept of it, and what proves intervals."""
    needed = (stated.change or stated.evaluation or stated.undecided) is not None or (
        stated.utilities is not None or any(step.step in ("level", MEDIAN) for step in stated.preparation)
    )

    def keep(header: Header) -> bool:
        return needed or (bool(stated.intervals) and (not boxes or header.utility is None))

    watchers: list[Watcher] = [*watches, *boxes.values()]
    if stated.embedded is None and lines is None:
        raise TableNeeded("The certificate does not embed its table; the file of the table has to be given: add --table FILE.")
    if stated.embedded is None:
        return read_table(lines_of_file(lines or ()), keep, stated.positive, stated.of_differences, watchers)
    table = read_table(embedded_lines(stated.embedded), keep, stated.positive, stated.of_differences, watchers)
    if lines is not None:
        findings.append(compared_file(lines, table.digest))
    return table


def _check_unknown(stated: Certificate, table: Table) -> None:
    """Refuse decisions of unknown group where they are not said to be left out, or where what is stated has no room for them."""
    said = any(step.step == "unknown" for step in stated.preparation)
    if said != bool(table.unknown) or (stated.shares and not table.unknown):
        raise malformed("the certificate", "and its table do not agree on whether there are decisions of unknown group")
    if table.unknown and (stated.utilities is not None or stated.of_differences):
        raise malformed("the certificate", "has decisions of unknown group, which go with ratios of one utility alone")


def _check_sign(stated: Certificate, table: Table) -> None:
    """Refuse utilities below 0 where anything but differences would be stated of them."""
    if is_signed(table) and (table.policy is not None or stated.utilities is not None or not stated.of_differences):
        raise malformed(
            "the table of the certificate",
            "has utilities below 0, of which differences have to be stated, without filters or a class of utilities",
        )


def _check_intervals(
    stated: Certificate, table: Table, findings: list[Finding], boxes: Mapping[str, PassingBox]
) -> tuple[dict[str, Proven], Proven | None]:
    """Check all intervals, and say what holds by them: of each quantity, and of a window that contradicts the stream."""
    found, proven = check_intervals(stated.intervals, table, stated.undecided, boxes)
    findings += found
    found, of_differences = check_differences(stated.differences, stated.intervals, table)
    findings += found
    window: Proven | None = None
    if stated.change is not None:
        found, window = check_change(stated.change, table)
        findings += found
    return proven | of_differences, window


def _check_subject(stated: Certificate, table: Table) -> Iterator[Finding]:
    """Compare table, columns, constants of the utility, privacy of the filters and declared constants."""
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
    yield from check_declared(stated.declared, stated.declared_in, table)
