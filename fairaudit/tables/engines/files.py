"""Files: who reads them."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

from fairaudit.errors import InputError
from fairaudit.tables.binning import apply_bins
from fairaudit.tables.csv import layout
from fairaudit.tables.engines.contents import refuse_twice
from fairaudit.tables.engines.converted import converted, format_of_file, refuse_another_format
from fairaudit.tables.engines.databases import listed, tables_of
from fairaudit.tables.engines.paths import SMALL, Form, expand, form, read_text, regular
from fairaudit.tables.engines.request import FOR_CERTIFY, Request
from fairaudit.tables.evaluations.paths import is_path
from fairaudit.tables.tally import Tally

if TYPE_CHECKING:
    from fairaudit.tables.engines.survey import Survey
    from fairaudit.tables.evaluations.samples import Format

__all__ = ["columns_in", "read", "survey"]


def columns_in(path: str, skip: int = 0) -> Sequence[str]:
    """The columns of a file whose beginning or end names them; none where only its reader knows them."""
    kind = form(path)
    if kind == "parquet":
        from fairaudit.tables.engines.nested import columns_of

        return [*columns_of(path, Request((), {}))]
    try:
        return layout(path).columns if kind == "csv" and not skip else ()
    except InputError:
        return ()  # which the reader says


def read(sources: Sequence[str], request: Request, engine: str) -> Tally:
    """Count the rows of files."""
    named = expand(sources)
    with regular(named) as found:
        log = _samples_of(found, request)
        told_apart = log is not None and (bool(log.key) or "file" in request.columns)  # or refused sample by sample
        said = refuse_twice(found, "accept" if told_apart else request.same_content, dict(zip(found, named, strict=True)))
        tally = _read(found, log, request, engine)
        return replace(tally, notes=(*said, *tally.notes)) if said and not told_apart else tally


def _read(found: list[str], log: Format | None, request: Request, engine: str) -> Tally:
    if log is not None:
        from fairaudit.tables.evaluations.reading import read as count

        return apply_bins(count(found, log, request.wanted), request.bins)
    with _files(found, request, engine) as (paths, kind, own):
        if kind == "delta":
            from fairaudit.tables.engines import delta

            return delta.read(paths[0], request)
        if own:
            return read_text(paths, request)
        from fairaudit.tables.engines import duckdb

        return duckdb.read_files(paths, kind, request)


def _samples_of(paths: Sequence[str], request: Request) -> Format | None:
    """How files are read sample by sample; None if they are tables."""
    asked = request.extraction
    known = _known_format(paths, asked.log_format)
    if known is not None and not request.evaluations:
        raise InputError(f"{paths[0]}: {FOR_CERTIFY}")
    if known is not None:
        return known
    if not asked.given and not any(map(is_path, request.columns)):
        return None
    kinds = {form(path) for path in paths}
    if kinds == {"json"}:
        from fairaudit.tables.evaluations.json_rows import ROWS

        return ROWS
    if kinds == {"parquet"}:
        from fairaudit.tables.engines.nested import columns_of, nested_rows

        flat = not asked.given and {*request.columns} <= columns_of(paths[0], request).keys()
        return None if flat else nested_rows(request)
    asked.refuse(f"{paths[0]}, which is {form(paths[0])}")
    return None


def _known_format(paths: Sequence[str], named: str | None) -> Format | None:
    """The format of evaluation logs, by its name or by their content."""
    if named is not None:
        from fairaudit.tables.evaluations.detection import FORMATS

        for path in paths:
            refuse_another_format(path, named)
        return FORMATS[named]
    found = {path: format_of_file(path) for path in paths}
    first = found[paths[0]]
    for path, other in found.items():
        if other is not first:
            names = ("no log of an evaluation" if log is None else f"a log of {log.name}" for log in (other, first))
            raise InputError(f"{path} is {next(names)} and {paths[0]} is {next(names)}; logs that are read together have one format")
    return first


def survey(sources: Sequence[str], request: Request, engine: str) -> Survey:
    """Look at every column of files."""
    from fairaudit.tables.engines import survey as of

    named = expand(sources)
    with regular(named) as found:
        log = _samples_of(found, request) or _objects(found, request)
        refuse_twice(found, request.same_content if log is None else "accept", dict(zip(found, named, strict=True)))
        if log is not None:
            return of.of_samples(found, log, request)
        with _files(found, request, engine) as (paths, kind, own):
            if kind == "delta":
                from fairaudit.tables.engines import delta

                return delta.survey(paths[0], request)
            return of.of_text(paths, request) if own else of.of_files(paths, kind, request)


def _objects(paths: Sequence[str], request: Request) -> Format | None:
    """How files are read row by row whose columns hold objects or lists; None if they are tables."""
    kind = form(paths[0])
    if kind == "json":
        from fairaudit.tables.evaluations.json_rows import ROWS, json_rows
        from fairaudit.tables.evaluations.listing import nested

        try:
            return ROWS if nested(row for _, row in json_rows(paths[0])) else None
        except InputError:
            return None  # what is wrong is said by the reader of tables
    if kind == "parquet":
        from fairaudit.tables.engines.nested import NESTED, columns_of, nested_rows

        return nested_rows(request) if any(map(NESTED.match, columns_of(paths[0], request).values())) else None
    return None


def _named(path: str, kind: Form) -> str:
    """How a database file and its table are named in a command; where there are several, or none can be seen, with a word for it."""
    import shlex

    try:
        found = tables_of(f"{kind}:{path}")
    except InputError:
        found = []
    held = f" (it holds {listed(found)})" if len(found) > 1 else ""
    return f"{shlex.join([f'{kind}:{path}', '--table', found[0] if len(found) == 1 else 'NAME'])}{held}"


@contextmanager
def _files(found: list[str], request: Request, engine: str) -> Iterator[tuple[list[str], Form, bool]]:
    """Find the files and what they hold, and say whether our own reader reads them."""
    with converted(found, request) as (paths, copied):
        kinds = {path: form(path) for path in paths}
        kind = kinds[paths[0]]
        for path, other in kinds.items():
            if other != kind:
                raise InputError(f"{path} is {other} and {paths[0]} is {kind}; files that are read together have one format")
        if kind == "delta":
            if len(paths) > 1 or engine != "auto":
                raise InputError(
                    f"{paths[0]} is a Delta table, which is read on its own and by its library; name it alone, without --engine"
                )
            yield paths, kind, False
            return
        if kind in ("sqlite", "duckdb"):
            raise InputError(f"{paths[0]} is a database; name it as {_named(paths[0], kind)}")
        for name in ("table", "query"):
            if getattr(request, name) is not None and not (copied and name == "table"):
                raise InputError(f"a {name} goes with a database, such as sqlite:decisions.db; {paths[0]} is {kind}")
        small = kind == "csv" and sum(Path(path).stat().st_size for path in paths) <= SMALL
        if engine == "python" and kind != "csv":
            raise InputError(f"the engine 'python' reads delimited text; {paths[0]} is {kind}")
        # What finds the line of a row in a text of any size reads the text again, and a copy is gone by then.
        yield paths, kind, engine == "python" or (engine == "auto" and small) or (copied and kind == "csv")
