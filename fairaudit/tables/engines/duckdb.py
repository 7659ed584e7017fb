"""DuckDB, the embedded engine: files of any size, and its own database files."""

from __future__ import annotations

import codecs
import json
import re
import shutil
import tempfile
from collections.abc import Generator, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager, suppress
from dataclasses import dataclass, replace
from fractions import Fraction
from itertools import chain, pairwise
from pathlib import Path
from typing import Any

import duckdb
import numpy as np

from fairaudit.errors import InputError, ManyRowsError, shown
from fairaudit.tables.binning import RAW, Bins, apply_bins
from fairaudit.tables.columns import MISSING_LABEL, label_is_there, read_labels
from fairaudit.tables.csv import Layout, first_row, layout, number_of_lines, opened, same_layout, text_lines
from fairaudit.tables.engines.paths import Form, read_text
from fairaudit.tables.engines.request import SAME_ROWS, Request, attended, database_source
from fairaudit.tables.engines.tally_files import refuse_others, said_by
from fairaudit.tables.evaluations.paths import json_value
from fairaudit.tables.label_text import Reader
from fairaudit.tables.preparation import Entry, left_out, level
from fairaudit.tables.sql import COUNT_COLUMN, READ_COLUMN, Written, count_statement, identifier, written, written_name
from fairaudit.tables.tally import Tally, refuse_loss
from fairaudit.tables.values import MARK, Label, column, combine, distinct, refuse_tally

__all__ = [
    "JSON",
    "DelimitedText",
    "bad_json",
    "connected",
    "delimited_text",
    "fetched_rows",
    "json_form",
    "json_texts",
    "literal",
    "literal_path",
    "literals",
    "one_statement",
    "parquet_faults",
    "progress",
    "read_database",
    "read_files",
    "read_parts",
    "readers",
    "told",
    "writing",
]

BATCH = 50_000  # rows that are fetched at a time: a few MB
SAMPLE = 100_000  # rows that say which texts are few; one that they lacked is noticed while counting
FEW = 1_000  # different texts that become an enumeration; more cost more than they save
PART = 2_000_000  # different rows that are held at a time when a log is read in parts: some 200 MB
BLOCK = 1 << 24  # 16 MiB of a text that are scanned at a time
BOM = codecs.BOM_UTF8
WHOLE = ("TINYINT", "SMALLINT", "INTEGER", "BIGINT", "UTINYINT", "USMALLINT", "UINTEGER", "BOOLEAN")
ROUNDED = re.compile(r"TIME|DOUBLE|FLOAT")
WHOLE_NUMBER = re.compile(r"U?(TINY|SMALL|BIG)INT|U?INTEGER")
BLANKS = "".join(character for character in map(chr, range(0x3001)) if character.isspace())  # of which a missing label consists
NUMERIC = re.compile(r"U?(TINY|SMALL|BIG|HUGE)INT|U?INTEGER|FLOAT|DOUBLE|DECIMAL.*")


def read_files(paths: Sequence[str], kind: Form, request: Request) -> Tally:
    """Count the rows of files that hold the same columns."""
    if kind == "csv":
        return _read_csv(paths, request)
    if kind == "json":
        return _read_json(paths, request)
    listed = literals(map(literal_path, paths))
    source = f"read_parquet({listed})"
    with connected(request) as connection, told(request, paths[0]):
        said = said_by(connection, paths, listed, request.same_content)
        types = _types(connection, source, request.columns, tally=said is not None)
        _refuse_rounded(connection, paths, types)
        if said is None:
            return _count(connection, Path(paths[0]).name, source, types, request, quick=True)
        said.refuse(paths[0], request.columns, request.count, [*request.bins])
        source = source if len(paths) == 1 else _added_up(connection, Path(paths[0]).name, source, types, request)
        tally = _count(connection, Path(paths[0]).name, source, types, request, quick=True)
        return replace(tally, preparation=said.preparation)


def _added_up(connection: Any, name: str, source: str, types: Mapping[str, str], request: Request) -> str:
    """Add up the counts of several files, each of which is opened once; what stands after ``from`` for the sums."""
    quoted = identifier(request.count or "", "duckdb")
    others = ", ".join(identifier(name, "duckdb") for name in types if name != request.count)
    sums = f"select {others}, sum({quoted})::{types[request.count or '']} as {quoted} from {source} group by {others}"  # noqa: S608
    attended(
        lambda: connection.execute(f"create temporary table added_up as {sums}"),
        connection.interrupt,
        replace(request, meanwhile=None),
        lambda: progress(connection),
    )
    _conserved(connection, name, f"sum({quoted})", "added_up", _amount(connection, f"sum({quoted})", source))
    return "added_up"


def read_database(path: str, request: Request) -> Tally:
    """Count the rows of a table, or of the result of a query, of a DuckDB database file, which is opened for reading."""
    if not Path(path).is_file():
        raise InputError(f"{path}: there is no such file")
    source = database_source(request, "duckdb")
    with connected(request, path) as connection, told(request, path):
        one_statement(connection, source)
        types = _types(connection, source, request.columns)
        return _count(connection, Path(path).name, source, types, request, quick=request.query is None)


def tables(path: str) -> list[str]:
    """Names of the tables and views of a DuckDB database file."""
    if not Path(path).is_file():
        raise InputError(f"{path}: there is no such file")
    with connected(Request((), {}), path) as connection, told(Request((), {}), path):
        listed = "select schema_name, {0}_name from duckdb_{0}s() where not internal"
        found = connection.execute(f"{listed.format('table')} union all {listed.format('view')}").fetchall()
    return sorted(written_name(*([] if schema == "main" else [schema]), name) for schema, name in found)


def one_statement(connection: Any, source: str) -> None:
    """Refuse a query that closes the parentheses around it to go on with statements of its own, which could write files.

    Raises
    ------
    InputError
        If it does.
    """
    found = connection.extract_statements(f"select * from {source}")  # noqa: S608
    if len(found) != 1 or found[0].type not in (duckdb.StatementType.SELECT, duckdb.StatementType.MULTI):  # PIVOT is one of several steps
        raise InputError("the query holds several statements; give one, a SELECT")


@dataclass(frozen=True)
class _Counted:
    """A log as the temporary table ``counted``: a row for each of its different rows, with the columns k0, k1, … and row_count.

    Beside it stands how many rows the log has, counted without groups; None where only its reader can say that.
    """

    name: str
    columns: tuple[str, ...]
    types: dict[str, str]
    bins: dict[str, Bins]
    cut: set[str]
    tied: set[str]
    enums: dict[str, str]
    rows: int | None

    def key(self, column: str) -> str:
        """Name a column has in the table."""
        return f"k{self.columns.index(column)}"

    def tally(self, connection: Any, columns: Sequence[str], source: str) -> Tally:
        """Fetch rows of the table, or of a query with the same columns."""
        if all(c in self.enums or (self.types[c] in WHOLE and c not in self.bins) for c in columns):
            return self._by_column(connection, columns, source)
        kinds = {c: writing(self.types[c], c) for c in columns if c not in self.cut}
        picked = [kinds[c].of(self.key(c)) if c in kinds else self.key(c) for c in columns]
        cursor = connection.execute(f"select {', '.join([*picked, COUNT_COLUMN])} from {source}")  # noqa: S608
        json_texts = [c for c in kinds if self.types[c] == "JSON"]
        tally = Tally.of(self.name, columns, fetched_rows(cursor), read=readers(kinds), equal=json_texts)
        return apply_bins(tally, {c: self.bins[c] for c in columns if c in self.bins}, self.cut, self.tied)

    def _by_column(self, connection: Any, columns: Sequence[str], source: str) -> Tally:
        """Fetch whole numbers, truth values and enumerated texts column by column."""
        picked = [f"enum_code({self.key(c)}) as {self.key(c)}" if c in self.enums else self.key(c) for c in columns]
        found = connection.execute(f"select {', '.join([*picked, COUNT_COLUMN])} from {source}").fetchnumpy()  # noqa: S608
        codes, levels = {}, {}
        for c in columns:
            part = found[self.key(c)]
            absent = np.ma.getmaskarray(part) if isinstance(part, np.ma.MaskedArray) else np.zeros(len(part), dtype=np.bool_)
            values, places = distinct(np.asarray(part, dtype=np.int64)[~absent])
            codes[c] = np.full(len(part), len(values), dtype=np.int64)
            codes[c][~absent] = places
            listed: list[Any] = values.tolist()
            if c in self.enums:
                known = connection.execute(f"select unnest(enum_range(null::{self.enums[c]}))").fetchall()
                listed = [known[value][0] for value in listed]
            elif part.dtype == np.bool_:
                listed = [bool(value) for value in listed]
            levels[c] = [*listed, None] if absent.any() else listed
        return Tally(self.name, codes, levels, np.asarray(found[COUNT_COLUMN], dtype=np.int64)).checked()


def read_parts(paths: Sequence[str], request: Request, by: Sequence[str]) -> Generator[Tally, None, None]:
    """Count Parquet files, or a table of a DuckDB database, and fetch the counts in parts.

    First come the counts of the columns that are not in `by`; then those of all columns, some values of `by` at a time, in the order of
    their texts, so that the rows of one value are in one part.
    """
    database = paths[0] if request.table is not None else ":memory:"
    source = f"read_parquet({literals(map(literal_path, paths))})" if request.table is None else database_source(request, "duckdb")
    with connected(request, database) as connection, told(request, paths[0]):
        said = None if request.table is not None else said_by(connection, paths, literals(map(literal_path, paths)), request.same_content)
        types = _types(connection, source, request.columns, tally=said is not None)
        if request.table is None:
            _refuse_rounded(connection, paths, types)
        if said is not None:
            said.refuse(paths[0], request.columns, request.count, [*request.bins])
        if unfit := _unfit(types, request.bins, by):
            raise InputError(unfit)
        if request.count is not None:
            _refuse_counts(connection, source, request.count, tally=said is not None)
        done: list[Entry] = [] if said is None else [*said.preparation]

        def work() -> tuple[_Counted, list[int]]:
            counted = _counted(connection, Path(paths[0]).name, source, types, request, quick=True, total=request.count)
            _conserved(connection, counted.name, f"sum({COUNT_COLUMN})", "counted", counted.rows)
            if request.missing == "drop":
                done.extend(_dropped(connection, counted, request.columns, request.group))
            elif request.missing == "group":
                done.extend(_levels(connection, counted, request.columns))
            keys, others = (", ".join(counted.key(c) for c in request.columns if (c in by) == inside) for inside in (True, False))
            order = ", ".join(f"coalesce(cast({counted.key(c)} as varchar), {literal(MISSING_LABEL)})" for c in by)
            same = " and ".join(f"a.{counted.key(c)} is not distinct from b.{counted.key(c)}" for c in by)
            steps = {
                "whole": f"select {others}, sum({COUNT_COLUMN})::bigint as {COUNT_COLUMN} from counted group by all",  # noqa: S608
                "places": f"select {keys}, count(*) as size, row_number() over (order by {order}) as place from counted group by {keys}",  # noqa: S608
                "placed": f"select a.*, b.place from counted a join places b on {same} order by b.place",  # noqa: S608
            }
            for made, statement in steps.items():
                connection.execute(f"create temporary table {made} as {statement}")
            rows = _amount(connection, f"sum({COUNT_COLUMN})", "counted")
            for made in ("whole", "placed"):
                _conserved(connection, counted.name, f"sum({COUNT_COLUMN})", made, rows)
            connection.execute("drop table counted")
            sizes = connection.execute("select size from places order by place").fetchnumpy()["size"]
            share = np.cumsum(sizes) // PART
            return replace(counted, rows=rows), [0, *(np.flatnonzero(np.diff(share)) + 1).tolist(), len(sizes)]

        counted, edges = attended(work, connection.interrupt, request, lambda: progress(connection))
        whole = counted.tally(connection, [c for c in request.columns if c not in by], "whole")
        yield replace(whole.conserving(counted.rows or 0, "DuckDB"), preparation=tuple(done))
        passed = 0
        for place, (first, last) in enumerate(pairwise(edges)):
            if request.report is not None:
                request.report(place / (len(edges) - 1), None)
            part = counted.tally(connection, request.columns, f"placed where place > {first} and place <= {last}")
            passed += part.rows
            yield part
        whole.conserving(passed, "DuckDB")


def _refuse_counts(connection: Any, source: str, count: str, *, tally: bool) -> None:
    """Refuse counts that are not whole numbers of at least 0."""
    kind = _types(connection, source, [count], tally=tally)[count]
    if not WHOLE_NUMBER.fullmatch(kind):
        raise InputError(f"column {shown(count)} holds {kind}; counts of contexts that are read in parts are whole numbers")
    name = identifier(count, "duckdb")
    wrong = connection.execute(f"select {name} from {source} where {name} is null or {name} < 0 limit 1").fetchall()  # noqa: S608
    if wrong:
        said = "the number is missing" if wrong[0][0] is None else f"{wrong[0][0]} is negative; numbers of at least 0 are accepted"
        raise InputError(f"column {shown(count)}: {said}")


def _absent(counted: _Counted, columns: Sequence[str]) -> dict[str, str]:
    """Say of each column when a row has no label in it."""
    absent = {}
    for name in columns:
        key = counted.key(name)
        missing = f"{key} is null"
        if name in counted.tied:
            missing = f"({missing} or (starts_with({key}, '{RAW}') and trim(substr({key}, {len(RAW) + 1}), {literal(BLANKS)}) = ''))"
        elif counted.types[name] == "VARCHAR":
            missing = f"({missing} or trim(cast({key} as varchar), {literal(BLANKS)}) = '')"
        elif counted.types[name] in ("FLOAT", "DOUBLE") and name not in counted.cut:
            missing = f"({missing} or isnan({key}))"
        absent[name] = missing
    return absent


def _levels(connection: Any, counted: _Counted, columns: Sequence[str]) -> list[Entry]:
    """Make one value of all missing labels of a column, and say how many decisions have none."""
    done = []
    for name, missing in _absent(counted, columns).items():
        key = counted.key(name)
        wanted = f"select count(*), sum({COUNT_COLUMN}) from counted where {missing}"  # noqa: S608
        ((rows, amount),) = connection.execute(wanted).fetchall()
        if not rows:
            continue
        if connection.execute(f"select 1 from counted where cast({key} as varchar) = {literal(MISSING_LABEL)} limit 1").fetchall():  # noqa: S608
            raise InputError(label_is_there(name))
        connection.execute(f"update counted set {key} = null where {missing}")  # noqa: S608
        if amount:
            done.append(level(name, MISSING_LABEL, "decisions", Fraction(int(amount))))
    keys = ", ".join(map(counted.key, counted.columns))  # rows that differed in how a label was missing are one row now
    again = f"select {keys}, sum({COUNT_COLUMN})::bigint as {COUNT_COLUMN} from counted group by {keys}"  # noqa: S608
    connection.execute(f"create or replace temporary table counted as {again}")
    return done


def _dropped(connection: Any, counted: _Counted, columns: Sequence[str], group: Sequence[str]) -> list[Entry]:
    """Drop the rows that have no label in some column, and say how many decisions they stand for."""
    absent = _absent(counted, columns)
    some = " or ".join(absent.values())
    amounts = ", ".join(f"coalesce(sum({COUNT_COLUMN}) filter (where {missing}), 0)" for missing in (some, *absent.values()))
    lost = _by_group(connection, counted, group, f"({some}) and not ({' or '.join(absent[name] for name in group)})")
    ((of, left, *each),) = connection.execute(f"select coalesce(sum({COUNT_COLUMN}), 0), {amounts} from counted").fetchall()  # noqa: S608
    connection.execute(f"delete from counted where {some}")  # noqa: S608
    if not connection.execute("select 1 from counted limit 1").fetchall():
        raise InputError("every row has a missing label; nothing is left to audit")
    by_column = {name: Fraction(int(amount)) for name, amount in zip(columns, each, strict=True)}
    if not left:
        return []
    kept = _by_group(connection, counted, group, "true")
    by_group = {label: (amount, amount + kept.get(label, Fraction(0))) for label, amount in lost.items()}
    return [left_out("decisions", Fraction(int(left)), Fraction(int(of)), by_column, by_group)]


def _by_group(connection: Any, counted: _Counted, group: Sequence[str], condition: str) -> dict[Label, Fraction]:
    """How many decisions of each group meet a condition."""
    keys = ", ".join(map(counted.key, group))
    amount = f"sum({COUNT_COLUMN})"
    source = f"(select {keys}, {amount}::bigint as {COUNT_COLUMN} from counted where {condition} group by {keys} having {amount} > 0)"  # noqa: S608
    tally = counted.tally(connection, group, source)
    if not len(tally.counts):
        return {}
    read = read_labels(tally, group, [], "error")
    codes, labels = combine([read.labels[name] for name in group], len(read.counts))
    found: dict[Label, Fraction] = {}
    for a, n in zip(codes.tolist(), read.counts.tolist(), strict=True):  # labels that are written alike are one
        found[labels[a]] = found.get(labels[a], Fraction(0)) + n
    return found


def _unfit(types: dict[str, str], bins: Mapping[str, Bins], by: Sequence[str]) -> str:
    """Why the values of some columns cannot be read in parts, in the order of their texts; empty if they can."""
    for name in by:
        if types[name] not in (*WHOLE, "UBIGINT", "VARCHAR") and name not in bins:
            return (
                f"column {shown(name)} holds {types[name]}; contexts that are read in parts are texts, whole numbers, or cut into "
                f"intervals, such as {name}:0,10"
            )
        if types[name] == "VARCHAR" and name in bins:
            return f"column {shown(name)} holds texts, which are not cut into intervals where contexts are read in parts"
    return ""


def _count(connection: Any, name: str, source: str, types: dict[str, str], request: Request, *, quick: bool = False) -> Tally:
    """Count the log and read what comes back; `quick` if a sample of the source costs little."""

    def work() -> Tally:
        counted = _counted(connection, name, source, types, request, quick=quick)
        fit = request.count is None or WHOLE_NUMBER.fullmatch(types[request.count])
        if request.most is not None and quick and fit and not _unfit(types, request.bins, request.by):
            ((rows,),) = connection.execute("select count(*) from counted").fetchall()
            if rows > request.most:
                raise ManyRowsError(f"the log has {rows} different rows, more than {request.most}")
        tally = counted.tally(connection, request.columns, "counted")
        return tally if counted.rows is None else tally.conserving(counted.rows, "DuckDB", SAME_ROWS)

    tally = attended(work, connection.interrupt, request, lambda: progress(connection))
    if not len(tally):
        raise InputError("the table has no rows")
    return tally


def _counted(
    connection: Any, name: str, source: str, types: dict[str, str], request: Request, *, quick: bool, total: str | None = None
) -> _Counted:
    """Make the table ``counted``."""
    cut = {c for c in request.bins if NUMERIC.fullmatch(types[c])}
    tied = {c for c in request.bins if types[c] == "VARCHAR"}
    bins = {c: request.bins[c] for c in cut | tied}
    length = _amount(connection, "count(*)" if total is None else f"sum({identifier(total, 'duckdb')})", source) if quick else None
    single = [identifier(c, "duckdb") for c in cut if types[c] == "FLOAT"]
    if single:  # compared with an edge they would round it to float32
        widened = ", ".join(f"cast({name} as double) as {name}" for name in single)
        source = f"(select * replace ({widened}) from {source}) as log"  # noqa: S608

    def made(enums: dict[str, str]) -> _Counted:
        read = None if request.query is None else request.read
        statement = count_statement(request.columns, source, "duckdb", bins=bins, exact_ties=tied, enums=enums, total=total, read=read)
        connection.execute(f"create or replace temporary table counted as {statement}")
        rows = length if read is None else _amount(connection, f"any_value({READ_COLUMN})", "counted")
        return _Counted(name, request.columns, types, dict(request.bins), cut, tied, enums, rows)

    found = made(_enums(connection, source, [c for c in request.columns if quick and types[c] == "VARCHAR" and c not in bins]))
    lost = " or ".join(f"({found.key(c)} is null and text{i} > 0)" for i, c in enumerate(found.enums))
    if lost and connection.execute(f"select 1 from counted where {lost} limit 1").fetchall():  # noqa: S608
        return made({})  # a text that the sample did not have
    return found


def _amount(connection: Any, what: str, source: str) -> int:
    """A number of rows, or a sum of counts; 0 of no rows."""
    ((found,),) = connection.execute(f"select {what} from {source}").fetchall()  # noqa: S608
    return int(found or 0)


def _conserved(connection: Any, name: str, what: str, made: str, rows: int | None) -> None:
    """Refuse a table of counts that DuckDB made of other than as many rows."""
    refuse_loss(name, _amount(connection, what, made), rows or 0, "DuckDB", SAME_ROWS)


def _enums(connection: Any, source: str, columns: Sequence[str]) -> dict[str, str]:
    """Types for text columns of which a sample has few different texts: DuckDB counts small integers faster than texts."""
    found = {}
    for place, name in enumerate(columns):
        quoted = identifier(name, "duckdb")
        sample = f"(select {quoted} as k from {source} limit {SAMPLE})"  # noqa: S608
        ((different,),) = connection.execute(f"select count(distinct k) from {sample}").fetchall()  # noqa: S608
        if 0 < different <= FEW:
            try:
                connection.execute(f"create temporary type text{place} as enum (select distinct k from {sample} where k is not null)")  # noqa: S608
            except duckdb.ParserException:
                return {}  # an older DuckDB, in which types are not temporary
            found[name] = f"text{place}"
    return found


def writing(kind: str, name: str) -> Written:
    """Say how a statement of DuckDB writes the values of a column, JSON as its text."""
    return JSON if kind == "JSON" else written(kind, "duckdb", name)


def readers(kinds: Mapping[str, Written]) -> dict[str, Reader]:
    """List what reads what a statement has written."""
    return {name: kind.read for name, kind in kinds.items() if kind.read is not None}


def fetched_rows(cursor: Any) -> Iterator[tuple[Any, ...]]:
    """Rows of a result, fetched many at a time."""
    while batch := cursor.fetchmany(BATCH):
        yield from batch


def _read_json(paths: Sequence[str], request: Request) -> Tally:
    """Count the rows of JSON lines. Each value is taken as the JSON that it is, so that no type is guessed from the first rows."""
    form, lines = json_form(paths)
    with connected(request) as connection:
        try:
            with told(request, paths[0]):
                _refuse_copies(connection, paths)
                source = json_texts(form, request.columns)
                tally = _count(connection, Path(paths[0]).name, source, dict.fromkeys(request.columns, "JSON"), request)
                if not lines or number_of_lines(paths) != tally.rows:
                    tally = tally.conserving(_amount(connection, "count(*)", source), "DuckDB")
                if any(values == [None] for values in tally.levels.values()):
                    _types(connection, f"read_json({form}, sample_size=-1)", request.columns)
        except InputError as error:
            name = Path(paths[0]).name
            said = str(error) if name in str(error) else f"{name}: {error}"
            raise InputError((bad_json(paths) if lines else None) or said) from None
    return tally


def _refuse_copies(connection: Any, paths: Sequence[str]) -> None:
    """Refuse JSON whose first object is a row of a tally."""
    for path in paths:
        first = f"(select * from {json_texts(json_form([path])[0], [MARK])} limit 1)"  # noqa: S608
        if connection.execute(f"select 1 from {first} where {identifier(MARK, 'duckdb')} is not null").fetchall():  # noqa: S608
            refuse_tally([MARK])


def json_form(paths: Sequence[str]) -> tuple[str, bool]:
    """Arguments of ``read_json`` for files, and whether each line of theirs is an object."""
    lines = all(re.search(r"\.(jsonl|ndjson)(\.\w+)?$", path, re.IGNORECASE) for path in paths)
    return f"{literals(map(literal_path, paths))}, format='{'newline_delimited' if lines else 'auto'}', maximum_object_size=67108864", lines


def json_texts(form: str, columns: Sequence[str]) -> str:
    """What stands after ``from`` for columns of JSON, each value as the text that it is."""
    held = ", ".join(f"{literal(name)}: 'JSON'" for name in columns)
    return f"read_json({form}, columns={{{held}}})"


def bad_json(paths: Sequence[str]) -> str | None:
    """Name the first line that holds no JSON object, if there is one; the engine's own count of lines may be off by one."""
    for path in paths:
        try:
            for number, line in enumerate(text_lines(Path(path)), 1):
                try:
                    if line.strip() and not isinstance(json.loads(line), dict):
                        return f'{path}: line {number} is not a JSON object; each line holds one, such as {{"answer": "yes"}}'
                except (ValueError, RecursionError) as error:
                    deep = "nested too deeply" if isinstance(error, RecursionError) else "a number has too many digits"
                    mark = line.startswith(codecs.BOM_UTF8.decode())
                    said = "it begins with the mark of a file" if mark else error.msg if isinstance(error, json.JSONDecodeError) else deep
                    return f"{path}: line {number} is not JSON: {said}"
        except InputError as error:
            return None if "Zstandard" in str(error) else f"{path}: {error}"
    return None


JSON = Written(read=json_value)


def _read_csv(paths: Sequence[str], request: Request) -> Tally:
    """Count the rows of delimited text: by DuckDB where it reads the text as the CSV reader does, else by that."""
    text = delimited_text(paths)
    if text is None:
        return read_text(paths, request)
    for name in request.columns:
        column(dict.fromkeys(text.layout.columns, ()), name)
    places = {name: f"c{i}" for i, name in enumerate(text.layout.columns)}
    inner = ", ".join(f"{places[name]} as k{i}" for i, name in enumerate(request.columns))
    renamed = Request(
        tuple(f"k{i}" for i in range(len(request.columns))),
        {f"k{i}": request.bins[name] for i, name in enumerate(request.columns) if name in request.bins},
        memory=request.memory,
        report=request.report,
        meanwhile=request.meanwhile,
    )
    try:
        with connected(request) as connection, told(request, paths[0]):
            types = dict.fromkeys(renamed.columns, "VARCHAR")
            held = f"(select {inner} from {text.source}) as log"  # noqa: S608
            counted = _count(connection, Path(paths[0]).name, held, types, renamed)
            whole = text.complete(counted.rows) and (text.delimiters is not None or text.lines == counted.rows + text.files)
            if not whole and text.delimiters is None:  # cells of several lines, say
                whole = _amount(connection, "count(*)", text.source) == counted.rows
    except InputError:
        # Whatever is wrong, the CSV reader says on which line; and if nothing is wrong, it reads the file.
        return read_text(paths, request)
    if not whole:
        return read_text(paths, request)
    back = dict(zip(renamed.columns, request.columns, strict=True))

    def find(tally: Tally, position: int) -> str:
        return _first_line(paths, text.layout.columns, tally, position)

    return Tally(
        counted.name,
        {back[key]: codes for key, codes in counted.codes.items()},
        {back[key]: values for key, values in counted.levels.items()},
        counted.counts,
        text.layout.notes,
        None if request.bins else find,
    )


@dataclass(frozen=True)
class DelimitedText:
    """Files of delimited text that DuckDB reads as the CSV reader does.

    Attributes
    ----------
    source : str
        What stands for them after ``from``; the columns are called c0, c1, …, because DuckDB takes names that differ in case for one.
    layout : Layout
        Their delimiter and columns.
    files : int
        How many files there are.
    delimiters : int or None
        How many delimiters there are; None if some may stand within quotes.
    lines : int
        How many lines there are, headers included; cells within quotes may have several.
    """

    source: str
    layout: Layout
    files: int
    delimiters: int | None
    lines: int

    def complete(self, rows: int) -> bool:
        """Whether so many rows have all the cells that there are; DuckDB passes over empty cells too many at the end of a row."""
        return self.delimiters is None or self.delimiters == (len(self.layout.columns) - 1) * (rows + self.files)


def delimited_text(paths: Sequence[str]) -> DelimitedText | None:
    """Look at files of delimited text; None if they are for the CSV reader.

    Raises
    ------
    InputError
        If one cannot be read, or they do not belong together.
    """
    found: Layout | None = None
    quoted, delimiters, lines = False, 0, 0
    for path in paths:
        try:
            found = same_layout(found, layout(path))
            scan = _scan(path, found.delimiter)
        except InputError as error:
            raise InputError(f"{path}: {error}") from None
        if scan is None:
            return None
        quoted, delimiters, lines = quoted or scan[0], delimiters + scan[1], lines + scan[2]
    if found is None or len(found.columns) < 2:
        return None
    held = ", ".join(f"c{i}: 'VARCHAR'" for i in range(len(found.columns)))
    quote = "'\"'" if quoted else "''"
    source = (
        f"read_csv({literals(map(literal_path, paths))}, columns={{{held}}}, auto_detect=false, header=true, "
        f"delim={literal(found.delimiter)}, quote={quote}, escape={quote}, nullstr='', strict_mode=true, null_padding=false)"
    )
    return DelimitedText(source, found, len(paths), None if quoted else delimiters, lines)


def _first_line(paths: Sequence[str], columns: Sequence[str], tally: Tally, position: int) -> str:
    wanted = {columns.index(name): tally.levels[name][codes[position]] or "" for name, codes in tally.codes.items()}
    return first_row(paths, wanted)


def _scan(path: str, delimiter: str) -> tuple[bool, int, int] | None:
    """Whether a text has quotation marks, how many delimiters, and how many lines; None if DuckDB might read it unlike the CSV reader.

    That is so for NUL characters, bytes that are not UTF-8, line ends of several kinds, blank lines before the header, blanks around
    quoted cells, and empty cells at the end of a row with quotes.
    """
    mark = delimiter.encode()
    decoder = codecs.getincrementaldecoder("utf-8")()
    quoted = False
    delimiters = returns = feeds = pairs = 0
    last = b""
    with opened(Path(path)) as file:
        while block := file.read(BLOCK):
            try:
                if decoder.getstate()[0] or not block.isascii():
                    decoder.decode(block)
            except UnicodeDecodeError:
                return None
            if b"\x00" in block or (not last and block.removeprefix(BOM)[:1] in (b"\r", b"\n")):
                return None
            quoted = quoted or b'"' in block
            delimiters += block.count(mark)
            feeds += block.count(b"\n")
            if b"\r" in block:
                returns += block.count(b"\r")
                pairs += block.count(b"\r\n")
            pairs += last[-1:] == b"\r" and block[:1] == b"\n"
            last = block
    mixed = bool(returns) and not (returns == pairs == feeds or not feeds)
    if mixed or decoder.getstate()[0] or (quoted and _is_suspect(path, mark)):
        return None
    return quoted, delimiters, max(feeds, returns) + (last[-1:] not in (b"\n", b"\r"))


def _is_suspect(path: str, mark: bytes) -> bool:
    """Whether a text with quotes has blanks around quoted cells, or empty cells at the end of a row."""
    suspects = (b' "', b'" ', mark + b"\n", mark + b"\r", mark + b'""\n', mark + b'""\r')
    last = b""
    with opened(Path(path)) as file:
        while block := file.read(BLOCK):
            joined = last[-4:] + block
            if any(part in joined for part in suspects):
                return True
            last = block
    return last.endswith((mark, mark + b'""'))


def _types(connection: Any, source: str, columns: Sequence[str], *, tally: bool = False) -> dict[str, str]:
    """Types of the columns that are wanted."""
    known = {name: str(kind) for name, kind, *_ in connection.execute(f"describe select * from {source}").fetchall()}  # noqa: S608
    if tally:
        known.pop(MARK, None)
    for name in columns:
        column(dict.fromkeys(known, ()), name)
        writing(known[name], name)
    return {name: known[name] for name in columns}


def parquet_faults(connection: Any, paths: Sequence[str], types: Mapping[str, str]) -> dict[str, str]:
    """Say which columns of Parquet files DuckDB would round when it reads them, and why.

    It takes the types of the first file for those of all, wide decimals for floats, and moments in the old format of 96 bits (and, in
    older versions, those with a zone) for microseconds.

    Raises
    ------
    InputError
        If only some of the files are tallies, whose columns DuckDB and Spark may pass over.
    """
    suspects = [name for name, kind in types.items() if len(paths) > 1 or ROUNDED.match(kind)]
    if not suspects:
        return {}
    faults: dict[str, str] = {}
    connection.execute("set preserve_insertion_order = true")
    cursor = connection.execute(f"select * from parquet_schema({literals(map(literal_path, paths))})")  # noqa: S608
    words = [entry[0] for entry in cursor.description]
    schemas: dict[str, list[dict[str, Any]]] = {}
    for row in fetched_rows(cursor):
        entry = dict(zip(words, row, strict=True))
        schemas.setdefault(entry["file_name"], []).append(entry)
    connection.execute("set preserve_insertion_order = false")
    marked = {path for path, entries in schemas.items() if any(entry["name"] == MARK for entry in entries)}
    if marked and (others := schemas.keys() - marked):
        refuse_others(min(marked), min(others))
    first: dict[str, tuple[str, str]] = {}
    for entry in chain.from_iterable(_leading(schemas[path]) for path in sorted(schemas)):
        name = entry["name"]
        if name not in suspects or name in faults:
            continue
        fine = "NANOS=NanoSeconds" in str(entry["logical_type"])
        kind = entry.get("duckdb_type") or f"{entry['type']} {entry['converted_type']}"
        kind, where = "INTEGER" if WHOLE_NUMBER.fullmatch(kind) else kind, entry["file_name"]
        other, before = first.setdefault(name, (kind, where))
        if kind != other:
            faults[name] = f"is {other} in {before} and {kind} in {where}; write it with one type in files that are read together"
        elif entry["type"] == "INT96":
            faults[name] = "holds moments of 96 bits, which do not say whether they are in UTC; write it as a timestamp of 64 bits"
        elif (entry["precision"] or 0) > 38:
            faults[name] = f"holds decimals of {entry['precision']} digits, which DuckDB rounds; write it with 38 digits, or as text"
        elif fine and not types[name].endswith("_NS"):
            faults[name] = "holds nanoseconds, which this version of DuckDB rounds; write it in microseconds, or as text"
    return faults


def _leading(entries: Iterable[dict[str, Any]]) -> Iterator[dict[str, Any]]:
    """Entries of columns that are part of no other, in the schema of a Parquet file."""
    left: list[int] = []
    for entry in entries:
        if len(left) == 1:
            yield entry
        if left:
            left[-1] -= 1
        if entry["num_children"]:
            left.append(entry["num_children"])
        while left and not left[-1]:
            left.pop()


def _refuse_rounded(connection: Any, paths: Sequence[str], types: Mapping[str, str]) -> None:
    for name, fault in parquet_faults(connection, paths, types).items():
        raise InputError(f"column {shown(name)} {fault}")


def progress(connection: Any) -> float | None:
    """Share of a running query that is done, if DuckDB knows."""
    done = float(connection.query_progress())
    return done / 100 if 0 <= done <= 100 else None


@contextmanager
def connected(request: Request, path: str = ":memory:") -> Iterator[Any]:
    """A connection that loads nothing from elsewhere, and spills into a directory of its own."""
    spill = tempfile.mkdtemp(prefix="fairaudit-spill-")
    config: dict[str, Any] = {
        "temp_directory": spill,
        "autoinstall_known_extensions": "false",
        "autoload_known_extensions": "false",
        "preserve_insertion_order": "false",
    }
    if request.memory is not None:
        config["memory_limit"] = request.memory
    connection = None
    try:
        try:
            connection = duckdb.connect(path, read_only=path != ":memory:", config=config)
            connection.execute("set enable_progress_bar = true; set enable_progress_bar_print = false; set perfect_ht_threshold = 22")
            with suppress(duckdb.CatalogException):  # an installation without time zones
                connection.execute("set TimeZone = 'UTC'")
        except duckdb.Error as error:
            raise InputError(_sentence(error, request)) from None
        yield connection
    finally:
        if connection is not None:
            connection.close()
        shutil.rmtree(spill, ignore_errors=True)


@contextmanager
def told(request: Request, path: str) -> Iterator[None]:
    """Make one sentence of what the engine complains about."""
    try:
        yield
    except duckdb.InterruptException:
        raise KeyboardInterrupt from None
    except duckdb.Error as error:
        raise InputError(f"{path}: {_sentence(error, request)}") from None


def _sentence(error: Exception, request: Request) -> str:
    text = " ".join(str(error).split("\n\n")[0].split())
    if isinstance(error, duckdb.OutOfMemoryException):
        limit = f" within --memory {request.memory}" if request.memory else ""
        return f"counting needs more memory or temporary space than there is{limit}: {text[:300]}"
    return f"DuckDB cannot read it: {text[:400]}"


def literal_path(path: str) -> str:
    """Write a path so that none of its characters is a pattern."""
    return re.sub(r"([*?\[])", r"[\1]", path)


def literal(text: str) -> str:
    """Write a text as it stands in a statement."""
    return "'" + text.replace("'", "''") + "'"


def literals(texts: Any) -> str:
    """Write a list of texts."""
    return "[" + ", ".join(map(literal, texts)) + "]"
