"""T8: filtering the context does not raise the local ratio of a utility of the decision alone."""

from __future__ import annotations

from dataclasses import replace
from math import inf

from fairaudit.errors import shown
from fairaudit.measures.ratios import local_fairness
from fairaudit.model.law import Law
from fairaudit.model.mechanism import Mechanism
from fairaudit.model.utility import UtilityTable
from fairaudit.tables.values import Label
from fairaudit.theorems.assumptions import DECISION_ONLY, FRESH
from fairaudit.theorems.bound import ANY_CONTEXT_FILTER, Bound
from fairaudit.theorems.case import Case

# T8: filtering the context


def t8_applies(law: Law, utility: UtilityTable, context_filter: Mechanism) -> tuple[bool, str]:
    """Tell whether T8 applies: then a context filter cannot raise the local ratio above that of the law with unfiltered contexts.

    Source: T8; Coq `T8_context_filter`, `T8_all_compared`.

    Parameters
    ----------
    law : Law
        The law with unfiltered contexts, its group filter and policy fixed.
    utility : UtilityTable
        The utility.
    context_filter : Mechanism
        The context filter; inputs and outputs are labels of contexts.

    Returns
    -------
    tuple of (bool, str)
        Whether it applies, and if not, why: the utility depends on more than the decision, or the filter can release something that is
        not itself a context in which all groups are compared. Nothing of the kind holds for the global ratio.

    Examples
    --------
    >>> from fairaudit.model.mechanism import RandomizedResponse
    >>> from fairaudit.model.utility import Utility
    >>> law = Law.from_array([[[1, 1], [2, 2]], [[3, 1], [0, 0]]], kind="counts", decisions=["yes", "no"])
    >>> t8_applies(law, Utility({"yes": 1}).on(law), RandomizedResponse(["0", "1"], keep_probability="0.7"))
    (False, "the filter can release the context '1', in which not all groups are compared")
    """
    if not utility.by_decision:
        return False, "the utility depends on context or group"
    members: dict[Label, int] = {}
    for x in law.cell_context.tolist():
        members[law.contexts[x]] = members.get(law.contexts[x], 0) + 1
    emitted = [any(row) for row in zip(*(context_filter.row(label) for label in context_filter.inputs), strict=True)]
    for label, possible in zip(context_filter.outputs, emitted, strict=True):
        if possible and members.get(label, 0) < len(law.groups):
            return False, f"the filter can release the context {shown(', '.join(label))}, in which not all groups are compared"
    return True, ""


def t8_in(case: Case) -> Bound | None:
    """T8 in a case: the local ratio over the contexts that the context filter can release; None where that is infinite.

    Source: T8; Coq `T8_released`.
    """
    released = case.deployment.filtered_contexts_law
    before = None if released is None else local_fairness(released, replace(case.utility, law=released))
    if before is None or before.ratio == inf:
        return None
    return Bound("T8", "local_ratio", before.ratio, {}, (), (FRESH, DECISION_ONLY), ANY_CONTEXT_FILTER)
