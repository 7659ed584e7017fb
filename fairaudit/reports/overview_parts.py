"""What an overview shows of a table: the means of groups with their intervals, the most unequal contexts, what was left out, in numbers."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from decimal import ROUND_CEILING, ROUND_FLOOR, ROUND_HALF_EVEN, Context, Decimal, localcontext
from fractions import Fraction
from typing import TYPE_CHECKING, Any, Literal, get_args

import numpy as np

from fairaudit.audits.sentences import Deciding, Size, Sizes
from fairaudit.audits.targets import Target
from fairaudit.certificates.reader import Subject
from fairaudit.errors import InputError
from fairaudit.exact.extended import Extended
from fairaudit.exact.rationals import shortened
from fairaudit.inference.comparisons import Comparison
from fairaudit.inference.ends import Method, form_ends
from fairaudit.measures.differences import MeanDifference, furthest_contexts, outermost_means
from fairaudit.measures.limits import Quantity
from fairaudit.measures.ratios import Ratio, Witness, most_unequal_contexts
from fairaudit.model.law import Law
from fairaudit.model.layout import Columns
from fairaudit.model.utility import UtilityTable
from fairaudit.reports.words import Value, clip, named, quotient
from fairaudit.tables.preparation import Entry, is_uncounted, said
from fairaudit.words import approximate, noun, percent, plain

if TYPE_CHECKING:
    from fairaudit.reports.lost_answers import LostAnswers

__all__ = ["Compared", "Gets", "GroupLine", "Known", "Parts", "Seen", "amount_name", "counted_decisions", "how_many", "rate_text"]


FEW_LABELS = 3  # decisions that count, of which a sentence names each

MOST_COUNTED = 10**15

MOST_DIGITS = 12  # of a rate that is nearly 100 %, which is then rounded down

ROUNDINGS = {"nearest": ROUND_HALF_EVEN, "down": ROUND_FLOOR, "up": ROUND_CEILING}

SHOW_OTHERS = 3  # decisions that do not count, which are named

LEFT_OUT = 6  # entries of what was left out, in lines


@dataclass(frozen=True)
class Known:
    """What the draws say of a ratio or a difference of the population: its interval."""

    lower: Fraction
    upper: Extended
    confidence: Fraction
    each: bool
    method: str
    over_units: Ratio | MeanDifference | None = None


@dataclass(frozen=True, eq=False)
class Seen:
    """What is known of a table besides the table: what an audit found, or what a certificate says."""

    columns: Columns
    kind: Literal["counts", "probabilities", "policy"]
    drawn: bool  # whether decisions were recorded, of a policy behind filters, too
    contexts: int
    verdict: str
    targets: Sequence[Target]
    deciding: Sequence[Deciding | None]
    ratios: Mapping[Quantity, Ratio | None]
    differences: Mapping[Quantity, MeanDifference | None]
    of_ratios: Mapping[Quantity, Known]
    of_differences: Mapping[Quantity, Known]
    comparisons: Callable[[], Mapping[Any, Comparison]]
    sizes: Callable[[Sequence[Witness]], Sequence[Sizes | None]]
    burden: bool
    not_compared: Sequence[Mapping[str, Any]]
    preparation: Sequence[Entry]
    assumptions: Sequence[str]
    beside: tuple[str, ...] = ()
    further: str = ""
    changed: str = ""
    warned: Sequence[str] = ()  # of how the table was read
    spelt: Sequence[dict[str, Any]] = ()
    lost: LostAnswers | None = None
    meant: Mapping[str, Extended] | None = None  # the least ratios of the table, whatever its undecided decisions meant
    undecided: Sequence[str] = ()  # decisions
    labels: Sequence[Any] | None = None  # of the contexts, where the table has them all together
    worst: Sequence[Ratio] | None = None


@dataclass(frozen=True)
class Gets:
    """What a group gets on average.

    Attributes
    ----------
    group : dict of str to str
        Its labels.
    mean : Value
        The mean of its utility.
    size : Size or None
        How many decisions, and units where one has several, were recorded; None where that is not known.
    counted : Fraction or None
        How many of these decisions count, where each that does is worth 1 and all others nothing.
    rate : bool
        Whether the mean is the rate of the decisions that count.
    """

    group: Mapping[str, str]
    mean: Value
    size: Size | None = None
    counted: Fraction | None = None
    rate: bool = False

    @property
    def label(self) -> str:
        """Its labels with their columns, escaped."""
        return named(self.group)

    @property
    def short(self) -> str:
        """Its labels alone, escaped."""
        return clip(" / ".join(self.group.values()))

    @property
    def amount(self) -> str:
        """The mean as a percentage, or as a number."""
        return rate_text(self.mean) if self.rate else self.mean.decimal

    @property
    def of(self) -> str:
        """Of how many decisions it is, and how many of them count."""
        if self.size is None:
            return ""
        if self.counted is not None and self.size.units is None:
            return f"{how_many(self.counted)} of {how_many(self.size.decisions)}"
        return f"n = {how_many(self.size.decisions)}" if self.size.units is None else f"{self.size.units:,} {noun(self.size.units, 'unit')}"


@dataclass(frozen=True)
class GroupLine:
    """A group in the table of groups.

    Attributes
    ----------
    gets : Gets
        What it gets.
    ends : pair of Value or None
        Between which ends that is in the population, each group by itself.
    least, greatest : Value
        The ratio to the best group in both readings: the smaller of the two means over the greater one, and the other way round. Of
        utilities that can be negative both are how far it is from the best group.
    """

    gets: Gets
    ends: tuple[Value, Value] | None
    least: Value
    greatest: Value

    @property
    def between(self) -> str:
        """The interval; empty without one."""
        if self.ends is None:
            return ""
        low, high = (rate_text(end, unit="") if self.gets.rate else end.decimal for end in self.ends)
        return f"{low} to {high}{' %' if self.gets.rate else ''}"


@dataclass(frozen=True)
class Compared:
    """Two groups of a context, or over all contexts, and their ratio, or how far apart they are."""

    context: Mapping[str, str] | None
    higher: Gets
    lower: Gets
    apart: Value

    @property
    def where(self) -> str:
        """The labels of the context alone, escaped."""
        return clip(" / ".join((self.context or {}).values()))


def rate_text(value: Value, unit: str = " %") -> str:
    """A rate in percent, in three digits, which say 0 and 100 of these alone; ends of intervals are rounded outwards.

    Examples
    --------
    >>> rate_text(Value(Fraction(1198, 2691))), rate_text(Value(Fraction(9999, 10000))), rate_text(Value(Fraction(1, 3), "up"))
    ('44.5 %', '99.99 %', '33.4 %')
    """
    share = 100 * shortened(Fraction(value.value))
    if share in (0, 100):
        return f"{share}{unit}"
    digits, rounded = 3, Decimal(100)
    while rounded == 100 and digits <= MOST_DIGITS:
        towards = ROUNDINGS["down" if digits == MOST_DIGITS and value.rounding == "nearest" else value.rounding]
        with localcontext(Context(prec=digits, rounding=towards)) as context:
            rounded = context.divide(Decimal(share.numerator), Decimal(share.denominator))
        if value.rounding == "up":
            break
        digits += 1
    digits -= value.rounding != "up"
    exponent = rounded.adjusted()
    plain_ = f"{rounded:.{max(0, digits - 1 - exponent)}f}" if exponent > -4 else f"{rounded:.{digits - 1}e}"
    return f"{plain_}{unit}"


def counted_decisions(utility: UtilityTable) -> list[int]:
    """Which decisions count, where each is worth 1 and all others nothing; empty where the utility is another one."""
    if not utility.by_decision:
        return []
    values = utility.values.tolist()
    return [i for i, v in enumerate(values) if v] if all(v in (0, utility.scale) for v in values) else []


def amount_name(law: Law, counted: Sequence[int], *, burden: bool) -> str:
    """What is compared, as the beginning of a sentence.

    Labels that say little by themselves are named with their column.
    """
    if not counted:
        return "Expected burden" if burden else "Expected utility"
    column, labels = clip(law.columns.decision, 30), [law.decisions[i] for i in counted]
    if len(labels) > FEW_LABELS:
        return f"{column}: one of {len(labels)} labels"
    listed = " or ".join(clip(label, 30) for label in labels)
    clear = all(len(label) > 3 and label.casefold() not in ("true", "false") and not label[0].isdigit() for label in labels)
    return listed if clear else f"{column}={listed}"


@dataclass(frozen=True, eq=False)
class Parts:
    """The parts of an overview that are computed from a table."""

    subject: Subject
    seen: Seen

    @property
    def signed(self) -> bool:
        """Whether utilities can be negative."""
        return self.subject.utility.signed

    def gets(self, group: Mapping[str, str], mean: Fraction, size: Size | None, *, rates: bool) -> Gets:
        """What a group gets; the decisions that count are named where there are so many."""
        counted = mean * size.decisions if rates and size is not None and size.units is None else None
        if counted is not None and (counted * self.subject.law.scale).denominator != 1:
            counted = None  # a mean over units, or a sum of weights
        return Gets(group, Value(mean), size, counted, rates)

    def pair(self, witness: Witness, apart: Extended, size: Sizes | None, *, rates: bool) -> Compared:
        """Two groups and what they get."""
        one, other = (None, None) if size is None else size
        high, low = witness.expectations
        higher, lower = self.gets(witness.higher, high, one, rates=rates), self.gets(witness.lower, low, other, rates=rates)
        return Compared(witness.context, higher, lower, Value(apart))

    def groups(self, *, rates: bool, most: int) -> tuple[tuple[GroupLine, ...], int, str]:
        """What groups get over all contexts, the worst first and the best last, how many are not listed, and how sure intervals are."""
        listed = group_means(self.subject, most, burden=self.seen.burden)
        if not listed:
            return (), 0, ""
        law, over_units = self.subject.law, self._over_units()
        number = len(law.global_groups) if listed[0][2] is None else len(listed)
        if over_units:
            listed = [(a, over_units.get(law.groups[a], mean), weight) for a, mean, weight in listed]
        ordered = sorted(listed, key=lambda entry: -entry[1] if self.seen.burden else entry[1])
        best = ordered[-1][1]
        kept = ordered if number <= most else [*ordered[: most - 1], ordered[-1]]
        ends, sure = self._ends()
        lines = []
        for a, mean, weight in kept:
            size = None if weight is None else Size(weight, self._units(a))
            found = ends(law.groups[a])
            between = None if found is None else (Value(found[0], "down"), Value(found[1], "up"))
            low, high = sorted((mean, best))
            least, greatest = (high - low, high - low) if self.signed else (quotient(low, high), quotient(high, low))
            gets = self.gets(law.group_label(a), mean, size, rates=rates)
            lines.append(GroupLine(gets, between, Value(least), Value(greatest)))
        return tuple(lines), number - len(kept), sure if any(line.ends for line in lines) else ""

    def _units(self, group: int) -> int | None:
        """How many units a group has, where they have several rows and there is one context."""
        law = self.subject.law
        if law.units is None or not law.units.repeated or len(law.contexts) > 1:
            return None
        return sum(n for cell in np.flatnonzero(law.cell_group == group).tolist() for n, _ in law.units.profiles[cell])

    def _over_units(self) -> dict[Any, Fraction]:
        """The means over units of the groups of the only context, where intervals are about those."""
        if len(self.subject.law.contexts) > 1 or self.subject.law.units is None or not self.subject.law.units.repeated:
            return {}
        comparison = self.seen.comparisons().get("local")
        if comparison is None or comparison.estimand == "mean over rows" or len(comparison.blocks) != 1:
            return {}
        forms = zip(comparison.labels[0][1], comparison.blocks[0], strict=True)
        return {tuple(label.values()): comparison.cells[form[0][0]].mean for label, form in forms}

    def _ends(self) -> tuple[Callable[[Any], tuple[Fraction, Fraction] | None], str]:
        """Gives the ends of the mean of a group in the population, each group by itself, and the confidence in words."""
        seen = self.seen
        quantity: Quantity = "global" if "global" in {*seen.of_ratios, *seen.of_differences} else "local"
        known = seen.of_ratios.get(quantity) or seen.of_differences.get(quantity)
        if quantity == "local" and len(self.subject.law.contexts) > 1:
            known = None
        comparison = None if known is None or known.method not in get_args(Method) else seen.comparisons().get(quantity)
        if known is None or comparison is None or len(comparison.blocks) != 1:
            return (lambda _: None), ""
        pairs = zip(comparison.labels[0][1], comparison.blocks[0], strict=True)
        forms = {tuple(label.values()): form for label, form in pairs}
        method: Any = known.method

        def ends(label: Any) -> tuple[Fraction, Fraction] | None:
            return None if label not in forms else form_ends(comparison, forms[label], known.confidence, method)

        return ends, percent(known.confidence)

    def contexts(self, *, rates: bool, most: int) -> tuple[tuple[Compared, ...], int]:
        """The most unequal contexts, and how many others have two groups."""
        law, utility = self.subject.law, self.subject.utility
        if not self.seen.columns.context:
            return (), 0
        found: Sequence[Ratio | MeanDifference]
        if self.seen.worst is not None:
            own: dict[tuple[str, ...], Ratio] = {}
            for entry in self.seen.worst:
                own.setdefault(tuple((entry.witness.context or {}).values()), entry)
            found = sorted(own.values(), key=lambda entry: entry.ratio, reverse=True)[:most]
            compared = self.seen.contexts - sum("groups" not in entry and "context" in entry for entry in self.seen.not_compared)
        else:
            found = [*furthest_contexts(law, utility, most)] if self.signed else [*most_unequal_contexts(law, utility, most)]
            compared = int((np.diff(law.starts) > 1).sum())
        if self.seen.contexts < 2:
            return (), 0
        pairs = zip(found, map(_of_rows, self.seen.sizes([entry.witness for entry in found])), strict=True)
        listed = [self.pair(e.witness, e.ratio if isinstance(e, Ratio) else e.value, size, rates=rates) for e, size in pairs]
        return tuple(listed), compared - len(listed)

    def audited(self) -> str:
        """What was audited, in numbers."""
        law, columns = self.subject.law, self.seen.columns
        what = {"policy": "a policy behind privacy filters", "probabilities": "probabilities of decisions"}.get(self.seen.kind, "")
        if not what:
            total = Fraction(sum(law.cell_mass), law.scale)
            what = f"{how_many(total)} {noun(total, 'decision')}"
            if law.unknown is not None:
                without = Fraction(int(law.unknown.weights.sum()), law.scale)
                what += f" and {how_many(without)} without a group"
            if law.units is not None and law.units.columns:
                what += f" on {law.units.total:,} {noun(law.units.total, 'unit')} ({_columns(law.units.columns)})"
        elif self.subject.deployment is not None and (policy := self.subject.deployment.policy.law).kind == "counts":
            what += f", seen in {how_many(Fraction(sum(policy.cell_mass), policy.scale))} decisions"
        said = f"{what}, {len(law.groups):,} {noun(len(law.groups), 'group')} ({_columns(columns.group)})"
        if not columns.context:
            return f"{said}, no contexts"
        return f"{said}, {self.seen.contexts:,} {noun(self.seen.contexts, 'context')} ({_columns(columns.context)})"

    def others(self) -> str:
        """Which decisions count as the contrary of those that count, the most common first."""
        law, utility = self.subject.law, self.subject.utility
        if not utility.by_decision or self.signed:
            return ""
        values, weights = utility.values.tolist(), law.weights
        worth = [u for u, value in enumerate(values) if value]
        rest = [u for u, value in enumerate(values) if not value and law.decisions[u] not in self.seen.undecided and weights[:, u].any()]
        if not rest or not worth:
            return ""
        one = len(worth) == 1 and values[worth[0]] == utility.scale
        what = f"not {clip(law.decisions[worth[0]], 30)}" if one else "worth 0"
        sizes = {u: Fraction(0) for u in rest}
        counted = law.kind == "counts" and self.subject.deployment is None
        if counted:
            small = weights.dtype == np.int64 and float(weights.sum(dtype=np.float64)) < 2.0**62
            sizes = {u: Fraction(int((weights[:, u] if small else weights[:, u].astype(object)).sum()), law.scale) for u in rest}
            rest.sort(key=lambda u: -sizes[u])
        named_ = [clip(law.decisions[u], 30) + (f" {how_many(sizes[u])}" if counted else "") for u in rest[:SHOW_OTHERS]]
        more = len(rest) - SHOW_OTHERS
        if more > 0:
            amount = f" ({how_many(sum((sizes[u] for u in rest[SHOW_OTHERS:]), Fraction(0)))})" if counted else ""
            named_.append(f"and {more:,} more {noun(more, 'label')}{amount}")
        return f"Counted as {what}: {', '.join(named_)}."

    def left_out(self) -> tuple[str, ...]:
        """What was left out, and why, in a few lines."""
        of_log = () if self.seen.lost is None else self.seen.lost.read
        steps = sorted(self.seen.preparation, key=is_uncounted)  # first who is not in the figures: a screen may show no more
        lines = [clip(plain(text), 600) for text in (*of_log, *said({"preparation": steps}))]
        reasons: dict[str, list[Mapping[str, Any]]] = {}
        for entry in self.seen.not_compared:
            reasons.setdefault(entry["reason"], []).append(entry)
        for reason, entries in reasons.items():
            lines.append(_left_out(plain(reason), entries, self.seen.columns, self.seen.contexts))
        more = len(lines) - LEFT_OUT
        return (*lines[:LEFT_OUT], f"and {more} more, all in the certificate") if more > 0 else tuple(lines)


def how_many(decisions: Fraction) -> str:
    """How many decisions: to the last one, or about, where nobody could have counted them."""
    return Size(decisions).text if decisions < MOST_COUNTED else approximate(decisions)


def _of_rows(found: Sizes | None) -> Sizes | None:
    """Sizes of means over rows, which the table of contexts has, whatever the units are."""
    return None if found is None else (Size(found[0].decisions), Size(found[1].decisions))


def _columns(names: Sequence[str]) -> str:
    return ", ".join(clip(name, 30) for name in names)


def _left_out(reason: str, entries: Sequence[Mapping[str, Any]], columns: Columns, contexts: int) -> str:
    """One line for all that was left out for one reason."""
    first, more = entries[0], len(entries) > 1
    if "quantity" in first:
        what = "nothing is compared over all contexts" if first["quantity"] == "global" else f"no {first['quantity']} ratio"
        return f"{what}: {reason}" if columns.context or first["quantity"] != "global" else f"nothing is compared: {reason}"
    if "context" not in first:
        groups = first.get("groups", ())
        return f"{_count(len(groups), 'group')}: {reason}"
    where = (
        f"{len(entries):,} of {contexts:,} contexts" if more else named(_labels(first["context"], columns.context)) or "the only context"
    )
    groups = sum(len(entry.get("groups", ())) for entry in entries)
    if not groups:
        return f"{where}: {reason}, so nobody is compared there"
    who = named(_labels(first["groups"][0], columns.group)) if groups == 1 else f"some groups ({groups:,} in all)" if more else ""
    return f"{where}: {reason} of {who or _count(groups, 'group')}"


def _labels(labels: Any, columns: Sequence[str]) -> Mapping[str, str]:
    """Labels as a result has them, or as a document does."""
    return labels if isinstance(labels, Mapping) else dict(zip(columns, labels, strict=True))


def _count(number: int, what: str) -> str:
    return f"{number:,} {noun(number, what)}"


def group_means(subject: Subject, most: int, *, burden: bool) -> list[tuple[int, Fraction, Fraction | None]]:
    """Of groups their means over all contexts, exact, and of counts how many decisions they have; empty where means are not defined.

    Of probabilities, those that the worst and the best are among are enough where there are more than are listed.
    """
    law, utility = subject.law, subject.utility
    if law.kind == "counts" and law.population == "counts":
        return _counted_means(law, utility)
    if not law.global_groups:
        return []
    try:
        return [(a, mean, None) for a, mean in outermost_means(law, utility, most, greatest=burden)]
    except InputError:  # of more digits than anybody computes
        return []


def _counted_means(law: Law, utility: UtilityTable) -> list[tuple[int, Fraction, Fraction | None]]:
    """The means of counts: sums of utilities over sums of decisions."""
    small = law.weights.dtype == np.int64 and utility.values.dtype == np.int64
    if small:
        most = max(1, int(np.abs(utility.values).max()))
        small = float(law.totals.sum(dtype=np.float64)) * most < 2.0**62
    weights, values, totals = law.weights, utility.values, law.totals
    if not small:
        weights, values, totals = (array.astype(object) for array in (weights, values, totals))
    tops = weights @ values if values.ndim == 1 else (weights * values).sum(axis=1)
    dtype = np.int64 if small else object
    sums, amounts = np.zeros(len(law.groups), dtype=dtype), np.zeros(len(law.groups), dtype=dtype)
    np.add.at(sums, law.cell_group, tops)
    np.add.at(amounts, law.cell_group, totals)
    pairs = enumerate(zip(sums.tolist(), amounts.tolist(), strict=True))
    return [(a, Fraction(top, n * utility.scale), Fraction(n, law.scale)) for a, (top, n) in pairs if n]
