"""Logarithms of a certificate in a Coq file: their enclosures, and limits in nats."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping, Sequence
from typing import Any

from fairaudit.errors import InputError, shown
from fairaudit.verified.coq_text import boolean, comment, entries, label, option, pair, rational

__all__ = ["Logarithm", "definitions", "enclosures", "limits", "theorems"]

Logarithm = tuple[str, str]
"""An entry of a list in Coq, and its place in the certificate with what it says."""

_DECIMAL = re.compile(r"0|inf|(?:0|[1-9][0-9]*)\.[0-9]{12}")

_ENCLOSED = """\
Theorem all_enclosed (R : realType) : forall e, In e enclosures -> encloses_log e.1.2 e.2 (omap (@ratio R) e.1.1).
Proof. apply: enclosures_sound; vm_compute; reflexivity. Qed."""

_JUDGED = """\
Theorem all_judged (R : realType) : forall t, In t limits -> in_nats_at_most (omap (@ratio R) t.1.1) t.1.2 = t.2.
Proof. apply: limits_in_nats_sound; vm_compute; reflexivity. Qed."""


def _ratio(value: str) -> str:
    return option(None if value == "inf" else rational(value))


def _text(value: object) -> str:
    if not isinstance(value, str) or not _DECIMAL.fullmatch(value):
        raise InputError(f"{shown(value)} is no end of the logarithm of a ratio")
    return f'(list_ascii_of_string "{value}")'


def enclosures(metrics: Mapping[str, Any]) -> list[Logarithm]:
    """Each ratio with the two decimals between which its logarithm is said to lie.

    Parameters
    ----------
    metrics : mapping
        The figures of the certificate.
    """
    return [
        (pair(_ratio(metric["ratio"]), *map(_text, metric["log"])), f"metrics.{label(key)}.log")
        for key, metric in metrics.items()
        if isinstance(metric, dict) and "log" in metric
    ]


def limits(targets: Sequence[Mapping[str, Any]], metrics: Mapping[str, Any]) -> Iterator[tuple[int, Logarithm]]:
    """Each limit in nats on a ratio of the table, by its number: the ratio, the limit, and whether it is kept.

    Parameters
    ----------
    targets : sequence of mapping
        The limits of the certificate.
    metrics : mapping
        Its figures.
    """
    for i, target in enumerate(targets):
        metric = metrics[target["quantity"]]
        if (
            target["unit"] == "log"
            and target["judged"] == "this table"
            and metric is not None
            and target["verdict"] in ("within", "exceeds")
        ):
            term = pair(_ratio(metric["ratio"]), rational(target["limit"]), boolean(target["verdict"] == "within"))
            yield i, (term, f"targets[{i}]: log of the {target['quantity']} ratio at most {target['limit']}: {target['verdict']}")


def definitions(enclosed: Sequence[Logarithm], judged: Sequence[Logarithm]) -> list[str]:
    """The lists of what is proved.

    Parameters
    ----------
    enclosed, judged : sequence
        Enclosures and limits.
    """
    return [
        "Module Logarithms.",
        *(
            [
                comment("A ratio (None: infinite) and two decimals: its natural logarithm is at least the first and less than the second."),
                f"Definition enclosures : list (option Q * list ascii * list ascii) := {entries(enclosed)}.",
            ]
            if enclosed
            else []
        ),
        *(
            [
                comment("A ratio, a limit, and whether the natural logarithm of the ratio is at most the limit."),
                f"Definition limits : list (option Q * Q * bool) := {entries(judged)}.",
            ]
            if judged
            else []
        ),
        "End Logarithms.",
    ]


def theorems(enclosed: Sequence[Logarithm], judged: Sequence[Logarithm]) -> tuple[list[str], list[str]]:
    """The theorems about the two lists, over the real numbers of mathcomp-analysis, and how Coq calls them.

    Parameters
    ----------
    enclosed, judged : sequence
        Enclosures and limits.
    """
    said = [_ENCLOSED] * bool(enclosed) + [_JUDGED] * bool(judged)
    names = ["all_enclosed"] * bool(enclosed) + ["all_judged"] * bool(judged)
    lines = ["Module Proved_of_logarithms.", "Import NatsSound Logarithms.", *said, "End Proved_of_logarithms."]
    return lines, [f"Proved_of_logarithms.{name}" for name in names]
