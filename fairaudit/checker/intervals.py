"""Intervals for the population behind a sample, with their evidence, as the certificate states them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from hashlib import sha256
from itertools import pairwise

from .claims import BETTING, METHODS, ONE_SIDED, OVER_UNITS, POPULATION
from .figures import EXPECTED_DIFFERENCES
from .header import Columns, Subject
from .json_values import (
    canonical_text,
    read_boolean,
    read_choice,
    read_digest,
    read_integer,
    read_list,
    read_object,
    read_string,
    read_strings,
)
from .metrics import read_metric
from .moved_ends import EndMove, Found
from .rationals import Rational, as_pair, read_extended, read_pairs, read_rational, read_rationals, read_two, read_two_signed
from .text import malformed, shown


@dataclass(frozen=True)
class Change:
    """A window of a stream that contradicts the whole stream until then, as the certificate states it."""

    quantity: str
    window: int
    confidence: Fraction
    stream: Interval
    digest: str
    cells: int
    lines: tuple[object, ...]  # the header and the rows of the window's table
    ratio: Interval
    assumptions: tuple[str, ...]


class Unproven(Exception):
    """The evidence of an interval does not prove it."""


REGIONS = ("box", "product", "pairs", "contrasts", "paired")
MOST_RATIOS = 8  # of bets on two cells at once

Ladder = list[Fraction]
Box = list[tuple[Fraction, Fraction]]
Ends = list[tuple[Rational, Rational]]  # a box of many means, in integers
Place = tuple[int, int, int]  # a block, and the positions of two forms in it, the higher one first


@dataclass(frozen=True)
class Listed:
    """Ends of some cells; those of the others follow."""

    cells: list[int]
    ends: Ends


@dataclass(frozen=True)
class BoxEvidence:
    """Ends of all cells, or of some of them, at the levels for the upper and for the lower end of the ratio."""

    levels: tuple[Fraction, Fraction]
    upper: Ends | Listed
    lower: Ends | Listed
    pair: Place | None


@dataclass(frozen=True)
class LadderEvidence:
    """Ladders for the upper end by block, and one for the lower end; the levels are (b, c)."""

    levels: tuple[tuple[Fraction, Fraction], tuple[Fraction, Fraction]]
    upper: list[Ladder] | None
    lower: tuple[Place, Ladder] | None


@dataclass(frozen=True)
class PairEvidence:
    """Ladders for the upper end, one for each ordered pair of each block in turn, and one for the lower end; the levels are of one pair.

    With a seed one half of the draws chose the pair of the lower end, and the other half proves it.
    """

    levels: tuple[Fraction, Fraction]
    upper: list[Ladder] | None
    lower: tuple[Place, Ladder] | None
    seed: str | None


@dataclass(frozen=True)
class ContrastEvidence:
    """The levels of one pair, and the pair that proves the lower end: all else follows from the draws."""

    levels: tuple[Fraction, Fraction]
    pair: Place | None


Profile = tuple[Fraction | None, ...]  # what a unit got in each group of a block, None where it was not seen


@dataclass(frozen=True)
class UnitEvidence:
    """By block how many units got what in its groups, with the digest of the list; units that are missing in a group may be dropped."""

    levels: tuple[Fraction, Fraction]
    profiles: list[dict[Profile, int]]
    digest: str
    drop: bool


@dataclass(frozen=True)
class StreamEvidence:
    """Of a stream: the ranks of its cells and how many were expected; ends of all cells with a pair, or ladders."""

    expected: int
    order: list[int]
    ends: Box | None
    pair: Place | None
    ladders: list[Ladder] | None
    proof: tuple[Place, Ladder] | None
    ratios: tuple[Fraction, ...] = ()  # of bets on two cells at once; without them bets are on single cells


Evidence = BoxEvidence | LadderEvidence | PairEvidence | ContrastEvidence | UnitEvidence | StreamEvidence


@dataclass(frozen=True)
class Interval:
    """An interval of a ratio, or of a difference of expectations, as the certificate states it."""

    quantity: str
    confidence: Rational
    each: bool  # whether the confidence is that of each end by itself, not of both together
    scope: str
    independent: bool
    method: str
    limits: tuple[Fraction, Fraction] | None
    units: list[list[tuple[int, list[int]]]] | None
    measured: dict[str, object] | None  # with units, what their means give in the sample
    ratio: tuple[Rational, Rational]
    evidence: Evidence
    difference: bool = False  # whether the ends, which stand under ``ratio``, are those of a difference

    @property
    def region(self) -> str:
        """The name of the kind of evidence."""
        if isinstance(self.evidence, PairEvidence | ContrastEvidence):
            return "pairs" if isinstance(self.evidence, PairEvidence) else "contrasts"
        if isinstance(self.evidence, StreamEvidence) and self.evidence.ratios:
            return "joint"
        if isinstance(self.evidence, UnitEvidence):
            return "paired"
        boxed = self.evidence.ends is not None if isinstance(self.evidence, StreamEvidence) else isinstance(self.evidence, BoxEvidence)
        return "box" if boxed else "product"


@dataclass(frozen=True)
class Boxed:
    """Ends of the means of single cells that an interval proves, for its upper end and for its lower one, and the ranges of the cells."""

    upper: Box
    lower: Box
    ranges: Box


@dataclass(frozen=True)
class Proven:
    """An interval that holds but with the probability ``error``, of each end if it is so, and what claims about it have to say.

    The ends of single cells, where it proves any, or, of cells that passed, what follows where they move.
    """

    ratio: tuple[Rational, Rational]
    error: Fraction
    scope: str
    by: str
    each: bool = False
    boxed: Boxed | Mapping[EndMove, Found] | None = None


def _read_difference(value: object, where: str, name: str) -> Interval:
    """Read an interval of a greatest difference of rates, with ends of all rates in use."""
    members = read_object(value, where, ("confidence", "levels", "upper", "lower", "difference"))
    levels = read_object(members["levels"], f"{where}.levels", ("upper", "lower"))
    upper, lower = (read_pairs(members[side], f"{where}.{side}") for side in ("upper", "lower"))
    low, high = read_rationals(members["difference"], f"{where}.difference", 2)
    box = BoxEvidence(
        (_level(levels["upper"], f"{where}.levels.upper"), _level(levels["lower"], f"{where}.levels.lower")), upper, lower, None
    )
    confidence = as_pair(read_confidence(members["confidence"], f"{where}.confidence"))
    scope = POPULATION + read_string(members["confidence"], f"{where}.confidence")
    return Interval(name, confidence, False, scope, False, METHODS[0], None, None, None, (low, high), box, difference=True)


def read_confidence(value: object, where: str) -> Fraction:
    """Read a confidence, which is between 0 and 1."""
    confidence = Fraction(*read_rational(value, where))
    if not 0 < confidence < 1:
        raise malformed(where, "must have a confidence between 0 and 1")
    return confidence


def read_intervals(
    value: object, where: str, subject: Subject, differences: Sequence[str]
) -> tuple[dict[str, Interval], dict[str, Interval]]:
    """Read the intervals, those of ratios and differences of expectations and those of differences of rates."""
    members = read_object(value, where, (), optional=("local", "global", *EXPECTED_DIFFERENCES, *differences))
    if not members:
        raise malformed(where, "must not be empty")
    ratios = {name: _read_interval(members[name], f"{where}.{name}", name, subject) for name in members if name not in differences}
    return ratios, {name: _read_difference(members[name], f"{where}.{name}", name) for name in members if name in differences}


def _read_interval(value: object, where: str, name: str, subject: Subject) -> Interval:
    difference = name in EXPECTED_DIFFERENCES
    given = "difference" if difference else "ratio"
    keys = ["confidence", "ends", "region", "independent", "method", "limits", given, "levels"]
    of_box, of_units = (isinstance(value, dict) and value.get("region") == kind for kind in ("box", "paired"))
    keys += ["missing", "profiles"] if of_units else ["upper", "lower"]
    of_stream = isinstance(value, dict) and value.get("method") == BETTING and not difference
    if name.startswith("local") and subject.kind == "counts" and not of_stream and isinstance(value, dict) and "units" in value:
        keys += ["units", "estimand", "measured"]
    of_contrasts = isinstance(value, dict) and value.get("region") == "contrasts"
    splits = subject.kind == "counts" and isinstance(value, dict) and value.get("region") == "pairs" and not difference
    optional = ("split",) if splits else ()
    members = read_object(value, where, keys + ["pair"] * ((of_box and not difference) or of_contrasts), optional=optional)
    each = read_choice(members["ends"], f"{where}.ends", ("together",) if of_stream else ("together", "each")) == "each"
    region = read_choice(members["region"], f"{where}.region", ("box", "product", "joint") if of_stream else REGIONS)
    of_levels = ("expected", "order", *(("ratios",) if region == "joint" else ())) if of_stream else ("upper", "lower")
    levels = read_object(members["levels"], f"{where}.levels", of_levels)
    upper, lower = members.get("upper"), members.get("lower")
    pair = None if members.get("pair") is None else _read_pair(members["pair"], f"{where}.pair")
    evidence: Evidence
    if of_units:
        one, other = (_level(levels[name], f"{where}.levels.{name}") for name in ("upper", "lower"))
        drop = read_choice(members["missing"], f"{where}.missing", ("worst", "drop")) == "drop"
        profiles = _read_profiles(members["profiles"], f"{where}.profiles")
        evidence = UnitEvidence((one, other), profiles, sha256(canonical_text(members["profiles"])).hexdigest(), drop)
    elif of_stream:
        evidence = _read_stream(members, levels, where, of_box)
    elif of_box:
        evidence = BoxEvidence(
            (_level(levels["upper"], f"{where}.levels.upper"), _level(levels["lower"], f"{where}.levels.lower")),
            _read_ends(upper, f"{where}.upper", difference),
            _read_ends(lower, f"{where}.lower", difference),
            pair,
        )
    elif of_contrasts:
        if upper is not None or lower is not None:
            raise malformed(where, "must have null as upper and as lower")
        evidence = ContrastEvidence(
            (_level(levels["upper"], f"{where}.levels.upper"), _level(levels["lower"], f"{where}.levels.lower")), pair
        )
    else:
        proof = None if lower is None else read_object(lower, f"{where}.lower", ("pair", "knots"))
        listed = None if upper is None else read_list(upper, f"{where}.upper")
        ladders = None if listed is None else [_read_ladder(item, f"{where}.upper[{i}]") for i, item in enumerate(listed)]
        least = (
            None if proof is None else (_read_pair(proof["pair"], f"{where}.lower.pair"), _read_ladder(proof["knots"], f"{where}.lower"))
        )
        if region == "pairs":
            one, other = (_level(levels[name], f"{where}.levels.{name}") for name in ("upper", "lower"))
            seed = None
            if "split" in members:
                split = read_object(members["split"], f"{where}.split", ("seed",))
                seed = read_digest(split["seed"], f"{where}.split.seed")
            evidence = PairEvidence((one, other), ladders, least, seed)
        else:
            two = read_two(levels["upper"], f"{where}.levels.upper"), read_two(levels["lower"], f"{where}.levels.lower")
            evidence = LadderEvidence(two, ladders, least)
    limits = None if members["limits"] is None else (read_two_signed if difference else read_two)(members["limits"], f"{where}.limits")
    if limits is not None and limits[0] > limits[1]:
        raise malformed(f"{where}.limits", "must have the lower one first")
    ends = read_list(members[given], f"{where}.{given}", 2)
    last = read_rational(ends[1], f"{where}.{given}[1]") if difference else read_extended(ends[1], f"{where}.{given}[1]")
    surely = of_box and not of_stream and not difference  # a group that is certain to get nothing makes the ratio infinite
    first = (read_extended if surely else read_rational)(ends[0], f"{where}.{given}[0]")
    confidence = read_confidence(members["confidence"], f"{where}.confidence")
    return Interval(
        name.removesuffix("_difference"),
        as_pair(confidence),
        each,
        (ONE_SIDED if each else POPULATION) + read_string(members["confidence"], f"{where}.confidence"),
        read_boolean(members["independent"], f"{where}.independent"),
        read_choice(members["method"], f"{where}.method", METHODS if difference else (*METHODS, BETTING)),
        limits,
        _read_units(members["units"], f"{where}.units") if "units" in members else None,
        _read_measured(members, where, name, subject.columns) if "units" in members else None,
        (first, last),
        evidence,
        difference,
    )


def read_change(value: object, where: str, subject: Subject) -> Change:
    """Read the window of a stream that contradicts the stream."""
    keys = ("quantity", "window", "confidence", "stream", "table", "ratio", "assumptions")
    members = read_object(value, where, keys)
    quantity = read_choice(members["quantity"], f"{where}.quantity", ("local", "global"))
    window = read_integer(members["window"], f"{where}.window")
    if subject.kind != "counts" or window == 0:
        raise malformed(where, "must be about counts, and a window with a number of at least 1")
    stream, ratio = (_read_interval(members[name], f"{where}.{name}", quantity, subject) for name in ("stream", "ratio"))
    if not isinstance(stream.evidence, StreamEvidence) or not isinstance(ratio.evidence, StreamEvidence):
        raise malformed(where, f"must have intervals of a stream, by the method {shown(BETTING)}")
    table = read_object(members["table"], f"{where}.table", ("sha256", "cells", "header", "rows"))
    return Change(
        quantity,
        window,
        read_confidence(members["confidence"], f"{where}.confidence"),
        stream,
        read_digest(table["sha256"], f"{where}.table.sha256"),
        read_integer(table["cells"], f"{where}.table.cells"),
        (table["header"], *read_list(table["rows"], f"{where}.table.rows")),
        ratio,
        read_strings(members["assumptions"], f"{where}.assumptions"),
    )


def _read_stream(members: Mapping[str, object], levels: Mapping[str, object], where: str, of_box: bool) -> StreamEvidence:
    expected = read_integer(levels["expected"], f"{where}.levels.expected")
    listed = read_list(levels["order"], f"{where}.levels.order")
    order = [read_integer(rank, f"{where}.levels.order[{i}]") for i, rank in enumerate(listed)]
    if expected == 0 or 0 in order or len(set(order)) != len(order):
        raise malformed(f"{where}.levels", "must have different ranks, all numbers being at least 1")
    upper, lower = members["upper"], members["lower"]
    if of_box:
        ends, again = (
            [read_two(item, f"{where}.{name}[{i}]") for i, item in enumerate(read_list(members[name], f"{where}.{name}"))]
            for name in ("upper", "lower")
        )
        if ends != again:
            raise malformed(f"{where}.lower", "must be the same as upper")
        return StreamEvidence(
            expected, order, ends, None if members["pair"] is None else _read_pair(members["pair"], f"{where}.pair"), None, None
        )
    ladders = (
        None if upper is None else [_read_ladder(item, f"{where}.upper[{i}]") for i, item in enumerate(read_list(upper, f"{where}.upper"))]
    )
    proof = None
    if lower is not None:
        parts = read_object(lower, f"{where}.lower", ("pair", "knots"))
        proof = _read_pair(parts["pair"], f"{where}.lower.pair"), _read_ladder(parts["knots"], f"{where}.lower")
    ratios: tuple[Fraction, ...] = ()
    if "ratios" in levels:
        given = read_list(levels["ratios"], f"{where}.levels.ratios")
        ratios = tuple(Fraction(*ratio) for ratio in read_rationals(given, f"{where}.levels.ratios", len(given)))
        if not 1 <= len(ratios) <= MOST_RATIOS or min(ratios) <= 0:
            raise malformed(f"{where}.levels.ratios", f"must be 1 to {MOST_RATIOS} positive numbers")
    return StreamEvidence(expected, order, None, None, ladders, proof, ratios)


def _level(value: object, where: str) -> Fraction:
    return Fraction(*read_rational(value, where, nonnegative=True))


def _read_ends(value: object, where: str, difference: bool) -> Ends | Listed:
    """Read the ends of all cells, or, of a ratio, those of some."""
    if difference or not isinstance(value, dict):
        return read_pairs(value, where, difference)
    members = read_object(value, where, ("cells", "ends"))
    cells = [read_integer(item, f"{where}.cells[{i}]") for i, item in enumerate(read_list(members["cells"], f"{where}.cells"))]
    if any(i >= j for i, j in pairwise(cells)):
        raise malformed(f"{where}.cells", "must be strictly rising")
    read_list(members["ends"], f"{where}.ends", len(cells))
    return Listed(cells, read_pairs(members["ends"], f"{where}.ends"))


def _read_ladder(value: object, where: str) -> Ladder:
    return [Fraction(*knot) for knot in read_rationals(value, where, len(read_list(value, where)))]


def _read_pair(value: object, where: str) -> Place:
    block, higher, lower = (read_integer(item, f"{where}[{i}]") for i, item in enumerate(read_list(value, where, 3)))
    return block, higher, lower


def _read_measured(members: Mapping[str, object], where: str, name: str, columns: Columns) -> dict[str, object]:
    read_choice(members["estimand"], f"{where}.estimand", (OVER_UNITS,))
    metric = read_metric(members["measured"], f"{where}.measured", name, columns)
    if metric is None:
        raise malformed(f"{where}.measured", "must not be null")
    return metric


def _read_profiles(value: object, where: str) -> list[dict[Profile, int]]:
    known: dict[object, Fraction | None] = {None: None}
    blocks: list[dict[Profile, int]] = []
    for i, entries in enumerate(read_list(value, where)):
        units: dict[Profile, int] = {}
        for j, item in enumerate(read_list(entries, f"{where}[{i}]")):
            place = f"{where}[{i}][{j}]"
            number, listed = read_list(item, place, 2)
            texts = read_list(listed, f"{place}[1]")
            for k, text in enumerate(texts):
                if not (text is None or (isinstance(text, str) and text in known)):
                    known[text] = Fraction(*read_rational(text, f"{place}[1][{k}]", nonnegative=True))
            profile = tuple(known[text] for text in texts)
            if profile in units or all(got is None for got in profile):
                raise malformed(f"{place}[1]", "must not be all null, nor what stood there before")
            units[profile] = read_integer(number, f"{place}[0]")
            if units[profile] == 0:
                raise malformed(f"{place}[0]", "must be at least 1")
        blocks.append(units)
    return blocks


def _read_units(value: object, where: str) -> list[list[tuple[int, list[int]]]]:
    lists: list[list[tuple[int, list[int]]]] = []
    for i, entries in enumerate(read_list(value, where)):
        units: dict[tuple[int, ...], int] = {}
        for j, item in enumerate(read_list(entries, f"{where}[{i}]")):
            place = f"{where}[{i}][{j}]"
            number, counts = read_list(item, place, 2)
            rows = tuple(read_integer(count, f"{place}[1][{u}]") for u, count in enumerate(read_list(counts, f"{place}[1]")))
            if rows in units or not any(rows):
                raise malformed(f"{place}[1]", "must not be all 0, nor what stood there before")
            units[rows] = read_integer(number, f"{place}[0]")
            if units[rows] == 0:
                raise malformed(f"{place}[0]", "must be at least 1")
        lists.append([(n, list(rows)) for rows, n in units.items()])
    return lists
