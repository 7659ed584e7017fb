"""A synthetic office in the layout of S3DIS, from a floor plan that is drawn in signs: `office.toml`."""

from __future__ import annotations

import tomllib
from collections.abc import Iterator
from importlib.resources import files
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fairaudit.errors import InputError

SIDE, LEFT, TOP = 0.1, -0.1, 6.1


def write_office(folder: str | Path) -> int:
    """Write a scan of an office with two rooms, office_1 and office_2, that mirror each other at the ends of a hallway.

    The area's folder must not exist or be empty. Points are the same each time; their number is returned.

    Examples
    --------
    >>> import tempfile
    >>> write_office(tempfile.mkdtemp())
    254996
    """
    folder, total = Path(folder), 0
    try:
        folder.mkdir(parents=True, exist_ok=True)
        if any(folder.iterdir()):
            raise InputError(f"{folder} is not empty; name a new folder")
        for room, objects in _rooms():
            annotations = folder / room / "Annotations"
            annotations.mkdir(parents=True)
            for name, points in objects.items():
                np.savetxt(annotations / f"{name}.txt", points, "%.3f %.3f %.3f %d %d %d")
                total += len(points)
            whole = b"".join((annotations / f"{name}.txt").read_bytes() for name in objects)
            (folder / room / f"{room}.txt").write_bytes(whole)
    except OSError as error:
        raise InputError(f"{folder} cannot be written: {error.strerror or error}") from None
    return total


def _rooms() -> Iterator[tuple[str, dict[str, Any]]]:
    """Rooms with their objects, each by the name of its annotation; a sign that is no floor belongs to the room nearest to it."""
    from scipy.ndimage import distance_transform_edt, label

    document = tomllib.loads(files("fairaudit.plugins.navigation").joinpath("office.toml").read_text("utf-8"))
    signs = np.array([list(line) for line in document["plan"].split()])
    floors = np.isin(signs, list(document["rooms"]))
    owner = signs[tuple(distance_transform_edt(~floors, return_distances=False, return_indices=True))]
    random = np.random.default_rng(0)
    for letter, room in document["rooms"].items():
        own = owner == letter
        inside = own & (signs != "#")
        objects = {f"{kind}_1": _points(inside, dense, [z], colour, random) for kind, (dense, z, colour) in document["planes"].items()}
        for kind, (sign, height, colour) in document["kinds"].items():
            pieces, count = label(own & (signs == sign))
            levels = [*np.arange(0.2, height - 0.05, 0.2), height]
            objects |= {f"{kind}_{number}": _points(pieces == number, 2, levels, colour, random) for number in range(1, count + 1)}
        yield room, objects


def _points(chosen: NDArray[np.bool_], dense: int, levels: list[float], colour: list[int], random: np.random.Generator) -> Any:
    """Points on each sign and level, `dense` along either side, up to 4 mm from where a lattice has them, in shades of a colour."""
    rows, columns = np.nonzero(np.repeat(np.repeat(chosen, dense, 0), dense, 1))
    x, y = LEFT + (columns + 0.5) * SIDE / dense, TOP - (rows + 0.5) * SIDE / dense
    xyz = np.concatenate([np.stack([x, y, np.full(len(x), level)], axis=1) for level in levels])
    xyz[:, :2] += random.uniform(-0.004, 0.004, (len(xyz), 2))
    return np.hstack([xyz, np.clip(colour + random.integers(-12, 13, (len(xyz), 1)), 0, 255)])
