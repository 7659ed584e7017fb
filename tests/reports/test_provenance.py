"""Who made a certificate, of what, in reports: what was checked stands apart from what is only stated, and what does not fit is refused."""

from __future__ import annotations

import base64
import json
from html.parser import HTMLParser
from pathlib import Path

import pytest
from attested import statement_about, statement_of, written

import fairaudit as fa
from fairaudit.cli import main
from fairaudit.errors import FalseCertificate, InputError
from fairaudit.reports.provenance import TITLE

LOG = {"hired": ["yes", "no", "yes", "no", "yes"], "sex": ["f", "f", "m", "m", ""]}

HOSTILE = "<script>alert(1)</script>\u202e{{ 7 * 7 }} =cmd() [x](http://example.org) @all"


@pytest.fixture
def certificate(tmp_path: Path) -> Path:
    fa.audit(LOG, decision="hired", group="sex", utility="yes", missing="drop", confidence=None).certificate.save(tmp_path / "c.json")
    return tmp_path / "c.json"


class Boxes(HTMLParser):
    """The text of the boxes of a page, by their class, and the names of its elements."""

    def __init__(self, page: str) -> None:
        super().__init__()
        self.depth, self.inside, self.texts, self.tags = 0, "", dict[str, str](), list[str]()
        self.feed(page)

    def handle_starttag(self, tag: str, attributes: list[tuple[str, str | None]]) -> None:
        self.tags.append(tag)
        if tag == "div":
            self.depth += 1
            named = dict(attributes).get("class") or ""
            if named.startswith("told"):
                self.inside = named

    def handle_endtag(self, tag: str) -> None:
        if tag == "div":
            self.inside = ""

    def handle_data(self, data: str) -> None:
        self.texts[self.inside] = self.texts.get(self.inside, "") + data


def test_what_is_stated_stands_apart_from_what_was_checked(certificate: Path) -> None:
    boxes = Boxes(fa.report(certificate, attestation=written(certificate))).texts
    sure, told = boxes["told within"], boxes["told none"]
    assert "byte for byte, under the name certificate.json" in sure
    assert (
        "5 decisions were read, 4 counted, 1 left out (missing label): that adds up, and nothing in the certificate contradicts it" in sure
    )
    assert "is not signed" in sure
    for stated in (
        "Example Audits",
        "Screening of applicants",
        "Screener",
        "4.2",
        "2025-01-01 to 2025-12-31",
        "log.csv",
        "12,003",
        "SELECT 1",
    ):
        assert stated in told
        assert stated not in sure


def test_without_an_attestation_nothing_is_said_of_it(certificate: Path) -> None:
    page = fa.report(certificate)
    assert TITLE not in page
    assert "ask whoever hands it to you" in page
    assert TITLE not in fa.report(certificate, format="markdown")


def test_what_is_not_stated_is_named(certificate: Path) -> None:
    found = statement_of(certificate)
    for key in ("issuer", "title", "system", "period"):
        del found["predicate"][key]
    beside = certificate.with_name("a.json")
    beside.write_text(json.dumps(found))
    said = "Not stated: who issued it, a title, the system, the period of the decisions."
    assert said in fa.report(certificate, attestation=beside)
    assert said in fa.report(certificate, attestation=beside, format="markdown")


def test_a_signature_is_not_said_to_be_checked(certificate: Path) -> None:
    payload = base64.b64encode(json.dumps(statement_of(certificate)).encode()).decode()
    signature = {"sig": base64.b64encode(b"s" * 64).decode()}
    envelope = {"payload": payload, "payloadType": "application/vnd.in-toto+json", "signatures": [signature]}
    page = fa.report(certificate, attestation=json.dumps(envelope).encode())
    assert "in an envelope with a signature, which was not checked" in page
    assert "is not signed" not in page
    command = "fairaudit verify certificate.json --attestation attestation.dsse.json --key SIGNER.pub.pem"
    assert command in page
    for form in ("markdown", "model-card"):
        told = fa.report(certificate, attestation=json.dumps(envelope).encode(), format=form)  # type: ignore[call-overload]
        assert command in told and "Get it from the signer" in told


def test_texts_are_data(certificate: Path) -> None:
    plain = Boxes(fa.report(certificate, attestation=written(certificate)))
    source = {"name": HOSTILE.replace("/", "∕"), "sha256": None, "bytes": None, "rows": None, "query": HOSTILE}
    said = {"title": HOSTILE, "issuer": {"name": HOSTILE}, "command": [HOSTILE], "sources": [source], "versions": {"fairaudit": HOSTILE}}
    changed = written(certificate, **said, options={"unknown": [HOSTILE], "query": HOSTILE})
    page = fa.report(certificate, attestation=changed)
    found = Boxes(page)
    assert set(found.tags) == set(plain.tags)
    assert found.tags.count("script") == plain.tags.count("script")
    assert "\u202e" not in page
    assert "{{ 7 * 7 }}" in found.texts["told none"]
    note = fa.report(certificate, attestation=changed, format="markdown")
    assert "<script" not in note
    assert "\u202e" not in note
    assert "](http" not in note
    assert "@all" not in note


FALSE = {
    "another certificate": lambda s: s["subject"][0]["digest"].update(sha256="0" * 64),
    "another table": lambda s: s["predicate"]["table"].update(sha256="0" * 64),
    "a wrong sum": lambda s: s["predicate"]["rows"].update(read=6),
    "wrong counts that add up": lambda s: s["predicate"]["rows"].update(read=6, counted=5),
    "another reason": lambda s: s["predicate"]["rows"].update(dropped={"unreadable line": 1}),
    "another unit": lambda s: s["predicate"]["rows"].update(unit="rows"),
}


@pytest.mark.parametrize("change", FALSE)
def test_what_does_not_fit_is_refused(change: str, certificate: Path, capsys: pytest.CaptureFixture[str]) -> None:
    found = statement_of(certificate)
    FALSE[change](found)
    beside = certificate.with_name("a.json")
    beside.write_text(json.dumps(found))
    with pytest.raises(FalseCertificate):
        fa.report(certificate, attestation=beside)
    page = certificate.with_name("page.html")
    assert main(["report", str(certificate), "--attestation", str(beside), "-o", str(page)]) == 1
    assert "no report was written" in capsys.readouterr().err
    assert not page.exists()


@pytest.mark.parametrize("change", ["another certificate", "another table", "a wrong sum"])
def test_without_the_table_digests_and_the_sum_are_still_checked(change: str, tmp_path: Path) -> None:
    made = fa.audit(LOG, decision="hired", group="sex", utility="yes", missing="drop", confidence=None, embed_table=False)
    made.certificate.save(tmp_path / "c.json")
    with_rows = {**made.certificate.document, "subject": {**made.certificate.document["subject"]}}
    with_rows["subject"]["table"] = {**with_rows["subject"]["table"], "rows": [{"weights": ["4"]}]}
    found = statement_about(with_rows, (tmp_path / "c.json").read_bytes())
    page = fa.report(tmp_path / "c.json", attestation=json.dumps(found).encode())
    assert "that adds up, and the table, which is not in the certificate, was not compared" in page
    FALSE[change](found)
    with pytest.raises(FalseCertificate):
        fa.report(tmp_path / "c.json", attestation=json.dumps(found).encode())


@pytest.mark.parametrize(("raw", "said"), [(b"", "JSON"), (b"{}", "lacks the key"), (b'{"format": "x"}', "lacks|unknown")])
def test_what_is_no_attestation_is_refused(raw: bytes, said: str, certificate: Path) -> None:
    with pytest.raises(InputError, match=said):
        fa.report(certificate, attestation=raw)


def test_the_command_refuses_to_write_over_the_attestation(certificate: Path, capsys: pytest.CaptureFixture[str]) -> None:
    beside = written(certificate)
    assert main(["report", str(certificate), "--attestation", str(beside), "-o", str(beside)]) == 2
    assert "is the attestation itself" in capsys.readouterr().err
    assert (
        main(["report", str(certificate), "--attestation", str(beside.with_name("none.json")), "-o", str(beside.with_name("p.html"))]) == 2
    )
    assert "none.json cannot be read" in capsys.readouterr().err


def test_certify_shows_it_on_every_page_that_it_writes(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    Path("log.csv").write_text("hired,sex\nyes,f\nno,f\nyes,m\nno,m\n")
    words = ["certify", "log.csv", "--decision", "hired", "--group", "sex", "--utility", "yes", "--issuer", "Example Audits"]
    assert main([*words, "-o", "c.json", "-o", "p.html", "-o", "p.md", "--attest", "a.json"]) == 0
    assert "4 decisions were read, 4 counted, none left out" in Boxes(Path("p.html").read_text()).texts["told within"]
    assert "* Issued by: <code>Example Audits</code>" in Path("p.md").read_text()
    for name, form in (("p.html", "html"), ("p.md", "markdown")):
        assert fa.report("c.json", attestation="a.json", format=form) == Path(name).read_text()  # type: ignore[arg-type]


def test_a_page_of_groups_that_were_not_recorded_shows_it(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    Path("log.csv").write_text("answer,area\n" + "yes,1\nno,1\nyes,2\nno,2\nno,2\n")
    Path("given.csv").write_text("area,race,probability\n1,a,0.9\n1,b,0.1\n2,a,0.2\n2,b,0.8\n")
    words = ["certify", "log.csv", "--decision", "answer", "--group", "race", "--utility", "yes", "--group-probability", "given.csv"]
    assert main([*words, "-o", "c.json", "-o", "p.html", "-o", "p.md", "--attest", "a.json", "--title", "Areas"]) == 0
    assert "Areas" in Boxes(Path("p.html").read_text()).texts["told none"]
    assert TITLE in Path("p.md").read_text()


def test_a_print_has_the_very_files_attached(certificate: Path) -> None:
    pytest.importorskip("weasyprint", reason="WeasyPrint is not installed", exc_type=OSError)
    pypdf = pytest.importorskip("pypdf", reason="pypdf is not installed")
    beside, paper = written(certificate), certificate.with_name("p.pdf")
    fa.report(certificate, paper, attestation=beside)
    found = pypdf.PdfReader(paper)
    held = {name: content[0] for name, content in found.attachments.items()}
    assert held == {"certificate.json": certificate.read_bytes(), "attestation.json": beside.read_bytes()}
    text = " ".join("\n".join(part.extract_text() for part in found.pages).split())
    assert TITLE in text
    assert "fairaudit verify certificate.json --attestation attestation.json" in text


def test_a_model_card_names_the_system_that_is_stated(certificate: Path) -> None:
    card = fa.report(certificate, format="model-card", attestation=written(certificate))
    assert 'name: "Screener 4.2"' in card


def test_a_page_with_small_counts_withheld_has_no_attestation(certificate: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["report", str(certificate), "--attestation", str(written(certificate)), "--small", "5"]) == 2
    assert "--attestation does not go with --small" in capsys.readouterr().err
