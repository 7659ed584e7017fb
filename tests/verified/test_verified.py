"""`verify`, `compare` and `report` ask the checker first, whatever form the certificate has."""

from __future__ import annotations

import copy
import json
from pathlib import Path
from typing import Any

import pytest

import fairaudit as fa
from fairaudit.cli import main

COUNTS = {"hired": ["yes", "no", "yes", "no"], "sex": ["f", "f", "m", "m"], "n": [300, 100, 200, 200]}


def made(**options: Any) -> fa.Result:
    return fa.audit(COUNTS, decision="hired", group="sex", count="n", utility="yes", **options)


def altered(result: fa.Result) -> dict[str, Any]:
    document = copy.deepcopy(result.certificate.document)
    document["metrics"]["local"]["ratio"] = "9"
    return document


def test_every_form_of_a_certificate_is_checked(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    result = made(max_local_ratio=2)
    path = tmp_path / "certificate.json"
    result.save(path)
    assert main(["verify", str(path), "--verbose"]) == 0
    lines = capsys.readouterr().out.splitlines()
    document = result.certificate.document
    for form in (result, result.certificate, document, result.certificate.text.encode(), path, str(path)):
        found = fa.verify(form)
        assert found.ok
        assert bool(found)
        assert found.exit_code == 0
        said = [f"true   {finding.statement}" for finding in found.findings]
        assert said == [line.partition(" (rests on ")[0] for line in lines[lines.index("Statements") + 1 :]]
        assert found.sentence == f"all {len(said)} statements are true of the table; the stated verdict is 'within'"
    assert result.verify() == fa.verify(path)


def test_what_is_false_is_found(tmp_path: Path) -> None:
    document = altered(made())
    found = fa.verify(document)
    assert not found.ok
    assert found.exit_code == 1
    assert found.false
    assert "FALSE" in found.sentence
    with pytest.raises(fa.FalseCertificate):
        found.require()
    for call in (lambda: fa.report(document, tmp_path / "x.md", format="markdown"), lambda: fa.compare(made(), document)):
        with pytest.raises(fa.FalseCertificate, match="statements are FALSE, the first"):
            call()
    assert not (tmp_path / "x.md").exists()


def test_a_verdict_can_be_required() -> None:
    assert fa.verify(made(max_local_ratio=2), require="within").require().verdict == "within"
    found = fa.verify(made(max_local_ratio="5/4"), require="within")
    assert (found.ok, found.false, found.verdict, found.exit_code) == (False, (), "exceeds", 1)
    assert found.sentence.endswith("'within' is required")
    with pytest.raises(fa.InputError, match="'within' is"):
        fa.verify(made(), require="exceeds")  # type: ignore[arg-type]


def test_a_table_that_is_not_embedded(tmp_path: Path) -> None:
    result = made(confidence=None, embed_table=False)
    path, table = result.save(tmp_path / "c.json")
    assert result.verify().ok  # it is at hand
    assert fa.verify(path, table).ok
    with pytest.raises(fa.TableNeeded, match="does not hold its table"):
        fa.verify(path)
    with pytest.raises(fa.TableNeeded):
        fa.verify(result.certificate.document)
    with pytest.raises(fa.InputError, match="cannot be read"):
        fa.verify(path, tmp_path / "no-such.jsonl")
    assert "was not checked" in " ".join(fa.compare(path, path).notes)
    assert "not checked" in fa.report(path, format="markdown")
    assert "not checked" not in fa.report(path, format="markdown", table=table).splitlines()[0]


@pytest.mark.parametrize("form", [b"{", b"[]", {}, {"format": "other"}, 3, None, "no-such.json"])
def test_what_is_no_certificate_is_refused_in_a_sentence(form: Any) -> None:
    for call in (fa.verify, fa.report, lambda one: fa.compare(one, one)):
        with pytest.raises(fa.InputError):
            call(form)


def test_reports_are_those_of_the_command(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    result = made(max_local_ratio="5/4")
    path = tmp_path / "c.json"
    result.save(path)
    for kind in ("markdown", "html"):
        ending = {"markdown": "md", "html": "html"}[kind]
        assert main(["report", str(path), "--format", kind, "-o", str(tmp_path / f"by-command.{ending}")]) == 0
        text = fa.report(result, tmp_path / f"here.{ending}", format=kind)  # type: ignore[arg-type]
        assert text == (tmp_path / f"here.{ending}").read_text("utf-8") == (tmp_path / f"by-command.{ending}").read_text("utf-8")
        assert result.report(format=kind) == text  # type: ignore[arg-type]
    capsys.readouterr()
    with pytest.raises(fa.InputError, match="is the certificate itself"):
        fa.report(path, path)
    with pytest.raises(fa.InputError, match=r"needs a path that ends in \.pdf"):
        fa.report(path, format="pdf")
    with pytest.raises(fa.InputError, match="format='docx' is not accepted"):
        fa.report(path, format="docx")  # type: ignore[arg-type]
    with pytest.raises(fa.InputError, match=r"does not go with .*page\.html"):
        fa.report(path, tmp_path / "page.html", format="markdown")


@pytest.mark.parametrize("picture", ["expectations", "ratios", "bounds"])
def test_pictures_are_drawn(picture: Any, tmp_path: Path) -> None:
    result = made(max_local_ratio="5/4")
    axes = result.plot(tmp_path / "x.svg", picture=picture)
    assert axes.figure is not None
    assert (tmp_path / "x.svg").read_bytes().startswith(b"<?xml")
    with pytest.raises(fa.InputError, match="there is no picture 'pie'"):
        result.plot(picture="pie")  # type: ignore[arg-type]


def test_comparisons() -> None:
    before, after = made(max_local_ratio=2), made(max_local_ratio="5/4")
    found = fa.compare(before, after)
    assert (found.verdict.old, found.verdict.new, found.worse) == ("within", "exceeds", True)
    assert not fa.compare(before, before).worse
    with pytest.raises(fa.InputError, match="cannot be compared"):
        fa.compare(before, fa.audit({**COUNTS, "age": COUNTS["sex"]}, decision="hired", group="age", count="n", utility="yes"))


def test_a_page_is_checked_by_the_certificate_in_it(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    pytest.importorskip("jinja2")
    path, certificate = tmp_path / "page.html", tmp_path / "certificate.json"
    labels = {**COUNTS, "hired": ["yes</script>", "no", "yes</script>", "no"]}
    result = fa.audit(labels, decision="hired", group="sex", count="n", utility={"yes</script>": 1}, max_local_ratio="5/4")
    result.save(certificate)
    fa.report(result, path)
    assert main(["verify", str(path)]) == 0
    of_page = " ".join(capsys.readouterr().out.split())
    assert main(["verify", str(certificate)]) == 0
    of_certificate = " ".join(capsys.readouterr().out.split())
    added = "This is about the certificate in the page; what the page shows besides was not compared with it."
    assert of_page == f"{of_certificate} {added}"
    assert fa.verify(path) == fa.verify(path.read_bytes()) == fa.verify(certificate)
    page = path.read_text()
    inside = '<script type="application/json" id="certificate">'
    head, _, held = page.partition(inside)
    false = tmp_path / "false.html"
    assert '"ratio":"3/2"' in held
    false.write_text(head + inside + held.replace('"ratio":"3/2"', '"ratio":"2"', 1))
    assert not fa.verify(false)
    for odd in (page.replace(inside, "<script>"), page + inside, page[: page.index(inside) + 200], "<!doctype html>", head):
        false.write_text(odd)
        with pytest.raises(fa.InputError, match="the page does not hold one certificate"):
            fa.verify(false)
        assert main(["verify", str(false)]) == 2
        assert "does not hold one certificate" in capsys.readouterr().err


def test_a_notebook_shows_what_is_false() -> None:
    label = "<b>\u202ef"
    made = fa.audit({"hired": ["yes", "no"] * 2, "sex": [label, label, "m", "m"]}, decision="hired", group="sex", utility="yes")
    shown = fa.verify(made)._repr_html_()
    assert shown == f"<p>{fa.verify(made).sentence.replace(chr(39), '&#x27;')}</p>"
    document = json.loads(made.certificate.text)
    document["metrics"]["local"]["ratio"] = "9"
    document["metrics"]["local"]["witness"]["higher"] = {"sex": label}
    shown = fa.verify(document)._repr_html_()
    assert "statements are FALSE" in shown and "<li><bdi>metrics.local.ratio" in shown and "the table gives 1" in shown
    assert "<b>" not in shown and "\u202e" not in shown
    assert "but &#x27;within&#x27; is required" in fa.verify(made, require="within")._repr_html_()
