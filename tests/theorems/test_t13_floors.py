"""T13 with floors: against exact linear programs, and judged by the rule of the certificate, written out.

All random settings: FAIRAUDIT_FULL=1 pytest -n0 tests/theorems/test_t13_floors.py
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from fractions import Fraction
from itertools import permutations
from math import inf, lcm
from random import Random
from typing import Any

import numpy as np
import pytest
import tiers
from theorem_oracle import F, Row, Table, random_row, response_rows
from worst_policy_oracle import Setting, random_setting, ratio

from fairaudit.errors import InputError
from fairaudit.exact import mixtures
from fairaudit.measures.limits import Quantity
from fairaudit.model.policy import Deployment, Policy
from fairaudit.model.utility import UtilityTable
from fairaudit.privacy.columns import merged_columns
from fairaudit.theorems import t13_floors
from fairaudit.theorems.bound import FLOORED
from fairaudit.theorems.supremum import Floors, Supremum
from fairaudit.theorems.t13_exact import envelope
from fairaudit.theorems.t13_floors import greatest_ratio_above
from fairaudit.theorems.t13_one_k import least_bound

ppl = pytest.importorskip("ppl", reason="the Parma Polyhedra Library has wheels for Linux only")

Dense = list[Row]
"""Numbers by output (x̃,ã) and decision."""

Place = tuple[int | None, int, int]


@dataclass
class Case:
    """A setting, a policy T[x̃][ã][u] behind it, and floors; everything multiplied out."""

    setting: Setting
    policy: list[Table]
    floors: Floors

    @property
    def groups(self) -> range:
        return range(len(self.setting.rows_a))

    @property
    def contexts(self) -> range:
        return range(len(self.setting.utility))

    @property
    def with_mass(self) -> list[int]:
        return [a for a in self.groups if self.setting.population is None or any(row[a] for row in self.setting.population)]

    def gains(self, x: int | None, a: int) -> Dense:
        """What each decision adds to E(x,a), or to the mean of the group."""
        shares = {x: F(1)} if x is not None else {y: self.setting.share(y, a) for y in self.contexts}
        rows = self.setting.rows_a
        return [
            [
                sum((s * self.setting.released[y][xt] * rows[a][at] * self.setting.utility[y][a][u] for y, s in shares.items()), F(0))
                for u in range(len(self.setting.utility[0][0]))
            ]
            for xt in range(len(self.setting.released[0]))
            for at in range(len(rows[0]))
        ]

    def floored(self) -> dict[tuple[int | None, int], Fraction]:
        """All floors above 0."""
        floors: dict[tuple[int | None, int], Fraction] = {(x, a): self.floors.cells[x] for x in self.contexts for a in self.groups}
        floors |= {(None, a): self.floors.overall for a in self.with_mass}
        return {cell: floor for cell, floor in floors.items() if floor}

    def places(self, quantity: Quantity) -> list[Place]:
        """The compared pairs."""
        if quantity == "local":
            return [(x, a, b) for x in self.contexts for a, b in permutations(self.groups, 2)]
        return [(None, a, b) for a, b in permutations(self.with_mass, 2)]

    def subject(self) -> tuple[Deployment, UtilityTable]:
        """The policy behind the filters, as the package reads them."""
        given, table = self.setting.subject()
        law = given.policy.law
        rows = [[*block, block[0]] for block in self.policy]
        groups = [*given.group_filter.outputs, ("never",) * len(given.group_filter.outputs[0])]
        policy = Policy.from_array(rows, decisions=law.decisions, groups=groups, contexts=law.contexts)
        deployment = policy.behind(
            group=given.group_filter, context=given.context_filter, population=self.setting.population, releases=self.setting.releases
        )
        return deployment, table

    def solved(self, quantity: Quantity) -> Supremum:
        found = greatest_ratio_above(*self.subject(), quantity, self.floors)
        assert found is not None
        return found


def inner(left: Dense, right: Dense) -> Fraction:
    return sum((v * w for one, other in zip(left, right, strict=True) for v, w in zip(one, other, strict=True)), F(0))


# An exact linear program for each pair


def by_linear_program(case: Case, place: Place) -> Any:
    """The greatest ratio of the policies that keep the floors: with y = T·s and Σ q·y = 1 it is linear (Charnes and Cooper)."""
    x, a, b = place
    tops, lows = case.gains(x, a), case.gains(x, b)
    outputs, decisions = len(tops), len(tops[0])
    scale = ppl.Variable(outputs * decisions)  # s

    def linear(rows: Dense, constant: Fraction) -> tuple[Any, int]:
        bottom = lcm(constant.denominator, *(v.denominator for row in rows for v in row))
        total = ppl.Linear_Expression(0)
        for i, v in enumerate(v for row in rows for v in row):
            total = total + int(v * bottom) * ppl.Variable(i)
        return total - int(constant * bottom) * scale, bottom

    top, over = linear(tops, F(0))
    low, unit = linear(lows, F(0))
    kept = [linear(case.gains(*cell), floor)[0] for cell, floor in case.floored().items()]

    def greatest(normed: Any) -> Any:
        program = ppl.MIP_Problem(outputs * decisions + 1)
        for o in range(outputs):
            shares = [ppl.Variable(o * decisions + u) for u in range(decisions)]
            for share in shares:
                program.add_constraint(share >= 0)
            program.add_constraint(sum(shares[1:], ppl.Linear_Expression(shares[0])) == scale)
        for row in kept:
            program.add_constraint(row >= 0)
        program.add_constraint(normed)
        program.set_objective_function(top)
        program.set_optimization_mode("maximization")
        if not program.is_satisfiable():
            return None
        try:
            value = program.optimal_value()
        except ValueError:  # unbounded
            return inf
        return F(int(value.numerator), int(value.denominator) * over)

    value = greatest(low == unit)
    if value is None:  # no policy gives the second group anything
        value = inf if greatest(scale == 1) else F(1)
    return max(F(1), value)


# The rule of the certificate


def is_proved(case: Case, place: Place, found: Supremum) -> bool:
    """Whether a multiplier or the multipliers of floors prove the value for a pair."""
    x, a, b = place
    value = found.value
    assert isinstance(value, Fraction)
    tops, lows = case.gains(x, a), case.gains(x, b)
    if x is None:
        least = max(case.floors.overall, sum((case.setting.share(y, b) * floor for y, floor in enumerate(case.floors.cells)), F(0)))
    else:
        least = case.floors.cells[x]
    for k in {*found.multipliers, value}:
        total = sum(max(p - k * q for p, q in zip(*rows, strict=True)) for rows in zip(tops, lows, strict=True))
        if 0 <= k <= value and total <= (value - k) * least:
            return True
    proofs = [proof for proof in found.pairs if (proof.context, proof.higher, proof.lower) == place]
    if case.setting.releases > 1 or len(proofs) != 1:
        return False
    floors = case.floored()
    rows = [[p - value * q for p, q in zip(*both, strict=True)] for both in zip(tops, lows, strict=True)]
    for cell, y in proofs[0].floors.items():
        if y <= 0 or cell not in floors:
            return False
        rows = [[v + y * e for v, e in zip(*both, strict=True)] for both in zip(rows, case.gains(*cell), strict=True)]
    return sum(map(max, rows)) <= sum(y * floors[cell] for cell, y in proofs[0].floors.items())


def policy_of(case: Case, rows: tuple[Row, ...]) -> Dense:
    """The rows of what can be released put where everything is listed."""
    released, each = case.setting.released, case.setting.rows_a
    left = iter(rows)
    size = len(case.setting.utility[0][0])
    found = [
        list(next(left)) if any(row[xt] for row in released) and any(row[at] for row in each) else [F(1), *[F(0)] * (size - 1)]
        for xt in range(len(released[0]))
        for at in range(len(each[0]))
    ]
    assert next(left, None) is None
    return found


def check(case: Case, quantity: Quantity, found: Supremum) -> None:
    """All that a certificate would have to show."""
    deployment, _ = case.subject()
    assert (found.quantity, found.scope) == (quantity, FLOORED)
    assert found.value >= 1
    assert list(found.multipliers) == sorted(set(found.multipliers), reverse=True)
    if found.value != inf:
        assert all(is_proved(case, place, found) for place in case.places(quantity))
    bare = replace_pairs(found)
    assert not any(is_proved(case, (proof.context, proof.higher, proof.lower), bare) for proof in found.pairs)
    if not found.exact or found.value == 1:
        assert (found.context, found.higher, found.lower, found.rows) == (None, None, None, ())
        return
    assert case.setting.releases == 1
    assert found.higher is not None and found.lower is not None
    policy = policy_of(case, found.rows)
    assert all(min(row) >= 0 and sum(row) == 1 for row in policy)
    assert all(inner(policy, case.gains(*cell)) >= floor for cell, floor in case.floored().items())
    x = None if found.context is None else deployment.contexts.index(found.context)
    assert (x is None) == (quantity == "global")
    top, low = (inner(policy, case.gains(x, deployment.groups.index(label))) for label in (found.higher, found.lower))
    assert ratio(top, low) == found.value


def replace_pairs(found: Supremum) -> Supremum:
    return Supremum(found.quantity, found.value, multipliers=found.multipliers)


# Random cases


def random_case(rng: Random, uses: str, releases: int = 1) -> Case:
    """A setting, a policy of one of several kinds, and floors that it keeps, often with nothing to spare."""
    setting = random_setting(rng, uses=uses, most_groups=4, releases=releases, most_outputs=12)
    decisions, released = len(setting.utility[0][0]), setting.released
    each = len(setting.factors[0][0]) if len(setting.factors) == 1 else None
    outputs = each or len(setting.subject()[0].group_filter.outputs)
    kind = rng.choice(["random", "best", "uniform"])
    policy: list[Table] = []
    for xt in range(len(released[0])):
        policy.append([])
        for _ in range(outputs):
            row = random_row(rng, decisions) if kind == "random" else [F(1, decisions)] * decisions
            if kind == "best":
                reach = [x for x in range(len(setting.utility)) if released[x][xt]] or [0]
                worth = setting.utility[rng.choice(reach)][rng.randrange(len(setting.rows_a))]
                row = [F(int(u == worth.index(max(worth)))) for u in range(decisions)]
            policy[-1].append(row)
    case = Case(setting, policy, Floors((F(0),) * len(setting.utility)))
    single = Case(Setting(setting.factors, setting.utility, setting.rows_x, setting.population), policy, case.floors)
    flat = [row for block in policy for row in block]
    chance, part = rng.choice([0.4, 1]), rng.choice([F(1, 2), F(9, 10), F(1)])
    cells = tuple(
        part * min(inner(flat, single.gains(x, a)) for a in case.groups) if rng.random() < chance else F(0) for x in case.contexts
    )
    overall = part * min((inner(flat, single.gains(None, a)) for a in case.with_mass), default=F(0)) if rng.random() < 0.4 else F(0)
    return Case(setting, policy, Floors(cells, overall))


USES = ("decision", "context", "group", "group")

QUANTITIES: tuple[Quantity, ...] = ("local", "global")


@pytest.mark.parametrize("uses", ["decision", "context", "group"])
@pytest.mark.parametrize("quantity", ["local", "global"])
def test_the_value_is_that_of_exact_linear_programs(quantity: Quantity, uses: str) -> None:
    """Exact, attained, and proved as a certificate would have it."""
    seen: dict[str, int] = {}
    for seed in range(600 if tiers.FULL else 25):
        case = random_case(Random(tiers.fresh(f"floors {quantity} {uses} {seed}")), uses)
        found = greatest_ratio_above(*case.subject(), quantity, case.floors)
        places = case.places(quantity)
        if found is None:
            assert not places
            continue
        assert (found.value, found.exact) == (max(by_linear_program(case, place) for place in places), True)
        check(case, quantity, found)
        kind = "programs" if found.pairs else "infinite" if found.value == inf else "one" if found.value == 1 else "one k"
        seen[kind] = seen.get(kind, 0) + 1
    assert tiers.enough("one k" in seen and ("programs" in seen or (quantity, uses) == ("local", "decision"))), seen


@pytest.mark.parametrize("quantity", ["local", "global"])
def test_without_linear_programs_it_is_a_bound(quantity: Quantity, monkeypatch: pytest.MonkeyPatch) -> None:
    """As behind filters that are too large: what k prove, exact only where a policy is found that attains it."""
    monkeypatch.setattr(t13_floors, "EXACT_VARIABLES", 0)
    monkeypatch.setattr(t13_floors, "MAX_ENTRIES", -1)
    seen = set()
    for seed in range(400 if tiers.FULL else 20):
        case = random_case(Random(tiers.fresh(f"large {quantity} {seed}")), USES[seed % 4])
        found = greatest_ratio_above(*case.subject(), quantity, case.floors)
        if found is not None:
            check(case, quantity, found)
            assert not found.pairs
            value = max(by_linear_program(case, place) for place in case.places(quantity))
            assert found.value == value if found.exact else found.value >= value
            seen.add((found.exact, found.value == value))
    assert tiers.enough({(True, True), (False, False)} <= seen)


@pytest.mark.parametrize("quantity", ["local", "global"])
def test_several_releases_are_those_of_the_product_written_out(quantity: Quantity) -> None:
    seen = set()
    for seed in range(300 if tiers.FULL else 15):
        case = random_case(Random(tiers.fresh(f"releases {quantity} {seed}")), USES[seed % 4], releases=2)
        found = greatest_ratio_above(*case.subject(), quantity, case.floors)
        if found is not None:
            check(case, quantity, found)
            value = max(by_linear_program(case, place) for place in case.places(quantity))
            assert found.value == value == 1 if found.exact else found.value >= value
            seen.add((found.exact, found.value == value))
    assert tiers.enough({(True, True), (False, True)} <= seen)


@pytest.mark.parametrize("lies", [False, True])
def test_a_solver_saves_time_and_changes_nothing(monkeypatch: pytest.MonkeyPatch, lies: bool) -> None:
    monkeypatch.setattr(mixtures, "WORTH_ASKING", 0)
    if lies:
        rng = np.random.default_rng(1)
        monkeypatch.setattr(mixtures, "ask_solver", lambda c, a, b, *_: (rng.random(len(c)), rng.random(len(b)) * 9))
    programs = 0
    for seed in range(15):
        case = random_case(Random(tiers.fresh(f"asked {seed}")), "group")
        for quantity in QUANTITIES:
            if case.places(quantity):
                found = case.solved(quantity)
                check(case, quantity, found)
                programs += len(found.pairs)
                assert found.value == max(by_linear_program(case, place) for place in case.places(quantity))
    assert tiers.enough(programs)


# Numbers that are known


SEVEN_TENTHS = [[F(7, 10), F(3, 10)], [F(3, 10), F(7, 10)]]

EVEN = [[F(1, 2), F(1, 2)]] * 2


def test_one_floor_of_the_theory_page() -> None:
    case = Case(Setting([SEVEN_TENTHS], [[[F(0), F(1)]] * 2]), [EVEN], Floors((F(1, 2),)))
    found = case.solved("local")
    check(case, "local", found)
    assert (found.value, found.exact, found.pairs) == (F(11, 7), True, ())
    assert [found.value - k for k in found.multipliers] == [F(8, 7)]


def test_floors_in_two_contexts_of_the_theory_page() -> None:
    """Behind a filter that says nothing of the context one k proves only 2 for the lower floors."""
    crossed = [[[F(0), F(1)]] * 2, [[F(1), F(0)]] * 2]
    for floor, value in ((F(2, 5), F(3, 2)), (F(1, 2), F(1))):
        case = Case(Setting([response_rows(2, F(3, 4))], crossed, [[F(1)], [F(1)]]), [EVEN], Floors((floor, floor)))
        found = case.solved("local")
        check(case, "local", found)
        assert (found.value, found.exact) == (value, True)
        proofs = {(proof.context, proof.higher, proof.lower): proof.floors for proof in found.pairs}
        assert set(proofs) == set(case.places("local"))
        if value > 1:
            assert proofs[0, 0, 1] == {(0, 1): F(3, 2), (1, 0): F(1)}
        alone = Case(Setting([response_rows(2, F(3, 4))], crossed[:1]), [EVEN], Floors((floor,)))
        assert alone.solved("local").value == (2 if value > 1 else F(5, 3))


def test_infinite_ratios() -> None:
    """A floor elsewhere leaves an infinite ratio as it is, but behind a filter that joins the contexts it may not."""
    identity = [[F(1), F(0)], [F(0), F(1)]]
    same = [[[F(0), F(1)]] * 2] * 2
    for rows_x, value in ((None, inf), ([[F(1)], [F(1)]], F(2))):
        case = Case(Setting([identity], same, rows_x), [EVEN] * (2 if rows_x is None else 1), Floors((F(0), F(1, 2))))
        found = case.solved("local")
        check(case, "local", found)
        assert (found.value, found.exact, found.context) == (value, True, ("c.0",))
    overall = Case(Setting([identity], same), [EVEN] * 2, Floors((F(0), F(0)), F(1, 2)))
    assert (overall.solved("local").value, overall.solved("global").value) == (inf, 2)
    several = Case(Setting([identity], same, releases=3), [EVEN] * 2, Floors((F(0), F(1, 2))))
    assert (several.solved("local").value, several.solved("local").exact) == (inf, False)


def test_floors_that_no_float_can_tell_from_nothing() -> None:
    for exponent in (-300, -400, 400):
        unit = F(10) ** exponent
        case = Case(Setting([SEVEN_TENTHS], [[[F(0), unit]] * 2, [[F(0), F(1)]] * 2]), [EVEN] * 2, Floors((unit / 2, F(1, 10**400))))
        found = case.solved("local")
        check(case, "local", found)
        assert (found.value, found.context) == (F(7, 3), ("c.1",))
        overall = case.solved("global")
        check(case, "global", overall)
        assert overall.value == max(by_linear_program(case, place) for place in case.places("global"))


def test_a_policy_below_the_floors_is_refused_and_utilities_that_are_open_are_not_judged() -> None:
    crossed = [[[F(0), F(1)]] * 2, [[F(1), F(0)]] * 2]
    case = Case(Setting([SEVEN_TENTHS], crossed, [[F(1)], [F(1)]]), [EVEN], Floors((F(2, 5), F(3, 5))))
    with pytest.raises(InputError, match="the policy does not keep the declared floors"):
        case.solved("local")
    deployment, table = case.subject()
    assert greatest_ratio_above(deployment, replace(table, given=np.zeros((4, 2), dtype=bool)), "local", case.floors) is None


def test_one_k_is_the_best_that_there_is() -> None:
    """No k proves less: the sums are convex in k, so that those where the best decisions change, and both ends, are enough to look at."""
    for seed in range(200):
        rng = Random(tiers.fresh(f"k {seed}"))
        rows = [random_row(rng, 4, zeros=rng.random() < 0.4) for _ in range(2)]
        columns = merged_columns([(int(p * 5040), int(q * 5040)) for p, q in zip(*rows, strict=True)])
        blocks = [[(rng.randint(0, 5), rng.randint(0, 5)) for _ in range(rng.randint(1, 4))] for _ in range(2)]
        floor = F(rng.randint(0, 40) * sum(q for _, q in columns), 8)
        value, k = least_bound(columns, [envelope(*map(list, zip(*block, strict=True))) for block in blocks], floor)

        def total(k: Fraction, columns: Any = columns, blocks: Any = blocks) -> Any:
            return sum(max(p * a - k * q * b for a, b in block) for block in blocks for p, q in columns)

        if value == inf:
            assert floor == 0 and total(F(10**9)) > 0
            continue
        assert isinstance(value, Fraction)
        best = value if k is None else k
        assert 0 <= best <= value and total(best) <= (value - best) * floor
        less = value - F(1, 10**9)
        changes = {
            F(p * (a - a2), q * (b - b2)) for p, q in columns if q for block in blocks for a, b in block for a2, b2 in block if b != b2
        }
        if less >= 1:
            assert all(total(other) > (less - other) * floor for other in {F(0), less, *changes} if 0 <= other <= less)
