"""From counts to a folder by New York City's rule: the printed examples, the order of the page, and what a browser shows."""

from __future__ import annotations

import csv
import io
import json
import random
import re
import shlex
from fractions import Fraction
from pathlib import Path
from typing import Any

import pytest
import tiers
from browser import Browser
from ll144_examples import (
    CUT_OFF,
    RACES,
    SCORING_BOTH,
    SCORING_RACE,
    SCORING_SEX,
    SCORING_UNKNOWN,
    SELECTION_BOTH,
    SELECTION_RACE,
    SELECTION_SEX,
    SELECTION_UNKNOWN,
    Printed,
    rounded,
)

import fairaudit as fa
from fairaudit.cli import main

GUIDE = Path(__file__).resolve().parents[3] / "docs" / "publish-ll144.md"

LABELS = ("hisp", "white", "black", "nhpi", "asian", "aian", "two")

HEADER = [
    *("table", "sex", "race_ethnicity", "applicants", "selected", "rate", "impact_ratio"),
    *("rate_exact", "impact_ratio_exact", "share_exact", "status"),
]

STATED = (
    *("--tool", "Ranker", "--tool-version", "3.2", "--auditor", "Independent Audits Ltd"),
    *("--audit-date", "2026-01-15", "--distribution-date", "2026-02-01", "--period", "2025-01-01/2025-12-31"),
    *("--data-source", "applications to this employer", "--data-kind", "historical"),
)


def saved(path: Path, printed: Printed, unknown: int = 0) -> Path:
    """The certificate of an example; a fifth of the unknown were selected."""
    rows = [(sex, race, s, n) for (sex, race), (n, s, _, _) in printed.items()]
    first = rows[0]
    rows.append(("declined" if first[0] else "", "declined" if first[1] else "", unknown // 5, unknown))
    columns = [name for name, place in (("sex", 0), ("race", 1)) if first[place]]
    table: dict[str, Any] = {name: [row[("sex", "race").index(name)] for row in rows for _ in range(2)] for name in columns}
    table |= {"hired": ["yes", "no"] * len(rows), "n": [n for _, _, s, all_ in rows for n in (s, all_ - s)]}
    fa.audit(table, decision="hired", group=columns, count="n", utility="yes", confidence=None).save(path)
    return path


def published(certificate: Path, to: Path, *more: str) -> list[dict[str, str]]:
    """The rows of the CSV."""
    assert main(["publish", str(certificate), "--rule", "ll144", "-o", str(to), "--unknown", "declined", *more]) == 0
    return list(csv.DictReader(io.StringIO((to / "table.csv").read_text("utf-8"))))


def shown(folder: Path) -> str:
    """The page, without blanks that do not break."""
    return (folder / "index.html").read_text("utf-8").replace("\u00a0", " ")


@pytest.mark.parametrize(
    ("printed", "tables", "unknown"),
    [
        (SELECTION_BOTH, {"sex": SELECTION_SEX, "intersection": SELECTION_BOTH}, SELECTION_UNKNOWN),
        (SELECTION_RACE, {"race": SELECTION_RACE}, SELECTION_UNKNOWN),
        (SCORING_BOTH, {"sex": SCORING_SEX, "race": SCORING_RACE, "intersection": SCORING_BOTH}, SCORING_UNKNOWN),
    ],
)
def test_the_rules_examples_from_counts_to_folder(printed: Printed, tables: dict[str, Printed], unknown: int, tmp_path: Path) -> None:
    both = printed is not SELECTION_RACE
    rows = published(saved(tmp_path / "c.json", printed, unknown), tmp_path / "out", "--race", "race", *(("--sex", "sex") if both else ()))
    assert list(rows[0]) == HEADER
    page = shown(tmp_path / "out")
    for name, expected in tables.items():
        own = [row for row in rows if row["table"] == name]
        assert [(row["sex"], row["race_ethnicity"]) for row in own[:-1]] == list(expected)
        for row, (category, (people, selected, rate, ratio)) in zip(own[:-1], expected.items(), strict=True):
            assert (int(row["applicants"]), int(row["selected"]), row["status"]) == (people, selected, "compared")
            rounded_rate = "64.3%" if expected is SCORING_RACE and category == CUT_OFF else rate
            exact = Fraction(row["rate_exact"]), Fraction(row["impact_ratio_exact"])
            assert exact[0] == Fraction(selected, people)
            assert (rounded(exact[0], rate), rounded(exact[1], ratio)) == (rounded_rate, ratio)
            assert (row["rate"], row["impact_ratio"]) == (rounded(exact[0], "0.0%").replace("%", " %"), rounded(exact[1], "0.000"))
            assert f"<span>{row['rate']}</span>" in page
        assert (own[-1]["status"], own[-1]["applicants"], own[-1]["selected"]) == ("unknown", str(unknown), str(unknown // 5))


@pytest.mark.parametrize("available", [False, True])
def test_random_logs_are_counted_as_by_hand(available: bool, tmp_path: Path) -> None:
    draw = random.Random(tiers.fresh(5303))
    for turn in range(4):
        races = draw.sample(RACES, draw.randint(1, 7))
        log = [
            (draw.choice(("Male", "Female", "x", "")), draw.choice([*races, "x"]), draw.choice("yn"), draw.choice("ab")) for _ in range(90)
        ]
        table = {name: [row[i] or None for row in log] for i, name in enumerate(("sex", "race", "got", "team"))}
        certificate = tmp_path / f"{turn}.json"
        how: dict[str, Any] = {"utility": "y", "missing": "group", "confidence": None}
        fa.audit(table, decision="got", group=["race", "sex"], context="team", **how).save(certificate)
        more = ("--sex", "sex", "--race", "race", "--unknown", "x", "--unknown-in", "available" if available else "complete")
        rows = published(certificate, tmp_path / str(turn), *more)
        for name, places in (("sex", (0,)), ("race", (1,)), ("intersection", (0, 1))):
            needed = places if available else (0, 1)
            inside = [row for row in log if all(row[i] not in ("x", "") for i in needed)]
            own = [row for row in rows if row["table"] == name]
            assert len(own) == {"sex": 2, "race": 7, "intersection": 14}[name] + 1
            rates = {}
            for row in own[:-1]:
                category = (row["sex"], row["race_ethnicity"])
                people = [person for person in inside if all(person[i] == category[i] for i in places)]
                taken = sum(person[2] == "y" for person in people)
                assert (int(row["applicants"]), int(row["selected"])) == (len(people), taken)
                assert row["status"] == ("compared" if people else "empty")
                rates[category] = Fraction(taken, len(people)) if people else None
            top = max(rate for rate in rates.values() if rate is not None)
            for row in own[:-1]:
                rate = rates[row["sex"], row["race_ethnicity"]]
                exact = (row["rate_exact"], row["impact_ratio_exact"])
                assert exact == (("", "") if rate is None else (str(rate), str(rate / top)))
            outside = len(log) - len(inside), sum(row[2] == "y" for row in log) - sum(row[2] == "y" for row in inside)
            assert (int(own[-1]["applicants"]), int(own[-1]["selected"])) == outside


def test_scores_above_the_median(tmp_path: Path) -> None:
    scores: list[tuple[str, str, str]] = []
    for (sex, race), (people, selected, _, _) in SCORING_BOTH.items():
        scores += [(sex, race, "64.6" if i < selected else "64.5" if i % 2 else "12") for i in range(people)]
    scores += [("", "White", "99")] * 6 + [("Male", "", "0.5")] * 9
    log = tmp_path / "log.csv"
    log.write_text("sex,race,score\n" + "".join(f"{','.join(row)}\n" for row in scores))
    median = sorted(Fraction(score) for _, _, score in scores)[len(scores) // 2]
    certificate = tmp_path / "c.json"
    options = ("--score", "score", "--above-median", "--group", "sex,race", "--missing", "group", "-o", str(certificate))
    assert main(["certify", str(log), *options]) == 0
    rows = published(certificate, tmp_path / "out", "--sex", "sex", "--race", "race")
    expected = {**SCORING_SEX, **SCORING_RACE, **SCORING_BOTH}
    found = {
        (row["sex"], row["race_ethnicity"]): (int(row["applicants"]), int(row["selected"])) for row in rows if row["status"] == "compared"
    }
    assert found == {category: row[:2] for category, row in expected.items()}
    assert [(row["applicants"], row["selected"]) for row in rows if row["status"] == "unknown"] == [("15", "6")] * 3
    summary = json.loads((tmp_path / "out" / "summary.json").read_text("ascii"))
    assert (summary["rate"], Fraction(summary["median"])) == ("scoring", median)
    page = shown(tmp_path / "out")
    assert "Scoring rate" in page
    assert "Selection rate" not in page
    assert "the median of all 183 is 64.5" in page
    refused = ("--rule", "ll144", "--sex", "sex", "--race", "race", "-o", str(tmp_path / "no"))
    assert main(["publish", str(certificate), *refused, "--favourable", "not above"]) == 2
    assert main(["publish", str(certificate), *refused, "--class", "above"]) == 2


@pytest.mark.parametrize(
    ("cut", "missing", "said"),
    [
        (("--above-median",), "drop", "This one is of 4 scores, without those of the 2 people of whom a category is missing."),
        (("--above", "2.5"), "group", "Scores were cut at 2.5."),
    ],
)
def test_a_median_that_is_not_that_of_all_is_remarked_on(cut: tuple[str, ...], missing: str, said: str, tmp_path: Path) -> None:
    log, certificate = tmp_path / "log.csv", tmp_path / "c.json"
    log.write_text("sex,score\nMale,1\nMale,2\nFemale,3\nFemale,4\n,5\n,6\n")
    assert main(["certify", str(log), "--score", "score", *cut, "--group", "sex", "--missing", missing, "-o", str(certificate)]) == 0
    published(certificate, tmp_path / "out", "--sex", "sex")
    assert said in shown(tmp_path / "out")


def test_nobody_of_known_category(tmp_path: Path) -> None:
    table = {"sex": ["declined", "refused", "refused"], "got": ["yes", "no", "no"]}
    fa.audit(table, decision="got", group="sex", utility="yes", confidence=None).save(tmp_path / "c.json")
    made = ("--unknown", "refused", "--data-kind", "test", "--test-data-explanation", "The tool is new; made by lot.")
    rows = published(tmp_path / "c.json", tmp_path / "out", "--sex", "sex", *made)
    assert [(row["status"], row["applicants"], row["impact_ratio"]) for row in rows] == [("empty", "0", "–")] * 2 + [("unknown", "3", "")]
    for text in ("Nobody in the certificate has a known category", "The tool is new; made by lot.", "so there is no rate"):
        assert text in shown(tmp_path / "out")


def test_the_page_says_it_in_the_order_of_the_rule(tmp_path: Path) -> None:
    more = (*STATED, "--sex", "sex", "--race", "race", "--exclude-below-2-percent", "--justification", "Too few people for a rate.")
    rows = published(saved(tmp_path / "c.json", SELECTION_BOTH, 250), tmp_path / "out", *more)
    text = re.sub(r"<style>.*?</style>|<nav.*?</nav>|<[^>]+>", " ", shown(tmp_path / "out"), flags=re.S)
    order = (
        *("Ranker, version 3.2", "Independent Audits Ltd", "2026-01-15", "2026-02-01", "applications to this employer", "historical data"),
        *("2025-01-01 to 2025-12-31", "250", "48.0 %", "Native Hawaiian", "52.2 %", "left out of the impact ratios"),
        *("Justification: Too few people for a rate.", "What the unknown could change", "after 2027-01-15", "How to verify this"),
    )
    at = -1
    for part in order:
        assert part in text[at + 1 :], part
        at = text.index(part, at + 1)
    assert "compliant" not in text.lower()
    assert "What is missing or remarkable" not in text
    left = {(row["sex"], row["race_ethnicity"]) for row in rows if row["status"] == "excluded"}
    assert left == {("", RACES[5]), ("Male", RACES[5]), ("Female", RACES[3]), ("Female", RACES[5])}
    for row in rows:
        if row["status"] == "excluded":
            assert (row["impact_ratio"], row["impact_ratio_exact"]) == ("–", "")
            assert Fraction(row["share_exact"]) < Fraction(1, 50)
            assert row["rate"] in text


def test_the_worst_case_on_the_page(tmp_path: Path) -> None:
    rows = {("Male", ""): (100, 50, "", ""), ("Female", ""): (60, 30, "", "")}
    published(saved(tmp_path / "c.json", rows, 10), tmp_path / "out", "--sex", "sex")
    by_hand = min(Fraction(30, 68) / Fraction(52, 102), Fraction(50, 108) / Fraction(32, 62))
    summary = json.loads((tmp_path / "out" / "summary.json").read_text("ascii"))
    [table] = summary["parts"][0]["tables"]
    assert Fraction(table["worst_case"]) == by_hand
    assert f"<span>{rounded(by_hand, '0.000')}</span>" in shown(tmp_path / "out")
    assert any("three tables" in text for text in summary["findings"])


CLASSES = ("A", "=B", "<i>C</i>")


def classes(path: Path) -> Path:
    """Three classes; contexts and a third attribute are summed over; some intersections are empty, one label of race means White."""
    people = [("Male", "White", "x", "1", (3, 5, 2)), ("Male", "Asian", "y", "2", (0, 4, 6)), ("Female", "W", "x", "1", (6, 2, 0))]
    people += [("Female", "White", "y", "2", (1, 1, 1)), ("Female", "?", "y", "1", (2, 0, 0))]
    names = ("sex", "race", "age", "team")
    table: dict[str, Any] = {name: [row[i] for row in people for _ in CLASSES] for i, name in enumerate(names)}
    table |= {"class": list(CLASSES) * len(people), "n": [n for row in people for n in row[4]]}
    fa.audit(table, decision="class", group=names[:3], context="team", count="n", utility={"A": "2"}, confidence=None).save(path)
    return path


def test_each_class_has_all_three_tables(tmp_path: Path) -> None:
    (tmp_path / "map.toml").write_text('[race]\n"W" = "White"\n')
    more = ("--sex", "sex", "--race", "race", "--categories", str(tmp_path / "map.toml"), "--unknown", "?")
    rows = published(classes(tmp_path / "c.json"), tmp_path / "out", *more, *(part for label in CLASSES for part in ("--class", label)))
    assert list(rows[0]) == ["class", *HEADER]
    assert len(rows) == 3 * (3 + 8 + 15)
    assert list(dict.fromkeys(row["class"] for row in rows)) == ["A", "'=B", "<i>C</i>"]
    sex = {(row["class"], row["sex"]): (row["applicants"], row["selected"]) for row in rows if row["table"] == "sex"}
    assert sex["A", "Male"] == ("20", "3")
    assert sex["A", "Female"] == ("11", "7")
    assert sex["'=B", "Female"] == ("11", "3")
    assert sex["<i>C</i>", ""] == ("2", "0")
    for name in ("sex", "race", "intersection"):
        own = [row for row in rows if row["table"] == name and row["status"] != "unknown"]
        people = {row["class"]: sum(int(other["applicants"]) for other in own if other["class"] == row["class"]) for row in own}
        assert set(people.values()) == {31}
        assert sum(int(row["selected"]) for row in own) == 31
    empty = [row for row in rows if row["status"] == "empty" and row["table"] == "race"]
    assert len(empty) == 3 * 5
    assert all((row["applicants"], row["rate"], row["impact_ratio"], row["share_exact"]) == ("0", "–", "–", "0") for row in empty)
    page = shown(tmp_path / "out")
    assert "<i>C" not in page
    assert "Summed over" in page
    assert "&#39;age&#39;, &#39;team&#39;" in page
    assert "there are none here of" not in page
    assert published(tmp_path / "c.json", tmp_path / "one", *more, "--class", "A")
    assert "none here of &#39;=B&#39;, &#39;&lt;i&gt;C&lt;/i&gt;&#39;" in shown(tmp_path / "one")


def test_the_commands_of_the_guide_run(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    blocks = re.findall(r"^```(\w+)\n(.*?)^```", GUIDE.read_text("utf-8"), re.M | re.S)
    [labels] = [text for kind, text in blocks if kind == "toml"]
    Path("categories.toml").write_text(labels)
    rows = [(sex, race, ("selected", "rejected")[i % 2], i) for i, sex in enumerate(("f", "m", "", "declined") * 7) for race in LABELS]
    Path("log.csv").write_text("sex,race,outcome,points\n" + "".join(f"{','.join(map(str, row))}\n" for row in rows))
    ran = []
    for text in (text for kind, text in blocks if kind == "sh"):
        for line in text.replace("\\\n", " ").splitlines():
            words = shlex.split(line)
            assert main(words[1:]) == 0, line
            ran.append(words[1])
    assert ran == ["certify", "publish", "certify", "certify", "attest", "attest", "verify"]
    summary = json.loads(Path("published/summary.json").read_text("ascii"))
    assert summary["findings"] == []
    assert [table["unknown"]["people"] for table in summary["parts"][0]["tables"]] == [14 * 7] * 3


@pytest.mark.parametrize(("width", "dark"), [(1100, False), (360, True)])
def test_a_browser_shows_the_tables_and_asks_for_nothing(width: int, dark: bool, browser: Browser, tmp_path: Path) -> None:
    hostile = ("--tool", "<img src=x onerror=alert(1)>", "--data-source", "\u202eevil " + "w" * 3000, "--auditor", "{{ 7 * 7 }}")
    published(saved(tmp_path / "c.json", SELECTION_BOTH, 250), tmp_path / "out", "--sex", "sex", "--race", "race", *hostile)
    page = tmp_path / "out" / "index.html"
    browser.open(page, width, dark=dark, scripts=False)
    assert browser.console() == []
    assert set(browser.requests()) <= {page.as_uri()}
    assert browser.run("return document.documentElement.scrollWidth") <= width
    assert browser.run("return document.querySelectorAll('img,script').length") == 0
    assert browser.run("return document.querySelectorAll('tbody tr').length") == 3 + 8 + 15 + 3
