"""What is in the columns of a table, and which of them a command would take for what."""

from __future__ import annotations

import argparse
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import islice
from typing import TYPE_CHECKING

from fairaudit.cli.source import lexicon_of, option, progress
from fairaudit.tables.sources import source_name
from fairaudit.words import quoted, to_copy

if TYPE_CHECKING:
    from fairaudit.audits.roles import Roles
    from fairaudit.tables.engines.survey import Seen, Survey
    from fairaudit.tables.number_form import NumberForm

__all__ = ["Column", "described", "is_complete", "looked_at", "named", "open_questions", "suggested", "warnings", "written"]

TITLE = re.compile(r"has (.*) where a header was expected, which looks like a title.*--skip (\d+)\)", re.DOTALL)
MISSING_WORDS = {"na", "n/a", "nan", "null", "none", "unknown", "?", "-", "."}


@dataclass(frozen=True)
class Column:
    """What a column looks like."""

    name: str
    levels: dict[str, int]
    different: int
    missing: int
    numeric: bool
    fault: str


def looked_at(arguments: argparse.Namespace) -> tuple[Survey, list[Column], Roles]:
    """Look at every column of the table that the options name, and guess what it is."""
    from fairaudit.audits.roles import proposed
    from fairaudit.audits.sample_roles import roles_of_samples
    from fairaudit.errors import InputError
    from fairaudit.tables.engines.databases import tables_of
    from fairaudit.tables.engines.logs import survey_log
    from fairaudit.tables.number_form import guessed

    given = _listed(arguments.table)
    said = ""
    if len(given) == 1 and arguments.database_table is None and arguments.query is None:
        found = tables_of(given[0])
        if len(found) == 1:
            [arguments.database_table] = found
            said = f"{found[0]} is the only table"

    def survey_of(skip: int) -> Survey:
        where = {name: getattr(arguments, name) for name in ("engine", "query", "memory", "log_format", "same_content", "encoding")}
        with progress() as report:
            return survey_log(given if len(given) > 1 else given[0], **where, skip=skip, table=arguments.database_table, report=report)

    try:
        survey = survey_of(arguments.skip)
    except InputError as error:
        title = TITLE.search(str(error))
        if title is None or arguments.skip:
            raise
        arguments.skip = int(title.group(2))
        survey = survey_of(arguments.skip)
        lines = "line looks" if arguments.skip == 1 else f"{arguments.skip} lines look"
        said = f"the first {lines} like a title ({title.group(1)}) and {'is' if arguments.skip == 1 else 'are'} skipped"
    if survey.samples is not None:
        return survey, [_look(seen, None) for seen in survey.columns], roles_of_samples(survey, survey.samples)
    lexicon = lexicon_of(arguments)
    written = {seen.name: guessed(seen.levels) for seen in survey.columns}
    plainly = [_plainly(seen, written[seen.name]) for seen in survey.columns]
    roles = _wide(arguments, survey, lexicon) or proposed(plainly, survey.rows, lexicon=lexicon)
    roles = _with_form(roles, {name: found for name, found in written.items() if found is not None})
    if said:
        roles = replace(roles, said=(said, *roles.said))
    return survey, [_look(seen, written[seen.name]) for seen in survey.columns], roles


Written = tuple["NumberForm", dict[str, str]]
"""How the numbers of a column are written, and the same written plainly."""


def _plainly(seen: Seen, written: Written | None) -> Seen:
    """A column whose numbers are written plainly."""
    if written is None:
        return seen
    levels: dict[str, int] = {}
    for text, count in seen.levels.items():
        plain = written[1][text]
        levels[plain] = levels.get(plain, 0) + count
    return replace(seen, levels=levels)


def _with_form(roles: Roles, forms: Mapping[str, Written]) -> Roles:
    """What has to be declared of the numbers that are taken for something, with what that means."""
    from fairaudit.tables.number_form import NumberForm, either

    numbers = [roles.count, roles.probability, roles.weight, roles.utility_column, *(roles.wide.columns if roles.wide else ())]
    used = {name: forms[name] for name in numbers if name is not None and name in forms}
    thousands = next((form.thousands for form, _ in used.values() if form.thousands), None)
    signs = tuple(dict.fromkeys(sign for form, _ in used.values() for sign in form.signs))
    clear = next((name for name, (form, texts) in used.items() if form.thousands == thousands and not either(texts, form)), None)
    name, says = next(((name, says) for name, (form, texts) in used.items() if (says := either(texts, form))), ("", ""))
    said = list(roles.said)
    if says and clear is None:
        said.append(f"both readings exist in column '{name}': {says}; the command has the first, and only you can say which is right")
    return replace(roles, form=NumberForm(None, thousands, signs), said=tuple(said))


def _wide(arguments: argparse.Namespace, survey: Survey, lexicon: Sequence[str]) -> Roles | None:
    """What columns of counts there are in a small table; it is read as a whole, because counts and totals stand beside each other."""
    from fairaudit.audits.reading import read_table
    from fairaudit.audits.wide_roles import ROWS, wide_roles
    from fairaudit.cli.source import access_of
    from fairaudit.errors import InputError
    from fairaudit.tables.label_text import label_text
    from fairaudit.tables.number_form import guessed
    from fairaudit.tables.values import column

    if survey.rows > ROWS or len(survey.columns) > 200 or any(seen.fault for seen in survey.columns):
        return None
    names = [seen.name for seen in survey.columns]
    try:
        table = read_table(arguments.table, names, {}, {}, access_of(arguments))
        cells = {name: [label_text(value) or "" for value in column(table, name)] for name in names}
        plain = {name: found[1] for name, texts in cells.items() if (found := guessed(texts)) is not None and "%" not in found[0].signs}
        written = {name: [plain[name][text] for text in texts] if name in plain else texts for name, texts in cells.items()}
        return wide_roles(written, lexicon=lexicon)
    except InputError:
        return None


def _listed(table: str | list[str]) -> list[str]:
    return [table] if isinstance(table, str) else table


def _look(seen: Seen, written: Written | None) -> Column:
    from fairaudit.audits.roles import as_number

    numeric = written is not None or (bool(seen.levels) and all(as_number(text) is not None for text in seen.levels))
    return Column(seen.name, seen.levels, seen.different, seen.missing, numeric, seen.fault)


def described(column: Column, room: int | None = None) -> str:
    """What a column holds, in a line; if there is so much room, with the levels that fit into it, of which one always does."""
    from fairaudit.tables.engines.survey import MOST
    from fairaudit.words import plain

    if column.fault:
        return plain(f"no labels: {column.fault}")
    absent = f"; {column.missing} missing" if column.missing else ""
    number = f"more than {MOST:,}" if column.different == MOST + 1 else f"{column.different}"
    if not column.levels:
        return f"empty{absent}"
    if column.numeric and column.different > 12:
        return f"numbers, {number} different{absent}"
    shown = [f"{plain(label)[:40]} ({count})" for label, count in islice(column.levels.items(), 8)]
    while True:
        more = f", … ({number} levels)" if column.different > len(shown) else ""
        text = f"{', '.join(shown)}{more}{absent}"
        if room is None or len(text) <= room or len(shown) == 1:
            return text
        shown.pop()


def warnings(column: Column) -> list[str]:
    """What to look at before a column is used."""
    from fairaudit.tables.labels import spellings
    from fairaudit.tables.preparation import said
    from fairaudit.tables.wide import is_total

    found = () if column.numeric and column.different > 12 else spellings([(column.name, column.levels)])
    found_ = [f"{text.partition(': ')[2]} (--fold-labels, or --map FILE)" for text in said({"spellings": found})]
    if not column.numeric:
        found_ += [f"'{label}' may be a row of totals, which would count everybody twice" for label in column.levels if is_total(label)]
    unset = [label for label in column.levels if " ".join(label.lower().split()) in MISSING_WORDS]
    found_ += [f"'{label}' counts as a level; only empty cells are missing" for label in unset]
    return found_[:5]


def suggested(arguments: argparse.Namespace, roles: Roles) -> list[str]:
    """The words of a certify command for the table that the options name."""
    paths = [source_name(path).replace(":…@", "@") for path in _listed(arguments.table)]
    words = ["fairaudit", "certify", *(f"./{path}" if path.startswith("-") else path for path in paths)]
    where = {
        "engine": "" if arguments.engine == "auto" else arguments.engine,
        "table": arguments.database_table or "",
        "query": arguments.query or "",
        "memory": arguments.memory or "",
        "skip": str(arguments.skip or ""),
        "encoding": arguments.encoding or "",
        "log_format": arguments.log_format or "",
    }
    for name, value in (where | written(roles)).items():
        if value:
            words += [f"{option(name)}={value}"] if value.startswith("-") else [option(name), value]
    words += [word for condition in roles.where for word in ("--where", condition)]
    words += ["--errors", "bound"] if roles.errors else []
    words += ["--missing-samples", "accept"] if roles.missing_samples else []
    return [*words, *(["--burden"] if roles.burden else [])]


def named(roles: Roles) -> frozenset[str]:
    """The columns that are taken for something."""
    return frozenset(filter(None, (roles.decision, roles.utility_column, roles.unit, *roles.group, *roles.context)))


def open_questions(roles: Roles) -> list[str]:
    """What to ask of labels that look undecided, and which options answer it."""
    return [
        f"is '{label}' in column '{roles.decision}' refused, or not decided yet? --undecided bounds the ratio whatever it becomes; "
        f"{to_copy([label], '=0')} in --utility counts it as refused"
        for label in roles.undecided
    ]


def is_complete(roles: Roles) -> bool:
    """Whether a command that is suggested names everything, and has no word in the place of a name that nobody could guess."""
    from fairaudit.audits.roles import UNNAMED

    words = written(roles)
    unknown = (("decision", "COL"), ("group", "COL"), ("unit", "PATH"), ("utility", UNNAMED))
    return not any(words.get(name) == word for name, word in unknown)


def written(roles: Roles) -> dict[str, str]:
    """What columns are, as the options of a command have it; empty for what there is not."""
    from fairaudit.audits.roles import UNNAMED

    if roles.slots:
        return {
            "slots": ",".join(map(quoted, roles.slots)),
            "winner": roles.winner or "",
            "context": ",".join(map(quoted, roles.context)),
        }
    wide = total = ""
    if roles.wide is not None:
        from fairaudit.tables.wide import written_wide

        wide, total = written_wide(roles.wide)
    column = roles.utility_column or ""
    if not roles.decision:
        roles = replace(roles, utility=UNNAMED)
    edges = {name: ":" + ",".join(map(str, cut)) for name, cut in roles.bins.items()}
    return {
        "decision": "" if wide or column else roles.decision or "COL",
        "utility_column": column,
        "wide": wide,
        "total": total,
        "group": ",".join(quoted(name) + edges.get(name, "") for name in roles.group) or "COL",
        "context": ",".join(map(quoted, roles.context)),
        "count": roles.count or "",
        "probability": roles.probability or "",
        "weight": roles.weight or "",
        "unit": quoted(roles.unit or ""),
        "utility": "" if column else ",".join([quoted(roles.utility), *(f"{quoted(label)}=0" for label in roles.refused)]),
        "undecided": ",".join(map(quoted, roles.undecided)),
        "missing": "drop" if roles.missing else "",
        "thousands": "space" if roles.form.thousands == " " else roles.form.thousands or "",
        "number_sign": ",".join(roles.form.signs),
    }
