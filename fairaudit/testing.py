"""Hypothesis strategies for laws and utilities, for property tests of your own.

Needs the extra ``testing`` (``pip install 'fairaudit-certify[testing]'``).
"""

from __future__ import annotations

from fractions import Fraction
from typing import Any

from hypothesis import strategies as st

from fairaudit.model.law import Law
from fairaudit.model.utility import Utility

__all__ = ["laws", "utilities", "weights"]


def weights() -> st.SearchStrategy[Any]:
    """Non-negative numbers of the kinds that tables hold.

    Returns
    -------
    SearchStrategy
        Zeros, small and huge integers, decimals, fractions and dyadic floats, from 1e-300 to 1e300.
    """
    return st.one_of(
        st.just(0),
        st.integers(0, 3),
        st.integers(0, 10**6),
        st.integers(0, 10**300),
        st.fractions(0, 10, max_denominator=60),
        st.decimals(0, 10, places=3).map(str),
        st.sampled_from(["1e-300", "1e300", 1e-300, 1e300, "1/3", 0.1]),
        st.floats(0, 10, allow_nan=False),
    )


@st.composite
def laws(
    draw: st.DrawFn,
    *,
    max_contexts: int = 5,
    max_groups: int = 5,
    max_decisions: int = 5,
    kinds: tuple[str, ...] = ("counts", "probabilities"),
    complete: bool = False,
    independent: bool = False,
    entries: st.SearchStrategy[Any] | None = None,
) -> Law:
    """Random laws, with zeros, ties and absent cells.

    Parameters
    ----------
    draw : callable
        Supplied by hypothesis.
    max_contexts, max_groups, max_decisions : int
        Greatest sizes; there are at least two groups.
    kinds : tuple of str
        Kinds of laws to draw.
    complete : bool
        Whether every group has a law in every context.
    independent : bool
        Whether context and group are independent under the population (implies probabilities, complete, with masses).
    entries : SearchStrategy, optional
        Where weights come from; `weights` by default.

    Returns
    -------
    Law
        A law in which at least one cell has a law.
    """
    entries = weights() if entries is None else entries
    kind = "probabilities" if independent else draw(st.sampled_from(kinds))
    x, a = draw(st.integers(1, max_contexts)), draw(st.integers(2, max_groups))
    u = draw(st.integers(1, max_decisions))
    pool = draw(st.lists(st.lists(entries, min_size=u, max_size=u), min_size=1, max_size=3))
    rows: list[list[Fraction]] = []
    for _ in range(x * a):
        # Rows come from a small pool half of the time, so that ties are common.
        row = draw(st.sampled_from(pool)) if draw(st.booleans()) else draw(st.lists(entries, min_size=u, max_size=u))
        rows.append([Fraction(value) for value in row])
    if complete or independent or not any(map(any, rows)):
        rows = [row if any(row) else [Fraction(1)] * u for row in rows]
    population = None
    if kind == "probabilities":
        rows = [[value / sum(row) for value in row] if any(row) else row for row in rows]
        if independent:
            by_context = draw(st.lists(st.integers(1, 9), min_size=x, max_size=x))
            by_group = draw(st.lists(st.integers(1, 9), min_size=a, max_size=a))
            population = [[p * q for q in by_group] for p in by_context]
        elif draw(st.booleans()):
            masses = [[draw(st.integers(0, 9)) if any(rows[i * a + j]) else 0 for j in range(a)] for i in range(x)]
            population = masses if any(map(any, masses)) else None
    array = [[[rows[i * a + j][k] for k in range(u)] for j in range(a)] for i in range(x)]
    return Law.from_array(array, kind="counts" if kind == "counts" else "probabilities", population=population)


@st.composite
def utilities(draw: st.DrawFn, law: Law, *, group_blind: bool = False, by_decision: bool = False) -> Utility:
    """Random utilities on a law.

    Parameters
    ----------
    draw : callable
        Supplied by hypothesis.
    law : Law
        The law.
    group_blind : bool
        Whether g may depend on decision and context only.
    by_decision : bool
        Whether g may depend on the decision only.

    Returns
    -------
    Utility
        A utility, often with zeros and ties.
    """
    entries = st.one_of(st.just(0), st.integers(0, 3), weights())
    if by_decision or draw(st.booleans()):
        return Utility({decision: draw(entries) for decision in law.decisions})
    values: dict[Any, Any] = {}

    def g(u: str, x: tuple[str, ...], a: tuple[str, ...]) -> Any:
        key = (u, x) if group_blind else (u, x, a)
        if key not in values:
            values[key] = draw(entries)
        return values[key]

    return Utility.from_function(g, law)
