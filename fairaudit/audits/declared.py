"""What was declared besides the table: constants of the utility, floors, and how far other policies may be; none contradicts the table."""

from __future__ import annotations

from collections.abc import Mapping
from fractions import Fraction
from typing import TYPE_CHECKING, Any

from fairaudit.errors import InputError, nearest, shown
from fairaudit.exact.extended import ZERO
from fairaudit.exact.rationals import Number, option_value
from fairaudit.measures.expectations import compared_expectations
from fairaudit.model.utility import UtilityTable
from fairaudit.tables.values import Label, names
from fairaudit.words import approximate

if TYPE_CHECKING:
    from fairaudit.model.policy import Deployment


GREATEST = ("gamma", "lipschitz")
"""Constants that the table must not exceed; it must not fall below the others."""

RANGE = ("gamma", "m")
"""The ends of what could be drawn."""

OF_POLICIES = ("tau", "global_tau", "lipschitz")
"""Constants that are declared of a policy behind filters only."""

Constants = dict[str, Fraction]

ByContext = Mapping[str, Mapping[str, Number]] | Mapping[Label, Mapping[str, Number]]
"""Constants of single contexts as they are given, by label."""


def read_declared(
    table: UtilityTable,
    tau: Fraction | None,
    declared: Mapping[str, Any],
    declared_in: ByContext,
    max_drift: Any,
    deployment: Deployment | None,
    *,
    signed: bool = False,
) -> tuple[Constants, dict[Label, Constants]]:
    """Constants that were declared, of all contexts and of single ones, as exact rationals.

    Parameters
    ----------
    table : UtilityTable
        The utility on the law.
    tau : Fraction or None
        The least expected utility that is compared.
    declared, declared_in, max_drift
        As given to `certify`.
    deployment : Deployment or None
        The policy behind filters, if that is what is audited.
    signed : bool
        Whether the range of the utility may be declared with negative ends, as differences allow it.

    Raises
    ------
    InputError
        If one is not known, is no number, contradicts the table, or goes with a policy behind filters and there is none.
    """
    if deployment is None:
        if declared.keys() & set(OF_POLICIES):
            raise InputError("tau, global_tau and lipschitz are declared for a policy behind filters; a plain table has its own")
        if declared_in:
            raise InputError("constants of single contexts are declared for a policy behind filters; this is a plain table")
    measured = {"gamma": table.gamma, "m": table.m, "tau": tau, "global_tau": None, "lipschitz": table.lipschitz()}
    if "global_tau" in declared:
        measured["global_tau"] = _least_mean(table)
    constants = _read(declared, measured, "", signed=signed)
    if max_drift is not None:
        from fairaudit.theorems.t13_near import read_drift

        constants["max_drift"] = read_drift(max_drift, "max_drift")
        if deployment is not None and deployment.releases > 1:
            raise InputError(f"max_drift is about policies that see one release of a group; here one memory sees {deployment.releases}")
    return constants, {} if deployment is None else _read_in(table, declared_in, deployment)


def _read(declared: Mapping[str, Any], measured: Mapping[str, Fraction | None], where: str, *, signed: bool = False) -> Constants:
    constants: Constants = {}
    for name, value in declared.items():
        if name not in measured:
            raise InputError(f"{shown(name)} cannot be declared{where}; {nearest(name, measured)}")
        try:
            constants[name] = Fraction(*option_value(value))
        except InputError as error:
            raise InputError(f"the declared {name}{where}: {error}") from None
        found = measured[name]
        if constants[name] < 0 and not (signed and name in RANGE):
            beside = "" if name not in RANGE else ", unless differences alone are asked for (difference, --difference)"
            raise InputError(f"the declared {name}{where} is {shown(value)}; it must be at least 0{beside}")
        if found is None:
            continue
        if name in GREATEST and constants[name] < found:
            most = approximate(found, "up")
            raise InputError(f"the declared {name}{where} is {shown(value)}, but the table has {most}; declare at least that")
        if name not in GREATEST and constants[name] > found:
            least = approximate(found, "down")
            raise InputError(f"the declared {name}{where} is {shown(value)}, but the table has only {least}; declare at most that")
    return constants


def _least_mean(table: UtilityTable) -> Fraction:
    """The least expected utility of a group overall."""
    means = compared_expectations(table.law, table, within_context=False)
    if not any(means):
        raise InputError("global_tau is a floor of group means, and no two groups have a population; leave it out")
    return min(mean for block in means for mean in block)


def _read_in(table: UtilityTable, declared_in: ByContext, deployment: Deployment) -> dict[Label, Constants]:
    """Constants of single contexts, in the order of the contexts."""
    given = {names(label): constants for label, constants in declared_in.items()}
    places = {label: i for i, label in enumerate(deployment.contexts)}
    for label, constants in given.items():
        if label not in places:
            raise InputError(f"there is no context {shown(', '.join(label))} for which to declare constants; name one of the table")
        if not constants:
            raise InputError(f"nothing is declared in context {shown(', '.join(label))}; declare gamma, m or tau")
    means = compared_expectations(table.law, table, within_context=True) if given else []
    found = {}
    for label in sorted(given, key=places.__getitem__):
        x, groups = places[label], len(deployment.groups)
        values = table.values if table.by_decision else table.values[x * groups : (x + 1) * groups]
        if table.given is not None:
            values = values[table.given if table.by_decision else table.given[x * groups : (x + 1) * groups]]
        own = {
            "gamma": Fraction(int(values.max()), table.scale),
            "m": Fraction(int(values.min()), table.scale),
            "tau": min(means[x], default=ZERO),
        }
        found[label] = _read(given[label], own, f" in context {shown(', '.join(label))}")
    return found
