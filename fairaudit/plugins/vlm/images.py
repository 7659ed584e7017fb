"""Pictures that an experiment shows: PNG or JPEG files, or a candidate set whose pictures have not changed since they were drawn."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from fairaudit.errors import InputError, nearest, shown
from fairaudit.files import read_bounded

__all__ = ["image_kind", "image_name", "read_images"]

MAX_IMAGE_BYTES = 10_000_000
IMAGE_KINDS = {b"\x89PNG\r\n\x1a\n": "image/png", b"\xff\xd8\xff": "image/jpeg"}
CANDIDATES = "candidates"
CANDIDATES_FORMAT = "fairaudit-candidates/1"


def read_images(section: Mapping[str, Any], folder: Path, options: tuple[str, ...]) -> dict[tuple[str, str], Path]:
    """Read the section ``[images]``: a path for each option, for each context and option, or ``candidates``, the path of a candidate set.

    The pictures are given by (context, option); the context is empty where they do not depend on it. A file that is no picture, or not
    the one that the candidate set describes, is refused.
    """
    found: dict[tuple[str, str], Path] = {}
    for key, value in section.items():
        if key == CANDIDATES and CANDIDATES not in options and isinstance(value, str):
            found.update(_candidate_set(folder / value, options))
            continue
        entries: dict[tuple[str, str], Any] = {}
        if isinstance(value, str):
            entries = {("", key): value}
        elif isinstance(value, dict):
            entries = {(key, option): name for option, name in value.items()}
        if not entries:
            raise InputError(f"[images] {key} is {shown(value)}; the path of a PNG or JPEG file for an option is accepted")
        for (context, option), name in entries.items():
            if option not in options:
                raise InputError(f"[images] names {shown(option)}, which is not an option; {nearest(option, options)}")
            found[context, option] = _image(folder / str(name))
    return found


def image_kind(head: bytes) -> str | None:
    """Media type of an image by its first bytes."""
    return next((kind for magic, kind in IMAGE_KINDS.items() if head.startswith(magic)), None)


def image_name(path: Path) -> str:
    """What requests in a journal call a picture: its SHA-256."""
    return f"sha256:{hashlib.sha256(path.read_bytes()).hexdigest()}"


def _candidate_set(path: Path, options: tuple[str, ...]) -> dict[tuple[str, str], Path]:
    try:
        document = json.loads(path.read_bytes())
        if document["format"] != CANDIDATES_FORMAT:
            raise KeyError("format")
        listed = [(entry["label"], entry["picture"], entry["picture_sha256"]) for entry in document["candidates"]]
    except OSError as error:
        raise InputError(f"the candidate set {path} cannot be read: {error.strerror}") from None
    except (ValueError, KeyError, TypeError, RecursionError):
        raise InputError(f"{path} is no candidate set; a file of the format {CANDIDATES_FORMAT} is accepted") from None
    if sorted(label for label, _, _ in listed if isinstance(label, str)) != sorted(options):
        raise InputError(
            f"the candidates of {path} are {shown([label for label, _, _ in listed])}; they must be the options {shown([*options])}"
        )
    found = {}
    for label, name, digest in listed:
        picture = _image(path.parent / Path(str(name)).name)
        if image_name(picture) != f"sha256:{digest}":
            raise InputError(f"the image {picture} is not the one that {path} describes; render the scenario again")
        found["", label] = picture
    return found


def _image(path: Path) -> Path:
    if image_kind(read_bounded(path, MAX_IMAGE_BYTES, "picture that is sent to a model")) is None:
        raise InputError(f"the image {path} is neither PNG nor JPEG")
    return path
