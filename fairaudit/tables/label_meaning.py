"""Labels of decisions that look as if nothing has been decided, such as pending, withdrawn or not applicable, in some languages."""

from __future__ import annotations

import os
import re
import unicodedata
from collections.abc import Iterable
from functools import cache
from pathlib import Path

from fairaudit.errors import InputError
from fairaudit.tables.sources import source_name

__all__ = ["looking_undecided", "read_lexicon"]

OWN = Path(__file__).with_name("data") / "undecided.txt"

LARGEST = 1_000_000  # bytes of a lexicon


def looking_undecided(labels: Iterable[str], more: Iterable[str] = ()) -> tuple[str, ...]:
    """Find the labels that look as if nothing has been decided: whole labels of the lexicon, however they are spelt.

    Parameters
    ----------
    labels : iterable of str
        Labels of decisions.
    more : iterable of str
        What is in the lexicon besides.

    Examples
    --------
    >>> looking_undecided(["granted", "PENDING", "en_attente", "open-ended", "spending"]), looking_undecided(["parked"], ["Parked"])
    (('PENDING', 'en_attente'), ('parked',))
    """
    known = _own() | {*map(_bare, more)}
    return tuple(label for label in labels if _bare(label) in known)


def read_lexicon(path: str | os.PathLike[str]) -> tuple[str, ...]:
    """Read labels from a file that has one a line; a line that begins with # is a remark.

    Parameters
    ----------
    path : path
        The file, in UTF-8.

    Raises
    ------
    InputError
        If it cannot be read, or has no label.
    """
    name = source_name(path)
    try:
        with Path(path).open("rb") as file:
            held = file.read(LARGEST + 1)
        lines = held.decode("utf-8-sig").splitlines()
    except OSError as error:
        raise InputError(f"the lexicon {name} cannot be read: {error.strerror or error}") from None
    except UnicodeDecodeError:
        raise InputError(f"the lexicon {name} is not a text in UTF-8; it has one label a line") from None
    if len(held) > LARGEST:
        raise InputError(f"the lexicon {name} has more than {LARGEST:,} bytes; it has one label a line")
    labels = tuple(text for line in lines if (text := line.strip()) and not text.startswith("#"))
    if not labels:
        raise InputError(f"the lexicon {name} has no label; it has one label a line, such as pending")
    return labels


@cache
def _own() -> frozenset[str]:
    """The lexicon of the package."""
    return frozenset(map(_bare, read_lexicon(OWN)))


def _bare(label: str) -> str:
    """A label without case, accents, and what stands between its words."""
    apart = unicodedata.normalize("NFKD", label.casefold().replace("ł", "l"))
    letters = "".join(sign for sign in apart if not unicodedata.combining(sign))
    return re.sub(r"[\s_-]+", " ", letters).strip() or label.strip()
