"""Tables that ship with the package, each with the options that audit it."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from fairaudit.arguments import answered
from fairaudit.errors import InputError, nearest, shown
from fairaudit.tables.csv import CsvTable, read_csv
from fairaudit.words import brief

__all__ = ["EXAMPLES", "Example", "example"]


@brief
@dataclass(frozen=True, repr=False)
class Example:
    """A table that ships with the package.

    Attributes
    ----------
    name, title, source : str
        What it is and where it is from.
    decision, group, context, count, probability, utility : str
        Which column has which role (empty for none), and the utility, as the command line takes them. All are empty for an audit file,
        which says so itself.

    Examples
    --------
    >>> import fairaudit as fa
    >>> found = fa.example("ucb-admissions")
    >>> found.decision, found.group, found.context, found.count, found.utility
    ('Admit', 'Gender', 'Dept', 'Freq', 'Admitted')
    """

    name: str
    title: str
    source: str
    decision: str = ""
    group: str = ""
    context: str = ""
    utility: str = ""
    count: str = ""
    probability: str = ""

    @property
    def path(self) -> str:
        """Where the file is: a table, or an audit file if there is no decision column."""
        return str(Path(__file__).with_name("data") / f"{self.name}.{'csv' if self.decision else 'toml'}")

    def table(self) -> CsvTable:
        """Read the table."""
        return read_csv(self.path)


EXAMPLES = (
    Example(
        name="ucb-admissions",
        title="graduate admissions at Berkeley, 1973: six largest departments, 4,526 applicants",
        source="24 published counts: Bickel, Hammel and O'Connell, Science 187 (1975) 398-404",
        decision="Admit",
        group="Gender",
        context="Dept",
        utility="Admitted",
        count="Freq",
    ),
    Example(
        name="hr-navigation",
        title="which of two HR officers a delivery robot goes to, by document and by the profile in the first slot",
        source="synthetic: made up to show the format, not measured on any model",
        decision="chosen",
        group="slot_1,slot_2",
        context="document",
        utility="HR1",
        probability="probability",
    ),
    Example(
        name="hr-filtered",
        title="the same robot behind a privacy filter that tells the truth about the profiles, and about the document, in 70 % of cases",
        source="synthetic, as above; an audit file with a policy, filters, a declared floor and a target",
    ),
)


@answered
def example(name: str) -> Example:
    """Look an example up by name.

    Parameters
    ----------
    name : str
        Its name; ``fairaudit certify --list-examples`` lists them.

    Returns
    -------
    Example
        The table with the options that audit it.

    Raises
    ------
    InputError
        If there is none of that name.

    Examples
    --------
    >>> len(example("ucb-admissions").table())
    24
    """
    for entry in EXAMPLES:
        if entry.name == name:
            return entry
    raise InputError(f"there is no example {shown(name)}; {nearest(name, [e.name for e in EXAMPLES])}")
