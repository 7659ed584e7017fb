"""Certificates of tables with true labels, by definition: rates in plain fractions, and their differences over all pairs of groups."""

from __future__ import annotations

import hashlib
from collections.abc import Mapping, Sequence
from fractions import Fraction
from itertools import permutations, product
from random import Random as Pick
from typing import Any

import tiers
from plain_certificates import lines_of, make

Counts = Mapping[tuple[int, int], Sequence[Sequence[str]]]
"""Of each context and group, for each true label the counts of the decisions."""

REASONS = {"true": "no decisions with the positive true label", "false": "no decisions with another true label"}


def truth_certificate(
    counts: Counts,
    *,
    positive: tuple[Sequence[int], int] = ((0,), 0),
    shape: tuple[int, int] | None = None,
    pooled: bool = True,
    **options: Any,
) -> dict[str, Any]:
    """Write the true certificate of a table given by its rows.

    Parameters
    ----------
    counts : mapping
        The counts, by context and group.
    positive : pair
        The positive decisions, and the positive true label.
    shape : pair, optional
        How many contexts and groups.
    pooled : bool
        Whether there is a column of contexts; if not, there is one context.
    **options
        `utility` and what else `make` takes.
    """
    decisions, wanted = positive
    weights = {cell: [str(sum(map(Fraction, column))) for column in zip(*rows, strict=True)] for cell, rows in counts.items()}
    utility = options.pop("utility", ["1"] + ["0"] * (len(next(iter(weights.values()))) - 1))
    document = make(weights, utility, shape=shape, **options)
    table, metrics, left_out = document["subject"]["table"], document["metrics"], document["not_compared"]
    header = table["header"]
    for row in table["rows"]:
        row["truth"] = [list(of_label) for of_label in counts[row["context"], row["group"]]]
    labels = range(len(next(iter(counts.values()))))
    header["columns"] = document["subject"]["columns"] = header["columns"] | {"truth": "T"}
    header["truths"] = [f"t{t}" for t in labels]
    document["subject"]["positive"] = {"decision": [f"u{u}" for u in decisions], "truth": f"t{wanted}"}
    n_contexts, n_groups = len(header["contexts"]), len(header["groups"])

    def numbers(kind: str, cells: Sequence[tuple[int, int]]) -> tuple[Fraction, Fraction]:
        rows = [counts[cell][t] for cell in cells for t in labels if (t == wanted) is (kind == "true")]
        return sum(Fraction(row[u]) for row in rows for u in decisions) + Fraction(0), sum(
            Fraction(n) for row in rows for n in row
        ) + Fraction(0)

    found: dict[tuple[str, bool], list[tuple[int, int, Fraction]]] = {}
    for kind, overall in product(("true", "false"), (False, True)[: 1 + pooled]):
        rates = found[kind, overall] = []
        name = f"{kind}_positive_rate{'_overall' * overall}"
        for x in [-1] if overall else range(n_contexts):
            cells = {a: [(y, a) for y in range(n_contexts) if (y, a) in counts and (overall or y == x)] for a in range(n_groups)}
            here = [a for a in cells if cells[a]]
            have = [(x, a, p / n) for a in here for p, n in [numbers(kind, cells[a])] if n]
            rates += have
            at = {"quantity": name} | ({} if overall else {"context": header["contexts"][x]})
            if lacking := [header["groups"][a] for a in here if a not in [b for _, b, _ in have]]:
                left_out.append(at | {"groups": lacking, "reason": REASONS[kind]})
            if len(have) < 2 <= len(here):
                left_out.append(at | {"reason": "fewer than two groups"})
        metrics[name] = [
            ({} if overall else {"context": {"C": f"x{x}"}}) | {"group": {"G": f"a{a}"}, "rate": str(rate)} for x, a, rate in rates
        ]
    for name, kinds in (("equal_opportunity", ["true"]), ("equalized_odds_true_label", ["true", "false"])):
        for overall in (False, True)[: 1 + pooled]:
            by_kind = [
                [(one[2] - other[2], kind, one, other) for one, other in permutations(found[kind, overall], 2) if one[0] == other[0]]
                for kind in kinds
            ]
            cases = sorted((case for cases in by_kind for case in cases), key=lambda c: (kinds.index(c[1]), c[2][0], c[2][1], c[3][1]))
            quantity = name + "_overall" * overall
            metrics[quantity] = None
            if not all(by_kind):
                continue
            value = max(case[0] for case in cases)
            _, kind, one, other = next(case for case in cases if case[0] == value)
            place: dict[str, Any] = {} if overall else {"context": {"C": f"x{one[0]}"}}
            place |= {"rate": f"{kind}_positive_rate", "higher": {"G": f"a{one[1]}"}, "lower": {"G": f"a{other[1]}"}}
            metrics[quantity] = {"value": str(value), "witness": place | {"rates": [str(one[2]), str(other[2])]}}
            claim = {
                "quantity": quantity,
                "relation": "=",
                "by": "enumeration",
                "value": str(value),
                "scope": "this law",
                "assumptions": [],
            }
            document["claims"].append(claim | {"evidence": {"table": table["sha256"]}})
    if not pooled:
        header["columns"]["context"] = []
        document = _without_context(document)
    return with_digest(document)


def _without_context(value: Any) -> Any:
    """The same with the label of the one context taken away."""
    if value in ({"C": "x0"}, ["x0"]):
        return type(value)()
    if isinstance(value, dict):
        return {key: _without_context(inner) for key, inner in value.items()}
    return [_without_context(inner) for inner in value] if isinstance(value, list) else value


def with_digest(document: dict[str, Any]) -> dict[str, Any]:
    """Bring the digests in line with the table."""
    table = document["subject"]["table"]
    sha = hashlib.sha256(b"".join(lines_of(table))).hexdigest()
    for claim in document["claims"]:
        if "table" in claim["evidence"]:
            claim["evidence"]["table"] = sha
    table["sha256"] = sha
    return document


def random_truth_certificate(seed: int) -> dict[str, Any]:
    """A small table: single groups, missing cells, counts of 0, up to three true labels, several positive decisions."""
    pick = Pick(tiers.fresh(f"truth {seed}"))
    contexts, groups, decisions, truths = (pick.choice(sizes) for sizes in ([1, 2, 2, 3], [1, 2, 2, 3, 4], [1, 2, 2, 3], [1, 2, 2, 3]))
    cells = [cell for cell in product(range(contexts), range(groups)) if pick.random() < 0.85] or [(0, 0)]
    zeros = pick.choice([1, 2, 6])
    counts = {}
    for cell in cells:
        rows = [[str(pick.choice([0] * zeros + [1, 1, 2, 5, 10**19, Fraction(1, 3)])) for _ in range(decisions)] for _ in range(truths)]
        if not any(Fraction(n) for row in rows for n in row):
            rows[pick.randrange(truths)][pick.randrange(decisions)] = "1"
        counts[cell] = rows
    positive = sorted(pick.sample(range(decisions), pick.randint(1, decisions))), pick.randrange(truths)
    limits = tuple(pick.sample([("local", "ratio", "2"), ("global", "log", "1/10"), ("local", "log", "3")], pick.randint(0, 2)))
    pooled = contexts > 1 or pick.random() < 0.5
    return truth_certificate(counts, positive=positive, shape=(contexts, groups), pooled=pooled, limits=limits)
