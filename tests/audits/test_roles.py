"""Which column is which: the command that `inspect` proposes audits the outcome of the table, by the attributes of people."""

from __future__ import annotations

import itertools
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from fairaudit.audits.roles import Roles, proposed
from fairaudit.tables.engines.survey import Seen

ROWS = 4000


def seen(name: str, labels: str, *, missing: int = 0, different: int | None = None, rows: int = ROWS) -> Seen:
    """A column with those labels, equally often."""
    levels = labels.split("|")
    return Seen(name, {label: rows // len(levels) for label in levels}, different or len(levels), missing)


def numbers(name: str, first: int, last: int, rows: int = ROWS) -> Seen:
    return Seen(name, {str(n): 1 for n in range(first, last + 1)}, last - first + 1, 0)


INDEX = Seen("rownames", {str(n): 1 for n in range(ROWS)}, ROWS, 0)
SEX, RACE = seen("sex", "Male|Female"), seen("race", "Black|White|Other")
YES_NO = "no|yes"

TABLES: dict[str, tuple[list[Seen], dict[str, Any]]] = {
    "a mortgage": (
        [INDEX, seen("deny", YES_NO), seen("phist", YES_NO), seen("selfemp", YES_NO), seen("afam", YES_NO), seen("hschool", YES_NO)],
        {"decision": "deny", "utility": "yes", "burden": True, "group": ("afam",), "context": ()},
    ),
    "an arrest": (
        [INDEX, seen("released", "Yes|No"), seen("colour", "White|Black"), numbers("age", 15, 70), SEX],
        {"decision": "released", "utility": "Yes", "burden": False, "group": ("colour", "sex")},
    ),
    "an application": (
        [INDEX, seen("gender", "female|male"), seen("quality", "high|low"), seen("call", YES_NO), seen("honors", YES_NO)],
        {"decision": "call", "utility": "yes", "burden": False, "group": ("gender",), "context": ()},
    ),
    "counts": (
        [*(seen(name, labels, rows=24) for name, labels in (("Dept", "A|B|C"), ("Gender", "Male|Female"), ("Admit", "Rejected|Admitted"))),
         numbers("Freq", 8, 31)],
        {"decision": "Admit", "utility": "Admitted", "group": ("Gender",), "context": ("Dept",), "count": "Freq"},
    ),
    "raw 0 and 1": (
        [numbers("applicant_id", 1, 900), seen("hired", "0|1"), seen("ethnicity", "a|b|c"), seen("dept", "x|y")],
        {"decision": "hired", "utility": "1", "group": ("ethnicity",), "context": ("dept",), "unit": "applicant_id"},
    ),
    "only an age": (
        [seen("approved", "approved|not approved"), numbers("age", 18, 80)],
        {"decision": "approved", "utility": "approved", "group": ("age",), "bins": {"age": (25, 45, 65)}},
    ),
    "a missing label": (
        [seen("hired", YES_NO), seen("sex", "f|m", missing=3), seen("remark", "a|b", missing=9)],
        {"decision": "hired", "group": ("sex",), "missing": True},
    ),
    "a missing label elsewhere": ([seen("hired", YES_NO), SEX, seen("remark", "a|b", missing=9)], {"missing": False}),
    "a label that says no": (
        [seen("decision", "not hired|hired"), SEX],
        {"decision": "decision", "utility": "hired", "burden": False},
    ),
    "a harm by its label": ([seen("outcome", "denied|other"), RACE], {"decision": "outcome", "utility": "denied", "burden": True}),
    "names of models": (
        [seen("recommend", "no|maybe|yes"), seen("name", "Emily|Lakisha|Greg"), seen("model", "m1|m2")],
        {"decision": "recommend", "utility": "yes", "group": ("name",), "context": ("model",)},
    ),
    "probabilities": (
        [seen(name, labels, rows=8)
         for name, labels in (("decision", YES_NO), ("sex", "f|m"), ("x", "a|b"), ("prob", "0.1|0.9"), ("w", "1|2"))],
        {"decision": "decision", "group": ("sex",), "probability": "prob", "weight": "w", "context": ("x",)},
    ),
}  # fmt: skip


@pytest.mark.parametrize("table", TABLES)
def test_names_and_labels_say_which_column_is_which(table: str) -> None:
    columns, expected = TABLES[table]
    rows = 24 if table == "counts" else 8 if table == "probabilities" else ROWS
    found = proposed(columns, rows)
    assert {name: getattr(found, name) for name in expected} == expected


@given(st.permutations(TABLES["a mortgage"][0]))
def test_the_order_of_the_columns_says_nothing(columns: list[Seen]) -> None:
    found = proposed(columns, ROWS)
    assert (found.decision, found.group) == ("deny", ("afam",))


@given(
    st.lists(
        st.builds(
            Seen,
            st.sampled_from(["id", "sex", "age", "n", "p", "w", "hired", "denied", "dept", "x", "result", "foo", "race", "name"]),
            st.dictionaries(st.text(max_size=4), st.integers(1, 50), max_size=6),
            st.integers(0, 1000),
            st.integers(0, 5),
        ),
        max_size=8,
        unique_by=lambda column: column.name,
    ),
    st.integers(1, 1000),
)
def test_every_column_has_one_role_at_most(columns: list[Seen], rows: int) -> None:
    found: Roles = proposed(columns, rows)
    single = (found.decision, found.count, found.probability, found.weight, found.unit)
    taken = [name for name in itertools.chain(single, found.group, found.context) if name is not None]
    assert len(taken) == len(set(taken))
    assert set(taken) <= {column.name for column in columns}
    assert found.bins.keys() <= set(found.group)
