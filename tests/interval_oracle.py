"""A second reading of docs/certificate-samples.md, for tests of intervals: exact sums, no code of the package; and what they draw."""

from __future__ import annotations

import json
from fractions import Fraction
from itertools import pairwise, permutations, product
from math import inf, log
from random import Random
from typing import Any

from mpmath import iv, mp
from pair_oracle import rarity

from fairaudit import Law, Policy, Utility
from fairaudit.inference.cells import Cell
from fairaudit.inference.comparisons import Comparison
from fairaudit.inference.table_comparisons import local_comparison

F = Fraction
ZERO, ONE = F(0), F(1)


def binary(n: int, k: int) -> Cell:
    return Cell(n, F(k), F(k), F(0), F(1), True)


def bounded(values: list[Fraction], low: Fraction = ZERO, high: Fraction = ONE) -> Cell:
    return Cell(len(values), sum(values, F(0)), sum((v * v for v in values), F(0)), low, high, False)


def one_block(*cells: Cell) -> Comparison:
    return Comparison(cells, (tuple(((i, F(1)),) for i in range(len(cells))),))


def binomial_sum(n: int, k: int, a: int, b: int) -> int:
    """Σ_{i ≤ k} C(n,i) a^i b^(n−i), over the shorter side."""
    if 2 * k > n:
        return (a + b) ** n - binomial_sum(n, n - k - 1, b, a) if k < n else (a + b) ** n
    total, term = 0, 1
    for i in range(k + 1):
        total = total * b + term
        term = term * (n - i) * a // (i + 1)
    return total * b ** (n - k)


def bound_exact(n: int, k: Fraction, p: Fraction, is_binary: bool, level: Fraction) -> bool:
    """Whether B(n, k, p) ≤ level."""
    if p <= 0 or k == n:
        return level >= 1
    if p >= 1:
        return True
    if is_binary and n <= 5000:
        a, d = p.numerator, p.denominator
        return binomial_sum(n, int(k), a, d - a) * level.denominator <= level.numerator * d**n
    if k >= n * p:
        return level >= 1

    def enclosed(x: Fraction) -> Any:
        return iv.log(iv.mpf(x.numerator) / iv.mpf(x.denominator))

    def number(x: Fraction) -> Any:
        return iv.mpf(x.numerator) / iv.mpf(x.denominator)

    iv.dps = 60
    exponent = number(n - k) * enclosed((n - k) / (n * (1 - p)))
    if k:
        exponent += number(k) * enclosed(k / (n * p))
    room = exponent + enclosed(level)
    rho = k * (1 - p) / ((n - k + 1) * p)
    if is_binary and k and rho < 1:
        square = F(53 * n, 333) / (k * (n - k) * (1 - rho) ** 2)
        if square < 1:
            room -= enclosed(square) / 2
    return bool(room.a >= 0)


def scaled(cell: dict[str, Any], mean: Fraction) -> tuple[int, Fraction, Fraction]:
    low, high = map(F, cell["range"])
    n = cell["draws"]
    return n, (F(cell["sum"]) - n * low) / (high - low), (mean - low) / (high - low)


def informative(cell: dict[str, Any]) -> bool:
    return cell["draws"] > 0 and F(cell["range"][0]) < F(cell["range"][1])


def lower_tail(cell: dict[str, Any], mean: Fraction, level: Fraction) -> bool:
    n, k, p = scaled(cell, mean)
    return bound_exact(n, k, p, cell["binary"], level)


def upper_tail(cell: dict[str, Any], mean: Fraction, level: Fraction) -> bool:
    n, k, p = scaled(cell, mean)
    return bound_exact(n, n - k, 1 - p, cell["binary"], level)


def bernstein(cell: dict[str, Any], mean: Fraction, level: Fraction, above: bool) -> bool:
    n, k, p = scaled(cell, mean)
    low, high = map(F, cell["range"])
    if n < 2:
        return False
    variance = (F(cell["squares"]) - F(cell["sum"]) ** 2 / n) / (n - 1) / (high - low) ** 2
    mp.dps = 60
    lam = F(int(mp.ceil(mp.log(mp.mpf(2) * level.denominator / level.numerator) * 2**120)) + 2, 2**120)
    d = (p - k / n if above else k / n - p) - 7 * lam / (3 * (n - 1))
    return d >= 0 and d * d >= 2 * variance * lam / n


def ends_hold(cell: dict[str, Any], lo: Fraction, hi: Fraction, level: Fraction, method: str) -> bool:
    low, high = map(F, cell["range"])
    if not low <= lo <= hi <= high:
        return False
    if not informative(cell):
        return (lo, hi) == (low, high)
    if cell["binary"] or method == "hoeffding-kl":
        return (hi == high or lower_tail(cell, hi, level)) and (lo == low or upper_tail(cell, lo, level))
    if method == "empirical-bernstein":
        return (hi == high or bernstein(cell, hi, level, True)) and (lo == low or bernstein(cell, lo, level, False))
    half = level / 2
    return (hi == high or lower_tail(cell, hi, half) or bernstein(cell, hi, half, True)) and (
        lo == low or upper_tail(cell, lo, half) or bernstein(cell, lo, half, False)
    )


def corner_ratios(w: dict[int, Fraction], v: dict[int, Fraction], ends: list[tuple[Fraction, Fraction]]) -> list[Any]:
    cells = sorted({*w, *v})
    found = []
    for corner in product(*[ends[i] for i in cells]):
        h = dict(zip(cells, corner, strict=True))
        top, bottom = (sum((x * h[i] for i, x in form.items()), F(0)) for form in (w, v))
        found.append((F(1) if top == 0 else inf) if bottom == 0 else top / bottom)
    return found


def area(b: Fraction, c: Fraction) -> float:
    return float(c) * log(float(c / b**2)) - float(c) + float(b) ** 2


def recheck(evidence: dict[str, Any], lower: Any, upper: Any) -> None:
    """Check an interval by its evidence alone; small boxes by all corners."""
    evidence = json.loads(json.dumps(evidence))
    alpha = 1 - F(evidence["confidence"])
    cells, ends_of = evidence["cells"], evidence["ends"]
    blocks = [[{i: F(w) for i, w in form} for form in block] for block in evidence["blocks"]]
    used = {i for block in blocks if len(block) > 1 for form in block for i in form if informative(cells[i])}
    K = len(used)
    pairs = [(b, i, j) for b, block in enumerate(blocks) for i, j in permutations(range(len(block)), 2)]
    s = max(len({*blocks[b][i], *blocks[b][j]} & used) for b, i, j in pairs)
    M = len(pairs)
    if evidence["region"] == "box":
        beta, prime = F(evidence["levels"]["upper"]), F(evidence["levels"]["lower"])
        alone = evidence["independent"]
        if not K:
            assert beta == prime == 0
        elif ends_of == "together":
            assert prime <= beta
            plain = s * beta + (2 * K - s) * prime <= alpha
            assert plain or (alone and (1 - beta - prime) ** s * (1 - 2 * prime) ** (K - s) >= 1 - alpha)
        if K and ends_of in ("upper", "each"):
            assert s * beta <= alpha or (alone and (1 - beta) ** s >= 1 - alpha)
        if K and ends_of in ("lower", "each"):
            assert 2 * K * prime <= alpha or (alone and (1 - 2 * prime) ** K >= 1 - alpha)
        ends = {}
        for name, level in (("upper", beta), ("lower", prime)):
            if evidence[name] is not None:
                ends[name] = [(F(a), F(b)) for a, b in evidence[name]]
                for cell, (lo, hi) in zip(cells, ends[name], strict=True):
                    assert ends_hold(cell, lo, hi, level, evidence["method"])
        if ends_of != "lower":
            assert upper >= 1
            assert all(upper >= max(corner_ratios(blocks[b][i], blocks[b][j], ends["upper"])) for b, i, j in pairs)
        if ends_of != "upper" and lower > 1:
            b, i, j = evidence["pair"]
            assert min(corner_ratios(blocks[b][i], blocks[b][j], ends["lower"])) >= lower
        return
    assert evidence["independent"]
    assert all(list(form.values()) == [1] for block in blocks for form in block)
    if evidence["region"] == "pairs":
        recheck_pairs(evidence, lower, upper, cells, [[next(iter(form)) for form in block] for block in blocks], pairs)
        return
    up, low = ([F(v) for v in evidence["levels"][k]] if evidence["levels"][k] else None for k in ("upper", "lower"))
    for pair in (up, low):
        if pair:
            assert pair[0] ** 2 <= pair[1] <= pair[0]
    if ends_of == "together":
        assert low[0] <= up[0] and low[1] <= up[1]
        assert 2 * up[0] + max(2, 2 * K - 2) * low[0] + area(*up) + (M - 1) * area(*low) <= float(alpha)
    if ends_of in ("upper", "each"):
        assert 2 * up[0] + area(*up) <= float(alpha)
    if ends_of in ("lower", "each"):
        assert 2 * K * low[0] + M * area(*low) <= float(alpha)
    if upper != inf:
        assert upper >= 1
        for block, knots in zip([b for b in blocks if len(b) > 1], evidence["upper"], strict=True):
            members = [next(iter(form)) for form in block]
            check_ladder(cells, members, members, upper, [F(q) for q in knots], *up)
    if lower > 1:
        b, i, j = evidence["lower"]["pair"]
        top, bottom = (next(iter(blocks[b][k])) for k in (j, i))
        check_ladder(cells, [top], [bottom], 1 / lower, [F(q) for q in evidence["lower"]["knots"]], *low)


def recheck_pairs(
    evidence: dict[str, Any],
    lower: Any,
    upper: Any,
    cells: list[dict[str, Any]],
    members: list[list[int]],
    pairs: list[tuple[int, int, int]],
) -> None:
    """Check the ladders of pairs of cells, each by itself."""
    together = evidence["ends"] == "together"
    share = (1 - F(evidence["confidence"])) / (2 if together else 1)
    levels = share, share / len(pairs)

    def proved(place: tuple[int, int, int], knots: list[str], ratio: Fraction, level: Fraction) -> bool:
        block, i, j = place
        one, other = cells[members[block][i]], cells[members[block][j]]
        (low, high), (other_low, other_high) = (map(F, cell["range"]) for cell in (one, other))
        assert low == other_low == 0 < min(high, other_high) and one["binary"] and other["binary"]
        single = level * (2 if together else 1)
        scale = F(25, 16) if single >= F(1, 100) else F(4) if single >= F(1, 2000) else F(9)
        counts = int(F(one["sum"]) / high), one["draws"], int(F(other["sum"]) / other_high), other["draws"]
        return rarity(counts, ratio * other_high / high, level, [F(q) for q in knots], scale, False) <= 1 + 1e-9

    for name, level in zip(("upper", "lower"), levels, strict=True):
        assert evidence["levels"][name] is None or F(evidence["levels"][name]) == level
    if upper != inf:
        assert upper >= 1
        assert all(proved(place, knots, F(upper), levels[0]) for place, knots in zip(pairs, evidence["upper"], strict=True))
    if lower > 1:
        b, i, j = evidence["lower"]["pair"]
        assert proved((b, j, i), evidence["lower"]["knots"], 1 / F(lower), levels[1])


def exact_tail(cell: dict[str, Any], mean: Fraction, lower: bool) -> Fraction:
    n, k, p = scaled(cell, mean)
    if not lower:
        k, p = n - k, 1 - p
    if p <= 0 or k == n:
        return F(1)
    if p >= 1:
        return F(0)
    assert cell["binary"] and n <= 5000
    a, d = p.numerator, p.denominator
    return F(binomial_sum(n, int(k), a, d - a), d**n)


def check_ladder(
    cells: list[dict[str, Any]], tops: list[int], bottoms: list[int], r: Fraction, q: list[Fraction], b: Fraction, c: Fraction
) -> None:
    assert q[0] > 0 and all(x < y for x, y in pairwise(q))
    assert all(q[0] <= F(cells[i]["range"][0]) or upper_tail(cells[i], q[0], b) for i in bottoms)
    for before, at in pairwise(q):
        left = {i: exact_tail(cells[i], r * before, True) for i in tops if r * before < F(cells[i]["range"][1])}
        right = {i: exact_tail(cells[i], at, False) for i in bottoms}
        assert all(t * u <= c for i, t in left.items() for j, u in right.items() if i != j)
    assert all(r * q[-1] >= F(cells[i]["range"][1]) or lower_tail(cells[i], r * q[-1], b) for i in tops)


def by_unit(table: Any, utility: Utility, **columns: str) -> Comparison:
    law = Law.from_log(table, **columns, unit="run")  # type: ignore[arg-type]
    return local_comparison(law, utility.on(law))


def sampled_policy(drop: tuple[str, str] | None = None) -> Policy:
    rows = {"x": [], "a": [], "u": [], "n": []}
    random = Random(2)
    for x in "PQ":
        for a in "fmo":
            if (x, a) != drop:
                k = random.randint(20, 80)
                for u, n in (("yes", k), ("no", 100 - k)):
                    for name, value in zip("xaun", (x, a, u, n), strict=True):
                        rows[name].append(value)
    return Policy.from_counts(rows, decision="u", group="a", context="x", count="n")
