"""What is in a log: for every column its most common labels, counted where the log is held; however many rows, few values travel back."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from fairaudit.errors import InputError, shown
from fairaudit.tables.csv import count_csv, layout
from fairaudit.tables.engines.tally_files import said_by
from fairaudit.tables.label_text import label_text
from fairaudit.tables.sql import Written, common_statement

if TYPE_CHECKING:
    from fairaudit.tables.engines.paths import Form
    from fairaudit.tables.engines.request import Request
    from fairaudit.tables.evaluations.samples import Format

__all__ = ["MOST", "Samples", "Seen", "Survey", "of_database", "of_files", "of_samples", "of_text", "read_first"]

MOST = 10_000  # different labels of a column that are held; a column with more is no column of labels


@dataclass(frozen=True)
class Seen:
    """What a column holds.

    Attributes
    ----------
    name : str
        Its name.
    levels : dict of str to int
        Its labels with their counts, the most common first; of many different values the `MOST` most common.
    different : int
        How many different values there are that are not missing; of samples `MOST` + 1 where there are more than `MOST`.
    missing : int
        How many rows have no label in it.
    fault : str
        Why it cannot serve as labels; empty if it can.
    """

    name: str
    levels: dict[str, int]
    different: int
    missing: int
    fault: str = ""


@dataclass(frozen=True)
class Samples:
    """What is known of a log of an evaluation beside its columns, which are paths then.

    Attributes
    ----------
    format : str
        Name of the format; empty for rows with objects and lists.
    decision : str or None
        The path where the decision usually is.
    unit : str
        The path of what names a question, where each was asked several times or of several models (``PATH`` if nobody knows); else empty.
    errors : int
        How many samples ended in an error.
    where : tuple of str
        Conditions without which samples would be counted several times, such as ``filter=first``.
    technical : frozenset of str
        Paths that are hardly a decision, a group, a context or a unit.
    question : str
        The path of what names a question; empty where none does.
    short : bool
        Whether the log holds fewer samples than it should.
    never_read : frozenset of str
        What stands where the decision does only in samples that have no answer, or one that decides nothing.
    """

    format: str
    decision: str | None
    unit: str
    errors: int
    where: tuple[str, ...] = ()
    technical: frozenset[str] = frozenset()
    question: str = ""
    short: bool = False
    never_read: frozenset[str] = frozenset()


@dataclass(frozen=True)
class Survey:
    """The columns of a log, its rows, and what was noticed while reading.

    Examples
    --------
    >>> found = Survey.of(["sex"], lambda name: [("f", 3, 3, 9), (None, 4, 3, 9), (" ", 2, 3, 9)])
    >>> found.rows, found.columns[0].levels, found.columns[0].different, found.columns[0].missing
    (9, {'f': 3}, 1, 6)
    """

    rows: int
    columns: tuple[Seen, ...]
    notes: tuple[str, ...] = ()
    samples: Samples | None = None

    @staticmethod
    def of(names: Sequence[str], common: Callable[[str], Iterable[Sequence[Any]]], notes: tuple[str, ...] = ()) -> Survey:
        """Collect what `common` says of each column: rows as `common_statement` gives them."""
        rows, columns = 0, []
        for name in names:
            levels: dict[str, int] = {}
            missing = absent = fetched = different = 0
            try:
                for value, count, different, total in common(name):  # noqa: B007
                    rows, fetched, text = int(total), fetched + 1, label_text(value)
                    if text is None:
                        missing, absent = missing + int(count), absent + 1
                    else:
                        levels[text] = levels.get(text, 0) + int(count)
            except InputError as error:
                columns.append(Seen(name, {}, 0, 0, str(error)))
                continue
            ranked = dict(sorted(levels.items(), key=lambda item: (-item[1], item[0])))
            columns.append(Seen(name, ranked, len(ranked) if fetched == different else int(different) - absent, missing))
        return Survey(rows, tuple(columns), notes)


def of_samples(paths: Sequence[str], log: Format, request: Request) -> Survey:
    """Look at the paths of a log of samples."""
    from fairaudit.tables.evaluations.listing import MOST, listing
    from fairaudit.tables.evaluations.samples import VERBS

    found = listing(paths, log, request.report)
    seen = tuple(
        Seen(name, dict(leaf.levels.most_common()), len(leaf.different), found.samples - leaf.seen, leaf.fault)
        for name, leaf in found.leaves.items()
    )
    notes = [f"{found.left_out} further paths are not listed"] if found.left_out else []
    said = [f"{found.outcomes[name]} {words}" for name, words in VERBS.items() if found.outcomes[name]]
    expected = [run.expected for run in found.runs]
    wanted = found.samples if None in expected else sum(map(int, filter(None, expected)))
    if wanted != found.samples:
        said.insert(0, f"there should be {wanted}")
    if said:
        notes.append(f"of {found.samples} samples {', '.join(said)}")
    again = max(run.epochs for run in found.runs) > 1 or len({run.model for run in found.runs}) > 1
    repeated = {path: found.leaves[path].levels for path in (*log.single, *log.apart) if path in found.leaves}
    where = tuple(f"{path}={next(iter(levels))}" for path, levels in repeated.items() if len(levels) > 1)
    asked = None if where else found.leaves.get(log.question)
    again = again or (asked is not None and len(asked.different) < min(asked.seen, MOST + 1))
    unit = "PATH" if log.name and not log.question else log.question if again else ""
    short = wanted > found.samples
    answer = found.answer(log)
    unread = frozenset() if answer is None else found.leaves[answer].never_read
    samples = Samples(log.name, answer, unit, found.outcomes["error"], where, found.technical(log), log.question, short, unread)
    return Survey(found.samples, seen, tuple(notes), samples)


def of_text(paths: Sequence[str], request: Request) -> Survey:
    """Look at delimited text, read line by line."""
    try:
        names = layout(paths[0]).columns
    except InputError as error:
        raise InputError(f"{paths[0]}: {error}") from None
    told = request.report
    tally = count_csv(paths, names, None if told is None else lambda rows: told(None, rows))

    def common(name: str) -> list[tuple[Any, int, int, int]]:
        counts = np.bincount(tally.codes[name], weights=tally.counts).astype(np.int64).tolist()
        return [(value, count, len(counts), tally.rows) for value, count in zip(tally.levels[name], counts, strict=True)]

    return Survey.of(names, common, tally.notes)


def of_files(paths: Sequence[str], kind: Form, request: Request) -> Survey:
    """Look at files by DuckDB."""
    from fairaudit.tables.engines import duckdb as engine

    if kind == "csv":
        return _of_csv(paths, request)
    if kind == "parquet":
        with engine.connected(request) as connection, engine.told(request, paths[0]):
            listed = engine.literals(map(engine.literal_path, paths))
            source = f"read_parquet({listed})"
            if (said := said_by(connection, paths, listed, request.same_content)) is not None:
                columns = ", ".join(map(shown, said.values))
                raise InputError(f"{paths[0]} is a tally of the columns {columns}; certify takes it with count (--count {said.count})")
            return _of_source(connection, source, request, engine.parquet_faults(connection, paths, _types(connection, source)))
    form, lines = engine.json_form(paths)
    with engine.connected(request) as connection:
        try:
            with engine.told(request, paths[0]):
                names = list(_types(connection, f"read_json({form}, sample_size=-1, maximum_depth=1, map_inference_threshold=-1)"))
                return _of_source(connection, engine.json_texts(form, names), request)
        except InputError as error:
            raise InputError((engine.bad_json(paths) if lines else None) or str(error)) from None


def of_database(path: str, request: Request) -> Survey:
    """Look at a table, or the result of a query, of a DuckDB database file."""
    from fairaudit.tables.engines import duckdb as engine
    from fairaudit.tables.engines.request import database_source

    if not Path(path).is_file():
        raise InputError(f"{path}: there is no such file")
    source = database_source(request, "duckdb")
    with engine.connected(request, path) as connection, engine.told(request, path):
        engine.one_statement(connection, source)
        return _of_source(connection, source, request)


def _of_csv(paths: Sequence[str], request: Request) -> Survey:
    """Look at delimited text by DuckDB where it reads the text as the CSV reader does, else by that."""
    from fairaudit.tables.engines import duckdb as engine

    text = engine.delimited_text(paths)
    if text is None:
        return of_text(paths, request)
    try:
        with engine.connected(request) as connection, engine.told(request, paths[0]):
            seen = _of_source(connection, text.source, request)
    except InputError:
        return of_text(paths, request)  # which says on which line something is wrong
    if not text.complete(seen.rows):
        return of_text(paths, request)
    named = (replace(column, name=name) for column, name in zip(seen.columns, text.layout.columns, strict=True))
    return Survey(seen.rows, tuple(named), text.layout.notes)


def _of_source(connection: Any, source: str, request: Request, faults: Mapping[str, str] | None = None) -> Survey:
    """Look at what stands after ``from`` in DuckDB; some columns may be known to be at fault."""
    from fairaudit.tables.engines import duckdb as engine
    from fairaudit.tables.engines.request import attended

    types = _types(connection, source)

    def common(name: str) -> Iterable[Sequence[Any]]:
        if faults and name in faults:
            raise InputError(f"column {shown(name)} {faults[name]}")
        kind = engine.writing(types[name], name)
        found = engine.fetched_rows(connection.execute(common_statement(name, source, "duckdb", MOST, kind)))
        return read_first(found, name, kind)

    return attended(lambda: Survey.of(list(types), common), connection.interrupt, request, lambda: engine.progress(connection))


def read_first(rows: Iterable[Sequence[Any]], name: str, kind: Written) -> Iterator[Sequence[Any]]:
    """Make values of what a statement has written in the first column of its result."""
    for value, *rest in rows:
        try:
            yield (value if kind.read is None else kind.read(value), *rest)
        except InputError as error:
            raise InputError(f"column {shown(name)}: {error}") from None


def _types(connection: Any, source: str) -> dict[str, str]:
    return {name: str(kind) for name, kind, *_ in connection.execute(f"describe select * from {source}").fetchall()}  # noqa: S608
