"""One table of what things cost beside what else would do them, each a ratio of processor time in one run. Nothing passes or fails on time.

Run: python tests/benchmarks/table.py                        (small, less than a minute: prints the table, records nothing)
     python tests/benchmarks/table.py --size full            (some twenty minutes and 10 GB of memory)
     python tests/benchmarks/table.py --size full --record   (and adds it to history.jsonl and writes docs/performance.md)
     python tests/benchmarks/table.py --size full --record --only help counts     (these rows; they join others of the same commit)

What is compared runs by turns, after a first turn that is not counted; the ratio is that of the medians.
"""

from __future__ import annotations

import argparse
import json
import os
import platform
import statistics
import subprocess
import sys
import tempfile
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from datetime import UTC, datetime
from functools import cache
from pathlib import Path
from resource import RUSAGE_CHILDREN, RUSAGE_SELF, getrusage
from typing import Any

import numpy as np
from engines import PLAIN, cells_of_people, generated, ours, people
from evaluations import FORMATS, parsed
from startup import EXAMPLE
from tallies import GROUPED, ROLES, counts, daily
from timing import environment

Work = Sequence[str] | Callable[[], Any]

HISTORY = Path(__file__).with_name("history.jsonl")
PAGE = Path(__file__).parents[2] / "docs" / "performance.md"
BEGIN, END = "<!-- table of tests/benchmarks/table.py -->", "<!-- end of the table -->"
COLUMNS = ("--decision", "u", "--group", "a", "--context", "x", "--utility", "1,2,3,4,5")
NUMPY = ("-c", "import numpy")
LOADS = """\
import json, sys
for path in sys.argv[1:]:
    with open(path, "rb") as file:
        [json.loads(text) for text in (file if path.endswith("l") else [file.read()])]
"""


@dataclass(frozen=True)
class Row:
    """Something that is measured.

    Attributes
    ----------
    what, beside : str
        What takes time, and what it is compared with; ``{}`` stands for the size.
    sizes : tuple of int
        The small and the full size.
    works : callable
        Gives, for a folder and a size, what is run for either: words of a Python process, or a function.
    needs : str
        The library that it is compared with, if not everybody has it.
    share : int
        Of what part of the size the comparison runs: its time is multiplied by that.
    """

    what: str
    beside: str
    sizes: tuple[int, int]
    works: Callable[[Path, int], tuple[Work, Work]]
    needs: str = ""
    share: int = 1


def certify(*words: object) -> tuple[str, ...]:
    return ("-m", "fairaudit", "certify", *map(str, words))


def counted(folder: Path, contexts: int, *more: str) -> tuple[Work, Work]:
    """The audit of a CSV of counts, and the engine reading and grouping them."""
    path = counts(folder, contexts)
    return certify(path, *ROLES, "--count", "n", *more, "-o", folder / "counts.json"), ("-c", GROUPED, str(path))


def verified(folder: Path, contexts: int) -> tuple[Work, Work]:
    run(counted(folder, contexts, "--confidence", "none")[0])
    files = [str(path) for path in (folder / "counts.json", folder / "counts.table.jsonl") if path.exists()]
    beside = ("--table", files[1]) if len(files) > 1 else ()
    return ("-m", "fairaudit", "verify", files[0], *beside), ("-c", LOADS, *files)


def probable(folder: Path, rows: int) -> tuple[Work, Work]:
    """The audit of random probabilities, and of the same table as counts."""
    values = np.random.default_rng(1).random((rows // 20, 10, 2))
    values /= values.sum(axis=2, keepdims=True)
    tables = {"probability": values, "count": np.ceil(values * 1000).astype(int)}
    for name, table in tables.items():
        (folder / f"{name}-{rows}.csv").write_text(
            f"shop,sex,hired,{name}\n"
            + "\n".join(
                f"s{shop},{group},{decision},{p if name == 'count' or decision == 'yes' else 1 - row[0]}"
                for shop, groups in enumerate(table.tolist())
                for group, row in enumerate(groups)
                for decision, p in zip(("yes", "no"), row, strict=True)
            )
            + "\n"
        )
    probability, count = (
        certify(folder / f"{name}-{rows}.csv", *ROLES, f"--{name}", name, "--confidence", "none", "-o", folder / "p.json")
        for name in tables
    )
    return probability, count


def queried(name: str) -> Callable[[Path, int], tuple[Work, Work]]:
    def works(folder: Path, rows: int) -> tuple[Work, Work]:
        path = generated(folder, name, rows)
        return certify(path, *COLUMNS, "-o", folder / "query.json"), ("-c", PLAIN, str(path))

    return works


@cache
def frames(rows: int) -> dict[str, Any]:
    return people(rows)


def peer(kind: str, library: str) -> Callable[[Path, int], tuple[Work, Work]]:
    def works(_: Path, rows: int) -> tuple[Work, Work]:
        held = frames(rows)
        return lambda: ours(held[kind], None), cells_of_people(held, library, rows // 10 if library == "fairlearn" else rows)

    return works


def another_day(folder: Path, rows: int) -> tuple[Work, Work]:
    paths, parts = daily(folder, 100 if rows > 100_000 else 5, rows)
    kept = certify(*parts[:-1], paths[-1], *ROLES, "--keep", parts[-1], "-o", folder / "days.json")
    return kept, certify(paths[-1], *ROLES, "-o", folder / "day.json")


def samples(folder: Path, rows: int) -> tuple[Work, Work]:
    import fairaudit as fa

    kind = FORMATS["lm-eval"]
    path = folder / f"{rows}-{kind.name}"
    kind.write(path, kind.rows(rows, 1))
    return lambda: fa.read_log(path, kind.columns, decision=kind.columns[0]), lambda: parsed(path)


def local(_: Path, contexts: int) -> tuple[Work, Work]:
    from fairaudit import Law, Utility
    from fairaudit.measures.ratios import local_fairness

    held = np.random.default_rng(1).random((contexts, 100, 1000))
    held /= held.sum(axis=2, keepdims=True)
    law, g = Law.from_array(held), np.linspace(0, 1, 1000)
    utility = Utility({u: i for i, u in enumerate(law.decisions)}).on(law)
    return lambda: local_fairness(law, utility), lambda: np.vecdot(held, g)


ROWS = {
    "help": Row("`fairaudit --help`", "`import numpy`", (1, 1), lambda *_: (("-m", "fairaudit", "--help"), NUMPY)),
    "example": Row("`certify --example ucb-admissions`, with intervals", "`import numpy`", (1, 1), lambda *_: (EXAMPLE, NUMPY)),
    "counts": Row(
        "`certify --confidence none` of counts in a CSV, {} contexts of 16",
        "DuckDB reads and groups the file",
        (5000, 100_000),
        lambda folder, size: counted(folder, size, "--confidence", "none"),
    ),
    "counts-intervals": Row("the same with intervals, {} contexts", "DuckDB reads and groups the file", (5000, 100_000), counted),
    "verify": Row("`verify` of that certificate, {} contexts", "`json.loads` of its files", (5000, 100_000), verified),
    "probabilities": Row(
        "`certify --confidence none` of {} random probabilities", "the same table as counts", (20_000, 1_000_000), probable
    ),
    "query": Row(
        "`certify` of a log in Parquet, {} rows, 8 groups as integers",
        "the plain query in DuckDB",
        (1_000_000, 100_000_000),
        queried("8 groups, integers"),
    ),
    "query-texts": Row(
        "`certify` of a log in Parquet, {} rows, 200 groups as texts",
        "the plain query in DuckDB",
        (1_000_000, 100_000_000),
        queried("200 groups, texts"),
    ),
    "day": Row(
        "another day of {} rows after many that are tallies: `certify --keep`", "`certify` of that day", (10_000, 1_000_000), another_day
    ),
    "texts-aequitas": Row("a pandas frame of {} rows, texts", "Aequitas", (100_000, 10_000_000), peer("texts", "aequitas"), "aequitas"),
    "categories-aequitas": Row(
        "a pandas frame of {} rows, categories", "Aequitas", (100_000, 10_000_000), peer("categories", "aequitas"), "aequitas"
    ),
    "texts-fairlearn": Row(
        "a pandas frame of {} rows, texts", "Fairlearn", (100_000, 10_000_000), peer("texts", "fairlearn"), "fairlearn", 10
    ),
    "categories-fairlearn": Row(
        "a pandas frame of {} rows, categories", "Fairlearn", (100_000, 10_000_000), peer("categories", "fairlearn"), "fairlearn", 10
    ),
    "samples": Row("reading {} samples of lm-evaluation-harness", "Python's JSON parser", (10_000, 1_000_000), samples),
    "dense": Row("the exact local ratio of a dense law, {} × 100 × 1000", "`np.vecdot` alone", (10, 1000), local),
}


def run(work: Work) -> float:
    """Processor seconds of this process, its threads and what it starts."""

    def used() -> float:
        return sum(one.ru_utime + one.ru_stime for one in map(getrusage, (RUSAGE_SELF, RUSAGE_CHILDREN)))

    before = used()
    if callable(work):
        work()
        return used() - before
    answer = subprocess.run([sys.executable, *work], capture_output=True, text=True, check=False, env=environment())
    if answer.returncode not in (0, 3):
        raise SystemExit(f"{work} failed: {answer.stderr}")
    return used() - before


def measured(row: Row, folder: Path, full: bool, repeats: int) -> dict[str, float] | None:
    """The medians of both, and their ratio; None where the library to compare with is absent."""
    if row.needs:
        try:
            __import__(row.needs)
        except ImportError:
            return None
    both = row.works(folder, row.sizes[full])
    turns = [[run(work) for work in both] for _ in range(repeats + 1)][1:]
    own, beside = (statistics.median(times) for times in zip(*turns, strict=True))
    beside *= row.share
    return {"seconds": round(own, 4), "beside": round(beside, 4), "ratio": float(f"{own / beside:.3g}")}


def ratio(found: Mapping[str, float] | None) -> str:
    """How many times as long, as people read it.

    Examples
    --------
    >>> ratio({"ratio": 2.345}), ratio({"ratio": 0.01}), ratio(None)
    ('2.3', '1/100', '–')
    """
    if found is None:
        return "–"
    return f"{found['ratio']:.2g}" if found["ratio"] >= 0.1 else f"1/{1 / found['ratio']:,.0f}"


def rendered(entries: Sequence[Mapping[str, Any]]) -> str:
    """The table of some runs: of each line the last one in which it was measured, beside the one before."""
    last = entries[-1]
    lines = [
        f"fairaudit {last['version']}, {last['date']}, {last['cores']} cores, Python {last['python']}, {last['size']} size:",
        "",
        "| | beside | times as long | before | seconds of the processor |",
        "| --- | --- | --- | --- | --- |",
    ]
    for name, row in ROWS.items():
        before, found = [None, None, *filter(None, (entry["rows"].get(name) for entry in entries))][-2:]
        said = row.what.format(f"{row.sizes[last['size'] == 'full']:,}")
        seconds = f"{found['seconds']:.3g}" if found else "–"
        lines.append(f"| {said} | {row.beside} | {ratio(found)} | {ratio(before)} | {seconds} |")
    return "\n".join(lines)


def recorded() -> list[dict[str, Any]]:
    """The runs that were recorded, in their order."""
    return [json.loads(line) for line in HISTORY.read_text().splitlines()] if HISTORY.exists() else []


def added(entries: Sequence[dict[str, Any]], entry: dict[str, Any]) -> list[dict[str, Any]]:
    """Runs with another one; rows that were measured of the same commit join it."""
    *others, last = entries or [{}]
    if {**last, "rows": 0, "date": 0} == {**entry, "rows": 0, "date": 0}:
        return [*others, {**entry, "rows": last["rows"] | entry["rows"]}]
    return [*entries, entry]


def written(page: str, table: str) -> str:
    """A page with its table written anew."""
    start, end = page.index(BEGIN) + len(BEGIN), page.index(END)
    return f"{page[:start]}\n\n{table}\n\n{page[end:]}"


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--size", choices=("small", "full"), default="small")
    parser.add_argument("--record", action="store_true", help="add the run to history.jsonl, and write docs/performance.md anew")
    parser.add_argument("--only", nargs="+", choices=tuple(ROWS), default=list(ROWS), metavar="ROW", help="these rows: %(choices)s")
    parser.add_argument("--repeats", type=int, help="5 at full size, else 1")
    parser.add_argument("--folder", type=Path, help="where logs are made, and kept for the next run")
    chosen = parser.parse_args()
    full = chosen.size == "full"
    if chosen.record and not full:
        parser.error("--record takes --size full: small runs say little")
    import fairaudit

    commit = subprocess.run(["git", "rev-parse", "--short", "HEAD"], cwd=PAGE.parent, capture_output=True, text=True, check=False).stdout
    entry: dict[str, Any] = {
        "version": fairaudit.__version__,
        "commit": commit.strip(),
        "date": f"{datetime.now(UTC):%Y-%m-%d}",
        "cores": os.cpu_count(),
        "python": platform.python_version(),
        "size": chosen.size,
        "rows": {},
    }
    with tempfile.TemporaryDirectory() as name:
        folder = chosen.folder or Path(name)
        folder.mkdir(parents=True, exist_ok=True)
        for key in chosen.only:
            entry["rows"][key] = measured(ROWS[key], folder, full, chosen.repeats or (5 if full else 1))
            print(f"{key:<22} {ratio(entry['rows'][key])}", file=sys.stderr, flush=True)
    entries = added(recorded(), entry) if full else [entry]
    print(rendered(entries))
    if chosen.record:
        HISTORY.write_text("".join(json.dumps(one) + "\n" for one in entries))
        PAGE.write_text(written(PAGE.read_text(), rendered(entries)))


if __name__ == "__main__":
    main()
