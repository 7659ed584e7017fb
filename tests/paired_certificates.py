"""Certificates with intervals of groups that were seen in the same units, and alterations of them."""

from __future__ import annotations

import copy
import json
import random
from collections import Counter
from collections.abc import Iterator
from fractions import Fraction
from hashlib import sha256
from typing import Any

import fairaudit as fa

F = Fraction
WORTH: dict[str, Any] = {"yes": 1, "maybe": "1/2"}

Row = tuple[str, str, str, str]  # decision, group, context, unit


def table(rows: list[Row]) -> dict[str, list[str]]:
    return dict(zip(["u", "a", "x", "unit"], map(list, zip(*rows, strict=True)), strict=True))


def law_of(rows: list[Row]) -> fa.Law:
    return fa.Law.from_log(table(rows), decision="u", group="a", context="x", unit="unit")


def certified(rows: list[Row], **options: Any) -> fa.Result:
    return fa.certify(law_of(rows), WORTH, **options)


def logs(
    source: random.Random, groups: str = "fmn", contexts: str = "st", units: int = 12, often: int = 2, lost: float = 0.03
) -> list[Row]:
    rows = []
    for x in contexts:
        for i in range(units):
            mood = source.random()
            for a in groups:
                if source.random() >= lost:
                    answers = ["yes" if source.random() < mood else source.choice(["no", "maybe"]) for _ in range(source.randint(1, often))]
                    rows += [(u, a, x, str(i)) for u in answers]
    return rows


def honest(source: random.Random) -> dict[str, Any]:
    while True:
        rows = logs(source, groups="fmn"[: source.randint(2, 3)], units=source.randint(8, 16), often=source.randint(1, 2))
        rows = [("yes" if a == "f" and source.random() < 0.8 else u, a, x, i) for u, a, x, i in rows]
        options: dict[str, Any] = source.choice([{}, {"max_local_ratio": "5/4"}, {"missing_units": "drop"}])
        document: dict[str, Any] = json.loads(certified(rows, confidence=source.choice(["0.5", "0.8"]), **options).certificate.text)
        if document["intervals"]["local"]["region"] == "paired":
            return document


def repaired(source: random.Random, profiles: list[Any]) -> list[Any]:
    """The same values in every group, but of other units."""
    block = source.randrange(len(profiles))
    spread = [list(values) for n, values in profiles[block] for _ in range(n)]
    group = source.randrange(len(spread[0]))
    column = [values[group] for values in spread]
    source.shuffle(column)
    for values, value in zip(spread, column, strict=True):
        values[group] = value
    counted = Counter(tuple(values) for values in spread)
    return [own if b != block else [[n, list(values)] for values, n in counted.items()] for b, own in enumerate(profiles)]


def line(value: object) -> bytes:
    return json.dumps(value, sort_keys=True, separators=(",", ":")).encode() + b"\n"


def named(document: dict[str, Any]) -> None:
    """Write the digest of the profiles into the header, and that of the table wherever it stands, as a forger would."""
    table, local = document["subject"]["table"], document["intervals"]["local"]
    table["header"]["profiles"]["local"] = sha256(line(local["profiles"])).hexdigest()
    old, table["sha256"] = table["sha256"], sha256(b"".join(map(line, [table["header"], *table["rows"]]))).hexdigest()
    for claim in document["claims"]:
        if claim["evidence"].get("table") == old:
            claim["evidence"]["table"] = table["sha256"]


def alterations(document: dict[str, Any], source: random.Random) -> Iterator[tuple[str, dict[str, Any]]]:
    """Each with what was altered."""

    def other() -> tuple[dict[str, Any], dict[str, Any]]:
        made = copy.deepcopy(document)
        return made, made["intervals"]["local"]

    for _ in range(6):
        made, local = other()
        local["profiles"] = repaired(source, local["profiles"])
        if sorted(map(str, local["profiles"])) != sorted(map(str, document["intervals"]["local"]["profiles"])):
            yield "other pairs of values, with the same margins", made
    for _ in range(6):
        made, local = other()
        block = source.choice(local["profiles"])
        entry = source.choice(block)
        kind = source.choice(["more units", "another value", "missing", "gone"])
        if kind == "more units":
            entry[0] += 1
        elif kind == "gone":
            block.remove(entry)
        else:
            g = source.randrange(len(entry[1]))
            before = entry[1][g]
            entry[1][g] = None if kind == "missing" else source.choice([v for v in ("0", "1/2", "1", "1/3") if v != before])
            if entry[1][g] == before:
                continue
        if source.random() < 0.5:
            named(made)
        yield kind, made
    low, high = document["intervals"]["local"]["ratio"]
    for factor in ("1000001/1000000", "101/100", "3/2"):
        made, local = other()
        local["ratio"][0] = str(F(low) * F(factor))
        for claim in made["claims"]:
            if claim["by"] == "paired-betting" and claim["relation"] == ">=":
                claim["value"] = local["ratio"][0]
        yield "a greater lower end", made
        if high != "inf" and F(high) / F(factor) > 1:
            made, local = other()
            local["ratio"][1] = str(F(high) / F(factor))
            for claim in made["claims"]:
                if claim["by"] == "paired-betting" and claim["relation"] == "<=":
                    claim["value"] = local["ratio"][1]
            yield "a smaller upper end", made
    for key, value in (
        ("confidence", "99/100"),
        ("levels", {"upper": "1/2", "lower": "1/2000"}),
        ("levels", {"upper": "999/1000", "lower": "999/1000"}),
        ("independent", True),
        ("ends", "together" if document["intervals"]["local"]["ends"] == "each" else "each"),
        ("missing", "worst" if document["intervals"]["local"]["missing"] == "drop" else "drop"),
        ("region", "pairs"),
        ("profiles", []),
    ):
        made, local = other()
        local[key] = value
        yield key, made
    made, _ = other()
    del made["subject"]["table"]["header"]["profiles"]
    yield "no digest of the profiles", made
