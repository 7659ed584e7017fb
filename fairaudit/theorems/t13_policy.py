"""The policy that attains the greatest ratio of T13, as a table."""

from __future__ import annotations

from dataclasses import replace
from fractions import Fraction
from math import gcd

import numpy as np

from fairaudit.errors import InputError
from fairaudit.exact.extended import Extended
from fairaudit.model.law import Law
from fairaudit.model.policy import Deployment, Policy
from fairaudit.model.utility import UtilityTable
from fairaudit.privacy.columns import Column
from fairaudit.tables.values import Label
from fairaudit.theorems.supremum import Supremum
from fairaudit.theorems.t13_tables import means_by_release

MAX_CELLS = 100_000
"""Released pairs of context and group for which a policy is written down."""

Worth = tuple[list[int], list[int]]
"""What every decision is worth to the two groups, over one denominator."""


def attaining_policy(deployment: Deployment, utility_table: UtilityTable, supremum: Supremum) -> Policy:
    """A deterministic policy whose ratio behind these filters is the greatest of all.

    Behind the filters no other two groups, and no other context, have a greater ratio, so that the figures of the audit are that value.

    Source: T13.

    Parameters
    ----------
    deployment : Deployment
        The filters. The new policy knows the contexts and groups that the policy of the deployment knows.
    utility_table : UtilityTable
        The utility.
    supremum : Supremum
        What `greatest_ratio` found.

    Returns
    -------
    Policy
        For each released context and group the decision that is best for the first group at that rate of exchange with the second; of
        equal ones that which gives the second more, then the first. Where groups are compared within contexts it ignores the context.

    Raises
    ------
    InputError
        If it has more than 100,000 cells, or needs several releases of the group.

    Examples
    --------
    >>> import fairaudit as fa
    >>> from fairaudit.theorems.t13 import greatest_ratio
    >>> policy = fa.Policy.from_array([["0.9", "0.1"], ["0.2", "0.8"]], decisions=["hire", "pass"], groups=["f", "m"])
    >>> coin = fa.RandomizedResponse(["f", "m"], keep_probability="2/3")
    >>> deployment = policy.behind(group=coin)
    >>> utility = fa.Utility({"hire": 3, "pass": 1})
    >>> found = greatest_ratio(deployment, utility.on(deployment.law), "local")
    >>> worst = attaining_policy(deployment, utility.on(deployment.law), found)
    >>> worst.law.weights.tolist()
    [[1, 0], [0, 1]]
    >>> from fairaudit.measures.ratios import local_fairness
    >>> local_fairness(worst.behind(group=coin).law, utility.on(worst.behind(group=coin).law)).ratio
    Fraction(7, 5)
    """
    if deployment.releases > 1:
        raise InputError(
            f"the policy that attains the greatest ratio sees {deployment.releases} releases of the group; a policy is a table of one: "
            "put it behind the filter with one release"
        )
    base = deployment.policy.law
    cells = len(base.cell_context)
    if cells > MAX_CELLS:
        raise InputError(f"the policy has {cells} cells of context and group; at most {MAX_CELLS} are written down")
    decide = _Decide(deployment, utility_table, supremum)
    weights = np.zeros((cells, len(utility_table.law.decisions)), dtype=np.int64)
    for cell, (x, a) in enumerate(zip(base.cell_context.tolist(), base.cell_group.tolist(), strict=True)):
        weights[cell, decide(base.contexts[x], base.groups[a])] = 1
    return Policy(
        Law(
            columns=replace(base.columns, truth=None),
            decisions=utility_table.law.decisions,
            groups=base.groups,
            contexts=base.contexts,
            kind="probabilities",
            population="equal",
            cell_context=base.cell_context,
            cell_group=base.cell_group,
            weights=weights,
        )
    )


class _Decide:
    """What the policy decides when it is shown a context and a group."""

    def __init__(self, deployment: Deployment, utility: UtilityTable, supremum: Supremum) -> None:
        self._value = supremum.value
        self._local = supremum.quantity == "local"
        self._rates: dict[Label, Column] = {}
        self._worth: dict[Label, Worth] = {}
        self._known: dict[tuple[Label, Column], int] = {}
        if supremum.higher is None or supremum.lower is None:  # every policy has the ratio 1
            return
        mechanism, labels = deployment.group_filter, (supremum.higher, supremum.lower)
        self._rates = dict(zip(mechanism.outputs, zip(*map(mechanism.row, labels), strict=True), strict=True))
        groups = [deployment.groups.index(label) for label in labels]
        if self._local:
            first = deployment.contexts.index(supremum.context or ()) * len(deployment.groups)
            self._worth[()] = utility.row(first + groups[0]), utility.row(first + groups[1])
            return
        means, bottoms = means_by_release(deployment, utility, groups)
        contexts = deployment.policy.law.contexts if deployment.context_filter is None else deployment.context_filter.outputs
        for label, (high, low) in zip(contexts, means.tolist(), strict=True):
            self._worth[label] = [v * bottoms[1] for v in high], [v * bottoms[0] for v in low]

    def __call__(self, context: Label, group: Label) -> int:
        """Number of the decision."""
        shown = () if self._local else context
        worth, (p, q) = self._worth.get(shown), self._rates.get(group, (0, 0))
        common = gcd(p, q)
        if worth is None or not common:
            return 0
        key = shown, (p // common, q // common)
        if key not in self._known:
            self._known[key] = _best(worth, *key[1], self._value)
        return self._known[key]


def _best(worth: Worth, p: int, q: int, value: Extended) -> int:
    """The decision with the greatest (p·A − V·q·B, q·B), and for an infinite V that with the least q·B, and then the greatest p·A."""
    every = range(len(worth[0]))
    if not isinstance(value, Fraction):
        return max(every, key=lambda u: (-q * worth[1][u], p * worth[0][u]))
    n, d = value.numerator, value.denominator
    return max(every, key=lambda u: (d * p * worth[0][u] - n * q * worth[1][u], q * worth[1][u]))
