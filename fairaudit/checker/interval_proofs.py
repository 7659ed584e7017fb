"""Whether the evidence of an interval proves it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from fractions import Fraction
from itertools import chain, combinations

from .betting import StreamProof
from .boxes import prove_by_box
from .figures import Greatest
from .intervals import BETTING, BoxEvidence, Interval, Proven, StreamEvidence, Unproven
from .ladders import prove_by_ladders
from .logarithms import log_enclosure
from .rationals import ONE, Rational, as_pair, at_most, reduced, widest_ratio
from .samples import Sampling
from .table import Table
from .tails import Sample
from .text import shown
from .work import spend


def prove_interval(interval: Interval, table: Table) -> Proven:
    """Make sure that the evidence of an interval proves it."""
    if interval.limits is not None:
        low, high = interval.limits
        values = {g for utility in {cell.utility for cell in table.cells} for g in utility if g is not None}
        if not all(low <= Fraction(*g) <= high for g in values):
            raise Unproven("a utility in the table is outside the limits")
    if isinstance(interval.evidence, StreamEvidence):
        StreamProof(interval, interval.evidence, table).prove()
        return Proven(interval.ratio, 1 - Fraction(*interval.confidence), interval.scope, BETTING)
    sampling = Sampling(interval, table)
    if table.header.subject.kind == "probabilities" or (table.policy is not None and interval.units is not None):
        raise Unproven("the table is not of the stated kind")
    comparison = sampling.of_counts() if table.policy is None else sampling.of_policy(table.policy)
    samples, blocks = comparison.samples, comparison.blocks
    if not blocks:
        raise Unproven("the table does not give this quantity")
    if interval.measured is not None:
        _check_measured(interval.measured, samples, table)
    if interval.independent and comparison.shared:
        raise Unproven("samples that share draws are not independent")
    if not at_most(ONE, interval.ratio[0]) or not at_most(ONE, interval.ratio[1]):
        raise Unproven("no ratio is less than 1")
    supports = [[frozenset(i for i in form if samples[i].informative) for form, _ in block] for block in blocks]
    used: frozenset[int] = frozenset().union(*chain.from_iterable(supports))
    spend(sum(len(block) * sum(4 + len(support) for support in block) for block in supports))
    if isinstance(interval.evidence, BoxEvidence):
        spanned = max(len(one | other) for block in supports for one, other in combinations(block, 2))
        prove_by_box(interval, interval.evidence, comparison, len(used), spanned)
    else:
        prove_by_ladders(interval, interval.evidence, comparison, len(used))
    by = "binomial" if all(samples[i].binary for i in used) else interval.method
    return Proven(interval.ratio, 1 - Fraction(*interval.confidence), interval.scope, by)


def _check_measured(stated: Mapping[str, object], samples: Sequence[Sample], table: Table) -> None:
    """Make sure that the ratio of the means over units is stated as the units of the local interval give it."""
    means = iter([as_pair(sample.total / sample.draws) for sample in samples])
    found = Greatest[Rational](widest_ratio, lambda left, right: {"expectations": [reduced(*left), reduced(*right)]})
    for cells in table.by_context():
        if len(cells) > 1:
            found.offer([next(means) for _ in cells], [cell.group for cell in cells], cells[0].context)
    actual = found.maximum(table.header)
    expected = None if actual is None else {"ratio": actual.value, "log": log_enclosure(actual.value), "witness": actual.witness}
    if actual is None or stated != expected:
        raise Unproven("measured is not what the units give" + ("" if actual is None else f": {shown(actual.value)}"))
