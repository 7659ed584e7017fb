"""A report for the public is the same whatever the withheld counts are, and holds nothing of the certificate."""

from __future__ import annotations

import io
import json
import random
from dataclasses import replace
from fractions import Fraction
from html.parser import HTMLParser
from pathlib import Path
from typing import Any

import pytest
import tiers

import fairaudit as fa
from fairaudit.certificates.certificate import Certificate
from fairaudit.cli import main
from fairaudit.errors import InputError
from fairaudit.publications.counts import Source, decisions_of
from fairaudit.publications.folder import page
from fairaudit.publications.four_fifths import four_fifths
from fairaudit.publications.public_report import private, public_files, public_markdown, public_report
from fairaudit.publications.withholding import by_label, withholding_of

TABLES = 1_000 if tiers.FULL else 150

Cells = dict[tuple[str, str], tuple[int, int]]
"""By context and group, how often yes and no."""


def source_of(cells: Cells, *, zeros: bool = True, **limits: Any) -> Source:
    """A certificate of these counts without its table, as `certify --no-table --confidence none` writes it, and the table.

    Without `zeros` the table that is counted has no rows for what never happened, as that of a query has not.
    """
    rows = [(x, g, word, n) for (x, g), pair in cells.items() for word, n in zip(("yes", "no"), pair, strict=True) if zeros or n]
    columns = dict(zip(("site", "group", "hired", "n"), map(list, zip(*rows, strict=True)), strict=True))
    chosen: dict[str, Any] = {"confidence": None, "embed_table": False, "utility": "yes"} | limits
    made = fa.audit(columns, decision="hired", group="group", context="site", count="n", **chosen).certificate
    table = b"" if made.table is None else b"".join(made.table.lines())
    return Source(made.document, made.text.encode(), table or None, "")


def said(source: Source, least: int) -> tuple[Any, str]:
    """Everything that is published, without the digest, which is random."""
    made = public_report(source, least)
    digest = source.document["subject"]["table"]["sha256"]
    return made, public_markdown(made, source, least).replace(digest, "")


def sums_of(cells: Cells, group: str) -> tuple[int, int]:
    pairs = [pair for (_, g), pair in cells.items() if g == group]
    return sum(s for s, _ in pairs), sum(u for _, u in pairs)


def test_whatever_the_withheld_counts_are_the_report_is_the_same() -> None:
    """Every value below the least one, of those selected and of those not, of every withheld group, with limits and contexts."""
    rng = random.Random(tiers.fresh(0))
    changed = 0
    for _ in range(TABLES):
        least = rng.choice((2, 4, 10))
        groups = [f"g{i}" for i in range(rng.randint(2, 5))]
        sites = ("a", "b")[: rng.randint(1, 2)]
        cells = {(x, g): (rng.randint(0, rng.choice((3, 40))), 1 + rng.randint(0, rng.choice((3, 40)))) for x in sites for g in groups}
        limits = {rng.choice(("max_global_ratio", "max_local_ratio", "max_global_log")): rng.choice(("5/4", "3/2", "3"))}
        before = said(source_of(cells, **limits), least)
        for group in groups:
            if min(sums_of(cells, group)) >= least:
                continue
            assert any(row == (group, *["withheld"] * 4) for row in before[0].sections[0].tables[0].rows)
            value, other = rng.randrange(least), rng.randint(1, 50)
            for pair in ((value, other), (other, value)):
                altered = cells | {(x, group): (0, 0) for x in sites} | {(sites[0], group): pair}
                assert said(source_of(altered, **limits), least) == before
                changed += 1
    assert tiers.enough(changed > TABLES)


@pytest.mark.parametrize("group", ["a", "z"])
def test_the_order_of_a_table_without_zeros_tells_nothing(group: str) -> None:
    """The first group of the table is withheld; which kind of decision comes first in it, and of which site, is not to be seen."""
    others = {("s", "m"): (60, 20), ("t", "m"): (30, 45), ("s", "n"): (40, 60), ("t", "n"): (20, 30)}
    rules, reports = set(), set()
    for counts in (((3, 5), (2, 1)), ((0, 5), (3, 1)), ((0, 5), (0, 0)), ((7, 0), (0, 6)), ((0, 0), (9, 9))):
        source = source_of({(site, group): pair for site, pair in zip("st", counts, strict=True)} | others, zeros=False)
        reports.add(said(source, 10)[1])
        decisions = by_label(decisions_of(source))
        found = four_fifths(decisions, ["yes"], (), withholding_of(decisions.selected(["yes"]), [("group",)], 10))
        rules.add(repr(found))
        assert [row[1] for row in found.rows] == ["m", "n", group]
    assert len(rules) == len(reports) == 1


def test_counts_of_contexts_can_be_anything_below_the_least_one() -> None:
    """Both groups are shown, with one small context each, which their sums do not tell."""
    cells = {("a", "f"): (3, 20), ("b", "f"): (40, 30), ("a", "m"): (30, 20), ("b", "m"): (40, 4)}
    before = said(source_of(cells, max_local_ratio="5/4", max_global_ratio="5/4"), 10)
    assert "not said here" in before[1]
    for value in range(10):
        altered = cells | {("a", "f"): (value, 20), ("b", "f"): (43 - value, 30)}
        assert said(source_of(altered, max_local_ratio="5/4", max_global_ratio="5/4"), 10) == before


class Reader(HTMLParser):
    """Rows of tables."""

    def __init__(self) -> None:
        super().__init__()
        self.rows: list[list[str]] = []
        self.inside = False

    def handle_starttag(self, tag: str, attrs: Any) -> None:  # noqa: ARG002
        if tag == "tr":
            self.rows.append([])
        if tag in ("td", "th"):
            self.rows[-1].append("")
            self.inside = True

    def handle_endtag(self, tag: str) -> None:
        self.inside = self.inside and tag not in ("td", "th")

    def handle_data(self, data: str) -> None:
        if self.inside:
            self.rows[-1][-1] += data.replace("\N{NO-BREAK SPACE}", " ")


CELLS: Cells = {("a", "f"): (60, 20), ("a", "m"): (30, 45), ("a", "x"): (3, 21), ("a", "y"): (0, 7)}


def test_the_page_shows_the_large_groups_exactly_and_of_the_others_nothing() -> None:
    source = source_of(CELLS)
    reader = Reader()
    text = page(public_report(source, 10), source, private(10))
    reader.feed(text)
    rows = [row for row in reader.rows if len(row) == 5][1:]
    assert rows == [
        ["f", "80", "60", "75.0 %", "1.000"],
        ["m", "75", "30", "40.0 %", "0.533"],
        ["x", *["withheld"] * 4],
        ["y", *["withheld"] * 4],
    ]
    assert "2 of 4 groups are withheld" in text and "cannot recompute" in text
    assert str(source.document["subject"]["table"]["sha256"]) in text
    assert source.sha256 not in text and "<script" not in text and "fairaudit-certificate" not in text


@pytest.mark.parametrize("number", ["186", "24", "93", "statements"])
def test_neither_totals_nor_the_number_of_statements_are_said(number: str) -> None:
    """186 decisions of all groups, 24 of the third; how many statements a certificate has depends on what is empty in it."""
    assert number not in said(source_of(CELLS), 10)[1].replace("every statement", "")


def test_a_verdict_is_said_where_the_groups_shown_determine_it() -> None:
    assert "exceeds the limit, judged for the table itself" in said(source_of(CELLS, max_global_ratio="3/2"), 10)[1]
    hidden_only = said(source_of(CELLS, max_global_ratio=2), 10)[1]  # 15/8 between those shown, more with a withheld one
    assert "exceeds the limit" not in hidden_only and "not said here" in hidden_only
    large = {("a", "f"): (60, 20), ("a", "m"): (30, 45)}
    assert "within the limit" in said(source_of(large, max_local_ratio=2), 10)[1]
    assert "none was set" in said(source_of(large), 10)[1]


def test_a_burden_is_compared_with_the_lowest_rate_shown() -> None:
    made = public_report(source_of(CELLS, burden=True), 10)
    assert [row[4] for row in made.sections[0].tables[0].rows[:2]] == ["1.875", "1.000"]


def test_people_of_unknown_group_are_shown_or_withheld_by_themselves() -> None:
    columns = {"hired": ["yes", "no"] * 3, "group": ["f", "f", "m", "m", "", ""], "n": [60, 20, 30, 45, 12, 9]}
    made = fa.audit(
        columns, decision="hired", group="group", count="n", utility="yes", missing="unknown", confidence=None, embed_table=False
    ).certificate
    assert made.table is not None
    source = Source(made.document, made.text.encode(), b"".join(made.table.lines()), "")
    assert decisions_of(source).unknown in ((12, 9), (9, 12))
    assert ("Group unknown", "withheld") in public_report(source, 10).facts
    assert any(name == "Group unknown" and text.startswith("21 more") for name, text in public_report(source, 9).facts)


def test_certificates_whose_digest_could_be_guessed_are_refused() -> None:
    with pytest.raises(InputError, match="holds its table"):
        public_report(source_of(CELLS, embed_table=True), 10)
    source = source_of(CELLS)
    head, _, rows = (source.table or b"").partition(b"\n")
    header = {key: value for key, value in json.loads(head).items() if key != "salt"}
    with pytest.raises(InputError, match="has no salt"):
        public_report(replace(source, table=json.dumps(header).encode() + b"\n" + rows), 10)
    with pytest.raises(InputError, match="withholds nothing"):
        public_report(source, 1)
    with pytest.raises(InputError, match="worth 0 or 1"):
        public_report(source_of(CELLS, utility={"yes": 2, "no": 1}), 10)
    with pytest.raises(InputError, match="the certificate itself"):
        public_files(source, 10, ["public.json"])


def test_labels_are_text(tmp_path: Path) -> None:
    label = "<script>alert(1)</script>|‮www.example.com"
    source = source_of({("a", label): (60, 20), ("a", "m"): (30, 45)})
    made = public_report(source, 10)
    assert "<script" not in page(made, source, private(10)) and "‮" not in page(made, source, private(10))
    assert "<script" not in public_markdown(made, source, 10) and "‮" not in public_markdown(made, source, 10)


def test_the_command_writes_pages_that_hold_no_certificate(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    pypdf = pytest.importorskip("pypdf")
    source = source_of(CELLS, max_global_ratio="3/2")
    certificate, table = tmp_path / "c.json", tmp_path / "c.table.jsonl"
    certificate.write_bytes(source.raw)
    table.write_bytes(source.table or b"")
    names = [str(tmp_path / name) for name in ("p.html", "p.md", "p.pdf")]
    given = ["report", str(certificate), "--table", str(table), "--small", "10"]
    assert main([*given, *(word for name in names for word in ("-o", name))]) == 0
    assert Path(names[0]).read_text() == page(public_report(source, 10), source, private(10))
    pdf = pypdf.PdfReader(io.BytesIO(Path(names[2]).read_bytes()))
    printed = "".join(page.extract_text() for page in pdf.pages)
    assert not pdf.attachments and "withheld" in printed and "cannot recompute" in printed
    assert main([*given, "--format", "markdown"]) == 0
    assert capsys.readouterr().out.strip() == Path(names[1]).read_text().strip()
    for refused, code in ((["report", str(certificate), "--small", "10"], 3), ([*given, "-o", str(tmp_path / "again.json")], 2)):
        assert main(refused) == code
        assert capsys.readouterr().err.startswith("fairaudit: ")
    assert not (tmp_path / "again.json").exists()
    false = json.loads(source.raw)
    false["verdict"] = "within"
    certificate.write_text(Certificate(false).text)
    assert main([*given, "-o", str(tmp_path / "no.html")]) == 1 and not (tmp_path / "no.html").exists()


def test_rates_are_those_of_the_counts_beside_them() -> None:
    made = public_report(source_of(CELLS), 10)
    for row in made.sections[0].tables[0].rows:
        if row[1] != "withheld":
            exact = Fraction(int(row[2]), int(row[1]))
            assert abs(Fraction(row[3].removesuffix(" %")) / 100 - exact) <= Fraction(1, 2000)


def test_two_columns_are_withheld_as_in_the_default_tables_of_a_rule() -> None:
    """Margins beside cells that another page shows would tell the one that both withhold."""
    rng = random.Random(tiers.fresh(5))
    for _ in range(20):
        cells = {(sex, race): [rng.randint(0, rng.choice((9, 60))) for _ in range(2)] for sex in "fm" for race in "abc"}
        rows = [
            (sex, race, word, n)
            for (sex, race), pair in cells.items()
            for word, n in zip(("yes", "no"), (pair[0], pair[1] + 1), strict=True)
        ]
        columns = dict(zip(("sex", "race", "hired", "n"), map(list, zip(*rows, strict=True)), strict=True))
        made = fa.audit(
            columns, decision="hired", group=["sex", "race"], count="n", utility="yes", confidence=None, embed_table=False
        ).certificate
        assert made.table is not None
        source = Source(made.document, made.text.encode(), b"".join(made.table.lines()), "")
        decisions = decisions_of(source)
        rule = four_fifths(decisions, ["yes"], (), withholding_of(decisions.selected(["yes"]), [("sex",), ("race",), ("sex", "race")], 10))
        hidden = [{row[0] for row in table.rows if row[-1] == "withheld"} for table in public_report(source, 10).sections[0].tables]
        by_rule = [{row[0] for row in section.tables[0].rows if row[-1] == "withheld"} for section in rule.page.sections[:3]]
        assert hidden == by_rule


def test_fractions_given_the_true_label_are_small_like_whole_counts(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    cells = [("yes", "f", "yes", 30), ("yes", "f", "no", 30), ("no", "f", "yes", 30), ("no", "f", "no", 30)]
    cells += [("yes", "m", "yes", "40.5"), ("yes", "m", "no", "20.5"), ("no", "m", "yes", 30), ("no", "m", "no", 30)]
    (tmp_path / "t.csv").write_text("u,g,t,n\n" + "".join(",".join(map(str, cell)) + "\n" for cell in cells))
    words = ["--decision", "u", "--group", "g", "--truth", "t", "--count", "n", "--utility", "yes", "--no-table", "--confidence", "none"]
    assert main(["certify", str(tmp_path / "t.csv"), *words, "-o", str(tmp_path / "c.json")]) == 0
    capsys.readouterr()
    given = ["report", str(tmp_path / "c.json"), "--table", str(tmp_path / "c.table.jsonl"), "--format", "markdown"]
    assert main([*given, "--small", "3"]) == 0 and "61" in capsys.readouterr().out
