"""`audit` does in one call what `fairaudit certify` does: the same certificate, byte for byte, whatever holds the table."""

from __future__ import annotations

import json
import sqlite3
from pathlib import Path
from typing import Any

import pandas as pd
import polars as pl
import pyarrow as pa
import pytest

import fairaudit as fa
from fairaudit.cli import main

LOG = {
    "answer": ["yes", "no", "Yes", "no", "yes", "no", "yes", "yes", "no", "no"] * 30,
    "sex": ["f", "f", "f", "m", "m", "m", "f", "m", "f", "m"] * 30,
    "age": [17, 30, 44, 70, 18, 65, 33, 20, 19, 90] * 30,
    "dept": ["a", "b"] * 150,
    "fit": ["yes", "no", "no", "yes", "yes"] * 60,
    "who": [str(i // 2) for i in range(300)],
}
COUNTS = {"hired": ["yes", "no", "yes", "no"], "sex": ["f", "f", "m", "m"], "n": [300, 100, 200, 200]}
POLICY = {"u": ["hire", "pass"] * 2, "sex": ["f", "f", "m", "m"], "p": ["0.9", "0.1", "0.2", "0.8"], "w": [1, 1, 3, 3]}

CASES: dict[str, tuple[list[str], dict[str, Any]]] = {
    "plain": (["--utility", "yes"], {"utility": {"yes": 1}, "fold": False}),
    "labels merged": (["--utility", "yes", "--fold-labels"], {"utility": "yes", "fold_labels": True}),
    "intervals": (["--context", "age:18,65", "--utility", "yes"], {"context": "age", "bins": {"age": [18, 65]}, "utility": "yes"}),
    "truth": (["--utility", "yes", "--fold-labels", "--truth", "fit"], {"utility": "yes", "fold_labels": True, "truth": "fit"}),
    "units": (["--utility", "yes", "--unit", "who"], {"utility": "yes", "unit": "who"}),
    "targets": (
        ["--utility", "yes=2,no=1", "--max-local-ratio", "0.8", "--max-global-log", "0.2", "--confidence", "0.9", "--independent-cells"],
        {"utility": "yes=2,no=1", "max_local_ratio": 0.8, "max_global_log": "0.2", "confidence": 0.9, "independent": True},
    ),
    "method": (
        ["--utility", "yes=1,Yes=1/2", "--interval", "intersection", "--utility-range", "0,2", "--burden"],
        {"utility": "yes=1,Yes=1/2", "interval": "intersection", "declared": {"m": 0, "gamma": 2}, "burden": True},
    ),
    "the table itself": (["--utility", "yes", "--confidence", "none"], {"utility": "yes", "confidence": None}),
}


def by_command(folder: Path, *options: str) -> str:
    path = folder / "by-command.json"
    assert main(["certify", *options, "-o", str(path)]) in (0, 1, 3)
    return path.read_text("ascii")


@pytest.fixture
def log(tmp_path: Path) -> Path:
    pd.DataFrame(LOG).to_csv(tmp_path / "log.csv", index=False)
    return tmp_path / "log.csv"


@pytest.mark.parametrize("case", CASES)
def test_it_writes_what_the_command_writes(case: str, log: Path) -> None:
    options, asked = CASES[case]
    asked = {"decision": "answer", "group": "sex", "context": "dept", **asked}
    asked.pop("fold", None)
    given = [] if "--context" in options else ["--context", "dept"]
    wanted = by_command(log.parent, str(log), "--decision", "answer", "--group", "sex", *given, *options)
    frame = pd.DataFrame(LOG)
    for table in (str(log), log, [log], LOG, frame, pl.from_pandas(frame), pl.from_pandas(frame).lazy(), pa.Table.from_pandas(frame)):
        assert fa.audit(table, **asked).certificate.text == wanted, type(table)


@pytest.mark.parametrize("kind", ["mapping", "pandas", "polars", "arrow", "csv"])
def test_tables_of_counts_and_probabilities(kind: str, tmp_path: Path) -> None:
    for name, columns, options in (
        ("counts", COUNTS, {"decision": "hired", "count": "n", "utility": "yes"}),
        ("policy", POLICY, {"decision": "u", "probability": "p", "weight": "w", "utility": "hire"}),
    ):
        frame = pd.DataFrame(columns)
        frame.to_csv(tmp_path / f"{name}.csv", index=False)
        as_options = [word for key, value in options.items() for word in (f"--{key}", value)]
        wanted = by_command(tmp_path, str(tmp_path / f"{name}.csv"), "--group", "sex", *as_options)
        table = {
            "mapping": columns,
            "pandas": frame,
            "polars": pl.from_pandas(frame),
            "arrow": pa.Table.from_pandas(frame),
            "csv": tmp_path / f"{name}.csv",
        }[kind]
        assert fa.audit(table, group="sex", **options).certificate.text == wanted


def test_databases_files_in_parts_and_audit_files(log: Path) -> None:
    folder = log.parent
    with sqlite3.connect(folder / "log.db") as database:
        pd.DataFrame(LOG).to_sql("log", database, index=False)
    database.close()
    pd.DataFrame(LOG).to_parquet(folder / "log.parquet")
    asked: dict[str, Any] = {"decision": "answer", "group": "sex", "context": "dept", "utility": "yes"}
    named = ["--decision", "answer", "--group", "sex", "--context", "dept", "--utility", "yes"]
    whole = fa.audit(log, **asked).certificate.text
    assert fa.audit(f"sqlite:{folder}/log.db", table="log", **asked).certificate.text == whole
    assert fa.audit(f"sqlite:{folder}/log.db", query="select * from log", **asked).certificate.text == whole
    parts = fa.audit(folder / "log.parquet", **asked, in_parts=True)
    assert parts.partial is not None
    assert parts.certificate.save(folder / "parts.json")
    assert (folder / "parts.json").read_text("ascii") == by_command(folder, str(folder / "log.parquet"), *named, "--in-parts")
    file = fa.example("hr-filtered").path
    assert fa.audit(file).certificate.text == by_command(folder, file)
    assert fa.audit(file, max_local_ratio=2).targets[0].limit == 2
    with pytest.raises(fa.InputError, match=r"^decision goes with a table; the audit file .* says it itself$"):
        fa.audit(file, decision="chosen")


def test_more_rows_than_are_held_pass_by_in_parts(log: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    pd.DataFrame(LOG).to_parquet(log.parent / "log.parquet")
    monkeypatch.setattr("fairaudit.audits.from_table.MOST_ROWS", 5)
    asked: dict[str, Any] = {"decision": "answer", "group": "sex", "context": "dept", "utility": "yes"}
    assert fa.audit(log.parent / "log.parquet", **asked).partial is not None
    assert fa.audit(log.parent / "log.parquet", **asked, fold_labels=True).partial is None


def test_a_policy_behind_filters() -> None:
    coin = fa.RandomizedResponse(["f", "m"], keep_probability="0.75")
    asked: dict[str, Any] = {"decision": "u", "group": "sex", "probability": "p", "utility": "hire"}
    law = fa.Law.from_probabilities(POLICY, decision="u", group="sex", probability="p")
    wanted = fa.certify(fa.Policy(law).behind(group=coin), {"hire": 1}).certificate.text
    assert fa.audit(POLICY, **asked, group_filter=coin).certificate.text == wanted
    assert fa.audit(law, utility="hire", group_filter=coin).certificate.text == wanted
    assert fa.audit(fa.Policy(law).behind(group=coin), utility="hire").certificate.text == wanted
    assert fa.audit(law, utility="hire").certificate.text == fa.certify(law, {"hire": 1}).certificate.text
    with pytest.raises(fa.InputError, match="go with group_filter"):
        fa.audit(law, utility="hire", context_filter=coin)
    with pytest.raises(fa.InputError, match="a Deployment has its filters"):
        fa.audit(fa.Policy(law).behind(group=coin), utility="hire", group_filter=coin)


@pytest.mark.parametrize(
    ("table", "asked", "said"),
    [
        (COUNTS, {"group": "sex", "utility": "yes"}, "no decision column was named; give decision"),
        (COUNTS, {"decision": "hired", "utility": "yes"}, "no group column was named; give group"),
        (COUNTS, {"decision": "hired", "group": "sex"}, "no utility was given; give utility"),
        (COUNTS, {"decision": "hired", "group": "sexx", "utility": "yes"}, "there is no column 'sexx'"),
        (COUNTS, {"decision": "hired", "group": "sex", "utility": "hired=1=2"}, "'1=2' is not a number"),
        (COUNTS, {"decision": "hired", "group": "sex", "utility": "yess", "count": "n"}, "which does not occur"),
        (COUNTS, {"decision": "hired", "group": "sex", "utility": "yes", "count": "n", "probability": "n"}, "count and probability"),
        (COUNTS, {"decision": "hired", "group": "sex", "utility": "yes", "weight": "n"}, "weight goes with probability"),
        (COUNTS, {"decision": "hired", "group": "sex", "utility": "yes", "count": "n", "unit": "n"}, "unit goes with a log"),
        (COUNTS, {"decision": "hired", "group": "sex", "utility": "yes", "count": "n", "bins": {"n": [1]}}, "go with a log"),
        (COUNTS, {"decision": "hired", "group": "sex", "utility": "yes", "table": "t"}, "table and query go with a database"),
        (COUNTS, {"decision": "hired", "group": "sex", "utility": "yes", "in_parts": True, "context": "n"}, "a table in memory"),
        (COUNTS, {"decision": "hired", "group": "sex", "utility": "yes", "bins": {"hired": [1]}}, "intervals need numbers"),
        (POLICY, {"decision": "u", "group": "sex", "utility": "hire", "probability": "p", "confidence": 0.95}, "needs counts or a log"),
        (POLICY, {"decision": "u", "group": "sex", "utility": "hire", "probability": "p", "independent": True}, "needs counts or a log"),
        (POLICY, {"decision": "u", "group": "sex", "utility": "hire", "probability": "p", "truth": "w"}, "truth goes with counts"),
        (
            {**COUNTS, "n": [0.5, 1, 2, 3]},
            {"decision": "hired", "group": "sex", "utility": "yes", "count": "n", "confidence": 0.9},
            "whole",
        ),
        (3, {"decision": "hired", "group": "sex", "utility": "yes"}, "a table cannot be read from an int"),
        ("no-such.csv", {"decision": "hired", "group": "sex", "utility": "yes"}, "no-such.csv: there is no such file"),
        (COUNTS, {"decision": "hired", "group": "sex", "utility": "yes", "max_local": 2}, "max_local is not accepted"),
    ],
)
def test_refusals_are_one_sentence_in_the_words_of_python(table: Any, asked: dict[str, Any], said: str) -> None:
    with pytest.raises(fa.InputError) as error:
        fa.audit(table, **asked)
    assert said in str(error.value)
    assert "--" not in str(error.value).replace("(--confidence none)", "")
    assert "\n" not in str(error.value)


def test_the_default_confidence_asks_for_nothing() -> None:
    assert fa.audit(POLICY, decision="u", group="sex", probability="p", utility="hire").intervals == {}
    weighted = {**COUNTS, "n": [0.5, 1, 2, 3]}
    assert fa.audit(weighted, decision="hired", group="sex", count="n", utility="yes").intervals == {}
    assert json.loads(fa.audit(COUNTS, decision="hired", group="sex", count="n", utility="yes").certificate.text)["intervals"]


def test_a_log_of_nested_rows_is_audited_by_paths(tmp_path: Path) -> None:
    rows = [{"id": n, "out": {"text": f"I say {'yes' if n % 3 else 'no'}"}, "who": {"sex": "fm"[n % 2]}, "f": 1} for n in range(60)]
    log = tmp_path / "log.jsonl"
    log.write_text("".join(json.dumps(row) + "\n" for row in rows))
    asked: dict[str, Any] = {"decision": "out.text", "group": "who.sex", "utility": "yes", "extract": r"say (yes|no)"}
    result = fa.audit(log, **asked)
    flat = {"out.text": ["yes" if n % 3 else "no" for n in range(60)], "who.sex": ["fm"[n % 2] for n in range(60)]}
    expected = fa.audit(flat, decision="out.text", group="who.sex", utility="yes")
    assert result.local == expected.local
    (tmp_path / "AUDIT.toml").write_text(
        '[law]\ntable = "log.jsonl"\ndecision = "out.text"\ngroup = "who.sex"\nextract = "say (yes|no)"\nwhere = { f = "1" }\n'
        "[utility]\nvalues = { yes = 1 }\n"
    )
    assert fa.audit(tmp_path / "AUDIT.toml").local.ratio == expected.local.ratio
    worded: dict[str, Any] = {**asked, "extract": r"I say (.*)", "options": ["yes", "no"]}
    assert fa.audit(log, **worded).local == expected.local
    for options in ('"yes,no"', '["yes", "no"]'):
        (tmp_path / "WORDS.toml").write_text(
            f'[law]\ntable = "log.jsonl"\ndecision = "out.text"\ngroup = "who.sex"\nextract = "I say (.*)"\noptions = {options}\n'
            "[utility]\nvalues = { yes = 1 }\n"
        )
        assert fa.audit(tmp_path / "WORDS.toml").local.ratio == expected.local.ratio
    with pytest.raises(fa.InputError, match=r"extract .*goes with logs of evaluations"):
        fa.audit(flat, **asked)
    with pytest.raises(fa.InputError, match=r"errors"):
        fa.audit(log, **asked, errors="ignore")  # type: ignore[arg-type]


def test_conditions_do_not_go_where_no_certificate_would_say_them(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    rows = [{"c": {"both": "x y", "won": "xy"[n % 2]}, "d": ["yes", "no"][n % 3 % 2], "g": "fm"[n % 2], "n": 2, "f": 1} for n in range(40)]
    log = tmp_path / "log.jsonl"
    log.write_text("".join(json.dumps(row) + "\n" for row in rows))
    for counts in ("count", "probability"):
        with pytest.raises(fa.InputError, match=f"{counts} goes with a table of counts or probabilities"):
            fa.audit(log, decision="d", group="g", **{counts: "n"}, utility="yes", where="f=1")  # type: ignore[arg-type]
    assert main(["certify", str(log), "--slots", "c.both", "--winner", "c.won", "--where", "f=1"]) == 2
    assert "--slots goes with a log of choices" in capsys.readouterr().err
