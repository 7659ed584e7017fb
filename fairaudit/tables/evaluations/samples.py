"""What a reader of an evaluation log hands over: the run, and its samples one by one."""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal, NamedTuple

from fairaudit.errors import shown
from fairaudit.tables.evaluations.extraction import Errors

__all__ = [
    "ERROR",
    "NOTHING_DECIDED",
    "UNDECIDED",
    "VERBS",
    "Drawn",
    "Dropped",
    "Evaluation",
    "Format",
    "Outcome",
    "Run",
    "Sample",
    "ended",
    "fixed",
]

Outcome = Literal["read", "refused", "truncated", "error"]

Drawn = Literal["questions", "answers", "units"]

REASONS: Mapping[str, Outcome] = {
    "content_filter": "refused",
    "refusal": "refused",
    "length": "truncated",
    "max_output_tokens": "truncated",
    "max_tokens": "truncated",
    "model_length": "truncated",
}

UNDECIDED = ("refused", "unreadable", "truncated")
"""Decisions that an answer is counted as where it decides nothing: refused, not to be understood, cut off."""

ERROR = "error"
"""The decision that a sample is counted as which ended in an error, where such samples are kept."""

VERBS = {"refused": "were refused", "unreadable": "could not be understood", "truncated": "were cut off", ERROR: "ended in an error"}
"""What became of answers that decide nothing, and of samples without one, by the decision that they are counted as."""

NOTHING_DECIDED = (*VERBS,)


class Sample(NamedTuple):
    """A sample of an evaluation log: one question with one answer.

    Attributes
    ----------
    row : mapping
        The sample as it stands in the log, parsed, with what stands once for all of them and what a format adds; paths go into it.
        Numbers with a point are decimals.
    outcome : {"read", "refused", "truncated", "error"}
        Whether the log says by its structure that there is no answer, or that it was refused or cut off. An answer that was cut off may
        still be there: a model that is asked for one token is always cut off.
    form : str
        Where it stands, for messages, with ``{}`` for what differs from sample to sample: ``line {}``, or ``sample {}, epoch {}``.
    places : tuple
        What differs.

    Examples
    --------
    >>> Sample({}, "read", "sample {}, epoch {}", ("q1", 2)).where
    "sample 'q1', epoch 2"
    """

    row: Mapping[str, Any]
    outcome: Outcome
    form: str
    places: tuple[Any, ...] = ()

    @property
    def where(self) -> str:
        """Where it stands, which is written for messages alone."""
        return self.form.format(*map(shown, self.places))


@dataclass(frozen=True)
class Run:
    """What a file of samples says of itself, where it says it.

    Attributes
    ----------
    format : str
        Name of the format.
    producer, model, task, status : str
        What wrote it, with its version; what was asked, about what, and how the run ended, in the words of the log.
    expected : int or None
        How many samples the file should hold, repetitions and filters counted, before any is selected.
    epochs : int
        How often each question was asked.
    fixed : str
        Why nothing was drawn, if the log says so: ``temperature 0`` or ``seed 7``.
    """

    format: str
    producer: str = ""
    model: str = ""
    task: str = ""
    status: str = ""
    expected: int | None = None
    epochs: int = 1
    fixed: str = ""


@dataclass(frozen=True)
class Format:
    """How logs of a format are read.

    Attributes
    ----------
    name : str
        As ``--log-format`` takes it.
    run : callable
        Of a path, what the file says of itself.
    samples : callable
        Of a path, and of the keys at the top of a sample that are wanted, the samples, one at a time; if none are, of all that are worth a
        look. Keys that say what became of a sample, and those of `key`, are always there.
    key : tuple of str
        Paths that together tell two samples of a file apart, where a missing one is a value, too; two equal ones are an error. None where
        a format has none.
    question : str
        Path of what names the question, the same in each repetition; one of `key`, as the two that follow.
    repetition : str
        Path of the number of the repetition.
    task : str
        Path of what the question is of, where samples of one file are of several tasks.
    single : tuple of str
        Paths of which samples that count must have one value, because a sample is repeated for each: another scorer, filter or metric.
    apart : tuple of str
        Paths that tell apart what may bear one label: samples of one unit that agree in all columns and differ here are an error.
    answers : tuple of str
        Where the decision usually is, the best first, with ``*`` for any one name: ``scores.*.answer``.
    parts : tuple of str
        What holds decisions, groups, contexts and units, in the same way, with all that is in it; the rest of a sample is technical.
    beside : callable
        Of a file, those that stand beside it and are read with it, where they are there.
    """

    name: str
    run: Callable[[str], Run]
    samples: Callable[[str, Collection[str]], Iterator[Sample]]
    key: tuple[str, ...] = ()
    question: str = ""
    repetition: str = ""
    task: str = ""
    single: tuple[str, ...] = ()
    apart: tuple[str, ...] = ()
    answers: tuple[str, ...] = ()
    parts: tuple[str, ...] = ()
    beside: Callable[[Path], tuple[Path, ...]] = lambda _: ()


@dataclass(frozen=True)
class Dropped:
    """Samples of a cell that ended in an error and were taken out.

    Attributes
    ----------
    context : tuple of str
        The context.
    group : tuple of str or None
        The group, where it was recorded.
    count : int
        How many there are.
    """

    context: tuple[str, ...]
    group: tuple[str, ...] | None
    count: int


@dataclass(frozen=True)
class Evaluation:
    """How a table was made of an evaluation log.

    Attributes
    ----------
    format : str
        Name of the format; ``rows`` of JSON lines and Parquet.
    extract : str or None
        The regular expression that took the decision out of it.
    options : tuple of str
        What there was to choose, where decisions were read out of answers in words.
    join : str or None
        The column by which rows of another file were joined.
    where : tuple of (str, str)
        Paths, and the text that each had to have for a sample to count.
    epochs : int
        How often each question was asked.
    expected : int or None
        How many samples there should be; None where a log does not say it.
    read : int
        How many samples the logs hold, those that do not count included.
    counted : int
        How many of them count.
    errors : {"refuse", "drop", "bound"}
        What became of samples without an answer.
    drawn : {"questions", "answers", "units"}
        What was drawn: questions, of which repetitions count once; answers to fixed questions; or units of another kind.
    runs : tuple of (str, Run)
        The files, and what each says of itself.
    recipe : str or None
        The recipe that made rows of samples.
    question : str
        What names a question in the log: the column that does, or else the path; empty where nothing does.
    unit : tuple of str
        Columns of the sampling unit, as the log was read.
    each : str or None
        The list of which each element made a row.
    rows : int
        How many rows the samples that count have made; none before labels were merged.
    dropped : tuple of Dropped
        Rows of samples that ended in an error and were taken out, by cell.
    unlabelled : int
        How many more were taken out that have no label of a cell.
    """

    format: str
    extract: str | None = None
    options: tuple[str, ...] = ()
    join: str | None = None
    where: tuple[tuple[str, str], ...] = ()
    epochs: int = 1
    expected: int | None = None
    read: int = 0
    counted: int = 0
    errors: Errors = "refuse"
    drawn: Drawn = "questions"
    runs: tuple[tuple[str, Run], ...] = ()
    recipe: str | None = None
    question: str = ""
    unit: tuple[str, ...] = ()
    each: str | None = None
    rows: int = 0
    dropped: tuple[Dropped, ...] = ()
    unlabelled: int = 0

    @property
    def fixed(self) -> str:
        """Why answers were not drawn, if a log says so."""
        return next((run.fixed for _, run in self.runs if run.fixed), "")

    @property
    def lost(self) -> int:
        """How many rows were taken out because their sample ended in an error."""
        return self.unlabelled + sum(entry.count for entry in self.dropped)

    @property
    def missing(self) -> int:
        """How many samples should be there and are not."""
        return 0 if self.expected is None else max(0, self.expected - self.read)


def ended(reason: object) -> Outcome:
    """Say what an answer is by the reason for which it ended, in the words of models' interfaces.

    Examples
    --------
    >>> ended("stop"), ended("length"), ended("content_filter"), ended(None)
    ('read', 'truncated', 'refused', 'read')
    """
    return REASONS.get(reason, "read") if isinstance(reason, str) else "read"


def fixed(settings: Mapping[str, Any]) -> str:
    """Say why answers were not drawn, if the settings of a model say so.

    Examples
    --------
    >>> fixed({"temperature": 0, "seed": 7}), fixed({"temperature": 1, "seed": 7}), fixed({"do_sample": False}), fixed({"seed": None})
    ('temperature 0', 'seed 7', 'do_sample false', '')
    """
    temperature, seed = settings.get("temperature"), settings.get("seed")
    if not isinstance(temperature, (bool, str)) and temperature == 0:
        return "temperature 0"
    if settings.get("do_sample") is False:
        return "do_sample false"
    return f"seed {seed}" if isinstance(seed, int) and not isinstance(seed, bool) else ""
