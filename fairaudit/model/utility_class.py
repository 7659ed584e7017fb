"""Classes of utilities, by the constraints that their members satisfy."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from itertools import pairwise
from math import inf
from typing import TYPE_CHECKING, Any, Literal, TypedDict, Unpack, get_type_hints

import numpy as np
from numpy.typing import NDArray

from fairaudit.arguments import answered, answered_class
from fairaudit.errors import Infeasible, InputError, nearest, shown
from fairaudit.exact.extended import Extended
from fairaudit.exact.rationals import Number, option_value
from fairaudit.model.law import Law
from fairaudit.model.utility import Utility, Values
from fairaudit.tables.label_text import label_text
from fairaudit.tables.values import ByLabel, Label, LabelLike, LabelsLike
from fairaudit.words import brief

if TYPE_CHECKING:
    import cvxpy

Term = tuple[Label | None, Label | None, str, Fraction]

Place = LabelLike | tuple[LabelLike] | tuple[LabelLike, LabelsLike] | tuple[LabelLike, LabelsLike, LabelsLike]

Terms = (
    Mapping[str, Number]
    | Mapping[tuple[str, str], Number]
    | Mapping[tuple[str, str, str], Number]
    | Mapping[tuple[str, Label], Number]
    | Mapping[tuple[str, Label, Label], Number]
    | Mapping[Place, Number]
    | Sequence[tuple[LabelsLike | None, LabelsLike | None, LabelLike, Number]]
)
"""Coefficients of a utility: by decision, by decision and context, or by decision, context and group."""

Distances = Callable[[Label, Label], Number] | NDArray[np.integer] | NDArray[np.floating] | Sequence[Sequence[Number]]
"""Distances between groups: a function, or a square table."""


Feature = ByLabel[Number] | Callable[[str, Label, Label], Number]
"""What a parameter multiplies: a number for each decision, or a function of decision, context and group."""


class ClassOptions(TypedDict, total=False):
    """What a class of utilities is given besides constraints."""

    gamma: Number
    m: Number
    tau: Number | None
    tau_on: Literal["all", "pair"]
    blind: bool
    lipschitz: Number | None
    metric: Distances | None
    order: Sequence[LabelLike] | Sequence[tuple[LabelLike, LabelLike]]
    rows: Sequence[LinearRow | tuple[Terms, Number]]
    family: Family | None
    ball: Ball | None


@answered_class(terms=Terms, bound=Number)
@brief
@dataclass(frozen=True, repr=False)
class LinearRow:
    """A linear constraint Σ coefficient·g ≤ bound on a utility.

    Parameters
    ----------
    terms : mapping or sequence of terms
        From ``(decision, context, group)`` to the coefficient of g(u,x,a); ``(decision, context)``, or the decision alone where there is a
        single context, in a class that is blind to the group. Contexts and groups are labels, or tuples of labels.
    bound : number
        The bound.

    Examples
    --------
    >>> LinearRow({"no": 1, "yes": "-1/2"}, 0).terms
    ((None, None, 'no', Fraction(1, 1)), (None, None, 'yes', Fraction(-1, 2)))
    """

    terms: tuple[Term, ...]
    bound: Fraction

    if TYPE_CHECKING:  # what is accepted; the attributes are what is kept of it

        def __init__(self, terms: Terms, bound: Number) -> None: ...

    def __post_init__(self) -> None:
        """Read labels and numbers."""
        items = self.terms.items() if isinstance(self.terms, Mapping) else [((u, x, a), c) for x, a, u, c in self.terms]
        terms: list[Term] = []
        for key, value in items:
            parts = key if isinstance(key, tuple) else (key,)
            if not 1 <= len(parts) <= 3:
                raise InputError(f"{shown(key)} does not name a value of the utility; give the decision, the context and the group")
            decision, context, group = (*parts, None, None)[:3]
            terms.append((_label(context), _label(group), str(label_text(decision)), read_number("a coefficient", value)))
        object.__setattr__(self, "terms", tuple(terms))
        object.__setattr__(self, "bound", read_number("the bound of a row", self.bound))


@answered_class(
    features=Mapping[str, Feature],
    lower=Number | Mapping[str, Number],
    upper=Number | Mapping[str, Number],
    rows=Sequence[tuple[Mapping[str, Number], Number]],
)
@brief
@dataclass(frozen=True, repr=False)
class Family:
    """Utilities g(u,x,a) = Σ_k θ_k φ_k(u,x,a) with θ in a polytope.

    Parameters
    ----------
    features : mapping
        From the name of k to φ_k: a mapping from decision to number, or a function of decision, context and group labels.
    lower, upper : number or mapping
        Bounds of θ, the same for all k or by name; they must be finite.
    rows : sequence of (mapping, number)
        Further constraints Σ coefficient·θ ≤ bound, coefficients by name.

    Examples
    --------
    >>> Family({"speed": {"fast": 1, "slow": 0}, "comfort": {"fast": 0, "slow": 1}}, 0, 1, rows=[({"speed": 1, "comfort": 1}, 1)]).names
    ('speed', 'comfort')
    """

    features: Mapping[str, Feature]
    lower: tuple[Fraction, ...] = 0  # type: ignore[assignment]
    upper: tuple[Fraction, ...] = 1  # type: ignore[assignment]
    rows: tuple[tuple[tuple[Fraction, ...], Fraction], ...] = ()

    if TYPE_CHECKING:  # what is accepted; the attributes are what is kept of it

        def __init__(
            self,
            features: Mapping[str, Feature],
            lower: Number | Mapping[str, Number] = 0,
            upper: Number | Mapping[str, Number] = 1,
            rows: Sequence[tuple[Mapping[str, Number], Number]] = (),
        ) -> None: ...

    def __post_init__(self) -> None:
        """Read the numbers."""
        if not self.features:
            raise InputError("the family has no features; name at least one")
        given: Any = self
        ends = []
        for end in (given.lower, given.upper):
            listed = []
            for name in self.features:
                if isinstance(end, Mapping) and name not in end:
                    raise InputError(f"the family has no bound for {shown(name)}; bounds of every parameter must be given")
                value = end[name] if isinstance(end, Mapping) else end
                listed.append(read_number(f"the bound of {shown(name)} in the family", value))
            ends.append(tuple(listed))
        for name, low, high in zip(self.features, *ends, strict=True):
            if low > high:
                raise Infeasible(f"the family bounds {shown(name)} by {low} from below and {high} from above; no utility is in the class")
        rows = []
        for coefficients, bound in given.rows:
            for name in coefficients:
                if name not in self.features:
                    raise InputError(f"a row of the family names {shown(name)}; {nearest(str(name), self.features)}")
            listed = [read_number("a coefficient of the family", coefficients.get(name, 0)) for name in self.features]
            rows.append((tuple(listed), read_number("the bound of a row of the family", bound)))
        object.__setattr__(self, "lower", ends[0])
        object.__setattr__(self, "upper", ends[1])
        object.__setattr__(self, "rows", tuple(rows))

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the parameters, in order."""
        return tuple(self.features)


@answered_class(reference=Utility | Values, radius=Number)
@brief
@dataclass(frozen=True, repr=False)
class Ball:
    """Utilities near a reference, in every context (and for every group, unless the class is blind).

    Parameters
    ----------
    reference : Utility or mapping
        g0, positive for every decision.
    radius : number
        The greatest divergence.
    divergence : {"chi2", "kl"}
        Σ_u (g − g0)²/g0, or Σ_u g·log(g/g0) − g + g0.

    Examples
    --------
    >>> Ball({"yes": 1, "no": "1/2"}, "0.1").radius
    Fraction(1, 10)
    """

    reference: Utility
    radius: Fraction
    divergence: Literal["chi2", "kl"] = "chi2"

    if TYPE_CHECKING:  # what is accepted; the attributes are what is kept of it

        def __init__(self, reference: Utility | Values, radius: Number, divergence: Literal["chi2", "kl"] = "chi2") -> None: ...

    def __post_init__(self) -> None:
        """Read the numbers."""
        if self.divergence not in ("chi2", "kl"):
            raise InputError(f"divergence={shown(self.divergence)} is not accepted; use 'chi2' or 'kl'")
        radius = read_number("the radius", self.radius)
        if radius < 0:
            raise InputError(f"the radius {radius} is negative; at least 0 is accepted")
        object.__setattr__(self, "radius", radius)
        object.__setattr__(self, "reference", self.reference if isinstance(self.reference, Utility) else Utility(self.reference))


@answered_class(**get_type_hints(ClassOptions))
@brief
@dataclass(frozen=True, repr=False)
class UtilityClass:
    """A class of utilities, by the constraints that its members satisfy; all numbers are exact.

    Parameters
    ----------
    gamma, m : number
        The range: m ≤ g ≤ γ.
    tau : number, optional
        A floor under expected utilities: E(x,a) in the context of the pair compared, or the group means for the global ratio.
    tau_on : {"all", "pair"}
        Whether every compared group keeps the floor, or only the pair.
    blind : bool
        Whether g must not depend on the group.
    lipschitz : number, optional
        |g(u,x,a) − g(u,x,a')| ≤ lipschitz·d(a,a'), for a class that is not blind.
    metric : callable or square array, optional
        d, of two group label tuples, or over the law's groups in order; 0/1 by default.
    order : sequence of labels or of (lower, higher)
        g(lower) ≤ g(higher): a chain from the least to the greatest decision, or any pairs; cycles make equalities.
    rows : sequence of LinearRow or (terms, bound)
        Further linear constraints.
    family : Family, optional
        Utilities that are combinations of given ones.
    ball : Ball, optional
        A convex ball around a reference utility; it is not certified but for a box around it.

    Examples
    --------
    >>> UtilityClass(gamma=1, tau="0.3", order=["low", "mid", "high"]).order
    (('low', 'mid'), ('mid', 'high'))
    """

    gamma: Fraction = Fraction(1)
    m: Fraction = Fraction(0)
    tau: Any = None
    tau_on: Literal["all", "pair"] = "all"
    blind: bool = True
    lipschitz: Any = None
    metric: Distances | None = None
    order: tuple[tuple[str, str], ...] = ()
    rows: tuple[LinearRow, ...] = ()
    family: Family | None = None
    ball: Ball | None = None

    if TYPE_CHECKING:  # what is accepted; the attributes are what is kept of it

        def __init__(
            self,
            gamma: Number = 1,
            m: Number = 0,
            tau: Number | None = None,
            tau_on: Literal["all", "pair"] = "all",
            blind: bool = True,
            lipschitz: Number | None = None,
            metric: Distances | None = None,
            order: Sequence[LabelLike] | Sequence[tuple[LabelLike, LabelLike]] = (),
            rows: Sequence[LinearRow | tuple[Terms, Number]] = (),
            family: Family | None = None,
            ball: Ball | None = None,
        ) -> None: ...

    def __post_init__(self) -> None:
        """Read the numbers, and refuse a class that is empty or not bounded on the face of it."""
        gamma, m = read_number("gamma", self.gamma), read_number("m", self.m)
        tau = None if self.tau is None else read_number("tau", self.tau)
        if gamma <= 0 or not 0 <= m <= gamma:
            raise InputError(f"the range from {m} to {gamma} holds no utilities; it needs 0 <= m <= gamma and gamma > 0")
        if tau is not None and not 0 <= tau <= gamma:
            raise InputError(f"the floor {tau} lies outside [0, {gamma}]; no utility of at most gamma has a mean above gamma")
        if self.tau_on not in ("all", "pair"):
            raise InputError(f"tau_on={shown(self.tau_on)} is not accepted; use 'all' or 'pair'")
        lipschitz = None if self.lipschitz is None else read_number("lipschitz", self.lipschitz)
        if lipschitz is not None and self.blind:
            raise InputError("a Lipschitz constant goes with a class that is not blind to the group; set blind=False")
        if lipschitz is not None and lipschitz < 0:
            raise InputError(f"the Lipschitz constant {lipschitz} is negative; at least 0 is accepted")
        rows = tuple(row if isinstance(row, LinearRow) else LinearRow(*row) for row in self.rows)
        named: dict[str, Any] = {"gamma": gamma, "m": m, "tau": tau, "lipschitz": lipschitz, "order": _pairs(self.order), "rows": rows}
        for name, value in named.items():
            object.__setattr__(self, name, value)

    @staticmethod
    @answered
    def from_cvxpy(
        law: Law, variable: cvxpy.Variable, constraints: Sequence[cvxpy.Constraint], **options: Unpack[ClassOptions]
    ) -> UtilityClass:
        """Make a class from affine cvxpy constraints; their coefficients are taken as the exact dyadic rationals that cvxpy derives.

        Parameters
        ----------
        law : Law
            Whose contexts, groups and decisions the entries of the variable are.
        variable : cvxpy.Variable
            The utility, of shape (rows, decisions): a row for each context that has a cell if the class is blind, else for each cell of
            the law, in its order. A single row may be of shape (decisions,).
        constraints : sequence of cvxpy constraints
            Affine inequalities and equalities in that variable.
        **options
            The other parameters of `UtilityClass`.

        Returns
        -------
        UtilityClass
            The class, with a row for every inequality and two for every equality.

        Raises
        ------
        InputError
            If a constraint is not affine in the variable, or the shape does not fit.
        """
        blind = options.get("blind", True)
        n = len(law.decisions)
        cells = list(zip(law.cell_context.tolist(), law.cell_group.tolist(), strict=True))
        slots = [(x, None) for x in dict.fromkeys(x for x, _ in cells)] if blind else cells
        if variable.shape != (len(slots), n) and not (len(slots) == 1 and variable.shape == (n,)):
            raise InputError(f"the variable has shape {variable.shape}; it must be {(len(slots), n)}, rows of the utility by decisions")
        rows = []
        for matrix, bounds in _affine(variable, constraints):
            for coefficients, bound in zip(matrix, bounds, strict=True):
                terms: list[Term] = []
                for j in np.flatnonzero(coefficients).tolist():
                    row, u = divmod(j, n)
                    x, a = slots[row]
                    terms.append((law.contexts[x], None if a is None else law.groups[a], law.decisions[u], Fraction(coefficients[j])))
                rows.append(LinearRow(terms, Fraction(bound)))
        asked: dict[str, Any] = dict(options)
        return UtilityClass(**{**asked, "rows": (*options.get("rows", ()), *rows)})

    @property
    def floor(self) -> Fraction:
        """The greater of m and the floor: what every compared mean is at least."""
        least: Fraction = self.m if self.tau is None else max(self.tau, self.m)
        return least

    @property
    def cap(self) -> Extended:
        """γ/τ, which no ratio exceeds; infinite without a floor."""
        quotient: Extended = self.gamma / self.floor if self.floor else inf
        return quotient

    @property
    def closed_form(self) -> bool:
        """Whether theorems T3, T4 and T6 give the exact answer."""
        return self.blind and not self.order and not self.couples and self.ball is None

    @property
    def couples(self) -> bool:
        """Whether a constraint may tie several contexts together."""
        return bool(self.rows) or self.family is not None


def _affine(variable: Any, constraints: Sequence[Any]) -> Iterator[tuple[NDArray[np.float64], NDArray[np.float64]]]:
    """Rows A and b of A·g ≤ b, with g flattened row by row, from affine cvxpy constraints."""
    import cvxpy

    if any(value is not None and value is not False for value in variable.attributes.values()):
        raise InputError(f"the variable {variable.name()} has attributes; write them as constraints")
    cp: Any = cvxpy
    kinds = tuple(getattr(cp.constraints, name) for name in ("Inequality", "Equality", "NonNeg", "NonPos", "Zero"))
    for constraint in constraints:
        if not isinstance(constraint, kinds) or not all(part.is_affine() for part in constraint.args):
            raise InputError(f"the constraint {shown(str(constraint), 200)} is not affine; a linear class takes affine constraints only")
        if [other.id for other in constraint.variables()] != [variable.id]:
            raise InputError(f"the constraint {shown(str(constraint), 200)} is not one on the utility alone")
        data, _, _ = cp.Problem(cp.Minimize(0), [constraint]).get_problem_data(cp.CLARABEL)
        matrix, bounds, equal = data["A"].toarray(), np.asarray(data["b"], dtype=np.float64), data["dims"].zero
        if matrix.shape[1] != variable.size or not (np.isfinite(matrix).all() and np.isfinite(bounds).all()):
            raise InputError(f"the constraint {shown(str(constraint), 200)} has coefficients that cannot be taken over")
        index = np.arange(variable.size).reshape(variable.shape, order="F").ravel()  # cvxpy counts by columns
        matrix = matrix[:, index]
        yield np.vstack((matrix, -matrix[:equal])), np.concatenate((bounds, -bounds[:equal]))


def read_number(name: str, value: Any, read: Callable[[object], tuple[int, int]] = option_value) -> Fraction:
    """An option's value as the rational that it says; what is wrong with it is said with the option's name."""
    try:
        return Fraction(*read(value))
    except InputError as error:
        raise InputError(f"{name}: {error}") from None


def _label(value: Any) -> Label | None:
    if value is None:
        return None
    return tuple(str(label_text(part)) for part in (value if isinstance(value, (tuple, list)) else (value,)))


def _pairs(order: Any) -> tuple[tuple[str, str], ...]:
    listed = list(order)
    if all(isinstance(entry, (tuple, list)) for entry in listed):
        for entry in listed:
            if len(entry) != 2:
                raise InputError(f"{shown(entry)} in the order is not a pair (lower, higher)")
        return tuple((str(label_text(low)), str(label_text(high))) for low, high in listed)
    labels = [str(label_text(entry)) for entry in listed]
    if len(labels) < 2:
        raise InputError("the order names one decision; give a chain of at least two, or pairs (lower, higher)")
    return tuple(pairwise(labels))
