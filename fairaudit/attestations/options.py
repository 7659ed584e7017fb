"""What has to be known to make a table again, as data: the options of a statement, and the reading that they say."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any, get_args

from fairaudit.attestations.statement import OPTIONS
from fairaudit.attestations.strict import check_data
from fairaudit.audits.reading import Access, Reading
from fairaudit.errors import InputError, kind_of, nearest, shown
from fairaudit.exact.rationals import rational_text
from fairaudit.model.utility import Utility
from fairaudit.tables.binning import Bins
from fairaudit.tables.columns import Missing
from fairaudit.tables.evaluations.extraction import NAMES, NOTHING_ASKED, Extraction, extraction_of
from fairaudit.tables.label_text import label_text
from fairaudit.tables.number_form import TEXT_FORM, number_form
from fairaudit.tables.scores import ABOVE, Cut, score_cut
from fairaudit.tables.sources import SameContent
from fairaudit.tables.wide import Wide, wide_of, written_wide

__all__ = ["options_of", "reading_of"]

ASKED = tuple(name for name in NAMES if name not in ("options", "join", "where"))
TEXTS = (
    *("decision", "truth", "positive", "count", "probability", "weight", "wide", "total", "utility_column", "missing", "table", "query"),
    *("same_content", *TEXT_FORM[:3]),
    *ASKED,
)
ROLES = ("group", "context", "unit", "unknown")
LISTS = (*ROLES, "options", "number_sign")
FLAGS = ("fold_labels", "signed")
OBJECTS = {"score": ("column", "above"), "join": ("file", "column")}
CONDITION = ("path", "value")
KEYS = tuple(name for name in OPTIONS if name != "audit")


def options_of(reading: Reading, utility: Utility | None, *, positive: str | None = None) -> dict[str, Any]:
    """Say as data what makes a table: what its columns are, what is done to them first, and what decisions are worth.

    Parameters
    ----------
    reading : Reading
        How the table is read.
    utility : Utility or None
        What decisions are worth, where no column says it; of scores, a score above the cut is worth 1 where nothing else is given.
    positive : str, optional
        The positive true label.

    Returns
    -------
    dict
        Texts, lists and objects of texts; only what was given. `reading_of` reads it again.

    Raises
    ------
    InputError
        If something cannot be said so: a utility of contexts or groups, or a text that is too long or holds control characters.

    Examples
    --------
    >>> options_of(Reading("hired", ("sex",), bins={}), Utility({"yes": 1, "maybe": "0.5"}))
    {'decision': 'hired', 'group': ['sex'], 'utility': {'yes': '1', 'maybe': '1/2'}}
    """
    if utility is not None and utility.entries is not None and reading.utility_column is None:
        raise InputError("a utility that varies with context or group cannot be recorded; give it as a column of the table, utility_column")
    wide, total = ("", "") if reading.wide is None else _wide(reading.wide)
    if utility is None and reading.above is not None and reading.utility_column is None:
        utility = Utility({ABOVE: 1})
    values = {} if utility is None or reading.utility_column is not None else utility.values
    access = reading.access
    said: dict[str, Any] = {
        "decision": "" if reading.above is not None else reading.decision,
        "score": {} if reading.above is None else {"column": reading.decision, "above": _cut(reading.above)},
        "group": list(reading.group),
        "context": list(reading.context),
        "truth": reading.truth,
        "positive": positive,
        "count": reading.count,
        "probability": reading.probability,
        "weight": reading.weight,
        "wide": wide,
        "total": total,
        "unit": list(reading.unit),
        "utility": {label: rational_text((value.numerator, value.denominator)) for label, value in values.items()},
        "utility_column": reading.utility_column,
        "missing": None if reading.missing == "error" else reading.missing,
        "unknown": list(reading.unknown),
        "fold_labels": reading.fold_labels,
        "label_map": {name: _renamed(entries) for name, entries in (reading.label_map or {}).items() if entries},
        "bins": {name: list((edges if isinstance(edges, Bins) else Bins.of(name, edges)).edges) for name, edges in reading.bins.items()},
        "skip": access.skip,
        "table": access.table,
        "query": access.query,
        "signed": reading.signed,
        "same_content": None if access.same_content == "refuse" else access.same_content,
        "encoding": access.encoding,
        "decimal": access.form.decimal,
        "thousands": access.form.thousands,
        "number_sign": list(access.form.signs),
        **_extraction(access.extraction),
    }
    found = {name: value for name, value in said.items() if value}
    _check_texts(found)
    return found


def reading_of(options: Mapping[str, Any], *, spelled: Callable[[str], str] = str) -> tuple[Reading, Utility | None]:
    """Read what `options_of` wrote: how the table is read, and what decisions are worth where no column says it.

    Parameters
    ----------
    options : mapping
        The options of a statement.
    spelled : callable
        How the one who asks writes the name of an option, for messages.

    Raises
    ------
    InputError
        If there is an unknown key, a value of the wrong type, or no column of decisions or groups.

    Examples
    --------
    >>> reading, utility = reading_of({"decision": "hired", "group": ["sex"], "utility": {"yes": "1"}, "bins": {"age": ["18"]}})
    >>> reading.group, utility.values, reading.bins["age"].labels
    (('sex',), {'yes': Fraction(1, 1)}, ('under 18', '18 and over'))
    """
    for name, value in options.items():
        _check(name, value)
    _check_texts(options)
    score = options.get("score", {})
    if score and "decision" in options:
        raise InputError("the options have both score and decision; a table has one of them")
    for name in ("group",) if score else ("decision", "group"):
        if name not in options:
            raise InputError(f"the options name no {name}; a table has columns of decisions and of groups")
    signed = "signed" in options
    missing: Missing = options.get("missing", "error")
    if missing not in get_args(Missing):
        raise InputError(f"the options have missing {shown(missing)}; {nearest(missing, get_args(Missing))}")
    same_content: SameContent = options.get("same_content", "refuse")
    if same_content not in get_args(SameContent):
        raise InputError(f"the options have same_content {shown(same_content)}; {nearest(same_content, get_args(SameContent))}")
    if "utility" in options and "utility_column" in options:
        raise InputError("the options have both utility and utility_column; a table has one of them")
    plain: dict[str, Any] = {name: options.get(name) for name in ("truth", "count", "probability", "weight", "utility_column", "label_map")}
    lists: dict[str, Any] = {name: tuple(options.get(name, ())) for name in ROLES}
    reading = Reading(
        **plain,
        **lists,
        decision=score["column"] if score else options["decision"],
        above=score_cut(score["above"], "the options have score") if score else None,
        bins={name: Bins.of(name, edges) for name, edges in options.get("bins", {}).items()},
        missing=missing,
        fold_labels="fold_labels" in options,
        access=Access(
            table=options.get("table"),
            query=options.get("query"),
            skip=options.get("skip", 0),
            extraction=_extraction_in(options),
            same_content=same_content,
            encoding=options.get("encoding"),
            form=number_form(options.get("decimal"), options.get("thousands"), options.get("number_sign", ())),
        ),
        spelled=spelled,
        signed=signed,
        wide=wide_of(options.get("wide"), options.get("total")),
    )
    return reading, Utility(options["utility"], signed=signed) if "utility" in options else None


def _extraction(asked: Extraction) -> dict[str, Any]:
    """What is asked of an evaluation log beyond columns; of the file that is joined the name without folders."""
    return {
        "log_format": asked.log_format,
        "extract": asked.extract,
        "options": list(asked.options),
        "join": {} if asked.join is None else {"file": Path(asked.join[0]).name, "column": asked.join[1]},
        "where": [dict(zip(CONDITION, condition, strict=True)) for condition in asked.where],
        "errors": None if asked.errors == NOTHING_ASKED.errors else asked.errors,
        "missing_samples": None if asked.missing_samples == NOTHING_ASKED.missing_samples else asked.missing_samples,
        "recipe": asked.recipe,
    }


def _extraction_in(options: Mapping[str, Any]) -> Extraction:
    """The same read again."""
    texts = {name: options[name] for name in (*ASKED, "options") if name in options}
    join = options.get("join")
    found = extraction_of(**texts, where={condition["path"]: condition["value"] for condition in options.get("where", ())})
    return found if join is None else replace(found, join=(join["file"], join["column"]))


def _cut(above: Cut) -> str:
    return above if isinstance(above, str) else rational_text((above.numerator, above.denominator))


def _wide(wide: Wide) -> tuple[str, str]:
    """Columns of counts and totals as texts, which have to say the same."""
    written, total = written_wide(wide)
    try:
        same = wide_of(written, total or None) == wide
    except InputError:
        same = False
    if not same:
        raise InputError(f"the columns of counts {shown(written)} with the total {shown(total)} cannot be recorded; rename them")
    return written, total


def _renamed(entries: Mapping[Any, Any]) -> dict[str, str]:
    return {label_text(old) or "": label_text(new) or "" for old, new in entries.items()}


def _check(name: str, value: Any) -> None:
    """Refuse an unknown key, and a value of the wrong type."""
    if name not in KEYS:
        raise InputError(f"the options have the unknown key {shown(name)}; {nearest(name, KEYS)}")
    fits, wanted = True, ""
    if name in TEXTS:
        fits, wanted = isinstance(value, str) and bool(value), "a text"
    elif name in LISTS:
        fits, wanted = _is_list(value), "a list of texts"
    elif name in FLAGS:
        fits, wanted = value is True, "true, or absent"
    elif name == "skip":
        fits, wanted = type(value) is int and value > 0, "a whole number above 0"
    elif name in OBJECTS:
        fits, wanted = _is_map(value) and {*value} == {*OBJECTS[name]}, f"an object with the texts {' and '.join(OBJECTS[name])}"
    elif name == "where":
        fits = isinstance(value, list) and bool(value) and all(_is_map(entry) and {*entry} == {*CONDITION} for entry in value)
        fits, wanted = fits and len({entry["path"] for entry in value}) == len(value), "a list of objects with the texts path and value"
    elif name == "utility":
        fits, wanted = _is_map(value), "an object of texts"
    elif name == "bins":
        fits, wanted = isinstance(value, dict) and bool(value) and all(map(_is_list, value.values())), "an object of lists of texts"
    else:
        fits, wanted = isinstance(value, dict) and bool(value) and all(map(_is_map, value.values())), "an object of objects of texts"
    if not fits:
        raise InputError(f"the options have {name} {shown(value)}, {kind_of(value)}; it must be {wanted}")


def _is_list(value: Any) -> bool:
    return isinstance(value, list) and bool(value) and all(isinstance(text, str) for text in value)


def _is_map(value: Any) -> bool:
    return isinstance(value, dict) and bool(value) and all(isinstance(text, str) for text in value.values())


def _check_texts(options: Mapping[str, Any]) -> None:
    """Refuse texts that a statement does not hold."""
    for name, value in options.items():
        check_data(value, f"the option {name}")
