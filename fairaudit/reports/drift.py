"""What a report says of drift: how much may change before a verdict falls, as a picture too, and the updates that change it."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import cached_property
from math import inf, isfinite
from typing import TYPE_CHECKING, Any

import numpy as np

from fairaudit.audits.document import document
from fairaudit.audits.drift import DriftedRatio, Pair, TableRadius
from fairaudit.certificates.reader import Subject, number
from fairaudit.exact.extended import Extended
from fairaudit.inference.comparisons import Comparison
from fairaudit.inference.moving_ends import MovingEnds
from fairaudit.reports.charts import from_one, steps
from fairaudit.reports.drift_text import drifted_line, pair_text, radius_lines, share
from fairaudit.reports.unknown_groups import as_ratio
from fairaudit.reports.words import Value, clip, named, scope
from fairaudit.theorems.bound import THIS_LAW
from fairaudit.theorems.registry import without_objection
from fairaudit.theorems.t16 import Form, Moved, Moving, can_drift, drifted_extremes, moved_row
from fairaudit.words import DRIFTING, approximate, noun, plain

if TYPE_CHECKING:
    from fairaudit.audits.result import Result

__all__ = ["Standing", "standings", "updates_text"]

NAMES = {"local": "Within contexts", "global": "Overall"}

SHOW_CELLS = 8  # cells of a group that an update moves, which are listed

SHOW_DECISIONS = 6  # decisions of a cell that are listed

MOST_DRAWN = 50_000  # cells, beyond which a picture would take seconds

SIZE = (420, 300)

MARGIN = (48, 30, 14, 42)


@dataclass(frozen=True)
class Standing:
    """How far a verdict stands, or between which ends a ratio is within a declared drift.

    Attributes
    ----------
    title : str
        What was judged, and of what.
    quantity : {"local", "global"}
        Of which ratio.
    lines : tuple of str
        What is known.
    updates : tuple of (str, tuple of str)
        Updates with which it changes, or which attain the ends, cell by cell; empty without a table.
    mark : Fraction or float
        The radius, or the declared drift; infinite where no update changes the verdict.
    radius : bool
        Whether it is a radius.
    limits : tuple of Value
        The targets, as ratios.
    moved : tuple of Moved or None
        What attains the greatest ratio and what the least; None where the table is not known, or too long for a picture.
    """

    title: str
    quantity: str
    lines: tuple[str, ...]
    updates: tuple[tuple[str, tuple[str, ...]], ...]
    mark: Extended
    radius: bool
    limits: tuple[Value, ...]
    moved: tuple[Moved, Moved] | None

    @property
    def overall(self) -> bool:
        """Whether it is about the averages of the groups over all contexts."""
        return self.quantity == "global"

    @cached_property
    def points(self) -> list[tuple[float, float, float]]:
        """Share of the decisions that an update changes, the greatest ratio with it, and the least; empty without a table."""
        if self.moved is None:
            return []
        mark = Fraction(1) if self.mark == inf else Fraction(self.mark)
        span = min(Fraction(1), 2 * mark) or Fraction(1, 20)
        count = 40 if self.moved[0].starts[-1] <= MOST_DRAWN // 10 else 10
        at = sorted({span * Fraction(i, count) for i in range(count + 1)} | {min(mark, span)})
        found = []
        for eta in at:
            one = drifted_extremes(self.moved[0], eta)
            other = one if self.moved[0] is self.moved[1] else drifted_extremes(self.moved[1], eta)
            if one is None or other is None:
                return []
            found.append((float(eta), float(Value(one[0].value)), float(Value(other[1].value))))
        return found

    @property
    def picture(self) -> str:
        """The greatest and the least ratio over the drift, with the limit as a line and the radius as a dot, as SVG; numbers only."""
        return _picture(self) if self.points else ""


def standings(found: Mapping[str, Any], of: Subject | None, comparisons: Mapping[str, Comparison]) -> list[Standing]:
    """Read what a certificate, or what it is made of, says of drift.

    Parameters
    ----------
    found : mapping
        The certificate.
    of : Subject or None
        Its table.
    comparisons : mapping
        The draws behind its intervals, by quantity.
    """
    claims = [claim for claim in found["claims"] if claim["by"] == "T16"]
    return [*_radii(found, claims, of, comparisons), *_ranges(found, claims, of, comparisons)]


def _radii(
    found: Mapping[str, Any], claims: Sequence[Mapping[str, Any]], of: Subject | None, comparisons: Mapping[str, Comparison]
) -> Iterator[Standing]:
    columns = found["subject"]["columns"]
    for claim in claims:
        quantity, _, rest = claim["quantity"].partition("_")
        unit, _, form = rest.partition("_")
        if form != "radius":
            continue
        own = claim["evidence"]
        by_factor = next(
            (
                other
                for other in claims
                if other["quantity"] == f"{quantity}_{unit}_factor"
                and other["scope"] == claim["scope"]
                and other["evidence"]["limit"] == own["limit"]
            ),
            None,
        )
        factor = None if by_factor is None else number(by_factor["value"])
        pairs = _pair(own["pair"], columns), None if by_factor is None else _pair(by_factor["evidence"]["pair"], columns)
        of_table = claim["scope"] == THIS_LAW
        radius, exact = number(claim["value"]), claim["relation"] == "="
        exact_factor = by_factor is not None and by_factor["relation"] == "="
        stands = TableRadius(own["verdict"], radius, exact, factor, exact_factor, *pairs, of_population=not of_table)
        target = {"unit": unit, "limit": own["limit"]}
        limit = Value(number(own["limit"]))
        said = f"{own['verdict']}, a {'log-ratio' if unit == 'log' else 'ratio'} of at most {limit.decimal}"
        updates: list[tuple[str, tuple[str, ...]]] = []
        if of_table and of is not None:
            up = own["verdict"] == "within"
            moves: tuple[tuple[Form, Extended | None, Pair | None], ...] = (("radius", radius, pairs[0]), ("factor", factor, pairs[1]))
            for move, value, pair in moves:
                if pair is not None and value is not None and value != inf:
                    far = f"{share(value)} of the decisions" if move == "radius" else f"the factor {approximate(value, 'down')}"
                    title = f"it changes with a little more than {far}" if up else f"the last pair comes down to the limit with {far}"
                    updates.append((title, tuple(_update(of, quantity, pair, move, Fraction(value), up=up))))
        yield Standing(
            f"{NAMES[quantity]}: {said}, judged for {scope('this table') if of_table else scope(claim['scope'])}",
            quantity,
            tuple(radius_lines(stands, quantity, named)),
            tuple(updates),
            radius,
            True,
            (as_ratio(target),),
            _moved(found, quantity, of, comparisons, of_table=of_table),
        )


def _ranges(
    found: Mapping[str, Any], claims: Sequence[Mapping[str, Any]], of: Subject | None, comparisons: Mapping[str, Comparison]
) -> Iterator[Standing]:
    columns, declared = found["subject"]["columns"], found["subject"].get("max_drift")
    ends: dict[tuple[str, str], dict[str, Mapping[str, Any]]] = {}
    for claim in claims:
        about, objection = without_objection(claim["scope"])
        if objection == DRIFTING:
            ends.setdefault((claim["quantity"].partition("_")[0], about), {})[claim["relation"]] = claim
    for (quantity, about), both in ends.items():
        if declared is None or both.keys() != {"<=", ">="}:
            continue
        drift, of_table = Fraction(number(declared)), about == THIS_LAW
        worst, best = number(both["<="]["value"]), number(both[">="]["value"])
        pairs = [_pair(both[relation]["evidence"]["pair"], columns) for relation in ("<=", ">=")]
        lines = [drifted_line(DriftedRatio(quantity, worst, best, pairs[0], pairs[1], about), drift)]  # type: ignore[arg-type]
        lines += [
            f"the {end}: {pair_text(pair, named)}" for end, pair in zip(("greatest", "least"), pairs, strict=True) if pair is not None
        ]
        updates = []
        for end, value, pair, up in (("greatest", worst, pairs[0], True), ("least", best, pairs[1], False)):
            if of_table and of is not None and pair is not None:
                title = f"for the {end} ratio, {approximate(value)}"
                updates.append((title, tuple(_update(of, quantity, pair, "radius", drift, up=up))))
        targets = tuple(as_ratio(t) for t in found["targets"] if t["quantity"] == quantity and t["unit"] != "difference")
        yield Standing(
            f"{NAMES[quantity]}, for {scope('this table') if of_table else scope(about)}",
            quantity,
            tuple(lines),
            tuple(updates),
            drift,
            False,
            targets,
            _moved(found, quantity, of, comparisons, of_table=of_table),
        )


def _pair(entry: Mapping[str, Any] | None, columns: Mapping[str, Any]) -> Pair | None:
    """The pair of an entry, with the names of the columns."""
    if entry is None:
        return None
    context = None if entry["context"] is None else dict(zip(columns["context"], entry["context"], strict=True))
    higher, lower = (dict(zip(columns["group"], entry[key], strict=True)) for key in ("higher", "lower"))
    return context, higher, lower


def _moved(
    found: Mapping[str, Any], quantity: str, of: Subject | None, comparisons: Mapping[str, Comparison], *, of_table: bool
) -> tuple[Moved, Moved] | None:
    """What moves: cells of the table, or between the ends that the interval proves."""
    if of is None or len(of.law.weights) > MOST_DRAWN:
        return None
    if of_table:
        if not can_drift(of.law, of.utility, quantity):  # type: ignore[arg-type]
            return None
        moving = Moving(of.law, of.utility, quantity)  # type: ignore[arg-type]
        return moving, moving
    entry = found.get("intervals", {}).get(quantity)
    comparison = comparisons.get(quantity)
    if entry is None or comparison is None or not comparison.single or entry.get("region") != "box":
        return None
    one, other = (MovingEnds(comparison, [(Fraction(low), Fraction(high)) for low, high in entry[side]]) for side in ("upper", "lower"))
    return one, other


def _update(of: Subject, quantity: str, pair: Pair, form: Form, amount: Fraction, *, up: bool) -> Iterator[str]:
    """How an update would move the cells of a pair: the higher group up and the lower one down, or the other way."""
    law, table = of.law, of.utility
    for label, upwards in ((pair[1], up), (pair[2], not up)):
        listed = 0
        group = law.groups.index(tuple(label.values()))
        for cell in np.flatnonzero(law.cell_group == group).tolist():
            x = int(law.cell_context[cell])
            if quantity == "local" and pair[0] is not None and law.contexts[x] != tuple(pair[0].values()):
                continue
            listed += 1
            if listed > SHOW_CELLS:
                continue
            row = [*law.row(cell)]
            values = (table.values if table.by_decision else table.values[cell]).tolist()
            new, total = moved_row(row, values, form, amount, up=upwards), sum(row)
            changed = [
                f"{clip(decision)} from {_percent(Fraction(w, total))} to {_percent(q)}"
                for decision, w, q in sorted(
                    zip(law.decisions, row, new, strict=True), key=lambda one: -abs(one[2] - Fraction(one[1], total))
                )
                if Fraction(w, total) != q
            ]
            if len(law.decisions) == 2:
                changed = changed[:1]
            more = len(changed) - SHOW_DECISIONS
            rest = f", and {more} more {noun(more, 'decision')}" if more > 0 else ""
            where = named({**law.context_label(x), **law.group_label(group)})
            yield f"in {where}: {', '.join(changed[:SHOW_DECISIONS]) or 'as it is'}{rest}"
        if listed > SHOW_CELLS:
            yield f"and {listed - SHOW_CELLS:,} more {noun(listed - SHOW_CELLS, 'cell')} of {named(label)}"


def _percent(value: Fraction) -> str:
    return f"{approximate(100 * value)} %"


def updates_text(result: Result) -> str:
    """Updates that change the verdicts, or that attain the worst and the best ratio within the declared drift."""
    found = standings(document(result), Subject(result.law, result.utility, result.deployment), {})
    lines = []
    for one in found:
        lines += [plain(one.title)] if one.updates else []
        for title, cells in one.updates:
            lines += [f"  {plain(title)}", *(f"    {plain(cell)}" for cell in cells)]
    if found and not lines:
        lines.append("Updates that change a verdict are constructed of verdicts on the table (--confidence none), where there are any")
    return "\n".join(lines)


def _picture(of: Standing) -> str:
    (width, height), (left, upper, right, lower) = SIZE, MARGIN
    points = of.points
    span = points[-1][0]
    limits = [float(limit) for limit in of.limits]
    here = next((p for p in points if p[0] == float(of.mark)), None)
    ends = [points[0][1], points[0][2], *limits, *([here[1], here[2]] if here and not of.radius else [])]
    marks = from_one(max(1.2, 1 + 1.6 * (max((end for end in ends if isfinite(end)), default=2) - 1)))
    top = marks[-1]

    def x(eta: float) -> float:
        return left + (width - left - right) * eta / span

    def y(ratio: float) -> float:
        return upper + (height - upper - lower) * (1 - (min(ratio, top) - 1) / (top - 1))

    worst, best = ([(x(p[0]), p[i]) for p in points] for i in (1, 2))
    outline = " ".join(f"{a:.1f},{y(b):.1f}" for a, b in [*worst, *reversed(best)])
    each = [points[0], *([here] if here else []), points[-1]]
    said = "; ".join(f"{Value(Fraction(p[0] * 100), rational=False).decimal} %: from {_short(p[2])} to {_short(p[1])}" for p in each)
    told = f"Between which ends the ratio is when an update changes a share of the decisions of each cell. {said}."
    parts = [f'<svg class="curve" viewBox="0 0 {width} {height}" role="img" aria-label="{told}">']
    if limits:
        edge = y(min(limits))
        parts.append(f'<rect class="beyond" x="{left}" y="{upper}" width="{width - left - right}" height="{edge - upper:.1f}"/>')
    parts.append(f'<polygon class="weak" points="{outline}"/>')
    for level in marks:
        parts.append(f'<line class="rail" x1="{left}" x2="{width - right}" y1="{y(level):.1f}" y2="{y(level):.1f}"/>')
        parts.append(f'<text x="{left - 8}" y="{y(level) + 4:.1f}" text-anchor="end">{level:.3g}</text>')
    for tick in steps(0, 100 * span, 4):
        if tick <= 100 * span:
            anchor = "end" if tick > 98 * span else "middle"
            parts.append(f'<text x="{x(tick / 100):.1f}" y="{height - 24}" text-anchor="{anchor}">{tick:.3g} %</text>')
    parts.append(
        f'<text x="{(left + width - right) / 2}" y="{height - 6}" text-anchor="middle">decisions of each cell that an update changes</text>'
    )
    parts.append(f'<text x="{left - 34}" y="{upper - 12}">ratio</text>')
    parts += [f'<line class="limit" x1="{left}" x2="{width - right}" y1="{y(v):.1f}" y2="{y(v):.1f}"/>' for v in limits]
    for line, kind in ((worst, "line"), (best, "line least")):
        shown = " ".join(f"{a:.1f},{y(b):.1f}" for a, b in _under(line, top))
        parts.append(f'<polyline class="{kind}" points="{shown}"/>')
    if here is not None:
        at = x(here[0])
        parts.append(f'<line class="mark" x1="{at:.1f}" x2="{at:.1f}" y1="{upper}" y2="{height - lower}"/>')
        heights = limits if of.radius else [here[1], here[2]]
        parts += [f'<circle class="here" cx="{at:.1f}" cy="{y(v):.1f}" r="5"/>' for v in heights if v <= top]
    caption = (
        "The shaded band: what the ratio can be after an update that changes so much in each cell, the worst above and the best below."
    )
    if limits:
        caption += f" Dashed: the limit, {' and '.join(limit.decimal for limit in of.limits)}."
    if here is not None:
        caption += f" The dot: the radius, {share(of.mark)}." if of.radius else f" The dots: within the declared drift, {share(of.mark)}."
    parts.append(f"</svg><figcaption>{caption}</figcaption>")
    return "".join(parts)


def _short(ratio: float) -> str:
    return f"{ratio:.4g}" if isfinite(ratio) else "infinite"


def _under(line: Sequence[tuple[float, float]], top: float) -> Iterator[tuple[float, float]]:
    """A line up to where it leaves the picture, and from where it comes into it."""
    for i, (a, b) in enumerate(line):
        if b <= top:
            yield a, b
            continue
        for j in (i - 1, i + 1):
            if 0 <= j < len(line) and line[j][1] <= top:
                c, d = line[j]
                yield (c + (a - c) * (top - d) / (b - d) if isfinite(b) else c), top
