"""Limits: one vocabulary that tells a ratio from its logarithm, read exactly, and said in both readings wherever they are shown."""

from __future__ import annotations

import json
import sqlite3
import subprocess
import sys
from collections.abc import Callable
from decimal import Decimal
from fractions import Fraction
from math import inf, nan
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from envelopes import envelope, envelopes, result_of
from hypothesis import given
from hypothesis import strategies as st

import fairaudit as fa
from fairaudit import checker
from fairaudit.cli import main
from fairaudit.errors import InputError
from fairaudit.exact.enclosures import compare_log
from fairaudit.exact.rationals import option_value, rational
from fairaudit.filters.calibration import calibrate
from fairaudit.filters.calibration_with_policy import calibrate_policy
from fairaudit.inference.planning import further_draws, plan
from fairaudit.inference.ratio_intervals import ratio_interval
from fairaudit.inference.table_comparisons import local_comparison
from fairaudit.inference.verdicts import verdict
from fairaudit.measures.limits import limit_readings, limit_text, limits_of, read_limit
from fairaudit.streams.settings import Settings
from fairaudit.streams.state import State
from fairaudit.tables.binning import Bins
from fairaudit.theorems.t03 import t3_approx

F = Fraction
FOUR_FIFTHS = "ratio at most 1.25 (least at least 0.8 of the greatest; log 0.2231)"
FIFTH = "log-ratio at most 0.2 (ratio 1.221; least at least 0.8187 of the greatest)"
MEASURED = {name: (f"{name}_ratio", f"{name}_log") for name in ("max_local", "max_global")}
POLICY = fa.Policy.from_array([[["0.9", "0.1"], ["0.2", "0.8"]]], decisions=["hire", "pass"], groups=["f", "m"])

positive = st.fractions(F(1, 1000), 1000, max_denominator=1000)


def law(f: int = 743, m: int = 1000, of: int = 1000) -> fa.Law:
    return fa.Law.from_array([[f, of - f], [m, of - m]], kind="counts", decisions=["yes", "no"], groups=["f", "m"])


@pytest.fixture
def log(tmp_path: Path) -> str:
    """Counts whose least group has 0.743 of what the greatest has."""
    path = tmp_path / "log.csv"
    path.write_text("answer,sex,n\nyes,f,743\nno,f,257\nyes,m,1000\n")
    return str(path)


COLUMNS = ["--decision", "answer", "--group", "sex", "--count", "n", "--utility", "yes"]


def refused(capsys: pytest.CaptureFixture[str], *words: str) -> str:
    """Run a command that is refused: code 2, one sentence, nothing else."""
    try:
        code = main(list(words))
    except SystemExit as stop:
        code = stop.code  # type: ignore[assignment]
    said = capsys.readouterr()
    assert (code, said.out) == (2, "")
    assert said.err.count("\n") == 1
    return said.err


# How limits are read


@given(limit=positive)
def test_a_ratio_under_1_is_least_over_greatest(limit: Fraction) -> None:
    assert read_limit("max_local_ratio", limit) == max(limit, 1 / limit)
    assert read_limit("max_ratio", str(1 / limit)) == read_limit("max_ratio", limit)
    assert read_limit("max_log", limit) == limit


@given(value=st.floats(1e-12, 1e12))
def test_a_float_is_the_decimal_that_it_is_printed_as(value: float) -> None:
    said = F(repr(value))
    assert F(*option_value(value)) == F(*option_value(Decimal(repr(value)))) == F(*option_value(np.float64(value))) == said
    assert F(*option_value(F(value))) == F(*rational(value)) == F(value)
    assert read_limit("max_log", value) == said
    assert read_limit("max_ratio", value) == (said if said >= 1 else 1 / said)


@given(f=st.integers(1, 40), m=st.integers(1, 40), limit=positive)
def test_the_verdict_is_that_of_either_reading(f: int, m: int, limit: Fraction) -> None:
    """From the definitions: greatest over least at most q, or, for q under 1, least over greatest at least q."""
    kept = F(max(f, m), min(f, m)) <= limit if limit >= 1 else F(min(f, m), max(f, m)) >= limit
    for given_as in (limit, str(limit)):
        result = fa.certify(law(f, m, 40), {"yes": 1}, max_local_ratio=given_as, max_global_ratio=limit, confidence=None)
        assert {t.verdict for t in result.targets} == {"within" if kept else "exceeds"}


@pytest.mark.parametrize("name", ["max_local_ratio", "max_global_log", "max_ratio", "max_log"])
@pytest.mark.parametrize(
    "value", [nan, inf, -inf, "nan", "inf", "-inf", Decimal("nan"), Decimal("inf"), np.float64("nan"), -1, "-0.8", True, [], "1/0"]
)
def test_what_is_no_limit(name: str, value: Any) -> None:
    with pytest.raises(InputError, match=f"^{name}[: ]"):
        read_limit(name, value)


def test_a_ratio_of_0_is_no_limit_and_a_logarithm_of_0_is_parity() -> None:
    for zero in (0, 0.0, "0", "-0", F(0)):
        with pytest.raises(InputError, match=r"a ratio above 0 .* 0\.8 is 5/4"):
            read_limit("max_global_ratio", zero)
        assert read_limit("max_global_log", zero) == 0
    with pytest.raises(InputError, match="a logarithm of at least 0"):
        read_limit("max_log", "-0.1")


def test_the_certificate_keeps_the_ratio_of_greatest_over_least() -> None:
    four_fifths, five_fourths = (
        fa.certify(law(), {"yes": 1}, max_global_ratio=limit, confidence=None).certificate for limit in (0.8, "5/4")
    )
    assert four_fifths.document == five_fourths.document
    target = four_fifths.document["targets"][0]
    assert (target["limit"], target["unit"], target["verdict"]) == ("5/4", "ratio", "exceeds")
    assert checker.check(json.dumps(four_fifths.document).encode()).ok


# Every option that takes a number takes it in the same way

PLACE = POLICY.law.contexts[0]
SAMPLE = local_comparison(law(), fa.Utility({"yes": 1}).on(law()))
OPTIONS: dict[str, Callable[[Any], Any]] = {
    "max_local_log": lambda v: fa.certify(law(), {"yes": 1}, max_local_log=v).targets[0].limit,
    "confidence": lambda v: ratio_interval(SAMPLE, v).confidence,
    "declared gamma": lambda v: fa.certify(law(), {"yes": "0.01"}, declared={"gamma": v}).declared["gamma"],
    "declared tau": lambda v: fa.certify(POLICY.behind(group=fa.Identity(["f", "m"])), {"hire": 1}, declared={"tau": v}).declared["tau"],
    "utility": lambda v: fa.Utility({"yes": v}).gamma,
    "utility of a function": lambda v: fa.Utility.from_function(lambda u, x, a: v, law()).gamma,
    "class": lambda v: fa.UtilityClass(gamma=1, m=v).m,
    "keep_probability": lambda v: fa.RandomizedResponse([str(i) for i in range(14)], keep_probability=v),
    "epsilon": lambda v: fa.RandomizedResponse(["a", "b"], epsilon=v),
    "constant": lambda v: fa.Constant(["a", "b"], {"a": v, "b": 1 - F(*option_value(v))}),
    "population": lambda v: POLICY.behind(group=fa.Identity(["f", "m"]), population={(PLACE, "f"): v, (PLACE, "m"): 1}).mass,
    "calibrate": lambda v: calibrate(max_log=v, groups=2, tau=v),
    "calibrate_policy": lambda v: calibrate_policy(POLICY, {"hire": 1}, max_log=v),
    "calibrate_utility": lambda v: fa.calibrate_utility(POLICY, {"hire": 1}, max_log=v),
    "design": lambda v: fa.design_model_free(2, max_log=v, tau=v),
    "cap": lambda v: fa.design(POLICY, {"hire": 1}, max_epsilon=v),
    "plan": lambda v: plan([v, v], max_log=v).draws,
    "further draws": lambda v: further_draws(SAMPLE, max_log=v).draws,
    "bins": lambda v: Bins.of("age", [v]).limits,
    "t3": lambda v: t3_approx(2, v, v, floor="declared").value,
    "delta": lambda v: fa.trade_off(fa.RandomizedResponse(["a", "b"], keep_probability="0.7")).beta(v),
    "monitor": lambda v: Settings(group=("g",), decision="d", utility={"yes": v}, targets={"max_local_log": v}).text,
}


def figures(found: Any) -> Any:
    """What of an answer can be compared."""
    if isinstance(found, fa.Mechanism):
        return found.factors
    return vars(found) | {"mechanism": None} if hasattr(found, "feasible") else found


@pytest.mark.parametrize("name", OPTIONS)
def test_a_float_is_read_in_the_same_way_in_every_option(name: str) -> None:
    read = OPTIONS[name]
    texts = [figures(read(value)) for value in (0.1, np.float64(0.1), np.float32(0.1), "0.1", Decimal("0.1"), F(1, 10))]
    assert all(text == texts[-1] for text in texts)


def test_an_entry_of_an_array_of_floats_stays_what_it_stores() -> None:
    array = np.array([[0.1, 0.9], [0.2, 0.8]])
    assert F(*option_value(0.1)) != F(0.1)
    filtered = fa.Mechanism.from_array(array, ["a", "b"], ["a", "b"])
    assert filtered.probability(("a",), ("a",)) == F(0.1) / (F(0.1) + F(0.9))
    weights = np.array([[0.1, 0.3]])
    mass = POLICY.behind(group=fa.Identity(["f", "m"]), population=weights).mass
    assert mass is not None
    assert F(mass[0], mass[1]) == F(0.1) / F(0.3)
    costs = np.array([[0, 0.1], [0.3, 0]])
    one, other = (fa.design(POLICY, {"hire": 1}, max_ratio=2, distortion=table).distortion for table in (costs, costs.tolist()))
    exact = [
        fa.design(POLICY, {"hire": 1}, max_ratio=2, distortion=[[0, low], [high, 0]]).distortion
        for low, high in ((F(0.1), F(0.3)), (F(1, 10), F(3, 10)))
    ]
    assert [one, other] == exact and one != other


# The bare forms


@pytest.mark.parametrize("name", MEASURED)
def test_bare_keywords_are_answered_with_both_names(name: str, tmp_path: Path) -> None:
    from fairaudit.audits.in_parts import certify_in_parts

    said = rf"^{name} is not accepted; give {name}_ratio, .* or {name}_log, .* natural logarithm$"
    given: Any = {name: 0.8}
    with pytest.raises(InputError, match=said):
        fa.certify(law(), {"yes": 1}, **given)
    with pytest.raises(InputError, match=said):
        certify_in_parts(str(tmp_path / "log.parquet"), {"yes": 1}, decision="u", group="a", context="x", **given)
    with pytest.raises(InputError, match=said):
        Settings(group=("g",), decision="d", utility={"yes": "1"}, targets=given)
    with pytest.raises(InputError, match="certify has no argument max_lokal; did you mean max_local_"):
        fa.certify(law(), {"yes": 1}, max_lokal=1)  # type: ignore[call-arg]


@pytest.mark.parametrize(
    ("call", "names"),
    [
        (
            lambda **given: calibrate(groups=4, **given),
            ["target_local", "target_local_ratio", "target_global", "target"],
        ),
        (lambda **given: calibrate_policy(POLICY, {"hire": 1}, **given), ["target_local", "target_global_ratio"]),
        (lambda **given: fa.design(POLICY, {"hire": 1}, **given), ["target_local", "target_local_ratio"]),
        (lambda **given: fa.design_model_free(4, **given), ["target_local", "max_local"]),
        (lambda **given: fa.frontier(groups=4, **given), ["targets"]),
        (lambda **given: plan(["0.5", "0.5"], **given), ["limit", "target"]),
        (lambda **given: further_draws(SAMPLE, **given), ["limit"]),
        (lambda **given: verdict((F(1), F(2)), **given), ["limit"]),
    ],
)
def test_bare_keywords_where_one_quantity_is_meant(call: Callable[..., Any], names: list[str]) -> None:
    for name in names:
        with pytest.raises(InputError, match=rf"^{name} is not accepted; give max_ratio, .* or max_log, "):
            call(**{name: "1.25"})
    with pytest.raises(InputError, match="one of max_ratio"):
        call(**({"max_ratio": [2], "max_log": [1]} if names == ["targets"] else {"max_ratio": 2, "max_log": 1}))


@pytest.mark.parametrize("name", ["local-ratio", "local-log", "global-ratio", "global-log"])
def test_a_second_limit_does_not_take_the_place_of_the_first(log: str, name: str, capsys: pytest.CaptureFixture[str]) -> None:
    said = refused(capsys, "certify", log, *COLUMNS, f"--max-{name}", "5/4", f"--max-{name}", "100")
    assert f"--max-{name} is given twice" in said


@pytest.mark.parametrize("name", MEASURED)
@pytest.mark.parametrize("value", [["0.8"], []])
def test_bare_options_are_answered_with_both_names(log: str, name: str, value: list[str], capsys: pytest.CaptureFixture[str]) -> None:
    option = "--" + name.replace("_", "-")
    for command in (["certify", log, *COLUMNS], ["monitor", log, *COLUMNS[:4]], ["experiment", "certify", "package-delivery"]):
        said = refused(capsys, *command, option, *value)
        assert f"{option} is not accepted; give {option}-ratio, a limit on the ratio such as 5/4, or {option}-log, " in said
    said = refused(capsys, "certify", log, *COLUMNS, f"{option}=0.8")
    assert f"{option}-ratio" in said and f"{option}-log" in said


@pytest.mark.parametrize("option", ["--target", "--target-ratio"])
@pytest.mark.parametrize("command", ["plan --guess 0.5,0.5", "calibrate --groups 4", "design --groups 4"])
def test_the_bare_target_is_answered_with_both_names(command: str, option: str, capsys: pytest.CaptureFixture[str]) -> None:
    said = refused(capsys, *command.split(), option, "1.25")
    assert f"{option} is not accepted; give --max-ratio, a limit on the ratio such as 5/4, or --max-log, " in said


@pytest.mark.parametrize("name", MEASURED)
def test_bare_keys_of_files_are_answered_with_both_names(log: str, tmp_path: Path, name: str, capsys: pytest.CaptureFixture[str]) -> None:
    from fairaudit.plugins.vlm.experiment import bundled

    audit, experiment = tmp_path / "audit.toml", tmp_path / "experiment.toml"
    law_section = '[law]\ntable = "log.csv"\ndecision = "answer"\ngroup = "sex"\ncount = "n"\n[utility]\nvalues = { yes = 1 }\n'
    audit.write_text(f"{law_section}[targets]\n{name} = 0.8\n")
    text = bundled()["package-delivery"].read_text().partition("[targets]")[0]
    experiment.write_text(f"{text}\n[targets]\n{name} = 0.8\n")
    for command in (["certify", str(audit)], ["experiment", "run", str(experiment), "--dry-run"]):
        said = refused(capsys, *command)
        assert f"[targets] {name} is not accepted; give {name}_ratio, " in said and f" or {name}_log, " in said
    audit.write_text(f"{law_section}[targets]\n{name}_ratio = 0.8\n")
    assert main(["certify", str(audit), "--confidence", "none"]) == 1


def test_the_gate_answers_with_both_names(tmp_path: Path) -> None:
    (tmp_path / "test_gate.py").write_text(
        "import fairaudit as fa\n"
        "LAW = fa.Law.from_array([[743, 257], [1000, 0]], kind='counts', decisions=['yes', 'no'], groups=['f', 'm'])\n"
        "def test_bare(fairness_gate):\n    fairness_gate(LAW, {'yes': 1}, max_global=0.8)\n"
        "def test_four_fifths(fairness_gate):\n    fairness_gate(LAW, {'yes': 1}, max_global_ratio=0.8, confidence=None)\n"
    )
    words = [sys.executable, "-m", "pytest", "-p", "no:cacheprovider", "-q", str(tmp_path), "-c", "/dev/null"]
    done = subprocess.run(words, capture_output=True, text=True, cwd=tmp_path, check=False)
    assert "2 failed" in done.stdout
    assert "InputError: max_global is not accepted; give max_global_ratio, " in done.stdout
    assert "EXCEEDS global ratio at most 1.25 (least at least 0.8 of the greatest)\n" in done.stdout
    assert "group=f 74.3 % (743 of 1,000), 1.346 times.\n" in done.stdout


# Both readings, wherever a limit is shown


def test_four_fifths_exceed_and_both_readings_are_shown(log: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """0.743 does not meet the four-fifths rule, as either number."""
    path = tmp_path / "c.json"
    for limit in ("0.8", "1.25", "5/4", "4/5"):
        limits = ["--max-global-ratio", limit, "--max-local-log", "0.2", "--confidence", "none"]
        assert main(["certify", log, *COLUMNS, *limits, "-o", str(path), "--verbose"]) == 1
        said = capsys.readouterr().out
        assert f"EXCEEDS      global {FOUR_FIFTHS}: it is 1.346 (this table, decided exactly)" in said
        assert f"EXCEEDS      local {FIFTH}: it is 0.2971" in said
    for form in ("page.html", "page.md"):
        assert main(["report", str(path), "-o", str(tmp_path / form)]) == 0
        page = (tmp_path / form).read_text()
        assert f"global {FOUR_FIFTHS}" in page and f"local {FIFTH}" in page
    capsys.readouterr()
    looser = tmp_path / "looser.json"
    assert (
        main(["certify", log, *COLUMNS, "--max-global-ratio", "0.75", "--max-local-log", "1", "--confidence", "none", "-o", str(looser)])
        == 1
    )
    for other in (path, looser):
        capsys.readouterr()
        assert main(["compare", str(path), str(other)]) == (other == looser)
        said = capsys.readouterr().out
        assert f"global {FOUR_FIFTHS}" in said and f"local {FIFTH}" in said
    assert main(["certify", log, *COLUMNS, "--max-global-ratio", "0.8", "--format", "json"]) == 1
    target = envelope(capsys.readouterr().out)["details"]["targets"][0]
    assert target["limit"] == "5/4" and target["readings"] == limit_readings("ratio", F(5, 4))


def test_calibrate_design_and_plan_show_both_readings(capsys: pytest.CaptureFixture[str]) -> None:
    for command in ("calibrate --groups 4", "design --groups 4", "plan --guess 0.5,0.5"):
        for limit in ("0.8", "1.25"):
            assert main([*command.split(), "--max-ratio", limit]) == 0
            assert f"local {FOUR_FIFTHS}" in capsys.readouterr().out
            assert main([*command.split(), "--max-ratio", limit, "--format", "json"]) == 0
            said = result_of(capsys.readouterr().out)
            assert said.get("found", [said])[0]["readings"] == limit_readings("ratio", F(5, 4))
        assert main([*command.split(), "--max-log", "0.2"]) == 0
        assert "0.8187 of the greatest" in capsys.readouterr().out
    assert main(["calibrate", "--groups", "4", "--max-ratio", "0.8", "--global"]) == 0
    assert f"global {FOUR_FIFTHS}" in capsys.readouterr().out
    for command in ("calibrate --groups 4", "design --groups 4"):
        assert main([*command.split(), "--max-ratio", "0.8,2"]) == 0
        head, first, *_ = capsys.readouterr().out.splitlines()
        assert head.split("  ")[0] == "ratio at most" and first.split()[:3] == ["1.25", "0.8", "0.2231"]


def test_a_monitor_shows_both_readings(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = tmp_path / "log.jsonl"
    path.write_text("".join(json.dumps({"d": "yes" if i % 8 == 0 or i % 2 else "no", "g": "fm"[i % 2]}) + "\n" for i in range(240)))
    command = ["monitor", str(path), "--decision", "d", "--group", "g", "--utility", "yes", "--max-local-ratio", "0.8"]
    assert main([*command, "--format", "text"]) == 1
    said = " ".join(capsys.readouterr().out.split())
    assert f"ALARM: local {FOUR_FIFTHS}: " in said and f" local {FOUR_FIFTHS}: exceeds" in said
    assert "above 1.25 (least under 0.8 of the greatest; log 0.2231)" in said
    assert main([*command, "--format", "json"]) == 1
    detected, alarm, last = envelopes(capsys.readouterr().out)
    readings = [detected["result"], alarm["result"], last["result"]["targets"][0]]
    assert [entry["readings"] for entry in readings] == [limit_readings("ratio", F(5, 4))] * 3


def test_an_experiment_shows_both_readings(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    folder = ["--folder", str(tmp_path / "out")]
    assert main(["experiment", "run", "package-delivery", *folder]) == 0
    capsys.readouterr()
    command = ["experiment", "certify", "package-delivery", *folder, "--max-local-ratio", "0.8"]
    assert main(command) in (0, 1, 3)
    assert f"Target: local {FOUR_FIFTHS}." in capsys.readouterr().out
    assert main([*command, "--format", "json"]) in (0, 1, 3)
    assert limit_readings("ratio", F(5, 4)) in [
        target["readings"] for entry in result_of(capsys.readouterr().out)["findings"] for target in entry["targets"]
    ]


@given(limit=st.one_of(positive, st.fractions(0, 30), st.integers(0, 20_000).map(Fraction)), unit=st.sampled_from(["log", "ratio"]))
def test_readings_enclose_each_other(limit: Fraction, unit: str) -> None:
    """log(ratio) = log and ratio·least = 1, each between the two ends that are given, by the comparison that judges targets."""
    if unit == "ratio":
        limit = read_limit("max_ratio", limit or 1)
    said = limit_readings(unit, limit)
    ends = {name: [F(10**9000) if text == "inf" else F(text) for text in texts] for name, texts in said.items()}
    assert all(low <= high for low, high in ends.values())
    assert ends["log" if unit == "log" else "ratio"] == [limit, limit]
    for side, sign in ((0, 1), (1, -1)):
        at = ends["log"][1 - side]
        for found in (ends["ratio"][side], 1 / (ends["least_over_greatest"][1 - side] or F(1, 10**9000))):
            assert sign * compare_log((found.numerator, found.denominator), (at.numerator, at.denominator)) <= 0
    if limit <= 10_000:
        assert all(high - low <= high / 10**10 + F(1, 10**12) for low, high in ends.values())
    text = limit_text("local", unit, limit)
    assert text.startswith("local ") and "of the greatest" in text


def test_a_limit_beyond_numbers_is_said_soundly() -> None:
    assert (
        limit_text("local", "log", F(20_000)) == "local log-ratio at most 2e+04 (ratio above 8.807e+4342; least at least 0 of the greatest)"
    )
    assert limit_text("local", "ratio", F(1)) == "local ratio at most 1 (least at least 1 of the greatest; log 0)"


def test_a_limit_that_is_refused_is_named_as_it_was_given(log: str, capsys: pytest.CaptureFixture[str]) -> None:
    for command in ("plan --guess 0.5,0.5", "calibrate --groups 4", "design --groups 4"):
        for option, value in (("--max-ratio", "0"), ("--max-ratio", "inf"), ("--max-log", "-1"), ("--max-log", "nan")):
            assert refused(capsys, *command.split(), f"{option}={value}").startswith(f"fairaudit: {option}")
    for name in ("max_local_ratio", "max_global_ratio"):
        for value in ("0", "-1", "nan", "inf"):
            assert f"{name}" in refused(capsys, "certify", log, *COLUMNS, f"--{name.replace('_', '-')}={value}")


def test_limits_keep_their_order() -> None:
    """Certificates list targets in one order, whatever order they are given in."""
    given_ = {"max_global_ratio": 2, "max_local_ratio": 3, "max_global_log": 1, "max_local_log": 2}
    assert [(q, u) for q, u, _ in limits_of(given_)] == [("local", "log"), ("local", "ratio"), ("global", "log"), ("global", "ratio")]


# States of before

BEFORE = """
CREATE TABLE alarms (number INTEGER PRIMARY KEY, entry TEXT NOT NULL);
CREATE TABLE cells (window INTEGER, rank INTEGER, context TEXT NOT NULL, label TEXT NOT NULL, PRIMARY KEY (window, rank)) WITHOUT ROWID;
CREATE TABLE counts (window INTEGER, rank INTEGER, decision INTEGER, n INTEGER NOT NULL, PRIMARY KEY (window, rank, decision))
  WITHOUT ROWID;
CREATE TABLE decisions (number INTEGER PRIMARY KEY, label TEXT NOT NULL UNIQUE, utility TEXT NOT NULL);
CREATE TABLE meta (key TEXT PRIMARY KEY, value TEXT NOT NULL) WITHOUT ROWID;
CREATE TABLE seen (digest BLOB PRIMARY KEY) WITHOUT ROWID;
"""
"""What was written by `monitor … --max-local 0.2 --max-global 0.3 --max-local-ratio 4` when limits on logarithms had no ending."""
AUDIT = (
    '{"confidence":"19/20","context":[],"decision":"answer","event_id":null,"expected":4,"group":["sex"],"high":"1",'
    '"layout":"jsonl","low":"0","since":null,"step":null,"targets":{"max_global":"3/10","max_local":"1/5","max_local_ratio":"4"},'
    '"time":null,"unit":[],"utility":{"yes":"1"},"window":null}'
)
ALARM = (
    '{"target": "max_local", "limit": "1/5", "lower": "2341767/1000000", "events": 240, "line": 240, "clock": null, '
    '"order": [[[], ["f"]], [[], ["m"]]], "counts": [[1, 0, 30], [2, 0, 120], [1, 1, 90]]}'
)
ROWS = {
    "cells": [(0, 1, "[]", '["f"]'), (0, 2, "[]", '["m"]')],
    "counts": [(0, 1, 0, 30), (0, 1, 1, 90), (0, 2, 0, 120)],
    "decisions": [(0, "yes", "1"), (1, "(other)", "0")],
    "alarms": [
        (1, ALARM),
    ],
    "meta": [
        ("audit", AUDIT),
        ("digest", "521a03e3364793616b5f56074f924b7c539ab3d229174ff2b77161d0a40421b9"),
        ("format", "fairaudit-monitor/1"),
        ("tally", '{"dead": 0, "repeats": 0, "early": 0, "back": 0, "clock": null, "window": 0, "index": null, "letters": null}'),
    ],
}


def state_of_before(path: Path) -> str:
    with sqlite3.connect(path) as db:
        db.executescript(BEFORE)
        for table, rows in ROWS.items():
            db.executemany(f"INSERT INTO {table} VALUES ({', '.join('?' * len(rows[0]))})", rows)
    db.close()
    return str(path)


def test_a_state_of_before_keeps_the_logarithms_that_it_meant(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = state_of_before(tmp_path / "watch.db")
    kept = {"max_local_log": "1/5", "max_global_log": "3/10", "max_local_ratio": "4"}
    state = State(path, read_only=True)
    assert state.settings.targets == kept
    assert [alarm["target"] for alarm in state.alarms()] == ["max_local_log"]
    state.close()
    for more in ([], ["--at-alarm"]):
        assert main(["certify", "--from-monitor", path, *more, "--format", "json"]) == 1
        targets = result_of(capsys.readouterr().out)["targets"]
        assert {f"max_{t['quantity']}_{t['unit']}": t["limit"] for t in targets} == kept


def test_a_state_of_before_goes_on(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path, log = state_of_before(tmp_path / "watch.db"), tmp_path / "log.jsonl"
    log.write_text('{"answer": "yes", "sex": "m"}\n' * 60)
    audit = ["--decision", "answer", "--group", "sex", "--utility", "yes", "--max-global-log", "0.3", "--max-local-ratio", "4"]
    assert "another audit" in refused(capsys, "monitor", str(log), "--state", path, *audit, "--max-local-log", "0.3")
    assert main(["monitor", str(log), "--state", path, *audit, "--max-local-log", "0.2"]) == 1
    alarms, last = [found["result"] for found in envelopes(capsys.readouterr().out)[-2:]]
    assert last["decisions"] == 300
    assert alarms["target"] == "max_global_log"
    assert [alarm["target"] for alarm in last["alarms"]] == ["max_local_log", "max_global_log"]
    assert main(["monitor", str(log), "--state", path]) == 1


def test_an_altered_state_of_before_is_refused(tmp_path: Path) -> None:
    path = state_of_before(tmp_path / "watch.db")
    with sqlite3.connect(path) as db:
        db.execute("UPDATE meta SET value = replace(value, '\"1/5\"', '\"2/5\"') WHERE key = 'audit'")
    db.close()
    with pytest.raises(InputError, match="was altered"):
        State(path, read_only=True)
