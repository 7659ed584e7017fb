"""A policy behind filters as theorems look at it: its constants, and the floor in question."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field, replace
from fractions import Fraction
from functools import cached_property
from math import inf
from typing import Literal

import numpy as np

from fairaudit.exact.extended import Extended
from fairaudit.model.law import Law
from fairaudit.model.policy import Deployment
from fairaudit.model.utility import UtilityTable
from fairaudit.privacy.columns import TooManyColumns
from fairaudit.privacy.epsilon_delta import exp_epsilon
from fairaudit.privacy.pairs import joint_ratios
from fairaudit.tables.values import Label

PAIR_RATIOS = 500_000
"""As many joint likelihood ratios as docs/certificate.md lets a claim ask a reader to go through."""

TOO_WIDE = (
    f"what T13, T1, T3 and T4 guarantee behind this filter is left out: its pairs of rows have more than {PAIR_RATIOS} joint likelihood "
    "ratios, which no certificate may ask a reader to go through"
)


@dataclass(frozen=True)
class Case:
    """A policy behind filters, and the constants by which theorems bound it.

    Attributes
    ----------
    deployment : Deployment
        The policy and its filters.
    law : Law
        The law that they induce.
    utility : UtilityTable
        The utility on that law.
    declared : mapping of str to Fraction
        Constants that take the place of those of the table: ``gamma``, ``m``, ``lipschitz``; ``tau`` stands beside that of the table,
        ``global_tau`` is a floor of group means, and ``max_drift`` says how far other policies are from this one.
    declared_in : mapping of label to mapping of str to Fraction
        ``gamma``, ``m`` and ``tau`` of single contexts, in the order of the contexts.
    tau : Fraction
        The floor in question, 0 where there is none.
    floor : {"table", "declared"}
        Where it comes from.
    """

    deployment: Deployment
    law: Law
    utility: UtilityTable
    declared: Mapping[str, Fraction]
    tau: Fraction = Fraction(0)
    floor: Literal["table", "declared"] = "table"
    declared_in: Mapping[Label, Mapping[str, Fraction]] = field(default_factory=dict)

    def above(self, tau: Fraction | None) -> Iterator[Case]:
        """The same for each floor above 0: that of the table, which is given, and the one that was declared."""
        if tau:
            yield replace(self, tau=tau, floor="table")
        if self.declared.get("tau"):
            yield replace(self, tau=self.declared["tau"], floor="declared")

    @property
    def gamma(self) -> Fraction:
        """The greatest utility."""
        return self.declared.get("gamma", self.utility.gamma)

    @property
    def m(self) -> Fraction:
        """The least utility."""
        return self.declared.get("m", self.utility.m)

    @cached_property
    def gap(self) -> Fraction:
        """The greatest difference of utility between groups for the same decision and context."""
        return self.declared.get("lipschitz", self.utility.lipschitz())

    @cached_property
    def exp_epsilon(self) -> Extended:
        """e^ε of the group filter."""
        return exp_epsilon(self.deployment.group_filter)

    @cached_property
    def narrow(self) -> bool:
        """Whether a reader may be asked to go through the pairs of rows of the group filter."""
        try:
            return joint_ratios(self.deployment.group_filter, self.deployment.releases) <= PAIR_RATIOS
        except TooManyColumns:
            return False

    @property
    def cap(self) -> Fraction:
        """What the floor proves by itself."""
        return self.gamma / self.tau

    def laid_over(self, law: Law) -> UtilityTable:
        """The utility, which must not depend on the group, laid out over other groups in the same contexts."""
        if self.utility.by_decision:
            return replace(self.utility, law=law)
        first = self.utility.law.starts[:-1]
        return replace(self.utility, law=law, values=np.repeat(self.utility.values[first], np.diff(law.starts), axis=0))


NEEDS: dict[str, Callable[[Case], bool]] = {
    "a-free": lambda case: case.gap == 0,
    "g(u)": lambda case: case.utility.by_decision,
    "finite": lambda case: case.exp_epsilon < inf,
    "context filter": lambda case: case.deployment.context_filter is not None,
    "independent": lambda case: case.law.independent,
    "one release": lambda case: case.deployment.releases == 1,
}
"""What a kind of claim can need of a case, by the names of the registry."""
