"""What a table is read from, for a statement: the digests of its files, taken before they are read, and whether they stayed the same."""

from __future__ import annotations

import hashlib
import os
import re
import stat
import unicodedata
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from urllib.parse import unquote

from fairaudit.attestations.statement import Source
from fairaudit.attestations.strict import check_text
from fairaudit.audits.origin import Files, database_name, files_of, names_of, paths_of, state_of
from fairaudit.errors import IN_URL, InputError, shown
from fairaudit.tables.sources import is_database

__all__ = ["Taken", "bare_name", "refuse_credentials", "take", "taken_of"]

SURE = re.compile(r"passw(?:or)?d|passphrase|passwort|kennwort|mot_?de_?passe|contrase\w{1,2}a|credential|identified\s+by", re.IGNORECASE)

BEFORE_VALUE = re.compile(
    r"(pass|(?<![a-z])pw|pwd|secret|token|(?<![a-z])sig|signature|(?<![a-z])auth(?:orization)?|bearer(?=\s+\w)|"
    r"(?:access|account|api|auth|encryption|master|private|sas|secret|shared|storage)[_-]?(?:access[_-]?)?key(?:_?id)?)"
    r"(?:[\d_]*[\"'`\]]?\s*(?:=|:(?!:)|\s[\"'$])|(?<=[rR])\s+\w)",
    re.IGNORECASE,
)

TOKEN = re.compile(
    r"(?<![A-Za-z0-9])(gh[oprsu]_|github_pat_|glpat-|hf_|xox[abprs]-|sk-|AKIA|ASIA|AIza|dapi|eyJ)(?=[\w.-]{12})|(-----BEGIN)(?=[ \w]*KEY)"
)

NO_RUNS: Mapping[str, Mapping[str, str]] = {}

USER_IN_URL = re.compile(r"://[^/@\s]+@")


@dataclass(frozen=True)
class Taken:
    """Sources with their digests.

    Attributes
    ----------
    sources : tuple of Source
        What was found.
    files : Files or None
        The files as they were before anything was read; None of a table in memory.
    data : int or None
        Which source is the only one that holds rows of the table.
    """

    sources: tuple[Source, ...]
    files: Files | None
    data: int | None

    def unchanged(self) -> None:
        """Refuse files that were changed since.

        Raises
        ------
        InputError
            If one was, or if a pattern or a folder stands for other files now.
        """
        if self.files is None:
            return
        for given, paths in self.files.listed.items():
            if paths and tuple(paths_of(given)) != paths:
                raise InputError(f"{given} stands for other files than when the audit began; run it again when nobody writes there")
        for path, before in self.files.states.items():
            if state_of(path) != before:
                raise _changed(path)

    @property
    def places(self) -> tuple[str, ...]:
        """Where the file of each source is; empty of what is none."""
        listed = () if self.files is None else self.files.listed.values()
        return tuple(os.path.realpath(path) if path else "" for paths in listed for path in paths or [""]) or ("",) * len(self.sources)

    def with_rows(self, rows: int | None, runs: Mapping[str, Mapping[str, str]] = NO_RUNS) -> tuple[Source, ...]:
        """The sources, with the number of rows of the only one that holds some, and what evaluation logs say, by where they are."""
        found = tuple(replace(source, run=runs.get(place, {})) for source, place in zip(self.sources, self.places, strict=True))
        if rows is None or self.data is None:
            return found
        return tuple(replace(source, rows=rows) if i == self.data else source for i, source in enumerate(found))


def take(source: object, *, table: str | None = None, query: str | None = None, beside: Sequence[str] = ()) -> Taken:
    r"""Look at what a table will be read from, and take the digests of its files.

    Parameters
    ----------
    source : path, sequence of paths, URL or table in memory
        The table, or an audit file, with which come all files that it names.
    table, query : str, optional
        Of a database: what is read.
    beside : sequence of str
        Further files that are read.

    Returns
    -------
    Taken
        The sources. Databases, pipes and tables in memory have no digest.

    Raises
    ------
    InputError
        If a file cannot be read, or its name or the query has no place in a statement.

    Examples
    --------
    >>> import tempfile
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     path = Path(folder) / "log.csv"
    ...     _ = path.write_text("hired,sex\nyes,f\n")
    ...     taken = take(path)
    ...     taken.unchanged()
    >>> taken.sources[0].name, taken.sources[0].bytes, taken.sources[0].sha256[:8]
    ('log.csv', 16, 'a45891d4')
    """
    names = names_of(source)
    return taken_of(None if names is None else files_of(names, beside), table=table, query=query)


def taken_of(files: Files | None, *, table: str | None = None, query: str | None = None) -> Taken:
    """Take the digests of files that were looked at before.

    Raises
    ------
    InputError
        As `take`, and if a file was changed since it was looked at.
    """
    if query is not None:
        refuse_credentials(query, "the query", query=True)
        check_text(query, "the query")
    if files is None:
        return Taken((Source("a table in memory"),), None, 0)
    found: list[Source] = []
    holding: list[int] = []
    for given, paths in files.listed.items():
        held = {"table": table, "query": query} if given in files.data else {"table": None, "query": None}
        found += [_file(path, files.states[path]) for path in paths] or [_database(given, **held)]
        if given in files.data:
            holding += range(len(found) - max(1, len(paths)), len(found))
    return Taken(tuple(found), files, holding[0] if len(holding) == 1 else None)


def refuse_credentials(text: str, what: str, *, query: bool = False) -> None:
    """Refuse a text that holds what looks like credentials: a user in a URL, a token, and in a query whatever could be a password.

    Common forms are recognised, and more than these refused; nothing recognises all.

    Raises
    ------
    InputError
        If it does; the message does not repeat it.

    Examples
    --------
    >>> refuse_credentials("SELECT * FROM log", "the query", query=True)
    >>> refuse_credentials("SELECT * FROM dblink('password=hush', 'log')", "the query", query=True)
    Traceback (most recent call last):
    fairaudit.errors.InputError: the query holds what looks like a password ('password'), which no attestation holds; omit or rename it
    """
    forms = f"{text}\n{unicodedata.normalize('NFKC', text)}\n{unquote(text)}"
    found = "a user before the @ of an address" if re.search(IN_URL, forms) or USER_IN_URL.search(forms) else ""
    for pattern in (TOKEN, SURE, BEFORE_VALUE) if query else (TOKEN,):
        if not found and (match := pattern.search(forms)):
            found = shown(match[match.lastindex or 0])
    if found:
        raise InputError(f"{what} holds what looks like a password ({found}), which no attestation holds; omit or rename it")


def _database(url: str, table: str | None, query: str | None) -> Source:
    return Source(_name(database_name(url)), table=None if query is not None else table, query=query)


def _file(path: str, before: tuple[int, ...]) -> Source:
    """A file with its digest; none of what can be read only once."""
    try:
        if not stat.S_ISREG(Path(path).stat().st_mode):
            return Source("a pipe")
        with Path(path).open("rb") as file:
            digest = hashlib.file_digest(file, "sha256").hexdigest()
            size = file.tell()
    except FileNotFoundError:
        raise InputError(f"{path}: there is no such file") from None
    except (OSError, ValueError) as error:
        raise InputError(f"{path}: the file cannot be read: {getattr(error, 'strerror', None) or error}") from None
    if state_of(path) != before:
        raise _changed(path)
    return Source(_name(Path(path).name), digest, size)


def _changed(path: str) -> InputError:
    return InputError(f"{path} was changed while it was read; run the audit again when nobody writes to it")


def _name(text: str) -> str:
    try:
        return check_text(text, "its name")
    except InputError as error:
        raise InputError(f"{shown(text)}: {error}; rename the file") from None


def bare_name(source: str) -> str:
    """Name a table or a file without its folders, a database without its server.

    Examples
    --------
    >>> bare_name("/home/me/log.csv"), bare_name("postgresql://me:hush@db.example.org/hiring")
    ('log.csv', 'postgresql:hiring')
    """
    if is_database(source) and not Path(source).exists():
        return database_name(source)
    return Path(source).name or "."
