"""Pure ε and δ of every single ordered pair of inputs, exactly."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from fractions import Fraction
from heapq import nlargest
from math import prod
from typing import Any, NamedTuple

from fairaudit.exact.rationals import at_least, fraction
from fairaudit.model.mechanism import Mechanism
from fairaudit.privacy.multiplied_out import greatest_ratios_of_rows, hockey_sticks_of_rows, whole_table, worth_multiplying_out
from fairaudit.privacy.pairs import PairLaw, flat_position, hockey_stick, kinds_of_pairs, kinds_of_row
from fairaudit.tables.values import Label


class PairPrivacy(NamedTuple):
    """Privacy of one ordered pair of inputs: ``exp_epsilon`` is the greatest P/Q, ``delta`` Σ max(0, P − kQ)."""

    first: Label
    second: Label
    exp_epsilon: Fraction | float
    delta: Fraction


@dataclass(frozen=True, eq=False)
class PairTable:
    """Exact e^ε and δ of every ordered pair of inputs; iterating gives a `PairPrivacy` for each pair of different inputs.

    Attributes
    ----------
    mechanism : Mechanism
        The filter.
    exp_epsilon : Fraction
        The k at which δ is taken.
    """

    mechanism: Mechanism
    exp_epsilon: Fraction
    _values: list[tuple[Fraction | float, Fraction]] = field(repr=False)
    _kinds_of: Callable[[int], list[int]] = field(repr=False)
    _examples: list[tuple[int, int]] = field(repr=False)

    def __len__(self) -> int:
        """Return the number of ordered pairs of different inputs."""
        size = prod(len(f.inputs) for f in self.mechanism.factors)
        return size * (size - 1)

    def __iter__(self) -> Iterator[PairPrivacy]:
        """Go through the pairs, the second input varying fastest."""
        inputs, values = self.mechanism.inputs, self._values
        for i, first in enumerate(inputs):
            for j, kind in enumerate(self._kinds_of(i)):
                if i != j:
                    yield PairPrivacy(first, inputs[j], *values[kind])

    def at(self, first: Any, second: Any) -> PairPrivacy:
        """Look one ordered pair up."""
        i, j = (flat_position(self.mechanism, self.mechanism.locate(value)) for value in (first, second))
        return PairPrivacy(self.mechanism.inputs[i], self.mechanism.inputs[j], *self._values[self._kinds_of(i)[j]])

    def top(self, count: int) -> list[PairPrivacy]:
        """List the most distinguishable ordered pairs, by e^ε and then δ, one for each kind of pair."""
        inputs = self.mechanism.inputs
        worst = nlargest(count, ((value, -n) for n, value in enumerate(self._values) if self._examples[n][0] != self._examples[n][1]))
        return [PairPrivacy(inputs[self._examples[-n][0]], inputs[self._examples[-n][1]], *value) for value, n in worst]


def per_pair(mechanism: Mechanism, exp_epsilon: Any = 1) -> PairTable:
    """Exact e^ε and δ of every ordered pair of inputs.

    Products are evaluated once for each kind of pair, other tables in vectorised integer arithmetic.

    Parameters
    ----------
    mechanism : Mechanism
        The filter.
    exp_epsilon : number or str
        The e^ε ≥ 1 at which δ is taken; 1 gives the total variation distance.

    Raises
    ------
    InputError
        If e^ε is not a number of at least 1, or the filter has too many kinds of ordered pairs.

    Examples
    --------
    >>> from fairaudit.model.mechanism import RandomizedResponse
    >>> table = per_pair(RandomizedResponse(["a", "b"], keep_probability="0.7"), 2)
    >>> len(table), table.at("b", "a").exp_epsilon, [pair.delta for pair in table]
    (2, Fraction(7, 3), [Fraction(1, 10), Fraction(1, 10)])
    """
    k = at_least("exp_epsilon", exp_epsilon, 1)
    if worth_multiplying_out(mechanism):
        rows, bottoms = whole_table(mechanism)
        size = len(rows)
        ratios = greatest_ratios_of_rows(rows, bottoms)
        values: list[tuple[Fraction | float, Fraction]] = []
        for i, tops in enumerate(hockey_sticks_of_rows(rows, bottoms, k)):
            scale = bottoms[i] * k.denominator
            values += [(fraction(ratios[i * size + j]), Fraction(top, scale * bottoms[j])) for j, top in enumerate(tops)]
        return PairTable(
            mechanism, k, values, lambda i: list(range(i * size, (i + 1) * size)), [divmod(n, size) for n in range(size * size)]
        )
    kinds = kinds_of_pairs(mechanism)
    evaluated: list[tuple[Fraction | float, Fraction]] = []
    for columns in kinds.examples:
        law = PairLaw(columns, sum(p for p, _ in columns), (), ())
        evaluated.append((fraction(columns[0]), hockey_stick(law, k)))
    examples = [(flat_position(mechanism, first), flat_position(mechanism, second)) for first, second in kinds.examples.values()]
    return PairTable(mechanism, k, evaluated, lambda i: kinds_of_row(mechanism, kinds, i), examples)
