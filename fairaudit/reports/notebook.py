"""What a notebook shows of a result, in the order of every other face: HTML without script, style sheet or anything from elsewhere.

Colours are those of the notebook, light or dark; positions in pictures are rounded, and every number stands beside them as text.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from fractions import Fraction
from html import escape
from math import ceil, floor, inf, isfinite, log10
from typing import TYPE_CHECKING

from fairaudit.measures.rates import NAMES
from fairaudit.reports.overview import Overview, of_result
from fairaudit.reports.overview_parts import Compared, GroupLine
from fairaudit.reports.overview_verdict import figure
from fairaudit.reports.words import Value, clip
from fairaudit.tables.preparation import said
from fairaudit.words import approximate, ends_text, plain

if TYPE_CHECKING:
    from fairaudit.audits.result import Result
    from fairaudit.inference.differences import DifferenceInterval
    from fairaudit.inference.interval import Interval

__all__ = ["notebook"]

CONTEXTS = 6  # in a notebook

WIDTH, HEIGHT = 180, 16  # of the picture in a row

CELL = ' style="text-align:left;padding:2px 12px 2px 0"'


def notebook(result: Result) -> str:
    """Show a result in a notebook.

    Examples
    --------
    >>> import fairaudit as fa
    >>> table = {"decision": ["hired", "turned down"] * 2, "sex": ["f", "f", "m", "m"], "n": [30, 10, 20, 20]}
    >>> result = fa.audit(table, decision="decision", group="sex", count="n", utility="hired", confidence=None)
    >>> "<bdi>hired: sex=f 75.0 % (30 of 40), sex=m 50.0 % (20 of 40), 1.5 times.</bdi>" in notebook(result)
    True
    """
    found = of_result(result, contexts=CONTEXTS)
    parts = [
        _lines([f"{found.audited[:1].upper()}{found.audited[1:]}.", *([found.others] if found.others else [])]),
        *_verdict(found),
        _groups(found),
        _contexts(found),
        _list("As read", [*said({"spellings": result.spellings}), *found.left_out]),
        _list("Also", found.beside),
        _folded("Assumed, for you to judge", _items(found.assumptions)) if found.assumptions else "",
        _folded("All figures", f"{_lines([result.sentence])}<table>{''.join(_figures(result))}</table>"),
        '<p>Next: <code>result.report("report.html")</code> writes it for others, with the certificate that they can check.</p>',
    ]
    return f'<div class="fairaudit">{"".join(parts)}</div>'


def _text(text: str) -> str:
    """A text whose labels are data."""
    return f"<bdi>{escape(plain(text))}</bdi>"


def _lines(texts: Iterable[str]) -> str:
    return "".join(f"<p>{_text(text)}</p>" for text in texts)


def _items(texts: Iterable[str]) -> str:
    return f"<ul>{''.join(f'<li>{_text(text)}</li>' for text in texts)}</ul>"


def _list(title: str, texts: Sequence[str]) -> str:
    return f"<p>{title}:</p>{_items(texts)}" if texts else ""


def _folded(title: str, inner: str) -> str:
    return f"<details><summary>{title}</summary>{inner}</details>"


def _verdict(found: Overview) -> Iterator[str]:
    """The verdict on each target, the pair that decided it, and whether that is more than chance."""
    for verdict, limit in found.targets:
        yield f"<p><strong>{verdict}</strong> {_text(limit)}</p>"
    if not found.targets:
        yield "<p><strong>no target was set</strong></p>"
    yield _lines([*found.cautions, *found.sentences])
    for answer, why in found.chance:
        yield f"<p>Established beyond chance: <strong>{answer}</strong> ({_text(why)})</p>"


def _table(heads: Sequence[str], rows: Iterable[Sequence[str]]) -> str:
    """A table whose cells are HTML."""
    head = "".join(f'<th scope="col"{CELL}>{cell}</th>' for cell in heads)
    body = "".join(f"<tr>{''.join(f'<td{CELL}>{cell}</td>' for cell in row)}</tr>" for row in rows)
    return f'<table style="margin:8px 0"><thead><tr>{head}</tr></thead><tbody>{body}</tbody></table>'


def _groups(found: Overview) -> str:
    """What each group gets, the worst first, with a picture on one scale."""
    if not found.groups:
        return ""
    scale = _Scale(found)
    sizes = [line.gets.of for line in found.groups]
    heads = [_text(" / ".join(map(clip, found.columns.group))), _text(found.amount)]
    heads += ["of"] if any(sizes) else []
    heads += [f"interval, each {found.sure}"] if found.sure else []
    apart = ("above the best" if found.burden else "below the best") if found.signed else "ratio to the best"
    heads += [f"{scale.least} to {scale.greatest}", apart]

    def row(line: GroupLine) -> list[str]:
        cells = [_text(line.gets.short), line.gets.amount, *([_text(line.gets.of)] if any(sizes) else [])]
        return [*cells, *([line.between] if found.sure else []), scale.picture(line), found.to_the_best(line)]

    rows = [row(line) for line in found.groups]
    if found.more_groups:
        rows.insert(-1, [f"… and {found.more_groups:,} more between them", *[""] * (len(heads) - 1)])
    return _table(heads, rows)


def _round(most: float) -> float:
    """The end of a scale: a number of one or two digits that is not less."""
    if not 0 < most < inf:
        return most
    step = 10.0 ** floor(log10(most)) / 2
    return min(ceil(most / step) * step, 1.0) if most <= 1 else ceil(most / step) * step


class _Scale:
    """One scale for the means and intervals of all groups, from 0 or from the least."""

    def __init__(self, found: Overview) -> None:
        values = [end for line in found.groups for end in (line.gets.mean, *(line.ends or ()))]
        self.low = -_round(-min(0.0, *map(float, values))) or 0.0
        self.high = _round(max(0.0, *map(float, values))) or 1.0
        self.rate = found.rates
        self.drawn = isfinite(self.high - self.low)

    @property
    def least(self) -> str:
        """Its left end."""
        return f"{self.low:.3g}"

    @property
    def greatest(self) -> str:
        """Its right end."""
        return f"{100 * self.high:.3g} %" if self.rate else f"{self.high:.3g}" if self.drawn else ""

    def picture(self, line: GroupLine) -> str:
        """A line at the mean on a bar from end to end."""
        if not self.drawn:
            return ""
        x = self._at(line.gets.mean)
        said_ = f"{line.gets.amount}, {line.between}" if line.between else line.gets.amount
        bar = ""
        if line.ends is not None:
            low, high = map(self._at, line.ends)
            bar = f'<rect x="{low:.1f}" y="4" width="{max(1.0, high - low):.1f}" height="8" rx="2" fill="currentColor" opacity="0.4"/>'
        axis = f'<line x1="0" x2="{WIDTH}" y1="8" y2="8" stroke="currentColor" opacity="0.25"/>'
        return (
            f'<svg width="{WIDTH}" height="{HEIGHT}" viewBox="-5 0 {WIDTH + 10} {HEIGHT}" role="img" aria-label="{escape(said_)}">'
            f'{axis}{bar}<rect x="{x - 1:.1f}" y="1" width="2" height="14" fill="currentColor"/></svg>'
        )

    def _at(self, value: Value) -> float:
        return WIDTH * (float(value) - self.low) / (self.high - self.low)


def _contexts(found: Overview) -> str:
    """The most unequal contexts, worst first."""
    if not found.contexts:
        return ""

    def row(pair: Compared) -> list[str]:
        who = [_text(f"{gets.short} {gets.amount}{f' ({gets.of})' if gets.of else ''}") for gets in (pair.higher, pair.lower)]
        return [_text(pair.where), figure(pair.apart.value, digits=3), *who]

    rows = [row(pair) for pair in found.contexts]
    if found.more_contexts:
        rows.append([f"… and {found.more_contexts:,} more, none of them worse", "", "", ""])
    where = f"{_text(' / '.join(map(clip, found.columns.context)))}, worst first"
    return _table([where, "apart" if found.signed else "ratio", "highest", "lowest"], rows)


def _figures(result: Result) -> Iterator[str]:
    """Every figure, in some digits and exactly."""
    for name, measured in () if result.utility.signed else (("local ratio", result.local), ("global ratio", result.global_)):
        yield _figure(name, None if measured is None else measured.ratio)
    for name, distance in result.distances.items():
        if distance is not None:
            yield _figure(name, distance.value)
    for key, rate in (result.given_truth.differences if result.given_truth else {}).items():
        if rate is not None:
            yield _figure(NAMES[key], rate.value)
    for quantity, interval in result.intervals.items():
        of = "" if interval.of_units is None else f" ({interval.estimand}; {approximate(interval.of_units.ratio)} in this log)"
        yield _interval(f"{quantity} ratio", of, interval)
    for quantity, apart in (result.differences.measured if result.differences else {}).items():
        yield _figure(f"{quantity} difference", None if apart is None else apart.value)
    for quantity, known in (result.differences.intervals if result.differences else {}).items():
        yield _interval(f"{quantity} difference", "", known)


def _figure(name: str, value: Fraction | float | None) -> str:
    if value is None:
        return f"<tr><td>{name}</td><td>not compared</td><td></td></tr>"
    return f"<tr><td>{name}</td><td>{approximate(value)}</td><td>{_exactly(value)}</td></tr>"


def _interval(name: str, of: str, known: Interval | DifferenceInterval) -> str:
    each = known.ends == "each"
    ends = ends_text(approximate(known.lower, "down"), approximate(known.upper, "up"), each=each)
    full = f"{name} of the population{of}, {'each end ' if each else ''}at confidence {known.confidence}"
    return f"<tr><td>{full}</td><td>{ends}</td><td></td></tr>"


def _exactly(value: Fraction | float) -> str:
    """The rational, where it is short enough to be read."""
    if not isinstance(value, Fraction) or max(value.numerator, value.denominator).bit_length() > 200:
        return ""
    return str(value)
