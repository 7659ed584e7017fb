"""Claims about every utility of a class, against linear programs that are solved in rationals."""

import copy
import json
import random
import time
from collections.abc import Callable
from fractions import Fraction
from functools import cache
from itertools import permutations
from typing import Any

import pytest
import tiers
from class_certificates import (
    FAMILY,
    SCHEMA,
    TINY,
    Case,
    F,
    Pair,
    Solved,
    Vector,
    by_hand,
    claim_fault,
    entries,
    tampered,
    true_certificate,
)
from plain_certificates import checker, false_statements, make, raw


@cache
def solved_case(seed: int) -> Solved:
    return Solved(Case(seed))


def claims_true(certificate: dict[str, Any]) -> bool:
    """Whether the last claim is true by the checker."""
    findings = [f for f in checker.check(raw(certificate)).findings if f.statement.startswith(f"claims[{len(certificate['claims']) - 1}]")]
    return all(f.true for f in findings)


def multipliers_of(case: Case, pair: Pair) -> list[Fraction]:
    """List the k at which k t + max(0, (gamma - m) H_k - (k - 1) m) can be least."""
    P, Q = (joint(case, pair[0], a) for a in pair[1:])
    breaks = sorted({F(0), F(1), *(p / q for p, q in zip(P, Q, strict=True) if q)})

    def excess(k: Fraction) -> Fraction:
        return (case.gamma - case.m) * sum((max(F(0), p - k * q) for p, q in zip(P, Q, strict=True)), F(0)) - (k - 1) * case.m

    roots = []
    for low, high in zip(breaks, [*breaks[1:], breaks[-1] + 1], strict=True):
        at, further = excess(low), excess(high)
        if at != further:
            root = low + (high - low) * at / (at - further)
            if root >= low:
                roots.append(root)
    return breaks + roots


def joint(case: Case, x: int | None, a: int) -> Vector:
    return case.mean(x, a)  # blind and without a family: the coefficients are the probabilities P(u,x|a) or P(u|x,a)


def closed_bound(case: Case, pair: Pair, k: Fraction) -> Fraction | None:
    P, Q = (joint(case, pair[0], a) for a in pair[1:])
    if P == Q:
        return F(1)
    floor = max(case.tau or F(0), case.m)
    h = sum((max(F(0), p - k * q) for p, q in zip(P, Q, strict=True)), F(0))
    if floor == 0:
        return k if h == 0 else None
    return k + max(F(0), (case.gamma - case.m) * h - (k - 1) * case.m) / floor


BLOCKS = 8 if tiers.FULL else 3
"""All eight of them: FAIRAUDIT_FULL=1 pytest tests/checker/test_worst_case.py"""
PER_BLOCK = 40


@pytest.mark.parametrize("block", range(BLOCKS))
def test_least_values_and_what_is_less(block: int) -> None:
    """The claim at the exact optimum is true; 10^-9 below, no multipliers make it true."""
    tight = finite = 0
    for seed in range(block * PER_BLOCK, (block + 1) * PER_BLOCK):
        s = solved_case(seed)
        certificate = true_certificate(s)
        exists = certificate["metrics"][s.case.quantity] is not None
        wrong = false_statements(certificate)
        if not exists:
            assert len(wrong) == 1 and "does not give this quantity" in wrong[0], seed
            continue
        assert wrong == [], seed
        assert not list(SCHEMA.iter_errors(certificate)), seed
        if s.infinite or s.value == 1:
            continue
        finite += 1
        tight += s.tight
        less = s.value - TINY
        assert any(s.case.least_ratio(pair, less) is None and not s.case.needless(pair, less) for pair in s.worst), seed
        lower = copy.deepcopy(certificate)
        lower["claims"][-1]["value"] = str(less)
        for _ in range(3):
            assert not claims_true(lower), seed
            for entry in lower["claims"][-1]["evidence"]["pairs"]:
                for pair in entry["multipliers"]:
                    pair[1] = str(F(pair[1]) * s.case.pick.choice([1 - TINY, 1 + TINY, F(1, 2), 2, 1]))
    assert tiers.enough(finite >= PER_BLOCK // 4 and tight >= finite // 2)


@pytest.mark.deep  # pays for what tests that are slow share
def test_every_kind_occurs() -> None:
    seen = [solved_case(seed) for seed in range(BLOCKS * PER_BLOCK)]
    settled = [s for s in seen if s.tight]
    tests: list[Callable[[Case], Any]] = [
        lambda c: c.family and c.blind,
        lambda c: c.family and not c.blind and c.quantity == "local" and c.nx > 1,
        lambda c: c.family and c.quantity == "global",
        lambda c: c.L is not None and c.metric,
        lambda c: c.L is not None and c.metric is None,
        lambda c: c.rows and c.quantity == "local" and c.nx > 1,
        lambda c: c.rows and c.quantity == "global",
        lambda c: c.order and c.blind,
        lambda c: c.order and not c.blind and c.tau_on == "pair",
        lambda c: c.tau is not None and c.tau_on == "all" and c.na > 2,
        lambda c: c.m > 0 and c.tau is not None,
    ]
    for i, test in enumerate(tests):
        assert sum(bool(test(s.case)) for s in settled) >= (4 if tiers.FULL else 1), i
    assert tiers.enough(sum(bool(s.infinite) for s in seen) >= (10 if tiers.FULL else 3))


@pytest.mark.parametrize("block", range(4 if tiers.FULL else 2))
def test_closed_form(block: int) -> None:
    """T3 at the least value that multipliers prove; two groups: no greater than the linear program's."""
    count = sharp = 0
    for seed in range(block * 40, block * 40 + 40):
        case = Case(10_000 + seed, "blind")
        if not case.closed_form() or not case.pairs():
            continue
        ks = sorted({k for pair in case.pairs() for k in multipliers_of(case, pair)})
        least = [min((b for k in ks if (b := closed_bound(case, pair, k)) is not None), default=None) for pair in case.pairs()]
        rational = [str(k) for k in ks]
        if None in least:
            assert false_statements(case.certificate(case.own, "inf", "T3", {"multipliers": rational})) == []
            assert not claims_true(case.certificate(case.own, "1000", "T3", {"multipliers": [*rational, "1000"]}))
            count += 1
            continue
        value = max([F(1), *(b for b in least if b is not None)])
        count += 1
        assert false_statements(case.certificate(case.own, str(value), "T3", {"multipliers": rational})) == [], seed
        shuffled = case.pick.sample(rational, len(rational))
        assert claims_true(case.certificate(case.own, str(value + TINY), "T3", {"multipliers": shuffled + shuffled}))
        linear = [case.least_ratio(pair) for pair in case.pairs()]
        best = max(r[0] for r in linear if r is not None)
        assert best <= value
        sharp += best == value
        if value > 1:
            more = [str(k + case.pick.choice([-1, 1]) * TINY) for k in ks if k > TINY]
            assert not claims_true(case.certificate(case.own, str(value - TINY), "T3", {"multipliers": rational + more})), seed
        # Which lists of multipliers do: the checker's search against trying all of them.
        for _ in range(5):
            some = case.pick.sample(ks, min(len(ks), case.pick.randint(0, 3)))
            at = case.pick.choice([value, value + F(1, 2), value * 2])
            each = [any((b := closed_bound(case, pair, k)) is not None and b <= at and k <= at for k in some) for pair in case.pairs()]
            alike = [joint(case, x, a) == joint(case, x, b) for x, a, b in case.pairs()]
            true = all(e or same for e, same in zip(each, alike, strict=True))
            certificate = case.certificate(case.own, str(at), "T3", {"multipliers": [str(k) for k in some]})
            assert claims_true(certificate) == true, (seed, some, at)
            assert not list(SCHEMA.iter_errors(certificate))
    assert tiers.enough(count >= 15 and sharp >= 8)


@pytest.mark.parametrize("block", range(BLOCKS))
def test_tampered_evidence(block: int) -> None:
    """Whatever is done to the evidence, the checker and the dense inequality agree."""
    false = 0
    for seed in range(block * PER_BLOCK, (block + 1) * PER_BLOCK):
        s = solved_case(seed)
        if s.infinite or not s.entries:
            continue
        certificate = s.case.certificate(s.point, str(s.value), "lp-dual", s.case.dual(s.entries, s.point))
        for _ in range(6):
            changed = tampered(s, certificate)
            evidence = changed["claims"][-1]["evidence"]["pairs"]
            given = {(e.get("context"), e["higher"], e["lower"]): e["multipliers"] for e in evidence}
            true = all(
                s.case.proves(pair, s.value, given[pair]) if pair in given else s.case.needless(pair, s.value) for pair in s.case.pairs()
            )
            assert claims_true(changed) == true, (seed, evidence)
            false += not true
    assert false >= PER_BLOCK


def outside(s: Solved) -> list[tuple[str, dict[str, Any]]]:
    """Shrink the class in every way that puts the utility outside, if only just."""
    case, certificate = s.case, true_certificate(s)
    g = {cell: case.gains(s.point, *cell) for cell in case.cells}
    flat = [v for row in g.values() for v in row]
    found: list[tuple[str, dict[str, Any]]] = []

    def change(word: str, **keys: Any) -> None:
        changed = copy.deepcopy(certificate)
        changed["subject"]["class"] |= keys
        found.append((word, changed))

    own = case.described()
    if max(flat) > max(TINY, case.m + TINY, (case.tau or 0) + TINY):
        change("leaves", gamma=str(max(flat) - TINY))
    if min(flat) + TINY <= case.gamma:
        change("leaves", m=str(min(flat) + TINY))
    metric = certificate["metrics"][case.quantity]
    if metric is not None:
        pair = metric["witness"]["expectations"]
        floor = min(map(F, pair)) + TINY
        if floor <= case.gamma:
            change("floor", tau=str(floor), tau_on=case.pick.choice(["pair", "all"]))
    worse = [(u, v) for u in range(case.n) for v in range(case.n) if any(row[u] > row[v] for row in g.values())]
    if worse:
        u, v = case.pick.choice(worse)
        change("order", order=[*own["order"], [f"u{u}", f"u{v}"]])
    cell = case.pick.choice(case.cells)
    u = case.pick.randrange(case.n)
    term = [cell[0], None if case.blind else cell[1], u]
    change("rows", rows=[*own["rows"], {"terms": [[*term, "1"], [*term, "1"]], "bound": str(2 * g[cell][u] - TINY)}])
    spreads = [
        (abs(p - q), a, b) for (x, a), (y, b) in permutations(case.cells, 2) if x == y for p, q in zip(g[x, a], g[y, b], strict=True)
    ]
    if not case.blind and spreads:
        spread, a, b = max(spreads)
        if spread > TINY:
            change("Lipschitz", lipschitz=str(spread - TINY), metric=None)
            near = [[str(F(i != j) * (1 if {i, j} == {a, b} else 2)) for j in range(case.na)] for i in range(case.na)]
            change("Lipschitz", lipschitz=str(spread - TINY), metric=near)
        if spread > 0 and not case.family and not case.rows:
            change("depends on the group", blind=True, lipschitz=None)
    if case.family:
        theta = certificate["claims"][-1]["evidence"]["theta"]
        changed = copy.deepcopy(certificate)
        changed["claims"][-1]["evidence"]["theta"] = [str(F(theta[0]) + TINY), *theta[1:]]
        found.append(("theta", changed))
        changed = copy.deepcopy(certificate)
        changed["subject"]["class"]["family"]["upper"][0] = changed["subject"]["class"]["family"]["lower"][0] = str(F(theta[0]) + TINY)
        found.append(("theta", changed))
        row = {"coefficients": ["1"] + ["0"] * (len(theta) - 1), "bound": str(F(theta[0]) - TINY)}
        changed = copy.deepcopy(certificate)
        changed["subject"]["class"]["family"]["rows"].append(row)
        found.append(("theta", changed))
        changed = copy.deepcopy(certificate)
        changed["claims"].pop()
        found.append(("theta", changed))
    return found


@pytest.mark.parametrize("block", range(BLOCKS))
def test_utilities_outside(block: int) -> None:
    count = 0
    for seed in range(block * PER_BLOCK, (block + 1) * PER_BLOCK):
        for word, changed in outside(solved_case(seed)):
            wrong = [line for line in false_statements(changed) if line.startswith("the utility is in subject.class")]
            floor_first = word == "theta" and wrong and "theta" not in wrong[0]
            assert len(wrong) == 1 and (word in wrong[0] or floor_first), (seed, word, wrong)
            count += 1
    assert tiers.enough(count >= 3 * PER_BLOCK)


DUAL = entries((0, 0, 1, []), (0, 1, 0, []))  # P - 3 Q = (0, -2) and (-2, 0): nothing but the box is needed


def test_by_hand() -> None:
    assert false_statements(by_hand()) == []
    assert false_statements(by_hand(by="lp-dual", evidence=DUAL)) == []
    assert claim_fault(by_hand("2999999999/1000000000"))  # the utility attains 3
    assert claim_fault(by_hand("2999999999/1000000000", by="lp-dual", evidence=DUAL))
    statement = checker.check(raw(by_hand())).findings
    assert any("local ratio, 0 <= g <= 1, floor 1/4 for all groups compared, the same for all groups" in f.statement for f in statement)


def test_missing_and_superfluous_pairs() -> None:
    assert "lacks context 0, groups 0 and 1" in claim_fault(by_hand(by="lp-dual", evidence=entries((0, 1, 0, []))))
    assert "lacks context 0, groups 1 and 0" in claim_fault(by_hand(by="lp-dual", evidence=entries((0, 0, 1, []))))
    more = entries((0, 0, 1, []), (0, 1, 0, []), (1, 0, 1, []), (1, 1, 0, []))
    assert not claim_fault(by_hand(by="lp-dual", evidence=more))
    for pair in [(1, 0, 0), (1, 0, 2), (2, 0, 1)]:
        evidence = entries((0, 0, 1, []), (0, 1, 0, []), (*pair, []))
        assert "not compared" in claim_fault(by_hand(by="lp-dual", evidence=evidence))

    def equal(blind: bool) -> dict[str, Any]:
        document = make({(0, 0): ["1", "1"], (0, 1): ["1", "1"]}, ["1", "0"])
        document["subject"]["class"] = by_hand(blind=blind)["subject"]["class"]
        document["claims"].append(by_hand(by="lp-dual", evidence={"pairs": []})["claims"][-1])
        return document

    assert not claim_fault(equal(True))
    assert "lacks context 0" in claim_fault(equal(False))  # equal rows do not help when g depends on the group


def test_floors_make_pairs_needless() -> None:
    assert not claim_fault(by_hand("4", by="lp-dual", evidence={"pairs": []}))  # gamma/tau = 4
    assert not claim_fault(by_hand("4", by="lp-dual", evidence={"pairs": []}, tau_on="pair"))
    assert claim_fault(by_hand("3999/1000", by="lp-dual", evidence={"pairs": []}))
    assert claim_fault(by_hand("4", by="lp-dual", evidence={"pairs": []}, tau=None))
    assert claim_fault(by_hand("1000000", by="lp-dual", evidence={"pairs": []}, tau="0"))
    assert claim_fault(by_hand("4", by="lp-dual", evidence={"pairs": []}, tau="1/5"))
    bad = entries((0, 0, 1, [[0, "1000"]]))
    assert "more than 0" in claim_fault(by_hand("4", by="lp-dual", evidence=bad))  # an entry that is there has to be right


def test_infinity() -> None:
    assert not claim_fault(by_hand("inf", by="lp-dual", evidence={"pairs": []}, tau=None))
    assert not claim_fault(by_hand("inf", evidence={"multipliers": []}, tau=None))
    certain = by_hand("inf", by="lp-dual", evidence={"pairs": []}, tau=None)
    certain["claims"][-1]["relation"] = "="
    assert "unknown claim" in claim_fault(certain)


@pytest.mark.parametrize(
    ("keys", "words"),
    [
        ({"blind": False}, "blind classes"),
        ({"tau_on": "pair"}, "all groups keep the floor"),
        ({"order": [["u1", "u0"]]}, "without further constraints"),
        ({"rows": [{"terms": [], "bound": "0"}]}, "without further constraints"),
        ({"quantity": "global"}, "the class is about the global ratio"),
    ],
)
def test_t3_has_conditions(keys: dict[str, Any], words: str) -> None:
    assert words in claim_fault(by_hand(**keys))
    assert words in claim_fault(by_hand("inf", **keys))
    assert not claim_fault(by_hand(tau=None, tau_on="pair"))


def test_values_contradict() -> None:
    assert "greater quantity" in claim_fault(by_hand("5/2", tau="1/3", evidence={"multipliers": ["5/2", "0", "1"]}))
    assert "less than 1" in claim_fault(by_hand("1/2"))
    assert "less than 1" in claim_fault(by_hand("-3"))
    constant = make({(0, 0): ["1", "1"], (0, 1): ["1", "1"]}, ["0", "0"])  # 0/0 everywhere
    constant["subject"]["class"] = by_hand()["subject"]["class"] | {"tau": None}
    claim = by_hand()["claims"][-1] | {"by": "lp-dual", "evidence": {"pairs": []}}
    for value, true in [("0", False), ("999999/1000000", False), ("1", True)]:
        constant["claims"] = [claim | {"value": value}]
        assert (false_statements(constant) == []) == true


def test_other_claims() -> None:
    twice = by_hand()
    twice["claims"].append(copy.deepcopy(twice["claims"][-1]))
    assert "occurs twice" in claim_fault(twice)
    both = by_hand()
    both["claims"].append(by_hand(by="lp-dual", evidence=DUAL)["claims"][-1])
    assert false_statements(both) == [] and not list(SCHEMA.iter_errors(both))
    classless = by_hand()
    del classless["subject"]["class"]
    assert "unknown claim" in claim_fault(classless)
    assert list(SCHEMA.iter_errors(classless))
    for change in ({"scope": "this law"}, {"scope": "any policy behind this filter"}, {"by": "T4"}, {"quantity": "equalized_odds"}):
        other = by_hand()
        other["claims"][-1] |= change
        assert "unknown claim" in claim_fault(other)
        assert list(SCHEMA.iter_errors(other))
    without = by_hand()
    without["claims"].pop()
    assert false_statements(without) == []


def test_null_quantity() -> None:
    lonely = make({(0, 0): ["1", "1"], (1, 1): ["1", "1"]}, ["1", "0"])
    lonely["subject"]["class"] = by_hand()["subject"]["class"]
    assert false_statements(lonely) == []
    lonely["claims"].append(by_hand("inf")["claims"][-1])
    assert "does not give this quantity" in claim_fault(lonely)


def test_only_given_entries() -> None:
    document = make({(0, 0): ["1", "0"], (0, 1): ["1", "0"]}, {(0, 0): ["1", None], (0, 1): ["1", "0"]})
    document["subject"]["class"] = by_hand()["subject"]["class"]
    assert "not given everywhere" in false_statements(document)[0]


def test_family_by_hand() -> None:
    evidence = entries((0, 0, 1, []), (0, 1, 0, [[3, "1"]])) | {"theta": ["1"]}
    # In theta: E = 3/4, E' = 1/4. The value 3 suffices for the one pair, 1 for the other; the evidence for it does no harm or does.
    document = by_hand(by="lp-dual", evidence=evidence, family=FAMILY)
    assert "groups 1 and 0" in claim_fault(document)
    document["claims"][-1]["evidence"]["pairs"][1]["multipliers"] = []
    assert false_statements(document) == []
    assert not list(SCHEMA.iter_errors(document))


def test_speed_of_t3() -> None:
    pick = random.Random(tiers.fresh(5))
    weights = {(x, a): [str(pick.randint(1, 99)) for _ in range(20)] for x in range(100) for a in range(30)}
    columns = {"decision": "D", "group": ["G"], "context": ["C"]}
    decisions, groups, contexts = [f"u{u}" for u in range(20)], [[f"a{a}"] for a in range(30)], [[f"x{x}"] for x in range(100)]
    head = {"format": "fairaudit-table/1", "kind": "counts", "columns": columns, "population": "counts", "decisions": decisions}
    head |= {"groups": groups, "contexts": contexts, "utility": ["1"] * 20}
    rows = [{"context": x, "group": a, "weights": w} for (x, a), w in weights.items()]
    table = checker.rows.read_table((f"line {i}", value, None) for i, value in enumerate([head, *rows]))
    members = by_hand(tau="1/10")["subject"]["class"]
    program = checker.program.Program(checker.utility_class.read_class(members, "class"), table)
    laws = [[cell.law for cell in cells] for cells in table.by_context()]
    ks = sorted({F(p[0][u] * q[1], p[1] * q[0][u]) for law in laws[:40] for p, q in permutations(law[:9], 2) for u in range(20)})
    ks = pick.sample(ks, 30_000)
    start = time.perf_counter()
    assert checker.worst_case._fault_of_closed_form((15, 2), ks, program) == ""
    fault = checker.worst_case._fault_of_closed_form((2, 1), ks, program)
    assert "no multiplier proves" in fault
    assert time.perf_counter() - start < 30


def test_speed_of_lp_dual() -> None:
    pick = random.Random(tiers.fresh(6))
    weights = {(0, a): [str(pick.randint(1, 9)) for _ in range(50)] for a in range(20)}
    rows: dict[str, Any] = {
        "quantity": "local",
        "gamma": "1",
        "m": "1/2",
        "tau": "3/5",
        "order": [[f"u{u}", f"u{u + 1}"] for u in range(49)],
    }
    document = make(weights, ["1"] * 50)
    document["subject"]["class"] = by_hand(**rows)["subject"]["class"]
    multipliers = [[i, "1/1000"] for i in range(0, 69, 2)]
    evidence = entries(*((0, a, b, multipliers) for a, b in permutations(range(20), 2)))
    document["claims"].append(by_hand("8", by="lp-dual", evidence=evidence)["claims"][-1])
    data = json.dumps(document).encode()
    start = time.perf_counter()
    findings = checker.check(data).findings
    assert time.perf_counter() - start < 5
    assert all(f.true for f in findings)
