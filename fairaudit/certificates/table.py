"""The table that a certificate is about, as canonical text with its digest."""

from __future__ import annotations

import json
import weakref
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from functools import cached_property
from math import gcd
from typing import IO, TYPE_CHECKING, Any

import numpy as np

from fairaudit.exact.rationals import integer_text, rational_text
from fairaudit.model.law import Law
from fairaudit.model.layout import Columns, dyadic_rows
from fairaudit.model.utility import UtilityTable
from fairaudit.words import brief

if TYPE_CHECKING:
    from fairaudit.model.mechanism import Factor, Mechanism
    from fairaudit.model.policy import Deployment


__all__ = ["OF_LOG", "Table", "WrittenTable", "log_digests"]


TABLE_FORMAT = "fairaudit-table/1"

OF_LOG = ("preparation", "evaluation")
"""What a subject says of the log; the header of the table names the digest of each."""

NUMBERS = 100_000  # numbers that are made text at a time

KEPT_BYTES = 1 << 27
"""Canonical text up to here is written once and kept."""

LONG_BITS = 10_000
"""Python writes integers of so many bits at once."""

CANONICAL = json.JSONEncoder(ensure_ascii=True, sort_keys=True, separators=(",", ":"))


@brief
@dataclass(frozen=True, repr=False)
class Table:
    """The canonical text of a law and its utility, or of a policy with filters, population and utility.

    Attributes
    ----------
    law : Law
        The law; that of the policy's own rows if there is a deployment.
    utility : UtilityTable
        The utility; on the induced law if there is a deployment.
    deployment : Deployment or None
        The policy behind filters.
    salt : str or None
        Random hexadecimal digits that keep the digest of an undisclosed table from being guessed.
    profiles : mapping of str to str
        Digests of what sampling units got in all groups, for the intervals that rest on it.
    log : mapping of str to str
        Digests of what the certificate says of the log (`log_digests`).
    """

    law: Law
    utility: UtilityTable
    deployment: Deployment | None = None
    salt: str | None = None
    profiles: Mapping[str, str] = field(default_factory=dict)
    log: Mapping[str, str] = field(default_factory=dict)

    @cached_property
    def header(self) -> dict[str, Any]:
        """First line of the canonical text."""
        law, utility, deployment = self.law, self.utility, self.deployment
        head: dict[str, Any] = {
            "format": TABLE_FORMAT,
            "kind": "policy" if deployment else law.kind,
            "columns": column_names(law.columns),
            "population": utility.law.population,
            "decisions": list(law.decisions),
            "groups": [list(group) for group in law.groups],
            "contexts": [list(context) for context in law.contexts],
            "utility": [rational_text((v, utility.scale)) for v in utility.values.tolist()] if utility.by_decision else None,
        }
        if deployment:
            context = deployment.context_filter
            head["filters"] = {"group": _factors(deployment.group_filter), "context": _factors(context) if context else None}
            if deployment.releases > 1:
                head["filters"]["releases"] = deployment.releases
        if law.truth is not None:
            head["truths"] = list(law.truth.labels)
        if law.unknown is not None:
            head["unknown"] = True
        if self.salt is not None:
            head["salt"] = self.salt
        if self.profiles:
            head["profiles"] = dict(self.profiles)
        return head | dict(self.log)

    def rows(self) -> Iterator[dict[str, Any]]:
        """Yield one object per cell, in order, then one per context that has decisions of unknown group."""
        if self.deployment:
            yield from self._policy_rows()
            return
        law, utility = self.law, self.utility
        masses = law.cell_mass if law.population == "weights" else None
        total = sum(masses) if masses else 1
        for cell, (x, a) in enumerate(zip(law.cell_context.tolist(), law.cell_group.tolist(), strict=True)):
            row = law.row(cell)
            bottom = law.scale if law.kind == "counts" else sum(row)
            entry: dict[str, Any] = {"context": x, "group": a, "weights": _texts(row, bottom)}
            if law.truth is not None:
                entry["truth"] = [_texts(part, bottom) for part in law.truth.weights[cell].tolist()]
            if masses:
                entry["mass"] = rational_text((masses[cell], total))
            if not utility.by_decision:
                given = utility.given[cell].tolist() if utility.given is not None else [True] * len(row)
                texts = _texts(utility.row(cell), utility.scale)
                entry["utility"] = [text if known else None for text, known in zip(texts, given, strict=True)]
            yield entry
        yield from self._unknown_rows()

    def _unknown_rows(self) -> Iterator[dict[str, Any]]:
        """Yield an object per context that has decisions of unknown group."""
        law, utility = self.law, self.utility
        if law.unknown is None:
            return
        for place, (x, row) in enumerate(zip(law.unknown.contexts.tolist(), law.unknown.weights.tolist(), strict=True)):
            entry: dict[str, Any] = {"context": x, "unknown": _texts(row, law.scale)}
            if not utility.by_decision:
                entry["utility"] = [None if v is None else rational_text((v, utility.scale)) for v in utility.unknown[place]]
            yield entry

    def _policy_rows(self) -> Iterator[dict[str, Any]]:
        """Yield the policy's rows, with the number of draws if it was sampled, then the true cells where they carry mass or utility."""
        law, utility = self.law, self.utility
        for cell, (x, a) in enumerate(zip(law.cell_context.tolist(), law.cell_group.tolist(), strict=True)):
            row = law.row(cell)
            drawn = {"draws": sum(row) // law.scale} if law.whole else {}
            yield {"context": x, "group": a, "weights": _texts(row, sum(row)), **drawn}
        induced = utility.law
        if induced.population == "equal" and utility.by_decision:
            return
        total = sum(induced.cell_mass)
        for cell, (x, a) in enumerate(zip(induced.cell_context.tolist(), induced.cell_group.tolist(), strict=True)):
            entry: dict[str, Any] = {"true_context": x, "true_group": a}
            if induced.population == "weights":
                entry["mass"] = rational_text((induced.cell_mass[cell], total))
            if not utility.by_decision:
                entry["utility"] = _texts(utility.row(cell), utility.scale)
            yield entry

    def lines(self) -> Iterator[bytes]:
        """Yield the canonical text line by line."""
        for part in self.parts():
            yield from part.splitlines(keepends=True)

    def parts(self) -> Iterator[bytes]:
        """Yield the canonical text, some whole lines at a time."""
        kept: list[bytes] | None = vars(self).get("_kept")
        if kept is not None:
            yield from kept
            return
        yield canonical(self.header)
        yield from self._row_parts()

    def __getstate__(self) -> dict[str, Any]:
        """What is pickled: not the text."""
        return {name: value for name, value in vars(self).items() if name != "_kept"}

    def _row_parts(self) -> Iterator[bytes]:
        """Yield the lines of the rows, some at a time."""
        law = self.law
        if self.deployment is None and law.truth is None and self.utility.by_decision:
            if law.kind == "counts" and law.scale == 1 and law.weights.dtype == np.int64:
                yield from count_lines(law)
                yield from map(canonical, self._unknown_rows())
                return
            if law.kind == "probabilities" and law.population == "equal":
                yield from probability_lines(law)
                return
        for row in self.rows():
            yield canonical(row)

    @cached_property
    def sha256(self) -> str:
        """Digest of the canonical text, which is kept to be written, too, if it is not very long."""
        kept, size = [], 0

        def keeping() -> Iterator[bytes]:
            nonlocal size
            for part in self.parts():
                size += len(part)
                if size <= KEPT_BYTES:
                    kept.append(part)
                yield part

        digest = _digest(keeping())
        if size <= KEPT_BYTES:
            vars(self)["_kept"] = kept
        return digest

    @property
    def cells(self) -> int:
        """Number of (x,a,u) entries."""
        return int(self.law.weights.size)


@brief
@dataclass(frozen=True, eq=False, repr=False)
class WrittenTable:
    """The canonical text of a table whose rows were written to a file, some at a time.

    Attributes
    ----------
    header : dict
        First line of the canonical text.
    file : binary file
        The other lines.
    cells : int
        Number of (x,a,u) entries.
    """

    header: dict[str, Any]
    file: IO[bytes]
    cells: int

    def __post_init__(self) -> None:
        """Close the file when the table is no longer needed."""
        weakref.finalize(self, self.file.close)

    def __getstate__(self) -> dict[str, Any]:
        """What is pickled: the rows in the place of the file."""
        self.file.seek(0)
        return {"header": self.header, "rows": self.file.read(), "cells": self.cells}

    def __setstate__(self, state: dict[str, Any]) -> None:
        """Write the rows to a file of its own."""
        from tempfile import TemporaryFile

        file = TemporaryFile()  # noqa: SIM115
        file.write(state["rows"])
        for name, value in {"header": state["header"], "file": file, "cells": state["cells"]}.items():
            object.__setattr__(self, name, value)
        self.__post_init__()

    def lines(self) -> Iterator[bytes]:
        """Yield the canonical text line by line."""
        yield canonical(self.header)
        self.file.seek(0)
        yield from self.file

    def parts(self) -> Iterator[bytes]:
        """Yield the canonical text in parts."""
        yield canonical(self.header)
        self.file.seek(0)
        while part := self.file.read(1 << 20):
            yield part

    @cached_property
    def sha256(self) -> str:
        """Digest of the canonical text."""
        return _digest(self.parts())


def log_digests(subject: Mapping[str, Any]) -> dict[str, str]:
    """Digests of what a subject says of the log, which the header of the table names: nobody can alter the one without the other.

    Examples
    --------
    >>> log_digests({"columns": {"decision": "hired"}})
    {}
    >>> list(log_digests({"preparation": [{"step": "intervals", "column": "age", "edges": ["40"]}]}))
    ['preparation']
    """
    return {key: _digest(iter([canonical(subject[key])])) for key in OF_LOG if key in subject}


def _digest(parts: Iterator[bytes]) -> str:
    from hashlib import sha256

    digest = sha256()
    for part in parts:
        digest.update(part)
    return digest.hexdigest()


def column_names(columns: Columns) -> dict[str, Any]:
    """Column names of a law as a certificate stores them."""
    named = {"decision": columns.decision, "group": list(columns.group), "context": list(columns.context)}
    return named if columns.truth is None else {**named, "truth": columns.truth}


def count_lines(law: Law, contexts_before: int = 0) -> Iterator[bytes]:
    """Yield what `canonical` makes of the rows of a law of whole counts, many at a time."""
    weights = ",".join(['"%d"'] * law.weights.shape[1])
    line = f'{{"context":%d,"group":%d,"weights":[{weights}]}}\n'
    step = max(1, NUMBERS // law.weights.shape[1])
    for first in range(0, len(law.weights), step):
        some = slice(first, first + step)
        numbers = np.column_stack((law.cell_context[some] + contexts_before, law.cell_group[some], law.weights[some]))
        yield (line * len(numbers) % tuple(numbers.ravel().tolist())).encode("ascii")


def probability_lines(law: Law) -> Iterator[bytes]:
    """Yield what `canonical` makes of the rows of a law of probabilities without masses, many at a time.

    Examples
    --------
    >>> b"".join(probability_lines(Law.from_array([["0.5", "0.5"], ["1/3", "2/3"]]))).decode().splitlines()[1]
    '{"context":0,"group":1,"weights":["1/3","2/3"]}'
    """
    width = law.weights.shape[1]
    weights = ",".join(['"%d/%d"'] * width)
    line = f'{{"context":%d,"group":%d,"weights":[{weights}]}}\n'
    step = max(1, NUMBERS // width)
    for first in range(0, len(law.weights), step):
        some = slice(first, first + step)
        tops = dyadic_rows(law.weights[some]) if law.floating else law.weights[some]
        totals = tops.sum(axis=1)
        cells = np.column_stack((law.cell_context[some], law.cell_group[some]))
        if int(totals.max()).bit_length() > LONG_BITS:
            for (x, a), row, total in zip(cells.tolist(), tops.tolist(), totals.tolist(), strict=True):
                yield canonical({"context": x, "group": a, "weights": _texts(row, total)})
            continue
        common = np.gcd(tops, totals[:, None])
        quotients = np.stack((tops // common, totals[:, None] // common), axis=2).reshape(len(tops), 2 * width)
        numbers = np.column_stack((cells, quotients)).ravel().tolist()
        yield (line * len(tops) % tuple(numbers)).replace('/1"', '"').encode("ascii")


def _factors(mechanism: Mechanism) -> list[dict[str, Any]]:
    return [_factor(factor) for factor in mechanism.factors]


def _factor(factor: Factor) -> dict[str, Any]:
    return {
        "inputs": [list(label) for label in factor.inputs],
        "outputs": [list(label) for label in factor.outputs],
        "rows": [[rational_text((v, factor.denominator)) for v in row] for row in factor.rows],
    }


def canonical(value: Any) -> bytes:
    """One line of canonical text."""
    return CANONICAL.encode(value).encode("ascii") + b"\n"


def _texts(values: list[int], bottom: int) -> list[str]:
    """Quotients of integers by one denominator as text, in lowest terms."""
    if bottom == 1:
        return [*map(str, values)] if max(values).bit_length() <= LONG_BITS else [integer_text(v) for v in values]
    common = gcd(bottom, *values)
    if common > 1:
        values, bottom = [v // common for v in values], bottom // common
    if max(bottom, *values).bit_length() > LONG_BITS:
        return [rational_text((v, bottom)) if v else "0" for v in values]
    shared = [gcd(v, bottom) for v in values]
    return [f"{v // s}/{bottom // s}" if s != bottom else str(v // s) for v, s in zip(values, shared, strict=True)]
