"""Sections of files that people write (TOML): what is accepted in them, and what is said of the rest."""

from __future__ import annotations

import tomllib
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any

from fairaudit.errors import InputError, nearest, shown
from fairaudit.measures.limits import DIFFERENCE_LIMITS, LIMITS, refuse_bare

__all__ = ["ATTESTATION_KEYS", "check_keys", "check_targets", "files_in", "read_section", "read_toml", "with_files"]

ATTESTATION_KEYS = ("issuer", "contact", "title", "system", "system_version", "period")
"""What an issuer says: in the section ``[attestation]``, as options, and to Python."""

FILES = dict.fromkeys(("law", "policy", "utility", "population"), ("table", "map"))
"""Sections of an audit file that name files, and under which keys; a filter of the kind ``table`` does so, too."""


def read_toml(path: Path) -> tuple[dict[str, Any], bytes]:
    """Read a file, with its bytes; numbers with a point stay the text that they are.

    Raises
    ------
    InputError
        If it cannot be read, or is not TOML.
    """
    try:
        data = path.read_bytes()
        return tomllib.loads(data.decode("utf-8"), parse_float=str), data
    except (FileNotFoundError, IsADirectoryError):
        raise InputError(f"{path}: there is no such file") from None
    except OSError as error:
        raise InputError(f"{path}: the file cannot be read: {error.strerror}") from None
    except (UnicodeDecodeError, tomllib.TOMLDecodeError, RecursionError) as error:
        raise InputError(f"{path}: this is not a TOML file: {error}") from None


def read_section(document: Mapping[str, Any], name: str) -> dict[str, Any]:
    """Find a section of a file; one that is not there is empty.

    Raises
    ------
    InputError
        If the name stands for something else.

    Examples
    --------
    >>> read_section({"targets": {"max_local_log": "0.2"}}, "targets"), read_section({}, "targets")
    ({'max_local_log': '0.2'}, {})
    """
    found = document.get(name, {})
    if not isinstance(found, dict):
        raise InputError(f"{name} must be a section [{name}], not {shown(found)}")
    return found


def check_keys(given: Mapping[str, Any], keys: Sequence[str], where: str) -> None:
    """Refuse keys that are not known.

    Raises
    ------
    InputError
        If there is one; the message names the nearest that is known.

    Examples
    --------
    >>> check_keys({"gama": "1"}, ["gamma", "tau"], "[utility]")
    Traceback (most recent call last):
    fairaudit.errors.InputError: [utility] has the unknown key 'gama'; known: 'gamma', 'tau'; did you mean 'gamma'?
    """
    for key in given:
        if key not in keys:
            raise InputError(f"{where} has the unknown key {shown(key)}; {nearest(key, keys)}")


def check_targets(given: Mapping[str, Any], *, differences: bool = False) -> None:
    """Refuse keys of the section [targets] that are no limits; those on differences where nothing could judge them.

    Raises
    ------
    InputError
        If there is one; where it does not tell a ratio from its logarithm, the message names both that do.
    """
    refuse_bare(given, where="[targets] ")
    check_keys(given, (*LIMITS, *(DIFFERENCE_LIMITS if differences else ())), "[targets]")


def with_files(document: Mapping[str, Any], named: Callable[[str], str]) -> dict[str, Any]:
    """The sections of an audit file with something else in the place of each name of a file.

    Parameters
    ----------
    document : mapping
        The sections.
    named : callable
        Gives what stands for a name.

    Examples
    --------
    >>> with_files({"law": {"table": "log.csv", "decision": "hired"}, "filter": {"group": {"kind": "table", "table": "f.csv"}}}, str.upper)
    {'law': {'table': 'LOG.CSV', 'decision': 'hired'}, 'filter': {'group': {'kind': 'table', 'table': 'F.CSV'}}}
    """

    def placed(section: Any, keys: Sequence[str]) -> Any:
        if not isinstance(section, dict):
            return section
        return {name: named(entry) if name in keys and isinstance(entry, str) else entry for name, entry in section.items()}

    def filtered(section: Any) -> Any:
        if not isinstance(section, dict):
            return section
        return placed({name: filtered(entry) for name, entry in section.items()}, ("table",) if section.get("kind") == "table" else ())

    return {name: filtered(entry) if name == "filter" else placed(entry, FILES.get(name, ())) for name, entry in document.items()}


def files_in(document: Mapping[str, Any]) -> list[str]:
    """The names of files in the sections of an audit file, in their order."""
    found: list[str] = []

    def noted(name: str) -> str:
        found.append(name)
        return name

    with_files(document, noted)
    return found
