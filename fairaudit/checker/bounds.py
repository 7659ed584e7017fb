"""Claims that bound a ratio by a theorem about one release of a policy behind filters."""

from __future__ import annotations

from fractions import Fraction

from .claims import GROUP_FILTERS, Claim, Rule
from .policy_facts import PolicyFacts
from .rationals import Rational, as_pair, at_most, bits_of, product_of, reduced
from .text import shown
from .work import spend


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
