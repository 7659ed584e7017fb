"""What a notebook shows of a result: the order of every face, numbers that are those of the table, labels as text, nothing that runs."""

from __future__ import annotations

import csv
import re
from fractions import Fraction
from html.parser import HTMLParser
from importlib.resources import files
from math import isqrt
from pathlib import Path
from typing import Any

import pytest

import fairaudit as fa
from fairaudit.reports.notebook import WIDTH, notebook

ADMISSIONS = files("fairaudit.tables").joinpath("data/ucb-admissions.csv")
TAGS = {
    "bdi",
    "code",
    "details",
    "div",
    "li",
    "line",
    "p",
    "rect",
    "strong",
    "summary",
    "svg",
    "table",
    "tbody",
    "td",
    "th",
    "thead",
    "tr",
    "ul",
}
ATTRIBUTES = {"aria-label", "class", "fill", "height", "opacity", "role", "rx", "scope", "stroke", "style", "viewbox", "width"}
HOSTILE = "<script>alert(1)</script>\"'&amp;\u202e\x1b[31m"


class Shown(HTMLParser):
    """The elements of a page, which must be closed as they were opened, with the text of each table."""

    def __init__(self, text: str) -> None:
        super().__init__()
        self.open: list[str] = []
        self.tags: set[str] = set()
        self.attributes: dict[str, set[str]] = {}
        self.text: list[str] = []
        self.rows: list[list[str]] = []
        self.feed(text)
        self.close()
        assert self.open == []

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.open.append(tag)
        self.tags.add(tag)
        for name, value in attrs:
            self.attributes.setdefault(name, set()).add(value or "")
        if tag == "tr":
            self.rows.append([])
        if tag in ("td", "th"):
            self.rows[-1].append("")

    def handle_startendtag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.handle_starttag(tag, attrs)
        self.open.pop()

    def handle_endtag(self, tag: str) -> None:
        assert self.open.pop() == tag

    def handle_data(self, data: str) -> None:
        self.text.append(data)
        if "td" in self.open or "th" in self.open:
            self.rows[-1][-1] += data


def admissions(**given: Any) -> fa.Result:
    asked = {"decision": "Admit", "group": "Gender", "context": "Dept", "count": "Freq", "utility": "Admitted", **given}
    return fa.audit(str(ADMISSIONS), **asked)


def rates() -> dict[str, tuple[int, int]]:
    """Admitted and applied by gender, by a plain loop over the published table."""
    found: dict[str, tuple[int, int]] = {}
    for row in csv.DictReader(ADMISSIONS.read_text("utf-8").splitlines()):
        admitted, applied = found.get(row["Gender"], (0, 0))
        n = int(row["Freq"])
        found[row["Gender"]] = admitted + n * (row["Admit"] == "Admitted"), applied + n
    return found


def test_it_is_in_the_order_in_which_people_ask() -> None:
    text = " ".join(Shown(notebook(admissions(max_global_ratio="5/4"))).text)
    asked = ["4,526 decisions, 2 groups (Gender), 6 contexts (Dept)", "exceeds", "Gender=Male 44.5 % (1,198 of 2,691)"]
    asked += [
        "Established beyond chance:",
        "28.2 to 32.6 %",
        "worst first",
        "Assumed, for you to judge",
        "All figures",
        "24475/18432",
        "Next:",
    ]
    places = [text.index(part) for part in asked]
    assert places == sorted(places)


def test_rates_are_those_of_the_table() -> None:
    shown = Shown(notebook(admissions()))
    for gender, (admitted, applied) in rates().items():
        (row,) = [row for row in shown.rows if row[0] == gender]
        assert row[1] == f"{100 * admitted / applied:.1f} %" and row[2] == f"{admitted:,} of {applied:,}"
        low, high = (Fraction(end) / 100 for end in re.findall(r"[\d.]+", row[3]))
        assert low < Fraction(admitted, applied) < high
        assert high - low < 5 / Fraction(isqrt(applied))  # a binomial interval of 95 % is about two deviations to each side
    best = max(Fraction(*pair) for pair in rates().values())
    worst = min(Fraction(*pair) for pair in rates().values())
    assert [row[-1] for row in shown.rows if row[0] in rates()] == [f"{float(worst / best):.3g}", "1"]


def test_pictures_stand_on_one_scale() -> None:
    text = notebook(admissions())
    assert "0 to 50 %" in text
    pictures = re.findall(r"<svg.*?</svg>", text)
    drawn = []
    for picture in pictures:
        (bar, tick) = re.findall(r'<rect x="([\d.]+)" y="\d+" width="([\d.]+)"', picture)
        left, right, mean = float(bar[0]), float(bar[0]) + float(bar[1]), float(tick[0]) + 1
        assert 0 <= left < mean < right <= WIDTH
        drawn.append(mean)
    assert drawn == [pytest.approx(WIDTH * admitted / applied / 0.5, abs=0.1) for admitted, applied in sorted(rates().values())]
    assert [re.findall('aria-label="([^"]*)"', picture) for picture in pictures] == [["30.4 %, 28.2 to 32.6 %"], ["44.5 %, 42.6 to 46.5 %"]]


def kinds(folder: Path) -> dict[str, fa.Result]:
    """Results of every kind."""
    counts: dict[str, Any] = {"hired": ["yes", "no", "yes", "no"], "sex": ["f", "f", "m", "m"], "n": [30, 10, 20, 20]}
    columns: dict[str, Any] = {"decision": "hired", "group": "sex"}
    asked = {**columns, "count": "n", "utility": "yes"}
    log = folder / "log.parquet"
    import duckdb

    duckdb.sql(f"copy (select 'yes' as hired, 'f' as sex, 'a' as dept union all select 'no', 'm', 'a') to '{log}' (format parquet)")
    policy = fa.Policy.from_array([[["0.9", "0.1"], ["0.2", "0.8"]]], decisions=["hire", "pass"], groups=["f", "m"])
    many = {"hired": [], "sex": [], "dept": []} | {key: [] for key in ("n",)}  # type: dict[str, list[Any]]
    for i in range(60):
        for hired in ("yes", "no"):
            for key, value in {"hired": hired, "sex": f"group {i % 20}", "dept": f"dept {i // 20}", "n": 1 + (7 * i) % 11}.items():
                many[key].append(value)
    return {
        "target": fa.audit(counts, **asked, max_local_ratio="5/4"),
        "no interval": fa.audit(counts, **asked, confidence=None),
        "truth": fa.audit({**counts, "fit": ["yes", "no", "no", "yes"]}, **asked, truth="fit"),
        "burden": fa.audit(counts, **asked, burden=True),
        "signed": fa.audit(counts, **{**asked, "utility": {"yes": 1, "no": -1}}, max_difference="0.1"),
        "numbers": fa.audit(counts, **{**asked, "utility": {"yes": 1000, "no": "0.5"}}),
        "great": fa.audit(counts, **{**asked, "utility": {"yes": 10**400}}, confidence=None),
        "infinite": fa.audit({**counts, "n": [30, 10, 0, 20]}, **asked),
        "nothing": fa.audit({**counts, "n": [0, 10, 0, 20]}, **asked),
        "never": fa.audit({**counts, "dept": ["a", "a", "b", "b"]}, **asked, context="dept"),
        "policy": fa.audit(policy.behind(group=fa.RandomizedResponse("fm", keep_probability="0.75")), utility="hire", max_local_ratio=2),
        "parts": fa.audit(log, **columns, context="dept", utility="yes", in_parts=True),
        "many": fa.audit(many, **asked, context="dept"),
        "unknown": fa.audit({**counts, "sex": ["f", "n/a", "m", "m"]}, **asked, unknown="n/a", max_local_ratio=2),
        "hidden": fa.audit(counts, **asked, hidden_context="2,3", max_local_ratio="5/4"),
        "hostile": fa.audit(
            {HOSTILE: [HOSTILE, "no"] * 2, "sex": [HOSTILE, HOSTILE, "m", "m"], "dept" + HOSTILE: [HOSTILE] * 4},
            decision=HOSTILE,
            group="sex",
            context="dept" + HOSTILE,
            utility={HOSTILE: 1},
            max_local_ratio=2,
        ),
    }


@pytest.fixture(scope="module")
def every(tmp_path_factory: pytest.TempPathFactory) -> dict[str, fa.Result]:
    return kinds(tmp_path_factory.mktemp("notebook"))


def test_every_kind_is_shown_with_nothing_that_runs_or_loads(every: dict[str, fa.Result]) -> None:
    for name, result in every.items():
        text = result._repr_html_()
        shown = Shown(text)
        assert shown.tags <= TAGS, name
        assert set(shown.attributes) <= ATTRIBUTES | {"x", "y", "x1", "x2", "y1", "y2"}, name
        assert shown.attributes["style"] <= {"text-align:left;padding:2px 12px 2px 0", "margin:8px 0"}
        assert "://" not in text and "url(" not in text and "nan" not in " ".join(shown.text).split(), name
        assert (result.verdict if result.targets else "no target was set") in shown.text, name
        assert all(line.isprintable() for line in shown.text), name
        assert len(text) < 60_000, name


def test_labels_are_text(every: dict[str, fa.Result]) -> None:
    text = every["hostile"]._repr_html_()
    assert "<script" not in text and "&lt;script&gt;alert(1)" in text and "\u202e" not in text and "\x1b" not in text


def test_of_many_groups_some_are_shown_and_the_rest_counted(every: dict[str, fa.Result]) -> None:
    shown = Shown(every["many"]._repr_html_())
    rows = [row[0] for row in shown.rows]
    assert rows.count("… and 8 more between them") == 1
    assert sum(row.startswith("group ") for row in rows) == 12


def test_differences_of_signed_utilities_have_a_scale_with_two_sides(every: dict[str, fa.Result]) -> None:
    text = every["signed"]._repr_html_()
    assert "below the best" in text and "ratio to the best" not in text
    assert re.search(r"-0?\.?\d+ to 0?\.?\d+", text)


def test_colours_are_those_of_the_notebook(every: dict[str, fa.Result]) -> None:
    colours = {value for result in every.values() for value in Shown(result._repr_html_()).attributes.get("fill", set())}
    assert colours == {"currentColor"}
