"""Contexts that are read in parts: the certificate is that of the log in memory, byte for byte."""

from __future__ import annotations

import copy
import json
import os
import re
import subprocess
import sys
from collections import Counter
from fractions import Fraction
from math import inf
from pathlib import Path
from typing import Any

import pytest
from envelopes import result_of
from hypothesis import given, settings
from hypothesis import strategies as st
from needs import POSIX

from fairaudit import InputError, Law, audit, certify, checker, tally
from fairaudit.audits.in_parts import certify_in_parts
from fairaudit.certificates.certificate import Certificate
from fairaudit.cli import main
from fairaudit.errors import ManyRowsError
from fairaudit.tables.engines import duckdb
from fairaudit.tables.engines.logs import read_log, read_parts

TEXTS = ["b", "a", "B", "ä", "a b", "10", "9", "\U0001f600", "zz"]


def write(path: Path, columns: dict[str, str], rows: list[tuple[Any, ...]]) -> str:
    """Write a log as Parquet."""
    import duckdb as library

    connection = library.connect()
    connection.execute(f"create table log ({', '.join(f'{name} {kind}' for name, kind in columns.items())})")
    connection.executemany(f"insert into log values ({', '.join('?' * len(columns))})", rows)
    connection.execute(f"copy log to '{path}' (format parquet)")
    connection.close()
    return str(path)


def table_text(certificate: Certificate) -> bytes:
    assert certificate.table is not None
    return b"".join(certificate.table.parts())


def without_cells(document: dict[str, Any]) -> dict[str, Any]:
    """In parts nobody looks whether group and context are independent, nor how far cells may move."""
    return {**document, "claims": [claim for claim in document["claims"] if claim["by"] not in ("T5", "T16")]}


@st.composite
def logs(draw: st.DrawFn) -> tuple[dict[str, str], list[tuple[Any, ...]]]:
    kinds = {"varchar": st.sampled_from(TEXTS), "integer": st.integers(-12, 12), "boolean": st.booleans()}
    first, second = draw(st.sampled_from(sorted(kinds))), draw(st.sampled_from(sorted(kinds)))
    row = st.tuples(st.sampled_from(["yes", "no", "maybe"]), st.sampled_from(["f", "m", "x"]), kinds[first], kinds[second])
    rows = draw(st.lists(row, min_size=4, max_size=40))
    some = draw(st.lists(st.sampled_from(rows), max_size=30))
    return {"u": "varchar", "a": "varchar", "x": first, "y": second}, rows + some


@settings(max_examples=60, deadline=None)
@given(logs(), st.sampled_from([1, 3, 10**6]), st.booleans(), st.sampled_from([None, 0.95]))
def test_the_certificate_is_that_of_the_log_in_memory(
    tmp_path_factory: pytest.TempPathFactory, log: tuple[dict[str, str], list[tuple[Any, ...]]], size: int, both: bool, confidence: Any
) -> None:
    """Ties, missing groups, contexts with one group, labels in any order, with intervals and without; the checker accepts it."""
    path = write(tmp_path_factory.mktemp("parts") / "log.parquet", *log)
    context = ["y", "x"] if both else ["x"]
    utility = {"yes": 2, "maybe": "0.3"}
    asked = {"max_local_ratio": "3/2", "max_global_log": "0.1", "confidence": confidence, "independent": both and confidence is not None}
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(duckdb, "PART", size)
        try:
            law = Law.from_log(read_log(path, ["u", "a", *context]), decision="u", group="a", context=context)
            known = certify(law, utility, **asked)
        except InputError as error:
            with pytest.raises(InputError) as refused:
                certify_in_parts(path, utility, decision="u", group="a", context=context)
            assert str(refused.value) == str(error)
            return
        found = certify_in_parts(path, utility, decision="u", group="a", context=context, **asked)
    assert found.most_unequal() == known.most_unequal()
    assert found.tau == known.tau
    assert (found.sentence, found.notes, found.drivers) == (known.sentence, known.notes, known.drivers)
    written, memory = copy.deepcopy(found.certificate.document), copy.deepcopy(known.certificate.document)
    table = memory["subject"]["table"]
    lines = [table["header"], *table["rows"]]
    canonical = "".join(json.dumps(line, ensure_ascii=True, sort_keys=True, separators=(",", ":")) + "\n" for line in lines)
    assert table_text(found.certificate).decode("ascii") == canonical
    memory["subject"]["table"] = {key: table[key] for key in ("sha256", "cells")}
    assert without_cells(written) == without_cells(memory)
    report = checker.check(found.certificate.text.encode(), iter(table_text(found.certificate).splitlines(keepends=True)))
    assert all(finding.true for finding in report.findings)


@pytest.mark.parametrize("size", [1, 10**6])
def test_labels_that_are_missing_in_several_ways_are_one_level(size: int, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(duckdb, "PART", size)
    kinds = dict.fromkeys("uax", "varchar")
    rows = [("yes", None, "x"), ("yes", "", "x"), ("yes", " ", "x"), ("no", "f", "x"), ("yes", "f", "x")]
    path = write(tmp_path / "log.parquet", kinds, rows)
    found = audit(path, decision="u", group="a", context="x", utility="yes", missing="group", in_parts=True, confidence=None)
    rows_of_table = map(json.loads, table_text(found.certificate).splitlines()[1:])
    assert [(row["group"], row["weights"]) for row in rows_of_table] == [(0, ["0", "3"]), (1, ["1", "1"])]


@pytest.mark.parametrize("n", [1, 3])
def test_a_pair_that_drives_an_end_is_told_with_its_sizes(n: int, tmp_path: Path) -> None:
    """Also one that is not among the most unequal, as none is of 0 against 0."""
    rows = [("yes", "f", 0), ("yes", "f", 0), *[("no", "f", 1)] * n, ("no", "m", 1)]
    path = write(tmp_path / "log.parquet", {"u": "varchar", "a": "varchar", "x": "integer"}, rows)
    found = certify_in_parts(path, {"yes": 1}, decision="u", group="a", context="x", max_local_ratio="3/2", confidence=0.95)
    assert f"(n = 1 and {n})" in found.sentence


@settings(max_examples=20, deadline=None)
@given(
    logs(),
    st.lists(st.integers(0, 3), min_size=70, max_size=70),
    st.sampled_from(["log", "counts", "tallies"]),
    st.sampled_from(["error", "drop", "group"]),
    st.booleans(),
)
def test_counts_and_missing_labels_in_parts_are_those_in_memory(
    tmp_path_factory: pytest.TempPathFactory,
    log: tuple[dict[str, str], list[tuple[Any, ...]]],
    times: list[int],
    form: str,
    missing: str,
    named: bool,
) -> None:
    """Rows that stand for none, labels that only those have, labels of blanks, and one that says it is missing; tallies, too."""
    blanks = [None, "", " \u2003\t"]
    rows = []
    for i, ((u, a, x, y), n) in enumerate(zip(log[1], times, strict=False)):
        lacks = missing != "error"
        seen = [label if label != "zz" or not named else "(missing)" for label in (x, y)]
        empty = blanks[i % 3] if isinstance(y, str) else None
        rows.append((u, blanks[n % 3] if lacks and i % 5 == 4 else a, seen[0], empty if lacks and i % 7 == 3 else seen[1], n))
    folder = tmp_path_factory.mktemp("counts")
    paths: Any = [write(folder / "log.parquet", {**log[0], "n": "integer"}, rows)]
    asked: dict[str, Any] = {"decision": "u", "group": "a", "context": ["x", "y"], "utility": {"yes": 2, "maybe": "0.3", "no": 0}}
    asked |= {"missing": missing, "confidence": None}
    if form == "tallies":
        for part in ("one.parquet", "two.parquet"):
            tally(paths[0], folder / part, ["u", "a", "x", "y"])
        paths = [folder / "one.parquet", folder / "two.parquet"]

    def outcome(*, in_parts: bool) -> Any:
        with pytest.MonkeyPatch.context() as patch:
            patch.setattr(duckdb, "PART", 3)
            try:
                found = audit(paths, **asked, in_parts=in_parts, count=None if form == "log" else "n")
            except InputError as error:
                return str(error).rpartition(": ")[2].partition(" (")[0]
        document = copy.deepcopy(found.certificate.document)
        document["subject"]["table"] = document["subject"]["table"]["sha256"]
        notes = [note for note in found.notes if "label" in note]
        return without_cells(document), found.law.preparation, found.most_unequal(2), notes

    found, known = outcome(in_parts=True), outcome(in_parts=False)
    assert found == known


@settings(max_examples=30, deadline=None)
@given(logs(), st.sampled_from([1, 2, 5]))
def test_parts_are_the_log(tmp_path_factory: pytest.TempPathFactory, log: tuple[dict[str, str], list[tuple[Any, ...]]], size: int) -> None:
    """Every row is in exactly one part, and the rows of a context are together."""
    path = write(tmp_path_factory.mktemp("parts") / "log.parquet", *log)
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(duckdb, "PART", size)
        whole, *parts = read_parts(path, ["u", "a", "x", "y"], ["x", "y"])
    rows = [Counter(dict(zip(zip(*map(part.__getitem__, "uaxy"), strict=True), part.counts.tolist(), strict=True))) for part in parts]
    assert sum(rows, Counter()) == Counter(log[1])
    contexts = [{(x, y) for _, _, x, y in part} for part in rows]
    assert sum(map(len, contexts)) == len(set.union(*contexts))
    marginal = dict(zip(zip(whole["u"], whole["a"], strict=True), whole.counts.tolist(), strict=True))
    assert marginal == Counter((u, a) for u, a, _, _ in log[1])


ROWS = [(u, a, x) for x in range(40) for a in "fm" for u in ("yes", "no") for _ in range(1 + (x * 7 + (a == "f") * 3 + (u == "no")) % 5)]
COLUMNS = ["--decision", "u", "--group", "a", "--context", "x", "--utility", "yes"]


@pytest.fixture
def parquet(tmp_path: Path) -> str:
    return write(tmp_path / "log.parquet", {"u": "varchar", "a": "varchar", "x": "integer"}, ROWS)


def test_the_command_line(parquet: str, tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch) -> None:
    """By option, and by itself when there are many different rows; databases, intervals of numbers, and a table that is not disclosed."""
    import duckdb as library

    monkeypatch.setattr(duckdb, "PART", 30)
    paths = {name: str(tmp_path / f"{name}.json") for name in ("memory", "parts", "many", "database", "salted")}
    exact = ["--confidence", "none", "--max-local-ratio", "9"]
    assert main(["certify", parquet, *COLUMNS, *exact, "-o", paths["memory"]]) == 0
    assert main(["certify", parquet, *COLUMNS, *exact, "-o", paths["parts"], "--in-parts", "--memory", "100MB"]) == 0
    with library.connect(str(tmp_path / "log.duckdb")) as connection:
        connection.execute(f"create table log as from '{parquet}'")
    database = [f"duckdb:{tmp_path / 'log.duckdb'}", "--table", "log"]
    assert main(["certify", *database, *COLUMNS, *exact, "-o", paths["database"], "--in-parts"]) == 0
    monkeypatch.setattr("fairaudit.audits.reading.MOST_ROWS", 100)
    assert main(["certify", parquet, *COLUMNS, *exact, "-o", paths["many"]]) == 0
    parts = Path(paths["parts"]).read_bytes()
    assert parts == Path(paths["many"]).read_bytes() == Path(paths["database"]).read_bytes()
    memory = json.loads(Path(paths["memory"]).read_text())
    assert json.loads(parts)["subject"]["table"]["sha256"] == memory["subject"]["table"]["sha256"]
    assert main(["certify", parquet, *COLUMNS, *exact, "--no-table", "-o", paths["salted"]]) == 0
    for name in ("parts", "salted"):
        assert main(["verify", paths[name], "--table", paths[name].replace(".json", ".table.jsonl"), "--require", "within"]) == 0
    assert json.loads(Path(paths["salted"]).read_text())["subject"]["table"]["sha256"] != memory["subject"]["table"]["sha256"]
    capsys.readouterr()
    for more in ([], ["--interval", "intersection"]):
        asked = ["certify", parquet, *COLUMNS, "--max-local-ratio", "9", *more, "-o"]
        monkeypatch.setattr("fairaudit.audits.reading.MOST_ROWS", 10**6)
        capsys.readouterr()
        code = main([*asked, paths["memory"]])
        screen = capsys.readouterr().out.replace("memory.json", "parts.json")
        monkeypatch.setattr("fairaudit.audits.reading.MOST_ROWS", 100)
        assert main([*asked, paths["parts"]]) == code
        assert capsys.readouterr().out.replace(f" --table {paths['parts'].replace('.json', '.table.jsonl')}", "") == screen
        documents = [json.loads(Path(paths[name]).read_text()) for name in ("memory", "parts")]
        assert documents[0]["intervals"] == documents[1]["intervals"]
        assert main(["verify", paths["parts"], "--table", paths["parts"].replace(".json", ".table.jsonl")]) == 0
    monkeypatch.setattr("fairaudit.audits.in_parts.MOST_CELLS", 79)
    capsys.readouterr()
    assert main(["certify", parquet, *COLUMNS, "--max-local-ratio", "9"]) == 3
    out, err = capsys.readouterr()
    assert "INCONCLUSIVE" in out
    assert "no interval for the local ratio is claimed: it needs the draws of 80 cells; of 79 they are held" in err
    assert main(["certify", parquet, *COLUMNS[:4], "--context", "x:10,20", "--utility", "yes", "--in-parts", "--format", "json"]) == 0
    assert result_of(capsys.readouterr().out)["subject"]["table"]["cells"] == 12


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["--unit", "u"], "--in-parts does not go with --unit"),
        (["--probability", "y"], "--in-parts does not go with --probability"),
        (["--missing-units", "drop"], "--in-parts does not go with --missing-units"),
        (["--confidence", "none", "--independent-cells"], "(--interval, --independent-cells) are about the population; give a confidence"),
        (["--no-table", "--max-local-ratio", "2"], "the ends of intervals would disclose the counts of a certificate without its table"),
        (["--missing", "unknown"], "--in-parts does not go with --missing"),
        (["--context", "z", "--missing", "drop", "--group", "w"], "every row has a missing label; nothing is left to audit"),
        (["--count", "y"], "column 'y' holds DOUBLE; counts of contexts that are read in parts are whole numbers"),
        (["--count", "v"], "column 'v': -1 is negative; numbers of at least 0 are accepted"),
        (["--count", "x"], "the column 'x' is used twice"),
        (["--engine", "python"], "--in-parts does not go with --engine python"),
        (["--utility-range", "0,1"], "--in-parts does not go with --utility-range"),
        (["--context", "y"], "column 'y' holds DOUBLE; contexts that are read in parts are texts, whole numbers, or cut into intervals"),
        (["--context", "absent"], "there is no column 'absent'"),
        (["--group", "x"], "the column 'x' is used twice"),
        (["--group", "z"], "the label is missing"),
        (["--context", "z"], "the label is missing"),
        (["--utility", "perhaps"], "perhaps"),
        (["--max-local-ratio", "0"], "a ratio above 0 is accepted"),
    ],
)
def test_what_is_not_read_in_parts(tmp_path: Path, capsys: pytest.CaptureFixture[str], words: list[str], said: str) -> None:
    """One sentence, and no file."""
    kinds = {"u": "varchar", "a": "varchar", "x": "integer", "y": "double", "z": "varchar", "w": "varchar", "v": "bigint"}
    rows = [(u, a, x, x / 2, None if x == 3 else "z", "\t\u2003", -1 if x == 5 else x) for u, a, x in ROWS]
    path = write(tmp_path / "log.parquet", kinds, rows)
    target = tmp_path / "c.json"
    assert main(["certify", path, *COLUMNS, "--in-parts", "-o", str(target), *words]) == 2
    out, err = capsys.readouterr()
    assert said in err and err.count("\n") == 1 and not out
    assert [part.name for part in tmp_path.iterdir()] == ["log.parquet"]


def test_logs_that_are_not_read_in_parts(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (tmp_path / "log.csv").write_text("u,a,x\nyes,f,1\nno,m,1\n")
    for source, said in (
        (str(tmp_path / "log.csv"), "is no Parquet file"),
        ("sqlite:log.db", "no such file"),
        ("nowhere.parquet", "no such file"),
    ):
        assert main(["certify", source, *COLUMNS, "--in-parts"]) == 2
        assert said in capsys.readouterr().err
    assert main(["certify", str(tmp_path / "log.csv"), "--slots", "a", "--winner", "u", "--in-parts"]) == 2
    assert "--in-parts does not go with --slots" in capsys.readouterr().err
    assert main(["certify", "--from-monitor", str(tmp_path / "state.db"), "--in-parts"]) == 2
    assert "--in-parts was settled" in capsys.readouterr().err
    assert main(["certify", str(tmp_path / "log.csv"), *COLUMNS[:4], "--utility", "yes", "--in-parts"]) == 2
    assert "--in-parts does not go with a log without --context" in capsys.readouterr().err


def test_many_rows_that_have_no_parts_are_read_all_the_same(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    """Dates have no order of texts that DuckDB and labels are known to share, so they come into memory however many they are."""
    rows = [(u, a, f"2026-01-{1 + x % 28:02}") for u, a, x in ROWS]
    path = write(tmp_path / "log.parquet", {"u": "varchar", "a": "varchar", "x": "date"}, rows)
    monkeypatch.setattr("fairaudit.audits.reading.MOST_ROWS", 10)
    assert main(["certify", path, *COLUMNS]) == 0
    assert "in the population" in capsys.readouterr().out


def test_the_screen_lists_each_context_once_in_input_order(parquet: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["certify", parquet, *COLUMNS, "--in-parts"]) == 0
    told = capsys.readouterr().out
    rates: dict[str, dict[str, list[int]]] = {}
    for u, a, x in ROWS:
        pair = rates.setdefault(str(x), {}).setdefault(a, [0, 0])
        pair[0] += u == "yes"
        pair[1] += 1
    apart = {}
    for x, own in rates.items():
        values = [Fraction(*pair) for pair in own.values()]
        apart[x] = max(values) / min(values) if min(values) else inf
    shown = re.findall(r"^(\S+) +(infinite|[\d.]+)  \S+ [\d.]+ %", told, re.MULTILINE)
    assert len(shown) > 1 and len({x for x, _ in shown}) == len(shown)
    assert [float(ratio.replace("infinite", "inf")) for _, ratio in shown] == pytest.approx([float(apart[x]) for x, _ in shown], rel=0.01)
    assert [apart[x] for x, _ in shown] == sorted(apart.values(), reverse=True)[: len(shown)]


def test_at_least_one_pair_is_kept(parquet: str) -> None:
    """The figures themselves are the first of what is kept."""
    with pytest.raises(InputError, match="at least 1"):
        certify_in_parts(parquet, {"yes": 1}, decision="u", group="a", context="x", top=0)


def test_more_rows_than_were_asked_for(parquet: str) -> None:
    assert len(read_log(parquet, ["u", "a", "x"], most=160)) == 160
    with pytest.raises(ManyRowsError, match="160 different rows, more than 159"):
        read_log(parquet, ["u", "a", "x"], most=159)


@POSIX
def test_a_full_disk_leaves_nothing(tmp_path: Path) -> None:
    """The table does not fit into the directory for temporary files."""
    resource = pytest.importorskip("resource")
    path = write(tmp_path / "log.parquet", {"u": "varchar", "a": "varchar", "x": "integer"}, [(u, a, x * 1000) for u, a, x in ROWS])
    ended = subprocess.run(
        [sys.executable, "-m", "fairaudit", "certify", path, *COLUMNS, "--in-parts", "-o", str(tmp_path / "c.json")],
        capture_output=True,
        env={**os.environ, "PYTHONDONTWRITEBYTECODE": "1"},
        preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_FSIZE, (1_024, 1_024)),
        check=False,
    )
    assert ended.returncode == 2, ended.stderr
    assert b"Traceback" not in ended.stderr
    assert b"cannot be written" in ended.stderr
    assert [part.name for part in tmp_path.iterdir()] == ["log.parquet"]
