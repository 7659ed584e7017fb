"""How far ratios are from parity as a colour, and how much truth a filter may tell as an SVG. Numbers only; no text of the input."""

from __future__ import annotations

from math import exp, isfinite, log

from fairaudit.reports.charts import steps
from fairaudit.reports.ladder import Calibrated
from fairaudit.reports.words import Value

__all__ = ["curve", "heat"]


CURVE = (420, 250)

MARGIN = (48, 14, 14, 42)


def heat(value: Value | None) -> str:
    """How far a ratio is from parity, in six steps."""
    if value is None:
        return ""
    distance = abs(log(float(value))) if float(value) > 0 and isfinite(float(value)) else 9
    return f"h{sum(distance >= step for step in (0.02, 0.1, 0.25, 0.5, 1))}"


def curve(found: Calibrated) -> str:
    """Keep probability over the target, as a picture."""
    (width, height), (left, upper, right, lower) = CURVE, MARGIN
    xs = [x for x, _ in found.points] + ([found.here[0]] if found.here else []) + ([found.target] if found.target else [])
    span = max(xs) * 1.04

    def x(value: float) -> float:
        return left + (width - left - right) * value / span

    def y(value: float) -> float:
        return upper + (height - upper - lower) * (1 - value)

    points = [(0.0, 0.0)] if not found.points else list(found.points)
    said = ", ".join(f"{100 * kept:.0f} % for {target:.2f}" for target, kept in points[:: max(1, len(points) // 4)])
    alternative = f"Probability of releasing the truth that still guarantees a target log-ratio: {said}."
    parts = [f'<svg class="curve" viewBox="0 0 {width} {height}" role="img" aria-label="{alternative}">']
    for step in range(5):
        level = step / 4
        parts.append(f'<line class="rail" x1="{left}" x2="{width - right}" y1="{y(level):.1f}" y2="{y(level):.1f}"/>')
        parts.append(f'<text x="{left - 8}" y="{y(level) + 4:.1f}" text-anchor="end">{100 * level:.0f} %</text>')
    ticks = [tick for tick in steps(0, span, 4) if tick <= span]
    parts += [f'<text x="{x(tick):.1f}" y="{height - 24}" text-anchor="middle">{tick:.3g}</text>' for tick in ticks]
    parts.append(
        f'<text x="{(left + width - right) / 2}" y="{height - 6}" text-anchor="middle">log of the target for the local ratio</text>'
    )
    if found.target is not None:
        parts.append(f'<line class="limit" x1="{x(found.target):.1f}" x2="{x(found.target):.1f}" y1="{upper}" y2="{height - lower}"/>')
    line = " ".join(f"{x(a):.1f},{y(b):.1f}" for a, b in points)
    parts.append(f'<polyline class="line" points="{line}"/>')
    parts += [f'<circle class="point" cx="{x(a):.1f}" cy="{y(b):.1f}" r="3"/>' for a, b in points]
    parts.append("</svg><figcaption>The curve: at most this much truth, computed at the small dots.")
    if found.here is not None:
        parts.insert(-1, f'<circle class="here" cx="{x(found.here[0]):.1f}" cy="{y(found.here[1]):.1f}" r="6"/>')
        parts.append(" The large dot: the audited group filter.")
    if found.target is not None:
        parts.append(f" The dashed line: the target, a ratio of {exp(found.target):.4g} (log {found.target:.4g}).")
    return "".join(parts) + "</figcaption>"
