"""Ratios of times and memory that the navigation plug-in promises, measured in one run. Not a test: nothing passes or fails on time.

Run: python tests/benchmarks/navigation.py
"""

from __future__ import annotations

import subprocess
import sys
import tempfile
import time
from pathlib import Path

import numpy as np
from timing import median

from fairaudit.plugins.navigation.maps import CHUNK, Maps, raise_tops, rasterise
from fairaudit.plugins.navigation.readers import Part, Points, read_points
from fairaudit.plugins.navigation.routes import _allowed, _graph, flood

POINTS = 10_000_000

CLOCK = time.process_time  # which other processes disturb less than the clock on the wall; nothing here runs in parallel


def cloud(size: int) -> Points:
    """A floor of 40 m × 25 m, a wall of points up to 3 m everywhere."""
    random = np.random.default_rng(1)
    xyz = random.random((size, 3)) * [40.0, 25.0, 3.0]
    rgb = random.integers(0, 256, (size, 3), dtype=np.uint8)
    return Points(xyz, rgb, (Part(0, size, "hall_1", "wall", "wall_1"),), {})


def rasterising() -> None:
    points = cloud(POINTS)
    found: Maps = rasterise(points, 0.05, floor=0.0)
    frame = found.frame
    rows = frame.rows - 1 - ((points.xyz[:, 1] - frame.y) / frame.resolution).astype(np.int64)
    cells = rows * frame.columns + ((points.xyz[:, 0] - frame.x) / frame.resolution).astype(np.int64)
    z = np.ascontiguousarray(points.xyz[:, 2])
    top = np.full(frame.rows * frame.columns, -np.inf)

    def library() -> None:
        top.fill(-np.inf)
        np.maximum.at(top, cells, z)

    def with_cells() -> None:
        top.fill(-np.inf)
        rows = frame.rows - 1 - ((points.xyz[:, 1] - frame.y) / frame.resolution).astype(np.int64)
        np.maximum.at(top, rows * frame.columns + ((points.xyz[:, 0] - frame.x) / frame.resolution).astype(np.int64), points.xyz[:, 2])

    colours = np.empty(len(top), np.int32)

    def kernel() -> None:
        top.fill(-np.inf)
        colours.fill(-1)
        for first in range(0, POINTS, CHUNK):
            there = slice(first, first + CHUNK)
            raise_tops(top, colours, cells[there], z[there], points.rgb[there])

    times = [median(work, clock=CLOCK) for work in (library, kernel, with_cells, lambda: rasterise(points, 0.05, floor=0.0))]
    seen = np.isfinite(top)
    assert (np.isfinite(found.height.ravel()) == seen).all() and np.abs(found.height.ravel()[seen] - top[seen]).max() < 1e-10
    print(f"1e7 points on {frame.rows} x {frame.columns} cells: maximum.at {times[0]:.3f} s, top view with colours on the same cells")
    print(f"    {times[1]:.3f} s   {times[1] / times[0]:.2f} x (at most 5)")
    print(f"    from coordinates: cells and maximum.at {times[2]:.3f} s, all maps {times[3]:.3f} s   {times[3] / times[2]:.2f} x")


def planning() -> None:
    from scipy.sparse.csgraph import dijkstra

    random = np.random.default_rng(2)
    for share in (0.0, 0.2, 0.3):
        free = random.random((1000, 1000)) >= share
        free[0, 0] = free[-1, -1] = True
        graph = _graph(_allowed(free, corner_cutting=False))
        library = median(lambda graph=graph: dijkstra(graph, indices=0), clock=CLOCK)
        ours = median(lambda free=free: flood(free, (0, 0)).route((999, 999)), clock=CLOCK)
        print(f"1000 x 1000 cells, {share:.0%} blocked: dijkstra {library:.3f} s, routes {ours:.3f} s   {ours / library:.2f} x (at most 2)")


def reading(lines: int) -> None:
    """Peak memory of a process that reads a text file, or a file of annotations, beyond one that only imports."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "scan.txt"
        random = np.random.default_rng(3)
        with path.open("w") as file:
            for _ in range(0, lines, 100_000):
                xyz, rgb = random.random((100_000, 3)) * 40, random.integers(0, 256, (100_000, 3))
                file.writelines(f"{x:.3f} {y:.3f} {z:.3f} {r} {g} {b}\n" for (x, y, z), (r, g, b) in zip(xyz, rgb, strict=True))
        seconds = median(lambda: read_points(path), 1, CLOCK)
        peaks = [process(path, read) for read in ("nothing", "points", "maps")]
    size = lines * 27
    beyond = [(peak - peaks[0]) / size for peak in peaks]
    print(
        f"{lines:,} lines read in {seconds:.2f} s ({lines / seconds / 1e6:.1f} million a second); points of "
        f"{size / 1e6:.0f} MB: peak {beyond[1]:.2f} x, with maps {beyond[2]:.2f} x (at most 3)"
    )


def process(path: Path, what: str) -> int:
    """Peak memory in bytes."""
    done = subprocess.run([sys.executable, __file__, what, str(path)], check=True, capture_output=True, text=True)
    return int(done.stdout)


def child(what: str, path: str) -> None:
    import pandas as pd  # noqa: F401

    if what != "nothing":
        points = read_points(path)
        if what == "maps":
            rasterise(points, 0.05)
    peak = next(line for line in Path("/proc/self/status").read_text().splitlines() if line.startswith("VmHWM"))
    print(int(peak.split()[1]) * 1024)


def main() -> None:
    if len(sys.argv) == 3:
        child(sys.argv[1], sys.argv[2])
        return
    rasterising()
    planning()
    reading(5_000_000)


if __name__ == "__main__":
    main()
