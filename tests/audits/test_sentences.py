"""The pair of groups that a verdict, its sentence and every report name is the one that decided; burdens and few decisions are said."""

from __future__ import annotations

import json
import re
from collections.abc import Mapping
from dataclasses import replace
from fractions import Fraction
from itertools import permutations, product
from math import inf
from pathlib import Path
from typing import Any

import pytest
from envelopes import envelope, envelopes
from hypothesis import assume, given, settings
from hypothesis import strategies as st

import fairaudit as fa
from fairaudit import checker
from fairaudit.audits.sentences import decide, sentence
from fairaudit.certificates.reader import load
from fairaudit.cli import main as command
from fairaudit.exact.rationals import quotient
from fairaudit.inference.anytime import Arrivals
from fairaudit.inference.comparisons import Comparison
from fairaudit.inference.interval import Interval
from fairaudit.measures.ratios import Witness
from fairaudit.reports.content import describe
from fairaudit.reports.markdown import markdown
from fairaudit.reports.page import html
from fairaudit.tables.examples import example
from fairaudit.words import THE_INTERVAL, plain

pytest_plugins = ["pytester"]
EXAMPLE = ["certify", "--example", "ucb-admissions"]
MEN = "Over all contexts, Gender=Male is favoured over Gender=Female"


def admissions(**options: Any) -> fa.Result:
    entry = example("ucb-admissions")
    law = fa.Law.from_counts(entry.table(), decision="Admit", group="Gender", context="Dept", count="Freq")
    return fa.certify(law, {"Admitted": 1}, **options)


def asked(capsys: pytest.CaptureFixture[str], *words: str) -> str:
    """What a command prints."""
    assert command(list(words)) in (0, 1, 3)
    return capsys.readouterr().out


# One pair in every face


def test_all_faces_of_the_admissions_name_the_pair_that_exceeds(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """Over all departments men are favoured, and that exceeds; that women are favoured in department A decided nothing."""
    path = tmp_path / "certificate.json"
    said = asked(capsys, *EXAMPLE, "--max-global-ratio", "5/4", "-o", str(path), "--verbose")
    first, second, *drift, blank, sentence = said.split("\n")[:6]
    assert first.startswith("EXCEEDS ") and second.strip() == "Gender=Male over Gender=Female (n = 2,691 and 1,835)" and not blank
    assert drift[0].strip().startswith("valid unless an update changes")
    assert sentence.startswith(MEN) and "(n = 2,691 and 1,835)" in sentence and "Dept=A" not in sentence
    found = envelope(asked(capsys, *EXAMPLE, "--max-global-ratio", "5/4", "--format", "json"))
    assert found["sentence"] == sentence
    assert found["details"]["decided_by"] == [
        {
            "quantity": "global",
            "end": "lower",
            "value": load(path)[0]["intervals"]["global"]["ratio"][0],
            "by": "the interval",
            "pair": {"context": None, "higher": {"Gender": "Male"}, "lower": {"Gender": "Female"}},
            "decisions": ["2691", "1835"],
        }
    ]
    result, document = admissions(max_global_ratio="5/4"), load(path)[0]
    content = describe(document)
    assert result.sentence == content.sentence == sentence and content.deciding == result.deciding
    assert content.lead.startswith(f"{MEN}: “Admitted” in 44.52 % of decisions against 30.35 %")
    assert content.targets[0]["pair"] == "Gender=Male over Gender=Female (n = 2,691 and 1,835)"
    assert f'<p class="lead"><bdi>{MEN}' in html(document) and f"\n{MEN}" in markdown(document)
    assert ": <bdi>Gender=Male over Gender=Female (n = 2,691 and 1,835)</bdi></li>" in html(document)
    assert f"<bdi>{MEN}" in result._repr_html_()


def test_the_gate_fails_with_the_pair_that_exceeds(pytester: pytest.Pytester) -> None:
    pytester.makepyfile(
        """
        import fairaudit as fa
        from fairaudit.tables.examples import example
        def test_fair(fairness_gate):
            law = fa.Law.from_counts(
                example("ucb-admissions").table(), decision="Admit", group="Gender", context="Dept", count="Freq")
            fairness_gate(law, {"Admitted": 1}, max_global_ratio="5/4")
        """
    )
    found = pytester.runpytest_inprocess("-p", "no:cacheprovider")
    found.stdout.fnmatch_lines(["*EXCEEDS*global ratio*", "Admitted over all contexts: Gender=Male 44.5 %*, Gender=Female 30.4 %*"])
    found.stdout.no_fnmatch_line("*Dept=A*")


@pytest.mark.parametrize(
    ("targets", "opening"),
    [
        ({"max_local_ratio": 4}, "In Dept=F, Gender=Female over Gender=Male comes closest to the limit: at most 2.757 times as much"),
        ({"max_local_ratio": 2}, "In Dept=F, Gender=Female over Gender=Male leaves it open: up to 2.757 times as much"),
        (
            {"max_local_ratio": "1.02"},
            "In Dept=A, Gender=Female is favoured over Gender=Male: an expected utility of 0.8241 against 0.6206",
        ),
        ({"max_local_ratio": 2, "max_global_ratio": "5/4"}, MEN),
        ({"max_local_ratio": 4, "max_global_ratio": "3/2"}, "Over all contexts, Gender=Male over Gender=Female leaves it open"),
        ({"max_local_ratio": "5/4", "max_global_ratio": 2, "confidence": None}, "In Dept=A, Gender=Female is favoured over Gender=Male"),
        ({"max_local_ratio": 2, "max_global_ratio": "5/4", "confidence": None}, MEN),
        ({}, "In Dept=A, Gender=Female is favoured over Gender=Male"),
    ],
)
def test_the_sentence_is_about_what_decided(targets: dict[str, Any], opening: str) -> None:
    """The lower end comes from department A, the upper one from F, where few are admitted; exceeds goes before inconclusive."""
    result = admissions(**targets)
    assert result.sentence.startswith(opening)
    assert describe(result.certificate.document).sentence == result.sentence


def test_a_target_for_which_nothing_was_compared_keeps_the_sentence() -> None:
    """It makes the verdict inconclusive, whatever the other target says."""
    log = {"u": ["yes", "no", "yes", "yes"] * 20, "a": ["f"] * 40 + ["m"] * 40, "x": ["p"] * 40 + ["q"] * 40}
    law = fa.Law.from_log(log, decision="u", group="a", context="x")
    result = fa.certify(law, {"yes": 1}, max_local_ratio=2, max_global_ratio=5)
    assert [target.verdict for target in result.targets] == ["inconclusive", "within"]
    assert result.sentence.startswith("No context has two groups, so nobody is compared within a context; over all contexts, all compared")
    same_in_the_report(result)


def test_intervals_of_differences_drive_no_pair() -> None:
    """Given the true label there are intervals of differences beside those of the ratios."""
    log = {"a": list("ffmmx") * 12, "u": ["yes", "no", "no", "no", "yes", "yes"] * 10, "t": ["yes", "yes", "no", "yes", "no", "no"] * 10}
    result = fa.certify(fa.Law.from_log(log, decision="u", group="a", truth="t"), {"yes": 1}, max_local_ratio=2)
    assert "equalized_odds_true_label" in result.certificate.document["intervals"]
    same_in_the_report(result)
    assert "leaves it open" in markdown(result.certificate)


def test_a_theorem_that_decides_is_named() -> None:
    """Draws leave the ratio of a policy open; its filter and a declared floor bound it, for every pair."""
    rows = {"u": ["y", "n"] * 2, "a": ["f", "f", "m", "m"], "n": [3, 1, 2, 2]}
    policy = fa.Policy.from_counts(rows, decision="u", group="a", count="n")
    deployed = policy.behind(group=fa.RandomizedResponse("fm", keep_probability="0.6"), population=[[2, 3]])
    for limit, opening in (
        (2, "T1 bounds every pair of groups: at most 1.334 times as much."),
        ("1.3", "T1 gives the smallest upper end, for every pair of groups: 1.334 times as much."),
    ):
        result = fa.certify(deployed, {"y": 1}, max_local_ratio=limit, declared={"gamma": 1, "tau": "1/2"})
        few = "Only 4 decisions show what the policy does with a=f."
        assert result.sentence.startswith(f"{few} {opening}") and describe(result.certificate.document).sentence == result.sentence
        assert result.deciding == describe(result.certificate.document).deciding
        assert result.deciding[0] is not None and (result.deciding[0].by, result.deciding[0].pair) == ("T1", None)


def test_without_the_table_a_report_names_no_pair_of_an_interval(tmp_path: Path) -> None:
    """The labels of the pair are in the table."""
    result = admissions(max_global_ratio="5/4", embed_table=None)
    document = json.loads(result.certificate.text)
    document["subject"]["table"] = {key: document["subject"]["table"][key] for key in ("sha256", "cells")}
    content = describe(document)
    assert content.lead.startswith("At least 1.290 times as much in the population, at confidence 95 %, for a pair of groups that only the")
    assert content.lead.endswith(f"{MEN}: an expected utility of 0.4452 against 0.3035 in the table, 1.467 times as much.")


# The pair behind an end, by brute force


def greatest(top: Mapping[int, Fraction], bottom: Mapping[int, Fraction], ends: Any) -> Any:
    """The greatest quotient of two weighted sums over all corners of a box."""
    cells = sorted({*top, *bottom})
    corners = (dict(zip(cells, corner, strict=True)) for corner in product(*(ends[i] for i in cells)))
    return max(quotient(sum(w * at[i] for i, w in top.items()), sum(w * at[i] for i, w in bottom.items())) for at in corners)


def of_pairs(comparison: Comparison, ends: Any, *, upper: bool) -> dict[tuple[Any, ...], Any]:
    """The end of every pair, by its labels: the greatest quotient over the box, or the least."""
    found = {}
    for block, (context, groups) in zip(comparison.blocks, comparison.labels, strict=True):
        for i, j in permutations(range(len(block)), 2):
            one, other = dict(block[i]), dict(block[j])
            value = greatest(one, other, ends) if upper else greatest(other, one, ends)
            value = value if upper else (Fraction(0) if value == inf else 1 / value if value else inf)
            found[labels(Witness(context, groups[i], groups[j], (Fraction(0), Fraction(0))))] = value
    return found


def labels(pair: Witness | None) -> tuple[Any, ...]:
    assert pair is not None
    return tuple((pair.context or {}).values()), tuple(pair.higher.values()), tuple(pair.lower.values())


def check_box(comparison: Comparison, interval: Interval, drivers: Any) -> None:
    """Both pairs attain the ends that the interval has, and no other pair goes beyond."""
    for k, (side, end) in enumerate((("lower", interval.lower), ("upper", interval.upper))):
        ends = [(Fraction(a), Fraction(b)) for a, b in interval.evidence[side]]
        known = of_pairs(comparison, ends, upper=side == "upper")
        if end == 1:
            assert drivers[k] is None
        else:
            assert known[labels(drivers[k])] == end == max(known.values())
        if end == inf:
            points = [(cell.mean if cell.draws else cell.low,) for cell in comparison.cells]
            apart = of_pairs(comparison, points, upper=True)
            assert apart[labels(drivers[k])] == max(apart[place] for place, value in known.items() if value == inf)


def same_in_the_report(result: fa.Result) -> None:
    """What a report finds in the JSON is what the result has."""
    content = describe(json.loads(result.certificate.text))
    assert content.deciding == result.deciding
    assert content.drivers == result.drivers
    assert content.sentence == plain(result.sentence)
    for target, deciding in zip(result.targets, result.deciding, strict=True):
        if deciding is not None and target.confidence is not None and deciding.by == "the interval":
            assert deciding.pair == result.drivers.get(target.quantity, (None, None))[target.verdict != "exceeds"]
            ends = result.intervals.get(target.quantity)
            assert ends is None or deciding.value == (ends.lower if target.verdict == "exceeds" else ends.upper)


LIMITS = st.fixed_dictionaries(
    {}, optional={"max_local_ratio": st.sampled_from(["11/10", "3/2", 3, 20]), "max_global_ratio": st.sampled_from(["11/10", "3/2", 3, 20])}
)


@st.composite
def counted(draw: st.DrawFn, most: int = 60) -> fa.Law:
    x, a, u = draw(st.integers(1, 3)), draw(st.integers(2, 3)), draw(st.integers(2, 3))
    count = st.one_of(st.integers(0, 3), st.integers(0, most))
    array = [[[draw(count) for _ in range(u)] for _ in range(a)] for _ in range(x)]
    assume(any(sum(any(row) for row in context) > 1 for context in array))
    return fa.Law.from_array(array, kind="counts")


UTILITIES = st.sampled_from([("1",), ("1", "1/2"), ("0", "2", "1/3")])


@settings(max_examples=120, deadline=None)
@given(counted(), UTILITIES, LIMITS, st.booleans(), st.booleans())
def test_the_pair_behind_each_end_of_random_tables(law: fa.Law, values: Any, limits: dict[str, Any], burden: bool, judged: bool) -> None:
    """Any number of contexts and groups, empty cells and ties; the report reads the same out of the JSON."""
    utility = dict(zip(law.decisions, values, strict=False))
    result = fa.certify(law, utility, burden=burden, confidence=0.9 if judged else None, **limits)
    for quantity, interval in result.intervals.items():
        assert interval.region == "box"
        check_box(result.comparisons[quantity], interval, result.drivers[quantity])
    same_in_the_report(result)
    assert ("favoured" in result.sentence) <= (not burden) and ("disadvantaged" in result.sentence) <= burden


@settings(max_examples=40, deadline=None)
@given(counted(most=300), LIMITS)
def test_the_pair_behind_the_upper_end_of_the_product_region(law: fa.Law, limits: dict[str, Any]) -> None:
    """Each pair by itself, as if nothing else had been compared: none has a greater upper end than the one that is named."""
    result = fa.certify(law, {law.decisions[0]: 1, law.decisions[1]: "1/2"}, independent=True, interval="hoeffding-kl", **limits)
    same_in_the_report(result)
    for quantity, interval in result.intervals.items():
        comparison, (lower, upper) = result.comparisons[quantity], result.drivers[quantity]
        if interval.region != "product":
            check_box(comparison, interval, (lower, upper))
            continue
        assert (lower is None) is (interval.lower == 1)
        alone = dict(bounds_of_pairs(comparison, interval.evidence["levels"]["upper"]))
        assert alone[labels(upper)] >= max(alone.values()) * (1 - 1e-6)
        assert interval.upper == inf or alone[labels(upper)] <= float(interval.upper) * (1 + 1e-6)


def bounds_of_pairs(comparison: Comparison, levels: list[str]) -> Any:
    """The greatest quotient p/q of means whose tails exceed b, and whose product of tails exceeds c, for every pair: on a fine grid."""
    from fairaudit.inference.product_region import pair_reach  # of one pair at a time, without the pruning that is on trial

    guard, c = map(Fraction, levels)
    for block, (context, groups) in zip(comparison.blocks, comparison.labels, strict=True):
        for i, j in permutations(range(len(block)), 2):
            top, bottom = (comparison.cells[block[k][0][0]] for k in (i, j))
            yield labels(Witness(context, groups[i], groups[j], (Fraction(0), Fraction(0)))), float(pair_reach([top], [bottom], guard, c))


@settings(max_examples=40, deadline=None)
@given(st.data())
def test_the_pair_behind_each_end_with_units(data: st.DataObject) -> None:
    """A unit counts once in a cell, with the mean over its rows; the expectations of the pair are those means."""
    rows = st.tuples(st.sampled_from("fmx"), st.sampled_from(["yes", "no"]), st.integers(1, 6))
    drawn = data.draw(st.lists(rows, min_size=6, max_size=40))
    log = {"a": [row[0] for row in drawn], "u": [row[1] for row in drawn], "run": [row[2] for row in drawn]}
    assume(len({*log["a"]}) > 1)
    law = fa.Law.from_log(log, decision="u", group="a", unit="run")
    result = fa.certify(law, {"yes": 1}, max_local_ratio=data.draw(st.sampled_from(["11/10", 3, 30])))
    if result.intervals["local"].region == "box":
        check_box(result.comparisons["local"], result.intervals["local"], result.drivers["local"])
    same_in_the_report(result)
    deciding = result.deciding[0]
    if deciding is not None and deciding.pair is not None and law.units is not None and law.units.repeated:
        means = []
        for group in (deciding.pair.higher["a"], deciding.pair.lower["a"]):
            units: dict[int, list[int]] = {}
            for a, u, run in drawn:
                if a == group:
                    units.setdefault(run, []).append(u == "yes")
            means.append(sum(Fraction(sum(said), len(said)) for said in units.values()) / len(units))
        assert list(deciding.pair.expectations) == means
        assert "as mean over units" in result.sentence


@settings(max_examples=40, deadline=None)
@given(st.data())
def test_the_pair_behind_each_end_of_a_sampled_policy(data: st.DataObject) -> None:
    """Expected utilities behind filters mix the cells of the policy; corners of the box decide."""
    counts = [[[data.draw(st.integers(0, 40)), data.draw(st.integers(1, 40))] for _ in "fm"] for _ in range(data.draw(st.integers(1, 2)))]
    policy = fa.Policy(fa.Law.from_array(counts, kind="counts", decisions=["y", "n"], groups=["f", "m"]))
    keep = data.draw(st.sampled_from(["0.6", "0.9", "1"]))
    deployed = policy.behind(group=fa.RandomizedResponse("fm", keep_probability=keep), population=[[1, 2]] * len(counts))
    result = fa.certify(deployed, {"y": 1}, **data.draw(LIMITS))
    for quantity, interval in result.intervals.items():
        check_box(result.comparisons[quantity], interval, result.drivers[quantity])
    same_in_the_report(result)


@settings(max_examples=25, deadline=None)
@given(counted(), LIMITS, st.booleans())
def test_the_pair_behind_each_end_of_a_stream(law: fa.Law, limits: dict[str, Any], joint: bool) -> None:
    """Bounds that hold at every moment: boxes for units, products of wealth otherwise."""
    order = tuple((law.contexts[x], law.groups[a]) for x, a in zip(law.cell_context.tolist(), law.cell_group.tolist(), strict=True))
    assume(joint or "max_global_ratio" not in limits or len(law.contexts) == 1)
    declared = {"gamma": 1, "m": 0}
    try:
        result = fa.certify(law, {law.decisions[0]: 1}, declared=declared, arrivals=Arrivals(order, joint=joint), **limits)
    except fa.InputError:
        assume(False)
    for quantity, interval in result.intervals.items():
        lower, upper = result.drivers[quantity]
        assert (lower is None) is (interval.lower == 1)
        assert upper is not None or interval.upper == 1
        if upper is not None and not joint:
            ends = iter([(Fraction(a), Fraction(b)) for a, b in interval.evidence["upper"]])
            cells = {place: next(ends) for place in compared(law, quantity)}
            context, high, low = labels(upper)
            assert quotient(cells[context, high][1], cells[context, low][0]) == interval.upper
            if lower is not None:
                context, high, low = labels(lower)
                assert cells[context, high][0] / cells[context, low][1] == interval.lower
    same_in_the_report(result)


def compared(law: fa.Law, quantity: str) -> Any:
    """Context and group of each cell that is compared, in order."""
    if quantity == "global":
        return [((), law.groups[a]) for a in law.global_groups]
    places = [(law.contexts[x], law.groups[a]) for x, a in zip(law.cell_context.tolist(), law.cell_group.tolist(), strict=True)]
    contexts = [context for context, _ in places]
    return [(context, group) for context, group in places if contexts.count(context) > 1]


def test_a_monitor_names_the_pair(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """The pair behind the lower end in the text, the alarm, the line of JSON, and the certificate of the state."""
    log = tmp_path / "log.jsonl"
    rows = [{"answer": "yes" if i % 10 < share else "no", "sex": sex} for i in range(400) for sex, share in (("f", 3), ("m", 8))]
    log.write_text("".join(json.dumps(row) + "\n" for row in rows))
    options = ["--decision", "answer", "--group", "sex", "--utility", "yes", "--max-local-ratio", "5/4"]
    said = asked(capsys, "monitor", str(log), *options, "--format", "text", "--burden", "--state", str(tmp_path / "state.db"))
    said = " ".join(said.split())  # lines are wrapped
    assert ": exceeds, sex=m over sex=f " in said
    assert re.search(r"ALARM: local ratio [^A]* exceeded after [^A]*, sex=m over sex=f ", said)
    entries = envelopes(asked(capsys, "monitor", str(log), *options, "--format", "json"))
    assert entries[-1]["result"]["targets"][0]["pair"] == {"context": {}, "higher": {"sex": "m"}, "lower": {"sex": "f"}}
    said = asked(capsys, "certify", "--from-monitor", str(tmp_path / "state.db"), "--verbose")
    assert "sex=m is disadvantaged compared with sex=f: an expected burden of 0.8 against 0.3 in the table" in said


def test_a_monitor_state_of_before_keeps_its_digest() -> None:
    """A benefit is not written down, so that states of before are known again."""
    from fairaudit.streams.settings import Settings

    benefit = Settings(group=("sex",), decision="answer", utility={"yes": "1"})
    burden = Settings(group=("sex",), decision="answer", utility={"yes": "1"}, burden=True)
    assert "burden" not in benefit.text and Settings.from_text(burden.text) == burden and burden.digest != benefit.digest


# Burdens


def test_a_burden_is_said_in_every_face(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = tmp_path / "certificate.json"
    judged = ["--utility", "Rejected", "--burden", "--max-local-ratio", "5/4", "--confidence", "none"]
    said = asked(capsys, *EXAMPLE, *judged, "-o", str(path), "--verbose")
    assert "In Dept=A, Gender=Male is disadvantaged compared with Gender=Female: an expected burden of 0.3794 against 0.1759" in said
    assert "favoured" not in said and "--burden" not in said and "Burden: from 0 to 1" in said
    document = load(path)[0]
    assert document["subject"]["utility"]["burden"] is True
    assert command(["verify", str(path)]) == 0
    capsys.readouterr()
    for face in (html(document), markdown(document)):
        assert "Gender=Male is disadvantaged compared with Gender=Female" in face and "bears" in face
        assert "favoured" not in face and "xpected utility" not in face.partition("<script")[0]
    found = envelope(asked(capsys, *EXAMPLE, "--utility", "Rejected", "--burden", "--format", "json"))
    assert "disadvantaged" in found["sentence"] and found["result"]["subject"]["utility"]["burden"] is True
    assert "disadvantaged" in admissions(burden=True)._repr_html_()
    other = tmp_path / "other.json"
    admissions(max_local_ratio=2, confidence=None).certificate.save(other)
    assert command(["compare", str(other), str(path)]) in (0, 1, 2)
    capsys.readouterr()
    admissions(max_local_ratio=2, confidence=None, burden=True).certificate.save(path)
    found = asked(capsys, "compare", str(other), str(path))
    assert "in the new certificate the utility counts a burden, in the old one a benefit" in found


def test_a_benefit_is_not_written_down_and_has_a_hint(capsys: pytest.CaptureFixture[str]) -> None:
    """Certificates of benefits keep their bytes."""
    assert "burden" not in admissions().certificate.document["subject"]["utility"]
    assert "if it counts a burden, say so with --burden" in asked(capsys, *EXAMPLE, "--verbose")
    assert "--burden" in asked(capsys, *EXAMPLE) and "--burden" not in asked(capsys, *EXAMPLE, "--burden")


@pytest.mark.parametrize("stated", [False, "true", 1, None])
def test_only_true_states_a_burden(stated: Any) -> None:
    document = json.loads(admissions(confidence=None, burden=True).certificate.text)
    assert all(finding.true for finding in checker.check(json.dumps(document).encode()).findings)
    document["subject"]["utility"]["burden"] = stated
    with pytest.raises(checker.FormatError, match=r"subject\.utility\.burden must be true where it is stated"):
        checker.check(json.dumps(document).encode())


def test_an_audit_file_states_a_burden(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (tmp_path / "log.csv").write_text("fined,sex\n" + "yes,f\nno,f\nno,m\nyes,f\nno,m\nyes,m\n" * 5)
    audit = '[law]\ntable = "log.csv"\ndecision = "fined"\ngroup = "sex"\n[utility]\nvalues = { yes = 1 }\nburden = '
    (tmp_path / "audit.toml").write_text(audit + "true\n")
    assert "sex=f is disadvantaged compared with sex=m" in asked(capsys, "certify", str(tmp_path / "audit.toml"), "--verbose")
    (tmp_path / "audit.toml").write_text(audit + '"yes"\n')
    assert command(["certify", str(tmp_path / "audit.toml")]) == 2
    assert "[utility] burden is 'yes'; true or false is accepted" in capsys.readouterr().err


# Few decisions, and identifiers


def few() -> fa.Law:
    return fa.Law.from_array([[[3, 0], [30, 70]], [[20, 80], [25, 75]]], kind="counts", decisions=["yes", "no"], groups=["f", "m"])


def test_a_headline_from_few_decisions_says_so_first(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    result = fa.certify(few(), {"yes": 1}, confidence=None)
    first = "Only 3 decisions stand behind group=f in context=0."
    assert result.sentence.startswith(f"{first} In context=0, group=f is favoured over group=m")
    content = describe(result.certificate.document)
    assert content.sentence == result.sentence and content.lead.startswith(first)
    for face in (html(result.certificate), markdown(result.certificate), result._repr_html_()):
        assert first in face.replace("&#61;", "=")
    (tmp_path / "log.csv").write_text("u,a\n" + "yes,f\n" * 9 + "yes,m\nno,m\n" * 6)
    options = ["--decision", "u", "--group", "a", "--utility", "yes", "--confidence", "none"]
    assert "\nOnly 9 decisions stand behind a=f.\nu=yes: a=f 100 % (9 of 9), " in asked(
        capsys, "certify", str(tmp_path / "log.csv"), *options
    )
    said = asked(capsys, "certify", str(tmp_path / "log.csv"), *options, "--verbose")
    assert said.split("\n\n")[1].startswith("Only 9 decisions stand behind a=f. a=f is favoured over a=m")
    (tmp_path / "log.csv").write_text("u,a\n" + "yes,f\n" * 10 + "yes,m\nno,m\n" * 6)
    said = asked(capsys, "certify", str(tmp_path / "log.csv"), *options, "--verbose")
    assert said.split("\n\n")[1].startswith("a=f is favoured over a=m") and "(n = 10 and 12)" in said


def test_a_column_that_is_an_identifier_is_named_first() -> None:
    rows = {"u": ["yes", "no"] * 40, "a": [f"person {i // 2}" if i < 40 else f"person {i}" for i in range(80)], "x": ["p", "q"] * 40}
    result = fa.certify(fa.Law.from_log(rows, decision="u", group="a", context="x"), {"yes": 1}, confidence=None)
    first = "The column 'a' has 60 labels in 80 decisions, like an identifier. Only 2 decisions stand behind a=person 0"
    assert result.sentence.startswith(first) and describe(result.certificate.document).sentence.startswith(first)
    rows["a"] = ["f", "m", "m", "f"] * 20
    assert "identifier" not in fa.certify(fa.Law.from_log(rows, decision="u", group="a", context="x"), {"yes": 1}).sentence


def test_sizes_stand_beside_every_pair_of_counts(capsys: pytest.CaptureFixture[str]) -> None:
    """Of units also how many there are; sums of weights are rounded down to one decimal; probabilities have none."""
    said = asked(capsys, *EXAMPLE, "--verbose")
    assert "1.328  Dept=A: Gender=Female 0.8241, Gender=Male 0.6206 (n = 108 and 825)" in said
    assert "1.467  Gender=Male 0.4452, Gender=Female 0.3035 (n = 2,691 and 1,835)" in said
    weighted = fa.Law.from_counts(
        {"u": ["y", "n"] * 2, "a": ["f", "f", "m", "m"], "n": ["9.5", "0.49", "1000.25", "3000"]}, decision="u", group="a", count="n"
    )
    sentence = fa.certify(weighted, {"y": 1}, confidence=None).sentence
    assert sentence.startswith("Only 9.99 decisions stand behind a=f.") and "(n = 9.99 and 4,000.2)" in sentence
    log = {"a": ["f"] * 30 + ["m"] * 24, "u": ["yes", "no"] * 27, "run": [i // 2 for i in range(54)]}
    log["u"][:10] = ["yes"] * 10
    units = fa.certify(fa.Law.from_log(log, decision="u", group="a", unit="run"), {"yes": 1}).sentence
    assert "(n = 15 and 12 units, 30 and 24 decisions)" in units and not units.startswith("Only")
    given = fa.Law.from_array([[["0.5", "0.5"], ["0.2", "0.8"]]], kind="probabilities")
    assert "n =" not in fa.certify(given, {given.decisions[0]: 1}).sentence


def test_sizes_of_contexts_that_were_read_in_parts(tmp_path: Path) -> None:
    duckdb = pytest.importorskip("duckdb")
    path = tmp_path / "log.parquet"
    rows = ", ".join(f"('{x}', '{a}', '{u}')" for x in "pq" for a, shares in (("f", 12), ("m", 30)) for u in ["yes"] * shares + ["no"] * 10)
    duckdb.execute(f"copy (from (values {rows}) log(x, a, u)) to '{path}' (format parquet)")
    from fairaudit.audits.in_parts import certify_in_parts

    result = certify_in_parts(path, {"yes": 1}, decision="u", group="a", context="x", max_local_ratio="5/4")
    assert (
        result.sentence
        == "In x=p, a=m is favoured over a=f: an expected utility of 0.75 against 0.5455, 1.375 times as much (n = 40 and 22)."
    )


def test_where_the_ends_cross_the_sentence_says_so() -> None:
    """A lower end above the limit beside an upper one within it decides nothing; where both are above the limit they do."""
    result = admissions(max_local_ratio="5/4")
    crossed = fa.Target("local", Fraction(5, 4), "ratio", "inconclusive", Fraction(19, 20), (Fraction(6, 5), THE_INTERVAL))
    deciding = decide(crossed, result.local, Fraction(4, 3), (None, None))
    assert deciding is not None and (deciding.by, deciding.value, deciding.pair) == ("the ends cross", Fraction(6, 5), None)
    assert sentence(deciding, result.local, None).startswith("The ends cross: the lower one is above the limit")
    for lower, upper in ((Fraction(6, 5), Fraction(3, 2)), (Fraction(1), Fraction(4, 3))):
        deciding = decide(replace(crossed, upper=(upper, THE_INTERVAL)), result.local, lower, (None, None))
        assert deciding is not None and deciding.by == THE_INTERVAL
