"""What a monitor audits: columns, utility, targets and budget of error, fixed before the first decision is read."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Mapping
from dataclasses import asdict, dataclass, fields
from fractions import Fraction
from typing import Any

from fairaudit.errors import InputError, nearest, shown
from fairaudit.exact.rationals import option_value, rational_text
from fairaudit.inference.levels import confidence_level, equal_share
from fairaudit.measures.limits import LIMITS, read_limit, refuse_bare
from fairaudit.words import brief

__all__ = ["OTHER", "Settings"]


OTHER = "(other)"  # the decision that stands for those that are not listed

PAIR_STEPS = 100  # of the utility, where pairs in time are tallied by both of theirs

RUN_LENGTH = 20_000  # pairs per direction to a false alarm of a detector, in the mean, at least

EARLIER = {"max_local": "max_local_log", "max_global": "max_global_log"}
"""What limits on logarithms are called in states of before."""


@brief
@dataclass(frozen=True, repr=False)
class Settings:
    """The settings of a monitor. Numbers are kept as the texts of exact rationals.

    Attributes
    ----------
    group, context : tuple of str
        Columns of the sensitive attributes and of the contexts.
    decision : str
        Column of the decision; with a utility column, that column.
    utility : mapping of str to str, or None
        What each listed decision is worth; others are worth 0 and counted together. None: the column says it itself.
    low, high : str
        The range of the utility, known in advance; low < high.
    step : str or None
        With a utility column: utilities are rounded to multiples of this, which is then what is audited.
    confidence : str
        With which each kind of statement holds at every moment.
    targets : mapping of str to str
        Limits, by the names `max_local_ratio`, `max_global_ratio`, `max_local_log`, `max_global_log`.
    expected : int
        About how many combinations of context and group will appear; shapes the budget, and any number is sound.
    unit : tuple of str
        Columns of the sampling unit: in each cell only its first decision counts.
    event_id : str or None
        Column whose repeats are dropped.
    time : str or None
        Column of the time of a decision.
    since : str or None
        Decisions before this time do not count.
    window : str or None
        Length of windows: a number of decisions, or of seconds with an ``s`` after it.
    layout : {"jsonl", "csv"}
        How the log is written.
    burden : bool
        Whether the utility counts a burden.
    run_length : int
        Pairs of decisions per direction until a detector of change raises a false alarm, in the mean, at least; 0 without a detector.
    bets : {"separate", "joint"}
        Whether bounds come from bets on single cells, multiplied, or on both cells of a pair at once.
    pair_by_time : bool
        Whether decisions that were made next to each other are compared too, pair by pair, so that means may move.

    Examples
    --------
    >>> settings = Settings(group=("sex",), decision="answer", utility={"yes": "1"})
    >>> settings.decisions
    (('yes', Fraction(1, 1)), ('(other)', Fraction(0, 1)))
    >>> Settings.from_text(settings.text) == settings
    True
    """

    group: tuple[str, ...]
    decision: str
    context: tuple[str, ...] = ()
    utility: Mapping[str, str] | None = None
    low: str = "0"
    high: str = "1"
    step: str | None = None
    confidence: str = "19/20"
    targets: Mapping[str, str] | None = None
    expected: int = 4
    unit: tuple[str, ...] = ()
    event_id: str | None = None
    time: str | None = None
    since: str | None = None
    window: str | None = None
    layout: str = "jsonl"
    burden: bool = False
    run_length: int = 0
    bets: str = "separate"
    pair_by_time: bool = False

    def __post_init__(self) -> None:
        """Refuse what cannot be audited, and write numbers in one way."""
        columns = [*self.group, *self.context, self.decision]
        for name in columns:
            if columns.count(name) > 1:
                raise InputError(f"the column {shown(name)} is used twice; each column has one role")
        if not self.group:
            raise InputError("no group column was named; name at least one")
        low, high = (_number(name, value) for name, value in (("low", self.low), ("high", self.high)))
        if not 0 <= low < high:
            raise InputError(f"a utility between {low} and {high} cannot be monitored; the range goes from at least 0 up to something more")
        if self.expected < 1 or self.expected > 10**6:
            raise InputError(f"{self.expected} expected cells are not accepted; a number from 1 to 1,000,000 is")
        if (self.since is not None or (self.window or "").endswith("s")) and self.time is None:
            raise InputError("--since and windows of time need the column of the time (--time COL)")
        if self.layout not in ("jsonl", "csv"):
            raise InputError(f"a log of the kind {shown(self.layout)} is not known; 'jsonl' and 'csv' are")
        written = {
            "utility": None if self.utility is None else _utilities(self.utility, low, high),
            "step": None if self.step is None else _step(self.step, high - low),
            "targets": _targets(self.targets or {}),
            "low": _text(low),
            "high": _text(high),
            "confidence": _text(confidence_level(self.confidence)),
        }
        for name, value in written.items():
            object.__setattr__(self, name, value)
        self._refuse_bets()
        if self.unit and self.context and "global" in self.named:
            raise InputError("a target for the global ratio cannot be judged with units in several contexts; leave out --unit or --context")

    def _refuse_bets(self) -> None:
        """Refuse a detector, or joint bets, that nothing could be asked of."""
        if self.run_length and not 100 <= self.run_length <= 10**12:
            raise InputError(f"a run length of {self.run_length} pairs is not accepted; one from 100 to 10^12 is, or 0 for no detector")
        if self.run_length and not self.named:
            raise InputError(
                "a detector of change (--run-length) asks whether a ratio is above a target; name one, such as --max-local-ratio 5/4"
            )
        if self.run_length and self.unit:
            raise InputError("a detector of change (--run-length) pairs decisions that do not hang together; leave out --unit, or give 0")
        if self.bets not in ("separate", "joint"):
            raise InputError(f"bets of the kind {shown(self.bets)} are not known; 'separate' and 'joint' are")
        if self.bets == "joint" and self.unit:
            raise InputError("joint bets (--bets joint) need decisions that do not hang together; leave out --unit, or bet separately")
        if self.pair_by_time:
            self._refuse_pairs()

    def _refuse_pairs(self) -> None:
        """Refuse to tally pairs that are not apart, or of too many values."""
        if self.unit:
            raise InputError("pairs in time (--pair-by-time) are of decisions that do not hang together; leave out --unit")
        low, high = self.limits
        if self.utility is None and (self.step is None or (high - low) / Fraction(self.step) > PAIR_STEPS):
            raise InputError(
                "pairs in time (--pair-by-time) are tallied by their utilities; round those with --utility-step, to at most "
                f"{PAIR_STEPS} steps"
            )
        if len({value for _, value in self.decisions}) > PAIR_STEPS + 1:
            raise InputError(f"pairs in time (--pair-by-time) are tallied by their utilities; list at most {PAIR_STEPS} different ones")

    @property
    def limits(self) -> tuple[Fraction, Fraction]:
        """The range of the utility."""
        return Fraction(self.low), Fraction(self.high)

    @property
    def decisions(self) -> tuple[tuple[str, Fraction], ...]:
        """The decisions that are known in advance, with their utilities."""
        if self.utility is None:
            return ()
        return (*((label, Fraction(value)) for label, value in self.utility.items()), (OTHER, Fraction(0)))

    @property
    def joint(self) -> bool:
        """Whether the cells are a martingale together; rows of one unit in several cells need not be."""
        return not self.unit

    @property
    def named(self) -> tuple[str, ...]:
        """The quantities with a target: "local", "global"."""
        return tuple(dict.fromkeys(quantity for name, (quantity, _) in LIMITS.items() if name in (self.targets or {})))

    @property
    def alpha(self) -> Fraction:
        """The error of each statement about the whole stream: quantities with targets share it."""
        return equal_share(1 - Fraction(self.confidence), len(self.named))

    @property
    def text(self) -> str:
        """All settings, as one line of JSON with sorted keys; what came later is named only where it is not as before."""
        before = {"burden": False, "run_length": 0, "bets": "separate", "pair_by_time": False}
        stated = {key: value for key, value in asdict(self).items() if key not in before or value != before[key]}
        return json.dumps(stated, sort_keys=True, separators=(",", ":"))

    @property
    def digest(self) -> str:
        """SHA-256 of the text."""
        return hashlib.sha256(self.text.encode()).hexdigest()

    @staticmethod
    def from_text(text: str) -> Settings:
        """Read what `text` wrote, also under the earlier names of limits: they were logarithms, and stay so."""
        members: dict[str, Any] = json.loads(text)
        members["targets"] = {EARLIER.get(name, name): limit for name, limit in members["targets"].items()}
        read: dict[str, Any] = {key: tuple(value) if isinstance(value, list) else value for key, value in members.items()}
        return Settings(**read)

    def differences(self, other: Settings) -> list[str]:
        """Name what another audit has different, with both values."""
        return [
            f"{field.name} is {shown(getattr(other, field.name))} there and {shown(getattr(self, field.name))} here"
            for field in fields(self)
            if getattr(self, field.name) != getattr(other, field.name)
        ]


def _number(name: str, value: Any) -> Fraction:
    try:
        return Fraction(*option_value(value))
    except InputError as error:
        raise InputError(f"{name}: {error}") from None


def _text(value: Fraction) -> str:
    return rational_text((value.numerator, value.denominator))


def _utilities(given: Mapping[str, str], low: Fraction, high: Fraction) -> dict[str, str]:
    values = {label: _number(f"the utility of {shown(label)}", value) for label, value in given.items()}
    if OTHER in values:
        raise InputError(f"the decision {OTHER!r} stands for those that are not listed; rename it")
    for label, value in values.items():
        if not low <= value <= high:
            raise InputError(f"the utility of {shown(label)} is {value}, outside the range from {low} to {high}")
    if low > 0:
        raise InputError("decisions that are not listed are worth 0, so the range of the utility begins at 0")
    return {label: _text(value) for label, value in values.items()}


def _step(given: str, width: Fraction) -> str:
    step = _number("step", given)
    if step <= 0 or width / step > 10_000:
        raise InputError(f"a step of {step} is not accepted; a range is divided into at most 10,000 steps")
    return _text(step)


def _targets(given: Mapping[str, Any]) -> dict[str, str]:
    refuse_bare(given)
    for name in given:
        if name not in LIMITS:
            raise InputError(f"{shown(name)} is no limit; {nearest(name, LIMITS)}")
    return {name: _text(read_limit(name, value)) for name, value in given.items()}
