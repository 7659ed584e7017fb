"""A certificate of the most unequal subgroups as it stands: well formed, and perhaps untrue."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from fractions import Fraction
from itertools import pairwise

from .claims import POPULATION
from .conjunctions import Conjunction, read_columns
from .header import Columns, Subject
from .intervals import read_confidence
from .json_values import (
    Labels,
    read_choice,
    read_digest,
    read_integer,
    read_list,
    read_object,
    read_object_of_strings,
    read_string,
    read_strings,
)
from .preparation import MEDIAN, Step, log_digests, read_preparation
from .rationals import ONE, Rational, at_most, read_extended, read_rational, read_two
from .text import malformed, shown
from .work import spend

SUBGROUPS_FORMAT = "fairaudit-subgroups/1"
THIS_TABLE = "this table"

Ends = tuple[Fraction, Fraction]
Conditions = Mapping[str, str]


@dataclass(frozen=True)
class StatedSubgroup:
    """A subgroup that is listed."""

    conditions: Conditions
    rows: int
    total: Rational
    ratio: Rational
    side: str
    same: tuple[Conditions, ...]
    ends: tuple[Ends, Ends] | None
    interval: tuple[Rational, Rational] | None


@dataclass(frozen=True)
class StatedClaim:
    """What is claimed of the greatest ratio."""

    relation: str
    value: Rational
    scope: str
    assumptions: Labels
    evidence: str | int  # a digest; the finding, or the number of conjunctions


@dataclass(frozen=True)
class Stated:
    """A certificate as it stands: well formed, and perhaps untrue."""

    decision: str
    attributes: Labels
    digest: str
    cells: int
    embedded: tuple[object, ...] | None
    preparation: tuple[Step, ...]
    depth: int
    least: int
    share: Rational | None
    family: Rational
    ends: Mapping[Conjunction, tuple[Ends, Ends]] | None  # of all conjunctions, by position
    overall: tuple[int, Rational]
    found: tuple[StatedSubgroup, ...]
    limit: Rational
    frontier: Mapping[Conjunction, tuple[int, ...]]
    claims: tuple[StatedClaim, ...]
    targets: tuple[tuple[Rational, str, str], ...]  # limit, what is judged, verdict
    verdict: str
    confidence: Fraction | None
    log_digests: Mapping[str, str]


def _read_conditions(value: object, where: str, attributes: Labels) -> Conditions:
    spend(len(attributes))
    members = read_object(value, where, (), optional=attributes)
    if not members:
        raise malformed(where, "must not be empty")
    return {name: read_string(item, f"{where}[{shown(name)}]") for name, item in members.items()}


def _read_places(value: object, where: str) -> Conjunction:
    pairs = [read_list(item, where, 2) for item in read_list(value, where)]
    places = tuple((read_integer(a, where), read_integer(v, where)) for a, v in pairs)
    if not places or any(one[0] >= other[0] for one, other in pairwise(places)):
        raise malformed(where, "must list conditions in the order of the attributes, each once")
    return places


def _read_both(members: Mapping[str, object], where: str) -> tuple[Ends, Ends]:
    return read_two(members["subgroup"], f"{where}.subgroup"), read_two(members["rest"], f"{where}.rest")


def _read_found(value: object, where: str, attributes: Labels) -> StatedSubgroup:
    keys = ("conditions", "rows", "sum", "ratio", "side", "same")
    members = read_object(value, where, keys, optional=("ends", "interval"))
    if ("ends" in members) != ("interval" in members):
        raise malformed(where, "must have both of ends and interval, or neither")
    ends = interval = None
    if "ends" in members:
        ends = _read_both(read_object(members["ends"], f"{where}.ends", ("subgroup", "rest")), f"{where}.ends")
        low, high = read_list(members["interval"], f"{where}.interval", 2)
        interval = read_extended(low, f"{where}.interval[0]"), read_extended(high, f"{where}.interval[1]")
    return StatedSubgroup(
        _read_conditions(members["conditions"], f"{where}.conditions", attributes),
        read_integer(members["rows"], f"{where}.rows"),
        read_rational(members["sum"], f"{where}.sum", nonnegative=True),
        read_extended(members["ratio"], f"{where}.ratio"),
        read_choice(members["side"], f"{where}.side", ("more", "less", "equal")),
        tuple(
            _read_conditions(item, f"{where}.same[{i}]", attributes) for i, item in enumerate(read_list(members["same"], f"{where}.same"))
        ),
        ends,
        interval,
    )


def _read_claim(value: object, where: str) -> StatedClaim:
    members = read_object(value, where, ("quantity", "relation", "value", "scope", "by", "assumptions", "evidence"))
    read_choice(members["quantity"], f"{where}.quantity", ("subgroup_ratio",))
    read_choice(members["by"], f"{where}.by", ("T18",))
    relation = read_choice(members["relation"], f"{where}.relation", ("=", ">=", "<="))
    key = {"=": "table", ">=": "finding", "<=": "ends"}[relation]
    item, place = read_object(members["evidence"], f"{where}.evidence", (key,))[key], f"{where}.evidence.{key}"
    evidence = read_digest(item, place) if relation == "=" else read_integer(item, place)
    scope = read_string(members["scope"], f"{where}.scope")
    if (scope == THIS_TABLE) != (relation == "="):
        raise malformed(where, f"must be about {shown(THIS_TABLE)} if it is an equation, else about a population")
    return StatedClaim(
        relation,
        read_extended(members["value"], f"{where}.value"),
        scope,
        read_strings(members["assumptions"], f"{where}.assumptions"),
        evidence,
    )


def _confidence_of(judged: str, where: str) -> Fraction | None:
    if judged == THIS_TABLE:
        return None
    if not judged.startswith(POPULATION):
        raise malformed(where, f"must be {shown(THIS_TABLE)} or begin with {shown(POPULATION)}")
    return read_confidence(judged.removeprefix(POPULATION), where)


def _read_target(value: object, where: str) -> tuple[Rational, str, str]:
    members = read_object(value, where, ("quantity", "limit", "unit", "judged", "verdict"))
    read_choice(members["quantity"], f"{where}.quantity", ("subgroup",))
    read_choice(members["unit"], f"{where}.unit", ("ratio",))
    limit = read_rational(members["limit"], f"{where}.limit", nonnegative=True)
    if not at_most(ONE, limit):
        raise malformed(f"{where}.limit", "must be at least 1, being the limit of a ratio")
    verdict = read_choice(members["verdict"], f"{where}.verdict", ("within", "exceeds", "inconclusive"))
    return limit, read_string(members["judged"], f"{where}.judged"), verdict


def read_stated(value: object) -> Stated:
    """Read a certificate so far as no table is needed."""
    keys = ("format", "subject", "family", "overall", "findings", "frontier", "claims", "targets", "verdict", "versions")
    top = read_object(value, "the certificate", keys)
    about = read_object(top["subject"], "subject", ("columns", "table"), optional=("burden", "preparation"))
    if about.get("burden", True) is not True:  # what a utility means is stated, and nothing follows from it
        raise malformed("subject.burden", f"must be true where it is stated, not {shown(about['burden'])}")
    decision, attributes = read_columns(about["columns"], "subject.columns")
    table = read_object(about["table"], "subject.table", ("sha256", "cells"), optional=("header", "rows"))
    embedded: tuple[object, ...] | None = None
    if "header" in table or "rows" in table:
        table = read_object(table, "subject.table", ("sha256", "cells", "header", "rows"))
        embedded = (table["header"], *read_list(table["rows"], "subject.table.rows"))
    family = read_object(top["family"], "family", ("depth", "least_rows", "conjunctions"), optional=("least_share", "ends"))
    ends: dict[Conjunction, tuple[Ends, Ends]] | None = None
    if "ends" in family:
        ends = {}
        for i, item in enumerate(read_list(family["ends"], "family.ends")):
            where = f"family.ends[{i}]"
            members = read_object(item, where, ("conditions", "subgroup", "rest"))
            ends[_read_places(members["conditions"], f"{where}.conditions")] = _read_both(members, where)
        if len(ends) < len(read_list(family["ends"], "family.ends")):
            raise malformed("family.ends", "lists a conjunction twice")
    overall = read_object(top["overall"], "overall", ("rows", "sum"))
    frontier = read_object(top["frontier"], "frontier", ("ratio", "nodes"))
    nodes: dict[Conjunction, tuple[int, ...]] = {}
    for i, item in enumerate(read_list(frontier["nodes"], "frontier.nodes")):
        where = f"frontier.nodes[{i}]"
        members = read_object(item, where, ("conditions", "counts"))
        place = _read_places(members["conditions"], f"{where}.conditions")
        if place in nodes:
            raise malformed(where, "occurs twice")
        nodes[place] = tuple(read_integer(n, f"{where}.counts") for n in read_list(members["counts"], f"{where}.counts"))
    found = tuple(_read_found(item, f"findings[{i}]", attributes) for i, item in enumerate(read_list(top["findings"], "findings")))
    if not found:
        raise malformed("findings", "must not be empty")
    limit = read_extended(frontier["ratio"], "frontier.ratio")
    if not at_most(ONE, limit):
        raise malformed("frontier.ratio", "must be at least 1")
    claims = tuple(_read_claim(item, f"claims[{i}]") for i, item in enumerate(read_list(top["claims"], "claims")))
    targets = tuple(_read_target(item, f"targets[{i}]") for i, item in enumerate(read_list(top["targets"], "targets")))
    read_object_of_strings(top["versions"], "versions")
    named = {_confidence_of(claim.scope, f"claims[{i}].scope") for i, claim in enumerate(claims)}
    named |= {_confidence_of(judged, f"targets[{i}].judged") for i, (_, judged, _) in enumerate(targets)}
    named -= {None}
    if len(named) > 1:
        raise malformed("the certificate", "names two confidences; its intervals hold at one")
    with_ends = {one.ends is not None for one in found} | ({True} if ends is not None else set())
    if with_ends != {bool(named)}:
        raise malformed("findings", "must all have ends where a population is spoken of, and none elsewhere")
    subject = Subject("counts", Columns(decision, attributes, ()), "counts")
    preparation = read_preparation(about["preparation"], "subject.preparation", subject) if "preparation" in about else ()
    if any(step.groups is not None for step in preparation):
        raise malformed("subject.preparation", "must have null in the place of groups, which subgroups do not have")
    if named and any(step.step == MEDIAN for step in preparation):
        raise malformed("findings", "must not have ends where scores were cut at their own median, of which no two are independent")
    return Stated(
        decision,
        attributes,
        read_digest(table["sha256"], "subject.table.sha256"),
        read_integer(table["cells"], "subject.table.cells"),
        embedded,
        preparation,
        _at_least_one(family["depth"], "family.depth"),
        _at_least_one(family["least_rows"], "family.least_rows"),
        read_rational(family["least_share"], "family.least_share", nonnegative=True) if "least_share" in family else None,
        read_rational(family["conjunctions"], "family.conjunctions", nonnegative=True),
        ends,
        (read_integer(overall["rows"], "overall.rows"), read_rational(overall["sum"], "overall.sum", nonnegative=True)),
        found,
        limit,
        nodes,
        claims,
        targets,
        read_choice(top["verdict"], "verdict", ("none", "within", "exceeds", "inconclusive")),
        next(iter(named), None),
        log_digests(about),
    )


def _at_least_one(value: object, where: str) -> int:
    number = read_integer(value, where)
    if number == 0:
        raise malformed(where, "must be at least 1")
    return number
