"""Changes of a certificate, many thousands of them, and whether a changed one may still be true."""

from __future__ import annotations

import hashlib
import json
import re
import unicodedata
from collections.abc import Iterator
from decimal import Decimal, localcontext
from fractions import Fraction
from itertools import combinations, islice, pairwise, permutations
from math import gcd
from typing import Any

from certificate_kinds import (
    as_bytes,
)

VERY_EXACT = 120


# Changing something makes a certificate false or malformed


def strictly(document: bytes) -> Any:
    """Parse JSON in which no key is repeated."""

    def members(pairs: list[tuple[str, Any]]) -> dict[str, Any]:
        if len(dict(pairs)) < len(pairs):
            raise ValueError("a key is repeated")
        return dict(pairs)

    def refuse(token: str) -> Any:
        raise ValueError(token)

    return json.loads(document.decode("utf-8"), object_pairs_hook=members, parse_constant=refuse)


def same(left: Any, right: Any) -> bool:
    """Whether two JSON values are the same, 1 and 1.0 and true being different."""
    return json.dumps(left, sort_keys=True) == json.dumps(right, sort_keys=True)


def texts(value: Any) -> bool:
    return all(isinstance(item, str) and not re.search("[\ud800-\udfff]", item) for item in value)


def truly_judged(target: Any, metrics: Any) -> bool:
    """Whether a target is well formed and its verdict true, decided with decimals of many digits."""
    if not isinstance(target, dict) or set(target) != {"quantity", "limit", "unit", "judged", "verdict"}:
        return False
    if not texts(target.values()) or target["quantity"] not in ("local", "global") or target["unit"] not in ("log", "ratio", "difference"):
        return False
    match = re.fullmatch(r"(0|[1-9][0-9]*)(?:/([1-9][0-9]*))?", target["limit"])
    if not match or not match[0].isascii() or (match[2] and (match[2] == "1" or gcd(int(match[1]), int(match[2])) > 1)):
        return False
    limit, metric = Fraction(target["limit"]), metrics[target["quantity"]]
    if target["unit"] == "difference":
        if f"{target['quantity']}_difference" not in metrics or target["judged"] != "this table":
            return False
        apart = metrics[f"{target['quantity']}_difference"]
        verdict = "inconclusive" if apart is None else "exceeds" if Fraction(apart["value"]) > limit else "within"
        return bool(target["verdict"] == verdict)
    if metric is None and metrics.get(f"{target['quantity']}_difference"):  # of a utility below 0
        return False
    if target["judged"] != "this table" or (target["unit"] == "ratio" and limit < 1):
        return False
    if metric is None:
        return bool(target["verdict"] == "inconclusive")
    if metric["ratio"] == "inf":
        return bool(target["verdict"] == "exceeds")
    ratio = Fraction(metric["ratio"])
    if target["unit"] == "log":
        with localcontext() as context:
            context.prec = VERY_EXACT
            exceeds = (Decimal(ratio.numerator).ln() - Decimal(ratio.denominator).ln()) * limit.denominator > limit.numerator
    else:
        exceeds = ratio > limit
    return bool(target["verdict"] == ("exceeds" if exceeds else "within"))


def still_true(original: Any, mutant: bytes) -> bool:
    """Whether a changed certificate is a certificate of the same table in which every statement is true.

    The only such changes are: other text with the same JSON value; other versions, which are not checked; claims left out or
    in another order; assumptions in another order; pairs, or targets, left out of what would explain a ratio away; and targets that ask for
    something else and are judged rightly.
    """
    try:
        changed = strictly(mutant)
    except ValueError:
        return False
    if not isinstance(changed, dict) or set(changed) != set(original):
        return False
    if any(changed[key] != original[key] for key in ("subject", "metrics", "not_compared", "format")):  # the cheap test first
        return False
    if not all(same(changed[key], original[key]) for key in ("subject", "metrics", "not_compared")):
        return False
    versions, claims, targets = (changed[key] for key in ("versions", "claims", "targets"))
    if not isinstance(versions, dict) or not texts([*versions, *versions.values()]):
        return False
    if not isinstance(claims, list) or not isinstance(targets, list):
        return False
    for claim in claims:
        if not isinstance(claim, dict) or not isinstance(claim.get("assumptions"), list) or not texts(claim["assumptions"]):
            return False
    claims = [_with_whole_frontier(claim, original["claims"]) for claim in claims]
    known = [json.dumps(claim | {"assumptions": sorted(claim["assumptions"])}, sort_keys=True) for claim in original["claims"]]
    stated = [json.dumps(claim | {"assumptions": sorted(claim["assumptions"])}, sort_keys=True) for claim in claims]
    if len(set(stated)) < len(stated) or not set(stated) <= set(known):
        return False
    if not all(truly_judged(target, original["metrics"]) for target in targets):
        return False
    if len({(target["quantity"], target["unit"]) for target in targets}) < len(targets):
        return False
    verdicts = [target["verdict"] for target in targets] + ["none"]
    return bool(changed["verdict"] == next(v for v in ("exceeds", "inconclusive", "within", "none") if v in verdicts))


def says_no_more(original: Any, mutant: bytes) -> bool:
    """Whether a changed certificate that is accepted says what the original one does, or less, about drift, and else is still true.

    A pair and what is followed are how a claim is proved and not what it says, so that others may do as well.
    """
    changed = json.loads(mutant)
    if not isinstance(changed, dict) or not isinstance(changed.get("claims"), list):
        return False
    put_back = [
        next((own for own in original["claims"] if _says_less_of_drift(claim, own, original["metrics"])), claim)
        for claim in changed["claims"]
    ]
    once = [claim for i, claim in enumerate(put_back) if claim not in put_back[:i]]  # a claim may stand beside one that says more
    return still_true(original, as_bytes(changed | {"claims": once}))


def _says_less_of_drift(claim: Any, own: Any, metrics: Any) -> bool:
    """Whether one claim about drift follows from another: by a smaller move, and with a verdict that stands for it the more so.

    No factor makes what is 0 greater: a ratio that is infinite exceeds all limits for ever.
    """
    if not isinstance(claim, dict) or claim.get("by") != "T16" or not isinstance(claim.get("evidence"), dict):
        return False
    if set(claim["evidence"]) != set(own["evidence"]) or "verdict" not in own["evidence"] or claim["relation"] not in ("=", ">="):
        return False
    limits = [each["evidence"]["limit"] for each in (claim, own)]
    values = [each["value"] for each in (claim, own)]
    if not same(own, claim | {"evidence": own["evidence"], "relation": own["relation"], "value": own["value"]}):
        return False
    if claim["evidence"]["verdict"] != own["evidence"]["verdict"] or any(text != str(Fraction(text)) for text in limits):
        return False
    easier = (
        Fraction(limits[0]) >= Fraction(limits[1]) if own["evidence"]["verdict"] == "within" else Fraction(limits[0]) <= Fraction(limits[1])
    )
    quantity, _, form = own["quantity"].partition("_")
    if form.endswith("factor") and metrics[quantity]["ratio"] == "inf" and own["evidence"]["verdict"] == "exceeds":
        easier = True
    if claim["relation"] == "=":
        return own["relation"] == "=" and values[0] == values[1] and (limits[0] == limits[1] or (easier and values[0] == "inf"))
    least = 0 if claim["quantity"].endswith("_radius") else 1
    if values[0] == "inf" or values[0] != str(Fraction(values[0])) or Fraction(values[0]) < least:
        return False
    return easier and (values[1] == "inf" or Fraction(values[0]) <= Fraction(values[1]))


def _on_the_same_curve(pairs: list[Any], whole: list[list[str]]) -> bool:
    """Whether pairs (k,m) are some of those, k rising; the curve is the same with k and m exchanged."""
    if not all(any(same(pair, own) for known in whole for own in (known, known[::-1])) for pair in pairs):
        return False
    common = [Fraction(k) for k, _ in pairs]
    return all(one < other for one, other in pairwise(common))


def _with_whole_frontier(claim: Any, claims: list[Any]) -> Any:
    """The claim with what was left out of its frontier put back, if it is one of these with nothing else changed."""
    shown = claim.get("evidence")
    levels = shown["frontier"] if isinstance(shown, dict) and set(shown) == {"frontier"} else None
    whole = next((c["evidence"]["frontier"] for c in claims if "frontier" in c["evidence"] and same(c | {"evidence": shown}, claim)), None)
    if whole is None or not isinstance(levels, list) or not levels or not isinstance(levels[0], dict):
        return claim
    if levels[0].get("to") != "1":
        return claim
    stated = {level["to"]: level for level in whole}
    for level in levels:
        own = stated.pop(level.get("to"), None) if isinstance(level, dict) and isinstance(level.get("to"), str) else None
        if own is None or not isinstance(level.get("pairs"), list) or not same(own | {"pairs": level["pairs"]}, level):
            return claim
        if not _on_the_same_curve(level["pairs"], own["pairs"]):
            return claim
    order = [level["to"] for level in whole]
    places = [order.index(level["to"]) for level in levels]
    return claim | {"evidence": {"frontier": whole}} if places == sorted(places) else claim


Path_ = tuple[Any, ...]


def places(value: Any, path: Path_ = ()) -> Iterator[tuple[Path_, Any]]:
    """Every value in a document with the way to it, except what is not checked."""
    if path[:1] == ("versions",):
        return
    yield path, value
    for key in value if isinstance(value, dict) else range(len(value)) if isinstance(value, list) else ():
        yield from places(value[key], (*path, key))


def put(text: str, path: Path_, value: Any) -> Any:
    """A copy of a document with one value changed, given its text."""
    document = json.loads(text)
    place = document
    for step in path[:-1]:
        place = place[step]
    place[path[-1]] = value
    return document


NUMBER = re.compile(r"-?[0-9]+(/[0-9]+)?")
LOG = re.compile(r"[0-9]+\.[0-9]{12}")


def other_numbers(text: str) -> list[Any]:
    value = Fraction(text)
    n, d = value.numerator, value.denominator
    numbers: list[Any] = [value + 1, value - 1, value + Fraction(1, 7), value / 2, -value, value**2, Fraction(d, n) if n else 7, 0, 1]
    spelt = [
        f"{2 * n}/{2 * d}",
        f"{n}/1",
        f"0{text}",
        f"+{text}",
        f"-{text}",
        f"{n}.0",
        f"{n}e0",
        f"{n}/0",
        f"{n}/-{d}",
        f"{n}//{d}",
        f"{n}/0{d}",
    ]
    spelt += [
        f"{text} ",
        f" {text}",
        f"{text}\n",
        f"{text}\x00",
        text.translate({48 + i: 0xFF10 + i for i in range(10)}),
        f"{n}_0",
        f"{n},0",
        "0.5",
    ]
    spelt += ["inf", "-inf", "nan", "Infinity", "", "-0", "0/1", "0x1", "1" + "0" * 4000]
    return [*map(str, numbers), *spelt, n if d == 1 else n / d, n, float(n), d, None, True, False, [text], [n, d], {"n": text}]


def other_logs(text: str) -> list[Any]:
    value = Decimal(text)
    spelt = [str(value + Decimal(k).scaleb(-12)) for k in (-2, -1, 1, 2, 10**12)]
    spelt += [f"0{text}", f"+{text}", f"-{text}", text[:-1], f"{text}0", f"{value:e}", text.replace(".", ","), "0", "inf", "1", f"{text}\n"]
    return [*spelt, float(value), None, [text]]


def other_strings(text: str, pool: list[str]) -> list[Any]:
    spelt = [
        text.swapcase(),
        text.upper(),
        text.title(),
        "",
        f"{text} ",
        f" {text}",
        f"{text}\u200b",
        text[::-1],
        text[:-1],
        f"{text}\x00",
        "\ud800",
        "0",
    ]
    spelt += [unicodedata.normalize(form, text) for form in ("NFC", "NFD", "NFKC")]
    if text == "inf":
        spelt += ["Infinity", "infinity", "+inf", "-inf", "oo", "∞", "1/0", "nan", "1e999", "1" + "0" * 4000]
    return [*spelt, *pool, None, 0, 1, True, [text], {}, {text: text}]


def other_values(value: Any, pool: list[str]) -> list[Any]:
    """Values to put into the place of a leaf, or of a whole list or object."""
    if isinstance(value, bool):
        return [not value, int(value), str(value), str(value).lower(), None, 2]
    if isinstance(value, int):
        return [value + 1, value - 1, -value, value + 256, float(value), str(value), bool(value), value == 1, None, [value], 10**30]
    if value is None:
        return ["0", "1", 0, False, "", "null", [], {}, "inf"]
    if isinstance(value, str):
        digest = re.fullmatch("[0-9a-f]{64}", value)
        if digest:
            return [
                ("0" if c != "0" else "1").join((value[:i], value[i + 1 :])) for i, c in enumerate(value) if i % 9 == 0
            ] + other_strings(value, pool[:3])
        return (
            other_numbers(value) if NUMBER.fullmatch(value) else other_logs(value) if LOG.fullmatch(value) else other_strings(value, pool)
        )
    if isinstance(value, list):
        lists = [value[:i] + value[i + 1 :] for i in range(len(value))]  # an entry removed
        lists += [value[: i + 1] + value[i:] for i in range(len(value))]  # duplicated
        lists += [[*value[:i], value[i + 1], value[i], *value[i + 2 :]] for i in range(len(value) - 1)]  # swapped
        lists += [value[::-1], [], [*value, None], [*value, "0"], [*value, *value], [value]]
        return [*lists, None, "", {}, {str(i): item for i, item in enumerate(value)}]
    objects: list[Any] = [{k: v for k, v in value.items() if k != key} for key in value]  # a key removed
    for key in value:
        objects += [
            {(new if k == key else k): v for k, v in value.items()} for new in (key.upper(), f"{key} ", f"{key}s", "", "x")
        ]  # renamed
    for one, other in combinations(value, 2):
        objects.append(value | {one: value[other], other: value[one]})  # values swapped
    objects += [value | {new: filler} for new in ("extra", "salt", "mass", "utility", "log") for filler in ("0", None)]  # added
    return [*objects, {}, None, [], [value], list(value.values()), ""]


def strings(document: Any) -> list[str]:
    found = {value for _, value in places(document) if isinstance(value, str) and not NUMBER.fullmatch(value) and not LOG.fullmatch(value)}
    return sorted(text for text in found if len(text) < 64)


def changed_values(document: Any, first: int = 0, step: int = 1) -> Iterator[bytes]:
    """Change every leaf, list and object of a document in many ways; with a step, one change in so many."""
    pool, text = strings(document), json.dumps(document)
    changes = ((path, other) for path, value in places(document) for other in other_values(value, pool))
    for path, other in islice(changes, first, None, step):
        yield as_bytes(put(text, path, other) if path else other)


def changed_text(document: Any) -> Iterator[bytes]:
    """Change the text: repeated keys at every level, every digit, every character removed, what stands before and after."""
    text = json.dumps(document, separators=(",", ":"))
    for match in re.finditer(r'"[^"\\]*":', text):
        yield f'{text[: match.start()]}{match[0]}"0",{text[match.start() :]}'.encode()
    for match in re.finditer(r'("[^"\\]*":)("[^"\\]*"|[0-9]+|null|true|false)', text):
        yield f"{text[: match.end()]},{match[0]}{text[match.end() :]}".encode()
    for i, c in enumerate(text):
        yield f"{text[:i]}{text[i + 1 :]}".encode()
        if c.isdigit():
            yield f"{text[:i]}{(int(c) + 1) % 10}{text[i + 1 :]}".encode()
    raw = text.encode()
    yield from (
        b"\xef\xbb\xbf" + raw,
        raw + b"\x00",
        raw + b"{}",
        b"[" + raw + b"]",
        raw + b",",
        raw[:-1],
        b"",
        raw.replace(b",", b",,", 1),
    )
    yield from (text.encode("utf-16"), raw.replace(b"1", b"\xff", 1), raw.replace(b'"', b"'"), raw.replace(b'"0"', b"NaN"), b"//\n" + raw)


def swapped_sections(document: Any, others: list[Any]) -> Iterator[bytes]:
    """Put parts of a document into the place of other parts, and parts of other documents into it."""
    text = json.dumps(document)
    for one, other in permutations(document["metrics"], 2):
        yield as_bytes(put(text, ("metrics", one), document["metrics"][other]))
    for name, metric in document["metrics"].items():
        if not isinstance(metric, dict):
            continue
        witness = metric["witness"]
        turned = witness | {"higher": witness["lower"], "lower": witness["higher"]}
        yield as_bytes(put(text, ("metrics", name, "witness"), turned))
        for key in ("expectations", "probabilities", "rates"):
            if key in turned:
                yield as_bytes(put(text, ("metrics", name, "witness"), turned | {key: turned[key][::-1]}))
    for i, claim in enumerate(document["claims"]):
        for relation, by in (
            ("<=", "enumeration"),
            ("<=", "T5"),
            ("=", "T5"),
            ("<=", "T6"),
            ("=", "T7"),
            (">=", "T7"),
            ("<=", "T7"),
            ("=", "T8"),
        ):
            yield as_bytes(put(text, ("claims", i), claim | {"relation": relation, "by": by}))
    for verdict in ("none", "within", "exceeds", "inconclusive"):
        yield as_bytes(document | {"verdict": verdict})
        yield as_bytes(document | {"verdict": verdict, "targets": []})
        yield as_bytes(document | {"verdict": verdict, "targets": [target | {"verdict": verdict} for target in document["targets"]]})
    for other in others:
        for key in ("subject", "metrics", "not_compared", "claims", "targets"):
            yield as_bytes(document | {key: other[key]})
        for section in ("subject", "metrics"):
            for key in other[section]:
                yield as_bytes(put(text, (section, key), other[section][key]))
        for key in ("sha256", "header", "rows"):
            if key in other["subject"]["table"]:
                yield as_bytes(put(text, ("subject", "table", key), other["subject"]["table"][key]))
        for claim in other["claims"]:
            yield as_bytes(document | {"claims": [*document["claims"], claim]})
        for i, claim in enumerate(other["claims"][: len(document["claims"])]):
            yield as_bytes(put(text, ("claims", i), claim))
            if "table" in claim["evidence"]:  # somebody else's figure under our digest
                ours = claim | {"evidence": {"table": document["subject"]["table"]["sha256"]}}
                yield as_bytes(put(text, ("claims", i), ours))
        for entry in other["not_compared"]:
            yield as_bytes(document | {"not_compared": [*document["not_compared"], entry]})


def canonical(value: Any) -> bytes:
    return json.dumps(value, sort_keys=True, separators=(",", ":")).encode() + b"\n"


def redigested(document: Any) -> bytes:
    """Bring the digests of a changed document in line with its changed table."""
    entry = document["subject"]["table"]
    old, new = entry["sha256"], hashlib.sha256(b"".join(map(canonical, [entry["header"], *entry["rows"]]))).hexdigest()
    return as_bytes(document).replace(old.encode(), new.encode())


def named_anew(document: bytes) -> bytes:
    """Bring the digests in the header, and that of the table, in line with what the subject now says of the log, so far as it is one."""
    try:
        changed = strictly(document)
        subject = changed["subject"]
        header = {key: value for key, value in subject["table"]["header"].items() if key not in ("preparation", "evaluation")}
        for key in ("preparation", "evaluation"):
            if key in subject:
                header[key] = hashlib.sha256(canonical(subject[key])).hexdigest()
        subject["table"]["header"] = header
    except (ValueError, TypeError, KeyError):
        return document
    return redigested(changed)


def other_tables(document: Any) -> Iterator[bytes]:
    """Change the embedded table and, consistently, every digest: what is said of it is then untrue."""
    text, rows = json.dumps(document), document["subject"]["table"]["rows"]
    at = ("subject", "table", "rows")
    for i, row in enumerate(rows):
        if row.get("mass") == "0":  # without population a row enters few figures, and another may give the same ones
            continue
        for u, weight in enumerate(row["weights"]):
            for change in (1, Fraction(1, 3), Fraction(weight)):
                yield redigested(put(text, (*at, i, "weights", u), str(Fraction(weight) + change)))
            if "utility" in row and weight != "0":  # where the weight is 0, another utility may change no figure
                yield redigested(put(text, (*at, i, "utility", u), str(Fraction(row["utility"][u]) + 1)))
        for u, v in permutations(range(len(row["weights"])), 2):
            swapped = list(row["weights"])
            swapped[u], swapped[v] = swapped[v], swapped[u]
            if swapped != row["weights"]:
                yield redigested(put(text, (*at, i, "weights"), swapped))
        for key, value in [("context", row["context"] + 1), ("group", row["group"] + 1), ("mass", "1/2")]:
            yield redigested(put(text, (*at, i, key), value))
        for key in ("context", "group"):
            for value in (bool(row[key]), float(row[key]), str(row[key]), row[key] - 5):
                yield redigested(put(text, (*at, i, key), value))
        yield redigested(put(text, at, rows[:i] + rows[i + 1 :]))
        yield redigested(put(text, at, rows[: i + 1] + rows[i:]))
    for i, j in permutations(range(len(rows)), 2):
        yield redigested(put(text, at, [rows[j if k == i else i if k == j else k] for k in range(len(rows))]))
        traded = [rows[j] | {"context": r["context"], "group": r["group"]} if k == i else r for k, r in enumerate(rows)]
        if not same(traded, rows):
            yield redigested(put(text, at, traded))
    header = document["subject"]["table"]["header"]
    for u in range(len(header["utility"] or [])):
        yield redigested(put(text, ("subject", "table", "header", "utility", u), str(Fraction(header["utility"][u]) + 1)))
    for name in ("decisions", "groups"):
        yield redigested(put(text, ("subject", "table", "header", name), header[name][::-1]))
        yield redigested(put(text, ("subject", "table", "header", name), [*header[name], header[name][0]]))
