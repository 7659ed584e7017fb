"""The checker on decisions of unknown group: nothing that is altered passes, and it decides pairs as going through all assignments does."""

from __future__ import annotations

import copy
import hashlib
import json
import os
import random
from collections.abc import Callable
from fractions import Fraction
from resource import RUSAGE_SELF, getrusage
from time import process_time
from typing import Any

import pytest
import tiers
from certificates import outcome, unknown
from unknown_rows import enumerated, random_block

import fairaudit as fa
from fairaudit import checker
from fairaudit.checker.rows import embedded_lines, read_table
from fairaudit.checker.unknown_groups import Block, UnknownGroups, _all_reach, pair_stays, stays
from fairaudit.checker.work import CURRENT_WORK, Work
from fairaudit.theorems.t15 import Block as Written

ALTERED = int(os.environ.get("FAIRAUDIT_UNKNOWN", "200"))

Change = Callable[[dict[str, Any], random.Random], object]


def as_read(block: Written) -> Block:
    """A block as the checker has it."""
    rows = tuple(zip(block.values, block.numbers, strict=True))
    groups = tuple(range(len(block.counts)))
    return Block(None, groups, block.counts, block.sums, rows, 1, tuple(zip(block.least, block.most, strict=True)), block.rest)


def test_the_checker_decides_pairs_as_all_assignments_do() -> None:
    pick = random.Random(tiers.fresh(3))
    for _ in range(60):
        block = random_block(pick, most=9)
        true = enumerated(block)
        for (a, b), greatest in true.pairs.items():
            for limit in (Fraction(1, 2), Fraction(1), Fraction(3, 2), *([greatest] if isinstance(greatest, Fraction) else [])):
                assert pair_stays(as_read(block), a, b, (limit.numerator, limit.denominator)) == (greatest <= limit), (block, a, b, limit)
                if limit < 1:
                    assert pair_stays(as_read(block), a, b, (limit.numerator, limit.denominator), below=True) == (greatest < limit)
        for limit in (Fraction(1), Fraction(3, 2), Fraction(4)):
            assert stays(as_read(block), (limit.numerator, limit.denominator)) == (true.greatest <= limit), block


# Altered certificates


def claims(document: dict[str, Any], relation: str) -> list[dict[str, Any]]:
    return [claim for claim in document["claims"] if claim["by"] == "T15" and claim["relation"] == relation]


def moved(text: str, pick: random.Random) -> str:
    """Another rational near one."""
    value = Fraction(text) if text != "inf" else Fraction(9)
    step = pick.choice([Fraction(1, 10**9), Fraction(1, 7), Fraction(1)])
    other = value + pick.choice([step, -step] if value > step else [step])
    return str(other)


def a_value(document: dict[str, Any], pick: random.Random) -> None:
    claim = pick.choice(claims(document, "<="))
    claim["value"] = moved(claim["value"], pick)


def a_greater_least(document: dict[str, Any], pick: random.Random) -> None:
    claim = pick.choice(claims(document, ">="))
    claim["value"] = str(Fraction(claim["value"]) + pick.choice([Fraction(1, 10**6), Fraction(1, 3)]))


def a_level(document: dict[str, Any], pick: random.Random) -> None:
    proofs = [claim["evidence"]["proof"] for claim in claims(document, ">=") if "levels" in (claim["evidence"]["proof"] or {})]
    ends = pick.choice(proofs)["levels"]
    place = pick.randrange(2)
    ends[place] = str(Fraction(ends[place]) * (1 + (2 * place - 1) * Fraction(1, 10**6)))


def received(document: dict[str, Any], pick: random.Random) -> None:
    rows = pick.choice(claims(document, "<="))["evidence"]["completion"]["received"]
    place = pick.randrange(2)
    rows[place] = str(int(rows[place]) + 1000)


def a_pair(document: dict[str, Any], pick: random.Random) -> None:
    place = pick.choice([c for c in claims(document, "<=") if c["value"] != "1"])["evidence"]["completion"]
    place["higher"], place["lower"] = place["lower"], place["higher"]


def a_smaller_reached(document: dict[str, Any], pick: random.Random) -> None:
    reached = pick.choice(claims(document, ">="))["evidence"]["reached"]
    assert reached is not None
    reached["ratio"] = str(max(Fraction(1), Fraction(reached["ratio"]) - Fraction(1, 10**6)) if reached["ratio"] != "1" else Fraction(1, 2))


def an_assignment(document: dict[str, Any], pick: random.Random) -> None:
    entries = [entry for claim in claims(document, ">=") for entry in claim["evidence"]["reached"]["assigned"] if entry["counts"]]
    counts = pick.choice(pick.choice(entries)["counts"])
    place = pick.randrange(len(counts))
    counts[place] = str(int(counts[place]) + 1000)


def a_verdict(document: dict[str, Any], pick: random.Random) -> None:
    target = pick.choice(document["targets"])
    target["verdict"] = pick.choice([v for v in ("within", "exceeds", "depends", "inconclusive") if v != target["verdict"]])


def judged(document: dict[str, Any], pick: random.Random) -> None:
    pick.choice(document["targets"])["judged"] = pick.choice(
        ["this table", "population at confidence 19/20", "this table, within the declared drift"]
    )


def the_unknown_rows(document: dict[str, Any], pick: random.Random) -> None:
    row = pick.choice([row for row in document["subject"]["table"]["rows"] if "unknown" in row])
    place = pick.randrange(len(row["unknown"]))
    row["unknown"][place] = str(int(row["unknown"][place]) + 1)


def without_the_unknown(document: dict[str, Any], pick: random.Random) -> None:
    table = document["subject"]["table"]
    if pick.random() < 0.5:
        table["rows"] = [row for row in table["rows"] if "unknown" not in row]
    del table["header"]["unknown"]


def the_preparation(document: dict[str, Any], pick: random.Random) -> None:
    entry = document["subject"]["preparation"][-1]
    key = pick.choice(["decisions", "of", "step"])
    if key == "step":
        document["subject"].pop("preparation")
    else:
        entry[key] = str(int(entry[key]) + 1)


def a_claim_less(document: dict[str, Any], pick: random.Random) -> None:
    """Without one of the claims its targets are open."""
    target = pick.choice([t for t in document["targets"] if t["verdict"] in ("within", "depends")])
    document["claims"] = [
        c for c in document["claims"] if (c["quantity"], c["relation"], c["by"]) != (f"{target['quantity']}_ratio", "<=", "T15")
    ]


def tips(document: dict[str, Any], pick: random.Random) -> None:
    own = pick.choice([t["tips"] for t in document["targets"] if "tips" in t])
    key = pick.choice(["rows", "labelled"])
    if key == "rows":
        own["rows"] = str(int(own["rows"]) + 1)
    else:
        own["labelled"] = "exceeds" if own["labelled"] == "within" else "within"


def shares(document: dict[str, Any], pick: random.Random) -> None:
    if "unknown_shares" not in document["subject"] or pick.random() < 0.3:
        document["subject"]["unknown_shares"] = [{"group": ["f"], "least": "0", "most": "1/7"}]
    else:
        document["subject"]["unknown_shares"][0]["most"] = "1/5"


def an_assumption(document: dict[str, Any], pick: random.Random) -> None:
    claim = pick.choice(document["claims"])
    if claim["by"] == "T15":
        claim["assumptions"].append("the unknown are no different from the others")
    else:
        claim["assumptions"] = []


CHANGES: list[Change] = [
    a_value,
    a_greater_least,
    a_level,
    received,
    a_pair,
    a_smaller_reached,
    an_assignment,
    a_verdict,
    judged,
    the_unknown_rows,
    without_the_unknown,
    the_preparation,
    a_claim_less,
    tips,
    shares,
    an_assumption,
]


def redigested(document: dict[str, Any]) -> dict[str, Any]:
    """The same with the digest of its table as it now is, so that a change of the table is not found by that alone."""
    subject, table = document["subject"], document["subject"]["table"]
    table["header"].pop("preparation", None)
    if "preparation" in subject:
        line = checker.json_values.canonical_text(subject["preparation"])
        table["header"]["preparation"] = hashlib.sha256(line).hexdigest()
    lines = [table["header"], *table["rows"]]
    digest = hashlib.sha256(b"".join(checker.json_values.canonical_text(line) for line in lines)).hexdigest()
    table["sha256"] = digest
    for claim in document["claims"]:
        if "table" in claim["evidence"]:
            claim["evidence"]["table"] = digest
    return document


@pytest.mark.parametrize("change", CHANGES, ids=lambda change: change.__name__)
def test_what_is_altered_does_not_pass(change: Change) -> None:
    done = 0
    for seed in range(ALTERED // 10):
        pick = random.Random(tiers.fresh(seed))
        document = json.loads(unknown(pick).text)
        altered = copy.deepcopy(document)
        try:
            change(altered, pick)
        except (IndexError, AssertionError, KeyError, ValueError):
            continue  # there is nothing of the kind in this one
        if altered == document:
            continue
        assert outcome(redigested(altered)) != "true", (change, seed)
        done += 1
    assert tiers.enough(done >= (1 if change is a_level else ALTERED // 40))  # levels prove few of them


def test_a_document_that_asks_for_too_much_is_refused() -> None:
    """Going through all assignments of very many rows is counted before it is done."""
    document = json.loads(unknown(random.Random(tiers.fresh(5))).text)
    rows = [row for row in document["subject"]["table"]["rows"] if "unknown" in row]
    more = 10**6 - int(rows[0]["unknown"][0])
    rows[0]["unknown"][0] = str(10**6)
    entry = document["subject"]["preparation"][-1]
    entry["decisions"], entry["of"] = str(int(entry["decisions"]) + more), str(int(entry["of"]) + more)
    entry["columns"] = {"a": entry["decisions"]}
    claim = claims(document, ">=")[0]
    claim["value"], claim["evidence"] = (
        "2",
        {"proof": {"context": document["subject"]["table"]["header"]["contexts"][rows[0]["context"]]}, "reached": None},
    )
    with pytest.raises(checker.TooMuch, match=r"steps|memory"):
        checker.check(json.dumps(redigested(document)).encode())


def small(yes: int = 1) -> dict[str, Any]:
    """Two groups and two decisions without one, one of each kind."""
    table = {"u": ["y", "n"] * 3, "a": ["f", "f", "m", "m", "?", "?"], "n": [3, 1, 2, 2, 1, 1]}
    made = fa.audit(table, decision="u", group="a", count="n", utility={"y": yes}, unknown=["?"], max_local_ratio="5/4", confidence=None)
    return dict(json.loads(made.certificate.text))


def said(document: dict[str, Any]) -> str:
    """What the checker finds false."""
    report = checker.check(json.dumps(redigested(document)).encode())
    return "; ".join(f"{finding.statement} {finding.detail}" for finding in report.findings if not finding.true)


def test_a_group_has_no_label_that_names_none() -> None:
    document = json.loads(json.dumps(small()).replace('["m"]', '["?"]').replace('"a": "m"', '"a": "?"'))
    assert "has a group with the label" in said(document)


@pytest.mark.parametrize("ratio", ["0", "1/2", "-7"])
def test_no_assignment_has_a_ratio_below_1(ratio: str) -> None:
    document = small(yes=0)
    assert not said(document)
    for claim in claims(document, ">="):
        claim["evidence"]["reached"] = {"ratio": ratio, "assigned": []}
    assert "no ratio is below 1" in said(document)


def test_nothing_is_shown_for_a_ratio_of_at_least_1() -> None:
    """The pair that is named here has a smaller ratio in some assignment, which nobody would look at."""
    document = small()
    for claim in claims(document, ">="):
        own = {"context": []} if claim["quantity"] == "local_ratio" else {}
        assert claim["value"] == "1"
        claim["evidence"]["proof"] = {**own, "higher": ["m"], "lower": ["f"]}
    assert "is null" in said(document)


def test_counts_are_whole_one_by_one() -> None:
    document = small(yes=0)
    for row, weights in zip(document["subject"]["table"]["rows"], (["5/2", "3/2"], ["1/2", "7/2"]), strict=False):
        row["weights"] = weights
    assert "counts are not whole" in said(document)


def test_going_through_assignments_of_long_numbers_is_counted_by_their_length() -> None:
    long = 10**90_000
    block = Block(None, (0, 1), (1, 1), (1, 1), ((long + 1, 300), (long, 300)), 1, ((0, 600), (0, 600)), (0, 600))
    before, token = getrusage(RUSAGE_SELF).ru_maxrss, CURRENT_WORK.set(Work())
    try:
        with pytest.raises(checker.TooMuch):
            _all_reach(block, (2, 1))
        assert getrusage(RUSAGE_SELF).ru_maxrss - before < 500_000  # kilobytes
    finally:
        CURRENT_WORK.reset(token)


def test_a_group_that_is_a_spelling_of_a_label_that_names_none_is_pointed_out() -> None:
    """In each group column; not two such labels, of which neither is a group."""
    table = {"u": ["y", "n"] * 4, "a": ["f", "f", "m", "m", "N/A", "N/A", "?", "n/a"], "b": ["s", "t"] * 2 + ["n/a ", "t", "s", "t"]}
    made = fa.audit(table, decision="u", group=["a", "b"], utility="y", unknown=["?", "n/a", "n/A"], confidence=None)
    found = [{"column": "a", "labels": ["N/A", "n/a"]}, {"column": "b", "labels": ["n/a", "n/a "]}]
    document = json.loads(made.certificate.text)
    assert document["subject"]["spellings"] == found
    assert outcome(document) == "true"
    del document["subject"]["spellings"]
    assert "differ in spelling alone" in outcome(document)


@pytest.mark.parametrize(("lacking", "listed"), [("t", True), ("s", False)])
def test_that_some_may_be_of_groups_that_are_not_compared_is_said(lacking: str, listed: bool) -> None:
    """In t nobody is recorded as m: should the unknown there be m, they get nothing, and no ratio that is claimed is about that."""
    table = {"u": ["y", "n", "y", "n", "y", "n"], "a": ["f", "f", "m", "m", "f", "?"], "x": ["s", "s", "s", "s", "t", lacking]}
    made = fa.audit(table, decision="u", group="a", context="x", utility="y", unknown=["?"], max_local_ratio="3", confidence=None)
    document = json.loads(made.certificate.text)
    assert made.verdict == "within"
    assert outcome(document) == "true"
    found = [claim for relation in ("<=", ">=") for claim in claims(document, relation)]
    for claim in found:
        assert ("though some" in "".join(claim["assumptions"])) == (listed and claim["quantity"] == "local_ratio")
    if listed:
        assert "though some without a recorded group may be of others" in str(fa.report(made))
        found[0]["assumptions"] = []
        assert "lacks the assumption" in outcome(document)


def wide(groups: int, contexts: int) -> list[object]:
    """A table with many groups, three of which are in each context, and unknown decisions in all."""
    table = dict(
        small()["subject"]["table"]["header"], groups=[[str(a)] for a in range(groups)], contexts=[[str(x)] for x in range(contexts)]
    )
    table["columns"] = {**table["columns"], "context": ["x"]}
    cells = [{"context": x, "group": 6 * x + a, "weights": ["3", "1"]} for x in range(contexts) for a in range(3)]
    return [table, *cells, *({"context": x, "unknown": ["2", "2"]} for x in range(contexts))]


def test_many_groups_and_contexts_take_no_time() -> None:
    """Half a megabyte, of which groups times contexts and groups times groups would be tens of millions."""
    facts = UnknownGroups(read_table(embedded_lines(wide(20_000, 2_000))), ())
    started = process_time()
    assert len(facts.local) == 2_000 and all(stays(block, (9, 1)) for block in facts.local.values())
    assert not stays(facts.overall[None], (9, 1))
    assert process_time() - started < 10


def test_comparing_long_means_is_counted_before_it_is_done() -> None:
    long = 10**90_000
    block = Block(None, tuple(range(200)), (4,) * 200, (7,) * 200, ((2, long), (1, long)), 1, ((0, 2 * long),) * 200, (0, 2 * long))
    started, token = process_time(), CURRENT_WORK.set(Work())
    try:
        with pytest.raises(checker.TooMuch):
            stays(block, (3, 1))
    finally:
        CURRENT_WORK.reset(token)
    assert process_time() - started < 2
