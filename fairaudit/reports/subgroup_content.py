"""What a report says of a certificate of the most unequal subgroups, before it has a shape."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from fractions import Fraction
from typing import Any

from fairaudit.certificates.reader import number
from fairaudit.measures.limits import limit_text
from fairaudit.reports.charts import Axis, linear
from fairaudit.tables.preparation import words
from fairaudit.words import approximate, noun, percent, place, words_for

__all__ = ["FORMAT", "HEADLINES", "SubgroupContent", "SubgroupRow", "describe_subgroups"]

FORMAT = "fairaudit-subgroups/1"

POPULATION = "population at confidence "

HEADLINES = {
    "none": "no target was set",
    "within": "no subgroup exceeds the target",
    "exceeds": "a subgroup exceeds the target",
    "inconclusive": "inconclusive: there are too few rows to decide",
}


@dataclass(frozen=True)
class SubgroupRow:
    """A subgroup, with its marks on the scale.

    Attributes
    ----------
    name, rows, mean, rest, ratio, interval : str
        What is said of it; no interval is empty.
    exact : str
        The ratio in full.
    same : tuple of str
        Other conditions that the same rows have.
    between : str
        Between which ends its mean is in the population.
    marks : str
        Its mean, that of the rest and that of everybody on the scale, as the inside of an SVG.
    """

    name: str
    rows: str
    mean: str
    rest: str
    ratio: str
    interval: str
    exact: str
    same: tuple[str, ...]
    between: str
    marks: str


@dataclass(frozen=True)
class SubgroupContent:
    """What a report says."""

    verdict: str
    lead: str
    facts: tuple[tuple[str, str], ...]
    targets: tuple[tuple[str, str, str], ...]
    rows: tuple[SubgroupRow, ...]
    amount: str
    overall: str
    axis: Axis
    compared: str
    together: str
    assumptions: tuple[str, ...]
    sha256: str
    embedded: bool


def describe_subgroups(document: Mapping[str, Any]) -> SubgroupContent:
    """Say what a certificate of the format ``fairaudit-subgroups/1`` states; it is believed here."""
    subject, family, overall = document["subject"], document["family"], document["overall"]
    everybody = overall["rows"], Fraction(overall["sum"])
    amount = words_for(burden=subject.get("burden", False)).amount
    findings, targets = document["findings"], document["targets"]
    listed = [*(Fraction(one["sum"]) / one["rows"] for one in findings), *(_rest(one, everybody) for one in findings)]
    top = max([*listed, *(Fraction(one["ends"]["subgroup"][1]) for one in findings if "ends" in one)]) or Fraction(1)
    axis = linear([*listed, top])
    rows = tuple(_row(one, everybody, axis) for one in findings)
    scopes = [claim["scope"] for claim in document["claims"]]
    confidence = next((scope.removeprefix(POPULATION) for scope in scopes if scope.startswith(POPULATION)), None)
    depth = family["depth"]
    least = f"at least {family['least_rows']:,} of {everybody[0]:,} rows"
    attributes = subject["columns"]["attributes"]
    return SubgroupContent(
        verdict=document["verdict"],
        lead=_lead(findings[0], rows[0], amount),
        facts=(
            ("Decision", subject["columns"]["decision"]),
            ("Attributes", ", ".join(attributes)),
            ("Rows", f"{everybody[0]:,}"),
            ("Subgroups", f"up to {min(depth, len(attributes))} of these attributes, {least}"),
            *(("Prepared", words(entry)) for entry in subject.get("preparation", ())),
        ),
        targets=tuple((one["verdict"], limit_text("subgroup", "ratio", Fraction(one["limit"])), one["judged"]) for one in targets),
        rows=rows,
        amount=amount,
        overall=approximate(everybody[1] / everybody[0]),
        axis=axis,
        compared=f"Every combination of up to {depth} attribute values with {least} was compared with all other rows; none is more unequal "
        f"than these.",
        together=""
        if confidence is None
        else f"The intervals hold for all {int(family['conjunctions']):,} conceivable combinations at once, at "
        f"{percent(Fraction(confidence))} confidence; so the most unequal one may be named although it was chosen after looking.",
        assumptions=tuple(dict.fromkeys(text for claim in document["claims"] for text in claim["assumptions"])),
        sha256=subject["table"]["sha256"],
        embedded="rows" in subject["table"],
    )


def _rest(one: Mapping[str, Any], everybody: tuple[int, Fraction]) -> Fraction:
    return Fraction(everybody[1] - Fraction(one["sum"]), everybody[0] - int(one["rows"]))


def _row(one: Mapping[str, Any], everybody: tuple[int, Fraction], axis: Axis) -> SubgroupRow:
    mean, rest, ratio = Fraction(one["sum"]) / one["rows"], _rest(one, everybody), number(one["ratio"])
    low, high = map(number, one.get("interval", ("1", "1")))
    ends = tuple(Fraction(end) for end in one["ends"]["subgroup"]) if "ends" in one else None
    return SubgroupRow(
        name=place(one["conditions"]),
        rows=f"{one['rows']:,}",
        mean=approximate(mean),
        rest=approximate(rest),
        ratio=approximate(ratio),
        interval=f"{approximate(low, 'down')} to {approximate(high, 'up')}" if ends else "",
        exact=str(ratio),
        same=tuple(map(place, one["same"])),
        between=f"{approximate(ends[0], 'down')} to {approximate(ends[1], 'up')}" if ends else "",
        marks=axis.track(
            dots=[(mean, "last" if one["side"] == "less" else "first")],
            rings=[rest],
            whiskers=[(ends[0], ends[1])] if ends else [],
            lines=[everybody[1] / everybody[0]],
        ),
    )


def _lead(one: Mapping[str, Any], row: SubgroupRow, amount: str) -> str:
    if one["side"] == "equal":
        return "No subgroup differs from the rest."
    compared = f"an {amount} of {row.mean} against {row.rest} for everybody else"
    return f"The most unequal subgroup is {row.name}, with {row.rows} {noun(row.rows, 'row')}: {compared}, a ratio of {row.ratio}."
