"""Rows of a log by their attributes and decisions, as canonical text with its digest: docs/certificate-subgroups.md."""

from __future__ import annotations

import hashlib
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from fractions import Fraction
from functools import cached_property
from math import lcm
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fairaudit.certificates.numbers import number
from fairaudit.certificates.table import NUMBERS, canonical
from fairaudit.theorems.t18_search import Rows
from fairaudit.words import brief

__all__ = ["SubgroupTable"]

TABLE_FORMAT = "fairaudit-subgroup-table/1"


@brief
@dataclass(frozen=True, eq=False, repr=False)
class SubgroupTable:
    """How many rows have which attributes and which decision.

    Attributes
    ----------
    decision : str
        Column of the decision.
    attributes : tuple of (str, tuple of str)
        Columns of attributes, each with its labels.
    decisions : tuple of (str, Fraction)
        Decisions with what they are worth; one that is worth several things occurs several times.
    codes : ndarray of int64, shape (entries, attributes)
        The different combinations of labels by position, rising.
    counts : ndarray of int64, shape (entries, decisions)
        How many rows of each have each decision.
    salt : str or None
        Random hexadecimal digits that keep the digest of an undisclosed table from being guessed.
    log : mapping of str to str
        Digests of what the certificate says of the log (`fairaudit.certificates.table.log_digests`).
    """

    decision: str
    attributes: tuple[tuple[str, tuple[str, ...]], ...]
    decisions: tuple[tuple[str, Fraction], ...]
    codes: NDArray[np.int64]
    counts: NDArray[np.int64]
    salt: str | None = None
    log: Mapping[str, str] = field(default_factory=dict)

    @cached_property
    def scale(self) -> int:
        """The common denominator of what decisions are worth."""
        return lcm(*(value.denominator for _, value in self.decisions))

    @cached_property
    def measured(self) -> Rows:
        """The rows by what their decisions are worth, as integers over `scale`."""
        worth = [int(value * self.scale) for _, value in self.decisions]
        values = sorted(set(worth))
        counts = np.zeros((len(self.counts), len(values)), dtype=self.counts.dtype)
        for column, value in enumerate(worth):
            counts[:, values.index(value)] += self.counts[:, column]
        sizes = tuple(len(labels) for _, labels in self.attributes)
        return Rows(tuple(np.ascontiguousarray(self.codes.T)), sizes, counts, tuple(values))

    @property
    def header(self) -> dict[str, Any]:
        """First line of the canonical text."""
        return {
            "format": TABLE_FORMAT,
            "columns": {"decision": self.decision, "attributes": [name for name, _ in self.attributes]},
            "labels": [list(labels) for _, labels in self.attributes],
            "decisions": [[label, number(value)] for label, value in self.decisions],
            **({} if self.salt is None else {"salt": self.salt}),
            **self.log,
        }

    def rows(self) -> Iterator[list[list[int]]]:
        """Yield the other lines: positions of the labels, and how often each decision occurs."""
        for codes, counts in zip(self.codes.tolist(), self.counts.tolist(), strict=True):
            yield [codes, counts]

    def parts(self) -> Iterator[bytes]:
        """Yield the canonical text, some whole lines at a time."""
        yield canonical(self.header)
        line = f"[[{','.join(['%d'] * self.codes.shape[1])}],[{','.join(['%d'] * self.counts.shape[1])}]]\n"
        step = max(1, NUMBERS // (self.codes.shape[1] + self.counts.shape[1]))
        for first in range(0, len(self.codes), step):
            numbers = np.column_stack((self.codes[first : first + step], self.counts[first : first + step]))
            yield (line * len(numbers) % tuple(numbers.ravel().tolist())).encode("ascii")

    def lines(self) -> Iterator[bytes]:
        """Yield the canonical text line by line."""
        for part in self.parts():
            yield from part.splitlines(keepends=True)

    @cached_property
    def sha256(self) -> str:
        """Digest of the canonical text."""
        digest = hashlib.sha256()
        for part in self.parts():
            digest.update(part)
        return digest.hexdigest()

    @property
    def cells(self) -> int:
        """How many numbers of rows there are."""
        return int(self.counts.size)

    def labels(self, conditions: Sequence[tuple[int, int]]) -> dict[str, str]:
        """Conditions by position in words."""
        return {self.attributes[a][0]: self.attributes[a][1][v] for a, v in conditions}
