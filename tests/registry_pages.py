"""What the registry of claims says on the pages, in the schema and in the index of proofs, as each should have it.

FAIRAUDIT_GOLDEN=1 pytest tests/theorems/test_registry.py writes it.
"""

from __future__ import annotations

import json
import re
import tomllib
from collections.abc import Callable, Iterable
from itertools import product
from pathlib import Path
from typing import Any

from fairaudit.theorems.bound import (
    ANY_CONTEXT_FILTER,
    ANY_POLICY,
    ANY_UTILITY,
    ANY_UTILITY_FLOORED,
    FLOORED,
    NEAR_POLICY,
    THIS_LAW,
    THIS_POLICY,
)
from fairaudit.theorems.kind import Kind
from fairaudit.theorems.registry import (
    DIFFERENCES,
    EVERY_UTILITY,
    EXPECTED_DIFFERENCES,
    KINDS,
    ONE_SIDED,
    SAMPLED,
    is_sampled,
    under,
    without_objection,
)
from fairaudit.words import DRIFTING, HIDDEN, WHATEVER, WHOEVER

ROOT = Path(__file__).resolve().parents[1]
PROOFS = ROOT / "proofs"
STATED = re.compile(r"^(?:Theorem|Corollary) (\w+)", re.MULTILINE)
WIDTH = 140

# Scopes by the short names that the tables of the pages use.
SCOPES = {
    THIS_LAW: "law",
    ANY_POLICY: "policies",
    NEAR_POLICY: "near",
    FLOORED: "floored",
    ANY_UTILITY: "range",
    ANY_UTILITY_FLOORED: "floored range",
    THIS_POLICY: "group filters",
    ANY_CONTEXT_FILTER: "context filters",
    EVERY_UTILITY: "class",
    f"{THIS_LAW}, {WHOEVER}": "law, whoever the unknown are",
    SAMPLED: "population",
    ONE_SIDED: "one-sided",
    f"{THIS_LAW}, {DRIFTING}": "law, drifting",
    f"{ONE_SIDED}, {DRIFTING}": "one-sided, drifting",
    under(THIS_LAW, WHATEVER): "law, whatever the undecided meant",
    under(SAMPLED, WHATEVER): "population, whatever the undecided meant",
    under(ONE_SIDED, WHATEVER): "one-sided, whatever the undecided meant",
    under(THIS_LAW, HIDDEN): "law, hidden context",
    under(SAMPLED, HIDDEN): "population, hidden context",
    under(ONE_SIDED, HIDDEN): "one-sided, hidden context",
}
RULES = {
    "any": "certificate.md#claims",
    "table": "certificate-objections.md#drift",
    "policy": "certificate-policy.md#claims",
    "class": "certificate-worst-case.md#the-claim",
    "sample": "certificate-samples.md#claims",
    "labels": "certificate-samples.md#differences-of-rates",
}
UNDER = {
    WHOEVER: "certificate-objections.md#decisions-of-unknown-group",
    DRIFTING: "certificate-objections.md#drift",
    WHATEVER: "certificate-objections.md#undecided-decisions",
}
"""The pages of claims that take an objection into account."""

SHAPES: dict[str, Any] = {
    "table": {"$ref": "#/$defs/digest"},
    "multipliers": {"type": "array", "items": {"$ref": "#/$defs/nonnegative"}},
    "pairs": {"type": "array"},
    "attained": {"$ref": "#/$defs/attained"},
    "policy": {"$ref": "#/$defs/attaining_policy"},
    "completion": {"$ref": "#/$defs/completion"},
    "proof": {"$ref": "#/$defs/proof_of_least"},
    "reached": {"$ref": "#/$defs/reached"},
    "pair": {"anyOf": [{"type": "null"}, {"$ref": "#/$defs/attained"}]},
    "ends": {"enum": ["local", "global"]},
    "followed": {"type": "array", "items": {"type": "array", "items": {"type": "string"}}},
    "limit": {"$ref": "#/$defs/nonnegative"},
    "verdict": {"enum": ["within", "exceeds"]},
    "interval": {"enum": ["local", "global", *EXPECTED_DIFFERENCES, *DIFFERENCES]},
    "frontier": {"$ref": "#/$defs/frontier"},
    "hidden_context": {"$ref": "#/$defs/hidden_context"},
}
"""What the evidence is, by its key; any other key holds a number."""


def sources() -> dict[str, str]:
    """The file of each statement of the proofs, as the index names it."""
    files = sorted([*PROOFS.glob("theories/*.v"), *PROOFS.glob("kernel/*.v")])
    return {name: f"{path.parent.name}/{path.name}" for path in files for name in STATED.findall(path.read_text("utf-8"))}


def unique(items: Iterable[str]) -> list[str]:
    return list(dict.fromkeys(items))


def by_source() -> dict[str, list[Kind]]:
    """The kinds of claims by what they cite, in the order of the registry."""
    found: dict[str, list[Kind]] = {}
    for kind in KINDS:
        found.setdefault(kind.by, []).append(kind)
    return found


def listed(names: Iterable[str]) -> str:
    return ", ".join(f"`{name}`" for name in names)


# docs/claims.md


def kinds_table() -> str:
    """Every kind of claim, one row each."""
    lines = [
        "| kind | `by` | in words | `quantity` | `relation` | scope | needs | lists | `evidence` | rule, and why |",
        "| --- | --- | --- | --- | --- | --- | --- | --- | --- | --- |",
    ]
    for kind in KINDS:
        relations = ", ".join(f"`{relation}`" for relation in kind.relations)
        scopes = ", ".join(SCOPES[scope] for scope in kind.scopes)
        always = unique(name for scope in kind.scopes for quantity in kind.quantities for name in kind.listed(scope, quantity))
        only = {"declared-floor": " (floored)", **(dict.fromkeys(kind.overall, " (global)") if len(kind.quantities) > 1 else {})}
        floor = [f"`{name}`{only.get(name, '')}" for name in always]
        may = [f"perhaps {listed(kind.may_assume)}"] if kind.may_assume else []
        evidence = listed(filter(None, (kind.evidence, *kind.beside)))
        rule = UNDER.get(without_objection(kind.scopes[0])[1]) or RULES["table" if kind.by == "T16" else kind.subject]
        pages = f"[rule]({rule}), [why]({kind.anchor})"
        cells = (f"`{kind.id}`", f"`{kind.by}`", kind.says, listed(kind.quantities), relations, scopes, _needed(kind))
        lines.append(f"| {' | '.join((*cells, '; '.join([', '.join(floor), *may]).strip('; '), evidence, pages))} |")
    return "\n".join(lines)


def _needed(kind: Kind) -> str:
    """What has to hold, with the scopes where that is more."""
    more = {need: [SCOPES[scope] for scope in kind.scopes if need in kind.asks(scope)] for s in kind.scopes for need in kind.asks(s)}
    return ", ".join(need + ("" if len(where) == len(kind.scopes) else f" ({', '.join(where)})") for need, where in more.items())


def with_confidence(scope: str, confidence: str = "c") -> str:
    """A scope with the confidence where that stands."""
    opening = next((opening for opening in (SAMPLED, ONE_SIDED) if scope.startswith(opening)), None)
    return scope if opening is None else opening + confidence + scope.removeprefix(opening)


def scopes_table() -> str:
    """The scopes by their short names."""
    lines = ["| | `scope` |", "| --- | --- |"]
    lines += [f"| {short} | `{with_confidence(scope)}` |" for scope, short in SCOPES.items()]
    return "\n".join(lines)


def _with_confidence(scope: str) -> str:
    """A scope as it is written: of a population with a confidence c."""
    about, objection = without_objection(scope)
    return under(f"{about}c" if is_sampled(about) else about, objection)


# docs/proofs.md and proofs/index.toml


def proofs_table() -> str:
    """What stands behind each name that a claim can cite."""
    files = sources()
    lines = ["| by | in words | proved in |", "| --- | --- | --- |"]
    for by, kinds in by_source().items():
        proved = [f"`proofs/{file}`" for file in unique(files[name] for kind in kinds for name in kind.coq)]
        instead = unique(kind.reason for kind in kinds if kind.reason)
        lines.append(f"| `{by}` | {' '.join(kind.says for kind in kinds)} | {'; '.join([*proved, *instead])} |")
    return "\n".join(lines)


def index_entries() -> str:
    """The entries of the index of proofs for what claims cite; the tests that they name are kept."""
    files = sources()
    old = tomllib.loads((PROOFS / "index.toml").read_text("utf-8"))["cited"]
    entries = []
    for by, kinds in by_source().items():
        modules = unique(name.split(".")[-2] for kind in kinds for name in kind.code)
        tests = old.get(by, {}).get("tests") or [f"tests/theorems/test_{module}.py" for module in modules]
        lines = [f"[cited.{by}]", f"says = {_toml(' '.join(kind.says for kind in kinds))}"]
        coq = unique(name for kind in kinds for name in kind.coq)
        if not coq:
            lines += ['statements = "none"', f"reason = {_toml(kinds[0].reason)}"]
        lines.append(f"tests = [{', '.join(map(_toml, tests))}]")
        if coq:
            lines += [f"[cited.{by}.statements]", *(f"{name} = {_toml(files[name])}" for name in coq)]
        entries.append("\n".join(lines))
    return "\n\n".join(entries)


def _toml(text: str) -> str:
    return json.dumps(text, ensure_ascii=False)


# The schema


def schema_text() -> str:
    """The definitions of a claim, of one about a class, and of one about a population, as the schema file spells them."""
    population = [{"$ref": "#/$defs/population_at_confidence"}, {"$ref": "#/$defs/population_one_sided"}]
    scopes = [scope for scope in SCOPES if not is_sampled(scope)]
    objected = [_scope(scope) for scope in SCOPES if is_sampled(scope) and scope not in (SAMPLED, ONE_SIDED)]
    keys = unique(key for kind in KINDS for key in (kind.evidence, *kind.beside) if key)
    shapes = {key: SHAPES.get(key, {"$ref": "#/$defs/extended"}) for key in keys}
    shapes["theta"] = {"$ref": "#/$defs/vector"}
    claim = {
        "description": (
            "A statement about the law in the table, the population behind it, what a policy and its filters may be changed to, or a class "
            "of utilities."
        ),
        "type": "object",
        "required": ["quantity", "relation", "value", "scope", "by", "assumptions", "evidence"],
        "additionalProperties": False,
        "properties": {
            "quantity": {"enum": unique(quantity for kind in KINDS for quantity in kind.quantities)},
            "relation": {"enum": ["=", "<=", ">="]},
            "value": {"$ref": "#/$defs/extended"},
            "scope": {
                "description": "What may be changed without making the statement false.",
                "anyOf": [{"enum": scopes}, *population, *objected],
            },
            "by": {
                "description": (
                    "Enumeration of the table, a floor, a theorem, multipliers of linear constraints, or the method of an interval."
                ),
                "enum": list(by_source()),
            },
            "assumptions": {
                "description": "Sentences that the reader has to judge.",
                "type": "array",
                "items": {"type": "string"},
            },
            "evidence": {
                "description": "What the value follows from.",
                "type": "object",
                "required": [],
                "additionalProperties": False,
                "properties": shapes,
            },
        },
        "oneOf": [*_sampled(), *(entry for kind in KINDS if kind.evidence != "interval" for entry in _stated(kind))],
    }
    of_class = {
        "description": "A claim in a certificate that describes a class of utilities.",
        "properties": {"by": {"enum": unique(kind.by for kind in KINDS if kind.subject == "class")}, "scope": {"const": EVERY_UTILITY}},
    }
    of_population = {
        "description": "A claim in a certificate about the population behind counts or the draws of a policy.",
        "properties": {"by": {"enum": unique(kind.by for kind in KINDS if kind.evidence == "interval")}, "scope": {"anyOf": population}},
    }
    made = {"claim": claim, "claim_about_class": of_class, "claim_about_population": of_population}
    return "".join(f'    "{name}": {_json(entry, 4)},\n' for name, entry in made.items())


def _sampled() -> Iterable[dict[str, Any]]:
    """One entry for each quantity of a population: by what, and which interval it repeats."""
    kinds = [kind for kind in KINDS if kind.evidence == "interval"]
    for quantity, scope in product(unique(quantity for kind in kinds for quantity in kind.quantities), (SAMPLED, ONE_SIDED)):
        own = [kind for kind in kinds if quantity in kind.quantities and scope in kind.scopes]
        if not own:
            continue
        yield {
            "allOf": [{"$ref": "#/$defs/claim_about_population"}],
            "properties": {
                "by": _among(kind.by for kind in own),
                "scope": {"$ref": f"#/$defs/population_{'at_confidence' if scope == SAMPLED else 'one_sided'}"},
                "relation": _among(relation for kind in kinds for relation in kind.relations),
                "quantity": {"const": quantity},
                "assumptions": {"minItems": 1},
                "evidence": {"required": ["interval"], "properties": {"interval": {"const": quantity.removesuffix("_ratio")}}},
            },
        }


def _stated(kind: Kind) -> Iterable[dict[str, Any]]:
    """The entries of a kind; one for each quantity where its evidence differs between them."""
    keys = [key for key in (kind.evidence, *kind.beside) if key]
    shape: dict[str, Any] = {**({"required": keys} if keys else {}), "maxProperties": len(keys)}
    if keys == ["multipliers"] and kind.subject == "policy":
        shape["properties"] = {"multipliers": {"minItems": 1}}
    shapes: list[tuple[tuple[str, ...], dict[str, Any]]] = [(kind.quantities, shape)]
    if keys == ["pairs"]:  # parameters may stand beside them
        dual, shape["maxProperties"] = {"$ref": "#/$defs/dual"}, 2
        context = {"local_ratio": {"required": ["context"]}, "global_ratio": {"properties": {"context": False}}}
        items = {quantity: {"allOf": [dual, context[quantity]]} for quantity in kind.quantities}
        shapes = [((quantity,), {**shape, "properties": {"pairs": {"items": item}}}) for quantity, item in items.items()]
    elif "pairs" in keys:
        shape["properties"] = {"pairs": {"items": {"$ref": "#/$defs/pair_proof"}}}
    for quantities, evidence in shapes:
        yield {
            "properties": {
                "by": {"const": kind.by},
                "relation": _among(kind.relations),
                "quantity": _among(quantities),
                "scope": {"anyOf": list(map(_scope, kind.scopes))} if any(map(is_sampled, kind.scopes)) else _among(kind.scopes),
                "evidence": evidence,
            }
        }


def _scope(scope: str) -> dict[str, Any]:
    """One scope; of a population at any confidence."""
    about, objection = without_objection(scope)
    if not is_sampled(about):
        return {"const": scope}
    if not objection:
        return {"$ref": f"#/$defs/population_{'at_confidence' if scope == SAMPLED else 'one_sided'}"}
    return {"type": "string", "maxLength": 200_080, "pattern": f"^{about}[1-9][0-9]*/([2-9]|[1-9][0-9]+), {objection}$"}


def _among(values: Iterable[str]) -> dict[str, Any]:
    found = unique(values)
    return {"const": found[0]} if len(found) == 1 else {"enum": found}


def _json(value: Any, indent: int) -> str:
    """JSON on one line where it fits, else an entry to a line."""
    flat = json.dumps(value, ensure_ascii=False)
    if not isinstance(value, (dict, list)) or len(flat) + indent < WIDTH - 20:
        return flat
    inner = " " * (indent + 2)
    items = value.items() if isinstance(value, dict) else ((None, item) for item in value)
    lines = [inner + (f"{json.dumps(key)}: " if key is not None else "") + _json(item, indent + 2) for key, item in items]
    left, right = "{}" if isinstance(value, dict) else "[]"
    return left + "\n" + ",\n".join(lines) + f"\n{' ' * indent}{right}"


# Where each stands

PLACES: dict[str, list[tuple[str, str, Callable[[], str]]]] = {
    "docs/claims.md": [
        ("<!-- scopes: made from fairaudit/theorems/registry.py -->\n", "\n<!-- end of scopes -->", scopes_table),
        ("<!-- kinds: made from fairaudit/theorems/registry.py -->\n", "\n<!-- end of kinds -->", kinds_table),
    ],
    "docs/proofs.md": [("<!-- cited: made from fairaudit/theorems/registry.py -->\n", "\n<!-- end of cited -->", proofs_table)],
    "proofs/index.toml": [
        ("# ---- What claims cite, made from fairaudit/theorems/registry.py ----\n\n", "\n\n# ---- Further theorems", index_entries)
    ],
    # JSON has no comments: what is made is all from the definition of a claim up to the one after it.
    "fairaudit/certificates/certificate.schema.json": [('    "claim": {', '    "population_at_confidence": {', schema_text)],
}


def should_be(path: str) -> str:
    """The text of a file with everything in it that is made from the registry."""
    text = (ROOT / path).read_text("utf-8")
    for begin, end, made in PLACES[path]:
        head, opening, rest = text.partition(begin)
        _, closing, tail = rest.partition(end)
        if not opening or not closing:
            raise ValueError(f"{path} lacks {begin.strip()!r} or {end.strip()!r}")
        text = head + ("" if made is schema_text else opening) + made() + closing + tail
    return text
