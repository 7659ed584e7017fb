"""The checker on joint bets of streams: what it accepts holds by a second reading in decimals, and altered evidence is refused."""

from __future__ import annotations

import copy
import json
import random
from decimal import Context, Decimal, localcontext
from fractions import Fraction
from functools import cache
from itertools import pairwise, permutations
from typing import Any

import jsonschema
import pytest
import tiers

from fairaudit import checker
from fairaudit.audits.certify import certify
from fairaudit.certificates.certificate import schema
from fairaudit.checker import interval_proofs, intervals
from fairaudit.checker.joint_betting import prove_stream
from fairaudit.inference.anytime import Arrivals
from fairaudit.model.law import Law
from fairaudit.model.utility import Utility

F = Fraction
ROWS = {"f": (20, 5, 75), "m": (60, 10, 30), "n": (40, 0, 30)}
VALUES = (F(1, 5), F(3, 5), F(1))
RANKS = [2, 1, 3]


@cache
def made(low: str) -> str:
    table: dict[str, list[Any]] = {"u": [], "a": [], "n": []}
    for group, counts in ROWS.items():
        for decision, n in zip(("no", "half", "yes"), counts, strict=True):
            for name, entry in (("u", decision), ("a", group), ("n", n)):
                table[name].append(entry)
    law = Law.from_counts(table, decision="u", group="a", count="n")
    order = tuple(((), (group,)) for group in "mfn")
    utility = Utility({"no": "1/5", "half": "3/5", "yes": "1"})
    arrivals = Arrivals(order, 3, True, (F(1), F(5, 4)))
    return certify(law, utility, declared={"m": low, "gamma": 1}, arrivals=arrivals, confidence="0.9").certificate.text


def accepted(document: Any) -> bool:
    try:
        return all(
            finding.true for finding in checker.check(json.dumps(document).encode()).findings if "intervals.local" in finding.statement
        )
    except checker.FormatError:
        return False


def decimal(value: Fraction) -> Decimal:
    return Decimal(value.numerator) / Decimal(value.denominator)


def bets(ratios: list[Fraction]) -> list[tuple[Fraction, Fraction, Fraction]]:
    found = [(F(1, 2**k), min(F(15, 16), r * F(1, 2**k)), F(4, 35 * len(ratios))) for r in ratios for k in range(1, 8)]
    return [*found, (F(1, 4), F(0), F(1, 20)), (F(1, 2), F(0), F(1, 20)), (F(0), F(1, 4), F(1, 20)), (F(0), F(1, 2), F(1, 20))]


def holds(interval: Any) -> bool:
    """The rules of docs/certificate-monitor.md, in decimals of 60 digits."""
    levels, limits = interval["levels"], [F(limit) for limit in interval["limits"]]
    made_ = bets([F(ratio) for ratio in levels["ratios"]])
    error, later = 1 - F(interval["confidence"]), sorted(levels["order"])[1:]
    expected = -(-levels["expected"] // 2)
    cells = list(ROWS.values())

    def won(i: int, j: int, ratio: Fraction, q: Fraction) -> list[Decimal]:
        found = []
        for one, other, share in made_:
            total = decimal(share)
            for value, n, m in zip(VALUES, cells[i], cells[j], strict=True):
                total *= decimal(1 - one * (value - ratio * q) / limits[1]) ** n * decimal(1 + other * (value - q) / limits[1]) ** m
            found.append(total)
        return found

    def ladder(knots: list[Fraction], pairs: Any, ratio: Fraction) -> bool:
        points = [limits[0], *knots, min(limits[1], limits[1] / ratio)]
        if any(p >= q for p, q in pairwise(points)):
            return False
        for i, j in pairs:
            last = max(levels["order"][i], levels["order"][j])
            at = later.index(last) + 1
            level = error * F(expected, (at + expected - 1) * (at + expected)) / (2 * at)
            if any(sum(map(min, won(i, j, ratio, p), won(i, j, ratio, q))) < 1 / decimal(level) for p, q in pairwise(points)):
                return False
        return True

    low, high = (F(end) if end != "inf" else None for end in interval["ratio"])
    upper, lower = interval["upper"], interval["lower"]
    if low is None or low < 1 or (high is None) != (upper is None) or (low == 1) != (lower is None):
        return False
    if high is not None and not (high >= 1 and len(upper) == 1 and ladder([F(k) for k in upper[0]], permutations(range(3), 2), high)):
        return False
    if lower is None:
        return True
    _, higher, under = lower["pair"]
    return higher != under and ladder([F(k) for k in lower["knots"]], [(under, higher)], 1 / low)


@pytest.mark.parametrize("low", ["0", "1/10"])
def test_certificates_with_joint_bets_are_true_and_fit_the_schema(low: str) -> None:
    document = json.loads(made(low))
    assert accepted(document) and all(finding.true for finding in checker.check(made(low).encode()).findings)
    jsonschema.Draft202012Validator(schema()).validate(document)
    for name in ("local", "global"):
        interval = document["intervals"][name]
        assert interval["region"] == "joint" and F(interval["ratio"][0]) > 1 and interval["ratio"][1] != "inf"
        assert interval["levels"] == {"expected": 3, "order": RANKS, "ratios": ["1", "5/4"]} and holds(interval)


def altered(interval: dict[str, Any], rng: random.Random) -> None:
    """One change that claims more, or takes away what proves it."""
    knots = rng.choice([interval["upper"][0], interval["lower"]["knots"]])
    at = rng.randrange(len(knots))
    kind = rng.randrange(10)
    ends, levels = interval["ratio"], interval["levels"]
    if kind == 0:
        ends[1] = str(F(ends[1]) * (1 - F(rng.randrange(1, 300), 1000)))
    elif kind == 1:
        ends[0] = str(F(ends[0]) * (1 + F(rng.randrange(1, 300), 1000)))
    elif kind == 2:
        interval["confidence"] = str(1 - (1 - F(interval["confidence"])) / rng.randrange(2, 50))
    elif kind == 3:
        knots[at] = str(F(knots[at]) * F(rng.randrange(700, 1400), 1000))
    elif kind == 4 and len(knots) > 1:
        del knots[at]
    elif kind == 5:
        levels["ratios"] = [str(F(rng.randrange(1, 400), 100)) for _ in range(rng.randrange(1, 9))]
    elif kind == 6:
        levels["expected"] = rng.randrange(1, 10_000)
    elif kind == 7:
        rng.shuffle(levels["order"])
    elif kind == 8:
        interval["lower"]["pair"] = [0, rng.randrange(3), rng.randrange(3)]
    else:
        interval["limits"] = rng.choice([["0", "9/10"], ["1/10", "3/5"], ["1", "1"], ["1/2", "1/4"]])


@cache
def checked(low: str) -> tuple[Any, Any]:
    """The subject and the table that the checker proves the interval of."""
    seen = []

    def watch(interval: Any, evidence: Any, table: Any) -> None:
        seen.append(table)
        prove_stream(interval, evidence, table)

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(interval_proofs, "prove_stream", watch)
        checker.check(made(low).encode())
    return seen[0].header.subject, seen[0]


def proves(interval: Any, low: str) -> bool:
    subject, table = checked(low)
    try:
        read = intervals._read_interval(interval, "intervals.local", "local", subject)
        assert isinstance(read.evidence, intervals.StreamEvidence)
        prove_stream(read, read.evidence, table)
    except (intervals.Unproven, checker.FormatError):
        return False
    return True


def test_what_is_accepted_holds_and_altered_evidence_is_refused() -> None:
    rng, refused, wanted = random.Random(tiers.fresh(3)), 0, 2_000 if tiers.FULL else 100
    while refused < wanted:
        low = rng.choice(["0", "1/10"])
        before = json.loads(made(low))["intervals"]["local"]
        interval = copy.deepcopy(before)
        altered(interval, rng)
        found = proves(interval, low)
        refused += not found
        if found or refused % 20 == 0:
            with localcontext(Context(prec=60)):
                assert holds(interval) == found, interval


def test_evidence_of_other_shapes_is_refused() -> None:
    def change(alter: Any) -> bool:
        document = json.loads(made("0"))
        alter(document["intervals"]["local"])
        return accepted(document)

    assert not change(lambda i: i["levels"].pop("ratios"))
    assert not change(lambda i: i["levels"].update(ratios=[]))
    assert not change(lambda i: i["levels"].update(ratios=["0", "1"]))
    assert not change(lambda i: i["levels"].update(ratios=["1"] * 9))
    assert not change(lambda i: i.update(region="product"))
    assert not change(lambda i: (i.update(region="product"), i["levels"].pop("ratios")))
    assert not change(lambda i: i.update(upper=None))
    assert not change(lambda i: i.update(lower=None))
    assert not change(lambda i: i["upper"].append(i["upper"][0]))
    assert not change(lambda i: i["upper"][0].reverse())
    assert not change(lambda i: i["upper"][0].append("9/10"))
    assert not change(lambda i: i.update(independent=True))


def test_long_ratios_are_paid_for() -> None:
    document = json.loads(made("0"))
    interval = document["intervals"]["local"]
    long = 10**4_000
    interval["levels"]["ratios"] = [f"{long + 1}/{3 * long + 2}"]
    interval["ratio"] = ["1", "10"]
    interval["lower"] = None
    interval["upper"] = [[str(F(i, 20_010)) for i in range(1, 2_001)]]
    with pytest.raises(checker.TooMuch):
        checker.check(json.dumps(document).encode())
