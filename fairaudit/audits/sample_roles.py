"""Which path of a log of samples is which, as far as names and labels say: a first command to try, that runs where nothing is missing."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from math import prod

from fairaudit.audits.column_names import AGE, GOOD, UNIT, YES, named, says
from fairaudit.audits.roles import MANY, WORDS, Roles, as_number, proposed
from fairaudit.tables.engines.survey import Samples, Seen, Survey
from fairaudit.tables.evaluations.paths import read_path
from fairaudit.tables.evaluations.samples import UNDECIDED

__all__ = ["roles_of_samples"]

PEOPLE = ("metadata", "doc", "vars", "instance", "sample")
"""Where logs of evaluations keep what is known of who or what a question is about."""

KEYS = frozenset(("gold", "target", "label", "answer_key", "answerkey", "correct", "answer", "split"))
"""Names of the right answer, and of parts of data sets: no group."""

MOST_SHOWN = 60  # characters of a label that a command names

MODEL = "eval.model"


def roles_of_samples(survey: Survey, samples: Samples) -> Roles:
    """Guess which path is which, by the last names in them.

    Parameters
    ----------
    survey : Survey
        What is at each path.
    samples : Samples
        What is known of the log beside.

    Returns
    -------
    Roles
        A guess, for people to correct.

    Examples
    --------
    >>> columns = [Seen("doc.sex", {"f": 20, "m": 20}, 2, 0), Seen("filtered_resps[0]", {"no": 30, "yes": 10}, 2, 0)]
    >>> found = roles_of_samples(Survey(40, tuple(columns)), Samples("lm-eval", "filtered_resps[0]", "", 0))
    >>> found.decision, found.utility, found.group
    ('filtered_resps[0]', 'yes', ('doc.sex',))
    """
    if not samples.format:
        return _of_rows(survey, samples)
    columns = {seen.name: seen for seen in survey.columns}
    questions = survey.rows // prod(len(columns[path].levels) for path, _, _ in (text.partition("=") for text in samples.where))
    named_ = _by_last_name(survey, samples, PEOPLE)
    people = {name: seen for name, seen in named_.items() if _of_people(seen, questions) and _path(seen, columns) != samples.question}
    roles = _with_paths(proposed([*people.values(), Seen("answer", {"yes": 1, "no": 1}, 2, 0)], questions), people, columns)
    group, unit, said = roles.group, samples.unit, []
    if not group:
        group = tuple(_path(seen, columns) for seen in people.values() if 2 <= seen.different <= MANY and _short(seen.levels))[:1]
    models = columns.get(MODEL)
    if not group and models is not None and models.different > 1 and samples.unit:
        group = (MODEL,)
    join = f"--join FILE:{samples.question}" if samples.question else "the metadata of its tests"
    if not group:
        where = f"a file that does with {join}, and its column" if samples.question else f"{join}, and then the path"
        said.append(f"nothing in the log says whom a question is about; name {where} with --group")
    if unit == "PATH":
        unit = _unit_of(survey, {*group, *roles.context}, questions)
        said.append(f"whether {unit} tells questions apart, only you can say: a repeated one counts once")
    decision, best = _decision(survey, samples)
    if decision and not best:
        example = "--extract '(?i)\\b(yes|no)\\b' --fold-labels with --utility yes"
        said.append(f"answers are texts; --extract takes decisions out of them, such as {example}")
    if {"question_polarity", "context_condition"} <= {read_path(seen.name).steps[-1] for seen in survey.columns}:
        said.append("questions look like those of BBQ: --recipe bbq stands for --decision, --group, --context, --unit and --utility")
    context = tuple(name for name in roles.context if name not in group)
    return replace(
        Roles(decision, best or "DECISION", False, group, context, roles.bins, unit=unit or None, said=tuple(said)),
        missing=any(columns[name].missing for name in (*group, *context)),
        errors=samples.errors > 0,
        where=samples.where,
        missing_samples=samples.short,
    )


def _of_rows(survey: Survey, samples: Samples) -> Roles:
    """The same of rows of no known format."""
    columns = {seen.name: seen for seen in survey.columns}
    found = _by_last_name(survey, samples, ())
    roles = _with_paths(proposed(list(found.values()), survey.rows), found, columns)

    def path(name: str | None) -> str | None:
        return _path(found[name], columns) if name in found else name

    return replace(roles, decision=path(roles.decision), utility_column=path(roles.utility_column), unit=path(roles.unit))


def _by_last_name(survey: Survey, samples: Samples, tops: tuple[str, ...]) -> dict[str, Seen]:
    """Columns by the last names in their paths, those at some keys alone; of equal names the first, in the order of these keys."""
    found: dict[str, Seen] = {}
    for seen in sorted(survey.columns, key=lambda seen: (*tops, _top(seen)).index(_top(seen))):
        steps = read_path(seen.name).steps
        names = [step for step in steps if isinstance(step, str)]
        known = not tops or (names[0] in tops and names[-1].casefold() not in KEYS)
        if known and seen.name != samples.decision and steps[-1] == names[-1] and names[-1] not in found:
            found[names[-1]] = replace(seen, name=names[-1])
    return found


def _top(seen: Seen) -> str:
    return read_path(seen.name).top


def _path(seen: Seen, columns: Mapping[str, Seen]) -> str:
    """The path of a column that was named by its last name."""
    return next(name for name, held in columns.items() if held.levels is seen.levels)


def _with_paths(roles: Roles, found: Mapping[str, Seen], columns: Mapping[str, Seen]) -> Roles:
    """What was proposed for columns of some names, for their paths; a log of samples has no numbers of rows."""
    full = {name: _path(seen, columns) for name, seen in found.items()}
    return replace(
        roles,
        group=tuple(full[name] for name in roles.group if name in full),
        context=tuple(full[name] for name in roles.context if name in full),
        bins={full[name]: cut for name, cut in roles.bins.items() if name in full},
        count=None,
        probability=None,
        weight=None,
        wide=None,
        slots=(),
        winner=None,
    )


def _of_people(seen: Seen, questions: int) -> bool:
    """Whether a path may say of whom questions are: it has labels that several of them share, or is an age."""
    shared = 2 * seen.different <= questions or seen.different == 2
    return bool(seen.levels) and not seen.fault and (shared or (named(seen.name, AGE) and all(map(_is_number, seen.levels))))


def _is_number(text: str) -> bool:
    return as_number(text) is not None


def _short(labels: Mapping[str, int]) -> bool:
    return sum(map(len, labels)) <= WORDS * len(labels)


def _unit_of(survey: Survey, taken: set[str], questions: int) -> str:
    """What tells questions apart where no id does: a person, or what has the most labels of what a prompt is filled with, or its text."""
    free = [seen for seen in survey.columns if _top(seen) in PEOPLE and seen.name not in taken and seen.levels and not seen.fault]
    free = sorted(free, key=lambda seen: PEOPLE.index(_top(seen)))
    people = [seen for seen in free if 2 < seen.different <= questions and named(str(read_path(seen.name).steps[-1]), UNIT)]
    prompt = next((seen for seen in survey.columns if seen.name == "prompt.raw" and seen.different > 2), None)
    most = max(free, key=lambda seen: seen.different, default=None)
    if people:
        return people[0].name
    if most is not None and (prompt is None or most.different >= prompt.different):
        return most.name
    return "PATH" if prompt is None else prompt.name


def _decision(survey: Survey, samples: Samples) -> tuple[str | None, str]:
    """Where decisions stand, and the label of them that is counted; an empty one if they are texts that decide nothing by themselves."""
    decision = next((seen for seen in survey.columns if seen.name == samples.decision), None)
    right = _right_of(survey, decision)
    if right:
        return right, "C"
    levels = {} if decision is None else decision.levels
    nothing = {*UNDECIDED, *samples.never_read}
    labels = [label for label in levels if label not in nothing and len(label) <= MOST_SHOWN and label.isprintable() and label.strip()]
    if decision is None or not labels or decision.different > MANY or not _short(levels):
        return samples.decision, ""
    index = decision.name.startswith("argmax(")
    return decision.name, next((label for label in labels if not index and says(label, f"{YES}|{GOOD}")), labels[0])


def _right_of(survey: Survey, decision: Seen | None) -> str:
    """Where a scorer of Inspect says whether an answer is right, if the answers are sentences; else empty."""
    if decision is None or not decision.name.startswith("scores.") or not decision.name.endswith(".answer"):
        return ""
    if not any(" " in label.strip() for label in decision.levels):
        return ""
    name = f"{decision.name.removesuffix('.answer')}.value"
    return name if any(seen.name == name and "C" in seen.levels and seen.levels.keys() <= {*"CIPN"} for seen in survey.columns) else ""
