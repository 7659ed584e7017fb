"""Folders whose own log says which files count: their files are refused, and Delta tables are read by their library."""

from __future__ import annotations

import json
import os
from pathlib import Path
from typing import Any

import pytest
from envelopes import result_of

from fairaudit import InputError, read_log
from fairaudit.audits.in_parts import certify_in_parts
from fairaudit.cli import main
from fairaudit.tables.engines.logs import survey_log

COMMAND = ("--decision", "answer", "--group", "sex", "--utility", "yes", "--confidence", "none")


def run(*words: Any) -> int:
    return main([str(word) for word in words])


def rows(count: int) -> Any:
    import pyarrow as pa

    return pa.table(
        {
            "answer": ["yes" if i % 3 else "no" for i in range(count)],
            "sex": ["f" if i % 2 else "m" for i in range(count)],
            "year": ["2024" if i % 5 else "2025" for i in range(count)],
        }
    )


@pytest.fixture
def delta(tmp_path: Path) -> Path:
    """A table of 10 rows, after 200 others were replaced: their files are still there."""
    deltalake = pytest.importorskip("deltalake")
    folder = tmp_path / "decisions"
    deltalake.write_deltalake(folder, rows(200))
    deltalake.write_deltalake(folder, rows(10), mode="overwrite")
    assert len(list(folder.glob("*.parquet"))) == 2
    return folder


def iceberg(folder: Path) -> Path:
    import pyarrow.parquet as pq

    (folder / "metadata").mkdir(parents=True)
    (folder / "metadata" / "00001-2f.metadata.json").write_text("{}")
    (folder / "data" / "year=2024").mkdir(parents=True)
    pq.write_table(rows(10), folder / "data" / "year=2024" / "a.parquet")
    return folder


def hudi(folder: Path) -> Path:
    import pyarrow.parquet as pq

    (folder / ".hoodie").mkdir(parents=True)
    (folder / "2024").mkdir()
    pq.write_table(rows(10), folder / "2024" / "a.parquet")
    return folder


@pytest.mark.parametrize("engine", ["auto", "duckdb"])
def test_files_of_a_delta_table_are_refused(delta: Path, engine: str, capsys: pytest.CaptureFixture[str]) -> None:
    one = next(delta.glob("*.parquet"))
    for source in (delta / "*.parquet", delta.parent / "*" / "*.parquet", delta.parent / "**" / "*.parquet", one):
        for command in (
            ("certify", source, *COMMAND),
            ("inspect", source),
            ("certify", source, *COMMAND, "--context", "year", "--in-parts"),
        ):
            assert run(*command, "--engine", engine) == 2
            out, err = capsys.readouterr()
            assert out == "" and err.count("\n") == 1 and "Delta table" in err and f"delta:{delta}" in err
        with pytest.raises(InputError, match="Delta table"):
            read_log(str(source), ["answer"], engine=engine)
        with pytest.raises(InputError, match="Delta table"):
            survey_log(str(source), engine=engine)
        with pytest.raises(InputError, match="Delta table"):
            certify_in_parts(str(source), {"yes": 1}, decision="answer", group="sex", context="year")


def test_spark_refuses_them_too(delta: Path, capsys: pytest.CaptureFixture[str]) -> None:
    pytest.importorskip("pyspark")
    if not any((Path(folder) / "java").exists() for folder in os.get_exec_path()):
        pytest.skip("Spark needs Java")
    for source in (delta / "*.parquet", delta / "**" / "*.parquet"):
        assert run("certify", source, *COMMAND, "--engine", "spark") == 2
        out, err = capsys.readouterr()
        assert out == "" and err.count("\n") == 1 and "a Delta table" in err, err


@pytest.mark.parametrize(("make", "name"), [(iceberg, "an Iceberg table"), (hudi, "a Hudi table")])
def test_other_formats_are_refused(make: Any, name: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    folder = make(tmp_path / "decisions")
    link = tmp_path / "link.parquet"
    link.symlink_to(next(folder.rglob("*.parquet")))
    for source in (folder / "**" / "*.parquet", link, folder, next(folder.rglob("*.parquet")).parent):
        assert run("certify", source, *COMMAND) == 2
        out, err = capsys.readouterr()
        assert out == "" and err.count("\n") == 1 and name in err and "read_log" in err


def test_the_message_for_a_folder_proposes_what_can_be_read(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    import pyarrow.parquet as pq

    nested = tmp_path / "year=2024"
    nested.mkdir()
    pq.write_table(rows(10), nested / "a.parquet")
    assert run("certify", tmp_path, *COMMAND) == 2
    assert f"{tmp_path}/**/*.parquet" in capsys.readouterr().err
    assert run("certify", f"{tmp_path}/**/*.parquet", *COMMAND) == 0


@pytest.mark.parametrize("partitions", [[], ["year"], ["year", "sex"]])
def test_a_delta_table_is_read_as_it_stands_now(partitions: list[str], tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """Replaced, deleted and appended rows and partitions, against the same rows as a frame."""
    deltalake = pytest.importorskip("deltalake")
    folder = tmp_path / "decisions"
    deltalake.write_deltalake(folder, rows(200), partition_by=partitions or None)
    table = deltalake.DeltaTable(folder)
    table.delete("year = '2025' and answer = 'no'")
    table.update(updates={"sex": "'x'"}, predicate="answer = 'no' and sex = 'm'")
    deltalake.write_deltalake(folder, rows(7), mode="append")
    kept = deltalake.DeltaTable(folder).to_pyarrow_table()
    assert kept.num_rows < 207
    expected = sorted(zip(*(kept[name].to_pylist() for name in ("answer", "sex", "year")), strict=True))
    for source in (folder, f"delta:{folder}"):
        tally = read_log(source, ["answer", "sex", "year"])
        found = zip(tally["answer"], tally["sex"], tally["year"], tally.counts.tolist(), strict=True)
        assert sorted(row for *row, n in found for _ in range(n)) == [[*row] for row in expected]
        assert survey_log(source).rows == kept.num_rows
        assert run("certify", source, *COMMAND, "--format", "json") == 0
        weights = result_of(capsys.readouterr().out)["subject"]["table"]["rows"]
        assert sum(int(w) for row in weights for w in row["weights"]) == kept.num_rows
        assert run("inspect", source) == 0
        assert f"{kept.num_rows} rows" in capsys.readouterr().out


def test_what_a_delta_reader_does_not_know_is_refused(delta: Path, capsys: pytest.CaptureFixture[str]) -> None:
    log = delta / "_delta_log"
    last = sorted(log.glob("*.json"))[-1]
    written = [json.loads(line) for line in last.read_text().splitlines()]
    for feature in ("deletionVectors", "columnMapping"):
        protocol = {"minReaderVersion": 3, "minWriterVersion": 7, "readerFeatures": [feature], "writerFeatures": [feature]}
        last.write_text("\n".join(map(json.dumps, [*written, {"protocol": protocol}])) + "\n")
        assert run("certify", delta, *COMMAND) == 2
        out, err = capsys.readouterr()
        assert out == "" and err.count("\n") == 1 and "cannot be read" in err
    first = sorted(log.glob("*.json"))[0]
    metadata = next(json.loads(line)["metaData"] for line in first.read_text().splitlines() if "metaData" in line)
    schema = json.loads(metadata["schemaString"])
    for number, field in enumerate(schema["fields"], 1):
        field["metadata"] = {"delta.columnMapping.id": number, "delta.columnMapping.physicalName": f"col-{number}"}
    metadata["schemaString"] = json.dumps(schema)
    metadata["configuration"] = {"delta.columnMapping.mode": "name"}
    changed = [{"protocol": {"minReaderVersion": 2, "minWriterVersion": 5}}, {"metaData": metadata}]
    last.write_text("\n".join(map(json.dumps, [*written, *changed])) + "\n")
    assert run("certify", delta, *COMMAND) == 2
    assert "maps the names of its columns" in capsys.readouterr().err


def test_other_words_for_a_delta_table(delta: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    for words, said in (
        ([f"delta:{tmp_path}"], "this is no Delta table"),
        ([f"delta:{tmp_path}/none"], "this is no Delta table"),
        ([delta, "--engine", "duckdb"], "read on its own"),
        ([delta, delta], "named twice"),
        ([delta, "--table", "t"], "goes with a database"),
    ):
        assert run("certify", *words, *COMMAND) == 2
        out, err = capsys.readouterr()
        assert out == "" and err.count("\n") == 1 and said in err, (words, err)
