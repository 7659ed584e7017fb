"""T13: the greatest ratio that any policy attains behind known filters, for a known utility, exactly.

For V ≥ 1 no policy behind the filters exceeds V for an ordered pair of groups exactly if S(V) = Σ_o max_u [p(o,u) − V·q(o,u)] ≤ 0, where
o runs over what the filters can release and p, q are what decision u under o adds to the expected utility of the two groups. Filters stay
factors: released groups of equal likelihood ratio are one, and so are pairs of groups with the same ratios and the same utilities.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from math import inf

import numpy as np

from fairaudit.exact.extended import ONE, Extended
from fairaudit.measures.limits import Quantity
from fairaudit.model.policy import Deployment
from fairaudit.model.utility import UtilityTable
from fairaudit.privacy.pairs import Column, kinds_of_pairs, kinds_of_row
from fairaudit.theorems.supremum import Supremum
from fairaudit.theorems.t13_exact import greatest_above
from fairaudit.theorems.t13_tables import Tables, utility_tables


def greatest_ratio(deployment: Deployment, utility_table: UtilityTable, quantity: Quantity) -> Supremum | None:
    """T13: the greatest ratio of expected utilities that any policy attains behind these filters, and where.

    Source: T13.

    Parameters
    ----------
    deployment : Deployment
        The filters, and the population. Its policy does not matter.
    utility_table : UtilityTable
        The utility over the true contexts and groups; it may depend on decision, context and group.
    quantity : {"local", "global"}
        Whether groups are compared within contexts, or by their means.

    Returns
    -------
    Supremum or None
        Exact and attained; None where nothing is compared, or where g is not given for some decision. Of equal ratios the first in input
        order counts, by context, group in the numerator, group in the denominator.

    Examples
    --------
    >>> import fairaudit as fa
    >>> policy = fa.Policy.from_array([["0.9", "0.1"], ["0.2", "0.8"]], decisions=["hire", "pass"], groups=["f", "m"])
    >>> deployment = policy.behind(group=fa.RandomizedResponse(["f", "m"], keep_probability="2/3"))
    >>> greatest_ratio(deployment, fa.Utility({"hire": 3, "pass": 1}).on(deployment.law), "local").value
    Fraction(7, 5)
    """
    tables = utility_tables(deployment, utility_table, quantity)
    if tables is None:
        return None
    columns, problems = _problems(deployment, tables)
    value: Extended = ONE
    where = None
    for problem in problems:
        envelopes = tables.envelopes(problem.higher_table, problem.lower_table)
        greater = greatest_above(columns[problem.kind], envelopes, value)
        if greater is not None:
            value, where = greater, problem
            if value == inf:
                break
    if where is None:
        return Supremum(quantity, ONE)
    context = deployment.contexts[where.context] if quantity == "local" else None
    return Supremum(quantity, value, True, context, deployment.groups[where.higher], deployment.groups[where.lower])


@dataclass(frozen=True)
class _Problem:
    """An ordered pair of groups, the first of its kind: likelihood ratios and utility tables."""

    context: int
    higher: int
    lower: int
    kind: int
    higher_table: int
    lower_table: int


def _problems(deployment: Deployment, tables: Tables) -> tuple[list[tuple[Column, ...]], Iterator[_Problem]]:
    """Likelihood ratios of pairs by kind, and the first ordered pair of each kind in input order."""
    mechanism = deployment.group_filter
    kinds = kinds_of_pairs(mechanism)
    rows = [np.array(kinds_of_row(mechanism, kinds, a)) for a in range(len(deployment.groups))]

    def listed() -> Iterator[_Problem]:
        seen: set[tuple[int, int, int]] = set()
        for x, of in zip(tables.contexts, tables.of.tolist(), strict=True):
            for a, row in enumerate(rows):
                for b, kind in enumerate(row.tolist()):
                    key = kind, of[a], of[b]
                    if a != b and min(key) >= 0 and key not in seen:
                        seen.add(key)
                        yield _Problem(x, a, b, *key)

    return list(kinds.examples), listed()
