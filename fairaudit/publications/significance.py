"""How far two selection rates are apart beyond chance, decided in integers: Fisher's exact test, standard deviations, Holm, shortfall."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from fractions import Fraction
from math import comb, perm, prod

__all__ = ["LEVEL", "Judged", "Pair", "Probability", "fisher", "holm", "judged"]

LEVEL = Fraction(1, 20)

FEW = 2_000  # terms of a distribution that are added as they are; of more, bounds are added first

PRECISIONS = (128, 1024)  # bits of the bounds; where they do not decide, nothing is rounded


@dataclass(frozen=True)
class Pair:
    """A group and the one that it is compared with: so many selected of so many, each at least one.

    Examples
    --------
    >>> pair = Pair(18, 41, 412, 797)
    >>> pair.ratio, pair.below(Fraction(4, 5)), pair.further(Fraction(4, 5)), pair.one_person
    (Fraction(7173, 8446), False, 0, False)
    """

    selected: int
    applicants: int
    other_selected: int
    other_applicants: int

    @property
    def ratio(self) -> Fraction | None:
        """Rate ÷ the rate of the other; 1 where both are 0, none where that of the other alone is."""
        top, bottom = self.selected * self.other_applicants, self.other_selected * self.applicants
        return Fraction(top, bottom) if bottom else None if top else Fraction(1)

    def below(self, share: Fraction) -> bool:
        """Whether the rate is less than this share of the rate of the other."""
        return share.denominator * self.selected * self.other_applicants < share.numerator * self.other_selected * self.applicants

    @property
    def squared_deviations(self) -> Fraction | None:
        """How many standard deviations the rates are apart, squared, with the variance of both together; none where that is 0."""
        n, other = self.applicants, self.other_applicants
        taken = self.selected + self.other_selected
        everybody = n + other
        if taken in (0, everybody):
            return None
        cross = self.selected * other - self.other_selected * n
        return Fraction(cross**2 * everybody, n * other * taken * (everybody - taken))

    @property
    def shortfall(self) -> Fraction:
        """How many more would have been selected at the rate of both together; negative where more were."""
        taken, everybody = self.selected + self.other_selected, self.applicants + self.other_applicants
        return Fraction(self.applicants * taken, everybody) - self.selected

    def further(self, share: Fraction) -> int:
        """The least whole number of people who, selected besides, raise the rate to this share of the rate of the other."""
        least = share * self.other_selected * self.applicants / self.other_applicants
        return max(0, -(-least.numerator // least.denominator) - self.selected)

    @property
    def one_person(self) -> bool:
        """Whether selecting one other person would reverse the order: one more of the group with the lower rate, one less of the other."""
        (s, n), (h, m) = (self.selected, self.applicants), (self.other_selected, self.other_applicants)
        if s * m > h * n:
            (s, n), (h, m) = (h, m), (s, n)
        return s * m != h * n and (s + 1) * m > (h - 1) * n


@dataclass(frozen=True)
class Probability:
    """A probability between two bounds, which are equal where it is known exactly."""

    low: Fraction
    high: Fraction

    def at_most(self, limit: Fraction) -> bool | None:
        """Whether it is at most the limit; None where the bounds do not tell."""
        return True if self.high <= limit else False if self.low > limit else None


@dataclass(frozen=True)
class Judged:
    """What Fisher's test says of a pair, and after all pairs were counted (Holm); each compared with 1/20, exactly."""

    p: Probability
    adjusted: Probability
    significant: bool
    significant_adjusted: bool


def judged(pairs: Sequence[Pair]) -> list[Judged]:
    """Test pairs, with Holm's adjustment over all of them.

    Examples
    --------
    >>> first, second = judged([Pair(3, 12, 12, 16), Pair(2, 40, 3, 40)])
    >>> first.p.low, first.adjusted.low, first.significant_adjusted, second.p.high
    (Fraction(6692, 334305), Fraction(13384, 334305), True, Fraction(1, 1))
    """
    for bits in (*PRECISIONS, None):
        ps = [fisher(pair, bits) for pair in pairs]
        lows, highs = holm([p.low for p in ps]), holm([p.high for p in ps])  # no adjusted value falls where a value rises
        adjusted = [Probability(low, high) for low, high in zip(lows, highs, strict=True)]
        if all(found.at_most(LEVEL) is not None for found in (*ps, *adjusted)):
            break
    return [Judged(p, q, bool(p.at_most(LEVEL)), bool(q.at_most(LEVEL))) for p, q in zip(ps, adjusted, strict=True)]


def holm(values: Sequence[Fraction]) -> list[Fraction]:
    """Adjust values for their number: the i-th smallest of m times m − i + 1, at least as great as those before it, at most 1.

    Examples
    --------
    >>> [str(value) for value in holm([Fraction(1, 100), Fraction(1, 25), Fraction(3, 100)])]
    ['3/100', '3/50', '3/50']
    """
    adjusted = [Fraction(1)] * len(values)
    least = Fraction(0)
    for rank, place in enumerate(sorted(range(len(values)), key=values.__getitem__)):
        least = max(least, min(Fraction(1), (len(values) - rank) * values[place]))
        adjusted[place] = least
    return adjusted


def fisher(pair: Pair, bits: int | None = PRECISIONS[0]) -> Probability:
    """Fisher's exact test, two-sided: the sum of the hypergeometric probabilities that are not greater than that of what was observed.

    Parameters
    ----------
    pair : Pair
        The pair.
    bits : int or None
        Of the bounds where there are many terms; None rounds nothing.

    Examples
    --------
    >>> fisher(Pair(3, 12, 12, 16)).low
    Fraction(6692, 334305)
    """
    law = _Hypergeometric(pair.applicants, pair.other_applicants, pair.selected + pair.other_selected)
    if bits is None or law.last - law.first < FEW:
        exact = _exact(law, pair.selected)
        return Probability(exact, exact)
    return _bounded(law, pair.selected, bits)


@dataclass(frozen=True)
class _Hypergeometric:
    """How many of `taken` people are of the first kind: the weight of k is C(n,k)·C(m,taken−k)."""

    n: int
    m: int
    taken: int

    @property
    def first(self) -> int:
        return max(0, self.taken - self.m)

    @property
    def last(self) -> int:
        return min(self.n, self.taken)

    @property
    def mode(self) -> int:
        return (self.n + 1) * (self.taken + 1) // (self.n + self.m + 2)

    def step(self, k: int, by: int) -> tuple[int, int]:
        """The weight of k + by ÷ that of k, for by = 1 or −1."""
        if by == 1:
            return (self.n - k) * (self.taken - k), (k + 1) * (self.m - self.taken + k + 1)
        return k * (self.m - self.taken + k), (self.n - k + 1) * (self.taken - k + 1)

    def heavier(self, k: int, than: int) -> bool:
        """Whether the weight of k is greater than that of another number, exactly."""
        low, high = min(k, than), max(k, than)
        up = perm(self.n - low, high - low) * perm(self.taken - low, high - low)
        down = perm(high, high - low) * perm(self.m - self.taken + high, high - low)
        return up < down if k == low else up > down


def _exact(law: _Hypergeometric, observed: int) -> Fraction:
    """The probability as it is. The weights are integers over one denominator, in which the first is `start`."""
    steps = [law.step(k, 1) for k in range(law.first, law.last)]
    everybody = law.n + law.m
    if everybody <= FEW:
        start, total = comb(law.n, law.first) * comb(law.m, law.taken - law.first), comb(everybody, law.taken)
    else:
        start, total = prod(bottom for _, bottom in steps), 0
    weights = [start]
    for top, bottom in steps:
        weights.append(weights[-1] * top // bottom)
    limit = weights[observed - law.first]
    return Fraction(sum(weight for weight in weights if weight <= limit), total or sum(weights))


def _bounded(law: _Hypergeometric, observed: int, bits: int) -> Probability:
    """Bounds of the probability: weights relative to that of the mode, in units of 2^-bits, rounded down and up."""
    if abs(observed - law.mode) < 2 and not law.heavier(law.mode, observed):  # further out every weight is less than the one before
        return Probability(Fraction(1), Fraction(1))
    unit = 1 << bits
    towards = 1 if observed > law.mode else -1
    least, most = [0, unit], [0, unit]  # of those in the sum, of all
    seen = (0, 0)
    for k, low, high, rest in _weights(law, towards, unit):
        if k == observed:
            seen = (low, high)
        if (k - observed) * towards >= 0:
            least[0] += low
            most[0] += high
        elif rest:  # what was observed is further out, and weighs no more than this
            seen = (0, high)
        most[0] += rest
        least[1] += low
        most[1] += high + rest
    inside = False
    for k, low, high, rest in _weights(law, -towards, unit):
        if not inside and low <= seen[1]:
            inside = high <= seen[0] or (high * high > unit and not law.heavier(k, observed))
        if inside:
            least[0] += low
        if inside or (low <= seen[1] and high * high <= unit):
            most[0] += high
        most[0] += rest
        least[1] += low
        most[1] += high + rest
    return Probability(Fraction(least[0], most[1]), min(Fraction(1), Fraction(most[0], least[1])))


def _weights(law: _Hypergeometric, by: int, unit: int) -> Iterator[tuple[int, int, int, int]]:
    """Numbers from the mode outwards, each with bounds of its weight; the last with a bound of all that follow."""
    k, low, high = law.mode, unit, unit
    end = law.last if by == 1 else law.first
    while k != end:
        top, bottom = law.step(k, by)
        k += by
        low, high = low * top // bottom, -(-high * top // bottom)
        if high**4 <= unit and top < bottom:  # the quotients fall, so that what follows is less than a geometric series
            yield k, low, high, -(-high * top // (bottom - top))
            return
        yield k, low, high, 0
