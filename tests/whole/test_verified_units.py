"""Intervals by bets on contrasts within units: the verified program says what the Python checker says, of true and altered certificates.

More of them: FAIRAUDIT_EXAMPLES=500 pytest -s tests/whole/test_verified_units.py
"""

from __future__ import annotations

import json
import os
import random
from collections.abc import Iterator
from fractions import Fraction
from hashlib import sha256
from pathlib import Path
from random import Random as Pick
from typing import Any

import pytest
from certificate_changes import redigested
from certificate_kinds import as_bytes
from paired_certificates import alterations, certified, honest, line, logs, named
from verified_roads import FALSE, MALFORMED, TRUE, Tally, altered, in_script, natively

import fairaudit as fa

DOCUMENTS = max(2, int(os.environ.get("FAIRAUDIT_EXAMPLES", "50")) // 10)
"""Of which each is altered some fifty times."""


def units(rows: list[tuple[str, str, str]], utility: Any, **options: Any) -> dict[str, Any]:
    """A certificate of decisions, groups and units."""
    decisions, groups, owners = map(list, zip(*rows, strict=True))
    law = fa.Law.from_log({"u": decisions, "a": groups, "i": owners}, decision="u", group="a", unit="i")
    document: dict[str, Any] = json.loads(fa.certify(law, utility, **options).certificate.text)
    assert document["intervals"]["local"]["region"] == "paired"
    return document


def covered() -> list[dict[str, Any]]:
    """Certificates of which all is covered: one row for each unit and group, several, a declared range, scores, units that miss a group."""
    told = random.Random(4)
    plain = [("yes" if told.random() < (0.8 if a == "f" else 0.5) else "no", a, str(i)) for i in range(80) for a in "fm"]
    twice = [("yes" if told.random() < 0.7 else "no", a, str(i)) for i in range(60) for a in "fmn" for _ in range(1 + i % 3)]
    scores = [(str(told.randint(40, 45 + 5 * (a == "f"))), a, str(i)) for i in range(90) for a in "fm"]
    worth = {score: int(score) for score, _, _ in scores}
    some = [row for row in plain if not (row[1] == "m" and row[2] in {"3", "4"})]
    found = [units(plain, {"yes": 1}), units(plain, {"yes": 1}, confidence="99/100", independent=False), units(twice, {"yes": "7/3"})]
    found += [units(scores, worth), units(scores, worth, declared={"gamma": 100, "m": 0}), units(some, {"yes": 1})]
    found += [units(some, {"yes": 1}, missing_units="drop"), units(twice, {"yes": 1}, confidence="1/2")]
    found += [units(rows, {"yes": 1}, max_local_ratio="5/4", max_local_log="2") for rows in (plain, twice)]
    for seed in range(6):
        missing = random.Random(seed).choice(["worst", "drop"])
        rows = logs(random.Random(seed), units=20 + seed, lost=0.0)
        found.append(json.loads(certified(rows, missing_units=missing).certificate.text))
    return found


def test_true_certificates_are_judged(program: Path) -> None:
    """Of the interval and of all claims about it, T14 included, nothing is left open; a global one beside it may be."""
    given = [as_bytes(document) for document in covered()]
    judged = natively(program, given)
    assert judged == in_script(given)
    open_ = {label for found in judged for label, true in found.statements if true is not True}
    assert all("hoeffding-kl" in label or label == "intervals.global" for label in open_)  # of scores pooled over units
    assert sum(found.code == TRUE for found in judged) >= len(given) - 2
    labels = [label for found in judged for label, _ in found.statements]
    assert sum('by "paired-betting"' in label for label in labels) == 2 * len(given) == 2 * labels.count("intervals.local")


def changed(document: dict[str, Any], pick: Pick) -> Iterator[bytes]:
    """Altered evidence, with digests in line or not, ends of claims with those of the interval, and anything."""
    for _, made in alterations(document, pick):
        yield as_bytes(made)
        try:
            yield redigested(made)
        except KeyError:
            continue
    for _ in range(15):
        yield altered(pick, as_bytes(document))


def test_altered_certificates_get_the_same_verdict(program: Path) -> None:
    source, tally = random.Random(11), Tally()
    for seed in range(DOCUMENTS):
        document = honest(source)
        tally.judge(program, [as_bytes(document), *changed(document, Pick(seed))])
    for seed, document in enumerate(covered()[:: 1 if DOCUMENTS > 20 else 4]):
        tally.judge(program, [*changed(document, Pick(f"covered {seed}"))])
    print(dict(tally.codes), dict(tally.open.most_common()))
    assert tally.different[:3] == []
    assert {python for python, _ in tally.codes} >= {TRUE, FALSE, MALFORMED}


@pytest.mark.parametrize(("what", "other"), [("ratio", "9/10"), ("expectations", "1/7"), ("estimand", "mean over rows")])
def test_what_was_measured_over_units_has_to_be_so(what: str, other: str, program: Path) -> None:
    document = covered()[2]
    local = document["intervals"]["local"]
    if what == "ratio":
        local["measured"]["ratio"] = other
    elif what == "expectations":
        local["measured"]["witness"]["expectations"][0] = other
    else:
        local["estimand"] = other
    tally = Tally()
    tally.judge(program, [as_bytes(document)])
    assert tally.different == []
    [judged] = natively(program, [as_bytes(document)])
    assert dict(judged.statements)["intervals.local"] is (None if what == "estimand" else False)


def test_the_last_digit_of_an_end_decides(program: Path) -> None:
    """Both programs round alike: the least end that one accepts is the least that the other does."""
    for document in covered()[:4]:
        made, ends = [], []
        text = json.dumps(document)
        high = Fraction(document["intervals"]["local"]["ratio"][1])
        for k in range(-40, 41):
            other = json.loads(text)
            end = str(high + Fraction(k, 4 * 10**6))
            other["intervals"]["local"]["ratio"][1] = end
            for claim in other["claims"]:
                if claim["by"] == "paired-betting" and claim["relation"] == "<=":
                    claim["value"] = end
            made.append(as_bytes(other))
            ends.append(end)
        tally = Tally()
        tally.judge(program, made)
        assert tally.different == []
        judged = [dict(found.statements)["intervals.local"] for found in natively(program, made)]
        assert judged == sorted(judged, key=bool) and {*judged} == {True, False}


def many_contexts(contexts: int, people: int, values: int) -> bytes:
    """A table of so many contexts, each with units that were seen in two groups."""
    told = random.Random(8)
    rows: list[tuple[str, str, str, str]] = []
    for x in range(contexts):
        for i in range(people):
            rows += [(str(told.randrange(values)), a, f"x{x}", f"{x}-{i}") for a in "fm"]
    decisions, groups, places, owners = map(list, zip(*rows, strict=True))
    data = {"u": decisions, "a": groups, "x": places, "i": owners}
    law = fa.Law.from_log(data, decision="u", group="a", context="x", unit="i")
    return fa.certify(law, {str(v): v for v in range(values)}).certificate.text.encode()


def test_many_contexts_take_seconds(program: Path) -> None:
    document = many_contexts(64, 3000, 2)
    [judged] = natively(program, [document])
    [of_script] = in_script([document])
    assert judged == of_script and dict(judged.statements)["intervals.local"] is True


def test_profiles_have_to_be_those_that_the_header_names(program: Path) -> None:
    document = covered()[0]
    profiles = document["intervals"]["local"]["profiles"]
    profiles[0].reverse()
    [other] = natively(program, [as_bytes(document)])
    assert dict(other.statements)["intervals.local"] is False
    document["subject"]["table"]["header"]["profiles"]["local"] = sha256(line(profiles)).hexdigest()
    named(document)
    [again] = natively(program, [as_bytes(document)])
    assert again.code == TRUE
