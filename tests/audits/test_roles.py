"""Which column is which: the command that `inspect` proposes audits the outcome of the table, by the attributes of people."""

from __future__ import annotations

import itertools
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from fairaudit.audits.roles import UNNAMED, Roles, proposed
from fairaudit.audits.wide_roles import wide_roles
from fairaudit.tables.engines.survey import Seen
from fairaudit.tables.wide import written_wide

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
    "wages": (
        [INDEX, numbers("exper", 1, 40), seen("sex", "male|female"), numbers("wage", 5, 90)],
        {"decision": None, "utility_column": "wage", "burden": False, "group": ("sex",)},
    ),
    "sentences": (
        [INDEX, seen("Crime", "Burglary|Swindle"), numbers("Years", 1, 15), seen("race", "b|w")],
        {"decision": None, "utility_column": "Years", "burden": True, "group": ("race",), "context": ("Crime",)},
    ),
    "a share that is no probability": (
        [INDEX, seen("card", YES_NO), numbers("age", 18, 80), Seen("share", {"0.1": 9, "0.2": 9}, 2, 0), numbers("months", 0, 500)],
        {"decision": "card", "utility": "yes", "group": ("age",), "bins": {"age": (25, 45, 65)}, "probability": None},
    ),
    "a label that says no interview": (
        [seen("outcome", "no_interview|interview"), seen("gender", "female|male")],
        {"decision": "outcome", "utility": "interview", "burden": False},
    ),
    "a label that says nothing": (
        [seen("admit", "Emergency|Elective"), seen("died", "No|Yes"), SEX],
        {"decision": "died", "utility": "Yes", "burden": True},
    ),
    "a bare number": (
        [seen("risk", "1|0"), SEX],
        {"decision": "risk", "said": ("that 1 in column 'risk' is a harm is a guess: only who made the table knows",)},
    ),
    "scores": (
        [numbers("final_score", 1, 99), SEX],
        {"decision": None, "utility_column": "final_score",
         "said": ("--score and --above-median, in the place of --utility-column, ask who is above the median",)},
    ),
    "columns of 0 and 1": (
        [seen("race_Black", "0|1"), Seen("race_White", {"1": 2000, "0": 2000}, 2, 0), Seen("frisked_N", {"0": 1000, "1": 3000}, 2, 0),
         Seen("frisked_Y", {"1": 1000, "0": 3000}, 2, 0), seen("frisky", "0|1")],
        {"decision": "frisked_Y", "utility": "1"},
    ),
    "participants": (
        [Seen("participant", {str(n): 20 for n in range(200)}, 200, 0), Seen("comment", {"x" * 60 + str(n): 1 for n in range(400)}, 400, 0),
         seen("hired", "0|1"), SEX],
        {"decision": "hired", "unit": "participant", "group": ("sex",), "context": ()},
    ),
    "a context that is mostly missing": (
        [seen("two_year_recid", "0|1"), RACE, seen("r_charge_degree", "F|M", missing=ROWS // 2)],
        {"decision": "two_year_recid", "burden": True, "context": (), "missing": False},
    ),
    "labels of people": (
        [seen("verdict", "guilty|acquitted"), seen("Victim", "White|Black"), seen("Level", "a|b")],
        {"decision": "verdict", "utility": "guilty", "burden": True, "group": ("Victim",)},
    ),
    "another language": (
        [seen("Geschlecht", "Frauen|Männer"), seen("Studiengang", "Jura|Chemie"), seen("Ergebnis", "abgelehnt|zugelassen"),
         numbers("Anzahl", 1, 9)],
        {"group": ("Geschlecht",), "context": ("Studiengang",), "count": "Anzahl", "decision": "Ergebnis", "utility": "zugelassen"},
    ),
    "rankings": (
        [seen("model", "m1|m2"), INDEX, seen("shown_order", "a b c|b a c|c b a"), seen("ranked_order", "c a b|b a c|a b c")],
        {"slots": ("shown_order",), "winner": "ranked_order", "context": ("model",), "decision": None, "group": ()},
    ),
    "candidates in columns": (
        [seen("job", "x|y"), *(seen(f"candidate_{n}", "Ann|Bob|Cem") for n in "123"), seen("chosen", "Ann|Bob|Cem")],
        {"slots": ("candidate_1", "candidate_2", "candidate_3"), "winner": "chosen", "context": ("job",)},
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


COUNTED: dict[str, tuple[dict[str, str], dict[str, Any]]] = {
    "decisions": (
        {"sex": "f m f m", "dept": "x x y y", "n_yes": "3 8 20 17", "n_no": "9 7 30 12"},
        {"wide": ("n_yes,n_no", ""), "utility": "n_yes", "group": ("sex",), "context": ("dept",), "burden": False},
    ),
    "harms": (
        {"Level": "1 1 2 2", "Victim": "White Black White Black", "Death": "2 1 2 1", "NoDeath": "60 181 15 21"},
        {"wide": ("Death,NoDeath", ""), "utility": "Death", "burden": True, "group": ("Victim",), "context": ("Level",)},
    ),
    "one of all": (
        {"race": "Black White", "stops": "1200 4000", "searches": "300 400"},
        {"wide": ("searches", "stops"), "burden": True, "group": ("race",)},
    ),
    "percentages": (
        {"major": "A A B B", "gender": "men women men women", "admitted": "62 82 63 68", "applicants": "825 108 560 25"},
        {"wide": ("admitted", "100"), "weight": "applicants", "group": ("gender",), "context": ("major",)},
    ),
    "shares": (
        {"race": "Black White", "stops": "1200 4000", "search_rate": "0.25 0.1"},
        {"wide": ("search_rate", "1"), "weight": "stops", "burden": True},
    ),
    "groups in the header": (
        {"Dept": "A B", "Male.Admitted": "512 353", "Male.Rejected": "313 207", "Female.Admitted": "89 17", "Female.Rejected": "19 8"},
        {
            "wide": (
                "admitted/male=Male.Admitted,rejected/male=Male.Rejected,admitted/female=Female.Admitted,rejected/female=Female.Rejected",
                "",
            ),
            "utility": "admitted",
            "group": ("gender",),
            "context": ("Dept",),
        },
    ),
    "groups in the header, of all": (
        {"dept": "A B Total", "men_applied": "9 8 17", "men_hired": "3 4 7", "women_applied": "7 6 13", "women_hired": "3 2 5",
         "men_pct": "33 50 41", "women_pct": "43 33 38"},
        {"wide": ("hired/men=men_hired,hired/women=women_hired", "men=men_applied,women=women_applied"), "context": ("dept",)},
    ),
}  # fmt: skip


@pytest.mark.parametrize("table", COUNTED)
def test_columns_of_counts_are_known_by_their_names_and_numbers(table: str) -> None:
    cells, expected = COUNTED[table]
    found = wide_roles({name: texts.split() for name, texts in cells.items()})
    assert found is not None and found.wide is not None
    counts, total = expected["wide"]
    assert written_wide(found.wide) == (counts, total)
    assert {name: getattr(found, name) for name in expected if name != "wide"} == {
        name: v for name, v in expected.items() if name != "wide"
    }
    assert bool(found.said) == (total in ("1", "100"))


@pytest.mark.parametrize(
    "cells",
    [
        {"sex": "f m f m", "approve": "1 0 1 1", "reject": "0 1 0 0"},
        {"sex": "f m f m", "hired": "yes no yes no", "score": "3 4 5 6"},
        {"sex": "f m f m", "hired": "3 4 5 6", "total": "9 9 9 9"},
        {"sex": "f m", "years": "3 4", "weight": "70 80"},
        {"Total": "Total Total", "yes": "1 2", "no": "3 4"},
        {"sex": "", "yes": "", "no": ""},
    ],
)
def test_other_tables_are_no_tables_of_counts(cells: dict[str, str]) -> None:
    """A row for each person, several rows for a group, no decisions, nothing but totals, nothing."""
    assert wide_roles({name: texts.split() for name, texts in cells.items()}) is None


@pytest.mark.parametrize(
    ("header", "lexicon", "counted"),
    [
        ("decision_pending granted total", (), "granted"),
        ("decision_pending total", (), UNNAMED),
        ("DecisionPending NoDecision", (), UNNAMED),
        ("granted denied", (), "granted"),
        ("granted denied", ("Granted",), "denied"),
        ("granted denied", ("granted", "denied"), UNNAMED),
        ("men_granted men_denied women_granted women_denied", ("granted",), "denied"),
        ("men_granted men_denied women_granted women_denied", ("granted", "DENIED"), UNNAMED),
        ("men_granted men_total women_granted women_total", ("granted",), UNNAMED),
    ],
)
def test_a_column_that_looks_undecided_is_never_what_counts(header: str, lexicon: tuple[str, ...], counted: str) -> None:
    names = header.split()
    cells = {"sex": ["f", "m"]} if not header.startswith("men") else {"dept": ["A", "B"]}
    cells |= {name: ["30", "40"] if name.endswith("total") else [str(k + 3), str(k + 5)] for k, name in enumerate(names)}
    found = wide_roles(cells, lexicon=lexicon)
    assert found is not None and found.wide is not None
    assert (found.utility, found.burden) == (counted, counted == "denied")


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
    single = (found.decision, found.utility_column, found.winner, found.count, found.probability, found.weight, found.unit)
    taken = [name for name in itertools.chain(single, found.group, found.context, found.slots) if name is not None]
    assert len(taken) == len(set(taken))
    assert set(taken) <= {column.name for column in columns}
    assert found.bins.keys() <= set(found.group)


@pytest.mark.parametrize("total", ["Summe", "total"])
def test_a_row_of_totals_makes_no_label_of_what_was_decided(total: str) -> None:
    columns = [
        Seen("Aktenzeichen", {total: 1, **{f"A{i}": 1 for i in range(60)}}, 61, 0),
        Seen("Geschlecht", {"weiblich": 40, "männlich": 20}, 2, 1),
        Seen("Entscheidung", {"bewilligt": 38, "abgelehnt": 22, "38": 1}, 3, 0),
        Seen("Anteil bewilligt", {"0.5": 20, "0.25": 20, "1": 20, "0.63": 1}, 4, 0),
    ]
    found = proposed(columns, 61)
    assert (found.decision, found.utility, found.utility_column) == ("Entscheidung", "bewilligt", None)
