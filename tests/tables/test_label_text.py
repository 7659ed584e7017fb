"""One log of typed columns, whatever holds it and whatever the time zone: one certificate, byte for byte, or a refusal.

Forty random tables, or 2,100 with ``FAIRAUDIT_FULL=1``; ``FAIRAUDIT_LABELS=500`` tries that many. Each time zone is a process of its own,
in which TZ, PGTZ and Spark's session time zone differ.
"""

from __future__ import annotations

import datetime
import json
import os
import random
import shutil
import sqlite3
import subprocess
import sys
import tempfile
import unicodedata
from collections import Counter
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from decimal import Decimal
from hashlib import sha256
from itertools import product
from pathlib import Path
from typing import Any
from uuid import UUID

import numpy as np
import pytest
import tiers
from servers import absent

from fairaudit import InputError, Law, certify
from fairaudit.tables.engines.logs import read_log, survey_log
from fairaudit.tables.label_text import label_text
from fairaudit.tables.tally import Tally

TABLES = int(os.environ.get("FAIRAUDIT_LABELS", "2100" if tiers.FULL else "40"))
ZONES = ("America/New_York", "Asia/Kolkata", "Europe/Paris")
COLUMNS = ("u", "a", "x")
BATCH = 10
DAY = 86_400 * 10**9
EPOCH = datetime.date(1970, 1, 1).toordinal()
CHANGES = (1_792_890_000, 1_793_512_800, 1_774_746_000)  # Paris back, New York back, Paris forward: in 2026, seconds since 1970


@dataclass(frozen=True)
class Column:
    """Values of a column, None where one is missing, and the texts of their labels by a way of their own."""

    kind: str
    values: list[Any]
    texts: list[str]

    @property
    def fine(self) -> bool:
        """Whether a value has nanoseconds."""
        return self.kind in ("timestamp", "instant", "time") and any(value is not None and value % 1_000 for value in self.values)

    def each(self, make: Callable[[Any], Any]) -> list[Any]:
        return [None if value is None else make(value) for value in self.values]


def clock(nanoseconds: int) -> str:
    seconds, rest = divmod(nanoseconds, 10**9)
    text = f"{seconds // 3600:02}:{seconds // 60 % 60:02}:{seconds % 60:02}"
    return f"{text}.{rest:09}".rstrip("0") if rest else text


def moment(nanoseconds: int) -> str:
    return f"{datetime.date.fromordinal(EPOCH + nanoseconds // DAY)}T{clock(nanoseconds % DAY)}"


def number(value: float) -> str:
    return str(int(value)) if value == int(value) else np.format_float_positional(value, unique=True, trim="-")


WRITTEN: dict[str, Callable[[Any], str]] = {
    "text": str,
    "integer": str,
    "float": number,
    "decimal": lambda value: format(value.normalize(), "f"),
    "boolean": lambda value: "true" if value else "false",
    "date": str,
    "timestamp": moment,
    "instant": lambda value: f"{moment(value)}+00:00",
    "time": clock,
    "uuid": str,
}


def pool(kind: str, pick: random.Random, fine: bool) -> list[Any]:
    """A few values of a kind that are easily taken for each other."""
    if kind == "text":
        word = pick.choice(("é", "Zoë", "naïve", "ﬁ", "a", "1", "1.0", "true", "Å"))
        return [word, unicodedata.normalize("NFD", word) + "b", word + "\u0301", word + " x"]
    if kind == "integer":
        middle = pick.choice((0, 2**31, 2**53, 2**63, -(2**63), 10**20, 2**64, -7))
        return [middle + step for step in (-1, 0, 1, 2)]
    if kind == "float":
        middle = pick.choice((0.5, 1.0, -0.0, 2.0**53, 1e23, 1e300, 0.1, 1e-7, 5e-324, -1234.5, 3.14))
        return [middle, float(np.nextafter(middle, 1e308)), float(np.nextafter(middle, -1e308)), float(round(middle)) + 1.0]
    if kind == "decimal":
        middle = Decimal(pick.choice(("0", "1.50", "12345678901234567890.123", "-0.000000001", "1E3")))
        return [middle, middle + Decimal("0.000000001"), middle + Decimal("0.1"), -middle - 1]
    if kind == "boolean":
        return [True, False]
    if kind == "date":
        middle = pick.choice((datetime.date(1, 1, 2), datetime.date(1969, 12, 31), datetime.date(2026, 3, 29), datetime.date(9999, 12, 30)))
        return [middle + datetime.timedelta(step) for step in (-1, 0, 1)]
    if kind == "time":
        middle = pick.choice((12 * 3600 * 10**9, 0, DAY - 10**9))
        return [middle + step for step in ((0, 1, 999, 1_000) if fine else (0, 1_000, 10**6, 500 * 10**6))]
    if kind == "uuid":
        middle = pick.getrandbits(128) >> 1
        return [UUID(int=middle + step) for step in range(3)]
    start = pick.choice((*CHANGES, 0, -1, -2_000_000_000, 1_769_860_800)) * 10**9
    coarse = pick.choice(((0, 1_000, 3_600 * 10**9, -3_600 * 10**9), (0, 120 * 10**6, DAY, 1_800 * 10**9)))
    return [start + step for step in ((0, 1, 999, 3_600 * 10**9) if fine else coarse)]


def tables(batch: int) -> dict[str, Column]:
    """Tables of three typed columns each, side by side; in every other batch moments have nanoseconds."""
    pick = random.Random(f"labels {batch}")
    rows = pick.randrange(6, 30)
    found = {}
    for name in (f"{column}{place}" for place in range(BATCH) for column in COLUMNS):
        kind = pick.choice(tuple(WRITTEN))
        values = pick.sample(known := list(dict.fromkeys(pool(kind, pick, bool(batch % 2)))), pick.randrange(2, len(known) + 1))
        absent = pick.random() < 0.2
        column: list[Any] = [pick.choice(values) for _ in range(rows)]
        column = [None if absent and pick.random() < 0.2 else value for value in column]
        column[:2] = values[:2]
        found[name] = Column(kind, column, ["" if value is None else WRITTEN[kind](value) for value in column])
    return found


KNOWN: dict[Any, str] = {}


def certificate(log: Any, place: int) -> str:
    """Digest of the certificate of a table; equal laws of one process are certified once."""
    law = Law.from_log(log, decision=f"u{place}", group=f"a{place}", context=f"x{place}", missing="group")
    key = (law.decisions, law.groups, law.contexts, law.weights.tobytes(), law.notes, law.columns)
    if key not in KNOWN:
        KNOWN[key] = sha256(certify(law, {law.decisions[-1]: 1}, confidence=None).certificate.text.encode()).hexdigest()
    return KNOWN[key]


# Holders


class CannotHoldError(Exception):
    """A library or database has no such values."""


def as_csv(columns: dict[str, Column], folder: Path) -> Any:
    import csv

    path = folder / "log.csv"
    with path.open("w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file)
        writer.writerow(columns)
        writer.writerows(zip(*(column.texts for column in columns.values()), strict=True))
    return path


def in_python(columns: dict[str, Column], folder: Path) -> Any:
    return read_log(as_csv(columns, folder), tuple(columns), engine="python")


def in_duckdb(columns: dict[str, Column], folder: Path) -> Any:
    return read_log(as_csv(columns, folder), tuple(columns), engine="duckdb")


def plain(column: Column) -> list[Any]:
    """Values that JSON and SQLite have, the texts of others."""
    if column.kind in ("integer", "float", "boolean"):
        return column.values
    return [text or None for text in column.texts]


def in_json(columns: dict[str, Column], folder: Path) -> Any:
    path = folder / "log.jsonl"
    rows = zip(*(plain(column) for column in columns.values()), strict=True)
    path.write_text("".join(json.dumps(dict(zip(columns, row, strict=True))) + "\n" for row in rows))
    return read_log(path, tuple(columns))


def in_sqlite(columns: dict[str, Column], folder: Path) -> Any:
    held = {}
    for name, column in columns.items():
        texts = column.kind == "boolean" or (column.kind == "integer" and any(abs(value or 0) >= 2**63 for value in column.values))
        held[name] = [text or None for text in column.texts] if texts else plain(column)
    path = folder / "log.db"
    path.unlink(missing_ok=True)
    with sqlite3.connect(path) as database:
        database.execute(f"create table log ({', '.join(columns)})")
        database.executemany(f"insert into log values ({', '.join('?' * len(columns))})", zip(*held.values(), strict=True))
    database.close()
    return read_log(f"sqlite:{path}", tuple(columns), table="log")


def typed(column: Column, types: dict[str, str]) -> str:
    if column.fine and f"fine {column.kind}" not in types:
        raise CannotHoldError
    wide = column.kind == "integer" and any(abs(value or 0) >= 2**63 for value in column.values)
    return types["wide" if wide else f"fine {column.kind}" if column.fine else column.kind]


def cast_rows(columns: dict[str, Column], types: dict[str, str]) -> tuple[list[str], list[str]]:
    """Types of columns, and rows of literals cast to them."""
    kinds = [typed(column, types) for column in columns.values()]
    listed = []
    for row in zip(*((c.texts if c.kind != "float" else c.each(repr)) for c in columns.values()), strict=True):
        cells = ["null" if not text else "'" + text.replace("'", "''") + "'" for text in row]
        listed.append(", ".join(f"cast({cell} as {kind})" for cell, kind in zip(cells, kinds, strict=True)))
    return kinds, listed


DUCKDB = {"text": "varchar", "integer": "bigint", "wide": "hugeint", "float": "double", "decimal": "decimal(38, 9)", "boolean": "boolean"}
DUCKDB |= {"date": "date", "timestamp": "timestamp", "fine timestamp": "timestamp_ns", "instant": "timestamptz", "uuid": "uuid"}
DUCKDB |= {"time": "time", "fine time": "time_ns", "fine instant": "timestamptz_ns"}
POSTGRES = {"text": "text", "integer": "bigint", "wide": "numeric", "float": "float8", "decimal": "numeric(40, 9)", "boolean": "boolean"}
POSTGRES |= {"date": "date", "timestamp": "timestamp", "instant": "timestamptz", "time": "time", "uuid": "uuid"}
SPARK = {
    "text": "string",
    "integer": "bigint",
    "wide": "decimal(38, 0)",
    "float": "double",
    "decimal": "decimal(38, 9)",
    "boolean": "boolean",
}
SPARK |= {"date": "date", "timestamp": "timestamp_ntz", "instant": "timestamp", "time": "string", "fine time": "string", "uuid": "string"}


def in_a_duckdb_file(columns: dict[str, Column], folder: Path) -> Any:
    import duckdb

    kinds, rows = cast_rows(columns, DUCKDB)
    path = folder / "log.duckdb"
    path.unlink(missing_ok=True)
    with duckdb.connect(str(path)) as connection:
        connection.execute(f"create table log ({', '.join(f'{n} {k}' for n, k in zip(columns, kinds, strict=True))})")
        connection.execute(f"insert into log values {', '.join(f'({row})' for row in rows)}")
    return read_log(f"duckdb:{path}", tuple(columns), table="log")


def in_a_relation(columns: dict[str, Column], folder: Path) -> Any:
    import duckdb

    _, rows = cast_rows(columns, DUCKDB)
    connection = duckdb.connect()
    connection.execute("set TimeZone = 'America/Sao_Paulo'")
    return read_log(
        connection.sql(f"select * from (values {', '.join(f'({row})' for row in rows)}) t({', '.join(columns)})"), tuple(columns)
    )


def in_postgres(columns: dict[str, Column], folder: Path) -> Any:
    import psycopg

    kinds, rows = cast_rows(columns, POSTGRES)
    url = os.environ["FAIRAUDIT_LABELS_POSTGRES"]
    name = f"labels{os.getpid()}"
    with psycopg.connect(url) as connection:
        connection.execute(f"drop table if exists {name}")
        connection.execute(f"create table {name} ({', '.join(f'{n} {k}' for n, k in zip(columns, kinds, strict=True))})")
        connection.execute(f"insert into {name} values {', '.join(f'({row})' for row in rows)}")
    return read_log(url, tuple(columns), table=name)


def in_spark(columns: dict[str, Column], folder: Path) -> Any:
    from pyspark.sql import SparkSession

    kinds, _ = cast_rows(columns, SPARK)
    held = [c.texts if c.kind != "float" else c.each(repr) for c in columns.values()]
    rows = [tuple(text or None for text in row) for row in zip(*held, strict=True)]
    texts = SparkSession.getActiveSession().createDataFrame(rows, ", ".join(f"{name} string" for name in columns))  # type: ignore[union-attr]
    frame = texts.selectExpr(*(f"cast({name} as {kind}) as {name}" for name, kind in zip(columns, kinds, strict=True)))
    return read_log(frame, tuple(columns))


def moments(column: Column) -> Any:
    return np.array([np.datetime64("NaT") if value is None else value for value in column.values], dtype="datetime64[ns]")


def in_pandas(columns: dict[str, Column], folder: Path) -> Any:
    import pandas as pd

    held: dict[str, Any] = {}
    for place, (name, column) in enumerate(columns.items()):
        if column.kind == "timestamp":
            held[name] = moments(column)
        elif column.kind == "instant":
            held[name] = pd.Series(moments(column)).dt.tz_localize("UTC").dt.tz_convert(ZONES[place % 3])
        elif column.kind == "time":
            if column.fine:
                raise CannotHoldError
            held[name] = pd.Series(column.each(lambda value: datetime.time.fromisoformat(clock(value))), dtype=object)
        elif column.kind == "boolean" and None in column.values:
            held[name] = pd.Series(column.values, dtype="boolean")
        elif column.kind in ("text", "integer") and None in column.values:  # which would make numbers of integers
            held[name] = pd.Series(column.values, dtype="str" if column.kind == "text" else object)
        else:
            held[name] = column.values
    frame = pd.DataFrame(held)
    return frame.astype({"u0": "category", "a1": "category"}) if len(frame) % 3 == 0 else frame


def in_python_objects(columns: dict[str, Column], folder: Path) -> Any:
    """A mapping of lists, with moments of a zone, whose clock may show one time twice."""
    from zoneinfo import ZoneInfo

    if any(column.fine for column in columns.values()):
        raise CannotHoldError
    start = datetime.datetime(1970, 1, 1, tzinfo=datetime.UTC)

    def local(value: int, zone: str | None) -> datetime.datetime:
        moment = start + datetime.timedelta(microseconds=value // 1_000)
        return moment.replace(tzinfo=None) if zone is None else moment.astimezone(ZoneInfo(zone))

    made: dict[str, Callable[[Any], Any]] = {
        "timestamp": lambda value: local(value, None),
        "instant": lambda value: local(value, "Europe/Paris"),
        "time": lambda value: datetime.time.fromisoformat(clock(value)),
    }
    return {name: column.each(made.get(column.kind, lambda value: value)) for name, column in columns.items()}


def arrow(columns: dict[str, Column]) -> Any:
    import pyarrow as pa

    held = {}
    for place, (name, column) in enumerate(columns.items()):
        wide = any(not -(2**63) <= (value or 0) < 2**63 for value in column.values) if column.kind == "integer" else False
        if column.kind in ("timestamp", "instant"):
            kind = pa.timestamp("ns" if column.fine else "us", ZONES[place % 3] if column.kind == "instant" else None)
            held[name] = pa.array(column.each(lambda v, fine=column.fine: v if fine else v // 1_000), pa.int64()).cast(kind)
        elif column.kind == "time":
            kind = pa.time64("ns" if column.fine else "us")
            held[name] = pa.array(column.each(lambda v, fine=column.fine: v if fine else v // 1_000), pa.int64()).cast(kind)
        elif column.kind == "uuid":
            held[name] = pa.array(column.each(lambda value: value.bytes), pa.uuid())
        elif column.kind == "decimal":
            held[name] = pa.array(column.values, pa.decimal128(38, 9))
        elif wide:
            held[name] = pa.array(column.each(Decimal), pa.decimal128(38, 0))
        else:
            held[name] = pa.array(column.values)
    return pa.table(held)


def in_pyarrow(columns: dict[str, Column], folder: Path) -> Any:
    return arrow(columns)


def in_parquet(columns: dict[str, Column], folder: Path) -> Any:
    import pyarrow.parquet as pq

    pq.write_table(arrow(columns), folder / "log.parquet")
    return read_log(folder / "log.parquet", tuple(columns))


def in_polars(columns: dict[str, Column], folder: Path) -> Any:
    import polars as pl

    held = {}
    for place, (name, column) in enumerate(columns.items()):
        if column.kind in ("timestamp", "instant"):
            kind = pl.Datetime("ns", ZONES[place % 3] if column.kind == "instant" else None)
            held[name] = pl.Series(column.values, dtype=pl.Int64).cast(kind)
        elif column.kind == "time":
            held[name] = pl.Series(column.values, dtype=pl.Int64).cast(pl.Time)
        elif column.kind == "uuid":
            held[name] = pl.Series(column.each(str), dtype=pl.String)
        elif column.kind == "integer":
            held[name] = pl.Series(column.values, dtype=pl.Int128)
        elif column.kind == "decimal":
            held[name] = pl.Series(column.values, dtype=pl.Decimal(38, 9))
        else:
            held[name] = pl.Series(column.values)
    frame = pl.DataFrame(held)
    return frame.lazy() if len(frame) % 2 else frame


HOLDERS: dict[str, Callable[[dict[str, Column], Path], Any]] = {
    "csv": in_python,
    "csv in duckdb": in_duckdb,
    "json lines": in_json,
    "parquet": in_parquet,
    "sqlite": in_sqlite,
    "duckdb": in_a_duckdb_file,
    "duckdb relation": in_a_relation,
    "pandas": in_pandas,
    "polars": in_polars,
    "pyarrow": in_pyarrow,
    "python": in_python_objects,
}


def outcomes(hold: Callable[[dict[str, Column], Path], Any], columns: dict[str, Column], folder: Path) -> list[str]:
    """The certificates' digests, or the sentence that refuses the log."""
    try:
        log = hold(columns, folder)
        return [certificate(log, place) for place in range(BATCH)]
    except CannotHoldError:
        return ["cannot"] * BATCH
    except InputError as error:
        return [f"refused: {error}"] * BATCH


def work(first: int, last: int) -> None:
    """Print, for each table, what each holder gives; in a process that has a time zone of its own."""
    holders = dict(HOLDERS)
    if "FAIRAUDIT_LABELS_POSTGRES" in os.environ:
        holders["postgres"] = in_postgres
    if "FAIRAUDIT_LABELS_SPARK" in os.environ:
        from pyspark.sql import SparkSession

        builder = SparkSession.builder.master("local[1]").config("spark.ui.enabled", "false").config("spark.sql.shuffle.partitions", "1")
        session = builder.config("spark.sql.session.timeZone", os.environ["FAIRAUDIT_LABELS_SPARK"]).getOrCreate()
        session.sparkContext.setLogLevel("OFF")
        holders["spark"] = in_spark
    with tempfile.TemporaryDirectory(prefix="fairaudit-labels-") as name:
        for batch in range(first, last):
            columns = tables(batch)
            found = {holder: outcomes(hold, columns, Path(name)) for holder, hold in holders.items()}
            print(json.dumps([batch, found]), flush=True)


def in_zones(batches: int, **settings: str) -> dict[str, list[dict[str, list[str]]]]:
    """What the holders give in each time zone."""
    running = {}
    for place, zone in enumerate(ZONES):
        places = os.pathsep.join((str(Path(__file__).parents[1]), os.environ.get("PYTHONPATH", "")))
        environment = {**os.environ, "TZ": zone, "PGTZ": zone, "PYTHONWARNINGS": "ignore", "PYTHONPATH": places, **settings}
        if "FAIRAUDIT_LABELS_SPARK" in settings:
            environment["FAIRAUDIT_LABELS_SPARK"] = ZONES[place - 1]
        words = [sys.executable, __file__, "0", str(batches)]
        out = tempfile.TemporaryFile("w+")  # noqa: SIM115
        running[zone] = subprocess.Popen(words, stdout=out, stderr=subprocess.PIPE, text=True, env=environment), out
    found: dict[str, list[dict[str, list[str]]]] = {}
    for zone, (process, out) in running.items():
        _, said = process.communicate()
        assert process.returncode == 0, said[-3000:]
        out.seek(0)
        found[zone] = [json.loads(line)[1] for line in out.read().splitlines() if line.startswith("[")]
        out.close()
    return found


def judged(found: dict[str, list[dict[str, list[str]]]], batches: int) -> tuple[Counter[str], Counter[str]]:
    """Demand one certificate of each table; count the certificates and refusals by holder."""
    certificates: Counter[str] = Counter()
    refusals: Counter[str] = Counter()
    for batch, zone in product(range(batches), found):
        expected = found[ZONES[0]][batch]["csv"]
        for holder, texts in found[zone][batch].items():
            for place, text in enumerate(texts):
                if text.startswith("refused"):
                    refusals[f"{holder}: {text}"] += 1
                elif text != "cannot":
                    assert text == expected[place], (batch, place, zone, holder, {n: column.kind for n, column in tables(batch).items()})
                    certificates[holder] += 1
    return certificates, refusals


def test_one_certificate_of_typed_tables_in_every_library_and_time_zone() -> None:
    batches = TABLES // BATCH
    certificates, refusals = judged(in_zones(batches), batches)
    print(dict(certificates), refusals.most_common(20))
    assert set(certificates) == set(HOLDERS) and not refusals
    assert min(certificates[holder] for holder in HOLDERS if holder not in ("pandas", "python")) == 3 * batches * BATCH


def test_one_certificate_of_typed_tables_in_servers_and_time_zones(postgres: str) -> None:
    if shutil.which("java") is None:
        absent("Spark needs Java, and there is none on this machine")
    pytest.importorskip("pyspark", reason="PySpark is not installed")
    batches = TABLES // BATCH if tiers.FULL else 2
    certificates, refusals = judged(in_zones(batches, FAIRAUDIT_LABELS_POSTGRES=postgres, FAIRAUDIT_LABELS_SPARK="UTC"), batches)
    print(dict(certificates), refusals.most_common(20))
    assert not refusals and min(certificates["postgres"], certificates["spark"]) >= 3 * BATCH * (batches // 2)


# One by one


def file_of(folder: Path, kind: str, values: list[str]) -> Path:
    """A Parquet file of two groups: in the first context one is favoured, in the second the other; the contexts are values of a type."""
    import duckdb

    path = folder / "typed.parquet"
    rows = [
        (u, a, x, n)
        for x, v in enumerate(values[:2])
        for u, a, n in (("yes", "f", 3 - 2 * x), ("no", "f", 1 + 2 * x), ("yes", "m", 1 + 2 * x), ("no", "m", 3 - 2 * x))
    ]
    listed = ", ".join(f"('{u}', '{a}', cast('{values[x]}' as {kind}))" for u, a, x, n in rows for _ in range(n))
    with duckdb.connect(str(folder / "typed.duckdb")) as connection:
        connection.execute("drop table if exists log")
        connection.execute(f"create table log as select * from (values {listed}) t(u, a, x)")
    if kind not in ("timestamptz_ns",):
        duckdb.sql(f"copy (select * from (values {listed}) t(u, a, x)) to '{path}' (format parquet)")
    return path


CLOSE = {
    "timestamp_ns": ["2026-01-31 12:00:00.000000001", "2026-01-31 12:00:00.000000002"],
    "timestamptz": ["2026-10-25 00:30:00+00", "2026-10-25 01:30:00+00"],
    "date": ["infinity", "9999-12-31"],
    "timestamp": ["infinity", "9999-12-31 23:59:59.999999"],
    "time": ["24:00:00", "00:00:00"],
    "hugeint": ["170141183460469231731687303715884105727", "170141183460469231731687303715884105726"],
    "decimal(38, 10)": ["0.1000000001", "0.1000000002"],
    "uuid": ["550e8400-e29b-41d4-a716-446655440000", "550e8400-e29b-41d4-a716-446655440001"],
}


@pytest.mark.parametrize("kind", CLOSE)
def test_values_of_an_engine_that_are_close_stay_two_contexts(kind: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Two contexts that merge would hide a ratio of 3 behind one of 1."""
    file_of(tmp_path, kind, CLOSE[kind])
    monkeypatch.setenv("TZ", "Europe/Paris")
    law = Law.from_log(read_log(f"duckdb:{tmp_path / 'typed.duckdb'}", COLUMNS, table="log"), decision="u", group="a", context="x")
    assert len(law.contexts) == 2
    found = certify(law, {"yes": 1}, confidence=None).local
    assert found is not None and found.ratio == 3


@pytest.mark.parametrize("library", ["parquet", "polars", "polars lazy", "pyarrow", "pandas", "relation", "pandas in arrow"])
def test_nanoseconds_stay_apart(library: str, tmp_path: Path) -> None:
    import duckdb
    import polars as pl
    import pyarrow.parquet as pq

    path = file_of(tmp_path, "timestamp_ns", CLOSE["timestamp_ns"])
    held = pq.read_table(path)
    log = {
        "parquet": lambda: read_log(path, COLUMNS),
        "polars": lambda: pl.read_parquet(path),
        "polars lazy": lambda: pl.scan_parquet(path),
        "pyarrow": lambda: held,
        "pandas": held.to_pandas,
        "pandas in arrow": lambda: held.to_pandas(types_mapper=__import__("pandas").ArrowDtype),
        "relation": lambda: duckdb.read_parquet(str(path)),
    }[library]()
    law = Law.from_log(log, decision="u", group="a", context="x")
    assert law.contexts == (("2026-01-31T12:00:00.000000001",), ("2026-01-31T12:00:00.000000002",))


def test_moments_with_a_zone_need_nothing_but_the_default_install(tmp_path: Path) -> None:
    file_of(tmp_path, "timestamptz", CLOSE["timestamptz"])
    expected = (("2026-10-25T00:30:00+00:00",), ("2026-10-25T01:30:00+00:00",))
    program = (
        "import sys; sys.modules['pytz'] = None\n"
        "from fairaudit import Law; from fairaudit.tables.engines.logs import read_log, survey_log\n"
        "for source in (['typed.parquet'], ['duckdb:typed.duckdb', 'log']):\n"
        "    named = {'table': source[1]} if source[1:] else {}\n"
        "    print(Law.from_log(read_log(source[0], ('u', 'a', 'x'), **named), decision='u', group='a', context='x').contexts)\n"
        "    print([(seen.fault, sorted(seen.levels)) for seen in survey_log(source[0], **named).columns][2])\n"
    )
    said = set()
    for zone in ZONES:
        environment = {**os.environ, "TZ": zone}
        done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, cwd=tmp_path, env=environment)
        assert (done.returncode, done.stderr) == (0, "")
        said.add(done.stdout)
    assert said == {2 * f"{expected}\n{('', [expected[0][0], expected[1][0]])}\n"}


REFUSED = {
    "interval": ["1 day", "24 hours"],
    "timetz": ["12:00:00+02", "12:00:00+03"],
    "blob": ["a", "b"],
    "bit": ["01", "1"],
    "integer[]": ["[1]", "[2]"],
    "struct(v integer)": ["{v: 1}", "{v: 2}"],
    "map(varchar, integer)": ["{a=1}", "{a=2}"],
}


@pytest.mark.parametrize("kind", REFUSED)
def test_values_without_one_text_are_refused_by_column_and_type(kind: str, tmp_path: Path) -> None:
    file_of(tmp_path, kind, REFUSED[kind])
    source = f"duckdb:{tmp_path / 'typed.duckdb'}"
    with pytest.raises(InputError, match=r"column 'x' is of type .*; cast the column to one of them"):
        read_log(source, COLUMNS, table="log")
    assert read_log(source, ("u", "a"), table="log").rows == 16
    assert [bool(seen.fault) for seen in survey_log(source, table="log").columns] == [False, False, True]


def refused_frames() -> Iterator[tuple[str, Any]]:
    import pandas as pd
    import polars as pl
    import pyarrow as pa

    hours = [datetime.timedelta(hours=n) for n in (1, 2)]
    periods = pd.period_range("2026-01", periods=2, freq="M")
    base = {"u": ["yes", "no"], "a": ["f", "m"]}
    yield "polars duration", pl.DataFrame({**base, "x": hours})
    yield "polars binary", pl.DataFrame({**base, "x": [b"a", b"b"]})
    yield "polars object", pl.DataFrame({**base, "x": pl.Series([object(), object()], dtype=pl.Object)})
    yield "pandas timedelta", pd.DataFrame({**base, "x": hours})
    yield "pandas period", pd.DataFrame({**base, "x": periods})
    yield "pandas periods in categories", pd.DataFrame({**base, "x": pd.Categorical(periods)})
    yield "pandas bytes", pd.DataFrame({**base, "x": [b"a", b"b"]})
    yield "pyarrow duration", pa.table({**base, "x": pa.array(hours)})
    yield "pyarrow binary", pa.table({**base, "x": pa.array([b"a", b"b"], pa.binary(1))})
    yield "pyarrow interval", pa.table({**base, "x": pa.array([(1, 2, 3), (1, 2, 4)], pa.month_day_nano_interval())})
    yield "pyarrow json", pa.table({**base, "x": pa.array(["1", "2"], pa.json_())})
    yield "time with a zone", {**base, "x": [datetime.time(12, tzinfo=datetime.UTC), datetime.time(13, tzinfo=datetime.UTC)]}
    yield "numpy timedelta", {**base, "x": np.array([1, 2], "timedelta64[s]")}
    yield "year 12026", {**base, "x": np.array(["12026-01-01", "2026-01-01"], "datetime64[D]")}


@pytest.mark.parametrize(("name", "frame"), [pytest.param(name, frame, id=name) for name, frame in refused_frames()])
def test_frames_of_values_without_one_text_are_refused_by_column(name: str, frame: Any) -> None:
    with pytest.raises(InputError, match="column 'x'"):
        Law.from_log(frame, decision="u", group="a", context="x")


def test_files_of_two_types_are_not_rounded_to_one(tmp_path: Path) -> None:
    import pyarrow as pa
    import pyarrow.parquet as pq

    for place, numbers in enumerate(([2, 3], [2.4, 3.4])):
        pq.write_table(pa.table({"u": ["yes", "no"], "a": ["f", "m"], "x": numbers}), tmp_path / f"{place}.parquet")
    with pytest.raises(InputError, match=r"column 'x' is INTEGER in .*0.parquet and DOUBLE in .*1.parquet"):
        read_log(str(tmp_path / "*.parquet"), COLUMNS)
    assert read_log(str(tmp_path / "*.parquet"), ("u", "a")).rows == 4


@pytest.mark.parametrize(("kind", "options"), [("moments", {"use_deprecated_int96_timestamps": True}), ("decimals", {})])
def test_what_an_engine_rounds_unseen_is_refused(kind: str, options: dict[str, Any], tmp_path: Path) -> None:
    import pyarrow as pa
    import pyarrow.parquet as pq

    held = {
        "moments": pa.array([1, 2], pa.int64()).cast(pa.timestamp("ns")),
        "decimals": pa.array([Decimal("1" * 45), Decimal("1" * 44 + "2")], pa.decimal256(50, 0)),
    }[kind]
    pq.write_table(pa.table({"u": ["yes", "no"], "a": ["f", "m"], "x": held}), tmp_path / "log.parquet", **options)
    with pytest.raises(InputError, match="column 'x' holds"):
        read_log(tmp_path / "log.parquet", COLUMNS)
    faults = [seen.fault for seen in survey_log(tmp_path / "log.parquet").columns]
    assert faults[:2] == ["", ""] and "column 'x' holds" in faults[2]


def test_rows_that_have_become_equal_are_refused() -> None:
    with pytest.raises(InputError, match="rows that differ where they are held have become equal"):
        Tally.of("log", ("u", "a"), [("yes", "f", 3), ("yes", "f", 1)])
    with pytest.raises(InputError, match="have become equal"):
        Tally.of("log", ("u",), [("2026-01-31 12:00:00.1", 3), ("2026-01-31 12:00:00.10", 1)], read={"u": lambda text: text.rstrip("0")})
    zeros = Tally.of("log", ("u", "a"), [(0.0, "f", 3), (-0.0, "f", 1), (None, "f", 2), (float("nan"), "f", 5)])
    assert sorted(zip(map(str, zeros["u"]), zeros.counts.tolist(), strict=True)) == [("0.0", 4), ("None", 7)]


def test_two_moments_of_one_hour_are_two_labels_to_python() -> None:
    from zoneinfo import ZoneInfo

    import pandas as pd

    clock = datetime.datetime(2026, 10, 25, 2, 30, tzinfo=ZoneInfo("Europe/Paris"))
    log = {"u": ["yes", "no"], "a": [clock, clock.replace(fold=1)]}
    for held in (log, pd.DataFrame(log, dtype=object)):
        law = Law.from_log(held, decision="u", group="a")
        assert law.groups == (("2026-10-25T00:30:00+00:00",), ("2026-10-25T01:30:00+00:00",))


@pytest.mark.parametrize(
    ("value", "text"),
    [
        (True, "true"),
        (np.bool_(False), "false"),
        (1.0, "1"),
        (-0.0, "0"),
        (1e23, "99999999999999991611392"),
        (2.0**60, "1152921504606846976"),
        (1e-7, "0.0000001"),
        (0.1, "0.1"),
        (np.float32(0.1), "0.10000000149011612"),
        (Decimal("1.50"), "1.5"),
        (Decimal("Infinity"), "inf"),
        (2**70, "1180591620717411303424"),
        (datetime.date(2026, 1, 31), "2026-01-31"),
        (datetime.datetime(2026, 1, 31, 12, microsecond=120_000, tzinfo=datetime.UTC), "2026-01-31T12:00:00.12+00:00"),
        (datetime.time(12, 30), "12:30:00"),
        (np.datetime64("2026-01-31T12:00:00.000000001"), "2026-01-31T12:00:00.000000001"),
        (UUID(int=1), "00000000-0000-0000-0000-000000000001"),
        (float("nan"), None),
        (Decimal("NaN"), None),
        (np.datetime64("NaT"), None),
    ],
)
def test_the_text_of_a_value(value: Any, text: str | None) -> None:
    assert label_text(value) == text


# Servers


def test_types_of_postgres(postgres: str, monkeypatch: pytest.MonkeyPatch) -> None:
    import psycopg

    values = {
        "date": ("infinity", "9999-12-31"),
        "timestamptz": ("2026-10-25 00:30:00+00", "2026-10-25 01:30:00+00"),
        "timestamp": ("2026-01-31 12:00:00.120000", "-infinity"),
        "float4": ("0.1", "1"),
        "numeric": ("1.50", "18446744073709551616"),
        "jsonb": ("true", '"x"'),
        "oid": ("1", "2"),
        "name": ("a", "b"),
        "char(3)": ("abc", "def"),
    }
    texts = [
        ("9999-12-31", "infinity"),
        ("2026-10-25T00:30:00+00:00", "2026-10-25T01:30:00+00:00"),
        ("-infinity", "2026-01-31T12:00:00.12"),
    ]
    texts += [("0.10000000149011612", "1"), ("1.5", "18446744073709551616"), ("true", "x"), ("1", "2"), ("a", "b"), ("abc", "def")]
    refused = ["interval", "timetz", "bytea", "json", "xml", "inet", "money", "point", "integer[]", "int4range", "bit(3)"]
    held = ["1 day", "12:00:00+02", "a", "{}", "<a/>", "10.0.0.1", "1", "(1,2)", "{1}", "[1,2)", "101"]
    with psycopg.connect(postgres) as connection:
        connection.execute("create table kinds as select * from (values ('yes', 'f'), ('no', 'm')) t(u, a)")
        for place, (kind, (first, second)) in enumerate(values.items()):
            connection.execute(f"alter table kinds add k{place} {kind}")
            connection.execute(f"update kinds set k{place} = case when u = 'yes' then '{first}'::{kind} else '{second}'::{kind} end")
        for place, (kind, text) in enumerate(zip(refused, held, strict=True)):
            connection.execute(f"alter table kinds add r{place} {kind} default '{text}'")
    for zone in ZONES:
        monkeypatch.setenv("PGTZ", zone)
        monkeypatch.setenv("PGDATESTYLE", "German")
        monkeypatch.setenv("PGOPTIONS", "-c extra_float_digits=-10")
        found = {seen.name: seen for seen in survey_log(postgres, table="kinds").columns}
        for place, expected in enumerate(texts):
            law = Law.from_log(read_log(postgres, ("u", f"k{place}"), table="kinds"), decision="u", group=f"k{place}")
            assert law.groups == tuple((text,) for text in expected)
            assert sorted(found[f"k{place}"].levels) == list(expected)
        for place in range(len(refused)):
            with pytest.raises(InputError, match=f"column 'r{place}' is of type"):
                read_log(postgres, ("u", f"r{place}"), table="kinds")
            assert "is of type" in found[f"r{place}"].fault


@pytest.mark.filterwarnings("ignore")
def test_types_of_spark() -> None:
    sql = pytest.importorskip("pyspark.sql", reason="PySpark is not installed")
    if shutil.which("java") is None:
        absent("Spark needs Java, and there is none on this machine")
    builder = sql.SparkSession.builder.master("local[1]").config("spark.ui.enabled", "false").config("spark.sql.shuffle.partitions", "1")
    spark = builder.getOrCreate()
    spark.sparkContext.setLogLevel("OFF")
    try:
        moments = "timestamp'2026-10-25 00:30:00+00:00', timestamp'2026-10-25 01:30:00+00:00'"
        said = set()
        for zone in ZONES:
            spark.conf.set("spark.sql.session.timeZone", zone)
            frame = spark.sql(
                f"select 'yes' as u, 'f' as a, explode(array({moments})) as x union all select 'no', 'm', explode(array({moments}))"
            )
            for log in (frame, read_log(frame, COLUMNS)):
                said.add(Law.from_log(log, decision="u", group="a", context="x").contexts)
        assert said == {(("2026-10-25T00:30:00+00:00",), ("2026-10-25T01:30:00+00:00",))}
        for expression in (
            "interval '1' day",
            "interval '1' month",
            "cast('a' as binary)",
            "array(1)",
            "named_struct('v', 1)",
            "map('v', 1)",
        ):
            with pytest.raises(InputError, match="column 'x' is of type"):
                read_log(spark.sql(f"select 'yes' as u, 'f' as a, {expression} as x"), COLUMNS)
    finally:
        spark.stop()


if __name__ == "__main__":
    work(int(sys.argv[1]), int(sys.argv[2]))
