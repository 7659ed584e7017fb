"""Attestations of certificates, made by hand from the certificate's file: none of the code that writes or reads them is used."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Callable, Iterator, Mapping
from copy import deepcopy
from fractions import Fraction
from pathlib import Path
from typing import Any

PREDICATE_TYPE = "urn:uuid:bd6d62ae-1fd3-4a67-b7b5-0c71c96f4a12"


def counted(document: Mapping[str, Any]) -> tuple[Fraction, dict[str, Fraction]]:
    """What the table of a certificate of counts adds up to, unknown groups included, and what its preparation left out."""
    rows = document["subject"]["table"]["rows"]
    lines = [row.get("weights", row.get("unknown", ())) for row in rows if isinstance(row, dict)]
    total = sum((Fraction(weight) for line in lines for weight in line), Fraction())
    dropped: dict[str, Fraction] = {}
    for step in document["subject"].get("preparation", ()):
        if step["step"] == "left out":
            amount = next(step[unit] for unit in ("decisions", "rows", "lines") if unit in step)
            dropped[step["reason"]] = dropped.get(step["reason"], Fraction()) + Fraction(amount)
    return total, dropped


def amount(value: Fraction) -> int | str:
    return int(value) if value.denominator == 1 else str(value)


def statement_of(path: Path, **changes: Any) -> dict[str, Any]:
    """The statement of a certificate that holds its table of counts."""
    raw = path.read_bytes()
    return statement_about(json.loads(raw), raw, **changes)


def written(certificate: Path, **changes: Any) -> Path:
    """The file a.json beside a certificate, which holds its statement."""
    path = certificate.with_name("a.json")
    path.write_text(json.dumps(statement_of(certificate, **changes)))
    return path


def statement_about(document: Mapping[str, Any], raw: bytes, **changes: Any) -> dict[str, Any]:
    """The same of a document and the bytes of its file."""
    total, dropped = counted(document)
    log = document["subject"].get("evaluation")
    run = {} if log is None else {"run": {"format": log["format"], "model": "a/b"}}
    if log is not None and log["errors"] == "drop" and log["answers"]["error"]:
        dropped["error"] = Fraction(log["answers"]["error"])
    predicate = {
        "issuer": {"name": "Example Audits", "contact": "audits@example.org"},
        "title": "Screening of applicants",
        "system": {"name": "Screener", "version": "4.2"},
        "period": {"start": "2025-01-01", "end": "2025-12-31"},
        "issuedAt": "2026-01-15T09:00:00Z",
        "table": {"sha256": document["subject"]["table"]["sha256"]},
        "sources": [
            {"name": "log.csv", "sha256": "0" * 64, "bytes": 812345, "rows": 12003, **run},
            {"name": "postgresql", "sha256": None, "bytes": None, "rows": 3, "query": "SELECT 1"},
        ],
        "rows": {
            "unit": "decisions",
            "read": amount(total + sum(dropped.values())),
            "counted": amount(total),
            "dropped": {reason: amount(left) for reason, left in dropped.items()},
        },
        "options": {"decision": "answer", "group": ["sex"], "utility": {"yes": "1"}, "query": "SELECT 1", "skip": 2, "extract": "(yes)"},
        "command": ["certify", "log.csv", "--decision", "answer"],
        "versions": {"fairaudit": "0.1.0", "python": "3.12"},
    }
    return {
        "_type": "https://in-toto.io/Statement/v1",
        "subject": [{"name": "certificate.json", "digest": {"sha256": hashlib.sha256(raw).hexdigest()}}],
        "predicateType": PREDICATE_TYPE,
        "predicate": predicate | changes,
    }


def places(value: Any, path: tuple[Any, ...] = ()) -> Iterator[tuple[tuple[Any, ...], Any]]:
    """Every value in a document, and where it is."""
    yield path, value
    entries = value.items() if isinstance(value, dict) else enumerate(value) if isinstance(value, list) else ()
    for key, item in entries:
        yield from places(item, (*path, key))


def altered(document: Any, path: tuple[Any, ...], change: Callable[[Any], Any]) -> Any:
    """A copy of a document in which one value is another."""
    if not path:
        return change(document)
    copy = deepcopy(document)
    at = copy
    for key in path[:-1]:
        at = at[key]
    at[path[-1]] = change(at[path[-1]])
    return copy
