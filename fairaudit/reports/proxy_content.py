"""What a report says of a certificate about groups that nobody recorded, before it has a shape."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from fractions import Fraction
from math import inf
from typing import Any

from fairaudit.certificates.reader import number
from fairaudit.exact.extended import Extended
from fairaudit.measures.limits import limit_text
from fairaudit.reports.charts import Axis, linear, logarithmic
from fairaudit.reports.unknown_groups import as_ratio
from fairaudit.reports.words import Value
from fairaudit.words import approximate, noun

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
    """A range, with its marks on the scale as the inside of an SVG."""

    name: str
    said: str
    exact: str
    marks: str


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
    means: Axis
    ratios: Axis
    limited: bool
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
    means, ratios = linear([top]), _ratios([*local, *([overall] if overall is not None else [])])
    limits = {name: [_as_ratio(entry) for entry in document["targets"] if entry["quantity"] == name] for name in ("local", "global")}
    panels = [
        _panel(entry, subject, means, ratios, limits["local"], _named(columns["context"], entry["context"])) for entry in local[:SHOW]
    ]
    if columns["context"] and overall is not None:
        panels.append(_panel(overall, subject, means, ratios, limits["global"], "All contexts together"))
    facts = [
        ("Decision", columns["decision"]),
        ("Groups", f"{', '.join(columns['group'])}: {', '.join(', '.join(group) for group in subject['groups'])}"),
        ("Known from", f"{len(subject['cells'])} {noun(len(subject['cells']), 'cell')} of {', '.join(columns['cell'])}"),
        *([("Context", ", ".join(columns["context"]))] if columns["context"] else []),
        *([("Rows", _rows(table))] if "rows" in table else []),
    ]
    return ProxyContent(
        document["verdict"],
        _lead(local, overall, contexts=bool(columns["context"])),
        tuple(facts),
        tuple((entry["verdict"], limit_text(entry["quantity"], entry["unit"], Fraction(entry["limit"]))) for entry in document["targets"]),
        tuple(panels),
        means,
        ratios,
        any(limits.values()),
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


def _panel(entry: Mapping[str, Any], subject: Mapping[str, Any], means: Axis, ratios: Axis, limits: list[float], title: str) -> Panel:
    names = {a: ", ".join(subject["groups"][a]) for a in entry["groups"]}
    gets = []
    for a, pair in zip(entry["groups"], entry["means"], strict=True):
        low, high = map(Fraction, pair)
        gets.append(Bar(names[a], _range(low, high), f"{pair[0]} to {pair[1]}", means.track(whiskers=[(low, high)])))
    apart, edges = [], [edge for limit in limits for edge in (limit, 1 / limit)]
    for pair in entry["pairs"]:
        first, last = map(number, pair["ratio"])
        said = _range(first, last) + ("" if all(pair["sharp"]) else " (at most)")
        named = f"{names[pair['groups'][0]]} over {names[pair['groups'][1]]}"
        marks = ratios.track(whiskers=[(Value(first), Value(last))], limits=edges, lines=[1])
        apart.append(Bar(named, said, " to ".join(pair["ratio"]), marks))
    ends = number(entry["least"]["ratio"]), number(entry["greatest"]["ratio"])
    return Panel(title, f"greatest ratio {_range(*ends)}", tuple(gets), tuple(apart))


def _as_ratio(target: Mapping[str, Any]) -> float:
    """The limit of a target as a ratio."""
    return float(as_ratio(target))


def _ratios(ranges: list[Any]) -> Axis:
    """A scale of ratios that reaches as far as they do, but not where they are infinite or nearly so."""
    ends = [float(number(end)) for entry in ranges for pair in entry["pairs"] for end in pair["ratio"]]
    far = max((max(end, 1 / end) for end in ends if 0 < end < inf), default=4.0)
    return logarithmic([min(MOST_SPAN, max(2.0, far))], both=True)
