"""All ordered pairs of a class of linear constraints, the most promising first, until no other can be worse."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from fractions import Fraction
from math import inf
from typing import Any

import numpy as np

from fairaudit.errors import InputError
from fairaudit.exact.dense import Floats
from fairaudit.exact.enclosures import UNIT
from fairaudit.exact.extended import ONE, ZERO, Extended
from fairaudit.exact.linear_programs import LinearProgram, dot, rounded_multipliers
from fairaudit.measures.ratios import Witness, global_fairness, local_fairness
from fairaudit.worst.attained import mean_under, raised_to_floor, ratio_of_means, witness_of
from fairaudit.worst.evidence import evidence_entry, pairs_to_prove
from fairaudit.worst.fractional_program import (
    Enclosed,
    FractionalProgram,
    answer_at_ratio,
    enclose,
    least_proved_ratio,
    phase_one,
    refined_multipliers,
)
from fairaudit.worst.result import WorstCase, utility_keeps_floor, utility_of_rows
from fairaudit.worst.rows import ENTRIES, LOOKED_AT, ComparedRows, Indices, compared_rows
from fairaudit.worst.setting import Setting


class LinearSearch:
    """All pairs of a class of linear constraints, the most promising first."""

    def __init__(self, setting: Setting) -> None:
        self.setting = setting
        self.solved: dict[tuple[int, tuple[int, int]], tuple[FractionalProgram, Enclosed]] = {}
        self.phase: dict[Any, tuple[list[Fraction] | None, dict[int, Fraction] | None]] = {}
        self.sticks: dict[tuple[int, tuple[int, int]], Fraction] = {}

    def program(self, block: int, pair: tuple[int, int]) -> FractionalProgram:
        """The program of an ordered pair: the whole class if constraints couple contexts, else only what concerns the pair.

        A utility of two groups extends to the others: the same g where the class is blind, g(·,b) = min(γ, g(·,a) + L·d(a,b), …) in a
        Lipschitz class. Mixed with the constant γ it keeps all floors at no loss (see `_raised`).
        """
        setting = self.setting
        floors = setting.floors(block, pair)
        offset = len(floors)
        if setting.of.couples:
            variables = list(range(setting.size))
            numbers = [*range(offset), *range(offset, offset + setting.numbering(block).end)]
        else:
            variables = sorted({v for member in pair for v in self._variables(member)})
            numbers = [floors.index(pair[1])] if floors else []
            numbers += [offset + i for i in self._numbers(block, pair)]
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

    def _cells(self, member: int) -> list[int]:
        return [member] if self.setting.quantity == "local" else [i for i, a in enumerate(self.setting.group_of) if a == member]

    def _variables(self, member: int) -> Iterator[int]:
        setting = self.setting
        for cell in self._cells(member):
            yield from (setting.variable(cell, u) for u in range(setting.n))

    def _numbers(self, block: int, pair: tuple[int, int]) -> Iterator[int]:
        """Constraints on the utilities of a pair, but the floors."""
        setting = self.setting
        cells = [self._cells(member) for member in pair]
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

    def solve(self, block: int, pair: tuple[int, int]) -> tuple[FractionalProgram, Enclosed]:
        key = (block, pair)
        if key not in self.solved:
            program = self.program(block, pair)
            interior: list[Fraction] | None = list(program.linear.high)
            if self.setting.of.couples:
                which = (block, pair if self.setting.of.tau_on == "pair" else None)
                if which not in self.phase:
                    self.phase[which] = phase_one(program)
                interior, empty = self.phase[which]
                if empty is not None:
                    self.solved[key] = program, Enclosed(ZERO, empty, None, empty=True)
                    return self.solved[key]
            self.solved[key] = program, enclose(program, interior)
        return self.solved[key]

    def run(self) -> WorstCase:
        """Solve pair after pair until no other can be worse."""
        setting = self.setting
        best: tuple[Extended, int, tuple[int, int], dict[int, list[Fraction]], Witness, Any] | None = None
        upper: Extended = ONE
        empty = True
        for bound, k, block, pair in self._ranked():
            if best is not None and bound <= best[0]:
                self.sticks[block, pair] = k
                empty = False
                continue
            program, found = self.solve(block, pair)
            if found.empty:
                continue
            empty = False
            upper = max(upper, found.upper)
            if found.point is not None:
                candidate = self._attained(block, pair, program, found.point)
                if best is None or candidate[0] > best[0]:
                    best = candidate
            if best is not None and best[0] == inf:
                break
        if empty:
            raise InputError("no utility is in the class: its constraints contradict each other or the floor")
        if best is None:
            raise InputError("no utility that is exactly in the class was found; give its constraints as short decimals")
        upper = max(upper, best[0])
        final = upper
        shown = self._shown(best) if setting.of.couples and setting.of.tau is not None else None
        return WorstCase(
            setting.law,
            setting.of,
            setting.quantity,
            final,
            best[0],
            best[4],
            "lp",
            "lp-dual",
            best[5],
            True,
            None,
            setting,
            best[3],
            lambda: self.evidence(final),
            shown,
        )

    def _shown(self, best: Any) -> tuple[dict[int, list[Fraction]], tuple[Fraction, ...] | None] | None:
        """Find a utility under which no pair without the floor differs more, where the worst one is not of that kind.

        It keeps the floor on all that is compared in all contexts; the pairs that promise most are tried.
        """
        setting = self.setting
        measure = local_fairness if setting.quantity == "local" else global_fairness

        def fits(table: dict[int, list[Fraction]]) -> Extended | None:
            found = measure(setting.law, utility_of_rows(setting, table).on(setting.law))
            return found.ratio if found is not None and utility_keeps_floor(setting, table, found.witness) else None

        if fits(best[3]) is not None:
            return None
        ranked = sorted(
            (key for key, (_, found) in self.solved.items() if not found.empty), key=lambda key: self.solved[key][1].upper, reverse=True
        )
        greatest: Any = None
        for block, pair in ranked[:LOOKED_AT]:
            program = self.program(block, pair)
            floors = [
                ([(j, -c) for j, c in setting.vector(member).items()], -setting.of.tau) for members in setting.members for member in members
            ]
            wide = program.with_rows(floors)
            interior, empty = phase_one(wide)
            if empty is not None:
                break
            found = enclose(wide, interior)
            if found.point is not None:
                table, theta = self._table(wide, found.point)
                ratio = fits(table)
                if ratio is not None and (greatest is None or ratio > greatest[0]):
                    greatest = ratio, table, theta
        return None if greatest is None else greatest[1:]

    def _attained(
        self, block: int, pair: tuple[int, int], program: FractionalProgram, point: Sequence[Fraction]
    ) -> tuple[Extended, int, tuple[int, int], dict[int, list[Fraction]], Witness, Any]:
        """The ratio of a point of the class, with the whole utility."""
        setting = self.setting
        table, theta = self._table(program, point)
        if setting.of.couples:
            values = (mean_under(setting, pair[0], table), mean_under(setting, pair[1], table))
            if values[1] > values[0]:
                pair, values = (pair[1], pair[0]), (values[1], values[0])
            return ratio_of_means(*values), block, pair, table, witness_of(setting, block, pair, values), theta
        if not setting.of.blind:
            self._extend(table)
        ratio, witness, raised = raised_to_floor(setting, block, pair, table)
        return ratio, block, pair, raised, witness, None

    def _table(
        self, program: FractionalProgram, point: Sequence[Fraction]
    ) -> tuple[dict[int, list[Fraction]], tuple[Fraction, ...] | None]:
        """Rows of the utility that a point of a program stands for, and θ."""
        setting = self.setting
        table: dict[int, list[Fraction]] = {}
        if setting.of.family is not None and setting.features is not None:
            for place in range(len(setting.cells)):
                for cell in setting.slots(place):
                    table[place if setting.of.blind else cell] = [dot(phi, point) for phi in setting.features[cell]]
            return table, tuple(point)
        for v, value in zip(program.variables, point, strict=True):
            row, u = divmod(v, setting.n)
            table.setdefault(row, [setting.of.gamma] * setting.n)[u] = value
        return table, None

    def _extend(self, table: dict[int, list[Fraction]]) -> None:
        """Give the other groups the greatest utility that the class allows beside the pair's."""
        setting = self.setting
        if setting.of.lipschitz is None:
            return
        known = dict(table)
        for place in {setting.place_of[cell] for cell in known}:
            anchors = [cell for cell in setting.cells[place] if cell in known]
            for cell in setting.cells[place]:
                if cell not in known:
                    table[cell] = [
                        min([setting.of.gamma, *(known[other][u] + setting.reach(other, cell) for other in anchors)])
                        for u in range(setting.n)
                    ]

    def _ranked(self) -> list[tuple[float, Fraction, int, tuple[int, int]]]:
        """All ordered pairs with a cheap rigorous bound and the k that gives it, greatest first."""
        setting = self.setting
        pairs = [(block, (i, j)) for block, members in enumerate(setting.members) for i in members for j in members if i != j]
        if setting.of.cap > 10**250 or setting.of.gamma > 10**250 or setting.of.family is not None:
            return [(inf, ZERO, block, pair) for block, pair in pairs]
        rows = compared_rows(setting)
        index = {(block, source): i for i, source in enumerate(rows.sources) for block in (rows.block(i),)}
        highs = np.array([index[block, pair[0]] for block, pair in pairs])
        lows = np.array([index[block, pair[1]] for block, pair in pairs])
        width = setting.of.gamma - setting.of.m
        if setting.of.blind:
            gaps = np.zeros(len(pairs))
        elif setting.of.lipschitz is None:
            gaps = np.full(len(pairs), float(width))
        else:
            gaps = np.array([float(min(width, self._gap(pair))) for _, pair in pairs])
        best, ks = np.full(len(pairs), np.inf), np.zeros(len(pairs))
        cap = float(min(setting.of.cap, Fraction(10) ** 6))
        for k in (0.0, *(round(k * 64) / 64 for k in np.geomspace(1.0, max(cap, 1.001), 24).tolist())):
            bounds = self._bounds(rows, highs, lows, gaps, k)
            better = bounds < best
            best[better], ks[better] = bounds[better], k
        order = np.argsort(-best, kind="stable").tolist()
        return [(float(best[i]), Fraction(float(ks[i])), *pairs[i]) for i in order]

    def _gap(self, pair: tuple[int, int]) -> Fraction:
        setting = self.setting
        a, b = pair if setting.quantity == "global" else (setting.group_of[pair[0]], setting.group_of[pair[1]])
        gap: Fraction = setting.of.lipschitz * (ONE if setting.metric is None else setting.metric[a][b])
        return gap

    def _bounds(self, rows: ComparedRows, highs: Indices, lows: Indices, gaps: Floats, k: float) -> Floats:
        """R ≤ k + max(0, Σ_u max over g of P·min(γ, g + K) − k·Q·g)/τ, rounded up."""
        of = self.setting.of
        gamma, m, floor = float(of.gamma), float(of.m), float(of.floor)
        bounds = np.empty(len(highs))
        n, chain = rows.floats.shape[1], self.setting.chain
        error = (gamma / floor + 1.0) * (1.0 + k) * (8 * n + 128) * UNIT
        step = max(1, ENTRIES // n)
        for begin in range(0, len(highs), step):
            part = slice(begin, begin + step)
            p, q = rows.floats[highs[part]], k * rows.floats[lows[part]]
            gap = gaps[part, None]
            difference = p - q
            if chain is not None:
                # A monotone utility is m plus steps: the best one is m + (γ − m) on an upper set of the chain, in each context.
                tails = np.cumsum(difference.reshape(len(p), -1, len(chain))[:, :, chain[::-1]], axis=2).max(axis=2)
                total = m * difference.sum(axis=1) + (gamma - m) * np.maximum(tails, 0.0).sum(axis=1)
                bounds[part] = k + np.maximum(total, 0.0) / floor + error
                continue
            apart = np.where(difference > 0, difference * gamma, difference * m) + np.minimum(p, q) * gap
            total = np.minimum(apart, p * gamma - q * m).sum(axis=1)
            bounds[part] = k + np.maximum(total, 0.0) / floor + error
        return bounds

    def evidence(self, ratio: Extended) -> dict[str, Any]:
        """Multipliers for every ordered pair that needs them, each checked exactly."""
        entries = []
        for block, pair in pairs_to_prove(self.setting, ratio):
            assert isinstance(ratio, Fraction)  # noqa: S101 - nothing is needed for infinity
            for found in self._proofs(block, pair, ratio):
                if self.setting.proves(block, pair, found, ratio):
                    entries.append(evidence_entry(self.setting, block, pair, found))
                    break
            else:
                raise InputError("the proof of the worst case could not be completed; give a floor (tau) to the class")
        return {"pairs": entries}

    def _proofs(self, block: int, pair: tuple[int, int], ratio: Fraction) -> Iterator[dict[int, Fraction]]:
        """Yield multipliers by constraint number that may prove a ratio for a pair."""
        key = (block, pair)
        if key in self.sticks:
            yield self._from_stick(block, pair, self.sticks[key], ratio)
        if self.setting.of.family is None:
            yield {}
        program, found = self.solve(block, pair)
        if found.empty:
            objective, _ = program.excess({}, ratio)
            scale = max(ZERO, objective) / Fraction(program.linear.emptiness(found.multipliers))
            yield {program.numbers[i]: y * scale for i, y in found.multipliers.items()}
            return
        named = {program.numbers[i]: y for i, y in found.multipliers.items()}
        yield named
        if program.floor is not None and isinstance(found.upper, Fraction):
            number = program.numbers[program.floor]
            yield {**named, number: named.get(number, ZERO) + ratio - found.upper}
        again = answer_at_ratio(program, ratio)
        if again is not None:
            for proof in refined_multipliers(program, again, ratio):
                yield {program.numbers[i]: y for i, y in proof.items()}
            _, proof = least_proved_ratio(program, rounded_multipliers(again[1]), ratio)
            yield {program.numbers[i]: y for i, y in proof.items()}

    def _from_stick(self, block: int, pair: tuple[int, int], k: Fraction, ratio: Fraction) -> dict[int, Fraction]:
        """Write the k of a cheap bound as multipliers: R − k on the floor of the lower group, and what joins the two utilities."""
        setting = self.setting
        of = setting.of
        found: dict[int, Fraction] = {}
        floors = setting.floors(block, pair)
        if floors and of.tau > of.m and ratio > k:
            found[floors.index(pair[1])] = ratio - k
        else:
            k = ratio
        if setting.chain is not None:
            found |= self._up_the_chain(block, pair, k, len(floors))
        if of.blind or of.lipschitz is None:
            return found
        second = {setting.place_of[cell]: cell for cell in self._cells(pair[1])}
        means = setting.vector(pair[0]), setting.vector(pair[1])
        for cell in self._cells(pair[0]):
            other = second.get(setting.place_of[cell])
            if other is None:
                continue
            reach = setting.reach(cell, other)
            for u, number in enumerate(setting.distance_numbers(block, cell, other)):
                p = means[0].get(setting.variable(cell, u), ZERO)
                q = k * means[1].get(setting.variable(other, u), ZERO)
                apart = (p - q) * (of.gamma if p > q else of.m) + min(p, q) * reach
                if min(p, q) > 0 and apart < p * of.gamma - q * of.m:
                    found[len(floors) + number] = min(p, q)
        return found

    def _up_the_chain(self, block: int, pair: tuple[int, int], k: Fraction, offset: int) -> dict[int, Fraction]:
        """Multipliers of the order that push what is positive in P − k·Q up the chain, where it cancels what is negative."""
        setting = self.setting
        high, low = setting.vector(pair[0]), setting.vector(pair[1])
        found: dict[int, Fraction] = {}
        for cell in sorted({setting.cells[setting.place_of[c]][0] for member in pair for c in self._cells(member)}):
            pushed = ZERO
            for number, (u, _) in zip(setting.order_numbers(block, cell), setting.order, strict=True):
                v = setting.variable(cell, u)
                pushed = max(ZERO, pushed + high.get(v, ZERO) - k * low.get(v, ZERO))
                if pushed:
                    found[offset + number] = pushed
        return found


def linear_case(setting: Setting) -> WorstCase:
    return LinearSearch(setting).run()
