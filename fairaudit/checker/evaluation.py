"""The log of a model's evaluation that a table was counted from: as stated, and against the table."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise

from .header import Subject
from .json_values import Labels, check_distinct, read_choice, read_integer, read_list, read_object, read_string, read_strings
from .preparation import Step
from .rationals import at_most, reduced, sum_of
from .sentences import ERRORS_LEFT_OUT, SAMPLES_LEFT_OUT
from .table import Table, counts_are_whole
from .text import Finding, compared, finding_of, malformed, shown

RECIPES = {"bbq": 2, "bbq-accuracy": 1}  # rows of a sample of which any are made
UNMADE = "unusable value"  # as which those are left out of which none are

UNDECIDED = ("refused", "unreadable", "truncated")  # decisions of the table, of answers that decide nothing
ERROR = "error"  # a decision of the table only where it is to be bounded
LOST = (*UNDECIDED, ERROR)
ANSWERS = ("read", *LOST)

OPTIONAL = ("extract", "options", "join", "where", "recipe", "each", "question", "unit", "unlabelled")

QUESTIONS = "questions were drawn; epochs of a question count once"
FIXED = "the questions are fixed; the model's answers were drawn"
UNITS = "sampling units were drawn; samples of a unit count once"
SAMPLES = "samples were drawn, each of them by itself"
NOTHING = "nothing was drawn: the questions are fixed, and the model answers each of them in one way"

WORDS = {
    "refused": "were refused",
    "unreadable": "could not be understood",
    "truncated": "were cut off",
    "error": "ended in an error",
}

Place = tuple[Labels, Labels]  # a context and a group, the empty one where it was not recorded
Counts = Mapping[str, int]  # of answers, those that decide nothing only where there are any


@dataclass(frozen=True)
class Evaluation:
    """What is stated of an evaluation log."""

    format: str
    epochs: int
    question: str  # what names one in the log, a column or a path
    unit: Labels  # columns of the sampling unit
    drawn: str
    errors: str
    expected: int | None  # samples
    read: int
    counted: int  # of these samples
    rows: int  # that were made of them, and were counted or left out
    all_count: bool  # whether there is no condition on samples
    recipe: str  # by which rows were made of samples, without where the answers stand
    options: Labels  # what there was to choose, if decisions were read out of answers in words
    each: bool  # whether a sample makes a row for each element of a list
    answers: Counts
    cells: tuple[tuple[Place, Counts], ...] | None
    unlabelled: int  # of the errors that were taken out, how many have no label of a cell

    @property
    def dropped(self) -> int:
        """How many rows were taken out because they ended in an error."""
        return self.answers[ERROR] if self.errors == "drop" else 0

    @property
    def missing(self) -> int:
        """How many samples are not in the log."""
        return 0 if self.expected is None else self.expected - self.read

    @property
    def sentences(self) -> tuple[str, ...]:
        """What every claim has to assume."""
        errors = (ERRORS_LEFT_OUT.format(error=self.dropped, rows=self.rows),) if self.dropped else ()
        missing = (SAMPLES_LEFT_OUT.format(missing=self.missing, expected=self.expected),) if self.missing else ()
        return (*errors, *missing)

    @property
    def words(self) -> str:
        """What is stated, for somebody who has not seen the log either."""
        what = "answers" if self.rows == self.counted else "rows"
        counted = [f"{self.answers['read']:,} of {self.rows:,} {what} were read"]
        counted += [f"{self.answers[name]:,} {WORDS[name]}" for name in LOST if self.answers[name]]
        if self.answers[ERROR]:
            counted[-1] += " and were left out" if self.dropped else ", which count as decisions of their own"
        if beside := self.rows - sum(self.answers.values()):
            counted.append(f"{beside:,} have no label and were left out")
        absent = f" {self.missing:,} of {self.expected:,} samples are not in it." if self.missing else ""
        return (
            f"The certificate says that the table was counted from an evaluation log ({shown(self.format)}), which was not looked at here: "
            f"{', '.join(counted)}.{absent} Of what was drawn it says: {self.drawn}{self._told_apart}.{''.join(self._unseen)}"
        )

    @property
    def _told_apart(self) -> str:
        """By what questions and units are told apart."""
        said = (("question", (self.question,) if self.question else ()), ("sampling unit", self.unit))
        parts = [f"a {what} is told by {' and '.join(map(shown, columns))}" for what, columns in said if columns]
        return f" ({', '.join(parts)})" if parts else ""

    @property
    def _unseen(self) -> Iterator[str]:
        """What no table shows, and somebody who reads the certificate has to take from it."""
        if self.epochs > 1 and self.drawn != NOTHING:
            yield f" Each question was asked up to {self.epochs:,} times, and which answers are to one question is not in the table."
        if self.dropped:
            yield " Of which groups the errors are that were left out the table does not show: nothing here checks it."


def read_evaluation(value: object, where: str, subject: Subject, *, embedded: bool) -> Evaluation:
    """Read what is stated of an evaluation log."""
    if subject.kind != "counts":
        raise malformed(where, "must not be there: only counts are of an evaluation log")
    keys = ("format", "epochs", "drawn", "errors", "samples", "answers", "cells")
    members = read_object(value, where, keys, optional=OPTIONAL)
    epochs = read_integer(members["epochs"], f"{where}.epochs")
    for key in ("format", *(key for key in ("extract", "join", "recipe", "each", "question") if key in members)):
        if not read_string(members[key], f"{where}.{key}"):
            raise malformed(f"{where}.{key}", "must not be empty")
    unit = read_strings(members["unit"], f"{where}.unit") if "unit" in members else ()
    if "unit" in members:
        check_distinct(unit, f"{where}.unit")
    if epochs == 0:
        raise malformed(f"{where}.epochs", "must be positive")
    question = str(members.get("question", ""))
    recipe = _read_recipe(members, where)
    if epochs > 1 and not question:
        raise malformed(where, "lacks the key 'question', though questions were asked several times")
    cell = (*subject.columns.context, *subject.columns.group)
    said = _possible(question, unit, cell, repeated=epochs > 1)
    options = _read_options(members, where)
    if "where" in members:
        _read_where(members["where"], f"{where}.where")
    samples = read_object(members["samples"], f"{where}.samples", ("expected", "read", "counted", "rows"))
    expected = samples["expected"]
    if expected is not None:
        expected = read_integer(expected, f"{where}.samples.expected")
    read = Evaluation(
        str(members["format"]),
        epochs,
        question,
        unit,
        read_choice(members["drawn"], f"{where}.drawn", said),
        read_choice(members["errors"], f"{where}.errors", ("refuse", "drop", "bound")),
        expected,
        read_integer(samples["read"], f"{where}.samples.read"),
        read_integer(samples["counted"], f"{where}.samples.counted"),
        read_integer(samples["rows"], f"{where}.samples.rows"),
        "where" not in members,
        recipe,
        options,
        "each" in members,
        {
            name: read_integer(item, f"{where}.answers.{name}")
            for name, item in read_object(members["answers"], f"{where}.answers", ANSWERS).items()
        },
        None if members["cells"] is None else _read_cells(members["cells"], f"{where}.cells", subject),
        read_integer(members["unlabelled"], f"{where}.unlabelled") if "unlabelled" in members else 0,
    )
    if "unlabelled" in members and not 0 < read.unlabelled <= read.dropped:
        raise malformed(f"{where}.unlabelled", "must be positive, and of the errors that were left out")
    if read.missing < 0 or read.counted > read.read:
        raise malformed(f"{where}.samples", "has more samples than there can be")
    if read.errors == "refuse" and read.answers[ERROR]:
        raise malformed(f"{where}.answers.{ERROR}", "must be 0 where errors were refused")
    if read.cells is None and embedded:
        raise malformed(f"{where}.cells", "must be a list, as the certificate holds the table")
    return read


def _read_recipe(members: Mapping[str, object], where: str) -> str:
    """Read by which recipe rows were made of samples; elements of one list are no draws by themselves."""
    if "each" in members and "unit" not in members:
        raise malformed(where, "lacks the key 'unit', though samples make a row for each element of a list")
    recipe = str(members.get("recipe", "")).partition(":")[0]
    if "recipe" in members and recipe not in RECIPES:
        raise malformed(f"{where}.recipe", f"must be one of {', '.join(RECIPES)}, of which it is known how many rows they make")
    return recipe


def _possible(question: str, unit: Labels, cell: Labels, *, repeated: bool) -> tuple[str, ...]:
    """What can have been drawn: an answer is a draw by itself only where its question is by itself, or in cells of its own."""
    if unit:
        return (QUESTIONS if question in unit else UNITS, FIXED, NOTHING)
    if not question:
        return (SAMPLES,)
    return (FIXED, NOTHING) if question in cell else () if repeated else (QUESTIONS,)


def _read_options(members: Mapping[str, object], where: str) -> Labels:
    """Read what there was to choose."""
    if "options" not in members:
        return ()
    options = read_strings(members["options"], f"{where}.options")
    check_distinct(options, f"{where}.options")
    if len(options) < 2:
        raise malformed(f"{where}.options", "must be two or more")
    return options


def _read_where(value: object, where: str) -> None:
    """Read which samples count, of which nothing is compared."""
    conditions = [read_object(item, f"{where}[{i}]", ("path", "value")) for i, item in enumerate(read_list(value, where))]
    check_distinct([tuple(read_string(item[key], f"{where}[{i}].{key}") for key in item) for i, item in enumerate(conditions)], where)


def _read_cells(value: object, where: str, subject: Subject) -> tuple[tuple[Place, Counts], ...]:
    """Read of the cells in which some answer decides nothing what each answer was, in the order of the labels."""
    cells: list[tuple[Place, Counts]] = []
    for i, item in enumerate(read_list(value, where)):
        place = f"{where}[{i}]"
        members = read_object(item, place, ("context", "group", "read"), optional=LOST)
        context = read_strings(members["context"], f"{place}.context", len(subject.columns.context))
        group = members["group"]
        labels = () if group is None else read_strings(group, f"{place}.group", len(subject.columns.group))
        counts = {name: read_integer(members[name], f"{place}.{name}") for name in ANSWERS if name in members}
        if len(counts) == 1 or not all(count for name, count in counts.items() if name != "read"):
            raise malformed(place, "must have some answer that decides nothing, and no such key with 0")
        cells.append(((context, labels), counts))
    if any(one >= other for (one, _), (other, _) in pairwise(cells)):
        raise malformed(where, "is not in increasing order of context and group, each once")
    return tuple(cells)


def check_evaluation(stated: Evaluation, steps: Sequence[Step], table: Table) -> Iterator[Finding]:
    """Compare how many answers of each kind there are, in all and by cell, with the table; and add up what was read."""
    held = tuple(name for name in LOST if name != ERROR or stated.errors == "bound")
    actual = dict(_by_cell(table, held))
    for name in ("read", *held):
        yield compared(f"subject.evaluation.answers.{name}", stated.answers[name], sum(counts.get(name, 0) for counts in actual.values()))
    if stated.cells is not None:
        fault = _fault_of_cells(stated, actual)
        beside = sum(counts.get(ERROR, 0) for place, counts in stated.cells if place not in actual)
        also = f"; {beside:,} errors are of cells that the table does not have" if beside else ""
        yield finding_of(f"subject.evaluation.cells: of each the answers that decide nothing{also}", not fault, fault)
    left_out = [step.amount for step in steps if step.step == "left out" and step.unit == "decisions"]
    yield compared("subject.evaluation.samples.rows", (stated.rows, 1), sum_of([(sum(stated.answers.values()), 1), *left_out]))
    yield _check_counted(stated, steps)
    if stated.options and not stated.recipe:  # a recipe makes decisions of what was chosen
        yield from _check_options(stated.options, held, steps, table)
    if stated.all_count:
        yield compared("subject.evaluation.samples.read", stated.read, stated.counted)


def _check_options(options: Labels, held: Sequence[str], steps: Sequence[Step], table: Table) -> Iterator[Finding]:
    """Compare what there was to choose with the decisions of the table that occur, whose labels may have been merged."""
    decision = table.header.subject.columns.decision
    known = {*options, *held, *(step.label for step in steps if step.column == decision)}
    places = [u for u, label in enumerate(table.header.decisions) if label not in known]
    occurring = (u for u in places if any(cell.law[0][u] for cell in table.cells) or any(row.counts[u][0] for row in table.unknown))
    other = next((table.header.decisions[u] for u in occurring), None)
    fault = "" if other is None else f"the table has the decision {shown(other)}"
    yield finding_of("subject.evaluation.options: each decision is one of them, or of an answer that decides nothing", not fault, fault)


def _check_counted(stated: Evaluation, steps: Sequence[Step]) -> Finding:
    """Compare how many samples count with the rows that they made, and with how many made none by a recipe."""
    own = [step.amount for step in steps if stated.recipe and step.unit == "lines" and step.reason == UNMADE]
    actual = reduced(*sum_of([(stated.rows, RECIPES.get(stated.recipe, 1)), *own]))
    if not stated.each:
        return compared("subject.evaluation.samples.counted", (stated.counted, 1), actual)
    statement = f"subject.evaluation.samples.counted is {stated.counted}, and each of these made a row"
    fault = "" if at_most((stated.counted, 1), actual) else f"the table has rows of {shown(actual)} at the most"
    return finding_of(statement, not fault, fault)


def _fault_of_cells(stated: Evaluation, actual: Mapping[Place, Counts]) -> str:
    """Say what in the table contradicts the list of cells; errors that were dropped are in no table, and add up by themselves."""
    listed = dict(stated.cells or ())
    dropped = 0
    for place, counts in listed.items():
        own = dict(counts)
        dropped += own.pop(ERROR, 0) if stated.errors == "drop" else 0
        if own != (given := actual.get(place, {"read": 0})):
            return f"the table gives {shown(given)} for {shown(place)}"
    absent = next((place for place, counts in actual.items() if len(counts) > 1 and place not in listed), None)
    if absent is not None:
        return f"{shown(absent)} is not there, of which the table gives {shown(actual[absent])}"
    if dropped + stated.unlabelled != stated.dropped:
        return f"of {stated.dropped} errors that were left out, those of cells are {dropped}, and {stated.unlabelled} are of none"
    return ""


def _by_cell(table: Table, held: Sequence[str]) -> Iterator[tuple[Place, Counts]]:
    """Count the answers of each cell of a table, and those of unknown group in each context."""
    header = table.header
    at = {name: header.decisions.index(name) for name in held if name in header.decisions}

    def counts(whole: Sequence[int]) -> Counts:
        lost = {name: whole[u] for name, u in at.items() if whole[u]}
        return {"read": sum(whole) - sum(lost.values()), **lost}

    if not counts_are_whole(table) or any(d != 1 for row in table.unknown for _, d in row.counts):
        raise malformed("the table of the certificate", "has counts that are not whole, which are of no evaluation log")
    for cell in table.cells:
        weights, total = cell.law
        times = cell.mass[0] // total
        yield (header.contexts[cell.context], header.groups[cell.group]), counts([times * weight for weight in weights])
    for row in table.unknown:
        yield (header.contexts[row.context], ()), counts([n for n, _ in row.counts])
