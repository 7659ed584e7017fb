"""Which tests are slow: ``make durations`` times all of them and writes ``tests/slow.txt``, and ``make check`` leaves out what that lists.

A test function is slow if all its cases together take `SLOW` seconds. The record knows functions by their names alone, so that a test may
move to another file; one that is not in it counts as fast, and a new one that is not should bear ``@pytest.mark.slow``.
"""

from __future__ import annotations

import sys
import xml.etree.ElementTree as ET
from collections import defaultdict
from pathlib import Path

RECORD = Path(__file__).with_name("slow.txt")
SLOW = 0.35


def function(name: str) -> str:
    """Name of the function behind a test's or a doctest's name: what is before its parameters, and after its module."""
    return name.partition("[")[0].rpartition(".")[2]


def recorded(record: Path = RECORD) -> dict[str, float]:
    """Seconds that each slow function took when it was timed."""
    lines = (line.split() for line in record.read_text("utf-8").splitlines())
    return {name: float(seconds) for seconds, name in lines}


def measured(report: Path) -> dict[str, float]:
    """Seconds of each function in a report of pytest's ``--junitxml``; where files share a name, those of the slowest."""
    seconds: defaultdict[tuple[str, str], float] = defaultdict(float)
    for case in ET.parse(report).iter("testcase"):  # noqa: S314 - written by pytest
        seconds[case.get("classname", ""), function(case.get("name", ""))] += float(case.get("time", 0))
    slowest: defaultdict[str, float] = defaultdict(float)
    for (_, name), taken in seconds.items():
        slowest[name] = max(slowest[name], taken)
    return slowest


def main(*reports: str) -> None:
    """Write the record from reports of whole runs."""
    found = [measured(Path(report)) for report in reports]
    slowest = {name: max(each.get(name, 0) for each in found) for name in sorted(set().union(*found))}
    RECORD.write_text("".join(f"{taken:.1f} {name}\n" for name, taken in slowest.items() if taken >= SLOW), "utf-8")


if __name__ == "__main__":
    main(*sys.argv[1:])
