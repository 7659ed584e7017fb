"""Reading a table line by line, that of a policy behind filters included."""

from __future__ import annotations

import hashlib
import re
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from itertools import chain, product
from typing import NamedTuple

from .figures import Figures, Watcher
from .filters import Filter, mixed_laws, read_filters, seen_in_contexts
from .header import Cell, Header, Positive, UnknownRow, read_header
from .json_values import Labels, canonical_text, decoded, read_integer, read_list, read_object
from .laws import Law, expectation, gains_of, mean_of, reduced_law
from .rates import GivenTruth
from .rationals import ONE, Rational, over_common_denominator, read_rational, read_rationals, reduced, sum_of
from .table import Policy, Table
from .text import malformed, shown
from .work import grant_bytes

TOGETHER = 1 << 16  # bytes of lines for which work is granted at once, of which a document has that for a million beforehand
ROWS = 1 << 9  # different weights that are remembered: many cells of a large table have equal ones

# A line of most tables as the canonical text has it: two short integers and a list of rationals.
_PLAIN = re.compile(rb'\{"context":(0|[1-9][0-9]{0,17}),"group":(0|[1-9][0-9]{0,17}),"weights":\["([0-9/]+(?:","[0-9/]+)*)"\]\}\n')

_WHOLE = re.compile(rb'(?:0|[1-9][0-9]{0,17})(?:","(?:0|[1-9][0-9]{0,17}))*')  # whole numbers among them


def _read_row(
    value: object, where: str, header: Header, keys: Sequence[str], optional: Sequence[str] = ()
) -> tuple[dict[str, object], tuple[int, int], Law, Rational]:
    """Read a line with weights: its members, context and group, the law, and the sum of the weights."""
    members = read_object(value, where, ("context", "group", "weights", *keys), optional)
    weights, denominator = over_common_denominator(read_rationals(members["weights"], f"{where}.weights", len(header.decisions)))
    total = sum(weights)
    if total == 0:
        raise malformed(f"{where}.weights", "are all zero")
    if header.subject.kind != "counts" and total != denominator:
        raise malformed(f"{where}.weights", "are probabilities that do not sum to 1")
    return members, _read_place(members, where, header), reduced_law(weights, total), reduced(total, denominator)


def _read_place(members: Mapping[str, object], where: str, header: Header, prefix: str = "") -> tuple[int, int]:
    return (
        read_integer(members[f"{prefix}context"], f"{where}.{prefix}context", len(header.contexts)),
        read_integer(members[f"{prefix}group"], f"{where}.{prefix}group", len(header.groups)),
    )


def _given_with_cells(header: Header) -> list[str]:
    named = {"mass": header.subject.population == "weights", "utility": header.utility is None, "truth": header.truths is not None}
    return [key for key, is_there in named.items() if is_there]


def _read_given(
    members: Mapping[str, object], where: str, header: Header, weights: Sequence[int]
) -> tuple[Rational, Sequence[Rational | None]]:
    """Read the mass and the utility of a cell, so far as the lines give them."""
    mass = read_rational(members["mass"], f"{where}.mass", nonnegative=True) if "mass" in members else ONE
    if header.utility is not None:
        return mass, header.utility
    return mass, _read_utility(members["utility"], f"{where}.utility", weights)


def _read_utility(value: object, where: str, weights: Sequence[int]) -> tuple[Rational | None, ...]:
    entries: list[Rational | None] = []
    for i, (item, weight) in enumerate(zip(read_list(value, where, len(weights)), weights, strict=True)):
        if item is None and weight:
            raise malformed(f"{where}[{i}]", "is null where the weight is positive")
        entries.append(None if item is None else read_rational(item, f"{where}[{i}]"))
    return tuple(entries)


def read_table(
    lines: Iterable[tuple[str | Line, object, bytes | None]],
    keep: Callable[[Header], bool] = lambda _: True,
    positive: Positive | None = None,
    differences: bool = False,
    watchers: Sequence[Watcher] = (),
) -> Table:
    """Read a table from (where, value, its canonical text in the file or None if embedded), the header first.

    In the place of the value of a line of a file its plain parts may stand.  Cells are not kept where the header says that the figures
    of the table are all that is needed.  Figures given the true label need to know what is positive; differences of expectations are
    formed where they are asked for; watchers follow the cells of what is no policy.
    """
    digest = hashlib.sha256()
    reader: _Rows | None = None
    unread = 0  # bytes of the lines since the last time that work was granted for them
    for where, value, raw in lines:
        if reader is None:
            header = read_header(_members(value) if isinstance(value, re.Match) else value, str(where))
            if isinstance(value, dict) and "filters" in value:
                reader = _PolicyRows(header, differences, *read_filters(header, value["filters"], f"{where}.filters"))
            else:
                reader = _Rows(header, differences, keep(header), positive, watchers)
        elif isinstance(value, re.Match):
            reader.add_plain(value, where)
        else:
            reader.add(value, str(where))
        if raw is None:
            digest.update(canonical_text(value))
            continue
        digest.update(raw)
        unread += len(raw)
        if unread > TOGETHER:
            grant_bytes(unread)
            unread = 0
    grant_bytes(unread)
    if reader is None:
        raise malformed("the table", "is empty")
    return reader.table(digest.hexdigest())


def _members(plain: re.Match[bytes]) -> dict[str, object]:
    """The value of a plain line."""
    context, group, weights = plain.groups()
    return {"context": int(context), "group": int(group), "weights": weights.decode("ascii").split('","')}


class Line:
    """Where a line of a table file is; in words only where something is wrong with it."""

    __slots__ = ("number",)

    def __init__(self) -> None:
        self.number = 0

    def __str__(self) -> str:
        """Name the line."""
        return f"line {self.number} of the table"


class _Row(NamedTuple):
    """What follows from the weights of a line of whole counts."""

    law: Law
    mass: Rational
    expectation: Rational


class _Rows:
    """The lines of a table after its header, as they are read."""

    def __init__(
        self, header: Header, differences: bool, keep: bool = True, positive: Positive | None = None, watchers: Sequence[Watcher] = ()
    ) -> None:
        self.header, self.differences = header, differences
        self.given_truth = None if header.truths is None or positive is None else GivenTruth(header, positive)
        self.figures = Figures(header, differences=differences, watchers=watchers)
        self.kept: list[Cell] | None = [] if keep or header.unknown else None
        self.unknown: list[UnknownRow] = []
        self.keys = _given_with_cells(header)
        self.gains = None if header.utility is None else gains_of(header.utility)
        self.last = (-1, -1)
        self.counted = header.subject.kind == "counts" and not self.keys and not header.unknown and self.gains is not None
        self.known: dict[bytes, _Row] = {}

    def add_plain(self, plain: re.Match[bytes], where: str | Line) -> None:
        """Read one more line by its parts: context, group and weights.  Those of equal weights are read once."""
        x, a, text = plain.groups()
        row = self.known.get(text) or (self._row_of(text) if self.counted else None)
        context, group = int(x), int(a)
        place = context, group
        header = self.header
        if row is None or self.last >= place or context >= len(header.contexts) or group >= len(header.groups):
            self.add(_members(plain), str(where))
            return
        self.last = place
        cell = Cell(context, group, row.law, row.mass, row.expectation, header.utility or ())
        self.figures.add(cell)
        if self.kept is not None:
            self.kept.append(cell)

    def _row_of(self, text: bytes) -> _Row | None:
        """Read weights that are short whole numbers, if they are."""
        items = text.split(b'","')
        if len(items) != len(self.header.decisions) or not _WHOLE.fullmatch(text):
            return None
        weights = [*map(int, items)]
        total = sum(weights)
        if total == 0 or self.gains is None:
            return None
        law = reduced_law(weights, total)
        if len(self.known) >= ROWS:
            self.known.clear()
        self.known[text] = row = _Row(law, (total, 1), mean_of(*law, self.gains))
        return row

    def add(self, value: object, where: str) -> None:
        """Read one more line."""
        if self.header.unknown and isinstance(value, dict) and "unknown" in value:
            self.unknown.append(_read_unknown(value, where, self.header, self.unknown[-1].context if self.unknown else -1))
            return
        if self.unknown:
            raise malformed(where, "is a cell after the decisions of unknown group")
        members, place, law, total = _read_row(value, where, self.header, self.keys)
        mass, utility = _read_given(members, where, self.header, law[0]) if self.keys else (ONE, self.header.utility or ())
        if self.header.subject.kind == "counts":
            mass = total
        self.follow(place, where)
        if self.header.truths is not None:
            counts = _read_truth(members["truth"], f"{where}.truth", self.header, law, total)
            if self.given_truth is not None:
                self.given_truth.add(place, counts)
        cell = Cell(*place, law, mass, mean_of(*law, self.gains or gains_of(utility)), utility)
        self.figures.add(cell)
        if self.kept is not None:
            self.kept.append(cell)

    def follow(self, place: tuple[int, int], where: str) -> None:
        """Make sure that the lines are sorted."""
        if place <= self.last:
            raise malformed(where, "is not in increasing order of context and group")
        self.last = place

    def table(self, digest: str) -> Table:
        """Put the lines together."""
        figures = self.figures.of_all()
        if self.header.utility is None and not figures.cells:
            raise malformed("the table", "gives no utility at all")
        if self.header.unknown and not self.unknown:
            raise malformed("the table", "has no decisions of unknown group, though its header says so")
        _check_masses(self.header, figures.masses())
        kept = None if self.kept is None else tuple(self.kept)
        return Table(self.header, kept, figures.cells, digest, figures, given=self.given_truth, unknown=tuple(self.unknown))


def _read_unknown(value: object, where: str, header: Header, last: int) -> UnknownRow:
    """Read the decisions of unknown group in a context."""
    members = read_object(value, where, ("context", "unknown", *(("utility",) if header.utility is None else ())))
    context = read_integer(members["context"], f"{where}.context", len(header.contexts))
    if context <= last:
        raise malformed(where, "is not in increasing order of context")
    counts = read_rationals(members["unknown"], f"{where}.unknown", len(header.decisions))
    if not any(n for n, _ in counts):
        raise malformed(f"{where}.unknown", "are all zero")
    utility = header.utility or _read_utility(members["utility"], f"{where}.utility", [n for n, _ in counts])
    if any(g is not None and g[0] < 0 for g in utility):
        raise malformed(where, "has utilities below 0, of which differences alone could be stated")
    return UnknownRow(context, counts, utility)


def _read_truth(value: object, where: str, header: Header, law: Law, total: Rational) -> tuple[list[list[int]], int]:
    """Read how the weights of a row are spread over the true labels, as integers over one denominator."""
    size = len(header.decisions)
    parts = [read_rationals(item, f"{where}[{i}]", size) for i, item in enumerate(read_list(value, where, len(header.truths or ())))]
    flat, below = over_common_denominator([entry for part in parts for entry in part])
    counts = [flat[i : i + size] for i in range(0, len(flat), size)]
    weights, law_total = law
    for u, column in enumerate(zip(*counts, strict=True)):
        if sum(column) * law_total * total[1] != weights[u] * total[0] * below:
            raise malformed(where, "is spread over the true labels so that it does not sum to the weights")
    return counts, below


def _check_masses(header: Header, masses: Sequence[Rational]) -> None:
    if header.subject.population == "weights" and (not masses or sum_of(masses) != ONE):
        raise malformed("the table", "has masses that do not sum to 1")


def lines_of_file(lines: Iterable[bytes]) -> Iterator[tuple[Line, object, bytes]]:
    """Decode the lines of a table file, as ``read_table`` takes them, and make sure that they are canonical."""
    where = Line()
    for where.number, line in enumerate(lines, 1):
        if plain := _PLAIN.fullmatch(line):
            yield where, plain, line
            continue
        value = decoded(line, str(where))
        if line != canonical_text(value):
            raise malformed(str(where), "is not the canonical text of its value, ended by one line feed")
        yield where, value, line


def embedded_lines(lines: Sequence[object]) -> Iterator[tuple[str, object, None]]:
    """Name the lines of a table that a certificate holds, as ``read_table`` takes them."""
    yield "subject.table.header", lines[0], None
    for i, line in enumerate(lines[1:]):
        yield f"subject.table.rows[{i}]", line, None


class _PolicyRows(_Rows):
    """The lines of a policy's table: the rows of the policy, then the true cells if masses or utilities are given."""

    def __init__(self, header: Header, differences: bool, group: Filter, context: Filter | None, releases: int) -> None:
        super().__init__(header, differences)
        self.group, self.context, self.releases = group, context, releases
        self.true = replace(header, groups=tuple(self.group.inputs))
        if self.context is not None:
            self.true = replace(self.true, contexts=tuple(self.context.inputs))
        self.laws: dict[tuple[int, int], Law] = {}
        self.draws: dict[tuple[int, int], int] = {}
        self.given: list[tuple[Rational, Sequence[Rational | None]]] = []

    def add(self, value: object, where: str) -> None:
        """Read a row of the policy, or a true cell."""
        if isinstance(value, dict) and "true_group" in value:
            self._add_true_cell(value, where)
            return
        members, place, law, _ = _read_row(value, where, self.header, (), optional=("draws",))
        if self.given:
            raise malformed(where, "is a row of the policy after a true cell")
        self.follow(place, where)
        self.laws[place] = law
        if "draws" in members:
            self.draws[place] = read_integer(members["draws"], f"{where}.draws")
            if self.draws[place] == 0 or self.draws[place] % law[1]:  # the weights are in lowest terms over law[1]
                raise malformed(f"{where}.draws", "must be positive, and whole when multiplied with any of the weights")

    def _add_true_cell(self, value: object, where: str) -> None:
        keys = _given_with_cells(self.header)
        members = read_object(value, where, ("true_context", "true_group", *keys))
        place = _read_place(members, where, self.true, "true_")
        if not keys or place != divmod(len(self.given), len(self.true.groups)):
            raise malformed(where, "is not the next true cell, or none is needed")
        every = [1] * len(self.header.decisions)  # each decision has to have its utility
        self.given.append(_read_given(members, where, self.header, every))

    def _released(self) -> list[list[tuple[int, int]]]:
        """List the places of the policy's rows by reachable context and reachable group."""
        if (len(self.header.contexts) if self.context is None else self.context.released) * self.group.released > len(self.laws):
            raise malformed("the table", "lacks a row of the policy for what the filters can release")
        contexts = self.header.contexts if self.context is None else self.context.outputs
        groups = self.group.outputs
        places = self._rows_of(contexts, groups)
        if len(places) < len(contexts) * len(groups):
            x, a = next(labels for labels in product(contexts, groups) if labels not in places)
            raise malformed("the table", f"lacks a row of the policy for {shown(x)} and {shown(a)}, which can be released")
        return [[places[x, a] for a in groups] for x in contexts]

    def _rows_of(self, contexts: Sequence[Labels], groups: Sequence[Labels]) -> dict[tuple[Labels, Labels], tuple[int, int]]:
        """Find the places of the policy's rows, so far as there are any, for some contexts and groups."""
        context_at = {label: i for i, label in enumerate(self.header.contexts)}
        group_at = {label: i for i, label in enumerate(self.header.groups)}
        places = {(x, a): (context_at.get(x, -1), group_at.get(a, -1)) for x, a in product(contexts, groups)}
        return {labels: place for labels, place in places.items() if place in self.laws}

    def table(self, digest: str) -> Table:
        """Compute the law that the policy and its filters induce."""
        n_groups = len(self.true.groups)
        n = len(self.true.contexts) * n_groups
        if _given_with_cells(self.header) and len(self.given) != n:
            raise malformed("the table", "does not list every true cell")
        given = self.given or [(ONE, self.header.utility or ())] * n
        _check_masses(self.header, [mass for mass, _ in given])
        if self.draws and len(self.draws) < len(self.laws):
            raise malformed("the table", "gives draws for some rows of the policy only")
        released = self._released()
        rows = [[self.laws[place] for place in places] for places in released]
        draws = [[self.draws[place] for place in places] for places in released] if self.draws else []
        by_context = seen_in_contexts(rows, self.context)
        induced = chain.from_iterable(mixed_laws(laws, self.group.maps) for laws in by_context)
        raw = self._rows_of(self.true.contexts, self.true.groups)  # in the order of the true cells
        unfiltered = self._table((self.laws[place] for place in raw.values()), given, "", None) if len(raw) == n else None
        drawn = sum(self.draws.values())
        policy = Policy(self.group, self.context, rows, by_context, unfiltered, draws, self.header, drawn, self.releases)
        return self._table(induced, given, digest, policy)

    def _table(
        self, laws: Iterable[Law], given: Sequence[tuple[Rational, Sequence[Rational | None]]], digest: str, policy: Policy | None
    ) -> Table:
        cells = tuple(
            Cell(*divmod(i, len(self.true.groups)), law, mass, expectation(law, utility), utility)
            for i, (law, (mass, utility)) in enumerate(zip(laws, given, strict=True))
        )
        figures = Figures(self.true, expectations_only=policy is None, differences=self.differences and policy is not None)
        for cell in cells:
            figures.add(cell)
        return Table(self.true, cells, len(self.laws), digest, figures.of_all(), policy)
