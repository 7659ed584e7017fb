"""What the checker accepts and refuses of claims about drift."""

from __future__ import annotations

import copy
import json
import os
import random
from fractions import Fraction
from typing import Any

import numpy as np
import pytest
import tiers

import fairaudit as fa
from fairaudit import checker

F = Fraction
TAMPERED = int(os.environ.get("FAIRAUDIT_DRIFT_FORGERIES", "150"))
"""Altered certificates; 2,000 were tried once."""


def document(seed: int) -> dict[str, Any]:
    """A true certificate with claims about drift."""
    pick = random.Random(tiers.fresh(seed))
    contexts, groups, decisions = pick.randint(1, 3), pick.randint(2, 3), pick.randint(2, 4)
    rows = np.array([[[pick.randint(0, 9) for _ in range(decisions)] for _ in range(groups)] for _ in range(contexts)], dtype=object)
    rows[:, :, 0] += 1
    limits = {
        "max_local_ratio": pick.choice(["1", "5/4", "2", "4"]),
        **({"max_global_ratio": pick.choice(["11/10", "3"])} if pick.random() < 0.6 else {}),
        **({"max_local_log": "1/3"} if pick.random() < 0.4 else {}),
    }
    utility = {str(u): pick.choice([0, 1, 1, 3]) for u in range(decisions)} | {"0": 1}
    law = fa.Law.from_array(rows, kind="counts", decisions=[str(u) for u in range(decisions)])
    drift = {"max_drift": pick.choice(["0", "1/20", "1/3"])} if pick.random() < 0.4 else {}
    result = fa.certify(law, utility, confidence=pick.choice([None, None, "1/2"]), **limits, **drift)
    return json.loads(result.certificate.text)  # type: ignore[no-any-return]


def outcome(made: dict[str, Any]) -> str:
    try:
        return "true" if checker.check(json.dumps(made).encode()).ok else "false"
    except checker.FormatError:
        return "malformed"


def of_drift(made: dict[str, Any]) -> list[dict[str, Any]]:
    return [claim for claim in made["claims"] if claim["by"] == "T16"]


@pytest.mark.parametrize("seed", range(40))
def test_what_is_written_is_true(seed: int) -> None:
    assert outcome(document(seed)) == "true"


def test_no_greater_radius_and_no_other_evidence_is_accepted() -> None:
    """Each claim that is altered so that it says something else is refused."""
    pick = random.Random(tiers.fresh(5))
    tried = seed = 0
    kinds: set[str] = set()
    while tried < TAMPERED:
        seed += 1
        made = document(seed)
        claims = of_drift(made)
        if not claims:
            continue
        at = made["claims"].index(pick.choice(claims))
        for name in ("greater", "verdict", "limit", "pair", "quantity", "scope", "assumption", "drift", "exact"):
            forged = copy.deepcopy(made)
            claim = forged["claims"][at]
            if not alter(forged, claim, name, pick):
                continue
            assert outcome(forged) != "true", (seed, name, made["claims"][at], claim)
            tried += 1
            kinds.add(name)
    assert tiers.enough(kinds == {"greater", "verdict", "limit", "pair", "quantity", "scope", "assumption", "drift", "exact"})


def alter(forged: dict[str, Any], claim: dict[str, Any], name: str, pick: random.Random) -> bool:
    """Make a claim false, or its evidence another one; whether there is something to alter."""
    radius = claim["quantity"].endswith(("_radius", "_factor"))
    table = claim["scope"].startswith("this law")
    if name == "greater":
        if claim["value"] == "inf" or (claim["relation"] == ">=" and radius and not table):
            return False
        if claim["relation"] == ">=" and radius:  # rounded inwards: by more than what was rounded off
            claim["value"] = str(F(claim["value"]) + F(1, 10**9))
        else:
            claim["value"] = str(F(claim["value"]) + F(pick.choice([1, -1]) if F(claim["value"]) >= 1 else 1, 10**15))
    elif name == "exact":
        if not radius or claim["relation"] == "=" or claim["value"] in ("0", "1"):
            return False
        claim["relation"] = "="
    elif name == "verdict":
        if not radius:
            return False
        claim["evidence"]["verdict"] = "exceeds" if claim["evidence"]["verdict"] == "within" else "within"
    elif name == "limit":
        if not radius or claim["relation"] != "=" or claim["value"] == "inf":
            return False
        claim["evidence"]["limit"] = str(F(claim["evidence"]["limit"]) + F(1, 1000))
    elif name == "pair":
        if claim["evidence"]["pair"] is None:
            return False
        claim["evidence"]["pair"][pick.choice(["higher", "lower"])] = ["nobody"]
    elif name == "quantity":
        if not radius or "log" in claim["quantity"]:
            return False
        claim["quantity"] = claim["quantity"].replace("ratio", "rate")
    elif name == "scope":
        claim["scope"] = claim["scope"] + ", whoever the unknown are"
    elif name == "assumption":
        claim["assumptions"] = claim["assumptions"][1:]
    elif name == "drift":
        if "max_drift" not in forged["subject"] or radius:
            return False
        forged["subject"]["max_drift"] = str(F(forged["subject"]["max_drift"]) / 2 + F(1, 7))
    return True


def test_a_verdict_depends_only_where_both_answers_are_shown() -> None:
    law = fa.Law.from_array([["1/2", "1/2"], ["2/5", "3/5"]], decisions=["yes", "no"], groups=["f", "m"])
    made = json.loads(fa.certify(law, {"yes": 1}, max_local_ratio="3/2", max_drift="1/20").certificate.text)
    assert (made["verdict"], outcome(made)) == ("depends", "true")
    for relation in ("<=", ">="):
        forged = copy.deepcopy(made)
        forged["claims"] = [c for c in made["claims"] if (c["by"], c["quantity"], c["relation"]) != ("T16", "local_ratio", relation)]
        assert outcome(forged) == "false"
    for verdict in ("within", "exceeds", "inconclusive"):
        forged = copy.deepcopy(made)
        forged["verdict"] = forged["targets"][0]["verdict"] = verdict
        assert outcome(forged) == "false"


def test_a_policy_and_a_null_utility_have_none() -> None:
    law = fa.Law.from_array([["1/2", "1/2"], ["2/5", "3/5"]], decisions=["yes", "no"], groups=["f", "m"])
    made = json.loads(fa.certify(law, {"yes": 1}, max_local_ratio=2).certificate.text)
    policy = json.loads(
        fa.certify(fa.Policy(law).behind(group=fa.RandomizedResponse(["f", "m"], keep_probability="3/4")), {"yes": 1}).certificate.text
    )
    policy["claims"] += of_drift(made)
    assert outcome(policy) != "true"


def test_means_that_are_not_followed_are_bounded() -> None:
    """Of many groups only those of the pair are summed; what no move exceeds is enough for the others, and for nothing else."""
    rows = [[["1/2", "1/2"], ["2/5", "3/5"], ["9/20", "11/20"]], [["3/5", "2/5"], ["1/2", "1/2"], ["11/20", "9/20"]]]
    law = fa.Law.from_array(rows, decisions=["yes", "no"], groups=["a", "b", "c"])
    made = json.loads(fa.certify(law, {"yes": 1}, max_global_ratio=2).certificate.text)
    for claim in of_drift(made):
        claim["evidence"]["followed"] = [["a"], ["b"]]
    assert outcome(made) == "true"
    for claim in of_drift(made):
        claim["evidence"]["followed"] = [["c"]]
    assert outcome(made) == "false"


@pytest.mark.parametrize(("value", "relation"), [("inf", "="), ("1000", ">="), ("3/2", ">=")])
@pytest.mark.parametrize(
    ("rows", "utility", "limit"),
    [([[1, 0, 0], [0, 1, 0], [2, 0, 3]], (2, 1, 0), "2"), ([[1, 0, 0], [1, 0, 0], [0, 4, 5], [0, 2, 3]], (0, 1, 0), "11/10")],
    ids=["at the limit", "nothing for both"],
)
def test_a_pair_that_no_factor_moves_does_not_prove_that_the_table_exceeds(
    value: str, relation: str, rows: list[list[int]], utility: tuple[int, ...], limit: str
) -> None:
    """The first two stay where they are, at the limit or with 0/0; of the others some exceed it, by factors near 1 alone."""
    law = fa.Law.from_array(rows, kind="counts", decisions=["x", "y", "z"], groups=["A", "B", "C", "D"][: len(rows)])
    made = json.loads(fa.certify(law, dict(zip("xyz", utility, strict=True)), confidence=None, max_local_ratio=limit).certificate.text)
    claim = next(c for c in of_drift(made) if c["quantity"] == "local_ratio_factor")
    assert (claim["evidence"]["verdict"], outcome(made)) == ("exceeds", "true")
    claim |= {"value": value, "relation": relation}
    claim["evidence"]["pair"] |= {"higher": ["A"], "lower": ["B"]}
    assert outcome(made) == "false"


def test_a_target_within_a_drift_needs_one_that_is_declared() -> None:
    law = fa.Law.from_array([["1/2", "1/2"], ["1/10", "9/10"]], decisions=["yes", "no"], groups=["f", "m"])
    made = json.loads(fa.certify(law, {"yes": 1}, max_local_ratio="3/2").certificate.text)
    made["targets"][0] |= {"judged": "this table, within the declared drift", "verdict": "inconclusive"}
    made["verdict"] = "inconclusive"
    assert outcome(made) == "false"


@pytest.mark.parametrize("limit", [40, 700])
def test_a_pair_is_not_named_where_another_one_is_the_greatest_before_it(limit: int) -> None:
    """The radius of a limit on a logarithm is rounded inwards."""
    big = 10**15
    rows = [[1, big, 1], [1, 10**20, 2], [big, big, 2]]
    laws = [[str(F(w, sum(row))) for w in row] for row in rows]
    law = fa.Law.from_array(laws, decisions=["x", "y", "z"], groups=["A", "B", "C"])
    assert outcome(json.loads(fa.certify(law, {"x": 2, "y": 1}, max_local_log=limit).certificate.text)) == "true"
