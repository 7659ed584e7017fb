"""T3: a utility that ignores the group, with a floor: power at level t, in every currency of privacy."""

from __future__ import annotations

from fractions import Fraction
from itertools import permutations
from math import inf, log
from random import Random

import mpmath
import pytest
import tiers
from theorem_oracle import (
    F,
    at,
    best_over_pairs,
    best_ratio,
    curve,
    deployments,
    maximize,
    most_power,
    proved,
    pure,
    random_filter,
    random_row,
    ratio,
    response_rows,
    stick,
    table_filter,
    worst_stick,
)

from fairaudit.errors import InputError
from fairaudit.exact.enclosures import log_enclosure
from fairaudit.model.mechanism import Identity, RandomizedResponse
from fairaudit.theorems.t01 import t1
from fairaudit.theorems.t03 import t3_approx, t3_curve, t3_general, t3_mechanism, t3_randomized_response
from fairaudit.theorems.t03_currencies import t3_gdp, t3_renyi, t3_zcdp


def log_up(value: Fraction) -> Fraction:
    return F(log_enclosure((value.numerator, value.denominator))[1])


@pytest.mark.parametrize("uses", ["context", "decision"])
def test_no_deployment_exceeds_any_of_the_forms(uses: str) -> None:
    seen = 0
    for rng, d in deployments(250, uses=uses):
        if not d.floor:
            continue
        seen += 1
        t = d.floor / d.gamma
        exact = t3_mechanism(d.mechanism, t)
        assert d.local <= exact.value <= 1 / t
        assert exact.value == max((most_power(p, q, t) / t for p, q in permutations(d.rows_a, 2)), default=F(1))
        assert proved(exact, d.rows_a, lambda p, q, k, t=t: k + stick(p, q, k) / t)
        k = rng.choice([F(1), F(5, 4), F(2), F(3)])
        approximate = t3_approx(k, worst_stick(d.rows_a, k), t)
        assert exact.value <= approximate.value
        assert proved(approximate, d.rows_a, lambda p, q, k, t=t: k + stick(p, q, k) / t)
        e = pure(d.rows_a)
        assert exact.value <= t3_approx(e, 0, t).value
        if e != inf and e > 1:
            epsilon = log_up(e)
            assert exact.value <= t3_zcdp(epsilon**2 / 2, t).value
            mu = 2 * mpmath.sqrt(2) * mpmath.erfinv(2 * float(e / (1 + e)) - 1) * 1.0000001
            assert exact.value <= t3_gdp(float(mu), t).value
            squares = max(sum(v * v / w for v, w in zip(p, q, strict=True) if w) for p, q in permutations(d.rows_a, 2))
            assert exact.value <= t3_renyi(2, log_up(squares) if squares > 1 else 0, t).value
    assert tiers.enough(seen > 80)


# Known mechanisms: equal to the best policy


@pytest.mark.parametrize("k", range(2, 9))
def test_randomized_response_equals_the_best_policy_in_every_regime(k: int) -> None:
    for keep in (F(1, k), F(1, k) + F(1, 10), F(3, 4), F(1)):
        rows, mechanism = response_rows(k, keep), RandomizedResponse(list(range(k)), keep_probability=keep)
        lie = (1 - keep) / (k - 1)
        levels = {lie / 2, lie, (lie + 1 - keep) / 2, 1 - keep, 1 - keep / 2, F(1)} - {F(0)}
        for t in sorted(level for level in levels if level <= 1):
            closed = t3_randomized_response(k, keep, t)
            assert closed.value == t3_mechanism(mechanism, t).value
            # By symmetry one ordered pair stands for all, but every group keeps the floor.
            assert closed.value == best_ratio(rows, F(0), F(1), t, (0, 1))
            assert proved(closed, rows, lambda p, q, c, t=t: c + stick(p, q, c) / t)


def test_below_one_in_k_the_closed_form_would_be_too_low_and_is_refused() -> None:
    """Truth 1/10, each of two lies 9/20: at level 1/10 + … the closed form says less than the best policy reaches."""
    keep, k, t = F(1, 10), 3, F(3, 10)
    lie = (1 - keep) / (k - 1)
    naive = 1 + (keep - lie) / t
    reached = best_over_pairs(response_rows(k, keep), F(0), F(1), t)
    assert reached == t3_mechanism(RandomizedResponse(list(range(k)), keep_probability=keep), t).value
    assert reached > 1 > naive
    with pytest.raises(InputError, match="below 1/3"):
        t3_randomized_response(k, keep, t)


def test_any_mechanism_equals_the_best_policy_even_when_every_group_keeps_the_floor() -> None:
    rng = Random(tiers.fresh("exact"))
    for _ in range(60):
        rows, mechanism = random_filter(rng)
        t = F(rng.randint(1, 10), 10)
        assert t3_mechanism(mechanism, t).value == best_over_pairs(rows, F(0), F(1), t)


def test_a_single_pair_alone_can_be_lower_than_its_power() -> None:
    """Three groups: the pair's best test leaves the third below the floor, so the value of that pair needs the linear program."""
    rows = [[F(1, 2), F(1, 2), F(0)], [F(1, 4), F(1, 2), F(1, 4)], [F(0), F(0), F(1)]]
    t = F(1, 4)
    alone, together = best_ratio(rows, F(0), F(1), t, (0, 1), everyone=False), best_ratio(rows, F(0), F(1), t, (0, 1))
    assert alone == most_power(rows[0], rows[1], t) / t
    assert together < alone


# (ε,δ)


@pytest.mark.parametrize(("e", "delta"), [(F(2), F(0)), (F(2), F(1, 20)), (F(1), F(1, 5)), (F(9, 2), F(1, 10)), (F(3), F(1))])
def test_epsilon_and_delta_are_attained_in_each_of_the_three_terms(e: Fraction, delta: Fraction) -> None:
    rest = 1 - delta
    p = [delta, rest * e / (1 + e), rest / (1 + e), F(0)]
    rows = [p, p[::-1]]
    assert worst_stick(rows, e) <= delta
    used = set()
    for t in (F(1, 100), F(1, 20), F(1, 5), F(1, 3), F(1, 2), F(2, 3), F(9, 10), F(99, 100), F(1)):
        bound = t3_approx(e, delta, t)
        assert bound.value == best_over_pairs(rows, F(0), F(1), t) == t3_mechanism(table_filter(rows), t).value
        assert bound.value == min(1 / t, e + delta / t, (1 - (1 - delta - t) / e) / t)
        used.add(bound.multipliers[0])
    if 0 < delta < 1 < e:
        assert used == {F(0), e, 1 / e}


def test_no_privacy_leaves_the_cap() -> None:
    assert t3_approx(inf, 0, "0.25").value == 4
    assert t3_mechanism(Identity(["a", "b"]), "0.25").value == 4


# Trade-off curves


def lines(rows: list[list[Fraction]], slopes: list[Fraction]) -> list[tuple[Fraction, Fraction]]:
    """The greatest of the lines 1 − H_k − kα, k among the slopes, with H_k the worst over ordered pairs: below every trade-off function."""
    parts = [(1 - worst_stick(rows, k), k) for k in slopes] + [(F(0), F(0))]
    crossings = {F(0), F(1)}
    for (c, k), (d, m) in permutations(parts, 2):
        if k != m and 0 < (c - d) / (k - m) < 1:
            crossings.add((c - d) / (k - m))
    return [(x, max(c - k * x for c, k in parts)) for x in sorted(crossings)]


def test_a_curve_below_both_orders_is_sound_and_its_symmetric_form_is_sharper() -> None:
    rng, sharper = Random(tiers.fresh("curves")), 0
    for _ in range(150):
        rows, _ = random_filter(rng)
        f = lines(rows, [rng.choice([F(1, 3), F(1, 2), F(1), F(3, 2), F(2), F(4)]) for _ in range(2)])
        t = F(rng.randint(1, 10), 10)
        bound = t3_curve(f, t, orders="both")
        reached = max((most_power(p, q, t) / t for p, q in permutations(rows, 2)), default=F(1))
        assert reached <= bound.value <= (1 - at(f, t)) / t
        sharper += bound.value < (1 - at(f, t)) / t
        assert proved(bound, rows, lambda p, q, k, t=t: k + stick(p, q, k) / t)
    assert tiers.enough(sharper > 10)


def test_the_curve_of_one_ordered_pair_needs_the_other_order_too() -> None:
    rng, wrong = Random(tiers.fresh("one order")), 0
    for _ in range(150):
        size = rng.randint(1, 4)
        p, q = random_row(rng, size), random_row(rng, size)
        t = F(rng.randint(1, 10), 10)
        f = curve(p, q)
        bound = t3_curve(f, t, orders="one")
        reached = max(most_power(p, q, t), most_power(q, p, t)) / t
        assert bound.value == reached == best_over_pairs([p, q], F(0), F(1), t)
        wrong += (1 - at(f, t)) / t < reached
        wrong_max = t3_curve(f, t, orders="both").value
        assert wrong_max <= reached
        assert proved(bound, [p, q], lambda v, w, k, t=t: k + stick(v, w, k) / t)
    assert tiers.enough(wrong > 20)


def test_reading_one_order_of_a_lopsided_pair_as_both_would_prove_too_much() -> None:
    """P = (1, 0), Q = (1/2, 1/2): at t = 1/2 the order Q, P gives 1, the order P, Q gives 2."""
    p, q, t = [F(1), F(0)], [F(1, 2), F(1, 2)], F(1, 2)
    f = curve(q, p)
    assert (1 - at(f, t)) / t == F(3, 2)
    assert t3_curve(f, t, orders="one").value == best_over_pairs([p, q], F(0), F(1), t) == 2


@pytest.mark.parametrize(
    "vertices",
    [
        [(0, 1)],
        [(0, 1), (1, "0.1")],
        [("0.1", 1), (1, 0)],
        [(0, 1), ("0.5", "0.6"), (1, 0)],
        [(0, "0.5"), ("0.5", "0.4"), (1, 0)],
        [(0, "0.5"), ("0.2", "0.6"), (1, 0)],
        [(0, 1), (0, "0.5"), (1, 0)],
        [(0, 2), (1, 0)],
    ],
)
def test_what_is_no_trade_off_function_is_refused(vertices: list[tuple[object, object]]) -> None:
    with pytest.raises(InputError):
        t3_curve(vertices, "0.5", orders="both")


# Gaussian, Rényi, zero-concentrated


@pytest.mark.parametrize("t", ["7e-324", "1e-280", "1e-9", "0.001", "0.1", "0.5", "0.9", "0.999999", 1])
@pytest.mark.parametrize("mu", ["0.001", "0.3", 1, 4, 30])
def test_the_gaussian_form_is_rounded_up_and_close(mu: object, t: object) -> None:
    bound = t3_gdp(mu, t)
    with mpmath.workdps(60):
        level, shift = mpmath.mpf(str(t)), mpmath.mpf(str(mu))
        if level == 1:
            assert bound.value == 1
            return
        below = mpmath.findroot(lambda z: mpmath.log(mpmath.ncdf(z)) - mpmath.log(level), float(mpmath_start(level)))
        exact = mpmath.ncdf(below + shift) / level
        value = mpmath.mpf(bound.value.numerator) / bound.value.denominator
        assert exact <= value <= (exact * (1 + mpmath.mpf(10) ** -9) if level > 1e-290 else 1 / level)
    assert not bound.certified


def mpmath_start(level: mpmath.mpf) -> float:
    from statistics import NormalDist

    return NormalDist().inv_cdf(float(level))


@pytest.mark.parametrize("t", ["1e-30", "0.01", "0.3", "0.5", "0.9", "0.9999", 1])
@pytest.mark.parametrize(("order", "rho"), [("1.01", "0.1"), (2, "0.001"), (2, 0), (3, 1), ("50", "0.2"), (2, 20000)])
def test_the_renyi_form_encloses_the_formula_from_above(order: object, rho: object, t: object) -> None:
    bound = t3_renyi(order, rho, t)
    with mpmath.workdps(80):
        a, r, level = (mpmath.mpf(str(v)) for v in (order, rho, t))
        terms = [1 / level, mpmath.exp((a - 1) * r / a) * level ** (-1 / a), (1 - mpmath.exp(-r) * (1 - level) ** (a / (a - 1))) / level]
        exact = mpmath.mpf(1) if r == 0 else min(terms)
        value = mpmath.mpf(bound.value.numerator) / bound.value.denominator
        assert exact <= value * (1 + mpmath.mpf(10) ** -70)
        assert value <= exact * (1 + mpmath.mpf(10) ** -10) + mpmath.mpf(10) ** -10 / level * (r > 0)
    assert not bound.certified


@pytest.mark.parametrize("t", ["1e-30", "0.01", "0.3", "0.5", "0.9", "0.9999", 1])
@pytest.mark.parametrize("rho", ["0.0001", "0.1", 1, 5, 0, 20000])
def test_the_concentrated_form_encloses_the_formula_from_above(rho: object, t: object) -> None:
    bound = t3_zcdp(rho, t)
    with mpmath.workdps(80):
        r, level = mpmath.mpf(str(rho)), mpmath.mpf(str(t))
        depth = -mpmath.log(level)
        terms = [1 / level]
        if r < depth:
            terms.append(mpmath.exp(2 * mpmath.sqrt(r * depth) - r))
        if level < 1:
            terms.append((1 - mpmath.exp(-((mpmath.sqrt(r) + mpmath.sqrt(-mpmath.log(1 - level))) ** 2))) / level)
        exact = mpmath.mpf(1) if r == 0 else min(terms)
        value = mpmath.mpf(bound.value.numerator) / bound.value.denominator
        assert exact <= value * (1 + mpmath.mpf(10) ** -70)
        assert value <= exact * (1 + mpmath.mpf(10) ** -9) + mpmath.mpf(10) ** -9 / level * (r > 0)


def test_the_divergences_bound_real_filters() -> None:
    rng = Random(tiers.fresh("divergences"))
    for _ in range(80):
        size = rng.randint(2, 4)
        rows = [random_row(rng, size, zeros=False) for _ in range(rng.randint(2, 3))]
        t = F(rng.randint(1, 19), 20)
        reached = max(most_power(p, q, t) / t for p, q in permutations(rows, 2))
        for order in (2, 3, 5):
            sums = max(sum(v**order / w ** (order - 1) for v, w in zip(p, q, strict=True)) for p, q in permutations(rows, 2))
            rho = log_up(sums) / (order - 1) if sums > 1 else F(0)
            assert reached <= t3_renyi(order, rho, t).value
        # ρ = sup D_α/α; on a fine grid of orders, with a margin.
        rho = max(
            log(sum(float(v) ** a * float(w) ** (1 - a) for v, w in zip(p, q, strict=True))) / (a - 1) / a
            for p, q in permutations(rows, 2)
            for a in [1 + 1.15**i / 1000 for i in range(80)]
        )
        assert reached <= t3_zcdp(max(rho, 0.0) * 1.01 + 1e-6, t).value


# Utilities of the group


def test_the_general_form_holds_beats_t1_and_is_proved_by_its_multipliers() -> None:
    seen = 0
    for _, d in deployments(300):
        gap, gamma, tau = d.gap, d.gamma, d.floor
        bound, additive = t3_general(d.mechanism, gamma, tau, gap), t1(d.mechanism, gamma, tau, gap)
        assert d.local <= bound.value <= additive.value
        if tau:
            seen += gap > 0
            span = gamma - min(gap, gamma)
            formula = max(
                ((gap + span * most_power(p, q, tau / span)) / tau if tau <= span else gamma / tau for p, q in permutations(d.rows_a, 2)),
                default=F(1),
            )
            assert bound.value == formula
            assert proved(bound, d.rows_a, lambda p, q, k, c=(gap, span, tau): k + (c[0] + c[1] * stick(p, q, k)) / c[2])
    assert tiers.enough(seen > 40)


def test_the_general_form_is_the_best_pair_of_responses() -> None:
    """Linear program: h and h' in [0, γ], |h − h'| ≤ K, greatest E_P h / E_Q h' with E_Q h' ≥ τ."""
    rng = Random(tiers.fresh("general"))
    for _ in range(60):
        n = rng.randint(1, 3)
        rows = [random_row(rng, n), random_row(rng, n)]
        gamma, gap, tau = F(2), F(rng.randint(0, 8), 4), F(rng.randint(1, 8), 4)
        values = []
        for p, q in permutations(rows, 2):
            constraints = []
            for j in range(n):
                own, other = ([F(int(i == j + shift)) for i in range(2 * n)] for shift in (0, n))
                difference = [v - w for v, w in zip(own, other, strict=True)]
                constraints += [[*(-v for v in own), gamma, 0], [*(-v for v in other), gamma, 0]]
                constraints += [[*difference, gap, 0], [*(-v for v in difference), gap, 0]]
            constraints.append([*[F(0)] * n, *q, -tau, 0])
            values.append(maximize(2 * n + 1, [*p, *[F(0)] * (n + 1)], [[*[F(0)] * n, *q, 0, -1]], constraints))
        assert t3_general(table_filter(rows), gamma, tau, gap).value == max(values)


# Whose floor it is


def test_a_floor_of_one_policy_proves_nothing_about_another() -> None:
    """A policy that always grants the greatest utility has t = 1 and ratio 1; behind the same filter another has ratio 3."""
    rows, mechanism = response_rows(2, F(3, 4)), RandomizedResponse(["a", "b"], keep_probability="0.75")
    always, favouring = [F(1), F(1)], [F(1), F(0)]
    means = {name: [sum(p * h for p, h in zip(row, response, strict=True)) for row in rows]
             for name, response in (("always", always), ("favouring", favouring))}  # fmt: skip
    t = min(means["always"])
    assert t == 1
    bound = t3_mechanism(mechanism, t)
    other = ratio(*means["favouring"])
    assert bound.value == 1 < other == 3
    assert bound.scope == "this law"
    for floor in ("table", "policy"):
        assert t3_mechanism(mechanism, t, floor=floor).scope == "this law"
        assert not t3_approx(3, 0, t, floor=floor).scope.startswith("any policy")
    declared = t3_mechanism(mechanism, t, floor="declared")
    assert declared.scope == "any policy behind this filter that keeps the declared floor"
    assert any(sentence.endswith("(declared)") for sentence in declared.assumptions)
    assert min(means["favouring"]) < t, "the second policy breaks what was declared"


def test_the_value_of_one_filter_does_not_cover_another_of_the_same_epsilon() -> None:
    """Even with the policy's own floor: 64-fold randomized response at e^ε = 8 against a filter that releases one bit."""
    e, k, t = F(8), 64, F(3, 10)
    own = t3_mechanism(RandomizedResponse(list(range(k)), exp_epsilon=e), t, floor="policy")
    response = [F(1), t]
    rows = [[e / (1 + e), 1 / (1 + e)], [1 / (1 + e), e / (1 + e)]]
    means = [sum(p * h for p, h in zip(row, response, strict=True)) for row in rows]
    assert pure(rows) == e
    assert min(response) == t
    assert ratio(*means) > own.value
    assert own.scope == "this law"
    assert ratio(*means) <= t3_approx(e, 0, t, floor="policy").value
