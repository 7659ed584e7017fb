"""The page in print: every row of its table, as text that can be selected; nothing from elsewhere, and the same bytes each time."""

from __future__ import annotations

import io
import json
import os
import subprocess
import sys
from fractions import Fraction
from pathlib import Path
from typing import Any

import needs
import pytest
from certificate_kinds import fifty_by_forty, many_columns, signed, weighted
from proxy_certificates import every_kind

import fairaudit as fa
from fairaudit import checker
from fairaudit.cli import main

pypdf = pytest.importorskip("pypdf")
if not needs.pango():
    pytest.skip("Pango is not installed", allow_module_level=True)
pytest.importorskip("weasyprint")

ADMISSIONS = {  # admitted and rejected, Bickel, Hammel and O'Connell, Science 187 (1975): the six largest departments
    ("A", "Male"): (512, 313),
    ("A", "Female"): (89, 19),
    ("B", "Male"): (353, 207),
    ("B", "Female"): (17, 8),
    ("C", "Male"): (120, 205),
    ("C", "Female"): (202, 391),
    ("D", "Male"): (138, 279),
    ("D", "Female"): (131, 244),
    ("E", "Male"): (53, 138),
    ("E", "Female"): (94, 299),
    ("F", "Male"): (22, 351),
    ("F", "Female"): (24, 317),
}


def read(path: Path) -> Any:
    return pypdf.PdfReader(io.BytesIO(path.read_bytes()))


def text_of(pdf: Any) -> str:
    return "\n".join(page.extract_text().replace("\0", "") for page in pdf.pages)


def rows_of(text: str) -> str:
    """What stands in the complete table, without the breaks of lines."""
    return " ".join(text.partition("Every row of the table")[2].split())


@pytest.fixture(scope="module")
def admissions(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("print") / "page.pdf"
    assert main(["certify", "--example", "ucb-admissions", "--max-local-ratio", "5/4", "-o", str(path)]) == 3
    return path


def test_every_published_rate_can_be_read(admissions: Path) -> None:
    said = rows_of(text_of(read(admissions)))
    for (department, sex), (yes, no) in ADMISSIONS.items():
        assert f"{department} {sex} {100 * yes / (yes + no):#.3g} % ({yes} of {yes + no}) " in said
        assert f" {Fraction(yes, yes + no)} " in f"{said} "


def test_title_numbers_of_pages_and_nothing_that_is_only_for_screens(admissions: Path) -> None:
    pdf = read(admissions)
    pages = [page.extract_text() for page in pdf.pages]
    assert all(f"{i} of {len(pages)}" in page for i, page in enumerate(pages, 1))
    assert pdf.metadata.title.startswith("Fairness audit: Inconclusive")
    for word in ("Skip to the findings", "Save the certificate", "script", "Look up", "Previous", "recomputed"):
        assert word not in "\n".join(pages)


def test_the_certificate_is_attached(admissions: Path) -> None:
    (attached,) = read(admissions).attachments["certificate.json"]
    assert checker.check(attached).ok and json.loads(attached)["format"] == "fairaudit-certificate/1"
    with pytest.raises(fa.InputError, match="is a PDF, which people read; check the certificate that is attached to it"):
        fa.verify(admissions.read_bytes())


def test_nothing_is_loaded_and_nothing_runs(admissions: Path) -> None:
    raw = admissions.read_bytes()
    pdf = read(admissions)
    assert b"/JavaScript" not in raw and b"/Launch" not in raw
    linked = [found.get_object() for page in pdf.pages for found in page.get("/Annots", [])]
    assert not [found for found in linked if "/URI" in found.get("/A", {})]
    fonts = {font.get_object()["/Subtype"] for page in pdf.pages for font in page["/Resources"]["/Font"].values()}
    assert fonts <= {"/Type0", "/Type3"}
    embedded = [
        any(name in font["/DescendantFonts"][0].get_object()["/FontDescriptor"] for name in ("/FontFile2", "/FontFile3"))
        for page in pdf.pages
        for font in (entry.get_object() for entry in page["/Resources"]["/Font"].values())
        if font["/Subtype"] == "/Type0"
    ]
    assert embedded and all(embedded)


def test_the_same_certificate_gives_the_same_bytes(admissions: Path, tmp_path: Path) -> None:
    again = tmp_path / "again.pdf"
    words = ["certify", "--example", "ucb-admissions", "--max-local-ratio", "5/4", "-o", str(again)]
    environment = os.environ | {"PYTHONHASHSEED": "11", "TZ": "Pacific/Kiritimati"}
    assert subprocess.run([sys.executable, "-m", "fairaudit", *words], env=environment, capture_output=True, check=False).returncode == 3
    assert again.read_bytes() == admissions.read_bytes()


def test_every_row_of_a_table_of_fifty_by_forty(tmp_path: Path) -> None:
    fa.report(fifty_by_forty(), tmp_path / "page.pdf")
    said = rows_of(text_of(read(tmp_path / "page.pdf")))
    assert [f"context {x} group {a} " for x in range(50) for a in range(40) if f"context {x} group {a} " not in said] == []


@pytest.mark.parametrize("kind", [many_columns, signed, weighted])
def test_tables_of_other_kinds(kind: Any, tmp_path: Path) -> None:
    result = kind()
    fa.report(result, tmp_path / "page.pdf")
    pdf = read(tmp_path / "page.pdf")
    assert "Every row of the table" in text_of(pdf)
    assert checker.check(pdf.attachments["certificate.json"][0]).ok


def test_a_certificate_without_its_table(tmp_path: Path) -> None:
    result = fa.audit(
        {"hired": ["yes", "no"] * 2, "sex": ["f", "f", "m", "m"]}, decision="hired", group="sex", utility="yes", embed_table=False
    )
    fa.report(result, tmp_path / "page.pdf")
    said = text_of(read(tmp_path / "page.pdf"))
    assert "Every row" not in said and "--table certificate.table.jsonl" in said and "statements are true of the table" in said


def test_groups_that_nobody_recorded(tmp_path: Path) -> None:
    fa.report(next(every_kind()).certificate, tmp_path / "page.pdf")
    pdf = read(tmp_path / "page.pdf")
    assert "Groups that were not recorded" in text_of(pdf) and checker.check(pdf.attachments["certificate.json"][0]).ok


MISSING = """
import sys
class Absent:
    def find_spec(self, name, path=None, target=None):
        if name == "weasyprint":
            raise {error}
sys.meta_path.insert(0, Absent())
from fairaudit.cli import main
sys.exit(main(["certify", "--example", "ucb-admissions", "-o", "c.json", "-o", "page.pdf"]))
"""


@pytest.mark.parametrize(
    ("error", "said"),
    [
        ("ImportError(name)", "pip install 'fairaudit-certify[pdf]'"),
        ("OSError(\"cannot load library 'libpango-1.0-0': not found\")", "a PDF needs libpango-1.0-0, which is not installed"),
    ],
)
def test_what_is_missing_is_named_before_the_work(error: str, said: str, tmp_path: Path) -> None:
    run = [sys.executable, "-c", MISSING.format(error=error)]
    done = subprocess.run(run, cwd=tmp_path, capture_output=True, text=True, check=False)
    assert done.returncode == 2 and said in done.stderr and done.stderr.count("\n") == 1 and not done.stdout
    assert list(tmp_path.iterdir()) == []
