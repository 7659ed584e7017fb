"""Filters: what they draw has exactly the probabilities that they state, sticky draws stay, and nothing unknown passes."""

from __future__ import annotations

import datetime
from collections import Counter
from fractions import Fraction
from typing import Any

import numpy as np
import pandas as pd
import pytest
import tiers
from hypothesis import given
from hypothesis import strategies as st
from scipy.stats import chi2

from fairaudit.errors import InputError
from fairaudit.exact.enclosures import compare_log, exp_enclosure
from fairaudit.model.mechanism import Constant, Factor, Identity, Mechanism, Product, RandomizedResponse
from fairaudit.privacy.epsilon_delta import exp_epsilon

F = Fraction
FALSE_ALARM = 1e-6
DRAWS = 1_000_000


def fits(counts: Counter[Any], probabilities: dict[Any, F], draws: int) -> bool:
    """Pearson's test at a false-alarm rate of 10^-6; an output of probability 0 must not occur."""
    possible = {b: p for b, p in probabilities.items() if p}
    if set(counts) - set(possible) or counts.total() != draws:
        return False
    if len(possible) == 1:
        return True
    statistic = sum((counts[b] - draws * float(p)) ** 2 / (draws * float(p)) for b, p in possible.items())
    return statistic <= float(chi2.isf(FALSE_ALARM, len(possible) - 1))


def row(mechanism: Mechanism, value: Any) -> dict[Any, F]:
    outputs = [b[0] if len(b) == 1 else b for b in mechanism.outputs]
    return dict(zip(outputs, (F(v, mechanism.denominator) for v in mechanism.row(value)), strict=True))


# Draws


@pytest.mark.parametrize(
    ("mechanism", "value"),
    [
        (RandomizedResponse("abc", keep_probability="0.7"), "a"),
        (RandomizedResponse("abcd", epsilon="0.5"), "c"),
        (Mechanism.from_array([["1/7", "2/7", "4/7", 0], [0, 0, "1/3", "2/3"]], "ab", "wxyz"), "b"),
        (Product({"x": RandomizedResponse("ab", keep_probability="0.9"), "y": Constant("cd")}), ("b", "d")),
    ],
)
def test_a_million_draws_have_the_stated_probabilities(mechanism: Mechanism, value: Any) -> None:
    """Chi-square at a false-alarm rate of 10^-6 for each case."""
    counts = Counter(mechanism.release_all([value] * DRAWS))
    assert fits(counts, row(mechanism, value), DRAWS)


def test_the_chi_square_test_notices_a_wrong_probability() -> None:
    counts = Counter(RandomizedResponse("ab", keep_probability="0.705").release_all(["a"] * DRAWS))
    assert not fits(counts, row(RandomizedResponse("ab", keep_probability="0.7"), "a"), DRAWS)


def test_sticky_and_fresh_releases_mixed() -> None:
    """Sticky draws never change and fresh ones keep their distribution: 200,000 releases, two million with FAIRAUDIT_FULL=1."""
    draws = 1_000_000 if tiers.FULL else 100_000
    mechanism = RandomizedResponse("abc", keep_probability="0.7")
    store: dict[Any, Any] = {}
    first: dict[int, Any] = {}
    fresh: Counter[Any] = Counter()
    people = draws // 5
    for n in range(draws):
        subject = n % people
        released = mechanism.release("a", subject=subject, attribute="letter", store=store)
        assert first.setdefault(subject, released) == released
        fresh[mechanism.release("a")] += 1
    assert len(store) == people
    assert fits(fresh, row(mechanism, "a"), draws)
    assert fits(Counter(store.values()), row(mechanism, "a"), people)


def test_a_sticky_release_stays_when_the_value_changes() -> None:
    mechanism, store = RandomizedResponse(range(1000), keep_probability="0.001"), {}
    kept = mechanism.release(3, subject="Ada", attribute="place", store=store)
    assert {mechanism.release(n, subject="Ada", attribute="place", store=store) for n in range(100)} == {kept}
    assert store == {mechanism.release_key("Ada", "place"): kept}


def test_sticky_release_errors() -> None:
    mechanism = Identity("ab")
    with pytest.raises(InputError, match="needs a store"):
        mechanism.release("a", subject=1)
    with pytest.raises(InputError, match="does not know the value 'z'"):
        mechanism.release("z", subject=1, attribute="letter", store={})
    with pytest.raises(InputError, match="does not know the value 'z'"):
        mechanism.release("a", subject=1, attribute="letter", store={mechanism.release_key(1, "letter"): "z"})
    with pytest.raises(InputError, match="needs to know what it releases"):
        mechanism.release("a", subject=1, store={})
    with pytest.raises(InputError, match="belong to a sticky release"):
        mechanism.release("a", store={})
    for subject in (True, 1.5, None, ("Ada", "B"), "", " ", "\ud800"):
        with pytest.raises(InputError, match=r"accepted|empty|Unicode|belong"):
            mechanism.release("a", subject=subject, attribute="letter", store={})  # type: ignore[arg-type]


@pytest.mark.parametrize("value", ["z", "", None, 1, ("a", "b"), ("a",) * 3, (), float("nan")])
def test_an_unknown_value_is_never_released(value: Any) -> None:
    mechanism = Identity("ab")
    calls: list[Any] = [mechanism.release, mechanism.row, mechanism.locate, lambda v: mechanism.release_all([v])]
    calls += [lambda v: mechanism.probability(v, "a"), lambda v: mechanism.probability("a", v)]
    calls.append(lambda v: mechanism.release_for_simulation([v], np.random.default_rng(1)))
    for call in calls:
        with pytest.raises(InputError):
            call(value)


@pytest.mark.parametrize("value", [["a"], {"a": 1}, b"a", object()])
def test_a_value_that_is_no_label_is_an_error(value: Any) -> None:
    with pytest.raises(InputError):
        Identity("ab").release(value)


def test_values_of_other_types_are_their_text() -> None:
    day = datetime.date(2024, 2, 29)
    mechanism = Identity([1, True, 2.5, day, np.int64(7)])
    assert [mechanism.release(v) for v in (1, "1", True, 2.5, day, 7, np.float64(2.5))] == [
        "1",
        "1",
        "true",
        "2.5",
        "2024-02-29",
        "7",
        "2.5",
    ]


def test_a_tuple_of_another_length_is_an_error() -> None:
    both = Product({"x": Identity("ab"), "y": Identity("cd")})
    for value in (("a",), ("a", "c", "a"), "a", ("a", "a"), ("c", "a")):
        with pytest.raises(InputError):
            both.release(value)
    assert both.release(("a", "d")) == ("a", "d")
    assert both.locate(("b", "c")) == (1, 0)


def test_simulation_is_reproducible_and_exact() -> None:
    mechanism = RandomizedResponse("abc", keep_probability="0.7")
    values = ["a", "b", "c"] * 1000
    draws = [mechanism.release_for_simulation(values, np.random.default_rng(seed)) for seed in (1, 1, 2)]
    assert draws[0] == draws[1] != draws[2]
    counts = Counter(mechanism.release_for_simulation(["b"] * 200_000, np.random.default_rng(3)))
    assert fits(counts, row(mechanism, "b"), 200_000)
    wide = Mechanism.from_array([[F(1, 3**60), 1 - F(1, 3**60)], [F(1, 3), F(2, 3)]], "ab")
    counts = Counter(wide.release_for_simulation(["b"] * 200_000, np.random.default_rng(3)))
    assert fits(counts, row(wide, "b"), 200_000)


# Randomized response


@given(st.integers(2, 40), st.fractions(0, 60))
def test_response_from_epsilon_is_rounded_to_the_safe_side(k: int, epsilon: F) -> None:
    """e^ε of the filter is at most the one asked for, exactly, and less by at most a relative 1e-12."""
    realised = exp_epsilon(RandomizedResponse(range(k), epsilon=epsilon))
    assert isinstance(realised, Fraction)
    assert compare_log(realised.as_integer_ratio(), epsilon.as_integer_ratio()) <= 0
    low, _ = exp_enclosure(epsilon.as_integer_ratio(), 64)
    assert realised * (1 + F(1, 10**12)) >= F(low, 1 << 64)


def test_response_from_epsilon_at_the_ends() -> None:
    assert exp_epsilon(RandomizedResponse("abc", epsilon=0)) == 1
    strong = exp_epsilon(RandomizedResponse("abc", epsilon=1000))
    assert isinstance(strong, Fraction)
    assert compare_log(strong.as_integer_ratio(), (1000, 1)) == -1
    assert compare_log(strong.as_integer_ratio(), (1000 * 10**12 - 1, 10**12)) == 1


@given(st.integers(2, 8), st.fractions(0, 1))
def test_response_from_keep_probability(k: int, keep: F) -> None:
    mechanism = RandomizedResponse(range(k), keep_probability=keep)
    lie = (1 - keep) / (k - 1)
    assert mechanism.probability(0, 0) == keep
    assert {mechanism.probability(0, j) for j in range(1, k)} == {lie}
    high, low = max(keep, lie), min(keep, lie)
    assert exp_epsilon(mechanism) == (high / low if low else float("inf"))


@given(st.integers(2, 8), st.fractions(1, 100))
def test_response_from_exp_epsilon_is_exact(k: int, factor: F) -> None:
    assert exp_epsilon(RandomizedResponse(range(k), exp_epsilon=factor)) == factor


def test_below_one_kth_the_truth_is_the_least_likely() -> None:
    mechanism = RandomizedResponse("abc", keep_probability="0.2")
    assert exp_epsilon(mechanism) == F(4, 10) / F(2, 10)
    assert mechanism.factors[0].mixing == (-1, (2, 2, 2))


@pytest.mark.parametrize(
    ("given_", "said"),
    [
        ({"keep_probability": "-0.1"}, "at least 0"),
        ({"keep_probability": "1.1"}, "from 0 to 1"),
        ({"keep_probability": float("nan")}, "not a finite number"),
        ({"keep_probability": True}, "truth value"),
        ({"epsilon": "-1"}, "at least 0"),
        ({"epsilon": float("inf")}, "not a finite number"),
        ({"epsilon": 20_000}, "10,000"),
        ({"exp_epsilon": "0.99"}, "at least 1"),
        ({"exp_epsilon": "e"}, "not a number"),
        ({}, "nothing was given"),
        ({"epsilon": 1, "exp_epsilon": 2}, "give one of"),
    ],
)
def test_response_parameters_out_of_range(given_: dict[str, Any], said: str) -> None:
    with pytest.raises(InputError, match=said):
        RandomizedResponse("ab", **given_)


@pytest.mark.parametrize(
    ("values", "said"),
    [(["a"], "at least two"), ([], "no values"), (["a", "a"], "different"), ([1, "1"], "different"), (["a", None], "missing")],
)
def test_response_alphabets(values: list[Any], said: str) -> None:
    with pytest.raises(InputError, match=said):
        RandomizedResponse(values, keep_probability="0.5")


def test_labels_of_different_widths_are_an_error() -> None:
    with pytest.raises(InputError, match="different numbers of parts"):
        Identity([("a", "b"), "c"])


# Tables


@pytest.mark.parametrize(
    ("rows", "said"),
    [
        ([[0.5, 0.4], [1, 0]], "row of 'a' sums to 0.9"),
        ([[1.5, -0.5], [1, 0]], "negative"),
        ([[1, 0]], "shape"),
        ([[1, 0, 0], [0, 1, 0]], "shape"),
        ([[1], [1, 0]], "shape"),
        ([1, 0], "shape"),
        ([[0, 0], [1, 0]], "sums to 0"),
        ([["x", 1], [1, 0]], "not a number"),
        ([[None, 1], [1, 0]], "not a number"),
        ([[float("nan"), 1], [1, 0]], "not a finite number"),
    ],
)
def test_tables_that_are_not_stochastic(rows: Any, said: str) -> None:
    with pytest.raises(InputError, match=said):
        Mechanism.from_array(rows, "ab")


def test_a_small_residue_is_normalised_exactly() -> None:
    third = 1 / 3
    mechanism = Mechanism.from_array([[third, third, third], [0.5, 0.5, 0]], "ab", "xyz")
    assert [mechanism.probability("a", b) for b in "xyz"] == [F(1, 3)] * 3
    assert mechanism.denominator == 6


def test_from_table() -> None:
    frame = pd.DataFrame({"in": ["a", "a", "b"], "out": ["b", "a", "b"], "p": ["1/4", "3/4", 1]})
    mechanism = Mechanism.from_table(frame, input="in", output="out", probability="p")
    assert mechanism.outputs == mechanism.inputs == (("a",), ("b",))
    assert mechanism.probability("b", "a") == 0
    assert mechanism.factors[0].mixing is not None
    with pytest.raises(InputError, match="was given before"):
        Mechanism.from_table(pd.concat([frame, frame]), input="in", output="out", probability="p")
    with pytest.raises(InputError, match="there is no column 'q'"):
        Mechanism.from_table(frame, input="in", output="out", probability="q")
    with pytest.raises(InputError, match="negative"):
        Mechanism.from_table(frame.assign(p=[-1.0, 2.0, 1.0]), input="in", output="out", probability="p")


def test_outputs_may_have_another_number_of_columns() -> None:
    table = {"name": ["x", "x", "y"], "age": ["1", "2", "1"], "out": ["r", "r", "s"], "p": [1, 1, 1]}
    mechanism = Mechanism.from_table(table, input=("name", "age"), output="out", probability="p")
    assert mechanism.probability(("y", "1"), "s") == 1
    assert mechanism.release(("x", "2")) == "r"
    assert mechanism.release(("x", "2"), subject=1, attribute="pair", store={mechanism.release_key(1, "pair"): "s"}) == "s"
    reverse = Mechanism.from_array([[1, 0], ["1/2", "1/2"]], "ab", [("p", "q"), ("p", "r")])
    assert reverse.probability("b", ("p", "r")) == F(1, 2)
    assert reverse.release("a", subject=1, attribute="b", store={reverse.release_key(1, "b"): ("p", "r")}) == ("p", "r")


@given(st.lists(st.lists(st.integers(0, 5), min_size=3, max_size=3).filter(any), min_size=3, max_size=3))
def test_mixing_is_found_exactly_where_it_is(weights: list[list[int]]) -> None:
    mechanism = Mechanism.from_array([[F(w, sum(line)) for w in line] for line in weights], "abc")
    factor = mechanism.factors[0]
    possible = (
        all(factor.rows[i][j] == factor.rows[k][j] for j in range(3) for i in range(3) for k in range(3) if j not in (i, k))
        and len({factor.rows[i][i] - factor.rows[(i + 1) % 3][i] for i in range(3)}) == 1
    )
    assert (factor.mixing is not None) == possible
    if factor.mixing is not None:
        diagonal, base = factor.mixing
        assert factor.rows == tuple(tuple(base[j] + diagonal * (i == j) for j in range(3)) for i in range(3))


def test_mixing_of_the_named_filters() -> None:
    assert Identity("abc").factors[0].mixing == (1, (0, 0, 0))
    assert Constant("abc", "b").factors[0].mixing == (0, (0, 1, 0))
    assert Constant("a").factors[0].mixing == (0, (1,))
    assert Factor((("a",), ("b",)), (("b",), ("a",)), ((1, 0), (0, 1)), 1).mixing is None


# Products and constants


def test_a_product_multiplies() -> None:
    parts = {"x": RandomizedResponse("ab", keep_probability="0.7"), "y": Mechanism.from_array([["1/3", "2/3", 0], [0, 0, 1]], "ab", "rst")}
    both = Product(parts)
    assert both.columns == ("x", "y")
    assert (both.width, both.denominator) == (2, 30)
    for a in both.inputs:
        assert sum(both.row(a)) == both.denominator
        for b in both.outputs:
            assert both.probability(a, b) == parts["x"].probability(a[0], b[0]) * parts["y"].probability(a[1], b[1])
            assert F(both.row(a)[both.outputs.index(b)], both.denominator) == both.probability(a, b)


def test_products_that_are_not_accepted() -> None:
    with pytest.raises(InputError, match="at least one"):
        Product({})
    with pytest.raises(InputError, match="covers 2 columns"):
        Product({"x": Product({"y": Identity("ab"), "z": Identity("ab")})})


def test_constant() -> None:
    assert Constant("ab").probability("a", "b") == F(1, 2)
    biased = Constant("ab", {"a": "1/3", "b": "2/3"})
    assert [biased.probability(a, "b") for a in "ab"] == [F(2, 3)] * 2
    assert exp_epsilon(biased) == 1
    for output, said in (
        ("z", "not among the values"),
        ({"a": "1/3"}, "sums to"),
        ({}, "sums to"),
        ({"a": 2, "b": -1}, "negative"),
        (None, ""),
    ):
        if output is not None:
            with pytest.raises(InputError, match=said):
                Constant("ab", output)
