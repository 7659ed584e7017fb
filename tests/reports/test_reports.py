"""Reports without a browser: what they say, that they load nothing, that labels stay data, and the command."""

from __future__ import annotations

import base64
import hashlib
import json
import os
import re
import subprocess
import sys
import venv
from collections.abc import Callable
from fractions import Fraction
from html.parser import HTMLParser
from math import inf
from pathlib import Path

import pytest
import tiers
from certificate_kinds import FOUR, KINDS, admissions, infinite, small_counts, weighted
from hypothesis import given, settings
from hypothesis import strategies as st

import fairaudit as fa
from fairaudit import checker
from fairaudit.certificates.reader import load, subject
from fairaudit.certificates.table import Table, log_digests
from fairaudit.cli import main as command
from fairaudit.inference.ends import cell_ends
from fairaudit.inference.table_comparisons import local_comparison
from fairaudit.reports.content import describe
from fairaudit.reports.markdown import markdown
from fairaudit.reports.page import html
from fairaudit.testing import laws, utilities


class Page(HTMLParser):
    """Elements with their attributes, the text, and what stands in script and style."""

    def __init__(self, text: str) -> None:
        super().__init__(convert_charrefs=True)
        self.elements: list[tuple[str, dict[str, str | None]]] = []
        self.text: list[str] = []
        self.raw: dict[str, list[str]] = {"script": [], "style": []}
        self.open = ""
        self.feed(text)
        self.close()

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.elements.append((tag, dict(attrs)))
        self.open = tag

    def handle_endtag(self, tag: str) -> None:  # noqa: ARG002
        self.open = ""

    def handle_data(self, data: str) -> None:
        self.raw.get(self.open, self.text).append(data)


# Reading a certificate back


@pytest.mark.parametrize("kind", KINDS)
def test_what_was_written_is_read_back(kind: Callable[..., fa.Result]) -> None:
    document = kind(**FOUR).certificate.document
    found = subject(document)
    assert found is not None
    again = Table(found.law, found.utility, found.deployment, log=log_digests(document["subject"]))
    assert again.sha256 == document["subject"]["table"]["sha256"]


@given(data=st.data())
@settings(max_examples=60)
def test_drawn_tables_are_read_back(data: st.DataObject) -> None:
    law = data.draw(laws(max_contexts=3, max_groups=4, max_decisions=3))
    utility = data.draw(utilities(law))
    try:
        result = fa.certify(law, utility, confidence=None)
    except fa.InputError:
        return
    found = subject(result.certificate.document)
    assert found is not None
    assert Table(found.law, found.utility).sha256 == result.certificate.document["subject"]["table"]["sha256"]
    assert "<h2" in html(result.certificate) and markdown(result.certificate).startswith("## ")


def test_a_sampled_policy_is_read_back() -> None:
    rows = {"u": ["y", "n"] * 2, "a": ["f", "f", "m", "m"], "n": [30, 10, 20, 20]}
    deployed = fa.Policy.from_counts(rows, decision="u", group="a", count="n").behind(
        group=fa.RandomizedResponse("fm", keep_probability="0.8"), population=[[2, 3]]
    )
    result = fa.certify(deployed, {"y": 1}, max_local_ratio=2)
    found = subject(result.certificate.document)
    assert found is not None and found.deployment is not None
    assert (
        Table(found.deployment.policy.law, found.utility, found.deployment).sha256
        == result.certificate.document["subject"]["table"]["sha256"]
    )
    ends = describe(result.certificate.document).panels[0].members[0].ends
    assert ends is not None and ends[0].value < Fraction(7, 10) < ends[1].value  # 0.8 · 3/4 + 0.2 · 1/2


def test_units_are_read_back() -> None:
    log = {"a": list("ffmm") * 5, "u": ["yes", "no", "no", "no"] * 5, "run": [i // 2 for i in range(20)]}
    result = fa.certify(fa.Law.from_log(log, decision="u", group="a", unit="run"), {"yes": 1})
    content = describe(result.certificate.document)
    member = content.panels[0].members[0]
    assert content.expectations is not None and member.ends is not None
    cell = result.comparisons["local"].cells[0]
    assert (member.ends[0].value, member.ends[1].value) == cell_ends(cell, Fraction(1, 40))


# What a report says


def test_figures_of_the_admissions() -> None:
    content = describe(admissions(max_local_ratio="5/4").certificate.document)
    assert content.lead == (
        "In Dept=F, Gender=Female over Gender=Male leaves it open: up to 2.757 times as often in the population, at confidence 95 %; "
        "“Admitted” in 7.038 % of decisions against 5.898 % in the table (n = 341 and 373)."
    )
    assert content.headline == "Inconclusive"
    assert content.panels[0].title == "Dept=A"
    first = content.panels[0].members[0]
    assert (first.label, first.value.exact, first.weight) == ("Gender=Female", "89/108", "108 decisions")
    overall = content.overall
    assert overall is not None and [m.value.exact for m in overall.members] == ["1198/2691", "557/1835"]
    matrix = content.matrices[0]
    assert matrix.ratios[0][1] is not None and matrix.ratios[0][1].exact == "24475/18432" and matrix.ratios[0][0] is None


def test_ends_of_a_ratio_with_a_target_hold_each_by_itself() -> None:
    result = admissions(max_local_ratio=2)
    document = result.certificate.document
    shown = Page(html(result.certificate))
    said = " ".join("".join(shown.text).split())
    assert "In the population: at least 1.044, at most 2.757, each at 95 %" in said
    assert "In the population, at confidence 95 %: 1.290 to 1.670" in said
    assert "the population behind the decisions, one-sided at confidence 95 %" in said
    assert "| at least 1.044, at most 2.757, each at 95 % |" in markdown(document) and "| 1.290 to 1.670 |" in markdown(document)
    notebook = result._repr_html_()
    assert "each end at confidence 19/20</td><td>at least 1.044, at most 2.757</td>" in notebook
    assert "population, at confidence 19/20</td><td>1.290 to 1.670</td>" in notebook
    assert "In the population: at least" not in html(admissions().certificate)


def test_intervals_of_groups_are_those_of_their_draws() -> None:
    result = admissions()
    comparison = local_comparison(result.law, result.utility)
    wanted = {cell.label: cell_ends(cell, Fraction(1, 40)) for cell in comparison.cells}
    panel = describe(result.certificate.document).panels[0]
    for member in panel.members:
        assert member.ends is not None
        assert (member.ends[0].value, member.ends[1].value) == wanted[("A",), (member.label.partition("=")[2],)]


def test_the_ladder_is_sorted_and_complete() -> None:
    law = fa.Policy.from_array([[["0.9", "0.1"], ["0.2", "0.8"]]], decisions=["hire", "pass"], groups=["f", "m"])
    deployed = law.behind(group=fa.RandomizedResponse(["f", "m"], keep_probability="0.75"))
    document = fa.certify(deployed, {"hire": 1}, max_local_log="0.5", declared={"tau": "0.2"}).certificate.document
    content = describe(document)
    rungs = content.ladders["local"]
    assert [float(r.value) for r in rungs] == sorted(float(r.value) for r in rungs)
    bounds = [c for c in document["claims"] if c["quantity"].startswith("local_ratio") and (c["relation"] == "<=" or c["by"] == "T13")]
    assert len([r for r in rungs if r.kind == "bound"]) == len(bounds)
    assert {r.kind for r in rungs} == {"measured", "unfiltered", "bound", "target"}
    assert {r.scope for r in rungs if r.kind == "bound"} == {c["scope"] for c in bounds}
    target = next(r for r in rungs if r.kind == "target")
    assert abs(float(target.value) - 2.718281828**0.5) < 1e-6 and target.value.exact == ""  # e^0.5 is no fraction
    found = content.calibration
    assert found is not None and found.target == 0.5 and found.here is not None and found.here[1] == 0.75
    for target_log, kept in found.points:
        assert kept == float(fa.calibrate(max_log=Fraction(target_log).limit_denominator(10**6), groups=2, tau="0.2").keep_probabilities[0])


def test_infinite_and_missing_figures() -> None:
    assert "infinite" in html(infinite().certificate) and describe(infinite().certificate.document).figures[0].value.value == inf  # type: ignore[union-attr]
    law = fa.Law.from_array([[[1, 1], [0, 0]], [[0, 0], [1, 2]]], kind="counts")
    page = html(fa.certify(law, {"0": 1}, confidence=None).certificate)
    assert "not compared" in page and "fewer than two groups" in page


@pytest.mark.parametrize("kind", [small_counts, weighted])
def test_a_report_without_the_table_shows_no_cell(kind: Callable[..., fa.Result]) -> None:
    result = kind(**FOUR, embed_table=False)
    for text in (html(result.certificate), markdown(result.certificate)):
        assert "certificate.table.jsonl" in text
        assert '"rows":[{' not in text and '"weights":[' not in text and "expected utility |" not in text
    assert describe(result.certificate.document).panels == []


# Nothing is loaded, nothing runs but what the policy names


def test_the_page_is_self_contained() -> None:
    page = Page(html(admissions(max_local_ratio="5/4").certificate))
    for tag, attributes in page.elements:
        assert tag not in ("img", "iframe", "object", "embed", "link", "base", "form", "audio", "video")
        assert not {"src", "srcset", "style", "action", "data", "poster", "background"} & attributes.keys()
        assert not [name for name in attributes if name.startswith("on")]
        assert attributes.get("href", "#").startswith("#")  # type: ignore[union-attr]
    assert "url(" not in "".join(page.raw["style"]) and "@import" not in "".join(page.raw["style"])
    for forbidden in ("innerHTML", "eval(", "fetch(", "XMLHttpRequest", "insertAdjacentHTML", "document.write"):
        assert forbidden not in "".join(page.raw["script"])


def test_the_policy_names_exactly_the_style_and_the_script() -> None:
    page = Page(html(admissions().certificate))
    policy = next(a["content"] for _, a in page.elements if a.get("http-equiv") == "Content-Security-Policy")
    assert policy is not None and policy.startswith("default-src 'none'; ")
    (style,), (_, script) = page.raw["style"], page.raw["script"]
    wanted = {f"sha256-{base64.b64encode(hashlib.sha256(text.encode()).digest()).decode()}" for text in (style, script)}
    assert set(re.findall(r"sha256-[A-Za-z0-9+/=]+", policy)) == wanted
    assert "unsafe" not in policy


def test_the_embedded_certificate_is_the_certificate() -> None:
    certificate = admissions().certificate
    embedded = Page(html(certificate)).raw["script"][0]
    assert json.loads(embedded) == certificate.document
    assert checker.check(embedded.encode()).ok


@given(label=st.text(st.characters(exclude_categories=["Cs"]), min_size=1, max_size=30).filter(str.strip))
@settings(max_examples=60)
def test_labels_are_data(label: str) -> None:
    law = fa.Law.from_counts(
        {"u": ["y", "n"] * 2, "a": [label, label, "m m", "m m"], "n": [3, 1, 1, 1]}, decision="u", group="a", count="n"
    )
    result = fa.certify(law, {"y": 1}, max_local_ratio=2, confidence=None)
    plain = Page(
        html(
            fa.certify(
                fa.Law.from_array([[3, 1], [1, 1]], kind="counts", columns=law.columns), {"0": 1}, max_local_ratio=2, confidence=None
            ).certificate
        )
    )
    page = Page(html(result.certificate))
    assert [tag for tag, _ in page.elements] == [tag for tag, _ in plain.elements]
    assert json.loads(page.raw["script"][0]) == result.certificate.document


@given(label=st.text(st.sampled_from("<>[]()*_`~|#@!\\&.:/w=-+1a\n\u202e"), min_size=1, max_size=20).filter(str.strip))
def test_labels_are_data_in_markdown(label: str) -> None:
    law = fa.Law.from_counts(
        {"u": ["y", "n"] * 2, "a": [label, label, "m m", "m m"], "n": [3, 1, 1, 1]}, decision="u", group="a", count="n"
    )
    text = markdown(fa.certify(law, {"y": 1}, max_local_ratio=2, confidence=None).certificate)
    outside = re.sub(r"<code>(?:[ A-Za-z0-9,.=;:]|&#[0-9]+;)*</code>", "", text)
    assert "<" not in outside and "@" not in outside and "www." not in outside and "\u202e" not in text
    rows = [line for line in text.splitlines() if line.startswith("|")]
    assert all(row.count("|") in {other.count("|") for other in rows if "---" in other} for row in rows)


# The command


def test_markdown_lists_groups_from_the_worst_to_the_best_and_says_what_it_leaves_to_the_page() -> None:
    log = {"hired": ["yes", "no"] * 100, "race": [f"r{i // 2 % 25}" for i in range(200)], "dept": [f"d{i // 50}" for i in range(200)]}
    log["hired"] = ["yes" if i % (2 + i // 2 % 25) else "no" for i in range(200)]
    text = fa.report(fa.audit(log, decision="hired", group="race", context="dept", utility="yes"), format="markdown")
    overall = text.split("### What each group gets\n\n")[1].split("\n\n")[0].splitlines()[2:]
    rates = [Fraction(line.split("|")[4].strip()) for line in overall]
    assert len(rates) == 25 and rates == sorted(rates) and rates[0] < rates[-1]
    assert "What groups get in 1 more context stands on the page (.html)." in text


def test_of_a_stream_no_group_gets_an_interval_of_a_single_look(tmp_path: Path) -> None:
    log = tmp_path / "log.jsonl"
    lines = [json.dumps({"u": "yes" if i % 3 or i % 2 else "no", "a": "fm"[i % 2]}) for i in range(120)]
    log.write_text("".join(f"{line}\n" for line in lines))
    watch = ["monitor", str(log), "--state", str(tmp_path / "w.db"), "--decision", "u", "--group", "a", "--utility", "yes"]
    assert command([*watch, "--max-local-ratio", "90"]) in (0, 3)
    page = tmp_path / "p.html"
    assert command(["certify", "--from-monitor", str(tmp_path / "w.db"), "-o", str(tmp_path / "c.json"), "--report", str(page)]) in (0, 3)
    document, _ = load(tmp_path / "c.json")
    assert document["intervals"]["local"]["method"] == "betting"
    content = describe(document)
    assert [m.ends for m in content.panels[0].members] == [None, None] and content.figures[0].sure is not None
    assert "every moment of the stream" in page.read_text("utf-8")
    assert command(["certify", "--from-monitor", str(tmp_path / "w.db"), "--report", str(tmp_path)]) == 2


@pytest.fixture
def certificate(tmp_path: Path) -> Path:
    path = tmp_path / "c.json"
    admissions(max_local_ratio="5/4").certificate.save(path)
    return path


def test_the_command_writes_a_page(certificate: Path, tmp_path: Path) -> None:
    page = tmp_path / "page.html"
    assert command(["report", str(certificate), "-o", str(page)]) == 0
    assert "all 45 statements are true" in page.read_text("utf-8") or "statements are true of the table" in page.read_text("utf-8")


def test_the_command_writes_markdown(certificate: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert command(["report", str(certificate), "--format", "markdown"]) == 0
    assert capsys.readouterr().out.startswith("## Fairness audit: inconclusive\n")


def test_a_false_certificate_gets_no_report(certificate: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    document = json.loads(certificate.read_text())
    document["metrics"]["local"]["ratio"] = "5/4"
    certificate.write_text(json.dumps(document))
    assert command(["report", str(certificate), "-o", str(tmp_path / "page.html")]) == 1
    assert not (tmp_path / "page.html").exists()
    assert "FALSE" in capsys.readouterr().err


@pytest.mark.parametrize("text", ["", "{", "[]", '{"format": "fairaudit-certificate/1"}', '{"format": "other"}', "\u00ff"])
def test_what_is_no_certificate_is_refused(text: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = tmp_path / "c.json"
    path.write_text(text, "utf-8")
    assert command(["report", str(path), "-o", str(tmp_path / "page.html")]) == 2
    said = capsys.readouterr().err
    assert said.count("\n") == 1 and "certificate" in said and not (tmp_path / "page.html").exists()


def test_bad_outputs_are_refused(certificate: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    before = certificate.read_bytes()
    assert command(["report", str(certificate), "-o", str(certificate)]) == 2
    assert command(["report", str(certificate), "-o", str(tmp_path / "no" / "page.html")]) == 2
    assert command(["report", str(tmp_path / "absent.json")]) == 2
    assert certificate.read_bytes() == before
    assert len(capsys.readouterr().err.splitlines()) == 3


def test_certify_writes_a_page(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    page = tmp_path / "page.html"
    assert command(["certify", "--example", "ucb-admissions", "--report", str(page)]) == 0
    assert "24475/18432" in page.read_text("utf-8")
    assert command(["certify", "--example", "ucb-admissions", "--report", str(page), "-o", str(page)]) == 2
    assert command(["certify", "--example", "ucb-admissions", "--report", str(tmp_path)]) == 2


def test_a_table_in_a_file_is_checked_and_stays_there(tmp_path: Path) -> None:
    path, page = tmp_path / "c.json", tmp_path / "page.html"
    small_counts(**FOUR, embed_table=False).certificate.save(path)
    assert command(["report", str(path), "-o", str(page)]) == 0
    text = page.read_text("utf-8")
    assert "repeated unchecked" in text and "Not checked: " in text and ' unchecked">' in text
    assert command(["report", str(path), "-o", str(page.with_suffix(".md"))]) == 0
    assert page.with_suffix(".md").read_text("utf-8").startswith("## Fairness audit, not checked: ")
    assert command(["report", str(path), "-o", str(page), "--table", str(tmp_path / "c.table.jsonl")]) == 0
    text = page.read_text("utf-8")
    assert "statements are true of the table" in text and '"weights":[' not in text and ' unchecked">' not in text


def test_python_refuses_what_is_no_certificate() -> None:
    for document in ({}, {"subject": 3}, {**admissions().certificate.document, "metrics": {}}):
        for write in (html, markdown):
            with pytest.raises(fa.InputError):
                write(document)


# Without the extras

BLOCKED = """
import sys
class Absent:
    def find_spec(self, name, path=None, target=None):
        if name.partition(".")[0] in {"jinja2", "markupsafe", "matplotlib", "PIL"}:
            raise ImportError(name)
sys.meta_path.insert(0, Absent())
from fairaudit.cli import main
sys.exit(main(sys.argv[1:]))
"""


def blocked(*arguments: str, directory: Path) -> subprocess.CompletedProcess[str]:
    return subprocess.run([sys.executable, "-c", BLOCKED, *arguments], cwd=directory, capture_output=True, text=True, check=False)


def test_without_extras_the_core_works_and_the_rest_says_what_to_install(tmp_path: Path) -> None:
    assert blocked("certify", "--example", "ucb-admissions", "-o", "c.json", directory=tmp_path).returncode == 0
    assert blocked("verify", "c.json", directory=tmp_path).returncode == 0
    assert blocked("calibrate", "--max-log", "0.2", "--groups", "4", "--tau", "0.3", directory=tmp_path).returncode == 0
    assert blocked("compare", "c.json", "c.json", directory=tmp_path).returncode == 0
    assert blocked("report", "c.json", "--format", "markdown", directory=tmp_path).returncode == 0
    for arguments, extra in (
        (("report", "c.json", "-o", "p.html"), "fairaudit-certify[report]"),
        (("certify", "--example", "ucb-admissions", "--report", "p.html"), "fairaudit-certify[report]"),
        (("calibrate", "--max-log", "0.2,0.3", "--groups", "4", "--tau", "0.3", "--plot", "p.png"), "fairaudit-certify[plots]"),
    ):
        done = blocked(*arguments, directory=tmp_path)
        assert done.returncode == 2 and extra in done.stderr and "Traceback" not in done.stderr, done.stderr
        assert not list(tmp_path.glob("p.*"))


@pytest.mark.skipif(not tiers.FULL, reason="installs a clean environment; set FAIRAUDIT_FULL=1")
def test_a_clean_environment_without_extras(tmp_path: Path) -> None:
    root = Path(__file__).resolve().parents[2]
    venv.create(tmp_path / "venv", with_pip=True)
    scripts = tmp_path / "venv" / ("Scripts" if os.name == "nt" else "bin")
    subprocess.run([scripts / "python", "-m", "pip", "install", "-q", str(root)], check=True)

    def run(*arguments: str) -> subprocess.CompletedProcess[str]:
        environment = {key: value for key, value in os.environ.items() if key != "PYTHONPATH"}
        return subprocess.run(
            [scripts / "fairaudit", *arguments], cwd=tmp_path, env=environment, capture_output=True, text=True, check=False
        )

    assert run("certify", "--example", "hr-filtered", "-o", "c.json").returncode == 0
    assert run("verify", "c.json").returncode == 0
    assert run("calibrate", "--max-log", "0.2", "--groups", "4", "--tau", "0.3").returncode == 0
    assert "## Fairness audit" in run("report", "c.json", "--format", "markdown").stdout
    # A solver of cvxpy may have brought jinja2 along.
    subprocess.run([scripts / "python", "-m", "pip", "uninstall", "-q", "-y", "jinja2"], check=True, stderr=subprocess.DEVNULL)
    refused = run("report", "c.json", "-o", "p.html")
    assert refused.returncode == 2 and "fairaudit-certify[report]" in refused.stderr
    assert "fairaudit-certify[plots]" in run("calibrate", "--max-log", "0.2,0.3", "--groups", "4", "--tau", "0.3", "--plot", "p.png").stderr
    subprocess.run([scripts / "python", "-m", "pip", "install", "-q", "jinja2"], check=True)
    assert run("report", "c.json", "-o", "p.html").returncode == 0  # the page's parts are in the wheel
    assert (tmp_path / "p.html").stat().st_size > 50_000


def test_load_keeps_the_bytes(certificate: Path) -> None:
    document, raw = load(certificate)
    assert json.loads(raw) == document
