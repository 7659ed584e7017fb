"""The claims that a certificate makes, each of a kind of the registry, with its scope, assumptions and evidence."""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from fractions import Fraction
from math import inf
from typing import TYPE_CHECKING, Any

import numpy as np

from fairaudit.audits.drift import TableRadius, evidence_of, radius_evidence
from fairaudit.certificates.numbers import number
from fairaudit.exact.extended import extended_text
from fairaudit.inference.interval import Interval
from fairaudit.measures.limits import Quantity
from fairaudit.model.law import Law
from fairaudit.tables.preparation import assumption
from fairaudit.tables.values import Label
from fairaudit.theorems.assumptions import (
    FRESH,
    UNDECIDED_RELEASED,
    UNKNOWN_COMPARED,
    UNKNOWN_OTHERS,
    UNKNOWN_SHARE,
    hidden_said,
    undecided_said,
)
from fairaudit.theorems.bound import FLOORED, THIS_LAW, Bound
from fairaudit.theorems.kind import Kind, Relation
from fairaudit.theorems.registry import BY_ID, BY_KEY, ONE_SIDED, SAMPLED, under
from fairaudit.theorems.t07 import t7
from fairaudit.words import DRIFTING, HIDDEN, WHATEVER, WHOEVER, brief

if TYPE_CHECKING:
    from fairaudit.audits.result import Result
    from fairaudit.audits.undecided import Undecided
    from fairaudit.audits.unknown import Place, Share, Whoever
    from fairaudit.inference.differences import DifferenceInterval
    from fairaudit.model.policy import Deployment
    from fairaudit.theorems.supremum import PairProof, Supremum
    from fairaudit.theorems.t16 import Form
    from fairaudit.worst.result import WorstCase

__all__ = ["Claim"]


@brief
@dataclass(frozen=True, repr=False)
class Claim:
    """A statement with its scope and evidence, as docs/certificate.md lists them.

    Attributes
    ----------
    quantity : str
        What is claimed of, such as ``"local_ratio"``.
    relation : {"=", "<=", ">="}
        Whether it has the value, or which end the value is.
    value : Fraction or float
        The value; possibly `math.inf`.
    by : str
        What proves it: ``"enumeration"``, a theorem, ``"lp-dual"``, or the method of an interval.
    evidence : mapping
        What a checker needs.
    scope : str
        What may be changed without making it false.
    assumptions : tuple of str
        What the reader must accept.

    Examples
    --------
    >>> import fairaudit as fa
    >>> table = {"hired": ["yes", "no", "yes", "no"], "sex": ["f", "f", "m", "m"], "n": [30, 10, 20, 20]}
    >>> result = fa.audit(table, decision="hired", group="sex", count="n", utility="yes", max_local_ratio="5/4")
    >>> claim = result.claims[0]
    >>> claim.quantity, claim.relation, claim.value, claim.by, claim.scope
    ('local_ratio', '=', Fraction(3, 2), 'enumeration', 'this law')
    """

    quantity: str
    relation: Relation
    value: Fraction | float
    by: str
    evidence: Mapping[str, Any]
    scope: str = "this law"
    assumptions: tuple[str, ...] = ()

    @property
    def entry(self) -> dict[str, Any]:
        """The claim as a certificate stores it."""
        return {
            "quantity": self.quantity,
            "relation": self.relation,
            "value": number(self.value),
            "scope": self.scope,
            "by": self.by,
            "assumptions": list(self.assumptions),
            "evidence": dict(self.evidence),
        }


def claims_of(result: Result) -> Iterator[Claim]:
    """What the certificate of a result claims: figures, what follows from them, intervals, and what theorems guarantee."""
    law = result.law
    about = (*((FRESH,) if result.deployment else ()), *law.assumptions)
    yield from _figures(result, about)
    for name, difference in (result.given_truth.intervals if result.given_truth else {}).items():
        yield from _ends(BY_ID["binomial-rates"], name, name, difference)
    for quantity, interval in result.intervals.items() if result.undecided is None else ():
        by = next((method for method in interval.methods if method != "binomial"), "binomial")
        yield from _ends(BY_ID[f"{by}-interval"], f"{quantity}_ratio", quantity, interval)
    for quantity, found in (result.differences.intervals if result.differences else {}).items():
        by = next((method for method in found.methods if method != "binomial"), "binomial")
        yield from _ends(BY_ID[f"{by}-interval"], f"{quantity}_difference", f"{quantity}_difference", found)
    for range_ in result.whoever:
        yield from claims_about_unknown(range_, result)
    if result.undecided is not None:
        yield from _about_undecided(result, result.undecided, about)
    yield from _about_drift(result, about)
    for supremum in result.suprema:
        yield _over_policies(supremum, result)
    for bound in result.bounds:
        if bound.certified:
            yield _by_theorem(bound, law.assumptions)
    yield from _of_hidden_contexts(result)


def claim_of_class(found: WorstCase, evidence: Mapping[str, Any]) -> Claim:
    """What a worst case claims: that no utility of the class gives a greater ratio."""
    kind = BY_ID["T3-class" if found.by == "T3" else found.by]
    return _claim(kind, f"{found.quantity}_ratio", found.upper, found.law.assumptions, evidence)


def _figures(result: Result, about: tuple[str, ...]) -> Iterator[Claim]:
    """Claims about the table itself; the digest in their evidence is filled in when the table is put into the certificate."""
    law, digest = result.law, {"table": ""}
    figure, supremum_of, distance_by = BY_ID["enumeration"], BY_ID["T6"], BY_ID["T7"]
    for name, ratio in (("local_ratio", result.local), ("global_ratio", result.global_)):
        if ratio:
            yield _claim(figure, name, ratio.ratio, about, digest)
    for name, distance in (("demographic_parity", result.demographic_parity), ("equalized_odds", result.equalized_odds)):
        if distance:
            yield _claim(figure, name, distance.value, about, digest)
    for quantity, supremum in (("local_ratio", result.local_supremum), ("global_ratio", result.global_supremum)):
        if supremum:
            bound = t7(supremum.ratio, quantity="equalized_odds" if quantity == "local_ratio" else "demographic_parity")
            yield _claim(supremum_of, f"{quantity}_supremum", supremum.ratio, about, digest)
            yield _claim(distance_by, bound.quantity, bound.value, about, {"supremum": number(supremum.ratio)})
    if result.local and result.global_ and not result.partial and law.independent:
        from fairaudit.theorems.t05 import t5_independent

        bound = t5_independent(result.local.ratio)
        yield _claim(BY_ID["T5"], bound.quantity, bound.value, about, digest)
    for name, difference in (result.given_truth.differences if result.given_truth else {}).items():
        if difference is not None:
            yield _claim(figure, name, difference.value, about, digest)
    for quantity, apart in (result.differences.measured if result.differences else {}).items():
        if apart is not None:
            yield _claim(figure, f"{quantity}_difference", apart.value, about, digest)


def _about_drift(result: Result, about: tuple[str, ...]) -> Iterator[Claim]:
    """How far cells may move while verdicts stand, and the ratios within a declared drift."""
    for target, found in zip(result.targets, result.drift_radii, strict=True):
        if not isinstance(found, TableRadius):
            continue
        scope, assumptions = "this law", about
        if found.of_population:
            interval = result.intervals[target.quantity]
            scope, assumptions = population_at(interval.confidence, each=True), interval.assumptions
        values: tuple[tuple[Form, Fraction | float | None, bool], ...] = (
            ("radius", found.radius, found.exact),
            ("factor", found.factor, found.exact_factor),
        )
        for form, value, exact in values:
            if value is not None:
                quantity = f"{target.quantity}_{target.unit}_{form}"
                kind = BY_ID["T16-radius-population" if found.of_population else "T16-radius"]
                listed = kind.sentences(scope, quantity, {})
                evidence = radius_evidence(result, target, found, form)
                yield Claim(quantity, "=" if exact else ">=", value, "T16", evidence, scope, (*listed, *assumptions))
    drift = result.declared.get("max_drift", Fraction(0))
    for ratio in result.drifted:
        of_law = ratio.scope == "this law"
        kind = BY_ID["T16-worst" if of_law else "T16-worst-population"]
        quantity = f"{ratio.quantity}_ratio"
        listed = (*kind.sentences(ratio.scope, quantity, {"drift": drift}), *(about if of_law else ratio.assumptions))
        ends: tuple[tuple[Relation, Fraction | float, Any], ...] = (
            (">=", ratio.best, ratio.best_pair),
            ("<=", ratio.worst, ratio.worst_pair),
        )
        for relation, end, pair in ends:
            followed: Quantity = ratio.quantity if of_law else "local"
            evidence = evidence_of(result, followed, pair, "radius", drift, end, worst=relation == "<=")
            yield Claim(quantity, relation, end, "T16", evidence, under(ratio.scope, DRIFTING), listed)


def _ends(kind: Kind, quantity: str, key: str, interval: Interval | DifferenceInterval) -> Iterator[Claim]:
    """Both ends of an interval of the population."""
    scope = population_at(interval.confidence, each=interval.ends == "each")
    for relation, end in zip(kind.relations, (interval.lower, interval.upper), strict=True):
        yield Claim(quantity, relation, end, kind.by, {kind.evidence: key}, scope, interval.assumptions)


def claims_about_unknown(found: Whoever, result: Result) -> Iterator[Claim]:
    """Both ends of a ratio, whoever the decisions of unknown group are; what was left out as unknown is not left out of these."""
    from fairaudit.audits.unknown import Levels

    law, quantity = result.law, f"{found.quantity}_ratio"
    of_unknown = {assumption(entry) for entry in law.preparation if entry["step"] == "unknown"}
    left_out = tuple(text for text in law.assumptions if text not in of_unknown)
    overall = found.quantity == "global"
    compared = () if overall or not _could_be_of_others(law) else (UNKNOWN_COMPARED,)
    assumed = (*compared, *(share_said(share, law, overall=overall) for share in result.unknown_shares), *left_out)
    scope = under("this law", WHOEVER)

    def place(at: Place) -> dict[str, Any]:
        where = {} if at.context is None else {"context": list(law.contexts[at.context])}
        return {**where, "higher": list(law.groups[at.higher]), "lower": list(law.groups[at.lower])}

    attained = {**place(found.place), "received": [str(rows) for rows in found.received]}
    yield Claim(quantity, "<=", found.greatest, "T15", {"completion": attained}, scope, assumed)
    proof: dict[str, Any] | None = None
    if isinstance(found.proof, int):
        proof = {} if found.proof < 0 else {"context": list(law.contexts[found.proof])}
    elif isinstance(found.proof, Levels):
        where = {} if found.proof.context is None else {"context": list(law.contexts[found.proof.context])}
        proof = {**where, "levels": [number(found.proof.low), number(found.proof.high)]}
    elif found.proof is not None:
        proof = place(found.proof)
    reached = None
    if found.reached is not None:
        assigned = [
            {
                **({} if x is None else {"context": list(law.contexts[x])}),
                "values": [number(value) for value in values],
                "counts": [[str(rows) for rows in row] for row in counts],
            }
            for x, values, counts in found.reached.assigned
        ]
        reached = {"ratio": number(found.reached.ratio), "assigned": assigned}
    yield Claim(quantity, ">=", found.least, "T15", {"proof": proof, "reached": reached}, scope, assumed)


def _about_undecided(result: Result, undecided: Undecided, about: tuple[str, ...]) -> Iterator[Claim]:
    """Both ends of the ratios, whatever undecided decisions meant: of the table, and of the population."""
    of_table, of_population = BY_ID["T19"], BY_ID["T19-population"]
    said = undecided_said(undecided.decisions, undecided.least, undecided.most)
    released = (UNDECIDED_RELEASED,) if result.deployment else ()
    for found in result.whatever:
        ends = (found.greatest, found.greatest_at), (found.least, found.least_at)
        for relation, (value, at) in zip(of_table.relations, ends, strict=True):
            labels = [] if at is None else [None if one is None else [*one.values()] for one in at]
            pair = dict(zip(("context", "higher", "lower"), labels, strict=True)) if labels else None
            yield Claim(f"{found.quantity}_ratio", relation, value, of_table.by, {"pair": pair}, under(THIS_LAW, WHATEVER), (said, *about))
    for quantity, interval in result.intervals.items():
        scope = under(population_at(interval.confidence, each=interval.ends == "each"), WHATEVER)
        for relation, end in zip(of_population.relations, (interval.upper, interval.lower), strict=True):
            evidence = {of_population.evidence: quantity}
            yield Claim(f"{quantity}_ratio", relation, end, of_population.by, evidence, scope, (*released, said, *interval.assumptions))


def _could_be_of_others(law: Law) -> bool:
    """Whether a context with decisions of unknown group has none of some group that is recorded elsewhere."""
    cells = np.bincount(law.cell_context, minlength=len(law.contexts))
    return law.unknown is not None and bool((cells[law.unknown.contexts] < len(law.groups)).any())


def share_said(share: Share, law: Law, *, overall: bool) -> str:
    """The sentence about a declared share of the decisions of unknown group."""
    where = "over all contexts" if overall else "in every context"
    low, high = extended_text(share.low), extended_text(share.high)
    if share.group is None:
        return UNKNOWN_OTHERS.format(where=where, low=low, high=high)
    return UNKNOWN_SHARE.format(where=where, low=low, high=high, group=json.dumps(list(law.groups[share.group]), ensure_ascii=False))


def _of_hidden_contexts(result: Result) -> Iterator[Claim]:
    """How strong an unrecorded factor would have to be to explain ratios away, and what a declared one leaves of them."""
    weak, strong = BY_ID["T14-frontier"], BY_ID["T14-hidden"]
    for found in result.explanations:
        scope, listed = _scope_of(found.interval, result.law)
        levels = [
            {
                "to": number(level.to),
                "balanced": number(level.balanced),
                "pairs": [[number(k), number(m)] for k, m in level.pairs],
            }
            for level in found.levels
        ]
        name = f"{found.quantity}_hidden_context"
        yield Claim(name, ">=", found.levels[0].balanced, weak.by, {weak.evidence: levels}, scope, listed)
    hidden = result.hidden_context
    if hidden is None:
        return
    for left in result.remaining:
        scope, listed = _scope_of(left.interval, result.law)
        factor = {"k": number(hidden.k), "m": number(hidden.m), "direction": hidden.direction}
        said = hidden_said(left.quantity, hidden.direction, hidden.k, hidden.m)
        evidence = {strong.evidence: factor}
        yield Claim(f"{left.quantity}_ratio", ">=", left.value, strong.by, evidence, under(scope, HIDDEN), (said, *listed))


def _scope_of(interval: Interval | None, law: Law) -> tuple[str, tuple[str, ...]]:
    """The scope of a claim that starts from a figure of the table, or from an end of an interval, and what it assumes."""
    if interval is None:
        return THIS_LAW, law.assumptions
    return population_at(interval.confidence, each=interval.ends == "each"), interval.assumptions


def _by_theorem(bound: Bound, about: tuple[str, ...]) -> Claim:
    """What a theorem guarantees, with the assumptions and the evidence that its kind asks for."""
    kind = BY_KEY[bound.quantity, "<=", bound.theorem, bound.scope]
    evidence: dict[str, Any] = {}
    if kind.evidence == "multipliers":
        evidence = {kind.evidence: [number(k) for k in bound.multipliers]}
    elif kind.evidence:
        evidence = {kind.evidence: number(bound.constants.get(kind.evidence, inf))}
    listed = bound.assumptions if kind.by == "T13" else kind.sentences(bound.scope, bound.quantity, bound.constants)
    return Claim(bound.quantity, "<=", bound.value, kind.by, evidence, bound.scope, (*listed, *about))


def _over_policies(found: Supremum, result: Result) -> Claim:
    """The greatest ratio of the policies of a scope, with where it is attained, or what bounds it."""
    law = result.law
    relation: Relation = "=" if found.exact else "<="
    named = found.higher is not None
    attained = {"context": _labels(found.context), "higher": _labels(found.higher), "lower": _labels(found.lower)} if named else None
    evidence: dict[str, Any] = {"attained": attained}
    if found.scope == FLOORED:
        evidence = {
            "multipliers": [number(k) for k in found.multipliers],
            "pairs": [_pair_proof(proof, law) for proof in found.pairs],
            "policy": {"attained": attained, "rows": _by_context(found, result.deployment)} if named else None,
        }
    return Claim(
        f"{found.quantity}_ratio_supremum", relation, found.value, "T13", evidence, found.scope, (*found.assumptions, *law.assumptions)
    )


def _by_context(found: Supremum, deployment: Deployment | None) -> list[list[list[str]]]:
    """The policy that attains it: for each released context the laws for the released groups."""
    if deployment is None:
        return []
    groups = deployment.released_rows[0].shape[1]
    return [[[number(chance) for chance in row] for row in found.rows[i : i + groups]] for i in range(0, len(found.rows), groups)]


def _pair_proof(proof: PairProof, law: Law) -> dict[str, Any]:
    context = None if proof.context is None else law.contexts[proof.context]
    floors = [[x, a, number(y)] for (x, a), y in proof.floors.items()]
    return {"context": _labels(context), "higher": list(law.groups[proof.higher]), "lower": list(law.groups[proof.lower]), "floors": floors}


def _labels(label: Label | None) -> list[str] | None:
    return None if label is None else list(label)


def _claim(kind: Kind, quantity: str, value: Fraction | float, about: tuple[str, ...], evidence: Mapping[str, Any]) -> Claim:
    """A claim of a kind that has one relation and one scope."""
    (relation,), (scope,) = kind.relations, kind.scopes
    return Claim(quantity, relation, value, kind.by, evidence, scope, (*kind.sentences(scope, quantity, {}), *about))


def population_at(confidence: Fraction, *, each: bool = False) -> str:
    """The scope of what is said of the population behind draws: at a confidence, or of each end by itself at it."""
    return f"{ONE_SIDED if each else SAMPLED}{number(confidence)}"
