"""The greatest ratio over all policies of a scope (T13): what was found, where it is attained, and what proves it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from fractions import Fraction

from fairaudit.exact.extended import Extended
from fairaudit.measures.limits import Quantity
from fairaudit.tables.values import Label
from fairaudit.theorems.bound import ANY_POLICY
from fairaudit.words import brief


@dataclass(frozen=True)
class Floors:
    """Declared floors that policies keep behind the filters.

    Attributes
    ----------
    cells : tuple of Fraction
        For each true context the floor τ_x of every group's expected utility there; 0 where there is none.
    overall : Fraction
        The floor of every group's mean over the contexts; 0 for none.
    """

    cells: tuple[Fraction, ...]
    overall: Fraction = Fraction(0)

    def __bool__(self) -> bool:
        """Whether there is any floor."""
        return any(self.cells) or self.overall > 0


@dataclass(frozen=True)
class PairProof:
    """Multipliers of floors that bound the ratio of one ordered pair of groups.

    Attributes
    ----------
    context : int or None
        Position of the true context; None for group means.
    higher, lower : int
        Positions of the true groups.
    floors : mapping of (int or None, int) to Fraction
        The multiplier y of the floor of a context (None: of the mean) and a group.
    """

    context: int | None
    higher: int
    lower: int
    floors: Mapping[tuple[int | None, int], Fraction]


@brief
@dataclass(frozen=True, repr=False)
class Supremum:
    """The greatest ratio that any policy of a scope attains behind given filters, for a given utility.

    Attributes
    ----------
    quantity : {"local", "global"}
        Whether expected utilities are compared within contexts, or group means.
    value : Fraction or float
        The greatest ratio, at least 1; `math.inf` where some policy gives one group nothing and another something.
    exact : bool
        Whether the value is attained; if not it is an upper bound.
    context : tuple of str or None
        The context in which it is attained; None for group means, and where the value is 1.
    higher, lower : tuple of str or None
        The two groups; None where the value is 1.
    multipliers : tuple of Fraction
        With floors: k of which one proves the value for each ordered pair that `pairs` does not list.
    pairs : tuple of PairProof
        With floors: proofs of single ordered pairs.
    rows : tuple of tuple of Fraction
        With floors, and near a policy: the policy that attains it, a distribution of decisions for each released context and group that is
        reachable; empty where the value is 1 or not attained.
    scope : str
        Which policies it is the greatest ratio of.
    assumptions : tuple of str
        What the reader must accept.
    """

    quantity: Quantity
    value: Extended
    exact: bool = True
    context: Label | None = None
    higher: Label | None = None
    lower: Label | None = None
    multipliers: tuple[Fraction, ...] = field(default=(), repr=False)
    pairs: tuple[PairProof, ...] = field(default=(), repr=False)
    rows: tuple[tuple[Fraction, ...], ...] = field(default=(), repr=False)
    scope: str = ANY_POLICY
    assumptions: tuple[str, ...] = field(default=(), repr=False)
