"""Certificates of policies behind filters with all that T13 claims of other policies, true and altered."""

from __future__ import annotations

import json
import random
from collections.abc import Iterator
from fractions import Fraction
from itertools import pairwise
from typing import Any

from assumptions import complete
from certificate_changes import put
from plain_certificates import INF, checker, text
from policy_certificates import FLOORED, POLICIES, TINY, Policy, write
from policy_floors import Floor, floors, greatest, place, priced, prices, witness
from policy_suprema import ZERO, Compared, by_steps, compared, declare, floor_in, laws_of, mean_floor, near_by_steps, ranged

NEAR = checker.claims.NEAR
RANGE = checker.claims.ANY_UTILITY
FLOORED_RANGE = checker.claims.ANY_UTILITY_FLOORED
LARGEST = 16  # cells of a policy, for linear programs


def claim(quantity: str, relation: str, scope: str, value: Any, **evidence: Any) -> dict[str, Any]:
    found = {"quantity": quantity, "relation": relation, "by": "T13", "scope": scope, "value": text(value)}
    return found | {"assumptions": [], "evidence": evidence}


def _attained(p: Policy, quantity: str, scope: str, values: dict[Compared, Any], pick: random.Random) -> dict[str, Any]:
    value = max(values.values())
    where = [case for case, v in values.items() if v == value]
    return claim(quantity, "=", scope, value, attained=None if value == 1 else place(p, pick.choice(where)))


def _with_floors(p: Policy, quantity: str, cases: tuple[Compared, ...], kept: list[Floor], pick: random.Random) -> Iterator[dict[str, Any]]:
    """What is claimed of the policies that keep the floors: exactly, with prices and a policy, or as a bound by multipliers."""

    def excess(case: Compared, k: Fraction) -> Fraction:
        return sum((max(x - k * y for x, y in zip(a, b, strict=True)) for a, b in zip(case.p, case.q, strict=True)), ZERO)

    multipliers = [Fraction(pick.randint(0, 12), 4) for _ in range(3)]
    least: Any = Fraction(1)
    for case in cases:
        tau = floor_in(p, case.context) if case.context is not None else mean_floor(p, case.lower)
        values = [max(k, k + excess(case, k) / tau) for k in multipliers if tau]
        least = max(least, min([*values, by_steps(case)]))
    if least != INF:
        yield claim(quantity, "<=", FLOORED, least, multipliers=[*map(str, multipliers)], pairs=[], policy=None)
    if p.releases > 1 or len(p.must) * p.n > LARGEST:
        return
    found = {case: greatest(case, kept) for case in cases}
    value = max(v for v, _ in found.values())
    best = next(case for case, (v, _) in found.items() if v == value)
    policy = None if value == 1 else witness(p, best, found[best][1])
    pairs = [] if value == INF else [priced(p, case, kept, prices(case, kept, value)) for case in found]
    yield claim(quantity, "=", FLOORED, value, multipliers=[], pairs=pairs, policy=policy)


def claims_of(p: Policy, pick: random.Random) -> Iterator[dict[str, Any]]:
    """What T13 says of policies like this one, for the ratio in a context and for that of means."""
    kept = floors(p)
    for name, local in (("local", True), ("global", False)):
        cases = compared(p, local)
        if not cases:
            continue
        supremum = f"{name}_ratio_supremum"
        yield _attained(p, supremum, POLICIES, {case: by_steps(case) for case in cases}, pick)
        if p.releases == 1 and "max_drift" in p.declared:
            laws, drift = laws_of(p), p.declared["max_drift"]
            yield _attained(p, supremum, NEAR, {case: near_by_steps(case, laws, drift) for case in cases}, pick)
        if kept:
            yield from _with_floors(p, supremum, cases, kept, pick)
        if not p.declared.keys() >= {"gamma", "m"}:
            continue
        pairs = ranged(p, local)
        least = max(pair.least() for pair in pairs)
        if least != INF:
            yield claim(f"{name}_ratio", "<=", RANGE, least)
        if all(pair.tau for pair in pairs):
            multipliers = [pick.choice(pick.choice(pairs).turns()) for _ in range(3)]
            value = max(min(pair.gamma / pair.tau, *map(pair.proved, multipliers)) for pair in pairs)
            yield claim(f"{name}_ratio", "<=", FLOORED_RANGE, max(value, Fraction(1)), multipliers=[*map(str, multipliers)])


def certificate(seed: int) -> dict[str, Any]:
    """A true certificate of a random policy, of which T13 claims all that it can."""
    p, pick = Policy(seed), random.Random(f"over policies {seed}")
    if pick.random() < 0.8:
        declare(p, seed)
    if pick.random() < 0.6:
        p.declared["max_drift"] = pick.choice([ZERO, Fraction(1), *[Fraction(i, 12) for i in range(1, 9)]])
    found = write(p)
    of_figures = [c for c in found["claims"] if c["by"] in ("enumeration", "T6", "T7")]  # bounds rest on what was declared before
    found["claims"] = [*pick.sample(of_figures, 2), *claims_of(p, pick)]
    return complete(found)


# Alterations: of values, of where they are attained, of proofs and of policies


def _others(number: str) -> list[str]:
    if number == "inf":
        return ["1", "1000000000"]
    value = Fraction(number)
    return [str(value + TINY), str(value - TINY), str(2 * value), str(value / 2), "0", "1", "inf", f"-{number}"]


def altered(document: dict[str, Any], pick: random.Random) -> Iterator[dict[str, Any]]:
    """Change something of each claim by T13."""
    raw = json.dumps(document)
    contexts = [*{json.dumps(x): x for x in _labels(document, "context")}.values(), ["A"]]
    groups = [*{json.dumps(a): a for a in _labels(document, "group")}.values()]
    by = [(i, c) for i, c in enumerate(document["claims"]) if c["by"] == "T13"]
    for i, c in by:
        at = ("claims", i)
        for value in _others(c["value"]):
            yield put(raw, (*at, "value"), value)
        for name, other in (
            ("scope", pick.choice([POLICIES, NEAR, FLOORED, RANGE, FLOORED_RANGE, "this law"])),
            ("relation", pick.choice("=<") + "="),
        ):
            yield put(raw, (*at, name), other.replace("==", "="))
        yield put(raw, (*at, "quantity"), pick.choice(["local_ratio", "global_ratio", "local_ratio_supremum", "global_ratio_supremum"]))
        yield put(raw, (*at, "assumptions"), c["assumptions"][1:])
        yield put(raw, (*at, "assumptions"), [*c["assumptions"][:-1], f"{c['assumptions'][-1]} "])
        leaves = [*_leaves(c["evidence"])]
        for path, value in pick.sample(leaves, min(12, len(leaves))):
            others: list[Any] = [None, [], 0]
            if isinstance(value, str) and value[:1].isdigit():
                others = _others(value)
            elif path[-1] == "context":
                others = [*contexts, None, ["nowhere"]]
            elif path[-1] in ("higher", "lower"):
                others = [*groups, ["nobody"], None]
            elif isinstance(value, int):
                others = [value + 1, max(0, value - 1), None, -1, "0"]
            for other in pick.sample(others, min(2, len(others))):
                yield put(raw, (*at, "evidence", *path), other)
        for (path, one), (_, other) in pairwise(pick.sample(leaves, len(leaves))):
            if isinstance(one, str) and isinstance(other, str) and one != other and pick.random() < 0.2:
                yield put(raw, (*at, "evidence", *path), other)
        pairs = c["evidence"].get("pairs")
        if pairs:
            for other_pairs in (pairs[1:], [*pairs, pairs[0]], pairs[::-1], [{**pairs[0], "floors": []}, *pairs[1:]]):
                yield put(raw, (*at, "evidence", "pairs"), other_pairs)
    for key, value in document["subject"]["declared"].items():
        if isinstance(value, str):
            for other in pick.sample(_others(value), 2):
                yield put(raw, ("subject", "declared", key), other)
        else:
            for n, entry in enumerate(value):
                for name, number in entry.items():
                    other = pick.choice(contexts) if name == "context" else pick.choice(_others(number))
                    yield put(raw, ("subject", "declared", key, n, name), other)
            yield put(raw, ("subject", "declared", key), value[::-1])
            yield put(raw, ("subject", "declared", key), [])
    filters = document["subject"]["table"]["header"]["filters"]
    if "releases" in filters:
        yield put(raw, ("subject", "table", "header", "filters", "releases"), filters["releases"] + 1)


def _labels(document: dict[str, Any], of: str) -> Iterator[Any]:
    for c in document["claims"]:
        for path, value in _leaves(c["evidence"]):
            if path[-1] in (("context",) if of == "context" else ("higher", "lower")) and value is not None:
                yield value


def _leaves(value: Any, path: tuple[Any, ...] = ()) -> Iterator[tuple[tuple[Any, ...], Any]]:
    """Numbers, places, and lists of labels as one."""
    if isinstance(value, dict):
        for key, item in value.items():
            if key in ("context", "higher", "lower"):
                yield (*path, key), item
            else:
                yield from _leaves(item, (*path, key))
    elif isinstance(value, list) and value:
        for i, item in enumerate(value):
            yield from _leaves(item, (*path, i))
    elif path:
        yield path, value
