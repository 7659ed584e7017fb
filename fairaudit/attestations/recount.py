"""`recount`: a log read again as a statement says, and its table compared with that of the certificate, cell by cell."""

from __future__ import annotations

import json
import os
import re
from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass, field, replace
from functools import partial
from hashlib import sha256
from pathlib import Path
from typing import Any

import numpy as np

from fairaudit.arguments import answered
from fairaudit.attestations.making import counted_rows, rows_of_source, runs_of
from fairaudit.attestations.options import reading_of
from fairaudit.attestations.recounted_log import CountedLog, audit_in, check_query, count_audit, count_log
from fairaudit.attestations.recounted_sources import Pairs, Recounted, compare_rows, compare_sources, files_of_audit, pairs_of, with_joined
from fairaudit.attestations.sources import Taken, take
from fairaudit.attestations.statement import Rows, Statement
from fairaudit.attestations.table_difference import TableDifference, compare_tables
from fairaudit.attestations.verification import read_attestation, signed_by, stated_in
from fairaudit.certificates.certificate import FORMAT, Certificate
from fairaudit.certificates.evaluation import evaluation_entry
from fairaudit.certificates.table import Table, canonical, log_digests
from fairaudit.errors import FalseCertificate, InputError, TableNeeded, shown
from fairaudit.exact.collecting import uncollected
from fairaudit.measures.rates import given_truth
from fairaudit.model.law import Law
from fairaudit.model.layout import Units
from fairaudit.tables.engines.logs import Engine
from fairaudit.tables.engines.request import Report
from fairaudit.tables.number_form import TEXT_FORM
from fairaudit.tables.preparation import undisclosed, words
from fairaudit.tables.sources import Source as Tables
from fairaudit.tables.sources import in_database, is_database, source_name
from fairaudit.verified.verification import CertificateLike, opened, table_lines, verification_of
from fairaudit.words import brief

__all__ = ["Recount", "attested_document", "recount", "recounted"]

NOT_SHOWN = "No recount shows whether the log is what really happened, or whether what the attestation only states is true."

Lines = Callable[[], Iterable[bytes]]
"""Gives the lines of a table, each time that it is asked."""

UNSAID = ("count", "probability", "weight", "wide", "total", "unit", "skip", "table", "query", *TEXT_FORM)
"""Options that make another table of the same log, and of which its certificate says nothing."""


@brief
@dataclass(frozen=True, repr=False)
class Recount:
    """A log counted again, beside the certificate that was made of it.

    Attributes
    ----------
    findings : tuple of Recounted
        What was compared.
    missing : tuple of str
        Sources of the statement that are not there, so that nothing was counted.
    difference : TableDifference or None
        In what the tables differ, if they do.
    read_with : mapping of str to str
        How the log was read, so far as the certificate does not say it.

    Examples
    --------
    >>> Recount((Recounted("the table", False, "a cell differs"),)).sentence
    'The recount DIFFERS in the table.'
    """

    findings: tuple[Recounted, ...]
    missing: tuple[str, ...] = ()
    difference: TableDifference | None = None
    read_with: Mapping[str, str] = field(default_factory=dict)

    @property
    def ok(self) -> bool:
        """Whether the log was counted again, and says the same."""
        return not self.missing and all(finding.equal is not False for finding in self.findings)

    def __bool__(self) -> bool:
        """Whether it is `ok`."""
        return self.ok

    @property
    def exit_code(self) -> int:
        """0 if all is the same, 1 if something differs, 3 if a source is not there."""
        return 1 if any(finding.equal is False for finding in self.findings) else 3 if self.missing else 0

    @property
    def sentence(self) -> str:
        """What was found, in a sentence."""
        different = [finding.what for finding in self.findings if finding.equal is False]
        if different:
            return f"The recount DIFFERS in {', '.join(different)}."
        if self.missing:
            verb = "is" if len(self.missing) == 1 else "are"
            return f"Nothing was recounted: {', '.join(map(shown, self.missing))} {verb} not there."
        return "The log was counted again as the attestation says, and gives the same table, cell for cell."

    @property
    def paragraph(self) -> str:
        """What was found, and what no recount shows."""
        unseen = [finding.what for finding in self.findings if finding.equal is None]
        rest = [f"What could not be told: {', '.join(unseen)}."] if unseen else []
        read = ", ".join(f"{name} {text}" for name, text in self.read_with.items())
        said = (
            [f"It was read with {read}, which the certificate does not say."]
            if read and self.difference is None and not self.missing
            else []
        )
        return " ".join([self.sentence, *said, *rest, NOT_SHOWN] if self.ok else [self.sentence, *said, *rest])


@answered
def recount(
    certificate: CertificateLike,
    attestation: bytes | str | os.PathLike[str],
    source: Tables,
    *,
    table: str | os.PathLike[str] | None = None,
    key: str | os.PathLike[str] | None = None,
    query: str | None = None,
    engine: Engine = "auto",
    memory: str | None = None,
) -> Recount:
    """Count a log again as an attestation says, and compare its table with that of the certificate, cell by cell.

    Certificate and attestation are checked first. Nothing that the attestation says is run: not its command, and its query only if the same
    text is given.

    Parameters
    ----------
    certificate : Certificate, Result, mapping, bytes or path
        The certificate.
    attestation : path or bytes
        What `fairaudit certify --attest` wrote beside it, signed or not.
    source : path, paths, URL, frame or mapping
        The log: what `fairaudit.audit` takes.
    table : path, optional
        The file of the canonical table, where the certificate does not hold it.
    key : path, optional
        The signer's public key, by which the attestation must be signed.
    query : str, optional
        Of a database: the query of the attestation, word for word.
    engine, memory
        As for `fairaudit.read_log`.

    Returns
    -------
    Recount
        What is equal, and where the tables differ.

    Raises
    ------
    FalseCertificate
        If a statement of the certificate or of the attestation is false.
    InputError
        If something cannot be read, the attestation is not signed by the key, or it does not say how to make the table again.
    TableNeeded
        If the certificate does not hold its table, and none was given.

    Examples
    --------
    >>> from fairaudit.attestations.making import stated_of, statement_of
    >>> from fairaudit.audits.from_table import audit
    >>> log = {"hired": ["yes", "no", "yes", "no"], "sex": ["f", "f", "m", "m"]}
    >>> result = audit(log, decision="hired", group="sex", utility="yes")
    >>> options = {"decision": "hired", "group": ["sex"], "utility": {"yes": "1"}}
    >>> made = statement_of(result, ["c.json"], take(log), options=options, command=["certify"], stated=stated_of({}))
    >>> recount(result, made.text.encode(), log).ok
    True
    >>> found = recount(result, made.text.encode(), {**log, "hired": ["yes", "yes", "yes", "no"]})
    >>> print(found.difference.first.sentence)
    sex='f': decision 'no' 1 in the certificate, 0 in the log; decision 'yes' 1 in the certificate, 2 in the log

    References
    ----------
    docs/attestation.md
    """
    name = "the attestation" if isinstance(attestation, bytes) else os.fspath(attestation)
    raw = attestation if isinstance(attestation, bytes) else read_attestation(attestation)
    signed = None if key is None else signed_by(raw, key, name)
    if signed is not None and signed.payload is None:
        raise InputError(f"{name}: {signed.why}")
    own = opened(certificate, table)
    found = verification_of(own, attestation=raw if signed is None else signed)
    if found.false:
        raise FalseCertificate(f"{found.sentence}: {found.false[0].statement}")
    statement, _ = stated_in(raw if signed is None or signed.payload is None else signed.payload, name)
    made = certificate if isinstance(certificate, Certificate) else getattr(certificate, "certificate", None)
    held = made.table.lines if isinstance(made, Certificate) and made.table is not None else None
    lines = held if table is None else partial(table_lines, Path(table))
    return recounted(own.document, lines, statement, source, query=query, engine=engine, memory=memory)


def recounted(
    document: Mapping[str, Any],
    lines: Lines | None,
    statement: Statement,
    source: Any,
    *,
    query: str | None = None,
    engine: Engine = "auto",
    memory: str | None = None,
    report: Report | None = None,
    spelled: Callable[[str], str] = str,
) -> Recount:
    """Read a log again as a statement says, and compare its table with that of the certificate.

    Nothing that the statement says is run: not its command, and its query only if the same text is given.

    Parameters
    ----------
    document : mapping
        The certificate, which has been checked.
    lines : callable or None
        Gives the lines of its table, where it does not hold it.
    statement : Statement
        What is said of how the table was made.
    source : path, URL, sequence of them, or a table in memory
        The log.
    query : str, optional
        The query whose result is the log: the same text as in the statement.
    engine, memory, report
        As for `fairaudit.tables.engines.logs.read_log`.
    spelled : callable
        How the one who asks writes the name of an option, for messages.

    Raises
    ------
    InputError
        If the log cannot be read, or what the statement says makes no table.
    TableNeeded
        If the table of the certificate is not at hand.
    """
    options = statement.options
    source = source[0] if isinstance(source, (list, tuple)) and len(source) == 1 else source
    if document.get("format") != FORMAT:
        raise InputError(f"a certificate of the format {shown(document.get('format'))} is not recounted; one of {FORMAT} is")
    if not options:
        raise InputError(
            "the statement does not say how its table was made, as of a monitor or of probabilities of groups; nothing can be recounted"
        )
    if "query" in options:
        check_query(options["query"], query, source, spelled)
    elif query is not None:
        raise InputError(f"the statement has no query; leave {spelled('query')} away")
    audit = audit_in(options)
    said = None if audit is not None else reading_of(options, spelled=spelled)
    header = _header(document, lines)
    if in_database(source) and said is not None and not {"table", "query"} & {*options}:
        raise InputError("the attestation is of files, and says of no table or query of a database; write the log to a file, and give that")
    if absent := _absent(source):
        return Recount((), tuple(absent))
    taken = take(source, table=options.get("table"), query=options.get("query"))
    pairs = pairs_of(statement.sources, taken.sources, audit)
    files = files_of_audit(statement.sources, pairs, taken) if audit is not None or "join" in options else {}
    findings = compare_sources(statement.sources, pairs, audit, files)
    if missing := [entry.name for place, entry in enumerate(statement.sources) if place not in pairs]:
        return Recount(tuple(findings), tuple(missing))
    try:
        with uncollected():
            if said is None:
                counted = count_audit(audit or {}, files)
            else:
                reading, utility = said
                source, extraction = with_joined(source, reading.access.extraction, files)
                access = replace(reading.access, engine=engine, memory=memory, extraction=extraction)
                counted = count_log(source, replace(reading, access=access), utility, report)
    except InputError as error:
        if all(finding.equal is not False for finding in findings):
            raise
        return Recount((*findings, Recounted("the table", False, f"of this log there is none: {error}")))  # which is another log anyway
    taken.unchanged()
    return _compared(document, lines, statement, counted, header, [*findings, *_runs(statement, pairs, taken, counted)])


def _compared(
    document: Mapping[str, Any],
    lines: Lines | None,
    statement: Statement,
    counted: CountedLog,
    header: Mapping[str, Any],
    findings: list[Recounted],
) -> Recount:
    """Compare what was counted with the certificate and the statement, after what was found of the sources."""
    table = counted.table(header, log_digests(document["subject"]))  # what it says of the log is compared by itself
    difference = None
    if table.sha256 != document["subject"]["table"]["sha256"]:
        difference = compare_tables(_lines(document, lines), table.lines())
        detail = "; ".join(difference.sentences) or "the lines are the same, and are not those of the digest in the certificate"
        findings.append(Recounted("the table", False, detail))
    else:
        findings.append(Recounted("the table", True))
    findings += [*_preparation(document, counted.law), *_evaluation(document, counted.law)]
    findings += _positive(document, counted, statement.options)
    findings += [*_units(document, counted), *_rows(statement, counted)]
    unsaid = _unsaid(statement.options)
    if "unit" in document["subject"].get("evaluation", {}):
        unsaid.pop("unit", None)
    return Recount(tuple(findings), (), difference, unsaid)


def _unsaid(options: Mapping[str, Any]) -> dict[str, str]:
    """How a log was read, so far as a certificate does not say it."""
    sections = options.get("audit", {})
    of_audit = {**sections.get("law", {}), **sections.get("policy", {}), "table": None}
    said = of_audit if sections else options
    return {name: shown(said[name], 1000) for name in UNSAID if said.get(name)}


def _header(document: Mapping[str, Any], lines: Lines | None) -> Mapping[str, Any]:
    """First line of the certificate's table."""
    held = document["subject"]["table"].get("header")
    if held is None and lines is None:
        raise TableNeeded("the certificate does not hold its table; give the file of the table")
    try:
        found = held if held is not None or lines is None else json.loads(next(iter(lines()), b""))
    except ValueError:
        found = None
    if not isinstance(found, dict):
        raise InputError("this is no table of a certificate; fairaudit verify says what is wrong with it")
    return found


def attested_document(certificate: CertificateLike, statement: Statement) -> dict[str, Any]:
    """Open a certificate that was checked, and make sure that it is still the one that the statement is about.

    Raises
    ------
    InputError
        If it is another one.
    """
    found = opened(certificate)
    if sha256(found.raw).hexdigest() not in {subject.sha256 for subject in statement.subjects}:
        raise InputError(f"{found.name} was changed while it was checked; run this again when nobody writes to it")
    return found.document


def _lines(document: Mapping[str, Any], lines: Lines | None) -> Iterator[bytes]:
    """The lines of the certificate's table."""
    held = document["subject"]["table"]
    if "header" in held:
        yield canonical(held["header"])
        yield from map(canonical, held["rows"])
    elif lines is not None:
        yield from lines()


def _absent(source: Any) -> list[str]:
    """Files among the logs that are not there."""
    given = [source] if isinstance(source, (str, os.PathLike)) else source if isinstance(source, (list, tuple)) else []
    texts = [os.fspath(name) for name in given]
    files = [re.sub("^(sqlite|duckdb|delta):(//(?=/))?", "", name) if not Path(name).exists() else name for name in texts]
    return [source_name(name) for name, file in zip(texts, files, strict=True) if not is_database(file) and not _is_there(file)]


def _is_there(file: str) -> bool:
    import glob

    try:
        return Path(file).exists() or (glob.has_magic(file) and bool(glob.glob(file, recursive=True)))  # noqa: PTH207
    except (OSError, ValueError):
        return False


def _rows(statement: Statement, counted: Any) -> Iterator[Recounted]:
    """Compare how much was read, counted and dropped, and how many rows each source had, where that was recorded."""
    found = counted_rows(counted)
    yield _amounts_of(statement, found)
    options = statement.options
    joined = options.get("join", {}).get("file")
    yield from compare_rows(statement.sources, audit_in(options), rows_of_source(counted, found, options), joined)


def _amounts_of(statement: Statement, found: Rows) -> Recounted:
    what = "how much was read, counted and dropped"
    if found != statement.rows:
        said = [f"{_amounts(rows)} in the {where}" for rows, where in ((statement.rows, "attestation"), (found, "log"))]
        return Recounted(what, False, "; ".join(said))
    return Recounted(what, True)


def _amounts(rows: Rows) -> str:
    dropped = ", ".join(f"{shown(reason)} {amount}" for reason, amount in rows.dropped.items())
    return f"{rows.read} {rows.unit} read, {rows.counted} counted, dropped {dropped or 'none'}"


def _preparation(document: Mapping[str, Any], law: Law) -> Iterator[Recounted]:
    """Compare what was done to labels, and what was left out."""
    theirs = document["subject"].get("preparation", [])
    hidden = any(entry.get("groups", ()) is None for entry in theirs)  # where the table is not disclosed
    ours = [undisclosed(entry) if hidden else dict(entry) for entry in law.preparation]
    if theirs != ours:
        alone = [
            next((words(entry) for entry in these if entry not in those), "nothing") for these, those in ((theirs, ours), (ours, theirs))
        ]
        yield Recounted("what was done to labels and rows", False, f"the certificate says: {alone[0]}; the log: {alone[1]}")
    elif ours:
        yield Recounted("what was done to labels and rows", True)


def _evaluation(document: Mapping[str, Any], law: Law) -> Iterator[Recounted]:
    """Compare how answers were found in an evaluation log, and how many of them decide nothing."""
    theirs, what = document["subject"].get("evaluation"), "how answers were read"
    cells = theirs is None or theirs["cells"] is not None
    ours = None if law.evaluation is None else evaluation_entry(law, law.evaluation, cells=cells)
    if theirs == ours:
        yield from [Recounted(what, True)] if ours is not None else []
        return
    said = theirs or {}
    name = next((key for key in {**said, **(ours or {})} if said.get(key) != (ours or {}).get(key)), "")
    detail = f"the certificate says of {name}: {shown(said.get(name), 400)}; the log: {shown((ours or {}).get(name), 400)}"
    yield Recounted(what, False, detail)


def _runs(statement: Statement, pairs: Pairs, taken: Taken, counted: CountedLog) -> Iterator[Recounted]:
    """Compare what each evaluation log says of itself with what the statement says that it does."""
    runs = runs_of(counted.law)
    own = {source.name: runs.get(place, {}) for source, place in zip(taken.sources, taken.places, strict=True)}
    for place, given in pairs.items():
        entry = statement.sources[place]
        if given is None or not (entry.run or own.get(given.name)):
            continue
        ours = own.get(given.name, {})
        detail = "" if ours == entry.run else f"the attestation has {shown(dict(entry.run), 400)}; the log {shown(ours, 400)}"
        yield Recounted(f"what {shown(entry.name)} says of its run", not detail, detail)


def _positive(document: Mapping[str, Any], counted: CountedLog, options: Mapping[str, Any]) -> Iterator[Recounted]:
    """Compare which decisions and which true label are positive, of which the table says nothing."""
    sections = options.get("audit", {"law": options})
    said, theirs = sections.get("law", {}).get("positive"), document["subject"].get("positive")
    if said is None and theirs is None:
        return
    what = "what is positive"
    try:
        found = given_truth(counted.law, counted.made.utility, said) if isinstance(counted.made, Table) else None
    except InputError as error:
        yield Recounted(what, False, str(error))
        return
    ours = None if found is None else {"decision": list(found.positive.decision), "truth": found.positive.truth}
    detail = f"the certificate has {shown(theirs)}; by the attestation it is {shown(ours)}"
    yield Recounted(what, True) if ours is not None and ours == theirs else Recounted(what, False, detail)


def _units(document: Mapping[str, Any], counted: CountedLog) -> Iterator[Recounted]:
    """Compare what sampling units have in each cell, on which intervals rest and which the table does not show."""
    intervals, units, law = document.get("intervals", {}), counted.law.units, counted.law
    listed = [entry["units"] for entry in intervals.values() if "units" in entry]
    own = None
    if units is not None:
        if wrong := [name for name, entry in intervals.items() if _counts_rows(name, entry, units)]:
            detail = f"the certificate's interval of {shown(wrong[0])} takes rows as independent draws, and units of the log have several"
            yield Recounted("the sampling units", False, detail)
            return
        own = [[[n, list(rows)] for n, rows in units.profiles[cell]] for cell in np.flatnonzero(law.compared).tolist()]
    if listed:
        same = all(entry == own for entry in listed)
        yield Recounted("the sampling units", same, "" if same else "they have other numbers of rows in some cell")


def _counts_rows(name: str, entry: Mapping[str, Any], units: Units) -> bool:
    """Whether an interval takes rows as independent draws that are of one unit, which none does that was made of units."""
    if entry.get("independent") and units.spanning:
        return True
    if name.startswith("local"):
        return units.repeated and "units" not in entry and entry.get("region") != "paired"
    return not units.once_per_group
