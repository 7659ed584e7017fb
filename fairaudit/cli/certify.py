"""`fairaudit certify`: audit a table, judge it against targets, write a certificate."""

from __future__ import annotations

import argparse
import re
from dataclasses import replace
from typing import TYPE_CHECKING, Any

from fairaudit.cli import CORE
from fairaudit.cli.attesting import add_attestation, attesting, refuse_attestation
from fairaudit.cli.certified import TOP, certified
from fairaudit.cli.destinations import add_output, check_output, documents
from fairaudit.cli.keeping import add_keep, keeping, refuse_beside_keep
from fairaudit.cli.options import add_command, add_limits, column_list, confidence_option, given_limits, unknown_shares, utility_range
from fairaudit.cli.output import Answer, add_format, ready
from fairaudit.cli.population import add_population, findings_beside, population_options
from fairaudit.cli.source import (
    add_label_options,
    add_lexicon,
    add_samples,
    add_score,
    add_source,
    add_table_form,
    add_wide,
    extraction_from,
    fill_recipe,
    lexicon_of,
    option,
    progress,
    reading_of,
)
from fairaudit.exact.collecting import uncollected
from fairaudit.measures.limits import LIMITS
from fairaudit.tables.sources import is_audit_file, source_name

if TYPE_CHECKING:
    from fairaudit.audits.audit_file import Audit
    from fairaudit.audits.reading import Reading
    from fairaudit.cli.attesting import Attesting
    from fairaudit.cli.keeping import Kept
    from fairaudit.model.law import Law
    from fairaudit.model.utility import Utility


DIFFERENCES = ("difference", "max_difference", "max_global_difference")

LISTED = 50  # most unequal pairs that are kept of contexts that are read in parts, for the contexts on the screen

COLUMNS = (
    "decision",
    "score",
    "utility_column",
    "utility",
    "group",
    "context",
    "count",
    "probability",
    "truth",
    "unit",
    "wide",
    "slots",
    "winner",
)
DIALECTS = ("bigquery", "duckdb", "postgres", "snowflake", "spark", "sqlite", "trino")

DESCRIPTION = """\
Measure how unequally a table of decisions treats groups: exactly, with the pair of groups that is worst off, and as a certificate that
anybody can check. The table has one of four forms: a count per row (--count), a column of counts for each decision (--wide), a
probability per row (--probability), or one decision per row (none of these); such a log may have any size, in CSV, Parquet or JSON
lines, or in a database."""


EPILOG = """\
exit codes: 0 within the targets, or no target; 1 a target is exceeded; 2 bad input; 3 inconclusive

examples:
  fairaudit certify --example ucb-admissions -o certificate.json
  fairaudit certify admissions.csv --decision Admit --group Gender --context Dept --count Freq --utility Admitted
  fairaudit certify log.csv --decision answer --group sex,age --utility yes=1,maybe=0.5 --max-local-ratio 5/4 --confidence 0.99
  fairaudit certify log.csv --decision answer --group sex --utility yes --max-local-ratio 0.8 --unit interview"""


def add(commands: Any) -> None:
    """Declare the options."""
    parser = add_command(commands, "certify", run, CORE["certify"], DESCRIPTION, EPILOG)
    parser.add_argument(
        "table",
        metavar="TABLE",
        nargs="*",
        help="files (CSV, Parquet, JSON lines), logs of evaluations, "
        "a database (sqlite:FILE, duckdb:FILE, delta:FOLDER, postgresql://…), or an audit file",
    )
    parser.add_argument("--from-monitor", metavar="STATE", help="certify what `fairaudit monitor --state STATE` has counted so far")
    parser.add_argument("--at-alarm", action="store_true", help="with --from-monitor: at the moment of the first alarm")
    parser.add_argument("--example", metavar="NAME", help="audit a table that ships with fairaudit")
    parser.add_argument("--list-examples", action="store_true", help="list those tables")
    _add_columns(parser)
    add_samples(parser)
    _add_choice(parser)
    _add_utility(parser)
    targets = parser.add_argument_group("targets (decided exactly: for counts and logs, of the population from which they were drawn)")
    add_limits(targets, differences=True)
    targets.add_argument(
        "--max-drift",
        metavar="D",
        help="judge the worst case within this total variation, from 0 to 1: of every cell of a table, or of a policy behind filters",
    )
    targets.add_argument(
        "--hidden-context",
        metavar="K,M[,higher|lower]",
        help="judge ratios with an unrecorded factor that is at most K times as common in one group as in another and changes what one of "
        "them gets at most M times; K limits both directions, or only how much more common it is in the group that gets more, or less",
    )
    add_population(parser)
    _add_guarantees(parser)
    _add_input_and_output(parser)
    add_attestation(parser)


def _add_columns(parser: argparse.ArgumentParser) -> None:
    roles = parser.add_argument_group("columns (several: separate with commas, or repeat the option)")
    roles.add_argument("--decision", metavar="COL", help="what was decided")
    add_score(roles)
    roles.add_argument("--group", metavar="COL", action="append", help="sensitive attribute; several form intersections")
    roles.add_argument(
        "--context", metavar="COL", action="append", help="what may legitimately matter; age:18,30,65 cuts numbers into intervals"
    )
    roles.add_argument(
        "--group-probability",
        metavar="FILE",
        help="where no row has its group: P(group | cell), with columns of the cell, as the log has them, of the group, and probability "
        "(or low and high)",
    )
    roles.add_argument("--truth", metavar="COL", help="true label: what should have been decided, for rates of true and false positives")
    add_table_form(roles)
    add_wide(roles)


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
        "--difference",
        action="store_true",
        help="state differences of expected utilities, too; utilities may then be negative, and of negative ones no ratio is stated",
    )
    worth.add_argument(
        "--undecided",
        metavar="LABEL",
        action="append",
        help="decisions whose meaning is not known, such as refused,unreadable: targets are judged whatever each of them meant",
    )
    add_lexicon(worth)
    worth.add_argument(
        "--burden", action="store_true", help="the utility counts a burden: the group with more of it is disadvantaged, not favoured"
    )


def _add_guarantees(parser: argparse.ArgumentParser) -> None:
    further = parser.add_argument_group("what is guaranteed behind filters (of an audit file with [policy])")
    further.add_argument(
        "--all-bounds", action="store_true", help="state bounds that the greatest ratio over all policies makes superfluous, too"
    )


def _add_input_and_output(parser: argparse.ArgumentParser) -> None:
    rest = parser.add_argument_group("input and output")
    add_label_options(rest, unknown=True)
    add_source(rest)
    rest.add_argument(
        "--in-parts",
        action="store_true",
        help="read some contexts at a time, in little memory (done anyway beyond 20 million different rows)",
    )
    rest.add_argument(
        "--print-sql", choices=DIALECTS, metavar="DIALECT", help=f"print the query that counts the log ({', '.join(DIALECTS)})"
    )
    rest.add_argument(
        "--top", metavar="K", type=_positive, help=f"print everything, with so many of the most unequal pairs (default {TOP})"
    )
    rest.add_argument("--verbose", action="store_true", help="print everything that was found, not the first screen alone")
    rest.add_argument(
        "--show-completions",
        action="store_true",
        help="print who the members of the groups could be at each end (--group-probability, --unknown, --missing unknown), which "
        "updates change a verdict on a ratio, or are the worst and the best within --max-drift, "
        "and which unrecorded factor could explain one",
    )
    add_output(rest)
    add_keep(rest)
    add_format(rest)


def _refuse_beside(arguments: argparse.Namespace) -> None:
    """Refuse options that do not go with a monitor's state, or with a choice among candidates."""
    from fairaudit.errors import InputError

    other = "--from-monitor" if arguments.from_monitor else "--slots" if arguments.slots else ""
    for name in ("score", "above", "truth", "positive", "hidden_context", "undecided", *DIFFERENCES) if other else ():
        if getattr(arguments, name):
            what = {
                "score": "scores go",
                "above": "scores go",
                "truth": "true labels go",
                "positive": "true labels go",
                "hidden_context": "a hidden context goes",
                "undecided": "undecided decisions go",
            }
            raise InputError(
                f"{option(name)} does not go with {other}; {what.get(name, 'differences go')} with counts and logs of decisions"
            )


def run(arguments: argparse.Namespace) -> Answer:
    """Do the work."""
    with uncollected():
        return _answer(arguments)


def _answer(arguments: argparse.Namespace) -> Answer:
    from fairaudit.errors import InputError

    if arguments.list_examples:
        return _list_examples()
    if isinstance(arguments.table, list):
        arguments.table = arguments.table if len(arguments.table) > 1 else arguments.table[0] if arguments.table else None
    if arguments.keep is not None:
        refuse_beside_keep(arguments)
    fill_recipe(arguments)
    _check_unknown(arguments)
    if arguments.group_probability is not None:
        return _certify_by_proxies(arguments)
    _refuse_beside(arguments)
    if arguments.from_monitor is not None:
        from fairaudit.cli.monitored import certify_state

        return certify_state(arguments)
    if arguments.at_alarm:
        raise InputError("--at-alarm goes with --from-monitor")
    if arguments.example is not None:
        _take_example(arguments)
    elif arguments.print_sql is not None:
        refuse_attestation(arguments, "--print-sql, which reads nothing")
        from fairaudit.cli.counting_query import counting_query

        return counting_query(arguments)
    elif arguments.table is None:
        raise InputError("no table was named; give a CSV file, or --example ucb-admissions")
    if arguments.keep is not None:
        with keeping(arguments) as kept:
            found = _certify_in_parts(arguments, kept=kept) if arguments.in_parts else _certify(arguments, kept)
            return ready(found, arguments.format)
    if not (arguments.in_parts or is_audit_file(arguments.table) or any(getattr(arguments, name) for name in COLUMNS)):
        from fairaudit.cli.asking import ask_for_columns

        ask_for_columns(arguments)
    if arguments.slots is not None:
        refuse_attestation(arguments, "--slots, which writes two certificates; a statement is about one table")
        from fairaudit.cli.allocation import certify_choices

        return certify_choices(arguments)
    if arguments.winner is not None or arguments.profile_exp_epsilon is not None:
        raise InputError("--winner and --profile-exp-epsilon go with --slots")
    return ready(_certify_in_parts(arguments) if arguments.in_parts else _certify(arguments), arguments.format)


def _check_unknown(arguments: argparse.Namespace) -> None:
    """Refuse options about decisions of unknown group where there can be none."""
    from fairaudit.errors import InputError

    unknown = bool(arguments.unknown) or arguments.missing == "unknown"
    possible = unknown or is_audit_file(arguments.table)
    if arguments.unknown_share and not possible:
        raise InputError("--unknown-share goes with --unknown LABEL, the labels that name no group, or --missing unknown")
    drifts = any(getattr(arguments, name) is not None for name in ("max_drift", "hidden_context", *LIMITS))
    if arguments.show_completions and not possible and not drifts and arguments.group_probability is None:
        raise InputError(
            "--show-completions goes with --group-probability, with --unknown LABEL or --missing unknown, with --hidden-context, and with "
            "a target on a ratio (such as --max-local-ratio)"
        )
    for name in ("from_monitor", "slots", "group_probability"):
        if unknown and getattr(arguments, name) is not None:
            raise InputError(f"--unknown and --missing unknown do not go with {option(name)}; they go with tables and logs of decisions")


def _certify_by_proxies(arguments: argparse.Namespace) -> Answer:
    """Certify a log without groups by the probabilities of groups in its cells."""
    from fairaudit.cli.proxies import certify_by_proxies
    from fairaudit.errors import InputError

    if arguments.example is not None:
        _take_example(arguments)
    if arguments.table is None:
        raise InputError("no table was named; give a CSV file, or --example ucb-admissions")
    return ready(certify_by_proxies(arguments), arguments.format)


def _certify(arguments: argparse.Namespace, kept: Kept | None = None) -> Answer:
    """Certify a table, a log or an audit file."""
    from fairaudit.audits.certify import certify
    from fairaudit.audits.warned import warned
    from fairaudit.errors import InputError, ManyRowsError, naming
    from fairaudit.tables.scores import ABOVE

    if (arguments.score or arguments.above) and arguments.utility is None and arguments.utility_column is None:
        arguments.utility = ABOVE
    if kept is None:  # whose options were looked at before its log was counted
        check_output(arguments)
    stated, lexicon = attesting(arguments), lexicon_of(arguments)
    audit = _audit_file(arguments) if is_audit_file(arguments.table) else None
    try:
        subject, utility, of_columns = (audit.subject, audit.utility, ()) if audit else _read(arguments)
    except ManyRowsError:
        return _certify_in_parts(arguments, stated, kept)
    targets = given_limits(arguments)
    options = population_options(arguments, subject, audit.sampling if audit else {})
    from fairaudit.model.law import Law

    if arguments.all_bounds and isinstance(subject, Law):
        raise InputError("--all-bounds is about a policy behind filters; name an audit file with [policy] and [filter.group]")
    burden = arguments.burden or (audit is not None and audit.burden)
    declared = {**(audit.declared if audit else {}), **utility_range(arguments.utility_range)}
    with naming(source_name(arguments.table)):
        result = certify(
            subject,
            utility,
            **{**(audit.targets if audit else {}), **targets},
            **options,
            declared=declared,
            declared_in=audit.declared_in if audit else None,
            max_drift=audit.max_drift if audit and arguments.max_drift is None else arguments.max_drift,
            hidden_context=audit.hidden_context if audit and arguments.hidden_context is None else arguments.hidden_context,
            undecided=column_list(arguments.undecided) or (audit.undecided if audit else ()),
            all_bounds=arguments.all_bounds,
            embed_table=False if arguments.no_table else None,
            positive=audit.positive if audit else arguments.positive,
            burden=burden,
            difference=arguments.difference or (audit is not None and audit.difference),
            unknown_share=unknown_shares(arguments.unknown_share) or (audit.unknown_share if audit else None),
        )
        findings = findings_beside(arguments, result, utility, options)
    result = replace(result, warnings=warned(result, utility, lexicon, of_columns))
    return certified(arguments, result, findings, attesting=stated, kept=kept)


def _unfit_for_parts(arguments: argparse.Namespace, reading: Reading) -> str:
    """Name an option that does not go with contexts that are read in parts; empty if there is none."""
    from fairaudit.audits.reading import unfit_for_parts

    others = (
        "positive",
        "placebo",
        "claimed_exp_epsilon",
        "utility_range",
        "two_sided",
        "select",
        "missing_units",
        "by_context",
        "min_cell",
        "pool_small",
        "unknown_share",
        "max_drift",
        "hidden_context",
        "undecided",
        "all_bounds",
    )
    given = {name: getattr(arguments, name) for name in (*others, *DIFFERENCES)}
    return unfit_for_parts(reading, given) or ", ".join(f"-o {name}" for name in documents(arguments))


def _certify_in_parts(arguments: argparse.Namespace, stated: Attesting | None = None, kept: Kept | None = None) -> Answer:
    """Certify a log of very many contexts; its sources were perhaps looked at already."""
    from fairaudit.audits.in_parts import certify_in_parts
    from fairaudit.audits.warned import warned
    from fairaudit.errors import InputError, naming
    from fairaudit.model.utility import Utility, utility_values

    if is_audit_file(arguments.table):
        raise InputError("--in-parts does not go with an audit file")
    if arguments.decision is None or arguments.utility is None or not arguments.group:
        raise InputError("contexts that are read in parts need --decision, --group and --utility")
    reading, worth, lexicon = reading_of(arguments), utility_values(arguments.utility, "--utility"), lexicon_of(arguments)
    if unfit := _unfit_for_parts(arguments, reading):
        raise InputError(f"--in-parts does not go with {unfit}")
    if kept is None:
        check_output(arguments)
    stated = stated or attesting(arguments)
    with progress() as told, naming(source_name(arguments.table)):
        result = certify_in_parts(
            arguments.table,
            worth,
            decision=reading.decision,
            group=reading.group,
            context=reading.context,
            bins=reading.bins,
            table=arguments.database_table,
            memory=arguments.memory,
            report=told,
            **given_limits(arguments),
            confidence=confidence_option(arguments.confidence),
            interval=arguments.interval,
            independent=arguments.independent_cells,
            top=arguments.top or LISTED,
            embed_table=False if arguments.no_table else None,
            burden=arguments.burden,
            count=reading.count,
            missing=reading.missing if reading.missing in ("drop", "group") else "error",
        )
    result = replace(result, warnings=warned(result, Utility(worth), lexicon))
    return certified(arguments, result, [], attesting=stated, kept=kept)


def _audit_file(arguments: argparse.Namespace) -> Audit:
    """Read an audit file, which names its columns and utility itself."""
    from fairaudit.audits.audit_file import SAID_THERE, read_audit, refuse_beside

    given = {name: getattr(arguments, name) for name in (*SAID_THERE, "placebo")}
    refuse_beside(arguments.table, {**given, **extraction_from(vars(arguments)).asked}, option)
    others = {
        "missing": arguments.missing != "error",
        "unknown": arguments.unknown,
        "fold_labels": arguments.fold_labels,
        "map": arguments.map,
    }
    refuse_beside(arguments.table, others, option)
    return read_audit(arguments.table, signed=_signed(arguments))


def _signed(arguments: argparse.Namespace) -> bool:
    """Whether differences are asked for, so that utilities may be negative."""
    return any(getattr(arguments, name) for name in DIFFERENCES)


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


def _read(arguments: argparse.Namespace) -> tuple[Law, Utility, tuple[str, ...]]:
    """The law, what decisions are worth, and what to know of the columns."""
    from fairaudit.audits.reading import MOST_ROWS, read_table_of
    from fairaudit.audits.warned import columns_warned
    from fairaudit.errors import InputError
    from fairaudit.model.utility import Utility, utility_values

    if arguments.utility is None and arguments.utility_column is None:
        raise InputError(
            "no utility was given; use --utility, such as --utility Admitted or --utility yes=1,maybe=0.5, or --utility-column COL"
        )
    signed = _signed(arguments)
    reading = replace(reading_of(arguments), signed=signed)
    given = None if arguments.utility is None else Utility(utility_values(arguments.utility, "--utility"), signed=signed)
    with progress() as told:
        most = None if _unfit_for_parts(arguments, reading) else MOST_ROWS
        table, law, utility = read_table_of(arguments.table, reading, given, report=told, most=most)
        return law, utility, columns_warned(arguments.table, reading, table, law)
