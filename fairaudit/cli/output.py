"""What a command found, and the one place that prints it: as text for people, or as one JSON envelope for programs."""

from __future__ import annotations

import json
import os
import sys
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import closing, contextmanager
from decimal import Decimal
from fractions import Fraction
from pathlib import Path
from typing import Any, NamedTuple

__all__ = ["Answer", "add_format", "aligned", "envelope", "in_colour", "is_json", "note", "put", "ready", "rewritten", "silence", "tell"]


class Answer(NamedTuple):
    """What a command found. Only what is asked for is made.

    Attributes
    ----------
    command : str
        Names the format of the result: ``fairaudit-<command>/1``.
    result : callable
        Gives what JSON says; rationals and decimals in it are written exactly.
    text : callable
        Gives what a person reads; nothing is printed where it is empty.
    verdict : str
        Of the targets; "none" if the command judges none, or there is none.
    sentence : str
        The answer in one sentence.
    notes : sequence of str
        What happened to the input, one sentence each.
    code : int
        The exit code.
    details : callable, optional
        Gives what stands beside a result that is a document of its own.
    """

    command: str
    result: Callable[[], Any]
    text: Callable[[], str]
    verdict: str = "none"
    sentence: str = ""
    notes: Sequence[str] = ()
    code: int = 0
    details: Callable[[], dict[str, Any]] | None = None


def add_format(parser: Any) -> None:
    """Declare the option `--format` of a command that prints an answer."""
    parser.add_argument("--format", choices=("text", "json"), default="text", help="what to print")


def tell(found: Answer | Iterator[Answer] | int, form: str | None) -> int:
    """Print what a command found, and give the exit code; of several answers, each as soon as it comes, that of the last.

    Parameters
    ----------
    found : Answer, iterator of Answer, or int
        What `run` of a command gave: an exit code, where nothing is left to print.
    form : {"text", "json"}, optional
        By default text on a terminal, else JSON.
    """
    if isinstance(found, int):
        return found
    if isinstance(found, Answer):
        said = _said(found, form, indent=1)
        _say_notes(found, form)
        if said:
            put(said)
        return found.code
    code = 0
    with closing(found) as answers:  # type: ignore[type-var]
        for answer in answers:
            said = _said(answer, form, indent=None)
            _say_notes(answer, form)
            if said:
                print(said, flush=True)
            code = answer.code
    return code


def envelope(found: Answer) -> dict[str, Any]:
    """An answer as JSON has it; the numbers are still to be written by `written`."""
    return {
        "format": f"fairaudit-{found.command}/1",
        "verdict": found.verdict,
        "sentence": found.sentence,
        "notes": list(found.notes),
        "result": found.result(),
        **({"details": found.details()} if found.details is not None else {}),
    }


def in_colour() -> bool:
    """Whether texts may have colours: on a terminal, where nobody has switched them off (https://no-color.org)."""
    return sys.stdout is not None and sys.stdout.isatty() and not os.environ.get("NO_COLOR") and os.environ.get("TERM") != "dumb"


def ready(found: Answer, form: str | None) -> Answer:
    """The same answer, with what will be printed of it already made."""
    if not is_json(form):
        text = found.text()
        return found._replace(text=lambda: text)
    result, details = found.result(), found.details and found.details()
    return found._replace(result=lambda: result, details=None if details is None else lambda: details)


def is_json(form: str | None) -> bool:
    """Whether answers are printed as JSON."""
    if form is None:
        return sys.stdout is None or not sys.stdout.isatty()
    return form == "json"


def _said(found: Answer, form: str | None, *, indent: int | None) -> str:
    if is_json(form):
        return json.dumps(envelope(found), ensure_ascii=True, allow_nan=False, indent=indent, default=_number)
    return found.text()


def _say_notes(found: Answer, form: str | None) -> None:
    if not is_json(form):
        for text in found.notes:
            note(text)


def _number(value: Any) -> str:
    """Write a number that is exact, or an end of a logarithm, as certificates do."""
    from fairaudit.certificates.numbers import log_text, number

    if isinstance(value, Fraction):
        return number(value)
    if isinstance(value, Decimal):
        return log_text(value)
    if isinstance(value, Path):
        return str(value)
    raise TypeError(f"{type(value).__name__} is not written to JSON")


def note(text: str) -> None:
    """Say something beside the answer, to people."""
    from fairaudit.words import plain

    print(f"note: {plain(text)}", file=sys.stderr)


@contextmanager
def rewritten(after: float = 0.0) -> Iterator[Callable[[str], None]]:
    """Say on a terminal how far long work is, on one line that is written anew, at most five times a second, and cleared in the end."""
    from fairaudit.words import plain

    on, last, written = sys.stderr is not None and sys.stderr.isatty(), time.monotonic() + after, False

    def say(text: str) -> None:
        nonlocal last, written
        if on and time.monotonic() >= last:
            last, written = time.monotonic() + 0.2, True
            sys.stderr.write(f"\r\x1b[K{plain(text)[:120]}")
            sys.stderr.flush()

    try:
        yield say
    finally:
        if written:
            sys.stderr.write("\r\x1b[K")
            sys.stderr.flush()


def put(text: str) -> None:
    """Print a text; where nobody reads on (a closed pager, say) the exit code still tells."""
    try:
        print(text, flush=True)
    except BrokenPipeError:
        silence()


def silence() -> None:
    """Send what is still to be printed nowhere, so that the interpreter does not fail on it when it exits."""
    os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())


def aligned(rows: Sequence[Sequence[str]], indent: str = "") -> str:
    """Rows of a table with columns of equal width."""
    widths = [max(map(len, column)) for column in zip(*rows, strict=True)]
    return "\n".join(f"{indent}{'  '.join(cell.ljust(width) for cell, width in zip(row, widths, strict=True))}".rstrip() for row in rows)
