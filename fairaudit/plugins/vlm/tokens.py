"""What a request uses: text by its length, pictures by the published formulas of the named models, an answer by its cap."""

from __future__ import annotations

import json
import re
import tomllib
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from math import ceil, floor, sqrt
from pathlib import Path
from typing import Any

from fairaudit.errors import InputError, shown
from fairaudit.tables.evaluations.replies import parsed

__all__ = ["CAPS", "DEFAULT_CAP", "Size", "capped", "picture_size", "picture_tokens", "request_size", "usage"]

CAPS = ("max_tokens", "max_completion_tokens")
DEFAULT_CAP = 1_000
ASSUMED_PICTURE = 2_000
MOST_TOKENS = 10**8
OVERHEAD = 64


@dataclass(frozen=True)
class Size:
    """Tokens of a request.

    Sent: likely (four characters each) and at the most (a byte each); then the cap of the answer, and whether the formula for each
    picture is known.
    """

    likely: int
    most: int
    answer: int
    known: bool


def _tiles(width: int, height: int, base: int, tile: int) -> int:
    """OpenAI: fit into 2048×2048, shortest side at most 768, then tiles of 512×512."""
    scale = min(1.0, 2048 / max(width, height), 768 / min(width, height))
    return base + tile * ceil(round(width * scale, 6) / 512) * ceil(round(height * scale, 6) / 512)


def _patches(width: int, height: int, factor: float) -> int:
    """OpenAI: patches of 32×32, at most 1536 of them, times a factor of the model."""
    return ceil(min(1536, ceil(width / 32) * ceil(height / 32)) * factor)


def _claude(width: int, height: int) -> int:
    """Anthropic: longest side at most 1568, then 750 pixels a token, at most about 1,600."""
    return min(1600, ceil(width * height * min(1.0, 1568 / max(width, height)) ** 2 / 750))


def _gemini(width: int, height: int) -> int:
    """Google: 258 up to 384×384, else 258 for each tile, whose side is two thirds of the shorter side."""
    unit = max(1, floor(min(width, height) / 1.5))
    return 258 if max(width, height) <= 384 else 258 * ceil(width / unit) * ceil(height / unit)


def _qwen(width: int, height: int) -> int:
    """Qwen: 28×28 pixels a token, from 4 to 16,384, and two that mark the picture."""
    grow = max(1.0, sqrt(3136 / (width * height)))
    return min(16_384, ceil(width * grow / 28) * ceil(height * grow / 28)) + 2


FORMULAS: Mapping[str, Callable[..., int]] = {
    "tiles": _tiles, "patches": _patches, "claude": _claude, "gemini": _gemini, "qwen": _qwen,
}  # fmt: skip
KNOWN = {
    model: (FORMULAS[formula], entry.get("numbers", ()))
    for formula, entries in tomllib.loads(Path(__file__).with_name("pictures.toml").read_text("utf-8")).items()
    for entry in entries
    for model in entry["models"]
}


def picture_tokens(model: str, width: int, height: int) -> int | None:
    """Tokens of a picture for a named model, in full detail; None where the formula is not known.

    Examples
    --------
    >>> picture_tokens("gpt-4o-2024-08-06", 1024, 1024), picture_tokens("a-model-of-my-own", 1024, 1024)
    (765, None)
    """
    name = re.sub(r"(-\d{8}|-\d{4}-\d{2}-\d{2}|-latest)$", "", model.lower().rpartition("/")[2])
    formula, numbers = KNOWN.get(name, (None, ()))
    return None if formula is None else formula(width, height, *numbers)


def picture_size(path: Path) -> tuple[int, int] | None:
    """Width and height of a PNG or JPEG file, or None if its head does not say."""
    data, at = path.read_bytes(), 2
    if data.startswith(b"\x89PNG"):
        return _sides(data[16:20], data[20:24])
    while at + 9 <= len(data) and data[at] == 0xFF:
        marker = data[at + 1]
        if 0xC0 <= marker <= 0xCF and marker not in (0xC4, 0xC8, 0xCC):  # the head of a frame
            return _sides(data[at + 7 : at + 9], data[at + 5 : at + 7])
        at += 1 if marker == 0xFF else 2 + max(2, int.from_bytes(data[at + 2 : at + 4]))
    return None


def _sides(width: bytes, height: bytes) -> tuple[int, int] | None:
    found = int.from_bytes(width), int.from_bytes(height)
    return found if all(found) and len(width) == len(height) else None


def capped(body: Mapping[str, Any]) -> dict[str, Any]:
    """A request with an output cap, its own or the default; caps that are no whole number, or two of them, are refused."""
    for cap in (body[name] for name in CAPS if name in body):
        if not isinstance(cap, int) or isinstance(cap, bool) or not 1 <= cap <= 10_000_000:
            raise InputError(f"[[model]] parameters has an output cap of {shown(cap)}; a whole number of tokens is accepted")
    if all(name in body for name in CAPS):
        raise InputError(f"a request has two output caps, {' and '.join(CAPS)}; leave one of them out of [[model]] parameters")
    return dict(body) if any(name in body for name in CAPS) else {**body, CAPS[0]: DEFAULT_CAP}


def request_size(body: Mapping[str, Any], pictures: Mapping[str, tuple[int, int] | None]) -> Size:
    """Tokens of a request that is `capped` and names its pictures; `pictures` has their sizes by these names."""
    parts = [part for message in body["messages"] if isinstance(message["content"], list) for part in message["content"]]
    sizes = [pictures.get(part["image_url"]["url"]) for part in parts if part.get("type") == "image_url"]
    counted = [None if size is None else picture_tokens(str(body["model"]), *size) for size in sizes]
    images = sum(ASSUMED_PICTURE if tokens is None else tokens for tokens in counted)
    text = json.dumps(body, ensure_ascii=False)
    cap = next(body[name] for name in CAPS if name in body)
    return Size(len(text) // 4 + images, len(text.encode()) + OVERHEAD + images, cap, None not in counted)


def usage(body: bytes) -> tuple[int, int] | None:
    """Tokens in and out as a server counted them, or None where it does not say, or says what cannot be.

    What the total has beyond the two counts (some servers count hidden reasoning only there) is taken for output.
    """
    try:
        counted = parsed(body)["usage"]
        sent, received = _count(counted["prompt_tokens"]), _count(counted["completion_tokens"])
    except (ValueError, KeyError, TypeError):
        return None
    if not sent or received is None:
        return None
    total = _count(counted.get("total_tokens"))
    return sent, received if total is None else max(received, total - sent)


def _count(value: Any) -> int | None:
    """A number of tokens: whole, not negative, and not more than any model gives."""
    if isinstance(value, bool) or not isinstance(value, (int, float)) or not 0 <= value <= MOST_TOKENS or value != int(value):
        return None
    return int(value)
