"""The page on trust counts lines: here they are counted again, a tenth more or less, so that the page stays true while the code moves."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
PAGE = (ROOT / "docs" / "trust.md").read_text("utf-8")
PICTURE = (ROOT / "docs" / "pictures" / "trust.svg").read_text("utf-8")
PROOFS = ROOT / "proofs"
SCRIPT = ROOT / "fairaudit" / "reports" / "page.js"


def lines(*paths: Path, until: str = "") -> int:
    return sum(len((path.read_text("utf-8").partition(until)[0] if until else path.read_text("utf-8")).splitlines()) for path in paths)


def in_checker(*names: str) -> list[Path]:
    return [PROOFS / "checker" / name for name in names]


def of_a_plain_table() -> int:
    """The lines of functions that run, which another page lists and another test counts."""
    (found,) = re.findall(r"^\| together \| [\d,]+ \| ([\d,]+) \|", (ROOT / "docs" / "verify.md").read_text("utf-8"), re.MULTILINE)
    return int(found.replace(",", ""))


COUNTED = {
    r"about ([\d,]+) lines of Python": lines(*(ROOT / "fairaudit" / "checker").glob("*.py")),
    r"of which about ([\d,]+) run for a plain table": of_a_plain_table(),
    r"about ([\d,]+) lines: digest": lines(*in_checker("sha256.ml", "report.ml", "main.ml", "Extract.v")),
    r"in the page ([\d,]+) lines more": lines(*in_checker("big_int_Z.ml", "bigint.js", "script.ml")),
    r"and about ([\d,]+) lines of its script": lines(SCRIPT) - lines(SCRIPT, until="// ---- The verified program"),
    r"about ([\d,]+) lines on what the bytes of a file say": lines(*in_checker("Json.v"), until="==== The program")
    + lines(*in_checker("ReadingSound.v", "CertificateSound.v"), until="==== Proofs")
    + lines(
        *in_checker("Reading.v", "TableText.v", "ClassText.v", "DrawnText.v", "BetsText.v", "DriftText.v", "Document.v", "TargetText.v")
    )
    + lines(*in_checker("Certificate.v")),
    r"and about ([\d,]+) on what that means": lines(*in_checker("Table.v", "Statements.v", "Meaning.v"))
    + lines(*in_checker("NatsSound.v"), until="---- Proofs")
    + lines(PROOFS / "kernel" / "WorstCaseSound.v", until="==== Proofs"),
}


@pytest.mark.parametrize("said", COUNTED)
def test_the_lines_are_as_many_as_the_page_says(said: str) -> None:
    (stated,) = re.findall(said, PAGE)
    assert int(stated.replace(",", "")) == pytest.approx(COUNTED[said], rel=0.1)


def test_the_picture_says_what_the_page_says() -> None:
    numbers = set(re.findall(r"[\d,]+(?= (?:lines|for everything))|(?<=lines, )[\d,]+|(?<=means: )[\d,]+|(?<=means, )[\d,]+", PICTURE))
    stated = {re.findall(said, PAGE)[0] for said in COUNTED if "in the page" not in said and "of its script" not in said}
    assert numbers == stated


@pytest.mark.parametrize("page", ["verify.md", "proofs.md", "report.md"])
def test_the_page_is_linked(page: str) -> None:
    assert "(trust.md)" in (ROOT / "docs" / page).read_text("utf-8")
