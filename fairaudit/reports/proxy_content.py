"""What a report says of a certificate about groups that nobody recorded, before it has a shape."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from fractions import Fraction
from math import ceil, inf, log
from typing import Any

from fairaudit.certificates.reader import number
from fairaudit.exact.extended import Extended
from fairaudit.measures.limits import limit_text
from fairaudit.words import approximate

__all__ = ["FORMAT", "HEADLINES", "SAMPLING", "Bar", "Panel", "ProxyContent", "describe_proxies"]

FORMAT = "fairaudit-proxies/1"

MOST_SPAN = 20.0  # of the scale of ratios

SHOW = 12  # contexts that a reader looks through; the certificate has all

SAMPLING = "Nothing is said of a population from which the rows were drawn: sampling error comes on top."

HEADLINES = {
    "none": "no target was set",
    "within": "within the targets, whoever the members of the groups are",
    "exceeds": "a target is exceeded, whoever the members of the groups are",
    "depends": "it depends on who the members of the groups are: both answers are possible",
    "inconclusive": "inconclusive: it is not known whether both answers are possible",
}


@dataclass(frozen=True)
class Bar:
    """A range and where it stands on its scale, in per cent."""

    name: str
    said: str
    exact: str
    start: float
    end: float


@dataclass(frozen=True)
class Panel:
    """What is said of a context, or of all."""

    title: str
    said: str
    means: tuple[Bar, ...]
    ratios: tuple[Bar, ...]


@dataclass(frozen=True)
class ProxyContent:
    """What a report says."""

    verdict: str
    lead: str
    facts: tuple[tuple[str, str], ...]
    targets: tuple[tuple[str, str], ...]
    panels: tuple[Panel, ...]
    span: str
    more: int
    assumptions: tuple[str, ...]
    sha256: str
    embedded: bool


def describe_proxies(document: Mapping[str, Any]) -> ProxyContent:
    """Say what a certificate of the format ``fairaudit-proxies/1`` states; it is believed here."""
    subject = document["subject"]
    columns, table = subject["columns"], subject["table"]
    local = sorted(document["local"], key=lambda entry: -number(entry["greatest"]["ratio"]))
    top = max((Fraction(mean[1]) for entry in local for mean in entry["means"]), default=Fraction(1)) or Fraction(1)
    overall = document["global"]
    span = _span([*local, *([overall] if overall is not None else [])])
    panels = [_panel(entry, subject, top, span, _named(columns["context"], entry["context"])) for entry in local[:SHOW]]
    if columns["context"] and overall is not None:
        panels.append(_panel(overall, subject, top, span, "All contexts together"))
    facts = [
        ("Decision", columns["decision"]),
        ("Groups", f"{', '.join(columns['group'])}: {', '.join(', '.join(group) for group in subject['groups'])}"),
        ("Known from", f"{len(subject['cells'])} cells of {', '.join(columns['cell'])}"),
        *([("Context", ", ".join(columns["context"]))] if columns["context"] else []),
        *([("Rows", _rows(table))] if "rows" in table else []),
    ]
    return ProxyContent(
        document["verdict"],
        _lead(local, overall, contexts=bool(columns["context"])),
        tuple(facts),
        tuple((entry["verdict"], limit_text(entry["quantity"], entry["unit"], Fraction(entry["limit"]))) for entry in document["targets"]),
        tuple(panels),
        f"{span:g}",
        max(0, len(local) - SHOW),
        (*document["assumptions"], SAMPLING),
        table["sha256"],
        "rows" in table,
    )


def _rows(table: Mapping[str, Any]) -> str:
    return f"{sum(int(weight) for row in table['rows'] for weight in row['weights']):,}"


def _named(columns: list[str], labels: list[str]) -> str:
    return ", ".join(f"{name}={label}" for name, label in zip(columns, labels, strict=True)) or "All cells"


def _range(low: Extended, high: Extended) -> str:
    return approximate(low) if low == high else f"{approximate(low, 'down')} to {approximate(high, 'up')}"


def _lead(local: list[Any], overall: Any, *, contexts: bool) -> str:
    parts = []
    if local:
        low, high = (max(number(entry[name]["ratio"]) for entry in local) for name in ("least", "greatest"))
        parts.append(f"the worst ratio{' within a context' if contexts else ''} is {'' if low == high else 'from '}{_range(low, high)}")
    if contexts and overall is not None:
        low, high = (number(overall[name]["ratio"]) for name in ("least", "greatest"))
        parts.append(f"the worst ratio of group means is {'' if low == high else 'from '}{_range(low, high)}")
    said = " and ".join(parts) or "fewer than two groups are there"
    return f"No row says who belongs to which group. From the probabilities of the groups in each cell, {said}."


def _panel(entry: Mapping[str, Any], subject: Mapping[str, Any], top: Fraction, span: float, title: str) -> Panel:
    names = {a: ", ".join(subject["groups"][a]) for a in entry["groups"]}
    means = [
        Bar(names[a], _range(Fraction(low), Fraction(high)), f"{low} to {high}", *(float(100 * Fraction(end) / top) for end in (low, high)))
        for a, (low, high) in zip(entry["groups"], entry["means"], strict=True)
    ]
    ratios = []
    for pair in entry["pairs"]:
        low, high = map(number, pair["ratio"])
        said = _range(low, high) + ("" if all(pair["sharp"]) else " (at most)")
        named = f"{names[pair['groups'][0]]} over {names[pair['groups'][1]]}"
        ratios.append(Bar(named, said, " to ".join(pair["ratio"]), _on_log_scale(low, span), _on_log_scale(high, span)))
    ends = number(entry["least"]["ratio"]), number(entry["greatest"]["ratio"])
    return Panel(title, f"greatest ratio {_range(*ends)}", tuple(means), tuple(ratios))


def _on_log_scale(value: Extended, span: float) -> float:
    """From 1/span to span, in per cent; 1 is in the middle, and what is beyond stands at the edge."""
    found = float(value)
    return min(100.0, max(0.0, 50 + 50 * log(found, span))) if 0 < found < inf else 100.0 if found else 0.0


def _span(ranges: list[Any]) -> float:
    """How far the scale of ratios reaches: as far as they do, but not where they are infinite or nearly so."""
    ends = [float(number(end)) for entry in ranges for pair in entry["pairs"] for end in pair["ratio"]]
    far = max((max(end, 1 / end) for end in ends if 0 < end < inf), default=4.0)
    return float(ceil(min(MOST_SPAN, max(2.0, far))))
