"""Decisions whose group was not recorded: how many of each there are in each context."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fairaudit.errors import InputError
from fairaudit.tables.columns import CodedTable
from fairaudit.tables.values import distinct
from fairaudit.words import brief

__all__ = ["UnknownRows"]


@brief
@dataclass(frozen=True, eq=False, repr=False)
class UnknownRows:
    """Counts of decisions of unknown group, by context.

    Attributes
    ----------
    contexts : ndarray of int64
        The contexts that have any, in order.
    weights : ndarray, shape (contexts, decisions)
        How many decisions of each kind there are, in units of the law's `scale`.

    Examples
    --------
    >>> from fairaudit.model.law import Law
    >>> table = {"hired": ["yes", "no", "yes", "no"], "sex": ["f", "f", "m", "n/a"], "n": [3, 1, 1, 2]}
    >>> law = Law.from_counts(table, decision="hired", group="sex", count="n", unknown=["n/a"])
    >>> law.groups, law.unknown.weights.tolist()
    ((('f',), ('m',)), [[0, 2]])
    """

    contexts: NDArray[np.int64]
    weights: NDArray[Any]


def unknown_rows(coded: CodedTable, weights: NDArray[Any]) -> UnknownRows | None:
    """Add up the decisions of unknown group, of which there are so many in each row; None if there are none."""
    u, x, a = coded.codes
    held = (a < 0) & (weights > 0)
    if not held.any():
        return None if (a >= 0).all() else UnknownRows(np.zeros(0, dtype=np.int64), np.zeros((0, len(coded.decisions)), dtype=np.int64))
    contexts, place = distinct(x[held])
    sums = np.zeros((len(contexts), len(coded.decisions)), dtype=weights.dtype)
    np.add.at(sums, (place, u[held]), weights[held])
    return UnknownRows(contexts, sums)


def refuse_beside_unknown(kind: str, *, unit: Sequence[str] = (), truth: str | None = None) -> None:
    """Refuse what says nothing of decisions whose group is unknown.

    Raises
    ------
    InputError
        If the table has probabilities, sampling units or true labels.
    """
    if kind != "counts":
        raise InputError("unknown groups go with counts and logs: probabilities do not say how many decisions have no group")
    if unit:
        raise InputError("unknown groups do not go with sampling units: leave out unit, or the labels that count as unknown")
    if truth is not None:
        raise InputError("unknown groups do not go with true labels: leave out truth, or the labels that count as unknown")
