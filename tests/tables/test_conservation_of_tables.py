"""Rows read are rows counted: every library and engine counts as many rows as it was given, or says that it did not.

Six random tables, or 2,000 with ``FAIRAUDIT_FULL=1``; ``FAIRAUDIT_ROWS=500`` tries that many. Each has missing labels, and each is held
in every frame, file and database that is installed. What a log must give is counted here row by row, in Python.
"""

from __future__ import annotations

import json
import os
import random
import sqlite3
from collections import Counter
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
import tiers

import fairaudit as fa
from fairaudit.errors import RowsLost
from fairaudit.tables.engines.logs import read_log, read_parts
from fairaudit.tables.sql import RowsRead
from fairaudit.tables.tally import Tally

TABLES = int(os.environ.get("FAIRAUDIT_ROWS", "2000" if tiers.FULL else "6"))
COLUMNS = ("hired", "sex", "age")
EDGES = [20, 40]

Table = dict[str, list[Any]]


def table(pick: random.Random) -> Table:
    """A log with missing labels: few or many labels of a column, numbers in another."""
    rows = pick.choice((3, 40, 700))
    many = pick.random() < 0.2
    sexes = [f"s{i}" for i in range(600)] if many else ["f", "m", "d"][: pick.randrange(1, 4)]
    absent = {name: pick.choice((0.0, 0.1, 0.9)) for name in COLUMNS}
    values: dict[str, Callable[[], Any]] = {
        "hired": lambda: pick.choice(("yes", "no")),
        "sex": lambda: pick.choice(sexes),
        "age": lambda: pick.choice((17, 20, 39, 40, 70)) if pick.random() < 0.9 else pick.randrange(10**6),
    }
    found = {name: [None if pick.random() < absent[name] else make() for _ in range(rows)] for name, make in values.items()}
    for name in COLUMNS:  # a column without a single label has no type
        found[name][0] = found[name][0] if found[name][0] is not None else values[name]()
    return found


def arrow(held: Table, *, dictionary: bool = False) -> Any:
    import pyarrow as pa

    kinds = {"hired": pa.string(), "sex": pa.string(), "age": pa.int64()}
    made = {name: pa.array(values, kinds[name]) for name, values in held.items()}
    return pa.table({name: part.dictionary_encode() if dictionary and name != "age" else part for name, part in made.items()})


def pandas(held: Table, kinds: dict[str, Any]) -> Any:
    import pandas as pd

    return pd.DataFrame({name: pd.Series(values, dtype=kinds[name]) for name, values in held.items()})


def of_texts(kind: str) -> Callable[[Table, Path], Any]:
    return lambda held, _: pandas(held, {"hired": kind, "sex": kind, "age": "Int64"})


def of_dictionaries(held: Table, _: Path) -> Any:
    import pandas as pd
    import pyarrow as pa

    kind = pd.ArrowDtype(pa.dictionary(pa.int32(), pa.string()))
    return pandas(held, {"hired": kind, "sex": kind, "age": pd.ArrowDtype(pa.int64())})


def of_dictionaries_of_numbers(held: Table, _: Path) -> Any:
    import pandas as pd
    import pyarrow as pa

    made = {name: arrow(held).column(name).dictionary_encode() for name in COLUMNS}
    return pa.table(made).to_pandas(types_mapper=pd.ArrowDtype)


def parquet(held: Table, folder: Path, *, dictionary: bool = False) -> Path:
    import pyarrow.parquet as pq

    path = folder / "log.parquet"
    pq.write_table(arrow(held, dictionary=dictionary), path)
    return path


def read_back(backend: Any) -> Callable[[Table, Path], Any]:
    def hold(held: Table, folder: Path) -> Any:
        import pandas as pd

        of_texts("category")(held, folder).to_parquet(folder / "back.parquet")
        return pd.read_parquet(folder / "back.parquet", **({} if backend is None else {"dtype_backend": backend}))

    return hold


def polars(kind: str, *, lazy: bool = False) -> Callable[[Table, Path], Any]:
    def hold(held: Table, _: Path) -> Any:
        import polars as pl

        frame = pl.DataFrame(held, schema={"hired": pl.String, "sex": pl.String, "age": pl.Int64})
        if kind == "categorical":
            frame = frame.with_columns(pl.col("hired", "sex").cast(pl.Categorical))
        return frame.lazy() if lazy else frame

    return hold


def relation(held: Table, _: Path) -> Any:
    import duckdb

    return duckdb.from_arrow(arrow(held))


def rows_of(held: Table) -> list[tuple[Any, ...]]:
    return list(zip(*held.values(), strict=True))


def csv(engine: str, *, quoted: bool = False) -> Callable[[Table, Path], Any]:
    def hold(held: Table, folder: Path) -> Any:
        path = folder / "log.csv"
        mark = '"' if quoted else ""
        cells = [
            "" if value is None else f"{mark}{value}{mark}" if isinstance(value, str) else str(value) for value in sum(rows_of(held), ())
        ]
        lines = [",".join(cells[place : place + 3]) for place in range(0, len(cells), 3)]
        path.write_text("\n".join([",".join(COLUMNS), *lines]) + "\n")
        return path, {"engine": engine}

    return hold


def json_lines(held: Table, folder: Path) -> Any:
    path = folder / "log.jsonl"
    path.write_text("".join(json.dumps(dict(zip(COLUMNS, row, strict=True))) + "\n" for row in rows_of(held)))
    return path, {}


def json_list(held: Table, folder: Path) -> Any:
    path = folder / "log.json"
    path.write_text(json.dumps([dict(zip(COLUMNS, row, strict=True)) for row in rows_of(held)], indent=1))
    return path, {}


def sqlite(**where: str) -> Callable[[Table, Path], Any]:
    def hold(held: Table, folder: Path) -> Any:
        path = folder / "log.db"
        path.unlink(missing_ok=True)
        with sqlite3.connect(path) as database:
            database.execute("create table log (hired text, sex text, age integer)")
            database.executemany("insert into log values (?, ?, ?)", rows_of(held))
        database.close()
        return f"sqlite:{path}", where

    return hold


def duckdb_file(**where: str) -> Callable[[Table, Path], Any]:
    def hold(held: Table, folder: Path) -> Any:
        import duckdb

        path = folder / "log.duckdb"
        path.unlink(missing_ok=True)
        rows = arrow(held)
        with duckdb.connect(str(path)) as connection:
            connection.register("rows", rows)
            connection.execute("create table log as select * from rows")
        return f"duckdb:{path}", where

    return hold


HOLDERS: dict[str, Callable[[Table, Path], Any]] = {
    "pandas str": of_texts("str"),
    "pandas object": of_texts("object"),
    "pandas string": of_texts("string"),
    "pandas category": of_texts("category"),
    "pandas dictionary": of_dictionaries,
    "pandas dictionary of numbers": of_dictionaries_of_numbers,
    "pandas from Parquet": read_back(None),
    "pandas from Parquet, Arrow": read_back("pyarrow"),
    "pandas from Parquet, nullable": read_back("numpy_nullable"),
    "polars": polars("text"),
    "polars categorical": polars("categorical"),
    "polars lazy": polars("categorical", lazy=True),
    "pyarrow": lambda held, _: arrow(held),
    "pyarrow dictionary": lambda held, _: arrow(held, dictionary=True),
    "relation": relation,
    "csv": csv("python"),
    "csv in DuckDB": csv("duckdb"),
    "quoted csv in DuckDB": csv("duckdb", quoted=True),
    "json lines": json_lines,
    "json": json_list,
    "parquet": lambda held, folder: (parquet(held, folder), {}),
    "parquet dictionary": lambda held, folder: (parquet(held, folder, dictionary=True), {}),
    "sqlite": sqlite(table="log"),
    "sqlite query": sqlite(query="select * from log"),
    "duckdb": duckdb_file(table="log"),
    "duckdb query": duckdb_file(query="select * from log"),
}


def counted(held: Any, *, cut: bool) -> Tally:
    """The counts of a log, as its holder makes them."""
    source, options = held if isinstance(held, tuple) else (held, {})
    return read_log(source, COLUMNS, bins={"age": EDGES} if cut else None, **options)


def oracle(held: Table, *, cut: bool) -> Counter[tuple[str, ...]]:
    """The same, one row at a time."""

    def age(value: int | None) -> str:
        if value is None or not cut:
            return "" if value is None else str(value)
        return "under 20" if value < 20 else "20 to under 40" if value < 40 else "40 and over"

    return Counter((hired or "", sex or "", age(value)) for hired, sex, value in rows_of(held))


def texts(tally: Tally) -> Counter[tuple[str, ...]]:
    found: Counter[tuple[str, ...]] = Counter()
    for *row, number in zip(*(tally[name] for name in COLUMNS), tally.counts.tolist(), strict=True):
        found[tuple("" if value is None else str(value) for value in row)] += number
    return found


def certificate(tally: Tally) -> str:
    """The certificate, or why there is none."""
    try:
        law = fa.Law.from_log(tally, decision="hired", group="sex", context="age", missing="group")
        return fa.certify(law, {law.decisions[-1]: 1}, confidence=None).certificate.text
    except fa.InputError as error:
        return str(error)


def test_no_row_is_lost_in_any_frame_file_or_database(tmp_path: Path) -> None:
    lost = Counter[str]()
    for number in range(TABLES):
        held, cut = table(random.Random(f"rows {number}")), number % 2 == 0
        expected, certificates = oracle(held, cut=cut), set()
        for name, hold in HOLDERS.items():
            tally = counted(hold(held, tmp_path), cut=cut)
            lost[name] += sum(expected.values()) - tally.rows
            assert texts(tally) == expected, (number, name)
            certificates.add(certificate(tally))
        assert len(certificates) == 1, number
    assert not any(lost.values()), lost


def test_parts_and_tallies_count_each_row_once(tmp_path: Path) -> None:
    for number in range(3):
        held = table(random.Random(f"parts {number}"))
        path = parquet(held, tmp_path)
        made = fa.tally(path, tmp_path / "tally.parquet", COLUMNS)
        again = read_log([tmp_path / "tally.parquet"], (*COLUMNS, "n"), count="n")
        assert made.rows == len(held["age"]) == sum(n * times for n, times in zip(again["n"], again.counts.tolist(), strict=True))
        whole, *parts = read_parts(path, COLUMNS, ["sex"], missing="group")
        assert whole.rows == sum(part.rows for part in parts) == len(held["age"])


@pytest.mark.parametrize("bins", [None, {"age": [30]}], ids=["plain", "intervals"])
@pytest.mark.parametrize("missing", ["error", "drop", "group"])
def test_dictionaries_of_arrow_in_pandas_keep_rows_whose_label_is_missing(bins: Any, missing: Any) -> None:
    """Of 142 rows some versions of pandas count 80 where a column is cut into intervals."""
    import pandas as pd
    import pyarrow as pa

    rows = [("yes", "f", "20")] * 30 + [("no", "f", "20")] * 10 + [("yes", "m", "20")] * 20 + [("no", "m", "20")] * 20
    rows += [("no", "m", None)] * 50 + [(None, "m", "20")] * 7 + [("yes", None, "20")] * 5
    frame = pd.DataFrame(rows, columns=["hired", "sex", "age"]).astype(pd.ArrowDtype(pa.dictionary(pa.int32(), pa.string())))

    def audit() -> fa.Result:
        return fa.audit(frame, decision="hired", group="sex", context="age", bins=bins, utility="yes", missing=missing)

    if missing == "error":
        with pytest.raises(fa.InputError, match="the label is missing"):
            audit()
        return
    found = audit()
    assert found.law.totals.sum() == (80 if missing == "drop" else 142)
    assert str(found.local.ratio) == ("3/2" if missing == "drop" else "47/20")


def test_a_library_that_loses_rows_is_named_with_both_numbers(monkeypatch: pytest.MonkeyPatch) -> None:
    """A pandas that leaves rows with a missing label out of groups although it is told not to, as versions of it did of dictionaries."""
    import pandas as pd

    grouped = pd.DataFrame.groupby
    monkeypatch.setattr(pd.DataFrame, "groupby", lambda self, *given, **asked: grouped(self, *given, **asked | {"dropna": True}))
    frame = pd.DataFrame({"hired": ["yes", "no", None] * 20, "sex": ["f", None, "m"] * 20, "age": [10, 20, 30] * 20})
    with pytest.raises(RowsLost, match=r"^DataFrame: pandas counted 20 of 60 rows, which is no fault of the log; nothing is certified; "):
        fa.audit(frame, decision="hired", group="sex", context="age", bins={"age": [15]}, utility="yes", missing="group")


def test_a_view_that_gives_other_rows_each_time_is_refused_and_a_query_is_asked_once(tmp_path: Path) -> None:
    path = tmp_path / "log.db"
    with sqlite3.connect(path) as database:
        database.execute(
            "create table log as with recursive t(i) as (select 0 union all select i + 1 from t where i < 4999) select * from t"
        )
        database.execute("create view some as select i % 7 as hired, i % 3 as sex from log where random() % 2 = 0")
    database.close()
    for _ in range(3):
        assert 0 < read_log(f"sqlite:{path}", ("hired", "sex"), query="select * from some").rows < 5000

    def looks() -> None:
        for _ in range(20):  # that two counts of one view are equal is rare, and not impossible
            read_log(f"sqlite:{path}", ("hired", "sex"), table="some")

    with pytest.raises(RowsLost, match=r"log.db: SQLite counted [0-9,]+ of [0-9,]+ rows, .*; store the rows in a table first"):
        looks()


def test_a_query_of_a_duckdb_file_that_gives_other_rows_each_time_is_asked_once(tmp_path: Path) -> None:
    source, _ = duckdb_file()({"hired": ["yes", "no"] * 500, "sex": ["f", "m", "m", "f"] * 250, "age": [1] * 1000}, tmp_path)
    found = {read_log(source, COLUMNS, query="select * from log where random() < 0.5").rows for _ in range(3)}
    assert all(0 < rows < 1000 for rows in found)


def test_a_text_with_cells_of_several_lines_is_counted_by_rows(tmp_path: Path) -> None:
    path = tmp_path / "log.csv"
    path.write_text("hired,sex,age\n" + '"yes","f\nf","1"\n"no","m","2"\n' * 100)
    assert counted((path, {"engine": "duckdb"}), cut=False).rows == counted((path, {"engine": "python"}), cut=False).rows == 200


def test_a_result_whose_rows_are_fewer_than_it_says_is_a_loss() -> None:
    read = RowsRead([("yes", "f", 2, 5), ("no", "f", 2, 5)])
    tally = Tally.of("log", ("hired", "sex"), read)
    with pytest.raises(RowsLost, match="log: Spark counted 4 of 5 rows"):
        tally.conserving(read.rows, "Spark")
