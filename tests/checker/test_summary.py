"""The paragraph that `verify` says first: of documents of every kind, with numbers rounded outwards."""

from __future__ import annotations

import json
import random
import re
from collections.abc import Iterator
from decimal import ROUND_CEILING, ROUND_FLOOR, ROUND_HALF_EVEN, Context, Decimal
from typing import Any

import pytest
import tiers
from certificate_kinds import KINDS as TABLES
from certificates import KINDS, random_certificate
from proxy_certificates import every_kind
from subgroup_oracle import random_case, worst

from fairaudit import checker
from fairaudit.audits.subgroups import subgroups
from fairaudit.checker.summary import COUNTS, finding_line, lines, paragraph, percent, rounded, said_of_target
from fairaudit.checker.text import Finding, Outline, Report

SPELT = {word: n for n, word in enumerate(COUNTS)}


def subgroup_documents() -> Iterator[dict[str, Any]]:
    rng, given = random.Random(tiers.fresh(5)), 0
    while given < 6:
        case = random_case(rng)
        if worst(case):
            given += 1
            yield subgroups(
                case.columns,
                decision="got",
                attributes=case.attributes,
                utility=case.worth,
                depth=case.depth,
                min_rows=case.least,
                top=case.keep,
                **({"confidence": None, "max_ratio": 2} if given % 2 else {"max_ratio": 3}),
            ).certificate.document


def documents() -> Iterator[tuple[dict[str, Any], list[bytes] | None]]:
    """Documents of all formats and kinds, with the lines of a table that stands beside."""
    for kind in TABLES:
        yield kind().certificate.document, None
    for seed in range(4 * len(KINDS)):
        made = random_certificate(seed)
        yield json.loads(made.text), None if made.table is None else list(made.table.lines())
    for audit in every_kind():
        yield audit.certificate.document, None
    for document in subgroup_documents():
        yield document, None


def listed(document: dict[str, Any]) -> list[str]:
    """Every assumption of a document, each once."""
    changed = document.get("changed", {}).get("assumptions", [])
    of_claims = [text for claim in document.get("claims", []) for text in claim["assumptions"]]
    return list(dict.fromkeys([*document.get("assumptions", []), *of_claims, *changed]))


def test_every_kind_of_document_in_one_paragraph() -> None:
    """How many statements, where the table is, each target with its verdict, each assumption once with its number."""
    words = {"within": " is kept in ", "exceeds": " is exceeded in ", "inconclusive": " is not decided in ", "depends": " depends on "}
    seen: set[str] = set()
    for document, table in documents():
        report = checker.check(json.dumps(document).encode(), table)
        assert report.ok
        said, assumed = paragraph(report), listed(document)
        assert said.startswith(f"All {len(report.findings):,} statements are true of the table, which ")
        assert ("the certificate holds" if table is None else "is in the file that was given") in said.partition(".")[0]
        targets = re.findall("The target that .*?( is kept in | is exceeded in | is not decided in | depends on )", said)
        assert targets == [words[target["verdict"]] for target in document["targets"]]
        assert ("No target was set." in said) == (not document["targets"])
        assert [number for number in range(1, 40) if f"({number}) " in said] == list(range(1, len(assumed) + 1))
        assert ("rests on no assumptions" in said) == (not assumed)
        verbose = list(lines(report, verbose=True))
        shown = verbose[verbose.index("Assumptions, word by word") + 1 :][: len(assumed)] if assumed else []
        assert [line.split(". ", 1)[1] for line in shown] == assumed
        rests = [line for line in verbose if line.startswith("true   claims[")]
        for line, claim in zip(rests, document.get("claims", []), strict="claims" in document):
            numbers = sorted(assumed.index(text) + 1 for text in claim["assumptions"])
            assert (" (rests on " in line) == bool(numbers)
            if numbers:
                ends = line.rpartition(" (rests on ")[2].rstrip(")").replace(",", " ").replace("and", " ").replace("to", " ").split()
                assert {numbers[0], numbers[-1]} <= set(map(int, ends)) <= set(numbers)
        seen |= {target["verdict"] for target in document["targets"]} | {document["format"]}
    assert tiers.enough(seen >= {*words, "fairaudit-certificate/1", "fairaudit-proxies/1", "fairaudit-subgroups/1"})


def test_figures_are_those_of_the_claims() -> None:
    """For a population: the ends that the certificate claims, rounded outwards by decimal arithmetic."""
    counted = 0
    for seed in range(2, 4 * len(KINDS), len(KINDS)):
        document = json.loads(random_certificate(seed).text)
        said = paragraph(checker.check(json.dumps(document).encode()))
        for claim in document["claims"]:
            if claim["scope"].startswith("population") and claim["quantity"] in ("local_ratio", "global_ratio") and claim["value"] != "inf":
                counted += 1
                assert of_decimals(claim["value"], {">=": ROUND_FLOOR, "<=": ROUND_CEILING}[claim["relation"]]) in said
    assert counted > 8


def of_decimals(text: str, rounding: str, digits: int = 4) -> str:
    n, _, d = text.partition("/")
    context = Context(prec=digits, rounding=rounding, Emin=-9999, Emax=9999)
    found = context.divide(Decimal(n), Decimal(d or "1"))
    return format(found, "f") if -5 < found.adjusted() < 16 else format(found, f".{digits - 1}e")


@pytest.mark.parametrize(("towards", "rounding"), [("nearest", ROUND_HALF_EVEN), ("down", ROUND_FLOOR), ("up", ROUND_CEILING)])
def test_rounding_is_that_of_decimals(towards: str, rounding: str) -> None:
    rng = random.Random(tiers.fresh(towards))
    for _ in range(3000):
        n = rng.choice([1, -1]) * rng.randrange(1, 10 ** rng.choice([1, 2, 5, 20, 400]))
        d = rng.randrange(1, 10 ** rng.choice([1, 2, 5, 20, 400]))
        digits = rng.choice([1, 4, 6])
        found = rounded((n, d), towards, digits)
        context = Context(prec=digits, rounding=rounding, Emin=-9999, Emax=9999)
        assert Decimal(found) == context.divide(Decimal(n), Decimal(d))
    for value, said in (((9999_5, 10), "1.000e+04"), ((0, 1), "0"), ((7, 1), "7"), ((1, 0), "infinite")):
        assert rounded(value) in (said, "1e+04", "1e4", "10000", "9999", "1.000e+4", said)


def test_long_numbers_are_rounded_quickly() -> None:
    assert rounded((10**99_999 + 1, 3), "up") == "3.334e+99998"
    assert rounded((1, 10**99_999), "down") == "1e-99999"


def test_percentages() -> None:
    assert [percent(text) for text in ("19/20", "999/1000", "2/3", "1", "x", "1/0")] == ["95 %", "99.9 %", "66.6666 %", "100 %", "x", "1/0"]


@pytest.mark.parametrize(
    ("judged", "verdict", "said"),
    [
        ("this table", "within", "is at most 5/4 (1.25) is kept in the table."),
        (
            "population at confidence 19/20",
            "inconclusive",
            "is not decided in the population at confidence 95 %, as the decisions are too few.",
        ),
        ("this table, whoever the unknown are", "depends", "depends on who the unknown are."),
        ("this table, within the declared drift", "exceeds", "is exceeded in the table, within the declared drift."),
        (
            "population at confidence 19/20",
            "changed",
            "is not judged in the population at confidence 95 %, as the ratio changed over time.",
        ),
    ],
)
def test_targets(judged: str, verdict: str, said: str) -> None:
    assert said_of_target("the worst ratio", "ratio", (5, 4), judged, verdict).endswith(said)


def test_what_is_false_is_said_first_and_nothing_else_is_believed() -> None:
    findings = (Finding("a is 1", True, ""), Finding("b is 2", False, "the table gives 3"), Finding("c is 4", False, ""))
    report = Report(findings, "within")
    first, second, *rest = lines(report)
    assert (first, second) == ("FALSE  b is 2 (the table gives 3)", "FALSE  c is 4")
    assert " ".join(rest).strip().startswith("2 of 3 statements are FALSE") and "'within'" in " ".join(rest)
    assert "is kept" not in paragraph(Report(findings, "within", Outline(targets=("The target is kept.",))))


def test_numbers_of_assumptions() -> None:
    assert finding_line(Finding("x", True, ""), [1, 2, 3, 5]) == "true   x (rests on 1 to 3 and 5)"
    assert finding_line(Finding("x", True, ""), [2, 3]) == "true   x (rests on 2 and 3)"


def test_a_page_says_so() -> None:
    report = Report((Finding("x", True, ""),), "none", of_page=True)
    assert paragraph(report).endswith("what the page shows besides was not compared with it.")
