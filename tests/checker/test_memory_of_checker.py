"""The checker forms the figures of a table while it reads it: the same figures as by definition, without holding the cells."""

import copy
import json
import tracemalloc
from collections.abc import Iterable
from fractions import Fraction
from typing import Any

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from plain_certificates import canonical, checker, detached, edited, false_statements, make, raw

import fairaudit as fa

LIMITS = (("local", "ratio", "2"), ("local", "log", "1/3"), ("global", "ratio", "1"), ("global", "log", "1/2"))
SMALL = st.sampled_from([0, 0, 1, 1, 2, 3, 7])  # ties and zeros are frequent
GAINS = st.sampled_from(["0", "1", "1", "1/2", "7/3"])


def over(numbers: list[int]) -> list[str]:
    """Divide by the sum."""
    return [str(Fraction(n, sum(numbers))) for n in numbers]


@st.composite
def certificates(draw: st.DrawFn) -> dict[str, Any]:
    """Draw the true certificate, by brute force, of a table with gaps, empty contexts, zero masses and equal values."""
    n_contexts, n_groups, n = (draw(st.integers(1, k)) for k in (5, 5, 4))
    places = [(x, a) for x in range(n_contexts) for a in range(n_groups)]
    cells = sorted(draw(st.just(places) | st.sets(st.sampled_from(places), min_size=1)))
    positive = st.lists(SMALL, min_size=n, max_size=n).filter(any)
    population = draw(st.sampled_from(["counts", "fractions", "weights", "equal"]))
    numbers = {cell: draw(positive) for cell in cells}
    if draw(st.booleans()):  # proportional masses: of equal laws here, of factors below
        scales = [draw(st.integers(1, 3)) for _ in range(n_contexts)]
        numbers = {(x, a): [scales[x] * k for k in numbers[cells[0]]] for x, a in cells}
    masses = None
    if population in ("counts", "fractions"):
        units = [1] if population == "counts" else [1, 2, 3, 7, 10**40]
        weights = {cell: [str(Fraction(k, draw(st.sampled_from(units)))) for k in row] for cell, row in numbers.items()}
    else:
        weights = {cell: over(row) for cell, row in numbers.items()}
    if population == "weights":
        of_context = [draw(SMALL) for _ in range(n_contexts)]
        of_group = [draw(SMALL) for _ in range(n_groups)]
        factors = draw(st.booleans())
        shares = [of_context[x] * of_group[a] if factors else draw(SMALL) for x, a in cells]
        shares = shares if any(shares) else [1, *shares[1:]]
        masses = dict(zip(cells, over(shares), strict=True))
    entries = st.lists(GAINS, min_size=n, max_size=n)
    utility: Any = draw(entries)
    if draw(st.booleans()):
        of_contexts = [draw(entries) for _ in range(n_contexts)]
        utility = {(x, a): draw(st.just(of_contexts[x]) | entries) for x, a in cells}
        if draw(st.booleans()):
            utility = {c: [g if Fraction(w) else None for g, w in zip(utility[c], weights[c], strict=True)] for c in cells}
    population = "counts" if population == "fractions" else population
    return make(weights, utility, population=population, masses=masses, shape=(n_contexts, n_groups), limits=LIMITS)


def paths(value: Any, path: str) -> Iterable[tuple[str, Any]]:
    """List what is in a document, with its place."""
    yield path, value
    if isinstance(value, dict | list):
        for key, item in value.items() if isinstance(value, dict) else enumerate(value):
            yield from paths(item, f"{path}.{key}")


def judged(certificate: dict[str, Any], lines: list[bytes] | None = None) -> str:
    try:
        return "true" if checker.check(raw(certificate), lines).ok else "false"
    except checker.FormatError:
        return "malformed"


@given(certificate=certificates(), data=st.data())
@settings(max_examples=200, deadline=None, suppress_health_check=list(HealthCheck))
def test_figures_are_those_of_the_definitions(certificate: dict[str, Any], data: st.DataObject) -> None:
    assert false_statements(certificate) == []
    apart, lines = detached(copy.deepcopy(certificate))
    assert false_statements(apart, lines) == []
    # Figures, witnesses and what is left out are unique: any other value is false.
    figures = {key: certificate[key] for key in ("metrics", "not_compared")} | {"utility": certificate["subject"]["utility"]}
    there = [(path.replace(".utility", "subject.utility").lstrip("."), value) for path, value in paths(figures, "")][1:]
    path, value = data.draw(st.sampled_from([(p, v) for p, v in there if p not in ("metrics", "subject.utility")]))
    others = [v for _, v in there if v != value or type(v) is not type(value)] + ["1", "0", "inf", None, []]
    other = data.draw(st.sampled_from([v for v in others if json.dumps(v) != json.dumps(value)]))
    for document, table in ((certificate, None), (apart, lines)):
        assert judged(edited(copy.deepcopy(document), path, other), table) != "true", (path, other)


def t5_holds(certificate: dict[str, Any]) -> bool:
    """Say whether the brute force claims T5, which it does exactly if all products of the margins are right; else the claim is false."""
    assert false_statements(certificate) == []
    if any(claim["by"] == "T5" for claim in certificate["claims"]):
        return True
    local = certificate["metrics"]["local"]
    claim = {"quantity": "global_ratio", "relation": "<=", "by": "T5", "value": local["ratio"] if local else "inf"}
    claim |= {"scope": "this law", "assumptions": [], "evidence": {"table": certificate["subject"]["table"]["sha256"]}}
    certificate["claims"].append(claim)
    [fault] = false_statements(certificate)
    assert "claims" in fault and "T5" in fault
    return False


@given(certificate=certificates())
@settings(max_examples=200, deadline=None, suppress_health_check=list(HealthCheck))
def test_independence_is_that_of_the_definition(certificate: dict[str, Any]) -> None:
    t5_holds(certificate)


@pytest.mark.parametrize(
    ("weights", "masses", "independent"),
    [
        ([[1, 2], [2, 4], [3, 6]], None, True),
        ([[1, 2], [2, 4], [3, 5]], None, False),
        ([[0, 0], [1, 2], [0, 0], [2, 4]], "given", True),  # contexts without mass, the first of them before all others
        ([[0, 0], [1, 2], [2, 1]], "given", False),
        ([[1, 0, 2], [2, 0, 4]], "given", True),  # a group without mass
        ([[0, 1, 2], [0, 2, 1]], "given", False),  # likewise, and the others depend on the context
        ([[0, 1, 2], [1, 2, 4]], "given", False),  # the group has mass in one context only
        ([[1, 2, 1], [0, 0, 1]], "given", False),  # no mass where the first context has some
    ],
)
def test_independence_by_hand(weights: list[list[int]], masses: str | None, independent: bool) -> None:
    cells = {(x, a): n for x, row in enumerate(weights) for a, n in enumerate(row)}
    whole = sum(cells.values())
    if masses is None:
        certificate = make({cell: [str(n), "0"] for cell, n in cells.items()}, ["1", "0"])
    else:
        shares = {cell: str(Fraction(n, whole)) for cell, n in cells.items()}
        certificate = make({cell: ["1/2", "1/2"] for cell in cells}, ["1", "0"], population="weights", masses=shares)
    assert t5_holds(certificate) is independent


@given(st.lists(st.lists(st.fractions(-3, 3, max_denominator=50), min_size=2, max_size=2), min_size=1, max_size=40))
def test_running_sums(vectors: list[list[Fraction]]) -> None:
    total = checker.rationals.RunningTotal()
    for p, q in vectors:
        total.add([p.numerator * q.denominator, q.numerator * p.denominator], p.denominator * q.denominator)
        assert len(total.parts) <= len(vectors).bit_length()
    for _ in range(2):  # asking changes nothing
        numerators, denominator = total.value()
        assert [Fraction(n, denominator) for n in numerators] == [sum(column) for column in zip(*vectors, strict=True)]


# Memory

KEPT = 300  # a cell that is kept takes more than that many bytes


def audited(kind: str, n_contexts: int, n_groups: int) -> tuple[bytes, fa.Result]:
    """Certify a table of three decisions; its text stands apart."""
    counts = np.random.default_rng(1).integers(1, 90, (n_contexts, n_groups, 3))
    law = fa.Law.from_array(counts, kind="counts")
    if kind in ("weights", "equal"):
        array = [[[Fraction(int(n), int(row.sum())) for n in row] for row in rows] for rows in counts]
        law = fa.Law.from_array(array, population=counts.sum(axis=2).tolist() if kind == "weights" else None)
    utility: Any = {"0": 1, "1": "1/2"}
    if kind == "own utilities":
        utility = fa.Utility.from_function(lambda u, x, a: (int(u) + int(x[0]) + int(a[0])) % 5, law)
    result = fa.certify(law, utility, confidence=None, embed_table=False)
    return result.certificate.text.encode(), result


def peak(certificate: bytes, lines: list[bytes]) -> tuple[int, bool]:
    """Check a certificate; tell how many bytes that took at its worst, and whether it is true."""
    checker.check(certificate, lines)  # so that what is remembered for good is there already
    tracemalloc.start()
    try:
        report = checker.check(certificate, lines)
        return tracemalloc.get_traced_memory()[1], report.ok
    finally:
        tracemalloc.stop()


@pytest.mark.parametrize("kind", ["counts", "weights", "equal", "own utilities"])
def test_cells_are_not_held(kind: str) -> None:
    """Of two tables with the same contexts, the one with ten times the cells takes little more."""
    peaks = []
    for n_groups in (3, 30):
        certificate, result = audited(kind, 300, n_groups)
        assert result.certificate.table is not None
        found, true = peak(certificate, [*result.certificate.table.lines()])
        assert true
        peaks.append(found)
    assert peaks[1] - peaks[0] < 300 * 27 * KEPT / 8, peaks


def test_cells_are_not_held_for_intervals() -> None:
    """The ends of those that decide are listed; those of the others are found while they pass by. What is remembered is as much."""
    peaks = []
    for n_groups in (40, 90):
        counts = np.random.default_rng(1).integers(1, 90, (150, n_groups, 2))
        document = json.loads(fa.certify(fa.Law.from_array(counts, kind="counts"), {"0": 1}).certificate.text)
        assert isinstance(document["intervals"]["local"]["upper"], dict)
        certificate, lines = detached(document)
        found, true = peak(raw(certificate), lines)
        assert true
        peaks.append(found)
    assert peaks[1] - peaks[0] < 150 * 50 * KEPT / 8, peaks


def test_pairs_that_are_left_out_are_not_held() -> None:
    """A short table can leave out many pairs of contexts and groups."""
    n = 1500
    certificate, _ = detached(make({(0, 0): ["1", "1"], (1, 1): ["1", "1"]}, ["1", "0"]))
    columns = {"decision": "D", "group": ["G"], "context": ["C"]}
    header = {"format": "fairaudit-table/1", "kind": "counts", "columns": columns, "population": "counts", "decisions": ["u0", "u1"]}
    labels = {"groups": [[f"a{i}"] for i in range(n)], "contexts": [[f"x{i}"] for i in range(n)], "utility": ["1", "0"]}
    rows = [{"context": i, "group": a, "weights": ["1", "2"]} for i in range(n) for a in sorted({i, (i + 1) % n})]
    found, true = peak(raw(certificate), [canonical(header | labels), *map(canonical, rows)])
    assert not true and found < n * n * 4
