"""The exact pair bound: its chance of error by counting, published figures, the order of its ends by level, and its edges.

All outcomes of every setting: FAIRAUDIT_FULL=1 pytest -n0 tests/inference/test_pair_exact.py
"""

from __future__ import annotations

from fractions import Fraction
from math import inf
from random import Random

import numpy as np
import pytest
import tiers
from hypothesis import given
from hypothesis import strategies as st
from pair_oracle import levels_of_rejection, rarity, score_ends
from scipy.stats import binom

from fairaudit.inference import pair_exact
from fairaudit.inference.pair_exact import Contrast, Pair, order_scale, pair_excludes, pair_upper, proves

F = Fraction
LEVEL = F(1, 20)
SCALE = F(25, 16)
CONTRASTS: tuple[Contrast, ...] = ("ratio", "difference")

# Means and draws of both cells; P(upper end < true ratio) at .05 and .025, published for a search of 300 steps; and by counting at 4,000
# means without steps, where that excludes a few outcomes more.
SETTINGS = [
    (".5", 30, ".4", 30, ".0471", ".0183"),
    (".4", 30, ".5", 30, ".0469", ".0167"),
    (".1", 40, ".05", 20, ".0415", ".0240"),
    (".05", 20, ".1", 40, ".0018", ".0001"),
    (".9", 10, ".3", 15, ".0392", ".0138"),
    (".3", 15, ".9", 10, ".0272", ".0153"),
    (".5", 60, ".5", 60, ".0413 .0414", ".0177"),
    (".95", 50, ".8", 50, ".0382", ".0167"),
    (".02", 100, ".02", 100, ".0232 .0474", ".0199"),
    (".99", 40, ".97", 40, ".0180", ".0002"),
    (".3", 20, ".3", 80, ".0442", ".0135"),
    (".3", 80, ".3", 20, ".0458", ".0174"),
    (".2", 100, ".1", 60, ".0459", ".0170 .0202"),
    (".5", 5, ".5", 5, ".0303", ".0107"),
    (".6", 100, ".48", 100, ".0466", ".0214 .0218"),
    ("1", 25, ".8", 25, ".0274", ".0038"),
]

BERKELEY = {
    "A": (512, 825, 89, 108),
    "B": (353, 560, 17, 25),
    "C": (120, 325, 202, 593),
    "D": (138, 417, 131, 375),
    "E": (53, 191, 94, 393),
    "F": (22, 373, 24, 341),
}


def chance_of_error(setting: tuple[str, int, str, int, str, str], level: Fraction, contrast: Contrast) -> float:
    """P(the true contrast is excluded): outcomes far from the level by the oracle but for a sample, in a full run all by the kernel."""
    mean, n, other, m = F(setting[0]), setting[1], F(setting[2]), setting[3]
    limit = mean / other if contrast == "ratio" else mean - other
    worst = levels_of_rejection(n, m, float(limit), float(level), SCALE, contrast == "difference", 2000 if tiers.FULL else 500)
    chance = np.outer(binom.pmf(np.arange(n + 1), n, float(mean)), binom.pmf(np.arange(m + 1), m, float(other)))
    found, random = 0.0, Random(n)
    for k, j in np.ndindex(worst.shape):
        excluded, close = worst[k, j] <= float(level), not (worst[k, j] <= 0.9 * float(level) or worst[k, j] > float(level))
        if tiers.FULL or (close and chance[k, j] > 1e-9) or random.random() < 0.004:
            by_kernel = pair_excludes(Pair(k, n, j, m, SCALE, contrast), limit, level) is not None
            assert by_kernel == excluded or close
            excluded = by_kernel
        found += chance[k, j] * excluded
    return found


@pytest.mark.parametrize("setting", SETTINGS, ids=lambda s: "-".join(map(str, s[:4])))
def test_the_chance_of_error_is_the_published_one(setting: tuple[str, int, str, int, str, str]) -> None:
    for level, published in ((LEVEL, setting[4]), (LEVEL / 2, setting[5])):
        found = chance_of_error(setting, level, "ratio")
        assert found <= level
        assert f"{found:.4f}"[1:] == published.split()[-1]


@pytest.mark.parametrize(
    "setting", [SETTINGS[i] for i in ((0, 3, 9, 13) if not tiers.FULL else range(16))], ids=lambda s: "-".join(map(str, s[:4]))
)
@pytest.mark.parametrize("level", [F(1, 2), LEVEL])
def test_the_chance_of_error_of_a_difference_is_at_most_the_level(setting: tuple[str, int, str, int, str, str], level: Fraction) -> None:
    assert 0 < chance_of_error(setting, level, "difference") <= level


def ends(cells: dict[str, tuple[int, int, int, int]], upper: Fraction, lower: Fraction, one: Fraction) -> tuple[float, float]:
    """Lower and upper end of the greatest ratio; the order is that of the one-sided ends, `one` and its share of the pairs."""
    pairs = [(a, b, c, d) for k, n, j, m in cells.values() for a, b, c, d in ((k, n, j, m), (j, m, k, n))]
    least = [pair_upper(Pair(*pair, order_scale(one / len(pairs))), lower / len(pairs)).value for pair in pairs]
    greatest = [pair_upper(Pair(*pair, order_scale(one)), upper).value for pair in pairs]
    return 1 / float(min(least)), float(max(greatest))


def test_admissions_at_berkeley() -> None:
    """Published: 1.130 to 1.937 one-sided, 1.110 to 2.151 two-sided; pooled 1.335 to 1.595 two-sided."""
    pooled = {"all": (1198, 2691, 557, 1835)}
    half = LEVEL / 2
    for cells, share, published in ((BERKELEY, LEVEL, (1.130, 1.937)), (BERKELEY, half, (1.110, 2.151)), (pooled, half, (1.335, 1.595))):
        low, high = ends(cells, share, share, LEVEL)
        assert published[0] * 0.999 <= low <= published[0] * 1.001
        assert published[1] * 0.994 <= high <= published[1] * 1.001


def test_the_difference_of_admissions_to_a_department() -> None:
    """Published: .130 to .266, one-sided."""
    k, n, j, m = BERKELEY["A"]
    assert round(-float(pair_upper(Pair(k, n, j, m, SCALE, "difference"), LEVEL).value), 3) == 0.130
    assert 0.2655 <= pair_upper(Pair(j, m, k, n, SCALE, "difference"), LEVEL).value <= 0.2666


@st.composite
def pairs(draw: st.DrawFn, most: int = 40) -> Pair:
    n, m = draw(st.integers(1, most)), draw(st.integers(1, most))
    scale = draw(st.sampled_from([F(25, 16), F(4), F(9)]))
    return Pair(draw(st.integers(0, n)), n, draw(st.integers(0, m)), m, scale, draw(st.sampled_from(CONTRASTS)))


LEVELS = st.sampled_from([F(1, 2), F(1, 10), LEVEL, LEVEL / 2, F(1, 1000), F(1, 10**6), F(1, 10**9)])


@given(pairs(), LEVELS)
def test_the_order_is_that_of_decimals(pair: Pair, level: Fraction) -> None:
    for k in range(pair.draws + 1):
        assert pair_exact.score_ends(k, pair.draws, pair.scale) == score_ends(k, pair.draws, pair.scale)
    assert order_scale(level) == (F(25, 16) if level >= F(1, 100) else F(4) if level >= F(1, 2000) else F(9))


@given(pairs(), LEVELS)
def test_an_end_is_proved_and_a_part_in_fifty_less_is_not(pair: Pair, level: Fraction) -> None:
    bound = pair_upper(pair, level)
    if bound.knots is None:
        assert bound.value == (inf if pair.contrast == "ratio" else 1)
        if pair.contrast == "ratio":
            assert not pair.other_successes
        else:  # an end so near to 1 that its lattice has nothing between
            assert pair_excludes(pair, F(49, 50), level) is None
        return
    assert isinstance(bound.value, Fraction)
    counts = (pair.successes, pair.draws, pair.other_successes, pair.other_draws)
    assert rarity(counts, bound.value, level, bound.knots, pair.scale, pair.contrast == "difference") <= 1 + 1e-9
    smaller = bound.value * F(49, 50) if pair.contrast == "ratio" else bound.value - F(1, 50)
    assert pair_excludes(pair, smaller, level) is None
    assert not proves(pair, smaller, level, bound.knots)
    greater = bound.value * F(11, 10) if pair.contrast == "ratio" else bound.value + F(1, 10)
    assert pair_excludes(pair, greater, level) is not None


@given(pairs(300), st.lists(st.integers(10**3, 5 * 10**8), min_size=2, max_size=3))
def test_a_greater_level_gives_no_greater_end(pair: Pair, parts: list[int]) -> None:
    found = [pair_upper(pair, F(part, 10**9)).value for part in sorted(parts)]
    assert found == sorted(found, reverse=True)


@pytest.mark.parametrize("draws", [1, 2, 30, 5000, 10**5])
def test_nothing_of_the_second_cell_bounds_no_ratio(draws: int) -> None:
    for k in (0, 1, draws):
        assert pair_upper(Pair(k, draws, 0, draws, SCALE), LEVEL).value == inf
        assert pair_excludes(Pair(k, draws, 0, draws, SCALE), F(10**9), LEVEL) is None


def test_single_draws() -> None:
    """One draw each, failure and success: p_i/p_j ≥ r and the one outcome in the staircase, (1 − p_i)·p_j, is at most 1/(4r)."""
    found = pair_upper(Pair(0, 1, 1, 1, SCALE), LEVEL).value
    assert 1 / (4 * LEVEL * F(98, 100)) <= found <= 1 / (4 * LEVEL * F(98, 100)) * F(1002, 1000)
    assert pair_upper(Pair(1, 1, 0, 1, SCALE, "difference"), LEVEL).value == 1


def test_all_or_nothing() -> None:
    assert 1 < pair_upper(Pair(30, 30, 30, 30, SCALE), LEVEL).value < F(6, 5)
    assert pair_upper(Pair(0, 30, 30, 30, SCALE), LEVEL).value < F(1, 8)
    assert pair_upper(Pair(0, 30, 30, 30, SCALE, "difference"), LEVEL).value < F(-4, 5)
    assert pair_upper(Pair(30, 30, 0, 30, SCALE, "difference"), LEVEL).value == 1


def test_far_from_the_null_a_single_knot_proves_it_and_beyond_the_limits_nothing_does() -> None:
    pair = Pair(10, 1000, 900, 1000, SCALE)
    knots = pair_excludes(pair, F(1), LEVEL)
    assert knots is not None and len(knots) == 1
    assert pair_upper(Pair(10, 10**6 + 1, 900, 1000, SCALE), LEVEL).value == inf
    assert pair_upper(pair, F(1, 10**13)).value == inf


def test_when_the_first_mean_must_be_greater_nothing_is_proved() -> None:
    """With 200 of 200 against 2 of 200 the null p_i ≥ p_j holds in the whole box, and an empty range of steps proves nothing."""
    pair = Pair(200, 200, 2, 200, SCALE)
    assert pair_excludes(pair, F(1), LEVEL) is None
    assert not any(proves(pair, F(1), LEVEL, (F(i, 100),)) for i in range(1, 101))


@pytest.mark.parametrize(
    ("k", "n", "j", "m"), [(400, 800, 400, 800), (2500, 5000, 2500, 5000), (1000, 10**5, 900, 10**5), (3, 50, 10**5, 10**6)]
)
def test_many_draws_come_close_to_the_normal_limit(k: int, n: int, j: int, m: int) -> None:
    error = (1 / k - 1 / n + 1 / j - 1 / m) ** 0.5
    estimate = F(k, n) / F(j, m)
    found = np.log(float(pair_upper(Pair(k, n, j, m, SCALE), LEVEL).value / estimate)) / error
    assert (1.645 if min(k, j) > 100 else 1.4) < found < (1.76 if min(k, j) > 100 else 2.2)
