"""An independent oracle: the definitions of the fairness measures as plain loops over `Fraction`s, and nothing else."""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction
from itertools import combinations, permutations
from math import inf
from typing import Any

from fairaudit.model.law import Law
from fairaudit.model.utility import Utility


@dataclass
class Plain:
    """A law and a utility as nested dictionaries of fractions."""

    p: dict[int, dict[int, list[Fraction]]]
    mass: dict[tuple[int, int], Fraction]
    g: dict[tuple[int, int], list[Fraction]]
    groups: int
    equal: bool
    complete: bool

    @property
    def shared(self) -> list[int]:
        """Groups that the global quantities compare."""
        if self.equal and not self.complete:
            return []
        found = [a for a in range(self.groups) if sum((m for (_, b), m in self.mass.items() if b == a), Fraction(0)) > 0]
        return found if len(found) > 1 else []


def plain(law: Law, utility: Utility) -> Plain:
    """Read the law's own arrays, entry by entry, without its arithmetic."""
    table = utility.on(law)
    p: dict[int, dict[int, list[Fraction]]] = {}
    mass, g = {}, {}
    for i in range(len(law.weights)):
        x, a = int(law.cell_context[i]), int(law.cell_group[i])
        raw = [Fraction(v) for v in law.weights[i].tolist()]
        total = sum(raw)
        p.setdefault(x, {})[a] = [v / total for v in raw]
        mass[x, a] = total if law.kind == "counts" else Fraction(law.mass[i]) if law.mass is not None else Fraction(1)
        row = table.values if table.values.ndim == 1 else table.values[i]
        g[x, a] = [Fraction(int(v), table.scale) for v in row.tolist()]
    complete = len(law.weights) == len(law.groups) * len(law.contexts)
    return Plain(p, mass, g, len(law.groups), law.population == "equal", complete)


def ratio(top: Fraction, bottom: Fraction) -> Any:
    """Return the ratio by the conventions."""
    if bottom == 0:
        return Fraction(1) if top == 0 else inf
    return top / bottom


def expectation(law: Plain, x: int, a: int) -> Fraction:
    return sum((w * v for w, v in zip(law.p[x][a], law.g[x, a], strict=True)), Fraction(0))


def mean(law: Plain, a: int) -> Fraction:
    cells = [x for x in law.p if a in law.p[x]]
    total = sum((law.mass[x, a] for x in cells), Fraction(0))
    return sum((law.mass[x, a] * expectation(law, x, a) for x in cells), Fraction(0)) / total


def mixture(law: Plain, a: int) -> list[Fraction]:
    cells = [x for x in law.p if a in law.p[x]]
    total = sum((law.mass[x, a] for x in cells), Fraction(0))
    size = len(next(iter(law.p[cells[0]].values())))
    return [sum((law.mass[x, a] * law.p[x][a][u] for x in cells), Fraction(0)) / total for u in range(size)]


def first_greatest(items: list[tuple[Any, Any]]) -> tuple[Any, Any] | None:
    """Greatest value with the first key that attains it."""
    best: tuple[Any, Any] | None = None
    for value, key in items:
        if best is None or value > best[0]:
            best = (value, key)
    return best


def local(law: Plain) -> Any:
    """Return (R, (x, a, a')) or None."""
    return first_greatest(
        [
            (ratio(expectation(law, x, a), expectation(law, x, b)), (x, a, b))
            for x in sorted(law.p)
            for a, b in sorted(permutations(sorted(law.p[x]), 2))
        ]
    )


def overall(law: Plain) -> Any:
    """Return (R̄, (a, a')) or None."""
    means = {a: mean(law, a) for a in law.shared}
    return first_greatest([(ratio(means[a], means[b]), (a, b)) for a, b in permutations(law.shared, 2)])


def distance(p: list[Fraction], q: list[Fraction]) -> Fraction:
    return sum((abs(v - w) for v, w in zip(p, q, strict=True)), Fraction(0)) / 2


def equalized_odds(law: Plain) -> Any:
    return first_greatest(
        [(distance(law.p[x][a], law.p[x][b]), (x, a, b)) for x in sorted(law.p) for a, b in combinations(sorted(law.p[x]), 2)]
    )


def demographic_parity(law: Plain) -> Any:
    rows = {a: mixture(law, a) for a in law.shared}
    return first_greatest([(distance(rows[a], rows[b]), (a, b)) for a, b in combinations(law.shared, 2)])


def local_supremum(law: Plain) -> Any:
    """Return (R*, (x, u, a, a')) or None."""
    return first_greatest(
        [
            (ratio(law.p[x][a][u], law.p[x][b][u]), (x, u, a, b))
            for x in sorted(law.p)
            for u in range(len(next(iter(law.p[x].values()))))
            for a, b in sorted(permutations(sorted(law.p[x]), 2))
        ]
    )


def global_supremum(law: Plain) -> Any:
    rows = {a: mixture(law, a) for a in law.shared}
    if not rows:
        return None
    size = len(next(iter(rows.values())))
    return first_greatest([(ratio(rows[a][u], rows[b][u]), (u, a, b)) for u in range(size) for a, b in permutations(law.shared, 2)])
