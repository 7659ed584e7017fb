"""`verify --coq`: a certificate as a file that Coq checks, with a table that a person can read."""

from __future__ import annotations

import json
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from hashlib import sha256
from typing import Any

from fairaudit.certificates.reader import FORMAT
from fairaudit.errors import InputError, TableNeeded, shown
from fairaudit.verified import coq_logarithms, coq_policy, coq_worst_case
from fairaudit.verified.coq_statements import Statement, definitions, induced_table, stated_table, statements, theorem
from fairaudit.verified.coq_text import Audited, comment, label, named

__all__ = ["CoqFile", "coq_file"]

_REQUIRED = """\
From Coq Require Import ZArith QArith String Ascii List.
From FairauditKernel Require Fractions WorstCase.
From FairauditChecker Require Table Statements Policy.
Import ListNotations.
Local Open Scope Q_scope."""


@dataclass(frozen=True)
class CoqFile:
    """The text of a file for Coq, and how many statements of the certificate it proves and leaves out."""

    text: str
    proved: int
    left: int


def coq_file(document: Mapping[str, Any], raw: bytes, lines: Iterable[bytes] | None = None) -> CoqFile:
    """Write what a certificate states as definitions and theorems of Coq, so far as that is covered.

    Nothing of the certificate has to be true: the file of a false one does not compile.

    Parameters
    ----------
    document : mapping
        A well-formed certificate.
    raw : bytes
        The bytes of its file.
    lines : iterable of bytes, optional
        Its table, where it does not hold it.

    Raises
    ------
    InputError
        If nothing that it states is covered.
    TableNeeded
        If it does not hold its table, which is not given either.
    """
    if document["format"] != FORMAT:
        raise InputError(f"certificates of the format {shown(document['format'])} are not covered by what is written for Coq")
    subject = document["subject"]
    header, rows = _table(subject["table"], lines)
    if "unknown" in header:
        raise InputError("tables with decisions of unknown group are not covered by what is written for Coq")
    behind = subject["kind"] == "policy"
    own = coq_policy.law_header(header) if behind else header
    stated = statements(document, own)
    of_policy = [(i, claim) for i, claim in enumerate(document["claims"]) if behind and coq_policy.is_covered(claim, header)]
    of_class = [(i, claim) for i, claim in enumerate(document["claims"]) if coq_worst_case.is_covered(claim)]
    places = {f"claims[{i}]" for i, _ in (*of_class, *of_policy)}
    of_table = [one for one in stated if one.covered]
    enclosed = coq_logarithms.enclosures(document["metrics"])
    in_nats = dict(coq_logarithms.limits(document["targets"], document["metrics"]))
    places |= {f"targets[{i}]" for i in in_nats}
    left = [one for one in stated if not one.covered and one.place not in places]
    if not of_class and not of_table and not of_policy and not enclosed:
        raise InputError("nothing that this certificate states is covered by what is written for Coq")
    logarithms, of_logarithms = coq_logarithms.theorems(enclosed, list(in_nats.values()))
    exact = ["Proved_of_the_table.all_hold"] * bool(of_table) + ["Proved_of_the_policy.all_claims_hold"] * bool(of_policy)
    exact += coq_worst_case.theorem_names(of_class)
    table = induced_table() if behind else stated_table(header, rows, subject)
    parts = [
        *_opening(raw, subject["table"]["sha256"], left),
        _REQUIRED,
        *_labels(own),
        comment("==== What is said: this part has to be read ===="),
        *([coq_policy.definitions(Audited(subject, header, rows), of_policy)] if behind else []),
        *([definitions(table, of_table)] if of_table else []),
        *([coq_logarithms.definitions(enclosed, list(in_nats.values()))] if enclosed else []),
        *([coq_worst_case.definitions(Audited(subject, header, rows), of_class)] if of_class else []),
        comment("==== What is proved of it ===="),
        _libraries(bool(of_table or of_policy), bool(enclosed), bool(of_class)),
        *([theorem()] if of_table else []),
        *([coq_policy.theorem()] if of_policy else []),
        *([logarithms] if enclosed else []),
        *([coq_worst_case.theorems(of_class)] if of_class else []),
        comment("What the theorems rest on; those about logarithms on the three axioms of the real numbers of mathcomp-analysis"),
        *([_resting("theorems", exact)] if exact else []),
        *([_resting("theorems_about_logarithms", of_logarithms)] if enclosed else []),
    ]
    text = "\n\n".join(part if isinstance(part, str) else "\n".join(part) for part in parts)
    return CoqFile(f"{text}\n", len(of_table) + len(of_policy) + len(enclosed) + len(in_nats) + len(of_class), len(left))


def _resting(name: str, theorems: Sequence[str]) -> list[str]:
    return [f"Definition all_{name} := {_together(theorems)}.", f"Print Assumptions all_{name}."]


def _together(names: Sequence[str]) -> str:
    terms = [f"@{name}" for name in names]
    return terms[0] if len(terms) == 1 else f"({', '.join(terms)})"


def _libraries(of_table: bool, of_logarithms: bool, of_class: bool) -> str:
    needed = ["From mathcomp Require Import all_ssreflect all_algebra.", "From FairauditKernel Require Import FractionsSound."]
    needed += ["From FairauditChecker Require Meaning PolicyMeaning AllTrue."] * of_table
    needed += ["From FairauditKernel Require WorstCaseSound."] * of_class
    needed += ["From mathcomp.analysis Require Import reals.", "From FairauditChecker Require NatsSound."] * of_logarithms
    return "\n".join(needed)


def _table(table: Mapping[str, Any], lines: Iterable[bytes] | None) -> tuple[Mapping[str, Any], Sequence[Mapping[str, Any]]]:
    if "header" in table:
        return table["header"], table["rows"]
    if lines is None:
        raise TableNeeded("the certificate does not hold its table; give the file of the table")
    header, *rows = map(json.loads, lines)
    return header, rows


def _opening(raw: bytes, digest: str, left: Sequence[Statement]) -> Iterator[list[str]]:
    yield [comment("A certificate of fairaudit, to be checked by Coq alone.")]
    yield [
        "(* SHA-256 of the certificate and of its table. Coq looks at neither: compare the numbers below with the certificate.",
        f"     certificate {sha256(raw).hexdigest()}",
        f"     table       {label(digest)}",
        "",
        "   In the folder proofs/ of fairaudit, after make:",
        "     coqc -R theories Fairaudit -R kernel FairauditKernel -R checker FairauditChecker FILE.v",
        "   If this says nothing but what the theorems rest on, they are proved. *)",
    ]
    if left:
        yield [
            comment("The certificate also states what is not proved here:"),
            *(comment(f"{one.place}: {one.said}") for one in left),
        ]


def _labels(header: Mapping[str, Any]) -> Iterator[list[str]]:
    columns = header["columns"]
    yield [
        comment(
            "What the numbers of decisions, groups, contexts and true labels stand for. Signs that could mean something to Coq are codes."
        ),
        *(comment(f"decision {i}: {named([columns['decision']], [text])}") for i, text in enumerate(header["decisions"])),
        *(comment(f"group {i}: {named(columns['group'], labels)}") for i, labels in enumerate(header["groups"])),
        *(comment(f"context {i}: {named(columns['context'], labels)}") for i, labels in enumerate(header["contexts"])),
        *(comment(f"true label {i}: {named([columns['truth']], [text])}") for i, text in enumerate(header.get("truths", []))),
    ]
