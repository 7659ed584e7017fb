"""Pages of every kind as people meet them: on a phone, in the dark, on paper, from the keyboard and by a reader of screens.

Axe on every kind of page in every look: FAIRAUDIT_FULL=1 pytest tests/reports/test_looks_of_reports.py
"""

from __future__ import annotations

import base64
import io
import json
import random
import re
from collections.abc import Callable
from functools import cache
from importlib.resources import files
from pathlib import Path
from typing import Any

import pytest
import tiers
from attested import statement_about as statement_of
from browser import Browser
from certificate_kinds import (
    FOUR,
    admissions,
    both_contrasts,
    fifty_by_forty,
    infinite,
    many_columns,
    never_globally,
    no_context,
    profiles,
    signed,
    small_counts,
    true_labels,
)
from proxy_certificates import proxied

import fairaudit as fa

BERKELEY = {"decision": "Admit", "group": "Gender", "context": "Dept", "count": "Freq", "utility": "Admitted"}
TARGET = {"max_local_ratio": "5/4", "max_global_ratio": "5/4"}


def asked(**options: Any) -> fa.Result:
    table = fa.example("ucb-admissions").table()
    given: dict[str, Any] = {**BERKELEY, **TARGET, **options}
    return fa.audit({name: list(table[name]) for name in ("Admit", "Gender", "Dept", "Freq")}, **given)


def unknown() -> fa.Result:
    table = {name: list(fa.example("ucb-admissions").table()[name]) for name in ("Admit", "Gender", "Dept", "Freq")}
    lost = [int(n) // 20 for n in table["Freq"]]
    table["Freq"] = [int(n) - k for n, k in zip(table["Freq"], lost, strict=True)] + lost
    table["Gender"] += ["n/a"] * len(lost)
    table["Admit"] += table["Admit"]
    table["Dept"] += table["Dept"]
    given: dict[str, Any] = {**BERKELEY, **TARGET}
    return fa.audit(table, unknown=["n/a"], **given)


def units() -> fa.Result:
    log: dict[str, Any] = {
        "a": list("ffmmffmm") * 6,
        "u": ["yes", "no", "no", "no", "yes", "yes", "yes", "no"] * 6,
        "run": [i // 2 for i in range(48)],
    }
    return fa.certify(fa.Law.from_log(log, decision="u", group="a", unit="run"), {"yes": 1}, max_local_ratio="5/4")


def filtered() -> fa.Result:
    array = [[["9/10", "1/10"], ["2/10", "8/10"], ["1/3", "2/3"]], [["1/2", "1/2"], ["1/5", "4/5"], ["3/4", "1/4"]]]
    policy = fa.Policy.from_array(array, decisions=["yes", "no"], groups=["a", "b", "c"], contexts=["day", "night"])
    coin = fa.RandomizedResponse(["a", "b", "c"], exp_epsilon="7/3")
    return fa.certify(policy.behind(group=coin), {"yes": 1, "no": "1/5"}, declared={"tau": "1/4", "gamma": 2}, **FOUR)


def sampled() -> fa.Result:
    rows = {
        "u": ["hire", "pass"] * 4,
        "x": ["office"] * 4 + ["field"] * 4,
        "a": ["f", "f", "m", "m"] * 2,
        "n": [30, 10, 20, 20, 11, 9, 13, 7],
    }
    policy = fa.Policy.from_counts(rows, decision="u", group="a", context="x", count="n")
    return fa.certify(policy.behind(group=fa.RandomizedResponse(["f", "m"], keep_probability="0.8")), {"hire": 1}, max_local_ratio="5/4")


def subgroups() -> Any:
    table = fa.example("ucb-admissions").table()
    log = {name: list(table[name]) for name in ("Admit", "Gender", "Dept", "Freq")}
    return fa.subgroups(log, decision="Admit", attributes=["Gender", "Dept"], utility="Admitted", count="Freq", depth=2, max_ratio="0.8")


def proxies() -> Any:
    return proxied(random.Random(0), 2)


KINDS: dict[str, Callable[[], Any]] = {
    "admissions": admissions,
    "with targets": asked,
    "of the table": lambda: asked(confidence=None),
    "burden": lambda: asked(burden=True, utility="Rejected"),
    "hidden context": lambda: asked(hidden_context=("3/2", "3/2")),
    "drift": lambda: asked(max_drift="0.05"),
    "unknown groups": unknown,
    "units": units,
    "filters": filtered,
    "filters, sampled": sampled,
    "without its table": lambda: small_counts(**FOUR, embed_table=False),
    "labels": lambda: many_columns(max_local_ratio=2),
    "true labels": lambda: true_labels(**FOUR),
    "infinite": lambda: infinite(max_local_ratio=2),
    "negative": lambda: signed(max_difference="1/3"),
    "differences": lambda: both_contrasts(**FOUR),
    "no context": lambda: no_context(max_local_ratio=2),
    "not comparable": never_globally,
    "profiles": profiles,
    "fifty by forty": fifty_by_forty,
    "subgroups": subgroups,
    "proxies": proxies,
}
KINDS |= {"attested": lambda: asked(confidence=None), "attested subgroups": subgroups}
SCRIPTLESS = ("subgroups", "attested subgroups", "proxies")


@cache
def page(kind: str) -> str:
    made = KINDS[kind]().certificate
    if not kind.startswith("attested"):
        return fa.report(made)
    said: dict[str, Any] = {
        "title": "Long " * 60,
        "issuer": {"name": "Ex\u202eample " + "x" * 300},
        "options": {"unknown": ["label " * 40], "query": "SELECT 1"},
    }
    said["rows"] = {"unit": "decisions", "read": 4526, "counted": 4526, "dropped": {}}
    return fa.report(made, attestation=json.dumps(statement_of(made.document, made.text.encode(), **said)).encode())


@pytest.fixture
def shown(browser: Browser, tmp_path: Path) -> Callable[..., Browser]:
    def show(kind: str, width: int = 1280, **options: Any) -> Browser:
        path = tmp_path / "page.html"
        path.write_text(page(kind), "utf-8")
        browser.open(path, width, **options, scripts=kind not in SCRIPTLESS)
        return browser

    return show


def violations(browser: Browser) -> list[str]:
    """What axe-core finds, with everything unfolded."""
    browser.run("for (const e of document.querySelectorAll('details')) e.open = true;")
    browser.run(files("axe_core_python").joinpath("axe.min.js").read_text("utf-8"))
    found = browser.driver.execute_async_script(
        "const done = arguments[0]; axe.run(document, {resultTypes: ['violations']}).then((r) => done(r.violations.map((v) =>"
        " v.id + ': ' + v.nodes.slice(0, 3).map((n) => n.html.slice(0, 120)).join(' | '))), (e) => done([String(e)]));"
    )
    return list(found)


LOOKS = ((1280, False), (1280, True), (360, False))
WHOLLY = ("with targets", "labels", "filters", "attested")
"""Kinds whose pages have most of what a page can have: each is tried in every look, the others in one look each."""


@pytest.mark.parametrize("kind", [kind for kind in KINDS if kind != "fifty by forty"])
def test_axe_finds_nothing(kind: str, shown: Callable[..., Browser]) -> None:
    pytest.importorskip("axe_core_python", reason="axe-core-python is not installed (it is in the extra dev)")
    every = kind in WHOLLY or tiers.FULL
    for width, dark in LOOKS if every else [LOOKS[list(KINDS).index(kind) % len(LOOKS)]]:
        assert violations(shown(kind, width, dark=dark)) == [], (width, dark)


def test_axe_sees_what_is_wrong(shown: Callable[..., Browser]) -> None:
    pytest.importorskip("axe_core_python", reason="axe-core-python is not installed (it is in the extra dev)")
    browser = shown("admissions")
    browser.run("document.querySelector('.what').style.color = '#ddd'; document.getElementById('find').labels[0].remove();")
    found = violations(browser)
    assert [text.partition(":")[0] for text in found] == ["color-contrast", "label"]


WIDE = """
const wide = [], limit = document.documentElement.clientWidth + 1;
for (const e of document.querySelectorAll('body *')) {
  const box = e.getBoundingClientRect();
  if (!box.width || e.closest('.vh, .skip, thead, script') || getComputedStyle(e).clipPath !== 'none') continue;
  if (e.closest('svg') && e.tagName !== 'svg') continue;
  if (box.right > limit || (e.scrollWidth > e.clientWidth + 1 && getComputedStyle(e).overflowX !== 'visible' && e.clientWidth))
    wide.push(e.tagName + '.' + e.className + ' ' + Math.round(box.right) + ' ' + e.textContent.slice(0, 30));
}
return wide;"""


@pytest.mark.parametrize("kind", KINDS)
def test_nothing_stands_beside_a_screen(kind: str, shown: Callable[..., Browser]) -> None:
    """No part of a page, unfolded, is wider than a phone, a tablet or a desk, and nothing is to be scrolled sideways."""
    for width in (360, 760, 1000, 1280):
        browser = shown(kind, width)
        if kind != "fifty by forty":
            browser.run("for (const e of document.querySelectorAll('details')) e.open = true;")
        assert browser.run("return document.documentElement.scrollWidth <= document.documentElement.clientWidth"), width
        assert browser.run(WIDE) == [], width


def test_on_a_phone_every_cell_of_a_table_is_seen(shown: Callable[..., Browser]) -> None:
    browser = shown("with targets", 360)
    browser.run("for (const e of document.querySelectorAll('details')) e.open = true;")
    hidden = "return [...document.querySelectorAll('tbody td')].filter((e) => e.textContent.trim() && !e.getClientRects().length).length"
    assert browser.run("return document.querySelectorAll('tbody td').length") > 40
    assert browser.run(hidden) == 0
    names = browser.run("return [...document.querySelectorAll('#rows tr')][0].innerText")
    said = browser.run(
        "return [...document.querySelectorAll('#rows tr:first-child td')].map((e) => getComputedStyle(e, '::before').content)"
    )
    assert "512/825" in names and [text.strip('"') for text in said][:4] == ["Dept", "Gender", "Decisions", "Counted"]


# Paper


def printed(browser: Browser) -> str:
    """The text of the pages that the browser prints, in one line."""
    pypdf = pytest.importorskip("pypdf", reason="pypdf is not installed (it is in the extra dev)")
    made = browser.driver.execute_cdp_cmd("Page.printToPDF", {"preferCSSPageSize": True})
    pages = pypdf.PdfReader(io.BytesIO(base64.b64decode(made["data"]))).pages
    return " ".join(" ".join(sheet.extract_text() for sheet in pages).split())


def test_paper_has_every_row(shown: Callable[..., Browser]) -> None:
    """All 12 cells of Berkeley, counted by hand from the published table, each with its numbers side by side."""
    text = printed(shown("with targets"))
    published = {
        ("A", "Male"): (825, 512),
        ("A", "Female"): (108, 89),
        ("B", "Male"): (560, 353),
        ("B", "Female"): (25, 17),
        ("C", "Male"): (325, 120),
        ("C", "Female"): (593, 202),
        ("D", "Male"): (417, 138),
        ("D", "Female"): (375, 131),
        ("E", "Male"): (191, 53),
        ("E", "Female"): (393, 94),
        ("F", "Male"): (373, 22),
        ("F", "Female"): (341, 24),
    }
    for (dept, gender), (n, admitted) in published.items():
        assert re.search(rf"\b{dept} {gender} {n} {admitted} ", text), (dept, gender)
    for claim in asked().certificate.document["claims"]:
        assert claim["by"] in text


def test_paper_has_every_row_of_a_long_table(shown: Callable[..., Browser]) -> None:
    text = printed(shown("fifty by forty"))
    rows = set(re.findall(r"context (\d+) group (\d+) \d+ \d+ ", text))
    assert len(rows) == 2000


def test_paper_has_the_rows_that_the_script_makes(browser: Browser, tmp_path: Path) -> None:
    """Of a table that is too long to be written out."""
    law = fa.Law.from_array([[1 + i % 7, 3] for i in range(2600)], kind="counts")
    path = tmp_path / "page.html"
    fa.report(fa.certify(law, {"0": 1}, confidence=None).certificate, path)
    browser.open(path)
    assert len(rows(browser)) == 10
    browser.run("window.dispatchEvent(new Event('beforeprint'))")
    listed = rows(browser)
    assert len(listed) == 2600
    assert listed[2].split() == ["2", "6", "3", "50.0", "%", "1.4", "1/2"]  # 3 of 6; the best group has 7 of 10


def test_paper_without_scripts_has_every_row(browser: Browser, tmp_path: Path) -> None:
    path = tmp_path / "page.html"
    path.write_text(page("with targets"), "utf-8")
    browser.open(path, scripts=False)
    text = printed(browser)
    assert len(set(re.findall(r"\b([A-F]) ((?:Fem|M)ale) \d+ \d+ ", text))) == 12


def test_paper_of_pages_without_scripts(shown: Callable[..., Browser]) -> None:
    made = subgroups()
    text = printed(shown("subgroups"))
    assert all(f"{one.rows:,}" in text for one in made.found)


# The look-up


def choose(browser: Browser, **chosen: str) -> None:
    for name, text in chosen.items():
        browser.run(
            "const s = document.getElementById(arguments[0]); s.value = [...s.options].find((o) => o.text === arguments[1]).value;"
            "s.dispatchEvent(new Event('change'));",
            name,
            text,
        )


def rows(browser: Browser) -> list[str]:
    return list(browser.run("return [...document.querySelectorAll('#rows tr')].map((e) => e.innerText.replace(/\\s+/g, ' '))"))


def test_two_groups_are_compared_in_a_context(shown: Callable[..., Browser]) -> None:
    browser = shown("with targets")
    choose(browser, context="B", group="Male", against="Female")
    assert [row.split()[:4] for row in rows(browser)] == [["B", "Male", "560", "353"], ["B", "Female", "25", "17"]]
    said = browser.run("return document.getElementById('compared').textContent")
    assert said == "Female 68.0\u00a0% against Male 63.0\u00a0%: 1.079 times (1904/1765)"  # 17/25 over 353/560
    choose(browser, against="all", group="all", context="all", order="furthest from the best first")
    assert rows(browser)[0].split()[:2] == ["A", "Male"]
    browser.run("window.dispatchEvent(new Event('beforeprint'))")
    assert len(rows(browser)) == 12
    browser.run("window.dispatchEvent(new Event('afterprint'))")
    assert len(rows(browser)) == 10


def test_rows_altered_on_the_page_alone_are_seen(browser: Browser, tmp_path: Path) -> None:
    text = page("with targets")
    for old, new in ((">62.1\u00a0%</td>", ">72.1\u00a0%</td>"), (">512/825</td>", ">612/825</td>"), ('">825</td>', '">925</td>')):
        assert text.count(old) == 1, old
        (tmp_path / "page.html").write_text(text.replace(old, new), "utf-8")
        browser.open(tmp_path / "page.html")
        assert browser.state == "differs"
        assert any(line.startswith("✗") and "rows of the table that stand on this page" in line for line in browser.findings)


# What every picture needs


@pytest.mark.parametrize("kind", KINDS)
def test_every_mark_has_a_legend_and_every_scale_its_numbers(kind: str, shown: Callable[..., Browser]) -> None:
    browser = shown(kind)
    for mark in ("dot", "whisker", "before", "limit", "line", "bar"):
        used = browser.run(f"return document.querySelectorAll('.track .{mark}').length")
        assert not used or browser.run(f"return document.querySelectorAll('.legend .{mark}').length"), mark
    scales = browser.run("return [...document.querySelectorAll('.scale')].map((e) => e.querySelectorAll('text').length)")
    assert all(count >= 2 for count in scales)
    assert bool(scales) == bool(browser.run("return document.querySelectorAll('.track').length"))


@pytest.mark.parametrize("kind", KINDS)
def test_the_index_leads_to_every_section(kind: str, shown: Callable[..., Browser]) -> None:
    browser = shown(kind)
    links = browser.run("return [...document.querySelectorAll('nav a')].map((e) => [e.getAttribute('href').slice(1), e.textContent])")
    heads = browser.run("return [...document.querySelectorAll('main h2')].map((e) => [e.id, e.textContent])")
    assert links == heads and len(links) >= 4
