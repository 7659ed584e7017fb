"""Groups that nobody recorded, of which a table says how probable they are in each cell: what the ratios of their means can be."""

from __future__ import annotations

import os
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from functools import cached_property
from pathlib import Path
from typing import Any, Literal

from fairaudit import __version__
from fairaudit.audits.reading import Reading, read_audited
from fairaudit.certificates.certificate import EMBED_LIMIT, Certificate, new_salt
from fairaudit.certificates.table import Table
from fairaudit.errors import InputError, shown
from fairaudit.exact.enclosures import compare_log
from fairaudit.exact.extended import Extended, extended_pair, extended_text
from fairaudit.inference.verdicts import Verdict, exit_code, foremost_verdict
from fairaudit.measures.limits import Quantity, Unit, limits_of
from fairaudit.model.law import Law
from fairaudit.model.utility import Utility, UtilityTable
from fairaudit.tables.engines.request import Report
from fairaudit.tables.group_probabilities import GroupProbabilities, read_group_probabilities
from fairaudit.tables.sources import Source
from fairaudit.tables.values import Label
from fairaudit.theorems.t15_cells import proxy_cells
from fairaudit.theorems.t15_proxies import (
    ENDS_IN_CONTEXTS,
    EXHAUSTIVE,
    SHARES,
    SHARES_BETWEEN,
    SHARES_IN_CONTEXTS,
    Completion,
    Ends,
    Extreme,
    proxy_ends,
)
from fairaudit.words import THIS_TABLE, WHOEVER_BELONGS, approximate, brief

__all__ = ["FORMAT", "ProxyAudit", "ProxyRange", "ProxyTarget", "audit_proxies"]

FORMAT = "fairaudit-proxies/1"

MOST_DIGITS = 4_000  # of a common denominator


@brief
@dataclass(frozen=True, repr=False)
class ProxyRange:
    """What the means and ratios of groups can be among some cells.

    Attributes
    ----------
    context : tuple of str or None
        The context whose cells these are; None for the cells of all contexts.
    groups : tuple of int
        The groups that are there, as positions among those of the audit; means and pairs are in this order.
    rows : tuple of int
        The cells, as positions of rows of the law.
    ends : Ends
        The ranges, and completions that reach them.
    """

    context: Label | None
    groups: tuple[int, ...]
    rows: tuple[int, ...]
    ends: Ends


@brief
@dataclass(frozen=True, repr=False)
class ProxyTarget:
    """A limit, and how it was judged.

    Attributes
    ----------
    quantity : {"local", "global"}
        What is limited.
    unit : {"ratio", "log"}
        Whether the ratio is limited or its natural logarithm.
    limit : Fraction
        The limit.
    verdict : {"within", "exceeds", "depends", "inconclusive"}
        "within" and "exceeds" hold whoever the members of the groups are; it "depends" where completions of both kinds are known.
    """

    quantity: Quantity
    unit: Unit
    limit: Fraction
    verdict: Verdict


@brief
@dataclass(frozen=True, repr=False)
class ProxyAudit:
    """What is known of the ratios of groups that were not recorded, from the probabilities of their cells.

    Attributes
    ----------
    law : Law
        The table: its groups are the cells.
    utility : UtilityTable
        The utility.
    context : tuple of str
        Columns of the contexts.
    group : tuple of str
        Columns of the groups.
    probabilities : GroupProbabilities
        P(group | cell).
    local : tuple of ProxyRange
        The ranges in each context that has at least two groups.
    global_ : ProxyRange or None
        Those of all contexts together.
    targets : tuple of ProxyTarget
        The limits that were asked for.
    verdict : {"none", "within", "exceeds", "depends", "inconclusive"}
        The severest of their verdicts.
    notes : tuple of str
        What was noticed while reading.
    embed : bool or None
        Whether the certificate holds the table.
    """

    law: Law
    utility: UtilityTable
    context: tuple[str, ...]
    group: tuple[str, ...]
    probabilities: GroupProbabilities
    local: tuple[ProxyRange, ...]
    global_: ProxyRange | None
    targets: tuple[ProxyTarget, ...]
    verdict: Verdict
    notes: tuple[str, ...] = ()
    embed: bool | None = None

    @property
    def groups(self) -> tuple[Label, ...]:
        """The groups."""
        return self.probabilities.groups

    @property
    def exact(self) -> bool:
        """Whether the probabilities are known exactly, so that all ends occur."""
        keys = {_key(label, self.law.columns.group, self.probabilities.keys) for label in self.law.groups}
        return all(low == high for low, high in (self.probabilities.ends[key] for key in keys))

    @property
    def exit_code(self) -> int:
        """What the command exits with: 0 within or no target, 1 exceeded, 3 it depends, or is not known."""
        return exit_code(self.verdict, [target.verdict for target in self.targets])

    def ranges(self, quantity: Quantity) -> tuple[ProxyRange, ...]:
        """The ranges of a quantity: of the local ratio one per context."""
        if quantity == "local":
            return self.local
        return () if self.global_ is None else (self.global_,)

    def proved(self, quantity: Quantity) -> tuple[Extended, Extended] | None:
        """Between which ends a ratio lies, whoever the members are; None where nothing is compared."""
        found = self.ranges(quantity)
        return (max(r.ends.least.value for r in found), max(r.ends.greatest.value for r in found)) if found else None

    def reached(self, quantity: Quantity) -> tuple[Extended, Extended] | None:
        """A small and a great ratio that completions have."""
        found = self.ranges(quantity)
        return (max(r.ends.low.ratio for r in found), max(r.ends.high.ratio for r in found)) if found else None

    def completion(self, found: ProxyRange, which: Literal["low", "high"]) -> Iterator[tuple[Label, str, tuple[Fraction, ...]]]:
        """Who the members could be, so that the ratio is small or great: for each cell and decision, the rows of each group of the range.

        Parameters
        ----------
        found : ProxyRange
            One of `local`, or `global_`.
        which : {"low", "high"}
            Which completion.
        """
        chosen = found.ends.low if which == "low" else found.ends.high
        for at, row in enumerate(found.rows):
            label = self.law.groups[int(self.law.cell_group[row])]
            size = sum(self.law.row(row))
            shares = self.probabilities.ends[_key(label, self.law.columns.group, self.probabilities.keys)][0]
            own = chosen.rows[at] if chosen.rows is not None else tuple(size * shares[a] for a in found.groups)
            parts = [[Fraction(0)] * len(own) for _ in self.law.decisions]
            for share, order in chosen.mixture:
                left = [(u, Fraction(count)) for count, u in self._worst_last(row)]
                for a in order:
                    wanted = own[a]
                    while wanted:
                        u, count = left.pop()
                        taken = min(count, wanted)
                        parts[u][a] += share * taken
                        wanted -= taken
                        if taken < count:
                            left.append((u, count - taken))
            yield from ((label, decision, tuple(part)) for decision, part in zip(self.law.decisions, parts, strict=True) if any(part))

    def _worst_last(self, row: int) -> list[tuple[int, int]]:
        """Counts and decisions of a cell, the one of the least utility last."""
        gains = self.utility.row(row)
        listed = [(count, u) for u, count in enumerate(self.law.row(row)) if count]
        return sorted(listed, key=lambda entry: -gains[entry[1]])

    @property
    def assumptions(self) -> tuple[str, ...]:
        """What a reader has to judge."""
        same = SHARES_IN_CONTEXTS if self.exact else ENDS_IN_CONTEXTS
        by_context = {*self.context} <= {*self.probabilities.keys}
        return (SHARES if self.exact else SHARES_BETWEEN, EXHAUSTIVE, *([] if by_context else [same]))

    @cached_property
    def certificate(self) -> Certificate:
        """The certificate, of the format ``fairaudit-proxies/1``."""
        return _certificate(self)

    def save(self, path: str | os.PathLike[str]) -> list[Path]:
        """Write the certificate, and its table beside it where it does not hold it; returns the files."""
        return self.certificate.save(path)

    @property
    def sentence(self) -> str:
        """The answer in one sentence."""
        said = [self._range_sentence(quantity) for quantity in ("local", "global") if quantity == "local" or self.context]
        return f"{'; '.join(said)}, {WHOEVER_BELONGS}."

    def _range_sentence(self, quantity: Quantity) -> str:
        ends = self.proved(quantity)
        name = "the worst ratio within a context" if quantity == "local" and self.context else "the worst ratio"
        name = "the worst ratio of group means" if quantity == "global" else name
        if ends is None:
            return f"nothing is compared for {name}"
        if ends[0] == ends[1]:
            return f"{name} is {approximate(ends[0])}"
        return f"{name} is from {approximate(ends[0], 'down')} to {approximate(ends[1], 'up')}"


def audit_proxies(
    source: Source,
    reading: Reading,
    utility: Utility | None,
    probabilities: GroupProbabilities | Source,
    *,
    limits: Mapping[str, Any],
    embed: bool | None = None,
    report: Report | None = None,
) -> ProxyAudit:
    """Audit a table without groups, by probabilities of groups in its cells.

    Parameters
    ----------
    source : Source
        The table.
    reading : Reading
        Its columns; those of the group are looked for among the probabilities only.
    utility : Utility or None
        What decisions are worth, where no column says it.
    probabilities : GroupProbabilities or Source
        P(group | cell): columns of the cell, which the table has too, of the group, and ``probability``, or ``low`` and ``high``.
    limits : mapping
        Targets, by the names of `certify`.
    embed : bool, optional
        Whether the certificate holds the table; by default, if it is not long.
    report : callable, optional
        As for `read_log`.

    Raises
    ------
    InputError
        If something does not fit, a cell has no probabilities, or a group might have no rows where it is compared.
    """
    given = probabilities if isinstance(probabilities, GroupProbabilities) else read_group_probabilities(probabilities, reading.group)
    for name in given.keys:
        if name in (reading.decision, reading.utility_column, reading.count):
            raise InputError(f"{given.name}: the column {shown(name)} says which cell, and the log has something else in it")
    cells = (*reading.context, *(name for name in given.keys if name not in reading.context))
    try:
        law, utility = read_audited(source, _as_cells(reading, cells), utility, report=report)
    except InputError as error:
        if "there is only one group" not in str(error):
            raise
        raise InputError("the log has one cell only, of which probabilities say nothing; cells that differ are needed") from None
    if law.evaluation is not None:
        raise InputError("probabilities of groups go with decisions of people; an evaluation log is audited with its own groups")
    if law.kind != "counts" or law.scale != 1:
        raise InputError("probabilities of groups go with whole counts or a log")
    laid = utility.on(law)
    law = laid.law
    keys = [_key(label, cells, given.keys) for label in law.groups]
    _refuse_unknown(keys, given)
    asked = limits_of(limits)
    places = [label[: len(reading.context)] for label in law.groups]
    contexts = dict.fromkeys(places[a] for a in law.cell_group.tolist())
    local = [_range(law, laid, given, keys, [x == place_ for place_ in places], context=x) for x in contexts]
    overall = _range(law, laid, given, keys, [True] * len(places), context=None) if reading.context else local[0]
    compared = tuple(found for found in local if found is not None)
    result = ProxyAudit(law, laid, reading.context, reading.group, given, compared, overall, (), "none", (*law.notes, *given.notes), embed)
    targets = tuple(ProxyTarget(quantity, unit, limit, _judge(result, quantity, unit, limit)) for quantity, unit, limit in asked)
    return replace(result, targets=targets, verdict=foremost_verdict(target.verdict for target in targets))


def _as_cells(reading: Reading, cells: tuple[str, ...]) -> Reading:
    """The same table, read by its cells; what has no meaning for them is refused."""
    others = {
        "probability": reading.probability,
        "weight": reading.weight,
        "truth": reading.truth,
        "unit": reading.unit,
        "fold_labels": reading.fold_labels,
        "map": reading.label_map,
    }
    for name, value in others.items():
        if value:
            raise InputError(f"{reading.spelled(name)} does not go with {reading.spelled('group_probability')}")
    return replace(reading, group=cells, context=())


def _key(label: Label, cells: Sequence[str], keys: Sequence[str]) -> Label:
    return tuple(label[cells.index(name)] for name in keys)


def _refuse_unknown(keys: Sequence[Label], given: GroupProbabilities) -> None:
    unknown = dict.fromkeys(key for key in keys if key not in given.ends)
    if unknown:
        first = ", ".join(f"{name}={shown(text)}" for name, text in zip(given.keys, next(iter(unknown)), strict=True))
        more = f" and {len(unknown) - 1} more" if len(unknown) > 1 else ""
        raise InputError(f"{given.name} has no probabilities for the cell {first}{more} of the log; each cell of the log is needed")


def _range(
    law: Law, laid: UtilityTable, given: GroupProbabilities, keys: Sequence[Label], chosen: Sequence[bool], context: Label | None
) -> ProxyRange | None:
    """The ranges among some cells; None if fewer than two groups are there."""
    rows = tuple(i for i, a in enumerate(law.cell_group.tolist()) if chosen[a])
    ends = [given.ends[keys[a]] for a in law.cell_group[list(rows)].tolist()]
    groups = tuple(a for a in range(len(given.groups)) if any(high[a] for _, high in ends))
    for a in groups:
        if not any(low[a] for low, _ in ends):
            where = f"in context {shown(', '.join(context))} " if context else ""
            raise InputError(
                f"{given.name}: {where}the group {shown(', '.join(given.groups[a]))} might have no rows at all, so that it has no mean; "
                "give it a low above 0 in some cell, or compare larger contexts"
            )
    if len(groups) < 2:
        return None
    gains = [[Fraction(gain, laid.scale) for gain in laid.row(i)] for i in rows]
    counted = (list(zip(own, law.row(i), strict=True)) for own, i in zip(gains, rows, strict=True))
    shares = ([tuple(end[a] for a in groups) for end in both] for both in ends)
    cells = proxy_cells(((own, low, high) for own, (low, high) in zip(counted, shares, strict=True)), len(groups))
    if cells.scale.bit_length() > MOST_DIGITS * 3:
        raise InputError(
            f"{given.name}: the probabilities have no common denominator of up to {MOST_DIGITS} digits; round them to decimals"
        )
    return ProxyRange(context, groups, rows, proxy_ends(cells))


def _judge(result: ProxyAudit, quantity: Quantity, unit: Unit, limit: Fraction) -> Verdict:
    """What holds of all completions is proved by the ends; both verdicts are possible where completions with both are known."""
    proved, reached = result.proved(quantity), result.reached(quantity)
    if proved is None or reached is None:
        return "inconclusive"
    if _exceeds(proved[0], unit, limit):
        return "exceeds"
    if not _exceeds(proved[1], unit, limit):
        return "within"
    return "depends" if _exceeds(reached[1], unit, limit) and not _exceeds(reached[0], unit, limit) else "inconclusive"


def _exceeds(value: Extended, unit: Unit, limit: Fraction) -> bool:
    return value > limit if unit == "ratio" else compare_log(extended_pair(value), (limit.numerator, limit.denominator)) > 0


def _certificate(result: ProxyAudit) -> Certificate:
    given, law = result.probabilities, result.law
    table = Table(law, result.utility, salt=new_salt() if result.embed is False else None)
    apart = table.cells > EMBED_LIMIT if result.embed is None else not result.embed
    entry: dict[str, Any] = {"sha256": table.sha256, "cells": table.cells}
    if not apart:
        entry |= {"header": table.header, "rows": list(table.rows())}
    keys = [_key(label, law.columns.group, given.keys) for label in law.groups]
    document = {
        "format": FORMAT,
        "subject": {
            "columns": {
                "decision": law.columns.decision,
                "context": list(result.context),
                "cell": list(given.keys),
                "group": list(result.group),
            },
            "table": entry,
            "groups": [list(group) for group in given.groups],
            "cells": [_cell_entry(key, *given.ends[key]) for key in dict.fromkeys(keys)],
        },
        "local": [{"context": list(found.context or ()), **_range_entry(found)} for found in result.local],
        "global": None if result.global_ is None else _range_entry(result.global_),
        "assumptions": list(result.assumptions),
        "targets": [
            {
                "quantity": target.quantity,
                "unit": target.unit,
                "limit": extended_text(target.limit),
                "judged": f"{THIS_TABLE}, {WHOEVER_BELONGS}",
                "verdict": target.verdict,
            }
            for target in result.targets
        ],
        "verdict": result.verdict,
        "versions": {"fairaudit": __version__},
    }
    return Certificate(document, table if apart else None)


def _cell_entry(key: Label, low: Sequence[Fraction], high: Sequence[Fraction]) -> dict[str, Any]:
    def texts(shares: Sequence[Fraction]) -> list[str]:
        return [extended_text(share) for share in shares]

    known = {"probability": texts(low)} if tuple(low) == tuple(high) else {"low": texts(low), "high": texts(high)}
    return {"cell": list(key), **known}


def _range_entry(found: ProxyRange) -> dict[str, Any]:
    ends = found.ends
    return {
        "groups": list(found.groups),
        "means": [[extended_text(low), extended_text(high)] for low, high in ends.means],
        "pairs": [
            {
                "groups": [found.groups[a], found.groups[b]],
                "ratio": [extended_text(low), extended_text(high)],
                "sharp": [low_sharp, high_sharp],
            }
            for (a, b), ((low, low_sharp), (high, high_sharp)) in ends.pairs.items()
        ],
        "least": _extreme_entry(found, ends.least),
        "greatest": _extreme_entry(found, ends.greatest),
        "low": _completion_entry(found, ends.low),
        "high": _completion_entry(found, ends.high),
    }


def _extreme_entry(found: ProxyRange, extreme: Extreme) -> dict[str, Any]:
    return {
        "ratio": extended_text(extreme.value),
        "higher": [found.groups[a] for a in extreme.higher],
        "lower": [found.groups[a] for a in extreme.lower],
        "sharp": extreme.sharp,
    }


def _completion_entry(found: ProxyRange, completion: Completion) -> dict[str, Any]:
    entry: dict[str, Any] = {
        "ratio": extended_text(completion.ratio),
        "mixture": [{"share": extended_text(share), "order": [found.groups[a] for a in order]} for share, order in completion.mixture],
    }
    if completion.rows is not None:
        entry["rows"] = [[extended_text(count) for count in cell] for cell in completion.rows]
    return entry
