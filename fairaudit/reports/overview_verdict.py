"""The verdict of an overview: in a sentence from the pair of groups that decided it, and whether it is more than chance."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from decimal import ROUND_CEILING, ROUND_FLOOR, ROUND_HALF_EVEN, Context, Decimal, localcontext
from fractions import Fraction
from math import inf
from typing import Literal

from fairaudit.audits.differences import difference_pair
from fairaudit.audits.sentences import Deciding, caution, few_of_policy, headline_pair, identifier_text
from fairaudit.audits.targets import Target
from fairaudit.audits.undecided import decisions_by_group
from fairaudit.exact.extended import Extended
from fairaudit.exact.rationals import quotient, shortened
from fairaudit.inference.verdicts import SEVERITY
from fairaudit.measures.differences import MeanDifference
from fairaudit.measures.limits import Quantity, limit_cells, limit_text
from fairaudit.measures.ratios import Ratio, Witness
from fairaudit.model.law import Law
from fairaudit.reports.overview_parts import Gets, Known, Parts, Seen
from fairaudit.reports.words import clip
from fairaudit.tables.preparation import said, unequal_shares, unequally_left_out
from fairaudit.words import DRIFTING, ENDS_CROSS, HIDDEN, THE_INTERVAL, WHATEVER, WHOEVER, approximate, percent, place, plain

__all__ = ["cautions", "chance", "figure", "sentences", "target_lines"]


SHOW_SPELT = 2  # labels in several spellings that are named

FOLD = "--fold-labels merges labels that differ in case, blanks or Unicode form alone."

SHOW_LABEL = 60  # characters of the labels of a group or context in a sentence

GREAT = Fraction(10**15)  # beyond, figures have an exponent


def figure(value: Extended, rounding: Literal["nearest", "down", "up"] = "nearest", digits: int = 4) -> str:
    """A ratio or difference in some digits, and not fewer than those before the point.

    Examples
    --------
    >>> figure(Fraction(22, 15), digits=3), figure(Fraction(123456, 10), "down"), figure(Fraction(1, 3), "up")
    ('1.47', '12,345', '0.3334')
    """
    if not isinstance(value, Fraction) or not Fraction(1, 10**300) < abs(value) < GREAT:
        return approximate(value, rounding, digits)
    value = shortened(value)
    towards = {"nearest": ROUND_HALF_EVEN, "down": ROUND_FLOOR, "up": ROUND_CEILING}[rounding]
    whole = len(str(abs(value.numerator) // value.denominator))
    with localcontext(Context(prec=max(digits, whole), rounding=towards)) as context:
        return f"{context.divide(Decimal(value.numerator), Decimal(value.denominator)):,}"


def target_lines(targets: Sequence[Target]) -> tuple[tuple[str, str], ...]:
    """The verdict on each target, and its limit."""
    return tuple((target.verdict, _limit(target)) for target in targets)


def _limit(target: Target) -> str:
    """A limit on a ratio in both readings; on another number as it is said everywhere."""
    if target.unit != "ratio" or target.limit < 1:
        return limit_text(target.quantity, target.unit, target.limit)
    most, least, _ = limit_cells("ratio", target.limit)
    return f"{target.quantity} ratio at most {most} (least at least {least} of the greatest)"


def sentences(parts: Parts, amount: str, *, rates: bool) -> tuple[str, ...]:
    """The verdict in a sentence from the pair that decided it; without a target one for contexts, and one for all together."""
    say = _Speaker(parts, amount, rates)
    seen = parts.seen
    foremost = _foremost(seen)
    if foremost is not None:
        return (say.judged(*foremost),)
    quantities: tuple[Quantity, ...] = ("local", "global")
    found = [] if parts.signed else [say.measured(q, seen.ratios.get(q), seen.of_ratios.get(q)) for q in quantities]
    found += [say.measured(q, seen.differences.get(q), seen.of_differences.get(q)) for q in quantities if q in seen.differences]
    said = [text for text in found if text]
    if _said_once(seen):
        said = [text for i, text in enumerate(found) if text and not (i % 2 and found[i - 1])]
    return tuple(said) or ("No two groups can be compared.",)


def _said_once(seen: Seen) -> bool:
    """Whether what holds within contexts is what holds over all: there is one context at the most, and nothing tells the two apart."""
    if not seen.columns.context:
        return True

    def alike(found: Mapping[Quantity, Ratio | MeanDifference | None], known: Mapping[Quantity, Known]) -> bool:
        local, overall = found.get("local"), found.get("global")
        if local is None or overall is None:
            return local is overall
        return (
            _apart(local) == _apart(overall)
            and (local.witness.higher, local.witness.lower) == (overall.witness.higher, overall.witness.lower)
            and known.get("local") == known.get("global")
        )

    return seen.contexts == 1 and alike(seen.ratios, seen.of_ratios) and alike(seen.differences, seen.of_differences)


def _apart(found: Ratio | MeanDifference) -> Extended:
    return found.ratio if isinstance(found, Ratio) else found.value


def cautions(parts: Parts) -> tuple[str, ...]:
    """What to know before the sentences: that a column looks like an identifier, or that hardly any decisions stand behind them."""
    seen, law = parts.seen, parts.subject.law
    foremost = _foremost(seen)
    deciding = None if foremost is None else foremost[1]
    if seen.differences and (parts.signed or (deciding is not None and deciding.unit == "difference")):
        pair = difference_pair(deciding, seen.differences)
    else:
        pair = headline_pair(deciding, seen.ratios.get("local"), seen.ratios.get("global"))
    size = None if pair is None else seen.sizes([pair])[0]
    prepared = law if parts.subject.deployment is None else parts.subject.deployment.policy.law
    listed = (
        *seen.warned,
        unequally_left_out(seen.preparation, prepared.groups),
        "" if seen.lost is not None else _undecided_by_group(seen.undecided, prepared),
        *said({"spellings": seen.spelt[:SHOW_SPELT]}),
        FOLD if seen.spelt else "",
        "" if seen.lost is None else seen.lost.caution,
        seen.changed,
        identifier_text(law, seen.columns, seen.labels),
        caution(pair, size, "", _named),
        few_of_policy(parts.subject.deployment, pair),
    )
    return tuple(plain(text) for text in listed if text)


def _undecided_by_group(undecided: Sequence[str], law: Law) -> str:
    """Of which groups more decisions are undecided than of others; empty where the shares hardly differ, or nothing was counted."""
    if not undecided or law.kind != "counts":
        return ""
    said = unequal_shares(decisions_by_group(law, undecided), law.groups)
    return f"Undecided: {said}." if said else ""


def _foremost(seen: Seen) -> tuple[Target, Deciding | None] | None:
    """The first target of those that determine the verdict on all, with what decided it."""
    pairs = zip(seen.targets, seen.deciding, strict=True)
    return max(pairs, key=lambda pair: SEVERITY[pair[0].verdict], default=None)


class _Speaker:
    """The parts of a sentence."""

    def __init__(self, parts: Parts, amount: str, rates: bool) -> None:
        self.parts, self.seen, self.amount, self.rates = parts, parts.seen, amount, rates

    def measured(self, quantity: Quantity, found: Ratio | MeanDifference | None, known: Known | None) -> str:
        """What the table shows of its most unequal pair, and what draws say of the population; empty where nothing is compared."""
        if found is None:
            return ""
        over_units = known is not None and known.over_units is not None
        shown = known.over_units if known is not None and known.over_units is not None else found
        unit = "ratio" if isinstance(shown, Ratio) else "difference"
        tail = "" if known is None else f"; in the population {self._noun(quantity, unit)} is {_ends(known)}"
        return self._pair(shown, shown.witness, unit, tail, over_units=over_units, digits=3)

    def judged(self, target: Target, deciding: Deciding | None) -> str:
        """The pair that decided a target, with the end that did."""
        seen, quantity = self.seen, target.quantity
        of_differences = target.unit == "difference"
        measured = seen.differences.get(quantity) if of_differences else seen.ratios.get(quantity)
        if measured is None:
            where = "" if not seen.columns.context else " over all contexts" if quantity == "global" else " within a context"
            return f"No two groups can be compared{where}."
        known = (seen.of_differences if of_differences else seen.of_ratios).get(quantity)
        unit: Literal["ratio", "difference"] = "difference" if of_differences else "ratio"
        over_units = known is not None and known.over_units is not None and target.confidence is not None and not target.under
        shown = known.over_units if over_units and known is not None and known.over_units is not None else measured
        witness = shown.witness if deciding is None or deciding.end == "table" or deciding.pair is None else deciding.pair
        tail = self._tail(target, deciding, known, unit)
        if any(getattr(witness, name) != getattr(shown.witness, name) for name in ("context", "higher", "lower")):
            tail = {"inconclusive": ", which leaves it open", "within": ", the closest to the limit"}.get(target.verdict, "") + tail
        return self._pair(shown, witness, unit, tail, over_units=over_units, digits=4 if target.confidence is None else 3)

    def _tail(self, target: Target, deciding: Deciding | None, known: Known | None, unit: Literal["ratio", "difference"]) -> str:
        """What is known of the population: the end that decided, or both where neither does."""
        if deciding is None or deciding.end == "table":
            return ""
        is_ = f"; in the population {self._noun(target.quantity, unit)} is"
        at = f"at {percent(target.confidence or 0)}"
        if target.verdict == "exceeds":
            return f"{is_} at least {figure(deciding.value, 'down')}, {at}"
        by = "" if deciding.by in (THE_INTERVAL, ENDS_CROSS) else f" by {deciding.by}"
        if target.verdict == "within":
            return f"{is_} at most {figure(deciding.value, 'up')}{by}, {at}"
        if deciding.value == inf and known is None:
            return "; nothing bounds the population"
        least = "" if known is None else f" at least {figure(known.lower, 'down')},"
        return f"{is_}{least} at most {figure(deciding.value, 'up')}{by}, {'each ' if least else ''}{at}"

    def _noun(self, quantity: Quantity, unit: str) -> str:
        """Of one pair its ratio, of several the greatest."""
        law = self.parts.subject.law
        single = len(law.groups) == 2 and (quantity == "global" or self.seen.contexts < 2)
        return f"the {'' if single else 'greatest '}{unit}"

    def _pair(self, most: Ratio | MeanDifference, witness: Witness, unit: str, tail: str, *, over_units: bool, digits: int) -> str:
        """Two groups, what they get, and how far apart that is; that all groups get the same, where the greatest says so."""
        units, alike = ", mean over units" if over_units else "", (most.ratio == 1 if isinstance(most, Ratio) else most.value == 0)
        if alike:
            where = " over all contexts" if witness.context is None else " in every context"
            return f"{self.amount}{units}: the same in all groups that are compared{where if self.seen.columns.context else ''}{tail}."
        high, low = witness.expectations
        about = f"{self.amount}{self._where(witness)}{units}"
        found = self.parts.pair(witness, Fraction(1), self.seen.sizes([witness])[0], rates=self.rates)
        if high == low:
            apart = "alike"
        elif unit == "difference":
            apart = f"{figure(high - low)} apart"
        else:
            ratio = quotient(high, low)
            apart = "an infinite ratio" if ratio == inf else f"{figure(ratio, digits=digits)} times"
        return f"{about}: {_who(found.higher)}, {_who(found.lower)}, {apart}{tail}."

    def _where(self, witness: Witness) -> str:
        if witness.context is None:
            return " over all contexts" if self.seen.columns.context else ""
        return f" within {_named(witness.context)}" if witness.context else ""


def _who(found: Gets) -> str:
    of = f" ({found.of})" if found.of else ""
    return f"{_named(found.group)} {found.amount}{of}"


def _named(labels: Mapping[str, str]) -> str:
    """Columns and labels; where both are too long for a sentence the labels alone, as the tables have them."""
    whole = plain(place(labels))
    return whole if len(whole) <= SHOW_LABEL else clip(" / ".join(labels.values()), SHOW_LABEL)


def _ends(known: Known) -> str:
    """An interval in words."""
    low, high = figure(known.lower, "down"), figure(known.upper, "up")
    if known.lower > known.upper:
        return f"at least {low}, and at most {high}: the ends cross (at {percent(known.confidence)})"
    if known.each:
        return f"at least {low}, at most {high}, each at {percent(known.confidence)}"
    if known.upper == inf:
        return f"at least {low}, at {percent(known.confidence)}, and nothing bounds it from above"
    return f"between {low} and {high}, at {percent(known.confidence)}"


def chance(parts: Parts) -> tuple[tuple[str, str], ...]:
    """Whether the verdict is established beyond chance, in a word or two, and why.

    With a target "yes" says that it is proved to be exceeded, "no" that it is proved to be kept; without one "yes" says that the interval
    of the ratio lies above 1 (of a difference, above 0), which is "too few decisions" where it does not, unless some are undecided.
    """
    seen = parts.seen
    if not any({**seen.ratios, **seen.differences}.values()):
        return (("not a question", "no two groups can be compared"),)
    foremost = _foremost(seen)
    if seen.verdict == "changed":
        return (("it depends", "on when: the ratio changed during the stream, and nothing is said of one constant ratio"),)
    if foremost is not None:
        return (_of_target(foremost[0], seen),)
    known = dict(seen.of_differences if parts.signed else seen.of_ratios)
    if not known:
        return (_without_draws(seen),)
    once = _said_once(seen)
    if once and len(known) > 1:
        known.pop("global")
    nothing = 0 if parts.signed else 1
    where: dict[Quantity, str] = {"local": "within a context", "global": "over all contexts"} if not once else {}
    said: dict[Literal["differ", "open", "meant"], list[Quantity]] = {}
    for quantity, own in known.items():
        alike = seen.meant is not None and seen.meant.get(quantity) == 1
        said.setdefault("differ" if own.lower > nothing else "meant" if alike else "open", []).append(quantity)
    found = []
    for answer, quantities in said.items():
        confidences = dict.fromkeys(percent(known[quantity].confidence) for quantity in quantities)
        at = f"{'each ' if len(quantities) > 1 else ''}at {' and '.join(confidences)}"
        places = " and ".join(where[quantity] for quantity in quantities if quantity in where)
        groups = {"differ": "groups differ", "open": "that groups are alike", "meant": "groups are alike"}[answer]
        about = f"{groups} {places}".rstrip()
        if answer == "differ":
            found.append(("yes", f"{about}, {at}"))
        elif answer == "meant":
            every = about.replace("within a", "within every")
            found.append(("not known", f"in this table itself, {every} for some of what the undecided decisions may have meant"))
        elif seen.meant is not None:
            found.append(("not known", f"too few decisions, or too many of them undecided: {about} is not excluded, {at}"))
        else:
            found.append(("too few decisions", f"{about} is not excluded, {at}"))
    return tuple(found)


def _whatever(target: Target, outcome: str, at: str) -> tuple[str, str]:
    """Whether the verdict is more than chance, and more than what undecided decisions meant."""
    if target.verdict == "depends":
        return "it depends", "on what the undecided decisions meant"
    if target.confidence is None:
        return "not asked", f"judged for this table alone: {outcome}, whatever the undecided decisions meant"
    word = {"exceeds": "yes", "within": "no"}.get(target.verdict, "not known")
    said = {
        "exceeds": "the population exceeds the limit, whatever the undecided decisions meant",
        "within": "within the limit is established, whatever the undecided decisions meant",
    }
    return word, f"{said.get(target.verdict, 'too few decisions, or too many of them undecided')}{at}"


def _without_draws(seen: Seen) -> tuple[str, str]:
    """Why chance is no question where there is no interval."""
    if seen.drawn:
        return "not asked", "no interval was computed; the figures describe this table alone"
    return "not a question", "the probabilities are taken as given, the figures are exact"


def _of_target(target: Target, seen: Seen) -> tuple[str, str]:
    """Whether the verdict on a target is more than chance."""
    outcome = {"exceeds": "the limit is exceeded", "within": "the limit is kept"}.get(target.verdict, "nothing is settled")
    at = "" if target.confidence is None else f", at {percent(target.confidence)}"
    if target.under == HIDDEN:
        return "it depends", f"on the declared unrecorded factor: with it {outcome}{at}"
    if target.under == DRIFTING:
        return "it depends", f"on the declared drift: in the worst case within it {outcome}{at}"
    if target.under == WHOEVER:
        if target.verdict == "depends":
            return "it depends", "on who the decisions without a recorded group are"
        return "not asked", f"judged for this table alone: {outcome}, whoever those without a group are"
    if (seen.differences if target.unit == "difference" else seen.ratios).get(target.quantity) is None:
        return "not known", "no two groups can be compared"
    if target.under == WHATEVER:
        return _whatever(target, outcome, at)
    if target.confidence is None:
        found = _without_draws(seen)
        return (found[0], "judged for this table alone, decided exactly") if seen.drawn else found
    by = f", by {target.upper[1]}" if target.upper is not None and target.upper[1] != THE_INTERVAL else ""
    if target.verdict == "exceeds":
        return "yes", f"the population exceeds the limit{at}"
    if target.verdict == "within":
        return "no", f"within the limit is established{by}{at}"
    if target.upper is None:
        return "not known", "nothing bounds the population behind the table"
    return "too few decisions", seen.further or f"what was recorded does not settle it{at}"
