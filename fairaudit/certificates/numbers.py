"""How a certificate writes numbers: exact rationals as text, ends of logarithms as decimals."""

from __future__ import annotations

from decimal import Decimal

from fairaudit.exact.rationals import number

__all__ = ["log_text", "number"]


def log_text(value: Decimal) -> str:
    """One end of an enclosure of a logarithm, all of its decimals."""
    return "inf" if value.is_infinite() else format(value, "f")
