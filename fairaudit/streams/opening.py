"""`monitor`: a log of decisions watched as it grows, by settings that are fixed before the first decision is read."""

from __future__ import annotations

import os
import re
from collections.abc import Mapping, Sequence
from fractions import Fraction
from typing import Any, Literal

from fairaudit.errors import InputError, kind_of, shown
from fairaudit.exact.rationals import Number, option_value, rational_text
from fairaudit.measures.limits import MEASURED, without_bare_limits
from fairaudit.model.utility import utility_values
from fairaudit.streams.settings import RUN_LENGTH, Settings
from fairaudit.streams.state import State
from fairaudit.streams.stream import Monitor
from fairaudit.tables.sources import SameContent
from fairaudit.tables.values import names

__all__ = ["default_run_length", "greatest", "monitor", "window_length"]

CONFIDENCE: Number = "0.95"

EXPECTED = 4

UNITS = {"": 1, "s": 1, "m": 60, "h": 3_600, "d": 86_400, "w": 604_800}


@without_bare_limits(MEASURED)
def monitor(
    log: str | os.PathLike[str],
    *,
    state: str | os.PathLike[str] | None = None,
    decision: str | None = None,
    group: str | Sequence[str] = (),
    context: str | Sequence[str] = (),
    utility: Mapping[str, Number] | str | None = None,
    utility_column: str | None = None,
    utility_range: tuple[Number, Number] | None = None,
    utility_step: Number | None = None,
    max_local_ratio: Number | None = None,
    max_global_ratio: Number | None = None,
    max_local_log: Number | None = None,
    max_global_log: Number | None = None,
    confidence: Number = CONFIDENCE,
    expected_cells: int = EXPECTED,
    unit: str | Sequence[str] = (),
    event_id: str | None = None,
    time: str | None = None,
    since: str | None = None,
    window: str | int | None = None,
    log_format: Literal["jsonl", "csv"] | None = None,
    burden: bool = False,
    run_length: int | None = None,
    bets: Literal["separate", "joint"] | None = None,
    pair_by_time: bool = False,
    dead_letters: str | os.PathLike[str] | None = None,
    same_content: SameContent = "refuse",
) -> Monitor:
    r"""Watch a log of decisions, with bounds that hold at every moment, however often one looks; as `fairaudit monitor` does.

    Parameters
    ----------
    log : path
        JSON lines or CSV; more lines may come while it is read.
    state : path, optional
        The SQLite file that keeps the counts, so that the watch is resumed where it ended; in memory by default. A state that is there
        knows its settings: those that are given here must agree, and none need be given.
    decision : str
        Column of the decision; with `utility_column` it is left out.
    group, context : str or sequence of str
        Columns of the sensitive attributes and of the contexts.
    utility : mapping or str
        What decisions are worth: ``{"yes": 1}`` or ``"yes,maybe=0.5"``; others are worth 0.
    utility_column, utility_range, utility_step : str, pair of number, number
        Instead of `utility`: the column that says it, its least and greatest value, and optionally what it is rounded to.
    max_local_ratio, max_global_ratio, max_local_log, max_global_log : number, optional
        Targets, as for `certify`.
    confidence : number
        With which each kind of statement holds at every moment.
    expected_cells : int
        About how many combinations of context and group will appear; any number is sound.
    unit, event_id : str, optional
        In each cell only the first decision of a sampling unit counts; repeats of an event are dropped.
    time, since : str, optional
        Column of the time, and the time from which decisions count.
    window : str or int, optional
        Length of windows: a number of decisions, or a time such as ``"12h"``.
    log_format : {"jsonl", "csv"}, optional
        How the log is written; by the end of its name by default.
    burden : bool
        Whether the utility counts a burden.
    run_length : int, optional
        Pairs of decisions per direction until the detector of change raises a false alarm, in the mean, at least; 0 for no detector.
        By default 20,000 where there is a target and no unit.
    bets : {"separate", "joint"}, optional
        Joint bets, on both cells of a pair at once, are narrower unless utilities are rare; separate ones by default.
    pair_by_time : bool
        Also compare decisions that were made next to each other, pair by pair: a ratio that was too great at some time shows though
        means move with the seasons, and it is said where seasons confound the interval of the whole stream.
    dead_letters : path, optional
        File for lines that cannot be counted.
    same_content : {"refuse", "accept"}
        What becomes of another log that holds, or begins with, what the state has counted; the same file is always refused.

    Returns
    -------
    Monitor
        To be used as ``with monitor(…) as watch:``; ``watch.catch_up()`` reads what there is and says what it shows.

    Raises
    ------
    InputError
        If the log, the state or the settings cannot be used.

    Examples
    --------
    >>> import json, tempfile
    >>> from pathlib import Path
    >>> log = Path(tempfile.mkdtemp()) / "log.jsonl"
    >>> rows = [{"sex": sex, "hired": hired} for sex, hired in [("f", "yes"), ("m", "yes"), ("m", "no")] for _ in range(200)]
    >>> _ = log.write_text("".join(json.dumps(row) + "\n" for row in rows))
    >>> with monitor(log, decision="hired", group="sex", utility="yes", max_local_ratio="5/4") as watch:
    ...     found = watch.catch_up()
    >>> found.events, found.verdict
    (600, 'exceeds')

    References
    ----------
    docs/monitoring.md.
    """
    if not isinstance(log, (str, os.PathLike)):
        raise InputError(f"{kind_of(log)} is no log to watch; give the path of a file")
    limits = {
        "max_local_ratio": max_local_ratio,
        "max_global_ratio": max_global_ratio,
        "max_local_log": max_local_log,
        "max_global_log": max_global_log,
    }
    audit: dict[str, Any] = {
        "decision": decision,
        "utility": utility_values(utility) if isinstance(utility, str) else utility,
        "utility_column": utility_column,
        "utility_range": utility_range,
        "group": names(group),
        "context": names(context),
        "step": None if utility_step is None else _text(utility_step),
        "targets": {name: limit for name, limit in limits.items() if limit is not None},
        "unit": names(unit),
        "event_id": event_id,
        "time": time,
        "since": since,
        "window": None if window is None else window_length(str(window)),
        "burden": burden,
        "pair_by_time": pair_by_time,
    }
    chosen = {"log_format": log_format, "run_length": run_length, "bets": bets}
    settings = None
    if any(audit.values()) or any(value is not None for value in chosen.values()) or (expected_cells, confidence) != (EXPECTED, CONFIDENCE):
        layout = log_format or ("csv" if os.fspath(log).endswith(".csv") else "jsonl")
        audit |= {"layout": layout, "run_length": run_length, "bets": bets or "separate"}
        settings = _settings(**audit, confidence=_text(confidence), expected=expected_cells)
    held = State(None if state is None else os.fspath(state), settings)
    try:
        return Monitor(held, os.fspath(log), None if dead_letters is None else os.fspath(dead_letters), same_content)
    except InputError:
        held.close()
        raise


def _settings(
    *,
    decision: str | None,
    utility: Mapping[str, Number] | None,
    utility_column: str | None,
    utility_range: tuple[Number, Number] | None,
    run_length: int | None,
    **others: Any,
) -> Settings:
    if (utility is None) == (utility_column is None):
        raise InputError("give one of utility, such as {'yes': 1}, and utility_column")
    if utility_column is not None and (decision is not None or utility_range is None):
        raise InputError("utility_column takes the place of decision, and needs utility_range, such as (0, 1)")
    column = decision or utility_column
    if column is None:
        raise InputError("no decision column was named; give decision, the name of the column")
    low, high = ("0", greatest(utility or {})) if utility_range is None else map(_text, utility_range)
    values = None if utility is None else {label: _text(value) for label, value in utility.items()}
    length = default_run_length(run_length, others["targets"], others["unit"])
    return Settings(decision=column, utility=values, low=low, high=high, run_length=length, **others)


def default_run_length(given: int | None, targets: Mapping[str, Any], unit: Sequence[str]) -> int:
    """The run length that is given, or that of a detector wherever one has something to ask.

    Examples
    --------
    >>> default_run_length(None, {"max_local_ratio": "5/4"}, ()), default_run_length(None, {}, ()), default_run_length(500, {}, ())
    (20000, 0, 500)
    """
    return (RUN_LENGTH if targets and not unit else 0) if given is None else given


def _text(value: Number) -> str:
    return value if isinstance(value, str) else rational_text(option_value(value))


def greatest(utility: Mapping[str, Number]) -> str:
    """The greatest of the utilities that are listed, as a text; 1 if none is.

    Examples
    --------
    >>> greatest({"yes": 1, "maybe": "0.5"}), greatest({})
    ('1', '1')
    """
    return str(max((Fraction(*option_value(value)) for value in utility.values()), default=Fraction(1)))


def window_length(text: str, name: str = "window") -> str:
    """Read the length of windows, as the settings have it.

    Raises
    ------
    InputError
        If it is neither a number of decisions nor a time.

    Examples
    --------
    >>> window_length("1000"), window_length("2h"), window_length("7d")
    ('1000', '7200s', '604800s')
    """
    match = re.fullmatch("([1-9][0-9]{0,11})([smhdw]?)", text)
    if match is None:
        raise InputError(f"{name} {shown(text)} is not accepted; a number of decisions such as 10000, or a time such as 12h or 7d, is")
    number, unit = match.groups()
    return f"{int(number) * UNITS[unit]}s" if unit else number
