"""Tokens of pictures by the examples that providers publish, sizes of pictures as another library reads them, and the dry run."""

from __future__ import annotations

import io
import json
from pathlib import Path

import pytest
from asking import key, written

from fairaudit.cli import main
from fairaudit.plugins.vlm.tokens import picture_size, picture_tokens, usage

__all__ = ["key"]

# OpenAI, "Images and vision", and Google, "Image understanding": the examples of these pages; Anthropic, "Vision": its table of costs,
# which is rounded.
PUBLISHED = [
    ("gpt-4o", 1024, 1024, 765),
    ("gpt-4o", 2048, 4096, 1105),
    ("gpt-4o-mini-2024-07-18", 1024, 1024, 2833 + 4 * 5667),
    ("openai/o1", 1024, 1024, 75 + 4 * 150),
    ("gpt-5-2025-08-07", 512, 512, 70 + 140),
    ("gpt-4.1-mini", 1024, 1024, 1659),
    ("o4-mini", 4000, 4000, 2642),
    ("claude-sonnet-4-5-20250929", 200, 200, 54),
    ("claude-3-7-sonnet-latest", 1000, 1000, 1334),
    ("google/gemini-2.5-flash", 384, 384, 258),
    ("gemini-2.5-flash", 960, 540, 6 * 258),
    ("qwen/qwen2.5-vl-7b-instruct", 280, 280, 102),
]


@pytest.mark.parametrize(("model", "width", "height", "tokens"), PUBLISHED)
def test_pictures_count_as_published(model: str, width: int, height: int, tokens: int) -> None:
    assert picture_tokens(model, width, height) == tokens


@pytest.mark.parametrize(
    "model", ["gpt-5.4", "gpt-4o-audio-preview", "claude-opus-4-8", "gemini-3-pro-preview", "llava", "smollm2-135m", ""]
)
def test_what_is_not_known_is_not_guessed(model: str) -> None:
    assert picture_tokens(model, 512, 512) is None


@pytest.mark.parametrize("form", ["PNG", "JPEG", "JPEG progressive"])
def test_sizes_of_pictures(form: str, tmp_path: Path) -> None:
    image = pytest.importorskip("PIL.Image", reason="Pillow, another reader of pictures, is not installed")
    for size in ((1, 1), (640, 3), (33, 1200)):
        data = io.BytesIO()
        image.new("RGB", size).save(
            data, form.split()[0], **({"progressive": True, "comment": b"\xff\xc0 no frame"} if " " in form else {})
        )
        path = tmp_path / "picture"
        path.write_bytes(data.getvalue())
        assert picture_size(path) == size
        for cut in range(0, min(700, len(data.getvalue())), 11):
            path.write_bytes(data.getvalue()[:cut])
            assert picture_size(path) in (size, None)


def test_a_dry_run_says_what_it_does_not_know(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    image = pytest.importorskip("PIL.Image", reason="Pillow, which draws the picture, is not installed")
    image.new("RGB", (1024, 1024)).save(tmp_path / "route.png")
    path = written(tmp_path, trials=5, more='[images]\nHR2 = "route.png"\n')
    found = {}
    for model in ("gpt-4o", "one-of-my-own"):
        command = [
            "experiment",
            "run",
            str(path),
            "--folder",
            str(tmp_path),
            "--base-url",
            "http://127.0.0.1:9/v1",
            "--model",
            model,
            "--dry-run",
        ]
        assert main([*command, "--price-input", "2", "--price-output", "10"]) == 0
        said = capsys.readouterr().out
        assert ("what a picture costs there is not known" in said) == (model == "one-of-my-own")
        assert main([*command, "--format", "json"]) == 0
        found[model] = json.loads(capsys.readouterr().out)["result"]["models"][0]
    assert found["gpt-4o"]["output_tokens"] == 20 * 1000
    assert found["gpt-4o"]["pictures_known"]
    assert found["one-of-my-own"]["input_tokens"] - found["gpt-4o"]["input_tokens"] - 20 * (2000 - 765) in range(200)


def test_usage_counts_what_only_the_total_has() -> None:
    """Hidden reasoning, which some servers count in the total alone."""
    assert usage(b'{"usage": {"prompt_tokens": 10, "completion_tokens": 5, "total_tokens": 115}}') == (10, 105)
    assert usage(b'{"usage": {"prompt_tokens": 10, "completion_tokens": 5.0, "total_tokens": 3}}') == (10, 5)
    for bad in ('"7"', "true", "-1", "1.5", "1e300", "1e999", "null", "0", "[1]"):
        assert usage(f'{{"usage": {{"prompt_tokens": {bad}, "completion_tokens": 5}}}}'.encode()) is None
    for counts in ("[]", "7", '{"prompt_tokens": []}'):
        assert usage(f'{{"usage": {counts}}}'.encode()) is None
    assert usage(b"[]") is None and usage(b"<html>") is None
