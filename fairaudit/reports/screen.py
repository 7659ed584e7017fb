"""The first screen: what an audit comes to, in at most 40 lines of 80 columns whatever was audited.

Every part has a least and a greatest number of lines. What does not fit is counted ("and 37 more"), long labels are shortened, and
colour, where a terminal shows it, repeats what words say. A command to copy stays in one line, however long its file's name is.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

from fairaudit.reports.overview import Overview
from fairaudit.reports.overview_parts import Compared, GroupLine, how_many
from fairaudit.reports.overview_verdict import figure
from fairaudit.reports.words import clip
from fairaudit.words import COLUMNS, columns_of, first_columns, plain, wrapped

__all__ = ["CONTEXTS", "GROUPS", "LINES", "first_screen", "shortened"]


LINES = 40

GROUPS = 12  # groups that are listed at the most

CONTEXTS = 10

LEAST_LABEL = 6  # columns of a label, below which a row of contexts leaves out how many decisions there are

WORST = ", worst first"

COLOURS = {"exceeds": 31, "within": 32, "inconclusive": 33, "depends": 33, "changed": 31}


def shortened(text: str, width: int) -> str:
    """A text in so many columns: of a longer one its beginning and its end.

    Examples
    --------
    >>> shortened("Mary 55 American / Tom 25 Asian", 18)
    'Mary 55 Amer…Asian'
    """
    if columns_of(text) <= width and len(text) <= 2 * width:
        return text
    tail = (width - 1) // 3
    return f"{first_columns(text, width - 1 - tail)}…{first_columns(text[::-1], tail)[::-1]}"


@dataclass(frozen=True)
class Part:
    """A part of the screen: gives at most so many lines, of which it needs some, and would have more."""

    lines: Callable[[int], list[str]]
    least: int
    most: int


def _text(lines: Sequence[str], least: int = 1) -> Part:
    """Lines of which the last one that is shown ends with dots where others follow."""

    def cut(most: int) -> list[str]:
        if len(lines) <= most:
            return [*lines]
        return [*lines[: most - 1], f"{first_columns(lines[most - 1], COLUMNS - 2).rstrip()} …"] if most else []

    return Part(cut, min(least, len(lines)), len(lines))


def _listed(lines: list[str], least: int, more: str) -> Part:
    """Lines of which those that are not shown are counted."""

    def cut(most: int) -> list[str]:
        return lines if len(lines) <= most else [*lines[: most - 1], more.format(len(lines) - most + 1)] if most else []

    return Part(cut, min(least, len(lines)), len(lines))


def first_screen(found: Overview, name: str, then: str, findings: Sequence[str] = (), *, colour: bool = False) -> str:
    """Say what an audit comes to on one screen.

    Parameters
    ----------
    found : Overview
        What it comes to.
    name : str
        What was read.
    then : str
        What to do next.
    findings : sequence of str
        What tests found that were asked for.
    colour : bool
        Whether a terminal shows it.

    Examples
    --------
    >>> import fairaudit as fa
    >>> from fairaudit.reports.overview import of_result
    >>> table = {"decision": ["hired", "turned down"] * 2, "sex": ["f", "f", "m", "m"], "n": [30, 10, 20, 20]}
    >>> result = fa.audit(table, decision="decision", group="sex", count="n", utility="hired", confidence=None)
    >>> print(first_screen(of_result(result), "jobs.csv", "fairaudit verify jobs.json").split("Left out")[0])
    jobs.csv: 80 decisions, 2 groups (sex), no contexts
    Counted as not hired: turned down 30.
    <BLANKLINE>
    NO TARGET was set.
    hired: sex=f 75.0 % (30 of 40), sex=m 50.0 % (20 of 40), 1.5 times.
    Established beyond chance: not asked (no interval was computed; the figures
      describe this table alone)
    <BLANKLINE>
    sex   n   hired  to the best
    m    40  50.0 %        0.667
    f    40  75.0 %            1
    <BLANKLINE>
    <BLANKLINE>
    """
    targets = [line for verdict, limit in found.targets for line in wrapped(f"{verdict.upper():<13}{plain(limit)}", 13)]
    parts = {
        "audited": _text(wrapped(f"{shortened(clip(name), 50)}: {found.audited}"), 1),
        "others": _text([shortened(plain(found.others), COLUMNS)] if found.others else []),
        "targets": _text(targets or ["NO TARGET was set."], 2),
        "cautions": _text([line for text in found.cautions for line in wrapped(text)], 1),
        "sentences": _text([line for text in found.sentences for line in wrapped(text)], 4),
        "chance": _text([line for text in found.chance for line in wrapped(_established(*text), 2)], 2),
        "findings": _text([line for text in findings for line in wrapped(plain(text), 2)], 3),
        "beside": _text([line for text in found.beside for line in _short(plain(text))], 4),
        "groups": _groups(found),
        "contexts": _contexts(found),
        "left out": _left_out(found.left_out),
        "assumed": _assumed(found.assumptions),
        "next": _text([*_next(plain(then)), "--verbose prints everything that was found."], 3),
    }
    blocks = [[name for name in block if parts[name].most] for block in BLOCKS]
    given = _shared(parts, LINES - sum(map(bool, blocks)) + 1)
    made = []
    for block in filter(None, blocks):
        lines = [(line, name, i == 0) for name in block for i, line in enumerate(parts[name].lines(given[name]))]
        made.append("\n".join(_painted(*line) if colour else line[0] for line in lines))
    return "\n\n".join(made)


BLOCKS = (
    ("audited", "others"),
    ("targets", "cautions", "sentences", "chance"),
    ("findings", "beside"),
    ("groups",),
    ("contexts",),
    ("left out", "assumed"),
    ("next",),
)

STAGES = (
    ("audited", 2),
    ("sentences", 12),
    ("chance", 4),
    ("cautions", 7),
    ("targets", 4),
    ("findings", 9),
    ("groups", 7),
    ("contexts", 6),
    ("assumed", 7),
    ("left out", 3),
    ("beside", 6),
    ("next", 5),
    ("left out", 7),
    ("targets", 8),
    ("sentences", 16),
    ("groups", 13),
    ("contexts", 12),
)
"""In which order parts get up to so many lines, once each has its least."""


def _shared(parts: Mapping[str, Part], room: int) -> dict[str, int]:
    """How many lines each part gets."""
    given = {name: part.least for name, part in parts.items()}
    room -= sum(given.values())
    for name, most in STAGES:
        more = max(0, min(room, min(parts[name].most, most) - given[name]))
        given[name] += more
        room -= more
    return given


def _short(text: str) -> list[str]:
    """A text in two lines at the most."""
    return _text(wrapped(text, 2)).lines(2)


def _established(answer: str, why: str) -> str:
    """Whether the verdict is more than chance, in a line."""
    return f"Established beyond chance: {answer} {why}" if answer == "it depends" else f"Established beyond chance: {answer} ({why})"


def _next(then: str) -> list[str]:
    """What to do next; a command stays in one line, so that it can be copied."""
    if not then.startswith("fairaudit "):
        return wrapped(f"Next: {then}", 6)
    return [f"Next: {then}"] if columns_of(then) + len("Next: ") <= COLUMNS else ["Next:", then]


def _left_out(listed: Sequence[str]) -> Part:
    """What was left out, merged or cut."""
    if not listed:
        return _text(["Left out: nothing"])
    lines = [(i, line) for i, text in enumerate(listed) for line in wrapped(f"As read:  {text}", 10)]
    return _text([line if i == 0 else line.replace("As read:", "        ", 1) for i, line in lines], 2)


def _assumed(listed: Sequence[str]) -> Part:
    """What is assumed."""
    return _listed(["Assumed, for you to judge:", *(shortened(f"  - {text}", COLUMNS) for text in listed)], 3, "  and {} more")


Cell = tuple[str, str]
"""A label, which may be shortened, and what may not."""


def _groups(found: Overview) -> Part:
    """The table of groups, the worst first and the best last."""
    groups, sizes = found.groups, [line.gets.size for line in found.groups if line.gets.size is not None]
    unit = [] if not sizes else ["units" if sizes[0].units is not None else "n"]
    between = [f"interval, each {found.sure}"] if found.sure else []
    apart = ("above best" if found.burden else "below best") if found.signed else "to the best"
    heads = [" / ".join(map(clip, found.columns.group)), *unit, shortened(found.amount, 18), *between, apart]

    def row(line: GroupLine) -> list[Cell]:
        gets = line.gets
        size = "" if gets.size is None else how_many(gets.size.decisions) if gets.size.units is None else f"{gets.size.units:,}"
        cells = [(size, unit), (gets.amount, True), (line.between, between), (found.to_the_best(line), True)]
        return [(gets.short, ""), *(("", text) for text, shown in cells if shown)]

    def cut(most: int) -> list[str]:
        kept = groups if not found.more_groups and len(groups) < most else (*groups[: most - 3], groups[-1])
        more = found.more_groups + len(groups) - len(kept)
        head, *rows = _aligned(heads, [row(line) for line in kept])
        return [head, *rows[:-1], f"… and {more:,} more between them", rows[-1]] if more else [head, *rows]

    size = 1 + len(groups) + (found.more_groups > 0)
    return Part(cut, min(4, size), size) if groups else _text([])


def _contexts(found: Overview) -> Part:
    """The most unequal contexts."""
    contexts = found.contexts
    heads = [f"{' / '.join(map(clip, found.columns.context))}{WORST}", "apart" if found.signed else "ratio", "highest", "lowest"]

    def row(pair: Compared, *, of: bool) -> list[Cell]:
        who = [(gets.short, f"{gets.amount} ({gets.of})" if of and gets.of else gets.amount) for gets in (pair.higher, pair.lower)]
        return [(pair.where, ""), ("", figure(pair.apart.value, digits=3)), *who]

    def cut(most: int) -> list[str]:
        kept = contexts if not found.more_contexts and len(contexts) < most else contexts[: most - 2]
        more = found.more_contexts + len(contexts) - len(kept)
        rows = [row(pair, of=True) for pair in kept]
        if _cap(heads, rows) < min(LEAST_LABEL, max(columns_of(label) for cells in rows for label, _ in cells)):
            rows = [row(pair, of=False) for pair in kept]
        return [*_aligned(heads, rows), *([f"… and {more:,} more, none of them worse"] if more else [])]

    size = 1 + len(contexts) + (found.more_contexts > 0)
    return Part(cut, min(3, size), size) if contexts else _text([])


def _cap(heads: Sequence[str], rows: Sequence[Sequence[Cell]]) -> int:
    """To how many columns labels are shortened, so that rows fit; the heads of numbers are not."""
    columns = [*zip(*rows, strict=True)]
    needed = [max(columns_of(label) for label, _ in column) for column in columns]
    fixed = [max(columns_of(rest) + bool(label and rest) for label, rest in column) for column in columns]
    fixed = [width if labels else max(width, columns_of(head)) for width, labels, head in zip(fixed, needed, heads, strict=True)]
    room = COLUMNS - sum(fixed) - 2 * (len(heads) - 1)
    return next((cap for cap in range(min(COLUMNS, max(needed)), 0, -1) if sum(min(cap, width) for width in needed) <= room), 0)


def _aligned(heads: Sequence[str], rows: Sequence[Sequence[Cell]]) -> list[str]:
    """A table with labels at the left and numbers at the right of their columns."""
    cap = max(3, _cap(heads, rows))
    texts = [[f"{shortened(label, cap)} {rest}".strip() for label, rest in row] for row in rows]
    left = [i == 0 or any(row[i][0] for row in rows) for i in range(len(heads))]
    widths = [max(columns_of(row[i]) for row in texts) for i in range(len(heads))]
    widths = [width if labels else max(width, columns_of(head)) for width, labels, head in zip(widths, left, heads, strict=True)]
    room = COLUMNS - sum(widths) - 2 * (len(heads) - 1)
    own = []
    for i, head in enumerate(heads):
        wider = max(0, min(columns_of(head) - widths[i], room))
        room -= wider
        widths[i] += wider
        own.append(head if columns_of(head) <= widths[i] else shortened(head.removesuffix(WORST), widths[i]))
    lines = []
    for row in [own, *texts]:
        pads = [" " * (width - columns_of(text)) for text, width in zip(row, widths, strict=True)]
        joined = (text + pad if to_left else pad + text for text, pad, to_left in zip(row, pads, left, strict=True))
        lines.append(shortened("  ".join(joined).rstrip(), COLUMNS))
    return lines


def _painted(line: str, part: str, first: bool) -> str:
    """A line as a terminal shows it: verdicts and headings stand out."""
    if part == "targets":
        word = line.split(" ")[0]
        return line.replace(word, f"\x1b[{COLOURS[word.lower()]};1m{word}\x1b[0m", 1) if word.lower() in COLOURS else line
    if part in ("groups", "contexts", "audited") and first:
        return f"\x1b[1m{line}\x1b[0m"
    return line
