"""A policy behind filters and the claims about it, in a Coq file: in the words of proofs/checker/Policy.v."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from itertools import product
from typing import Any

from fairaudit.errors import InputError
from fairaudit.verified.coq_text import Audited, Claims, boolean, comment, entries, items, label, named, option, pair, rational

__all__ = ["definitions", "is_covered", "law_header", "theorem"]

POLICIES = "any policy behind this filter"
FLOORED = f"{POLICIES} that keeps the declared floor"
GROUP_FILTERS = "this policy and context filter, any group filter at most this epsilon that releases the same values"
ANY_UTILITY = f"{POLICIES}, any utility of the declared range"
CONTEXT_FILTERS = "this policy and group filter, any context filter that releases these contexts"

_SCOPES = {
    "this law": "ThisLaw",
    POLICIES: "AnyPolicy",
    FLOORED: "KeepingFloor",
    GROUP_FILTERS: "AnyGroupFilter",
    CONTEXT_FILTERS: "AnyContextFilter",
    ANY_UTILITY: "AnyUtility",
}
_PLAIN = {"T1-paper": "ByT1paper", "T2": "ByT2", "T5": "ByT5", "T8": "ByT8", "floor": "ByFloor"}
_MULTIPLIED = {"T1": "ByT1", "T3": "ByT3", "T4": "ByT4"}
_RATIOED = {"T5-decision": ("ByT5decision", "composition"), "T12": ("ByT12", "raw_ratio")}


def is_covered(claim: Mapping[str, Any], header: Mapping[str, Any]) -> bool:
    """Whether a claim is one about a policy behind filters that `policy_claim` of proofs/checker/PolicyChecker.v judges."""
    if claim["by"] == "T13":  # of all policies that see one release: of the greatest local ratio, and of that of any utility of a range
        said = claim["quantity"], claim["relation"], claim["scope"]
        known = said in (("local_ratio_supremum", "=", POLICIES), ("local_ratio", "<=", ANY_UTILITY))
        return known and claim["value"] != "inf" and "releases" not in header["filters"]
    of_law = claim["scope"] == "this law" and claim["by"] == "T5"
    known = claim["by"] in _PLAIN or claim["by"] in _MULTIPLIED or claim["by"] in _RATIOED
    return claim["quantity"] in ("local_ratio", "global_ratio") and claim["scope"] in _SCOPES and known and not of_law


def _joined(lists: Sequence[Sequence[Sequence[str]]]) -> list[list[str]]:
    """All ways to take one list of each, joined; the last varies fastest."""
    return [[text for part in parts for text in part] for parts in product(*lists)]


def _reachable(factor: Mapping[str, Any]) -> list[int]:
    return [j for j in range(len(factor["outputs"])) if any(row[j] != "0" for row in factor["rows"])]


def _released(factors: Sequence[Mapping[str, Any]]) -> list[list[str]]:
    return _joined([[factor["outputs"][j] for j in _reachable(factor)] for factor in factors])


def law_header(header: Mapping[str, Any]) -> dict[str, Any]:
    """The header of the law that policy and filters induce: its groups and contexts are the true ones.

    Parameters
    ----------
    header : mapping
        The header of the policy's table.
    """
    filters = header["filters"]
    contexts = header["contexts"] if filters["context"] is None else _joined([factor["inputs"] for factor in filters["context"]])
    return {**header, "contexts": contexts, "groups": _joined([factor["inputs"] for factor in filters["group"]])}


def _matrix(factor: Mapping[str, Any]) -> str:
    return items(items(rational(row[j]) for j in _reachable(factor)) for row in factor["rows"])


def _nullable(stated: Mapping[str, Any], key: str) -> str:
    return option(rational(stated[key]) if key in stated else None)


def _declared(stated: Mapping[str, Any], true: Mapping[str, Any]) -> str:
    numbers = {tuple(labels): i for i, labels in enumerate(true["contexts"])}
    own = items(
        f"DeclaredIn {numbers[tuple(one['context'])]} {' '.join(_nullable(one, key) for key in ('gamma', 'm', 'tau'))}"
        for one in stated.get("by_context", [])
    )
    return f"Declared {' '.join(_nullable(stated, key) for key in ('gamma', 'm', 'tau', 'lipschitz', 'global_tau', 'max_drift'))} {own}"


def _cells(rows: Sequence[Mapping[str, Any]], true: Mapping[str, Any], key: str) -> list[list[Any]]:
    given = {(row["true_context"], row["true_group"]): row[key] for row in rows if "true_context" in row}
    return [[given[x, a] for a in range(len(true["groups"]))] for x in range(len(true["contexts"]))]


def _behind(subject: Mapping[str, Any], header: Mapping[str, Any], rows: Sequence[Mapping[str, Any]]) -> list[str]:
    filters, true = header["filters"], law_header(header)
    laws = {(row["context"], row["group"]): row["weights"] for row in rows if "weights" in row}
    groups = {tuple(labels): a for a, labels in enumerate(header["groups"])}
    contexts = {tuple(labels): x for x, labels in enumerate(header["contexts"])}
    of_contexts = header["contexts"] if filters["context"] is None else _released(filters["context"])
    policy = []
    for context in of_contexts:
        own = []
        for group in _released(filters["group"]):
            x, a = contexts[tuple(context)], groups[tuple(group)]
            if (x, a) not in laws:
                raise InputError(
                    "policies that lack a row for what the filters release with no probability are not covered by what is written for Coq"
                )
            own.append(items(map(rational, laws[x, a])))
        policy.append((items(own), named(header["columns"]["context"], context)))
    seen = f"(AsIs {len(header['contexts'])})" if filters["context"] is None else f"(Filtered {items(map(_matrix, filters['context']))})"
    masses = None
    if header["population"] == "weights":
        masses = items(items(map(rational, row)) for row in _cells(rows, true, "mass"))
    if header["utility"] is not None:
        utility = f"OfDecision {items(map(rational, header['utility']))}"
    else:
        utility = f"OfCell {items(items(items(map(rational, gains)) for gains in row) for row in _cells(rows, true, 'utility'))}"
    return [
        "Definition S : behind := {|",
        f"  group_filter := {items(map(_matrix, filters['group']))};",
        f"  context_filter := {seen};",
        f"  releases := {int(filters.get('releases', 1))};",
        f"  decisions := {len(header['decisions'])};",
        f"  policy_laws := {entries(policy, '    ')};",
        f"  population := {option(masses)};",
        f"  utility := {utility};",
        f"  stated := {_declared(subject['declared'], true)}",
        "|}.",
    ]


def _reason(claim: Mapping[str, Any], true: Mapping[str, Any]) -> str:
    by, evidence = claim["by"], claim["evidence"]
    if by == "T13" and claim["scope"] == ANY_UTILITY:
        return "(ByT13range [])"
    if by == "T13":
        attained = evidence["attained"]
        if attained is None:
            return "(ByT13 None)"
        context = option(None if attained["context"] is None else f"{true['contexts'].index(attained['context'])}%nat")
        return f"(ByT13 (Some (Pair {context} {true['groups'].index(attained['higher'])} {true['groups'].index(attained['lower'])})))"
    if by in _PLAIN:
        return _PLAIN[by]
    if by in _MULTIPLIED:
        return f"({_MULTIPLIED[by]} {items(map(rational, evidence['multipliers']))})"
    name, key = _RATIOED[by]
    return f"({name} {_value(evidence[key])})"


def _value(text: str) -> str:
    return option(None if text == "inf" else rational(text))


def _claim(claim: Mapping[str, Any], true: Mapping[str, Any]) -> str:
    means, exactly = boolean(claim["quantity"] == "global_ratio"), boolean(claim["relation"] == "=")
    return pair(f"Statement {means} {exactly} {_value(claim['value'])} {_SCOPES[claim['scope']]}", _reason(claim, true))


def definitions(audited: Audited, claims: Claims) -> list[str]:
    """The filters, the policy, the utility and what was declared; and the claims, each with its theorem and evidence.

    Parameters
    ----------
    audited : Audited
        What the certificate is about.
    claims : sequence
        The claims.
    """
    subject, header, rows = audited
    said = [(_claim(claim, law_header(header)), f"claims[{i}]: {label(claim['quantity'])} by {label(claim['by'])}") for i, claim in claims]
    return [
        "Module Behind_filters.",
        "Import Policy.",
        "",
        comment(
            "A row of a filter has the probabilities of what is released, for each input; outputs that are never released are left out."
        ),
        comment("The rows of the policy are by released context and, within that, by released group:"),
        *(
            comment(f"released group {i}: {named(header['columns']['group'], labels)}")
            for i, labels in enumerate(_released(header["filters"]["group"]))
        ),
        *_behind(subject, header, rows),
        *(
            [
                "",
                comment("What each of them says of the policy stands in checker/PolicyMeaning.v, as policy_holds."),
                f"Definition all_claims : list (statement * reason) := {entries(said)}.",
            ]
            if claims
            else []
        ),
        "End Behind_filters.",
    ]


def theorem() -> list[str]:
    """The theorem that all claims hold."""
    return [
        "Module Proved_of_the_policy.",
        "Import Policy Behind_filters.",
        "Theorem all_claims_hold (R : realFieldType) : forall c, In c all_claims -> PolicyMeaning.policy_holds R S c.1.",
        "Proof. apply: AllTrue.all_claims_hold; vm_compute; reflexivity. Qed.",
        "End Proved_of_the_policy.",
    ]
