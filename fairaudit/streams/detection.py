"""Change by an e-detector in a stream: for which ratios, over which limit, and what an alarm says."""

from __future__ import annotations

from collections.abc import Mapping
from fractions import Fraction
from typing import Any

from fairaudit.inference.detectors import Detection, Detector, ratio_above
from fairaudit.inference.pairing import Moment
from fairaudit.measures.limits import LIMITS, Quantity
from fairaudit.streams.settings import Settings
from fairaudit.tables.values import Label

Cells = Mapping[tuple[Label, Label], int]


def limit_of(settings: Settings, quantity: Quantity) -> Fraction | None:
    """The least limit on a ratio that the targets name, as a ratio."""
    found = [
        ratio_above(Fraction(limit), LIMITS[name][1]) for name, limit in (settings.targets or {}).items() if LIMITS[name][0] == quantity
    ]
    return min((limit for limit in found if limit is not None), default=None)


class Detectors:
    """The detectors of the ratios that have a target.

    Parameters
    ----------
    settings : Settings
        The targets, and the run length.
    cells : mapping of (context, group) to int
        The cells that were seen so far, by rank; it may grow.
    kept : mapping
        What `kept` returned.
    stopped : set of quantity
        Ratios of which nothing more is asked.
    """

    def __init__(self, settings: Settings, cells: Cells, kept: Mapping[str, Any], stopped: frozenset[Quantity]) -> None:
        self.settings, self._cells = settings, cells
        self._groups: dict[Label, int] = {}
        self.running: dict[Quantity, Detector] = {}
        named = {LIMITS[name][0] for name in settings.targets or {}} if settings.run_length else set()
        for quantity in sorted(named, reverse=True):  # local first, which withdraws the global one too
            limit = limit_of(settings, quantity)
            if limit is not None and quantity not in stopped:
                self.running[quantity] = Detector(limit, settings.limits[1], settings.run_length, kept.get(quantity))
        for context, group in cells:
            for quantity, detector in self.running.items():
                detector.join(*self._place(quantity, context, group))

    def _place(self, quantity: Quantity, context: Label, group: Label) -> tuple[Label | None, int]:
        """The block within which a cell is compared, and its number there."""
        if quantity == "local":
            return context, self._cells[context, group]
        return None, self._groups.setdefault(group, len(self._groups) + 1)

    def take(self, cell: tuple[Label, Label], value: Fraction, at: Moment) -> list[tuple[Quantity, Detection]]:
        """Take a decision in; returns the alarms that it raises, whose detectors then rest."""
        raised: list[tuple[Quantity, Detection]] = []
        for quantity, detector in self.running.items():
            found = detector.take(*self._place(quantity, *cell), value, at)
            if found is not None:
                raised.append((quantity, found))
        return raised

    def stop(self, quantities: frozenset[Quantity]) -> None:
        """Ask nothing more of these ratios."""
        self.running = {quantity: detector for quantity, detector in self.running.items() if quantity not in quantities}

    def kept(self) -> dict[str, Any]:
        """All that is to be remembered."""
        return {quantity: detector.kept() for quantity, detector in self.running.items()}

    def entry(self, quantity: Quantity, found: Detection) -> dict[str, Any]:
        """What an alarm says: the pair, the limit, the estimated moment, and how often such an alarm is false."""
        detector = self.running[quantity]
        columns = self.settings.context, self.settings.group
        if quantity == "local":
            cells = {rank: cell for cell, rank in self._cells.items()}
            (context, higher), (_, lower) = cells[found.higher], cells[found.lower]
        else:
            groups = {number: group for group, number in self._groups.items()}
            context, higher, lower = (), groups[found.higher], groups[found.lower]
        named = None if quantity == "global" else dict(zip(columns[0], context, strict=True))
        decision, clock = found.since
        return {
            "detected": quantity,
            "limit": str(detector.limit),
            "pair": {
                "context": named,
                "higher": dict(zip(columns[1], higher, strict=True)),
                "lower": dict(zip(columns[1], lower, strict=True)),
            },
            "since": {"decision": decision, "clock": clock},
            "run_length": detector.run_length,
            "directions": found.directions,
            "error": str(min(Fraction(1), found.pairs / detector.run_length)),
            "exceeds": [],
        }
