"""What was left out is counted by group wherever the group is known, by every reader alike; the checker holds it against the table."""

from __future__ import annotations

import json
import random
from collections import Counter
from fractions import Fraction
from pathlib import Path
from typing import Any

import pandas as pd
import pytest
from certificate_changes import named_anew
from certificate_kinds import outcome

import fairaudit as fa
from fairaudit.audits.in_parts import certify_in_parts
from fairaudit.cli import main

Row = tuple[str, str, str, str, int]
NAMES = ("d", "g", "h", "x", "n")


def drawn(seed: int) -> list[Row]:
    """Rows of a log in which labels of every column may be missing."""
    pick = random.Random(seed)
    rows = [(d, g, h, x, 20) for d in ("yes", "no") for g in ("f", "m") for h in ("p", "q") for x in "st"]
    for _ in range(60):
        d, g, h, x = (pick.choice([*labels, ""]) for labels in (["yes", "no"], ["f", "m", "n"], "pq", "st"))
        rows.append((d, g, h, x, pick.randint(0, 9)))
    pick.shuffle(rows)
    return rows


def counted(rows: list[Row], group: tuple[str, ...]) -> dict[str, Any]:
    """The entry of the preparation, row by row."""
    lost, of = Counter[tuple[str, ...]](), Counter[tuple[str, ...]]()
    total = left = 0
    columns = Counter[str]()
    for row in rows:
        held = dict(zip(NAMES, row, strict=True))
        used = ("d", *group, "x")
        total += row[4]
        label = tuple(str(held[name]) for name in group)
        of[label] += row[4]
        if any(not held[name] for name in used):
            left += row[4]
            columns.update({name: row[4] for name in used if not held[name]})
            if all(label):
                lost[label] += row[4]
    listed = [{"group": list(label), "decisions": str(lost[label]), "of": str(of[label])} for label in sorted(lost) if lost[label]]
    by_column = {name: str(number) for name, number in columns.items() if number}
    return {"step": "left out", "reason": "missing label", "decisions": str(left), "of": str(total), "columns": by_column, "groups": listed}


def frame_of(rows: list[Row], *, taken_apart: bool = False) -> pd.DataFrame:
    """The log as a frame; taken apart, with a row for each decision and no counts."""
    held = [row[:4] for row in rows for _ in range(row[4])] if taken_apart else rows
    return pd.DataFrame(held, columns=NAMES[:4] if taken_apart else NAMES)


def entry_of(document: Any) -> Any:
    [entry] = [entry for entry in document["subject"]["preparation"] if entry["step"] == "left out"]
    return entry


@pytest.mark.parametrize("group", [("g",), ("g", "h")])
@pytest.mark.parametrize("reader", ["mapping", "csv", "pandas", "jsonl", "parquet", "counts"])
def test_every_reader_counts_by_group(reader: str, group: tuple[str, ...], tmp_path: Path) -> None:
    for seed in range(3):
        rows = drawn(seed)
        frame = frame_of(rows, taken_apart=reader not in ("mapping", "counts"))
        count: dict[str, Any] = {"count": "n"} if reader in ("mapping", "counts") else {}
        source: Any = {"mapping": {name: list(frame[name]) for name in frame}, "pandas": frame}.get(reader)
        if source is None:
            source = tmp_path / f"log{seed}.{'csv' if reader in ('csv', 'counts') else reader}"
            if reader == "jsonl":
                frame.to_json(source, orient="records", lines=True)
            elif reader == "parquet":
                frame.to_parquet(source)
            else:
                frame.to_csv(source, index=False)
        made = fa.audit(source, decision="d", group=list(group), context="x", utility="yes", missing="drop", confidence=None, **count)
        document = json.loads(made.certificate.text)
        assert entry_of(document) == counted(rows, group)
        assert outcome(json.dumps(document).encode()) == "true"


@pytest.mark.parametrize("group", [("g",), ("g", "h")])
def test_a_log_that_is_read_in_parts_is_counted_by_group(group: tuple[str, ...], tmp_path: Path) -> None:
    for seed in range(3):
        rows = drawn(seed)
        frame_of(rows).to_parquet(tmp_path / "log.parquet")
        made = certify_in_parts(
            tmp_path / "log.parquet", {"yes": 1}, decision="d", group=list(group), context="x", count="n", missing="drop", embed_table=True
        )
        assert dict(made.preparation[0]) == counted(rows, group)
        apart = fa.audit(tmp_path / "log.parquet", decision="d", group=list(group), context="x", count="n", utility="yes", missing="drop")
        assert made.certificate.document["subject"]["table"]["sha256"] == apart.certificate.document["subject"]["table"]["sha256"]


def test_fractions_of_decisions_are_counted_by_group() -> None:
    log = {"d": ["y", "n", "", "y", "n", ""], "g": ["f", "f", "f", "m", "m", ""], "n": ["1/2", "3", "1/3", "2", "5", "1/7"]}
    made = fa.audit(log, decision="d", group="g", count="n", utility="y", missing="drop", confidence=None)
    assert entry_of(made.certificate.document)["groups"] == [{"group": ["f"], "decisions": "1/3", "of": str(Fraction(23, 6))}]


def test_groups_after_merging_are_those_of_the_table() -> None:
    log = {"d": ["y", "n", "", "y", "n", ""], "g": ["f", "F", "F ", "m", "m", "man"]}
    made = fa.audit(log, decision="d", group="g", utility="y", missing="drop", fold_labels=True, label_map={"g": {"man": "m"}})
    groups = entry_of(made.certificate.document)["groups"]
    assert [(own["group"], own["decisions"], own["of"]) for own in groups] == [(["F"], "1", "3"), (["m"], "1", "3")]


def test_a_group_of_which_all_are_left_out_is_named() -> None:
    made = fa.audit({"d": ["y", "n", "y", ""], "g": ["f", "f", "m", "x"]}, decision="d", group="g", utility="y", missing="drop")
    assert entry_of(made.certificate.document)["groups"] == [{"group": ["x"], "decisions": "1", "of": "1"}]
    assert outcome(made.certificate.text.encode()) == "true"


def test_a_table_that_is_not_disclosed_discloses_no_group() -> None:
    log = {"d": ["y", "n", "y", ""], "g": ["f", "f", "m", "m"]}
    made = fa.audit(log, decision="d", group="g", utility="y", missing="drop", embed_table=False)
    assert made.certificate.table is not None
    assert entry_of(made.certificate.document)["groups"] is None
    assert outcome(made.certificate.text.encode(), list(made.certificate.table.lines())) == "true"
    [disclosed] = fa.audit(log, decision="d", group="g", utility="y", missing="drop").preparation
    assert disclosed["groups"] == [{"group": ["m"], "decisions": "1", "of": "2"}]


def altered(groups: list[Any], seed: int) -> list[Any] | None:
    """Other amounts, another group, one less, one more, or another order."""
    pick = random.Random(seed)
    changed = json.loads(json.dumps(groups))
    own = pick.choice(changed)
    what = pick.randrange(6)
    if what == 0:
        own["decisions"] = str(max(1, int(own["decisions"]) + pick.choice([-3, -1, 1, 50])))
    elif what == 1:
        own["of"] = str(max(1, int(own["of"]) + pick.choice([-3, -1, 1, 50])))
    elif what == 2:
        own["group"] = [pick.choice("fmnz")]
    elif what == 3:
        changed.remove(own)
    elif what == 4:
        changed.append({"group": ["z"], "decisions": "1", "of": pick.choice(["1", "2"])})
    else:
        changed.reverse()
    return None if changed == groups else changed


def test_what_is_altered_is_false_or_malformed_or_no_other_than_the_table_says() -> None:
    """With all digests made anew. Of a group that is in the table, what is left of it is; how many had no label, no table shows."""
    found = Counter[str]()
    for seed in range(120):
        rows = [(d, g if seed % 2 or d else g or "f", h, x, n) for d, g, h, x, n in drawn(seed % 7)]
        made = fa.audit(frame_of(rows), decision="d", group="g", count="n", utility="yes", missing="drop", confidence=None)
        document = json.loads(made.certificate.text)
        entry = entry_of(document)
        before = entry["groups"]
        after = altered(before, seed)
        if after is None:
            continue
        entry["groups"] = after
        left = {tuple(own["group"]): int(own["of"]) - int(own["decisions"]) for own in before}
        said = outcome(named_anew(json.dumps(document).encode()))
        found[said] += 1
        if said == "true":  # the table cannot tell
            header = document["subject"]["table"]["header"]
            kept = Counter[tuple[str, ...]]()
            for row in document["subject"]["table"]["rows"]:
                kept[tuple(header["groups"][row["group"]])] += sum(map(int, row["weights"]))
            assert all(int(own["of"]) - int(own["decisions"]) == kept[tuple(own["group"])] for own in after)
            assert sum(int(own["decisions"]) for own in after) <= int(entry["decisions"])
        assert left
    assert found["false"] > 40 and found["malformed"] > 5


@pytest.fixture
def undecided_on_one_group(tmp_path: Path) -> Path:
    """Of 500 decisions on one group, 480 are missing: the field's log, and small."""
    rows = [("yes", "asian")] * 480 + [("no", "asian")] * 520 + [("yes", "white")] * 500 + [("no", "white")] * 500
    rows += [("yes", "black")] * 20 + [("", "black")] * 480
    path = tmp_path / "m2.csv"
    pd.DataFrame(rows, columns=["d", "g"]).to_csv(path, index=False)
    return path


WORDS = ("--decision", "d", "--group", "g", "--utility", "yes")


def test_whom_it_hit_is_said_first(undecided_on_one_group: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = undecided_on_one_group
    saved = path.with_suffix(".json")
    assert main(["certify", str(path), *WORDS, "--missing", "drop", "-o", str(saved), "--report", str(path.with_suffix(".html"))]) == 0
    text = " ".join(capsys.readouterr().out.split())
    said = "Left out for a missing label: 480 of the 500 decisions on 'black' (96 %), and none on other groups."
    assert text.index(said) < text.index("g=black 100 % (20 of 20)")
    assert "480 of the 500 decisions" in path.with_suffix(".html").read_text("utf-8")
    assert main(["verify", str(saved)]) == 0
    assert 'Left out for a missing label: 480 of the 500 decisions on "black".' in " ".join(capsys.readouterr().out.split())


def test_equal_shares_are_no_headline(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    rows = [(d, g) for d, n in (("yes", 30), ("no", 20), ("", 5)) for g in "fm" for _ in range(n)]
    path = tmp_path / "log.csv"
    pd.DataFrame(rows, columns=["d", "g"]).to_csv(path, index=False)
    assert main(["certify", str(path), *WORDS, "--missing", "drop"]) == 0
    text = " ".join(capsys.readouterr().out.split())
    assert "Left out for a missing label" not in text
    assert "('d': 10; by group: 'f' 5 of 55, 'm' 5 of 55)" in text
