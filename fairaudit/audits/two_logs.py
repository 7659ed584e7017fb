"""Two logs of the same columns: whether the second is less fair, and how what each group gets changed in the units of both."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from itertools import pairwise
from typing import Any

from fairaudit.audits.certify import certify
from fairaudit.audits.population import confidence_for
from fairaudit.audits.reading import Reading, read_table_of
from fairaudit.audits.result import Result
from fairaudit.audits.undecided import undecided_of_log
from fairaudit.certificates.compare import CertificateComparison
from fairaudit.certificates.fairness import Fairness, sharpened
from fairaudit.errors import InputError, naming, shown
from fairaudit.inference.draws import unit_profiles
from fairaudit.inference.levels import equal_share
from fairaudit.inference.paired_rates import Cells, PairedRate, greatest_change, paired_rates, units_alike
from fairaudit.model.law import Law
from fairaudit.model.utility import Utility
from fairaudit.tables.engines.request import Report
from fairaudit.tables.evaluations.samples import ERROR
from fairaudit.tables.sources import Source, source_name
from fairaudit.tables.tally import Tally, counted
from fairaudit.theorems.assumptions import BY_DESIGN, PAIRED
from fairaudit.verified.comparison import compare

__all__ = ["ComparedLogs", "compare_logs"]

MOST_CELLS = 1000

WHICH = ("first", "second")


@dataclass(frozen=True)
class ComparedLogs:
    """What two logs say of each other.

    Attributes
    ----------
    results : tuple of Result
        Each log by itself.
    found : CertificateComparison
        What moved between them, and whether the second is less fair.
    rates : tuple of PairedRate
        How what each group gets changed, in the units of both logs; empty where they are not compared by unit.
    confidence : Fraction or None
        At which the ends of all ratios of rates hold together, and those of all differences.
    unpaired : str
        Why rates are not compared by unit.
    """

    results: tuple[Result, Result]
    found: CertificateComparison
    rates: tuple[PairedRate, ...]
    confidence: Fraction | None
    unpaired: str = ""


def compare_logs(
    old: Source,
    new: Source,
    reading: Reading,
    utility: Utility | None,
    *,
    confidence: Fraction | None,
    margin: Fraction,
    options: Mapping[str, Any],
    undecided: Sequence[str] = (),
    report: Report | None = None,
) -> ComparedLogs:
    """Compare two logs: each is certified with half of the error, and where both have the same units, rates are compared within them.

    Then the error against "no less fair" is shared by two ways of showing it: the ends of both ratios, and how much rates changed.

    Parameters
    ----------
    old, new : Source
        The logs.
    reading : Reading
        What their columns are.
    utility : Utility or None
        What decisions are worth, where no column says it.
    confidence : Fraction or None
        Of the answer; None compares the logs themselves, and says nothing of what they were drawn from.
    margin : Fraction
        How many times the old ratio the new one may be.
    options : mapping
        For `certify`: whether cells are independent, what units mean that are missing, and what is declared of utilities in a column.
    undecided : sequence of str
        Decisions whose meaning is not known; of evaluation logs the answers that decide nothing are among them.
    report : callable, optional
        As for `read_log`.

    Raises
    ------
    InputError
        If a log cannot be read, or they cannot be compared.
    """
    read = [read_table_of(source, reading, utility, report=report) for source in (old, new)]
    laws, utilities = [law for _, law, _ in read], [own for _, _, own in read]
    valued = list(zip(laws, utilities, strict=True))
    for law, source in zip(laws, (old, new), strict=True):
        with naming(source_name(source)):
            confidence_for(law, confidence, confidence, {}, reading.spelled)
    unknown = [_undecided(law, own, undecided) for law, own in valued]
    for label in undecided:
        if not any(label in law.decisions for law in laws):
            raise InputError(f"{reading.spelled('undecided')} names the decision {shown(label)}, which occurs in neither of the two logs")
    if confidence is None:
        alone = [
            certify(*each, confidence=None, declared=options.get("declared", {}), undecided=labels)
            for each, labels in zip(valued, unknown, strict=True)
        ]
        return ComparedLogs(
            (alone[0], alone[1]), compare(*alone, margin=margin), (), None, "nothing is said of what the logs were drawn from"
        )
    alpha = 1 - confidence

    def certified(level: Fraction) -> tuple[Result, Result]:
        own: dict[str, Any] = {"confidence": 1 - level, "one_sided": True, **options}
        first, second = (certify(*each, **own, undecided=labels) for each, labels in zip(valued, unknown, strict=True))
        return first, second

    results = certified(equal_share(alpha, 2))
    found = compare(*results, margin=margin)
    if not all("local" in result.intervals for result in results):
        return ComparedLogs(results, found, (), confidence, "of one of the logs no interval for the local ratio is stated")
    cells, most, unpaired = _cells(
        [table for table, _, _ in read],
        reading,
        utilities[0],
        drop=options["missing_units"] == "drop",
        lost=sorted({label for labels in unknown for label in labels}),
    )
    if unpaired:
        return ComparedLogs(results, found, (), confidence, unpaired)
    half = equal_share(alpha, 2)
    sharper = compare(*certified(equal_share(half, 2)), margin=margin)
    change = greatest_change(cells, most, half)
    assumed = (PAIRED, *((BY_DESIGN,) if options["missing_units"] == "drop" else ()))
    fairness: list[Fairness] = []
    for entry, own in zip(found.fairness, sharper.fairness, strict=True):
        fairness.append(sharpened(entry, own, change, assumed) if entry.quantity == "local" else entry)
    return ComparedLogs(results, replace(found, fairness=tuple(fairness)), paired_rates(cells, most, alpha), confidence)


def _undecided(law: Law, utility: Utility, named: Sequence[str]) -> tuple[str, ...]:
    """Which decisions of a log may have meant anything: those named, and of an evaluation log the answers that decide nothing."""
    of_log, _ = undecided_of_log((), law, utility, {}, judged=False)
    return tuple(label for label in law.decisions if label in (*named, *of_log))


def _cells(tables: list[Any], reading: Reading, utility: Utility, *, drop: bool, lost: Sequence[str]) -> tuple[Cells, Fraction, str]:
    """What the units of each cell got in the two logs, the greatest utility, and why that is not compared."""
    nothing: tuple[Cells, Fraction] = ({}, Fraction(0))
    if not reading.unit:
        return *nothing, f"{reading.spelled('unit')} says which rows of the two logs are about the same"
    if reading.utility_column is not None:
        return *nothing, f"the utility is that of each row ({reading.spelled('utility_column')})"
    if lost:
        return *nothing, f"some decisions may have meant anything ({', '.join(map(shown, lost))})"
    law = _joint(tables, reading)
    table = utility.on(law)
    if len(law.cell_context) > MOST_CELLS:
        return *nothing, f"there are more than {MOST_CELLS} cells"
    spans = [(start, end) for start, end in pairwise(law.starts.tolist()) if end - start == len(WHICH)]
    profiles = unit_profiles(table)
    if not profiles or len(spans) != len(law.contexts):
        return *nothing, "no unit is in both, or a group is in one of them only"
    names = len(reading.context)
    places = [law.contexts[int(law.cell_context[start])] for start, _ in spans]
    cells = {(place[:names], place[names:]): own for place, own in zip(places, profiles, strict=True)}
    if not (drop or units_alike(cells)):
        return *nothing, (
            f"some units are in one of the logs only; if that is by design, {reading.spelled('missing_units')} drop compares the others"
        )
    return cells, table.gamma, ""


def _joint(tables: list[Any], reading: Reading) -> Law:
    """Both logs as one, in which the contexts and groups are contexts and the log is the group."""
    which = next(
        name for name in ("log", "which log", "which of the two logs") if name not in (*reading.beside, reading.decision, *reading.unit)
    )
    names = tuple(dict.fromkeys((reading.decision, *reading.context, *reading.group, *reading.unit)))
    rows: dict[tuple[Any, ...], int] = {}
    for number, table in enumerate(tables):
        values = [table[name] for name in names]
        found = getattr(table, "evaluation", None)
        dropped = ERROR if found is not None and found.errors == "drop" else None
        for row, times in zip(zip(*values, strict=True), counted(table, len(values[0])).tolist(), strict=True):
            key = (*row, WHICH[number])
            if dropped is None or row[0] != dropped:
                rows[key] = rows.get(key, 0) + times
    tally = Tally.of("both logs", (*names, which), ((*row, times) for row, times in rows.items()))
    contexts = (*reading.context, *reading.group)
    return Law.from_log(tally, decision=reading.decision, group=which, context=contexts, unit=reading.unit, missing=reading.missing)
