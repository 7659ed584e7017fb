"""Certificates about groups that nobody recorded, of all kinds, and alterations of them."""

from __future__ import annotations

import copy
import json
import random
from collections.abc import Iterator
from fractions import Fraction
from typing import Any

from proxy_oracle import random_rows

from fairaudit.audits.proxies import ProxyAudit, audit_proxies
from fairaudit.audits.reading import Reading
from fairaudit.model.utility import Utility


def proxied(
    rng: random.Random, groups: int, *, intervals: bool = False, contexts: int = 1, limit: str = "5/4", **options: Any
) -> ProxyAudit:
    """An audit of random cells; of several contexts all together."""
    log: dict[str, list[object]] = {name: [] for name in ("place", "out", "n", *(["job"] if contexts > 1 else []))}
    given: dict[str, list[str]] = {name: [] for name in ("place", "race", *(("low", "high") if intervals else ("probability",)))}
    rows = random_rows(rng, groups, intervals=intervals)
    for place, (_, low, high) in enumerate(rows):
        for a, (least, most) in enumerate(zip(low, high, strict=True)):
            given["place"].append(f"p{place}")
            given["race"].append(f"g{a}")
            for name, value in (("low", least), ("high", most), ("probability", least)):
                if name in given:
                    given[name].append(str(value))
    for job in range(contexts):
        for place, (gains, _, _) in enumerate(rows):
            for i, (_, count) in enumerate(gains):
                log["place"].append(f"p{place}")
                log["out"].append(f"o{i}")
                log["n"].append(count if contexts == 1 else count + rng.randint(0, 2))
                if contexts > 1:
                    log["job"].append(f"j{job}")
    utility = Utility({f"o{i}": gain for i, (gain, _) in enumerate(rows[0][0])})
    reading = Reading("out", ("race",), ("job",) if contexts > 1 else (), count="n")
    return audit_proxies(log, reading, utility, given, limits={"max_local_ratio": limit, "max_global_ratio": "3"}, **options)


def every_kind() -> Iterator[ProxyAudit]:
    """Two to four groups, known shares and intervals, one context and several."""
    for seed, (groups, intervals, contexts) in enumerate(
        [(2, False, 1), (3, False, 2), (4, False, 1), (2, True, 2), (3, True, 1), (4, True, 1)]
    ):
        yield proxied(random.Random(seed), groups, intervals=intervals, contexts=contexts)


def leaves(value: Any, path: tuple[Any, ...] = ()) -> Iterator[tuple[tuple[Any, ...], Any]]:
    """Every value in a document that holds no other, and every list."""
    if isinstance(value, dict):
        for key, item in value.items():
            yield from leaves(item, (*path, key))
        return
    if isinstance(value, list):
        yield path, value
        for i, item in enumerate(value):
            yield from leaves(item, (*path, i))
        return
    yield path, value


def others(value: Any) -> list[Any]:
    """What could stand in the place of a value."""
    if isinstance(value, bool):
        return [not value]
    if isinstance(value, int):
        return [value + 1, value - 1]
    if isinstance(value, list):
        return [value[:-1], [*value, value[-1]], value[::-1]] if value else [["x"]]
    if value is None:
        return ["1"]
    try:
        number = Fraction(value)
    except ValueError:
        return [f"{value}x", "1" if value == "inf" else "inf"]
    return [str(number + 1), str(number * Fraction(999, 1000)), str(number * Fraction(1001, 1000)), "0", "1", "inf", str(-number)]


def alterations(document: dict[str, Any]) -> Iterator[tuple[tuple[Any, ...], dict[str, Any]]]:
    """A document with one value changed, for each value."""
    for path, value in leaves(document):
        if path == ("targets",):  # what was not asked for, or in another order, is no less true
            continue
        for other in others(value):
            if json.dumps(other) == json.dumps(value):
                continue
            changed = copy.deepcopy(document)
            at = changed
            for key in path[:-1]:
                at = at[key]
            at[path[-1]] = other
            yield path, changed


def stated(document: dict[str, Any]) -> Any:
    """What a document states of figures and verdicts; the evidence for them, names of groups and limits are left out."""
    ranges = [*document["local"], *([document["global"]] if document["global"] else [])]
    names = ("means", "pairs")
    return [
        [[found[name] for name in names] for found in ranges],
        [[found[name]["ratio"] for name in ("least", "greatest", "low", "high")] for found in ranges],
        [[found[name]["sharp"] for name in ("least", "greatest")] for found in ranges],
        [found.get("context") for found in ranges],
        [target["verdict"] for target in document["targets"]],
        document["verdict"],
        document["subject"]["table"],
        sorted(document["assumptions"]),
    ]
