"""What the registry says of a kind of claim."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from fractions import Fraction
from importlib import import_module
from typing import TYPE_CHECKING, Any, Literal

from fairaudit.exact.extended import extended_text
from fairaudit.measures.limits import Quantity
from fairaudit.theorems.assumptions import SENTENCES
from fairaudit.theorems.bound import ANY_POLICY, FLOORED, Bound

if TYPE_CHECKING:
    from fairaudit.theorems.case import Case
    from fairaudit.theorems.supremum import Supremum

__all__ = ["Kind", "Relation", "later"]

Relation = Literal["=", "<=", ">="]


def later(name: str) -> Callable[..., Any]:
    """A function of this folder by its module and its name, which is loaded when it is called: most audits ask no theorem."""

    def call(*given: Any) -> Any:
        module, _, own = name.partition(".")
        return getattr(import_module(f"fairaudit.theorems.{module}"), own)(*given)

    return call


@dataclass(frozen=True)
class Kind:
    """A kind of claim.

    Attributes
    ----------
    id : str
        Its name, here and in docs/claims.md.
    by : str
        What its claims name as their source: a theorem, a method, or how the figure is found. Several kinds can share it.
    says : str
        The statement in words. The entry of proofs/index.toml for `by` is that of all its kinds, one after the other.
    how : str
        The same in a few words, as reports put it beside a figure.
    quantities, relations, scopes : tuple of str
        What a claim of the kind can be about; the checker knows each combination.
    subject : {"any", "table", "policy", "class", "sample", "labels"}
        What a certificate has to be about: anything, a table, a policy behind filters, a class of utilities, draws, decisions with true
        labels.
    evidence : str
        The one key of the evidence, or "" where there is none.
    beside : tuple of str
        Further keys of the evidence.
    code : tuple of str
        The functions that find the value.
    anchor : str
        Where in docs/ it is stated and proved.
    coq : tuple of str
        The statements in proofs/ that say it.
    reason : str
        What there is instead, where nothing is machine-checked.
    needs : tuple of str
        What has to hold, of `case.NEEDS`; the checker decides the same by itself. `asks` has what a scope adds.
    declares : tuple of str
        Constants that have to be declared, besides what the scope says, for a claim about any policy to hold of one that was sampled.
    assumes : tuple of str
        Sentences of `SENTENCES` that each claim lists, besides those that its subject and its scope ask for.
    overall : tuple of str
        Sentences that each claim about a global quantity lists besides.
    may_assume : tuple of str
        Sentences that some claims of the kind list besides, as their interval asks for, or what was declared.
    applies : callable or None
        Of a theorem about a policy behind filters: what it guarantees in a case that has what it needs.
    reaches : callable or None
        Of one of the scopes of T13: the greatest ratio in a case, or what bounds it; None where there is nothing to say.
    """

    id: str
    by: str
    says: str
    how: str
    quantities: tuple[str, ...]
    relations: tuple[Relation, ...]
    scopes: tuple[str, ...]
    subject: Literal["any", "table", "policy", "class", "sample", "labels"]
    evidence: str
    code: tuple[str, ...]
    anchor: str
    beside: tuple[str, ...] = ()
    coq: tuple[str, ...] = ()
    reason: str = ""
    needs: tuple[str, ...] = ()
    declares: tuple[str, ...] = ()
    assumes: tuple[str, ...] = ()
    overall: tuple[str, ...] = ()
    may_assume: tuple[str, ...] = ()
    applies: Callable[[Case], Bound | None] | None = None
    reaches: Callable[[Case, Quantity], Supremum | Bound | None] | None = None

    @property
    def floored(self) -> bool:
        """Whether the theorem rests on one floor, that of the table or the one that was declared."""
        return self.applies is not None and FLOORED in self.scopes

    def asks(self, scope: str) -> tuple[str, ...]:
        """What has to hold for a claim of a scope: theorems other than T13 know nothing of policies that see several releases."""
        return (*self.needs, *(("one release",) if self.applies is not None and scope in (ANY_POLICY, FLOORED) else ()))

    def listed(self, scope: str, quantity: str) -> tuple[str, ...]:
        """The names of the sentences that every claim of the kind lists in a scope."""
        return (
            *(("fresh",) if self.subject == "policy" else ()),
            *self.assumes,
            *(self.overall if quantity.startswith("global") else ()),
            *(("declared-floor",) if self.floored and scope == FLOORED else ()),
        )

    def sentences(self, scope: str, quantity: str, constants: Mapping[str, Fraction]) -> tuple[str, ...]:
        """The sentences that every claim of the kind lists in a scope, with the numbers that they speak of."""
        numbers = {name: extended_text(value) for name, value in constants.items()}
        return tuple(SENTENCES[name].format_map(numbers) for name in self.listed(scope, quantity))
