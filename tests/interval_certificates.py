"""Intervals for the population behind a sample: a dense second reading of docs/certificate-samples.md."""

import copy
from collections.abc import Callable, Iterator
from fractions import Fraction
from functools import cache
from itertools import chain, pairwise, permutations
from math import ceil, comb, floor
from typing import Any

from assumptions import complete
from mpmath import mp
from plain_certificates import INF, checker, false_statements, log_pair, make, raw, text
from policy_certificates import SCHEMA

F = Fraction
ALPHA = F(1, 10)
GRID = 2**12  # ends are multiples of the range over this
TINY = F(1, 10**12)
Cell = dict[str, Any]
Form = dict[int, Fraction]


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


def by_box(cells: list[Cell], blocks: list[list[Form]], independent: bool, method: str, ends: str) -> dict[str, Any]:
    used, s, _ = figures(cells, blocks)
    K = len(used)
    beta, prime = (ALPHA / (2 * s), ALPHA / (2 * (2 * K - s))) if K else (F(0), F(0))
    if ends == "each" and K:
        beta, prime = ALPHA / s, ALPHA / (2 * K)
        if independent:
            beta *= 1 + F(first(1000, lambda t: 1 - (1 - beta * (1 + F(t, 1000))) ** s > ALPHA) - 1, 1000)
            prime *= 1 + F(first(1000, lambda t: 1 - (1 - 2 * prime * (1 + F(t, 1000))) ** K > ALPHA) - 1, 1000)
    elif independent and K:
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


def interval(
    cells: list[Cell],
    blocks: list[list[Form]],
    *,
    independent: bool = False,
    method: str = "hoeffding-kl",
    limits: Any = None,
    ends: str = "together",
) -> dict[str, Any]:
    common = {"confidence": str(1 - ALPHA), "ends": ends, "independent": independent, "method": method, "limits": limits}
    return common | by_box(cells, blocks, independent, method, ends)


def claims(name: str, interval: dict[str, Any], by: str) -> list[dict[str, Any]]:
    opening = "population, one-sided at confidence" if interval["ends"] == "each" else "population at confidence"
    common = {"quantity": f"{name}_ratio", "scope": f"{opening} {interval['confidence']}", "by": by}
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
    shapes = shapes and ("units" not in found or found["units"] is not None) and found["ends"] in ("together", "each")
    derived = derive(found["limits"], found.get("units")) if shapes and 0 < c < 1 else None
    if derived is None or low < 1 or high < 1 or (found["independent"] and derived[2] and "units" not in found):
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
        box = [(F(lo), F(hi)) for lo, hi in every_end(found[key], cells, level if key == "upper" else None, found["method"])]
        for cell, (lo, hi) in zip(cells, box, strict=True):
            least, most = cell["range"]
            if not least <= lo <= hi <= most or (not informative(cell) and (lo, hi) != (least, most)):
                return False
            if lo > least and not excluded(cell, lo, level, found["method"], False):
                return False
            if hi < most and not excluded(cell, hi, level, found["method"], True):
                return False
        boxes.append(box)
    if not box_levels_keep(found["ends"], beta, prime, (K, s), alpha, found["independent"]):
        return False
    if max(greatest(u, v, boxes[0]) for block in blocks for u, v in permutations(block, 2)) > ratio[1]:
        return False
    if found["pair"] is None:
        return bool(ratio[0] == 1)
    b, i, j = found["pair"]
    return bool(ratio[0] > 1 and i != j and inverse(greatest(blocks[b][j], blocks[b][i], boxes[1])) >= ratio[0])


def every_end(given: Any, cells: list[Cell], level: Fraction | None, method: str) -> list[Any]:
    """The ends of all cells: of those that are not listed the range, or at a level the plain ends."""
    if not isinstance(given, dict):
        return [*given]
    listed = dict(zip(given["cells"], given["ends"], strict=True))
    assert given.keys() == {"cells", "ends"}
    if sorted(listed) != given["cells"] or not listed.keys() <= {*range(len(cells))}:
        raise ValueError(given["cells"])
    return [listed[i] if i in listed else plain_ends(cell, level, method) for i, cell in enumerate(cells)]


def plain_ends(cell: Cell, level: Fraction | None, method: str) -> tuple[Fraction, Fraction]:
    """By the words of docs/certificate-samples.md, with bisection."""
    low, high = cell["range"]
    if level is None or not informative(cell):
        return low, high
    if not 0 < level < 1 or (not cell["binary"] and method != "hoeffding-kl"):
        raise ValueError("no plain ends")
    mp.dps = 60
    reach = F(int(mp.ceil(mp.log(mp.mpf(level.denominator) / level.numerator) * 2**32)), 2**32)
    z = (cell["sum"] / cell["draws"] - low) / (high - low)
    least, most = plain_lower(z, cell["draws"], reach), 1 - plain_lower(1 - z, cell["draws"], reach)
    return low + (high - low) * least, low + (high - low) * most


def plain_lower(z: Fraction, n: int, reach: Fraction) -> Fraction:
    """b(z)."""

    def reached(p: Fraction) -> bool:
        middle = min(max(p, F(1, 2)), z)
        return p < z and n * (p - z) ** 2 >= 2 * middle * (1 - middle) * reach

    if not z:
        return F(0)
    inside, outside = 0, 2**32
    while outside - inside > 1:
        at = (inside + outside) // 2
        inside, outside = (at, outside) if reached(F(at, 2**32)) else (inside, at)
    halved = z / 2 ** ceil(F(13, 9) * (1 + reach / (n * z)))
    return max(F(inside, 2**32), F(floor(halved * 2**32), 2**32))


def box_levels_keep(ends: str, beta: Fraction, prime: Fraction, numbers: tuple[int, int], alpha: Fraction, independent: bool) -> bool:
    K, s = numbers
    if not K:
        return bool(beta == prime == 0)
    if ends == "each":
        upper = s * beta <= alpha or (independent and 1 - (1 - beta) ** s <= alpha)
        lower = 2 * K * prime <= alpha or (independent and 2 * prime < 1 and 1 - (1 - 2 * prime) ** K <= alpha)
        return bool(0 < beta < 1 and 0 < prime < 1 and upper and lower)
    alone = independent and beta + prime < 1 and any_wrong(beta, prime, K, s, F(1)) <= alpha
    halves = s * beta == (2 * K - s) * prime
    return bool(0 < prime <= beta < 1 and halves and (s * beta + (2 * K - s) * prime <= alpha or alone))


def read_ladders(
    found: Any, cells: list[Cell], blocks: list[list[Form]], ratio: Any, alpha: Fraction, numbers: tuple[int, int, int]
) -> bool:
    K, _, pairs = numbers
    (b, c), (prime, other) = ([*map(F, found["levels"][key])] for key in ("upper", "lower"))
    if not found["independent"] or any([*form.values()] != [1] for block in blocks for form in block):
        return False
    if found["method"] != "hoeffding-kl" and not all(cell["binary"] for cell in cells if informative(cell)):
        return False
    if not (b * b <= c <= b < 1 and prime * prime <= other <= prime < 1):
        return False
    if found["ends"] == "each":
        share, ends, products = alpha, 2 * K, pairs
    else:
        share, ends, products = alpha / 2, max(2, 2 * K - 2), pairs - 1
        if prime > b or other > c:
            return False
    if max(2 * b, ends * prime) > F(4, 5) * share or max(area(b, c), products * area(prime, other)) > share / 5:
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
    elif value in ("together", "each"):
        changes = ["together", "each", "both"]
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


COUNTS = {(0, 0): ["40", "10"], (0, 1): ["10", "40"], (1, 0): ["30", "20"], (1, 1): ["25", "25"]}


def both_intervals(ends: str = "together") -> Any:
    certificate = make(COUNTS, ["1", "0"])
    for name in ("local", "global"):
        cells, blocks = of_counts(certificate, name, None, None)
        certificate = with_interval(certificate, name, interval(cells, blocks, ends=ends), "binomial")
    return certificate
