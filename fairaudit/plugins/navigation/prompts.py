"""Visual prompts: the map with one route in red and its index in the upper left corner."""

from __future__ import annotations

import hashlib
import io
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fairaudit.errors import InputError
from fairaudit.libraries import library
from fairaudit.plugins.navigation.routes import Route

__all__ = ["Picture", "draw"]

RED = (255, 0, 0)
TARGET_SIDE = 768
LARGEST_SIDE = 16_384


@dataclass(frozen=True)
class Picture:
    """A picture as a PNG file.

    Attributes
    ----------
    png : bytes
        The file; equal input gives equal bytes, with the same version of the libraries.
    width, height : int
        Size in pixels.
    pixels_sha256 : str
        SHA-256 of the RGB values in reading order, which no version of a compressor changes.
    """

    png: bytes = field(repr=False)
    width: int
    height: int
    pixels_sha256: str

    @property
    def sha256(self) -> str:
        """SHA-256 of the file."""
        return hashlib.sha256(self.png).hexdigest()


def draw(
    rgb: NDArray[np.uint8], route: Route | None = None, index: str = "", *, scale: int | None = None, line: float | None = None
) -> Picture:
    """Draw a map with a route.

    Parameters
    ----------
    rgb : array of uint8, shape (rows, columns, 3)
        The map.
    route : Route, optional
        Drawn in red along the centres of its cells.
    index : str
        Written in the upper left corner.
    scale : int, optional
        Pixels per cell; by default as many as make the longer side about 768 pixels.
    line : float, optional
        Width of the route in pixels; 1/120 of the longer side by default.

    Returns
    -------
    Picture
        The picture.

    Raises
    ------
    InputError
        If pillow is missing, or the picture would be larger than 16,384 pixels.
    """
    image_module, drawing = library("PIL.Image", "navigation"), library("PIL.ImageDraw", "navigation")
    rows, columns = rgb.shape[:2]
    factor = max(1, round(TARGET_SIDE / max(rows, columns))) if scale is None else scale
    if factor < 1 or factor * max(rows, columns) > LARGEST_SIDE:
        raise InputError(
            f"a picture of {factor} × {max(rows, columns)} pixels is larger than {LARGEST_SIDE}; use a smaller scale or bounds"
        )
    picture = image_module.fromarray(np.ascontiguousarray(rgb)).resize((columns * factor, rows * factor), image_module.Resampling.NEAREST)
    longer = max(picture.size)
    if route is not None and route.found:
        width = max(1, round(longer / 120 if line is None else line))
        path = [((column + 0.5) * factor, (row + 0.5) * factor) for row, column in route.cells.tolist()]
        pen = drawing.Draw(picture)
        pen.line(path, fill=RED, width=width, joint="curve")
        for x, y in (path[0], path[-1]):
            pen.ellipse([x - width, y - width, x + width, y + width], fill=RED)
    if index:
        _label(picture, index, max(1, round(longer / 250)))
    buffer = io.BytesIO()
    picture.save(buffer, "PNG")
    return Picture(buffer.getvalue(), picture.width, picture.height, hashlib.sha256(picture.tobytes()).hexdigest())


def _label(picture: Any, text: str, scale: int) -> None:
    """Write a text in black on white into the upper left corner, in pillow's built-in bitmap font, which is the same everywhere."""
    image_module, drawing, fonts = (
        library("PIL.Image", "navigation"),
        library("PIL.ImageDraw", "navigation"),
        library("PIL.ImageFont", "navigation"),
    )
    font = fonts.load_default_imagefont()
    if not text.isascii() or not text.isprintable():
        raise InputError(f"the index {text!r} cannot be drawn; letters, digits and signs of ASCII are accepted")
    left, top, right, bottom = font.getbbox(text)
    label = image_module.new("RGB", (right - left + 4, bottom - top + 4), (255, 255, 255))
    drawing.Draw(label).text((2 - left, 2 - top), text, fill=(0, 0, 0), font=font)
    picture.paste(label.resize((label.width * scale, label.height * scale), image_module.Resampling.NEAREST), (0, 0))
