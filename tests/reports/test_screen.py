"""The first screen: 40 lines of 80 columns for any table and any labels, its numbers those of the table, in the order that people ask."""

from __future__ import annotations

import csv
import io
import os
import random
import re
import unicodedata
from collections.abc import Iterable
from fractions import Fraction
from math import inf
from pathlib import Path
from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import fairaudit as fa
from fairaudit.cli import main
from fairaudit.reports.overview import of_result
from fairaudit.reports.screen import CONTEXTS, GROUPS, LINES, first_screen, shortened
from fairaudit.words import COLUMNS, columns_of, wrapped

GOLDEN = Path(__file__).parents[1] / "golden" / "screens"

HOSTILE = (
    "東京都" * 30,
    "e\u0301" * 90,
    "\x1b[31mred\x1b[0m",
    "\u202eesrever",
    "👩‍👩‍👧‍👦" * 20,
    "word " * 40,
    "x" * 500,
    "a\nb",
    " ",
    "1",
    "-",
    "50 %",
    "=1+1",
    "а̸̢̛" * 50,
)


def write(path: Path, rows: Iterable[dict[str, Any]]) -> str:
    listed = list(rows)
    with path.open("w", newline="", encoding="utf-8") as file:
        writer = csv.DictWriter(file, [*listed[0]])
        writer.writeheader()
        writer.writerows(listed)
    return str(path)


def runs(folder: Path) -> str:
    """What a model answered in 120 interviews, three rows each."""
    drawn = random.Random(7)
    rows = []
    for i in range(120):
        profile = drawn.choice(("f", "m"))
        rows += [
            {
                "interview": i,
                "sex": profile,
                "job": job,
                "answer": drawn.choice(("invite", "invite", "decline") if profile == "m" else ("invite", "decline", "decline")),
            }
            for job in ("cook", "cook", "nurse")
        ]
    return write(folder / "interviews.csv", rows)


def many(folder: Path) -> str:
    drawn = random.Random(11)
    rows = []
    for x in range(50):
        for a in range(40):
            total = drawn.randint(50, 300)
            granted = drawn.randint(total // 4, 3 * total // 4)
            labels = {"branch": f"branch {x}", "region of birth": f"region {a}"}
            rows += [{**labels, "outcome": "granted", "n": granted}, {**labels, "outcome": "refused", "n": total - granted}]
    return write(folder / "loans.csv", rows)


def changes(folder: Path) -> str:
    drawn = random.Random(5)
    rows = [{"sex": sex, "after": drawn.choices(("better", "same", "worse"), (5, 3, 2 + 2 * (sex == "f")))[0]} for sex in ("f", "m") * 400]
    return write(folder / "therapy.csv", rows)


def stream(folder: Path) -> str:
    drawn = random.Random(3)
    lines = [
        f'{{"sex": "{sex}", "job": "cook", "answer": "{"invited" if drawn.random() < (0.6 if sex == "m" else 0.4) else "declined"}"}}'
        for sex in ("f", "m") * 600
    ]
    (folder / "log.jsonl").write_text("\n".join(lines) + "\n")
    options = ["--group", "sex", "--context", "job", "--decision", "answer", "--utility", "invited", "--max-local-ratio", "1.25"]
    main(["monitor", str(folder / "log.jsonl"), "--state", str(folder / "answers.db"), *options, "--format", "json"])
    return str(folder / "answers.db")


def commands(folder: Path) -> dict[str, list[str]]:
    log = ["--decision", "answer", "--group", "sex", "--context", "job", "--utility", "invite", "--unit", "interview"]
    loans = ["--decision", "outcome", "--group", "region of birth", "--context", "branch", "--count", "n", "--utility", "granted"]
    therapy = ["--decision", "after", "--group", "sex", "--utility", "better=1,worse=-1", "--max-difference", "0.5"]
    return {
        "plain-table": ["--example", "ucb-admissions"],
        "with-a-target": ["--example", "ucb-admissions", "--max-global-ratio", "0.8"],
        "log-with-units": [runs(folder), *log, "--max-local-ratio", "0.8"],
        "policy-behind-filters": ["--example", "hr-filtered"],
        "certificate-of-a-stream": ["--from-monitor", stream(folder)],
        "many-groups-and-contexts": [many(folder), *loans, "--max-local-ratio", "0.8", "--confidence", "none"],
        "differences": [changes(folder), *therapy],
    }


@pytest.fixture(scope="module")
def listed(tmp_path_factory: pytest.TempPathFactory) -> dict[str, list[str]]:
    return commands(tmp_path_factory.mktemp("audited"))


@pytest.mark.parametrize(
    "name",
    [
        "plain-table",
        "with-a-target",
        "log-with-units",
        "policy-behind-filters",
        "certificate-of-a-stream",
        "many-groups-and-contexts",
        "differences",
    ],
)
def test_golden_screens(name: str, listed: dict[str, list[str]], capsys: pytest.CaptureFixture[str]) -> None:
    """Set FAIRAUDIT_GOLDEN=1 to write the screens anew, and read them before committing them."""
    capsys.readouterr()
    main(["certify", *listed[name]])
    out = capsys.readouterr().out
    assert_fits(out.removesuffix("\n"))
    path = GOLDEN / f"{name}.txt"
    if os.environ.get("FAIRAUDIT_GOLDEN"):
        path.write_text(out, encoding="utf-8")
    assert out == path.read_text(encoding="utf-8")


def assert_fits(text: str) -> None:
    lines = text.split("\n")
    assert len(lines) <= LINES, len(lines)
    assert max(map(width, lines)) <= COLUMNS, max(lines, key=width)
    assert not any(unicodedata.category(c) in ("Cc", "Cf") for line in lines for c in line)


def width(line: str) -> int:
    """Columns of a terminal, counted by the tables of Unicode."""
    return sum(0 if unicodedata.combining(c) else 1 + (unicodedata.east_asian_width(c) in ("W", "F")) for c in line)


labels = st.one_of(st.sampled_from(HOSTILE), st.text(min_size=1, max_size=30).filter(lambda text: text.strip() != ""))


@st.composite
def audits(draw: Any) -> tuple[dict[str, list[Any]], dict[str, Any]]:
    groups = draw(st.lists(labels, min_size=2, max_size=draw(st.sampled_from((2, 3, 20))), unique=True))
    contexts = draw(st.lists(labels, min_size=1, max_size=draw(st.sampled_from((1, 4, 16))), unique=True))
    decisions = draw(st.lists(labels, min_size=2, max_size=4, unique=True))
    seed = random.Random(draw(st.integers(0, 10**6)))
    most = draw(st.sampled_from((3, 90, 10**7)))
    rows = [(u, a, x, seed.choice((0, seed.randint(0, most)))) for u in decisions for a in groups for x in contexts]
    rows += [(decisions[0], a, contexts[0], 1) for a in groups[:2]]
    u, a, x, n = map(list, zip(*rows, strict=True))
    names = draw(st.lists(labels, min_size=4, max_size=4, unique_by=lambda name: name.strip()))
    utility = draw(st.sampled_from(({decisions[0]: 1}, dict.fromkeys(decisions[:3], 1), {decisions[0]: 2, decisions[1]: "1/3"})))
    options: dict[str, Any] = {"decision": names[0], "group": names[1], "context": names[2], "count": names[3], "utility": utility}
    options |= draw(st.sampled_from(({}, {"max_local_ratio": "0.8"}, {"max_global_ratio": 2, "max_local_log": "0.3"}, {"burden": True})))
    return dict(zip(names, (u, a, x, n), strict=True)), options | {"confidence": draw(st.sampled_from((None, "0.95")))}


@given(audits())
@settings(max_examples=25, deadline=None)
def test_it_fits_whatever_was_audited(audit: tuple[dict[str, list[Any]], dict[str, Any]]) -> None:
    table, options = audit
    try:
        result = fa.audit(table, **options)
    except fa.InputError:
        return
    text = first_screen(of_result(result, groups=GROUPS, contexts=CONTEXTS), HOSTILE[0], command := "fairaudit verify " + "x" * 200)
    assert_fits(text.replace(f"Next:\n{command}", "Next:\nfairaudit verify x"))
    assert f"\n{command}\n" in text
    for heading in ("Established beyond chance: ", "Assumed, for you to judge:", "Next:"):
        assert heading in text
    assert "Left out: nothing" in text or "\nAs read:" in text


@given(st.integers(0, 10**6), st.integers(2, 16), st.integers(1, 14), st.sampled_from((5, 400, 3_000)))
@settings(max_examples=20, deadline=None)
def test_every_number_is_counted_again(seed: int, groups: int, contexts: int, most: int) -> None:
    drawn = random.Random(seed)
    counts = {(f"g{a:02}", f"x{x:02}"): (drawn.randint(0, most), drawn.randint(0, most)) for a in range(groups) for x in range(contexts)}
    counts |= {("g00", "x00"): (1, 2), ("g01", "x00"): (2, 3)}
    rows = [(u, a, x, n[i]) for (a, x), n in counts.items() for i, u in enumerate(("hired", "refused"))]
    u, a, x, n = zip(*rows, strict=True)
    table = {"outcome": u, "sex": a, "dept": x, "n": n}
    result = fa.audit(table, decision="outcome", group="sex", context="dept", count="n", utility="hired", max_global_ratio="0.8")
    text = first_screen(of_result(result, groups=GROUPS, contexts=CONTEXTS), "t.csv", "fairaudit verify c.json")
    assert_fits(text)
    totals: dict[str, tuple[int, int]] = {}
    for (group, _), (good, bad) in counts.items():
        old = totals.get(group, (0, 0))
        totals[group] = old[0] + good, old[1] + good + bad
    best = max(Fraction(*pair) for pair in totals.values() if pair[1])
    table_of_groups = re.findall(r"^(g\d\d) +([\d,]+) +(\S+) % +(\S+) to (\S+) % +(\S+)(?: or (\S+))?$", text, re.MULTILINE)
    assert len(table_of_groups) >= min(groups, 2)
    for group, amount, rate, low, high, least, greatest in table_of_groups:
        exact = Fraction(*totals[group])
        assert int(amount.replace(",", "")) == totals[group][1]
        assert_rounds(rate, 100 * exact)
        assert Fraction(low) <= 100 * exact <= Fraction(high)
        assert_rounds(least, exact / best)
        if greatest:
            assert greatest == "infinite" if not exact else assert_rounds(greatest, best / exact) is None
    cells = {(x, a): (good, good + bad) for (a, x), (good, bad) in counts.items() if good + bad}
    pairs = re.findall(r"^(x\d\d) +(\S+) +(g\d\d) (\S+) % \(([\d,]+) of ([\d,]+)\) +(g\d\d) (\S+) % \(([\d,]+) of ([\d,]+)\)$", text, re.M)
    assert pairs or contexts == 1
    for context, ratio, *both in pairs:
        rates = [Fraction(*pair) for (x, _), pair in cells.items() if x == context]
        assert_rounds(ratio, max(rates) / min(rates) if min(rates) else inf)
        for group, rate, good, of in (both[:4], both[4:]):
            assert (int(good.replace(",", "")), int(of.replace(",", ""))) == cells[context, group]
            assert_rounds(rate, 100 * Fraction(*cells[context, group]))
    said = re.search(
        r"(g\d\d) ([\d.]+) % \(([\d,]+) of ([\d,]+)\), sex=(g\d\d) ([\d.]+) % \(([\d,]+) of ([\d,]+)\)", text.replace("\n", " ")
    )
    assert said is not None
    for group, rate, good, of in (said.groups()[:4], said.groups()[4:]):
        assert (int(good.replace(",", "")), int(of.replace(",", ""))) == totals[group]
        assert_rounds(rate, 100 * Fraction(*totals[group]))


def assert_rounds(text: str, exact: Any) -> None:
    """A figure is within half of its last digit."""
    if exact == inf:
        assert text == "infinite"
        return
    plain = text.replace(",", "")
    decimals = len(plain.partition(".")[2])
    assert abs(Fraction(plain) - exact) <= Fraction(1, 2 * 10**decimals), (text, float(exact))


def test_the_order_is_that_in_which_people_ask(capsys: pytest.CaptureFixture[str]) -> None:
    main(["certify", "--example", "ucb-admissions", "--max-global-ratio", "0.8"])
    out = capsys.readouterr().out
    parts = (
        "4,526 decisions",
        "EXCEEDS ",
        "Admitted over all contexts: ",
        "Established beyond chance: yes",
        "Gender  ",
        "Dept, worst",
        "Left out:",
    )
    places = [out.index(part) for part in (*parts, "Assumed, for you to judge:", "Next: ")]
    assert places == sorted(places)


def test_everything_is_printed_where_it_is_asked_for(capsys: pytest.CaptureFixture[str]) -> None:
    for asked in (["--verbose"], ["--top", "1"], ["--two-sided"]):
        main(["certify", "--example", "ucb-admissions", "--max-local-ratio", "0.8", *asked])
        out = capsys.readouterr().out
        assert "log R at least" in out and "worst over group-blind utilities, local" in out and "What this does not say" in out


def test_what_to_do_next_runs(tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    for options in (["--max-local-ratio", "0.8"], ["-o", "with blank.json"]):
        main(["certify", "--example", "ucb-admissions", *options])
        found = re.search(r"^Next: fairaudit (.*)$", capsys.readouterr().out, re.MULTILINE)
        assert found is not None
        assert main([part.strip("'") for part in re.findall(r"'[^']*'|\S+", found.group(1))]) == 0
        assert capsys.readouterr().out
    main(["certify", "--example", "ucb-admissions"])
    assert "with -o certificate.json" in capsys.readouterr().out.replace("\n      ", " ")


class Terminal(io.StringIO):
    """A place to print to that says it is a terminal."""

    def isatty(self) -> bool:
        return True


def printed(monkeypatch: pytest.MonkeyPatch, **environment: str) -> str:
    out = Terminal()
    monkeypatch.setattr("sys.stdout", out)
    for name in ("NO_COLOR", "TERM"):
        monkeypatch.delenv(name, raising=False)
    for name, value in environment.items():
        monkeypatch.setenv(name, value)
    main(["certify", "--example", "ucb-admissions", "--max-global-ratio", "0.8"])
    return out.getvalue()


def test_colour_is_for_terminals_and_says_nothing_new(monkeypatch: pytest.MonkeyPatch) -> None:
    golden = (GOLDEN / "with-a-target.txt").read_text(encoding="utf-8")
    coloured = printed(monkeypatch)
    assert "\x1b[31;1mEXCEEDS\x1b[0m" in coloured
    assert re.sub(r"\x1b\[[\d;]*m", "", coloured) == golden
    assert printed(monkeypatch, NO_COLOR="1") == golden == printed(monkeypatch, TERM="dumb")
    assert printed(monkeypatch, NO_COLOR="") == coloured


def test_labels_are_shortened_by_columns() -> None:
    assert [columns_of(text) for text in ("abc", "東京", "e\u0301")] == [3, 4, 1]
    assert shortened("東京都庁舎", 7) == "東京…舎" and shortened("abc", 3) == "abc"
    assert wrapped("a rate of 44.5 % and more" * 4, 2)[1].startswith("  ") and not any(
        line.startswith("%") for line in wrapped("44.5 % " * 40)
    )
    assert all(columns_of(line) <= COLUMNS for line in wrapped("東" * 200, 10))


def test_a_stream_that_changed_is_not_said_to_have_no_interval(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    log, state = tmp_path / "log.csv", str(tmp_path / "watch.db")
    draw = random.Random(0)
    rows = [("fm"[i % 2], "hired" if draw.random() < (0.9, 0.2)[(i % 2) ^ (i >= 1500)] else "refused") for i in range(3000)]
    log.write_text("a,u\n" + "".join(f"{a},{u}\n" for a, u in rows))
    asked = ["--decision", "u", "--group", "a", "--utility", "hired", "--window", "500"]
    assert main(["monitor", str(log), "--state", state, "--log-format", "csv", *asked]) in (0, 3)
    capsys.readouterr()
    assert main(["certify", "--from-monitor", state]) == 3
    said = " ".join(capsys.readouterr().out.split())
    assert "The local ratio changed: " in said and "no interval was computed" not in said
    assert "Established beyond chance: it depends on when: the ratio changed during the stream" in said
