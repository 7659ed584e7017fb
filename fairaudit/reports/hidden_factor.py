"""An unrecorded factor that leaves no more of a ratio than T14 says, constructed for the pair with the greatest ratio."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from fractions import Fraction
from typing import TYPE_CHECKING

from fairaudit.theorems.t14 import HiddenContext, attaining
from fairaudit.theorems.t16 import Moving, can_drift
from fairaudit.words import approximate, place, plain

if TYPE_CHECKING:
    from fairaudit.audits.result import Result
    from fairaudit.measures.limits import Quantity
    from fairaudit.measures.ratios import Ratio

__all__ = ["factors_text", "just_enough"]


def just_enough(ratio: Fraction, hidden: HiddenContext) -> HiddenContext:
    """The same factor, but changing no more than it takes to explain the whole ratio.

    Examples
    --------
    >>> just_enough(Fraction(3, 2), HiddenContext.of("2,9")).m, just_enough(Fraction(3, 2), HiddenContext.of("2,3")).m
    (Fraction(4, 1), Fraction(3, 1))
    """
    if ratio * hidden.remaining >= 1:
        return hidden
    k = hidden.k
    least = {
        "both": lambda: (ratio * k - 1) / (k - ratio),
        "higher": lambda: ratio * (k - 1) / (k - ratio),
        "lower": lambda: (ratio * k - 1) / (k - 1),
    }[hidden.direction]()
    return replace(hidden, m=least)


def factors_text(result: Result) -> str:
    """For the local and the global ratio of a table, a factor as declared, or else one of the frontier of 1."""
    quantities: tuple[Quantity, ...] = ("local", "global")
    lines: list[str] = []
    for quantity, ratio in zip(quantities, (result.local, result.global_), strict=True):
        declared = [result.hidden_context] if result.hidden_context is not None else _of_frontier(result, quantity)
        if declared and ratio is not None and ratio.ratio > 1 and isinstance(ratio.ratio, Fraction):
            first, *rest = _lines(result, quantity, ratio, ratio.ratio, declared)
            lines += [f"  {quantity} ratio: {first}", *(f"    {line}" for line in rest)]
    return "\n".join(["A constructed factor, which the table does not rule out", *lines]) if lines else ""


def _of_frontier(result: Result, quantity: Quantity) -> list[HiddenContext]:
    """The pairs of the frontier of 1 of the table; none where decisions have no group, whose ends are shown instead."""
    levels = [found.levels[0] for found in result.explanations if found.quantity == quantity and found.interval is None]
    return [] if result.whoever else [HiddenContext(k, m) for level in levels for k, m in level.pairs]


def _lines(result: Result, quantity: Quantity, ratio: Ratio, seen: Fraction, declared: list[HiddenContext]) -> Iterator[str]:
    """The first of these factors that these decisions can have."""
    groups = [plain(place(labels)) for labels in (ratio.witness.higher, ratio.witness.lower)]
    for hidden in declared if can_drift(result.law, result.utility, quantity) else ():
        hidden = just_enough(seen, hidden)
        left = seen * hidden.remaining
        one, other, worths = attaining(hidden)
        laws, at = (one, other), int(hidden.direction != "lower")  # whose expectations m is about
        unit = ratio.witness.expectations[at] / sum((p * worth for p, worth in zip(laws[at], worths, strict=True)), Fraction(0))
        own = [unit * worth for worth in worths]
        gains = ([gain * left for gain in own], own) if at else (own, [gain / left for gain in own])
        if not _possible(result, quantity, ratio, laws, gains):
            continue
        where = f" in {plain(place(ratio.witness.context))}" if ratio.witness.context else ""
        shares = " and ".join(f"{_share(law[0])} of {group}" for law, group in zip(laws, groups, strict=True))
        yield f"an unrecorded factor that {shares} have{where}"
        for which, name in enumerate(("with it", "without it")):
            means = [f"{group} {approximate(gain[which])}" for law, group, gain in zip(laws, groups, gains, strict=True) if law[which]]
            yield f"{name}: {', '.join(means)}" + (f", a ratio of {approximate(left)}" if len(means) > 1 and own[which] else "")
        return
    yield "none is constructed, the decisions of the two groups cannot differ so much with it"


def _possible(
    result: Result,
    quantity: Quantity,
    ratio: Ratio,
    laws: tuple[tuple[Fraction, Fraction], tuple[Fraction, Fraction]],
    gains: tuple[list[Fraction], list[Fraction]],
) -> bool:
    """Whether those who have the factor can have that much of what the group got: no more than so great a part of it, the best first."""
    law, moving = result.law, Moving(result.law, result.utility, quantity)
    columns, witness = law.columns, ratio.witness
    for labels, shares, gain in zip((witness.higher, witness.lower), laws, gains, strict=True):
        group = law.groups.index(tuple(labels[name] for name in columns.group))
        if quantity == "global":
            i = list(law.global_groups).index(group)
        else:
            context = law.contexts.index(tuple((witness.context or {})[name] for name in columns.context))
            i = next(i for i, c in enumerate(moving.cells) if (law.cell_context[c], law.cell_group[c]) == (context, group))
        mean = moving.mean(i)
        start, slope = mean.contributed(shares[0], top=True)
        if shares[0] * gain[0] > (start + slope * shares[0]) / mean.bottom:
            return False
    return True


def _share(part: Fraction) -> str:
    """A share in words."""
    return {Fraction(0): "nobody", Fraction(1): "all"}.get(part, str(part) if part.denominator < 1000 else f"{approximate(100 * part)} %")
