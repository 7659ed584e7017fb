"""What is asked of an evaluation log beyond its columns."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, fields
from typing import Literal, get_args

from fairaudit.errors import InputError, nearest, shown

__all__ = ["FORMATS", "NAMES", "NOTHING_ASKED", "RECIPES", "Errors", "Extraction", "MissingSamples", "Wanted", "extraction_of"]

FORMATS = ("inspect", "lm-eval", "eee", "helm", "promptfoo", "openai", "openai-evals")
"""Names of the formats of evaluation logs."""

RECIPES = ("bbq", "bbq-accuracy")
"""Names of the recipes."""

MissingSamples = Literal["refuse", "accept"]

Errors = Literal["refuse", "drop", "bound"]


@dataclass(frozen=True)
class Extraction:
    """How answers are found in an evaluation log, and which samples count.

    Attributes
    ----------
    log_format : str or None
        The format, where it is not to be found from the content.
    extract : str or None
        A regular expression whose one group, of exactly one match, is the decision.
    options : tuple of str
        What there was to choose: the decision is the option that the answer (or what was taken out of it) clearly chooses.
    join : tuple of (str, str) or None
        A file of rows, and the column by which they belong to samples.
    where : tuple of (str, str)
        Paths, and the text that each must have for a sample to count.
    errors : {"refuse", "drop", "bound"}
        What becomes of samples without an answer: an error, left out and stated, or counted as decisions of unknown meaning.
    missing_samples : {"refuse", "accept"}
        What becomes of a log that holds fewer samples than it should.
    recipe : str or None
        A known data set whose rows are made by a recipe of its own, and after a colon the path of the answers: ``bbq:answer``.
    """

    log_format: str | None = None
    extract: str | None = None
    options: tuple[str, ...] = ()
    join: tuple[str, str] | None = None
    where: tuple[tuple[str, str], ...] = ()
    errors: Errors = "refuse"
    missing_samples: MissingSamples = "refuse"
    recipe: str | None = None

    @property
    def given(self) -> bool:
        """Whether anything is asked that only samples of a log can answer."""
        return self != NOTHING_ASKED

    @property
    def asked(self) -> dict[str, object]:
        """What is asked, by the names of the options."""
        return {name: getattr(self, name) for name in NAMES if getattr(self, name) != getattr(NOTHING_ASKED, name)}

    def refuse(self, what: str) -> None:
        """Refuse what is asked of a table that has no samples.

        Raises
        ------
        InputError
            If anything is asked.
        """
        for name in self.asked:
            option = "--" + name.replace("_", "-")
            raise InputError(f"{option} ({name}) goes with logs of evaluations, JSON lines and Parquet, and not with {what}")


NAMES = tuple(each.name for each in fields(Extraction))
"""The options that say what is asked."""

NOTHING_ASKED = Extraction()


@dataclass(frozen=True)
class Wanted:
    """What is wanted of the samples of a log.

    Attributes
    ----------
    columns : tuple of str
        Names or paths of the columns that tell rows apart.
    decision : str or None
        Which of them is the decision.
    group, unit : tuple of str
        Which of them are groups, and which the sampling unit.
    extraction : Extraction
        What is asked beyond columns.
    report : callable or None
        Told how many samples were read.
    """

    columns: tuple[str, ...]
    decision: str | None = None
    group: tuple[str, ...] = ()
    unit: tuple[str, ...] = ()
    extraction: Extraction = NOTHING_ASKED
    report: Callable[[float | None, int | None], None] | None = None


def extraction_of(
    *,
    log_format: str | None = None,
    extract: str | None = None,
    options: str | Sequence[str] = (),
    join: str | None = None,
    where: Mapping[str, str] | Sequence[str] = (),
    errors: str = "refuse",
    missing_samples: str = "refuse",
    recipe: str | None = None,
) -> Extraction:
    """Read what is asked of an evaluation log as a command or a caller writes it.

    Parameters
    ----------
    log_format, extract, errors, missing_samples, recipe : str
        As in `Extraction`.
    options : str or sequence of str
        What there was to choose; a text names them between commas.
    join : str
        ``FILE:COLUMN``.
    where : mapping of str to str, or sequence of str
        Paths with the text that each must have; as texts ``PATH=VALUE``.

    Raises
    ------
    InputError
        If something is of another form.

    Examples
    --------
    >>> extraction_of(join="prompts.csv:custom_id", where=["filter=first"]).where
    (('filter', 'first'),)
    """
    for name, value, known in (
        ("log_format", log_format, FORMATS),
        ("errors", errors, get_args(Errors)),
        ("missing_samples", missing_samples, get_args(MissingSamples)),
        ("recipe", recipe and recipe.partition(":")[0], RECIPES),
    ):
        if value is not None and value not in known:
            raise InputError(f"{name} {shown(value)} is not known; {nearest(value, known)}")
    file, colon, column = ("", ":", "") if join is None else join.rpartition(":")
    if join is not None and not (file and colon and column):
        raise InputError(f"{shown(join, 200)} does not say what to join; write FILE:COLUMN, such as prompts.csv:custom_id")
    if isinstance(where, Mapping):
        conditions = [(str(path), str(text)) for path, text in where.items()]
    else:
        conditions = [_condition(text) for text in ([where] if isinstance(where, str) else where)]
    given: dict[str, str] = {}
    for path, text in conditions:
        if given.setdefault(path, text) != text:
            raise InputError(f"{shown(path, 200)} cannot be both {shown(given[path])} and {shown(text)}; where takes one value of a path")
    return Extraction(
        log_format,
        extract,
        _choices(options),
        None if join is None else (file, column),
        tuple(given.items()),
        errors,  # type: ignore[arg-type]  # one of the known
        missing_samples,  # type: ignore[arg-type]  # one of the known
        recipe,
    )


def _choices(options: str | Sequence[str]) -> tuple[str, ...]:
    """What there was to choose."""
    if not options:
        return ()
    from fairaudit.tables.evaluations.choices import asked_of_log

    names = [name.strip() for name in options.split(",")] if isinstance(options, str) else options
    if not isinstance(names, Sequence) or not all(isinstance(name, str) for name in names):
        raise InputError(f"options are {shown(options)}; texts such as yes,no or a list of texts are accepted")
    return asked_of_log(names).options


def _condition(text: str) -> tuple[str, str]:
    path, sign, value = text.partition("=")
    if not sign or not path.strip() or not value:
        raise InputError(f"{shown(text, 200)} is no condition; write PATH=VALUE, such as filter=first")
    return path.strip(), value
