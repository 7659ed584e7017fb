"""`fairaudit worst-case`: the utility of a class for which a table looks worst."""

from __future__ import annotations

import argparse
from itertools import pairwise
from math import inf
from typing import TYPE_CHECKING, Any

from fairaudit.cli import CORE
from fairaudit.cli.destinations import add_output, check_output, write_outputs
from fairaudit.cli.options import add_command, column_list
from fairaudit.cli.output import Answer, add_format, aligned
from fairaudit.cli.source import add_label_options, add_source, add_table_form, law_from_options
from fairaudit.words import noun

if TYPE_CHECKING:
    from fairaudit.worst.result import WorstCase

DESCRIPTION = """\
Find the utility, among all of a class, for which a table of decisions looks worst: the ratio that it gives exactly, a bound for every
utility of the class with its proof, and a certificate of both. Utilities lie between --g-min and --gamma; more options narrow the class."""

EPILOG = """\
exit codes: 0 found; 2 bad input

examples:
  fairaudit worst-case admissions.csv --decision Admit --group Gender --context Dept --count Freq --tau 0.3 -o certificate.json
  fairaudit worst-case grades.csv --decision grade --group sex --tau 1/4 --order low,mid,high
  fairaudit worst-case log.csv --decision answer --group age --tau 0.2 --not-blind --lipschitz 0.1 --global"""

SHOWN_ROWS = 20


def add(commands: Any) -> None:
    """Declare the options."""
    parser = add_command(commands, "worst-case", run, CORE["worst-case"], DESCRIPTION, EPILOG)
    _add_table(parser)
    _add_class(parser)
    _add_input_and_output(parser)


def _add_table(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("table", metavar="TABLE", help="file (CSV, Parquet, JSON lines) or database (sqlite:FILE, postgresql://…)")
    roles = parser.add_argument_group("columns (several: separate with commas, or repeat the option)")
    roles.add_argument("--decision", metavar="COL", required=True, help="what was decided")
    roles.add_argument("--group", metavar="COL", action="append", required=True, help="sensitive attribute; several form intersections")
    roles.add_argument("--context", metavar="COL", action="append", help="what may legitimately matter")
    add_table_form(roles)


def _add_class(parser: argparse.ArgumentParser) -> None:
    kind = parser.add_argument_group("the class of utilities (exact numbers)")
    kind.add_argument("--gamma", metavar="G", default="1", help="greatest utility (1)")
    kind.add_argument("--g-min", metavar="M", default="0", help="least utility (0)")
    kind.add_argument("--tau", metavar="T", help="floor of the expected utility of the groups compared")
    kind.add_argument("--tau-on", choices=("all", "pair"), default="all", help="which groups keep the floor (all)")
    kind.add_argument("--not-blind", action="store_true", help="the utility may depend on the group")
    kind.add_argument("--lipschitz", metavar="L", help="by how much at most, with --not-blind")
    kind.add_argument("--order", metavar="LOW,…,HIGH", action="append", help="decisions from the least to the most useful")


def _add_input_and_output(parser: argparse.ArgumentParser) -> None:
    rest = parser.add_argument_group("input and output")
    rest.add_argument("--global", dest="overall", action="store_true", help="compare group means instead of groups within contexts")
    add_label_options(rest)
    add_source(rest)
    add_output(rest)
    add_format(rest)


def run(arguments: argparse.Namespace) -> Answer:
    """Do the work."""
    from fairaudit.audits.worst_utility import certify_worst_case
    from fairaudit.errors import InputError
    from fairaudit.model.utility_class import UtilityClass
    from fairaudit.worst.methods import worst_case

    check_output(arguments)
    order = [pair for chain in arguments.order or [] for labels in (column_list([chain]),) for pair in _chain(labels)]
    of = UtilityClass(
        gamma=arguments.gamma,
        m=arguments.g_min,
        tau=arguments.tau,
        tau_on=arguments.tau_on,
        blind=not arguments.not_blind,
        lipschitz=arguments.lipschitz,
        order=order,
    )
    law = law_from_options(arguments)
    try:
        found = worst_case(law, of, "global" if arguments.overall else "local")
    except InputError as error:
        raise InputError(f"{arguments.table}: {error}") from None
    if arguments.output is None and arguments.format != "json":
        return _answer(found, {}, [])
    certificate = certify_worst_case(found, embed_table=False if arguments.no_table else None)
    written = write_outputs((certificate, arguments.output)) if arguments.output else []
    return _answer(found, certificate.document, written)


def _answer(found: WorstCase, document: dict[str, Any], written: list[str]) -> Answer:
    return Answer(
        "worst-case",
        sentence=f"{_headline(found)}. {_who(found)}",
        notes=found.law.notes,
        result=lambda: _entry(found, document),
        text=lambda: _text(found, written),
    )


def _chain(labels: tuple[str, ...]) -> list[tuple[str, str]]:
    from fairaudit.errors import InputError, shown

    if len(labels) < 2:
        raise InputError(f"--order {shown(','.join(labels))} names fewer than two decisions; list them from the least to the most useful")
    return list(pairwise(labels))


def _headline(found: WorstCase, width: int = 0) -> str:
    from fairaudit.words import approximate

    said = f"{found.quantity} fairness: ratio R = {approximate(found.lower)}, over every utility of the class"
    return f"{'WORST CASE'.ljust(width)} {said}" if width else f"Worst case of {said}"


def _who(found: WorstCase) -> str:
    """Which groups the worst utility tells apart, in a sentence."""
    from fairaudit.audits.sentences import caution, identifier_text, size_text, sizes
    from fairaudit.words import approximate, place, plain

    if found.lower == 1:
        return "No utility of the class tells any two groups apart."
    law, witness = found.law, found.witness
    where = f" in {plain(place(witness.context))}" if witness.context else ""
    high, low = (approximate(v) for v in witness.expectations)
    (behind,) = sizes(law, [witness])
    first = caution(witness, behind, identifier_text(law, law.columns))
    pair = f"{place(witness.higher)} is favoured over {place(witness.lower)}"
    size = f" {size_text(behind)}" if behind else ""
    return plain(f"{first} {pair}{where}: expected utility {high} against {low}{size}.".lstrip())


def _text(found: WorstCase, written: list[str]) -> str:
    from fairaudit.audits.result import spellings_of
    from fairaudit.reports.text import prepared_text, spelling_text, written_text
    from fairaudit.words import plain

    law = found.law
    spelt = spelling_text(spellings_of(law, law.columns, law.contexts))
    lines = [spelt, ""] if spelt else []
    lines += [_headline(found, 12), "", _who(found)]
    if law.preparation:
        lines += ["", prepared_text(law.preparation)]
    lines += ["", *_table(found), ""]
    lines.append(f"Attained exactly      R = {_exact(found.lower)}")
    lines.append(f"Proved for all        R at most {_exact(found.upper)}")
    gap = "none" if found.gap == 0 else "infinite" if found.gap == inf else f"{found.gap:.2g} (relative)"
    lines.append(f"Gap                   {gap}")
    how = {"closed form": "closed form (T3, T4, T6)", "lp": "linear programs, checked exactly", "conic": "conic program"}
    lines.append(f"Method                {how[found.method]}")
    if law.assumptions:
        lines += ["", "For you to judge", *(f"  - {plain(text)}" for text in law.assumptions)]
    if written:
        lines += ["", written_text(written)]
    lines += [
        "",
        "What this does not say",
        "  Whether anybody's utility is the worst one: it bounds what may be said about this table for any utility of the class.",
    ]
    return "\n".join(lines)


def _exact(value: Any) -> str:
    from fairaudit.certificates.numbers import number
    from fairaudit.words import approximate

    if value == inf:
        return "infinite"
    text = number(value)
    return text if len(text) <= 60 else approximate(value)


def _table(found: WorstCase) -> list[str]:
    """The worst utility: one row per decision, one column per place where it differs."""
    from fairaudit.words import approximate, place, plain

    table = found.utility.on(found.law)
    if table.by_decision:
        rows = [[label, approximate(value)] for label, value in zip(found.law.decisions, _values(table, 0), strict=True)]
        return aligned([["worst utility", "g"], *rows], "  ").splitlines()
    law, witness = found.law, found.witness
    lines = [["worst utility", "decision", "g"]]
    hidden = 0
    for cell, (x, a) in enumerate(zip(law.cell_context.tolist(), law.cell_group.tolist(), strict=True)):
        context, group = law.context_label(x), law.group_label(a)
        if (witness.context is not None and context != witness.context) or group not in (witness.higher, witness.lower):
            continue
        if found.utility_class.blind and group != witness.higher:
            continue
        label = place(context if found.utility_class.blind else {**context, **group})
        for u, value in zip(law.decisions, _values(table, cell), strict=True):
            if len(lines) > SHOWN_ROWS:
                hidden += 1
                continue
            lines.append([label, u, approximate(value)])
    shown = aligned([[plain(text) for text in line] for line in lines], "  ").splitlines()
    if hidden:
        shown.append(f"  … and {hidden} more {noun(hidden, 'value')}, in the certificate")
    if witness.context is not None:
        shown.append("  (elsewhere it is constant, or as the certificate lists it)")
    return shown


def _values(table: Any, cell: int) -> list[Any]:
    from fractions import Fraction

    return [Fraction(v, table.scale) for v in table.row(cell)]


def _entry(found: WorstCase, document: dict[str, Any]) -> dict[str, Any]:
    from fairaudit.certificates.numbers import number

    witness = found.witness
    return {
        "quantity": found.quantity,
        "lower": number(found.lower),
        "upper": number(found.upper),
        "gap": "inf" if found.gap == inf else found.gap,
        "method": found.method,
        "certified": found.certified,
        "witness": {
            "context": witness.context,
            "higher": witness.higher,
            "lower": witness.lower,
            "expectations": witness.expectations,
        },
        "certificate": document,
    }
