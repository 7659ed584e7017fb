"""What is wrong with an input, in one sentence: what, where, and what would be accepted."""

from __future__ import annotations

from collections.abc import Iterable

__all__ = ["InputError", "nearest"]


class InputError(ValueError):
    """Input that cannot be audited; the message is one sentence: what, where, and what would be accepted."""


def shown(value: object, width: int = 60) -> str:
    """`repr` of a value from the input, cut to `width` characters, for use in a message."""
    try:
        text = repr(value)
    except ValueError:
        text = f"a number of about {int(getattr(value, 'bit_length', lambda: 0)()) * 3 // 10} digits"
    return text if len(text) <= width else text[: width - 1] + "…"


def nearest(word: str, known: Iterable[str]) -> str:
    """End a message with the known names and, where there is one, the name that was probably meant."""
    import difflib

    names = list(known)
    close = difflib.get_close_matches(word, names, n=1, cutoff=0.6)
    meant = f"; did you mean {shown(close[0])}?" if close else ""
    listed = ", ".join(shown(name) for name in names[:20]) + (f", … ({len(names)} in all)" if len(names) > 20 else "")
    return f"known: {listed}{meant}"
