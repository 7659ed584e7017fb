"""How often the test for copies is wrong, over many logs of independent units."""

from __future__ import annotations

import numpy as np
import tiers
from independent_logs import SHAPES

from fairaudit.model.replication import STEPS, copies_note

LOGS = 200 if tiers.FULL else 20  # of each of eleven shapes


def test_false_alarms_are_as_rare_as_stated() -> None:
    """At most 1 of 1,000 logs: of 2,200 logs, 9 alarms or more would have probability below 0.001 at just that rate."""
    alarms = 0
    for shape in SHAPES.values():
        for seed in range(LOGS):
            unit, context, group, answer = np.array(shape(np.random.default_rng([7, seed]))).T
            labels = [(str(i),) for i in range(unit.max() + 1)]
            alarms += bool(copies_note(["unit"], (unit, labels), context, group, answer, np.ones_like(unit)))
    assert STEPS == 999
    assert alarms < (9 if LOGS == 200 else 4)
