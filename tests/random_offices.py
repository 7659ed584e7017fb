"""Floor plans drawn at random, whose rooms, doors and furniture are known."""

from __future__ import annotations

import numpy as np

from fairaudit.plugins.navigation.office import DOOR_WIDTH, THINGS, WALL, Door, Plan, Room, Thing

LEAST_SIDE = 2.4
KINDS = ("office", "conferenceRoom", "hallway", "lounge", "storage", "pantry", "copyRoom", "WC")

_Box = tuple[float, float, float, float]


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
