"""Claims by T14: how strong an unrecorded factor would have to be to explain a ratio away, and what a declared one leaves of it.

The factor is at most k times as common in one of two groups as in the other, and over its values the expected utility of one of them
differs at most m times.  Of a ratio R it leaves at least R (m + k)/(1 + mk), or less where k is a limit in one direction alone.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from itertools import pairwise
from math import isqrt

from .claims import HIDDEN, LAW, Claim, without_objection
from .figures import Maximum
from .intervals import Proven
from .json_values import read_choice, read_list, read_object
from .rationals import INFINITY, ONE, Rational, as_pair, at_most, bits_of, read_extended, read_pairs, read_rational, written
from .sentences import HIDDEN_BOTH, HIDDEN_HIGHER, HIDDEN_LOWER
from .text import malformed, shown
from .work import spend

UNIT = 10**6  # a balanced strength has six decimals
SENTENCES = {"both": HIDDEN_BOTH, "higher": HIDDEN_HIGHER, "lower": HIDDEN_LOWER}
MOST_LEVELS = 8
MOST_PAIRS = 16


@dataclass(frozen=True)
class Level:
    """What it takes to bring a ratio down to ``to``: a factor with k and m below ``balanced`` is too weak, as is one below a pair."""

    to: Fraction
    balanced: Rational
    pairs: tuple[tuple[Fraction, Fraction], ...]


@dataclass(frozen=True)
class HiddenContext:
    """A factor as it was declared."""

    k: Fraction
    m: Rational
    direction: str

    @property
    def remaining(self) -> Fraction:
        """The part of a ratio that it leaves at the least."""
        k, infinite = self.k, self.m == INFINITY
        m = Fraction(1) if infinite else Fraction(*self.m)
        if self.direction == "lower":
            return Fraction(k == 1) if infinite else k / (m * k - m + 1)
        if infinite:
            return 1 / k
        return (m + k) / (1 + m * k) if self.direction == "both" else (m + k - 1) / (m * k)

    def sentence(self, quantity: str) -> str:
        """What a claim with it assumes."""
        where = "of a context" if quantity == "local_ratio" else "over all contexts"
        m = "inf" if self.m == INFINITY else written(self.m)
        return SENTENCES[self.direction].format(written(as_pair(self.k)), where, m)


def read_hidden(value: object, where: str) -> HiddenContext:
    """Read the factor of a claim."""
    members = read_object(value, where, ("k", "m", "direction"))
    k = read_rational(members["k"], f"{where}.k", nonnegative=True)
    m = read_extended(members["m"], f"{where}.m")
    return HiddenContext(Fraction(*k), m, read_choice(members["direction"], f"{where}.direction", ("both", "higher", "lower")))


def read_frontier(value: object, where: str) -> tuple[Level, ...]:
    """Read what it takes to bring a ratio down, for 1 and for targets."""
    items = read_list(value, where)
    if not 0 < len(items) <= MOST_LEVELS:
        raise malformed(where, f"must have from 1 to {MOST_LEVELS} entries")
    levels = []
    for i, item in enumerate(items):
        place = f"{where}[{i}]"
        members = read_object(item, place, ("to", "balanced", "pairs"))
        pairs = read_pairs(members["pairs"], f"{place}.pairs")
        if len(pairs) > MOST_PAIRS:
            raise malformed(f"{place}.pairs", f"must have at most {MOST_PAIRS} entries")
        to, balanced = (
            read_rational(members["to"], f"{place}.to", nonnegative=True),
            read_extended(members["balanced"], f"{place}.balanced"),
        )
        levels.append(Level(Fraction(*to), balanced, tuple((Fraction(*k), Fraction(*m)) for k, m in pairs)))
    return tuple(levels)


def seen_ratio(claim: Claim, metrics: Mapping[str, Maximum | None], proven: Mapping[str, Proven]) -> Rational | str:
    """Find the ratio that a claim starts from: that of the table, or the lower end for the population; or say why there is none."""
    name = claim.key[0].partition("_")[0]
    about, _ = without_objection(claim.key[3])
    metric, interval = metrics.get(name), proven.get(name)
    if metric is None:
        return "the table does not give this quantity"
    if about == LAW:
        return metric.value
    if interval is None:
        return "there is no interval that holds"
    return interval.ratio[0] if interval.scope == about else f"the interval is for {shown(interval.scope)}"


def fault_of_hidden_context(claim: Claim, seen: Rational | str) -> str:
    """Say what is wrong with a claim by T14; nothing if it is true."""
    if isinstance(seen, str):
        return seen
    bits = bits_of(seen, claim.value)
    if isinstance(claim.evidence, HiddenContext):
        hidden = claim.evidence
        if hidden.k < 1 or not at_most(ONE, hidden.m):
            return "k and m have to be at least 1"
        spend(20, bits, bits_of(hidden.k, hidden.m))
        infinite = INFINITY if hidden.remaining else ONE
        bound = infinite if seen == INFINITY else as_pair(max(Fraction(1), Fraction(*seen) * hidden.remaining))
        return "" if claim.value == bound else f"the bound is {shown(bound)}"
    levels: Sequence[Level] = claim.evidence if isinstance(claim.evidence, tuple) else ()
    if not levels or levels[0].to != 1 or any(one.to >= other.to for one, other in pairwise(levels)):
        return "the frontier does not begin with 1 and go up"
    if claim.value != levels[0].balanced:
        return "the value is not that of the first entry of the frontier"
    return next((fault for fault in (_fault_of_level(level, seen) for level in levels) if fault), "")


def _fault_of_level(level: Level, seen: Rational) -> str:
    """Compute again what it takes to bring a ratio down to a level."""
    if at_most(seen, as_pair(level.to)):
        return f"the ratio {shown(seen)} is not above {shown(as_pair(level.to))}"
    if seen == INFINITY:
        explained = level.balanced != INFINITY or level.pairs or level.to != 1
        return "no factor explains an infinite ratio" if explained else ""
    bits = bits_of(seen, level.to)
    spend(60, bits, bits)
    excess = Fraction(*seen) / level.to
    p, q = excess.numerator, excess.denominator
    balanced = as_pair(Fraction((p * UNIT + isqrt((p * p - q * q) * UNIT * UNIT)) // q, UNIT))
    if level.balanced != balanced:
        return f"k and m have to be {shown(balanced)} where they are equal"
    before = excess
    for k, m in level.pairs:
        spend(20, bits, bits_of(k, m))
        if k <= before:
            return "the k of the pairs do not go up from the ratio"
        least = (excess * k - 1) / (k - excess)
        if m != least:
            return f"k = {shown(as_pair(k))} needs m = {shown(as_pair(least))}"
        before = k
    return ""


def least_hidden(quantity: str, of_population: bool, claims: Sequence[Claim]) -> Rational | None:
    """Find what a ratio is at the least with the declared factor, by the claims that are true; nothing if none states it."""
    low = None
    for claim in claims:
        about, objection = without_objection(claim.key[3])
        own = claim.key[:3] == (f"{quantity}_ratio", ">=", "T14") and objection == HIDDEN and (about != LAW) == of_population
        if own and (low is None or at_most(low, claim.value)):
            low = claim.value
    return low
