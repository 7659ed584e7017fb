"""What was done to the log before it was counted, and labels that differ in spelling alone: as stated, and against the table."""

from __future__ import annotations

import hashlib
import re
import unicodedata
from collections.abc import Callable, Collection, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise

from .header import OF_LOG, Columns, Header, Subject
from .json_values import Labels, canonical_text, read_choice, read_list, read_object, read_string, read_strings
from .left_out import Groups, LeftOutOf, fault_of_groups, groups_of, read_amount, read_groups
from .rationals import ZERO, Rational, at_most, product_of, read_rational, sum_of
from .sentences import DECISIONS_LEFT_OUT, LINES_LEFT_OUT, ROWS_LEFT_OUT, UNKNOWN_LEFT_OUT
from .table import Table
from .text import Counted, Finding, Incomplete, compared, finding_of, malformed, printable, shown, shown_rational

Amounts = Callable[[str], Mapping[str, Rational] | None]  # of a column, how many decisions have each label

LONGEST_SPELLING = 1000  # characters of labels that are compared with other spellings; see ``_is_settled``


def read_spellings(value: object, where: str) -> tuple[tuple[str, Labels], ...]:
    """Read lists of labels of one column."""
    entries = [read_object(item, f"{where}[{i}]", ("column", "labels")) for i, item in enumerate(read_list(value, where))]
    if not entries:
        raise malformed(where, "must not be empty")
    return tuple(
        (read_string(e["column"], f"{where}[{i}].column"), read_strings(e["labels"], f"{where}[{i}].labels")) for i, e in enumerate(entries)
    )


def _labels_by_column(header: Header) -> dict[str, list[str]]:
    columns = header.subject.columns
    found = {columns.decision: list(header.decisions)}
    for names, labels in ((columns.group, header.groups), (columns.context, header.contexts)):
        found |= {name: list(dict.fromkeys(label[i] for label in labels)) for i, name in enumerate(names)}
    return found if columns.truth is None else found | {columns.truth: list(header.truths or ())}


def _folded(text: str) -> str:
    """What labels have in common that differ in case, blanks or Unicode form alone: canonical caseless matching, single blanks."""
    decomposed = unicodedata.normalize("NFD", unicodedata.normalize("NFD", text).casefold())
    return " ".join(decomposed.split())


def _is_settled(text: str) -> bool:
    """Whether Unicode 3.2 assigns every code point, of which no later version changes the case or the normal forms.

    Longer texts are not looked at: many combining marks in a row take the square of their number of steps to put into order.
    """
    return len(text) <= LONGEST_SPELLING and all(unicodedata.ucd_3_2_0.category(character) != "Cn" for character in text)


_NUMBER = re.compile(r"([+-]?)(?:([0-9]+)(?:\.([0-9]*))?|\.([0-9]+))(?:e([+-]?[0-9]{1,4}))?")


def _spelling(text: str) -> tuple[str, ...]:
    """What spellings of one label have in common: the number that they say, or else what is folded."""
    folded = _folded(text)
    match = _NUMBER.fullmatch(folded)
    if match is None:
        return (folded,)
    sign, whole, decimals, only, power = match.groups()
    fraction = decimals or only or ""
    digits = ((whole or "") + fraction).lstrip("0")
    shortened = digits.rstrip("0")
    exponent = int(power or 0) - len(fraction) + len(digits) - len(shortened)
    return ("a number", "-" if sign == "-" else "", shortened, str(exponent)) if shortened else ("a number", "0")


def _spellings(header: Header, unknown: Iterable[str]) -> Iterator[tuple[str, Labels]]:
    """List labels of one column that are spellings of one label, or groups that are spellings of a label that names none."""
    for column, labels in _labels_by_column(header).items():
        own, alike = set(labels), dict[tuple[str, ...], list[str]]()
        for label in own.union(unknown if column in header.subject.columns.group else ()):
            if _is_settled(label):
                alike.setdefault(_spelling(label), []).append(label)
        several = (found for found in alike.values() if len(found) > 1 and not own.isdisjoint(found))
        yield from sorted((column, tuple(sorted(found))) for found in several)


STEPS = ("above", "above median", "intervals", "mapped", "folded", "left out", "level", "unknown")
ABOVE, NOT_ABOVE = "above", "not above"  # labels of the decision where scores were cut
MEDIAN = "above median"
ABOVE_STEPS = ("above", MEDIAN)
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
    groups: tuple[LeftOutOf, ...] | None = None  # nothing where that is not disclosed
    labels: Labels = ()  # that name no group
    sentence: str = ""  # what every claim has to assume


def read_preparation(value: object, where: str, subject: Subject) -> tuple[Step, ...]:
    """Read the entries of ``subject.preparation``, which have an order."""
    steps = tuple(_read_step(item, f"{where}[{i}]", subject.columns) for i, item in enumerate(read_list(value, where)))
    if not steps:
        raise malformed(where, "must not be empty")
    names = _names(subject.columns)
    places = [(STEPS.index(s.step), names.index(s.column) if s.column else -1, s.label, s.unit, _reason_rank(s)) for s in steps]
    if any(one >= other for one, other in pairwise(places)):
        raise malformed(where, "is not in the order of steps, columns and labels, each once")
    if len(steps) > 1 and any(s.step in ABOVE_STEPS for s in steps) and sum(s.column == subject.columns.decision for s in steps) > 1:
        raise malformed(where, "says something else of scores that were cut in two")
    return steps


def _names(columns: Columns) -> tuple[str, ...]:
    return (columns.decision, *columns.group, *columns.context, *([] if columns.truth is None else [columns.truth]))


def _reason_rank(step: Step) -> int:
    return REASONS.index(step.reason) if step.unit == "lines" else -1


def _read_step(value: object, where: str, columns: Columns) -> Step:
    name = read_choice(value.get("step"), f"{where}.step", STEPS) if isinstance(value, dict) else STEPS[0]
    possible = ("decisions", "rows", "lines") if name == "left out" else ("decisions", "rows")
    if name == "unknown":
        return _read_unknown(value, where, columns)
    if name in ABOVE_STEPS:
        return _read_above(value, where, columns)
    units = [unit for unit in possible if isinstance(value, dict) and unit in value]
    unit = units[0] if units else "decisions"
    if name == "left out":
        keys = ("step", "reason", "lines") if unit == "lines" else ("step", "reason", unit, "of", "columns", "groups")
        members = read_object(value, where, keys)
        reason = read_choice(members["reason"], f"{where}.reason", REASONS if unit == "lines" else ("missing label",))
        amount = read_amount(members[unit], f"{where}.{unit}", unit)
        template = {"decisions": DECISIONS_LEFT_OUT, "rows": ROWS_LEFT_OUT, "lines": LINES_LEFT_OUT}[unit]
        if unit == "lines":
            return Step(name, reason=reason, unit=unit, amount=amount, sentence=template.format(**members))
        of = read_amount(members["of"], f"{where}.of", unit)
        listed = read_object(members["columns"], f"{where}.columns", (), optional=_names(columns))
        by_column = tuple((column, read_amount(item, f"{where}.columns[{shown(column)}]", unit)) for column, item in listed.items())
        by_group = None if members["groups"] is None else read_groups(members["groups"], f"{where}.groups", unit, len(columns.group))
        sentence = template.format(**members)
        return Step(name, reason=reason, unit=unit, amount=amount, of=of, columns=by_column, groups=by_group, sentence=sentence)
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
        return Step(name, column, label=label, unit=unit, amount=read_amount(members[unit], f"{where}.{unit}", unit))
    former = read_strings(members["from"], f"{where}.from")
    if not former or list(former) != sorted(set(former)) or label in former:
        raise malformed(f"{where}.from", "must be other labels in the order of their code points, each once")
    return Step(name, column, label=label, former=former)


def _read_unknown(value: object, where: str, columns: Columns) -> Step:
    """Read of how many decisions the group is unknown, and by which labels."""
    members = read_object(value, where, ("step", "labels", "decisions", "of", "columns"))
    labels = read_strings(members["labels"], f"{where}.labels")
    if not labels or list(labels) != sorted(set(labels)):
        raise malformed(f"{where}.labels", "must be labels in the order of their code points, each once")
    amount, of = (read_amount(members[key], f"{where}.{key}", "decisions") for key in ("decisions", "of"))
    listed = read_object(members["columns"], f"{where}.columns", (), optional=columns.group)
    by_column = tuple((column, read_amount(item, f"{where}.columns[{shown(column)}]", "decisions")) for column, item in listed.items())
    sentence = UNKNOWN_LEFT_OUT.format(**members)
    return Step("unknown", unit="decisions", amount=amount, of=of, columns=by_column, labels=labels, sentence=sentence)


def _read_above(value: object, where: str, columns: Columns) -> Step:
    """Read at which number scores were cut, and of how many it is the median."""
    own = isinstance(value, dict) and value["step"] == MEDIAN
    members = read_object(value, where, ("step", "column", "median", "of") if own else ("step", "column", "limit"))
    column = read_choice(members["column"], f"{where}.column", (columns.decision,))
    key = "median" if own else "limit"
    edges = (read_rational(members[key], f"{where}.{key}"),)
    of = read_amount(members["of"], f"{where}.of", "decisions") if own else ZERO
    return Step(MEDIAN if own else "above", column, edges, ABOVE, of=of)


def log_digests(about: Mapping[str, object]) -> dict[str, str]:
    """Digests of what a subject says of the log, as the header of its table names them."""
    return {key: hashlib.sha256(canonical_text(about[key])).hexdigest() for key in OF_LOG if key in about}


def check_log_digests(stated: Mapping[str, str], named: Mapping[str, str]) -> Iterator[Finding]:
    """Compare what the subject says of the log with the digests in the header, which have to be there."""
    for key in OF_LOG:
        if key in stated and key not in named:
            lacks = f"the header of the table lacks the key {shown(key)}, the SHA-256 of subject.{key}; certify the log again"
            raise Incomplete(printable(lacks))
        if key in named:
            fault = "" if stated.get(key) == named[key] else "it has another SHA-256 than the header of the table says"
            fault = fault if key in stated else "the subject does not have it, and the header of the table says its SHA-256"
            yield finding_of(f"subject.{key} is the one that was counted with the table", not fault, fault)


def check_spellings(stated: Sequence[tuple[str, Labels]], steps: Sequence[Step], table: Table) -> Iterator[Finding]:
    """Compare the spellings, which have to be stated where there are any."""
    header = table.header if table.policy is None else table.policy.header
    actual = tuple(_spellings(header, [label for step in steps for label in step.labels]))
    if actual and not stated:
        column, labels = actual[0]
        raise Incomplete(
            printable(f'subject lacks the key "spellings": the labels {shown(labels)} of column {shown(column)} differ in spelling alone')
        )
    if stated:
        yield compared("subject.spellings", stated, actual)


@dataclass(frozen=True)
class Unlabelled:
    """How many decisions are of unknown group, and the columns in which they may have any label."""

    columns: Labels
    amount: Rational


NOBODY = Unlabelled((), ZERO)


class _Prepared:
    """What a table shows of the preparation of its log, found once for all entries."""

    def __init__(
        self,
        steps: Sequence[Step],
        labels: Mapping[str, Sequence[str]],
        amounts: Amounts,
        total: Rational | None,
        most: int,
        unknown: Unlabelled,
        groups: Groups | None,
    ) -> None:
        self.groups = groups
        self.sampled, self.total, self.most, self.unknown = total is not None, total, most, unknown
        self.present = {column: set(listed) for column, listed in labels.items()}
        self.of_groups = {label for column in unknown.columns for label in labels[column]}
        for column in unknown.columns:
            self.present[column] |= {label for step in steps for label in step.labels}
        self.mapped = {(step.column, step.label) for step in steps if step.step == "mapped"}
        self.written = {(step.column, step.label) for step in steps if step.step != "intervals"}
        self.amounts_of, self.amounts = amounts, dict[str, Mapping[str, Rational] | None]()

    def amount(self, step: Step) -> Rational | None:
        """How many decisions have a label in a column; nothing where decisions are not counted by true cells."""
        if step.column not in self.amounts:
            self.amounts[step.column] = self.amounts_of(step.column)
        amounts = self.amounts[step.column]
        return None if amounts is None else amounts.get(step.label, ZERO)


def check_preparation(stated: Sequence[Step], table: Table) -> Iterator[Finding]:
    """Check each entry so far as the table can contradict it."""
    if not stated:
        return
    header = table.header if table.policy is None else table.policy.header
    most = table.rows * len(table.header.decisions)
    labels, unknown, groups = _labels_by_column(header), _unlabelled(table), groups_of(table, header)
    yield from check_steps(stated, labels, lambda column: _amounts_of_labels(column, table), _total(table), most, unknown, groups)


def check_steps(
    stated: Sequence[Step],
    labels: Mapping[str, Sequence[str]],
    amounts: Amounts,
    total: Rational | None,
    most: int = 0,
    unknown: Unlabelled = NOBODY,
    groups: Groups | None = None,
) -> Iterator[Finding]:
    """Check each entry against the labels of each column, how many rows have them, and how many there are, or at most so many."""
    prepared = _Prepared(stated, labels, amounts, total, most, unknown, groups)
    for i, step in enumerate(stated):
        fault = _fault_of_step(step, prepared)
        what = step.sentence.partition(";")[0] or f"{step.step} {shown(step.column)} {shown(step.label or step.edges)}"
        yield finding_of(f"subject.preparation[{i}]: {what}", not fault, fault)


def _fault_of_step(step: Step, prepared: _Prepared) -> str:
    """Say what in the table contradicts an entry; what the log was like before nobody can see from it."""
    if step.unit in ("decisions", "rows") and (step.unit == "decisions") != prepared.sampled:
        return f"the table is {'counted' if prepared.sampled else 'not counted'}"
    if step.step in ("left out", "unknown"):
        return "" if step.unit == "lines" else _fault_of_left_out(step, prepared)
    if step.column not in prepared.present:
        return "the table has no such column"
    labels = prepared.present[step.column]
    if step.step in ABOVE_STEPS:
        return _fault_of_above(step, prepared, labels)
    if step.step == "intervals":
        allowed = _interval_labels(step.edges)
        other = next((x for x in sorted(labels) if x not in allowed and (step.column, x) not in prepared.written), None)
        return "" if other is None else f"the label {shown(other)} is none of these intervals"
    if step.label not in labels:
        return f"the table has no label {shown(step.label)} in this column"
    if step.step == "level":
        amount = prepared.amount(step)
        if amount is None:
            return ""
        unknown = prepared.unknown.amount if step.column in prepared.unknown.columns else ZERO  # can have the label in this column, too
        fits = at_most(amount, step.amount) and at_most(step.amount, sum_of([amount, unknown]))
        return "" if fits else f"the table gives {shown(amount)}"
    for former in step.former:
        if former in labels and not (step.step == "mapped" and (step.column, former) in prepared.mapped):
            return f"the table still has the label {shown(former)}"
        settled = step.step == "folded" and _is_settled(former) and _is_settled(step.label)
        if settled and _folded(former) != _folded(step.label):
            return f"{shown(former)} differs in more than case, blanks or Unicode form"
    return ""


def _fault_of_above(step: Step, prepared: _Prepared, labels: Collection[str]) -> str:
    """Say why scores were not cut so: the only decisions are the two, and no more than half of all scores are above their median."""
    other = next((label for label in sorted(labels) if label not in (ABOVE, NOT_ABOVE)), None)
    if other is not None:
        return f"the decision has the label {shown(other)}"
    if step.step != MEDIAN:
        return ""
    if prepared.total is None:
        return "the table is not counted"
    total = sum_of([prepared.total, prepared.unknown.amount])
    if step.of != total:
        return f"the table gives {shown(total)}"
    higher = prepared.amount(step)
    return "" if higher is None or at_most(sum_of([higher, higher]), total) else f"{shown(higher)} of {shown(total)} decisions are above"


def _fault_of_left_out(step: Step, prepared: _Prepared) -> str:
    amounts = [amount for _, amount in step.columns]
    if not amounts or not all(at_most(amount, step.amount) for amount in amounts) or not at_most(step.amount, sum_of(amounts)):
        return "the amounts of the columns do not make up the whole"
    known, listed = prepared.groups, step.groups
    if known is not None and listed is not None and (fault := fault_of_groups(step.amount, step.columns, listed, known)):
        return fault
    kept = sum_of([step.of, (-step.amount[0], step.amount[1])])
    if prepared.total is None:
        return "" if 0 < kept[0] <= prepared.most else f"the table has at most {prepared.most} rows"
    unknown = prepared.unknown.amount
    if step.step == "unknown" and step.amount != unknown:
        return f"the table gives {shown(unknown)}"
    if named := sorted(prepared.of_groups.intersection(step.labels)):
        return f"the table has a group with the label {shown(named[0])}"
    total = prepared.total if step.step == "unknown" else sum_of([prepared.total, unknown])
    return "" if kept == total else f"the table gives {shown(total)} decisions that are left"


def _unlabelled(table: Table) -> Unlabelled:
    """Count the decisions of unknown group."""
    amount = sum_of([ZERO, *(count for row in table.unknown for count in row.counts)])
    return Unlabelled(table.header.subject.columns.group, amount) if table.unknown else NOBODY


def left_out(steps: Iterable[Step]) -> tuple[tuple[str, Rational], ...]:
    """How much was left out, by reason."""
    amounts: dict[str, list[Rational]] = {}
    for step in steps:
        if step.step == "left out":
            amounts.setdefault(step.reason, []).append(step.amount)
    return tuple((reason, sum_of(found)) for reason, found in amounts.items())


def counted_of(steps: Sequence[Step], table: Table) -> Counted:
    """Say what was counted of a log, and what was left out."""
    total, most = _total(table), table.rows * len(table.header.decisions)
    if total is None:
        kept = [sum_of([step.of, (-step.amount[0], step.amount[1])]) for step in steps if step.step == "left out" and step.unit == "rows"]
        return Counted(table.digest, "rows", kept[0] if kept else None, most, left_out(steps))
    return Counted(table.digest, "decisions", sum_of([total, _unlabelled(table).amount]), most, left_out(steps))


def _total(table: Table) -> Rational | None:
    """How many decisions of known group were counted; nothing of a table of probabilities, or of a policy without draws."""
    if table.header.subject.kind == "counts":
        return sum_of([ZERO, *table.figures.masses()])
    return (table.policy.drawn, 1) if table.policy is not None and table.policy.drawn else None


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
    for row in () if of_group else table.unknown:
        if column == columns.decision:
            for label, count in zip(header.decisions, row.counts, strict=True):
                amounts.setdefault(label, []).append(count)
        else:
            amounts.setdefault(header.contexts[row.context][position], []).append(sum_of(row.counts))
    return {label: sum_of(found) for label, found in amounts.items()}
