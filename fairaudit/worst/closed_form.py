"""Classes with a range and one common floor: the worst utility in closed form (T3, T4, T6)."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from fractions import Fraction
from math import inf
from typing import Any, Literal

import numpy as np

from fairaudit.exact.enclosures import HUGE, UNIT
from fairaudit.exact.extended import ONE, ZERO, Extended
from fairaudit.worst.attained import raised_to_floor
from fairaudit.worst.evidence import pairs_by_sticks
from fairaudit.worst.most_powerful import Span
from fairaudit.worst.result import WorstCase
from fairaudit.worst.rows import ComparedRows, compared_rows
from fairaudit.worst.setting import Setting
from fairaudit.worst.sieve import Sieve


def closed_form_case(setting: Setting) -> WorstCase:
    """The worst utility of such a class, attained, with its proof.

    Source: T3 and T6; Coq `T3_class`, `T3_class_no_floor`.
    """
    of, rows = setting.of, compared_rows(setting)
    span = Span(of.gamma, of.m, of.floor)
    if not span.width:
        return _closed(setting, ONE, (int(rows.starts[0]), int(rows.starts[0]) + 1), [of.gamma] * rows.floats.shape[1], rows, lambda: [ONE])
    if not span.floor:
        ratio, column, pair = _greatest_quotient(rows)
        values = [ZERO] * rows.floats.shape[1]
        values[column] = of.gamma
        return _closed(setting, ratio, pair, values, rows, lambda: [ratio] if isinstance(ratio, Fraction) else [])
    sieve = Sieve(rows, span)
    best = sieve.run()
    return _closed(setting, best.ratio, best.pair, best.values, rows, sieve.multipliers)


def _greatest_quotient(rows: ComparedRows) -> tuple[Extended, int, tuple[int, int]]:
    """Greatest P(j|a)/P(j|a'), exact, with its column and pair.

    Source: T6; Coq `T6_local`, `T6_attained`.
    """
    floats, edges = rows.floats, rows.starts[:-1]
    error = (2 * floats.shape[1] + 16) * UNIT
    top, low = np.maximum.reduceat(floats, edges), np.minimum.reduceat(floats, edges)
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        quotient = np.where(low > 0, top / low, np.where(top > 0, np.inf, 1.0))
    tiny = (low < HUGE**-1) & (top > 0)
    upper = np.where(tiny, np.inf, quotient * (1 + 3 * error))
    lower = np.where(tiny, 1.0, quotient * (1 - 3 * error))
    best: tuple[Extended, int, tuple[int, int]] = (ONE, 0, (int(edges[0]), int(edges[0]) + 1))
    for block, column in np.argwhere(upper >= max(1.0, float(lower.max(initial=1.0)))).tolist():
        members = range(int(rows.starts[block]), int(rows.starts[block + 1]))
        near = floats[members.start : members.stop, column]
        highest, least = float(near.max()), float(near.min())
        wanted = [
            i
            for i, v in zip(members, near.tolist(), strict=True)
            if v >= highest * (1 - 3 * error) or v <= least * (1 + 3 * error) or v < HUGE**-1
        ]
        values = [(Fraction(row[column], sum(row)), i) for i in wanted for row in (rows.exact(i),)]
        (high, i), (small, j) = max(values, key=lambda e: (e[0], -e[1])), min(values)
        ratio: Extended = high / small if small else (inf if high else ONE)
        if ratio > best[0]:
            best = (ratio, column, (i, j))
        if ratio == inf:
            break
    return best


def _closed(
    setting: Setting,
    ratio: Extended,
    pair: tuple[int, int],
    values: Sequence[Fraction],
    rows: ComparedRows,
    multipliers: Callable[[], list[Fraction]],
) -> WorstCase:
    block, of, n = rows.block(pair[0]), setting.of, setting.n
    high, low = rows.sources[pair[0]], rows.sources[pair[1]]
    place = setting.places[block]
    table = {place: list(values)} if place is not None else {}
    if place is None:
        table = {i: list(values[i * n : (i + 1) * n]) for i in range(len(setting.contexts))}
    if ratio == 1:
        table = {i: [of.gamma] * n for i in range(len(setting.contexts))}
    lower, witness, raised = raised_to_floor(setting, block, (high, low), table)
    if lower != ratio:  # the theory says that this cannot be; if it were, the claims would still be right
        lower = min(lower, ratio)
    by: Literal["T3", "lp-dual"] = "T3" if of.tau is None or of.tau_on == "all" else "lp-dual"

    def proof() -> dict[str, Any]:
        if by == "T3":
            return {"multipliers": multipliers()}
        if not isinstance(ratio, Fraction):
            return {"pairs": []}
        return pairs_by_sticks(setting, ratio, multipliers())

    return WorstCase(
        law=setting.law,
        utility_class=of,
        quantity=setting.quantity,
        upper=ratio,
        lower=lower,
        witness=witness,
        method="closed form",
        by=by,
        setting=setting,
        values=raised,
        proof=proof,
    )
