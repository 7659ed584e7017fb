"""Publication of a certificate whose small counts stay with those who may see them: what it needs, which groups it shows, what it says."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import chain

from fairaudit.errors import InputError
from fairaudit.publications.circulation import LEAST, Arc, Parts, is_small, published
from fairaudit.publications.counts import Counts, Decisions, Source
from fairaudit.tables.values import Label
from fairaudit.words import noun

__all__ = [
    "BESIDES",
    "CHECKED",
    "MOST_CELLS",
    "WHO",
    "Place",
    "Private",
    "Withholding",
    "by_label",
    "check_hidden",
    "chosen_of_two",
    "least_shown",
    "parts_of",
    "remark_on_small",
    "said_of",
    "why_withheld",
    "withholding_of",
]

LEAST_OF_ALL = 2

MOST_CELLS = 400
"""Of tables that are linked: the time grows with their square."""


WHO = (
    (
        "The public cannot recompute these figures. The certificate and its table tell the counts that are withheld, so that neither "
        "is published, nor the digest of the certificate, from which they could be guessed."
    ),
    (
        "Whoever was given both, such as a regulator or the other party of a contract, checks that every statement is true of the "
        "table, makes this page again and compares the two. The digest says which table it was: it is salted, and the salt stands "
        "in the file of the table alone."
    ),
)
"""Who can check a page that withholds counts."""

BESIDES = "How many decisions were left out, if any, is not said here."
"""What a page that withholds counts says of what was done before they were counted."""

CHECKED = "Checked when this was made: every statement of the certificate is true of its table (fairaudit verify)."


@dataclass(frozen=True)
class Private:
    """What a page says of a certificate that is not public.

    Attributes
    ----------
    least : int
        The least count that is published.
    commands : tuple of str
        What whoever has the certificate and its table runs.
    beside : bool
        Whether a CSV and a summary stand beside the page.
    """

    least: int
    commands: tuple[str, ...]
    beside: bool = False


def check_hidden(source: Source, least: int) -> None:
    """Refuse what small counts could be computed or guessed from whatever is withheld.

    Raises
    ------
    InputError
        If the least count is below 2, the certificate holds its table or the digest of one without a salt, or its decisions say how many of
        all there are of each kind.
    """
    if least < LEAST_OF_ALL:
        raise InputError(f"--small {least} withholds nothing that could be hidden; give the least count to publish, 2 or more, such as 10")
    if "evaluation" in source.document["subject"]:
        raise InputError(
            "--small does not go with an evaluation log: its certificate says how many answers there are of each kind, from which anybody "
            "could compute what is withheld"
        )
    for entry in source.document["subject"].get("preparation", ()):
        if entry["step"] == "above median":
            raise InputError(
                "--small does not go with scores above their median: everybody knows that half of all are, and could compute what is "
                "withheld; certify with --above and a number that was chosen before"
            )
    if "header" in source.document["subject"]["table"]:
        why = "the certificate holds its table, whose digest has no salt that only you know"
    elif "salt" not in next(source.lines):
        why = "the digest of the table has no salt"
    else:
        return
    raise InputError(
        f"{why}: small counts could be guessed from a published digest; certify again with --no-table --confidence none, and give the "
        "table that is written beside the certificate with --table"
    )


@dataclass(frozen=True)
class Withholding:
    """Which groups are withheld.

    Attributes
    ----------
    least : int
        The least count that is not small.
    kept : mapping of tuple of str to frozenset of Label
        By the columns of a table, the groups in it that are.
    linked : bool
        Whether some may be withheld for the sake of others.
    done : str
        What is said of those who are counted in a rate.
    """

    least: int
    kept: Mapping[tuple[str, ...], frozenset[Label]]
    linked: bool = False
    done: str = "selected"


def why_withheld(least: int, hidden: int, groups: int, *, linked: bool = False, done: str = "selected") -> str:
    """Say how many groups of a table are withheld, and why.

    Examples
    --------
    >>> why_withheld(10, 1, 7)
    '1 of 7 groups is withheld: fewer than 10 in it were selected, or fewer than 10 were not.'
    >>> why_withheld(10, 0, 7)
    'No group is withheld: in each at least 10 were selected, and at least 10 were not.'
    """
    if not hidden:
        return f"No group is withheld: in each at least {least} were {done}, and at least {least} were not."
    said = f"{hidden} of {groups} {noun(groups, 'group')} {'is' if hidden == 1 else 'are'} withheld: "
    few = f"fewer than {least} in {'it' if hidden == 1 else 'each'} were {done}, or fewer than {least} were not"
    if not linked:
        return f"{said}{few}."
    return (
        f"{said}{few}, or the tables together would tell such a number of another group. Which of these it is is not said, since that "
        "would tell, too."
    )


def least_shown(least: int) -> tuple[str, str]:
    """For the head of a page."""
    return "Least count shown", f"{least}; what is below, 0 included, is withheld"


def said_of(withholding: Withholding | None) -> list[tuple[str, str]]:
    """What the head of a page says of what is withheld."""
    return [] if withholding is None else [least_shown(withholding.least)]


def withholding_of(counts: Counts, tables: Sequence[tuple[str, ...]], least: int, done: str = "selected") -> Withholding:
    """Decide which groups are withheld in tables of the same people, each by some of the columns.

    Of one table those are withheld that have a small count: nothing published depends on them.  Tables by one column and by two are linked,
    since one's groups are sums of the other's: then the groups by one column are published first, and those by two as far as nothing small
    can be computed from all of them together.

    Parameters
    ----------
    counts : Counts
        The people.
    tables : sequence of tuples of str
        The columns of each table.
    least : int
        The least count that is not small.
    done : str
        What is said of those who are counted in a rate.

    Raises
    ------
    InputError
        If the tables are by more than two columns and there are several.

    Examples
    --------
    >>> groups = (("f", "a"), ("f", "b"), ("m", "a"), ("m", "b"))
    >>> counts = Counts(("sex", "race"), groups, (70, 23, 90, 130), (40, 20, 50, 60))
    >>> {by: sorted(labels) for by, labels in withholding_of(counts, [("sex", "race")], 10).kept.items()}
    {('sex', 'race'): [('f', 'b')]}
    >>> {by: len(labels) for by, labels in withholding_of(counts, [("sex",), ("race",), ("sex", "race")], 10).kept.items()}
    {('sex',): 0, ('race',): 0, ('sex', 'race'): 4}
    """
    if len({frozenset(by) for by in tables}) == 1:
        small = {by: {group for group, parts in _parts(counts.by(*by)) if is_small(parts, least)} for by in tables}
        return Withholding(least, {by: frozenset(groups) for by, groups in small.items()}, done=done)
    columns = tuple(dict.fromkeys(chain.from_iterable(tables)))
    if len(columns) > 2:
        raise InputError(
            f"--small does not decide what tables by {', '.join(columns)} tell together; name one table, or those by two columns, with --by"
        )
    cells = {(group[0], group[1]): parts for group, parts in _parts(counts.by(*columns))}
    if len(cells) > MOST_CELLS:
        raise InputError(
            f"--small does not decide what tables of {len(cells)} groups tell together ({MOST_CELLS} at the most); name one table with --by"
        )
    chosen = chosen_of_two(cells, least, [*map(frozenset, tables)], (columns[0], columns[1]))
    kept = {by: frozenset(group for group in counts.by(*by).groups if _place(by, group, columns) not in chosen) for by in tables}
    return Withholding(least, kept, linked=True, done=done)


Place = tuple[str | None, str | None]
"""A group by two columns: None where its table is not about one of them, and where a label is unknown or not recorded."""


def _place(by: Sequence[str], group: Label, columns: Sequence[str]) -> Place:
    labels = dict(zip(by, group, strict=True))
    return labels.get(columns[0]), labels.get(columns[1])


def chosen_of_two(
    cells: Mapping[tuple[str, str], Parts], least: int, tables: Sequence[frozenset[str]], columns: tuple[str, str]
) -> frozenset[Place]:
    """Which groups may be published of tables by two columns, by either of them, or by some of these.

    Parameters
    ----------
    cells : mapping of (str, str) to tuple of int
        For each pair of labels how many people there are of each kind; pairs that are not there are known to have nobody.
    least : int
        The least count that is not small.
    tables : sequence of frozenset of str
        The columns of each table that is to be published.
    columns : (str, str)
        Both columns.

    Returns
    -------
    frozenset of (str or None, str or None)
        The groups; None for a column that their table is not about.
    """
    sums: tuple[dict[str, Parts], dict[str, Parts]] = ({}, {})
    for labels, parts in cells.items():
        for margin, label in zip(sums, labels, strict=True):
            margin[label] = tuple(map(sum, zip(margin.get(label, (0,) * len(parts)), parts, strict=True)))
    arcs: dict[Place, Arc] = {(label, None): Arc("all", (0, label), parts) for label, parts in sums[0].items()}
    arcs |= {(None, label): Arc((1, label), "all", parts) for label, parts in sums[1].items()}
    arcs |= {labels: Arc((0, labels[0]), (1, labels[1]), parts) for labels, parts in cells.items()}
    wanted = [name for name in arcs if frozenset(c for c, label in zip(columns, name, strict=True) if label is not None) in tables]
    wanted.sort(key=lambda name: (len(name) - name.count(None), name[0] is None, -min(arcs[name].parts), name[0] or "", name[1] or ""))
    return published(arcs, wanted, least)


def _parts(counts: Counts) -> list[tuple[Label, tuple[int, int]]]:
    """For each group those selected and those not."""
    return [(group, (s, n - s)) for group, n, s in zip(counts.groups, counts.applicants, counts.selected, strict=True)]


def parts_of(counts: Counts, tables: Sequence[tuple[str, ...]], withholding: Withholding | None) -> list[Counts]:
    """The groups of each table; where some are withheld nothing of these, nor of people of unknown group."""
    whole = [counts.by(*by).known() for by in tables]
    return whole if withholding is None else [_shown_only(part, withholding) for part in whole]


def _shown_only(counts: Counts, withholding: Withholding) -> Counts:
    hidden = withholding.kept[counts.columns] & {*counts.groups}
    places = sorted((place for place, group in enumerate(counts.groups) if group not in hidden), key=counts.groups.__getitem__)
    return Counts(
        counts.columns,
        tuple(counts.groups[place] for place in places),
        tuple(counts.applicants[place] for place in places),
        tuple(counts.selected[place] for place in places),
        withheld=tuple(sorted(hidden)),
        why=why_withheld(withholding.least, len(hidden), len(counts.groups), linked=withholding.linked, done=withholding.done),
    )


def by_label(decisions: Decisions) -> Decisions:
    """Decisions whose kinds are in the order of their labels: that of the log may tell which kind nobody of its first group got."""
    places = sorted(range(len(decisions.labels)), key=decisions.labels.__getitem__)

    def ordered(counts: Sequence[int]) -> tuple[int, ...]:
        return tuple(counts[place] for place in places)

    return replace(
        decisions,
        labels=tuple(decisions.labels[place] for place in places),
        counts=tuple(map(ordered, decisions.counts)),
        unknown=ordered(decisions.unknown),
    )


def remark_on_small(counts: Counts) -> str:
    """What to say where small counts are published; empty where there are none."""
    people, taken = counts.unknown
    listed = (*(parts for _, parts in _parts(counts)), (taken, people - taken))
    if not any(0 < count < LEAST for parts in listed for count in parts):
        return ""
    return (
        f"a group has fewer than {LEAST} people selected, or fewer than {LEAST} who were not; all counts are published: "
        f"--small {LEAST} withholds such groups"
    )
