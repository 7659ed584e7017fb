"""The greatest ratio over all policies, against dense tables of plain fractions and every deterministic policy."""

from __future__ import annotations

from fractions import Fraction
from typing import Any

import pytest
import tiers
from assumptions import complete
from hypothesis import given
from hypothesis import strategies as st
from plain_certificates import INF, checker, raw, text
from policy_certificates import POLICIES, TINY, Policy, write
from policy_suprema import Compared, by_enumeration, by_steps, compared

SEEDS = range(0, 400, 4)
BLOCKS = 5


def place(p: Policy, case: Compared) -> dict[str, Any]:
    context = None if case.context is None else p.true_x[case.context]
    return {"context": context, "higher": p.true_a[case.higher], "lower": p.true_a[case.lower]}


def accepted(certificate: dict[str, Any], claim: dict[str, Any]) -> bool:
    """Whether the checker finds a claim true that stands alone in a certificate."""
    certificate["claims"] = [claim | {"by": "T13", "assumptions": []}]
    [found] = [f.true for f in checker.check(raw(complete(certificate))).findings if f.statement.startswith("claims[")]
    return bool(found)


@pytest.mark.parametrize("block", range(BLOCKS))
def test_the_greatest_ratio_and_where_it_is_attained(block: int) -> None:
    for seed in SEEDS[block::BLOCKS]:
        p = Policy(tiers.fresh(seed))
        certificate = write(p)
        for local in (True, False):
            values = {case: by_steps(case) for case in compared(p, local)}
            if not values:
                continue
            for case, value in values.items():
                assert p.n ** len(case.p) > 300 or by_enumeration(case) == value
            greatest = max(values.values())
            claim = {"quantity": f"{'local' if local else 'global'}_ratio_supremum", "relation": "=", "scope": POLICIES}

            def true(value: Any, attained: Any, claim: dict[str, Any] = claim, certificate: dict[str, Any] = certificate) -> bool:
                return accepted(certificate, claim | {"value": text(value), "evidence": {"attained": attained}})

            assert true(greatest, None) == (greatest == 1)
            for case, value in values.items():
                attains = value == greatest != 1
                assert true(greatest, place(p, case)) == attains, (seed, case)
                if attains and greatest != INF:
                    assert not true(greatest + TINY, place(p, case)) and not true(greatest - TINY, place(p, case))
                assert value == greatest or not true(value, place(p, case))


@given(
    st.lists(st.tuples(st.integers(0, 99), st.integers(0, 99)), min_size=1, max_size=40),
    st.lists(st.tuples(st.integers(0, 9), st.integers(0, 9)), min_size=1, max_size=4),
    st.fractions(0, 9),
)
def test_quick_bounds_are_not_below_what_they_bound(pairs: Any, worth: Any, k: Any) -> None:
    """They take the place of a law of likelihood ratios, and give no less of the greatest p - k q."""
    rest = sum(p for p, _ in pairs) - sum(q for _, q in pairs)
    pairs = [*pairs, (max(0, -rest) + 1, max(0, rest) + 1)]

    def total(classes: Any) -> Fraction:
        return sum((max(p * x - k * q * y for x, y in worth) for p, q in classes), Fraction(0))

    law = checker.likelihoods.PairLaw(checker.filters.by_likelihood_ratio(pairs))
    for classes, unit in (law.outer, law.finer):
        assert total(classes) / unit >= total(pairs) / law.unit
        assert all(p >= 0 and q >= 0 for p, q in classes)
        assert sum(p for p, _ in classes) >= unit >= sum(q for _, q in classes)
