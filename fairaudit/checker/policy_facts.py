"""What the rules about a policy behind filters need of it, each computed when a claim needs it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import cached_property
from operator import mul

from .claims import FLOORED, LAW
from .declared import DeclaredIn
from .filters import map_of, map_through, mixed_laws
from .json_values import Labels
from .laws import expectation
from .likelihoods import Likelihoods
from .policy_evidence import Attained
from .rationals import ZERO, Rational, as_pair, extreme_positions, maximum, over_common_denominator, widest_ratio
from .sides import Range, Sides, Worth, global_worth, local_worth, sides_of
from .table import Policy, Table, constants
from .text import shown
from .work import spend


@dataclass(frozen=True)
class PolicyFacts:
    """What the theorems need of a policy and its filters, each computed when a claim needs it."""

    table: Table  # of the law that they induce
    policy: Policy
    declared: Mapping[str, Rational]
    by_context: Sequence[DeclaredIn] = ()

    @cached_property
    def constants(self) -> dict[str, Fraction]:
        """The effective constants of g, those that are declared first; tau is that of the table."""
        own = constants(self.table)
        finite = {key: Fraction(*value) for key, value in own.items() if isinstance(value, tuple)}
        return finite | {key: Fraction(*value) for key, value in self.declared.items() if key in ("gamma", "m", "lipschitz")}

    def _utilities(self) -> list[Sequence[Rational | None]]:
        """For each true context its g(u,x), which must not depend on the group."""
        return [cells[0].utility for cells in self.table.by_context()]

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

    @cached_property
    def _declared_in(self) -> dict[Labels, dict[str, Fraction]]:
        """What was declared of single contexts."""
        return {entry.context: {key: Fraction(*value) for key, value in entry.values.items()} for entry in self.by_context}

    @cached_property
    def floors(self) -> list[Fraction]:
        """The declared floor of each true context, 0 where there is none."""
        of_all = self.declared_number("tau")
        return [max(of_all, self._declared_in.get(label, {}).get("tau", of_all)) for label in self.table.header.contexts]

    @cached_property
    def mean_floors(self) -> dict[int, Fraction]:
        """What the declared floors leave for the mean of each group of positive mass."""
        masses, _ = over_common_denominator([cell.mass for cell in self.table.cells])
        floors, unit = over_common_denominator([as_pair(floor) for floor in self.floors])
        spend(len(masses), max(masses).bit_length(), max(floors).bit_length())
        groups, of_all = len(self.table.header.groups), self.declared_number("global_tau")
        found: dict[int, Fraction] = {}
        for a in self.table.figures.populated():
            own = masses[a::groups]
            found[a] = max(of_all, Fraction(sum(map(mul, own, floors)), sum(own) * unit))
        return found

    @cached_property
    def range(self) -> Range:
        """The declared range of the utility; gamma and m must be declared."""
        return self._range({})

    @cached_property
    def ranges(self) -> list[Range]:
        """The declared range of the utility in each true context."""
        return [self._range(self._declared_in.get(label, {})) for label in self.table.header.contexts]

    def _range(self, own: Mapping[str, Fraction]) -> Range:
        gamma, m = (own.get(key, self.declared_number(key)) for key in ("gamma", "m"))
        return Range(gamma, m, min(self.constants["lipschitz"], gamma - m))

    def declared_number(self, key: str) -> Fraction:
        """A declared constant, 0 where there is none."""
        return Fraction(*self.declared.get(key, ZERO))

    @cached_property
    def likelihoods(self) -> Likelihoods:
        """The laws of the likelihood ratios of all pairs of groups, for as many releases as one memory sees."""
        return Likelihoods(self.policy.group, self.policy.releases)

    @cached_property
    def _worth(self) -> dict[bool, Worth]:
        return {}

    def worth(self, local: bool) -> Worth:
        """What decisions are worth to the groups, for the local or for the global ratio."""
        if local not in self._worth:
            self._worth[local] = local_worth(self.table) if local else global_worth(self.table, self.policy)
        return self._worth[local]

    @cached_property
    def _sides(self) -> dict[bool, Sides]:
        return {}

    def sides(self, local: bool) -> Sides:
        """The same with like contexts put together, where there is nothing else that tells them apart."""
        if local not in self._sides:
            self._sides[local] = sides_of(self.worth(local), local)
        return self._sides[local]

    @cached_property
    def shown(self) -> tuple[list[list[tuple[int, int]]], int]:
        """For each true context the released contexts of positive probability, with these probabilities over one denominator."""
        if self.policy.context is None:
            return [[(x, 1)] for x in range(len(self.table.header.contexts))], 1
        rows, total = self.policy.context.matrix()
        return [[(i, weight) for i, weight in enumerate(row) if weight] for row in rows], total

    @cached_property
    def released(self) -> tuple[list[list[int]], int]:
        """The probabilities of the released groups under each true group, over one denominator."""
        return self.policy.group.matrix()

    @cached_property
    def _numbers(self) -> tuple[dict[Labels, int], dict[Labels, int]]:
        """The numbers of the true contexts and of the true groups."""
        header = self.table.header
        return {label: i for i, label in enumerate(header.contexts)}, {label: i for i, label in enumerate(header.groups)}

    def place(self, attained: Attained, local: bool) -> tuple[int | None, int, int] | str:
        """Find the context and the groups that are named, or say why they are not those of an ordered pair that is compared."""
        contexts, groups = self._numbers
        if (attained.context is None) == local:
            return "the context must be named of a local ratio, and of no other"
        if attained.higher == attained.lower:
            return "a group is not compared with itself"
        if attained.context is not None and attained.context not in contexts:
            return f"{shown(list(attained.context))} is no true context"
        for label in (attained.higher, attained.lower):
            if groups.get(label) not in self.worth(local).scales:
                return f"{shown(list(label))} is no group that is compared"
        context = None if attained.context is None else contexts[attained.context]
        return context, groups[attained.higher], groups[attained.lower]

    def named(self, context: int | None, higher: int, lower: int) -> str:
        """Name an ordered pair of groups, and the context in which it is compared."""
        header = self.table.header
        place = "" if context is None else f" in context {shown(list(header.contexts[context]))}"
        return f"for the groups {shown(list(header.groups[higher]))} and {shown(list(header.groups[lower]))}{place}"
