"""Pictures that a model is shown: what is written covers nothing that matters and can be read, in any of many scenes."""

from __future__ import annotations

import hashlib
import io
from itertools import combinations, groupby

import numpy as np
import pytest
import tiers
from numpy.typing import NDArray

from fairaudit.errors import InputError
from fairaudit.plugins.navigation.prompts import COLOURS, INK, PAPER, RED, colour, set_text
from fairaudit.plugins.navigation.routes import Route, flood

image = pytest.importorskip("PIL.Image")
pytest.importorskip("matplotlib")
from fairaudit.plugins.navigation.prompts import Picture, draw  # noqa: E402

NAMES = (
    "HR1", "Büro 3", "кабинет Юрьева", "Αίθουσα συνεδριάσεων", "غرفة الاجتماعات", "חדר ישיבות", "phòng họp số 9", "café №7 → x²",
    "Dr. Wilhelmina Featherstonehaugh-Cholmondeley, head of the department for personnel, third floor, second door on the left",
    "Rindfleischetikettierungsüberwachungsaufgabenübertragungsgesetz", "i", "a_long_room_name_without_any_blank_12345678901234567890",
)  # fmt: skip


def scene(seed: int) -> tuple[NDArray[np.uint8], list[Route], list[str], tuple[list[str], NDArray[np.int16]], float, int | None]:
    """Make a coloured map with rooms and obstacles, routes from one start, and names."""
    random = np.random.default_rng(seed)
    rows, columns = (int(v) for v in random.integers(6, 160, 2))
    free = random.random((rows, columns)) > random.choice([0.0, 0.05, 0.2])
    owner = np.full((rows, columns), -1, np.int16)
    across, down = (int(v) for v in random.integers(1, 4, 2))
    for i in range(down):
        for j in range(across):
            owner[i * rows // down : (i + 1) * rows // down, j * columns // across : (j + 1) * columns // across] = i * across + j
    rgb = random.integers(0, 256, (rows, columns, 3), dtype=np.uint8) if seed % 3 else np.full((rows, columns, 3), seed % 256, np.uint8)
    start = tuple(int(v) for v in np.argwhere(free)[int(random.integers(free.sum()))])
    found = flood(free, (start[0], start[1]))
    goals = np.argwhere(found.reached)
    chosen = goals[random.integers(len(goals), size=int(random.integers(1, 13)))]
    routes = [found.route((int(row), int(column))) for row, column in chosen]
    names = [str(name) for name in random.choice(NAMES, len(routes))]
    rooms = [f"{name} {number}" for number, name in enumerate(random.choice(NAMES, across * down))]
    return rgb, routes, names, (rooms, owner), float(random.choice([0.02, 0.05, 1.0])), (None, None, 3, 1)[seed % 4]


def pixels(picture: Picture) -> NDArray[np.int16]:
    return np.asarray(image.open(io.BytesIO(picture.png)).convert("RGB")).astype(np.int16)


def luminance(rgb: NDArray[np.int16] | tuple[int, int, int]) -> NDArray[np.float64]:
    """Relative luminance as WCAG 2 has it."""
    value = np.asarray(rgb, np.float64) / 255
    linear = np.where(value <= 0.04045, value / 12.92, ((value + 0.055) / 1.055) ** 2.4)
    return linear @ np.array([0.2126, 0.7152, 0.0722])


def contrast(first: NDArray[np.float64], second: NDArray[np.float64]) -> NDArray[np.float64]:
    return (np.maximum(first, second) + 0.05) / (np.minimum(first, second) + 0.05)


def check(picture: Picture, ends: list[tuple[int, int]], mark: float) -> None:
    """What holds of every picture, on its pixels."""
    seen = pixels(picture)
    boxes = [(*label.corner, label.corner[0] + label.size[0], label.corner[1] + label.size[1]) for label in picture.labels]
    for left, top, right, bottom in boxes:
        assert 0 <= left < right <= picture.width and 0 <= top < bottom <= picture.height
        for row, column in ends:
            x, y = picture.left + (column + 0.5) * picture.scale, picture.top + (row + 0.5) * picture.scale
            away = np.hypot(max(left - x, 0, x - right), max(top - y, 0, y - bottom))
            assert away >= mark, "a label covers a start or a goal"
        inside = seen[top + 3 : bottom - 3, left + 3 : right - 3]
        dark = luminance(inside)
        letters, under = dark < 0.02, dark > 0.9
        assert letters.any(), "no letters"
        near = np.zeros_like(letters)  # what is within two pixels of a letter, but for its smooth edge, is light enough
        for dy in range(-2, 3):
            for dx in range(-2, 3):
                near |= np.roll(letters, (dy, dx), (0, 1))
        assert contrast(dark[letters].max(), dark[under].min()) >= 4.5 and under[near].sum() > 0.1 * near.sum()
        assert np.ptp(inside.reshape(-1, 3), axis=1).max() == 0, "something else than letters is in the box"
        frame = np.concatenate([inside[0], inside[-1], inside[:, 0], inside[:, -1]])
        assert (frame == PAPER).all(), "letters reach the border of the box"
    for (a, b, c, d), (e, f, g, h) in combinations(boxes, 2):
        assert c <= e or g <= a or d <= f or h <= b, "labels overlap"


@pytest.mark.parametrize("first", range(0, 200, 20))
def test_labels_of_many_scenes(first: int) -> None:
    """Of each twenty scenes seven in the suite, and all with FAIRAUDIT_FULL=1."""
    for seed in range(first, first + 20, 1 if tiers.FULL else 3):
        rgb, routes, names, rooms, resolution, scale = scene(seed)
        cells = [route.cells for route in routes]
        start, goals = tuple(cells[0][0].tolist()), [tuple(each[-1].tolist()) for each in cells]
        together = draw(rgb, routes, names, rooms=rooms, resolution=resolution, scale=scale)
        side = max(rgb.shape[:2]) * together.scale
        mark = 2.4 * max(3, round(side / 120))
        check(together, [start, *goals], mark)
        known = {f"{number + 1} {name}" for number, name in enumerate(names)} | {"start"}
        assert known <= {label.text for label in together.labels}
        number = seed % len(routes)
        alone = draw(rgb, routes, names, chosen=number, rooms=rooms, resolution=resolution, scale=scale)
        check(alone, [start, goals[number]], mark)
        texts = [label.text for label in alone.labels]
        assert {f"{number + 1} {names[number]}", "start", str(number + 1)} <= set(texts)
        if len(set(names)) == len(names):
            places = {label.text: label.corner for label in together.labels}
            assert all(places[label.text] == label.corner for label in alone.labels if label.text != str(number + 1))
        assert (alone.width, alone.height) == (together.width, together.height)


def test_routes_have_shapes_casing_and_colours() -> None:
    """Start and goal differ in shape; a route is red, with dark and light around it, whatever it lies on."""
    free = np.ones((40, 60), bool)
    routes = [flood(free, (20, 10)).route((20, 50))]
    for shade in (0, 60, 128, 255):
        picture = draw(np.full((40, 60, 3), shade, np.uint8), routes, ["HR1"], chosen=0, resolution=0.1)
        seen = pixels(picture)
        x, y = picture.left + round(30.5 * picture.scale), picture.top + round(20.5 * picture.scale)
        column = [tuple(v) for v in seen[y - 20 : y + 1, x].tolist()]
        assert column[-1] == RED and INK in column and PAPER in column
        assert column.index(PAPER) < column.index(INK) < column.index(RED)
        start, goal = ((seen[y, picture.left + round((c + 0.5) * picture.scale)] == RED).all() for c in (10, 50))
        assert goal and not start
    for each in (RED, *COLOURS):
        assert contrast(luminance(each), luminance(INK)) >= 3


def test_scale_bar_is_as_long_as_it_says() -> None:
    routes = [flood(np.ones((30, 40), bool), (5, 5)).route((20, 30))]
    for resolution, scale in ((0.05, 8), (0.013, 20), (1.0, 3), (30.0, 12)):
        picture = draw(np.full((30, 40, 3), 200, np.uint8), routes, ["x"], chosen=0, resolution=resolution, scale=scale)
        (text,) = (label.text for label in picture.labels if label.text.endswith(" m"))
        head = (pixels(picture)[: picture.top] == INK).all(axis=2)
        longest = max(sum(1 for _ in run) for row in head for value, run in groupby(row.tolist()) if value)
        assert longest * resolution / scale == pytest.approx(float(text[:-2]), abs=3 * resolution / scale)


def test_twenty_eight_candidates_can_be_told_apart() -> None:
    """Each has a colour and a line style that no other has; colours stay apart for those who see two kinds only."""
    styles = {tuple(colour(number, piece) for piece in range(12)) for number in range(28)}
    assert len(styles) == 28
    protan = [[0.152286, 1.052583, -0.204868], [0.114503, 0.786281, 0.099216], [-0.003882, -0.048116, 1.051998]]
    deutan = [[0.367322, 0.860646, -0.227968], [0.280085, 0.672501, 0.047413], [-0.011820, 0.042940, 0.968881]]
    tritan = [[1.255528, -0.076749, -0.178779], [-0.078411, 0.930809, 0.147602], [0.004733, 0.691367, 0.303900]]
    values = np.array(COLOURS) / 255
    linear = np.where(values <= 0.04045, values / 12.92, ((values + 0.055) / 1.055) ** 2.4)
    to_xyz = np.array([[0.4124, 0.3576, 0.1805], [0.2126, 0.7152, 0.0722], [0.0193, 0.1192, 0.9505]]) / [[0.9505], [1.0], [1.089]]
    for matrix in (np.eye(3), protan, deutan, tritan):  # Machado, Oliveira and Fernandes 2009, severity 1
        f = np.cbrt(np.clip(linear @ np.array(matrix).T, 0, 1) @ to_xyz.T)
        lab = np.stack([116 * f[:, 1] - 16, 500 * (f[:, 0] - f[:, 1]), 200 * (f[:, 1] - f[:, 2])], axis=1)
        for first, second in combinations(lab, 2):
            assert np.linalg.norm(first - second) > 10


def test_shared_way_has_the_colours_of_all() -> None:
    found = flood(np.ones((30, 90), bool), (15, 2))
    routes = [found.route((15, 80)), found.route((15, 85))]
    seen = pixels(draw(np.zeros((30, 90, 3), np.uint8), routes, ["a", "b"]))
    for number in (0, 1):
        assert (seen == colour(number, 0)).all(axis=2).sum() > 500


def test_letters_of_many_scripts_and_none() -> None:
    for text, fonts in (("Büro 3", 1), ("会议室 1", 2)):
        try:
            pieces, _ = set_text(text, 20, 500)
        except InputError as error:
            assert fonts == 2 and "no font on this machine has the letters '会'" in str(error)
        else:
            assert len({face.path for _, _, face in pieces}) == fonts and "".join(letters for _, letters, _ in pieces) == text
    for text in ("\u1234\ue000", "a\x07"):
        with pytest.raises(InputError, match="no font on this machine has the letters"):
            set_text(text, 20, 500)
    assert set_text("e\u0301", 20, 500)[1] == set_text("\u00e9", 20, 500)[1]


def test_maps_alone_are_their_cells() -> None:
    rgb = np.random.default_rng(1).integers(0, 256, (30, 40, 3), dtype=np.uint8)
    picture = draw(rgb, scale=8)
    assert (pixels(picture)[4::8, 4::8] == rgb).all() and not picture.labels
    assert picture.sha256 == hashlib.sha256(picture.png).hexdigest() and draw(rgb.copy(), scale=8).png == picture.png
    assert hashlib.sha256(pixels(picture).astype(np.uint8).tobytes()).hexdigest() == picture.pixels_sha256
    with pytest.raises(InputError, match="larger than 16384"):
        draw(rgb, scale=1000)
    for rows, columns in ((10, 20), (300, 200), (700, 900)):
        plain = draw(np.zeros((rows, columns, 3), np.uint8))
        assert 700 <= max(plain.width, plain.height) <= 1000 and plain.width * rows == plain.height * columns
    assert draw(np.zeros((1, 1, 3), np.uint8)).width == 768
