"""The targets of a certificate, with what decided them, read back from its JSON."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from fractions import Fraction
from typing import Any

from fairaudit.audits.targets import Target
from fairaudit.certificates.reader import number
from fairaudit.theorems.registry import for_any_sampled, kind_of, without_objection
from fairaudit.words import THE_INTERVAL, THIS_TABLE

__all__ = ["judged_targets"]


def judged_targets(document: Mapping[str, Any]) -> Iterator[tuple[Target, Fraction | float | None]]:
    """Each target with the smallest upper end that it was judged by, and the lower end of its interval, where there is one."""
    for entry in document["targets"]:
        quantity, apart = entry["quantity"], entry["unit"] == "difference"
        interval = document.get("intervals", {}).get(f"{quantity}_difference" if apart else quantity)
        low, high = (None, None) if interval is None else map(number, interval["difference" if apart else "ratio"])
        about, under = without_objection(entry["judged"])
        confidence = None if about == THIS_TABLE else Fraction(about.rpartition(" ")[2])
        upper = None if confidence is None else _upper(document, quantity)
        if apart:
            upper = None if confidence is None or high is None else (high, THE_INTERVAL)
        yield Target(quantity, Fraction(entry["limit"]), entry["unit"], entry["verdict"], confidence, upper, under=under), low


def _upper(document: Mapping[str, Any], quantity: str) -> tuple[Fraction | float, str] | None:
    """The smallest sound upper end for the population, and the theorem or interval that gave it."""
    interval, declared = document.get("intervals", {}).get(quantity), document["subject"].get("declared", {})
    group_free = not document["subject"]["utility"]["depends_on_group"]
    ends = [] if interval is None else [(number(interval["ratio"][1]), THE_INTERVAL)]
    ends += [
        (number(claim["value"]), claim["by"])
        for claim in document["claims"]
        if claim["quantity"] == f"{quantity}_ratio"
        and claim["relation"] == "<="
        and for_any_sampled(kind_of(claim), claim["scope"], declared, group_free=group_free)
    ]
    return min(ends, key=lambda end: end[0], default=None)
