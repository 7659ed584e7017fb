"""`fairaudit inspect`: what is in a table, and a certify command to try."""

from __future__ import annotations

import argparse
import re
import shlex
import sys
from collections import Counter
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from fairaudit.tables.csv import CsvTable

HINTS = {
    "count": r"n|freq(uency)?|counts?|num(ber)?|total|cases|size",
    "probability": r"p|pr|prob(ability|abilities)?|share|rate",
    "weight": r"w|weights?|mass|population|prior",
    "decision": r".*(decision|outcome|admi(t|ssion)|hired?|accept|approv|select|cho(sen|ice)|recommend|result|label|predict|grant).*|u|y",
    "group": r".*(gender|sex|race|ethnic|group|name|age|religion|nationality|disab|minority|origin|placebo).*|a|s",
}
MISSING_WORDS = {"na", "n/a", "nan", "null", "none", "unknown", "?", "-", "."}
MANY = 50


@dataclass(frozen=True)
class _Column:
    """What a column looks like."""

    name: str
    levels: Counter[str]
    missing: int
    numeric: bool

    def is_a(self, role: str) -> bool:
        """Whether the name suggests the role."""
        return re.fullmatch(HINTS[role], self.name.strip().lower()) is not None


def add(commands: Any) -> None:
    """Declare the options."""
    parser = commands.add_parser(
        "inspect",
        help="list the columns of a table and suggest a certify command",
        description="List columns, levels and missing values of a table, and print a certify command to try.",
        allow_abbrev=False,
    )
    parser.set_defaults(run=run)
    parser.add_argument("table", metavar="TABLE", help="CSV file with a header line")


def run(arguments: argparse.Namespace) -> int:
    """Do the work."""
    from fairaudit.cli.text import plain
    from fairaudit.tables.csv import read_csv

    table = read_csv(arguments.table)
    for note in table.notes:
        print(f"note: {plain(note)}", file=sys.stderr)
    found = [_look(table, name) for name in table.columns]
    width = max(len(plain(column.name)) for column in found)
    print(f"{len(table)} rows, {len(found)} columns\n")
    for column in found:
        print(f"  {plain(column.name).ljust(width)}  {_describe(column)}")
        for warning in _warnings(column):
            print(f"  {' ' * width}  ! {warning}")
    print("\nA command to try (check which column is which):\n")
    print(f"  {plain(_suggest(arguments.table, found))}")
    return 0


def _look(table: CsvTable, name: str) -> _Column:
    from fairaudit.exact import InputError, parse_rational

    cells = table[name]
    levels = Counter(cell for cell in cells if cell.strip())

    def number(text: str) -> bool:
        try:
            parse_rational(text.replace(",", ".", 1) if table.delimiter != "," else text)
        except InputError:
            return False
        return True

    return _Column(name, levels, len(cells) - levels.total(), bool(levels) and all(map(number, levels)))


def _describe(column: _Column) -> str:
    from fairaudit.cli.text import plain

    absent = f"; {column.missing} missing" if column.missing else ""
    if not column.levels:
        return f"empty{absent}"
    if column.numeric and len(column.levels) > 12:
        return f"numbers, {len(column.levels)} different{absent}"
    shown = ", ".join(f"{plain(label)[:40]} ({count})" for label, count in column.levels.most_common(8))
    more = f", … ({len(column.levels)} levels)" if len(column.levels) > 8 else ""
    return f"{shown}{more}{absent}"


def _warnings(column: _Column) -> list[str]:
    from fairaudit.cli.text import plain

    warnings = []
    folded: dict[str, str] = {}
    for label in column.levels:
        key = " ".join(label.lower().split())
        if key in folded:
            warnings.append(f"'{plain(label)}' and '{plain(folded[key])}' differ only in case or blanks; they count as different levels")
        folded.setdefault(key, label)
        if key in MISSING_WORDS:
            warnings.append(f"'{plain(label)}' counts as a level; only empty cells are missing")
    return warnings[:5]


def _suggest(path: str, found: list[_Column]) -> str:
    left = list(found)

    def take(role: str, numeric: bool) -> _Column | None:
        for column in left:
            if column.is_a(role) and column.numeric >= numeric and column.levels:
                left.remove(column)
                return column
        return None

    count = take("count", numeric=True)
    probability = None if count else take("probability", numeric=True)
    weight = take("weight", numeric=True) if probability else None
    groups = [column for column in left if column.is_a("group") and 2 <= len(column.levels) <= 10 * MANY]
    for column in groups:
        left.remove(column)
    usable = [column for column in left if 2 <= len(column.levels) <= MANY and not (column.numeric and len(column.levels) > 12)]
    decision = next((column for column in usable if column.is_a("decision")), None) or next(
        (column for column in sorted(usable, key=lambda c: len(c.levels))), None
    )
    usable = [column for column in usable if column is not decision and not column.numeric]
    if not groups and usable:
        groups = [usable.pop(0)]
    words = ["fairaudit", "certify", f"./{path}" if path.startswith("-") else path]
    for option, value in (
        ("--decision", decision.name if decision else "COL"),
        ("--group", ",".join(_quoted(column.name) for column in groups) or "COL"),
        ("--context", ",".join(_quoted(column.name) for column in usable)),
        ("--count", count.name if count else ""),
        ("--probability", probability.name if probability else ""),
        ("--weight", weight.name if weight else ""),
        ("--utility", _quoted(_good(decision)) if decision else "DECISION"),
    ):
        if value:
            words += [f"{option}={value}"] if value.startswith("-") else [option, value]
    return " ".join(shlex.quote(word) for word in words)


def _good(decision: _Column) -> str:
    """The level that most likely is the good one."""
    good = re.compile(r"(yes|true|1|admit\w*|accept\w*|hired?|approv\w*|granted|selected|chosen|first|pass\w*|positive)", re.IGNORECASE)
    return next((label for label in decision.levels if good.fullmatch(label.strip())), next(iter(decision.levels)))


def _quoted(label: str) -> str:
    """Quote a name or label as `--group` and `--utility` read it, where that is needed."""
    needed = label != label.strip() or any(c in label for c in ',="\r\n')
    return '"' + label.replace('"', '""') + '"' if needed else label
