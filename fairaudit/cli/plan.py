"""`fairaudit plan`: how many decisions to draw so that a target will be decided, before any money is spent."""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from fractions import Fraction
from functools import partial
from itertools import islice, zip_longest
from typing import TYPE_CHECKING, Any

from fairaudit.cli import CORE
from fairaudit.cli.options import add_command, add_limit, limits_as_options
from fairaudit.cli.output import Answer, add_format

if TYPE_CHECKING:
    from fairaudit.inference.planning import Planning

DESCRIPTION = "Estimate the draws per context and group that would show that a target is kept or exceeded, if guesses are right."
EPILOG = """\
exit codes: 0 a number of draws is expected to decide; 1 no number is; 2 bad input

examples:
  fairaudit plan --guess 0.5,0.5 --max-ratio 0.8 --independent-cells
  fairaudit plan --guess 0.5 --groups 8 --contexts 50 --max-ratio 5/4
  fairaudit plan --guess 0.5,0.45,0.4 --guess 0.2,0.2,0.2 --shares 3,2,1 --max-ratio 3/2 --confidence 0.99 --power 0.9"""

LISTED = 10  # contexts, beyond which a list is no longer read


def add(commands: Any) -> None:
    """Declare the options."""
    parser = add_command(commands, "plan", run, CORE["plan"], DESCRIPTION, EPILOG)
    parser.add_argument(
        "--guess",
        metavar="MEAN,MEAN…",
        action="append",
        required=True,
        help="supposed expected utility of each group; repeat the option for each context",
    )
    parser.add_argument("--groups", metavar="G", type=int, help="with one --guess of one mean: so many groups have it")
    parser.add_argument("--contexts", metavar="X", type=int, help="with one --guess: so many contexts are like it")
    parser.add_argument(
        "--shares",
        metavar="SIZE,SIZE…",
        action="append",
        help="sizes of the groups in proportion to each other; repeat the option for each context (default: all alike)",
    )
    add_limit(parser, required=True)
    parser.add_argument("--confidence", metavar="C", default="0.95", help="confidence of the verdict (default 0.95)")
    parser.add_argument("--power", metavar="P", default="0.8", help="how likely the draws should suffice (default 0.8)")
    parser.add_argument(
        "--independent-cells", action="store_true", help="certify will be told that cells are independent: fewer are needed"
    )
    parser.add_argument("--select", choices=("bonferroni", "half-split"), default="bonferroni", help="as certify will be told")
    parser.add_argument("--utility-range", metavar="LOW,HIGH", default="0,1", help="least and greatest utility (default 0,1)")
    parser.add_argument("--many-valued", action="store_true", help="the utility takes values between the two")
    parser.add_argument("--units", action="store_true", help="count sampling units, each with several rows in its cell (certify --unit)")
    add_format(parser)


def run(arguments: argparse.Namespace) -> Answer:
    """Do the work."""
    from fairaudit.cli.options import utility_range
    from fairaudit.errors import InputError
    from fairaudit.exact.rationals import exact, rational
    from fairaudit.inference.planning import plan
    from fairaudit.measures.limits import limit_readings, limit_text, one_limit

    rows = _rows(arguments)
    ends = utility_range(arguments.utility_range)
    top, bottom = rational(arguments.power)
    try:
        unit, limit = one_limit(arguments.max_ratio, arguments.max_log)
    except InputError as error:
        raise InputError(limits_as_options(str(error))) from None
    shares = [_listed(text) for text in arguments.shares or ()]
    planned = partial(
        plan,
        rows,
        arguments.confidence,
        max_ratio=arguments.max_ratio,
        max_log=arguments.max_log,
        power=top / bottom,
        limits=(ends["m"], ends["gamma"]),
        binary=not arguments.many_valued,
        shares=(shares if len(shares) > 1 else shares[0]) if shares else None,
        units=arguments.units,
        select=arguments.select,
    )
    found = planned(independent=arguments.independent_cells)
    sizes = [len(row) for row in rows]

    def text() -> str:
        lines = [f"Limit: {limit_text('local', unit, limit)}", found.sentence]
        if found.draws is not None:
            what = "units" if arguments.units else "draws"
            lines += _told(found, sizes, what)
            fewer = None if arguments.independent_cells else planned(independent=True).total
            if fewer is not None and fewer < sum(found.draws):
                lines.append(
                    f"If cells are independent of each other, and certify is told so (--independent-cells): {fewer} {what} in all."
                )
        return "\n".join(lines)

    return Answer(
        "plan",
        sentence=found.sentence,
        result=lambda: {
            "unit": unit,
            "limit": limit,
            "readings": limit_readings(unit, limit),
            "confidence": exact(arguments.confidence),
            "power": Fraction(top, bottom),
            "draws": found.draws,
            "total": found.total,
            "decides": found.decides,
            "expected_power": None if found.power is None else Fraction(round(1000 * found.power), 1000),
            "method": found.method,
            "by_context": None if found.draws is None else [sum(row) for row in _by_context(found.draws, sizes)],
            "by_group": None if found.draws is None else _by_group(found.draws, sizes),
            "needed_by": [dict(zip(("context", "group"), at, strict=True)) for at in _places(found.cells, sizes)],
            "fewest": found.fewest,
        },
        text=text,
        code=0 if found.draws is not None else 1,
    )


def _listed(text: str) -> list[str]:
    return [part.strip() for part in text.split(",")]


def _rows(arguments: argparse.Namespace) -> list[list[str]]:
    """The guesses of each context."""
    from fairaudit.errors import InputError, shown

    rows = [_listed(text) for text in arguments.guess]
    for name, number, least in (("--groups", arguments.groups, 2), ("--contexts", arguments.contexts, 1)):
        if number is not None and (number < least or len(rows) > 1):
            raise InputError(f"{name} {number} is not accepted; give {least} or more, and --guess once")
    if arguments.groups is not None:
        if len(rows[0]) > 1:
            raise InputError(f"--groups goes with one guess for all groups, not with {shown(arguments.guess[0])}")
        rows = [rows[0] * arguments.groups]
    for row in rows:
        if len(row) < 2:
            raise InputError(
                f"--guess {shown(row[0])} names one group; at least two are compared, such as --guess 0.5,0.45 or --guess 0.5 --groups 2"
            )
    return rows * (arguments.contexts or 1)


def _by_context(draws: Sequence[int], sizes: Sequence[int]) -> list[list[int]]:
    """The draws of the groups of each context."""
    rest = iter(draws)
    return [list(islice(rest, size)) for size in sizes]


def _by_group(draws: Sequence[int], sizes: Sequence[int]) -> list[int]:
    """The draws of each group in all contexts together, by its place among the guesses."""
    return [sum(column) for column in zip_longest(*_by_context(draws, sizes), fillvalue=0)]


def _places(cells: Sequence[int], sizes: Sequence[int]) -> list[tuple[int, int]]:
    """The context and the group of cells, counted from 1."""
    every = [(x, a) for x, size in enumerate(sizes, 1) for a in range(1, size + 1)]
    return [every[i] for i in cells]


def _told(found: Planning, sizes: Sequence[int], what: str) -> list[str]:
    """What else is said of the draws of an audit: their sums, who needs them, and where fewer will do."""
    draws = found.draws or ()
    lines = [f"In all cells together: {sum(draws)} {what}."]
    contexts, groups = [sum(row) for row in _by_context(draws, sizes)], _by_group(draws, sizes)
    if len(sizes) > 1:
        lines.append(f"Of each context: {_numbers(contexts)}. Of each group: {_numbers(groups)}.")
    elif len({*draws}) > 1:
        lines.append(f"Of each group: {_numbers(draws)}.")
    if 0 < len(found.cells) < len(draws):
        needed: dict[int, list[int]] = {}
        for x, a in _places(found.cells, sizes):
            needed.setdefault(x, []).append(a)
        named = [
            (f"context {x}, " if len(sizes) > 1 else "") + f"groups {' and '.join(map(str, members))}" for x, members in needed.items()
        ]
        lines.append(f"The verdict hangs on {'; '.join(_few(named))}.")
    if found.fewest is not None:
        listed = [f"{max(row)}" for row in _by_context(found.fewest, sizes)]
        lines.append(f"About as good: in contexts 1, 2, … up to {', '.join(_few(listed))} {what} per cell, {sum(found.fewest)} in all.")
    return lines


def _few(named: list[str]) -> list[str]:
    return named if len(named) <= LISTED else [*named[:LISTED], f"and {len(named) - LISTED} more"]


def _numbers(listed: Sequence[int]) -> str:
    return str(listed[0]) if len({*listed}) == 1 else ", ".join(_few([str(n) for n in listed]))
