"""Audits of groups that nobody recorded."""

from __future__ import annotations

import random
from collections import Counter
from fractions import Fraction
from math import inf
from pathlib import Path
from typing import Any

import pytest
from envelopes import PROXIES, result_of
from hypothesis import given
from hypothesis import strategies as st
from jsonschema import Draft202012Validator
from proxy_certificates import proxied

import fairaudit as fa
from fairaudit.audits.proxies import ProxyAudit
from fairaudit.cli import main
from fairaudit.errors import InputError

LOG = "zip,out\n1,y\n1,n\n2,y\n2,y\n2,y\n2,n\n1,y\n1,n\n"
GIVEN = "zip,race,probability\n1,a,0.8\n1,b,0.2\n2,a,0.2\n2,b,0.8\n"


@pytest.fixture
def files(tmp_path: Path) -> Path:
    (tmp_path / "log.csv").write_text(LOG, "utf-8")
    (tmp_path / "given.csv").write_text(GIVEN, "utf-8")
    return tmp_path


def audited(files: Path, **options: Any) -> ProxyAudit:
    found: Any = fa.audit(files / "log.csv", decision="out", group="race", utility="y", group_probability=files / "given.csv", **options)
    return found


def certify(files: Path, *options: str) -> int:
    given_ = ["--decision", "out", "--group", "race", "--utility", "y", "--group-probability", str(files / "given.csv")]
    return main(["certify", str(files / "log.csv"), *given_, *options])


def test_the_example_depends_below_19_over_6_and_is_within_from_there_on(files: Path) -> None:
    assert audited(files).proved("local") == (1, Fraction(19, 6))
    assert audited(files, max_local_ratio="3.1").verdict == "depends"
    assert audited(files, max_local_ratio="19/6").verdict == "within"
    assert audited(files, max_local_log="1.1").verdict == "depends"
    assert audited(files, max_local_log="1.2").verdict == "within"
    made = audited(files, max_local_ratio="5/4")
    assert made.sentence == "the worst ratio is from 1 to 3.167, whoever the members of the groups are."
    assert made.exit_code == 3
    assert fa.verify(made.certificate).ok


def test_forced_ratios_exceed_whoever_the_members_are(files: Path) -> None:
    (files / "given.csv").write_text("zip,race,probability\n1,a,1\n1,b,0\n2,a,0\n2,b,1\n", "utf-8")
    made = audited(files, max_local_ratio="5/4")
    assert (made.verdict, made.proved("local"), made.exit_code) == ("exceeds", (Fraction(3, 2), Fraction(3, 2)), 1)


def test_the_command_says_the_same_and_its_certificate_is_checked(files: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert certify(files, "--max-local-ratio", "5/4", "--show-completions", "-o", str(files / "c.json")) == 3
    said = capsys.readouterr().out
    assert "DEPENDS      local ratio at most 1.25" in said
    assert "a / b  ratio 0.3157 to 1.273" in said
    assert said.count("a constructed witness with the ratio") == 2
    assert "sampling error comes on top" in said
    assert main(["verify", str(files / "c.json")]) == 0
    assert main(["verify", str(files / "c.json"), "--require", "within"]) == 1
    assert certify(files, "--no-table", "-o", str(files / "apart.json")) == 0
    assert main(["verify", str(files / "apart.json")]) == 3
    assert main(["verify", str(files / "apart.json"), "--table", str(files / "apart.table.jsonl")]) == 0
    capsys.readouterr()
    assert certify(files, "--format", "json") == 0
    assert result_of(capsys.readouterr().out)["format"] == "fairaudit-proxies/1"


def test_the_same_table_has_the_same_bytes(files: Path) -> None:
    assert audited(files).certificate.text == audited(files).certificate.text


@given(st.integers(0, 10**6), st.sampled_from([2, 3]), st.booleans())
def test_completions_are_of_the_log_and_have_the_ratio_that_is_said(seed: int, groups: int, intervals: bool) -> None:
    made = proxied(random.Random(seed), groups, intervals=intervals)
    for found in made.local:
        for which, completion in (("low", found.ends.low), ("high", found.ends.high)):
            counts: Counter[tuple[Any, str]] = Counter()
            sums, sizes = [Fraction(0)] * len(found.groups), [Fraction(0)] * len(found.groups)
            for label, decision, rows in made.completion(found, which):  # type: ignore[arg-type]
                assert min(rows) >= 0
                counts[label, decision] += sum(rows)
                gain = Fraction(int(made.utility.values[made.law.decisions.index(decision)]), made.utility.scale)
                sums = [one + gain * other for one, other in zip(sums, rows, strict=True)]
                sizes = [one + other for one, other in zip(sizes, rows, strict=True)]
            law = made.law
            for row, a in enumerate(law.cell_group.tolist()):
                for decision, count in zip(law.decisions, law.row(row), strict=True):
                    assert counts[law.groups[a], decision] == count
            means = [total / size for total, size in zip(sums, sizes, strict=True)]
            top, bottom = max(means), min(means)
            assert completion.ratio == (top / bottom if bottom else inf if top else 1)


@given(st.integers(0, 10**6), st.sampled_from([2, 3, 4]), st.booleans(), st.sampled_from([1, 2]))
def test_certificates_are_true_and_their_verdicts_follow(seed: int, groups: int, intervals: bool, contexts: int) -> None:
    made = proxied(random.Random(seed), groups, intervals=intervals, contexts=contexts)
    assert fa.verify(made.certificate).ok
    Draft202012Validator(PROXIES).validate(made.certificate.document)
    for target in made.targets:
        proved, reached = made.proved(target.quantity), made.reached(target.quantity)
        assert proved is not None and reached is not None
        assert proved[0] <= reached[0] and reached[1] <= proved[1]
        if target.verdict == "depends":
            assert reached[0] <= target.limit < reached[1]
        assert (target.verdict == "within") == (proved[1] <= target.limit)
        assert (target.verdict == "exceeds") == (proved[0] > target.limit)
        assert target.verdict != "inconclusive" or intervals


def test_contexts_that_no_cell_names_are_assumed_to_say_nothing_of_groups() -> None:
    assert "the shares of a cell are the same in each context" in proxied(random.Random(1), 2, contexts=2).assumptions
    log = {"dept": ["A", "A", "B", "B"], "out": ["y", "n"] * 2, "n": [3, 1, 2, 2]}
    given_ = {"dept": ["A", "A", "B", "B"], "sex": ["f", "m"] * 2, "probability": ["1/2", "1/2", "1/4", "3/4"]}
    made: Any = fa.audit(log, decision="out", group="sex", context="dept", count="n", utility="y", group_probability=given_)
    assert "the shares of a cell are the same in each context" not in made.assumptions
    assert [found.context for found in made.local] == [("A",), ("B",)]
    assert made.global_.context is None
    assert fa.verify(made.certificate).ok


def test_berkeley_is_what_its_departments_allow() -> None:
    """Figures of docs/proxies.md; the truth, which the other column of the same table tells, lies inside, and sure names of it give it."""
    table = fa.example("ucb-admissions").table()
    log = {name: list(table[name]) for name in ("Dept", "Gender", "Admit")} | {"n": [int(count) for count in table["Freq"]]}
    sizes: Counter[tuple[str, str]] = Counter()
    for dept, gender, count in zip(log["Dept"], log["Gender"], log["n"], strict=True):
        sizes[dept, gender] += count
    shares = {key: Fraction(count, sizes[key[0], "Male"] + sizes[key[0], "Female"]) for key, count in sizes.items()}
    given_ = {"Dept": [d for d, _ in shares], "sex": [g for _, g in shares], "probability": [*map(str, shares.values())]}
    asked: dict[str, Any] = {"decision": "Admit", "group": "sex", "count": "n", "utility": "Admitted"}
    merged = {name: log[name] for name in ("Dept", "Admit", "n")}
    loose: Any = fa.audit(merged, **asked, group_probability=given_, max_local_ratio="5/4")
    assert loose.groups == (("Male",), ("Female",))
    assert loose.local[0].ends.means == ((Fraction(838, 2691), Fraction(15, 23)), (Fraction(0), Fraction(917, 1835)))
    assert (loose.verdict, loose.proved("local")) == ("depends", (1, inf))
    truth = Fraction(2198330, 1498887)
    (low, _), (high, _) = loose.local[0].ends.pairs[0, 1]
    assert low < truth < high
    sure = {"Gender": ["Male", "Male", "Female", "Female"], "sex": ["m", "f"] * 2, "probability": [1, 0, 0, 1]}
    known: Any = fa.audit(log, **asked, group_probability=sure)
    assert known.proved("local") == (truth, truth)


def test_cells_that_the_log_does_not_have_say_nothing() -> None:
    log = {"zip": ["1", "1", "2", "2"], "job": ["j", "k"] * 2, "out": ["y", "n"] * 2, "n": [3, 1, 2, 2]}
    given_ = {"zip": ["1", "1", "2", "2", "3", "3"], "sex": ["f", "m"] * 3, "low": ["1/2", "1/2", "1/4", "1/2", "0", "0"]}
    given_["high"] = ["1/2", "1/2", "1/4", "3/4", "1", "1"]  # which leaves 3/4 for the men of zip 2
    made: Any = fa.audit(log, decision="out", group="sex", count="n", utility="y", group_probability=given_)
    assert made.exact and fa.verify(made.certificate).ok
    given_["high"] = ["1"] * 6
    made = fa.audit(log, decision="out", group="sex", context="job", count="n", utility="y", group_probability=given_)
    assert not made.exact and fa.verify(made.certificate).ok
    assert "the ends that are given for a cell hold in each context" in made.assumptions


def test_a_group_without_rows_in_a_context_is_not_compared_there() -> None:
    log = {"dept": ["A", "A", "B", "B"], "out": ["y", "n"] * 2, "n": [3, 1, 2, 2]}
    given_ = {"dept": ["A", "A", "B", "B"], "sex": ["f", "m"] * 2, "probability": ["0", "1", "1/4", "3/4"]}
    made: Any = fa.audit(log, decision="out", group="sex", context="dept", count="n", utility="y", group_probability=given_)
    assert [found.context for found in made.local] == [("B",)]
    assert fa.verify(made.certificate).ok


@pytest.mark.parametrize(
    ("options", "says"),
    [
        (["--confidence", "0.9"], "--confidence does not go with --group-probability"),
        (["--truth", "zip"], "--truth does not go with --group-probability"),
        (["--from-monitor", "x"], "--from-monitor does not go with --group-probability"),
        (["--difference"], "--difference does not go with --group-probability"),
        (["--unit", "zip"], "--unit does not go with --group-probability"),
        (["--fold-labels"], "--fold-labels does not go with --group-probability"),
        (["--probability", "zip"], "--probability does not go with --group-probability"),
    ],
)
def test_what_has_no_meaning_is_refused(files: Path, capsys: pytest.CaptureFixture[str], options: list[str], says: str) -> None:
    assert certify(files, *options) == 2
    assert says in capsys.readouterr().err


@pytest.mark.parametrize(
    ("log", "given_", "says"),
    [
        (LOG + "3,y\n", GIVEN, "has no probabilities for the cell zip='3' of the log"),
        (LOG.replace("zip", "place"), GIVEN, "there is no column 'zip'"),
        (LOG, GIVEN.replace("zip", "out"), "the column 'out' says which cell"),
        ("zip,out\n1,y\n1,n\n", GIVEN, "the log has one cell only"),
        (LOG, "zip,race,low,high\n1,a,0,0.5\n1,b,0.5,1\n2,a,0,0.5\n2,b,0.5,1\n", "the group 'a' might have no rows at all"),
    ],
)
def test_tables_that_do_not_fit_are_refused_in_one_sentence(files: Path, log: str, given_: str, says: str) -> None:
    (files / "log.csv").write_text(log, "utf-8")
    (files / "given.csv").write_text(given_, "utf-8")
    with pytest.raises(InputError) as refused:
        audited(files)
    assert says in str(refused.value)


def test_options_of_other_audits_are_refused_in_python(files: Path) -> None:
    for options in ({"confidence": 0.9}, {"difference": True}, {"declared": {"m": 0}}, {"unit": "zip"}, {"in_parts": True}):
        with pytest.raises(InputError, match="group_probability"):
            audited(files, **options)


def test_completions_are_printed_of_such_audits_alone(files: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["certify", str(files / "log.csv"), "--show-completions"]) == 2
    assert "--show-completions goes with --group-probability" in capsys.readouterr().err


def test_certificates_of_this_format_are_not_compared(files: Path) -> None:
    made = audited(files)
    with pytest.raises(InputError, match="fairaudit-proxies/1"):
        fa.compare(made.certificate, made.certificate)
