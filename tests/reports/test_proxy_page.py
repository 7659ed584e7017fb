"""Reports of certificates about groups that nobody recorded."""

from __future__ import annotations

import random
from html.parser import HTMLParser
from pathlib import Path
from typing import Any

import pytest
from proxy_certificates import every_kind, proxied

import fairaudit as fa
from fairaudit.errors import FalseCertificate


class Tags(HTMLParser):
    """Elements that stand on a page."""

    def __init__(self) -> None:
        super().__init__()
        self.found: list[str] = []

    def handle_starttag(self, tag: str, attributes: list[tuple[str, str | None]]) -> None:
        self.found.append("track" if ("class", "track") in attributes else tag)


def test_pages_say_what_the_certificate_does() -> None:
    for made in every_kind():
        page = fa.report(made.certificate)
        assert "sampling error comes on top" in page
        assert "statements are true of the table" in page
        assert made.verdict in page
        for text in made.assumptions:
            assert text in page
        tags = Tags()
        tags.feed(page)
        assert tags.found.count("script") == 1  # the certificate itself, which is data
        assert fa.verify(page.encode("utf-8")).ok
        bars = sum(len(found.groups) + len(found.ends.pairs) for found in made.local)
        bars += len(made.global_.groups) + len(made.global_.ends.pairs) if made.context and made.global_ else 0
        assert tags.found.count("track") == bars


def test_labels_are_data() -> None:
    evil = "<script>alert(1)</script>"
    log = {evil: [evil, evil, "x", "x"], "out": ["y", "n"] * 2, "n": [3, 1, 2, 2]}
    given = {evil: [evil, evil, "x", "x"], "sex": [evil, "m"] * 2, "probability": ["1/2", "1/2", "1/4", "3/4"]}
    made: Any = fa.audit(log, decision="out", group="sex", context=evil, count="n", utility="y", group_probability=given)
    for format_ in ("html", "markdown"):
        assert evil not in fa.report(made.certificate, format=format_)  # type: ignore[arg-type]


def test_markdown_has_the_exact_ends() -> None:
    made = proxied(random.Random(0), 2)
    text = fa.report(made.certificate, format="markdown")
    low, high = made.local[0].ends.means[0]
    assert f"{low} to {high}" in text


def test_a_false_certificate_gets_no_page(tmp_path: Path) -> None:
    document = proxied(random.Random(0), 2).certificate.document
    document["local"][0]["greatest"]["ratio"] = "1"
    with pytest.raises(FalseCertificate):
        fa.report(document, tmp_path / "page.html")
    assert not (tmp_path / "page.html").exists()


def test_a_certificate_without_its_table_is_marked_as_not_checked() -> None:
    made = proxied(random.Random(0), 2, embed=False).certificate
    assert "Not checked" in fa.report(made.document)
    assert "Not checked" not in fa.report(made)
