"""Labels that are one label in several spellings: found, and, if that is asked for, merged before a log is counted."""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any
from unicodedata import normalize, ucd_3_2_0

import numpy as np
from numpy.typing import NDArray

from fairaudit.arguments import answered
from fairaudit.errors import InputError, nearest, shown
from fairaudit.tables.columns import label_codes
from fairaudit.tables.csv import CsvTable
from fairaudit.tables.label_text import label_text
from fairaudit.tables.preparation import Entry, merged_labels
from fairaudit.tables.sources import Table
from fairaudit.tables.tally import Tally, counted, merged
from fairaudit.tables.values import ByLabel, LabelLike, column, locator, names
from fairaudit.words import brief

__all__ = ["PreparedTable", "merge_labels", "read_label_map", "spellings", "spelt_alike"]

NUMBER = re.compile(r"([+-]?)([0-9]*)(?:\.([0-9]*))?(?:e([+-]?[0-9]{1,4}))?")
STARTS = frozenset("+-.0123456789")
LONGEST_SPELLING = 1000  # characters of labels that are compared with other spellings; longer ones are only ever themselves
LabelMap = Mapping[str, ByLabel[LabelLike]]
"""For columns the new labels of old ones."""


def spellings(columns: Iterable[tuple[str, Iterable[str]]]) -> tuple[dict[str, Any], ...]:
    """Find labels of one column that differ in case, blanks or Unicode form alone, or are the same number.

    Labels with characters that Unicode 3.2 does not have are passed over, so that every later version finds the same, and so are
    labels of more than 1000 characters.

    Parameters
    ----------
    columns : iterable of (str, iterable of str)
        Names of columns with their different labels.

    Returns
    -------
    tuple of dict
        What the certificate has under ``spellings``: a column and labels of it, for each label that has several spellings.

    Examples
    --------
    >>> spellings([("race", ["Black", "White", "BLACK", "black "]), ("n", ["1", "2", "01.0"])])
    ({'column': 'race', 'labels': ['BLACK', 'Black', 'black ']}, {'column': 'n', 'labels': ['01.0', '1']})
    """
    found: list[dict[str, Any]] = []
    for name, labels in columns:
        labels, known = list(labels), dict[str, list[str]]()
        for label in () if _plainly_different(labels) else labels:
            if _settled(label):
                folded = _folded(label)
                known.setdefault(_number(folded) or folded, []).append(label)
        several = sorted(sorted(alike) for alike in known.values() if len(alike) > 1)
        found += [{"column": name, "labels": alike} for alike in several]
    return tuple(found)


@answered
def merge_labels(table: Table, columns: str | Sequence[str], *, fold: bool = False, label_map: LabelMap | None = None) -> Table:
    """Write labels in one way before a table is counted; the certificate records what was merged.

    First each label that `label_map` lists becomes the one that it says (once: a new label is not looked up again). Then, with `fold`,
    labels that differ in case, blanks (leading, trailing, several for one) or Unicode form alone become one: the new label of the map if
    one is among them, else the spelling that most rows have, of equally frequent ones the first by code point.

    Parameters
    ----------
    table : Tally, CsvTable, mapping of str to sequence, or frame of pandas or polars
        What `Law` and `Utility` take; other frames and files are counted by `read_log` first.
    columns : str or sequence of str
        The label columns: decision, groups, contexts. Not sampling units, whose labels are names of draws.
    fold : bool
        Whether to merge spellings.
    label_map : mapping of str to mapping, optional
        For columns the new labels of old ones.

    Returns
    -------
    Tally, CsvTable or PreparedTable
        The table with the labels merged, for `Law.from_log`, `Law.from_counts`, `Law.from_probabilities` and `Utility.from_table`.

    Raises
    ------
    InputError
        If the map names a column that is not among `columns`, or a label that does not occur, or has new labels that `fold` would merge.

    Examples
    --------
    >>> from fairaudit.model.law import Law
    >>> log = {"hired": ["yes", "Yes", "no", "yes"], "sex": ["f", "F ", "m", "man"]}
    >>> table = merge_labels(log, ["hired", "sex"], fold=True, label_map={"sex": {"man": "m"}})
    >>> law = Law.from_log(table, decision="hired", group="sex")
    >>> law.decisions, law.groups, [entry["step"] for entry in law.preparation]
    (('no', 'yes'), (('F ',), ('m',)), ['mapped', 'folded', 'folded'])
    """
    listed = names(columns)
    wanted = dict(label_map or {})
    for name in wanted:
        if name not in listed:
            raise InputError(
                f"the map has a column {shown(name)}, which is no decision, group, context or true label; {nearest(name, listed)}"
            )
    where = locator(table)
    labels: dict[str, tuple[NDArray[np.int64], list[str]]] = {}
    done: list[Entry] = []
    for name in listed:
        [(codes, texts)] = label_codes(table, [name], where)
        amounts = np.zeros(len(texts) + 1, dtype=np.int64)
        np.add.at(amounts, codes, counted(table, len(codes)))
        written, entries = _written(name, dict(zip(texts, amounts.tolist(), strict=False)), wanted.get(name, {}), fold=fold)
        if entries:
            done += entries
            kept = list(dict.fromkeys(written[text] for text in texts))
            place = {text: i for i, text in enumerate(kept)}
            labels[name] = np.array([*(place[written[text]] for text in texts), -1], dtype=np.int64)[codes], kept
    return with_labels(table, labels, tuple(done)) if done else table


def spelt_alike(table: Table, columns: Sequence[str], labels: Sequence[str]) -> tuple[str, ...]:
    """Labels of some columns that differ from one of these in case, blanks or Unicode form alone; those that have none of them as they are.

    Examples
    --------
    >>> spelt_alike({"sex": ["f", "N/A", "m"]}, ["sex"], ["n/a", "declined"])
    ('N/A', 'declined')
    """
    held = [text for _, texts in label_codes(table, columns, locator(table)) for text in texts]
    found = {label: [text for text in held if _folded(text) == _folded(label)] for label in labels}
    return tuple(dict.fromkeys(text for label, alike in found.items() for text in alike or [label]))


def read_label_map(path: str | Path) -> dict[str, dict[str, str]]:
    r"""Read a map of labels: a TOML file with a table for each column, ``"old" = "new"``.

    Raises
    ------
    InputError
        If it is no such file.

    Examples
    --------
    >>> import tempfile
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     file = Path(folder) / "map.toml"
    ...     _ = file.write_text('[race]\n"BLK" = "Black"\n')
    ...     read_label_map(file)
    {'race': {'BLK': 'Black'}}
    """
    import tomllib

    try:
        document = tomllib.loads(Path(path).read_bytes().decode("utf-8"))
    except (FileNotFoundError, IsADirectoryError):
        raise InputError(f"{path}: there is no such file") from None
    except tomllib.TOMLDecodeError as error:
        quote = 'quote the names of columns and the labels: ["Race / Ethnicity"] and under it "BLK" = "Black"'
        raise InputError(f"{path}: this is not a TOML file: {error}; {quote}") from None
    except (UnicodeDecodeError, RecursionError) as error:
        raise InputError(f"{path}: this is not a TOML file: {error}") from None
    except (OSError, ValueError) as error:
        raise InputError(f"{path}: the file cannot be read: {getattr(error, 'strerror', None) or error}") from None
    for name, entries in document.items():
        if not isinstance(entries, dict):
            raise InputError(
                f'{path}: {shown(name)} is no table; write a table for each column, such as [race] and under it "BLK" = "Black"'
            )
        for old, new in entries.items():
            if not isinstance(new, str):
                raise InputError(f'{path}: [{name}] has {shown(old)} = {shown(new)}; the new label is a text, such as "Black"')
    return document


@brief
@dataclass(frozen=True, repr=False)
class PreparedTable:
    """A table of which some columns have other labels.

    Attributes
    ----------
    table : Any
        The table as it was.
    labels : dict of str to list
        The columns with other labels; None where one is missing.
    preparation : tuple of mapping
        What was done.
    """

    table: Any
    labels: dict[str, list[str | None]] = field(repr=False)
    preparation: tuple[Entry, ...]

    @property
    def columns(self) -> list[str]:
        """Column names, in order."""
        return [name for name in (self.table.columns if hasattr(self.table, "columns") else self.table) if isinstance(name, str)]

    def __getitem__(self, name: str) -> list[Any]:
        """Values of a column."""
        return list(self.labels[name]) if name in self.labels else column(self.table, name)

    def locate(self, position: int) -> str:
        """Name a row."""
        return locator(self.table)(position)


def with_labels(table: Any, labels: Mapping[str, tuple[NDArray[np.int64], list[str]]], done: tuple[Entry, ...]) -> Any:
    """A table with other labels in some columns, as codes (-1 where one is missing) and what they stand for, and with what was done."""
    preparation = (*getattr(table, "preparation", ()), *done)
    if isinstance(table, Tally):
        codes, levels = dict(table.codes), dict(table.levels)
        for name, (places, texts) in labels.items():
            codes[name], levels[name] = np.where(places < 0, len(texts), places), [*texts, None]
        return merged(replace(table, codes=codes, levels=levels, preparation=preparation))
    lists = {name: [texts[i] if i >= 0 else None for i in places.tolist()] for name, (places, texts) in labels.items()}
    if isinstance(table, CsvTable):
        cells = {name: ["" if text is None else text for text in texts] for name, texts in lists.items()}
        return replace(table, texts={**table.texts, **cells}, preparation=preparation)
    return PreparedTable(table, lists, preparation)


def _written(name: str, amounts: Mapping[str, int], wanted: Mapping[Any, Any], *, fold: bool) -> tuple[dict[str, str], list[Entry]]:
    """How each label of a column is to be written, and what that merges."""
    new = {_label(name, old): _label(name, label) for old, label in wanted.items()}
    for old in new:
        if old not in amounts:
            raise InputError(f"the map of column {shown(name)} has the label {shown(old)}, which does not occur; {nearest(old, amounts)}")
    written = {text: new.get(text, text) for text in amounts}
    entries = [
        merged_labels("mapped", name, label, (old for old in new if new[old] == label and old != label))
        for label in dict.fromkeys(new.values())
        if any(new[old] == label and old != label for old in new)
    ]
    if not fold:
        return written, entries
    sums: dict[str, int] = {}
    for text, label in written.items():
        sums[label] = sums.get(label, 0) + amounts[text]
    alike: dict[str, list[str]] = {}
    for label in sums:
        alike.setdefault(_folded(label), []).append(label)
    chosen: dict[str, str] = {}
    for labels in alike.values():
        given = sorted(set(labels) & set(new.values()))
        if len(given) > 1:
            raise InputError(
                f"the map of column {shown(name)} has the new labels {shown(given[0])} and {shown(given[1])}, which folding would merge; "
                "write them in one way"
            )
        label = given[0] if given else min(labels, key=lambda label: (-sums[label], label))
        chosen |= dict.fromkeys(labels, label)
        if len(labels) > 1:
            entries.append(merged_labels("folded", name, label, (other for other in labels if other != label)))
    return {text: chosen[label] for text, label in written.items()}, entries


def _label(name: str, value: Any) -> str:
    text = label_text(value)
    if text is None:
        raise InputError(
            f"the map of column {shown(name)} has the label {shown(value)}, which is a missing one; missing=drop (--missing drop) or "
            "missing=group (--missing group) says what becomes of those"
        )
    return text


def _folded(text: str) -> str:
    """What spellings of one label have in common."""
    if len(text) > LONGEST_SPELLING:
        return text
    if text.isascii():
        return " ".join(text.lower().split())
    return " ".join(normalize("NFD", normalize("NFD", text).casefold()).split())


def _plainly_different(labels: Sequence[str]) -> bool:
    """Whether labels of letters without blanks differ by more than their case, which is quickly seen of many."""
    joined = "".join(labels)
    if (
        not joined.isascii()
        or "".join(joined.split()) != joined
        or any(label[:1] in STARTS or len(label) > LONGEST_SPELLING for label in labels)
    ):
        return False
    return max(map(len, labels), default=0) <= LONGEST_SPELLING and len({label.lower() for label in labels}) == len(labels)


def _settled(text: str) -> bool:
    """Whether Unicode 3.2 has all characters, so that no version folds the text in another way."""
    return len(text) <= LONGEST_SPELLING and (text.isascii() or all(ucd_3_2_0.category(character) != "Cn" for character in text))


def _number(text: str) -> str:
    """A number in one spelling; empty if a text is none."""
    match = NUMBER.fullmatch(text) if text[:1] in STARTS else None
    if match is None or not (match[2] or match[3]):
        return ""
    digits, exponent = match[2] + (match[3] or ""), int(match[4] or 0) - len(match[3] or "")
    kept = digits.rstrip("0")
    exponent += len(digits) - len(kept)
    kept = kept.lstrip("0")
    return f"{match[1].replace('+', '')}{kept}e{exponent}" if kept else "0e0"
