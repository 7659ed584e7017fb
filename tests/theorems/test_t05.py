"""T5: the global ratio."""

from __future__ import annotations

from math import inf

import pytest
from theorem_oracle import Deployment, F, deployments, proved, pure, stick, table_filter

from fairaudit.errors import InputError
from fairaudit.measures.ratios import global_fairness, local_fairness
from fairaudit.model.law import Law
from fairaudit.model.mechanism import Constant, Mechanism
from fairaudit.model.utility import Utility
from fairaudit.theorems.bound import Bound
from fairaudit.theorems.t02 import t2
from fairaudit.theorems.t03 import t3_mechanism
from fairaudit.theorems.t05 import context_ratio, t5_decision, t5_floor, t5_general, t5_independent


def contexts_filter(d: Deployment) -> Mechanism:
    return Mechanism.from_array(d.rows_x, list(d.contexts), [f"r{j}" for j in range(len(d.rows_x[0]))])


def spread(rows: list[list[F]]) -> F | float:
    return pure(rows)


def test_independence_makes_the_local_ratio_bound_the_global_one() -> None:
    for _, d in deployments(200, independent=True):
        bound = t5_independent(d.local)
        assert d.overall <= bound.value
        law, _ = d.audited()
        assert law.independent


def test_without_independence_fair_contexts_can_be_globally_unfair() -> None:
    law = Law.from_array([[[1, 0], [1, 0]], [[0, 1], [0, 1]]], population=[[3, 1], [1, 3]], decisions=["yes", "no"])
    utility = Utility({"yes": 1}).on(law)
    local, overall = local_fairness(law, utility), global_fairness(law, utility)
    assert local is not None and overall is not None
    assert (local.ratio, overall.ratio) == (1, 3)
    assert not law.independent
    assert "context and group are independent in the population" in t5_independent(local.ratio).assumptions
    assert t5_general(law, utility).value >= overall.ratio


def test_bounds_carry_over_with_their_evidence() -> None:
    bound = t5_independent(t2(3))
    assert (bound.quantity, bound.value, bound.multipliers) == ("global_ratio", 3, (3,))
    assert bound.scope == "any policy behind this filter"
    with pytest.raises(InputError):
        t5_independent(bound)


@pytest.mark.parametrize("uses", ["group", "decision"])
def test_the_general_form_bounds_the_global_ratio(uses: str) -> None:
    for _, d in deployments(200, uses=uses):
        law, utility = d.audited()
        table = utility.on(law)
        shares = [[d.share(x, a) for x in d.contexts] for a in d.groups]
        weighted = [[d.share(x, a) * d.expectation(x, a) for x in d.contexts] for a in d.groups]
        bound = t5_general(law, table)
        assert d.overall <= bound.value == spread(weighted)
        assert context_ratio(law) == spread(shares)
        assert bound.value <= d.local * spread(shares)


def test_decision_utilities_are_bounded_by_both_filters() -> None:
    for _, d in deployments(250, uses="decision"):
        law, utility = d.audited()
        released = [[sum((d.share(x, a) * d.rows_x[x][j] for x in d.contexts), F(0)) for j in range(len(d.rows_x[0]))] for a in d.groups]
        exact = context_ratio(law, contexts_filter(d))
        assert exact == spread(released)
        e, e_x = pure(d.rows_a), pure(d.rows_x)
        assert exact <= min(e_x, context_ratio(law))
        tight = t5_decision(e, utility.on(law), released_ratio=exact)
        loose = t5_decision(e, utility.on(law), exp_epsilon_context=e_x, context_ratio=context_ratio(law))
        assert d.overall <= tight.value <= loose.value
        assert tight.value == e * exact


def test_the_context_filter_does_not_bound_a_utility_of_the_context() -> None:
    """Nothing about the context is released, ε_A = 0, and the groups' contexts differ: with g(u,x) = x the global ratio is 9."""
    law = Law.from_array([[[1], [1]], [[1], [1]]], population=[[1, 9], [9, 1]], decisions=["go"])
    by_context = Utility.from_function(lambda u, x, a: int(x[0]), law).on(law)
    overall = global_fairness(law, by_context)
    assert overall is not None
    assert overall.ratio == 9
    assert t5_decision(1, Utility({"go": 1}).on(law), exp_epsilon_context=1).value == 1
    with pytest.raises(InputError, match="decision alone"):
        t5_decision(1, by_context, exp_epsilon_context=1)


def test_the_filter_of_the_group_alone_leaves_the_composition() -> None:
    """ε_A = 0 and contexts released as they are: what remains is the composition of the groups."""
    law = Law.from_array([[[1, 0], [1, 0]], [[0, 1], [0, 1]]], population=[[3, 1], [1, 3]], decisions=["yes", "no"])
    bound = t5_decision(1, Utility({"yes": 1}).on(law), context_ratio=context_ratio(law))
    assert bound.value == 3


@pytest.mark.parametrize("uses", ["context", "decision"])
def test_the_floor_under_the_means_works_on_the_joint_rows(uses: str) -> None:
    seen = 0
    for _, d in deployments(200, uses=uses):
        tau = min(d.mean(a) for a in d.groups)
        if not tau:
            continue
        seen += 1
        law, _ = d.audited()
        labels = [str(a) for a in d.groups]
        mechanism = Mechanism.from_array(d.rows_a, labels, [f"o{j}" for j in range(len(d.rows_a[0]))])
        t = tau / d.gamma
        bound = t5_floor(law, mechanism, t)
        assert d.overall <= bound.value <= 1 / t
        joint = [[d.share(x, a) * w for x in d.contexts for w in d.rows_a[a]] for a in d.groups]
        assert bound.value == t3_mechanism(table_filter(joint), t).value
        assert proved(bound, joint, lambda p, q, k, t=t: k + stick(p, q, k) / t)
    assert seen > 50


def test_the_filter_alone_would_not_do_where_contexts_differ() -> None:
    law = Law.from_array([[[1, 0], [1, 0]], [[0, 1], [0, 1]]], population=[[3, 1], [1, 3]], decisions=["yes", "no"])
    constant = Constant(["0", "1"])
    assert t3_mechanism(constant, "0.25").value == 1
    assert t5_floor(law, constant, "0.25").value == 3


def test_the_paper_example_of_filtered_contexts() -> None:
    """The global ratio goes from 1 to exactly 4 when a log 3-private filter is put on contexts that are independent of the group."""
    policy = [[[F(0), F(1)], [F(1), F(0)]], [[F(1), F(0)], [F(0), F(1)]]]
    identity = [[F(1), F(0)], [F(0), F(1)]]
    filtered = [[F(9, 10), F(1, 10)], [F(7, 10), F(3, 10)]]
    assert pure(filtered) == 3
    found = []
    for rows_x in (identity, filtered):
        d = Deployment(policy, rows_x, identity, [[[F(0), F(1)]] * 2] * 2, [[F(1, 4)] * 2] * 2, table_filter(identity))
        law, utility = d.audited()
        assert law.independent
        overall = global_fairness(law, utility.on(law))
        assert overall is not None
        assert overall.ratio == d.overall
        found.append(overall.ratio)
    assert found == [1, 4]
    bound = t5_decision(inf, utility.on(law), exp_epsilon_context=3)
    assert isinstance(bound, Bound) and bound.value == inf and bound.note


def test_ratios_of_nothing() -> None:
    law = Law.from_array([[[1, 0], [1, 0]], [[0, 1], [0, 1]]], population=[[1, 0], [0, 1]], decisions=["yes", "no"])
    assert context_ratio(law) == inf
    assert t5_general(law, Utility({"yes": 0}).on(law)).value == 1
