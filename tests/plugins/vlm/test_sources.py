"""Answers as policies of any audit: what a journal holds against an independent count, and the example of the page."""

from __future__ import annotations

import csv
import json
import re
from collections import Counter
from dataclasses import replace
from fractions import Fraction
from pathlib import Path

import pytest

import fairaudit as fa
from fairaudit import checker
from fairaudit.cli import main
from fairaudit.errors import InputError
from fairaudit.plugins.vlm.experiment import Model, bundled, read_experiment
from fairaudit.plugins.vlm.journal import Journal
from fairaudit.plugins.vlm.run import estimate, run

PAGE = Path(__file__).parents[3] / "docs" / "policies.md"


def example() -> str:
    """The audit file of the page."""
    (found,) = (block for block in re.findall(r"```toml\n(.*?)```", PAGE.read_text("utf-8"), re.DOTALL) if 'plugin = "journal"' in block)
    return found


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder in which the commands of the page were given."""
    found = tmp_path_factory.mktemp("page")
    assert main(["experiment", "run", "waiting-time", "--maker", "stand-in", "--folder", str(found / "waiting-time")]) == 0
    assert main(["experiment", "certify", "waiting-time", "--folder", str(found / "waiting-time")]) == 0
    (found / "audit.toml").write_text(example(), "utf-8")
    return found


def certified(folder: Path, text: str, *more: str) -> int:
    (folder / "other.toml").write_text(text, "utf-8")
    return main(["certify", str(folder / "other.toml"), *more])


def test_answers_that_were_paid_for_serve_another_audit(folder: Path) -> None:
    """The certificate's policy has the counts of answers.csv, it is true, and the ε of the filter is 3/2 · 9 as the page says."""
    place = folder / "c.json"
    assert main(["certify", str(folder / "audit.toml"), "-o", str(place), "--attest", str(folder / "a.json")]) == 0
    assert checker.main([str(place)]) == 0
    with (folder / "waiting-time" / "stand-in.answers.csv").open(encoding="utf-8", newline="") as file:
        expected = Counter((r["Recipient1 complaints"], r["Recipient2 complaints"], r["decision"]) for r in csv.DictReader(file))
    law = fa.policy_source("journal", experiment="waiting-time", journal=str(folder / "waiting-time" / "journal.sqlite")).table().law
    cells = list(zip(law.cell_group, law.weights, strict=True))
    assert {(*law.groups[a], u): int(n) for a, row in cells for u, n in zip(law.decisions, row, strict=True)} == dict(expected)
    bounds = [claim["value"] for claim in json.loads(place.read_text())["claims"] if claim["by"] == "T2"]
    assert "27/2" in bounds
    attested = json.loads((folder / "a.json").read_text())
    assert "journal.sqlite" in json.dumps(attested)


def test_nothing_of_a_plug_in_is_run_by_a_recount(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["certify", str(folder / "audit.toml"), "-o", str(folder / "c.json"), "--attest", str(folder / "a.json")]) == 0
    files = [str(folder / "audit.toml"), str(folder / "waiting-time" / "journal.sqlite")]
    assert main(["verify", str(folder / "c.json"), "--attestation", str(folder / "a.json"), "--recount", *files]) == 2
    assert "no table that is counted again" in capsys.readouterr().err


def test_options_of_a_plug_in_that_are_refused(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    good = example()
    for old, new, said in (
        ('options = { experiment = "waiting-time" }', 'options = { experiment = "waiting-time", model = "o1" }', "no model 'o1'"),
        ('options = { experiment = "waiting-time" }', 'options = { experiment = "epsilon-a" }', "belongs to another experiment file"),
        ('options = { experiment = "waiting-time" }', 'options = { experimnt = "epsilon-a" }', "is not made with these options"),
        ('plugin = "journal"', 'plugin = "jurnal"', "did you mean 'journal'"),
        ('plugin = "journal"', 'plugin = "journal"\ntable = "x.csv"', "unknown key 'table'"),
        ('plugin = "journal"', 'plugin = "journal"\ntrials = 0', "trials is 0"),
        ("values = { Recipient1 = 1 }", 'column = "x"', "goes with a table"),
        ("waiting-time/journal.sqlite", "nowhere/journal.sqlite", "there is no journal"),
    ):
        assert old in good
        assert certified(folder, good.replace(old, new)) == 2
        found = capsys.readouterr().err
        assert said in found
        assert found.count("\n") == 1


def test_an_answer_that_settings_share_counts_once_and_none_is_missing(tmp_path: Path) -> None:
    """Released values that were drawn: the policy is that of what was shown, and a run that was stopped is refused."""
    text = bundled()["waiting-time"].read_text("utf-8").replace("trials = 100", 'trials = 20\ndesign = "end-to-end"')
    (tmp_path / "e.toml").write_text(text, "utf-8")
    experiment = read_experiment(str(tmp_path / "e.toml"))
    source = fa.policy_source("journal", experiment=str(tmp_path / "e.toml"), journal=str(tmp_path / "j.sqlite"))
    with Journal(tmp_path / "j.sqlite", experiment.digest, experiment.trials, create=True) as journal:
        report = run(experiment, Model("s", "stand-in"), journal)
        shown = {(a.draw.request, a.draw.occurrence): a.draw.shown_slots for a in journal.answers("s (stand-in)")}
    law = source.table().law
    assert int(law.weights.sum()) == report.answered == len(shown)
    sizes = Counter(sum(slots, ()) for slots in shown.values())
    assert {law.groups[a]: int(n) for a, n in zip(law.cell_group, law.totals, strict=True)} == dict(sizes)
    with Journal(tmp_path / "j.sqlite", experiment.digest, experiment.trials, create=False) as journal:
        journal._db.execute("DELETE FROM answers WHERE attempt = 3")
    with pytest.raises(InputError, match="finish the run first"):
        source.table()


def test_answers_that_choose_nothing_may_have_meant_anything(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """As `experiment certify` takes them, unless the audit says what they are worth."""
    text = bundled()["waiting-time"].read_text("utf-8").replace("\n[stand-in]", '\n[stand-in]\nunreadable = "1/4"')
    (folder / "some.toml").write_text(text, "utf-8")
    options = ["--maker", "stand-in", "--folder", str(folder / "some")]
    assert main(["experiment", "run", str(folder / "some.toml"), *options]) == 0
    audit = example().replace("waiting-time/journal.sqlite", "some/journal.sqlite").replace('"waiting-time"', f'"{folder}/some.toml"')
    capsys.readouterr()
    worth = "values = { Recipient1 = 1 }"
    assert worth in audit
    for changed, found in (
        (audit, ["unreadable"]),
        (audit.replace(worth, "values = { Recipient1 = 1, unreadable = 0 }"), None),
        (audit.replace(worth, worth + '\nundecided = ["unreadable"]'), ["unreadable"]),
    ):
        certified(folder, changed, "-o", str(folder / "u.json"))
        subject = json.loads((folder / "u.json").read_text())["subject"]
        assert subject.get("undecided", {}).get("decisions") == found
        assert checker.main([str(folder / "u.json")]) == 0
    source = fa.policy_source("journal", experiment=str(folder / "some.toml"), journal=str(folder / "some" / "journal.sqlite"))
    same = fa.Policy.from_source(source)
    names = list(same.law.columns.group)
    shown = fa.Product({name: fa.Identity(["rarely complains", "often complains"]) for name in names})
    result = fa.certify(same.behind(group=shown), {"Recipient1": 1}, max_local_ratio="5")
    assert result.undecided is not None
    assert result.whatever
    for search in (fa.calibrate_policy, fa.calibrate_utility, fa.design, fa.design_utility):
        with pytest.raises(InputError, match=r"leaves open what the decision 'unreadable' meant"):
            search(same, {"Recipient1": 1}, max_ratio=5)
    assert fa.calibrate_policy(same, {"Recipient1": 1, "unreadable": 0}, max_ratio=5).feasible


def test_answers_that_are_shared_are_estimated_once(tmp_path: Path) -> None:
    """Four prompts, 20 answers of each for the table, and few more for seven settings of 40 draws: not 4·20 + 7·40."""
    experiment = read_experiment("pictures-waiting", trials=20)
    model = Model("s", "stand-in")
    estimated = estimate(experiment, model)["calls"]
    with Journal(tmp_path / "j.sqlite", experiment.digest, experiment.trials, create=True) as journal:
        total = run(experiment, model, journal).total
    assert 80 <= min(estimated, total) <= max(estimated, total) <= 130


def test_embedded_makers_are_exact_policies() -> None:
    """The likelihood ratio of the stand-in's two profiles by hand: e^(1.1+0.2) to e^(-1.1+0.2), without a filter."""
    policy = fa.Policy.from_source(fa.policy_source("stand-in", experiment="waiting-time"))
    law = policy.law
    share = {law.groups[a]: Fraction(int(row[0]), int(sum(row))) for a, row in zip(law.cell_group, law.weights, strict=True)}
    assert law.decisions[0] == "Recipient1"
    odds = [float(p / (1 - p)) for p in (share["often complains", "rarely complains"], share["rarely complains", "often complains"])]
    assert odds == pytest.approx([2.718281828459045**1.3, 2.718281828459045**-0.9])
    with pytest.raises(InputError, match="is not made with these options"):
        fa.policy_source("stand-in", experimnt="waiting-time")


def test_parameters_of_a_model_take_the_place_of_the_section() -> None:
    from fairaudit.plugins.vlm.makers import StandIn, embedded

    experiment = read_experiment("waiting-time")
    cell = experiment.cells()[0]
    own = embedded(experiment, Model("b", "stand-in", parameters={"position": 2}))
    assert own.probabilities(*cell) == StandIn(replace(experiment, stand_in={"position": "2"})).probabilities(*cell)
    assert embedded(experiment, Model("a", "stand-in")).probabilities(*cell) == StandIn(experiment).probabilities(*cell)
