"""Intervals and their evidence, against a second reading of docs/certificate-samples.md in plain fractions."""

import copy
import json
import random
import subprocess
import sys
from collections.abc import Callable
from fractions import Fraction
from functools import cache
from itertools import permutations, product
from math import lcm
from pathlib import Path
from typing import Any

import pytest
import tiers
from interval_certificates import (
    ALPHA,
    COUNTS,
    GRID,
    TINY,
    Cell,
    Derive,
    F,
    Form,
    accepted,
    area,
    below,
    both_intervals,
    cell_of,
    compare_readings,
    figures,
    first,
    from_counts,
    interval,
    measured,
    of_counts,
    rejected,
    rows_of,
    stands,
    tail,
    with_interval,
)
from plain_certificates import checker, edited, false_statements, make, raw
from policy_certificates import SCHEMA, Policy, digested, write

import fairaudit as fa


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


def by_ladders(cells: list[Cell], blocks: list[list[Form]], ends: str) -> dict[str, Any] | None:
    used, _, pairs = figures(cells, blocks)
    K = len(used)
    if not K or any([*form.values()] != [1] for block in blocks for form in block):
        return None
    share, count, products = (ALPHA, 2 * K, pairs) if ends == "each" else (ALPHA / 2, max(2, 2 * K - 2), pairs - 1)
    b, prime = F(4, 5) * share / 2, F(4, 5) * share / count
    c, other = b, prime
    while area(b, c) > share / 5 - F(1, 10**6):
        c *= F(9, 10)
    while products * area(prime, other) > share / 5 - F(1, 10**6) or (ends == "together" and other > c):
        other *= F(9, 10)
    if not (b * b <= c and prime**2 <= other):
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
        if members[x][i] != members[x][j] and (knots := ladder(cells, [members[x][j]], [members[x][i]], 1 / r, prime, other)):
            low, lower = str(r), {"pair": [x, i, j], "knots": [*map(str, knots)]}
            break
    levels = {"upper": [str(b), str(c)], "lower": [str(prime), str(other)]}
    return {"region": "product", "ratio": [low, high], "levels": levels, "upper": upper, "lower": lower}


def method_of(cells: list[Cell], blocks: list[list[Form]], interval: dict[str, Any]) -> str:
    used, _, _ = figures(cells, blocks)
    if interval["region"] == "pairs":
        return "pair-exact"
    return "binomial" if all(cells[i]["binary"] for i in used) else interval["method"]


def random_counts(seed: int) -> tuple[Any, random.Random]:
    pick = random.Random(tiers.fresh(seed))
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
    ends = "each" if seed % 4 == 1 else "together"
    found = interval(cells, blocks, independent=independent, method=method, limits=limits, ends=ends)
    if independent and pick.random() < 0.6 and (method == "hoeffding-kl" or all(c["binary"] for c in cells)):
        found |= by_ladders(cells, blocks, ends) or {}
        if found["region"] == "product":
            found.pop("pair", None)
    if units is not None:
        found |= {"units": units, "estimand": "mean over units", "measured": measured(certificate, cells, blocks)}
    return with_interval(certificate, name, found, method_of(cells, blocks, found)), cells, blocks


SEEDS = range(120)


@pytest.mark.parametrize("block", range(6 if tiers.FULL else 2))
def test_random_intervals(block: int) -> None:
    pick = random.Random(tiers.fresh(block))
    taken = refused = 0
    for seed, name in product(SEEDS[block::6], ("local", "global")):
        made = certified(seed, name)
        if made is not None:
            assert accepted(made[0]), (seed, false_statements(made[0]))
            derive = from_counts(made[0], name)
            counts = compare_readings(made[0], name, derive, lambda changes: pick.sample(changes, min(len(changes), 40)))
            taken, refused = taken + counts[0], refused + counts[1]
    assert tiers.enough(taken > 100 and refused > 300)


def test_the_random_intervals_are_of_many_kinds() -> None:
    made = [found for seed in SEEDS for name in ("local", "global") if (found := certified(seed, name))]
    kinds = [next(iter(c["intervals"].values())) for c, _, _ in made]
    assert {k["region"] for k in kinds} == {"box", "product"} and {k["independent"] for k in kinds} == {True, False}
    assert {(k["region"], k["ends"]) for k in kinds} == {*product(("box", "product"), ("together", "each"))}
    for method in ("binomial", "hoeffding-kl", "empirical-bernstein", "intersection"):
        assert sum(c["claims"][-1]["by"] == method for c, _, _ in made) > 4
    assert tiers.enough(sum("units" in k for k in kinds) > 5 and sum(k["limits"] is not None for k in kinds) > 5)
    assert tiers.enough(sum(k["ratio"][1] == "inf" for k in kinds) > 5 and sum(k["ratio"][1] != "inf" for k in kinds) > 20)
    assert tiers.enough(sum(k["ratio"][0] != "1" for k in kinds) > 10)
    assert tiers.enough(sum(k["region"] == "product" and k["ratio"] != ["1", "inf"] for k in kinds) > 3)


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


@cache
def sampled(seed: int) -> tuple[Any, Policy, dict[tuple[int, int], int]]:
    p = Policy(tiers.fresh(seed))
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
    pick = random.Random(tiers.fresh(1))
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
                common = {"confidence": "9/10", "ends": "together", "region": "box", "independent": False, "method": "intersection"}
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
    assert tiers.enough({kind[:2] for kind in kinds} == set(product(("local", "global"), (True, False))))
    assert tiers.enough(any(kind[2] for kind in kinds) and any(kind[3] for kind in kinds))
    assert tiers.enough(taken > 50 and refused > 200)


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


@pytest.fixture
def good() -> Any:
    return both_intervals()


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
    found["levels"]["lower"] = [str(ALPHA / 1000), str(ALPHA / 10_000)]
    found["levels"]["upper"] = found["levels"]["lower"]
    lines = false_statements(with_interval(certificate, "local", found, method_of(cells, blocks, found)))
    assert any("equal" in line for line in lines)


def test_levels_of_more_than_one_are_no_levels(good: Any) -> None:
    """(1 - b - b')^2 is near 1 again when the levels are."""
    found = good["intervals"]["global"]
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
        ("intervals.local.ends", "upper"),
        ("intervals.local.ends", ...),
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
        ("intervals.local.ratio", ["infinite", "inf"]),
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
    assert tiers.enough(len(seen) >= 4)


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
    pick = random.Random(tiers.fresh(at))
    for name, found in certificate["intervals"].items():
        derive = from_counts(certificate, name)
        cells, blocks, *_ = derive(found["limits"], found.get("units")) or ([], [], False, None)
        stated = [c for c in certificate["claims"] if c["relation"] == ">=" and c["quantity"] == f"{name}_ratio"]
        assert {c["by"] for c in stated} == {method_of(cells, blocks, found)}
        if found["region"] == "pairs":  # tests/inference/test_pair_region.py reads and alters those
            continue
        _, refused = compare_readings(certificate, name, derive, lambda changes: pick.sample(changes, 20))
        assert refused > 3


def test_how_many_samples_two_forms_rest_on() -> None:
    pick = random.Random(tiers.fresh(4))
    for _ in range(2_000):
        supports = [pick.sample(range(5), pick.choice([0, 1, 1, 1, 2, 3])) for _ in range(pick.randint(2, 4))]
        most = max(len({*one, *other}) for one, other in permutations(supports, 2))
        assert checker.interval_proofs._spanned(supports) == most


@pytest.mark.parametrize(("worth", "true"), [(0, True), (1, False)])
def test_the_lower_end_is_infinite_where_a_group_is_certain_to_get_nothing(worth: int, true: bool) -> None:
    law = fa.Law.from_array([[5, 5], [10, 0]], kind="counts", decisions=["no", "yes"], groups=["A", "B"])
    utility = fa.Utility.from_function(lambda decision, _, group: worth * (decision == "yes") + ("A" in group), law)
    document = json.loads(fa.certify(law, utility, max_local_ratio=2).certificate.text)
    assert (document["intervals"]["local"]["ratio"][0] == "inf") is true
    document["intervals"]["local"]["ratio"] = ["inf", "inf"]
    assert SCHEMA.is_valid(document)
    assert checker.check(json.dumps(document).encode()).ok is true
