"""Labelled scales and the marks on them, as SVG that fits any width. Numbers only; no text of the input."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from math import ceil, floor, isfinite, log, log10

__all__ = ["Axis", "from_one", "linear", "logarithmic", "steps"]


RATIOS = (1, 1.05, 1.1, 1.2, 1.5, 2, 3, 5, 10, 20, 50, 100, 1000, 10**4, 10**6, 10**9, 10**15, 10**30, 10**100, 10**300)

TOP, MIDDLE, BOTTOM = 0, 13, 26

MOST = 1e290  # how far a scale reaches


@dataclass(frozen=True)
class Axis:
    """A scale with ticks.

    Attributes
    ----------
    low, high : float
        Between which values it runs.
    ticks : tuple of (float, str)
        Values with what is written at them.
    log : bool
        Whether it is logarithmic.
    """

    low: float
    high: float
    ticks: tuple[tuple[float, str], ...]
    log: bool = False

    def at(self, value: object) -> float:
        """Where a value stands, in per cent; what is beyond stands at the edge.

        Examples
        --------
        >>> linear([0.2, 0.7]).at(0.4), logarithmic([4]).at(float("inf"))
        (50.0, 100.0)
        """
        number = float(value)  # type: ignore[arg-type]
        if self.log:
            number, low, high = (log(max(one, 1e-300)) if isfinite(one) else one for one in (number, self.low, self.high))
        else:
            low, high = self.low, self.high
        share = (number - low) / (high - low) if isfinite(number) else float(number > 0)
        return round(100 * min(1.0, max(0.0, share)), 2)

    @property
    def labels(self) -> str:
        """The ticks with their numbers, as the inside of an SVG."""
        parts = []
        for value, text in self.ticks:
            x = self.at(value)
            anchor = "start" if x < 4 else "end" if x > 96 else "middle"
            parts.append(f'<text x="{x}%" y="12" text-anchor="{anchor}">{text}</text>')
        return "".join(parts)

    def track(
        self,
        *,
        dots: Iterable[tuple[object, str]] = (),
        whiskers: Iterable[tuple[object, object]] = (),
        bars: Iterable[tuple[object, str]] = (),
        rings: Iterable[object] = (),
        limits: Iterable[object] = (),
        lines: Iterable[object] = (),
        beyond: tuple[object, object] | None = None,
    ) -> str:
        """The marks of one row, as the inside of an SVG.

        Parameters
        ----------
        dots, bars : iterable of (number, str)
            What was measured, and bars from the lower end of the scale to a bound, each with its class.
        whiskers : iterable of (number, number)
            Intervals.
        rings : iterable of number
            What would be without filters.
        limits : iterable of number
            Where a target is.
        lines : iterable of number
            What the rest is compared with.
        beyond : pair of numbers, optional
            What is shaded, as being beyond a target.

        Examples
        --------
        >>> linear([1]).track(dots=[(0.5, "")]).count("<line"), "<circle" in linear([1]).track(dots=[(0.5, "")])
        (6, True)
        """
        parts = []
        if beyond is not None:
            start, end = self.at(beyond[0]), self.at(beyond[1])
            parts.append(f'<rect class="beyond" x="{start}%" width="{max(0.0, round(end - start, 2))}%" y="{TOP}" height="{BOTTOM}"/>')
        for value, _ in self.ticks:
            x = self.at(value)
            parts.append(f'<line class="tick" x1="{x}%" x2="{x}%" y1="{TOP}" y2="{BOTTOM}"/>')
        parts.append(f'<line class="rail" x1="0" x2="100%" y1="{MIDDLE}" y2="{MIDDLE}"/>')
        parts += [f'<rect class="bar {kind}" x="0" width="{max(0.6, self.at(v))}%" y="10" height="6" rx="2"/>' for v, kind in bars]
        for low, high in whiskers:
            a, b = self.at(low), self.at(high)
            parts.append(f'<line class="whisker" x1="{a}%" x2="{max(b, a + 0.4)}%" y1="{MIDDLE}" y2="{MIDDLE}"/>')
        parts += [f'<line class="limit" x1="{x}%" x2="{x}%" y1="{TOP}" y2="{BOTTOM}"/>' for x in map(self.at, limits)]
        parts += [f'<line class="line" x1="{x}%" x2="{x}%" y1="{TOP}" y2="{BOTTOM}"/>' for x in map(self.at, lines)]
        parts += [f'<circle class="before" cx="{self.at(value)}%" cy="{MIDDLE}" r="4"/>' for value in rings]
        parts += [f'<circle class="{f"dot {kind}".strip()}" cx="{self.at(value)}%" cy="{MIDDLE}" r="5.5"/>' for value, kind in dots]
        return "".join(parts)


def steps(low: float, high: float, most: int = 6) -> list[float]:
    """Round numbers from at most `low` to at least `high`, fewer than `most` steps apart.

    Examples
    --------
    >>> steps(0, 0.9), steps(1, 4.4)
    ([0.0, 0.2, 0.4, 0.6, 0.8, 1.0], [1.0, 2.0, 3.0, 4.0, 5.0])
    """
    low, high = max(low, -MOST), min(high, MOST)
    width = high - low
    if width < 1 / MOST:
        return [low, low + 1]
    rough = width / most
    unit = 10.0 ** floor(log10(rough))
    unit *= next(step for step in (1, 2, 2.5, 5, 10) if step * unit >= rough * (1 - 1e-9))
    first, last = floor(low / unit + 1e-9), ceil(high / unit - 1e-9)
    digits = max(0, 2 - floor(log10(unit)))
    return [round(i * unit, digits) for i in range(first, last + 1)]


def from_one(high: float, most: int = 5) -> list[float]:
    """Round numbers from 1 to at least `high`.

    Examples
    --------
    >>> from_one(23), from_one(2.9)
    ([1.0, 5.0, 10.0, 15.0, 20.0, 25.0], [1.0, 1.5, 2.0, 2.5, 3.0])
    """
    return [1.0, *(mark for mark in steps(1, high, most) if mark > 1)]


def linear(values: Iterable[object], *, percent: bool = False) -> Axis:
    """A scale from 0, or from the least value below it, to the greatest.

    Examples
    --------
    >>> [text for _, text in linear([0.3, 0.45], percent=True).ticks]
    ['0', '20 %', '40 %', '60 %']
    """
    finite = [number for number in map(float, values) if isfinite(number)]  # type: ignore[arg-type]
    marks = steps(min([0.0, *finite]), max([0.0, *finite]), 4)
    if percent:
        marks = [mark for mark in marks if mark <= 1]
    texts = [f"{100 * mark:.10g} %" if percent and mark else f"{mark:.4g}" for mark in marks]
    return Axis(marks[0], marks[-1], tuple(zip(marks, texts, strict=True)))


def logarithmic(values: Iterable[object], *, both: bool = False) -> Axis:
    """A logarithmic scale from 1 to the greatest finite value, with some room; with `both`, as far below 1, too.

    Examples
    --------
    >>> [text for _, text in logarithmic([1.328, 3.1]).ticks]
    ['1', '1.5', '2', '3']
    """
    greatest = max((number for number in map(float, values) if isfinite(number)), default=1.0)  # type: ignore[arg-type]
    high = max(1.1, min(MOST, greatest) ** 1.06 * 1.01)
    marks = [float(mark) for mark in RATIOS if mark <= high]
    room = 0.11 * log(high)
    for mark in reversed(marks[1:]):
        if any(other != mark and 0 <= log(mark) - log(other) < room for other in marks):
            marks.remove(mark)
    if both:
        marks = [*(1 / mark for mark in reversed(marks[1:])), *marks]
    texts = [f"{mark:.4g}" if mark >= 1 else f"1/{1 / mark:.4g}" for mark in marks]
    return Axis(1 / high if both else 1.0, high, tuple(zip(marks, texts, strict=True)), log=True)
