"""Buildings whose rooms and doors are known, as occupancy maps: corridors, L-shaped rooms, open plans, furniture, noise, any resolution."""

from __future__ import annotations

from dataclasses import dataclass
from math import ceil, cos, radians, sin

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import binary_dilation, binary_erosion, label

from fairaudit.plugins.navigation.grids import FREE, OCCUPIED, UNKNOWN, Frame, OccupancyGrid

__all__ = ["Building", "Way", "building", "scores"]

OUTSIDE = -1
MARGIN = 0.6


@dataclass(frozen=True)
class Way:
    """A door: its rooms, its middle and width in metres."""

    rooms: tuple[int, int]
    at: tuple[float, float]
    width: float


@dataclass(frozen=True)
class Building:
    """A map and the truth about it: the room of each cell, between the walls (furniture included), or -1."""

    grid: OccupancyGrid
    rooms: NDArray[np.int64]
    doors: tuple[Way, ...]
    what: str


def building(seed: int) -> Building:
    """Draw a building: coarse cells between lines are joined into rooms, rooms by doors, and furniture never cuts a room in two."""
    random = np.random.default_rng(seed)
    xs, corridors_x = _lines(random, int(random.integers(2, 7)), 0.5)
    ys, corridors_y = _lines(random, int(random.integers(2, 6)), 0.7)
    plan = _rooms(random, len(xs) - 1, len(ys) - 1, corridors_x, corridors_y)
    resolution = float(random.choice([0.025, 0.05, 0.05, 0.1]))
    thickness = float(random.uniform(max(0.1, 1.5 * resolution), 0.3))
    doors = _doors(random, plan, xs, ys, thickness)
    angle = float(random.choice([0.0, 0.0, 0.0, random.uniform(-45, 45)]))
    clutter, noise = float(random.choice([0.0, 0.3, 0.6])), float(random.choice([0.0, 0.002, 0.006]))
    layout = _Layout(xs, ys, plan, thickness, doors)
    frame, x, y = _frame(layout, resolution, angle)
    owner, wall = layout.sample(x, y)
    free = ~wall & (owner != OUTSIDE)
    rooms = np.where(free & ~layout.in_door(x, y), owner, OUTSIDE)
    free = _furnished(random, layout, free, rooms, x, y, clutter, resolution)
    states = np.where(free, FREE, np.where((owner == OUTSIDE) & ~wall, UNKNOWN, OCCUPIED)).astype(np.int8)
    _noise(random, states, noise)
    turn, back = radians(angle), [(door, door.at) for door in doors]
    moved = tuple(Way(d.rooms, (cos(turn) * px - sin(turn) * py, sin(turn) * px + cos(turn) * py), d.width) for d, (px, py) in back)
    what = f"seed {seed}: {plan.max() + 1} rooms, {len(doors)} doors, cells {resolution}, turned {angle:.0f}°, walls {thickness:.2f}"
    return Building(OccupancyGrid(frame, states), rooms, moved, f"{what}, clutter {clutter}, noise {noise}")


def _lines(random: np.random.Generator, count: int, corridor: float) -> tuple[list[float], set[int]]:
    """Lines between coarse cells, and which strips between them are corridors, never two side by side."""
    ends, strips = [0.0], set()
    for place in range(count):
        if place - 1 not in strips and count > 2 and random.random() < corridor / 2:
            strips.add(place)
            ends.append(ends[-1] + float(random.uniform(1.7, 2.6)))
        else:
            ends.append(ends[-1] + float(random.uniform(2.6, 5.5)))
    return ends, strips


def _rooms(random: np.random.Generator, columns: int, rows: int, corridors_x: set[int], corridors_y: set[int]) -> NDArray[np.int64]:
    """Room of each coarse cell: corridors that cross are one room; of the others some are joined into L, T and open plans."""
    hall = np.zeros((rows, columns), bool)
    hall[sorted(corridors_y), :] = True
    hall[:, sorted(corridors_x)] = True
    plan = np.where(hall, 0, np.arange(1, rows * columns + 1).reshape(rows, columns)).astype(np.int64)
    halls, _ = label(hall)
    plan[hall] = halls[hall] + rows * columns
    share = float(random.choice([0.0, 0.2, 0.5]))
    for row in range(rows):
        for column in range(columns):
            for other in ((row, column + 1), (row + 1, column)):
                if other[0] < rows and other[1] < columns and not hall[row, column] and not hall[other] and random.random() < share:
                    plan[plan == plan[other]] = plan[row, column]
    return np.unique(plan, return_inverse=True)[1].reshape(rows, columns).astype(np.int64)


def _doors(random: np.random.Generator, plan: NDArray[np.int64], xs: list[float], ys: list[float], thickness: float) -> tuple[Way, ...]:
    """Doors of a spanning tree of neighbouring rooms, and some more; each at least 0.1 m from the corners of its piece of wall."""
    rows, columns = plan.shape
    walls = [
        (int(plan[r, c]), int(plan[r, c + 1]), (xs[c + 1], ys[r]), (xs[c + 1], ys[r + 1]))
        for r in range(rows)
        for c in range(columns - 1)
        if plan[r, c] != plan[r, c + 1]
    ]
    walls += [
        (int(plan[r, c]), int(plan[r + 1, c]), (xs[c], ys[r + 1]), (xs[c + 1], ys[r + 1]))
        for r in range(rows - 1)
        for c in range(columns)
        if plan[r, c] != plan[r + 1, c]
    ]
    group = list(range(int(plan.max()) + 1))
    doors: list[Way] = []
    for place in random.permutation(len(walls)):
        first, second, low, high = walls[place]
        joined = group[first] == group[second]
        if joined and random.random() > 0.15:
            continue
        width = float(random.uniform(0.8, 1.2))
        length = high[0] - low[0] + high[1] - low[1]
        edge = thickness / 2 + 0.1 + width / 2
        if length < 2 * edge:
            continue
        share = float(random.uniform(edge, length - edge)) / length
        at = (low[0] + share * (high[0] - low[0]), low[1] + share * (high[1] - low[1]))
        doors.append(Way((min(first, second), max(first, second)), at, width))
        group = [group[first] if g == group[second] else g for g in group]
    return tuple(doors)


@dataclass(frozen=True)
class _Layout:
    xs: list[float]
    ys: list[float]
    plan: NDArray[np.int64]
    thickness: float
    doors: tuple[Way, ...]

    def sample(self, x: NDArray[np.float64], y: NDArray[np.float64]) -> tuple[NDArray[np.int64], NDArray[np.bool_]]:
        """Room and wall at points: a wall is where points half a wall away belong to different rooms, and no door is."""
        half = self.thickness / 2
        owner = self._owner(x, y)
        wall = np.zeros(x.shape, bool)
        for dx, dy in ((half, 0), (-half, 0), (0, half), (0, -half), (half, half), (half, -half), (-half, half), (-half, -half)):
            wall |= self._owner(x + dx, y + dy) != owner
        return owner, wall & ~self.in_door(x, y)

    def _owner(self, x: NDArray[np.float64], y: NDArray[np.float64]) -> NDArray[np.int64]:
        column, row = np.searchsorted(self.xs, x) - 1, np.searchsorted(self.ys, y) - 1
        inside = (column >= 0) & (row >= 0) & (column < len(self.xs) - 1) & (row < len(self.ys) - 1)
        return np.where(inside, self.plan[np.clip(row, 0, len(self.ys) - 2), np.clip(column, 0, len(self.xs) - 2)], OUTSIDE)

    def in_door(self, x: NDArray[np.float64], y: NDArray[np.float64]) -> NDArray[np.bool_]:
        found = np.zeros(x.shape, bool)
        for door in self.doors:
            upright = door.at[0] in self.xs
            along, across = (y - door.at[1], x - door.at[0]) if upright else (x - door.at[0], y - door.at[1])
            found |= (np.abs(along) < door.width / 2) & (np.abs(across) <= self.thickness / 2 + 1e-9)
        return found


def _frame(layout: _Layout, resolution: float, angle: float) -> tuple[Frame, NDArray[np.float64], NDArray[np.float64]]:
    """Frame around the building turned about the origin, and the places of its cells' centres in the building that is not."""
    turn = radians(angle)
    corners = [(cos(turn) * x - sin(turn) * y, sin(turn) * x + cos(turn) * y) for x in (0, layout.xs[-1]) for y in (0, layout.ys[-1])]
    low = [min(c[k] for c in corners) - MARGIN for k in (0, 1)]
    size = [ceil((max(c[k] for c in corners) + MARGIN - low[k]) / resolution) for k in (0, 1)]
    frame = Frame(low[0], low[1], resolution, size[1], size[0])
    columns, rows = np.meshgrid(np.arange(size[0]), np.arange(size[1]))
    x, y = low[0] + (columns + 0.5) * resolution, low[1] + (size[1] - rows - 0.5) * resolution
    return frame, cos(turn) * x + sin(turn) * y, -sin(turn) * x + cos(turn) * y


def _furnished(
    random: np.random.Generator,
    layout: _Layout,
    free: NDArray[np.bool_],
    rooms: NDArray[np.int64],
    x: NDArray[np.float64],
    y: NDArray[np.float64],
    clutter: float,
    resolution: float,
) -> NDArray[np.bool_]:
    """Put cupboards, desks, beds and shelves at walls, tables and chairs anywhere; never before a door, nor so that a room falls apart."""
    sizes = [(1.0, 0.4), (0.8, 0.6), (1.4, 0.7), (1.6, 0.8), (2.0, 1.4), (2.0, 0.9), (0.4, 0.4), (1.2, 0.8), (2.4, 1.0), (0.5, 0.5)]
    before = np.zeros(free.shape, bool)
    for door in layout.doors:
        before |= (np.abs(x - door.at[0]) < door.width / 2 + 0.5) & (np.abs(y - door.at[1]) < door.width / 2 + 0.5)
    disc = _disc(0.28 / resolution)
    for row in range(layout.plan.shape[0]):
        for column in range(layout.plan.shape[1]):
            half = layout.thickness / 2
            x0, x1 = layout.xs[column] + half, layout.xs[column + 1] - half
            y0, y1 = layout.ys[row] + half, layout.ys[row + 1] - half
            room = rooms == layout.plan[row, column]
            for _ in range(round(clutter * (x1 - x0) * (y1 - y0) / 3.0)):
                length, depth = sizes[int(random.integers(len(sizes)))]
                if random.random() < 0.5:
                    length, depth = depth, length
                if length > x1 - x0 - 0.7 or depth > y1 - y0 - 0.7:
                    continue
                left, low = float(random.uniform(x0, x1 - length)), float(random.uniform(y0, y1 - depth))
                side = int(random.integers(6))
                left, low = [(x0, low), (x1 - length, low), (left, y0), (left, y1 - depth), (left, low), (left, low)][side]
                thing = (x >= left) & (x < left + length) & (y >= low) & (y < low + depth)
                kept = free & ~thing
                if not (thing & before).any() and _in_one_piece(kept & (room | before), disc, kept & room):
                    free = kept
    return free


def _in_one_piece(floor: NDArray[np.bool_], disc: NDArray[np.bool_], room: NDArray[np.bool_]) -> bool:
    """Whether somebody 0.56 m wide gets everywhere in a room: what is not within reach is less than a fiftieth."""
    rows, columns = (slice(int(where.min()), int(where.max()) + 1) for where in np.nonzero(room))
    room = np.pad(room[rows, columns], 1)
    parts, found = label(binary_erosion(room, disc))
    if found == 0:
        return False
    largest = 1 + int(np.bincount(parts.ravel())[1:].argmax())
    reached = binary_dilation(parts == largest, disc, iterations=2) & room
    return bool(found == 1 or (room & ~reached).sum() < 0.02 * room.sum())


def _disc(radius: float) -> NDArray[np.bool_]:
    reach = int(radius) + 1
    far = np.hypot(*np.meshgrid(np.arange(-reach, reach + 1), np.arange(-reach, reach + 1)))
    return np.asarray(far <= radius)


def _noise(random: np.random.Generator, states: NDArray[np.int8], share: float) -> None:
    """Specks, cells never seen, ragged walls, and holes of a cell in them."""
    free, wall = states == FREE, states == OCCUPIED
    edge = binary_dilation(wall) & free
    states[free & (random.random(states.shape) < share)] = OCCUPIED
    states[free & (random.random(states.shape) < share)] = UNKNOWN
    states[edge & (random.random(states.shape) < 25 * share)] = OCCUPIED
    states[wall & (random.random(states.shape) < 5 * share)] = FREE


def scores(true: Building, owner: NDArray[np.int64], doors: list[tuple[float, float]]) -> dict[str, int]:
    """Rooms that are met by overlap of more than 0.8 of the free cells and of the whole floor, and doors within 0.5 m, each met once."""
    free = true.grid.free
    count, found = int(true.rooms.max()) + 1, int(owner.max()) + 1
    met = floor = 0
    for room in range(count):
        truth = true.rooms == room
        numbers = np.unique(owner[truth & (owner >= 0)])
        here = [owner == number for number in numbers]
        met += any((truth & free & mine).sum() > 0.8 * (free & (truth | mine)).sum() for mine in here)
        floor += any((truth & mine).sum() > 0.8 * (truth | mine).sum() for mine in here)
    left = list(doors)
    close = 0
    for door in true.doors:
        near = min(left, key=lambda at: np.hypot(at[0] - door.at[0], at[1] - door.at[1]), default=None)
        if near is not None and np.hypot(near[0] - door.at[0], near[1] - door.at[1]) <= 0.5:
            left.remove(near)
            close += 1
    return {"rooms": count, "met": met, "floor": floor, "found": found, "doors": len(true.doors), "close": close, "listed": len(doors)}
