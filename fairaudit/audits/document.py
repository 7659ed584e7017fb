"""The JSON document of a result, as docs/certificate.md describes it, with its table."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from fairaudit import __version__
from fairaudit.audits.claims import population_at
from fairaudit.audits.sentences import evaluation_of
from fairaudit.certificates.certificate import FORMAT, Certificate, with_table
from fairaudit.certificates.entries import (
    add_differences,
    add_given_truth,
    change_entry,
    distance_entry,
    interval_entry,
    left_out_entry,
    privacy_entry,
    rate_entry,
    ratio_entry,
)
from fairaudit.certificates.numbers import number
from fairaudit.certificates.table import Table, canonical, column_names
from fairaudit.tables.preparation import undisclosed
from fairaudit.theorems.registry import under
from fairaudit.words import THIS_TABLE

if TYPE_CHECKING:
    from fairaudit.audits.result import Result
    from fairaudit.audits.targets import Target
    from fairaudit.audits.unknown import Tips
    from fairaudit.model.policy import Deployment


def certificate_of(result: Result) -> Certificate:
    """The certificate of a result: its document, and the table in it or beside it."""
    from hashlib import sha256

    made, given = document(result), result.given_truth
    if result.partial is not None:
        return with_table(made, result.partial.table, embed=result.embed)
    law = result.deployment.policy.law if result.deployment else result.law
    paired = {quantity: interval.evidence["profiles"] for quantity, interval in result.intervals.items() if interval.region == "paired"}
    digests: dict[str, str] = {quantity: sha256(canonical(profiles)).hexdigest() for quantity, profiles in paired.items()}
    certificate = with_table(made, Table(law, result.utility, result.deployment, profiles=digests), embed=result.embed)
    if given is not None and certificate.table is None:
        made["metrics"] |= {name: [rate_entry(law, rate) for rate in rates] for name, rates in given.rates.items()}
    return certificate


def document(result: Result) -> dict[str, Any]:
    """The document of a result, before the table is put into it."""
    made: dict[str, Any] = {
        "format": FORMAT,
        "subject": _subject(result),
        "metrics": {
            "local": ratio_entry(result.local),
            "global": ratio_entry(result.global_),
            "demographic_parity": distance_entry(result.demographic_parity),
            "equalized_odds": distance_entry(result.equalized_odds),
            "local_supremum": ratio_entry(result.local_supremum),
            "global_supremum": ratio_entry(result.global_supremum),
        },
        "not_compared": [left_out_entry(entry) for entry in result.not_compared],
        "claims": [claim.entry for claim in result.claims],
        "targets": [_target(target, result) for target in result.targets],
        "verdict": result.verdict,
        "versions": {"fairaudit": __version__},
    }
    if result.intervals:
        made["intervals"] = {
            quantity: interval_entry(interval, result.comparisons.get(quantity), result.law if quantity == "local" else None)
            for quantity, interval in result.intervals.items()
        }
    if result.differences is not None:
        add_differences(made, result.differences, result.law)
    if result.given_truth is not None:
        add_given_truth(made, result.given_truth)
    if result.changed is not None:
        made["changed"] = change_entry(result.changed)
    if result.deployment is not None:
        _add_filters(made, result, result.deployment)
    return made


def _subject(result: Result) -> dict[str, Any]:
    """What was audited; `table` is filled in when the table is put into the certificate."""
    utility = result.utility
    subject: dict[str, Any] = {
        "kind": "policy" if result.deployment else result.law.kind,
        "columns": column_names(result.columns),
        "population": result.law.population,
        "table": {},
        "utility": {
            "gamma": number(utility.gamma),
            "m": number(utility.m),
            "tau": None if result.tau is None else number(result.tau),
            "lipschitz": number(utility.lipschitz()),
            "depends_on_group": utility.depends_on_group,
            **({"burden": True} if result.burden else {}),
        },
    }
    if result.preparation:
        subject["preparation"] = [dict(entry) if result.embed is not False else undisclosed(entry) for entry in result.preparation]
    if (evaluation := evaluation_of(result)) is not None:
        subject["evaluation"] = evaluation
    if result.unknown_shares:
        subject["unknown_shares"] = [
            {
                "group": None if share.group is None else list(result.law.groups[share.group]),
                "least": number(share.low),
                "most": number(share.high),
            }
            for share in result.unknown_shares
        ]
    if result.undecided is not None:
        subject["undecided"] = {
            "decisions": list(result.undecided.decisions),
            "least": number(result.undecided.least),
            "most": number(result.undecided.most),
        }
    if result.deployment is None and "max_drift" in result.declared:
        subject["max_drift"] = number(result.declared["max_drift"])
    if result.spellings:
        subject["spellings"] = list(result.spellings)
    return subject


def _add_filters(made: dict[str, Any], result: Result, deployment: Deployment) -> None:
    """What is said of a policy behind filters besides: docs/certificate-policy.md."""
    context = deployment.context_filter
    made["subject"]["privacy"] = {
        "group": privacy_entry(deployment.group_filter),
        "context": privacy_entry(context) if context else None,
    }
    declared: dict[str, Any] = {name: number(value) for name, value in result.declared.items()}
    if result.declared_in:
        declared["by_context"] = [
            {"context": list(label), **{name: number(value) for name, value in own.items()}} for label, own in result.declared_in.items()
        ]
    made["subject"]["declared"] = declared
    made["metrics"]["unfiltered"] = (
        None if result.unfiltered is None else dict(zip(("local", "global"), map(ratio_entry, result.unfiltered), strict=True))
    )


def _target(target: Target, result: Result) -> dict[str, Any]:
    """A target as a certificate stores it."""
    return {
        "quantity": target.quantity,
        "limit": number(target.limit),
        "unit": target.unit,
        "judged": under(THIS_TABLE if target.confidence is None else population_at(target.confidence), target.under),
        **({} if target.estimand == "mean over rows" else {"estimand": target.estimand}),
        "verdict": target.verdict,
        **({} if target.tips is None else {"tips": _tips(target.tips, result)}),
    }


def _tips(tips: Tips, result: Result) -> dict[str, Any]:
    """How many decisions of unknown group could not change what those with a group say, and of which groups one more could."""
    law, place = result.law, tips.place
    where = {} if place.context is None else {"context": list(law.contexts[place.context])}
    pair = {**where, "higher": list(law.groups[place.higher]), "lower": list(law.groups[place.lower])}
    return {"labelled": tips.labelled, "rows": str(tips.rows), "pair": pair}
