"""Claims that bound a ratio by a theorem about a policy behind filters, and what the theorems need of both."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import cached_property

from .claims import FLOORED, GROUP_FILTERS, LAW, Claim, Rule
from .filters import map_of, map_through, mixed_laws
from .laws import expectation
from .rationals import (
    Rational,
    as_pair,
    at_most,
    bits_of,
    extreme_positions,
    maximum,
    over_common_denominator,
    product_of,
    reduced,
    widest_ratio,
)
from .table import Policy, Table, constants
from .text import shown
from .work import spend


@dataclass(frozen=True)
class PolicyFacts:
    """What the theorems need of a policy and its filters, each computed when a claim needs it."""

    table: Table  # of the law that they induce
    policy: Policy
    declared: Mapping[str, Rational]

    @cached_property
    def constants(self) -> dict[str, Fraction]:
        """The effective constants of g, those that are declared first; tau is that of the table."""
        own = constants(self.table)
        finite = {key: Fraction(*value) for key, value in own.items() if isinstance(value, tuple)}
        return finite | {key: Fraction(*value) for key, value in self.declared.items() if key != "tau"}

    def _utilities(self) -> list[Sequence[Rational | None]]:
        """For each true context its g(u,x), which must not depend on the group."""
        return [cells[0].utility for cells in self.table.by_context()]

    def floor(self, scope: str) -> Fraction | None:
        """The tau of a claim: what all expectations are at least, in the scope of the claim."""
        if scope == LAW:
            return self.constants.get("tau")
        if scope == FLOORED:
            return Fraction(*self.declared["tau"]) if "tau" in self.declared else None
        return Fraction(*self._policy_floor)

    @cached_property
    def _policy_floor(self) -> Rational:
        """The least expectation over what each true context can release and all reachable groups, for g(u,x)."""
        contexts = range(len(self.table.header.contexts))
        releases = self.policy.context.releases() if self.policy.context else [[x] for x in contexts]
        seen: dict[Sequence[Rational | None], set[int]] = {}
        for utility, released in zip(self._utilities(), releases, strict=True):
            seen.setdefault(utility, set()).update(released)
        values = [expectation(law, g) for g, released in seen.items() for x in released for law in self.policy.rows[x]]
        return values[extreme_positions(values)[1]]

    @cached_property
    def raw_ratio(self) -> Rational:
        """The greatest ratio of two expectations of one true context over the reachable groups, for g(u,x)."""
        pairs = zip(self._utilities(), self.policy.by_context, strict=True)
        ratios = [widest_ratio([expectation(law, utility) for law in laws])[0] for utility, laws in pairs]
        return maximum(ratios)

    @cached_property
    def context_ratio(self) -> Rational:
        """The local ratio of the law over reachable contexts and true groups, for g(u)."""
        utility = self.table.header.utility or ()
        laws = (mixed_laws(row, self.policy.group.maps) for row in self.policy.rows)
        ratios = [widest_ratio([expectation(law, utility) for law in row])[0] for row in laws]
        return maximum(ratios)

    @cached_property
    def composition(self) -> Rational:
        """The greatest P(x|a)/P(x|a') over released contexts x and pairs of groups of positive mass."""
        masses, _ = over_common_denominator([cell.mass for cell in self.table.cells])
        factors = self.policy.context.factors if self.policy.context else ()
        released = map_through(masses, [map_of([*zip(*factor.matrix, strict=True)], factor.total) for factor in factors])
        n = len(self.table.header.groups)
        rows = [released[i : i + n] for i in range(0, len(released), n)]
        totals = [sum(column) for column in zip(*rows, strict=True)]
        ratios = [widest_ratio([(p, total) for p, total in zip(row, totals, strict=True) if total])[0] for row in rows]
        return maximum(ratios)


def fault_of_bound(claim: Claim, rule: Rule, facts: PolicyFacts) -> str:
    """Judge a claim that a policy certificate adds: its value has to be at least the bound of its theorem."""
    _, _, by, scope = claim.key
    gamma, m, lipschitz = (facts.constants[key] for key in ("gamma", "m", "lipschitz"))
    n, d = facts.policy.group.exp_epsilon
    bits = bits_of(gamma, m, lipschitz, (n, d), claim.value)
    spend(20, bits, bits)
    tau: Fraction | None = Fraction(1)
    if by in ("T1-paper", "T1", "T3", "floor"):
        tau = facts.floor(scope)
    elif by == "T4":
        tau = m
    if tau is None or tau <= 0:
        return "the floor is 0" if tau is not None else "no floor is declared"
    if by == "T3" and tau > gamma - lipschitz:
        return f"the floor {shown(as_pair(tau))} is more than gamma - L"
    if rule.evidence == "multipliers":
        return _fault_of_multipliers(claim, facts, tau)
    evidence: Rational | None = None
    match by:
        case "T2" | "T5":
            bound = n, d
        case "T1-paper":
            bound = as_pair(Fraction(n, d) * (1 + lipschitz / tau))
        case "floor":
            bound = as_pair(gamma / tau)
        case "T12":
            evidence = r, s = facts.raw_ratio
            bound = reduced(s * d + r * n, s * n + r * d)  # (1 + R0 e^eps) / (R0 + e^eps), both possibly infinite
        case "T8":
            bound = facts.context_ratio
        case "T5-decision":
            evidence = facts.composition
            bound = product_of([(n, d), evidence])
        case _:
            raise AssertionError(by)
    if claim.evidence != evidence:
        return f"the evidence is {shown(claim.evidence)}, the table gives {shown(evidence)}"
    return "" if at_most(bound, claim.value) else f"the bound is {shown(bound)}"


def _fault_of_multipliers(claim: Claim, facts: PolicyFacts, tau: Fraction) -> str:
    """Look for a multiplier that proves the claim for each ordered pair P, Q of rows of the filter.

    H_k is the sum of max(0, P - k Q).  For every function h on the outputs with values in [0, gamma] it is
    E_P h <= k E_Q h + gamma H_k; the theorems put the expected utilities under ã, or parts of them, in the place of h.
    """
    _, _, by, scope = claim.key
    gamma, m, lipschitz = (facts.constants[key] for key in ("gamma", "m", "lipschitz"))
    # What is bounded is k + max(0, add + weight H_k - (k - 1) shed) / tau, which is convex in k.
    add, weight, shed = {"T1": (lipschitz, gamma, 0), "T3": (lipschitz, gamma - lipschitz, 0)}.get(by, (Fraction(0), gamma - m, m))
    n, d = facts.policy.group.exp_epsilon
    # The second is the one pair that stands for all filters of this epsilon.
    pairs, unit = facts.policy.group.pairs if scope != GROUP_FILTERS else ({((n, d), (d, n))}, n + d)
    multipliers: list[Fraction] = sorted(claim.evidence) if isinstance(claim.evidence, list) else []
    bits = bits_of(gamma, m, lipschitz, tau, claim.value) + unit.bit_length()
    hint = 0  # where the last multiplier that did was found
    for pair in pairs:
        low, high, at = 0, len(multipliers), hint
        least: Fraction | None = None
        while low < high:
            k = multipliers[at]
            spend(4 * len(pair), unit.bit_length(), bits_of(k))
            spend(60, bits + bits_of(k), bits + bits_of(k))
            exceeding = [(p, q) for p, q in pair if p * k.denominator > q * k.numerator]
            sum_p, sum_q = sum(p for p, _ in exceeding), sum(q for _, q in exceeding)
            h = Fraction(sum_p * k.denominator - sum_q * k.numerator, unit * k.denominator)
            excess = add + weight * h - (k - 1) * shed
            value = k + max(Fraction(0), excess) / tau
            if at_most(as_pair(value), claim.value):
                hint = at
                break
            least = value if least is None else min(least, value)
            if excess > 0 and tau < weight * Fraction(sum_q, unit) + shed:  # the slope to the right is negative
                low = at + 1
            else:
                high = at
            at = (low + high) // 2
        else:
            return f"for some pair of groups the multipliers prove no less than {shown(as_pair(least or Fraction(0)))}"
    return ""
