"""What is wrong with an input, in one sentence: what, where, and what would be accepted."""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from decimal import Decimal

__all__ = [
    "FairauditError",
    "FalseCertificate",
    "Infeasible",
    "InputError",
    "ManyRowsError",
    "RowsLost",
    "TableNeeded",
    "kind_of",
    "nearest",
    "shown",
    "without_passwords",
]

IN_URL = r"(?i)(?<![a-z0-9+.-])([a-z][a-z0-9+.-]{0,30}:/*|(?<!/)//+)([^/@:\s]{0,200}):(?:\S{0,300}@|[^/@\n]{0,300}@)"

ALONE_IN_URL = r"(?i)(?<![a-z0-9])((?:http|ftp)s?:/+)[^/@:\s]{1,300}@"

LONGEST = 1000
"""How many characters beyond those that are shown are looked at, since a password is known by what follows it."""

NAMES = (
    r"password|passwd|passphrase|passwort|kennwort|pwd|secret|token|(?:access|account|api|private|shared)_?(?:access_?)?key|"
    r"(?<=[?&;])(?:pass|sig)"
)

BESIDE_NAME = rf"(?i)((?:{NAMES})[\"'\]]?\s*(?:=>?|(?<=[\"']):|\s(?=['\"]))\s*)('[^']*'?|\"[^\"]*\"?|[^\s&;,'\"]+)"


class FairauditError(Exception):
    """What fairaudit raises on purpose; the command prints its message, one sentence, and exits with code 2.

    Examples
    --------
    >>> issubclass(InputError, FairauditError), issubclass(InputError, ValueError)
    (True, True)
    """

    def __init__(self, *words: object) -> None:
        super().__init__(*(without_passwords(word) if isinstance(word, str) else word for word in words))


class InputError(FairauditError, ValueError):
    """Input that cannot be audited; the message is one sentence: what, where, and what would be accepted.

    Examples
    --------
    >>> try:
    ...     raise InputError("there is no column 'sexx'; known: 'sex'")
    ... except FairauditError as error:
    ...     print(error)
    there is no column 'sexx'; known: 'sex'
    """


class Infeasible(InputError):  # noqa: N818
    """No filter, or no utility, meets everything that was asked for; the message says what stands in the way.

    Examples
    --------
    >>> from fairaudit.filters.calibration import calibrate
    >>> try:
    ...     calibrate(max_ratio="5/4", groups=2, lipschitz=1).require()
    ... except Infeasible as error:
    ...     print("no filter")
    no filter
    """


class ManyRowsError(InputError):
    """A log has more different rows than were asked for; `certify_in_parts` and `audit` read such logs some contexts at a time.

    Examples
    --------
    >>> issubclass(ManyRowsError, InputError)
    True
    """


class FalseCertificate(InputError):  # noqa: N818
    """A statement of a certificate is false, so that nothing is made of it; the message names the first.

    Examples
    --------
    >>> issubclass(FalseCertificate, InputError)
    True
    """


class RowsLost(FairauditError):  # noqa: N818
    """A library counted other than as many rows as it read: a fault of the library or of this package, and none of the log.

    Examples
    --------
    >>> issubclass(RowsLost, FairauditError), issubclass(RowsLost, InputError)
    (True, False)
    """


class TableNeeded(InputError):  # noqa: N818
    """A certificate does not hold its table, and none was given, so that it cannot be checked.

    Examples
    --------
    >>> issubclass(TableNeeded, InputError)
    True
    """


def shown(value: object, width: int = 60) -> str:
    """`repr` of a value from the input, cut to `width` characters, for use in a message; a decimal is its digits.

    Examples
    --------
    >>> print(shown("yes"), shown(Decimal("0.50")))
    'yes' 0.50
    """
    try:
        text = str(value) if isinstance(value, Decimal) else repr(value)
    except ValueError:
        text = f"a number of about {int(getattr(value, 'bit_length', lambda: 0)()) * 3 // 10} digits"
    text = without_passwords(text[: width + LONGEST])
    return text if len(text) <= width else text[: width - 1] + "…"


def without_passwords(text: str) -> str:
    """Leave out what looks like a password, for a message: in a URL, however it is written, and beside a name such as ``password=``.

    Examples
    --------
    >>> print(without_passwords("Postgres:/me:hush@host/db, postgresql://host/db?user=me&password=hush"))
    Postgres:/me:…@host/db, postgresql://host/db?user=me&password=…
    """
    text = re.sub(ALONE_IN_URL, r"\1…@", re.sub(IN_URL, r"\1\2:…@", text))
    return re.sub(BESIDE_NAME, r"\1…", text)


def kind_of(value: object) -> str:
    """What a value is, for use in a message.

    Examples
    --------
    >>> kind_of(None), kind_of(3), kind_of("x"), kind_of(InputError)
    ('None', 'an int', 'a text', 'the class InputError')
    """
    if value is None:
        return "None"
    if isinstance(value, type):
        return f"the class {value.__name__}"
    name = {"str": "text", "bool": "truth value"}.get(type(value).__name__, type(value).__name__)
    return f"{'an' if name[0] in 'aeiouAEIO' else 'a'} {name}"


def nearest(word: object, known: Iterable[str]) -> str:
    """End a message with the known names and, where there is one, the name that was probably meant."""
    import difflib

    names = list(known)
    folded = {str(name).casefold(): name for name in reversed(names)}
    close = difflib.get_close_matches(str(word), names, n=1, cutoff=0.6)
    close = close or [folded[name] for name in difflib.get_close_matches(str(word).casefold(), folded, n=1, cutoff=0.6)]
    meant = f"; did you mean {shown(close[0])}?" if close else ""
    listed = ", ".join(shown(name) for name in names[:20]) + (f", … ({len(names)} in all)" if len(names) > 20 else "")
    return f"known: {listed}{meant}"


@contextmanager
def naming(name: str | None) -> Iterator[None]:
    """Begin the messages about bad input with the name of the file or database that it is in, where there is one."""
    try:
        yield
    except InputError as error:
        if name is None:
            raise
        raise InputError(f"{name}: {error}") from None
