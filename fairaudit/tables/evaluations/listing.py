"""What is in a log of samples: every path to a value, its most common labels, and what became of the samples."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

from fairaudit.errors import InputError
from fairaudit.tables.evaluations.columns import SAID, file_names
from fairaudit.tables.evaluations.paths import LAST, Step, read_path, written_path
from fairaudit.tables.evaluations.samples import Format, Run
from fairaudit.tables.label_text import label_text

__all__ = ["MOST", "Leaf", "Listing", "listing", "nested"]

MOST = 10_000  # different labels of a path that are held
PATHS = 400  # paths that are held
DEEPEST = 8
LONGEST = 200  # characters of a label that are held
SHORT = 20  # paths that are all shown, and labels that are few
LOOKED_AT = 100  # rows that say whether there are objects and lists

HEAVY = frozenset(("messages", "input", "target", "choices", "arguments", "resps"))
"""Keys at the top of samples of known formats that hold prompts and answers at length."""


@dataclass
class Leaf:
    """What is at a path."""

    levels: Counter[str] = field(default_factory=Counter)
    seen: int = 0
    different: set[int] = field(default_factory=set)
    unread: Counter[str] = field(default_factory=Counter)
    fault: str = ""

    @property
    def never_read(self) -> frozenset[str]:
        """What is there only in samples that have no answer, or one that decides nothing."""
        return frozenset(label for label, count in self.unread.items() if count == self.levels[label])

    def add(self, value: Any, *, read: bool = True) -> None:
        """Count a value."""
        try:
            text = label_text(value)
        except InputError as error:
            self.fault = self.fault or str(error)
            return
        if text is None:
            return
        self.seen += 1
        label = text if len(text) <= LONGEST else text[: LONGEST - 1] + "…"
        if label in self.levels or len(self.levels) < MOST:
            self.levels[label] += 1
            if not read:
                self.unread[label] += 1
        if len(self.different) <= MOST:  # one more says that there are more
            self.different.add(hash(text))


@dataclass(frozen=True)
class Listing:
    """What is in logs.

    Attributes
    ----------
    samples : int
        How many there are.
    leaves : dict of str to Leaf
        What is at each path.
    outcomes : Counter
        How many samples were read, refused, truncated, or ended in an error.
    runs : tuple of Run
        What the files say of themselves.
    left_out : int
        How many further paths there are.
    """

    samples: int
    leaves: dict[str, Leaf]
    outcomes: Counter[str]
    runs: tuple[Run, ...]
    left_out: int

    def answer(self, log: Format) -> str | None:
        """The path where the decision usually is."""
        inside = [rf"{_expression(pattern)}[.\[].*" for pattern in log.answers if not pattern.startswith("argmax(")]
        for expression in (*map(_expression, log.answers), *inside):
            fits = re.compile(expression)
            found = next((path for path, leaf in self.leaves.items() if fits.fullmatch(path) and leaf.levels and not leaf.fault), None)
            if found is not None:
                return found
        return None

    def technical(self, log: Format) -> frozenset[str]:
        """Paths that are hardly a decision, group, context or unit, where there are many; of no known format, those of many labels."""
        if len(self.leaves) <= SHORT:
            return frozenset()
        fits = re.compile("|".join(rf"{_expression(part)}(?:[.\[].*)?" for part in ("file", *log.parts)), re.DOTALL)
        return frozenset(
            path
            for path, leaf in self.leaves.items()
            if not leaf.levels or not (fits.fullmatch(path) if log.name else len(leaf.different) <= SHORT or path.isidentifier())
        )


def _expression(pattern: str) -> str:
    """The regular expression of a path with ``*`` for any one name."""
    return re.escape(pattern).replace(r"\.\*\.", r"\.(?:[^.\[]+|\"[^\"]*\")\.")


def listing(paths: Sequence[str], log: Format, report: Callable[[float | None, int | None], None] | None = None) -> Listing:
    """Look at every path of every sample.

    Parameters
    ----------
    paths : sequence of str
        The files.
    log : Format
        How they are read.
    report : callable, optional
        Told how many samples were read.

    Raises
    ------
    InputError
        If one cannot be read, or there are no samples.
    """
    leaves: dict[str, Leaf] = {}
    outcomes: Counter[str] = Counter()
    runs: list[Run] = []
    more: set[str] = set()
    named = file_names(paths)
    greatest = [path for path in map(read_path, log.answers) if path.argmax]
    for path in paths:
        run = log.run(path)
        runs.append(run)
        said = dict(zip(SAID, (named[path] if len(paths) > 1 else "", run.model, run.task), strict=True))
        for sample in log.samples(path, ()):
            outcomes[sample.outcome] += 1
            if report is not None and not outcomes.total() % 1000:
                report(None, outcomes.total())
            found = dict(_values(sample.row, (), HEAVY if log.name else frozenset()))
            for place in greatest:
                try:
                    found[place.text] = place.of(sample.row)
                except InputError as error:
                    leaves.setdefault(place.text, Leaf()).fault = str(error)
            for name, text in said.items() if log.name else ():
                if text:
                    found.setdefault(name, text)
            for name, value in found.items():
                if name not in leaves and len(leaves) >= PATHS:
                    more.add(name)
                else:
                    leaves.setdefault(name, Leaf()).add(value, read=sample.outcome == "read")
    if not outcomes:
        raise InputError(f"{', '.join(paths[:3])}: the log has no samples")
    leaves = {name: leaf for name, leaf in leaves.items() if leaf.levels or not name.startswith("argmax(")}
    return Listing(outcomes.total(), leaves, outcomes, tuple(runs), len(more))


def nested(rows: Iterator[Mapping[str, Any]]) -> bool:
    """Whether some of the first rows hold objects or lists."""
    return any(isinstance(value, (dict, list)) for _, row in zip(range(LOOKED_AT), rows, strict=False) for value in row.values())


def _values(value: Any, steps: tuple[Step, ...], heavy: frozenset[str]) -> Iterator[tuple[str, Any]]:
    """Paths to the values in a value; of a list the first element and the last."""
    if isinstance(value, Mapping) and len(steps) < DEEPEST:
        for name, held in value.items():
            if steps or name not in heavy:
                yield from _values(held, (*steps, str(name)), heavy)
    elif isinstance(value, list) and len(steps) < DEEPEST:
        if value:
            yield from _values(value[0], (*steps, 0), heavy)
            if len(value) > 1:
                yield from _values(value[-1], (*steps, LAST), heavy)
    elif steps:
        yield written_path(steps), value if not isinstance(value, (Mapping, list)) else None
