"""Scores are cut in two at a number or at their own median: exactly, the same by whatever reads them, and as the checker can see."""

from __future__ import annotations

import copy
import csv
import json
import sqlite3
from collections import Counter
from fractions import Fraction
from pathlib import Path
from statistics import median
from typing import Any

import pytest
from certificate_changes import named_anew
from certificates import outcome
from hypothesis import given, settings
from hypothesis import strategies as st
from jsonschema import Draft202012Validator

import fairaudit as fa
from fairaudit import checker
from fairaudit.audits.reading import Reading, read_law
from fairaudit.certificates.certificate import schema
from fairaudit.cli import main
from fairaudit.tables import scores
from fairaudit.tables.scores import cut_scores, score_cut

SCHEMA = Draft202012Validator(schema())

SCORES = [
    "-3",
    "0",
    "0.1",
    "0.10",
    "1/3",
    "1e-3",
    "7",
    "7.0",
    "64.5",
    "9007199254740993",
    "9007199254740992",
    "9007199254740993.5",
    "1e400",
]

# Selection above the median in the example of 6 RCNY 5-301: 84 of 168 applicants, by sex.
EXAMPLE = {"Male": (92, 50), "Female": (76, 34)}


def run(*words: Any) -> int:
    return main([str(word) for word in words])


def accepted(result: fa.Result) -> Any:
    document = json.loads(result.certificate.text)
    SCHEMA.validate(document)
    assert outcome(document) == "true"
    return document


def example() -> dict[str, list[Any]]:
    rows = [(sex, 65 if place < high else 64) for sex, (n, high) in EXAMPLE.items() for place in range(n)]
    return {"sex": [sex for sex, _ in rows], "points": [points for _, points in rows]}


def test_the_example_of_the_rule(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    result = fa.audit(example(), score="points", above="median", group="sex")
    document = accepted(result)
    assert document["subject"]["columns"]["decision"] == "points"
    assert document["subject"]["preparation"] == [{"step": "above median", "column": "points", "median": "129/2", "of": "168"}]
    assert result.global_ is not None and result.global_.ratio == Fraction(50, 92) / Fraction(34, 76) and "intervals" not in document
    path = tmp_path / "log.csv"
    path.write_text("sex,points\n" + "".join(f"{sex},{points}\n" for sex, points in zip(*example().values(), strict=True)))
    words = ("certify", path, "--score", "points", "--above-median", "--group", "sex")
    assert run(*words, "-o", tmp_path / "c.json", "--max-global-ratio", "0.85") == 1
    said = "a number in column 'points' above 64.5, the median of 168, counts as 'above', any other as 'not above'"
    out = " ".join(capsys.readouterr().out.split())
    assert said in out and "above: sex=Male 54.3 % (50 of 92), sex=Female 44.7 % (34 of 76)" in out
    assert run("verify", tmp_path / "c.json") == 0
    for name in ("c.html", "c.md"):
        assert run("report", tmp_path / "c.json", "-o", tmp_path / name) == 0
        assert "above 64.5, the median of 168" in (tmp_path / name).read_text()
    assert json.loads((tmp_path / "c.json").read_text())["subject"] == document["subject"]


@settings(max_examples=60, deadline=None)
@given(
    rows=st.lists(
        st.tuples(st.sampled_from([*SCORES, ""]), st.sampled_from(["f", "m", "n/a", ""]), st.fractions(0, 3, max_denominator=3)),
        min_size=1,
        max_size=30,
    ),
    weighted=st.booleans(),
)
def test_the_median_against_its_definition(rows: list[tuple[str, str, Fraction]], weighted: bool) -> None:
    rows += [("-3", "f", Fraction(1, 2)), ("2e400", "m", Fraction(1, 2))]
    table = {"points": [row[0] for row in rows], "sex": [row[1] for row in rows], "n": [str(row[2]) for row in rows]}
    # 1e400 and what else no float tells apart is compared exactly; a weight in sixths is as many equal rows.
    kept = [(read(text), sex, int(6 * n) if weighted else 1) for text, sex, n in rows if text and sex]
    middle = median(value for value, _, times in kept for _ in range(times))
    expected: Counter[tuple[str, str]] = Counter()
    for value, sex, times in kept:
        expected[sex, "above" if value > middle else "not above"] += times
    reading = Reading("points", ("sex",), above="median", missing="drop", unknown=("n/a",), count="n" if weighted else None)
    try:
        law = read_law(table, reading)
    except fa.InputError as error:
        assert "no score is above the median" in str(error) and not any(n for (_, what), n in expected.items() if what == "above")
        return
    [entry, *_] = law.preparation
    scale = 6 if weighted else 1
    assert entry["median"] == str(middle) and Fraction(entry["of"]) * scale == sum(times for _, _, times in kept)
    found: Counter[tuple[str, str]] = Counter()
    for cell, weights in zip(law.cell_group, law.weights, strict=True):
        for decision, weight in zip(law.decisions, weights, strict=True):
            found[law.groups[cell][0], decision] += Fraction(int(weight), law.scale) * scale
    known = {key: n for key, n in expected.items() if key[0] != "n/a" and n}
    assert {key: n for key, n in found.items() if n} == known
    if law.unknown is None or not weighted:
        accepted(fa.certify(law, {"above": 1}))


def read(text: str) -> Fraction:
    return Fraction(text)


@pytest.fixture(scope="module")
def holders(tmp_path_factory: pytest.TempPathFactory) -> dict[str, tuple[Any, dict[str, str]]]:
    """One log of scores with decimals in whatever can hold it."""
    import duckdb
    import pandas as pd
    import polars as pl

    folder = tmp_path_factory.mktemp("scores")
    rows = [((place * 37) % 101 / 10, "fm"[place * 7 % 11 % 2]) for place in range(400)]
    frame = pd.DataFrame(rows, columns=["points", "sex"])
    frame.to_csv(folder / "log.csv", index=False)
    frame.to_parquet(folder / "log.parquet")
    frame.astype({"points": str}).to_parquet(folder / "texts.parquet")
    (folder / "log.jsonl").write_text("".join(json.dumps({"points": points, "sex": sex}) + "\n" for points, sex in rows))
    (folder / "comma.csv").write_text("points;sex\n" + "".join(f"{points};{sex}\n".replace(".", ",") for points, sex in rows))
    with sqlite3.connect(folder / "log.db") as database:
        database.execute("create table log (points real, sex text)")
        database.executemany("insert into log values (?, ?)", rows)
    database.close()
    with duckdb.connect(str(folder / "log.duckdb")) as connection:
        connection.execute(f"create table log as select cast(points as decimal(9, 2)) as points, sex from '{folder}/log.parquet'")
    counted = frame.groupby(["points", "sex"]).size().rename("n").reset_index()
    held: dict[str, tuple[Any, dict[str, str]]] = {
        name: (folder / name, {}) for name in ("log.csv", "log.parquet", "texts.parquet", "log.jsonl", "comma.csv")
    }
    return held | {
        "csv by DuckDB": (folder / "log.csv", {"engine": "duckdb"}),
        "sqlite": (f"sqlite:{folder}/log.db", {"table": "log"}),
        "duckdb": (f"duckdb:{folder}/log.duckdb", {"table": "log"}),
        "pandas": (frame, {}),
        "polars": (pl.from_pandas(frame).lazy(), {}),
        "mapping": ({"points": [points for points, _ in rows], "sex": [sex for _, sex in rows]}, {}),
        "counts": (counted, {"count": "n"}),
        "counts in a mapping": ({name: counted[name].tolist() for name in counted}, {"count": "n"}),
    }


def test_whatever_holds_the_scores_gives_one_certificate(holders: dict[str, tuple[Any, dict[str, str]]]) -> None:
    texts = {
        name: fa.audit(source, score="points", above="median", group="sex", **options).certificate.text
        for name, (source, options) in holders.items()
    }
    counts = {texts.pop(name) for name in list(texts) if name.startswith("counts")}  # whose labels stand in the order of their rows
    assert len({*texts.values()}) == 1 == len(counts), {name: hash(text) for name, text in texts.items()}
    [prepared] = {str(json.loads(text)["subject"]["preparation"]) for text in (*texts.values(), *counts)}
    assert "above median" in prepared
    frame = holders["pandas"][0]
    [entry] = json.loads(texts["sqlite"])["subject"]["preparation"]
    assert Fraction(entry["median"]) == median(Fraction(str(points)) for points in frame.points)


def test_a_cut_that_was_fixed_before_leaves_a_population_to_speak_of() -> None:
    result = fa.audit(example(), score="points", above=64.5, group="sex")
    document = accepted(result)
    assert document["subject"]["preparation"] == [{"step": "above", "column": "points", "limit": "129/2"}]
    assert "intervals" in document
    assert fa.audit(example(), score="points", above="64.5", group="sex").certificate.text == result.certificate.text


def test_of_a_median_nothing_is_said_of_a_population(capsys: pytest.CaptureFixture[str]) -> None:
    asked: dict[str, Any] = {"score": "points", "above": "median", "group": "sex"}
    for more in ({"confidence": "0.9"}, {"independent": True}, {"select": "half"}, {"interval": "hoeffding-kl"}):
        with pytest.raises(fa.InputError, match="the scores were cut at their own median"):
            fa.audit(example(), **asked, **more)
    assert fa.audit(example(), **asked, confidence=None).verdict == "none"
    law = fa.audit(example(), **asked).law
    result = fa.certify(law, {"above": 1}, max_global_ratio="5/4")
    assert not result.intervals and result.certificate.document["targets"][0]["judged"] == "this table"
    # An interval that another program put there is refused by the checker.
    sampled = json.loads(fa.audit(example(), score="points", above="64.5", group="sex").certificate.text)
    sampled["subject"]["preparation"] = [dict(entry) for entry in law.preparation]
    assert outcome(sampled).startswith("malformed: intervals")


def test_what_the_table_shows_of_a_cut_is_checked() -> None:
    rows = {"points": [1, 2, 3, 4, 5, 5, "", 3], "sex": ["f", "f", "f", "m", "m", "m", "m", "?"]}
    document = accepted(fa.audit(rows, score="points", above="median", group="sex", missing="drop", unknown="?"))
    assert [entry["step"] for entry in document["subject"]["preparation"]] == ["above median", "left out", "unknown"]
    [entry, *others] = document["subject"]["preparation"]
    assert entry == {"step": "above median", "column": "points", "median": "3", "of": "7"}

    def changed(**keys: Any) -> str:
        mutant = copy.deepcopy(document)
        mutant["subject"]["preparation"] = [{k: v for k, v in (entry | keys).items() if v is not None}, *others]
        return outcome(json.loads(named_anew(json.dumps(mutant).encode())))

    assert changed(of="8") == changed(of="6") == changed(of="7/2") == "false"
    for keys in ({"of": "0"}, {"of": None}, {"median": None}, {"median": "6/2"}, {"column": "sex"}, {"column": "other"}, {"limit": "3"}):
        assert changed(**keys).startswith("malformed")
    assert changed(median="100") == "true"  # which scores there were, no table shows
    mutant = copy.deepcopy(document)
    mutant["subject"]["preparation"] = [{"step": "above", "column": "points", "limit": "3"}, entry, *others]
    assert outcome(mutant).startswith("malformed")
    mutant["subject"]["preparation"] = [{"step": "above", "column": "points", "limit": "3"}, *others]
    assert outcome(json.loads(named_anew(json.dumps(mutant).encode()))) == "true"
    # More than half cannot be above, and there is no third decision.
    for decisions, counts in ((["above", "not above"], [[3, 1], [1, 2]]), (["above", "not above", "between"], [[1, 2, 1], [1, 2, 1]])):
        law = fa.Law.from_array([counts], kind="counts", decisions=decisions, groups=["f", "m"])
        document = json.loads(fa.certify(law, {"above": 1}, confidence=None).certificate.text)
        total = str(sum(map(sum, counts)))
        document["subject"]["preparation"] = [{"step": "above median", "column": law.columns.decision, "median": "3", "of": total}]
        assert outcome(json.loads(named_anew(json.dumps(document).encode()))) == "false"


def test_a_policy_of_scores_says_it_too() -> None:
    filters = {"group_filter": fa.RandomizedResponse(["Female", "Male"], keep_probability="3/4")}
    result = fa.audit(example(), score="points", above="median", group="sex", **filters)
    assert accepted(result)["subject"]["preparation"][0]["step"] == "above median" and not result.intervals


@pytest.mark.parametrize("missing", ["group", "unknown"])
def test_who_has_no_score_is_left_out_while_who_has_no_group_is_kept(missing: str) -> None:
    """Beside 3, 5 and 9 stand a blank score, one of nobody known, and a score without a group: the median is that of four scores."""
    log = {"points": [3, 5, None, 9, "", 7], "sex": ["f", "m", "f", "m", None, None]}
    document = accepted(fa.audit(log, score="points", above="median", group="sex", missing=missing))
    steps = {step["step"]: step for step in document["subject"]["preparation"]}
    assert steps["above median"] | {"median": "6", "of": "4"} == steps["above median"]
    groups = steps["left out"].pop("groups")
    assert steps["left out"] == {"step": "left out", "reason": "missing label", "decisions": "2", "of": "6", "columns": {"points": "2"}}
    of_known = [{"group": ["f"], "decisions": "1", "of": "2"}]
    assert groups == ([*([{"group": ["(missing)"], "decisions": "1", "of": "2"}] if missing == "group" else []), *of_known])
    kept = steps["level"] if missing == "group" else steps["unknown"]
    assert kept["decisions"] == "1"
    rows = document["subject"]["table"]["rows"]
    assert sum(int(n) for row in rows for n in row.get("weights", row.get("unknown"))) == 4


BAD: dict[str, tuple[dict[str, Any], dict[str, Any], str]] = {
    "no number": ({"points": [1, "two"]}, {}, "column 'points', row 2: 'two' is not a number such as 12, 0.25, 1e-3 or 1/3; scores are"),
    "a truth value": ({"points": [True, False]}, {}, "row 1: 'true' is not a number"),
    "infinite": ({"points": [1.0, float("inf")]}, {}, "row 2: 'inf' is not a number"),
    "missing": ({"points": [1, None]}, {}, "row 2: the score is missing (1 in all); missing=drop (--missing drop) leaves such rows"),
    "nothing left": ({"points": [None, None]}, {"missing": "drop"}, "every row has a missing label"),
    "nobody": ({"points": [1, 7]}, {"above": 7}, "no score is above the number 7; there is nothing to compare"),
    "half are the highest": ({"points": [7, 7.0]}, {}, "no score is above the median 7, because half of all or more have the highest one"),
    "no cut": ({}, {"above": None}, "score goes with above: a column of scores, and what one has to be above, its median or a number"),
    "no score": ({}, {"score": None}, "above goes with score"),
    "a decision besides": ({}, {"decision": "sex"}, "score and decision do not go together"),
    "no such cut": ({}, {"above": "mean"}, "above: 'mean' is not a number"),
    "twice": ({}, {"group": "points"}, "the column 'points' is used twice"),
    "of probabilities": ({"p": [1, 1]}, {"probability": "p"}, "score goes with counts and logs, and does not go with probability"),
    "a column of utilities": (
        {"g": [1, 1]},
        {"utility_column": "g"},
        "score goes with counts and logs, and does not go with utility_column",
    ),
    "a map": ({}, {"label_map": {"points": {"1": "2"}}}, "which is that of the scores; these are numbers, not labels"),
    "in parts": ({}, {"in_parts": True}, "in_parts does not go with"),
    "no such column": ({}, {"score": "marks"}, "there is no column 'marks'"),
}


@pytest.mark.parametrize("case", BAD)
def test_what_is_no_score_is_refused_in_a_sentence(case: str) -> None:
    cells, options, message = BAD[case]
    table = {"points": [1, 2], "sex": ["f", "m"]} | cells
    with pytest.raises(fa.InputError) as error:
        fa.audit(table, **({"score": "points", "above": "median", "group": "sex"} | options))
    assert message in str(error.value)


def test_the_command_refuses_what_does_not_go_with_scores(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = tmp_path / "log.csv"
    path.write_text("points,sex,w\n1,f,1\n2,m,1\n,m,1\n")
    words = ("certify", path, "--score", "points", "--above-median", "--group", "sex")
    assert run(*words) == 2 and "log.csv: column 'points', line 4: the score is missing" in capsys.readouterr().err
    refused = {
        ("--print-sql", "duckdb"): "--print-sql does not go with --score",
        ("--confidence", "0.9", "--missing", "drop"): "--above with a number that was fixed before",
        ("--slots", "a", "--winner", "w"): "--score does not go with --slots; scores go with counts and logs of decisions",
        ("--wide", "yes=w,no=points"): "--score goes with counts and logs, and does not go with --wide",
        ("--decision", "w"): "--score and --decision do not go together",
        ("--group-probability", path): "--score does not go with --group-probability",
        ("--in-parts",): "contexts that are read in parts need --decision",
    }
    for more, message in refused.items():
        assert run(*words, *more) == 2 and message in capsys.readouterr().err, more
    assert run("certify", path, "--score", "points", "--group", "sex") == 2
    assert "--score goes with --above-median or --above NUMBER" in capsys.readouterr().err
    assert run("certify", path, "--score", "points", "--group", "sex", "--above", "1", "--missing", "drop") == 0
    with pytest.raises(SystemExit):
        run(*words, "--above", "3")


def test_one_score_that_no_float_tells_from_the_others() -> None:
    values = [2**60 + place for place in (3, 1, 2, 0)]
    for points in (values, [str(value) for value in values]):
        law = fa.audit({"points": points, "sex": ["f", "f", "m", "m"]}, score="points", above="median", group="sex").law
        assert law.preparation[0]["median"] == str(2**60 + Fraction(3, 2)) and law.weights.tolist() == [[1, 1], [1, 1]]
    assert score_cut(0.1) == Fraction(1, 10)
    table = cut_scores({"points": [1, 2], "sex": ["f", "m"]}, "points", "median")
    assert table["points"] == ["not above", "above"]


def test_what_checker_and_writer_call_them() -> None:
    assert (checker.preparation.ABOVE, checker.preparation.NOT_ABOVE) == (scores.ABOVE, scores.NOT_ABOVE)


def test_scores_of_résumés(data: Path) -> None:
    path = data / "hiring_scores" / "gpt-3.5-turbo.csv"
    with path.open(encoding="utf-8") as lines:
        rows = list(csv.DictReader(lines))
    middle = median(int(row["Total"]) for row in rows)
    result = fa.audit(path, score="Total", above="median", group=["gender", "race"])
    assert result.law.preparation[0]["median"] == str(Fraction(middle))
    expected = Counter((row["gender"], row["race"], int(row["Total"]) > middle) for row in rows)
    for cell, weights in zip(result.law.cell_group, result.law.weights.tolist(), strict=True):
        assert weights == [expected[*result.law.groups[cell], True], expected[*result.law.groups[cell], False]]
    accepted(result)
