"""Whether the second of two certificates is less fair than the first."""

from __future__ import annotations

import json
from fractions import Fraction
from math import inf
from pathlib import Path
from typing import Any

import pytest
from certificate_kinds import KINDS, never_locally
from envelopes import result_of
from evaluation_changes import UNITS
from hypothesis import given, settings
from hypothesis import strategies as st
from oracle import local as local_oracle
from oracle import plain

import fairaudit as fa
from fairaudit.certificates.compare import compare_documents
from fairaudit.certificates.fairness import Fairness, drawn_otherwise
from fairaudit.cli import main as command
from fairaudit.testing import laws

F = Fraction


def certified(rows: list[list[int]], groups: str = "fmx", **options: Any) -> dict[str, Any]:
    law = fa.Law.from_array(rows, kind="counts", decisions=["yes", "no"], groups=list(groups[: len(rows)]))
    return fa.certify(law, {"yes": 1}, **options).certificate.document


def local(old: dict[str, Any], new: dict[str, Any], margin: Any = 1) -> Fairness:
    (found,) = (entry for entry in compare_documents(old, new, F(margin)).fairness if entry.quantity == "local")
    return found


def stated(document: dict[str, Any], quantity: str = "local") -> tuple[list[Any], Fraction]:
    interval = document["intervals"][quantity]
    return [inf if end == "inf" else F(end) for end in interval["ratio"]], F(interval["confidence"])


@pytest.mark.parametrize("judged", [{}, {"max_local_ratio": "5/4"}])
@given(yes=st.lists(st.integers(0, 400), min_size=4, max_size=4), margin=st.sampled_from([F(1), F(11, 10), F(2)]))
@settings(max_examples=25)
def test_the_quotient_is_that_of_the_ends_and_the_errors_add_up(judged: dict[str, str], yes: list[int], margin: Fraction) -> None:
    old, new = (
        certified([[k, 400 - k] for k in pair], confidence=confidence, **judged)
        for pair, confidence in ((yes[:2], "0.975"), (yes[2:], "0.98"))
    )
    found = local(old, new, margin)
    (low, high), one = stated(old)
    (least, greatest), other = stated(new)
    assert found.confidence == one + other - 1 == F("0.955")
    assert found.ratio[0] == (0 if high == inf else least / high) and found.ratio[1] == (inf if greatest == inf else greatest / low)
    assert (found.verdict == "less fair") is (least > margin * high)
    assert (found.verdict == "no less fair") is (greatest <= margin * low)


@given(data=st.data(), margin=st.sampled_from([F(1), F(5, 4)]))
@settings(max_examples=40)
def test_tables_themselves_are_compared_exactly(data: st.DataObject, margin: Fraction) -> None:
    shape = {"max_contexts": 2, "max_groups": 2, "max_decisions": 2, "kinds": ("probabilities",), "complete": True}
    one = data.draw(laws(**shape))
    two = data.draw(laws(**shape).filter(lambda law: law.groups == one.groups and law.contexts == one.contexts))
    utility = {one.decisions[0]: 1}
    both = [fa.certify(law, utility) for law in (one, two)]
    found = compare_documents(*(result.certificate.document for result in both), margin).fairness
    attained = [local_oracle(plain(law, fa.Utility(utility))) for law in (one, two)]
    if None in attained:
        assert all(entry.quantity == "global" for entry in found)
        return
    (was, *_), (now, *_) = attained
    entry = found[0]
    assert (entry.old, entry.new, entry.confidence) == ((was, was), (now, now), None)
    assert entry.verdict == ("less fair" if now > margin * was else "no less fair")
    assert "nothing is said of a population" in entry.ends


def test_infinite_ratios() -> None:
    endless, even = certified([[0, 4], [4, 4]], confidence=None), certified([[4, 4], [4, 4]], confidence=None)
    assert (local(even, endless).verdict, local(even, endless).ratio) == ("less fair", (inf, inf))
    assert (local(endless, even).verdict, local(endless, even).ratio) == ("no less fair", (0, 0))
    assert (local(endless, endless).verdict, local(endless, endless).ratio) == ("no less fair", (0, inf))


def test_nothing_is_established_where_the_two_do_not_compare_the_same() -> None:
    sure = {"confidence": "0.975"}
    far, even = certified([[900, 100], [300, 700]], **sure), certified([[500, 500], [500, 500]], **sure)
    third = [500, 500]
    assert local(even, far).verdict == "less fair" and local(far, even, 2).verdict == "no less fair"
    more = certified([[900, 100], [300, 700], third], **sure)
    found = local(even, more)  # the group that makes it less fair may be the new one
    assert found.verdict == "not established" and "group 'x' is only in the new one" in found.why
    assert local(more, even).verdict == "not established" and "'x' is not there any more" in local(more, even).why
    assert local(more, far, 1).why == "" and local(far, more, "3/2").verdict == "no less fair"  # with one more group to compare, too
    exact: dict[str, Any] = {"confidence": None}
    apart = certified([[900, 100], [300, 700]], embed_table=False, **exact)
    assert "does not hold its table" in local(certified([[500, 500], [500, 500]], **exact), apart).why
    assert "something of a population" in local(even, certified([[900, 100], [300, 700]], confidence=None)).why
    low = certified([[900, 100], [300, 700]], confidence="0.5")
    assert local(low, low).confidence == 0 and "add up" in local(low, low).why


def test_left_out_decisions_are_in_the_way_of_one_answer() -> None:
    def prepared(rows: list[list[int]], n: int) -> dict[str, Any]:
        document = certified(rows, confidence=None)
        entry = {"step": "left out", "reason": "missing label", "decisions": str(n), "of": "3000", "columns": {"sex": str(n)}}
        return {**document, "subject": {**document["subject"], "preparation": [entry]}}

    far, even = [[900, 100], [300, 700]], [[500, 500], [500, 500]]
    assert local(prepared(even, 5), prepared(far, 9)).verdict == "less fair"
    assert local(prepared(even, 9), prepared(far, 5)).verdict == "not established"
    assert local(prepared(far, 9), prepared(even, 5)).verdict == "no less fair"
    assert local(prepared(far, 5), prepared(even, 9)).verdict == "not established"


def test_means_over_units_are_not_compared_with_means_over_rows() -> None:
    rows = [("yes" if i % 3 else "no", "fm"[i % 2], str(i // 4)) for i in range(400)]
    log = dict(zip(("hired", "sex", "run"), map(list, zip(*rows, strict=True)), strict=True))
    asked: dict[str, Any] = {"decision": "hired", "group": "sex", "utility": "yes"}
    one, other = (fa.audit(log, **asked, **more).certificate.document for more in ({}, {"unit": "run"}))
    assert local(one, one).why == "" and "about the mean over" in local(one, other).why


def test_decisions_of_unknown_group_are_taken_as_whoever_they_are() -> None:
    def made(n: int, declined: int) -> dict[str, Any]:
        table = {"hired": ["yes", "no"] * 3, "sex": ["f", "f", "m", "m", "?", "?"], "n": [n, 100, 100, 100, declined, declined]}
        asked: dict[str, Any] = {"decision": "hired", "group": "sex", "count": "n", "utility": "yes", "unknown": ["?"], "confidence": None}
        return fa.audit(table, **asked).certificate.document

    few, many = local(made(100, 1), made(400, 1)), local(made(100, 1), made(130, 50))
    assert few.verdict == "less fair" and few.new[0] < F(8, 5) < few.new[1] and few.confidence is None
    assert many.verdict == "not established"


@pytest.mark.parametrize("kind", KINDS)
def test_every_kind_has_an_answer(kind: Any) -> None:
    document = kind(confidence=None).certificate.document
    found = compare_documents(document, document).fairness
    assert {entry.quantity for entry in found} == {name for name in ("local", "global") if document["metrics"][name] is not None}
    for entry in found:
        assert entry.verdict == "no less fair" or entry.old[0] < entry.old[1] or entry.why


def test_the_margin_is_a_number_from_1() -> None:
    for margin in ("0.9", 0):
        with pytest.raises(fa.InputError, match="from 1"):
            fa.compare(certified([[1, 1], [1, 1]]), certified([[1, 1], [1, 1]]), margin=margin)
    with pytest.raises(fa.InputError):
        fa.compare(certified([[1, 1], [1, 1]]), certified([[1, 1], [1, 1]]), margin="x")


def test_exit_codes_and_what_is_printed(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    made = {
        "even": certified([[5000, 5000], [5000, 5000]], confidence="0.975"),
        "far": certified([[9000, 1000], [3000, 7000]], confidence="0.975"),
        "alone": never_locally().certificate.document,
    }
    names = {}
    for name, document in made.items():
        names[name] = str(tmp_path / f"{name}.json")
        Path(names[name]).write_text(json.dumps(document))

    def run(old: str, new: str, *more: str) -> tuple[int, str, str]:
        code = command(["compare", names[old], names[new], "--fail-on", "less-fair", *more])
        return code, *capsys.readouterr()

    assert run("even", "far")[0] == 1 and run("far", "even")[0] == 0 and run("even", "even")[0] == 3
    assert run("even", "even", "--margin", "1.1")[0] == 0 and run("even", "far", "--global", "--margin", "2")[0] == 1
    code, out, _ = run("even", "even", "--margin", "1.1")
    assert out.startswith("NO LESS FAIR: the local ratio of the new one is at most 1.1 times that of the old one\n")
    assert "each at 95 %, whatever the draws of the two have to do with each other" in out
    for form in ("json", "markdown"):
        code, out, _ = run("even", "far", "--format", form)
        assert code == 1 and "LESS FAIR: the local ratio of the new one is more than that of the old one" in out
    assert result_of(run("even", "far", "--format", "json")[1])["fairness"][0]["verdict"] == "less fair"
    assert run("alone", "alone")[0] == 2
    for low, high, said in (1000, 1001, "1.001 times as much in the tables alone"), (10**6, 10**6 + 1, "1.000001 times as much in the"):
        names["tiny"] = str(tmp_path / "tiny.json")
        Path(names["tiny"]).write_text(json.dumps(certified([[low, 9 * low], [high, 10 * low - high]], confidence=None)))
        names["equal"] = str(tmp_path / "equal.json")
        Path(names["equal"]).write_text(json.dumps(certified([[low, 9 * low], [low, 9 * low]], confidence=None)))
        code, out, _ = run("equal", "tiny")
        assert code == 1 and said in out.splitlines()[0] and "worse" not in out and "new/old is 1," not in out
    found = local(made["even"], made["far"])
    assert f"{found.verdict.upper()}: " in found.sentence and ", at least " in found.sentence and "tables" not in found.sentence
    least = F(found.sentence.partition(", at least ")[2].split()[0])
    assert found.ratio[0] - F(1, 1000) * found.ratio[0] <= least <= found.ratio[0]
    assert command(["compare", names["even"], names["far"]]) == 0  # no target, so no verdict got worse
    assert "LESS FAIR" in capsys.readouterr().out
    assert command(["compare", names["even"], names["far"], "--global"]) == 2


def undecided(yes: list[int], lost: list[int], **options: Any) -> dict[str, Any]:
    rows = [[k, 400 - k - n, n] for k, n in zip(yes, lost, strict=True)]
    law = fa.Law.from_array(rows, kind="counts", decisions=["yes", "no", "refused"], groups=["f", "m"])
    return fa.certify(law, {"yes": 1}, **{"undecided": "refused", **options}).certificate.document


def test_undecided_decisions_are_taken_as_whatever_they_meant() -> None:
    """Of tables the ranges, of populations the intervals that hold whatever they meant; a face value on one side answers nothing."""
    old, new = undecided([200, 100], [20, 40], confidence=None), undecided([200, 180], [0, 10], confidence=None)
    found = local(old, new)
    assert (found.old, found.new) == ((F(200, 140), F(220, 100)), (F(200, 190), F(200, 180)))
    assert (found.ratio, found.verdict) == ((F(200, 190) / F(220, 100), F(200, 180) / F(200, 140)), "no less fair")
    assert any("whatever they meant" in text for text in found.assumptions)
    assert local(undecided([200, 180], [0, 10], confidence=None), old).verdict == "less fair"
    one, other = (undecided(yes, lost, confidence="0.975") for yes, lost in (([300, 30], [4, 8]), ([220, 180], [0, 10])))
    found = local(one, other)
    assert found.new == tuple(F(end) for end in other["intervals"]["local"]["ratio"])
    assert (found.confidence, found.verdict) == (F(19, 20), "no less fair")
    plain_ = undecided([220, 180], [0, 10], confidence="0.975", undecided=())
    for pair in ((one, plain_), (plain_, one)):
        assert local(*pair).verdict == "not established"
        gone = "the decision 'refused' may have meant anything in one and counts at face value in the other"
        assert compare_documents(*pair).gone == (gone,)


@pytest.mark.parametrize("options", [{"hidden_context": "2,2"}, {"max_drift": "1/20"}])
def test_an_objection_is_no_confidence(options: dict[str, Any]) -> None:
    """Targets that are judged of a population under an objection are compared with those that are not."""
    rows = [[300, 100], [200, 200]]
    found = compare_documents(certified(rows, max_local_ratio=2), certified(rows, max_local_ratio=2, **options))
    assert [change.what for change in found.targets] and "instead of" in found.targets[0].note


def drawn(made: dict[str, Any], said: str | None) -> dict[str, Any]:
    """A certificate whose evaluation log says what was drawn."""
    evaluation = {"drawn": said, "errors": "refuse", "samples": {"expected": None}}
    return made if said is None else {**made, "subject": {**made["subject"], "evaluation": evaluation}}


@pytest.mark.parametrize(
    ("first", "second"), [("questions were drawn", "answers were drawn"), ("questions were drawn", None), (None, "answers were drawn")]
)
def test_draws_of_different_things_say_nothing_of_each_other(first: str | None, second: str | None) -> None:
    """Whether questions or answers were drawn makes other populations; the tables themselves can be compared nevertheless."""
    even, far = ([[5000, 5000], [5000, 5000]], [[9000, 1000], [3000, 7000]])
    for one, other in ((even, far), (far, even)):
        old, new = (certified(rows, confidence="0.975", max_local_ratio="3/2") for rows in (one, other))
        assert local(drawn(old, first), drawn(new, first)).verdict != "not established"
        found = compare_documents(drawn(old, first), drawn(new, second))
        assert {entry.verdict for entry in found.fairness} == {"not established"}
        assert all("the two describe different things" in entry.why and (first or second or "") in entry.why for entry in found.fairness)
        assert [entry.direction for entry in found.intervals] == ["changed", "changed"] and found.gone[0] == found.fairness[0].why
        assert all(change.direction != "better" for change in (found.verdict, *found.targets))
        old, new = (certified(rows, confidence=None) for rows in (one, other))
        assert local(drawn(old, first), drawn(new, second)).verdict != "not established"


def test_units_of_another_kind_are_another_population() -> None:
    """Questions are told by one column or another; what else was drawn is what its columns name."""
    made = certified([[9000, 1000], [3000, 7000]], confidence="0.975")

    def by(said: str, *unit: str) -> dict[str, Any]:
        document = drawn(made, said)
        document["subject"]["evaluation"]["unit"] = list(unit)
        return document

    assert drawn_otherwise(by(UNITS, "person"), by(UNITS, "person")) == ""
    assert drawn_otherwise(by("questions were drawn", "id"), by("questions were drawn", "doc_id")) == ""
    assert f"in the old one {UNITS} ('person'), in the new one {UNITS} ('household')" in drawn_otherwise(
        by(UNITS, "person"), by(UNITS, "household")
    )


def worth(column: str, values: list[str], yes: int = 300) -> dict[str, Any]:
    table = {"d": ["x", "y"] * 2, "g": ["f", "f", "m", "m"], column: values, "n": [yes, 400 - yes, 200, 200]}
    return fa.audit(table, decision="d", group="g", count="n", utility_column=column, confidence=None).certificate.document


def test_utilities_that_vary_with_the_group_are_compared_where_both_have_them() -> None:
    salary, score = worth("salary", ["1", "0", "1", "1/4"]), worth("score", ["0", "1", "1/10", "1"])
    found = compare_documents(salary, score)
    assert {(entry.verdict, entry.why) for entry in found.fairness} == {
        ("not established", "the utility varies with context or group, and it is not the same in both")
    }
    assert any("it is not the same in both" in note for note in found.notes)
    again = compare_documents(salary, worth("salary", ["1", "0", "1", "1/4"], yes=380))
    assert again.fairness[0].verdict == "less fair" or again.fairness[0].verdict == "no less fair"
    assert again.fairness[0].why == "" and any("the same in both" in note and "not the same" not in note for note in again.notes)


def test_unknown_groups_in_one_certificate_leave_the_figure_of_the_other() -> None:
    def made(n: list[int], **options: Any) -> dict[str, Any]:
        table = {"d": ["yes", "no"] * (len(n) // 2), "g": ["f", "f", "m", "m", "n/a", "n/a"][: len(n)], "n": n}
        return fa.audit(table, decision="d", group="g", count="n", utility="yes", confidence=None, **options).certificate.document

    known, unknown = made([200, 200, 200, 200]), made([300, 100, 100, 300, 3, 3], unknown=["n/a"])
    found = local(known, unknown)
    # of 3 and 3 of unknown group the least ratio is where those with yes are m and those with no are f
    assert found.old == (1, 1) and found.new[0] == F(300, 403) / F(103, 403) and found.verdict == "less fair"
    back = local(unknown, known)
    assert back.verdict == "no less fair" and back.ratio == (1 / found.new[1], 1 / found.new[0])
    still = local(unknown, unknown)
    assert still.verdict == "not established" and still.why == "who those of unknown group are leaves it open"


def test_a_log_beside_itself_says_that_meanings_leave_it_open() -> None:
    made = undecided([200, 100], [20, 40], confidence=None)
    found = local(made, made)
    assert found.verdict == "not established" and found.why == "what undecided decisions meant leaves it open"
