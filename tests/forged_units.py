"""Forged certificates of intervals that rest on what units got in several groups."""

from __future__ import annotations

import json
import random
from collections.abc import Iterator
from fractions import Fraction
from typing import Any

from forged_samples import DRAWS, MADE, TINY, Change, Forged, claims_of, document, in_words, renamed, told_wrongly, written
from paired_certificates import certified, law_of, logs, named, repaired, table

import fairaudit as fa

F = Fraction


def units(**options: Any) -> Any:
    """Units that were seen in all groups of a context, with several rows in some."""
    return json.loads(certified(logs(random.Random(1), units=20, lost=0.0), **options).certificate.text)


def unfair_units() -> Any:
    """Units with one row in each group, some of which were not seen everywhere."""
    rows = logs(random.Random(5), groups="fm", units=40, often=1, lost=0.03)
    rows = [("yes" if a == "f" else "no" if i in "0123456789" else u, a, x, i) for u, a, x, i in rows]
    return json.loads(certified(rows, max_local_ratio="11/10", missing_units="drop").certificate.text)


MADE["units"] = units
MADE["unfair"] = unfair_units


def paired() -> Iterator[Forged]:
    """Units that are not those of the table, not those that the header names, or of whom less is known than is said."""
    for kind in ("units", "unfair"):
        true = document(kind)
        own = true["intervals"]["local"]
        at = "intervals.local"
        pick = random.Random(3)

        def both(what: str, profiles: Any, *changes: Change, true: Any = true, kind: str = kind) -> Iterator[Forged]:
            made = json.loads(written(true, ("intervals.local.profiles", profiles), *changes))
            yield f"{kind}: {what}, the digest that was there", json.dumps(made).encode()
            named(made)
            yield f"{kind}: {what}, its own digest", json.dumps(made).encode()

        blocks = own["profiles"]
        (n, values), *rest = blocks[0]
        for what, profiles in (
            ("one unit more", [[[n + 1, values], *rest], *blocks[1:]]),
            ("a unit less", [rest, *blocks[1:]]),
            ("the groups exchanged", [[[m, got[::-1]] for m, got in block] for block in blocks]),
            ("the contexts exchanged", blocks[::-1]),
            ("a context left out", blocks[:-1]),
            ("a context twice", [*blocks, blocks[0]]),
            ("nobody", [[] for _ in blocks]),
            ("no contexts", []),
            ("a value above the range", [[[n, ["2", *values[1:]]], *rest], *blocks[1:]]),
            ("a value that is none", [[[n, ["1/0", *values[1:]]], *rest], *blocks[1:]]),
            ("a value below 0", [[[n, ["-1", *values[1:]]], *rest], *blocks[1:]]),
            ("a value not seen", [[[n, [None, *values[1:]]], *rest], *blocks[1:]]),
            ("nobody seen anywhere", [[*blocks[0], [5, [None] * len(values)]], *blocks[1:]]),
            ("a unit that is none", [[*blocks[0], [0, ["0"] * len(values)]], *blocks[1:]]),
            ("units below 0", [[*blocks[0], [-1, ["0"] * len(values)]], *blocks[1:]]),
            ("the same twice", [[*blocks[0], blocks[0][0]], *blocks[1:]]),
            ("one group less", [[[m, got[:-1]] for m, got in block] for block in blocks]),
        ):
            yield from both(what, profiles)
        for _ in range(3):
            made = json.loads(written(true, (f"{at}.profiles", repaired(pick, blocks))))
            if made["intervals"]["local"]["profiles"] != blocks:
                yield f"{kind}: other units have the values", json.dumps(made).encode()
        names = "subject.table.header.profiles"
        sha = true["subject"]["table"]["header"]["profiles"]["local"]
        for value in (..., {}, None, {"local": "0" * 64}, {"local": sha.upper()}, {"global": sha}, {"local": None}, sha):
            for digest in (False, True):
                yield f"{kind}: the header names {str(value)[:30]}, {digest}", written(true, (names, value), digest=digest)
        low, high = own["ratio"]
        for i, end in ((1, (F(high) + 1) / 2), (1, F(high) * F(999, 1000)), (0, F(low) * F(1001, 1000))):
            moved: list[Change] = [(f"{at}.ratio.{i}", str(end))]
            moved += [(f"claims.{m}.value", str(end)) for m, c in claims_of(true, "local") if (c["relation"] == "<=") == bool(i)]
            yield f"{kind}: end {i} narrower", written(true, *moved)
        for key, value in (
            ("missing", "worst" if own["missing"] == "drop" else "Drop"),
            ("missing", "ignore"),
            ("independent", True),
            ("ends", "together" if own["ends"] == "each" else "each"),
            ("pair", [0, 0, 1]),
            ("upper", None),
            ("estimand", "mean over rows"),
            ("estimand", None),
            ("units", []),
            ("units", None),
        ):
            if own.get(key, ()) != value:
                yield f"{kind}: {key} {value}", written(true, (f"{at}.{key}", value))
        yield f"{kind}: the same of means", written(true, ("intervals.global", own))
        for m, claim in claims_of(true, "local"):
            yield f"{kind}: claim {m} by binomial", written(true, (f"claims.{m}.by", "binomial"))
            draws = [DRAWS]
            yield f"{kind}: claim {m} of independent draws", written(true, (f"claims.{m}.assumptions", draws + claim["assumptions"][1:]))
        yield from told_wrongly(true, "local")
    true = document("units")
    rows = true["intervals"]["local"]["units"]
    at = "intervals.local"
    for what, value in (
        ("a group left out", rows[1:]),
        ("groups exchanged", [rows[1], rows[0], *rows[2:]]),
        ("one unit more", [[[rows[0][0][0] + 1, rows[0][0][1]], *rows[0][1:]], *rows[1:]]),
        ("rows below 0", [[*rows[0], [1, [0, -1, 1]], [1, [0, 1, -1]]], *rows[1:]]),
        ("no rows", [[*rows[0], [1, [0, 0, 0]]], *rows[1:]]),
        ("rows of a decision left out", [[[m, row[:-1]] for m, row in rows[0]], *rows[1:]]),
        ("rows pooled into one unit", [[[1, [sum(m * row[u] for m, row in rows[0]) for u in range(3)]]], *rows[1:]]),
    ):
        yield f"units: {what}", written(true, (f"{at}.units", value))
    measured = true["intervals"]["local"]["measured"]
    higher, lower = measured["witness"]["higher"], measured["witness"]["lower"]
    for path, value in (
        ("ratio", "1"),
        ("ratio", str(F(measured["ratio"]) + TINY)),
        ("ratio", "inf"),
        ("log", ["0", "0"]),
        ("log", ["0.000000000000", "1.000000000000"]),
        ("witness.context", {"x": "t"}),
        ("witness.context", {"y": "s"}),
        ("witness.higher", lower),
        ("witness.lower", higher),
        ("witness.higher", {"group": higher["a"]}),
        ("witness.expectations", ["1", "1"]),
        ("witness.expectations", measured["witness"]["expectations"][::-1]),
        ("witness.expectations", ["7/10", "23/040"]),
        ("salt", "1"),
    ):
        yield f"measured {path} {value}", written(true, (f"{at}.measured.{path}", value))
    for value in (None, ..., true["metrics"]["local"], {}):
        yield f"measured is {str(value)[:20]}", written(true, (f"{at}.measured", value))
    drop = document("unfair")
    judged = drop["targets"][0]
    for verdict in {"within", "exceeds", "inconclusive"} - {judged["verdict"]}:
        yield f"a verdict {verdict}", written(drop, ("targets.0.verdict", verdict), ("verdict", verdict))
    for key, value in (("estimand", "mean over units"), ("judged", "population at confidence 99/100")):
        yield f"judged by units, {key} {value}", written(drop, (f"targets.0.{key}", value))
    for low, high in (("0", "1/2"), ("1/4", "1"), ("1", "0"), ("0", "1/0"), ("-1", "1")):
        words = in_words(true, ("a utility between 0 and 1", f"a utility between {low} and {high}"))
        yield f"a range from {low} to {high}", written(words, ("intervals.local.limits", [low, high]))
    for often, alone in ((2, False), (2, True), (1, True)):
        drawn = logs(random.Random(1), units=20, often=often, lost=0.0)
        seen = [("yes" if u == "maybe" else u, a, x, i) for u, a, x, i in drawn]
        beside = json.loads(fa.certify(law_of(seen), {"yes": 1}).certificate.text)
        columns = {name: values for name, values in table(seen).items() if name != "unit"}
        law = fa.Law.from_log(columns, decision="u", group="a", context="x")
        of_rows = fa.certify(law, {"yes": 1}, confidence="19/20", independent=alone).certificate.document
        claims = [c for c in beside["claims"] if c["evidence"].get("interval") != "global"] + [c for _, c in claims_of(of_rows, "global")]
        name = f"rows as draws beside units with {often}, independent cells: {alone}"
        yield name, written(beside, ("intervals.global", of_rows["intervals"]["global"]), ("claims", claims))
    yield from renamed("units", [("profiles", '{"local": "0"}'), ("missing", '"drop"'), ("measured", "null"), ("estimand", '"mean"')])
