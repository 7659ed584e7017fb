"""The rows that a class compares, P(·∣x,a) or P(u,x∣a), in floats and exactly."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fairaudit.exact.dense import Floats
from fairaudit.worst.setting import Setting

Indices = NDArray[np.int64]

ENTRIES = 1_000_000
"""Entries of a matrix of floats in one step: 8 MB, which caches hold."""

LOOKED_AT = 64
"""Promising pairs that are looked at closely in one step; the best of them rules out nearly all others."""


@dataclass(frozen=True, eq=False)
class ComparedRows:
    """Laws of the members compared, sorted into blocks: in floats, and exactly."""

    floats: Floats
    starts: Indices
    exact: Callable[[int], list[int]]
    sources: list[int]
    """The cell or group of each member."""
    stored: NDArray[Any] | None = None
    """The rows as they are stored: members with equal stored rows are surely equal."""

    def block(self, member: int) -> int:
        """The block that a member belongs to."""
        return int(np.searchsorted(self.starts, member, side="right")) - 1


def compared_rows(setting: Setting) -> ComparedRows:
    """Rows P(·|x,a) of compared cells, or P(u,x|a) of the global groups."""
    law = setting.law
    if setting.quantity == "local":
        cells = np.flatnonzero(law.compared)
        weights = law.weights if len(cells) == len(law.weights) else law.weights[cells]
        sizes = [len(block) for block in setting.members]
        floats = law.float_rows(cells)
        starts = np.concatenate(([0], np.cumsum(sizes))).astype(np.int64)
        return ComparedRows(floats, starts, lambda i: law.row(int(cells[i])), cells.tolist(), weights)
    n, places = setting.n, setting.place_of
    listed: list[list[int]] = []
    coefficients, totals = law.mixing
    for a in law.global_groups:
        row = [0] * (len(setting.contexts) * n)
        for cell in np.flatnonzero(law.cell_group == a).tolist():
            c = int(coefficients[cell])
            if c:
                row[places[cell] * n : (places[cell] + 1) * n] = [c * v for v in law.row(cell)]
        listed.append(row)
    floats = np.array([[v / totals[a] for v in row] for a, row in zip(law.global_groups, listed, strict=True)], dtype=np.float64)
    return ComparedRows(floats, np.array([0, len(listed)], dtype=np.int64), listed.__getitem__, list(law.global_groups))
