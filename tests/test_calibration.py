"""Calibration: the guarantee holds at the returned filter, the next one breaks it, infeasible exactly when the theory says."""

from __future__ import annotations

import os
import random
from fractions import Fraction
from itertools import product
from math import inf
from pathlib import Path
from typing import Any

import pytest

import fairaudit as fa
from fairaudit import InputError, bounds
from fairaudit.calibration import SPLITS, calibrate, calibrate_policy
from fairaudit.cli import main
from fairaudit.exact import compare_log
from fairaudit.privacy import pair_laws, power

F = Fraction
SETTINGS = int(os.environ.get("FAIRAUDIT_SETTINGS", "600"))
"""Random settings per rule; the full suite runs 10,000: FAIRAUDIT_SETTINGS=10000 pytest tests/test_calibration.py"""


def response_factor(keep: Fraction, k: int) -> Any:
    """e^ε of k-ary randomized response, by its definition."""
    lie = (1 - keep) / (k - 1)
    return inf if lie == 0 else max(keep / lie, lie / keep) if keep else inf


def worst_ratio(keep: Fraction, k: int, t: Fraction) -> Fraction:
    """Greatest ratio over all policies with floor t behind k-ary randomized response: the closed form of T3, worked out by regime."""
    lie = (1 - keep) / (k - 1)
    if t <= lie:
        return keep / lie
    if t <= 1 - keep:
        return 1 + (keep - lie) / t
    return (1 - lie / keep * (1 - t)) / t


@pytest.mark.parametrize(("k", "keep", "paper"), [(16, 0.125, 0.075), (64, 0.081, 0.019)])
def test_the_lever_of_the_paper_and_ours(k: int, keep: float, paper: float) -> None:
    found = calibrate(target_local="0.2", groups=k, tau="0.3")
    assert round(float(found.keep_probabilities[0]), 3) == keep
    assert round(float(found.paper_keep_probabilities[0]), 3) == paper
    realised = worst_ratio(found.keep_probabilities[0], k, F(3, 10))
    assert found.achieved == realised == max(power(pair, F(3, 10))[0] for pair in pair_laws(found.mechanism)) / F(3, 10)
    assert compare_log((realised.numerator, realised.denominator), (2, 10)) <= 0
    assert compare_log((realised.numerator, realised.denominator), (199, 1000)) > 0


@pytest.mark.parametrize("rule", ["paper", "tight", "sharp", "mechanism", "contraction"])
def test_random_settings(rule: Any) -> None:
    """The formulas of the theory, solved for e^ε, against the search."""
    rng = random.Random(rule)
    for _ in range(SETTINGS):
        k = rng.choice([2, 3, 5, 16, 64])
        gamma = F(rng.randint(1, 20), rng.randint(1, 4))
        tau = gamma * F(rng.randint(1, 99), 100)
        delta = F(0) if rule in ("mechanism", "contraction") else rng.choice([F(0), F(rng.randint(1, 30), 100)])
        gap = F(0) if rule in ("sharp", "contraction", "mechanism") else rng.choice([F(0), gamma * F(rng.randint(1, 20), 100)])
        target = 1 + F(rng.randint(1, 300), 100) ** rng.choice([1, 3]) / rng.choice([1, 10])
        raw = 1 + F(rng.randint(1, 900), 100)
        options = {"raw_ratio": raw} if rule == "contraction" else {"tau": tau, "delta": delta, "lipschitz": gap}
        found = calibrate(target_local_ratio=target, groups=k, gamma=gamma, bound=rule, **options)
        t, excess = tau / gamma, (gap + delta * gamma) / tau
        wanted: Any
        if rule == "contraction":
            wanted = inf if target >= raw else (target * raw - 1) / (raw - target)
        elif target * t >= 1:
            wanted = inf
        elif rule == "paper":
            wanted = target / (1 + excess)
        elif rule == "tight":
            wanted = target - excess
        elif rule == "sharp":
            infeasible = target < min(1 / t, 1 + delta / t)
            wanted = 0 if infeasible else max(target - delta / t, (1 - delta - t) / (1 - t * target))
        else:
            c = t * (target - 1)
            wanted = max(target, (1 + (k - 1) * c) / (1 - c), (1 - t) / (1 - t * target))
        assert found.feasible == (wanted >= 1), (rule, k, gamma, tau, delta, gap, target)
        if not found.feasible:
            assert found.reason
            continue
        if wanted == inf:
            assert found.keep_probabilities == (1,)
            continue
        keep = found.keep_probabilities[0]
        exact = wanted / (wanted + k - 1)
        # The greatest keep probability on the grid of 1e-12, but never below 1/k.
        assert exact - F(2, 10**12) < keep <= max(exact, F(1, k))
        assert found.achieved <= target
        if keep + F(1, 10**6) < 1:
            following = response_factor(keep + F(1, 10**6), k)
            broken: Any
            if rule == "mechanism":
                broken = worst_ratio(keep + F(1, 10**6), k, t)
            elif rule == "contraction":
                broken = (1 + raw * following) / (raw + following)
            elif rule == "sharp":
                broken = bounds.t3_approx(following, delta, t).value
            else:
                broken = min(gamma / tau, following * (1 + excess) if rule == "paper" else following + excess)
            assert broken > target


@pytest.mark.parametrize("split", SPLITS)
def test_products_keep_the_target_for_every_pair_of_tuples(split: Any) -> None:
    found = calibrate(target_local_ratio="3/2", groups={"a": 2, "b": 3, "c": 2}, tau="0.2", split=split)
    mechanism = found.mechanism
    worst = F(0)
    t = F(1, 5)
    for a, b in product(mechanism.inputs, repeat=2):
        if a == b:
            continue
        pairs = sorted(
            ((F(p, mechanism.denominator), F(q, mechanism.denominator)) for p, q in zip(mechanism.row(a), mechanism.row(b), strict=True)),
            key=lambda pq: pq[0] / pq[1],
            reverse=True,
        )
        spent = gained = F(0)
        for p, q in pairs:
            part = min(F(1), (t - spent) / q) if q else F(1)
            spent, gained = spent + part * q, gained + part * p
            if spent >= t:
                break
        worst = max(worst, gained / t)
    assert worst == found.achieved <= F(3, 2)
    assert worst > F(3, 2) - F(1, 10**6)


def test_most_truth_keeps_at_least_as_much_as_the_other_splits() -> None:
    kept = {}
    for split in SPLITS:
        found = calibrate(target_local="0.5", groups={"a": 2, "b": 5, "c": 9}, tau="0.3", split=split)
        kept[split] = found.keep_probabilities[0] * found.keep_probabilities[1] * found.keep_probabilities[2]
    assert kept["most-truth"] >= max(kept.values())


def test_a_known_policy_is_calibrated_on_its_own_ratio() -> None:
    policy = fa.Policy.from_array([[["0.9", "0.1"], ["0.2", "0.8"]]], decisions=["hire", "pass"], groups=["f", "m"])
    found = calibrate_policy(policy, {"hire": 1}, target_local_ratio=2)
    keep = found.keep_probabilities[0]
    # E(f)/E(m) = (0.2 + 0.7p)/(0.9 − 0.7p) = 2 at p = 16/21.
    assert F(16, 21) - F(2, 10**12) < keep <= F(16, 21)
    assert found.achieved == (F(1, 5) + F(7, 10) * keep) / (F(9, 10) - F(7, 10) * keep) <= 2
    contraction = calibrate(target_local_ratio=2, groups=2, bound="contraction", raw_ratio="9/2")
    assert contraction.keep_probabilities[0] <= keep
    assert calibrate_policy(policy, {"hire": 1}, target_local_ratio=5).keep_probabilities == (1,)


def test_a_global_target_names_independence() -> None:
    found = calibrate(target_global="0.2", groups=3, tau="0.3")
    assert bounds.INDEPENDENT in found.assumptions
    assert found.quantity == "global"


def test_a_least_utility_serves_every_policy() -> None:
    found = calibrate(target_local_ratio="3/2", groups=2, gamma=4, g_min=1, bound="contraction")
    assert found.scope == "any policy behind this filter"
    # (1 + 4e)/(4 + e) = 3/2 at e = 2.
    assert F(2, 3) - F(2, 10**12) < found.keep_probabilities[0] <= F(2, 3)


@pytest.mark.parametrize(
    ("options", "word"),
    [
        ({"target_local": 0, "groups": 2}, "above 0"),
        ({"target_local": -1, "groups": 2}, "above 0"),
        ({"target_local_ratio": 1, "groups": 2}, "above 1"),
        ({"groups": 2}, "exactly one target"),
        ({"target_local": 1, "target_global": 1, "groups": 2}, "exactly one target"),
        ({"target_local": "x", "groups": 2}, "not a number"),
        ({"target_local": 1, "groups": 1}, "at least two"),
        ({"target_local": 1, "groups": {}}, "no attribute"),
        ({"target_local": 1, "groups": 2, "gamma": 1, "tau": 2}, "above gamma"),
        ({"target_local": 1, "groups": 2, "gamma": 0}, "gamma is 0"),
        ({"target_local": 1, "groups": 2, "delta": 2}, "from 0 to 1"),
        ({"target_local": 1, "groups": 2, "tau": -1}, "at least 0"),
        ({"target_local": 1, "groups": 2, "bound": "contraction"}, "raw_ratio"),
        ({"target_local": 1, "groups": 2, "raw_ratio": 2}, "contraction"),
        ({"target_local": 1, "groups": 2, "bound": "sharpe"}, "did you mean 'sharp'"),
        ({"target_local": 1, "groups": 2, "split": "equal"}, "split"),
        ({"target_local": 1, "groups": 2, "bound": "sharp", "lipschitz": 1}, "does not depend"),
    ],
)
def test_refusals(options: dict[str, Any], word: str) -> None:
    with pytest.raises(InputError, match=word):
        calibrate(**options)


@pytest.mark.parametrize(
    ("options", "code", "word"),
    [
        (["--target", "0.2", "--groups", "16", "--tau", "0.3"], 0, "0.12477"),
        (["--target", "0.1,0.2", "--groups", "name=2,age=3", "--tau", "0.3"], 0, "keep probability"),
        (["--target", "0.1", "--groups", "3", "--lipschitz", "0.5", "--tau", "0.2"], 1, "INFEASIBLE"),
        (["--target", "0.1", "--groups", "3", "--lipschitz", "0.5"], 1, "Without a floor"),
        (["--target", "0", "--groups", "3"], 2, "above 0"),
        (["--target", "0.1", "--groups", "3,a=2"], 2, "mixes forms"),
        (["--target", "0.1", "--groups", "a=2,a=2"], 2, "twice"),
        (["--target", "0.1", "--groups", "x"], 2, "not a number"),
        (["--target", "0.1", "--groups", "1"], 2, "at least two"),
        (["--target", "0.1"], 2, "--groups is missing"),
        (["--target", "0.1", "--bound", "policy"], 2, "needs an audit file"),
        (["--target", "0.1", "--groups", "2", "nothing.toml"], 2, "no such file|goes without"),
        (["--target", "0.1", "--groups", "2", "--tau", "2"], 2, "above gamma"),
        (["--groups", "2"], 2, "--target"),
    ],
)
def test_the_command(capsys: pytest.CaptureFixture[str], options: list[str], code: int, word: str) -> None:
    import re

    try:
        found = main(["calibrate", *options])
    except SystemExit as stop:
        found = stop.code
    out, err = capsys.readouterr()
    assert found == code
    assert re.search(word, err if code == 2 else out), (out, err)
    if code == 2:
        assert out == ""
        assert err.count("\n") == 1


def test_the_command_draws_a_picture(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    pytest.importorskip("matplotlib")
    target = tmp_path / "c.png"
    assert main(["calibrate", "--target", "0.1,0.2,0.4", "--groups", "16", "--tau", "0.3", "--plot", str(target)]) == 0
    assert target.read_bytes().startswith(b"\x89PNG")
    assert main(["calibrate", "--target", "0.1", "--groups", "16", "--plot", str(tmp_path / "c.gif")]) == 2
    assert "ends in" in capsys.readouterr().err
