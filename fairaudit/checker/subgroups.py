"""A certificate of the most unequal subgroups, against the rows of its table."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import replace
from fractions import Fraction
from functools import cached_property, cmp_to_key
from itertools import chain

from .conjunctions import (
    Conjunction,
    SubgroupTable,
    conditions_of,
    embedded_lines,
    every_set,
    lines_of_subgroups,
    none_reaches,
    reaches,
    read_subgroup_table,
)
from .preparation import check_log_digests, check_steps, left_out
from .rationals import INFINITY, ONE, Rational, as_pair, at_most, maximum, reduced, written
from .sentences import CHOSEN_BEFOREHAND, INDEPENDENT_ROWS, RANGE
from .subgroup_statement import THIS_TABLE, Ends, Stated, StatedClaim, read_stated
from .summary import NAMES, assumed_for, said_of_figure, said_of_table, said_of_target
from .tails import Sample, fault_of_ends
from .text import (
    Counted,
    Finding,
    Incomplete,
    Outline,
    Report,
    TableNeeded,
    compared,
    compared_file,
    finding_of,
    malformed,
    printable,
    shown,
)
from .work import keep, spend, working_on

LAST_WAYS = 1 << 256  # a number of conjunctions beyond which nobody counts


def check_subgroups(document: object, lines: Iterable[bytes] | None) -> Report:
    """Check every statement of a certificate of this format."""
    stated = read_stated(document)
    working_on("the table")
    if stated.embedded is None and lines is None:
        raise TableNeeded("The certificate does not embed its table; the file of the table has to be given: add --table FILE.")
    table = read_subgroup_table(lines_of_subgroups(lines or ()) if stated.embedded is None else embedded_lines(stated.embedded))
    working_on("the subgroups")
    checked = _Checked(stated, table)
    findings: list[Finding] = []
    if stated.embedded is not None and lines is not None:
        findings.append(compared_file(lines, table.digest))
    findings += [*checked.subject(), *checked.search(), *checked.population(), *checked.claims(), *checked.targets()]
    counted = Counted(table.digest, "decisions", (checked.everybody[0], 1), stated.cells, left_out(stated.preparation))
    report = Report(tuple(findings), stated.verdict, counted=counted)
    if not report.ok:
        return report
    _check_assumptions(stated, table)
    return replace(report, outline=_outline(stated))


def _outline(stated: Stated) -> Outline:
    """Say in short what is stated."""
    name = NAMES["subgroup"]
    return Outline(
        said_of_table(stated.cells, embedded=stated.embedded is not None),
        tuple(said_of_target(name, "ratio", limit, judged, verdict) for limit, judged, verdict in stated.targets),
        (
            said_of_figure(
                name,
                stated.found[0].ratio,
                [(claim.scope, claim.relation, claim.value) for claim in stated.claims if claim.scope != THIS_TABLE],
            ),
        ),
        assumed_for((claim.scope, claim.assumptions) for claim in stated.claims),
    )


Reached = tuple[Rational, int, int, int, Conjunction]  # the ratio, how many rows, what they get, the same by value, and which they are


class _Checked:
    """What the table says of a certificate, step by step."""

    def __init__(self, stated: Stated, table: SubgroupTable) -> None:
        self.stated, self.table = stated, table
        counts = [0] * len(table.values)
        places = {value: i for i, value in enumerate(table.values)}
        for (_, worth), n in zip(table.decisions, table.by_decision, strict=True):
            counts[places[worth[0] * (table.unit // worth[1])]] += n
        self.everybody = sum(counts), table.total(counts)
        self.depth = min(stated.depth, len(table.sizes))
        self.lower, self.upper = ONE, INFINITY  # what is proved of the population
        self.true: dict[int, tuple[int, int]] = {}  # of the findings, as counted: how many rows they have, and what these get
        self.all: list[tuple[Conjunction, int, int]] = []  # the family, where it is listed

    def subject(self) -> Iterator[Finding]:
        """Compare what the certificate is about."""
        stated, table = self.stated, self.table
        yield compared("subject.table.sha256", stated.digest, table.digest)
        yield compared("subject.table.cells", stated.cells, table.lines * len(table.decisions))
        yield compared("subject.columns", (stated.decision, stated.attributes), (table.decision, table.attributes))
        yield from check_log_digests(stated.log_digests, table.log)
        yield from check_steps(
            stated.preparation,
            {
                table.decision: [label for label, _ in table.decisions],
                **dict(zip(table.attributes, map(list, table.labels), strict=True)),
            },
            self._amounts,
            (self.everybody[0], 1),
        )
        n, total = self.everybody
        yield compared("overall", stated.overall, (n, reduced(total, table.unit)))
        if stated.share is not None:
            least = -(-stated.share[0] * n // stated.share[1])
            yield compared("family.least_rows, for the share that was asked for,", stated.least, least)
        yield compared("family.conjunctions", stated.family, (self._ways(), 1))

    def _ways(self) -> int:
        """How many conjunctions there are, whether rows have them or not."""
        ways = [1] + [0] * self.depth
        for size in self.table.sizes:
            for k in range(self.depth, 0, -1):
                spend(2, ways[k].bit_length())
                ways[k] += ways[k - 1] * size
        return sum(ways[1:])

    def _amounts(self, column: str) -> Mapping[str, Rational]:
        """How many rows have each label of a column."""
        table = self.table
        found: dict[str, int] = {}
        if column == table.decision:
            for (label, _), n in zip(table.decisions, table.by_decision, strict=True):
                found[label] = found.get(label, 0) + n
        else:
            at = table.attributes.index(column)
            for own, counted in every_set(table, 1):
                if own == (at,):
                    found = {table.labels[at][key]: sum(table.unpacked(packed)) for key, packed in counted.items()}
        return {label: (n, 1) for label, n in found.items()}

    def search(self) -> Iterator[Finding]:
        """Count every conjunction again, and see that the frontier and the list are what the search has to find."""
        stated, table = self.stated, self.table
        met = labels_met = 0
        wrong: list[str] = []
        reached: list[Reached] = []
        for own, counted in every_set(table, self.depth):
            spend((4 + 2 * len(table.values)) * len(counted))
            each = 60 + 12 * len(table.values) + 6 * len(own)
            labels_met += len(counted) if len(own) == 1 else 0
            for key, packed in counted.items():
                counts = table.unpacked(packed)
                rows = sum(counts)
                if rows < stated.least:
                    continue
                spend(each, table.values[-1].bit_length())
                conditions, total = conditions_of(key, own, table.sizes), table.total(counts)
                proper = rows < self.everybody[0]
                if stated.ends is not None and proper:
                    keep(4)
                    self.all.append((conditions, rows, total))
                if any(conditions[:k] in stated.frontier for k in range(1, len(conditions))):
                    continue
                if proper and reaches(rows, total, self.everybody, stated.limit):
                    keep(8)
                    reached.append((self._ratio(rows, total), rows, total, packed, conditions))
                if len(own) < self.depth and own[-1] < len(table.sizes) - 1:
                    met += conditions in stated.frontier
                    wrong += filter(None, [self._fault_at(conditions, counts)])
        if labels_met < sum(table.sizes):
            wrong.append("a label of the table occurs in no row")
        if met < len(stated.frontier):
            wrong.append(f"{len(stated.frontier) - met} of its conjunctions are none at which a search ends")
        yield finding_of(f"frontier: {len(stated.frontier)} conjunctions, below {shown(stated.limit)}", not wrong, "; ".join(wrong[:3]))
        yield from self._compare_found(reached)

    def _fault_at(self, conditions: Conjunction, counts: tuple[int, ...]) -> str:
        """Say what is wrong where the search has to end, or has to go on."""
        limit, listed = self.stated.limit, self.stated.frontier.get(conditions)
        if not none_reaches(counts, self.table.values, self.everybody, self.stated.least, limit):
            return "" if listed is None else f"a refinement of {self._said(conditions)} may reach {shown(limit)}"
        if listed is None:
            return f"{self._said(conditions)} is missing, no refinement of which reaches {shown(limit)}"
        return "" if listed == counts else f"{self._said(conditions)} has the counts {shown(list(counts))}"

    def _said(self, conditions: Conjunction) -> str:
        return shown(self._labels(conditions))

    def _labels(self, conditions: Conjunction) -> dict[str, str]:
        return {self.table.attributes[a]: self.table.labels[a][v] for a, v in conditions}

    def _ratio(self, rows: int, total: int) -> Rational:
        own, rest = total * (self.everybody[0] - rows), (self.everybody[1] - total) * rows
        return ONE if own == rest else reduced(max(own, rest), min(own, rest))

    def _compare_found(self, reached: list[Reached]) -> Iterator[Finding]:
        """Put in order what reaches the limit, of conjunctions with the same rows the first, and compare it with the list."""
        spend(60 * len(reached) * (1 + len(reached).bit_length()), self.everybody[1].bit_length())
        reached.sort(key=lambda entry: (len(entry[4]), entry[4]))
        reached.sort(key=cmp_to_key(_more_unequal))
        actual: list[tuple[Rational, int, int, Conjunction, list[Conjunction]]] = []
        alike: dict[int, list[int]] = {}
        rows_of: dict[int, list[int]] = {}
        for ratio, rows, total, packed, conditions in reached:
            same = None
            for i in alike.get(packed, ()):
                if i not in rows_of:
                    spend(2 * len(self.table.entries) * len(actual[i][3]))
                    rows_of[i] = self._entries(actual[i][3])
                spend(2 * len(conditions))
                if all(self._has(key, conditions) for key in rows_of[i]):
                    same = i
                    break
            if same is not None:
                actual[same][4].append(conditions)
            elif len(actual) < len(self.stated.found):
                alike.setdefault(packed, []).append(len(actual))
                actual.append((ratio, rows, total, conditions, []))
        for i, one in enumerate(self.stated.found):
            if i >= len(actual):
                yield finding_of(f"findings[{i}]", False, f"nothing else reaches {shown(self.stated.limit)}")
                continue
            ratio, rows, total, conditions, others = actual[i]
            own, rest = total * (self.everybody[0] - rows), (self.everybody[1] - total) * rows
            side = "equal" if own == rest else "more" if own > rest else "less"
            is_that = (one.conditions, one.rows, one.total, one.ratio, one.side, one.same)
            expected = (
                self._labels(conditions),
                rows,
                reduced(total, self.table.unit),
                ratio,
                side,
                tuple(map(self._labels, others)),
            )
            self.true[i] = rows, total
            yield compared(f"findings[{i}]", is_that, expected)

    @cached_property
    def _strides(self) -> list[int]:
        strides = [1]
        for size in reversed(self.table.sizes[1:]):
            strides.append(strides[-1] * size)
        return strides[::-1]

    def _has(self, key: int, conditions: Conjunction) -> bool:
        return all(key // self._strides[a] % self.table.sizes[a] == v for a, v in conditions)

    def _entries(self, conditions: Conjunction) -> list[int]:
        """The entries of the table that have some conditions."""
        kept: Iterable[int] = self.table.entries
        for a, v in conditions:
            kept = [key for key in kept if key // self._strides[a] % self.table.sizes[a] == v]
        return list(kept)

    def population(self) -> Iterator[Finding]:
        """Check the ends of the means, and what they leave of the ratios."""
        stated = self.stated
        if stated.confidence is None:
            return
        working_on("the intervals")
        if self._ways() >= LAST_WAYS:
            raise malformed("family.conjunctions", "are too many for intervals")
        level = (1 - stated.confidence) / (4 * self._ways())
        lower: list[Rational] = []
        for i, one in enumerate(stated.found):
            if one.ends is None or one.interval is None or i not in self.true:
                yield finding_of(f"findings[{i}].ends", False, "there is no such finding")
                continue
            fault = self._fault_of(one.ends, *self.true[i], level)
            yield finding_of(f"findings[{i}].ends", not fault, fault)
            interval = interval_of(one.ends)
            yield compared(f"findings[{i}].interval", one.interval, interval)
            lower.append(interval[0] if not fault else ONE)
        if lower:
            self.lower = maximum(lower)
        if stated.ends is not None:
            yield self._family_within(stated.ends, level)

    def _family_within(self, ends: Mapping[Conjunction, tuple[Ends, Ends]], level: Fraction) -> Finding:
        """Check the ends of the whole family, one conjunction after the other."""
        upper = ONE
        said = f"family.ends: those of {len(ends)} conjunctions"
        for conditions, rows, total in self.all:
            if conditions not in ends:
                return finding_of(said, False, f"{self._said(conditions)} is missing")
            fault = self._fault_of(ends[conditions], rows, total, level)
            if fault:
                return finding_of(said, False, f"{self._said(conditions)} {fault}")
            upper = maximum([upper, interval_of(ends[conditions])[1]])
        if len(self.all) < len(ends):
            return finding_of(said, False, f"there are {len(self.all)} with enough rows")
        self.upper = upper
        return finding_of(said, True)

    def _fault_of(self, ends: tuple[Ends, Ends], rows: int, total: int, level: Fraction) -> str:
        n, everything = self.everybody
        for what, own, draws, gains in (("the subgroup", ends[0], rows, total), ("the rest", ends[1], n - rows, everything - total)):
            top = self.table.values[-1]
            sample = Sample(draws, gains, 0, 0, top, self.table.unit, {*self.table.values} <= {0, top})
            if fault := fault_of_ends(sample, *own, level, "hoeffding-kl"):
                return f"{what} {fault}"
        return ""

    def claims(self) -> Iterator[Finding]:
        """Judge each claim."""
        said: set[str] = set()
        for i, claim in enumerate(self.stated.claims):
            fault = "a claim that occurs twice" if claim.relation in said else self._fault_of_claim(claim)
            said.add(claim.relation)
            statement = f"claims[{i}]: subgroup_ratio {claim.relation} {shown(claim.value)} by T18 for {shown(claim.scope)}"
            yield finding_of(statement, not fault, fault, claim.assumptions)
        if "=" not in said:
            raise Incomplete("there is no claim on the greatest ratio of this table")
        needed = {">="} if self.stated.confidence is not None else set()
        if (needed | ({"<="} if self.stated.ends is not None else set())) - said:
            raise Incomplete("there is no claim that states what the intervals assume")

    def _fault_of_claim(self, claim: StatedClaim) -> str:
        found = self.stated.found
        if claim.relation == "=":
            if claim.evidence != self.table.digest:
                return "the evidence is the digest of another table"
            return "" if claim.value == found[0].ratio else f"the greatest ratio is {shown(found[0].ratio)}"
        if claim.relation == ">=":
            if not isinstance(claim.evidence, int) or claim.evidence >= len(found):
                return "the evidence is no finding"
            low = (found[claim.evidence].interval or (ONE, ONE))[0]
            true = at_most(ONE, claim.value) and at_most(claim.value, low) and at_most(low, self.lower)
            return "" if true else f"that finding has at least {shown(low)}"
        if self.stated.ends is None or claim.evidence != len(self.stated.ends):
            return "the ends of the family are not listed"
        return "" if at_most(self.upper, claim.value) else f"the ends of the family leave {shown(self.upper)}"

    def targets(self) -> Iterator[Finding]:
        """Judge each target, and all of them."""
        verdicts = []
        for i, (limit, judged, verdict) in enumerate(self.stated.targets):
            if judged == THIS_TABLE:
                actual = "within" if at_most(self.stated.found[0].ratio, limit) else "exceeds"
            else:
                exceeds, within = not at_most(self.lower, limit), at_most(self.upper, limit)
                actual = "inconclusive" if exceeds == within else "exceeds" if exceeds else "within"
            verdicts.append(actual)
            statement = f"targets[{i}]: subgroup ratio at most {shown(limit)} for {shown(judged)}: {verdict}"
            yield finding_of(statement, verdict == actual, "" if verdict == actual else f"it is {actual}")
        order = ("none", "within", "inconclusive", "exceeds")
        yield compared("verdict", self.stated.verdict, max(verdicts, key=order.index, default="none"))


def _more_unequal(one: Reached, other: Reached) -> int:
    """Order by falling ratio; infinity is 1/0."""
    return other[0][0] * one[0][1] - one[0][0] * other[0][1]


def interval_of(ends: tuple[Ends, Ends]) -> tuple[Rational, Rational]:
    """What the ends of two means leave of the greater over the less."""
    (low, high), (least, most) = ends
    lower = maximum([ONE, _quotient(low, most), _quotient(least, high)])
    return lower, maximum([ONE, _quotient(high, least), _quotient(most, low)])


def _quotient(one: Fraction, other: Fraction) -> Rational:
    return as_pair(one / other) if other else ONE if one == 0 else INFINITY


def _check_assumptions(stated: Stated, table: SubgroupTable) -> None:
    """Refuse a true certificate that keeps from the reader what it rests on, or lists what it does not rest on."""
    left_out = [step.sentence for step in stated.preparation if step.sentence]
    top = written(reduced(table.values[-1], table.unit))
    for i, claim in enumerate(stated.claims):
        drawn = [] if claim.relation == "=" else [INDEPENDENT_ROWS, RANGE.format("0", top), CHOSEN_BEFOREHAND]
        needed, listed = Counter(chain(drawn, left_out)), Counter(claim.assumptions)
        for text in needed - listed:
            raise Incomplete(printable(f"claims[{i}] lacks the assumption {shown(text)}"))
        for text in listed - needed:
            raise malformed(f"claims[{i}]", f"lists {shown(text)}, which is no assumption of such a claim, or is listed twice")
