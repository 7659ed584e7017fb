"""What makes a table as data: written and read again, nothing is lost, and nothing else is taken."""

from __future__ import annotations

import json
import re
from fractions import Fraction
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from fairaudit import InputError
from fairaudit.attestations.options import options_of, reading_of
from fairaudit.audits.reading import Access, Reading
from fairaudit.model.law import Law
from fairaudit.model.utility import Utility
from fairaudit.tables.binning import Bins
from fairaudit.tables.evaluations.extraction import FORMATS, RECIPES, Extraction
from fairaudit.tables.wide import Wide, read_wide

texts = st.text(st.characters(exclude_categories=("Cc", "Cs")), min_size=1, max_size=8)
listed = st.lists(texts, max_size=3).map(tuple)
numbers = st.fractions(-1000, 1000, max_denominator=99)
edges = st.lists(st.integers(-(10**6), 10**6), min_size=1, max_size=4, unique=True).map(lambda cut: [Fraction(n, 8) for n in sorted(cut)])
wides = st.one_of(
    st.dictionaries(texts, texts, min_size=2, max_size=3).map(lambda counts: (counts, None)),
    st.tuples(st.dictionaries(st.tuples(texts, texts), texts, min_size=1, max_size=3), st.fractions("1/99", 100)),
    st.tuples(st.dictionaries(texts, texts, min_size=1, max_size=3), texts),
)


def wide_or_none(given: Any) -> Wide | None:
    try:
        return None if given is None else read_wide(*given)
    except InputError:
        return None


names = texts.filter(lambda text: "/" not in text and text != "." and text.strip())
extractions = st.builds(
    Extraction,
    log_format=st.sampled_from([None, *FORMATS]),
    extract=st.none() | texts,
    options=st.just(()) | st.lists(texts.filter(str.strip), min_size=2, max_size=4, unique=True).map(tuple),
    join=st.none() | st.tuples(names, texts),
    where=st.dictionaries(texts, texts, max_size=2).map(lambda conditions: tuple(conditions.items())),
    errors=st.sampled_from(["refuse", "drop", "bound"]),
    missing_samples=st.sampled_from(["refuse", "accept"]),
    recipe=st.sampled_from([None, *RECIPES]),
)


@st.composite
def readings(draw: st.DrawFn) -> Reading:
    maybe = st.none() | texts
    map_ = st.dictionaries(texts, st.dictionaries(texts.filter(str.strip), texts.filter(str.strip), min_size=1, max_size=2), max_size=2)
    return Reading(
        decision=draw(texts),
        group=draw(st.lists(texts, min_size=1, max_size=3).map(tuple)),
        context=draw(listed),
        bins={name: Bins.of(name, cut) for name, cut in draw(st.dictionaries(texts, edges, max_size=2)).items()},
        truth=draw(maybe),
        count=draw(maybe),
        probability=draw(maybe),
        weight=draw(maybe),
        unit=draw(listed),
        utility_column=draw(maybe),
        missing=draw(st.sampled_from(["error", "drop", "group", "unknown"])),
        unknown=draw(listed),
        fold_labels=draw(st.booleans()),
        label_map=draw(map_) or None,
        access=Access(table=draw(maybe), query=draw(maybe), skip=draw(st.integers(0, 20)), extraction=draw(extractions)),
        signed=draw(st.booleans()),
        wide=wide_or_none(draw(st.none() | wides)),
        above=draw(st.none() | st.just("median") | numbers),
    )


@given(readings(), st.dictionaries(texts.filter(str.strip), numbers, min_size=1, max_size=3))
def test_what_is_written_is_read_again_through_json(reading: Reading, values: dict[str, Fraction]) -> None:
    utility = (
        None
        if reading.utility_column
        else Utility(values if reading.signed else {label: abs(v) for label, v in values.items()}, signed=reading.signed)
    )
    try:
        written = options_of(reading, utility)
    except InputError as error:  # a column whose name is a number, as the total of others
        assert "cannot be recorded" in str(error) and reading.wide is not None
        return
    back, worth = reading_of(json.loads(json.dumps(written)))
    renamed = {name: {str(old): str(new) for old, new in entries.items()} for name, entries in (reading.label_map or {}).items()}
    assert (back.label_map or {}) == renamed
    assert {**vars(back), "label_map": None} == {**vars(reading), "label_map": None}
    assert (None if worth is None else worth.values) == (None if utility is None else utility.values)
    assert worth is None or worth.signed == reading.signed


def test_scores_are_said_instead_of_a_decision() -> None:
    said = options_of(Reading("points", ("sex",), above="median"), None)
    assert said == {"score": {"column": "points", "above": "median"}, "group": ["sex"], "utility": {"above": "1"}}
    reading, _ = reading_of({"score": {"column": "points", "above": "129/2"}, "group": ["sex"]})
    assert (reading.decision, reading.above) == ("points", Fraction(129, 2))
    for score in ({"column": "points"}, {"column": "points", "above": "mean"}, {"column": "points", "above": 3}, {}):
        with pytest.raises(InputError, match="the options have score"):
            reading_of({"score": score, "group": ["sex"]})
    with pytest.raises(InputError, match="both score and decision"):
        reading_of(said | {"decision": "hired"})


def test_only_what_was_given_is_said() -> None:
    assert options_of(Reading("hired", ("sex",), utility_column="pay"), None) == {
        "decision": "hired",
        "group": ["sex"],
        "utility_column": "pay",
    }
    reading = Reading("d", ("g",), bins={"age": [18, "30.5", Fraction(81, 2)]}, label_map={"g": {1: 2}}, wide=read_wide("yes=a", 100))
    assert options_of(reading, Utility({"yes": 0.1}), positive="bad") == {
        "decision": "d",
        "group": ["g"],
        "positive": "bad",
        "wide": "yes=a",
        "total": "100",
        "utility": {"yes": "1/10"},
        "label_map": {"g": {"1": "2"}},
        "bins": {"age": ["18", "30.5", "40.5"]},
    }


def test_what_cannot_be_said_is_refused() -> None:
    law = Law.from_array([[1, 3], [2, 2]], kind="counts", decisions=["left", "right"])
    varied = Utility.from_function(lambda u, x, a: 1 + len(a[0]) if a == law.groups[0] else 1, law)
    with pytest.raises(InputError, match="varies with context or group"):
        options_of(Reading("d", ("g",)), varied)
    with pytest.raises(InputError, match="control character"):
        options_of(Reading("d", ("g",), unknown=("a\x1bb",)), None)
    with pytest.raises(InputError, match="4097 characters"):
        options_of(Reading("d" * 4097, ("g",)), None)
    with pytest.raises(InputError, match="rename them"):
        options_of(Reading("d", ("g",), wide=Wide((("yes", "", "a"),), (("", "100"),))), None)


BASE = {"decision": "hired", "group": ["sex"], "utility": {"yes": "1"}}


@pytest.mark.parametrize(
    ("change", "said"),
    [
        ({"groups": ["sex"]}, "unknown key 'groups'; known: .*did you mean 'group'"),
        ({"engine": "duckdb"}, "unknown key 'engine'"),
        ({"decision": 3}, "decision 3, an int; it must be a text"),
        ({"decision": ""}, "it must be a text"),
        ({"group": "sex"}, "group 'sex', a text; it must be a list of texts"),
        ({"group": []}, "it must be a list of texts"),
        ({"context": ["a", None]}, "it must be a list of texts"),
        ({"skip": True}, "it must be a whole number above 0"),
        ({"skip": -1}, "it must be a whole number above 0"),
        ({"fold_labels": False}, "it must be true, or absent"),
        ({"signed": 1}, "it must be true, or absent"),
        ({"utility": {"yes": 1}}, "it must be an object of texts"),
        ({"utility": {"yes": "many"}}, "the utility of decision 'yes'"),
        ({"utility": {"yes": "-1"}}, "negative"),
        ({"bins": {"age": "18"}}, "an object of lists of texts"),
        ({"bins": {"age": ["30", "18"]}}, "must rise"),
        ({"label_map": {"sex": {"m": None}}}, "an object of objects of texts"),
        ({"missing": "forget"}, "missing 'forget'; known: 'error'"),
        ({"utility_column": "pay"}, "both utility and utility_column"),
        ({"total": "all"}, "total goes with wide"),
        ({"truth": "a\nb"}, "control character"),
    ],
)
def test_nothing_else_is_read(change: dict[str, Any], said: str) -> None:
    with pytest.raises(InputError) as raised:
        reading_of({**BASE, **change})
    assert re.search(said, str(raised.value)) and "\n" not in str(raised.value)


@pytest.mark.parametrize("name", ["decision", "group"])
def test_a_table_has_decisions_and_groups(name: str) -> None:
    with pytest.raises(InputError, match=f"name no {name}"):
        reading_of({key: value for key, value in BASE.items() if key != name})
