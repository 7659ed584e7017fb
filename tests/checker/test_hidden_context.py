"""Claims by T14 in the checker: what holds is accepted, every altered number is refused, and the verdict follows.

All 1,500 altered certificates: FAIRAUDIT_FULL=1 pytest -n0 tests/checker/test_hidden_context.py
"""

from __future__ import annotations

import copy
import json
from collections.abc import Iterator
from fractions import Fraction
from random import Random
from typing import Any

import pytest
import tiers
from assumptions import complete
from certificates import hidden, outcome, sample

import fairaudit as fa
from fairaudit import checker

ALTERED = 1500 if tiers.FULL else 150
UNDER = "with the declared hidden context"
TABLE = {"u": ["y", "n", "y", "n"], "a": ["f", "f", "m", "m"], "n": [30, 10, 20, 20]}


def audited(**options: Any) -> Any:
    options = {"confidence": None, "max_local_ratio": "11/10", **options}
    return fa.audit(TABLE, decision="u", group="a", count="n", utility="y", **options)


def document(**options: Any) -> dict[str, Any]:
    found: dict[str, Any] = json.loads(audited(**options).certificate.text)
    return found


def claims_of(made: dict[str, Any]) -> list[dict[str, Any]]:
    return [claim for claim in made["claims"] if claim["by"] == "T14"]


def numbers(value: Any) -> Iterator[tuple[Any, Any]]:
    """Where numbers stand in a claim: the container and the key."""
    items = value.items() if isinstance(value, dict) else enumerate(value) if isinstance(value, list) else ()
    for key, item in items:
        if key in ("assumptions", "scope", "by", "relation", "quantity"):
            continue
        if isinstance(item, str) and item not in ("both", "higher", "lower"):
            yield value, key
        else:
            yield from numbers(item)


def other(rng: Random, text: str) -> str:
    """Another number of at least 1."""
    if text == "inf":
        return rng.choice(["1", "2", "1000000"])
    value = Fraction(text)
    changed = rng.choice([value + 1, value + Fraction(1, 10**6), 1 + (value - 1) / 2, value * 2, value - Fraction(1, 10**9), Fraction(1)])
    return rng.choice(["inf", str(changed)]) if changed != value else "inf"


def test_every_altered_number_of_a_claim_is_refused() -> None:
    rng, tried, seed = Random(tiers.fresh(14)), 0, 0
    while tried < ALTERED:
        seed += 1
        made = json.loads((hidden if seed % 3 else sample)(Random(tiers.fresh(seed))).text)
        assert outcome(made) == "true"
        for claim in claims_of(made):
            places = list(numbers(claim))
            for container, key in rng.sample(places, min(3, len(places))):
                altered = copy.deepcopy(made)
                own = altered["claims"][made["claims"].index(claim)]
                found, at = list(numbers(own))[places.index((container, key))]
                before = found[at]
                found[at] = other(rng, before)
                if at in ("k", "m") and _same_bound(claim, own):
                    continue
                tried += 1
                assert outcome(complete(altered)) != "true", (seed, own, before)


def part(factor: dict[str, str]) -> Fraction:
    """What a factor leaves of a ratio, from the page."""
    k, m = Fraction(factor["k"]), Fraction(factor["m"]) if factor["m"] != "inf" else None
    if m is None:
        return 1 / k if factor["direction"] != "lower" else Fraction(k == 1)
    return {"both": (m + k) / (1 + m * k), "higher": (m + k - 1) / (m * k), "lower": k / (m * k - m + 1)}[factor["direction"]]


def _same_bound(before: dict[str, Any], after: dict[str, Any]) -> bool:
    """Whether the altered factor leaves the same: with k = 1 any m does, and of a ratio near 1 many factors leave nothing."""
    if "hidden_context" not in after["evidence"]:
        return False
    factors = before["evidence"]["hidden_context"], after["evidence"]["hidden_context"]
    refused = "inf" in factors[1]["k"] or min(Fraction(factors[1][name]) for name in ("k", "m") if factors[1][name] != "inf") < 1
    return not refused and (after["value"] in ("1", "inf") or part(factors[0]) == part(factors[1]))


@pytest.mark.parametrize("direction", ["higher", "lower"])
def test_another_direction_is_another_bound(direction: str) -> None:
    made = document(hidden_context="2,2")
    for claim in claims_of(made):
        if "hidden_context" in claim["evidence"]:
            claim["evidence"]["hidden_context"]["direction"] = direction
    assert outcome(complete(made)) == "false"


def test_the_verdict_is_that_of_what_is_left() -> None:
    """3/2 of the table: 6/5 is left by two and two, 9/8 one-sided, 1 by two and four."""
    assert [c["value"] for c in claims_of(document(hidden_context="2,2")) if "hidden_context" in c["evidence"]] == ["6/5", "6/5"]
    for factor, verdict in (("2,2", "exceeds"), ("2,2,higher", "exceeds"), ("2,2,lower", "inconclusive"), ("2,4", "inconclusive")):
        made = document(hidden_context=factor)
        assert made["verdict"] == made["targets"][0]["verdict"] == verdict
        assert made["targets"][0]["judged"] == f"this table, {UNDER}"
        assert outcome(made) == "true"
        for wrong in {"exceeds", "inconclusive", "within", "depends", "changed"} - {verdict}:
            changed = copy.deepcopy(made)
            changed["targets"][0]["verdict"] = changed["verdict"] = wrong
            assert outcome(changed) == "false"


def test_a_target_needs_the_claim_that_states_the_factor() -> None:
    made = document(hidden_context="2,2")
    made["claims"] = [claim for claim in made["claims"] if UNDER not in claim["scope"]]
    assert outcome(made) == "false"
    plain = document()
    plain["targets"][0]["judged"] = f"this table, {UNDER}"
    assert outcome(plain) == "false"


def test_one_factor_is_declared_at_the_most() -> None:
    made = document(hidden_context="2,2")
    second = next(claim for claim in claims_of(made) if claim["quantity"] == "global_ratio")
    second["evidence"]["hidden_context"]["k"] = "3"
    assert outcome(complete(made)) == "false"


def test_the_factor_is_an_assumption_word_by_word() -> None:
    made = document(hidden_context="2,2")
    for claim in claims_of(made):
        assert UNDER not in claim["scope"] or claim["assumptions"]
        claim["assumptions"] = []
    assert outcome(made).startswith("incomplete")
    told = document(hidden_context="2,2")
    claims_of(told)[-1]["assumptions"] = [text.replace("2 times", "3 times") for text in claims_of(told)[-1]["assumptions"]]
    assert outcome(told).startswith(("incomplete", "malformed"))


@pytest.mark.parametrize(
    "scope",
    [
        "population at confidence 19/20",
        "population, one-sided at confidence 1/2",
        "any policy behind this filter",
        "this law, within the declared drift",
    ],
)
def test_a_scope_that_is_not_proved_is_refused(scope: str) -> None:
    for options in ({}, {"hidden_context": "2,2"}):
        made = document(**options)
        claim = claims_of(made)[-1]
        claim["scope"] = scope + (f", {UNDER}" if options and "drift" not in scope else "")
        assert outcome(complete(made)) != "true"


def test_of_a_population_it_starts_from_the_lower_end() -> None:
    made = document(hidden_context="6/5,6/5", confidence="0.9", max_local_ratio="101/100")
    low = Fraction(made["intervals"]["local"]["ratio"][0])
    found = next(c for c in claims_of(made) if c["quantity"] == "local_ratio" and c["scope"].startswith("population"))
    assert Fraction(found["value"]) == max(1, low * Fraction(60, 61))
    assert made["targets"][0]["judged"] == f"population at confidence 9/10, {UNDER}"
    assert outcome(made) == "true"
    found["value"] = str(Fraction(3, 2) * Fraction(60, 61))
    assert outcome(made) == "false"


def test_nothing_explains_an_infinite_ratio() -> None:
    table = {**TABLE, "n": [30, 10, 0, 20]}
    for factor, left in (("2,2", "inf"), ("2,inf,lower", "1")):
        result = fa.audit(table, decision="u", group="a", count="n", utility="y", confidence=None, hidden_context=factor)
        made = json.loads(result.certificate.text)
        assert {c["value"] for c in claims_of(made) if "hidden_context" in c["evidence"]} == {left}
        frontier = next(c for c in claims_of(made) if "frontier" in c["evidence"])
        assert (frontier["value"], frontier["evidence"]["frontier"]) == ("inf", [{"to": "1", "balanced": "inf", "pairs": []}])
        assert outcome(made) == "true"


def test_a_long_frontier_is_refused_before_it_is_computed() -> None:
    made = document()
    level = claims_of(made)[0]["evidence"]["frontier"][0]
    level["pairs"] = level["pairs"] * 9
    with pytest.raises(checker.FormatError, match="at most 16"):
        checker.check(json.dumps(made).encode())
