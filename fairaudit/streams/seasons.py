"""Seasons: what pairs in time say of the local ratio where means may move, and whether they contradict the interval of the whole stream."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from fractions import Fraction
from math import inf

from fairaudit.inference.time_pairs import PairedEnds, TimePairs, paired_ends
from fairaudit.inference.verdicts import Verdict, foremost_verdict, verdict
from fairaudit.measures.limits import LIMITS, Quantity
from fairaudit.measures.ratios import Witness
from fairaudit.streams.looks import ByTime, Look, interval_of
from fairaudit.streams.settings import Settings
from fairaudit.streams.subjects import Subject
from fairaudit.tables.values import Label

Cells = Mapping[tuple[Label, Label], int]


def by_time(settings: Settings, cells: Cells, tallies: TimePairs, whole: Subject | None) -> ByTime:
    """What pairs in time show of the local ratio, by an error of their own, and whether they contradict that of the whole stream."""
    alpha = 1 - Fraction(settings.confidence)
    blocks: dict[Label, list[int]] = {}
    for (context, _), rank in cells.items():
        blocks.setdefault(context, []).append(rank)

    def ends_of(*, exact: bool) -> PairedEnds:
        return paired_ends(tallies, list(blocks.values()), settings.expected, settings.limits[1], alpha, exact=exact)

    def exceeded(ends: PairedEnds) -> tuple[str, ...]:
        judged = {name: f"max_{LIMITS[name][1]}" for name in _asked(settings)}
        limits = settings.targets or {}
        return tuple(name for name, unit in judged.items() if verdict((ends.lower, inf), **{unit: limits[name]}) == "exceeds")

    def confounded(ends: PairedEnds, *, exact: bool) -> bool:
        pooled = interval_of(settings, whole, "local", exact=exact)
        return pooled is not None and (pooled.upper < ends.lower or ends.upper < pooled.lower)

    ends = ends_of(exact=False)
    confounds = confounded(ends, exact=False)
    above = exceeded(ends)
    if confounds or above:
        ends = ends_of(exact=True)
        above, confounds = exceeded(ends), confounds and confounded(ends, exact=True)
    pair = None if ends.pair is None else _witness(settings, cells, tallies, ends.pair)
    error = min(Fraction(1), alpha + settings.alpha)
    return ByTime(tallies.pairs, float(ends.lower), float(ends.upper), 1 - alpha, above, pair, confounds, error)


def judged_by_time(settings: Settings, found: Look, paired: ByTime) -> Look:
    """Judge again with what pairs in time show: a target that was exceeded at some time is; what seasons confound decides nothing."""
    verdicts: dict[str, Verdict] = dict(found.verdicts)
    pairs = dict(found.pairs)
    for name in _asked(settings):
        if verdicts[name] == "changed":
            continue
        if name in paired.exceeded:
            pairs[name] = pairs[name] if verdicts[name] == "exceeds" else paired.pair
            verdicts[name] = "exceeds"
        elif paired.confounds:
            verdicts[name] = "inconclusive"
    overall: Verdict = found.verdict if found.verdict == "changed" else foremost_verdict(verdicts.values())
    return replace(found, verdicts=verdicts, verdict=overall, pairs=pairs, by_time=paired)


def compared(settings: Settings) -> frozenset[Quantity]:
    """The ratios that pairs in time are about: the local one, which is the global one where there are no contexts."""
    return frozenset({"local"} if settings.context else {"local", "global"})


def _asked(settings: Settings) -> list[str]:
    return [name for name in settings.targets or {} if LIMITS[name][0] in compared(settings)]


def _witness(settings: Settings, cells: Cells, tallies: TimePairs, pair: tuple[int, int]) -> Witness:
    """The labels of two cells, and their means in the pairs."""
    labels = {rank: cell for cell, rank in cells.items()}
    tally = tallies.of(*pair)
    one, other = (sum((values[k] * n for values, n in tally.items()), Fraction(0)) / sum(tally.values()) for k in (0, 1))
    higher, lower = (dict(zip(settings.group, labels[rank][1], strict=True)) for rank in pair)
    return Witness(dict(zip(settings.context, labels[pair[0]][0], strict=True)), higher, lower, (one, other))
