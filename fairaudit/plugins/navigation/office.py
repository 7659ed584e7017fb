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

__all__ = ["write_office"]

SIDE, LEFT, TOP, HEIGHT = 0.1, -0.1, 6.1, 2.7
KINDS = {  # sign, height in metres, colour
    "wall": ("#", HEIGHT, (205, 205, 210)), "door": ("D", 2.0, (120, 75, 45)), "table": ("T", 0.74, (190, 140, 80)),
    "chair": ("C", 0.9, (45, 60, 110)), "sofa": ("S", 0.8, (140, 50, 60)), "bookcase": ("B", 1.9, (105, 70, 40)),
    "clutter": ("U", 0.6, (90, 140, 80)),
}  # fmt: skip
FLOOR, CEILING = (176, 150, 120), (225, 225, 220)


def write_office(folder: str | Path) -> int:
    """Write a scan of an office with two rooms, office_1 and office_2, that mirror each other at the ends of a hallway.

    Parameters
    ----------
    folder : path-like
        The area's folder; it must not exist or be empty. Points are the same each time.

    Returns
    -------
    int
        Number of points.

    Raises
    ------
    InputError
        If the folder is not empty or cannot be written.

    Examples
    --------
    >>> import tempfile
    >>> write_office(tempfile.mkdtemp())
    254996
    """
    import pandas as pd

    folder, total = Path(folder), 0
    try:
        folder.mkdir(parents=True, exist_ok=True)
        if any(folder.iterdir()):
            raise InputError(f"{folder} is not empty; name a new folder")
        for room, objects in _rooms():
            annotations = folder / room / "Annotations"
            annotations.mkdir(parents=True)
            for name, points in objects.items():
                text = (
                    pd.DataFrame(points)
                    .astype({3: int, 4: int, 5: int})
                    .to_csv(None, sep=" ", header=False, index=False, float_format="%.3f")
                )
                (annotations / f"{name}.txt").write_text(text, "ascii")
                total += len(points)
            texts = [(annotations / f"{name}.txt").read_text("ascii") for name in objects]
            (folder / room / f"{room}.txt").write_text("".join(texts), "ascii")
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
        objects = {"ceiling_1": _points(inside, 2, [HEIGHT], CEILING, random), "floor_1": _points(inside, 3, [0.0], FLOOR, random)}
        for kind, (sign, height, colour) in KINDS.items():
            pieces, count = label(own & (signs == sign))
            levels = [*np.arange(0.2, height - 0.05, 0.2), height]
            objects |= {f"{kind}_{number}": _points(pieces == number, 2, levels, colour, random) for number in range(1, count + 1)}
        yield room, objects


def _points(chosen: NDArray[np.bool_], dense: int, levels: list[float], colour: tuple[int, ...], random: np.random.Generator) -> Any:
    """Points on each sign and level, `dense` along either side, up to 4 mm from where a lattice has them, in shades of a colour."""
    rows, columns = np.nonzero(np.repeat(np.repeat(chosen, dense, 0), dense, 1))
    x, y = LEFT + (columns + 0.5) * SIDE / dense, TOP - (rows + 0.5) * SIDE / dense
    xyz = np.concatenate([np.stack([x, y, np.full(len(x), level)], axis=1) for level in levels])
    xyz[:, :2] += random.uniform(-0.004, 0.004, (len(xyz), 2))
    return np.hstack([xyz, np.clip(colour + random.integers(-12, 13, (len(xyz), 1)), 0, 255)])
