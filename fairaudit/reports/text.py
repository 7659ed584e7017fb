"""A result as text for a terminal, in which labels from the input are data."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from decimal import ROUND_CEILING, ROUND_FLOOR, Decimal
from fractions import Fraction
from math import inf
from typing import TYPE_CHECKING, Any, Literal

from fairaudit.audits.document import document
from fairaudit.audits.drift import TableRadius
from fairaudit.audits.sentences import evaluation_of, pair_text, size_text
from fairaudit.certificates.entries import change_assumptions
from fairaudit.certificates.reader import Subject
from fairaudit.errors import shown
from fairaudit.exact.extended import Extended
from fairaudit.exact.rationals import rational_text
from fairaudit.measures.expectations import cell_expectation
from fairaudit.measures.limits import Quantity, limit_text
from fairaudit.measures.rates import KINDS, NAMES, OVERALL
from fairaudit.measures.ratios import Ratio, Witness
from fairaudit.model.mechanism import Mechanism
from fairaudit.privacy.epsilon_delta import exp_epsilon
from fairaudit.reports.difference_text import difference_rows, difference_target, differences
from fairaudit.reports.drift import updates_text
from fairaudit.reports.drift_text import ON_PAIRS, drifted_line, radius_lines
from fairaudit.reports.hidden_context_text import explained, hidden_target
from fairaudit.reports.hidden_factor import factors_text
from fairaudit.reports.lost_answers import lost_text
from fairaudit.reports.undecided import undecided_ranges, undecided_said
from fairaudit.reports.unknown_groups import unknown_ranges
from fairaudit.reports.words import REACH
from fairaudit.tables.preparation import said
from fairaudit.theorems.applicable import to_judge
from fairaudit.theorems.bound import THIS_LAW
from fairaudit.theorems.registry import BY_KEY, ONE_SIDED
from fairaudit.words import (
    DRIFTING,
    ENDS_CROSS,
    HIDDEN,
    THE_INTERVAL,
    THIS_TABLE,
    WHATEVER,
    WHOEVER,
    approximate,
    ends_text,
    noun,
    percent,
    place,
    plain,
    words_for,
)

if TYPE_CHECKING:
    from fairaudit.audits.result import Result
    from fairaudit.audits.sentences import Deciding
    from fairaudit.audits.targets import Target
    from fairaudit.inference.changes import Change
    from fairaudit.inference.interval import Interval
    from fairaudit.inference.rates import GivenTruth
    from fairaudit.model.law import Law
    from fairaudit.tables.preparation import Entry
    from fairaudit.tables.values import Label
    from fairaudit.theorems.supremum import Supremum
from fairaudit.theorems.t13_near import DriftRadius

__all__ = ["TWO_SIDED", "intervals", "prepared_text", "spelling_text", "summary", "verdict"]


SHOW_EXACT = 60  # characters of an exact number that still fit a line

SHOW_CELLS = 12  # small cells that a line names

SHOW_SPELLINGS = 5  # pairs of spellings that a line names

TWO_SIDED = "Two-sided (half the error on each side; may straddle a limit that the one-sided end decides)"

NOWHERE = Witness(None, {}, {}, (Fraction(1), Fraction(1)))


def summary(
    result: Result, top: int, written: Sequence[str], findings: Sequence[str] = (), *, two_sided: bool = False, completions: bool = False
) -> str:
    """Describe a result: the verdict, one sentence, the figures, what was found beside them, and what they do not say."""
    blocks = [
        spelling_text(result.spellings),
        verdict(result),
        plain(result.sentence),
        lost_text(evaluation_of(result), result.law),
        prepared_text(result.preparation),
        unknown_groups(result, completions=completions),
        undecided_text(result),
        updates_text(result) if completions else "",
        _figures(result),
        intervals(result),
        differences(result),
        explained(result),
        factors_text(result) if completions else "",
        two_sided_text(result) if two_sided else "",
        given_truth(result),
        "\n".join(findings),
        _filters(result),
        _before_and_after(result),
        _guaranteed(result),
        _assumed(result),
        _pairs(result, top),
        _constants(result),
        _not_compared(result),
        _limits(result),
    ]
    if written:
        blocks.append(written_text(written))
    return "\n\n".join(block for block in blocks if block)


def spelling_text(found: Sequence[dict[str, Any]]) -> str:
    """Labels that are counted apart and look like one."""
    lines = [f"SPELLINGS    {plain(text)}" for text in said({"spellings": found[:SHOW_SPELLINGS]})]
    if more := len(found) - SHOW_SPELLINGS:
        lines += [f"SPELLINGS    and {more} more, all in the certificate"] if more > 0 else []
    advice = "--fold-labels merges labels that differ in case, blanks or Unicode form alone; --map FILE merges any"
    return "\n".join([*lines, f"             {advice}"]) if lines else ""


def written_text(written: Sequence[str]) -> str:
    """Where a certificate is, with its table where that stands beside it, and how it is checked."""
    beside = f" --table {written[1]}" if len(written) > 1 else ""
    return f"Certificate: {plain(', '.join(written))}\nCheck it:    fairaudit verify {plain(written[0] + beside)}"


def prepared_text(preparation: Sequence[Entry]) -> str:
    """What was done to the log before it was counted."""
    lines = [f"  - {plain(text)}" for text in said({"preparation": preparation})]
    return "\n".join(["Before it was counted", *lines]) if lines else ""


def verdict(result: Result) -> str:
    """One line per target, or that there was none."""
    if not result.targets:
        return "NO TARGET was set; these are the exact figures of the table."
    lines = []
    for target, deciding, radius in zip(result.targets, result.deciding, result.drift_radii, strict=True):
        measured = result.local if target.quantity == "local" else result.global_
        said = difference_target(target, result) if target.unit == "difference" else _target(target, measured, result)
        lines.append(f"{target.verdict.upper():<13}{said}")
        if deciding is not None:
            lines.append(f"{'':<13}{_decided(deciding, result)}")
        if target.verdict == "inconclusive" and target.unit != "difference" and target.quantity in result.if_independent:
            lines += [f"{'':<13}{said}" for said in independence_text(*result.if_independent[target.quantity], target.unit)]
        if isinstance(radius, TableRadius):
            lines += [f"{'':<13}{said}" for said in radius_lines(radius, target.quantity)]
        elif radius is None and target.confidence is not None and result.drift_is_not_given(target):
            lines.append(f"{'':<13}{ON_PAIRS}")
        elif radius is not None and measured is not None:
            lines += [f"{'':<13}{said}" for said in [drift_text(radius)] if said]
    return "\n".join(lines)


def _target(target: Target, measured: Ratio | None, result: Result) -> str:
    interval, units = result.intervals.get(target.quantity), result.law.units
    said = limit_text(target.quantity, target.unit, target.limit)
    if measured is None:
        return f"{said}: nothing could be compared"
    if target.under == HIDDEN:
        return hidden_target(target, result)
    scopes = THIS_LAW if target.confidence is None else ONE_SIDED
    within = next((one for one in result.drifted if one.quantity == target.quantity and one.scope.startswith(scopes)), None)
    if target.under == DRIFTING and within is not None:
        sure = "" if target.confidence is None else f" (population, {percent(target.confidence)})"
        return f"{said}: {drifted_line(within, result.declared['max_drift'])}{sure}"
    value = approximate(measured.ratio) if target.unit == "ratio" else _log(measured)
    if target.under == WHOEVER:
        return f"{said}: {_whoever(target, value, result)}"
    if target.under == WHATEVER and target.confidence is None:
        own = next(one for one in result.whatever if one.quantity == target.quantity)
        low, high = _end(own.least, target.unit, up=False), _end(own.greatest, target.unit, up=True)
        return f"{said}: between {low} and {high}, {WHATEVER} ({value} at face value; this table)"
    if target.confidence is None:
        of = ", mean over rows" if units and units.repeated else ""
        return f"{said}: it is {value} (this table{of}, decided exactly)"
    if result.changed is not None and target.quantity in result.changed.withdrawn:
        return f"{said}: {_in_window(target, result.changed)}nothing is said of the whole stream ({value} in the table)"
    if target.upper is None:
        return f"{said}: nothing bounds the population ({value} in the table)"
    lower = interval.lower if interval else Fraction(1)
    upper, source = target.upper
    low, high = (_end(end, target.unit, up=up) for end, up in ((lower, False), (upper, True)))
    proved = "" if source == THE_INTERVAL else f", by {source}"
    if interval is not None and interval.ends == "each":
        ends = f"at least {low}, at most {high}{proved}, each at {percent(interval.confidence)}"
    else:
        ends = f"between {low} and {high}{proved}, at confidence {percent(target.confidence)}"
    crossed = "; the ends cross" if lower > upper else ""
    of, beside = "", f"{value} in the table"
    if interval is not None and interval.of_units is not None:
        of, beside = f"{interval.estimand} ", _both_means(measured, interval.of_units, target.unit)
    under = f", {WHATEVER}" if target.under == WHATEVER else ""
    return f"{said}: {of}{ends}{under} ({beside}){crossed}"


def _whoever(target: Target, value: str, result: Result) -> str:
    """Between which ends it is, whoever the decisions of unknown group are."""
    own = next(one for one in result.whoever if one.quantity == target.quantity)
    low, high = _end(own.least, target.unit, up=False), _end(own.greatest, target.unit, up=True)
    return f"between {low} and {high}, whoever the {own.unknown:,} of {own.of:,} without a group are ({value} among the others; this table)"


def unknown_groups(result: Result, *, completions: bool) -> str:
    """Between which ends the ratios are, whoever the decisions of unknown group are, and what tips a verdict."""
    groups: dict[tuple[str, ...] | None, list[Label]] = {None: [result.law.groups[a] for a in result.law.global_groups]}
    for x, a in zip(result.law.cell_context.tolist(), result.law.cell_group.tolist(), strict=True) if completions else ():
        groups.setdefault(result.law.contexts[x], []).append(result.law.groups[a])
    ranges = unknown_ranges(document(result), groups) if result.whoever else []
    lines = [plain(text) for found in ranges[:1] for text in [f"{found.opening}; whoever they are"]]
    for found in ranges:
        lines.append(f"  {found.quantity} ratio R {found.ends} ({found.labelled.decimal} among those with a group)")
        lines += [f"    {plain(text)}" for text in found.tips]
        for title, given in found.completions if completions else ():
            lines += [f"    {title}", *(f"      {plain(text)}" for text in given)]
    if ranges and not completions and any(found.greatest.value != found.least.value for found in ranges):
        lines.append("  --show-completions prints who they would have to be")
    return "\n".join(lines)


def undecided_text(result: Result) -> str:
    """Which decisions are undecided, and between which ends the ratios are whatever they meant."""
    if result.undecided is None:
        return ""
    found = document(result)
    lines = [plain(undecided_said(found, Subject(result.law, result.utility, result.deployment)))]
    for one in undecided_ranges(found):
        beside = f" ({one.face.decimal} at face value)" if one.face and one.of_table else ""
        lines.append(f"  {one.quantity} ratio R {one.ends}, {WHATEVER}, in {one.of}{beside}")
    return "\n".join(lines)


def _in_window(target: Target, change: Change) -> str:
    """Between which ends a ratio lies in the window that contradicts the stream, if it is that ratio that does."""
    if target.quantity != change.quantity:
        return ""
    part = change.part
    ends = " and ".join(_end(end, target.unit, up=up) for end, up in ((part.lower, False), (part.upper, True)))
    return f"between {ends} in window {change.window.number}, at confidence {percent(part.confidence)}; "


def _both_means(over_rows: Ratio, over_units: Ratio, unit: str) -> str:
    """The ratio of the sample as the mean over units, and over rows where that is another."""
    units, rows = (approximate(found.ratio) if unit == "ratio" else _log(found) for found in (over_units, over_rows))
    return f"{units} in the table" if over_units.ratio == over_rows.ratio else f"{units} in the table, and {rows} as mean over rows"


def _decided(deciding: Deciding, result: Result) -> str:
    """The pair of groups that decided a target, or what else did."""
    if deciding.pair is not None:
        return plain(f"{pair_text(deciding.pair)} {size_text(result.sizes_of(deciding.pair))}").rstrip()
    if deciding.by == ENDS_CROSS:
        return ENDS_CROSS
    if deciding.by in (THE_INTERVAL, THIS_TABLE):
        return "no pair of groups is apart" if deciding.value == 1 else "no interval is claimed"
    return f"every pair of groups, by {deciding.by}"


def independence_text(lower: Fraction, upper: Fraction | float, unit: str) -> tuple[str, str]:
    """What it would mean, and give, to declare the cells independent."""
    low, high = (_end(end, unit, up=up) for end, up in ((lower, False), (upper, True)))
    return (
        "if the decisions in different cells were drawn independently, as those on different persons are and those on the same profiles",
        f"with the group exchanged are not, --independent-cells says so, and the ends would be at least {low} and at most {high}",
    )


def drift_text(found: DriftRadius) -> str:
    """How far from this policy a verdict on it stands.

    Examples
    --------
    >>> drift_text(DriftRadius("within", Fraction(3, 35), always=False))
    'so is every policy within total variation 0.08571 (3/35) of this one, for each value that the filters release'
    """
    if found.always:
        return "so is every policy behind these filters" if found.verdict == "within" else "so does every policy behind these filters"
    if found.radius == 0:
        return (
            f"some policies as near to this one as one likes {'are not' if found.verdict == 'within' else 'do not'}" if found.exact else ""
        )
    exactly = f" ({found.radius})" if found.exact and found.radius.denominator < 10**6 else ""
    much = f"total variation {approximate(found.radius, 'down')}{exactly}"
    where = "for each value that the filters release"
    if found.verdict == "within":
        return f"so is every policy within {much} of this one, {where}"
    return f"so does every policy nearer to this one than {much}, {where}"


def _end(value: Fraction | float, unit: str, *, up: bool) -> str:
    """An end of an interval in the unit of a target."""
    if unit == "ratio" or value == inf:
        return approximate(value, "up" if up else "down")
    return _rounded(Ratio(value, NOWHERE).log[int(up)], up=up)


def _rounded(value: Decimal, *, up: bool) -> str:
    return "infinite" if value.is_infinite() else str(value.quantize(Decimal("1.0000"), ROUND_CEILING if up else ROUND_FLOOR))


def intervals(result: Result) -> str:
    """What the draws say of the population from which they come."""
    if not result.intervals:
        return ""
    under = "" if result.undecided is None else f", {WHATEVER}"
    lines = [f"In the population from which these decisions were drawn{under}", *_interval_rows(result.intervals)]
    each = [found for found in result.intervals.values() if found.ends == "each"]
    if len(result.intervals) == 2 and len({t.quantity for t in result.targets}) < 2:
        lines.append("  Each interval holds at its confidence by itself.")
    if each and len(result.targets) > 1:
        lines.append(f"  The verdicts on all targets hold together at confidence {percent(result.targets[0].confidence or 0)}.")
    lines += [f"  {target.quantity}: {planned.sentence}" for target, planned in result.further_draws]
    lines.append("  For you to judge")
    lines += [f"    - {plain(text)}" for text in dict.fromkeys(text for found in result.intervals.values() for text in found.assumptions)]
    return "\n".join(lines)


def two_sided_text(result: Result) -> str:
    """The intervals of ratios and differences with a target, with half of the error on each side."""
    rows = [
        *(_interval_rows(result.two_sided) if result.two_sided else []),
        *difference_rows(result.differences.two_sided if result.differences else {}),
    ]
    return "\n".join([TWO_SIDED, *rows]) if rows else ""


def _interval_rows(found: Mapping[Quantity, Interval]) -> list[str]:
    """A line for each interval."""
    rows = []
    for quantity, own in found.items():
        each = own.ends == "each"
        logs = ends_text(_rounded(own.log[0], up=False), _rounded(own.log[1], up=True), each=each)
        ends = ends_text(approximate(own.lower, "down"), approximate(own.upper, "up"), each=each)
        method = ", ".join((*own.methods, *(("half-split",) if "split" in own.evidence else ()))) or "nothing was drawn at random"
        of = "" if own.of_units is None else f", {own.estimand}"
        sure = f"{'each at' if each else 'at confidence'} {percent(own.confidence)} ({method})"
        rows.append((f"{quantity} ratio R{of}", ends, f"log R {logs}", sure))
    widths = [max(len(row[i]) for row in rows) for i in range(3)]
    return ["  " + "  ".join([*(cell.ljust(width) for cell, width in zip(row[:3], widths, strict=True)), row[3]]) for row in rows]


def given_truth(result: Result) -> str:
    """Rates of true and false positives, and how far apart they are, in the table and in the population."""
    given = result.given_truth
    if given is None:
        return ""
    positive = " or ".join(map(shown, given.positive.decision))
    column, label = shown(result.law.columns.truth), shown(given.positive.truth)
    lines = [f"Given the true label in column {column} (positive: decision {positive}, true label {label})"]
    for name, found in given.differences.items():
        if found is None:
            lines.append(f"  {NAMES[name]}: not compared")
            continue
        where = f"{_place(found.context)}: " if found.context else ""
        high, low = map(approximate, found.rates)
        sizes = " and ".join(map(approximate, found.draws))
        pair = f"{where}{NAMES[found.kind]} {high} for {_place(found.higher)}, {low} for {_place(found.lower)}; n = {sizes}"
        lines.append(f"  {NAMES[name]}: a difference of {approximate(found.value)} ({pair})")
        if interval := given.intervals.get(name):
            ends = f"between {approximate(interval.lower, 'down')} and {approximate(interval.upper, 'up')}"
            lines.append(f"    in the population {ends}, at confidence {percent(interval.confidence)} (binomial)")
    lines += _rates(result.law, given)
    if given.intervals:
        lines.append("  Each interval holds at its confidence by itself. For you to judge")
        texts = dict.fromkeys(text for interval in given.intervals.values() for text in interval.assumptions)
        lines += [f"    - {plain(text)}" for text in texts]
    return "\n".join(lines)


def _rates(law: Law, given: GivenTruth) -> list[str]:
    """The rates of each group over all contexts, and how many draws they are of."""
    names = [kind + (OVERALL if law.columns.context else "") for kind in KINDS]
    rates = [{rate.group: rate for rate in given.rates[name]} for name in names]
    rows = [("", *(NAMES[name] for name in names))]
    for a in sorted(set().union(*rates)):
        found = [by_group.get(a) for by_group in rates]
        said = [f"{approximate(r.value)} ({approximate(r.positives)} of {approximate(r.draws)})" if r else "no draws" for r in found]
        rows.append((_place(law.group_label(a)), *said))
    more = len(rows) - 1 - SHOW_CELLS
    widths = [max(len(row[i]) for row in rows) for i in range(2)]
    lines = ["  " + "  ".join([*(cell.ljust(width) for cell, width in zip(row, widths, strict=False)), row[2]]) for row in rows]
    return [*lines[: SHOW_CELLS + 1], *([f"  … and {more} more {noun(more, 'group')}, in the certificate"] if more > 0 else [])]


def _log(measured: Ratio) -> str:
    lo = measured.log[0]
    return "infinite" if lo.is_infinite() else f"{float(lo):.4f}"


def _exact(value: Fraction | float) -> str:
    if not isinstance(value, Fraction):
        return "infinite"
    text = rational_text((value.numerator, value.denominator))
    return text if len(text) <= SHOW_EXACT else f"(a fraction of {len(text)} characters; it is in the certificate)"


def _figures(result: Result) -> str:
    rows: list[tuple[str, str, str, str]] = [] if result.utility.signed else _ratio_rows(result)
    if result.differences is not None:
        rows.append(("", "difference", "", "" if rows else "exactly"))
        for quantity, apart in result.differences.measured.items():
            name = "greatest within a context (D)" if quantity == "local" else "greatest of group means"
            rows.append((name, approximate(apart.value), "", _exact(apart.value)) if apart else (name, "-", "", "not compared"))
    rows.append(("", "distance", "", ""))
    for name, distance in result.distances.items():
        if distance:
            rows.append((name, approximate(distance.value), "", _exact(distance.value)))
        else:
            rows.append((name, "-", "", "not compared"))
    widths = [max(len(row[i]) for row in rows) for i in range(3)]
    return "\n".join(
        f"{name.ljust(widths[0])}  {value.rjust(widths[1])}  {log.rjust(widths[2])}  {exact}".rstrip() for name, value, log, exact in rows
    )


def _ratio_rows(result: Result) -> list[tuple[str, str, str, str]]:
    """The ratios of the table, with and without filters."""
    rows: list[tuple[str, str, str, str]] = [("", "ratio R", "log R", "exactly")]
    over_units = result.intervals["local"].of_units if "local" in result.intervals else None
    if over_units is not None and result.local is not None and over_units.ratio == result.local.ratio:
        over_units = None
    for name, ratio in (
        ("local fairness (worst within a context)", result.local),
        *([("the same, as mean over units", over_units)] if over_units else []),
        ("global fairness (worst of group means)", result.global_),
        ("worst over group-blind utilities, local", result.local_supremum),
        ("worst over group-blind utilities, global", result.global_supremum),
    ):
        if ratio:
            rows.append((name, approximate(ratio.ratio), _log(ratio), _exact(ratio.ratio)))
        else:
            rows.append((name, "-", "-", "not compared"))
    if result.deployment is not None:
        for name, ratio in zip(("local", "global"), result.unfiltered or (None, None), strict=True):
            title = f"{name} fairness without the filters"
            if ratio:
                rows.append((title, approximate(ratio.ratio), _log(ratio), _exact(ratio.ratio)))
            else:
                rows.append((title, "-", "-", "the policy lacks a true context or group"))
    return rows


def _filters(result: Result) -> str:
    if result.deployment is None:
        return ""
    lines = []
    for name, mechanism in (("group", result.deployment.group_filter), ("context", result.deployment.context_filter)):
        if mechanism is None:
            lines.append(f"No {name} filter: the policy sees the true {name}.")
            continue
        factor = exp_epsilon(mechanism)
        epsilon = "infinite" if factor == inf else f"{float(Ratio(factor, NOWHERE).log[0]):.4f}"
        line = f"The {name} filter is ε-private with ε = {epsilon} (e^ε = {_exact(factor)})"
        if len(mechanism.factors) > 1:
            each = ", ".join(_exact(exp_epsilon(Mechanism((part,)))) for part in mechanism.factors)
            line += f"; this is the ε of the whole tuple, of single attributes e^ε is {each}"
        lines.append(line + ".")
    return "\n".join(lines)


def _before_and_after(result: Result) -> str:
    """What each group gets without and with the filters: equal may mean worse for everybody."""
    before = result.unfiltered_expectations
    if before is None:
        return ""
    law = result.law
    lines = [f"{words_for(burden=result.burden).amount.capitalize()} without and with the filters"]
    changes = [(before[cell], Fraction(*cell_expectation(law, result.utility, cell)), cell) for cell in range(len(before))]
    changes.sort(key=lambda change: -abs(change[1] - change[0]))
    for was, now, cell in changes[:SHOW_CELLS]:
        x, a = int(law.cell_context[cell]), int(law.cell_group[cell])
        where = f"{_place(law.context_label(x))}: " if law.contexts[x] else ""
        lines.append(f"  {approximate(was):>8} -> {approximate(now):<8}  {where}{_place(law.group_label(a))}")
    if len(changes) > SHOW_CELLS:
        lines.append(f"  … and {len(changes) - SHOW_CELLS} smaller changes")
    worse = sum(now < was for was, now, _ in changes)
    verb = "bear" if result.burden else "get"
    lines.append(f"  {worse} of {len(changes)} combinations of context and group {verb} less with the filters than without.")
    return "\n".join(lines)


def _guaranteed(result: Result) -> str:
    """What is guaranteed behind the filters, from this policy to any: a line for each scope, and more where more was asked for."""
    lines = []
    for quantity, measured in (("local", result.local), ("global", result.global_)):
        found = sorted(_guarantees(result, quantity), key=lambda line: (line.reach, line.value, line.why))
        if measured is None or not found:
            continue
        where = "within contexts" if quantity == "local" and result.columns.context else "overall" if quantity == "global" else ""
        lines.append(" ".join(["Guaranteed", *([where] if where else []), "behind these filters, ratio R (log R)"]))
        known = [_Guarantee(0, measured.ratio, "the figure itself"), *found]
        lines += [f"  {approximate(at.value, at.rounding):>8}  {_logarithm(at.value):>10}  {REACHES[at.reach]}: {at.why}" for at in known]
    if lines:
        suprema = [text for found in result.suprema for text in found.assumptions]
        judge = dict.fromkeys([*(text for bound in result.bounds for text in to_judge(bound)), *suprema])
        confirmed = dict.fromkeys(text for bound in result.bounds for text in bound.assumptions if text not in judge)
        for title, texts in (("Confirmed by the table and the filters", confirmed), ("For you to judge", judge)):
            if texts:
                lines += [title, *(f"  - {plain(text)}" for text in texts)]
    return "\n".join(lines)


@dataclass(frozen=True)
class _Guarantee:
    """A line: how far it reaches, the ratio, and why; what is only an upper bound is rounded up."""

    reach: int
    value: Extended
    why: str
    rounding: Literal["nearest", "up"] = "nearest"


REACHES = tuple(REACH.values())


def _guarantees(result: Result, quantity: str) -> Iterator[_Guarantee]:
    """What is known of a ratio behind filters besides the figure itself."""
    places = {scope: i for i, scope in enumerate(REACH)}
    for bound in result.bounds:
        if bound.quantity == f"{quantity}_ratio":
            how = BY_KEY[bound.quantity, "<=", bound.theorem, bound.scope].how
            yield _Guarantee(places[bound.scope], bound.value, f"{how} ({bound.theorem})", "up")
    for found in result.suprema:
        if found.quantity == quantity:
            yield _Guarantee(places[found.scope], found.value, f"{_attained(found, result)} (T13)", "nearest" if found.exact else "up")


def _attained(found: Supremum, result: Result) -> str:
    """Where the greatest ratio of the policies of a scope is attained."""
    if not found.exact:
        return "at most"
    if found.higher is None or found.lower is None:
        return "none of them treats groups unequally"
    columns = result.columns
    where = "" if found.context is None or not columns.context else f"{_place(dict(zip(columns.context, found.context, strict=True)))}: "
    high, low = (_place(dict(zip(columns.group, label, strict=True))) for label in (found.higher, found.lower))
    if found.value == inf:
        gets = "bears" if result.burden else "gets"
        return f"{where}one of them leaves {low} with nothing where {high} {gets} something"
    return f"exactly the worst of them, {where}{high} over {low}"


def _logarithm(value: Extended) -> str:
    return "infinite" if value == inf else f"{float(Ratio(value, NOWHERE).log[1]):.4f}"


def _assumed(result: Result) -> str:
    """What claims rest on besides what stands beside intervals and bounds."""
    intervals: tuple[Any, ...] = (*result.intervals.values(), *(result.given_truth.intervals.values() if result.given_truth else ()))
    intervals = (*intervals, *(result.differences.intervals.values() if result.differences else ()))
    listed = (*intervals, *result.bounds, *result.suprema)
    said = {text for found in listed for text in found.assumptions}
    needed = [*(claim.assumptions for claim in result.claims), change_assumptions(result.changed) if result.changed else ()]
    rest = dict.fromkeys(text for texts in needed for text in texts if text not in said)
    return "\n".join(["For you to judge", *(f"  - {plain(text)}" for text in rest)]) if rest else ""


def _pairs(result: Result, top: int) -> str:
    lines = []
    ranked = result.most_unequal_pairs(top)
    for title, measures in (("Most unequal within a context", ranked["local"]), ("Most unequal group means", ranked["global"])):
        entries = [_pair(measured, result) for measured in measures if measured.ratio != 1]
        if entries:
            lines.append(title + "\n" + "\n".join(f"  {entry}" for entry in entries))
    return "\n".join(lines)


def _pair(measured: Ratio, result: Result) -> str:
    witness = measured.witness
    high, low = (approximate(v) for v in witness.expectations)
    where = f"{_place(witness.context)}: " if witness.context else ""
    sizes = size_text(result.sizes_of(witness))
    size = f" {sizes}" if sizes else ""
    return f"{approximate(measured.ratio):>8}  {where}{_place(witness.higher)} {high}, {_place(witness.lower)} {low}{size}"


def _place(labels: dict[str, str]) -> str:
    return plain(place(labels))


def _constants(result: Result) -> str:
    utility = result.utility
    tau = "undefined" if result.tau is None else approximate(result.tau)
    blind = (
        ""
        if utility.by_decision or not utility.depends_on_group
        else f", differs between groups by up to {approximate(utility.lipschitz())}"
    )
    name = "Burden" if result.burden else "Utility"
    return f"{name}: from {approximate(utility.m)} to {approximate(utility.gamma)}{blind}; least expected value {tau}"


def _not_compared(result: Result) -> str:
    if not result.not_compared:
        return ""
    lines = [f"Not compared ({len(result.not_compared)}):"]
    for entry in result.not_compared[:10]:
        what: Any = []
        if "context" in entry:
            what.append(_place(entry["context"]) or "the only context")
        if "groups" in entry:
            groups = [_place(group) for group in entry["groups"][:5]]
            what.append("; ".join(groups) + (f" and {len(entry['groups']) - 5} more" if len(entry["groups"]) > 5 else ""))
        if "quantity" in entry:
            what.append(NAMES.get(entry["quantity"], f"{entry['quantity']} fairness"))
        lines.append(f"  {', '.join(what)}: {entry['reason']}")
    if len(result.not_compared) > 10:
        lines.append(f"  … and {len(result.not_compared) - 10} more, all in the certificate")
    return "\n".join(lines)


def _limits(result: Result) -> str:
    said = []
    if result.intervals or (result.differences and result.differences.intervals):
        said.append("The figures above the intervals describe this table; small counts vary by chance, as the intervals show.")
    elif (result.deployment.policy.law if result.deployment else result.law).kind == "counts":
        said.append("It describes this table, not the population behind it: small counts vary by chance, and no interval is claimed.")
    else:
        said.append("It takes the probabilities in the table as given.")
    if result.law.population == "equal" and result.global_ is not None and len(result.law.contexts) > 1:
        named = "[population]" if result.deployment else "--weight"
        said.append(f"No population was given ({named}): the global figures weigh all contexts equally.")
    said.append("It does not say that the table is genuine, complete or representative, nor why groups differ.")
    if not result.burden:
        said.append("The utility is taken for a benefit; if it counts a burden, say so with --burden.")
    return "What this does not say\n" + "\n".join(f"  {line}" for line in said)
