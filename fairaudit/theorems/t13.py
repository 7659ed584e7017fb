"""T13: the greatest ratio that any policy attains behind known filters, for a known utility, exactly.

For V ≥ 1 no policy behind the filters exceeds V for an ordered pair of groups exactly if S(V) = Σ_o max_u [p(o,u) − V·q(o,u)] ≤ 0, where
o runs over what the filters can release and p, q are what decision u under o adds to the expected utility of the two groups. Filters stay
factors: released groups of equal likelihood ratio are one, and so are pairs of groups with the same ratios and the same utilities.
"""

from __future__ import annotations

from fractions import Fraction
from math import inf

import numpy as np

from fairaudit.exact.extended import ONE, Extended
from fairaudit.measures.limits import Quantity
from fairaudit.model.policy import Deployment
from fairaudit.model.utility import UtilityTable
from fairaudit.theorems.supremum import Supremum
from fairaudit.theorems.t13_exact import Points, attained, greatest_above
from fairaudit.theorems.t13_problems import Problems, different_pairs
from fairaudit.theorems.t13_search import Search
from fairaudit.theorems.t13_tables import Ints, Tables, utility_tables


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
    problems = different_pairs(deployment.group_filter, deployment.releases, tables)
    value, at = _greatest(problems, tables)
    if at is None:
        return Supremum(quantity, ONE)
    x, higher, lower = problems.place(at)
    context = deployment.contexts[x] if quantity == "local" else None
    return Supremum(quantity, value, True, context, deployment.groups[higher], deployment.groups[lower])


def _greatest(problems: Problems, tables: Tables) -> tuple[Extended, int | None]:
    """The greatest ratio of all pairs, and the first that attains it; None where it is 1."""
    search = Search(problems, tables)
    infinite = search.infinite()
    if infinite is not None:
        return inf, infinite
    value, left = ONE, np.arange(len(problems))
    for level in search.levels:
        while True:
            left, sums = search.possible(left, value, level)
            promising = search.promising(left, sums, value)
            greater = None if promising is None else _greater(problems, tables, promising, value)
            if greater is None:
                break
            value = greater
    return _first(problems, tables, left, value)


def _greater(problems: Problems, tables: Tables, at: int, value: Fraction) -> Fraction | None:
    """The greatest ratio of a pair if it is above a value; finite."""
    envelopes = tables.envelopes(int(problems.higher[at]), int(problems.lower[at]))
    found = greatest_above(problems.laws.columns[problems.kind[at]], envelopes, value)
    return found if isinstance(found, Fraction) else None


def _first(problems: Problems, tables: Tables, left: Ints, value: Fraction) -> tuple[Fraction, int | None]:
    """The greatest ratio of the pairs that are left, and the first that attains it, exactly; pairs that are alike are looked at once."""
    first = None
    seen: set[tuple[int, tuple[Points, ...]]] = set()
    for at in left.tolist():
        envelopes = tuple(sorted(tables.envelopes(int(problems.higher[at]), int(problems.lower[at]))))
        kind = int(problems.kind[at])
        if (kind, envelopes) in seen:
            continue
        seen.add((kind, envelopes))
        greater = greatest_above(problems.laws.columns[kind], envelopes, value)
        if isinstance(greater, Fraction):
            value, first = greater, at
        elif first is None and value > 1 and attained(problems.laws.columns[kind], envelopes, value):
            first = at
    return value, first
