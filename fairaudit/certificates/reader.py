"""What a certificate holds, read back from its JSON: the table as a law, its figures as measures.

A certificate is believed here; `fairaudit verify` is what checks one.
"""

from __future__ import annotations

import json
import os
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from math import inf, lcm
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from fairaudit.errors import InputError, shown
from fairaudit.exact.rationals import common_denominator
from fairaudit.measures.differences import MeanDifference
from fairaudit.measures.ratios import Ratio, Witness
from fairaudit.model.law import Law
from fairaudit.model.layout import Columns, Truth, Units
from fairaudit.model.unknown import UnknownRows
from fairaudit.model.utility import UtilityTable
from fairaudit.tables.values import INT64

if TYPE_CHECKING:
    from fairaudit.model.mechanism import Mechanism
    from fairaudit.model.policy import Deployment


__all__ = ["Subject", "load", "mean_difference", "number", "ratio", "subject"]


FORMAT = "fairaudit-certificate/1"

OTHER_FORMATS = ("fairaudit-proxies/1", "fairaudit-subgroups/1")

MAX_BYTES = 1 << 30  # what the checker reads, too


@dataclass(frozen=True, eq=False)
class Subject:
    """What a certificate is about, when it holds its table.

    Attributes
    ----------
    law : Law
        The law; behind filters the one that they induce.
    utility : UtilityTable
        The utility on it.
    deployment : Deployment or None
        The policy and its filters, if that is what was audited.
    """

    law: Law
    utility: UtilityTable
    deployment: Deployment | None = None


def load(
    path: str | os.PathLike[str], formats: Sequence[str] = (FORMAT,), unwrap: Callable[[bytes], bytes] = bytes
) -> tuple[dict[str, Any], bytes]:
    """Read a certificate file.

    Parameters
    ----------
    path : path
        The file.
    formats : sequence of str
        Those that are accepted.
    unwrap : callable
        Takes the document out of what else the file may hold.

    Returns
    -------
    tuple of dict and bytes
        The document, and the bytes of the file.

    Raises
    ------
    InputError
        If it cannot be read, or is no certificate of this format.
    """
    try:
        with Path(path).open("rb") as file:
            raw = file.read(MAX_BYTES + 1)
        if len(raw) > MAX_BYTES:
            raise InputError(f"it is longer than {MAX_BYTES} bytes, which no certificate is")
        document = json.loads(unwrap(raw))
    except OSError as error:
        hint = ""
        if Path(path).is_dir():
            hint = f"; give {'certificate.json' if (Path(path) / 'certificate.json').is_file() else 'a file'} in it"
        raise InputError(f"{path} cannot be read: {error.strerror or error}{hint}") from None
    except (ValueError, RecursionError) as error:
        if isinstance(error, InputError):
            raise InputError(f"{path}: {error}") from None
        raise InputError(f"{path} is not JSON, as a certificate is") from None
    if not isinstance(document, dict) or document.get("format") not in formats:
        form = document.get("format") if isinstance(document, dict) else None
        of = f", but of {shown(form)}" if isinstance(form, str) else ""
        stated = isinstance(document, dict) and not document.keys().isdisjoint(("predicateType", "payloadType"))
        raise InputError(f"{path} is not a certificate of the format {FORMAT}{', but an attestation of one' if stated else of}")
    return document, raw


def number(text: str) -> Fraction | float:
    """Read a rational of a certificate, or ``"inf"``.

    Examples
    --------
    >>> number("5/4"), number("inf")
    (Fraction(5, 4), inf)
    """
    return inf if text == "inf" else _rational(text)


def ratio(entry: Mapping[str, Any] | None) -> Ratio | None:
    """Read a metric with a ratio and a witness; None where it was not measured."""
    if entry is None:
        return None
    found = entry["witness"]
    values = found["expectations"] if "expectations" in found else found["probabilities"]
    pair = (_rational(values[0]), _rational(values[1]))
    return Ratio(number(entry["ratio"]), Witness(found.get("context"), found["higher"], found["lower"], pair, found.get("decision")))


def mean_difference(entry: Mapping[str, Any] | None) -> MeanDifference | None:
    """Read a difference of expected utilities with its witness; None where it was not measured."""
    if entry is None:
        return None
    found = entry["witness"]
    pair = (_rational(found["expectations"][0]), _rational(found["expectations"][1]))
    return MeanDifference(_rational(entry["value"]), Witness(found.get("context"), found["higher"], found["lower"], pair))


def subject(document: Mapping[str, Any]) -> Subject | None:
    """Read the table of a certificate back; None when the certificate does not hold it.

    Raises
    ------
    InputError
        If the document does not have the shape of a certificate.

    Examples
    --------
    >>> from fairaudit.audits.certify import certify
    >>> law = Law.from_array([[3, 1], [1, 1]], kind="counts", decisions=["yes", "no"], groups=["f", "m"])
    >>> found = subject(certify(law, {"yes": 1}).certificate.document)
    >>> found.law.weights.tolist(), found.utility.gamma
    ([[3, 1], [1, 1]], Fraction(1, 1))
    """
    try:
        table = document["subject"]["table"]
        if "header" not in table:
            return None
        if table["header"]["kind"] == "policy":
            return _policy(table["header"], table["rows"])
        intervals = document.get("intervals", {})
        units = (intervals.get(name, {}).get("units") for name in ("local", "local_difference"))
        return _plain(table["header"], table["rows"], next(filter(None, units), None))
    except (KeyError, IndexError, TypeError, ValueError, AttributeError, ZeroDivisionError) as error:
        if isinstance(error, InputError):
            raise
        raise InputError("this is no certificate of the format; fairaudit verify says what is wrong with it") from None


def _plain(header: Mapping[str, Any], rows: list[dict[str, Any]], units: Any) -> Subject:
    unknown = [row for row in rows if "unknown" in row]
    rows = [row for row in rows if "unknown" not in row]
    law = _law(header, rows, header["kind"], header["population"])
    if unknown:
        law = replace(law, unknown=_unknown(unknown, law.scale))
    if units is not None:
        compared = np.flatnonzero(law.compared).tolist()
        profiles: list[tuple[tuple[int, tuple[int, ...]], ...]] = [()] * len(rows)
        for cell, entries in zip(compared, units, strict=True):
            profiles[cell] = tuple((n, tuple(counts)) for n, counts in entries)
        law = replace(law, units=Units((), sum(n for cell in profiles for n, _ in cell), 1, once_per_group=False, profiles=tuple(profiles)))
    if "truths" in header:
        law = replace(law, truth=_truth(header, rows, law.scale))
    return Subject(law, _utility(header, law, rows))


def _unknown(rows: list[dict[str, Any]], scale: int) -> UnknownRows:
    listed = [[int(_rational(w) * scale) for w in row["unknown"]] for row in rows]
    return UnknownRows(np.array([row["context"] for row in rows], dtype=np.int64), _array(listed, len(listed[0])))


def _truth(header: Mapping[str, Any], rows: list[dict[str, Any]], scale: int) -> Truth:
    listed = [[int(_rational(w) * scale) for part in row["truth"] for w in part] for row in rows]
    shape = (len(listed), len(header["truths"]), len(header["decisions"]))
    return Truth(tuple(header["truths"]), _array(listed, shape[1] * shape[2]).reshape(shape))


def _policy(header: Mapping[str, Any], rows: list[dict[str, Any]]) -> Subject:
    from fairaudit.model.policy import Deployment, Policy
    from fairaudit.model.releases import check_releases

    shown = [row for row in rows if "weights" in row]
    true = [row for row in rows if "weights" not in row]
    sampled = any("draws" in row for row in shown)
    if sampled:
        shown = [{**row, "weights": [str(row["draws"] * _rational(w)) for w in row["weights"]]} for row in shown]
    law = _law(header, shown, "counts" if sampled else "probabilities", "counts" if sampled else "equal")
    group, context = (_mechanism(header["filters"][name]) for name in ("group", "context"))
    if group is None:
        raise InputError("the certificate has no group filter")
    mass = None
    if header["population"] == "weights":
        mass = tuple(common_denominator([_pair(row["mass"]) for row in true])[0])
    deployment = Deployment(Policy(law), group, context, mass, check_releases(header["filters"].get("releases", 1)))
    return Subject(deployment.law, _utility(header, deployment.law, true), deployment)


def _law(header: Mapping[str, Any], rows: list[dict[str, Any]], kind: Any, population: Any) -> Law:
    """The law of the rows as integers over one denominator."""
    weights = [[_pair(w) for w in row["weights"]] for row in rows]
    scale = lcm(*{d for row in weights for _, d in row}) if kind == "counts" else 1
    whole = [[n * (scale // d) for n, d in row] if kind == "counts" else common_denominator(row)[0] for row in weights]
    columns = header["columns"]
    return Law(
        columns=Columns(columns["decision"], tuple(columns["group"]), tuple(columns["context"]), columns.get("truth")),
        decisions=tuple(header["decisions"]),
        groups=tuple(tuple(label) for label in header["groups"]),
        contexts=tuple(tuple(label) for label in header["contexts"]),
        kind=kind,
        population=population,
        cell_context=np.array([row["context"] for row in rows], dtype=np.int64),
        cell_group=np.array([row["group"] for row in rows], dtype=np.int64),
        weights=_array(whole, len(header["decisions"])),
        scale=scale,
        mass=tuple(common_denominator([_pair(row["mass"]) for row in rows])[0]) if population == "weights" else None,
    )


def _utility(header: Mapping[str, Any], law: Law, rows: list[dict[str, Any]]) -> UtilityTable:
    if header["utility"] is not None:
        values, scale = common_denominator([_pair(v) for v in header["utility"]])
        return UtilityTable(law, _array([values], len(values))[0], scale, None)
    entries = [[(0, 1) if v is None else _pair(v) for v in row["utility"]] for row in rows]
    width = len(header["decisions"])
    flat, scale = common_denominator([pair for row in entries for pair in row])
    given = np.array([[v is not None for v in row["utility"]] for row in rows], dtype=bool)
    listed = [flat[i : i + width] for i in range(0, len(flat), width)]
    return UtilityTable(law, _array(listed, width), scale, None if given.all() else given)


def _mechanism(factors: list[dict[str, Any]] | None) -> Mechanism | None:
    from fairaudit.model.mechanism import Factor, Mechanism

    if factors is None:
        return None
    made = []
    for entry in factors:
        flat, scale = common_denominator([_pair(v) for row in entry["rows"] for v in row])
        width = len(entry["outputs"])
        rows = tuple(tuple(flat[i : i + width]) for i in range(0, len(flat), width))
        made.append(Factor(tuple(map(tuple, entry["inputs"])), tuple(map(tuple, entry["outputs"])), rows, scale))
    return Mechanism(tuple(made))


def _array(rows: Iterable[list[int]], width: int) -> NDArray[Any]:
    listed = list(rows)
    small = all(sum(map(abs, row)) <= INT64 for row in listed)
    array = np.empty((len(listed), width), dtype=np.int64 if small else object)
    for i, row in enumerate(listed):
        array[i] = row
    return array


def _rational(text: str) -> Fraction:
    return Fraction(*_pair(text))


def _pair(text: str) -> tuple[int, int]:
    top, _, bottom = text.partition("/")
    sign = -1 if top.startswith("-") else 1
    return sign * _whole(top.removeprefix("-")), _whole(bottom) if bottom else 1


def _whole(digits: str) -> int:
    """An integer of any length, without the interpreter's limit of 4,300 digits."""
    if len(digits) < 4_000:
        return int(digits)
    half = len(digits) // 2
    raised: int = 10**half
    return _whole(digits[:-half]) * raised + _whole(digits[-half:])
