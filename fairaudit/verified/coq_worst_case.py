"""A class of utilities and the claims about the worst one of it, in a Coq file."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from fairaudit.verified.coq_text import Audited, Claims, boolean, comment, entries, integer, items, named, option, pair, rational

__all__ = ["definitions", "is_covered", "theorem_names", "theorems"]

SCOPE = "every utility of the class"

_LOCAL = """\
Theorem no_utility_is_worse (R : realFieldType) (g : utility R) :
  in_class K T g ->
  forall c d, In c (cells T) -> In d (cells T) -> In (context c) (contexts T) -> context c = context d -> group c <> group d ->
  local_floor K T g c d ->
  (expectation g c <= ratio bound * expectation g d)%R.
Proof. move=> g_in; apply: (@worst_case_local R K T bound evidence) => //; vm_compute; reflexivity. Qed."""

_GLOBAL = """\
Theorem no_utility_is_worse (R : realFieldType) (g : utility R) :
  in_class K T g ->
  forall a b, In a (everywhere T) -> In b (everywhere T) -> a <> b ->
  global_floor K T g a b ->
  (group_mean T g a <= ratio bound * group_mean T g b)%R.
Proof. move=> g_in; apply: (@worst_case_global R K T bound evidence) => //; vm_compute; reflexivity. Qed."""

_POPULATIONS = {"counts": "Counted", "weights": "Given", "equal": "Alike"}


def is_covered(claim: Mapping[str, Any]) -> bool:
    """Whether a claim is one that multipliers prove, with a finite bound."""
    return bool(claim["by"] == "lp-dual" and claim["scope"] == SCOPE and claim["value"] != "inf")


def definitions(audited: Audited, claims: Claims) -> list[str]:
    """What the claims are about: the table with the utility that is stated, the class, and of each claim the bound and the multipliers.

    Parameters
    ----------
    audited : Audited
        What the certificate is about.
    claims : sequence
        The claims.
    """
    subject, header, rows = audited
    return [
        "Module Worst_case.",
        "Import WorstCase.",
        "",
        comment("The table with the utility that is stated: an outcome has a decision, its weight, its features and its utility."),
        *_table(header, rows, subject["class"]),
        "",
        comment("The class of utilities. What it is to be in it stands in kernel/WorstCaseSound.v as in_class."),
        *_class(header, subject["class"]),
        *(line for number, claim in claims for line in ("", *_claim(number, claim))),
        "End Worst_case.",
    ]


def theorems(claims: Claims) -> list[str]:
    """For each claim the theorem that no utility of the class gives a greater ratio.

    Parameters
    ----------
    claims : sequence
        The claims.
    """

    def proved(number: int, claim: Mapping[str, Any]) -> list[str]:
        theorem = _LOCAL if claim["quantity"] == "local_ratio" else _GLOBAL
        return ["", f"Module Claim_{number}.", f"Import Claim_{number}.", theorem, f"End Claim_{number}."]

    return [
        "Module Proved_of_worst_case.",
        "Import WorstCase WorstCaseSound Worst_case.",
        *(line for number, claim in claims for line in proved(number, claim)),
        "End Proved_of_worst_case.",
    ]


def theorem_names(claims: Claims) -> list[str]:
    """How Coq calls the theorems."""
    return [f"Proved_of_worst_case.Claim_{number}.no_utility_is_worse" for number, _ in claims]


def _cell(row: Mapping[str, Any], header: Mapping[str, Any], features: Sequence[Any] | None) -> str:
    gains = header["utility"] if header["utility"] is not None else row["utility"]
    lists: Sequence[Any] = [[]] * len(gains) if features is None else features
    outcomes = [
        f"Outcome {u} {rational(weight)} {items(map(rational, phi))} {'0' if gain is None else rational(gain)}"
        for u, (weight, gain, phi) in enumerate(zip(row["weights"], gains, lists, strict=True))
    ]
    return f"Cell {integer(row['context'])} {integer(row['group'])} {items(outcomes)} {rational(row.get('mass', '0'))}"


def _table(header: Mapping[str, Any], rows: Sequence[Mapping[str, Any]], utilities: Mapping[str, Any]) -> list[str]:
    features = [None] * len(rows) if utilities["family"] is None else utilities["family"]["features"]
    columns = header["columns"]

    def cell(row: Mapping[str, Any], own: Any) -> tuple[str, str]:
        context, group = header["contexts"][row["context"]], header["groups"][row["group"]]
        return _cell(row, header, own), f"{named(columns['context'], context)}; {named(columns['group'], group)}"

    return [
        "Definition T : table := {|",
        f"  contexts := {items(map(str, range(len(header['contexts']))))}%Z;",
        f"  groups := {items(map(str, range(len(header['groups']))))}%Z;",
        f"  population := {_POPULATIONS[header['population']]};",
        f"  cells := {entries([cell(row, own) for row, own in zip(rows, features, strict=True)], '    ')}",
        "|}.",
    ]


def _bounded(terms: Sequence[str], bound: object) -> str:
    return pair(items(terms), rational(bound))


def _class(header: Mapping[str, Any], utilities: Mapping[str, Any]) -> list[str]:
    def nullable(value: object) -> str:
        return option(None if value is None else rational(value))

    def term(of: Sequence[Any]) -> str:
        x, a, u, coefficient = of
        return f"Term {integer(x)} {'(-1)' if a is None else integer(a)} {integer(u)} {rational(coefficient)}"

    decisions = header["decisions"]
    metric, family = utilities["metric"], utilities["family"]
    distances = option(None if metric is None else items(items(map(rational, row)) for row in metric))
    order = items(pair(str(decisions.index(low)), str(decisions.index(high))) for low, high in utilities["order"])
    parameters = "None"
    if family is not None:
        rows = items(_bounded(list(map(rational, row["coefficients"])), row["bound"]) for row in family["rows"])
        ends = f"{items(map(rational, family['lower']))} {items(map(rational, family['upper']))}"
        parameters = option(f"(Family {ends} {rows})")
    return [
        "Definition K : utilities := {|",
        f"  local := {boolean(utilities['quantity'] == 'local')};",
        f"  gamma := {rational(utilities['gamma'])};",
        f"  least := {rational(utilities['m'])};",
        f"  tau := {nullable(utilities['tau'])};",
        f"  on_pair := {boolean(utilities['tau_on'] == 'pair')};",
        f"  blind := {boolean(utilities['blind'])};",
        f"  lipschitz := {nullable(utilities['lipschitz'])};",
        f"  metric := {distances};",
        f"  order := {order}%Z;",
        f"  rows := {entries([_bounded(list(map(term, row['terms'])), row['bound']) for row in utilities['rows']], '    ')};",
        f"  parameters := {parameters}",
        "|}.",
    ]


def _claim(number: int, claim: Mapping[str, Any]) -> list[str]:
    local = claim["quantity"] == "local_ratio"

    def entry(of: Mapping[str, Any]) -> str:
        multipliers = items(pair(f"{integer(i)}%Z", rational(y)) for i, y in of["multipliers"])
        context = integer(of["context"]) if local else "(-1)"
        return f"Evidence {context} {integer(of['higher'])} {integer(of['lower'])} {multipliers}"

    return [
        f"Module Claim_{number}.",
        comment("The bound, and for each pair (context, higher and lower group) the constraints that prove it, with their factors"),
        f"Definition bound : Q := {rational(claim['value'])}.",
        f"Definition evidence : list evidence := {entries([entry(of) for of in claim['evidence']['pairs']])}.",
        f"End Claim_{number}.",
    ]
