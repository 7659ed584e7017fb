"""A claimed ε, and an effect beside a noise floor."""

from __future__ import annotations

from math import comb
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from interval_oracle import (
    F,
    binary,
    one_block,
    recheck,
)

from fairaudit import Law, Utility, read_csv
from fairaudit.errors import InputError
from fairaudit.inference.comparisons import Comparison
from fairaudit.inference.hypothesis_tests import noise_floor, refute_epsilon
from fairaudit.inference.ratio_intervals import default_region
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


def refuted(draws: Comparison, claimed: Any, confidence: str = "0.95", *, independent: bool = True) -> bool:
    region = default_region(draws, independent=independent, alpha=1 - F(confidence))
    return refute_epsilon(draws, claimed, confidence, region=region, independent=independent).refuted


@pytest.mark.parametrize("confidence", ["0.6", "0.95"])
def test_a_true_claim_is_refuted_no_more_often_than_the_level(confidence: str) -> None:
    """All outcomes of randomized response of e^ε = 3, where the decision is what was released, and of policies that tell less of it."""
    n, m = 7, 5
    found = {(k, j): refuted(one_block(binary(n, k), binary(m, j)), 3, confidence) for k in range(n + 1) for j in range(m + 1)}
    chances = []
    for told, lied in ((1.0, 0.0), (0.9, 0.0), (0.3, 0.0), (1.0, 0.2), (0.0, 0.9)):  # P(yes) given either release
        p, q = 0.75 * told + 0.25 * lied, 0.25 * told + 0.75 * lied
        outcomes = {
            (k, j): comb(n, k) * p**k * (1 - p) ** (n - k) * comb(m, j) * q**j * (1 - q) ** (m - j) for k, j in found if found[k, j]
        }
        chances.append(sum(outcomes.values()))
    assert max(chances) <= 1 - float(confidence) and (confidence == "0.95" or max(chances) > 0.05)


def test_a_false_claim_is_refuted_more_often_by_pairs() -> None:
    """The same filter claims 3/2."""
    pick = np.random.default_rng(3)
    runs = [
        one_block(binary(60, int(k)), binary(60, int(j)))
        for k, j in zip(pick.binomial(60, 0.75, 60), pick.binomial(60, 0.25, 60), strict=True)
    ]
    by_pairs, by_box = (sum(refuted(draws, "3/2", independent=independent) for draws in runs) for independent in (True, False))
    assert by_pairs >= 50 and by_box <= 42


def test_decisions_through_one_release_are_one_draw() -> None:
    """Five releases of each group, ten decisions through each: as rows they refute a true claim, as units with no more than the level."""
    pick, by_rows, by_units, count = np.random.default_rng(4), 0, 0, 40
    for _ in range(count):
        log: dict[str, list[str]] = {"u": [], "a": [], "release": []}
        for number, group in enumerate("fm" * 5):
            released = group if pick.random() < 0.75 else "mf"["fm".index(group)]
            for answer in pick.random(10) < (0.95 if released == "f" else 0.05):
                for name, value in (("u", "yes" if answer else "no"), ("a", group), ("release", str(number))):
                    log[name].append(value)
        rows, units = (Law.from_log(log, decision="u", group="a", **options) for options in ({}, {"unit": "release"}))  # type: ignore[arg-type]
        by_rows += refuted(local_comparison(rows, Utility({"yes": 1}).on(rows)), 3)
        by_units += refuted(local_comparison(units, Utility({"yes": 1}).on(units)), 3, "0.9")
    assert by_rows >= count / 5 and by_units <= count / 10 + 6


def test_it_says_what_counts_as_a_release() -> None:
    law = Law.from_array([[900, 100], [100, 900]], kind="counts", decisions=["yes", "no"], groups=["f", "m"])
    found = refute_epsilon(local_comparison(law, Utility({"yes": 1}).on(law)), 2)
    assert found.sentence.endswith(
        "Every decision counts as one release of the filter; if some shared a release, name it as the sampling unit (--unit)."
    )
    assert any("fresh for each decision" in text for text in found.assumptions) and set(found.interval.assumptions) < {*found.assumptions}
    law = Law.from_log({"u": list("yyn"), "a": list("ffm"), "release": [1, 1, 2]}, decision="u", group="a", unit="release")
    found = refute_epsilon(local_comparison(law, Utility({"y": 1}).on(law)), 2)
    assert found.sentence.endswith("Every unit of column 'release' counts as one release of the filter, however many decisions it has.")


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
