"""Columns of exact numbers: the same as Fractions, over one denominator and over one for each row, whatever the denominators."""

from fractions import Fraction
from math import gcd, lcm
from typing import Any

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

from fairaudit import Law, Utility, certify
from fairaudit.certificates.table import Table, canonical
from fairaudit.exact.number_columns import NumberColumn
from fairaudit.exact.rationals import parse_rational
from fairaudit.measures.distances import demographic_parity, equalized_odds
from fairaudit.measures.ratios import global_fairness, global_supremum, local_fairness, local_supremum
from fairaudit.tables.values import exact_numbers

F = Fraction

ODD = [repr(0.1 + 0.2), "1e-300", "0." + "123456789" * 4, "1/3", "2/999983", "1/" + "9" * 30, "0e-900", "9" * 18, "1e18", "0.000", "5e-324"]

TEXTS = (
    st.sampled_from(ODD) | st.floats(0, 1e20).map(repr) | st.fractions(0, 1).map(str) | st.integers(0, 10**17).map(lambda n: f"0.{n:017d}")
)


def column(texts: list[str]) -> NumberColumn:
    return exact_numbers(texts, "p", str)


@settings(max_examples=150, deadline=None)
@example(ODD)
@example(["0e-900"])
@example([f"1/{10**9 + n}" for n in range(6)])
@example(["9" * 18] * 12)
@given(st.lists(TEXTS, min_size=1, max_size=12))
def test_one_denominator_is_the_least_common_one(texts: list[str]) -> None:
    exact = [F(*parse_rational(text)) for text in texts]
    tops, bottom = column(texts).over_one_denominator()
    assert bottom == lcm(*(value.denominator for value in exact))
    assert [F(top, bottom) for top in tops.tolist()] == exact
    assert (tops.dtype == np.int64) == (sum(tops.tolist()) < 2**63)


@settings(max_examples=150, deadline=None)
@given(st.lists(TEXTS, min_size=1, max_size=12), st.integers(1, 4), st.randoms(use_true_random=False))
def test_rows_over_their_own_denominators_are_the_numbers(texts: list[str], width: int, random: object) -> None:
    rows = -(-len(texts) // width) + 1
    places = np.array(random.sample(range(rows * width), len(texts)))  # type: ignore[attr-defined]
    matrix, bottoms = column(texts).rows(places, (rows, width))
    wanted = dict(zip(places.tolist(), (F(*parse_rational(text)) for text in texts), strict=True))
    assert [F(v, bottom) for row, bottom in zip(matrix.tolist(), bottoms.tolist(), strict=True) for v in row] == [
        wanted.get(place, F(0)) for place in range(rows * width)
    ]
    if matrix.dtype == np.int64:
        assert all(sum(row) < 2**63 for row in matrix.tolist())


@st.composite
def tables(draw: st.DrawFn) -> list[list[list[str]]]:
    """Texts of probabilities [context][group][decision] whose rows sum to 1, exactly or nearly, with whatever denominators."""
    contexts, groups, decisions = (draw(st.integers(*ends)) for ends in ((1, 3), (2, 4), (2, 3)))
    style = draw(st.sampled_from(["decimals", "floats", "fractions", "equal", "tiny", "mixed"]))
    same = draw(st.lists(st.integers(1, 9), min_size=decisions, max_size=decisions))

    def row() -> list[str]:
        own = draw(st.sampled_from(["decimals", "floats", "fractions"])) if style == "mixed" else style
        parts = same if own == "equal" else draw(st.lists(st.integers(0, 10**6), min_size=decisions, max_size=decisions).filter(any))
        if own == "floats":
            return [repr(part / sum(parts)) for part in parts]
        if own == "decimals":
            places = draw(st.sampled_from([12, 17, 25]))
            whole = [part * 10**places // sum(parts) for part in parts]
            whole[-1] += 10**places - sum(whole)
            return ["1" if v == 10**places else f"0.{v:0{places}d}" for v in whole]
        if own == "tiny":
            return [draw(st.sampled_from(["0", "1e-300", "5e-324", "3e-330"])) for _ in parts[1:]] + ["1"]
        return [str(F(part, sum(parts))) for part in parts]

    return [[row() for _ in range(groups)] for _ in range(contexts)]


def worst(values: list[list[F]]) -> F | float:
    """The worst ratio within any of the blocks."""
    found: F | float = F(1)
    for block in values:
        for v in block:
            for w in block:
                found = max(found, F(1) if v == w == 0 else float("inf") if w == 0 else v / w)
    return found


@pytest.mark.parametrize("floats", [False, True])
@settings(max_examples=150, deadline=None)
@given(table=tables(), g=st.lists(st.integers(0, 3), min_size=3, max_size=3))
def test_every_figure_is_that_of_fractions(floats: bool, table: list[list[list[str]]], g: list[int]) -> None:
    values: Any = np.array([[[float(F(v)) for v in row] for row in context] for context in table]) if floats else table
    law = Law.from_array(values)
    read = [[[F(v) for v in row] for row in context] for context in (values.tolist() if floats else values)]
    p = [[[v / sum(row) for v in row] for row in context] for context in read]
    n = len(p[0][0])
    mixed = [[sum(context[a][u] for context in p) / len(p) for u in range(n)] for a in range(len(p[0]))]
    utility = Utility({str(u): g[u] for u in range(n)}).on(law)

    def worth(row: list[F]) -> F:
        return sum((v * w for v, w in zip(row, g, strict=False)), F(0))

    def apart(rows: list[list[F]]) -> F:
        return max(sum(max(F(0), v - w) for v, w in zip(one, other, strict=True)) for one in rows for other in rows)

    local, overall = local_fairness(law, utility), global_fairness(law, utility)
    assert local is not None and local.ratio == worst([[worth(row) for row in context] for context in p])
    assert overall is not None and overall.ratio == worst([[worth(row) for row in mixed]])
    found, found_overall = local_supremum(law), global_supremum(law)
    assert found is not None and found.ratio == worst([[row[u] for row in context] for context in p for u in range(n)])
    assert found_overall is not None and found_overall.ratio == worst([[row[u] for row in mixed] for u in range(n)])
    odds, parity = equalized_odds(law), demographic_parity(law)
    assert odds is not None and odds.value == max(map(apart, p))
    assert parity is not None and parity.value == apart(mixed)
    listed = [[v // common for v in row] for row in law.mixed_rows for common in (gcd(*row),)]
    assert [[F(v, sum(row)) for v in row] for row in listed] == mixed


@settings(max_examples=100, deadline=None)
@given(table=tables(), floats=st.booleans())
def test_the_text_of_a_table_written_many_rows_at_a_time_is_that_of_each_row(floats: bool, table: list[list[list[str]]]) -> None:
    law = Law.from_array([[[float(F(v)) if floats else v for v in row] for row in context] for context in table])
    written = Table(law, Utility({"0": 1}).on(law))
    whole = canonical(written.header) + b"".join(map(canonical, written.rows()))
    assert b"".join(written.parts()) == whole
    assert written.sha256 and b"".join(written.parts()) == whole


def test_cells_share_no_denominator() -> None:
    """Rows over denominators that differ everywhere: figures are exact, and nothing is multiplied out over all rows."""
    primes = [n for n in range(10**6, 10**6 + 2_000) if all(n % d for d in range(2, 1_002))]
    cells = [(str(i // 2), "ab"[i % 2], prime) for i, prime in enumerate(primes[: len(primes) // 2 * 2])]
    table = {
        "x": [x for x, _, _ in cells for _ in "yn"],
        "a": [a for _, a, _ in cells for _ in "yn"],
        "u": ["y", "n"] * len(cells),
        "p": [text for _, _, prime in cells for text in (f"{prime // 3}/{prime}", f"{prime - prime // 3}/{prime}")],
    }
    law = Law.from_probabilities(table, decision="u", group="a", context="x", probability="p")
    assert law.weights.dtype == np.int64
    result = certify(law, {"y": 1}, confidence=None)
    means = [sum((F(prime // 3, prime) for _, a, prime in cells if a == group), F(0)) for group in "ab"]
    assert result.global_ is not None and result.global_.ratio == max(means) / min(means)
