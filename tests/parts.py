"""Parts of the mission, and which cases of each tier test them: ``make parts`` prints the table."""

from __future__ import annotations

import re
from collections.abc import Iterable
from typing import NamedTuple


class Case(NamedTuple):
    """One collected case."""

    name: str
    """Its path below ``tests/``, two colons, and its function with parameters."""
    tier: str
    """quick, default or deep."""
    needs: frozenset[str]
    """First words of what it needs of the machine beyond Python packages."""


PARTS = {
    "exact core": r"tests/(exact|measures|model)/",
    "bounds": r"tests/theorems/",
    "calibration": r"tests/filters/test_calibration",
    "designs": r"tests/filters/",
    "linear programs and the worst utility": r"tests/worst/|test_linear_programs",
    "privacy": r"tests/privacy/",
    "intervals": r"tests/(inference|validity)/",
    "certificates": r"tests/(certificates|audits)/",
    "checker, altered certificates": r"tests/checker/",
    "verified program": r"tests/verified/|tests/whole/test_verified",
    "tables and engines": r"tests/tables/",
    "evaluation logs": r"tests/tables/evaluations/",
    "streams": r"tests/streams/",
    "attestations": r"tests/attestations/",
    "reports": r"tests/reports/|test_plots",
    "publications": r"tests/publications/",
    "command line": r"tests/cli/",
    "plug-in for navigation": r"tests/plugins/navigation/",
    "plug-in for language models": r"tests/plugins/vlm/",
    "gallery": r"test_gallery",
    "documentation": r"tests/whole/test_(docs|start|pictures|notebooks)|fairaudit/",
}
"""Parts by where their tests are."""

PROGRAMS = {
    "a page in Chromium": "browser",
    "Spark": "Java",
    "PostgreSQL": "PostgreSQL",
    "Coq": "Coq",
    "spreadsheets by LibreOffice": "LibreOffice",
}
"""Parts by what their tests need."""


def table(cases: Iterable[Case]) -> list[tuple[str, int, int, int]]:
    """Per part: its cases in the quick tier, in the default tier (the quick ones included), and in the deep one."""
    found = list(cases)
    of_parts = {part: [case for case in found if re.search(where, case.name)] for part, where in PARTS.items()}
    of_programs = {part: [case for case in found if need in case.needs] for part, need in PROGRAMS.items()}
    return [
        (part, *(sum(case.tier in tiers for case in members) for tiers in (("quick",), ("quick", "default"), ("deep",))))
        for part, members in {**of_parts, **of_programs, "all": found}.items()
    ]


def markdown(cases: Iterable[Case]) -> list[str]:
    """The table as lines of Markdown."""
    lines = ["| part of the mission | `make check` | by default | `make deep` |", "| --- | ---: | ---: | ---: |"]
    return lines + [f"| {part} | {quick:,} | {default:,} | {deep:,} |" for part, quick, default, deep in table(cases)]
