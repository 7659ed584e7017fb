"""How long commands take to start, as multiples of a process that imports numpy, by turns in one run. Not a test: nothing fails.

Run: python tests/benchmarks/startup.py [--python PYTHON of another environment, where fairaudit is installed] [--repeats 5]
"""

from __future__ import annotations

import argparse
import statistics
import subprocess
import sys
from resource import RUSAGE_CHILDREN, getrusage
from time import perf_counter

from timing import environment

EXAMPLE = ["-m", "fairaudit", "certify", "--example", "ucb-admissions"]

PROCESSES = {
    "python -c pass": ["-c", "pass"],
    "python -c 'import numpy'": ["-c", "import numpy"],
    "fairaudit --help": ["-m", "fairaudit", "--help"],
    "fairaudit certify --help": ["-m", "fairaudit", "certify", "--help"],
    "certify --example ucb-admissions": EXAMPLE,
    "the same, --confidence none": [*EXAMPLE, "--confidence", "none"],
}

UNIT = "python -c 'import numpy'"

COUNT = "import importlib.metadata as m; print(len({one.name for one in m.distributions()}))"


def run(words: list[str]) -> tuple[float, float]:
    """Seconds on the clock and of the processor."""
    before, start = getrusage(RUSAGE_CHILDREN), perf_counter()
    subprocess.run(words, check=True, capture_output=True, env=environment())
    clock, after = perf_counter() - start, getrusage(RUSAGE_CHILDREN)
    return clock, after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--python", default=sys.executable, help="the interpreter (default: this one)")
    parser.add_argument("--repeats", type=int, default=5)
    given = parser.parse_args()
    installed = subprocess.run([given.python, "-c", COUNT], check=True, capture_output=True, text=True).stdout.strip()
    took: dict[str, list[tuple[float, float]]] = {name: [] for name in PROCESSES}
    for turn in range(given.repeats + 1):
        for name, words in PROCESSES.items():
            seconds = run([given.python, *words])
            if turn:  # the first writes bytecode and fills the cache of the system
                took[name].append(seconds)
    medians = {name: [statistics.median(each) for each in zip(*seconds, strict=True)] for name, seconds in took.items()}
    print(f"{installed} distributions are installed; medians of {given.repeats} by turns")
    for name, (clock, processor) in medians.items():
        ratios = [one / unit for one, unit in zip((clock, processor), medians[UNIT], strict=True)]
        print(f"{name:<34} {clock:.3f} s, {ratios[0]:.2f} times; processor {processor:.3f} s, {ratios[1]:.2f} times")


if __name__ == "__main__":
    main()
