"""The folder of a publication: whole or not at all, harmless whatever the labels are, and the same each time."""

from __future__ import annotations

import base64
import csv
import io
import json
import os
import re
import shutil
import subprocess
import zipfile
from html.parser import HTMLParser
from importlib.resources import files
from pathlib import Path

import pytest
from browser import Browser

import fairaudit as fa
from fairaudit.cli import main
from fairaudit.errors import InputError
from fairaudit.publications.counts import read_source
from fairaudit.publications.folder import write_folder
from fairaudit.words import harmless

EVIL = (
    '=HYPERLINK("http://x.example/","a")',
    "+1+2",
    "-2+3",
    "@SUM(1)",
    "\t=1+1",
    "＝1+1",
    " =1+1",
    "<script>alert(1)</script>",
    "\u202eevil\x1b[31m",
    'a"b,c\nd',
    "x" * 5000,
)


def certificate(path: Path, labels: tuple[str, ...] = EVIL) -> Path:
    table = {
        "=cmd|' /C calc'!A1": [label for label in labels for _ in range(2)],
        "out": ["=1+1", "no"] * len(labels),
        "n": [n for i in range(len(labels)) for n in (3 + i, 40)],
    }
    fa.audit(table, decision="out", group="=cmd|' /C calc'!A1", count="n", utility={"=1+1": 1}, confidence=None).save(path)
    return path


def publish(path: Path, to: Path, *more: str) -> int:
    return main(["publish", str(path), "--rule", "four-fifths", "-o", str(to), *more])


class Tags(HTMLParser):
    """What a page is made of."""

    def __init__(self, text: str) -> None:
        super().__init__()
        self.tags: set[str] = set()
        self.addresses: list[str] = []
        self.feed(text)

    def handle_starttag(self, tag: str, attributes: list[tuple[str, str | None]]) -> None:
        self.tags.add(tag)
        self.addresses += [value or "" for name, value in attributes if name in ("href", "src", "action") or name.startswith("on")]


def test_labels_are_data_everywhere(tmp_path: Path) -> None:
    assert publish(certificate(tmp_path / "c.json"), tmp_path / "out") == 0
    page = (tmp_path / "out" / "index.html").read_text("utf-8")
    found = Tags(page)
    assert not found.tags & {"script", "img", "iframe", "link", "object", "form"}
    assert all(re.fullmatch(r"#[a-z0-9]+|[a-z.]+", address) for address in found.addresses)
    assert "default-src &#39;none&#39;" in page
    assert not {"\u202e", "\x1b"} & {*page}
    text = (tmp_path / "out" / "table.csv").read_text("utf-8")
    rows = list(csv.reader(io.StringIO(text)))
    assert len({len(row) for row in rows}) == 1
    assert [cell for row in rows for cell in row if cell.lstrip()[:1] in {*"=+@\t＝"}] == []
    assert [cell for row in rows for cell in row if cell[:1] == "-" and not re.fullmatch(r"-[0-9./]+", cell)] == []
    summary = json.loads((tmp_path / "out" / "summary.json").read_text("ascii"))
    assert {entry["group"]["=cmd|' /C calc'!A1"] for entry in summary["tables"][0]["groups"]} == {*EVIL}


def test_numbers_stay_numbers_and_formulas_do_not() -> None:
    assert [harmless(cell) for cell in ("-0.5", "12", "-3/4", "women", "-", "=1", " +1", "-1-1", "\rx")] == [
        "-0.5",
        "12",
        "-3/4",
        "women",
        "'-",
        "'=1",
        "' +1",
        "'-1-1",
        "'\\rx",
    ]


@pytest.mark.core
def test_a_spreadsheet_computes_nothing(tmp_path: Path) -> None:
    office = shutil.which("soffice")
    if office is None:
        pytest.skip("soffice is not on the path (Debian: apt-get install --no-install-recommends libreoffice-calc)")
    publish(certificate(tmp_path / "c.json"), tmp_path / "out")
    control = tmp_path / "control.csv"
    control.write_text("a,b\n=1+1,x\n")
    for path in (tmp_path / "out" / "table.csv", control):
        settings = f"-env:UserInstallation=file://{tmp_path}/office"
        options = ["--headless", "--infilter=CSV:44,34,76,1", "--convert-to", "ods", "--outdir", str(tmp_path), str(path)]
        subprocess.run([office, settings, *options], check=True, capture_output=True, timeout=120)
    content = {name: zipfile.ZipFile(tmp_path / name).read("content.xml").decode("utf-8") for name in ("table.ods", "control.ods")}
    assert "table:formula" in content["control.ods"]  # the test can tell
    assert "table:formula" not in content["table.ods"]
    assert "HYPERLINK" in content["table.ods"]


def test_the_folder_holds_what_was_given_and_is_the_same_again(tmp_path: Path) -> None:
    path = certificate(tmp_path / "c.json", ("f", "m"))
    (tmp_path / "empty").mkdir()
    for name in ("first", "second", "empty"):
        assert publish(path, tmp_path / name) == 0
    names = {"index.html", "table.csv", "summary.json", "certificate.json"}
    for name in ("first", "second", "empty"):
        assert {file.name for file in (tmp_path / name).iterdir()} == names
    for file in names:
        assert (tmp_path / "first" / file).read_bytes() == (tmp_path / "second" / file).read_bytes()
    assert (tmp_path / "first" / "certificate.json").read_bytes() == path.read_bytes()
    assert not list(tmp_path.glob(".fairaudit-*"))
    mask = os.umask(0)
    os.umask(mask)
    assert (tmp_path / "first").stat().st_mode & 0o777 == 0o777 & ~mask


def test_a_folder_that_is_there_keeps_its_rights_and_the_current_one_is_refused(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    path = certificate(tmp_path / "c.json", ("f", "m"))
    (tmp_path / "private").mkdir(mode=0o700)
    assert publish(path, tmp_path / "private") == 0
    assert (tmp_path / "private").stat().st_mode & 0o777 == 0o700 and (tmp_path / "private" / "index.html").exists()
    (tmp_path / "here").mkdir()
    monkeypatch.chdir(tmp_path / "here")
    capsys.readouterr()
    for name in (Path(), tmp_path / "here"):
        assert publish(path, name) == 2
        assert "is the current directory" in capsys.readouterr().err
    assert Path.cwd() == tmp_path / "here" and not list(Path().iterdir())


def test_two_labels_are_two_cells() -> None:
    labels = ("=1", "'=1", "''=1", "'women", "women")
    assert len({harmless(label) for label in labels}) == len(labels)


def test_what_is_there_is_never_replaced(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = certificate(tmp_path / "c.json", ("f", "m"))
    (tmp_path / "full").mkdir()
    (tmp_path / "full" / "mine").write_text("x")
    before = path.read_bytes()
    for to, said in (
        (tmp_path / "full", "is not empty"),
        (path, "is a file"),
        (tmp_path / "no" / "where", "there is no directory"),
        (Path("\0"), "cannot be made"),
        (tmp_path / ("x" * 300), "cannot be"),
    ):
        assert publish(path, to) == 2
        assert said in capsys.readouterr().err
    assert (tmp_path / "full" / "mine").read_text() == "x" and path.read_bytes() == before
    assert not list(tmp_path.glob(".fairaudit-*"))


def test_nothing_is_left_where_a_file_cannot_be_written(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="cannot be written"):
        write_folder(tmp_path / "out", {"a": b"1", "x" * 300: b"2"})
    assert list(tmp_path.iterdir()) == []


def test_what_was_left_out_is_said(tmp_path: Path) -> None:
    log = {"out": ["y", "n", None, "y"] * 9, "sex": ["f", "f", "m", "m"] * 9}
    fa.audit(log, decision="out", group="sex", utility="y", missing="drop").save(tmp_path / "c.json")
    publish(tmp_path / "c.json", tmp_path / "out")
    assert "9 of 36 decisions have a missing label and were left out" in (tmp_path / "out" / "index.html").read_text("utf-8")


@pytest.mark.parametrize(("width", "dark"), [(1100, False), (360, True)])
def test_a_browser_shows_the_page_and_asks_for_nothing(width: int, dark: bool, browser: Browser, tmp_path: Path) -> None:
    pytest.importorskip("axe_core_python", reason="axe-core-python is not installed (it is in the extra dev)")
    publish(certificate(tmp_path / "c.json"), tmp_path / "out")
    page = tmp_path / "out" / "index.html"
    browser.open(page, width, dark=dark, scripts=False)
    assert browser.console() == []
    assert set(browser.requests()) <= {page.as_uri()}
    assert browser.run("return document.documentElement.scrollWidth") <= width
    browser.run(files("axe_core_python").joinpath("axe.min.js").read_text("utf-8"))
    script = "const done = arguments[0]; axe.run(document, {resultTypes: ['violations']}).then((r) => done(r.violations.map((v) => v.id)))"
    assert browser.driver.execute_async_script(script) == []


def test_a_print_shows_every_figure(browser: Browser, tmp_path: Path) -> None:
    pypdf = pytest.importorskip("pypdf", reason="pypdf is not installed (it is in the extra test)")
    publish(certificate(tmp_path / "c.json", ("women", "men", "others")), tmp_path / "out")
    browser.open(tmp_path / "out" / "index.html", scripts=False)
    words = ""
    for _ in range(20):  # a busy browser may print a page before it is laid out
        printed = browser.driver.execute_cdp_cmd("Page.printToPDF", {"paperWidth": 8.27, "paperHeight": 11.69})
        text = " ".join(page.extract_text() for page in pypdf.PdfReader(io.BytesIO(base64.b64decode(printed["data"]))).pages)
        words = " ".join(text.replace("\u00a0", " ").split())
        if words:
            break
    with (tmp_path / "out" / "table.csv").open(encoding="utf-8") as file:
        for row in csv.DictReader(file):
            for name in ("applicants", "selected", "rate", "ratio", "standard_deviations", "shortfall"):
                assert row[name] in words
    assert "How to verify this" in words and "http" not in words


def test_the_source_is_read_once(tmp_path: Path) -> None:
    path = certificate(tmp_path / "c.json", ("f", "m"))
    source = read_source(path)
    path.unlink()
    assert source.raw and next(source.lines)["groups"] == [["f"], ["m"]]
