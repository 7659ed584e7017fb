"""Likelihood ratios of the rows of a group filter: of all pairs of groups, for one release of the group or for several."""

from __future__ import annotations

from bisect import bisect_left
from collections.abc import Iterable, Sequence
from functools import cached_property
from itertools import accumulate, product
from math import prod

from .filters import Distribution, Filter, by_likelihood_ratio, check_entries
from .work import keep, spend

Classes = tuple[list[tuple[int, int]], int]  # pairs (p, q), and what they are over

PARTS = 3  # of the likelihood ratios of two rows, for quick proofs
FINER = 24  # bits of their masses beyond those of the rows


class PairLaw:
    """What two rows P and Q give to the outputs: pairs (p, q), in order of p/q, each for all outputs of that likelihood ratio.

    The p add up to ``unit``, and so do the q.
    """

    def __init__(self, classes: Iterable[tuple[int, int]]) -> None:
        self.classes = list(classes)
        self.unit = sum(p for p, _ in self.classes)
        self.bits = self.unit.bit_length()
        # Ratios of numbers of so many bits differ by more than 2^(-2 bits), so that they are in the order of their quotients.
        self.classes.sort(key=lambda c: (c[0] << 2 * self.bits) // c[1] if c[1] else self.unit << 2 * self.bits + 1)
        after = reversed(self.classes)
        self._sums = [*accumulate(after, lambda sums, c: (sums[0] + c[0], sums[1] + c[1]), initial=(0, 0))][::-1]

    def above(self, n: int, d: int) -> tuple[int, int]:
        """Add up the p and the q of the outputs with p/q > n/d, that is p d > q n."""
        return self._sums[bisect_left(self.classes, True, key=lambda c: c[0] * d > c[1] * n)]

    @cached_property
    def outer(self) -> Classes:
        """Give the mass of each output to the two extreme ratios, so that the sums of p and of q are kept.

        Whatever is convex in (p, q), and homogeneous, only grows by that: these rows tell more.
        """
        (p, q), (r, s) = self.classes[0], self.classes[-1]
        if len(self.classes) < 3:
            return self.classes, self.unit
        low, high = r - s, q - p  # low (p, q) + high (r, s) is a multiple of (1, 1)
        return [(low * p, low * q), (high * r, high * s)], low * p + high * r

    @cached_property
    def finer(self) -> Classes:
        """The same for each of some parts of the ratios; p rounded up and q down, which serves what grows in p and falls in q."""
        count = len(self.classes)
        if count <= 2 * PARTS:
            return self.classes, self.unit
        found: list[tuple[int, int]] = []
        for i in range(PARTS):
            start, end = i * count // PARTS, (i + 1) * count // PARTS
            (p, q), (r, s) = self.classes[start], self.classes[end - 1]
            total_p, total_q = (self._sums[start][side] - self._sums[end][side] for side in (0, 1))
            low, high, over = total_q * r - total_p * s, total_p * q - total_q * p, q * r - p * s
            found += [(-((-factor * n << FINER) // over), (factor * d << FINER) // over) for factor, n, d in ((low, p, q), (high, r, s))]
        return found, self.unit << FINER


class Likelihoods:
    """The laws of the likelihood ratios of all ordered pairs of true groups, made when they are asked for; equal ones are one object."""

    def __init__(self, group: Filter, releases: int) -> None:
        self.factors = [factor.kinds for factor in group.factors]
        self.digits = [*product(*(range(len(factor.inputs)) for factor in group.factors))]
        keep(2 * len(self.digits))
        entries, bits = 1, 0
        self.powers: list[list[Distribution]] = []
        for factor, (distributions, _) in zip(group.factors, self.factors, strict=True):
            powers = [power(distribution, releases) for distribution in distributions]
            bits += releases * factor.total.bit_length()
            entries *= sum(map(len, powers))
            check_entries(entries, bits)
            self.powers.append(powers)
        self._by_kind: dict[tuple[int, ...], PairLaw] = {}
        self._by_classes: dict[Distribution, PairLaw] = {}

    def of(self, higher: int, lower: int) -> PairLaw:
        """Find the law of a pair."""
        digits = zip(self.factors, self.digits[higher], self.digits[lower], strict=True)
        return self._of_kind(tuple(which[i][j] for (_, which), i, j in digits))

    def every(self) -> set[PairLaw]:
        """List the laws of all pairs, and perhaps that of equal rows."""
        kinds = [range(len(powers)) for powers in self.powers]
        spend(10 * prod(map(len, kinds)))
        return {self._of_kind(kind) for kind in product(*kinds)}

    def _of_kind(self, kind: tuple[int, ...]) -> PairLaw:
        law = self._by_kind.get(kind)
        if law is None:
            classes = _joint([powers[number] for powers, number in zip(self.powers, kind, strict=True)])
            law = self._by_classes.get(classes)
            if law is None:
                law = self._by_classes[classes] = PairLaw(classes)
            self._by_kind[kind] = law
        return law


def _joint(distributions: Sequence[Distribution]) -> Distribution:
    """Multiply the laws of outputs that are drawn independently."""
    joint: Distribution = ((1, 1),)
    for distribution in distributions:
        joint = _times(joint, distribution)
    return joint


def _times(one: Distribution, other: Distribution) -> Distribution:
    bits = sum(max(p + q for p, q in each).bit_length() for each in (one, other))
    spend(10 * len(one) * len(other), bits, bits)
    keep(2 * len(one) * len(other), bits)
    return by_likelihood_ratio((p * r, q * s) for p, q in one for r, s in other)


def power(distribution: Distribution, releases: int) -> Distribution:
    """Multiply a law so often with itself, by squaring."""
    result: Distribution = ((1, 1),)
    for bit in f"{releases:b}":
        result = _times(result, result)
        if bit == "1":
            result = _times(result, distribution)
    return result
