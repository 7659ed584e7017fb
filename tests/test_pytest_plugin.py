"""The fixture that users' tests take: a gate that is kept, exceeded, not settled, or has no target, on the screen and as JUnit."""

from __future__ import annotations

import json
import os
import subprocess
import sys
import xml.etree.ElementTree as ET
from fractions import Fraction
from pathlib import Path

import pytest

from fairaudit import verify

LAW = """\
import fairaudit as fa
def law(f, m, names=("f", "m")):
    table = {'u': ['yes', 'no'] * 2, 'a': [names[0]] * 2 + [names[1]] * 2, 'n': [f, 4000 - f, m, 4000 - m]}
    return fa.Law.from_counts(table, decision='u', group='a', count='n')
"""

GATES = """\
def test_kept(fairness_gate):
    assert fairness_gate(law(2000, 2000), {'yes': 1}, max_local_ratio='5/4').verdict == 'within'
def test_exceeded(fairness_gate):
    fairness_gate(law(2000, 1000), {'yes': 1}, max_local_ratio='5/4', save='exceeded.json')
def test_open(fairness_gate):
    fairness_gate(law(2000, 1650), {'yes': 1}, max_local_ratio='5/4')
def test_none(fairness_gate):
    fairness_gate(law(2000, 2000), {'yes': 1})
"""

OF_A_CASE = {"skipped", "error", "failure", "rerunFailure", "rerunError", "flakyFailure", "flakyError", "system-out", "system-err"}
"""What the schema of Jenkins' xUnit plugin (junit-10.xsd) lets a test case hold."""


def pytested(folder: Path, tests: str, *words: str) -> str:
    """Run pytest on some tests and give what it printed."""
    (folder / "test_gate.py").write_text(LAW + tests, "utf-8")
    command = [sys.executable, "-m", "pytest", "-p", "no:cacheprovider", "-q", "-rf", str(folder), "-c", "/dev/null", *words]
    environment = {name: value for name, value in os.environ.items() if not name.startswith("PYTEST_")}
    return subprocess.run(command, capture_output=True, encoding="utf-8", cwd=folder, env=environment, check=False).stdout


def cases(file: Path) -> dict[str, ET.Element]:
    return {case.attrib["name"]: case for case in ET.parse(file).iter("testcase")}  # noqa: S314 - written by pytest


def properties(case: ET.Element) -> dict[str, str]:
    return {entry.attrib["name"]: entry.attrib["value"] for entry in case.iter("property")}


def test_the_pytest_fixture(tmp_path: Path) -> None:
    """A real pytest run, with one gate that is kept, one that is exceeded, one that is not settled and one without a target."""
    printed = pytested(tmp_path, GATES, "--junitxml=gates.xml", "-o", "junit_logging=system-out")
    assert "3 failed, 1 passed" in printed
    assert "warning" not in printed
    for words_said in ("EXCEEDS", "INCONCLUSIVE", "the fairness gate has no target"):
        assert words_said in printed
    found = cases(tmp_path / "gates.xml")
    verdicts = {name: properties(case)["fairness.verdict"] for name, case in found.items()}
    assert verdicts == {"test_kept": "within", "test_exceeded": "exceeds", "test_open": "inconclusive", "test_none": "none"}
    said = properties(found["test_exceeded"])
    assert said["fairness.local.ratio"] == said["fairness.global.ratio"] == "2"
    ends = json.loads((tmp_path / "exceeded.json").read_text("utf-8"))["intervals"]["local"]["ratio"]
    lower, upper = Fraction(said["fairness.local.at_least"]), Fraction(said["fairness.local.at_most"])
    assert lower <= Fraction(ends[0]) < 2 < Fraction(ends[1]) <= upper
    assert said["fairness.local.confidence"] == "19/20"
    assert said["fairness.certificate"] == "exceeded.json"
    assert verify(tmp_path / "exceeded.json").ok
    failure = found["test_exceeded"].find("failure")
    assert failure is not None
    assert said["fairness.sentence"] in failure.attrib["message"] + (failure.text or "")
    kept = found["test_kept"].find("system-out")
    assert kept is not None
    assert properties(found["test_kept"])["fairness.sentence"] in (kept.text or "")


def test_several_gates_of_a_test_are_told_apart(tmp_path: Path) -> None:
    both = "\n    ".join(f"fairness_gate(law({f}, 2000), {{'yes': 1}}, max_local_ratio=2)" for f in (2000, 2500))
    pytested(tmp_path, f"def test_both(fairness_gate):\n    {both}\n", "--junitxml=gates.xml", "-n", "0")
    said = properties(cases(tmp_path / "gates.xml")["test_both"])
    assert (said["fairness.local.ratio"], said["fairness2.local.ratio"]) == ("1", "5/4")


def test_a_result_is_judged_as_it_is(tmp_path: Path) -> None:
    audit = "fa.audit({'u': ['yes', 'no', 'yes', 'no'], 'a': ['f', 'f', 'm', 'm']}, decision='u', group='a', utility='yes'"
    gates = "".join(
        f"def test_{name}(fairness_gate):\n    result = {audit}, confidence=None, max_local_ratio='5/4')\n    {call}\n"
        for name, call in (
            ("kept", "assert fairness_gate(result, save='c.json') is result"),
            ("wrong", "fairness_gate(result, max_local_ratio=2)"),
        )
    )
    assert "1 failed, 1 passed" in pytested(tmp_path, gates)
    assert verify(tmp_path / "c.json").verdict == "within"


def test_a_strict_schema_is_kept_on_demand(tmp_path: Path) -> None:
    """Properties of a test case are not in every schema; without them, the text is there."""
    pytested(tmp_path, GATES, "--junitxml=gates.xml", "-o", "junit_logging=system-out", "-o", "fairness_properties=false")
    found = cases(tmp_path / "gates.xml")
    assert {part.tag for case in found.values() for part in case} <= OF_A_CASE
    assert all(part.text for case in found.values() for part in case)


@pytest.mark.parametrize("label", ["]]><x/>", "a\x1b[31m\x00b", '"&<', "\u202etxt", "a\nb"])
def test_labels_stay_text_in_the_file(tmp_path: Path, label: str) -> None:
    gate = f"def test_gate(fairness_gate):\n    fairness_gate(law(2000, 1000, ({label!r}, 'm')), {{'yes': 1}}, max_local_ratio=2)\n"
    pytested(tmp_path, gate, "--junitxml=gates.xml", "-o", "junit_logging=system-out")
    (case,) = cases(tmp_path / "gates.xml").values()
    assert {part.tag for part in case} <= OF_A_CASE | {"properties"}
    assert properties(case)["fairness.sentence"].isprintable()
