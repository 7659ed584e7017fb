"""The utility g(u,x,a) of the person with context x and group a when decision u is taken, and its constants.

It is at least 0 wherever ratios are formed; one that may be negative is said to be `signed`, and has differences only.
"""

from __future__ import annotations

import unicodedata
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from fractions import Fraction
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from fairaudit.arguments import answered, answered_class
from fairaudit.errors import InputError, nearest, shown
from fairaudit.exact.dense import Weights
from fairaudit.exact.rationals import Number, common_denominator, option_value, rational
from fairaudit.model.law import Law
from fairaudit.tables.columns import MISSING_LABEL, Missing
from fairaudit.tables.label_text import label_text
from fairaudit.tables.number_form import bears_sign, plain_numbers
from fairaudit.tables.sources import Table
from fairaudit.tables.values import INT64, ByLabel, Label, column, locator, names
from fairaudit.words import brief

__all__ = ["Utility", "UtilityTable", "known_utility", "utility_values"]


Values = ByLabel[Number]
"""What decisions are worth."""

Metric = Callable[[Label, Label], Any]

SIGNED = "or ask for differences alone: difference, --difference"

MISSPELT = 0.8  # of difflib's measure: 'yess' is yes, 'not hired' is not hired

Entry = tuple[str, Label, Label]


@answered_class(values=Values)
@brief
@dataclass(frozen=True, repr=False)
class Utility:
    """A utility of decisions, contexts and groups.

    Parameters
    ----------
    values : mapping of decision to number
        g(u), the same in every context and group; decisions that are not listed have g = 0.
    entries : mapping, optional
        g(u,x,a) where it varies; set by `from_table` and `from_function`.
    observed : bool
        Whether the values were read off a table, so that the greatest one seen does not bound those that were not.
    signed : bool
        Whether values may be negative. Such a utility has differences between groups and no ratios, which depend on the origin.

    Examples
    --------
    >>> Utility({"yes": 1, "maybe": "0.5"}).gamma
    Fraction(1, 1)
    >>> Utility({"better": 1, "worse": -1}, signed=True).m
    Fraction(-1, 1)
    """

    values: Mapping[str, Fraction]
    entries: Mapping[Entry, tuple[int, int]] | None = field(default=None, repr=False)
    observed: bool = field(default=False, repr=False)
    signed: bool = field(default=False, repr=False)

    if TYPE_CHECKING:  # what is accepted; the attributes are what is kept of it

        def __init__(
            self, values: Values, entries: Mapping[Entry, tuple[int, int]] | None = None, observed: bool = False, signed: bool = False
        ) -> None: ...

    def __post_init__(self) -> None:
        """Read the values as exact rationals."""
        exact: dict[str, tuple[int, int]] = {}
        for decision, value in self.values.items():
            label = label_text(decision)
            if label is None:
                raise InputError("a decision of the utility has no label")
            if label in exact:
                raise InputError(f"the utility gives decision {shown(label)} twice")
            try:
                pair = option_value(value)
            except InputError as error:
                raise InputError(f"the utility of decision {shown(label)}: {error}") from None
            if pair[0] < 0 and not self.signed:
                raise InputError(
                    f"the utility of decision {shown(label)} is negative; utilities are at least 0 (audit the burden, {SIGNED})"
                )
            exact[label] = pair
        object.__setattr__(self, "values", {label: Fraction(*pair) for label, pair in exact.items()})
        if not exact and self.entries is None:
            raise InputError("the utility lists no decision; list at least one, such as {'Admitted': 1}")

    @staticmethod
    @answered
    def from_table(
        table: Table,
        *,
        utility: str,
        decision: str,
        group: str | Sequence[str] = (),
        context: str | Sequence[str] | None = None,
        missing: Missing = "error",
        signed: bool = False,
    ) -> Utility:
        """Read g(u,x,a) from a column of a table.

        A value that is the same on all rows of a decision makes g depend on the decision alone.

        Parameters
        ----------
        table : DataFrame or mapping of str to sequence
            The table.
        utility, decision : str
            Columns of g and of the decision.
        group, context : str or sequence of str
            Columns on which g may depend.
        missing : {"error", "drop", "group", "unknown", "undecided"}
            With "group", of the decision with "undecided", and in group columns with "unknown", an empty label is the level ``(missing)``,
            as in `Law.from_counts`; otherwise such rows are passed over.
        signed : bool
            Whether values may be negative.

        Returns
        -------
        Utility
            The utility.

        Raises
        ------
        InputError
            If g is missing, negative, not a number, or varies within one (u,x,a).
        """
        where = locator(table)
        groups, contexts = names(group), names(context)
        lists = {name: column(table, name) for name in (decision, *groups, *contexts, utility)}
        worth = plain_numbers(utility, lists[utility], where) or lists[utility]
        entries: dict[Entry, tuple[int, int]] = {}
        cache: dict[Any, tuple[int, int]] = {}
        empty: list[list[Any]] = []
        a_rows = list(zip(*[lists[g] for g in groups], strict=True)) if groups else empty
        x_rows = list(zip(*[lists[c] for c in contexts], strict=True)) if contexts else empty
        for position, (u, value) in enumerate(zip(lists[decision], worth, strict=True)):
            labels = [label_text(v) for v in (u, *(x_rows[position] if contexts else ()), *(a_rows[position] if groups else ()))]
            needed = {"unknown": labels[: 1 + len(contexts)], "undecided": labels[1:], "group": []}.get(missing, labels)
            if None in needed:
                continue
            texts = [MISSING_LABEL if text is None else text for text in labels]
            key = (texts[0], tuple(texts[1 : 1 + len(contexts)]), tuple(texts[1 + len(contexts) :]))
            cached = (type(value), value)
            pair = cache.get(cached)
            if pair is None:
                try:
                    if label_text(value) is None:
                        raise InputError("the utility is missing")
                    pair = rational(value)
                    if pair[0] < 0 and not signed:
                        raise InputError(f"{shown(value)} is negative; utilities are at least 0 ({SIGNED})")
                except InputError as error:
                    raise InputError(f"column {shown(utility)}, {where(position)}: {error}{bears_sign(value)}") from None
                cache[cached] = pair
            known = entries.setdefault(key, pair)
            if known != pair:
                raise InputError(
                    f"column {shown(utility)}, {where(position)}: the utility {shown(value)} differs from that of an earlier row with the "
                    "same decision, context and group; leave out the decision column so that each value counts as its own decision"
                )
        return Utility(*_simplest(entries), observed=True, signed=signed)

    @staticmethod
    @answered
    def from_function(function: Callable[[str, Label, Label], Number], law: Law, *, signed: bool = False) -> Utility:
        """Tabulate g(u, x, a) over the decisions, contexts and groups of a law.

        Parameters
        ----------
        function : callable
            Takes a decision label and the label tuples of context and group; returns a number.
        law : Law
            Where the labels come from.
        signed : bool
            Whether values may be negative.

        Returns
        -------
        Utility
            The utility.

        Raises
        ------
        InputError
            If a value is negative or not a number.

        Examples
        --------
        >>> law = Law.from_array([[1, 3], [2, 2]], kind="counts", decisions=["left", "right"])
        >>> Utility.from_function(lambda u, x, a: 1 if u == "left" else 0, law).gamma
        Fraction(1, 1)
        """
        entries: dict[Entry, tuple[int, int]] = {}
        for x, a in zip(law.cell_context.tolist(), law.cell_group.tolist(), strict=True):
            for u in law.decisions:
                value = function(u, law.contexts[x], law.groups[a])
                pair = option_value(value)
                if pair[0] < 0 and not signed:
                    raise InputError(f"the utility of decision {shown(u)} is {shown(value)}; utilities are at least 0 ({SIGNED})")
                entries[u, law.contexts[x], law.groups[a]] = pair
        return Utility(*_simplest(entries), signed=signed)

    @property
    def gamma(self) -> Fraction:
        """Greatest value over what is listed (and 0 for decisions that are not)."""
        return max(self._listed())

    @property
    def m(self) -> Fraction:
        """Least value over what is listed (and 0 for decisions that are not); `on` a law that lists them all it may be greater."""
        return min(self._listed())

    def _listed(self) -> list[Fraction]:
        if self.entries is None:
            return [*self.values.values(), Fraction(0)]
        return [Fraction(*pair) for pair in self.entries.values()]

    @answered
    def over(self, law: Law) -> Law:
        """The law with all decisions that the utility names, so that those that never occurred count into the range of g.

        Raises
        ------
        InputError
            If a decision that never occurred is spelt much like one that did and is not named, or none that is named occurred.

        Examples
        --------
        >>> law = Law.from_array([[3, 1], [1, 1]], kind="counts", decisions=["maybe", "no"])
        >>> Utility({"yes": 1, "maybe": "0.5"}).over(law).decisions
        ('maybe', 'no', 'yes')
        """
        named = self.values if self.entries is None else {u for u, _, _ in self.entries}
        further = sorted(label for label in named if label not in law.decisions)
        for label in further if self.entries is None else ():
            others = [other for other in law.decisions if other not in named]
            meant = next((other for other in others if _alike(label, other)), None)
            if meant is None and len(further) < len(named):
                continue
            if label == law.columns.decision and meant is None:
                such = ", such as 1 (--utility 1)" if "1" in law.decisions else ""
                raise InputError(
                    f"the utility names the decision {shown(label)}, which does not occur: that is the column; give one of its labels{such}"
                    f"; {nearest('', law.decisions)}"
                )
            beside = meant or (others or law.decisions)[0]
            raise InputError(
                f"the utility names the decision {shown(label)}, which does not occur; {nearest(label, law.decisions)} "
                f"(if {shown(label)} is a decision that could have occurred, give {shown(beside)} a utility too, such as 0)"
            )
        return law.with_decisions(further)

    @answered
    def on(self, law: Law) -> UtilityTable:
        """Lay the utility out over the alphabet of a law, with all decisions that it names: see `over`.

        Raises
        ------
        InputError
            As for `over`, and if it leaves g open where a decision has weight.
        """
        law = self.over(law)
        if self.entries is None:
            pairs = [self.values.get(u, Fraction(0)) for u in law.decisions]
            whole, bottom = common_denominator([(v.numerator, v.denominator) for v in pairs])
            return UtilityTable(law, _array(whole), bottom, None)
        unknown = [] if law.unknown is None else self._of_unknown(law)
        listed: list[tuple[int, int]] = []
        given = np.zeros((len(law.cell_context), len(law.decisions)), dtype=bool)
        for i, (x, a) in enumerate(zip(law.cell_context.tolist(), law.cell_group.tolist(), strict=True)):
            for k, u in enumerate(law.decisions):
                pair = self.entries.get((u, law.contexts[x], law.groups[a]))
                given[i, k] = pair is not None
                listed.append(pair or (0, 1))
        open_cells = np.argwhere(~given & (law.weights != 0))
        if len(open_cells):
            i, k = (int(v) for v in open_cells[0])
            where = {**law.context_label(int(law.cell_context[i])), **law.group_label(int(law.cell_group[i]))}
            raise InputError(f"the utility of decision {shown(law.decisions[k])} at {where} is not given")
        whole, bottom = common_denominator([*listed, *(pair or (0, 1) for row in unknown for pair in row)])
        width, size = len(law.decisions), given.size
        held = [iter(whole[i : i + width]) for i in range(size, len(whole), width)]
        of_unknown = tuple(
            tuple(v if pair else None for v, pair in zip(own, row, strict=True)) for own, row in zip(held, unknown, strict=True)
        )
        return UtilityTable(law, _array(whole[:size]).reshape(given.shape), bottom, None if given.all() else given, of_unknown)

    def _of_unknown(self, law: Law) -> list[list[tuple[int, int] | None]]:
        """What decisions of unknown group are worth in each context that has any: what they are worth in every group there."""
        found: dict[tuple[str, Label], set[tuple[int, int]]] = {}
        for (u, x, _), pair in (self.entries or {}).items():
            found.setdefault((u, x), set()).add(pair)
        rows: list[list[tuple[int, int] | None]] = []
        for x, weights in zip(law.unknown.contexts.tolist(), law.unknown.weights.tolist(), strict=True) if law.unknown else ():
            rows.append([])
            for u, weight in zip(law.decisions, weights, strict=True):
                values = found.get((u, law.contexts[x]), set())
                if weight and len(values) != 1:
                    where = f" at {law.context_label(x)}" if law.columns.context else ""
                    why = "depends on the group" if values else "is not given"
                    raise InputError(
                        f"the utility of decision {shown(u)}{where} {why}, so that of decisions of unknown group is not known; "
                        "give one that is the same for all groups"
                    )
                rows[-1].append(next(iter(values)) if len(values) == 1 else None)
        return rows


@brief
@dataclass(frozen=True, eq=False, repr=False)
class UtilityTable:
    """A utility laid out over a law; made by `Utility.on`.

    Attributes
    ----------
    law : Law
        The law, with all decisions that the utility names.
    values : ndarray of int
        g as integers over `scale`: shape (decisions,) when g depends on the decision alone, else (cells, decisions).
    scale : int
        The common denominator.
    given : ndarray of bool or None
        Which entries were given, where some were not (their weight is zero).
    unknown : tuple of tuple
        Where g does not depend on the decision alone: what decisions of unknown group are worth, for each context that has any, as integers
        over `scale`; None where that is not known (and there are none).

    Examples
    --------
    >>> import fairaudit as fa
    >>> table = {"hired": ["yes", "no", "yes", "no"], "sex": ["f", "f", "m", "m"], "n": [30, 10, 20, 20]}
    >>> result = fa.audit(table, decision="hired", group="sex", count="n", utility="yes", max_local_ratio="5/4")
    >>> result.utility.gamma, result.utility.m
    (Fraction(1, 1), Fraction(0, 1))
    """

    law: Law
    values: Weights
    scale: int
    given: NDArray[np.bool_] | None
    unknown: tuple[tuple[int | None, ...], ...] = ()

    @property
    def by_decision(self) -> bool:
        """Whether g depends on the decision alone."""
        return self.values.ndim == 1

    @cached_property
    def gamma(self) -> Fraction:
        """γ, the greatest value of g over the whole decision alphabet."""
        return Fraction(int(self._entries().max()), self.scale)

    @cached_property
    def m(self) -> Fraction:
        """Least value of g over the whole decision alphabet."""
        return Fraction(int(self._entries().min()), self.scale)

    def _entries(self) -> NDArray[Any]:
        return self.values if self.given is None else self.values[self.given]

    @property
    def signed(self) -> bool:
        """Whether a value is negative, so that ratios of expectations say nothing: they depend on the origin."""
        return self.m < 0

    @property
    def depends_on_group(self) -> bool:
        """Whether g differs between two groups somewhere."""
        return self.lipschitz() > 0

    def lipschitz(self, metric: Metric | None = None) -> Fraction:
        """L_A = max |g(u,x,a) − g(u,x,a')| / d(a,a').

        Parameters
        ----------
        metric : callable, optional
            d, taking two group label tuples and returning a number > 0; the 0/1 metric by default.

        Returns
        -------
        Fraction
            The constant, over decisions and over groups that are both present in a context.
        """
        if self.by_decision:
            return Fraction(0)
        law, best = self.law, Fraction(0)
        for start, end in zip(law.starts[:-1].tolist(), law.starts[1:].tolist(), strict=True):
            block = self.values[start:end]
            given = self.given[start:end] if self.given is not None else np.ones(block.shape, dtype=bool)
            if metric is None:
                for k in np.flatnonzero(given.sum(axis=0) > 1).tolist():
                    column_values = block[given[:, k], k]
                    best = max(best, Fraction(int(column_values.max()) - int(column_values.min()), self.scale))
                continue
            for i in range(end - start):
                for j in range(i):
                    both = given[i] & given[j]
                    if not both.any():
                        continue
                    gap = int(np.abs(block[i][both] - block[j][both]).max())
                    if gap:
                        a, b = (law.groups[int(law.cell_group[start + n])] for n in (i, j))
                        distance = Fraction(*option_value(metric(a, b)))
                        if distance <= 0:
                            raise InputError(
                                f"the metric gives the distance {distance} between {a} and {b}; distances of different groups are positive"
                            )
                        best = max(best, Fraction(gap, self.scale) / distance)
        return best

    def row(self, cell: int) -> list[int]:
        """G of a cell as integers over `scale`."""
        values: list[int] = (self.values if self.by_decision else self.values[cell]).tolist()
        return values


def _alike(one: str, other: str) -> bool:
    """Whether two labels are so close that one may be a misspelling of the other."""
    first, second = (" ".join(unicodedata.normalize("NFC", label).casefold().split()) for label in (one, other))
    if first == second:
        return True
    from difflib import SequenceMatcher

    return SequenceMatcher(None, first, second).ratio() >= MISSPELT


def _array(values: list[int]) -> NDArray[Any]:
    return np.array(values, dtype=np.int64 if min(values) >= -INT64 and max(values) <= INT64 else object)


def _simplest(entries: dict[Entry, tuple[int, int]]) -> tuple[dict[str, Fraction], dict[Entry, tuple[int, int]] | None]:
    """Reduce to g(u) where all rows of a decision agree."""
    by_decision: dict[str, tuple[int, int]] = {}
    for (u, _, _), pair in entries.items():
        if by_decision.setdefault(u, pair) != pair:
            return {}, entries
    if not by_decision:
        raise InputError("the utility table has no rows")
    return {u: Fraction(*pair) for u, pair in by_decision.items()}, None


def known_utility(law: Law, utility: Utility | Values) -> Utility:
    """A utility for what needs the worth of every decision, with which decisions of unknown meaning do not go.

    Raises
    ------
    InputError
        If whoever supplied the law says that a decision may have meant anything, and the utility does not say what it is worth.

    Examples
    --------
    >>> from dataclasses import replace
    >>> law = Law.from_array([[3, 1], [1, 1]], kind="counts", decisions=["yes", "unreadable"])
    >>> known_utility(replace(law, undecided=("unreadable",)), {"yes": 1, "unreadable": 0}).gamma
    Fraction(1, 1)
    """
    wanted = utility if isinstance(utility, Utility) else Utility(utility)
    named = wanted.values if wanted.entries is None else {u for u, _, _ in wanted.entries}
    unknown = [label for label in law.undecided if label not in named and label in law.decisions]
    if unknown:
        raise InputError(
            f"the policy leaves open what the decision {shown(unknown[0])} meant, and a filter is found for what is worth a known number; "
            "give it a utility, too, such as 0"
        )
    return wanted


def utility_values(text: str, name: str = "utility") -> dict[str, str]:
    """Read ``decision[=number],…``; a label with a comma or an equals sign is quoted as in CSV.

    Parameters
    ----------
    text : str
        The text.
    name : str
        What the option is called, for messages.

    Raises
    ------
    InputError
        If the text is not of that form.

    Examples
    --------
    >>> utility_values('yes,maybe=0.5,"no, sorry"=1/4')
    {'yes': '1', 'maybe': '0.5', 'no, sorry': '1/4'}
    """
    values: dict[str, str] = {}
    rest = text.strip()
    while rest:
        if rest.startswith('"'):
            end = 1
            while (end := rest.find('"', end)) >= 0 and rest[end : end + 2] == '""':
                end += 2
            if end < 0:
                raise InputError(f"{name} {shown(text)} has a quotation mark that is not closed")
            label, rest = rest[1:end].replace('""', '"'), rest[end + 1 :].lstrip()
        else:
            cut = min((i for i in (rest.find(","), rest.find("=")) if i >= 0), default=len(rest))
            label, rest = rest[:cut].strip(), rest[cut:]
        value = "1"
        if rest.startswith("="):
            value, _, rest = rest[1:].partition(",")
        elif rest.startswith(",") and len(rest) > 1:
            rest = rest[1:]
        elif rest:
            raise InputError(f"{name} {shown(text)} is not of the form decision[=number],… near {shown(rest)}")
        rest = rest.lstrip()
        if not label or label in values:
            raise InputError(
                f"{name} {shown(text)} {'has an empty label' if not label else f'lists {shown(label)} twice'}; list each decision once"
            )
        values[label] = value.strip()
    if not values:
        raise InputError(f"{name} is empty; list at least one decision, such as Admitted or yes=1,maybe=0.5")
    return values
