"""What it costs to count a log again beside the audit of it, and that one changed row of a million is named. Nothing fails on time.

Run: python tests/benchmarks/recount.py --folder /tmp/bench
     python tests/benchmarks/recount.py --rows 10000000 --repeats 1

`verify` checks the certificate as well; what it takes without a recount is printed, too, so that the recount alone is the difference.
Its ratio is that of CPU seconds, which other users of the machine disturb less.
"""

from __future__ import annotations

import argparse
import json
import statistics
import subprocess
import sys
import tempfile
from pathlib import Path

from engines import run

SHAPES = {"20 contexts": 20, "one context for 20 rows": 0}


def made(path: Path, rows: int, contexts: int) -> None:
    """A log of two groups and two decisions."""
    import duckdb

    columns = (
        "case when random() < 0.6 then 'yes' else 'no' end as hired, case when random() < 0.5 then 'f' else 'm' end as sex, "
        f"'d' || (random() * {contexts or rows // 20})::int as dept"
    )
    form = "(header)" if path.suffix == ".csv" else "(format parquet)"
    duckdb.execute("select setseed(0.5)").execute(f"copy (select {columns} from range({rows})) to '{path}' {form}")


def measured(path: Path, folder: Path, repeats: int) -> list[str]:
    """Print what each command takes, and give the words of the one that recounts."""
    certificate, attestation = folder / "c.json", folder / "a.json"
    columns = ("--decision", "hired", "--group", "sex", "--context", "dept", "--utility", "yes", "--confidence", "none")
    certify = ("-m", "fairaudit", "certify", str(path), *columns, "-o", str(certificate), "--attest", str(attestation))
    run(*certify)
    table = folder / "c.table.jsonl"
    beside = ("--table", str(table)) if table.exists() else ()
    verify = ("-m", "fairaudit", "verify", str(certificate), *beside, "--attestation", str(attestation))
    commands = {"certify": certify, "verify": verify, "verify --recount": (*verify, "--recount", str(path))}
    found: dict[str, list[tuple[float, ...]]] = {label: [] for label in commands}
    for _ in range(repeats):
        for label, words in commands.items():
            found[label].append(run(*words))
    clock, processor = ({label: statistics.median(times[place] for times in own) for label, own in found.items()} for place in (0, 1))
    alone = processor["verify --recount"] - processor["verify"]
    said = ", ".join(f"{label} {clock[label]:.1f} s ({processor[label]:.1f} s of CPU)" for label in commands)
    memory = max(times[2] for times in found["verify --recount"])
    print(
        f"  {said}; the recount alone {alone:.1f} s, {alone / processor['certify']:.2f} x certify (at most 1.1); {memory:.2f} GB",
        flush=True,
    )
    return [sys.executable, *verify]


def changed(path: Path, words: list[str]) -> None:
    """Change one row of a text, and print what the recount says of it."""
    lines = path.read_text().splitlines()
    place = len(lines) // 2
    hired, *others = lines[place].split(",")
    lines[place] = ",".join(["no" if hired == "yes" else "yes", *others])
    other = path.with_name(f"changed-{path.name}")
    other.write_text("\n".join(lines) + "\n")
    answer = subprocess.run([*words, "--recount", str(other), "--format", "json"], capture_output=True, text=True, check=False)
    found = json.loads(answer.stdout)["result"]["recount"]
    named = [*found["first_cell"]["group"].values(), *found["first_cell"]["context"].values()]
    print(f"  row {place} was {hired},{','.join(others)}: {found['different_cells']} cell differs, {found['first_cell']}", flush=True)
    if (answer.returncode, found["different_cells"], named) != (1, 1, others):
        raise SystemExit("the changed row was not named")


def main() -> None:
    """Measure all shapes."""
    parser = argparse.ArgumentParser()
    parser.add_argument("--folder")
    parser.add_argument("--rows", type=lambda text: int(float(text)), default=1_000_000)
    parser.add_argument("--repeats", type=int, default=3)
    arguments = parser.parse_args()
    with tempfile.TemporaryDirectory(dir=arguments.folder) as name:
        for shape, contexts in SHAPES.items():
            for suffix in (".csv", ".parquet"):
                folder = Path(name) / f"{contexts}{suffix}"
                folder.mkdir()
                path = folder / f"log{suffix}"
                made(path, arguments.rows, contexts)
                print(f"{arguments.rows:,} rows, {shape}, {suffix[1:]}", flush=True)
                words = measured(path, folder, arguments.repeats)
                if suffix == ".csv":
                    changed(path, words)


if __name__ == "__main__":
    main()
