"""`fairaudit certify`: audit a table, judge it against targets, write a certificate."""

from __future__ import annotations

import argparse
import gc
import re
from collections.abc import Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING, Any

from fairaudit.cli.certified import certified
from fairaudit.cli.destinations import check_output
from fairaudit.cli.options import add_limits, column_list, column_roles, confidence_option, given_limits, utility_range, utility_spec
from fairaudit.cli.output import Answer, add_format, ready
from fairaudit.cli.population import add_population, findings_beside, population_options
from fairaudit.cli.source import add_label_options, add_source, law_from_options, progress, read_source, source_name, with_labels

if TYPE_CHECKING:
    from fairaudit.cli.audit_file import Audit
    from fairaudit.model.law import Law
    from fairaudit.model.utility import Utility


MOST_ROWS = 20_000_000

DIALECTS = ("bigquery", "duckdb", "postgres", "snowflake", "spark", "sqlite", "trino")

DESCRIPTION = """\
Measure how unequally a table of decisions treats groups: exactly, with the pair of groups that is worst off, and as a certificate that
anybody can check. The table has one of three forms: a count per row (--count), a probability per row (--probability), or one
decision per row (neither); such a log may have any size, in CSV, Parquet or JSON lines, or in a database."""


EPILOG = """\
exit codes: 0 within the targets, or no target; 1 a target is exceeded; 2 bad input; 3 inconclusive

examples:
  fairaudit certify --example ucb-admissions -o certificate.json
  fairaudit certify admissions.csv --decision Admit --group Gender --context Dept --count Freq --utility Admitted
  fairaudit certify log.csv --decision answer --group sex,age --utility yes=1,maybe=0.5 --max-local-ratio 5/4 --confidence 0.99
  fairaudit certify log.csv --decision answer --group sex --utility yes --max-local-ratio 0.8 --unit interview"""


def add(commands: Any) -> None:
    """Declare the options."""
    parser = commands.add_parser(
        "certify",
        help="audit a table of decisions and write a certificate",
        description=DESCRIPTION,
        epilog=EPILOG,
        formatter_class=argparse.RawDescriptionHelpFormatter,
        allow_abbrev=False,
    )
    parser.set_defaults(run=run)
    parser.add_argument(
        "table",
        metavar="TABLE",
        nargs="*",
        help="files (CSV, Parquet, JSON lines), a database (sqlite:FILE, duckdb:FILE, delta:FOLDER, postgresql://…), or an audit file",
    )
    parser.add_argument("--from-monitor", metavar="STATE", help="certify what `fairaudit monitor --state STATE` has counted so far")
    parser.add_argument("--at-alarm", action="store_true", help="with --from-monitor: at the moment of the first alarm")
    parser.add_argument("--example", metavar="NAME", help="audit a table that ships with fairaudit")
    parser.add_argument("--list-examples", action="store_true", help="list those tables")
    _add_columns(parser)
    _add_choice(parser)
    _add_utility(parser)
    add_limits(parser.add_argument_group("targets (decided exactly: for counts and logs, of the population from which they were drawn)"))
    add_population(parser)
    _add_input_and_output(parser)


def _add_columns(parser: argparse.ArgumentParser) -> None:
    roles = parser.add_argument_group("columns (several: separate with commas, or repeat the option)")
    roles.add_argument("--decision", metavar="COL", help="what was decided")
    roles.add_argument("--group", metavar="COL", action="append", help="sensitive attribute; several form intersections")
    roles.add_argument(
        "--context", metavar="COL", action="append", help="what may legitimately matter; age:18,30,65 cuts numbers into intervals"
    )
    roles.add_argument("--truth", metavar="COL", help="true label: what should have been decided, for rates of true and false positives")
    form = roles.add_mutually_exclusive_group()
    form.add_argument("--count", metavar="COL", help="how often the row occurred")
    form.add_argument("--probability", metavar="COL", help="P(decision | context, group)")
    roles.add_argument("--weight", metavar="COL", help="P(context, group) up to a factor, with --probability")


def _add_choice(parser: argparse.ArgumentParser) -> None:
    choice = parser.add_argument_group("who of several candidates was chosen (instead of decision, group and utility)")
    choice.add_argument(
        "--slots", metavar="COL", action="append", help="a column per slot, in order, or one that lists the candidates in order"
    )
    choice.add_argument("--winner", metavar="COL", help="who was chosen; of a ranking, the first")
    choice.add_argument(
        "--profile-exp-epsilon", metavar="Q", help="e^epsilon of the filter of one profile, for the bound of a random order (T10)"
    )


def _add_utility(parser: argparse.ArgumentParser) -> None:
    worth = parser.add_argument_group("utility (what a decision is worth to the person)")
    kind = worth.add_mutually_exclusive_group()
    kind.add_argument("--utility", metavar="SPEC", help="decision[=number],…; decisions that are not listed are worth 0")
    kind.add_argument("--utility-column", metavar="COL", help="column with the utility of each row; --decision may then be left out")
    worth.add_argument(
        "--positive", metavar="LABEL", help="the positive true label, where the decisions that are worth something do not name it"
    )
    worth.add_argument(
        "--burden", action="store_true", help="the utility counts a burden: the group with more of it is disadvantaged, not favoured"
    )


def _add_input_and_output(parser: argparse.ArgumentParser) -> None:
    rest = parser.add_argument_group("input and output")
    rest.add_argument(
        "--missing",
        choices=("error", "drop", "group"),
        default="error",
        help="what to do with empty labels: refuse (default), leave the row out, or make them a level of their own",
    )
    add_label_options(rest)
    add_source(rest)
    rest.add_argument(
        "--in-parts",
        action="store_true",
        help="read some contexts at a time, in little memory, without intervals (done anyway beyond 20 million different rows)",
    )
    rest.add_argument(
        "--print-sql", choices=DIALECTS, metavar="DIALECT", help=f"print the query that counts the log ({', '.join(DIALECTS)})"
    )
    rest.add_argument("--top", metavar="K", type=_positive, default=3, help="how many of the most unequal pairs to list (default 3)")
    rest.add_argument("-o", "--output", metavar="FILE", help="write the certificate")
    rest.add_argument("--report", metavar="FILE", help="write a page for people, too (needs the extra 'report')")
    rest.add_argument("--no-table", action="store_true", help="keep the table out of the certificate (it is written beside it)")
    add_format(rest)


def run(arguments: argparse.Namespace) -> Answer:
    """Do the work."""
    from fairaudit.errors import InputError

    if arguments.list_examples:
        return _list_examples()
    if isinstance(arguments.table, list):
        arguments.table = arguments.table if len(arguments.table) > 1 else arguments.table[0] if arguments.table else None
    for name in ("truth", "positive"):
        if getattr(arguments, name) is not None and (arguments.from_monitor or arguments.slots):
            other = "--from-monitor" if arguments.from_monitor else "--slots"
            raise InputError(f"--{name} does not go with {other}; true labels go with counts and logs of decisions")
    if arguments.from_monitor is not None:
        from fairaudit.cli.monitored import certify_state

        return certify_state(arguments)
    if arguments.at_alarm:
        raise InputError("--at-alarm goes with --from-monitor")
    if arguments.example is not None:
        _take_example(arguments)
    elif arguments.print_sql is not None:
        from fairaudit.cli.counting_query import counting_query

        return counting_query(arguments)
    elif arguments.table is None:
        raise InputError("no table was named; give a CSV file, or --example ucb-admissions")
    if arguments.slots is not None:
        if arguments.report is not None:
            raise InputError("--report does not go with --slots; write the certificate with -o, and run fairaudit report on it")
        from fairaudit.cli.allocation import certify_choices

        return certify_choices(arguments)
    if arguments.winner is not None or arguments.profile_exp_epsilon is not None:
        raise InputError("--winner and --profile-exp-epsilon go with --slots")
    with _uncollected():
        return ready(_certify_in_parts(arguments) if arguments.in_parts else _certify(arguments), arguments.format)


@contextmanager
def _uncollected() -> Iterator[None]:
    """Spare the search for reference cycles, of which there are none: among millions of cells it would take a quarter of the time."""
    was = gc.isenabled()
    gc.disable()
    try:
        yield
    finally:
        if was:
            gc.enable()


def _certify(arguments: argparse.Namespace) -> Answer:
    """Certify a table, a log or an audit file."""
    from fairaudit.audits.certify import certify
    from fairaudit.errors import InputError
    from fairaudit.tables.engines.request import ManyRowsError

    audit = _audit_file(arguments) if isinstance(arguments.table, str) and arguments.table.endswith(".toml") else None
    try:
        subject, utility = (audit.subject, audit.utility) if audit else _read(arguments, None if _unfit_for_parts(arguments) else MOST_ROWS)
    except ManyRowsError:
        return _certify_in_parts(arguments)
    targets = given_limits(arguments)
    check_output(arguments)
    options = population_options(arguments, subject, audit.sampling if audit else {})
    burden = arguments.burden or (audit is not None and audit.burden)
    declared = {**(audit.declared if audit else {}), **utility_range(arguments.utility_range)}
    try:
        result = certify(
            subject,
            utility,
            **{**(audit.targets if audit else {}), **targets},
            **options,
            declared=declared,
            embed_table=False if arguments.no_table else None,
            positive=audit.positive if audit else arguments.positive,
            burden=burden,
        )
        findings = findings_beside(arguments, result, utility, options)
    except InputError as error:
        raise InputError(f"{source_name(arguments.table)}: {error}") from None
    return certified(arguments, result, findings)


def _unfit_for_parts(arguments: argparse.Namespace) -> str:
    """Name an option that does not go with contexts that are read in parts; empty if there is none."""
    if isinstance(arguments.table, str) and arguments.table.endswith(".toml"):
        return "an audit file"
    if not arguments.context:
        return "a log without --context"
    unfit = (
        "count",
        "probability",
        "utility_column",
        "truth",
        "positive",
        "fold_labels",
        "map",
        "unit",
        "query",
        "report",
        "placebo",
        "claimed_exp_epsilon",
        "utility_range",
    )
    given = [name for name in unfit if getattr(arguments, name)]
    if given or arguments.missing != "error":
        return f"--{(given or ['missing'])[0].replace('_', '-')}"
    return "" if arguments.engine in ("auto", "duckdb") else f"--engine {arguments.engine}"


def _certify_in_parts(arguments: argparse.Namespace) -> Answer:
    """Certify a log of very many contexts."""
    from fairaudit.audits.in_parts import certify_in_parts
    from fairaudit.errors import InputError

    if unfit := _unfit_for_parts(arguments):
        raise InputError(f"--in-parts does not go with {unfit}")
    group, context = column_roles(arguments.group), column_roles(arguments.context)
    if arguments.decision is None or arguments.utility is None or not group.names:
        raise InputError("contexts that are read in parts need --decision, --group and --utility")
    check_output(arguments)
    with progress() as told:
        try:
            result = certify_in_parts(
                arguments.table,
                utility_spec(arguments.utility),
                decision=arguments.decision,
                group=group.names,
                context=context.names,
                bins={**group.edges, **context.edges},
                table=arguments.database_table,
                memory=arguments.memory,
                report=told,
                **given_limits(arguments),
                confidence=confidence_option(arguments.confidence),
                top=arguments.top,
                embed_table=False if arguments.no_table else None,
                burden=arguments.burden,
            )
        except InputError as error:
            raise InputError(f"{source_name(arguments.table)}: {error}") from None
    return certified(arguments, result, [])


def _audit_file(arguments: argparse.Namespace) -> Audit:
    """Read an audit file, which names its columns and utility itself."""
    from fairaudit.cli.audit_file import read_audit
    from fairaudit.errors import InputError

    foreign = (
        "decision",
        "group",
        "context",
        "truth",
        "count",
        "probability",
        "weight",
        "utility",
        "utility_column",
        "positive",
        "unit",
        "placebo",
    )
    for name in foreign:
        if getattr(arguments, name):
            raise InputError(f"--{name.replace('_', '-')} goes with a table; the audit file {arguments.table} says it itself")
    if arguments.missing != "error":
        raise InputError("--missing goes with a table; the audit file has missing in [law] or [policy]")
    if arguments.fold_labels or arguments.map:
        raise InputError("--fold-labels and --map go with a table; the audit file has fold_labels and map in [law] or [policy]")
    return read_audit(arguments.table)


def _positive(text: str) -> int:
    if not re.fullmatch("[1-9][0-9]{0,4}", text) or int(text) > 10_000:
        from fairaudit.errors import shown

        raise argparse.ArgumentTypeError(f"{shown(text)} is not a whole number from 1 to 10000")
    return int(text)


def _list_examples() -> Answer:
    from fairaudit.tables.examples import EXAMPLES

    return Answer(
        "examples",
        sentence=f"{len(EXAMPLES)} tables ship with fairaudit.",
        result=lambda: [{"name": entry.name, "title": entry.title, "source": entry.source} for entry in EXAMPLES],
        text=lambda: "\n".join(f"{entry.name}\n    {entry.title}\n    {entry.source}" for entry in EXAMPLES),
    )


def _take_example(arguments: argparse.Namespace) -> None:
    """Fill in the options of an example; those that were given win."""
    from fairaudit.errors import InputError
    from fairaudit.tables.examples import example

    if arguments.table is not None:
        raise InputError("both a table and --example were given; give one")
    entry = example(arguments.example)
    if not entry.decision:
        arguments.table = entry.path
        return
    arguments.table = entry.table()
    arguments.decision = arguments.decision or entry.decision
    arguments.group = arguments.group or [entry.group]
    arguments.context = arguments.context or [entry.context]
    if arguments.utility is None and arguments.utility_column is None:
        arguments.utility = entry.utility
    if not (arguments.count or arguments.probability):
        arguments.count, arguments.probability = entry.count or None, entry.probability or None


def _read(arguments: argparse.Namespace, most: int | None) -> tuple[Law, Utility]:

    from fairaudit.errors import InputError, shown

    if arguments.utility is None and arguments.utility_column is None:
        raise InputError(
            "no utility was given; use --utility, such as --utility Admitted or --utility yes=1,maybe=0.5, or --utility-column COL"
        )
    decision = arguments.decision or arguments.utility_column
    if decision is None:
        raise InputError("no decision column was named; use --decision COL")
    group, context = column_roles(arguments.group), column_roles(arguments.context)
    groups, contexts, unit = group.names, context.names, column_list(arguments.unit)
    if not groups:
        raise InputError("no group column was named; use --group COL")
    numeric = [c for c in (arguments.count, arguments.probability, arguments.weight) if c is not None]
    if arguments.utility_column in (*groups, *contexts, *numeric):
        raise InputError(f"the column {shown(arguments.utility_column)} is used twice; each column has one role")
    if arguments.truth is not None and arguments.probability is not None:
        raise InputError("--truth goes with counts and logs; probabilities do not say what should have been decided")
    if arguments.unit and (arguments.count or arguments.probability):
        raise InputError("--unit goes with a log, which has one decision per row; counts do not say which rows belong together")
    if arguments.weight is not None and arguments.probability is None:
        raise InputError("--weight goes with --probability; counts and logs carry their own population")
    valued = [] if arguments.utility_column is None else [arguments.utility_column]
    truth = [] if arguments.truth is None else [arguments.truth]
    wanted = (decision, *groups, *contexts, *truth, *unit, *numeric, *valued)
    table = read_source(arguments, arguments.table, wanted, {**group.edges, **context.edges}, [*numeric, *valued], most, contexts)
    from fairaudit.model.utility import Utility

    try:
        labelled = (decision, *groups, *contexts, *([arguments.truth] if arguments.truth else []))
        table = with_labels(arguments, table, labelled)
        law = law_from_options(arguments, table, decision, groups, contexts, unit, arguments.truth)
        if arguments.utility is not None:
            utility = Utility(utility_spec(arguments.utility))
        else:
            utility = Utility.from_table(
                table, utility=arguments.utility_column, decision=decision, group=groups, context=contexts, missing=arguments.missing
            )
        utility.on(law)
    except InputError as error:
        raise InputError(f"{table.name}: {error}") from None
    return law, utility
