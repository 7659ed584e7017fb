"""Sources of a statement beside the files that are given for a recount: which is which, and whether they are the same."""

from __future__ import annotations

import os
from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import chain
from pathlib import Path
from typing import Any

from fairaudit.attestations.making import audit_options
from fairaudit.attestations.sources import Taken
from fairaudit.attestations.statement import Source
from fairaudit.audits.origin import names_of
from fairaudit.audits.sections import files_in
from fairaudit.errors import InputError, shown
from fairaudit.files import read_toml
from fairaudit.tables.evaluations.extraction import Extraction
from fairaudit.tables.sources import is_audit_file
from fairaudit.words import noun

__all__ = ["Pairs", "Recounted", "compare_rows", "compare_sources", "files_of_audit", "pairs_of", "with_joined"]

Pairs = Mapping[int, Source | None]
"""For each source of a statement, by its place, what was given for it; None for an audit file, which need not be given."""


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

    @property
    def line(self) -> str:
        """What was looked at, and what the log says instead."""
        return f"{self.what}: {self.detail}" if self.detail else self.what


def pairs_of(said: Sequence[Source], given: Sequence[Source], audit: Mapping[str, Any] | None) -> dict[int, Source | None]:
    """Find for each source of a statement what was given for it: what has its name and digest, then its digest, its name, then in order.

    Parameters
    ----------
    said, given : sequence of Source
        The sources of the statement, and the files that were given.
    audit : mapping or None
        The sections of an audit file; that file itself need not be given, because the statement has what of it makes the table.

    Raises
    ------
    InputError
        If more was given than there are sources.
    """
    left, pairs = list(given), dict[int, Source | None]()

    def take(same: Callable[[Source, Source], bool]) -> None:
        for place, entry in enumerate(said):
            own = None if place in pairs else next((other for other in left if same(entry, other)), None)
            if own is not None:
                pairs[place] = own
                left.remove(own)

    take(lambda one, other: one.name == other.name and one.sha256 == other.sha256)
    take(lambda one, other: one.sha256 == other.sha256 is not None)
    take(lambda one, other: one.name == other.name)
    for place, entry in enumerate(said):
        if place not in pairs and audit is not None and _is_audit_file(entry, audit):
            pairs[place] = None
    for place, _ in enumerate(said):
        if place not in pairs and left:
            pairs[place] = left.pop(0)
    if left:
        raise InputError(f"{len(given)} logs were given, and the statement has {len(said)}; leave {shown(left[0].name)} away")
    return {place: pairs[place] for place in sorted(pairs)}


def _is_audit_file(source: Source, audit: Mapping[str, Any]) -> bool:
    return is_audit_file(source.name) and source.name not in files_in(audit)


def files_of_audit(said: Sequence[Source], pairs: Pairs, taken: Taken) -> dict[str, str]:
    """Give the path of what was given for each file of an audit; names have to be different, because folders are not recorded.

    Raises
    ------
    InputError
        If they are not.
    """
    paths = list(chain.from_iterable(taken.files.listed.values() if taken.files else ()))
    for names in ([entry.name for entry in said], [Path(path).name for path in paths]):
        for name, count in Counter(names).items():
            if count > 1:
                raise InputError(f"two files of the audit are called {shown(name)}, which cannot be told apart; nothing is recounted")
    held = {Path(path).name: path for path in paths}
    return {said[place].name: held[given.name] for place, given in pairs.items() if given is not None and given.name in held}


def with_joined(source: Any, asked: Extraction, files: Mapping[str, str]) -> tuple[Any, Extraction]:
    """Give the logs among the files, and what is asked of them with the file that is joined to them, where one is.

    Parameters
    ----------
    source : path, sequence of paths, or table in memory
        All files that were given.
    asked : Extraction
        What is asked of the logs, the file that is joined by its name alone.
    files : mapping of str to str
        Where the file of each source is.

    Raises
    ------
    InputError
        If that file is not among them.
    """
    if asked.join is None:
        return source, asked
    name, column = asked.join
    path = files.get(name)
    logs = [given for given in (names_of(source) or []) if path is None or os.path.realpath(given) != os.path.realpath(path)]
    if path is None or not logs:
        raise InputError(f"the rows of {shown(name)} were joined to the log; give that file beside the log")
    return logs, replace(asked, join=(path, column))


def compare_sources(said: Sequence[Source], pairs: Pairs, audit: Mapping[str, Any] | None, paths: Mapping[str, str]) -> list[Recounted]:
    """Compare each file that was given with what a statement says of it, and an audit file with its sections in the statement.

    Parameters
    ----------
    said : sequence of Source
        The sources of the statement.
    pairs : mapping
        What was given for each.
    audit : mapping or None
        The sections of an audit file, where the statement has some.
    paths : mapping of str to str
        Of an audit, where the file of each source is.
    """
    found: list[Recounted] = []
    for place, given in pairs.items():
        entry = said[place]
        finding = _compare(entry, given)
        if audit is not None and given is not None and _is_audit_file(entry, audit):
            found += [finding, _sections_in(paths.get(entry.name), entry, audit)]
        elif audit is not None and given is not None and entry.name not in files_in(audit) and finding.equal:
            found.append(Recounted(finding.what, None, "no section of the audit file names it, and nothing was read from it"))
        else:
            found.append(finding)
    return found


def _compare(said: Source, given: Source | None) -> Recounted:
    """Compare length and digest of a file with those of the statement."""
    what = f"the source {shown(said.name)}"
    if given is None:
        return Recounted(what, None, "it was not given; the attestation has what it says")
    if given.sha256 is not None and (said.query is not None or said.table is not None):
        return Recounted(what, False, f"it is said to be of a database, and {shown(given.name)} is a file")
    if said.sha256 is None:
        return Recounted(what, None, "no digest of it was recorded")
    if given.sha256 is None:
        return Recounted(what, None, f"{shown(given.name)} has no digest")
    if (given.sha256, given.bytes) == (said.sha256, said.bytes):
        return Recounted(what, True)
    recorded = f"recorded are {said.bytes} and {said.sha256}"
    return Recounted(
        what, False, f"{shown(given.name)} has {given.bytes} {noun(given.bytes, 'byte')} and the digest {given.sha256}, {recorded}"
    )


def _sections_in(path: str | None, said: Source, audit: Mapping[str, Any]) -> Recounted:
    """Compare what an audit file says of how the table is made with what the statement says that it does."""
    what = f"what {shown(said.name)} says of the table"
    if path is None:
        return Recounted(what, False, "what was given for it is no file")
    try:
        own = audit_options(read_toml(Path(path))[0])
    except InputError as error:
        return Recounted(what, False, str(error))
    other = next((name for name in (*own, *audit) if own.get(name) != audit.get(name)), None)
    return Recounted(what, other is None, "" if other is None else f"the attestation has another section [{other}] than the file")


def compare_rows(said: Sequence[Source], audit: Mapping[str, Any] | None, read: int | None, joined: str | None = None) -> list[Recounted]:
    """Compare how many rows sources are said to have with how many were read of all; what cannot be told of one is said.

    Parameters
    ----------
    said : sequence of Source
        The sources of the statement.
    audit : mapping or None
        The sections of an audit file, where the statement has some.
    read : int or None
        How many rows were read, where that is known.
    joined : str, optional
        The file whose rows were joined to those of the others.
    """
    sections = [(audit or {}).get(name) for name in ("law", "policy")]
    tables = [section.get("table") for section in sections if isinstance(section, dict)]
    recorded = [entry for entry in said if entry.rows is not None]
    runs = any(entry.run for entry in said)  # what is read beside a run holds no rows
    holding = [entry for entry in said if (audit is None and entry.name != joined and (entry.run or not runs)) or entry.name in tables]
    listed = [entry.rows for entry in holding if entry.rows is not None]
    if read is not None and listed and (sum(listed) > read or (len(listed) == len(holding) and sum(listed) < read)):
        return [Recounted("the rows of the sources", False, f"the attestation says that they have {sum(listed)}; {read} were read")]
    if read is not None and listed and len(holding) == 1:
        recorded = [entry for entry in recorded if entry is not holding[0]]
    return [
        Recounted(f"the {entry.rows} {noun(entry.rows, 'row')} of {shown(entry.name)}", None, "they are not counted by themselves")
        for entry in recorded
    ]
