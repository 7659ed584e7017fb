"""Which column of a table is which, as far as names and labels say: a first command to try, and to correct."""

from __future__ import annotations

import re
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from fractions import Fraction

from fairaudit.errors import InputError
from fairaudit.exact.rationals import parse_rational
from fairaudit.tables.engines.survey import Seen
from fairaudit.words import brief

__all__ = ["MANY", "Roles", "as_number", "proposed"]

MANY = 50
"""A column with more labels is neither a decision nor a context."""

GROUPS = 500
"""A column with more labels is no group."""

CELL = 20
"""Rows that each combination of group and context has on average, or a context is left out."""

NUMBERS = 12
"""A column with more different numbers is a measurement."""

COUNT = r"n|freq(uency)?|counts?|num(ber)?|total|cases|size"
PROBABILITY = r"p|pr|prob(ability|abilities)?|share|rate"
WEIGHT = r"w|weights?|mass|population|prior"
IDENTIFIER = r"(row_?)?(names?|num|number|index)|column 1|x|unnamed.*|(.*[_ .-])?(id|ids|uuid|guid|key|no|nr)|case_?number|.*identifier"
RACE = r".*(race|ethnic|colou?r|afam|black|minority|hispanic|nationality|citizen|origin|caste).*"
SEX = r"(.*[_ .])?(sex|gender)([_ .].*)?|female|male"
AGE = r"(.*[_ .])?age([_ .]?(group|cat|category|band|range|class|bracket))?"
OTHER = (
    r".*(religion|disab|orientation|marital|married|pregnan|veteran|language|group|placebo|treatment_arm).*|a|s|names?|firstname|first_name"
)
CONTEXT = (
    r".*(dept|department|major|program|faculty|school|job|position|occupation|profession|role|class|model|document|scenario|prompt|question|"
    r"categor|stratum|branch|site|court|district|degree|jd|wanted|vacancy|task|context|crime|charge|city|region|county).*|.*place|x"
)
GOOD = (
    r".*(decision|outcome|hired?|admi(t|ssion)|accept|approv|grant|select|cho(sen|ice)|recommend|offer|promot|call(ed)?_?(back)?|callback|interview|"
    r"released?|surviv|answer|response|winner|first|eligib|award|funded|repaid|paid|passed?|graduat).*|u"
)
BAD = (
    r".*(den(y|ied|ial)|reject|refus|declin|default|recid|re_?offend|arrest|convict|guilt|sentenc|verdict|penalty|prison|jail|death|died?|search|"
    r"citation|fine[ds]?|fraud|churn|suspend|expel|expuls|fired|layoff|complain|bad|risk|delinquen|charged_?off).*"
)
NEUTRAL = r".*(result|label|predict|status|target|class|score_text|judg).*|y"
YES = (
    r"(yes|y|true|t|1|1\.0|.*(admit|accept|hire|approv|grant|select|chosen|recommend|releas|pass|surviv|promot|offer|success|good|positive|paid).*|first|"
    r"called?|callback|alive|lived)"
)
HARM = r"(yes|y|true|t|1|1\.0|.*(den|reject|refus|declin|default|recid|arrest|convict|guilt|death|died|bad|high|search|fraud|charged).*)"
NOT = r"(no|not|non|un|in|dis)[ _-]?.*|.*\bnot\b.*"


@brief
@dataclass(frozen=True)
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


def as_number(text: str, *, decimal_comma: bool = False) -> Fraction | None:
    """The number that a label says, if it says one."""
    try:
        numerator, denominator = parse_rational(text.replace(",", ".", 1) if decimal_comma else text)
    except InputError:
        return None
    return Fraction(numerator, denominator)


def proposed(columns: Sequence[Seen], rows: int, *, decimal_comma: bool = False) -> Roles:
    """Guess which column is which from names and labels.

    Parameters
    ----------
    columns : sequence of Seen
        What is in each column (`survey_log`).
    rows : int
        How many rows there are.
    decimal_comma : bool
        Whether numbers may have one.

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
    return _Guess([seen for seen in columns if seen.levels and not seen.fault], rows, decimal_comma).roles()


class _Guess:
    """The columns that have no role yet."""

    def __init__(self, columns: list[Seen], rows: int, decimal_comma: bool) -> None:
        self.left, self.rows = columns, rows
        self.numbers = {seen.name: [as_number(text, decimal_comma=decimal_comma) for text in seen.levels] for seen in columns}

    def numeric(self, seen: Seen) -> bool:
        return all(value is not None for value in self.numbers[seen.name])

    def few(self, seen: Seen) -> bool:
        """Whether it has a few labels, or fewer numbers."""
        return 2 <= seen.different <= (NUMBERS if self.numeric(seen) else MANY)

    def take(self, pattern: str, fits: Callable[[Seen], bool]) -> Seen | None:
        """The first column whose name and labels fit, which is then no longer free."""
        found = next((seen for seen in self.left if _named(seen, pattern) and fits(seen)), None)
        if found is not None:
            self.left.remove(found)
        return found

    def roles(self) -> Roles:
        """Take the columns in the order in which their names say most."""
        count = self.take(COUNT, self.numeric)
        probability = None if count else self.take(PROBABILITY, self.numeric)
        weight = self.take(WEIGHT, self.numeric) if probability else None
        plain = count is None and probability is None
        unit = self._identifiers() if plain else None
        if not plain:
            self._identifiers()
        decision = self._decision()
        groups, bins = self._groups()
        contexts = self._contexts(groups, rows=self.rows if plain else None)
        if decision is not None and not groups:
            groups, contexts = contexts[:1], contexts[1:]
        good, burden = ("", False) if decision is None else _good(decision)
        chosen = [seen for seen in (decision, *groups, *contexts, unit) if seen is not None]
        return Roles(
            _name(decision),
            good,
            burden,
            tuple(seen.name for seen in groups),
            tuple(seen.name for seen in contexts),
            bins,
            count=_name(count),
            probability=_name(probability),
            weight=_name(weight),
            unit=_name(unit),
            missing=any(seen.missing for seen in chosen),
        )

    def _identifiers(self) -> Seen | None:
        """Set aside what names a row; one whose labels repeat says which rows are one draw."""
        repeated = None
        for seen in [seen for seen in self.left if _named(seen, IDENTIFIER) and (seen.different > GROUPS or seen.different == self.rows)]:
            self.left.remove(seen)
            if MANY < seen.different < self.rows and not seen.missing and not _named(seen, ".*name.*"):
                repeated = repeated or seen
        self.left = [seen for seen in self.left if not (self.numeric(seen) and seen.different == self.rows > NUMBERS)]
        return repeated

    def _decision(self) -> Seen | None:
        """A column of few labels: by its name, else the one with the fewest that is no attribute of people."""

        def two(seen: Seen) -> bool:
            return seen.different == 2

        attributes = f"{RACE}|{SEX}|{AGE}|{OTHER}"
        for pattern, fits in ((GOOD, two), (BAD, two), (NEUTRAL, two), (GOOD, self.few), (BAD, self.few), (NEUTRAL, self.few)):
            found = self.take(pattern, lambda seen, fits=fits: fits(seen) and self.few(seen) and not _named(seen, f"{RACE}|{SEX}|{AGE}"))  # type: ignore[misc]
            if found is not None:
                return found
        rest = [seen for seen in self.left if self.few(seen) and not _named(seen, attributes)]
        found = min(rest, key=lambda seen: seen.different, default=None)
        if found is not None:
            self.left.remove(found)
        return found

    def _groups(self) -> tuple[list[Seen], dict[str, tuple[Fraction, ...]]]:
        """Race and sex; else age, cut into intervals where it is a number; else other attributes of people."""
        order = list(self.left)
        found = [seen for seen in (self.take(RACE, self.few), self.take(SEX, self.few)) if seen is not None]
        if found:
            return sorted(found, key=order.index), {}
        age = self.take(AGE, lambda seen: seen.different >= 2)
        if age is not None:
            if not self.numeric(age) or age.different <= NUMBERS:
                return [age], {}
            values = sorted(value for value in self.numbers[age.name] if value is not None)
            edges = [edge for edge in (Fraction(25), Fraction(45), Fraction(65)) if values[0] < edge <= values[-1]]
            if edges:
                return [age], {age.name: tuple(edges)}
        other = self.take(OTHER, lambda seen: 2 <= seen.different <= GROUPS)
        if other is not None:
            return [other], {}
        rest = [seen for seen in self.left if self.few(seen) and not _named(seen, CONTEXT)]
        self.left = [seen for seen in self.left if seen not in rest[:1]]
        return rest[:1], {}

    def _contexts(self, groups: list[Seen], rows: int | None) -> list[Seen]:
        """What may rightly matter, by its name, as long as each combination still has rows."""
        cells = 1
        for seen in groups:
            cells *= min(seen.different, MANY)
        found: list[Seen] = []
        for seen in self.left:
            of_labels = (
                2 <= seen.different <= MANY and not self.numeric(seen) and not all(_is(label, "yes|no|true|false") for label in seen.levels)
            )
            fits = of_labels and _named(seen, CONTEXT)
            if fits and (rows is None or cells * seen.different * CELL <= rows):
                found.append(seen)
                cells *= seen.different
        return found[:2]


def _name(seen: Seen | None) -> str | None:
    return None if seen is None else seen.name


def _named(seen: Seen, pattern: str) -> bool:
    return re.fullmatch(pattern, seen.name.strip().lower()) is not None


def _good(decision: Seen) -> tuple[str, bool]:
    """The label that is worth something, and whether that is a harm: the name of the column says what its yes means."""
    harms = _named(decision, BAD) and not _named(decision, GOOD)
    wanted = HARM if harms else YES
    found = next((label for label in decision.levels if _is(label, wanted) and not _is(label, NOT)), None)
    if found is None and not harms:
        found, harms = next(((label, True) for label in decision.levels if _is(label, HARM) and not _is(label, NOT)), (None, False))
    return (next(iter(decision.levels)) if found is None else found), harms


def _is(label: str, pattern: str) -> bool:
    return re.fullmatch(pattern, label.strip().lower()) is not None
