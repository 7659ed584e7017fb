"""The three tables of New York City's rule, against its printed examples and by hand."""

from __future__ import annotations

from fractions import Fraction

import pytest
from ll144_examples import (
    CUT_OFF,
    HISPANIC,
    RACES,
    SCORING_BOTH,
    SCORING_RACE,
    SCORING_SEX,
    SELECTION_BOTH,
    SELECTION_RACE,
    SELECTION_SEX,
    WHITE,
    Printed,
    rounded,
)

from fairaudit.publications.ll144.tables import ImpactTable, Unknown, impact_table, three_tables

NOBODY = Unknown()


def made(printed: Printed, *, exclude: bool = False) -> ImpactTable:
    return impact_table("x", {category: (s, n) for category, (n, s, _, _) in printed.items()}, NOBODY, exclude=exclude)


def both(printed: Printed) -> dict[tuple[str | None, str | None], tuple[int, int]]:
    return {category: (s, n) for category, (n, s, _, _) in printed.items()}


@pytest.mark.parametrize("printed", [SELECTION_SEX, SELECTION_RACE, SELECTION_BOTH, SCORING_SEX, SCORING_RACE, SCORING_BOTH])
def test_the_rules_examples_to_the_printed_digit(printed: Printed) -> None:
    table = made(printed)
    assert len(table.lines) == len(printed)
    for line, (category, (people, selected, rate, ratio)) in zip(table.lines, printed.items(), strict=True):
        assert ((line.sex, line.race), line.applicants, line.selected) == (category, people, selected)
        assert line.rate is not None
        assert line.ratio is not None
        exact = "64.3%" if printed is SCORING_RACE and category == CUT_OFF else rate
        assert (rounded(line.rate, rate), rounded(line.ratio, ratio)) == (exact, ratio)


def test_ratios_are_of_counts_and_not_of_printed_rates() -> None:
    other = 0
    for printed in (SELECTION_SEX, SELECTION_RACE, SELECTION_BOTH):
        rates = {category: Fraction(rate.removesuffix("%")) for category, (_, _, rate, _) in printed.items()}
        other += sum(rounded(rates[category] / max(rates.values()), row[3]) != row[3] for category, row in printed.items())
    assert other == 9


def test_margins_of_the_intersections_are_the_other_tables_but_for_one_row() -> None:
    for whole, sex, race in ((SELECTION_BOTH, SELECTION_SEX, SELECTION_RACE), (SCORING_BOTH, SCORING_SEX, SCORING_RACE)):
        tables = three_tables(both(whole), NOBODY)
        assert [table.name for table in tables] == ["sex", "race", "intersection"]
        margins = {(line.sex, line.race): (line.applicants, line.selected) for table in tables[:2] for line in table.lines}
        stated = {category: row[:2] for category, row in {**sex, **race}.items()}
        different = {category for category in margins if margins[category] != stated[category]}
        assert different == ({("", HISPANIC)} if whole is SELECTION_BOTH else set())
    assert margins["", HISPANIC] == (28, 18)


def test_fourteen_intersections_have_one_comparator() -> None:
    table = three_tables(both(SELECTION_BOTH), NOBODY)[2]
    assert len(table.lines) == 14
    assert [(line.sex, line.race) for line in table.lines if line.ratio == 1] == [("Male", WHITE)]


def test_rows_that_share_the_highest_rate_both_have_ratio_one() -> None:
    table = made(SCORING_BOTH)
    assert [(line.sex, line.race) for line in table.lines if line.ratio == 1] == [("Male", HISPANIC), ("Male", RACES[3])]


def test_leaving_small_categories_out_is_optional_and_changes_no_other_ratio_here() -> None:
    small = {("Male", RACES[5]), ("Female", RACES[3]), ("Female", RACES[5])}
    kept, left = made(SELECTION_BOTH), made(SELECTION_BOTH, exclude=True)
    assert all(line.status == "compared" for line in kept.lines)
    assert {(line.sex, line.race) for line in left.lines if line.status == "excluded"} == small
    for before, after in zip(kept.lines, left.lines, strict=True):
        assert after.ratio == (None if after.status == "excluded" else before.ratio)
        assert (after.rate, after.applicants) == (before.rate, before.applicants)
    assert [line.race for line in made(SELECTION_RACE, exclude=True).lines if line.status == "excluded"] == [RACES[5]]


@pytest.mark.parametrize(("people", "status"), [(2, "compared"), (1, "excluded"), (0, "empty")])
def test_exactly_two_percent_may_not_be_left_out(people: int, status: str) -> None:
    counts = {("Male", ""): (10, 100 - people), ("Female", ""): (0, people)}
    assert impact_table("sex", counts, NOBODY, exclude=True).lines[1].status == status


def test_the_two_percent_are_decided_in_integers() -> None:
    n = 10**40
    counts = {("Male", ""): (n, 49 * n + 1), ("Female", ""): (n, n)}
    assert impact_table("sex", counts, NOBODY, exclude=True).lines[1].status == "excluded"
    counts = {("Male", ""): (n, 49 * n), ("Female", ""): (n, n)}
    assert impact_table("sex", counts, NOBODY, exclude=True).lines[1].status == "compared"


def test_what_is_left_out_is_no_comparator() -> None:
    counts = {("Male", ""): (50, 100), ("Female", ""): (1, 1)}
    assert [line.ratio for line in impact_table("sex", counts, NOBODY).lines] == [Fraction(1, 2), 1]
    left = impact_table("sex", counts, NOBODY, exclude=True)
    assert [line.ratio for line in left.lines] == [1, None]
    assert left.lines[1].rate == 1


def test_unknown_people_are_no_part_of_the_two_percent() -> None:
    counts = {("Male", ""): (10, 90), ("Female", ""): (1, 2)}
    assert impact_table("sex", counts, Unknown(0, 10**6), exclude=True).lines[1].status == "compared"


def test_all_rates_zero_and_nobody_at_all() -> None:
    zero = impact_table("sex", {("Male", ""): (0, 3), ("Female", ""): (0, 0)}, NOBODY)
    assert zero.nobody_selected
    assert [(line.ratio, line.status) for line in zero.lines] == [(1, "compared"), (None, "empty")]
    nobody = three_tables({}, Unknown(1, 2))
    assert [(table.top, table.least(), table.applicants, table.worst) for table in nobody[:1]] == [(None, None, 0, None)]
    assert all(line.status == "empty" and line.rate is None and line.share is None for table in nobody for line in table.lines)


def test_who_is_in_which_table() -> None:
    people = {("Male", WHITE): (3, 5), ("Female", WHITE): (2, 5), ("Male", None): (1, 4), (None, WHITE): (2, 2), (None, None): (0, 7)}
    complete = three_tables(people, Unknown(1, 1, 2))
    assert [(table.applicants, table.unknown) for table in complete] == [(10, Unknown(4, 11, 2))] * 3
    available = three_tables(people, NOBODY, available=True)
    assert [(table.applicants, table.unknown) for table in available] == [
        (14, Unknown(2, 7)),
        (12, Unknown(1, 10)),
        (10, Unknown(3, 10)),
    ]
    alone = three_tables({("Male", None): (1, 4), ("Female", None): (1, 2), (None, None): (0, 7)}, NOBODY, race=False)
    assert [(table.name, table.applicants, table.unknown) for table in alone] == [("sex", 6, Unknown(0, 7))]


def test_the_worst_case_is_of_what_is_compared_and_of_everything() -> None:
    counts = {("Male", ""): (50, 100), ("Female", ""): (30, 100), ("Other", ""): (0, 1)}
    table = impact_table("sex", counts, Unknown(0, 10), exclude=True)
    assert table.worst is not None
    assert table.worst_of_all is not None
    assert (table.worst.ratio, table.worst.pair) == (Fraction(30, 110) / Fraction(1, 2), (1, 0))
    assert table.worst_of_all.ratio == 0
    assert table.worst_of_all.pair == (2, 0)
