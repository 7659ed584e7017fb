"""How far cells may drift while a verdict stands, and the worst and best ratio within a drift, in words."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from fractions import Fraction
from math import inf

from fairaudit.audits.drift import DriftedRatio, Pair, TableRadius
from fairaudit.exact.extended import Extended
from fairaudit.words import approximate, place, plain

HELD = "the contexts of each group staying distributed as they are"

ON_PAIRS = "no drift is stated for this verdict: its interval rests on pairs of cells, or on units, not on ends of single cells"


def radius_lines(found: TableRadius, quantity: str, name: Callable[[Mapping[str, str]], str] = place) -> Iterator[str]:
    r"""How far cells may move while a verdict stands.

    Examples
    --------
    >>> from fractions import Fraction
    >>> pair = ({"dept": "A"}, {"sex": "f"}, {"sex": "m"})
    >>> made = TableRadius("within", Fraction(31, 1000), True, Fraction(5, 4), True, pair, pair, of_population=False)
    >>> print("\n".join(radius_lines(made, "local")))
    valid unless an update changes more than 3.1 % of the decisions in some cell, or a probability by more than the factor 1.25
    the first to change it: dept=A, sex=f against sex=m
    """
    within = found.verdict == "within"
    than = "more than" if within else "at least"
    parts = []
    if found.radius != inf:
        parts.append(f"changes {than} {share(found.radius)} of the decisions in some cell")
    if found.factor is not None and found.factor != inf:
        by = approximate(found.factor, "down")
        parts.append(f"{'a probability' if parts else 'changes a probability'} by {than} the factor {by}")
    held = f" ({HELD})" if quantity == "global" else ""
    if not parts:
        yield f"valid whatever an update does to the decisions in the cells{held}"
        return
    if found.radius == 0 and within:
        yield f"the least update can change that{held}"
    else:
        yield f"valid unless an update {', or '.join(parts)}{held}"
    # It takes one pair above the limit to leave it, and none to keep it again.
    first = "the first to change it" if within else "the last pair above the limit"
    pair = found.pair or found.factor_pair
    if pair is not None:
        yield f"{first}: {pair_text(pair, name)}"
    if found.pair is not None and found.factor_pair not in (None, found.pair):
        yield f"{first} by a factor: {pair_text(found.factor_pair, name)}"


def share(value: Extended) -> str:
    """A share of decisions in percent, rounded down.

    Examples
    --------
    >>> share(Fraction(2, 3))
    '66.66 %'
    """
    return f"{approximate(100 * Fraction(value), 'down')} %"


def pair_text(pair: Pair, name: Callable[[Mapping[str, str]], str] = place) -> str:
    """Name a pair of groups, with the context if there is one."""
    context, higher, lower = pair
    where = f"{name(context)}, " if context else ""
    return plain(f"{where}{name(higher)} against {name(lower)}")


def drifted_line(found: DriftedRatio, drift: Fraction) -> str:
    """The worst and the best ratio within a declared drift.

    Examples
    --------
    >>> drifted_line(DriftedRatio("local", Fraction(11, 7), Fraction(1), None, None, "this law"), Fraction(1, 20))
    'from 1 to 1.572 within the declared drift, at most 5 % of the decisions in each cell'
    """
    ends = f"from {approximate(found.best, 'down')} to {approximate(found.worst, 'up')}"
    held = f", {HELD}" if found.quantity == "global" else ""
    return f"{ends} within the declared drift, at most {share(drift)} of the decisions in each cell{held}"
