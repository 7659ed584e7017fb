"""Whether the evidence of an interval proves it, and whether a window of a stream contradicts the stream."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from fractions import Fraction
from itertools import chain, combinations

from .claims import BETTING, CONTRASTS, PAIR_EXACT, PAIRED_BETTING, WHATEVER
from .contrasts import prove_by_contrasts
from .difference_contrasts import prove_difference_by_contrasts
from .difference_regions import prove_difference_by_box, prove_difference_by_pairs
from .figures import Greatest
from .header import Cell
from .intervals import (
    Boxed,
    BoxEvidence,
    Change,
    ContrastEvidence,
    Ends,
    Interval,
    PairEvidence,
    Proven,
    StreamEvidence,
    UnitEvidence,
    Unproven,
)
from .joint_betting import prove_stream
from .logarithms import log_enclosure
from .meanings import Undecided, valued
from .paired_betting import prove_by_units
from .passing import PassingBox
from .rates import DIFFERENCES, Share
from .rationals import ONE, Rational, as_pair, at_most, bits_of, reduced, widest_gap, widest_ratio
from .regions import prove_by_box, prove_by_ladders, prove_by_pairs
from .rows import read_table
from .samples import Comparison, Sampling
from .split import names_of_cells
from .table import Table, is_signed, place_of
from .tails import Sample
from .text import Finding, compared, finding_of, malformed, shown
from .work import spend, working_on


def _prove_interval(interval: Interval, table: Table, passed: PassingBox | None = None) -> Proven:
    """Make sure that the evidence of an interval proves it, the cells of the table having passed or being kept."""
    _check_limits(interval, table)
    _check_sign(interval, table)
    if isinstance(interval.evidence, StreamEvidence):
        prove_stream(interval, interval.evidence, table)
        return Proven(interval.ratio, 1 - Fraction(*interval.confidence), interval.scope, BETTING)
    _check_kind(interval, table)
    if passed is not None:
        return passed.proven()
    comparison = _compared(interval, table)
    samples, blocks = comparison.samples, comparison.blocks
    if not blocks:
        raise Unproven("the table does not give this quantity")
    if interval.measured is not None:
        _check_measured(interval.measured, samples, table, interval.difference)
    if interval.independent and comparison.shared:
        raise Unproven("samples that share draws are not independent")
    informative = [sample.informative for sample in samples]
    used = {i for block in blocks for form, _ in block for i in form if informative[i]}
    boxes: tuple[Ends, Ends] | None = None
    if isinstance(interval.evidence, BoxEvidence):
        spanned = max(_spanned([[i for i in form if informative[i]] for form, _ in block]) for block in blocks)
        if interval.difference:
            prove_difference_by_box(interval, interval.evidence, comparison, len(used), spanned)
        else:
            boxes = prove_by_box(interval, interval.evidence, comparison, len(used), spanned)
    elif isinstance(interval.evidence, PairEvidence):
        if interval.difference:
            prove_difference_by_pairs(interval, interval.evidence, comparison)
        else:
            names = [] if interval.evidence.seed is None else names_of_cells(interval.quantity, table)
            prove_by_pairs(interval, interval.evidence, comparison, names)
        return Proven(interval.ratio, 1 - Fraction(*interval.confidence), interval.scope, PAIR_EXACT, interval.each)
    elif isinstance(interval.evidence, ContrastEvidence | UnitEvidence):
        by = _prove_by_bets(interval, interval.evidence, comparison, table)
        return Proven(interval.ratio, 1 - Fraction(*interval.confidence), interval.scope, by, interval.each)
    elif interval.difference:
        raise Unproven("a product is for ratios only")
    else:
        prove_by_ladders(interval, interval.evidence, comparison, len(used))
    by = "binomial" if all(samples[i].binary for i in used) else interval.method
    boxed = None if boxes is None or table.policy is not None else _boxed(interval, samples, boxes)
    return Proven(interval.ratio, 1 - Fraction(*interval.confidence), interval.scope, by, interval.each, boxed)


def prove_whatever(interval: Interval, table: Table, undecided: Undecided) -> Proven:
    """Make sure that the ends of means prove an interval whatever undecided decisions meant (T19).

    Lower ends have to hold of the draws with each of them worth the least, and upper ones with each worth the most.
    """
    if not isinstance(interval.evidence, BoxEvidence) or interval.difference:
        raise Unproven("decisions of unknown meaning need a box of the ends of means")
    tables = [table, *(valued(table, undecided, worth) for worth in (undecided.least, undecided.most))]
    for own in tables:
        _check_limits(interval, own)
    _check_sign(interval, table)
    _check_kind(interval, table)
    if interval.limits is None and any(None in cell.utility for cell in table.cells):
        raise Unproven("the range of a utility that is not given everywhere has to be declared")
    face, low, high = (_compared(interval, own) for own in tables)
    if not face.blocks:
        raise Unproven("the table does not give this quantity")
    if interval.measured is not None:
        _check_measured(interval.measured, face.samples, table, interval.difference)
    if interval.independent and face.shared:
        raise Unproven("samples that share draws are not independent")
    informative = [any(sample.informative for sample in samples) for samples in zip(low.samples, high.samples, strict=True)]
    used = {i for block in face.blocks for form, _ in block for i in form if informative[i]}
    spanned = max(_spanned([[i for i in form if informative[i]] for form, _ in block]) for block in face.blocks)
    prove_by_box(interval, interval.evidence, low, len(used), spanned, high.samples)
    return Proven(interval.ratio, 1 - Fraction(*interval.confidence), f"{interval.scope}, {WHATEVER}", "T19", interval.each)


def _compared(interval: Interval, table: Table) -> Comparison:
    """The samples of a table, and what is compared."""
    sampling = Sampling(interval, table)
    return sampling.of_counts() if table.policy is None else sampling.of_policy(table.policy)


def _check_limits(interval: Interval, table: Table) -> None:
    """Make sure that no utility is outside the declared limits."""
    if interval.limits is not None:
        low, high = interval.limits
        common = table.header.utility
        utilities = {tuple(cell.utility) for cell in table.cells} if common is None else {common}
        values = {g for utility in utilities for g in utility if g is not None}
        if not all(low <= Fraction(*g) <= high for g in values):
            raise Unproven("a utility in the table is outside the limits")


def _check_kind(interval: Interval, table: Table) -> None:
    """Make sure that there are draws, and that no ratio is less than 1."""
    if table.header.subject.kind == "probabilities" or (table.policy is not None and interval.units is not None):
        raise Unproven("the table is not of the stated kind")
    if not interval.difference and not (at_most(ONE, interval.ratio[0]) and at_most(ONE, interval.ratio[1])):
        raise Unproven("no ratio is less than 1")


def _boxed(interval: Interval, samples: Sequence[Sample], boxes: tuple[Ends, Ends]) -> Boxed | None:
    """List the ends of single cells, where both ends of a ratio rest on them, each by itself, and rows are drawn."""
    if not interval.each or interval.units is not None:
        return None
    spend(20 * len(samples))
    upper, lower = ([(Fraction(*low), Fraction(*high)) for low, high in ends] for ends in boxes)
    return Boxed(upper, lower, [(sample.low, sample.high) for sample in samples])


def _prove_by_bets(interval: Interval, evidence: ContrastEvidence | UnitEvidence, comparison: Comparison, table: Table) -> str:
    """Make sure that bets on contrasts prove an interval, and name them."""
    if isinstance(evidence, UnitEvidence):
        if interval.quantity != "local":
            raise Unproven("contrasts within units are for the local ratio only")
        prove_by_units(interval, evidence, comparison, table)
        return PAIRED_BETTING
    (prove_difference_by_contrasts if interval.difference else prove_by_contrasts)(interval, evidence, comparison)
    return CONTRASTS


def _spanned(supports: Sequence[Sequence[int]]) -> int:
    """The greatest number of samples that two forms rest on together."""
    spend(sum(4 + len(support) for support in supports))
    different = {frozenset(support) for support in supports}
    longest = max(map(len, different))
    if longest <= 1 or len(different) == 1:
        return min(2, len(different - {frozenset()})) * longest
    spend(len(different) * sum(4 + len(support) for support in different))
    return max(len(one | other) for one, other in combinations(different, 2))


def _check_sign(interval: Interval, table: Table) -> None:
    """Make sure that no ratio is bounded where expectations can be negative: it would depend on the origin."""
    signed = is_signed(table)
    if not interval.difference and (signed or (interval.limits is not None and interval.limits[0] < 0)):
        raise Unproven("utilities can be below 0, and ratios depend on the origin")
    if signed and interval.limits is None and table.header.utility is None:
        raise Unproven("the range of utilities that depend on more than the decision, and can be below 0, has to be declared")


def _check_measured(stated: Mapping[str, object], samples: Sequence[Sample], table: Table, difference: bool) -> None:
    """Make sure that the ratio, or the difference, of the means over units is stated as the units of the local interval give it."""
    means = iter([as_pair(sample.total / sample.draws) for sample in samples])
    widest = widest_gap if difference else widest_ratio
    found = Greatest[Rational](widest, lambda left, right: {"expectations": [reduced(*left), reduced(*right)]})
    for cells in table.by_context():
        if len(cells) > 1:
            found.offer([next(means) for _ in cells], [cell.group for cell in cells], cells[0].context)
    actual = found.maximum(table.header)
    expected: dict[str, object] = {}
    if actual is not None:
        expected = {"value": actual.value} if difference else {"ratio": actual.value, "log": log_enclosure(actual.value)}
        expected["witness"] = actual.witness
    if actual is None or stated != expected:
        raise Unproven("measured is not what the units give" + ("" if actual is None else f": {shown(actual.value)}"))


def check_intervals(
    stated: Mapping[str, Interval], table: Table, undecided: Undecided | None, passed: Mapping[str, PassingBox]
) -> tuple[list[Finding], dict[str, Proven]]:
    """Check the intervals of ratios and differences of expectations, and say what holds by those that are proven."""
    findings: list[Finding] = []
    proven: dict[str, Proven] = {}
    for name, interval in stated.items():
        fault = ""
        working_on(f"intervals.{name}")
        try:
            if interval.independent and any(isinstance(other.evidence, UnitEvidence) for other in stated.values()):
                raise Unproven("units were seen in several groups, whose draws are then not independent")
            for units in (other.units for other in stated.values() if other.units and other is not interval):
                if interval.units is not None:
                    if interval.units != units:
                        raise Unproven("the units are not those of the other local interval")
                elif any(sum(rows) > 1 for cell in units for _, rows in cell) or interval.independent:
                    raise Unproven("the units of the local interval are no independent draws of the groups")
            proven[name] = (
                _prove_interval(interval, table, passed.get(name)) if undecided is None else prove_whatever(interval, table, undecided)
            )
        except Unproven as error:
            fault = str(error)
        ends = " and ".join(map(shown, interval.ratio))
        how = f"a {interval.region} of {'independent' if interval.independent else 'dependent'} cells"
        how = "contrasts within units" if interval.region == "paired" else how
        sure = f"at confidence {shown(interval.confidence)}{' each' if interval.each else ''}"
        statement = f"intervals.{name}: between {ends} {sure}, by {how}"
        findings.append(finding_of(statement, not fault, fault))
    return findings, proven


def check_differences(
    stated: Mapping[str, Interval], intervals: Mapping[str, Interval], table: Table
) -> tuple[list[Finding], dict[str, Proven]]:
    """Check the intervals of differences of rates, which stand beside those of ratios, and say what holds by those that are proven."""
    findings: list[Finding] = []
    proven: dict[str, Proven] = {}
    for name, interval in stated.items():
        fault = ""
        try:
            if any(other.units is not None for other in intervals.values()):
                raise Unproven("the rows of one sampling unit are no independent draws given their true labels")
            lists = [] if table.given is None else [table.given.blocks(rate) for rate in DIFFERENCES[name]]
            if not lists or not all(lists):
                raise Unproven("the table does not give this quantity")
            _prove_rates(interval, [*chain.from_iterable(lists)])
            proven[name] = Proven(interval.ratio, 1 - Fraction(*interval.confidence), interval.scope, "binomial")
        except Unproven as error:
            fault = str(error)
        ends = " and ".join(map(shown, interval.ratio))
        statement = f"intervals.{name}: between {ends} at confidence {shown(interval.confidence)}"
        findings.append(finding_of(statement, not fault, fault))
    return findings, proven


def _prove_rates(interval: Interval, blocks: Sequence[Sequence[Share]]) -> None:
    """Make sure that the ends of all rates prove the interval of the greatest difference of two rates of one block."""
    shares = [*chain.from_iterable(blocks)]
    if any(number.denominator != 1 for share in shares for number in (share.draws, share.positives)):
        raise Unproven("the counts are not integers")
    counted = [(share.draws.numerator, share.positives.numerator) for share in shares]
    samples = [Sample(n, k, k, 0, 1, 1, binary=True) for n, k in counted]
    numbers = iter(range(len(samples)))
    comparison = Comparison(samples, [[({next(numbers): 1}, 1) for _ in block] for block in blocks], True, [])
    if isinstance(interval.evidence, BoxEvidence):
        prove_difference_by_box(interval, interval.evidence, comparison, len(samples), 2)


def check_change(change: Change, table: Table) -> tuple[list[Finding], Proven | None]:
    """Check that the window contradicts the stream, and say what holds of the window."""
    working_on("the window that contradicts the stream")
    names = chain(["changed.table.header"], (f"changed.table.rows[{i}]" for i in range(len(change.lines) - 1)))
    part = read_table((name, value, None) for name, value in zip(names, change.lines, strict=True))
    if part.header.log:
        raise malformed("changed.table.header", "names what the subject says of the log; the header of the whole table does so")
    findings = [
        compared("changed.table.sha256", change.digest, part.digest),
        compared("changed.table.cells", change.cells, part.rows * len(part.header.decisions)),
    ]
    fault, proven = "", None
    try:
        _check_part(part, table)
        stream, proven = _prove_interval(change.stream, table), _prove_interval(change.ratio, part)
        if change.stream.limits != change.ratio.limits or change.stream.region != change.ratio.region:
            raise Unproven("the window has another range, or another region, than the stream")
        if at_most(stream.ratio[0], proven.ratio[1]) and at_most(proven.ratio[0], stream.ratio[1]):
            raise Unproven("the two intervals have a ratio in common")
        if change.confidence > 1 - stream.error - change.window**2 * proven.error:
            raise Unproven("the intervals of the stream and of the windows do not hold together at this confidence")
    except Unproven as error:
        fault, proven = str(error), None
    ends = [" and ".join(map(shown, interval.ratio)) for interval in (change.ratio, change.stream)]
    statement = f"changed: the {change.quantity} ratio is between {ends[0]} in window {change.window}, between {ends[1]} in the stream"
    findings.append(finding_of(statement, not fault, fault))
    return findings, proven


def _check_part(part: Table, whole: Table) -> None:
    """Make sure that a window is part of a stream: the same columns, decisions and utility, and in no cell more decisions."""
    one, other = part.header, whole.header
    if one.subject != other.subject or one.decisions != other.decisions or one.utility is None or one.utility != other.utility:
        raise Unproven("the window has other columns, decisions or utilities than the stream")
    counts = {(whole.header.contexts[cell.context], whole.header.groups[cell.group]): _counts(cell) for cell in whole.cells}
    for cell in part.cells:
        listed = counts.get((part.header.contexts[cell.context], part.header.groups[cell.group]))
        if listed is None or any(n > m for n, m in zip(_counts(cell), listed, strict=True)):
            raise Unproven(f"the window has more decisions than the stream {place_of(part, cell)}")


def _counts(cell: Cell) -> list[Fraction]:
    weights, total = cell.law
    spend(40 * len(weights), total.bit_length(), bits_of(Fraction(*cell.mass)))
    return [Fraction(*cell.mass) * weight / total for weight in weights]
