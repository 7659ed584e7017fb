"""Samples of logs counted: paths, rows of another file, conditions, answers that decide nothing, and what must not be counted twice."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import nullcontext
from dataclasses import replace
from functools import lru_cache, partial
from itertools import islice
from pathlib import Path as File
from typing import TYPE_CHECKING, Any

from fairaudit.errors import InputError, naming, nearest, shown
from fairaudit.tables.evaluations.columns import SAID, Column, clean, file_names, known_paths, meant, plain
from fairaudit.tables.evaluations.expressions import Expression
from fairaudit.tables.evaluations.extraction import Wanted
from fairaudit.tables.evaluations.joining import Joined, joined_rows
from fairaudit.tables.evaluations.paths import ABSENT, EACH, is_path, read_path, value_at, written_path
from fairaudit.tables.evaluations.recipes.known import answer_path, recipe_of
from fairaudit.tables.evaluations.recipes.recipe import Recipe
from fairaudit.tables.evaluations.repetition import Questions, drawn_of, question_of
from fairaudit.tables.evaluations.same_samples import ASKED, Together
from fairaudit.tables.evaluations.samples import NOTHING_DECIDED, Evaluation, Format, Run, Sample
from fairaudit.tables.label_text import label_text
from fairaudit.tables.preparation import unread
from fairaudit.tables.tally import Tally

if TYPE_CHECKING:
    from fairaudit.tables.evaluations.choices import Choice

__all__ = ["read"]

LARGEST = 10**12  # samples that a log may say it holds, and times that a question was asked

EVERY = 4096  # samples between two words on how far the work is

NOTHING: Mapping[str, Any] = {}

Asked = tuple[str, str, str | None]
"""The task, the question and its repetition."""


class _Reader:
    """Takes samples of logs of one format, and keeps what is counted of them."""

    def __init__(self, log: Format, wanted: Wanted, *, several: bool = False) -> None:
        asked = wanted.extraction
        _check_roles(wanted)
        self.log, self.wanted, self.several = log, wanted, several
        self.columns = tuple(map(Column.named, wanted.columns))
        self.decision = None if wanted.decision is None else wanted.columns.index(wanted.decision)
        self.units = tuple(place for place, name in enumerate(wanted.columns) if name in wanted.unit)
        self.groups = tuple(place for place, name in enumerate(wanted.columns) if name in wanted.group)
        self.models = tuple(place for place in self.groups if wanted.columns[place] in ASKED)
        together = bool(self.models and self.units) and asked.missing_samples == "refuse"
        asked_of, asked_about = (tuple(wanted.columns[place] for place in at) for at in (self.models, self.units))
        self.together = Together(asked_of, asked_about) if together else None
        self.each = _each(self.columns, wanted)
        self.where = tuple((Column.named(path), text) for path, text in asked.where)
        self.key = tuple(map(Column.named, log.key))
        told = {*wanted.columns, *(path for path, _ in asked.where)}
        self.single: tuple[tuple[Column, dict[str, None]], ...] = tuple((Column.named(path), {}) for path in log.single if path not in told)
        self.apart = tuple(Column.named(path) for path in log.apart if path not in told) if self.units else ()
        self.parts: dict[tuple[Any, ...], tuple[str | None, ...]] = {}
        self.questions = Questions()
        self.once = not log.repetition and wanted.unit == (log.question,)  # each question is its own unit, and has no repetition
        self.by_file = "file" in wanted.columns
        self.asked = tuple(log.key.index(path) if path else -1 for path in (log.task, log.question, log.repetition))
        self.expression = None if asked.extract is None else Expression(asked.extract)
        self.joined: Joined | None = None if asked.join is None else joined_rows(*asked.join)
        self.join = None if self.joined is None else Column.named(self.joined.column)
        self.choice = _chooser(asked.options) if asked.options else None
        self.recipe = None if asked.recipe is None else recipe_of(asked.recipe)
        self.answer = None if asked.recipe is None else Column.named(answer_path(asked.recipe, log.name))
        self.unmade: Counter[str] = Counter()
        self.rows: dict[tuple[Any, ...], int] = {}
        self.read = self.counted = self.answered = self.made = 0
        self.taken, self.unfit = False, ""
        self.errors: Counter[tuple[Any, ...]] = Counter()
        self.keys: set[int] = set()
        self.passed: dict[str, dict[str, None]] = {column.name: {} for column, _ in self.where}
        self.ordinary: set[str] = set()
        self.outcomes: Counter[str] = Counter()
        self.example: Mapping[str, Any] = {}

    @property
    def tops(self) -> frozenset[str]:
        """Keys at the top of a sample that are wanted."""
        columns = [
            *self.columns,
            *(column for column, _ in self.where),
            *self.key,
            *(column for column, _ in self.single),
            *([] if self.join is None else [self.join]),
            *([] if self.answer is None else [self.answer]),
        ]
        named = {name for column in columns for name in (column.name, *([] if column.path is None else [column.path.top]))}
        return frozenset(named if self.recipe is None else named | {*self.recipe.tops})

    def take(self, sample: Sample, run: Run, said: Mapping[str, str]) -> None:
        """Count a sample."""
        row, outcome = sample.row, sample.outcome
        if not self.read or (outcome == "read" and not self.outcomes["read"]):
            self.example = row
        self.read += 1
        asked = self._asked(row, run, said) if self.key else None
        beside = NOTHING if self.joined is None or self.join is None else self.joined.of(self._value(self.join, row, NOTHING, said))
        if self.where and not self._fits(sample, beside, said):
            return
        self.counted += 1
        self.outcomes[outcome] += 1
        for column, single in self.single:
            held = column.of(row, beside, said)
            if type(held) is not str or held not in single:
                single[label_text(plain(clean(held, column.name))) or "nothing"] = None
        if asked is not None and not self.units:
            self.questions.add(*asked, None)
        for values in self._values(row, beside, said) if self.recipe is None else self._made(self.recipe, row, beside, said, outcome):
            if self.decision is not None and self.recipe is None:
                values[self.decision] = self._decision(values[self.decision], outcome)
            if outcome == "error":
                self.errors[tuple(values[place] for place in self.groups)] += 1
            if self.apart and any(values[place] is not None for place in self.units):
                self._check_apart(values, tuple(self._text(column, row, beside, said) for column in self.apart))
            if self.units:
                unit = tuple([values[place] for place in self.units])
                if asked is not None and self.once:
                    self.questions.tasks[asked[0]] = None
                elif asked is not None:
                    self.questions.add(*asked, unit)
                if self.together is not None:
                    self.together.add(tuple([values[place] for place in self.models]), unit)
            counted = tuple(values)
            self.made += 1
            self.rows[counted] = self.rows.get(counted, 0) + 1

    def _fits(self, sample: Sample, beside: Mapping[str, Any], said: Mapping[str, str]) -> bool:
        """Whether all conditions are met, as far as a sample says; one that failed may not."""
        for column, text in self.where:
            value = self._text(column, sample.row, beside, said)
            if value != text and not (value is None and sample.outcome == "error"):
                if len(seen := self.passed[column.name]) < 10:
                    seen["nothing" if value is None else shown(value)] = None
                return False
        return True

    def _asked(self, row: Mapping[str, Any], run: Run, file: Mapping[str, str]) -> Asked | None:
        """What was asked, in a log that has questions; a sample is refused if another one of its file is the same by its key."""
        values = [column.of(row, NOTHING, NOTHING) for column in self.key]
        name = file.get("file") if self.by_file else ""
        texts = list(map(str, values))  # 1 and "1" would be one unit
        key = hash((run.model, run.task, name, *texts))
        if key in self.keys:
            told = [shown(None if value is ABSENT else value) for value in values]
            said = ", ".join(f"{column.name} {text}" for column, text in zip(self.key, told, strict=True))
            ways = f"; leave one file out, or compare them by --group file (group) and --unit {self.log.question} (unit)"
            raise InputError(
                f"the sample with {said} is there twice{f' for the model {shown(run.model)}' if run.model else ''}"
                f"{ways if self.several and self.log.question else ''}"
            )
        self.keys.add(key)
        task, question, repetition = self.asked
        if question < 0:
            return None
        return run.task if task < 0 else texts[task], texts[question], None if repetition < 0 else texts[repetition]

    def _check_apart(self, values: Sequence[Any], parts: tuple[str | None, ...]) -> None:
        labels = tuple(value for place, value in enumerate(values) if place != self.decision)
        if (known := self.parts.setdefault(labels, parts)) != parts:
            (path, first, second) = next((column.name, a, b) for column, a, b in zip(self.apart, known, parts, strict=True) if a != b)
            unit = ", ".join(f"{self.columns[place].name} {shown(plain(values[place]))}" for place in self.units)
            raise InputError(
                f"{unit} has the same labels in {path} {first} and {second}, which are other prompts or providers; name {path} with "
                f"--context (context) or choose one with --where {path}={first} (where)"
            )

    def _value(self, column: Column, row: Mapping[str, Any], beside: Mapping[str, Any], said: Mapping[str, Any]) -> Any:
        return plain(clean(column.of(row, beside, said), column.name))

    def _text(self, column: Column, row: Mapping[str, Any], beside: Mapping[str, Any], said: Mapping[str, Any]) -> str | None:
        return label_text(self._value(column, row, beside, said))

    def _values(self, row: Mapping[str, Any], beside: Mapping[str, Any], said: Mapping[str, Any]) -> list[list[Any]]:
        """The values of the columns: one list, or one for each element of the list that is taken apart."""
        first = [column.of(row, beside, said) for column in self.columns]
        if self.each is None:
            rows = [first]
        else:
            held = value_at(row, self.each, written_path(self.each))
            if held is ABSENT or held is None or held == []:
                rows = [first]
            elif not isinstance(held, list):
                raise InputError(f"{shown(written_path((*self.each, EACH)))} takes a list apart, and there is {shown(held)}")
            else:
                rows = [
                    [self._inner(column, value, element) for column, value in zip(self.columns, first, strict=True)] for element in held
                ]
        for values in rows:
            for place, value in enumerate(values):
                if type(value) is not str:  # which most are
                    values[place] = clean(value, self.columns[place].name)
        return rows

    def _made(
        self, recipe: Recipe, row: Mapping[str, Any], beside: Mapping[str, Any], said: Mapping[str, Any], outcome: str
    ) -> Iterator[list[Any]]:
        """The values of the columns in the rows that a recipe makes of a sample."""
        assert self.answer is not None  # noqa: S101
        answer = plain(clean(self.answer.of(row, beside, said), self.answer.name))
        rows = recipe.rows({**beside, **row}, label_text(self._decision(answer, outcome)) or "")
        if isinstance(rows, str):
            self.unmade[rows] += 1
            return
        for made in rows:
            yield from self._values({**row, **made}, beside, said)

    def _inner(self, column: Column, value: Any, element: Any) -> Any:
        if column.inner is None or value is not ABSENT:
            return value
        column.found.add("path")
        return value_at(element, column.inner, column.name)

    def _decision(self, value: Any, outcome: str) -> Any:
        """The decision of a sample, or the word for an answer that decides nothing."""
        if outcome != "read" and not (outcome == "truncated" and self._stands_whole(value)):
            return outcome
        self.answered += 1
        if (self.expression is not None or self.choice is not None) and value is not None:
            answer = label_text(plain(value)) or ""
            value = self._taken(answer)
            if value is None:
                self.unfit = self.unfit or answer
                return "unreadable"
            self.taken = True
        if value is None or (isinstance(value, str) and not value.strip()):
            return "unreadable" if self.log.name else value
        if isinstance(value, str) and value.strip().casefold() in NOTHING_DECIDED:
            self.ordinary.add(value)
        return value

    def _stands_whole(self, value: Any) -> bool:
        """Whether an answer that was cut off is nothing but what is taken out of answers."""
        if not isinstance(value, str) or (self.expression is not None and not self.expression.is_all(value)):
            return False
        return self.expression is not None if self.choice is None else self._taken(value, cut=True) is not None

    def _taken(self, answer: str, *, cut: bool = False) -> str | None:
        """What the expression takes out of an answer in words; and the option that it chooses, where there are such."""
        taken = answer if self.expression is None else self.expression.of(answer)
        return taken if taken is None or self.choice is None else self.choice(taken, cut=cut).option or None

    def check(self, paths: Sequence[str]) -> None:
        """Refuse what cannot be counted as it stands.

        Raises
        ------
        InputError
            If there is such.
        """
        name = ", ".join(paths[:3])
        if not self.read:
            raise InputError(f"{name}: the log has no samples")
        if not self.counted:
            column, text = self.where[0]
            seen = ", ".join(self.passed[column.name]) or "other values in other paths"
            raise InputError(f"{name}: no sample fits all of where; {column.name} is to be {shown(text)}, and there is {seen}")
        if self.recipe is not None and not self.rows:
            raise InputError(f"{name}: no sample is left ({'; '.join(f'{number}: {why}' for why, number in self.unmade.items())})")
        for column in (*self.columns, *(column for column, _ in self.where), *([] if self.answer is None else [self.answer])):
            self._check_found(column, paths)
        self._check_single(name)
        self._check_errors(name)
        self._check_taken(name)
        lost = self.outcomes["refused"] + self.outcomes["truncated"]
        if lost and self.decision is None and self.recipe is None:
            raise InputError(
                f"{name}: {lost} of {self.counted} answers were refused or cut off, which only a decision can say; name with --decision "
                "(decision) where answers stand"
            )
        self._check_units(name)
        if self.joined is not None and self.wanted.extraction.missing_samples == "refuse":
            self.joined.refuse_unused()
        if self.together is not None:
            with naming(name):
                self.together.check()

    def _check_units(self, name: str) -> None:
        """Refuse a unit whose name is a number in some samples and the same text in others: they may be two."""
        for place in self.units:
            values = {row[place] for row in self.rows}
            texts = {value for value in values if isinstance(value, str)}
            both = texts and texts & {label_text(plain(value)) for value in values if not isinstance(value, str)}
            if both:
                raise InputError(
                    f"{name}: {shown(self.columns[place].name, 200)} is {min(both)} in some samples, and the text {shown(min(both))} in "
                    "others; give it one form in all, if they are the same"
                )

    def _check_single(self, name: str) -> None:
        for column, seen in self.single:
            if len(seen) > 1:
                listed, path = ", ".join(map(shown, list(seen)[:10])), column.name
                raise InputError(
                    f"{name}: samples are repeated for each {path} ({listed}); choose one with --where {path}={next(iter(seen))} (where)"
                )

    def _check_errors(self, name: str) -> None:
        if self.errors and self.wanted.extraction.errors == "refuse":
            names = [self.columns[place].name for place in self.groups]
            of_groups: Counter[tuple[Any, ...]] = Counter()
            for row, number in self.rows.items():
                of_groups[tuple(row[place] for place in self.groups)] += number
            most = sorted(of_groups, key=lambda group: (-self.errors[group], repr(group)))[:10]
            of = {group: ", ".join(f"{name}={plain(label)}" for name, label in zip(names, group, strict=True)) for group in most}
            parts = [f"{of[group]} {self.errors[group]} of {of_groups[group]}" for group in most]
            by = f" ({'; '.join(parts)})" if names else ""
            raise InputError(
                f"{name}: {sum(self.errors.values())} of {self.counted} samples have no answer{by}; --errors drop leaves them out and "
                "states them, --errors bound lets them have meant anything"
            )

    def _check_taken(self, name: str) -> None:
        if self.choice is not None and self.unfit and not self.taken:
            names = ", ".join(map(shown, self.wanted.extraction.options[:10]))
            raise InputError(
                f"{name}: none of {self.answered} answers clearly chooses one of --options (options) {names}; the first is "
                f"{shown(self.unfit, 200)}, and a choice is an option by itself, 'My answer is …' and the like, or JSON with a field answer"
            )
        if self.expression is not None and self.unfit and not self.taken:
            raise InputError(
                f"{name}: --extract (extract) took nothing out of any of {self.answered} answers; the first is {shown(self.unfit, 200)}, "
                "and the expression has to fit in it ((?i) at its beginning ignores case)"
            )

    def _check_found(self, column: Column, paths: Sequence[str]) -> None:
        name = ", ".join(paths[:3])
        if column.name == self.wanted.decision and not self.answered:
            return
        if self.joined is not None and column.name in self.joined.columns and column.found - {"join"} and column.name != self.joined.column:
            raise InputError(f"{name}: both the log and {self.joined.name} have {shown(column.name)}; rename one of them")
        if len(column.found) > 1:
            raise InputError(
                f"{name}: some rows have a column {shown(column.name)}, in others this is a path to a value; give them one form"
            )
        if not column.found and column.inner is None:
            if is_path(column.name):
                with naming(name):
                    read_path(column.name)
            known = [*([] if self.joined is None else self.joined.columns), *self._known(paths[0]), *(SAID if self.log.name else ())]
            what = "path" if is_path(column.name) else "column"
            raise InputError(f"{name}: there is no {what} {shown(column.name, 200)}; {meant(column, known)}")

    def _known(self, path: str) -> list[str]:
        """Paths of a whole sample, those first that are worth a look."""
        samples = islice(self.log.samples(path, ()), EVERY)
        known = known_paths(next((sample.row for sample in samples if sample.outcome == "read"), self.example))
        parts = {read_path(part.replace("*", "x")).top for part in (*self.log.parts, *self.log.answers) if not part.startswith("argmax")}
        return sorted(known, key=lambda path: read_path(path).top not in parts)

    def clash(self) -> str:
        """An ordinary decision that would be taken for an answer that decides nothing; empty if there is none."""
        return next(iter(sorted(self.ordinary)), "")


def _chooser(options: tuple[str, ...]) -> Callable[..., Choice]:
    """What reads which of some options an answer chooses."""
    from fairaudit.tables.evaluations.choices import asked_of_log, read_choice

    return lru_cache(partial(read_choice, asked=asked_of_log(options)))


def read(paths: Sequence[str], log: Format, wanted: Wanted) -> Tally:
    """Count the samples of logs of one format.

    Parameters
    ----------
    paths : sequence of str
        The files.
    log : Format
        How they are read; its name is empty for rows of no known format.
    wanted : Wanted
        The columns, and what is asked beyond them.

    Returns
    -------
    Tally
        The different rows and their counts, with what a certificate says of how they were read.

    Raises
    ------
    InputError
        If a file cannot be read, a path leads nowhere, samples are missing or occur twice, or answers are missing and that was not
        allowed.
    """
    asked = wanted.extraction
    reader = _Reader(log, wanted, several=len(paths) > 1)
    runs: list[tuple[str, Run]] = []
    expected: list[int] = []
    named = file_names(paths)
    tops = reader.tops
    for path in paths:
        run = log.run(path)
        runs.append((path, run))
        before = reader.read
        said = dict(zip(SAID, (named[path], run.model, run.task), strict=True))
        said = {name: text for name, text in said.items() if text}
        with nullcontext() if reader.expression is None else reader.expression.limited():
            for sample in log.samples(path, tops):
                try:
                    reader.take(sample, run, said)
                except InputError as error:
                    raise InputError(f"{path}, {sample.where}: {error}") from None
                if wanted.report is not None and not reader.read % EVERY:
                    wanted.report(None, reader.read)
        _check_number(path, run, reader.read - before, accept=asked.missing_samples == "accept")
        expected.append(reader.read - before if run.expected is None else run.expected)
    reader.check(paths)
    with naming(", ".join(paths[:3])):
        drawn = drawn_of(log, wanted, [run for _, run in runs], reader.questions)
    cells = ((*map(plain, row), number) for row, number in reader.rows.items())
    tally = Tally.of(File(paths[0]).name, list(wanted.columns), cells).conserving(reader.made, "fairaudit")
    if not log.name and reader.each is None and not asked.given:
        return tally
    if clash := reader.clash():
        raise InputError(
            f"{', '.join(paths[:3])}: the decision {shown(clash)} is a word for answers that decide nothing; take decisions out of the "
            "answers with --extract (extract) or --options (options), or write it anew in the log"
        )
    lost = sum(reader.unmade.values())
    return replace(
        tally,
        notes=(*tally.notes, *(f"{number} of {reader.counted} samples make no row: {why}" for why, number in reader.unmade.items())),
        preparation=(unread("unusable value", lost),) if lost else (),
        evaluation=Evaluation(
            format=log.name or "rows",
            extract=asked.extract,
            options=asked.options,
            join=None if asked.join is None else asked.join[1],
            where=asked.where,
            epochs=max(reader.questions.repetitions, *(run.epochs for _, run in runs)),
            expected=None if all(run.expected is None for _, run in runs) else sum(expected),
            read=reader.read,
            recipe=asked.recipe,
            question=question_of(log, (*wanted.unit, *wanted.columns)),
            unit=wanted.unit,
            each=None if reader.each is None else written_path((*reader.each, EACH)),
            errors=asked.errors,
            runs=tuple(runs),
            counted=reader.counted,
            drawn=drawn,
        ),
    )


def _check_roles(wanted: Wanted) -> None:
    """Refuse a decision that is not among the columns, and what is asked of a decision where none is named."""
    decision, asked = wanted.decision, wanted.extraction
    if decision is not None and decision not in wanted.columns:
        raise InputError(f"the decision {shown(decision, 200)} is not among the columns; {nearest(decision, wanted.columns)}")
    for option in asked.options:
        if option.strip().casefold() in NOTHING_DECIDED:
            raise InputError(f"the option {shown(option)} is a word for answers that decide nothing; take another word")
    for name, given in (("extract", asked.extract is not None), ("options", bool(asked.options)), ("errors", asked.errors != "refuse")):
        if given and decision is None and asked.recipe is None:
            raise InputError(f"--{name} ({name}) goes with a decision; name its column")


def _each(columns: Sequence[Column], wanted: Wanted) -> tuple[Any, ...] | None:
    """The steps to the one list that is taken apart."""
    lists = {
        column.path.steps[: column.path.each]: column.name for column in columns if column.path is not None and column.inner is not None
    }
    if len(lists) > 1:
        first, second = list(lists.values())[:2]
        raise InputError(
            f"{shown(first, 200)} and {shown(second, 200)} take different lists apart; one row is made for each element of one list"
        )
    if lists and not wanted.unit:
        (name,) = lists.values()
        raise InputError(
            f"{shown(name, 200)} makes a row for each element of a list; name with --unit (unit) what was drawn, such as the path of an "
            "id: elements of one list are no separate draws unless you say so"
        )
    return next(iter(lists), None)


def _check_number(path: str, run: Run, read: int, *, accept: bool) -> None:
    """Refuse a log that holds fewer samples than it should, or more, or that says what no log can hold."""
    if max(run.epochs, run.expected or 0) > LARGEST:
        said = f"{run.expected} samples, of {run.epochs} epochs"
        raise InputError(f"{path}: the log says that it should hold {said}; {LARGEST:,} is the most")
    if run.expected is None or read == run.expected:
        return
    status = f", whose status is {shown(run.status)}," if run.status else ""
    if read > run.expected:
        raise InputError(f"{path}: the log{status} holds {read} samples and should hold {run.expected}; it is damaged or was put together")
    if not accept:
        raise InputError(
            f"{path}: the log{status} holds {read} of {run.expected} samples; --missing-samples accept goes on, and the certificate says so"
        )
