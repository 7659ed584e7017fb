"""Filters as they are read, applied factor by factor, and what they can release."""

import copy
from fractions import Fraction
from itertools import product
from typing import Any

import pytest
import tiers
from plain_certificates import canonical, checker, false_statements, raw
from policy_certificates import SEEDS, Policy, by_hand, digested, randomized, write


@pytest.fixture
def good() -> dict[str, Any]:
    return by_hand()


def test_other_rows_of_the_filter(good: dict[str, Any]) -> None:
    factor = good["subject"]["table"]["header"]["filters"]["group"][0]
    for rows in ([["3/4", "1/4"], ["1/3", "2/3"]], [["1", "0"], ["0", "1"]], [["1/3", "2/3"], ["2/3", "1/3"]]):
        factor["rows"] = rows
        assert false_statements(digested(good)) != []
    factor["rows"] = [["2/3", "1/3"], ["1/3", "2/3"]]
    assert false_statements(digested(good)) == []


def test_missing_rows() -> None:
    accepted = 0
    for seed in range(80):
        p = Policy(tiers.fresh(seed))
        certificate = write(p)
        table = certificate["subject"]["table"]
        for at in range(len(p.T)):
            fewer = copy.deepcopy(certificate)
            row = fewer["subject"]["table"]["rows"].pop(at)
            fewer["subject"]["table"]["cells"] -= p.n
            if (row["context"], row["group"]) in p.must:
                with pytest.raises(checker.FormatError, match="lacks a row"):
                    checker.check(raw(digested(fewer)))
            else:
                lines = [line for line in false_statements(digested(fewer)) if not line.startswith("metrics.unfiltered")]
                assert lines == [], seed
                accepted += 1
        assert table["cells"] == len(p.T) * p.n
    assert accepted > 50


def test_true_cells_are_listed_in_order() -> None:
    p = next(p for p in map(Policy, SEEDS) if p.mass is not None and not isinstance(p.given, list))
    certificate = write(p)
    rows = certificate["subject"]["table"]["rows"]
    first, count = len(p.T), len(rows)
    assert false_statements(certificate) == []
    spoiled = [
        rows[:-1],
        rows[:first],
        [*rows, rows[-1]],
        [*rows[:first], *rows[first:][::-1]],
        [*rows[first:], *rows[:first]],
        [*rows[: count - 1], rows[-1] | {"mass": "1/977"}],
        [*rows[: count - 1], rows[-1] | {"utility": [None] * p.n}],
        [*rows[: count - 1], {key: item for key, item in rows[-1].items() if key != "utility"}],
        [*rows[: count - 1], {key: item for key, item in rows[-1].items() if key != "mass"}],
        [*rows[: count - 1], rows[-1] | {"true_group": len(p.true_a)}],
    ]
    for other in spoiled:
        certificate["subject"]["table"]["rows"] = other
        with pytest.raises(checker.FormatError):
            checker.check(raw(digested(certificate)))


def test_factors_are_applied_one_by_one() -> None:
    """Eight factors of three values, 6561 groups, whose product would have 43 million entries."""
    factors = [([[f"{i}"] for i in range(3)], [[f"{i}"] for i in range(3)], randomized(3, Fraction(1, 2))) for _ in range(8)]
    groups = [list(labels) for labels in product("012", repeat=8)]
    header = {
        "format": "fairaudit-table/1",
        "kind": "policy",
        "columns": {"decision": "D", "group": [f"G{i}" for i in range(8)], "context": []},
        "population": "equal",
        "decisions": ["yes", "no"],
        "groups": groups,
        "contexts": [[]],
        "utility": ["1", "0"],
        "filters": {
            "group": [{"inputs": i, "outputs": o, "rows": [[str(p) for p in row] for row in m]} for i, o, m in factors],
            "context": None,
        },
    }
    rows = [
        {"context": 0, "group": j, "weights": [str(Fraction(g.count("0") + 1, 9)), str(Fraction(8 - g.count("0"), 9))]}
        for j, g in enumerate(groups)
    ]
    lines = [canonical(header), *map(canonical, rows)]
    table = checker.rows.read_table(checker.rows.lines_of_file(lines))
    # Released zeros: one half of those that are there, a quarter of the others.
    for cell, g in zip(table.cells, groups, strict=True):
        zeros = g.count("0")
        assert Fraction(*cell.expectation) == (1 + Fraction(zeros, 2) + Fraction(8 - zeros, 4)) / 9
    assert table.policy.group.exp_epsilon == (2**8, 1)
    differing, unit = table.policy.group.pairs
    assert len(differing) == 8 and unit == 4**8


@pytest.mark.parametrize("name", ["inputs", "outputs"])
def test_more_true_cells_than_fit(good: dict[str, Any], name: str) -> None:
    """A short header can speak of 10^40 groups, true or released; it is refused without listing them."""
    labels = {"inputs": [["0"], ["1"]], "outputs": [["0"], ["1"]]} | {name: [[f"{i}"] for i in range(100)]}
    rows = [[str(Fraction(1, len(labels["outputs"])))] * len(labels["outputs"])] * len(labels["inputs"])
    table = good["subject"]["table"]
    header = copy.deepcopy(table.pop("header"))
    del table["rows"]
    header["columns"]["group"] = [f"G{i}" for i in range(20)]
    header["groups"] = [["0"] * 20, ["1"] * 20]
    header["filters"]["group"] = [labels | {"rows": rows}] * 20
    with pytest.raises(checker.TooMuch, match=r"the law that the filters induce takes more than the (steps|memory) of a document of 1 MB"):
        checker.check(raw(good), [canonical(header)])
