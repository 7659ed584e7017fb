"""Reading a log into a monitor, against a loop over the same file with Python's json module. Nothing passes or fails on time.

Run: python tests/benchmarks/monitor.py [LINES]
"""

from __future__ import annotations

import json
import random
import statistics
import subprocess
import sys
import tempfile
import time
from collections import Counter
from collections.abc import Callable
from pathlib import Path
from typing import Any

from fairaudit.streams.settings import Settings
from fairaudit.streams.state import State
from fairaudit.streams.stream import Monitor

SETTINGS = Settings(
    group=("sex",), context=("job",), decision="answer", utility={"yes": "1"}, targets={"max_local_ratio": "5/4"}, expected=6
)
PEAK = "import resource; print(resource.getrusage(resource.RUSAGE_SELF).ru_maxrss)"


def write(path: Path, lines: int) -> None:
    rng = random.Random(0)
    with path.open("w") as file:
        for k in range(lines):
            event = {
                "event": f"{k:08x}-{rng.getrandbits(32):08x}",
                "time": f"2026-03-{1 + k % 28:02d}T{k % 24:02d}:{k % 60:02d}:00Z",
                "model": {"name": "dispatcher", "version": f"4.{k % 7}"},
                "latency_ms": rng.randrange(40, 900),
                "job": rng.choice(("cook", "clean", "carry")),
                "sex": rng.choice("fm"),
                "answer": rng.choice(("yes", "no")),
            }
            file.write(json.dumps(event) + "\n")


def loop(path: Path) -> Counter[Any]:
    counts: Counter[Any] = Counter()
    with path.open() as file:
        for line in file:
            event = json.loads(line)
            counts[event["job"], event["sex"], event["answer"]] += 1
    return counts


def monitor(path: Path) -> Counter[Any]:
    with tempfile.TemporaryDirectory() as folder:
        watched = Monitor(State(str(Path(folder) / "state.db"), SETTINGS), str(path))
        for _ in watched.read():
            pass
        watched.close()
    names = [label for label, _ in watched.decisions]
    cells = list(watched.total.order)
    return Counter({(*cells[rank - 1][0], *cells[rank - 1][1], names[number]): n for (rank, number), n in watched.total.n.items()})


def timed(work: Callable[[Path], Any], path: Path, repeats: int = 3) -> tuple[float, float]:
    wall, cpu = [], []
    for _ in range(repeats):
        start, own = time.perf_counter(), time.process_time()
        work(path)
        wall.append(time.perf_counter() - start)
        cpu.append(time.process_time() - own)
    return statistics.median(wall), statistics.median(cpu)


def peak(path: Path) -> int:
    """Peak memory of a process that monitors the log, in kilobytes."""
    code = f"import sys; sys.path[:0] = {sys.path!r}; sys.argv = ['x']\nfrom pathlib import Path\nimport runpy\n"
    code += f"space = runpy.run_path({__file__!r}, run_name='benchmark')\nspace['monitor'](Path({str(path)!r}))\n{PEAK}"
    return int(subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True).stdout)


def main() -> None:
    lines = int(sys.argv[1]) if len(sys.argv) > 1 else 1_000_000
    with tempfile.TemporaryDirectory() as folder:
        path, short = Path(folder) / "log.jsonl", Path(folder) / "short.jsonl"
        write(path, lines)
        write(short, lines // 10)
        megabytes = path.stat().st_size / 1e6
        assert sum(monitor(short).values()) == sum(loop(short).values())
        reference, own = timed(loop, path), timed(monitor, path)
        print(f"{lines} lines, {megabytes:.0f} MB; medians of 3 runs, clock and processor")
        print(f"json loop   {reference[0]:7.2f} s {reference[1]:7.2f} s")
        print(
            f"monitor     {own[0]:7.2f} s {own[1]:7.2f} s   state and alarms included; {lines / own[1] / 1e6:.2f} million lines per second"
        )
        print(f"ratio       {reference[0] / own[0]:7.2f}   {reference[1] / own[1]:7.2f}")
        print(f"peak memory {peak(short) / 1024:.0f} MB for a tenth of the log, {peak(path) / 1024:.0f} MB for all of it")


if __name__ == "__main__":
    main()
