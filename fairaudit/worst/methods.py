"""The utility of a class that makes a law look worst: sup of the local or global ratio over g, enclosed between exact ends.

R_lo is attained by a utility that is exactly in the class; R_hi is proved for all of the class by weak duality. Floats only
search: whatever a solver answers, wrong answers can loosen [R_lo, R_hi] or end in a refusal, but not make it false.

A class that only has a range [m, γ] and one common floor is solved in closed form; then R_lo = R_hi. Other classes are
linear-fractional programs, one per ordered pair of groups.
"""

from __future__ import annotations

from fairaudit.arguments import answered
from fairaudit.measures.limits import Quantity
from fairaudit.model.law import Law
from fairaudit.model.utility_class import UtilityClass
from fairaudit.worst.closed_form import closed_form_case
from fairaudit.worst.conic import conic_case
from fairaudit.worst.reading import lay_out
from fairaudit.worst.result import WorstCase
from fairaudit.worst.search import linear_case


@answered
def worst_case(law: Law, utility_class: UtilityClass, quantity: Quantity = "local") -> WorstCase:
    """Find the utility of a class for which a law looks worst.

    Parameters
    ----------
    law : Law
        The law P(u|x,a).
    utility_class : UtilityClass
        The class 𝒢.
    quantity : {"local", "global"}
        Whether groups are compared within each context, or by their means over contexts.

    Returns
    -------
    WorstCase
        R_lo ≤ sup over 𝒢 of R ≤ R_hi, exact ends, with the utility that attains R_lo and the proof of R_hi.

    Raises
    ------
    InputError
        If the class is empty, does not fit the law, or nothing can be compared. Source: theory, worst-case g; T3, T4 and T6.

    Examples
    --------
    >>> law = Law.from_array([[3, 1], [1, 1]], kind="counts", decisions=["yes", "no"], groups=["f", "m"])
    >>> worst_case(law, UtilityClass(tau="1/4")).upper
    Fraction(2, 1)
    >>> found = worst_case(law, UtilityClass(tau="3/4", order=["no", "yes"]))
    >>> found.lower, found.upper, found.utility.values["no"]
    (Fraction(7, 6), Fraction(7, 6), Fraction(1, 2))
    """
    setting = lay_out(law, utility_class, quantity)
    if utility_class.closed_form:
        return closed_form_case(setting)
    if utility_class.ball is not None:
        return conic_case(setting)
    return linear_case(setting)
