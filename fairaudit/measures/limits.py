"""Limits on the worst ratio, and on the greatest difference: their names, how they are read, and how they are said.

A limit is one on the ratio itself (R, R̄) or on its natural logarithm (L, L̄), and its name says which: a bare number such as 0.8 is a
ratio to one reader and a logarithm to the next, and the two differ by far. A limit on the ratio under 1 is read as least over greatest,
so that 0.8, the four-fifths rule, is 5/4. A limit on the difference of expectations (D, D̄) is on the scale of the utility.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from decimal import ROUND_CEILING, ROUND_FLOOR, Context, Decimal
from fractions import Fraction
from functools import wraps
from math import inf
from typing import Any, Literal, ParamSpec, TypeVar

from fairaudit.arguments import answered
from fairaudit.errors import InputError, shown
from fairaudit.exact.enclosures import exp_enclosure, log_enclosure
from fairaudit.exact.rationals import option_value, rational_text
from fairaudit.words import approximate

__all__ = [
    "ALONE",
    "DIFFERENCE_LIMITS",
    "LIMITS",
    "MEASURED",
    "Limit",
    "Quantity",
    "Unit",
    "difference_limits_of",
    "instead",
    "limit_cells",
    "limit_readings",
    "limit_text",
    "limits_of",
    "one_limit",
    "read_limit",
    "refuse_bare",
    "without_bare_limits",
]


Quantity = Literal["local", "global"]

Unit = Literal["log", "ratio", "difference"]

Limit = tuple[Quantity, Unit, Fraction]


LIMITS: dict[str, tuple[Quantity, Unit]] = {
    "max_local_log": ("local", "log"),
    "max_local_ratio": ("local", "ratio"),
    "max_global_log": ("global", "log"),
    "max_global_ratio": ("global", "ratio"),
}

DIFFERENCE_LIMITS: dict[str, Quantity] = {"max_difference": "local", "max_global_difference": "global"}

MEASURED = {"max_local": ("max_local_ratio", "max_local_log"), "max_global": ("max_global_ratio", "max_global_log")}

ALONE = dict.fromkeys(
    (*MEASURED, "targets", "limit", *(f"target{quantity}{unit}" for quantity in ("", "_local", "_global") for unit in ("", "_ratio"))),
    ("max_ratio", "max_log"),
)

MOST = 10_000  # beyond, a limit on a logarithm is shown as more than e^10,000, which has 4,343 digits


P = ParamSpec("P")

R = TypeVar("R")


def instead(name: str, names: tuple[str, str]) -> str:
    """Say what takes the place of a name that does not tell a ratio from its logarithm.

    Examples
    --------
    >>> instead("--target", ("--max-ratio", "--max-log"))
    '--target is not accepted; give --max-ratio, a limit on the ratio such as 5/4, or --max-log, one on its natural logarithm'
    """
    return f"{name} is not accepted; give {names[0]}, a limit on the ratio such as 5/4, or {names[1]}, one on its natural logarithm"


def refuse_bare(given: Iterable[str], bare: Mapping[str, tuple[str, str]] = MEASURED, where: str = "") -> None:
    """Refuse names of limits that do not say of which number.

    Raises
    ------
    InputError
        If there is one; the message names both that do.
    """
    for name in given:
        if name in bare:
            raise InputError(where + instead(name, bare[name]))


def without_bare_limits(bare: Mapping[str, tuple[str, str]]) -> Callable[[Callable[P, R]], Callable[P, R]]:
    """Let a function answer a keyword that does not tell a ratio from its logarithm with the two that do."""

    def decorate(function: Callable[P, R]) -> Callable[P, R]:
        sentences = answered(function)

        @wraps(function)
        def call(*args: P.args, **kwargs: P.kwargs) -> R:
            refuse_bare(kwargs, bare)
            return sentences(*args, **kwargs)

        return call

    return decorate


def read_limit(name: str, value: Any) -> Fraction:
    """Read a limit whose name ends in ``ratio`` or ``log``.

    Parameters
    ----------
    name : str
        Its name.
    value : number or str
        The limit; a float is the decimal that it is printed as.

    Returns
    -------
    Fraction
        A limit on the ratio, at least 1, or on its logarithm, at least 0.

    Raises
    ------
    InputError
        If it is not finite, a ratio that is not positive, or a negative logarithm.

    Examples
    --------
    >>> read_limit("max_local_ratio", 1.25), read_limit("max_local_ratio", "0.8"), read_limit("max_local_log", 0.2)
    (Fraction(5, 4), Fraction(5, 4), Fraction(1, 5))
    """
    try:
        limit = Fraction(*option_value(value))
    except InputError as error:
        raise InputError(f"{name}: {error}") from None
    if not name.endswith("ratio"):
        if limit < 0:
            raise InputError(f"{name} is {shown(value)}; a logarithm of at least 0 is accepted, which is perfect parity")
        return limit
    if limit <= 0:
        raise InputError(
            f"{name} is {shown(value)}; a ratio above 0 is accepted, and one under 1 is read as least over greatest: 0.8 is 5/4"
        )
    return limit if limit >= 1 else 1 / limit


def limits_of(given: Mapping[str, Any]) -> list[Limit]:
    """Limits that were asked for, by the names of `LIMITS` (those that are None were not), as exact rationals.

    Examples
    --------
    >>> limits_of({"max_global_ratio": "0.8", "max_local_log": None})
    [('global', 'ratio', Fraction(5, 4))]
    """
    asked = ((quantity, unit, name, given.get(name)) for name, (quantity, unit) in LIMITS.items())
    return [(quantity, unit, read_limit(name, value)) for quantity, unit, name, value in asked if value is not None]


def difference_limits_of(given: Mapping[str, Any]) -> list[Limit]:
    """Limits on differences that were asked for, by the names of `DIFFERENCE_LIMITS`, as exact rationals.

    Raises
    ------
    InputError
        If one is no number, or negative.

    Examples
    --------
    >>> difference_limits_of({"max_difference": 0.2})
    [('local', 'difference', Fraction(1, 5))]
    """
    found: list[Limit] = []
    for name, quantity in DIFFERENCE_LIMITS.items():
        value = given.get(name)
        if value is None:
            continue
        try:
            limit = Fraction(*option_value(value))
        except InputError as error:
            raise InputError(f"{name}: {error}") from None
        if limit < 0:
            raise InputError(f"{name} is {shown(value)}; a difference of at least 0 is accepted, which is perfect parity")
        found.append((quantity, "difference", limit))
    return found


def one_limit(max_ratio: Any, max_log: Any) -> tuple[Literal["log", "ratio"], Fraction]:
    """The one limit that was given.

    Raises
    ------
    InputError
        If none is, or both are.

    Examples
    --------
    >>> one_limit("0.8", None)
    ('ratio', Fraction(5, 4))
    """
    if (max_ratio is None) == (max_log is None):
        said = "max_ratio and max_log were given" if max_log is not None else "no limit was given"
        raise InputError(f"{said}; give one of max_ratio, a limit on the ratio, and max_log, one on its natural logarithm")
    if max_log is None:
        return "ratio", read_limit("max_ratio", max_ratio)
    return "log", read_limit("max_log", max_log)


def limit_text(quantity: str, unit: str, limit: Fraction) -> str:
    """Say a limit in its readings, the way it is said everywhere.

    Examples
    --------
    >>> limit_text("local", "ratio", Fraction(5, 4))
    'local ratio at most 1.25 (least at least 0.8 of the greatest; log 0.2231)'
    >>> limit_text("global", "log", Fraction(1, 5))
    'global log-ratio at most 0.2 (ratio 1.221; least at least 0.8187 of the greatest)'
    >>> limit_text("local", "difference", Fraction(1, 5))
    'local difference at most 0.2'
    """
    if unit == "difference":
        return f"{quantity} difference at most {approximate(limit)}"
    if unit == "ratio" and limit < 1:  # no limit of ours, but a document of others may say it
        return f"{quantity} ratio at most {approximate(limit)}"
    ratio, least, log = limit_cells(unit, limit)
    if unit == "ratio":
        return f"{quantity} ratio at most {ratio} (least at least {least} of the greatest; log {log})"
    return f"{quantity} log-ratio at most {log} (ratio {ratio}; least at least {least} of the greatest)"


def limit_cells(unit: str, limit: Fraction) -> tuple[str, str, str]:
    """A limit as the ratio, as least over greatest, and as the logarithm, in four digits each.

    Examples
    --------
    >>> limit_cells("ratio", Fraction(5, 4))
    ('1.25', '0.8', '0.2231')
    """
    ratio, least, log = _readings(unit, limit)
    above = "" if ratio[1] < inf else "above "
    return above + approximate(ratio[0]), approximate(least[0]), approximate((log[0] + log[1]) / 2)


def limit_readings(unit: str, limit: Fraction) -> dict[str, list[str]]:
    """The readings of a limit as a program reads them: what is exact as a rational twice, the rest between two decimals.

    Examples
    --------
    >>> limit_readings("ratio", Fraction(5, 4))
    {'ratio': ['5/4', '5/4'], 'least_over_greatest': ['4/5', '4/5'], 'log': ['0.223143551314', '0.223143551315']}
    >>> limit_readings("difference", Fraction(1, 5))
    {'difference': ['1/5', '1/5']}
    """
    if unit == "difference":
        return {"difference": _ends((limit, limit))}
    ratio, least, log = _readings(unit, limit)
    return {"ratio": _ends(ratio), "least_over_greatest": _ends(least), "log": _ends(log)}


def ratio_above(unit: str, limit: Fraction) -> Fraction:
    """The ratio of a limit, or one that is a little above that of a logarithm.

    Examples
    --------
    >>> ratio_above("ratio", Fraction(5, 4)), round(float(ratio_above("log", Fraction(1, 5))), 6)
    (Fraction(5, 4), 1.221403)
    """
    found = _readings(unit, limit)[0][1]
    if found == inf:
        raise InputError(f"a limit of {limit} on a logarithm is above all ratios that can be compared")
    return Fraction(found)


def _readings(unit: str, limit: Fraction) -> tuple[tuple[Any, Any], tuple[Any, Any], tuple[Any, Any]]:
    """Ratio, least over greatest, and logarithm, each between two ends; equal ends are exact."""
    if unit == "ratio":
        low, high = (Fraction(text) for text in log_enclosure((limit.numerator, limit.denominator)))
        return (limit, limit), (1 / limit, 1 / limit), (low, high)
    capped = min(limit, Fraction(MOST))
    low, high = (Fraction(end, 1 << 64) for end in exp_enclosure((capped.numerator, capped.denominator), 64))
    if capped < limit:
        return (low, inf), (Fraction(0), 1 / low), (limit, limit)
    ends = (Fraction(1), Fraction(1)) if limit == 0 else (low, high)
    return ends, (1 / ends[1], 1 / ends[0]), (limit, limit)


def _ends(ends: tuple[Any, Any]) -> list[str]:
    if ends[0] == ends[1]:
        return [rational_text((ends[0].numerator, ends[0].denominator))] * 2
    return [_rounded(ends[0], ROUND_FLOOR), _rounded(ends[1], ROUND_CEILING)]


def _rounded(value: Any, towards: str) -> str:
    if value == inf:
        return "inf"
    context = Context(prec=12, rounding=towards, Emin=-999_999, Emax=999_999)
    return str(context.divide(Decimal(value.numerator), Decimal(value.denominator)))
