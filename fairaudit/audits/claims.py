"""The statements that a certificate makes, each with its scope and evidence."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from fractions import Fraction
from math import inf
from typing import Any, Literal

from fairaudit.certificates.numbers import number
from fairaudit.inference.rates import GivenTruth
from fairaudit.theorems.applicable import to_judge
from fairaudit.theorems.bound import Bound

__all__ = ["Claim"]


@dataclass(frozen=True)
class Claim:
    """A statement with its scope and evidence, as docs/certificate.md lists them."""

    quantity: str
    relation: Literal["=", "<=", ">="]
    value: Fraction | float
    by: str
    evidence: Mapping[str, Any]
    scope: str = "this law"
    assumptions: tuple[str, ...] = ()


def claims_given_truth(given: GivenTruth, assumptions: tuple[str, ...]) -> Iterator[Claim]:
    for name, found in given.differences.items():
        if found is not None:
            yield Claim(name, "=", found.value, "enumeration", {"table": ""}, assumptions=assumptions)
    for name, interval in given.intervals.items():
        scope = f"population at confidence {number(interval.confidence)}"
        yield Claim(name, ">=", interval.lower, "binomial", {"interval": name}, scope, interval.assumptions)
        yield Claim(name, "<=", interval.upper, "binomial", {"interval": name}, scope, interval.assumptions)


def bound_claim(bound: Bound, assumptions: tuple[str, ...]) -> Claim:
    evidence: dict[str, Any] = {}
    if bound.theorem == "T12":
        evidence["raw_ratio"] = number(bound.constants.get("raw_ratio", inf))
    if bound.theorem == "T5-decision":
        evidence["composition"] = number(bound.constants["composition"])
    if bound.theorem in ("T1", "T3", "T4"):
        evidence["multipliers"] = [number(k) for k in bound.multipliers]
    return Claim(bound.quantity, "<=", bound.value, bound.theorem, evidence, bound.scope, (*to_judge(bound), *assumptions))
