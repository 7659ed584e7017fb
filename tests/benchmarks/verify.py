"""What `verify` costs beside `json.loads` of the same files, by shapes of tables. Not a test: nothing passes or fails on time.

Run: python tests/benchmarks/verify.py --folder /tmp/bench

Each pair runs by turns, five times, each in a process of its own; medians of processor time.
"""

from __future__ import annotations

import argparse
import tempfile
from pathlib import Path

import numpy as np
from engines import medians, run

LOADS = """\
import json, sys
for path in sys.argv[1:]:
    with open(path, "rb") as file:
        for line in file if path.endswith("l") else [file.read()]:
            json.loads(line)
"""
COLUMNS = ("--decision", "u", "--group", "a", "--context", "x", "--utility", "1")
WITHOUT = ("--confidence", "none")
SHAPES: dict[str, tuple[tuple[int, int, int, int], tuple[str, ...]]] = {
    "100,000 contexts × 8 groups × 2 decisions, no intervals": ((100_000, 8, 2, 25), WITHOUT),
    "the same with intervals": ((100_000, 8, 2, 25), ()),
    "--max-local-ratio 5/4, inconclusive": ((100_000, 8, 2, 25), ("--max-local-ratio", "5/4")),
    "--max-local-ratio 5/4, within": ((20_000, 8, 2, 20_000), ("--max-local-ratio", "5/4")),
    "--max-local-ratio 1, exceeded": ((20_000, 8, 2, 20_000), ("--max-local-ratio", "1")),
    "20 contexts × 5,000 groups": ((20, 5_000, 2, 200), ()),
    "20,000 contexts × 8 groups × 10 decisions": ((20_000, 8, 10, 125), ()),
    "50 contexts × 40 groups": ((50, 40, 2, 500), ()),
    "20,000 contexts × 8 groups, probabilities": ((20_000, 8, 2, 1_000), WITHOUT),
    "50 contexts × 8 groups, 100,000 units of three rows": ((50, 8, 2, 100_000), ()),
}


def table(path: Path, shape: tuple[int, int, int, int]) -> None:
    """A table of counts, one line for each entry, whose groups differ a little."""
    contexts, groups, decisions, draws = shape
    pick = np.random.default_rng(0)
    sizes = pick.poisson(draws, (contexts, groups)) + 1
    if decisions == 2:
        yes = pick.binomial(sizes, 0.5 + 0.02 * np.arange(groups) / groups)
        counts = np.stack([sizes - yes, yes], axis=-1)
    else:
        counts = pick.multinomial(sizes, np.ones(decisions) / decisions)
    lines = np.column_stack([*(index.ravel() for index in np.indices(counts.shape)), counts.ravel()])
    with path.open("w") as file:
        file.write("x,a,u,n\n" + "c%d,g%d,%d,%d\n" * len(lines) % tuple(lines.ravel().tolist()))


def probabilities(path: Path, shape: tuple[int, int, int, int]) -> None:
    """The same as probabilities, each cell with a denominator of its own."""
    table(path, shape)
    rows = [line.split(",") for line in path.read_text().splitlines()[1:]]
    pairs = zip(rows[::2], rows[1::2], strict=True)
    lines = (f"{x},{a},{u},{n}/{int(one[3]) + int(other[3])}\n" for one, other in pairs for x, a, u, n in (one, other))
    path.write_text("x,a,u,n\n" + "".join(lines))


def units(path: Path, shape: tuple[int, int, int, int]) -> None:
    """A log of sampling units, each with three rows in one context."""
    contexts, groups, decisions, number = shape
    pick = np.random.default_rng(0)
    unit = np.repeat(np.arange(number), 3)
    columns = unit, unit % contexts, pick.integers(0, groups, len(unit)), pick.integers(0, decisions, len(unit))
    path.write_text("unit,x,a,u\n" + "v%d,c%d,g%d,%d\n" * len(unit) % tuple(np.column_stack(columns).ravel().tolist()))


KINDS = {"probabilities": (probabilities, ("--probability", "n")), "units": (units, ("--unit", "unit"))}


def main() -> None:
    parser = argparse.ArgumentParser()
    parser.add_argument("--folder", type=Path, default=Path(tempfile.gettempdir()))
    parser.add_argument("--repeats", type=int, default=5)
    given = parser.parse_args()
    given.folder.mkdir(parents=True, exist_ok=True)
    log, certificate, beside = (given.folder / name for name in ("counts.csv", "v.json", "v.table.jsonl"))
    for name, (shape, options) in SHAPES.items():
        beside.unlink(missing_ok=True)
        make, number = next((KINDS[kind] for kind in KINDS if kind in name), (table, ("--count", "n")))
        make(log, shape)
        _, certified, _ = run("-m", "fairaudit", "certify", str(log), *COLUMNS, *number, *options, "-o", str(certificate))
        files = [str(path) for path in (certificate, beside) if path.exists()]
        words = ("-m", "fairaudit", "verify", files[0], *(("--table", files[1]) if len(files) > 1 else ()))
        found = [(run("-c", LOADS, *files), run(*words)) for _ in range(given.repeats)]
        (_, loads, _), (_, verify, _) = medians([one for one, _ in found]), medians([other for _, other in found])
        size = sum(Path(path).stat().st_size for path in files[:1]) / 1e3
        print(
            f"{name:<56} certify {certified:5.1f} s, certificate {size:7.0f} kB; "
            f"json.loads {loads:5.2f} s, verify {verify:5.2f} s ({verify / loads:.1f} times)",
            flush=True,
        )


if __name__ == "__main__":
    main()
