"""Affine forms in the variables of a program or the means of samples."""

from __future__ import annotations

from collections.abc import Iterable

from .rationals import Rational, common_denominator
from .work import keep, spend

# An affine form in the variables: integer coefficients over one denominator, that of the constant under CONSTANT.  A
# constraint A v <= b is kept as its slack b - A v, an affine form that is at least 0 on the class.
Affine = tuple[dict[int, int], int]

CONSTANT = -1


def affine_sum(terms: Iterable[tuple[Rational, Affine]]) -> Affine:
    """Add up multiples of affine forms."""
    kept = [(n, d * denominator, form) for (n, d), (form, denominator) in terms if n]
    common = common_denominator({d for _, d, _ in kept})
    count = sum(len(form) for _, _, form in kept)
    bits = max((n.bit_length() + max(map(int.bit_length, form.values()), default=0) for n, _, form in kept), default=0)
    spend(3 * count, bits + common.bit_length(), bits)
    keep(count, bits + common.bit_length())
    total: dict[int, int] = {}
    for n, d, form in kept:
        factor = n * (common // d)
        for j, coefficient in form.items():
            total[j] = total.get(j, 0) + factor * coefficient
    return total, common


def constant_form(value: Rational) -> Affine:
    return {CONSTANT: value[0]}, value[1]
