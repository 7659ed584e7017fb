"""`fairaudit privacy --releases`: what several fresh releases let a policy do, and how many keep a target."""

from __future__ import annotations

from fractions import Fraction
from pathlib import Path
from typing import Any

import pytest
from envelopes import envelope, result_of

from fairaudit.cli import main

F = Fraction

TWENTY = "84157638225849945906869/39321600000000000000000"


@pytest.fixture
def coin(tmp_path: Path) -> str:
    """Randomized response that keeps one of two groups with probability 11/20."""
    path = tmp_path / "coin.csv"
    path.write_text("input,a,b\na,0.55,0.45\nb,0.45,0.55\n")
    return str(path)


def fairness(path: str, capsys: pytest.CaptureFixture[str], *options: str, code: int = 0) -> dict[str, Any]:
    assert main(["privacy", path, *options, "--format", "json"]) == code
    found: dict[str, Any] = result_of(capsys.readouterr().out)["fairness"]
    return found


def test_the_example_of_the_theory(coin: str, capsys: pytest.CaptureFixture[str]) -> None:
    found = fairness(coin, capsys, "--releases", "20", "--tau", "0.3", "--max-ratio", "3/2,2,3", code=1)
    assert found["guarantee"]["ratio"] == TWENTY
    assert (found["sticky"]["ratio"], found["without_end"]["ratio"]) == ("11/9", "10/3")
    assert F(found["by_epsilon"]["ratio"]) == F(11, 9) ** 20
    assert [(t["holds_to"], t["breaks_at"], t["verdict"]) for t in found["targets"]] == [
        (4, 5, "exceeds"),
        (15, 16, "exceeds"),
        (81, 82, "within"),
    ]
    assert (found["releases"], found["gamma"], found["g_min"], found["tau"]) == (20, "1", "0", "3/10")
    assert found["scope"].startswith("any policy behind this filter that keeps the declared floor")
    assert "one memory sees at most 20 releases of a group, each drawn afresh (declared)" in found["assumptions"]


def test_it_is_told_to_people(coin: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["privacy", coin, "--releases", "20", "--tau", "0.3", "--max-ratio", "2"]) == 1
    out, _ = capsys.readouterr()
    for said in (
        "20 fresh releases                                 R at most 2.141   exactly " + TWENTY,
        "R at most 1.223   exactly 11/9",
        "R at most 3.334   exactly 10/3",
        "times too large",
        "Target: R at most 2 holds for up to 15 fresh releases and breaks at 16. With a sticky release it holds for good: R at most 1.223.",
    ):
        assert said in out


def test_the_envelope_has_the_verdict_and_the_answer(coin: str, capsys: pytest.CaptureFixture[str]) -> None:
    for releases, verdict, code in ((15, "within", 0), (16, "exceeds", 1)):
        assert main(["privacy", coin, "--releases", str(releases), "--tau", "0.3", "--max-ratio", "2", "--format", "json"]) == code
        found = envelope(capsys.readouterr().out)
        assert found["verdict"] == verdict
        assert f"sees {releases} fresh releases: R at most" in found["sentence"] and "breaks at 16" in found["sentence"]


def test_without_releases_one_is_meant(coin: str, capsys: pytest.CaptureFixture[str]) -> None:
    found = fairness(coin, capsys, "--g-min", "1", "--gamma", "3")
    assert found["guarantee"] == found["sticky"] == {"ratio": "21/19", "log": found["sticky"]["log"]}
    assert found["targets"] == [] and found["releases"] == 1
    assert not any("releases of a group" in sentence for sentence in found["assumptions"])


def test_without_a_floor_it_is_e_to_the_epsilon(coin: str, capsys: pytest.CaptureFixture[str]) -> None:
    found = fairness(coin, capsys, "--releases", "3", "--max-log", "1")
    assert found["guarantee"] == found["by_epsilon"] and found["without_end"]["ratio"] == "inf"
    assert (found["targets"][0]["holds_to"], found["targets"][0]["breaks_at"]) == (4, 5)
    assert F(found["targets"][0]["max_ratio"]) < F(2718281828459046, 10**15)
    assert main(["privacy", coin, "--gamma", "1"]) == 0
    assert "a floor, --tau, or a least utility, --g-min" in capsys.readouterr().out


def test_targets_that_always_and_never_hold(coin: str, capsys: pytest.CaptureFixture[str]) -> None:
    found = fairness(coin, capsys, "--tau", "0.3", "--max-ratio", "10/3,6/5", code=1)
    assert [(t["holds_to"], t["breaks_at"]) for t in found["targets"]] == [(None, None), (0, 1)]
    assert main(["privacy", coin, "--tau", "0.3", "--max-ratio", "10/3,6/5"]) == 1
    out, _ = capsys.readouterr()
    assert "holds however many releases there are" in out and "does not hold for a single release" in out


def test_a_filter_that_hides_nothing(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (tmp_path / "open.csv").write_text("input,a,b\na,1,0\nb,0,1\n")
    found = fairness(str(tmp_path / "open.csv"), capsys, "--releases", "5", "--tau", "1/4")
    assert {found[key]["ratio"] for key in ("guarantee", "sticky", "without_end")} == {"4"}
    assert found["by_epsilon"]["ratio"] == "inf"
    assert main(["privacy", str(tmp_path / "open.csv"), "--g-min", "0"]) == 0
    assert "no bound   (one with a floor, --tau, or a least utility, --g-min)" in capsys.readouterr().out


def test_a_filter_that_hides_everything(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (tmp_path / "shut.csv").write_text("input,a,b\na,0.5,0.5\nb,0.5,0.5\n")
    assert main(["privacy", str(tmp_path / "shut.csv"), "--releases", "9", "--max-ratio", "1"]) == 0
    out, _ = capsys.readouterr()
    assert out.count("R at most 1   exactly 1") == 3 and "less with" not in out
    assert "Target: R at most 1 holds however many releases there are." in out


def test_without_any_of_the_options_nothing_is_said_of_fairness(coin: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["privacy", coin, "--releases", "20", "--format", "json"]) == 0
    assert "fairness" not in result_of(capsys.readouterr().out)


@pytest.mark.parametrize(
    ("options", "said"),
    [
        (["--gamma", "0"], "--gamma is 0"),
        (["--gamma", "2", "--tau", "3"], "--tau is '3', above --gamma, which is '2'"),
        (["--g-min", "2"], "--g-min is '2', above --gamma, which is 1"),
        (["--g-min=-1"], "--g-min is '-1'; a number of at least 0"),
        (["--tau", "x"], "--tau: 'x' is not a number"),
        (["--max-ratio", "x"], "--max-ratio: 'x' is not a number"),
        (["--max-ratio", "2", "--max-log", "1"], "not allowed with"),
        (["--max-log", "1e9"], "--max-log is '1e9'; a number from 0 to 10,000"),
        (
            ["--tau", "0.3", "--releases", "20000"],
            "--releases is 20000; with --gamma, --g-min, --tau or a target a whole number from 1 to 10000 is",
        ),
    ],
)
def test_bad_options(coin: str, capsys: pytest.CaptureFixture[str], options: list[str], said: str) -> None:
    try:
        code = main(["privacy", coin, *options])
    except SystemExit as stopped:
        code = int(stopped.code or 0)
    out, err = capsys.readouterr()
    assert code == 2 and out == "" and said in err
