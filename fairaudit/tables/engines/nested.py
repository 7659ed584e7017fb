"""Parquet whose columns hold objects and lists, row by row: paths go into them as into JSON."""

from __future__ import annotations

import re
from collections.abc import Collection, Iterator, Mapping
from pathlib import Path
from typing import Any

from fairaudit.errors import InputError, nearest, shown
from fairaudit.tables.engines.duckdb import connected, fetched_rows, literal, literal_path, parquet_faults, told, writing
from fairaudit.tables.engines.request import Request
from fairaudit.tables.evaluations.json_text import DECODER
from fairaudit.tables.evaluations.samples import Format, Run, Sample
from fairaudit.tables.sql import identifier
from fairaudit.tables.tally import refuse_loss
from fairaudit.tables.values import refuse_tally

__all__ = ["NESTED", "columns_of", "nested_rows"]

NESTED = re.compile(r"STRUCT\(|MAP\(|VARIANT|JSON|UNION\(|.*\]", re.DOTALL)

WIDE = 38  # digits of a decimal that DuckDB does not round


def nested_rows(request: Request) -> Format:
    """Parquet read row by row, as samples that all have an answer."""

    def samples(path: str, wanted: Collection[str]) -> Iterator[Sample]:
        source = f"read_parquet({literal(literal_path(path))}, file_row_number = true)"
        with connected(request) as connection, told(request, path):
            types = {name: str(kind) for name, kind, *_ in connection.execute(f"describe select * from {source}").fetchall()}  # noqa: S608
            number = types.popitem()[0]
            refuse_tally(types)
            held = [name for name in types if name in wanted or not wanted]
            if not held:
                raise InputError(f"none of the columns {', '.join(map(shown, sorted(wanted)))} is there; {nearest(min(wanted), types)}")
            _refuse_rounded(connection, path, types, held)
            kinds = {name: None if NESTED.match(types[name]) else writing(types[name], name) for name in held}
            picked = [
                f"to_json({identifier(name, 'duckdb')})" if kind is None else kind.of(identifier(name, "duckdb"))
                for name, kind in kinds.items()
            ]
            ((rows,),) = connection.execute(f"select count(*) from {source}").fetchall()  # noqa: S608
            passed = 0
            found = connection.execute(f"select {', '.join([*picked, identifier(number, 'duckdb')])} from {source}")  # noqa: S608
            for *values, place in fetched_rows(found):
                where = f"row {place + 1}"
                row: dict[str, Any] = {}
                for (name, kind), value in zip(kinds.items(), values, strict=True):
                    if kind is not None:
                        row[name] = value if kind.read is None else kind.read(value)
                    else:
                        row[name] = None if value is None else DECODER.decode(value)
                passed += 1
                yield Sample(row, "read", where)
            refuse_loss(Path(path).name, passed, rows, "DuckDB")

    return Format("", lambda _: Run(""), samples)


def columns_of(path: str, request: Request) -> dict[str, str]:
    """The columns of a Parquet file, with their types as DuckDB calls them."""
    with connected(request) as connection, told(request, path):
        found = connection.execute(f"describe select * from read_parquet({literal(literal_path(path))})").fetchall()  # noqa: S608
        return {name: str(kind) for name, kind, *_ in found}


def _refuse_rounded(connection: Any, path: str, types: Mapping[str, str], held: Collection[str]) -> None:
    """Refuse columns that DuckDB would round, or within which it would."""
    for name, fault in parquet_faults(connection, [path], {name: types[name] for name in held}).items():
        raise InputError(f"column {shown(name)} {fault}")
    for name, entries in _entries(connection, path).items():
        for entry in entries if name in held and len(entries) > 1 else ():
            if entry["type"] == "INT96" or (entry["precision"] or 0) > WIDE or "NANOS=NanoSeconds" in str(entry["logical_type"]):
                raise InputError(
                    f"column {shown(name)} holds in {shown(entry['name'])} what DuckDB may round (moments of 96 bits or in nanoseconds, "
                    "decimals of more than 38 digits); write it in microseconds, with 38 digits, or as text"
                )


def _entries(connection: Any, path: str) -> Mapping[str, list[dict[str, Any]]]:
    """The entries of the schema of a Parquet file by the column to which they belong, in their order."""
    connection.execute("set preserve_insertion_order = true")
    cursor = connection.execute(f"select * from parquet_schema({literal(literal_path(path))})")  # noqa: S608
    words = [entry[0] for entry in cursor.description]
    rows = [dict(zip(words, row, strict=True)) for row in fetched_rows(cursor)]
    connection.execute("set preserve_insertion_order = false")
    found: dict[str, list[dict[str, Any]]] = {}
    left: list[int] = []
    name = ""
    for entry in rows:
        if len(left) == 1:
            name = entry["name"]
        if left:
            left[-1] -= 1
            found.setdefault(name, []).append(entry)
        if entry["num_children"]:
            left.append(entry["num_children"])
        while left and not left[-1]:
            left.pop()
    return found
