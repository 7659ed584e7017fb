"""A log, the files that can hold it, and what engines count in it."""

from __future__ import annotations

import bz2
import gzip
import json
import lzma
import sqlite3
from collections import Counter
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from fairaudit import Law, certify
from fairaudit.tables.tally import Tally

COLUMNS = ("dept", "sex", "answer")
LABELS = ("answer", "sex")


def log(rows: int = 400, seed: int = 1) -> list[dict[str, Any]]:
    """A log with repeated rows; every column is text but age, which is a whole number."""
    generator = np.random.default_rng(seed)
    answers = generator.choice(["yes", "no", "maybe, later"], rows)
    return [
        {"answer": str(u), "sex": str(a), "dept": str(x), "age": int(age), "run": int(i // 7)}
        for i, (u, a, x, age) in enumerate(
            zip(
                answers,
                generator.choice(["f", "m"], rows),
                generator.choice(["x", "ü", "=z"], rows),
                generator.integers(15, 80, rows),
                strict=True,
            )
        )
    ]


def as_csv(rows: list[dict[str, Any]]) -> str:
    def cell(value: Any) -> str:
        text = str(value)
        return '"' + text.replace('"', '""') + '"' if any(c in text for c in ',"\n') else text

    return "\n".join([",".join(rows[0]), *(",".join(map(cell, row.values())) for row in rows)]) + "\n"


def counts(tally: Tally) -> Counter[tuple[Any, ...]]:
    """What a tally says, whatever the order of its rows."""
    found: Counter[tuple[Any, ...]] = Counter()
    for row, n in zip(zip(*(tally[name] for name in tally.columns), strict=True), tally.counts.tolist(), strict=True):
        found[row] += n
    return found


def certificate(tally: Any, **options: Any) -> str:
    cut = options.pop("cut", ())
    law = Law.from_log(tally, decision="answer", group="sex", context=["dept", "age"] if options.pop("age", False) else "dept", **options)
    law = replace(law, preparation=(*law.preparation, *cut))
    return certify(law, {"yes": 1, "maybe, later": "0.5"}).certificate.text


@pytest.fixture(scope="module")
def files(tmp_path_factory: pytest.TempPathFactory) -> dict[str, str]:
    """One log in all kinds of files; name to what `read_log` takes."""
    import duckdb

    folder = tmp_path_factory.mktemp("logs")
    rows = log()
    text = as_csv(rows).encode()
    (folder / "log.csv").write_bytes(text)
    (folder / "log.csv.gz").write_bytes(gzip.compress(text))
    (folder / "log.csv.bz2").write_bytes(bz2.compress(text))
    (folder / "log.csv.xz").write_bytes(lzma.compress(text))
    lines = "".join(json.dumps(row) + "\n" for row in rows)
    (folder / "log.jsonl").write_text(lines)
    (folder / "log.jsonl.gz").write_bytes(gzip.compress(lines.encode()))
    half = len(rows) // 2
    for number, part in enumerate((rows[:half], rows[half:])):
        (folder / f"part{number}.csv").write_text(as_csv(part))
    quoted = str(folder).replace("'", "''")
    types = "{'answer': 'VARCHAR', 'sex': 'VARCHAR', 'dept': 'VARCHAR', 'age': 'BIGINT', 'run': 'BIGINT'}"
    source = f"from read_csv('{quoted}/log.csv', header=true, columns={types})"
    duckdb.sql(f"copy (select * {source}) to '{quoted}/log.parquet'")
    duckdb.sql(f"copy (select * {source} limit {half}) to '{quoted}/p0.parquet'")
    duckdb.sql(f"copy (select * {source} offset {half}) to '{quoted}/p1.parquet'")
    with duckdb.connect(str(folder / "log.duckdb")) as connection:
        connection.execute(f'create table "Log of ""all""" as select * {source}')
    with sqlite3.connect(folder / "log.db") as database:
        database.execute('create table decisions ("answer" text collate nocase, sex, dept, age, run)')
        database.executemany("insert into decisions values (:answer, :sex, :dept, :age, :run)", rows)
    database.close()
    names = ("log.csv", "log.csv.gz", "log.csv.bz2", "log.csv.xz", "log.jsonl", "log.jsonl.gz", "log.parquet", "part*.csv", "p?.parquet")
    return {name: str(folder / name) for name in (*names, "log.db", "log.duckdb")}
