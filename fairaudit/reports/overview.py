"""What an audit comes to, in the order in which a person asks for it: the screen, the page and notebooks say it from here.

What was audited, the pair of groups that decided in one sentence, whether that is more than chance, what each group gets, the most
unequal contexts, what was left out, and what is assumed.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from fractions import Fraction
from typing import TYPE_CHECKING, Any, Literal, get_args

from fairaudit.audits.sentences import Sizes, change_text, evaluation_of, sizes
from fairaudit.certificates.reader import Subject, mean_difference, number, ratio
from fairaudit.measures.limits import Quantity
from fairaudit.measures.rates import NAMES, OVERALL
from fairaudit.measures.ratios import Witness
from fairaudit.model.law import Law
from fairaudit.model.layout import Columns
from fairaudit.reports.assumed import in_short
from fairaudit.reports.overview_parts import Compared, GroupLine, Known, Parts, Seen, amount_name, counted_decisions, rate_text
from fairaudit.reports.overview_verdict import cautions, chance, figure, sentences, target_lines
from fairaudit.reports.words import Value, named
from fairaudit.words import DRIFTING, HIDDEN, approximate

if TYPE_CHECKING:
    from collections.abc import Sequence

    from fairaudit.audits.result import Result
    from fairaudit.audits.targets import Target
    from fairaudit.model.policy import Deployment
    from fairaudit.reports.content import Content
    from fairaudit.reports.lost_answers import LostAnswers

__all__ = ["Overview", "of_content", "of_result", "overview"]


GROUPS = 12  # groups whose intervals are found, unless more are asked for

CONTEXTS = 8


@dataclass(frozen=True)
class Overview:
    """What an audit comes to.

    Attributes
    ----------
    amount : str
        What is compared: the decisions that count, or an expected utility or burden.
    rates : bool
        Whether it is a rate, to be said in percent.
    audited : str
        What was audited, in numbers.
    others : str
        Which decisions count as the contrary of those that count; empty where all of them count, or each row has its own utility.
    columns : Columns
        The names of the columns.
    groups : tuple of GroupLine
        What groups get, the worst first, and the best one last; empty where means over all contexts are not defined.
    more_groups : int
        How many are not listed, between the others.
    sure : str
        At which confidence each interval of a group holds by itself; empty without intervals.
    contexts : tuple of Compared
        The most unequal contexts, most unequal first, with the pair of groups that is furthest apart.
    more_contexts : int
        How many contexts with two groups are not listed; none of them is more unequal.
    targets : tuple of (str, str)
        The verdict on each target, and its limit.
    cautions : tuple of str
        What makes little of the sentences: hardly any decisions behind them, a column like an identifier, a ratio that changed.
    sentences : tuple of str
        The verdict in a sentence from the pair that decided it; without a target one for contexts, one for all together.
    chance : tuple of (str, str)
        Whether that is established beyond chance, in a word or two, and why.
    beside : tuple of str
        What else was found.
    left_out : tuple of str
        What was left out.
    assumptions : tuple of str
        What is assumed, in short.
    signed : bool
        Whether utilities can be negative, so that groups are apart by differences and not by ratios.
    burden : bool
        Whether the utility counts a burden, so that the best group is the one with the least.
    """

    amount: str
    rates: bool
    audited: str
    others: str
    columns: Columns
    groups: tuple[GroupLine, ...]
    more_groups: int
    sure: str
    contexts: tuple[Compared, ...]
    more_contexts: int
    targets: tuple[tuple[str, str], ...]
    cautions: tuple[str, ...]
    sentences: tuple[str, ...]
    chance: tuple[tuple[str, str], ...]
    beside: tuple[str, ...]
    left_out: tuple[str, ...]
    assumptions: tuple[str, ...]
    signed: bool
    burden: bool

    def to_the_best(self, line: GroupLine) -> str:
        """How far a group is from the best one; in both readings where there is a target on a ratio."""
        least, greatest = figure(line.least.value, digits=3), figure(line.greatest.value, digits=3)
        if self.signed:
            return least
        own, other = (greatest, least) if self.burden else (least, greatest)
        return f"{own} or {other}" if self.targets and own != other else own


def overview(subject: Subject, seen: Seen, *, groups: int = GROUPS, contexts: int = CONTEXTS) -> Overview:
    """Say what an audit comes to.

    Parameters
    ----------
    subject : Subject
        The table.
    seen : Seen
        What is known besides.
    groups, contexts : int
        How many are listed at the most.
    """
    parts = Parts(subject, seen)
    counted = counted_decisions(subject.utility)
    rates, amount = bool(counted), amount_name(subject.law, counted, burden=seen.burden)
    lines, more_groups, sure = parts.groups(rates=rates, most=groups)
    unequal, more_contexts = parts.contexts(rates=rates, most=contexts)
    return Overview(
        amount,
        rates,
        parts.audited(),
        parts.others(),
        seen.columns,
        lines,
        more_groups,
        sure,
        unequal,
        more_contexts,
        target_lines(seen.targets),
        cautions(parts),
        sentences(parts, amount, rates=rates),
        chance(parts),
        seen.beside,
        parts.left_out(),
        (*in_short(seen.assumptions), *_as_given(subject.law, seen)),
        parts.signed,
        seen.burden,
    )


def _as_given(law: Law, seen: Seen) -> Iterator[str]:
    """What is assumed of a table by whoever reads its figures."""
    if law.population == "equal" and law.global_groups and len(law.contexts) > 1:
        yield "all contexts weigh equally, as no population was given"
    if not seen.burden:
        yield "more of it is better; where it harms, --burden says so"
    yield f"the {'table is' if seen.drawn else 'probabilities are'} genuine and complete"


def _drawn(law: Law, deployment: Deployment | None) -> bool:
    """Whether what is audited are recorded decisions, and not probabilities."""
    return (deployment.policy.law if deployment else law).kind == "counts"


def of_result(result: Result, *, groups: int = GROUPS, contexts: int = CONTEXTS) -> Overview:
    """What an audit that was just made comes to.

    Examples
    --------
    >>> import fairaudit as fa
    >>> table = {"decision": ["hired", "turned down"] * 2, "sex": ["f", "f", "m", "m"], "n": [30, 10, 20, 20]}
    >>> result = fa.audit(table, decision="decision", group="sex", count="n", utility="hired", confidence=None)
    >>> of_result(result).sentences
    ('hired: sex=f 75.0 % (30 of 40), sex=m 50.0 % (20 of 40), 1.5 times.',)
    """
    apart = result.differences
    comparisons = {**(apart.comparisons if apart else {}), **result.comparisons}
    special = result.whoever or result.hidden_context or result.given_truth or result.undecided or any(t.under for t in result.targets)
    subject = Subject(result.law, result.utility, result.deployment)
    of_windows: Sequence[str] = ()
    beside: tuple[str, ...] = ()
    if result.changed:
        from fairaudit.certificates.entries import change_assumptions

        of_windows = change_assumptions(result.changed)
    if special:
        from fairaudit.audits.document import document

        beside = tuple(_beside(document(result), subject))
    seen = Seen(
        columns=result.columns,
        kind="policy" if result.deployment else result.law.kind,
        drawn=_drawn(result.law, result.deployment),
        contexts=len(result.partial.table.header["contexts"] if result.partial else result.law.contexts),
        verdict=result.verdict,
        targets=result.targets,
        deciding=result.deciding,
        ratios={} if result.utility.signed else {"local": result.local, "global": result.global_},
        differences=apart.measured if apart else {},
        of_ratios={
            q: Known(i.lower, i.upper, i.confidence, i.ends == "each", i.evidence.get("method", ""), i.of_units)
            for q, i in result.intervals.items()
        },
        of_differences={
            q: Known(i.lower, i.upper, i.confidence, i.ends == "each", i.evidence.get("method", ""), i.of_units)
            for q, i in (apart.intervals if apart else {}).items()
        },
        comparisons=lambda: comparisons,
        sizes=lambda pairs: [*map(result.sizes_of, pairs)] if result.partial else sizes(result.law, pairs),
        burden=result.burden,
        not_compared=result.not_compared,
        preparation=result.preparation,
        lost=_lost(result),
        undecided=() if result.undecided is None else result.undecided.decisions,
        meant=None if result.undecided is None else {one.quantity: one.least for one in result.whatever},
        assumptions=_assumed([claim.entry for claim in result.claims], result.targets, of_windows),
        beside=beside,
        warned=result.warnings,
        spelt=result.spellings,
        changed=_changed(result),
        further=_further(result),
        worst=result.partial.pairs if result.partial else None,
        labels=result.partial.table.header["contexts"] if result.partial else None,
    )
    return overview(subject, seen, groups=groups, contexts=contexts)


def _lost(result: Result) -> LostAnswers | None:
    said = evaluation_of(result)
    if said is None:
        return None
    from fairaudit.reports.lost_answers import lost_answers

    return lost_answers(said, result.law)


def of_content(content: Content, *, groups: int = GROUPS, contexts: int = CONTEXTS) -> Overview | None:
    """What a certificate comes to; None where it does not hold its table."""
    from fairaudit.reports.undecided import least_meant
    from fairaudit.reports.verdicts import judged_targets

    subject, found = content.subject, content.document
    if subject is None:
        return None
    about, stated = found["subject"], found.get("intervals", {})
    targets = [target for target, _ in judged_targets(found)]

    def sizes_of(pairs: Sequence[Witness]) -> list[Sizes | None]:
        return sizes(subject.law, pairs)

    seen = Seen(
        columns=subject.law.columns,
        kind=about["kind"],
        drawn=_drawn(subject.law, subject.deployment),
        contexts=len(subject.law.contexts),
        verdict=found["verdict"],
        targets=targets,
        deciding=content.deciding,
        ratios={} if content.signed else {"local": content.measured["local"], "global": content.measured["global"]},
        differences=content.differences,
        of_ratios=dict(_known(stated, "ratio")),
        of_differences=dict(_known(stated, "difference")),
        comparisons=lambda: content.expectations.comparisons if content.expectations else {},
        sizes=sizes_of,
        burden=content.burden,
        not_compared=found["not_compared"],
        preparation=about.get("preparation", ()),
        undecided=about.get("undecided", {}).get("decisions", ()),
        lost=content.lost,
        meant=least_meant(found),
        assumptions=_assumed(found["claims"], targets, found.get("changed", {}).get("assumptions", ())),
        beside=tuple(_beside(found, subject)),
        spelt=about.get("spellings", ()),
        changed=content.changed,
    )
    return overview(subject, seen, groups=groups, contexts=contexts)


def _changed(result: Result) -> str:
    """What a window of a stream says against the whole of it."""
    if result.changed is None:
        return ""
    own = result.changed
    ends = (own.stream.lower, own.stream.upper), (own.part.lower, own.part.upper)
    return change_text(own.quantity, own.window.number, *ends, own.confidence)


def _known(stated: Mapping[str, Any], unit: Literal["ratio", "difference"]) -> Iterator[tuple[Quantity, Known]]:
    """The intervals of a certificate."""
    for quantity in get_args(Quantity):
        entry = stated.get(quantity if unit == "ratio" else f"{quantity}_difference")
        if entry is not None and unit in entry:
            low, high = map(number, entry[unit])
            measured = entry.get("measured")
            over_units = ratio(measured) if unit == "ratio" else mean_difference(measured)
            method = entry.get("method", "")
            yield quantity, Known(Fraction(low), high, Fraction(entry["confidence"]), entry.get("ends") == "each", method, over_units)


def _assumed(claims: Sequence[Mapping[str, Any]], targets: Sequence[Target], changed: Sequence[str]) -> tuple[str, ...]:
    """What claims rest on, and what a contradicted stream does, without what is about updates where no drift was declared."""
    drifts = any(target.under == DRIFTING for target in targets)
    claimed = (text for claim in claims if drifts or claim["by"] != "T16" for text in claim["assumptions"])
    return tuple(dict.fromkeys((*claimed, *changed)))


def _further(result: Result) -> str:
    """How many more draws would settle the target that is open, where that can be estimated."""
    if result.verdict != "inconclusive":
        return ""
    units = "units" if result.law.units is not None and result.law.units.repeated else "decisions"
    for target, planned in result.further_draws:
        if target.verdict == "inconclusive" and planned.total and planned.decides is not None:
            shown = {"exceeds": "the limit is exceeded", "within": "the limit is kept"}[planned.decides]
            return f"an estimate: {planned.total:,} more {units} would show that {shown}, if the truth is as measured"
    return ""


def _beside(found: Mapping[str, Any], subject: Subject) -> Iterator[str]:
    """What else a document says: of decisions without meaning or group, of an unrecorded factor, of drift, of rates given true labels."""
    from fairaudit.reports.drift import standings
    from fairaudit.reports.hidden_context import declared
    from fairaudit.reports.undecided import undecided_lines
    from fairaudit.reports.unknown_groups import unknown_ranges
    from fairaudit.reports.verdicts import judged_targets

    yield from undecided_lines(found, subject)
    for one in unknown_ranges(found, {}):
        name = "the ratio within contexts" if one.quantity == "local" else "the ratio over all"
        yield f"Whoever the {one.amounts[0]} of {one.amounts[1]} decisions without a group are, {name} is {one.ends}."
    targets = [target for target, _ in judged_targets(found)]
    if any(target.under == HIDDEN for target in targets):
        yield from declared(found)
    drifting = {target.quantity for target in targets if target.under == DRIFTING}
    yield from (f"{one.title}: {one.lines[0]}." for one in standings(found, None, {}) if not one.radius and one.quantity in drifting)
    for key in ("equal_opportunity", "equalized_odds_true_label"):
        entry = found["metrics"].get(key) or found["metrics"].get(key + OVERALL)
        if entry is not None:
            witness = entry["witness"]
            where = f" within {named(witness['context'])}" if witness.get("context") else ""
            high, low = (rate_text(Value(number(rate))) for rate in witness["rates"])
            pair = f"{NAMES[witness['rate']]}{where} {high} for {named(witness['higher'])}, {low} for {named(witness['lower'])}"
            yield f"{NAMES[key][0].upper()}{NAMES[key][1:]}: {pair}, {approximate(number(entry['value']))} apart."
