"""The global ratio where the population is itself known from a sample alone."""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction
from typing import Any

from fairaudit.errors import InputError
from fairaudit.exact.extended import extended_text
from fairaudit.inference.cells import Cell, Ends, cell_entries
from fairaudit.inference.comparisons import Comparison, unit_form
from fairaudit.inference.ends import Method, cell_ends, ends_of_cells
from fairaudit.inference.interval import Interval
from fairaudit.inference.levels import confidence_level, equal_share
from fairaudit.inference.quotients import extreme_ratio
from fairaudit.theorems.assumptions import POPULATION_DRAWS


def sampled_population_interval(
    comparison: Comparison, counts: Sequence[Sequence[int]], confidence: Any = "0.95", *, method: Method = "hoeffding-kl"
) -> Interval:
    """Bound the global ratio when P(x|a) is itself estimated, from a sample of its own, in the same error.

    P(·|a) lies in the box of its binomial ends and sums to 1; over that region the greatest and least group means are found exactly, by
    filling up the contexts in order. The two groups of a pair are taken apart (a shared cell may be at its upper end in one and at its
    lower in the other), which is sound and not tight.

    Parameters
    ----------
    comparison : Comparison
        A local comparison: for each context a block with a form for each group, in the same order.
    counts : sequence of sequence of int
        How often each context (row) was seen for each group (column).
    confidence, method
        As for `ratio_interval`.

    Returns
    -------
    Interval
        Of the global ratio.

    Raises
    ------
    InputError
        If the counts do not fit.
    """
    level = confidence_level(confidence)
    groups = len(comparison.blocks[0]) if comparison.blocks else 0
    if len(counts) != len(comparison.blocks) or any(len(row) != groups for row in counts) or groups < 2:
        raise InputError("the counts of contexts need one row for each context and one column for each of at least two groups")
    if any(len(block) != groups for block in comparison.blocks):
        raise InputError("an estimated population needs every group in every context")
    if any(not isinstance(n, int) or isinstance(n, bool) or n < 0 for row in counts for n in row):
        raise InputError("an estimated population needs whole counts of at least 0")
    totals = [sum(row[a] for row in counts) for a in range(groups)]
    if 0 in totals:
        raise InputError("an estimated population needs at least one draw of every group")
    used = len(comparison.used)
    shares = len(counts) * groups if len(counts) > 1 else 0
    end = equal_share(1 - level, 2 * (used + shares)) if used + shares else Fraction(1, 2)
    ends = ends_of_cells(comparison, end, method)
    population = [
        [cell_ends(Cell(totals[a], Fraction(row[a]), None, Fraction(0), Fraction(1), True), end) for row in counts] for a in range(groups)
    ]
    means = []
    for a in range(groups):
        low, high = ([sum((w * ends[i][side] for i, w in block[a]), Fraction(0)) for block in comparison.blocks] for side in (0, 1))
        means.append((-_fill([-v for v in low], population[a]), _fill(high, population[a])))
    box = Comparison(comparison.cells, (tuple(unit_form(a) for a in range(groups)),))
    upper, _ = extreme_ratio(box, means, upper=True)
    lower, _ = extreme_ratio(box, means, upper=False)
    estimate = None
    if all(cell.draws for cell in comparison.cells):
        point = [
            sum(
                (
                    Fraction(row[a], totals[a]) * w * comparison.cells[i].mean
                    for row, block in zip(counts, comparison.blocks, strict=True)
                    for i, w in block[a]
                ),
                Fraction(0),
            )
            for a in range(groups)
        ]
        estimate, _ = extreme_ratio(box, [(v, v) for v in point], upper=True)
    evidence = {
        "confidence": extended_text(level),
        "method": method,
        "cells": cell_entries(comparison.cells),
        "blocks": [[[[i, extended_text(w)] for i, w in form] for form in block] for block in comparison.blocks],
        "counts": [list(row) for row in counts],
        "level": extended_text(end),
        "ends": [[extended_text(a), extended_text(b)] for a, b in ends],
        "population": [[[extended_text(a), extended_text(b)] for a, b in row] for row in population],
    }
    kinds = {"binomial", *("binomial" if comparison.cells[i].binary else method for i in comparison.used)}
    assumptions = (*comparison.assumptions, POPULATION_DRAWS)
    return Interval(lower, upper, estimate, level, "box", tuple(sorted(kinds)), assumptions, evidence)


def _fill(values: Sequence[Fraction], shares: Sequence[Ends]) -> Fraction:
    """Maximise Σ p·v over lo ≤ p ≤ hi, Σ p = 1: raise p from lo in falling order of v."""
    rest = 1 - sum(low for low, _ in shares)
    total = sum((low * v for (low, _), v in zip(shares, values, strict=True)), Fraction(0))
    for v, (low, high) in sorted(zip(values, shares, strict=True), key=lambda pair: -pair[0]):
        step = min(rest, high - low)
        total += step * v
        rest -= step
    return total
