"""Columns of counts become rows of decisions: the law is that of the long table, and no percentage or total passes for a count."""

from __future__ import annotations

from fractions import Fraction
from pathlib import Path
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

import fairaudit as fa
from fairaudit.cli import main
from fairaudit.errors import InputError
from fairaudit.tables.wide import read_wide, written_wide

DEATHS: dict[str, list[Any]] = {  # Georgia, by aggravation of the crime and race of the victim: Woodworth, Baldus, Pulaski
    "Aggravation": [1, 1, 2, 2, 3, 3, 4, 4, 5, 5, 6, 6],
    "Victim": ["White", "Black"] * 6,
    "Death": [2, 1, 2, 1, 6, 2, 9, 2, 9, 4, 17, 4],
    "NoDeath": [60, 181, 15, 21, 7, 9, 3, 4, 0, 3, 0, 0],
}


def written(path: Path, table: dict[str, list[Any]]) -> str:
    rows = [",".join(table), *(",".join(map(str, row)) for row in zip(*table.values(), strict=True))]
    path.write_text("\n".join(rows) + "\n")
    return str(path)


def test_counts_by_decision_are_the_long_table() -> None:
    wide = fa.audit(DEATHS, wide=["Death", "NoDeath"], group="Victim", context="Aggravation", utility="Death", burden=True)
    long: dict[str, list[Any]] = {"Aggravation": [], "Victim": [], "decision": [], "n": []}
    for x, a, died, lived in zip(*DEATHS.values(), strict=True):
        for decision, n in (("Death", died), ("NoDeath", lived)):
            for name, value in zip(long, (x, a, decision, n), strict=True):
                long[name].append(value)
    expected = fa.audit(long, decision="decision", group="Victim", context="Aggravation", count="n", utility="Death", burden=True)
    assert wide.certificate.document == expected.certificate.document
    assert fa.verify(wide.certificate.document).ok
    assert wide.global_ is not None and wide.global_.ratio == Fraction(45, 130) / Fraction(14, 232)


def test_groups_in_the_header_and_totals_for_each() -> None:
    table: dict[str, list[Any]] = {
        "dept": ["A", "B"],
        "men_applied": [825, 560],
        "men_in": [512, 353],
        "women_applied": [108, 25],
        "women_in": [89, 17],
    }
    result = fa.audit(
        table,
        wide={("in", "men"): "men_in", ("in", "women"): "women_in"},
        total={"men": "men_applied", "women": "women_applied"},
        group="sex",
        context="dept",
        utility="in",
    )
    assert result.law.decisions == ("in", "not in")
    assert result.local is not None
    assert result.local.ratio == Fraction(89, 108) / Fraction(512, 825)
    assert dict(result.local.witness.higher) == {"sex": "women"}


def test_percentages_are_probabilities_and_never_counts(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """As the table `admissions` of the R package dslabs has them: percentages of applicants, in a column called admitted."""
    table: dict[str, list[Any]] = {
        "major": ["A", "A", "B", "B"],
        "gender": ["men", "women"] * 2,
        "admitted": [62, 82, 63, 68],
        "applicants": [825, 108, 560, 25],
    }
    with pytest.raises(InputError, match="row 4: 68 in column 'admitted' is more than 25 in column 'applicants'; if these are percentages"):
        fa.audit(table, wide={"yes": "admitted"}, total="applicants", group="gender", context="major", utility="yes")
    result = fa.audit(table, wide={"yes": "admitted"}, total=100, weight="applicants", group="gender", context="major", utility="yes")
    assert result.law.kind == "probabilities" and not result.intervals
    assert result.local is not None and result.global_ is not None
    assert result.local.ratio == Fraction(82, 62)
    men, women = Fraction(62 * 825 + 63 * 560, 825 + 560), Fraction(82 * 108 + 68 * 25, 108 + 25)
    assert result.global_.ratio == women / men
    path = written(tmp_path / "admissions.csv", table)
    common = ["--group", "gender", "--context", "major", "--utility", "yes"]
    assert main(["certify", path, "--wide", "yes=admitted", "--total", "100", "--weight", "applicants", *common]) == 0
    assert "shares of 100; of how many decisions is not known" in capsys.readouterr().err
    assert main(["certify", path, "--wide", "yes=admitted", "--total", "applicants", *common]) == 2
    assert "line 5: 68 in column 'admitted' is more than 25" in capsys.readouterr().err


def test_numbers_that_may_be_percentages_are_remarked() -> None:
    table: dict[str, list[Any]] = {"sex": ["f", "m"], "hired": [62, 81], "applied": [825, 108]}
    result = fa.audit(table, wide=["hired"], total="applied", group="sex", utility="hired")
    assert any("if they are percentages" in note for note in result.law.notes)
    table["hired"] = [62, 101]
    assert not fa.audit(table, wide=["hired"], total="applied", group="sex", utility="hired").law.notes


TOTALS: dict[str, list[Any]] = {
    "dept": ["A", "A", "B", "B", "Total"],
    "sex": ["f", "m", "f", "m", ""],
    "yes": [3, 8, 20, 17, 48],
    "no": [9, 7, 30, 12, 58],
}


def test_rows_of_totals_are_named_and_not_counted() -> None:
    result = fa.audit(TOTALS, wide=["yes", "no"], group="sex", context="dept", utility="yes")
    without = {name: column[:-1] for name, column in TOTALS.items()}
    expected = fa.audit(without, wide=["yes", "no"], group="sex", context="dept", utility="yes")
    assert result.certificate.document == expected.certificate.document
    assert result.law.notes == ("row 5 is the total of others ('Total') and not counted again",)


def test_a_row_without_a_label_is_a_total_if_it_is_that_of_others() -> None:
    """As where the word stands in a column that is not used."""
    options: dict[str, Any] = {"wide": ["yes", "no"], "group": "sex", "utility": "yes"}
    result = fa.audit(TOTALS, **options)
    assert int(result.law.weights.sum()) == 48 + 58
    assert result.law.notes == ("row 5 is the total of others (without a label) and not counted again",)
    with pytest.raises(InputError, match="the label is missing"):
        fa.audit({**TOTALS, "no": [9, 7, 30, 12, 59]}, **options)


def test_rows_of_totals_of_a_group_and_of_all() -> None:
    table: dict[str, list[Any]] = {"sex": ["f", "m", "All", "f", "m", "All", "Total"], "job": ["x", "x", "x", "y", "y", "y", "Total"]}
    table |= {"yes": [1, 2, 3, 4, 5, 9, 12], "no": [5, 5, 10, 5, 5, 10, 20]}
    result = fa.audit(table, wide=["yes", "no"], group="sex", context="job", utility="yes")
    assert int(result.law.weights.sum()) == 32
    assert "3 rows, first row 3, are totals of others" in result.law.notes[0]


@pytest.mark.parametrize(
    ("change", "options", "words"),
    [
        (
            {"yes": [3, 8, 20, 17, 47]},
            {},
            "row 5: the label 'Total' in column 'dept' says that the row is a total of others, but the others have 48",
        ),
        ({"yes": [3, 8.5, 20, 17, 48]}, {}, "column 'yes', row 2: 8.5 is not a whole number of decisions"),
        ({"yes": ["3", "8", "20 %", "17", "48"]}, {}, "column 'yes', row 3: '20 %' is a percentage"),
        ({"yes": [3, -8, 20, 17, 48]}, {}, "column 'yes', row 2: -8 is negative"),
        ({"yes": ["3", "", "20", "17", "48"]}, {}, "column 'yes', row 2: the number is missing"),
        ({"yes": ["3", "many", "20", "17", "48"]}, {}, "column 'yes', row 2"),
        ({}, {"wide": ["yes", "perhaps"]}, "there is no column 'perhaps'"),
        ({}, {"wide": ["yes"]}, "name the column of the others, too, or that of all with total"),
        ({}, {"wide": ["yes"], "total": "yes"}, "total names a column that wide names, too"),
        ({}, {"wide": []}, "wide names no column of counts"),
        ({}, {"wide": {"yes": "yes", "no": "yes"}}, "wide names the column 'yes' twice"),
        ({}, {"wide": "yes=yes,yes=no"}, "wide names the decision 'yes' twice"),
        ({}, {"wide": "yes/f=yes,no=no"}, "names a group for some columns and none for others"),
        ({}, {"wide": {"yes": "yes", "not yes": "no"}, "total": 100}, "shares do not say so"),
        ({}, {"wide": {"yes": "yes"}, "total": "f=no,m=no"}, "it needs one column"),
        ({}, {"wide": {"yes": "yes", "not yes": "no"}, "total": "no"}, "total names a column"),
        ({}, {"wide": {1: "yes"}}, "neither a decision nor a pair"),
        ({}, {"wide": "yes==no"}, "not of the form decision=column"),
        ({"dept": list("AABBC")}, {"wide": ["yes"], "total": 1}, "row 1: 3 in column 'yes' is more than the 1 that they are shares of"),
        ({}, {"total": 0}, "shares are of a number above 0"),
        ({}, {"count": "yes"}, "wide does not go with count"),
        ({}, {"unit": "dept"}, "wide does not go with unit"),
        ({}, {"truth": "dept"}, "wide does not go with truth"),
        ({}, {"group": ()}, "no group column was named"),
        ({}, {"decision": "sex"}, "a group or context is called 'sex'"),
        ({}, {"wide": None, "total": "yes"}, "total goes with wide"),
        ({}, {"weight": "yes"}, "weight goes with probability"),
    ],
)
def test_refusals(change: dict[str, list[Any]], options: dict[str, Any], words: str) -> None:
    with pytest.raises(InputError) as caught:
        fa.audit({**TOTALS, **change}, **{"wide": ["yes", "no"], "group": "sex", "context": "dept", "utility": "yes", **options})
    assert words in str(caught.value)
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize("name", ["table.xlsx.csv", "table.jsonl", "table.parquet"])
def test_every_reader_gives_the_same(tmp_path: Path, name: str) -> None:
    import duckdb

    source = written(tmp_path / "source.csv", DEATHS)
    path = str(tmp_path / name)
    form = {"jsonl": "(format json)", "parquet": "(format parquet)", "csv": "(format csv, delimiter ';')"}[name.rpartition(".")[2]]
    duckdb.sql(f"copy (select * from '{source}') to '{path}' {form}")
    options: dict[str, Any] = {"wide": ["Death", "NoDeath"], "group": "Victim", "context": "Aggravation", "utility": "Death"}
    expected, found = fa.audit(DEATHS, **options), fa.audit(path, **options)
    assert expected.local is not None and found.local is not None
    assert (found.local.ratio, found.global_) == (expected.local.ratio, expected.global_)


def test_equal_rows_of_a_file_add_up(tmp_path: Path) -> None:
    path = tmp_path / "table.jsonl"
    path.write_text('{"sex": "f", "yes": 2, "no": 3}\n' * 2 + '{"sex": "m", "yes": 1, "no": 4}\n')
    law = fa.audit(path, wide=["yes", "no"], group="sex", utility="yes").law
    assert sorted(law.weights.sum(axis=1).tolist()) == [5, 10]
    with pytest.raises(InputError, match="occurs 2 times; of shares each combination has one row"):
        fa.audit(path, wide=["yes", "no"], total=100, group="sex", utility="yes")


def test_options_that_have_their_own_columns_refuse_it(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = written(tmp_path / "t.csv", DEATHS)
    named = ["certify", path, "--wide", "Death,NoDeath", "--group", "Victim", "--utility", "Death"]
    for more, words in (
        (["--print-sql", "duckdb"], "--print-sql goes with a log"),
        (["--slots", "Victim", "--winner", "Death"], "--group does not go with --slots"),
        (["--group-probability", path], "--wide does not go with --group-probability"),
        (["--in-parts", "--decision", "d", "--context", "Aggravation"], "--in-parts does not go with --wide"),
    ):
        assert main([*named, *more]) == 2
        assert words in capsys.readouterr().err
    assert main(["certify", path, "--slots", "Victim", "--winner", "Death", "--wide", "Death,NoDeath"]) == 2
    assert "--wide does not go with --slots" in capsys.readouterr().err
    assert main(["certify", "--from-monitor", "none", "--wide", "Death,NoDeath"]) == 2
    assert "--wide was settled" in capsys.readouterr().err
    assert main(["certify", path, "--total", "Death", "--decision", "Victim", "--group", "Victim", "--utility", "Black"]) == 2
    assert "--total goes with --wide" in capsys.readouterr().err


NAMES = st.text(min_size=1, max_size=5).filter(lambda text: text == text.strip())


@given(st.dictionaries(NAMES, NAMES, min_size=2, max_size=4), st.booleans())
def test_what_is_written_is_read_again(columns: dict[str, str], in_headers: bool) -> None:
    if len(set(columns.values())) < len(columns) or any(name.startswith("not ") or name == "none of these" for name in columns):
        return
    counts: Any = {(decision, 'a "b", c/d=e'): name for decision, name in columns.items()} if in_headers else columns
    wide = read_wide(counts)
    assert read_wide(written_wide(wide)[0]) == wide


def test_what_is_in_no_column_of_several_is_said() -> None:
    table = {"sex": ["f", "m"], "yes": [62, 82], "no": [38, 18], "total": [100, 101]}
    found = fa.audit(table, wide=["yes", "no"], total="total", group="sex", utility="yes")
    assert [note for note in found.notes if "none of these" in note] == [
        "'yes', 'no' do not add up to the total: 1 decision of the totals is counted as 'none of these'"
    ]
    whole = fa.audit({**table, "total": [100, 100]}, wide=["yes", "no"], total="total", group="sex", utility="yes")
    assert not any("none of these" in note for note in whole.notes)
