"""`compare` of two logs in the place of two certificates: their columns, and rates that were compared in the units of both."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import TYPE_CHECKING, Any

from fairaudit.cli.options import column_list, confidence_option, utility_range
from fairaudit.cli.output import aligned
from fairaudit.cli.source import (
    add_label_options,
    add_number_form,
    add_samples,
    add_score,
    add_source,
    fill_recipe,
    option,
    progress,
    reading_of,
)

if TYPE_CHECKING:
    from fairaudit.audits.two_logs import ComparedLogs
    from fairaudit.inference.paired_rates import PairedRate

__all__ = ["COLUMNS_OF_LOGS", "add_logs", "are_logs", "compared_logs", "is_certificate", "rates_entry", "rates_text"]

MAKE_LOGS = ("decision", "score", "group", "utility", "utility_column", "recipe")

COLUMNS_OF_LOGS = (
    "two logs need their columns: --decision, --group and --utility (or --score, or --utility-column), which `fairaudit inspect` proposes"
)


def add_logs(parser: argparse.ArgumentParser) -> None:
    """Declare the options of two logs."""
    columns = parser.add_argument_group("two logs in the place of two certificates: their columns, the same in both")
    columns.add_argument("--decision", metavar="COL", help="what was decided")
    add_score(columns)
    add_number_form(columns)
    columns.add_argument("--group", metavar="COL", action="append", help="sensitive attribute; several form intersections")
    columns.add_argument("--context", metavar="COL", action="append", help="what may legitimately matter")
    columns.add_argument("--count", metavar="COL", help="how often the row occurred")
    worth = columns.add_mutually_exclusive_group()
    worth.add_argument("--utility", metavar="SPEC", help="decision[=number],…; decisions that are not listed are worth 0")
    worth.add_argument("--utility-column", metavar="COL", help="column with the utility of each row; --decision may then be left out")
    columns.add_argument(
        "--utility-range", metavar="LOW,HIGH", help="with --utility-column: least and greatest utility of anything that could be drawn"
    )
    columns.add_argument(
        "--unit",
        metavar="COL",
        action="append",
        help="rows with the same label are one draw; where both logs have it, it is compared with itself",
    )
    columns.add_argument(
        "--missing-units",
        choices=("worst", "drop"),
        help="units that are not in all groups, or not in both logs, are missing by design: drop",
    )
    columns.add_argument(
        "--confidence", metavar="C", help="at which it is said whether the second is less fair (0.95); 'none' compares the logs alone"
    )
    columns.add_argument(
        "--undecided",
        metavar="LABEL",
        action="append",
        help="decisions that may have meant anything; answers that decide nothing are among them",
    )
    columns.add_argument("--independent-cells", action="store_true", help="decisions in different cells of a log were drawn independently")
    add_label_options(columns)
    add_source(columns)
    add_samples(parser)
    parser.set_defaults(probability=None, weight=None)


def is_certificate(path: str) -> bool:
    """Whether a file looks like a certificate or its page, or is not there, and so hardly a log that was to be compared."""
    try:
        with Path(path).open("rb") as file:
            start = file.read(4096).lstrip()
    except (OSError, ValueError):
        return True
    return start.startswith(b"<") or b"fairaudit-" in start or not start


def are_logs(arguments: argparse.Namespace) -> bool:
    """Whether columns were named, so that logs are compared.

    Raises
    ------
    InputError
        If only options were given that go with logs, and no columns.
    """
    from fairaudit.errors import InputError

    if any(getattr(arguments, name) for name in MAKE_LOGS):
        return True
    alone = argparse.ArgumentParser(add_help=False)
    add_logs(alone)
    for name, default in vars(alone.parse_args([])).items():
        if getattr(arguments, name) != default:
            said = option(name.removeprefix("database_"))
            raise InputError(f"{said} goes with two logs, whose columns are named with --decision, --group and --utility")
    return False


def compared_logs(arguments: argparse.Namespace) -> ComparedLogs:
    """Read both logs and compare them.

    Raises
    ------
    InputError
        If one cannot be read, or something is missing.
    """
    from fairaudit.audits.two_logs import compare_logs
    from fairaudit.errors import InputError
    from fairaudit.model.utility import Utility, utility_values
    from fairaudit.tables.scores import ABOVE
    from fairaudit.verified.comparison import read_margin

    fill_recipe(arguments)
    if (arguments.score or arguments.above) and arguments.utility is None and arguments.utility_column is None:
        arguments.utility = ABOVE
    if arguments.utility is None and arguments.utility_column is None:
        raise InputError("no utility was given; use --utility, such as --utility yes=1,maybe=0.5, or --utility-column COL")
    confidence = confidence_option(arguments.confidence)
    if arguments.utility_range is not None and arguments.utility_column is None:
        raise InputError("--utility-range goes with --utility-column; --utility names the least and the greatest itself")
    if arguments.utility_column is not None and arguments.utility_range is None and confidence is not None:
        raise InputError(
            "--utility-column needs --utility-range LOW,HIGH, without which nothing is known of what the logs were drawn from; "
            "--confidence none compares the logs alone"
        )
    declared = utility_range(arguments.utility_range)
    utility = None if arguments.utility is None else Utility(utility_values(arguments.utility, "--utility"))
    options: dict[str, Any] = {
        "declared": declared,
        "independent": arguments.independent_cells,
        "missing_units": arguments.missing_units or "worst",
    }
    with progress() as told:
        return compare_logs(
            arguments.old,
            arguments.new,
            reading_of(arguments),
            utility,
            confidence=confidence,
            margin=read_margin(arguments.margin),
            options=options,
            undecided=column_list(arguments.undecided),
            report=told,
        )


def rates_text(found: ComparedLogs) -> str:
    """How rates changed in the units of both logs, or why that is not said; and what all of it rests on."""
    from fairaudit.words import percent, plain

    if found.rates:
        rows = [("", "units", "old", "new", "new/old", "new - old"), *map(_row, found.rates)]
        sure = "" if found.confidence is None else f"all ends of a column together at {percent(found.confidence)}"
        text = f"Each group in the units of both logs ({sure})\n{aligned(rows, '  ')}"
    else:
        text = f"Rates were not compared unit by unit: {plain(found.unpaired)}"
    assumed = dict.fromkeys(sentence for entry in found.found.fairness for sentence in entry.assumptions)
    listed = "\n".join(f"  - {plain(sentence)}" for sentence in assumed)
    return f"{text}\n\nAssumed, for you to judge\n{listed}" if listed else text


def _row(rate: PairedRate) -> tuple[str, ...]:
    from fairaudit.reports.words import clip
    from fairaudit.words import approximate

    name = clip(", ".join((*rate.context, *rate.group)))
    ratio, difference = (f"{approximate(low, 'down')} to {approximate(high, 'up')}" for low, high in (rate.ratio, rate.difference))
    return name, f"{rate.units:,}", approximate(rate.old), approximate(rate.new), ratio, difference


def rates_entry(found: ComparedLogs) -> dict[str, Any]:
    """The same for programs."""
    from fairaudit.certificates.numbers import number

    first = found.results[0].law.columns
    return {
        "confidence": None if found.confidence is None else number(found.confidence),
        "unpaired": found.unpaired,
        "rates": [
            {
                "context": dict(zip(first.context, rate.context, strict=True)),
                "group": dict(zip(first.group, rate.group, strict=True)),
                "units": rate.units,
                "old": number(rate.old),
                "new": number(rate.new),
                "ratio": [number(end) for end in rate.ratio],
                "difference": [number(end) for end in rate.difference],
            }
            for rate in found.rates
        ],
    }
