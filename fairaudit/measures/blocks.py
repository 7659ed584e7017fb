"""Contexts as blocks of rows: where they begin, which are equal to the one before, and the error of one rounding."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from fairaudit.exact.dense import equal_to_previous
from fairaudit.model.law import Law


def block_starts(law: Law, cells: NDArray[np.int64]) -> NDArray[np.int64]:
    """Where the cells of each context begin, and after the last where they end."""
    if not len(cells):
        return np.zeros(1, dtype=np.int64)
    edges = np.flatnonzero(np.diff(law.cell_context[cells])) + 1
    return np.concatenate(([0], edges, [len(cells)])).astype(np.int64)


def equal_blocks(matrix: NDArray[Any], starts: NDArray[np.int64], blocks: NDArray[np.int64]) -> NDArray[np.bool_]:
    """Tell which of the given blocks have equal rows only."""
    chosen = np.zeros(len(starts) - 1, dtype=bool)
    chosen[blocks] = True
    equal = equal_to_previous(matrix, np.repeat(chosen, np.diff(starts)))
    equal[starts[:-1]] = True
    return np.asarray(np.logical_and.reduceat(equal, starts[:-1])[blocks]) if len(blocks) else np.zeros(0, dtype=bool)
