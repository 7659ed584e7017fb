"""The worst ordered pairs of a product of tables: what is left out by domination never changes what is worst."""

from fractions import Fraction
from itertools import product
from math import prod

from hypothesis import given, settings
from hypothesis import strategies as st
from seven_tables import TOTAL, outer_pairs, seven_tables

from fairaudit.model.mechanism import Factor, Mechanism
from fairaudit.privacy.columns import merged_columns
from fairaudit.privacy.epsilon_delta import delta
from fairaudit.privacy.pairs import PairLaw, hockey_stick
from fairaudit.privacy.trade_offs import lower_hull, worst_pair_laws

F = Fraction


@st.composite
def factors(draw: st.DrawFn) -> Factor:
    """A table of whole weights, with zeros and equal rows."""
    inputs, outputs = draw(st.integers(1, 3)), draw(st.integers(1, 3))
    rows = draw(st.lists(st.lists(st.integers(0, 4), min_size=outputs, max_size=outputs).filter(any), min_size=inputs, max_size=inputs))
    bottom = prod(map(sum, rows))
    exact = tuple(tuple(v * (bottom // sum(row)) for v in row) for row in rows)
    return Factor(tuple((str(i),) for i in range(inputs)), tuple((str(j),) for j in range(outputs)), exact, bottom)


def enumerated(mechanism: Mechanism) -> list[PairLaw]:
    """All ordered pairs of different rows of the product, multiplied out."""
    rows = {
        tuple(part for label, _ in chosen for part in label): [prod(entries) for entries in product(*(row for _, row in chosen))]
        for chosen in product(*(zip(factor.inputs, factor.rows, strict=True) for factor in mechanism.factors))
    }
    return [
        PairLaw(merged_columns(zip(p, q, strict=True)), sum(column[0] for column in merged_columns(zip(p, q, strict=True))), first, second)
        for first, p in rows.items()
        for second, q in rows.items()
        if first != second
    ]


@settings(max_examples=150, deadline=None)
@given(st.lists(factors(), min_size=1, max_size=3), st.fractions(1, 6, max_denominator=7))
def test_nothing_that_is_worst_is_left_out(parts: list[Factor], k: Fraction) -> None:
    mechanism = Mechanism(tuple(parts))
    found, every = worst_pair_laws(mechanism, few=0), enumerated(mechanism)
    assert {(law.first, law.second, law.columns) for law in found} <= {(law.first, law.second, law.columns) for law in every}
    assert max((hockey_stick(law, k) for law in found), default=F(0)) == max((hockey_stick(law, k) for law in every), default=F(0))
    if every:
        assert lower_hull(found).vertices == lower_hull(every).vertices


def test_a_product_of_many_tables_is_not_enumerated() -> None:
    mechanism = seven_tables()

    def above(both: tuple[list[int], list[int]]) -> int:
        """The part of P above 2·Q, in parts of the total."""
        return sum(max(0, p - 2 * q) for p, q in zip(*both, strict=True))

    assert delta(mechanism, 2) == F(max(map(above, outer_pairs(mechanism))), TOTAL)
