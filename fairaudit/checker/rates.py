"""Rates given the true label, and their greatest differences."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from fractions import Fraction
from typing import NamedTuple

from .figures import Maximum
from .header import Columns, Header, Positive
from .rationals import as_pair, at_most, bits_of, fraction_sum, reduced
from .text import malformed, shown
from .work import keep, spend

TRUE_POSITIVES, FALSE_POSITIVES = KINDS = ("true_positive_rate", "false_positive_rate")
OVERALL = "_overall"  # ends the name of what is pooled over contexts, where there are context columns
LACKING = {TRUE_POSITIVES: "no decisions with the positive true label", FALSE_POSITIVES: "no decisions with another true label"}

DIFFERENCES = {  # the rates that each difference is about
    "equal_opportunity": (TRUE_POSITIVES,),
    "equalized_odds_true_label": KINDS,
    f"equal_opportunity{OVERALL}": (TRUE_POSITIVES + OVERALL,),
    f"equalized_odds_true_label{OVERALL}": (TRUE_POSITIVES + OVERALL, FALSE_POSITIVES + OVERALL),
}


def stated_given_truth(columns: Columns) -> tuple[list[str], list[str]]:
    """The names of the rates and of the differences that a certificate states."""
    if columns.truth is None:
        return [], []
    suffixes = ("", OVERALL) if columns.context else ("",)
    names = [name for name in DIFFERENCES if columns.context or not name.endswith(OVERALL)]
    return [kind + suffix for kind in KINDS for suffix in suffixes], names


class Share(NamedTuple):
    """Of ``draws`` decisions in a cell, or of a group over all contexts (-1), with the wanted true label, ``positives`` are positive."""

    context: int
    group: int
    positives: Fraction
    draws: Fraction
    rate: Fraction | None  # none where there are no draws


def _rated(context: int, group: int, positives: Fraction, draws: Fraction) -> Share:
    bits = bits_of(positives, draws)
    spend(12, bits, bits)  # the quotient, and comparisons with others
    keep(12, bits)
    return Share(context, group, positives, draws, positives / draws if draws else None)


class GivenTruth:
    """The numbers of decisions by true label, while the rows of a table pass by."""

    def __init__(self, header: Header, positive: Positive) -> None:
        self.header = header
        for label in positive.decision:
            if label not in header.decisions:
                raise malformed("subject.positive.decision", f"names {shown(label)}, which is no decision of the table")
        if positive.truth not in (truths := header.truths or ()):
            raise malformed("subject.positive.truth", f"is {shown(positive.truth)}, which is no true label of the table")
        self.decisions = [header.decisions.index(label) for label in positive.decision]
        if self.decisions != sorted(self.decisions):
            raise malformed("subject.positive.decision", "is not in the order of the decisions of the table")
        self.truth = truths.index(positive.truth)
        self.cells: list[tuple[Share, Share]] = []
        self.pooled: dict[str, list[Share]] = {}

    def add(self, place: tuple[int, int], counts: tuple[list[list[int]], int]) -> None:
        """Take in the next cell."""
        rows, below = counts
        spend(len(rows) * len(rows[0]), below.bit_length(), below.bit_length())
        sums = []
        for wanted in (True, False):
            own = [row for t, row in enumerate(rows) if (t == self.truth) is wanted]
            numbers = (sum(row[u] for row in own for u in self.decisions), sum(map(sum, own)))
            sums.append(_rated(*place, *(Fraction(*reduced(number, below)) for number in numbers)))
        self.cells.append((sums[0], sums[1]))

    def _shares(self, name: str) -> list[Share]:
        """All of them, in order, also those without draws."""
        position = KINDS.index(name.removesuffix(OVERALL))
        own = [shares[position] for shares in self.cells]
        if not name.endswith(OVERALL):
            return own
        if name not in self.pooled:
            totals: dict[int, list[tuple[Fraction, Fraction]]] = {}
            for share in own:
                totals.setdefault(share.group, []).append((share.positives, share.draws))
            self.pooled[name] = [_rated(-1, a, *map(fraction_sum, zip(*totals[a], strict=True))) for a in sorted(totals)]
        return self.pooled[name]

    def blocks(self, name: str) -> list[list[Share]]:
        """The rates of one name that are compared with each other."""
        lists: dict[int, list[Share]] = {}
        for share in self._shares(name):
            if share.rate is not None:
                lists.setdefault(share.context, []).append(share)
        return [block for block in lists.values() if len(block) > 1]

    def rates(self) -> dict[str, list[dict[str, object]]]:
        """All rates that exist, as a certificate lists them."""
        names, _ = stated_given_truth(self.header.subject.columns)
        return {
            name: [self._named(share) | {"rate": as_pair(share.rate)} for share in self._shares(name) if share.rate is not None]
            for name in names
        }

    def _named(self, share: Share) -> dict[str, object]:
        columns = self.header.subject.columns
        names: dict[str, object] = {}
        if share.context >= 0:
            names["context"] = dict(zip(columns.context, self.header.contexts[share.context], strict=True))
        return names | {"group": dict(zip(columns.group, self.header.groups[share.group], strict=True))}

    def differences(self) -> dict[str, Maximum | None]:
        """The greatest differences, each null when one of its rates compares nobody."""
        _, names = stated_given_truth(self.header.subject.columns)
        return {name: self._greatest([self._widest(rate) for rate in DIFFERENCES[name]]) for name in names}

    @staticmethod
    def _greatest(found: Sequence[Maximum | None]) -> Maximum | None:
        best = found[0]
        for other in found:
            if best is None or other is None:
                return None
            if not at_most(other.value, best.value):
                best = other
        return best

    def _widest(self, name: str) -> Maximum | None:
        best: tuple[Fraction, Share, Share] | None = None
        for block in self.blocks(name):
            values = [share.rate for share in block if share.rate is not None]
            gap = max(values) - min(values)
            if best is None or gap > best[0]:
                lower = values.index(min(values)) if gap else 1
                best = gap, block[values.index(max(values))], block[lower]
        if best is None:
            return None
        gap, high, low = best
        upper, under = self._named(high), self._named(low)
        witness = {key: upper[key] for key in upper if key == "context"}
        witness |= {"rate": name.removesuffix(OVERALL), "higher": upper["group"], "lower": under["group"]}
        witness["rates"] = [as_pair(share.rate) for share in (high, low) if share.rate is not None]
        return Maximum(as_pair(gap), witness, (high.context if high.context >= 0 else None, high.group, low.group))

    def not_compared(self) -> Iterator[dict[str, object]]:
        """List where a rate does not exist, so that nobody is compared by it."""
        header = self.header
        names, _ = stated_given_truth(header.subject.columns)
        for name in names:
            lists: dict[int, list[Share]] = {}
            for share in self._shares(name):
                lists.setdefault(share.context, []).append(share)
            for x, shares in lists.items():
                place: dict[str, object] = {"quantity": name} | ({"context": list(header.contexts[x])} if x >= 0 else {})
                lacking = [list(header.groups[share.group]) for share in shares if not share.draws]
                if lacking:
                    yield place | {"groups": lacking, "reason": LACKING[name.removesuffix(OVERALL)]}
                if len(shares) - len(lacking) < 2 <= len(shares):
                    yield place | {"reason": "fewer than two groups"}
