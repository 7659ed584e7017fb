"""A claimed ε, and an effect beside a noise floor."""

from __future__ import annotations

from pathlib import Path

import pytest
from interval_oracle import (
    F,
    binary,
    one_block,
    recheck,
)

from fairaudit import Law, Utility, read_csv
from fairaudit.errors import InputError
from fairaudit.inference.hypothesis_tests import noise_floor, refute_epsilon
from fairaudit.inference.table_comparisons import local_comparison


def test_a_filter_is_refuted_by_draws_that_are_too_unequal() -> None:
    law = Law.from_array([[900, 100], [100, 900]], kind="counts", decisions=["yes", "no"], groups=["f", "m"])
    draws = local_comparison(law, Utility({"yes": 1}).on(law))
    assert refute_epsilon(draws, 2).refuted
    found = refute_epsilon(draws, 9)
    assert not found.refuted and "prove nothing" in found.sentence
    assert not refute_epsilon(draws, "inf").refuted
    recheck(found.interval.evidence, found.interval.lower, found.interval.upper)
    by_group = Utility.from_function(lambda u, x, a: (1 if a == ("f",) else 2) * (u == "yes"), law).on(law)
    with pytest.raises(InputError, match="depends on the group"):
        refute_epsilon(local_comparison(law, by_group), 2)
    with pytest.raises(InputError, match="at least 1"):
        refute_epsilon(draws, "0.5")


def test_noise_floor() -> None:
    quiet, loud = one_block(binary(500, 250), binary(500, 250)), one_block(binary(500, 400), binary(500, 100))
    assert noise_floor(loud, quiet).rises
    found = noise_floor(quiet, loud)
    assert not found.rises and "does not rise above" in found.sentence
    assert found.effect.confidence == F(39, 40)


def test_names_against_the_placebo(data: Path) -> None:
    names, edits = read_csv(data / "hiringbias_firstname.csv"), read_csv(data / "hiringbias_placebo.csv")
    utility = Utility({"yes": 1, "maybe": 1})
    tables = [
        Law.from_log(table, decision="recommend_interview", group=group, context="model")
        for table, group in ((names, "name"), (edits, "placebo"))
    ]
    effect, placebo = (local_comparison(law, utility.on(law)) for law in tables)
    found = noise_floor(effect, placebo)
    assert found.effect.estimate == F(3, 2)
    assert not found.rises
