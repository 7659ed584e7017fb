"""Which column of a table is which, as far as names and labels say: a first command to try, and to correct."""

from __future__ import annotations

import re
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from fractions import Fraction
from functools import partial

from fairaudit.audits.column_names import (
    AGE,
    AMOUNT,
    BAD,
    CONTEXT,
    COSTS,
    COUNT,
    GOOD,
    HARM,
    HISTORY,
    IDENTIFIER,
    NEUTRAL,
    NOT,
    ORIGINS,
    OTHER,
    PROBABILITY,
    RACE,
    RATED,
    SCORE,
    SEX,
    SEXES,
    SLOT,
    SURVEY_WEIGHT,
    UNIT,
    WEIGHT,
    WINNER,
    YES,
    named,
    says,
)
from fairaudit.errors import InputError
from fairaudit.exact.rationals import parse_rational
from fairaudit.tables.engines.survey import Seen
from fairaudit.tables.label_meaning import looking_undecided
from fairaudit.tables.number_form import PLAIN, NumberForm
from fairaudit.tables.wide import Wide, is_total
from fairaudit.words import brief

__all__ = ["MANY", "NUMBERS", "UNNAMED", "Roles", "as_number", "cuts", "people", "proposed"]

MANY = 50
"""A column with more labels is neither a decision nor a context."""

GROUPS = 500
"""A column with more labels is no group."""

UNNAMED = "DECISION"
"""Stands in a command for a label that nobody could guess."""

CELL = 20
"""Rows that each combination of group and context has on average, or a context is left out."""

NUMBERS = 12
"""A column with more different numbers is a measurement."""

ABSENT = 20
"""A context of which a greater part than one in so many is missing would leave out too many rows."""

WORDS = 30
"""Labels that are longer on average are texts."""


@brief
@dataclass(frozen=True, repr=False)
class Roles:
    """What each column is taken for.

    Attributes
    ----------
    decision : str or None
        The column of what was decided.
    utility : str
        The label of it that is worth 1.
    burden : bool
        Whether that label is a harm.
    group, context : tuple of str
        Columns of attributes of people, and of what may rightly matter.
    bins : dict of str to tuple
        Edges of numbers that are cut into intervals.
    count, probability, weight : str or None
        Columns of numbers.
    unit : str or None
        A column of identifiers that repeat.
    missing : bool
        Whether a label is missing in one of them.
    utility_column : str or None
        Instead of a decision and its label, a column of numbers.
    slots : tuple of str
        Instead of a decision and groups, columns of candidates.
    winner : str or None
        Then who was chosen.
    wide : Wide or None
        Columns of counts of decisions, instead of one of decisions.
    said : tuple of str
        What is to be known before it is believed.
    errors : bool
        Whether samples of a log have no answer.
    where : tuple of str
        Conditions on the samples of a log that count.
    missing_samples : bool
        Whether a log holds fewer samples than it should.
    form : NumberForm
        How the texts of numbers are written, as far as that has to be declared.
    undecided : tuple of str
        Labels of the decision that look as if nothing has been decided.
    refused : tuple of str
        Those of them that were decided, and are worth nothing.
    """

    decision: str | None
    utility: str
    burden: bool
    group: tuple[str, ...]
    context: tuple[str, ...]
    bins: dict[str, tuple[Fraction, ...]] = field(default_factory=dict)
    count: str | None = None
    probability: str | None = None
    weight: str | None = None
    unit: str | None = None
    missing: bool = False
    utility_column: str | None = None
    slots: tuple[str, ...] = ()
    winner: str | None = None
    wide: Wide | None = None
    said: tuple[str, ...] = ()
    errors: bool = False
    where: tuple[str, ...] = ()
    missing_samples: bool = False
    form: NumberForm = PLAIN
    undecided: tuple[str, ...] = ()
    refused: tuple[str, ...] = ()


def as_number(text: str) -> Fraction | None:
    """The number that a label says, if it says one."""
    try:
        numerator, denominator = parse_rational(text)
    except InputError:
        return None
    return Fraction(numerator, denominator)


def proposed(columns: Sequence[Seen], rows: int, *, lexicon: Sequence[str] = ()) -> Roles:
    """Guess which column is which from names and labels.

    Parameters
    ----------
    columns : sequence of Seen
        What is in each column (`survey_log`).
    rows : int
        How many rows there are.
    lexicon : sequence of str
        Labels that look undecided besides those of the package.

    Returns
    -------
    Roles
        A guess, for people to correct.

    Examples
    --------
    >>> seen = [Seen("id", {"1": 1, "2": 1}, 40, 0), Seen("sex", {"f": 20, "m": 20}, 2, 0), Seen("denied", {"no": 30, "yes": 10}, 2, 0)]
    >>> found = proposed(seen, 40)
    >>> found.decision, found.utility, found.burden, found.group
    ('denied', 'yes', True, ('sex',))
    """
    whole = _without_totals(columns)
    return _Guess([seen for seen in whole if seen.levels and not seen.fault], rows, lexicon).roles()


def _without_totals(columns: Sequence[Seen]) -> list[Seen]:
    """Where rows say that they are totals: columns of words without the numbers that stand in as few rows, which are no labels."""
    totals = max((sum(count for label, count in seen.levels.items() if is_total(label)) for seen in columns), default=0)
    if not totals:
        return list(columns)

    def labels(seen: Seen) -> dict[str, int]:
        numbers = {label for label in seen.levels if as_number(label) is not None}
        few = sum(seen.levels[label] for label in numbers) <= totals and len(numbers) < len(seen.levels)
        return {label: count for label, count in seen.levels.items() if not (few and label in numbers)}

    return [
        replace(seen, levels=kept, different=seen.different - len(seen.levels) + len(kept)) for seen in columns for kept in (labels(seen),)
    ]


class _Guess:
    """The columns that have no role yet."""

    def __init__(self, columns: list[Seen], rows: int, lexicon: Sequence[str] = ()) -> None:
        self.rows, self.lexicon = rows, lexicon
        spread = {seen.name for seen in _spread(columns, rows)}
        self.left = [seen for seen in columns if seen.name not in spread]
        self.numbers = {seen.name: [as_number(text) for text in seen.levels] for seen in columns}

    def numeric(self, seen: Seen) -> bool:
        return all(value is not None for value in self.numbers[seen.name])

    def positive(self, seen: Seen) -> bool:
        """Whether it is a measurement that a ratio can be made of."""
        return self.numeric(seen) and seen.different > 2 and all(value is not None and value >= 0 for value in self.numbers[seen.name])

    def few(self, seen: Seen) -> bool:
        """Whether it has a few labels, or fewer numbers, which more than one row has."""
        most = NUMBERS if self.numeric(seen) else MANY
        return 2 <= seen.different <= most and (seen.different == 2 or seen.different < self.rows)

    def short(self, seen: Seen) -> bool:
        """Whether its labels are names and not texts."""
        return sum(map(len, seen.levels)) <= WORDS * len(seen.levels)

    def take(self, pattern: str, fits: Callable[[Seen], bool]) -> Seen | None:
        """The first column whose name and labels fit, which is then no longer free."""
        found = next((seen for seen in self.left if named(seen.name, pattern) and fits(seen)), None)
        if found is not None:
            self.left.remove(found)
        return found

    def roles(self) -> Roles:
        """Take the columns in the order in which their names say most."""
        choice = self._choice()
        if choice is not None:
            slots, winner = choice
            self._identifiers()
            contexts = self._contexts([], rows=self.rows)
            return Roles(None, "", False, (), tuple(seen.name for seen in contexts), slots=slots, winner=winner)
        count = self.take(COUNT, self._counts)
        probability = None if count else self.take(PROBABILITY, self._probabilities)
        weight = self.take(WEIGHT, self.numeric) if probability else None
        plain = count is None and probability is None
        weights = [] if probability else [seen for seen in self.left if self._survey_weight(seen)]
        self.left = [seen for seen in self.left if seen not in weights]
        unit = self._identifiers()
        decision = self._decision()
        scored = decision is None or (decision.different > 2 and self.positive(decision))
        groups, bins = self._groups(cut=plain)
        if decision is None:
            decision = self._measured()
            scored = decision is not None
        contexts = self._contexts(groups, rows=self.rows if plain else None)
        if decision is not None and not groups:
            groups, contexts = contexts[:1], contexts[1:]
        undecided = () if decision is None or scored else looking_undecided(decision.levels, self.lexicon)
        good, burden = ("", False) if decision is None else ("", _costs(decision)) if scored else _good(decision, undecided)
        chosen = [seen for seen in (decision, *groups, *contexts) if seen is not None]
        return Roles(
            None if scored else _name(decision),
            good,
            burden,
            tuple(seen.name for seen in groups),
            tuple(seen.name for seen in contexts),
            bins,
            count=_name(count),
            probability=_name(probability),
            weight=_name(weight),
            unit=_name(unit) if plain else None,
            missing=any(seen.missing for seen in chosen),
            utility_column=_name(decision) if scored else None,
            said=(
                *([f"column '{count.name}' looks like counts: --count {count.name}"] if count else []),
                *(f"column '{seen.name}' looks like a survey weight, which is no count" for seen in weights),
                *(() if decision is None else self._said(decision, good, burden=burden, scored=scored)),
            ),
            undecided=() if probability else undecided,
        )

    def _said(self, decision: Seen, good: str, *, burden: bool, scored: bool) -> tuple[str, ...]:
        """What is to be known of the decision before it is believed."""
        if scored:
            rated = named(decision.name, RATED)
            return ("--score and --above-median, in the place of --utility-column, ask who is above the median",) if rated else ()
        if self._bare(decision):
            return (f"that {good} in column '{decision.name}' is {_word(burden)} is a guess: only who made the table knows",)
        return ()

    def _bare(self, decision: Seen) -> bool:
        """Whether its labels are numbers, and its name does not say what a yes would be."""
        return self.numeric(decision) and named(decision.name, f"{NEUTRAL}|.*risk.*|u")

    def _choice(self) -> tuple[tuple[str, ...], str] | None:
        """Columns of candidates, and who of them was chosen: a column for each slot, or one that lists them."""
        lists = {seen.name: found for seen in self.left if (found := _listed(seen))}
        for winner in (seen for seen in self.left if named(seen.name, WINNER)):
            chosen = {(label.split() or [""])[0] for label in winner.levels}
            for name, known in lists.items():
                if name != winner.name and chosen <= known and not (winner.name in lists and named(name, WINNER)):
                    return self._taken((name,), winner)
            stems: dict[str, list[Seen]] = {}
            for seen in self.left:
                match = re.fullmatch(SLOT, seen.name.strip().lower())
                if match is not None and seen is not winner and not seen.missing and 2 <= seen.different <= GROUPS:
                    stems.setdefault(match.group(1), []).append(seen)
            for slots in stems.values():
                shown = {label for seen in slots for label in seen.levels}
                if len(slots) > 1 and set(winner.levels) <= shown and len(set(slots[0].levels) & set(slots[1].levels)) > 1:
                    return self._taken(tuple(seen.name for seen in slots), winner)
        return None

    def _taken(self, slots: tuple[str, ...], winner: Seen) -> tuple[tuple[str, ...], str]:
        self.left = [seen for seen in self.left if seen is not winner and seen.name not in slots]
        return slots, winner.name

    def _counts(self, seen: Seen) -> bool:
        """Whether it may say how often a row occurred: whole numbers; where its name may mean something else, no measurements beside it."""
        whole = all(value is not None and value >= 0 and value.denominator == 1 for value in self.numbers[seen.name])
        return whole and not (named(seen.name, "total|num(ber)?|size") and self._measured_beside(seen))

    def _survey_weight(self, seen: Seen) -> bool:
        """Whether it may say for how many people a row stands: a measurement of no person, by its name."""
        return named(seen.name, SURVEY_WEIGHT) and self.positive(seen) and seen.different > NUMBERS

    def _probabilities(self, seen: Seen) -> bool:
        """Whether it may be the probability of a row: from 0 to 1, with no measurements beside it."""
        return all(value is not None and 0 <= value <= 1 for value in self.numbers[seen.name]) and not self._measured_beside(seen)

    def _measured_beside(self, seen: Seen) -> bool:
        others = [other for other in self.left if other is not seen and self.numeric(other) and other.different > NUMBERS]
        return any(not named(other.name, f"{IDENTIFIER}|{WEIGHT}") for other in others)

    def _identifiers(self) -> Seen | None:
        """Set aside what names a row; one whose labels repeat says which rows are one draw."""
        repeated = None
        for seen in list(self.left):
            named_so = named(seen.name, IDENTIFIER) and (seen.different > MANY or seen.different == self.rows)
            if named_so or (named(seen.name, UNIT) and seen.different > NUMBERS):
                self.left.remove(seen)
                if NUMBERS < seen.different < self.rows and not seen.missing and not named(seen.name, ".*name.*"):
                    repeated = repeated or seen
        self.left = [
            seen for seen in self.left if not (self.numeric(seen) and seen.different == self.rows > NUMBERS and self._running(seen))
        ]
        return repeated

    def _running(self, seen: Seen) -> bool:
        """Whether it numbers the rows."""
        values = [value for value in self.numbers[seen.name] if value is not None]
        return all(value.denominator == 1 for value in values) and max(values) - min(values) < 2 * len(values)

    def _decision(self) -> Seen | None:
        """A column of few labels: by its name, else one of numbers by its name, else the one with the fewest that is nothing else."""

        def two(seen: Seen) -> bool:
            return seen.different == 2

        def fits(seen: Seen, least: Callable[[Seen], bool]) -> bool:
            return least(seen) and self.few(seen) and not named(seen.name, f"{RACE}|{SEX}|{AGE}")

        def of_nobody(seen: Seen) -> bool:
            return self.few(seen) and not named(seen.name, f"{RACE}|{SEX}|{AGE}|{OTHER}|{HISTORY}")

        def yes_or_no(seen: Seen) -> bool:
            return of_nobody(seen) and two(seen) and any(says(label, "yes|true|y|ja|oui|s[ií]") for label in seen.levels)

        def telling(seen: Seen) -> bool:
            return two(seen) and any(named(label, f"{YES}|{HARM}|{GOOD}|{BAD}|{NOT}|0") for label in seen.levels)

        def plain(seen: Seen, least: Callable[[Seen], bool]) -> bool:
            return least(seen) and of_nobody(seen) and (two(seen) or not self.numeric(seen))

        for least in (telling, two, self.few):
            for pattern in (GOOD, BAD):
                found = self.take(pattern, partial(fits, least=least))
                if found is not None:
                    return found
            found = self.take(f"{NEUTRAL}|{SCORE}|income", partial(plain, least=least))
            if found is not None:
                return found
        found = self._score(SCORE) or self.take(".*", yes_or_no) or self._score(AMOUNT)
        if found is not None:
            return found
        rest = [seen for seen in self.left if self.few(seen) and not named(seen.name, f"{RACE}|{SEX}|{AGE}|{OTHER}|{CONTEXT}|{HISTORY}")]
        rest = [seen for seen in rest if self._still_open(seen)] or rest
        found = min(rest, key=lambda seen: seen.different, default=None)
        if found is not None:
            self.left.remove(found)
        return found

    def _still_open(self, seen: Seen) -> bool:
        """Whether some of its labels look undecided, and others say in a word what was decided."""
        told = any(len(label) > 4 and says(label, f"{YES}|{HARM}") for label in seen.levels)
        return told and bool(looking_undecided(seen.levels, self.lexicon))

    def _score(self, pattern: str) -> Seen | None:
        """A measurement whose name says that people get more or less of it."""
        return self.take(pattern, lambda seen: self.positive(seen) and not named(seen.name, f"{RACE}|{SEX}|{AGE}|{HISTORY}"))

    def _measured(self) -> Seen | None:
        """Any measurement that is not of the person."""
        return self.take(
            ".*", lambda seen: self.positive(seen) and not named(seen.name, f"{RACE}|{SEX}|{AGE}|{HISTORY}|{OTHER}|{CONTEXT}|{IDENTIFIER}")
        )

    def _groups(self, *, cut: bool) -> tuple[list[Seen], dict[str, tuple[Fraction, ...]]]:
        """Race and sex; else age, cut into intervals where it is a number; else other attributes of people."""
        order = list(self.left)
        named_so = (
            self.take("race|ethnicity", self.few) or self.take(RACE, self.few) or self._labelled(ORIGINS),
            self.take(SEX, self.few) or self._labelled(SEXES),
        )
        found = [seen for seen in named_so if seen is not None]
        if found:
            return sorted(found, key=order.index), {}
        age = self.take(AGE, lambda seen: self.few(seen) or (self.numeric(seen) and cut))
        if age is not None:
            edges = () if self.few(age) else cuts(age.name, dict(zip(self.numbers[age.name], age.levels.values(), strict=True)))
            return [age], {age.name: edges} if edges else {}
        other = self.take(OTHER, lambda seen: 2 <= seen.different <= min(GROUPS, self.rows // 2) and self.short(seen))
        if other is not None:
            return [other], {}
        rest = [seen for seen in self.left if self.few(seen) and self.short(seen) and not named(seen.name, CONTEXT)]
        self.left = [seen for seen in self.left if seen not in rest[:1]]
        return rest[:1], {}

    def _labelled(self, pattern: str) -> Seen | None:
        """A column whose labels say of whom they are."""
        return self.take(".*", lambda seen: self.few(seen) and all(len(label) > 1 and named(label, pattern) for label in seen.levels))

    def _contexts(self, groups: list[Seen], rows: int | None) -> list[Seen]:
        """What may rightly matter, by its name, as long as each combination still has rows."""
        cells = 1
        for seen in groups:
            cells *= min(seen.different, MANY)
        found: list[Seen] = []
        for seen in self.left:
            of_labels = (
                2 <= seen.different <= MANY
                and not self.numeric(seen)
                and not all(named(label, "yes|no|true|false") for label in seen.levels)
            )
            fits = of_labels and named(seen.name, CONTEXT) and self.short(seen) and seen.missing * ABSENT <= self.rows
            if fits and (rows is None or cells * seen.different * CELL <= rows):
                found.append(seen)
                cells *= seen.different
        return found[:2]


def people(columns: Sequence[Seen], rows: int) -> tuple[tuple[str, ...], tuple[str, ...]]:
    """Groups and contexts among columns of labels of a table that has a row for each combination of them.

    Examples
    --------
    >>> people([Seen("dept", {"x": 2, "y": 2}, 2, 0), Seen("sex", {"f": 2, "m": 2}, 2, 0)], 4)
    (('sex',), ('dept',))
    """
    guess = _Guess(list(columns), rows)
    groups, _ = guess._groups(cut=False)
    contexts = [seen for seen in guess.left if 2 <= seen.different <= MANY]
    if not groups:
        groups, contexts = contexts[:1], contexts[1:]
    return tuple(seen.name for seen in groups), tuple(seen.name for seen in contexts[:2])


def cuts(name: str, counts: dict[Fraction | None, int]) -> tuple[Fraction, ...]:
    """Where to cut a column of numbers: ages at 25, 45 and 65, others at their quartiles.

    Examples
    --------
    >>> [str(edge) for edge in cuts("income", {Fraction(n): 1 for n in range(1, 101)})]
    ['26', '51', '76']
    """
    values = sorted((value, count) for value, count in counts.items() if value is not None)
    if not values:
        return ()
    if named(name, AGE):
        usual = tuple(edge for edge in (Fraction(25), Fraction(45), Fraction(65)) if values[0][0] < edge <= values[-1][0])
        if usual:
            return usual
    total, below = sum(count for _, count in values), 0
    edges: list[Fraction] = []
    for value, count in values:
        if below and 4 * below >= total * (len(edges) + 1) and len(edges) < 3:
            edges.append(value)
        below += count
    return tuple(edges)


def _spread(columns: Sequence[Seen], rows: int) -> list[Seen]:
    """Of attributes spread over columns of 0 and 1, one for each label, all columns but that whose label says yes, or the most common."""
    stems: dict[str, list[Seen]] = {}
    for seen in columns:
        stem, mark, label = seen.name.rpartition("_")
        if stem and mark and label and set(seen.levels) <= {"0", "1", "0.0", "1.0"}:
            stems.setdefault(stem, []).append(seen)
    found: list[Seen] = []
    for members in stems.values():
        ones = [sum(count for label, count in seen.levels.items() if label.startswith("1")) for seen in members]
        if len(members) > 1 and sum(ones) == rows:
            kept = next((seen for seen in members if says(seen.name.rpartition("_")[2], YES)), members[ones.index(max(ones))])
            found += [seen for seen in members if seen is not kept]
    return found


def _listed(seen: Seen) -> set[str]:
    """The candidates that each of its labels lists in some order; empty if they do not."""
    lists = [label.split() for label in seen.levels]
    known = {part for parts in lists for part in parts}
    same = len({len(parts) for parts in lists}) == 1 and all(len(set(parts)) == len(parts) > 1 for parts in lists)
    return known if same and len(lists) > 1 and len(known) <= max(GROUPS // 10, 2 * len(lists[0])) else set()


def _name(seen: Seen | None) -> str | None:
    return None if seen is None else seen.name


def _word(burden: bool) -> str:
    return "a harm" if burden else "good for people"


def _costs(decision: Seen) -> bool:
    """Whether more of a measurement is a harm."""
    return named(decision.name, COSTS) and not named(decision.name, GOOD)


def _good(decision: Seen, undecided: Sequence[str]) -> tuple[str, bool]:
    """The label that is worth something, and whether that is a harm: the name of the column says what its yes means.

    It is never one that looks undecided; where all do, a word in its place says that it is missing.
    """
    harms = named(decision.name, BAD) and not named(decision.name, GOOD)
    wanted = f"{HARM}|{BAD}" if harms else f"{YES}|{GOOD}"
    labels = [label for label in decision.levels if label not in undecided]
    found = next((label for label in labels if says(label, wanted)), None)
    if found is None and not harms:
        found, harms = next(((label, True) for label in labels if says(label, f"{HARM}|{BAD}")), (None, False))
    denied = [label for label in labels if named(label, NOT)]
    if found is None and len(denied) == 1 and len(labels) == 2:
        found = next(label for label in labels if label not in denied)
    return (next(iter(labels), UNNAMED) if found is None else found), harms
