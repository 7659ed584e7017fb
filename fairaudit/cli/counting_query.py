"""`fairaudit certify --print-sql DIALECT`: the query that counts a log, for a database that is not reached from here."""

from __future__ import annotations

import argparse

from fairaudit.cli.options import column_roles
from fairaudit.cli.output import Answer

__all__ = ["counting_query"]


def counting_query(arguments: argparse.Namespace) -> Answer:
    """The query that counts a log, and the command that audits its result."""
    import shlex

    from fairaudit.errors import InputError
    from fairaudit.tables.binning import Bins
    from fairaudit.tables.sql import COUNT_COLUMN, count_statement, table_name

    if arguments.score or arguments.above:
        raise InputError("--print-sql does not go with --score: which of the scores is the median, no query that counts decisions says")
    if arguments.count or arguments.probability or arguments.wide or arguments.unit or arguments.slots:
        raise InputError("--print-sql goes with a log whose rows are draws of their own")
    if arguments.table is not None or arguments.output is not None:
        raise InputError("--print-sql only prints a query; name the table in the database with --table")
    decision = arguments.decision or arguments.utility_column
    group, context = column_roles(arguments.group), column_roles(arguments.context)
    if decision is None or not group.names:
        raise InputError("--print-sql needs the columns: --decision COL and --group COL")
    valued = [c for c in [arguments.utility_column] if c not in (None, decision)]
    names = (*context.names, *group.names, decision, *([arguments.truth] if arguments.truth else []), *valued)
    edges = {**group.edges, **context.edges}
    held = table_name(arguments.database_table or "decisions", arguments.print_sql)
    if arguments.query is not None:
        held = f"({arguments.query.strip().rstrip(';')}) as log"
    bins = {name: Bins.of(name, cut) for name, cut in edges.items()}
    statement = count_statement(names, held, arguments.print_sql, bins=bins, names=names, ordered=True)
    words = ["fairaudit", "certify", "result.csv", "--decision", decision, "--count", COUNT_COLUMN]
    for option, listed in (("--group", group.names), ("--context", context.names)):
        for name in listed:
            words += [option, '"' + name.replace('"', '""') + '"' if any(c in name for c in ',":') else name]
    for name in ("utility", "utility_column", "truth", "positive", "map"):
        option, value = f"--{name.replace('_', '-')}", getattr(arguments, name)
        words += [option, value] if value is not None else []
    words += ["--fold-labels"] if arguments.fold_labels else []
    words += ["--burden"] if arguments.burden else []
    return Answer(
        "query",
        sentence="Save the result of the query as CSV with a header line, and audit it with the command.",
        result=lambda: {"dialect": arguments.print_sql, "query": f"{statement};", "command": words},
        text=lambda: f"-- Save the result as CSV with a header line, then: {shlex.join(words)}\n{statement};",
    )
