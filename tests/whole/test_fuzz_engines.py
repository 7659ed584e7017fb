"""Damaged and odd small files of every format through every reader: counts, or one sentence; and the readers of text agree.

``FAIRAUDIT_FUZZ=200000 pytest tests/whole/test_fuzz_engines.py`` tries that many of each kind; ``FAIRAUDIT_FULL=1`` a million in all.
"""

from __future__ import annotations

import os
import random
import sqlite3
import tempfile
from collections import Counter
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest
import tiers
from damage import PIECES, TABLES, damaged, filled
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from fairaudit import InputError, Law
from fairaudit.tables.csv import read_csv
from fairaudit.tables.engines.logs import read_log
from fairaudit.tables.number_form import guessed

EXAMPLES = int(os.environ.get("FAIRAUDIT_FUZZ", "200000" if tiers.FULL else "60"))
fuzzed = settings(
    max_examples=EXAMPLES,
    derandomize="FAIRAUDIT_FUZZ" not in os.environ and not tiers.FULL,
    database=None,
    deadline=None,
    suppress_health_check=[HealthCheck.too_slow, HealthCheck.data_too_large, HealthCheck.large_base_example],
)


@pytest.fixture(scope="module")
def folder() -> Iterator[Path]:
    with tempfile.TemporaryDirectory(prefix="fairaudit-fuzz-") as name:
        yield Path(name)


def outcome(work: Callable[[], Any]) -> Any:
    """What work gives, or the sentence that refuses it; anything else is a fault."""
    try:
        return work()
    except InputError as error:
        assert str(error)
        return str(error)


def counted(path: Path, columns: tuple[str, ...], engine: str) -> Any:
    tally = read_log(path, columns, engine=engine, bins={"n": ["0", "1.5"]} if "n" in columns else None)
    found: Counter[tuple[Any, ...]] = Counter()
    for row, n in zip(zip(*(tally[name] for name in tally.columns), strict=True), tally.counts.tolist(), strict=True):
        found[tuple(cell or None for cell in row)] += n
    return found


@given(st.one_of(st.binary(max_size=60), st.lists(st.sampled_from(PIECES), max_size=30).map(b"".join), damaged(), filled()))
@fuzzed
def test_text(folder: Path, content: bytes) -> None:
    path = folder / "log.csv"
    path.write_bytes(content)
    for columns in (("g", "d"), ("g", "n")):
        outcomes = [outcome(lambda engine=engine, columns=columns: counted(path, columns, engine)) for engine in ("python", "duckdb")]
        if isinstance(outcomes[0], str) and isinstance(outcomes[1], str):
            continue
        assert outcomes[0] == outcomes[1]
    # The reader of whole tables takes the same files.
    whole = outcome(lambda: read_csv(path))
    rows = outcome(lambda: read_log(path, ("g", "d"), engine="python").rows)
    if not isinstance(whole, str) and {"g", "d"} <= {*whole.columns}:
        assert rows == len(whole)
    if isinstance(whole, str):
        assert isinstance(rows, str)


OBJECTS = st.lists(
    st.sampled_from(
        (
            b'{"d": "yes", "g": "f"}',
            b'{"d": "no", "g": "m", "n": 1}',
            b'{"d": "no", "g": 1.50}',
            b'{"d": "no", "g": 1e999999}',
            b'{"d": true, "g": null}',
            b'{"d": "\\ud800", "g": []}',
            b'{"d": "yes", "d": "no", "g": "f"}',
            b"[]",
            b"1",
            b"",
            b"{",
            b'{"d": "yes" "g"}',
            b'\xff{"d": 1, "g": 2}',
            b'{"d": NaN, "g": "f"}',
            b'{"g": "f"}',
            b'{"d": "' + b"x" * 5000 + b'", "g": "f"}',
        )
    ),
    max_size=6,
)


@given(OBJECTS, st.sampled_from((b"\n", b"\r\n", b"", b"\n\n", b" ", b"\x00")), st.sampled_from(("log.jsonl", "log.ndjson", "log.json")))
@fuzzed
def test_json_lines(folder: Path, lines: list[bytes], end: bytes, name: str) -> None:
    path = folder / name
    path.write_bytes(end.join(lines))
    outcome(lambda: Law.from_log(read_log(path, ("d", "g")), decision="d", group="g", missing="group"))


@pytest.fixture(scope="module")
def good(folder: Path) -> dict[str, bytes]:
    import duckdb

    path = folder / "good"
    rows = "select * from (values ('yes', 'f', 1.5), ('no', 'm', 2), (null, 'f', 3)) t(d, g, n)"
    duckdb.sql(f"copy ({rows}) to '{path}.parquet'")
    with sqlite3.connect(f"{path}.db") as database:
        database.execute("create table t (d, g, n)")
        database.executemany("insert into t values (?, ?, ?)", [("yes", "f", 1.5), ("no", "m", 2), (None, b"\xff", "x")])
    database.close()
    return {name: path.with_suffix(f".{name}").read_bytes() for name in ("parquet", "db")}


@given(st.data(), st.sampled_from(("parquet", "db")))
@fuzzed
def test_damaged_binaries(folder: Path, good: dict[str, bytes], data: st.DataObject, name: str) -> None:
    content = bytearray(good[name])
    for _ in range(data.draw(st.integers(0, 4))):
        at = data.draw(st.integers(0, max(0, len(content) - 1)))
        piece = data.draw(st.binary(max_size=4))
        content[at : at + data.draw(st.integers(0, 8))] = piece
    path = folder / f"bad.{name}"
    path.write_bytes(bytes(content))
    source, options = (f"sqlite:{path}", {"table": "t"}) if name == "db" else (path, {})
    outcome(lambda: Law.from_log(read_log(source, ("d", "g"), **options), decision="d", group="g", missing="drop"))
    outcome(lambda: read_log(source, ("n", "g"), bins={"n": [2]}, **options))


@given(st.lists(st.text("0123456789,.-+e ", max_size=6), min_size=1, max_size=5))
@fuzzed
def test_forms_of_numbers_that_are_guessed(cells: list[str]) -> None:
    found = outcome(lambda: guessed(cells))
    assert found is None or isinstance(found, str) or all("," not in found[1][old] or "," in old for old in cells)


def test_many_small_texts_through_the_readers_of_text(folder: Path) -> None:
    """Three thousand damaged texts, or a million with ``FAIRAUDIT_FULL=1``; each is read whole and row by row."""
    pick = random.Random(20260101)
    path = folder / "many.csv"
    accepted = 0
    for _ in range(1_000_000 if tiers.FULL else 3_000):
        content = pick.choice(TABLES)
        for _ in range(pick.randrange(5)):
            start = pick.randrange(len(content) + 1)
            content = content[:start] + pick.choice((*PIECES, b"")) + content[start + pick.choice((0, 0, 1, 3, 9)) :]
        path.write_bytes(content)
        whole = outcome(lambda: read_csv(path))
        rows = outcome(lambda: read_log(path, ("g", "d"), engine="python").rows)
        if isinstance(whole, str):
            assert isinstance(rows, str)
        elif {"g", "d"} <= {*whole.columns}:
            assert rows == len(whole)
            accepted += 1
    assert accepted > 100
