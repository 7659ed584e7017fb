"""What a report says of unrecorded factors: how strong they would have to be to explain a ratio away, and what a declared one leaves."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from math import inf, isfinite
from typing import Any

from fairaudit.certificates.reader import number
from fairaudit.reports.charts import from_one
from fairaudit.reports.hidden_context_text import factor_text, left_text
from fairaudit.reports.words import Value, scope
from fairaudit.theorems.bound import THIS_LAW
from fairaudit.theorems.registry import is_sampled, without_objection
from fairaudit.theorems.t14 import HiddenContext
from fairaudit.words import HIDDEN

__all__ = ["Strength", "area", "declared", "strengths"]

NAMES = {"local": "within contexts", "global": "overall"}

SIZE = (420, 300)

MARGIN = (48, 30, 14, 42)


@dataclass(frozen=True)
class Strength:
    """What it takes of an unrecorded factor to bring a ratio down to one that would be left."""

    quantity: str
    about: str
    of_table: bool
    ratio: Value
    to: Value
    balanced: Value
    pairs: tuple[tuple[Value, Value], ...]

    @property
    def name(self) -> str:
        """Which ratio."""
        return NAMES[self.quantity]

    @property
    def excess(self) -> float:
        """The ratio over the one that would be left."""
        return float(self.ratio) / float(self.to)


def strengths(document: Mapping[str, Any]) -> list[Strength]:
    """What explaining the ratios away would take, in the order of the claims."""
    found = []
    for claim in document["claims"]:
        if claim["by"] != "T14" or "frontier" not in claim["evidence"]:
            continue
        quantity, sampled = claim["quantity"].partition("_")[0], is_sampled(claim["scope"])
        seen = document["intervals"][quantity]["ratio"][0] if sampled else document["metrics"][quantity]["ratio"]
        about = "the table" if claim["scope"] == THIS_LAW else f"the lower end, for {scope(claim['scope'])}"
        for level in claim["evidence"]["frontier"]:
            pairs = tuple((Value(number(k)), Value(number(m), "down")) for k, m in level["pairs"])
            ratio, to = Value(number(seen), "down" if sampled else "nearest"), Value(number(level["to"]))
            found.append(Strength(quantity, about, not sampled, ratio, to, Value(number(level["balanced"]), "down"), pairs))
    return found


def declared(document: Mapping[str, Any]) -> list[str]:
    """The factor that was declared, and what it leaves of each ratio; empty where none was."""
    lines: list[str] = []
    for claim in document["claims"]:
        about, objection = without_objection(claim["scope"])
        if claim["by"] == "T14" and objection == HIDDEN:
            given = claim["evidence"]["hidden_context"]
            if not lines:
                factor = HiddenContext.of((given["k"], given["m"], given["direction"]))
                lines.append(f"Targets are judged with {factor_text(factor)}.")
            where = "in the table" if about == THIS_LAW else f"in {scope(about)}"
            said = f"Of the ratio {NAMES[claim['quantity'].partition('_')[0]]} {left_text(number(claim['value']))}, {where}."
            lines.append(said)
    return lines


def area(found: Strength) -> str:
    """The pairs (k,m) as a picture: those that are too weak to explain the ratio are shaded."""
    (width, height), (left, upper, right, lower) = SIZE, MARGIN
    q, balanced = found.excess, float(found.balanced)
    if not isfinite(q) or balanced > 1e6 or q <= 1:
        return ""
    ticks = from_one(1 + 2.2 * (balanced - 1))
    most = ticks[-1]

    def x(k: float) -> float:
        return left + (width - left - right) * (k - 1) / (most - 1)

    def y(m: float) -> float:
        return upper + (height - upper - lower) * (1 - (m - 1) / (most - 1))

    first = (q * most - 1) / (most - q)
    ks = [first * (most / first) ** (i / 40) for i in range(41)]
    line = " ".join(f"{x(k):.1f},{y(min(most, (q * k - 1) / (k - q) if k > q else inf)):.1f}" for k in ks)
    said = f"An unrecorded factor with k and m both below {found.balanced.decimal} is too weak to explain the ratio {found.name}"
    parts = [f'<svg class="curve" viewBox="0 0 {width} {height}" role="img" aria-label="{said}.">']
    corners = f"{x(1):.1f},{y(1):.1f} {x(1):.1f},{y(most):.1f}"
    parts.append(f'<polygon class="weak" points="{corners} {line} {x(most):.1f},{y(1):.1f}"/>')
    for tick in ticks:
        parts.append(f'<line class="rail" x1="{left}" x2="{width - right}" y1="{y(tick):.1f}" y2="{y(tick):.1f}"/>')
        parts.append(f'<text x="{left - 8}" y="{y(tick) + 4:.1f}" text-anchor="end">{tick:.3g}</text>')
        parts.append(f'<text x="{x(tick):.1f}" y="{height - 24}" text-anchor="middle">{tick:.3g}</text>')
    parts.append(f'<text x="{(left + width - right) / 2}" y="{height - 6}" text-anchor="middle">k: times as common in one group</text>')
    parts.append(f'<text x="{left - 34}" y="{upper - 12}">m: times the outcome</text>')
    parts.append(f'<polyline class="line" points="{line}"/>')
    parts.append(f'<circle class="here" cx="{x(balanced):.1f}" cy="{y(balanced):.1f}" r="5"/>')
    dots = [(x(float(k)), y(float(m))) for k, m in found.pairs if max(float(k), float(m)) < most]
    parts += [f'<circle class="point" cx="{across:.1f}" cy="{up:.1f}" r="3"/>' for across, up in dots]
    said = (
        "Shaded: factors that are too weak to explain the ratio. The curve: the weakest that could. Large dot: k = m; small: other pairs."
    )
    parts.append(f"</svg><figcaption>{said}</figcaption>")
    return "".join(parts)
