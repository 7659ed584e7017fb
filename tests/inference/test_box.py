"""The box of many cells, of which only those that decide have narrow ends."""

from __future__ import annotations

from decimal import Decimal

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from interval_oracle import (
    F,
)

from fairaudit import Law, Utility, certify, checker
from fairaudit.inference import quotients
from fairaudit.inference.ratio_intervals import ratio_interval
from fairaudit.inference.table_comparisons import local_comparison


@pytest.mark.parametrize("unit", ["1e-400", "1e-30", "1e30", "1e400"])
def test_many_cells_have_the_same_interval_in_every_unit_of_utility(unit: str) -> None:
    """Whether or not floats could hold the numbers."""
    law = Law.from_array(np.random.default_rng(5).integers(1, 100, (20, 8, 3)), kind="counts")
    known = ratio_interval(local_comparison(law, Utility({"0": 1, "1": "0.5"}).on(law)), "0.95")
    half = str(Decimal(unit) / 2)
    found = ratio_interval(local_comparison(law, Utility({"0": unit, "1": half}).on(law)), "0.95")
    assert found.upper == known.upper > 1
    assert abs(found.lower / known.lower - 1) < F(1, 100_000)


@given(st.integers(0, 10**6), st.booleans())
@settings(max_examples=25)
def test_many_cells_have_the_interval_of_all_of_them(seed: int, binary: bool) -> None:
    """Narrowing only the ends that decide changes no interval: the upper end is the same, and the lower one all but."""
    pick = np.random.default_rng(seed)
    law = Law.from_array(pick.integers(0, 10 ** pick.integers(1, 5), (pick.integers(1, 5), pick.integers(2, 12), 3)) + 1, kind="counts")
    utility = Utility({"0": 1} if binary else {"0": 1, "1": "0.3"}).on(law)
    comparison = local_comparison(law, utility)
    found = []
    for least in (10**9, 0):
        with pytest.MonkeyPatch.context() as patch:
            patch.setattr(quotients, "DECISIVE_CELLS", least)
            assert quotients.are_many(comparison.used) is (least == 0)
            found.append(ratio_interval(comparison, "0.95"))
    every, decisive = found
    assert decisive.upper == every.upper
    assert every.lower * F(999_999, 1_000_000) <= max(decisive.lower, F(1)) <= every.lower


@given(st.integers(0, 10**6), st.sampled_from(["binary", "many", "declared", "zero"]))
@settings(max_examples=12, deadline=None)
def test_certificates_of_many_cells_are_accepted(seed: int, kind: str) -> None:
    """Ends in closed form, sums over groups and the estimate, checked from the certificate alone."""
    pick = np.random.default_rng(seed)
    counts = pick.integers(0, 10 ** pick.integers(1, 6), (pick.integers(30, 60), 4, 3)) + (pick.random((1, 1, 3)) < 0.7)
    law = Law.from_array(counts + (counts.sum(axis=2, keepdims=True) == 0), kind="counts")
    utility = {"binary": {"0": 1}, "many": {"0": 3, "1": "0.7"}, "declared": {"0": "1.5", "1": 1, "2": "0.5"}, "zero": {"2": "1e-30"}}[kind]
    declared = {"gamma": 2, "m": "0.25"} if kind == "declared" else {}
    result = certify(law, utility, max_local_ratio=3, max_global_log="0.1", declared=declared)
    report = checker.check(result.certificate.text.encode())
    assert all(finding.true for finding in report.findings), [finding for finding in report.findings if not finding.true]
    assert result.intervals["local"].estimate == (result.local.ratio if result.local else None)
    assert result.intervals["global"].estimate == (result.global_.ratio if result.global_ else None)
