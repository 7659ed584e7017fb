"""From a point of a pair's program to a utility of the whole class, and what it attains."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction

from fairaudit.exact.extended import Extended
from fairaudit.exact.linear_programs import dot
from fairaudit.measures.ratios import Witness
from fairaudit.worst.attained import mean_under, raised_to_floor, ratio_of_means, witness_of
from fairaudit.worst.fractional_program import FractionalProgram
from fairaudit.worst.setting import Setting

Rows = dict[int, list[Fraction]]
"""g by row of the utility, as `WorstCase.values`."""


@dataclass(frozen=True, eq=False)
class Attained:
    """A utility of the class, the ratio that it attains, and the pair that attains it."""

    ratio: Extended
    rows: Rows
    witness: Witness
    theta: tuple[Fraction, ...] | None = None
    """Its parameters in a family."""


def attained_by(setting: Setting, block: int, pair: tuple[int, int], program: FractionalProgram, point: Sequence[Fraction]) -> Attained:
    """The ratio of a point of the class, with the whole utility."""
    rows, theta = rows_of_point(setting, program, point)
    if setting.of.couples:
        values = (mean_under(setting, pair[0], rows), mean_under(setting, pair[1], rows))
        if values[1] > values[0]:
            pair, values = (pair[1], pair[0]), (values[1], values[0])
        return Attained(ratio_of_means(*values), rows, witness_of(setting, block, pair, values), theta)
    if not setting.of.blind:
        _extend(setting, rows)
    ratio, witness, raised = raised_to_floor(setting, block, pair, rows)
    return Attained(ratio, raised, witness)


def rows_of_point(setting: Setting, program: FractionalProgram, point: Sequence[Fraction]) -> tuple[Rows, tuple[Fraction, ...] | None]:
    """Rows of the utility that a point of a program stands for, and θ."""
    table: Rows = {}
    if setting.of.family is not None and setting.features is not None:
        for place in range(len(setting.cells)):
            for cell in setting.slots(place):
                table[place if setting.of.blind else cell] = [dot(phi, point) for phi in setting.features[cell]]
        return table, tuple(point)
    for v, value in zip(program.variables, point, strict=True):
        row, u = divmod(v, setting.n)
        table.setdefault(row, [setting.of.gamma] * setting.n)[u] = value
    return table, None


def _extend(setting: Setting, table: Rows) -> None:
    """Give the other groups the greatest utility that the class allows beside the pair's."""
    if setting.of.lipschitz is None:
        return
    known = dict(table)
    for place in {setting.place_of[cell] for cell in known}:
        anchors = [cell for cell in setting.cells[place] if cell in known]
        for cell in setting.cells[place]:
            if cell not in known:
                table[cell] = [
                    min([setting.of.gamma, *(known[other][u] + setting.reach(other, cell) for other in anchors)]) for u in range(setting.n)
                ]
