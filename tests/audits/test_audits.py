"""`certify` from Python and from the command line: targets, verdicts, exit codes, what is printed."""

from __future__ import annotations

import re
from fractions import Fraction
from pathlib import Path

import pytest
from envelopes import envelope, result_of

from fairaudit import InputError, Law, Utility, certify
from fairaudit.cli import main

COUNTS = {"hired": ["yes", "no", "yes", "no"], "sex": ["f", "f", "m", "m"], "n": [3, 1, 1, 1]}
TABLE = "hired,sex,p\nyes,f,0.5\nno,f,0.5\nyes,m,0.4\nno,m,0.6\n"


def law() -> Law:
    return Law.from_counts(COUNTS, decision="hired", group="sex", count="n")


@pytest.mark.parametrize(
    ("options", "verdict"),
    [
        ({}, "none"),
        ({"max_local_ratio": "3/2"}, "within"),
        ({"max_local_ratio": Fraction(3, 2) - Fraction(1, 10**50)}, "exceeds"),
        ({"max_local_log": "0.405465108108164381978013115464349136571990423462494197614014"}, "exceeds"),
        ({"max_local_log": "0.405465108108164381978013115464349136571990423462494197614015"}, "within"),
        ({"max_local_ratio": 2, "max_global_ratio": 1}, "exceeds"),
        ({"max_global_log": 10**300}, "within"),
        ({"max_local_log": 0}, "exceeds"),
    ],
)
def test_targets_are_decided_exactly(options: dict[str, object], verdict: str) -> None:
    """The local ratio is 3/2, and log(3/2) = 0.405465…97614014(1)."""
    result = certify(law(), {"yes": 1}, **options, confidence=None)
    assert result.local.ratio == Fraction(3, 2)
    assert result.verdict == verdict


@pytest.mark.parametrize("confidence", [0, 1, -1, "2", "x"])
def test_a_confidence_lies_between_0_and_1(confidence: object) -> None:
    with pytest.raises(InputError):
        certify(law(), {"yes": 1}, confidence=confidence)


def test_a_target_on_counts_is_about_the_population() -> None:
    """Three against one of few draws decide nothing, though the table's ratio is 3/2."""
    result = certify(law(), {"yes": 1}, max_local_log="0.2")
    assert result.verdict == "inconclusive"
    assert result.targets[0].confidence == Fraction(19, 20)
    assert certify(law(), {"yes": 1}, max_local_log="0.2", confidence=None).verdict == "exceeds"


@pytest.mark.parametrize(
    ("options", "code", "word"),
    [
        (["--max-local-ratio", "5/4"], 0, "WITHIN"),
        (["--max-local-ratio", "1.24"], 1, "EXCEEDS"),
        (["--max-global-log", "0.2231435513142097557662950903098345033746010855480072136712878"], 1, "EXCEEDS"),
        (["--max-global-log", "0.2231435513142097557662950903098345033746010855480072136712879"], 0, "WITHIN"),
        (["--max-local-log", "0.22"], 1, "EXCEEDS"),
        ([], 0, "NO TARGET"),
    ],
)
def test_exit_codes(tmp_path: Path, capsys: pytest.CaptureFixture[str], options: list[str], code: int, word: str) -> None:
    """R = 5/4, and log(5/4) = 0.22314355131420975576629509030983450337460108554800721367128787…."""
    path = tmp_path / "t.csv"
    path.write_text(TABLE)
    command = ["certify", str(path), "--decision", "hired", "--group", "sex", "--probability", "p", "--utility", "yes"]
    assert main([*command, *options]) == code
    out, err = capsys.readouterr()
    assert f"\n{word} " in out
    assert err == ""
    assert "\nhired=yes: sex=f 50.0 %, sex=m 40.0 %, 1.25 times.\n" in out


def test_nothing_to_compare_locally_is_inconclusive(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = tmp_path / "t.csv"
    path.write_text("u,a,x\ny,f,p\nn,f,p\ny,m,q\n")
    command = ["certify", str(path), "--decision", "u", "--group", "a", "--context", "x", "--utility", "y", "--confidence", "none"]
    assert main([*command, "--max-local-log", "1"]) == 3
    out, _ = capsys.readouterr()
    assert "\nINCONCLUSIVE " in out
    assert "No two groups can be compared within a context." in out
    assert "fewer than two groups" in out


def test_json_is_the_only_output(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = tmp_path / "t.csv"
    path.write_text(TABLE.replace(",", ";").replace("0.", "0,"))
    assert (
        main(["certify", str(path), "--decision", "hired", "--group", "sex", "--probability", "p", "--utility", "yes", "--format", "json"])
        == 0
    )
    out, err = capsys.readouterr()
    printed = envelope(out)
    assert err == ""
    assert printed["result"]["metrics"]["local"]["ratio"] == "5/4"
    assert printed["details"]["most_unequal"]["local"][0]["ratio"] == "5/4"
    assert any("decimal commas" in note for note in printed["notes"])


def test_several_columns_form_intersections(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = tmp_path / "t.csv"
    path.write_text("u,sex,age,job,year\ny,f,old,a,1\nn,f,old,a,1\ny,m,old,a,1\ny,f,young,a,1\nn,m,old,a,2\ny,f,old,a,2\n")
    command = ["certify", str(path), "--decision", "u", "--group", "sex,age", "--context", "job", "--context", "year", "--utility", "y"]
    assert main([*command, "--format", "json"]) == 0
    witness = result_of(capsys.readouterr().out)["metrics"]["local"]["witness"]
    assert witness["context"] == {"job": "a", "year": "2"}
    assert witness["higher"] == {"sex": "f", "age": "old"}


def test_counts_and_logs_agree(tmp_path: Path) -> None:
    rows = [("y", "f")] * 3 + [("n", "f")] * 2 + [("y", "m")] * 1 + [("n", "m")] * 4
    log = Law.from_log({"u": [u for u, _ in rows], "a": [a for _, a in rows]}, decision="u", group="a")
    # Repeated count cells add up.
    counts = Law.from_counts(
        {"u": list("nynyny"), "a": list("ffffmm"), "n": ["1.5", 1, "1/2", 2, 4, 1]}, decision="u", group="a", count="n"
    )
    one, two = (certify(table, {"y": 1}) for table in (log, counts))
    assert one.local.ratio == two.local.ratio == 3
    assert one.certificate.text == two.certificate.text.replace('"3/1"', '"3"')


def test_utility_column_may_vary_by_context_and_group() -> None:
    table = {
        "u": ["go", "stay"] * 4,
        "a": ["f", "f", "m", "m"] * 2,
        "x": ["p"] * 4 + ["q"] * 4,
        "n": [1, 1, 1, 1, 1, 3, 3, 1],
        "g": [2, 0, 1, 0, 4, 0, 4, 0],
    }
    audited = Law.from_counts(table, decision="u", group="a", context="x", count="n")
    result = certify(audited, Utility.from_table(table, utility="g", decision="u", group="a", context="x"))
    assert result.local.ratio == 3
    assert result.utility.depends_on_group
    assert result.utility.lipschitz() == 1
    assert (result.utility.gamma, result.utility.m) == (4, 0)


def test_a_log_of_values_needs_no_decision_column(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = tmp_path / "waits.csv"
    path.write_text("who,minutes\nf,10\nf,20\nm,12.5\nm,5\n")
    assert main(["certify", str(path), "--group", "who", "--utility-column", "minutes", "--format", "json"]) == 0
    local = result_of(capsys.readouterr().out)["metrics"]["local"]
    assert local["ratio"] == "12/7"
    assert local["witness"]["expectations"] == ["15", "35/4"]


def test_examples_and_inspect(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["certify", "--list-examples"]) == 0
    names = re.findall(r"^(\S+)$", capsys.readouterr().out, re.MULTILINE)
    assert names == ["ucb-admissions", "hr-navigation", "hr-filtered"]
    for name in names:
        target = tmp_path / f"{name}.json"
        assert main(["certify", "--example", name, "-o", str(target)]) == 0
        assert main(["verify", str(target)]) == 0
    assert "synthetic" in (main(["certify", "--list-examples"]), capsys.readouterr().out)[1]


def test_inspect_suggests_a_command_that_runs(tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch) -> None:
    import shlex

    from fairaudit.tables.examples import example

    table = example("ucb-admissions").table()
    path = tmp_path / "my admissions.csv"
    path.write_text(
        "Admit,Gender,Dept,Freq\n"
        + "".join(",".join(row) + "\n" for row in zip(*(table[c] for c in ("Admit", "Gender", "Dept", "Freq")), strict=True))
    )
    assert main(["inspect", str(path)]) == 0
    command = next(line for line in capsys.readouterr().out.splitlines() if line.startswith("  fairaudit certify"))
    assert main(shlex.split(command)[1:]) == 0
    assert "Gender=Female 82.4 % (89 of 108)" in capsys.readouterr().out


def test_top_lists_that_many_pairs(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["certify", "--example", "ucb-admissions", "--top", "2", "--format", "json"]) == 0
    ranked = envelope(capsys.readouterr().out)["details"]["most_unequal"]
    assert [len(ranked[name]) for name in ("local", "global", "equalized_odds", "demographic_parity")] == [2, 1, 2, 1]
    assert ranked["local"][1]["witness"]["context"] == {"Dept": "F"}
