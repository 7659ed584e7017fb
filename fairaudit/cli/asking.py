"""`fairaudit certify TABLE` and nothing else: on a terminal the columns are asked for, elsewhere a command is proposed."""

from __future__ import annotations

import argparse
import shlex
import sys
from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING

from fairaudit.cli.columns import Column, described, is_complete, looked_at, named, open_questions, suggested, warnings, written
from fairaudit.cli.source import lexicon_of
from fairaudit.errors import FairauditError
from fairaudit.words import noun, plain

if TYPE_CHECKING:
    from fairaudit.audits.roles import Roles

__all__ = ["ask_for_columns"]

NOTHING, BACK = "-", "<"
REPEATED = ("group", "context", "unit", "slots", "undecided", "number_sign")
HELP = "Answer with a name or its number. Enter takes what stands in brackets, - is none, < goes back, Ctrl-C leaves.\n"


class _BackError(FairauditError):
    """The one who is asked wants the question before."""


def ask_for_columns(arguments: argparse.Namespace) -> None:
    """Fill in the columns, the utility and what becomes of missing labels, and print the command that does the same without questions.

    Raises
    ------
    InputError
        If nobody can be asked; the message has a command to try.
    """
    from fairaudit.cli.options import column_list
    from fairaudit.errors import InputError

    survey, found, roles = looked_at(arguments)
    if sys.stdin is None or sys.stderr is None or not (sys.stdin.isatty() and sys.stderr.isatty()):
        command = plain(shlex.join(suggested(arguments, roles)))
        said = "".join(f"; {plain(text)}" for text in (*roles.said, *open_questions(roles)))
        what = "to try" if is_complete(roles) else "to complete, with a name for each word in capitals"
        raise InputError(f"no column was named; what each is, only you can say{said}; {what}: {command}")
    _say(f"The table has {survey.rows:,} row{'s' * (survey.rows != 1)} and these columns:")
    technical = frozenset[str]() if survey.samples is None else survey.samples.technical - named(roles)
    roles = replace(roles, undecided=tuple(dict.fromkeys((*roles.undecided, *column_list(arguments.undecided)))))
    shown = sorted(found, key=lambda column: column.name in technical)
    roles = _Dialogue(shown, roles, hidden=len(technical), lexicon=lexicon_of(arguments)).asked()
    if roles.where:
        arguments.where = [*(arguments.where or ()), *roles.where]
    if roles.errors and arguments.errors == "refuse":
        arguments.errors = "bound"
    if roles.missing_samples:
        arguments.missing_samples = "accept"
    for name, value in written(roles).items():
        if value and not (name == "missing" and arguments.missing != "error"):
            setattr(arguments, name, [value] if name in REPEATED else value)
    arguments.burden = arguments.burden or roles.burden
    _say(f"\nThe same without questions:\n  {plain(shlex.join(suggested(arguments, roles)))}\n")


def _taken(roles: Roles) -> set[str | None]:
    """The columns that say what was decided, and how often."""
    whole = () if roles.wide is None else roles.wide.columns
    return {roles.decision, roles.utility_column, roles.count, roles.probability, roles.weight, roles.winner, *roles.slots, *whole}


class _Dialogue:
    """Questions about the columns, which people may go back to."""

    def __init__(self, found: Sequence[Column], roles: Roles, *, hidden: int = 0, lexicon: Sequence[str] = ()) -> None:
        self.columns, self.lexicon = {column.name: column for column in found}, lexicon
        self.guess, self.hidden = roles, hidden
        self.place, self.spoke = 1, False

    def asked(self) -> Roles:
        """Let people correct what was guessed."""
        names = [plain(name) for name in self.columns]
        shown = len(names) - self.hidden
        width = max(map(len, names[:shown]))
        for place, (name, column) in enumerate(zip(names[:shown], self.columns.values(), strict=False), 1):
            _say(f"  {place:>3}  {name.ljust(width)}  {described(column)}")
            for text in warnings(column):
                _say(f"       {' ' * width}  ! {plain(text)}")
        if self.hidden:
            _say(f"  and {self.hidden} more {noun(self.hidden, 'path')}, which may be named, too: fairaudit inspect --all lists them")
        _say("\n" + HELP)
        for text in self.guess.said:
            _say(f"Note: {plain(text)}.\n")
        steps: list[Callable[[Roles], Roles]] = [self.form, self.decision, self.label, self.good, self.meaning]
        steps += [self.group, self.cut, self.context]
        behind: list[tuple[int, Roles]] = []
        roles, at = self.guess, 0
        while at < len(steps):
            self.place, self.spoke, before = len(behind) + 1, False, roles
            try:
                roles = steps[at](roles)
            except _BackError:
                at, roles = behind.pop() if behind else (at, roles)
                continue
            if self.spoke:
                behind.append((at, before))
            at += 1
        chosen = (roles.decision, roles.utility_column, *roles.group, *roles.context)
        missing = any(self.columns[name].missing for name in chosen if name in self.columns)
        if missing and not roles.slots:
            _say("Rows without a label in one of these are left out; how many, the certificate says.")
        return replace(roles, missing=missing and not roles.slots)

    def form(self, roles: Roles) -> Roles:
        """Whether the table is what it seems to be, where that is not a decision in each row."""
        if roles.slots:
            slots, winner = ", ".join(map(plain, roles.slots)), plain(roles.winner or "")
            what = f"Is each row a choice among candidates, with {slots} for who they were and {winner} for who was chosen?"
        elif roles.wide is not None:
            columns = ", ".join(plain(name) for name in dict.fromkeys(name for *_, name in roles.wide.counts))
            whole = ", ".join(plain(name) for _, name in roles.wide.totals) or (roles.wide.of and f"{roles.wide.of} each")
            what = f"Are decisions counted in the columns {columns}{f', of {whole}' if whole else ''}?"
        else:
            return roles
        if self.one(what, "yes", ["yes", "no"]) == "yes":
            return roles
        return replace(roles, slots=(), winner=None, wide=None, weight=None, decision=None, group=(), context=())

    def decision(self, roles: Roles) -> Roles:
        """What was decided: labels, or numbers of which more is better or worse."""
        from fairaudit.audits.roles import MANY, as_number

        if roles.slots or roles.wide is not None:
            return roles
        while True:
            default = roles.decision or roles.utility_column
            (name,) = self.names(
                "Which column says what was decided, or how much people got?", (default,) if default else (), least=1, most=1
            )
            column = self.columns[name]
            if not column.levels:
                _say("  It is empty.")
            elif column.numeric and column.different > 2:
                if all((as_number(text) or 0) >= 0 for text in column.levels):
                    _say("  Its numbers are compared as they stand, by their means.")
                    return replace(roles, decision=None, utility_column=name)
                _say("  It has negative numbers, of which no ratio is taken; name another, or see --difference.")
            elif column.different > MANY:
                _say(f"  It has {column.different:,} different labels, which are no decisions; name another.")
            else:
                return replace(roles, decision=name, utility_column=None)

    def label(self, roles: Roles) -> Roles:
        """Which label counts."""
        if roles.slots or roles.utility_column is not None:
            return roles
        labels = (
            list(self.columns[roles.decision].levels)
            if roles.wide is None and roles.decision
            else list(dict.fromkeys(decision for decision, _, _ in roles.wide.counts))
            if roles.wide is not None
            else []
        )
        decided = () if roles.wide is not None else self.decided(labels)
        default = roles.utility if roles.utility in labels else next(iter(decided), "")
        if len(labels) == 1 and default:
            return replace(roles, utility=default)
        bare = any(label.strip().isdigit() for label in labels)
        listed = ", ".join(plain(label) if bare else f"{place} {plain(label)}" for place, label in enumerate(labels[:20], 1))
        return replace(roles, utility=self.one(f"Which of its labels is counted: {listed}?", default, labels))

    def good(self, roles: Roles) -> Roles:
        """Whether what is counted is good for people."""
        if roles.slots:
            what = "being chosen"
        elif roles.utility_column is not None:
            what = f"more of {plain(roles.utility_column)}"
        else:
            what = f"'{plain(roles.utility)}'"
        answer = self.one(f"Is {what} good for the person, or a harm?", "harm" if roles.burden else "good", ["good", "harm"])
        return replace(roles, burden=answer == "harm")

    def decided(self, labels: Sequence[str]) -> Sequence[str]:
        """The labels that do not look undecided."""
        from fairaudit.tables.label_meaning import looking_undecided

        undecided = looking_undecided(labels, self.lexicon)
        return [label for label in labels if label not in undecided]

    def meaning(self, roles: Roles) -> Roles:
        """Whether labels that look undecided are."""
        asked = roles.decision and not (roles.wide or roles.slots or roles.probability)
        labels = list(self.columns[roles.decision].levels) if roles.decision and asked else []
        decided = {*self.decided(labels)} - {*self.guess.undecided}
        found: dict[str, str] = {}
        for label in labels:
            if label not in decided and label != roles.utility:
                no = "spared" if roles.burden else "refused"
                found[label] = self.one(f"Does '{plain(label)}' mean {no}, or is it undecided?", "undecided", [no, "undecided"])
        undecided = tuple(label for label, answer in found.items() if answer == "undecided")
        return replace(roles, undecided=undecided, refused=tuple(label for label in found if label not in undecided))

    def group(self, roles: Roles) -> Roles:
        """Whose treatment is compared."""
        if roles.slots:
            return roles
        if roles.wide is not None and roles.wide.headers:
            return roles
        question = "Which columns say who people are, such as sex or origin (several: with commas)?"
        group = self.names(question, roles.group, least=1, taken=_taken(roles))
        return replace(roles, group=group, context=tuple(name for name in roles.context if name not in group))

    def cut(self, roles: Roles) -> Roles:
        """Where numbers of a group are cut into intervals."""
        from fairaudit.audits.roles import NUMBERS, as_number, cuts

        bins = {}
        for name in roles.group if not (roles.slots or roles.wide or roles.count or roles.probability) else ():
            column = self.columns[name]
            if not column.numeric or column.different <= NUMBERS:
                continue
            values = {as_number(text): count for text, count in column.levels.items()}
            default = ",".join(map(str, roles.bins.get(name) or cuts(name, values))) or NOTHING
            while True:
                answer = (
                    self.answer(f"{plain(name)} has {column.different:,} different numbers; where is it cut into groups?", default)
                    or default
                )
                edges = [] if answer == NOTHING else [as_number(text) for text in answer.split(",")]
                found = tuple(edge for edge in edges if edge is not None)
                if len(found) == len(edges) and list(found) == sorted(set(found)):
                    break
                _say("  Numbers that grow, separated by commas, are needed, such as 25,45,65.")
            if found:
                bins[name] = found
        return replace(roles, bins=bins)

    def context(self, roles: Roles) -> Roles:
        """Within what people are compared."""
        question = "What may rightly make a difference, such as the job applied for, so that people are compared within it?"
        return replace(roles, context=self.names(question, roles.context, taken=_taken(roles) | {*roles.group}))

    def names(
        self, question: str, default: Sequence[str], *, least: int = 0, most: int = 5, taken: set[str | None] | None = None
    ) -> tuple[str, ...]:
        """Ask for columns until each is one."""
        from fairaudit.cli.options import parts
        from fairaudit.errors import InputError, nearest

        known = list(self.columns)
        while True:
            answer = self.answer(question, ", ".join(default) or NOTHING)
            try:
                given = tuple(default) if not answer else () if answer == NOTHING else tuple(name.strip() for name, _ in parts(answer))
            except InputError as error:
                _say(f"  {error}")
                continue
            chosen = tuple(known[int(name) - 1] if _is_place(name, known) else name for name in given)
            unknown = next((name for name in chosen if name not in self.columns), None)
            used = next((name for name in chosen if taken and name in taken), None)
            if unknown is not None:
                _say(f"  There is no column {unknown!r}; {nearest(unknown, self.columns)}.")
            elif used is not None:
                _say(f"  {plain(used)} is something else already; name another column.")
            elif not least <= len(chosen) <= most or len(set(chosen)) < len(chosen):
                _say(f"  {'One column is' if most == 1 else 'One column or more, each once, are'} needed.")
            else:
                return chosen

    def one(self, question: str, default: str, known: Sequence[str]) -> str:
        """Ask for one of some words."""
        from fairaudit.errors import nearest

        while True:
            answer = self.answer(question, plain(default)) or default
            alike = [word for word in known if word.lower() == answer.lower()]
            if answer in known or len(alike) == 1:
                return answer if answer in known else alike[0]
            if _is_place(answer, known):
                return known[int(answer) - 1]
            _say(f"  {answer!r} is none of them; {nearest(answer, known)}.")

    def answer(self, question: str, default: str) -> str:
        """Ask, and read a line."""
        sys.stderr.write(f"{self.place}. {question} [{plain(default)}] ")
        sys.stderr.flush()
        self.spoke = True
        line = sys.stdin.readline()
        if not line:
            raise KeyboardInterrupt
        if line.strip() == BACK:
            raise _BackError
        return line.strip()


def _is_place(answer: str, known: Sequence[str]) -> bool:
    """Whether a number stands for one of several names, none of which it is."""
    return answer not in known and answer.isascii() and answer.isdigit() and 1 <= int(answer[:6]) <= len(known)


def _say(text: str) -> None:
    print(text, file=sys.stderr)
