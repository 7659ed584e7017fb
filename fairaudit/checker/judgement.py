"""What is wrong with a claim, by the rule of its kind."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from .bounds import fault_of_bound
from .claims import LAW, RULES, UTILITIES, Claim, Rule
from .facts import CONDITIONS, Facts
from .findings import Finding, finding_of
from .population import fault_about_population, is_about_population
from .rationals import Rational, at_most, reduced
from .text import shown
from .work import working_on
from .worst_case import fault_of_worst_case


def _rule(claim: Claim, facts: Facts) -> Rule | None:
    """Find the rule of a claim, if there is one for what the certificate is about."""
    rule = RULES.get(claim.key)
    if rule is None or rule.source:
        return rule
    subject = facts.program if claim.key[3] == UTILITIES else facts.table.policy
    return rule if subject is not None else None


def _fault(claim: Claim, facts: Facts) -> str:
    """Say what is wrong with a claim; nothing if it is true."""
    if is_about_population(claim.key):
        return fault_about_population(claim, facts.proven)
    rule = _rule(claim, facts)
    if rule is None:
        known = any(claim.key[:3] == key[:3] for key in RULES)
        return f"unknown claim: the scope is {shown(claim.key[3])}" if known else "unknown claim"
    quantity, source = facts.metrics.get(rule.quantity), facts.metrics.get(rule.source or rule.quantity)
    if quantity is None or source is None:
        return "the table does not give this quantity"
    for condition in rule.needs:
        if not facts.holds(condition):
            return CONDITIONS[condition]
    if claim.key[3] == UTILITIES and facts.program is not None:
        fault = fault_of_worst_case(claim, rule, facts.program)
    else:
        fault = _fault_of_figure(claim, rule, facts, source.value) if rule.source else fault_of_bound(claim, rule, facts)
    if not fault and not at_most(quantity.value, claim.value):
        fault = f"the table gives the greater quantity {shown(quantity.value)}"
    return fault


def _fault_of_figure(claim: Claim, rule: Rule, facts: Facts, source: Rational) -> str:
    """Compare the value and the evidence of a claim that repeats a metric, or has one as its value by a theorem."""
    by_t7 = rule.evidence == "supremum"
    value = reduced(source[0] - source[1], source[0] + source[1]) if by_t7 else source
    evidence = source if by_t7 else facts.table.digest
    if claim.value != value:
        return f"the table gives {shown(value)}"
    return "" if claim.evidence == evidence else f"the evidence is {shown(claim.evidence)}, the table gives {shown(evidence)}"


def faults_of_claims(claims: Sequence[Claim], facts: Facts) -> list[str]:
    """Say of each claim what is wrong with it; nothing if it is true."""
    faults: list[str] = []
    seen: set[tuple[str, str, str, str]] = set()
    for i, claim in enumerate(claims):
        working_on(f"claims[{i}]")
        faults.append("a claim that occurs twice" if claim.key in seen else _fault(claim, facts))
        seen.add(claim.key)
    return faults


def check_claims(claims: Sequence[Claim], faults: Sequence[str]) -> Iterator[Finding]:
    for i, (claim, fault) in enumerate(zip(claims, faults, strict=True)):
        quantity, relation, by, scope = claim.key
        statement = f"claims[{i}]: {shown(quantity)} {shown(relation)[1:-1]} {shown(claim.value)} by {shown(by)}"
        statement += "" if scope == LAW else f" for {shown(scope)}"
        assumed = f"assuming, for the reader to judge, {shown(list(claim.assumptions))}" if claim.assumptions else ""
        yield finding_of(statement, not fault, fault or assumed)
