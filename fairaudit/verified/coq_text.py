"""Values of a certificate as text of Coq: numbers as terms, labels as comments that nothing in them can end."""

from __future__ import annotations

import re
import unicodedata
from collections.abc import Iterable, Mapping, Sequence
from typing import Any, NamedTuple

from fairaudit.errors import InputError, shown

__all__ = ["Audited", "Claims", "boolean", "comment", "entries", "integer", "items", "label", "named", "option", "pair", "rational"]

Claims = Sequence[tuple[int, Mapping[str, Any]]]
"""Claims that are covered: the number of each in its certificate, and its JSON object."""

MOST_DIGITS = 4000
"""Of a number in a Coq file: Coq's reader of numerals takes time that grows with the square of their length."""

_RATIONAL = re.compile(r"(-?)(0|[1-9][0-9]*)(?:/([1-9][0-9]*))?")
_PLAIN = frozenset(" _.,:;/+=<>%&#@!?|~^$[]{}-")
_FROM_RIGHT = ("R", "AL", "AN")
_LONGEST = 80


class Audited(NamedTuple):
    """What a certificate is about: its subject, and the header and the lines of its table."""

    subject: Mapping[str, Any]
    header: Mapping[str, Any]
    rows: Sequence[Mapping[str, Any]]


def integer(value: object) -> str:
    """An integer that is not negative.

    Raises
    ------
    InputError
        If it is none.
    """
    if type(value) is not int or value < 0:
        raise InputError(f"{shown(value)} is no index of a certificate")
    return str(value)


def rational(value: object) -> str:
    """A rational as it stands in a certificate, as a term of type Q.

    Raises
    ------
    InputError
        If it is none, or too long for Coq.

    Examples
    --------
    >>> rational("3"), rational("-1/2")
    ('3', '(-1 # 2)')
    """
    match = _RATIONAL.fullmatch(value) if isinstance(value, str) else None
    if match is None:
        raise InputError(f"{shown(value)} is no rational of a certificate")
    sign, above, below = match.groups()
    if max(len(above), len(below or "")) > MOST_DIGITS:
        raise InputError(f"a number of the certificate has more than {MOST_DIGITS} digits, which is too long for a file that Coq reads")
    if below is not None:
        return f"({sign}{above} # {below})"
    return f"({sign}{above})" if sign else above


def option(term: str | None) -> str:
    """Something, or nothing.

    Examples
    --------
    >>> option("3"), option(None)
    ('(Some 3)', 'None')
    """
    return "None" if term is None else f"(Some {term})"


def boolean(value: object) -> str:
    """A truth value."""
    return "true" if value is True else "false"


def pair(*terms: str) -> str:
    """Several terms as one.

    Examples
    --------
    >>> pair("0", "1")
    '(0, 1)'
    """
    return f"({', '.join(terms)})"


def items(terms: Iterable[str]) -> str:
    """A list in one line.

    Examples
    --------
    >>> items(["512", "(1 # 2)"])
    '[512; (1 # 2)]'
    """
    return f"[{'; '.join(terms)}]"


def label(text: str) -> str:
    r"""A label as it may stand in a comment, whatever it holds; what is long is cut.

    Letters and digits are kept, and of signs those that mean nothing to Coq. The rest, what is written from the right
    included, becomes ``\u{...}``, so that no comment ends early and no line is shown in another order.

    Examples
    --------
    >>> label("Ingénieur *) Axiom")
    'Ingénieur \\u{2a}\\u{29} Axiom'
    """
    kept = "".join(c if _is_harmless(c) else f"\\u{{{ord(c):x}}}" for c in text[:_LONGEST])
    return f"{kept}..." if len(text) > _LONGEST else kept


def _is_harmless(c: str) -> bool:
    return c in _PLAIN or (c.isalnum() and unicodedata.bidirectional(c) not in _FROM_RIGHT)


def named(columns: Sequence[str], labels: Sequence[str]) -> str:
    """A group, or a context, by its columns.

    Examples
    --------
    >>> named(["Dept", "Sex"], ["A", "f"])
    'Dept = A, Sex = f'
    """
    return ", ".join(f"{label(column)} = {label(text)}" for column, text in zip(columns, labels, strict=True)) or "all"


def comment(text: str) -> str:
    """A comment of words and labels that are harmless by themselves.

    Examples
    --------
    >>> comment("context 0: Dept = A")
    '(* context 0: Dept = A *)'
    """
    return f"(* {text} *)"


def entries(terms: Sequence[Any], indent: str = "  ") -> str:
    """A list with an entry in each line; an entry is a term, or a term and what a comment says of it."""
    if not terms:
        return "[]"
    lines = []
    for i, term in enumerate(terms):
        text, said = (term, "") if isinstance(term, str) else term
        lines.append(f"{indent}{text}{';' * (i < len(terms) - 1)}{f' {comment(said)}' if said else ''}")
    return "[\n" + "\n".join(lines) + f"\n{indent[:-2]}]"
