"""Counts of a log in a file: written once, and added up with those of other days whenever they are certified."""

from __future__ import annotations

import os
import tempfile
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from fairaudit.arguments import answered
from fairaudit.errors import InputError, shown
from fairaudit.exact.rationals import Number
from fairaudit.files import write_atomically
from fairaudit.tables.binning import Bins
from fairaudit.tables.columns import label_codes
from fairaudit.tables.engines.contents import digests_of
from fairaudit.tables.engines.files import columns_in
from fairaudit.tables.engines.logs import Engine, counted_log, log_request
from fairaudit.tables.engines.paths import expand
from fairaudit.tables.engines.request import Report, Request
from fairaudit.tables.engines.tally_files import KEY, Said
from fairaudit.tables.sources import SameContent, Source, is_database, source_name
from fairaudit.tables.tally import Tally, merged
from fairaudit.tables.values import MARK, held_columns, locator, names

__all__ = ["COUNT", "check_ending", "tally"]

COUNT = "n"
"""What the column of counts is called where nobody says it."""

BLOCK = 1 << 24  # bytes of a file that are copied at a time


@answered
def tally(
    source: Source,
    output: str | os.PathLike[str],
    columns: str | Sequence[str],
    *,
    bins: Mapping[str, Sequence[Number] | Bins] | None = None,
    count: str = COUNT,
    engine: Engine = "auto",
    table: str | None = None,
    query: str | None = None,
    memory: str | None = None,
    report: Report | None = None,
    meanwhile: Callable[[], object] | None = None,
    skip: int = 0,
    same_content: SameContent = "refuse",
    encoding: str | None = None,
) -> Tally:
    """Count the equal rows of a log, and write the counts to a file, so that this part of a longer log is never read again.

    `audit` takes such files together, with `count`, for the whole log: its certificate is that of all rows, byte for byte.

    Parameters
    ----------
    source : path, sequence of paths, URL or frame
        What `read_log` reads, except logs of evaluations, whose certificates say more of each answer than how often it was given.
    output : path
        The file, FILE.parquet.
    columns : str or sequence of str
        The columns that an audit may ask for: decision, groups, contexts, true label. Whoever asks for fewer gets sums.
    bins : mapping of str to sequence of number, optional
        Numeric columns to cut into intervals at these edges; the file says so, and with it the certificate.
    count : str
        What the column of the counts is called; none of the log may be called so.
    engine, table, query, memory, report, meanwhile, skip, same_content, encoding
        As for `read_log`. The file has the digests of the files that were counted, so that none of them is counted again beside it.

    Returns
    -------
    Tally
        What was written: each column as texts of labels, None where one is missing.

    Raises
    ------
    InputError
        If the log cannot be read, the file cannot be written, or a column holds texts as well as numbers.

    Examples
    --------
    >>> import fairaudit as fa
    >>> import tempfile
    >>> folder = Path(tempfile.mkdtemp())
    >>> monday = {"hired": ["yes", "no", "yes"], "sex": ["f", "m", "m"]}
    >>> tuesday = {"hired": ["no", "no"], "sex": ["f", "m"]}
    >>> import pandas as pd
    >>> for day, log in (("monday", monday), ("tuesday", tuesday)):
    ...     print(fa.tally(pd.DataFrame(log), folder / f"{day}.parquet", ["hired", "sex"]).rows)
    3
    2
    >>> days = [folder / "monday.parquet", folder / "tuesday.parquet"]
    >>> result = fa.audit(days, decision="hired", group="sex", count="n", utility="yes")
    >>> result.global_.ratio
    Fraction(3, 2)
    """
    check_ending(output)
    wanted = names(columns)
    if len({name.casefold() for name in (*wanted, count)}) < len(wanted) + 1:
        raise InputError(_alike(wanted, count))
    where = {"table": table, "query": query, "memory": memory, "report": report, "meanwhile": meanwhile, "skip": skip}
    where |= {"same_content": same_content, "encoding": encoding}
    request = log_request(wanted, bins, **where, evaluations=False)
    files = _files(source)
    states, digests = _states(files), digests_of(files)
    found = counted_log(source, request, engine)
    _refuse_counts(source, files, skip, count)
    if _states(files) != states:
        raise InputError(f"{source_name(source)} changed while it was counted; count it when nobody writes there")
    made, said = _of_texts(found, count)
    said = replace(said, sources=digests)
    write_atomically(Path(output), _parquet(made, said))
    return made


def _files(source: Source) -> list[str]:
    """The files of a log; of a database, a folder, a pipe or a frame none."""
    named = [source] if isinstance(source, (str, os.PathLike)) else source if isinstance(source, (list, tuple)) else []
    names_ = [os.fspath(name) for name in named if isinstance(name, (str, os.PathLike))]
    listed = expand([name for name in names_ if not is_database(name) or os.path.exists(name)])  # noqa: PTH110
    return [path for path in listed if os.path.isfile(path)]  # noqa: PTH113


def _refuse_counts(source: Source, files: Sequence[str], skip: int, count: str) -> None:
    """Refuse a log that has a column of the name of the counts already: if it holds counts, they would be ignored.

    Raises
    ------
    InputError
        If the columns can be known without reading the log, and this is one of them.
    """
    known = {source_name(path): columns_in(path, skip) for path in files} or {"the table": held_columns(source)}
    for name, columns in known.items():
        for column in columns:
            if column.casefold() == count.casefold():
                raise InputError(
                    f"{name} has a column {shown(column)}, and a tally counts each row once, whatever stands there; if it holds counts, "
                    "certify the table itself with that column as its count, else call the counts otherwise with count (--count NAME)"
                )


def _states(files: Sequence[str]) -> list[tuple[int, int]]:
    return [(found.st_size, found.st_mtime_ns) for found in map(os.stat, files)]


def check_ending(output: str | os.PathLike[str]) -> None:
    """Refuse a file of counts that is not called FILE.parquet.

    Raises
    ------
    InputError
        If it is not.
    """
    if Path(output).suffix.lower() != ".parquet":
        raise InputError(f"{os.fspath(output)} does not end in .parquet, as a tally does; name a file FILE.parquet")


def _alike(wanted: Sequence[str], count: str) -> str:
    """Say which two columns of a file would have one name, in which Parquet readers tell no capitals apart."""
    for place, name in enumerate(wanted):
        if name.casefold() == count.casefold():
            return f"{shown(name)} is a column of the log, and would be that of the counts; call them otherwise with count (--count NAME)"
        for other in wanted[:place]:
            if name == other:
                return f"the column {shown(name)} is named twice; name each column once"
            if name.casefold() == other.casefold():
                return (
                    f"the columns {shown(other)} and {shown(name)} differ in capitals alone, which a tally does not tell apart; rename one"
                )
    raise AssertionError(wanted)


def _of_texts(found: Tally, count: str) -> tuple[Tally, Said]:
    """The counts by texts of labels, with missing ones as None, sorted; and what the file says of itself."""
    coded = label_codes(found, found.columns, locator(found))
    codes, levels, values = {}, {}, {}
    for name, (own, texts) in zip(found.columns, coded, strict=True):
        kinds = {isinstance(value, str) for value in found.levels[name] if value is not None and not _is_blank(value)}
        if len(kinds) > 1:
            raise InputError(
                f"column {shown(name)} holds texts as well as numbers or truth values, which a tally does not tell apart; make the column "
                "of one type"
            )
        values[name] = "none" if not kinds or not texts else "texts" if kinds.pop() else "values"
        order = sorted(range(len(texts)), key=texts.__getitem__)
        rank = np.empty(len(texts) + 1, dtype=np.int64)
        rank[order], rank[-1] = np.arange(len(texts)), len(texts)
        codes[name], levels[name] = rank[own], [*(texts[place] for place in order), None]
    made = replace(merged(replace(found, codes=codes, levels=levels)), find=None)
    return made, Said(count, made.preparation, values)


def _is_blank(value: object) -> bool:
    return isinstance(value, str) and not value.strip()


def _parquet(made: Tally, said: Said) -> Iterator[bytes]:
    """The bytes of a Parquet file."""
    from fairaudit.tables.engines.duckdb import connected, literal, told
    from fairaudit.tables.sql import identifier

    held: dict[str, Any] = {f"c{i}": np.array(made.levels[name], dtype=object)[made.codes[name]] for i, name in enumerate(made.columns)}
    listed = [f"cast(c{i} as varchar) as {identifier(name, 'duckdb')}" for i, name in enumerate(made.columns)]
    listed.append(f"cast(n as bigint) as {identifier(said.count, 'duckdb')}")
    listed.append(f"true as {identifier(MARK, 'duckdb')}")
    request = Request((), {})
    with tempfile.TemporaryDirectory(prefix="fairaudit-") as folder, connected(request) as connection, told(request, "the tally"):
        path = Path(folder) / "tally.parquet"
        connection.execute("set preserve_insertion_order = true")
        connection.register("tally", {**held, "n": made.counts})
        options = f"format parquet, compression zstd, kv_metadata {{{literal(KEY)}: {literal(said.text)}}}"
        connection.execute(f"copy (select {', '.join(listed)} from tally) to {literal(str(path))} ({options})")  # noqa: S608
        with path.open("rb") as file:
            while block := file.read(BLOCK):
                yield block
