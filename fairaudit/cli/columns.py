"""What is in the columns of a table, and which of them a command would take for what."""

from __future__ import annotations

import argparse
from dataclasses import dataclass
from itertools import islice
from typing import TYPE_CHECKING

from fairaudit.cli.source import progress
from fairaudit.tables.sources import PASSWORD

if TYPE_CHECKING:
    from fairaudit.audits.roles import Roles
    from fairaudit.tables.engines.survey import Seen, Survey

__all__ = ["Column", "described", "looked_at", "quoted", "suggested", "warnings", "written"]

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
    from fairaudit.errors import InputError
    from fairaudit.tables.engines.logs import survey_log

    given = _listed(arguments.table)
    where = {name: getattr(arguments, name) for name in ("engine", "query", "memory", "skip")}
    try:
        with progress() as report:
            survey = survey_log(given if len(given) > 1 else given[0], **where, table=arguments.database_table, report=report)
    except InputError as error:
        raise InputError(PASSWORD.sub(r"\1:…", str(error))) from None
    comma = any("separated by" in note for note in survey.notes)
    return survey, [_look(seen, decimal_comma=comma) for seen in survey.columns], proposed(survey.columns, survey.rows, decimal_comma=comma)


def _listed(table: str | list[str]) -> list[str]:
    return [table] if isinstance(table, str) else table


def _look(seen: Seen, *, decimal_comma: bool) -> Column:
    from fairaudit.audits.roles import as_number

    numeric = bool(seen.levels) and all(as_number(text, decimal_comma=decimal_comma) is not None for text in seen.levels)
    return Column(seen.name, seen.levels, seen.different, seen.missing, numeric, seen.fault)


def described(column: Column) -> str:
    """What a column holds, in a line."""
    from fairaudit.words import plain

    if column.fault:
        return plain(f"no labels: {column.fault}")
    absent = f"; {column.missing} missing" if column.missing else ""
    if not column.levels:
        return f"empty{absent}"
    if column.numeric and column.different > 12:
        return f"numbers, {column.different} different{absent}"
    shown = ", ".join(f"{plain(label)[:40]} ({count})" for label, count in islice(column.levels.items(), 8))
    more = f", … ({column.different} levels)" if column.different > 8 else ""
    return f"{shown}{more}{absent}"


def warnings(column: Column) -> list[str]:
    """What to look at before a column is used."""
    from fairaudit.tables.labels import spellings
    from fairaudit.tables.preparation import said

    found = () if column.numeric and column.different > 12 else spellings([(column.name, column.levels)])
    found_ = [f"{text.partition(': ')[2]} (--fold-labels, or --map FILE)" for text in said({"spellings": found})]
    unset = [label for label in column.levels if " ".join(label.lower().split()) in MISSING_WORDS]
    found_ += [f"'{label}' counts as a level; only empty cells are missing" for label in unset]
    return found_[:5]


def suggested(arguments: argparse.Namespace, roles: Roles) -> list[str]:
    """The words of a certify command for the table that the options name."""
    paths = [PASSWORD.sub(r"\1", path) for path in _listed(arguments.table)]
    words = ["fairaudit", "certify", *(f"./{path}" if path.startswith("-") else path for path in paths)]
    where = {
        "engine": "" if arguments.engine == "auto" else arguments.engine,
        "table": arguments.database_table or "",
        "query": arguments.query or "",
        "memory": arguments.memory or "",
        "skip": str(arguments.skip or ""),
    }
    for name, value in (where | written(roles)).items():
        if value:
            words += [f"--{name}={value}"] if value.startswith("-") else [f"--{name}", value]
    return [*words, *(["--burden"] if roles.burden else [])]


def written(roles: Roles) -> dict[str, str]:
    """What columns are, as the options of a command have it; empty for what there is not."""
    edges = {name: ":" + ",".join(map(str, cut)) for name, cut in roles.bins.items()}
    return {
        "decision": roles.decision or "COL",
        "group": ",".join(quoted(name) + edges.get(name, "") for name in roles.group) or "COL",
        "context": ",".join(map(quoted, roles.context)),
        "count": roles.count or "",
        "probability": roles.probability or "",
        "weight": roles.weight or "",
        "unit": quoted(roles.unit or ""),
        "utility": quoted(roles.utility) if roles.decision else "DECISION",
        "missing": "drop" if roles.missing else "",
    }


def quoted(label: str) -> str:
    """Quote a name or label as `--group` and `--utility` read it, where that is needed."""
    needed = label != label.strip() or any(c in label for c in ',="\r\n')
    return '"' + label.replace('"', '""') + '"' if needed else label
