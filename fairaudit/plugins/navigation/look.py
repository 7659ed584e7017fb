"""How maps that a model is shown look: colours, line styles, sizes and letters, for every picture of the plug-in."""

from __future__ import annotations

import textwrap
import unicodedata
from functools import lru_cache
from itertools import groupby
from pathlib import Path
from typing import Any

import numpy as np

from fairaudit.errors import InputError, shown
from fairaudit.libraries import library

__all__ = ["FAINT", "INK", "PAPER", "RED", "colour", "line_width", "set_text", "text_size"]

RED, INK, PAPER, FAINT = (255, 0, 0), (20, 20, 20), (255, 255, 255), (170, 170, 170)
COLOURS = (  # after Okabe and Ito, for readers who see fewer colours
    (0, 114, 178), (213, 94, 0), (0, 158, 115), (204, 121, 167), (230, 159, 0), (86, 180, 233), (240, 228, 66),
)  # fmt: skip
TEXT, LINE = 1 / 42, 1 / 120  # height of letters and width of a route, as shares of the map's longer side
LEAST_TEXT, LEAST_LINE = 14, 3
MOST_LINES, LEADING = 3, 1.3
SHAPED = {"R", "AL", "NSM"}  # bidirectional classes of letters that are joined, reordered or stacked


def text_size(side: int) -> int:
    """Height of letters in pixels, on a map whose longer side has so many."""
    return max(LEAST_TEXT, round(side * TEXT))


def line_width(side: int) -> int:
    """Width of a route in pixels; its dark casing and its light halo add a third each on both sides."""
    return max(LEAST_LINE, round(side * LINE))


def colour(number: int, piece: int) -> tuple[int, int, int]:
    """Colour of a piece of the route of a candidate (from 0): the eighth to fourteenth are dashed, every second piece of them being light.

    Of the next seven every third piece is light, and so on.
    """
    style = number // len(COLOURS)
    return PAPER if style and piece % (style + 1) == style else COLOURS[number % len(COLOURS)]


def set_text(text: str, size: int, limit: int) -> tuple[list[tuple[tuple[int, int], str, Any]], tuple[int, int]]:
    """Break a text into at most three lines of so many pixels, and choose letters: DejaVu Sans, or fonts of the system for what it lacks.

    Returns
    -------
    tuple
        Pieces, each with where its baseline starts, its letters and their font; and the width and height of a box around them.
        What does not fit is "…".

    Raises
    ------
    InputError
        If matplotlib or pillow is missing, no font has a letter, or letters are joined or stacked and pillow cannot do that.
    """
    text = unicodedata.normalize("NFC", text)
    for columns in range(min(len(text), max(1, 2 * limit // size)), 0, -1):
        pieces, boxes = [], []
        for number, line in enumerate(textwrap.wrap(text, columns, max_lines=MOST_LINES, placeholder="…")):
            x, y = 0, round(number * LEADING * size)
            for letters, face in _runs(line, size):
                pieces.append(((x, y), letters, face))
                boxes.append(np.add(face.getbbox(letters, anchor="ls"), (x, y, x, y)))
                x += round(face.getlength(letters))
        left, top = (int(v) for v in np.min(boxes, axis=0)[:2])
        right, bottom = (int(v) for v in np.max(boxes, axis=0)[2:])
        if right - left <= limit:
            break
    pad = size // 2
    placed = [((x - left + pad, y - top + pad), letters, face) for (x, y), letters, face in pieces]
    return placed, (right - left + 2 * pad, bottom - top + 2 * pad)


def _runs(line: str, size: int) -> list[tuple[str, Any]]:
    """Letters that go together, each with its font; where letters are shaped, one font has all of them."""
    fonts = library("PIL.ImageFont", "navigation")
    shaped = not SHAPED.isdisjoint(map(unicodedata.bidirectional, line))
    if shaped and not library("PIL.features", "navigation").check("raqm"):
        raise InputError(f"the letters of {shown(line)} are joined or stacked, which needs pillow with libraqm; others are accepted")
    engine = fonts.Layout.RAQM if shaped else fonts.Layout.BASIC
    found = [("".join(run), path) for path, run in groupby(line, _face)] if not shaped else [(line, _face(line))]
    return [(letters, fonts.truetype(path, size, layout_engine=engine)) for letters, path in found]


@lru_cache(maxsize=4096)
def _face(letters: str) -> str:
    """File of the first font that has all letters: DejaVu Sans as matplotlib brings it, else one of the system, by name."""
    needed = {ord(letter) for letter in letters if not letter.isspace()}
    first = str(Path(library("matplotlib", "navigation").get_data_path(), "fonts", "ttf", "DejaVuSans.ttf"))
    if needed <= _codes(first):
        return first
    for path in _fonts():
        if needed <= _codes(path):
            return path
    raise InputError(f"no font on this machine has the letters {shown(letters)}; install one, such as Noto Sans, or write other letters")


@lru_cache(maxsize=1)
def _fonts() -> list[str]:
    """Files of the fonts of the system, by name."""
    paths = map(Path, library("matplotlib.font_manager", "navigation").findSystemFonts())
    return [str(path) for path in sorted(paths, key=lambda path: (path.name, path))]


@lru_cache(maxsize=1024)
def _codes(path: str) -> frozenset[int]:
    """Letters that a font has; none if the file cannot be read."""
    try:
        return frozenset(library("matplotlib.ft2font", "navigation").FT2Font(path).get_charmap())
    except (OSError, RuntimeError):
        return frozenset()
