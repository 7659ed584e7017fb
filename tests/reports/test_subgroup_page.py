"""Reports of certificates of the most unequal subgroups."""

from __future__ import annotations

import re
from html.parser import HTMLParser
from pathlib import Path
from random import Random

import pytest
from subgroup_oracle import Case, random_case, worst

import fairaudit as fa
from fairaudit.cli import main
from fairaudit.errors import FalseCertificate


class Page(HTMLParser):
    """Elements that stand on a page, and where the pictures put their dots."""

    def __init__(self, text: str) -> None:
        super().__init__()
        self.tags: list[str] = []
        self.dots: list[float] = []
        self.feed(text)

    def handle_starttag(self, tag: str, attributes: list[tuple[str, str | None]]) -> None:
        given = dict(attributes)
        self.tags.append("track" if given.get("class") == "track" else tag)
        if tag == "circle" and "dot" in (given["class"] or "") and (given["cx"] or "").endswith("%"):
            self.dots.append(float((given["cx"] or "").removesuffix("%")))


def found(case: Case, **options: object) -> fa.Subgroups:
    return fa.subgroups(
        case.columns,
        decision="got",
        attributes=case.attributes,
        utility=case.worth,
        depth=case.depth,
        min_rows=case.least,
        top=case.keep,
        **options,  # type: ignore[arg-type]
    )


def cases(seed: str, number: int) -> list[Case]:
    rng = Random(seed)
    made = [random_case(rng) for _ in range(3 * number)]
    return [case for case in made if worst(case)][:number]


@pytest.mark.parametrize("confidence", [None, 0.9])
def test_a_page_shows_what_the_certificate_states(confidence: float | None) -> None:
    for case in cases("pages", 20):
        made = found(case, confidence=confidence, max_ratio=2)
        text = fa.report(made.certificate)
        page = Page(text)
        assert page.tags.count("script") == 1  # the certificate itself, which is data
        assert len(page.dots) == page.tags.count("track") == len(made.found)
        scale = max([abs(100 * float(one.mean) / dot) for one, dot in zip(made.found, page.dots, strict=True) if dot > 1], default=1)
        for one, dot in zip(made.found, page.dots, strict=True):
            assert abs(dot - 100 * float(one.mean) / scale) < 1.5
            assert f'title="{one.ratio}"' in text
        assert all(0 <= dot <= 100 for dot in page.dots)
        assert made.verdict in text
        assert ("hold for all" in text) == (confidence is not None)
        assert fa.verify(text.encode("utf-8")).ok


def test_labels_are_data() -> None:
    evil = "<script>alert(1)</script>"
    log = {evil: [evil, evil, "x", "x"], "out": ["y", "n"] * 2, "n": [3, 1, 2, 2]}
    made = fa.subgroups(log, decision="out", attributes=evil, utility="y", count="n")
    assert evil not in fa.report(made.certificate)
    assert evil not in re.sub("`+[^`]*`+", "", fa.report(made.certificate, format="markdown"))


def test_markdown_has_the_exact_ratios() -> None:
    for case in cases("markdown", 5):
        made = found(case)
        text = fa.report(made.certificate, format="markdown")
        assert all(f"| {one.ratio} |" in text for one in made.found)
        assert all(sentence in text for claim in made.certificate.document["claims"] for sentence in claim["assumptions"])


def test_a_false_certificate_gets_no_page(tmp_path: Path) -> None:
    document = found(cases("false", 1)[0]).certificate.document
    document["findings"][0]["rows"] += 1
    with pytest.raises(FalseCertificate, match="no report was written"):
        fa.report(document, tmp_path / "page.html")
    assert not (tmp_path / "page.html").exists()


def test_the_command_writes_a_page(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (tmp_path / "log.csv").write_text("sex,hired\n" + "f,yes\nf,no\nm,yes\nm,yes\n" * 30)
    given = ["subgroups", str(tmp_path / "log.csv"), "--decision", "hired", "--attributes", "sex", "--utility", "yes"]
    assert main([*given, "--report", str(tmp_path / "page.html"), "-o", str(tmp_path / "c.json")]) == 0
    assert main(["report", str(tmp_path / "c.json"), "-o", str(tmp_path / "again.html")]) == 0
    assert (tmp_path / "page.html").read_text() == (tmp_path / "again.html").read_text()
    capsys.readouterr()
