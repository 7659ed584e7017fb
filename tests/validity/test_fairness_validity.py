"""Whether one log is less fair than the other: the wrong answer is given at most as often as the confidence allows.

FAIRAUDIT_FULL=1 runs 2,000 repetitions of each setting.
"""

from __future__ import annotations

from fractions import Fraction
from typing import Any

import numpy as np
import pytest
import tiers
from scipy import stats

import fairaudit as fa
from fairaudit.audits.reading import Reading
from fairaudit.audits.two_logs import compare_logs

ALPHA = 0.1
UNITS = 120


def log(ids: list[str], groups: list[str], answers: Any) -> dict[str, list[str]]:
    return {"id": ids, "group": groups, "answer": ["yes" if got else "no" for got in answers]}


@pytest.mark.parametrize("same", [0.0, 1.0])
@pytest.mark.parametrize("unit", [(), ("id",)])
def test_the_wrong_answer_is_rare_where_it_is_hardest(same: float, unit: tuple[str, ...]) -> None:
    """R = 10/8 and R' = 10/8 · 1.2: with the margin 1.2 "less fair" is wrong; with a hair less, "no less fair" is."""
    generator = np.random.default_rng(11)
    ids, groups = [f"{group}{i}" for group in "fm" for i in range(UNITS)], [group for group in "fm" for _ in range(UNITS)]
    old = np.repeat([0.4, 0.5], UNITS)
    new = np.repeat([0.4, 0.6], UNITS)
    times, wrong = 2000 if tiers.FULL else 15, {"less fair": 0, "no less fair": 0}
    reading = Reading("answer", ("group",), unit=unit)
    asked = {"independent": False, "missing_units": "worst"}
    for _ in range(times):
        uniform = generator.random(2 * UNITS)
        again = np.where(generator.random(2 * UNITS) < same, uniform, generator.random(2 * UNITS))
        logs = log(ids, groups, uniform < old), log(ids, groups, again < new)
        found = compare_logs(
            *logs, reading, fa.Utility({"yes": 1}), confidence=Fraction(9, 10), margin=Fraction(6, 5), options=asked
        ).found.fairness[0]
        wrong["less fair"] += found.ratio[0] > Fraction(6, 5)
        wrong["no less fair"] += found.ratio[1] < Fraction(6, 5)
    print(f"{wrong} of {times}, at most {ALPHA} of each wanted")
    assert all(stats.binom.sf(number - 1, times, ALPHA) >= 1e-6 for number in wrong.values())
