"""Claims about every utility of a class: by multipliers of the program, and by the closed form."""

from __future__ import annotations

from collections.abc import Iterable
from fractions import Fraction
from itertools import permutations

from .affine import affine_sum
from .claims import Claim, Rule
from .laws import Law, reduced_law
from .program import Program
from .rationals import INFINITY, ONE, ZERO, Rational, as_pair, at_most, bits_of, negated, over_common_denominator, product_of, reduced
from .text import shown
from .utility_class import Dual
from .work import keep, spend


def fault_of_worst_case(claim: Claim, rule: Rule, program: Program) -> str:
    """Judge a claim about every utility of the class."""
    utilities = program.utilities
    if rule.quantity != utilities.quantity:
        return f"the class is about the {utilities.quantity} ratio"
    if not at_most(ONE, claim.value):
        return "the value is less than 1, the ratio of 0 to 0"
    if claim.key[2] == "T3":
        if not utilities.blind or (utilities.tau is not None and utilities.tau_on == "pair"):
            return "T3 is for blind classes in which all groups keep the floor"
        if utilities.order or utilities.rows or utilities.family is not None:
            return "T3 is for classes without further constraints"
    if claim.value == INFINITY:
        return ""
    if isinstance(claim.evidence, Dual):
        return _fault_of_dual(claim.value, claim.evidence, program)
    return _fault_of_closed_form(claim.value, claim.evidence if isinstance(claim.evidence, list) else [], program)


def _fault_of_dual(value: Rational, evidence: Dual, program: Program) -> str:
    """Look for a compared pair for which the multipliers do not prove the claim.

    E and E' being those of the two groups, slack_i >= 0 on the class and y_i > 0,
    E - value E' <= E - value E' + sum of y_i slack_i, which is an affine form.  If its greatest value on the boxes is at
    most 0, then E <= value E' for every utility of the class; in particular E = 0 if E' = 0, and 0/0 = 1 <= value.
    """
    utilities, pairs = program.utilities, dict(evidence.pairs)
    # Both settings of tau_on put the floor under the lower group of every pair: E/E' <= gamma/floor.
    bounded = utilities.floor != ZERO and at_most(product_of([utilities.gamma, (utilities.floor[1], utilities.floor[0])]), value)
    for context, groups in program.compared():
        # The expectations of a blind utility under equal laws are equal.
        alike = utilities.blind and context >= 0 and len({cell.law for cell in program.by_context[context]}) == 1
        spend(3 * len(groups) ** 2)
        for higher, lower in permutations(groups, 2):
            pair = context, higher, lower
            named = f"{'' if context < 0 else f'context {context}, '}groups {higher} and {lower}"
            if pair not in pairs:
                if alike or bounded:
                    continue
                return f"the evidence lacks {named}"
            terms = [(ONE, program.mean(context, higher)), (negated(value), program.mean(context, lower))]
            for number, y in pairs.pop(pair):
                slack = program.slack(pair, number)
                if slack is None:
                    return f"there is no constraint {number} for {named}"
                terms.append((y, slack))
            greatest = program.greatest(affine_sum(terms))
            if greatest[0] > 0:
                return f"the multipliers leave {shown(reduced(*greatest))}, more than 0, for {named}"
    for context, higher, lower in pairs:
        return f"the evidence names {'' if context < 0 else f'context {context}, '}groups {higher} and {lower}, which are not compared"
    return ""


def _fault_of_closed_form(value: Rational, multipliers: Iterable[Fraction], program: Program) -> str:
    """Look for a compared pair of rows P, Q for which no multiplier k proves the claim.

    H_k is the sum of max(0, P - k Q).  Where m <= g <= gamma, E - k E' is the sum of (P - k Q) g, which is at most
    (gamma - m) H_k + (1 - k) m.  With t, the floor of E', this gives E/E' <= k + max(0, (gamma - m) H_k - (k - 1) m) / t;
    if t = 0, hence m = 0, then H_k = 0 gives E <= k E'.

    k t + max(0, (gamma - m) H_k - (k - 1) m) is convex in k.  So where it is too great, its slope tells on which side of k
    others may do, and few of them have to be tried.
    """
    utilities = program.utilities
    (gamma, m, floor), _ = over_common_denominator([utilities.gamma, utilities.m, utilities.floor])
    above, below = value
    ks = sorted({k for k in multipliers if k <= Fraction(*value)})
    hint = 0  # where the last multiplier that did was found

    def proved(p: Law, q: Law) -> bool:
        nonlocal hint
        common = p[1] * q[1]
        low, high = 0, len(ks)
        at = hint
        while low < high:
            n, d = as_pair(ks[at])
            bits = common.bit_length()
            spend(4 * len(p[0]) + 10, bits, d.bit_length() + n.bit_length())
            spend(4, bits + bits_of(value) + floor.bit_length(), d.bit_length() + n.bit_length() + gamma.bit_length())
            # P > k Q means p * raised > q * lowered; H_k is the sum of the differences over common * d
            raised, lowered = q[1] * d, p[1] * n
            sum_p = sum_q = 0
            for a, b in zip(p[0], q[0], strict=True):
                if a * raised > b * lowered:
                    sum_p += a
                    sum_q += b
            excess = (gamma - m) * (sum_p * raised - sum_q * lowered) - (n - d) * m * common
            if below * (n * floor * common + max(0, excess)) <= above * floor * d * common:
                hint = at
                return True
            # Since k <= value, the excess is positive here; the slope is floor - (gamma - m) * sum_q / q[1] - m.
            if (floor - m) * q[1] < (gamma - m) * sum_q:
                low = at + 1
            else:
                high = at
            at = (low + high) // 2
        return False

    for context, groups in program.compared():
        if context >= 0:
            laws = [cell.law for cell in program.by_context[context]]
        else:
            forms = [program.mean(-1, group) for group in groups]
            spend(len(groups) * len(program.values))
            keep(len(groups) * len(program.values) // 3)
            laws = [reduced_law([form.get(j, 0) for j in range(len(program.values))], total) for form, total in forms]
        spend(3 * len(groups) ** 2)
        for (higher, p), (lower, q) in permutations(zip(groups, laws, strict=True), 2):
            if p != q and not proved(p, q):
                place = "" if context < 0 else f"context {context}, "
                return f"no multiplier proves the value for {place}groups {higher} and {lower}"
    return ""
