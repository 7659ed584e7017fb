"""Sampled policies behind filters: forms, cells without draws, filters of several attributes."""

from __future__ import annotations

from itertools import product

from interval_oracle import (
    F,
    recheck,
    sampled_policy,
)

from fairaudit import Policy, Product, RandomizedResponse, Utility
from fairaudit.inference.policy_comparisons import policy_comparison
from fairaudit.inference.ratio_intervals import ratio_interval
from fairaudit.model.mechanism import Identity


def test_forms_are_the_induced_law() -> None:
    policy = sampled_policy()
    group = RandomizedResponse(["f", "m", "o"], keep_probability="0.6")
    context = RandomizedResponse(["P", "Q"], keep_probability="0.8")
    table = {(x, a): F(i + 1) for i, (x, a) in enumerate(product([("P",), ("Q",)], [("f",), ("m",), ("o",)]))}
    deployed = policy.behind(group=group, context=context, population=table)
    by_context = Utility.from_function(lambda u, x, a: (2 if x == ("P",) else 3) * (u == "yes"), deployed.law)
    by_group = Utility.from_function(lambda u, x, a: (2 if a == ("f",) else 3) * (u == "yes"), deployed.law)
    for utility, cells in ((Utility({"yes": 1}), 6), (by_context, 12), (by_group, 36)):
        values = utility.on(deployed.law)
        expected = {}
        for i, (x, a) in enumerate(zip(deployed.law.cell_context.tolist(), deployed.law.cell_group.tolist(), strict=True)):
            row = deployed.law.row(i)
            expected[x, a] = F(sum(w * g for w, g in zip(row, values.row(i), strict=True)), sum(row) * values.scale)
        comparison = policy_comparison(policy, utility, group, context)
        assert len(comparison.cells) == cells
        assert comparison.dependent == (cells > 6)
        for x, block in enumerate(comparison.blocks):
            for a, form in enumerate(block):
                assert sum(w * comparison.cells[i].mean for i, w in form) == expected[x, a]
        means = policy_comparison(policy, utility, group, context, table, local=False)
        for a, form in enumerate(means.blocks[0]):
            mass = [table[x, group.inputs[a]] for x in (("P",), ("Q",))]
            mean = (mass[0] * expected[0, a] + mass[1] * expected[1, a]) / sum(mass)
            assert sum(w * means.cells[i].mean for i, w in form) == mean
    found = ratio_interval(policy_comparison(policy, Utility({"yes": 1}), group, context))
    assert found.lower <= found.estimate <= found.upper
    recheck(found.evidence, found.lower, found.upper)
    identity = ratio_interval(policy_comparison(policy, Utility({"yes": 1}), Identity(["f", "m", "o"])))
    assert found.upper < identity.upper


def test_cells_without_draws_are_the_whole_range() -> None:
    group = RandomizedResponse(["f", "m", "o"], keep_probability="0.6")
    whole = policy_comparison(sampled_policy(), Utility({"yes": 1}), group)
    lacking = policy_comparison(sampled_policy(("Q", "m")), Utility({"yes": 1}), group)
    assert [c.draws for c in lacking.cells].count(0) == 1
    first, second = ratio_interval(whole), ratio_interval(lacking)
    assert second.upper > first.upper
    assert second.estimate is None
    recheck(second.evidence, second.lower, second.upper)


def test_attributes_filtered_apart() -> None:
    cells = {"x": ["P"] * 8, "s": list("ffffmmmm"), "g": list("aabbaabb"), "u": ["yes", "no"] * 4, "n": [30, 10, 20, 20, 10, 30, 15, 25]}
    policy = Policy.from_counts(cells, decision="u", group=["s", "g"], context="x", count="n")
    parts = {"s": RandomizedResponse(["f", "m"], keep_probability="0.7"), "g": RandomizedResponse(["a", "b"], keep_probability="0.9")}
    comparison = policy_comparison(policy, Utility({"yes": 1}), Product(parts))
    assert comparison.span == 4 == len(comparison.used)
    recheck(ratio_interval(comparison).evidence, *[getattr(ratio_interval(comparison), k) for k in ("lower", "upper")])
