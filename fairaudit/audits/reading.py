"""A table read as a law: which column has which role, what is done to labels and numbers first, and which reader fits."""

from __future__ import annotations

import os
from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from fairaudit.errors import InputError, naming, shown
from fairaudit.exact.rationals import Number
from fairaudit.model.law import Law
from fairaudit.model.utility import Utility
from fairaudit.tables.arriving import as_table, is_frame, unreadable
from fairaudit.tables.columns import LabelledRows, Missing, read_labels
from fairaudit.tables.csv import SMALL, CsvTable, decimal_commas, read_csv
from fairaudit.tables.evaluations.extraction import NOTHING_ASKED, Extraction
from fairaudit.tables.labels import LabelMap, PreparedTable, merge_labels, spelt_alike
from fairaudit.tables.number_form import PLAIN, NumberForm, NumberKind, plain_numbers
from fairaudit.tables.sources import SameContent, Source, is_database
from fairaudit.tables.tally import Tally, relabelled
from fairaudit.tables.values import column, locator
from fairaudit.tables.wide import LongTable, Wide, lengthened

if TYPE_CHECKING:
    from fairaudit.tables.binning import Bins
    from fairaudit.tables.engines.logs import Engine
    from fairaudit.tables.engines.request import Report
    from fairaudit.tables.scores import Cut


__all__ = [
    "MOST_ROWS",
    "Access",
    "Reading",
    "read_audited",
    "read_law",
    "read_rows",
    "read_table",
    "read_table_of",
    "read_text_table",
    "unfit_for_parts",
]

MOST_ROWS = 20_000_000
"""How many different rows of a log are held; more of them pass by some contexts at a time. They take about two gigabytes."""


@dataclass(frozen=True)
class Access:
    """How a table is reached.

    Attributes
    ----------
    engine : {"auto", "duckdb", "python", "spark"} or SparkSession
        Who reads files.
    table, query : str or None
        Of a database: the table, or a query whose result is the table. Of a spreadsheet: the sheet.
    memory : str or None
        What DuckDB may use before it spills to disk.
    skip : int
        How many lines stand above the header of a text or a spreadsheet.
    same_content : {"refuse", "accept"}
        What becomes of several files with the same content.
    extraction : Extraction
        What is asked of an evaluation log beyond columns.
    evaluations : bool
        Whether evaluation logs are read; else they are refused.
    encoding : str or None
        How the characters of a text are written, where that is not UTF-8.
    form : NumberForm
        How the texts of numbers are written.
    """

    engine: Engine = "auto"
    table: str | None = None
    query: str | None = None
    memory: str | None = None
    skip: int = 0
    extraction: Extraction = NOTHING_ASKED
    evaluations: bool = True
    same_content: SameContent = "refuse"
    encoding: str | None = None
    form: NumberForm = PLAIN


@dataclass(frozen=True)
class Reading:
    """How a table is read as a law.

    Attributes
    ----------
    decision : str
        Column of what was decided.
    group, context : tuple of str
        Columns of the sensitive attributes and of the contexts.
    bins : mapping of str to sequence of number
        Edges of those that are cut into intervals.
    truth : str or None
        Column of the true label.
    count, probability, weight : str or None
        Column of how often the row occurred; of P(decision | context, group), and with it of P(context, group).
    unit : tuple of str
        Of a log, columns of the sampling unit.
    utility_column : str or None
        Column of what the decision of the row is worth.
    missing : {"error", "drop", "group", "unknown", "undecided"}
        What an empty label means.
    unknown : tuple of str
        Labels of group columns that name no group.
    fold_labels : bool
        Whether labels that differ in spelling alone are merged.
    label_map : mapping or None
        For columns the new labels of old ones.
    access : Access
        How the table is reached.
    spelled : callable
        How the one who asks writes the name of an option, for messages.
    signed : bool
        Whether utilities may be negative.
    wide : Wide or None
        Which columns hold counts or shares of decisions, where rows have several.
    above : Fraction, "median" or None
        The decision column holds scores, and the decision is whether one is above this.
    """

    decision: str
    group: tuple[str, ...]
    context: tuple[str, ...] = ()
    bins: Mapping[str, Sequence[Number] | Bins] = field(default_factory=dict)
    truth: str | None = None
    count: str | None = None
    probability: str | None = None
    weight: str | None = None
    unit: tuple[str, ...] = ()
    utility_column: str | None = None
    missing: Missing = "error"
    unknown: tuple[str, ...] = ()
    fold_labels: bool = False
    label_map: LabelMap | None = None
    access: Access = Access()
    spelled: Callable[[str], str] = str
    signed: bool = False
    wide: Wide | None = None
    above: Cut | None = None

    @property
    def labelled(self) -> tuple[str, ...]:
        """Columns whose labels may be merged; labels of sampling units are names of draws and are not."""
        return (self.decision, *self.beside)

    @property
    def beside(self) -> tuple[str, ...]:
        """The same without the decision."""
        return (*self.group, *self.context, *([] if self.truth is None else [self.truth]))

    @property
    def numeric(self) -> tuple[str, ...]:
        """Columns of numbers."""
        return tuple(name for name in (self.count, self.probability, self.weight) if name is not None)

    @property
    def numbers(self) -> dict[str, NumberKind]:
        """Columns of numbers, and what they are."""
        whole = () if self.wide is None else self.wide.columns
        share: NumberKind = "amount" if self.wide is None or self.wide.of is None else "share"
        found: dict[str, NumberKind] = {name: "share" if name == self.probability else "amount" for name in self.numeric}
        found |= dict.fromkeys(whole, share)
        return found | {
            name: "label" for name in (self.utility_column, self.decision if self.above is not None else None) if name is not None
        }

    def check(self) -> None:
        """Refuse roles that do not go together.

        Raises
        ------
        InputError
            If there are such.
        """
        spelled = self.spelled
        self._check_scores()
        if self.utility_column is not None and self.utility_column in (*self.group, *self.context, *self.numeric):
            raise InputError(f"the column {shown(self.utility_column)} is used twice; each column has one role")
        if self.count is not None and self.probability is not None:
            raise InputError(f"{spelled('count')} and {spelled('probability')} do not go together; give one, or neither for a log")
        if self.truth is not None and self.probability is not None:
            raise InputError(f"{spelled('truth')} goes with counts and logs; probabilities do not say what should have been decided")
        if self.unit and (self.count or self.probability):
            raise InputError(
                f"{spelled('unit')} goes with a log, which has one decision per row; counts do not say which rows belong together"
            )
        if self.unknown or self.missing == "unknown":
            what = spelled("unknown") if self.unknown else f"{spelled('missing')} unknown"
            if self.probability is not None:
                raise InputError(f"{what} goes with counts and logs; probabilities do not say how many decisions have no group")
            for name, given in (("unit", self.unit), ("truth", self.truth)):
                if given:
                    raise InputError(f"{what} does not go with {spelled(name)}; leave one of them out")
        self._check_form()
        shares = self.wide is not None and self.wide.of is not None
        if self.wide is not None:
            others = ("count", "probability", "utility_column", "truth", "unit", *(["unknown"] if shares else []))
            for name in others:
                if getattr(self, name):
                    raise InputError(
                        f"{spelled('wide')} does not go with {spelled(name)}: its columns say how often each decision was taken"
                    )
            if shares and self.missing == "unknown":
                raise InputError(
                    f"{spelled('missing')} unknown goes with counts and logs; shares do not say how many decisions have no group"
                )
        if self.weight is not None and self.probability is None and not shares:
            raise InputError(f"{spelled('weight')} goes with {spelled('probability')}; counts and logs carry their own population")

    def _check_form(self) -> None:
        form, spelled = self.access.form, self.spelled
        if self.bins and form.point == ",":
            raise InputError(
                f"intervals such as {next(iter(self.bins))}:… are cut from numbers with a decimal point, not a comma; "
                "put labels of intervals into the column instead"
            )
        if self.wide is not None and "%" in form.signs:
            raise InputError(f"{spelled('wide')} reads percentages with {spelled('total')} 100, without {spelled('number_sign')} %")

    def _check_scores(self) -> None:
        if self.above is None:
            return
        for name in ("probability", "wide", "utility_column"):
            if getattr(self, name):
                raise InputError(f"{self.spelled('score')} goes with counts and logs, and does not go with {self.spelled(name)}")
        if self.decision in (*self.beside, *self.unit, *self.numeric):
            raise InputError(f"the column {shown(self.decision)} is used twice; each column has one role")
        if self.label_map and self.decision in self.label_map:
            raise InputError(f"the map has a column {shown(self.decision)}, which is that of the scores; these are numbers, not labels")


def refuse_two_utilities(utility: object, column: str | None) -> None:
    """Refuse a utility of decisions beside the column that says it of each row."""
    if utility is not None and column is not None:
        raise InputError("utility and utility_column do not go together; give one of them")


def refuse_half_a_score(score: str | None, above: object, decision: str | None, spelled: Callable[[str], str] = str) -> None:
    """Refuse a column of scores without what one has to be above, the other way round, and a decision beside it."""
    if score is not None and decision is not None:
        raise InputError(f"{spelled('score')} and {spelled('decision')} do not go together; the decision is whether a score is above")
    if (score is None) != (above is None):
        given, other = ("score", "above") if above is None else ("above", "score")
        raise InputError(
            f"{spelled(given)} goes with {spelled(other)}: a column of scores, and what one has to be above, its median or a number"
        )


def read_law(source: Source, reading: Reading, *, report: Report | None = None) -> Law:
    """Read a table as a law.

    Parameters
    ----------
    source : Source
        The table.
    reading : Reading
        What its columns are.
    report : callable, optional
        As for `read_log`.

    Raises
    ------
    InputError
        If the table cannot be read, or its columns do not fit their roles.
    """
    table = _prepared(source, reading, report, None)
    with naming(_name(table)):
        return _law(table, reading)


def read_audited(
    source: Source, reading: Reading, utility: Utility | None, *, report: Report | None = None, most: int | None = None
) -> tuple[Law, Utility]:
    """Read a table as a law, and the utility if a column holds it; else it is the one that was given, which must fit the law.

    Parameters
    ----------
    source : Source
        The table.
    reading : Reading
        What its columns are.
    utility : Utility or None
        What decisions are worth, where no column says it.
    report, most
        As for `read_log`.

    Raises
    ------
    InputError
        As `read_law`, and if there is no utility, or it does not fit.
    ManyRowsError
        If a log has more different rows than `most` and can be read in parts.
    """
    return read_table_of(source, reading, utility, report=report, most=most)[1:]


def read_table_of(
    source: Source, reading: Reading, utility: Utility | None, *, report: Report | None = None, most: int | None = None
) -> tuple[Any, Law, Utility]:
    """Read a table as `read_audited` does, and give its columns, too."""
    table = _prepared(source, reading, report, most)
    with naming(_name(table)):
        law = _law(table, reading)
        if reading.utility_column is not None:
            columns: dict[str, Any] = {"decision": reading.decision, "group": reading.group, "context": reading.context}
            utility = Utility.from_table(table, utility=reading.utility_column, **columns, missing=reading.missing, signed=reading.signed)
        if utility is None:
            raise InputError(f"no utility was given; give {reading.spelled('utility')} or {reading.spelled('utility_column')}")
        utility = folded_utility(utility, law.decisions) if reading.fold_labels else utility
        utility.on(law)
        return table, law, utility


def folded_utility(utility: Utility, decisions: Sequence[str]) -> Utility:
    """Write the decisions of a utility as those of a table whose labels were merged are written.

    Raises
    ------
    InputError
        If two of them are one decision then.

    Examples
    --------
    >>> folded_utility(Utility({"YES": 1, "maybe": "0.5"}), ["yes", "no"]).values
    {'yes': Fraction(1, 1), 'maybe': Fraction(1, 2)}
    """
    if utility.entries is not None:
        return utility
    written: dict[str, str] = {}
    for label in utility.values:
        (name,) = [label] if label in decisions else spelt_alike({"u": list(decisions)}, ["u"], [label])
        if name in written:
            raise InputError(f"the utility names the decision {shown(name)} twice, as {shown(written[name])} and {shown(label)}")
        written[name] = label
    return replace(utility, values={name: utility.values[label] for name, label in written.items()})


def read_rows(source: Source, reading: Reading, *, report: Report | None = None) -> LabelledRows:
    """Read the labels of a table's rows, each column by itself, with the numbers of count and utility columns as they stand.

    Parameters
    ----------
    source : Source
        The table.
    reading : Reading
        What its columns are.
    report : callable, optional
        As for `read_log`.

    Raises
    ------
    InputError
        As `read_law`.
    """
    from fairaudit.tables.frames import tally_frame

    table = _prepared(source, reading, report, None)
    others = [name for name in (reading.count, reading.utility_column) if name is not None and name not in reading.labelled]
    with naming(_name(table)):
        tally = None if reading.count is not None else tally_frame(table, [*reading.labelled, *others])
        read = read_labels(table if tally is None else tally, reading.labelled, others, reading.missing, count=reading.count)
    return replace(read, notes=(*getattr(table, "notes", ()), *read.notes))


def _prepared(source: Source, reading: Reading, report: Report | None, most: int | None) -> Any:
    """Read the columns that are wanted, labels merged."""
    reading.check()
    valued = [] if reading.utility_column is None else [reading.utility_column]
    truth = [] if reading.truth is None else [reading.truth]
    wanted = (reading.decision, *reading.group, *reading.context, *truth, *reading.unit, *reading.numeric, *valued)
    options: dict[str, Any] = {"spelled": reading.spelled, "report": report, "most": most, "by": reading.context}
    table: Any
    if reading.wide is not None:
        table = _long(source, reading, reading.wide, report)
        return table if not reading.fold_labels and reading.label_map is None else _merged(table, reading)
    plain = reading.count is not None or reading.probability is not None
    scored = [] if reading.above is None else [reading.decision]
    labelled = reading.decision if not scored and reading.decision != reading.utility_column else None
    roles: dict[str, Any] = {"decision": labelled, "group": reading.group, "unit": reading.unit, "count": reading.count}
    table = read_table(source, wanted, reading.bins, reading.numbers, reading.access, plain=plain, **options, **roles)
    if plain and isinstance(table, Tally) and table.evaluation is not None:
        name = reading.spelled("count" if reading.count is not None else "probability")
        raise InputError(f"{table.name}: {name} goes with a table of counts or probabilities; a sample of an evaluation log is one answer")
    if reading.fold_labels or reading.label_map is not None:
        table = _merged(table, reading)
    if isinstance(table, Tally):
        with naming(table.name):
            unknown = spelt_alike(table, reading.group, reading.unknown) if reading.fold_labels else reading.unknown
            from fairaudit.tables.evaluations.lost import settled

            table = settled(table, reading.decision, reading.context, reading.group, missing=reading.missing, unknown=unknown)
    if reading.above is None:
        return table
    with naming(_name(table)):
        from fairaudit.tables.scores import cut_scores

        return cut_scores(table, reading.decision, reading.above, others=reading.beside, missing=reading.missing, count=reading.count)


def _merged(table: Any, reading: Reading) -> Any:
    labelled = reading.labelled if reading.above is None else reading.beside
    with naming(_name(table)):
        return merge_labels(table, labelled, fold=reading.fold_labels, label_map=reading.label_map)


def _long(source: Source, reading: Reading, wide: Wide, report: Report | None) -> LongTable:
    """Read the columns of counts or shares, and make a row for each decision."""
    from fairaudit.tables.evaluations.lost import refuse_samples

    rows = (*(reading.group[1:] if wide.headers else reading.group), *reading.context)
    numeric = (*wide.columns, *([] if reading.weight is None else [reading.weight]))
    table = read_table(
        source, (*rows, *numeric), reading.bins, reading.numbers, reading.access, plain=True, spelled=reading.spelled, report=report
    )
    roles: dict[str, Any] = {"decision": reading.decision, "group": reading.group, "context": reading.context, "weight": reading.weight}
    with naming(_name(table)):
        if isinstance(table, Tally):
            refuse_samples(table)
        return lengthened(table, wide, **roles, spelled=reading.spelled)


def _name(table: object) -> str | None:
    """Name of what was read from a file or database."""
    return table.name if isinstance(table, (CsvTable, Tally, LongTable)) else None


def _law(table: Any, reading: Reading) -> Law:
    """Read columns as a law."""
    columns: dict[str, Any] = {
        "decision": reading.decision,
        "group": reading.group,
        "context": reading.context,
        "missing": reading.missing,
    }
    unknown = spelt_alike(table, reading.group, reading.unknown) if reading.fold_labels else reading.unknown
    count, probability = reading.count, reading.probability
    if reading.wide is not None:
        count, probability = (reading.wide.number, None) if reading.wide.of is None else (None, reading.wide.number)
    if count is not None:
        law = Law.from_counts(table, **columns, count=count, truth=reading.truth, unknown=unknown)
    elif probability is not None:
        law = Law.from_probabilities(table, **columns, probability=probability, weight=reading.weight)
    else:
        law = Law.from_log(table, **columns, unit=reading.unit, truth=reading.truth, unknown=unknown)
    return replace(law, notes=(*getattr(table, "notes", ()), *law.notes))


def read_table(
    source: Source,
    columns: Sequence[str],
    bins: Mapping[str, Sequence[Number] | Bins],
    numeric: Mapping[str, NumberKind],
    access: Access,
    *,
    plain: bool = False,
    spelled: Callable[[str], str] = str,
    report: Report | None = None,
    most: int | None = None,
    by: Sequence[str] = (),
    **roles: Any,
) -> Any:
    """Read a table: the counted rows of a log, or a table of counts or probabilities as it is.

    Parameters
    ----------
    source : Source
        The table.
    columns : sequence of str
        The columns that are wanted.
    bins : mapping of str to sequence of number
        Edges of columns that are cut into intervals.
    numeric : mapping of str to {"amount", "label", "share"}
        Columns of numbers, and what they are.
    access : Access
        How the table is reached.
    plain : bool
        Whether each row carries its own count or probability, so that small tables are taken as they are.
    spelled : callable
        How options are written, for messages.
    report, most, by
        As for `read_log`.
    **roles
        Of an evaluation log ``decision``, ``group`` and ``unit``, as for `read_log`; of counts ``count``.

    Returns
    -------
    CsvTable, Tally, PreparedTable or the table itself
        What `Law` and `Utility` take.

    Raises
    ------
    InputError
        If it cannot be read, or a column is not there.
    """
    source = as_table(source, columns)
    if isinstance(source, (list, tuple)) and len(source) == 1:
        source = source[0]
    if isinstance(source, CsvTable):
        found = source
    elif isinstance(source, (Tally, PreparedTable)) or _in_memory(source, plain=plain):
        with naming(_name(source)):
            return _with_numbers(_held(source, bins, access, plain=plain, spelled=spelled), numeric, access.form)
    elif not plain or not isinstance(source, (str, os.PathLike)) or access.skip or access.encoding or not _is_csv(os.fspath(source)):
        from fairaudit.tables.engines.logs import counted_log, log_request

        reached = ("table", "query", "memory", "skip", "extraction", "evaluations", "same_content", "encoding", "form")
        where = {name: getattr(access, name) for name in reached}
        request = log_request(
            columns, bins, **where, **roles, numeric=tuple(numeric), report=report, meanwhile=_warm, most=most, by=tuple(by)
        )
        tally = counted_log(source, request, access.engine)
        with naming(tally.name):
            return _with_numbers(tally, numeric, PLAIN if _typed(source) else access.form)
    else:
        found = read_text_table(source, columns, numeric, access, report, count=roles.get("count"))
    _refuse_what_logs_have(bins, access, spelled)
    try:
        for name in columns:
            column(dict.fromkeys(found.columns, ()), name)
        return found.with_numbers(numeric, access.form)
    except InputError as error:
        raise InputError(f"{found.name}: {error}") from None


def read_text_table(
    source: str | os.PathLike[str],
    columns: Sequence[str],
    numeric: Collection[str],
    access: Access = Access(),
    report: Report | None = None,
    *,
    count: str | None = None,
) -> CsvTable:
    """Read counts or probabilities in a delimited text row by row: a big one by an engine, where that reads it alike.

    Parameters
    ----------
    source : path
        The file.
    columns, numeric, access, report
        As for `read_table`.
    count : str, optional
        The column of counts.

    Raises
    ------
    InputError
        If it cannot be read, or a big one lacks a column.
    """
    path = os.fspath(source)
    if access.engine == "auto" and os.path.isfile(path) and Path(path).stat().st_size > SMALL:  # noqa: PTH113
        from fairaudit.tables.engines.logs import log_request
        from fairaudit.tables.engines.ordered import read_ordered

        request = log_request(columns, memory=access.memory, report=report, meanwhile=_warm, count=count)
        found = read_ordered(path, request, numeric)
        if found is not None:
            return found
    return read_csv(source)


def _refuse_what_logs_have(bins: Mapping[str, Any], access: Access, spelled: Callable[[str], str]) -> None:
    if bins:
        name, edges = next(iter(bins.items()))
        from fairaudit.tables.binning import Bins

        listed = edges.edges if isinstance(edges, Bins) else edges
        raise InputError(f"intervals such as {name}:{','.join(map(str, listed))} go with a log")
    if access.table is not None or access.query is not None:
        raise InputError(f"{spelled('table')} and {spelled('query')} go with a database")
    access.extraction.refuse("a table of counts or probabilities")


def _in_memory(source: Any, *, plain: bool) -> bool:
    """Whether a table is taken as it is: a mapping, or a frame in memory whose rows carry counts or probabilities."""
    if isinstance(source, (str, os.PathLike, list, tuple)):
        return False
    if not is_frame(source):
        return True
    from fairaudit.tables.frames import is_lazy

    return plain and not is_lazy(source)


def _held(
    source: Any,
    bins: Mapping[str, Sequence[Number] | Bins],
    access: Access,
    *,
    plain: bool,
    spelled: Callable[[str], str],
) -> Any:
    """A table in memory, with numbers cut into intervals."""
    from fairaudit.tables.binning import Bins, apply_bins
    from fairaudit.tables.engines.logs import cut_columns
    from fairaudit.tables.engines.request import FOR_CERTIFY

    if plain:
        _refuse_what_logs_have(bins, access, spelled)
    elif access.table is not None or access.query is not None:
        raise InputError(f"{spelled('table')} and {spelled('query')} go with a database")
    if not access.evaluations and isinstance(source, Tally) and source.evaluation is not None:
        raise InputError(f"{source.name}: {FOR_CERTIFY}")
    access.extraction.refuse("a table in memory")
    if not hasattr(source, "columns") and not isinstance(source, Mapping) and not isinstance(source, Tally):
        raise unreadable(source)
    if is_frame(source) and not hasattr(source, "iloc") and not all(isinstance(name, str) for name in source.columns):
        source = {name: source[name] for name in source.column_names}
    if not bins:
        return source
    cut = {name: edges if isinstance(edges, Bins) else Bins.of(name, edges) for name, edges in bins.items()}
    if isinstance(source, Tally):
        return replace(apply_bins(source, cut), preparation=(*source.preparation, *cut_columns(cut)))
    labels: dict[str, list[str | None]] = {}
    for name, intervals in cut.items():
        values, known = column(source, name), dict[tuple[type, Any], str | None]()
        for position, value in enumerate(values):
            key = (type(value), value)
            try:
                known[key] = known[key] if key in known else intervals.label_of(value)
            except InputError as error:
                raise InputError(f"column {shown(name)}, row {position + 1}: {error}; intervals need numbers") from None
        labels[name] = [known[type(value), value] for value in values]
    return PreparedTable(source, labels, (*getattr(source, "preparation", ()), *cut_columns(cut)))


def _with_numbers(table: Any, columns: Mapping[str, NumberKind], form: NumberForm) -> Any:
    """Write the numbers of some columns with decimal points, without separators and signs."""
    if isinstance(table, CsvTable):
        return table.with_numbers(columns, form)
    if not isinstance(table, Tally):
        texts = {name: column(table, name) for name in columns if not _has_numbers(table, name)}
        plain = {name: plain_numbers(name, cells, locator(table), form, columns[name]) for name, cells in texts.items()}
        changed: dict[str, Any] = {name: found for name, found in plain.items() if found is not None}
        return PreparedTable(table, changed, getattr(table, "preparation", ())) if changed else table
    levels, notes = dict(table.levels), list(table.notes)
    for name, kind in columns.items():
        column(dict.fromkeys(levels, ()), name)
        at, held = table.codes[name], levels[name]

        def first(level: int, at: Any = at) -> str:
            return table.locate(int(np.flatnonzero(at == level)[0]))

        found = plain_numbers(name, held, first, form, kind)
        if found is not None:
            levels[name] = found
            notes += decimal_commas(name, held, form)
    return replace(relabelled(table, levels), notes=tuple(notes))


def _has_numbers(table: Any, name: str) -> bool:
    """Whether a column of a frame holds numbers and no texts."""
    known = [own for own in (table.columns if hasattr(table, "columns") else table) if isinstance(own, str)]
    return name in known and getattr(getattr(table[name], "dtype", None), "kind", "O") in "iufb"


def _typed(source: Any) -> bool:
    """Whether the cells of a source say which are numbers, as in spreadsheets: only texts were read as declared, when it was opened."""
    from fairaudit.tables.engines.paths import form

    paths = [source] if isinstance(source, (str, os.PathLike)) else source if isinstance(source, (list, tuple)) else []
    try:
        return any(os.path.isfile(path) and form(os.fspath(path)) in ("spreadsheet", "statistics") for path in paths)  # noqa: PTH113
    except (InputError, OSError, ValueError, TypeError):
        return False


def _is_csv(table: str) -> bool:
    """Whether a table is a file of delimited text, as far as its name and first bytes say."""
    from fairaudit.tables.engines.paths import form

    if is_database(table) and not Path(table).exists():
        return False
    try:
        return Path(table).is_fifo() or form(table) == "csv"
    except (InputError, OSError, ValueError):
        return not any(character in table for character in "*?[")  # the reader says what is wrong with it


def _warm() -> None:
    """Load what comes after the table while an engine reads it."""
    import fairaudit.audits.certify  # noqa: F401


def unfit_for_parts(reading: Reading, given: Mapping[str, object]) -> str:
    """Name what does not go with contexts that are read in parts, as the one who asks writes it; empty if there is nothing.

    Parameters
    ----------
    reading : Reading
        What is asked of the table.
    given : mapping
        Further options that do not go with it, by name; those that are not given are None, false or empty.
    """
    if not reading.context:
        return f"a log without {reading.spelled('context')}"
    asked: dict[str, object] = {
        "score": reading.above is not None,
        "probability": reading.probability,
        "wide": reading.wide,
        "utility_column": reading.utility_column,
        "truth": reading.truth,
        "positive": given.get("positive"),
        "fold_labels": reading.fold_labels,
        "map": reading.label_map,
        "unit": reading.unit,
        "query": reading.access.query,
        "skip": reading.access.skip,
        "same_content": reading.access.same_content == "accept",
        **reading.access.extraction.asked,
        **given,
        "unknown": reading.unknown,
        "missing": reading.missing in ("unknown", "undecided"),
    }
    for name, value in asked.items():
        if value:
            return reading.spelled(name)
    return "" if reading.access.engine in ("auto", "duckdb") else f"{reading.spelled('engine')} {reading.access.engine}"
