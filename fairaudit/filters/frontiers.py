"""Filters of one setting for several targets: how much truth each target costs."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from fractions import Fraction
from typing import Any

from fairaudit.errors import InputError
from fairaudit.filters.design_result import Design
from fairaudit.filters.model_free import design_model_free
from fairaudit.filters.with_policy import design
from fairaudit.measures.limits import ALONE, without_bare_limits
from fairaudit.model.policy import Policy
from fairaudit.model.utility import Utility


@dataclass(frozen=True)
class Frontier:
    """Designs of one setting for several targets.

    Attributes
    ----------
    designs : tuple of Design
        One for each target, in the order given.
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


@without_bare_limits(ALONE)
def frontier(
    *,
    max_ratio: Iterable[Any] | None = None,
    max_log: Iterable[Any] | None = None,
    policy: Policy | None = None,
    utility: Utility | Mapping[Any, Any] | None = None,
    **options: Any,
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

    Examples
    --------
    >>> found = frontier(max_ratio=["1.2", "1.4"], groups=2, tau="0.5")
    >>> [str(row["truth_kept"]) for row in found.rows]
    ['5/9', '5/8']
    """
    asked = {name: value for name, value in (("max_ratio", max_ratio), ("max_log", max_log)) if value is not None}
    if len(asked) != 1:
        raise InputError("give the targets as one of max_ratio, limits on the ratio, and max_log, limits on its natural logarithm")
    ((name, targets),) = asked.items()
    if policy is None:
        if "groups" not in options:
            raise InputError("neither a policy nor groups were given; give a policy with its utility, or groups")
        return Frontier(tuple(design_model_free(**{name: target}, **options) for target in targets))
    if utility is None:
        raise InputError("a policy was given without a utility; give both")
    return Frontier(tuple(design(policy, utility, **{name: target}, **options) for target in targets))
