"""What counts cost: a big table of them beside DuckDB's own reading, and another day beside a hundred that were counted. Not a test.

Run: python tests/benchmarks/tallies.py --contexts 100000
     python tests/benchmarks/tallies.py --days 100 --rows 1000000

What is compared runs by turns; medians of processor time are printed, and their ratios.
"""

from __future__ import annotations

import argparse
import tempfile
from pathlib import Path

from engines import made, medians, run

GROUPED = """\
import duckdb, sys
connection = duckdb.connect()
connection.execute(f"select shop, sex, hired, sum(n) from read_csv('{sys.argv[1]}') group by all").fetchnumpy()
"""
ROLES = ("--decision", "hired", "--group", "sex", "--context", "shop", "--utility", "yes")


def turns(commands: dict[str, list[tuple[str, ...]]], repeats: int) -> None:
    """Run processes by turns, and print what each group of them takes beside the first."""
    found: dict[str, list[tuple[float, ...]]] = {label: [] for label in commands}
    for _ in range(repeats):
        for label, processes in commands.items():
            measured = [run(*words) for words in processes]
            found[label].append((sum(wall for wall, _, _ in measured), sum(cpu for _, cpu, _ in measured), max(m for *_, m in measured)))
    base = None
    for label, listed in found.items():
        wall, cpu, memory = medians(listed)
        base = base or cpu
        print(f"  {label:<44} {wall:7.2f} s  CPU {cpu:6.2f} s, {cpu / base:5.2f} times  {memory:.2f} GB", flush=True)


def counts(folder: Path, contexts: int) -> Path:
    """Counts of 8 groups and 2 decisions in very many contexts, as CSV; made once."""
    import duckdb

    path = folder / f"counts-{contexts}.csv"
    if not path.exists():
        cells = f"range({contexts}) s(i), range(8) g(j), range(2) d(k)"
        columns = "'shop' || i as shop, chr(97 + j::int) as sex, if(k = 0, 'yes', 'no') as hired, 1 + hash(i * 16 + j * 2 + k) % 500 as n"
        duckdb.execute(f"copy (select {columns} from {cells} order by i, j, k) to '{path}' (format csv, header)")
    return path


def table(folder: Path, contexts: int, repeats: int) -> None:
    """Counts in a CSV, beside DuckDB's own reading."""
    path = counts(folder, contexts)
    certify = ("-m", "fairaudit", "certify", str(path), *ROLES, "--count", "n")
    print(f"\n{contexts * 16:.1e} counts as CSV")
    ways = {"DuckDB reads and groups them": GROUPED, "certify --confidence none": "", "certify": ""}
    commands = {
        label: [("-c", script, str(path)) if script else (*certify, *(["--confidence", "none"] if "none" in label else []))]
        for label, script in ways.items()
    }
    turns(commands, repeats)


def tally(log: Path, part: str) -> tuple[str, ...]:
    """Words that count a day."""
    return ("-m", "fairaudit", "tally", str(log), *ROLES[:6], "-o", part)


def daily(folder: Path, count: int, rows: int) -> tuple[list[Path], list[str]]:
    """Logs of some days and another one, and where their tallies are; all are counted."""
    columns = "['yes', 'no', 'maybe'][1 + (hash(i + {0}) % 3)::int] as hired, 'g' || (hash(i * 7 + {0}) % 8) as sex"
    columns += ", 's' || (hash(i * 11 + {0}) % 50) as shop"
    paths = [made(folder / f"day-{rows}-{day}.parquet", columns.format(day * rows), rows) for day in range(count + 1)]
    parts = [str(folder / f"tally-{rows}-{day}.parquet") for day in range(count + 1)]
    for path, part in zip(paths, parts, strict=True):
        run(*tally(path, part))
    return paths, parts


def days(folder: Path, count: int, rows: int, repeats: int) -> None:
    """Another day after many that were counted: its tally, and the certificate of all, in one step and in two."""
    import duckdb

    paths, parts = daily(folder, count, rows)
    text = folder / f"day-{rows}.csv"
    if not text.exists():
        duckdb.execute(f"copy (from '{paths[-1]}') to '{text}' (format csv, header)")
    first, one = ("-m", "fairaudit", "certify", *parts[:-1]), str(folder / "days.json")
    for kind, log in (("Parquet", paths[-1]), ("CSV", text)):
        print(f"\n{count} days of {rows:.0e} rows that were counted, and another one, {kind}")
        ways = {
            "that day alone, certify": [("-m", "fairaudit", "certify", str(log), *ROLES, "-o", one)],
            f"certify --keep, {count + 1} days": [(*first, str(log), *ROLES, "--keep", parts[-1], "-o", one)],
            "its tally, and certify of all": [tally(log, parts[-1]), (*first, parts[-1], *ROLES, "--count", "n", "-o", one)],
        }
        turns(ways, repeats)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--contexts", type=lambda text: int(float(text)), default=0)
    parser.add_argument("--days", type=int, default=0)
    parser.add_argument("--rows", type=lambda text: int(float(text)), default=1_000_000)
    parser.add_argument("--folder", type=Path, default=Path(tempfile.gettempdir()) / "fairaudit-bench")
    parser.add_argument("--repeats", type=int, default=5)
    chosen = parser.parse_args()
    chosen.folder.mkdir(parents=True, exist_ok=True)
    if chosen.contexts:
        table(chosen.folder, chosen.contexts, chosen.repeats)
    if chosen.days:
        days(chosen.folder, chosen.days, chosen.rows, chosen.repeats)


if __name__ == "__main__":
    main()
