"""Altered evidence of differences is refused, and of utilities below 0 no ratio is ever taken for proven."""

from __future__ import annotations

import copy
import json
from collections.abc import Iterator
from fractions import Fraction
from itertools import permutations, product
from random import Random
from typing import Any

import tiers
from certificates import outcome
from pair_oracle import rarity

import fairaudit as fa
from fairaudit import checker
from fairaudit.inference.pair_exact import order_scale

F = Fraction
NAMES = ("local_difference", "global_difference")
ENOUGH = 2_000 if tiers.FULL else 70


def certified(pick: Random, *, exact: bool) -> dict[str, Any]:
    """A certificate with intervals of differences, of two-valued draws or of more."""
    values = {"yes": pick.choice([1, 3]), "no": pick.choice([-1, "-1/2", 0])}
    utility: dict[str, Any] = values if exact else values | {"maybe": "1/3"}
    array = [[[pick.randint(3, 40) for _ in utility] for _ in range(pick.randint(2, 3))] for _ in range(pick.randint(1, 2))]
    groups = min(map(len, array))
    law = fa.Law.from_array([block[:groups] for block in array], kind="counts", decisions=list(utility))
    options: dict[str, Any] = {"confidence": pick.choice(["0.5", "0.9", "0.95"]), "independent": exact or pick.random() < 0.5}
    if not exact and (not options["independent"] or pick.random() < 0.3):
        options["interval"] = pick.choice(["hoeffding-kl", "empirical-bernstein", "intersection"])
    limits = {"max_difference": "1/2"} if pick.random() < 0.5 else {}
    document: dict[str, Any] = json.loads(fa.certify(law, utility, difference=True, **options, **limits).certificate.text)
    document["targets"], document["verdict"] = [], "none"  # what is altered are intervals and their claims
    return document


def text(value: Fraction) -> str:
    return str(value)


def with_end(document: dict[str, Any], name: str, side: int, value: Fraction) -> dict[str, Any]:
    """The same with another end, and the claim that repeats it."""
    changed = copy.deepcopy(document)
    changed["intervals"][name]["difference"][side] = text(value)
    for claim in changed["claims"]:
        if claim["evidence"] == {"interval": name} and claim["relation"] == ("<=" if side else ">="):
            claim["value"] = text(value)
    return changed


def with_confidence(document: dict[str, Any], name: str, value: Fraction) -> dict[str, Any]:
    changed = copy.deepcopy(document)
    changed["intervals"][name]["confidence"] = text(value)
    for claim in changed["claims"]:
        if claim["evidence"] == {"interval": name}:
            claim["scope"] = claim["scope"].rpartition(" ")[0] + f" {value}"
    return changed


def put(document: dict[str, Any], name: str, path: tuple[Any, ...], value: Any) -> dict[str, Any]:
    changed = copy.deepcopy(document)
    at = changed["intervals"][name]
    for step in path[:-1]:
        at = at[step]
    at[path[-1]] = value
    return changed


def common(document: dict[str, Any], name: str, pick: Random) -> Iterator[dict[str, Any]]:
    """What is false whatever the region: more than the evidence gives, at a level that it does not have."""
    entry = document["intervals"][name]
    low, high = map(F, entry["difference"])
    for share in (F(1, 50), F(1, 9), F(1, 3)):
        yield with_end(document, name, 1, high * (1 - share))
        yield with_end(document, name, 0, low + (high - low) * share)
    confidence = F(entry["confidence"])
    yield with_confidence(document, name, confidence + (1 - confidence) * F(pick.randint(1, 9), 10))
    for side in ("upper", "lower"):
        level = F(entry["levels"][side])
        yield put(document, name, ("levels", side), text(level * F(pick.randint(11, 30), 10)))
        yield put(document, name, ("levels", side), "0")
    yield put(document, name, ("region",), {"box": "pairs", "pairs": "contrasts", "contrasts": "box"}[entry["region"]])
    yield put(document, name, ("region",), "product")
    if entry["ends"] == "together":
        yield put(document, name, ("ends",), "each")
    else:
        yield put(document, name, ("ends",), "together")
    yield put(document, name, ("limits",), ["-7", "7"])
    yield put(document, name, ("limits",), ["0", "1/100"])


def of_box(document: dict[str, Any], name: str, pick: Random) -> Iterator[dict[str, Any]]:
    """Ends of cells that the draws do not exclude at their level."""
    entry = document["intervals"][name]
    for side in ("upper", "lower"):
        for i, ends in enumerate(entry[side]):
            lo, hi = map(F, ends)
            for share in (F(1, 1000), F(1, 20), F(1, 3)):
                yield put(document, name, (side, i, 0), text(lo + (hi - lo) * share))
                yield put(document, name, (side, i, 1), text(hi - (hi - lo) * share))
        yield put(document, name, (side,), entry[side][1:])
        yield put(document, name, (side,), [*entry[side], entry[side][0]])


def of_contrasts(document: dict[str, Any], name: str, pick: Random) -> Iterator[dict[str, Any]]:
    """Another pair, or none, in the place of the one that proves the lower end; ladders, where there are none."""
    pair = document["intervals"][name]["pair"]
    if pair is not None:
        b, i, j = pair
        for other in ([b, j, i], [b, i, i], [b + 7, i, j], None):
            yield put(document, name, ("pair",), other)
    else:
        yield put(document, name, ("pair",), [0, 0, 1])
    yield put(document, name, ("independent",), False)
    yield put(document, name, ("upper",), [])
    for _ in range(12):
        low, high = map(F, document["intervals"][name]["difference"])
        share = F(pick.randint(1, 99), 100)
        yield with_end(document, name, 1, low + (high - low) * share)
        yield with_end(document, name, 0, low + (high - low) * share)


def counts_of(document: dict[str, Any], name: str) -> tuple[list[list[tuple[int, int]]], Fraction]:
    """Successes and draws of the cells by block, and how far apart the two values are, read off the table."""
    table = document["subject"]["table"]
    values = [*map(F, table["header"]["utility"])]
    low, high = min(F(0), *values), max(F(0), *values)
    rows = [(row["context"], row["group"], [*map(int, row["weights"])]) for row in table["rows"]]
    cells: dict[Any, list[tuple[int, int]]] = {}
    for x, a, weights in rows:
        wins = sum(w for w, v in zip(weights, values, strict=True) if v == high)
        cells.setdefault((x, a) if name.startswith("local") else (0, a), []).append((wins, sum(weights)))
    blocks: dict[int, list[tuple[int, int]]] = {}
    for (x, _), parts in sorted(cells.items()):
        blocks.setdefault(x, []).append((sum(k for k, _ in parts), sum(n for _, n in parts)))
    return [*blocks.values()], high - low


def of_pairs(document: dict[str, Any], name: str, pick: Random) -> Iterator[dict[str, Any]]:
    """Ladders with other knots, as far as another reading finds that they prove nothing."""
    entry, (blocks, width) = document["intervals"][name], counts_of(document, name)
    alpha = (1 - F(entry["confidence"])) / (1 if entry["ends"] == "each" else 2)
    couples = [(block[i], block[j]) for block in blocks for i, j in permutations(range(len(block)), 2)]
    ladders = (
        []
        if entry["upper"] is None
        else [(("upper", at), *couple, F(entry["difference"][1]) / width, alpha, 0) for at, couple in enumerate(couples)]
    )
    if entry["lower"] is not None:
        b, i, j = entry["lower"]["pair"]
        ladders.append((("lower", "knots"), blocks[b][j], blocks[b][i], -F(entry["difference"][0]) / width, alpha / len(couples), 1))
        yield put(document, name, ("lower", "pair"), [b, j, i])
        yield put(document, name, ("lower", "pair"), [b, i, i])
        yield put(document, name, ("lower",), None)
    for path, (k, n), (other, m), limit, level, _ in ladders:
        knots = [F(q) for q in entry[path[0]][path[1]]]
        scale = order_scale(level * (1 if entry["ends"] == "each" else 2))
        for _ in range(8):
            change, at = pick.randrange(4), pick.randrange(len(knots))
            altered = [*knots]
            if change == 0 and len(knots) > 1:
                del altered[at]
            elif change == 1:
                altered = altered[: at + 1]
            elif change == 2:
                altered = altered[at:]
            else:
                altered[at] *= F(pick.randint(80, 120), 100)
            if rarity((k, n, other, m), limit, level, altered, scale, True) > 1 + 1e-9:
                yield put(document, name, path, [text(q) for q in altered])


def test_altered_evidence_is_refused() -> None:
    """Many alterations of each region, none of which the checker takes; FAIRAUDIT_FULL=1 makes 2,000 of each."""
    made = {"box": 0, "pairs": 0, "contrasts": 0}
    for seed in range(400):
        if min(made.values()) >= ENOUGH:
            break
        pick = Random(tiers.fresh(seed))
        exact = made["pairs"] < ENOUGH and (seed % 3 == 0 or min(made["box"], made["contrasts"]) >= ENOUGH)
        document = certified(pick, exact=exact)
        assert outcome(document) == "true"
        for name in NAMES:
            region = document["intervals"][name]["region"]
            own = {"box": of_box, "pairs": of_pairs, "contrasts": of_contrasts}[region]
            for altered in (*common(document, name, pick), *own(document, name, pick)):
                made[region] += 1
                said = outcome(altered)
                same = altered["intervals"][name] == document["intervals"][name]
                assert same or said != "true", (seed, name, altered["intervals"][name])
    assert tiers.enough(min(made.values()) >= ENOUGH)


def of_ratios(document: dict[str, Any]) -> Iterator[dict[str, Any]]:
    """Every kind of claim about a ratio that there is, beside what a certificate says."""
    table = document["subject"]["table"]["sha256"]
    keys: list[tuple[tuple[str, str, str, str], dict[str, Any]]] = []
    for key, rule in checker.claims.RULES.items():
        if "ratio" in key[0] or key[2] == "T7":
            keys.append((key, {rule.evidence: table if rule.evidence == "table" else "3"} if rule.evidence else {}))
    scopes = {claim["scope"] for claim in document["claims"] if claim["scope"].startswith("population")}
    methods = ("binomial", "pair-exact", "symmetric-betting", "hoeffding-kl", "betting")
    for quantity, relation, by, scope in product(("local_ratio", "global_ratio"), ("<=", ">="), methods, sorted(scopes)):
        for name in ("local", "global", *NAMES):
            keys.append(((quantity, relation, by, scope), {"interval": name}))
    for (quantity, relation, by, scope), evidence in keys:
        assumptions = document["claims"][-1]["assumptions"] if scope.startswith("population") else []
        value = "1" if relation == ">=" else "inf"
        stated = {"quantity": quantity, "relation": relation, "value": value, "scope": scope}
        yield {**stated, "by": by, "assumptions": assumptions, "evidence": evidence}


def test_no_claim_about_a_ratio_is_true_of_a_utility_below_0() -> None:
    law = fa.Law.from_array([[[30, 10], [20, 20]], [[5, 9], [8, 8]]], kind="counts", decisions=["yes", "no"])
    certificate = fa.certify(law, {"yes": 1, "no": -1}, difference=True, confidence="0.9", max_difference=1).certificate
    document = json.loads(certificate.text)
    assert outcome(document) == "true"
    for claim in of_ratios(document):
        altered = copy.deepcopy(document)
        altered["claims"].append(claim)
        assert outcome(altered) != "true", claim


def test_no_interval_or_limit_of_a_ratio_is_taken_of_a_utility_below_0() -> None:
    law = fa.Law.from_array([[30, 10], [20, 20]], kind="counts", decisions=["yes", "no"])
    above = json.loads(fa.certify(law, {"yes": 2}, difference=True, confidence="0.9").certificate.text)
    below = json.loads(fa.certify(law, {"yes": 1, "no": -1}, difference=True, confidence="0.9").certificate.text)
    for name in ("local", "global"):
        altered = copy.deepcopy(below)
        altered["intervals"][name] = above["intervals"][name]
        altered["claims"] += [claim for claim in above["claims"] if claim["evidence"] == {"interval": name}]
        assert outcome(altered) != "true"
        altered = copy.deepcopy(below)
        altered["metrics"][name] = above["metrics"][name]
        assert outcome(altered) != "true"
        for judged in ("this table", "population at confidence 9/10"):
            for unit, verdict in (("ratio", "inconclusive"), ("log", "inconclusive"), ("ratio", "within")):
                altered = copy.deepcopy(below)
                altered["targets"] = [{"quantity": name, "limit": "2", "unit": unit, "judged": judged, "verdict": verdict}]
                altered["verdict"] = verdict
                assert outcome(altered) != "true"
    altered = copy.deepcopy(above)  # a declared range that goes below 0 says as much
    for name in ("local", "global"):
        altered["intervals"][name]["limits"] = ["-1", "2"]
    assert outcome(altered) != "true"
    for name in NAMES:  # nothing but ratios could be stated
        del altered["metrics"][name]
    altered = {**below, "metrics": {key: value for key, value in below["metrics"].items() if key not in NAMES}}
    altered["claims"] = [claim for claim in below["claims"] if claim["quantity"] not in NAMES]
    altered = {key: value for key, value in altered.items() if key != "intervals"}
    assert outcome(altered).startswith("malformed")


def test_units_of_both_contrasts_are_the_same() -> None:
    pick = Random(tiers.fresh(5))
    rows = {"u": [pick.choice("ab") for _ in range(40)], "a": [pick.choice("fm") for _ in range(40)]}
    law = fa.Law.from_log({**rows, "person": [str(pick.randrange(15)) for _ in range(40)]}, decision="u", group="a", unit="person")
    document = json.loads(fa.certify(law, {"a": 1}, difference=True, max_difference="1/2").certificate.text)
    assert outcome(document) == "true" and document["intervals"]["local_difference"]["units"] == document["intervals"]["local"]["units"]
    altered = copy.deepcopy(document)
    del altered["intervals"]["local_difference"]["units"]
    assert outcome(altered) != "true"
    altered = copy.deepcopy(document)
    altered["intervals"]["local_difference"]["measured"]["value"] = "1/7"
    assert outcome(altered) != "true"


def test_what_proves_a_ratio_within_units_proves_no_difference() -> None:
    pick = Random(tiers.fresh(5))
    rows = [(pick.choice("ab"), g, str(who)) for who in range(60) for g in "fm" for _ in range(2)]
    table = dict(zip(("u", "g", "who"), map(list, zip(*rows, strict=True)), strict=True))
    options: dict[str, Any] = {"decision": "u", "group": "g", "unit": "who", "utility": {"a": 5}, "difference": True}
    document = json.loads(fa.audit(table, **options).certificate.text)
    of_ratio = document["intervals"]["local"]
    assert outcome(document) == "true" and of_ratio["region"] == "paired" and of_ratio["ratio"][1] != "inf"
    own = document["intervals"]["local_difference"]
    forged = {key: value for key, value in of_ratio.items() if key not in ("ratio", "measured")}
    document["intervals"]["local_difference"] = {**forged, "difference": of_ratio["ratio"], "measured": own["measured"]}
    for claim in document["claims"]:
        if claim["evidence"] == {"interval": "local_difference"}:
            claim["by"], claim["value"] = "paired-betting", of_ratio["ratio"][claim["relation"] == "<="]
    assert outcome(document) != "true"
