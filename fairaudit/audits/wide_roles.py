"""Tables with several columns of counts in a row, as far as their names and numbers say: which count what, and of how many."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction

from fairaudit.audits.column_names import AGES, BAD, GOOD, HARM, ORIGINS, RUNNING, SEXES, YES, named, says
from fairaudit.audits.roles import UNNAMED, Roles, as_number, people
from fairaudit.tables.engines.survey import Seen
from fairaudit.tables.label_meaning import looking_undecided
from fairaudit.tables.wide import Wide, is_total

__all__ = ["ROWS", "wide_roles"]

ROWS = 5_000
"""A table with more rows has a row for each person, or is none that people wrote."""

WHOLE = (
    r"n|all|counts?|number|num|totals?|applicants?|applications?|applied|candidates?|cases|people|persons|population|size|sample|stops|stopped|"
    r"tests|tested|tried|trials|eligible|anzahl|bewerber|gesamt"
)
RATE = r"rates?|percent(age|ages)?|pct|perc|shares?|proportions?|prop|prob|ratio|quote|anteil|prozent|taux|%"
OPPOSITE = r"(no|not|non|un|in|dis|re)(?=.{2})"
PLAIN = ("", "n", "count", "number", "num", "total", "freq")


@dataclass(frozen=True)
class _Part:
    """What the name of a column says: a group, and what is counted."""

    name: str
    group: str
    stem: str
    values: tuple[Fraction, ...]

    @property
    def whole(self) -> bool:
        """Whether it is what others are a part of."""
        return all(re.fullmatch(f"{WHOLE}|of", word) for word in _words(self.stem)) and bool(self.stem)

    @property
    def rate(self) -> bool:
        return any(re.fullmatch(RATE, word) for word in _words(self.stem)) or "%" in self.name

    @property
    def counts(self) -> bool:
        return all(value.denominator == 1 for value in self.values)


def wide_roles(cells: Mapping[str, Sequence[str]], *, lexicon: Sequence[str] = ()) -> Roles | None:
    """Guess which columns count what.

    Parameters
    ----------
    cells : mapping of str to sequence of str
        The whole table, as texts.
    lexicon : sequence of str
        Labels that look undecided besides those known.

    Returns
    -------
    Roles or None
        A guess, for people to correct; None if nothing looks like columns of counts.

    Examples
    --------
    >>> table = {"dept": ["x", "y"], "men_yes": ["3", "4"], "men_no": ["5", "9"], "women_yes": ["2", "8"], "women_no": ["7", "7"]}
    >>> found = wide_roles(table)
    >>> found.wide.counts[:2], found.group, found.context
    ((('yes', 'men', 'men_yes'), ('no', 'men', 'men_no')), ('gender',), ('dept',))
    """
    rows = [row for row in zip(*cells.values(), strict=True) if not any(map(is_total, row))]
    if not rows:
        return None
    cells = dict(zip(cells, map(list, zip(*rows, strict=True)), strict=True))
    parts = [part for name in cells if (part := _part(name, cells[name])) is not None]
    if len(parts) < 2:
        return None
    return _in_headers(cells, parts, lexicon) or _in_rows(cells, parts, lexicon)


def _part(name: str, column: Sequence[str]) -> _Part | None:
    """A column of numbers of at least 0."""
    percent = [text.rstrip().removesuffix("%") for text in column]
    values = [as_number(text) for text in percent]
    if not values or named(name, RUNNING) or any(value is None or value < 0 for value in values):
        return None
    words = _words(name)
    own = [word for word in words if re.fullmatch(f"{SEXES}|{ORIGINS}|{AGES}", word)]
    group = own[0] if len(own) == 1 and len(words) > 1 else ""
    rest = [word for word in words if word != group]
    return _Part(name, group, " ".join(rest), tuple(value for value in values if value is not None))


def _words(name: str) -> list[str]:
    """The words of a name: of NoDeath and no_death the same."""
    apart = re.sub(r"(?<=[a-zà-ÿ])(?=[A-Z])", " ", name)
    return [word for word in re.split(r"[^\w%]+|_", apart.lower()) if word]


def _in_headers(cells: Mapping[str, Sequence[str]], parts: list[_Part], lexicon: Sequence[str]) -> Roles | None:
    """Where each group has columns of its own."""
    groups = list(dict.fromkeys(part.group for part in parts if part.group))
    if len(groups) < 2:
        return None
    held = {(part.stem, part.group): part for part in parts if part.group}
    stems = [stem for stem in dict.fromkeys(part.stem for part in parts) if all((stem, group) in held for group in groups)]
    of = {group: [held[stem, group] for stem in stems] for group in groups}
    chosen = _chosen(of[groups[0]], lexicon)
    if chosen is None:
        return None
    outcomes, whole = chosen
    places = [stems.index(part.stem) for part in outcomes]
    base = stems.index(whole.stem) if whole is not None else None
    for group in groups:
        if not _fit([of[group][at] for at in places], None if base is None else of[group][base]):
            return None
    counts = tuple((of[groups[0]][at].stem, group, of[group][at].name) for group in groups for at in places)
    totals = () if base is None else tuple((group, of[group][base].name) for group in groups)
    rest = [part.name for part in parts]
    contexts = _labels(cells, rest)
    kind = "gender" if re.fullmatch(SEXES, groups[0]) else "origin" if re.fullmatch(ORIGINS, groups[0]) else "age group"
    names = tuple(seen.name for seen in contexts if seen.different >= 2)[:2]
    return _roles(Wide(counts, totals), (kind,), names, lexicon, missing=any(seen.missing for seen in contexts if seen.name in names))


def _in_rows(cells: Mapping[str, Sequence[str]], parts: list[_Part], lexicon: Sequence[str]) -> Roles | None:
    """Where each group has rows of its own."""
    parts = [_Part(part.name, "", " ".join(_words(part.name)), part.values) for part in parts]
    chosen = _chosen(parts, lexicon)
    if chosen is None:
        return None
    outcomes, whole = chosen
    used = [part.name for part in (*outcomes, *([whole] if whole else []))]
    numeric = [part.name for part in parts if any(value.denominator > 1 for value in part.values)]
    columns = _labels(cells, [*used, *numeric, *(part.name for part in parts if part.whole or part.rate)])
    groups, contexts = people(columns, len(outcomes[0].values))
    rows = list(zip(*(cells[seen.name] for seen in columns), strict=True)) if columns else []
    if not groups or len(set(rows)) < len(rows):
        return None
    missing = any(seen.missing for seen in columns if seen.name in (*groups, *contexts))
    counts = tuple((part.name, "", part.name) for part in outcomes)
    if _fit(outcomes, whole):
        wide = Wide(counts, (("", whole.name),) if whole is not None else ())
        return _roles(wide, groups, contexts, lexicon, missing=missing)
    most = max(value for part in outcomes for value in part.values)
    if whole is None or most > 100 or len(outcomes) > 1:
        return None
    of = Fraction(1 if most <= 1 else 100)
    said = _why(outcomes[0], whole, of)
    return _roles(Wide(counts, (), of), groups, contexts, lexicon, weight=whole.name, said=(said,), missing=missing)


def _why(part: _Part, whole: _Part, of: Fraction) -> str:
    more = next((i for i, (value, all_) in enumerate(zip(part.values, whole.values, strict=True)) if value > all_), None)
    why = (
        "are not whole"
        if more is None
        else f"are no part of those in '{whole.name}' (row {more + 1}: {part.values[more]} of {whole.values[more]})"
    )
    what = "percentages" if of == 100 else "shares"
    return f"the numbers in '{part.name}' {why}, so that they are taken for {what}; counts are not made of them"


def _chosen(parts: list[_Part], lexicon: Sequence[str]) -> tuple[list[_Part], _Part | None] | None:
    """The columns of decisions, and that of all of them if it is needed."""
    whole = next((part for part in parts if part.whole and part.counts), None)
    outcomes = [part for part in parts if not part.whole and not part.rate]
    for part in outcomes:
        other = next((other for other in outcomes if other is not part and _opposite(part.stem, other.stem)), None)
        if other is not None and part.counts and other.counts:
            return ([part, other] if outcomes.index(part) < outcomes.index(other) else [other, part]), None
    said = [part for part in outcomes if _decides(part.stem)]
    if whole is None:
        return (said, None) if len(said) == 2 and len(outcomes) == 2 else None
    if not said:
        said = [part for part in parts if part.rate and not part.whole and _decides(part.stem)]
    said.sort(key=lambda part: _undecided(part.stem, lexicon))
    return (said[:1], whole) if said else None


def _undecided(label: str, lexicon: Sequence[str]) -> bool:
    """Whether a label looks undecided, as it is or as its words."""
    return bool(looking_undecided((label, " ".join(_words(label))), lexicon))


def _decides(stem: str) -> bool:
    return any(named(word, GOOD) or named(word, BAD) or says(word, YES) or says(word, HARM) for word in _words(stem))


def _opposite(one: str, other: str) -> bool:
    """Whether two names say the contrary of each other, once what they count is left out."""
    first, second = (" ".join(word for word in _words(stem) if word not in PLAIN) for stem in (one, other))
    pairs = {("yes", "no"), ("ja", "nein"), ("oui", "non"), ("1", "0"), ("true", "false"), ("survived", "died"), ("admitted", "rejected")}
    pairs |= {("accepted", "rejected"), ("approved", "denied"), ("passed", "failed"), ("pass", "fail"), ("hired", "rejected")}
    pairs |= {("success", "failure"), ("successes", "failures"), ("dead", "alive"), ("granted", "denied"), ("accept", "reject")}
    if (first, second) in pairs:
        return True
    joined, bare = second.replace(" ", ""), first.replace(" ", "")
    return bool(bare) and re.sub(f"^{OPPOSITE}", "", joined) == bare and joined != bare


def _fit(outcomes: Sequence[_Part], whole: _Part | None) -> bool:
    """Whether numbers can be counts, and no more than all."""
    if not all(part.counts for part in outcomes) or max(value for part in outcomes for value in part.values) <= 1:
        return False
    if whole is None:
        return True
    sums = [sum(values) for values in zip(*(part.values for part in outcomes), strict=True)]
    return all(added <= all_ for added, all_ in zip(sums, whole.values, strict=True)) and not any(part.rate for part in outcomes)


def _labels(cells: Mapping[str, Sequence[str]], numeric: Sequence[str]) -> list[Seen]:
    """Columns that are labels, without those that number the rows."""
    found = []
    for name, column in cells.items():
        if name in numeric or (named(name, RUNNING) and len(set(column)) == len(column)):
            continue
        levels = Counter(text for text in column if text.strip())
        found.append(Seen(name, dict(levels), len(levels), len(column) - levels.total()))
    return [seen for seen in found if seen.levels]


def _roles(
    wide: Wide,
    group: tuple[str, ...],
    context: tuple[str, ...],
    lexicon: Sequence[str],
    *,
    weight: str | None = None,
    said: tuple[str, ...] = (),
    missing: bool = False,
) -> Roles:
    """The decision that is good for people, or a harm; where all look undecided, a word in its place says that it is missing."""
    labels = list(dict.fromkeys(decision for decision, _, _ in wide.counts))
    labels = [label for label in labels if not _undecided(label, lexicon)]
    good = next(
        (label for label in labels if any(says(word, YES) or named(word, GOOD) for word in _words(label)) and not _negative(label)), None
    )
    harm = next(
        (label for label in labels if any(says(word, HARM) or named(word, BAD) for word in _words(label)) and not _negative(label)), None
    )
    burden = good is None and harm is not None
    counted = good or harm or next(iter(labels), UNNAMED)
    return Roles("decision", counted, burden, group, context, weight=weight, wide=wide, said=said, missing=missing)


def _negative(label: str) -> bool:
    return bool(re.match(r"(no|not|non)(?![a-z])", " ".join(_words(label))))
