"""What a table of probabilities costs beside the same table as counts, by their denominators. Nothing fails on time.

Run: python tests/benchmarks/probabilities.py --folder /tmp/bench
     python tests/benchmarks/probabilities.py --entries 100000 --repeats 3

Each is `fairaudit certify --confidence none -o …` in a process of its own, by turns; the ratios are those of processor time, which other
users of the machine disturb less.
"""

from __future__ import annotations

import argparse
import os
import statistics
import subprocess
import sys
import tempfile
from fractions import Fraction
from pathlib import Path

import numpy as np

FORMS = ("counts", "12 decimals", "17 decimals", "fractions", "floats")


def shapes(entries: int) -> list[tuple[int, int, int]]:
    """Contexts, groups and decisions: many contexts with two decisions, some with 20, and few with very many."""
    return [(entries // 400, 200, 2), (entries // 1_000, 50, 20), (10, 10, entries // 100)]


def numbers(form: str, cells: int, decisions: int, generator: np.random.Generator) -> list[str]:
    """Texts of the numbers of each cell, one cell after the other."""
    if form == "counts":
        return [str(v) for v in generator.integers(1, 10**6, cells * decisions).tolist()]
    rows = generator.dirichlet(np.ones(decisions), cells)
    if form == "floats":
        return [repr(v) for v in rows.ravel().tolist()]
    texts = []
    for row in rows.tolist():
        places = 0 if form == "fractions" else int(form.split()[0])
        bottom = int(generator.integers(2, 10**6)) if form == "fractions" else 10**places
        tops = [int(v * bottom) for v in row[:-1]]
        tops.append(bottom - sum(tops))
        texts += [str(Fraction(top, bottom)) if form == "fractions" else f"{top // bottom}.{top % bottom:0{places}d}" for top in tops]
    return texts


def written(path: Path, form: str, contexts: int, groups: int, decisions: int) -> None:
    """Write a table, the groups of each context beside each other."""
    texts = iter(numbers(form, contexts * groups, decisions, np.random.default_rng(0)))
    with path.open("w") as file:
        file.write("x,a,u,n\n")
        file.writelines(f"{x},g{a},u{u},{next(texts)}\n" for x in range(contexts) for a in range(groups) for u in range(decisions))


def seconds(path: Path, form: str) -> float:
    """Processor time of an audit, started and written included."""
    number = ("--count" if form == "counts" else "--probability", "n")
    columns = ("--decision", "u", "--group", "a", "--context", "x", "--utility", "u1", "--confidence", "none")
    before = os.times()
    command = [sys.executable, "-m", "fairaudit", "certify", str(path), *columns, *number, "-o", str(path.with_suffix(".json"))]
    subprocess.run(command, check=True, capture_output=True)
    after = os.times()
    return after.children_user + after.children_system - before.children_user - before.children_system


def main() -> None:
    """Print a table of ratios."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--entries", type=lambda text: int(float(text)), default=10**6)
    parser.add_argument("--repeats", type=int, default=5)
    parser.add_argument("--folder", type=Path)
    arguments = parser.parse_args()
    with tempfile.TemporaryDirectory() as made:
        folder = arguments.folder or Path(made)
        folder.mkdir(parents=True, exist_ok=True)
        for shape in shapes(arguments.entries):
            paths = {form: folder / f"{'x'.join(map(str, shape))}_{form.replace(' ', '_')}.csv" for form in FORMS}
            for form, path in paths.items():
                written(path, form, *shape)
            times: dict[str, list[float]] = {form: [] for form in paths}
            for _ in range(arguments.repeats):
                for form, path in paths.items():
                    times[form].append(seconds(path, form))
            medians = {form: statistics.median(found) for form, found in times.items()}
            said = ", ".join(f"{form} {medians[form]:.2f} s ({medians[form] / medians['counts']:.2f})" for form in paths)
            print(f"{' x '.join(map(str, shape))}: {said}", flush=True)


if __name__ == "__main__":
    main()
