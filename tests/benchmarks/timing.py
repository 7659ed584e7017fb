"""How the benchmarks time a piece of work."""

from __future__ import annotations

import os
import statistics
import time
from collections.abc import Callable
from typing import Any


def median(work: Callable[[], Any], repeats: int = 5, clock: Callable[[], float] = time.perf_counter) -> float:
    """Median duration, by the clock on the wall unless another is given."""
    times = []
    for _ in range(repeats):
        start = clock()
        work()
        times.append(clock() - start)
    return statistics.median(times)


def environment() -> dict[str, str]:
    """The environment of a process that is timed: as users have it, who keep the bytecode of what they installed."""
    return {name: value for name, value in os.environ.items() if name != "PYTHONDONTWRITEBYTECODE"}
