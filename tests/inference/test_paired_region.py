"""Intervals of groups that were seen in the same units: when they are taken, what proves them, and what refuses altered ones."""

from __future__ import annotations

import copy
import json
import random
from collections import Counter
from fractions import Fraction
from itertools import permutations
from math import inf
from typing import Any

import pytest
from certificates import outcome
from contrast_oracle import paired
from hypothesis import given, settings
from hypothesis import strategies as st
from paired_certificates import WORTH, Row, alterations, certified, honest, law_of, logs, named, repaired, table

import fairaudit as fa
from fairaudit import checker
from fairaudit.errors import InputError
from fairaudit.inference.comparisons import Comparison
from fairaudit.inference.ratio_intervals import default_region, drivers, ratio_interval
from fairaudit.inference.table_comparisons import local_comparison
from fairaudit.model.utility import Utility
from fairaudit.theorems.assumptions import POOLED

F = Fraction
VALUE = {"yes": F(1), "maybe": F(1, 2), "no": F(0)}
ALTERED = 2_000


def compared(rows: list[Row]) -> Comparison:
    law = law_of(rows)
    return local_comparison(law, Utility(WORTH).on(law))


def plain_profiles(rows: list[Row]) -> list[Counter[tuple[Fraction | None, ...]]]:
    """What each unit got in each group of a context, counted row by row."""
    found = []
    for x in sorted({x for _, _, x, _ in rows}):
        here = [row for row in rows if row[2] == x]
        groups = sorted({a for _, a, _, _ in here})
        of_units: Counter[tuple[Fraction | None, ...]] = Counter()
        for unit in {row[3] for row in here}:
            own = [[VALUE[u] for u, b, _, i in here if b == a and i == unit] for a in groups]
            of_units[tuple(sum(got, F(0)) / len(got) if got else None for got in own)] += 1
        if len(groups) > 1:
            found.append(of_units)
    return found


def plain_wealth(rows: list[Row], limit: Fraction, *, drop: bool = False) -> list[Fraction]:
    """What bets against E_i ≥ limit·E_j won, by definition, for all ordered pairs."""
    won = []
    for profiles in plain_profiles(rows):
        for i, j in permutations(range(len(next(iter(profiles)))), 2):
            counts: Counter[tuple[Fraction, Fraction]] = Counter()
            for values, n in profiles.items():
                x, y = values[i], values[j]
                if not (drop and (x is None or y is None)):
                    counts[F(1) if x is None else x, F(0) if y is None else y] += n
            won.append(paired(counts, limit, "ratio"))
    return won


@given(st.integers(0, 10**6), st.sampled_from(["0.5", "0.9", "0.95"]), st.booleans(), st.sampled_from(["each", "together"]))
@settings(max_examples=15, deadline=None)
def test_ends_are_where_the_definition_puts_them(seed: int, confidence: str, drop: bool, ends: Any) -> None:
    rows = logs(random.Random(seed))
    comparison = compared(rows)
    if drop:
        comparison = Comparison(**{**vars_of(comparison), "missing": "drop"})
    if default_region(comparison, independent=False) != "paired":
        return
    found = ratio_interval(comparison, confidence, region="paired", ends=ends)
    level = (1 - F(confidence)) / (1 if ends == "each" else 2)
    just = 1 + F(1, 10**5)
    if found.upper < inf:
        upper = F(found.upper)
        assert min(plain_wealth(rows, upper, drop=drop)) >= 1 / level
        assert upper == 1 or min(plain_wealth(rows, upper / just, drop=drop)) < 1 / level
    means = plain_wealth(rows, 1 / found.lower, drop=drop)
    assert found.lower == 1 or sum(means, F(0)) / len(means) >= 1 / level
    further = plain_wealth(rows, 1 / (found.lower * just), drop=drop)
    assert sum(further, F(0)) / len(further) < 1 / level
    assert found.methods == ("paired-betting",)


def vars_of(comparison: Comparison) -> dict[str, Any]:
    return {name: getattr(comparison, name) for name in comparison.__dataclass_fields__}


@given(st.integers(0, 10**6), st.sampled_from([0.0, 0.05, 0.4]))
@settings(max_examples=25, deadline=None)
def test_profiles_are_what_each_unit_got(seed: int, lost: float) -> None:
    source = random.Random(seed)
    rows = logs(source, units=6, often=3, lost=lost)
    law = law_of(rows)
    found = local_comparison(law, Utility(WORTH).on(law)).profiles
    expected = plain_profiles(rows)
    if any(sum(value is not None for value in values) > 1 for profiles in expected for values in profiles):
        assert [dict(profiles) for profiles in found] == [dict(profiles) for profiles in expected]
    else:
        assert not found


def test_the_order_of_rows_changes_no_digit() -> None:
    source = random.Random(5)
    rows = logs(source)
    texts = set()
    for _ in range(4):
        texts.add(certified(rows, max_local_ratio="5/4").certificate.text)
        source.shuffle(rows)
    assert len(texts) == 1


def test_units_in_one_group_each_keep_the_box() -> None:
    rows = [(u, a, "s", f"{a}{i}") for a in "fm" for i, u in enumerate(["yes", "no"] * 10)]
    assert not compared(rows).profiles
    assert default_region(compared(rows), independent=False) == "box"
    with pytest.raises(InputError, match="contrasts within units need units"):
        ratio_interval(compared(rows), region="paired")


@pytest.mark.parametrize(("absent", "region"), [(0, "paired"), (6, "paired"), (7, "box"), (35, "box")])
def test_more_missing_units_than_the_square_root_of_all_keep_the_box(absent: int, region: str) -> None:
    """36 units, and none, or some, or nearly all, of which one group never saw."""
    rows = [(u, a, "s", str(i)) for i in range(36) for a, u in (("f", "yes"), ("m", "no" if i % 3 else "yes")) if a == "f" or i >= absent]
    result = certified(rows, max_local_ratio=2)
    assert result.intervals["local"].region == region
    said = "within the units of column 'unit', " if region == "paired" else "were not seen in all groups; if that is by design"
    assert any(said in note for note in result.notes)
    dropped = certified(rows, max_local_ratio=2, missing_units="drop")
    assert dropped.intervals["local"].region == "paired"  # all that the smaller group saw are in both
    if absent and region == "paired":
        assert dropped.intervals["local"].upper < result.intervals["local"].upper
        assert "by design" in " ".join(dropped.intervals["local"].assumptions)


@pytest.mark.parametrize(("both", "region"), [(10, "paired"), (9, "box")])
def test_units_missing_by_design_need_half_of_the_smaller_group_in_both(both: int, region: str) -> None:
    seen = {"f": range(20), "m": range(20 - both, 60)}
    rows = [(u, a, "s", str(i)) for a, own in seen.items() for i in own for u in (["yes"] if i % 3 else ["no"])]
    assert certified(rows, missing_units="drop").intervals["local"].region == region


def test_another_method_keeps_the_box() -> None:
    rows = logs(random.Random(1), lost=0)
    assert certified(rows).intervals["local"].region == "paired"
    assert certified(rows, interval="empirical-bernstein").intervals["local"].region == "box"


def test_what_is_no_way_to_treat_missing_units_is_refused() -> None:
    rows = logs(random.Random(1))
    with pytest.raises(InputError, match="missing_units is 'best'"):
        certified(rows, missing_units="best")
    plain = fa.Law.from_log(table(rows), decision="u", group="a", context="x")
    with pytest.raises(InputError, match="missing_units is about a log with sampling units"):
        fa.certify(plain, WORTH, missing_units="drop")


def test_drivers_are_the_pair_that_won_most_and_least() -> None:
    rows = [("yes", "f", x, str(i)) for x in "st" for i in range(40)]
    rows += [("yes" if i % 2 else "no", "m", "t", str(i)) for i in range(40)] + [("yes", "m", "s", str(i)) for i in range(40)]
    found = ratio_interval(compared(rows), ends="each", region="paired")
    lower, upper = drivers(compared(rows), found.evidence, found.upper, found.lower)
    for witness in (lower, upper):
        assert witness is not None
        assert (witness.context, witness.higher, witness.lower) == ({"x": "t"}, {"a": "f"}, {"a": "m"})
    assert 1 < found.lower < 2 < found.upper < inf


@given(st.integers(0, 10**6), st.sampled_from(["0.5", "0.95"]))
@settings(max_examples=15, deadline=None)
def test_certificates_are_true(seed: int, confidence: str) -> None:
    source = random.Random(seed)
    rows = logs(source, groups="fmn"[: source.randint(2, 3)], often=source.randint(1, 2))
    options: dict[str, Any] = source.choice([{}, {"max_local_ratio": "5/4"}, {"missing_units": "drop"}])
    result = certified(rows, confidence=confidence, **options)
    assert outcome(json.loads(result.certificate.text)) == "true"
    for claim in result.claims:
        assert claim.by != "paired-betting" or result.intervals["local"].region == "paired"


def test_a_declared_range_counts_from_nothing() -> None:
    """A utility of at least 1 has the origin 0 all the same, and the greatest that could be drawn is that of the range."""
    rows = logs(random.Random(2), lost=0, often=1)
    worth: dict[str, Any] = {"yes": 2, "maybe": "3/2", "no": 1}
    result = fa.certify(law_of(rows), worth, declared={"m": 1, "gamma": 4}, max_local_ratio=2)
    assert result.intervals["local"].region == "paired" and outcome(json.loads(result.certificate.text)) == "true"
    tighter = fa.certify(law_of(rows), worth, declared={"m": 1, "gamma": 2}, max_local_ratio=2)
    assert tighter.intervals["local"].upper < result.intervals["local"].upper


# Altered evidence


def test_altered_evidence_is_refused() -> None:
    source, tried, kinds = random.Random(11), 0, Counter[str]()
    while tried < ALTERED:
        document = honest(source)
        assert outcome(document) == "true"
        for kind, made in alterations(document, source):
            assert outcome(made) != "true", (kind, made["intervals"])
            kinds[kind] += 1
            tried += 1
    assert min(kinds.values()) >= 20


def test_profiles_of_other_units_are_refused_by_the_digest_of_the_table() -> None:
    """Equal margins leave open which value goes with which; a forger has to forge the digest of the table, as with counts."""
    source = random.Random(3)
    document = honest(source)
    made = copy.deepcopy(document)
    made["intervals"]["local"]["profiles"] = repaired(source, made["intervals"]["local"]["profiles"])
    assert made["intervals"]["local"]["profiles"] != document["intervals"]["local"]["profiles"]
    assert outcome(made) == "false"
    named(made)
    assert made["subject"]["table"]["sha256"] != document["subject"]["table"]["sha256"]


def of_two_groups(**options: Any) -> dict[str, Any]:
    """A certificate of decisions in one context, on the same 60 units if they are named."""
    told = random.Random(5)
    rows = [("yes" if told.random() < (0.8 if a == "f" else 0.4) else "no", a, str(i)) for i in range(60) for a in "fm"]
    decisions, groups, units = zip(*rows, strict=True)
    named = {"unit": "i"} if not options else {}
    law = fa.Law.from_log({"u": list(decisions), "a": list(groups), "i": list(units)}, decision="u", group="a", **named)
    return json.loads(fa.certify(law, {"yes": 1}, max_local_ratio="5/4", **options).certificate.text)


def false_of(document: dict[str, Any]) -> list[str]:
    return [finding.detail for finding in checker.check(json.dumps(document).encode()).findings if not finding.true]


@pytest.mark.parametrize("pooled", [True, False])
def test_contrasts_within_units_are_not_for_the_global_ratio(pooled: bool) -> None:
    document = of_two_groups()
    assert false_of(document) == []
    document["subject"]["table"]["header"]["profiles"]["global"] = document["subject"]["table"]["header"]["profiles"]["local"]
    document["intervals"]["global"] = copy.deepcopy(document["intervals"]["local"])
    said = {claim["relation"]: claim for claim in document["claims"] if claim["by"] == "paired-betting"}
    for claim in document["claims"]:
        if claim["quantity"] == "global_ratio" and claim["scope"].startswith("population"):
            own = said[claim["relation"]]
            claim |= {key: own[key] for key in ("value", "scope", "by")} | {
                "assumptions": [*own["assumptions"], *([POOLED] if pooled else [])]
            }
    named(document)
    try:
        assert any("for the local ratio only" in fault for fault in false_of(document))
    except checker.FormatError as error:
        assert "assumption" in str(error)


def test_no_interval_beside_them_may_take_the_groups_for_independent() -> None:
    document, other = of_two_groups(), of_two_groups(independent=True)
    document["intervals"]["global"] = other["intervals"]["global"]

    def of_population(claim: dict[str, Any]) -> bool:
        return bool(claim["quantity"] == "global_ratio" and claim["scope"].startswith("population"))

    document["claims"] = [c for c in document["claims"] if not of_population(c)] + [c for c in other["claims"] if of_population(c)]
    assert any("not independent" in fault for fault in false_of(document))
