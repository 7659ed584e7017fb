"""Options for limits on the worst ratio, the same in every command that takes them."""

from __future__ import annotations

import argparse
from typing import Any, NoReturn

__all__ = ["add_options", "add_single", "as_options", "given", "single"]


def add_options(group: Any) -> None:
    """Declare the limits on the local and the global ratio."""
    group.add_argument(
        "--max-local-ratio", action=_Once, metavar="Q", help="limit on R, the worst ratio within a context: 5/4, or 0.8 (least/greatest)"
    )
    group.add_argument("--max-global-ratio", action=_Once, metavar="Q", help="limit on the worst ratio of group means")
    group.add_argument("--max-local-log", action=_Once, metavar="L", help="limit on L, the natural logarithm of R")
    group.add_argument(
        "--max-global-log", action=_Once, metavar="L", help="limit on the natural logarithm of the worst ratio of group means"
    )
    for quantity in ("local", "global"):
        _refuse(group, f"--max-{quantity}", (f"--max-{quantity}-ratio", f"--max-{quantity}-log"))


def given(arguments: argparse.Namespace) -> dict[str, Any]:
    """The limits that were given, by name."""
    from fairaudit.limits import LIMITS

    return {name: getattr(arguments, name) for name in LIMITS if getattr(arguments, name) is not None}


def add_single(parser: Any, *, required: bool = False, several: bool = False) -> None:
    """Declare the limit of a command that takes a limit on one quantity."""
    group = parser.add_mutually_exclusive_group(required=required)
    more, table = ("[,…]", "; several make a table") if several else ("", "")
    group.add_argument(
        "--max-ratio", action=_Once, metavar=f"Q{more}", help=f"limit on the worst ratio: 5/4, or 0.8 (least/greatest){table}"
    )
    group.add_argument("--max-log", action=_Once, metavar=f"L{more}", help=f"limit on its natural logarithm{table}")
    for name in ("--target", "--target-ratio"):
        _refuse(parser, name, ("--max-ratio", "--max-log"))


def single(arguments: argparse.Namespace) -> list[dict[str, str]]:
    """The limits that were given with `add_single`, each as the keyword of a function."""
    name = "max_log" if arguments.max_ratio is None else "max_ratio"
    text = getattr(arguments, name)
    return [] if text is None else [{name: part.strip()} for part in text.split(",")]


def as_options(message: str) -> str:
    """Name the options of `add_single` in a message instead of the keywords.

    Examples
    --------
    >>> as_options("max_ratio: 'x' is not a number")
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
        from fairaudit.limits import instead

        parser.error(instead(str(given[-1]), self.const))
