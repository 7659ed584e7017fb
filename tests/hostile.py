"""Documents of less than a megabyte that are meant to keep a checker busy for long, or to fill its memory."""

from __future__ import annotations

import copy
import json
import random
from collections.abc import Callable, Iterator
from functools import cache
from itertools import product
from math import gcd
from typing import Any

import tiers
from certificates import KINDS, random_certificate
from mpmath import mp

LARGEST = 999_000
Pick = random.Random


@cache
def _honest(kind: str, number: int) -> str:
    seeds = [seed for seed in range(60 * len(KINDS)) if KINDS[seed % len(KINDS)].__name__ == kind]
    return random_certificate(seeds[number]).text


def honest(pick: Pick, *kinds: str) -> Any:
    return json.loads(_honest(pick.choice(kinds), pick.randrange(4)))


def digits(pick: Pick, count: int) -> str:
    return str(pick.randrange(1, 10)) + "".join(pick.choices("0123456789", k=count - 1))


def odd(pick: Pick, count: int) -> str:
    """A long number that shares few divisors with others."""
    return digits(pick, max(1, count - 1)) + pick.choice("1379")


def size(pick: Pick, least: float = 3.0) -> int:
    """Characters for the document: mostly near the limit."""
    return int(10 ** pick.uniform(least, 5.99))


def long_rational(pick: Pick, count: int) -> str:
    count = min(count, 199_000)
    return (
        f"{2 ** (count * 3 // 2)}/{odd(pick, count - count // 2)}" if count < 8000 else f"1{'0' * (count // 2)}/{digits(pick, count // 2)}3"
    )


def rationals(value: Any, path: tuple[Any, ...] = ()) -> Iterator[tuple[Any, ...]]:
    if isinstance(value, str) and value.replace("/", "").isdigit() and len(value) < 60:
        yield path
    for key in value if isinstance(value, dict) else range(len(value)) if isinstance(value, list) else ():
        yield from rationals(value[key], (*path, key))


def put(document: Any, path: tuple[Any, ...], value: Any) -> None:
    for step in path[:-1]:
        document = document[step]
    document[path[-1]] = value


def long_numbers(pick: Pick) -> Any:
    """An honest certificate in which some numbers are long."""
    document = honest(pick, *{kind.__name__ for kind in KINDS})
    places = list(rationals(document))
    chosen = pick.sample(places, min(len(places), pick.choice([1, 2, 5, 50])))
    each = (size(pick) - 1000) // len(chosen)
    for path in chosen:
        put(document, path, pick.choice([long_rational, odd])(pick, max(20, min(each, 99_000))))
    return document


def long_numbers_in_intervals(pick: Pick) -> Any:
    """Long levels, ends, knots, limits."""
    document = honest(pick, "sample", "units", "stream", "policy")
    places = [path for path in rationals(document.get("intervals", {}), ("intervals",)) if "units" not in path]
    chosen = pick.sample(places, min(len(places), pick.choice([1, 2, 20])))
    for path in chosen:
        small = f"1/{odd(pick, min(99_000, size(pick) // len(chosen)))}"
        put(document, path, pick.choice([small, long_rational(pick, size(pick) // len(chosen))]))
    return document


def _plain(pick: Pick, decisions: int, groups: int, contexts: int, row: Callable[[int, int], dict[str, Any]], **header: Any) -> Any:
    """A certificate of a table that is laid out here; its figures are those of another one."""
    document = honest(pick, "counts")
    columns = document["subject"]["columns"]
    head = {
        "format": "fairaudit-table/1",
        "kind": "counts",
        "columns": columns,
        "population": "counts",
        "decisions": [str(i) for i in range(decisions)],
        "groups": [[str(i)] for i in range(groups)],
        "contexts": [[str(i)] for i in range(contexts)],
        "utility": ["1"] + ["0"] * (decisions - 1),
    }
    rows = [{"context": x, "group": a} | row(x, a) for x in range(contexts) for a in range(groups)]
    document["subject"]["table"] |= {"header": head | header, "rows": rows}
    return document


def coprime_weights(pick: Pick) -> Any:
    """Rows whose weights have no common denominator but a long one."""
    n = size(pick, 4)
    decisions = pick.choice([2, 30, 300, 3000])
    cells = pick.choice([2, 10, 100, 1000])
    each = max(6, n // (decisions * cells + 100))
    contexts = max(1, cells // 2)
    return _plain(pick, decisions, 2, contexts, lambda x, a: {"weights": [f"1/{odd(pick, each)}" for _ in range(decisions)]})


def coprime_utilities(pick: Pick) -> Any:
    """Utilities that stand with the cells and have no common denominator."""
    n = size(pick, 4)
    decisions, contexts = pick.choice([(2, 100), (100, 10), (1000, 1), (3, 3000)])
    each = max(4, n // (2 * decisions * contexts) - 12)

    def row(x: int, a: int) -> dict[str, Any]:
        return {"weights": ["1"] * decisions, "utility": [f"1/{odd(pick, each)}" for _ in range(decisions)]}

    return _plain(pick, decisions, 2, contexts, row, utility=None)


def many_groups(pick: Pick) -> Any:
    """One context with many groups whose laws are nearly at the greatest distance."""
    groups = pick.choice([100, 3000, 12_000])
    far = [["10000000", "1", "1"], ["1", "1", "10000000"]]

    def row(x: int, a: int) -> dict[str, Any]:
        return {"weights": [f"{int(w) + pick.randrange(9)}" if len(w) > 1 else w for w in far[a % 2]]}

    return _plain(pick, 3, groups, 1, row)


def many_labels(pick: Pick) -> Any:
    """Many contexts and groups, and nearly no cells."""
    n = pick.choice([1000, 20_000, 40_000])
    document = _plain(pick, 2, 2, 1, lambda x, a: {"weights": ["1", "1"]})
    header = document["subject"]["table"]["header"]
    header |= {"groups": [[str(i)] for i in range(n)], "contexts": [[str(i)] for i in range(n)]}
    document["not_compared"] = [{"context": [str(i)], "groups": [[str(i)]], "reason": "no decisions recorded"} for i in range(100)]
    return document


def preparations(pick: Pick) -> Any:
    """As many entries of what was done to the log as there are labels, each of which has to be looked for in the table."""
    step = pick.choice(["intervals", "mapped", "folded", "level"])
    n = pick.choice([1500, 5000])
    document = _plain(pick, 2, n if step == "level" else 2, 1, lambda x, a: {"weights": ["1", "1"]})
    labels = [f"{i:05}" for i in range(n)]
    entries: list[dict[str, Any]] = [{"step": step, "label": label} for label in labels]
    if step == "intervals":
        labels = ["under 0", *(f"{i} to under {i + 1}" for i in range(n)), f"{n} and over"]
        entries = [{"step": step, "edges": [str(i) for i in range(n + 1)]}]
    more: dict[str, dict[str, Any]] = {"mapped": {"from": ["x"]}, "folded": {"from": ["x"]}, "level": {"decisions": "2"}}
    [column] = document["subject"]["columns"]["group"]
    document["subject"]["table"]["header"]["groups"] = [[label] for label in labels]
    document["subject"]["preparation"] = [entry | {"column": column} | more.get(step, {}) for entry in entries]
    document["subject"]["table"]["header"]["preparation"] = "0" * 64
    return document


def combining_marks(pick: Pick) -> Any:
    """A label whose marks stand as far as can be from their canonical order."""
    n = pick.choice([20_000, 80_000])
    document = _plain(pick, 2, 2, 1, lambda x, a: {"weights": ["1", "1"]})
    document["subject"]["table"]["header"]["groups"] = [["a"], ["a" + "\u0301" * (n // 2) + "\u0323" * (n // 2)]]
    return document


def _policy(
    pick: Pick, inputs: list[int], outputs: int, entry: Callable[[int, int], str] | None = None, context: list[int] | None = None
) -> Any:
    """A policy behind a product of filters."""
    document = next(d for d in (honest(pick, "policy") for _ in iter(int, 1)) if "intervals" not in d or pick.random() < 0.5)
    rng = pick

    def factor(k: int) -> dict[str, Any]:
        rows = []
        for i in range(k):
            if entry:
                weights = [entry(i, j) for j in range(outputs)]
            else:
                numbers = [rng.randint(1, 9) for _ in range(outputs)]
                weights = [_lowest(v, sum(numbers)) for v in numbers]
            rows.append(weights)
        return {"inputs": [[f"i{i}"] for i in range(k)], "outputs": [[f"o{j}"] for j in range(outputs)], "rows": rows}

    factors = [factor(k) for k in inputs]
    of_context = None if context is None else [factor(k) for k in context]
    subject = document["subject"]
    columns = {
        "decision": "u",
        "group": [f"g{i}" for i in range(len(factors))],
        "context": [f"x{i}" for i in range(len(context or [0]))],
    }
    groups = [list(labels) for labels in product(*([f"o{j}" for j in range(outputs)] for _ in factors))]
    contexts = [list(labels) for labels in product(*([f"o{j}" for j in range(outputs)] for _ in context))] if context else [["x"], ["y"]]
    header = {
        "format": "fairaudit-table/1",
        "kind": "policy",
        "columns": columns,
        "population": "equal",
        "decisions": ["yes", "no"],
        "groups": groups,
        "contexts": contexts,
        "utility": ["1", "1/3"],
        "filters": {"group": factors, "context": of_context},
    }
    rows = [
        {"context": x, "group": a, "weights": [f"{v}/10", f"{10 - v}/10"]}
        for x in range(len(contexts))
        for a in range(len(groups))
        for v in (rng.choice([1, 3, 7, 9]),)
    ]
    subject |= {"columns": columns, "population": "equal", "utility": subject["utility"] | {"lipschitz": "0", "depends_on_group": False}}
    subject["table"] = {"sha256": "0" * 64, "cells": 2 * len(rows), "header": header, "rows": rows}
    subject["declared"] = {"tau": "1/100", "gamma": "1"}
    for key in document["metrics"]:
        document["metrics"][key] = None
    document["not_compared"] = []
    document.pop("intervals", None)
    document["targets"] = []
    ks = [str(k) for k in range(pick.choice([1, 5, 500]))]
    floored = "any policy behind this filter that keeps the declared floor"
    document["claims"] = [
        {
            "quantity": "local_ratio",
            "relation": "<=",
            "value": "99",
            "scope": scope,
            "by": by,
            "assumptions": [],
            "evidence": {"multipliers": ks},
        }
        for by, scope in (("T1", floored), ("T3", floored), ("T4", "any policy behind this filter"), ("T1", "this law"))
    ]
    return document


def _lowest(n: int, d: int) -> str:
    g = gcd(n, d)
    return f"{n // g}" if g == d else f"{n // g}/{d // g}"


def generic_filters(pick: Pick) -> Any:
    """Products of tables without any two alike pairs of rows."""
    k = pick.choice([5, 9, 12, 24])
    return _policy(pick, [k] * pick.choice([1, 2, 3] if k < 9 else [2]), min(k, pick.choice([3, k])))


def many_inputs(pick: Pick) -> Any:
    """Few outputs, and a product of many inputs."""
    count, width = pick.choice([(7, 10), (5, 10), (12, 2), (20, 2), (3, 40), (4, 30)])
    context = pick.choice([None, [10] * 3, [30, 30]])
    return _policy(pick, [width] * count, 1, lambda i, j: "1", context)


def large_filter(pick: Pick) -> Any:
    """One filter with many inputs and outputs."""
    k = pick.choice([50, 150, 250])

    def entry(i: int, j: int) -> str:
        return _lowest(k + 1, 2 * k) if i == j else _lowest(1, 2 * k)

    return _policy(pick, [k], k, entry if pick.random() < 0.5 else None)


def long_filters(pick: Pick) -> Any:
    """A filter of which each row has its own long denominator."""
    k = pick.choice([2, 10, 40])
    each = max(4, size(pick) // (k * 4))

    def row(i: int, j: int) -> str:
        if i not in known:
            d = int(odd(pick, min(each, 3000)))
            known[i] = d
        d = known[i]
        return _lowest(1, d) if j == 0 else _lowest(d - 1, d)

    known: dict[int, int] = {}
    return _policy(pick, [k, k], 2, row)


def greatest_ratios(pick: Pick) -> Any:
    """Claims about all policies in all scopes, with as much evidence as there can be, for utilities of each group in each context."""
    document = pick.choice([generic_filters, generic_filters, many_inputs, large_filter, long_filters])(pick)
    subject = document["subject"]
    header, rows = subject["table"]["header"], subject["table"]["rows"]
    of_group, of_context = header["filters"]["group"], header["filters"]["context"]
    contexts = [["x"], ["y"]]
    if of_context:
        contexts = [[*labels] for labels in product(*([f"i{i}" for i in range(len(factor["inputs"]))] for factor in of_context))]
    groups = [len(of_group), len(of_group[0]["inputs"])]
    releases = pick.choice([1, 1, 1, 2, 100, 10_000])
    if releases > 1:
        header["filters"]["releases"] = releases
    cells = len(contexts) * groups[1] ** groups[0]
    if cells < 4000 and pick.random() < 0.7:
        header["utility"] = None
        rows += [
            {"true_context": x, "true_group": a, "utility": [_lowest(pick.randrange(1, 99), 99), _lowest(pick.randrange(1, 99), 98)]}
            for x, a in product(range(len(contexts)), range(groups[1] ** groups[0]))
        ]
    subject["declared"] = {"gamma": "1", "m": "1/1000", "tau": "1/1000", "global_tau": "1/1000", "lipschitz": "1", "max_drift": "1/7"}
    labels = [[f"i{pick.randrange(groups[1])}" for _ in range(groups[0])] for _ in range(2 * (size(pick) // 1000))]
    entries = [
        {
            "context": pick.choice(contexts),
            "higher": higher,
            "lower": lower,
            "floors": [[0, a % 2, f"1/{a + 2}"] for a in range(pick.choice([1, 30]))],
        }
        for higher, lower in zip(labels[::2], labels[1::2], strict=True)
    ]
    laws = {(row["context"], row["group"]): row["weights"] for row in rows if "group" in row}
    width = max(a for _, a in laws) + 1
    attained = {"context": contexts[0], "higher": [label[0] for label in (f["inputs"][0] for f in of_group)]}
    attained["lower"] = [label[0] for label in (f["inputs"][-1] for f in of_group)]
    policy = {"attained": attained, "rows": [[laws[x, a] for a in range(width)] for x in range(len(laws) // width)]}
    multipliers = [_lowest(i, 100) for i in range(pick.choice([1, 300]))]
    evidence = {
        "any policy behind this filter": {"attained": attained},
        "any policy behind this filter within the declared drift of this one": {"attained": attained},
        "any policy behind this filter that keeps the declared floor": {"multipliers": multipliers, "pairs": entries, "policy": policy},
        "any policy behind this filter, any utility of the declared range": {},
        "any policy behind this filter that keeps the declared floor, any utility of the declared range": {"multipliers": multipliers},
    }
    document["claims"] = []
    for scope, given in evidence.items():
        relation, suffix = ("<=", "") if "any utility" in scope else ("=", "_supremum")
        for quantity in ("local_ratio", "global_ratio"):
            one = {"quantity": quantity + suffix, "relation": relation, "by": "T13", "scope": scope, "assumptions": [], "evidence": given}
            document["claims"].append(one | {"value": pick.choice(["2", "1000003/1000", long_rational(pick, 50)])})
    pick.shuffle(document["claims"])
    return document


def streams(pick: Pick) -> Any:
    """Many cells, values and knots, all of which a martingale has to be computed for."""
    document = json.loads(_honest("stream", pick.randrange(4)))
    decisions, groups = pick.choice([(2, 50), (300, 2), (100, 10), (2, 300)])
    table = _plain(pick, decisions, groups, 1, lambda x, a: {"weights": [str(pick.randrange(1, 10**17)) for _ in range(decisions)]})
    interval = document["intervals"]["local"]
    many = sorted({pick.randrange(1, 10**9) for _ in range(pick.choice([5, 300, 5000]))})
    knots = [_lowest(v, 10**9) for v in many]
    interval |= {"region": "product", "ratio": ["1", "3"], "upper": [knots], "lower": None, "limits": ["0", "1"]}
    interval.pop("pair", None)
    interval["levels"] = {"expected": 4, "order": list(range(1, groups + 1))}
    utility = [_lowest(pick.randrange(1000), 1000) for _ in range(decisions)]
    table["subject"]["table"]["header"]["utility"] = utility
    table["intervals"] = {"local": interval}
    return table


def ladders(pick: Pick) -> Any:
    """Many knots, each of which asks for a binomial sum of every cell."""
    groups = pick.choice([2, 30, 300])
    table = _plain(pick, 2, groups, 1, lambda x, a: {"weights": [str(pick.randrange(2400, 2500)) for _ in range(2)]})
    many = sorted({pick.randrange(4 * 10**11, 6 * 10**11) for _ in range(pick.choice([100, 3000, 30_000]))})
    knots = [_lowest(v, 10**12) for v in many]
    interval = {
        "confidence": "1/1000",
        "ends": "together",
        "region": "product",
        "independent": True,
        "method": "hoeffding-kl",
        "limits": None,
        "ratio": ["1", "100"],
        "levels": {"upper": ["1/3", "1/4"], "lower": ["0", "0"]},
        "upper": [["1/1000", *knots]],
        "lower": None,
    }
    table["intervals"] = {"local": interval}
    return table


def contrasts(pick: Pick) -> Any:
    """Many cells and values, or long ones, of which every pair asks for sums over all of its draws."""
    decisions, groups = pick.choice([(3, 60), (300, 2), (3000, 2), (100, 10), (3, 300)])
    most = pick.choice([2, 30, 10**6, 10**17])
    table = _plain(pick, decisions, groups, 1, lambda x, a: {"weights": [str(pick.randrange(1, most)) for _ in range(decisions)]})
    bottom = 10 ** pick.choice([3, 9, min(4_000, max(9, size(pick, 3) // decisions))])
    table["subject"]["table"]["header"]["utility"] = ["1", *(_lowest(pick.randrange(bottom), bottom) for _ in range(decisions - 1))]
    pairs = groups * (groups - 1)
    table["intervals"] = {
        "local": {
            "confidence": "1/1000",
            "ends": "each",
            "region": "contrasts",
            "independent": True,
            "method": "hoeffding-kl",
            "limits": None,
            "ratio": ["1", pick.choice(["11/10", "3", "1000", f"{odd(pick, size(pick, 2))}/{2**64}"])],
            "levels": {"upper": "999/1000", "lower": _lowest(999, 1000 * pairs)},
            "upper": None,
            "lower": None,
            "pair": None,
        }
    }
    return table


def boundary(pick: Pick) -> Any:
    """An end whose tail is so close to its level that logarithms cannot tell, with a long mean."""
    n = pick.choice([50, 500, 4999])
    table = _plain(pick, 2, 2, 1, lambda x, a: {"weights": ["0", str(n)] if a else [str(n), "0"]})
    d = int(odd(pick, pick.choice([5, 50, min(2000, size(pick, 2))])))
    level = f"1/{d**n}" if len(str(d)) * n < 4000 else f"1/{odd(pick, 90_000)}"
    box = [[_lowest(d - 1, d), "1"], ["0", _lowest(1, d)]]
    table["intervals"] = {
        "local": {
            "confidence": "1/2",
            "ends": "together",
            "region": "box",
            "independent": False,
            "method": "hoeffding-kl",
            "limits": None,
            "ratio": ["1", "inf"],
            "levels": {"upper": level, "lower": level},
            "upper": box,
            "lower": box,
            "pair": None,
        }
    }
    return table


def units(pick: Pick) -> Any:
    """Units whose numbers of rows have no common divisor."""
    document: Any = json.loads(_honest("units", 1))
    listed: list[Any] = [[1, [int(digits(pick, pick.choice([5, 17]))), int(digits(pick, 17)), 1]] for _ in range(size(pick, 4) // 50)]
    sums = [str(sum(row[1][u] for row in listed)) for u in range(3)]
    for row in document["subject"]["table"]["rows"]:
        row["weights"] = sums
    if "intervals" in document and "local" in document["intervals"]:
        document["intervals"]["local"]["units"] = [listed, listed]
        document["intervals"]["local"]["independent"] = False
    return document


def classes(pick: Pick) -> Any:
    """Classes of utilities on tables with many groups, with metrics, families and duals."""
    groups = pick.choice([10, 200, 5000])
    table = _plain(pick, 2, groups, 1, lambda x, a: {"weights": [str(pick.randrange(1, 99)), "7"]})
    of: dict[str, Any] = {"quantity": pick.choice(["local", "global"]), "gamma": "1", "m": "1/10", "tau": None, "tau_on": "all"}
    of |= {"blind": pick.random() < 0.5, "metric": None, "order": [], "rows": [], "family": None}
    of["lipschitz"] = None if of["blind"] else "1/5"
    if groups <= 200 and not of["blind"]:
        of["metric"] = [["0" if i == j else "1" for j in range(groups)] for i in range(groups)]
    claim = {
        "quantity": f"{of['quantity']}_ratio",
        "relation": "<=",
        "value": "9",
        "scope": "every utility of the class",
        "assumptions": [],
    }
    pairs: list[dict[str, Any]] = [
        {"higher": 0, "lower": j, "multipliers": [[number, f"1/{odd(pick, 20)}"] for number in range(pick.choice([3, 300]))]}
        for j in range(1, min(groups, 40))
    ]
    if of["quantity"] == "local":
        pairs = [{"context": 0} | pair for pair in pairs]
    ks = [_lowest(i, 100) for i in range(100, 900)]
    table["subject"]["class"] = of
    table["claims"] = [claim | {"by": "lp-dual", "evidence": {"pairs": pairs}}, claim | {"by": "T3", "evidence": {"multipliers": ks}}]
    return table


def logarithms(pick: Pick) -> Any:
    """Limits on a logarithm that are equal to it in very many digits."""
    precision = pick.choice([100, 3000, 20_000])
    document = _plain(pick, 2, 2, 1, lambda x, a: {"weights": ["3", "7"] if a else ["7", "3"]})
    with mp.workdps(precision + 20):
        text = mp.nstr(mp.log(mp.mpf(7) / 3), precision).replace("0.", "")
    n = int("".join(text[i : i + 4000] for i in range(0, 4000, 4000))) if precision <= 4000 else None
    limit = f"{text.lstrip('0')}/1{'0' * len(text)}" if n is None else _lowest(n, 10 ** len(text))
    if n is None and text[-1] in "024685":
        limit = f"{text[:-1].lstrip('0')}3/1{'0' * len(text)}"
    document["targets"] = [{"quantity": "local", "limit": limit, "unit": "log", "judged": "this table", "verdict": "within"}]
    return document


def nested(pick: Pick) -> bytes:
    n = size(pick)
    opening, closing = pick.choice([("[", "]"), ('{"a":', "}"), ('[{"a":[', "]}]")])
    depth = n // (len(opening) + len(closing))
    return (opening * depth + pick.choice(["", "1"]) + closing * depth * pick.choice([0, 1])).encode()


def long_lists(pick: Pick) -> Any:
    """Very many claims, targets, entries, versions, or one key very often."""
    document = honest(pick, *{kind.__name__ for kind in KINDS})
    key = pick.choice(["claims", "targets", "not_compared", "versions", "assumptions", "decisions"])
    n = size(pick, 5)
    if key == "versions":
        document["versions"] = {str(i): "x" for i in range(n // 16)}
    elif key == "assumptions":
        document["claims"][0]["assumptions"] = [f"{i} of {i + 1} rows have a missing label and were left out" for i in range(n // 70)]
    elif key == "decisions":
        document["subject"]["table"]["header"]["decisions"] = [str(i) for i in range(n // 10)]
    elif document[key]:
        entry = pick.choice(document[key])
        document[key] = [entry] * min(n // (len(json.dumps(entry)) + 2), 90_000)
    return document


def repeated_keys(pick: Pick) -> bytes:
    document = honest(pick, "counts")
    text = json.dumps(document)
    return text.replace('"versions": {', '"versions": {' + '"a": "b", ' * (size(pick) // 12)).encode()


FAMILIES: tuple[Callable[[Pick], Any], ...] = (
    long_numbers,
    long_numbers,
    long_numbers_in_intervals,
    coprime_weights,
    coprime_utilities,
    many_groups,
    many_labels,
    preparations,
    preparations,
    combining_marks,
    generic_filters,
    many_inputs,
    large_filter,
    long_filters,
    greatest_ratios,
    greatest_ratios,
    streams,
    ladders,
    contrasts,
    boundary,
    units,
    classes,
    logarithms,
    nested,
    long_lists,
    repeated_keys,
)


def hostile(seed: int) -> bytes:
    """The document of a seed; successive seeds are of different families."""
    for attempt in range(20):
        pick = Pick(tiers.fresh(seed * 100 + attempt))
        made = FAMILIES[seed % len(FAMILIES)](pick)
        raw = made if isinstance(made, bytes) else json.dumps(copy.copy(made), separators=(",", ":")).encode()
        if len(raw) < 1_000_000:
            return raw
    raise AssertionError(FAMILIES[seed % len(FAMILIES)].__name__)
