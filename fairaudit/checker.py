"""Check a certificate of the format ``fairaudit-certificate/1``.

This file stands alone: it uses the Python standard library only, imports nothing of the package that writes
certificates, and runs from a copy of itself::

    python checker.py CERTIFICATE.json [--table FILE] [--require within]

It reads the certificate and the decision table, computes every figure again from the table, and says of each statement
in the certificate whether it is true.  All decisions are made in integers; no floating-point number occurs.

What is trusted: Python's integers, ``json`` and ``hashlib``; and, for the claims ``by`` T5, T6 and T7, the theorems of
those names.  Nothing that the certificate says is.  The sentences under ``assumptions`` cannot be checked and are
repeated for the reader.  A true certificate is true *of its table*; that the table is genuine is not checked.

Exit codes: 0 every statement is true (and the required verdict is there); 1 a statement is false, or the required
verdict is not there; 2 not a certificate of this format, not readable, or wrong usage; 3 the table is not embedded and
was not given.

Rationals are pairs ``(numerator, denominator)`` of integers; infinity is ``(1, 0)``.  Cross-multiplication then orders
all of them, infinity included.
"""

import argparse
import hashlib
import json
import os
import re
import sys
from collections import Counter
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import combinations, zip_longest
from math import gcd, isqrt, lcm

CERTIFICATE_FORMAT = "fairaudit-certificate/1"
TABLE_FORMAT = "fairaudit-table/1"
MAX_DIGITS = 100_000
MAX_BYTES = 1 << 30  # of a certificate, and of one line of a table
LOG_SCALE = 10**12

Rational = tuple[int, int]
Law = tuple[tuple[int, ...], int]  # integer weights of the decisions, and their sum

ZERO: Rational = (0, 1)
ONE: Rational = (1, 1)
INFINITY: Rational = (1, 0)


class FormatError(ValueError):
    """The document is not a well-formed certificate (or table) of the format."""


class TableNeeded(Exception):
    """The table is not embedded in the certificate and was not given."""


@dataclass(frozen=True)
class Finding:
    """One statement of a certificate, and whether it is true."""

    statement: str
    true: bool
    detail: str


@dataclass(frozen=True)
class Report:
    """What was found out about every statement, and the verdict that the certificate states."""

    findings: tuple[Finding, ...]
    verdict: str

    @property
    def ok(self) -> bool:
        """Whether every statement is true."""
        return all(finding.true for finding in self.findings)


# ---------------------------------------------------------------------------------------------------------------------
# Text for people


def printable(text: str) -> str:
    """Escape what could steer a terminal: control, format, bidi, surrogate, private and unassigned characters."""
    if text.isprintable():
        return text
    return "".join(c if c.isprintable() else _escaped(ord(c)) for c in text)


def _escaped(code: int) -> str:
    return f"\\u{code:04x}" if code <= 0xFFFF else f"\\U{code:08x}"


def shown(value: object) -> str:
    """Show a label, a rational, a witness and so on in one short line."""
    text = _shown(value)
    return text if len(text) <= 400 else text[:400] + " [...]"


def _shown(value: object) -> str:
    match value:
        case (int(numerator), int(denominator)):
            return _shown_rational(numerator, denominator)
        case dict():
            return "{" + ", ".join(f"{_shown(key)}: {_shown(item)}" for key, item in value.items()) + "}"
        case list() | tuple():
            return "[" + ", ".join(_shown(item) for item in value) + "]"
        case str() if len(value) > 400:
            return json.dumps(value[:400] + " [...]", ensure_ascii=False)
        case _:
            return json.dumps(value, ensure_ascii=False)


def _shown_rational(numerator: int, denominator: int) -> str:
    if denominator == 0:
        return "inf"
    bits = max(numerator.bit_length(), denominator.bit_length())
    if bits > 1500:  # Python may refuse to write long numbers, and nobody would read them
        return f"(a rational of about {bits * 3 // 10} digits)"
    return str(numerator) if denominator == 1 else f"{numerator}/{denominator}"


def _finding(statement: str, true: bool, detail: str = "") -> Finding:
    return Finding(printable(statement), true, printable(detail))


def _compared(name: str, stated: object, actual: object) -> Finding:
    true = stated == actual
    return _finding(f"{name} is {shown(stated)}", true, "" if true else f"the table gives {shown(actual)}")


def _malformed(where: str, what: str) -> FormatError:
    return FormatError(printable(f"{where} {what}"))


# ---------------------------------------------------------------------------------------------------------------------
# JSON and its types


@dataclass(frozen=True)
class _OtherNumber:
    """A JSON number that the format has no place for; the check of the type where it stands rejects it."""

    token: str


def _number(token: str) -> object:
    return int(token) if len(token) <= 18 and token != "-0" else _OtherNumber(token)


def _members(pairs: list[tuple[str, object]]) -> dict[str, object]:
    members = dict(pairs)
    if len(members) != len(pairs):
        [(repeated, _)] = Counter(key for key, _ in pairs).most_common(1)
        raise FormatError(f"an object repeats the key {shown(repeated)}")
    return members


_DECODER = json.JSONDecoder(object_pairs_hook=_members, parse_int=_number, parse_float=_OtherNumber, parse_constant=_OtherNumber)


def _decoded(raw: bytes, where: str) -> object:
    try:
        return _DECODER.decode(raw.decode("utf-8"))
    except UnicodeDecodeError as error:
        raise _malformed(where, f"is not UTF-8 at byte {error.start}") from None
    except json.JSONDecodeError as error:
        raise _malformed(where, f"is not JSON: {error}") from None
    except RecursionError:
        raise _malformed(where, "is nested too deeply") from None
    except FormatError as error:
        raise _malformed(where, f"is not acceptable: {error}") from None


def _canonical(value: object) -> bytes:
    return json.dumps(value, ensure_ascii=True, sort_keys=True, separators=(",", ":")).encode("ascii") + b"\n"


def _described(value: object) -> str:
    if value is None or isinstance(value, bool):
        return shown(value)
    names = {int: "a number", _OtherNumber: "a number", str: "a string", list: "a list", dict: "an object"}
    return names[type(value)]


def _object(value: object, where: str, keys: Sequence[str], optional: Sequence[str] = ()) -> dict[str, object]:
    if not isinstance(value, dict):
        raise _malformed(where, f"must be an object, not {_described(value)}")
    for key in keys:
        if key not in value:
            raise _malformed(where, f"lacks the key {shown(key)}")
    for key in value:
        if key not in keys and key not in optional:
            raise _malformed(where, f"has the unknown key {shown(key)}")
    return value


def _object_of_strings(value: object, where: str) -> dict[str, object]:
    members = _object(value, where, (), optional=tuple(value) if isinstance(value, dict) else ())
    for key, item in members.items():
        _string(key, f"a key of {where}")
        _string(item, f"{where}[{shown(key)}]")
    return members


def _list(value: object, where: str, length: int | None = None) -> list[object]:
    if not isinstance(value, list):
        raise _malformed(where, f"must be a list, not {_described(value)}")
    if length is not None and len(value) != length:
        raise _malformed(where, f"must have {length} entries, not {len(value)}")
    return value


_SURROGATE = re.compile("[\ud800-\udfff]")


def _string(value: object, where: str) -> str:
    if not isinstance(value, str):
        raise _malformed(where, f"must be a string, not {_described(value)}")
    if not value.isascii() and _SURROGATE.search(value):
        raise _malformed(where, "holds a lone surrogate, which is not a Unicode scalar value")
    return value


def _strings(value: object, where: str, length: int | None = None) -> tuple[str, ...]:
    return tuple(_string(item, f"{where}[{i}]") for i, item in enumerate(_list(value, where, length)))


def _one_of(value: object, where: str, choices: Sequence[str]) -> str:
    text = _string(value, where)
    if text not in choices:
        raise _malformed(where, f"must be one of {shown(list(choices))}, not {shown(text)}")
    return text


def _integer(value: object, where: str, below: int | None = None) -> int:
    if type(value) is not int:  # True is an instance of int, and no index
        raise _malformed(where, f"must be an integer, not {_described(value)}")
    if value < 0 or (below is not None and value >= below):
        raise _malformed(where, f"is out of range: {value}")
    return value


def _hexadecimal(value: object, where: str, digits: str, length: int) -> str:
    text = _string(value, where)
    if len(text) != length or not set(text) <= set(digits):
        raise _malformed(where, f"must be {length} hexadecimal digits")
    return text


def _digest(value: object, where: str) -> str:
    return _hexadecimal(value, where, "0123456789abcdef", 64)


# ---------------------------------------------------------------------------------------------------------------------
# Rationals

_RATIONAL = re.compile(r"(-?)(0|[1-9][0-9]*)(?:/([1-9][0-9]*))?")


def _whole(digits: str) -> int:
    """Read decimal digits by halves: Python refuses to read long numbers at once."""
    if len(digits) <= 500:
        return int(digits)
    half = len(digits) // 2
    scale: int = 10**half
    return _whole(digits[:-half]) * scale + _whole(digits[-half:])


def _rational(value: object, where: str, nonnegative: bool = False) -> Rational:
    match = _RATIONAL.fullmatch(value) if isinstance(value, str) else None
    if match is None:
        got = shown(value) if isinstance(value, str) else _described(value)
        raise _malformed(where, f'must be a rational, a string like "3/2" or "3", not {got}')
    sign, above, below = match.groups()
    if len(above) > MAX_DIGITS or (below is not None and len(below) > MAX_DIGITS):
        raise _malformed(where, f"has more than {MAX_DIGITS} digits")
    numerator = _whole(above)
    denominator = 1 if below is None else _whole(below)
    if below is not None and (denominator == 1 or gcd(numerator, denominator) != 1):
        raise _malformed(where, f"is not in lowest terms: {shown(value)}")
    if sign and numerator == 0:
        raise _malformed(where, 'must be written "0", not "-0"')
    if sign and nonnegative:
        raise _malformed(where, f"must not be negative: {shown(value)}")
    return (-numerator if sign else numerator), denominator


def _extended(value: object, where: str) -> Rational:
    return INFINITY if value == "inf" else _rational(value, where)


def _rationals(value: object, where: str, length: int) -> list[Rational]:
    return [_rational(item, f"{where}[{i}]", nonnegative=True) for i, item in enumerate(_list(value, where, length))]


def _reduced(numerator: int, denominator: int) -> Rational:
    divisor = gcd(numerator, denominator)
    return numerator // divisor, denominator // divisor


def _at_most(left: Rational, right: Rational) -> bool:
    return left[0] * right[1] <= right[0] * left[1]


def _over_common_denominator(values: Sequence[Rational]) -> tuple[list[int], int]:
    common = lcm(*(denominator for _, denominator in values))
    return [numerator * (common // denominator) for numerator, denominator in values], common


def _ends(values: Iterable[Rational]) -> tuple[int, int]:
    """Find the positions of the first greatest and the first least of some finite rationals."""
    first, *rest = values
    greatest, least = first, first
    top, low = 0, 0
    for i, value in enumerate(rest, 1):
        if value[0] * greatest[1] > greatest[0] * value[1]:
            greatest, top = value, i
        if value[0] * least[1] < least[0] * value[1]:
            least, low = value, i
    return top, low


Vector = tuple[list[int], int]  # numerators over one denominator


def _sum_of_vectors(terms: Iterable[Vector]) -> Vector:
    """Add vectors of rationals in pairs, so that long denominators occur in the last few additions only."""
    level = list(terms)
    while len(level) > 1:
        added = [_sum_of_two(level[i], level[i + 1]) for i in range(0, len(level) - 1, 2)]
        level = added + level[2 * len(added) :]
    return level[0]


def _sum_of_two(left: Vector, right: Vector) -> Vector:
    divisor = gcd(left[1], right[1])
    p, q = right[1] // divisor, left[1] // divisor
    return [a * p + b * q for a, b in zip(left[0], right[0], strict=True)], left[1] * p


def _sum(values: Iterable[Rational]) -> Rational:
    (numerator,), denominator = _sum_of_vectors(([n], d) for n, d in values)
    return _reduced(numerator, denominator)


# ---------------------------------------------------------------------------------------------------------------------
# Logarithms


def _atanh(z: int, bits: int, up: int) -> int:
    """Bound 2^bits atanh(z / 2^bits), 0 <= 3z <= 2^bits (a few units more do no harm), from below or above.

    All terms of z + z^3/3 + z^5/5 + ... are positive, so rounding every step down (``up`` 0) gives a lower bound, and
    rounding every step up (``up`` 1) an upper bound.  Rounded up, a power never falls below one unit; from there the
    terms left out add up to less than two units.
    """
    total, power, square, odd = 0, z, (z * z >> bits) + up, 1
    while power > up:
        total += power // odd + up
        power = (power * square >> bits) + up
        odd += 2
    return total + 2 * up


def _log_bounds(n: int, d: int, bits: int) -> tuple[int, int]:
    """Integers low, high with low <= 2^bits log(n/d) <= high, for n > d > 0; closer together for more bits.

    log R = 2^r log R^(1/2^r), and log m = 2 atanh((m - 1) / (m + 1)).  Square roots bring m close to 1, where the
    series needs few terms; an R that is close to 1 already needs fewer roots.
    """
    size, closeness = n.bit_length() - d.bit_length() + 1, d.bit_length() - (n - d).bit_length()
    roots = max(0, size.bit_length() + 8 + isqrt(bits) // 4 - max(0, closeness))
    one = 1 << bits
    low = (n << bits) // d
    high = low + 1
    for _ in range(roots):
        low, high = isqrt(low << bits), isqrt(high << bits) + 1
    z_low = ((low - one) << bits) // (low + one)
    z_high = ((high - one) << bits) // (high + one) + 1
    return _atanh(z_low, bits, 0) << (roots + 1), _atanh(z_high, bits, 1) << (roots + 1)


def log_floor(ratio: Rational, scale: int) -> int:
    """Compute floor(scale log R) for a finite R > 1 (an irrational logarithm: some precision decides)."""
    bits = 128
    while True:
        low, high = _log_bounds(*ratio, bits)
        if low * scale >> bits == high * scale >> bits:
            return low * scale >> bits
        bits *= 2


def log_at_most(ratio: Rational, limit: Rational) -> bool:
    """Decide log R <= q exactly, for R >= 1 (possibly infinite) and a finite q >= 0."""
    n, d = ratio
    if d == 0 or limit == ZERO or n == d:
        return n == d
    if limit[0] >= (n.bit_length() - d.bit_length() + 1) * limit[1]:  # log R < log2 R < this
        return True
    if _at_most((n - d, d), limit):  # log R < R - 1
        return True
    if _at_most(limit, (n - d, n)):  # log R > 1 - 1/R
        return False
    bits = 128
    while True:  # log R is irrational, q is not, so that some precision tells them apart
        low, high = _log_bounds(n, d, bits)
        if high * limit[1] <= limit[0] << bits:
            return True
        if low * limit[1] >= limit[0] << bits:
            return False
        bits *= 2


def log_enclosure(ratio: Rational) -> tuple[str, str]:
    """Write the enclosure of log R, for R >= 1, as the format wants it."""
    if ratio == ONE:
        return "0", "0"
    if ratio == INFINITY:
        return "inf", "inf"
    low = log_floor(ratio, LOG_SCALE)
    return _decimal(low), _decimal(low + 1)


def _decimal(units: int) -> str:
    return f"{units // LOG_SCALE}.{units % LOG_SCALE:012d}"


# ---------------------------------------------------------------------------------------------------------------------
# The table


@dataclass(frozen=True)
class Columns:
    """The names of the columns of a table."""

    decision: str
    group: tuple[str, ...]
    context: tuple[str, ...]


@dataclass(frozen=True)
class Subject:
    """What the certificate and the header of the table have to agree on."""

    kind: str
    columns: Columns
    population: str


@dataclass(frozen=True)
class Header:
    """The first line of a table."""

    subject: Subject
    decisions: tuple[str, ...]
    groups: tuple[tuple[str, ...], ...]
    contexts: tuple[tuple[str, ...], ...]
    utility: tuple[Rational, ...] | None


@dataclass(frozen=True, slots=True)
class Cell:
    """One line of a table: P(u|x,a) is ``law``, M(x,a) is ``mass`` and E(x,a) is ``expectation``."""

    context: int
    group: int
    law: Law
    mass: Rational
    expectation: Rational
    utility: Sequence[Rational | None]


@dataclass(frozen=True)
class Table:
    """A decision table and the digest of its canonical text."""

    header: Header
    cells: tuple[Cell, ...]
    digest: str

    def by_context(self) -> list[list[Cell]]:
        """List the cells of each context."""
        lists: list[list[Cell]] = [[] for _ in self.header.contexts]
        for cell in self.cells:
            lists[cell.context].append(cell)
        return lists

    def by_group(self) -> list[list[Cell]]:
        """List the cells of each group."""
        lists: list[list[Cell]] = [[] for _ in self.header.groups]
        for cell in self.cells:
            lists[cell.group].append(cell)
        return lists

    def complete(self) -> bool:
        """Say whether every group has a cell in every context (no cell occurs twice)."""
        return len(self.cells) == len(self.header.contexts) * len(self.header.groups)


def _read_columns(value: object, where: str) -> Columns:
    members = _object(value, where, ("decision", "group", "context"))
    columns = Columns(
        _string(members["decision"], f"{where}.decision"),
        _strings(members["group"], f"{where}.group"),
        _strings(members["context"], f"{where}.context"),
    )
    names = (columns.decision, *columns.group, *columns.context)
    if not columns.group:
        raise _malformed(f"{where}.group", "must name at least one column")
    if len(set(names)) != len(names):
        raise _malformed(where, "names a column twice")
    return columns


def _read_subject(members: Mapping[str, object], where: str) -> Subject:
    kind = _one_of(members["kind"], f"{where}.kind", ("counts", "probabilities"))
    populations = ("counts",) if kind == "counts" else ("weights", "equal")
    population = _one_of(members["population"], f"{where}.population", populations)
    return Subject(kind, _read_columns(members["columns"], f"{where}.columns"), population)


def _read_label_lists(value: object, where: str, width: int) -> tuple[tuple[str, ...], ...]:
    lists = tuple(_strings(item, f"{where}[{i}]", width) for i, item in enumerate(_list(value, where)))
    _check_distinct(lists, where)
    return lists


def _check_distinct(items: Sequence[object], where: str) -> None:
    if not items:
        raise _malformed(where, "must not be empty")
    if len(set(items)) != len(items):
        raise _malformed(where, "lists something twice")


def _read_header(value: object, where: str) -> Header:
    keys = ("format", "kind", "columns", "population", "decisions", "groups", "contexts", "utility")
    members = _object(value, where, keys, optional=("salt",))
    _one_of(members["format"], f"{where}.format", (TABLE_FORMAT,))
    if "salt" in members:
        _hexadecimal(members["salt"], f"{where}.salt", "0123456789abcdefABCDEF", 32)
    subject = _read_subject(members, where)
    decisions = _strings(members["decisions"], f"{where}.decisions")
    _check_distinct(decisions, f"{where}.decisions")
    utility = members["utility"]
    return Header(
        subject,
        decisions,
        _read_label_lists(members["groups"], f"{where}.groups", len(subject.columns.group)),
        _read_label_lists(members["contexts"], f"{where}.contexts", len(subject.columns.context)),
        None if utility is None else tuple(_rationals(utility, f"{where}.utility", len(decisions))),
    )


def _read_cell(value: object, where: str, header: Header) -> Cell:
    weighted = header.subject.population == "weights"
    keys = ["context", "group", "weights"] + ["mass"] * weighted + ["utility"] * (header.utility is None)
    members = _object(value, where, keys)
    weights, denominator = _over_common_denominator(_rationals(members["weights"], f"{where}.weights", len(header.decisions)))
    total = sum(weights)
    if total == 0:
        raise _malformed(f"{where}.weights", "are all zero")
    mass = ONE
    if header.subject.kind == "counts":
        mass = _reduced(total, denominator)
    elif total != denominator:
        raise _malformed(f"{where}.weights", "are probabilities that do not sum to 1")
    elif weighted:
        mass = _rational(members["mass"], f"{where}.mass", nonnegative=True)
    utility: Sequence[Rational | None] | None = header.utility
    if utility is None:
        utility = _read_utility(members["utility"], f"{where}.utility", weights)
    # Without a common factor equal laws have equal weights, which saves comparisons later.
    divisor = gcd(*weights)
    law = tuple(weight // divisor for weight in weights), total // divisor
    return Cell(
        _integer(members["context"], f"{where}.context", len(header.contexts)),
        _integer(members["group"], f"{where}.group", len(header.groups)),
        law,
        mass,
        _expectation(law, utility),
        utility,
    )


def _read_utility(value: object, where: str, weights: Sequence[int]) -> tuple[Rational | None, ...]:
    entries: list[Rational | None] = []
    for i, (item, weight) in enumerate(zip(_list(value, where, len(weights)), weights, strict=True)):
        if item is None and weight:
            raise _malformed(f"{where}[{i}]", "is null where the weight is positive")
        entries.append(None if item is None else _rational(item, f"{where}[{i}]", nonnegative=True))
    return tuple(entries)


def _expectation(law: Law, utility: Sequence[Rational | None]) -> Rational:
    gains, denominator = _over_common_denominator([ZERO if entry is None else entry for entry in utility])
    return _reduced(sum(w * g for w, g in zip(law[0], gains, strict=True)), law[1] * denominator)


def _read_table(lines: Iterable[tuple[str, object, bytes | None]]) -> Table:
    """Read a table from (where, value, bytes in the file or None if embedded), the header first."""
    digest = hashlib.sha256()
    header: Header | None = None
    cells: list[Cell] = []
    for where, value, raw in lines:
        if header is None:
            header = _read_header(value, where)
        else:
            cells.append(_read_cell(value, where, header))
            if len(cells) > 1 and (cells[-1].context, cells[-1].group) <= (cells[-2].context, cells[-2].group):
                raise _malformed(where, "is not in increasing order of context and group")
        text = _canonical(value)
        if raw is not None and raw != text:
            raise _malformed(where, "is not the canonical text of its value, ended by one line feed")
        digest.update(text)
    if header is None:
        raise _malformed("the table", "is empty")
    if header.utility is None and not cells:
        raise _malformed("the table", "gives no utility at all")
    if header.subject.population == "weights" and (not cells or _sum(cell.mass for cell in cells) != ONE):
        raise _malformed("the table", "has masses that do not sum to 1")
    return Table(header, tuple(cells), digest.hexdigest())


def _lines_of_file(lines: Iterable[bytes]) -> Iterator[tuple[str, object, bytes]]:
    for number, line in enumerate(lines, 1):
        where = f"line {number} of the table"
        yield where, _decoded(line, where), line


# ---------------------------------------------------------------------------------------------------------------------
# The metrics


@dataclass(frozen=True)
class Maximum:
    """The value of a metric and its witness."""

    value: Rational
    witness: dict[str, object]


@dataclass(frozen=True)
class Setting:
    """Where groups are compared; local figures have a context, suprema a decision."""

    groups: Sequence[int]
    context: int | None = None
    decision: int | None = None

    def witness(self, header: Header, higher: int, lower: int) -> dict[str, object]:
        """Name the place and the two groups that stand at the given positions."""
        names: dict[str, object] = {}
        columns = header.subject.columns
        if self.context is not None:
            names["context"] = dict(zip(columns.context, header.contexts[self.context], strict=True))
        if self.decision is not None:
            names["decision"] = header.decisions[self.decision]
        names["higher"] = dict(zip(columns.group, header.groups[self.groups[higher]], strict=True))
        names["lower"] = dict(zip(columns.group, header.groups[self.groups[lower]], strict=True))
        return names


def _widest_ratio(values: Sequence[Rational]) -> tuple[Rational, int, int]:
    """Find the greatest ratio of two of the values, and the first positions (higher, lower) that attain it."""
    top, low = _ends(values)
    (n, d), (p, q) = values[top], values[low]
    if n * q == p * d:  # all values are equal, possibly to 0: every ratio is 1
        return ONE, 0, 1
    if p == 0:  # any positive value over 0 is infinite, not only the greatest
        return INFINITY, next(i for i, value in enumerate(values) if value[0] > 0), low
    return (n * q, d * p), top, low


def _greatest_ratio(header: Header, compared: Iterable[tuple[Setting, Sequence[Rational]]], name: str) -> Maximum | None:
    """Find the greatest ratio over all settings; the first one that attains it is kept."""
    best: tuple[Rational, Setting, int, int, Sequence[Rational]] | None = None
    for setting, values in compared:
        ratio, higher, lower = _widest_ratio(values)
        if best is None or not _at_most(ratio, best[0]):
            best = ratio, setting, higher, lower, values
    if best is None:
        return None
    ratio, setting, higher, lower, values = best
    pair = [_reduced(*values[higher]), _reduced(*values[lower])]
    return Maximum(_reduced(*ratio), setting.witness(header, higher, lower) | {name: pair})


def _widest_distance(laws: Sequence[Law]) -> tuple[Rational, int, int]:
    """Find the greatest total variation distance of two of the laws, and the first positions that attain it."""
    if len(laws[0][0]) <= 2:  # the distance is the difference of the probabilities of the first decision
        values = [(weights[0], total) for weights, total in laws]
        top, low = _ends(values)
        (n, d), (p, q) = values[top], values[low]
        return ((n * q - p * d, d * q), min(top, low), max(top, low)) if n * q > p * d else (ZERO, 0, 1)
    # The first pair that attains a positive maximum consists of first occurrences, so that repetitions can be left out.
    first: dict[tuple[int, ...], int] = {}
    for i, (weights, _) in enumerate(laws):
        first.setdefault(weights, i)
    best: tuple[Rational, int, int] = (ZERO, 0, 1)
    for i, j in combinations(first.values(), 2):
        distance = _distance(laws[i], laws[j])
        if not _at_most(distance, best[0]):
            best = distance, i, j
    return best


def _distance(left: Law, right: Law) -> Rational:
    (p, m), (q, n) = left, right
    return sum(e for a, b in zip(p, q, strict=True) if (e := a * n - b * m) > 0), m * n


def _greatest_distance(header: Header, compared: Iterable[tuple[Setting, Sequence[Law]]]) -> Maximum | None:
    """Find the greatest distance over all settings; the first one that attains it is kept."""
    best: tuple[Rational, Setting, int, int, Sequence[Law]] | None = None
    for setting, laws in compared:
        distance, higher, lower = _widest_distance(laws)
        if best is None or not _at_most(distance, best[0]):
            best = distance, setting, higher, lower, laws
    if best is None:
        return None
    distance, setting, higher, lower, laws = best
    (p, m), (q, n) = laws[higher], laws[lower]
    raised = [u for u, a, b in zip(header.decisions, p, q, strict=True) if a * n > b * m]
    return Maximum(_reduced(*distance), setting.witness(header, higher, lower) | {"decisions": raised})


def _group_law(cells: Sequence[Cell]) -> tuple[Law, Rational]:
    """Compute P(.|a) and the mean of E(.,a) of a group of positive mass from its cells."""
    terms: list[Vector] = []
    for cell in cells:
        weights, total = cell.law
        n, d = _reduced(cell.mass[0], cell.mass[1] * total)
        terms.append(([n * weight for weight in weights], d))
    summed, denominator = _sum_of_vectors(terms)
    total = sum(summed)  # the mass of the group is total / denominator
    n, d = _sum((cell.mass[0] * cell.expectation[0], cell.mass[1] * cell.expectation[1]) for cell in cells)
    return (tuple(summed), total), _reduced(n * denominator, d * total)


def _populated(table: Table) -> list[int]:
    return [a for a, cells in enumerate(table.by_group()) if any(cell.mass[0] for cell in cells)]


def _lacks_population(table: Table) -> bool:
    return table.header.subject.population == "equal" and not table.complete()


def measure(table: Table) -> dict[str, Maximum | None]:
    """Compute the six metrics of a table."""
    header = table.header
    groups = [] if _lacks_population(table) else _populated(table)
    by_group = table.by_group()
    globally = [_group_law(by_group[a]) for a in groups] if len(groups) > 1 else []
    # The places where groups are compared, with their laws and their expectations.
    everywhere = [(Setting(groups), [law for law, _ in globally], [mean for _, mean in globally])] if globally else []
    contexts = [
        (Setting([c.group for c in cells], x), [c.law for c in cells], [c.expectation for c in cells])
        for x, cells in enumerate(table.by_context())
        if len(cells) > 1
    ]
    metrics: dict[str, Maximum | None] = {}
    for scope, distance, places in (
        ("local", "equalized_odds", contexts),
        ("global", "demographic_parity", everywhere),
    ):
        metrics[scope] = _greatest_ratio(header, ((s, means) for s, _, means in places), "expectations")
        metrics[distance] = _greatest_distance(header, ((s, laws) for s, laws, _ in places))
        single = (
            (replace(s, decision=u), [(weights[u], total) for weights, total in laws])
            for s, laws, _ in places
            for u in range(len(header.decisions))
        )
        metrics[f"{scope}_supremum"] = _greatest_ratio(header, single, "probabilities")
    return metrics


def constants(table: Table) -> dict[str, Rational | bool | None]:
    """Compute the constants of the utility g."""
    given = list(dict.fromkeys(table.header.utility or (g for c in table.cells for g in c.utility if g is not None)))
    top, low = _ends(given)
    contexts = [cells for cells in table.by_context() if len(cells) > 1]
    expectations = [cell.expectation for cells in contexts for cell in cells]
    spreads = [ZERO]
    if table.header.utility is None:
        for cells in contexts:
            for column in zip(*(cell.utility for cell in cells), strict=True):
                entries = [g for g in set(column) if g is not None]
                if len(entries) > 1:
                    i, j = _ends(entries)
                    (n, d), (p, q) = entries[i], entries[j]
                    spreads.append((n * q - p * d, d * q))
    lipschitz = _reduced(*spreads[_ends(spreads)[0]])
    return {
        "gamma": given[top],
        "m": given[low],
        "tau": expectations[_ends(expectations)[1]] if expectations else None,
        "lipschitz": lipschitz,
        "depends_on_group": lipschitz != ZERO,
    }


def not_compared(table: Table) -> Iterator[dict[str, object]]:
    """List what the metrics leave out, and why."""
    header, contexts = table.header, table.by_context()
    for label, cells in zip(header.contexts, contexts, strict=True):
        present = {cell.group for cell in cells}
        missing = [list(group) for a, group in enumerate(header.groups) if a not in present]
        if missing:
            yield {"context": list(label), "groups": missing, "reason": "no decisions recorded"}
    for label, cells in zip(header.contexts, contexts, strict=True):
        if len(cells) < 2:
            yield {"context": list(label), "reason": "fewer than two groups"}
    populated = set(_populated(table))
    empty = [list(header.groups[a]) for a, cells in enumerate(table.by_group()) if cells and a not in populated]
    if empty:
        yield {"groups": empty, "reason": "no population"}
    if _lacks_population(table):
        yield {"quantity": "global", "reason": "a group is missing in a context and no population was given"}
    elif len(populated) < 2:
        yield {"quantity": "global", "reason": "fewer than two groups"}


def independent(table: Table) -> bool:
    """Decide whether context and group are independent: M(x,a) M = M(x,.) M(.,a) for all x and a."""
    if not table.complete():
        return False
    of_context = [_sum(cell.mass for cell in cells) for cells in table.by_context()]
    of_group = [_sum(cell.mass for cell in cells) for cells in table.by_group()]
    whole = _sum(of_context)
    for cell in table.cells:
        x, a, m = of_context[cell.context], of_group[cell.group], cell.mass
        if m[0] * whole[0] * x[1] * a[1] != x[0] * a[0] * m[1] * whole[1]:
            return False
    return True


# ---------------------------------------------------------------------------------------------------------------------
# The certificate

# What a witness of each metric has to name, and whether the metric is a ratio (with a logarithm) or a distance.
METRICS: dict[str, tuple[bool, tuple[str, ...]]] = {
    "local": (True, ("context", "higher", "lower", "expectations")),
    "global": (True, ("higher", "lower", "expectations")),
    "demographic_parity": (False, ("higher", "lower", "decisions")),
    "equalized_odds": (False, ("context", "higher", "lower", "decisions")),
    "local_supremum": (True, ("context", "decision", "higher", "lower", "probabilities")),
    "global_supremum": (True, ("decision", "higher", "lower", "probabilities")),
}


@dataclass(frozen=True)
class Claim:
    """A claim as the certificate states it."""

    key: tuple[str, str, str]  # quantity, relation, by
    value: Rational
    scope: str
    assumptions: tuple[str, ...]
    evidence: dict[str, object]


@dataclass(frozen=True)
class Target:
    """A limit that was asked for, with the verdict that the certificate states."""

    quantity: str
    limit: Rational
    unit: str
    judged: str
    verdict: str


@dataclass(frozen=True)
class Certificate:
    """A certificate as it stands: well formed, and perhaps untrue."""

    subject: Subject
    digest: str
    cells: int
    embedded: tuple[object, ...] | None  # the header and the rows
    constants: dict[str, Rational | bool | None]
    metrics: dict[str, dict[str, object] | None]
    not_compared: list[dict[str, object]]
    claims: tuple[Claim, ...]
    targets: tuple[Target, ...]
    verdict: str


@dataclass(frozen=True)
class Rule:
    """What makes a claim true.

    The metric ``quantity`` must not be null; the claimed value is that of the metric ``source``, with ``by_t7`` put
    through R -> (R - 1) / (R + 1); the evidence is the digest of the table, or the supremum R.
    """

    quantity: str
    source: str
    by_t7: bool = False
    needs_independence: bool = False

    @property
    def evidence(self) -> str:
        """The key of the evidence."""
        return "supremum" if self.by_t7 else "table"


RULES: dict[tuple[str, str, str], Rule] = {
    ("local_ratio", "=", "enumeration"): Rule("local", "local"),
    ("global_ratio", "=", "enumeration"): Rule("global", "global"),
    ("demographic_parity", "=", "enumeration"): Rule("demographic_parity", "demographic_parity"),
    ("equalized_odds", "=", "enumeration"): Rule("equalized_odds", "equalized_odds"),
    ("local_ratio_supremum", "=", "T6"): Rule("local_supremum", "local_supremum"),
    ("global_ratio_supremum", "=", "T6"): Rule("global_supremum", "global_supremum"),
    ("equalized_odds", "<=", "T7"): Rule("equalized_odds", "local_supremum", by_t7=True),
    ("demographic_parity", "<=", "T7"): Rule("demographic_parity", "global_supremum", by_t7=True),
    ("global_ratio", "<=", "T5"): Rule("global", "local", needs_independence=True),
}


def _read_constants(value: object, where: str) -> dict[str, Rational | bool | None]:
    members = _object(value, where, ("gamma", "m", "tau", "lipschitz", "depends_on_group"))
    read: dict[str, Rational | bool | None] = {}
    for key in ("gamma", "m", "tau", "lipschitz"):
        absent = key == "tau" and members[key] is None
        read[key] = None if absent else _rational(members[key], f"{where}.{key}")
    depends = members["depends_on_group"]
    if not isinstance(depends, bool):
        raise _malformed(f"{where}.depends_on_group", f"must be true or false, not {_described(depends)}")
    return read | {"depends_on_group": depends}


_LOG = re.compile(r"0|inf|(?:0|[1-9][0-9]*)\.[0-9]{12}")


def _read_log(value: object, where: str) -> tuple[str, ...]:
    pair = _strings(value, where, 2)
    for i, text in enumerate(pair):
        if not _LOG.fullmatch(text):
            raise _malformed(f"{where}[{i}]", f'must be "0", "inf" or have twelve decimals, not {shown(text)}')
    return pair


def _read_witness(value: object, where: str, keys: Sequence[str], columns: Columns) -> dict[str, object]:
    members = _object(value, where, keys)
    read: dict[str, object] = {}
    for key in keys:
        item, place = members[key], f"{where}.{key}"
        if key == "decision":
            read[key] = _string(item, place)
        elif key == "decisions":
            read[key] = list(_strings(item, place))
        elif key in ("expectations", "probabilities"):
            read[key] = [_rational(number, f"{place}[{i}]") for i, number in enumerate(_list(item, place, 2))]
        else:
            names = columns.context if key == "context" else columns.group
            labels = _object(item, place, names)
            read[key] = {name: _string(labels[name], f"{place}[{shown(name)}]") for name in names}
    return read


def _read_metric(value: object, where: str, name: str, columns: Columns) -> dict[str, object] | None:
    if value is None:
        return None
    is_ratio, names = METRICS[name]
    members = _object(value, where, ("ratio", "log", "witness") if is_ratio else ("value", "witness"))
    read: dict[str, object] = {}
    if is_ratio:
        read["ratio"] = _extended(members["ratio"], f"{where}.ratio")
        read["log"] = _read_log(members["log"], f"{where}.log")
    else:
        read["value"] = _rational(members["value"], f"{where}.value")
    return read | {"witness": _read_witness(members["witness"], f"{where}.witness", names, columns)}


def _read_not_compared(value: object, where: str, columns: Columns) -> dict[str, object]:
    shapes = [("context", "groups", "reason"), ("context", "reason"), ("groups", "reason"), ("quantity", "reason")]
    shape = next((keys for keys in shapes if isinstance(value, dict) and value.keys() == set(keys)), None)
    if shape is None or not isinstance(value, dict):
        raise _malformed(where, f"must be an object with the keys {', or '.join(map(shown, shapes))}")
    for key in shape:
        if key == "groups":
            for i, group in enumerate(_list(value[key], f"{where}.groups")):
                _strings(group, f"{where}.groups[{i}]", len(columns.group))
        elif key == "context":
            _strings(value[key], f"{where}.context", len(columns.context))
        else:
            _string(value[key], f"{where}.{key}")
    return value


def _read_claim(value: object, where: str) -> Claim:
    keys = ("quantity", "relation", "value", "scope", "by", "assumptions", "evidence")
    members = _object(value, where, keys)
    quantity, relation, by = (_string(members[key], f"{where}.{key}") for key in ("quantity", "relation", "by"))
    rule = RULES.get((quantity, relation, by))
    return Claim(
        (quantity, relation, by),
        _extended(members["value"], f"{where}.value"),
        _string(members["scope"], f"{where}.scope"),
        _strings(members["assumptions"], f"{where}.assumptions"),
        _read_evidence(members["evidence"], f"{where}.evidence", rule),
    )


def _read_evidence(value: object, where: str, rule: Rule | None) -> dict[str, object]:
    if rule is None:  # an unknown claim is found false, whatever is offered as evidence
        return _object_of_strings(value, where)
    members = _object(value, where, (rule.evidence,))
    item, place = members[rule.evidence], f"{where}.{rule.evidence}"
    return {rule.evidence: _extended(item, place) if rule.by_t7 else _digest(item, place)}


def _read_target(value: object, where: str) -> Target:
    members = _object(value, where, ("quantity", "limit", "unit", "judged", "verdict"))
    target = Target(
        _one_of(members["quantity"], f"{where}.quantity", ("local", "global")),
        _rational(members["limit"], f"{where}.limit", nonnegative=True),
        _one_of(members["unit"], f"{where}.unit", ("log", "ratio")),
        _string(members["judged"], f"{where}.judged"),
        _one_of(members["verdict"], f"{where}.verdict", ("within", "exceeds", "inconclusive")),
    )
    if target.unit == "ratio" and not _at_most(ONE, target.limit):
        raise _malformed(f"{where}.limit", "must be at least 1, being the limit of a ratio")
    return target


def _read_certificate(raw: bytes) -> Certificate:
    keys = ("format", "subject", "metrics", "not_compared", "claims", "targets", "verdict", "versions")
    top = _object(_decoded(raw, "the certificate"), "the certificate", keys)
    _one_of(top["format"], "format", (CERTIFICATE_FORMAT,))
    about = _object(top["subject"], "subject", ("kind", "columns", "population", "table", "utility"))
    subject = _read_subject(about, "subject")
    table = _object(about["table"], "subject.table", ("sha256", "cells"), optional=("header", "rows"))
    embedded: tuple[object, ...] | None = None
    if "header" in table or "rows" in table:
        table = _object(table, "subject.table", ("sha256", "cells", "header", "rows"))
        embedded = (table["header"], *_list(table["rows"], "subject.table.rows"))
    metrics = _object(top["metrics"], "metrics", tuple(METRICS))
    _object_of_strings(top["versions"], "versions")
    return Certificate(
        subject,
        _digest(table["sha256"], "subject.table.sha256"),
        _integer(table["cells"], "subject.table.cells"),
        embedded,
        _read_constants(about["utility"], "subject.utility"),
        {name: _read_metric(metrics[name], f"metrics.{name}", name, subject.columns) for name in METRICS},
        [
            _read_not_compared(item, f"not_compared[{i}]", subject.columns)
            for i, item in enumerate(_list(top["not_compared"], "not_compared"))
        ],
        tuple(_read_claim(item, f"claims[{i}]") for i, item in enumerate(_list(top["claims"], "claims"))),
        tuple(_read_target(item, f"targets[{i}]") for i, item in enumerate(_list(top["targets"], "targets"))),
        _one_of(top["verdict"], "verdict", ("none", "within", "exceeds", "inconclusive")),
    )


# ---------------------------------------------------------------------------------------------------------------------
# The findings


def _check_subject(stated: Certificate, table: Table) -> Iterator[Finding]:
    yield _compared("subject.table.sha256", stated.digest, table.digest)
    yield _compared("subject.table.cells", stated.cells, len(table.cells) * len(table.header.decisions))
    ours, theirs = stated.subject, table.header.subject
    yield _compared("subject.kind", ours.kind, theirs.kind)
    yield _compared("subject.population", ours.population, theirs.population)
    for name in ("decision", "group", "context"):
        yield _compared(f"subject.columns.{name}", getattr(ours.columns, name), getattr(theirs.columns, name))
    actual = constants(table)
    for key, value in stated.constants.items():
        yield _compared(f"subject.utility.{key}", value, actual[key])


def _check_metrics(stated: Certificate, metrics: Mapping[str, Maximum | None]) -> Iterator[Finding]:
    for name, figures in stated.metrics.items():
        actual = metrics[name]
        if figures is None or actual is None:
            yield _compared(f"metrics.{name}", figures, None if actual is None else actual.value)
            continue
        expected: dict[str, object] = {"value": actual.value, "witness": actual.witness}
        if METRICS[name][0]:
            expected |= {"ratio": actual.value, "log": log_enclosure(actual.value)}
        for key, figure in figures.items():
            yield _compared(f"metrics.{name}.{key}", figure, expected[key])


def _check_not_compared(stated: Certificate, table: Table) -> Finding:
    # One entry at a time: a short table can leave out more pairs of contexts and groups than fit into memory.
    for i, (entry, actual) in enumerate(zip_longest(stated.not_compared, not_compared(table))):
        if entry != actual:
            detail = "the table gives no further entry" if actual is None else f"the table gives {shown(actual)}"
            return _finding(f"not_compared[{i}] is {'not there' if entry is None else shown(entry)}", False, detail)
    return _finding(f"not_compared is {shown(stated.not_compared)}", True)


def _check_claims(stated: Certificate, table: Table, metrics: Mapping[str, Maximum | None]) -> Iterator[Finding]:
    seen: set[tuple[str, str, str]] = set()
    for i, claim in enumerate(stated.claims):
        quantity, relation, by = claim.key
        fault = "a claim that occurs twice" if claim.key in seen else _fault(claim, table, metrics)
        seen.add(claim.key)
        statement = f"claims[{i}]: {shown(quantity)} {shown(relation)[1:-1]} {shown(claim.value)} by {shown(by)}"
        assumed = f"assuming, for the reader to judge, {shown(list(claim.assumptions))}" if claim.assumptions else ""
        yield _finding(statement, not fault, fault or assumed)


def _fault(claim: Claim, table: Table, metrics: Mapping[str, Maximum | None]) -> str:
    """Say what is wrong with a claim; nothing if it is true."""
    rule = RULES.get(claim.key)
    if rule is None or claim.scope != "this law":
        return "unknown claim" if rule is None else f"unknown claim: the scope is {shown(claim.scope)}"
    quantity, source = metrics[rule.quantity], metrics[rule.source]
    if quantity is None or source is None:
        return "the table does not give this quantity"
    if rule.needs_independence and not independent(table):
        return "context and group are not independent in the table"
    n, d = source.value
    value = _reduced(n - d, n + d) if rule.by_t7 else source.value
    if claim.value != value:
        return f"the table gives {shown(value)}"
    if not _at_most(quantity.value, value):
        return f"the table gives the greater quantity {shown(quantity.value)}"
    evidence = source.value if rule.by_t7 else table.digest
    if claim.evidence[rule.evidence] != evidence:
        return f"the evidence is {shown(claim.evidence[rule.evidence])}, the table gives {shown(evidence)}"
    return ""


def _judge(target: Target, metrics: Mapping[str, Maximum | None]) -> str:
    metric = metrics[target.quantity]
    if metric is None:
        return "inconclusive"
    decide = log_at_most if target.unit == "log" else _at_most
    return "within" if decide(metric.value, target.limit) else "exceeds"


def _check_targets(stated: Certificate, metrics: Mapping[str, Maximum | None]) -> Iterator[Finding]:
    verdicts: list[str] = []
    seen: set[tuple[str, str]] = set()
    for i, target in enumerate(stated.targets):
        verdicts.append(_judge(target, metrics))
        fault = "" if target.verdict == verdicts[-1] else f"the table gives {shown(verdicts[-1])}"
        if target.judged != "this table":
            fault = f'judged must be "this table", not {shown(target.judged)}'
        if (target.quantity, target.unit) in seen:
            fault = "a target that occurs twice"
        seen.add((target.quantity, target.unit))
        statement = f"targets[{i}]: {target.quantity} {target.unit}, limit {shown(target.limit)}: {target.verdict}"
        yield _finding(statement, not fault, fault)
    order = ("exceeds", "inconclusive", "within", "none")
    yield _compared("verdict", stated.verdict, next(verdict for verdict in order if verdict in [*verdicts, "none"]))


def check(certificate: bytes, table: Iterable[bytes] | None = None) -> Report:
    """Check every statement of a certificate.

    Parameters
    ----------
    certificate
        The bytes of the certificate file.
    table
        The lines of the table file, each with its line feed. When the certificate embeds its table this is not needed;
        if given nonetheless, it has to be the canonical text of the same table.

    Returns
    -------
    Report
        A finding for each statement.

    Raises
    ------
    FormatError
        If the certificate or the table is not well formed.
    TableNeeded
        If the table is not embedded and not given.
    """
    stated = _read_certificate(certificate)
    findings: list[Finding] = []
    if stated.embedded is not None:
        names = ("subject.table.header", *(f"subject.table.rows[{i}]" for i in range(len(stated.embedded) - 1)))
        law = _read_table((name, value, None) for name, value in zip(names, stated.embedded, strict=True))
        if table is not None:
            digest = hashlib.sha256()
            for line in table:
                digest.update(line)
            findings.append(_compared("the digest of the table file", digest.hexdigest(), law.digest))
    elif table is not None:
        law = _read_table(_lines_of_file(table))
    else:
        raise TableNeeded("The certificate does not embed its table; the file of the table has to be given.")
    metrics = measure(law)
    findings += _check_subject(stated, law)
    findings += _check_metrics(stated, metrics)
    findings.append(_check_not_compared(stated, law))
    findings += _check_claims(stated, law, metrics)
    findings += _check_targets(stated, metrics)
    return Report(tuple(findings), stated.verdict)


# ---------------------------------------------------------------------------------------------------------------------
# The command


def _check_files(path: str, table: str | None) -> Report:
    with open(path, "rb") as file:
        raw = file.read(MAX_BYTES + 1)
    if len(raw) > MAX_BYTES:
        raise _malformed("the certificate", f"is longer than {MAX_BYTES} bytes")
    if table is None:
        return check(raw)
    with open(table, "rb") as file:
        return check(raw, iter(lambda: file.readline(MAX_BYTES), b""))


def _line(finding: Finding) -> str:
    detail = f" ({finding.detail})" if finding.detail else ""
    return f"{'true ' if finding.true else 'FALSE'}  {finding.statement}{detail}"


def _print(lines: Iterable[str]) -> None:
    if sys.stdout is None:  # standard output was closed; the exit code still tells
        return
    encoding = sys.stdout.encoding or "utf-8"
    try:
        for line in lines:
            print(printable(line).encode(encoding, "backslashreplace").decode(encoding))
        sys.stdout.flush()
    except BrokenPipeError:  # nobody reads on; the exit code still tells
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())


def _failed(message: str, code: int) -> int:
    print(printable(message), file=sys.stderr)
    return code


def main(argv: Sequence[str] | None = None) -> int:
    """Run the command.

    Parameters
    ----------
    argv
        The arguments, without the name of the program; those of the process by default.

    Returns
    -------
    int
        The exit code.
    """
    parser = argparse.ArgumentParser(prog="checker.py", description="Check a certificate.", allow_abbrev=False)
    parser.add_argument("certificate", help="the certificate, a JSON file")
    parser.add_argument("--table", metavar="FILE", help="the table, if the certificate does not embed it")
    parser.add_argument("--require", choices=["within"], help="fail unless the verdict is this one")
    try:
        arguments = parser.parse_args(argv)
    except SystemExit as stop:
        return 2 if stop.code else 0
    try:
        report = _check_files(arguments.certificate, arguments.table)
        wrong = sum(not finding.true for finding in report.findings)
        missing = arguments.require is not None and report.verdict != arguments.require
        count = len(report.findings)
        summary = f"{wrong} of {count} statements are FALSE" if wrong else f"all {count} statements are true of the table"
        required = f", but {arguments.require!r} is required" if missing else ""
        _print([*map(_line, report.findings), f"{summary}; the stated verdict is {report.verdict!r}{required}"])
    except TableNeeded as error:
        return _failed(str(error), 3)
    except FormatError as error:
        return _failed(f"Not a certificate of the format {CERTIFICATE_FORMAT}: {error}.", 2)
    except (OSError, ValueError) as error:  # ValueError: a path with a null character
        return _failed(f"Cannot read or write: {error}.", 2)
    except (MemoryError, OverflowError):
        return _failed("The numbers in the certificate or its table need more memory than there is.", 2)
    return 1 if wrong or missing else 0


if __name__ == "__main__":
    sys.exit(main())
