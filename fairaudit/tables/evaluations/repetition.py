"""What was drawn: as counted of the questions, their repetitions, and the units in which they are."""

from __future__ import annotations

from collections import Counter
from collections.abc import Hashable, Sequence
from dataclasses import dataclass, field

from fairaudit.errors import InputError, shown
from fairaudit.tables.evaluations.extraction import Wanted
from fairaudit.tables.evaluations.paths import Step, read_path
from fairaudit.tables.evaluations.samples import Drawn, Format, Run

__all__ = ["Questions", "drawn_of", "question_of"]


@dataclass
class Questions:
    """In which units the questions of a log are.

    Attributes
    ----------
    units : dict of int to int
        The unit of each repetition of a question, all known by their hashes.
    first : dict of int to int
        The unit of the first repetition of a question, in logs that have repetitions.
    further : Counter
        How many further repetitions a question has.
    tasks : dict of str to None
        What the questions are of.
    apart : bool
        Whether repetitions of a question are in several units.
    again : str
        A question of which one repetition is in several units, or, where there are no units, in several samples; empty if there is none.

    Examples
    --------
    >>> questions = Questions()
    >>> for epoch, unit in (("1", "q1"), ("2", "q1")):
    ...     questions.add("task", "q1", epoch, unit)
    >>> questions.repetitions, questions.apart, questions.again
    (2, False, '')
    >>> questions.add("task", "q1", "2", "another unit")
    >>> questions.again
    'q1'
    """

    units: dict[int, int] = field(default_factory=dict)
    first: dict[int, int] = field(default_factory=dict)
    further: Counter[int] = field(default_factory=Counter)
    tasks: dict[str, None] = field(default_factory=dict)
    apart: bool = False
    again: str = ""

    @property
    def repetitions(self) -> int:
        """How many repetitions a question has at the most."""
        return 1 + max(self.further.values(), default=0)

    def add(self, task: str, question: str, repetition: str | None, unit: Hashable | None) -> None:
        """Note a sample: its question and repetition, None in a log that has none, and its unit, None where it is by itself."""
        if task not in self.tasks:
            self.tasks[task] = None
        own = hash(repr(unit))  # to hash, -1 is -2
        key = hash((task, question, repetition))
        known = self.units.get(key)
        if known is not None:
            if not self.again and (known != own or unit is None):
                self.again = question
            return
        self.units[key] = own
        if repetition is None:
            return
        which = hash((task, question))
        if which not in self.first:
            self.first[which] = own
            return
        self.further[which] += 1
        self.apart = self.apart or self.first[which] != own


def drawn_of(log: Format, wanted: Wanted, runs: Sequence[Run], questions: Questions) -> Drawn:
    """Say what was drawn, by the unit that was named and by what was counted.

    Raises
    ------
    InputError
        If samples may belong together and no unit says how, or the unit takes one question for several.
    """
    if not log.name:
        return "units"
    if not log.question:
        if not wanted.unit:
            raise InputError(
                f"a log of {log.name} does not tell a repeated question from another one; name with --unit (unit) the path of what tells "
                "questions apart"
            )
        return "units"
    return _of_units(log, wanted, questions) if wanted.unit else _of_samples(log, wanted, runs, questions)


def _of_units(log: Format, wanted: Wanted, questions: Questions) -> Drawn:
    """Say what was drawn, where units are named."""
    tasks, named = questions.tasks, _named(log.question, wanted.unit)
    if named and len(tasks) > 1 and not any(_named(path, wanted.unit) for path in ("eval.task", "file", log.task)):
        raise InputError(
            f"the logs are of several tasks ({', '.join(map(shown, sorted(tasks)))}), in which the same {log.question} names different "
            f"questions; --unit {log.question},eval.task tells them apart"
        )
    if questions.again:
        once = f", where {log.repetition} is the same," if log.repetition else ""
        raise InputError(
            f"the unit {','.join(wanted.unit)} takes one question for several: {log.question} {shown(questions.again)} is in more than one "
            f"unit{once} because another file, model or row has it, too; --unit {log.question} counts each question once"
        )
    if questions.apart or (log.repetition and _named(log.repetition, wanted.unit)):
        return "answers"
    return "questions" if named else "units"


def _of_samples(log: Format, wanted: Wanted, runs: Sequence[Run], questions: Questions) -> Drawn:
    """Say what was drawn, where each sample is taken for a draw."""
    within = _named(log.question, wanted.columns)
    epochs = max(questions.repetitions, *(run.epochs for run in runs))
    if epochs > 1 and not within:
        raise InputError(
            f"each question was asked {epochs} times; say what was drawn: --unit {log.question} (questions were drawn; epochs of a "
            f"question count once) or --unit {log.question},{log.repetition} (the questions are fixed; the model's answers were drawn)"
        )
    if questions.again or (len({run.model for run in runs}) > 1 and not within):
        several = len({run.model for run in runs}) > 1
        what = (
            "several models were asked the same questions" if several else f"{log.question} {shown(questions.again)} is there several times"
        )
        raise InputError(f"{what}; --unit {log.question} says that the answers to a question are no separate draws")
    return "answers" if within else "questions"


def question_of(log: Format, columns: Sequence[str]) -> str:
    """What names a question: the column that does, however it is written, or else the path; empty where nothing does."""
    return next((name for name in columns if _named(log.question, [name])), log.question)


def _named(path: str, among: Sequence[str]) -> bool:
    """Whether a path is among others, however it is written."""
    return bool(path) and _steps(path) in map(_steps, among)


def _steps(path: str) -> tuple[Step, ...]:
    try:
        return read_path(path).steps
    except InputError:
        return (path,)
