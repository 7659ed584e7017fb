"""Sections of files that people write (TOML): what is accepted in them, and what is said of the rest."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from fairaudit.exact import InputError, nearest, shown

__all__ = ["check_keys", "read_section"]


def read_section(document: Mapping[str, Any], name: str) -> dict[str, Any]:
    """Find a section of a file; one that is not there is empty.

    Raises
    ------
    InputError
        If the name stands for something else.

    Examples
    --------
    >>> read_section({"targets": {"max_local": "0.2"}}, "targets"), read_section({}, "targets")
    ({'max_local': '0.2'}, {})
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
    >>> check_keys({"max_locl": "0.2"}, ["max_local", "max_global"], "[targets]")
    Traceback (most recent call last):
    fairaudit.exact.InputError: [targets] has the unknown key 'max_locl'; known: 'max_local', 'max_global'; did you mean 'max_local'?
    """
    for key in given:
        if key not in keys:
            raise InputError(f"{where} has the unknown key {shown(key)}; {nearest(key, keys)}")
