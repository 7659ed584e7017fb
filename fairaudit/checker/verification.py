"""Checking a certificate: every statement of it, one after the other."""

from __future__ import annotations

import hashlib
from collections.abc import Iterable
from itertools import chain

from .assumptions import check_assumptions
from .certificate import read_certificate
from .change import check_change
from .errors import TableNeeded
from .facts import Facts
from .findings import Finding, Report, compared
from .intervals import Proven
from .judgement import check_claims, faults_of_claims
from .preparation_checks import check_preparation, check_spellings
from .program import Program
from .rows import lines_of_file, read_table
from .statements import (
    check_class,
    check_differences,
    check_intervals,
    check_metrics,
    check_not_compared,
    check_rates,
    check_subject,
    check_unfiltered,
)
from .table import measure
from .tails import tail_rarity
from .targets import check_targets
from .work import CURRENT_WORK, Work, grant_bytes, working_on


def check(certificate: bytes, table: Iterable[bytes] | None = None) -> Report:
    """Check every statement of a certificate.

    Parameters
    ----------
    certificate
        The bytes of the certificate file.
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
    try:
        return _checked(certificate, table)
    finally:
        CURRENT_WORK.reset(token)
        tail_rarity.cache_clear()


def _checked(certificate: bytes, table: Iterable[bytes] | None) -> Report:
    grant_bytes(len(certificate))
    stated = read_certificate(certificate)
    findings: list[Finding] = []
    working_on("the table")
    keep = stated.change is not None or (
        stated.utilities is not None or bool(stated.intervals) or any(step.step == "level" for step in stated.preparation)
    )  # else the figures of a plain table are all that is needed of it
    if stated.embedded is not None:
        names = chain(["subject.table.header"], (f"subject.table.rows[{i}]" for i in range(len(stated.embedded) - 1)))
        law = read_table(((name, value, None) for name, value in zip(names, stated.embedded, strict=True)), keep, stated.positive)
        if table is not None:
            digest = hashlib.sha256()
            for line in table:
                digest.update(line)
            findings.append(compared("the digest of the table file", digest.hexdigest(), law.digest))
    elif table is not None:
        law = read_table(lines_of_file(table), keep, stated.positive)
    else:
        raise TableNeeded("The certificate does not embed its table; the file of the table has to be given.")
    working_on("the class of utilities")
    program = None if stated.utilities is None else Program(stated.utilities, law)
    working_on("the metrics")
    metrics = measure(law)
    findings += check_subject(stated, law)
    findings += check_spellings(stated, law)
    findings += check_preparation(stated, law)
    if program is not None:
        working_on("the class of utilities")
        findings.append(check_class(stated, program, metrics))
    working_on("the metrics")
    if law.given is not None:
        metrics |= law.given.differences()
    findings += check_metrics(stated.metrics, metrics, "metrics")
    findings += check_rates(stated, law)
    if law.policy is not None:
        findings += check_unfiltered(stated, law.policy)
    findings.append(check_not_compared(stated, law))
    of_intervals, proven = check_intervals(stated, law)
    findings += of_intervals
    of_differences, held = check_differences(stated, law)
    findings += of_differences
    proven |= held
    window: Proven | None = None
    if stated.change is not None:
        of_change, window = check_change(stated.change, law)
        findings += of_change
    facts = Facts(law, metrics, stated.declared, program, proven)
    faults = faults_of_claims(stated.claims, facts)
    findings += check_claims(stated.claims, faults)
    findings += check_targets(stated, facts, [claim for claim, fault in zip(stated.claims, faults, strict=True) if not fault], window)
    report = Report(tuple(findings), stated.verdict)
    if report.ok:
        check_assumptions(stated, law)
    return report
