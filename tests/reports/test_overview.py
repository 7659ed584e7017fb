"""The numbers of an overview are those of the table, counted again here; screen and page say the same; words mean what they say."""

from __future__ import annotations

import dataclasses
import json
import random
from collections.abc import Callable
from fractions import Fraction
from math import comb, inf
from typing import Any

import certificates
import pytest
from certificate_kinds import FOUR, KINDS
from hypothesis import given, settings
from hypothesis import strategies as st

import fairaudit as fa
from fairaudit.certificates.certificate import Certificate
from fairaudit.errors import InputError
from fairaudit.measures.differences import furthest_contexts
from fairaudit.measures.ratios import most_unequal_contexts
from fairaudit.model.utility import Utility
from fairaudit.reports.assumed import SHORT, in_short
from fairaudit.reports.content import describe
from fairaudit.reports.overview import Overview, of_content, of_result
from fairaudit.reports.overview_parts import Gets, rate_text
from fairaudit.reports.overview_verdict import figure
from fairaudit.reports.words import Value
from fairaudit.tables.examples import example
from fairaudit.theorems.assumptions import DRAWS, SENTENCES

Counts = dict[tuple[int, int, int], int]
"""How many decisions by context, group and whether they count."""

ADMISSIONS = {"decision": "Admit", "group": "Gender", "context": "Dept", "count": "Freq", "utility": "Admitted"}


def admissions(**options: Any) -> fa.Result:
    return fa.audit(example("ucb-admissions").path, **{**ADMISSIONS, **options})


def audited(counts: Counts, **options: Any) -> fa.Result:
    rows = [("hired" if good else "refused", f"g{a}", f"x{x}", n) for (x, a, good), n in counts.items()]
    u, a, x, n = zip(*rows, strict=True)
    table = {"outcome": u, "sex": a, "dept": x, "n": n}
    return fa.audit(table, decision="outcome", group="sex", context="dept", count="n", utility="hired", **options)


def test_the_admissions_are_said_by_department_and_over_all() -> None:
    found = of_result(admissions())
    assert found.audited == "4,526 decisions, 2 groups (Gender), 6 contexts (Dept)"
    within, overall = found.sentences
    assert within.startswith("Admitted within Dept=A: Gender=Female 82.4 % (89 of 108), Gender=Male 62.1 % (512 of 825), 1.33 times; ")
    assert overall.startswith(
        "Admitted over all contexts: Gender=Male 44.5 % (1,198 of 2,691), Gender=Female 30.4 % (557 of 1,835), 1.47 times; "
    )
    assert " is between " in within and within.endswith(", at 95 %.")
    assert found.chance == (("yes", "groups differ within a context and over all contexts, each at 95 %"),)
    assert [line.gets.short for line in found.groups] == ["Female", "Male"]
    assert [(line.least.value, line.greatest.value) for line in found.groups][1] == (1, 1)
    assert found.groups[0].greatest.value == Fraction(1198, 2691) / Fraction(557, 1835)
    assert [pair.where for pair in found.contexts] == ["A", "F", "E", "C", "B", "D"]


def test_a_target_is_answered_with_the_end_that_decided_it() -> None:
    exceeded = of_result(admissions(max_global_ratio="0.8"))
    assert exceeded.chance == (("yes", "the population exceeds the limit, at 95 %"),)
    assert "in the population the ratio is at least 1.290, at 95 %" in exceeded.sentences[0]
    kept = of_result(admissions(max_global_ratio=2))
    assert kept.chance == (("no", "within the limit is established, at 95 %"),) and "the ratio is at most 1.6" in kept.sentences[0]
    open_ = of_result(admissions(max_local_ratio="0.8"))
    assert open_.chance[0][0] == "too few decisions" and "more decisions would show that the limit is exceeded" in open_.chance[0][1]
    assert "the greatest ratio is at least 1.044, at most 2.757, each at 95 %" in open_.sentences[0]
    assert of_result(admissions(max_local_ratio="0.8", confidence=None)).chance[0][0] == "not asked"
    hidden = of_result(admissions(max_global_ratio="1.1", hidden_context="2,3"))
    assert hidden.chance[0][0] == "it depends" and "unrecorded factor" in hidden.chance[0][1]
    drifting = of_result(admissions(max_global_ratio="0.8", max_drift="0.05"))
    assert drifting.chance[0][0] == "it depends" and "declared drift" in drifting.chance[0][1]
    apart = of_result(admissions(max_difference="0.3", confidence=None))
    assert apart.sentences[0].endswith(f"{float(Fraction(89, 108) - Fraction(512, 825)):.4f} apart.")


def test_nothing_is_said_of_chance_where_nothing_was_drawn() -> None:
    table = {"u": ["hired", "refused"] * 2, "a": ["f", "f", "m", "m"], "p": ["0.25", "0.75", "0.5", "0.5"]}
    found = of_result(fa.audit(table, decision="u", group="a", probability="p", utility="hired", max_local_ratio="0.8"))
    assert found.chance == (("not a question", "the probabilities are taken as given, the figures are exact"),)
    assert found.sentences == ("hired: a=m 50.0 %, a=f 25.0 %, 2 times.",)
    assert found.audited == "probabilities of decisions, 2 groups (a), no contexts"


def test_a_policy_that_was_seen_in_decisions_is_no_exact_one() -> None:
    table = {"u": ["hired", "refused"] * 2, "a": ["f", "f", "m", "m"], "n": [30, 10, 20, 20]}
    policy = fa.Policy.from_counts(table, decision="u", group="a", count="n")
    found = of_result(
        fa.certify(policy.behind(group=fa.RandomizedResponse(["f", "m"], keep_probability="0.9")), {"hired": 1}, confidence=None)
    )
    assert found.chance[0][0] == "not asked" and found.assumptions[-1] == "the table is genuine and complete"
    assert found.audited.startswith("a policy behind privacy filters, seen in 80 decisions, 2 groups (a)")


def test_what_is_open_needs_more_decisions() -> None:
    table = {"u": ["y", "y"], "a": ["f", "m"], "n": [5, 9]}
    found = of_result(fa.audit(table, decision="u", group="a", count="n", utility="y", max_local_ratio=2))
    assert found.targets[0][0] == "inconclusive" and 2 * 0.025 ** (1 / 5) < 1 < 2 * 0.025 ** (1 / 6)
    ((answer, why),) = found.chance
    assert answer == "too few decisions" and why.startswith("an estimate: 2 more decisions would show that the limit is kept")


def test_small_sums_of_weights_are_not_rounded_to_nothing() -> None:
    table = {"u": list("ynyn"), "a": list("ffmm"), "n": ["0.04", "0.01", "0.02", "2.23"]}
    found = of_result(fa.audit(table, decision="u", group="a", count="n", utility="y", confidence=None))
    assert found.audited.startswith("2.3 decisions, ")
    assert {line.gets.short: line.gets.of for line in found.groups} == {"f": "0.04 of 0.05", "m": "0.02 of 2.25"}


def test_a_confidence_is_never_said_to_be_certainty() -> None:
    found = of_result(admissions(confidence=1 - Fraction(1, 10**8)))
    assert found.sure == "99.9999 %" and "100 %" not in " ".join((*found.sentences, *(why for _, why in found.chance)))


def test_groups_that_are_alike_are_said_to_be_alike() -> None:
    same = of_result(audited({(0, 0, 1): 2, (0, 0, 0): 2, (0, 1, 1): 4, (0, 1, 0): 4}, confidence=None))
    assert same.sentences[0] == "hired: the same in all groups that are compared in every context."


def test_a_burden_has_its_worst_group_first_and_utilities_below_zero_have_differences() -> None:
    assert [line.gets.short for line in of_result(admissions(burden=True)).groups] == ["Male", "Female"]
    signed = of_result(admissions(utility={"Admitted": 1, "Rejected": -1}, difference=True))
    assert signed.signed and not signed.rates and signed.amount == "Expected utility"
    assert signed.groups[0].least.value == 2 * (Fraction(1198, 2691) - Fraction(557, 1835))
    assert signed.sentences[0].startswith("Expected utility within Dept=A: Gender=Female 0.6481 (n = 108), Gender=Male 0.2412 (n = 825), ")


@st.composite
def tables(draw: Any) -> Counts:
    contexts, groups = draw(st.integers(1, 5)), draw(st.integers(2, 5))
    cells = [(x, a) for x in range(contexts) for a in range(groups)]
    amounts = st.one_of(st.integers(0, 4), st.integers(0, 3000))
    counts = {(x, a, good): draw(amounts) for x, a in cells for good in (0, 1)}
    return {**counts, (0, 0, 1): counts[0, 0, 1] + 1, (0, 1, 0): counts[0, 1, 0] + 1}


@given(tables())
@settings(max_examples=60, deadline=None)
def test_every_number_is_that_of_the_table(counts: Counts) -> None:
    result = audited(counts)
    found = of_result(result, groups=99, contexts=99)
    totals: dict[str, list[int]] = {}
    cells: dict[str, dict[str, list[int]]] = {}
    for (x, a, good), n in counts.items():
        if n:
            for own in (totals.setdefault(f"g{a}", [0, 0]), cells.setdefault(f"x{x}", {}).setdefault(f"g{a}", [0, 0])):
                own[0] += n * good
                own[1] += n
    rates = {a: Fraction(*pair) for a, pair in totals.items()}
    assert [line.gets.mean.value for line in found.groups] == sorted(rates.values()) and found.more_groups == 0
    best = max(rates.values())
    for line in found.groups:
        assert_counted(line.gets, totals)
        rate = rates[line.gets.short]
        assert (line.least.value, line.greatest.value) == ((rate / best, best / rate if rate else inf) if best else (1, 1))
        if line.ends is not None:
            assert_surely(totals[line.gets.short], [Fraction(end.value) for end in line.ends])
    apart = {x: ratio([Fraction(*pair) for pair in own.values()]) for x, own in cells.items() if len(own) > 1}
    unequal = sorted((value for value in apart.values() if value != 1), reverse=True)
    if len({x for x, _, _ in counts if x is not None}) > 1 and len(cells) > 1:
        assert [pair.apart.value for pair in found.contexts] == unequal
        assert found.more_contexts == len(apart) - len(unequal)
        for pair in found.contexts:
            assert apart[pair.where] == pair.apart.value
            assert_counted(pair.higher, cells[pair.where])
            assert_counted(pair.lower, cells[pair.where])


def assert_counted(gets: Gets, pairs: dict[str, list[int]]) -> None:
    good, of = pairs[gets.short]
    assert gets.mean.value == Fraction(good, of) and gets.of == f"{good:,} of {of:,}"


def assert_surely(pair: list[int], ends: list[Fraction]) -> None:
    """Both tails at the ends are at most half the error: exact for few draws."""
    good, of = pair
    assert ends[0] <= Fraction(good, of) <= ends[1]
    if of <= 60:
        above = sum(comb(of, k) * ends[0] ** k * (1 - ends[0]) ** (of - k) for k in range(good, of + 1))
        below = sum(comb(of, k) * ends[1] ** k * (1 - ends[1]) ** (of - k) for k in range(good + 1))
        assert (ends[0] == 0 or above <= Fraction(1, 40)) and (ends[1] == 1 or below <= Fraction(1, 40))


def ratio(rates: list[Fraction]) -> Any:
    low, high = min(rates), max(rates)
    return high / low if low else inf if high else Fraction(1)


@pytest.mark.parametrize("made", KINDS)
@pytest.mark.parametrize("options", [{}, {"confidence": None}, FOUR])
def test_a_result_and_its_certificate_say_the_same(made: Callable[..., fa.Result], options: dict[str, Any]) -> None:
    try:
        result = made(**options)
    except InputError:
        pytest.skip("this kind has no such targets")
    assert_alike(of_result(result), result.certificate)


def assert_alike(own: Overview, certificate: Certificate) -> None:
    told = of_content(describe(json.loads(certificate.text)))
    assert told is not None
    for entry in dataclasses.fields(own):
        if entry.name != "chance":  # how many more would do is computed by those who have the draws
            assert getattr(told, entry.name) == getattr(own, entry.name), entry.name
    assert [answer for answer, _ in told.chance] == [answer for answer, _ in own.chance]


@pytest.mark.parametrize("kind", certificates.KINDS)
def test_every_certificate_comes_to_something(kind: Callable[[random.Random], Certificate]) -> None:
    document = json.loads(kind(random.Random(3)).text)
    found = of_content(describe(document))
    assert found is None or (found.sentences and found.chance and found.audited)


def test_a_certificate_without_its_table_has_no_overview() -> None:
    assert of_content(describe(json.loads(admissions(embed_table=False).certificate.text))) is None


def test_the_most_unequal_contexts_are_found_among_many_that_are_alike() -> None:
    rows = [[[5, 5], [5, 5]]] * 40 + [[[5, 5], [4, 6]], [[0, 3], [1, 2]], [[5, 5], [4, 6]], [[0, 2], [2, 1]]]
    law = fa.Law.from_array(rows, kind="counts", decisions=["yes", "no"])
    utility = Utility({"yes": 1}).on(law)
    unequal = [(entry.ratio, (entry.witness.context or {})["context"]) for entry in most_unequal_contexts(law, utility, 3)]
    assert unequal == [(inf, "41"), (inf, "43"), (Fraction(5, 4), "40")]
    apart = [(entry.value, (entry.witness.context or {})["context"]) for entry in furthest_contexts(law, utility, 3)]
    assert apart == [(Fraction(2, 3), "43"), (Fraction(1, 3), "41"), (Fraction(1, 10), "40")]


def test_rates_round_to_three_digits_and_never_to_certainty() -> None:
    assert [rate_text(Value(Fraction(rate))) for rate in ("0", "1", "0.9999", "0.059", "0.00012345")] == [
        "0 %",
        "100 %",
        "99.99 %",
        "5.90 %",
        "0.0123 %",
    ]
    ends = [rate_text(Value(Fraction(2, 3), "down")), rate_text(Value(Fraction(2, 3), "up")), rate_text(Value(Fraction(9999, 10000), "up"))]
    assert ends == ["66.6 %", "66.7 %", "100 %"]
    assert rate_text(Value(1 - Fraction(1, 10**30))) == "99.9999999999 %"


def test_figures_of_many_digits_are_whole() -> None:
    assert [figure(Fraction(text), "up") for text in ("1.23451", "12345.1", "1e20")] == ["1.235", "12,346", "1.000e+20"]
    assert figure(Fraction(9999), "nearest", 3) == "9,999" and figure(inf) == "infinite"


def test_every_assumption_has_one_line() -> None:
    assert set(SHORT) == set(SENTENCES) and max(map(len, SHORT.values())) <= 76
    assert in_short([DRAWS, DRAWS]) == ("the decisions on a group in a context were drawn independently",)
    assert in_short([SENTENCES["range"].format(low="-1", high="3/2")]) == ("whatever could have been drawn has a utility from -1 to 3/2",)
    assert in_short(["something that nobody knows"]) == ("something that nobody knows",)


def test_pairs_with_long_names_of_columns_are_said_by_their_labels() -> None:
    table = {
        "Entscheidung": ["bewilligt", "abgelehnt"] * 2,
        "Antragsteller Geschlecht": ["weiblich", "weiblich", "männlich", "männlich"],
        "Staatsangehörigkeit": ["türkisch", "türkisch", "deutsch", "deutsch"],
        "n": [10, 30, 30, 10],
    }
    group = ["Antragsteller Geschlecht", "Staatsangehörigkeit"]
    said = of_result(fa.audit(table, decision="Entscheidung", group=group, count="n", utility="bewilligt", confidence=None)).sentences
    assert any("männlich / deutsch 75.0 % (30 of 40), weiblich / türkisch 25.0 % (10 of 40)" in str(text) for text in said), said


def test_one_context_is_not_said_twice() -> None:
    """Within the only context and over all is one question, unless the two have other answers: then both are said."""
    one: Counts = {(0, 0, True): 30, (0, 0, False): 10, (0, 1, True): 20, (0, 1, False): 20}
    for options in ({}, {"confidence": None}, {"difference": True}):
        found = of_result(audited(one, **options))
        assert len(found.sentences) == 1 + ("difference" in options) and len(found.chance) == 1
        assert not any("over all" in text or "within a context" in text for text in (*found.sentences, *found.chance[0]))
    two = of_result(audited({**one, (1, 0, True): 20, (1, 0, False): 20, (1, 1, True): 20, (1, 1, False): 20}))
    assert len(two.sentences) == 2 and "over all contexts" in two.sentences[1]
    log = {"u": ["yes", "no"] * 30, "g": ["f", "f", "f", "m"] * 15, "x": ["x"] * 60, "id": [i // 4 for i in range(60)]}
    units = of_result(fa.audit(log, decision="u", group="g", context="x", unit="id", utility="yes", missing_units="drop"))
    assert len(units.sentences) == 2  # a mean over units within the context, and one over rows
