"""Publication of a certificate whose small counts stay with those who may see them: what it needs, which groups it shows, what it says."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import chain

from fairaudit.errors import InputError
from fairaudit.publications.counts import Counts, Source
from fairaudit.publications.withheld import Arc, is_small, published
from fairaudit.tables.values import Label

__all__ = ["CHECKED", "WITHHELD", "Kept", "Private", "check_least", "check_salted", "has_small", "kept_back", "shown_only", "why_withheld"]

WITHHELD = "withheld"

LEAST_OF_ALL = 2

Kept = Mapping[tuple[str, ...], frozenset[Label]]
"""By the columns of a table, the groups in it that are withheld."""


CHECKED = "Checked when this was made: every statement of the certificate is true of its table (fairaudit verify)."


@dataclass(frozen=True)
class Private:
    """What a page says of a certificate that is not public.

    Attributes
    ----------
    commands : tuple of str
        What whoever has the certificate and its table runs.
    beside : bool
        Whether a CSV and a summary stand beside the page.
    paragraphs : tuple of str
        Who can check the page, and how.
    """

    commands: tuple[str, ...]
    beside: bool = False
    paragraphs: tuple[str, ...] = (
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


def check_least(least: int) -> None:
    """Refuse a least count that keeps nothing back.

    Raises
    ------
    InputError
        If it is below 2.
    """
    if least < LEAST_OF_ALL:
        raise InputError(f"--small {least} withholds nothing that could be hidden; give the least count to publish, 2 or more, such as 10")


def check_salted(source: Source) -> None:
    """Refuse a certificate from whose digest small counts can be guessed.

    Raises
    ------
    InputError
        If it holds its table, or the digest of a table without a salt.
    """
    if "header" in source.document["subject"]["table"]:
        why = "the certificate holds its table, whose digest has no salt that only you know"
    elif "salt" not in next(iter(source.lines)):
        why = "the digest of the table has no salt"
    else:
        return
    raise InputError(
        f"{why}: small counts could be guessed from a published digest; certify again with --no-table --confidence none, and give the "
        "table that is written beside the certificate with --table"
    )


def kept_back(counts: Counts, tables: Sequence[tuple[str, ...]], least: int) -> Kept:
    """Which groups are withheld in tables of the same people, each by some of the columns.

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

    Raises
    ------
    InputError
        If the tables are by more than two columns and there are several.

    Examples
    --------
    >>> groups = (("f", "a"), ("f", "b"), ("m", "a"), ("m", "b"))
    >>> counts = Counts(("sex", "race"), groups, (70, 23, 90, 130), (40, 20, 50, 60))
    >>> {by: sorted(labels) for by, labels in kept_back(counts, [("sex", "race")], 10).items()}
    {('sex', 'race'): [('f', 'b')]}
    >>> {by: len(labels) for by, labels in kept_back(counts, [("sex",), ("race",), ("sex", "race")], 10).items()}
    {('sex',): 0, ('race',): 0, ('sex', 'race'): 4}
    """
    if len({frozenset(by) for by in tables}) == 1:
        return {by: _small(counts.by(*by), least) for by in tables}
    columns = tuple(dict.fromkeys(chain.from_iterable(tables)))
    if len(columns) > 2:
        raise InputError(
            f"--small does not decide what tables by {', '.join(columns)} tell together; name one table, or those by two columns, with --by"
        )
    arcs = _circulation(counts, columns)
    wanted = {frozenset(by) for by in tables}
    order = [name for name in arcs if frozenset(column for column, _ in name) in wanted]
    order.sort(key=lambda name: (len(name), columns.index(name[0][0]) if len(name) == 1 else 0, -min(arcs[name].parts)))
    chosen = published(arcs, order, least)
    return {by: frozenset(group for group in counts.by(*by).groups if _name(by, group, columns) not in chosen) for by in tables}


Name = tuple[tuple[str, str], ...]
"""Of a group, the columns and its labels in them."""


def _name(by: Sequence[str], group: Label, columns: Sequence[str]) -> Name:
    labels = dict(zip(by, group, strict=True))
    return tuple((column, labels[column]) for column in columns if column in labels)


def _circulation(counts: Counts, columns: tuple[str, ...]) -> dict[Name, Arc]:
    """A table by two columns with its margins."""
    first, second = columns
    arcs: dict[Name, Arc] = {}
    for group, parts in _parts(counts.by(first)):
        arcs[_name((first,), group, columns)] = Arc("all", (first, *group), parts)
    for group, parts in _parts(counts.by(second)):
        arcs[_name((second,), group, columns)] = Arc((second, *group), "all", parts)
    for group, parts in _parts(counts.by(first, second)):
        arcs[_name(columns, group, columns)] = Arc((first, group[0]), (second, group[1]), parts)
    return arcs


def _parts(counts: Counts) -> list[tuple[Label, tuple[int, int]]]:
    """For each group those selected and those not."""
    return [(group, (s, n - s)) for group, n, s in zip(counts.groups, counts.applicants, counts.selected, strict=True)]


def _small(counts: Counts, least: int) -> frozenset[Label]:
    return frozenset(group for group, parts in _parts(counts) if is_small(parts, least))


def shown_only(counts: Counts, kept: Kept) -> Counts:
    """The groups of one table that are not withheld; of people of unknown group nothing is said."""
    hidden = kept[counts.columns]
    places = [place for place, group in enumerate(counts.groups) if group not in hidden]
    return Counts(
        counts.columns,
        tuple(counts.groups[place] for place in places),
        tuple(counts.applicants[place] for place in places),
        tuple(counts.selected[place] for place in places),
    )


def has_small(counts: Counts, least: int) -> bool:
    """Whether a group of people, or those of unknown group, have a count below the least one that is not 0."""
    people, taken = counts.unknown
    return any(0 < count < least for parts in (*(parts for _, parts in _parts(counts)), (taken, people - taken)) for count in parts)


def why_withheld(hidden: int, groups: int, least: int, *, linked: bool = False, done: str = "selected") -> str:
    """Say in a sentence how many groups of a table are withheld, and why.

    Examples
    --------
    >>> why_withheld(1, 7, 10)
    '1 of 7 groups is withheld: fewer than 10 in it were selected, or fewer than 10 were not.'
    >>> why_withheld(0, 7, 10)
    'No group is withheld: in each at least 10 were selected, and at least 10 were not.'
    """
    if not hidden:
        return f"No group is withheld: in each at least {least} were {done}, and at least {least} were not."
    said = f"{hidden} of {groups} groups {'is' if hidden == 1 else 'are'} withheld: "
    few = f"fewer than {least} in {'it' if hidden == 1 else 'each'} were {done}, or fewer than {least} were not"
    if not linked:
        return f"{said}{few}."
    return (
        f"{said}{few}, or the tables together would tell such a number of another group. Which of these it is is not said, since that "
        "would tell, too."
    )
