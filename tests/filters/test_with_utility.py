"""Filters behind which no policy exceeds a target: as good as the linear program over all deterministic policies says, and on target."""

from __future__ import annotations

import json
import random
from fractions import Fraction
from itertools import permutations, product
from math import lcm
from pathlib import Path
from typing import Any

import pytest
import tiers
from envelopes import result_of
from theorem_oracle import best_in_range
from worst_policy_oracle import Setting, by_linear_program, random_utility

import fairaudit as fa
from fairaudit import InputError
from fairaudit.cli import main
from fairaudit.filters.design_result import Design
from fairaudit.filters.model_free import design_model_free
from fairaudit.filters.with_utility import design_utility
from fairaudit.model.mechanism_file import read_mechanism
from fairaudit.theorems.bound import ANY_POLICY, ANY_UTILITY, ANY_UTILITY_FLOORED

ppl = pytest.importorskip("ppl", reason="the Parma Polyhedra Library has wheels for Linux only")

F = Fraction
CASES = 600 if tiers.FULL else 40

Requirement = list[Fraction]
"""Coefficients of the entries of a table, row by row; their sum is at most 0."""


def cheapest(size: int, prices: Requirement, requirements: list[Requirement]) -> Fraction | None:
    """The least cost of a table that keeps all requirements, by an exact linear program."""
    program = ppl.MIP_Problem(size * size)
    entries = [ppl.Variable(v) for v in range(size * size)]

    def total(row: Requirement) -> Any:
        bottom = lcm(*(v.denominator for v in row))
        return sum((int(v * bottom) * entry for v, entry in zip(row, entries, strict=True)), ppl.Linear_Expression(0))

    for entry in entries:
        program.add_constraint(entry >= 0)
    for a in range(size):
        program.add_constraint(sum(entries[a * size : (a + 1) * size], ppl.Linear_Expression(0)) == 1)
    for row in requirements:
        program.add_constraint(total(row) <= 0)
    program.set_objective_function(total(prices))
    program.set_optimization_mode("minimization")
    if not program.is_satisfiable():
        return None
    value = program.optimal_value()
    return F(int(value.numerator), int(value.denominator)) / lcm(*(v.denominator for v in prices))


def requirement(size: int, first: int, second: int, gains: list[Fraction], losses: list[Fraction], target: Fraction) -> Requirement:
    """One policy: what it brings the first group, less the target times what it brings the second."""
    row = [F(0)] * (size * size)
    for j, (gain, loss) in enumerate(zip(gains, losses, strict=True)):
        row[first * size + j] += gain
        row[second * size + j] -= target * loss
    return row


def of_all_policies(size: int, tables: list[list[list[Fraction]]], target: Fraction) -> list[Requirement]:
    """Of every deterministic policy and every ordered pair of groups; tables[block][group][decision], policies see block and release."""
    found = []
    choices = list(product(range(len(tables[0][0])), repeat=size * len(tables)))
    for (first, second), choice in product(permutations(range(size), 2), choices):
        taken = [choice[i * size : (i + 1) * size] for i in range(len(tables))]
        gains, losses = (
            [sum((block[a][u[j]] for block, u in zip(tables, taken, strict=True)), F(0)) for j in range(size)] for a in (first, second)
        )
        found.append(requirement(size, first, second, gains, losses, target))
    return found


def rows_of(found: Design) -> list[list[Fraction]]:
    mechanism = found.mechanism
    assert mechanism is not None
    rows = [[mechanism.probability(a, b) for b in mechanism.inputs] for a in mechanism.inputs]
    assert all(sum(row) == 1 and min(row) >= 0 for row in rows)
    return rows


def near_the_best(found: Design, best: Fraction) -> None:
    """The optimum lies between the bound and the filter, and both are close."""
    assert found.lower_bound is not None and found.distortion is not None
    assert found.lower_bound <= best <= found.distortion < best + F(1, 10**8)
    assert best - found.lower_bound < F(1, 10**8)
    assert found.response_distortion is None or found.distortion <= found.response_distortion


def some_policy(groups: int, contexts: int, decisions: int) -> fa.Policy:
    row = [1, *[0] * (decisions - 1)]
    names = [f"u{i}" for i in range(decisions)]
    table = [[row] * groups] * contexts
    return fa.Policy.from_array(
        table, decisions=names, groups=[f"g{i}" for i in range(groups)], contexts=[f"x{i}" for i in range(contexts)]
    )


@pytest.mark.parametrize("uses", ["decision", "context", "group"])
@pytest.mark.parametrize("quantity", ["local", "global"])
def test_a_known_utility_against_the_program_over_all_policies(uses: str, quantity: Any) -> None:
    rng = random.Random(tiers.fresh(f"{uses} {quantity}"))
    kept = missed = 0
    for _ in range(CASES):
        groups, contexts, decisions = rng.choice([(2, 1, 2), (2, 1, 3), (2, 2, 2), (3, 1, 2), (3, 1, 3), (3, 2, 2)])
        utility = random_utility(rng, uses, contexts, groups, decisions)
        population = [[F(rng.randint(1, 3)) for _ in range(groups)] for _ in range(contexts)]
        costs = [[F(rng.randint(0, 3)) if a != b else F(0) for b in range(groups)] for a in range(groups)]
        target = 1 + F(rng.randint(0, 60), 20)
        policy = some_policy(groups, contexts, decisions)
        worth = fa.Utility.from_function(lambda u, x, a, g=utility: g[int(x[0][1:])][int(a[0][1:])][int(u[1:])], policy.law)
        found = design_utility(policy, worth, max_ratio=target, quantity=quantity, population=population, distortion=costs)
        mass = [sum(row[a] for row in population) for a in range(groups)]
        if quantity == "local":
            asked = [row for block in utility for row in of_all_policies(groups, [block], target)]
        else:
            shares = [
                [[row[a] / mass[a] * v for v in block[a]] for a in range(groups)] for row, block in zip(population, utility, strict=True)
            ]
            asked = of_all_policies(groups, shares, target)
        prices = [mass[a] / sum(mass) * costs[a][b] for a in range(groups) for b in range(groups)]
        best = cheapest(groups, prices, asked)
        assert found.feasible == (best is not None)
        assert (found.quantity, found.scope) == (quantity, ANY_POLICY)
        if best is None:
            missed += 1
            assert "hides the group" in found.reason
            continue
        kept += 1
        near_the_best(found, best)
        worst = max(by_linear_program(sums) for *_, sums in Setting([rows_of(found)], utility, None, population).sums(quantity))
        assert worst == found.achieved <= target
    assert tiers.enough(kept > CASES // 4)
    assert missed or uses == "decision" or (uses, quantity) == ("context", "local")


def test_a_range_against_the_program_over_all_utilities() -> None:
    """K + (γ − K − m)·H_{R*} ≤ m·(R* − 1): every set of releases at which the most is paid is a requirement."""
    rng = random.Random(tiers.fresh("range"))
    kept = missed = 0
    for _ in range(CASES):
        groups, target = rng.choice([2, 3, 4]), 1 + F(rng.randint(0, 60), 20)
        gamma = F(rng.randint(1, 9), rng.randint(1, 3))
        least = gamma * F(rng.choice([0, rng.randint(1, 9), rng.randint(1, 9)]), 10)
        gap = min(gamma - least, rng.choice([F(0), *(F(rng.randint(*part), 10) * least * (target - 1) for part in ((1, 9), (11, 15)))]))
        population = [rng.randint(1, 4) for _ in range(groups)]
        found = design_model_free(groups, max_ratio=target, gamma=gamma, g_min=least, lipschitz=gap, population=population)
        asked = []
        for (first, second), paid in product(permutations(range(groups), 2), product([0, 1], repeat=groups)):
            losses = [least + taken * (gamma - gap - least) for taken in paid]
            asked.append(requirement(groups, first, second, [v + gap for v in losses], losses, target))
        prices = [F(population[a] * (a != b), sum(population)) for a in range(groups) for b in range(groups)]
        best = cheapest(groups, prices, asked)
        assert found.feasible == (best is not None)
        if best is None:
            missed += 1
            assert f"differs between groups by {gap}" in found.reason
            continue
        kept += 1
        near_the_best(found, best)
        rows = rows_of(found)
        worst = max(best_in_range(rows[a], rows[b], gamma, least, gap, F(0)) for a, b in permutations(range(groups), 2))
        assert worst <= found.achieved <= target
        assert worst == found.achieved or not least + gap  # a bound by ε alone may not be attained
        assert found.scope == (ANY_UTILITY if least or gap else ANY_POLICY)
    assert tiers.enough(min(kept, missed) >= CASES // 20)


def test_equal_groups_need_randomized_response_in_closed_form() -> None:
    """The closed form of calibration, without its grid; for 64 groups no linear program is asked."""
    for found in (
        design_model_free(64, max_ratio="6/5", g_min="0.3"),
        design_utility(some_policy(64, 2, 2), {"u0": 10, "u1": 3}, max_ratio="6/5"),
    ):
        assert (found.truth_kept, found.achieved, found.method) == (F(11, 107), F(6, 5), "randomized response, exactly solved")
        assert found.lower_bound == found.distortion == F(96, 107)
    capped = design_model_free(3, max_ratio=2, g_min="0.3", max_exp_epsilon="3/2")
    assert (capped.exp_epsilon, capped.truth_kept) == (F(3, 2), F(3, 7))
    nothing = design_model_free(3, max_ratio=4, g_min="0.3", population=[1, 2, 3])
    assert (nothing.truth_kept, nothing.achieved) == (1, F(10, 3))


@pytest.mark.parametrize("seed", range(6))
def test_a_floor_with_a_least_utility_and_a_gap(seed: int) -> None:
    """On target by linear programs; more truth than without the floor, and no less than with a lower one."""
    rng = random.Random(tiers.fresh(seed))
    groups, target = rng.choice([2, 3]), F(rng.randint(24, 40), 20)
    least, gap = F(rng.randint(0, 2), 10), F(rng.choice([0, rng.randint(1, 2)]), 40)
    options: dict[str, Any] = {
        "g_min": least,
        "lipschitz": gap,
        "max_ratio": target,
        "population": [rng.randint(1, 4) for _ in range(groups)],
    }
    kept = [F(0)]
    for tau in (F(0), F(3, 10), F(9, 20)):
        found = design_model_free(groups, tau=tau, **options)
        if not found.feasible:
            assert gap > max(least, tau) * (target - 1)
            continue
        rows = rows_of(found)
        worst = max(best_in_range(rows[a], rows[b], F(1), least, gap, tau) for a, b in permutations(range(groups), 2))
        assert worst <= found.achieved <= target
        assert found.scope == (ANY_UTILITY_FLOORED if tau else ANY_UTILITY if least or gap else ANY_POLICY)
        assert found.truth_kept is not None and found.truth_kept > kept[-1] - F(1, 10**9)
        kept.append(found.truth_kept)
    assert len(kept) > 2


def test_refusals() -> None:
    policy = some_policy(2, 1, 2)
    with pytest.raises(InputError, match="neither a target nor a cap"):
        design_utility(policy, {"u0": 1})
    with pytest.raises(InputError, match="quantity"):
        design_utility(policy, {"u0": 1}, max_ratio=2, quantity="both")  # type: ignore[arg-type]
    with pytest.raises(InputError, match="g_min is 2, above gamma"):
        design_model_free(2, max_ratio=2, g_min=2)
    with pytest.raises(InputError, match="lipschitz"):
        design_model_free(2, max_ratio=2, lipschitz=-1)
    with pytest.raises(InputError, match="variables besides the filter"):
        design_model_free(40, max_ratio=2, g_min="0.1", population=range(40))
    assert design_utility(policy, {"u0": 1}, max_exp_epsilon=3).achieved == 3


AUDIT = '[policy]\ntable = "policy.csv"\ndecision = "choice"\ngroup = "sex"\ncontext = "place"\nprobability = "p"\n[population]\n'
AUDIT += 'table = "people.csv"\nweight = "n"\n[utility]\nvalues = {hire = 3, pass = 1}\n'


@pytest.fixture
def audit(tmp_path: Path) -> str:
    (tmp_path / "policy.csv").write_text("place,sex,choice,p\nnorth,f,hire,1\nnorth,f,pass,0\nnorth,m,hire,1\nnorth,m,pass,0\n")
    (tmp_path / "people.csv").write_text("place,sex,n\nnorth,f,1\nnorth,m,3\n")
    (tmp_path / "audit.toml").write_text(AUDIT)
    return str(tmp_path / "audit.toml")


def test_the_command_guards_every_policy_or_this_one(audit: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """This policy hires everybody, and needs no filter; with f : m as 1 : 3 every policy is on target where x + 7/5·y ≥ 4/5 both ways."""
    out = str(tmp_path / "filter.csv")
    for options in (["--bound", "exact"], ["--bound", "exact", "--global"]):
        assert main(["design", audit, "--max-ratio", "7/5", *options, "-o", out, "--format", "json"]) == 0
        (found,) = result_of(capsys.readouterr().out)["found"]
        assert (found["truth_kept"], found["achieved_ratio"], found["scope"]) == ("4/5", "7/5", ANY_POLICY)
        assert found["quantity"] == ("global" if "--global" in options else "local")
        assert read_mechanism(out).probability("f", "m") == F(4, 5)
    for options in ([], ["--bound", "policy"]):
        assert main(["design", audit, "--max-ratio", "7/5", *options]) == 0
        said = capsys.readouterr().out
        assert "100.0000%" in said and "this law" in said
    assert main(["design", audit, "--max-ratio", "7/5", "--g-min", "1"]) == 0
    assert "any utility of the declared range" in capsys.readouterr().out
    assert main(["design", "--groups", "64", "--max-ratio", "6/5", "--g-min", "0.3"]) == 0
    assert "10.2804%" in capsys.readouterr().out


@pytest.mark.parametrize(
    ("options", "word"),
    [
        (["--groups", "3", "--bound", "policy"], "--bound policy needs an audit file"),
        (["--groups", "3", "--global"], "--global goes with an audit file and --bound exact"),
        (["AUDIT", "--global"], "--global goes with an audit file and --bound exact"),
        (["AUDIT", "--bound", "policy", "--tau", "0.5"], "--tau does not go with --bound policy"),
        (["AUDIT", "--g-min", "2"], "--g-min is 2, but the utility of the audit file has 1"),
        (["AUDIT", "--tau", "1", "--gamma", "2"], "--gamma is 2, but the utility of the audit file has 3"),
        (["AUDIT", "--bound", "exact", "--gamma", "3"], "--gamma goes with --tau, --g-min or --lipschitz"),
        (["--groups", "3", "--g-min", "2"], "above gamma"),
    ],
)
def test_options_that_contradict_each_other(audit: str, options: list[str], word: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["design", "--max-ratio", "2", *(audit if option == "AUDIT" else option for option in options)]) == 2
    out, err = capsys.readouterr()
    assert word in err and out == ""


def test_the_filter_is_certified_for_any_policy(audit: str, tmp_path: Path) -> None:
    """From design to a certificate that states the greatest ratio of any policy, which is the target."""
    out, certificate = str(tmp_path / "filter.csv"), tmp_path / "c.json"
    assert main(["design", audit, "--max-ratio", "7/5", "--bound", "exact", "-o", out]) == 0
    final = tmp_path / "final.toml"
    final.write_text(AUDIT + '[filter.group]\nkind = "table"\ntable = "filter.csv"\n')
    assert main(["certify", str(final), "-o", str(certificate), "--confidence", "none"]) == 0
    claims = json.loads(certificate.read_text())["claims"]
    (value,) = {claim["value"] for claim in claims if claim["quantity"] == "local_ratio_supremum" and claim["scope"] == ANY_POLICY}
    assert value == "7/5"
    assert main(["verify", str(certificate)]) == 0


def test_the_target_that_is_called_feasible_is() -> None:
    """All is worth 4/3 to m and 1 to f: every policy has the ratio 4/3 behind every filter, and that is no decimal."""
    policy = fa.Policy.from_array([[["1/2", "1/2"], ["1/2", "1/2"]]], decisions=["hire", "pass"], groups=["f", "m"])
    utility = fa.Utility.from_function(lambda u, x, a: F(1) if a == ("f",) else F(4, 3), policy.law)
    found = fa.calibrate_utility(policy, utility, max_ratio="1.2")
    assert "at least 1.33334 (log 0.287683) is feasible" in found.reason
    assert not fa.calibrate_utility(policy, utility, max_ratio="1.33333").feasible
    assert fa.calibrate_utility(policy, utility, max_ratio="1.33334").feasible
    assert fa.calibrate_utility(policy, utility, max_log="0.287683").feasible
