"""Rows of the tables of a page against the published counts of Berkeley, and against plain fractions."""

from __future__ import annotations

from fractions import Fraction

import pytest
from certificate_kinds import admissions, infinite, many_columns, signed, weighted

import fairaudit as fa
from fairaudit.inference.ends import cell_ends
from fairaudit.inference.table_comparisons import local_comparison
from fairaudit.reports.content import describe
from fairaudit.reports.expectations import Expectations
from fairaudit.reports.rows import MOST_ROWS, context_rows, ranked, short, table_rows
from fairaudit.reports.views import Views

PUBLISHED = {  # admitted and applied
    "A": {"Male": (512, 825), "Female": (89, 108)},
    "B": {"Male": (353, 560), "Female": (17, 25)},
    "C": {"Male": (120, 325), "Female": (202, 593)},
    "D": {"Male": (138, 417), "Female": (131, 375)},
    "E": {"Male": (53, 191), "Female": (94, 393)},
    "F": {"Male": (22, 373), "Female": (24, 341)},
}


def of(result: fa.Result) -> Expectations:
    found = describe(result.certificate.document).expectations
    assert found is not None
    return found


def test_every_row_of_berkeley() -> None:
    rows = table_rows(of(admissions()))
    assert [(row.context, row.group) for row in rows] == [(dept, sex) for dept, both in PUBLISHED.items() for sex in both]
    for row in rows:
        admitted, applied = PUBLISHED[row.context][row.group]
        best = max(Fraction(*pair) for pair in PUBLISHED[row.context].values())
        assert (row.counted, row.decisions, row.of) == (f"{admitted:,}", f"{applied:,}", f"{admitted:,} of {applied:,}")
        assert row.value.value == Fraction(admitted, applied) and row.best == (row.value.value == best)
        assert row.apart.value == best / Fraction(admitted, applied) and row.less.value == Fraction(admitted, applied) / best
        assert row.title == f"Dept={row.context}, Gender={row.group}"


def test_intervals_of_rows_are_those_of_their_draws() -> None:
    result = admissions()
    wanted = {cell.label: cell_ends(cell, Fraction(1, 40)) for cell in local_comparison(result.law, result.utility).cells}
    for row in table_rows(of(result)):
        assert row.ends is not None
        assert (row.ends[0].value, row.ends[1].value) == wanted[(row.context,), (row.group,)]
        assert (row.ends[0].rounding, row.ends[1].rounding) == ("down", "up")


def test_contexts_are_ranked_by_their_ratios() -> None:
    listed, size = ranked(of(admissions()))
    ratios = {dept: max(a / b for a in rates for b in rates) for dept, rates in _rates().items()}
    assert size == 6 and [one.context for one in listed] == sorted(ratios, key=ratios.__getitem__, reverse=True)
    for one in listed:
        assert one.apart.value == ratios[one.context] == Fraction(one.higher.value.value) / Fraction(one.lower.value.value)


def _rates() -> dict[str, list[Fraction]]:
    return {dept: [Fraction(*pair) for pair in both.values()] for dept, both in PUBLISHED.items()}


def test_who_fares_worst_stands_first_and_the_best_last() -> None:
    for burden in (False, True):
        rows = context_rows(of(admissions()), 0, 2, burden=burden)
        assert [row.group for row in rows] == (["Female", "Male"] if burden else ["Male", "Female"])
        assert [row.best for row in rows] == [False, True]
    law = fa.Law.from_array([[i, 20 - i] for i in range(1, 20)], kind="counts")
    found = of(fa.certify(law, {"0": 1}))
    assert [row.value.value for row in context_rows(found, 0, 19, most=4)] == [Fraction(i, 20) for i in (1, 2, 3, 19)]


def test_infinite_ratios_negative_utilities_and_probabilities() -> None:
    rows = table_rows(of(infinite()))
    assert [(row.apart.decimal, row.less.decimal) for row in rows if not row.best] == [("infinite", "0")] * 2
    for row in table_rows(of(signed())):
        assert row.best or Fraction(row.apart.value) > 0
    assert {(row.decisions, row.counted, row.of) for row in table_rows(of(weighted()))} == {("", "", "")}


def test_long_tables_are_not_written_out() -> None:
    many = MOST_ROWS + 1
    law = fa.Law.from_array([[1 + i % 7, 3] for i in range(many)], kind="counts")
    views = Views(describe(fa.certify(law, {"0": 1}, confidence=None).certificate.document))
    assert views.rows == [] and views.cells == many
    assert views.overall is not None and len(views.overall.rows) + len(views.overall.folded) + views.overall.more == many


def test_labels_of_tuples_are_short() -> None:
    row = table_rows(of(many_columns()))[0]
    assert (row.context, row.group) == ("Zürich / 1973", "weiblich ♀ / <30")
    assert row.title == "Ort=Zürich, Jahr=1973, Geschlecht=weiblich ♀, Älter=<30"
    assert short({}) == ""


@pytest.mark.parametrize(("limit", "edge"), [("5/4", Fraction(89, 108) * 4 / 5), ("2", Fraction(89, 108) / 2)])
def test_the_limit_stands_where_a_group_would_reach_it(limit: str, edge: Fraction) -> None:
    views = Views(describe(admissions(max_local_ratio=limit).certificate.document))
    (_, marks), _ = views.contexts[0].rows
    assert f'class="limit" x1="{views.axis.at(edge)}%"' in marks and views.contexts[0].limited
    assert views.overall is not None and not views.overall.limited and "limit" not in views.overall.rows[0][1]


def test_a_group_that_is_one_below_the_best_is_not_the_best() -> None:
    table = {"u": ["good", "bad", "good", "bad"], "a": ["f", "f", "m", "m"], "n": [75, 25, 25, 75]}
    found = fa.audit(table, decision="u", group="a", count="n", utility={"good": 1, "bad": -1}, difference=True)
    rows = Views(describe(found.certificate.document))._overall
    assert [(row.group, row.best, row.apart.value) for row in rows] == [("m", False, 1), ("f", True, 0)]


def test_of_units_contexts_with_one_group_have_rows_without_means_over_units() -> None:
    table = {"u": list("yynynyy"), "a": list("fffmmmm"), "x": list("pppppqq"), "who": list("1123455")}
    found = fa.audit(table, decision="u", group="a", context="x", unit="who", utility="y")
    rows = Views(describe(found.certificate.document)).rows
    assert [(row.context, row.group, row.over_units is not None, row.ends is not None) for row in rows] == [
        ("p", "f", True, True),
        ("p", "m", True, True),
        ("q", "m", False, False),
    ]
    assert "<title>" in found.report()
