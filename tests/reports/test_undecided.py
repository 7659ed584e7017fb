"""What screens and reports say of decisions of unknown meaning."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

import fairaudit as fa
from fairaudit.cli import main
from fairaudit.reports.content import describe
from fairaudit.reports.markdown import markdown
from fairaudit.reports.model_card import model_card
from fairaudit.reports.overview import of_content, of_result
from fairaudit.reports.page import html
from fairaudit.reports.screen import first_screen
from fairaudit.reports.undecided import undecided_lines, undecided_ranges

LOG = {
    "u": ["yes", "no", "refused"] * 4,
    "a": (["f"] * 3 + ["m"] * 3) * 2,
    "x": ["p"] * 6 + ["q"] * 6,
    "n": [300, 100, 4, 200, 180, 20, 30, 70, 0, 40, 50, 10],
}
COUNTED = "Undecided (refused): 34 of 1,004 decisions, counted as worth 0; each may have been worth something from 0 to 1."
RANGES = (
    "Whatever they meant, the ratio within contexts is from 1.350 to 1.667 and the ratio over all is from 1.212 to 1.381, in the table."
)


def audited(**options: Any) -> fa.Result:
    columns: dict[str, Any] = {"decision": "u", "group": "a", "context": "x", "count": "n", "utility": "yes"}
    return fa.audit(LOG, **columns, **{"undecided": "refused", "max_local_ratio": "8/5", **options})


@pytest.mark.parametrize("confidence", [None, "0.95"])
def test_the_first_screen_says_how_they_are_counted_and_what_they_could_do(confidence: str | None) -> None:
    """p: 300 to 304 of 404 over 200 to 220 of 400; q: 40 to 50 of 100 over 30 of 100; a result and its certificate say the same."""
    result = audited(confidence=confidence)
    made = of_result(result)
    assert made.beside == (COUNTED, RANGES)
    read = of_content(describe(result.certificate.document))
    assert read is not None and (read.beside, read.groups) == (made.beside, made.groups)
    word, why = made.chance[0]
    assert (word, why) == (
        ("it depends", "on what the undecided decisions meant")
        if confidence is None
        else ("not known", "too few decisions, or too many of them undecided, at 95 %")
    )


@pytest.mark.parametrize(
    ("limit", "confidence", "said"),
    [
        ("5", "0.95", ("no", "within the limit is established, whatever the undecided decisions meant, at 95 %")),
        ("1.05", "0.95", ("yes", "the population exceeds the limit, whatever the undecided decisions meant, at 95 %")),
        ("1.3", None, ("not asked", "judged for this table alone: the limit is exceeded, whatever the undecided decisions meant")),
    ],
)
def test_verdicts_hold_whatever_they_meant(limit: str, confidence: str | None, said: tuple[str, str]) -> None:
    assert of_result(audited(confidence=confidence, max_local_ratio=limit)).chance == (said,)


def test_without_a_target_undecided_decisions_are_no_lack_of_decisions() -> None:
    """2,000 of 3,000 answers in each group say nothing, so that no number of them would tell; few of 12 would, if there were more."""
    shares = [("yes", 600, 400), ("no", 400, 600), ("refused", 2000, 2000)]
    table = {"u": [u for u, *_ in shares] * 2, "a": ["f"] * 3 + ["m"] * 3, "n": [f for _, f, _ in shares] + [m for *_, m in shares]}
    options: dict[str, Any] = {"decision": "u", "group": "a", "count": "n", "utility": "yes", "undecided": "refused"}
    result = fa.audit(table, **options)
    meant = "in this table itself, groups are alike for some of what the undecided decisions may have meant"
    assert of_result(result).chance == (("not known", meant),)
    read = of_content(describe(result.certificate.document))
    assert read is not None and read.chance == of_result(result).chance
    few = {"u": ["yes", "no", "yes", "no", "refused"], "a": ["f", "f", "m", "m", "m"], "n": [9, 3, 4, 8, 1]}
    (answer, why) = of_result(fa.audit(few, **options)).chance[0]
    assert (answer, why.partition(":")[0]) == ("not known", "too few decisions, or too many of them undecided")
    assert of_result(audited(max_local_ratio=None)).chance[0][0] == "yes"


def test_ranges_stay_on_the_first_screen_however_much_else_is_said() -> None:
    result = audited(max_local_ratio=None)
    found = replace(of_result(result), cautions=("long " * 300,), sentences=("words " * 300,), chance=(("yes", "why " * 100),))
    words = " ".join(first_screen(found, "log.csv", "fairaudit verify c.json", ["found " * 200]).split())
    assert len(first_screen(found, "log.csv", "fairaudit verify c.json").splitlines()) <= 40
    assert COUNTED in words and RANGES.partition(" is ")[0] in words and "in the table." in words


def test_intervals_of_groups_hold_whatever_they_meant() -> None:
    """The lower end of men is that of 240 of 500, the upper one that of 270 of 500."""
    (men, _) = of_result(audited()).groups
    plain, meant = (of_result(audited(undecided=(), max_local_ratio=None)), audited())
    assert men.gets.group == {"a": "m"} and men.between != plain.groups[0].between
    assert men.between.split(" to ")[0] == plain.groups[0].between.split(" to ")[0]
    every = {**LOG, "u": ["yes" if u == "refused" else u for u in LOG["u"]]}
    most = of_result(fa.audit(every, decision="u", group="a", context="x", count="n", utility="yes")).groups
    upper = next(line.between for line in most if line.gets.group == {"a": "m"})
    assert men.between.split(" to ")[1] == upper.split(" to ")[1]
    assert meant.undecided is not None


def test_documents_have_the_table_of_ranges() -> None:
    certificate = audited().certificate
    written = markdown(certificate)
    assert "### Undecided decisions" in written and "from 1.212 to 1.381 | the table |" in written
    of = "the table; the greatest within x=q"  # 50 to 30 of 100; in p 304 of 404 to 200 of 400
    assert f"| the ratio within contexts | 1.485 | from 1.350 to 1.667 | {of} |" in written
    page = html(certificate)
    assert 'id="undecided"' in page and "from 1.350 to 1.667" in page and COUNTED in page and f"<td>{of}</td>" in page
    card = model_card(certificate)
    assert RANGES in card and "whatever the undecided meant" in card
    found = json.loads(certificate.text)
    assert [(one.quantity, one.of_table) for one in undecided_ranges(found)] == [
        ("local", True),
        ("global", True),
        ("local", False),
        ("global", False),
    ]


def test_labels_are_escaped_and_clipped() -> None:
    odd = "no\u202e\x1b[31m" + "w" * 300
    table = {**LOG, "u": [odd if u == "refused" else u for u in LOG["u"]]}
    result = fa.audit(table, decision="u", group="a", context="x", count="n", utility="yes", undecided=odd)
    said = " ".join(of_result(result).beside)
    assert "\u202e" not in said and "\x1b" not in said and len(said) < 400
    assert "\u202e" not in html(result.certificate).split('id="certificate"')[0]


def test_nothing_is_said_without_them() -> None:
    result = audited(undecided=())
    assert undecided_lines(json.loads(result.certificate.text), None) == []
    assert "ndecided" not in markdown(result.certificate)


def test_the_command(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    rows = ["u,a,x,n", *(",".join(map(str, row)) for row in zip(LOG["u"], LOG["a"], LOG["x"], LOG["n"], strict=True))]
    (tmp_path / "log.csv").write_text("\n".join(rows) + "\n", "utf-8")
    columns = ["--decision", "u", "--group", "a", "--context", "x", "--count", "n", "--utility", "yes", "--undecided", "refused"]
    asked = ["certify", str(tmp_path / "log.csv"), *columns, "--max-local-ratio", "8/5", "-o", str(tmp_path / "c.json")]
    assert main([*asked, "--confidence", "none"]) == 3
    out = capsys.readouterr().out
    assert "DEPENDS" in out and "counted as worth 0" in out
    assert main(["verify", str(tmp_path / "c.json")]) == 0
    assert "depends on what the undecided decisions" in " ".join(capsys.readouterr().out.split())
    assert main([*asked, "--verbose"]) == 3
    assert "each at 95 %, whatever the undecided meant (1.485 in the table)" in capsys.readouterr().out
    assert main([*asked, "--difference"]) == 2
    assert "undecided decisions do not go with differences" in capsys.readouterr().err
    (tmp_path / "audit.toml").write_text(
        '[law]\ntable = "log.csv"\ndecision = "u"\ngroup = "a"\ncontext = "x"\ncount = "n"\n[utility]\nvalues = { yes = 1 }\n'
        'undecided = ["refused"]\n[targets]\nmax_local_ratio = "8/5"\n[confidence]\nlevel = "none"\n',
        "utf-8",
    )
    assert main(["certify", str(tmp_path / "audit.toml")]) == 3
    assert "DEPENDS" in capsys.readouterr().out


def test_bounds_are_rounded_to_the_side_on_which_they_say_less() -> None:
    """300 of 404 over 260 of 440 is 1.25663…, 304 of 404 over 200 of 440 is 1.65544…."""
    log = {"u": ["yes", "no", "refused"] * 2, "a": ["f"] * 3 + ["m"] * 3, "n": [300, 100, 4, 200, 180, 60]}
    columns: dict[str, Any] = {"decision": "u", "group": "a", "count": "n", "utility": "yes", "undecided": "refused"}
    made = fa.audit(log, **columns, confidence=None).certificate
    text = markdown(made)
    assert "| 1.256 | 1650/1313 | at least" in text and "| 1.656 | 836/505 | at most" in text
    assert {claim["relation"]: claim["value"].decimal for claim in describe(made.document).claims if claim["by"] == "T19"} == {
        "≥": "1.256",
        "≤": "1.656",
    }
