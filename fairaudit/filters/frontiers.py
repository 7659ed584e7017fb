"""Filters of one setting for several targets: how much truth each target costs."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from fractions import Fraction
from typing import Any, TypedDict, Unpack

from fairaudit.errors import InputError
from fairaudit.exact.rationals import Number
from fairaudit.filters.design_result import Design
from fairaudit.filters.groups import Groups, Masses
from fairaudit.filters.model_free import design_model_free
from fairaudit.filters.problem import Distortion
from fairaudit.filters.with_policy import design
from fairaudit.measures.limits import ALONE, without_bare_limits
from fairaudit.model.policy import Policy, Population
from fairaudit.model.utility import Utility, Values
from fairaudit.words import brief


@brief
@dataclass(frozen=True, repr=False)
class Frontier:
    """Designs of one setting for several targets.

    Attributes
    ----------
    designs : tuple of Design
        One for each target, in the order given.

    Examples
    --------
    >>> import fairaudit as fa
    >>> [design.truth_kept for design in fa.frontier(max_ratio=["1.2", "1.4"], groups=2, tau="0.5").designs]
    [Fraction(5, 9), Fraction(5, 8)]
    """

    designs: tuple[Design, ...]

    @property
    def rows(self) -> list[dict[str, Fraction | float | None]]:
        """Target against truth kept, as a table for `pandas.DataFrame`: exact numbers, None where there is no filter."""
        return [
            {
                "max_ratio": d.target,
                "truth_kept": d.truth_kept,
                "distortion": d.distortion,
                "lower_bound": d.lower_bound,
                "achieved_ratio": d.achieved,
                "exp_epsilon": d.exp_epsilon if d.feasible else None,
                "response_truth_kept": d.response_truth_kept,
                "response_distortion": d.response_distortion,
            }
            for d in self.designs
        ]


class DesignOptions(TypedDict, total=False):
    """What `design` and `design_model_free` are asked besides the target."""

    groups: Groups
    tau: Number
    gamma: Number
    g_min: Number
    lipschitz: Number
    population: Population | Masses | None
    distortion: Distortion | None
    max_epsilon: Number | None
    max_exp_epsilon: Number | None


@without_bare_limits(ALONE)
def frontier(
    *,
    max_ratio: Iterable[Number] | None = None,
    max_log: Iterable[Number] | None = None,
    policy: Policy | None = None,
    utility: Utility | Values | None = None,
    **options: Unpack[DesignOptions],
) -> Frontier:
    """Design for several targets: how much truth each of them costs.

    Parameters
    ----------
    max_ratio, max_log : iterable of number or str, optional
        Targets for R, or for L, its natural logarithm; exactly one of the two.
    policy, utility
        As in `design`; without a policy `design_model_free` is asked, whose `groups` are then among the options.
    **options
        As in `design` or `design_model_free`.

    Returns
    -------
    Frontier
        The designs; `rows` is the table.

    Raises
    ------
    InputError
        If not exactly one kind of target is given, or neither a policy with its utility nor groups, or as `design`.

    Examples
    --------
    >>> found = frontier(max_ratio=["1.2", "1.4"], groups=2, tau="0.5")
    >>> [str(row["truth_kept"]) for row in found.rows]
    ['5/9', '5/8']
    """
    asked: dict[str, Iterable[Any]] = {name: value for name, value in (("max_ratio", max_ratio), ("max_log", max_log)) if value is not None}
    if len(asked) != 1:
        raise InputError("give the targets as one of max_ratio, limits on the ratio, and max_log, limits on its natural logarithm")
    ((name, targets),) = asked.items()
    others: dict[str, Any] = dict(options)
    if policy is None:
        if "groups" not in options:
            raise InputError("neither a policy nor groups were given; give a policy with its utility, or groups")
        return Frontier(tuple(design_model_free(**{name: target}, **others) for target in targets))
    if utility is None:
        raise InputError("a policy was given without a utility; give both")
    return Frontier(tuple(design(policy, utility, **{name: target}, **others) for target in targets))
