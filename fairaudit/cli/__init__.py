"""The command line. Each command is a module with `add` (its options) and `run` (its work, which imports what it needs).

Only the command that is named is loaded; what other distributions supply is looked for where none of the core has that name.
`run` gives an answer, several that come one after the other, or, where it has written what there was to say, an exit code.
"""
# PYTHON_ARGCOMPLETE_OK

from __future__ import annotations

import argparse
import os
import re
import sys
from collections.abc import Iterator, Mapping, Sequence
from functools import cache
from importlib import import_module
from typing import TYPE_CHECKING, Any, NoReturn

from fairaudit import __version__
from fairaudit.exact.collecting import uncollected

if TYPE_CHECKING:
    from importlib.metadata import EntryPoint

__all__ = ["main", "plugins"]

EXIT_BAD_INPUT = 2
ENTRY_POINT = "fairaudit.commands"
CORE = {
    "certify": "audit a table of decisions and write a certificate",
    "inspect": "list the columns of a table and suggest a certify command",
    "tally": "count a part of a log once, to be certified with others",
    "verify": "check a certificate",
    "attest": "sign the attestation of a certificate, or make keys",
    "privacy": "measure the privacy of a filter",
    "calibrate": "find the privacy filter for a fairness target",
    "design": "find the best privacy filter for a fairness target",
    "worst-case": "find the utility for which a table looks worst",
    "subgroups": "find the subgroups that fare most unequally, and prove that none is worse",
    "plan": "estimate how many decisions are needed to certify a target",
    "report": "write a certificate as a page for people",
    "publish": "write what a rule asks to be published",
    "compare": "compare two certificates, or two logs",
    "monitor": "watch a stream of decisions",
}
"""What each command does; it is the module of its name, and loaded when it is asked for."""


class _Parser(argparse.ArgumentParser):
    """A parser whose errors are one sentence."""

    def error(self, message: str) -> NoReturn:
        """Print the message and where help is, and exit with code 2."""
        from fairaudit.errors import without_passwords
        from fairaudit.words import plain

        self.exit(EXIT_BAD_INPUT, f"{self.prog}: {plain(without_passwords(' '.join(message.split())))}; see {self.prog} --help\n")


def _read(parser: argparse.ArgumentParser, commands: Mapping[str, argparse.ArgumentParser], given: Sequence[str]) -> argparse.Namespace:
    """Read the arguments; where a command or an option is not known, the one that was probably meant is named."""
    if given and not given[0].startswith("-") and given[0] not in commands:
        from fairaudit.errors import nearest

        parser.error(f"there is no command {given[0]!r}; {nearest(given[0], commands)}")
    arguments, unknown = parser.parse_known_args(given)
    if unknown:
        command = commands.get(given[0], parser)
        command.error(f"unrecognized arguments: {' '.join(unknown)}{_meant(unknown, command)}")
    return arguments


def _meant(unknown: Sequence[str], parser: argparse.ArgumentParser) -> str:
    """Name the option that was probably meant by the first unknown one."""
    from difflib import get_close_matches

    word = unknown[0].partition("=")[0]
    if not word.startswith("--"):
        return ""
    known = [name for action in parser._actions if action.help != argparse.SUPPRESS for name in action.option_strings]
    begun = [name for name in known if name.startswith(word) and len(word) > 4]
    close = begun[:1] or get_close_matches(word, known, n=1, cutoff=0.7)
    return f"; did you mean {close[0]}?" if close else ""


def plugins(group: str) -> Iterator[Any]:
    """Modules with `add` and `run`, like those here, that other distributions supply by entry points. A broken one stops no other."""
    for entry in _entry_points():
        if entry.group != group:
            continue
        try:
            yield entry.load()
        except Exception as error:
            print(f"fairaudit: the plug-in {entry.name} cannot be loaded: {error}", file=sys.stderr)


@cache
def _entry_points() -> list[EntryPoint]:
    """Entry points that name this package, by name; to parse those of all other distributions would take longer than the rest."""
    from importlib.metadata import distributions

    ours = [each for each in distributions() if "[fairaudit." in (each.read_text("entry_points.txt") or "")]
    found = {(entry.group, entry.name): entry for each in reversed(ours) for entry in each.entry_points}  # the first on the path counts
    return [found[key] for key in sorted(found)]


def _add(commands: Any, given: Sequence[str], *, every: bool) -> None:
    """Declare the command that is named, or all: those on the line, or every one, with their options, the others by what they do."""
    alone = not every and given[:1] and given[0] in CORE
    for name in given[:1] if alone else CORE:
        if every or name in given:
            import_module(f"fairaudit.cli.{name.replace('-', '_')}").add(commands)
        else:
            commands.add_parser(name, help=CORE[name])
    for module in () if alone else plugins(ENTRY_POINT):
        module.add(commands)


def with_negative_values(given: Sequence[str]) -> list[str]:
    """Tie values that begin with a minus and a digit to their option: argparse would take ``-2,2`` for an option.

    Examples
    --------
    >>> with_negative_values(["certify", "--utility-range", "-2,2", "-o", "c.json"])
    ['certify', '--utility-range=-2,2', '-o', 'c.json']
    """
    tied: list[str] = []
    for text in given:
        if re.match(r"-\.?[0-9]", text) and tied and re.fullmatch("--[a-z-]+", tied[-1]):
            tied[-1] += f"={text}"
        else:
            tied.append(text)
    return tied


def main(argv: Sequence[str] | None = None) -> int:
    """Run the command line.

    Parameters
    ----------
    argv : sequence of str, optional
        The arguments; those of the process by default.

    Returns
    -------
    int
        0 within the targets, or no target; 1 a target is exceeded or a claim is false; 2 bad input; 3 inconclusive.
    """
    for stream in (sys.stdout, sys.stderr):
        reconfigure = getattr(stream, "reconfigure", None)
        if reconfigure:
            reconfigure(errors="backslashreplace")
    parser = _Parser(
        prog="fairaudit",
        description="Exact, certified fairness audits of decision tables.",
        epilog="Try: fairaudit certify --example ucb-admissions. Exit codes of all commands are in one table: docs/json.md#exit-codes",
        allow_abbrev=False,
    )
    parser.add_argument("--version", action="version", version=f"fairaudit {__version__}")
    commands = parser.add_subparsers(prog=parser.prog, metavar="COMMAND", required=True, parser_class=_Parser)
    given = with_negative_values(sys.argv[1:] if argv is None else argv)
    if given[:1] and given[0] in CORE:
        os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")  # numpy's library starts others when it is loaded, and they wait by spinning
    completing = "_ARGCOMPLETE" in os.environ and argv is None
    if given[:1] != ["--version"]:
        with uncollected():
            _add(commands, given, every=completing)
    if completing:
        from fairaudit.cli.completion import complete

        complete(parser, commands.choices)
    arguments = _read(parser, commands.choices, given)
    from fairaudit.cli.output import silence, tell

    try:
        code = tell(arguments.run(arguments), getattr(arguments, "format", "text"))
        if sys.stdout is not None:  # None when the process was started without one
            sys.stdout.flush()
        return code
    except BrokenPipeError:
        silence()  # the reader of our output went away (a closed pager, say); there is nobody to tell
        return 0
    except OSError as error:
        silence()
        print(f"fairaudit: the output cannot be written: {error.strerror or error}", file=sys.stderr)
        return EXIT_BAD_INPUT
    except KeyboardInterrupt:
        print("fairaudit: interrupted", file=sys.stderr)
        return 130
    except MemoryError:
        print("fairaudit: the table does not fit into memory", file=sys.stderr)
        return EXIT_BAD_INPUT
    except Exception as error:
        from fairaudit.errors import FairauditError

        if not isinstance(error, FairauditError):
            raise
        from fairaudit.words import plain

        print(f"fairaudit: {plain(str(error))}", file=sys.stderr)
        return EXIT_BAD_INPUT
