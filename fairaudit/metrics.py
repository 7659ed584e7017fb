"""Fairness metrics with the signature of scikit-learn and Fairlearn: arrays in, one number out.

Each is exact until the last step, when it becomes the nearest float. `fairaudit.certify` says more about the same decisions: the pair of
groups that attains the number, an interval for the population behind them, and a certificate.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from fractions import Fraction
from math import inf
from typing import Any

import numpy as np

from fairaudit.arguments import answered
from fairaudit.errors import InputError, nearest, shown
from fairaudit.exact.enclosures import log_fixed
from fairaudit.exact.rationals import Number, rational
from fairaudit.measures.distances import demographic_parity as _demographic_parity
from fairaudit.measures.distances import equalized_odds as _equalized_odds
from fairaudit.measures.ratios import Ratio, global_fairness, local_fairness
from fairaudit.model.law import Law
from fairaudit.model.utility import Utility
from fairaudit.tables.label_text import label_text

__all__ = [
    "demographic_parity",
    "equal_opportunity",
    "equalized_odds",
    "global_g_fairness",
    "local_g_fairness",
    "parity_within_contexts",
]

TRUTH = {"true": "1", "false": "0", "True": "1", "False": "0"}


@answered
def local_g_fairness(
    y_true: Any,
    y_pred: Any,
    *,
    sensitive_features: Any,
    control_features: Any = None,
    utility: Mapping[Any, Number] | None = None,
    sample_weight: Any = None,
) -> float:
    """Local g-fairness L: the worst log-ratio of mean utilities between two groups with the same control features.

    Parameters
    ----------
    y_true : array_like or None
        Not used: fairness compares decisions. To compare within true labels, pass them as a control feature, or see `equalized_odds`.
    y_pred : array_like, shape (samples,)
        The decisions.
    sensitive_features : array_like, mapping or DataFrame
        The groups; several columns make intersections.
    control_features : array_like, mapping or DataFrame, optional
        The contexts within which groups are compared; one context if there are none.
    utility : mapping of decision to number ≥ 0, optional
        What a decision is worth to the person, and 0 for those that are not listed. If it is not given, decisions are numbers ≥ 0 and worth
        what they say, which for 0 and 1 compares selection rates.
    sample_weight : array_like, optional
        Weights ≥ 0.

    Returns
    -------
    float
        L ≥ 0 in nats; ``exp(L)`` is the ratio. Two means of 0 are equal (0); a mean of 0 beside a greater one gives infinity. Contexts
        with a single group compare nobody and are passed over.

    Raises
    ------
    InputError
        If no context has two groups, lengths differ, a label is missing, or a number is not usable.

    Examples
    --------
    >>> round(local_g_fairness(None, [1, 1, 0, 1, 0, 0], sensitive_features=list("aaabbb")), 4)  # log of (2/3) / (1/3)
    0.6931
    """
    law = _law(y_pred, sensitive_features, control_features, sample_weight)
    return _log(local_fairness(law, _utility(utility, law).on(law)))


@answered
def global_g_fairness(
    y_true: Any,
    y_pred: Any,
    *,
    sensitive_features: Any,
    control_features: Any = None,
    utility: Mapping[Any, Number] | None = None,
    sample_weight: Any = None,
) -> float:
    """Global g-fairness L̄: the worst log-ratio of the groups' mean utilities over everybody.

    Parameters
    ----------
    y_true, y_pred, sensitive_features, utility, sample_weight
        As in `local_g_fairness`.
    control_features : array_like, mapping or DataFrame, optional
        Accepted, so that all metrics can be called alike; averaging over contexts with the samples' own frequencies removes them.

    Returns
    -------
    float
        L̄ ≥ 0 in nats, with the conventions of `local_g_fairness`.

    Raises
    ------
    InputError
        As `local_g_fairness`.

    Examples
    --------
    >>> global_g_fairness(None, [1, 0, 1, 0], sensitive_features=list("aabb"))
    0.0
    """
    law = _law(y_pred, sensitive_features, control_features, sample_weight)
    return _log(global_fairness(law, _utility(utility, law).on(law)))


@answered
def demographic_parity(
    y_true: Any,
    y_pred: Any,
    *,
    sensitive_features: Any,
    control_features: Any = None,
    utility: Mapping[Any, Number] | None = None,
    sample_weight: Any = None,
) -> float:
    """Demographic parity: the greatest total variation distance between the decisions of two groups.

    For two decisions it is the difference of selection rates.

    Parameters
    ----------
    y_true, y_pred, sensitive_features, sample_weight
        As in `local_g_fairness`.
    control_features, utility
        Accepted, so that all metrics can be called alike; they make no difference.

    Returns
    -------
    float
        Between 0 (alike) and 1.

    Raises
    ------
    InputError
        As `local_g_fairness`.

    Examples
    --------
    >>> demographic_parity(None, ["yes", "no", "yes", "yes"], sensitive_features=list("aabb"))
    0.5
    """
    found = _demographic_parity(_law(y_pred, sensitive_features, control_features, sample_weight))
    if found is None:
        raise _nobody()
    return float(found.value)


@answered
def parity_within_contexts(
    y_true: Any,
    y_pred: Any,
    *,
    sensitive_features: Any,
    control_features: Any = None,
    utility: Mapping[Any, Number] | None = None,
    sample_weight: Any = None,
) -> float:
    """Parity within contexts: the greatest total variation distance between two groups with the same control features.

    The paper behind this library calls it equalized odds. It does not look at the true label; `equalized_odds` does.

    Parameters
    ----------
    y_true, y_pred, sensitive_features, control_features, sample_weight
        As in `local_g_fairness`; `y_true` is not used.
    utility
        Accepted, so that all metrics can be called alike; it makes no difference.

    Returns
    -------
    float
        Between 0 (alike) and 1.

    Raises
    ------
    InputError
        As `local_g_fairness`.

    Examples
    --------
    >>> parity_within_contexts(None, [1, 0, 0, 1, 1, 0], sensitive_features=list("aaabbb"), control_features=list("xxyxxy"))
    0.5
    """
    found = _equalized_odds(_law(y_pred, sensitive_features, control_features, sample_weight))
    if found is None:
        raise _nobody()
    return float(found.value)


@answered
def equalized_odds(
    y_true: Any,
    y_pred: Any,
    *,
    sensitive_features: Any,
    control_features: Any = None,
    utility: Mapping[Any, Number] | None = None,
    sample_weight: Any = None,
) -> float:
    """Equalized odds: the greatest total variation distance between two groups with the same true label and control features.

    For two labels and two decisions it is the greater of the greatest difference of true positive rates and that of false positive rates.

    Parameters
    ----------
    y_true : array_like
        The true labels; two or more different ones.
    y_pred, sensitive_features, sample_weight
        As in `local_g_fairness`.
    control_features : array_like, mapping or DataFrame, optional
        The contexts within which groups are compared, beside the true label.
    utility
        Accepted, so that all metrics can be called alike; it makes no difference.

    Returns
    -------
    float
        Between 0 (alike) and 1. A group without a sample of a true label (in a context) has no rate there and is passed over there.

    Raises
    ------
    InputError
        As `local_g_fairness`, and if for some true label no two groups are compared anywhere, so that nothing is known of its rate.

    Examples
    --------
    >>> equalized_odds([1, 1, 0, 1, 1, 0], [1, 0, 0, 1, 1, 0], sensitive_features=list("aaabbb"))
    0.5
    """
    law = _law(y_pred, sensitive_features, control_features, sample_weight, _truth(y_true))
    labels = [law.contexts[x][-1] for x in law.cell_context.tolist()]
    compared = {label for label, together in zip(labels, law.compared.tolist(), strict=True) if together}
    for label in labels:
        if label not in compared:
            raise _no_rate(label)
    found = _equalized_odds(law)
    if found is None:
        raise _nobody()
    return float(found.value)


@answered
def equal_opportunity(
    y_true: Any,
    y_pred: Any,
    *,
    sensitive_features: Any,
    control_features: Any = None,
    utility: Mapping[Any, Number] | None = None,
    sample_weight: Any = None,
    pos_label: Any = 1,
) -> float:
    """Equal opportunity: `equalized_odds` among the samples of one true label only.

    For two decisions it is the greatest difference of true positive rates.

    Parameters
    ----------
    y_true, y_pred, sensitive_features, control_features, utility, sample_weight
        As in `equalized_odds`.
    pos_label : label
        The true label that is positive.

    Returns
    -------
    float
        Between 0 (alike) and 1, with the conventions of `equalized_odds`.

    Raises
    ------
    InputError
        As `local_g_fairness`, and if no two groups with the same control features have samples of that true label.

    Examples
    --------
    >>> equal_opportunity([1, 1, 0, 1, 1, 0], [1, 0, 0, 1, 1, 1], sensitive_features=list("aaabbb"))
    0.5
    """
    law = _law(y_pred, sensitive_features, control_features, sample_weight, _truth(y_true))
    wanted = _worth(label_text(pos_label) or "")
    kept = [cell for cell, x in enumerate(law.cell_context.tolist()) if _worth(law.contexts[x][-1]) == wanted]
    positive = replace(law, cell_context=law.cell_context[kept], cell_group=law.cell_group[kept], weights=law.weights[kept])
    found = _equalized_odds(positive) if positive.compared.any() else None
    if found is None:
        raise _no_rate(pos_label)
    return float(found.value)


def _no_rate(label: Any) -> InputError:
    return InputError(
        f"no two groups with the same control features have samples whose true label is {shown(label)}, so that nobody is compared there"
    )


def _truth(y_true: Any) -> list[Any]:
    if y_true is None:
        raise InputError("y_true is None; give the true label of every sample, or use parity_within_contexts, which needs none")
    return _flat(y_true, "y_true")


def _law(y_pred: Any, sensitive_features: Any, control_features: Any, sample_weight: Any, truth: list[Any] | None = None) -> Law:
    groups = _features(sensitive_features, "sensitive feature")
    if not groups:
        raise InputError("sensitive_features is None; give the group of every sample")
    contexts = _features(control_features, "control feature")
    if truth is not None:
        contexts["true label"] = truth
    table = {"decision": _flat(y_pred, "y_pred"), **groups, **contexts}
    if sample_weight is None:
        return Law.from_log(table, decision="decision", group=list(groups), context=list(contexts))
    table["sample_weight"] = _flat(sample_weight, "sample_weight")
    return Law.from_counts(table, decision="decision", group=list(groups), context=list(contexts), count="sample_weight")


def _flat(values: Any, name: str) -> list[Any]:
    try:
        array = values if isinstance(values, np.ma.MaskedArray) else np.asarray(values)  # whose list has None where it is masked
    except ValueError:
        raise InputError(f"{name} has rows of different lengths; one value for each sample is accepted") from None
    if array.ndim == 2 and array.shape[1] == 1:
        array = array[:, 0]
    if array.ndim != 1:
        raise InputError(f"{name} has shape {array.shape}; one value for each sample is accepted")
    listed: list[Any] = array.tolist()
    return listed


def _features(features: Any, name: str) -> dict[str, list[Any]]:
    """Columns of features: of a frame or mapping by name, of arrays by number."""
    if features is None:
        return {}
    if isinstance(features, Mapping) or hasattr(features, "columns"):
        return {f"{name} {column}": _flat(features[column], f"{name} {shown(column)}") for column in getattr(features, "columns", features)}
    array = np.asarray(features, dtype=None if hasattr(features, "dtype") else object)
    if array.ndim == 1:
        return {name: array.tolist()}
    if array.ndim != 2:
        raise InputError(f"the {name}s have shape {array.shape}; one value, or one row of values, for each sample is accepted")
    return {f"{name} {i}": column.tolist() for i, column in enumerate(array.T)}


def _utility(utility: Mapping[Any, Number] | None, law: Law) -> Utility:
    if utility is None:
        try:
            return Utility({decision: TRUTH.get(decision, decision) for decision in law.decisions})
        except InputError as error:
            raise InputError(f"y_pred as a utility: {error}; or give utility={{decision: value}}") from None
    if not utility:
        raise InputError("the utility lists no decision; list at least one, such as {1: 1}")
    values = {label_text(decision) or "": value for decision, value in utility.items()}
    numbers = {_worth(label): value for label, value in values.items()}
    if not any(decision in values or _worth(decision) in numbers for decision in law.decisions):
        word = next(iter(values))
        raise InputError(
            f"none of the decisions that the utility lists occurs in y_pred, such as {shown(word)}; {nearest(word, law.decisions)} "
            "(where a sample may lack them, list those that are worth 0, too)"
        )
    return Utility({decision: values.get(decision, numbers.get(_worth(decision), 0)) for decision in law.decisions})


def _worth(label: str) -> Any:
    """A label, or the number or truth value that it says: ``1``, ``1.0`` and ``True`` are one label, as in Python."""
    try:
        return rational(TRUTH.get(label, label))
    except InputError:
        return label


def _log(found: Ratio | None) -> float:
    if found is None:
        raise _nobody()
    top, bottom = found.pair
    if not bottom or top == bottom:
        return inf if top != bottom else 0.0
    bits = 128
    while True:  # until both ends of the logarithm round to one float
        lo, hi = (float(Fraction(end, 1 << bits)) for end in log_fixed(top, bottom, bits))
        if lo == hi:
            return lo
        bits *= 2


def _nobody() -> InputError:
    return InputError("no two groups have the same control features, so that nobody is compared; use fewer control features")
