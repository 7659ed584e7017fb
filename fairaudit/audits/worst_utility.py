"""Certificates of a worst-case utility: docs/certificate-worst-case.md."""

from __future__ import annotations

from fractions import Fraction
from math import inf
from typing import Any

from fairaudit.arguments import answered
from fairaudit.audits.certify import certify
from fairaudit.audits.claims import claim_of_class
from fairaudit.certificates.certificate import Certificate
from fairaudit.certificates.numbers import number
from fairaudit.errors import InputError
from fairaudit.measures.ratios import Ratio
from fairaudit.worst.result import WorstCase

__all__ = ["certify_worst_case"]


@answered
def certify_worst_case(found: WorstCase, *, embed_table: bool | None = None) -> Certificate:
    """Write a worst case as a certificate: of the law with the worst utility, with the class and the bound for all of it.

    Parameters
    ----------
    found : WorstCase
        What `worst_case` found.
    embed_table : bool, optional
        As in `certify`.

    Returns
    -------
    Certificate
        Ready to be saved.

    Raises
    ------
    InputError
        If the utility found is one that the format cannot express: with constraints that tie contexts together, another pair of groups,
        which does not keep the floor, can have a greater ratio under it.

    Examples
    --------
    >>> from fairaudit.model.law import Law
    >>> from fairaudit.model.utility_class import UtilityClass
    >>> from fairaudit.worst.methods import worst_case
    >>> law = Law.from_array([[3, 1], [1, 1]], kind="counts", decisions=["yes", "no"], groups=["f", "m"])
    >>> certificate = certify_worst_case(worst_case(law, UtilityClass(tau="1/4")))
    >>> claim = certificate.document["claims"][-1]
    >>> claim["relation"], claim["value"], claim["scope"]
    ('<=', '2', 'every utility of the class')
    """
    result = certify(found.law.without_truth, found.certified_utility, confidence=None, embed_table=embed_table)
    measured = result.local if found.quantity == "local" else result.global_
    if measured is None or not _keeps(found, measured):
        raise InputError(
            "the worst utility gives a greater ratio to groups that do not keep the floor, which a certificate cannot express; leave out "
            "the floor, or ask for it on all groups"
        )
    certificate = result.certificate
    certificate.document["subject"]["class"] = _class(found)
    of_table = [entry for entry in certificate.document["claims"] if entry["by"] != "T14"]  # a class has no figure to be explained away
    certificate.document["claims"] = of_table
    certificate.document["claims"].append(claim_of_class(found, _evidence(found)).entry)
    return certificate


def _keeps(found: WorstCase, measured: Ratio) -> bool:
    """Whether the ratio that the certificate states is one that the class bounds."""
    return measured.ratio <= found.upper and found.keeps_floor(measured.witness)


def _class(found: WorstCase) -> dict[str, Any]:
    of, setting, law = found.bounded_class, found.setting, found.law
    family: dict[str, Any] | None = None
    if of.family is not None:
        family = {
            "names": list(of.family.names),
            "lower": [number(v) for v in of.family.lower],
            "upper": [number(v) for v in of.family.upper],
            "features": [[[number(v) for v in phi] for phi in cell] for cell in setting.features],
            "rows": [{"coefficients": [number(v) for v in row], "bound": number(bound)} for row, bound in of.family.rows],
        }
    rows = []
    for terms, bound in setting.rows:
        entries = []
        for variable in sorted(terms):
            row, u = divmod(variable, len(law.decisions))
            x = setting.contexts[row] if of.blind else int(law.cell_context[row])
            entries.append([x, None if of.blind else int(law.cell_group[row]), u, number(terms[variable])])
        rows.append({"terms": entries, "bound": number(bound)})
    return {
        "quantity": found.quantity,
        "gamma": number(of.gamma),
        "m": number(of.m),
        "tau": None if of.tau is None else number(of.tau),
        "tau_on": of.tau_on,
        "blind": of.blind,
        "lipschitz": None if of.lipschitz is None else number(of.lipschitz),
        "metric": None if setting.metric is None else [[number(v) for v in row] for row in setting.metric],
        "order": [list(pair) for pair in of.order],
        "rows": rows,
        "family": family,
    }


def _evidence(found: WorstCase) -> dict[str, Any]:
    evidence = found.evidence if found.upper != inf or found.by == "T3" else {"pairs": []}
    if found.by == "T3":
        return {"multipliers": [number(k) for k in evidence["multipliers"]]}
    pairs = [{**entry, "multipliers": [[i, number(y)] for i, y in entry["multipliers"]]} for entry in evidence["pairs"]]
    theta = found.certified_theta
    return {"pairs": pairs} if theta is None else {"pairs": pairs, "theta": [number(Fraction(v)) for v in theta]}
