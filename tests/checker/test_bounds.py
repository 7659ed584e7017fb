"""Claims by theorems about policies behind filters, against sums over all outputs in plain fractions."""

import copy
import hashlib
import random
from collections.abc import Callable, Iterator
from fractions import Fraction
from typing import Any

import pytest
import tiers
from assumptions import complete
from plain_certificates import INF, checker, edited, false_statements, lines_of, make, raw, text
from policy_certificates import (
    CONTEXT_FILTERS,
    FLOORED,
    GROUP_FILTERS,
    LAW,
    POLICIES,
    SCHEMA,
    SEEDS,
    TINY,
    Policy,
    bounds,
    by_hand,
    exp_epsilon,
    figures,
    hockey_stick,
    random_matrix,
    write,
)

BLOCKS = 8

FEW = 10  # certificates, in which every kind of claim has a finite bound


def blocks(index: int) -> range:
    return range(index * len(SEEDS) // BLOCKS, (index + 1) * len(SEEDS) // BLOCKS)


def judge(seed: int) -> None:
    """A true certificate is accepted; with a claim that is false, or a value that is a little too small, it is not."""
    p = Policy(tiers.fresh(seed))
    certificate = write(p)
    assert false_statements(certificate) == [], seed
    assert seed % 4 or [error.message for error in SCHEMA.iter_errors(certificate)] == [], seed
    lines = lines_of(certificate["subject"]["table"])
    apart = copy.deepcopy(certificate)
    apart["subject"]["table"] = {key: apart["subject"]["table"][key] for key in ("sha256", "cells")}
    assert checker.check(raw(apart), lines).ok
    # Each claim with several values: infinity, the least true one, a little more, and a little less.
    for number in range(4):
        claims, true = [], []
        for claim, least in bounds(p):
            finite = Fraction(0) if least in (None, INF) else least
            values = ["inf", text(least or INF), str(finite + TINY), str(finite - TINY)]
            claims.append(claim | {"value": values[number]})
            true.append(least is not None and (values[number] == "inf" or (least != INF and number < 3)))
        certificate["claims"] = claims
        found = [f.true for f in checker.check(raw(complete(certificate))).findings if f.statement.startswith("claims[")]
        assert found == true, (seed, claims, found)


@pytest.mark.parametrize("block", range(BLOCKS))
def test_random_certificates(block: int) -> None:
    for seed in blocks(block):
        judge(seed)


def test_some_random_certificates_before_every_commit() -> None:
    for seed in SEEDS[:FEW]:
        judge(seed)


def test_the_random_certificates_are_of_many_kinds() -> None:
    seen: dict[Any, list[int]] = {}
    for seed in SEEDS:
        p = Policy(tiers.fresh(seed))
        for claim, least in bounds(p):
            counts = seen.setdefault((claim["by"], claim["scope"]), [0, 0, 0])
            counts[(least is None) + 2 * (least == INF)] += 1
    rules = [(key, rule) for key, rule in checker.claims.RULES.items() if not checker.claims.without_objection(key[3])[1]]
    assert tiers.enough(
        set(seen) == {key[2:] for key, rule in rules if not rule.source and key[3] != checker.claims.UTILITIES and key[2] != "T13"}
    )  # all that judge this policy by a theorem about one release
    for key, (true, none, infinite) in seen.items():
        assert true >= 40 and none + infinite >= 40, key


@pytest.mark.parametrize("block", range(BLOCKS))
def test_claims_hold_for_what_they_speak_of(block: int) -> None:
    """Search for counterexamples: other policies behind the filter, other group filters, other context filters."""
    for seed in blocks(block)[::3]:
        p = Policy(tiers.fresh(seed))
        claims = [(claim, least) for claim, least in bounds(p) if least not in (None, INF)]
        e = exp_epsilon(p.A)
        for trial in range(3):
            pick = random.Random(tiers.fresh(seed * 100 + trial))
            others = {scope: copy.deepcopy(p) for scope in (POLICIES, GROUP_FILTERS, CONTEXT_FILTERS)}
            for i, j in p.T:
                w = [pick.choice([0, 0, 1, 5]) for _ in range(p.n)]
                w[pick.randrange(p.n)] += 1
                others[POLICIES].T[i, j] = [Fraction(v, sum(w)) for v in w]
            # Mixing with one row lowers epsilon; so does taking a row of the product that has it for the pair of lies.
            other = random_matrix(pick, 1, len(p.reach_a))[0]
            mixed = [[Fraction(0)] * len(p.released_a) for _ in p.true_a]
            for a, row in enumerate(mixed):
                own = random_matrix(pick, 1, len(p.reach_a))[0]
                share = Fraction(pick.randint(0, 2), 2)
                for j, v, w in zip(p.reach_a, own, other, strict=True):
                    row[j] = share * v + (1 - share) * w if trial else share * p.A[a][j] + (1 - share) * w
            if exp_epsilon(mixed) <= e:
                others[GROUP_FILTERS].A = mixed
            others[CONTEXT_FILTERS].X = [[Fraction(0)] * len(p.released_x) for _ in p.true_x]
            for row in others[CONTEXT_FILTERS].X:
                for i, v in zip(p.reach_x, random_matrix(pick, 1, len(p.reach_x))[0], strict=True):
                    row[i] = v
            others[FLOORED] = others[POLICIES]
            others[LAW] = p
            for scope, q in others.items():
                q.P = q.induced()
                metrics = figures(q, q.P)["metrics"]
                keeps = min(q.mean(x, a) for x, a in q.cells()) >= p.declared.get("tau", Fraction(0))
                for claim, least in claims:
                    name = claim["quantity"].split("_")[0]
                    if claim["scope"] == scope and metrics[name] and (scope != FLOORED or keeps):
                        measured = metrics[name]["ratio"]
                        assert measured != "inf" and Fraction(measured) <= least, (seed, claim)


@pytest.fixture
def good() -> dict[str, Any]:
    return by_hand()


def place_of(certificate: dict[str, Any], by: str, scope: str) -> str:
    [at] = [i for i, c in enumerate(certificate["claims"]) if (c["by"], c["scope"]) == (by, scope)]
    return f"claims.{at}"


def test_by_hand(good: dict[str, Any]) -> None:
    """The chances are 5/12 and 1/3, the ratio 5/4; unfiltered it is 2, and 2 and e^eps = 2 contract to 5/4."""
    assert false_statements(good) == []
    assert good["metrics"]["local"]["ratio"] == "5/4" and good["metrics"]["unfiltered"]["local"]["ratio"] == "2"
    values = {(c["by"], c["scope"]): c["value"] for c in good["claims"]}
    assert values["T12", GROUP_FILTERS] == "5/4" and values["T2", POLICIES] == "2" and values["floor", LAW] == "3"
    # k = 1 has H = 1/3 and gives 1 + (1/3) / (1/3); k = 1/2 has H = 1/2 and gives 1/2 + (1/2) / (1/3)
    assert values["T3", LAW] == "2" and values["T5-decision", POLICIES] == "2"
    assert values["T3", FLOORED] == "2" and values["floor", FLOORED] == "4"


@pytest.mark.parametrize(
    ("path", "value"),
    [
        ("subject.privacy.group.exp_epsilon", "3"),
        ("subject.privacy.group.exp_epsilon", "inf"),
        ("subject.privacy.group.attributes", []),
        ("subject.privacy.group.attributes.0", "3"),
        ("subject.privacy.context", {"exp_epsilon": "1", "attributes": []}),
        ("subject.declared.tau", "2/5"),
        ("subject.declared", {"gamma": "1/2"}),
        ("subject.declared", {"m": "1/2"}),
        ("subject.declared", {"lipschitz": "1"}),
        ("subject.utility.tau", "1/4"),
        ("subject.table.cells", 2),
        ("metrics.unfiltered", None),
        ("metrics.unfiltered.local", None),
        ("metrics.unfiltered.local.ratio", "5/4"),
        ("metrics.unfiltered.global.witness.expectations", ["5/12", "1/3"]),
        ("metrics.local.ratio", "2"),
        ("subject.kind", "policy2"),
    ],
)
def test_false(good: dict[str, Any], path: str, value: Any) -> None:
    if value == "policy2":  # a certificate of the first kind about the table of a policy
        good["subject"] = {key: item for key, item in good["subject"].items() if key not in ("privacy", "declared")}
        good["subject"] |= {"kind": "probabilities"}
        lines = lines_of(good["subject"].pop("table"))
        good["subject"]["table"] = {"sha256": hashlib.sha256(b"".join(lines)).hexdigest(), "cells": 4}
        del good["metrics"]["unfiltered"]
        assert any(line.startswith("subject.kind") for line in false_statements(good, lines))
        return
    assert false_statements(edited(good, path, value)) != []


def test_false_claims(good: dict[str, Any]) -> None:
    scopes = (LAW, POLICIES, FLOORED, GROUP_FILTERS, CONTEXT_FILTERS, "", "every law")
    keys = {(c["quantity"], c["by"], c["scope"]) for c in good["claims"]}
    for i, claim in enumerate(good["claims"]):
        at = f"claims.{i}"
        for scope in scopes:
            if (claim["quantity"], claim["by"], scope) not in keys:
                lines = false_statements(edited(copy.deepcopy(good), f"{at}.scope", scope))
                assert len(lines) == 1 and ("unknown claim" in lines[0] or claim["by"] == "T8"), (claim, scope, lines)
        double = copy.deepcopy(good)
        double["claims"].append(claim)
        assert "occurs twice" in false_statements(double)[0]
        if claim["by"] not in ("T7", "T5-decision", "T12"):
            continue
        [evidence] = claim["evidence"]
        assert "the evidence is" in false_statements(edited(copy.deepcopy(good), f"{at}.evidence.{evidence}", "7/5"))[0]
    for by, bad in (("T3", ["3"]), ("T1", ["1/9"])):
        assert (
            "the multipliers prove no less"
            in false_statements(edited(copy.deepcopy(good), f"{place_of(good, by, LAW)}.evidence.multipliers", bad))[0]
        )


@pytest.mark.parametrize("by", ["T1-paper", "T1", "T3", "floor"])
def test_a_declared_floor_has_to_be_declared(good: dict[str, Any], by: str) -> None:
    place = place_of(good, by, FLOORED)
    del good["subject"]["declared"]["tau"]
    lines = false_statements(good)
    assert len(lines) == 4 and all("no floor is declared" in line for line in lines)
    good["subject"]["declared"]["tau"] = "0"
    assert sum("the floor is 0" in line for line in false_statements(good)) == 4
    good["claims"] = [good["claims"][int(place.split(".")[1])] | {"value": "inf"}]
    assert "the floor is 0" in false_statements(good)[0]


def test_declared_constants_are_used(good: dict[str, Any]) -> None:
    good["subject"]["declared"]["gamma"] = "3/2"
    assert sorted({line.split('"')[-4 if " for " in line else -2] for line in false_statements(good)}) >= ["T1", "T3", "floor"]
    good["subject"]["declared"] = {"lipschitz": "1/8", "tau": "1/4"}
    lines = "".join(false_statements(good))
    for by in ("T2", "T12", "T3", "T1", "T1-paper"):
        assert f'by "{by}"' in lines
    assert 'by "T5-decision"' not in lines and 'by "floor"' not in lines


@pytest.mark.parametrize(
    ("path", "value"),
    [
        ("subject.privacy", ...),
        ("subject.declared", ...),
        ("metrics.unfiltered", ...),
        ("subject.declared", None),
        ("subject.declared", {"epsilon": "1"}),
        ("subject.declared", {"tau": "-1"}),
        ("subject.declared", {"tau": "inf"}),
        ("subject.privacy.group", None),
        ("subject.privacy.group.attributes", "2"),
        ("subject.privacy.other", None),
        ("subject.population", "counts"),
        ("metrics.unfiltered.equalized_odds", None),
        ("metrics.unfiltered.global", ...),
        ("subject.table.header.filters", ...),
        ("subject.table.header.filters.context", ...),
        ("subject.table.header.filters.context", []),
        ("subject.table.header.filters.group", []),
        ("subject.table.header.filters.group", None),
        ("subject.table.header.filters.group.0.rows", [["1", "0"]]),
        ("subject.table.header.filters.group.0.rows.0", ["1"]),
        ("subject.table.header.filters.group.0.rows.0", ["2/3", "1/2"]),
        ("subject.table.header.filters.group.0.rows.0", ["4/3", "-1/3"]),
        ("subject.table.header.filters.group.0.inputs", [["f"], ["f"]]),
        ("subject.table.header.filters.group.0.inputs", [[], []]),
        ("subject.table.header.filters.group.0.inputs", []),
        ("subject.table.header.filters.group.0.inputs", [["f", "g"], ["m", "g"]]),
        ("subject.table.header.filters.group.0.outputs", [["f"], ["m", "g"]]),
        ("subject.table.header.filters.group.0.outputs", [["f"], ["d"]]),
        ("subject.table.header.groups", [["f"], ["d"]]),
        ("subject.table.rows.0.weights", ["1/2", "1/4"]),
        ("subject.table.rows.0.mass", "1"),
        ("subject.table.rows.1.group", 0),
        ("subject.table.rows.1.true_group", 0),
        ("subject.table.rows.2", {"true_context": 0, "true_group": 0}),
        ("claims.0.evidence", {}),
    ],
)
def test_malformed(good: dict[str, Any], path: str, value: Any) -> None:
    if path.endswith("rows.2"):
        good["subject"]["table"]["rows"].append(None)
    with pytest.raises(checker.FormatError):
        checker.check(raw(edited(good, path, value)))


@pytest.mark.parametrize("by", ["T1", "T2", "T3", "T12", "T5-decision", "floor"])
def test_malformed_evidence(good: dict[str, Any], by: str) -> None:
    claim = next(c for c in good["claims"] if c["by"] == by)
    wrong: list[Any] = [{"table": "0" * 64}, {"multipliers": []}, {"multipliers": ["-1"]}, {"multipliers": ["inf"]}, {"raw_ratio": "x"}]
    for evidence in [*wrong, {"composition": 1}, None, claim["evidence"] | {"more": "1"}]:
        claim_before = claim["evidence"]
        claim["evidence"] = evidence
        with pytest.raises(checker.FormatError):
            checker.check(raw(good))
        assert not SCHEMA.is_valid(good)
        claim["evidence"] = claim_before


def test_keys_of_a_policy_are_unknown_elsewhere() -> None:
    certificate = make({(0, 0): ["1", "1"], (0, 1): ["1", "3"]}, ["1", "0"])
    assert false_statements(certificate) == []
    for path, value in (
        ("subject.privacy", {}),
        ("subject.declared", {}),
        ("metrics.unfiltered", None),
        ("subject.table.header.filters", {}),
    ):
        with pytest.raises(checker.FormatError):
            checker.check(raw(edited(copy.deepcopy(certificate), path, value)))
        assert not SCHEMA.is_valid(edited(copy.deepcopy(certificate), path, value))
    foreign = {"quantity": "local_ratio", "relation": "<=", "value": "inf", "assumptions": []}
    for by, scope, evidence in (("T2", POLICIES, {}), ("floor", LAW, {}), ("T3", LAW, {"multipliers": ["1"]})):
        certificate["claims"] = [foreign | {"by": by, "scope": scope, "evidence": evidence}]
        assert "unknown claim" in false_statements(certificate)[0]
        assert not SCHEMA.is_valid(certificate)


def test_every_value_of_a_wrong_type() -> None:
    """Whatever stands anywhere, the outcome is a report or a FormatError."""
    certificate = write(next(p for p in map(Policy, SEEDS) if p.context and p.mass and not isinstance(p.given, list) and len(p.T) < 7))

    def replace_all(value: Any, put: Callable[[Any], None]) -> None:
        junk: Any
        for junk in (None, True, 7, "", "1/3", "inf", [], {}, [[]], [None], {"a": []}):
            put(junk)
            try:
                checker.check(raw(certificate))
            except checker.FormatError as error:
                assert len(str(error)) < 1000
        put(value)
        for key in list(value) if isinstance(value, dict) else range(len(value)) if isinstance(value, list) else ():
            replace_all(value[key], lambda item, key=key: value.__setitem__(key, item))  # type: ignore[misc]

    for key in ("subject", "metrics", "claims"):
        replace_all(certificate[key], lambda item, key=key: certificate.__setitem__(key, item))  # type: ignore[misc]
    assert checker.check(raw(certificate)).ok


def test_figures_that_are_a_little_different() -> None:
    """Each number in the subject and the metrics is changed; looser declared constants are true, nothing else is."""
    for seed in range(0, 60, 3):
        certificate = write(Policy(tiers.fresh(seed)))
        places = list(numbers(certificate["subject"], ["subject"])) + list(numbers(certificate["metrics"], ["metrics"]))
        for path in places:
            parent: Any = certificate
            for step in path[:-1]:
                parent = parent[step]
            before = parent[path[-1]]
            change = TINY if path[-1] in ("gamma", "lipschitz") or "declared" not in path else -TINY
            parent[path[-1]] = "2" if before == "inf" else str(max(Fraction(0), Fraction(before) + change))
            if parent[path[-1]] != before:
                try:
                    lines = [line for line in false_statements(certificate) if not line.startswith("claims")]
                except checker.FormatError:
                    assert "table" in path  # probabilities that do not sum to 1
                else:
                    assert (lines == []) is ("declared" in path), (seed, path)
            parent[path[-1]] = before
        assert false_statements(certificate) == []


def numbers(value: Any, path: list[Any]) -> Iterator[list[Any]]:
    if isinstance(value, str) and (value == "inf" or value[:1].isdigit()) and len(value) < 60 and "log" not in path:
        yield path
    for key in list(value) if isinstance(value, dict) else range(len(value)) if isinstance(value, list) else ():
        yield from numbers(value[key], [*path, key])


def test_a_filter_that_releases_other_values_breaks_the_contraction() -> None:
    """A policy that treats two values alike has R0 = 1; a filter that releases a third one shows that it is treated otherwise."""
    h = [Fraction(1), Fraction(1), Fraction(0)]
    other = [[Fraction(1, 2), Fraction(1, 4), Fraction(1, 4)], [Fraction(1, 4), Fraction(1, 4), Fraction(1, 2)]]
    assert exp_epsilon(other) == 2
    one, two = (sum(p * v for p, v in zip(row, h, strict=True)) for row in other)
    assert one / two > (1 + 1 * 2) / Fraction(1 + 2)


def test_a_policy_that_breaks_the_declared_floor_breaks_its_bound() -> None:
    """With the floor at its highest, k = 0 proves R <= 1; behind the same filter another policy has 2."""
    row = [Fraction(2, 3), Fraction(1, 3)]
    assert 0 + 1 * hockey_stick((row, row[::-1]), Fraction(0)) / 1 == 1
    assert row[0] / row[1] == 2
