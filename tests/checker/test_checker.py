"""Forged claims and stripped assumptions on certificates of all kinds: none is accepted.

All 3,000 of them: FAIRAUDIT_FULL=1 pytest -n0 tests/checker/test_checker.py
"""

from __future__ import annotations

import copy
import json
import random
from fractions import Fraction
from typing import Any

import pytest
import tiers
from assumptions import sentences
from certificates import KINDS, random_certificate

from fairaudit import checker

FORGED = 3000 if tiers.FULL else 330
BATCHES = 10
QUANTITIES = ("local_ratio", "global_ratio", "demographic_parity", "equalized_odds", "local_ratio_supremum", "global_ratio_supremum")
Pick = random.Random


def less(pick: Pick, text: str) -> str:
    """A smaller number: by very little, by some, or very much."""
    if text == "inf":
        return str(10 ** pick.choice([1, 9, 300]))
    return str(Fraction(text) * (1 - pick.choice([Fraction(1, 10**40), Fraction(1, 1000), Fraction(1, 3)])))


def forge_value(pick: Pick, claim: dict[str, Any]) -> bool:
    if claim["by"] == "lp-dual":  # its evidence may prove a little less than it says
        claim["value"] = "1/2"
    elif claim["relation"] == ">=":
        claim["value"] = str(Fraction(claim["value"]) * (1 + Fraction(1, 10 ** pick.choice([1, 40]))))
    else:
        claim["value"] = less(pick, claim["value"])
    return True


def forge_relation(pick: Pick, claim: dict[str, Any]) -> bool:
    claim["relation"] = pick.choice([other for other in ("=", "<=", ">=", "<", "==", "") if other != claim["relation"]])
    return True


def _unlike(pick: Pick, claim: dict[str, Any], key: str, values: tuple[str, ...]) -> bool:
    """Another value of a key that makes the claim one that no theorem gives."""
    known = {rule[:4] for rule in checker.claims.RULES}
    for _ in range(20):
        changed = claim | {key: pick.choice(values)}
        if changed[key] != claim[key] and tuple(changed[k] for k in ("quantity", "relation", "by", "scope")) not in known:
            claim[key] = changed[key]
            return True
    return False


def forge_by(pick: Pick, claim: dict[str, Any]) -> bool:
    methods = ("enumeration", "T1", "T2", "T3", "T5", "T6", "T7", "T12", "lp-dual", "binomial", "betting", "hoeffding-kl", "", "T99")
    return _unlike(pick, claim, "by", methods)


def forge_scope(pick: Pick, claim: dict[str, Any]) -> bool:
    scopes = (
        "every law",
        "this law ",
        "any policy",
        checker.claims.POLICIES,
        checker.claims.UTILITIES,
        "population at confidence 999/1000",
        "population",
    )
    return _unlike(pick, claim, "scope", scopes)


def forge_quantity(pick: Pick, claim: dict[str, Any]) -> bool:
    return _unlike(pick, claim, "quantity", (*QUANTITIES, "local", "ratio"))


def strip(pick: Pick, claim: dict[str, Any]) -> bool:
    needed = [text for text in claim["assumptions"] if text != sentences()["one-row"]]
    if not needed:
        return False
    gone = pick.sample(needed, pick.choice([1, len(needed)]))
    claim["assumptions"] = [text for text in claim["assumptions"] if text not in gone]
    return True


def alter(pick: Pick, claim: dict[str, Any]) -> bool:
    if not claim["assumptions"]:
        claim["assumptions"] = ["all is well"]
        return True
    i = pick.randrange(len(claim["assumptions"]))
    text = claim["assumptions"][i]
    at = pick.randrange(len(text))
    changes = [text[:at] + text[at + 1 :], text + " ", text.upper(), text.replace(" ", "  ", 1), text.replace("not", "now"), "", text + "."]
    claim["assumptions"][i] = pick.choice([change for change in changes if change != text])
    return True


def repeat(pick: Pick, claim: dict[str, Any]) -> bool:
    if claim["assumptions"]:
        claim["assumptions"].append(pick.choice(claim["assumptions"]))
    return bool(claim["assumptions"])


def forge_evidence(pick: Pick, claim: dict[str, Any]) -> bool:
    evidence = claim["evidence"]
    if "table" in evidence:
        evidence["table"] = evidence["table"][::-1]
    elif "interval" in evidence:
        evidence["interval"] = "global" if evidence["interval"] == "local" else "local"
    elif "attained" in evidence:
        attained = evidence["attained"]
        evidence["attained"] = {"context": None, "higher": ["a"], "lower": ["b"]} if attained is None else None
    elif "frontier" in evidence:
        level = pick.choice(evidence["frontier"])
        level["balanced"] = less(pick, level["balanced"])
    elif "hidden_context" in evidence:
        factor = evidence["hidden_context"]
        factor["direction"] = "lower" if factor["direction"] != "lower" else "higher"
    elif evidence and not {"multipliers", "pairs"} & evidence.keys():
        key = next(iter(evidence))
        nobody = {"context": [], "higher": ["nobody"], "lower": ["nobody"]}
        evidence[key] = less(pick, evidence[key]) if isinstance(evidence[key], str) else nobody
    else:
        evidence["note"] = "x"
    return True


FORGERIES = (forge_value, forge_value, forge_relation, forge_by, forge_scope, forge_quantity, strip, strip, alter, repeat, forge_evidence)


def outcome(document: Any) -> str:
    try:
        return "true" if checker.check(json.dumps(document).encode()).ok else "false"
    except checker.FormatError as error:
        return type(error).__name__


@pytest.mark.parametrize("batch", range(BATCHES))
def test_no_forged_claim_is_accepted(batch: int) -> None:
    pick = Pick(tiers.fresh(batch))
    accepted, forged = [], 0
    honest = [json.loads(random_certificate(seed).text) for seed in range(batch * len(KINDS), (batch + 1) * len(KINDS))]
    while forged < FORGED // BATCHES:
        document = copy.deepcopy(pick.choice(honest))
        counted = [text for text in document["claims"][0]["assumptions"] if "left out" in text]
        claim, forge = pick.choice(document["claims"]), pick.choice(FORGERIES)
        before = copy.deepcopy(claim)
        if not forge(pick, claim) or claim == before or (len(document["claims"]) == 1 and counted):
            continue
        forged += 1
        if outcome(document) == "true":
            accepted.append((forge.__name__, before, claim))
    assert accepted == []
