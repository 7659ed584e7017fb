"""The split of the draws of all cells into a half that chooses a pair of cells, and a half that tests it."""

from __future__ import annotations

import json
from collections.abc import Sequence
from fractions import Fraction
from hashlib import sha256
from itertools import chain, permutations

from .intervals import Place, Unproven
from .pair_exact import score_ends
from .samples import compared_cells
from .table import Table
from .work import keep, spend

MOST_DRAWS = 10**6  # of all cells together
SCALE = Fraction(4)  # z^2 of the ends by which the first half chooses

Counts = tuple[int, int]  # successes and draws


def names_of_cells(quantity: str, table: Table) -> list[list[bytes]]:
    """Write the labels of the cells that are compared, by block, as canonical text."""
    header = table.header
    columns = header.subject.columns
    names: list[list[bytes]] = []
    for block in compared_cells(quantity, table):
        names.append([])
        for first, *_ in block:
            context = dict(zip(columns.context, header.contexts[first.context], strict=True)) if quantity == "local" else None
            label = {"context": context, "group": dict(zip(columns.group, header.groups[first.group], strict=True))}
            name = json.dumps(label, ensure_ascii=True, sort_keys=True, separators=(",", ":")).encode("ascii")
            spend(100 + len(name))
            keep(1 + len(name) // 8)  # and once more in the lines of the seed
            names[-1].append(name)
    return names


def seed_of(names: Sequence[Sequence[bytes]], counts: Sequence[Sequence[Counts]]) -> str:
    """Digest the names of the cells with their counts, in the order of the names."""
    if sum(n for _, n in chain(*counts)) > MOST_DRAWS:
        raise Unproven(f"a split is for at most {MOST_DRAWS} draws")
    lines = [b"%b %d %d\n" % (name, *own) for name, own in zip(chain(*names), chain(*counts), strict=True)]
    return sha256(b"".join(sorted(lines))).hexdigest()


def halves_of(seed: str, name: bytes, counts: Counts) -> tuple[Counts, Counts]:
    """Split the draws of a cell, in order of their values: those of the least hashes are the first half, rounded down."""
    k, n = counts
    spend(9 * n)
    keep(2 * n)
    start = bytes.fromhex(seed) + sha256(name).digest()
    order = sorted((sha256(start + i.to_bytes(8, "big")).digest(), i) for i in range(n))
    first = sum(i >= n - k for _, i in order[: n // 2])
    return (first, n // 2), (k - first, n - n // 2)


def chosen_by(halves: Sequence[Sequence[Counts]], highs: Sequence[Sequence[Fraction]], names: Sequence[Sequence[bytes]]) -> Place | None:
    """Find the pair of draws in both cells whose lower end of the first mean is the greatest multiple of the upper end of the second."""
    best: tuple[Fraction, tuple[bytes, bytes], Place] | None = None
    for b, (block, high, named) in enumerate(zip(halves, highs, names, strict=True)):
        ends = [[end * own for end in score_ends(k, n, SCALE)] if n else [] for (k, n), own in zip(block, high, strict=True)]
        for i, j in permutations([i for i, own in enumerate(ends) if own], 2):
            spend(20, 128, 128)
            quotient, pair = ends[i][0] / ends[j][1], (named[i], named[j])
            if best is None or quotient > best[0] or (quotient == best[0] and pair < best[1]):
                best = quotient, pair, (b, i, j)
    return None if best is None else best[2]
