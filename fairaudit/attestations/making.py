"""A statement made: what was counted, of which sources, for which certificate."""

from __future__ import annotations

import hashlib
import os
from collections.abc import Mapping, Sequence
from datetime import UTC, datetime
from fractions import Fraction
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal, Protocol

from fairaudit import __version__
from fairaudit.attestations.options import options_of
from fairaudit.attestations.sources import Taken, bare_name, taken_of
from fairaudit.attestations.statement import RUN, Rows, Stated, Statement, Subject, split_period
from fairaudit.attestations.strict import check_text
from fairaudit.audits.sections import ATTESTATION_KEYS, with_files
from fairaudit.certificates.certificate import Certificate
from fairaudit.errors import InputError, shown
from fairaudit.files import write_together
from fairaudit.model.law import Law
from fairaudit.model.policy import Deployment
from fairaudit.tables.preparation import amount_of
from fairaudit.words import plain

if TYPE_CHECKING:
    from fairaudit.audits.result import Result

__all__ = [
    "Counted",
    "audit_options",
    "counted_rows",
    "of_table",
    "rows_of_source",
    "runs_of",
    "stated_of",
    "statement_of",
    "write_attested",
]

VALUES = ("values", "column", "table")
"""What a section [utility] says of what decisions are worth."""


class Counted(Protocol):
    """What was found of a table that was read: a `Result`, or a `ProxyAudit`."""

    @property
    def law(self) -> Law:
        """The table; behind filters the law that they induce."""

    @property
    def certificate(self) -> Certificate:
        """The certificate."""


def stated_of(given: Mapping[str, Any], spelled: Mapping[str, str] | None = None) -> Stated:
    """What an issuer says, by the names of its options; those that are None were not given.

    Parameters
    ----------
    given : mapping
        Texts under ``issuer``, ``contact``, ``title``, ``system``, ``system_version``, and ``period``, such as ``2025-01-01/2025-12-31``.
    spelled : mapping of str to str, optional
        How the one who asks writes them, for messages.

    Raises
    ------
    InputError
        If one of them has no place in a statement.

    Examples
    --------
    >>> stated_of({"issuer": "A. Auditor", "period": "2025-01-01/2025-12-31"}).period
    ('2025-01-01', '2025-12-31')
    """
    names = {name: (spelled or {}).get(name, name) for name in ATTESTATION_KEYS}
    texts: dict[str, Any] = {name: given[name] for name in ATTESTATION_KEYS if given.get(name) is not None}
    for name, text in texts.items():
        if not isinstance(text, str) or not text.strip():
            raise InputError(f"{names[name]} is {shown(text)}; a text is accepted")
        check_text(text, names[name])
    for part, whole in (("contact", "issuer"), ("system_version", "system")):
        if part in texts and whole not in texts:
            raise InputError(f"{names[part]} goes with {names[whole]}; give both")
    if "period" in texts:
        texts["period"] = split_period(texts["period"], names["period"])
    return Stated(**texts)


def counted_rows(result: Counted) -> Rows:
    """How much was read, counted and dropped, as the certificate has it.

    Parameters
    ----------
    result : Result or ProxyAudit
        What was found.

    Raises
    ------
    InputError
        If it counts parts of decisions of a policy, of which a certificate says no numbers.

    Examples
    --------
    >>> import fairaudit as fa
    >>> log = {"hired": ["yes", "no", "yes", "no", "yes"], "sex": ["f", "f", "m", "m", ""]}
    >>> rows = counted_rows(fa.audit(log, decision="hired", group="sex", utility="yes", missing="drop"))
    >>> rows.read, rows.counted, rows.dropped
    (Fraction(5, 1), Fraction(4, 1), {'missing label': Fraction(1, 1)})
    """
    deployment: Deployment | None = getattr(result, "deployment", None)
    law = result.law if deployment is None else deployment.policy.law
    unit: Literal["decisions", "rows"] = "decisions" if law.kind == "counts" else "rows"
    if unit == "decisions" and deployment is not None and not law.whole:
        raise InputError(
            "parts of decisions were counted of a policy, of which no attestation is made; give whole counts, or probabilities"
        )
    dropped: dict[str, Fraction] = {}
    for entry in law.preparation:
        if entry["step"] == "left out":
            dropped[entry["reason"]] = dropped.get(entry["reason"], Fraction(0)) + Fraction(amount_of(entry)[0])
    if law.evaluation is not None and law.evaluation.lost:
        dropped["error"] = Fraction(law.evaluation.lost)
    if unit == "rows":
        if law.rows_read is None:
            raise InputError("nobody counted the rows of the table, so that no attestation can say how many there were")
        counted = Fraction(law.rows_read)
    else:
        counted = Fraction(sum(law.totals.tolist()), law.scale)
        if law.unknown is not None:
            counted += Fraction(sum(law.unknown.weights.ravel().tolist()), law.scale)
    return Rows(unit, counted + sum(dropped.values()), counted, dropped)


def rows_of_source(result: Counted, rows: Rows, options: Mapping[str, Any]) -> int | None:
    """How many rows the source of a table had, where that can be known of what was counted."""
    deployment: Deployment | None = getattr(result, "deployment", None)
    law = result.law if deployment is None else deployment.policy.law
    said = options.get("audit", {})
    held = {**options, **said.get("law", {}), **said.get("policy", {})}
    if law.evaluation is not None:
        return law.evaluation.read
    if law.rows_read is None or "wide" in held:
        return None
    if rows.unit == "decisions" and "count" in held:  # which says of what was dropped how many decisions it was, not how many rows
        return None if rows.dropped else law.rows_read
    return law.rows_read + int(sum(rows.dropped.values()))


def runs_of(law: Law) -> dict[str, dict[str, str]]:
    """What evaluation logs say of themselves, by where they are, in texts that a statement may hold."""
    found: dict[str, dict[str, str]] = {}
    if law.evaluation is None:
        return found
    from fairaudit.tables.evaluations.detection import files_of_log

    for path, run in law.evaluation.runs:
        said = {key: plain(getattr(run, key))[:400] for key in RUN}
        if said["format"]:
            found[os.path.realpath((files_of_log(path) or [path])[0])] = {key: text for key, text in said.items() if text.strip()}
    return found


def audit_options(audit: Mapping[str, Any]) -> dict[str, Any]:
    """What makes the table in the sections of an audit file, as data, with its files by their names."""
    return {name: _data(entry) for name, entry in with_files(of_table(audit), lambda name: Path(name).name).items()}


def of_table(audit: Mapping[str, Any]) -> dict[str, Any]:
    """The sections of an audit file without what makes no table: targets, confidence, what is declared or only stated."""
    kept = {name: entry for name, entry in audit.items() if name in ("law", "policy", "filter", "population")}
    for about in kept.keys() & {"law", "policy"}:
        kept[about] = _without(kept[about], ("unknown_share", "hidden_context", "max_drift"))
    if "utility" in audit:
        values = audit["utility"]
        kept["utility"] = {name: values[name] for name in VALUES if name in values} if isinstance(values, dict) else values
    return kept


def _without(section: Any, keys: Sequence[str]) -> Any:
    return {name: entry for name, entry in section.items() if name not in keys} if isinstance(section, dict) else section


def _data(value: Any) -> Any:
    if isinstance(value, dict):
        return {name: _data(entry) for name, entry in value.items()}
    if isinstance(value, list):
        return [_data(entry) for entry in value]
    return value if isinstance(value, (bool, str)) or (isinstance(value, int) and 0 <= value < 10**18) else str(value)


def statement_of(
    result: Counted, names: Sequence[str], taken: Taken, *, options: Mapping[str, Any], command: Sequence[str], stated: Stated
) -> Statement:
    """Make the statement of a certificate that is about to be written.

    Parameters
    ----------
    result : Result or ProxyAudit
        What was found.
    names : sequence of str
        The files to which the certificate goes.
    taken : Taken
        The sources, as they were before they were read.
    options : mapping
        What makes the same table again.
    command : sequence of str
        What was run.
    stated : Stated
        What the issuer says.

    Raises
    ------
    InputError
        If a source was changed meanwhile.
    """
    taken.unchanged()
    document, rows = result.certificate.document, counted_rows(result)
    digest = hashlib.sha256(result.certificate.text.encode("ascii")).hexdigest()
    return Statement(
        subjects=tuple(Subject(Path(name).name, digest) for name in names),
        table=document["subject"]["table"]["sha256"],
        sources=taken.with_rows(rows_of_source(result, rows, options), runs_of(result.law)),
        rows=rows,
        options=options,
        command=tuple(command),
        versions={"fairaudit": __version__},
        issued_at=_moment(),
        stated=stated,
    )


def _moment() -> str:
    """Now; or what SOURCE_DATE_EPOCH says it is, by which whoever makes files again gets the same bytes."""
    said = os.environ.get("SOURCE_DATE_EPOCH")
    if not said:
        moment = datetime.now(UTC)
    elif said.isascii() and said.isdecimal() and len(said) <= 11:  # to the year 5138
        moment = datetime.fromtimestamp(int(said), UTC)
    else:
        raise InputError(f"SOURCE_DATE_EPOCH is {shown(said)}; whole seconds since 1970 are accepted, such as 1767225600")
    return moment.strftime("%Y-%m-%dT%H:%M:%SZ")


def write_attested(
    result: Result, path: str | os.PathLike[str], attestation: str | os.PathLike[str], given: Mapping[str, Any]
) -> list[Path]:
    """Write the certificate of a result, and a statement of where it comes from: both, or neither.

    Parameters
    ----------
    result : Result
        What `fairaudit.audit` gave.
    path, attestation : path
        Where they go.
    given : mapping
        What the issuer says (`stated_of`), before what an audit file says in its section ``[attestation]``.

    Raises
    ------
    InputError
        If a file cannot be written or is one of those that were read, if one of those was changed since, or a text has no place in a
        statement.
    """
    origin = result.origin
    of_file = {} if origin is None or origin.audit is None else origin.audit.get("attestation", {})
    stated = stated_of({**of_file, **{name: text for name, text in given.items() if text is not None}})
    for name, what in ((path, "a certificate"), (attestation, "an attestation")):
        if Path(name).suffix.lower() != ".json":
            raise InputError(f"{os.fspath(name)} does not end in .json, as {what} does; name a file to write")
    beside = result.certificate.files(path)
    written = [*(os.path.realpath(target) for target, _ in beside), os.path.realpath(attestation)]
    if len({*written}) < len(written):
        raise InputError(f"{os.fspath(attestation)} is a file of the certificate; name another file for the attestation")
    reading = None if origin is None else origin.reading
    files = None if origin is None else origin.files
    if files is not None:
        files.refuse(written)
    options: dict[str, Any] = {}
    if origin is not None and origin.audit is not None:
        options = {"audit": audit_options(origin.audit)}
    elif origin is not None and reading is not None:
        options = options_of(reading, origin.utility, positive=origin.positive)
    access = {} if reading is None else {"table": reading.access.table, "query": reading.access.query}
    taken = taken_of(files, **access)
    names = () if files is None else tuple(map(bare_name, (files.others[:1] or files.data) if options.get("audit") else files.data))
    made = statement_of(result, [os.fspath(path)], taken, options=options, command=("fairaudit.audit", *names), stated=stated)
    write_together([(Path(attestation), [made.text.encode("ascii")]), *beside])
    return [Path(path), Path(attestation)]
