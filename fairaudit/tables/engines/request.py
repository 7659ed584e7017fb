"""What is asked of an engine: columns, intervals and where the log is; and the work in a thread that can be watched and interrupted."""

from __future__ import annotations

import threading
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any, Literal, TypeVar

from fairaudit.errors import InputError
from fairaudit.tables.binning import Bins
from fairaudit.tables.evaluations.extraction import NOTHING_ASKED, Extraction, Wanted
from fairaudit.tables.number_form import PLAIN, NumberForm
from fairaudit.tables.sources import SameContent
from fairaudit.tables.sql import table_name

__all__ = ["FOR_CERTIFY", "SAME_ROWS", "PartsMissing", "Request", "attended", "database_source"]

FOR_CERTIFY = "an evaluation log is audited by certify, and its certificate says which answers were lost"

SAME_ROWS = "store the rows in a table first, if they change from one run to the next; else give them as a CSV or Parquet file"
"""What to do where an engine counts fewer rows than it reads, and a query or a view may give others each time."""


Report = Callable[[float | None, int | None], None]

PartsMissing = Literal["error", "drop", "group"]
"""What an empty label may mean where contexts are read in parts."""

T = TypeVar("T")


@dataclass(frozen=True)
class Request:
    """What is wanted of an engine.

    Attributes
    ----------
    columns : tuple of str
        The columns that tell rows apart.
    bins : dict of str to Bins
        Numeric columns among them to cut into intervals.
    table, query : str or None
        Of a database, the table or the query that gives the log.
    memory : str or None
        How much memory the engine may use before it spills to disk, such as ``2GB``.
    report : callable or None
        Told how far the work is: a share of it, or a number of rows.
    meanwhile : callable or None
        Run once beside the engine's work.
    most : int or None
        How many different rows may come back from DuckDB, where more can be read in parts.
    by : tuple of str
        The columns whose values those parts would keep together.
    skip : int
        How many lines stand above the header of a text or a spreadsheet.
    decision : str or None
        Which of the columns is the decision.
    group, unit : tuple of str
        Which of them are groups, and which the sampling unit.
    count : str or None
        Which of them says how many decisions a row stands for; of a log that is read in parts it is none of them.
    missing : {"error", "drop", "group"}
        Of a log that is read in parts, what an empty label means.
    extraction : Extraction
        What is asked of an evaluation log beyond columns.
    evaluations : bool
        Whether evaluation logs are read; else they are refused.
    same_content : {"refuse", "accept"}
        What becomes of several files with the same content.
    encoding : str or None
        How the characters of a text are written, where that is not UTF-8.
    form : NumberForm
        How numbers are written in the texts of a spreadsheet; those of other tables are read later.
    numeric : tuple of str
        Which of the columns hold numbers.
    """

    columns: tuple[str, ...]
    bins: Mapping[str, Bins]
    table: str | None = None
    query: str | None = None
    memory: str | None = None
    report: Report | None = None
    meanwhile: Callable[[], Any] | None = None
    most: int | None = None
    by: tuple[str, ...] = ()
    skip: int = 0
    decision: str | None = None
    group: tuple[str, ...] = ()
    unit: tuple[str, ...] = ()
    count: str | None = None
    missing: PartsMissing = "error"
    extraction: Extraction = NOTHING_ASKED
    evaluations: bool = True
    same_content: SameContent = "refuse"
    encoding: str | None = None
    form: NumberForm = PLAIN
    numeric: tuple[str, ...] = ()

    @property
    def read(self) -> Literal["apart", "once"]:
        """How the rows of a database are counted beside the equal ones: a query, which may give others each time, is asked once."""
        return "apart" if self.query is None else "once"

    @property
    def wanted(self) -> Wanted:
        """What is wanted of the samples of a log."""
        return Wanted(self.columns, self.decision, self.group, self.unit, self.extraction, self.report)


def database_source(request: Request, dialect: str) -> str:
    """Write what a database counts, as it stands after ``from``.

    Raises
    ------
    InputError
        If neither a table nor a query was named.
    """
    if request.table is not None:
        return table_name(request.table, dialect)
    if request.query is None:
        raise InputError("a database holds several tables; name one with table (--table), or give a query (--query)")
    return f"({request.query.strip().rstrip(';')}\n) as log"


def attended(work: Callable[[], T], interrupt: Callable[[], Any], request: Request, share: Callable[[], float | None] | None = None) -> T:
    """Run an engine's work in a thread, so that it can be watched and interrupted.

    Parameters
    ----------
    work : callable
        The work.
    interrupt : callable
        Makes the engine give the work up.
    request : Request
        Whose `report` is told how far the work is, and whose `meanwhile` runs beside it.
    share : callable, optional
        Says how much of the work is done, from 0 to 1.
    """
    done: list[T] = []
    failed: list[BaseException] = []
    ended = threading.Event()  # an interrupted Thread.join would take the thread for ended

    def run() -> None:
        try:
            done.append(work())
        except BaseException as error:
            failed.append(error)
        finally:
            ended.set()

    threading.Thread(target=run, name="fairaudit-engine", daemon=True).start()
    try:
        if request.meanwhile is not None:
            request.meanwhile()
        while not ended.wait(0.1):
            if request.report is not None:
                request.report(share() if share is not None else None, None)
    except BaseException:
        interrupt()
        ended.wait(30)
        raise
    if failed:
        raise failed[0]
    return done[0]
