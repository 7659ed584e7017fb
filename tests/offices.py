"""Synthetic offices in the layout of S3DIS: rooms, doors and furniture whose truth is known."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from fairaudit.errors import InputError

WALL = 0.2
LEAST_SIDE = 2.4
KINDS = ("office", "conferenceRoom", "hallway", "lounge", "storage", "pantry", "copyRoom", "WC")
HEIGHT = 2.7
DOOR_WIDTH, DOOR_HEIGHT, LEAF = 0.9, 2.0, 0.05
COLOURS = {
    "ceiling": (225, 225, 220), "floor": (176, 150, 120), "wall": (205, 205, 210), "door": (120, 75, 45), "window": (150, 190, 220),
    "table": (190, 140, 80), "chair": (45, 60, 110), "sofa": (140, 50, 60), "bookcase": (105, 70, 40), "board": (245, 245, 245),
    "clutter": (90, 140, 80),
}  # fmt: skip
THINGS = {  # sides and height in metres
    "table": (1.2, 0.7, 0.74), "chair": (0.5, 0.5, 0.9), "bookcase": (1.0, 0.35, 1.9), "sofa": (1.4, 0.8, 0.8), "clutter": (0.4, 0.4, 0.6),
}  # fmt: skip
CLOSED = ("bookcase", "sofa", "clutter")  # no scanner sees the floor under these

_Box = tuple[float, float, float, float]


@dataclass(frozen=True)
class Room:
    """A room: its name and its floor between the walls, as least x and y, greatest x and y."""

    name: str
    box: _Box


@dataclass(frozen=True)
class Door:
    """A door in the wall between two rooms, or in an outer wall.

    Attributes
    ----------
    rooms : tuple of str
        The rooms on its sides; the second is empty for an outer door. The first one's annotations hold it.
    at : tuple of float
        Its middle.
    along : str
        The axis, x or y, along which its wall runs.
    twice : bool
        Whether the second room's annotations hold it too.
    standing_open : bool
        Whether its leaf stands open, into the first room.
    """

    rooms: tuple[str, str]
    at: tuple[float, float]
    along: str
    twice: bool = False
    standing_open: bool = False


@dataclass(frozen=True)
class Thing:
    """A piece of furniture on the floor of a room."""

    kind: str
    room: str
    box: _Box
    height: float


@dataclass(frozen=True)
class Plan:
    """A floor plan: the truth that a scan of it should give back."""

    rooms: tuple[Room, ...]
    doors: tuple[Door, ...]
    things: tuple[Thing, ...] = field(default=())

    @property
    def edges(self) -> set[frozenset[str]]:
        """Pairs of rooms that a door joins."""
        return {frozenset(door.rooms) for door in self.doors if door.rooms[1]}

    def room(self, name: str) -> Room:
        """Return a room by its name."""
        return next(room for room in self.rooms if room.name == name)


def hr_office() -> Plan:
    """Return an office with two rooms, office_1 and office_2, that mirror each other at the ends of a hallway.

    Examples
    --------
    >>> sorted(sorted(edge) for edge in hr_office().edges)[0]
    ['conferenceRoom_1', 'hallway_1']
    """
    rooms = (
        Room("office_1", (0.1, 2.3, 3.9, 5.9)),
        Room("copyRoom_1", (4.1, 2.3, 7.9, 5.9)),
        Room("office_2", (8.1, 2.3, 11.9, 5.9)),
        Room("hallway_1", (0.1, 0.1, 11.9, 2.1)),
        Room("conferenceRoom_1", (0.1, -4.1, 5.9, -0.1)),
        Room("lounge_1", (6.1, -4.1, 11.9, -0.1)),
    )
    doors = (
        Door(("office_1", "hallway_1"), (3.0, 2.2), "x"),
        Door(("office_2", "hallway_1"), (9.0, 2.2), "x"),
        Door(("copyRoom_1", "hallway_1"), (6.0, 2.2), "x", twice=True),
        Door(("conferenceRoom_1", "hallway_1"), (4.5, 0.0), "x"),
        Door(("lounge_1", "hallway_1"), (7.5, 0.0), "x"),
        Door(("hallway_1", ""), (12.0, 1.1), "y"),
    )
    half = (
        ("office_1", "table", 0.3, 4.4), ("office_1", "chair", 1.6, 4.5), ("office_1", "bookcase", 2.4, 5.5),
        ("office_1", "clutter", 0.2, 5.4), ("copyRoom_1", "table", 4.2, 5.1),
    )  # fmt: skip
    things = [_thing(room, kind, x, y) for room, kind, x, y in half]
    mirrored = [
        replace(t, room=t.room.replace("office_1", "office_2"), box=(12 - t.box[2], t.box[1], 12 - t.box[0], t.box[3])) for t in things
    ]
    others = [
        _thing("conferenceRoom_1", "table", x, y) for x, y in ((1.6, -2.6), (1.6, -1.9), (2.8, -2.6), (2.8, -1.9))
    ] + [_thing("lounge_1", "sofa", 6.3, -3.9), _thing("lounge_1", "sofa", 9.4, -3.9), _thing("lounge_1", "table", 8.0, -2.6)]  # fmt: skip
    chairs = [_thing("conferenceRoom_1", "chair", x, y) for x in (1.8, 3.0) for y in (-3.3, -1.0)]
    return Plan(rooms, doors, (*things, *mirrored, *others, *chairs))


def _thing(room: str, kind: str, x: float, y: float) -> Thing:
    width, depth, height = THINGS[kind]
    return Thing(kind, room, (x, y, round(x + width, 3), round(y + depth, 3)), height)


def random_office(seed: int) -> Plan:
    """Draw a floor plan: 4 to 12 rooms, doors between most neighbours, some outer doors, furniture that leaves every room in one piece.

    Equal seeds give equal plans. Rooms may be cut off: not every plan is connected.
    """
    random = np.random.default_rng(seed)
    width, depth = (round(float(side), 1) for side in random.uniform((8.0, 6.0), (15.0, 11.0)))
    outlines = _split((0.0, 0.0, width, depth), random)
    counts: dict[str, int] = {}
    rooms = []
    for x0, y0, x1, y1 in outlines:
        kind = str(random.choice(KINDS))
        counts[kind] = counts.get(kind, 0) + 1
        half = WALL / 2
        rooms.append(Room(f"{kind}_{counts[kind]}", _rounded(x0 + half, y0 + half, x1 - half, y1 - half)))
    doors = _doors(rooms, random)
    things = [thing for room in rooms for thing in _furniture(room, doors, random)]
    return Plan(tuple(rooms), tuple(doors), tuple(things))


def _rounded(*values: float) -> _Box:
    x0, y0, x1, y1 = (round(v, 3) for v in values)
    return x0, y0, x1, y1


def _split(box: _Box, random: np.random.Generator) -> list[_Box]:
    """Divide a rectangle by walls until the parts are about as large as rooms."""
    x0, y0, x1, y1 = box
    sides = (x1 - x0, y1 - y0)
    axis = int(sides[1] > sides[0]) if random.random() < 0.8 else int(random.integers(2))
    least = LEAST_SIDE + WALL
    if sides[axis] < 2 * least or (sides[0] * sides[1] < 25 and random.random() < 0.6):
        return [box]
    cut = round(float(random.uniform(least, sides[axis] - least)), 1)
    parts = [(x0, y0, x0 + cut, y1), (x0 + cut, y0, x1, y1)] if axis == 0 else [(x0, y0, x1, y0 + cut), (x0, y0 + cut, x1, y1)]
    return [part for half in parts for part in _split(_rounded(*half), random)]


def _doors(rooms: list[Room], random: np.random.Generator) -> list[Door]:
    doors = []
    for i, room in enumerate(rooms):
        for other in rooms[i + 1 :]:
            span = _shared(room.box, other.box)
            if span is None or random.random() < 0.3:
                continue
            along, at, low, high = span
            pair = (room.name, other.name) if random.random() < 0.5 else (other.name, room.name)
            place = round(float(random.uniform(low + 0.65, high - 0.65)), 2)
            where = (place, at) if along == "x" else (at, place)
            room_to_swing = min(place - low, high - place) > 1.3
            doors.append(Door(pair, where, along, bool(random.random() < 0.2), bool(room_to_swing and random.random() < 0.25)))
    return doors + _outer_doors(rooms, random)


def _shared(one: _Box, other: _Box) -> tuple[str, float, float, float] | None:
    """Wall between two rooms that is long enough for a door: its axis, its middle line and its ends."""
    for axis, along in ((0, "y"), (1, "x")):
        across = 1 - axis
        low, high = max(one[across], other[across]), min(one[across + 2], other[across + 2])
        for near, far in ((one, other), (other, one)):
            if abs(far[axis] - near[axis + 2] - WALL) < 0.01 and high - low >= DOOR_WIDTH + 0.5:
                return along, round(near[axis + 2] + WALL / 2, 3), low, high
    return None


def _outer_doors(rooms: list[Room], random: np.random.Generator) -> list[Door]:
    left = min(room.box[0] for room in rooms)
    found = [
        Door((room.name, ""), (round(left - WALL / 2, 3), round(float(random.uniform(room.box[1] + 0.6, room.box[3] - 0.6)), 2)), "y")
        for room in rooms
        if room.box[0] == left and random.random() < 0.5
    ]
    return found[:2]


def _furniture(room: Room, doors: list[Door], random: np.random.Generator) -> list[Thing]:
    """Place things so far from each other, from doors and, unless they touch them, from walls that a robot passes everywhere."""
    gap = 0.8
    placed: list[Thing] = []
    ways = [door.at for door in doors if room.name in door.rooms]
    x0, y0, x1, y1 = room.box
    for _ in range(int(random.integers(2, 9))):
        kind = str(random.choice(list(THINGS)))
        long, short, height = THINGS[kind]
        width, depth = (long, short) if random.random() < 0.5 else (short, long)
        if x1 - x0 < width + 2 * gap or y1 - y0 < depth + 2 * gap:
            continue
        x = x0 + gap + float(random.random()) * (x1 - x0 - width - 2 * gap)
        y = y0 + gap + float(random.random()) * (y1 - y0 - depth - 2 * gap)
        if random.random() < 0.7:  # against one wall
            wall = int(random.integers(4))
            x, y = (x0, y) if wall == 0 else (x1 - width, y) if wall == 1 else (x, y0) if wall == 2 else (x, y1 - depth)
        box = _rounded(x, y, x + width, y + depth)
        apart = all(_gap(box, thing.box) >= gap for thing in placed)
        if apart and all(_gap(box, (a, b, a, b)) >= DOOR_WIDTH + 0.5 for a, b in ways):
            placed.append(Thing(kind, room.name, box, height))
    return placed


def _gap(one: _Box, other: _Box) -> float:
    """Distance between two rectangles along the axis on which they are farther apart."""
    return max(max(one[i], other[i]) - min(one[i + 2], other[i + 2]) for i in (0, 1))


def write_office(plan: Plan, folder: str | Path, *, spacing: float = 0.05, seed: int = 0) -> int:
    """Write a scan of a plan in the layout of S3DIS.

    Parameters
    ----------
    plan : Plan
        The office.
    folder : path-like
        The area's folder; it must not exist or be empty.
    spacing : float
        Mean distance of neighbouring points on a surface, in metres.
    seed : int
        Equal seeds give equal files.

    Returns
    -------
    int
        Number of points.

    Raises
    ------
    InputError
        If the folder is not empty or cannot be written.
    """
    folder = Path(folder)
    random = np.random.default_rng(seed)
    total = 0
    try:
        folder.mkdir(parents=True, exist_ok=True)
        if any(folder.iterdir()):
            raise InputError(f"{folder} is not empty; name a new folder")
        for room in plan.rooms:
            annotations = folder / room.name / "Annotations"
            annotations.mkdir(parents=True)
            whole = []
            for name, surface in _surfaces(plan, room, spacing, random).items():
                text = _lines(surface, COLOURS.get(name.rsplit("_", 1)[0], COLOURS["clutter"]), random)
                (annotations / f"{name}.txt").write_text(text, "ascii")
                whole.append(text)
                total += len(surface)
            (folder / room.name / f"{room.name}.txt").write_text("".join(whole), "ascii")
    except OSError as error:
        raise InputError(f"{folder} cannot be written: {error.strerror or error}") from None
    return total


def _lines(xyz: NDArray[np.float64], colour: tuple[int, int, int], random: np.random.Generator) -> str:
    import pandas as pd

    rgb = np.clip(np.array(colour) + random.integers(-12, 13, (len(xyz), 1)), 0, 255)
    frame = pd.DataFrame({"x": xyz[:, 0], "y": xyz[:, 1], "z": xyz[:, 2], "r": rgb[:, 0], "g": rgb[:, 1], "b": rgb[:, 2]})
    return str(frame.to_csv(sep=" ", header=False, index=False, float_format="%.3f", lineterminator="\n"))


def _surfaces(plan: Plan, room: Room, spacing: float, random: np.random.Generator) -> dict[str, NDArray[np.float64]]:
    """Points of each object of a room, by the name of its annotation."""
    x0, y0, x1, y1 = room.box
    doors = [door for door in plan.doors if room.name in door.rooms]

    def sheet(low: tuple[float, float, float], high: tuple[float, float, float]) -> NDArray[np.float64]:
        """Points at about equal distances, none outside, on a flat box."""
        counts = [max(1, round((b - a) / spacing)) for a, b in zip(low, high, strict=True)]
        axes = [a + (np.arange(n) + 0.5) * ((b - a) / n) for a, b, n in zip(low, high, counts, strict=True)]
        points = np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, 3)
        shift = random.uniform(-0.1, 0.1, points.shape) * spacing
        return np.clip(points + shift, low, high)

    strips = [sheet((a, b, 0.0), (c, d, 0.0)) for a, b, c, d in (_doorway(door) for door in doors if door.rooms[0] == room.name)]
    floor = sheet((x0, y0, 0.0), (x1, y1, 0.0))
    for thing in plan.things:
        if thing.room == room.name and thing.kind in CLOSED:
            a, b, c, d = thing.box
            floor = floor[~((floor[:, 0] > a) & (floor[:, 0] < c) & (floor[:, 1] > b) & (floor[:, 1] < d))]
    found = {"ceiling_1": sheet((x0, y0, HEIGHT), (x1, y1, HEIGHT)), "floor_1": np.concatenate([floor, *strips])}
    walls = (((x0, y0), (x1, y0)), ((x0, y1), (x1, y1)), ((x0, y0), (x0, y1)), ((x1, y0), (x1, y1)))
    for number, (start, end) in enumerate(walls, start=1):
        points = sheet((*start, 0.0), (*end, HEIGHT))
        for door in doors:
            points = points[~_in_doorway(points, door)]
        found[f"wall_{number}"] = points
    held = [door for door in doors if door.rooms[0] == room.name or door.twice]
    for number, door in enumerate(held, start=1):
        a, b, c, d = _leaf(door, plan)
        found[f"door_{number}"] = sheet((a, b, 0.02), (c, d, DOOR_HEIGHT))
    numbers: dict[str, int] = {}
    for thing in (thing for thing in plan.things if thing.room == room.name):
        numbers[thing.kind] = numbers.get(thing.kind, 0) + 1
        a, b, c, d = thing.box
        sides = [((a, b), (c, b)), ((a, d), (c, d)), ((a, b), (a, d)), ((c, b), (c, d))]
        pieces = [sheet((*low, 0.1), (*high, thing.height)) for low, high in sides]
        found[f"{thing.kind}_{numbers[thing.kind]}"] = np.concatenate([sheet((a, b, thing.height), (c, d, thing.height)), *pieces])
    return found


def _doorway(door: Door) -> _Box:
    """Floor of an opening, from wall face to wall face."""
    (x, y), half = door.at, DOOR_WIDTH / 2
    return (x - half, y - WALL / 2, x + half, y + WALL / 2) if door.along == "x" else (x - WALL / 2, y - half, x + WALL / 2, y + half)


def _in_doorway(points: NDArray[np.float64], door: Door) -> NDArray[np.bool_]:
    (x, y), half, deep = door.at, DOOR_WIDTH / 2, WALL / 2 + 0.02
    wide, thick = (half, deep) if door.along == "x" else (deep, half)
    return (np.abs(points[:, 0] - x) <= wide) & (np.abs(points[:, 1] - y) <= thick) & (points[:, 2] <= DOOR_HEIGHT)


def _leaf(door: Door, plan: Plan) -> _Box:
    """Footprint of the leaf: in the wall if it is shut, at a right angle to it in the first room if it stands open."""
    (x, y), half, thick = door.at, DOOR_WIDTH / 2, LEAF / 2
    if not door.standing_open:
        return (x - half, y - thick, x + half, y + thick) if door.along == "x" else (x - thick, y - half, x + thick, y + half)
    box = plan.room(door.rooms[0]).box
    if door.along == "x":
        face = box[1] if box[1] > y else box[3]
        low, high = sorted((face, face + (DOOR_WIDTH if face == box[1] else -DOOR_WIDTH)))
        return (x - half - thick, low, x - half + thick, high)
    face = box[0] if box[0] > x else box[2]
    low, high = sorted((face, face + (DOOR_WIDTH if face == box[0] else -DOOR_WIDTH)))
    return (low, y - half - thick, high, y - half + thick)
