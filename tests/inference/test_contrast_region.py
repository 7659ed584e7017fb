"""Intervals of independent cells of several values, every pair by itself: when they are taken, what proves them, how often they err.

2,000 repetitions and 2,400 alterations: FAIRAUDIT_FULL=1 pytest -n0 tests/inference/test_contrast_region.py
"""

from __future__ import annotations

import copy
import json
import random
from collections.abc import Callable, Iterator
from dataclasses import replace
from fractions import Fraction
from itertools import permutations
from math import comb, inf
from typing import Any

import numpy as np
import pytest
import tiers
from certificates import outcome
from contrast_oracle import bets
from hypothesis import given, settings
from hypothesis import strategies as st
from interval_oracle import ONE, ZERO, binary, one_block

import fairaudit as fa
from fairaudit import checker
from fairaudit.checker import symmetric_betting
from fairaudit.checker.work import CURRENT_WORK, Work
from fairaudit.errors import InputError
from fairaudit.inference.betting import ValueCounts
from fairaudit.inference.cells import Cell
from fairaudit.inference.comparisons import Comparison, unit_form
from fairaudit.inference.contrast_region import MOST_STEPS, contrast_steps, fits_contrasts
from fairaudit.inference.ratio_intervals import default_region, drivers, ratio_interval
from fairaudit.inference.symmetric_betting import upper_end
from fairaudit.inference.table_comparisons import global_comparison, local_comparison

F = Fraction
HALF = F(1, 2)
REPETITIONS = 2_000 if tiers.FULL else 25
ALTERED = 2_400 if tiers.FULL else 150
ENDS = st.sampled_from(["together", "each", "lower", "upper"])
Draws = list[Fraction]


def compared(*drawn: Any, low: Fraction = ZERO, high: Fraction = ONE, blocks: int = 1) -> Comparison:
    """Cells of these draws, in one context or as many as that."""
    tallies: list[dict[Fraction, int]] = []
    for draws in drawn:
        found, counts = np.unique(np.asarray(draws, dtype=np.float64), return_counts=True)
        tallies.append({F(v): int(n) for v, n in zip(found.tolist(), counts.tolist(), strict=True)})
    cells = []
    for tally in tallies:
        total, squares = (sum((n * v**power for v, n in tally.items()), ZERO) for power in (1, 2))
        cells.append(Cell(sum(tally.values()), total, squares, low, high, False))
    size = len(cells) // blocks
    return Comparison(
        tuple(cells), tuple(tuple(unit_form(b * size + i) for i in range(size)) for b in range(blocks)), drawn=lambda: tallies
    )


def contrasts(comparison: Comparison, confidence: Any = "0.95", **options: Any) -> Any:
    return ratio_interval(comparison, confidence, region="contrasts", independent=True, **options)


def symmetric_means(values: Draws, most: int) -> Draws:
    """The mean over all sets of k draws of the product of their values, k = 0 … most."""
    sums = [ONE, *[ZERO] * most]
    for v in values:
        sums = [s + (sums[k - 1] * v if k else 0) for k, s in enumerate(sums)]
    return [s / comb(len(values), k) for k, s in enumerate(sums)]


def won(xs: Draws, ys: Draws, limit: Fraction) -> Fraction:
    """What the bets against E(x) ≥ limit·E(y) won, exactly, from the sum over k."""
    pairs, total = min(len(xs), len(ys)), F(0)
    made = bets(pairs**2 * (F(1, len(xs)) + F(1, len(ys))))
    of_y = symmetric_means(ys, pairs)
    for bet in made:
        of_x = symmetric_means([1 - bet * x for x in xs], pairs)
        total += sum((comb(pairs, k) * (bet * limit) ** k * of_y[k] * of_x[pairs - k] for k in range(pairs + 1)), ZERO)
    return total / len(made)


def listed(comparison: Comparison) -> list[Draws]:
    """Draws, as parts of the greatest value there could be."""
    cells = zip(comparison.cells, comparison.tallies, strict=True)
    return [[v / cell.high for v, n in tally.items() for _ in range(n)] for cell, tally in cells]


def recheck(comparison: Comparison, found: Any) -> None:
    """Check both ends by definition."""
    evidence = json.loads(json.dumps(found.evidence))
    drawn, highs = listed(comparison), [cell.high for cell in comparison.cells]
    places = [(b, i, j) for b, block in enumerate(comparison.blocks) for i, j in permutations(range(len(block)), 2)]
    share = (1 - F(evidence["confidence"])) / (2 if evidence["ends"] == "together" else 1)
    for name, level in (("upper", share), ("lower", share / len(places))):
        assert evidence["levels"][name] is None or F(evidence["levels"][name]) == level

    def below(place: tuple[int, int, int], limit: Fraction, level: Fraction) -> bool:
        i, j = (comparison.blocks[place[0]][k][0][0] for k in place[1:])
        if comparison.cells[j].low * limit >= highs[i]:
            return True
        return won(drawn[i], drawn[j], limit * highs[j] / highs[i]) >= 1 / level

    assert found.lower >= 1 and found.upper >= 1
    if found.upper != inf:
        assert all(below(place, F(found.upper), share) for place in places)
    if found.lower > 1:
        b, i, j = evidence["pair"]
        assert below((b, j, i), 1 / F(found.lower), share / len(places))
    assert (evidence["pair"] is None) == (found.lower == 1)


VALUES = st.lists(st.sampled_from([ZERO, F(1, 4), HALF, ONE]), min_size=1, max_size=9)


@given(st.lists(VALUES, min_size=2, max_size=3), st.sampled_from(["0.3", "0.5", "0.8"]), ENDS, st.sampled_from([ZERO, F(-1)]))
@settings(max_examples=20, deadline=None)
def test_its_evidence_proves_it(drawn: list[Draws], confidence: str, ends: Any, shift: Fraction) -> None:
    """Also of values from 1 to 2, whose ratio is at most 2 whatever is drawn."""
    low = -shift
    comparison = compared(*([v + low for v in draws] for draws in drawn), low=low, high=low + 1)
    found = contrasts(comparison, confidence, ends=ends)
    assert found.methods == ("symmetric-betting",)
    assert found.upper <= 2 or not low or ends == "lower"
    recheck(comparison, found)


def test_the_end_is_the_least_that_all_pairs_prove() -> None:
    source = np.random.default_rng(5)
    comparison = compared(
        *(source.choice([0, 0.5, 1], n, p=p) for n, p in ((12, (0, 0.1, 0.9)), (10, (0.2, 0.6, 0.2)), (14, (0.8, 0.1, 0.1))))
    )
    found, drawn = contrasts(comparison, "0.6", ends="each"), listed(comparison)
    less = F(found.upper) * (1 - F(1, 10**5))
    assert any(won(drawn[i], drawn[j], less) < F(10, 4) for i, j in permutations(range(3), 2))
    more = F(found.lower) * (1 + F(1, 10**5))
    assert found.lower > 1 and all(won(drawn[j], drawn[i], 1 / more) < 6 * F(10, 4) for i, j in permutations(range(3), 2))
    recheck(comparison, found)


Generator = np.random.Generator
THREE = [0.0, 0.5, 1.0]

SETTINGS: dict[str, tuple[Callable[[Generator], Comparison], float]] = {  # with the true ratio
    "three groups": (
        lambda s: compared(*(s.choice(THREE, 25, p=p) for p in ((0.1, 0.8, 0.1), (0.1, 0.8, 0.1), (0.3, 0.6, 0.1)))),
        0.5 / 0.4,
    ),
    "mostly nothing": (lambda s: compared(*(s.choice(THREE, 40, p=(0.9, 0.05, 0.05)) for _ in range(2))), 1.0),
    "one group gets nothing": (lambda s: compared(np.zeros(20), s.choice(THREE, 20)), inf),
    "nobody gets anything": (lambda s: compared(np.zeros(20), np.zeros(20)), 1.0),
    "one draw": (lambda s: compared(s.choice(THREE, 1), s.choice(THREE, 60, p=(0.2, 0.2, 0.6))), 0.7 / 0.5),
    "one in a hundred": (lambda s: compared(*((s.beta(0.5, 3, n) * 64 // 1) / 64 for n in (3, 300))), 1.0),
    "certain against chance": (lambda s: compared(np.ones(30), s.choice(THREE, 30, p=(0.25, 0.5, 0.25))), 2.0),
    "contexts": (lambda s: compared(*(s.choice(THREE, 15, p=p) for p in ((0.2, 0.2, 0.6), (0.4, 0.2, 0.4)) * 3), blocks=3), 0.7 / 0.5),
    "nobody gets nothing": (
        lambda s: compared(*(1 + s.choice(THREE, 20, p=p) for p in ((0.2, 0, 0.8), (0.8, 0, 0.2))), low=ONE, high=F(2)),
        1.5,
    ),
}


@pytest.mark.parametrize("setting", SETTINGS)
@pytest.mark.parametrize("ends", ["each", "together"])
def test_ends_err_no_more_than_they_say(setting: str, ends: Any) -> None:
    """At a confidence of 1/2, where errors are seen, and at 95 %."""
    draw, true = SETTINGS[setting]
    source = np.random.default_rng(41)
    for confidence, count in (("1/2", REPETITIONS), ("0.95", REPETITIONS if tiers.FULL else 8)):
        misses = [0, 0]
        for _ in range(count):
            found = contrasts(draw(source), confidence, ends=ends)
            misses[0] += found.lower > true * (1 + 1e-12)
            misses[1] += found.upper < true * (1 - 1e-12)
        alpha = 1 - float(F(confidence))
        print(f"{setting}, {ends} at {confidence}: {misses[0] / count:.4f} below, {misses[1] / count:.4f} above, of {count}")
        assert (max(misses) if ends == "each" else sum(misses)) <= count * alpha + 5 * (count * alpha * (1 - alpha)) ** 0.5


SHAPES: list[tuple[Any, float, int, float]] = [
    (lambda s, n: s.choice(THREE, n, p=(0.1, 0.8, 0.1)), 1, 50, 1.353),
    (lambda s, n: s.choice(THREE, n, p=(0.1, 0.8, 0.1)), 1, 400, 1.116),
    (lambda s, n: s.beta(0.5, 3, n), 1, 50, 2.163),
    (lambda s, n: s.beta(0.5, 3, n), 1, 400, 1.326),
    (lambda s, n: s.beta(2, 2, n), 1.25, 50, 1.611),
    (lambda s, n: s.beta(2, 2, n), 1.25, 400, 1.363),
]


@pytest.mark.parametrize("case", range(len(SHAPES)) if tiers.FULL else (0, 2, 4))
def test_upper_ends_are_as_narrow_as_another_simulation_found_them(case: int) -> None:
    shape, ratio, n, expected = SHAPES[case]
    source = np.random.default_rng(42)
    count = (400 if n == 50 else 200) if tiers.FULL else 25
    ends = [float(contrasts(compared(shape(source, n), shape(source, n) / ratio), ends="upper").upper) for _ in range(count)]
    print(f"median {np.median(ends):.4f}, {expected} elsewhere")
    assert np.median(ends) == pytest.approx(expected, rel=0.03 if tiers.FULL else 0.1)


def test_narrower_errors_are_nested() -> None:
    source = np.random.default_rng(6)
    comparison = compared(*(source.choice(THREE, 40, p=p) for p in ((0.1, 0.2, 0.7), (0.2, 0.6, 0.2), (0.6, 0.2, 0.2))))
    found = [contrasts(comparison, confidence, ends=how) for confidence in ("0.8", "0.95", "0.99") for how in ("each", "together")]
    for one, other in zip(found[::2], found[1::2], strict=True):
        assert one.upper <= other.upper and one.lower >= other.lower
    assert [each.upper for each in found[::2]] == sorted(each.upper for each in found[::2])
    assert [each.lower for each in found[::2]] == sorted((each.lower for each in found[::2]), reverse=True)


LAW = fa.Law.from_array(
    [[[30, 100, 20], [10, 90, 40]], [[20, 60, 20], [25, 50, 25]]],
    kind="counts",
    decisions=["yes", "maybe", "no"],
    groups=["f", "m"],
    contexts=["x", "y"],
)
WORTH: dict[str, Any] = {"yes": 1, "maybe": "1/2"}


def test_independence_is_never_assumed_and_a_method_that_was_asked_for_is_kept() -> None:
    assert fa.certify(LAW, WORTH).intervals["local"].region == "box"
    found = fa.certify(LAW, WORTH, independent=True)
    assert {name: own.region for name, own in found.intervals.items()} == {"local": "contrasts", "global": "contrasts"}
    for method in ("hoeffding-kl", "empirical-bernstein", "intersection"):
        asked = fa.certify(LAW, WORTH, independent=True, interval=method)
        assert asked.intervals["local"].region in ("box", "product") and asked.intervals["local"].methods == (method,)
        assert asked.intervals["local"].upper > found.intervals["local"].upper
    assert fa.certify(LAW, {"yes": 1}, independent=True).intervals["local"].region == "pairs"
    with pytest.raises(InputError, match="contrasts of draws need independent cells"):
        ratio_interval(local_comparison(LAW, fa.Utility(WORTH).on(LAW)), region="contrasts")


def test_a_declared_range_is_one_of_several_values() -> None:
    """Two values were seen, but others may be drawn; and cells of two values beside others take the same method."""
    found = fa.certify(LAW, {"yes": 1}, independent=True, declared={"gamma": 2, "m": 0}).intervals["local"]
    assert found.region == "contrasts" and found.evidence["cells"][0]["range"] == ["0", "2"]
    utility = fa.Utility.from_function(lambda u, x, a: "1" if u == "yes" else "1/2" if u == "maybe" and a == ("f",) else "0", LAW)
    mixed = fa.certify(LAW, utility, independent=True).intervals["local"]
    assert {cell["binary"] for cell in mixed.evidence["cells"]} == {True, False} and mixed.methods == ("symmetric-betting",)


def test_utilities_of_groups_scale_the_ratio() -> None:
    """What is worth three times as much in one group makes three times the ratio."""
    plain = contrasts(compared([0, 0.5, 1, 1, 0.5], [0.5, 0.5, 0, 1, 0]), "0.5", ends="each")
    comparison = compared([0, 0.5, 1, 1, 0.5], [0.5, 0.5, 0, 1, 0])
    one, other = comparison.cells
    tallies = [{3 * v: n for v, n in comparison.tallies[0].items()}, comparison.tallies[1]]
    tripled = Comparison(
        (Cell(one.draws, 3 * one.total, 9 * (one.squares or ZERO), ZERO, F(3), False), other), comparison.blocks, drawn=lambda: tallies
    )
    scaled = contrasts(tripled, "0.5", ends="each")
    assert scaled.upper == 3 * plain.upper
    recheck(tripled, scaled)


@pytest.mark.parametrize(
    "other",
    [
        one_block(binary(40, 30), binary(40, 20)),  # two values, which the exact pair bound takes
        compared([0, 0.5, 1], []),  # no draws
        compared([0, 0], [0, 0], high=ZERO),  # nothing is worth anything
        compared(np.arange(3_001) / 3_001, [0, 0.5, 1]),  # too many values
        compared([2.0**-140, 0.5, 1], [0, 0.5, 1]),  # values that are too long
        compared(*[[0, 0.5, 1] * 9] * 200),  # too many pairs
        compared(*[np.arange(2_900) / 2_900] * 4),  # too much to check
    ],
)
def test_other_cells_keep_another_region(other: Comparison) -> None:
    assert not fits_contrasts(other) and default_region(other, independent=True) != "contrasts"
    with pytest.raises(InputError):
        contrasts(other)


def test_an_open_verdict_says_what_independence_would_give() -> None:
    result = fa.certify(LAW, WORTH, max_local_ratio="6/5")
    assert result.verdict == "inconclusive"
    declared = fa.certify(LAW, WORTH, max_local_ratio="6/5", independent=True).intervals["local"]
    assert declared.region == "contrasts" and result.if_independent == {"local": (declared.lower, declared.upper)}
    assert not fa.certify(LAW, WORTH, max_local_ratio="6/5", interval="hoeffding-kl").if_independent


def test_the_pair_behind_each_end_is_named() -> None:
    law = fa.Law.from_array([[20, 40, 40], [70, 20, 10], [5, 10, 15]], kind="counts", decisions=[*WORTH, "no"], groups=["a", "b", "c"])
    comparison = local_comparison(law, fa.Utility(WORTH).on(law))
    found = contrasts(comparison)
    lower, upper = drivers(comparison, found.evidence, found.upper)
    assert lower is not None and (lower.higher, lower.lower) == ({"group": "b"}, {"group": "a"})
    assert upper is not None and (upper.higher, upper.lower) == ({"group": "b"}, {"group": "c"})
    nothing = fa.Law.from_array([[20, 40, 40], [0, 0, 20]], kind="counts", decisions=[*WORTH, "no"], groups=["a", "b"])
    comparison = local_comparison(nothing, fa.Utility(WORTH).on(nothing))
    assert drivers(comparison, contrasts(comparison).evidence, inf)[1].lower == {"group": "b"}  # type: ignore[union-attr]


def runs(pick: random.Random, spanning: bool) -> dict[str, list[str]]:
    """Several rows of each run; a run has one group, or may have two."""
    log: dict[str, list[str]] = {"u": [], "a": [], "run": []}
    for run in range(60):
        p = pick.random()
        for row in range(pick.randint(1, 5)):
            group = "fm"[row % 2] if spanning else "fm"[run % 2]
            for name, value in (("u", "yes" if pick.random() < p else "no"), ("a", group), ("run", str(run))):
                log[name].append(value)
    return log


def test_means_over_units_that_have_one_group_each() -> None:
    pick = random.Random(4)
    law = fa.Law.from_log(runs(pick, spanning=False), decision="u", group="a", unit="run")
    result = fa.certify(law, {"yes": 1}, independent=True, max_local_ratio="3")
    found = result.intervals["local"]
    assert found.region == "contrasts" and found.estimand == "mean over units"
    assert [sum(tally.values()) for tally in result.comparisons["local"].tallies] == [30, 30]
    document = json.loads(result.certificate.text)
    assert document["intervals"]["local"]["units"] and outcome(document) == "true"
    box = fa.certify(law, {"yes": 1}, independent=True, interval="hoeffding-kl", max_local_ratio="3")
    assert outcome(json.loads(box.certificate.text)) == "true" and box.intervals["local"].upper > found.upper
    shared = fa.Law.from_log(runs(pick, spanning=True), decision="u", group="a", unit="run")
    assert fa.certify(shared, {"yes": 1}).intervals["local"].region == "box"
    with pytest.raises(InputError, match="not independent"):
        fa.certify(shared, {"yes": 1}, independent=True)


def test_pooled_rows_are_one_cell_for_each_group() -> None:
    comparison = global_comparison(LAW, fa.Utility(WORTH).on(LAW))
    assert [*comparison.tallies] == [{ONE: 50, HALF: 160, ZERO: 40}, {ONE: 35, HALF: 140, ZERO: 65}]
    drawn = [ValueCounts(dict(tally)) for tally in comparison.tallies]
    expected = max(upper_end(drawn[i], drawn[j], F(1, 20)) for i, j in ((0, 1), (1, 0)))
    assert contrasts(comparison, ends="upper").upper == expected


def steps_of(comparison: Comparison, limit: Fraction) -> int:
    """The steps that the checker takes for all pairs, the hardest of them twice."""
    drawn = [{v / cell.high: n for v, n in tally.items()} for cell, tally in zip(comparison.cells, comparison.tallies, strict=True)]
    taken = []
    for i, j in permutations(range(len(drawn)), 2):
        work = Work(10**12, 10**12)
        token = CURRENT_WORK.set(work)
        try:
            symmetric_betting.wealth_of(drawn[i], drawn[j], limit, False)
        finally:
            CURRENT_WORK.reset(token)
        taken.append(10**12 - work.steps)
    return sum(taken) + max(taken)


@given(
    st.integers(0, 10**6),
    st.tuples(*[st.sampled_from([1, 4, 30, 200, 1_500, 8_000])] * 2),
    st.sampled_from([2, 3, 20, 300]),
    st.sampled_from([F(1), F(6, 5), F(30)]),
)
@settings(max_examples=12, deadline=None)
def test_no_more_steps_are_taken_than_are_expected(seed: int, sizes: tuple[int, int], values: int, limit: Fraction) -> None:
    source = np.random.default_rng(seed)
    comparison = compared(*(np.round(source.beta(0.7, 2, n) * values) / 1024 for n in sizes))
    assert steps_of(comparison, limit) <= contrast_steps(comparison) < MOST_STEPS


def test_as_many_values_as_are_taken_are_checked() -> None:
    """Both intervals of a table in which no two draws of a cell are alike."""
    n = 2_700 if tiers.FULL else 250
    rows = [(str(i), "fm"[i % 2]) for i in range(2 * n)]
    law = fa.Law.from_log({"u": [u for u, _ in rows], "a": [a for _, a in rows]}, decision="u", group="a")
    worth = {u: str(F(int(u) * int(u) % 10_007, 10_007)) for u, _ in rows}
    result = fa.certify(law, worth, independent=True)
    assert {own.region for own in result.intervals.values()} == {"contrasts"}
    assert outcome(json.loads(result.certificate.text)) == "true"


def certificate(**options: Any) -> Any:
    return json.loads(fa.certify(LAW, WORTH, independent=True, **options).certificate.text)


def stands(document: Any, name: str = "local") -> bool:
    """Whether the checker takes the interval, whatever else is false."""
    try:
        findings = checker.check(json.dumps(document).encode()).findings
    except checker.FormatError:
        return False
    return all(finding.true for finding in findings if finding.statement.startswith(f"intervals.{name}:"))


def changes(document: Any, pick: random.Random) -> Iterator[Any]:
    """Intervals that say more than was proved, of this table; and the same of tables that say less."""

    def with_(change: Callable[[Any, Any], Any]) -> Any:
        made = copy.deepcopy(document)
        change(made["intervals"]["local"], made)
        return made

    low, high = (F(end) for end in document["intervals"]["local"]["ratio"])
    part = F(pick.randint(1, 999), 1_000)
    yield with_(lambda i, _: i.update(ratio=[str(low), str(1 + (high - 1) * part)]))
    yield with_(lambda i, _: i.update(ratio=[str(low), str(high * (1 - F(1, 10**6)))]))
    yield with_(lambda i, _: i.update(ratio=[str(low * (1 + F(pick.randint(1, 10**6), 10**9) + F(1, 10**6))), str(high)]))
    yield with_(lambda i, _: i.update(ratio=[str(low), str(part)]))
    for name in ("upper", "lower"):
        yield with_(lambda i, _, name=name: i["levels"].update({name: str(F(i["levels"][name]) * pick.choice([F(2), F(1, 2), part]))}))  # type: ignore[misc]
        yield with_(lambda i, _, name=name: i["levels"].update({name: str(part)}))  # type: ignore[misc]
    place = document["intervals"]["local"]["pair"]
    for other in ([0, 1, 0], [0, 0, 1], [1, 0, 1], [1, 1, 0], [0, 0, 0], [pick.randint(2, 9), 0, 1], [0, 0, 2], None):
        if other != place:
            yield with_(lambda i, _, other=other: i.update(pair=other))  # type: ignore[misc]
    yield with_(lambda i, _: i.update(independent=False))
    yield with_(lambda i, _: i.update(ends={"each": "together", "together": "each"}[i["ends"]]))
    yield with_(lambda i, _: i.update(confidence=str(F(96, 100) + part / 30)))
    yield with_(lambda i, _: i.update(limits=["0", str(1 + part)]))
    yield with_(lambda i, _: i.update(region=pick.choice(["box", "product", "pairs", "contrast"])))
    yield with_(lambda i, _: i.update(upper=[]))
    yield with_(lambda i, _: i.pop("pair"))
    yield with_(lambda i, _: i.update(units=[[[1, [30, 100, 20]]]] * 4))
    # In the table: those who got less get less still, those who got more get more.
    rows = range(len(document["subject"]["table"]["rows"]))
    lower, higher = (rows[2 * place[0] + place[k]] for k in (2, 1))
    moved = pick.randint(1, 9)

    def move(made: Any, row: int, steps: tuple[int, int]) -> Any:
        weights = made["subject"]["table"]["rows"][row]["weights"]
        weights[steps[0]] = str(int(weights[steps[0]]) - moved)
        weights[steps[1]] = str(int(weights[steps[1]]) + moved)
        return made

    yield with_(lambda _, made: move(made, lower, (1, 0)))  # the lower end falls
    yield with_(lambda _, made: move(made, higher, (0, 2)))
    yield with_(lambda _, made: [move(made, lower, (1, 2)), move(made, higher, (1, 0))])  # the upper end rises


@pytest.mark.parametrize("target", [None, "2"])
def test_no_altered_evidence_is_accepted(target: str | None) -> None:
    honest = certificate(**({} if target is None else {"max_local_ratio": target}))
    assert honest["intervals"]["local"]["region"] == "contrasts" and honest["intervals"]["local"]["pair"] is not None
    assert outcome(honest) == "true"
    pick, tried = random.Random(7), 0
    while tried < ALTERED / 2:
        for altered in changes(honest, pick):
            assert not stands(altered), altered["intervals"]["local"]
            assert outcome(altered) != "true"
            tried += 1


def test_claims_name_the_method() -> None:
    honest = certificate()
    made = [claim for claim in honest["claims"] if claim["by"] == "symmetric-betting"]
    assert len(made) == 4
    for by in ("binomial", "hoeffding-kl", "pair-exact", "betting"):
        altered = copy.deepcopy(honest)
        for claim in altered["claims"]:
            claim["by"] = by if claim["by"] == "symmetric-betting" else claim["by"]
        assert outcome(altered) != "true"


def test_how_draws_came_out_has_no_say_in_the_method() -> None:
    """As many draws of the same values are as much to check, whichever came; of values that nobody listed all might have been different."""
    worth = {"a": 1, "b": "1/2", "c": "1/3", "d": 0}
    steps = []
    for counts in ([[50, 0, 0, 0], [50, 0, 0, 0]], [[12, 13, 12, 13], [0, 10, 40, 0]]):
        law = fa.Law.from_array(counts, kind="counts", decisions=[*worth])
        comparison = local_comparison(law, fa.Utility(worth).on(law))
        steps.append(contrast_steps(comparison))
        assert contrast_steps(replace(comparison, listed=False)) > steps[-1]
    assert steps[0] == steps[1]
    table = {"u": ["x", "y", "x", "y"], "a": ["f", "f", "m", "m"], "g": ["1", "0.5", "0.7", "0"], "n": [10, 20, 20, 10]}
    columns = {"decision": "u", "group": "a", "utility_column": "g", "count": "n", "declared": {"gamma": 1, "m": 0}}
    seen = fa.audit(table, independent=True, **columns)  # type: ignore[arg-type]
    assert not seen.comparisons["local"].listed and seen.intervals["local"].region == "contrasts"
