"""What the auditor states for a publication under New York City's rule: the tool, the dates and the data; and what of it is amiss."""

from __future__ import annotations

from contextlib import suppress
from dataclasses import dataclass
from datetime import date
from typing import Literal

from fairaudit.attestations.statement import Stated as Attested
from fairaudit.attestations.statement import split_period
from fairaudit.attestations.strict import check_text
from fairaudit.errors import InputError, shown

__all__ = ["Stated", "contradictions", "day", "findings", "last_day", "period", "stated_text"]


@dataclass(frozen=True)
class Stated:
    """What is stated, none of which a certificate shows.

    Attributes
    ----------
    tool, tool_version, auditor : str or None
        What was audited, and by whom.
    audit_date, distribution_date : date or None
        Of the latest audit; when the employer began to use the tool.
    data_source, test_data : str or None
        Where the data is from; why there is no historical data, and how test data was made.
    data_kind : {"historical", "test"} or None
        Which data it is.
    period : (date, date) or None
        First and last day of the data.
    justification : str or None
        Why categories below 2 % are left out of the impact ratios; where it is None they are not.

    Raises
    ------
    InputError
        If two of them contradict each other.
    """

    tool: str | None = None
    tool_version: str | None = None
    auditor: str | None = None
    audit_date: date | None = None
    distribution_date: date | None = None
    data_source: str | None = None
    data_kind: Literal["historical", "test"] | None = None
    test_data: str | None = None
    period: tuple[date, date] | None = None
    justification: str | None = None

    def __post_init__(self) -> None:
        """Refuse what cannot be."""
        if self.data_kind == "test" and self.test_data is None:
            raise InputError(
                "--data-kind test needs --test-data-explanation: why there is no historical data, and how the test data was made"
            )
        if self.data_kind != "test" and self.test_data is not None:
            raise InputError("--test-data-explanation goes with --data-kind test")
        if self.tool_version is not None and self.tool is None:
            raise InputError("--tool-version goes with --tool, the name of the tool")
        if self.period is not None and self.audit_date is not None and self.audit_date < self.period[1]:
            raise InputError(f"--audit-date {self.audit_date} is before {self.period[1]}, the last day of --period; one of them is wrong")


def stated_text(text: str | None, option: str) -> str | None:
    """Give a text back; None where none was given.

    Raises
    ------
    InputError
        If it is empty, too long, or not on one line.
    """
    if text is None:
        return None
    if not check_text(text, option).strip():
        raise InputError(f"{option} is empty; write the text, or leave the option away")
    return text.strip()


def day(text: str | None, option: str) -> date | None:
    """Read a day; None where none was given.

    Raises
    ------
    InputError
        If it is none.

    Examples
    --------
    >>> day("2026-01-15", "--audit-date")
    datetime.date(2026, 1, 15)
    """
    if text is None:
        return None
    with suppress(ValueError):
        found = date.fromisoformat(text)
        if found.isoformat() == text:
            return found
    raise InputError(f"{option} is {shown(text)}; a day such as 2026-01-15 is accepted")


def period(text: str | None) -> tuple[date, date] | None:
    """Read a first and a last day.

    Raises
    ------
    InputError
        If they are no days, or in the wrong order.

    Examples
    --------
    >>> period("2025-01-01/2025-12-31")
    (datetime.date(2025, 1, 1), datetime.date(2025, 12, 31))
    """
    if text is None:
        return None
    first, last = split_period(text, "--period")
    return date.fromisoformat(first), date.fromisoformat(last)


def last_day(audited: date) -> date | None:
    """The last day on which no more than one year has passed since an audit; None where the calendar ends before.

    Examples
    --------
    >>> str(last_day(date(2026, 1, 15))), str(last_day(date(2024, 2, 29)))
    ('2027-01-15', '2025-02-28')
    """
    if audited.year == date.max.year:
        return None
    return audited.replace(year=audited.year + 1, day=28 if (audited.month, audited.day) == (2, 29) else audited.day)


def contradictions(stated: Stated, attested: Attested) -> tuple[str, ...]:
    """Where an attestation states something else.

    Examples
    --------
    >>> contradictions(Stated(tool="Ranker"), Attested(system="Ranker 2"))
    ("The tool is 'Ranker' here, and 'Ranker 2' in the attestation.",)
    """
    days = None if stated.period is None else f"{stated.period[0]} to {stated.period[1]}"
    pairs = (
        ("The tool", stated.tool, attested.system),
        ("The version of the tool", stated.tool_version, attested.system_version),
        ("The period of the data", days, None if attested.period is None else " to ".join(attested.period)),
    )
    return tuple(
        f"{what} is {shown(here)} here, and {shown(there)} in the attestation."
        for what, here, there in pairs
        if here is not None and there is not None and here != there
    )


def findings(stated: Stated) -> tuple[str, ...]:
    """What the rule asks for and was not stated, and dates that do not go with it."""
    found = [
        f"The rule asks for {what}, which is not stated here."
        for what, given in (
            ("the date of the latest bias audit", stated.audit_date),
            ("the distribution date of the tool, when this employer began to use it", stated.distribution_date),
            ("the source and an explanation of the data", stated.data_source),
        )
        if given is None
    ]
    if stated.data_kind is None:
        found.append("Whether the data is historical or test data is not stated; of test data the rule asks why, and how it was made.")
    if stated.tool is None:
        found.append("The tool is not named.")
    if stated.audit_date is not None and stated.distribution_date is not None:
        limit = last_day(stated.audit_date)
        if limit is not None and stated.distribution_date > limit:
            found.append(
                f"On the distribution date, {stated.distribution_date}, the audit of {stated.audit_date} was more than one year old; "
                "the rule does not let a tool be used then."
            )
        if stated.distribution_date < stated.audit_date:
            found.append(
                f"The distribution date, {stated.distribution_date}, is before this audit, of {stated.audit_date}; the rule asks for one "
                "before use, so for the time between an earlier audit is needed, of which this page says nothing."
            )
    if stated.period is not None and (stated.period[1] - stated.period[0]).days >= 366:
        found.append(f"The data is of more than one year: {stated.period[0]} to {stated.period[1]}.")
    return tuple(found)
