"""The table of benchmarks on the page about costs is that of the last runs in their history, and has a line for each of them."""

from __future__ import annotations

import importlib
from pathlib import Path
from typing import Any

import pytest

BENCHMARKS = Path(__file__).resolve().parents[1] / "benchmarks"


@pytest.fixture
def table(monkeypatch: pytest.MonkeyPatch) -> Any:
    monkeypatch.syspath_prepend(str(BENCHMARKS))
    return importlib.import_module("table")


def test_the_page_shows_the_last_run_and_every_benchmark(table: Any) -> None:
    page = table.PAGE.read_text("utf-8")
    entries = table.recorded()
    assert table.written(page, table.rendered(entries)) == page, "python tests/benchmarks/table.py --size full --record"
    assert set(entries[-1]["rows"]) <= set(table.ROWS)
    section = page[page.index(table.BEGIN) : page.index(table.END)]
    lines = [line.split(" | ") for line in section.splitlines() if line.startswith("| ")][2:]
    for name, row, line in zip(table.ROWS, table.ROWS.values(), lines, strict=True):
        assert line[0] == "| " + row.what.format(f"{row.sizes[1]:,}")
        assert line[1] == row.beside
        *before, found = [entry["rows"][name] for entry in entries if entry["rows"].get(name)]
        assert line[3] == table.ratio(before[-1] if before else None)
        assert line[2] in (f"{found['ratio']:.2g}", f"1/{1 / found['ratio']:,.0f}")
        assert found["ratio"] == pytest.approx(found["seconds"] / found["beside"], rel=0.05)


def test_rows_of_one_commit_are_one_run(table: Any) -> None:
    first = {"commit": "a", "size": "full", "date": "2026-01-01", "rows": {"help": {"ratio": 1.0}}}
    again = {**first, "date": "2026-01-02", "rows": {"example": {"ratio": 2.0}}}
    other = {**first, "commit": "b", "rows": {"help": {"ratio": 3.0}}}
    assert table.added([], first) == [first]
    assert table.added([other, first], again) == [other, {**again, "rows": first["rows"] | again["rows"]}]
    assert table.added([first], other) == [first, other]


def test_each_turn_runs_both_and_the_first_is_not_counted(table: Any, tmp_path: Path) -> None:
    ran: list[str] = []
    row = table.Row("a", "b", (1, 2), lambda _, size: (lambda: ran.append(f"a{size}"), lambda: ran.append(f"b{size}") or sum(range(10**6))))
    found = table.measured(row, tmp_path, True, 2)
    assert ran == ["a2", "b2"] * 3
    assert found["beside"] > 0
    assert table.measured(table.Row("a", "b", (1, 2), row.works, needs="no_such_library"), tmp_path, True, 2) is None
    assert [table.ratio(one) for one in ({"ratio": 2.345}, {"ratio": 0.5}, {"ratio": 0.01}, None)] == ["2.3", "0.5", "1/100", "–"]
