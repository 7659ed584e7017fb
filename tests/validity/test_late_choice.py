"""Levels that are chosen after the draws: how much of the error they would take, and that no such interval is proved.

Of one cell that is compared with another one of which nothing can be drawn but 0, the greatest difference is the mean, so that each end of
the interval is one of the mean, and nothing of the error is left over. All outcomes are gone through, with exact probabilities.
"""

from __future__ import annotations

import copy
import json
from collections.abc import Iterator
from fractions import Fraction
from functools import cache
from math import comb
from typing import Any

import pytest
from interval_certificates import area
from plain_certificates import raw

import fairaudit as fa
from fairaudit import checker
from fairaudit.inference.cells import Cell
from fairaudit.inference.ends import cell_ends

F = Fraction
ALPHA = F(1, 10)
DRAWS, MEAN = 23, F(3, 4)
GREAT = (ALPHA * F(999, 1000), ALPHA / 1000), (ALPHA / 2, ALPHA / 2)
"""Levels whose sum is the error: nearly all of it for the upper end, or as much for either."""


def chance(successes: int) -> Fraction:
    return comb(DRAWS, successes) * MEAN**successes * (1 - MEAN) ** (DRAWS - successes)


@cache
def ends(successes: int, level: Fraction) -> tuple[Fraction, Fraction]:
    return cell_ends(Cell(DRAWS, F(successes), F(successes), F(0), F(1), True), level, "hoeffding-kl")


@cache
def honest(successes: int) -> Any:
    law = fa.Law.from_array([[successes, DRAWS - successes], [3, 3]], kind="counts", decisions=["yes", "no"], groups=["f", "m"])
    utility = fa.Utility.from_function(lambda u, x, a: int(u == "yes" and a == ("f",)), law)
    return json.loads(fa.certify(law, utility, difference=True, confidence="0.9").certificate.text)


def at_levels(successes: int, levels: tuple[Fraction, Fraction]) -> Any:
    """The certificate with an interval at these levels, as narrow as they allow."""
    document = copy.deepcopy(honest(successes))
    of_upper, of_lower = (ends(successes, level) for level in levels)
    document["intervals"]["local_difference"] |= {
        "levels": dict(zip(("upper", "lower"), map(str, levels), strict=True)),
        "upper": [[*map(str, of_upper)], ["0", "0"]],
        "lower": [[*map(str, of_lower)], ["0", "0"]],
        "difference": [str(of_lower[0]), str(of_upper[1])],
    }
    return document


def fault(document: Any, name: str) -> str:
    """What the checker has against an interval."""
    [found] = [found for found in checker.check(raw(document)).findings if found.statement.startswith(f"intervals.{name}:")]
    return "" if found.true else found.detail


def wrong(document: Any) -> bool:
    low, high = map(F, document["intervals"]["local_difference"]["difference"])
    return not low <= MEAN <= high


def late(successes: int) -> Iterator[Any]:
    """What somebody would write who sees the draws, and knows the mean."""
    yield from (document for levels in GREAT if wrong(document := at_levels(successes, levels)))


def test_levels_that_are_chosen_late_err_more_often_than_the_confidence_says_and_prove_nothing() -> None:
    error = F(0)
    for successes in range(DRAWS + 1):
        documents = [*late(successes)]
        error += chance(successes) * bool(documents)
        for document in documents:
            levels = [F(level) for level in document["intervals"]["local_difference"]["levels"].values()]
            said = fault(document, "local_difference")
            assert sum(levels) == ALPHA and (levels[0] == levels[1] or "must be 1/1 times" in said)
    assert error > ALPHA * F(14, 10)


def test_levels_that_are_scaled_late_err_no_more_often_than_the_confidence_says() -> None:
    """In the proportion that the checker asks for every smaller pair of levels is taken, and proves no more than the greatest pair."""
    error = F(0)
    for successes in range(DRAWS + 1):
        documents = [at_levels(successes, (ALPHA * scale / 2,) * 2) for scale in (F(1), F(7, 10), F(1, 1000))]
        assert not any(fault(document, "local_difference") for document in documents)
        assert not any(wrong(document) and not wrong(documents[0]) for document in documents)
        error += chance(successes) * any(map(wrong, documents))
    assert ALPHA * F(8, 10) < error <= ALPHA


ROWS = {"two values": [[[40, 30], [25, 35]], [[20, 60], [50, 20]]], "three": [[[20, 20, 30], [25, 35, 10]], [[20, 60, 9], [9, 50, 20]]]}
KINDS: dict[str, tuple[str, str, dict[str, Any], str]] = {
    "a box": ("two values", "box", {}, "times that for the lower one"),
    "a box of independent cells": (
        "three",
        "box",
        {"independent": True, "interval": "empirical-bernstein"},
        "times that for the lower one",
    ),
    "a product": ("three", "product", {"independent": True, "interval": "hoeffding-kl"}, "more of the error than there is"),
    "pairs": ("two values", "pairs", {"independent": True}, "the levels must be"),
    "contrasts": ("three", "contrasts", {"independent": True}, "the levels must be"),
}


def shifted(levels: dict[str, Any]) -> Iterator[dict[str, Any]]:
    """Levels that spend as much, but more of it on one thing and less on another."""
    for share in (F(-1, 10), F(1, 1000)):
        if isinstance(levels["upper"], str):
            yield {"upper": str(F(levels["upper"]) * (1 + share)), "lower": str(F(levels["lower"]) * (1 - share))}
        else:
            b, c = map(F, levels["upper"])
            moved, other = b * (1 + share), c
            while 2 * moved + F(area(moved, other)) > ALPHA / 2:
                other *= F(99, 100)
            while 2 * moved + F(area(moved, other * F(101, 100))) < ALPHA / 2:
                other *= F(101, 100)
            yield levels | {"upper": [str(moved), str(other)]}


@pytest.mark.parametrize("kind", KINDS)
def test_other_levels_than_those_of_the_rule_are_refused(kind: str) -> None:
    values, region, options, refusal = KINDS[kind]
    utility = dict(zip(("yes", "no", "maybe"), ("1", "0", "1/2"), strict=True))
    law = fa.Law.from_array(ROWS[values], kind="counts", decisions=list(utility)[: len(ROWS[values][0][0])])
    used = {decision: utility[decision] for decision in law.decisions}
    document = json.loads(fa.certify(law, used, difference=True, confidence="0.9", **options).certificate.text)
    for name, interval in document["intervals"].items():
        assert fault(document, name) == "" and interval["ends"] == "together"
        boxed = region == "product" and name != "local"  # of two cells, and of differences, it is a box
        assert interval["region"] == ("box" if boxed else region)
        for levels in shifted(interval["levels"]):
            changed = document | {"intervals": document["intervals"] | {name: interval | {"levels": levels}}}
            assert (KINDS["a box"][-1] if boxed else refusal) in fault(changed, name)


def test_other_levels_of_rates_are_refused() -> None:
    counts = [("yes", "fit", 9), ("no", "fit", 4), ("yes", "not", 5), ("no", "not", 8)]
    rows = [(u, t, a, n + a.count("m") * len(u)) for u, t, n in counts for a in "fm"]
    table = dict(zip("utan", map(list, zip(*rows, strict=True)), strict=True))
    law = fa.Law.from_counts(table, decision="u", group="a", count="n", truth="t")
    document = json.loads(fa.certify(law, {"yes": 1}, positive="fit", confidence="0.9").certificate.text)
    for name in ("equal_opportunity", "equalized_odds_true_label"):
        interval = document["intervals"][name]
        assert fault(document, name) == ""
        for levels in shifted(interval["levels"]):
            changed = document | {"intervals": document["intervals"] | {name: interval | {"levels": levels}}}
            assert "times that for the lower one" in fault(changed, name)
