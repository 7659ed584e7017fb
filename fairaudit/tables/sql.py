"""The one statement that counts a log in any SQL engine: distinct rows and how often each occurs. Only cells travel back.

Column and table names are quoted; labels never become part of a statement.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Literal

from fairaudit.errors import InputError, nearest, shown
from fairaudit.tables.label_text import ACCEPTED, Reader, iso_text

if TYPE_CHECKING:
    from fairaudit.tables.binning import Bins


__all__ = [
    "AS_IS",
    "COUNT_COLUMN",
    "DIALECTS",
    "RowsRead",
    "Written",
    "common_statement",
    "count_statement",
    "identifier",
    "refused_type",
    "table_name",
    "written",
]

QUOTES = {
    "bigquery": "`",
    "duckdb": '"',
    "postgres": '"',
    "snowflake": '"',
    "spark": "`",
    "sqlite": '"',
    "trino": '"',
}
DIALECTS = tuple(QUOTES)
COUNT_COLUMN = "row_count"
READ_COLUMN = "rows_read"
LOG = "fairaudit_log"
LARGEST = "1.7976931348623157E308"


@dataclass(frozen=True)
class Written:
    """How a statement writes the values of a type for their labels, whatever the time zone of machine, server and session.

    Attributes
    ----------
    expression : str
        What is selected, with ``{}`` for the value.
    read : callable or None
        What makes the label's text of it.
    """

    expression: str = "{}"
    read: Reader | None = None

    def of(self, quoted: str) -> str:
        """Write the value of a quoted column."""
        return self.expression.replace("{}", quoted)


class RowsRead:
    """Rows of a result without their last value, which says how many rows were read.

    Attributes
    ----------
    rows : int
        How many were read; known once the rows have passed.

    Examples
    --------
    >>> read = RowsRead([("yes", 2, 3), ("no", 1, 3)])
    >>> list(read), read.rows
    ([['yes', 2], ['no', 1]], 3)
    """

    def __init__(self, result: Iterable[Sequence[Any]]) -> None:
        self.result, self.rows = result, 0

    def __iter__(self) -> Iterator[list[Any]]:
        """Give the rows."""
        for *row, rows in self.result:
            self.rows = rows
            yield row


AS_IS = Written()
DUCKDB_MOMENT = "case when isfinite(cast({{}} as timestamptz)) then cast(epoch_{}({{}}) as varchar) else cast({{}} as varchar) end"
WRITTEN: dict[str, tuple[tuple[str, Written], ...]] = {
    "duckdb": (
        (r"U?(TINY|SMALL|BIG|HUGE)INT|U?INTEGER|BOOLEAN|FLOAT|DOUBLE|DECIMAL\(.*\)|VARCHAR|ENUM\(.*\)|JSON|\"NULL\"", AS_IS),
        (r"BIGNUM|UUID", Written("cast({} as varchar)")),
        (r"DATE", Written("cast({} as varchar)", iso_text("date"))),
        (r"TIME(_NS)?", Written("cast({} as varchar)", iso_text("time"))),
        (r"TIMESTAMP(_S|_MS|_NS)?", Written("cast({} as varchar)", iso_text("timestamp"))),
        (r"TIMESTAMP WITH TIME ZONE", Written(DUCKDB_MOMENT.format("us"), iso_text("timestamp", zone=True, unit="us"))),
        (r"TIMESTAMPTZ_NS", Written(DUCKDB_MOMENT.format("ns"), iso_text("timestamp", zone=True, unit="ns"))),
    ),
    "postgres": (
        (r"bool|int2|int4|int8|oid|numeric|float8|enum|string|unknown", AS_IS),
        (r"float4", Written("cast({} as float8)")),
        (r"uuid", Written("cast({} as text)")),
        (r"date", Written("cast({} as text)", iso_text("date"))),
        (r"time", Written("cast({} as text)", iso_text("time"))),
        (r"timestamp", Written("cast({} as text)", iso_text("timestamp"))),
        (r"timestamptz", Written("cast(({} at time zone 'UTC') as text)", iso_text("timestamp", zone=True))),
    ),
    "spark": (
        (r"string|(var)?char\(.*\)|boolean|tinyint|smallint|int|bigint|float|double|decimal\(.*\)|void", AS_IS),
        (r"date", Written("cast({} as string)", iso_text("date"))),
        (r"time\(.*\)", Written("cast({} as string)", iso_text("time"))),
        (r"timestamp_ntz", Written("cast({} as string)", iso_text("timestamp"))),
        (r"timestamp", Written("cast(unix_micros({}) as string)", iso_text("timestamp", zone=True, unit="us"))),
    ),
}


def written(kind: str, dialect: str, name: str) -> Written:
    """Say how a statement writes the values of a column for their labels.

    Parameters
    ----------
    kind : str
        The column's type, as the engine calls it.
    dialect : {"duckdb", "postgres", "spark"}
        The engine.
    name : str
        The column, for the message.

    Raises
    ------
    InputError
        If values of that type have no one text in all engines.

    Examples
    --------
    >>> entry = written("timestamp", "spark", "seen")
    >>> entry.of("`seen`"), entry.read("1769860800000001")
    ('cast(unix_micros(`seen`) as string)', '2026-01-31T12:00:00.000001+00:00')
    """
    for pattern, entry in WRITTEN[dialect]:
        if re.fullmatch(pattern, kind, re.DOTALL):
            return entry
    raise refused_type(name, kind)


def refused_type(name: str, kind: str) -> InputError:
    """Make the message that values of a type are no labels.

    Examples
    --------
    >>> print(refused_type("stay", "INTERVAL"))  # doctest: +ELLIPSIS
    column 'stay' is of type INTERVAL, which has no one text; text, numbers, truth values, dates, times and UUIDs are accepted; ...
    """
    nested = re.match(r"struct|map|.*\]$", kind, re.IGNORECASE | re.DOTALL) is not None
    inside = f", or in Parquet name what is in it, such as {name}.race or {name}[0]" if nested else ""
    return InputError(f"column {shown(name)} is of type {kind[:60]}, which has no one text; {ACCEPTED}{inside}")


def identifier(name: str, dialect: str) -> str:
    """Quote a column name.

    Raises
    ------
    InputError
        If the dialect is not known, or cannot express the name.

    Examples
    --------
    >>> print(identifier("answer", "duckdb"), identifier("a`b", "spark"))
    "answer" `a``b`
    """
    quote = QUOTES.get(dialect)
    if quote is None:
        raise InputError(f"the SQL dialect {shown(dialect)} is not known; {nearest(dialect, DIALECTS)}")
    if not name or "\x00" in name or (dialect == "bigquery" and ("`" in name or "\\" in name)):
        raise InputError(f"the name {shown(name)} cannot be written in {dialect}; rename it")
    return quote + name.replace(quote, quote * 2) + quote


def table_name(text: str, dialect: str) -> str:
    """Quote the name of a table: parts separated by points, a part with a point in it between double quotation marks.

    Raises
    ------
    InputError
        If it is not such a name.

    Examples
    --------
    >>> print(table_name("logs.decisions", "postgres"), table_name('"a.b"', "spark"))
    "logs"."decisions" `a.b`
    """
    part = r'"(?:[^"]|"")+"|[^".]+'
    if not re.fullmatch(rf"(?:{part})(?:\.(?:{part}))*", text):
        raise InputError(f"{shown(text)} is not the name of a table; write it as decisions or schema.decisions")
    parts = re.findall(part, text)
    return ".".join(identifier(p[1:-1].replace('""', '"') if p.startswith('"') else p, dialect) for p in parts)


def written_name(*parts: str) -> str:
    """Write the name of a table as `table_name` reads it.

    Examples
    --------
    >>> print(written_name("logs", "a.b"))
    logs."a.b"
    """
    return ".".join('"' + p.replace('"', '""') + '"' if p == "" or "." in p or '"' in p else p for p in parts)


def count_statement(
    columns: Sequence[str],
    source: str,
    dialect: str,
    *,
    bins: Mapping[str, Bins] | None = None,
    names: Sequence[str] | None = None,
    exact_ties: Iterable[str] = (),
    enums: Mapping[str, str] | None = None,
    kinds: Mapping[str, Written] | None = None,
    ordered: bool = False,
    total: str | None = None,
    read: Literal["apart", "once"] | None = None,
) -> str:
    """Write the statement that counts equal rows.

    Parameters
    ----------
    columns : sequence of str
        The columns that tell rows apart.
    source : str
        What is counted, as it stands after ``from``: a quoted table, a table function, a query in parentheses.
    dialect : str
        One of `DIALECTS`.
    bins : mapping of str to Bins, optional
        Numeric columns to cut into intervals.
    names : sequence of str, optional
        Names of the columns of the result; ``k0, k1, …`` by default.
    exact_ties : iterable of str
        Binned columns that hold text (DuckDB only): where rounding to float64 could decide, the text itself travels back.
    enums : mapping of str to str, optional
        Text columns to count as values of these types (DuckDB only). Each adds a column to the result, ``text0``, ``text1``, …: how many of
        the texts are not null, which for a row without a value are those that the type does not have.
    kinds : mapping of str to Written, optional
        How the result writes the values of columns; rows are told apart by the values themselves.
    ordered : bool
        Whether the result is sorted.
    total : str, optional
        A column of whole numbers, which are added up instead of rows.
    read : {"apart", "once"}, optional
        Whether each row of the result ends with the number of rows of the source, counted without groups (`RowsRead`): of the source
        itself, or, where that may give other rows each time, of the rows that are counted, which are read once.

    Returns
    -------
    str
        The statement.

    Examples
    --------
    >>> print(count_statement(["answer", "sex"], '"log"', "sqlite"))
    select "k0", "k1", count(*) as "row_count"
    from (select "answer" as "k0", "sex" as "k1" from "log") as counted
    group by "k0" collate binary, "k1" collate binary
    >>> print(count_statement(["sex"], '"log"', "postgres", read="apart"))
    select "k0", count(*) as "row_count", (select count(*) from "log") as "rows_read"
    from (select "sex" as "k0" from "log") as counted
    group by "k0"
    """
    listed = [identifier(name, dialect) for name in (names or [f"k{i}" for i in range(len(columns))])]
    collated = " collate binary" if dialect == "sqlite" else ""
    ties = set(exact_ties)
    inner: list[str] = []
    texts: list[str] = []
    for name, alias in zip(columns, listed, strict=True):
        quoted = identifier(name, dialect)
        if bins and name in bins:
            quoted = _case_of_text(quoted, bins[name]) if name in ties else _case(quoted, bins[name], dialect)
        elif enums and name in enums:
            text = identifier(f"text{len(texts)}", dialect)
            inner.append(f"{quoted} as {text}")
            texts.append(f", count({text}) as {text}")
            quoted = f"try_cast({quoted} as {enums[name]})"
        inner.append(f"{quoted} as {alias}")
    keys = ", ".join(f"{alias}{collated}" for alias in listed)
    times, number = identifier("times", dialect), "count(*)"
    if total is not None:
        inner.append(f"{identifier(total, dialect)} as {times}")
        number = f"cast(sum({times}) as bigint)"
    counted = f"(select {', '.join(inner)} from {source}) as counted"  # noqa: S608
    selected = [
        alias if (entry := (kinds or {}).get(name, AS_IS)) is AS_IS else f"{entry.of(alias)} as {alias}"
        for name, alias in zip(columns, listed, strict=True)
    ]
    begin, length = "", ""
    if read is not None:
        length = f", (select count(*) from {LOG if read == 'once' else source}) as {identifier(READ_COLUMN, dialect)}"  # noqa: S608
    if read == "once":
        kept = "materialized " if dialect in ("duckdb", "postgres") else ""  # which others do by themselves, or cannot be told
        begin, counted = f"with {LOG} as {kept}{counted.removesuffix(' as counted')}\n", LOG
    counts = f"{number} as {identifier(COUNT_COLUMN, dialect)}{''.join(texts)}{length}"
    text = f"{begin}select {', '.join(selected)}, {counts}\nfrom {counted}\ngroup by {keys}"
    return f"{text}\norder by {', '.join(listed)}" if ordered else text


def common_statement(name: str, source: str, dialect: str, most: int, kind: Written = AS_IS) -> str:
    """Write the statement that fetches the most common values of a column, those that may be missing labels before all others.

    Each row of the result has a value, written as `kind` says, how often it occurs, how many different values there are, and how many rows.

    Examples
    --------
    >>> print(common_statement("sex", '"log"', "sqlite", 8))
    select "k0", "row_count", count(*) over () as "different", sum("row_count") over () as "total"
    from (select "k0", count(*) as "row_count"
    from (select "sex" as "k0" from "log") as counted
    group by "k0" collate binary) as common
    order by case when "k0" is null or trim(cast("k0" as varchar)) in ('', '""', 'null') then 0 else 1 end, "row_count" desc, "k0"
    limit 8
    """
    value, count, different, total = (identifier(word, dialect) for word in ("k0", COUNT_COLUMN, "different", "total"))
    text = "string" if dialect in ("bigquery", "spark") else "varchar"
    first = f"case when {value} is null or trim(cast({value} as {text})) in ('', '\"\"', 'null') then 0 else 1 end"
    counted = count_statement([name], source, dialect, kinds={name: kind})
    return (
        f"select {value}, {count}, count(*) over () as {different}, sum({count}) over () as {total}\n"
        f"from ({counted}) as common\norder by {first}, {count} desc, {value}\nlimit {most}"
    )


def _case(quoted: str, bins: Bins, dialect: str) -> str:
    """Interval of a numeric column. What is not finite, and orders unlike a number in some engine, gets a label of its own.

    DuckDB is asked what is finite: it drops a comparison that the greatest value in a Parquet file's statistics decides, and most writers
    leave NaN out of those.
    """
    whens = [f"when {quoted} < {edge} then '{label}'" for edge, label in zip(bins.edges, bins.labels, strict=False)]
    last = f"when {quoted} >= {bins.edges[-1]} and {quoted} <= {LARGEST} then '{bins.labels[-1]}'"
    finite = f"when not isfinite(cast({quoted} as double)) then '{bins.refused}' " if dialect == "duckdb" else ""
    return (
        f"case when {quoted} is null then null {finite}when {quoted} < -{LARGEST} then '{bins.refused}' {' '.join(whens)} {last} "
        f"else '{bins.refused}' end"
    )


def _case_of_text(quoted: str, bins: Bins) -> str:
    """Interval of a text column: by float64 where that is certain, else the text itself, which is then read exactly."""
    from fairaudit.tables.binning import RAW

    number = f"try_cast({quoted} as double)"
    plain = f"regexp_full_match({quoted}, '[+-]?[0-9]{{1,300}}([.][0-9]{{0,300}})?([eE][+-]?[0-9]{{1,2}})?')"
    near = " or ".join(f"{number} = cast('{edge}' as double)" for edge in bins.edges)
    whens = [f"when {number} < cast('{edge}' as double) then '{label}'" for edge, label in zip(bins.edges, bins.labels, strict=False)]
    return (
        f"case when {plain} is null then null when not {plain} or {number} is null or {near} then '{RAW}' || {quoted} "
        f"{' '.join(whens)} else '{bins.labels[-1]}' end"
    )
