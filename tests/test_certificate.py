"""Certificates from end to end: what the writer writes is accepted, and whatever is changed in it is not."""

from __future__ import annotations

import hashlib
import json
import os
import pickle
import random
import re
import shutil
import signal
import subprocess
import sys
import time
import unicodedata
from collections.abc import Callable, Iterator
from decimal import Decimal, localcontext
from fractions import Fraction
from functools import cache
from itertools import combinations, islice, permutations
from math import gcd
from pathlib import Path
from typing import Any

import pytest
from hypothesis import HealthCheck, assume, given, settings
from hypothesis import strategies as st
from jsonschema import Draft202012Validator

import fairaudit as fa
from fairaudit import checker
from fairaudit.certificates.certificate import Certificate, schema
from fairaudit.cli import main as command
from fairaudit.files import write_atomically
from fairaudit.tables.examples import EXAMPLES
from fairaudit.testing import laws, utilities

SCHEMA = Draft202012Validator(schema())
FOUR = {"max_local_log": "0.3", "max_local_ratio": "4/3", "max_global_log": "0.3", "max_global_ratio": 2, "confidence": None}
VERY_EXACT = 120


# Certificates of many kinds


def table(names: str, *rows: tuple[Any, ...]) -> dict[str, list[Any]]:
    return {name: list(values) for name, values in zip(names.split(), zip(*rows, strict=True), strict=True)}


def admissions(**options: Any) -> fa.Result:
    law = fa.Law.from_counts(fa.example("ucb-admissions").table(), decision="Admit", group="Gender", context="Dept", count="Freq")
    return fa.certify(law, {"Admitted": 1}, **options)


def small_counts(**options: Any) -> fa.Result:
    rows = [("yes", "f", "A", 3), ("no", "f", "A", 1), ("yes", "m", "A", 1), ("no", "m", "A", 4)]
    rows += [("yes", "f", "B", 2), ("no", "f", "B", 5), ("yes", "m", "B", 3), ("no", "m", "B", 3)]
    law = fa.Law.from_counts(table("u a x n", *rows), decision="u", group="a", context="x", count="n")
    return fa.certify(law, {"yes": "3/2", "no": "1/4"}, **options)


def fractional_counts(**options: Any) -> fa.Result:
    array = [[["1/2", "2.5"], [0, 3]], [[1, 0], ["1/3", "1/7"]]]
    return fa.certify(fa.Law.from_array(array, kind="counts"), {"0": "1/2", "1": 3}, **options)


def many_columns(**options: Any) -> fa.Result:
    """Several columns, labels of many scripts, one label in two Unicode normal forms, and quotation marks."""
    rows = []
    for i, (sex, age, place, year) in enumerate(
        (s, a, p, y)
        for s in ("weiblich ♀", 'm"än\\nlich')
        for a in ("<30", "é", "e\u0301")
        for p in ("Zürich", "東京 😀")
        for y in ("1973", "אב")
    ):
        rows += [
            ("ja ✓", sex, age, place, year, i % 5 + 1),
            ("nein", sex, age, place, year, i % 3),
            ("\u202eweiß nicht", sex, age, place, year, 1),
        ]
    law = fa.Law.from_counts(
        table("Entscheid Geschlecht Älter Ort Jahr n", *rows),
        decision="Entscheid",
        group=["Geschlecht", "Älter"],
        context=["Ort", "Jahr"],
        count="n",
    )
    return fa.certify(law, {"ja ✓": 2, "\u202eweiß nicht": "0.5"}, **options)


def infinite(**options: Any) -> fa.Result:
    law = fa.Law.from_array([[[1, 1, 0], [0, 4, 1]], [[1, 1, 0], [0, 2, 0]]], kind="counts")
    return fa.certify(law, {"0": 1}, **options)


def never_locally(**options: Any) -> fa.Result:
    """Each context has a single group, so that L is undefined and the global figures are not."""
    rows = [("yes", "f", "A", 3), ("no", "f", "A", 1), ("yes", "m", "B", 1), ("no", "m", "B", 1), ("no", "m", "C", 1)]
    law = fa.Law.from_counts(table("u a x n", *rows), decision="u", group="a", context="x", count="n")
    return fa.certify(law, {"yes": 1}, **options)


def never_globally(**options: Any) -> fa.Result:
    array = [[["1/2", "1/2"], ["1/3", "2/3"], [0, 0]], [["1/2", "1/2"], [0, 0], [0, 0]], [[0, 0]] * 3]
    return fa.certify(fa.Law.from_array(array), {"0": 1, "1": 2}, **options)


def weighted(**options: Any) -> fa.Result:
    """Probabilities with a population; the last group has none."""
    array = [[["1/2", "1/3", "1/6"], ["1/4", "1/4", "1/2"], [0, 1, 0]], [["2/3", 0, "1/3"], ["1/5", "4/5", 0], ["1/2", "1/2", 0]]]
    law = fa.Law.from_array(array, population=[[3, 2, 0], [1, 5, 0]], decisions=["left", "right", "stay"], groups=["f", "m", "x"])
    return fa.certify(law, {"left": 1, "stay": "1/2"}, **options)


def independent(**options: Any) -> fa.Result:
    array = [[["1/2", "1/2"], ["1/4", "3/4"]], [["2/3", "1/3"], ["1/5", "4/5"]], [["1/9", "8/9"], ["1/9", "8/9"]]]
    return fa.certify(fa.Law.from_array(array, population=[[2, 6], [1, 3], [0, 0]]), {"1": 1}, **options)


def by_context(**options: Any) -> fa.Result:
    law = fa.Law.from_array([[["1/2", "1/2"], ["1/4", "3/4"]], [["2/3", "1/3"], ["1/5", "4/5"]]])
    return fa.certify(law, fa.Utility.from_function(lambda u, x, a: int(u) + int(x[0]), law), **options)


def by_group(**options: Any) -> fa.Result:
    """g depends on everything, and is open where the weight is zero."""
    rows = [
        ("yes", "f", "A", 3, "1"),
        ("no", "f", "A", 1, "1/3"),
        ("yes", "m", "A", 1, "5/4"),
        ("yes", "f", "B", 2, "1/7"),
        ("no", "m", "B", 4, "2"),
    ]
    rows += [("no", "f", "B", 5, "0"), ("yes", "m", "B", 1, "1/2")]
    data = table("u a x n g", *rows)
    law = fa.Law.from_counts(data, decision="u", group="a", context="x", count="n")
    return fa.certify(law, fa.Utility.from_table(data, utility="g", decision="u", group="a", context="x"), **options)


def huge_and_tiny(**options: Any) -> fa.Result:
    array = [[["1e300", 1, "1e-300"], [1, "1e-300", 0]], [["1e-300", "1e300", 7], ["1e300", "1e300", "1e-300"]]]
    return fa.certify(fa.Law.from_array(array, kind="counts"), {"0": "1e-300", "1": "1e300", "2": 1}, **options)


def floats(**options: Any) -> fa.Result:
    array = [[[0.1, 0.9], [0.3, 0.7]], [[1e-300, 1.0], [0.5, 0.5]]]
    return fa.certify(fa.Law.from_array(array), {"0": 0.1}, **options)


def no_context(**options: Any) -> fa.Result:
    return fa.certify(fa.Law.from_array([[3, 1], [1, 1], [0, 0]], kind="counts"), {"0": 1}, **options)


def one_decision(**options: Any) -> fa.Result:
    return fa.certify(fa.Law.from_array([[[1], [2]], [[3], [4]]], kind="counts"), {"0": 0}, **options)


def rows_dropped(**options: Any) -> fa.Result:
    data = table("u a n", ("yes", "f", 3), ("no", "f", 1), ("yes", "m", 1), ("no", "m", 1), ("no", "", 9))
    return fa.certify(fa.Law.from_counts(data, decision="u", group="a", count="n", missing="drop"), {"yes": 1}, **options)


def true_labels(**options: Any) -> fa.Result:
    """Counts with true labels: several positive decisions, groups without a positive true label here or anywhere, fractional counts."""
    rows = [("yes", "fit", "f", "A", 3), ("no", "fit", "f", "A", 1), ("yes", "not", "f", "A", 1), ("no", "not", "f", "A", 6)]
    rows += [("call", "fit", "m", "A", 1), ("no", "fit", "m", "A", 4), ("yes", "not", "m", "A", 2), ("no", "?", "m", "A", 3)]
    rows += [("yes", "fit", "f", "B", 2), ("no", "not", "f", "B", 5), ("yes", "not", "m", "B", 3), ("no", "fit", "x", "C", "5/2")]
    rows += [("no", "not", "y", "A", 2), ("yes", "not", "y", "A", 1), ("no", "not", "y", "C", 1)]
    law = fa.Law.from_counts(table("u t a x n", *rows), decision="u", group="a", context="x", count="n", truth="t")
    return fa.certify(law, {"yes": 1, "call": 1}, positive="fit", **options)


def profiles(**options: Any) -> fa.Result:
    entry = fa.example("hr-navigation")
    law = fa.Law.from_probabilities(
        entry.table(), decision=entry.decision, group=entry.group.split(","), context=entry.context, probability=entry.probability
    )
    return fa.certify(law, {entry.utility: 1}, **options)


KINDS: list[Callable[..., fa.Result]] = [
    admissions,
    small_counts,
    fractional_counts,
    many_columns,
    infinite,
    never_locally,
    never_globally,
    weighted,
    independent,
    by_context,
    by_group,
    huge_and_tiny,
    floats,
    no_context,
    one_decision,
    rows_dropped,
    true_labels,
    profiles,
]


def outcome(document: bytes, lines: list[bytes] | None = None) -> str:
    try:
        report = checker.check(document, lines)
    except checker.FormatError:
        return "malformed"
    except checker.TableNeeded:
        return "table needed"
    return "true" if report.ok else "false"


def as_bytes(document: Any) -> bytes:
    return json.dumps(document).encode()


def assert_accepted(certificate: Certificate) -> None:
    document = certificate.text.encode()
    lines = list(certificate.table.lines()) if certificate.table is not None else None
    assert [finding for finding in checker.check(document, lines).findings if not finding.true] == []
    assert [error.message for error in SCHEMA.iter_errors(json.loads(document))] == []


# What the writer writes is accepted


@pytest.mark.parametrize("embed", [True, False])
@pytest.mark.parametrize("options", [{}, FOUR], ids=["no target", "four targets"])
@pytest.mark.parametrize("kind", KINDS)
def test_written_certificates_are_accepted(
    kind: Callable[..., fa.Result], options: dict[str, Any], embed: bool, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    result = kind(**options, embed_table=embed)
    assert_accepted(result.certificate)
    assert ("salt" in result.certificate.text) is False and (result.certificate.table is None) is embed
    path = tmp_path / "c.json"
    arguments = [str(path)] + ([] if embed else ["--table", str(tmp_path / "c.table.jsonl")])
    assert sorted(result.certificate.save(path)) == sorted([path, *[tmp_path / "c.table.jsonl"] * (not embed)])
    assert checker.main(arguments) == 0
    assert checker.main([*arguments, "--require", "within"]) == (0 if result.verdict == "within" else 1)
    assert "FALSE" not in capsys.readouterr().out
    assert len(json.loads(result.certificate.text)["targets"]) == (4 if options else 0)


def test_the_kinds_are_as_different_as_they_should_be() -> None:
    documents = {kind.__name__: json.loads(kind(**FOUR).certificate.text) for kind in KINDS}
    assert documents["infinite"]["metrics"]["local"]["ratio"] == "inf" and documents["infinite"]["metrics"]["local"]["log"] == [
        "inf",
        "inf",
    ]
    assert documents["never_locally"]["metrics"]["local"] is None and documents["never_locally"]["metrics"]["global"] is not None
    assert documents["never_locally"]["subject"]["utility"]["tau"] is None
    assert documents["never_globally"]["metrics"]["global"] is None and documents["never_globally"]["metrics"]["local"] is not None
    assert {d["verdict"] for d in documents.values()} == {"within", "exceeds", "inconclusive"}
    assert [n for n, d in documents.items() if any(c["by"] == "T5" for c in d["claims"])] == [
        "independent",
        "by_context",
        "floats",
        "rows_dropped",
        "profiles",
    ]
    assert documents["weighted"]["not_compared"] == [{"groups": [["x"]], "reason": "no population"}]
    assert documents["rows_dropped"]["claims"][0]["assumptions"]
    assert documents["by_context"]["subject"]["utility"]["depends_on_group"] is False
    assert documents["by_context"]["subject"]["table"]["header"]["utility"] is None
    assert documents["by_group"]["subject"]["utility"]["depends_on_group"] is True
    assert any(None in row["utility"] for row in documents["by_group"]["subject"]["table"]["rows"])
    assert documents["no_context"]["metrics"]["local"]["witness"]["context"] == {}
    assert {r["reason"] for d in documents.values() for r in d["not_compared"]} == {
        "no decisions recorded",
        "fewer than two groups",
        "no population",
        "a group is missing in a context and no population was given",
        "no decisions with the positive true label",
        "no decisions with another true label",
    }
    populations = {(d["subject"]["kind"], d["subject"]["population"]) for d in documents.values()}
    assert populations == {("counts", "counts"), ("probabilities", "weights"), ("probabilities", "equal")}


def test_every_example_is_among_the_kinds() -> None:
    assert {entry.name for entry in EXAMPLES if entry.decision} == {"ucb-admissions", "hr-navigation"}


@given(data=st.data())
@settings(max_examples=150, deadline=None, suppress_health_check=list(HealthCheck))
def test_drawn_certificates_are_accepted(data: st.DataObject) -> None:
    independence = data.draw(st.sampled_from([False, False, True]))
    law = data.draw(laws(max_contexts=3, max_groups=4, max_decisions=4, independent=independence))
    utility = data.draw(utilities(law, group_blind=data.draw(st.booleans())))
    logs, ratios = st.sampled_from([None, 0, "1/10", "0.2", "1e-300", 700]), st.sampled_from([None, 1, "5/4", "1e300", 1.5])
    limits = {
        "max_local_log": data.draw(logs),
        "max_global_log": data.draw(logs),
        "max_local_ratio": data.draw(ratios),
        "max_global_ratio": data.draw(ratios),
    }
    try:
        result = fa.certify(law, utility, **limits, confidence=None, embed_table=data.draw(st.sampled_from([True, True, False])))
    except fa.InputError as error:
        assume("no two groups can be compared" not in str(error))
        raise
    assert_accepted(result.certificate)


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
    if not texts(target.values()) or target["quantity"] not in ("local", "global") or target["unit"] not in ("log", "ratio"):
        return False
    match = re.fullmatch(r"(0|[1-9][0-9]*)(?:/([1-9][0-9]*))?", target["limit"])
    if not match or not match[0].isascii() or (match[2] and (match[2] == "1" or gcd(int(match[1]), int(match[2])) > 1)):
        return False
    limit, metric = Fraction(target["limit"]), metrics[target["quantity"]]
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
    in another order; assumptions in another order; and targets that ask for something else and are judged rightly.
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


def changed_values(document: Any) -> Iterator[bytes]:
    """Change every leaf, list and object of a document in many ways."""
    pool, text = strings(document), json.dumps(document)
    for path, value in places(document):
        for other in other_values(value, pool):
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


LONG_TABLE = [small_counts, fractional_counts, weighted, by_group, by_context, infinite, never_locally, never_globally, true_labels]


@cache
def mutable(kind: Callable[..., fa.Result], embed: bool = True) -> tuple[Any, tuple[bytes, ...] | None]:
    certificate = kind(**FOUR, embed_table=embed).certificate
    return json.loads(certificate.text), None if certificate.table is None else tuple(certificate.table.lines())


def assert_rejected(original: Any, mutants: Iterator[bytes], lines: list[bytes] | None, tmp_path: Path) -> int:
    """Every mutant is rejected, but for those that are demonstrably true; and so says the command. Returns how many were."""
    assert outcome(as_bytes(original), lines) == "true"
    rejected: set[bytes] = set()
    true: set[bytes] = set()
    seen = 0
    beside = tmp_path / "t.jsonl"
    beside.write_bytes(b"".join(lines or []))
    for mutant in mutants:
        if mutant in rejected or mutant in true:
            continue
        found = outcome(mutant, lines)
        seen += 1
        if (found == "true" or seen % 5 == 0) and still_true(original, mutant):
            assert found == "true", mutant
            assert SCHEMA.is_valid(json.loads(mutant)), mutant
            true.add(mutant)
            continue
        assert found in ("false", "malformed") or (found == "table needed" and lines is None), mutant
        rejected.add(mutant)
        if len(rejected) % 100 == 1:
            path = tmp_path / "mutant.json"
            path.write_bytes(mutant)
            code = checker.main([str(path), *(["--table", str(beside)] if lines else [])])
            assert code == {"false": 1, "malformed": 2, "table needed": 3}[found]
    return len(rejected)


@pytest.mark.parametrize(
    ("kind", "step"),  # all changes of one certificate, and every second to fifth of some more
    [
        (small_counts, 2),
        (never_globally, 1),
        (weighted, 4),
        (by_group, 4),
        (independent, 5),
        (infinite, 5),
        (never_locally, 5),
        (true_labels, 9),
    ],
)
def test_changed_values(kind: Callable[..., fa.Result], step: int, tmp_path: Path) -> None:
    document, lines = mutable(kind)
    assert assert_rejected(document, islice(changed_values(document), 0, None, step), None, tmp_path) > 5000 // step
    assert lines is None


@pytest.mark.parametrize(("kind", "step"), [(small_counts, 4), (weighted, 2), (true_labels, 9)])
def test_changed_values_beside_a_table_in_a_file(kind: Callable[..., fa.Result], step: int, tmp_path: Path) -> None:
    document, lines = mutable(kind, embed=False)
    assert lines is not None
    assert outcome(as_bytes(document)) == "table needed"
    assert assert_rejected(document, islice(changed_values(document), 0, None, step), list(lines), tmp_path) > 5000 // step


@pytest.mark.parametrize("kind", [small_counts, weighted, never_globally])
def test_changed_text(kind: Callable[..., fa.Result], tmp_path: Path) -> None:
    document, _ = mutable(kind)
    assert assert_rejected(document, changed_text(document), None, tmp_path) > 3000


@pytest.mark.parametrize("kind", LONG_TABLE)
def test_parts_of_other_certificates(kind: Callable[..., fa.Result], tmp_path: Path) -> None:
    document, _ = mutable(kind)
    others = [mutable(other)[0] for other in [*LONG_TABLE, many_columns, huge_and_tiny] if other is not kind]
    assert assert_rejected(document, swapped_sections(document, others), None, tmp_path) > 200


@pytest.mark.parametrize("kind", [small_counts, fractional_counts, weighted, by_group, by_context, true_labels])
def test_another_table_with_its_own_digest(kind: Callable[..., fa.Result], tmp_path: Path) -> None:
    document, _ = mutable(kind)
    assert redigested(json.loads(json.dumps(document))) == as_bytes(document)
    assert assert_rejected(document, other_tables(document), None, tmp_path) > 40


def spoiled_tables(lines: list[bytes]) -> Iterator[bytes]:
    """Change the text of a table in a file."""
    whole = b"".join(lines)
    yield from (whole[:-1], whole + b"\n", b"\n" + whole, b"\xef\xbb\xbf" + whole, whole + lines[-1], b"", lines[0], whole.upper())
    yield from (
        whole.replace(b"\n", b"\r\n"),
        whole.replace(b"\n", b"\r"),
        whole.replace(b"\n", b" \n"),
        whole.replace(b",", b", "),
        whole.rstrip(),
    )
    yield from (whole.replace(b'"weights"', b'"w"'), whole.decode("ascii").encode("utf-16"), whole.replace(b"\n", b"\n\n", 1))
    for i in range(len(lines)):
        yield b"".join(lines[:i] + lines[i + 1 :])
        yield b"".join(lines[: i + 1] + lines[i:])
        yield b"".join(lines[:i] + lines[i:][::-1])
        turned = dict(reversed(json.loads(lines[i]).items()))
        yield b"".join([*lines[:i], json.dumps(turned, separators=(",", ":")).encode() + b"\n", *lines[i + 1 :]])
    for i, byte in enumerate(whole):
        yield whole[:i] + whole[i + 1 :]
        yield whole[:i] + bytes([byte ^ 1]) + whole[i + 1 :]
    for match in re.finditer(rb"[A-Za-z]", whole):
        yield whole[: match.start()] + b"\\u%04x" % ord(match[0]) + whole[match.end() :]


@pytest.mark.parametrize("kind", [small_counts, weighted, by_group, many_columns, true_labels])
def test_spoiled_tables(kind: Callable[..., fa.Result], tmp_path: Path) -> None:
    document, lines = mutable(kind, embed=False)
    assert lines is not None
    raw, whole = as_bytes(document), b"".join(lines)
    sha = document["subject"]["table"]["sha256"].encode()
    path, beside = tmp_path / "c.json", tmp_path / "t.jsonl"
    path.write_bytes(raw)
    beside.write_bytes(whole)
    assert checker.main([str(path), "--table", str(beside)]) == 0
    distinct = set(islice(spoiled_tables(list(lines)), 2500)) - {whole}
    assert len(distinct) > 700
    for i, spoiled in enumerate(sorted(distinct)):
        split = spoiled.splitlines(keepends=True) if b"\r" not in spoiled else [line + b"\n" for line in spoiled.split(b"\n")]
        assert outcome(raw, split) in ("malformed", "false"), spoiled
        if i % 50 == 0:
            beside.write_bytes(spoiled)
            assert checker.main([str(path), "--table", str(beside)]) in (1, 2)
    # The text of the table is canonical, or it is none: its own digest does not help.
    for spoiled in (
        whole[:-1],
        whole.replace(b"\n", b"\r\n"),
        whole + b"\n",
        whole.replace(b",", b", ", 1),
        whole.replace(b'"c', b'"\\u0063', 1),
    ):
        assert spoiled != whole
        path.write_bytes(raw.replace(sha, hashlib.sha256(spoiled).hexdigest().encode()))
        beside.write_bytes(spoiled)
        assert checker.main([str(path), "--table", str(beside)]) == 2


def test_table_of_another_certificate(tmp_path: Path) -> None:
    for one, other in permutations(LONG_TABLE, 2):
        document, lines = mutable(one, embed=False)
        embedded, _ = mutable(one)
        wrong = mutable(other, embed=False)[1]
        assert lines is not None and wrong is not None
        assert outcome(as_bytes(document), list(lines)) == "true"
        assert outcome(as_bytes(document), list(wrong)) == "false"
        assert outcome(as_bytes(embedded), list(wrong)) == "false"
        assert outcome(as_bytes(embedded), list(lines)) == "false"  # the same table with salt is another text


def test_random_changes(tmp_path: Path) -> None:
    """Several changes at once, at random."""
    pick = random.Random(20)
    for kind in (small_counts, weighted, by_group):
        document, _ = mutable(kind)
        pool, mutants = strings(document), []
        for _ in range(600):
            changed = json.loads(json.dumps(document))
            for _ in range(pick.choice([2, 2, 3])):
                path, value = pick.choice([(path, value) for path, value in places(changed) if path])
                changed = put(json.dumps(changed), path, pick.choice(other_values(value, pool)))
            mutants.append(as_bytes(changed))
        assert_rejected(document, iter(mutants), None, tmp_path)


def test_unicode_normal_forms_are_different_labels() -> None:
    document, _ = mutable(many_columns)
    assert document["subject"]["table"]["header"]["groups"][1:3] == [["weiblich ♀", "é"], ["weiblich ♀", "e\u0301"]]
    text, changed = json.dumps(document), 0
    for path, value in places(document):
        for form in ("NFC", "NFD", "NFKC", "NFKD"):
            if isinstance(value, str) and unicodedata.normalize(form, value) != value:
                assert outcome(as_bytes(put(text, path, unicodedata.normalize(form, value)))) in ("false", "malformed")
                changed += 1
    assert changed > 20


def test_the_judge_of_mutants_is_awake() -> None:
    """`still_true` knows true from false by itself."""
    document, _ = mutable(small_counts)
    claims, targets = document["claims"], document["targets"]
    assert still_true(document, as_bytes(document))
    assert still_true(document, json.dumps(document, indent=3).encode())
    assert still_true(document, as_bytes(document | {"claims": claims[:0:-1]}))
    assert still_true(document, as_bytes(document | {"targets": [], "verdict": "none"}))
    assert not still_true(document, as_bytes(document | {"targets": []}))
    assert not still_true(document, as_bytes(document | {"claims": [*claims, claims[0]]}))
    assert not still_true(document, as_bytes(document | {"targets": [targets[0] | {"limit": "1000"}, *targets[1:]]}))
    assert not still_true(document, as_bytes(document | {"subject": {}}))


# The schema


def test_schema_is_a_schema_of_this_format() -> None:
    Draft202012Validator.check_schema(schema())
    assert schema()["properties"]["format"] == {"const": "fairaudit-certificate/1"}
    assert schema()["$id"] == "fairaudit-certificate/1" and schema()["title"]
    objects = [value for _, value in places(schema()) if isinstance(value, dict) and value.get("type") == "object"]
    assert len(objects) > 20
    for value in objects:
        if "properties" in value:
            assert value["additionalProperties"] is False
            assert set(value.get("required", ())) <= set(value["properties"])
        elif "$ref" not in value:  # maps from column to label or amount, and versions
            refs = [{"$ref": f"#/$defs/{name}"} for name in ("label", "amount", "whole_amount")]
            assert value["additionalProperties"] in ({"type": "string"}, *refs)
    for name, value in schema()["$defs"].items():
        assert "description" in value or name in ("metrics", "population_fits_kind")


LABELLED = {"decisions", "groups", "contexts", "context", "higher", "lower", "decision"}  # "0" is a label there


@pytest.mark.parametrize("kind", [weighted, never_globally])
def test_schema_refuses_what_is_malformed(kind: Callable[..., fa.Result]) -> None:
    document, _ = mutable(kind)
    text = json.dumps(document)
    for path, value in places(document):
        if path:
            assert not SCHEMA.is_valid(put(text, path, 1.5)), path
            assert not SCHEMA.is_valid(put(text, path, {"unexpected": [None]})), path
        if isinstance(value, dict):
            labels = path[-1] in ("context", "higher", "lower") if path else False
            assert SCHEMA.is_valid(put(text, path, value | {"extra": "0"}) if path else value | {"extra": "0"}) is labels, path
            for key in value:
                smaller = {k: v for k, v in value.items() if k != key}
                assert not SCHEMA.is_valid(put(text, path, smaller) if path else smaller) or path[-1:] == ("context",), (path, key)
        if isinstance(value, str) and NUMBER.fullmatch(value) and not LABELLED & set(path):
            for wrong in (f"0{value}", f"+{value}", f"{value}/1", "0.5", "-0", "nan", "", "1/0", "1/1", "1/02"):
                assert not SCHEMA.is_valid(put(text, path, wrong)), (path, wrong)
    assert not SCHEMA.is_valid(put(text, ("format",), "fairaudit-certificate/2"))
    assert not SCHEMA.is_valid(put(text, ("subject", "table", "sha256"), "A" * 64))


# The checker alone


def alone(directory: Path, *arguments: str, **options: Any) -> subprocess.CompletedProcess[bytes]:
    return subprocess.run([sys.executable, "-I", "-S", "checker", *arguments], cwd=directory, capture_output=True, check=False, **options)


def test_lone_checker(tmp_path: Path) -> None:
    here, files = tmp_path / "empty", tmp_path / "files"
    here.mkdir()
    files.mkdir()
    shutil.copytree(Path(checker.__file__).parent, here / "checker", ignore=shutil.ignore_patterns("__pycache__"))
    small_counts(**FOUR).certificate.save(files / "exceeds.json")
    small_counts(max_local_ratio=100, confidence=None).certificate.save(files / "within.json")
    weighted(embed_table=False).certificate.save(files / "apart.json")
    false = (files / "within.json").read_bytes().replace(b'"verdict": "within"', b'"verdict": "exceeds"')
    (files / "false.json").write_bytes(false)
    (files / "broken.json").write_bytes(false[:-3])
    assert alone(here, "../files/exceeds.json").returncode == 0
    assert alone(here, "../files/exceeds.json", "--require", "within").returncode == 1
    assert alone(here, "../files/within.json", "--require", "within").returncode == 0
    assert alone(here, "../files/false.json").returncode == 1
    assert alone(here, "../files/broken.json").returncode == 2
    assert alone(here, "../files/nowhere.json").returncode == 2
    assert alone(here).returncode == 2
    assert alone(here, "../files/apart.json").returncode == 3
    apart = alone(here, "../files/apart.json", "--table", "../files/apart.table.jsonl")
    assert apart.returncode == 0 and not apart.stderr
    assert apart.stdout.count(b"\n") > 20 and all(line.startswith(b"true ") for line in apart.stdout.splitlines()[:-1])
    assert sorted(path.name for path in here.iterdir()) == ["checker"]


def test_command_verifies(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    certificate, apart = tmp_path / "ucb.json", tmp_path / "apart.json"
    assert (
        command(["certify", "--example", "ucb-admissions", "--max-local-ratio", "4/3", "--confidence", "none", "-o", str(certificate)]) == 0
    )
    assert command(["verify", str(certificate)]) == 0
    assert command(["verify", str(certificate), "--require", "within"]) == 0
    assert (
        command(["certify", "--example", "ucb-admissions", "--max-local-ratio", "5/4", "--confidence", "none", "-o", str(certificate)]) == 1
    )
    assert command(["verify", str(certificate)]) == 0
    assert command(["verify", str(certificate), "--require", "within"]) == 1
    assert command(["certify", "--example", "hr-navigation", "--no-table", "-o", str(apart)]) == 0
    capsys.readouterr()
    assert command(["verify", str(apart)]) == 3
    assert "table" in capsys.readouterr().err
    assert command(["verify", str(apart), "--table", str(tmp_path / "apart.table.jsonl")]) == 0
    assert command(["verify", str(apart), "--table", str(certificate)]) == 2
    assert command(["verify", str(tmp_path)]) == 2
    certificate.write_bytes(certificate.read_bytes().replace(b"24475/18432", b"24475/18433"))
    capsys.readouterr()
    assert command(["verify", str(certificate)]) == 1
    assert "FALSE  metrics.local.ratio is 24475/18433 (the table gives 24475/18432)" in capsys.readouterr().out


# Files appear whole or not at all

SAVER = """
import pickle, sys
from pathlib import Path
certificates = pickle.loads(Path(sys.argv[1]).read_bytes())
print("ready", flush=True)
while True:
    for certificate in certificates:
        certificate.save(sys.argv[2])
"""


def killed_while_saving(pickled: Path, target: Path, delay: float) -> None:
    command_line = [sys.executable, "-c", SAVER, str(pickled), str(target)]
    with subprocess.Popen(command_line, stdout=subprocess.PIPE, stderr=subprocess.PIPE) as process:
        assert process.stdout is not None and process.stderr is not None
        ready = process.stdout.readline()
        time.sleep(delay)
        process.send_signal(signal.SIGKILL)
        assert process.wait() == -signal.SIGKILL, process.stderr.read()
        assert ready == b"ready\n"


def big(seed: int, embed: bool) -> Certificate:
    pick = random.Random(seed)
    array = [[[pick.randint(1, 10**6), pick.randint(1, 10**6)] for _ in range(2)] for _ in range(2000)]
    return fa.certify(fa.Law.from_array(array, kind="counts"), {"0": 1}, confidence=None, embed_table=embed).certificate


def test_kill_while_saving(tmp_path: Path) -> None:
    """Killed at any moment, a save leaves the old file or the new one, and never a part of one."""
    pick = random.Random(1)
    certificates = [big(1, True), big(2, True)]
    for certificate in certificates:
        assert_accepted(certificate)
    whole = {certificate.text.encode() for certificate in certificates}
    (tmp_path / "pickled").write_bytes(pickle.dumps(certificates))
    target = tmp_path / "c.json"
    kills = 0
    while kills < 10 or not target.exists():
        assert kills < 100
        killed_while_saving(tmp_path / "pickled", target, pick.uniform(0, 0.15 + 0.01 * kills))
        assert not target.exists() or target.read_bytes() in whole
        kills += 1
    assert checker.main([str(target)]) == 0


def test_kill_while_saving_a_table(tmp_path: Path) -> None:
    pick = random.Random(2)
    certificate = big(3, False)
    assert certificate.table is not None
    whole, text = b"".join(certificate.table.lines()), certificate.text.encode()
    assert_accepted(certificate)
    (tmp_path / "pickled").write_bytes(pickle.dumps([certificate]))
    kills, complete, partial = 0, 0, 0
    while kills < 10 or not (complete and partial):  # until some kills have hit a save in its middle, and some not
        assert kills < 100
        directory = tmp_path / str(kills)
        directory.mkdir()
        killed_while_saving(tmp_path / "pickled", directory / "c.json", pick.uniform(0, 0.02 + 0.01 * kills))
        kills += 1
        beside = directory / "c.table.jsonl"
        assert not beside.exists() or beside.read_bytes() == whole
        if (directory / "c.json").exists():  # then its table is there too
            assert (directory / "c.json").read_bytes() == text and beside.exists()
            complete += 1
        partial += any(path.name.endswith(".part") for path in directory.iterdir())


def test_failure_while_saving(tmp_path: Path) -> None:
    def lines() -> Iterator[bytes]:
        yield b"x" * 10**6
        raise RuntimeError("in the middle")

    target = tmp_path / "c.json"
    target.write_bytes(b"before")
    with pytest.raises(RuntimeError, match="in the middle"):
        write_atomically(target, lines())
    assert [path.name for path in tmp_path.iterdir()] == ["c.json"] and target.read_bytes() == b"before"
    with pytest.raises(fa.InputError, match="directory"):
        small_counts().certificate.save(tmp_path)
    with pytest.raises(fa.InputError, match="cannot be written"):
        small_counts().certificate.save(tmp_path / "nowhere" / "c.json")


def test_saved_files_have_ordinary_permissions(tmp_path: Path) -> None:
    (tmp_path / "plain").write_bytes(b"")
    for path in small_counts(embed_table=False).certificate.save(tmp_path / "c.json"):
        assert path.stat().st_mode == (tmp_path / "plain").stat().st_mode
        assert os.access(path, os.R_OK)
