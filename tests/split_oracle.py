"""The half-split by definition, as docs/certificate-samples.md has it: names, seed, halves and choice, by code of its own."""

from __future__ import annotations

import hashlib
import math
from fractions import Fraction
from typing import Any

from pair_oracle import score_ends

Place = tuple[dict[str, str] | None, dict[str, str]]
"""Labels of the context (None over all contexts) and of the group."""


def text(value: dict[str, str] | None) -> str:
    if value is None:
        return "null"
    return "{" + ",".join(f"{quoted(key)}:{quoted(label)}" for key, label in sorted(value.items())) + "}"


def quoted(label: str) -> str:
    short = {'"': '\\"', "\\": "\\\\", "\n": "\\n", "\r": "\\r", "\t": "\\t", "\b": "\\b", "\f": "\\f"}
    units = label.encode("utf-16-be", "surrogatepass")
    codes = [units[i] << 8 | units[i + 1] for i in range(0, len(units), 2)]
    return '"' + "".join(short.get(chr(c)) or (chr(c) if 32 <= c < 127 else f"\\u{c:04x}") for c in codes) + '"'


def name(place: Place) -> bytes:
    context, group = place
    return f'{{"context":{text(context)},"group":{text(group)}}}'.encode()


def seed(cells: dict[bytes, tuple[int, int]]) -> str:
    """The seed of cells with their successes and draws, by name."""
    digest = hashlib.sha256()
    for own, (k, n) in sorted(cells.items()):
        digest.update(own + f" {k} {n}\n".encode())
    return digest.hexdigest()


def first_half(seeded: str, own: bytes, k: int, n: int) -> tuple[int, int]:
    """Successes and draws of the half that chooses."""
    draws = [0] * (n - k) + [1] * k
    ranks = {}
    for i, value in enumerate(draws):
        data = bytes.fromhex(seeded) + hashlib.sha256(own).digest() + bytes([i >> 8 * j & 255 for j in range(7, -1, -1)])
        ranks[hashlib.new("sha256", data).hexdigest()] = value
    chosen = [ranks[rank] for rank in sorted(ranks)][: math.floor(n / 2)]
    return sum(chosen), len(chosen)


def choice(blocks: list[dict[bytes, tuple[int, int]]], halves: dict[bytes, tuple[int, int]]) -> tuple[bytes, bytes] | None:
    """The names of the chosen pair, of cells that are worth 1."""
    found: list[tuple[Any, bytes, bytes]] = []
    for block in blocks:
        for one in block:
            for other in block:
                (k, n), (m, size) = halves[one], halves[other]
                if one != other and n and size:
                    low, high = score_ends(k, n, Fraction(4))[0], score_ends(m, size, Fraction(4))[1]
                    found.append((-Fraction(low, high), one, other))
    return min(found)[1:] if found else None
