"""Lines that a monitor leaves out, by group, against a plain loop over the lines of its log."""

from __future__ import annotations

import csv
import io
import json
import random
import sqlite3
from collections import Counter
from pathlib import Path
from typing import Any

import pytest
from envelopes import result_of

from fairaudit.cli import main
from fairaudit.streams import labels as resolver
from fairaudit.streams import left_out, tail
from fairaudit.streams.left_out import LeftOut
from fairaudit.streams.settings import Settings
from fairaudit.streams.state import State
from fairaudit.streams.stream import Monitor

AUDIT: dict[str, Any] = {"group": ("sex", "origin"), "context": ("job",), "decision": "answer", "utility": {"yes": "1"}}
FORMS = {
    "json": Settings(**AUDIT),
    "csv": Settings(**AUDIT, layout="csv"),
    "all": Settings(**AUDIT, event_id="id", time="t", since="100"),
}
COLUMNS = ("job", "sex", "origin", "answer", "id", "t")
LATER = 10**11

Line = dict[str, Any] | str


def lines(number: int, seed: int) -> list[Line]:
    """A log in which about every third line lacks something."""
    rng, listed = random.Random(seed), list[Line]()
    for k in range(number):
        group = {"sex": rng.choice("fm"), "origin": rng.choice(["1", "2", "é"])}
        line = {"job": rng.choice(["cook", "clean"]), **group, "answer": rng.choice(["yes", "no", "later"]), "t": "200"}
        line["id"] = f"{sorted(group.values())} {rng.randrange(20) if rng.random() < 0.3 else f'new {k}'}"
        fault = rng.choice([*COLUMNS, "early", "future", "broken", *[None] * 18])
        if fault in COLUMNS:
            line[fault] = ""
        elif fault:
            line["t"] = {"early": "50", "future": str(LATER)}.get(fault, "200")
        listed.append(rng.choice(["no line", "x,y"]) if fault == "broken" else line)
    return listed


def counted_by_hand(listed: list[Line], settings: Settings) -> tuple[Counter[Any], Counter[Any]]:
    """By group, or None, and reason how many lines are left out; and how many are counted."""
    lost, counted, seen = Counter[Any](), Counter[Any](), set[str]()
    for line in listed:
        if isinstance(line, str):
            lost[None, "dead"] += 1
            continue
        group = (line["sex"], line["origin"])
        known = group if all(group) else None
        if not (known and line["job"] and line["answer"]):
            lost[known, "dead"] += 1
        elif settings.event_id is None:
            counted[group] += 1
        elif not (line["id"] and line["t"]) or int(line["t"]) == LATER:
            lost[group, "dead"] += 1
        elif int(line["t"]) < 100:
            lost[group, "early"] += 1
        elif line["id"] in seen:
            lost[group, "repeats"] += 1
        else:
            seen.add(line["id"])
            counted[group] += 1
    return lost, counted


def written(path: Path, listed: list[Line], settings: Settings, mode: str = "w") -> Path:
    text = io.StringIO()
    if settings.layout == "csv":
        table = csv.writer(text, lineterminator="\n")
        table.writerows([COLUMNS] if mode == "w" else [])
        for line in listed:
            if isinstance(line, str):
                text.write(line + "\n")
            else:
                table.writerow([line[name] for name in COLUMNS])
    else:
        text.writelines((line if isinstance(line, str) else json.dumps(line)) + "\n" for line in listed)
    with path.open(mode, encoding="utf-8") as file:
        file.write(text.getvalue())
    return path


def read(log: Path, settings: Settings, state: Path | None = None) -> Monitor:
    with Monitor(State(None if state is None else str(state), settings), str(log)) as monitor:
        monitor.catch_up()
    return monitor


def lost_of(found: LeftOut) -> Counter[Any]:
    """The same as a plain loop has it."""
    assert not found.other
    return Counter({(group, why): n for group, counts in [*found.groups.items(), (None, found.unknown)] for why, n in counts.items() if n})


@pytest.mark.parametrize("form", FORMS)
@pytest.mark.parametrize("seed", [0, *(pytest.param(seed, marks=pytest.mark.deep) for seed in range(1, 8))])
def test_lines_left_out_are_counted_by_group_in_whatever_order_and_after_a_restart(tmp_path: Path, form: str, seed: int) -> None:
    settings, listed = FORMS[form], lines(600, seed)
    lost, counted = counted_by_hand(listed, settings)
    assert {group is None for group, why in lost if why == "dead"} == {True, False}
    assert {why for _, why in lost} == ({"dead", "repeats", "early"} if settings.event_id else {"dead"})
    whole = read(written(tmp_path / "log", listed, settings), settings)
    assert lost_of(whole.left_out) == lost
    assert whole.total.by_group() == counted
    assert {why: whole.left_out.total(why) for why in left_out.WHY} == {why: whole.tally[why] for why in left_out.WHY}

    shuffled = random.Random(seed + 1).sample(listed, len(listed))
    assert read(written(tmp_path / "shuffled", shuffled, settings), settings).left_out.kept() == whole.left_out.kept()

    log, state = written(tmp_path / "halves", listed[:250], settings), tmp_path / "state.db"
    read(log, settings, state)
    written(log, listed[250:], settings, "a")
    assert read(log, settings, state).left_out.kept() == whole.left_out.kept()
    assert read(log, settings, state).left_out.kept() == whole.left_out.kept()


def test_a_state_of_before_goes_on_with_groups_that_are_not_known(tmp_path: Path) -> None:
    settings, listed = FORMS["all"], lines(600, 3)
    first, lost = (counted_by_hand(part, settings)[0] for part in (listed[:250], listed))
    log, state = written(tmp_path / "log", listed[:250], settings), tmp_path / "state.db"
    read(log, settings, state)
    with sqlite3.connect(state) as database:
        assert database.execute("delete from meta where key = 'left_out'").rowcount == 1
    database.close()
    written(log, listed[250:], settings, "a")
    expected = lost - first
    for (_, why), n in first.items():
        expected[None, why] += n
    for _ in range(2):
        assert lost_of(read(log, settings, state).left_out) == expected


@pytest.mark.parametrize("seed", [0, *(pytest.param(seed, marks=pytest.mark.deep) for seed in range(1, 20))])
def test_of_many_groups_those_with_short_names_are_held_in_whatever_order(monkeypatch: pytest.MonkeyPatch, seed: int) -> None:
    monkeypatch.setattr(left_out, "GROUPS", 5)
    rng = random.Random(seed)
    drawn = [(str(rng.randrange(30)), rng.choice("xy")) for _ in range(300)] + [("long" * 100, "z")] * 3
    lost = Counter((group, rng.choice(["dead", "repeats"])) for group in [*drawn, *[None] * 30])
    names = sorted({group for group in drawn if group[1] != "z"}, key=lambda group: (len(group[0]), group))[:5]
    found = []
    for _ in range(3):
        adding = rng.sample([*lost.elements()], lost.total())
        whole, earlier = LeftOut(), LeftOut()
        for k, (group, why) in enumerate(adding):
            whole.add(why, group)
            if k == 150:
                earlier = LeftOut(json.loads(json.dumps(whole.kept())))
                whole = LeftOut(json.loads(json.dumps(whole.kept())))
        found.append(whole.kept())
        for why in ("dead", "repeats"):
            assert {group: whole.groups[group][why] for group in names} == {group: lost[group, why] for group in names}
            assert whole.other[why] == sum(n for (group, reason), n in lost.items() if reason == why and group not in [*names, None])
            assert whole.unknown[why] == lost[None, why]
        after, later = whole.since(earlier), Counter(adding[151:])
        assert {(group, why): n for group in names for why, n in after.groups[group].items()} == {
            at: n for at, n in later.items() if at[0] in names
        }
        assert after.other.total() == sum(n for (group, _), n in later.items() if group not in [*names, None])
        assert after.unknown == Counter({why: n for (group, why), n in later.items() if group is None})
    assert len(whole.groups) == 5 and found[0] == found[1] == found[2]


def test_screen_json_alarm_and_certificate_say_whom_it_hit(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """A log whose alarm comes after lines were lost, and that loses more later."""
    good = [{"sex": sex, "answer": answer} for sex, answer in [("f", "yes"), ("m", "yes"), ("m", "no"), ("m", "no")] for _ in range(300)]
    lost: list[Line] = [{"sex": "f"}] * 7 + [{"sex": "m\x1b"}] * 2 + ["broken"] * 4
    log, state = tmp_path / "log.jsonl", str(tmp_path / "state.db")
    settings = Settings(group=("sex",), decision="answer", utility={"yes": "1"})
    written(log, [*good, *lost], settings)
    command = ["monitor", str(log), "--state", state, "--decision", "answer", "--group", "sex", "--utility", "yes"]
    assert main([*command, "--max-local-ratio", "5/4", "--format", "json"]) == 1
    nothing = {"dead_letters": 0, "repeats": 0, "before_since": 0}
    expected = {
        "groups": [
            {"group": {"sex": "f"}, "counted": 300, **nothing, "dead_letters": 7},
            {"group": {"sex": "m\x1b"}, "counted": 0, **nothing, "dead_letters": 2},
        ],
        "other_groups": nothing,
        "unknown_group": {**nothing, "dead_letters": 4},
    }
    said = [result_of(line) for line in capsys.readouterr().out.splitlines()]
    assert [entry["left_out"] for entry in said] == [expected] * len(said)
    assert {entry["event"] for entry in said} == {"alarm", "look"}

    written(log, [{"sex": "f"}, {"sex": "d"}], settings, "a")
    assert main(["monitor", "--state", state, "--format", "text"]) == 1
    shown = " ".join(capsys.readouterr().out.split())
    assert (
        "15 lines could not be read: sex=f 8 (300 counted), sex=m\\x1b 2 (0 counted), sex=d 1 (0 counted), group unknown 4"
        in shown.replace("\\x1B", "\\x1b")
    )
    for option, n, groups in (([], 15, "sex=f 8 (300 counted)"), (["--at-alarm"], 13, "sex=f 7 (300 counted)")):
        assert main(["certify", "--from-monitor", state, *option, "-o", str(tmp_path / "c.json"), "--format", "json"]) == 1
        (note,) = [note for note in json.loads(capsys.readouterr().out)["notes"] if "could not be counted" in note]
        assert note.startswith(f"{n} lines could not be counted: {groups}, sex=m"), note
        preparation = json.loads((tmp_path / "c.json").read_text())["subject"]["preparation"]
        assert {key for entry in preparation for key in entry} == {"step", "reason", "lines"}, "the form of the certificate is as before"
        assert main(["verify", str(tmp_path / "c.json")]) == 0
        capsys.readouterr()


def test_a_group_is_read_where_the_path_of_another_column_leads_nowhere(tmp_path: Path) -> None:
    settings = Settings(group=("who.sex",), decision="said.answer", utility={"yes": "1"})
    listed: list[Line] = [
        {"who": {"sex": "f"}, "said": [1]},
        {"who": {"sex": "f"}, "said": {"answer": ["yes"]}},
        {"who": {"sex": 1.50}, "said": {}},
        {"who": [1], "said": {"answer": "yes"}},
        {"who": {"sex": ["f"]}, "said": {"answer": "yes"}},
    ]
    found = read(written(tmp_path / "log", listed, settings), settings).left_out
    assert lost_of(found) == Counter({(("f",), "dead"): 2, (("1.5",), "dead"): 1, (None, "dead"): 2})


def test_a_group_with_a_long_name_is_one_of_the_others() -> None:
    """Of whatever size a label is, the state stays small."""
    found = LeftOut()
    for length in (100, 101):
        found.add("dead", ("x" * 100, "y" * length))
    assert found.kept() == {"groups": [[["x" * 100, "y" * 100], {"dead": 1}]], "other": {"dead": 1}, "unknown": found.unknown}


def test_screen_lists_the_groups_that_lost_most() -> None:
    found = LeftOut()
    for number in range(9):
        for _ in range(number + 1):
            found.add("repeats", (str(number),))
    said = left_out.said(found.entry(["g"], {("8",): 5}), "repeats")
    assert said.startswith("g=8 9 (5 counted), g=7 8 (0 counted), ")
    assert said.endswith("g=3 4 (0 counted), other groups 6") and said.count("g=") == left_out.SHOWN
    assert not left_out.said(found.entry(["g"], {}), "dead_letters")


@pytest.mark.parametrize("chunk", [40, 1_000, 200_000])
def test_lines_of_more_cells_than_are_held_are_said_and_not_lost(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, chunk: int) -> None:
    """Also where cells come to be too many among lines that were gathered and not counted yet."""
    monkeypatch.setattr(resolver, "MAX_CELLS", 10)
    monkeypatch.setattr(tail, "CHUNK", chunk)
    rng = random.Random(chunk)
    drawn = [str(rng.randrange(k // 10 + 1)) for k in range(300)]
    first = list(dict.fromkeys(drawn))[:10]
    settings = Settings(group=("sex",), decision="answer", utility={"yes": "1"})
    found = read(written(tmp_path / "log", [{"sex": sex, "answer": "yes"} for sex in drawn], settings), settings)
    assert found.total.by_group() == Counter((sex,) for sex in drawn if sex in first)
    assert lost_of(found.left_out) == Counter(((sex,), "dead") for sex in drawn if sex not in first)
    assert found.events + found.tally["dead"] == len(drawn)
