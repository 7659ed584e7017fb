"""What an auditor states: days, periods and texts, and what of it is amiss."""

from __future__ import annotations

from datetime import date
from typing import Any

import pytest

from fairaudit.errors import InputError
from fairaudit.publications.ll144.stated import Stated, day, findings, last_day, period, stated_text

FULL = Stated(
    tool="Ranker",
    audit_date=date(2026, 1, 15),
    distribution_date=date(2026, 2, 1),
    data_source="applications",
    data_kind="historical",
    period=(date(2025, 1, 1), date(2025, 12, 31)),
)


@pytest.mark.parametrize(
    "text",
    [*("", "2026", "20260115", "2026-1-5", "2026-02-30", "15.01.2026", "2026-W03-4", " 2026-01-15", "2026-01-15T00:00"), "२०२६-०१-१५"],
)
def test_days_that_are_none_are_refused(text: str) -> None:
    with pytest.raises(InputError, match="a day such as 2026-01-15 is accepted"):
        day(text, "--audit-date")
    with pytest.raises(InputError, match="accepted"):
        period(f"{text}/2026-01-15")


@pytest.mark.parametrize("text", ["2026-01-15", "2026-01-15/", "/2026-01-15", "2026-01-15/2026-01-14", "2026-01-15/2026-01-16/2026-01-17"])
def test_periods_that_are_none_are_refused(text: str) -> None:
    with pytest.raises(InputError, match="period"):
        period(text)


def test_a_period_of_one_day_is_one() -> None:
    assert period("2026-01-15/2026-01-15") == (date(2026, 1, 15), date(2026, 1, 15))


@pytest.mark.parametrize("text", ["", "  ", "a\nb", "a\x00", "\ud800", "x" * 4097])
def test_texts_that_cannot_be_shown_are_refused(text: str) -> None:
    with pytest.raises(InputError, match="--justification"):
        stated_text(text, "--justification")


def test_a_year_ends_on_the_same_day() -> None:
    assert last_day(date(2026, 1, 15)) == date(2027, 1, 15)
    assert last_day(date(2024, 2, 29)) == date(2025, 2, 28)
    assert last_day(date(9999, 5, 1)) is None


def test_nothing_is_amiss_where_all_is_stated() -> None:
    assert findings(FULL) == ()


def test_what_is_not_stated_is_a_finding() -> None:
    assert len(findings(Stated())) == 5


@pytest.mark.parametrize(
    ("used", "said"),
    [
        (date(2027, 1, 15), ()),
        (date(2027, 1, 16), ("more than one year old",)),
        (date(2026, 1, 15), ()),
        (date(2026, 1, 14), ("before this audit",)),
    ],
)
def test_the_day_of_first_use_is_compared_with_that_of_the_audit(used: date, said: tuple[str, ...]) -> None:
    found = findings(Stated("Ranker", None, None, FULL.audit_date, used, "x", "historical"))
    assert len(found) == len(said)
    assert all(part in text for part, text in zip(said, found, strict=True))


@pytest.mark.parametrize(("last", "found"), [(date(2025, 12, 31), 0), (date(2026, 1, 1), 0), (date(2026, 1, 2), 1)])
def test_data_of_more_than_a_year_is_a_finding(last: date, found: int) -> None:
    stated = Stated("Ranker", None, None, date(2026, 1, 15), date(2026, 2, 1), "x", "historical", None, (date(2025, 1, 1), last))
    assert len(findings(stated)) == found


@pytest.mark.parametrize(
    ("stated", "said"),
    [
        ({"data_kind": "test"}, "--test-data-explanation"),
        ({"data_kind": "historical", "test_data": "none yet"}, "--data-kind test"),
        ({"test_data": "none yet"}, "--data-kind test"),
        ({"tool_version": "2"}, "--tool"),
        ({"audit_date": date(2025, 6, 1), "period": (date(2025, 1, 1), date(2025, 12, 31))}, "last day"),
    ],
)
def test_what_contradicts_itself_is_refused(stated: dict[str, Any], said: str) -> None:
    with pytest.raises(InputError, match=said):
        Stated(**stated)
