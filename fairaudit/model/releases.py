"""How often one memory sees a fresh release of the same true value."""

from __future__ import annotations

from typing import Any

from fairaudit.errors import InputError, shown

MAX_RELEASES = 10_000
"""Releases whose joint law is counted exactly."""


def check_releases(releases: Any, most: int = MAX_RELEASES) -> int:
    """A number of releases, as an int.

    Raises
    ------
    InputError
        If it is not a whole number from 1 to `most`.

    Examples
    --------
    >>> check_releases(20)
    20
    """
    if isinstance(releases, bool) or not isinstance(releases, int) or not 1 <= releases <= most:
        raise InputError(f"the number of releases is {shown(releases)}; a whole number from 1 to {most} is accepted")
    return releases
