"""Completion in a shell, by argcomplete: commands, options and choices, and columns and labels of the table that stands on the line.

``eval "$(register-python-argcomplete fairaudit)"`` turns it on, in bash and in zsh; docs/which-command.md says more.
"""

from __future__ import annotations

import argparse
import contextlib
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

__all__ = ["complete"]

MOST = 4_000_000
"""Bytes of a file whose labels are looked at; of a longer text only the header is read, and of anything else nothing."""

LABELS = {"utility": "decision", "undecided": "decision", "positive": "truth", "unknown": "group"}
"""Options that take labels, and the option that names their columns."""

FILES = ("FILE", "TABLE", "LOG", "STATE", "DIR", "CERTIFICATE", "SCAN", ".json", ".csv", ".toml")


def complete(parser: argparse.ArgumentParser, commands: Mapping[str, argparse.ArgumentParser]) -> None:
    """Answer the shell and exit; where argcomplete is not installed, do nothing."""
    try:
        import argcomplete
    except ImportError:
        return
    for command in commands.values():
        for action in command._actions:
            _equip(action)
    argcomplete.autocomplete(parser, always_complete_options=False)


def _equip(action: argparse.Action) -> None:
    """Say what completes an option; files and choices need no word."""
    metavar = action.metavar if isinstance(action.metavar, str) else ""
    if metavar == "COL":
        action.completer = _columns  # type: ignore[attr-defined]
    elif action.dest in LABELS:
        action.completer = _labels  # type: ignore[attr-defined]
    elif action.dest == "example":
        action.completer = _examples  # type: ignore[attr-defined]
    elif action.choices is None and not any(each in metavar for each in FILES):
        action.completer = _nothing  # type: ignore[attr-defined]


def _columns(prefix: str, action: argparse.Action, parsed_args: argparse.Namespace, **_: Any) -> list[str]:
    names = list(_looked_at(parsed_args))
    return _extended(prefix, names) if isinstance(action, argparse._AppendAction) else [name for name in names if name.isprintable()]


def _labels(prefix: str, action: argparse.Action, parsed_args: argparse.Namespace, **_: Any) -> list[str]:
    named = getattr(parsed_args, LABELS[action.dest], None) or []
    columns = {name.strip() for text in ([named] if isinstance(named, str) else named) for name in text.split(",")}
    return _extended(prefix, [label for name, labels in _looked_at(parsed_args).items() if name in columns for label in labels])


def _examples(**_: Any) -> list[str]:
    from fairaudit.tables.examples import EXAMPLES

    return [entry.name for entry in EXAMPLES]


def _nothing(**_: Any) -> list[str]:
    return []


def _extended(prefix: str, words: Sequence[str]) -> list[str]:
    """The list that is begun, with each word that is not in it yet; without those that a shell could not show."""
    from fairaudit.words import quoted

    begun, comma, _ = prefix.rpartition(",")
    there = {part.partition("=")[0] for part in begun.split(",")}
    return [f"{begun}{comma}{quoted(word)}" for word in words if word.isprintable() and word and word not in there]


def _looked_at(arguments: argparse.Namespace) -> dict[str, list[str]]:
    """Columns of the file on the line with their most common labels; nothing where that is not cheap, or it cannot be read."""
    from fairaudit.errors import InputError

    given = getattr(arguments, "table", None) or getattr(arguments, "log", None) or []
    path = given if isinstance(given, str) else given[0] if given else ""
    with contextlib.suppress(OSError, ValueError, InputError):
        if not Path(path).is_file():
            return {}
        if Path(path).stat().st_size <= MOST:
            from fairaudit.tables.engines.logs import survey_log

            return {column.name: list(column.levels) for column in survey_log(path).columns}
        from fairaudit.tables.csv import layout
        from fairaudit.tables.engines.paths import form

        return {name: [] for name in layout(path).columns} if form(path) == "csv" else {}
    return {}
