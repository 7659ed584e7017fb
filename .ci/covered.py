"""Say how much of the core's lines and of its branches the tests reach, and fail where either is less than 95 %."""

from __future__ import annotations

import json
import sys
from pathlib import Path

LEAST = 95


def main(report: str) -> int:
    """Read what ``coverage json`` wrote."""
    totals = json.loads(Path(report).read_text("utf-8"))["totals"]
    shares = {
        "lines": 100 * totals["covered_lines"] / totals["num_statements"],
        "branches": 100 * totals["covered_branches"] / totals["num_branches"],
    }
    for kind, share in shares.items():
        sys.stdout.write(f"{kind}: {share:.2f} % (at least {LEAST} %)\n")
    return int(min(shares.values()) < LEAST)


if __name__ == "__main__":
    sys.exit(main(sys.argv[1]))
