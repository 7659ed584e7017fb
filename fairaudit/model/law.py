"""The audited law P(u|x,a): decisions u, contexts x, groups a, with labels, exact weights and, where known, a population.

A law holds one row of non-negative weights per cell (x,a); a row normalised by its own sum is P(·|x,a). Rows are integers over one
denominator (int64, or Python integers where those are too small) or the float64 values that were handed over, each of which is a
dyadic rational, or float32 values likewise. Nothing is rounded on the way in.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from fractions import Fraction
from functools import cached_property
from math import gcd
from typing import TYPE_CHECKING, Any, Literal

import numpy as np
from numpy.typing import NDArray

from fairaudit.arguments import answered
from fairaudit.errors import InputError, shown
from fairaudit.exact.dense import Numbers, Weights, least_and_sums, quotients
from fairaudit.exact.number_columns import NumberColumn, added
from fairaudit.exact.rationals import common_denominator
from fairaudit.model.layout import (
    MAX_ENTRIES,
    Columns,
    Kind,
    Truth,
    Units,
    array_entries,
    array_mass,
    axis_labels,
    copies_of_units,
    default_names,
    dyadic,
    dyadic_rows,
    masses_of_cells,
    refuse_repeats,
    sampling_units,
    spread_truth,
)
from fairaudit.model.unknown import UnknownRows, refuse_beside_unknown, unknown_rows
from fairaudit.tables.columns import MISSING_LABEL, CodedTable, Missing, read_columns
from fairaudit.tables.preparation import Entry, assumption
from fairaudit.tables.sources import Table
from fairaudit.tables.tally import Tally
from fairaudit.tables.values import (
    Label,
    LabelLike,
    LabelsLike,
    distinct,
    exact_floats,
    exact_numbers,
    float_numbers,
    integers,
    names,
    numbers,
)
from fairaudit.words import brief

if TYPE_CHECKING:
    from fairaudit.tables.evaluations.samples import Evaluation


__all__ = ["Law"]


Population = Literal["counts", "weights", "equal"]

MAX_DRAWS = 10**18  # draws of a cell that still fit 64 bits

TOLERANCE = 10**6  # one part in so many is what rows of probabilities may be off 1 by: six printed digits


@brief
@dataclass(frozen=True, eq=False, repr=False)
class Law:
    """A discrete law P(u|x,a), exact, with labels.

    Build one with `from_counts`, `from_probabilities`, `from_log` or `from_array`.

    Attributes
    ----------
    columns : Columns
        Names of the decision, group and context columns.
    decisions : tuple of str
        Labels of the decision alphabet, in order of first appearance; of a log, sorted.
    groups, contexts : tuple of tuple of str
        Labels of the groups a and contexts x, one text per column.
    kind : {"counts", "probabilities"}
        Whether the weights are counts (they also carry the population) or probabilities.
    population : {"counts", "weights", "equal"}
        Where P(x,a) comes from; "equal" weighs contexts equally.
    cell_context, cell_group : ndarray of int64, shape (cells,)
        Which context and group a row belongs to; rows are sorted by (context, group).
    weights : ndarray, shape (cells, decisions)
        Rows of non-negative weights with positive sums.
    scale : int
        Counts are ``weights / scale``; for probabilities rows are normalised by their own sum and it has no meaning.
    mass : tuple of int or None
        P(x,a) up to a common factor, with population "weights".
    notes : tuple of str
        What was noticed while reading, for a person.
    preparation : tuple of mapping
        What was done to the log before it was counted, as a certificate records it (`fairaudit.tables.preparation`).
    units : Units or None
        Which rows of a log belong to one draw; None if every row is a draw of its own.
    truth : Truth or None
        The true labels of counts, if they are known.
    unknown : UnknownRows or None
        Counts of decisions whose group was not recorded; no other attribute has them.
    rows_read : int or None
        How many rows of a table it was made of, without those that were left out; None where it was not read from one.
    evaluation : Evaluation or None
        Of a log of a model's evaluation, how it was read, and which samples were taken out of it.
    undecided : tuple of str
        Decisions that may have meant anything, as whoever supplied the law says; an audit takes them so unless it says what they are worth.

    Examples
    --------
    >>> law = Law.from_counts(
    ...     {"hired": ["yes", "no", "yes", "no"], "sex": ["f", "f", "m", "m"], "n": [3, 1, 1, 1]},
    ...     decision="hired", group="sex", count="n")
    >>> law.decisions, law.groups
    (('yes', 'no'), (('f',), ('m',)))
    """

    columns: Columns
    decisions: tuple[str, ...]
    groups: tuple[Label, ...]
    contexts: tuple[Label, ...]
    kind: Kind
    population: Population
    cell_context: NDArray[np.int64]
    cell_group: NDArray[np.int64]
    weights: Weights
    scale: int = 1
    mass: tuple[int, ...] | None = None
    notes: tuple[str, ...] = ()
    units: Units | None = None
    truth: Truth | None = None
    preparation: tuple[Entry, ...] = ()
    unknown: UnknownRows | None = None
    rows_read: int | None = field(default=None, repr=False)
    evaluation: Evaluation | None = field(default=None, repr=False)
    undecided: tuple[str, ...] = field(default=(), repr=False)

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
        truth: str | None = None,
        unknown: Sequence[str] = (),
    ) -> Law:
        """Read a table with one row per combination and its count; repeated rows add up.

        Parameters
        ----------
        table : DataFrame or mapping of str to sequence
            Anything whose columns are reached by ``table[name]``.
        decision, count : str
            Columns of the decision and of the count (a number ≥ 0, not necessarily an integer).
        group, context : str or sequence of str
            Columns of the sensitive attributes and of the contexts; several make tuples (intersections).
        missing : {"error", "drop", "group", "unknown", "undecided"}
            What an empty label means: an error, a row to leave out, a level of its own named ``(missing)``; in a group column that the
            group is unknown; or of the decision that it may have been any: it is ``(missing)``, and undecided.
        truth : str, optional
            Column of the true label, for rates of true and false positives (`certify`).
        unknown : sequence of str
            Labels of group columns that name no group: of a row with one of them in any group column the group is unknown.

        Returns
        -------
        Law
            The law, with the counts as population.

        Raises
        ------
        InputError
            If a column is absent, a label or number is not usable, or nothing is left.
        """
        return _read(table, decision, group, context, "counts", count, None, missing, truth=truth, unknown=unknown)

    @staticmethod
    @answered
    def from_log(
        table: Table,
        *,
        decision: str,
        group: str | Sequence[str],
        context: str | Sequence[str] | None = None,
        missing: Missing = "error",
        unit: str | Sequence[str] | None = None,
        truth: str | None = None,
        unknown: Sequence[str] = (),
    ) -> Law:
        """Read a log with one decision per row.

        Its labels are sorted, so that every engine and every order of the rows gives the same law.

        Parameters
        ----------
        table : DataFrame, lazy frame, relation, mapping of str to sequence, or Tally
            Frames of pandas, polars, pyarrow, DuckDB and PySpark count their rows themselves. For files and databases see `read_log`.
        decision, group, context, missing, truth, unknown
            As in `from_counts`.
        unit : str or sequence of str, optional
            Columns of the sampling unit, when several rows belong to one draw: the run that ranked several candidates, the profile
            that was asked about several times. It changes no figure of the table, only what may be said of the population behind it.

        Returns
        -------
        Law
            The law, with the counts as population.

        Raises
        ------
        InputError
            As in `from_counts`, and if a row has no unit.

        Examples
        --------
        >>> law = Law.from_log({"hired": ["yes", "no", "yes"], "sex": ["f", "f", "m"]}, decision="hired", group="sex")
        >>> law.weights.tolist()
        [[1, 1], [0, 1]]
        """
        from fairaudit.tables.frames import tally_frame

        wanted = dict.fromkeys((decision, *names(context), *names(group), *names(unit), *names(truth)))
        tally = tally_frame(table, list(wanted))
        return _read(table if tally is None else tally, decision, group, context, "counts", None, None, missing, unit, truth, unknown)

    @staticmethod
    @answered
    def from_probabilities(
        table: Table,
        *,
        decision: str,
        group: str | Sequence[str],
        probability: str,
        context: str | Sequence[str] | None = None,
        weight: str | None = None,
        missing: Missing = "error",
    ) -> Law:
        """Read a table with one row per combination and its probability P(u|x,a).

        Each row of the law is normalised exactly; a sum that is off 1 by more than 1e-6 is an error, a smaller residue is noted.

        Parameters
        ----------
        table, decision, group, context, missing
            As in `from_counts`.
        probability : str
            Column of P(u|x,a); a decision without a row has probability 0.
        weight : str, optional
            Column of the population mass P(x,a), the same on all rows of a cell; any common factor.

        Returns
        -------
        Law
            The law.

        Raises
        ------
        InputError
            As in `from_counts`, and if a combination is repeated, or the mass varies within a cell.

        Examples
        --------
        >>> law = Law.from_probabilities(
        ...     {"u": ["yes", "no", "yes", "no"], "a": ["f", "f", "m", "m"], "p": ["0.1", "0.9", "1/3", "2/3"]},
        ...     decision="u", group="a", probability="p")
        >>> law.population
        'equal'
        """
        return _read(table, decision, group, context, "probabilities", probability, weight, missing)

    @staticmethod
    @answered
    def from_array(
        array: Numbers,
        *,
        kind: Kind = "probabilities",
        decisions: Sequence[LabelLike] | None = None,
        groups: Sequence[LabelsLike] | None = None,
        contexts: Sequence[LabelsLike] | None = None,
        population: Numbers | None = None,
        columns: Columns | None = None,
    ) -> Law:
        """Read an array indexed [context, group, decision], or [group, decision] for a single context.

        Parameters
        ----------
        array : array_like
            Counts or probabilities; an all-zero row is a cell without a law. Floats are the dyadic rationals that they are. Arrays of
            float64 and float32 probabilities are neither copied nor converted, so they may be memory-mapped files larger than memory.
        kind : {"counts", "probabilities"}
            What the entries are.
        decisions, groups, contexts : sequence, optional
            Labels along the axes (a tuple per entry for several columns); ``0, 1, …`` by default.
        population : array_like, shape (contexts, groups), optional
            P(x,a) up to a common factor, for probabilities.
        columns : Columns, optional
            Column names; ``decision``, ``group``, ``context`` by default.

        Returns
        -------
        Law
            The law.

        Raises
        ------
        InputError
            If shapes, labels or entries do not fit.

        Examples
        --------
        >>> law = Law.from_array([[[3, 1], [1, 1]]], kind="counts", decisions=["yes", "no"], groups=["f", "m"])
        >>> law.groups
        (('f',), ('m',))
        """
        return _from_array(array, kind, decisions, groups, contexts, population, columns)

    @property
    def assumptions(self) -> tuple[str, ...]:
        """What was done to the log and must be judged by the reader of a certificate: what was left out."""
        of_table = tuple(text for text in map(assumption, self.preparation) if text)
        if self.evaluation is None:
            return of_table
        from fairaudit.tables.evaluations.lost import left_out_of

        return (*left_out_of(self.evaluation), *of_table)

    def with_decisions(self, labels: Sequence[str]) -> Law:
        """The same law with further decisions that never occurred.

        Examples
        --------
        >>> law = Law.from_array([[3, 1], [1, 1]], kind="counts", decisions=["maybe", "no"]).with_decisions(["yes"])
        >>> law.decisions, law.weights.tolist()
        (('maybe', 'no', 'yes'), [[3, 1, 0], [1, 1, 0]])
        """
        if not labels:
            return self
        nothing = np.zeros((len(self.weights), len(labels)), dtype=self.weights.dtype)
        units, truth, unknown = self.units, self.truth, self.unknown
        if unknown is not None:
            unknown = replace(unknown, weights=np.pad(unknown.weights, ((0, 0), (0, len(labels)))))
        if truth is not None:
            spread = np.zeros((*truth.weights.shape[:2], len(labels)), dtype=truth.weights.dtype)
            truth = replace(truth, weights=np.concatenate((truth.weights, spread), axis=2))
        if units is not None:
            none = (0,) * len(labels)
            units = replace(units, profiles=tuple(tuple((n, rows + none) for n, rows in cell) for cell in units.profiles))
        listed = ", ".join(map(shown, labels))
        kept = "it is kept as a possible decision" if len(labels) == 1 else "they are kept as possible decisions"
        return replace(
            self,
            decisions=(*self.decisions, *labels),
            weights=np.concatenate((self.weights, nothing), axis=1),
            units=units,
            truth=truth,
            unknown=unknown,
            notes=(*self.notes, f"{listed} never occurred; {kept}"),
        )

    @property
    def without_truth(self) -> Law:
        """The same law, its true labels forgotten."""
        return self if self.truth is None else replace(self, truth=None, columns=replace(self.columns, truth=None))

    @cached_property
    def totals(self) -> NDArray[Any]:
        """Row sums, exact; for float rows use `row` instead."""
        sums: NDArray[Any] = self.weights.sum(axis=1)
        return sums

    @cached_property
    def starts(self) -> NDArray[np.int64]:
        """First row of each context that has rows, then the number of rows."""
        edges = np.flatnonzero(np.diff(self.cell_context)) + 1
        return np.concatenate(([0], edges, [len(self.cell_context)]))

    @cached_property
    def whole(self) -> bool:
        """Whether its counts are numbers of draws: whole, and not above 10^18."""
        if self.kind != "counts" or (self.scale != 1 and any(w % self.scale for w in self.weights.ravel().tolist())):
            return False
        return int(self.totals.max()) <= MAX_DRAWS * self.scale

    @property
    def floating(self) -> bool:
        """Whether the rows are floats."""
        return self.weights.dtype.kind == "f"

    @cached_property
    def float_sums(self) -> NDArray[np.float64]:
        """Row sums of float rows in float64, off by a relative n·2⁻⁵³ at most."""
        return least_and_sums(self.weights)[1]

    def float_rows(self, cells: NDArray[np.int64]) -> NDArray[np.float64]:
        """P(·|x,a) of the given cells in float64, each entry off by a relative (n + 4)·2⁻⁵³ at most, underflow aside."""
        weights, sums = (self.weights, self.float_sums) if self.floating else (self.weights, self.totals)
        if len(cells) < len(weights):
            weights, sums = weights[cells], sums[cells]
        return quotients(weights, sums)

    def row(self, cell: int) -> list[int]:
        """Weights of a cell as integers, up to a common factor (none for counts)."""
        values: list[Any] = self.weights[cell].tolist()
        return dyadic(values) if self.floating else values

    @cached_property
    def integer_rows(self) -> list[list[int]]:
        """All rows as `row` gives them."""
        listed: list[list[Any]] = self.weights.tolist()
        return [dyadic(row) for row in listed] if self.floating else listed

    @cached_property
    def compared(self) -> NDArray[np.bool_]:
        """Which cells are compared locally: those whose context has at least two."""
        sizes = np.diff(self.starts)
        return np.repeat(sizes >= 2, sizes)

    @cached_property
    def complete(self) -> bool:
        """Whether every group has a law in every context."""
        return len(self.cell_context) == len(self.groups) * len(self.contexts)

    @cached_property
    def cell_mass(self) -> tuple[int, ...]:
        """P(x,a) of each cell up to a common factor, as integers."""
        if self.population == "counts":
            return tuple(self.totals.tolist())
        return self.mass if self.mass is not None else (1,) * len(self.cell_context)

    @cached_property
    def global_groups(self) -> tuple[int, ...]:
        """Groups that the global quantities compare: those of positive mass; empty when those quantities are undefined."""
        if self.population == "equal" and not self.complete:
            return ()
        return tuple(sorted(self.groups_with_mass)) if len(self.groups_with_mass) > 1 else ()

    @cached_property
    def groups_with_mass(self) -> frozenset[int]:
        """Groups of positive mass; of counts every row has some."""
        if self.population == "counts":
            return frozenset(np.flatnonzero(np.bincount(self.cell_group)).tolist())
        return frozenset(a for a, m in zip(self.cell_group.tolist(), self.cell_mass, strict=True) if m > 0)

    @cached_property
    def mixing(self) -> tuple[NDArray[Any], dict[int, int]]:
        """Integers that mix the rows of a group into its global law.

        Returns
        -------
        coefficients : ndarray of object, shape (cells,)
            c such that Σ_x c(x,a)·row(x,a) is proportional to P(·|a).
        totals : dict of int to int
            For each group of positive mass the sum of that mixture, so that dividing by it gives P(·|a).
        """
        mass = self.cell_mass
        coefficients = [1 if self.population == "counts" else 0] * len(mass)
        sums = [sum(row) for row in self.integer_rows] if self.floating else self.totals.tolist()
        totals: dict[int, int] = {}
        for group in sorted(set(self.cell_group.tolist())):
            cells = [i for i in np.flatnonzero(self.cell_group == group).tolist() if mass[i] > 0]
            if not cells:
                continue
            if self.population == "counts":
                totals[group] = sum(mass[i] for i in cells)
                continue
            _, bottom = added([(0, total) for total in {sums[i] for i in cells}])
            for i in cells:
                coefficients[i] = mass[i] * (bottom // sums[i])
            totals[group] = bottom * sum(mass[i] for i in cells)
        return np.array(coefficients, dtype=object), totals

    @cached_property
    def mixed_rows(self) -> list[list[int]]:
        """P(·|a) of each of `global_groups`, as integers up to a common factor."""
        if not self.global_groups:
            return []
        if self.population == "counts" and self.weights.dtype == np.int64:
            mixed = np.zeros((len(self.groups), len(self.decisions)), dtype=np.int64)
            np.add.at(mixed, self.cell_group, self.weights)
            rows: list[list[int]] = mixed[list(self.global_groups)].tolist()
            return rows
        return [self.mixed_row(i) for i in range(len(self.global_groups))]

    def mixed_row(self, i: int) -> list[int]:
        """P(·|a) of one of `global_groups`, by its position, as integers up to a common factor."""
        if i not in self._mixtures:
            self._mixtures[i] = self._mixture(self.cells_of(self.global_groups[i]))
        return self._mixtures[i]

    @cached_property
    def _mixtures(self) -> dict[int, list[int]]:
        return {}

    def cells_of(self, group: int) -> list[int]:
        """The cells of a group that have mass."""
        return [cell for cell in np.flatnonzero(self.cell_group == group).tolist() if self.cell_mass[cell]]

    def _mixture(self, cells: Sequence[int]) -> list[int]:
        """The rows of some cells, mixed by their mass, as integers up to a common factor."""
        counts = self.population == "counts"
        rows = dyadic_rows(self.weights[cells]) if self.floating else self.weights[cells]
        totals = [1] * len(cells) if counts else rows.sum(axis=1).tolist()
        parts = []
        kinds: dict[int, list[int]] = {}
        for place, total in enumerate(totals):
            kinds.setdefault(total, []).append(place)
        for total, places in kinds.items():
            some = rows[places].astype(object)
            if not counts and self.mass is not None:
                some = some * np.array([[self.mass[cells[i]]] for i in places], dtype=object)
            parts.append((some.sum(axis=0), total))
        mixed = added(parts)[0].tolist()
        common = gcd(*mixed)
        return [v // common for v in mixed]

    @cached_property
    def mixed_floats(self) -> tuple[NDArray[np.float64], float, float]:
        """P(·|a) of each of `global_groups` in float64, the relative error of an entry, and what may be lost where one underflows."""
        rows = self.float_rows(np.arange(len(self.weights)))
        members = [self.cells_of(group) for group in self.global_groups]
        masses = [[self.cell_mass[cell] for cell in cells] for cells in members]
        shares = [np.array([m / total for m in mass]) for mass in masses for total in (sum(mass),)]
        mixed = np.array([share @ rows[cells] for share, cells in zip(shares, members, strict=True)])
        most = max(map(len, members), default=0)
        tiny = bool(np.any((rows < 2.0**-900) & np.asarray(self.weights > 0, dtype=np.bool_))) or any(
            (share < 2.0**-60).any() for share in shares
        )
        return mixed, (len(self.decisions) + most + 16) * 2.0**-53, 4 * (most + 1) * 2.0**-1074 * tiny

    @cached_property
    def independent(self) -> bool:
        """Whether X and A are independent under the population, exactly (every group in every context)."""
        if not self.complete:
            return False
        shape = (len(self.contexts), len(self.groups))
        if self.population == "counts" and self.totals.dtype == np.int64:
            near = self.totals.astype(np.float64).reshape(shape)
            apart = near * near.sum() - near.sum(axis=1)[:, None] * near.sum(axis=0)[None, :]
            if bool(np.any(np.abs(apart) > 1e-6 * near * near.sum())):
                return False
        mass = np.array(self.cell_mass, dtype=object).reshape(shape)
        by_context, by_group, total = mass.sum(axis=1), mass.sum(axis=0), mass.sum()
        return bool(np.all(mass * total == by_context[:, None] * by_group[None, :]))

    def context_label(self, index: int) -> dict[str, str]:
        """Context as a mapping from column to label."""
        return dict(zip(self.columns.context, self.contexts[index], strict=True))

    def group_label(self, index: int) -> dict[str, str]:
        """Group as a mapping from column to label."""
        return dict(zip(self.columns.group, self.groups[index], strict=True))


def _read(
    table: Any,
    decision: str,
    group: str | Sequence[str],
    context: str | Sequence[str] | None,
    kind: Kind,
    value: str | None,
    weight: str | None,
    missing: Missing,
    unit: str | Sequence[str] | None = None,
    truth: str | None = None,
    unknown: Sequence[str] = (),
) -> Law:
    if unknown or missing == "unknown":
        refuse_beside_unknown(kind, unit=names(unit), truth=truth)
    columns, unknown = Columns(decision, names(group), names(context), truth), names(unknown)
    if not columns.group:
        raise InputError("no group column was named; name at least one")
    evaluation = None
    if isinstance(table, Tally):
        from fairaudit.tables.evaluations.lost import refuse_samples, settled

        if value is not None:
            refuse_samples(table)
        table = settled(table, decision, columns.context, columns.group, missing=missing, unknown=unknown)
        evaluation = table.evaluation if value is None else None
    if evaluation is not None:
        from fairaudit.tables.evaluations.lost import refuse_other_draws

        refuse_other_draws(evaluation, names(unit), (*columns.context, *columns.group))
    coded = read_columns(
        table,
        decision,
        columns.group,
        columns.context,
        [c for c in (value, weight) if c is not None],
        missing,
        names(unit),
        ordered=value is None or isinstance(table, Tally),
        truth=truth,
        count=value if kind == "counts" else None,
        measured_in="decisions" if kind == "counts" else "rows",
        unknown=unknown,
    )
    u, x, a = coded.codes
    column = _probabilities(coded, value) if kind == "probabilities" and value is not None else None
    weights, scale = (coded.counts, 1) if column is not None or value is None else _counts(coded, value)
    unrecorded = unknown_rows(coded, weights)
    if unrecorded is not None:
        u, x, a, weights = (part[a >= 0] for part in (u, x, a, weights))
    cells, cell = distinct(x * len(coded.groups) + a)
    shape = (len(cells), len(coded.decisions))
    if shape[0] * shape[1] > MAX_ENTRIES:
        raise InputError(
            f"{shape[0]} combinations of context and group with {shape[1]} decisions are more than {MAX_ENTRIES} entries; "
            "use fewer context columns, or bin numeric ones"
        )
    flat = cell * shape[1] + u
    bottoms: NDArray[Any] | None = None
    if isinstance(column, NumberColumn):
        refuse_repeats(flat, coded, columns)
        matrix, bottoms = column.rows(flat, shape)
    else:
        matrix = np.zeros(shape, dtype=weights.dtype if column is None else column.dtype)
        if column is None:
            np.add.at(matrix.ravel(), flat, weights)
        else:
            refuse_repeats(flat, coded, columns)
            matrix.flat[flat] = column
    mass = None if weight is None else masses_of_cells(coded.values[weight], weight, cell, len(cells), coded.locate)
    full = matrix.sum(axis=1) > 0 if kind == "counts" else np.ones(len(cells), dtype=bool)
    units = sampling_units(coded, names(unit), cell, len(cells)) if unit else None
    return _finish(
        Law(
            columns=columns,
            decisions=tuple(coded.decisions),
            groups=tuple(coded.groups),
            contexts=tuple(coded.contexts),
            kind=kind,
            population="counts" if kind == "counts" else "equal" if mass is None else "weights",
            cell_context=cells[full] // len(coded.groups),
            cell_group=cells[full] % len(coded.groups),
            weights=matrix if full.all() else matrix[full],
            scale=scale,
            mass=mass,
            notes=(*coded.notes, *copies_of_units(coded, names(unit))) if unit else coded.notes,
            units=units,
            truth=spread_truth(coded, columns, weights, cell, len(cells), full),
            preparation=coded.preparation,
            unknown=unrecorded if unrecorded is not None and len(unrecorded.contexts) else None,
            rows_read=int(coded.counts.sum()),
            evaluation=evaluation,
            undecided=(MISSING_LABEL,) if missing == "undecided" and MISSING_LABEL in coded.decisions else (),
        ),
        bottoms,
    )


def _counts(coded: CodedTable, value: str) -> tuple[NDArray[Any], int]:
    """The counts of a column, each times how often its row occurs, and their denominator."""
    weights, scale = numbers(coded.values[value], value, coded.locate)
    if weights.dtype.kind == "f":
        weights, scale = exact_floats(weights)
    if (coded.counts > 1).any():
        weights = integers([w * n for w, n in zip(weights.tolist(), coded.counts.tolist(), strict=True)])
    return weights, scale


def _probabilities(coded: CodedTable, value: str) -> NDArray[np.float64] | NumberColumn:
    """The probabilities of a column, of which each row occurs once."""
    floats = float_numbers(coded.values[value], value, coded.locate)
    column = exact_numbers(coded.values[value], value, coded.locate, "share") if floats is None else floats
    if (coded.counts > 1).any():
        at = int(np.flatnonzero(coded.counts > 1)[0])
        raise InputError(f"{coded.locate(at)} occurs {coded.counts[at]} times; each combination has one row")
    return column


def _finish(law: Law, bottoms: NDArray[Any] | None = None) -> Law:
    """Refuse a law in which nothing can be compared, or whose rows do not sum to 1; note smaller residues."""
    if len(law.groups) < 2:
        raise InputError(f"there is only one group, {shown(', '.join(law.groups[0]))}; fairness compares at least two")
    if not len(law.cell_context):
        raise InputError("every count is zero; nothing is left to audit")
    residue = _check_sums(law, bottoms) if law.kind == "probabilities" else ""
    if residue:
        known = {"float_sums": law.float_sums} if law.floating else {}
        law = replace(law, notes=(*law.notes, residue))
        vars(law).update(known)
    return law


def _check_sums(law: Law, bottoms: NDArray[Any] | None) -> str:
    """Refuse rows whose sum is off 1 by more than 1e-6; describe the largest smaller residue, if any."""
    if bottoms is None:
        off = np.abs(law.float_sums - 1)
        for i in np.flatnonzero(~(off < 0.99e-6)).tolist():
            whole, bottom = common_denominator([v.as_integer_ratio() for v in law.weights[i].tolist()])
            if abs(sum(whole) - bottom) * TOLERANCE > bottom:
                raise _wrong_sum(law, i, Fraction(sum(whole), bottom))
        worst = float(off.max())
    else:
        off = np.abs(law.totals - bottoms)
        wrong = np.flatnonzero(off > bottoms // TOLERANCE)
        if len(wrong):
            i = max(wrong.tolist(), key=lambda i: Fraction(int(off[i]), int(bottoms[i])))
            raise _wrong_sum(law, i, Fraction(int(law.totals[i]), int(bottoms[i])))
        some = np.flatnonzero(off)
        worst = max((int(v) / int(bottom) or 5e-324 for v, bottom in zip(off[some], bottoms[some], strict=True)), default=0.0)
    return f"rows were normalised exactly; the largest sum is off 1 by {worst:.2g}" if worst else ""


def _wrong_sum(law: Law, cell: int, total: Fraction) -> InputError:
    labels = {**law.context_label(int(law.cell_context[cell])), **law.group_label(int(law.cell_group[cell]))}
    said = ", ".join(f"{name}={shown(text)}" for name, text in labels.items())
    return InputError(f"the probabilities of {said} sum to {_approximate(total)}; they must sum to 1 within 1e-6")


def _approximate(value: Fraction) -> str:
    try:
        return f"{float(value):.10g}"
    except OverflowError:
        return "more than 1e308"


def _from_array(
    array: Any,
    kind: Kind,
    decisions: Sequence[Any] | None,
    groups: Sequence[Any] | None,
    contexts: Sequence[Any] | None,
    population: Any,
    columns: Columns | None,
) -> Law:
    if kind not in ("counts", "probabilities"):
        raise InputError(f"kind={shown(kind)} is not accepted; use 'counts' or 'probabilities'")
    try:
        values = np.asarray(array)
    except ValueError:
        raise InputError("the rows of the array are not equally long; it is indexed [context, group, decision]") from None
    single = values.ndim == 2
    if single:
        values = values[None]
    if values.ndim != 3 or 0 in values.shape:
        raise InputError(f"an array of shape {np.shape(array)} is not indexed [context, group, decision]")
    x, a, u = values.shape
    matrix, scale, sums, bottoms = array_entries(values.reshape(x * a, u), kind)
    group_labels = axis_labels(groups, a, "groups")
    context_labels: list[Label] = [()] if single and contexts is None else axis_labels(contexts, x, "contexts")
    decision_labels = axis_labels(decisions, u, "decisions")
    if len(decision_labels[0]) != 1:
        raise InputError("a decision has one label")
    if columns is None:
        columns = Columns("decision", default_names("group", len(group_labels[0])), default_names("context", len(context_labels[0])))
    elif len(columns.group) != len(group_labels[0]) or len(columns.context) != len(context_labels[0]):
        raise InputError("the column names do not fit the number of parts of the labels")
    full = np.asarray(matrix.any(axis=1)) if sums is None else sums > 0
    cells = np.flatnonzero(full)
    mass = None if population is None else array_mass(population, kind, (x, a), full)
    law = Law(
        columns=columns,
        decisions=tuple(text for (text,) in decision_labels),
        groups=tuple(group_labels),
        contexts=tuple(context_labels),
        kind=kind,
        population="counts" if kind == "counts" else "equal" if mass is None else "weights",
        cell_context=cells // a,
        cell_group=cells % a,
        weights=matrix if full.all() else matrix[full],
        scale=scale,
        mass=mass,
    )
    if sums is not None and law.floating:
        vars(law)["float_sums"] = sums[full]
    return _finish(law, None if bottoms is None else bottoms[full])
