"""Ends that move while cells pass by: what those of cells that are held give, and claims about them that are altered."""

from __future__ import annotations

import copy
import json
import random
from dataclasses import replace
from fractions import Fraction
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import fairaudit as fa
from fairaudit import checker
from fairaudit.checker.certificate import read_certificate
from fairaudit.checker.drift import _boxed
from fairaudit.checker.interval_proofs import _prove_interval
from fairaudit.checker.intervals import Boxed, BoxEvidence, Listed, Proven, Unproven
from fairaudit.checker.moved_ends import EndMove
from fairaudit.checker.passing import passing_box
from fairaudit.checker.rows import embedded_lines, read_table
from fairaudit.inference import quotients

F = Fraction
UTILITIES: list[Any] = [{"0": 1}, {"0": 1, "1": "1/3"}, {"0": "1/2", "1": 2}, {"0": 1, "1": 1}]


def of_few_listed(counts: Any, utility: Any, **options: Any) -> Any:
    """A certificate that lists the ends of those cells that decide, as those of many cells do."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(quotients, "DECISIVE_CELLS", 0)
        law = fa.Law.from_array(np.array(counts), kind="counts")
        return json.loads(fa.certify(law, utility, **options).certificate.text)


@st.composite
def tables(draw: st.DrawFn) -> list[list[list[int]]]:
    """Counts of many sizes, some contexts of which have one group or none."""
    contexts, groups, decisions = draw(st.integers(1, 5)), draw(st.integers(2, 4)), draw(st.integers(2, 3))
    size = st.sampled_from([0, 0, 1, 3, 40, 700, 10**6])
    rows = [[[draw(size) for _ in range(decisions)] for _ in range(groups)] for _ in range(contexts)]
    rows[0][0][0] += 1
    rows[0][1][-1] += 1
    return rows


@given(
    tables(),
    st.sampled_from(UTILITIES),
    st.fractions(0, 1, max_denominator=50),
    st.sampled_from(["0.5", "0.95"]),
    st.randoms(use_true_random=False),
)
def test_cells_that_pass_give_what_cells_that_are_held_give(
    counts: list[list[list[int]]], utility: Any, eta: Fraction, confidence: str, pick: random.Random
) -> None:
    stated = read_certificate(of_few_listed(counts, utility, confidence=confidence, max_local_ratio=2))
    interval = stated.intervals["local"]
    names = [(f"{a}",) for a in range(len(counts[0]) + 1)]
    header = stated.embedded[0] if stated.embedded else {}
    groups = [tuple(label) for label in header["groups"]] + names[-1:]  # type: ignore[index]
    contexts = [tuple(label) for label in header["contexts"]] + [("nowhere",), None]  # type: ignore[index]
    places = [(pick.choice(contexts), pick.choice(groups), pick.choice(groups)) for _ in range(6)]
    moves = [EndMove(pick.choice([eta, F(0), F(1)]), upper, place) for upper in (True, False) for place in (None, *places)]
    passing = passing_box(interval, moves)
    assert passing is not None
    table = read_table(embedded_lines(stated.embedded or ()), watchers=[passing])
    held, passed = _prove_interval(interval, table), passing.proven()
    assert isinstance(held.boxed, Boxed)
    assert passed.boxed == {move: _boxed(held.boxed, table, "local", move) for move in moves}
    assert all(found.greatest == by_definition(held, table, move) for move, found in passed.boxed.items())


def by_definition(held: Proven, table: Any, move: EndMove) -> tuple[int, int]:
    """The greatest quotient of an end and another one of its context, all pairs looked at, as a pair of integers."""
    assert isinstance(held.boxed, Boxed)
    found: list[Fraction | None] = [F(1)]
    first = 0
    for cells in (own for own in table.by_context() if len(own) > 1):
        ends = []
        for i in range(first, first + len(cells)):
            (low, high), (least, most) = (held.boxed.upper if move.upper else held.boxed.lower)[i], held.boxed.ranges[i]
            ends.append((max(least, low - move.eta * (most - least)), min(most, high + move.eta * (most - least))))
        first += len(cells)
        for i, one in enumerate(ends):
            for top, bottom in ((one[move.upper], other[not move.upper]) for j, other in enumerate(ends) if j != i):
                found.append(top / bottom if bottom else None if top else F(1))
    if None in found:
        return 1, 0
    greatest = max(value for value in found if value is not None)
    return greatest.numerator, greatest.denominator


@given(tables(), st.sampled_from(UTILITIES), st.sampled_from(["0.5", "0.95"]))
def test_cells_that_pass_keep_a_bound_exactly_where_cells_that_are_held_do(
    counts: list[list[list[int]]], utility: Any, confidence: str
) -> None:
    """A context is looked at closely only where what holds all its ends is beyond the bound; no end is listed here."""
    stated = read_certificate(of_few_listed(counts, utility, confidence=confidence))
    own = stated.intervals["local"]
    assert isinstance(own.evidence, BoxEvidence)
    evidence = replace(own.evidence, upper=Listed([], []), lower=Listed([], []), pair=None)
    interval = replace(own, ratio=((1, 1), (1, 0)), evidence=evidence)

    def proven(top: Fraction) -> bool:
        passing = passing_box(replace(interval, ratio=((1, 1), (top.numerator, top.denominator))))
        assert passing is not None
        read_table(embedded_lines(stated.embedded or ()), watchers=[passing])
        try:
            return bool(passing.proven())
        except Unproven:
            return False

    table = read_table(embedded_lines(stated.embedded or ()))
    each = replace(interval, each=True)
    n, d = by_definition(_prove_interval(each, table), table, EndMove(F(0), True, None))
    if d:
        assert proven(F(n, d))
        assert n == d or not proven(F(n, d) - F(1, 10**30))
        assert n == d or proven((F(n, d) + 1) / 2) is False


COUNTS = [[[30000, 70000], [35000, 65000], [33000, 67000]], [[250, 250], [240, 260], [0, 0]], [[900, 1100], [1000, 900], [5, 5]]]


@pytest.mark.parametrize("utility", [{"1": 1}, {"0": 1, "1": "1/3"}])
@pytest.mark.parametrize(
    "options", [{"max_local_ratio": 40}, {"max_local_ratio": 1}, {"max_local_log": 4}, {"max_drift": "1/50", "max_local_ratio": 3}]
)
def test_what_is_altered_is_judged_as_where_all_ends_are_listed(utility: Any, options: Any) -> None:
    document = of_few_listed(COUNTS, utility, **options)
    about = [
        i for i, c in enumerate(document["claims"]) if c["by"] == "T16" and c["quantity"].startswith("local") and "population" in c["scope"]
    ]
    assert about and accepted(document) and accepted(of_all_listed(document))
    refused = 0
    for i in about:
        for change in CHANGES:
            forged = copy.deepcopy(document)
            alter(forged, forged["claims"][i], change)
            assert accepted(forged) == accepted(of_all_listed(forged)), (change, forged["claims"][i])
            assert forged == document or change not in ALWAYS or not accepted(forged), (change, forged["claims"][i])
            refused += not accepted(forged)
    assert refused > 3


ALWAYS = ("value", "inf", "verdict", "context", "nowhere", "followed")
CHANGES = (*ALWAYS, "smaller", "pair", "none", "limit")  # which can leave something true


def alter(document: Any, claim: Any, change: str) -> None:
    """Make a claim say something else, or rest on something else, if that is there."""
    own, pair = claim["evidence"], claim["evidence"]["pair"] or {}
    radius = claim["quantity"].endswith("radius")
    if change in ("value", "smaller") and claim["value"] != "inf":
        sign = 1 if radius or F(claim["value"]) == 1 else -1
        claim["value"] = str(max(F(0), F(claim["value"]) + sign * (1 if change == "value" else -1) * F(1, 10**9)))
    elif change == "inf" and claim["value"] != "inf":
        claim["value"] = "inf"
    elif change == "verdict" and radius:
        own["verdict"] = "exceeds" if own["verdict"] == "within" else "within"
    elif change == "pair" and pair:
        pair["higher"], pair["lower"] = pair["lower"], pair["higher"]
    elif change == "context" and pair:
        pair["context"] = next([x] for x in ("0", "1", "2") if [x] != pair["context"])
    elif change == "nowhere" and pair:
        pair["context"] = None
    elif change == "none":
        own["pair"] = None
    elif change == "followed":
        own["followed"] = [["0"]]
    elif change == "limit" and radius:
        own["limit"] = str(F(own["limit"]) + F(1, 7))


def of_all_listed(document: Any) -> Any:
    """The same with the ends of all cells, which then are held."""
    stated = read_certificate(document)
    held = _prove_interval(stated.intervals["local"], read_table(embedded_lines(stated.embedded or ()))).boxed
    assert isinstance(held, Boxed)
    changed = copy.deepcopy(document)
    for side, box in (("upper", held.upper), ("lower", held.lower)):
        changed["intervals"]["local"][side] = [[str(low), str(high)] for low, high in box]
    own = read_certificate(changed).intervals["local"]
    assert passing_box(own) is None
    return changed


def accepted(document: Any) -> bool:
    try:
        return checker.check(json.dumps(document).encode()).ok
    except checker.FormatError:
        return False
