"""Policies T(u|x̃,ã), the black boxes that are audited, and the law that one induces behind privacy filters."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from math import lcm
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from fairaudit.arguments import answered, answered_class
from fairaudit.errors import InputError, nearest, shown
from fairaudit.exact.dense import Numbers
from fairaudit.exact.rationals import Number, common_denominator, option_value, rational
from fairaudit.model.law import Law
from fairaudit.model.mechanism import Factor, Mechanism
from fairaudit.model.releases import check_releases
from fairaudit.tables.columns import Missing
from fairaudit.tables.label_text import label_text
from fairaudit.tables.sources import Table
from fairaudit.tables.values import INT64, Label, LabelLike, LabelsLike, names
from fairaudit.words import brief, noun

__all__ = ["Deployment", "Policy", "PolicySource", "policy_source", "sample_policy"]


ENTRY_POINT = "fairaudit.policies"

Population = (
    Law | Numbers | Mapping[tuple[str, str], Number] | Mapping[tuple[Label, Label], Number] | Mapping[tuple[LabelsLike, LabelsLike], Number]
)
"""P(x,a) up to a common factor: an array of contexts by groups, a mapping from pairs of labels, or the population of a law."""


class PolicySource(Protocol):
    """What a plug-in supplies under the entry point ``fairaudit.policies``: something that decides, cell by cell."""

    def cells(self) -> Iterable[tuple[LabelsLike, LabelsLike]]:
        """List the pairs (x̃, ã) that it knows."""
        ...

    def decide(self, context: LabelsLike, group: LabelsLike, trial: int) -> LabelLike:
        """Decide once for what it is shown; `trial` counts the repetitions of a cell."""
        ...


class PolicyTable(Protocol):
    """What a plug-in may supply instead: something that knows its whole table."""

    def table(self) -> Policy:
        """Give the policy."""
        ...


@answered_class()
@brief
@dataclass(frozen=True, eq=False, repr=False)
class Policy:
    """A black box as a table: the law of its decision for every context x̃ and group ã that it may be shown.

    Attributes
    ----------
    law : Law
        T(u|x̃,ã), with x̃ as contexts and ã as groups.

    Examples
    --------
    >>> policy = Policy.from_array([[0.9, 0.1], [0.4, 0.6]], decisions=["hire", "pass"], groups=["f", "m"])
    >>> from fairaudit.model.mechanism import RandomizedResponse
    >>> policy.behind(group=RandomizedResponse(["f", "m"], keep_probability="0.5")).law.weights[0].tolist() == (
    ...     policy.behind(group=RandomizedResponse(["f", "m"], keep_probability="0.5")).law.weights[1].tolist())
    True
    """

    law: Law

    def __post_init__(self) -> None:
        """Refuse decisions of unknown group: a policy says what each group is given."""
        if self.law.unknown is not None:
            raise InputError("unknown groups do not go with a policy or filters, which say what each group is given")

    @staticmethod
    @answered
    def from_probabilities(
        table: Table,
        *,
        decision: str,
        group: str | Sequence[str],
        probability: str,
        context: str | Sequence[str] | None = None,
        missing: Missing = "error",
    ) -> Policy:
        """Read T(u|x̃,ã) from a table with one row per combination. Parameters and errors as in `Law.from_probabilities`."""
        return Policy(
            Law.from_probabilities(table, decision=decision, group=group, probability=probability, context=context, missing=missing)
        )

    @staticmethod
    @answered
    def from_counts(
        table: Table,
        *,
        decision: str,
        group: str | Sequence[str],
        count: str,
        context: str | Sequence[str] | None = None,
        missing: Missing = "error",
    ) -> Policy:
        """Read how often each decision was drawn, as `sample_policy` counts it. Parameters and errors as in `Law.from_counts`."""
        return Policy(Law.from_counts(table, decision=decision, group=group, count=count, context=context, missing=missing))

    @staticmethod
    @answered
    def from_array(
        array: Numbers,
        *,
        decisions: Sequence[LabelLike] | None = None,
        groups: Sequence[LabelsLike] | None = None,
        contexts: Sequence[LabelsLike] | None = None,
    ) -> Policy:
        """Read T from an array indexed [context, group, decision]. Parameters and errors as in `Law.from_array`."""
        return Policy(Law.from_array(array, decisions=decisions, groups=groups, contexts=contexts))

    @staticmethod
    @answered
    def from_source(source: PolicySource | PolicyTable, trials: int = 50) -> Policy:
        """Ask a plug-in for its table, or sample its decisions.

        Parameters
        ----------
        source : PolicySource, or object with ``table() -> Policy``
            The plug-in.
        trials : int
            How often each cell is asked, when it has no table.

        Returns
        -------
        Policy
            The policy; from counts if it was sampled.
        """
        table: Callable[[], Policy] | None = getattr(source, "table", None)
        if table is not None:
            return table()
        asked: Any = source
        counts = sample_policy(asked, trials=trials)
        return Policy.from_counts(counts, decision="decision", group="group", context="context", count="count")

    @answered
    def behind(
        self, *, group: Mechanism, context: Mechanism | None = None, population: Population | None = None, releases: int = 1
    ) -> Deployment:
        """Put the policy behind filters.

        Parameters
        ----------
        group : Mechanism
            The filter of the sensitive attributes; its inputs are the true groups.
        context : Mechanism, optional
            The filter of the context; by default contexts are released as they are.
        population : array_like, mapping or Law, optional
            P(x,a) up to a common factor: an array [context, group] in the order of the filters' inputs, a mapping from
            (context, group) labels, or a law whose counts or masses are taken. Without one, contexts weigh equally.
        releases : int
            How many releases of the same true group, each drawn afresh, one memory may see, 1 to 10,000. The policy at hand is shown one;
            what holds for every policy holds for those that see all of them. A sticky release, drawn once and replayed, counts once.

        Returns
        -------
        Deployment
            The policy with its filters, and the law that they induce.

        Raises
        ------
        InputError
            If the filters' alphabets do not fit the policy's, a released pair has no law, or `releases` is not accepted.
        """
        return _deploy(self, group, context, population, check_releases(releases))


@brief
@dataclass(frozen=True, eq=False, repr=False)
class Deployment:
    """A policy behind filters.

    Attributes
    ----------
    policy : Policy
        The black box.
    group_filter : Mechanism
        M_A.
    context_filter : Mechanism or None
        M_X; None is the identity.
    mass : tuple of int or None
        P(x,a) up to a common factor, contexts first, or None.
    releases : int
        How many releases of the same true group, each drawn afresh, one memory may see.

    Examples
    --------
    >>> import fairaudit as fa
    >>> policy = fa.Policy.from_array([[["0.9", "0.1"], ["0.2", "0.8"]]], decisions=["hire", "pass"], groups=["f", "m"])
    >>> coin = fa.RandomizedResponse(["f", "m"], keep_probability="0.75")
    >>> policy.behind(group=coin).law.weights.tolist()
    [[29, 11], [15, 25]]
    """

    policy: Policy
    group_filter: Mechanism
    context_filter: Mechanism | None
    mass: tuple[int, ...] | None
    releases: int = 1

    @property
    def groups(self) -> tuple[Label, ...]:
        """True groups."""
        return self.group_filter.inputs

    @property
    def contexts(self) -> tuple[Label, ...]:
        """True contexts."""
        return self.policy.law.contexts if self.context_filter is None else self.context_filter.inputs

    @cached_property
    def law(self) -> Law:
        """The induced law P(u|x,a) = Σ M_X(x̃|x) M_A(ã|a) T(u|x̃,ã), exact."""
        return self._law(self.contexts, self.groups, self._induced(group=True, context=True))

    @cached_property
    def shown_law(self) -> Law:
        """The law over true contexts and *released* groups, Σ_x̃ M_X(x̃|x) T(u|x̃,ã): what the policy itself does to what it is shown."""
        groups = [b for b, r in zip(self.group_filter.outputs, self._reachable(self.group_filter), strict=True) if r]
        tensor = self._induced(group=False, context=True)[:, self._reachable(self.group_filter)]
        return self._law(self.contexts, tuple(groups), tensor, mass=False)

    @cached_property
    def filtered_contexts_law(self) -> Law | None:
        """The law over the contexts that can be *released* and true groups, Σ_ã M_A(ã|a) T(u|x̃,ã); None without a context filter."""
        if self.context_filter is None:
            return None
        reachable = self._reachable(self.context_filter)
        contexts = tuple(x for x, r in zip(self.context_filter.outputs, reachable, strict=True) if r)
        return self._law(contexts, self.groups, self._induced(group=True, context=False)[reachable], mass=False)

    @cached_property
    def unfiltered(self) -> Law | None:
        """The law without filters, T(u|x,a) for the true contexts and groups; None if the policy lacks one of them."""
        law = self.policy.law
        place = self._cells
        xs, gs = ({label: i for i, label in enumerate(labels)} for labels in (law.contexts, law.groups))
        if not (all(x in xs for x in self.contexts) and all(a in gs for a in self.groups)):
            return None
        cells = [place.get((xs[x], gs[a])) for x in self.contexts for a in self.groups]
        if None in cells:
            return None
        picked = [cell for cell in cells if cell is not None]
        rows, _ = self._rows
        tensor = rows[picked].reshape(len(self.contexts), len(self.groups), -1)
        return self._law(self.contexts, self.groups, tensor)

    @cached_property
    def shown_cells(self) -> list[tuple[int, int]]:
        """Pairs (true context, policy cell): what the policy may be shown in each true context, whatever the group filter's odds are."""
        law = self.policy.law
        xs, gs = ({label: i for i, label in enumerate(labels)} for labels in (law.contexts, law.groups))
        released = [gs[b] for b, r in zip(self.group_filter.outputs, self._reachable(self.group_filter), strict=True) if r]
        if self.context_filter is None:
            return [(x, self._cells[x, a]) for x in range(len(self.contexts)) for a in released]
        outputs = [xs.get(label, -1) for label in self.context_filter.outputs]
        return [
            (x, self._cells[seen, a])
            for x, label in enumerate(self.contexts)
            for seen, positive in zip(outputs, self.context_filter.row(label), strict=True)
            if positive
            for a in released
        ]

    @cached_property
    def released_rows(self) -> tuple[NDArray[Any], int]:
        """T(u|x̃,ã) over the contexts and groups that can be released, in the order of the filters' outputs: integers, and what rows sum to.

        Examples
        --------
        >>> from fairaudit.model.mechanism import RandomizedResponse
        >>> policy = Policy.from_array([["0.9", "0.1"], ["0.4", "0.6"]], decisions=["hire", "pass"], groups=["f", "m"])
        >>> rows, total = policy.behind(group=RandomizedResponse(["f", "m"], keep_probability="0.7")).released_rows
        >>> rows.tolist(), total
        ([[[9, 1], [4, 6]]], 10)
        """
        tensor = self._tensor[:, self._reachable(self.group_filter)]
        return tensor if self.context_filter is None else tensor[self._reachable(self.context_filter)], self._rows[1]

    @cached_property
    def _cells(self) -> dict[tuple[int, int], int]:
        law = self.policy.law
        return {(x, a): i for i, (x, a) in enumerate(zip(law.cell_context.tolist(), law.cell_group.tolist(), strict=True))}

    @cached_property
    def _rows(self) -> tuple[NDArray[Any], int]:
        """The policy's rows as integers over one denominator, and that denominator."""
        law = self.policy.law
        if law.weights.dtype == np.int64 and bool((law.totals == law.totals[0]).all()):
            return law.weights, int(law.totals[0])
        sums = [sum(row) for row in law.integer_rows]
        bottom = lcm(*set(sums))
        if bottom.bit_length() > 300_000:
            raise InputError("the policy's probabilities have no common denominator of fewer than 90,000 digits; give them as decimals")
        rows = [[v * (bottom // total) for v in row] for row, total in zip(law.integer_rows, sums, strict=True)]
        dtype: Any = np.int64 if bottom <= INT64 else object
        return np.array(rows, dtype=dtype), bottom

    def _released_contexts(self) -> tuple[Label, ...]:
        return self.policy.law.contexts if self.context_filter is None else self.context_filter.outputs

    @staticmethod
    def _reachable(mechanism: Mechanism) -> NDArray[np.bool_]:
        """Which released values have positive probability for some input."""
        reachable = np.ones(1, dtype=bool)
        for factor in mechanism.factors:
            positive = np.array([any(row[j] for row in factor.rows) for j in range(len(factor.outputs))])
            reachable = (reachable[:, None] & positive[None, :]).ravel()
        return reachable

    @cached_property
    def _tensor(self) -> NDArray[Any]:
        """T over released contexts and groups; zero where nothing is ever released."""
        law = self.policy.law
        xs, gs = ({label: i for i, label in enumerate(labels)} for labels in (law.contexts, law.groups))
        contexts, groups = self._released_contexts(), self.group_filter.outputs
        reach_x = np.ones(len(contexts), dtype=bool) if self.context_filter is None else self._reachable(self.context_filter)
        reach_a = self._reachable(self.group_filter)
        rows, _ = self._rows
        at_x = np.array([xs.get(x, -1) for x in contexts])
        at_a = np.array([gs.get(a, -1) for a in groups])
        table = np.full((len(law.contexts) + 1, len(law.groups) + 1), -1, dtype=np.int64)
        table[law.cell_context, law.cell_group] = np.arange(len(law.weights))
        index = table[at_x[:, None], at_a[None, :]]
        lost = np.argwhere((index < 0) & reach_x[:, None] & reach_a[None, :])
        if len(lost):
            x, a = contexts[int(lost[0][0])], groups[int(lost[0][1])]
            raise InputError(
                f"the filters can release context {x or 'everything'} with group {a}, for which the policy has no law; "
                + (
                    "draw decisions there (fairaudit.inference.policy_comparisons.policy_comparison bounds the ratio without them)"
                    if law.kind == "counts"
                    else "add it to the policy, or filter into what the policy knows"
                )
            )
        full = np.concatenate((rows, np.zeros((1, rows.shape[1]), dtype=rows.dtype)))
        if len(full) == index.size + 1 and np.array_equal(index.ravel(), np.arange(index.size)):
            return rows.reshape(*index.shape, -1)
        tensor: NDArray[Any] = full[index]
        return tensor

    def _induced(self, *, group: bool, context: bool) -> NDArray[Any]:
        """Σ over released values, factor by factor along its own axis, as integers; rows sum to a common total."""
        tensor = self._tensor
        _, bottom = self._rows
        if self.context_filter and context:
            bottom *= self.context_filter.denominator
        if group:
            bottom *= self.group_filter.denominator
        if bottom > INT64 and tensor.dtype != object:
            tensor = tensor.astype(object)
        decisions = tensor.shape[2]
        on_context: list[Factor | None] = [*self.context_filter.factors] if self.context_filter and context else [None]
        on_group: list[Factor | None] = [*self.group_filter.factors] if group else [None]
        shape = [len(f.outputs) if f else tensor.shape[0] for f in on_context] + [
            len(f.outputs) if f else tensor.shape[1] for f in on_group
        ]
        tensor = tensor.reshape(*shape, decisions)
        for axis, factor in enumerate([*on_context, *on_group]):
            if factor is not None:
                tensor = _apply(factor, tensor, axis)
        rows = len(self.contexts) if context or self.context_filter is None else len(self._released_contexts())
        return tensor.reshape(rows, -1, decisions)

    def _law(self, contexts: tuple[Label, ...], groups: tuple[Label, ...], tensor: NDArray[Any], *, mass: bool = True) -> Law:
        x, a, u = tensor.shape
        base = self.policy.law
        cells = np.arange(x * a, dtype=np.int64)
        weights = mass and self.mass is not None
        return Law(
            columns=base.columns,
            decisions=base.decisions,
            groups=groups,
            contexts=contexts,
            kind="probabilities",
            population="weights" if weights else "equal",
            cell_context=cells // a,
            cell_group=cells % a,
            weights=tensor.reshape(x * a, u),
            mass=self.mass if weights else None,
            notes=base.notes,
            preparation=base.preparation,
        )


@answered
def sample_policy(
    decide: Callable[[LabelsLike, LabelsLike], LabelLike] | PolicySource,
    cells: Iterable[tuple[LabelsLike, LabelsLike]] | None = None,
    trials: int = 1,
) -> dict[str, list[LabelsLike]]:
    """Ask a black box again and again, and count its decisions.

    Parameters
    ----------
    decide : callable or PolicySource
        ``decide(context, group)`` returns a decision; or an object with ``cells()`` and ``decide(context, group, trial)``.
    cells : iterable of (context, group), optional
        What to show it; by default what the source says that it knows.
    trials : int
        How often each cell is asked.

    Returns
    -------
    dict of str to list
        A counts table with the columns ``context``, ``group``, ``decision`` and ``count``, for `Policy.from_counts`.

    Raises
    ------
    InputError
        If there is no cell or no trial, or a decision is not a label.

    Examples
    --------
    >>> counts = sample_policy(lambda x, a: "go" if a == "f" else "stay", [("lobby", "f"), ("lobby", "m")], trials=5)
    >>> counts["count"]
    [5, 5]
    """
    source_decide = getattr(decide, "decide", None)
    if cells is None:
        if source_decide is None:
            raise InputError("no cells were given; list the pairs (context, group) to ask about")
        cells = decide.cells()  # type: ignore[union-attr]
    if trials < 1:
        raise InputError(f"{trials} trials were asked for; at least 1 is needed")
    counts: dict[tuple[Any, Any, str], int] = {}
    for x, a in cells:
        for trial in range(trials):
            answer = source_decide(x, a, trial) if source_decide is not None else decide(x, a)  # type: ignore[operator]
            label = label_text(answer)
            if label is None:
                raise InputError(
                    f"the black box returned {shown(answer)} for context {shown(x)} and group {shown(a)}; a decision is a label"
                )
            counts[x, a, label] = counts.get((x, a, label), 0) + 1
    if not counts:
        raise InputError("there is no cell to ask about; list at least one pair (context, group)")
    return {
        "context": [x for x, _, _ in counts],
        "group": [a for _, a, _ in counts],
        "decision": [u for _, _, u in counts],
        "count": list(counts.values()),
    }


@answered
def policy_source(name: str, **options: object) -> Any:
    """Load a plug-in that is registered under the entry point ``fairaudit.policies``.

    Parameters
    ----------
    name : str
        Its name.
    **options
        What the plug-in is made with, where it registered a class or a callable: of which file, of which model.

    Returns
    -------
    object
        What it registered: a `PolicySource`, or an object with ``table() -> Policy``, or a callable that makes one.

    Raises
    ------
    InputError
        If no plug-in has that name, or it does not take these options.

    Examples
    --------
    >>> policy_source("stand-in").__class__.__name__, policy_source("stand-in", experiment="waiting-time").table().law.decisions
    ('StandIn', ('Recipient1', 'Recipient2'))
    """
    from importlib.metadata import entry_points
    from inspect import signature

    found = {entry.name: entry for entry in entry_points(group=ENTRY_POINT)}
    if name not in found:
        raise InputError(f"there is no policy plug-in {shown(name)}; {nearest(name, found) if found else 'none is installed'}")
    loaded = found[name].load()
    if not (isinstance(loaded, type) or options):
        return loaded
    try:
        signature(loaded).bind(**options)
    except (TypeError, ValueError) as error:
        raise InputError(f"the policy plug-in {shown(name)} is not made with these options: {error}") from None
    return loaded(**options)


def _deploy(policy: Policy, group: Mechanism, context: Mechanism | None, population: Any, releases: int) -> Deployment:
    law = policy.law
    for what, mechanism, columns in (("group", group, law.columns.group), ("context", context, law.columns.context)):
        if mechanism is None:
            continue
        if mechanism.width != len(columns):
            raise InputError(
                f"the {what} filter covers {mechanism.width} {noun(mechanism.width, 'column')}; the policy has "
                f"{len(columns)}: {', '.join(columns)}"
            )
        if mechanism.columns and mechanism.columns != columns:
            raise InputError(f"the {what} filter is for the columns {', '.join(mechanism.columns)}; the policy has {', '.join(columns)}")
    if len(group.inputs) < 2:
        raise InputError("the group filter has only one input; fairness compares at least two groups")
    deployment = Deployment(policy, group, context, None, releases)
    mass = None if population is None else _mass(population, deployment)
    deployment = replace(deployment, mass=mass)
    _ = deployment.law
    return deployment


def _mass(population: Any, deployment: Deployment) -> tuple[int, ...]:
    contexts, groups = deployment.contexts, deployment.groups
    if isinstance(population, Law):
        places = zip(population.cell_context.tolist(), population.cell_group.tolist(), strict=True)
        labels = [(population.contexts[x], population.groups[a]) for x, a in places]
        found = dict(zip(labels, population.cell_mass, strict=True))
        return _positive([(found.pop((x, a), 0), 1) for x in contexts for a in groups], found)
    if isinstance(population, Mapping):
        given = {tuple(names(part) for part in key): option_value(v) for key, v in population.items()}
        return _positive([given.pop((x, a), (0, 1)) for x in contexts for a in groups], given)
    array = np.asarray(population)
    if array.shape != (len(contexts), len(groups)):
        raise InputError(f"the population has shape {array.shape}; it must be {(len(contexts), len(groups))}, contexts by groups")
    return _positive([rational(v) for v in array.ravel().tolist()], {})


def _positive(pairs: list[tuple[int, int]], unknown: Mapping[Any, Any]) -> tuple[int, ...]:
    if unknown:
        raise InputError(f"the population names {shown(next(iter(unknown)))}, which is not a true context and group of the filters")
    if any(n < 0 for n, _ in pairs):
        raise InputError("the population has a negative mass; masses of at least 0 are accepted")
    whole, _ = common_denominator(pairs)
    if not any(whole):
        raise InputError("every mass of the population is zero; at least one must be positive")
    return tuple(whole)


def _apply(factor: Factor, tensor: NDArray[Any], axis: int) -> NDArray[Any]:
    """Σ_j rows[i][j]·tensor[…, j, …] along an axis; identity plus rank one where the factor is of that form."""
    mixing = factor.mixing
    if mixing is None:
        rows = np.array(factor.rows, dtype=tensor.dtype)
        return np.moveaxis(np.tensordot(rows, tensor, axes=(1, axis)), 0, axis)
    diagonal, base = mixing
    if diagonal == 0 or len(set(base)) > 1:
        weights = np.array(base, dtype=tensor.dtype)
        common = np.expand_dims(np.tensordot(weights, tensor, axes=(0, axis)), axis)
    else:
        common = tensor.sum(axis=axis, keepdims=True) * base[0]
    if diagonal == 0:
        return np.ascontiguousarray(np.broadcast_to(common, tensor.shape))
    result: NDArray[Any] = tensor * diagonal
    result += common
    return result
