"""Certificates of as many kinds of table as there are, and how they are checked."""

from __future__ import annotations

import json
import random
from collections.abc import Callable
from typing import Any

from jsonschema import Draft202012Validator

import fairaudit as fa
from fairaudit import checker
from fairaudit.certificates.certificate import Certificate, schema

SCHEMA = Draft202012Validator(schema())
FOUR = {"max_local_log": "0.3", "max_local_ratio": "4/3", "max_global_log": "0.3", "max_global_ratio": 2, "confidence": None}


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


def _differences(options: dict[str, Any]) -> dict[str, Any]:
    """The same options, with limits on differences in the place of those on ratios."""
    rest = {name: value for name, value in options.items() if name not in FOUR or name == "confidence"}
    limits = {"max_difference": "1/3", "max_global_difference": 1} if len(rest) < len(options) else {}
    return {"difference": True, **limits, **rest}


def both_contrasts(**options: Any) -> fa.Result:
    """Ratios and differences beside each other."""
    limits = {"max_difference": "1/3", "max_global_difference": 1} if options.keys() & FOUR.keys() else {}
    law = fa.Law.from_array([[[3, 1, 2], [1, 1, 0], [2, 0, 5]], [[1, 4, 1], [2, 2, 2], [0, 0, 0]]], kind="counts")
    return fa.certify(law, {"0": 1, "1": "2/3"}, **options, **limits, difference=True)


def signed(**options: Any) -> fa.Result:
    """A utility below 0, of which nothing but differences is stated."""
    law = fa.Law.from_array([[[3, 1, 2], [1, 1, 0], [2, 0, 5]], [[1, 4, 1], [2, 2, 2], [0, 0, 0]]], kind="counts")
    return fa.certify(law, {"0": 1, "1": "-2/3"}, **_differences(options))


def signed_by_cell(**options: Any) -> fa.Result:
    """A utility below 0 that depends on context and group, of probabilities with a population."""
    array = [[["1/2", "1/3", "1/6"], ["1/4", "1/4", "1/2"]], [["2/3", 0, "1/3"], ["1/5", "4/5", 0]]]
    law = fa.Law.from_array(array, population=[[3, 2], [1, 5]])
    utility = fa.Utility.from_function(lambda u, x, a: f"{int(u) - 1 - int(x[0])}/{2 + int(a[0])}", law, signed=True)
    return fa.certify(law, utility, **_differences(options))


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
    both_contrasts,
    signed,
    signed_by_cell,
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


LONG_TABLE = [small_counts, fractional_counts, weighted, by_group, by_context, infinite, never_locally, never_globally, true_labels]


def fifty_by_forty() -> fa.Result:
    drawn = random.Random(11)
    rows = {"u": [], "a": [], "x": [], "n": []}  # type: dict[str, list[Any]]
    for x in range(50):
        for a in range(40):
            total = drawn.randint(50, 300)
            yes = drawn.randint(total // 4, 3 * total // 4)
            for u, n in (("yes", yes), ("no", total - yes)):
                for key, value in zip("uaxn", (u, f"group {a}", f"context {x}", n), strict=True):
                    rows[key].append(value)
    return fa.certify(fa.Law.from_counts(rows, decision="u", group="a", context="x", count="n"), {"yes": 1}, max_local_ratio=2)
