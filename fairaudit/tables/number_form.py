"""Numbers as people write them: decimal marks, thousands separators, percent and currency signs, and which texts could mean two numbers."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, replace
from typing import Any, Literal

from fairaudit.errors import FairauditError, InputError, shown

__all__ = [
    "CURRENCIES",
    "PLAIN",
    "TEXT_FORM",
    "NumberForm",
    "NumberKind",
    "bears_sign",
    "either",
    "guessed",
    "number_form",
    "plain_numbers",
    "unmistakable",
]

NumberKind = Literal["amount", "label", "share"]
"""Counts and weights; numbers that are labels of decisions, too; and shares, of which none can be as great as a thousand."""

MARKS = (".", ",")
SEPARATORS = (".", ",", "'", " ")
SPACES = " \u00a0\u2009\u202f"  # blank, no-break, thin and narrow no-break space
WRITTEN = {",": ",", ".": ".", "'": "'\u2019", " ": SPACES}
"""The characters that a separator is written as."""

CURRENCIES = ("€", "$", "£", "¥", "₹", "EUR", "USD", "GBP", "CHF", "JPY", "PLN", "zł", "kr")
"""Signs that are proposed where a table has them; any other may be declared."""

TEXT_FORM = ("encoding", "decimal", "thousands", "number_sign")
"""What can be declared of how the texts of a table are written, by the names that keywords, keys and options have."""

_PERCENT = "%"
_POWER = re.compile("[eE]")
_NUMBER = re.compile(rf"[+-]?[\d.,'\u2019{SPACES}]*\d[\d.,'\u2019{SPACES}]*([eE][+-]?\d+)?", re.ASCII)
_GROUPED = {mark: re.compile(rf"[+-]?[1-9]\d{{0,2}}(\{mark}\d{{3}})+", re.ASCII) for mark in MARKS}
_GROUPS = {mark: re.compile(rf"[+-]?\d{{1,3}}([{own}]\d{{3}})+", re.ASCII) for mark, own in WRITTEN.items()}
_SIGN = re.compile(r"[^\d\s.,'\u2019+/-]")
_DIGIT = re.compile(r"\d")
_NAMES = {".": "point", ",": "comma"}


@dataclass(frozen=True)
class NumberForm:
    """How the texts of numbers are written, so far as it was declared.

    Attributes
    ----------
    decimal : {".", ","} or None
        The decimal mark.
    thousands : {".", ",", "'", " "} or None
        What separates groups of three digits.
    signs : tuple of str
        Signs that numbers may bear: ``%`` for hundredths, and those of currencies.
    """

    decimal: str | None = None
    thousands: str | None = None
    signs: tuple[str, ...] = ()

    @property
    def point(self) -> str | None:
        """The decimal mark, as it was declared or follows from the thousands separator."""
        return self.decimal or {".": ",", ",": "."}.get(self.thousands or "")


PLAIN = NumberForm()
"""Nothing was declared."""


def number_form(
    decimal: str | None = None, thousands: str | None = None, signs: str | Sequence[str] = (), *, spelled: Callable[[str], str] = str
) -> NumberForm:
    """Read a declaration of how numbers are written.

    Parameters
    ----------
    decimal : {".", ","}, optional
        The decimal mark.
    thousands : {".", ",", "'", " ", "space"}, optional
        The thousands separator.
    signs : str or sequence of str
        Signs that numbers bear, such as ``%`` or ``€``.
    spelled : callable
        How the one who asks writes the name of an option, for messages.

    Raises
    ------
    InputError
        If a mark is not one of these, both are the same, or a sign could be a part of a number.

    Examples
    --------
    >>> number_form(thousands="."), number_form(thousands=".").point
    (NumberForm(decimal=None, thousands='.', signs=()), ',')
    """
    thousands = " " if thousands == "space" else thousands
    if decimal is not None and decimal not in MARKS:
        raise InputError(f"{spelled('decimal')} {shown(decimal)} is not accepted; '.' or ',' is")
    if thousands is not None and thousands not in SEPARATORS:
        raise InputError(f"{spelled('thousands')} {shown(thousands)} is not accepted; '.', ',', \"'\" or 'space' is")
    if decimal is not None and decimal == thousands:
        raise InputError(f"{spelled('decimal')} and {spelled('thousands')} are both {shown(decimal)}; a mark has one meaning")
    listed = tuple(dict.fromkeys((signs,) if isinstance(signs, str) else signs))
    for sign in listed:
        if not isinstance(sign, str) or sign != sign.strip() or not _SIGN.search(sign) or _DIGIT.search(sign) or sign.lower() == "e":
            raise InputError(f"{spelled('number_sign')} {shown(sign)} could be a part of a number; a sign such as % or € is accepted")
    return NumberForm(decimal, thousands, listed)


def plain_numbers(
    name: str, values: Sequence[Any], locate: Callable[[int], str], form: NumberForm = PLAIN, kind: NumberKind = "label"
) -> list[Any] | None:
    """Values of a column of numbers in which texts are written with a decimal point and without separators or signs.

    Where nothing was declared, a comma is a decimal comma if some number of the column shows it. Marks that all separate groups of three
    digits could be either, and are refused. Whatever is no number is left to whoever reads it.

    Parameters
    ----------
    name : str
        Name of the column.
    values : sequence
        Its values; those that are no texts stay as they are.
    locate : callable
        Names the place of a value, for messages.
    form : NumberForm
        What was declared.
    kind : {"amount", "label", "share"}
        What the numbers are. Of amounts, decimals that are known to be such are written so that no part of the column is unclear; labels
        stay as they are where nothing has to be changed.

    Returns
    -------
    list or None
        The values; None if all stay as they are.

    Raises
    ------
    InputError
        If a text could be two numbers, or is not written as declared.

    Examples
    --------
    >>> plain_numbers("n", ["943", "1.306"], str, number_form(thousands="."))
    ['943', '1306']
    >>> plain_numbers("n", ["7,5", "12"], str)
    ['7.5', '12']
    """
    texts = dict.fromkeys(value for value in values if isinstance(value, str))
    if form == PLAIN and not any("," in text or "." in text for text in texts):
        return None
    try:
        known = _plain(texts, form, kind)
    except _RefusedError as error:
        at = next(place for place, value in enumerate(values) if isinstance(value, str) and value == error.text)
        raise InputError(f"column {shown(name)}, {locate(at)}: {error}") from None
    if all(text == plain for text, plain in known.items()):
        return None
    return [known[value] if isinstance(value, str) else value for value in values]


def guessed(texts: Iterable[str]) -> tuple[NumberForm, dict[str, str]] | None:
    """How the labels of a column are written as numbers, with what has to be declared, and the same written plainly; None if they are none.

    Of marks that could be either thousands are proposed: a table of three decimals everywhere is rarer.

    Examples
    --------
    >>> guessed(["943", "1.306"])
    (NumberForm(decimal=None, thousands='.', signs=()), {'943': '943', '1.306': '1306'})
    >>> guessed(["51.2%", "3%"])[0], guessed(["7,5", "12"])[0], guessed(["yes"])
    (NumberForm(decimal=None, thousands=None, signs=('%',)), NumberForm(decimal=None, thousands=None, signs=()), None)
    """
    from fairaudit.exact.rationals import parse_rational

    listed = list(texts)
    if not listed or not all(any(character.isdigit() for character in text) for text in listed):
        return None
    signs = tuple(sign for sign in (_PERCENT, *CURRENCIES) if any(_without(text.strip(), sign) is not None for text in listed))
    occurring = [mark for mark in SEPARATORS if any(character in text.strip() for text in listed for character in WRITTEN[mark])]
    for own in dict.fromkeys(((), signs)):
        for form in (NumberForm(signs=own), *(NumberForm(thousands=mark, signs=own) for mark in occurring)):
            try:
                plain = _plain(listed, form, "label")
                for text in plain.values():
                    parse_rational(text)
            except (InputError, _RefusedError):
                continue
            return form, plain
    return None


def either(texts: Iterable[str], form: NumberForm) -> str:
    """Say that a thousands separator in the numbers of a column could be the decimal mark, too; empty if it could not.

    Examples
    --------
    >>> either(["943", "1.306"], NumberForm(thousands="."))
    "'1.306' may be 1306 (--thousands .) or 1.306 (--decimal .)"
    >>> either(["1.306.000"], NumberForm(thousands="."))
    ''
    """
    mark, listed = form.thousands, list(texts)
    if mark not in MARKS:
        return ""
    try:
        one = _plain(listed, replace(form, thousands=None, decimal=mark), "label")
    except _RefusedError:
        return ""
    text = next((text for text in listed if mark in text), None)
    if text is None or any(plain.count(".") > 1 or "," in plain for plain in one.values()):
        return ""
    other = _plain([text], form, "label")[text]
    return f"{shown(text)} may be {other} (--thousands {mark}) or {one[text].removesuffix('0')} (--decimal {mark})"


def bears_sign(value: Any) -> str:
    """Say how a text is read that is a number with a sign which was not declared; empty if it is none.

    Examples
    --------
    >>> bears_sign("51.2%"), bears_sign("EUR 1200"), bears_sign("yes")
    ("; number_sign='%' (--number-sign %) reads it", "; number_sign='EUR' (--number-sign EUR) reads it", '')
    """
    text = value.strip() if isinstance(value, str) else ""
    for sign in (_PERCENT, *CURRENCIES):
        if _NUMBER.fullmatch(_without(text, sign) or ""):
            return f"; number_sign={sign!r} (--number-sign {sign}) reads it"
    return ""


def unmistakable(value: Any) -> Any:
    """A number whose text could be taken for one with a thousands separator, as a text that cannot; any other value as it is.

    Examples
    --------
    >>> unmistakable(1.306), unmistakable(7.5)
    ('1.3060', 7.5)
    """
    text = str(value) if isinstance(value, float) else ""
    plain = _sure(text)
    return value if plain == text else plain


class _RefusedError(FairauditError):
    """A text is not a number, as far as is known how numbers are written."""

    def __init__(self, text: str, said: str) -> None:
        super().__init__(f"{shown(text)} {said}")
        self.text = text


def _plain(texts: Iterable[str], form: NumberForm, kind: NumberKind) -> dict[str, str]:
    """Different texts, and how each is written plainly."""
    bodies, powers, used = dict[str, str](), dict[str, str](), dict[str, str]()
    for text in texts:
        body, sign = text.strip(), None
        for sign in form.signs:
            found = _without(body, sign)
            if found is not None:
                body = found
                break
        else:
            sign = None
        if _NUMBER.fullmatch(body) is None:
            continue
        if sign == _PERCENT:
            if _POWER.search(body):
                continue
            powers[text] = "e-2"
        elif sign is not None:
            other = next((one for one in used if one != sign), None)
            if other is not None:
                raise _RefusedError(text, f"bears {shown(sign)} and {shown(used[other])} bears {shown(other)}; a column has one currency")
            used[sign] = text
        bodies[text] = body if form.thousands is None else _ungrouped(text, body, form.thousands, form.point)
    point = form.point
    plain = _undeclared(bodies, kind) if point is None else {text: _declared(text, body, point) for text, body in bodies.items()}
    bare = next((text for text, body in bodies.items() if powers and text not in powers and _DIGIT.search(body.replace("0", ""))), None)
    if bare is not None:
        raise _RefusedError(bare, f"bears no % and {shown(next(iter(powers)))} does; all numbers of a column bear it, or none")
    return {text: plain[text] + powers.get(text, "") if text in plain else text for text in texts}


def _without(text: str, sign: str) -> str | None:
    """A number without the sign before or behind it; None if it has none."""
    lead = text[:1] if text[:1] in "+-" else ""
    rest = text[len(lead) :].strip()
    if rest.startswith(sign):
        return lead + rest.removeprefix(sign).strip()
    return lead + rest.removesuffix(sign).strip() if rest.endswith(sign) else None


def _ungrouped(text: str, body: str, thousands: str, point: str | None) -> str:
    """A number without its thousands separators, which have to separate groups of three."""
    own = WRITTEN[thousands]
    if not any(mark in body for mark in own):
        return body
    end = min((body.index(mark) for mark in (MARKS if point is None else (point,)) if mark in body), default=len(body))
    if _GROUPS[thousands].fullmatch(body[:end]) is None or any(mark in body[end:] for mark in own):
        name = "a space" if thousands == " " else repr(thousands)
        raise _RefusedError(
            text, f"has {name} that separates no group of three digits, as thousands={thousands!r} (--thousands) says it does"
        )
    return "".join(character for character in body if character not in own)


def _declared(text: str, body: str, point: str) -> str:
    """A number with a decimal point, where the decimal mark is known."""
    if point == "." and "," in body:
        raise _RefusedError(
            text, "has a comma, and the decimal mark is a point; if it separates thousands, say thousands=',' (--thousands ,)"
        )
    if point == "," and "." in body and ("," in body or _GROUPED["."].fullmatch(body)):
        raise _RefusedError(
            text,
            "has a dot, and the decimal mark is a comma; if it separates thousands, say both: --decimal , --thousands .",
        )
    return _sure(body.replace(",", ".") if point == "," and body.count(",") == 1 else body)


def _sure(body: str) -> str:
    """The same number, written so that its point cannot be taken for a thousands separator."""
    return f"{body}0" if _GROUPED["."].fullmatch(body) and body.count(".") == 1 else body


def _undeclared(bodies: dict[str, str], kind: NumberKind) -> dict[str, str]:
    """Numbers with a decimal point, where only the numbers say which mark that is; texts that no mark makes a number are left out."""
    bodies = {
        text: body
        for text, body in bodies.items()
        if all(
            body.count(mark) < 2 or _GROUPED[mark].fullmatch(body.replace(other, "0"))
            for mark, other in zip(MARKS, MARKS[::-1], strict=True)
        )
    }
    with_mark = {mark: [text for text, body in bodies.items() if mark in body] for mark in MARKS}
    if with_mark[","] and with_mark["."]:
        dot, comma = with_mark["."][0], with_mark[","][0]
        both = next((text for text in with_mark[","] if "." in bodies[text]), None)
        if both is not None:
            raise _RefusedError(
                both, "has a dot and a comma; say which of them separates thousands: thousands='.' (--thousands .) or ',' (--thousands ,)"
            )
        raise _RefusedError(
            dot,
            f"has a decimal point, and {shown(comma)} a comma; use one of the two, or say which is which (--decimal , --thousands .)",
        )
    for mark, texts in with_mark.items():
        if texts and not (kind == "share" and mark == ".") and all(_GROUPED[mark].fullmatch(bodies[text]) for text in texts):
            raise _RefusedError(texts[0], _either(bodies[texts[0]], mark))
    plain = {text: body.replace(",", ".") if body.count(",") == 1 else body for text, body in bodies.items()}
    return {text: _sure(body) for text, body in plain.items()} if kind == "amount" else plain


def _either(body: str, mark: str) -> str:
    """Say that a mark could be either, and how to settle it."""
    thousands = f"thousands={mark!r} (--thousands {mark})"
    if body.count(mark) > 1:
        return f"has thousands separators; {thousands} reads it as {body.replace(mark, '')}"
    one = f"decimal={mark!r} (--decimal {mark}) reads it as {body.replace(',', '.')}"
    return f"may have a decimal {_NAMES[mark]} or a thousands separator; {one}, {thousands} as {body.replace(mark, '')}"
