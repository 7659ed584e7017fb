"""Files of databases: which tables they hold."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

__all__ = ["listed", "tables_of"]


def tables_of(source: str) -> list[str]:
    """Names of the tables and views in an SQLite or DuckDB file, as a table is named; none of what is neither.

    Raises
    ------
    InputError
        If the file cannot be read.
    """
    kind, _, path = source.partition(":")
    if kind not in ("sqlite", "duckdb") or Path(source).exists():
        return []
    if kind == "sqlite":
        from fairaudit.tables.engines import sqlite

        return sqlite.tables(path)
    from fairaudit.tables.engines import duckdb

    return duckdb.tables(path)


def listed(tables: Sequence[str]) -> str:
    """List the names of tables, the first ten of them."""
    return f"{', '.join(tables[:10])}{f' and {len(tables) - 10} more' if len(tables) > 10 else ''}"
