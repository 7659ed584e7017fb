"""T15, second part: no row has a recorded group, but of each cell of rows it is known which share belongs to which group.

Whoever the members are, they take slices of the cells. A union of groups has the least mean where it takes the worst slice of every
cell, and the greatest where it takes the best ones. These are the ends that everything else is made of:

- two groups take opposite slices, so that their ratio reaches the best mean of the one over the worst mean of the other;
- in some completion all ratios are at most V, if and only if no union must have a mean of more than V times the mean that another union
  can have at best: what groups get are the bases of a supermodular function (the worst slices of unions), and a box meets those bases
  if and only if no union keeps it out (Frank and Tardos). So two unions are all the evidence there is, and `level` constructs the
  completion.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from itertools import combinations, permutations

from fairaudit.errors import InputError
from fairaudit.exact.extended import Extended
from fairaudit.theorems.t15_cells import Cell, Cells, Mixture, beyond, level, members, mixture_means, ratio
from fairaudit.theorems.t15_shares import equal_shares, unequal_shares

__all__ = ["MOST_GROUPS", "Completion", "Ends", "Extreme", "proxy_ends"]

SHARES = "of the rows of each cell, each group has the given share: the probabilities are those of the people in this table"

SHARES_BETWEEN = "of the rows of each cell, each group has a share between the given ends: these hold of the people in this table"

EXHAUSTIVE = "everybody belongs to exactly one of the groups"

SHARES_IN_CONTEXTS = "the shares of a cell are the same in each context"

ENDS_IN_CONTEXTS = "the ends that are given for a cell hold in each context"

MOST_GROUPS = 8
"""How many groups are compared: every union of them is looked at."""


@dataclass(frozen=True)
class Completion:
    """Who the members could be: an assignment of rows to groups, parts of rows included.

    Attributes
    ----------
    ratio : Fraction or float
        The greatest ratio of two groups in it.
    mixture : Mixture
        In each cell the groups take its rows in these orders, each of which has a share of the rows.
    rows : tuple of tuple of Fraction, or None
        How many rows of each cell each group has, where that is not known.
    """

    ratio: Extended
    mixture: Mixture
    rows: tuple[tuple[Fraction, ...], ...] | None = None


@dataclass(frozen=True)
class Extreme:
    """An end of the greatest ratio.

    Attributes
    ----------
    value : Fraction or float
        The end.
    higher, lower : tuple of int
        The unions of groups whose means prove it.
    sharp : bool
        Whether some completion has this ratio.
    """

    value: Extended
    higher: tuple[int, ...]
    lower: tuple[int, ...]
    sharp: bool


@dataclass(frozen=True)
class Ends:
    """What the means and ratios of groups can be, whoever their members are.

    Attributes
    ----------
    means : tuple of (Fraction, Fraction)
        The least and the greatest mean of each group, both of which occur.
    pairs : mapping of (int, int) to ((Fraction or float, bool), (Fraction or float, bool))
        For two groups, the least and the greatest ratio of the first to the second, each with whether it occurs for certain.
    least, greatest : Extreme
        Of the greatest ratio of two groups.
    low, high : Completion
        Completions with a small and with a great ratio: with the ends themselves, where these are sharp.
    """

    means: tuple[tuple[Fraction, Fraction], ...]
    pairs: dict[tuple[int, int], tuple[tuple[Extended, bool], tuple[Extended, bool]]]
    least: Extreme
    greatest: Extreme
    low: Completion
    high: Completion


def proxy_ends(cells: Cells) -> Ends:
    """The ranges of all means and ratios of groups that have rows in every completion.

    Source: T15; Coq `T15_cells`, `T15_cells_pair`, `T15_cells_exceeds`, `T15_cells_attained`, `T15_cells_interval`.

    Parameters
    ----------
    cells : Cells
        The cells; of each group at least one has more than no rows.

    Returns
    -------
    Ends
        The ranges, with completions.

    Raises
    ------
    InputError
        If there are too many groups.

    Examples
    --------
    >>> from fairaudit.theorems.t15_cells import proxy_cells
    >>> def cell(successes, share):
    ...     shares = [share, 1 - share]
    ...     return [(Fraction(1), successes), (Fraction(0), 4 - successes)], shares, shares
    >>> found = proxy_ends(proxy_cells([cell(2, Fraction(4, 5)), cell(3, Fraction(1, 5))], 2))
    >>> found.pairs[0, 1], str(found.greatest.value)
    (((Fraction(6, 19), True), (Fraction(14, 11), True)), '19/6')
    """
    if cells.groups > MOST_GROUPS:
        raise InputError(f"{cells.groups} groups are too many, because every union of them is looked at; up to {MOST_GROUPS} are compared")
    full = (1 << cells.groups) - 1
    of_unions = {union: cells.ends(union) for union in range(1, full)}
    means = tuple(of_unions[1 << a] for a in range(cells.groups))
    pairs = {}
    for a, b in combinations(range(cells.groups), 2):
        up, down = ratio(means[a][1], means[b][0]), ratio(means[a][0], means[b][1])
        pairs[a, b] = (down, _fits(cells, b, a, means)), (up, _fits(cells, a, b, means))
    greatest = _greatest(pairs)
    forced = max(of_unions, key=lambda union: of_unions[union][0])
    capped = min(of_unions, key=lambda union: of_unions[union][1])
    value = ratio(of_unions[forced][0], of_unions[capped][1])
    least = Extreme(max(value, Fraction(1)), members(forced), members(capped), cells.exact)
    if cells.exact:
        order = (greatest.lower[0], *(c for c in range(cells.groups) if c not in (*greatest.lower, *greatest.higher)), greatest.higher[0])
        high = Completion(greatest.value, ((Fraction(1), order),))
        low = Completion(least.value, level(cells))
        return Ends(means, pairs, least, greatest, low, high)
    low, high = _low(cells), _high(cells, means)
    least = replace(least, sharp=low.ratio == least.value)
    greatest = replace(greatest, sharp=high.ratio == greatest.value)
    return Ends(means, pairs, least, greatest, low, high)


def _greatest(pairs: dict[tuple[int, int], tuple[tuple[Extended, bool], tuple[Extended, bool]]]) -> Extreme:
    ends: list[tuple[Extended, bool, int, int]] = []
    for (a, b), ((down, down_sharp), (up, up_sharp)) in pairs.items():
        ends += [(up, up_sharp, a, b), (ratio(Fraction(1), down) if isinstance(down, Fraction) else Fraction(0), down_sharp, b, a)]
    value = max(end[0] for end in ends)
    _, sharp, a, b = max((end for end in ends if end[0] == value), key=lambda end: end[1])
    return Extreme(value, (a,), (b,), sharp)


def _fits(cells: Cells, a: int, b: int, means: Sequence[tuple[Fraction, Fraction]]) -> bool:
    """Whether some shares let one group have its greatest mean while another has its least: the slices leave room for the others."""
    if cells.exact:
        return True
    above, below = means[a][1] * cells.unit, means[b][0] * cells.unit
    for cell in cells.cells:
        a_least, a_most = (_clamped(cell, a, beyond(cell, above, up=True, ties=ties)) for ties in (False, True))
        b_least, b_most = (_clamped(cell, b, beyond(cell, below, up=False, ties=ties)) for ties in (False, True))
        least, most = cell.within(1 << a | 1 << b)
        if a_most + b_most < least or a_least + b_least > most:
            return False
    return True


def _clamped(cell: Cell, a: int, rows: int) -> int:
    low, high = cell.within(1 << a)
    return min(max(rows, low), high)


def _low(cells: Cells) -> Completion:
    """A completion of shares that are not known whose groups are much alike."""
    found = [_completion(known, level(known)) for known in equal_shares(cells)]
    return min(found, key=lambda completion: completion.ratio)


def _high(cells: Cells, means: Sequence[tuple[Fraction, Fraction]]) -> Completion:
    """A completion of shares that are not known, two of whose groups are far apart."""
    far = sorted(permutations(range(cells.groups), 2), key=lambda pair: -ratio(means[pair[0]][1], means[pair[1]][0]))
    best: Completion | None = None
    for a, b in far:
        if best is not None and best.ratio >= ratio(means[a][1], means[b][0]):
            break
        order = (b, *(c for c in range(cells.groups) if c not in (a, b)), a)
        for known in unequal_shares(cells, a, b, means[a][1], means[b][0]):
            found = _completion(known, ((Fraction(1), order),))
            best = found if best is None or found.ratio > best.ratio else best
    if best is None:
        raise AssertionError
    return best


def _completion(known: Cells, mixture: Mixture) -> Completion:
    means = mixture_means(known, mixture)
    rows = tuple(tuple(Fraction(count, known.scale) for count in cell.low) for cell in known.cells)
    return Completion(ratio(max(means), min(means)), mixture, rows)
