"""Words that results, reports and the command line share: figures rounded for people, labels that are data, who is favoured."""

from __future__ import annotations

import re
import reprlib
import shlex
import unicodedata
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, fields
from decimal import ROUND_CEILING, ROUND_FLOOR, ROUND_HALF_EVEN, Context, Decimal, localcontext
from fractions import Fraction
from typing import Any, Literal, TypeVar

__all__ = [
    "BENEFIT",
    "BURDEN",
    "COLUMNS",
    "Words",
    "approximate",
    "brief",
    "columns_of",
    "ends_text",
    "factor_text",
    "first_columns",
    "harmless",
    "noun",
    "percent",
    "place",
    "plain",
    "quoted",
    "to_copy",
    "words_for",
    "wrapped",
]


def approximate(value: Fraction | float, rounding: Literal["nearest", "down", "up"] = "nearest", digits: int = 4) -> str:
    """Some significant digits of an exact value, for a person.

    Examples
    --------
    >>> approximate(Fraction(24475, 18432)), approximate(Fraction(10**400, 3)), approximate(float("inf"))
    ('1.328', '3.333e+399', 'infinite')
    >>> approximate(Fraction(24475, 18432), "down"), approximate(Fraction(2, 3), "up")
    ('1.327', '0.6667')
    """
    if not isinstance(value, Fraction):
        return "infinite"
    if rounding == "nearest" and (value == 0 or Fraction(1, 10**300) < abs(value) < 10**300):
        return f"{float(value):.{digits}g}"
    towards = {"nearest": ROUND_HALF_EVEN, "down": ROUND_FLOOR, "up": ROUND_CEILING}[rounding]
    with localcontext(Context(prec=digits, rounding=towards, Emin=-999_999, Emax=999_999)) as context:
        return format(context.divide(Decimal(value.numerator), Decimal(value.denominator)), f".{digits}g")


def factor_text(value: Fraction | float, rounding: Literal["nearest", "down", "up"] = "nearest") -> str:
    """A factor with four significant digits, or with as many more as tell it from 1.

    Examples
    --------
    >>> factor_text(Fraction(1002, 1001)), factor_text(Fraction(5, 3)), factor_text(Fraction(1002, 1001), "down")
    ('1.001', '1.667', '1.0009')
    """
    texts = (approximate(value, rounding, digits) for digits in range(4, 17))
    return next((text for text in texts if value == 1 or float(text.replace("infinite", "inf")) != 1), approximate(value, rounding))


STEERING = {"Cc", "Cf", "Cs", "Co", "Cn", "Zl", "Zp"}


def plain(text: str) -> str:
    r"""Escape characters that could steer a terminal or reorder text.

    Examples
    --------
    >>> plain("a\x1b[31mb\u202ec")
    'a\\x1b[31mb\\u202ec'
    """
    if text.isprintable():
        return text
    return "".join(c if unicodedata.category(c) not in STEERING else c.encode("unicode_escape").decode("ascii") for c in text)


RUN = "=+-@\t\r\n＝＋－＠"
"""What begins a cell that a spreadsheet would compute."""

NUMBER = re.compile(r"-?[0-9]+(\.[0-9]+|/[0-9]+)?")


def harmless(cell: str) -> str:
    r"""A cell that no spreadsheet runs: what would begin a formula stands behind an apostrophe, unless it is a number.

    An apostrophe at the beginning is doubled, so that two labels are two cells.

    Examples
    --------
    >>> harmless('=HYPERLINK("x")'), harmless("-0.5"), harmless("'=1"), harmless("women")
    ('\'=HYPERLINK("x")', '-0.5', "''=1", 'women')
    """
    risky = cell[:1] == "'" or cell.lstrip(" \N{NO-BREAK SPACE}")[:1] in {*RUN} or cell[:1] in {*RUN}
    return f"'{plain(cell)}" if risky and not NUMBER.fullmatch(cell) else plain(cell)


THE_INTERVAL = "the interval"

THIS_TABLE = "this table"

ENDS_CROSS = "the ends cross"

WHOEVER = "whoever the unknown are"

WHOEVER_BELONGS = "whoever the members of the groups are"

HIDDEN = "with the declared hidden context"

DRIFTING = "within the declared drift"

WHATEVER = "whatever the undecided meant"

OBJECTIONS = (WHOEVER, HIDDEN, DRIFTING, WHATEVER)
"""What a target can be judged under, and a claim hold under, besides of the table or the population as they are."""


@dataclass(frozen=True)
class Words:
    """How a sentence speaks of what is compared.

    Attributes
    ----------
    worse : str
        What is said of the group with the higher expectation.
    amount : str
        What is compared.
    counted : str
        The decisions that count, where each is worth 1 and all others nothing; the sentence then says how often they are taken.
    """

    worse: str
    amount: str
    counted: str = ""

    def amounts(self, values: tuple[Fraction, Fraction]) -> str:
        """What two groups get."""
        high, low = values
        if self.counted:
            return f"{self.counted} in {approximate(100 * high)} % of decisions against {approximate(100 * low)} %"
        return f"an {self.amount} of {approximate(high)} against {approximate(low) if low else 'exactly 0'}"

    @property
    def much(self) -> str:
        """The unit of a factor."""
        return "as often" if self.counted else "as much"


BENEFIT = Words("is favoured over", "expected utility")

BURDEN = Words("is disadvantaged compared with", "expected burden")


def words_for(*, burden: bool) -> Words:
    """The words for a utility that counts a benefit, or a burden."""
    return BURDEN if burden else BENEFIT


def place(labels: Mapping[str, str]) -> str:
    """Name a group or context.

    Examples
    --------
    >>> place({"Dept": "A", "Year": "1973"})
    'Dept=A, Year=1973'
    """
    return ", ".join(f"{column}={label}" for column, label in labels.items())


def noun(number: object, one: str, more: str = "") -> str:
    """What stands behind a number: in the singular behind 1; the plural is given where it does not end in s.

    Examples
    --------
    >>> noun(1, "context"), noun(0, "context"), noun(1_204, "entry", "entries")
    ('context', 'contexts', 'entries')
    """
    return one if number in (1, "1") else more or f"{one}s"


def quoted(label: str) -> str:
    """Quote a name or label as `--group` and `--utility` read it, where that is needed.

    Examples
    --------
    >>> quoted("in review"), quoted("no, open"), quoted('"a"')
    ('in review', '"no, open"', '\"\"\"a\"\"\"')
    """
    needed = label != label.strip() or any(c in label for c in ',="\r\n')
    return '"' + label.replace('"', '""') + '"' if needed else label


def to_copy(labels: Iterable[str], more: str = "") -> str:
    """Labels as an option takes them, as they are copied into a shell.

    Examples
    --------
    >>> to_copy(["open", "in review"]), to_copy(["open"], "=0")
    ("'open,in review'", 'open=0')
    """
    return shlex.quote(",".join(map(quoted, labels)) + more)


def percent(value: Fraction | float, rounding: Literal["down", "up"] = "down") -> str:
    """A probability as a percentage in six digits: rounded down, as a confidence may be, unless it is one of errors.

    Examples
    --------
    >>> percent(Fraction(19, 20))
    '95 %'
    >>> percent(1 - Fraction(1, 10**8)), percent(Fraction(1, 3), "up")
    ('99.9999 %', '33.3334 %')
    """
    exact = value if isinstance(value, Fraction) else Fraction(str(value))
    return f"{approximate(100 * exact, rounding, 6)} %"


def ends_text(low: str, high: str, *, each: bool) -> str:
    """Both ends of an interval, or each by itself.

    Examples
    --------
    >>> ends_text("1.2", "1.9", each=False), ends_text("1.2", "1.9", each=True)
    ('1.2 to 1.9', 'at least 1.2, at most 1.9')
    """
    return f"at least {low}, at most {high}" if each else f"{low} to {high}"


T = TypeVar("T")

MOST = 600
"""A `repr` is shorter than this: what fits on a screen beside others, of tables of any size."""


class _Short(reprlib.Repr):
    """Parts of a `repr`: labels escaped and cut, numbers of many digits rounded, the first of many."""

    def __init__(self, width: int, many: int) -> None:
        super().__init__()
        self.maxstring = self.maxother = self.maxlong = width
        self.maxtuple = self.maxlist = self.maxdict = self.maxset = self.maxfrozenset = many
        self.maxlevel = 4

    def repr_Fraction(self, value: Fraction, _: int) -> str:  # noqa: N802
        """Exactly, or rounded where it has more digits than anybody reads."""
        exact = max(value.numerator.bit_length(), value.denominator.bit_length()) < 3 * self.maxlong
        return repr(value) if exact else f"Fraction(about {approximate(value)})"

    def repr_int(self, value: int, _: int) -> str:
        """Exactly, or rounded."""
        return repr(value) if value.bit_length() < 3 * self.maxlong else f"about {approximate(Fraction(value))}"

    def repr_ndarray(self, value: Any, _: int) -> str:
        """Its shape and type."""
        return f"array of {' × '.join(map(str, value.shape))} {value.dtype}"

    def repr_instance(self, value: object, level: int) -> str:
        """A mapping as a dict; else what it says of itself, cut."""
        if isinstance(value, Mapping):
            return self.repr_dict(dict(value), level)
        text = repr(value)
        return text if len(text) <= self.maxother else text[: self.maxother - 1] + "…"


def _brief(value: Any) -> str:
    kind = type(value).__qualname__
    text = ""
    for width, many in ((120, 6), (60, 4), (30, 2), (16, 1), (8, 1)):
        short = _Short(width, many)
        text = f"{kind}({', '.join(f'{entry.name}={short.repr(getattr(value, entry.name))}' for entry in fields(value) if entry.repr)})"
        if len(text) < MOST:
            return text
    return text[: MOST - 3] + "…)"


def brief(of: type[T]) -> type[T]:
    """Give a dataclass a `repr` of fewer than 600 characters, whatever it holds: to be written above ``@dataclass``.

    Examples
    --------
    >>> @brief
    ... @dataclass
    ... class Group:
    ...     labels: tuple[str, ...]
    >>> Group(("f", "m"))
    Group(labels=('f', 'm'))
    >>> len(repr(Group(("very long label " * 99,) * 1000))) < 600
    True
    """
    of.__repr__ = _brief  # type: ignore[method-assign]
    return of


COLUMNS = 80
"""Of a screen."""


def columns_of(text: str) -> int:
    """How many columns of a terminal a text takes.

    Examples
    --------
    >>> columns_of("Zürich"), columns_of("東京")
    (6, 4)
    """
    if text.isascii():
        return len(text)
    return sum(0 if unicodedata.combining(c) else 2 if unicodedata.east_asian_width(c) in "WF" else 1 for c in text)


def first_columns(text: str, width: int) -> str:
    """The characters that fit into so many columns."""
    taken, used = 0, 0
    for c in text[: 2 * width]:
        used += columns_of(c)
        if used > width:
            break
        taken += 1
    return text[:taken]


def wrapped(text: str, indent: int = 0, columns: int = COLUMNS) -> list[str]:
    """A text in lines of 80 columns, or fewer, those after the first indented; a percentage stays on one line.

    Examples
    --------
    >>> wrapped("the ratio changed: it is above 1.25", 2, 20)
    ['the ratio changed:', '  it is above 1.25']
    """
    lines: list[str] = []
    line = ""
    for word in re.split(r" (?!%)", text):
        room = columns - (indent if lines else 0)
        joined = f"{line} {word}" if line else word
        if columns_of(joined) <= room:
            line = joined
            continue
        if line:
            lines.append(line)
        room = columns - (indent if lines else 0)
        while columns_of(word) > room:
            head = first_columns(word, room)
            lines.append(head)
            word, room = word[len(head) :], columns - indent
        line = word
    lines.append(line)
    return [lines[0], *(" " * indent + line for line in lines[1:])]
