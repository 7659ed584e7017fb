"""`fairaudit certify TABLE` and nothing else: on a terminal the columns are asked for, elsewhere a command is proposed."""

from __future__ import annotations

import argparse
import shlex
import sys
from collections.abc import Sequence
from dataclasses import replace
from typing import TYPE_CHECKING

from fairaudit.cli.columns import Column, described, looked_at, suggested, written
from fairaudit.words import plain

if TYPE_CHECKING:
    from fairaudit.audits.roles import Roles

__all__ = ["ask_for_columns"]

NOTHING = "-"
REPEATED = ("group", "context", "unit")


def ask_for_columns(arguments: argparse.Namespace) -> None:
    """Fill in the columns, the utility and what becomes of missing labels, and print the command that does the same without questions.

    Raises
    ------
    InputError
        If nobody can be asked; the message has a command to try.
    """
    from fairaudit.errors import InputError

    _, found, roles = looked_at(arguments)
    if sys.stdin is None or sys.stderr is None or not (sys.stdin.isatty() and sys.stderr.isatty()):
        command = plain(shlex.join(suggested(arguments, roles)))
        raise InputError(f"no column was named; what each is, only you can say; to try: {command}")
    roles = _asked(found, roles)
    for name, value in written(roles).items():
        if value:
            setattr(arguments, name, [value] if name in REPEATED else value)
    arguments.burden = roles.burden
    _say(f"The same without questions:\n  {plain(shlex.join(suggested(arguments, roles)))}\n")


def _asked(found: Sequence[Column], roles: Roles) -> Roles:
    """Let people correct what was guessed."""
    columns = {column.name: column for column in found}
    width = max(len(plain(name)) for name in columns)
    _say("The table has these columns:")
    for name, column in columns.items():
        _say(f"  {plain(name).ljust(width)}  {described(column)}")
    _say("\nFive questions. Enter takes what stands in brackets; - is for none.\n")
    (decision,) = _columns("Which column says what was decided?", (roles.decision,) if roles.decision else (), columns, least=1, most=1)
    labels = list(columns[decision].levels)
    utility = roles.utility if roles.utility in labels else labels[0]
    utility = _one("Which of its labels counts, as good for people or as a harm?", utility, labels)
    burden = _one("Is that good for them, or a harm?", "harm" if roles.burden else "good", ["good", "harm"]) == "harm"
    group = _columns("Whose treatment is compared (columns, separated by commas)?", roles.group, columns, least=1)
    context = _columns("What may rightly make a difference, such as the job applied for?", roles.context, columns)
    chosen = (decision, *group, *context)
    bins = {name: edges for name, edges in roles.bins.items() if name in group}
    missing = any(columns[name].missing for name in chosen)
    if missing:
        _say("Rows without a label in one of these are left out; how many, the certificate says.")
    return replace(roles, decision=decision, utility=utility, burden=burden, group=group, context=context, bins=bins, missing=missing)


def _columns(question: str, default: Sequence[str], columns: dict[str, Column], *, least: int = 0, most: int = 5) -> tuple[str, ...]:
    """Ask for columns until each is one."""
    from fairaudit.cli.options import parts
    from fairaudit.errors import InputError, nearest

    while True:
        answer = _answer(question, ", ".join(default) or NOTHING)
        try:
            names = tuple(default) if not answer else () if answer == NOTHING else tuple(name.strip() for name, _ in parts(answer))
        except InputError as error:
            _say(f"  {error}")
            continue
        unknown = next((name for name in names if name not in columns), None)
        if unknown is not None:
            _say(f"  There is no column {unknown!r}; {nearest(unknown, columns)}.")
        elif not least <= len(names) <= most or len(set(names)) < len(names):
            _say(f"  {'One column is' if most == 1 else 'One column or more, each once, are'} needed.")
        else:
            return names


def _one(question: str, default: str, known: Sequence[str]) -> str:
    """Ask for one of some words."""
    from fairaudit.errors import nearest

    while True:
        answer = _answer(question, plain(default)) or default
        if answer in known:
            return answer
        _say(f"  {answer!r} is none of them; {nearest(answer, known)}.")


def _answer(question: str, default: str) -> str:
    sys.stderr.write(f"{question} [{plain(default)}] ")
    sys.stderr.flush()
    line = sys.stdin.readline()
    if not line:
        raise KeyboardInterrupt
    return line.strip()


def _say(text: str) -> None:
    print(text, file=sys.stderr)
