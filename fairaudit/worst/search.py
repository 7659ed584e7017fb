"""All ordered pairs of a class of linear constraints, the most promising first, until no other can be worse."""

from __future__ import annotations

from collections.abc import Iterator
from fractions import Fraction
from math import inf
from typing import Any

from fairaudit.errors import Infeasible, InputError
from fairaudit.exact.extended import ONE, ZERO, Extended
from fairaudit.exact.linear_programs import rounded_multipliers
from fairaudit.measures.ratios import global_fairness, local_fairness
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
from fairaudit.worst.pair_programs import pair_program
from fairaudit.worst.ranking import ranked_pairs, stick_multipliers
from fairaudit.worst.result import WorstCase, utility_keeps_floor, utility_of_rows
from fairaudit.worst.rows import LOOKED_AT
from fairaudit.worst.setting import Setting
from fairaudit.worst.whole_utility import Attained, Rows, attained_by, rows_of_point


class LinearSearch:
    """All pairs of a class of linear constraints, the most promising first."""

    def __init__(self, setting: Setting) -> None:
        self.setting = setting
        self.solved: dict[tuple[int, tuple[int, int]], tuple[FractionalProgram, Enclosed]] = {}
        self.phase: dict[Any, tuple[list[Fraction] | None, dict[int, Fraction] | None]] = {}
        self.sticks: dict[tuple[int, tuple[int, int]], Fraction] = {}

    def solve(self, block: int, pair: tuple[int, int]) -> tuple[FractionalProgram, Enclosed]:
        """The program of a pair and what is known of it; solved once."""
        key = (block, pair)
        if key not in self.solved:
            program = pair_program(self.setting, block, pair)
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
        best: Attained | None = None
        upper: Extended = ONE
        empty = True
        for bound, k, block, pair in ranked_pairs(setting):
            if best is not None and bound <= best.ratio:
                self.sticks[block, pair] = k
                empty = False
                continue
            program, found = self.solve(block, pair)
            if found.empty:
                continue
            empty = False
            upper = max(upper, found.upper)
            if found.point is not None:
                candidate = attained_by(setting, block, pair, program, found.point)
                if best is None or candidate.ratio > best.ratio:
                    best = candidate
            if best is not None and best.ratio == inf:
                break
        if empty:
            raise Infeasible("no utility is in the class: its constraints contradict each other or the floor")
        if best is None:
            raise InputError("no utility that is exactly in the class was found; give its constraints as short decimals")
        final = max(upper, best.ratio)
        return WorstCase(
            law=setting.law,
            utility_class=setting.of,
            quantity=setting.quantity,
            upper=final,
            lower=best.ratio,
            witness=best.witness,
            method="lp",
            by="lp-dual",
            theta=best.theta,
            setting=setting,
            values=best.rows,
            proof=lambda: self.evidence(final),
            shown=self._shown(best) if setting.of.couples and setting.of.tau is not None else None,
        )

    def _shown(self, best: Attained) -> tuple[Rows, tuple[Fraction, ...] | None] | None:
        """Find a utility under which no pair without the floor differs more, where the worst one is not of that kind.

        It keeps the floor on all that is compared in all contexts; the pairs that promise most are tried.
        """
        setting = self.setting
        measure = local_fairness if setting.quantity == "local" else global_fairness

        def fits(table: Rows) -> Extended | None:
            found = measure(setting.law, utility_of_rows(setting, table).on(setting.law))
            return found.ratio if found is not None and utility_keeps_floor(setting, table, found.witness) else None

        if fits(best.rows) is not None:
            return None
        ranked = sorted(
            (key for key, (_, found) in self.solved.items() if not found.empty), key=lambda key: self.solved[key][1].upper, reverse=True
        )
        greatest: Any = None
        for block, pair in ranked[:LOOKED_AT]:
            program = pair_program(setting, block, pair)
            floors = [
                ([(j, -c) for j, c in setting.vector(member).items()], -setting.of.tau) for members in setting.members for member in members
            ]
            wide = program.with_rows(floors)
            interior, empty = phase_one(wide)
            if empty is not None:
                break
            found = enclose(wide, interior)
            if found.point is not None:
                table, theta = rows_of_point(setting, wide, found.point)
                ratio = fits(table)
                if ratio is not None and (greatest is None or ratio > greatest[0]):
                    greatest = ratio, table, theta
        return None if greatest is None else greatest[1:]

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
            yield stick_multipliers(self.setting, block, pair, self.sticks[key], ratio)
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


def linear_case(setting: Setting) -> WorstCase:
    """The worst utility of a class of linear constraints."""
    return LinearSearch(setting).run()
