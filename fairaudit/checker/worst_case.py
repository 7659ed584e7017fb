"""Claims about every utility of a class: whether that of the table is in it, and proofs by multipliers or in closed form."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from fractions import Fraction
from itertools import chain, combinations, permutations

from .claims import UTILITIES, Claim, Rule
from .figures import Maximum
from .header import Cell
from .laws import Law, reduced_law
from .program import Program
from .rationals import (
    INFINITY,
    ONE,
    ZERO,
    Rational,
    affine_sum,
    as_pair,
    at_most,
    bits_of,
    negated,
    over_common_denominator,
    product_of,
    reduced,
)
from .table import Table, place_of
from .text import Finding, finding_of, shown
from .utility_class import Dual, Family
from .work import keep, spend


def _fault_of_membership(program: Program, metric: Maximum | None, theta: Sequence[Rational] | None) -> str:
    """Say which constraint of the class the utility of the table violates; nothing if it is in the class."""
    utilities, table = program.utilities, program.table
    gamma, m = Fraction(*utilities.gamma), Fraction(*utilities.m)
    first: dict[int, list[Fraction]] = {}  # g by place
    gains: list[list[Fraction]] = []  # g by cell
    for cell in table.cells:
        where = place_of(table, cell)
        own = [Fraction(*entry) for entry in cell.utility if entry is not None]
        if len(own) < program.decisions:
            return f"the utility is not given everywhere {where}"
        if not all(m <= g <= gamma for g in own):
            return f"the utility leaves [m, gamma] {where}"
        if first.setdefault(program.place(cell), own) != own:
            return f"the utility depends on the group {where}, but the class is blind"
        for (lower, higher), names in zip(program.order, utilities.order, strict=True):
            if own[lower] > own[higher]:
                return f"the utility violates the order {shown(names)} {where}"
        gains.append(own)
    if utilities.lipschitz is not None:
        by_context: list[list[tuple[Cell, list[Fraction]]]] = [[] for _ in table.header.contexts]
        for cell, own in zip(table.cells, gains, strict=True):
            by_context[cell.context].append((cell, own))
        bits = 2 * max((bits_of(g) for own in gains for g in own), default=0)
        spend(sum(len(cells) ** 2 for cells in by_context) * 15 * (1 + program.decisions), bits, bits)
        for (left, one), (right, other) in chain.from_iterable(combinations(cells, 2) for cells in by_context):
            allowed = Fraction(*program.allowed(left, right))
            if one != other and any(abs(g - h) > allowed for g, h in zip(one, other, strict=True)):
                return f"the utility violates the Lipschitz constraint between group {right.group} and the cell {place_of(table, left)}"
    for i, (terms, bound) in enumerate(utilities.rows):
        bits = bits_of(bound) + sum(bits_of(c) + bits_of(first[program.places[x, a]][u]) for x, a, u, c in terms)
        spend(20 * len(terms), bits // max(1, len(terms)), bits)
        if sum(Fraction(*c) * first[program.places[x, a]][u] for x, a, u, c in terms) > Fraction(*bound):
            return f"the utility violates subject.class.rows[{i}]"
    if utilities.family is not None and (fault := _outside_family(utilities.family, table, gains, theta)):
        return fault
    return _below_floor(program, metric)


def _outside_family(family: Family, table: Table, gains: Sequence[Sequence[Fraction]], theta: Sequence[Rational] | None) -> str:
    """Say why theta does not show that the utility belongs to the family."""
    if theta is None:
        return "no claim by lp-dual about this quantity gives the theta of the utility"
    own = [Fraction(*parameter) for parameter in theta]
    for k, (low, high) in enumerate(zip(family.lower, family.upper, strict=True)):
        if not Fraction(*low) <= own[k] <= Fraction(*high):
            return f"theta[{k}] is not within its ends"
    widest = bits_of(*own)
    for i, (coefficients, bound) in enumerate(family.rows):
        bits = widest + bits_of(*coefficients)
        spend(20 * len(own), bits // len(own), bits)
        if sum(Fraction(*c) * parameter for c, parameter in zip(coefficients, own, strict=True)) > Fraction(*bound):
            return f"theta violates subject.class.family.rows[{i}]"
    for cell, features, values in zip(table.cells, family.features, gains, strict=True):
        for phi, g in zip(features, values, strict=True):
            bits = widest + bits_of(*phi)
            spend(20 * len(own), bits // len(own), bits)
            if sum(Fraction(*f) * parameter for f, parameter in zip(phi, own, strict=True)) != g:
                return f"theta does not give the utility {place_of(table, cell)}"
    return ""


def _below_floor(program: Program, metric: Maximum | None) -> str:
    tau, table = program.utilities.tau, program.table
    if tau is None or metric is None:
        return ""
    context, higher, lower = metric.place
    for group in program.groups_with_floor(-1 if context is None else context, higher, lower):
        if context is None:
            _, mean = table.figures.of_group(group)
        else:
            mean = next(cell.expectation for cell in program.by_context[context] if cell.group == group)
        if not at_most(tau, mean):
            return f"the floor is violated by group {shown(list(table.header.groups[group]))}, whose expectation is {shown(mean)}"
    return ""


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


def check_class(claims: Iterable[Claim], program: Program, metrics: Mapping[str, Maximum | None]) -> Finding:
    """Check that the utility of the table is in the class, with the parameters that a claim gives where they are a family's."""
    utilities = program.utilities
    key = (f"{utilities.quantity}_ratio", "<=", "lp-dual", UTILITIES)
    evidence = next((claim.evidence for claim in claims if claim.key == key), None)
    fault = _fault_of_membership(program, metrics[utilities.quantity], evidence.theta if isinstance(evidence, Dual) else None)
    return finding_of(f"the utility is in subject.class: {utilities.described()}", not fault, fault)
