"""Forged certificates of rates with true labels, of what T13 says of other policies, and of what drifts."""

from __future__ import annotations

import copy
import json
from collections.abc import Callable, Iterator
from fractions import Fraction
from functools import cache
from typing import Any

import over_policies
from assumptions import complete
from certificate_kinds import rows_dropped
from forged_samples import NOT_NUMBERS, TINY, Forged, document, in_words, renamed, written
from plain_certificates import edited

F = Fraction


# Rates with true labels


def rates() -> Iterator[Forged]:
    """Rates of nobody, of others, or of another outcome; differences at another place; what was left out that was not."""
    true = document("truth")
    names = [name for name in true["metrics"] if "_rate" in name]
    for name in names:
        listed = true["metrics"][name]
        first = listed[0]
        other = true["metrics"][name.replace("true_", "other_").replace("false_", "true_").replace("other_", "false_")]
        overall = true["metrics"][name.removesuffix("_overall") if name.endswith("_overall") else f"{name}_overall"]
        here = {(json.dumps(r.get("context")), json.dumps(r["group"])) for r in listed}
        groups = [g for g in ("f", "m", "x", "y") if (json.dumps(first.get("context")), json.dumps({"a": g})) not in here]
        for what, value in (
            ("those of the other label", other),
            ("those of everywhere or of contexts", overall),
            ("none", []),
            ("null", None),
            ("one left out", listed[1:]),
            ("one twice", [first, *listed]),
            ("in another order", listed[::-1]),
            ("rates that add up to 1", [r | {"rate": str(1 - F(r["rate"]))} for r in listed]),
            *(
                (f"{g} with no denominator, {rate}", [*listed, first | {"group": {"a": g}, "rate": rate}])
                for g in groups
                for rate in ("0", "1", "1/0")
            ),
            *((f"a rate of {text!r}", [first | {"rate": text}, *listed[1:]]) for text in NOT_NUMBERS),
            ("another group", [first | {"group": {"a": "nobody"}}, *listed[1:]]),
            ("another column", [first | {"group": {"b": first["group"]["a"]}}, *listed[1:]]),
            ("a context too many", [first | {"context": {"x": "A", "y": "B"}}, *listed[1:]]),
            ("a rate by a tiny part", [first | {"rate": str(F(first["rate"]) + TINY)}, *listed[1:]]),
        ):
            yield f"{name}: {what}", written(true, (f"metrics.{name}", value))
    for name in ("equal_opportunity", "equal_opportunity_overall", "equalized_odds_true_label", "equalized_odds_true_label_overall"):
        metric = true["metrics"][name]
        if metric is None:
            yield f"{name} of nobody", written(true, (f"metrics.{name}", {"value": "0", "witness": {}}))
            continue
        witness = metric["witness"]
        for path, value in (
            ("value", "0"),
            ("value", str(F(metric["value"]) - TINY)),
            ("value", str(-F(metric["value"]))),
            ("witness.rate", "false_positive_rate" if witness["rate"].startswith("true") else "true_positive_rate"),
            ("witness.rate", "rate"),
            ("witness.higher", witness["lower"]),
            ("witness.lower", witness["higher"]),
            ("witness.rates", witness["rates"][::-1]),
            ("witness.rates", ["1", "1"]),
            ("witness.context", {"x": "B"}),
            ("witness.context", {"x": "C"}),
        ):
            if not (path == "witness.context" and witness.get("context") == value):
                yield f"{name} {path} {str(value)[:30]}", written(true, (f"metrics.{name}.{path}", value))
        yield f"{name} null", written(true, (f"metrics.{name}", None))
    positive = true["subject"]["positive"]
    for key, value in (
        ("decision", positive["decision"][:1]),
        ("decision", ["no"]),
        ("decision", []),
        ("decision", [*positive["decision"], "no"]),
        ("decision", positive["decision"] * 2),
        ("decision", ["Yes", "call"]),
        ("truth", "not"),
        ("truth", "Fit"),
        ("truth", None),
        ("truth", ["fit"]),
    ):
        yield f"positive {key} {value}", written(true, (f"subject.positive.{key}", value))
    yield "positive left out", written(true, ("subject.positive", ...))
    left = true["not_compared"]
    for i, entry in enumerate(left):
        yield f"not compared: {i} left out", written(true, ("not_compared", left[:i] + left[i + 1 :]))
        yield f"not compared: {i} twice", written(true, ("not_compared", [*left, entry]))
        for reason in ("no decisions with another true label", "no decisions with the positive true label", "fewer than two groups"):
            if entry.get("reason") != reason:
                yield f"not compared: {i} for {reason}", written(true, (f"not_compared.{i}.reason", reason))
    for i, row in enumerate(true["subject"]["table"]["rows"][:3]):
        labels = row["truth"]
        at = f"subject.table.rows.{i}.truth"
        for what, value in (
            ("labels exchanged", labels[::-1]),
            ("nothing", [["0"] * len(r) for r in labels]),
            ("one too many", [*labels, labels[0]]),
        ):
            for digest in (False, True):
                if value != labels:
                    yield f"row {i}: {what}, {digest}", written(true, (at, value), digest=digest)
    for i, claim in enumerate(true["claims"]):
        if claim["quantity"].startswith("equal_opportunity") or "true_label" in claim["quantity"]:
            for key, value in (
                ("value", "0"),
                ("relation", "<="),
                ("relation", ">="),
                ("by", "T7"),
                ("scope", "population at confidence 19/20"),
            ):
                yield f"claim {i} {key} {value}", written(true, (f"claims.{i}.{key}", value))
    yield from renamed("truth", [("truth", '"t"'), ("truths", '["fit"]'), ("positive", "{}"), ("rate", '"0"'), ("rates", '["1", "0"]')])


# Other policies


SEEDS = (5, 6, 40, 61, 73, 212)
ONE_WAY = (6,)
"""Of which no two groups are alike, so that what one exceeds the other by is not what that exceeds it by."""
POLICIES, NEAR = over_policies.POLICIES, over_policies.NEAR
RANGE, FLOORED_RANGE = over_policies.RANGE, over_policies.FLOORED_RANGE


@cache
def _of_policies(seed: int) -> str:
    return json.dumps(over_policies.certificate(seed))


def _supposed(true: Any, path: str, value: Any) -> bytes:
    """What was declared changed, and the sentences of all claims with it."""
    made = edited(copy.deepcopy(true), path, value)
    try:
        return json.dumps(complete(made)).encode()
    except (ValueError, TypeError, KeyError, AttributeError, StopIteration, ZeroDivisionError):
        return json.dumps(made).encode()


def other_policies() -> Iterator[Forged]:
    """Suprema that are not reached where they are said to be, proofs for other floors, and declarations that the table contradicts."""
    for seed in SEEDS:
        true = json.loads(_of_policies(seed))
        by = [(i, c) for i, c in enumerate(true["claims"]) if c["by"] == "T13"]
        for i, c in by:
            name = f"{seed}: claim {i}"
            at = f"claims.{i}"
            if c["value"] not in ("1", "inf"):
                yield f"{name} a little less", written(true, (f"{at}.value", str(F(c["value"]) - TINY)))
                yield f"{name} 1", written(true, (f"{at}.value", "1"))
            yield f"{name} 1/2", written(true, (f"{at}.value", "1/2"))
            for text in ("1/0", "-0", "01", "2/2", "9" * 40 + "/0", None) if i == by[0][0] else ():
                yield f"{name} {str(text)[:9]}", written(true, (f"{at}.value", text))
            for scope in (POLICIES, NEAR, RANGE, "any policy", f"{c['scope']} "):
                if scope != c["scope"] and not (scope == POLICIES and "attained" in c["evidence"]):
                    yield f"{name} of {scope[-30:]!r}", written(true, (f"{at}.scope", scope))
            yield f"{name} twice", written(true, ("claims", [*true["claims"], c]))
            yield f"{name} assumes the moon", written(true, (f"{at}.assumptions", [*c["assumptions"], "the moon is full"]))
            for n in range(len(c["assumptions"])):
                fewer = c["assumptions"][:n] + c["assumptions"][n + 1 :]
                yield f"{name} without assumption {n}", written(true, (f"{at}.assumptions", fewer))
            evidence = c["evidence"]
            floored = any(
                F(c["value"]) < F(d["value"])
                for _, d in by
                if (d["quantity"], d["scope"]) == (c["quantity"], POLICIES) and d["value"] != "inf"
            )
            if "attained" in evidence:
                place = evidence["attained"]
                if place is None:
                    other = next(
                        (d["evidence"]["attained"] for _, d in by if d["evidence"].get("attained")),
                        {"context": None, "higher": [], "lower": []},
                    )
                    yield f"{name} attained somewhere", written(true, (f"{at}.evidence.attained", other))
                else:
                    turned = place | {"higher": place["lower"], "lower": place["higher"]}
                    turns = [turned] if seed in ONE_WAY else []
                    for other in (
                        None,
                        *turns,
                        place | {"lower": place["higher"]},
                        place | {"higher": ["nobody"]},
                        place | {"salt": 1},
                        {},
                    ):
                        yield f"{name} attained at {str(other)[:40]}", written(true, (f"{at}.evidence.attained", other))
                    elsewhere = None if place["context"] is not None else ["nowhere"]
                    yield f"{name} attained in another context", written(true, (f"{at}.evidence.attained.context", elsewhere))
            if evidence.get("multipliers"):
                for given in (["-1"], ["1/0"], [None], "1", ["01"]):
                    yield f"{name} by {given}", written(true, (f"{at}.evidence.multipliers", given))
                if floored:
                    for given in ([], ["1000"]):
                        yield f"{name} by {given}", written(true, (f"{at}.evidence.multipliers", given))
            if evidence.get("pairs") and floored:
                pairs = evidence["pairs"]
                others = [p for p in pairs if any(p[key] != label for key, label in evidence["policy"]["attained"].items())]
                for what, listed in (
                    ("none", []),
                    ("the one that decides left out", others),
                    ("one twice", [*pairs, pairs[0]]),
                    ("one for all", [pairs[0]] * len(pairs)),
                ):
                    if listed != pairs:
                        yield f"{name} pairs: {what}", written(true, (f"{at}.evidence.pairs", listed))
            for n, entry in enumerate(evidence.get("pairs", []) if floored else []):
                if entry["floors"] and all(entry[key] == label for key, label in evidence["policy"]["attained"].items()):
                    x, a, y = entry["floors"][0]
                    for wrong_ in (
                        [x, a, "0"],
                        [x, a, f"-{y}"],
                        [x, 10**6, y],
                        [10**6, a, y],
                        [x, -1, y],
                        [x, a],
                        [x, a, str(F(y) * 1000)],
                        [x, a, "1/0"],
                    ):
                        yield f"{name} floor of pair {n}: {str(wrong_)[:40]}", written(true, (f"{at}.evidence.pairs.{n}.floors.0", wrong_))
                    yield f"{name} no floors of pair {n}", written(true, (f"{at}.evidence.pairs.{n}.floors", []))
            if evidence.get("policy"):
                yield f"{name} without a policy", written(true, (f"{at}.evidence.policy", None))
                shown, rows = evidence["policy"]["attained"], evidence["policy"]["rows"]
                turned = shown | {"higher": shown["lower"], "lower": shown["higher"]}
                for other in (None, turned, shown | {"lower": ["nobody"]}, {}):
                    yield f"{name} shown at {str(other)[:40]}", written(true, (f"{at}.evidence.policy.attained", other))
                law = rows[0][0]
                for what, laws in (
                    ("none", []),
                    ("fewer", rows[:-1]),
                    ("more", [*rows, rows[0]]),
                    ("no law", [[["1"] * (len(law) + 1), *rows[0][1:]], *rows[1:]]),
                    ("a law of 2", [[["2"] * len(law), *rows[0][1:]], *rows[1:]]),
                    ("the same everywhere", [[["1", *["0"] * (len(law) - 1)] for _ in block] for block in rows]),
                ):
                    yield f"{name} shown by {what}", written(true, (f"{at}.evidence.policy.rows", laws))
            others = [d for _, d in by if d["quantity"] != c["quantity"] and d["scope"] == c["scope"] and d["evidence"] != evidence]
            if others and c["value"] not in ("1", "inf") and "multipliers" not in others[0]["evidence"]:
                yield f"{name} by what another one has", written(true, (f"{at}.evidence", others[0]["evidence"]))
            if c["scope"] == NEAR and any(
                d["value"] != c["value"] for _, d in by if (d["quantity"], d["scope"]) == (c["quantity"], POLICIES)
            ):
                yield f"{name}, a drift of 1", _supposed(true, "subject.declared.max_drift", "1")
        declared = true["subject"]["declared"]
        for key in [k for k in ("gamma", "m", "tau", "lipschitz", "global_tau", "max_drift") if k in declared]:
            own = F(declared[key])
            if key in ("m", "tau", "global_tau", "max_drift"):
                yield f"{seed}: {key} {own + 5}", _supposed(true, f"subject.declared.{key}", str(own + 5))
            for text in ("1/0", "-1", "-0", "01", "inf", None, 1):
                yield f"{seed}: {key} {text}", _supposed(true, f"subject.declared.{key}", text)
        yield f"{seed}: something else declared", _supposed(true, "subject.declared.salt", "0")
        listed = declared.get("by_context", [])
        wrong: list[Any] = [[], None, {}, [{}], [{"context": ["nowhere"], "tau": "0"}], [{"context": []}], [{"tau": "0"}]]
        if listed:
            entry = listed[0]
            wrong += [[entry, *listed], [entry, entry | {"tau": "0"}], [*listed[:-1], listed[-1] | {"salt": "0"}]]
            wrong += [
                [entry | {key: value}, *listed[1:]]
                for key, value in (("gamma", "0"), ("m", "100"), ("tau", "100"), ("tau", "-1"), ("gamma", "1/0"))
                if not (key == "gamma" and F(entry.get("tau", "0")) == 0)
            ]
            wrong += [[{"context": entry["context"]}, *listed[1:]], [entry | {"context": None}, *listed[1:]]]
        if len(listed) > 1:
            wrong.append(listed[::-1])
        for value in wrong:
            yield f"{seed}: by_context {str(value)[:60]}", _supposed(true, "subject.declared.by_context", value)
    text = _of_policies(6)
    for key, other in (("global_tau", '"0"'), ("attained", "null"), ("multipliers", '["1"]'), ("max_drift", '"1"'), ("declared", "{}")):
        yield f"{key} twice", text.replace(f'"{key}": ', f'"{key}": {other}, "{key}": ', 1).encode()


# Drift


def drifts() -> Iterator[Forged]:
    """Radii that are a bit too large, pairs that do not turn, groups that are not followed, and limits judged beside the drift."""
    for kind in ("exceeding", "drift"):
        true = document(kind)
        for i, c in enumerate(true["claims"]):
            if c["by"] != "T16":
                continue
            name = f"{kind}: claim {i}"
            at, evidence = f"claims.{i}", c["evidence"]
            value = None if c["value"] == "inf" else F(c["value"])
            worse = []
            if value is not None:
                if "limit" in evidence:
                    worse = [value + F(1, 10**9), value * 2 + 1] + [value + TINY] * (c["relation"] == "=")
                else:
                    worse = [value + TINY, value - TINY, value * 2]
            for other in worse:
                yield f"{name} {str(other)[:12]}", written(true, (f"{at}.value", str(other)))
            for text in ("1/0", "-0", "01", "-1", None, *(("inf",) if value is not None else ())):
                yield f"{name} {text}", written(true, (f"{at}.value", text))
            if "limit" in evidence:
                for verdict in {"within", "exceeds", "inconclusive", "depends"} - {evidence["verdict"]}:
                    yield f"{name} {verdict}", written(true, (f"{at}.evidence.verdict", verdict))
                stricter = F(evidence["limit"]) * (F(9, 10) if evidence["verdict"] == "within" else F(11, 10))
                for limit in (str(stricter), "1/0", "-1", "01", "inf", None):
                    yield f"{name} limit {limit}", written(true, (f"{at}.evidence.limit", limit))
            pair = evidence["pair"]
            if pair is not None:
                turned = pair | {"higher": pair["lower"], "lower": pair["higher"]}
                where = [None, ["0"], ["1"], ["2"], ["0", "1"], []]
                changed = [turned, pair | {"lower": pair["higher"]}, pair | {"higher": ["9"]}, pair | {"salt": 1}, {}]
                changed += [pair | {"context": x} for x in where if x != pair["context"]]
                if c["relation"] == "=" or evidence.get("verdict") == "exceeds" or "limit" not in evidence:
                    changed.append(None)
                for other in changed:
                    yield f"{name} pair {str(other)[:50]}", written(true, (f"{at}.evidence.pair", other))
            followed = evidence["followed"]
            lists: list[Any] = [[["9"]], [["0"], ["0"]], [["0", "1"]], [[]], None, ["0"], [[0]]]
            if followed:
                lists += [[g for g in followed if g not in (pair["higher"], pair["lower"])]] * (pair is not None) + [[]]
            else:
                lists += [[["0"], ["1"], ["2"]], [["0"]]]
            for listed in lists:
                yield f"{name} follows {listed}", written(true, (f"{at}.evidence.followed", listed))
            for key, word in (
                ("relation", "<=" if c["relation"] == "=" else "=="),
                ("by", "T14"),
                ("by", "T13"),
                ("by", "enumeration"),
                ("scope", "population, one-sided at confidence 19/20"),
                ("scope", "this law, within the declared drift" if "limit" in evidence else "this law"),
                ("scope", "any policy behind this filter"),
                (
                    "quantity",
                    c["quantity"].replace("local", "global") if "local" in c["quantity"] else c["quantity"].replace("global", "local"),
                ),
                ("quantity", "unfairness"),
                ("assumptions", []),
                ("assumptions", c["assumptions"][1:]),
                ("assumptions", c["assumptions"][:-1]),
                ("assumptions", c["assumptions"] * 2),
                ("assumptions", [*c["assumptions"], "the moon is full"]),
            ):
                yield f"{name} {key} {str(word)[:50]}", written(true, (f"{at}.{key}", word))
            for unit, other in (
                ("ratio_radius", "ratio_factor"),
                ("log_radius", "log_factor"),
                ("ratio_factor", "ratio_radius"),
                ("log_factor", "log_radius"),
            ):
                if c["quantity"].endswith(unit):
                    yield f"{name} {other}", written(true, (f"{at}.quantity", c["quantity"].replace(unit, other)))
            yield f"{name} twice", written(true, ("claims", [*true["claims"], c]))
    true = document("drift")
    for eta in ("0", "1/1000", "1/21", "1/2", "1", "3/2", "-1/20", "1/0", "01/20", "inf", None, 0):
        yield f"a drift of {eta}", written(true, ("subject.max_drift", eta))
        if isinstance(eta, str):
            sentence = "total variation of at most"
            words = in_words(true, (f"{sentence} 1/20", f"{sentence} {eta}"))
            yield f"a drift of {eta}, said throughout", written(words, ("subject.max_drift", eta))
    yield "no drift declared", written(true, ("subject.max_drift", ...))
    without = [c for c in true["claims"] if "declared drift" not in c["scope"]]
    yield "no claims about the drift", written(true, ("claims", without))
    for i, target in enumerate(true["targets"]):
        for verdict in {"within", "exceeds", "depends", "inconclusive", "changed"} - {target["verdict"]}:
            yield f"target {i} {verdict}", written(true, (f"targets.{i}.verdict", verdict))
            yield f"target {i} {verdict}, and so all", written(true, (f"targets.{i}.verdict", verdict), ("verdict", verdict))
        for judged in (
            "this law, within the declared drift",
            "population at confidence 19/20",
            "population at confidence 19/20, within the declared drift",
        ):
            yield f"target {i} judged {judged!r}", written(true, (f"targets.{i}.judged", judged))
    lost = json.loads(rows_dropped(max_global_ratio=3, max_drift="1/20", confidence=None).certificate.text)
    for i, c in enumerate(lost["claims"]):
        listed = c["assumptions"]
        for assumed in ([], listed[:-1], [*listed[:-1], "the moon is full"], [*listed, "the moon is full"], listed * 2):
            if assumed != listed:
                yield f"rows left out: claim {i} assumes {len(assumed)}", written(lost, (f"claims.{i}.assumptions", assumed))
    for value in (..., [], None, [{}]):
        yield f"rows left out: {value}", written(lost, ("subject.preparation", value))
    yield from renamed("drift", [("max_drift", '"0"'), ("followed", "[]"), ("pair", "null"), ("judged", '"this table"')])


OF_STATEMENTS: tuple[Callable[[], Iterator[Forged]], ...] = (rates, other_policies, drifts)
