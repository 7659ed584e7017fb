"""What bets on the contrast of two groups within a unit have won: for ratios and differences of units that are seen in several groups."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from fractions import Fraction
from itertools import permutations

from .intervals import Interval, Profile, UnitEvidence, Unproven
from .rationals import INFINITY, ONE, as_pair, bits_of
from .samples import Comparison
from .table import Table
from .text import shown
from .work import spend

BETS = (Fraction(15, 16), Fraction(2, 3))  # and their halves, by turns
SPREAD = 24  # the first bet whose square times the spread of the contrast is not more than this is the last one
MANTISSA = 128  # bits of what was won and of what it is computed from, rounded down

Contrasts = dict[tuple[Fraction, Fraction], int]  # how many units got which two values, scaled to [0, 1]
Wealth = tuple[int, int]  # m, e: a number of at least m 2^e
NOTHING: Wealth = (0, 0)


def bets_for(spread: Fraction) -> list[Fraction]:
    """List the bets that are made on contrasts of this spread."""
    bets: list[Fraction] = []
    while not bets or bets[-1] ** 2 * spread > SPREAD:
        bets.append(BETS[len(bets) % 2] / (1 << len(bets) // 2))
    return bets


def trimmed(mantissa: int, exponent: int) -> Wealth:
    """Leave out all but the first bits."""
    excess = max(0, mantissa.bit_length() - MANTISSA)
    return mantissa >> excess, exponent + excess


def quotient(above: int, below: int) -> Wealth:
    """Divide natural numbers, rounded down."""
    shift = max(0, MANTISSA + below.bit_length() - above.bit_length())
    return trimmed((above << shift) // below, -shift)


def times(left: Wealth, right: Wealth) -> Wealth:
    """Multiply, rounded down."""
    return trimmed(left[0] * right[0], left[1] + right[1])


def power(base: Wealth, exponent: int) -> Wealth:
    """Raise to a power, every step rounded down."""
    result: Wealth = (1, 0)
    for digit in bin(exponent)[2:]:
        result = times(result, result)
        if digit == "1":
            result = times(result, base)
    return result


def total(parts: Sequence[Wealth]) -> Wealth:
    """Add up, rounded down."""
    least = max((m.bit_length() + e for m, e in parts if m), default=0) - 2 * MANTISSA
    return trimmed(sum(m << e - least if e >= least else m >> least - e for m, e in parts), least)


def mean(parts: Sequence[Wealth]) -> Wealth:
    """Average, rounded down."""
    m, e = total(parts)
    return (m << MANTISSA) // len(parts), e - MANTISSA


def reaches(wealth: Wealth, level: Fraction) -> bool:
    """Decide whether a wealth is at least 1/level."""
    spend(10, bits_of(level), 2 * MANTISSA)
    m, e = wealth[0] * level.numerator, wealth[1]
    if (excess := m.bit_length() + e - level.denominator.bit_length()) not in (0, 1):
        return m > 0 and excess > 0
    return m << e >= level.denominator if e >= 0 else m >= level.denominator << -e


def check_units(
    profiles: Mapping[Profile, int], cells: Sequence[Mapping[Fraction, int]], limits: tuple[Fraction, Fraction], where: str
) -> None:
    """Make sure that the units of a context have in each group the values that its cell has, and values within the limits."""
    found: list[dict[Fraction, int]] = [{} for _ in cells]
    spend(20 * len(profiles) * len(cells))
    for profile, units in profiles.items():
        if len(profile) != len(cells) or units <= 0:
            raise Unproven(f"{where} must give some units, each with a value or none in {len(cells)} groups")
        for group, value in enumerate(profile):
            if value is not None:
                found[group][value] = found[group].get(value, 0) + units
    for group, cell in enumerate(cells):
        if found[group] != {value: units for value, units in cell.items() if units}:
            raise Unproven(f"{where} gives other values in group {group} than its cell has")
        if not all(limits[0] <= value <= limits[1] for value in found[group]):
            raise Unproven(f"{where} has a value outside the limits in group {group}")


def contrasts_of(profiles: Mapping[Profile, int], pair: tuple[int, int], limits: tuple[Fraction, Fraction], drop: bool) -> Contrasts:
    """Scale what units got in the higher and in the lower group of a pair.

    What is missing is the highest value in the first and the lowest one in the second, unless units that miss one are dropped. If
    the limits are equal, nothing can be said.
    """
    low, high = limits
    found: Contrasts = {}
    if low == high:
        return found
    spend(10 * len(profiles))
    seen: dict[tuple[Fraction | None, Fraction | None], int] = {}
    for profile, units in profiles.items():
        got = (profile[pair[0]], profile[pair[1]])
        seen[got] = seen.get(got, 0) + units
    spend(20 * len(seen), 2 * bits_of(low, high), bits_of(low, high))
    for (x, y), units in seen.items():
        if drop and (x is None or y is None):
            continue
        two = (Fraction(1) if x is None else (x - low) / (high - low), Fraction(0) if y is None else (y - low) / (high - low))
        found[two] = found.get(two, 0) + units
    return found


def prove_by_units(interval: Interval, evidence: UnitEvidence, comparison: Comparison, table: Table) -> None:
    """Make sure that what units got in the groups of each block proves an interval of the ratio.

    The pair that attains the ratio is one, whatever is drawn; of the lower end what was won against all pairs is averaged.
    """
    if table.policy is not None or interval.independent or interval.difference:
        raise Unproven("contrasts within units are for ratios of counts, of cells that were not declared independent")
    if table.header.profiles.get(interval.quantity) != evidence.digest:
        raise Unproven("profiles are not those that the header of the table names")
    share = (1 - Fraction(*interval.confidence)) / (1 if interval.each else 2)
    if evidence.levels != (share, share):
        raise Unproven(f"the levels must be {shown(as_pair(share))}")
    blocks = [[next(iter(form)) for form, _ in block] for block in comparison.blocks]
    if len(evidence.profiles) != len(blocks):
        raise Unproven(f"profiles must be listed for {len(blocks)} blocks, not for {len(evidence.profiles)}")
    pairs: list[Contrasts] = []
    for number, (block, profiles) in enumerate(zip(blocks, evidence.profiles, strict=True)):
        limits = Fraction(0), max(comparison.samples[i].high for i in block)  # a ratio has the origin 0
        check_units(profiles, [comparison.tallies[i] for i in block], limits, f"profiles[{number}]")
        pairs += [contrasts_of(profiles, pair, limits, evidence.drop) for pair in permutations(range(len(block)), 2)]
    low, high = interval.ratio
    if high != INFINITY and not all(proves_below(contrasts, Fraction(*high), share) for contrasts in pairs):
        raise Unproven("the bets do not show that no pair exceeds the upper end")
    if low != ONE and not proves_above(pairs, Fraction(*low), share):
        raise Unproven("the bets do not show that some pair exceeds the lower end")


def wealth_of(contrasts: Contrasts, limit: Fraction, difference: bool) -> Wealth:
    """Bound from below what bets have won that the first of two means is less than a multiple of the second, or not that much greater."""
    if limit < (-1 if difference else 0) or not all(0 <= value <= 1 for two in contrasts for value in two):
        return NOTHING  # one could lose more than one has
    a, b = limit.numerator, limit.denominator
    won = []
    for bet in bets_for(Fraction(2 * sum(contrasts.values()))):
        found: Wealth = (1, 0)
        for (x, y), units in contrasts.items():
            spend(40 + 8 * units.bit_length(), bits_of(limit, x, y), bits_of(limit, x, y))
            p, q, u, v = x.numerator, x.denominator, y.numerator, y.denominator
            # The gain is limit y - x, or half of limit - x + y, over one denominator.
            gain = a * q * v - p * b * v + u * b * q if difference else a * u * q - p * b * v
            below = bet.denominator * b * q * v * (2 if difference else 1)
            found = times(found, power(quotient(below + bet.numerator * gain, below), units))
        won.append(found)
    return mean(won)


def proves_below(contrasts: Contrasts, limit: Fraction, level: Fraction, difference: bool = False) -> bool:
    """Decide whether the ratio of two means, or their difference as a part of the range, is less than a limit at this level."""
    return reaches(wealth_of(contrasts, limit, difference), level)


def proves_above(pairs: Sequence[Contrasts], limit: Fraction, level: Fraction, difference: bool = False) -> bool:
    """Decide whether the greatest ratio, or difference, of all ordered pairs of groups is more than a limit at this level."""
    if not pairs or limit < (0 if difference else 1):
        return False
    opposite = -limit if difference else 1 / limit
    return reaches(mean([wealth_of(contrasts, opposite, difference) for contrasts in pairs]), level)
