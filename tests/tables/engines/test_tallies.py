"""Counts that were written once are those of the log whose rows they stand for."""

from __future__ import annotations

import json
import sqlite3
from contextlib import closing
from datetime import date
from decimal import Decimal
from fractions import Fraction
from pathlib import Path
from typing import Any

import duckdb
import numpy as np
import pandas as pd
import polars as pl
import pyarrow.dataset
import pyarrow.parquet
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

import fairaudit as fa
from fairaudit.cli import main
from fairaudit.tables.engines.tally_files import KEY

LABELS = ["a", " a", "A", "007", "7", "1", "1.0", "1e3", "nan", "null", "\u202ea", "é", "e\u0301", "x,\"y'", "ä\x7f", "日本"]
ASKED: dict[str, Any] = {"decision": "u", "group": "a", "utility": {"yes": 1, "7": "0.5"}}
COLUMNS = ["u", "a", "x", "y"]


def parquet(path: Path, rows: list[dict[str, Any]], kinds: dict[str, str]) -> Path:
    """Write rows as columns of these types."""
    with duckdb.connect() as connection:
        connection.execute(f"create table log ({', '.join(f'{name} {kind}' for name, kind in kinds.items())})")
        connection.executemany(f"insert into log values ({', '.join('?' * len(kinds))})", [[row[name] for name in kinds] for row in rows])
        connection.execute(f"copy log to '{path}' (format parquet)")
    return path


def outcome(source: Any, **options: Any) -> str:
    """The certificate of a log, or why there is none."""
    try:
        return fa.audit(source, **ASKED | options).certificate.text
    except fa.InputError as error:
        return f"refused: {str(error).partition(': ')[2].split('(')[0] if '(missing)' in str(error) else type(error)}"


texts = st.one_of(st.none(), st.sampled_from(["", "  ", *LABELS]))
values: dict[str, st.SearchStrategy[Any]] = {
    "varchar": texts,
    "bigint": st.one_of(st.none(), st.integers(-(2**63), 2**63 - 1), st.integers(0, 3)),
    "double": st.one_of(st.none(), st.sampled_from([0.0, -0.0, 1.0, 0.1, 1e300, float("nan"), float("inf"), 2.0**60])),
    "boolean": st.one_of(st.none(), st.booleans()),
    "decimal(9,2)": st.one_of(st.none(), st.sampled_from([Decimal("1.50"), Decimal("1.00"), Decimal("-3.25")])),
    "date": st.one_of(st.none(), st.dates(date(1, 1, 1), date(9999, 12, 31))),
    "timestamp": st.one_of(st.none(), st.datetimes()),
    "timestamptz": st.sampled_from(["2026-01-31 12:00:00.12+02", "1969-12-31 23:59:59.999999+00", None]),
    "time": st.one_of(st.none(), st.times()),
}


@settings(max_examples=15, deadline=None, suppress_health_check=[HealthCheck.too_slow, HealthCheck.data_too_large])
@given(st.data())
def test_parts_give_the_certificate_of_the_whole_log(tmp_path_factory: pytest.TempPathFactory, data: st.DataObject) -> None:
    folder = tmp_path_factory.mktemp("parts")
    kinds = {"u": "varchar", **{name: data.draw(st.sampled_from(sorted(values)), label=name) for name in ("a", "x", "y")}}
    row = st.fixed_dictionaries({"u": st.sampled_from(["yes", "no", "7"]), **{name: values[kinds[name]] for name in ("a", "x", "y")}})
    days = data.draw(st.lists(st.lists(row, min_size=1, max_size=12), min_size=1, max_size=4))
    logs = [parquet(folder / f"log{i}.parquet", rows, kinds) for i, rows in enumerate(days)]
    parts = [folder / f"part{i}.parquet" for i in range(len(days))]
    for log, part, rows in zip(logs, parts, days, strict=True):
        assert fa.tally(log, part, COLUMNS).rows == len(rows)
    missing = data.draw(st.sampled_from(["error", "drop", "group", "unknown"]))
    options = {"context": data.draw(st.sampled_from([None, "x", ["x", "y"]])), "missing": missing, "fold_labels": data.draw(st.booleans())}
    assert outcome(parts, count="n", **options) == outcome(logs, **options)


@settings(max_examples=8, deadline=None)
@given(
    st.lists(st.lists(st.tuples(st.sampled_from(["yes", "no"]), *[st.sampled_from(["", *LABELS])] * 2), min_size=3), min_size=1, max_size=3)
)
def test_parts_of_texts_give_the_certificate_of_the_whole_text(
    tmp_path_factory: pytest.TempPathFactory, days: list[list[tuple[str, ...]]]
) -> None:
    folder = tmp_path_factory.mktemp("texts")
    logs = []
    for i, rows in enumerate(days):
        logs.append(folder / f"log{i}.csv")
        pd.DataFrame(rows, columns=["u", "a", "x"]).to_csv(logs[-1], index=False)
        fa.tally(logs[-1], folder / f"part{i}.parquet", ["u", "a", "x"])
    parts = [folder / f"part{i}.parquet" for i in range(len(days))]
    for missing in ("drop", "group"):
        options: dict[str, Any] = {"context": "x", "missing": missing}
        assert outcome(parts, count="n", **options) == outcome(logs, **options)


def frame(day: int, rows: int = 400) -> pd.DataFrame:
    """A day of a log."""
    drawn = np.random.default_rng(day)
    return pd.DataFrame(
        {
            "u": drawn.choice(["yes", "no", "maybe"], rows),
            "a": drawn.choice(["f", "m", ""], rows, p=[0.5, 0.4, 0.1]),
            "age": drawn.integers(10, 90, rows),
            "deserved": drawn.choice(["yes", "no"], rows),
            "points": drawn.integers(0, 50, rows) / 4,
        }
    )


def test_what_is_asked_of_a_log_is_asked_of_its_parts(tmp_path: Path) -> None:
    """Intervals of numbers, true labels, scores, unknown groups and differences, each beside statistical intervals."""
    days = [frame(day) for day in range(3)]
    whole = pd.concat(days)
    parts = [tmp_path / f"{day}.parquet" for day in range(3)]
    for day, part in zip(days, parts, strict=True):
        fa.tally(day, part, ["u", "a", "age", "deserved", "points"], bins={"age": [18, "64.5"]}, count="Anzahl")
    for asked in (
        {"decision": "u", "utility": "yes,maybe=0.5", "context": "age", "missing": "drop", "max_local_ratio": "5/4"},
        {"decision": "u", "utility": "yes", "missing": "unknown", "context": "age", "max_global_ratio": 2},
        {"decision": "u", "utility": "yes", "truth": "deserved", "missing": "group"},
        {"score": "points", "above": "median", "missing": "drop"},
        {"decision": "u", "utility": {"yes": 1, "no": -1}, "context": ["age", "deserved"], "missing": "drop", "difference": True},
    ):
        bins = {"age": [18, "64.5"]} if "age" in str(asked) else None
        expected = fa.audit(whole, group="a", bins=bins, **asked)
        found = fa.audit(parts, group="a", count="Anzahl", **asked)
        assert found.certificate.text == expected.certificate.text
        assert found.sentence == expected.sentence


def test_counts_of_many_days_are_added_up_beyond_machine_integers(tmp_path: Path) -> None:
    part = tmp_path / "part.parquet"
    rows = [("yes", "f", 2**61), ("no", "f", 2**61), ("yes", "m", 2**61), ("no", "m", 5)]
    tally = fa.Tally.of("log", ("u", "a"), rows)
    from fairaudit.tables.engines.tallies import _of_texts, _parquet

    part.write_bytes(b"".join(_parquet(*_of_texts(tally, "n"))))
    twice = tmp_path / "again.parquet"
    twice.write_bytes(part.read_bytes())
    law = fa.audit([part, twice], **ASKED | {"utility": "yes"}, count="n", confidence=None, same_content="accept").law
    assert law.weights.tolist() == [[2**62, 2**62], [10, 2**62]]
    copies = []
    for i in range(5):
        copies.append(tmp_path / f"{i}.parquet")
        copies[-1].write_bytes(part.read_bytes())
    with pytest.raises(fa.InputError, match=r"of range|Overflow"):
        fa.audit(copies, **ASKED | {"utility": "yes"}, count="n", confidence=None, same_content="accept")


def test_one_log_has_one_file(tmp_path: Path) -> None:
    day = frame(1)
    for name, log in (("a", day), ("b", day.sample(frac=1, random_state=2))):
        fa.tally(log, tmp_path / f"{name}.parquet", ["u", "a", "age"])
    assert (tmp_path / "a.parquet").read_bytes() == (tmp_path / "b.parquet").read_bytes()
    day.to_csv(tmp_path / "day.csv", index=False)
    day.to_csv(tmp_path / "turned.csv", columns=["age", "points", "a", "u"], index=False)
    for name in ("day", "turned"):
        fa.tally(tmp_path / f"{name}.csv", tmp_path / f"{name}.parquet", ["u", "a", "age"])
    import pyarrow.parquet as pq

    assert pq.read_table(tmp_path / "day.parquet").equals(pq.read_table(tmp_path / "turned.parquet"))
    (tmp_path / "same.csv").write_bytes((tmp_path / "day.csv").read_bytes())
    fa.tally(tmp_path / "same.csv", tmp_path / "same.parquet", ["u", "a", "age"])
    assert (tmp_path / "day.parquet").read_bytes() == (tmp_path / "same.parquet").read_bytes()


def test_a_statement_has_a_digest_for_each_part_and_the_parts_are_counted_again(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    import hashlib

    parts = [tmp_path / f"{day}.parquet" for day in range(3)]
    for day, part in enumerate(parts):
        fa.tally(frame(day), part, ["u", "a"])
    made, stated = tmp_path / "c.json", tmp_path / "a.json"
    words = ["certify", *map(str, parts[:2]), "--decision", "u", "--group", "a", "--count", "n", "--utility", "yes", "--missing", "drop"]
    assert main([*words, "-o", str(made), "--attest", str(stated)]) == 0
    sources = json.loads(stated.read_text())["predicate"]["sources"]
    assert [(source["name"], source["sha256"]) for source in sources] == [
        (part.name, hashlib.sha256(part.read_bytes()).hexdigest()) for part in parts[:2]
    ]
    capsys.readouterr()
    assert fa.recount(made, stated, parts[:2]).ok
    other = fa.recount(made, stated, [parts[0], parts[2]])
    assert not other.ok and other.difference is not None
    tally = [tmp_path / "both.parquet", tmp_path / "one.parquet"]
    fa.tally(pd.concat([frame(0), frame(1)]), tally[0], ["u", "a"])
    assert fa.audit(tally[0], decision="u", group="a", count="n", utility="yes", missing="drop").certificate.text == made.read_text()


def test_wrong_uses_are_one_sentence(tmp_path: Path) -> None:
    good, cut, other, plain = (tmp_path / f"{name}.parquet" for name in ("good", "cut", "other", "plain"))
    day = frame(0)
    fa.tally(day, good, ["u", "a", "age"])
    fa.tally(day, cut, ["u", "a", "age"], bins={"age": [18]})
    fa.tally(day, other, ["u", "a", "age"], count="m")
    day.assign(n=1, age=day["age"].astype(str)).to_parquet(plain)
    asked: dict[str, Any] = {"decision": "u", "group": "a", "context": "age", "utility": "yes", "missing": "drop"}
    for source, options, said in (
        (good, {}, "is a tally: each of its rows stands for as many decisions as its column 'n' says"),
        (good, {"count": "age", "context": None}, "name that column with count"),
        ([good, cut], {"count": "n"}, "were cut into different intervals before they were counted"),
        ([good, other], {"count": "n"}, "the counts are in column 'n' of"),
        ([good, plain], {"count": "n"}, "is a tally and .* is none"),
        (cut, {"count": "n", "bins": {"age": [18]}}, "column 'age' was cut at 18 before .* was counted; name it without edges"),
        (good, {"count": "n", "unit": "a"}, "unit goes with a log"),
        ([good, good], {"count": "n"}, "twice"),
    ):
        with pytest.raises(fa.InputError, match=said):
            fa.audit(source, **asked | options)
    assert fa.read_log(good, ["u", "n"], count="n").rows > 3
    for columns, options, said in (
        (["u", "a", "n"], {}, "'n' is a column of the log, and would be that of the counts; call them otherwise with count"),
        (["u", "A", "a"], {}, "the columns 'A' and 'a' differ in capitals alone"),
        (["u", "a", "a"], {}, "the column 'a' is named twice"),
        (["u", "b"], {"count": "m"}, "there is no column 'b'"),
        (["u", "a"], {"bins": {"b": [1]}}, "intervals were given for column 'b'"),
    ):
        with pytest.raises(fa.InputError, match=said):
            fa.tally(plain, tmp_path / "new.parquet", columns, **options)
    for name in ("new.csv", "new", "nowhere/new.parquet"):
        with pytest.raises(fa.InputError, match=r"does not end in .parquet|cannot be written"):
            fa.tally(day, tmp_path / name, ["u", "a"])
    assert not (tmp_path / "new.parquet").exists()


def test_whatever_reads_a_tally_or_a_copy_of_it_does_not_take_its_rows_for_decisions(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    part, copy, log = (tmp_path / f"{name}.parquet" for name in ("part", "copy", "log"))
    fa.tally(frame(0), part, ["u", "a"])
    frame(0).to_parquet(log)
    held = pd.read_parquet(part)
    held.to_parquet(copy)
    held.to_csv(tmp_path / "copy.csv", index=False)
    held.to_json(tmp_path / "copy.jsonl", orient="records", lines=True)
    frame(1).to_json(tmp_path / "log.jsonl", orient="records", lines=True)
    with duckdb.connect(str(tmp_path / "copy.db")) as connection:
        connection.execute(f"create table log as from '{part}'")
    with closing(sqlite3.connect(tmp_path / "copy.sqlite")) as lite:
        held.to_sql("log", lite)
    database = {"table": "log"}
    sources: list[tuple[Any, dict[str, Any]]] = [
        (held, {}),
        (held, {"count": "n"}),
        (held.to_dict("list"), {}),
        (held.to_dict("records"), {}),
        (pl.read_parquet(part), {}),
        (pl.scan_parquet(part), {}),
        (pyarrow.parquet.read_table(part), {}),
        (pyarrow.dataset.dataset(part), {}),
        (pyarrow.parquet.read_table(part).to_reader(), {}),
        (duckdb.sql(f"from '{part}'"), {}),
        (copy, {}),
        (copy, {"count": "n"}),
        (tmp_path / "copy.csv", {}),
        (tmp_path / "copy.jsonl", {}),
        ([tmp_path / "log.jsonl", tmp_path / "copy.jsonl"], {}),
        (tmp_path / "copy.jsonl", {"where": ["u=yes"]}),
        (pyarrow.parquet.read_table(part, columns=["u", "a"]), {}),
        (part, {"where": ["u=yes"]}),
        (f"duckdb:{tmp_path / 'copy.db'}", database),
        (f"duckdb:{tmp_path / 'copy.db'}", {"query": "select * from log where a = 'f'"}),
        (f"sqlite:{tmp_path / 'copy.sqlite'}", database),
    ]
    for source, options in sources:
        with pytest.raises(fa.InputError, match="these are counts that fairaudit tally wrote, not a log; give the file itself"):
            fa.audit(source, **ASKED | {"utility": "yes", "missing": "drop"} | options)
    for several in ([log, copy], [copy, log], [log, part], str(tmp_path / "*.parquet")):
        with pytest.raises(fa.InputError, match=r"is a tally and .* is none|counts that fairaudit tally wrote"):
            fa.audit(several, **ASKED | {"utility": "yes"})
    assert main(["inspect", str(part)]) == 2
    assert "is a tally of the columns 'a', 'u'; certify takes it with count (--count n)" in capsys.readouterr().err


def test_a_log_that_holds_counts_is_not_counted_by_rows(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """A table of counts, one row a cell: counted by rows, all groups would be alike."""
    (tmp_path / "cells.csv").write_text("hair;eye;sex;Freq\nred;blue;f;7\nred;brown;f;30\nred;blue;m;10\nred;brown;m;24\n")
    frame_ = pd.read_csv(tmp_path / "cells.csv", sep=";")
    frame_.to_parquet(tmp_path / "cells.parquet")
    new = tmp_path / "new.parquet"
    said = "has a column 'Freq', and a tally counts each row once"
    for source in (tmp_path / "cells.csv", [tmp_path / "cells.parquet"], frame_):
        with pytest.raises(fa.InputError, match=said):
            fa.tally(source, new, ["eye", "sex"], count="freq")
    words = ["--decision", "eye", "--group", "sex", "--count", "Freq"]
    assert main(["tally", str(tmp_path / "cells.csv"), *words, "-o", str(new)]) == 2
    assert said in capsys.readouterr().err
    assert main(["certify", str(tmp_path / "cells.csv"), *words, "--utility", "blue", "--keep", str(new)]) == 2
    assert said in capsys.readouterr().err
    assert not new.exists()
    assert fa.tally(tmp_path / "cells.csv", new, ["eye", "sex"]).rows == 4
    result = fa.audit(tmp_path / "cells.csv", decision="eye", group="sex", count="Freq", utility="blue")
    assert result.global_.ratio == Fraction(10, 34) / Fraction(7, 37)


def test_a_label_that_could_be_two_values_is_refused(tmp_path: Path) -> None:
    numbers, texts_, mixed, none = (tmp_path / f"{name}.parquet" for name in ("numbers", "texts", "mixed", "none"))
    day = pd.DataFrame({"u": ["yes", "no"] * 2, "a": [1, 1, 2, 2]})
    fa.tally(day, numbers, ["u", "a"])
    fa.tally(day.astype({"a": str}), texts_, ["u", "a"])
    fa.tally(day.assign(a=None), none, ["u", "a"])
    options: dict[str, Any] = {**ASKED, "utility": "yes", "count": "n", "missing": "drop"}
    with pytest.raises(fa.InputError, match=r"column 'a' held texts where .*texts.parquet was counted, and numbers or truth values where"):
        fa.audit([numbers, texts_], **options)
    for part in (numbers, texts_):
        assert fa.audit([part, none], **options).law.weights.sum() == 4
    (tmp_path / "log.jsonl").write_text('{"u": "yes", "a": 1}\n{"u": "no", "a": "x"}\n')
    with pytest.raises(fa.InputError, match="column 'a' holds texts as well as numbers"):
        fa.tally(tmp_path / "log.jsonl", mixed, ["u", "a"])


@pytest.mark.parametrize(
    "said",
    [
        "",
        "{}",
        "[]",
        "null",
        "[" * 5000,
        '{"count": 1, "preparation": [], "values": {}}',
        '{"count": "n", "preparation": [1], "values": {}}',
        '{"count": "n", "preparation": [{"step": "left out"}], "values": {}}',
        '{"count": "n", "preparation": [], "values": {"a": "x"}}',
        '{"count": "n", "preparation": [{"step": "intervals", "column": "a", "edges": "18"}], "values": {}}',
    ],
)
def test_what_a_file_says_of_itself_may_be_anything(tmp_path: Path, said: str) -> None:
    path = tmp_path / "part.parquet"
    with duckdb.connect() as connection:
        text = said.replace("'", "''")
        rows = "(values ('yes', 'f', 3), ('no', 'm', 2)) log(u, a, n)"
        connection.execute(f"copy (from {rows}) to '{path}' (format parquet, kv_metadata {{'{KEY}': '{text}'}})")
    with pytest.raises(fa.InputError, match="what this tally says of itself cannot be read"):
        fa.audit(path, **ASKED, count="n")


def test_the_command_goes_on_to_the_next(tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch) -> None:
    import shlex

    monkeypatch.chdir(tmp_path)
    frame(0).rename(columns={"a": "sex, or:1"}).to_csv("log.csv", index=False)
    words = ["tally", "log.csv", "--decision", "u", "--group", '"sex, or:1"', "--context", "age:18,40", "-o", "part.parquet"]
    assert main(words) == 0
    first, _, command = capsys.readouterr().out.strip().split("\n")
    different = frame(0).assign(age=np.digitize(frame(0)["age"], [18, 40])).groupby(["u", "a", "age"]).ngroups
    assert first == f"400 rows, {different} of them different, are counted in part.parquet."
    asked = shlex.split(command.removeprefix("Next: fairaudit ").replace("DECISION", "yes"))
    assert main([*asked, "--missing", "drop", "-o", "part.json"]) == 0
    edges = ["certify", "log.csv", "--decision", "u", "--group", '"sex, or:1"', "--context", "age:18,40", "--utility", "yes"]
    assert main([*edges, "--missing", "drop", "-o", "log.json"]) == 0
    assert Path("part.json").read_bytes() == Path("log.json").read_bytes()
    capsys.readouterr()
    for more, said in (
        (["--unit", "run"], "--unit does not go with tally: rows of one sampling unit may lie in several files; certify the log itself"),
        (["--missing", "drop"], "--missing does not go with tally: a tally keeps missing labels as they are; give it to certify"),
        (["--utility-column", "x"], "--utility-column does not go with tally: a tally counts labels"),
        (["--context", "n", "--count", "N"], "'n' is a column of the log, and would be that of the counts"),
        (["-o", "log.csv"], "log.csv does not end in .parquet"),
    ):
        before = sorted(tmp_path.iterdir())
        assert main([*words, *more]) == 2
        out, err = capsys.readouterr()
        assert out == "" and said in err and err.count("\n") == 1
        assert sorted(tmp_path.iterdir()) == before
