"""Whether the stated preparation and spellings are those that the table shows."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from itertools import pairwise

from .certificate import Certificate
from .errors import Incomplete
from .findings import Finding, compared, finding_of
from .preparation import Step
from .rationals import ZERO, Rational, at_most, product_of, sum_of
from .spelling import folded_label, is_settled, labels_by_column, spellings
from .table import Table
from .text import printable, shown, shown_rational


def check_spellings(stated: Certificate, table: Table) -> Iterator[Finding]:
    header = table.header if table.policy is None else table.policy.header
    actual = tuple(spellings(header))
    if actual and not stated.spellings:
        column, labels = actual[0]
        raise Incomplete(
            printable(f'subject lacks the key "spellings": the labels {shown(labels)} of column {shown(column)} differ in spelling alone')
        )
    if stated.spellings:
        yield compared("subject.spellings", stated.spellings, actual)


class _Prepared:
    """What a table shows of the preparation of its log, found once for all entries."""

    def __init__(self, steps: Sequence[Step], table: Table) -> None:
        self.table = table
        self.header = table.header if table.policy is None else table.policy.header
        self.sampled = table.header.subject.kind == "counts" or (table.policy is not None and table.policy.drawn > 0)
        self.present = {column: set(labels) for column, labels in labels_by_column(self.header).items()}
        self.mapped = {(step.column, step.label) for step in steps if step.step == "mapped"}
        self.written = {(step.column, step.label) for step in steps if step.step != "intervals"}
        self.amounts: dict[str, Mapping[str, Rational] | None] = {}

    def amount(self, step: Step) -> Rational | None:
        """How many decisions have a label in a column; nothing where decisions are not counted by true cells."""
        if step.column not in self.amounts:
            self.amounts[step.column] = _amounts_of_labels(step.column, self.table)
        amounts = self.amounts[step.column]
        return None if amounts is None else amounts.get(step.label, ZERO)


def check_preparation(stated: Certificate, table: Table) -> Iterator[Finding]:
    prepared = _Prepared(stated.preparation, table)
    for i, step in enumerate(stated.preparation):
        fault = _fault_of_step(step, prepared)
        what = step.sentence.partition(";")[0] or f"{step.step} {shown(step.column)} {shown(step.label or step.edges)}"
        yield finding_of(f"subject.preparation[{i}]: {what}", not fault, fault)


def _fault_of_step(step: Step, prepared: _Prepared) -> str:
    """Say what in the table contradicts an entry; what the log was like before nobody can see from it."""
    if step.unit in ("decisions", "rows") and (step.unit == "decisions") != prepared.sampled:
        return f"the table is {'counted' if prepared.sampled else 'not counted'}"
    if step.step == "left out":
        return "" if step.unit == "lines" else _fault_of_left_out(step, prepared.table)
    if step.column not in prepared.present:
        return "the table has no such column"
    labels = prepared.present[step.column]
    if step.step == "intervals":
        allowed = _interval_labels(step.edges)
        other = next((x for x in sorted(labels) if x not in allowed and (step.column, x) not in prepared.written), None)
        return "" if other is None else f"the label {shown(other)} is none of these intervals"
    if step.label not in labels:
        return f"the table has no label {shown(step.label)} in this column"
    if step.step == "level":
        amount = prepared.amount(step)
        return "" if amount in (None, step.amount) else f"the table gives {shown(amount)}"
    for former in step.former:
        if former in labels and not (step.step == "mapped" and (step.column, former) in prepared.mapped):
            return f"the table still has the label {shown(former)}"
        settled = step.step == "folded" and is_settled(former) and is_settled(step.label)
        if settled and folded_label(former) != folded_label(step.label):
            return f"{shown(former)} differs in more than case, blanks or Unicode form"
    return ""


def _fault_of_left_out(step: Step, table: Table) -> str:
    amounts = [amount for _, amount in step.columns]
    if not amounts or not all(at_most(amount, step.amount) for amount in amounts) or not at_most(step.amount, sum_of(amounts)):
        return "the amounts of the columns do not make up the whole"
    kept = sum_of([step.of, (-step.amount[0], step.amount[1])])
    if step.unit == "rows":
        most = table.rows * len(table.header.decisions)
        return "" if 0 < kept[0] <= most else f"the table has at most {most} rows"
    total = sum_of(table.figures.masses()) if table.policy is None else (table.policy.drawn, 1)
    return "" if kept == total else f"the table gives {shown(total)} decisions that are left"


def _interval_labels(edges: Sequence[Rational]) -> set[str]:
    """Labels of the intervals between edges, which hold their lower edge."""
    texts = [_finite_decimal(edge) for edge in edges]
    between = {f"{low} to under {high}" for low, high in pairwise(texts)}
    return {f"under {texts[0]}", *between, f"{texts[-1]} and over"}


def _finite_decimal(value: Rational) -> str:
    """Write a rational with finitely many decimals (at most 30) as these; others are in no label."""
    numerator, denominator = value
    places = next((n for n in range(31) if 10**n % denominator == 0), None)
    if places is None:
        return ""
    digits = shown_rational(abs(numerator) * 10**places // denominator, 1).rjust(places + 1, "0")
    text = f"{digits[:-places]}.{digits[-places:]}" if places else digits
    return f"-{text}" if numerator < 0 else text


def _amounts_of_labels(column: str, table: Table) -> Mapping[str, Rational] | None:
    """Count the decisions with each label in a column; nothing where decisions are not counted by true cells."""
    header = table.header
    columns = header.subject.columns
    if header.subject.kind != "counts":
        return None
    of_group = column in columns.group
    position = 0 if column == columns.decision else (columns.group if of_group else columns.context).index(column)
    amounts: dict[str, list[Rational]] = {}
    for cell in table.cells:
        if column == columns.decision:
            for label, weight in zip(header.decisions, cell.law[0], strict=True):
                amounts.setdefault(label, []).append(product_of([cell.mass, (weight, cell.law[1])]))
        else:
            labels = header.groups[cell.group] if of_group else header.contexts[cell.context]
            amounts.setdefault(labels[position], []).append(cell.mass)
    return {label: sum_of(found) for label, found in amounts.items()}
