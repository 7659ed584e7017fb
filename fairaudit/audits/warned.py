"""What to know of how a table was read, before any figure: undecided labels, counts that nobody named, weights that are no counts.

None of it is in a certificate, which is about the table as it was read.
"""

from __future__ import annotations

import os
from collections.abc import Collection, Mapping, Sequence
from dataclasses import replace
from fractions import Fraction
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from fairaudit.audits.column_names import COUNT, SURVEY_WEIGHT, named
from fairaudit.audits.undecided import decisions_by_group
from fairaudit.errors import FairauditError, shown
from fairaudit.tables.label_meaning import looking_undecided
from fairaudit.tables.label_text import label_text
from fairaudit.tables.number_form import guessed
from fairaudit.tables.tally import Tally
from fairaudit.tables.values import column, held_columns
from fairaudit.words import noun, to_copy

if TYPE_CHECKING:
    from fairaudit.audits.reading import Reading
    from fairaudit.audits.result import Result
    from fairaudit.model.law import Law
    from fairaudit.model.utility import Utility
    from fairaudit.tables.sources import Source

__all__ = ["columns_warned", "count_nobody_named", "labels_undecided", "looks_like_counts", "warned", "weight_no_count"]

ROWS = 1000  # of a table with more, nobody counted the rows by hand

SHOW_LABELS = 3

SHOW_GROUPS = 3

ROWS_PER_CELL = 2  # with as many rows for each combination of labels, numbers above 1 on average count people whom nobody asked


def warned(result: Result, utility: Utility, lexicon: Collection[str] = (), of_columns: Sequence[str] = ()) -> tuple[str, ...]:
    """What to know of how a table was read, a sentence or two each.

    Parameters
    ----------
    result : Result
        What was found.
    utility : Utility
        What decisions are worth, as it was given: the labels that it names are settled.
    lexicon : collection of str
        Labels that look undecided besides those of the package.
    of_columns : sequence of str
        What was found of columns while the table was at hand.
    """
    return tuple(text for text in (*of_columns, labels_undecided(result, utility, lexicon)) if text)


def columns_warned(source: Source, reading: Reading, table: Any, law: Law) -> tuple[str, ...]:
    """What to know of the columns of counts of a table that was just read."""
    found = (count_nobody_named(source, reading, law), weight_no_count(table, law, reading.count))
    return tuple(text for text in found if text)


def labels_undecided(result: Result, utility: Utility, lexicon: Collection[str] = ()) -> str:
    """Say which decisions look undecided and count as if they were not, of whom, and which options settle it; else nothing.

    A label that the utility names, or that is said to be undecided, is settled. So is every answer of an evaluation log.
    """
    law = result.law
    if result.deployment is not None or law.evaluation is not None or utility.entries is not None:
        return ""
    settled = {*utility.values, *law.undecided, *(() if result.undecided is None else result.undecided.decisions)}
    occurring = [label for u, label in enumerate(law.decisions) if label not in settled and law.weights[:, u].any()]
    found = looking_undecided(occurring, lexicon)
    if not found:
        return ""
    rest = len(found) - SHOW_LABELS
    more = f" and {rest} more {noun(rest, 'label')}" if rest > 0 else ""
    listed = " and ".join(map(shown, found)) if len(found) == 2 else ", ".join(map(shown, found[:SHOW_LABELS]))
    worth = [label for label, value in utility.values.items() if value]
    as_what = f"as not {shown(worth[0])}" if len(worth) == 1 else "as worth 0"
    whose = f": {_by_group(law, found)}" if law.kind == "counts" else ""
    looks, counts, pronoun, becomes = ("look", "count", "they", "become")
    if len(found) == 1:
        looks, counts, pronoun, becomes = ("looks", "counts", "it", "becomes")
    return (
        f"{listed}{more} {looks} undecided and {counts} {as_what}{whose}. "
        f"--undecided {to_copy(found)} bounds the ratio whatever {pronoun} {becomes}; "
        f"{to_copy(found[:1], '=0')} in --utility says that it was decided."
    )


def _by_group(law: Law, labels: Collection[str]) -> str:
    """How many decisions of each group have one of these labels, the greatest share first."""
    amounts = decisions_by_group(law, labels).items()
    shares = sorted((-amount / all_, label, amount, all_) for label, (amount, all_) in amounts if amount)
    said = [
        f"{_number(amount)} of {_number(all_)}{' decisions' if i == 0 else ''} on {', '.join(map(shown, label))}"
        for i, (_, label, amount, all_) in enumerate(shares[:SHOW_GROUPS])
    ]
    more = len(shares) - SHOW_GROUPS
    return ", ".join([*said, *([f"some on {more:,} more {noun(more, 'group')}"] if more > 0 else [])])


def _number(amount: Fraction) -> str:
    return f"{int(amount):,}" if amount.denominator == 1 else f"{float(amount):,.4g}"


def weight_no_count(table: Any, law: Law, count: str | None) -> str:
    """Say that a column of counts is named like a survey weight, where many rows of each combination stand for more than themselves.

    Examples
    --------
    >>> import fairaudit as fa
    >>> table = {"hired": ["yes", "no"] * 20, "sex": ["f", "f", "m", "m"] * 10, "PWGTP": [100 + n for n in range(40)]}
    >>> law = fa.Law.from_counts(table, decision="hired", group="sex", count="PWGTP")
    >>> weight_no_count(table, law, "PWGTP")
    "40 rows stand for 4,780 decisions: if 'PWGTP' is a survey weight, the intervals are not valid."
    """
    if count is None or not named(count, SURVEY_WEIGHT):
        return ""
    rows = table.rows if isinstance(table, Tally) else len(column(table, count))
    total = Fraction(sum(law.cell_mass), law.scale)
    if rows < ROWS_PER_CELL * np.count_nonzero(law.weights) or total < 2 * rows:
        return ""
    stand = f"{rows:,} {noun(rows, 'row')} stand for {int(total):,} decisions"
    return f"{stand}: if {shown(count)} is a survey weight, the intervals are not valid."


def count_nobody_named(source: Source, reading: Reading, law: Law) -> str:
    """Say that a column looks like counts, where each row was counted once; nothing where the table is large, or cannot be read again."""
    named_counts = (reading.count, reading.probability, reading.wide, reading.unit, reading.utility_column, reading.above, law.evaluation)
    if any(given is not None and given != () for given in named_counts) or law.kind != "counts" or sum(law.cell_mass) > ROWS * law.scale:
        return ""
    try:
        cells = _cells(source, reading)
    except FairauditError:
        return ""
    used = {reading.decision, *reading.group, *reading.context, *([] if reading.truth is None else [reading.truth])}
    found = next((name for name in cells if name not in used and looks_like_counts(name, cells, used)), None)
    if found is None:
        return ""
    return f"Column {shown(found)} looks like counts, and each row counts as one decision: --count {to_copy([found])}."


def looks_like_counts(name: str, cells: Mapping[str, Sequence[str]], used: Collection[str]) -> bool:
    """Whether a column of a table may say how often a row occurred.

    It is named so, its numbers are whole and do not number the rows, and each combination of the labels beside it has one row.

    Parameters
    ----------
    name : str
        The column.
    cells : mapping of str to sequence of str
        The table, as texts.
    used : collection of str
        Columns of the decision, the group and the context.

    Examples
    --------
    >>> table = {"sex": ["f", "f", "m", "m"], "hired": ["yes", "no"] * 2, "n": ["89", "19", "512", "313"], "age": ["31", "44", "25", "52"]}
    >>> [looks_like_counts(name, table, {"sex", "hired"}) for name in ("n", "age")]
    [True, False]
    """
    if not named(name, COUNT):
        return False
    written = guessed(cells[name])
    texts = cells[name] if written is None else [written[1][text] for text in cells[name]]
    if not all(text.isascii() and text.isdecimal() and len(text) < 16 for text in texts):
        return False
    numbers = [int(text) for text in texts]
    if max(numbers, default=0) < 2 or sorted(numbers) in (list(range(len(numbers))), list(range(1, len(numbers) + 1))):
        return False
    labels = [column for own, column in cells.items() if own != name and (own in used or 2 * len(set(column)) <= len(column))]
    rows = list(zip(*labels, strict=True))
    return len(set(rows)) == len(rows)


def _cells(source: Source, reading: Reading) -> dict[str, list[str]]:
    """All columns of a small table as texts; none of what is read only once, or elsewhere."""
    from fairaudit.audits.reading import read_table
    from fairaudit.tables.engines.files import columns_in
    from fairaudit.tables.engines.logs import survey_log

    access = replace(reading.access, engine="auto")  # which starts nothing for a small file
    paths: Sequence[Any] = source if isinstance(source, (list, tuple)) else [source]
    names: Sequence[str] = ()
    if not isinstance(source, (str, os.PathLike, list, tuple)):
        names = held_columns(source)
    elif all(isinstance(path, (str, os.PathLike)) and Path(path).is_file() for path in paths):
        known = columns_in(os.fspath(paths[0]), access.skip)
        if known and not any(named(name, COUNT) for name in known):
            return {}
        where: dict[str, Any] = {name: getattr(access, name) for name in ("engine", "table", "query", "skip", "encoding")}
        survey = survey_log(source, **where, same_content=access.same_content)
        names = [seen.name for seen in survey.columns if not seen.fault]
    if not any(named(name, COUNT) for name in names):
        return {}
    table = read_table(source, names, {}, {}, access)
    if isinstance(table, Tally) and table.rows > len(table):
        return {}
    return {name: [label_text(value) or "" for value in column(table, name)] for name in names}
