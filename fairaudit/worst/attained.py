"""What a utility attains on a law: exact means, the ratio of a pair, and the pair that differs most."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from fractions import Fraction
from math import inf

from fairaudit.exact.extended import ONE, ZERO, Extended
from fairaudit.measures.ratios import Witness
from fairaudit.worst.setting import Setting


def raised_to_floor(
    setting: Setting, block: int, pair: tuple[int, int], table: dict[int, list[Fraction]]
) -> tuple[Extended, Witness, dict[int, list[Fraction]]]:
    """Mix a utility with the constant γ until all compared groups keep the floor, and find the pair that attains the ratio.

    The ratio does not fall: the numerator grows, and the least denominator is the floor. (The pair's own numerator is at least its
    denominator, so that only the other groups can force the mixture.)
    """
    gamma, floor = setting.of.gamma, setting.of.floor
    means = {member: mean_under(setting, member, table) for member in setting.members[block]}
    share = max([(floor - v) / (gamma - v) for v in means.values() if v < floor], default=ZERO)
    if share:
        table = {key: [v + share * (gamma - v) for v in row] for key, row in table.items()}
        means = {member: v + share * (gamma - v) for member, v in means.items()}
    high = max(means.values())
    least = min(means.values())
    first = pair[0] if means[pair[0]] == high else next(m for m in means if means[m] == high)
    second = pair[1] if means[pair[1]] == least else next(m for m in means if means[m] == least)
    if first == second:
        first, second = pair
    return ratio_of_means(means[first], means[second]), witness_of(setting, block, (first, second), (means[first], means[second])), table


def ratio_of_means(top: Fraction, bottom: Fraction) -> Extended:
    """A ratio by its conventions: 0/0 is 1, and c/0 infinite."""
    if bottom:
        return top / bottom
    return inf if top else ONE


def mean_under(setting: Setting, member: int, table: Mapping[int, Sequence[Fraction]]) -> Fraction:
    """Mean of a member under a utility, γ where the utility says nothing."""
    total = ZERO
    for v, p in setting.mean(member).items():
        row, u = divmod(v, setting.n)
        total += p * (table[row][u] if row in table else setting.of.gamma)
    return total


def witness_of(setting: Setting, block: int, pair: tuple[int, int], values: tuple[Fraction, Fraction]) -> Witness:
    """A pair with its means, by the labels of the law."""
    law, place = setting.law, setting.places[block]
    groups = pair if place is None else (setting.group_of[pair[0]], setting.group_of[pair[1]])
    context = None if place is None else law.context_label(setting.contexts[place])
    return Witness(context, law.group_label(groups[0]), law.group_label(groups[1]), values)
