"""`fairaudit certify --attest`: the statement that is written beside a certificate, and what it says of the command."""

from __future__ import annotations

import argparse
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from fairaudit.cli.source import option

if TYPE_CHECKING:
    from fairaudit.attestations.making import Counted
    from fairaudit.attestations.sources import Taken
    from fairaudit.attestations.statement import Stated

__all__ = ["Attesting", "add_attestation", "attesting", "refuse_attestation"]

FILES = ("from_monitor", "group_probability", "map", "output", "placebo", "attest")
"""Options whose values are files."""

DEFAULTS = {
    "missing": "error",
    "engine": "auto",
    "format": "text",
    "errors": "refuse",
    "missing_samples": "refuse",
    "same_content": "refuse",
}

SPELLED = {"database_table": "--table", "output": "-o"}


def add_attestation(parser: argparse.ArgumentParser) -> None:
    """Declare the options."""
    group = parser.add_argument_group("who made this, of what (docs/attestation.md)")
    group.add_argument(
        "--attest", metavar="FILE", help="write beside the certificate a statement of where it comes from: sources with their digests, rows"
    )
    group.add_argument("--issuer", metavar="NAME", help="who made the audit; this and what follows is only stated")
    group.add_argument("--contact", metavar="TEXT", help="how to reach them")
    group.add_argument("--title", metavar="TEXT", help="what the audit is called")
    group.add_argument("--system", metavar="NAME", help="what was audited")
    group.add_argument("--system-version", metavar="TEXT", help="in which version")
    group.add_argument("--period", metavar="START/END", help="first and last day of the decisions, such as 2025-01-01/2025-12-31")


@dataclass(frozen=True)
class Attesting:
    """What is known of a statement before the table is read.

    Attributes
    ----------
    path : str
        Where it goes.
    taken : Taken
        The sources.
    options : mapping
        What makes the same table again.
    command : tuple of str
        What was run.
    stated : Stated
        What the issuer says.
    """

    path: str
    taken: Taken
    options: Mapping[str, Any]
    command: tuple[str, ...]
    stated: Stated

    def text(self, result: Counted, names: Sequence[str]) -> str:
        """The statement of what was found and goes to these files; it is refused where a source was changed meanwhile."""
        from fairaudit.attestations.making import statement_of
        from fairaudit.reports.endings import form_of

        own = [name for name in names if form_of(name) == "json"]
        made = statement_of(result, own, self.taken, options=self.options, command=self.command, stated=self.stated)
        return made.text


def refuse_attestation(arguments: argparse.Namespace, why: str) -> None:
    """Refuse a statement where there is none.

    Raises
    ------
    InputError
        If one is asked for.
    """
    from fairaudit.errors import InputError

    if arguments.attest is not None:
        raise InputError(f"--attest does not go with {why}")


def attesting(arguments: argparse.Namespace, *, again: bool = True) -> Attesting | None:
    """Take the digests of what will be read, and check what will be stated of it; nothing, where no statement is asked for.

    Parameters
    ----------
    arguments : Namespace
        What was asked for.
    again : bool
        Whether the table can be made again from what is recorded.

    Raises
    ------
    InputError
        If the options do not go together, or a source or a text has no place in a statement.
    """
    from fairaudit.audits.sections import ATTESTATION_KEYS
    from fairaudit.errors import InputError
    from fairaudit.reports.endings import form_of

    if arguments.attest is None:
        for name in ATTESTATION_KEYS:
            if getattr(arguments, name) is not None:
                raise InputError(f"{option(name)} goes with --attest FILE, which writes who made the certificate and of what")
        return None
    if not any(form_of(name) == "json" for name in arguments.output or []):
        raise InputError("--attest needs -o FILE.json, the certificate that it is about")
    from fairaudit.attestations.making import audit_options, stated_of

    taken = _taken(arguments)  # before anything is read, so that whatever is changed since is noticed
    audit, given = _audit(arguments), {name: getattr(arguments, name) for name in ATTESTATION_KEYS}
    said = {**audit.get("attestation", {}), **{name: text for name, text in given.items() if text is not None}}
    spelled = {name: f"[attestation] {name}" if given[name] is None and name in said else option(name) for name in ATTESTATION_KEYS}
    stated = stated_of(said, spelled)
    command = _command(arguments)
    options = {} if not again else {"audit": audit_options(audit)} if audit else _options(arguments)
    return Attesting(arguments.attest, taken, options, command, stated)


def _taken(arguments: argparse.Namespace) -> Taken:
    """What is read, as it is now: of an example its file, of a monitor nothing that stays as it is."""
    from fairaudit.attestations.sources import Taken, take
    from fairaudit.attestations.statement import Source
    from fairaudit.tables.examples import example

    if arguments.from_monitor is not None:
        return Taken((Source(Path(arguments.from_monitor).name),), None, None)
    source = arguments.table if arguments.example is None else example(arguments.example).path
    beside = [arguments.group_probability] if arguments.group_probability is not None else []
    beside += [arguments.join.rpartition(":")[0]] if arguments.join is not None else []
    return take(source, table=arguments.database_table, query=arguments.query, beside=beside)


def _audit(arguments: argparse.Namespace) -> dict[str, Any]:
    """The sections of an audit file; none of anything else."""
    from fairaudit.files import read_toml
    from fairaudit.tables.sources import is_audit_file

    return read_toml(Path(arguments.table))[0] if is_audit_file(arguments.table) else {}


def _options(arguments: argparse.Namespace) -> dict[str, Any]:
    """What makes the table."""
    from dataclasses import replace

    from fairaudit.attestations.options import options_of
    from fairaudit.cli.source import reading_of
    from fairaudit.measures.limits import DIFFERENCE_LIMITS
    from fairaudit.model.utility import Utility, utility_values

    reading = replace(reading_of(arguments), signed=any(getattr(arguments, name) for name in ("difference", *DIFFERENCE_LIMITS)))
    utility = None if arguments.utility is None else Utility(utility_values(arguments.utility, "--utility"), signed=reading.signed)
    return options_of(reading, utility, positive=arguments.positive)


def _command(arguments: argparse.Namespace) -> tuple[str, ...]:
    """The command as it was understood: no folders, no servers, nothing that looks like a password, nor what is stated elsewhere."""
    from fairaudit.attestations.sources import bare_name, refuse_credentials
    from fairaudit.audits.sections import ATTESTATION_KEYS

    words = ["certify", *map(bare_name, _listed(arguments.table) if arguments.example is None else [])]
    for name, value in vars(arguments).items():
        if name in ("table", "run", "keep", *ATTESTATION_KEYS) or value in (None, False, 0, "", []) or DEFAULTS.get(name) == value:
            continue
        spelled = SPELLED.get(name, option(name))
        if value is True:
            words.append(spelled)
            continue
        for text in map(str, _listed(value)):
            refuse_credentials(text, spelled, query=name == "query")
            folder = text.rpartition("/")[0] if name == "join" else ""
            words += [spelled, bare_name(text) if name in FILES else text.removeprefix(f"{folder}/")]
    return tuple(words)


def _listed(value: Any) -> list[Any]:
    return value if isinstance(value, list) else [] if value is None else [value]
