"""Forged claims of T13: at and just below the greatest ratio, with other evidence, other constants, other sentences. None is accepted.

All 150 random deployments: FAIRAUDIT_FULL=1 pytest -n0 -s tests/checker/test_forgeries_of_checker.py
"""

from __future__ import annotations

import copy
import itertools
from collections import Counter
from collections.abc import Iterable, Iterator, Sequence
from fractions import Fraction
from functools import cache, partial
from itertools import permutations
from typing import Any

import pytest
import tiers
from assumptions import complete
from plain_certificates import INF, checker, ratio, raw, text
from policy_certificates import FLOORED, POLICIES, TINY, Policy, write
from policy_floors import Floor, floors, greatest, place, priced, prices, witness
from policy_suprema import Compared, by_steps, compared, declare, floor_in, laws_of, near_by_steps, ranged, sums

NEAR, ANY_UTILITY, ANY_UTILITY_FLOORED = checker.claims.NEAR, checker.claims.ANY_UTILITY, checker.claims.ANY_UTILITY_FLOORED
BLOCKS = 3
DEPLOYMENTS = 150 if tiers.FULL else 6
Forged = tuple[str, dict[str, Any], dict[str, Any]]  # what was done, the claim, and other members of ``declared``


def accepted(certificate: dict[str, Any]) -> bool:
    try:
        return bool(checker.check(raw(certificate)).ok)
    except checker.FormatError:
        return False


def values(value: Any, exact: bool) -> Iterator[tuple[str, Any]]:
    """Other values, less than the true one, and greater ones where the true one is stated exactly."""
    if value == INF:
        yield from [("finite", Fraction(10**12)), ("1", Fraction(1))]
        return
    yield "10^-9 less", value - TINY
    yield "a unit less in the numerator", value - Fraction(1, value.denominator)
    yield "10^-60 less", value - Fraction(1, 10**60)
    if value > 1:
        yield "1", Fraction(1)
        yield "half way to 1", (1 + value) / 2
    if exact:
        yield "10^-9 more", value + TINY
        yield "a unit more in the numerator", value + Fraction(1, value.denominator)
    yield "infinite", INF


def statement(local: bool, relation: str, scope: str, value: Any, **evidence: Any) -> dict[str, Any]:
    quantity = ("local" if local else "global") + "_ratio" + "_supremum" * (scope in (POLICIES, NEAR, FLOORED))
    return {"quantity": quantity, "relation": relation, "by": "T13", "scope": scope, "value": text(value), "evidence": evidence}


def other_places(p: Policy, of_cases: dict[Compared, Any], value: Any) -> Iterator[tuple[str, Any]]:
    """Places where the value is not attained."""
    true = next(case for case, v in of_cases.items() if v == value)
    for case, v in of_cases.items():
        if v != value:
            names = {(True, False): "another context", (False, True): "swapped groups"}
            swapped = (case.higher, case.lower) == (true.lower, true.higher)
            yield names.get((case.context != true.context, swapped), "another pair"), place(p, case)
    at = place(p, true)
    yield "no place", None
    yield "a group with itself", at | {"lower": at["higher"]}
    yield "no such group", at | {"lower": [*at["lower"], "x"]}
    yield "no such context", at | {"context": ["nowhere"]}
    yield "a context or none", at | {"context": None if at["context"] is not None else p.true_x[0]}


# By scope: a true claim, and forged ones


def attained(
    p: Policy, local: bool, scope: str, of_cases: dict[Compared, Any], changes: Iterable[tuple[str, Any, Any]] = ()
) -> Iterator[Forged]:
    """Forgeries of a greatest ratio with the place where it is attained; and changes of what was declared that change the value."""
    value = max(of_cases.values())
    at = place(p, next(case for case, v in of_cases.items() if v == value))
    claim = partial(statement, local, "=", scope)
    yield "true", claim(value, attained=None if value == 1 else at), {}
    for name, forged in values(value, True):
        yield name, claim(forged, attained=None if forged == 1 else at), {}
    if value > 1:
        for name, elsewhere in other_places(p, of_cases, value):
            yield name, claim(value, attained=elsewhere), {}
    else:
        yield "a place for 1", claim(value, attained=at), {}
    for case, v in of_cases.items():
        if v != value:
            yield "the value of another pair", claim(v, attained=place(p, case)), {}
    for name, declared, changed in changes:
        if changed != value:
            yield name, claim(value, attained=None if value == 1 else at), declared


def forged_near(p: Policy, local: bool) -> Iterator[Forged]:
    laws, drift = laws_of(p), p.declared["max_drift"]

    def of_cases(eta: Fraction) -> dict[Compared, Any]:
        return {case: near_by_steps(case, laws, eta) for case in compared(p, local)}

    def changes() -> Iterator[tuple[str, Any, Any]]:
        for name, eta in (("drift lowered", drift / 2), ("drift a little lower", drift - TINY), ("drift raised", (1 + drift) / 2)):
            yield name, {"max_drift": str(eta)}, max(of_cases(eta).values())
        yield "no drift", {"max_drift": None}, None

    return attained(p, local, NEAR, of_cases(drift), changes())


def forged_ranges(p: Policy, local: bool) -> Iterator[Forged]:
    least = max(pair.least() for pair in ranged(p, local))
    claim = partial(statement, local, "<=", ANY_UTILITY)
    if least == INF:
        yield "finite", claim(Fraction(10**12)), {}
        yield "infinite", claim(INF), {}
        return
    yield "true", claim(least), {}
    for name, forged in values(least, False):
        yield name, claim(forged), {}
    for name, declared in changed_ranges(p):
        if any(value is None for value in declared.values()) or max(pair.least() for pair in ranged(altered(p, declared), local)) > least:
            yield name, claim(least), declared


def forged_floored_ranges(p: Policy, local: bool) -> Iterator[Forged]:
    pairs = ranged(p, local)
    if not all(pair.tau for pair in pairs):
        yield "somebody has no floor", statement(local, "<=", ANY_UTILITY_FLOORED, Fraction(10**12), multipliers=["0", "1", "2"]), {}
        return
    ks = sorted({min([*pair.turns(), *([pair.least()] if pair.least() < INF else [])], key=pair.proved) for pair in pairs})

    def proved(multipliers: Sequence[Fraction], pairs: Any) -> Any:
        return max(min([pair.gamma / pair.tau, *map(pair.proved, multipliers)]) for pair in pairs)

    least = proved(ks, pairs)

    def claim(value: Any, multipliers: Any = ks) -> dict[str, Any]:
        return statement(local, "<=", ANY_UTILITY_FLOORED, value, multipliers=[str(k) for k in multipliers])

    yield "true", claim(least), {}
    for name, forged in values(least, False):
        yield name, claim(forged), {}
    for i, k in enumerate(ks):
        rest = [*ks[:i], *ks[i + 1 :]]
        for name, others in (("a multiplier removed", rest), ("a multiplier moved", [*rest, k + TINY])):
            if not others or proved(others, pairs) > least:
                yield name, claim(least, others), {}
    for name, declared in [*changed_ranges(p), *changed_floors(p)]:
        if any(declared.get(key, "") is None for key in ("gamma", "m")):
            yield name, claim(least), declared
            continue
        changed = ranged(altered(p, declared), local)
        if not all(pair.tau for pair in changed) or proved(ks, changed) > least:
            yield name, claim(least), declared


def changed_ranges(p: Policy) -> Iterator[tuple[str, dict[str, Any]]]:
    """Other ranges, of which some allow for more than those that are declared."""
    yield "gamma raised", {"gamma": p.declared["gamma"] + 1}
    yield "gamma a little higher", {"gamma": p.declared["gamma"] + TINY}
    yield "m lowered", {"m": p.declared["m"] / 2}
    yield "m a little lower", {"m": p.declared["m"] * (1 - TINY)}
    yield "groups further apart", {"lipschitz": p.declared.get("lipschitz", p.own["lipschitz"]) + Fraction(1, 2)}
    yield "gamma not declared", {"gamma": None}
    yield "m not declared", {"m": None}


def changed_floors(p: Policy) -> Iterator[tuple[str, dict[str, Any]]]:
    for key in ("tau", "global_tau"):
        if p.declared.get(key):
            yield f"{key} lowered", {key: p.declared[key] / 2}
            yield f"{key} a little lower", {key: p.declared[key] * (1 - TINY)}
            yield f"{key} not declared", {key: None}


def altered(p: Policy, declared: dict[str, Any]) -> Policy:
    """The same with other constants."""
    other = copy.copy(p)
    other.declared = {key: value for key, value in (p.declared | declared).items() if value is not None}
    return other


def forged_floored(p: Policy, local: bool) -> Iterator[Forged]:
    kept, cases = floors(p), compared(p, local)
    found = {case: greatest(case, kept) for case in cases}
    of_cases = {case: v for case, (v, _) in found.items()}
    value = max(of_cases.values())
    attaining = next(case for case, v in of_cases.items() if v == value)
    policy = found[attaining][1]
    by = None if value == 1 else witness(p, attaining, policy)
    if not kept:
        yield "no floor", statement(local, "=", FLOORED, value, multipliers=["1"], pairs=[], policy=by), {}
        return
    finite = value < INF
    ys = {case: prices(case, kept, value) for case in cases} if finite else {}
    ks: list[Fraction] = []

    def claim(value: Any, pairs: Any = None, by: Any = by, relation: str = "=") -> dict[str, Any]:
        listed = [priced(p, case, kept, y) for case, y in ys.items()] if pairs is None else pairs
        return statement(local, relation, FLOORED, value, multipliers=[str(k) for k in ks], pairs=listed, policy=by)

    yield "true", claim(value), {}
    for name, forged in values(value, True):
        yield name, claim(forged, by=None if forged == 1 else by), {}
    for name, forged in values(value, False):
        yield f"at most: {name}", claim(forged, by=None, relation="<="), {}
    if by is not None:
        yield "no policy", claim(value, by=None), {}
        yield "at most, with a policy", claim(value, relation="<="), {}
        ratios = {case: ratio(*sums(case, policy)) for case in cases}
        for name, at in other_places(p, ratios, value):
            if at is not None:
                yield f"policy: {name}", claim(value, by=by | {"attained": at}), {}
        for name, moved in moved_rows(policy):
            if not keeps(moved, kept) or ratio(*sums(attaining, moved)) != value:
                yield name, claim(value, by=witness(p, attaining, moved)), {}
    for case in ys if finite else ():
        if proves(p, case, kept, [Fraction(0)] * len(kept), value):
            continue
        entry = priced(p, case, kept, ys[case])
        others = [priced(p, other, kept, y) for other, y in ys.items() if other is not case]
        yield "a pair removed", claim(value, others), {}
        yield "a pair reversed", claim(value, [*others, entry | {"higher": entry["lower"], "lower": entry["higher"]}]), {}
        yield "a pair twice", claim(value, [*others, entry, entry]), {}
        for name, y in changed_prices(kept, ys[case]):
            if not proves(p, case, kept, y, value):
                yield name, claim(value, [*others, priced(p, case, kept, y)]), {}
        yield "a floor that is not there", claim(value, [*others, place(p, case) | {"floors": [[len(p.true_x), 0, "1"]]}]), {}
    for name, declared in changed_floors(p) if finite else ():
        lower = altered(p, declared)
        fewer = floors(lower)
        if not fewer or not all(proves(lower, case, kept, y, value) for case, y in ys.items()):
            yield name, claim(value), declared


def keeps(policy: Sequence[Sequence[Fraction]], kept: Sequence[Floor]) -> bool:
    """Whether a policy keeps the floors."""
    means = (sum(t * v for law, row in zip(policy, floor.e, strict=True) for t, v in zip(law, row, strict=True)) for floor in kept)
    return all(mean >= floor.value for mean, floor in zip(means, kept, strict=True))


def moved_rows(policy: list[list[Fraction]]) -> Iterator[tuple[str, list[list[Fraction]]]]:
    """Policies of which a row has another law."""
    for o, law in enumerate(policy):
        for u in range(len(law)):
            v = (u + 1) % len(law)
            for name, part in (("a row of the policy moved", law[u]), ("a row of the policy moved a little", law[u] * TINY)):
                if u != v and part:
                    moved = [[*row] for row in policy]
                    moved[o][u] -= part
                    moved[o][v] += part
                    yield name, moved
    if len(policy) > 1 and policy[0] != policy[-1]:
        yield "rows of the policy reversed", policy[::-1]


def changed_prices(kept: Sequence[Floor], y: list[Fraction]) -> Iterator[tuple[str, list[Fraction]]]:
    for factor in (Fraction(1, 2), Fraction(2), 1 - TINY, 1 + TINY, Fraction(10**9)):
        yield f"y times {factor if factor.denominator < 9 else float(factor)}", [v * factor for v in y]
    for i in range(len(y)):
        yield "all y on one floor", [sum(y, Fraction(0)) * (j == i) for j in range(len(y))]
        yield "a great y on one floor", [v + 10**6 * (j == i) for j, v in enumerate(y)]
    yield "y moved to other floors", y[1:] + y[:1]


def proves(p: Policy, case: Compared, kept: Sequence[Floor], y: Sequence[Fraction], value: Fraction) -> bool:
    """Whether an ordered pair is proved, by V as a multiplier or by prices."""
    plain = sum((max(a - value * b for a, b in zip(*rows, strict=True)) for rows in zip(case.p, case.q, strict=True)), Fraction(0))
    return plain <= 0 or proves_as_listed(p, case, kept, y, value)


def proves_as_listed(p: Policy, case: Compared, kept: Sequence[Floor], y: Sequence[Fraction], value: Fraction) -> bool:
    """The same by prices for floors that are declared; what they add is that of the floors of which they were found."""
    total = Fraction(0)
    for floor, v in zip(kept, y, strict=True):
        declared = p.declared.get("global_tau", Fraction(0)) if floor.context is None else floor_in(p, floor.context)
        if v and not declared:
            return False
        total -= v * declared
    for o, (p_row, q_row) in enumerate(zip(case.p, case.q, strict=True)):
        total += max(
            a - value * b + sum(v * floor.e[o][u] for floor, v in zip(kept, y, strict=True))
            for u, (a, b) in enumerate(zip(p_row, q_row, strict=True))
        )
    return total <= 0


# All of them


def forgeries(p: Policy) -> Iterator[tuple[str, dict[str, Any]]]:
    """Certificates with a forged claim each, and true ones between them."""
    certificate = write(p)
    stated = certificate["subject"]["declared"]
    for local in (True, False):
        if not compared(p, local):
            continue
        true: dict[str, dict[str, Any]] = {}
        sources = {"policies": attained(p, local, POLICIES, {case: by_steps(case) for case in compared(p, local)})}
        sources |= {"range": forged_ranges(p, local), "floored range": forged_floored_ranges(p, local)}
        if p.releases == 1:
            sources |= {"near": forged_near(p, local), "floored": forged_floored(p, local)}
        for source, claims in sources.items():
            for name, claim, declared in claims:
                changed = {key: value if value is None else str(value) for key, value in declared.items()}
                certificate["subject"]["declared"] = {key: value for key, value in (stated | changed).items() if value is not None}
                certificate["claims"] = [{"assumptions": [], **claim}]
                yield f"{source}: {name}", complete(certificate)
                if name == "true":
                    yield from ((f"{source}: {what}", forged) for what, forged in without_sentences(certificate))
                    true[source] = claim
        certificate["subject"]["declared"] = stated
        for source, other in permutations(true, 2):
            if said_of_more(true[source], true[other]):
                certificate["claims"] = [{"assumptions": [], **true[source], "scope": true[other]["scope"]}]
                yield f"{source}: said of another scope", complete(certificate)
        yield from other_releases(p, local)


def said_of_more(one: dict[str, Any], other: dict[str, Any]) -> bool:
    """Whether a claim has the same form as another one, and what it says is too little for the scope of that."""
    ours, theirs = (INF if claim["value"] == "inf" else Fraction(claim["value"]) for claim in (one, other))
    same = (one["quantity"], one["relation"], {*one["evidence"]}) == (other["quantity"], other["relation"], {*other["evidence"]})
    return same and (ours < theirs or (one["relation"] == "=" and ours > theirs))


def without_sentences(certificate: dict[str, Any]) -> Iterator[tuple[str, dict[str, Any]]]:
    """The same without a sentence, with another number in it, or with one that is not asked for."""
    [claim] = certificate["claims"]
    listed = claim["assumptions"]
    for i, sentence in enumerate(listed):
        claim["assumptions"] = listed[:i] + listed[i + 1 :]
        yield "a sentence dropped", certificate
        claim["assumptions"] = [*listed[:i], sentence.replace(" 1", " 2"), *listed[i + 1 :]]
        if claim["assumptions"] != listed:
            yield "another number in a sentence", certificate
    claim["assumptions"] = [*listed, "one memory sees at most 5 releases of a group, each drawn afresh (declared)"]
    yield "a sentence too many", certificate
    claim["assumptions"] = listed


def other_releases(p: Policy, local: bool) -> Iterator[tuple[str, dict[str, Any]]]:
    """What holds of so many releases, where there are more or fewer of them."""
    value = max(map(by_steps, compared(p, local)))
    at = place(p, next(case for case in compared(p, local) if by_steps(case) == value))
    least = max(pair.least() for pair in ranged(p, local))
    for releases in {1, 2, 3} - {p.releases}:
        other = copy.copy(p)
        other.releases = releases
        certificate = write(other)
        name = "releases lowered" if releases < p.releases else "releases raised"
        if max(map(by_steps, compared(other, local))) != value:
            certificate["claims"] = [statement(local, "=", POLICIES, value, attained=None if value == 1 else at)]
            yield f"policies: {name}", complete(certificate)
        if max(pair.least() for pair in ranged(other, local)) > least:
            certificate["claims"] = [statement(local, "<=", ANY_UTILITY, least)]
            yield f"range: {name}", complete(certificate)


@cache
def deployments(count: int) -> list[Policy]:
    """Random deployments in which some policy is unfair, and of which linear programs are solved soon."""
    found: list[Policy] = []
    for seed in itertools.count():
        p = Policy(tiers.fresh(seed))
        if len(p.must) * p.n <= 18 and len(p.true_a) <= 4 and max(map(by_steps, compared(p, True))) > 1:
            declare(p, seed)
            p.declared["max_drift"] = Fraction(p.pick.randint(0, 9), 10)
            if len(found) == count:
                return found
            if len(found) % 3 == 0 or floors(p):
                found.append(p)
    raise AssertionError


@pytest.mark.parametrize("block", range(BLOCKS))
def test_no_forged_claim_is_accepted(block: int) -> None:
    counts: Counter[str] = Counter()
    for p in deployments(DEPLOYMENTS)[block::BLOCKS]:
        for name, certificate in forgeries(p):
            counts[name] += 1
            assert accepted(certificate) == name.endswith(": true"), (name, certificate["claims"])
    print("\n".join(f"{count:6} {name}" for name, count in sorted(counts.items())))
    forged = sum(count for name, count in counts.items() if not name.endswith(": true"))
    print(f"{forged} forgeries")
    assert forged >= (3000 if tiers.FULL else 200) / BLOCKS
