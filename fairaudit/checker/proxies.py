"""Certificates of the format ``fairaudit-proxies/1``: of groups that nobody recorded it is known how probable they are in each cell."""

from __future__ import annotations

import json
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from itertools import combinations

from .json_values import (
    Labels,
    check_distinct,
    read_boolean,
    read_choice,
    read_digest,
    read_integer,
    read_label_lists,
    read_list,
    read_object,
    read_object_of_strings,
    read_string,
    read_strings,
)
from .logarithms import log_at_most
from .proxy_ranges import Completion, Extreme, Pair, Range, Scope, check_range, scope_of
from .rationals import ONE, ZERO, Rational, at_most, fraction_sum, read_extended, read_rational, read_rationals, sum_of
from .rows import embedded_lines, lines_of_file, read_table
from .summary import NAMES, assumed_for, said_of_figure, said_of_table, said_of_target
from .table import Table, counts_are_whole, is_signed
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
from .work import keep, working_on

PROXIES_FORMAT = "fairaudit-proxies/1"
JUDGED = "this table, whoever the members of the groups are"
SHARES = "of the rows of each cell, each group has the given share: the probabilities are those of the people in this table"
SHARES_BETWEEN = "of the rows of each cell, each group has a share between the given ends: these hold of the people in this table"
EXHAUSTIVE = "everybody belongs to exactly one of the groups"
SHARES_IN_CONTEXTS = "the shares of a cell are the same in each context"
ENDS_IN_CONTEXTS = "the ends that are given for a cell hold in each context"

Row = tuple[list[tuple[Fraction, int]], tuple[Fraction, ...], tuple[Fraction, ...]]
Shares = tuple[tuple[Fraction, ...], tuple[Fraction, ...]]  # the least and the greatest share of each group


@dataclass(frozen=True)
class Target:
    """A limit that was asked for, and the verdict on it."""

    quantity: str
    limit: Rational
    unit: str
    judged: str
    verdict: str


@dataclass(frozen=True)
class Proxies:
    """What a certificate states, so far as no table is needed."""

    decision: str
    context: tuple[str, ...]
    keys: tuple[str, ...]  # columns of the cells
    digest: str
    entries: int
    embedded: tuple[object, ...] | None
    shares: dict[Labels, Shares]  # by the labels of the keys
    local: tuple[tuple[Labels, Range], ...]
    overall: Range | None
    assumptions: tuple[str, ...]
    targets: tuple[Target, ...]
    verdict: str


def check_proxies(document: object, lines: Iterable[bytes] | None) -> Report:
    """Check every statement of such a certificate, which was decoded already."""
    stated = _read(document)
    working_on("the table")
    if stated.embedded is None and lines is None:
        raise TableNeeded("The certificate does not embed its table; the file of the table has to be given: add --table FILE.")
    table = read_table(embedded_lines(stated.embedded) if stated.embedded is not None else lines_of_file(lines or ()))
    _check_table(stated, table)
    findings = [
        compared("subject.table.sha256", stated.digest, table.digest),
        compared("subject.table.cells", stated.entries, table.rows * len(table.header.decisions)),
    ]
    if stated.embedded is not None and lines is not None:
        findings.append(compared_file(lines, table.digest))
    findings += _check_ranges(stated, table)
    findings += _check_targets(stated)
    counted = Counted(table.digest, "decisions", sum_of([ZERO, *table.figures.masses()]), stated.entries, None)
    report = Report(tuple(findings), stated.verdict, counted=counted)
    if not report.ok:
        return report
    _check_assumptions(stated)
    return replace(report, outline=_outline(stated))


def _outline(stated: Proxies) -> Outline:
    """Say in short what is stated."""
    figures = []
    for name, ranges in (("local", [found for _, found in stated.local]), ("global", [stated.overall] if stated.overall else [])):
        if ranges:
            least, greatest, _, _ = _ends(ranges)
            figures.append(said_of_figure(NAMES[name], None, [(JUDGED, ">=", least), (JUDGED, "<=", greatest)]))
    return Outline(
        said_of_table(stated.entries, embedded=stated.embedded is not None),
        tuple(
            said_of_target(NAMES[target.quantity], target.unit, target.limit, target.judged, target.verdict) for target in stated.targets
        ),
        tuple(figures),
        assumed_for([(JUDGED, stated.assumptions)]),
    )


def _read(document: object) -> Proxies:
    keys = ("format", "subject", "local", "global", "assumptions", "targets", "verdict", "versions")
    top = read_object(document, "the certificate", keys)
    read_choice(top["format"], "format", (PROXIES_FORMAT,))
    subject = read_object(top["subject"], "subject", ("columns", "table", "groups", "cells"))
    columns = read_object(subject["columns"], "subject.columns", ("decision", "context", "cell", "group"))
    names = {key: read_strings(columns[key], f"subject.columns.{key}") for key in ("context", "cell", "group")}
    for key in ("cell", "group"):
        check_distinct(names[key], f"subject.columns.{key}")
    table = read_object(subject["table"], "subject.table", ("sha256", "cells"), optional=("header", "rows"))
    embedded: tuple[object, ...] | None = None
    if "header" in table or "rows" in table:
        table = read_object(table, "subject.table", ("sha256", "cells", "header", "rows"))
        embedded = (table["header"], *read_list(table["rows"], "subject.table.rows"))
    groups = read_label_lists(subject["groups"], "subject.groups", len(names["group"]))
    shares: dict[Labels, Shares] = {}
    for i, item in enumerate(read_list(subject["cells"], "subject.cells")):
        cell, ends = _read_cell(item, f"subject.cells[{i}]", len(names["cell"]), len(groups))
        if cell in shares:
            raise malformed(f"subject.cells[{i}]", "lists a cell again")
        shares[cell] = ends
    read_object_of_strings(top["versions"], "versions")
    local = []
    for i, item in enumerate(read_list(top["local"], "local")):
        where = f"local[{i}]"
        members = read_object(item, where, ("context", *RANGE_KEYS))
        local.append(
            (read_strings(members["context"], f"{where}.context", len(names["context"])), _read_range(members, where, len(groups)))
        )
    overall = top["global"]
    return Proxies(
        read_string(columns["decision"], "subject.columns.decision"),
        names["context"],
        names["cell"],
        read_digest(table["sha256"], "subject.table.sha256"),
        read_integer(table["cells"], "subject.table.cells"),
        embedded,
        shares,
        tuple(local),
        None if overall is None else _read_range(read_object(overall, "global", RANGE_KEYS), "global", len(groups)),
        read_strings(top["assumptions"], "assumptions"),
        tuple(_read_target(item, f"targets[{i}]") for i, item in enumerate(read_list(top["targets"], "targets"))),
        read_choice(top["verdict"], "verdict", ("none", "within", "exceeds", "depends", "inconclusive")),
    )


def _read_cell(value: object, where: str, width: int, groups: int) -> tuple[Labels, Shares]:
    known = isinstance(value, dict) and "probability" in value
    ends = ("probability",) if known else ("low", "high")
    members = read_object(value, where, ("cell", *ends))
    low, high = (
        tuple(Fraction(*share) for share in read_rationals(members[name], f"{where}.{name}", groups)) for name in (ends[0], ends[-1])
    )
    if known and fraction_sum(low) != 1:
        raise malformed(f"{where}.probability", "does not sum to 1")
    if any(least > most for least, most in zip(low, high, strict=True)) or not fraction_sum(low) <= 1 <= fraction_sum(high):
        raise malformed(where, "has ends between which no probabilities sum to 1")
    return read_strings(members["cell"], f"{where}.cell", width), (low, high)


RANGE_KEYS = ("groups", "means", "pairs", "least", "greatest", "low", "high")


def _read_groups(value: object, where: str, groups: int) -> tuple[int, ...]:
    found = tuple(read_integer(item, f"{where}[{i}]", groups) for i, item in enumerate(read_list(value, where)))
    check_distinct(found, where)
    return found


def _read_among(value: object, where: str, groups: Sequence[int], count: int | None = None) -> tuple[int, ...]:
    """Read some of the groups of a range, so many if that is given."""
    found = _read_groups(value, where, max(groups) + 1)
    if not set(found) <= set(groups) or count not in (None, len(found)):
        raise malformed(where, f"must be {'some' if count is None else count} of the groups {shown(list(groups))}")
    return found


def _read_range(members: dict[str, object], where: str, every: int) -> Range:
    groups = _read_groups(members["groups"], f"{where}.groups", every)
    if len(groups) < 2 or list(groups) != sorted(groups):
        raise malformed(f"{where}.groups", "must be two groups or more in increasing order")
    means = []
    for i, item in enumerate(read_list(members["means"], f"{where}.means", len(groups))):
        low, high = read_rationals(item, f"{where}.means[{i}]", 2)
        means.append((Fraction(*low), Fraction(*high)))
    listed = list(combinations(groups, 2))
    pairs = tuple(
        _read_pair(item, f"{where}.pairs[{i}]", pair)
        for i, (item, pair) in enumerate(zip(read_list(members["pairs"], f"{where}.pairs", len(listed)), listed, strict=True))
    )
    least, greatest = (_read_extreme(members[name], f"{where}.{name}", groups) for name in ("least", "greatest"))
    low_, high_ = (_read_completion(members[name], f"{where}.{name}", groups) for name in ("low", "high"))
    return Range(groups, tuple(means), pairs, least, greatest, low_, high_)


def _read_ratio(value: object, where: str) -> Rational:
    found = read_extended(value, where)
    if found[0] < 0:
        raise malformed(where, "must not be negative")
    return found


def _read_pair(value: object, where: str, pair: tuple[int, int]) -> Pair:
    members = read_object(value, where, ("groups", "ratio", "sharp"))
    if _read_groups(members["groups"], f"{where}.groups", pair[1] + 1) != pair:
        raise malformed(f"{where}.groups", f"must be {shown(list(pair))}")
    low, high = (_read_ratio(item, f"{where}.ratio") for item in read_list(members["ratio"], f"{where}.ratio", 2))
    sharp = [read_boolean(item, f"{where}.sharp") for item in read_list(members["sharp"], f"{where}.sharp", 2)]
    return Pair(pair, (low, high), (sharp[0], sharp[1]))


def _read_extreme(value: object, where: str, groups: Sequence[int]) -> Extreme:
    members = read_object(value, where, ("ratio", "higher", "lower", "sharp"))
    higher, lower = (_read_among(members[name], f"{where}.{name}", groups) for name in ("higher", "lower"))
    return Extreme(_read_ratio(members["ratio"], f"{where}.ratio"), higher, lower, read_boolean(members["sharp"], f"{where}.sharp"))


def _read_completion(value: object, where: str, groups: Sequence[int]) -> Completion:
    members = read_object(value, where, ("ratio", "mixture"), optional=("rows",))
    mixture = []
    for i, item in enumerate(read_list(members["mixture"], f"{where}.mixture")):
        part = read_object(item, f"{where}.mixture[{i}]", ("share", "order"))
        share = Fraction(*read_rational(part["share"], f"{where}.mixture[{i}].share", nonnegative=True))
        mixture.append((share, _read_among(part["order"], f"{where}.mixture[{i}].order", groups, len(groups))))
    check_distinct([order for _, order in mixture], f"{where}.mixture")
    rows = None
    if "rows" in members:
        listed = read_list(members["rows"], f"{where}.rows")
        rows = tuple(
            tuple(Fraction(*count) for count in read_rationals(item, f"{where}.rows[{i}]", len(groups))) for i, item in enumerate(listed)
        )
    return Completion(_read_ratio(members["ratio"], f"{where}.ratio"), tuple(mixture), rows)


def _read_target(value: object, where: str) -> Target:
    members = read_object(value, where, ("quantity", "limit", "unit", "judged", "verdict"))
    target = Target(
        read_choice(members["quantity"], f"{where}.quantity", ("local", "global")),
        read_rational(members["limit"], f"{where}.limit", nonnegative=True),
        read_choice(members["unit"], f"{where}.unit", ("log", "ratio")),
        read_string(members["judged"], f"{where}.judged"),
        read_choice(members["verdict"], f"{where}.verdict", ("within", "exceeds", "depends", "inconclusive")),
    )
    if target.unit == "ratio" and not at_most(ONE, target.limit):
        raise malformed(f"{where}.limit", "must be at least 1, being the limit of a ratio")
    return target


def _check_table(stated: Proxies, table: Table) -> None:
    """Refuse a table that is not one of counts by cells."""
    header = table.header
    columns = header.subject.columns
    more = header.truths is not None or header.profiles or header.unknown or header.log
    if header.subject.kind != "counts" or table.policy is not None or more:
        raise malformed("the table", "must be one of counts, and no more")
    if columns.context or columns.group != (*stated.context, *(name for name in stated.keys if name not in stated.context)):
        raise malformed("the table", "must have the columns of the contexts and of the cells in the place of groups, and no contexts")
    if columns.decision != stated.decision:
        raise malformed("subject.columns.decision", "is not that of the table")
    if is_signed(table):
        raise malformed("the table", "has utilities below 0, of which no ratios are stated")
    if not counts_are_whole(table):
        raise malformed("the table", "has counts that are not whole")


def _scopes(stated: Proxies, table: Table) -> dict[Labels | None, Scope]:
    """Put together the cells of each context, and under None those of all contexts."""
    width = len(stated.context)
    at = [table.header.subject.columns.group.index(name) for name in stated.keys]
    rows: dict[Labels | None, list[Row]] = {}
    for cell in table.cells:
        label = table.header.groups[cell.group]
        key = tuple(label[i] for i in at)
        if key not in stated.shares:
            raise malformed("subject.cells", f"lacks the cell {shown(list(key))} of the table")
        weights, total = cell.law
        counts = [weight * (cell.mass[0] // total) for weight in weights]
        gains = [(Fraction(*gain), count) for gain, count in zip(cell.utility, counts, strict=True) if gain is not None]
        keep(2 * len(gains))
        for scope in (label[:width], None):
            rows.setdefault(scope, []).append((gains, *stated.shares[key]))
    found = {x: scope_of(cells) for x, cells in rows.items()}
    for compared_ in found.values():
        for a, group in enumerate(compared_.groups):
            if not any(cell.low[a] for cell in compared_.cells):
                raise malformed("the table", f"compares the group {group}, which might have no rows at all")
    return {x: scope for x, scope in found.items() if len(scope.groups) > 1}


def _check_ranges(stated: Proxies, table: Table) -> Iterator[Finding]:
    """Check what is stated of each context, and of all of them."""
    scopes = _scopes(stated, table)
    overall = scopes.pop(None, None)
    yield compared("the list of contexts with two groups", [list(x) for x, _ in stated.local], [list(x) for x in scopes if x is not None])
    yield compared("whether two groups are compared over all contexts", stated.overall is not None, overall is not None)
    named = [(f"local {shown(list(x))}", found, scopes.get(x)) for x, found in stated.local]
    if stated.overall is not None:
        named.append(("global", stated.overall, overall))
    for name, found, scope in named:
        working_on(name)
        if scope is None:
            continue
        yield compared(f"{name}: the groups", list(found.groups), list(scope.groups))
        for completion in (found.low, found.high):
            if (completion.rows is None) != scope.known or len(completion.rows or scope.cells) != len(scope.cells):
                raise malformed(name, "must list the rows of each group in each cell where these are not known, and only there")
        if found.groups == scope.groups:
            yield from check_range(name, found, scope)


def _greatest(ratios: Iterable[Rational]) -> Rational:
    found = ONE
    for ratio in ratios:
        found = found if at_most(ratio, found) else ratio
    return found


def _ends(ranges: Sequence[Range]) -> tuple[Rational, ...]:
    """Find the greatest of the ends, and of the completions, of all ranges: each context has completions of its own."""
    each = ((found.least.ratio, found.greatest.ratio, found.low.ratio, found.high.ratio) for found in ranges)
    return tuple(map(_greatest, zip(*each, strict=True)))


def _verdict(target: Target, ends: tuple[Rational, ...]) -> str:
    """Judge a target by the ends of all ranges; there are none without ranges."""
    if not ends:
        return "inconclusive"
    within = log_at_most if target.unit == "log" else at_most
    least, greatest, low, high = ends
    if not within(least, target.limit):
        return "exceeds"
    if within(greatest, target.limit):
        return "within"
    return "depends" if within(low, target.limit) and not within(high, target.limit) else "inconclusive"


def _check_targets(stated: Proxies) -> Iterator[Finding]:
    """Judge each target by what is stated, which was checked, and the certificate by its targets."""
    verdicts: list[str] = []
    seen: set[tuple[str, str]] = set()
    ends = {"local": _ends([found for _, found in stated.local]), "global": _ends([stated.overall] if stated.overall else [])}
    for i, target in enumerate(stated.targets):
        working_on(f"targets[{i}]")
        verdicts.append(_verdict(target, ends[target.quantity]))
        fault = "" if target.verdict == verdicts[-1] else f"the ranges give {shown(verdicts[-1])}"
        if target.judged != JUDGED:
            fault = f"judged must be {shown(JUDGED)}, not {shown(target.judged)}"
        if (target.quantity, target.unit) in seen:
            fault = "a target that occurs twice"
        seen.add((target.quantity, target.unit))
        statement = (
            f"targets[{i}]: {target.quantity} {target.unit}, limit {shown(target.limit)}: {target.verdict} for {shown(target.judged)}"
        )
        yield finding_of(statement, not fault, fault)
    order = ("exceeds", "depends", "inconclusive", "within", "none")
    yield compared("verdict", stated.verdict, next(verdict for verdict in order if verdict in [*verdicts, "none"]))


def _check_assumptions(stated: Proxies) -> None:
    """Refuse a true certificate that keeps from the reader what it rests on, or lists what it does not rest on."""
    known = all(low == high for low, high in stated.shares.values())
    needed = [SHARES if known else SHARES_BETWEEN, EXHAUSTIVE]
    if not set(stated.context) <= set(stated.keys):
        needed.append(SHARES_IN_CONTEXTS if known else ENDS_IN_CONTEXTS)
    for text in needed:
        if text not in stated.assumptions:
            raise Incomplete(printable(f"the certificate lacks the assumption {json.dumps(text, ensure_ascii=False)}"))
    for text in stated.assumptions:
        if text not in needed or stated.assumptions.count(text) > 1:
            raise malformed("assumptions", f"lists {shown(text)} twice, or it is no assumption of such a certificate")
