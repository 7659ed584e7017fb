"""A scan made to stand upright, in metres, on a level floor, without stray points; and whether its points are dense enough for a map."""

from __future__ import annotations

from dataclasses import replace
from itertools import product
from math import cos, degrees, pi, radians, sqrt

import numpy as np
from numpy.typing import NDArray

from fairaudit.errors import InputError, nearest, shown
from fairaudit.plugins.navigation.maps import BAND, floor_height
from fairaudit.plugins.navigation.readers import Part, Points

UNITS = {"m": 1.0, "cm": 0.01, "mm": 0.001, "ft": 0.3048}
UPS = {"z": (0, 1, 2), "y": (2, 0, 1), "x": (1, 2, 0), "-z": (1, 0, 2), "-y": (0, 2, 1), "-x": (2, 1, 0)}  # new x, y and z
SAMPLE = 40_000
NEIGHBOURS = 12
STEEPEST = radians(15.0)
TRIPLES, PLANES = 256, 4
NEAR = 0.03
NOTICED = 0.02
COMPANY, LEAST = 4, 100
SIDES = (0.25, 0.1)
TALL, LOWEST = 1000.0, 2.2
STEPS = (0.05, 0.06, 0.08, 0.1, 0.12, 0.15, 0.2, 0.25, 0.3, 0.4, 0.5)
HOLES, MOST_CELLS = 0.02, 10**8

_Array = NDArray[np.float64]


def prepare(points: Points, *, unit: str | None = None, up: str | None = None, level: bool = True, stray: bool = True) -> Points:
    """Make a scan stand upright, in metres, on a level floor, and remove its stray points.

    The unit is one of `UNITS`, by default metres, or millimetres if the scan would be 1 km high; up is one of `UPS`, by default z, or y if
    the scan is flat along y and most of its surfaces face that way. There is a note for everything that was done.

    Notes
    -----
    The floor is the lowest of the planes within 15° of level that many points lie on: planes through 256 triples from a fixed seed, of
    which the one that most points are within 3 cm of is fitted by least squares, again and again, until the same points stay with it. The
    scan is turned about the middle of these points. A point is stray if fewer than three others are in its cube and the 26 around it,
    whose side is twice the distance of neighbouring points and at least 10 cm; near the floor, where sparse points are no obstacle, 25 cm.

    Examples
    --------
    >>> from fairaudit.plugins.navigation.readers import Part
    >>> x, y = (axis.ravel() for axis in np.meshgrid(np.arange(0, 4, 0.05), np.arange(0, 4, 0.05)))
    >>> xyz = np.stack([x, y, 0.05 * x], axis=1)
    >>> scan = prepare(Points(xyz, np.zeros((len(xyz), 3), np.uint8), (Part(0, len(xyz)),), {}))
    >>> bool(np.ptp(scan.xyz[:, 2]) < 1e-9), scan.notes[0].split(";")[0]
    (True, 'the floor leaned by 2.86°')
    """
    for name, value, known in (("unit", unit, UNITS), ("up", up, UPS)):
        if value is not None and value not in known:
            raise InputError(f"{name} is {shown(value)}; {nearest(value, known)}")
    notes = list(points.notes)
    xyz = _upright(points.xyz, unit, up, notes)
    if level:
        xyz = _levelled(xyz, points.parts, notes)
    found = replace(points, xyz=xyz)
    if stray:
        kept = ~_strays(xyz, floor_height(found) + BAND[1])
        if not kept.all():
            notes.append(f"{int((~kept).sum()):,} of {len(kept):,} points have hardly any others around them and were removed")
            found = found.only(kept)
    return replace(found, notes=tuple(notes))


def _sample(xyz: _Array) -> _Array:
    if len(xyz) <= SAMPLE:
        return xyz
    return xyz[np.unique(np.random.default_rng(0).integers(0, len(xyz), SAMPLE))]


def _upright(xyz: _Array, unit: str | None, up: str | None, notes: list[str]) -> _Array:
    sample = _sample(xyz)
    extent = np.subtract(*np.quantile(sample, [0.99, 0.01], axis=0))
    if unit is None and extent.min() > TALL:
        unit = "mm"
        notes.append(f"the scan is {extent.min():,.0f} high, so its unit was taken for the millimetre; unit says otherwise")
    scale = UNITS[unit or "m"]
    extent = extent * scale
    if up is None and extent[1] < extent[2]:
        faces = (np.abs(_normals(sample * scale)) > cos(STEEPEST)).sum(axis=0)
        if faces[1] > 1.5 * faces[2] and LOWEST <= extent[1] < 0.7 * min(extent[0], extent[2]):
            low, high = np.quantile(sample[:, 1], [0.01, 0.99])
            inner = sample[(sample[:, 1] > 0.9 * low + 0.1 * high) & (sample[:, 1] < 0.1 * low + 0.9 * high), 1]
            up = "y" if len(inner) == 0 or np.median(inner) <= (low + high) / 2 + 0.02 * (high - low) else "-y"
            notes.append(f"the scan is {extent[1]:.1f} m along y and its floor faces that way, so {up} was taken for up; up says otherwise")
        elif faces[1] > 1.5 * faces[2]:
            notes.append("most surfaces face along y; z was taken for up, as it is in a corridor, and up says otherwise")
    if up in (None, "z") and scale == 1:
        return xyz
    turned = np.empty_like(xyz)
    for axis, source in enumerate(UPS[up or "z"]):
        np.multiply(xyz[:, source], scale, out=turned[:, axis])
    if up in ("-x", "-y", "-z"):
        turned[:, 2] *= -1
    return turned


def _neighbours(sample: _Array, count: int) -> tuple[_Array, NDArray[np.int64]]:
    from scipy.spatial import cKDTree

    distances, found = cKDTree(sample).query(sample, k=min(count, len(sample)))
    return np.reshape(distances, (len(sample), -1)), np.reshape(found, (len(sample), -1))


def _normals(sample: _Array) -> _Array:
    """Directions in which the surroundings of points are thinnest."""
    around = sample[_neighbours(sample, NEIGHBOURS)[1]]
    around -= around.mean(axis=1, keepdims=True)
    return np.linalg.eigh(np.einsum("nki,nkj->nij", around, around))[1][:, :, 0]


def _spacing(xyz: _Array) -> float:
    """Distance of neighbouring points, were they spread evenly over the surfaces."""
    sample = _sample(xyz)
    eighth = _neighbours(sample, 9)[0][:, -1]
    return float(np.median(eighth)) * sqrt(pi / 8) * sqrt(len(sample) / len(xyz))


def _strays(xyz: _Array, over: float) -> NDArray[np.bool_]:
    """Which points have hardly any others around them, those near the floor and those over it apart; none in a scan too small to tell."""
    stray = np.zeros(len(xyz), np.bool_)
    if len(xyz) < LEAST:
        return stray
    middle, half, spacing = np.median(_sample(xyz), axis=0), 2.0**19, _spacing(xyz)
    for chosen, side in ((xyz[:, 2] <= over, SIDES[0]), (xyz[:, 2] > over, SIDES[1])):
        codes = np.zeros(int(chosen.sum()), np.int64)
        for axis in range(3):
            cells = (xyz[chosen, axis] - middle[axis]) / max(2 * spacing, side)
            codes = (codes << 21) + np.floor(np.clip(cells, -half, half)).astype(np.int64) + 2**20
        stray[chosen] = _lonely(codes)
    return stray if not stray.all() else ~stray


def _lonely(codes: NDArray[np.int64]) -> NDArray[np.bool_]:
    """Which points of these cubes have too few others in their own and the 26 around it."""
    cubes, counts = np.unique(codes, return_counts=True)
    thin = cubes[counts < COMPANY]
    around = np.zeros(len(thin), np.int64)
    for x, y, z in product((-1, 0, 1), repeat=3):
        wanted = thin + (x << 42) + (y << 21) + z
        at = np.minimum(np.searchsorted(cubes, wanted), len(cubes) - 1)
        around = around + np.where(cubes[at] == wanted, counts[at], 0)
    alone = thin[around < COMPANY]
    at = np.minimum(np.searchsorted(alone, codes), len(alone) - 1)
    return np.asarray(alone[at] == codes) if len(alone) else np.zeros(len(codes), np.bool_)


_Plane = tuple[_Array, _Array, int]  # its middle, its normal, and how many points are near it


def _levelled(xyz: _Array, parts: tuple[Part, ...], notes: list[str]) -> _Array:
    floors = [xyz[part.start : part.stop] for part in parts if part.kind == "floor"]
    flat = _sample(np.concatenate(floors) if floors else xyz)
    if not floors:
        flat = flat[np.abs(_normals(flat)[:, 2]) > cos(1.3 * STEEPEST)]
    plane = _floor(flat)
    if plane is None:
        notes.append("no floor was found, so the scan was not levelled")
        return xyz
    middle, (x, y, z), held = plane
    lean = float(np.arctan2(np.hypot(x, y), z))
    if lean * float(np.ptp(flat[:, :2], axis=0).max()) < NOTICED:
        return xyz
    turn = np.eye(3) - np.array([[x * x / (1 + z), x * y / (1 + z), x], [x * y / (1 + z), y * y / (1 + z), y], [-x, -y, 1 - z]])
    said = f"the floor leaned by {degrees(lean):.2f}°; the scan was levelled about ({', '.join(f'{value:.2f}' for value in middle)}), by"
    notes.append(f"{said} {held:,} of {len(flat):,} points that were looked at")
    level = np.empty_like(xyz)
    for first in range(0, len(xyz), SAMPLE):
        level[first : first + SAMPLE] = (xyz[first : first + SAMPLE] - middle) @ turn.T + middle
    return level


def _floor(flat: _Array) -> _Plane | None:
    """Lowest of the planes that many points lie on."""
    if len(flat) < LEAST:
        return None
    a, b, c = (flat[corner] for corner in np.random.default_rng(0).integers(0, len(flat), (3, TRIPLES)))
    normals = np.cross(b - a, c - a)
    sizes = np.linalg.norm(normals, axis=1)
    level = (np.abs(normals[:, 2]) >= cos(STEEPEST) * sizes) & (sizes > 0)
    found, rest = list[_Plane](), flat
    while len(found) < PLANES and len(rest) >= LEAST:
        held = [int(level[n] and (np.abs((rest - a[n]) @ normals[n]) < NEAR * sizes[n]).sum()) for n in range(TRIPLES)]
        best = int(np.argmax(held))
        plane = _fitted(rest, a[best], normals[best] / sizes[best]) if held[best] >= LEAST / 2 else None
        if plane is None:
            break
        found.append(plane)
        rest = rest[np.abs((rest - plane[0]) @ plane[1]) >= 2 * NEAR]
    middle = np.median(flat[:, :2], axis=0)
    many = [each for each in found if each[2] >= max(found[0][2] / 4, 0.1 * len(flat)) and each[1][2] >= cos(STEEPEST)]
    return min(many, key=lambda each: each[0] @ each[1] - middle @ each[1][:2], default=None)


def _fitted(flat: _Array, centre: _Array, normal: _Array) -> _Plane | None:
    """Fit a plane by least squares to the points near it, until they stay the same."""
    near = np.zeros(len(flat), np.bool_)
    for _ in range(50):
        before, near = near, np.abs((flat - centre) @ normal) < NEAR
        if near.sum() < 3:
            return None
        if (before == near).all():
            break
        centre = flat[near].mean(axis=0)
        normal = np.linalg.svd(flat[near] - centre, full_matrices=False)[2][2]
    return centre, normal if normal[2] > 0 else -normal, int(near.sum())


def advice(points: Points, resolution: float, robot_radius: float, band: tuple[float, float]) -> tuple[str, ...]:
    """Say what a map of these cells would miss, and which options would not; the band is the z of ground that can be traversed."""
    said = []
    low = points.xyz[(points.xyz[:, 2] >= band[0]) & (points.xyz[:, 2] <= band[1]), :2]
    if len(low) and (missed := _holes(low, resolution)) > HOLES:
        better = next((step for step in STEPS if step > resolution and _holes(low, step) <= HOLES), None)
        offer = f"a resolution of {better:g} m has none" if better else f"so have cells of {STEPS[-1]:g} m"
        wider = " and are widened by the robot's radius" if robot_radius else ""
        holes = f"{missed:.0%} of it are holes, which are obstacles{wider}"
        said.append(f"the points of the floor are too far apart for cells of {resolution:g} m: {holes}; {offer}")
    if 0 < robot_radius < resolution / 2:
        said.append(f"the robot's radius of {robot_radius:g} m is less than half a cell; cells of {2 * robot_radius:g} m or less show it")
    return tuple(said)


def _holes(xy: _Array, resolution: float) -> float:
    """Share of a floor's cells without a point that others surround, at the worse of two places of the grid."""
    from scipy.ndimage import binary_closing

    worst = 0.0
    for shift in (0.0, 0.5):
        cells = np.floor(xy / resolution + shift).astype(np.int64)
        cells -= cells.min(axis=0)
        rows, columns = (int(n) + 5 for n in cells.max(axis=0))
        if rows * columns > MOST_CELLS:
            return worst
        seen = np.zeros((rows, columns), np.bool_)
        seen[cells[:, 0] + 2, cells[:, 1] + 2] = True
        worst = max(worst, 1 - float(seen.sum()) / float(binary_closing(seen, np.ones((3, 3), np.bool_)).sum()))
    return worst
