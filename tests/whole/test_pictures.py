"""Each picture of docs/pictures.md is what the command above it draws today. FAIRAUDIT_GOLDEN=1 draws them anew."""

from __future__ import annotations

import os
import re
import shlex
from pathlib import Path

import pytest

from fairaudit.cli import main

ROOT = Path(__file__).resolve().parents[2]
PICTURES = ROOT / "docs" / "pictures"
PAGE = (ROOT / "docs" / "pictures.md").read_text("utf-8")
SHOWN = re.findall(r"!\[[^\]]+\]\(pictures/([\w.-]+)\)", PAGE)
MADE = {"document-delivery.png": "document-delivery/figure.png", "candidate-2.png": "example/documents-candidates/candidate-2.png"}
"""Where commands put pictures that are not named on their lines."""


@pytest.fixture(scope="module")
def drawn(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder in which all commands of the page were run."""
    pytest.importorskip("matplotlib", reason="matplotlib is not installed (it is in the extra plots)")
    pytest.importorskip("networkx", reason="networkx is not installed (it is in the extra navigation)")
    folder = tmp_path_factory.mktemp("pictures")
    before, namespace = Path.cwd(), {}
    os.chdir(folder)
    try:
        for language, text in re.findall(r"^```(python|sh)\n(.*?)^```", PAGE, re.MULTILINE | re.DOTALL):
            if language == "python":
                exec(compile(text, "pictures.md", "exec"), namespace)  # noqa: S102
            else:
                codes = [main(shlex.split(each)[1:]) for each in text.replace("\\\n", " ").split("&&")]
                assert set(codes) <= {0, 3}  # 3: the verdict of an example is inconclusive
    finally:
        os.chdir(before)
    return folder


def words(picture: bytes) -> list[str]:
    """Every text of a picture of matplotlib: a comment stands before the outlines of its letters."""
    return re.findall(r"<!-- (.*?) -->", picture.decode())


@pytest.mark.parametrize("name", SHOWN)
def test_pictures_are_what_the_commands_draw(name: str, drawn: Path) -> None:
    made, shown = drawn / MADE.get(name, name), PICTURES / name
    if os.environ.get("FAIRAUDIT_GOLDEN"):
        shown.write_bytes(made.read_bytes())
    if name.endswith(".svg"):
        assert len(words(made.read_bytes())) >= 5
        assert words(shown.read_bytes()) == words(made.read_bytes())
        return
    numpy, image = pytest.importorskip("numpy"), pytest.importorskip("PIL.Image")
    ours, theirs = (numpy.asarray(image.open(path).convert("L"), dtype=float) for path in (shown, made))
    assert ours.shape == theirs.shape
    assert abs(ours - theirs).mean() < 10  # of 255: answers are drawn anew, and letters move; another picture is far off


def test_every_picture_has_one_command_and_is_shown() -> None:
    sections = PAGE.split("\n## ")[1:]
    assert all(len(re.findall(r"^```(?:python|sh)$", each, re.MULTILINE)) == 1 for each in sections)
    assert all(len(re.findall(r"^!\[", each, re.MULTILINE)) == 1 for each in sections)
    pages = "\n".join(path.read_text("utf-8") for path in [ROOT / "README.md", *(ROOT / "docs").glob("*.md")])
    assert {path.name for path in PICTURES.iterdir()} == set(re.findall(r"pictures/([\w.-]+)\)", pages))
