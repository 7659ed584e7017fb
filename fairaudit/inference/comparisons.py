"""Forms, weighted sums of the means of cells, and the blocks of forms that are compared with each other.

A form is a single cell for a plain table, the filters' probabilities for a policy behind filters, P(x|a) for a group mean. A block
is a context for the local ratio. The ratio R is the greatest quotient of two forms of one block.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from fractions import Fraction
from functools import cached_property
from itertools import permutations
from math import inf
from typing import Any, Literal

from fairaudit.errors import InputError
from fairaudit.exact.extended import ONE, Extended
from fairaudit.exact.rationals import option_value
from fairaudit.inference.cells import Cell, Ends, Profiles, informative
from fairaudit.measures.ratios import Ratio, Witness
from fairaudit.model.layout import Units
from fairaudit.tables.values import Label, names
from fairaudit.theorems.assumptions import DECLARED, DRAWS
from fairaudit.words import brief

Form = tuple[tuple[int, Fraction], ...]
"""Cells by their index, each with a positive weight."""

Place = tuple[int, int, int]
"""A block, and the positions of two of its forms, the higher one first."""

Tally = Mapping[Fraction, int]
"""How often each value was drawn, also of those that never were."""

Estimand = Literal["mean over rows", "mean over units"]

MissingUnits = Literal["worst", "drop"]


@brief
@dataclass(frozen=True, repr=False)
class Comparison:
    """Cells, and the blocks of forms in their means that are compared.

    Attributes
    ----------
    cells : tuple of Cell
        The cells.
    blocks : tuple of tuple of forms
        A form is a tuple of (cell index, weight > 0).
    labels : tuple
        For each block its context and the groups of its forms, as mappings from column to label (the context is None over all contexts).
    dependent : bool
        Whether cells are known to share draws or sampling units, so that they cannot be declared independent.
    assumptions, notes : tuple of str
        What the reader must accept, and what was noticed.
    limits : pair of Fraction or None
        The declared range of g.
    units : Units or None
        The sampling units of the log.
    drawn : callable or None
        What tells how often each value was drawn in each cell, for `tallies`; None where that is not known.
    listed : bool
        Whether the values of g were listed beforehand, and not read off the draws.
    profiles : tuple of mapping
        For each block how many units got which values in its groups, None where they were not seen; empty if no unit was seen in two.
    missing : {"worst", "drop"}
        Whether a unit counts as what is worst for the claim in a group in which it was not seen, or pairs with that group leave it out.
    meanings : pair of tuple of Cell, or None
        The same cells with every decision of unknown meaning worth the least, and the most, that it may be worth.

    Examples
    --------
    >>> import fairaudit as fa
    >>> table = {"hired": ["yes", "no", "yes", "no"], "sex": ["f", "f", "m", "m"], "n": [30, 10, 20, 20]}
    >>> result = fa.audit(table, decision="hired", group="sex", count="n", utility="yes", max_local_ratio="5/4")
    >>> [(cell.draws, cell.mean) for cell in result.comparisons["local"].cells]
    [(40, Fraction(3, 4)), (40, Fraction(1, 2))]
    """

    cells: tuple[Cell, ...]
    blocks: tuple[tuple[Form, ...], ...]
    labels: tuple[tuple[dict[str, str] | None, tuple[dict[str, str], ...]], ...] = ()
    dependent: bool = False
    assumptions: tuple[str, ...] = (DRAWS, DECLARED)
    notes: tuple[str, ...] = ()
    limits: Ends | None = None
    units: Units | None = None
    drawn: Callable[[], Sequence[Tally]] | None = field(default=None, repr=False, compare=False)
    listed: bool = True
    profiles: tuple[Profiles, ...] = ()
    missing: MissingUnits = "worst"
    meanings: tuple[tuple[Cell, ...], tuple[Cell, ...]] | None = None

    @cached_property
    def tallies(self) -> Sequence[Tally]:
        """How often each value was drawn in each cell; only counted where it is asked for."""
        return self.drawn() if self.drawn else ()

    @property
    def estimand(self) -> Estimand:
        """What the means of the cells are: over rows, or, where units have several rows in a cell, over units of the mean of each."""
        return "mean over units" if self.units and self.units.repeated else "mean over rows"

    @cached_property
    def of_units(self) -> Ratio | None:
        """The ratio of the sample as the mean over units, with its witness; None where a unit has one row in a cell."""
        if self.estimand == "mean over rows":
            return None
        best: tuple[Extended, int, int, int] | None = None
        for number, block in enumerate(self.blocks):
            means = [self.cells[i].mean for ((i, _),) in block]
            low, high = means.index(min(means)), means.index(max(means))
            if means[low] == means[high]:
                found: tuple[Extended, int, int] = Fraction(1), 0, 1
            elif means[low]:
                found = means[high] / means[low], high, low
            else:
                found = inf, next(i for i, mean in enumerate(means) if mean), low
            if best is None or found[0] > best[0]:
                best = found[0], number, *found[1:]
        if best is None:
            return None
        ratio, *place = best
        witness = witness_of(self, place)
        return None if witness is None else Ratio(ratio, witness)

    @cached_property
    def used(self) -> tuple[int, ...]:
        """The informative cells of blocks with at least two forms, in order."""
        found = {i for block in self.blocks if len(block) > 1 for form in block for i, _ in form}
        known = [informative(cells) for cells in self.valued]
        return tuple(i for i in sorted(found) if any(own[i] for own in known))

    @property
    def valued(self) -> tuple[tuple[Cell, ...], ...]:
        """The cells, or, where decisions have an unknown meaning, the cells of either extreme."""
        return self.meanings or (self.cells,)

    def range_of(self, cell: int) -> Ends:
        """Between which ends the mean of a cell lies, whatever was drawn and whatever it meant."""
        return self.valued[0][cell].low, self.valued[-1][cell].high

    @cached_property
    def span(self) -> int:
        """s, the greatest number of informative cells in the two forms of a compared pair."""
        used = set(self.used)
        best = 0
        for block in self.blocks:
            supports = {frozenset(i for i, _ in form if i in used) for form in block} if len(block) > 1 else set()
            sizes = sorted((len(support) for support in supports), reverse=True)
            if len(supports) == 1 or sizes[:1] == [1]:
                best = max([best, sum(sizes[:2])])
            elif sum(sizes[:2]) > best:
                best = max([best, *(len(p | q) for p, q in permutations(supports, 2))])
        return best

    @cached_property
    def single(self) -> bool:
        """Whether every form is one cell."""
        return all(len(form) == 1 and (form[0][1] is ONE or form[0][1] == 1) for block in self.blocks for form in block)

    @cached_property
    def places(self) -> list[Place]:
        """All ordered pairs of forms that are compared, block by block."""
        return [(b, i, j) for b, block in enumerate(self.blocks) for i, j in permutations(range(len(block)), 2)]

    def cells_of(self, place: Place) -> tuple[int, int]:
        """The cells of a pair of forms of one cell each."""
        block = self.blocks[place[0]]
        return block[place[1]][0][0], block[place[2]][0][0]

    @property
    def pairs(self) -> int:
        """M, the number of ordered pairs that are compared."""
        return sum(len(block) * (len(block) - 1) for block in self.blocks)


def unit_form(cell: int) -> Form:
    """The mean of one cell."""
    return ((cell, ONE),)


def normalised_form(weights: Sequence[tuple[int, Fraction]]) -> Form:
    """The mean of cells with these weights, scaled to sum to 1."""
    total = sum((w for _, w in weights), Fraction(0))
    return tuple((i, w / total) for i, w in weights)


def stated_masses(population: Mapping[tuple[Label, Label], Any]) -> dict[tuple[Label, Label], Fraction]:
    """Read the masses of a stated population, by context and group."""
    masses = {(names(x), names(a)): Fraction(*option_value(v)) for (x, a), v in population.items()}
    if any(v < 0 for v in masses.values()) or not any(masses.values()):
        raise InputError("the population needs masses of at least 0, one of them positive")
    return masses


def form_mean(comparison: Comparison, form: Form) -> Fraction:
    """The form of the means of the draws; a cell without draws counts with the low end of its range."""
    cells = [(comparison.cells[i], w) for i, w in form]
    return sum((w * (cell.mean if cell.draws else cell.low) for cell, w in cells), Fraction(0))


def draws_of(comparison: Comparison, witness: Witness) -> tuple[int, int] | None:
    """How many draws the two groups of a pair have, each a cell of one block; None where the comparison has no such pair."""
    for (context, groups), forms in zip(comparison.labels, comparison.blocks, strict=True):
        if context == witness.context and witness.higher in groups and witness.lower in groups:
            higher, lower = (forms[groups.index(group)][0][0] for group in (witness.higher, witness.lower))
            return comparison.cells[higher].draws, comparison.cells[lower].draws
    return None


def witness_of(comparison: Comparison, found: Sequence[int] | None) -> Witness | None:
    """Name a block and the higher and the lower of its forms, with the means of their draws."""
    if found is None:
        return None
    block, higher, lower = found
    context, groups = comparison.labels[block]
    forms = comparison.blocks[block]
    return Witness(context, groups[higher], groups[lower], (form_mean(comparison, forms[higher]), form_mean(comparison, forms[lower])))
