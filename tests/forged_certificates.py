"""Certificates that somebody wrote to deceive a checker: true ones, of which by hand something was made false or ambiguous."""

from __future__ import annotations

import json
import re
from collections.abc import Callable, Iterator
from fractions import Fraction
from functools import cache
from itertools import product
from typing import Any

from assumptions import complete
from certificate_changes import redigested
from certificate_kinds import true_labels, weighted
from class_certificates import by_hand as of_class
from class_certificates import entries
from forged_samples import OF_SAMPLES, Forged
from forged_statements import OF_STATEMENTS
from forged_units import paired
from plain_certificates import COUNTS, LIMITS, edited, make
from policy_certificates import by_hand as of_policy

import fairaudit as fa

ROWS = "subject.table.rows"
HEADER = "subject.table.header"


def small_sample() -> fa.Result:
    """Few draws of two groups in two contexts, which prove intervals."""
    return fa.certify(fa.Law.from_array([[[40, 10], [15, 35]], [[20, 30], [22, 28]]], kind="counts"), {"0": 1})


@cache
def _text(kind: str) -> str:
    worst = entries(*[(x, a, 1 - a, []) for x in (0, 1) for a in (0, 1)])
    made: dict[str, Callable[[], Any]] = {
        "plain": lambda: complete(make(COUNTS, ["1", "0"], limits=LIMITS)),
        "partial": lambda: complete(make({(0, 0): ["3", "0"], (0, 1): ["1", "3"], (1, 2): ["1", "1"]}, ["1", "0"], limits=LIMITS)),
        "weighted": lambda: json.loads(weighted(max_local_ratio=100).certificate.text),
        "truth": lambda: json.loads(true_labels().certificate.text),
        "policy": of_policy,
        "sample": lambda: json.loads(small_sample().certificate.text),
        "class": lambda: complete(of_class("inf", "lp-dual", worst)),
    }
    return json.dumps(made[kind]())


def document(kind: str) -> Any:
    """A true certificate, to be changed."""
    return json.loads(_text(kind))


def with_value(kind: str, path: str, value: Any, *, digest: bool = False) -> bytes:
    """The certificate with one value changed, and its digests brought in line or not."""
    changed = edited(document(kind), path, value)
    return redigested(changed) if digest else json.dumps(changed).encode()


NOT_RATIONALS = [
    "-0",
    "00",
    "01",
    "+1",
    "1/1",
    "2/4",
    "6/2",
    "0/1",
    "0/7",
    "1/0",
    "-1/-3",
    "1/-3",
    "1 / 3",
    "1_0",
    "１",
    "٣",
    "1e3",
    "1E+400",
    "0x1",
]
NOT_RATIONALS += [
    "1e999999999",
    "1.0",
    ".5",
    "1.",
    "",
    " 1",
    "1 ",
    "1\n",
    "1\u0000",
    "1/",
    "/3",
    "1//3",
    "1/3/5",
    "nan",
    "NaN",
    "Infinity",
    "-inf",
]
NOT_RATIONALS += ["3\u200b", "\ufeff3", "3\u2044" + "1", "½", "³", "𝟛", "--3", "3-", "inf ", "INF", "1,000"]
NOT_STRINGS = [3, 3.0, True, None, ["3"], {"3": "1"}, 10**30, -1]


def numbers() -> Iterator[Forged]:
    """Numbers that some readers take for others."""
    places = [(f"{ROWS}.0.weights.0", True), ("metrics.local.ratio", False), ("claims.0.value", False), ("targets.0.limit", False)]
    for path, digest in places:
        for text in NOT_RATIONALS:
            yield f"{path} is {text!r}", with_value("plain", path, text, digest=digest)
        for value in NOT_STRINGS:
            yield f"{path} is {value!r}", with_value("plain", path, value, digest=digest)
    for text in ("-1", "1/3", "1" + "0" * 5000):
        yield f"a weight of {text[:9]}", with_value("plain", f"{ROWS}.0.weights.0", text, digest=True)
    for index in ("0", 0.0, -1, 2, 10**17, 10**18, 2**63, 2**64, 1e400, True, None, [0]):
        yield f"a row of context {index}", with_value("plain", f"{ROWS}.0.context", index, digest=index is not None and index != 1e400)
        yield f"a row of group {index}", with_value("plain", f"{ROWS}.1.group", index, digest=False)
    for cells in (7, 9, "8", 8.0, -8, 2**30, 2**63, 2**64 + 8, 10**18, None, True):
        yield f"{cells} cells", with_value("plain", "subject.table.cells", cells)
    for token in (
        "-0",
        "1.0",
        "1e0",
        "1E2",
        "01",
        "NaN",
        "Infinity",
        "-Infinity",
        "+1",
        "0x1",
        "1_0",
        ".0",
        "0.",
        "1e",
        "--1",
        "9" * 19,
        "9" * 10**5,
    ):
        yield f"an index written {token[:20]}", _text("plain").replace('"context": 0', f'"context": {token}', 1).encode()


def _repeated(text: str, key: str, value: str, count: int = 0) -> bytes:
    """A key before the one that is there, or after it."""
    found = [*re.finditer(f'"{key}": ', text)][count]
    return f'{text[: found.start()]}"{key}": {value}, {text[found.start() :]}'.encode()


def keys() -> Iterator[Forged]:
    """Keys twice, in other letters, escaped, missing, and further ones."""
    text = _text("plain")
    for key, value in [
        *[("format", '"fairaudit-certificate/1"'), ("subject", "{}"), ("metrics", "{}"), ("claims", "[]"), ("targets", "[]")],
        *[("verdict", '"within"'), ("versions", "{}"), ("sha256", '"0"'), ("cells", "8"), ("rows", "[]"), ("header", "{}")],
        *[("decisions", '["u0", "u1"]'), ("groups", "[]"), ("utility", '["0", "1"]'), ("weights", '["1", "1"]'), ("ratio", '"1"')],
        *[("log", '["0", "0"]'), ("witness", "{}"), ("value", '"1"'), ("by", '"T5"'), ("limit", '"100"'), ("higher", "{}")],
        *[("assumptions", "[]"), ("evidence", "{}"), ("scope", '"this law"'), ("population", '"equal"'), ("kind", '"probabilities"')],
    ]:
        yield f"{key} twice", _repeated(text, key, value)
        yield (
            f"{key} twice, escaped",
            _repeated(text, key, value).replace(f'"{key}"'.encode(), f'"\\u{ord(key[0]):04x}{key[1:]}"'.encode(), 1),
        )
        yield f"{key} in capitals", text.replace(f'"{key}": ', f'"{key.upper()}": ', 1).encode()
        yield f"{key} and a zero", text.replace(f'"{key}": ', f'"{key}\\u0000": ', 1).encode()
        yield f"{key} left out", re.sub(f'"{key}": ', '"x": ', text, count=1).encode()
    for path in ("subject", "subject.table", "subject.utility", "subject.columns", HEADER, f"{ROWS}.0", "metrics", "metrics.local"):
        for key in ("salt", "__proto__", "constructor", "toString", "", "mass", "positive"):
            yield f"{path} has {key!r}", with_value("plain", f"{path}.{key}", "0", digest=path in (HEADER, f"{ROWS}.0"))
    for path in ("metrics.local.witness", "claims.0", "claims.0.evidence", "targets.0"):
        for key in ("__proto__", "context ", "table\u0000", "tips", "estimand"):
            yield f"{path} has {key!r}", with_value("plain", f"{path}.{key}", "0")


def texts() -> Iterator[Forged]:
    """Bytes that are no JSON, or that some readers take for it."""
    text = _text("plain")
    raw = text.encode()
    yield "a byte order mark", b"\xef\xbb\xbf" + raw
    for name in ("utf-16", "utf-16-le", "utf-16-be", "utf-32", "cp037"):
        yield name, text.encode(name)
    for at in (0, 1, 100, len(raw) // 2, len(raw) - 1):
        yield f"cut at {at}", raw[:at]
    for after in (b"\x00", b"{}", b",", b"]", b"}", b"//", b"\xff", raw, b"\x1a", b"\x0b", b"\xc2\xa0", b"\xe2\x80\xa8"):
        yield f"then {after[:9]!r}", raw + after
        yield f"{after[:9]!r} first", after + raw
    for bad in (
        b"\xff",
        b"\xc0\x80",
        b"\xed\xa0\x80",
        b"\xf4\x90\x80\x80",
        b"\xc1\xbf",
        b"\xe0\x80\xaf",
        b"\xf8\x88\x80\x80\x80",
        b"\x80",
        b"\xe2\x82",
    ):
        yield f"a label with {bad!r}", raw.replace(b"u0", b"u" + bad, 1)
    for escape in (
        "\\ud800",
        "\\udc00",
        "\\ud800\\ud800",
        "\\udc00\\ud800",
        "\\ud83d",
        "\\u00",
        "\\x41",
        "\\u00zz",
        "\\",
        "\\'",
        "\\0",
        "\\U0041",
        "\n",
        "\t",
        "\x01",
        "\x1f",
    ):
        yield f"a label with {escape!r}", text.replace('"u0"', f'"u0{escape}"').encode()
    for old, new in [
        ('"', "'"),
        (",", ",,"),
        (":", "::"),
        ("{", "[{"),
        ("false", "False"),
        ("false", "undefined"),
        ("false", "0"),
        ("]", ",]"),
        ("}", ",}"),
    ]:
        assert old in text
        yield f"{new} for {old}", text.replace(old, new, 1).encode()
    for depth in (1_000, 100_000, 1_000_000):
        yield f"{depth} brackets", b"[" * depth
        yield f"{depth} objects", b'{"a":' * depth
        yield f"versions of {depth} brackets", raw.replace(b'"fairaudit": "0"', b'"fairaudit": ' + b"[" * depth + b"]" * depth)
        yield f"{depth} closing brackets", raw + b"]" * depth
    yield "an empty file", b""
    yield "a page without a certificate", b"<!doctype html><p>true"
    for other in (
        "fairaudit-certificate/2",
        "Fairaudit-certificate/1",
        "fairaudit-certificate/1 ",
        "fairaudit-certificate/01",
        "",
        None,
        1,
    ):
        yield f"format {other!r}", with_value("plain", "format", other)


def tables() -> Iterator[Forged]:
    """Another table under the old figures: the digest right, or that of the true table."""
    labels: Any
    value: Any
    for digest in (False, True):
        name = "its own digest" if digest else "the old digest"
        for i in range(4):
            for u in range(2):
                for weight in ("0", "7", "1000000000000000000000", "1/3"):
                    yield f"row {i} has weight {weight}, {name}", with_value("plain", f"{ROWS}.{i}.weights.{u}", weight, digest=digest)
        rows = document("plain")["subject"]["table"]["rows"]
        for order in ([1, 0, 2, 3], [0, 2, 1, 3], [3, 2, 1, 0], [0, 0, 1, 2, 3], [0, 1, 2, 3, 3], [0, 1, 2], [1, 2, 3], [0, 2], []):
            yield f"rows {order}, {name}", with_value("plain", ROWS, [rows[i] for i in order], digest=digest)
        swapped = [rows[i] | {"group": 1 - rows[i]["group"]} for i in (1, 0, 3, 2)]
        yield f"groups exchanged, {name}", with_value("plain", ROWS, swapped, digest=digest)
        for key, labels in [
            ("decisions", ["u0", "u0"]),
            ("decisions", ["u1", "u0"]),
            ("decisions", ["u0", "u\u0430"]),
            ("decisions", ["u0"]),
        ]:
            yield f"{key} {labels}, {name}", with_value("plain", f"{HEADER}.{key}", labels, digest=digest)
        for labels in (
            [["a1"], ["a0"]],
            [["a0"], ["a0"]],
            [["a0"], ["а1"]],
            [["a0"]],
            [["a0"], ["a1"], ["a2"]],
            [["a0", "a1"]],
            ["a0", "a1"],
            [],
        ):
            yield f"groups {labels}, {name}", with_value("plain", f"{HEADER}.groups", labels, digest=digest)
        for labels in ([["x1"], ["x0"]], [["x0"], ["x0"]], [["x0"]], [["x0"], ["x1"], ["x2"]]):
            yield f"contexts {labels}, {name}", with_value("plain", f"{HEADER}.contexts", labels, digest=digest)
        for utility in (["0", "1"], ["1", "1"], ["2", "0"], ["1"], ["1", "0", "0"], ["-1", "0"], [None, "0"], None, "1", ["1", "-0"]):
            yield f"utility {utility}, {name}", with_value("plain", f"{HEADER}.utility", utility, digest=digest)
        for key, value in [
            ("kind", "probabilities"),
            ("kind", "policy"),
            ("population", "equal"),
            ("population", "weights"),
            ("format", "fairaudit-table/2"),
        ]:
            yield f"{key} {value}, {name}", with_value("plain", f"{HEADER}.{key}", value, digest=digest)
        for columns in (
            {"decision": "D", "group": ["H"], "context": ["C"]},
            {"decision": "D", "group": ["C"], "context": ["G"]},
            {"decision": "D", "group": ["G"], "context": []},
        ):
            yield f"columns {columns}, {name}", with_value("plain", f"{HEADER}.columns", columns, digest=digest)
        for i, mass in ((0, "1"), (0, "-1"), (1, "0"), (2, "2/4"), (0, None), (0, ...)):
            yield f"mass {i} is {mass}, {name}", with_value("weighted", f"{ROWS}.{i}.mass", mass, digest=digest)
        for i, row in (
            (0, ["1/2", "1/2", "1/2"]),
            (0, ["1/2", "1/3", "1/7"]),
            (1, ["2", "-1", "0"]),
            (1, ["0", "0", "0"]),
            (2, ["1", "0"]),
            (2, ["0", "1", "0", "0"]),
        ):
            yield f"law {i} is {row}, {name}", with_value("weighted", f"{ROWS}.{i}.weights", row, digest=digest)
        truth = document("truth")["subject"]["table"]["rows"]
        i, key = next((i, key) for i, row in enumerate(truth) for key in row if key not in ("context", "group", "weights"))
        for value in (truth[i]["weights"], [], None, ["0"], ["1"] * 9, [["-1"]]):
            yield f"{key} {i} is {value}, {name}", with_value("truth", f"{ROWS}.{i}.{key}", value, digest=digest)
    wrong = document("plain")
    for sha in ("0" * 64, wrong["subject"]["table"]["sha256"].upper(), wrong["subject"]["table"]["sha256"][:-1], "", None, 0):
        yield f"digest {sha!r}", with_value("plain", "subject.table.sha256", sha)
    other = document("partial")["subject"]["table"]
    for key in ("sha256", "header", "rows"):
        yield f"{key} of another table", with_value("plain", f"subject.table.{key}", other[key])
    yield "another table", with_value("plain", "subject.table", other)
    for key in ("header", "rows"):
        yield f"no {key}", with_value("plain", f"subject.table.{key}", ...)


def figures() -> Iterator[Forged]:
    """Figures that are a little off, of other places, or left out."""
    for kind in ("plain", "partial", "weighted", "truth"):
        true = document(kind)
        for name, metric in true["metrics"].items():
            yield f"{kind}: no {name}", with_value(kind, f"metrics.{name}", ... if metric is None else None)
            if isinstance(metric, list) or metric is None:
                yield f"{kind}: {name} twice", with_value(kind, f"metrics.{name}", [] if metric is None else [*metric, *metric])
                continue
            key = "ratio" if "ratio" in metric else "value"
            value = metric[key]
            near = (
                ["10000000000000000000000"] if value == "inf" else [str(Fraction(value) * (1 + Fraction(sign, 10**40))) for sign in (1, -1)]
            )
            for other in [*near, "1/3", "0" if value != "0" else "1"]:
                yield f"{kind}: {name} is {other[:12]}", with_value(kind, f"metrics.{name}.{key}", other)
            witness = metric["witness"]
            turned = witness | {"higher": witness["lower"], "lower": witness["higher"]}
            yield f"{kind}: {name} turned", with_value(kind, f"metrics.{name}.witness", turned)
            yield (
                f"{kind}: {name} of nobody",
                with_value(kind, f"metrics.{name}.witness.lower", dict.fromkeys(witness["lower"], "nobody")),
            )
            yield f"{kind}: {name} of one", with_value(kind, f"metrics.{name}.witness.lower", witness["higher"])
            for twin in ("expectations", "probabilities", "rates", "decisions"):
                if twin in witness:
                    yield (
                        f"{kind}: {twin} of {name} turned",
                        with_value(kind, f"metrics.{name}.witness.{twin}", [*witness[twin][::-1], "0"]),
                    )
            if "log" in metric and metric["log"][0] not in ("0", "inf"):
                low, high = (Fraction(end) for end in metric["log"])
                for by in (Fraction(1, 10**12), -Fraction(1, 10**12), Fraction(1)):
                    ends = [f"{float(end + by):.12f}" for end in (low, high)]
                    yield f"{kind}: log of {name} off by {by}", with_value(kind, f"metrics.{name}.log", ends)
                yield f"{kind}: log of {name} too wide", with_value(kind, f"metrics.{name}.log", ["0", metric["log"][1]])
                yield f"{kind}: log of {name} turned", with_value(kind, f"metrics.{name}.log", metric["log"][::-1])
        for key, stated in true["subject"]["utility"].items():
            for value in ("5", "1/7", "-1", None, True, "0"):
                if value != stated:
                    yield f"{kind}: {key} is {value}", with_value(kind, f"subject.utility.{key}", value)
        for gone in range(len(true["not_compared"])):
            entries_left = true["not_compared"]
            yield f"{kind}: {gone} not listed", with_value(kind, "not_compared", entries_left[:gone] + entries_left[gone + 1 :])
            yield f"{kind}: {gone} listed twice", with_value(kind, "not_compared", [*entries_left, entries_left[gone]])
            yield f"{kind}: {gone} has another reason", with_value(kind, f"not_compared.{gone}.reason", "no reason")
        yield f"{kind}: a group left out", with_value(kind, "not_compared", [{"groups": [["a0"]], "reason": "no population"}])
    for key, value in [
        ("kind", "probabilities"),
        ("population", "equal"),
        ("population", "weights"),
        ("columns", {"decision": "D", "group": ["G"], "context": []}),
    ]:
        yield f"subject.{key} {value}", with_value("plain", f"subject.{key}", value)


def claims() -> Iterator[Forged]:
    """Claims that are false, that say more, that look like known ones, twice; limits and verdicts that contradict."""
    evidence: Any
    verdict: Any
    for kind in ("plain", "partial", "weighted", "policy", "class"):
        true = document(kind)["claims"]
        for i, claim in enumerate(true):
            yield f"{kind}: claim {i} twice", with_value(kind, "claims", [*true, claim])
            yield (
                f"{kind}: claim {i} also otherwise",
                with_value(kind, "claims", [*true, claim | {"value": "1" if claim["value"] != "1" else "2"}]),
            )
            for value in ("0", "1/2", "inf" if claim["relation"] == "=" and claim["value"] != "inf" else "-1"):
                if value != claim["value"] and not (claim["by"] == "lp-dual" and value == "inf"):
                    yield f"{kind}: claim {i} is {value}", with_value(kind, f"claims.{i}.value", value)
            for key, other in [
                ("by", f"{claim['by']} "),
                ("by", claim["by"].swapcase()),
                ("by", "T5"),
                ("relation", ">="),
                ("relation", "≤"),
            ]:
                if claim[key] != other and not (other == ">=" and claim["by"] == "T16"):  # which is true, and less
                    yield f"{kind}: claim {i} {key} {other!r}", with_value(kind, f"claims.{i}.{key}", other)
            for other in ("any policy", "This law", "this law\u200b", "population at confidence 19/20"):
                yield f"{kind}: claim {i} of {other!r}", with_value(kind, f"claims.{i}.scope", other)
            for other in ("unfairness", "global_ratio" if claim["quantity"] == "local_ratio" else "local_ratio"):
                if not (other == "global_ratio" and (claim["by"], claim["relation"]) == ("T5", "<=")):
                    yield f"{kind}: claim {i} about {other}", with_value(kind, f"claims.{i}.quantity", other)
            for evidence in ({}, None, [], {"table": "0" * 64}, {"supremum": "1/9"}, {"table": None}, claim["evidence"] | {"salt": "1"}):
                if evidence != claim["evidence"]:
                    yield f"{kind}: claim {i} because of {str(evidence)[:20]}", with_value(kind, f"claims.{i}.evidence", evidence)
            for extra in (["the moon is full"], [*claim["assumptions"], "the moon is full"], [*claim["assumptions"], 1], None):
                yield f"{kind}: claim {i} assumes {str(extra)[:30]}", with_value(kind, f"claims.{i}.assumptions", extra)
            if claim["assumptions"]:
                yield f"{kind}: claim {i} assumes nothing", with_value(kind, f"claims.{i}.assumptions", [])
    for by in ("enumeration", "T5", "T6", "T7", "lp-dual", "Enumeration", "T05", "T5\u0000", "proof", ""):
        claim = {
            "quantity": "local_ratio",
            "relation": "<=",
            "by": by,
            "value": "1",
            "scope": "this law",
            "assumptions": [],
            "evidence": {},
        }
        yield f"a ratio of 1 by {by!r}", with_value("plain", "claims", [claim])
    true = document("plain")
    for i, target in enumerate(true["targets"]):
        for verdict in {"within", "exceeds", "inconclusive", "depends", "changed", "Within", ""} - {target["verdict"]}:
            yield f"target {i} {verdict}", with_value("plain", f"targets.{i}.verdict", verdict)
        for key, value in [
            ("limit", "-1"),
            ("limit", "inf"),
            ("unit", "nats"),
            ("unit", "difference"),
            ("quantity", "both"),
            ("judged", "this table "),
        ]:
            yield f"target {i}: {key} {value!r}", with_value("plain", f"targets.{i}.{key}", value)
        yield f"target {i} twice", with_value("plain", "targets", [*true["targets"], target])
        yield (
            f"target {i} also otherwise",
            with_value("plain", "targets", [*true["targets"], target | {"limit": "100", "verdict": "within"}]),
        )
    for verdict in {"within", "exceeds", "inconclusive", "none", "depends", "changed", "passed", None} - {true["verdict"]}:
        yield f"verdict {verdict}", with_value("plain", "verdict", verdict)
    yield "no target, a verdict", json.dumps(true | {"targets": [], "verdict": "within"}).encode()


def policies() -> Iterator[Forged]:
    """Filters that are none, that say more privacy than they have, and policies without the rows that are released."""
    at = f"{HEADER}.filters.group.0"
    for row in (["1", "1"], ["2/3", "1/4"], ["4/3", "-1/3"], ["0", "0"], ["1"], ["2/3", "1/3", "0"], ["3/4", "1/4"], [], None, ["2/3", 1]):
        for digest in (False, True):
            yield f"a row {row}, {digest}", with_value("policy", f"{at}.rows.0", row, digest=digest)
    for key in ("inputs", "outputs"):
        for labels in ([["f"]], [["f"], ["f"]], [["m"], ["f"]], [["f"], ["m"], ["x"]], [["f", "m"]], [], None):
            yield f"{key} {labels}", with_value("policy", f"{at}.{key}", labels, digest=True)
    for path in ("subject.privacy.group.exp_epsilon", "subject.privacy.group.attributes.0"):
        for value in ("1", "199/100", "3/2", "0", "inf", "4/2", None, "-2"):
            yield f"{path} is {value}", with_value("policy", path, value)
    for value in ("1/2", "2/5", "1", "-1/4", "inf", None):
        yield f"a floor of {value}", with_value("policy", "subject.declared.tau", value)
    for key, value in (("gamma", "1/2"), ("m", "1/2"), ("lipschitz", "-1"), ("epsilon", "1")):
        yield f"declared {key} {value}", with_value("policy", f"subject.declared.{key}", value)
    rows = document("policy")["subject"]["table"]["rows"]
    for kept in (
        [],
        rows[:1],
        rows[1:],
        rows[::-1],
        [*rows, rows[0]],
        [*rows, rows[0] | {"context": 5}],
        [row | {"mass": "1"} for row in rows],
    ):
        for digest in (False, True):
            yield f"{len(kept)} rows of {len(rows)}, {digest}", with_value("policy", ROWS, kept, digest=digest)
    for i in range(len(rows)):
        for weights in (["1", "0"], ["1/2", "1/3"], ["-1", "2"], ["0", "0"]):
            yield f"policy row {i} is {weights}", with_value("policy", f"{ROWS}.{i}.weights", weights, digest=True)
    for i, claim in enumerate(document("policy")["claims"]):
        if "multipliers" in (claim["evidence"] or {}):
            for given in (["-1"], ["0"], [], ["1", "-2"], ["1e9"], [1], None):
                yield f"claim {i} by {given}", with_value("policy", f"claims.{i}.evidence.multipliers", given)
        if Fraction(claim["value"]) > 1:
            less = str(Fraction(claim["value"]) - Fraction(1, 10**30))
            yield f"claim {i} a little less", with_value("policy", f"claims.{i}.value", less)


def worst_cases() -> Iterator[Forged]:
    """Claims about every utility of a class whose multipliers prove nothing."""
    value: Any
    last = len(document("class")["claims"]) - 1
    for value in ("1", "11/10", "3/2", "2"):
        for multiplier in ("0", "1", "-1", "1/1000", "10000"):
            evidence = entries(*[(x, a, 1 - a, [[0, multiplier]]) for x in (0, 1) for a in (0, 1)])
            forged = edited(document("class"), f"claims.{last}.evidence", evidence)
            yield f"value {value} by {multiplier}", json.dumps(edited(forged, f"claims.{last}.value", value)).encode()
    for key, value in (
        ("gamma", "0"),
        ("gamma", "1/2"),
        ("tau", "-1"),
        ("quantity", "global"),
        ("quantity", "both"),
        ("m", "2"),
        ("blind", 1),
    ):
        forged = edited(document("class"), f"subject.class.{key}", value)
        yield f"class with {key} {value}", json.dumps(edited(forged, f"claims.{last}.value", "2")).encode()


def _of_population(scale: Fraction) -> Iterator[tuple[str, Any]]:
    """Keys of an interval with values that say too much, or that no reading allows."""
    yield "confidence", ["99/100", "1", "0", "95/100", "19/20 "]
    yield "ends", ["each", "upper", None]
    yield "independent", [True, "false"]
    yield "region", ["product", "pairs", "Box"]
    yield "limits", [["0", "1/2"], ["0", "2"], []]
    yield "pair", [None, [0, 0, 0], [0, 5, 6], [9, 0, 1], [0, 1], [-1, 0, 1]]
    yield (
        "levels",
        [{"upper": "1/2", "lower": "1/2"}, {"upper": "0", "lower": "0"}, {"upper": str(scale), "lower": "1/80"}, {"upper": "1/80"}],
    )
    yield "units", [[], None]


def intervals() -> Iterator[Forged]:
    """Intervals that are too narrow, whose evidence proves less, or something else, and claims that say more of them."""
    true = document("sample")
    for quantity in ("local", "global"):
        own = true["intervals"][quantity]
        for key, values in _of_population(Fraction(1, 81)):
            for value in values:
                if own.get(key, ()) != value and not (key == "pair" and value is None and own["ratio"][0] == "1"):
                    yield f"{quantity}.{key} is {value}", with_value("sample", f"intervals.{quantity}.{key}", value)
        for side, i, end in product(("upper", "lower"), range(len(own["upper"])), (0, 1)):
            stated = Fraction(own[side][i][end])
            inward = stated + (1 - 2 * end) * Fraction(1, 100)
            for value in (str(inward), str(-1 - stated), "2", "inf"):
                yield f"{quantity}.{side}[{i}][{end}] is {value}", with_value("sample", f"intervals.{quantity}.{side}.{i}.{end}", value)
            yield f"{quantity}.{side} lacks {i}", with_value("sample", f"intervals.{quantity}.{side}", own[side][:i] + own[side][i + 1 :])
        low, high = (Fraction(end) for end in own["ratio"])
        for ends in ([str(low + 1), str(high)], [str(low), str((low + high) / 2)], ["1/2", str(high)], ["inf", "inf"], [str(low)]):
            yield f"{quantity}.ratio is {ends}", with_value("sample", f"intervals.{quantity}.ratio", ends)
    for i, claim in enumerate(true["claims"]):
        if claim["by"] == "binomial":
            value = Fraction(claim["value"])
            more = "1/2" if claim["relation"] == "<=" else str(value + 1)
            others = {"value": [more, "inf" if claim["relation"] == ">=" else "1"], "by": ["Binomial", "pair-exact", "hoeffding-kl"]}
            others |= {
                "scope": ["this law", "population at confidence 99/100", f"{claim['scope']} ", "population, one-sided at confidence 19/20"]
            }
            others |= {"relation": ["=", "≤"], "evidence": [{}, {"interval": "locally"}, {"interval": None}, {"table": "0" * 64}]}
            others |= {"assumptions": [[], claim["assumptions"][1:], [*claim["assumptions"], "all is well"], claim["assumptions"] * 2]}
            for key, values in others.items():
                for value in values:
                    if claim[key] != value:
                        yield f"claim {i}: {key} is {value}", with_value("sample", f"claims.{i}.{key}", value)


FAMILIES: tuple[Callable[[], Iterator[Forged]], ...] = (
    *(numbers, keys, texts, tables, figures, claims, policies, worst_cases, intervals),
    *(*OF_SAMPLES, paired, *OF_STATEMENTS),
)


def forged() -> Iterator[Forged]:
    """Every forged certificate, with what was done to it."""
    for family in FAMILIES:
        for name, raw in family():
            yield f"{family.__name__}: {name}", raw
