"""`fairaudit certify`: audit a table, judge it against targets, write a certificate."""

from __future__ import annotations

import argparse
import csv
import json
import os
import re
import sys
from pathlib import Path
from typing import TYPE_CHECKING, Any

from fairaudit.cli import population

if TYPE_CHECKING:
    from fairaudit.audit import Result
    from fairaudit.cli.audit_file import Audit
    from fairaudit.cli.population import Finding
    from fairaudit.law import Law
    from fairaudit.tables.csv import CsvTable
    from fairaudit.utility import Utility

TARGETS = ("max_local", "max_global", "max_local_ratio", "max_global_ratio")
DESCRIPTION = """\
Measure how unequally a table of decisions treats groups: exactly, with the pair of groups that is worst off, and as a certificate that
anybody can check. The table is a CSV file with a header line, in one of three forms: a count per row (--count), a probability
per row (--probability), or one decision per row (neither)."""

EPILOG = """\
exit codes: 0 within the targets, or no target; 1 a target is exceeded; 2 bad input; 3 inconclusive

examples:
  fairaudit certify --example ucb-admissions -o certificate.json
  fairaudit certify admissions.csv --decision Admit --group Gender --context Dept --count Freq --utility Admitted
  fairaudit certify log.csv --decision answer --group sex,age --utility yes=1,maybe=0.5 --max-local-ratio 5/4 --confidence 0.99
  fairaudit certify log.csv --decision answer --group sex --utility yes --max-local 0.2 --unit interview"""


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
    parser.add_argument("table", metavar="TABLE", nargs="?", help="CSV file with a header line, or an audit file (.toml)")
    parser.add_argument("--example", metavar="NAME", help="audit a table that ships with fairaudit")
    parser.add_argument("--list-examples", action="store_true", help="list those tables")
    roles = parser.add_argument_group("columns (several: separate with commas, or repeat the option)")
    roles.add_argument("--decision", metavar="COL", help="what was decided")
    roles.add_argument("--group", metavar="COL", action="append", help="sensitive attribute; several form intersections")
    roles.add_argument("--context", metavar="COL", action="append", help="what may legitimately matter")
    form = roles.add_mutually_exclusive_group()
    form.add_argument("--count", metavar="COL", help="how often the row occurred")
    form.add_argument("--probability", metavar="COL", help="P(decision | context, group)")
    roles.add_argument("--weight", metavar="COL", help="P(context, group) up to a factor, with --probability")
    choice = parser.add_argument_group("who of several candidates was chosen (instead of decision, group and utility)")
    choice.add_argument(
        "--slots", metavar="COL", action="append", help="a column per slot, in order, or one that lists the candidates in order"
    )
    choice.add_argument("--winner", metavar="COL", help="who was chosen; of a ranking, the first")
    choice.add_argument(
        "--profile-exp-epsilon", metavar="Q", help="e^epsilon of the filter of one profile, for the bound of a random order (T10)"
    )
    worth = parser.add_argument_group("utility (what a decision is worth to the person)")
    kind = worth.add_mutually_exclusive_group()
    kind.add_argument("--utility", metavar="SPEC", help="decision[=number],…; decisions that are not listed are worth 0")
    kind.add_argument("--utility-column", metavar="COL", help="column with the utility of each row; --decision may then be left out")
    targets = parser.add_argument_group("targets (decided exactly: for counts and logs, of the population from which they were drawn)")
    targets.add_argument("--max-local", metavar="L", help="limit on L, the log of the worst ratio within a context")
    targets.add_argument("--max-global", metavar="L", help="limit on the log of the worst ratio of group means")
    targets.add_argument("--max-local-ratio", metavar="Q", help="the same as a ratio, such as 5/4")
    targets.add_argument("--max-global-ratio", metavar="Q", help="the same as a ratio")
    population.add_options(parser)
    rest = parser.add_argument_group("input and output")
    rest.add_argument(
        "--missing",
        choices=("error", "drop", "group"),
        default="error",
        help="what to do with empty labels: refuse (default), leave the row out, or make them a level of their own",
    )
    rest.add_argument("--top", metavar="K", type=_positive, default=3, help="how many of the most unequal pairs to list (default 3)")
    rest.add_argument("-o", "--output", metavar="FILE", help="write the certificate")
    rest.add_argument("--report", metavar="FILE", help="write a page for people, too (needs the extra 'report')")
    rest.add_argument("--no-table", action="store_true", help="keep the table out of the certificate (it is written beside it)")
    rest.add_argument("--format", choices=("text", "json"), default="text", help="what to print")


def run(arguments: argparse.Namespace) -> int:
    """Do the work."""
    from fairaudit.exact import InputError

    if arguments.list_examples:
        _list_examples()
        return 0
    if arguments.example is not None:
        _take_example(arguments)
    elif arguments.table is None:
        raise InputError("no table was named; give a CSV file, or --example ucb-admissions")
    if arguments.slots is not None:
        if arguments.report is not None:
            raise InputError("--report does not go with --slots; write the certificate with -o, and run fairaudit report on it")
        from fairaudit.cli.allocation import run as run_allocation

        return run_allocation(arguments)
    if arguments.winner is not None or arguments.profile_exp_epsilon is not None:
        raise InputError("--winner and --profile-exp-epsilon go with --slots")
    audit = _audit_file(arguments) if isinstance(arguments.table, str) and arguments.table.endswith(".toml") else None
    subject, utility = (audit.subject, audit.utility) if audit else _read(arguments)
    targets = {name: getattr(arguments, name) for name in TARGETS if getattr(arguments, name) is not None}
    check_output(arguments)
    if arguments.report is not None:
        _check_page(arguments)

    from fairaudit.audit import certify

    options = population.options(arguments, subject, audit.sampling if audit else {})
    declared = {**(audit.declared if audit else {}), **population.utility_range(arguments.utility_range)}
    try:
        result = certify(
            subject,
            utility,
            **{**(audit.targets if audit else {}), **targets},
            **options,
            declared=declared,
            embed_table=False if arguments.no_table else None,
        )
        findings = population.findings(arguments, result, utility, options)
    except InputError as error:
        raise InputError(f"{getattr(arguments.table, 'name', arguments.table)}: {error}") from None
    from fairaudit.cli.text import plain, put, summary

    said = json.dumps(_json(result, arguments.top, findings), ensure_ascii=True, indent=1) if arguments.format == "json" else ""
    written = result.certificate.save(arguments.output) if arguments.output is not None else []
    if arguments.report is not None:
        from fairaudit.cli.report import write_page

        write_page(result.certificate, arguments.report)
    if arguments.format == "json":
        put(said)
    else:
        for note in result.notes:
            print(f"note: {plain(note)}", file=sys.stderr)
        put(summary(result, arguments.top, [str(path) for path in written], [plain(finding.sentence) for finding in findings]))
    code = {"none": 0, "within": 0, "exceeds": 1, "inconclusive": 3}[result.verdict]
    return 1 if any(finding.refuted for finding in findings) else code


def _audit_file(arguments: argparse.Namespace) -> Audit:
    """Read an audit file, which names its columns and utility itself."""
    from fairaudit.cli.audit_file import read_audit
    from fairaudit.exact import InputError

    foreign = ("decision", "group", "context", "count", "probability", "weight", "utility", "utility_column", "unit", "placebo")
    for name in foreign:
        if getattr(arguments, name):
            raise InputError(f"--{name.replace('_', '-')} goes with a table; the audit file {arguments.table} says it itself")
    if arguments.missing != "error":
        raise InputError("--missing goes with a table; an audit file refuses missing labels")
    return read_audit(arguments.table)


def column_list(given: list[str] | None) -> tuple[str, ...]:
    """Column names from repeated options with commas; a name with a comma is quoted as in CSV.

    Raises
    ------
    InputError
        If the quotes do not fit.

    Examples
    --------
    >>> column_list(["sex, age", '"last, first"'])
    ('sex', 'age', 'last, first')
    """
    from fairaudit.exact import InputError, shown

    names: list[str] = []
    for text in given or []:
        try:
            names += next(csv.reader([text], skipinitialspace=True, strict=True), [])
        except csv.Error:
            raise InputError(
                f"{shown(text)} is not a list of column names; separate them with commas, and quote a name with a comma as in CSV"
            ) from None
    return tuple(names)


def utility_spec(text: str) -> dict[str, str]:
    """Read ``decision[=number],…``; a label with a comma or an equals sign is quoted as in CSV.

    Raises
    ------
    InputError
        If the text is not of that form.

    Examples
    --------
    >>> utility_spec('yes,maybe=0.5,"no, sorry"=1/4')
    {'yes': '1', 'maybe': '0.5', 'no, sorry': '1/4'}
    """
    from fairaudit.exact import InputError, shown

    values: dict[str, str] = {}
    rest = text.strip()
    while rest:
        if rest.startswith('"'):
            end = 1
            while (end := rest.find('"', end)) >= 0 and rest[end : end + 2] == '""':
                end += 2
            if end < 0:
                raise InputError(f"--utility {shown(text)} has a quotation mark that is not closed")
            label, rest = rest[1:end].replace('""', '"'), rest[end + 1 :].lstrip()
        else:
            cut = min((i for i in (rest.find(","), rest.find("=")) if i >= 0), default=len(rest))
            label, rest = rest[:cut].strip(), rest[cut:]
        value = "1"
        if rest.startswith("="):
            value, _, rest = rest[1:].partition(",")
        elif rest.startswith(",") and len(rest) > 1:
            rest = rest[1:]
        elif rest:
            raise InputError(f"--utility {shown(text)} is not of the form decision[=number],… near {shown(rest)}")
        rest = rest.lstrip()
        if not label or label in values:
            raise InputError(
                f"--utility {shown(text)} {'has an empty label' if not label else f'lists {shown(label)} twice'}; list each decision once"
            )
        values[label] = value.strip()
    if not values:
        raise InputError("--utility is empty; list at least one decision, such as Admitted or yes=1,maybe=0.5")
    return values


def _positive(text: str) -> int:
    if not re.fullmatch("[1-9][0-9]{0,4}", text) or int(text) > 10_000:
        from fairaudit.exact import shown

        raise argparse.ArgumentTypeError(f"{shown(text)} is not a whole number from 1 to 10000")
    return int(text)


def check_output(arguments: argparse.Namespace) -> None:
    """Refuse an output that cannot be written, or must not be, before the work is done."""
    from fairaudit.exact import InputError

    if arguments.output is None:
        if arguments.no_table:
            raise InputError("--no-table needs -o FILE, to write the certificate and its table separately")
        return
    refuse_output(arguments.output, arguments.table if isinstance(arguments.table, str) else None)


def refuse_output(name: str, table: str | None) -> None:
    """Refuse a file that cannot be written, or is the table.

    Raises
    ------
    InputError
        If it is one of these.
    """
    from fairaudit.exact import InputError

    path = Path(name)
    try:
        fault = _fault(path, table)
    except (OSError, ValueError) as error:
        fault = f"cannot be written: {getattr(error, 'strerror', None) or error}"
    if fault:
        raise InputError(f"{path} {fault}")


def _check_page(arguments: argparse.Namespace) -> None:
    """Refuse a page that cannot be written, before the work is done."""
    from fairaudit.exact import InputError
    from fairaudit.report import check_extra

    refuse_output(arguments.report, arguments.table if isinstance(arguments.table, str) else None)
    if arguments.output is not None and os.path.realpath(arguments.output) == os.path.realpath(arguments.report):
        raise InputError("-o and --report name the same file; the certificate and its page need one each")
    check_extra()


def _fault(path: Path, table: str | None) -> str:
    """Why a file must not be written; empty if nothing is wrong."""
    if path.is_dir():
        return "is a directory; name a file to write"
    if not path.parent.is_dir():
        return f"cannot be written: there is no directory {path.parent}"
    try:
        found = path.stat()
    except FileNotFoundError:
        return ""
    if not path.is_file():
        return "is a device or a pipe; name a file to write"
    return "is the table itself; name another file to write" if table is not None and os.path.samestat(found, Path(table).stat()) else ""


def _list_examples() -> None:
    from fairaudit.tables.examples import EXAMPLES

    for entry in EXAMPLES:
        print(f"{entry.name}\n    {entry.title}\n    {entry.source}")


def _take_example(arguments: argparse.Namespace) -> None:
    """Fill in the options of an example; those that were given win."""
    from fairaudit.exact import InputError
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


def _read(arguments: argparse.Namespace) -> tuple[Law, Utility]:
    from dataclasses import replace

    from fairaudit.columns import column
    from fairaudit.exact import InputError, shown
    from fairaudit.sampling import repetition_warnings
    from fairaudit.tables.csv import read_csv
    from fairaudit.utility import Utility

    if arguments.utility is None and arguments.utility_column is None:
        raise InputError(
            "no utility was given; use --utility, such as --utility Admitted or --utility yes=1,maybe=0.5, or --utility-column COL"
        )
    decision = arguments.decision or arguments.utility_column
    if decision is None:
        raise InputError("no decision column was named; use --decision COL")
    groups, contexts = column_list(arguments.group), column_list(arguments.context)
    if not groups:
        raise InputError("no group column was named; use --group COL")
    numeric = [c for c in (arguments.count, arguments.probability, arguments.weight) if c is not None]
    if arguments.utility_column in (*groups, *contexts, *numeric):
        raise InputError(f"the column {shown(arguments.utility_column)} is used twice; each column has one role")
    if arguments.unit and (arguments.count or arguments.probability):
        raise InputError("--unit goes with a log, which has one decision per row; counts do not say which rows belong together")
    if arguments.weight is not None and arguments.probability is None:
        raise InputError("--weight goes with --probability; counts and logs carry their own population")
    table = read_csv(arguments.table) if isinstance(arguments.table, str) else arguments.table
    try:
        for name in (decision, *groups, *contexts, *column_list(arguments.unit)):
            column(table, name)
        table = table.with_numbers([*numeric, *([] if arguments.utility_column is None else [arguments.utility_column])])
        law = law_from_options(arguments, table, decision, groups, contexts, column_list(arguments.unit))
        if arguments.utility is not None:
            utility = Utility(utility_spec(arguments.utility))
        else:
            utility = Utility.from_table(
                table, utility=arguments.utility_column, decision=decision, group=groups, context=contexts, missing=arguments.missing
            )
        utility.on(law)
        if arguments.unit:
            law = replace(law, notes=(*law.notes, *repetition_warnings(table, column_list(arguments.unit), (*contexts, *groups), decision)))
    except InputError as error:
        raise InputError(f"{table.name}: {error}") from None
    return law, utility


def law_from_options(
    arguments: argparse.Namespace,
    table: CsvTable,
    decision: str,
    groups: tuple[str, ...],
    contexts: tuple[str, ...],
    unit: tuple[str, ...] = (),
) -> Law:
    """Read the law that the options describe."""
    from dataclasses import replace

    from fairaudit.law import Law

    if arguments.count is not None:
        law = Law.from_counts(table, decision=decision, group=groups, context=contexts, count=arguments.count, missing=arguments.missing)
    elif arguments.probability is not None:
        law = Law.from_probabilities(
            table,
            decision=decision,
            group=groups,
            context=contexts,
            probability=arguments.probability,
            weight=arguments.weight,
            missing=arguments.missing,
        )
    else:
        law = Law.from_log(table, decision=decision, group=groups, context=contexts, missing=arguments.missing, unit=unit)
    return replace(law, notes=(*table.notes, *law.notes))


def _json(result: Result, top: int, findings: list[Finding]) -> dict[str, Any]:
    """What `--format json` prints: the certificate, the sentence, the most unequal pairs, findings of tests, and the notes."""
    from fairaudit.audit import measure_entry

    return {
        "verdict": result.verdict,
        "sentence": result.sentence,
        "most_unequal": {name: [measure_entry(m) for m in measures] for name, measures in result.most_unequal(top).items()},
        "findings": [{"test": found.test, "sentence": found.sentence, **found.figures} for found in findings],
        "further_draws": [
            {"quantity": target.quantity, "unit": target.unit, "draws": planned.draws, "sentence": planned.sentence}
            for target, planned in result.further_draws
        ],
        "notes": list(result.notes),
        "certificate": result.certificate.document,
    }
