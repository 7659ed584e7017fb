"""What an audit of a log costs beside the engine's own query, and beside other auditing tools. Not a test: nothing passes or fails on time.

Run: python tests/benchmarks/engines.py --rows 100000000 --folder /tmp/bench
     python tests/benchmarks/engines.py --cells 100000 --rows 20000000 --decisions 2      (very many contexts; --units likewise)
     python tests/benchmarks/engines.py --peers --rows 10000000        (needs aequitas and fairlearn)

Each pair of things that are compared runs by turns, five times; the medians are printed. CPU is that of the process and its threads, which
other users of the machine disturb less than the time on the clock.
"""

from __future__ import annotations

import argparse
import os
import resource
import statistics
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
from timing import environment

PLAIN = """\
import duckdb, sys
print(len(duckdb.connect().execute(f"select x, a, u, count(*) from '{sys.argv[1]}' group by x, a, u").fetchall()))
"""
LOGS = {
    "8 groups, integers": "(hash(i + 1000000007) % 8)::utinyint as a",
    "200 groups, texts": "'group-' || (hash(i + 1000000007) % 200)::varchar as a",
}


def generated(folder: Path, name: str, rows: int) -> Path:
    """A log of 50 contexts and 10 decisions as Parquet."""
    columns = f"(hash(i) % 50)::utinyint as x, {LOGS[name]}, (hash(i * 3 + 7) % 10)::utinyint as u"
    return made(folder / f"{'int' if 'integers' in name else 'text'}-{rows}.parquet", columns, rows)


def run(*words: str) -> tuple[float, float, float]:
    """Seconds on the clock, CPU seconds, and the most memory in GB, of a process."""
    started = time.perf_counter()
    process = subprocess.Popen([sys.executable, *words], stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL, env=environment())
    _, status, used = os.wait4(process.pid, 0)
    if os.waitstatus_to_exitcode(status) not in (0, 1, 3):
        raise SystemExit(f"{words} failed")
    return time.perf_counter() - started, used.ru_utime + used.ru_stime, used.ru_maxrss / 1e6


def medians(measured: list[tuple[float, ...]]) -> tuple[float, ...]:
    return tuple(map(statistics.median, zip(*measured, strict=True)))


def processes(folder: Path, rows: int, repeats: int) -> None:
    columns = ("--decision", "u", "--group", "a", "--context", "x", "--utility", "1,2,3,4,5")
    for name in LOGS:
        path = generated(folder, name, rows)
        written = ("-o", str(folder / "c.json"))
        commands = {
            "the query alone": ("-c", PLAIN, str(path)),
            "certify": ("-m", "fairaudit", "certify", str(path), *columns, *written),
            "certify --confidence none": ("-m", "fairaudit", "certify", str(path), *columns, "--confidence", "none", *written),
        }
        found: dict[str, list[tuple[float, ...]]] = {label: [] for label in commands}
        for _ in range(repeats):
            for label, words in commands.items():
                found[label].append(run(*words))
        print(f"\n{rows:.0e} rows, {name}, Parquet")
        base = medians(found["the query alone"])
        for label, measured in found.items():
            wall, cpu, memory = medians(measured)
            print(f"  {label:<28} {wall:7.2f} s ({wall - base[0]:+.2f})  CPU {cpu:6.2f} s ({cpu - base[1]:+.2f})  {memory:.2f} GB")


def cells(folder: Path, rows: int, contexts: int, decisions: int, repeats: int) -> None:
    """Very many contexts: exact, with intervals (of at most 100,000 contexts), and in parts; and what it costs to check each."""
    path = made(
        folder / f"wide-{contexts}-{decisions}-{rows}.parquet",
        f"(hash(i) % {contexts})::integer as x, (hash(i * 7 + 1) % 8)::utinyint as a, (hash(i * 3 + 7) % {decisions})::utinyint as u",
        rows,
    )
    columns = ("--decision", "u", "--group", "a", "--context", "x", "--utility", "1")
    written, table = str(folder / "w.json"), str(folder / "w.table.jsonl")
    ways = {"in parts, --memory 2GB": ("--confidence", "none", "--in-parts", "--memory", "2GB")}
    if contexts <= 1_000_000:
        ways["exact"] = ("--confidence", "none")
    if contexts <= 100_000:
        ways["with intervals"] = ()
    print(f"\n{rows:.0e} rows, {contexts} contexts, 8 groups, {decisions} decisions")
    for name, more in ways.items():
        wall, cpu, memory = medians([run("-m", "fairaudit", "certify", str(path), *columns, *more, "-o", written) for _ in range(repeats)])
        print(f"  {name:<24} certify {wall:7.2f} s  CPU {cpu:7.2f} s  {memory:.2f} GB", flush=True)
        wall, cpu, memory = run("-m", "fairaudit", "verify", written, "--table", table)
        print(f"  {'':<24} verify  {wall:7.2f} s  CPU {cpu:7.2f} s  {memory:.2f} GB", flush=True)


def units(folder: Path, rows: int, repeats: int) -> None:
    """Sampling units with three rows each."""
    columns = "'user-' || (i // 3) as unit, (hash(i // 3) % 50)::integer as x, (hash((i // 3) * 7 + 1) % 8)::utinyint as a"
    path = made(folder / f"units-{rows}.parquet", f"{columns}, (hash(i * 3 + 7) % 2)::utinyint as u", rows)
    words = ("--decision", "u", "--group", "a", "--context", "x", "--utility", "1", "--unit", "unit")
    wall, cpu, memory = medians([run("-m", "fairaudit", "certify", str(path), *words) for _ in range(repeats)])
    print(f"\n{rows // 3} units of three rows: certify {wall:.2f} s  CPU {cpu:.2f} s  {memory:.2f} GB")


def made(path: Path, columns: str, rows: int) -> Path:
    """A log as Parquet; made once."""
    import duckdb

    if not path.exists():
        connection = duckdb.connect()
        connection.execute("set preserve_insertion_order = false")
        connection.execute(f"copy (select {columns} from range({rows}) t(i)) to '{path}.part' (format parquet)")
        Path(f"{path}.part").rename(path)
    return path


def growth(folder: Path, rows: int, repeats: int) -> None:
    """Marginal cost per row from a tenth of the rows to all of them."""
    columns = ("--decision", "u", "--group", "a", "--context", "x", "--utility", "1,2,3,4,5")
    name = next(iter(LOGS))
    paths = [generated(folder, name, n) for n in (rows // 10, rows)]
    found: dict[tuple[str, int], list[tuple[float, ...]]] = {}
    for _ in range(repeats):
        for size, path in enumerate(paths):
            found.setdefault(("query", size), []).append(run("-c", PLAIN, str(path)))
            found.setdefault(("certify", size), []).append(run("-m", "fairaudit", "certify", str(path), *columns))
    print(f"\nMarginal cost per row, {rows // 10:.0e} to {rows:.0e}")
    slopes = {
        what: [(b - a) / (rows * 0.9) * 1e9 for a, b in zip(medians(found[what, 0]), medians(found[what, 1]), strict=True)]
        for what in ("query", "certify")
    }
    for what, (wall, cpu, _) in slopes.items():
        print(f"  {what:<10} {wall:6.2f} ns on the clock, {cpu:6.2f} ns of CPU")
    print(
        f"  ratio      {slopes['certify'][0] / slopes['query'][0]:.2f}, CPU {slopes['certify'][1] / slopes['query'][1]:.2f} (at most 1.20)"
    )


def timed(work: Callable[[], Any], repeats: int) -> tuple[float, float]:
    measured = []
    for _ in range(repeats):
        wall, cpu = time.perf_counter(), time.process_time()
        work()
        measured.append((time.perf_counter() - wall, time.process_time() - cpu))
    wall, cpu = medians(measured)
    return wall, cpu


GROUPS = ["sex", "ethnic", "age"]


def people(rows: int) -> dict[str, Any]:
    """Frames of the same rows, 120 cells: 2 x 5 x 3 groups in 4 contexts. Aequitas takes texts as objects only, in one column."""
    import pandas as pd

    generator = np.random.default_rng(1)
    labels = {"sex": ["f", "m"], "ethnic": list("ABCDE"), "age": ["young", "middle", "old"], "dept": list("wxyz")}
    codes = {name: generator.integers(0, len(listed), rows) for name, listed in labels.items()}
    frame = pd.DataFrame({name: np.array(listed)[codes[name]] for name, listed in labels.items()})
    frame["score"], frame["label_value"] = generator.integers(0, 2, rows), generator.integers(0, 2, rows)
    frame["cell"] = frame.sex + "|" + frame.ethnic + "|" + frame.age + "|" + frame.dept
    return {
        "texts": frame,
        "objects": frame.astype(dict.fromkeys([*labels, "cell"], object)),
        "categories": frame.astype(dict.fromkeys(labels, "category")),
        "integers": frame.assign(**codes),
    }


def ours(table: Any, confidence: Any) -> Any:
    """The audit of a frame of people."""
    import fairaudit as fa

    law = fa.Law.from_log(table, decision="score", group=GROUPS, context="dept")
    return fa.certify(law, {"1": 1}, confidence=confidence)


def cells_of_people(kinds: dict[str, Any], library: str, rows: int) -> Callable[[], Any]:
    """What another tool says of the first rows of them."""
    if library == "aequitas":
        from aequitas.group import Group

        few = kinds["objects"].head(rows)[["cell", "score", "label_value"]]
        return lambda: Group().get_crosstabs(few.copy(), attr_cols=["cell"])
    from fairlearn.metrics import MetricFrame, selection_rate

    few = kinds["texts"].head(rows)
    columns = {"y_true": few.label_value, "y_pred": few.score, "sensitive_features": few[GROUPS], "control_features": few[["dept"]]}
    return lambda: MetricFrame(metrics=selection_rate, **columns).ratio()


def peers(rows: int, repeats: int, with_fairlearn: int) -> None:
    """One process, everything imported, frames in memory."""
    kinds = people(rows)
    ours(kinds["texts"].head(1000), 0.95)
    times: dict[str, tuple[float, float]] = {}
    print(f"\n{rows:.0e} rows in one process, 120 cells")
    for kind, table in kinds.items():
        for confidence in (None, 0.95):
            wall, cpu = timed(lambda table=table, confidence=confidence: ours(table, confidence), repeats)
            times[f"{kind} {confidence}"] = wall, cpu
            print(
                f"  fairaudit, pandas {kind:<11} {'with intervals' if confidence else 'exact figures':<15} {wall:8.3f} s  CPU {cpu:8.3f} s"
            )
    for library, taken in (("aequitas", rows), ("fairlearn", with_fairlearn)):
        if not taken:
            continue
        try:
            work = cells_of_people(kinds, library, taken)
        except ImportError:
            print(f"  {library} is not installed")
            continue
        seconds = [one * rows / taken for one in timed(work, repeats if library == "aequitas" else 1)]
        scaled = "" if taken == rows else f", times {rows / taken:.0f}"
        print(f"  {library}, {taken:.0e} rows{scaled}: {seconds[0]:.3f} s  CPU {seconds[1]:.3f} s")
        for what, theirs, place in (("on the clock", seconds[0], 0), ("of the processor", seconds[1], 1)):
            said = ", ".join(f"{kind} {theirs / times[f'{kind} None'][place]:.1f}" for kind in kinds)
            print(f"    times as long as ours {what}: {said}")
    print(f"  most memory {resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1e6:.1f} GB")


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--rows", type=lambda text: int(float(text)), default=10_000_000)
    parser.add_argument("--folder", type=Path, default=Path(tempfile.gettempdir()) / "fairaudit-bench")
    parser.add_argument("--repeats", type=int, default=5)
    parser.add_argument("--peers", action="store_true", help="compare with aequitas and fairlearn instead")
    parser.add_argument("--fairlearn-rows", type=lambda text: int(float(text)), default=1_000_000, help="0 leaves it out")
    parser.add_argument("--cells", type=lambda text: int(float(text)), metavar="CONTEXTS", help="a log of so many contexts instead")
    parser.add_argument("--decisions", type=int, default=2, help="with --cells")
    parser.add_argument("--units", action="store_true", help="a log of sampling units instead")
    chosen = parser.parse_args()
    if chosen.peers:
        peers(chosen.rows, chosen.repeats, chosen.fairlearn_rows)
        return
    chosen.folder.mkdir(parents=True, exist_ok=True)
    if chosen.cells:
        cells(chosen.folder, chosen.rows, chosen.cells, chosen.decisions, chosen.repeats)
        return
    if chosen.units:
        units(chosen.folder, chosen.rows, chosen.repeats)
        return
    processes(chosen.folder, chosen.rows, chosen.repeats)
    growth(chosen.folder, chosen.rows, chosen.repeats)


if __name__ == "__main__":
    main()
