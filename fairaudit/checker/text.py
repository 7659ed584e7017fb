"""Text for people: nothing that stands in a document steers the terminal."""

from __future__ import annotations

import json

from .errors import FormatError

# Text for people


def printable(text: str) -> str:
    """Escape what could steer a terminal: control, format, bidi, surrogate, private and unassigned characters."""
    if text.isprintable():
        return text
    return "".join(c if c.isprintable() else _escaped(ord(c)) for c in text)


def _escaped(code: int) -> str:
    return f"\\u{code:04x}" if code <= 0xFFFF else f"\\U{code:08x}"


def shown(value: object) -> str:
    """Show a label, a rational, a witness and so on in one short line."""
    text = _shown(value)
    return text if len(text) <= 400 else text[:400] + " [...]"


def _shown(value: object) -> str:
    match value:
        case (int(numerator), int(denominator)):
            return shown_rational(numerator, denominator)
        case dict():
            return "{" + ", ".join(f"{_shown(key)}: {_shown(item)}" for key, item in value.items()) + "}"
        case list() | tuple():
            return "[" + ", ".join(_shown(item) for item in value) + "]"
        case str() if len(value) > 400:
            return json.dumps(value[:400] + " [...]", ensure_ascii=False)
        case _:
            return json.dumps(value, ensure_ascii=False)


def shown_rational(numerator: int, denominator: int) -> str:
    if denominator == 0:
        return "inf"
    bits = max(numerator.bit_length(), denominator.bit_length())
    if bits > 1500:  # Python may refuse to write long numbers, and nobody would read them
        return f"(a rational of about {bits * 3 // 10} digits)"
    return str(numerator) if denominator == 1 else f"{numerator}/{denominator}"


def malformed(where: str, what: str) -> FormatError:
    return FormatError(printable(f"{where} {what}"))
