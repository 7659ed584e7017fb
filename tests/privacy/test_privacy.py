"""Privacy of filters against brute force in fractions, closed forms, high-precision arithmetic and an independent library."""

from __future__ import annotations

import math
import unicodedata
from collections.abc import Sequence
from decimal import Decimal
from fractions import Fraction
from itertools import pairwise, product
from math import inf, prod
from pathlib import Path
from statistics import NormalDist
from typing import Any

import mpmath
import numpy as np
import pytest
from envelopes import result_of
from hypothesis import given, settings
from hypothesis import strategies as st

from fairaudit.cli import main
from fairaudit.errors import InputError
from fairaudit.model.mechanism import Constant, Identity, Mechanism, Product, RandomizedResponse
from fairaudit.model.mechanism_file import read_mechanism, read_mechanism_with_notes
from fairaudit.privacy import epsilon_delta, pair_table
from fairaudit.privacy.composition import compose
from fairaudit.privacy.epsilon_delta import approx_dp, delta, delta_at, exp_epsilon, pure_dp
from fairaudit.privacy.pair_table import per_pair
from fairaudit.privacy.pairs import PairLaw, hockey_stick, pair_law, pair_laws, power
from fairaudit.privacy.renyi_divergences import renyi, zcdp
from fairaudit.privacy.trade_offs import gdp, pair_trade_off, profile, trade_off

F = Fraction
KS = [F(1), F(11, 10), F(3, 2), F(7, 3), F(9)]
Rows = list[list[F]]


# Brute force: multiply the filter out and look at everything.


def rows_of(mechanism: Mechanism) -> Rows:
    return [[F(v, mechanism.denominator) for v in mechanism.row(a)] for a in mechanism.inputs]


def ratio_of(p: Sequence[F], q: Sequence[F]) -> Any:
    return max(x / y if y else inf for x, y in zip(p, q, strict=True) if x or y)


def hockey(p: Sequence[F], q: Sequence[F], k: F) -> F:
    """The greatest P(S) − kQ(S) over all sets S of outputs."""
    return max(
        sum((x - k * y for x, y, inside in zip(p, q, chosen, strict=True) if inside), F(0)) for chosen in product((0, 1), repeat=len(p))
    )


def pairs_of(rows: Rows) -> list[tuple[int, int]]:
    return [(i, j) for i in range(len(rows)) for j in range(len(rows)) if i != j]


def beta_of(points: Sequence[tuple[F, F]], alpha: F) -> F:
    """The lowest point at `alpha` of the convex hull of points, some of them on either side."""
    left = [v for v in points if v[0] <= alpha]
    right = [v for v in points if v[0] >= alpha]
    values = []
    for a1, b1 in left:
        for a2, b2 in right:
            values.append(min(b1, b2) if a1 == a2 else b1 + (b2 - b1) * (alpha - a1) / (a2 - a1))
    return min(values)


def all_tests(p: Sequence[F], q: Sequence[F]) -> list[tuple[F, F]]:
    """Error rates of every deterministic test; randomized tests are their convex hull."""
    points = []
    for chosen in product((0, 1), repeat=len(p)):
        alpha = sum((y for y, inside in zip(q, chosen, strict=True) if inside), F(0))
        points.append((alpha, 1 - sum((x for x, inside in zip(p, chosen, strict=True) if inside), F(0))))
    return points


@st.composite
def tables(draw: st.DrawFn, most: int = 4, zeros: bool = True) -> Mechanism:
    inputs, outputs = draw(st.integers(2, most)), draw(st.integers(1, most))
    rows = []
    for _ in range(inputs):
        weights = draw(st.lists(st.integers(0 if zeros else 1, 6), min_size=outputs, max_size=outputs).filter(any))
        rows.append([F(w, sum(weights)) for w in weights])
    return Mechanism.from_array(rows, [f"a{i}" for i in range(inputs)], [f"b{j}" for j in range(outputs)])


@st.composite
def responses(draw: st.DrawFn) -> Mechanism:
    return RandomizedResponse("abc"[: draw(st.integers(2, 3))], keep_probability=F(draw(st.integers(0, 10)), 10))


@st.composite
def mechanisms(draw: st.DrawFn, zeros: bool = True) -> Mechanism:
    if draw(st.booleans()):
        return draw(tables(zeros=zeros))
    parts = draw(st.lists(st.one_of(responses() if zeros else tables(2, False), tables(2, zeros)), min_size=2, max_size=3))
    return Product({f"c{i}": part for i, part in enumerate(parts)})


# Exact results


@given(mechanisms(), st.sampled_from(KS))
def test_pure_approximate_and_per_pair_are_those_of_the_multiplied_table(mechanism: Mechanism, k: F) -> None:
    rows = rows_of(mechanism)
    ratios = {(i, j): ratio_of(rows[i], rows[j]) for i, j in pairs_of(rows)}
    deltas = {(i, j): sum((max(F(0), x - k * y) for x, y in zip(rows[i], rows[j], strict=True)), F(0)) for i, j in ratios}
    assert exp_epsilon(mechanism) == max(ratios.values())
    assert delta(mechanism, k) == max(deltas.values())
    at = {a: i for i, a in enumerate(mechanism.inputs)}
    pure, approximate = pure_dp(mechanism), approx_dp(mechanism, k)
    assert pure.pair is not None
    assert approximate.pair is not None
    assert ratios[at[pure.pair[0]], at[pure.pair[1]]] == pure.exp_epsilon
    assert deltas[at[approximate.pair[0]], at[approximate.pair[1]]] == approximate.delta
    table = per_pair(mechanism, k)
    listed = list(table)
    assert len(table) == len(listed) == len(ratios)
    assert {(at[p.first], at[p.second]): (p.exp_epsilon, p.delta) for p in listed} == {key: (ratios[key], deltas[key]) for key in ratios}
    worst = table.top(1)[0]
    assert (worst.exp_epsilon, worst.delta) == max((ratios[key], deltas[key]) for key in ratios)
    assert table.at(worst.first, worst.second) == worst


@given(mechanisms(), st.sampled_from(KS))
def test_both_ways_to_evaluate_pairs_agree(mechanism: Mechanism, k: F) -> None:
    found = []
    for dense in (True, False):
        with pytest.MonkeyPatch.context() as patch:
            for module in (epsilon_delta, pair_table):
                patch.setattr(module, "worth_multiplying_out", lambda mechanism, dense=dense: dense)
            found.append((list(per_pair(mechanism, k)), approx_dp(mechanism, k).delta))
    assert found[0] == found[1]


def test_dense_tables_beyond_64_bits() -> None:
    big = 10**40
    mechanism = Mechanism.from_array([[F(i + 1, big), F(big - i - 1, big)] for i in range(5)], list("abcde"), ["yes", "no"])
    rows = rows_of(mechanism)
    for pair in per_pair(mechanism, F(11, 10)):
        i, j = mechanism.inputs.index(pair.first), mechanism.inputs.index(pair.second)
        assert pair.exp_epsilon == ratio_of(rows[i], rows[j])
        assert pair.delta == hockey(rows[i], rows[j], F(11, 10))


@given(tables())
@settings(max_examples=30)
def test_trade_off_is_the_hull_of_all_tests(mechanism: Mechanism) -> None:
    rows = rows_of(mechanism)
    curve = trade_off(mechanism)
    everything: list[tuple[F, F]] = []
    for i, j in pairs_of(rows):
        points = all_tests(rows[i], rows[j])
        everything += points
        law = pair_law(mechanism, mechanism.inputs[i], mechanism.inputs[j])
        for alpha in (F(0), F(1, 7), F(1, 2), F(9, 10), F(1)):
            assert pair_trade_off(law).beta(alpha) == beta_of(points, alpha)
            if alpha:
                assert power(law, alpha)[0] == 1 - beta_of(points, alpha)
        for k in KS:
            assert hockey_stick(law, k) == hockey(rows[i], rows[j], k)
    for alpha in (F(0), F(1, 7), F(1, 3), F(2, 3), F(1)):
        assert curve.beta(alpha) == beta_of(everything, alpha)
    for alpha, beta in curve.vertices[1:]:
        assert curve.beta(beta) <= alpha  # symmetric: the inverse of f is f
    slopes = [(b2 - b1) / (a2 - a1) for (a1, b1), (a2, b2) in pairwise(curve.vertices)]
    assert slopes == sorted(set(slopes))


@given(mechanisms())
def test_the_profile_is_exact_everywhere(mechanism: Mechanism) -> None:
    found = profile(mechanism)
    ks = [k for k, _ in found.vertices]
    for k in [*KS, *ks, *((a + b) / 2 for a, b in pairwise(ks)), ks[-1] + 5]:
        assert found.delta(k) == delta(mechanism, k)
    assert found.vertices[0][0] == 1
    worst = exp_epsilon(mechanism)
    assert (found.vertices[-1][1] == 0) == (worst != inf)
    if worst != inf:
        assert ks[-1] == worst


@given(mechanisms(), st.integers(0, 30))
def test_delta_at_encloses_from_above(mechanism: Mechanism, tenths: int) -> None:
    upper = delta_at(mechanism, F(tenths, 10))
    with mpmath.workdps(60):
        k = mpmath.exp(mpmath.mpf(tenths) / 10)
        rows = [[mpmath.mpf(v.numerator) / v.denominator for v in row] for row in rows_of(mechanism)]
        true = max(sum(max(mpmath.mpf(0), x - k * y) for x, y in zip(rows[i], rows[j], strict=True)) for i, j in pairs_of(rows))  # type: ignore[type-var]
        value = mpmath.mpf(upper.numerator) / upper.denominator
        assert true - mpmath.mpf(10) ** -50 <= value <= true + mpmath.mpf(2) ** -60


@given(st.lists(tables(3), min_size=2, max_size=3))
def test_epsilons_of_attributes_add_up(parts: list[Mechanism]) -> None:
    together = pure_dp(Product({f"c{i}": part for i, part in enumerate(parts)}))
    alone = [exp_epsilon(part) for part in parts]
    assert [a.exp_epsilon for a in together.attributes] == alone
    assert together.exp_epsilon == prod(alone)
    assert [a.column for a in together.attributes] == [f"c{i}" for i in range(len(parts))]


@given(st.lists(tables(2), min_size=2, max_size=2))
def test_attributes_of_a_table_over_several_columns(parts: list[Mechanism]) -> None:
    separate = Product({f"c{i}": part for i, part in enumerate(parts)})
    joint = Mechanism.from_array(rows_of(separate), separate.inputs, separate.outputs)
    assert [a.exp_epsilon for a in pure_dp(joint).attributes] == [a.exp_epsilon for a in pure_dp(separate).attributes]
    assert pure_dp(joint).exp_epsilon == pure_dp(separate).exp_epsilon


@pytest.mark.parametrize(("times", "expected"), [(1, F(7, 3)), (3, F(7, 3) ** 3), (6, F(7, 3) ** 6)])
def test_epsilon_of_binary_response(times: int, expected: F) -> None:
    coin = RandomizedResponse(["f", "m"], keep_probability="0.7")
    found = pure_dp(Product({str(i): coin for i in range(times)}))
    assert found.exp_epsilon == expected
    assert {a.exp_epsilon for a in found.attributes} == {F(7, 3)}
    low, high = found.epsilon
    assert low < high
    assert float(low) == pytest.approx(times * math.log(7 / 3), abs=1e-11)


def test_epsilon_of_seventy_fifteen_fifteen() -> None:
    assert exp_epsilon(RandomizedResponse("abc", keep_probability="0.7")) == F(14, 3)


def test_profile_of_binary_response_has_its_closed_form() -> None:
    coin = RandomizedResponse("ab", keep_probability="0.7")
    for k in KS:
        assert delta(coin, k) == max(F(0), F(7, 10) - k * F(3, 10))


def test_no_privacy_and_perfect_privacy() -> None:
    none, perfect = Identity("abc"), Constant("abc")
    assert exp_epsilon(none) == inf
    assert delta(none, 10**9) == 1
    assert trade_off(none).vertices == ((0, 0), (1, 0))
    assert gdp(none).mu == inf
    assert renyi(none, 2).epsilon == zcdp(none).rho == (Decimal("inf"), Decimal("inf"))
    assert exp_epsilon(perfect) == 1
    assert delta(perfect, 1) == 0
    assert trade_off(perfect).vertices == ((0, 1), (1, 0))
    assert gdp(perfect).mu == 0
    assert renyi(perfect, 2).epsilon[0] == 0
    assert renyi(perfect, 2).epsilon[1] < Decimal("1e-25")
    assert zcdp(perfect).rho == (0, 0)
    assert compose(perfect, 1000).delta(1) == 0
    assert compose(none, 1000).delta(2) == 1
    single = Constant(["a"])
    assert (exp_epsilon(single), delta(single, 1), pair_laws(single), list(per_pair(single))) == (1, 0, (), [])
    assert pure_dp(single).pair is None
    assert profile(single).delta(3) == 0


def test_twenty_attributes_have_few_kinds_of_pairs() -> None:
    coin = RandomizedResponse("abcd", keep_probability="0.7")
    many = Product({str(i): coin for i in range(20)})
    assert exp_epsilon(many) == 7**20
    assert len(pair_laws(many)) == 20
    assert 0 < delta(many, 7**10) < 1


def test_too_many_kinds_of_pairs_is_an_error() -> None:
    generator = np.random.default_rng(1)
    parts = {}
    for name in "abc":
        weights = generator.integers(1, 10**6, (12, 3)).tolist()
        parts[name] = Mechanism.from_array([[F(v, sum(row)) for v in row] for row in weights], range(12), range(3))
    mechanism = Product(parts)
    assert exp_epsilon(mechanism) == prod(exp_epsilon(part) for part in parts.values())
    with pytest.raises(InputError, match="kinds of ordered pairs"):
        pair_laws(mechanism)


@pytest.mark.parametrize("value", [0.5, "0.9", -1, "x", float("nan"), None])
def test_exp_epsilon_below_one_is_an_error(value: Any) -> None:
    coin = RandomizedResponse("ab", keep_probability="0.7")
    for call in (delta, per_pair, lambda m, k: profile(m).delta(k), lambda m, k: compose(m, 2).delta(k)):
        with pytest.raises(InputError):
            call(coin, value)


@pytest.mark.parametrize("call", [lambda m: delta_at(m, -1), lambda m: delta_at(m, "x"), lambda m: renyi(m, 1), lambda m: renyi(m, 10**7)])
def test_other_arguments_out_of_range(call: Any) -> None:
    with pytest.raises(InputError):
        call(RandomizedResponse("ab", keep_probability="0.7"))


@pytest.mark.parametrize("releases", [0, -1, 1.5, "2", True, 10**6])
def test_releases_out_of_range(releases: Any) -> None:
    with pytest.raises(InputError, match=r"releases is .*a whole number"):
        compose(RandomizedResponse("ab", keep_probability="0.7"), releases)


def test_alpha_out_of_range() -> None:
    with pytest.raises(InputError, match="false-positive rate"):
        trade_off(Identity("ab")).beta("1.5")


# Rényi, zCDP, GDP


def divergence(p: Sequence[F], q: Sequence[F], order: Any) -> Any:
    """Rényi divergence at 60 digits."""
    terms = [
        (mpmath.mpf(x.numerator) / x.denominator, mpmath.mpf(y.numerator) / y.denominator) for x, y in zip(p, q, strict=True) if x or y
    ]
    return mpmath.log(mpmath.fsum(x**order * y ** (1 - order) for x, y in terms)) / (order - 1)


def greatest(rows: Rows, order: Any) -> Any:
    return max(divergence(rows[i], rows[j], order) for i, j in pairs_of(rows))


def within(enclosure: tuple[Decimal, Decimal], value: Any, slack: float = 1e-50) -> bool:
    low, high = (mpmath.mpf(str(end)) for end in enclosure)
    return bool(low - slack <= value <= high + slack)


@given(mechanisms(zeros=False), st.sampled_from([F(101, 100), F(3, 2), F(2), F(5), F(64), F(201, 2)]))
@settings(max_examples=80)
def test_renyi_encloses_the_true_value(mechanism: Mechanism, order: F) -> None:
    found = renyi(mechanism, order)
    with mpmath.workdps(60):
        true = greatest(rows_of(mechanism), mpmath.mpf(order.numerator) / order.denominator)
        assert within(found.epsilon, true)
    assert found.epsilon[1] - found.epsilon[0] < Decimal("1e-15") * max(1, found.epsilon[1])


@given(mechanisms(), st.sampled_from([F(3, 2), F(2)]))
@settings(max_examples=60)
def test_renyi_is_infinite_exactly_where_supports_differ(mechanism: Mechanism, order: F) -> None:
    assert renyi(mechanism, order).epsilon[0].is_infinite() == (exp_epsilon(mechanism) == inf) == zcdp(mechanism).rho[1].is_infinite()


@pytest.mark.parametrize("scale", [10, 10**6])
def test_renyi_of_larger_tables(scale: int) -> None:
    generator = np.random.default_rng(scale)
    rows = []
    for _ in range(9):
        weights = generator.integers(1, scale, 7).tolist()
        rows.append([F(w, sum(weights)) for w in weights])
    mechanism = Mechanism.from_array(rows, range(9), range(7))
    with mpmath.workdps(60):
        for order in (F(5, 4), F(3), F(50), F(5001, 2)):
            true = greatest(rows, mpmath.mpf(order.numerator) / order.denominator)
            assert within(renyi(mechanism, order).epsilon, true)


@given(mechanisms(zeros=False))
@settings(max_examples=25)
def test_zcdp_encloses_the_supremum(mechanism: Mechanism) -> None:
    low, high = zcdp(mechanism).rho
    assert low <= high <= low * Decimal("1.0011")
    rows = rows_of(mechanism)
    with mpmath.workdps(30):
        densely = [1 + mpmath.mpf(10) ** (mpmath.mpf(t) / 8) for t in range(-40, 25)]
        best = max(greatest(rows, order) / order for order in densely)
        assert best <= mpmath.mpf(str(high)) * (1 + mpmath.mpf(10) ** -25) + mpmath.mpf(10) ** -25
        assert mpmath.mpf(str(low)) <= best * mpmath.mpf("1.02")


def test_zcdp_of_binary_response_is_below_the_general_bounds() -> None:
    for keep in ("0.51", "0.6", "0.9", "0.999999"):
        coin = RandomizedResponse("ab", keep_probability=keep)
        epsilon = pure_dp(coin).epsilon[1]
        assert zcdp(coin).rho[0] <= epsilon * epsilon / 2


def test_gdp_of_binary_response() -> None:
    for keep in ("0.6", "0.7", "0.99"):
        true = 2 * NormalDist().inv_cdf(float(keep))
        assert true <= gdp(RandomizedResponse("ab", keep_probability=keep)).mu <= true * (1 + 1e-8)


@given(mechanisms())
@settings(max_examples=60)
def test_gdp_curve_lies_just_below(mechanism: Mechanism) -> None:
    mu, curve = gdp(mechanism).mu, trade_off(mechanism)
    if mu == inf:
        assert curve.vertices[0][1] < 1
        return
    normal = NormalDist()
    gaps = []
    for step in range(1, 100):
        alpha = F(step, 100)
        gaps.append(float(curve.beta(alpha)) - normal.cdf(normal.inv_cdf(1 - step / 100) - mu))
    assert min(gaps) > -1e-9
    touching = [float(b) - normal.cdf(normal.inv_cdf(1 - float(a)) - mu) for a, b in curve.vertices[1:-1]]
    assert not touching or abs(min(touching, key=abs)) < 1e-8


def test_gdp_with_tails_beyond_floats() -> None:
    tiny = F(1, 10**400)
    assert 40 < gdp(Mechanism.from_array([[tiny, 1 - tiny], [1 - tiny, tiny]], "ab")).mu < 100


# Composition


def joint(p: Sequence[F], times: int) -> list[F]:
    return [prod(entries, start=F(1)) for entries in product(p, repeat=times)]


@given(tables(3), st.integers(1, 4))
@settings(max_examples=60)
def test_composition_is_that_of_the_joint_distribution(mechanism: Mechanism, times: int) -> None:
    rows = [joint(row, times) for row in rows_of(mechanism)]
    found = compose(mechanism, times, exact=True)
    bound = compose(mechanism, times, exact=False)
    assert found.exact
    assert found.exp_epsilon == max(ratio_of(rows[i], rows[j]) for i, j in pairs_of(rows))
    for k in KS:
        true = max(sum((max(F(0), x - k * y) for x, y in zip(rows[i], rows[j], strict=True)), F(0)) for i, j in pairs_of(rows))
        assert found.delta(k) == true
        assert true <= bound.delta(k) <= 1


@given(tables(3), st.sampled_from([5, 8, 13]))
@settings(max_examples=20)
def test_the_bound_on_a_composition_is_above_and_close(mechanism: Mechanism, times: int) -> None:
    exact, bound = compose(mechanism, times, exact=True), compose(mechanism, times, exact=False)
    for k in [*KS, F(50), F(1000)]:
        assert exact.delta(k) <= bound.delta(k) <= exact.delta(k) + F(1, 500)


def test_the_bound_for_many_releases_of_a_weak_response() -> None:
    coin = RandomizedResponse("ab", keep_probability="0.51")
    times = 400
    bound = compose(coin, times, exact=False)
    p = F(51, 100)
    for epsilon in ("0.5", "2", "4"):
        k = F(int(math.exp(float(epsilon)) * 1000), 1000)
        true = sum(
            math.comb(times, i) * max(F(0), p**i * (1 - p) ** (times - i) - k * p ** (times - i) * (1 - p) ** i) for i in range(times + 1)
        )
        assert true <= bound.delta(k) <= true * F(100001, 100000)
    assert compose(coin, 100_000).delta(10**6) < 1
    assert compose(coin, 5).delta(F(51, 49) ** 5) == 0


def test_many_undominated_pairs_are_bounded_by_their_hull() -> None:
    weights = np.random.default_rng(1).integers(1, 50, (8, 3)).tolist()
    mechanism = Mechanism.from_array([[F(w, sum(row)) for w in row] for row in weights], range(8), range(3))
    exact, bound = compose(mechanism, 2, exact=True), compose(mechanism, 2, exact=False)
    assert (len(exact.laws), len(bound.laws)) == (10, 1)
    for k in KS:
        assert exact.delta(k) <= bound.delta(k)


def test_extreme_ratios_compose() -> None:
    tiny = F(1, 10**300)
    mechanism = Mechanism.from_array([[tiny, 1 - tiny], [F(1, 2), F(1, 2)]], "ab")
    exact, bound = compose(mechanism, 3, exact=True), compose(mechanism, 3, exact=False)
    for k in KS:
        assert exact.delta(k) <= bound.delta(k) <= exact.delta(k) + F(1, 100)


# An independent library


@given(tables(4))
@settings(max_examples=25)
def test_agreement_with_dp_accounting_in_both_directions(mechanism: Mechanism) -> None:
    from dp_accounting.pld import privacy_loss_distribution as pld

    first, second = mechanism.inputs[:2]
    rows = rows_of(mechanism)[:2]
    for pair, (p, q) in (((first, second), rows), ((second, first), rows[::-1])):
        law = pair_law(mechanism, *pair)
        logs = [{j: math.log(v) for j, v in enumerate(row) if v} for row in (q, p)]
        # Its first argument is the distribution in the denominator; symmetric=True would report one direction only.
        theirs = pld.from_two_probability_mass_functions(logs[0], logs[1], symmetric=True, value_discretization_interval=1e-4)
        for epsilon in (0.0, 0.3, 1.0):
            ours = float(hockey_stick(law, F(math.exp(epsilon))))
            assert theirs.get_delta_for_epsilon(epsilon) == pytest.approx(ours, abs=1e-4)


def test_a_pair_has_two_directions() -> None:
    mechanism = Mechanism.from_array([["0.9", "0.1"], ["0.5", "0.5"]], "ab")
    assert pair_law(mechanism, "a", "b").columns[0] == (9, 5)
    assert [per_pair(mechanism, 1).at(*pair).exp_epsilon for pair in (("a", "b"), ("b", "a"))] == [F(9, 5), F(5)]
    assert exp_epsilon(mechanism) == 5


def test_a_pair_law_is_the_one_listed() -> None:
    mechanism = Mechanism.from_array([["0.9", "0.1"], ["0.5", "0.5"]], "ab")
    assert {law.columns for law in pair_laws(mechanism)} == {pair_law(mechanism, *pair).columns for pair in (("a", "b"), ("b", "a"))}
    assert all(isinstance(law, PairLaw) and law.denominator == sum(q for _, q in law.columns) for law in pair_laws(mechanism))


# Command line and files

SQUARE = ",a,b,c\na,0.7,0.15,0.15\nb,0.15,0.7,0.15\nc,0.15,0.15,0.7\n"
LONG = "input_n,input_s,output_n,probability\nx,f,x,1/3\nx,f,y,2/3\nx,m,y,1\ny,f,x,0.5\ny,f,y,0.5\n"


def write(folder: Path, text: str) -> str:
    path = folder / "filter.csv"
    path.write_text(text, encoding="utf-8")
    return str(path)


@pytest.mark.parametrize("corner", ["", '""', "true", '" "'])
@pytest.mark.parametrize("delimiter", [",", ";", "\t"])
def test_a_square_table(tmp_path: Path, corner: str, delimiter: str) -> None:
    text = corner + SQUARE.replace(",", delimiter)
    mechanism = read_mechanism(write(tmp_path, "\n" + text))
    assert mechanism.inputs == (("a",), ("b",), ("c",))
    assert mechanism.factors[0].mixing == (11, (3, 3, 3))
    assert mechanism.columns == (("true",) if corner == "true" else ())


def test_a_long_table(tmp_path: Path) -> None:
    mechanism = read_mechanism(write(tmp_path, LONG))
    assert mechanism.columns == ("input_n", "input_s")
    assert mechanism.probability(("x", "f"), "y") == F(2, 3)
    assert mechanism.probability(("x", "m"), "x") == 0
    named = write(tmp_path, LONG.replace("input_n", "n").replace("input_s", "s").replace("output_n", "o").replace("probability", "p"))
    assert read_mechanism(named, input=("n", "s"), output="o", probability="p").factors == mechanism.factors


def test_outputs_in_another_order_are_put_in_the_order_of_the_inputs(tmp_path: Path) -> None:
    mechanism = read_mechanism(write(tmp_path, "i,b,a\na,0.2,0.8\nb,0.7,0.3\n"))
    assert mechanism.probability("a", "a") == F(4, 5)
    assert mechanism.outputs == (("a",), ("b",))


def test_a_small_residue_is_normalised_and_reported(tmp_path: Path) -> None:
    mechanism, notes = read_mechanism_with_notes(write(tmp_path, "i,a,b\na,0.3333333,0.6666666\nb,0.5,0.5\n"))
    assert mechanism.probability("a", "a") == F(3333333, 9999999)
    assert notes == ("1 of 2 rows are off 1 by up to 1e-07 and were normalised exactly",)


BAD = {
    "empty": ("", "the file is empty"),
    "no rows": ("i,a,b\n", "no rows"),
    "ragged": ("i,a,b\nx,1\ny,1,0\n", "line 2 has 2 cells"),
    "sum": ("i,a,b\nx,0.5,0.5\ny,0.4,0.5\n", "line 3: the probabilities of the input 'y' sum to 9/10"),
    "negative": ("i,a,b\nx,-0.5,1.5\ny,1,0\n", "column 'a', line 2: '-0.5' is negative"),
    "text": ("i,a,b\nx,1,0\ny,1,zero\n", "column 'b', line 3: 'zero' is not a number"),
    "blank": ("i,a,b\nx,1,0\ny,1,\n", "column 'b', line 3: the probability is missing"),
    "nan": ("i,a,b\nx,nan,0\ny,1,0\n", "'nan' is not a number"),
    "division by zero": ("i,a,b\nx,1/0,0\ny,1,0\n", "divides by zero"),
    "huge exponent": ("i,a,b\nx,1e999999,0\ny,1,0\n", "exponent"),
    "one input": ("i,a,b\nx,1,0\n", "a single input"),
    "one column": ("a\nb\n", "has one column"),
    "repeated input": ("i,a,b\nx,1,0\nx,1,0\n", "line 3: the input 'x' has a row on line 2 already"),
    "repeated output": ("i,a,a\nx,1,0\ny,1,0\n", "occurs twice"),
    "missing label": ("i,a,b\n ,1,0\ny,1,0\n", "line 2: the label in the first column is missing"),
    "long, sum": ("input,output,probability\na,a,0.9\nb,b,1\n", "line 2: up to here the probabilities of the input 'a' sum to 9/10"),
    "long, repeated": (
        "input,output,probability\na,a,0.5\na,a,0.5\nb,b,1\n",
        "line 3: the output 'a' for the input 'a' has a row on line 2",
    ),
    "long, negative": ("input,output,probability\na,a,-1\na,b,2\nb,b,1\n", "column 'probability', line 2: '-1' is negative"),
    "long, text": ("input,output,probability\na,a,p\nb,b,1\n", "column 'probability', line 2: 'p' is not a number"),
    "long, one input": ("input,output,probability\na,a,1\n", "a single input"),
    "long, missing": ("input,output,probability\n,a,1\nb,b,1\n", "missing"),
    "binary": ("i,a\x00,b\nx,1,0\n", "NUL"),
}


@pytest.mark.parametrize("name", BAD)
def test_bad_files_are_one_sentence(tmp_path: Path, capsys: pytest.CaptureFixture[str], name: str) -> None:
    text, said = BAD[name]
    assert main(["privacy", write(tmp_path, text)]) == 2
    out, err = capsys.readouterr()
    assert out == ""
    assert said in err
    assert err.count("\n") == 1
    assert "filter.csv" in err


@pytest.mark.parametrize(
    ("options", "said"),
    [
        (["--delta-at", "-1"], "out of range"),
        (["--delta-at", "x"], "not a number"),
        (["--delta-at", "20000"], "out of range"),
        (["--exp-epsilon", "1/2"], "out of range"),
        (["--releases", "0"], "whole number"),
        (["--releases", "1e3"], "whole number"),
        (["--input", "nobody", "--output", "a"], "there is no column 'nobody'"),
        (["--probability", "p"], "no column was named for the input"),
        (["--input", "a", "--output", "a", "--probability", "b"], "used twice"),
    ],
)
def test_bad_options(tmp_path: Path, capsys: pytest.CaptureFixture[str], options: list[str], said: str) -> None:
    assert main(["privacy", write(tmp_path, SQUARE), *(f"{options[0]}={options[1]}", *options[2:])]) == 2
    assert said in capsys.readouterr().err


def test_a_missing_file(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["privacy", "nowhere.csv"]) == 2
    assert "there is no such file" in capsys.readouterr().err


def test_the_report(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["privacy", write(tmp_path, SQUARE), "--releases", "2"]) == 0
    out, err = capsys.readouterr()
    assert err == ""
    for part in ("e^ε = 14/3", "exactly 11/20", "2 releases of the same value", "δ (exact)", "3/20, 3/10", "not certified", "a from b"):
        assert part in out


def test_labels_cannot_steer_the_terminal(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    nasty = "\x1b[31m\u202e"
    text = f"input{nasty},inputs,output,probability\nx{nasty},1,x,1\ny,1,x,1/2\ny,1,z,1/2\n"
    assert main(["privacy", write(tmp_path, text)]) == 0
    out, _ = capsys.readouterr()
    assert all(c == "\n" or unicodedata.category(c) not in {"Cc", "Cf", "Cs", "Co", "Zl", "Zp"} for c in out)


def test_json(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["privacy", write(tmp_path, SQUARE), "--exp-epsilon", "1,7/3", "--releases", "3", "--format", "json"]) == 0
    found = result_of(capsys.readouterr().out)
    mechanism = RandomizedResponse("abc", keep_probability="0.7")
    assert found["exp_epsilon"] == "14/3"
    assert found["delta"] == [{"exp_epsilon": "1", "delta": "11/20"}, {"exp_epsilon": "7/3", "delta": str(delta(mechanism, "7/3"))}]
    assert found["releases"]["exp_epsilon"] == str(F(14, 3) ** 3)
    assert found["releases"]["exact"] is True
    assert found["releases"]["delta"][1]["delta"] == str(compose(mechanism, 3).delta("7/3"))
    assert [[F(v) for v in vertex] for vertex in found["trade_off"]] == [list(v) for v in trade_off(mechanism).vertices]
    assert found["gdp"]["certified"] is False


def test_json_of_no_privacy_and_of_many_releases(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["privacy", write(tmp_path, "i,a,b\na,1,0\nb,0,1\n"), "--format", "json"]) == 0
    found = result_of(capsys.readouterr().out)
    assert (found["exp_epsilon"], found["epsilon"], found["gdp"]["mu"]) == ("inf", ["inf", "inf"], "inf")
    assert main(["privacy", write(tmp_path, "i,a,b\na,0.501,0.499\nb,0.499,0.501\n"), "--releases", "20000", "--format", "json"]) == 0
    found = result_of(capsys.readouterr().out)
    assert found["releases"]["exact"] is False
    assert float(F(found["releases"]["epsilon"][0])) == pytest.approx(20000 * math.log(501 / 499))


def test_delta_at_a_given_epsilon_is_rounded_up(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["privacy", write(tmp_path, SQUARE), "--delta-at", "0.5", "--format", "json"]) == 0
    entry = result_of(capsys.readouterr().out)["delta"][0]
    upper = delta_at(RandomizedResponse("abc", keep_probability="0.7"), "0.5")
    assert entry["rounded_up"] is True
    assert upper <= F(entry["delta"]) <= upper + F(1, 10**20)
