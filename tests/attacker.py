"""Whoever knows which groups there are and what is published of them asks an integer solver what the counts behind it may be."""

from __future__ import annotations

from collections.abc import Collection, Hashable, Iterable, Sequence
from typing import TypeVar

import numpy as np
from scipy.optimize import Bounds, LinearConstraint, milp

Cell = TypeVar("Cell", bound=Hashable)


def agreeing(cells: Sequence[Cell], known: Iterable[tuple[Collection[Cell], int]]) -> dict[Cell, int] | None:
    """Whole counts of the cells with these sums; None if there are none. Found by floats, confirmed in integers."""
    groups, sums = map(list, zip(*known, strict=True))
    matrix = np.array([[cell in group for cell in cells] for group in groups], dtype=int)
    found = milp(
        np.zeros(len(cells)),
        integrality=np.ones(len(cells)),
        bounds=Bounds(0, np.inf),
        constraints=LinearConstraint(matrix, sums, sums),
    )
    if found.x is None:
        return None
    values = [round(x) for x in found.x]
    assert (matrix @ values).tolist() == sums and min(values) >= 0
    return dict(zip(cells, values, strict=True))


def inside(place: Sequence[str], cells: Iterable[tuple[str, str]]) -> list[tuple[str, str]]:
    """The cells of a group by two columns; an empty text stands for all labels of one."""
    return [cell for cell in cells if all(not label or label == of for label, of in zip(place, cell, strict=True))]
