"""Two logs compared: whether the second is less fair, with and without the units of both."""

from __future__ import annotations

import json
from fractions import Fraction
from pathlib import Path
from typing import Any

import pytest
from envelopes import result_of

import fairaudit as fa
from fairaudit.audits.reading import Reading
from fairaudit.audits.two_logs import compare_logs
from fairaudit.cli import main as command
from fairaudit.inference.paired_rates import greatest_change
from fairaudit.theorems.assumptions import BY_DESIGN, PAIRED

F = Fraction
COLUMNS = ["--decision", "answer", "--group", "race", "--utility", "yes"]


def log(path: Path, answers: dict[str, list[int]], *, shift: int = 0, start: int = 0, unit: bool = True) -> str:
    """A log in which so many of the units of each group got yes: of (yes, all, exchanged) the last answers are exchanged for others."""
    rows = ["id,race,answer" if unit else "race,answer"]
    for group, (yes, units, other) in answers.items():
        for i in range(units):
            got = i < yes if i % 100 >= other or not shift else i >= yes
            rows.append(f"{f'{group}{start + i},' if unit else ''}{group},{'yes' if got else 'no'}")
    path.write_text("\n".join(rows) + "\n")
    return str(path)


def compared(old: str, new: str, *, unit: tuple[str, ...] = ("id",), margin: str = "1.1", **options: Any) -> Any:
    reading = Reading("answer", ("race",), unit=unit)
    asked = {"independent": False, "missing_units": "worst", **options}
    return compare_logs(old, new, reading, fa.Utility({"yes": 1}), confidence=F(19, 20), margin=F(margin), options=asked)


def test_logs_that_nearly_agree_are_no_less_fair_within_a_margin(tmp_path: Path) -> None:
    """Their own intervals leave it open; unit by unit little changed."""
    old = log(tmp_path / "old.csv", {"w": [350, 500, 0], "b": [300, 500, 0]})
    new = log(tmp_path / "new.csv", {"w": [350, 500, 1], "b": [300, 500, 1]}, shift=1)
    found = compared(old, new)
    local, overall = found.found.fairness
    assert (local.quantity, local.verdict, local.confidence) == ("local", "no less fair", F(19, 20))
    assert overall.verdict == "not established" and overall.ratio[1] > F(11, 10) > local.ratio[1]
    assert {rate.group: rate.units for rate in found.rates} == {("b",): 500, ("w",): 500} and found.unpaired == ""
    alone = compared(old, new, unit=())
    assert alone.found.fairness[0].verdict == "not established" and alone.rates == () and "unit" in alone.unpaired


def test_the_ends_are_those_of_both_logs_at_half_of_the_error(tmp_path: Path) -> None:
    old = log(tmp_path / "old.csv", {"w": [300, 500, 0], "b": [280, 500, 0]})
    new = log(tmp_path / "new.csv", {"w": [450, 500, 0], "b": [150, 500, 0]})

    def ends(path: str, confidence: str) -> tuple[Any, Any]:
        law = fa.Law.from_log(fa.read_csv(path), decision="answer", group="race", unit="id")
        interval = fa.certify(law, {"yes": 1}, confidence=confidence, one_sided=True).intervals["local"]
        assert interval.ends == "each"
        return interval.lower, interval.upper

    for unit in ((), ("id",)):
        found = compared(old, new, unit=unit)
        local = found.found.fairness[0]
        assert local.verdict == "less fair" and local.ratio[0] == ends(new, "0.975")[0] / ends(old, "0.975")[1]
        back = compared(new, old, unit=unit, margin="1").found.fairness[0]
        assert back.verdict == "no less fair"
        half = "0.9875" if unit else "0.975"  # with units the error is shared with the second way
        assert back.ratio[1] == ends(old, half)[1] / ends(new, half)[0]


def test_of_two_ways_the_better_one_counts_with_its_part_of_the_error(tmp_path: Path) -> None:
    old = log(tmp_path / "old.csv", {"w": [350, 500, 0], "b": [300, 500, 0]})
    found = compared(old, old)
    cells = {((), (group,)): {(F(1), F(1)): yes, (F(0), F(0)): 500 - yes} for group, yes in (("b", 300), ("w", 350))}
    assert found.found.fairness[0].ratio[1] == greatest_change(cells, F(1), F(1, 40))
    assert PAIRED in found.found.fairness[0].assumptions and BY_DESIGN not in found.found.fairness[0].assumptions
    assert [(rate.old, rate.new) for rate in found.rates] == [(F(3, 5), F(3, 5)), (F(7, 10), F(7, 10))]


def test_units_that_only_one_log_has_are_not_compared_unless_by_design(tmp_path: Path) -> None:
    old = log(tmp_path / "old.csv", {"w": [350, 500, 0], "b": [300, 500, 0]})
    new = log(tmp_path / "new.csv", {"w": [350, 499, 0], "b": [300, 500, 0]})
    assert "some units are in one of the logs only" in compared(old, new).unpaired
    found = compared(old, new, missing_units="drop")
    assert found.unpaired == "" and {rate.units for rate in found.rates} == {499, 500}
    assert BY_DESIGN in found.found.fairness[0].assumptions
    apart = log(tmp_path / "apart.csv", {"w": [350, 500, 0], "b": [300, 500, 0]}, start=1000)
    assert "no unit is in both" in compared(old, apart).unpaired
    fewer = log(tmp_path / "fewer.csv", {"w": [350, 500, 0], "b": [300, 500, 0], "x": [3, 5, 0]})
    found = compared(fewer, old)
    assert "a group is in one of them only" in found.unpaired and found.found.fairness[0].verdict == "not established"


def test_the_first_log_compared_more(tmp_path: Path) -> None:
    """Nothing that was left out of the second log makes it no less fair."""
    old = log(tmp_path / "old.csv", {"w": [350, 500, 0], "b": [300, 500, 0]})
    new = Path(log(tmp_path / "new.csv", {"w": [350, 500, 0], "b": [300, 500, 0]}))
    lines = new.read_text().splitlines()
    new.write_text("\n".join([*lines, "w600,,no", "w601,,no"]) + "\n")
    reading = Reading("answer", ("race",), unit=("id",), missing="drop")
    asked = {"independent": False, "missing_units": "worst"}
    found = compare_logs(old, str(new), reading, fa.Utility({"yes": 1}), confidence=F(19, 20), margin=F(11, 10), options=asked)
    local = found.found.fairness[0]
    assert local.ratio[1] < F(11, 10) and local.verdict == "not established" and "left out (missing label), none before" in local.why


def test_the_command(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    old = log(tmp_path / "old.csv", {"w": [350, 500, 0], "b": [300, 500, 0]})
    new = log(tmp_path / "new.csv", {"w": [350, 500, 1], "b": [300, 500, 1]}, shift=1)
    worse = log(tmp_path / "worse.csv", {"w": [450, 500, 0], "b": [150, 500, 0]})
    asked = [*COLUMNS, "--unit", "id"]
    assert command(["compare", old, new, *asked, "--margin", "1.1"]) == 0
    out = capsys.readouterr().out
    assert out.startswith("NO LESS FAIR") and "Each group in the units of both logs (all ends of a column together at 95 %)" in out
    assert "Assumed, for you to judge\n  - " in out and "different sampling units are independent" in out
    assert command(["compare", old, new, *asked]) == 3 and command(["compare", old, worse, *asked]) == 1
    assert command(["compare", old, worse, *asked, "--fail-on", "verdict"]) == 0
    capsys.readouterr()
    assert command(["compare", old, new, *asked, "--format", "json", "--margin", "1.1"]) == 0
    by_unit = result_of(capsys.readouterr().out)["by_unit"]
    assert by_unit["confidence"] == "19/20" and [rate["units"] for rate in by_unit["rates"]] == [500, 500]
    assert command(["compare", old, new, *asked, "--format", "markdown"]) == 3
    assert "new/old" in capsys.readouterr().out
    assert command(["compare", old, worse, *COLUMNS, "--confidence", "none"]) == 1
    assert "Rates were not compared unit by unit" in capsys.readouterr().out


def scored(path: Path, cut: int, *, worth: bool = False) -> str:
    """Scores of 400 men and women each; women's lie lower by `cut`."""
    rows = [f"{i},{g},{i % 100 - cut * (g == 'f')}" for i in range(400) for g in "fm"]
    path.write_text("\n".join([f"id,race,{'worth' if worth else 'points'}", *rows]) + "\n")
    return str(path)


def test_scores_are_cut_as_for_a_certificate(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """The answer is that of the decisions that the cut makes, unit by unit, too."""
    files = [scored(tmp_path / f"{cut}.csv", cut) for cut in (0, 15)]
    made = []
    for name in files:
        lines = [line.split(",") for line in Path(name).read_text().splitlines()[1:]]
        cut_by_hand = "\n".join(["id,race,points", *(f"{i},{g},{'above' if int(p) > 39 else 'not above'}" for i, g, p in lines)])
        made.append(tmp_path / f"cut-{Path(name).name}")
        made[-1].write_text(cut_by_hand + "\n")
    capsys.readouterr()
    same = ["--group", "race", "--unit", "id", "--format", "json"]
    code = command(["compare", *files, "--score", "points", "--above", "39", *same])
    by_score = result_of(capsys.readouterr().out)
    assert command(["compare", *map(str, made), "--decision", "points", "--utility", "above", *same]) == code == 1
    by_hand = result_of(capsys.readouterr().out)
    assert by_score["fairness"] == by_hand["fairness"] and by_score["by_unit"] == by_hand["by_unit"] and by_hand["by_unit"]["rates"]
    own = ["compare", *files, "--score", "points", "--above-median", "--group", "race"]
    assert command(own) == 2 and "cut at their own median" in capsys.readouterr().err
    assert command([*own, "--confidence", "none"]) == 1


def test_utilities_of_a_column_are_those_of_a_certificate(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    files = [scored(tmp_path / f"{cut}.csv", cut, worth=True) for cut in (0, 15)]
    files = [str(Path(name).rename(tmp_path / f"worth-{Path(name).name}")) for name in files]
    for name in files:  # a utility is at least 0
        Path(name).write_text(Path(name).read_text().replace(",-", ","))
    words = ["--group", "race", "--utility-column", "worth", "--confidence"]
    capsys.readouterr()
    assert command(["compare", *files, *words, "0.95", "--utility-range", "0,99", "--format", "json"]) in (0, 1, 3)
    found = result_of(capsys.readouterr().out)["fairness"][0]
    for side, name in zip(("old", "new"), files, strict=True):
        table = fa.read_csv(name)
        law = fa.Law.from_log(table, decision="worth", group="race")
        utility = {label: label for label in law.decisions}
        alone = fa.certify(law, utility, declared={"m": 0, "gamma": 99}, confidence="0.975", one_sided=True).intervals["local"]
        assert found[side] == [str(alone.lower), str(alone.upper)]
    capsys.readouterr()
    assert command(["compare", *files, *words, "0.95"]) == 2 and "needs --utility-range" in capsys.readouterr().err
    assert command(["compare", *files, *words, "none"]) == 1
    assert command(["compare", *files, "--decision", "worth", "--group", "race", "--utility", "1", "--utility-range", "0,1"]) == 2


def test_labels_are_data(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    groups = {"\x1b[31m<b>\u202e|@you": [30, 50, 0], "m" * 500: [30, 50, 0]}
    logs = [log(tmp_path / f"{name}.csv", groups) for name in ("old", "new")]
    for form in ("text", "markdown", "json"):
        command(["compare", *logs, *COLUMNS, "--unit", "id", "--format", form])
        out = capsys.readouterr().out
        assert "\x1b" not in out and "\u202e" not in out
        assert form == "json" or "m" * 200 not in out.partition("Each group")[2].partition("Assumed")[0]


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (["--decision", "answer", "--group", "race"], "no utility was given"),
        (["--decision", "answer", "--utility", "yes"], "no group column was named"),
        (["--unit", "id"], "--unit goes with two logs"),
        (["--confidence", "0.9"], "--confidence goes with two logs"),
        (["--errors", "drop"], "--errors goes with two logs"),
        (["--missing", "drop"], "--missing goes with two logs"),
        (["--skip", "1"], "--skip goes with two logs"),
        (["--table", "t"], "--table goes with two logs"),
        (["--fold-labels"], "--fold-labels goes with two logs"),
        ([*COLUMNS, "--confidence", "2"], "--confidence '2' is not accepted"),
        ([*COLUMNS, "--margin", "0.5"], "a number from 1"),
        ([*COLUMNS, "--unit", "nobody"], "there is no column 'nobody'"),
    ],
)
def test_what_is_not_accepted(arguments: list[str], said: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    paths = [log(tmp_path / f"{name}.csv", {"w": [3, 5, 0], "b": [3, 5, 0]}) for name in ("old", "new")]
    assert command(["compare", *paths, *arguments]) == 2
    out, err = capsys.readouterr()
    assert out == "" and said in err and err.count("\n") == 1


def test_what_may_have_meant_anything_is_no_answer(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """At face value the second log is fair; the refused answers may all have been for one group."""
    old = log(tmp_path / "old.csv", {"w": [300, 500, 0], "b": [300, 500, 0]})
    new = Path(log(tmp_path / "new.csv", {"w": [300, 500, 0], "b": [300, 500, 0]}))
    lines = new.read_text().splitlines()
    new.write_text("\n".join(line.replace(",no", ",refused") if number % 2 else line for number, line in enumerate(lines)) + "\n")
    asked = ["compare", old, str(new), *COLUMNS, "--unit", "id", "--margin", "1.3", "--format", "json"]
    assert command(asked) == 0
    assert result_of(capsys.readouterr().out)["fairness"][0]["verdict"] == "no less fair"
    assert command([*asked, "--undecided", "refused"]) == 3
    found = result_of(capsys.readouterr().out)
    assert "some decisions may have meant anything ('refused')" in found["by_unit"]["unpaired"] and found["by_unit"]["rates"] == []
    assert F(found["fairness"][0]["new"][1]) > F(13, 10)
    assert command([*asked, "--undecided", "refusd"]) == 2
    assert "which occurs in neither of the two logs" in capsys.readouterr().err


def samples(path: Path, model: str, right: range, *, broken: int = -1, **settings: Any) -> str:
    """A log as Inspect writes it."""
    asked = {
        "model_generate_config": settings,
        "model": model,
        "task": "t",
        "config": {"epochs": 1},
        "dataset": {"sample_ids": [*range(400)], "samples": 400},
    }
    made: list[dict[str, Any]] = []
    for number in range(400):
        value = "C" if number // 2 in right else "I"
        sample = {"id": number, "epoch": 1, "metadata": {"race": "wb"[number % 2]}, "scores": {"choice": {"value": value}}}
        if number == broken:
            sample = {**sample, "error": {"message": "x"}}
        made.append({**sample, "output": {"choices": [{"stop_reason": "stop"}]}})
    path.write_text(json.dumps({"version": 2, "status": "success", "eval": asked, "samples": made}))
    return str(path)


def test_logs_of_two_models(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """Which serves people better, in one certificate; whether one is less fair, in another question."""
    one, other = samples(tmp_path / "a.json", "a", range(180)), samples(tmp_path / "b.json", "b", range(100))
    asked = ["--decision", "scores.choice.value", "--unit", "id", "--utility", "C=1"]
    made = tmp_path / "c.json"
    assert command(["certify", one, other, *asked, "--group", "eval.model", "-o", str(made)]) == 0 and command(["verify", str(made)]) == 0
    document = json.loads(made.read_text())
    assert F(document["metrics"]["local"]["ratio"]) == F(9, 5) and document["metrics"]["local"]["witness"]["higher"] == {"eval.model": "a"}
    assert "paired-betting" in {claim["by"] for claim in document["claims"]} and F(document["intervals"]["local"]["ratio"][0]) > F(3, 2)
    assert command(["certify", one, other, *asked, "--group", "eval.model", "--context", "metadata.race"]) == 0
    assert command(["compare", one, other, *asked, "--group", "metadata.race", "--margin", "1.25"]) in (0, 3)
    capsys.readouterr()


def test_answers_that_were_not_drawn_say_nothing_of_a_population(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    logs = [samples(tmp_path / f"{name}.json", name, range(180), temperature=0) for name in "ab"]
    asked = ["--decision", "scores.choice.value", "--unit", "id,epoch", "--utility", "C=1", "--group", "metadata.race", "--format", "json"]
    assert command(["compare", *logs, *asked]) == 2
    assert "nothing was drawn" in capsys.readouterr().err
    assert command(["compare", *logs, *asked, "--confidence", "none"]) == 0
    found = result_of(capsys.readouterr().out)
    assert found["by_unit"]["rates"] == [] and {entry["confidence"] for entry in found["fairness"]} == {None}


def test_samples_without_an_answer_are_not_taken_for_answers(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    one, other = samples(tmp_path / "a.json", "a", range(180)), samples(tmp_path / "b.json", "b", range(180), broken=5)
    asked = ["--decision", "scores.choice.value", "--unit", "id", "--utility", "C=1", "--group", "metadata.race", "--format", "json"]
    assert command(["compare", one, other, *asked]) == 2
    capsys.readouterr()
    assert command(["compare", one, other, *asked, "--errors", "drop"]) in (0, 3)
    assert "some units are in one of the logs only" in result_of(capsys.readouterr().out)["by_unit"]["unpaired"]


def answers(path: Path, refused: int) -> str:
    """A log of Inspect in which so many samples of each group were refused, others answered rightly in turn."""
    path.write_text(Path(samples(path, "a", range(180))).read_text())
    made = json.loads(path.read_text())
    for sample in made["samples"][: 2 * refused]:
        sample["output"] = {"choices": [{"stop_reason": "content_filter"}]}
    path.write_text(json.dumps(made))
    return str(path)


def test_a_utility_that_names_an_answer_that_decides_nothing_says_what_it_is_worth(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    logs = [answers(tmp_path / f"{name}.json", 20) for name in "ab"]
    asked = ["compare", *logs, "--decision", "scores.choice.value", "--group", "metadata.race", "--unit", "id", "--format", "json"]
    open_ = [*asked, "--confidence", "none", "--utility", "C=1"]
    assert command(open_) == 3
    found = result_of(capsys.readouterr().out)["fairness"][0]
    assert found["why"] == "what undecided decisions meant leaves it open" and found["old"] != ["1", "1"]
    for more in ([*asked, "--margin", "1.3", "--utility", "C=1,refused=0"], [*open_[:-1], "C=1,refused=1/2"]):
        assert command(more) == 0
        found = result_of(capsys.readouterr().out)
        assert found["fairness"][0]["verdict"] == "no less fair"
        assert not any("whatever they meant" in text for text in found["fairness"][0]["assumptions"])
        assert found["by_unit"]["rates"] or "--confidence" in more


def test_two_logs_without_columns_are_told_what_they_need(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (tmp_path / "a.jsonl").write_text('{"answer": "yes", "sex": "f"}\n{"answer": "yes", "sex": "m"}\n')
    assert command(["compare", str(tmp_path / "a.jsonl"), str(tmp_path / "a.jsonl")]) == 2
    said = "a.jsonl is no certificate that fairaudit wrote; two logs need their columns: --decision, --group and --utility"
    assert said in capsys.readouterr().err
    (tmp_path / "c.json").write_text('{"format": "fairaudit-certificate/1"}')
    assert command(["compare", str(tmp_path / "c.json"), str(tmp_path / "c.json")]) == 2
    assert "two logs" not in capsys.readouterr().err
