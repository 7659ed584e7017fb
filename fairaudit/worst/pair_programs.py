"""The fractional program of an ordered pair: its variables and rows among those of the class."""

from __future__ import annotations

from collections.abc import Iterator

from fairaudit.exact.extended import ZERO
from fairaudit.exact.linear_programs import LinearProgram
from fairaudit.worst.fractional_program import FractionalProgram
from fairaudit.worst.setting import Setting


def pair_program(setting: Setting, block: int, pair: tuple[int, int]) -> FractionalProgram:
    """The program of an ordered pair: the whole class if constraints couple contexts, else only what concerns the pair.

    A utility of two groups extends to the others: the same g where the class is blind, g(·,b) = min(γ, g(·,a) + L·d(a,b), …) in a
    Lipschitz class. Mixed with the constant γ it keeps all floors at no loss (see `raised_to_floor`).
    """
    floors = setting.floors(block, pair)
    offset = len(floors)
    if setting.of.couples:
        variables = list(range(setting.size))
        numbers = [*range(offset), *range(offset, offset + setting.numbering(block).end)]
    else:
        variables = sorted({v for member in pair for v in _variables(setting, member)})
        numbers = [floors.index(pair[1])] if floors else []
        numbers += [offset + i for i in _numbers(setting, block, pair)]
    position = {v: j for j, v in enumerate(variables)}
    rows, kept = [], []
    for number in numbers:
        terms, bound = setting.constraint(block, pair, number)
        if terms or bound < 0:  # an empty row with a negative bound contradicts itself
            rows.append(([(position[v], a) for v, a in terms.items()], bound))
            kept.append(number)
    floor = kept.index(floors.index(pair[1])) if floors and setting.of.tau > 0 else None
    p, q = ([vector.get(v, ZERO) for v in variables] for vector in (setting.vector(member) for member in pair))
    low, high = zip(*(setting.box(v) for v in variables), strict=True)
    return FractionalProgram(LinearProgram(low, high, rows), variables, kept, p, q, floor, setting.of.cap)


def _variables(setting: Setting, member: int) -> Iterator[int]:
    for cell in setting.cells_of(member):
        yield from (setting.variable(cell, u) for u in range(setting.n))


def _numbers(setting: Setting, block: int, pair: tuple[int, int]) -> Iterator[int]:
    """Constraints on the utilities of a pair, but the floors."""
    cells = [setting.cells_of(member) for member in pair]
    if setting.order:
        slots = {setting.cells[setting.place_of[c]][0] if setting.of.blind else c for listed in cells for c in listed}
        for cell in sorted(slots):
            yield from setting.order_numbers(block, cell)
    if setting.of.lipschitz is not None:
        second = {setting.place_of[cell]: cell for cell in cells[1]}
        for cell in cells[0]:
            other = second.get(setting.place_of[cell])
            if other is not None:
                yield from setting.distance_numbers(block, cell, other)
                yield from setting.distance_numbers(block, other, cell)
