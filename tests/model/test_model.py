"""Decisions that the utility names and that never occurred: they count into the range of the utility, in every face."""

from __future__ import annotations

import json
from fractions import Fraction
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import fairaudit as fa
from fairaudit import checker
from fairaudit.cli import main
from fairaudit.errors import InputError
from fairaudit.inference.policy_comparisons import policy_comparison
from fairaudit.inference.ratio_intervals import ratio_interval

F = Fraction
DECLARED = {"yes": 1, "maybe": "0.5"}
KEPT = "'yes' never occurred; it is kept as a possible decision"


def rows(f: int, m: int, of: int = 40) -> dict[str, list[Any]]:
    """Counts in which nobody hears yes."""
    return {"u": ["maybe", "no"] * 2, "a": list("ffmm"), "n": [f, of - f, m, of - m]}


def counts(f: int = 14, m: int = 9, of: int = 40) -> fa.Law:
    return fa.Law.from_counts(rows(f, m, of), decision="u", group="a", count="n")


def log(f: int = 14, m: int = 9, of: int = 40) -> dict[str, list[Any]]:
    table = rows(f, m, of)
    listed = [(u, a) for u, a, n in zip(*table.values(), strict=True) for _ in range(n)]
    return {"u": [u for u, _ in listed], "a": [a for _, a in listed], "person": [i // 2 for i in range(len(listed))]}


def accepted(result: fa.Result) -> dict[str, Any]:
    certificate = result.certificate
    report = checker.check(certificate.text.encode(), certificate.table.lines() if certificate.table else None)
    assert report.ok, [finding for finding in report.findings if not finding.true]
    return certificate.document


def policy(kind: str) -> fa.Policy:
    if kind == "counts":
        return fa.Policy.from_counts(rows(14, 9), decision="u", group="a", count="n")
    return fa.Policy.from_array([["0.35", "0.65"], ["0.25", "0.75"]], decisions=["maybe", "no"], groups=["f", "m"])


COIN = fa.RandomizedResponse(["f", "m"], keep_probability="0.7")
FACES = {
    "counts": counts,
    "log": lambda: fa.Law.from_log(log(), decision="u", group="a"),
    "units": lambda: fa.Law.from_log(log(), decision="u", group="a", unit="person"),
    "probabilities": lambda: fa.Law.from_array([["0.35", "0.65"], ["0.25", "0.75"]], decisions=["maybe", "no"], groups=["f", "m"]),
    "floats": lambda: fa.Law.from_array(np.array([[0.25, 0.75], [0.5, 0.5]]), decisions=["maybe", "no"], groups=["f", "m"]),
    "policy from counts": lambda: policy("counts").behind(group=COIN),
    "policy": lambda: policy("probabilities").behind(group=COIN),
}


@pytest.mark.parametrize("face", FACES)
def test_the_range_goes_up_to_what_was_declared(face: str) -> None:
    subject = FACES[face]()
    result = fa.certify(subject, DECLARED, max_local_ratio=100)
    document = accepted(result)
    assert KEPT in result.notes
    assert document["subject"]["utility"]["gamma"] == "1"
    assert document["subject"]["table"]["header"]["decisions"] == ["maybe", "no", "yes"]
    # As if somebody had listed the label in a table of counts, with the count 0.
    alone = fa.certify(subject, {"maybe": "0.5"}, max_local_ratio=100)
    assert result.local is not None and alone.local is not None
    assert (result.local.ratio, result.demographic_parity) == (alone.local.ratio, alone.demographic_parity)
    for quantity, found in result.intervals.items():
        assert found.lower <= alone.intervals[quantity].lower and found.upper >= alone.intervals[quantity].upper
    if face == "counts":
        zero = {"u": ["maybe", "no", "yes"] * 2, "a": list("fffmmm"), "n": [14, 26, 0, 9, 31, 0]}
        listed = fa.certify(fa.Law.from_counts(zero, decision="u", group="a", count="n"), DECLARED, max_local_ratio=100)
        assert document == accepted(listed) and KEPT not in listed.notes


@pytest.mark.parametrize("range_", [[], ["--utility-range", "0,1"]])
def test_the_command_line_and_audit_files(range_: list[str], tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path, out = tmp_path / "log.csv", tmp_path / "c.json"
    path.write_text("u,a\n" + "".join(f"{u},{a}\n" for u, a in zip(log()["u"], log()["a"], strict=True)))
    command = ["certify", str(path), "--decision", "u", "--group", "a", "--utility", "yes=1,maybe=0.5", *range_, "-o", str(out)]
    assert main(command) == 0
    assert KEPT in capsys.readouterr().err
    assert json.loads(out.read_text())["subject"]["utility"]["gamma"] == "1"
    assert main(["verify", str(out)]) == 0
    audit = tmp_path / "audit.toml"
    audit.write_text('[law]\ntable = "log.csv"\ndecision = "u"\ngroup = "a"\n[utility]\nvalues = { yes = 1, maybe = "0.5" }\n')
    stored = json.loads(out.read_text())
    assert main(["certify", str(audit), "-o", str(out)]) == 0
    assert range_ or json.loads(out.read_text()) == stored


def test_filters_are_calibrated_and_designed_with_it() -> None:
    known = policy("probabilities")
    for utility in ({"maybe": "0.5"}, DECLARED):
        calibrated = fa.calibrate_policy(known, utility, max_ratio="11/10")
        designed = fa.design(known, utility, max_ratio="11/10")
        assert calibrated.feasible
        assert designed.achieved == F(11, 10)
    found = ratio_interval(policy_comparison(policy("counts"), fa.Utility(DECLARED), COIN))
    assert found.evidence["cells"][0]["range"] == ["0", "1"]


@pytest.mark.parametrize(
    ("utility", "words"),
    [
        ({"mayby": 1, "no": 0}, ["'mayby', which does not occur", "did you mean 'maybe'?", "give 'maybe' a utility too"]),
        ({"Maybe": 1, "no": 0}, ["did you mean 'maybe'?"]),
        ({" maybe": 1, "no": 0}, ["did you mean 'maybe'?"]),
        ({"yes": 1}, ["'yes', which does not occur; known: 'maybe', 'no'", "give 'maybe' a utility too, such as 0"]),
    ],
)
def test_misspellings_are_errors(utility: dict[str, Any], words: list[str]) -> None:
    """A label that would count for nothing at all is one, too; the way out that the message names gives a sound interval."""
    with pytest.raises(InputError) as refused:
        fa.certify(counts(), utility)
    assert all(word in str(refused.value) for word in words)
    result = fa.certify(counts(), {"maybe": 0, **utility})
    assert result.utility.gamma == 1 and any("never occurred" in note for note in result.notes)


def test_grades_are_no_misspellings_of_each_other() -> None:
    table = {"u": ["grade 1", "grade 2", "grade 3", "grade 2"] * 9, "a": list("ffmm") * 9}
    grades = {f"grade {i}": i - 1 for i in range(1, 6)}
    result = fa.certify(fa.Law.from_log(table, decision="u", group="a"), grades)
    assert "'grade 4', 'grade 5' never occurred; they are kept as possible decisions" in result.notes
    assert accepted(result)["subject"]["utility"]["gamma"] == "4"


@given(st.dictionaries(st.sampled_from("abcde"), st.fractions(0, 3), min_size=1), st.integers(0, 30), st.integers(0, 30))
def test_any_declared_utility_is_in_the_range(utility: dict[str, Fraction], f: int, m: int) -> None:
    law = fa.Law.from_counts(
        {"u": list("abab"), "a": list("ffmm"), "n": [f + 1, 31 - f, m + 1, 31 - m]}, decision="u", group="a", count="n"
    )
    if not utility.keys() & {"a", "b"}:
        with pytest.raises(InputError, match="does not occur"):
            fa.certify(law, utility)
        return
    result = fa.certify(law, utility, max_local_ratio=3)
    accepted(result)
    assert result.utility.gamma == max(utility.values())
    assert {cell.high for cell in result.comparisons["local"].cells} == {max(utility.values())}
