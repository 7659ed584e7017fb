"""Forged certificates of what is said of a population: limits, and intervals by ends and by ladders."""

from __future__ import annotations

import copy
import json
import math
import random
from collections.abc import Callable, Iterator, Sequence
from fractions import Fraction
from functools import cache
from typing import Any

from certificate_changes import redigested
from certificate_kinds import admissions, true_labels
from plain_certificates import edited

import fairaudit as fa

Forged = tuple[str, bytes]
Change = tuple[str, Any]
"""A place, and what somebody wrote there."""

F = Fraction
DRAWS = (
    "the draws within a cell are independent, each with the law of the cell, and how many there are does not depend on how they came out"
)
TINY = F(1, 10**30)
NOT_NUMBERS = ("1/0", "-0", "01", "+1", "0.5", "1e3", "2/4", "-1/2", "１", "", " 1", "nan", "inf", None, 1, ["1"])


def of_counts(counts: Any, **options: Any) -> fa.Result:
    return fa.certify(fa.Law.from_array(counts, kind="counts"), {"0": 1}, **options)


def many_cells() -> fa.Result:
    """An interval that lists few of its cells: the ends of the others are in closed form."""
    drawn = random.Random(7)
    return of_counts([[[drawn.randrange(40), drawn.randrange(1, 40)] for _ in range(3)] for _ in range(60)], confidence="19/20")


DRIFTING = [[[30, 70], [55, 45], [20, 60]], [[20, 10], [5, 15], [9, 9]]]

MADE: dict[str, Callable[[], Any]] = {
    "judged": lambda: admissions(max_local_ratio="10", max_global_ratio="11/10", confidence="19/20").certificate.document,
    "ladders": lambda: of_counts([[[30, 70], [55, 45]]], confidence="19/20", independent=True).certificate.document,
    "three": lambda: of_counts([[[9, 31], [22, 18], [40, 3]]], confidence="19/20", independent=True).certificate.document,
    "cells": lambda: many_cells().certificate.document,
    "draws": lambda: of_counts([[[312_000, 40_000], [100_000, 90_000]]], confidence="19/20").certificate.document,
    "truth": lambda: json.loads(true_labels().certificate.text),
    "drift": lambda: of_counts(DRIFTING, max_local_ratio="8", max_global_log="1/2", max_drift="1/20", confidence=None).certificate.document,
    "exceeding": lambda: of_counts(DRIFTING, max_local_log="1/10", max_global_ratio="11/10", confidence=None).certificate.document,
}


@cache
def _text(kind: str) -> str:
    return json.dumps(MADE[kind]())


def document(kind: str) -> Any:
    """A true certificate, to be changed."""
    return json.loads(_text(kind))


def written(true: Any, *changes: Change, digest: bool = False) -> bytes:
    """The certificate with some places changed, and its digests brought in line or not."""
    made = copy.deepcopy(true)
    for path, value in changes:
        edited(made, path, value)
    return redigested(made) if digest else json.dumps(made).encode()


def in_words(true: Any, *words: tuple[str, str]) -> Any:
    """The certificate with words exchanged wherever they stand."""
    text = json.dumps(true)
    for old, new in words:
        assert old in text
        text = text.replace(old, new)
    return json.loads(text)


def renamed(kind: str, keys: Sequence[tuple[str, str]]) -> Iterator[Forged]:
    """Keys twice, and keys that only look like those of the format."""
    text = _text(kind)
    for key, value in keys:
        assert f'"{key}": ' in text
        for other in (
            f'"{key}": {value}, "{key}": ',
            f'"{key} ": ',
            f'"{key.upper()}": ',
            f'"{key}": {value}, "\\u{ord(key[0]):04x}{key[1:]}": ',
        ):
            yield f"{kind}: {other}", text.replace(f'"{key}": ', other, 1).encode()


# Verdicts on the population


def _limits(*given: tuple[str, str, str, str], at: str = "19/20") -> list[dict[str, str]]:
    judged = f"population at confidence {at}"
    return [{"quantity": q, "limit": limit, "unit": unit, "judged": judged, "verdict": verdict} for q, unit, limit, verdict in given]


LOCAL, GLOBAL = ("local", "ratio", "10", "within"), ("global", "ratio", "11/10", "exceeds")


def verdicts() -> Iterator[Forged]:
    """Limits that are kept by the table alone, by the interval of something else, at another confidence, or too many at once."""
    true = document("judged")
    ends = {name: [F(end) for end in interval["ratio"]] for name, interval in true["intervals"].items()}
    sets: list[tuple[str, list[dict[str, str]], str]] = [
        ("within, as the table is", _limits(("local", "ratio", "3/2", "within"), GLOBAL), "exceeds"),
        ("exceeds, as the table does", _limits(("local", "ratio", "5/4", "exceeds"), GLOBAL), "exceeds"),
        ("within, as the table is, of means", _limits(LOCAL, ("global", "ratio", "3/2", "within")), "within"),
        (
            "by the interval of the other quantity",
            _limits(("local", "ratio", "11/10", "exceeds"), ("global", "ratio", "10", "within")),
            "exceeds",
        ),
        ("inconclusive where it exceeds", _limits(LOCAL, ("global", "ratio", "11/10", "inconclusive")), "inconclusive"),
        ("inconclusive where it keeps", _limits(("local", "ratio", "10", "inconclusive"), GLOBAL), "exceeds"),
        ("depends", _limits(LOCAL, ("global", "ratio", "11/10", "depends")), "depends"),
        ("changed", _limits(LOCAL, ("global", "ratio", "11/10", "changed")), "changed"),
        ("three at once", _limits(LOCAL, GLOBAL, ("local", "log", "3", "within")), "exceeds"),
        ("four at once", _limits(LOCAL, GLOBAL, ("local", "log", "3", "within"), ("global", "log", "1/20", "exceeds")), "exceeds"),
        ("three, two of them the same", [*_limits(LOCAL, GLOBAL), *_limits(LOCAL)], "exceeds"),
        ("two of one quantity that say otherwise", _limits(LOCAL, ("local", "ratio", "2", "inconclusive")), "inconclusive"),
        ("each at its own confidence", [*_limits(LOCAL), *_limits(GLOBAL, at="9/10")], "exceeds"),
        ("each at the confidence of its interval", _limits(LOCAL, GLOBAL, at="39/40"), "exceeds"),
        ("a confidence above that of the interval", _limits(LOCAL, at="79/80"), "within"),
        ("one of the table as well", [*_limits(LOCAL), _limits(GLOBAL)[0] | {"judged": "this table", "verdict": "within"}], "within"),
        ("no verdict at all", _limits(LOCAL, GLOBAL), "none"),
        ("the verdict on one of two", _limits(LOCAL, GLOBAL), "within"),
        ("a verdict without a target", [], "within"),
        ("a difference", _limits(("local", "difference", "1", "within")), "within"),
        ("a difference that is open", _limits(("global", "difference", "1/100", "inconclusive")), "inconclusive"),
    ]
    for name, targets, verdict in sets:
        yield name, written(true, ("targets", targets), ("verdict", verdict))
    for quantity, i, verdict in (("local", 1, "within"), ("global", 1, "within"), ("local", 0, "exceeds"), ("global", 0, "exceeds")):
        beyond = ends[quantity][i] * (1 + (1 - 2 * i) * F(1, 10**9))
        nats = F(round(math.log(beyond) * 10**12) + (1 - 2 * i), 10**12)
        for unit, limit in (("ratio", beyond), ("log", nats)):
            targets = _limits((quantity, unit, str(limit), verdict))
            yield f"{quantity} {verdict} by a billionth, {unit}", written(true, ("targets", targets), ("verdict", verdict))
    for judged in (
        *(f"population at confidence {c}" for c in ("1", "0", "-1/2", "38/40", "0.95", "1/0", "01/2", "19/20 ", "", "9" * 30, "２/3")),
        *(
            f"population at confidence 19/20, {under}"
            for under in ("whoever the unknown are", "within the declared drift", "if we are lucky")
        ),
        *("population", "population, one-sided at confidence 19/20", "Population at confidence 19/20", "this table ", "this population"),
    ):
        yield f"judged {judged[:40]!r}", written(true, ("targets.0.judged", judged), ("targets.1.judged", judged))
    for key, value in (("estimand", "mean over units"), ("estimand", None), ("tips", {}), ("confidence", "19/20"), ("interval", "local")):
        yield f"a target with {key} {value}", written(true, (f"targets.0.{key}", value))
    for limit in (*NOT_NUMBERS, "1/2", "0"):
        yield f"a limit of {limit!r}", written(true, ("targets.0.limit", limit))
    for gamma in ("1/2", "2", "10/10"):
        words = in_words(true, ("a utility between 0 and 1", f"a utility between 0 and {gamma}"))
        yield f"utilities up to {gamma}", written(words)
        yield f"utilities up to {gamma}, as is said of the table", written(words, ("subject.utility.gamma", gamma))
    for scope, other in (
        ("39/40", "79/80"),
        ("39/40", "99/100"),
        ("population, one-sided at confidence 39/40", "population at confidence 39/40"),
    ):
        yield f"{other} for {scope}", written(in_words(true, (scope, other)))
    together = in_words(true, ("population, one-sided at", "population at"), ('"ends": "each"', '"ends": "together"'))
    yield "ends that each hold by themselves, as if together", written(together)
    for name in ("local", "global"):
        rest = [claim for claim in true["claims"] if claim["evidence"].get("interval") != name and "one-sided" not in claim["scope"]]
        own = [claim for claim in true["claims"] if claim not in rest and name not in claim["quantity"]]
        yield f"no interval of {name}, its verdict kept", written(true, (f"intervals.{name}", ...), ("claims", rest + own))
        yield f"no interval of {name}, its claims kept", written(true, (f"intervals.{name}", ...))
        for i, end in ((0, ends[name][0] * F(101, 100)), (1, max(F(1), ends[name][1] * F(99, 100)))):
            relation = ">=" if i == 0 else "<="
            at = next(
                n
                for n, c in enumerate(true["claims"])
                if (c["quantity"], c["relation"], c["by"]) == (f"{name}_ratio", relation, "binomial")
            )
            yield f"end {i} of {name} narrower", written(true, (f"intervals.{name}.ratio.{i}", str(end)), (f"claims.{at}.value", str(end)))
        swapped = "global" if name == "local" else "local"
        yield f"the interval of {name} for both", written(true, (f"intervals.{swapped}", true["intervals"][name]))
        crossing = ["11", "9"] if name == "local" else ["2", "1"]
        yield f"ends of {name} that cross", written(true, (f"intervals.{name}.ratio", crossing))
    for i, claim in enumerate(true["claims"]):
        if claim["by"] == "T14" and claim["scope"] == "this law":
            sampled = next(c for c in true["claims"] if c["evidence"].get("interval", "none") in claim["quantity"])
            for assumed in (claim["assumptions"], sampled["assumptions"]):
                changes_ = [(f"claims.{i}.scope", sampled["scope"]), (f"claims.{i}.assumptions", assumed)]
                yield f"claim {i} about the population, assuming {len(assumed)}", written(true, *changes_)
    probabilities = fa.certify(fa.Law.from_array([[["1/2", "1/2"], ["1/4", "3/4"]]]), {"0": 1}).certificate.document
    for verdict in ("inconclusive", "exceeds"):
        for kind in ("probabilities", "counts"):
            changes: list[Change] = [("targets", _limits(("local", "ratio", "5/4", verdict))), ("verdict", verdict), ("subject.kind", kind)]
            yield f"probabilities as a sample, {verdict}, {kind}", written(probabilities, *changes)
    for one, other in (("1", "1.0"), ("\u00e9", "e\u0301")):
        law = fa.Law.from_array([[[30, 70], [55, 45]]] * 2, kind="counts", contexts=[one, other])
        alike = json.loads(fa.certify(law, {"0": 1}, max_local_ratio="10").certificate.text)
        yield f"{one} and {other!r}, which are not told apart", written(alike, ("subject.spellings", ...))
    drift = document("drift")
    for verdict in ("exceeds", "within"):
        judged_ = _limits(("local", "ratio", "8", verdict))
        yield f"a drift that the verdict {verdict} forgets", written(drift, ("targets", judged_), ("verdict", verdict))
    yield from renamed(
        "judged", [("judged", '"this table"'), ("limit", '"1000"'), ("ends", '"each"'), ("confidence", '"39/40"'), ("targets", "[]")]
    )


# Intervals


def claims_of(true: Any, name: str) -> list[tuple[int, Any]]:
    return [(i, claim) for i, claim in enumerate(true["claims"]) if claim["evidence"].get("interval") == name]


def told_wrongly(true: Any, name: str) -> Iterator[Forged]:
    """An interval with another confidence, independence or ends, and claims that follow it; claims that say or assume otherwise."""
    interval = true["intervals"][name]
    c = interval["confidence"]
    for other in ("99/100", "199/200", "1", "0", "19/20 ", "1/0", "0.95", None):
        words = in_words(true, (f"confidence {c}", f"confidence {other}"))
        yield f"{name}: confidence {other} throughout", written(words, (f"intervals.{name}.confidence", other))
        yield f"{name}: confidence {other}", written(true, (f"intervals.{name}.confidence", other))
    for level in ("0", "1", "1/2", "1/1000", "-1/40", "1/0", "040/1600", None):
        for side in ("upper", "lower"):
            yield f"{name}: {side} level {level}", written(true, (f"intervals.{name}.levels.{side}", level))
    for key, values in {
        "region": ("pairs", "box", "paired", "product", "contrasts", "Pairs"),
        "method": ("binomial", "hoeffding", ""),
        "limits": (["0", "1/2"], ["1", "0"], [], ["0", "01"]),
        "ratio": (["1", "1"], ["inf", "inf"], ["2", "1"], ["1/2", "3"], ["1"], ["1", "1/0"], ["-0", "3"], None),
    }.items():
        for value in values:
            if interval[key] != value:
                yield f"{name}: {key} {value}", written(true, (f"intervals.{name}.{key}", value))
    yield f"{name}: more is stated", written(true, (f"intervals.{name}.salt", "1"))
    yield f"{name}: another quantity", written(true, (f"intervals.{name} ", interval))
    for i, claim in claims_of(true, name):
        less = "1000000" if claim["value"] == "inf" else str(F(claim["value"]) * F(999 if claim["relation"] == "<=" else 1001, 1000))
        at = f"claims.{i}"
        for key, value in (
            ("value", less),
            ("value", "1/2"),
            ("relation", "="),
            ("by", "enumeration"),
            ("by", "hoeffding-kl"),
            ("scope", "this law"),
            ("scope", "population"),
            ("scope", f"{claim['scope']}0"),
            ("scope", f"{claim['scope']}, within the declared drift"),
            ("quantity", "global_ratio" if name == "local" else "local_ratio"),
            ("quantity", "local_difference"),
            ("evidence", {"interval": "global" if name == "local" else "local"}),
            ("evidence", {}),
        ):
            yield f"{name}: claim {i} {key} {str(value)[:60]}", written(true, (f"{at}.{key}", value))
        for n in range(len(claim["assumptions"])):
            fewer = claim["assumptions"][:n] + claim["assumptions"][n + 1 :]
            yield f"{name}: claim {i} without assumption {n}", written(true, (f"{at}.assumptions", fewer))
        yield f"{name}: claim {i} twice", written(true, ("claims", [*true["claims"], claim]))


def ladders() -> Iterator[Forged]:
    """Ladders that leave a step or a pair out, climb too far, or stand for other cells."""
    for kind in ("ladders", "three"):
        true = document(kind)
        for name in ("local", "global"):
            interval = true["intervals"][name]
            at = f"intervals.{name}"
            up, low = interval["upper"], interval["lower"]
            for i, knots in enumerate(up or []):
                middle = len(knots) // 2
                for what, other in (
                    ("half", knots[::2]),
                    ("without the first", knots[1:]),
                    ("without the last", knots[:-1]),
                    ("without the middle", knots[:middle] + knots[middle + 1 :]),
                    ("backwards", knots[::-1]),
                    ("one step", ["0", "1"]),
                    ("nothing", []),
                    ("twice", knots * 2),
                    ("beyond 1", [*knots, "2"]),
                    ("not a number", [*knots[:-1], "1/0"]),
                ):
                    if other != knots:
                        yield f"{kind} {name}: ladder {i}, {what}", written(true, (f"{at}.upper.{i}", other))
                yield f"{kind} {name}: no ladder {i}", written(true, (f"{at}.upper", up[:i] + up[i + 1 :]))
                if i == 0:
                    yield f"{kind} {name}: ladder {i} for all", written(true, (f"{at}.upper", [knots] * len(up)))
            for other in (None, [], (up or [])[::-1], [*(up or []), *(up or [])], {}):
                if other != up and not (other == [] and not up):
                    yield f"{kind} {name}: upper {str(other)[:20]}", written(true, (f"{at}.upper", other))
            if low:
                block, i, j = low["pair"]
                for pair in ([block, j, i], [block, i, i], [block, 8, 9], [1, i, j], [-1, i, j], [i, j], None):
                    yield f"{kind} {name}: lower of {pair}", written(true, (f"{at}.lower.pair", pair))
                knots = low["knots"]
                for other in (knots[::2], knots[1:], knots[:-1], knots[::-1], ["0", "1"], []):
                    yield f"{kind} {name}: lower by {len(other)} knots", written(true, (f"{at}.lower.knots", other))
                yield f"{kind} {name}: no lower ladder", written(true, (f"{at}.lower", None))
            ends = [F(end) for end in interval["ratio"]]
            for i, end in ((1, (ends[0] + ends[1]) / 2), (1, ends[1] * F(99, 100)), (0, ends[0] * F(101, 100))):
                moved: list[Change] = [(f"{at}.ratio.{i}", str(end))]
                moved += [(f"claims.{n}.value", str(end)) for n, c in claims_of(true, name) if (c["relation"] == "<=") == bool(i)]
                yield f"{kind} {name}: end {i} at {end}", written(true, *moved)
            dependent = written(true, (f"{at}.independent", False))
            yield f"{kind} {name}: of cells that are not independent", dependent
            sentence = "the draws of different cells are independent of each other"
            unsaid: list[Change] = [
                (f"claims.{n}.assumptions", [a for a in c["assumptions"] if a != sentence]) for n, c in claims_of(true, name)
            ]
            yield f"{kind} {name}: and claims that do not say so", written(json.loads(dependent), *unsaid)
            if kind == "ladders":
                yield from told_wrongly(true, name)
    other = document("three")["intervals"]["local"]
    for key in ("upper", "lower"):
        yield f"{key} of another table", written(document("ladders"), (f"intervals.local.{key}", other[key]))
    yield "an interval of another table", written(document("ladders"), ("intervals.local", other))
    yield from renamed(
        "ladders",
        [
            ("knots", "[]"),
            ("upper", "null"),
            ("levels", '{"upper": "1/80", "lower": "1/80"}'),
            ("independent", "true"),
            ("pair", "[0, 0, 1]"),
        ],
    )


def ends() -> Iterator[Forged]:
    """Ends of cells that are not listed, or that are of very many draws, and too narrow by little."""
    true = document("cells")
    interval = true["intervals"]["local"]
    for side in ("upper", "lower"):
        at = f"intervals.local.{side}"
        cells, listed = interval[side]["cells"], interval[side]["ends"]
        for what, numbers_, own in (
            ("nothing", [], []),
            ("the first left out", cells[1:], listed[1:]),
            ("the last left out", cells[:-1], listed[:-1]),
            ("cells of others", [n + 1 for n in cells], listed),
            ("a cell twice", cells[:1] + cells, listed[:1] + listed),
            ("backwards", cells[::-1], listed[::-1]),
            ("a cell that is not there", [*cells, 10**6], [*listed, ["0", "1"]]),
            ("a cell below 0", [-1, *cells], [["0", "1"], *listed]),
            ("fewer ends", cells, listed[:-1]),
            ("points", cells, [[low, low] for low, _ in listed]),
            ("halves", cells, [[str((F(low) + F(high)) / 2), high] for low, high in listed]),
            ("ends exchanged", cells, [[high, low] for low, high in listed]),
            ("numbers as texts", [str(n) for n in cells], listed),
            ("a number that is none", cells, [["0", "1/0"], *listed[1:]]),
        ):
            if (numbers_, own) != (cells, listed) and (side, what) != ("lower", "the last left out"):  # which proves nothing
                yield f"{side}: {what}", written(true, (at, {"cells": numbers_, "ends": own}))
        yield f"{side}: as if all were listed", written(true, (at, listed))
        yield f"{side}: more keys", written(true, (f"{at}.salt", []))
        for key in ("cells", "ends"):
            yield f"{side}: no {key}", written(true, (f"{at}.{key}", ...))
    for i, factor in ((1, F(999, 1000)), (0, F(1001, 1000)), (1, F(1, 2))):
        if interval["ratio"][i] not in ("inf", "1"):
            yield f"end {i} narrower", written(true, (f"intervals.local.ratio.{i}", str(F(interval["ratio"][i]) * factor)))
    yield from told_wrongly(true, "local")
    for kind, name in (("cells", "local"), ("judged", "local"), ("judged", "global")):
        true = document(kind)
        stated = true["intervals"][name]["pair"]
        if stated is not None:
            block, i, j = stated
            for pair in ([block, j, i], [block, i, i], [10**6, i, j], [block, i, 10**6], [-1, i, j], [i, j], [str(block), i, j], None):
                yield f"{kind} {name}: proved by {pair}", written(true, (f"intervals.{name}.pair", pair))
    draws = document("draws")
    for name, own in draws["intervals"].items():
        for side in ("upper", "lower"):
            for i, pair in enumerate(own[side]):
                for e, by in ((0, F(1, 10**4)), (1, -F(1, 10**4)), (0, F(1, 10**3)), (1, -F(1, 10**3))):
                    yield f"{name}.{side}[{i}][{e}] by {by}", written(draws, (f"intervals.{name}.{side}.{i}.{e}", str(F(pair[e]) + by)))
                yield (
                    f"{name}.{side}[{i}] is the share",
                    written(draws, (f"intervals.{name}.{side}.{i}", ["39/44", "39/44"] if i == 0 else ["10/19", "10/19"])),
                )


OF_SAMPLES: tuple[Callable[[], Iterator[Forged]], ...] = (verdicts, ladders, ends)
