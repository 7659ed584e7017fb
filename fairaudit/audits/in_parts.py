"""Audits of logs whose cells do not fit into memory: contexts pass by some at a time, and only what is needed of them is kept."""

from __future__ import annotations

import tempfile
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import closing, contextmanager
from dataclasses import replace
from fractions import Fraction
from typing import IO, Any, TypeVar

import numpy as np
from numpy.typing import NDArray

from fairaudit.audits.population import DISCLOSED, possible_comparisons, ratio_intervals
from fairaudit.audits.result import Partial, Result, not_compared, pair_key
from fairaudit.audits.sentences import Sizes, sizes
from fairaudit.audits.targets import judged
from fairaudit.certificates.certificate import new_salt
from fairaudit.certificates.table import Table, WrittenTable, column_names, count_lines, log_digests
from fairaudit.errors import InputError, shown
from fairaudit.exact.rationals import Number
from fairaudit.inference.comparisons import Comparison
from fairaudit.inference.ends import Method
from fairaudit.inference.interval import Interval
from fairaudit.inference.levels import confidence_level
from fairaudit.measures.distances import Distance, demographic_parity, most_unequal_distances
from fairaudit.measures.expectations import least_expectation
from fairaudit.measures.limits import MEASURED, Limit, Quantity, limits_of, without_bare_limits
from fairaudit.measures.ratios import Ratio, global_fairness, global_supremum, local_supremum, most_unequal_ratios
from fairaudit.model.law import Law
from fairaudit.model.layout import Columns
from fairaudit.model.utility import Utility, UtilityTable, Values
from fairaudit.tables.binning import Bins
from fairaudit.tables.columns import MISSING_LABEL, read_columns
from fairaudit.tables.engines.logs import cut_columns, read_parts
from fairaudit.tables.engines.request import PartsMissing, Report
from fairaudit.tables.preparation import in_order, undisclosed, words
from fairaudit.tables.sources import Source
from fairaudit.tables.tally import Tally
from fairaudit.tables.values import distinct, names

__all__ = ["certify_in_parts"]


MOST_CELLS = 2_000_000
"""Of how many cells the draws are held for an interval: some gigabyte, while it is found."""

T = TypeVar("T", Ratio, Distance)


@without_bare_limits(MEASURED)
def certify_in_parts(
    source: Source,
    utility: Utility | Values,
    *,
    decision: str,
    group: str | Sequence[str],
    context: str | Sequence[str],
    bins: Mapping[str, Sequence[Number] | Bins] | None = None,
    table: str | None = None,
    memory: str | None = None,
    report: Report | None = None,
    max_local_ratio: Number | None = None,
    max_global_ratio: Number | None = None,
    max_local_log: Number | None = None,
    max_global_log: Number | None = None,
    confidence: Number | None = None,
    interval: Method | None = None,
    independent: bool = False,
    top: int = 3,
    embed_table: bool | None = None,
    burden: bool = False,
    count: str | None = None,
    missing: PartsMissing = "error",
) -> Result:
    """Certify a log of very many contexts: the certificate of `fairaudit.certify`.

    DuckDB counts the log and sorts it by context, on disk where memory does not suffice; some contexts at a time are measured, written to
    the table, and forgotten. Labels of contexts stay in memory. A global figure is that of the law over all contexts together, because
    P(u|a) and the mean of g over it do not depend on where the rows of a group come from. For an interval of the
    local ratio is kept how often each utility was drawn in each cell that is compared; of more than two million cells none is claimed.

    Parameters
    ----------
    source, bins, table, memory, report, count, missing
        As for `fairaudit.tables.engines.logs.read_parts`: Parquet files, or a table of a DuckDB database.
    utility : Utility or mapping
        g, which depends on the decision alone.
    decision, group, context
        As for `Law.from_log`; at least one context column.
    max_local_ratio, max_global_ratio, max_local_log, max_global_log, confidence, interval, independent, embed_table, burden
        As for `fairaudit.certify`; the confidence is None by default.
    top : int
        How many of the most unequal pairs to keep.

    Returns
    -------
    Result
        Its `law` is that over all contexts together; the certificate's table is in a temporary file.

    Raises
    ------
    InputError
        If the log cannot be read in parts, a label is missing, or nothing can be compared.

    Examples
    --------
    >>> import duckdb, tempfile
    >>> path = tempfile.mkdtemp() + "/log.parquet"
    >>> rows = "(values ('a', 'f', 'yes'), ('a', 'm', 'yes'), ('a', 'm', 'no'), ('b', 'f', 'no')) log(shop, sex, hired)"
    >>> _ = duckdb.execute(f"copy (from {rows}) to '{path}' (format parquet)")
    >>> result = certify_in_parts(path, {"yes": 1}, decision="hired", group="sex", context="shop")
    >>> result.local.ratio, result.local.witness.context
    (Fraction(2, 1), {'shop': 'a'})
    """
    columns = Columns(decision, names(group), names(context))
    wanted = (decision, *columns.group, *columns.context)
    for name in (used := (*wanted, *names(count))):
        if used.count(name) > 1:
            raise InputError(f"the column {shown(name)} is used twice; each column has one role")
    if top < 1:
        raise InputError(f"{top} most unequal pairs cannot be kept; ask for at least 1")
    limits = limits_of(
        {
            "max_local_ratio": max_local_ratio,
            "max_global_ratio": max_global_ratio,
            "max_local_log": max_local_log,
            "max_global_log": max_global_log,
        }
    )
    cut = {name: edges if isinstance(edges, Bins) else Bins.of(name, edges) for name, edges in (bins or {}).items()}
    level = None if confidence is None else confidence_level(confidence)
    _refuse_asked(level, interval, independent, judged=bool(limits), embed=embed_table)
    drawn = _Drawn()
    supremum: Ratio | None = None
    odds: tuple[Distance, ...] = ()
    pairs: tuple[Ratio, ...] = ()
    recorded: dict[tuple[str, ...], Sizes] = {}
    floors, left_out, contexts = [], [], list[tuple[str, ...]]()
    access: dict[str, Any] = {"table": table, "memory": memory, "report": report, "count": count, "missing": missing}
    opened = read_parts(source, wanted, columns.context, bins=cut, group=columns.group, **access)
    with closing(opened) as parts, _written() as rows:
        first = next(parts)
        whole = Law.from_log(first, decision=decision, group=columns.group, missing=missing)
        if count is not None:
            whole = replace(whole, rows_read=None)  # which are fewer than the decisions that they stand for
        worth = utility if isinstance(utility, Utility) else Utility(utility)
        g = worth.on(whole)
        if not g.by_decision:
            raise InputError(
                "the utility depends on more than the decision; contexts that are read in parts need one of the decision alone"
            )
        whole = g.law
        cells = read = 0
        for tally in parts:
            law = _part(tally, columns, whole, missing)
            if contexts and contexts[-1] >= law.contexts[0]:
                raise InputError(f"the contexts {contexts[-1]} and {law.contexts[0]} do not come in the order of their texts")
            left_out += [entry for entry in not_compared(law) if "context" in entry]
            at = len(contexts)
            contexts += law.contexts
            if not len(law.weights):
                continue
            table_of = replace(g, law=law)
            found = local_supremum(law)
            supremum = found if supremum is None or (found is not None and found.ratio > supremum.ratio) else supremum
            ranked = most_unequal_ratios(law, table_of, top, within_context=True)
            pairs = _foremost((*pairs, *ranked), top, lambda ratio: ratio.ratio - 1)
            found_sizes = zip(ranked, sizes(law, [ratio.witness for ratio in ranked]), strict=True)
            recorded |= {pair_key(ratio.witness): size for ratio, size in found_sizes if size is not None}
            recorded = {key: recorded[key] for key in (pair_key(ratio.witness) for ratio in pairs)}
            odds = _foremost((*odds, *most_unequal_distances(law, top, within_context=True)), top, lambda distance: distance.value)
            floors.append(least_expectation(law, table_of))
            rows.writelines(count_lines(law, at))
            if level is not None:
                drawn.add(law, g, at)
            cells += law.weights.size
            read += int(law.weights.sum())
        if read != int(whole.weights.sum()):
            raise InputError("the parts of the log do not add up to all of its rows")
        local, overall = pairs[0] if pairs else None, global_fairness(whole, g)
        if local is None and overall is None:
            raise InputError("no two groups can be compared: no context has two groups, and no two groups have a population")
    measured: dict[Quantity, Ratio | None] = {"local": local, "global": overall}
    prepared = in_order((*cut_columns(cut), *first.preparation), wanted, dict.fromkeys(wanted, (MISSING_LABEL,)))
    whole = replace(whole, preparation=prepared)
    asked: dict[str, Any] = {"level": level, "limits": limits, "embed": embed_table, "method": interval, "independent": independent}
    comparisons, intervals, said = _of_population(worth, replace(g, law=whole), measured, drawn, (columns, contexts), **asked)
    targets, verdict = judged(measured, limits, level, intervals)
    absent = [words(entry) for entry in first.preparation if entry["step"] in ("left out", "level")]
    left_out.sort(key=lambda entry: "groups" not in entry)
    listed = [undisclosed(entry) if embed_table is False else dict(entry) for entry in prepared]
    log = log_digests({"preparation": listed} if listed else {})
    header = {**Table(whole, g, log=log).header, "columns": column_names(columns), "contexts": [list(label) for label in contexts]}
    if embed_table is False:
        header["salt"] = new_salt()
    return Result(
        law=whole,
        utility=g,
        local=local,
        global_=overall,
        demographic_parity=demographic_parity(whole),
        equalized_odds=odds[0] if odds else None,
        local_supremum=supremum,
        global_supremum=global_supremum(whole),
        tau=min((floor for floor in floors if floor is not None), default=None),
        not_compared=(*left_out, *(entry for entry in not_compared(whole) if "context" not in entry)),
        targets=targets,
        verdict=verdict,
        notes=(*dict.fromkeys((*absent, *whole.notes)), *said),
        intervals=intervals,
        comparisons=comparisons,
        method=interval,
        embed=embed_table,
        partial=Partial(columns, pairs, odds, WrittenTable(header, rows, cells), recorded),
        burden=burden,
    )


class _Drawn:
    """How often each utility was drawn in the cells that are compared, of some contexts at a time, until there are too many of them."""

    def __init__(self) -> None:
        self.cells = 0
        self.parts: list[tuple[NDArray[np.int64], NDArray[np.int64], NDArray[np.int64]]] = []

    def add(self, law: Law, utility: UtilityTable, first: int) -> None:
        """Keep the draws of some contexts, of which this is the number of the first."""
        at = np.flatnonzero(law.compared)
        self.cells += len(at)
        if self.cells > MOST_CELLS:
            self.parts.clear()
            return
        kept = law.weights[at]
        weights = np.stack([kept[:, utility.values == value].sum(axis=1) for value in np.unique(utility.values)], axis=1)
        self.parts.append((law.cell_context[at] + first, law.cell_group[at], weights))

    def laid_out(self, utility: UtilityTable, columns: Columns, contexts: Sequence[tuple[str, ...]]) -> UtilityTable | None:
        """The utility on a law of the cells that are compared, in which decisions that are worth the same are one; None of too many."""
        if self.cells > MOST_CELLS or not self.parts:
            return None
        whole = utility.law
        values, places = np.unique(utility.values, return_index=True)
        context, group, weights = (np.concatenate(part) for part in zip(*self.parts, strict=True))
        decisions = tuple(whole.decisions[place] for place in places.tolist())
        held: dict[str, Any] = {"cell_context": context, "cell_group": group, "weights": weights}
        law = replace(whole, columns=columns, decisions=decisions, contexts=tuple(contexts), **held)
        return replace(utility, law=law, values=values)


def _refuse_asked(level: Fraction | None, interval: Method | None, independent: bool, *, judged: bool, embed: bool | None) -> None:
    """Refuse what is about a population where none is asked about, and targets on one whose interval would disclose the counts."""
    if level is None and (interval is not None or independent):
        raise InputError("interval and independent (--interval, --independent-cells) are about the population; give a confidence")
    if level is not None and judged and embed is False:
        raise InputError(f"{DISCLOSED}; confidence none (--confidence none) judges the table itself")


def _of_population(
    utility: Utility,
    table: UtilityTable,
    measured: Mapping[Quantity, Ratio | None],
    drawn: _Drawn,
    labels: tuple[Columns, Sequence[tuple[str, ...]]],
    *,
    level: Fraction | None,
    limits: Sequence[Limit],
    embed: bool | None,
    method: Method | None,
    independent: bool,
) -> tuple[Mapping[Quantity, Comparison], Mapping[Quantity, Interval], tuple[str, ...]]:
    """What the draws say of the population, once all contexts have passed by."""
    if level is None:
        return {}, {}, ()
    compared, within, said = dict(measured), drawn.laid_out(table, *labels), list[str]()
    if within is None and compared.pop("local") is not None:
        said.append(
            f"no interval for the local ratio is claimed: it needs the draws of {drawn.cells:,} cells; of {MOST_CELLS:,} they are held"
        )
    named = {quantity for quantity, _, _ in limits}
    found, reasons = possible_comparisons(table.law, utility, table, compared, {}, named, embed, within=within)
    judging = sum(quantity in found for quantity, _, _ in limits)
    intervals, notes = ratio_intervals(found, measured, level, judging, named, method=method, independent=independent)
    return found, intervals, (*said, *reasons, *notes)


def _part(tally: Tally, columns: Columns, whole: Law, missing: PartsMissing) -> Law:
    """The law of some contexts, over the decisions and groups of the whole log."""
    coded = read_columns(tally, columns.decision, columns.group, columns.context, [], missing, ordered=True)
    u, x, a = coded.codes
    decision_of = np.array([whole.decisions.index(label) for label in coded.decisions])
    place_of = {label: place for place, label in enumerate(whole.groups)}
    group_of = np.array([place_of[label] for label in coded.groups])
    cells, cell = distinct(x * len(whole.groups) + group_of[a])
    weights = np.zeros((len(cells), len(whole.decisions)), dtype=np.int64)
    np.add.at(weights, (cell, decision_of[u]), coded.counts)
    full = weights.any(axis=1)
    return Law(
        columns=columns,
        decisions=whole.decisions,
        groups=whole.groups,
        contexts=tuple(coded.contexts),
        kind="counts",
        population="counts",
        cell_context=cells[full] // len(whole.groups),
        cell_group=cells[full] % len(whole.groups),
        weights=weights[full],
    )


def _foremost(measures: Sequence[T], count: int, size: Callable[[T], Any]) -> tuple[T, ...]:
    """The greatest measures, the first of equal ones before the others; those of size 0 only if nothing else is there."""
    unequal = sorted((measure for measure in measures if size(measure)), key=lambda measure: -size(measure))
    return tuple(unequal[:count] or measures[:1])


@contextmanager
def _written() -> Iterator[IO[bytes]]:
    """A temporary file that has no name, so that nothing is left of it however the process ends; closed if the work fails."""
    try:
        file = tempfile.TemporaryFile()  # noqa: SIM115
        try:
            yield file
            file.flush()
        except BaseException:
            file.close()
            raise
    except OSError as error:
        raise InputError(f"the table cannot be written to the directory for temporary files: {error.strerror or error}") from None
