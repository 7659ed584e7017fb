"""Position and profile effects of choices among candidates."""

from __future__ import annotations

import json
import random
from fractions import Fraction
from itertools import permutations
from pathlib import Path

import pytest
import tiers
from envelopes import result_of

from fairaudit import InputError, certify, read_csv
from fairaudit.cli import main
from fairaudit.model.allocation import read_allocation

F = Fraction


def chances(law: object) -> dict[str, Fraction]:
    at = law.decisions.index("chosen")
    return {law.groups[g][0]: F(row[at], sum(row)) for g, row in zip(law.global_groups, law.mixed_rows, strict=True)}


def test_effects_of_a_choice_that_only_looks_at_the_slot() -> None:
    """Every order once, the first always chosen: all profiles alike, all slots but the first without a chance."""
    orders = [" ".join(order) for order in permutations("abc")]
    found = read_allocation({"shown": orders, "won": [order[0] for order in orders]}, slots="shown", winner="won")
    assert chances(found.position) == {"1": 1, "2": 0, "3": 0}
    assert chances(found.profile) == {"a": F(1, 3), "b": F(1, 3), "c": F(1, 3)}
    assert found.imbalance == 0
    assert found.warnings == ()
    assert certify(found.profile, {"chosen": 1}).local.ratio == 1


def test_effects_of_a_choice_that_only_looks_at_the_profile() -> None:
    orders = [list(order) for order in permutations("abc")]
    table = {"s1": [o[0] for o in orders], "s2": [o[1] for o in orders], "s3": [o[2] for o in orders], "won": ["b"] * 6}
    found = read_allocation(table, slots=["s1", "s2", "s3"], winner="won")
    assert chances(found.position) == {"1": F(1, 3), "2": F(1, 3), "3": F(1, 3)}
    assert chances(found.profile) == {"a": 0, "b": 1, "c": 0}


def test_fixed_slots_are_warned_about() -> None:
    found = read_allocation({"shown": ["ann bob"] * 50, "won": ["ann"] * 40 + ["bob"] * 10}, slots="shown", winner="won")
    assert "cannot be told apart" in found.warnings[0]
    rng = random.Random(tiers.fresh(2))
    skewed = ["ann bob" if rng.random() < 0.9 else "bob ann" for _ in range(500)]
    found = read_allocation({"shown": skewed, "won": ["ann"] * 500}, slots="shown", winner="won")
    assert "not balanced" in found.warnings[0]


ALL = [" ".join(order) for order in permutations("abc")]
TURNING = ["a b c", "b c a", "c a b"]


@pytest.mark.parametrize(
    ("shown", "context"),
    [
        (TURNING * 20, None),  # every profile stands equally often in every slot, in 3 of 6 orders
        (ALL * 5 + ["a b c"] * 60 + ["b c a"] * 60 + ["c a b"] * 60, None),
        ([*TURNING * 20, *(" ".join(reversed(o.split())) for o in TURNING * 20)], ["x"] * 60 + ["y"] * 60),
        ([" ".join(f"{name}{k}" for name in order.split()) for k in range(40) for order in TURNING], None),  # never the same candidates
    ],
)
def test_orders_that_are_missing_or_too_frequent(
    shown: list[str], context: list[str] | None, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """T10 needs an order drawn from all: a cyclic rotation is balanced, and still tells who stands where."""
    table = {"shown": shown, "won": [order.split()[0] for order in shown], **({"job": context} if context else {})}
    found = read_allocation(table, slots="shown", winner="won", context="job" if context else None)
    assert found.imbalance == 0 or len(found.profile.groups) > 3
    assert "not drawn uniformly from all orders" in found.warnings[-1]
    path = tmp_path / "runs.csv"
    path.write_text("\n".join([",".join(table), *(",".join(row) for row in zip(*table.values(), strict=True))]) + "\n")
    command = [
        "certify",
        str(path),
        "--slots",
        "shown",
        "--winner",
        "won",
        "--profile-exp-epsilon",
        "7/3",
        *(["--context", "job"] if context else []),
    ]
    main(command)
    out = capsys.readouterr().out
    assert "No bound for a random order (T10)" in out and "5.44" not in out and "\nWARNING: " in out
    main([*command, "--verbose"])
    assert "No bound for a random order (T10)" in capsys.readouterr().out
    main([*command, "--format", "json"])
    assert result_of(capsys.readouterr().out)["random_order_bound"] is None


def test_random_orders_are_not_warned_about() -> None:
    """At most 1 of 1,000 logs; of 300 small and large ones none was."""
    rng = random.Random(tiers.fresh(11))
    for size, runs in ((2, 5), (2, 400), (3, 4), (3, 30), (3, 600), (4, 50), (4, 500), (8, 60)):
        for _ in range(40):
            names = [f"p{i}" for i in range(size + rng.choice((0, 0, 2)))]
            shown = [" ".join(rng.sample(names, size)) for _ in range(runs)]
            found = read_allocation({"shown": shown, "won": [o.split()[0] for o in shown]}, slots="shown", winner="won")
            assert not any("not drawn uniformly" in text for text in found.warnings)


def test_resume_rankings(data: Path) -> None:
    """Position effect of the first-listed resume: 56 % of the wins for gpt-3.5-turbo, 28 % for gpt-4, over 4,000 runs each."""
    table = read_csv(data / "bloomberg_gpt_rankings.csv")
    keep = [i for i, batch in enumerate(table["batch"]) if batch != "oversampled"]
    part = {name: [table[name][i] for i in keep] for name in table.columns}
    found = read_allocation(part, slots="shown_order", winner="ranked_order", context="model")
    law = found.position
    at = law.decisions.index("chosen")
    first = {}
    for cell, (x, a) in enumerate(zip(law.cell_context.tolist(), law.cell_group.tolist(), strict=True)):
        if law.groups[a] == ("1",):
            first[law.contexts[x][0]] = F(int(law.weights[cell][at]), sum(law.row(cell)))
    assert {model: round(float(chance), 2) for model, chance in first.items()} == {"gpt-3.5-turbo": 0.56, "gpt-4": 0.28}
    # The profile effect over the jobs of one model equals that of the published counts of who was ranked first.
    counts = read_csv(data / "gpt_resume_first_counts.csv")
    wins: dict[tuple[str, str], int] = {}
    for model, group, decision, n in zip(counts["model"], counts["group"], counts["decision"], counts["n"], strict=True):
        if decision == "first":
            wins[model, group] = wins.get((model, group), 0) + int(n)
    law = found.profile
    for cell, (x, a) in enumerate(zip(law.cell_context.tolist(), law.cell_group.tolist(), strict=True)):
        assert int(law.weights[cell][law.decisions.index("chosen")]) == wins[law.contexts[x][0], law.groups[a][0]]


@pytest.mark.parametrize(
    ("table", "word"),
    [
        ({"shown": ["a b", "a b c"], "won": ["a", "a"]}, "same number"),
        ({"shown": ["a b"], "won": ["c"]}, "not among"),
        ({"shown": ["a a"], "won": ["a"]}, "twice"),
        ({"shown": ["a"], "won": ["a"]}, "two candidates"),
        ({"shown": [""], "won": ["a"]}, "missing"),
        ({"shown": ["a b"], "won": [""]}, "missing"),
        ({"shown": [], "won": []}, "no rows"),
        ({"shown": ["a b"], "one": ["a"]}, "no column 'won'"),
    ],
)
def test_refusals(table: dict[str, list[str]], word: str) -> None:
    with pytest.raises(InputError, match=word):
        read_allocation(table, slots="shown", winner="won")


def test_the_command(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path, target = tmp_path / "runs.csv", tmp_path / "c.json"
    path.write_text("shown,won\n" + "".join(f"{' '.join(o)},{o[0] if i % 2 else 'b'}\n" for i, o in enumerate([*permutations("abc")] * 5)))
    command = ["certify", str(path), "--slots", "shown", "--winner", "won", "--profile-exp-epsilon", "7/3"]
    assert main([*command, "-o", str(target)]) == 0
    out = capsys.readouterr().out
    assert "Position effect" in out
    beside = tmp_path / "c.position.json"
    assert f"fairaudit verify {target} {beside}" in out.splitlines()  # both, in a line to copy
    assert main(["verify", str(target), str(beside)]) == 0
    assert main([*command, "-o", str(target), "--no-table"]) == 0
    assert f"--table {tmp_path / 'c.table.jsonl'}" in capsys.readouterr().out
    assert main([*command, "-o", str(target)]) == 0
    capsys.readouterr()
    assert "at most a factor 5.445 (T10)" in " ".join(out.split()) and len(out.splitlines()) <= 40
    main([*command, "--verbose"])
    assert "5.444" in capsys.readouterr().out
    assert main(["verify", str(target)]) == 0
    assert main(["verify", str(tmp_path / "c.position.json")]) == 0
    capsys.readouterr()
    assert main([*command, "--max-local-ratio", "5/4", "--confidence", "none"]) == 1
    capsys.readouterr()
    assert main([*command, "--format", "json"]) == 0
    printed = result_of(capsys.readouterr().out)
    assert (printed["random_order_bound"], printed["slots"], printed["imbalance"]) == ("49/9", 3, "0")
    for extra, word in (
        (["--utility", "x"], "--utility"),
        (["--confidence", "2"], "--confidence '2' is not accepted"),
        (["--unit", "won"], "--unit does not go with --slots"),
        (["--profile-exp-epsilon", "1/2"], "at least 1"),
    ):
        assert main([*command, *extra]) == 2
        assert word in capsys.readouterr().err
    assert main(["certify", str(path), "--winner", "won"]) == 2


def choices(folder: Path, rows: int = 4000) -> list[dict[str, str]]:
    """Runs of eleven candidates, so that the second slot comes before the tenth; written as CSV, Parquet, JSON lines and databases."""
    import sqlite3

    import duckdb

    rng = random.Random(tiers.fresh(3))
    orders = [rng.sample([f"p{i}" for i in range(11)], 11) for _ in range(40)]
    drawn = [(orders[rng.randrange(40)], rng.choice("xü"), rng.randrange(15, 80)) for _ in range(rows)]
    listed = [{"shown": " ".join(order), "won": order[rng.randrange(4)], "job": job, "age": str(age)} for order, job, age in drawn]
    (folder / "runs.csv").write_text("\n".join(["shown,won,job,age", *(",".join(row.values()) for row in listed)]) + "\n")
    (folder / "runs.jsonl").write_text("".join(json.dumps(row) + "\n" for row in listed))
    shuffled = rng.sample(listed, rows)
    (folder / "shuffled.csv").write_text("\n".join(["shown,won,job,age", *(",".join(row.values()) for row in shuffled)]) + "\n")
    held = f"select * from read_csv('{folder}/runs.csv', all_varchar=true)"
    duckdb.sql(f"copy ({held}) to '{folder}/runs.parquet'")
    with duckdb.connect(str(folder / "runs.duckdb")) as connection:
        connection.execute(f"create table runs as {held}")
    database = sqlite3.connect(folder / "runs.db")
    database.execute("create table runs (shown, won, job, age)")
    database.executemany("insert into runs values (:shown, :won, :job, :age)", listed)
    database.commit()
    database.close()
    return listed


def test_every_holder_of_the_choices_gives_the_same_certificates(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    listed = choices(tmp_path)
    command = ["--slots", "shown", "--winner", "won", "--context", "job,age:30,65", "--max-local-ratio", "3/2"]
    found = set()
    for words in (
        [tmp_path / "runs.csv"],
        [tmp_path / "runs.csv", "--engine", "duckdb"],
        [tmp_path / "shuffled.csv"],
        [tmp_path / "runs.jsonl"],
        [tmp_path / "runs.parquet"],
        [tmp_path / "run*.parquet"],
        [f"sqlite:{tmp_path / 'runs.db'}", "--table", "runs"],
        [f"duckdb:{tmp_path / 'runs.duckdb'}", "--query", "select * from runs"],
    ):
        code = main(["certify", *map(str, words), *command, "-o", str(tmp_path / "c.json"), "--verbose"])
        printed = capsys.readouterr()
        assert printed.err == ""
        found.add((code, printed.out, *(path.read_text() for path in sorted(tmp_path.glob("c.*json*")))))
    assert len(found) == 1
    assert main(["verify", str(tmp_path / "c.json")]) == 0
    frame = {name: [row[name] for row in listed] for name in ("shown", "won", "job")}
    law = read_allocation(frame, slots="shown", winner="won", context="job").position
    assert [group for (group,) in law.groups] == [str(slot) for slot in range(1, 12)]
    assert law.contexts == (("x",), ("ü",))


def test_bad_choices_are_named_wherever_they_are(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    lines = [f'{{"shown": "a b", "won": "{won}", "job": {job}}}' for won, job in (("a", '"x"'), ("b", '"y"'), ("c", '"x"'))]
    (tmp_path / "runs.jsonl").write_text("\n".join(lines) + "\n")
    (tmp_path / "runs.csv").write_text("shown,won,job\na b,a,x\na b,c,x\n")
    (tmp_path / "blank.csv").write_text("shown,won,job\na b,a,x\na b,b,\n")
    for words, said in (
        (["runs.jsonl"], "'c' was chosen but is not among the candidates"),
        (["runs.csv", "--engine", "duckdb"], "column 'won', line 3: 'c' was chosen"),
        (["blank.csv"], "column 'job', line 3: the label is missing"),
        (["blank.csv", "--missing", "drop"], "--missing does not go with --slots"),
        (["runs.csv", "--context", "what"], "there is no column 'what'"),
        (["runs.csv", "--table", "t"], "a table goes with a database"),
        (["none.parquet"], "there is no such file"),
        (["sqlite:none.db", "--table", "t"], "there is no such file"),
    ):
        name = words[0] if ":" in words[0] else str(tmp_path / words[0])
        given = ["--context", "job"] if "--context" not in words else []
        assert main(["certify", name, *words[1:], "--slots", "shown", "--winner", "won", *given]) == 2
        out, err = capsys.readouterr()
        assert out == "" and err.count("\n") == 1 and said in err
