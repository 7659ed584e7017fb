"""How long a browser is busy with a report after it is loaded. Not a test: nothing passes or fails on time.

Run: python tests/benchmarks/report.py
"""

from __future__ import annotations

import statistics
import sys
import tempfile
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))

from browser import Browser
from certificate_kinds import fifty_by_forty

from fairaudit.reports.page import html

RUNS = 7


def main() -> None:
    """Load a page of 50 contexts by 40 groups several times, in one browser."""
    text = html(fifty_by_forty().certificate)
    with tempfile.TemporaryDirectory() as directory:
        page = Path(directory) / "page.html"
        page.write_text(text, "utf-8")
        browser = Browser(Path(directory) / "profile")
        longest, totals = [], []
        for _ in range(RUNS):
            browser.open(page)
            loaded = browser.run("return performance.timing.loadEventEnd - performance.timeOrigin")
            tasks = [duration for start, duration in browser.run("return longTasks") if start >= loaded]
            longest.append(max(tasks, default=0))
            totals.append(browser.run("return performance.now()") - loaded)
        nodes = browser.run("return document.querySelectorAll('*').length")
        browser.close()
    print(f"page of 50 contexts by 40 groups: {len(text.encode()):,} bytes, {nodes:,} elements")
    print(f"longest task after load: median {statistics.median(longest):.0f} ms, greatest {max(longest):.0f} ms (0: none above 50 ms)")
    print(f"from load to the finished check: median {statistics.median(totals):.0f} ms")


if __name__ == "__main__":
    main()
