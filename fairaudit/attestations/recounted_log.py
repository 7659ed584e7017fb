"""A log read again as a statement says: nothing of that is run but what the one who asks has given, too, and no other file is read."""

from __future__ import annotations

import os
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from hashlib import sha256
from typing import Any

from fairaudit.attestations.making import of_table
from fairaudit.audits.audit_file import audit_of
from fairaudit.audits.certify import laid_out
from fairaudit.audits.in_parts import certify_in_parts
from fairaudit.audits.reading import MOST_ROWS, Reading, read_audited, unfit_for_parts
from fairaudit.audits.sections import with_files
from fairaudit.certificates.table import OF_LOG, Table, WrittenTable, canonical
from fairaudit.errors import InputError, ManyRowsError, naming, shown
from fairaudit.inference.draws import unit_profiles
from fairaudit.inference.paired_region import listed_profiles
from fairaudit.model.law import Law
from fairaudit.model.policy import Deployment
from fairaudit.model.utility import Utility
from fairaudit.tables.engines.request import Report
from fairaudit.tables.sources import in_database, source_name

__all__ = ["CountedLog", "audit_in", "check_query", "count_audit", "count_log"]

READ_ONLY = ("sqlite", "duckdb", "postgres", "postgresql")
"""Databases that are opened so that nothing can be written."""


@dataclass(frozen=True)
class CountedLog:
    """A log that was read again; its table in a file, if its contexts passed by in parts."""

    law: Law
    made: Table | WrittenTable
    deployment: Deployment | None = None

    def table(self, header: Mapping[str, Any], log: Mapping[str, str]) -> Table | WrittenTable:
        """The table with what no log says: the salt, digests of units if the certificate has some, and those of what it says of the log."""
        salt = header.get("salt")
        if isinstance(self.made, WrittenTable):
            kept = {key: value for key, value in self.made.header.items() if key not in OF_LOG}
            return WrittenTable({**kept, **({} if salt is None else {"salt": salt}), **log}, self.made.file, self.made.cells)
        own = sha256(canonical(_profiles(self.made))).hexdigest() if "profiles" in header else ""
        return replace(self.made, salt=salt, profiles=dict.fromkeys(header.get("profiles", ()), own), log=log)


def count_log(source: Any, reading: Reading, utility: Utility | None, report: Report | None) -> CountedLog:
    """Read a log as it was read for the certificate.

    Parameters
    ----------
    source : path, URL, sequence of them, or a table in memory
        The log.
    reading, utility
        How, as `fairaudit.attestations.options.reading_of` found it.
    report : callable or None
        Is told how far the work is.

    Raises
    ------
    InputError
        If it cannot be read so.
    """
    held = not isinstance(source, (str, os.PathLike, list, tuple))
    most = None if held or unfit_for_parts(reading, {}) else MOST_ROWS
    try:
        law, worth = read_audited(source, reading, utility, report=report, most=most)
    except ManyRowsError:
        if utility is None:
            raise
        columns: dict[str, Any] = {"decision": reading.decision, "group": reading.group, "context": reading.context}
        access = reading.access
        with naming(_name(source)):
            found = certify_in_parts(
                source, utility, **columns, bins=reading.bins, table=access.table, memory=access.memory, report=report, embed_table=True
            )
        if found.partial is None:
            raise
        return CountedLog(found.law, found.partial.table)
    table = worth.on(law)
    return CountedLog(table.law, Table(table.law, table))


def audit_in(options: Mapping[str, Any]) -> Mapping[str, Any] | None:
    """Find the sections of an audit file that make a table; nothing, where the options are those of a table.

    Raises
    ------
    InputError
        If there is something else beside them or in them.
    """
    if "audit" not in options:
        return None
    for name in options:
        if name != "audit":
            raise InputError(f"the options have {shown(name)} beside an audit file, which says that itself")
    audit = options["audit"]
    if not isinstance(audit, dict):
        raise InputError(f"the options have audit {shown(audit)}; the sections of an audit file are accepted")
    making = of_table(audit)
    for name, section in audit.items():
        if name not in making:
            raise InputError(f"the options have the section {shown(name)} of an audit file, which does not make a table")
        for key in section if isinstance(section, dict) else ():
            if key not in making[name]:
                raise InputError(f"options have {shown(key)} in the section {shown(name)} of an audit file, which does not make a table")
    return audit


def count_audit(audit: Mapping[str, Any], files: Mapping[str, str]) -> CountedLog:
    """Read what an audit file described, its files being those that were given.

    Raises
    ------
    InputError
        If it names another file, or cannot be read.
    """

    def path_of(name: str) -> str:
        path = files.get(name)
        if path is None:
            raise InputError(f"the options name the file {shown(name)}, which is none of the logs")
        return os.path.abspath(path)  # noqa: PTH100

    found = audit_of(with_files(audit, path_of), signed=True)  # nothing is read but what was given
    subject, table = laid_out(found.subject, found.utility)
    if isinstance(subject, Deployment):
        return CountedLog(subject.law, Table(subject.policy.law, table, subject), subject)
    return CountedLog(subject, Table(subject, table))


def _profiles(table: Table) -> list[Any]:
    return [*map(listed_profiles, unit_profiles(table.utility))]


def check_query(said: str, given: str | None, source: Any, spelled: Callable[[str], str]) -> None:
    """Refuse to run a query that is not the one that was given, and any where something could be written.

    Raises
    ------
    InputError
        If it is so.
    """
    option = spelled("query")
    if given is None:
        raise InputError(
            f"the log is the result of the query {said!r}, which is run only if you give it yourself: read it, then give {option}"
        )
    if given != said:
        raise InputError(f"{option} is not the query of the statement, which is {said!r}; give the same text")
    scheme = source.partition(":")[0] if in_database(source) else ""
    if scheme and scheme not in READ_ONLY:
        raise InputError(f"a query is run again where nothing can be written: in PostgreSQL, SQLite and DuckDB; {scheme} is none of these")


def _name(source: Any) -> str | None:
    return source_name(source) if isinstance(source, (str, os.PathLike, list, tuple)) else None
