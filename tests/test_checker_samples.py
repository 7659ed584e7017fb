"""The checker on intervals for the population behind a sample, against a dense second reading of docs/certificate-samples.md."""

import copy
import json
import random
import subprocess
import sys
from collections.abc import Callable, Iterator
from fractions import Fraction
from functools import cache
from itertools import chain, pairwise, permutations, product
from math import comb, lcm
from pathlib import Path
from typing import Any

import pytest
from assumptions import complete
from mpmath import mp
from test_checker_policy import FLOORED, POLICIES, SCHEMA, Policy, digested, write
from test_checker_policy import by_hand as policy_by_hand
from test_checker_unit import INF, checker, edited, false_statements, log_pair, make, raw, text

F = Fraction
ALPHA = F(1, 10)
GRID = 2**12  # ends are multiples of the range over this
TINY = F(1, 10**12)
Cell = dict[str, Any]
Form = dict[int, Fraction]


# What follows from the table, by definition


def rows_of(certificate: Any) -> tuple[Any, list[Any]]:
    table = certificate["subject"]["table"]
    return table["header"], table["rows"]


def cell_of(draws: list[tuple[int, Fraction]], low: Fraction, high: Fraction, binary: bool) -> Cell:
    n, total, squares = sum(n for n, _ in draws), sum((n * g for n, g in draws), F(0)), sum((n * g * g for n, g in draws), F(0))
    return {"draws": n, "sum": total, "squares": squares, "range": (low, high), "binary": binary}


def pooled(rows: list[tuple[list[int], list[Any]]], limits: Any, units: Any, partly: Fraction | None) -> Cell:
    g = [[None if e is None else F(e) for e in own] for _, own in rows]
    draws = [(n, e) for (counts, _), own in zip(rows, g, strict=True) for n, e in zip(counts, own, strict=True) if n and e is not None]
    values = [*chain.from_iterable(g)]
    high = max(e for e in values if e is not None) if partly is None else partly
    low, high = map(F, limits or (0, high))
    binary = limits is None and units is None and all(e in (low, high) for e in values)
    if units is not None:
        draws = [(n, sum((c * (e or F(0)) for c, e in zip(own, g[0], strict=True)), F(0)) / sum(own)) for n, own in units]
    return cell_of(draws, low, high, binary)


def of_counts(certificate: Any, quantity: str, limits: Any, units: Any) -> tuple[list[Cell], list[list[Form]]]:
    header, rows = rows_of(certificate)
    entries = [(r["context"], r["group"], [*map(int, r["weights"])], header["utility"] or r["utility"]) for r in rows]
    given = [e for *_, own in entries for e in own]
    partly = max(F(e) for e in given if e is not None) if None in given else None
    if quantity == "global":
        groups = sorted({a for _, a, *_ in entries})
        cells = [pooled([(w, g) for _, b, w, g in entries if b == a], limits, None, partly) for a in groups]
        return cells, [[{i: F(1)} for i in range(len(cells))]]
    cells, blocks = [], []
    for x in range(len(header["contexts"])):
        here = [(w, g) for y, _, w, g in entries if x == y]
        if len(here) > 1:
            blocks.append([{len(cells) + i: F(1)} for i in range(len(here))])
            cells += [pooled([row], limits, units[len(cells) + i] if units else None, partly) for i, row in enumerate(here)]
    return cells, blocks


def of_policy(p: Policy, draws: dict[tuple[int, int], int], quantity: str) -> tuple[list[Cell], list[list[Form]], bool]:
    by_group = p.own["lipschitz"] > 0
    places: dict[Any, int] = {}
    cells: list[Cell] = []
    forms: dict[tuple[int, int], Form] = {}
    for x, a in p.cells():
        forms[x, a] = {}
        for i, j in product(range(len(p.released_x)), range(len(p.released_a))):
            weight = p.X[x][i] * p.A[a][j]
            if weight:
                place = (i, j, None if isinstance(p.given, list) else x, a if by_group else None)
                if place not in places:
                    places[place] = len(cells)
                    at = p.contexts.index(p.released_x[i]), p.groups.index(p.released_a[j])
                    n = [(int(w * draws[at]), g) for w, g in zip(p.T[at], p.g[x, a], strict=True)]
                    high = max(p.g[x, a])
                    cells.append(cell_of([(c, g) for c, g in n if c], F(0), high, all(g in (0, high) for _, g in n)))
                forms[x, a][places[place]] = weight
    shared = len({place[:2] for place in places}) < len(places)
    if quantity == "local":
        return cells, [[forms[x, a] for a in range(len(p.true_a))] for x in range(len(p.true_x))], shared
    block: list[Form] = []
    for a in range(len(p.true_a)):
        if p.of_group(a):
            terms = [(p.weight(x, a) / p.of_group(a), forms[x, a]) for x in range(len(p.true_x)) if p.weight(x, a)]
            block.append({i: sum((s * form.get(i, F(0)) for s, form in terms), F(0)) for i in range(len(cells))})
            block[-1] = {i: w for i, w in block[-1].items() if w}
    return cells, [block] if len(block) > 1 else [], shared


# Tails, by sums of fractions and by logarithms of fifty digits


@cache
def bound(n: int, k: Fraction, p: Fraction, binary: bool) -> Any:
    if p <= 0 or k == n:
        return F(1)
    if p >= 1:
        return F(0)
    if binary and n <= 5000:
        if 2 * k > n:
            return 1 - bound(n, n - k - 1, 1 - p, True)
        a, b = p.numerator, p.denominator - p.numerator
        return F(sum(comb(n, i) * a**i * b ** (int(k) - i) for i in range(int(k) + 1)) * b ** (n - int(k)), p.denominator**n)
    if k >= n * p:
        return F(1)
    mp.dps = 50

    def real(x: Fraction) -> Any:
        return mp.mpf(x.numerator) / x.denominator

    exponent = (real(k) * mp.log(real(k / (n * p))) if k else 0) + real(n - k) * mp.log(real((n - k) / (n * (1 - p))))
    factor = mp.mpf(1)
    if binary and k:
        rho = k * (1 - p) / ((n - k + 1) * p)
        factor = min(factor, mp.sqrt(real(F(53 * n, 333) / (k * (n - k) * (1 - rho) ** 2))))
    return mp.exp(-exponent) * factor


def tail(cell: Cell, mean: Fraction, lower: bool) -> Any:
    if not informative(cell):
        return F(1)
    n, (low, high) = cell["draws"], cell["range"]
    k, p = (cell["sum"] - n * low) / (high - low), (mean - low) / (high - low)
    return bound(n, k, p, cell["binary"]) if lower else bound(n, n - k, 1 - p, cell["binary"])


def informative(cell: Cell) -> bool:
    return bool(cell["draws"] and cell["range"][0] < cell["range"][1])


def below(value: Any, level: Fraction) -> bool:
    return bool(value <= level) if isinstance(value, Fraction) else bool(value * level.denominator <= level.numerator)


def excluded(cell: Cell, mean: Fraction, level: Fraction, method: str, above: bool) -> bool:
    if cell["binary"] or method == "hoeffding-kl":
        return below(tail(cell, mean, above), level)
    if method == "intersection":
        return any(excluded(cell, mean, level / 2, m, above) for m in ("hoeffding-kl", "empirical-bernstein"))
    n, (low, high) = cell["draws"], cell["range"]
    if n < 2 or level == 0:
        return False
    mp.dps = 50
    logarithm = mp.log(2 * mp.mpf(level.denominator) / level.numerator)
    variance = (cell["squares"] - cell["sum"] ** 2 / n) / (n - 1) / (high - low) ** 2
    distance = (mean - cell["sum"] / n) / (high - low) * (1 if above else -1)
    radius = mp.sqrt(2 * mp.mpf(variance.numerator) / variance.denominator * logarithm / n) + 7 * logarithm / (3 * (n - 1))
    return bool(mp.mpf(distance.numerator) / distance.denominator >= radius)


def first(most: int, holds: Callable[[int], bool]) -> int:
    """Find the least number up to ``most`` from which on a property holds, which has to hold there."""
    low, high = -1, most
    while high - low > 1:
        middle = (low + high) // 2
        low, high = (low, middle) if holds(middle) else (middle, high)
    return high


def tightest(cell: Cell, level: Fraction, method: str) -> tuple[Fraction, Fraction]:
    """The tightest ends on the grid."""
    low, high = cell["range"]
    if not informative(cell) or level == 0:
        return low, high
    step = (high - low) / GRID
    up = first(GRID, lambda i: i == GRID or excluded(cell, low + i * step, level, method, True))
    down = first(GRID, lambda i: i == GRID or excluded(cell, high - i * step, level, method, False))
    return high - down * step, low + up * step


def quotient(a: Fraction, b: Fraction) -> Any:
    return a / b if b else (F(1) if a == 0 else INF)


def greatest(w: Form, v: Form, box: list[tuple[Fraction, Fraction]]) -> Any:
    """Raise the cells of a pair to their upper ends, one after the other; the greatest quotient passed."""
    order = sorted({*w, *v}, key=lambda i: quotient(w.get(i, F(0)), v.get(i, F(0))), reverse=True)
    a, b = (sum((c * box[i][0] for i, c in form.items()), F(0)) for form in (w, v))
    best = quotient(a, b)
    for i in order:
        a, b = (t + form.get(i, F(0)) * (box[i][1] - box[i][0]) for t, form in ((a, w), (b, v)))
        best = max(best, quotient(a, b))
    return best


def inverse(value: Any) -> Any:
    return INF if value == 0 else F(0) if value == INF else 1 / value


def figures(cells: list[Cell], blocks: list[list[Form]]) -> tuple[set[int], int, int]:
    used = {i for block in blocks for form in block for i in form if informative(cells[i])}
    pairs = [(u, v) for block in blocks for u, v in permutations(block, 2)]
    return used, max(len({*u, *v} & used) for u, v in pairs), len(pairs)


def strings(box: list[tuple[Fraction, Fraction]]) -> list[list[str]]:
    return [[str(lo), str(hi)] for lo, hi in box]


def by_box(cells: list[Cell], blocks: list[list[Form]], independent: bool, method: str) -> dict[str, Any]:
    used, s, _ = figures(cells, blocks)
    K = len(used)
    beta, prime = (ALPHA / (2 * s), ALPHA / (2 * (2 * K - s))) if K else (F(0), F(0))
    if independent and K:
        steps = first(1000, lambda t: any_wrong(beta, prime, K, s, 1 + F(t, 1000)) > ALPHA)
        beta, prime = ((1 + F(steps - 1, 1000)) * level for level in (beta, prime))
    upper, lower = ([tightest(cell, level, method) for cell in cells] for level in (beta, prime))
    high = max([F(1)] + [greatest(u, v, upper) for block in blocks for u, v in permutations(block, 2)])
    low, pair = F(1), None
    for b, block in enumerate(blocks):
        for i, j in permutations(range(len(block)), 2):
            least = inverse(greatest(block[j], block[i], lower))
            if least != INF and least > low:
                low, pair = least, [b, i, j]
    return {
        "region": "box",
        "ratio": [str(low), text(high)],
        "levels": {"upper": str(beta), "lower": str(prime)},
        "upper": strings(upper),
        "lower": strings(lower),
        "pair": pair,
    }


def any_wrong(beta: Fraction, prime: Fraction, used: int, s: int, factor: Fraction) -> Fraction:
    return 1 - (1 - factor * (beta + prime)) ** s * (1 - 2 * factor * prime) ** (used - s)


def ladder(cells: list[Cell], tops: list[int], bottoms: list[int], r: Fraction, b: Fraction, c: Fraction) -> list[Fraction] | None:
    """Climb in the greatest steps on the grid that are allowed; None when there is no way."""
    step = max(cells[i]["range"][1] for i in {*tops, *bottoms}) / 512

    def starts(q: Fraction) -> bool:
        return all(q <= cells[j]["range"][0] or below(tail(cells[j], q, False), b) for j in bottoms)

    def follows(p: Fraction, q: Fraction) -> bool:
        left = {i: tail(cells[i], r * p, True) for i in tops if r * p < cells[i]["range"][1]}
        return all(below(t * tail(cells[j], q, False), c) for i, t in left.items() for j in bottoms if i != j)

    at = first(512, lambda i: i > 0 and not starts(i * step)) - 1
    knots = []
    while at > 0:
        q = at * step
        knots.append(q)
        if all(r * q >= cells[i]["range"][1] or below(tail(cells[i], r * q, True), b) for i in tops):
            return knots
        further = next((t for t in range(1024, at, -1) if follows(q, t * step)), None)
        if further is None:
            return None
        at = further
    return None


def climbs(cells: list[Cell], tops: list[int], bottoms: list[int], r: Fraction, knots: list[Fraction], b: Fraction, c: Fraction) -> bool:
    def step(p: Fraction, q: Fraction) -> bool:
        left = {i: tail(cells[i], r * p, True) for i in tops if r * p < cells[i]["range"][1]}
        return all(below(t * tail(cells[j], q, False), c) for i, t in left.items() for j in bottoms if i != j)

    if not knots or knots[0] <= 0 or any(p >= q for p, q in pairwise(knots)):
        return False
    starts = all(knots[0] <= cells[j]["range"][0] or below(tail(cells[j], knots[0], False), b) for j in bottoms)
    ends = all(r * knots[-1] >= cells[i]["range"][1] or below(tail(cells[i], r * knots[-1], True), b) for i in tops)
    return starts and ends and all(step(p, q) for p, q in pairwise(knots))


def area(b: Fraction, c: Fraction) -> float:
    return float(c) * float(mp.log(float(c / b**2))) - float(c - b * b)


def by_ladders(cells: list[Cell], blocks: list[list[Form]]) -> dict[str, Any] | None:
    used, _, pairs = figures(cells, blocks)
    K = len(used)
    if not K or any([*form.values()] != [1] for block in blocks for form in block):
        return None
    b = ALPHA / (4 * K + 2)
    c, prime = b / 2, b / 2
    while 2 * b + max(2, 2 * K - 2) * prime + area(b, c) + (pairs - 1) * area(prime, c / 2) > ALPHA - F(1, 10**6):
        b, c, prime = b * F(9, 10), c * F(8, 10), prime * F(9, 10)
    if not (b * b <= c <= b and prime**2 <= c / 2 <= prime):
        return None
    members = [[next(iter(form)) for form in block] for block in blocks]
    high, upper = "inf", None
    for r in (F(1), F(5, 4), F(2), F(4), F(16)):
        ladders = [ladder(cells, block, block, r, b, c) for block in members]
        if None not in ladders:
            high, upper = str(r), [[*map(str, knots)] for knots in ladders]
            break
    low, lower = "1", None
    places = [(x, i, j) for x, block in enumerate(members) for i, j in permutations(range(len(block)), 2)]
    for r, (x, i, j) in product((F(3), F(3, 2), F(21, 20)), places):
        if members[x][i] != members[x][j] and (knots := ladder(cells, [members[x][j]], [members[x][i]], 1 / r, prime, c / 2)):
            low, lower = str(r), {"pair": [x, i, j], "knots": [*map(str, knots)]}
            break
    levels = {"upper": [str(b), str(c)], "lower": [str(prime), str(c / 2)]}
    return {"region": "product", "ratio": [low, high], "levels": levels, "upper": upper, "lower": lower}


def interval(
    cells: list[Cell], blocks: list[list[Form]], *, independent: bool = False, method: str = "hoeffding-kl", limits: Any = None
) -> dict[str, Any]:
    common = {"confidence": str(1 - ALPHA), "side": "both", "independent": independent, "method": method, "limits": limits}
    return common | by_box(cells, blocks, independent, method)


def method_of(cells: list[Cell], blocks: list[list[Form]], interval: dict[str, Any]) -> str:
    used, _, _ = figures(cells, blocks)
    return "binomial" if all(cells[i]["binary"] for i in used) else interval["method"]


def claims(name: str, interval: dict[str, Any], by: str) -> list[dict[str, Any]]:
    common = {"quantity": f"{name}_ratio", "scope": f"population at confidence {interval['confidence']}", "by": by}
    common |= {"assumptions": [], "evidence": {"interval": name}}
    return [common | {"relation": relation, "value": value} for relation, value in zip((">=", "<="), interval["ratio"], strict=True)]


def with_interval(certificate: Any, name: str, interval: dict[str, Any], by: str) -> Any:
    certificate = copy.deepcopy(certificate)
    certificate.setdefault("intervals", {})[name] = interval
    certificate["claims"] += claims(name, interval, by)
    return complete(certificate)


def accepted(certificate: Any, table: Any = None) -> bool:
    false = false_statements(certificate, table)
    assert false or SCHEMA.is_valid(complete(copy.deepcopy(certificate)))
    return not false


def rejected(certificate: Any) -> bool:
    try:
        return bool(false_statements(certificate))
    except checker.FormatError:
        return True


# True intervals of random tables, and what is a little tighter


def random_counts(seed: int) -> tuple[Any, random.Random]:
    pick = random.Random(seed)
    n_contexts, n_groups, n = pick.randint(1, 2), pick.randint(2, 3), pick.randint(2, 3)
    size = pick.choice([1, 4, 30])
    places = [(x, a) for x in range(n_contexts) for a in range(n_groups) if pick.random() < pick.choice([0.7, 1])] or [(0, 0)]
    weights, utility = {}, {}
    for place in places:
        row = [pick.choice([0, pick.randint(0, size), pick.randint(0, size)]) for _ in range(n)]
        row[pick.randrange(n)] += 1
        weights[place] = [*map(str, row)]
        utility[place] = [None if w == 0 and pick.random() < 0.3 else pick.choice(["0", "0", "1", "1", "1/2"]) for w in row]
        if all(e is None for e in utility[place]):
            utility[place][0] = "1"
    common = pick.choice([["1", *["0"] * (n - 1)], [pick.choice(["0", "1", "3/2"]) for _ in range(n)]])
    return make(weights, pick.choice([common, common, utility]), shape=(n_contexts, n_groups)), pick


def random_units(certificate: Any, pick: random.Random) -> list[list[list[Any]]]:
    """Divide the rows of each compared cell into units at random."""
    _, rows = rows_of(certificate)
    lists = []
    for row in rows:
        if sum(r["context"] == row["context"] for r in rows) < 2:
            continue
        left = [*map(int, row["weights"])]
        units: dict[tuple[int, ...], int] = {}
        while any(left):
            own = [pick.randint(0, min(2, n)) for n in left]
            if any(own):
                units[tuple(own)] = units.get(tuple(own), 0) + 1
                left = [n - c for n, c in zip(left, own, strict=True)]
        lists.append([[n, [*own]] for own, n in units.items()])
    return lists


def measured(certificate: Any, cells: list[Cell], blocks: list[list[Form]]) -> Any:
    """The greatest quotient of the means over units, and the first pair that attains it, by definition."""
    header, rows = rows_of(certificate)
    places = [(r["context"], r["group"]) for r in rows if sum(other["context"] == r["context"] for other in rows) > 1]
    means = [cell["sum"] / cell["draws"] for cell in cells]
    pairs = [(i, j) for block in blocks for i, j in permutations([next(iter(form)) for form in block], 2)]
    quotients = [F(1) if means[i] == means[j] else means[i] / means[j] if means[j] else INF for i, j in pairs]
    best = max(quotients)
    i, j = pairs[quotients.index(best)]
    labels = {
        "context": header["contexts"][places[i][0]],
        "higher": header["groups"][places[i][1]],
        "lower": header["groups"][places[j][1]],
    }
    columns = header["columns"]
    names = {key: dict(zip(columns["context" if key == "context" else "group"], own, strict=True)) for key, own in labels.items()}
    witness = names | {"expectations": [str(means[i]), str(means[j])]}
    return {"ratio": text(best), "log": log_pair(best), "witness": witness}


@cache
def certified(seed: int, name: str) -> tuple[Any, list[Cell], list[list[Form]]] | None:
    """Write the interval of a ratio of a random table, in one of many ways; None when there is nothing to compare."""
    certificate, pick = random_counts(seed)
    if certificate["metrics"][name] is None:
        return None
    limits = pick.choice([None, None, ["0", "2"], ["0", "1"]])
    units = random_units(certificate, pick) if name == "local" and pick.random() < 0.3 else None
    cells, blocks = of_counts(certificate, name, limits, units)
    if any(c["range"][1] < 0 or c["sum"] > c["draws"] * c["range"][1] for c in cells):
        limits = None
        cells, blocks = of_counts(certificate, name, None, units)
    given = [g for r in rows_of(certificate)[1] for g in rows_of(certificate)[0]["utility"] or r["utility"] if g is not None]
    if limits and max(map(F, given)) > F(limits[1]):
        limits = None
        cells, blocks = of_counts(certificate, name, None, units)
    method = pick.choice(["hoeffding-kl", "empirical-bernstein", "intersection"])
    independent = units is None and pick.random() < 0.5
    found = interval(cells, blocks, independent=independent, method=method, limits=limits)
    if independent and pick.random() < 0.6 and (method == "hoeffding-kl" or all(c["binary"] for c in cells)):
        found |= by_ladders(cells, blocks) or {}
        if found["region"] == "product":
            found.pop("pair", None)
    if units is not None:
        found |= {"units": units, "estimand": "mean over units", "measured": measured(certificate, cells, blocks)}
    return with_interval(certificate, name, found, method_of(cells, blocks, found)), cells, blocks


SEEDS = range(120)


# The page read once more: which intervals are proven


Derive = Callable[[Any, Any], tuple[list[Cell], list[list[Form]], bool, Any] | None]


def from_counts(certificate: Any, name: str) -> Derive:
    header, rows = rows_of(certificate)

    def derive(limits: Any, units: Any) -> Any:
        given = [F(g) for row in rows for g in header["utility"] or row["utility"] if g is not None]
        compared = [row for row in rows if sum(r["context"] == row["context"] for r in rows) > 1]
        if limits and not all(F(limits[0]) <= g <= F(limits[1]) for g in given):
            return None
        if units is not None:
            sums = [[sum(column) for column in zip(*([n * c for c in own] for n, own in cell), strict=True)] for cell in units]
            if sums != [[*map(int, row["weights"])] for row in compared]:
                return None
        cells, blocks = of_counts(certificate, name, limits, units)
        return cells, blocks, units is not None, None if units is None else measured(certificate, cells, blocks)

    return derive


def proved(found: dict[str, Any], derive: Derive) -> bool:
    try:
        return read_again(found, derive)
    except (ValueError, TypeError, IndexError, KeyError):  # of another shape
        return False


def read_again(found: dict[str, Any], derive: Derive) -> bool:
    c, (low, high) = F(found["confidence"]), (INF if end == "inf" else F(end) for end in found["ratio"])
    shapes = found["limits"] is None or (len(found["limits"]) == 2 and F(found["limits"][0]) <= F(found["limits"][1]))
    shapes = shapes and ("units" not in found or found["units"] is not None)
    derived = derive(found["limits"], found.get("units")) if shapes and 0 < c < 1 else None
    if derived is None or low < 1 or high < 1 or (found["independent"] and derived[2]):
        return False
    cells, blocks, of_units, known = derived
    if found.get("measured") != known or found.get("estimand") != ("mean over units" if of_units and known else None):
        return False
    used, s, pairs = figures(cells, blocks)
    return (read_box if found["region"] == "box" else read_ladders)(found, cells, blocks, (low, high), 1 - c, (len(used), s, pairs))


def read_box(found: Any, cells: list[Cell], blocks: list[list[Form]], ratio: Any, alpha: Fraction, numbers: tuple[int, int, int]) -> bool:
    K, s, _ = numbers
    beta, prime = F(found["levels"]["upper"]), F(found["levels"]["lower"])
    boxes = []
    for key, level in (("upper", beta), ("lower", prime)):
        box = [(F(lo), F(hi)) for lo, hi in found[key]]
        for cell, (lo, hi) in zip(cells, box, strict=True):
            least, most = cell["range"]
            if not least <= lo <= hi <= most or (not informative(cell) and (lo, hi) != (least, most)):
                return False
            if lo > least and not excluded(cell, lo, level, found["method"], False):
                return False
            if hi < most and not excluded(cell, hi, level, found["method"], True):
                return False
        boxes.append(box)
    levels = 0 < prime <= beta < 1 if K else beta == prime == 0
    alone = found["independent"] and beta + prime < 1 and any_wrong(beta, prime, K, s, F(1)) <= alpha
    if not levels or (s * beta + (2 * K - s) * prime > alpha and not alone):
        return False
    if max(greatest(u, v, boxes[0]) for block in blocks for u, v in permutations(block, 2)) > ratio[1]:
        return False
    if found["pair"] is None:
        return bool(ratio[0] == 1)
    b, i, j = found["pair"]
    return bool(ratio[0] > 1 and i != j and inverse(greatest(blocks[b][j], blocks[b][i], boxes[1])) >= ratio[0])


def read_ladders(
    found: Any, cells: list[Cell], blocks: list[list[Form]], ratio: Any, alpha: Fraction, numbers: tuple[int, int, int]
) -> bool:
    K, _, pairs = numbers
    (b, c), (prime, other) = ([*map(F, found["levels"][key])] for key in ("upper", "lower"))
    if not found["independent"] or any([*form.values()] != [1] for block in blocks for form in block):
        return False
    if found["method"] != "hoeffding-kl" and not all(cell["binary"] for cell in cells if informative(cell)):
        return False
    if not (b * b <= c <= b < 1 and prime * prime <= other <= prime <= b and other <= c):
        return False
    if 2 * b + max(2, 2 * K - 2) * prime + area(b, c) + (pairs - 1) * area(prime, other) > alpha:
        return False
    members = [[next(iter(form)) for form in block] for block in blocks]
    if (ratio[1] == INF) is not (found["upper"] is None) or (ratio[0] == 1) is not (found["lower"] is None):
        return False
    if found["upper"] is not None:
        for block, knots in zip(members, found["upper"], strict=True):
            if not climbs(cells, block, block, ratio[1], [*map(F, knots)], b, c):
                return False
    if found["lower"] is None:
        return True
    x, i, j = found["lower"]["pair"]
    top, bottom = members[x][j], members[x][i]
    return top != bottom and climbs(cells, [top], [bottom], 1 / ratio[0], [*map(F, found["lower"]["knots"])], prime, other)


def mutations(value: Any, path: list[Any]) -> Iterator[tuple[list[Any], Any]]:
    """List what may stand in the place of every part of an interval."""
    changes: list[Any] = []
    if value is None:
        changes = [[0, 1, 0], [0, 0, 1], ["0", "2"], [["1", "2"]], {"pair": [0, 0, 1], "knots": ["1/2", "1"]}]
    elif isinstance(value, str) and value[:1].isdigit():
        number = F(value)
        step = F(1, GRID)
        near = [number + TINY, number - TINY, number * F(1001, 1000), number * F(999, 1000), number + step, number - step, 2 * number]
        changes = [str(max(F(0), other)) for other in near] + ["1", "1/3", "0"]
    elif value == "inf":
        changes = ["1000", "10"]
    elif isinstance(value, bool):
        changes = [not value]
    elif isinstance(value, int):
        changes = [value + 1, max(0, value - 1), 9]
    elif isinstance(value, list):
        changes = [value[1:], [*value, *value[-1:]], value[::-1], None]
    elif value in checker.claims.METHODS:
        changes = [*checker.claims.METHODS]
    yield from ((path, change) for change in changes if change != value)
    for key in list(value) if isinstance(value, dict) else range(len(value)) if isinstance(value, list) else ():
        yield from mutations(value[key], [*path, key])


def stands(certificate: Any, name: str) -> bool:
    """Whether the checker takes the interval, whatever claims and targets make of it."""
    try:
        findings = checker.check(raw(complete(copy.deepcopy(certificate)))).findings
    except checker.FormatError:
        return False
    [found] = [finding.true for finding in findings if finding.statement.startswith(f"intervals.{name}:")]
    return bool(found)


def compare_readings(certificate: Any, name: str, derive: Derive, sample: Callable[[list[Any]], list[Any]]) -> tuple[int, int]:
    """Change an interval in many ways; the checker must agree with the second reading. How many were taken, and refused?"""
    assert proved(certificate["intervals"][name], derive)
    taken = refused = 0
    for path, value in sample([*mutations(certificate["intervals"][name], ["intervals", name])]):
        changed = copy.deepcopy(certificate)
        place = changed
        for step in path[:-1]:
            place = place[step]
        place[path[-1]] = value
        expected = proved(changed["intervals"][name], derive)
        assert stands(changed, name) is expected, (path, value, expected)
        taken, refused = taken + expected, refused + (not expected)
    return taken, refused


@pytest.mark.parametrize("block", range(6))
def test_random_intervals(block: int) -> None:
    pick = random.Random(block)
    taken = refused = 0
    for seed, name in product(SEEDS[block::6], ("local", "global")):
        made = certified(seed, name)
        if made is not None:
            assert accepted(made[0]), (seed, false_statements(made[0]))
            derive = from_counts(made[0], name)
            counts = compare_readings(made[0], name, derive, lambda changes: pick.sample(changes, min(len(changes), 40)))
            taken, refused = taken + counts[0], refused + counts[1]
    assert taken > 100 and refused > 300


def test_the_random_intervals_are_of_many_kinds() -> None:
    made = [found for seed in SEEDS for name in ("local", "global") if (found := certified(seed, name))]
    kinds = [next(iter(c["intervals"].values())) for c, _, _ in made]
    assert {k["region"] for k in kinds} == {"box", "product"} and {k["independent"] for k in kinds} == {True, False}
    for method in ("binomial", "hoeffding-kl", "empirical-bernstein", "intersection"):
        assert sum(c["claims"][-1]["by"] == method for c, _, _ in made) > 4
    assert sum("units" in k for k in kinds) > 5 and sum(k["limits"] is not None for k in kinds) > 5
    assert sum(k["ratio"][1] == "inf" for k in kinds) > 5 and sum(k["ratio"][1] != "inf" for k in kinds) > 20
    assert sum(k["ratio"][0] != "1" for k in kinds) > 10
    assert sum(k["region"] == "product" and k["ratio"] != ["1", "inf"] for k in kinds) > 3


def test_the_tightest_ends_and_ratios_are_the_last_that_stand() -> None:
    """Of a box, every end one step further in and every ratio a little sharper is refused, and every weaker one stands."""
    for seed, name in product(SEEDS[::4], ("local", "global")):
        made = certified(seed, name)
        if made is None or made[0]["intervals"][name]["region"] != "box":
            continue
        certificate, cells, _ = made
        found = certificate["intervals"][name]
        low, high = found["ratio"]
        at = f"intervals.{name}"
        if high != "inf":
            assert stands(edited(copy.deepcopy(certificate), f"{at}.ratio.1", str(F(high) + TINY)), name)
            assert not stands(edited(copy.deepcopy(certificate), f"{at}.ratio.1", str(F(high) - TINY)), name)
        assert not stands(edited(copy.deepcopy(certificate), f"{at}.ratio.0", str(F(low) + TINY)), name)
        if low != "1":
            assert stands(edited(copy.deepcopy(certificate), f"{at}.ratio.0", str((1 + F(low)) / 2)), name)
        for key, (i, cell) in product(("upper", "lower"), enumerate(cells)):
            lo, hi = map(F, found[key][i])
            step = (cell["range"][1] - cell["range"][0]) / GRID
            if hi - lo > 2 * step:
                assert not stands(edited(copy.deepcopy(certificate), f"{at}.{key}.{i}.0", str(lo + step)), name)
                assert not stands(edited(copy.deepcopy(certificate), f"{at}.{key}.{i}.1", str(hi - step)), name)


# Policies that were sampled


@cache
def sampled(seed: int) -> tuple[Any, Policy, dict[tuple[int, int], int]]:
    p = Policy(seed)
    certificate = write(p)
    draws = {place: lcm(*(w.denominator for w in row)) * p.pick.choice([1, 7, 40]) for place, row in p.T.items()}
    for row in rows_of(certificate)[1]:
        if "weights" in row:
            row["draws"] = draws[row["context"], row["group"]]
    return digested(certificate), p, draws


def from_policy(p: Policy, draws: dict[tuple[int, int], int], name: str) -> Derive:
    def derive(limits: Any, units: Any) -> Any:
        return None if limits or units else (*of_policy(p, draws, name), None)  # reads no limits

    return derive


def test_sampled_policies() -> None:
    pick = random.Random(1)
    taken = refused = 0
    kinds: set[Any] = set()
    for seed in range(0, 70, 2):
        certificate, p, draws = sampled(seed)
        assert accepted(certificate)
        for name in ("local", "global"):
            cells, blocks, shared = of_policy(p, draws, name)
            if certificate["metrics"][name] is None:
                assert not blocks
                empty = {"levels": {"upper": "0", "lower": "0"}, "upper": [], "lower": [], "ratio": ["1", "inf"], "pair": None}
                common = {"confidence": "9/10", "side": "both", "region": "box", "independent": False, "method": "intersection"}
                nothing = edited(copy.deepcopy(certificate), "intervals", {name: common | {"limits": None} | empty})
                assert "does not give" in false_statements(nothing)[0]
                continue
            found = interval(cells, blocks, independent=not shared, method=p.pick.choice(["hoeffding-kl", "empirical-bernstein"]))
            kinds.add((name, shared, found["ratio"][0] != "1", found["ratio"][1] != "inf"))
            full = with_interval(certificate, name, found, method_of(cells, blocks, found))
            assert accepted(full), (seed, name, false_statements(full))
            if shared:
                assert rejected(edited(copy.deepcopy(full), f"intervals.{name}.independent", True))
            if len(cells) < 20:
                read = from_policy(p, draws, name)
                counts = compare_readings(full, name, read, lambda found: pick.sample([c for c in found if "limits" not in c[0]], 12))
                taken, refused = taken + counts[0], refused + counts[1]
    assert {kind[:2] for kind in kinds} == set(product(("local", "global"), (True, False)))
    assert any(kind[2] for kind in kinds) and any(kind[3] for kind in kinds)
    assert taken > 50 and refused > 200


def test_draws_have_to_fit_the_weights() -> None:
    certificate, _, draws = sampled(0)
    _, rows = rows_of(certificate)
    places = [i for i, row in enumerate(rows) if "draws" in row]
    at = next(i for i in places if lcm(*(F(w).denominator for w in rows[i]["weights"])) > 1)
    for value in (0, rows[at]["draws"] + 1, "7", None, True, 10**18, ...):
        spoiled = edited(copy.deepcopy(certificate), f"subject.table.rows.{at}.draws", value)
        with pytest.raises(checker.FormatError):
            checker.check(raw(digested(spoiled)))
    # A policy without draws is not a sample, and the rows of other tables have none.
    cells, blocks, _ = of_policy(sampled(0)[1], draws, "local")
    full = with_interval(certificate, "local", interval(cells, blocks), "binomial")
    for i in places:
        del full["subject"]["table"]["rows"][i]["draws"]
    assert "do not say how many" in false_statements(digested(full))[0]
    with pytest.raises(checker.FormatError):
        checker.check(raw(digested(edited(random_counts(0)[0], "subject.table.rows.0.draws", 4))))


# Claims and targets


COUNTS = {(0, 0): ["40", "10"], (0, 1): ["10", "40"], (1, 0): ["30", "20"], (1, 1): ["25", "25"]}


def both_intervals() -> Any:
    certificate = make(COUNTS, ["1", "0"])
    for name in ("local", "global"):
        cells, blocks = of_counts(certificate, name, None, None)
        certificate = with_interval(certificate, name, interval(cells, blocks), "binomial")
    return certificate


@pytest.fixture
def good() -> Any:
    return both_intervals()


def target(quantity: str, unit: str, limit: Any, verdict: str, judged: str = "9/10") -> dict[str, Any]:
    return {"quantity": quantity, "limit": str(limit), "unit": unit, "judged": f"population at confidence {judged}", "verdict": verdict}


def judged(certificate: Any, *targets: dict[str, Any]) -> Any:
    certificate = copy.deepcopy(certificate)
    certificate["targets"] = [*targets]
    verdicts = {t["verdict"] for t in targets}
    certificate["verdict"] = next(v for v in ("exceeds", "inconclusive", "within", "none") if v in verdicts or v == "none")
    return certificate


def test_verdicts_about_the_population(good: Any) -> None:
    low, high = map(F, good["intervals"]["local"]["ratio"])
    assert 1 < low < 4 < high
    mp.dps = 50
    log_low, log_high = (F(int(mp.log(mp.mpf(v.numerator) / v.denominator) * 10**30), 10**30) for v in (low, high))
    for unit, least, most, rounded in (("ratio", low, high, F(0)), ("log", log_low, log_high, F(1, 10**30))):
        for limit, verdict in (
            (least - TINY, "exceeds"),
            (least + rounded, "inconclusive"),
            (most - TINY, "inconclusive"),
            (most + rounded, "within"),
        ):
            for stated in ("within", "exceeds", "inconclusive"):
                certificate = judged(good, target("local", unit, limit, stated))
                assert accepted(certificate) is (stated == verdict), (unit, limit, stated)
                certificate["verdict"] = "within" if stated != "within" else "inconclusive"
                assert rejected(certificate)
    # The table's own figure is judged beside it, but not twice in one unit.
    own = {"quantity": "local", "limit": "4", "unit": "log", "judged": "this table", "verdict": "within"}
    assert accepted(judged(good, target("local", "ratio", high, "within"), own))
    assert rejected(judged(good, target("local", "log", high, "within"), own))


def test_verdicts_hold_together(good: Any) -> None:
    both = target("local", "ratio", 10**6, "within"), target("global", "ratio", 10**6, "within")
    assert rejected(judged(good, *both))  # each at 9/10: together at 8/10
    together = [t | {"judged": "population at confidence 4/5"} for t in both]
    assert accepted(judged(good, *together))
    assert rejected(judged(good, *[t | {"judged": "population at confidence 81/100"} for t in both]))
    assert rejected(judged(good, together[0], both[1]))
    assert accepted(judged(good, both[0], target("local", "log", 100, "within")))  # one interval, two limits
    assert rejected(judged(good, both[0] | {"judged": "population at confidence 91/100"}))
    assert accepted(judged(good, both[0] | {"judged": "population at confidence 1/100"}))
    for other in ("population", "the population at confidence 9/10", "population at confidence 9/10 ", "population at confidence 0.9"):
        assert rejected(judged(good, both[0] | {"judged": other}))
    for confidence in ("0", "1", "18/20", "11/10", "-1/2", "inf", ""):
        assert rejected(judged(good, both[0] | {"judged": f"population at confidence {confidence}"}))


def test_without_an_interval_nothing_is_known(good: Any) -> None:
    del good["intervals"]["global"]
    good["claims"] = [c for c in good["claims"] if c["quantity"] != "global_ratio" or c["scope"] == "this law"]
    assert accepted(judged(good, target("global", "ratio", 10**6, "inconclusive", "99/100")))
    assert rejected(judged(good, target("global", "ratio", 10**6, "within", "99/100")))
    probabilities = make({c: ["1/2", "1/2"] for c in COUNTS}, ["1", "0"], population="equal")
    assert accepted(probabilities)
    assert rejected(judged(probabilities, target("local", "ratio", 2, "inconclusive")))
    probabilities["intervals"] = good["intervals"]
    with pytest.raises(checker.FormatError):
        checker.check(raw(probabilities))
    assert not SCHEMA.is_valid(probabilities)


@pytest.mark.parametrize(
    ("at", "change"),
    [
        (-1, {"value": "1"}),
        (-2, {"value": "1000"}),
        (-2, {"value": "inf"}),
        (-2, {"value": "1/2"}),
        (-1, {"by": "hoeffding-kl"}),
        (-1, {"by": "T2"}),
        (-1, {"relation": "="}),
        (-1, {"relation": ">="}),
        (-1, {"quantity": "local_ratio"}),
        (-1, {"quantity": "equalized_odds"}),
        (-1, {"scope": "population at confidence 19/20"}),
        (-1, {"scope": "population at confidence 18/20"}),
        (-1, {"scope": "population"}),
        (-1, {"scope": "this law"}),
        (-1, {"evidence": {"interval": "local"}}),
        (-1, {"evidence": {"interval": "other"}}),
        (-1, {"evidence": {"interval": None}}),
        (-1, {"evidence": {}}),
        (-1, {"evidence": {"interval": "global", "table": "0" * 64}}),
    ],
)
def test_false_claims(good: Any, at: int, change: dict[str, Any]) -> None:
    assert accepted(good)
    good["claims"][at] |= change
    assert rejected(good)


def test_claims(good: Any) -> None:
    low, high = map(F, good["intervals"]["local"]["ratio"])
    own = claims("local", good["intervals"]["local"], "binomial")
    certificate = copy.deepcopy(good)
    others = certificate["claims"] = [*certificate["claims"][:-4], *certificate["claims"][-2:]]
    for claim, bound, away in ((own[0], low, -1), (own[1], high, 1)):
        for value, true in ((bound, True), (bound + away * TINY, True), (bound - away * TINY, False)):
            certificate["claims"].append(claim | {"value": str(value)})
            assert accepted(certificate) is true
            certificate["claims"].pop()
    for extra in (own[1] | {"value": "inf"}, own[0] | {"value": "1"}):
        certificate["claims"] = [*others, extra]
        assert accepted(certificate)
    certificate["claims"] += [extra]
    assert "occurs twice" in "".join(false_statements(certificate))
    del certificate["intervals"]["local"]
    assert "no interval" in "".join(false_statements(certificate))
    good["intervals"]["local"]["ratio"][1] = str(high - TINY)
    assert any("no interval" in line for line in false_statements(good) if line.startswith("claims"))


# Which claims of a policy bound what the population may be


def test_declared_constants_bound_a_policy_that_was_sampled() -> None:
    """e^eps is 2; nothing is known of the policy but that it stands behind its filter."""
    for draws in (None, 4):
        certificate = policy_by_hand()
        if draws:
            for row in rows_of(certificate)[1]:
                row["draws"] = draws
            digested(certificate)
        for limit, verdict in (("2", "within"), ("199/100", "inconclusive")):
            assert accepted(judged(certificate, target("local", "ratio", limit, verdict, "999/1000"))), draws
            assert accepted(judged(certificate, target("global", "ratio", limit, verdict, "999/1000")))
        certificate["claims"] = [c for c in certificate["claims"] if c["by"] not in ("T2", "T5", "T5-decision")]
        # T3, T12 and the floor of this law are about this policy; those of the declared floor need gamma declared, too.
        for limit in ("2", "4", "1000000"):
            assert accepted(judged(certificate, target("local", "ratio", limit, "inconclusive", "1/2")))
            assert accepted(judged(certificate, target("global", "ratio", limit, "inconclusive", "1/2")))
        certificate["subject"]["declared"]["gamma"] = "1"
        floored = min(F(c["value"]) for c in certificate["claims"] if c["scope"] == FLOORED)
        assert floored == 2
        assert accepted(judged(certificate, target("local", "ratio", 2, "within", "1/2")))
        assert accepted(judged(certificate, target("local", "ratio", "199/100", "inconclusive", "1/2")))


def test_t4_counts_with_declared_constants_only() -> None:
    pick = next(p for p in map(Policy, range(400)) if p.L == 0 and p.own["m"] > 0 and not p.declared and p.own["gamma"] > p.own["m"])
    certificate = write(pick)
    value = next(c["value"] for c in certificate["claims"] if c["by"] == "T4")
    certificate["claims"] = [c for c in certificate["claims"] if c["by"] not in ("T2", "T5", "T5-decision")]
    stated = judged(certificate, target("local", "ratio", value, "within"))
    constants = {key: str(pick.own[key]) for key in ("gamma", "m")}
    for declared in ({}, {"gamma": constants["gamma"]}, {"m": constants["m"]}):
        stated["subject"]["declared"] = declared
        assert rejected(stated)
    stated["subject"]["declared"] = constants
    assert accepted(stated)
    stated["claims"] = [c for c in stated["claims"] if c["by"] != "T4"]
    assert rejected(stated)
    stated["claims"].append({"quantity": "local_ratio", "relation": "<=", "value": value, "scope": POLICIES, "by": "T4", "assumptions": []})
    stated["claims"][-1]["evidence"] = {"multipliers": ["1000000"]}  # proves less
    assert rejected(stated)


def test_t5_of_a_table_is_not_about_the_population() -> None:
    certificate = make({(0, 0): ["30", "20"], (0, 1): ["20", "30"], (1, 0): ["3", "2"], (1, 1): ["2", "3"]}, ["1", "0"])
    assert any(c["by"] == "T5" for c in certificate["claims"])
    assert accepted(certificate)
    assert accepted(judged(certificate, target("global", "ratio", 10, "inconclusive")))
    assert rejected(judged(certificate, target("global", "ratio", 10, "within")))


# What the page must not allow


def test_a_ladder_from_a_cell_to_itself_proves_nothing() -> None:
    """Groups with the same row of the filter have one form; a ladder would have no step to prove."""
    certificate, p, draws = next(
        found
        for found in map(sampled, range(400))
        if not of_policy(found[1], found[2], "local")[2]
        and any(len(b[0]) == 1 and b[0] == b[1] for b in of_policy(found[1], found[2], "local")[1])
        and {len(f) for b in of_policy(found[1], found[2], "local")[1] for f in b} == {1}
    )
    cells, blocks, _ = of_policy(p, draws, "local")
    x = next(i for i, b in enumerate(blocks) if b[0] == b[1])
    found = interval(cells, blocks, independent=True)
    found |= {
        "region": "product",
        "levels": {"upper": ["0", "0"], "lower": ["0", "0"]},
        "ratio": ["1", "inf"],
        "upper": None,
        "lower": None,
    }
    del found["pair"]
    assert accepted(with_interval(certificate, "local", found, method_of(cells, blocks, found)))
    found |= {"ratio": ["2", "inf"], "lower": {"pair": [x, 0, 1], "knots": ["1/1000000", "1000000"]}}
    found["levels"]["lower"] = [str(ALPHA / 100), str(ALPHA / 200)]
    found["levels"]["upper"] = found["levels"]["lower"]
    lines = false_statements(with_interval(certificate, "local", found, method_of(cells, blocks, found)))
    assert any("equal" in line for line in lines)


def test_levels_of_more_than_one_are_no_levels(good: Any) -> None:
    """(1 - b - b')^2 is near 1 again when the levels are."""
    found = good["intervals"]["local"]
    found["independent"] = True
    for level in ("99/100", "999999/1000000"):
        found["levels"] = {"upper": level, "lower": level}
        assert rejected(good)


def test_intervals_need_whole_counts(good: Any) -> None:
    halves = make({c: [str(F(w) / 2) for w in row] for c, row in COUNTS.items()} | {(0, 0): ["41/2", "10"]}, ["1", "0"])
    halves["intervals"] = good["intervals"]
    assert sum("not integers" in line for line in false_statements(halves)) == 2


def test_intervals_and_classes_do_not_meet(good: Any) -> None:
    good["subject"]["class"] = {"quantity": "local", "gamma": "1", "m": "0", "tau": None, "tau_on": "all", "blind": True}
    good["subject"]["class"] |= {"lipschitz": None, "metric": None, "order": [], "rows": [], "family": None}
    with pytest.raises(checker.FormatError, match="intervals"):
        checker.check(raw(good))
    assert not SCHEMA.is_valid(good)
    del good["intervals"]
    del good["claims"][-4:]
    assert accepted(good)


@pytest.mark.parametrize(
    ("path", "value"),
    [
        ("intervals", {}),
        ("intervals", []),
        ("intervals.regional", {}),
        ("intervals.local", None),
        ("intervals.local.side", "upper"),
        ("intervals.local.side", ...),
        ("intervals.local.region", "sphere"),
        ("intervals.local.region", "product"),
        ("intervals.local.method", "binomial"),
        ("intervals.local.independent", 1),
        ("intervals.local.confidence", "0"),
        ("intervals.local.confidence", "1"),
        ("intervals.local.confidence", "18/20"),
        ("intervals.local.confidence", "0.9"),
        ("intervals.local.limits", ["1", "0"]),
        ("intervals.local.limits", ["-1", "1"]),
        ("intervals.local.limits", ["1"]),
        ("intervals.local.ratio", ["1"]),
        ("intervals.local.ratio", ["inf", "inf"]),
        ("intervals.local.ratio", ["1", None]),
        ("intervals.local.levels", ["1/80", "1/80"]),
        ("intervals.local.levels.upper", None),
        ("intervals.local.levels.upper", ["1/80", "1/80"]),
        ("intervals.local.upper", None),
        ("intervals.local.upper.0", ["0"]),
        ("intervals.local.upper.0", ["0", "1", "1"]),
        ("intervals.local.upper.0.1", "inf"),
        ("intervals.local.pair", ...),
        ("intervals.local.pair", [0, 1]),
        ("intervals.local.pair", [0, -1, 1]),
        ("intervals.local.pair", ["0", "1", "0"]),
        ("intervals.local.cells", []),
        ("intervals.local.units", None),
        ("intervals.local.units", [[[0, [1, 0]]]]),
        ("intervals.local.units", [[[1, [0, 0]]]]),
        ("intervals.local.units", [[[1, [1, 0]], [2, [1, 0]]]]),
        ("intervals.local.units", [[[1, [1, -1]]]]),
        ("intervals.local.units", [[[1]]]),
        ("intervals.global.units", []),
    ],
)
def test_malformed(good: Any, path: str, value: Any) -> None:
    with pytest.raises(checker.FormatError):
        checker.check(raw(edited(good, path, value)))


def test_every_value_of_a_wrong_type() -> None:
    """Whatever stands anywhere in an interval, the outcome is a report or a FormatError."""
    seen = set()
    for seed, name in product(SEEDS, ("local", "global")):
        made = certified(seed, name)
        if made is None or len(made[1]) > 4:
            continue
        certificate = copy.deepcopy(made[0])
        found = certificate["intervals"][name]
        kind = (found["region"], found["upper"] is None, found["lower"] is None, "units" in found)
        if kind in seen:
            continue
        seen.add(kind)

        def replace_all(value: Any, put: Callable[[Any], None], certificate: Any = certificate) -> None:
            junk: Any
            for junk in (None, True, 7, "", "0", "1/3", "inf", [], {}, [[]], [None], [7, 7, 7], ["1", "2"]):
                put(junk)
                try:
                    checker.check(raw(certificate))
                except checker.FormatError as error:
                    assert len(str(error)) < 1000
            put(value)
            for key in list(value) if isinstance(value, dict) else range(len(value)) if isinstance(value, list) else ():
                replace_all(value[key], lambda item, key=key: value.__setitem__(key, item))  # type: ignore[misc]

        replace_all(found, lambda item, certificate=certificate, name=name: certificate["intervals"].__setitem__(name, item))  # type: ignore[misc]
        assert accepted(certificate)
    assert len(seen) >= 4


# Tails


@pytest.mark.parametrize("level", ["1/40", "1/3120", "1/1000000000"])
@pytest.mark.parametrize(
    ("n", "k"), [(1, 0), (1, 1), (2, 1), (40, 0), (40, 39), (300, 7), (1000, 800), (5000, 17), (5001, 2000), (10**8, 10**7)]
)
def test_tails_are_decided_on_either_side(n: int, k: int, level: str) -> None:
    """Of neighbours on a fine grid the checker accepts the one and not the other."""
    cell = cell_of([(k, F(1)), (n - k, F(0))], F(0), F(1), True)
    sample = checker.tails.Sample(n, F(k), F(k), F(0), F(1), True)
    for lower in (True, False):
        if k == (n if lower else 0):
            assert not checker.tails.tails_at_most([sample.tail(F(1, 2), lower)], F(level))
            continue
        steps = 2**30
        at = first(steps, lambda i: i == steps or below(tail(cell, F(i if lower else steps - i, steps), lower), F(level)))  # noqa: B023
        for i, holds in ((at, True), (at - 1, False)):
            mean = F(i if lower else steps - i, steps)
            assert checker.tails.tails_at_most([sample.tail(mean, lower)], F(level)) is holds


def test_a_tail_that_is_the_level() -> None:
    for n, binary in product((1, 2, 3, 30), (True, False)):
        sample = checker.tails.Sample(n, F(0), F(0), F(0), F(3), binary)
        for p in (F(1, 2), F(7, 8), F(999, 1000)):
            level = (1 - p) ** n
            assert checker.tails.tails_at_most([sample.tail(3 * p, True)], level)
            assert not checker.tails.tails_at_most([sample.tail(3 * p, True)], level * (1 - F(1, 10**100)))
            assert checker.tails.tails_at_most([sample.tail(3 * p, True)] * 2, level**2)
            assert not checker.tails.tails_at_most([sample.tail(3 * p, True)] * 2, level**2 * (1 - F(1, 10**100)))


def test_many_draws() -> None:
    """A hundred million draws in each of forty cells, by the quick bounds of both sides."""
    pick = random.Random(2)
    n = 10**8
    counts = {(x, a): pick.randint(30_000_000, 40_000_000) for x in range(20) for a in range(2)}
    weights = {cell: [str(k), str(n - k)] for cell, k in counts.items()}
    certificate = make(weights, ["1", "0"])
    cells, blocks = of_counts(certificate, "local", None, None)
    found = interval(cells, blocks)
    assert max(F(hi) - F(lo) for lo, hi in found["upper"]) <= F(3, GRID)
    full = with_interval(certificate, "local", found, "binomial")
    assert accepted(full)
    pick = random.Random(3)
    taken, refused = compare_readings(full, "local", from_counts(full, "local"), lambda changes: pick.sample(changes, 60))
    assert taken > 10 and refused > 10


# Certificates as they are written


UCB = "ucb_admissions.csv --decision Admit --group Gender --context Dept --count Freq"
FIRST = "gpt_resume_first_counts.csv --decision decision --group group --context model,job --count n"
NAMES = "hiringbias_firstname.csv --decision recommend_interview --group name"
CASES = [
    f"{UCB} --utility Admitted --max-local-ratio 2",
    f"{UCB} --utility Admitted=1,Rejected=1/3 --utility-range 0,1 --max-global-ratio 3 --max-local-ratio 5 --confidence 0.99",
    f"{UCB} --utility Admitted --independent-cells --max-local-log 1/10",
    f"{FIRST} --utility first=1",
    f"{FIRST} --utility first --independent-cells --max-local-ratio 5/4",
    f"{NAMES} --context model,jd --utility yes=1,maybe=1/2 --interval empirical-bernstein",
    f"{NAMES} --context model --utility yes=1,maybe=1/2 --unit run --interval intersection",
]


@pytest.fixture(scope="module")
def written(data: Path, tmp_path_factory: pytest.TempPathFactory) -> list[Path]:
    """Certificates as the command writes them."""
    paths = []
    for i, case in enumerate(CASES):
        table, *options = case.split()
        paths.append(tmp_path_factory.mktemp("certificates") / f"{i}.json")
        command = [sys.executable, "-m", "fairaudit", "certify", str(data / table), *options, "-o", str(paths[-1])]
        finished = subprocess.run(command, capture_output=True, text=True, check=False)
        assert finished.returncode in (0, 1, 3), finished.stderr
    return paths


@pytest.mark.parametrize("at", range(len(CASES)))
def test_certificates_as_they_are_written(written: list[Path], at: int) -> None:
    """They are true, and whatever number in one is changed, the second reading agrees with the checker."""
    certificate = json.loads(written[at].read_bytes())
    assert "local" in certificate["intervals"]
    assert accepted(certificate), false_statements(certificate)
    pick = random.Random(at)
    for name, found in certificate["intervals"].items():
        derive = from_counts(certificate, name)
        cells, blocks, *_ = derive(found["limits"], found.get("units")) or ([], [], False, None)
        stated = [c for c in certificate["claims"] if c["relation"] == ">=" and c["quantity"] == f"{name}_ratio"]
        assert {c["by"] for c in stated} == {method_of(cells, blocks, found)}
        _, refused = compare_readings(certificate, name, derive, lambda changes: pick.sample(changes, 20))
        assert refused > 3
