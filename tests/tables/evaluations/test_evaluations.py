"""Rows of JSON with paths into them, through the reader of logs: what is counted, and what is refused."""

from __future__ import annotations

import gzip
import json
import tempfile
from collections import Counter
from collections.abc import Sequence
from dataclasses import replace
from decimal import Decimal
from pathlib import Path
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

import fairaudit as fa
from fairaudit.errors import InputError
from fairaudit.tables.evaluations.extraction import Wanted, extraction_of
from fairaudit.tables.evaluations.json_rows import ROWS as ROWS_OF_JSON
from fairaudit.tables.evaluations.listing import listing
from fairaudit.tables.evaluations.paths import is_path
from fairaudit.tables.evaluations.reading import read
from fairaudit.tables.evaluations.samples import Format, Run, Sample
from fairaudit.tables.label_text import label_text


def lines(path: Path, rows: Sequence[Any]) -> str:
    path.write_text("".join(json.dumps(row) + "\n" for row in rows), "utf-8")
    return str(path)


def counted(tally: Any) -> Counter[tuple[Any, ...]]:
    rows = zip(*(tally[name] for name in tally.columns), strict=True)
    return Counter({row: int(n) for row, n in zip(rows, tally.counts, strict=True)})


PEOPLE = [
    {"id": 1, "answer": "Yes, hire.", "who": {"race": "b", "ages": [30, 40]}, "p": [[0.5], [0.25]]},
    {"id": 2, "answer": "no", "who": {"race": "w", "ages": [20]}, "p": [[-2], ["-1.5"]]},
    {"id": 3, "answer": "Yes", "who": {"race": "b", "ages": []}, "p": [[1e-9], [0]]},
]


def test_paths_are_columns(tmp_path: Path) -> None:
    path = lines(tmp_path / "log.jsonl", PEOPLE)
    tally = fa.read_log(path, ["argmax(p[*][0])", "who.race", "who.ages[last]"])
    assert counted(tally) == {(0, "b", 40): 1, (1, "w", 20): 1, (0, "b", None): 1}
    assert tally.evaluation is None  # nothing was asked but where columns are


@pytest.mark.parametrize("form", ["lines", "array", "spread array", "gzip", "crlf", "bom", "blank lines", "one line without end"])
def test_the_form_of_the_file_does_not_matter(tmp_path: Path, form: str) -> None:
    text = "\n".join(map(json.dumps, PEOPLE)) + "\n"
    path = tmp_path / ("log.json" if "array" in form else "log.jsonl")
    if form == "gzip":
        path = tmp_path / "log.jsonl.gz"
        path.write_bytes(gzip.compress(text.encode()))
    else:
        written = {
            "array": json.dumps(PEOPLE),
            "spread array": json.dumps(PEOPLE, indent=2),
            "crlf": text.replace("\n", "\r\n"),
            "bom": "\ufeff" + text,
            "blank lines": "\n\n" + text.replace("\n", "\n \n"),
            "one line without end": text.rstrip("\n"),
        }
        path.write_bytes(written.get(form, text).encode())
    assert counted(fa.read_log(str(path), ["who.race"])) == {("b",): 2, ("w",): 1}


def test_a_column_with_exactly_that_name_wins(tmp_path: Path) -> None:
    path = lines(tmp_path / "log.jsonl", [{"a.b": "flat", "a": {"b": "deep"}}, {"a.b": "flat"}])
    assert counted(fa.read_log(path, ["a.b"])) == {("flat",): 2}
    mixed = lines(tmp_path / "mixed.jsonl", [{"a.b": "flat"}, {"a": {"b": "deep"}}])
    with pytest.raises(InputError, match=r"some rows have a column 'a.b', in others this is a path"):
        fa.read_log(mixed, ["a.b"])


def test_labels_of_every_kind(tmp_path: Path) -> None:
    values = [True, False, None, 1, 1.0, "1", "true", 0.1, 10**30, "", " "]
    path = lines(tmp_path / "log.jsonl", [{"a": {"v": value}} for value in values] + [{"a": {}}])
    plain = lines(tmp_path / "plain.jsonl", [{"v": value} for value in values] + [{}])
    deep, flat = fa.read_log(path, ["a.v"]), fa.read_log(plain, ["v"])

    assert counted_labels(deep, "a.v") == counted_labels(flat, "v") == {"true": 2, "false": 1, None: 4, "1": 3, "0.1": 1, "1" + "0" * 30: 1}


def test_numbers_are_what_the_text_says(tmp_path: Path) -> None:
    path = tmp_path / "log.jsonl"
    path.write_text('{"a": {"u": 0.1}}\n{"a": {"u": 0.10000000000000000000001}}\n{"a": {"u": 1e400}}\n')
    assert sorted(fa.read_log(str(path), ["a.u"])["a.u"]) == [Decimal("0.1"), Decimal("0.10000000000000000000001"), Decimal("1e400")]


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ('{"a": {"v": NaN}}', "line 1: 'a.v' is NaN, which is not a JSON value"),
        ('{"a": {"v": [1]}}', r"'a.v' is a list with 1 element; name an element, such as a.v\[0\], a.v\[last\] or a.v\[\*\]$"),
        ('{"a": {"v": [{"k": 1}, 2]}}', r"'a.v' is a list with 2 elements; .* and what is in it: a.v\[0\].k$"),
        ('{"a": {"v": {"k l": 1, "m": {"n": 1}}}}', "'a.v' is an object; name what is in it: a.v.\"k l\", a.v.m.n$"),
        ('{"a": [{"v": 1}]}', "goes by the name 'v' into a list"),
        ('{"a": {"v": 1}}\n{"a": {"v"', "line 2, character 11: no JSON"),
        ('{"a": {"v": 1, "v": 2}}', "the key 'v' stands twice"),
        ('{"a": ' + "[" * 100_000, "nested too deeply"),
        ('{"a": {"v": ' + "9" * 5000 + "}}", "line 1: a whole number has too many digits"),
        ('{"a": {"v": 1e9999999999999999999999}}', "line 1: the exponent of a number has too many digits"),
        ("[1, 2]", "row 1 is an int; each row is an object"),
        ("3", "line 1: an object was expected"),
        ('{"b": 1}', "there is no path 'a.v'; known: 'b'"),
        ("", "the log has no samples"),
        ("[]", "the log has no samples"),
        ('[{"a": {"v": 1}}', "it was cut"),
        ('[{"a": {"v": 1}} {"a": {"v": 1}}]', ", or ] was expected"),
        ('[{"a": {"v": 1}},]', "no JSON"),
        ('[{"a": {"v": 1}}] x', "the end of the file was expected"),
    ],
)
def test_what_is_wrong_is_said_with_its_place(tmp_path: Path, text: str, said: str) -> None:
    path = tmp_path / "log.jsonl"
    path.write_text(text)
    with pytest.raises(InputError, match=said) as error:
        fa.read_log(str(path), ["a.v"])
    assert "log.jsonl" in str(error.value)


def test_a_row_for_each_element_needs_a_unit(tmp_path: Path) -> None:
    rows = [{"id": 1, "r": [["a", "b", "a"]], "g": "x"}, {"id": 2, "r": [["b"]], "g": "y"}, {"id": 3, "r": [[]], "g": "y"}]
    path = lines(tmp_path / "log.jsonl", rows)
    with pytest.raises(InputError, match=r"name with --unit"):
        fa.read_log(path, ["r[0][*]", "g"])
    tally = fa.read_log(path, ["r[0][*]", "g", "id"], unit="id", decision="r[0][*]")
    assert counted(tally) == {("a", "x", 1): 2, ("b", "x", 1): 1, ("b", "y", 2): 1, (None, "y", 3): 1}
    with pytest.raises(InputError, match=r"take different lists apart"):
        fa.read_log(path, ["r[*]", "g[*]", "id"], unit="id")


def test_extracted_answers(tmp_path: Path) -> None:
    answers = ["Yes.", "yes, YES", "no", "Yes or no", "maybe", "", None]
    path = lines(tmp_path / "log.jsonl", [{"a": answer} for answer in answers])
    tally = fa.read_log(path, ["a"], decision="a", extract="(?i)\\b(yes|no)\\b")
    assert counted(tally) == {("Yes",): 1, ("unreadable",): 4, ("no",): 1, (None,): 1}  # yes and YES are two answers
    assert (tally.evaluation.format, tally.evaluation.extract, tally.evaluation.read) == ("rows", "(?i)\\b(yes|no)\\b", 7)
    for asked in ({"extract": "(yes)"}, {"errors": "drop"}):
        with pytest.raises(InputError, match=r"goes with a decision; name its column"):
            fa.read_log(path, ["a"], **asked)  # type: ignore[arg-type]
    with pytest.raises(InputError, match=r"the decision 'b' is not among the columns"):
        fa.read_log(path, ["a"], decision="b", extract="(yes)")
    for wrong in ("yes", "(", "(a", "(yes)|(no)"):
        with pytest.raises(InputError, match=r"--extract"):
            fa.read_log(path, ["a"], decision="a", extract=wrong)


def test_numbers_of_any_size_are_read_or_refused_in_a_sentence(tmp_path: Path) -> None:
    for number, words in (("1e" + "9" * 23, "exponent|not a JSON value"), ("9" * 5000, "too many digits")):
        for row, name in (({"g": 0}, "g"), ({"o": {"g": 0}}, "o.g")):
            path = tmp_path / "log.jsonl"
            path.write_text(json.dumps(row) + "\n" + json.dumps(row).replace("0", number) + "\n")
            with pytest.raises(InputError, match=words) as refused:
                fa.read_log(str(path), [name])
            assert "sys." not in str(refused.value)


def test_conditions_that_no_sample_fits_show_values_as_they_are(tmp_path: Path) -> None:
    path = lines(tmp_path / "log.jsonl", [{"a": "yes", "n": 0.5}])
    with pytest.raises(InputError, match=r"nope is to be 'nothing', and there is nothing$"):
        fa.read_log(path, ["a"], where={"nope": "nothing"})
    with pytest.raises(InputError, match=r"n is to be '1', and there is '0.5'$"):
        fa.read_log(path, ["a"], where={"n": "1"})
    with pytest.raises(InputError, match=r"takes the greatest of a list, and there is 0\.5$"):
        fa.read_log(path, ["argmax(n[*])"])


def test_a_decision_that_is_a_word_for_no_answer_is_refused(tmp_path: Path) -> None:
    path = lines(tmp_path / "log.jsonl", [{"a": "Refused", "f": 1}, {"a": "yes", "f": 1}])
    assert counted(fa.read_log(path, ["a"], decision="a")) == {("Refused",): 1, ("yes",): 1}  # a column of a table is a column
    with pytest.raises(InputError, match=r"'Refused' is a word for answers that decide nothing"):
        fa.read_log(path, ["a"], decision="a", where={"f": "1"})


def test_only_samples_that_fit_count(tmp_path: Path) -> None:
    rows = [{"a": "yes", "f": {"x": 1}, "g": True}, {"a": "no", "f": {"x": 2}, "g": True}, {"a": "no", "f": {"x": 1}, "g": False}]
    path = lines(tmp_path / "log.jsonl", rows)
    assert counted(fa.read_log(path, ["a"], where=["f.x=1"])) == {("yes",): 1, ("no",): 1}
    assert counted(fa.read_log(path, ["a"], where={"f.x": "1", "g": "true"})) == {("yes",): 1}
    with pytest.raises(InputError, match=r"no sample fits all of where; f.x is to be '3', and there is '1', '2'"):
        fa.read_log(path, ["a"], where="f.x=3")
    with pytest.raises(InputError, match=r"no sample fits"):
        fa.read_log(path, ["a"], where="f.y=3")
    with pytest.raises(InputError, match=r"cannot be both '1' and '2'"):
        fa.read_log(path, ["a"], where=["f.x=1", "f.x=2"])


def test_rows_of_another_file(tmp_path: Path) -> None:
    path = lines(tmp_path / "log.jsonl", [{"id": 1, "a": {"v": "yes"}}, {"id": 2, "a": {"v": "no"}}])
    people = tmp_path / "people.csv"
    people.write_text("id,race\n1,b\n2,w\n")
    assert counted(fa.read_log(path, ["a.v", "race"], join=f"{people}:id")) == {("yes", "b"): 1, ("no", "w"): 1}
    people.write_text("id,race\n1,b\n2,w\n3,w\n")
    with pytest.raises(InputError, match=r"1 of 3 rows of .*people.csv belong to no sample \('3'\)"):
        fa.read_log(path, ["a.v", "race"], join=f"{people}:id")
    assert fa.read_log(path, ["a.v", "race"], join=f"{people}:id", missing_samples="accept").rows == 2
    people.write_text("id,race\n1,b\n")
    with pytest.raises(InputError, match=r"line 2: .*people.csv has no row whose 'id' is '2'"):
        fa.read_log(path, ["a.v", "race"], join=f"{people}:id")
    people.write_text("id,race\n1,b\n1,w\n2,w\n")
    with pytest.raises(InputError, match=r"row 2: a row whose 'id' is '1' is there already"):
        fa.read_log(path, ["a.v", "race"], join=f"{people}:id")
    people.write_text("id,race,a.v\n1,b,x\n2,w,y\n")
    with pytest.raises(InputError, match=r"both the log and .*people.csv have 'a.v'"):
        fa.read_log(path, ["a.v", "race"], join=f"{people}:id")
    typed = lines(tmp_path / "people.jsonl", [{"id": "1", "race": "b"}, {"id": "2", "race": "w"}])
    with pytest.raises(InputError, match=r"'id' is 1 here, and is a number in some samples and a text in others"):
        fa.read_log(path, ["a.v", "race"], join=f"{typed}:id")


def test_ids_are_numbers_or_text_but_not_both(tmp_path: Path) -> None:
    first = lines(tmp_path / "a.jsonl", [{"m": {"id": 1}, "a": "x"}])
    second = lines(tmp_path / "b.jsonl", [{"m": {"id": "1"}, "a": "x"}])
    assert fa.read_log([first, second], ["a", "m.id"]).rows == 2
    with pytest.raises(InputError, match=r"'m.id' is 1 in some samples, and the text '1' in others"):
        fa.read_log([first, second], ["a", "m.id"], unit="m.id")


TEXTS = st.sampled_from(["", "x", "1", "true", "a.b"])
SCALARS = st.one_of(st.none(), st.booleans(), st.integers(-3, 3), TEXTS, st.sampled_from([0.5, 1.0]))
NAMES = st.sampled_from("abc")
VALUES = st.recursive(SCALARS, lambda inner: st.lists(inner, max_size=3) | st.dictionaries(NAMES, inner, max_size=3), max_leaves=8)
OBJECTS = st.lists(st.dictionaries(st.sampled_from(["a", "b", "a.b", "a[0]"]), VALUES, max_size=4), min_size=1, max_size=6)
PATHS = ["a", "a.b", "a[0]", "a[last]", "a.b.c", "a[0].b", "b[1].a", "a[0][last]", '"a.b".c', "b.a[last]"]


def found_at(row: Any, path: str) -> Any:
    """What a path leads to, written anew: an exact name, else one step after another."""
    if path in row:
        return ("column", row[path])
    value, rest = row, path.replace('"a.b"', "A").replace("[", ".[").split(".")
    for step in rest:
        step = "a.b" if step == "A" else step
        if step.startswith("["):
            if not isinstance(value, list) or not value or (step != "[last]" and int(step[1:-1]) >= len(value)):
                return ("nothing", None)
            value = value[-1 if step == "[last]" else int(step[1:-1])]
        elif isinstance(value, list):
            return ("refused", None)
        elif isinstance(value, dict) and step in value:
            value = value[step]
        else:
            return ("nothing", None)
    return ("path", value)


@given(OBJECTS, st.sampled_from(PATHS))
def test_rows_are_counted_as_plain_loops_count_them(rows: list[dict[str, Any]], path: str) -> None:
    found = [found_at(row, path) for row in rows]
    values = [value for _, value in found]
    kinds = {kind for kind, _ in found}
    with tempfile.TemporaryDirectory() as folder:
        for name, text in (("log.jsonl", "\n".join(map(json.dumps, rows))), ("log.json", json.dumps(rows))):
            log = Path(folder) / name
            log.write_text(text)
            if (
                "refused" in kinds
                or {"column", "path"} <= kinds
                or kinds == {"nothing"}
                or any(isinstance(v, (dict, list)) for v in values)
            ):
                with pytest.raises(InputError):
                    fa.read_log(log, [path], where={})
                continue
            tally = fa.read_log(log, [path]) if is_path(path) else read([str(log)], ROWS_OF_JSON, Wanted((path,)))
            assert counted_labels(tally, path) == Counter(map(label_text, values))


def counted_labels(tally: Any, name: str) -> Counter[str | None]:
    found: Counter[str | None] = Counter()
    for value, number in zip(tally[name], tally.counts.tolist(), strict=True):
        found[label_text(value)] += number
    return found


def test_files_are_a_column(tmp_path: Path) -> None:
    paths = [lines(tmp_path / f"{name}.jsonl", [{"a": {"v": "x"}}]) for name in "pq"]
    assert counted(fa.read_log(paths, ["a.v", "file"])) == {("x", "p.jsonl"): 1, ("x", "q.jsonl"): 1}


ROWS = [{"id": n, "epoch": e, "answer": "yes" if n % 2 else "no", "race": "b" if n < 4 else "w"} for n in range(8) for e in (1, 2)]


def made(rows: Sequence[dict[str, Any]], outcomes: Sequence[str], **said: Any) -> Format:
    """A format whose one file holds these rows."""
    samples = [Sample(row, outcome, f"sample {place}") for place, (row, outcome) in enumerate(zip(rows, outcomes, strict=True))]  # type: ignore[arg-type]
    run = Run("made", **{"epochs": 2, "expected": len(rows), **said})
    return Format("made", lambda _: run, lambda *_: iter(samples), ("id", "epoch"), "id", "epoch")


def wanted(unit: Sequence[str] = ("id",), **asked: Any) -> Wanted:
    return Wanted(("answer", "race", *unit), "answer", ("race",), tuple(unit), extraction_of(**asked))


def test_answers_that_decide_nothing_are_decisions_of_their_own() -> None:
    outcomes = ["refused", "truncated", *["read"] * 14]
    rows = [*ROWS[:15], {**ROWS[15], "answer": ""}]
    tally = read(["log"], made(rows, outcomes), wanted())
    assert Counter(dict(zip(tally["answer"], [0] * len(tally), strict=True))).keys() == {"refused", "truncated", "unreadable", "yes", "no"}
    found = Counter[str]()
    for answer, number in zip(tally["answer"], tally.counts.tolist(), strict=True):
        found[answer] += number
    assert found == {"refused": 1, "truncated": 1, "unreadable": 1, "yes": 7, "no": 6}
    assert (tally.evaluation.epochs, tally.evaluation.expected, tally.evaluation.read) == (2, 16, 16)


def test_samples_without_an_answer_are_refused_by_group_or_kept_as_errors() -> None:
    outcomes = ["error"] * 3 + ["read"] * 13
    with pytest.raises(InputError, match=r"3 of 16 samples have no answer \(race=b 3 of 8; race=w 0 of 8\); --errors drop"):
        read(["log"], made(ROWS, outcomes), wanted())
    for errors in ("drop", "bound"):
        tally = read(["log"], made(ROWS, outcomes), wanted(errors=errors))
        failed = [n for answer, n in zip(tally["answer"], tally.counts.tolist(), strict=True) if answer == "error"]
        assert (sum(failed), tally.rows, tally.evaluation.errors) == (3, 16, errors)
    with pytest.raises(InputError, match=r"16 of 16 samples have no answer"):
        read(["log"], made(ROWS, ["error"] * 16), wanted())


def test_what_became_of_samples_is_not_lost_by_the_way() -> None:
    """Neither by a condition that a failed sample cannot meet, nor where numbers take the place of decisions."""
    rows = [{**row, "score": {"of": 1}} if place else row for place, row in enumerate(ROWS)]
    with pytest.raises(InputError, match=r"1 of 16 samples have no answer"):
        read(["log"], made(rows, ["error", *["read"] * 15]), wanted(where={"score.of": "1"}))
    kept = read(["log"], made(rows, ["error", *["read"] * 15]), wanted(where={"score.of": "1"}, errors="bound"))
    assert (kept.rows, kept["answer"].count("error")) == (16, 1)
    with pytest.raises(InputError, match=r"2 of 16 answers were refused or cut off, which only a decision can say"):
        read(["log"], made(ROWS, ["refused", "truncated", *["read"] * 14]), replace(wanted(), decision=None))


def test_samples_that_are_missing_or_twice_there() -> None:
    with pytest.raises(InputError, match=r"log: the log, whose status is 'started', holds 16 of 48 samples; --missing-samples accept"):
        read(["log"], made(ROWS, ["read"] * 16, expected=48, status="started"), wanted())
    tally = read(["log"], made(ROWS, ["read"] * 16, expected=48), wanted(missing_samples="accept"))
    assert (tally.evaluation.expected, tally.evaluation.read, tally.evaluation.missing) == (48, 16, 32)
    with pytest.raises(InputError, match=r"holds 16 samples and should hold 15"):
        read(["log"], made(ROWS, ["read"] * 16, expected=15), wanted(missing_samples="accept"))
    with pytest.raises(InputError, match=r"log, sample 16: the sample with id 0, epoch 1 is there twice"):
        read(["log"], made([*ROWS, ROWS[0]], ["read"] * 17), wanted())
    with pytest.raises(InputError, match=r"the sample with id 0, epoch 1 is there twice for the model 'm'; .* --group file .* --unit id "):
        read(["log", "again"], made(ROWS, ["read"] * 16, model="m"), wanted())


def test_parquet_with_objects_and_lists(tmp_path: Path) -> None:
    arrow = pytest.importorskip("pyarrow")
    import pyarrow.parquet as parquet

    path = str(tmp_path / "log.parquet")
    rows = [{**row, "p": [[str(number) for number in pair] for pair in row["p"]], "score": 0.5} for row in PEOPLE]
    parquet.write_table(arrow.Table.from_pylist(rows), path)
    tally = fa.read_log(path, ["argmax(p[*][0])", "who.race", "who.ages[last]", "score"])
    assert counted(tally) == {(0, "b", 40, Decimal("0.5")): 1, (1, "w", 20, Decimal("0.5")): 1, (0, "b", None, Decimal("0.5")): 1}
    assert counted(fa.read_log(path, ["answer", "who.race"], decision="answer", extract="(?i)(yes|no)"))[("Yes", "b")] == 2
    with pytest.raises(InputError, match=r"column 'who' is of type STRUCT.*, or in Parquet name what is in it"):
        fa.read_log(path, ["who"])
    with pytest.raises(InputError, match=r"there is no path 'who.sex'; known: 'who.race'"):
        fa.read_log(path, ["who.sex"])
    dotted = str(tmp_path / "dotted.parquet")
    parquet.write_table(arrow.table({"a.b": ["x", "y", "x"]}), dotted)
    assert counted(fa.read_log(dotted, ["a.b"])) == {("x",): 2, ("y",): 1}
    with pytest.raises(InputError, match=r"none of the columns .*'whom'"):
        fa.read_log(path, ["whom.sex"])
    table = arrow.table({"s": [{"t": 1_700_000_000_000_000_001}]})
    wide = arrow.struct([("t", arrow.timestamp("ns"))])
    parquet.write_table(table.cast(arrow.schema([("s", wide)])), path, version="2.6")
    with pytest.raises(InputError, match=r"column 's' holds in 't' what DuckDB may round"):
        fa.read_log(path, ["s.t"])


def test_what_became_of_samples_is_listed() -> None:
    rows = [{**row, "scores": {"a b": {"answer": row["answer"]}}, "messages": ["..."], "long": "x" * 999} for row in ROWS]
    log = made(rows, [*["error"] * 2, "refused", *["read"] * 13], model="m")
    found = listing(["log"], replace(log, answers=("argmax(p[*])", "choices.*.text", "scores.*.answer")))
    assert (found.samples, found.outcomes) == (16, {"error": 2, "refused": 1, "read": 13})
    assert found.answer(replace(log, answers=("scores.*.answer",))) == 'scores."a b".answer'
    assert found.answer(log) is None
    assert {name: dict(leaf.levels) for name, leaf in found.leaves.items()} == {
        "id": {str(n): 2 for n in range(8)},
        "epoch": {"1": 8, "2": 8},
        "answer": {"yes": 8, "no": 8},
        "race": {"b": 8, "w": 8},
        'scores."a b".answer': {"yes": 8, "no": 8},
        "long": {"x" * 199 + "…": 16},
        "eval.model": {"m": 16},
    }


def test_repetitions_need_a_unit() -> None:
    with pytest.raises(InputError, match=r"asked 2 times; say what was drawn: --unit id .* or --unit id,epoch"):
        read(["log"], made(ROWS, ["read"] * 16), wanted(()))
    assert read(["log"], made(ROWS, ["read"] * 16), wanted(("id", "epoch"))).rows == 16
    once = [row for row in ROWS if row["epoch"] == 1]
    assert read(["log"], made(once, ["read"] * 8, epochs=1), wanted(())).rows == 8


@pytest.mark.parametrize("said", [{"epochs": 10**20}, {"expected": 2 * 10**18}])
def test_numbers_that_no_log_can_have_are_refused(said: dict[str, int]) -> None:
    """Of which no certificate could be read again."""
    with pytest.raises(InputError, match=r"log: the log says that it should hold .* samples, of \d+ epochs; 1,000,000,000,000 is the most"):
        read(["log"], made(ROWS, ["read"] * 16, **said), wanted(missing_samples="accept"))


def test_what_an_expression_takes_out_is_no_word_for_answers_that_decide_nothing(tmp_path: Path) -> None:
    rows = [{"answer": "verdict: pass", "who": "a"}, {"answer": "verdict: error", "who": "b"}]
    path = lines(tmp_path / "log.jsonl", rows)
    with pytest.raises(InputError, match="the decision 'error' is a word for answers that decide nothing"):
        fa.read_log(path, ["answer", "who"], decision="answer", extract="verdict: ([a-z]+)", errors="drop")


def test_samples_that_one_of_two_files_lacks_are_missing() -> None:
    runs = {"a": Run("made", model="a", expected=20), "b": Run("made", model="b")}
    rows = [Sample({"id": i, "answer": "A", "race": "ab"[i % 2]}, "read", f"line {i}") for i in range(16)]
    log = Format("made", runs.__getitem__, lambda path, tops: iter(rows), ("id",), "id")
    tally = read(["a", "b"], log, wanted(missing_samples="accept", unit=("id",)))
    assert tally.evaluation is not None and (tally.evaluation.expected, tally.evaluation.missing) == (36, 4)


LOGS = Path(__file__).parent / "logs"


@pytest.mark.parametrize(
    ("group", "said"),
    [
        ("race", r"known: 'metadata.race', .*did you mean 'metadata.race'\?"),
        ("vars.RACE", r"known: 'metadata.race', .*did you mean 'metadata.race'\?"),
        ("metadata.rase", r"known: .*did you mean 'metadata.race'\?"),
    ],
)
def test_a_path_that_is_nowhere_comes_before_lost_answers_and_is_looked_for_in_a_whole_sample(group: str, said: str) -> None:
    with pytest.raises(InputError, match=f"there is no (path|column) '{group}'; {said}"):
        fa.read_log(LOGS / "promptfoo" / "loans.json", ["response.output", group], decision="response.output", unit="id")


def test_a_scorer_that_is_not_there_shows_what_is() -> None:
    with pytest.raises(InputError, match=r"there is no path 'score.choice.answer'; known: 'scores.choice.answer', "):
        fa.read_log(LOGS / "inspect" / "data_arc_qwen.json", ["score.choice.answer", "id"], decision="score.choice.answer")


def test_an_expression_that_takes_nothing_out_is_refused(tmp_path: Path) -> None:
    rows = [{"answer": answer, "race": "b"} for answer in ("No", "Yes")]
    path = lines(tmp_path / "log.jsonl", rows)
    asked = {"decision": "answer", "group": "race"}
    with pytest.raises(InputError, match=r"--extract \(extract\) took nothing out of any of 2 answers; the first is 'No'.*\(\?i\)"):
        fa.read_log(path, ["answer", "race"], extract="(yes|no)", **asked)
    assert counted(fa.read_log(path, ["answer", "race"], extract="(?i)(yes|no)", **asked)) == {("No", "b"): 1, ("Yes", "b"): 1}
