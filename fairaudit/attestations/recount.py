"""`recount`: a log read again as a statement says, and its table compared with that of the certificate, cell by cell."""

from __future__ import annotations

import json
import os
import re
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from hashlib import sha256
from pathlib import Path
from typing import Any

import numpy as np

from fairaudit.attestations.cells import TableDifference, compare_tables
from fairaudit.attestations.options import reading_of
from fairaudit.attestations.sources import take
from fairaudit.attestations.statement import Source, Statement
from fairaudit.audits.in_parts import certify_in_parts
from fairaudit.audits.reading import MOST_ROWS, Reading, read_audited, uncollected, unfit_for_parts
from fairaudit.certificates.table import Table, WrittenTable, canonical
from fairaudit.errors import InputError, ManyRowsError, TableNeeded, naming, shown
from fairaudit.inference.draws import unit_profiles
from fairaudit.inference.paired_region import listed_profiles
from fairaudit.model.law import Law
from fairaudit.model.utility import Utility
from fairaudit.tables.engines.logs import Engine
from fairaudit.tables.engines.request import Report
from fairaudit.tables.preparation import words
from fairaudit.tables.sources import is_database, source_name
from fairaudit.words import brief

__all__ = ["Recount", "Recounted", "recounted"]

Lines = Callable[[], Iterable[bytes]]
"""Gives the lines of a table, each time that it is asked."""

READ_ONLY = ("sqlite", "duckdb", "postgres", "postgresql")
"""Databases that are opened so that nothing can be written."""


@dataclass(frozen=True)
class Recounted:
    """What was found of one thing that a statement or a certificate says of a log.

    Attributes
    ----------
    what : str
        What was looked at.
    equal : bool or None
        Whether the log says the same; None where that could not be told.
    detail : str
        What the log says instead, or why it could not be told.
    """

    what: str
    equal: bool | None
    detail: str = ""


@brief
@dataclass(frozen=True)
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
    """

    findings: tuple[Recounted, ...]
    missing: tuple[str, ...] = ()
    difference: TableDifference | None = None

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
        different = [finding for finding in self.findings if finding.equal is False]
        if different:
            return f"the recount DIFFERS in {', '.join(finding.what for finding in different)}"
        if self.missing:
            return f"nothing was recounted: {', '.join(map(shown, self.missing))} {'is' if len(self.missing) == 1 else 'are'} not there"
        return "the recount of the log gives the same table, cell for cell"


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
    if "query" in statement.options:
        _check_query(statement.options["query"], query, source, spelled)
    elif query is not None:
        raise InputError(f"the statement has no query; leave {spelled('query')} away")
    reading, utility = reading_of(statement.options, spelled=spelled)
    reading = replace(reading, access=replace(reading.access, engine=engine, memory=memory))
    header = _header(document, lines)
    absent = _absent(source)
    if absent:
        return Recount((), tuple(absent))
    taken = take(source, table=reading.access.table, query=reading.access.query)
    findings, missing = _compared_sources(statement.sources, taken.sources)
    if missing:
        return Recount(tuple(findings), tuple(missing))
    with uncollected(), naming(_name(source)):
        counted = _count(source, reading, utility, report)
    taken.unchanged()
    table = counted.table(header)
    difference = None
    if table.sha256 != document["subject"]["table"]["sha256"]:
        difference = compare_tables(_lines(document, lines), table.lines())
        said = "; ".join(difference.sentences) or "the lines are the same, and are not those of the digest in the certificate"
        findings.append(Recounted("the table", False, said))
    else:
        findings.append(Recounted("the table", True))
    findings += [*_preparation(document, counted.law), *_units(document, counted)]
    return Recount(tuple(findings), (), difference)


@dataclass(frozen=True)
class _Counted:
    """A log that was read again; its table in a file, if its contexts passed by in parts."""

    law: Law
    made: Table | WrittenTable

    def table(self, header: Mapping[str, Any]) -> Table | WrittenTable:
        """The table with what no log says: the salt; and the digests of what sampling units got, if the certificate has some."""
        salt = header.get("salt")
        if isinstance(self.made, WrittenTable):
            return WrittenTable({**self.made.header, **({} if salt is None else {"salt": salt})}, self.made.file, self.made.cells)
        own = sha256(canonical(_profiles(self.made))).hexdigest() if "profiles" in header else ""
        return replace(self.made, salt=salt, profiles=dict.fromkeys(header.get("profiles", ()), own))


def _count(source: Any, reading: Reading, utility: Utility | None, report: Report | None) -> _Counted:
    """Read the log as it was read for the certificate."""
    held = not isinstance(source, (str, os.PathLike, list, tuple))
    most = None if held or unfit_for_parts(reading, {}) else MOST_ROWS
    try:
        law, worth = read_audited(source, reading, utility, report=report, most=most)
    except ManyRowsError:
        if utility is None:
            raise
        columns: dict[str, Any] = {"decision": reading.decision, "group": reading.group, "context": reading.context}
        access = reading.access
        found = certify_in_parts(
            source, utility, **columns, bins=reading.bins, table=access.table, memory=access.memory, report=report, embed_table=True
        )
        if found.partial is None:
            raise
        return _Counted(found.law, found.partial.table)
    table = worth.on(law)
    return _Counted(table.law, Table(table.law, table))


def _profiles(table: Table) -> list[Any]:
    return [*map(listed_profiles, unit_profiles(table.utility))]


def _check_query(said: str, given: str | None, source: Any, spelled: Callable[[str], str]) -> None:
    """Refuse to run a query that is not the one that was given."""
    option = spelled("query")
    if given is None:
        raise InputError(
            f"the log is the result of the query {said!r}, which is run only if you give it yourself: read it, then give {option}"
        )
    if given != said:
        raise InputError(f"{option} is not the query of the statement, which is {said!r}; give the same text")
    scheme = re.match("([a-z][a-z0-9+.-]*):", source) if is_database(source) else None
    if scheme is not None and scheme.group(1) not in READ_ONLY:
        raise InputError(
            f"a query is run again where nothing can be written: in PostgreSQL, SQLite and DuckDB; {scheme.group(1)} is none of these"
        )


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
    return [name for name, file in zip(texts, files, strict=True) if not is_database(file) and not _is_there(file)]


def _is_there(file: str) -> bool:
    import glob

    try:
        return Path(file).exists() or (glob.has_magic(file) and bool(glob.glob(file, recursive=True)))  # noqa: PTH207
    except (OSError, ValueError):
        return False


def _compared_sources(said: Sequence[Source], given: Sequence[Source]) -> tuple[list[Recounted], list[str]]:
    """Compare digests: of what has the same name, then in order; and name what was not given."""
    left = list(given)
    pairs: dict[int, Source] = {}
    for place, entry in enumerate(said):
        own = next((other for other in left if other.name == entry.name), None)
        if own is not None:
            pairs[place] = own
            left.remove(own)
    for place, _ in enumerate(said):
        if place not in pairs and left:
            pairs[place] = left.pop(0)
    if left:
        raise InputError(f"{len(given)} logs were given, and the statement has {len(said)}; leave {shown(left[0].name)} away")
    return [_of_source(said[place], pairs[place]) for place in sorted(pairs)], [e.name for i, e in enumerate(said) if i not in pairs]


def _of_source(said: Source, given: Source) -> Recounted:
    what = f"the source {shown(said.name)}"
    if said.sha256 is None:
        return Recounted(what, None, "no digest of it was recorded")
    if given.sha256 is None:
        return Recounted(what, None, f"{given.name} has no digest")
    if given.sha256 == said.sha256:
        return Recounted(what, True)
    return Recounted(
        what,
        False,
        f"{shown(given.name)} has {given.bytes} bytes and the digest {given.sha256}, recorded are {said.bytes} and {said.sha256}",
    )


def _preparation(document: Mapping[str, Any], law: Law) -> Iterator[Recounted]:
    """Compare what was done to labels, and what was left out."""
    theirs, ours = document["subject"].get("preparation", []), [dict(entry) for entry in law.preparation]
    if theirs != ours:
        alone = [
            next((words(entry) for entry in these if entry not in those), "nothing") for these, those in ((theirs, ours), (ours, theirs))
        ]
        yield Recounted("what was done to labels and rows", False, f"the certificate says: {alone[0]}; the log: {alone[1]}")
    elif ours:
        yield Recounted("what was done to labels and rows", True)


def _units(document: Mapping[str, Any], counted: _Counted) -> Iterator[Recounted]:
    """Compare what sampling units have in each cell, on which intervals rest and which the table does not show."""
    listed = [entry["units"] for entry in document.get("intervals", {}).values() if "units" in entry]
    if not listed:
        return
    law = counted.law
    own = None
    if law.units is not None:
        own = [[[n, list(rows)] for n, rows in law.units.profiles[cell]] for cell in np.flatnonzero(law.compared).tolist()]
    same = all(units == own for units in listed)
    yield Recounted("the sampling units", same, "" if same else "they have other numbers of rows in some cell")


def _name(source: Any) -> str | None:
    return source_name(source) if isinstance(source, (str, os.PathLike, list, tuple)) else None
