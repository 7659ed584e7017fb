"""Intervals by boxes of ends, judged by the verified program as by the other: many cells, of which few are listed, and many draws.

One alteration in 8 in .ci/run; all: FAIRAUDIT_FULL=1 pytest -s tests/whole/test_verified_ends.py
"""

from __future__ import annotations

import json
from collections.abc import Iterator
from fractions import Fraction
from pathlib import Path
from random import Random as Pick
from typing import Any

import tiers
from certificate_changes import put
from certificate_kinds import as_bytes
from verified_roads import FALSE, MALFORMED, TRUE, Tally, natively

import fairaudit as fa


def with_plain_ends() -> list[dict[str, Any]]:
    """True certificates whose intervals list the ends of the cells that decide alone: of few and of many draws, none in some cells."""
    pick, found = Pick(7), []
    for contexts, groups, most in ((60, 3, 40), (120, 2, 6), (30, 5, 300)):
        counts = [[[pick.randrange(most), pick.randrange(1, most)] for _ in range(groups)] for _ in range(contexts)]
        law = fa.Law.from_array(counts, kind="counts")
        for worth, options in (("1", {}), ("2/7", {"confidence": "9/10"}), ("3", {"max_local_ratio": "3/2"})):
            found.append(fa.certify(law, {"0": Fraction(worth)}, **{"confidence": "19/20", **options}).certificate.document)
    return found


def changed_plain_ends(document: dict[str, Any]) -> Iterator[dict[str, Any]]:
    text, interval = json.dumps(document), document["intervals"]["local"]
    for side, other in (("upper", "lower"), ("lower", "upper")):
        at, cells, ends = ("intervals", "local", side), interval[side]["cells"], interval[side]["ends"]
        for listed in (
            [],
            cells[1:],
            cells[::-1],
            [*cells[:-1], sum(cells[-1:]) + 1],
            [*cells[:-1], 10**6],
            [*cells, 10**30],
            [-1, *cells[1:]],
            None,
        ):
            yield put(text, (*at, "cells"), listed)
        for listed in ([], ends[1:], ends[::-1], [[high, low] for low, high in ends], [["0", "1000"]] * len(ends), None):
            yield put(text, (*at, "ends"), listed)
        yield put(text, at, {"cells": [], "ends": []})
        yield put(text, at, {"cells": [10**6], "ends": [["0", "1"]]})
        yield put(text, at, {**interval[side], "more": []})
        yield put(text, at, interval[other])
        yield put(text, at, ends)
        level = Fraction(interval["levels"][side])
        for near in (level / 2, 2 * level, level + Fraction(1, 10**12), Fraction(0), Fraction(1)):
            yield put(text, ("intervals", "local", "levels", side), str(near))
    for i, end in enumerate(interval["ratio"]):
        if end != "inf":
            for near in (Fraction(end) * (1 + Fraction(s, 10**9)) for s in (-1, 1)):
                yield put(text, ("intervals", "local", "ratio", i), str(near))


def with_many_draws() -> list[dict[str, Any]]:
    """True certificates of cells in which up to 40 million were drawn, some of which got nothing or next to nothing."""
    pick, found = Pick(8), []
    for contexts, groups, most in ((1, 2, 12_000), (2, 3, 400_000), (1, 2, 40_000_000)):
        counts = [[[pick.choice([0, 5, pick.randrange(most)]), pick.randrange(1, most)] for _ in range(groups)] for _ in range(contexts)]
        law = fa.Law.from_array(counts, kind="counts")
        found += [fa.certify(law, {"0": Fraction(2, 7)}, confidence=confidence).certificate.document for confidence in ("9/10", "999/1000")]
    return found


def changed_ends(document: dict[str, Any]) -> Iterator[dict[str, Any]]:
    text = json.dumps(document)
    for quantity, interval in document["intervals"].items():
        for side in ("upper", "lower"):
            for i, end in enumerate(interval[side]):
                for near in (Fraction(end[s]) + k * Fraction(1, n) for s in (0, 1) for k in (-1, 1) for n in (10**4, 10**6, 10**12)):
                    if near >= 0:
                        yield put(text, ("intervals", quantity, side, i, int(near > Fraction(end[1]))), str(near))


def test_ends_of_many_draws(program: Path) -> None:
    """Beyond 5,000 draws an end has to be excluded by the bound of the page as well as by the tail itself."""
    documents_, tally = with_many_draws(), Tally()
    for judged in natively(program, [as_bytes(document) for document in documents_]):
        assert {dict(judged.statements)[f"intervals.{quantity}"] for quantity in ("local", "global")} == {True}
    altered = [as_bytes(changed) for document in documents_ for changed in changed_ends(document)]
    tally.judge(program, [*map(as_bytes, documents_), *(altered if tiers.FULL else altered[::8])])
    print(len(altered), dict(tally.codes))
    assert tally.different[:3] == []
    assert {python for python, _ in tally.codes} >= {TRUE, FALSE}


def test_ends_in_closed_form(program: Path) -> None:
    """Intervals whose cells are not all listed are judged, and one that is narrower by a billionth as by the other checker."""
    documents_, tally = with_plain_ends(), Tally()
    for judged in natively(program, [as_bytes(document) for document in documents_]):
        assert dict(judged.statements)["intervals.local"] is True
    altered = [as_bytes(changed) for document in documents_ for changed in changed_plain_ends(document)]
    tally.judge(program, [*map(as_bytes, documents_), *(altered if tiers.FULL else altered[::8])])
    print(len(altered), dict(tally.codes))
    assert tally.different[:3] == []
    assert {python for python, _ in tally.codes} >= {TRUE, FALSE, MALFORMED}
