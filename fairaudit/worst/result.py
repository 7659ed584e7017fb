"""The worst utility of a class for a law, between exact ends."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from fractions import Fraction
from functools import cached_property
from math import inf
from typing import Any, Literal

from fairaudit.exact.extended import ZERO, Extended
from fairaudit.measures.expectations import least_expectation
from fairaudit.measures.limits import Quantity
from fairaudit.measures.ratios import Witness
from fairaudit.model.law import Law
from fairaudit.model.utility import Utility
from fairaudit.model.utility_class import UtilityClass
from fairaudit.words import brief
from fairaudit.worst.attained import mean_under
from fairaudit.worst.setting import Setting


@brief
@dataclass(frozen=True, eq=False, repr=False)
class WorstCase:
    """The worst utility of a class for a law, between exact ends.

    Attributes
    ----------
    law : Law
        The law.
    utility_class : UtilityClass
        The class.
    quantity : {"local", "global"}
        Which ratio.
    upper, lower : Fraction or float
        R_hi, proved for every utility of the class, and R_lo, attained by `utility`; `math.inf` where the ratio is unbounded.
    witness : Witness
        The pair that attains `lower`, and its two expected utilities.
    method : {"closed form", "lp", "conic"}
        How it was found.
    certified : bool
        Whether the class that `upper` is about is the class itself: false for a ball, of which `upper` bounds a box around it.
    estimate : float or None
        The solver's own value, where it is not certified.
    by : {"T3", "lp-dual"}
        How `upper` is proved.
    theta : tuple of Fraction or None
        The parameters of `utility` in a family.

    Examples
    --------
    >>> import fairaudit as fa
    >>> law = fa.Law.from_array([[3, 1], [1, 1]], kind="counts", decisions=["yes", "no"], groups=["f", "m"])
    >>> found = fa.worst_case(law, fa.UtilityClass(tau="1/4"))
    >>> found.lower, found.upper, found.certified
    (Fraction(2, 1), Fraction(2, 1), True)
    """

    law: Law
    utility_class: UtilityClass
    quantity: Quantity
    upper: Extended
    lower: Extended
    witness: Witness
    method: Literal["closed form", "lp", "conic"]
    by: Literal["T3", "lp-dual"]
    theta: tuple[Fraction, ...] | None = None
    certified: bool = True
    estimate: float | None = None
    setting: Any = field(default=None, repr=False)
    values: Mapping[int, Sequence[Fraction]] = field(default_factory=dict, repr=False)
    """g by row of the utility (cells, or positions of contexts in a blind class); γ where none is given."""
    proof: Callable[[], dict[str, Any]] = field(default=dict, repr=False)
    shown: tuple[Mapping[int, Sequence[Fraction]], tuple[Fraction, ...] | None] | None = field(default=None, repr=False)
    """Another utility (and θ) for the certificate, where under the worst one groups without the floor differ more."""

    def __getstate__(self) -> dict[str, Any]:
        """What is pickled: the evidence in the place of what would find it."""
        return {**vars(self), "evidence": self.evidence, "proof": dict}

    @property
    def gap(self) -> float:
        """Relative gap (R_hi − R_lo)/R_lo."""
        if self.upper == self.lower:
            return 0.0
        if not isinstance(self.upper, Fraction) or not isinstance(self.lower, Fraction):
            return inf
        gap = (self.upper - self.lower) / self.lower
        return float(gap) if gap < 10**300 else inf

    @cached_property
    def evidence(self) -> dict[str, Any]:
        """What proves `upper`, as docs/certificate-worst-case.md lists it, numbers as `Fraction`."""
        return self.proof()

    @cached_property
    def utility(self) -> Utility:
        """The worst utility, exactly in the class: the same g(u) in every context where that is in the class too."""
        return utility_of_rows(self.setting, self.values)

    @property
    def certified_utility(self) -> Utility:
        """The utility for the certificate: the worst one, unless there groups that do not keep the floor differ more."""
        return self.utility if self.shown is None else utility_of_rows(self.setting, self.shown[0])

    @property
    def certified_theta(self) -> tuple[Fraction, ...] | None:
        """Its parameters in a family."""
        return self.theta if self.shown is None else self.shown[1]

    @property
    def bounded_class(self) -> UtilityClass:
        """The class that `upper` bounds: the class itself, or, for a ball, the box around it."""
        of: UtilityClass = self.setting.of
        return of

    def keeps_floor(self, witness: Witness) -> bool:
        """Tell whether the groups that have to keep the floor do so under `certified_utility`, for a pair in this context."""
        setting: Setting = self.setting
        values = self.values if self.shown is None else self.shown[0]
        return utility_keeps_floor(setting, values, witness)


def utility_keeps_floor(setting: Setting, values: Mapping[int, Sequence[Fraction]], witness: Witness) -> bool:
    """Tell whether the groups that have to keep the floor do so under a utility, for the pair of a witness."""
    if setting.of.tau is None:
        return True
    if setting.of.tau_on == "pair":
        return bool(min(witness.expectations) >= setting.of.tau)
    block = _block_of(setting, witness)
    return all(mean_under(setting, member, values) >= setting.of.tau for member in setting.members[block])


def _block_of(setting: Setting, witness: Witness) -> int:
    if witness.context is None:
        return 0
    labels = [None if place is None else setting.law.context_label(setting.contexts[place]) for place in setting.places]
    return labels.index(witness.context)


def utility_of_rows(setting: Setting, values: Mapping[int, Sequence[Fraction]]) -> Utility:
    """A utility from its rows; γ where none is given."""
    law, of = setting.law, setting.of
    rows = {tuple(row) for row in values.values()}
    if of.blind and not of.couples and len(rows) == 1:
        everywhere = Utility(dict(zip(law.decisions, next(iter(rows)), strict=True)))
        if len(values) == len(setting.contexts):
            return everywhere
        if setting.quantity == "local" and (least_expectation(law, everywhere.on(law)) or ZERO) >= of.floor > 0:
            return everywhere
    entries = {}
    for cell, (x, a) in enumerate(zip(law.cell_context.tolist(), law.cell_group.tolist(), strict=True)):
        row = values.get(setting.place_of[cell] if of.blind else cell)
        for u, label in enumerate(law.decisions):
            value = of.gamma if row is None else row[u]
            entries[label, law.contexts[x], law.groups[a]] = (value.numerator, value.denominator)
    if len(set(entries.values())) == 1:
        return Utility(dict.fromkeys(law.decisions, Fraction(*next(iter(entries.values())))))
    return Utility({}, entries)
