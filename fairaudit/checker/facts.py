"""What claims are judged by, computed when a claim needs it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import cached_property

from .claims import FLOORED, LAW
from .figures import Maximum
from .filters import map_of, map_through, mixed_laws
from .intervals import Proven
from .laws import expectation
from .program import Program
from .rationals import INFINITY, Rational, extreme_positions, maximum, over_common_denominator, widest_ratio
from .table import Policy, Table, constants


@dataclass(frozen=True)
class Facts:
    """What claims are judged by; what is costly, and needed by few claims, is computed when a claim needs it."""

    table: Table
    metrics: Mapping[str, Maximum | None]
    declared: Mapping[str, Rational]
    program: Program | None
    proven: Mapping[str, Proven]  # the intervals that hold

    @cached_property
    def constants(self) -> dict[str, Fraction]:
        """The effective constants of g, those that are declared first; tau is that of the table."""
        own = constants(self.table)
        finite = {key: Fraction(*value) for key, value in own.items() if isinstance(value, tuple)}
        return finite | {key: Fraction(*value) for key, value in self.declared.items() if key != "tau"}

    @property
    def policy(self) -> Policy:
        """The policy and its filters; the rules that need them are not applied to other subjects."""
        if self.table.policy is None:
            raise AssertionError
        return self.table.policy

    def _utilities(self) -> list[Sequence[Rational | None]]:
        """For each true context its g(u,x), which must not depend on the group."""
        return [cells[0].utility for cells in self.table.by_context()]

    def holds(self, condition: str) -> bool:
        """Decide one of the CONDITIONS."""
        if condition == "independent":
            return self.table.figures.independent()
        if condition == "a-free":  # the constant of the table is no greater
            return self.constants["lipschitz"] == 0
        if condition == "g(u)":
            return self.table.header.utility is not None
        if condition == "finite":
            return self.policy.group.exp_epsilon != INFINITY
        return self.policy.context is not None

    def floor(self, scope: str) -> Fraction | None:
        """The tau of a claim: what all expectations are at least, in the scope of the claim."""
        if scope == LAW:
            return self.constants.get("tau")
        if scope == FLOORED:
            return Fraction(*self.declared["tau"]) if "tau" in self.declared else None
        return Fraction(*self._policy_floor)

    @cached_property
    def _policy_floor(self) -> Rational:
        """The least expectation over what each true context can release and all reachable groups, for g(u,x)."""
        contexts = range(len(self.table.header.contexts))
        releases = self.policy.context.releases() if self.policy.context else [[x] for x in contexts]
        seen: dict[Sequence[Rational | None], set[int]] = {}
        for utility, released in zip(self._utilities(), releases, strict=True):
            seen.setdefault(utility, set()).update(released)
        values = [expectation(law, g) for g, released in seen.items() for x in released for law in self.policy.rows[x]]
        return values[extreme_positions(values)[1]]

    @cached_property
    def raw_ratio(self) -> Rational:
        """The greatest ratio of two expectations of one true context over the reachable groups, for g(u,x)."""
        pairs = zip(self._utilities(), self.policy.by_context, strict=True)
        ratios = [widest_ratio([expectation(law, utility) for law in laws])[0] for utility, laws in pairs]
        return maximum(ratios)

    @cached_property
    def context_ratio(self) -> Rational:
        """The local ratio of the law over reachable contexts and true groups, for g(u)."""
        utility = self.table.header.utility or ()
        laws = (mixed_laws(row, self.policy.group.maps) for row in self.policy.rows)
        ratios = [widest_ratio([expectation(law, utility) for law in row])[0] for row in laws]
        return maximum(ratios)

    @cached_property
    def composition(self) -> Rational:
        """The greatest P(x|a)/P(x|a') over released contexts x and pairs of groups of positive mass."""
        masses, _ = over_common_denominator([cell.mass for cell in self.table.cells])
        factors = self.policy.context.factors if self.policy.context else ()
        released = map_through(masses, [map_of([*zip(*factor.matrix, strict=True)], factor.total) for factor in factors])
        n = len(self.table.header.groups)
        rows = [released[i : i + n] for i in range(0, len(released), n)]
        totals = [sum(column) for column in zip(*rows, strict=True)]
        ratios = [widest_ratio([(p, total) for p, total in zip(row, totals, strict=True) if total])[0] for row in rows]
        return maximum(ratios)


CONDITIONS = {
    "independent": "context and group are not independent in the table",
    "a-free": "the utility depends on the group, by the table or as declared",
    "g(u)": "the utility does not depend on the decision alone",
    "finite": "epsilon is infinite",
    "context filter": "there is no context filter",
}
