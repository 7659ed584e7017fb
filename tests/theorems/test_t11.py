"""T11: an audit as a refutation."""

from __future__ import annotations

from math import inf

import pytest
from theorem_oracle import F, deployments, pure, ratio

from fairaudit.errors import InputError
from fairaudit.theorems.t11 import t11_refutes


@pytest.mark.parametrize("uses", ["context", "decision"])
def test_a_true_claim_is_never_refuted(uses: str) -> None:
    for _, d in deployments(250, uses=uses):
        assert not t11_refutes(d.local, pure(d.rows_a))


def test_a_false_claim_can_be() -> None:
    refuted = 0
    for _, d in deployments(250, uses="context"):
        e = pure(d.rows_a)
        if e != inf and e > 1:
            refuted += t11_refutes(d.local, (1 + e) / 2)
    assert refuted > 10


def test_a_utility_of_the_group_refutes_nothing() -> None:
    """Such a utility has ratios above e^ε under filters that keep their promise."""
    assert any(d.local > pure(d.rows_a) for _, d in deployments(100, uses="group"))


def test_ends() -> None:
    assert not t11_refutes(ratio(F(0), F(0)), 1)
    assert t11_refutes(ratio(F(1), F(0)), 10**6)
    assert not t11_refutes(inf, inf)
    assert not t11_refutes(2, 2)
    assert not t11_refutes("0.3", 1)
    with pytest.raises(InputError):
        t11_refutes(-1, 2)
    with pytest.raises(InputError):
        t11_refutes(2, "0.5")
