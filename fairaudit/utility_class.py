"""Classes of utilities, by constraints, and such a class laid out over a law as variables with boxes and linear constraints."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import cached_property
from itertools import pairwise
from math import inf
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from fairaudit.columns import Label, label_text
from fairaudit.exact import InputError, nearest, option_value, rational, shown
from fairaudit.law import Law
from fairaudit.utility import Utility

__all__ = ["Ball", "Family", "LinearRow", "Setting", "UtilityClass", "lay_out"]

Extended = Fraction | float
Quantity = Literal["local", "global"]
Terms = dict[int, Fraction]
ZERO, ONE = Fraction(0), Fraction(1)
Term = tuple[Label | None, Label | None, str, Fraction]


@dataclass(frozen=True)
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

    terms: Any
    bound: Any

    def __post_init__(self) -> None:
        """Read labels and numbers."""
        items = self.terms.items() if isinstance(self.terms, Mapping) else [((u, x, a), c) for x, a, u, c in self.terms]
        terms: list[Term] = []
        for key, value in items:
            parts = key if isinstance(key, tuple) else (key,)
            if not 1 <= len(parts) <= 3:
                raise InputError(f"{shown(key)} does not name a value of the utility; give the decision, the context and the group")
            decision, context, group = (*parts, None, None)[:3]
            terms.append((_label(context), _label(group), str(label_text(decision)), _number("a coefficient", value)))
        object.__setattr__(self, "terms", tuple(terms))
        object.__setattr__(self, "bound", _number("the bound of a row", self.bound))


@dataclass(frozen=True)
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

    features: Mapping[str, Any]
    lower: Any = 0
    upper: Any = 1
    rows: Any = ()

    def __post_init__(self) -> None:
        """Read the numbers."""
        if not self.features:
            raise InputError("the family has no features; name at least one")
        ends = []
        for end in (self.lower, self.upper):
            listed = []
            for name in self.features:
                if isinstance(end, Mapping) and name not in end:
                    raise InputError(f"the family has no bound for {shown(name)}; bounds of every parameter must be given")
                value = end[name] if isinstance(end, Mapping) else end
                listed.append(_number(f"the bound of {shown(name)} in the family", value))
            ends.append(tuple(listed))
        for name, low, high in zip(self.features, *ends, strict=True):
            if low > high:
                raise InputError(f"the family bounds {shown(name)} by {low} from below and {high} from above; no utility is in the class")
        rows = []
        for coefficients, bound in self.rows:
            for name in coefficients:
                if name not in self.features:
                    raise InputError(f"a row of the family names {shown(name)}; {nearest(str(name), self.features)}")
            listed = [_number("a coefficient of the family", coefficients.get(name, 0)) for name in self.features]
            rows.append((tuple(listed), _number("the bound of a row of the family", bound)))
        object.__setattr__(self, "lower", ends[0])
        object.__setattr__(self, "upper", ends[1])
        object.__setattr__(self, "rows", tuple(rows))

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the parameters, in order."""
        return tuple(self.features)


@dataclass(frozen=True)
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

    reference: Any
    radius: Any
    divergence: Literal["chi2", "kl"] = "chi2"

    def __post_init__(self) -> None:
        """Read the numbers."""
        if self.divergence not in ("chi2", "kl"):
            raise InputError(f"divergence={shown(self.divergence)} is not accepted; use 'chi2' or 'kl'")
        radius = _number("the radius", self.radius)
        if radius < 0:
            raise InputError(f"the radius {radius} is negative; at least 0 is accepted")
        object.__setattr__(self, "radius", radius)
        object.__setattr__(self, "reference", self.reference if isinstance(self.reference, Utility) else Utility(self.reference))


@dataclass(frozen=True)
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

    gamma: Any = 1
    m: Any = 0
    tau: Any = None
    tau_on: Literal["all", "pair"] = "all"
    blind: bool = True
    lipschitz: Any = None
    metric: Any = None
    order: Any = ()
    rows: Any = ()
    family: Family | None = None
    ball: Ball | None = None

    def __post_init__(self) -> None:
        """Read the numbers, and refuse a class that is empty or not bounded on the face of it."""
        gamma, m = _number("gamma", self.gamma), _number("m", self.m)
        tau = None if self.tau is None else _number("tau", self.tau)
        if gamma <= 0 or not 0 <= m <= gamma:
            raise InputError(f"the range from {m} to {gamma} holds no utilities; it needs 0 <= m <= gamma and gamma > 0")
        if tau is not None and not 0 <= tau <= gamma:
            raise InputError(f"the floor {tau} lies outside [0, {gamma}]; no utility of at most gamma has a mean above gamma")
        if self.tau_on not in ("all", "pair"):
            raise InputError(f"tau_on={shown(self.tau_on)} is not accepted; use 'all' or 'pair'")
        lipschitz = None if self.lipschitz is None else _number("lipschitz", self.lipschitz)
        if lipschitz is not None and self.blind:
            raise InputError("a Lipschitz constant goes with a class that is not blind to the group; set blind=False")
        if lipschitz is not None and lipschitz < 0:
            raise InputError(f"the Lipschitz constant {lipschitz} is negative; at least 0 is accepted")
        rows = tuple(row if isinstance(row, LinearRow) else LinearRow(*row) for row in self.rows)
        named: dict[str, Any] = {"gamma": gamma, "m": m, "tau": tau, "lipschitz": lipschitz, "order": _pairs(self.order), "rows": rows}
        for name, value in named.items():
            object.__setattr__(self, name, value)

    @staticmethod
    def from_cvxpy(law: Law, variable: Any, constraints: Sequence[Any], **options: Any) -> UtilityClass:
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
        return UtilityClass(**{**options, "rows": (*options.get("rows", ()), *rows)})

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


def _number(name: str, value: Any, read: Callable[[object], tuple[int, int]] = option_value) -> Fraction:
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


# The class on a law: variables, constraints and their numbers, as docs/certificate-worst-case.md lists them


@dataclass(frozen=True, eq=False)
class Setting:
    """A class laid out over a law."""

    law: Law
    of: UtilityClass
    quantity: Quantity
    contexts: list[int]
    """Contexts that have a cell."""
    cells: list[list[int]]
    """The cells of each of them."""
    members: list[list[int]]
    """What is compared: the cells of each context with two or more, or the global groups."""
    places: list[int | None]
    """For each block of members the position of its context."""
    order: list[tuple[int, int]]
    metric: list[list[Fraction]] | None
    rows: list[tuple[Terms, Fraction]]
    """Rows over the variables g."""
    features: list[list[list[Fraction]]] | None
    """By cell, decision and parameter."""

    @property
    def n(self) -> int:
        """Number of decisions."""
        return len(self.law.decisions)

    @cached_property
    def chain(self) -> list[int] | None:
        """The decisions in increasing order, if the order is one chain of all of them and the class is blind."""
        order = self.order
        if not self.of.blind or not order or any(one[1] != other[0] for one, other in pairwise(order)):
            return None
        listed = [order[0][0], *(high for _, high in order)]
        return listed if len(listed) == len(set(listed)) == self.n else None

    @cached_property
    def place_of(self) -> list[int]:
        """Position of the context of each cell."""
        where = {x: position for position, x in enumerate(self.contexts)}
        return [where[x] for x in self.law.cell_context.tolist()]

    @cached_property
    def group_of(self) -> list[int]:
        """Group of each cell."""
        return [int(a) for a in self.law.cell_group.tolist()]

    def variable(self, cell: int, u: int) -> int:
        """Variable g(u,x,a) of a cell."""
        return (self.place_of[cell] if self.of.blind else cell) * self.n + u

    def slots(self, place: int) -> list[int]:
        """One cell for each utility row in a context: its first cell when the class is blind."""
        return self.cells[place][:1] if self.of.blind else self.cells[place]

    @cached_property
    def probabilities(self) -> dict[int, list[Fraction]]:
        """P(·|x,a) of the cells that were asked for, kept."""
        return {}

    def row(self, cell: int) -> list[Fraction]:
        """P(·|x,a), exact."""
        if cell not in self.probabilities:
            row = self.law.row(cell)
            total = sum(row)
            self.probabilities[cell] = [Fraction(v, total) for v in row]
        return self.probabilities[cell]

    @cached_property
    def shares(self) -> dict[int, dict[int, Fraction]]:
        """P(x|a) of the global groups, by group and cell."""
        found: dict[int, dict[int, Fraction]] = {a: {} for a in self.law.global_groups}
        for cell, (a, mass) in enumerate(zip(self.group_of, self.law.cell_mass, strict=True)):
            if a in found and mass:
                found[a][cell] = Fraction(mass)
        for weights in found.values():
            total = sum(weights.values())
            for cell in weights:
                weights[cell] /= total
        return found

    def mean(self, member: int) -> Terms:
        """E(x,a) of a cell or Ē(a) of a group, as coefficients of g."""
        shares = {member: ONE} if self.quantity == "local" else self.shares[member]
        terms: Terms = {}
        for cell, share in shares.items():
            for u, p in enumerate(self.row(cell)):
                if p:
                    v = self.variable(cell, u)
                    terms[v] = terms.get(v, ZERO) + share * p
        return terms

    @cached_property
    def means(self) -> dict[int, Terms]:
        """Group means in the variables that were asked for, kept."""
        return {}

    def vector(self, member: int) -> Terms:
        """The mean of a member in the variables: g, or θ with a family."""
        if member not in self.means:
            self.means[member] = self.in_variables(self.mean(member))
        return self.means[member]

    def in_variables(self, terms: Terms) -> Terms:
        """Coefficients of g as coefficients of the variables."""
        if self.features is None:
            return terms
        result: Terms = {}
        for v, coefficient in terms.items():
            row, u = divmod(v, self.n)
            cell = self.cells[row][0] if self.of.blind else row
            for k, feature in enumerate(self.features[cell][u]):
                if feature:
                    result[k] = result.get(k, ZERO) + coefficient * feature
        return {k: value for k, value in result.items() if value}

    def concerned(self, block: int) -> list[int]:
        """Positions of the contexts whose constraints concern a block."""
        place = self.places[block]
        return list(range(len(self.contexts))) if place is None or self.of.couples else [place]

    def floors(self, block: int, pair: tuple[int, int]) -> list[int]:
        """Members that keep the floor, in the order of their constraints."""
        if self.of.tau is None:
            return []
        return list(pair) if self.of.tau_on == "pair" else self.members[block]

    @cached_property
    def tables(self) -> dict[tuple[int, ...], _Numbering]:
        """Numberings of variables that were asked for, kept."""
        return {}

    def numbering(self, block: int) -> _Numbering:
        """Where each kind of constraint begins, without the floors."""
        key = tuple(self.concerned(block))
        if key not in self.tables:
            at, orders, distances = 0, {}, {}
            for place in key:
                for cell in self.slots(place):
                    orders[cell] = at
                    at += len(self.order)
            for place in key:
                distances[place] = at
                if self.of.lipschitz is not None:
                    size = len(self.cells[place])
                    at += size * (size - 1) * self.n
            rows = at
            at += len(self.rows)
            ranges: dict[int, int] = {}
            if self.of.family is not None:
                for place in range(len(self.contexts)):
                    for cell in self.slots(place):
                        ranges[cell] = at
                        at += 2 * self.n
            family = at
            at += len(self.of.family.rows) if self.of.family is not None else 0
            self.tables[key] = _Numbering(orders, distances, rows, ranges, family, at)
        return self.tables[key]

    def order_numbers(self, block: int, cell: int) -> range:
        """Constraints of the order in one row of the utility, without the floors."""
        start = self.numbering(block).orders[cell]
        return range(start, start + len(self.order))

    def distance_numbers(self, block: int, first: int, second: int) -> range:
        """Constraints g(first) − g(second) ≤ L·d between two cells of a context, without the floors."""
        place = self.place_of[first]
        cells = self.cells[place]
        i, j = cells.index(first), cells.index(second)
        start = self.numbering(block).distances[place] + (i * (len(cells) - 1) + j - (j > i)) * self.n
        return range(start, start + self.n)

    def reach(self, first: int, second: int) -> Fraction:
        """L·d of the groups of two cells."""
        a, b = self.group_of[first], self.group_of[second]
        distance = (ONE if a != b else ZERO) if self.metric is None else self.metric[a][b]
        constant: Fraction = self.of.lipschitz * distance
        return constant

    def all_constraints(self, block: int) -> list[tuple[Terms, Fraction]]:
        """Every constraint but the floors and the box, in order."""
        listed: list[tuple[Terms, Fraction]] = []
        for place in self.concerned(block):
            for cell in self.slots(place):
                listed += [self._order_row(cell, low, high) for low, high in self.order]
        if self.of.lipschitz is not None:
            for place in self.concerned(block):
                for first in self.cells[place]:
                    for second in self.cells[place]:
                        if first != second:
                            listed += [self._distance_row(first, second, u) for u in range(self.n)]
        listed += [(self.in_variables(terms), bound) for terms, bound in self.rows]
        if self.of.family is not None:
            for place in range(len(self.contexts)):
                for cell in self.slots(place):
                    for u in range(self.n):
                        v = self.variable(cell, u)
                        listed.append((self.in_variables({v: -ONE}), -self.of.m))
                        listed.append((self.in_variables({v: ONE}), self.of.gamma))
            for coefficients, bound in self.of.family.rows:
                listed.append(({k: c for k, c in enumerate(coefficients) if c}, bound))
        return listed

    @cached_property
    def listed(self) -> dict[tuple[int, ...], list[tuple[Terms, Fraction]]]:
        """Constraints that were asked for, kept."""
        return {}

    def constraint(self, block: int, pair: tuple[int, int], number: int) -> tuple[Terms, Fraction]:
        """A constraint by its number."""
        floors = self.floors(block, pair)
        if number < len(floors):
            return {v: -c for v, c in self.vector(floors[number]).items()}, -self.of.tau
        number -= len(floors)
        numbering = self.numbering(block)
        for cell, start in numbering.orders.items():
            if self.order and start <= number < start + len(self.order):
                return self._order_row(cell, *self.order[number - start])
        for place, start in numbering.distances.items():
            size = len(self.cells[place])
            if self.of.lipschitz is not None and start <= number < start + size * (size - 1) * self.n:
                index, u = divmod(number - start, self.n)
                i, j = divmod(index, size - 1)
                cells = self.cells[place]
                return self._distance_row(cells[i], cells[j + (j >= i)], u)
        key = tuple(self.concerned(block))
        if key not in self.listed:
            self.listed[key] = self.all_constraints(block)
        return self.listed[key][number]

    def _order_row(self, cell: int, low: int, high: int) -> tuple[Terms, Fraction]:
        if low == high:
            return {}, ZERO
        return self.in_variables({self.variable(cell, low): ONE, self.variable(cell, high): -ONE}), ZERO

    def _distance_row(self, first: int, second: int, u: int) -> tuple[Terms, Fraction]:
        return self.in_variables({self.variable(first, u): ONE, self.variable(second, u): -ONE}), self.reach(first, second)

    def box(self, variable: int) -> tuple[Fraction, Fraction]:
        """Ends between which a variable lies."""
        if self.of.family is not None:
            return self.of.family.lower[variable], self.of.family.upper[variable]
        return self.of.m, self.of.gamma

    @property
    def size(self) -> int:
        """Number of variables."""
        if self.of.family is not None:
            return len(self.of.family.names)
        return (len(self.contexts) if self.of.blind else len(self.law.weights)) * self.n

    def proves(self, block: int, pair: tuple[int, int], multipliers: Mapping[int, Fraction], ratio: Fraction) -> bool:
        """Whether multipliers prove that no utility of the class has a greater ratio of the pair: F(ratio) ≤ 0."""
        return self.excess(block, pair, multipliers, ratio) <= 0

    def excess(self, block: int, pair: tuple[int, int], multipliers: Mapping[int, Fraction], ratio: Fraction) -> Fraction:
        """F(ratio)."""
        c = dict(self.vector(pair[0]))
        for v, q in self.vector(pair[1]).items():
            c[v] = c.get(v, ZERO) - ratio * q
        total = ZERO
        for number, y in multipliers.items():
            terms, bound = self.constraint(block, pair, number)
            total += y * bound
            for v, a in terms.items():
                c[v] = c.get(v, ZERO) - y * a
        for v, value in c.items():
            low, high = self.box(v)
            total += value * (high if value > 0 else low)
        return total


@dataclass(frozen=True)
class _Numbering:
    """Where constraints begin, the floors not counted: by cell, by context, and of the rows at the end."""

    orders: dict[int, int]
    distances: dict[int, int]
    rows: int
    ranges: dict[int, int]
    family: int
    end: int


def lay_out(law: Law, of: UtilityClass, quantity: Quantity) -> Setting:
    """Lay a class out over a law; refuses one that does not fit it."""
    if quantity not in ("local", "global"):
        raise InputError(f"quantity={shown(quantity)} is not accepted; use 'local' or 'global'")
    by_context: dict[int, list[int]] = {}
    for cell, x in enumerate(law.cell_context.tolist()):
        by_context.setdefault(x, []).append(cell)
    contexts, cells = list(by_context), list(by_context.values())
    places: list[int | None]
    if quantity == "local":
        places = [i for i, listed in enumerate(cells) if len(listed) > 1]
        members = [cells[i] for i in places if i is not None]
        if not members:
            raise InputError("no context has two groups, so nobody is compared within a context")
    else:
        places, members = [None], [list(law.global_groups)]
        if not law.global_groups:
            raise InputError(
                "the global ratio is undefined: fewer than two groups have a population, or one is missing in a context and no population "
                "was given"
            )
    index = {label: u for u, label in enumerate(law.decisions)}
    order = []
    for pair in of.order:
        for label in pair:
            if label not in index:
                raise InputError(f"the order names the decision {shown(label)}, which does not occur; {nearest(label, law.decisions)}")
        order.append((index[pair[0]], index[pair[1]]))
    setting = Setting(law, of, quantity, contexts, cells, members, places, order, _metric(law, of), [], _features(law, of))
    setting.rows.extend(_resolved(setting, row) for row in of.rows)
    return setting


def _metric(law: Law, of: UtilityClass) -> list[list[Fraction]] | None:
    """Distances between groups; an error unless they form a metric."""
    if of.metric is None:
        return None
    if of.lipschitz is None:
        raise InputError("a metric goes with a Lipschitz constant; give lipschitz too")
    size = len(law.groups)
    if callable(of.metric):
        raw = [[of.metric(a, b) for b in law.groups] for a in law.groups]
    else:
        raw = [list(row) for row in of.metric]
        if len(raw) != size or any(len(row) != size for row in raw):
            raise InputError(f"the metric is not a square table over the {size} groups of the law")
    read = rational if isinstance(of.metric, np.ndarray) else option_value
    d = [[_number("the metric", value, read) for value in row] for row in raw]
    name = law.group_label
    for i in range(size):
        for j in range(size):
            if (d[i][j] <= 0) != (i == j) or d[i][j] < 0:
                raise InputError(
                    f"the metric gives the distance {d[i][j]} from {name(i)} to {name(j)}; it is zero from a group to itself, else positive"
                )
            if d[i][j] != d[j][i]:
                raise InputError(f"the metric is not symmetric: {d[i][j]} from {name(i)} to {name(j)}, but {d[j][i]} back")
    for i in range(size):
        for j in range(size):
            for k in range(size):
                if d[i][k] > d[i][j] + d[j][k]:
                    raise InputError(
                        f"the metric breaks the triangle inequality: {name(i)} to {name(k)} is {d[i][k]}, but through {name(j)} it is "
                        f"{d[i][j]} + {d[j][k]}"
                    )
    return d


def _features(law: Law, of: UtilityClass) -> list[list[list[Fraction]]] | None:
    if of.family is None:
        return None
    features = []
    first: dict[int, list[list[Fraction]]] = {}
    for named in of.family.features.values():
        if isinstance(named, Mapping):
            for label in named:
                if label_text(label) not in law.decisions:
                    raise InputError(
                        f"the family names the decision {shown(label)}, which does not occur; {nearest(str(label), law.decisions)}"
                    )
    for x, a in zip(law.cell_context.tolist(), law.cell_group.tolist(), strict=True):
        rows = [[_feature(name, phi, u, law.contexts[x], law.groups[a]) for name, phi in of.family.features.items()] for u in law.decisions]
        if of.blind and first.setdefault(x, rows) != rows:
            raise InputError(f"the features differ between groups at {law.context_label(x)}, but the class is blind; set blind=False")
        features.append(rows)
    return features


def _feature(name: str, phi: Any, u: str, x: Label, a: Label) -> Fraction:
    value = phi.get(u, 0) if isinstance(phi, Mapping) else phi(u, x, a)
    return _number(f"the feature {shown(name)} of decision {shown(u)}", value)


def _resolved(setting: Setting, row: LinearRow) -> tuple[Terms, Fraction]:
    """Read the labels of a row as variables."""
    law = setting.law
    terms: Terms = {}
    for context, group, decision, coefficient in row.terms:
        if decision not in law.decisions:
            raise InputError(f"a row names the decision {shown(decision)}, which does not occur; {nearest(decision, law.decisions)}")
        if context is None and len(setting.contexts) > 1:
            raise InputError(f"a row names the decision {shown(decision)} without a context, but there are {len(setting.contexts)}")
        if context is not None and context not in law.contexts:
            raise InputError(f"a row names the context {shown(context)}, which does not occur")
        x = setting.contexts[0] if context is None else law.contexts.index(context)
        if x not in setting.contexts:
            raise InputError(f"a row names the context {shown(context)}, in which no decisions are recorded")
        cells = setting.cells[setting.contexts.index(x)]
        if setting.of.blind == (group is not None):
            raise InputError(
                f"a row names the group {shown(group)}, but the class is blind"
                if setting.of.blind
                else "a row names no group, but the class is not blind to groups"
            )
        found = cells[:1] if group is None else [cell for cell in cells if law.groups[setting.group_of[cell]] == group]
        if not found:
            raise InputError(f"a row names the group {shown(group)}, which has no decisions at {law.context_label(x)}")
        v = setting.variable(found[0], law.decisions.index(decision))
        terms[v] = terms.get(v, ZERO) + coefficient
    return {v: c for v, c in terms.items() if c}, row.bound
