"""Say how much of the core's lines and of its branches the tests reach, and fail where it is less than the aim."""

from __future__ import annotations

import json
import sys
from pathlib import Path

LEAST = {"lines": 95, "branches": 88}
"""In percent, just under what the tests reach."""


def main(report: str) -> int:
    """Read what ``coverage json`` wrote."""
    totals = json.loads(Path(report).read_text("utf-8"))["totals"]
    shares = {
        "lines": 100 * totals["covered_lines"] / totals["num_statements"],
        "branches": 100 * totals["covered_branches"] / totals["num_branches"],
    }
    for kind, share in shares.items():
        sys.stdout.write(f"{kind}: {share:.2f} % (at least {LEAST[kind]} %)\n")
    return int(any(share < LEAST[kind] for kind, share in shares.items()))


if __name__ == "__main__":
    sys.exit(main(sys.argv[1]))
