"""Which cases of the tests run when, and the command that times them.

Three tiers, decided case by case from `RECORD`, which ``make durations`` writes:

* *quick* (``make check``): functions whose cases together take at most `QUICK` seconds, and that start no heavy program;
* *default* (README's command): of every function as many cases as fit into `BUDGET` seconds, spread over all of them;
* *deep* (``make deep``): all other cases, and each property once more on as many examples as the deep tier has.

A function that is not in the record is new, and quick; one that takes longer bears ``@pytest.mark.deep`` until it is timed.
``@pytest.mark.core`` keeps the first case of a long function in the default tier: a real browser, a server, Spark.
"""

from __future__ import annotations

import hashlib
import os
import sys
import xml.etree.ElementTree as ET
from collections import defaultdict
from pathlib import Path
from typing import NamedTuple, overload

RECORD = Path(__file__).with_name("times.txt")
QUICK = 0.06
BUDGET = 0.5
LONGEST = 1.5
"""A case that takes longer is deep, unless its function bears ``@pytest.mark.core``."""

FULL = os.environ.get("FAIRAUDIT_FULL") == "1"
"""Before a release: random tests in their full size, some for hours."""
DEEP = FULL or os.environ.get("FAIRAUDIT_DEEP") == "1"
SEED = int(os.environ.get("FAIRAUDIT_SEED", "0"))
"""0 repeats the examples of every run; any other number is a set of examples of its own."""


def size(default: int, deep: int, full: int | None = None) -> int:
    """How many random cases a test tries: few by default, more in the deep tier, all before a release."""
    if FULL:
        return deep if full is None else full
    return deep if DEEP else default


@overload
def fresh(seed: int) -> int: ...
@overload
def fresh(seed: str) -> str: ...
def fresh(seed: int | str) -> int | str:
    """A seed of a random test: the same in every run, another one for every `SEED`."""
    if isinstance(seed, str):
        return f"{seed} {SEED}" if SEED else seed
    return seed + SEED * 1_000_000


def enough(held: object) -> bool:
    """Whether random examples were of all kinds that a test wants, which is known only of those of every run."""
    return bool(SEED or held)


class Timed(NamedTuple):
    """What ``make durations`` measured of one function."""

    seconds: float
    cases: int


def kept(timed: Timed | None, core: bool, cases: int) -> set[int]:
    """Which of a function's cases run by default: as many as fit into the budget, evenly spread from the first one on."""
    if timed is None:
        return set(range(cases))
    each = timed.seconds / timed.cases
    if each > LONGEST:
        return {0} if core else set()
    number = min(cases, max(1, int(BUDGET / each)))
    return {i * cases // number for i in range(number)}


def function(name: str) -> str:
    """Name of the function behind a test's or a doctest's name: what is before its parameters, and after its module."""
    return name.partition("[")[0].rpartition("::")[2].rpartition(".")[2]


def _digest(lines: str) -> str:
    return hashlib.sha256(lines.encode()).hexdigest()


def recorded(record: Path = RECORD) -> dict[str, Timed]:
    """What was timed, by the name of the function; ValueError for a record that was edited by hand."""
    head, _, lines = record.read_text("utf-8").partition("\n")
    if head != f"# written by make durations: {_digest(lines)}":
        raise ValueError(f"{record.name} is not as `make durations` wrote it: run it again, and leave the file as it is")
    found = (line.split() for line in lines.splitlines())
    return {name: Timed(float(seconds), int(cases)) for seconds, cases, name in found}


def write(times: dict[str, Timed], record: Path = RECORD) -> None:
    """Write the record: functions that are not quick, as they were timed."""
    lines = "".join(f"{seconds:.2f} {cases} {name}\n" for name, (seconds, cases) in sorted(times.items()) if seconds > QUICK)
    record.write_text(f"# written by make durations: {_digest(lines)}\n{lines}", "utf-8")


def measured(report: Path) -> dict[str, Timed]:
    """Seconds and cases of each function in a report of pytest's ``--junitxml``; where files share a name, those of the slowest."""
    times: defaultdict[tuple[str, str], list[float]] = defaultdict(list)
    for case in ET.parse(report).iter("testcase"):  # noqa: S314 - written by pytest
        times[case.get("classname", ""), function(case.get("name", ""))].append(float(case.get("time", 0)))
    slowest: dict[str, Timed] = {}
    for (_, name), seconds in times.items():
        timed = Timed(sum(seconds), len(seconds))
        slowest[name] = max(timed, slowest.get(name, timed))
    return slowest


def part_of(nodeid: str, parts: int) -> int:
    """Which of so many parts of the deep tier a case is in: by its name, so that it stays there."""
    return int.from_bytes(hashlib.sha256(nodeid.encode()).digest()[:4]) % parts


def repeat(part: str | None) -> list[str]:
    """Lines for the head of a run that has examples of its own: the command that repeats it."""
    if not SEED:
        return []
    words = ["FAIRAUDIT_DEEP=1" if DEEP else "", f"FAIRAUDIT_SEED={SEED}", ".venv/bin/pytest", f"--part {part}" if part else ""]
    return [f"fairaudit: examples of their own; the same once more: {' '.join(word for word in words if word)} [TEST]"]


if __name__ == "__main__":
    write(measured(Path(sys.argv[1])))
