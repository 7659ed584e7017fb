"""Are sampling units copies of each other? A test over the whole log with a stated rate of false alarms.

A unit has answered questions (a context and a group), some of them several times. Its answer to a question is what it said there in all,
in whatever order: the rows of a unit in a cell may depend on each other in any way, as they do where the same items are behind them.
Hypothesis: the log-odds of an answer are the sum of a part that belongs to the question (and how often it was asked) and one that belongs
to the unit, and given these the answers to different questions are independent. Where a unit saw several groups in one context it has a
part of its own for each context, so that a quota (one winner for each run and job) is no coincidence. Given how often each question got
each answer, and how often each unit gave it (in each context), all arrangements of the answers are then equally likely, whatever the parts.

The statistic is the number of pairs of units that gave the same answers, as often, to the same questions. A reversible chain with those
arrangements as its uniform law is run from the observed one, so many steps in one direction and the others in the opposite one, with a
random place for the observed arrangement among the `STEPS` + 1: by exchangeability of that place the observed statistic is the only
greatest one with probability at most 1/(STEPS + 1) (Besag and Clifford, Biometrika 76, 1989). The chain need not mix for that.

A step matches units at random in pairs. Where the two of a pair answered a question differently, their answers may be exchanged; which
exchanges are made is drawn uniformly from all that leave both with as many answers of each kind.

If all units answered each question alike, only one arrangement is possible, and nothing can be said: that is what a model does whose answer
to a question never varies, of which even independent draws are alike.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from hashlib import sha256

import numpy as np
from numpy.typing import NDArray

from fairaudit.errors import shown

__all__ = ["copies_note"]


STEPS = 999  # 1 in 1,000 logs of independent units is suspected

ROWS = 8_000  # what is judged in about a second

LISTED = 5  # columns that a sentence names


Codes = NDArray[np.int64]


def copies_note(
    columns: Sequence[str],
    units: tuple[Codes, Sequence[tuple[str, ...]]],
    context: Codes,
    group: Codes,
    decision: Codes,
    counts: Codes,
) -> str:
    """Say, if it is so, that more units of a log answered alike than their answers explain.

    Logs of more than `ROWS` rows are judged by some of their units, evenly spread over the order of their labels.

    Parameters
    ----------
    columns : sequence of str
        The columns that name the units.
    units : tuple of (ndarray of int64, sequence of label tuples)
        The unit of each row as a code, and what the codes stand for.
    context, group, decision : ndarray of int64
        Context, group and decision of each row, as codes in an order that does not depend on the order of the rows.
    counts : ndarray of int64
        How many rows of the log each row stands for.

    Returns
    -------
    str
        A sentence, in at most one of STEPS + 1 logs whose units are independent; else an empty text.

    Examples
    --------
    >>> pick = np.random.default_rng(1)
    >>> asked, unit = np.tile(np.arange(12), 6), np.repeat(np.arange(6), 12)
    >>> answers = np.concatenate([*[pick.integers(0, 2, 12)] * 3, pick.integers(0, 2, 36)])
    >>> labels = [(str(i),) for i in range(6)]
    >>> print(copies_note(["run"], (unit, labels), asked, asked * 0, answers, answers * 0 + 1)[:69])
    pseudo-replication: 3 pairs of units of 'run', such as '0', '1', '2',
    """
    chosen = _chosen(units, context, group, counts)
    if len(chosen) < 2:
        return ""
    rank = np.full(len(units[1]), -1, dtype=np.int64)
    rank[chosen] = np.arange(len(chosen))
    unit = rank[units[0]]
    kept = unit >= 0
    rows = np.repeat(np.column_stack([codes[kept] for codes in (unit, context, group, decision)]), counts[kept], axis=0)
    rows = rows[np.lexsort(rows.T[::-1])]
    found = _Arrangement.of(rows)
    alike = found.alike(found.answers)
    pairs = _pairs(alike)
    if not pairs or not _exceptional(found, pairs, rows):
        return ""
    values, first, times = np.unique(alike, return_index=True, return_counts=True)
    most = values[np.lexsort((first, -times))[0]]
    named = [", ".join(units[1][chosen[i]]) for i in np.flatnonzero(alike == most).tolist()]
    listed = ", ".join(map(shown, named[:LISTED])) + (", …" if len(named) > LISTED else "")
    of = ", ".join(map(shown, columns))
    several = f"{pairs} pairs of units of {of}, such as {listed}, " if pairs > 1 else f"the units {listed} of {of} "
    return (
        f"pseudo-replication: {several}gave the same decisions on everything that they were asked, more than in any of {STEPS} "
        f"rearrangements of the answers that leave each question and each unit its own; copies of one draw are one draw, not several "
        f"(a false alarm in at most 1 of {STEPS + 1:,} logs)"
    )


def _chosen(units: tuple[Codes, Sequence[tuple[str, ...]]], context: Codes, group: Codes, counts: Codes) -> list[int]:
    """The units with at least two questions, in the order of their labels; evenly thinned out where they have too many rows."""
    codes, labels = units
    question = context * (int(group.max()) + 1) + group
    one = np.empty(len(labels), dtype=np.int64)
    one[codes] = question
    able = np.flatnonzero(np.bincount(codes[question != one[codes]], minlength=len(labels))).tolist()
    able.sort(key=labels.__getitem__)
    size = np.bincount(codes, weights=counts, minlength=len(labels))
    total = float(size[able].sum())
    step = max(1.0, total / ROWS)
    thinned = [able[int(place)] for place in np.arange(0, len(able), step)] if step > 1 else able
    return thinned if float(size[thinned].sum()) <= 2 * ROWS else []


@dataclass(frozen=True)
class _Arrangement:
    """Answers of units: for each its unit, its question, the question with the times it was asked, its stratum, and the answer itself."""

    unit: Codes
    question: Codes
    column: Codes
    stratum: Codes
    by_context: NDArray[np.bool_]
    answers: Codes
    starts: Codes

    @staticmethod
    def of(rows: Codes) -> _Arrangement:
        """From rows (unit, context, group, decision), sorted, each unit having at least one."""
        unit, context, group, decision = rows.T
        _, context = np.unique(context, return_inverse=True)
        _, question = np.unique(context * (int(group.max()) + 1) + group, return_inverse=True)
        first = np.flatnonzero((np.diff(unit, prepend=-1) != 0) | (np.diff(question, prepend=-1) != 0))
        sizes = np.diff(first, append=len(rows))
        _, answers = np.unique(np.add.reduceat(_mixed(decision), first), return_inverse=True)
        unit, context, question = unit[first], context[first], question[first]
        starts = np.flatnonzero(np.diff(unit, prepend=-1))
        # A unit that saw several groups in one context may have a quota there.
        several, times = np.unique(unit * (int(context.max()) + 1) + context, return_counts=True)
        by_context = np.zeros(len(starts), dtype=np.bool_)
        by_context[several[times > 1] // (int(context.max()) + 1)] = True
        column = question * (int(sizes.max()) + 1) + sizes
        return _Arrangement(unit, question, column, context, by_context, answers, starts)

    def alike(self, answers: Codes) -> NDArray[np.uint64]:
        """A number for each unit, the same for those with the same answers to the same questions, whatever their order."""
        found: NDArray[np.uint64] = np.add.reduceat(_mixed(self.question * (int(self.answers.max()) + 1) + answers), self.starts)
        return found

    def step(self, answers: Codes, pick: np.random.Generator) -> Codes:
        """One step of the chain."""
        pair = pick.permutation(len(self.starts)) // 2
        key = pair[self.unit] * (int(self.column.max()) + 1) + self.column
        order = np.argsort(key, kind="stable")
        met = key[order][1:] == key[order][:-1]
        one, other = order[:-1][met], order[1:][met]
        differ = answers[one] != answers[other]
        one, other = one[differ], other[differ]
        low, high = np.minimum(answers[one], answers[other]), np.maximum(answers[one], answers[other])
        turned = answers[one] > answers[other]
        split = self.by_context[self.unit[one]] | self.by_context[self.unit[other]]
        stratum = np.where(split, self.stratum[one] + 1, 0)
        width = int(self.answers.max()) + 1
        kind = ((pair[self.unit[one]] * (int(self.stratum.max()) + 2) + stratum) * width + low) * width + high
        mixed = np.empty_like(turned)
        mixed[np.lexsort((pick.random(len(kind)), kind))] = turned[np.argsort(kind, kind="stable")]
        made = answers.copy()
        made[one], made[other] = np.where(mixed, high, low), np.where(mixed, low, high)
        return made


def _mixed(codes: Codes) -> NDArray[np.uint64]:
    """Scrambled codes, whose sums tell sets of them apart."""
    mixed = codes.astype(np.uint64) + np.uint64(1)
    for factor in (0x9E3779B97F4A7C15, 0xBF58476D1CE4E5B9, 0x94D049BB133111EB):
        mixed = mixed * np.uint64(factor)
        mixed ^= mixed >> np.uint64(29)
    return mixed


def _pairs(alike: NDArray[np.uint64]) -> int:
    _, times = np.unique(alike, return_counts=True)
    return int((times * (times - 1) // 2).sum())


def _exceptional(found: _Arrangement, pairs: int, rows: Codes) -> bool:
    """Whether the observed arrangement alone has so many pairs among all of the chain."""
    seed = sha256(np.ascontiguousarray(rows, dtype="<i8").tobytes()).digest()
    pick = np.random.Generator(np.random.PCG64(int.from_bytes(seed, "big")))
    before = int(pick.integers(STEPS + 1))
    for steps in (before, STEPS - before):
        answers = found.answers
        for _ in range(steps):
            answers = found.step(answers, pick)
            if _pairs(found.alike(answers)) >= pairs:
                return False
    return True
