"""What is measured, as entries of a certificate: ratios, distances, rates, intervals, changes, privacy."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from fairaudit.certificates.certificate import EMBED_LIMIT
from fairaudit.certificates.numbers import log_text, number
from fairaudit.certificates.table import Table
from fairaudit.errors import InputError
from fairaudit.exact.rationals import rational_text
from fairaudit.inference.comparisons import Comparison
from fairaudit.inference.interval import Interval
from fairaudit.measures.differences import MeanDifference
from fairaudit.measures.distances import Distance
from fairaudit.measures.rates import Difference, Rate
from fairaudit.measures.ratios import Ratio
from fairaudit.model.law import Law
from fairaudit.theorems.assumptions import WINDOWS

if TYPE_CHECKING:
    from fairaudit.inference.bounded_differences import Differences
    from fairaudit.inference.changes import Change
    from fairaudit.inference.rates import GivenTruth
    from fairaudit.model.mechanism import Mechanism


def change_assumptions(change: Change) -> list[str]:
    """What rests on the reader's judgement where a window is said to contradict the stream."""
    return [*change.stream.assumptions, WINDOWS]


def change_entry(change: Change) -> dict[str, Any]:
    """The change as a certificate stores it: docs/certificate-monitor.md."""
    window = Table(change.window.law, change.window.utility)
    if window.cells > EMBED_LIMIT:
        raise InputError(f"the window has a table of {window.cells} entries; a certificate about a change holds at most {EMBED_LIMIT}")
    return {
        "quantity": change.quantity,
        "window": change.window.number,
        "confidence": number(change.confidence),
        "stream": interval_entry(change.stream, None, None),
        "table": {"sha256": window.sha256, "cells": window.cells, "header": window.header, "rows": list(window.rows())},
        "ratio": interval_entry(change.part, None, None),
        "assumptions": change_assumptions(change),
    }


def measure_entry(measured: Ratio | Distance) -> dict[str, Any]:
    """Write a measure as a certificate stores it."""
    entry = ratio_entry(measured) if isinstance(measured, Ratio) else distance_entry(measured)
    return entry or {}


def left_out_entry(entry: Mapping[str, Any]) -> dict[str, Any]:
    """An entry of `not_compared` as a certificate stores it: labels as lists."""
    stored = dict(entry)
    if "context" in entry:
        stored["context"] = list(entry["context"].values())
    if "groups" in entry:
        stored["groups"] = [list(group.values()) for group in entry["groups"]]
    return stored


def privacy_entry(mechanism: Mechanism) -> dict[str, Any]:
    """Privacy of a filter as a certificate stores it."""
    from fairaudit.model.mechanism import Mechanism
    from fairaudit.privacy.epsilon_delta import exp_epsilon

    return {
        "exp_epsilon": number(exp_epsilon(mechanism)),
        "attributes": [number(exp_epsilon(Mechanism((factor,)))) for factor in mechanism.factors],
    }


def add_given_truth(document: dict[str, Any], given: GivenTruth) -> None:
    """Put what is measured given the true label into a certificate: docs/certificate.md."""
    document["subject"]["positive"] = {"decision": list(given.positive.decision), "truth": given.positive.truth}
    document["metrics"] |= dict.fromkeys(given.rates)  # filled in where the table is in the certificate
    document["metrics"] |= {name: _difference_entry(found) for name, found in given.differences.items()}
    if given.intervals:
        document.setdefault("intervals", {}).update({name: interval.evidence for name, interval in given.intervals.items()})


def add_differences(document: dict[str, Any], found: Differences, law: Law) -> None:
    """Put differences of expected utilities into a certificate: docs/certificate.md."""
    document["metrics"] |= {f"{quantity}_difference": mean_difference_entry(measured) for quantity, measured in found.measured.items()}
    for quantity, interval in found.intervals.items():
        limits = found.comparisons[quantity].limits
        entry = {key: value for key, value in interval.evidence.items() if key not in ("cells", "blocks")}
        entry["limits"] = None if limits is None else [number(limit) for limit in limits]
        entry["difference"] = [number(interval.lower), number(interval.upper)]
        if quantity == "local" and interval.of_units is not None:
            entry |= _units_entry(law, interval.estimand, mean_difference_entry(interval.of_units))
        document.setdefault("intervals", {})[f"{quantity}_difference"] = entry


def mean_difference_entry(measured: MeanDifference | None) -> dict[str, Any] | None:
    """A difference of expected utilities with its witness; None where nothing could be compared."""
    if measured is None:
        return None
    witness = measured.witness
    entry: dict[str, Any] = {} if witness.context is None else {"context": witness.context}
    entry |= {"higher": witness.higher, "lower": witness.lower, "expectations": [number(v) for v in witness.expectations]}
    return {"value": number(measured.value), "witness": entry}


def rate_entry(law: Law, rate: Rate) -> dict[str, Any]:
    """One group's rate given the true label, in its context or over all of them."""
    where = {} if rate.context is None else {"context": law.context_label(rate.context)}
    return {**where, "group": law.group_label(rate.group), "rate": number(rate.value)}


def _difference_entry(measured: Difference | None) -> dict[str, Any] | None:
    if measured is None:
        return None
    entry: dict[str, Any] = {} if measured.context is None else {"context": measured.context}
    entry |= {"rate": measured.kind, "higher": measured.higher, "lower": measured.lower, "rates": [number(v) for v in measured.rates]}
    return {"value": number(measured.value), "witness": entry}


def interval_entry(interval: Interval, comparison: Comparison | None, law: Law | None) -> dict[str, Any]:
    """An interval as a certificate stores it: docs/certificate-samples.md."""
    entry = {key: value for key, value in interval.evidence.items() if key not in ("cells", "blocks")}
    if comparison is not None:
        entry["limits"] = None if comparison.limits is None else [number(limit) for limit in comparison.limits]
    entry["ratio"] = [number(interval.lower), number(interval.upper)]
    if law is not None and interval.of_units is not None:
        entry |= _units_entry(law, interval.estimand, ratio_entry(interval.of_units))
    return entry


def _units_entry(law: Law, estimand: str, measured: dict[str, Any] | None) -> dict[str, Any]:
    """The sampling units behind an interval, and what they give in the sample."""
    if law.units is None:
        return {}
    compared = np.flatnonzero(law.compared).tolist()
    units = [[[n, list(rows)] for n, rows in law.units.profiles[cell]] for cell in compared]
    return {"estimand": estimand, "measured": measured, "units": units}


def ratio_entry(measured: Ratio | None) -> dict[str, Any] | None:
    """A ratio with the enclosure of its logarithm and its witness; None where nothing could be compared."""
    if measured is None:
        return None
    witness = measured.witness
    entry: dict[str, Any] = {}
    if witness.context is not None:
        entry["context"] = witness.context
    if witness.decision is not None:
        entry["decision"] = witness.decision
    entry |= {"higher": witness.higher, "lower": witness.lower}
    entry["expectations" if witness.decision is None else "probabilities"] = [number(v) for v in witness.expectations]
    lo, hi = measured.log
    return {"ratio": number(measured.ratio), "log": [log_text(lo), log_text(hi)], "witness": entry}


def distance_entry(measured: Distance | None) -> dict[str, Any] | None:
    """A distance with its witness; None where nothing could be compared."""
    if measured is None:
        return None
    witness = measured.witness
    entry: dict[str, Any] = {} if witness.context is None else {"context": witness.context}
    entry |= {"higher": witness.higher, "lower": witness.lower, "decisions": list(witness.decisions)}
    return {"value": rational_text((measured.value.numerator, measured.value.denominator)), "witness": entry}
