"""What was done to the log before it was counted, as the certificate states it."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise

from .header import Columns, Subject
from .json_values import Labels, read_choice, read_list, read_object, read_string, read_strings
from .rationals import ZERO, Rational, at_most, read_rational
from .sentences import DECISIONS_LEFT_OUT, LINES_LEFT_OUT, ROWS_LEFT_OUT
from .text import malformed, shown

# What was done to the log before it was counted, and labels that differ in spelling alone

STEPS = ("intervals", "mapped", "folded", "left out", "level")

REASONS = ("unreadable line", "missing label", "unusable value", "unknown reason")  # why lines of a log could not be counted


@dataclass(frozen=True)
class Step:
    """One entry of ``subject.preparation``."""

    step: str
    column: str = ""
    edges: tuple[Rational, ...] = ()
    label: str = ""
    former: Labels = ()
    reason: str = ""
    unit: str = ""  # of the amounts: decisions, rows (of a table of probabilities) or lines (of a log)
    amount: Rational = ZERO
    of: Rational = ZERO
    columns: tuple[tuple[str, Rational], ...] = ()
    sentence: str = ""  # what every claim has to assume


def read_preparation(value: object, where: str, subject: Subject) -> tuple[Step, ...]:
    steps = tuple(_read_step(item, f"{where}[{i}]", subject.columns) for i, item in enumerate(read_list(value, where)))
    if not steps:
        raise malformed(where, "must not be empty")
    names = _names(subject.columns)
    places = [(STEPS.index(s.step), names.index(s.column) if s.column else -1, s.label, s.unit, _reason_rank(s)) for s in steps]
    if any(one >= other for one, other in pairwise(places)):
        raise malformed(where, "is not in the order of steps, columns and labels, each once")
    return steps


def _names(columns: Columns) -> tuple[str, ...]:
    return (columns.decision, *columns.group, *columns.context, *([] if columns.truth is None else [columns.truth]))


def _reason_rank(step: Step) -> int:
    return REASONS.index(step.reason) if step.unit == "lines" else -1


def _read_step(value: object, where: str, columns: Columns) -> Step:
    name = read_choice(value.get("step"), f"{where}.step", STEPS) if isinstance(value, dict) else STEPS[0]
    possible = ("decisions", "rows", "lines") if name == "left out" else ("decisions", "rows")
    units = [unit for unit in possible if isinstance(value, dict) and unit in value]
    unit = units[0] if units else "decisions"
    if name == "left out":
        keys = ("step", "reason", "lines") if unit == "lines" else ("step", "reason", unit, "of", "columns")
        members = read_object(value, where, keys)
        reason = read_choice(members["reason"], f"{where}.reason", REASONS if unit == "lines" else ("missing label",))
        amount = _read_amount(members[unit], f"{where}.{unit}", unit)
        template = {"decisions": DECISIONS_LEFT_OUT, "rows": ROWS_LEFT_OUT, "lines": LINES_LEFT_OUT}[unit]
        if unit == "lines":
            return Step(name, reason=reason, unit=unit, amount=amount, sentence=template.format(**members))
        of = _read_amount(members["of"], f"{where}.of", unit)
        listed = read_object(members["columns"], f"{where}.columns", (), optional=_names(columns))
        by_column = tuple((column, _read_amount(item, f"{where}.columns[{shown(column)}]", unit)) for column, item in listed.items())
        return Step(name, reason=reason, unit=unit, amount=amount, of=of, columns=by_column, sentence=template.format(**members))
    shapes = {"intervals": ("step", "column", "edges"), "level": ("step", "column", "label", unit)}
    members = read_object(value, where, shapes.get(name, ("step", "column", "label", "from")))
    column = read_choice(members["column"], f"{where}.column", _names(columns))
    if name == "intervals":
        edges = tuple(read_rational(item, f"{where}.edges[{i}]") for i, item in enumerate(read_list(members["edges"], f"{where}.edges")))
        if not edges or any(at_most(other, one) for one, other in pairwise(edges)):
            raise malformed(f"{where}.edges", "must rise")
        return Step(name, column, edges)
    label = read_string(members["label"], f"{where}.label")
    if name == "level":
        if column == columns.truth:
            raise malformed(where, "is about the true labels: where there is none, a decision is neither a true nor a false positive")
        return Step(name, column, label=label, unit=unit, amount=_read_amount(members[unit], f"{where}.{unit}", unit))
    former = read_strings(members["from"], f"{where}.from")
    if not former or list(former) != sorted(set(former)) or label in former:
        raise malformed(f"{where}.from", "must be other labels in the order of their code points, each once")
    return Step(name, column, label=label, former=former)


def _read_amount(value: object, where: str, unit: str) -> Rational:
    amount = read_rational(value, where, nonnegative=True)
    if amount[0] == 0 or (unit != "decisions" and amount[1] != 1):
        raise malformed(where, f"must be {'positive' if unit == 'decisions' else 'a positive integer'}, not {shown(amount)}")
    return amount
