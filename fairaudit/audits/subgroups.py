"""`subgroups`: the conjunctions of attribute values that fare most unequally beside the rest, and a certificate that none is worse."""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from functools import cached_property
from math import ceil
from pathlib import Path
from typing import TYPE_CHECKING

from fairaudit.arguments import answered
from fairaudit.audits.reading import Access, Reading, refuse_two_utilities
from fairaudit.audits.subgroup_rows import SubgroupLog, read_subgroup_log
from fairaudit.certificates.certificate import Certificate
from fairaudit.errors import InputError, shown
from fairaudit.exact.collecting import uncollected
from fairaudit.exact.extended import Extended
from fairaudit.exact.rationals import Number, option_value
from fairaudit.inference.cells import Cell, Ends
from fairaudit.inference.levels import confidence_level
from fairaudit.inference.subgroup_ends import both_ends, ratio_ends
from fairaudit.inference.verdicts import Verdict, exit_code
from fairaudit.measures.limits import read_limit
from fairaudit.model.utility import Utility, Values, utility_values
from fairaudit.tables.binning import Bins
from fairaudit.tables.columns import Missing
from fairaudit.tables.engines.logs import Engine
from fairaudit.tables.engines.request import Report
from fairaudit.tables.labels import LabelMap, read_label_map
from fairaudit.tables.number_form import number_form
from fairaudit.tables.sources import Source
from fairaudit.tables.values import names
from fairaudit.theorems.t18 import Side
from fairaudit.theorems.t18_search import Found, Worst, conjunctions, every_conjunction, most_unequal
from fairaudit.words import approximate, brief, place, words_for

if TYPE_CHECKING:
    import pandas as pd

__all__ = ["MOST_LISTED", "Subgroup", "Subgroups", "find_subgroups", "subgroups"]

DEFAULT_CONFIDENCE: Number = 0.95

MOST_LISTED = 20_000
"""Conjunctions whose intervals a certificate lists, one by one, where a target is within reach of all of them."""


@brief
@dataclass(frozen=True, repr=False)
class Subgroup:
    """Rows that share some attribute values, beside the rest.

    Attributes
    ----------
    conditions : mapping of str to str
        The attributes and their values.
    rows : int
        How many rows there are.
    mean, rest : Fraction
        The mean utility of these rows, and that of all others.
    ratio : Fraction or inf
        The greater of the two over the less.
    side : {"more", "less", "equal"}
        Whether the subgroup gets more than the rest.
    same : tuple of mapping
        Other conditions that the same rows have.
    ends, rest_ends : pair of Fraction, or None
        Ends of both means in the population, which hold for all subgroups at once.

    Examples
    --------
    >>> log = {"sex": ["f", "f", "m", "m"], "hired": ["yes", "no", "yes", "no"], "n": [3, 1, 2, 2]}
    >>> first = subgroups(log, decision="hired", attributes="sex", count="n", utility="yes").found[0]
    >>> first.conditions, first.mean, first.rest, first.ratio
    ({'sex': 'f'}, Fraction(3, 4), Fraction(1, 2), Fraction(3, 2))
    """

    conditions: Mapping[str, str]
    rows: int
    mean: Fraction
    rest: Fraction
    ratio: Extended
    side: Side
    same: tuple[Mapping[str, str], ...] = ()
    ends: Ends | None = None
    rest_ends: Ends | None = None

    @property
    def interval(self) -> tuple[Extended, Extended] | None:
        """What the ends leave of the ratio in the population."""
        return None if self.ends is None or self.rest_ends is None else ratio_ends(self.ends, self.rest_ends)


@brief
@dataclass(frozen=True, eq=False, repr=False)
class Subgroups:
    """The most unequal subgroups of a log; made by `subgroups`.

    Attributes
    ----------
    found : tuple of Subgroup
        The most unequal ones, falling; each stands for all conditions that the same rows have.
    depth, least_rows : int
        How many conditions a subgroup has at most, and how many rows at least.
    share : Fraction or None
        What share of all rows that is, where a share was asked for.
    conjunctions : int
        How many conjunctions of attribute values there are, whether any row has them or not.
    rows : int
        How many rows the log has.
    mean : Fraction
        Their mean utility.
    confidence : Fraction or None
        That of the intervals.
    limit : Fraction or None
        The target.
    verdict : {"none", "within", "exceeds", "inconclusive"}
        On the target.
    log : SubgroupLog
        What was read.
    worst : Worst
        What was found, by position, with the frontier of the search.
    everybody : tuple
        Each conjunction of the family with both of its ends, where all of them together prove that the population is within the target.
    burden : bool
        Whether the utility counts a burden.
    embed : bool or None
        Whether the certificate holds the table.

    Examples
    --------
    >>> log = {"sex": ["f", "f", "m", "m"], "hired": ["yes", "no", "yes", "no"], "n": [300, 100, 200, 200]}
    >>> found = subgroups(log, decision="hired", attributes="sex", count="n", utility="yes", max_ratio="5/4")
    >>> found.verdict, found.rows, found.least_rows
    ('inconclusive', 800, 8)
    """

    found: tuple[Subgroup, ...]
    depth: int
    least_rows: int
    share: Fraction | None
    conjunctions: int
    confidence: Fraction | None
    limit: Fraction | None
    verdict: Verdict
    log: SubgroupLog
    worst: Worst
    everybody: tuple[tuple[tuple[tuple[int, int], ...], Ends, Ends], ...] = ()
    burden: bool = False
    embed: bool | None = None

    @property
    def rows(self) -> int:
        """How many rows the log has."""
        return self.log.table.measured.rows

    @property
    def mean(self) -> Fraction:
        """Their mean utility."""
        return Fraction(self.log.table.measured.total, self.log.table.scale * self.rows)

    @property
    def ratio(self) -> Extended:
        """The greatest ratio."""
        return self.found[0].ratio

    @property
    def notes(self) -> tuple[str, ...]:
        """What was noticed while reading."""
        return self.log.notes

    @cached_property
    def certificate(self) -> Certificate:
        """The certificate: docs/certificate-subgroups.md."""
        from fairaudit.audits.subgroup_document import certificate_of

        return certificate_of(self)

    @answered
    def save(self, path: str | os.PathLike[str]) -> list[Path]:
        """Write the certificate, and beside it the table if that is large."""
        return self.certificate.save(path)

    @property
    def exit_code(self) -> int:
        """0 within or no target, 1 exceeded, 3 inconclusive."""
        return exit_code(self.verdict, [self.verdict])

    @property
    def sentence(self) -> str:
        """Who fares most unequally, in a sentence."""
        first = self.found[0]
        if first.ratio == 1:
            return f"No subgroup of at least {self.least_rows:,} rows differs from the rest."
        words = words_for(burden=self.burden)
        who = f"{place(first.conditions)} ({first.rows:,} of {self.rows:,} rows)"
        more, less = (first.mean, first.rest) if first.side == "more" else (first.rest, first.mean)
        amounts = f"{words.amount} {approximate(first.mean)} against {approximate(first.rest)} for everybody else"
        compared = "which is nothing against something" if less == 0 else f"a ratio of {approximate(more / less)}"
        return f"The most unequal subgroup is {who}: {amounts}, {compared}."

    def to_frame(self) -> pd.DataFrame:
        """Tabulate what was found: one row per subgroup, the most unequal first."""
        import pandas as pd

        records = [
            {
                "subgroup": place(one.conditions),
                "rows": one.rows,
                "mean": one.mean,
                "rest": one.rest,
                "ratio": one.ratio,
                "side": one.side,
                **({} if one.interval is None else {"lower": one.interval[0], "upper": one.interval[1]}),
            }
            for one in self.found
        ]
        return pd.DataFrame.from_records(records)


@answered
def subgroups(
    source: Source,
    *,
    decision: str | None = None,
    attributes: str | Sequence[str],
    utility: Utility | Values | str | None = None,
    utility_column: str | None = None,
    depth: int = 3,
    min_share: Number | None = None,
    min_rows: int | None = None,
    max_ratio: Number | None = None,
    confidence: Number | None = DEFAULT_CONFIDENCE,
    top: int = 10,
    count: str | None = None,
    bins: Mapping[str, Sequence[Number] | Bins] | None = None,
    missing: Missing = "error",
    fold_labels: bool = False,
    label_map: LabelMap | str | os.PathLike[str] | None = None,
    burden: bool = False,
    embed_table: bool | None = None,
    engine: Engine = "auto",
    table: str | None = None,
    query: str | None = None,
    memory: str | None = None,
    encoding: str | None = None,
    decimal: str | None = None,
    thousands: str | None = None,
    number_sign: str | Sequence[str] = (),
) -> Subgroups:
    """Find the subgroups of a log that fare most unequally beside everybody else, and prove that none is worse.

    A subgroup is a conjunction of 1 to `depth` conditions attribute = value with enough rows; so does `fairaudit subgroups`. Source: T18.

    Parameters
    ----------
    source : path, paths, URL, frame or mapping
        A log with one decision per row, or with counts.
    decision : str
        Column of what was decided; with `utility_column` it may be left out.
    attributes : str or sequence of str
        Columns whose values subgroups share.
    utility, utility_column, count, bins, missing, fold_labels, label_map, engine, table, query, memory, encoding, decimal, thousands,
    number_sign
        As for `audit`.
    depth : int
        How many conditions a subgroup has at most.
    min_share : number, optional
        The least share of all rows that a subgroup has, such as 0.01; 0.01 if `min_rows` is not given either.
    min_rows : int, optional
        The least number of rows of a subgroup.
    max_ratio : number, optional
        Limit on the ratio of a subgroup's mean and that of the rest, either way round: 5/4, or 0.8 (least over greatest).
    confidence : number or None
        Of intervals that hold for all conjunctions at once, and of the verdict on the population; None judges the log itself.
    top : int
        How many subgroups to list; those with the same rows count once.
    burden : bool
        Whether the utility counts a burden.
    embed_table : bool, optional
        Whether the certificate holds the table; by default if it has at most 100,000 entries.

    Returns
    -------
    Subgroups
        The most unequal ones, the verdict and the certificate.

    Raises
    ------
    InputError
        If the log cannot be read, a number is not acceptable, or no subgroup has as many rows.

    Examples
    --------
    >>> log = {"region": ["n", "n", "s", "s"] * 2, "sex": ["f", "m"] * 4, "hired": ["yes"] * 4 + ["no"] * 4, "n": [2, 6, 7, 3, 8, 4, 3, 7]}
    >>> found = subgroups(log, decision="hired", attributes=["sex", "region"], utility="yes", count="n", min_rows=10)
    >>> found.found[0].conditions, found.ratio
    ({'sex': 'f', 'region': 'n'}, Fraction(8, 3))
    """
    if decision is None and utility_column is None:
        raise InputError("no decision column was named; give decision, the name of the column")
    refuse_two_utilities(utility, utility_column)
    reading = Reading(
        decision=decision or utility_column or "",
        group=names(attributes),
        bins=bins or {},
        count=count,
        utility_column=utility_column,
        missing=missing,
        fold_labels=fold_labels,
        label_map=read_label_map(Path(label_map)) if isinstance(label_map, (str, os.PathLike)) else label_map,
        access=Access(
            engine, table, query, memory, evaluations=False, encoding=encoding, form=number_form(decimal, thousands, number_sign)
        ),
    )
    values = utility_values(utility) if isinstance(utility, str) else utility
    given = Utility(values) if isinstance(values, Mapping) else values
    return find_subgroups(
        source,
        reading,
        given,
        depth=depth,
        min_share=min_share,
        min_rows=min_rows,
        max_ratio=max_ratio,
        confidence=confidence,
        top=top,
        burden=burden,
        embed_table=embed_table,
    )


def find_subgroups(
    source: Source,
    reading: Reading,
    utility: Utility | None,
    *,
    depth: int,
    min_share: Number | None,
    min_rows: int | None,
    max_ratio: Number | None,
    confidence: Number | None,
    top: int,
    burden: bool = False,
    embed_table: bool | None = None,
    report: Report | None = None,
) -> Subgroups:
    """Do what `subgroups` says for a log that is read in a given way."""
    limit = None if max_ratio is None else read_limit("max_ratio", max_ratio)
    level = None if confidence is None else confidence_level(confidence)
    for name, number in (("depth", depth), ("top", top)):
        if isinstance(number, bool) or not isinstance(number, int) or number < 1:
            raise InputError(f"{name} {shown(number)} is not a whole number of at least 1")
    if min_share is not None and min_rows is not None:
        raise InputError(f"{reading.spelled('min_share')} and {reading.spelled('min_rows')} do not go together; give one")
    share = None if min_rows is not None else _share("0.01" if min_share is None else min_share)
    with uncollected():
        log = read_subgroup_log(source, reading, utility, report=report)
        rows = log.table.measured
        least = ceil(share * rows.rows) if share is not None else min_rows
        if isinstance(least, bool) or not isinstance(least, int) or least < 1:
            raise InputError(f"min_rows {shown(least)} is not a whole number of at least 1")
        worst = most_unequal(rows, depth, least, top, report)
        if not worst.found:
            raise InputError(
                f"no conjunction of attribute values has at least {least:,} rows and not all {rows.rows:,}; ask for fewer rows, or name "
                "other attributes"
            )
    made = Subgroups(
        found=(),
        depth=depth,
        least_rows=least,
        share=share,
        conjunctions=conjunctions(rows.sizes, depth),
        confidence=level,
        limit=limit,
        verdict="none",
        log=log,
        worst=worst,
        burden=burden,
        embed=embed_table,
    )
    listed = tuple(_subgroup(made, one) for one in worst.found)
    return _judged(replace(made, found=listed))


def _share(given: Number) -> Fraction:
    try:
        share = Fraction(*option_value(given))
    except InputError as error:
        raise InputError(f"min_share: {error}") from None
    if not 0 < share < 1:
        raise InputError(f"min_share {shown(given)} is not a share between 0 and 1, such as 0.01")
    return share


def _subgroup(made: Subgroups, one: Found) -> Subgroup:
    table, rows = made.log.table, made.log.table.measured
    ends, rest = (None, None) if made.confidence is None else _both_ends(made, one.rows, one.total)
    return Subgroup(
        conditions=table.labels(one.conditions),
        rows=one.rows,
        mean=Fraction(one.total, table.scale * one.rows),
        rest=Fraction(rows.total - one.total, table.scale * (rows.rows - one.rows)),
        ratio=one.ratio,
        side=one.side,
        same=tuple(table.labels(other) for other in one.same),
        ends=ends,
        rest_ends=rest,
    )


def _both_ends(made: Subgroups, n: int, total: int) -> tuple[Ends, Ends]:
    rows, scale = made.log.table.measured, made.log.table.scale
    cells = [
        Cell(draws, Fraction(gains, scale), None, Fraction(0), Fraction(rows.values[-1], scale), set(rows.values) <= {0, rows.values[-1]})
        for draws, gains in ((n, total), (rows.rows - n, rows.total - total))
    ]
    return both_ends(cells[0], cells[1], made.confidence or Fraction(0), made.conjunctions)


def _judged(made: Subgroups) -> Subgroups:
    """With the verdict on the target: of the log, or of the population."""
    limit = made.limit
    if limit is None:
        return made
    if made.confidence is None:
        return replace(made, verdict="within" if made.ratio <= limit else "exceeds")
    if any(one.interval is not None and one.interval[0] > limit for one in made.found):
        return replace(made, verdict="exceeds")
    everybody = _everybody_within(made, limit)
    return replace(made, verdict="within" if everybody else "inconclusive", everybody=everybody)


def _everybody_within(made: Subgroups, limit: Fraction) -> tuple[tuple[tuple[tuple[int, int], ...], Ends, Ends], ...]:
    """Both ends of each conjunction of the family, if they prove of all of them that the limit is kept; else nothing."""
    if any(one.interval is None or one.interval[1] > limit for one in made.found):
        return ()
    listed = every_conjunction(made.log.table.measured, made.depth, made.least_rows, MOST_LISTED)
    if listed is None:
        return ()
    found = []
    for conditions, n, total in listed:
        ends, rest = _both_ends(made, n, total)
        if ratio_ends(ends, rest)[1] > limit:
            return ()
        found.append((conditions, ends, rest))
    return tuple(sorted(found, key=lambda entry: (len(entry[0]), entry[0])))
