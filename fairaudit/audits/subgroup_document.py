"""The JSON document of the most unequal subgroups, as docs/certificate-subgroups.md describes it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from fractions import Fraction
from typing import TYPE_CHECKING, Any

from fairaudit import __version__
from fairaudit.audits.claims import population_at
from fairaudit.certificates.certificate import EMBED_LIMIT, Certificate, new_salt
from fairaudit.certificates.numbers import number
from fairaudit.certificates.table import log_digests
from fairaudit.inference.cells import Ends
from fairaudit.inference.subgroup_ends import ratio_ends
from fairaudit.tables.preparation import assumption
from fairaudit.theorems.assumptions import range_said
from fairaudit.theorems.t18 import CHOSEN_BEFOREHAND, INDEPENDENT_ROWS
from fairaudit.words import THIS_TABLE

if TYPE_CHECKING:
    from fairaudit.audits.subgroups import Subgroup, Subgroups

FORMAT = "fairaudit-subgroups/1"


def certificate_of(made: Subgroups) -> Certificate:
    """The certificate of what was found, with the table in it or beside it."""
    table = made.log.table
    apart = table.cells > EMBED_LIMIT if made.embed is None else not made.embed
    preparation = {"preparation": [dict(step) for step in made.log.preparation]} if made.log.preparation else {}
    table = replace(table, salt=new_salt() if made.embed is False else None, log=log_digests(preparation))
    entry: dict[str, Any] = {"sha256": table.sha256, "cells": table.cells}
    if not apart:
        entry |= {"header": table.header, "rows": list(table.rows())}
    subject: dict[str, Any] = {"columns": table.header["columns"], "table": entry}
    if made.burden:
        subject["burden"] = True
    subject |= preparation
    rows = table.measured
    document: dict[str, Any] = {
        "format": FORMAT,
        "subject": subject,
        "family": {
            "depth": made.depth,
            "least_rows": made.least_rows,
            **({} if made.share is None else {"least_share": number(made.share)}),
            "conjunctions": str(made.conjunctions),
        },
        "overall": {"rows": rows.rows, "sum": number(Fraction(rows.total, table.scale))},
        "findings": [_finding(one) for one in made.found],
        "frontier": {
            "ratio": number(made.worst.limit),
            "nodes": [{"conditions": _places(node.conditions), "counts": list(node.counts)} for node in made.worst.frontier],
        },
        "claims": _claims(made, table.sha256),
        "targets": [] if made.limit is None else [_target(made, made.limit)],
        "verdict": made.verdict,
        "versions": {"fairaudit": __version__},
    }
    if made.everybody:
        document["family"]["ends"] = [
            {"conditions": _places(conditions), "subgroup": _ends(own), "rest": _ends(rest)} for conditions, own, rest in made.everybody
        ]
    return Certificate(document, table if apart else None)


def _finding(one: Subgroup) -> dict[str, Any]:
    entry: dict[str, Any] = {
        "conditions": dict(one.conditions),
        "rows": one.rows,
        "sum": number(one.mean * one.rows),
        "ratio": number(one.ratio),
        "side": one.side,
        "same": [dict(other) for other in one.same],
    }
    if one.ends is not None and one.rest_ends is not None and one.interval is not None:
        entry |= {"ends": {"subgroup": _ends(one.ends), "rest": _ends(one.rest_ends)}, "interval": [number(end) for end in one.interval]}
    return entry


def _claims(made: Subgroups, digest: str) -> list[dict[str, Any]]:
    left_out = [said for entry in made.log.preparation if (said := assumption(entry))]

    def claim(relation: str, value: Any, scope: str, assumptions: Sequence[str], evidence: dict[str, Any]) -> dict[str, Any]:
        return {
            "quantity": "subgroup_ratio",
            "relation": relation,
            "value": number(value),
            "scope": scope,
            "by": "T18",
            "assumptions": [*assumptions, *left_out],
            "evidence": evidence,
        }

    listed = [claim("=", made.ratio, THIS_TABLE, (), {"table": digest})]
    if made.confidence is not None:
        table = made.log.table
        drawn = (INDEPENDENT_ROWS, range_said(Fraction(0), Fraction(table.measured.values[-1], table.scale)), CHOSEN_BEFOREHAND)
        scope = population_at(made.confidence)
        lower = [one.interval[0] for one in made.found if one.interval is not None]
        best = max(range(len(lower)), key=lambda i: (lower[i], -i))
        listed.append(claim(">=", lower[best], scope, drawn, {"finding": best}))
        if made.everybody:
            upper = max(ratio_ends(own, rest)[1] for _, own, rest in made.everybody)
            listed.append(claim("<=", upper, scope, drawn, {"ends": len(made.everybody)}))
    return listed


def _target(made: Subgroups, limit: Fraction) -> dict[str, Any]:
    judged = THIS_TABLE if made.confidence is None else population_at(made.confidence)
    return {"quantity": "subgroup", "limit": number(limit), "unit": "ratio", "judged": judged, "verdict": made.verdict}


def _places(conditions: Sequence[tuple[int, int]]) -> list[list[int]]:
    return [list(condition) for condition in conditions]


def _ends(ends: Ends) -> list[str]:
    return [number(end) for end in ends]
