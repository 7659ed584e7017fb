"""Rates of true and false positives by group, and how far apart they are: equal opportunity and equalized odds given the true label."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import cached_property
from itertools import groupby
from typing import Any, Literal

from fairaudit.errors import InputError, nearest, shown
from fairaudit.model.law import Law
from fairaudit.model.utility import UtilityTable
from fairaudit.tables.label_text import label_text
from fairaudit.words import brief

__all__ = ["NAMES", "Difference", "Positive", "Rate", "RatesGivenTruth", "given_truth", "positive_labels"]


Kind = Literal["true_positive_rate", "false_positive_rate"]

KINDS: tuple[Kind, Kind] = ("true_positive_rate", "false_positive_rate")

OVERALL = "_overall"

NAMES = {
    "true_positive_rate": "true positive rate",
    "false_positive_rate": "false positive rate",
    "equal_opportunity": "equal opportunity",
    "equalized_odds_true_label": "equalized odds given the true label",
}

NAMES |= {key + OVERALL: f"{name}, over all contexts" for key, name in NAMES.items()}

NO_DRAWS = {KINDS[0]: "no decisions with the positive true label", KINDS[1]: "no decisions with another true label"}


@dataclass(frozen=True)
class Positive:
    """What counts as positive.

    Attributes
    ----------
    decision : tuple of str
        The positive decisions.
    truth : str
        The positive true label.
    """

    decision: tuple[str, ...]
    truth: str


@brief
@dataclass(frozen=True, repr=False)
class Rate:
    """A rate of positive decisions among those with a positive (or another) true label.

    Attributes
    ----------
    context : int or None
        Index of the context; None over all contexts.
    group : int
        Index of the group.
    positives, draws : Fraction
        How many of the decisions were positive, and how many there were, more than 0.
    """

    context: int | None
    group: int
    positives: Fraction
    draws: Fraction

    @cached_property
    def value(self) -> Fraction:
        """The rate."""
        return self.positives / self.draws


@brief
@dataclass(frozen=True, repr=False)
class Difference:
    """The greatest difference of a rate between two groups, and who they are.

    Attributes
    ----------
    kind : {"true_positive_rate", "false_positive_rate"}
        Which rate it is.
    context : dict of str to str, or None
        The context in which it occurs; None over all contexts.
    higher, lower : dict of str to str
        The groups with the higher and the lower rate.
    rates : pair of Fraction
        Their rates.
    draws : pair of Fraction
        How many decisions these are rates of.
    """

    kind: Kind
    context: dict[str, str] | None
    higher: dict[str, str]
    lower: dict[str, str]
    rates: tuple[Fraction, Fraction]
    draws: tuple[Fraction, Fraction]

    @property
    def value(self) -> Fraction:
        """The difference, from 0 (alike) to 1."""
        return self.rates[0] - self.rates[1]


@brief
@dataclass(frozen=True, eq=False, repr=False)
class RatesGivenTruth:
    """What the decisions are given the true label.

    Attributes
    ----------
    law : Law
        Counts with true labels.
    positive : Positive
        What counts as positive.
    """

    law: Law
    positive: Positive

    @cached_property
    def rates(self) -> dict[str, tuple[Rate, ...]]:
        """Rates of each group in each context and, if there are context columns, over all of them; where there are no draws, none."""
        law, truth = self.law, self.law.truth
        if truth is None:
            raise AssertionError
        chosen = [law.decisions.index(label) for label in self.positive.decision]
        own = truth.labels.index(self.positive.truth)
        hits, draws = truth.weights[:, :, chosen].sum(axis=2), truth.weights.sum(axis=2)
        found: dict[str, tuple[Rate, ...]] = {}
        for kind in KINDS:
            parts = [array[:, own] if kind == KINDS[0] else array.sum(axis=1) - array[:, own] for array in (hits, draws)]
            places = zip(law.cell_context.tolist(), law.cell_group.tolist(), *(part.tolist() for part in parts), strict=True)
            listed = list(places)
            found[kind] = tuple(Rate(x, a, Fraction(k, law.scale), Fraction(n, law.scale)) for x, a, k, n in listed if n)
            if law.columns.context:
                sums: dict[int, list[int]] = {a: [0, 0] for a in sorted({a for _, a, _, _ in listed})}
                for _, a, k, n in listed:
                    sums[a][0] += k
                    sums[a][1] += n
                pooled = [(a, Fraction(k, law.scale), Fraction(n, law.scale)) for a, (k, n) in sums.items() if n]
                found[kind + OVERALL] = tuple(Rate(None, *each) for each in pooled)
        return found

    @cached_property
    def differences(self) -> dict[str, Difference | None]:
        """Equal opportunity and equalized odds, within contexts and, if there are context columns, over all of them.

        None where nothing is compared; the odds are None, too, where only one of the two rates is compared.
        """
        found: dict[str, Difference | None] = {}
        for suffix in ("", OVERALL) if self.law.columns.context else ("",):
            true, false = (self._greatest(kind, suffix) for kind in KINDS)
            found["equal_opportunity" + suffix] = true
            found["equalized_odds_true_label" + suffix] = max(true, false, key=lambda d: d.value) if true and false else None
        return found

    def _greatest(self, kind: Kind, suffix: str) -> Difference | None:
        best: tuple[Fraction, Rate, Rate] | None = None
        for block in blocks(self.rates[kind + suffix]):
            high, low = (extreme(block, key=lambda rate: rate.value) for extreme in (max, min))
            if best is None or high.value - low.value > best[0]:
                best = (high.value - low.value, high, low if high.value > low.value else block[1])
        if best is None:
            return None
        _, high, low = best
        context = None if high.context is None else self.law.context_label(high.context)
        names = self.law.group_label(high.group), self.law.group_label(low.group)
        return Difference(kind, context, *names, (high.value, low.value), (high.draws, low.draws))

    @cached_property
    def not_compared(self) -> tuple[dict[str, Any], ...]:
        """Where a rate does not exist, so that nobody is compared by it."""
        law = self.law
        held: dict[int, list[int]] = {}
        for x, a in zip(law.cell_context.tolist(), law.cell_group.tolist(), strict=True):
            held.setdefault(x, []).append(a)
        everybody = sorted({a for groups in held.values() for a in groups})
        found: list[dict[str, Any]] = []
        for name, rates in self.rates.items():
            overall = name.endswith(OVERALL)
            known: dict[int, set[int]] = {}
            for rate in rates:
                known.setdefault(-1 if rate.context is None else rate.context, set()).add(rate.group)
            for x, groups in [(-1, everybody)] if overall else held.items():
                place: dict[str, Any] = {"quantity": name} if overall else {"quantity": name, "context": law.context_label(x)}
                having = known.get(x, set())
                if lacking := [law.group_label(a) for a in groups if a not in having]:
                    found.append({**place, "groups": lacking, "reason": NO_DRAWS[KINDS[name.startswith(KINDS[1])]]})
                if len(having) < 2 <= len(groups):
                    found.append({**place, "reason": "fewer than two groups"})
        return tuple(found)


def blocks(rates: Sequence[Rate]) -> list[list[Rate]]:
    """Rates that are compared with each other: those of one context, where there are at least two."""
    return [block for _, part in groupby(rates, key=lambda rate: rate.context) if len(block := list(part)) > 1]


def given_truth(law: Law, utility: UtilityTable, positive: Any = None) -> RatesGivenTruth | None:
    """Set up what is measured given the true label; None where no true labels are known.

    Parameters
    ----------
    law : Law
        Counts, made with ``truth=``.
    utility : UtilityTable
        The utility on it; decisions that are worth more than nothing are the positive ones.
    positive : label, optional
        The positive true label, as in `positive_labels`.

    Returns
    -------
    RatesGivenTruth or None
        Rates and differences.

    Raises
    ------
    InputError
        If it is not clear what is positive, or missing true labels were made a level of their own.

    Examples
    --------
    >>> from fairaudit.model.utility import Utility
    >>> table = {"hired": ["yes", "no", "yes", "yes"], "fit": ["yes", "yes", "yes", "no"], "sex": ["f", "f", "m", "m"]}
    >>> law = Law.from_log(table, decision="hired", group="sex", truth="fit")
    >>> given_truth(law, Utility({"yes": 1}).on(law)).differences["equal_opportunity"].value
    Fraction(1, 2)
    """
    if law.truth is None:
        if positive is not None:
            raise InputError(f"the positive label {shown(positive)} was given without true labels; name their column with truth (--truth)")
        return None
    unknown = next((entry for entry in law.preparation if entry["step"] == "level" and entry["column"] == law.columns.truth), None)
    if unknown is not None:
        raise InputError(
            f"column {shown(law.columns.truth)}: {unknown['decisions']} decisions have no true label, and as a level of their own they "
            "would count as ones that should not have been positive; missing=drop (--missing drop) leaves them out"
        )
    return RatesGivenTruth(law, positive_labels(law, utility, positive))


def positive_labels(law: Law, utility: UtilityTable, positive: Any = None) -> Positive:
    """Say which decisions and which true label are positive.

    The positive decisions are those that are worth more than nothing, if all of these are worth the same. The positive true label is
    the one that is a positive decision, too; where that does not name exactly one, and where the utility does not say which decisions
    are positive, `positive` does.

    Raises
    ------
    InputError
        If it is not clear what is positive.
    """
    truths = () if law.truth is None else law.truth.labels
    name = shown(law.columns.truth)
    wanted = None if positive is None else label_text(positive)
    if positive is not None and wanted not in truths:
        raise InputError(f"the positive label {shown(positive)} is no true label of column {name}; {nearest(str(wanted), truths)}")
    worth = utility.values.tolist() if utility.by_decision else []
    if len({value for value in worth if value > 0}) == 1:
        chosen = tuple(label for label, value in zip(law.decisions, worth, strict=True) if value > 0)
    elif wanted is not None and wanted in law.decisions:
        chosen = (wanted,)
    else:
        raise InputError(
            "the utility does not say which decisions are positive, being neither 0 nor one same value for each of them; give positive "
            f"(--positive), a label that is both a decision and a true label of column {name}"
        )
    if wanted is None:
        common = [label for label in chosen if label in truths]
        if len(common) != 1:
            decisions = ", ".join(map(shown, chosen))
            said = "several true labels are" if common else "no true label is"
            raise InputError(
                f"column {name}: {said} a positive decision ({decisions}); give the positive one (positive, --positive); "
                f"{nearest(chosen[0], truths)}"
            )
        wanted = common[0]
    return Positive(chosen, wanted)
