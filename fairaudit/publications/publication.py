"""What is published: a page of facts and sections with tables, the rows of the CSV and a summary; every rule fills this one shape."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

__all__ = ["AMISS", "Page", "Publication", "Section", "Table"]

AMISS = " What is missing or remarkable:"
"""Ends a lead below which that stands."""


@dataclass(frozen=True)
class Table:
    """A table on the page; the first cell of a row names it."""

    title: str
    head: tuple[str, ...]
    rows: tuple[tuple[str, ...], ...]
    notes: tuple[str, ...] = ()


@dataclass(frozen=True)
class Section:
    """A part of the page: paragraphs, then tables, then what is quoted."""

    title: str
    paragraphs: tuple[str, ...] = ()
    tables: tuple[Table, ...] = ()
    quotes: tuple[str, ...] = ()


@dataclass(frozen=True)
class Page:
    """What a page says. Labels in it are data, which the page makes harmless.

    Attributes
    ----------
    title : str
        Its heading.
    lead : str
        What it comes to, in a sentence or two: findings, no verdict.
    facts : tuple of (str, str)
        What it says first: of whom, when, from what.
    sections : tuple of Section
        In the order of the page.
    points : tuple of str
        A list below the lead.
    footer : str
        What the figures are, for the last line.
    """

    title: str
    lead: str
    facts: tuple[tuple[str, str], ...]
    sections: tuple[Section, ...]
    points: tuple[str, ...] = ()
    footer: str = "These are figures, not a verdict: nothing here says whether a law was kept. They are of this table alone"


@dataclass(frozen=True)
class Publication:
    """What a rule asks for, before it has a shape. Labels in it are data, which the page and the CSV make harmless.

    Attributes
    ----------
    page : Page
        For people.
    rule : str
        As the option names it: "four-fifths".
    header : tuple of str
        The columns of ``table.csv``.
    rows : tuple of tuple of str
        Its rows.
    summary : mapping
        What ``summary.json`` says beside the certificate's digest: texts, integers, truth values, lists and mappings of such.
    """

    page: Page
    rule: str
    header: tuple[str, ...]
    rows: tuple[tuple[str, ...], ...]
    summary: Mapping[str, Any]
