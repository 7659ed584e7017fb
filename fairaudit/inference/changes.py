"""Change in a stream: windows whose interval has no ratio in common with that of the whole stream."""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction

from fairaudit.errors import InputError
from fairaudit.inference.anytime import Arrivals, stream_interval
from fairaudit.inference.interval import Interval
from fairaudit.inference.levels import constancy_error, window_share
from fairaudit.measures.limits import Quantity
from fairaudit.model.law import Law
from fairaudit.model.utility import UtilityTable
from fairaudit.words import brief


@brief
@dataclass(frozen=True, eq=False, repr=False)
class Window:
    """A part of a stream, counted by itself.

    Attributes
    ----------
    number : int
        Its number, from 1 on: the error that all windows share is divided as 1/(i(i + 1)).
    law : Law
        What was counted in it.
    utility : UtilityTable
        The utility on it.
    arrivals : Arrivals
        The order in which its own cells first appeared.
    """

    number: int
    law: Law
    utility: UtilityTable
    arrivals: Arrivals


@brief
@dataclass(frozen=True, eq=False, repr=False)
class Change:
    """A window that contradicts the stream: their intervals have no ratio in common.

    Attributes
    ----------
    quantity : {"local", "global"}
        Which ratio.
    window : Window
        The window.
    stream, part : Interval
        The interval of the whole stream until then, and that of the window.
    """

    quantity: Quantity
    window: Window
    stream: Interval
    part: Interval

    @property
    def confidence(self) -> Fraction:
        """One minus the probability that, for a constant ratio, the stream and a window up to this one ever contradict each other."""
        return 1 - constancy_error(1 - self.stream.confidence, 1 - self.part.confidence, self.window.number)

    @property
    def withdrawn(self) -> frozenset[Quantity]:
        """The ratios of which nothing is claimed any more: means that changed are behind both, the mix of contexts behind one."""
        return withdrawn_by(self.quantity, contexts=bool(self.window.law.columns.context))


def withdrawn_by(quantity: Quantity, *, contexts: bool) -> frozenset[Quantity]:
    """The ratios of which nothing is claimed any more once one of them changed.

    If the ratio within contexts changed, the means of cells did, and all rests on them. A global ratio also changes with the mix of
    contexts, if there are any, of which the ratio within them needs nothing.
    """
    return frozenset({"global"}) if quantity == "global" and contexts else frozenset({"local", "global"})


def disjoint(one: Interval, other: Interval) -> bool:
    """Whether two intervals have no ratio in common: not both come from one constant ratio."""
    return one.upper < other.lower or other.upper < one.lower


def change_of(stream: Interval, window: Window, quantity: Quantity, limits: tuple[Fraction, Fraction]) -> Change:
    """Prove that a window contradicts the stream.

    Raises
    ------
    InputError
        If their intervals have a ratio in common.
    """
    level = 1 - (1 - stream.confidence) * window_share(window.number)
    part = stream_interval(window.law, window.utility, window.arrivals, quantity, limits, level)
    if not disjoint(stream, part):
        raise InputError(f"window {window.number} does not contradict the stream: their intervals of the {quantity} ratio overlap")
    return Change(quantity, window, stream, part)
