"""Columns of a table that is too big to hold each cell by itself."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import overload

import numpy as np
from numpy.typing import NDArray

__all__ = ["Cells"]


@dataclass(frozen=True, eq=False)
class Cells(Sequence[str]):
    """Cells of a column, as positions in the list of its different texts.

    Examples
    --------
    >>> cells = Cells(np.array([0, 1, 0]), ["f", "m"])
    >>> len(cells), cells[1], [*cells]
    (3, 'm', ['f', 'm', 'f'])
    """

    codes: NDArray[np.int64]
    levels: list[str]

    def __len__(self) -> int:
        """Return the number of cells."""
        return len(self.codes)

    @overload
    def __getitem__(self, position: int) -> str: ...

    @overload
    def __getitem__(self, position: slice) -> list[str]: ...

    def __getitem__(self, position: int | slice) -> str | list[str]:
        """Text of a cell."""
        if isinstance(position, slice):
            return [self.levels[code] for code in self.codes[position].tolist()]
        return self.levels[int(self.codes[position])]

    def __iter__(self) -> Iterator[str]:
        """The texts."""
        return map(self.levels.__getitem__, self.codes.tolist())

    def tolist(self) -> list[str]:
        """All texts."""
        return list(self)
