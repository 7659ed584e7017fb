"""Scores cut in two, exactly: those above a number, or above the median of all of them, and the others."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from contextlib import suppress
from fractions import Fraction
from math import inf, nan
from types import NoneType
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from fairaudit.errors import InputError, shown
from fairaudit.exact.rationals import Number, decimal_text, option_value, parse_rational
from fairaudit.tables.columns import Missing, label_codes
from fairaudit.tables.label_text import label_text
from fairaudit.tables.labels import with_labels
from fairaudit.tables.number_form import bears_sign, plain_numbers
from fairaudit.tables.preparation import above, above_median
from fairaudit.tables.tally import Tally, counted
from fairaudit.tables.values import Locate, column, exact_floats, integers, locator, numbers
from fairaudit.words import noun

__all__ = ["ABOVE", "MEDIAN", "NOT_ABOVE", "Cut", "cut_scores", "score_cut"]


ABOVE, NOT_ABOVE = "above", "not above"

MEDIAN: Literal["median"] = "median"

Cut = Fraction | Literal["median"]


def score_cut(given: Number | None, spelled: str = "above") -> Cut:
    """Read where scores are cut: at their median, or at a number.

    Raises
    ------
    InputError
        If it is neither.

    Examples
    --------
    >>> score_cut("median"), score_cut("64.5")
    ('median', Fraction(129, 2))
    """
    if isinstance(given, str) and given == MEDIAN:
        return MEDIAN
    try:
        return Fraction(*option_value(given))
    except InputError as error:
        raise InputError(f"{spelled}: {error}; a number or 'median' is accepted") from None


def cut_scores(
    table: Any, score: str, cut: Cut, *, others: Sequence[str] = (), missing: Missing = "error", count: str | None = None
) -> Any:
    """Write the scores of a table as two labels, ``above`` and ``not above``, before it is counted; the certificate records the cut.

    A score is the number that its label says. *Above* is strict. The median is that of all decisions that are counted, those of unknown
    group among them; of an even number it is the mean of the two in the middle.

    Parameters
    ----------
    table : Tally, CsvTable, mapping of str to sequence, or frame of pandas or polars
        What `Law` takes.
    score : str
        Column of the scores.
    cut : Fraction or "median"
        What a score has to be above.
    others : sequence of str
        The other columns of labels; with ``missing="drop"`` rows without one of them are no part of the sample.
    missing : {"error", "drop", "group", "unknown", "undecided"}
        As for `Law.from_log`; rows without a score are left out, but for "error".
    count : str, optional
        Column of how often the row occurred.

    Returns
    -------
    Tally, CsvTable or PreparedTable
        The table with labels for scores.

    Raises
    ------
    InputError
        If a score is missing or not a number, or no score is above the cut.

    Examples
    --------
    >>> from fairaudit.model.law import Law
    >>> log = {"points": [70, 64, "65.0", 12], "sex": ["f", "f", "m", "m"]}
    >>> law = Law.from_log(cut_scores(log, "points", "median"), decision="points", group="sex")
    >>> law.decisions, law.preparation
    (('above', 'not above'), ({'step': 'above median', 'column': 'points', 'median': '129/2', 'of': '4'},))
    """
    where = locator(table)
    codes, values = _levels(table, score, where)

    def first(place: int) -> str:
        return where(int(np.flatnonzero(codes == place)[0]))

    values = plain_numbers(score, values, first) or values
    keys = np.append(_floats(values, score, first), nan)
    absent = np.isnan(keys)[codes]
    if absent.any() and missing in ("error", "undecided"):
        at, amount = where(int(np.flatnonzero(absent)[0])), int(counted(table, len(codes))[absent].sum())
        raise InputError(
            f"column {shown(score)}, {at}: the score is missing ({amount} in all); missing=drop (--missing drop) leaves such rows "
            "out, as do missing=group and missing=unknown, which keep those without a group"
        )
    kept = ~absent
    for own, _ in label_codes(table, others, where) if missing == "drop" else ():
        kept &= own >= 0
    if not kept.any():
        raise InputError("every row has a missing label; nothing is left to audit")
    weights, scale = _weights(table, count, kept, where)
    amounts = np.zeros(len(keys), dtype=weights.dtype)
    np.add.at(amounts, codes[kept], weights)
    limit = cut if cut != MEDIAN else _median(values, keys[:-1], amounts[:-1])
    higher = _higher(values, keys, limit)
    if amounts.any() and not amounts[higher].any():
        high = "the median" if cut == MEDIAN else "the number"
        why = ", because half of all or more have the highest one" if cut == MEDIAN else ""
        raise InputError(f"column {shown(score)}: no score is above {high} {decimal_text(limit)}{why}; there is nothing to compare")
    done = above(score, limit) if cut != MEDIAN else above_median(score, limit, Fraction(sum(amounts.tolist()), scale))
    places = np.where(absent, -1, np.where(higher, 0, 1)[codes])
    return with_labels(table, {score: (places, [ABOVE, NOT_ABOVE])}, (done,))


def _levels(table: Any, score: str, where: Locate) -> tuple[NDArray[np.int64], Sequence[Any]]:
    """The different scores, and which of them each row has; -1 may stand for a missing one."""
    if isinstance(table, Tally):
        column(table, score)  # which is there
        return table.codes[score], table.levels[score]
    [(codes, texts)] = label_codes(table, [score], where)
    return codes, texts


def _floats(values: Sequence[Any], score: str, where: Callable[[int], str]) -> NDArray[np.float64]:
    """The float next to each score: of two scores the greater one never has the smaller float. NaN where one is missing."""
    if {*map(type, values)} <= {int, float, NoneType}:
        with suppress(OverflowError):
            floats = np.array([nan if value is None else value for value in values], dtype=np.float64)
            if not np.isinf(floats).any():
                return floats
    found = []
    for place, value in enumerate(values):
        try:
            text = label_text(value)
            found.append(nan if text is None else _float(*parse_rational(text)))
        except InputError as error:
            raise InputError(f"column {shown(score)}, {where(place)}: {error}; scores are numbers{bears_sign(value)}") from None
    return np.array(found)


def _float(numerator: int, denominator: int) -> float:
    try:
        return numerator / denominator
    except OverflowError:
        return inf if numerator > 0 else -inf


def _exact(value: object) -> Fraction:
    """The number that the label of a score says."""
    return Fraction(*parse_rational(label_text(value) or ""))


def _weights(table: Any, count: str | None, kept: NDArray[np.bool_], where: Locate) -> tuple[NDArray[Any], int]:
    """How many decisions the rows that are kept stand for, as integers over one denominator."""
    times = counted(table, len(kept))[kept]
    if count is None:
        return times, 1
    places, held = np.flatnonzero(kept).tolist(), column(table, count)
    if len(held) != len(kept):
        raise InputError(
            f"column {shown(count)} has {len(held)} {noun(len(held), 'value')} and the scores {len(kept)}; they must be equally long"
        )
    weights, scale = numbers([held[place] for place in places], count, lambda position: where(places[position]), "share")
    if weights.dtype.kind == "f":
        weights, scale = exact_floats(weights)
    return integers([weight * n for weight, n in zip(weights.tolist(), times.tolist(), strict=True)]), scale


def _median(values: Sequence[Any], keys: NDArray[np.float64], amounts: NDArray[Any]) -> Fraction:
    """The score in the middle, or the mean of the two that are; missing ones come last."""
    order = np.argsort(keys, kind="stable")
    ranked = keys[order]
    starts = np.flatnonzero(np.append(True, ranked[1:] != ranked[:-1]) & ~np.isnan(ranked))
    ends = np.append(starts[1:], np.count_nonzero(~np.isnan(ranked)))
    for run in np.flatnonzero(ends - starts > 1).tolist():  # one float for several rationals
        part = slice(int(starts[run]), int(ends[run]))
        order[part] = sorted(order[part].tolist(), key=lambda place: _exact(values[place]))
    below = np.cumsum(amounts[order])
    left = below[-1] - below
    lower, upper = (_exact(values[order[int(np.argmax(reached))]]) for reached in (below >= left, below > left))
    return (lower + upper) / 2


def _higher(values: Sequence[Any], keys: NDArray[np.float64], limit: Fraction) -> NDArray[np.bool_]:
    """Which scores are above a number."""
    key = _float(limit.numerator, limit.denominator)
    higher = keys > key
    for place in np.flatnonzero(keys == key).tolist():
        higher[place] = _exact(values[place]) > limit
    return higher
