"""Options that several commands take, and how their values are read."""

from __future__ import annotations

import argparse
import re
from collections.abc import Iterator, Mapping, Sequence
from typing import TYPE_CHECKING, Any, NamedTuple, NoReturn

if TYPE_CHECKING:
    from fairaudit.exact.rationals import Number
    from fairaudit.tables.values import Label, LabelLike

__all__ = ["add_command", "add_limit", "add_limits", "given_limit", "given_limits", "limits_as_options"]


def add_command(commands: Any, name: str, run: Any, summary: str, description: str, epilog: str = "") -> argparse.ArgumentParser:
    """Declare a command: what it is called, what it does, and how its help is laid out.

    Parameters
    ----------
    commands : subparsers
        Where it stands.
    name : str
        What it is called.
    run : callable
        Its work: parsed arguments to an answer, answers, or an exit code.
    summary : str
        A line for the list of commands.
    description, epilog : str
        The help before and after its options, as it is to be shown.
    """
    form = argparse.RawDescriptionHelpFormatter
    parser: argparse.ArgumentParser = commands.add_parser(
        name, help=summary, description=description, epilog=epilog, formatter_class=form, allow_abbrev=False
    )
    parser.set_defaults(run=run)
    return parser


def add_limits(group: Any, *, differences: bool = False) -> None:
    """Declare the limits on the local and the global ratio, and those on differences where they are judged."""
    group.add_argument(
        "--max-local-ratio", action=_Once, metavar="Q", help="limit on R, the worst ratio within a context: 5/4, or 0.8 (least/greatest)"
    )
    group.add_argument("--max-global-ratio", action=_Once, metavar="Q", help="limit on the worst ratio of group means")
    group.add_argument("--max-local-log", action=_Once, metavar="L", help="limit on L, the natural logarithm of R")
    group.add_argument(
        "--max-global-log", action=_Once, metavar="L", help="limit on the natural logarithm of the worst ratio of group means"
    )
    if differences:
        group.add_argument(
            "--max-difference", action=_Once, metavar="D", help="limit on D, the greatest difference of expected utilities within a context"
        )
        group.add_argument("--max-global-difference", action=_Once, metavar="D", help="limit on the greatest difference of group means")
    for quantity in ("local", "global"):
        _refuse(group, f"--max-{quantity}", (f"--max-{quantity}-ratio", f"--max-{quantity}-log"))


def given_limits(arguments: argparse.Namespace) -> dict[str, Any]:
    """The limits that were given, by name."""
    from fairaudit.measures.limits import DIFFERENCE_LIMITS, LIMITS

    named = (*LIMITS, *DIFFERENCE_LIMITS)
    return {name: limit for name in named if (limit := getattr(arguments, name, None)) is not None}


def add_limit(parser: Any, *, required: bool = False, several: bool = False) -> None:
    """Declare the limit of a command that takes a limit on one quantity."""
    group = parser.add_mutually_exclusive_group(required=required)
    more, table = ("[,…]", "; several make a table") if several else ("", "")
    group.add_argument(
        "--max-ratio", action=_Once, metavar=f"Q{more}", help=f"limit on the worst ratio: 5/4, or 0.8 (least/greatest){table}"
    )
    group.add_argument("--max-log", action=_Once, metavar=f"L{more}", help=f"limit on its natural logarithm{table}")
    for name in ("--target", "--target-ratio"):
        _refuse(parser, name, ("--max-ratio", "--max-log"))


def given_limit(arguments: argparse.Namespace) -> list[dict[str, str]]:
    """The limits that were given with `add_limit`, each as the keyword of a function."""
    name = "max_log" if arguments.max_ratio is None else "max_ratio"
    text = getattr(arguments, name)
    return [] if text is None else [{name: part.strip()} for part in text.split(",")]


def limits_as_options(message: str) -> str:
    """Name the options of `add_limit` in a message instead of the keywords.

    Examples
    --------
    >>> limits_as_options("max_ratio: 'x' is not a number")
    "--max-ratio: 'x' is not a number"
    """
    return message.replace("max_ratio", "--max-ratio").replace("max_log", "--max-log")


def _refuse(group: Any, option: str, names: tuple[str, str]) -> None:
    group.add_argument(option, action=_Refused, const=names, nargs="?", dest=argparse.SUPPRESS, help=argparse.SUPPRESS)


class _Once(argparse.Action):
    """An option that does not let a second value take the place of the first."""

    def __call__(self, parser: argparse.ArgumentParser, namespace: argparse.Namespace, value: Any, option: str | None = None) -> None:
        """Keep the value."""
        if getattr(namespace, self.dest) is not None:
            parser.error(f"{option} is given twice; give one limit")
        setattr(namespace, self.dest, value)


class _Refused(argparse.Action):
    """An option that does not tell a ratio from its logarithm."""

    def __call__(self, parser: argparse.ArgumentParser, *given: object) -> NoReturn:
        """Name both that do."""
        from fairaudit.measures.limits import instead

        parser.error(instead(str(given[-1]), self.const))


TOKEN = re.compile(r'[ \t]*(?:"((?:[^"]|"")*)"[ \t]*|((?:"(?:[^"]|"")*"(?=[.\[]))?(?:(?<=\.)"(?:[^"]|"")*"|[^,\r\n])*))(,|\Z)')
"""A name in quotes as in CSV, or one without, which may be a path with names in quotes: ``"last name".first``."""

NUMBER = re.compile(r"\s*[+-]?(\d+(\.\d*)?|\.\d+)([eE][+-]?\d+)?\s*", re.ASCII)


class Roles(NamedTuple):
    """Column names, and the edges of those that are cut into intervals."""

    names: tuple[str, ...]
    edges: dict[str, tuple[str, ...]]


def column_roles(given: Sequence[str] | None) -> Roles:
    """Read column names from repeated options with commas; ``age:18,30`` cuts the column ``age`` at 18 and 30.

    A name with a comma is quoted as in CSV; so is one with a colon before a number that is not to be cut.

    Raises
    ------
    InputError
        If the quotes do not fit.

    Examples
    --------
    >>> column_roles(["sex, age:18,30", '"last, first"'])
    Roles(names=('sex', 'age', 'last, first'), edges={'age': ('18', '30')})
    """
    names: list[str] = []
    edges: dict[str, tuple[str, ...]] = {}
    for text in given or []:
        cut = ""
        for name, quoted in parts(text):
            stem, colon, number = name.rpartition(":")
            if cut and not quoted and NUMBER.fullmatch(name):
                edges[cut] = (*edges[cut], name.strip())
            elif colon and stem and not quoted and NUMBER.fullmatch(number):
                cut = stem
                names.append(stem)
                edges[stem] = (number.strip(),)
            else:
                cut = ""
                names.append(name)
    return Roles(tuple(names), edges)


def parts(text: str) -> Iterator[tuple[str, bool]]:
    """Parts of a list with commas, and whether each was quoted."""
    from fairaudit.errors import InputError, shown

    position = 0
    while text:
        match = TOKEN.match(text, position)
        if match is None or (match.group(1) is None and re.match('"(?!(?:[^"]|"")*"[.[])', match.group(2))):
            raise InputError(
                f"{shown(text)} is not a list of column names; separate them with commas, and quote a name with a comma as in CSV"
            )
        quoted = match.group(1) is not None
        yield match.group(1).replace('""', '"') if quoted else match.group(2), quoted
        position = match.end()
        if not match.group(3):
            return


METHODS = ("hoeffding-kl", "empirical-bernstein", "intersection")

SELECTIONS = ("bonferroni", "half-split")

DEFAULT = "0.95"


def confidence_option(text: Any) -> Any:
    """Read a confidence: a number between 0 and 1 (0.95 if it was not given), or None for 'none'.

    Raises
    ------
    InputError
        If it is neither.
    """
    from fairaudit.errors import InputError, shown
    from fairaudit.inference.levels import confidence_level

    if text == "none":
        return None
    try:
        return confidence_level(DEFAULT if text is None else text)
    except InputError:
        raise InputError(f"--confidence {shown(text)} is not accepted; a number between 0 and 1 such as 0.95 is, or 'none'") from None


def utility_range(text: str | None) -> dict[str, str]:
    """Read --utility-range as declared constants.

    Examples
    --------
    >>> utility_range("0,5")
    {'m': '0', 'gamma': '5'}
    """
    from fairaudit.errors import InputError, shown

    if text is None:
        return {}
    low, comma, high = text.partition(",")
    if not comma or "," in high:
        raise InputError(f"--utility-range {shown(text)} is not of the form LOW,HIGH, such as 0,1")
    return {"m": low.strip(), "gamma": high.strip()}


def unknown_shares(given: list[str] | None) -> Mapping[LabelLike | Label, Sequence[Number]]:
    """Read --unknown-share.

    Examples
    --------
    >>> unknown_shares(["f=0.4,0.6", "*=0,0"])
    {'f': ('0.4', '0.6'), '*': ('0', '0')}
    """
    from fairaudit.errors import InputError, shown

    found: dict[LabelLike | Label, Sequence[Number]] = {}
    for text in given or []:
        label, equals, ends = text.rpartition("=")
        low, comma, high = ends.partition(",")
        if not equals or not comma or "," in high or not label.strip():
            raise InputError(f"--unknown-share {shown(text)} is not of the form GROUP=LOW,HIGH, such as f=0.4,0.6")
        if label.strip() in found:
            raise InputError(f"--unknown-share names {shown(label.strip())} twice; give each group once")
        found[label.strip()] = low.strip(), high.strip()
    return found


def groups_option(text: str) -> int | dict[str, int]:
    """Read ``16`` or ``name=2,age=5``.

    Raises
    ------
    InputError
        If the two forms are mixed, or a number is not one.

    Examples
    --------
    >>> groups_option("16"), groups_option("name=2,age=5")
    (16, {'name': 2, 'age': 5})
    """
    from fairaudit.errors import InputError, shown

    def size(digits: str) -> int:
        if not (digits.isascii() and digits.isdigit() and len(digits) < 6):
            raise InputError(f"--groups {shown(text)}: {shown(digits)} is not a number of values from 2 to 10000")
        return int(digits)

    parts = [part.strip() for part in text.split(",")]
    if len(parts) == 1 and "=" not in text:
        return size(parts[0])
    named: dict[str, int] = {}
    for part in parts:
        name, equals, digits = part.partition("=")
        if not equals or not name.strip():
            raise InputError(f"--groups {shown(text)} mixes forms; give one number, or name=number for every attribute")
        if name.strip() in named:
            raise InputError(f"--groups {shown(text)} names {shown(name.strip())} twice")
        named[name.strip()] = size(digits.strip())
    return named


def column_list(given: list[str] | None) -> tuple[str, ...]:
    """Names from repeated options with commas; a name with a comma is quoted as in CSV.

    Raises
    ------
    InputError
        If the quotes do not fit.

    Examples
    --------
    >>> column_list(["sex, age", '"last, first"'])
    ('sex', 'age', 'last, first')
    """
    return tuple(name for text in given or [] for name, _ in parts(text))
