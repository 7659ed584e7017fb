"""Dead letters: lines that cannot be counted, why, how many, and the file where they are kept."""

from __future__ import annotations

import json
import os
from pathlib import Path
from typing import Any

from fairaudit.errors import InputError

SHOWN = 2_000  # bytes of a line that are kept: more than a decision needs, and a log of binary data fills no disk

UNREADABLE, MISSING, UNUSABLE, UNKNOWN = "unreadable line", "missing label", "unusable value", "unknown reason"


def reasons(tally: dict[str, Any], alarm: dict[str, Any] | None = None) -> dict[str, int]:
    """How many lines could not be counted so far, or when an alarm was raised, by reason.

    Examples
    --------
    >>> reasons({"dead": 5, "reasons": {"unreadable line": 3}})
    {'unreadable line': 3, 'unknown reason': 2}
    """
    known = tally if alarm is None or "dead" not in alarm else alarm
    listed = known.get("reasons", {})
    counts = {reason: listed.get(reason, 0) for reason in (UNREADABLE, MISSING, UNUSABLE)}
    counts[UNKNOWN] = known.get("dead", 0) - sum(counts.values())
    return {reason: n for reason, n in counts.items() if n}


class DeadLetters:
    """The file of dead letters, without what was written after the last commit.

    Parameters
    ----------
    path : str
        The file.
    length : int
        How long it was at the last commit.
    earlier : str or None
        Which file that was, links resolved; another one is only appended to.

    Attributes
    ----------
    path : str
        The file, links resolved.

    Raises
    ------
    InputError
        If the file cannot be written.
    """

    def __init__(self, path: str, length: int, earlier: str | None) -> None:
        self.path = os.path.realpath(path)
        try:
            self._file = Path(path).open("ab")  # noqa: SIM115
            if earlier == self.path and self._file.tell() > length:
                self._file.truncate(length)
                self._file.seek(0, os.SEEK_END)
        except OSError as error:
            raise InputError(f"{path} cannot be written: {error.strerror or error}") from None

    @property
    def length(self) -> int:
        """Bytes that were written."""
        return self._file.tell()

    def write(self, line: int, reason: str, text: bytes) -> None:
        """Keep a line, with its number and why it cannot be counted."""
        entry = {"line": line, "reason": reason, "text": text[:SHOWN].decode("utf-8", "backslashreplace")}
        self._file.write(json.dumps(entry).encode("ascii") + b"\n")

    def flush(self) -> int:
        """Hand everything to the system, and say how long the file is."""
        self._file.flush()
        return self._file.tell()

    def close(self) -> None:
        """Close the file."""
        self._file.close()
