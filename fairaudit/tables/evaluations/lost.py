"""Samples of an evaluation log that have no answer: counted by the cell in which they would be, and taken out of what is counted."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Sequence
from dataclasses import replace

from fairaudit.errors import InputError, shown
from fairaudit.tables.columns import MISSING_LABEL, Missing, label_codes, read_labels
from fairaudit.tables.evaluations.samples import ERROR, NOTHING_DECIDED, Dropped, Evaluation
from fairaudit.tables.preparation import Entry
from fairaudit.tables.tally import Tally
from fairaudit.tables.values import Label
from fairaudit.words import noun

__all__ = ["NOTHING", "UNITS", "drawn_said", "left_out_of", "refuse_other_draws", "refuse_samples", "settled"]

QUESTIONS = "questions were drawn; epochs of a question count once"
ANSWERS = "the questions are fixed; the model's answers were drawn"
UNITS = "sampling units were drawn; samples of a unit count once"
SAMPLES = "samples were drawn, each of them by itself"
NOTHING = "nothing was drawn: the questions are fixed, and the model answers each of them in one way"


def drawn_said(evaluation: Evaluation) -> str:
    """Say what was drawn.

    Examples
    --------
    >>> drawn_said(Evaluation("inspect", epochs=3, question="id", unit=("id",)))
    'questions were drawn; epochs of a question count once'
    """
    if evaluation.drawn == "units":
        return UNITS if evaluation.unit else SAMPLES
    if evaluation.drawn == "questions":
        return QUESTIONS
    return NOTHING if evaluation.fixed else ANSWERS


def refuse_other_draws(evaluation: Evaluation, unit: Sequence[str], cell: Sequence[str]) -> None:
    """Refuse a table in which draws are not what they were when the log was read.

    Parameters
    ----------
    evaluation : Evaluation
        How the log was read.
    unit : sequence of str
        Columns of the sampling unit of the table.
    cell : sequence of str
        Its columns of contexts and groups.

    Raises
    ------
    InputError
        If it has another sampling unit, or puts several questions into a cell whose answers alone were drawn.

    Examples
    --------
    >>> refuse_other_draws(Evaluation("inspect", epochs=3, question="id", unit=("id",)), ["id"], ["race"])
    >>> refuse_other_draws(Evaluation("inspect", epochs=3, question="id", unit=("id",)), [], ["race"])
    Traceback (most recent call last):
        ...
    fairaudit.errors.InputError: the log was read with the sampling unit id, and the table is to have none; name the same in both
    """
    if (*unit,) != evaluation.unit:
        read, asked = (", ".join(names) or "none" for names in (evaluation.unit, unit))
        raise InputError(f"the log was read with the sampling unit {read}, and the table is to have {asked}; name the same in both")
    if not unit and evaluation.drawn == "answers" and evaluation.question not in cell:
        raise InputError(
            f"{evaluation.question} is neither a context nor a group, so that answers to it are no draws by themselves; name it as unit"
        )


def left_out_of(evaluation: Evaluation) -> tuple[str, ...]:
    """Say what has to be assumed of the samples that have no answer and are not counted.

    Examples
    --------
    >>> left_out_of(Evaluation("inspect", expected=48, read=20))
    ('28 of 48 samples are not in the evaluation log and were left out; they are taken to be no different from the others',)
    """
    said = []
    if evaluation.lost:
        said.append(f"{evaluation.lost} of {evaluation.rows} rows of the evaluation log ended in an error and were left out")
    if evaluation.missing:
        said.append(f"{evaluation.missing} of {evaluation.expected} samples are not in the evaluation log and were left out")
    return tuple(f"{text}; they are taken to be no different from the others" for text in said)


def refuse_samples(tally: Tally) -> None:
    """Refuse samples of an evaluation log where rows carry counts or probabilities; rows of no known format may, as they stand.

    Raises
    ------
    InputError
        If they are such.
    """
    log = tally.evaluation
    if log is not None and (log.format != "rows" or log.extract is not None or log.options or log.errors == "drop"):
        raise InputError(
            "an evaluation log has a sample in each row, and no counts, shares or probabilities of decisions; name the decision of a sample"
        )


def settled(
    tally: Tally,
    decision: str,
    context: Sequence[str],
    group: Sequence[str],
    *,
    missing: Missing = "error",
    unknown: Sequence[str] = (),
) -> Tally:
    """Take out the samples that ended in an error, where they are to be dropped, and count them by context and group.

    Parameters
    ----------
    tally : Tally
        A log, its labels merged and cut; one that is no evaluation log stays as it is.
    decision : str
        Column of the decision.
    context, group : sequence of str
        Columns of the cell.
    missing, unknown
        What it means that a label is missing, and labels that name no group.

    Returns
    -------
    Tally
        The others, with those in its evaluation that were taken out.

    Raises
    ------
    InputError
        If nothing is left, a label of a sample that was taken out is missing and has to be there, or a label that says that nothing was
        decided was merged with another one.
    """
    evaluation = tally.evaluation
    if evaluation is None or evaluation.rows:
        return tally
    _refuse_rewritten(tally.preparation, decision)
    evaluation = replace(evaluation, rows=tally.rows)
    failed = tally.codes[decision] == (tally.levels[decision].index(ERROR) if ERROR in tally.levels[decision] else -1)
    if evaluation.errors != "drop" or not failed.any():
        return replace(tally, evaluation=evaluation)
    if failed.all():
        raise InputError(f"all {tally.rows} {noun(tally.rows, 'sample')} ended in an error; nothing is left to audit")
    cells, unlabelled = _cells(tally.only(failed), context, group, missing, unknown)
    dropped = tuple(Dropped(place, label or None, count) for (place, label), count in sorted(cells.items()))
    note = f"{int(tally.counts[failed].sum())} of {tally.rows} rows ended in an error and were left out"
    found = replace(evaluation, dropped=dropped, unlabelled=unlabelled)
    return replace(tally.only(~failed), evaluation=found, notes=(*tally.notes, note))


def _cells(
    lost: Tally, context: Sequence[str], group: Sequence[str], missing: Missing, unknown: Sequence[str]
) -> tuple[Counter[tuple[Label, Label]], int]:
    """Count samples by context and group, which is empty where it was not recorded; and those that are in no cell for lack of a label."""
    cells: Counter[tuple[Label, Label]] = Counter()
    unlabelled = 0
    texts: dict[str, list[str | None]] = {}
    columns = (*context, *group)
    for name, (codes, labels) in zip(columns, label_codes(lost, columns, lost.locate), strict=True):
        texts[name] = [labels[code] if code >= 0 else None for code in codes.tolist()]
        if missing in ("error", "undecided") or (missing == "unknown" and name in context):
            read_labels(lost, [name], [], "error")  # which says where one is missing
        if missing == "group":
            texts[name] = [text or MISSING_LABEL for text in texts[name]]
    for row, count in enumerate(lost.counts.tolist()):
        place, label = (tuple(texts[name][row] for name in names) for names in (context, group))
        if missing == "drop" and None in (*place, *label):
            unlabelled += count
        else:
            cells[place, () if {None, *unknown} & {*label} else label] += count  # type: ignore[index]  # no context is without label
    return cells, unlabelled


def _refuse_rewritten(preparation: Iterable[Entry], decision: str) -> None:
    """Refuse labels of the decision that were written as others, where one of them says that nothing was decided."""
    for entry in preparation:
        for label in (entry.get("label"), *entry.get("from", ())) if entry.get("column") == decision else ():
            if label in NOTHING_DECIDED:
                raise InputError(
                    f"column {shown(decision)}: {shown(label)} says that an answer decided nothing, and stays a decision of its own; "
                    "write no label as this one, nor this one as another"
                )
