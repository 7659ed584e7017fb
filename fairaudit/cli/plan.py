"""`fairaudit plan`: how many decisions to draw so that a target will be decided, before any money is spent."""

from __future__ import annotations

import argparse
from fractions import Fraction
from typing import Any

from fairaudit.cli.options import add_command, add_limit, limits_as_options
from fairaudit.cli.output import Answer, add_format

DESCRIPTION = "Estimate the draws per context and group that would show that a target is kept or exceeded, if guesses are right."
EPILOG = """\
exit codes: 0 a number of draws is expected to decide; 1 no number is; 2 bad input

examples:
  fairaudit plan --guess 0.5,0.5 --max-ratio 0.8
  fairaudit plan --guess 0.5,0.45,0.4 --guess 0.2,0.2,0.2 --max-ratio 5/4 --confidence 0.99 --power 0.9"""


def add(commands: Any) -> None:
    """Declare the options."""
    parser = add_command(commands, "plan", run, "estimate how many decisions are needed to certify a target", DESCRIPTION, EPILOG)
    parser.add_argument(
        "--guess",
        metavar="MEAN,MEAN…",
        action="append",
        required=True,
        help="supposed expected utility of each group; repeat the option for each context",
    )
    add_limit(parser, required=True)
    parser.add_argument("--confidence", metavar="C", default="0.95", help="confidence of the verdict (default 0.95)")
    parser.add_argument("--power", metavar="P", default="0.8", help="how likely the draws should roughly suffice (default 0.8)")
    parser.add_argument("--utility-range", metavar="LOW,HIGH", default="0,1", help="least and greatest utility (default 0,1)")
    parser.add_argument("--many-valued", action="store_true", help="the utility takes values between the two")
    add_format(parser)


def run(arguments: argparse.Namespace) -> Answer:
    """Do the work."""
    from fairaudit.cli.options import utility_range
    from fairaudit.errors import InputError, shown
    from fairaudit.exact.rationals import rational
    from fairaudit.inference.planning import plan
    from fairaudit.measures.limits import limit_readings, limit_text, one_limit

    rows = [[guess.strip() for guess in text.split(",")] for text in arguments.guess]
    for row in rows:
        if len(row) < 2:
            raise InputError(f"--guess {shown(row[0])} names one group; at least two are compared, such as --guess 0.5,0.45")
    ends = utility_range(arguments.utility_range)
    top, bottom = rational(arguments.power)
    try:
        unit, limit = one_limit(arguments.max_ratio, arguments.max_log)
    except InputError as error:
        raise InputError(limits_as_options(str(error))) from None
    found = plan(
        rows,
        arguments.confidence,
        max_ratio=arguments.max_ratio,
        max_log=arguments.max_log,
        power=top / bottom,
        limits=(ends["m"], ends["gamma"]),
        binary=not arguments.many_valued,
    )
    lines = [f"Limit: {limit_text('local', unit, limit)}", found.sentence]
    together = None if found.draws is None else sum(found.draws)
    lines += [] if together is None else [f"In all cells together: {together} draws."]
    return Answer(
        "plan",
        sentence=found.sentence,
        result=lambda: {
            "unit": unit,
            "limit": limit,
            "readings": limit_readings(unit, limit),
            "confidence": Fraction(*rational(arguments.confidence)),
            "power": Fraction(top, bottom),
            "draws": found.draws,
            "total": together,
            "decides": found.decides,
        },
        text=lambda: "\n".join(lines),
        code=0 if together is not None else 1,
    )
