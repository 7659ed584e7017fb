"""Pictures of a page, as SVG: positions in per cent, so that they fit any width. Numbers only; no text of the input."""

from __future__ import annotations

from collections.abc import Sequence
from math import exp, isfinite, log

from fairaudit.reports.ladder import Calibrated, Rung
from fairaudit.reports.words import Value

__all__ = ["curve", "heat", "rail", "share"]


CURVE = (420, 250)

MARGIN = (48, 14, 14, 42)


def share(value: Value, most: Value, least: float = 0.0) -> float:
    """Where a value stands on a scale from 0, or from a lesser number, in per cent."""
    width = float(most) - least
    return min(100.0, 100 * (float(value) - least) / width) if width > 0 else 0.0


def heat(value: Value | None) -> str:
    """How far a ratio is from parity, in six steps."""
    if value is None:
        return ""
    distance = abs(log(float(value))) if float(value) > 0 and isfinite(float(value)) else 9
    return f"h{sum(distance >= step for step in (0.02, 0.1, 0.25, 0.5, 1))}"


def rail(rung: Rung, rungs: Sequence[Rung]) -> str:
    """A rung on a logarithmic scale from 1, with what is beyond the target shaded."""
    finite = [float(r.value) for r in rungs if isfinite(float(r.value))]
    span = log(max(finite, default=1) * 1.08) or 1

    def at(value: Value) -> float:
        number = float(value)
        return 100.0 if not isfinite(number) else 100 * log(max(1, number)) / span if span > 0 else 0.0

    limits = [at(r.value) for r in rungs if r.kind == "target"]
    parts = []
    if limits:
        parts.append(f'<rect class="beyond" x="{min(limits):.2f}%" width="{max(0.0, 100 - min(limits)):.2f}%" y="0" height="18"/>')
    parts.append('<line class="rail" x1="0" x2="100%" y1="9" y2="9"/>')
    parts += [f'<line class="limit" x1="{x:.2f}%" x2="{x:.2f}%" y1="-4" y2="22"/>' for x in limits]
    parts.append(f'<rect class="bar {rung.kind}" x="0" width="{max(0.6, at(rung.value)):.2f}%" y="6" height="6" rx="2"/>')
    return "".join(parts)


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
        parts.append(f'<text x="{x(span * level):.1f}" y="{height - 24}" text-anchor="middle">{span * level:.2f}</text>')
    parts.append(
        f'<text x="{(left + width - right) / 2}" y="{height - 6}" text-anchor="middle">log of the target for the local ratio</text>'
    )
    if found.target is not None:
        parts.append(f'<line class="limit" x1="{x(found.target):.1f}" x2="{x(found.target):.1f}" y1="{upper}" y2="{height - lower}"/>')
    line = " ".join(f"{x(a):.1f},{y(b):.1f}" for a, b in points)
    parts.append(f'<polyline class="line" points="{line}"/>')
    parts += [f'<circle class="point" cx="{x(a):.1f}" cy="{y(b):.1f}" r="3"/>' for a, b in points]
    parts.append("</svg><figcaption>The curve: at most this much truth.")
    if found.here is not None:
        parts.insert(-1, f'<circle class="here" cx="{x(found.here[0]):.1f}" cy="{y(found.here[1]):.1f}" r="6"/>')
        parts.append(" The large dot: the audited group filter.")
    if found.target is not None:
        parts.append(f" The dashed line: the target, a ratio of {exp(found.target):.4g} (log {found.target:.4g}).")
    return "".join(parts) + "</figcaption>"
