"""Ends that evidence does not list, against a second reading of docs/certificate-samples.md, and certificates that list few."""

from __future__ import annotations

import copy
import json
import random
from fractions import Fraction
from typing import Any

import numpy as np
import pytest
import tiers
from hypothesis import given, settings
from hypothesis import strategies as st
from interval_certificates import accepted, compare_readings, figures, from_counts, plain_lower, rejected, stands, tail

import fairaudit as fa
from fairaudit import checker
from fairaudit.inference import quotients
from fairaudit.inference.plain_ends import SLACK, UNIT, float_plain
from fairaudit.inference.plain_ends import plain_lower as written_lower

F = Fraction
LEVELS = [F(1, 2), F(1, 80), F(1, 10**8), F(1, 10**40)]


def lower(n: int, z: Fraction, level: Fraction) -> tuple[int, int]:
    """As the checker has it, with λ in units of 2^-32."""
    reach = checker.plain_ends.reach_of_plain(level)
    return checker.plain_ends.below(n, n * z.numerator, n * z.denominator, reach), reach


@given(st.sampled_from([1, 2, 3, 10, 125, 10**6, 10**12]), st.fractions(0, 1, max_denominator=10**6), st.sampled_from(LEVELS))
@settings(max_examples=150)
def test_the_lower_end_is_the_greatest_that_the_two_inequalities_prove(n: int, z: Fraction, level: Fraction) -> None:
    found, reach = lower(n, z, level)
    assert F(found, UNIT) == plain_lower(z, n, F(reach, UNIT))
    assert written_lower(n, n * z.numerator, n * z.denominator, reach) == found
    [guess] = float_plain(np.array([float(z)]), np.array([float(n)]), reach / UNIT)
    assert guess - SLACK < found / UNIT  # what decides where to look closely promises no less than is true


@given(
    st.sampled_from([1, 2, 3, 10, 125, 10**6, 10**12]),
    st.integers(0, 200),
    st.fractions(0, 1, max_denominator=10**6),
    st.one_of(st.just(F(0)), st.fractions(0, 1), st.fractions(0, F(1, 10**9))),
    st.sampled_from(LEVELS),
)
@settings(max_examples=300)
def test_ends_rise_with_the_mean_and_come_closer_with_more_draws(n: int, more: int, z: Fraction, up: Fraction, level: Fraction) -> None:
    higher = min(F(1), z + up)
    assert lower(n, z, level)[0] <= lower(n + n * more // 100, higher, level)[0]


@given(st.integers(1, 60), st.floats(0, 1), st.booleans(), st.sampled_from(LEVELS))
@settings(max_examples=150)
def test_draws_exclude_what_is_below_a_plain_end(n: int, share: float, binary: bool, level: Fraction) -> None:
    """By the tails that the format defines, those of draws between the ends of their range included."""
    total = F(round(n * share)) if binary else n * F(share).limit_denominator(100)
    found, _ = lower(n, total / n, level)
    cell = {"draws": n, "sum": total, "squares": total, "range": (F(0), F(1)), "binary": binary}
    assert not found or float(tail(cell, F(found, UNIT), False)) <= float(level) * (1 + 1e-9)


def of_few_listed(counts: Any, utility: Any, **options: Any) -> Any:
    """A certificate that lists the ends of those cells that decide, as those of many cells do."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(quotients, "DECISIVE_CELLS", 0)
        law = fa.Law.from_array(np.array(counts), kind="counts")
        return json.loads(fa.certify(law, utility, **options).certificate.text)


DECIDED = [[[300, 700], [650, 350], [500, 500]], [[250, 250], [240, 260], [0, 0]], [[2, 30], [20, 40], [1, 1]]]


@pytest.mark.parametrize("utility", [{"1": 1}, {"0": 1, "1": "1/3"}, {"0": "1/2", "1": 2}])
@pytest.mark.parametrize("options", [{}, {"max_local_ratio": 2, "max_global_ratio": 3}, {"max_local_ratio": "5/4", "confidence": "0.8"}])
def test_certificates_that_list_few_ends(utility: Any, options: Any) -> None:
    """They are true, and whatever number of their evidence is changed, the second reading agrees with the checker."""
    document = of_few_listed(DECIDED, utility, **options)
    assert accepted(document)
    for name in ("local", "global"):
        own = document["intervals"][name]
        assert {*own["upper"]} == {*own["lower"]} == {"cells", "ends"}
        derive = from_counts(document, name)
        cells, blocks, *_ = derive(None, None) or ([], [], False, None)
        assert len(own["upper"]["cells"]) <= len(figures(cells, blocks)[0])
        pick = random.Random(tiers.fresh(7))
        taken, refused = compare_readings(document, name, derive, lambda changes, pick=pick: pick.sample(changes, min(12, len(changes))))
        assert tiers.enough(refused > taken)


def test_what_decides_has_to_be_listed() -> None:
    document = of_few_listed(DECIDED, {"1": 1}, max_local_ratio=2)
    own = document["intervals"]["local"]
    assert F(own["ratio"][0]) > 1 and own["ratio"][1] != "inf"
    for side in ("upper", "lower"):
        for gone in range(len(own[side]["cells"])):
            changed = copy.deepcopy(document)
            part = changed["intervals"]["local"][side]
            del part["cells"][gone], part["ends"][gone]
            if side == "lower" and own["lower"]["cells"][gone] not in deciding(document):
                continue
            if side == "upper" and gone:
                continue
            assert not stands(changed, "local"), (side, gone)
    for change in ({"cells": [99]}, {"cells": [1, 1]}, {"cells": [2, 1]}, {"cells": []}, {"cells": ["1"]}, {"cells": None}, {"ends": {}}):
        changed = copy.deepcopy(document)
        changed["intervals"]["local"]["upper"] |= change
        assert rejected(changed)


def deciding(document: Any) -> set[int]:
    """The numbers of the cells of the pair that proves the lower end."""
    block, *pair = document["intervals"]["local"]["pair"]
    sizes = [3, 2, 3]
    return {sum(sizes[:block]) + place for place in pair}


def test_methods_without_plain_ends_list_every_cell() -> None:
    counts = np.random.default_rng(2).integers(5, 60, (60, 3, 3))
    law = fa.Law.from_array(counts, kind="counts")
    document = json.loads(fa.certify(law, {"0": 1, "1": "1/3"}, interval="empirical-bernstein").certificate.text)
    own = document["intervals"]["local"]
    assert len(own["upper"]) == 180
    assert checker.check(json.dumps(document).encode()).ok
    own["ratio"][1] = "inf"
    own["upper"] = {"cells": [], "ends": []}
    report = checker.check(json.dumps(document).encode())
    assert any("no plain ends" in str(finding) for finding in report.findings if not finding.true)


@pytest.mark.parametrize("token", [str(10**30), "1.0", "-0", "1e9"])
def test_a_number_of_a_cell_is_a_short_integer(token: str) -> None:
    table = {"u": ["yes", "no"] * 2, "a": list("ffmm"), "n": [30, 10, 20, 20]}
    document = json.loads(fa.audit(table, decision="u", group="a", count="n", utility="yes").certificate.text)
    document["subject"]["table"]["cells"] = 10**12
    raw = json.dumps(document).replace(str(10**12), token).encode()
    with pytest.raises(checker.FormatError, match=f"subject.table.cells must be an integer of at most 18 digits, not {token}"):
        checker.check(raw)
