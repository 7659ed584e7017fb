"""Equalized odds by both of its meanings: the paper's, within contexts, and the usual one, given the true label."""

from __future__ import annotations

import json
import os
import random
import re
import time
from collections.abc import Iterator, Sequence
from fractions import Fraction
from itertools import product
from math import comb, prod
from pathlib import Path
from typing import Any

import pytest
from envelopes import envelope
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from jsonschema import Draft202012Validator

import fairaudit as fa
from fairaudit import checker
from fairaudit.certificates.certificate import Certificate, schema
from fairaudit.certificates.table import Table
from fairaudit.cli import main
from fairaudit.inference.differences import difference_of_rates
from fairaudit.reports.markdown import markdown
from fairaudit.reports.page import html

SCHEMA = Draft202012Validator(schema())

NAME = "parity within contexts (the paper's equalized odds)"
LOG = {"hired": ["yes", "no", "yes", "yes", "no", "no"], "sex": list("ffmmfm"), "dept": list("ABABAB")}


@pytest.mark.parametrize("context", ["dept", None])
def test_the_papers_quantity_has_its_own_name_and_stands_only_beside_contexts(
    context: str | None, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    result = fa.certify(fa.Law.from_log(LOG, decision="hired", group="sex", context=context), {"yes": 1}, confidence=None)
    table = tmp_path / "log.csv"
    table.write_text("\n".join(",".join(row) for row in [tuple(LOG), *zip(*LOG.values(), strict=True)]) + "\n")
    saved = tmp_path / "certificate.json"
    options = ["--decision", "hired", "--group", "sex", *(["--context", context] if context else []), "--utility", "yes", "-o", str(saved)]
    assert main(["certify", str(table), *options, "--verbose"]) == 0
    text = capsys.readouterr().out
    assert main(["compare", str(saved), str(saved)]) == 0
    compared = capsys.readouterr().out
    document = json.loads(saved.read_text())
    (figures,) = [part for part in markdown(document).split("###") if part.startswith(" The figures")]
    page = " ".join(re.findall(r"<h3>.*?</h3>", html(document).replace("&#39;", "'")))
    for shown in (text, compared, result._repr_html_(), figures, page):
        assert shown.casefold().count(NAME) == (1 if context else 0)
        assert "equalized odds" not in shown.casefold().replace(NAME, "")
    assert "equalized_odds" in document["metrics"]


# Given the true label: exactly


ROWS = st.lists(
    st.tuples(st.sampled_from("yno"), st.sampled_from("yn?"), st.sampled_from("fmx"), st.sampled_from("AB")), min_size=2, max_size=40
)


def brute(rows: list[tuple[str, str, str, str]], *, overall: bool) -> dict[str, Any]:
    """The definitions as plain loops: rates by context and group, and the greatest differences."""
    rates: dict[bool, dict[tuple[str, str], Fraction]] = {}
    for positive in (True, False):
        cells: dict[tuple[str, str], list[bool]] = {}
        for u, t, a, x in rows:
            if (t == "y") is positive:
                cells.setdefault(("" if overall else x, a), []).append(u == "y")
        rates[positive] = {cell: Fraction(sum(found), len(found)) for cell, found in cells.items()}
    widest = {
        positive: max((p - q for (x, a), p in own.items() for (y, b), q in own.items() if x == y and a != b), default=None)
        for positive, own in rates.items()
    }
    both = None if None in widest.values() else max(widest.values())  # type: ignore[type-var]
    return {"rates": rates, "equal_opportunity": widest[True], "equalized_odds_true_label": both}


def columns(rows: Sequence[tuple[str, ...]], names: str = "u t a x") -> dict[str, list[str]]:
    return {name: [row[i] for row in rows] for i, name in enumerate(names.split())}


def measured(rows: Sequence[tuple[str, ...]], *, context: str | None = "x", **options: Any) -> fa.Result:
    law = fa.Law.from_log(columns(rows), decision="u", group="a", context=context, truth="t")
    return fa.certify(law, {"y": 1}, positive="y", **options)


def usable(rows: Sequence[tuple[str, ...]]) -> bool:
    return len({row[2] for row in rows}) > 1 and any(row[1] == "y" for row in rows) and any(row[0] == "y" for row in rows)


def accepted(certificate: Certificate) -> None:
    lines = list(certificate.table.lines()) if isinstance(certificate.table, Table) else None
    assert [finding for finding in checker.check(certificate.text.encode(), lines).findings if not finding.true] == []
    assert [error.message for error in SCHEMA.iter_errors(json.loads(certificate.text))] == []


@given(rows=ROWS, embed=st.booleans(), confidence=st.sampled_from([None, "0.9"]))
def test_rates_and_differences_are_those_of_plain_loops(
    rows: list[tuple[str, str, str, str]], *, embed: bool, confidence: str | None
) -> None:
    assume(usable(rows))
    result = measured(rows, embed_table=embed, confidence=confidence)
    metrics = result.certificate.document["metrics"]
    for overall, suffix in ((False, ""), (True, "_overall")):
        expected = brute(rows, overall=overall)
        for name in ("equal_opportunity", "equalized_odds_true_label"):
            found, entry = result.given_truth.differences[name + suffix], metrics[name + suffix]
            assert (None if found is None else found.value) == expected[name]
            if found is None:
                assert entry is None
                continue
            own = expected["rates"][found.kind == "true_positive_rate"]
            where = "" if overall else found.context["x"]
            assert found.rates == (own[where, found.higher["a"]], own[where, found.lower["a"]]) and found.higher != found.lower
            assert Fraction(entry["value"]) == found.value == found.rates[0] - found.rates[1]
            assert ("context" in entry["witness"]) is not overall
        for positive, name in ((True, "true_positive_rate"), (False, "false_positive_rate")):
            listed = metrics[name + suffix]
            assert (listed is None) is not embed
            if listed:
                said = {(e.get("context", {"x": ""})["x"], e["group"]["a"]): Fraction(e["rate"]) for e in listed}
                assert said == expected["rates"][positive]
    assert bool(result.given_truth.intervals) is (embed and confidence is not None and any(result.given_truth.differences.values()))
    accepted(result.certificate)


@given(rows=ROWS)
@settings(max_examples=60)
def test_a_group_without_a_rate_is_named_and_not_compared(rows: list[tuple[str, str, str, str]]) -> None:
    """Whoever has decisions but no true positive stands in the list, and its absence makes no difference of 0."""
    assume(usable(rows))
    result = measured(rows, confidence=None)
    for positive, name in ((True, "true_positive_rate"), (False, "false_positive_rate")):
        known = {(row[3], row[2]) for row in rows if (row[1] == "y") is positive}
        lacking = {(row[3], row[2]) for row in rows} - known
        entries = [e for e in result.not_compared if e.get("quantity") == name and "groups" in e]
        assert {(e["context"]["x"], group["a"]) for e in entries for group in e["groups"]} == lacking
    for name, found in result.given_truth.differences.items():
        if found is None:
            assert name not in {claim.quantity for claim in result.claims}


@given(rows=ROWS)
@settings(max_examples=20)
def test_fairlearn_agrees_where_every_rate_exists(rows: list[tuple[str, str, str, str]]) -> None:
    from fairlearn.metrics import equal_opportunity_difference, equalized_odds_difference

    rows = [("y" if u == "y" else "n", "y" if t == "y" else "n", a, x) for u, t, a, x in rows]
    rows += [("y" if (t, a) == ("y", "f") else "n", t, a, x) for t, a, x in product("yn", "fmx", "AB")]  # no rate is missing
    differences = measured(rows, confidence=None).given_truth.differences
    for name, theirs in (("equal_opportunity", equal_opportunity_difference), ("equalized_odds_true_label", equalized_odds_difference)):
        each = []
        for level in {row[3] for row in rows}:
            for kept in ([row for row in rows if row[3] == level], rows):
                u, t, a = ([row[i] for row in kept] for i in range(3))
                each.append(theirs([v == "y" for v in t], [v == "y" for v in u], sensitive_features=a))
        assert float(differences[name].value) == pytest.approx(max(each[::2]), abs=1e-12)
        assert float(differences[f"{name}_overall"].value) == pytest.approx(each[1], abs=1e-12)


def test_questions_with_known_answers(data: Path) -> None:
    """Whether a model says that it cannot know, given whether it could: BBQ, by the group that the question is about."""
    from fairlearn.metrics import equal_opportunity_difference, equalized_odds_difference

    rows = []
    for line in (data / "bbq" / "preds_Sexual_orientation.jsonl").read_text().splitlines():
        entry = json.loads(line)
        kinds = [entry["answer_info"][f"ans{i}"][1] == "unknown" for i in range(3)]
        said = entry[next(key for key in entry if key.endswith("_pred_race"))].strip().lower()
        chosen = next((i for i in range(3) if entry[f"ans{i}"].strip().lower() == said), None)
        if chosen is not None:
            group = entry["additional_metadata"]["stereotyped_groups"][0]
            rows.append(("y" if kinds[chosen] else "n", "y" if kinds[entry["label"]] else "n", group, entry["question_polarity"]))
    assert len(rows) > 500
    result = measured(rows)
    u, t, a = ([row[i] if i == 2 else row[i] == "y" for row in rows] for i in range(3))
    found = result.given_truth.differences
    assert float(found["equal_opportunity_overall"].value) == pytest.approx(equal_opportunity_difference(t, u, sensitive_features=a))
    assert float(found["equalized_odds_true_label_overall"].value) == pytest.approx(equalized_odds_difference(t, u, sensitive_features=a))
    for name, interval in result.given_truth.intervals.items():
        assert interval.lower <= found[name].value <= interval.upper
    accepted(result.certificate)


def test_counts_and_their_log_say_the_same() -> None:
    rows = [("y", "y", "f", "A")] * 3 + [("n", "y", "f", "A")] * 2 + [("y", "n", "m", "A"), ("y", "y", "m", "A"), ("n", "n", "f", "A")]
    counted = [(*row, str(rows.count(row))) for row in dict.fromkeys(sorted(rows))]
    law = fa.Law.from_counts(columns(counted, "u t a x n"), decision="u", group="a", context="x", count="n", truth="t")
    assert law.truth.weights.sum(axis=1).tolist() == law.weights.tolist()
    counts, log = fa.certify(law, {"y": 1}), measured(rows)
    assert {k: d and d.value for k, d in counts.given_truth.differences.items()} == {
        k: d and d.value for k, d in log.given_truth.differences.items()
    }
    halves = fa.Law.from_counts(
        columns([(*row[:-1], f"{row[-1]}/2") for row in counted], "u t a x n"), decision="u", group="a", context="x", count="n", truth="t"
    )
    half = fa.certify(halves, {"y": 1}, confidence="0.9")
    assert half.certificate.document["metrics"] == counts.certificate.document["metrics"] and not half.given_truth.intervals
    assert any("rates given the true label" in note for note in half.notes)
    accepted(half.certificate)


# What is positive


TRUTHS = [("hire", "fit", "f"), ("call", "fit", "m"), ("no", "unfit", "f"), ("hire", "unfit", "m")]


@pytest.mark.parametrize(
    ("utility", "positive", "expected"),
    [
        ({"hire": 1}, "fit", (("hire",), "fit")),
        ({"hire": "1/2", "call": "1/2"}, "unfit", (("call", "hire"), "unfit")),
        ({"hire": 1}, None, "no true label is a positive decision ('hire'); give the positive one (positive, --positive)"),
        ({"hire": 1}, "Fit", "the positive label 'Fit' is no true label of column 't'; known: 'fit', 'unfit'; did you mean 'fit'?"),
        ({"hire": 1, "call": 2}, "fit", "the utility does not say which decisions are positive"),
        ({"hire": 0}, "fit", "the utility does not say which decisions are positive"),
    ],
)
def test_what_is_positive(utility: dict[str, Any], positive: str | None, expected: Any) -> None:
    law = fa.Law.from_log(columns(TRUTHS, "u t a"), decision="u", group="a", truth="t")
    if isinstance(expected, str):
        with pytest.raises(fa.InputError) as error:
            fa.certify(law, utility, positive=positive, confidence=None)
        assert expected in str(error.value)
        return
    found = fa.certify(law, utility, positive=positive, confidence=None)
    assert (found.given_truth.positive.decision, found.given_truth.positive.truth) == expected
    assert found.certificate.document["subject"]["positive"] == {"decision": list(expected[0]), "truth": expected[1]}
    accepted(found.certificate)


def test_a_utility_of_several_values_asks_for_a_label_that_is_both() -> None:
    law = fa.Law.from_log(columns([("y", "y", "f"), ("n", "n", "m"), ("m", "y", "m")], "u t a"), decision="u", group="a", truth="t")
    with pytest.raises(fa.InputError, match="give positive"):
        fa.certify(law, {"y": 1, "m": "1/2"}, confidence=None)
    assert fa.certify(law, {"y": 1, "m": "1/2"}, positive="y", confidence=None).given_truth.positive.decision == ("y",)


def test_true_labels_that_cannot_be_used_are_refused() -> None:
    law = fa.Law.from_log(columns([("y", "f"), ("n", "m")], "u a"), decision="u", group="a")
    with pytest.raises(fa.InputError, match="was given without true labels"):
        fa.certify(law, {"y": 1}, positive="y", confidence=None)
    with pytest.raises(fa.InputError, match="used twice"):
        fa.Law.from_log(columns(TRUTHS, "u t a"), decision="u", group="a", truth="u")
    gaps = columns([*TRUTHS, ("no", "", "f")], "u t a")
    with pytest.raises(fa.InputError, match="column 't', row 5: the label is missing"):
        fa.Law.from_log(gaps, decision="u", group="a", truth="t")
    assert fa.Law.from_log(gaps, decision="u", group="a", truth="t", missing="drop").weights.sum() == 4
    assert "(missing)" in fa.Law.from_log(gaps, decision="u", group="a", truth="t", missing="group").truth.labels
    policy = fa.Policy(fa.Law.from_log(columns(TRUTHS, "u t a"), decision="u", group="a", truth="t"))
    with pytest.raises(fa.InputError, match="not with a policy behind filters"):
        fa.certify(policy.behind(group=fa.RandomizedResponse(["f", "m"], keep_probability="0.8")), {"hire": 1}, confidence=None)


def test_positive_decisions_that_never_occurred_count() -> None:
    law = fa.Law.from_log(columns([("n", "y", "f"), ("n", "y", "m"), ("call", "n", "f")], "u t a"), decision="u", group="a", truth="t")
    result = fa.certify(law, {"hired": 1, "call": 1}, positive="y", confidence=None)
    assert result.given_truth.positive.decision == ("call", "hired")
    assert result.given_truth.differences["equal_opportunity"].value == 0
    accepted(result.certificate)


# Intervals


def all_outcomes(draws: Sequence[int]) -> Iterator[tuple[int, ...]]:
    return product(*(range(n + 1) for n in draws))


@pytest.mark.parametrize(
    ("blocks", "alpha"),
    [([(5, 6)], "1/5"), ([(4, 3, 5)], "1/4"), ([(3, 4), (5, 2)], "1/5"), ([(12, 9)], "1/20")],
)
def test_intervals_contain_the_truth_often_enough_by_exact_enumeration(blocks: list[tuple[int, ...]], alpha: str) -> None:
    """Every outcome of every rate, weighted by its exact binomial probability, for many true rates."""
    draws = [n for block in blocks for n in block]
    known: dict[tuple[int, ...], tuple[Fraction, Fraction]] = {}
    for outcome in all_outcomes(draws):
        parts = iter(outcome)
        found = difference_of_rates([[(next(parts), n) for n in block] for block in blocks], 1 - Fraction(alpha))
        known[outcome] = found.lower, found.upper
    grid = [Fraction(i, 8) for i in range(9)]
    for chances in random.Random(1).sample(list(product(grid, repeat=len(draws))), 80):
        rates = iter(chances)
        truth = max(p - q for block in blocks for own in [[next(rates) for _ in block]] for p in own for q in own)
        missed = sum(
            prod(comb(n, k) * p**k * (1 - p) ** (n - k) for n, k, p in zip(draws, outcome, chances, strict=True))
            for outcome, (low, high) in known.items()
            if not low <= truth <= high
        )
        assert missed <= Fraction(alpha), (chances, float(missed))
    assert any(high < 1 for _, high in known.values()) and (len(draws) > 2 or any(low > 0 for low, _ in known.values()))


def test_many_rates_are_bounded_fast_and_their_evidence_holds() -> None:
    """More cells than have ends of their own: those that cannot decide keep cheaper ones, which the checker accepts."""
    source = random.Random(2)
    rows = []
    for x in range(300):
        for a in "fm":
            chance = 0.9 if x == 7 and a == "f" else 0.2 if x == 7 else 0.5
            rows += [("y" if source.random() < chance else "n", source.choice("yyyn"), a, str(x)) for _ in range(200 if x == 7 else 20)]
    started = time.monotonic()
    result = measured(rows)
    interval = result.given_truth.intervals["equal_opportunity"]
    assert time.monotonic() - started < 60
    assert 0 < interval.lower < result.given_truth.differences["equal_opportunity"].value <= interval.upper
    accepted(result.certificate)
    few = difference_of_rates([[(90, 100), (50, 100)]] * 40, "0.95")
    many = difference_of_rates([[(90, 100), (50, 100)]] * 60, "0.95")
    assert few.lower > many.lower > 0 and few.upper == many.upper  # the upper end does not pay for the number of rates


def test_no_interval_where_none_can_be() -> None:
    rows = [("y", "y", "f", "A"), ("n", "y", "m", "A"), ("y", "n", "f", "A"), ("n", "n", "m", "A")] * 5
    log = columns(rows) | {"run": [str(i // 2) for i in range(len(rows))]}
    law = fa.Law.from_log(log, decision="u", group="a", context="x", truth="t", unit="run")
    for result in (fa.certify(law, {"y": 1}), measured(rows, embed_table=False)):
        assert not result.given_truth.intervals and not [q for q in result.certificate.document.get("intervals", {}) if "equal" in q]
        assert any(note.startswith("no interval for the rates given the true label is claimed: ") for note in result.notes)
    accepted(fa.certify(law, {"y": 1}).certificate)


def test_the_worst_utility_of_a_law_forgets_its_true_labels() -> None:
    law = fa.Law.from_log(
        columns([("y", "p", "f"), ("n", "q", "f"), ("y", "q", "m"), ("n", "p", "m")] * 3, "u t a"), decision="u", group="a", truth="t"
    )
    certificate = fa.certify_worst_case(fa.worst_case(law, fa.UtilityClass(gamma=1, tau="0.3")))
    assert "truth" not in certificate.document["subject"]["columns"]
    accepted(certificate)


# Tampering


def sampled() -> dict[str, Any]:
    rows = [("y", "y", "f", "A")] * 30 + [("n", "y", "f", "A")] * 5 + [("y", "n", "f", "A")] * 6 + [("n", "n", "f", "A")] * 20
    rows += [("y", "y", "m", "A")] * 9 + [("n", "y", "m", "A")] * 25 + [("y", "n", "m", "A")] * 3 + [("n", "n", "m", "A")] * 24
    rows += [("y", "y", "m", "B")] * 4 + [("n", "?", "f", "B")] * 3 + [("n", "y", "f", "B")] * 2
    document: dict[str, Any] = json.loads(measured(rows).certificate.text)
    return document


def outcome(document: Any) -> str:
    try:
        report = checker.check(json.dumps(document).encode())
    except checker.FormatError:
        return "malformed"
    return "true" if report.ok else "false"


def leaves(value: Any, path: tuple[Any, ...] = ()) -> Iterator[tuple[tuple[Any, ...], Any]]:
    if isinstance(value, dict | list):
        for key in value if isinstance(value, dict) else range(len(value)):
            yield from leaves(value[key], (*path, key))
    else:
        yield path, value


def changed(document: Any, path: tuple[Any, ...], value: Any) -> Any:
    copy = json.loads(json.dumps(document))
    place = copy
    for step in path[:-1]:
        place = place[step]
    place[path[-1]] = value
    return copy


def moved(path: tuple[Any, ...], value: str) -> list[Any]:
    number = Fraction(value)
    return [str(number + by) for by in (Fraction(1, 1000), Fraction(-1, 1000), 1, -1)] + [str(1 - number), "0", "1", "1/2", value + " "]


def test_intervals_that_were_tampered_with_are_false() -> None:
    """Every end, level and difference moved by a little or much: only what claims less is still true."""
    document = sampled()
    assert outcome(document) == "true"
    assert Fraction(document["intervals"]["equal_opportunity"]["difference"][0]) > Fraction(1, 8)
    seen = 0
    for name in [name for name in document["intervals"] if name.startswith("equal")]:
        for path, value in leaves(document["intervals"][name], ("intervals", name)):
            for other in moved(path, value):
                if other == value:
                    continue
                mutant = changed(document, path, other)
                wider = path[2] in ("upper", "lower") and ((path[4] == 0) is (other == "0" or Fraction(other.strip()) < Fraction(value)))
                found, seen = outcome(mutant), seen + 1
                if found != "true":
                    continue
                # What is left true states no more than before: wider ends that still prove the difference, and differences that are wider.
                low, high = (Fraction(end) for end in mutant["intervals"][name]["difference"])
                old_low, old_high = (Fraction(end) for end in document["intervals"][name]["difference"])
                assert wider or (low <= old_low and high >= old_high), (path, value, other)
    assert seen > 300


def proves(interval: dict[str, Any], cells: list[list[tuple[int, int]]]) -> bool:
    """Whether the evidence proves an interval, by the definitions, with sums of fractions."""

    def tail(n: int, k: int, p: Fraction) -> Fraction:
        return sum((comb(n, i) * p**i * (1 - p) ** (n - i) for i in range(k + 1)), Fraction(0))

    counts = [cell for block in cells for cell in block]
    beta, other = (Fraction(interval["levels"][side]) for side in ("upper", "lower"))
    if not 0 < other <= beta < 1 or 2 * beta + (2 * len(counts) - 2) * other > 1 - Fraction(interval["confidence"]):
        return False
    outermost, innermost = Fraction(0), Fraction(0)
    for side, level in (("upper", beta), ("lower", other)):
        ends = [(Fraction(lo), Fraction(hi)) for lo, hi in interval[side]]
        for (k, n), (lo, hi) in zip(counts, ends, strict=True):
            if not 0 <= lo <= hi <= 1 or (hi < 1 and tail(n, k, hi) > level) or (lo > 0 and tail(n, n - k, 1 - lo) > level):
                return False
        parts = iter(ends)
        for block in cells:
            own = [next(parts) for _ in block]
            pairs = [(one, two) for i, one in enumerate(own) for j, two in enumerate(own) if i != j]
            if side == "upper":
                outermost = max(outermost, *(one[1] - two[0] for one, two in pairs))
            else:
                innermost = max(innermost, *(one[0] - two[1] for one, two in pairs))
    low, high = map(Fraction, interval["difference"])
    return 0 <= low <= innermost and high >= min(Fraction(1), outermost)


@given(data=st.data(), quantity=st.sampled_from(["equal_opportunity", "equalized_odds_true_label"]))
@settings(max_examples=int(os.environ.get("FAIRAUDIT_EXAMPLES", "100")))
def test_forged_intervals_are_accepted_only_where_the_evidence_proves_them(data: st.DataObject, quantity: str) -> None:
    """Small tables; levels, ends and differences moved at random, one or all of them, towards claiming more and towards claiming less."""
    seed = data.draw(st.integers(0, 10**9))
    source = random.Random(seed)
    cells = [
        [((n := source.randrange(1, 9)), source.randrange(0, n + 1))[::-1] for _ in range(source.choice([2, 2, 3]))]
        for _ in range(2 if quantity == "equalized_odds_true_label" else 1)
    ]
    if len(cells) == 2:
        cells[1] = (cells[1] * 2)[: len(cells[0])]
    rows = [
        row
        for kind, block in zip("yn", cells, strict=False)
        for a, (k, n) in zip("fmx", block, strict=False)
        for row in [("y", kind, a)] * k + [("n", kind, a)] * (n - k)
    ]
    rows += [("n", "n", a) for a in "fmx"[: len(cells[0])]] if quantity == "equal_opportunity" else []
    law = fa.Law.from_log(columns(rows, "u t a"), decision="u", group="a", truth="t")
    utility = fa.Utility({"y": 1, "n": 0})
    document = json.loads(fa.certify(law, utility, positive="y", confidence="4/5").certificate.text)
    interval = document["intervals"][quantity]
    for path, value in list(leaves(interval)):
        if path == ("confidence",) or source.random() > 0.25:
            continue
        place = interval
        for step in path[:-1]:
            place = place[step]
        place[path[-1]] = str(
            Fraction(value) + Fraction(source.choice([-1, 1]) * source.randrange(0, 40), source.choice([100, 1000, 10**6]))
        )
    document["claims"] = [claim for claim in document["claims"] if claim["quantity"] != quantity or claim["by"] == "enumeration"]
    try:
        findings = checker.check(json.dumps(document).encode()).findings
    except checker.FormatError:
        negative = any(Fraction(value) < 0 for path, value in leaves(interval))
        assert negative or proves(interval, cells)  # without claims about it, a proved interval is incomplete
        return
    (found,) = [finding for finding in findings if finding.statement.startswith(f"intervals.{quantity}:")]
    assert found.true is proves(interval, cells), (interval, found.detail)


@pytest.mark.parametrize(
    ("path", "value", "expected"),
    [
        (("subject", "positive", "truth"), "n", "false"),
        (("subject", "positive", "truth"), "z", "malformed"),
        (("subject", "positive", "decision"), ["n"], "false"),
        (("subject", "positive", "decision"), [], "malformed"),
        (("subject", "positive", "decision"), ["y", "y"], "malformed"),
        (("subject", "positive", "decision"), ["y", "n"], "malformed"),  # not in the order of the table
        (("subject", "columns", "truth"), "T", "false"),
        (("metrics", "equal_opportunity", "value"), "0", "false"),
        (("metrics", "equal_opportunity"), None, "false"),
        (("metrics", "equalized_odds_true_label", "witness", "rate"), "false_positive_rate", "false"),
        (("metrics", "true_positive_rate"), None, "false"),
        (("metrics", "true_positive_rate", 0, "rate"), "1", "false"),
        (("metrics", "false_positive_rate_overall"), [], "false"),
        (("not_compared",), [], "false"),
        (("intervals", "equal_opportunity", "confidence"), "99/100", "false"),
        (("intervals", "equal_opportunity", "levels", "lower"), "0", "false"),
        (("intervals", "equal_opportunity", "upper"), [], "false"),
        (("subject", "table", "rows", 0, "truth", 0, 0), "7", "malformed"),
    ],
)
def test_a_certificate_that_was_tampered_with_is_refused(path: tuple[Any, ...], value: Any, expected: str) -> None:
    assert outcome(changed(sampled(), path, value)) == expected


def test_claims_say_no_more_than_their_interval_and_list_what_they_rest_on() -> None:
    document = sampled()
    about = [i for i, claim in enumerate(document["claims"]) if claim["quantity"].startswith("equal_") and claim["by"] == "binomial"]
    assert len(about) == 4
    for i in about:
        claim = document["claims"][i]
        stronger = Fraction(claim["value"]) + (Fraction(1, 100) if claim["relation"] == ">=" else -Fraction(1, 100))
        assert outcome(changed(document, ("claims", i, "value"), str(stronger))) == "false"
        for key, value in (("scope", "population at confidence 99/100"), ("by", "hoeffding-kl"), ("relation", "=")):
            assert outcome(changed(document, ("claims", i, key), value)) == "false"
        assert outcome(changed(document, ("claims", i, "evidence"), {"interval": "equalized_odds_true_label"})) == "false"
        for k in range(len(claim["assumptions"])):
            assert (
                outcome(changed(document, ("claims", i, "assumptions"), claim["assumptions"][:k] + claim["assumptions"][k + 1 :]))
                == "malformed"
            )


def test_without_true_labels_nothing_given_them_may_be_stated() -> None:
    document = sampled()
    plain = json.loads(fa.certify(fa.Law.from_log(LOG, decision="hired", group="sex", context="dept"), {"yes": 1}).certificate.text)
    assert outcome(plain) == "true"
    for section, names in (("metrics", ["equal_opportunity", "true_positive_rate"]), ("intervals", ["equal_opportunity"])):
        for name in names:
            assert outcome({**plain, section: {**plain[section], name: document[section][name]}}) == "malformed"
    assert outcome({**plain, "subject": {**plain["subject"], "positive": {"decision": ["yes"], "truth": "yes"}}}) == "malformed"
    for claim in document["claims"]:
        if claim["quantity"].startswith(("equal_", "equalized_odds_")):
            assert outcome({**plain, "claims": [*plain["claims"], claim]}) != "true"


def test_rows_of_one_unit_are_no_draws_of_a_rate() -> None:
    """An interval that would be right of independent rows, put beside the units that say that they are not."""
    rows = [("y", "y", "f", "A"), ("y", "y", "f", "A"), ("n", "y", "m", "A"), ("y", "n", "f", "A"), ("n", "n", "m", "A")] * 6
    log = columns(rows) | {"run": [str(i // 2) for i in range(len(rows))]}
    law = fa.Law.from_log(log, decision="u", group="a", context="x", truth="t", unit="run")
    own, other = (json.loads(result.certificate.text) for result in (fa.certify(law, {"y": 1}, interval="hoeffding-kl"), measured(rows)))
    assert outcome(own) == outcome(other) == "true" and own["subject"] == other["subject"]
    name = "equal_opportunity"
    claims = [claim for claim in other["claims"] if claim["quantity"] == name and claim["by"] == "binomial"]
    both = {**own, "intervals": {**own["intervals"], name: other["intervals"][name]}, "claims": [*own["claims"], *claims]}
    assert outcome(both) == "false"


def test_missing_true_labels_are_recorded_and_checked() -> None:
    log = columns([("y", "y", "f"), ("n", "", "f"), ("y", "y", "m"), ("n", "n", "m")] * 3, "u t a")
    result = fa.certify(fa.Law.from_log(log, decision="u", group="a", truth="t", missing="drop"), {"y": 1}, positive="y")
    accepted(result.certificate)
    document = json.loads(result.certificate.text)
    (done,) = document["subject"]["preparation"]
    assert done["columns"] == {"t": "3"}


def test_unknown_true_labels_are_no_false_positives() -> None:
    log = columns([("y", "y", "f"), ("y", "", "f"), ("y", "y", "m"), ("n", "n", "m"), ("n", "n", "")] * 3, "u t a")
    with pytest.raises(fa.InputError, match="column 't': 3 decisions have no true label"):
        fa.certify(fa.Law.from_log(log, decision="u", group="a", truth="t", missing="group"), {"y": 1})
    known = fa.Law.from_log({**log, "t": ["n" if t == "" else t for t in log["t"]]}, decision="u", group="a", truth="t", missing="group")
    document = json.loads(fa.certify(known, {"y": 1}).certificate.text)
    assert outcome(document) == "true"
    document["subject"]["preparation"].append({"step": "level", "column": "t", "label": "n", "decisions": "9"})
    assert outcome(document) == "malformed"


# Faces


@pytest.fixture
def log(tmp_path: Path) -> Path:
    rows = [("y", "y", "f", "A")] * 9 + [("n", "y", "f", "A")] * 4 + [("n", "n", "f", "A")] * 6 + [("y", "n", "f", "A")]
    rows += [("y", "y", "m", "A")] * 5 + [("n", "y", "m", "A")] * 8 + [("n", "n", "m", "A")] * 3 + [("n", "?", "x", "A")] * 2
    path = tmp_path / "log.csv"
    path.write_text("\n".join(",".join(row) for row in [("u", "t", "a", "x"), *rows]) + "\n")
    return path


OPTIONS = ["--decision", "u", "--group", "a", "--utility", "y", "--truth", "t"]


def test_one_certificate_whoever_reads_the_log(log: Path, tmp_path: Path) -> None:
    import sqlite3

    import pandas as pd

    frame = pd.read_csv(log, dtype=str)
    frame.to_parquet(tmp_path / "log.parquet")
    frame.to_json(tmp_path / "log.jsonl", orient="records", lines=True)
    with sqlite3.connect(tmp_path / "log.db") as database:
        frame.to_sql("decisions", database, index=False)
    audit = tmp_path / "audit.toml"
    audit.write_text('[law]\ntable = "log.csv"\ndecision = "u"\ngroup = "a"\ntruth = "t"\npositive = "y"\n[utility]\nvalues = { y = 1 }\n')
    texts = set()
    sources = [
        [str(log)],
        [str(tmp_path / "log.parquet")],
        [str(tmp_path / "log.jsonl")],
        [f"sqlite:{tmp_path / 'log.db'}", "--table", "decisions"],
    ]
    for given_, options in [*((source, OPTIONS) for source in sources), ([str(audit)], [])]:
        assert main(["certify", *given_, *options, "-o", str(tmp_path / "c.json")]) == 0
        texts.add((tmp_path / "c.json").read_text())
    law = fa.Law.from_log(frame, decision="u", group="a", truth="t")
    texts.add(fa.certify(law, {"y": 1}).certificate.text)
    documents = [json.loads(text) for text in texts]
    same = {json.dumps({**document, "subject": {**document["subject"], "table": 0}, "claims": 0}, sort_keys=True) for document in documents}
    assert len(same) == 1  # the audit file reads a table, whose labels are in order of appearance; figures and intervals are the same
    assert main(["verify", str(tmp_path / "c.json")]) == 0


def test_text_page_markdown_and_json(log: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["certify", str(log), *OPTIONS, "-o", str(tmp_path / "c.json"), "--verbose"]) == 0
    printed = capsys.readouterr().out
    for line in (
        "Given the true label in column 't' (positive: decision 'y', true label 'y')",
        "equal opportunity: a difference of 0.3077 (true positive rate 0.6923 for a=f, 0.3846 for a=m; n = 13 and 13)",
        "a=f  0.6923 (9 of 13)    0.1429 (1 of 7)",
        "a=x  no draws            0 (0 of 2)",
        "Each interval holds at its confidence by itself.",
        "the only context, a=x, true positive rate: no decisions with the positive true label",
    ):
        assert line in printed, line
    document = json.loads((tmp_path / "c.json").read_text())
    text, page = markdown(document), html(document)
    for shown in (text, page):
        assert "Given the true label" in shown and "Equalized odds given the true label" in shown and "0.3077" in shown
    assert "true positive rate" in text and 'data-path="metrics.equal_opportunity.value">4/13<' in page
    assert main(["certify", str(log), *OPTIONS, "--format", "json"]) == 0
    found = envelope(capsys.readouterr().out)
    assert found["result"]["metrics"]["equal_opportunity"]["value"] == "4/13"
    assert main(["compare", str(tmp_path / "c.json"), str(tmp_path / "c.json")]) == 0
    assert main(["certify", str(log), *OPTIONS, "--context", "x", "--no-table", "-o", str(tmp_path / "d.json")]) == 0
    apart = json.loads((tmp_path / "d.json").read_text())
    assert apart["metrics"]["true_positive_rate"] is None and "rows" not in apart["subject"]["table"]
    assert main(["verify", str(tmp_path / "d.json"), "--table", str(tmp_path / "d.table.jsonl")]) == 0
    assert html(apart).count(">Given the true label</h2>") == 1


def test_differences_are_compared(capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    """A rate that moved is a measure that moved; other true labels, or other positive ones, are another question."""
    rows = [("y", "y", "f"), ("y", "y", "m"), ("n", "n", "f"), ("n", "n", "m")] * 3
    made = {}
    for name, more, truth, positive in (
        ("old", [], "t", "y"),
        ("new", [("n", "y", "f"), ("y", "n", "f")], "t", "y"),
        ("other", [], "t", "n"),
        ("none", [], None, None),
    ):
        law = fa.Law.from_log(columns([*rows, *more], "u t a"), decision="u", group="a", truth=truth)
        made[name] = tmp_path / f"{name}.json"
        fa.certify(law, {"y": 1}, positive=positive).certificate.save(made[name])
    assert main(["compare", str(made["old"]), str(made["new"]), "--fail-on", "rise"]) == 1
    printed = capsys.readouterr().out
    assert re.search(r"(?m)equal opportunity +0 -> 0.25 \(1/4\) +\+0.25$", printed), printed
    assert "equalized odds given the true label" in printed
    for other, said in (
        ("other", "positive is {'decision': ['y'], 'truth': 'y'} in one"),
        ("none", "the truth column is 't' in one and None"),
    ):
        assert main(["compare", str(made["old"]), str(made[other])]) == 2
        assert said in capsys.readouterr().err


@pytest.mark.parametrize(
    ("options", "message"),
    [
        (["--truth", "z"], "there is no column 'z'"),
        (["--truth", "u"], "used twice"),
        (["--truth", "t", "--positive", "maybe"], "is no true label of column 't'"),
        (["--positive", "y"], "was given without true labels"),
        (["--truth", "t", "--in-parts", "--context", "x"], "--in-parts does not go with --truth"),
        (["--truth", "t", "--probability", "x"], "--truth goes with counts and logs"),
    ],
)
def test_options_that_do_not_fit_are_refused(options: list[str], message: str, log: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["certify", str(log), "--decision", "u", "--group", "a", "--utility", "y", *options]) == 2
    printed = capsys.readouterr()
    assert message in printed.err and printed.out == "" and len(printed.err.strip().splitlines()) == 1


def test_true_labels_go_with_no_stream_and_no_slots(log: Path, capsys: pytest.CaptureFixture[str]) -> None:
    for other in (["--from-monitor", "state.db"], ["--slots", "a"]):
        assert main(["certify", *([] if "--from-monitor" in other else [str(log)]), *other, "--truth", "t"]) == 2
        assert f"--truth does not go with {other[0]}" in capsys.readouterr().err


def test_the_printed_query_counts_true_labels(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["certify", "--print-sql", "duckdb", *OPTIONS, "--positive", "y"]) == 0
    printed = capsys.readouterr().out
    assert "--truth t" in printed and "--positive y" in printed and printed.count('"t"') >= 2
