"""A certificate: exact statements about one table, with what is needed to check them. The format is docs/certificate.md."""

from __future__ import annotations

import json
import os
from collections.abc import Iterable
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from fairaudit.arguments import answered, answered_class
from fairaudit.certificates.table import Table, WrittenTable, log_digests
from fairaudit.errors import InputError
from fairaudit.files import write_together
from fairaudit.words import brief

if TYPE_CHECKING:
    from fairaudit.certificates.subgroup_table import SubgroupTable


__all__ = ["Certificate", "schema"]


FORMAT = "fairaudit-certificate/1"

EMBED_LIMIT = 100_000  # cells: about 10 MB of text; larger tables stand beside the certificate

LONG = 1_000  # entries of a list that are not indented, which would take most of the time and half of the text


@answered_class()
@brief
@dataclass(frozen=True, repr=False)
class Certificate:
    """A certificate and the table that it is about.

    Attributes
    ----------
    document : dict
        The JSON document of docs/certificate.md.
    table : Table, WrittenTable, SubgroupTable or None
        The table, when it is not embedded.

    Examples
    --------
    >>> import fairaudit as fa
    >>> table = {"hired": ["yes", "no", "yes", "no"], "sex": ["f", "f", "m", "m"], "n": [30, 10, 20, 20]}
    >>> result = fa.audit(table, decision="hired", group="sex", count="n", utility="yes", max_local_ratio="5/4")
    >>> certificate = result.certificate
    >>> certificate.document["format"], certificate.document["verdict"], certificate.table
    ('fairaudit-certificate/1', 'inconclusive', None)
    """

    document: dict[str, Any]
    table: Table | WrittenTable | SubgroupTable | None = None

    @property
    def text(self) -> str:
        """The document as JSON, indented but for long lists, which have a hundred entries on each line."""
        return _written(self.document, 0) + "\n"

    @answered
    def save(self, path: str | os.PathLike[str]) -> list[Path]:
        """Write the certificate, and beside it the canonical table if that is not embedded.

        Files appear whole or not at all; the table is written first.

        Parameters
        ----------
        path : path-like
            Where; the table goes to the same name with ``.table.jsonl`` instead of ``.json``.

        Returns
        -------
        list of Path
            The files written.

        Raises
        ------
        InputError
            If a file cannot be written.
        """
        files = self.files(path)
        write_together(files)
        return [path for path, _ in reversed(files)]

    def files(self, path: str | os.PathLike[str]) -> list[tuple[Path, Iterable[bytes]]]:
        """What `save` writes: the table, where it is not embedded, and the certificate.

        Raises
        ------
        InputError
            If the path names no file.
        """
        target = Path(path)
        if not target.name:
            raise InputError(f"{str(path)!r} is not a file name; name a file to write")
        beside = [] if self.table is None else [(table_beside(target), self.table.parts())]
        return [*beside, (target, [self.text.encode("ascii")])]


def table_beside(path: Path) -> Path:
    """Where the table of a certificate stands that does not hold it."""
    return path.with_name((path.stem if path.suffix == ".json" else path.name) + ".table.jsonl")


def _written(value: Any, depth: int) -> str:
    margin = "\n" + " " * depth
    if isinstance(value, dict) and value:
        members = (f"{margin} {json.dumps(key)}: {_written(item, depth + 1)}" for key, item in value.items())
        return "{" + ",".join(members) + margin + "}"
    if isinstance(value, list) and len(value) > LONG:
        return "[" + ",".join(f"{margin} {json.dumps(value[i : i + 100])[1:-1]}" for i in range(0, len(value), 100)) + margin + "]"
    return json.dumps(value, indent=1).replace("\n", margin)


def with_table(document: dict[str, Any], table: Table | WrittenTable, *, embed: bool | None = None) -> Certificate:
    """Put a table into a document; only its digest when `embed` is false, it has more than 100,000 entries, or its rows are in a file.

    A table whose rows are in a file has to name the digests of what the document says of the log; others are made to.
    """
    if isinstance(table, Table):
        table = replace(table, log=log_digests(document["subject"]))
    apart = isinstance(table, WrittenTable) or table.cells > EMBED_LIMIT if embed is None else not embed
    if embed is False and isinstance(table, Table):
        table = replace(table, salt=new_salt())
    entry: dict[str, Any] = {"sha256": table.sha256, "cells": table.cells}
    if not apart and isinstance(table, Table):
        entry |= {"header": table.header, "rows": list(table.rows())}
    for claim in document["claims"]:
        if "table" in claim["evidence"]:
            claim["evidence"]["table"] = table.sha256
    document["subject"]["table"] = entry
    return Certificate(document, table if apart else None)


def new_salt() -> str:
    """Digits that keep the digest of a table that is not disclosed from being guessed."""
    import secrets

    return secrets.token_hex(16)


def schema() -> dict[str, Any]:
    """Return the JSON Schema of the format, as shipped with the package.

    Examples
    --------
    >>> schema()["properties"]["format"]
    {'const': 'fairaudit-certificate/1'}
    """
    from importlib.resources import files

    loaded: dict[str, Any] = json.loads(files("fairaudit.certificates").joinpath("certificate.schema.json").read_text("utf-8"))
    return loaded
