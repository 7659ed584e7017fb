"""Check a certificate of the format ``fairaudit-certificate/1``.

This file stands alone: it uses the Python standard library only, imports nothing of the package that writes
certificates, and runs from a copy of itself::

    python checker.py CERTIFICATE.json [--table FILE] [--require within]

It reads the certificate and the decision table, computes every figure again from the table, and says of each statement
in the certificate whether it is true.  All decisions are made in integers; no floating-point number occurs.

What is trusted: Python's integers, ``fractions``, ``json`` and ``hashlib``; and, for the claims ``by`` T1, T2 and so on,
the theorems of those names.  Nothing that the certificate says is.  What the sentences under ``assumptions`` say cannot be checked,
and they are repeated for the reader; but each claim has to list those that it rests on, word by word, and no others.  A true
certificate is true *of its table*; that the table is genuine is not checked.

Exit codes: 0 every statement is true (and the required verdict is there); 1 a statement is false, or the required
verdict is not there; 2 not a complete certificate of this format, not readable, or wrong usage; 3 the table is not embedded and
was not given.

Rationals are pairs ``(numerator, denominator)`` of integers; infinity is ``(1, 0)``.  Cross-multiplication then orders
all of them, infinity included.  Where no infinity occurs and speed does not matter, they are ``Fraction``.
"""

import argparse
import hashlib
import json
import os
import re
import struct
import sys
import unicodedata
from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextvars import ContextVar
from dataclasses import dataclass, replace
from fractions import Fraction
from functools import cached_property, lru_cache
from itertools import chain, combinations, pairwise, permutations, product, zip_longest
from math import comb, gcd, isqrt, lcm, prod
from operator import add, mul
from typing import Generic, NamedTuple, TypeVar

CERTIFICATE_FORMAT = "fairaudit-certificate/1"
TABLE_FORMAT = "fairaudit-table/1"
MAX_DIGITS = 100_000
MAX_BYTES = 1 << 30  # of a certificate, and of one line of a table
MAX_STEPS = 50_000_000  # of a document with its table; a step is an operation on numbers of at most 256 bits
MAX_BLOCKS = 8_000_000  # that are kept; a block is a number of at most 256 bits
FREE_BYTES = 1_000_000  # of the document and its table; each further byte adds to the steps and blocks
STEPS_PER_BYTE = 250
BLOCKS_PER_BYTE = 8
PAIR_ENTRIES = 500_000  # of the joint likelihood ratios of pairs of rows of a product of filters
LOG_SCALE = 10**12

Rational = tuple[int, int]
Law = tuple[tuple[int, ...], int]  # integer weights of the decisions, and their sum
Labels = tuple[str, ...]

ZERO: Rational = (0, 1)
ONE: Rational = (1, 1)
INFINITY: Rational = (1, 0)


class FormatError(ValueError):
    """The document is not a well-formed certificate (or table) of the format."""


class Incomplete(FormatError):
    """The certificate does not state what its claims assume."""


class TooMuch(FormatError):
    """Checking the certificate would take more work than a document of its length is given."""


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
# Work: counted before it is done, so that a short document cannot keep its reader busy for long


class _Work:
    """What is left of the steps and blocks of a document, and the part of it that is being checked."""

    def __init__(self, steps: int = MAX_STEPS, blocks: int = MAX_BLOCKS) -> None:
        self.steps, self.blocks, self.bytes = steps, blocks, 0
        self.part = "the certificate"

    def grant(self, count: int) -> None:
        """Take note of bytes that were read."""
        before, self.bytes = self.bytes, self.bytes + count
        beyond = max(0, self.bytes - FREE_BYTES) - max(0, before - FREE_BYTES)
        self.steps += STEPS_PER_BYTE * beyond
        self.blocks += BLOCKS_PER_BYTE * beyond

    def refusal(self, limit: str) -> TooMuch:
        """Say which limit was hit, and where."""
        size = "1 MB" if self.bytes <= FREE_BYTES else f"{self.bytes} bytes"
        return TooMuch(f"{self.part} takes more than {limit} of a document of {size}")


_WORK: ContextVar[_Work | None] = ContextVar("_WORK", default=None)


def _spend(times: int, left: int = 0, right: int = 0) -> None:
    """Count operations that are about to be made on numbers of so many bits: products, quotients, greatest common divisors."""
    work = _WORK.get()
    if work is not None:
        work.steps -= times * (1 + (left >> 8)) * (1 + (right >> 8))
        if work.steps < 0:
            raise work.refusal("the steps")


def _keep(count: int, bits: int = 0) -> None:
    """Count numbers of so many bits that are about to be kept."""
    work = _WORK.get()
    if work is not None:
        work.blocks -= count * (1 + (bits >> 8))
        if work.blocks < 0:
            raise work.refusal("the memory")


def _working_on(part: str) -> None:
    work = _WORK.get()
    if work is not None:
        work.part = part


def _granted(count: int) -> None:
    work = _WORK.get()
    if work is not None:
        work.grant(count)


def _bits(*values: Fraction | Rational) -> int:
    """Count the bits of some rationals together."""
    total = 0
    for value in values:
        n, d = (value.numerator, value.denominator) if isinstance(value, Fraction) else value
        total += n.bit_length() + d.bit_length()
    return total


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


def _written(value: Rational) -> str:
    """Write a finite rational in full, as the format has it."""
    numerator, denominator = value
    sign = "-" * (numerator < 0)
    return sign + _decimal_digits(abs(numerator)) + (f"/{_decimal_digits(denominator)}" if denominator != 1 else "")


def _decimal_digits(number: int) -> str:
    """Write a number by halves: Python refuses to write long ones at once."""
    if number.bit_length() <= 1500:
        return str(number)
    half = number.bit_length() * 3 // 20
    upper, lower = divmod(number, 10**half)
    return _decimal_digits(upper) + _decimal_digits(lower).zfill(half)


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


_ENCODER = json.JSONEncoder(ensure_ascii=True, sort_keys=True, separators=(",", ":"))


def _canonical(value: object) -> bytes:
    return _ENCODER.encode(value).encode("ascii") + b"\n"


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
    known = {*keys, *optional}
    for key in value:
        if key not in known:
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


def _boolean(value: object, where: str) -> bool:
    if not isinstance(value, bool):
        raise _malformed(where, f"must be true or false, not {_described(value)}")
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
    if len(above) > 500 or (below is not None and len(below) > 500):
        digits = max(len(above), len(below or ""))
        _spend(3, 4 * digits, 4 * digits)
        _keep(1, 4 * (len(above) + len(below or "")))
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


@lru_cache(maxsize=1 << 14)
def _short(text: str) -> Rational:
    """Read a rational that is not negative and has few digits: tables repeat those."""
    return _rational(text, "", nonnegative=True)


def _rationals(value: object, where: str, length: int) -> list[Rational]:
    items = _list(value, where, length)
    try:
        return [_short(item) if isinstance(item, str) and len(item) <= 40 else _rational(item, "", nonnegative=True) for item in items]
    except FormatError:  # to be said again with its place
        return [_rational(item, f"{where}[{i}]", nonnegative=True) for i, item in enumerate(items)]


def _reduced(numerator: int, denominator: int) -> Rational:
    if denominator.bit_length() > 512:
        _spend(3, numerator.bit_length(), denominator.bit_length())
    divisor = gcd(numerator, denominator)
    return numerator // divisor, denominator // divisor


def _product(factors: Iterable[Rational]) -> Rational:
    numerators, denominators = zip(*factors, strict=True)
    for numbers in (numerators, denominators):
        bits = sum(number.bit_length() for number in numbers)
        _spend(1, bits, bits)
    return _reduced(prod(numerators), prod(denominators))


def _at_most(left: Rational, right: Rational) -> bool:
    return left[0] * right[1] <= right[0] * left[1]


def _common(denominators: Iterable[int]) -> int:
    """Find the least common multiple."""
    common = 1
    for denominator in denominators:
        if (bits := common.bit_length()) > 256:
            _spend(3, bits, denominator.bit_length())
        common = lcm(common, denominator)
    return common


def _over_common_denominator(values: Sequence[Rational]) -> tuple[list[int], int]:
    common = _common({denominator for _, denominator in values})
    if common == 1:
        return [numerator for numerator, _ in values], 1
    if (bits := common.bit_length()) > 256:
        _spend(2 * len(values), bits, max(d.bit_length() + n.bit_length() for n, d in values))
        _keep(len(values), 2 * bits)
    return [numerator * (common // denominator) for numerator, denominator in values], common


def _spend_on_order(first: Rational, rest: Sequence[Rational]) -> None:
    """Count the steps of comparing numbers with the extremes of those before."""
    bits = max(first[0].bit_length(), first[1].bit_length())
    for n, d in rest:
        bits = max(bits, n.bit_length(), d.bit_length())
    _spend(4 * len(rest), bits, bits)


def _ends(values: Iterable[Rational]) -> tuple[int, int]:
    """Find the positions of the first greatest and the first least of some rationals."""
    first, *rest = values
    _spend_on_order(first, rest)
    greatest, least = first, first
    top, low = 0, 0
    for i, value in enumerate(rest, 1):
        if value[0] * greatest[1] > greatest[0] * value[1]:
            greatest, top = value, i
        if value[0] * least[1] < least[0] * value[1]:
            least, low = value, i
    return top, low


def _maximum(values: Sequence[Rational]) -> Rational:
    return _reduced(*values[_ends(values)[0]])


Vector = tuple[list[int], int]  # numerators over one denominator


class _Total:
    """A running sum of vectors of rationals, in which long denominators occur in few additions only.

    Each part is the sum of 2^rank terms, but for those that were added where the denominator was the same already.  The
    ranks of the parts decrease, as the digits of a binary counter do: two parts of one rank become one of the next.
    """

    def __init__(self) -> None:
        self.parts: list[tuple[int, Vector]] = []

    def add(self, numerators: list[int], denominator: int) -> None:
        """Add a vector."""
        if (bits := denominator.bit_length()) > 256:
            _keep(len(numerators), 2 * bits)
        parts = self.parts
        if parts and parts[-1][1][1] == denominator:
            own = parts[-1][1][0]
            own[:] = map(add, own, numerators)
            return
        rank, term = 0, (numerators, denominator)
        while parts and parts[-1][0] == rank:
            term = _sum_of_two(parts.pop()[1], term)
            rank += 1
        parts.append((rank, term))

    def value(self) -> Vector:
        """The sum of what was added, at least one vector."""
        rank, term = self.parts.pop()
        while self.parts:
            rank, part = self.parts.pop()
            term = _sum_of_two(part, term)
        self.parts.append((rank, term))
        return term


def _sum_of_two(left: Vector, right: Vector) -> Vector:
    one, other = left[1].bit_length(), right[1].bit_length()
    if one + other > 256:
        widest = max(map(int.bit_length, chain(left[0], right[0])))
        _spend(2 * len(left[0]) + 3, one + other, max(widest, one, other))
        _keep(len(left[0]), one + other + widest)
    divisor = gcd(left[1], right[1])
    p, q = right[1] // divisor, left[1] // divisor
    return [a * p + b * q for a, b in zip(left[0], right[0], strict=True)], left[1] * p


def _sum(values: Iterable[Rational]) -> Rational:
    total = _Total()
    for n, d in values:
        total.add([n], d)
    (numerator,), denominator = total.value()
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
    _spend(4 * (roots + bits // (roots + 4)) + 40, bits, bits)
    _spend(2, n.bit_length() + bits, d.bit_length())
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
    truth: str | None = None


@dataclass(frozen=True)
class Positive:
    """Which decisions and which true label count as positive, as the certificate states it."""

    decision: tuple[str, ...]
    truth: str


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
    groups: tuple[Labels, ...]
    contexts: tuple[Labels, ...]
    utility: tuple[Rational, ...] | None
    group_filter: "Filter | None" = None  # of a policy, and of no other subject
    context_filter: "Filter | None" = None
    truths: tuple[str, ...] | None = None  # the true labels


class Cell(NamedTuple):
    """What is known of (x,a): P(u|x,a) is ``law``, M(x,a) is ``mass`` and E(x,a) is ``expectation``."""

    context: int
    group: int
    law: Law
    mass: Rational
    expectation: Rational
    utility: Sequence[Rational | None]


@dataclass(frozen=True)
class Table:
    """A decision table, the number of its rows, the digest of its canonical text, and the figures of its cells.

    The cells themselves are there if they were kept.  The table of a policy is that of the law which the policy and
    its filters induce.
    """

    header: Header
    kept: tuple[Cell, ...] | None
    rows: int
    digest: str
    figures: "Figures"
    policy: "Policy | None" = None
    given: "GivenTruth | None" = None

    @property
    def cells(self) -> tuple[Cell, ...]:
        """The cells, which have to be there."""
        if self.kept is None:
            raise AssertionError
        return self.kept

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


def _read_columns(value: object, where: str) -> Columns:
    members = _object(value, where, ("decision", "group", "context"), optional=("truth",))
    columns = Columns(
        _string(members["decision"], f"{where}.decision"),
        _strings(members["group"], f"{where}.group"),
        _strings(members["context"], f"{where}.context"),
        _string(members["truth"], f"{where}.truth") if "truth" in members else None,
    )
    names = (columns.decision, *columns.group, *columns.context, *([] if columns.truth is None else [columns.truth]))
    if not columns.group:
        raise _malformed(f"{where}.group", "must name at least one column")
    if len(set(names)) != len(names):
        raise _malformed(where, "names a column twice")
    return columns


def _read_subject(members: Mapping[str, object], where: str) -> Subject:
    kind = _one_of(members["kind"], f"{where}.kind", ("counts", "probabilities", "policy"))
    populations = ("counts",) if kind == "counts" else ("weights", "equal")
    population = _one_of(members["population"], f"{where}.population", populations)
    columns = _read_columns(members["columns"], f"{where}.columns")
    if kind != "counts" and columns.truth is not None:
        raise _malformed(f"{where}.columns.truth", "must not be there: only counts have true labels")
    return Subject(kind, columns, population)


def _has_truth(value: object) -> bool:
    """Whether an object has a column of true labels."""
    columns = value.get("columns") if isinstance(value, dict) else None
    return isinstance(columns, dict) and "truth" in columns


def _read_positive(value: object, where: str) -> Positive:
    members = _object(value, where, ("decision", "truth"))
    decisions = _strings(members["decision"], f"{where}.decision")
    _check_distinct(decisions, f"{where}.decision")
    return Positive(decisions, _string(members["truth"], f"{where}.truth"))


def _read_label_lists(value: object, where: str, width: int) -> tuple[Labels, ...]:
    lists = tuple(_strings(item, f"{where}[{i}]", width) for i, item in enumerate(_list(value, where)))
    _check_distinct(lists, where)
    return lists


def _check_distinct(items: Sequence[object], where: str) -> None:
    if not items:
        raise _malformed(where, "must not be empty")
    if len(set(items)) != len(items):
        raise _malformed(where, "lists something twice")


def _read_header(value: object, where: str) -> Header:
    keys = ["format", "kind", "columns", "population", "decisions", "groups", "contexts", "utility"]
    of_policy = _is_about_policy(value)
    members = _object(value, where, keys + ["filters"] * of_policy + ["truths"] * _has_truth(value), optional=("salt",))
    _one_of(members["format"], f"{where}.format", (TABLE_FORMAT,))
    if "salt" in members:
        _hexadecimal(members["salt"], f"{where}.salt", "0123456789abcdefABCDEF", 32)
    subject = _read_subject(members, where)
    decisions = _strings(members["decisions"], f"{where}.decisions")
    _check_distinct(decisions, f"{where}.decisions")
    utility = members["utility"]
    header = Header(
        subject,
        decisions,
        _read_label_lists(members["groups"], f"{where}.groups", len(subject.columns.group)),
        _read_label_lists(members["contexts"], f"{where}.contexts", len(subject.columns.context)),
        None if utility is None else tuple(_rationals(utility, f"{where}.utility", len(decisions))),
    )
    if "truths" in members:
        header = replace(header, truths=_strings(members["truths"], f"{where}.truths"))
        _check_distinct(header.truths or (), f"{where}.truths")
    if not of_policy:
        return header
    filters = _object(members["filters"], f"{where}.filters", ("group", "context"))
    group = _read_filter(filters["group"], f"{where}.filters.group", len(subject.columns.group))
    context = None
    if filters["context"] is not None:
        context = _read_filter(filters["context"], f"{where}.filters.context", len(subject.columns.context))
    if group.size < 2:
        raise _malformed(f"{where}.filters.group", "has fewer than two inputs")
    true_contexts = context.size if context else len(header.contexts)
    _working_on("the law that the filters induce")
    _spend(true_contexts * (group.size * (100 + 10 * len(decisions)) + 3 * group.released * len(decisions)))
    _keep(true_contexts * (12 * group.size + max(group.size, group.released) * len(decisions)))
    return replace(header, group_filter=group, context_filter=context)


def _is_about_policy(value: object) -> bool:
    return isinstance(value, dict) and value.get("kind") == "policy"


def _read_filter(value: object, where: str, columns: int) -> "Filter":
    factors = tuple(_read_factor(item, f"{where}[{i}]") for i, item in enumerate(_list(value, where)))
    if not factors or sum(len(factor.inputs[0]) for factor in factors) != columns:
        raise _malformed(where, f"must have factors that cover {columns} columns together")
    return Filter(factors)


def _read_factor(value: object, where: str) -> "Factor":
    members = _object(value, where, ("inputs", "outputs", "rows"))
    width = len(_strings(next(iter(_list(members["inputs"], f"{where}.inputs")), []), f"{where}.inputs[0]"))
    if width == 0:
        raise _malformed(f"{where}.inputs", "must list labels")
    inputs = _read_label_lists(members["inputs"], f"{where}.inputs", width)
    outputs = _read_label_lists(members["outputs"], f"{where}.outputs", width)
    rows = [
        _rationals(row, f"{where}.rows[{i}]", len(outputs)) for i, row in enumerate(_list(members["rows"], f"{where}.rows", len(inputs)))
    ]
    entries, total = _over_common_denominator([entry for row in rows for entry in row])
    matrix = [entries[i : i + len(outputs)] for i in range(0, len(entries), len(outputs))]
    for i, row in enumerate(matrix):
        if sum(row) != total:
            raise _malformed(f"{where}.rows[{i}]", "are probabilities that do not sum to 1")
    released = [j for j, column in enumerate(zip(*matrix, strict=True)) if any(column)]
    return Factor(inputs, tuple(outputs[j] for j in released), [[row[j] for j in released] for row in matrix], total)


def _read_row(
    value: object, where: str, header: Header, keys: Sequence[str], optional: Sequence[str] = ()
) -> tuple[dict[str, object], tuple[int, int], Law, Rational]:
    """Read a line with weights: its members, context and group, the law, and the sum of the weights."""
    members = _object(value, where, ("context", "group", "weights", *keys), optional)
    weights, denominator = _over_common_denominator(_rationals(members["weights"], f"{where}.weights", len(header.decisions)))
    total = sum(weights)
    if total == 0:
        raise _malformed(f"{where}.weights", "are all zero")
    if header.subject.kind != "counts" and total != denominator:
        raise _malformed(f"{where}.weights", "are probabilities that do not sum to 1")
    return members, _read_place(members, where, header), _law(weights, total), _reduced(total, denominator)


def _read_place(members: Mapping[str, object], where: str, header: Header, prefix: str = "") -> tuple[int, int]:
    return (
        _integer(members[f"{prefix}context"], f"{where}.{prefix}context", len(header.contexts)),
        _integer(members[f"{prefix}group"], f"{where}.{prefix}group", len(header.groups)),
    )


def _law(weights: Sequence[int], total: int) -> Law:
    """Divide by the common factor: then equal laws have equal weights, which saves comparisons later."""
    if (bits := total.bit_length()) > 256:
        _spend(2 * len(weights), bits, bits)
        _keep(len(weights), bits)
    divisor = gcd(*weights)
    return tuple(weight // divisor for weight in weights), total // divisor


def _given_with_cells(header: Header) -> list[str]:
    named = {"mass": header.subject.population == "weights", "utility": header.utility is None, "truth": header.truths is not None}
    return [key for key, is_there in named.items() if is_there]


def _read_given(
    members: Mapping[str, object], where: str, header: Header, weights: Sequence[int]
) -> tuple[Rational, Sequence[Rational | None]]:
    """Read the mass and the utility of a cell, so far as the lines give them."""
    mass = _rational(members["mass"], f"{where}.mass", nonnegative=True) if "mass" in members else ONE
    if header.utility is not None:
        return mass, header.utility
    return mass, _read_utility(members["utility"], f"{where}.utility", weights)


def _read_utility(value: object, where: str, weights: Sequence[int]) -> tuple[Rational | None, ...]:
    entries: list[Rational | None] = []
    for i, (item, weight) in enumerate(zip(_list(value, where, len(weights)), weights, strict=True)):
        if item is None and weight:
            raise _malformed(f"{where}[{i}]", "is null where the weight is positive")
        entries.append(None if item is None else _rational(item, f"{where}[{i}]", nonnegative=True))
    return tuple(entries)


def _gains(utility: Sequence[Rational | None]) -> Vector:
    return _over_common_denominator([ZERO if entry is None else entry for entry in utility])


def _mean(weights: Sequence[int], total: int, gains: Vector) -> Rational:
    if total.bit_length() + gains[1].bit_length() > 256:
        _spend(2 * len(weights), total.bit_length(), max(map(int.bit_length, gains[0])) + gains[1].bit_length())
    return _reduced(sum(map(mul, weights, gains[0])), total * gains[1])


def _expectation(law: Law, utility: Sequence[Rational | None]) -> Rational:
    return _mean(*law, _gains(utility))


def _read_table(lines: Iterable[tuple[str, object, bytes | None]], keep: bool = True, positive: Positive | None = None) -> Table:
    """Read a table from (where, value, bytes in the file or None if embedded), the header first.

    What is read is not kept when only the figures of the table are needed.  Figures given the true label need to know what is positive.
    """
    digest = hashlib.sha256()
    reader: _Rows | None = None
    for where, value, raw in lines:
        if reader is None:
            header = _read_header(value, where)
            reader = _Rows(header, keep, positive) if header.group_filter is None else _PolicyRows(header, header.group_filter)
        else:
            reader.add(value, where)
        if raw is not None:
            _granted(len(raw))
        text = _canonical(value)
        if raw is not None and raw != text:
            raise _malformed(where, "is not the canonical text of its value, ended by one line feed")
        digest.update(text)
    if reader is None:
        raise _malformed("the table", "is empty")
    return reader.table(digest.hexdigest())


class _Rows:
    """The lines of a table after its header, as they are read."""

    def __init__(self, header: Header, keep: bool = True, positive: Positive | None = None) -> None:
        self.header = header
        self.given_truth = None if header.truths is None or positive is None else GivenTruth(header, positive)
        self.figures = Figures(header)
        self.kept: list[Cell] | None = [] if keep else None
        self.keys = _given_with_cells(header)
        self.gains = None if header.utility is None else _gains(header.utility)
        self.last = (-1, -1)

    def add(self, value: object, where: str) -> None:
        """Read one more line."""
        members, place, law, total = _read_row(value, where, self.header, self.keys)
        mass, utility = _read_given(members, where, self.header, law[0]) if self.keys else (ONE, self.header.utility or ())
        if self.header.subject.kind == "counts":
            mass = total
        self.follow(place, where)
        if self.header.truths is not None:
            counts = _read_truth(members["truth"], f"{where}.truth", self.header, law, total)
            if self.given_truth is not None:
                self.given_truth.add(place, counts)
        cell = Cell(*place, law, mass, _mean(*law, self.gains or _gains(utility)), utility)
        self.figures.add(cell)
        if self.kept is not None:
            self.kept.append(cell)

    def follow(self, place: tuple[int, int], where: str) -> None:
        """Make sure that the lines are sorted."""
        if place <= self.last:
            raise _malformed(where, "is not in increasing order of context and group")
        self.last = place

    def table(self, digest: str) -> Table:
        """Put the lines together."""
        figures = self.figures.of_all()
        if self.header.utility is None and not figures.cells:
            raise _malformed("the table", "gives no utility at all")
        _check_masses(self.header, figures.masses())
        kept = None if self.kept is None else tuple(self.kept)
        return Table(self.header, kept, figures.cells, digest, figures, given=self.given_truth)


def _read_truth(value: object, where: str, header: Header, law: Law, total: Rational) -> tuple[list[list[int]], int]:
    """Read how the weights of a row are spread over the true labels, as integers over one denominator."""
    size = len(header.decisions)
    parts = [_rationals(item, f"{where}[{i}]", size) for i, item in enumerate(_list(value, where, len(header.truths or ())))]
    flat, below = _over_common_denominator([entry for part in parts for entry in part])
    counts = [flat[i : i + size] for i in range(0, len(flat), size)]
    weights, law_total = law
    for u, column in enumerate(zip(*counts, strict=True)):
        if sum(column) * law_total * total[1] != weights[u] * total[0] * below:
            raise _malformed(where, "is spread over the true labels so that it does not sum to the weights")
    return counts, below


def _check_masses(header: Header, masses: Sequence[Rational]) -> None:
    if header.subject.population == "weights" and (not masses or _sum(masses) != ONE):
        raise _malformed("the table", "has masses that do not sum to 1")


def _lines_of_file(lines: Iterable[bytes]) -> Iterator[tuple[str, object, bytes]]:
    for number, line in enumerate(lines, 1):
        where = f"line {number} of the table"
        yield where, _decoded(line, where), line


# ---------------------------------------------------------------------------------------------------------------------
# A policy behind filters


@dataclass(frozen=True)
class _Map:
    """A linear map: row i of its matrix is ``scale * base`` plus some further ``(column, coefficient)``, over ``denominator``.

    Where a filter keeps the truth or else draws from one distribution, each row has one or two further entries.
    """

    base: Sequence[int]
    rows: Sequence[tuple[int, Sequence[tuple[int, int]]]]
    denominator: int

    def applied(self, values: list[int], step: int) -> list[int]:
        """Multiply along one axis of a tensor, the neighbours on which are ``step`` apart."""
        result: list[int] = []
        width = len(self.base)
        bits = max(map(int.bit_length, values))
        own = max(self.denominator.bit_length(), *map(int.bit_length, self.base))
        terms = width + len(self.rows) + sum(len(further) for _, further in self.rows)
        _spend(len(values) // width * terms, bits, own)
        if bits + own > 256:
            _keep(len(values) // width * len(self.rows), bits + own)
        for start in range(0, len(values), step * width):
            parts = [values[i : i + step] for i in range(start, start + step * width, step)]
            common = _combination(self.base, parts)
            for scale, further in self.rows:
                result += _combination([scale, *(c for _, c in further)], [common, *(parts[j] for j, _ in further)])
        return result


def _combination(coefficients: Sequence[int], vectors: Sequence[list[int]]) -> list[int]:
    kept = [(c, vector) for c, vector in zip(coefficients, vectors, strict=True) if c]
    if not kept:
        return [0] * len(vectors[0])
    factors = [c for c, _ in kept]
    return [sum(map(mul, factors, entries)) for entries in zip(*(vector for _, vector in kept), strict=True)]


def _map(matrix: Sequence[Sequence[int]], total: int) -> _Map:
    """Find the base: the most frequent entry of each column; a row that follows it in half of its entries is a multiple of it."""
    entries = len(matrix) * len(matrix[0])
    _spend(12 * entries, total.bit_length(), total.bit_length())
    base = [Counter(column).most_common(1)[0][0] for column in zip(*matrix, strict=True)]
    multiples: list[Rational] = []
    for row in matrix:
        ratios = Counter(_reduced(entry, common) for entry, common in zip(row, base, strict=True) if common)
        [(multiple, count)] = ratios.most_common(1) or [(ZERO, 0)]
        multiples.append(multiple if 2 * count >= len(row) else ZERO)
    unit = _common({d for _, d in multiples})
    if (bits := unit.bit_length()) > 256:
        _spend(entries, bits, total.bit_length())
        _keep(entries, bits + total.bit_length())
    rows: list[tuple[int, list[tuple[int, int]]]] = []
    for row, (n, d) in zip(matrix, multiples, strict=True):
        scale = n * (unit // d)
        rests = [entry * unit - scale * common for entry, common in zip(row, base, strict=True)]
        rows.append((scale, [(j, rest) for j, rest in enumerate(rests) if rest]))
    return _Map(base, rows, total * unit)


def _through(values: list[int], maps: Sequence[_Map]) -> list[int]:
    """Apply each map along its own axis, the last of them varying fastest (but for a last axis that none of them touches)."""
    sizes = [len(m.base) for m in maps]
    width = len(values) // prod(sizes)
    for i in sorted(range(len(maps)), key=lambda i: len(maps[i].rows) > sizes[i]):  # what shrinks the tensor goes first
        values = maps[i].applied(values, width * prod(sizes[i + 1 :]))
        sizes[i] = len(maps[i].rows)
    return values


def _mixed(laws: Sequence[Law], maps: Sequence[_Map]) -> list[Law]:
    """Mix laws, listed by what is released (a last axis may be left alone), into the laws by what is true."""
    width = len(laws[0][0])
    common = _common({total for _, total in laws})
    if (bits := common.bit_length()) > 256:
        _spend(len(laws) * width, bits, bits)
        _keep(len(laws) * width, bits)
    values = _through([weight * (common // total) for weights, total in laws for weight in weights], maps)
    total = common * prod(m.denominator for m in maps)
    return [_law(values[i : i + width], total) for i in range(0, len(values), width)]


Distribution = tuple[tuple[int, int], ...]  # pairs (p, q), sorted: what two rows give to the outputs, by likelihood ratio p/q


def _by_likelihood_ratio(pairs: Iterable[tuple[int, int]]) -> Distribution:
    """Add up the pairs of equal p/q; those with p = 0 add nothing to any H_k."""
    sums: Counter[tuple[int, int]] = Counter()
    for p, q in pairs:
        if p:
            divisor = gcd(p, q)
            sums[p // divisor, q // divisor] += divisor
    return tuple(sorted((p * n, q * n) for (p, q), n in sums.items()))


@dataclass(frozen=True)
class Factor:
    """One part of a filter, without the outputs that are never released; ``matrix`` is over ``total``."""

    inputs: tuple[Labels, ...]
    outputs: tuple[Labels, ...]
    matrix: list[list[int]]
    total: int

    @cached_property
    def map(self) -> _Map:
        """The matrix, to be applied to laws that are listed by output."""
        return _map(self.matrix, self.total)

    @cached_property
    def exp_epsilon(self) -> Rational:
        """The greatest ratio of two entries of a column."""
        columns = ([(entry, 1) for entry in column] for column in zip(*self.matrix, strict=True))
        ratios = [_widest_ratio(column)[0] for column in columns] if len(self.inputs) > 1 else [ONE]
        return _maximum(ratios)

    def pairs(self) -> set[Distribution]:
        """List the different distributions of p/q over the ordered pairs of rows of different inputs."""
        rows, bits = len(self.matrix), self.total.bit_length()
        _spend(rows * (rows - 1) * (len(self.outputs) + 4), bits, bits)
        alike: set[frozenset[tuple[tuple[int, int], int]]] = set()
        found: set[Distribution] = set()
        entries = 0
        for one, other in permutations(self.matrix, 2):
            counts = frozenset(Counter(zip(one, other, strict=True)).items())
            if counts not in alike:
                _keep(4 * len(counts), bits)
                alike.add(counts)
                distribution = _by_likelihood_ratio((p * n, q * n) for (p, q), n in counts)
                if distribution not in found:
                    found.add(distribution)
                    entries += len(distribution)
                    _check_entries(entries, bits)
        return found


@dataclass(frozen=True)
class Filter:
    """The product of its factors: they draw independently of each other."""

    factors: tuple[Factor, ...]

    @property
    def size(self) -> int:
        """The number of joint inputs."""
        return prod(len(factor.inputs) for factor in self.factors)

    @property
    def released(self) -> int:
        """The number of joint outputs that can be released."""
        return prod(len(factor.outputs) for factor in self.factors)

    @property
    def maps(self) -> list[_Map]:
        """The maps of the factors."""
        return [factor.map for factor in self.factors]

    @property
    def inputs(self) -> list[Labels]:
        """The joint inputs, the last factor varying fastest."""
        return [tuple(chain(*parts)) for parts in product(*(factor.inputs for factor in self.factors))]

    @property
    def outputs(self) -> list[Labels]:
        """The joint outputs that can be released."""
        return [tuple(chain(*parts)) for parts in product(*(factor.outputs for factor in self.factors))]

    def releases(self) -> list[list[int]]:
        """List for each joint input which of the joint outputs it can release."""
        size = prod(sum(map(bool, chain.from_iterable(factor.matrix))) for factor in self.factors)
        _spend(2 * size)
        _keep(size // 4)
        lists = [[0]]
        for factor in self.factors:
            own = [[j for j, entry in enumerate(row) if entry] for row in factor.matrix]
            lists = [[i * len(factor.outputs) + j for i in before for j in after] for before in lists for after in own]
        return lists

    def matrix(self) -> tuple[list[list[int]], int]:
        """Multiply out the probabilities of the joint outputs under each joint input, over one denominator."""
        bits = sum(factor.total.bit_length() for factor in self.factors)
        _spend(self.size * self.released * 2, bits, bits)
        _keep(self.size * self.released, bits)
        rows = [[1]]
        for factor in self.factors:
            rows = [[p * q for p in before for q in after] for before in rows for after in factor.matrix]
        return rows, prod(factor.total for factor in self.factors)

    @property
    def exp_epsilon(self) -> Rational:
        """The greatest ratio of the probabilities of one output under two inputs."""
        return _product(factor.exp_epsilon for factor in self.factors)

    @cached_property
    def pairs(self) -> tuple[set[Distribution], int]:
        """The different distributions of p/q over ordered pairs of different joint inputs, and the unit of p and q.

        Two joint inputs differ in some factors, at least one, and agree in the others.
        """
        unit = 1
        differing: set[Distribution] = set()
        for factor in self.factors:
            agree: Distribution = ((factor.total, factor.total),)
            own = factor.pairs()
            before = differing
            entries = (1 + sum(map(len, before))) * (1 + sum(map(len, own)))
            bits = unit.bit_length() + factor.total.bit_length()
            _check_entries(entries, bits)
            _spend(20 * entries, bits, bits)
            _keep(2 * entries, 2 * bits)
            differing = {_joint(pair, other) for pair in before for other in {*own, agree}}
            differing |= {_joint(((unit, unit),), other) for other in own}
            unit *= factor.total
        return differing, unit


def _check_entries(entries: int, bits: int) -> None:
    if entries * (1 + (bits >> 8)) ** 2 > PAIR_ENTRIES:
        raise TooMuch(f"the pairs of rows of the group filter have more than {PAIR_ENTRIES} joint likelihood ratios")


def _joint(one: Distribution, other: Distribution) -> Distribution:
    return _by_likelihood_ratio((p * r, q * s) for p, q in one for r, s in other)


@dataclass(frozen=True)
class Policy:
    """What claims about a policy need to know of it besides the law that it induces with its filters.

    ``rows`` are the laws by released context and released group, ``by_context`` those by true context and released
    group, both for the released values that are reachable only.  ``draws`` tells how many decisions each of the rows
    was estimated from; it is empty when the policy is not a sample.
    """

    group: Filter
    context: Filter | None
    rows: list[list[Law]]
    by_context: list[list[Law]]
    unfiltered: Table | None
    draws: list[list[int]]
    header: Header  # with the labels of the policy's own rows
    drawn: int  # all draws together, also for what is never released


class _PolicyRows(_Rows):
    """The lines of a policy's table: the rows of the policy, then the true cells if masses or utilities are given."""

    def __init__(self, header: Header, group: Filter) -> None:
        super().__init__(header)
        self.group, self.context = group, header.context_filter
        self.true = replace(header, groups=tuple(self.group.inputs))
        if self.context is not None:
            self.true = replace(self.true, contexts=tuple(self.context.inputs))
        self.laws: dict[tuple[int, int], Law] = {}
        self.draws: dict[tuple[int, int], int] = {}
        self.given: list[tuple[Rational, Sequence[Rational | None]]] = []

    def add(self, value: object, where: str) -> None:
        """Read a row of the policy, or a true cell."""
        if isinstance(value, dict) and "true_group" in value:
            self._add_true_cell(value, where)
            return
        members, place, law, _ = _read_row(value, where, self.header, (), optional=("draws",))
        if self.given:
            raise _malformed(where, "is a row of the policy after a true cell")
        self.follow(place, where)
        self.laws[place] = law
        if "draws" in members:
            self.draws[place] = _integer(members["draws"], f"{where}.draws")
            if self.draws[place] == 0 or self.draws[place] % law[1]:  # the weights are in lowest terms over law[1]
                raise _malformed(f"{where}.draws", "must be positive, and whole when multiplied with any of the weights")

    def _add_true_cell(self, value: object, where: str) -> None:
        keys = _given_with_cells(self.header)
        members = _object(value, where, ("true_context", "true_group", *keys))
        place = _read_place(members, where, self.true, "true_")
        if not keys or place != divmod(len(self.given), len(self.true.groups)):
            raise _malformed(where, "is not the next true cell, or none is needed")
        every = [1] * len(self.header.decisions)  # each decision has to have its utility
        self.given.append(_read_given(members, where, self.header, every))

    def _released(self) -> list[list[tuple[int, int]]]:
        """List the places of the policy's rows by reachable context and reachable group."""
        if (len(self.header.contexts) if self.context is None else self.context.released) * self.group.released > len(self.laws):
            raise _malformed("the table", "lacks a row of the policy for what the filters can release")
        contexts = self.header.contexts if self.context is None else self.context.outputs
        groups = self.group.outputs
        places = self._rows_of(contexts, groups)
        if len(places) < len(contexts) * len(groups):
            x, a = next(labels for labels in product(contexts, groups) if labels not in places)
            raise _malformed("the table", f"lacks a row of the policy for {shown(x)} and {shown(a)}, which can be released")
        return [[places[x, a] for a in groups] for x in contexts]

    def _rows_of(self, contexts: Sequence[Labels], groups: Sequence[Labels]) -> dict[tuple[Labels, Labels], tuple[int, int]]:
        """Find the places of the policy's rows, so far as there are any, for some contexts and groups."""
        context_at = {label: i for i, label in enumerate(self.header.contexts)}
        group_at = {label: i for i, label in enumerate(self.header.groups)}
        places = {(x, a): (context_at.get(x, -1), group_at.get(a, -1)) for x, a in product(contexts, groups)}
        return {labels: place for labels, place in places.items() if place in self.laws}

    def table(self, digest: str) -> Table:
        """Compute the law that the policy and its filters induce."""
        n_groups = len(self.true.groups)
        n = len(self.true.contexts) * n_groups
        if _given_with_cells(self.header) and len(self.given) != n:
            raise _malformed("the table", "does not list every true cell")
        given = self.given or [(ONE, self.header.utility or ())] * n
        _check_masses(self.header, [mass for mass, _ in given])
        if self.draws and len(self.draws) < len(self.laws):
            raise _malformed("the table", "gives draws for some rows of the policy only")
        released = self._released()
        rows = by_context = [[self.laws[place] for place in places] for places in released]
        draws = [[self.draws[place] for place in places] for places in released] if self.draws else []
        if self.context is not None:
            flat = _mixed([law for row in rows for law in row], self.context.maps)
            by_context = [flat[i : i + len(rows[0])] for i in range(0, len(flat), len(rows[0]))]
        induced = chain.from_iterable(_mixed(laws, self.group.maps) for laws in by_context)
        raw = self._rows_of(self.true.contexts, self.true.groups)  # in the order of the true cells
        unfiltered = self._table((self.laws[place] for place in raw.values()), given, "", None) if len(raw) == n else None
        drawn = sum(self.draws.values())
        return self._table(
            induced, given, digest, Policy(self.group, self.context, rows, by_context, unfiltered, draws, self.header, drawn)
        )

    def _table(
        self, laws: Iterable[Law], given: Sequence[tuple[Rational, Sequence[Rational | None]]], digest: str, policy: Policy | None
    ) -> Table:
        cells = tuple(
            Cell(*divmod(i, len(self.true.groups)), law, mass, _expectation(law, utility), utility)
            for i, (law, (mass, utility)) in enumerate(zip(laws, given, strict=True))
        )
        figures = Figures(self.true, expectations_only=policy is None)
        for cell in cells:
            figures.add(cell)
        return Table(self.true, cells, len(self.laws), digest, figures.of_all(), policy)


# ---------------------------------------------------------------------------------------------------------------------
# The metrics


@dataclass(frozen=True)
class Maximum:
    """The value of a metric and its witness; ``place`` is the context (if any), the higher and the lower, as indices."""

    value: Rational
    witness: dict[str, object]
    place: tuple[int | None, int, int]


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


def _widest_distance(laws: Sequence[Law]) -> tuple[Rational, int, int]:
    """Find the greatest total variation distance of two of the laws, and the first positions that attain it."""
    bits = max(total.bit_length() for _, total in laws)
    if len(laws[0][0]) <= 2:  # the distance is the difference of the probabilities of the first decision
        values = [(weights[0], total) for weights, total in laws]
        top, low = _ends(values)
        (n, d), (p, q) = values[top], values[low]
        _spend(3, bits, bits)
        return ((n * q - p * d, d * q), min(top, low), max(top, low)) if n * q > p * d else (ZERO, 0, 1)
    # The first pair that attains a positive maximum consists of first occurrences, so that repetitions can be left out.
    first: dict[tuple[int, ...], int] = {}
    for i, (weights, _) in enumerate(laws):
        first.setdefault(weights, i)
    places = list(first.values())
    each = 10 + 2 * len(laws[0][0])
    _spend(len(places) * (len(places) * len(laws[0][0]) // 40 + each))
    screen = _Screen([laws[i] for i in places]) if len(places) > 32 else None
    best: tuple[Rational, int, int] = (ZERO, 0, 1)
    for at, i in enumerate(places):
        others = screen.farther(best[0]) if screen else range(len(places) - at - 1)
        _spend(len(others) * each, bits, bits)
        for later in others:
            j = places[at + 1 + later]
            distance = _distance(laws[i], laws[j])
            if not _at_most(distance, best[0]):
                best = distance, i, j
        if best[0][0] == best[0][1]:  # no distance exceeds 1
            break
    return best


def _distance(left: Law, right: Law) -> Rational:
    (p, m), (q, n) = left, right
    return sum(e for a, b in zip(p, q, strict=True) if (e := a * n - b * m) > 0), m * n


class _Screen:
    """A quick test that leaves only those pairs of many laws whose distance may exceed a bound.

    It works on probabilities that are rounded down to multiples of 2^-28.  Then p - q is less than one unit above the
    difference of the rounded numbers, so that the distance of two laws on d decisions is at most d units above the sum
    of the positive differences of the rounded numbers.  That sum is formed for one law and all later ones at once: for
    each decision a long integer holds the numbers of all laws in lanes of 32 bits.  The highest bit of a lane is set
    before a subtraction; it is still set afterwards exactly if the difference is not negative, and no lane borrows
    from its neighbour.
    """

    def __init__(self, laws: Sequence[Law]) -> None:
        rounded = [[(weight << 28) // total for weight in weights] for weights, total in laws]
        self.lanes = len(laws)
        self.ones = self._packed([1] * self.lanes)
        self.columns = [self._packed(column) for column in zip(*rounded, strict=True)]

    @staticmethod
    def _packed(values: Sequence[int]) -> int:
        return int.from_bytes(struct.pack(f"<{len(values)}I", *values), "little")

    def farther(self, bound: Rational) -> list[int]:
        """Take the next law off; list those of the later ones (0 is the next) whose distance from it may exceed the bound."""
        own = [column & 0xFFFFFFFF for column in self.columns]
        self.lanes -= 1
        self.ones >>= 32
        self.columns = [column >> 32 for column in self.columns]
        signs = self.ones << 31
        sums = 0
        for number, column in zip(own, self.columns, strict=True):
            differences = (column | signs) - number * self.ones
            positive = differences & signs
            sums += differences & (positive - (positive >> 31))
        least = max(0, (bound[0] << 28) // bound[1] - len(own) + 1)  # of the sums that are worth a closer look
        if not ((sums | signs) - least * self.ones) & signs:
            return []
        found = struct.unpack(f"<{self.lanes}I", sums.to_bytes(4 * self.lanes, "little"))
        return [i for i, total in enumerate(found) if total >= least]


T = TypeVar("T")


class _Greatest(Generic[T]):
    """The greatest value of a metric over the settings so far; the first one that attains it is kept."""

    def __init__(self, widest: Callable[[Sequence[T]], tuple[Rational, int, int]], details: Callable[[T, T], dict[str, object]]) -> None:
        self.widest, self.details = widest, details
        self.value: Rational = ZERO  # of nothing; no metric is less
        self.found: tuple[Setting, int, int, T, T] | None = None

    def offer(self, values: Sequence[T], groups: Sequence[int], context: int | None, decision: int | None = None) -> None:
        """Compare the values of some groups."""
        value, higher, lower = self.widest(values)
        if self.found is None or not _at_most(value, self.value):
            self.value = value
            self.found = Setting(groups, context, decision), higher, lower, values[higher], values[lower]

    def maximum(self, header: Header) -> Maximum | None:
        """The value and its witness, if anything was compared."""
        if self.found is None:
            return None
        setting, higher, lower, one, other = self.found
        witness = setting.witness(header, higher, lower) | self.details(one, other)
        return Maximum(_reduced(*self.value), witness, (setting.context, setting.groups[higher], setting.groups[lower]))


class _Compared:
    """The three metrics that compare groups, be it in each context or once."""

    def __init__(self, header: Header, expectations_only: bool) -> None:
        def raised(left: Law, right: Law) -> dict[str, object]:
            (p, m), (q, n) = left, right
            return {"decisions": [u for u, a, b in zip(header.decisions, p, q, strict=True) if a * n > b * m]}

        def both(name: str) -> Callable[[Rational, Rational], dict[str, object]]:
            return lambda left, right: {name: [_reduced(*left), _reduced(*right)]}

        self.header, self.expectations_only = header, expectations_only
        self.means = _Greatest[Rational](_widest_ratio, both("expectations"))
        self.laws = _Greatest[Law](_widest_distance, raised)
        self.single = _Greatest[Rational](_widest_ratio, both("probabilities"))

    def add(self, groups: Sequence[int], laws: Sequence[Law], means: Sequence[Rational], context: int | None = None) -> None:
        """Compare at least two groups."""
        self.means.offer(means, groups, context)
        if self.expectations_only:
            return
        self.laws.offer(laws, groups, context)
        for u in range(len(self.header.decisions)):
            self.single.offer([(weights[u], total) for weights, total in laws], groups, context, u)

    def maxima(self, ratio: str, distance: str, supremum: str) -> dict[str, Maximum | None]:
        """The metrics by these names."""
        metrics = {ratio: self.means.maximum(self.header)}
        if not self.expectations_only:
            metrics |= {distance: self.laws.maximum(self.header), supremum: self.single.maximum(self.header)}
        return metrics


class Figures:
    """What the cells of a table add up to, while they pass by in their order.

    Only the cells of one context are held at a time.  What stays grows with the labels of the header: a number for
    each context, and a vector for each group.  Besides, ``rarer`` holds for each context that has cells of some groups
    but not of all either those groups or the others, whichever are fewer: no more than what ``not_compared`` has to name.
    """

    def __init__(self, header: Header, expectations_only: bool = False) -> None:
        n = len(header.groups)
        self.header, self.cells = header, 0
        self.local = _Compared(header, expectations_only)
        self.sizes = [0] * len(header.contexts)  # the number of cells
        self.rarer: dict[int, tuple[int, ...]] = {}
        self.with_cells = [False] * n
        self.laws = [_Total() for _ in range(n)]  # the sum of M(x,a) P(.|x,a) over the cells of positive mass, by group
        self.gains = None if header.utility is None else _gains(header.utility)
        self.means = [_Total() for _ in range(n)] if self.gains is None else []  # likewise, of M(x,a) E(x,a)
        self.reference: list[Rational] | None = None  # the masses of the first complete context in which one is positive
        self.proportional = True  # the masses of complete contexts, to the reference
        self.tau: Rational | None = None
        self.ends: tuple[Rational, Rational] | None = None  # of the utilities that stand with the cells
        self.spread = ZERO
        self.held: list[Cell] = []

    def add(self, cell: Cell) -> None:
        """Take in the next cell."""
        if self.held and self.held[0].context != cell.context:
            self._take()
        self.held.append(cell)

    def of_all(self) -> "Figures":
        """Take in what is held: no cell follows."""
        if self.held:
            self._take()
        return self

    def _take(self) -> None:
        """Take in the cells of a context, all of which are held."""
        cells, self.held = self.held, []
        context, groups = cells[0].context, [cell.group for cell in cells]
        self.cells += len(cells)
        self.sizes[context] = len(cells)
        self._add_up(cells)
        if self.gains is None:
            self._take_utilities(cells)
        if len(cells) == len(self.header.groups):
            self._take_masses([cell.mass for cell in cells])
        elif 2 * len(cells) <= len(self.header.groups):
            self.rarer[context] = tuple(groups)
        else:
            self.rarer[context] = _others(groups, len(self.header.groups))
        if len(cells) > 1:
            means = [cell.expectation for cell in cells]
            least = means[_ends(means)[1]]
            if self.tau is None or not _at_most(self.tau, least):
                self.tau = least
            self.local.add(groups, [cell.law for cell in cells], means, context)

    def _add_up(self, cells: Sequence[Cell]) -> None:
        for _, group, (weights, total), mass, expectation, _ in cells:
            self.with_cells[group] = True
            if mass[0]:
                n, d = _reduced(mass[0], mass[1] * total)
                self.laws[group].add([n * weight for weight in weights], d)
                if self.gains is None:
                    self.means[group].add([mass[0] * expectation[0]], mass[1] * expectation[1])

    def _take_utilities(self, cells: Sequence[Cell]) -> None:
        """Compare the entries of utilities that stand with the cells: in all, and of each decision in this context."""
        utilities = {cell.utility for cell in cells}
        given = [*{g for utility in utilities for g in utility if g is not None}, *(self.ends or ())]
        top, low = _ends(given)
        self.ends = given[top], given[low]
        if len(utilities) == 1:
            return
        for column in zip(*utilities, strict=True):
            entries = [g for g in set(column) if g is not None]
            if len(entries) > 1:
                i, j = _ends(entries)
                (n, d), (p, q) = entries[i], entries[j]
                if not _at_most((n * q - p * d, d * q), self.spread):
                    self.spread = _reduced(n * q - p * d, d * q)

    def _take_masses(self, masses: list[Rational]) -> None:
        """Compare the masses of a complete context with the reference.

        With r the reference and r_p > 0, the masses m are a multiple of r exactly if m_a r_p = m_p r_a for all a.
        """
        if self.reference is None:
            if any(n for n, _ in masses):
                self.reference = masses
        elif self.proportional:
            p = next(i for i, (n, _) in enumerate(self.reference) if n)
            (n, d), (k, e) = self.reference[p], masses[p]
            above, below = n * e, k * d  # r_p and m_p over one denominator
            self.proportional = all(m[0] * above * r[1] == r[0] * below * m[1] for m, r in zip(masses, self.reference, strict=True))

    def complete(self) -> bool:
        """Say whether every group has a cell in every context (no cell occurs twice)."""
        return self.cells == len(self.header.contexts) * len(self.header.groups)

    def independent(self) -> bool:
        """Decide whether context and group are independent: M(x,a) M = M(x,.) M(.,a) for all x and a.

        Let there be a cell for each x and a.  If all masses are 0, this holds, and there is no reference.  Else let
        r_a = M(z,a) be the reference, R > 0 the sum of r, and M > 0.  If it holds, then M(.,a) = r_a M / R because of z, and
        M(x,a) = (M(x,.) / R) r_a: the masses of each context are a multiple of r.  If they are, M(x,a) = c_x r_a with
        c_x = 0 where all masses are 0 (as in the contexts before z), and with C the sum of c both sides are c_x r_a C R.
        """
        return self.complete() and self.proportional

    def missing(self, context: int) -> Sequence[int]:
        """List the groups without a cell in a context."""
        size, n = self.sizes[context], len(self.header.groups)
        if size in (0, n):
            return range(0 if size else n)
        return _others(self.rarer[context], n) if 2 * size <= n else self.rarer[context]

    def populated(self) -> list[int]:
        """List the groups of positive mass."""
        return [a for a, law in enumerate(self.laws) if law.parts]

    def masses(self) -> list[Rational]:
        """List the masses of the groups of positive mass."""
        sums = (self.laws[a].value() for a in self.populated())
        return [_reduced(sum(numerators), denominator) for numerators, denominator in sums]

    def of_group(self, group: int) -> tuple[Law, Rational]:
        """Compute P(.|a) and the mean of E(.,a) of a group of positive mass."""
        summed, denominator = self.laws[group].value()
        total = sum(summed)  # the mass of the group is total / denominator
        law = tuple(summed), total
        if self.gains is not None:  # g(u): the mean is that of the law
            return law, _mean(*law, self.gains)
        (n,), d = self.means[group].value()
        return law, _reduced(n * denominator, d * total)


def _others(numbers: Iterable[int], below: int) -> tuple[int, ...]:
    known = set(numbers)
    return tuple(i for i in range(below) if i not in known)


def _lacks_population(table: Table) -> bool:
    return table.header.subject.population == "equal" and not table.figures.complete()


def _globally_compared(table: Table) -> list[int]:
    groups = [] if _lacks_population(table) else table.figures.populated()
    return groups if len(groups) > 1 else []


def measure(table: Table) -> dict[str, Maximum | None]:
    """Compute the six metrics of a table, or if only these were asked for the two of them that compare expectations."""
    local = table.figures.local
    overall = _Compared(table.header, local.expectations_only)
    groups = _globally_compared(table)
    if groups:
        laws, means = zip(*map(table.figures.of_group, groups), strict=True)
        overall.add(groups, laws, means)
    metrics = local.maxima("local", "equalized_odds", "local_supremum")
    return metrics | overall.maxima("global", "demographic_parity", "global_supremum")


def constants(table: Table) -> dict[str, Rational | bool | None]:
    """Compute the constants of the utility g."""
    figures = table.figures
    given = table.header.utility or figures.ends or ()
    top, low = _ends(given)
    return {
        "gamma": given[top],
        "m": given[low],
        "tau": figures.tau,
        "lipschitz": figures.spread,
        "depends_on_group": figures.spread != ZERO,
    }


def not_compared(table: Table) -> Iterator[dict[str, object]]:
    """List what the metrics leave out, and why."""
    header, figures = table.header, table.figures
    for x, label in enumerate(header.contexts):
        if missing := [list(header.groups[a]) for a in figures.missing(x)]:
            yield {"context": list(label), "groups": missing, "reason": "no decisions recorded"}
    for label, size in zip(header.contexts, figures.sizes, strict=True):
        if size < 2:
            yield {"context": list(label), "reason": "fewer than two groups"}
    populated = set(figures.populated())
    empty = [list(group) for a, group in enumerate(header.groups) if figures.with_cells[a] and a not in populated]
    if empty:
        yield {"groups": empty, "reason": "no population"}
    if _lacks_population(table):
        yield {"quantity": "global", "reason": "a group is missing in a context and no population was given"}
    elif len(populated) < 2:
        yield {"quantity": "global", "reason": "fewer than two groups"}
    if table.given is not None:
        yield from table.given.not_compared()


# ---------------------------------------------------------------------------------------------------------------------
# Given the true label

TRUE_POSITIVES, FALSE_POSITIVES = KINDS = ("true_positive_rate", "false_positive_rate")
OVERALL = "_overall"  # ends the name of what is pooled over contexts, where there are context columns
LACKING = {TRUE_POSITIVES: "no decisions with the positive true label", FALSE_POSITIVES: "no decisions with another true label"}
DIFFERENCES = {  # the rates that each difference is about
    "equal_opportunity": (TRUE_POSITIVES,),
    "equalized_odds_true_label": KINDS,
    f"equal_opportunity{OVERALL}": (TRUE_POSITIVES + OVERALL,),
    f"equalized_odds_true_label{OVERALL}": (TRUE_POSITIVES + OVERALL, FALSE_POSITIVES + OVERALL),
}


def _stated_given_truth(columns: Columns) -> tuple[list[str], list[str]]:
    """The names of the rates and of the differences that a certificate states."""
    if columns.truth is None:
        return [], []
    suffixes = ("", OVERALL) if columns.context else ("",)
    names = [name for name in DIFFERENCES if columns.context or not name.endswith(OVERALL)]
    return [kind + suffix for kind in KINDS for suffix in suffixes], names


class Share(NamedTuple):
    """Of ``draws`` decisions in a cell, or of a group over all contexts (-1), with the wanted true label, ``positives`` are positive."""

    context: int
    group: int
    positives: Fraction
    draws: Fraction
    rate: Fraction | None  # none where there are no draws


def _rated(context: int, group: int, positives: Fraction, draws: Fraction) -> Share:
    bits = _bits(positives, draws)
    _spend(12, bits, bits)  # the quotient, and comparisons with others
    _keep(12, bits)
    return Share(context, group, positives, draws, positives / draws if draws else None)


class GivenTruth:
    """The numbers of decisions by true label, while the rows of a table pass by."""

    def __init__(self, header: Header, positive: Positive) -> None:
        self.header = header
        for label in positive.decision:
            if label not in header.decisions:
                raise _malformed("subject.positive.decision", f"names {shown(label)}, which is no decision of the table")
        if positive.truth not in (truths := header.truths or ()):
            raise _malformed("subject.positive.truth", f"is {shown(positive.truth)}, which is no true label of the table")
        self.decisions = [header.decisions.index(label) for label in positive.decision]
        if self.decisions != sorted(self.decisions):
            raise _malformed("subject.positive.decision", "is not in the order of the decisions of the table")
        self.truth = truths.index(positive.truth)
        self.cells: list[tuple[Share, Share]] = []
        self.pooled: dict[str, list[Share]] = {}

    def add(self, place: tuple[int, int], counts: tuple[list[list[int]], int]) -> None:
        """Take in the next cell."""
        rows, below = counts
        _spend(len(rows) * len(rows[0]), below.bit_length(), below.bit_length())
        sums = []
        for wanted in (True, False):
            own = [row for t, row in enumerate(rows) if (t == self.truth) is wanted]
            numbers = (sum(row[u] for row in own for u in self.decisions), sum(map(sum, own)))
            sums.append(_rated(*place, *(Fraction(*_reduced(number, below)) for number in numbers)))
        self.cells.append((sums[0], sums[1]))

    def _shares(self, name: str) -> list[Share]:
        """All of them, in order, also those without draws."""
        position = KINDS.index(name.removesuffix(OVERALL))
        own = [shares[position] for shares in self.cells]
        if not name.endswith(OVERALL):
            return own
        if name not in self.pooled:
            totals: dict[int, list[tuple[Fraction, Fraction]]] = {}
            for share in own:
                totals.setdefault(share.group, []).append((share.positives, share.draws))
            self.pooled[name] = [_rated(-1, a, *map(_fraction_sum, zip(*totals[a], strict=True))) for a in sorted(totals)]
        return self.pooled[name]

    def blocks(self, name: str) -> list[list[Share]]:
        """The rates of one name that are compared with each other."""
        lists: dict[int, list[Share]] = {}
        for share in self._shares(name):
            if share.rate is not None:
                lists.setdefault(share.context, []).append(share)
        return [block for block in lists.values() if len(block) > 1]

    def rates(self) -> dict[str, list[dict[str, object]]]:
        """All rates that exist, as a certificate lists them."""
        names, _ = _stated_given_truth(self.header.subject.columns)
        return {
            name: [self._named(share) | {"rate": _pair(share.rate)} for share in self._shares(name) if share.rate is not None]
            for name in names
        }

    def _named(self, share: Share) -> dict[str, object]:
        columns = self.header.subject.columns
        names: dict[str, object] = {}
        if share.context >= 0:
            names["context"] = dict(zip(columns.context, self.header.contexts[share.context], strict=True))
        return names | {"group": dict(zip(columns.group, self.header.groups[share.group], strict=True))}

    def differences(self) -> dict[str, Maximum | None]:
        """The greatest differences, each null when one of its rates compares nobody."""
        _, names = _stated_given_truth(self.header.subject.columns)
        return {name: self._greatest([self._widest(rate) for rate in DIFFERENCES[name]]) for name in names}

    @staticmethod
    def _greatest(found: Sequence[Maximum | None]) -> Maximum | None:
        best = found[0]
        for other in found:
            if best is None or other is None:
                return None
            if not _at_most(other.value, best.value):
                best = other
        return best

    def _widest(self, name: str) -> Maximum | None:
        best: tuple[Fraction, Share, Share] | None = None
        for block in self.blocks(name):
            values = [share.rate for share in block if share.rate is not None]
            gap = max(values) - min(values)
            if best is None or gap > best[0]:
                lower = values.index(min(values)) if gap else 1
                best = gap, block[values.index(max(values))], block[lower]
        if best is None:
            return None
        gap, high, low = best
        upper, under = self._named(high), self._named(low)
        witness = {key: upper[key] for key in upper if key == "context"}
        witness |= {"rate": name.removesuffix(OVERALL), "higher": upper["group"], "lower": under["group"]}
        witness["rates"] = [_pair(share.rate) for share in (high, low) if share.rate is not None]
        return Maximum(_pair(gap), witness, (high.context if high.context >= 0 else None, high.group, low.group))

    def not_compared(self) -> Iterator[dict[str, object]]:
        """List where a rate does not exist, so that nobody is compared by it."""
        header = self.header
        names, _ = _stated_given_truth(header.subject.columns)
        for name in names:
            lists: dict[int, list[Share]] = {}
            for share in self._shares(name):
                lists.setdefault(share.context, []).append(share)
            for x, shares in lists.items():
                place: dict[str, object] = {"quantity": name} | ({"context": list(header.contexts[x])} if x >= 0 else {})
                lacking = [list(header.groups[share.group]) for share in shares if not share.draws]
                if lacking:
                    yield place | {"groups": lacking, "reason": LACKING[name.removesuffix(OVERALL)]}
                if len(shares) - len(lacking) < 2 <= len(shares):
                    yield place | {"reason": "fewer than two groups"}


def _fraction_sum(values: Iterable[Fraction]) -> Fraction:
    return Fraction(*_sum((value.numerator, value.denominator) for value in values))


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
SHAPES = METRICS | {
    name: (False, ("context",) * (not name.endswith(OVERALL)) + ("rate", "higher", "lower", "rates")) for name in DIFFERENCES
}


@dataclass(frozen=True)
class Claim:
    """A claim as the certificate states it."""

    key: tuple[str, str, str, str]  # quantity, relation, by, scope
    value: Rational
    assumptions: tuple[str, ...]
    evidence: object  # what its rule has as evidence, read


@dataclass(frozen=True)
class Target:
    """A limit that was asked for, with the verdict that the certificate states."""

    quantity: str
    limit: Rational
    unit: str
    judged: str
    confidence: Fraction | None  # of what is judged about the population
    verdict: str
    of_units: bool  # whether the mean over units is judged


@dataclass(frozen=True)
class Change:
    """A window of a stream that contradicts the whole stream until then, as the certificate states it."""

    quantity: str
    window: int
    confidence: Fraction
    stream: "Interval"
    digest: str
    cells: int
    lines: tuple[object, ...]  # the header and the rows of the window's table
    ratio: "Interval"
    assumptions: tuple[str, ...]


@dataclass(frozen=True)
class Certificate:
    """A certificate as it stands: well formed, and perhaps untrue."""

    subject: Subject
    digest: str
    cells: int
    embedded: tuple[object, ...] | None  # the header and the rows
    constants: dict[str, Rational | bool | None]
    utilities: "UtilityClass | None"
    privacy: dict[str, dict[str, object] | None] | None  # this, the next and the unfiltered metrics are those of a policy
    declared: dict[str, Rational]
    metrics: dict[str, dict[str, object] | None]
    unfiltered: dict[str, dict[str, object] | None] | None
    not_compared: list[dict[str, object]]
    claims: tuple[Claim, ...]
    targets: tuple[Target, ...]
    verdict: str
    intervals: "dict[str, Interval]"  # by quantity
    positive: Positive | None  # this, the rates, and some metrics are of counts with true labels
    rates: dict[str, list[dict[str, object]] | None]
    differences: "dict[str, DifferenceInterval]"  # intervals, by metric
    preparation: "tuple[Step, ...]"
    spellings: tuple[tuple[str, Labels], ...]
    change: Change | None = None

    @property
    def withdrawn(self) -> frozenset[str]:
        """The ratios of the stream that a change leaves nothing to say about: the mix of contexts is behind one of them only."""
        if self.change is None:
            return frozenset()
        return frozenset(("global",) if self.change.quantity == "global" and self.subject.columns.context else ("local", "global"))


LAW = "this law"
POLICIES = "any policy behind this filter"
FLOORED = "any policy behind this filter that keeps the declared floor"
GROUP_FILTERS = "this policy and context filter, any group filter at most this epsilon that releases the same values"
CONTEXT_FILTERS = "this policy and group filter, any context filter that releases these contexts"
UTILITIES = "every utility of the class"
POPULATION = "population at confidence "  # the confidence follows


@dataclass(frozen=True)
class Facts:
    """What claims are judged by; what is costly, and needed by few claims, is computed when a claim needs it."""

    table: Table
    metrics: Mapping[str, Maximum | None]
    declared: Mapping[str, Rational]
    program: "Program | None"
    proven: "Mapping[str, Proven]"  # the intervals that hold

    @cached_property
    def constants(self) -> dict[str, Fraction]:
        """The effective constants of g, those that are declared first; tau is that of the table."""
        own = constants(self.table)
        finite = {key: Fraction(*value) for key, value in own.items() if isinstance(value, tuple)}
        return finite | {key: Fraction(*value) for key, value in self.declared.items() if key != "tau"}

    @property
    def policy(self) -> Policy:
        """The policy and its filters; the rules that need them are not applied to other subjects."""
        if self.table.policy is None:
            raise AssertionError
        return self.table.policy

    def _utilities(self) -> list[Sequence[Rational | None]]:
        """For each true context its g(u,x), which must not depend on the group."""
        return [cells[0].utility for cells in self.table.by_context()]

    def holds(self, condition: str) -> bool:
        """Decide one of the CONDITIONS."""
        if condition == "independent":
            return self.table.figures.independent()
        if condition == "a-free":  # the constant of the table is no greater
            return self.constants["lipschitz"] == 0
        if condition == "g(u)":
            return self.table.header.utility is not None
        if condition == "finite":
            return self.policy.group.exp_epsilon != INFINITY
        return self.policy.context is not None

    def floor(self, scope: str) -> Fraction | None:
        """The tau of a claim: what all expectations are at least, in the scope of the claim."""
        if scope == LAW:
            return self.constants.get("tau")
        if scope == FLOORED:
            return Fraction(*self.declared["tau"]) if "tau" in self.declared else None
        return Fraction(*self._policy_floor)

    @cached_property
    def _policy_floor(self) -> Rational:
        """The least expectation over what each true context can release and all reachable groups, for g(u,x)."""
        contexts = range(len(self.table.header.contexts))
        releases = self.policy.context.releases() if self.policy.context else [[x] for x in contexts]
        seen: dict[Sequence[Rational | None], set[int]] = {}
        for utility, released in zip(self._utilities(), releases, strict=True):
            seen.setdefault(utility, set()).update(released)
        values = [_expectation(law, g) for g, released in seen.items() for x in released for law in self.policy.rows[x]]
        return values[_ends(values)[1]]

    @cached_property
    def raw_ratio(self) -> Rational:
        """The greatest ratio of two expectations of one true context over the reachable groups, for g(u,x)."""
        pairs = zip(self._utilities(), self.policy.by_context, strict=True)
        ratios = [_widest_ratio([_expectation(law, utility) for law in laws])[0] for utility, laws in pairs]
        return _maximum(ratios)

    @cached_property
    def context_ratio(self) -> Rational:
        """The local ratio of the law over reachable contexts and true groups, for g(u)."""
        utility = self.table.header.utility or ()
        laws = (_mixed(row, self.policy.group.maps) for row in self.policy.rows)
        ratios = [_widest_ratio([_expectation(law, utility) for law in row])[0] for row in laws]
        return _maximum(ratios)

    @cached_property
    def composition(self) -> Rational:
        """The greatest P(x|a)/P(x|a') over released contexts x and pairs of groups of positive mass."""
        masses, _ = _over_common_denominator([cell.mass for cell in self.table.cells])
        factors = self.policy.context.factors if self.policy.context else ()
        released = _through(masses, [_map([*zip(*factor.matrix, strict=True)], factor.total) for factor in factors])
        n = len(self.table.header.groups)
        rows = [released[i : i + n] for i in range(0, len(released), n)]
        totals = [sum(column) for column in zip(*rows, strict=True)]
        ratios = [_widest_ratio([(p, total) for p, total in zip(row, totals, strict=True) if total])[0] for row in rows]
        return _maximum(ratios)


CONDITIONS = {
    "independent": "context and group are not independent in the table",
    "a-free": "the utility depends on the group, by the table or as declared",
    "g(u)": "the utility does not depend on the decision alone",
    "finite": "epsilon is infinite",
    "context filter": "there is no context filter",
}


@dataclass(frozen=True)
class Rule:
    """What makes a claim true, besides what its theorem says about the value.

    The metric ``quantity`` must not be null, the conditions in ``needs`` hold, and the evidence is that of the table.
    """

    quantity: str
    evidence: str
    needs: tuple[str, ...] = ()
    source: str = ""  # the metric that the value is or follows from; claims about a policy or a class of utilities have none
    assumes: tuple[str, ...] = ()  # what the theorem needs and no table shows, besides what all claims about a policy assume


STATED_POPULATION = "the contexts of each group are distributed as in the stated population"

RULES: dict[tuple[str, str, str, str], Rule] = {
    ("local_ratio", "=", "enumeration", LAW): Rule("local", "table", source="local"),
    ("global_ratio", "=", "enumeration", LAW): Rule("global", "table", source="global"),
    ("demographic_parity", "=", "enumeration", LAW): Rule("demographic_parity", "table", source="demographic_parity"),
    ("equalized_odds", "=", "enumeration", LAW): Rule("equalized_odds", "table", source="equalized_odds"),
    ("local_ratio_supremum", "=", "T6", LAW): Rule("local_supremum", "table", source="local_supremum"),
    ("global_ratio_supremum", "=", "T6", LAW): Rule("global_supremum", "table", source="global_supremum"),
    ("equalized_odds", "<=", "T7", LAW): Rule("equalized_odds", "supremum", source="local_supremum"),
    ("demographic_parity", "<=", "T7", LAW): Rule("demographic_parity", "supremum", source="global_supremum"),
    ("global_ratio", "<=", "T5", LAW): Rule("global", "table", ("independent",), source="local"),
    **{(name, "=", "enumeration", LAW): Rule(name, "table", source=name) for name in DIFFERENCES},
    ("local_ratio", "<=", "T2", POLICIES): Rule("local", "", ("a-free", "finite")),
    ("local_ratio", "<=", "T1-paper", LAW): Rule("local", "", ("finite",)),
    ("local_ratio", "<=", "T1-paper", FLOORED): Rule("local", "", ("finite",)),
    ("local_ratio", "<=", "T1", LAW): Rule("local", "multipliers"),
    ("local_ratio", "<=", "T1", FLOORED): Rule("local", "multipliers"),
    ("local_ratio", "<=", "T3", LAW): Rule("local", "multipliers"),
    ("local_ratio", "<=", "T3", FLOORED): Rule("local", "multipliers"),
    ("local_ratio", "<=", "T3", GROUP_FILTERS): Rule("local", "multipliers", ("a-free",)),
    ("local_ratio", "<=", "T4", POLICIES): Rule("local", "multipliers", ("a-free",)),
    ("local_ratio", "<=", "floor", LAW): Rule("local", ""),
    ("local_ratio", "<=", "floor", FLOORED): Rule("local", ""),
    ("local_ratio", "<=", "T12", GROUP_FILTERS): Rule("local", "raw_ratio", ("a-free",)),
    ("local_ratio", "<=", "T8", CONTEXT_FILTERS): Rule("local", "", ("g(u)", "context filter")),
    ("global_ratio", "<=", "T5", POLICIES): Rule("global", "", ("a-free", "independent", "finite"), assumes=(STATED_POPULATION,)),
    ("global_ratio", "<=", "T5-decision", POLICIES): Rule("global", "composition", ("g(u)", "finite"), assumes=(STATED_POPULATION,)),
    ("local_ratio", "<=", "T3", UTILITIES): Rule("local", "multipliers"),
    ("global_ratio", "<=", "T3", UTILITIES): Rule("global", "multipliers"),
    ("local_ratio", "<=", "lp-dual", UTILITIES): Rule("local", "pairs"),
    ("global_ratio", "<=", "lp-dual", UTILITIES): Rule("global", "pairs"),
}


def _rule(claim: Claim, facts: Facts) -> Rule | None:
    """Find the rule of a claim, if there is one for what the certificate is about."""
    rule = RULES.get(claim.key)
    if rule is None or rule.source:
        return rule
    subject = facts.program if claim.key[3] == UTILITIES else facts.table.policy
    return rule if subject is not None else None


def _fault(claim: Claim, facts: Facts) -> str:
    """Say what is wrong with a claim; nothing if it is true."""
    if _is_about_population(claim.key):
        return _fault_about_population(claim, facts.proven)
    rule = _rule(claim, facts)
    if rule is None:
        known = any(claim.key[:3] == key[:3] for key in RULES)
        return f"unknown claim: the scope is {shown(claim.key[3])}" if known else "unknown claim"
    quantity, source = facts.metrics.get(rule.quantity), facts.metrics.get(rule.source or rule.quantity)
    if quantity is None or source is None:
        return "the table does not give this quantity"
    for condition in rule.needs:
        if not facts.holds(condition):
            return CONDITIONS[condition]
    if claim.key[3] == UTILITIES and facts.program is not None:
        fault = _fault_of_worst_case(claim, rule, facts.program)
    else:
        fault = _fault_of_figure(claim, rule, facts, source.value) if rule.source else _fault_of_bound(claim, rule, facts)
    if not fault and not _at_most(quantity.value, claim.value):
        fault = f"the table gives the greater quantity {shown(quantity.value)}"
    return fault


def _fault_of_figure(claim: Claim, rule: Rule, facts: Facts, source: Rational) -> str:
    """Compare the value and the evidence of a claim that repeats a metric, or has one as its value by a theorem."""
    by_t7 = rule.evidence == "supremum"
    value = _reduced(source[0] - source[1], source[0] + source[1]) if by_t7 else source
    evidence = source if by_t7 else facts.table.digest
    if claim.value != value:
        return f"the table gives {shown(value)}"
    return "" if claim.evidence == evidence else f"the evidence is {shown(claim.evidence)}, the table gives {shown(evidence)}"


def _fault_of_bound(claim: Claim, rule: Rule, facts: Facts) -> str:
    """Judge a claim that a policy certificate adds: its value has to be at least the bound of its theorem."""
    _, _, by, scope = claim.key
    gamma, m, lipschitz = (facts.constants[key] for key in ("gamma", "m", "lipschitz"))
    n, d = facts.policy.group.exp_epsilon
    bits = _bits(gamma, m, lipschitz, (n, d), claim.value)
    _spend(20, bits, bits)
    tau: Fraction | None = Fraction(1)
    if by in ("T1-paper", "T1", "T3", "floor"):
        tau = facts.floor(scope)
    elif by == "T4":
        tau = m
    if tau is None or tau <= 0:
        return "the floor is 0" if tau is not None else "no floor is declared"
    if by == "T3" and tau > gamma - lipschitz:
        return f"the floor {shown(_pair(tau))} is more than gamma - L"
    if rule.evidence == "multipliers":
        return _fault_of_multipliers(claim, facts, tau)
    evidence: Rational | None = None
    match by:
        case "T2" | "T5":
            bound = n, d
        case "T1-paper":
            bound = _pair(Fraction(n, d) * (1 + lipschitz / tau))
        case "floor":
            bound = _pair(gamma / tau)
        case "T12":
            evidence = r, s = facts.raw_ratio
            bound = _reduced(s * d + r * n, s * n + r * d)  # (1 + R0 e^eps) / (R0 + e^eps), both possibly infinite
        case "T8":
            bound = facts.context_ratio
        case "T5-decision":
            evidence = facts.composition
            bound = _product([(n, d), evidence])
        case _:
            raise AssertionError(by)
    if claim.evidence != evidence:
        return f"the evidence is {shown(claim.evidence)}, the table gives {shown(evidence)}"
    return "" if _at_most(bound, claim.value) else f"the bound is {shown(bound)}"


def _pair(value: Fraction) -> Rational:
    return value.numerator, value.denominator


def _fault_of_multipliers(claim: Claim, facts: Facts, tau: Fraction) -> str:
    """Look for a multiplier that proves the claim for each ordered pair P, Q of rows of the filter.

    H_k is the sum of max(0, P - k Q).  For every function h on the outputs with values in [0, gamma] it is
    E_P h <= k E_Q h + gamma H_k; the theorems put the expected utilities under ã, or parts of them, in the place of h.
    """
    _, _, by, scope = claim.key
    gamma, m, lipschitz = (facts.constants[key] for key in ("gamma", "m", "lipschitz"))
    # What is bounded is k + max(0, add + weight H_k - (k - 1) shed) / tau, which is convex in k.
    add, weight, shed = {"T1": (lipschitz, gamma, 0), "T3": (lipschitz, gamma - lipschitz, 0)}.get(by, (Fraction(0), gamma - m, m))
    n, d = facts.policy.group.exp_epsilon
    # The second is the one pair that stands for all filters of this epsilon.
    pairs, unit = facts.policy.group.pairs if scope != GROUP_FILTERS else ({((n, d), (d, n))}, n + d)
    multipliers: list[Fraction] = sorted(claim.evidence) if isinstance(claim.evidence, list) else []
    bits = _bits(gamma, m, lipschitz, tau, claim.value) + unit.bit_length()
    hint = 0  # where the last multiplier that did was found
    for pair in pairs:
        low, high, at = 0, len(multipliers), hint
        least: Fraction | None = None
        while low < high:
            k = multipliers[at]
            _spend(4 * len(pair), unit.bit_length(), _bits(k))
            _spend(60, bits + _bits(k), bits + _bits(k))
            exceeding = [(p, q) for p, q in pair if p * k.denominator > q * k.numerator]
            sum_p, sum_q = sum(p for p, _ in exceeding), sum(q for _, q in exceeding)
            h = Fraction(sum_p * k.denominator - sum_q * k.numerator, unit * k.denominator)
            excess = add + weight * h - (k - 1) * shed
            value = k + max(Fraction(0), excess) / tau
            if _at_most(_pair(value), claim.value):
                hint = at
                break
            least = value if least is None else min(least, value)
            if excess > 0 and tau < weight * Fraction(sum_q, unit) + shed:  # the slope to the right is negative
                low = at + 1
            else:
                high = at
            at = (low + high) // 2
        else:
            return f"for some pair of groups the multipliers prove no less than {shown(_pair(least or Fraction(0)))}"
    return ""


# ---------------------------------------------------------------------------------------------------------------------
# The worst utility of a class


@dataclass(frozen=True)
class Family:
    """Utilities with parameters: g is the sum of theta_k phi_k; ``features`` lists the phi_k by cell and decision."""

    lower: list[Rational]
    upper: list[Rational]
    features: list[list[list[Rational]]]
    rows: list[tuple[list[Rational], Rational]]  # coefficients and a bound


@dataclass(frozen=True)
class UtilityClass:
    """A class of utilities, as ``subject.class`` states it."""

    quantity: str
    gamma: Rational
    m: Rational
    tau: Rational | None
    tau_on: str
    blind: bool
    lipschitz: Rational | None
    metric: list[list[Rational]] | None
    order: list[tuple[str, str]]
    rows: list[tuple[list[tuple[int, int | None, int, Rational]], Rational]]  # (context, group, decision, coefficient), and a bound
    family: Family | None

    @property
    def floor(self) -> Rational:
        """What the expectations of two groups that are compared are at least: tau, or m if that is greater."""
        return self.m if self.tau is None or _at_most(self.tau, self.m) else self.tau

    def described(self) -> str:
        """Describe the class in one line."""
        parts = [f"{self.quantity} ratio", f"{shown(self.m)} <= g <= {shown(self.gamma)}"]
        if self.tau is not None:
            parts.append(f"floor {shown(self.tau)} for {'the pair compared' if self.tau_on == 'pair' else 'all groups compared'}")
        if self.blind:
            parts.append("the same for all groups")
        if self.lipschitz is not None:
            parts.append(f"Lipschitz constant {shown(self.lipschitz)}{'' if self.metric is None else ' for a metric of its own'}")
        parts += [f"{shown(lower)} no better than {shown(higher)}" for lower, higher in self.order]
        parts += [f"{len(self.rows)} further constraints"] * bool(self.rows)
        if self.family is not None:
            parts.append(f"a family with {len(self.family.lower)} parameters and {len(self.family.rows)} constraints on them")
        text = ", ".join(parts)
        return text if len(text) <= 400 else text[:400] + " [...]"


@dataclass(frozen=True)
class Dual:
    """The evidence of a claim by ``lp-dual``: for each pair, as (context or -1, higher, lower), its multipliers by constraint number."""

    pairs: dict[tuple[int, int, int], list[tuple[int, Rational]]]
    theta: list[Rational] | None


def _signed(value: object, where: str, length: int | None = None) -> list[Rational]:
    return [_rational(item, f"{where}[{i}]") for i, item in enumerate(_list(value, where, length))]


def _read_class(value: object, where: str) -> UtilityClass:
    """Read a class so far as no table is needed; that it fits the table is made sure of by ``Program``."""
    keys = ("quantity", "gamma", "m", "tau", "tau_on", "blind", "lipschitz", "metric", "order", "rows", "family")
    members = _object(value, where, keys)

    def nonnegative(key: str) -> Rational:
        return _rational(members[key], f"{where}.{key}", nonnegative=True)

    def entries(key: str) -> list[tuple[str, object]]:
        return [(f"{where}.{key}[{i}]", item) for i, item in enumerate(_list(members[key], f"{where}.{key}"))]

    blind = _boolean(members["blind"], f"{where}.blind")
    gamma, m = nonnegative("gamma"), nonnegative("m")
    tau = None if members["tau"] is None else nonnegative("tau")
    lipschitz = None if members["lipschitz"] is None else nonnegative("lipschitz")
    if gamma == ZERO or not _at_most(m, gamma):
        raise _malformed(f"{where}.gamma", "must be positive and at least m")
    if tau is not None and not _at_most(tau, gamma):
        raise _malformed(f"{where}.tau", "must be at most gamma")
    if blind and lipschitz is not None:
        raise _malformed(f"{where}.lipschitz", "must be null when the class is blind")
    order = [_strings(item, place, 2) for place, item in entries("order")]
    return UtilityClass(
        _one_of(members["quantity"], f"{where}.quantity", ("local", "global")),
        gamma,
        m,
        tau,
        _one_of(members["tau_on"], f"{where}.tau_on", ("pair", "all")),
        blind,
        lipschitz,
        None if members["metric"] is None else _read_distances(members["metric"], f"{where}.metric"),
        [(lower, higher) for lower, higher in order],
        [_read_constraint(item, place, blind) for place, item in entries("rows")],
        None if members["family"] is None else _read_family(members["family"], f"{where}.family"),
    )


def _read_distances(value: object, where: str) -> list[list[Rational]]:
    """Read a metric, and make sure that it is one."""
    n = len(_list(value, where))
    distances = [_rationals(row, f"{where}[{i}]", n) for i, row in enumerate(_list(value, where))]
    flat, unit = _over_common_denominator([ONE, *chain.from_iterable(distances)])
    _spend(n * n * (n + 5) // 2, unit.bit_length())
    rows = [flat[i : i + n] for i in range(1, n * n + 1, n or 1)]
    for i, row in enumerate(rows):
        for j, distance in enumerate(row):
            if (distance == 0) != (i == j):
                raise _malformed(f"{where}[{i}][{j}]", "must be zero on the diagonal and positive elsewhere")
            if distance != rows[j][i]:
                raise _malformed(f"{where}[{i}][{j}]", "must be symmetric")
            if distance > min(map(add, row, rows[j])):
                raise _malformed(f"{where}[{i}][{j}]", "violates the triangle inequality")
    return distances


def _read_constraint(value: object, where: str, blind: bool) -> tuple[list[tuple[int, int | None, int, Rational]], Rational]:
    members = _object(value, where, ("terms", "bound"))
    terms: list[tuple[int, int | None, int, Rational]] = []
    for i, item in enumerate(_list(members["terms"], f"{where}.terms")):
        place = f"{where}.terms[{i}]"
        context, group, decision, coefficient = _list(item, place, 4)
        if blind and group is not None:
            raise _malformed(f"{place}[1]", "must be null when the class is blind")
        terms.append(
            (
                _integer(context, f"{place}[0]"),
                None if blind else _integer(group, f"{place}[1]"),
                _integer(decision, f"{place}[2]"),
                _rational(coefficient, f"{place}[3]"),
            )
        )
    return terms, _rational(members["bound"], f"{where}.bound")


def _read_family(value: object, where: str) -> Family:
    members = _object(value, where, ("names", "lower", "upper", "features", "rows"))
    names = _strings(members["names"], f"{where}.names")
    _check_distinct(names, f"{where}.names")
    lower, upper = (_signed(members[key], f"{where}.{key}", len(names)) for key in ("lower", "upper"))
    for k, (low, high) in enumerate(zip(lower, upper, strict=True)):
        if not _at_most(low, high):
            raise _malformed(f"{where}.lower[{k}]", "is greater than the upper end")
    features = [
        [_signed(phi, f"{where}.features[{i}][{u}]", len(names)) for u, phi in enumerate(_list(cell, f"{where}.features[{i}]"))]
        for i, cell in enumerate(_list(members["features"], f"{where}.features"))
    ]
    rows: list[tuple[list[Rational], Rational]] = []
    for i, item in enumerate(_list(members["rows"], f"{where}.rows")):
        row = _object(item, f"{where}.rows[{i}]", ("coefficients", "bound"))
        coefficients = _signed(row["coefficients"], f"{where}.rows[{i}].coefficients", len(names))
        rows.append((coefficients, _rational(row["bound"], f"{where}.rows[{i}].bound")))
    return Family(lower, upper, features, rows)


def _read_dual(value: object, where: str, local: bool, parameters: int | None) -> Dual:
    members = _object(value, where, ["pairs"] if parameters is None else ["pairs", "theta"])
    pairs: dict[tuple[int, int, int], list[tuple[int, Rational]]] = {}
    last = (-1, -1, -1)
    for i, item in enumerate(_list(members["pairs"], f"{where}.pairs")):
        place = f"{where}.pairs[{i}]"
        entry = _object(item, place, ["context"] * local + ["higher", "lower", "multipliers"])
        context = _integer(entry["context"], f"{place}.context") if local else -1
        pair = context, _integer(entry["higher"], f"{place}.higher"), _integer(entry["lower"], f"{place}.lower")
        if pair <= last:
            raise _malformed(place, "is not in increasing order of context, higher and lower")
        last = pair
        pairs[pair] = _read_multipliers(entry["multipliers"], f"{place}.multipliers")
    return Dual(pairs, None if parameters is None else _signed(members["theta"], f"{where}.theta", parameters))


def _read_multipliers(value: object, where: str) -> list[tuple[int, Rational]]:
    multipliers: list[tuple[int, Rational]] = []
    for i, item in enumerate(_list(value, where)):
        number, y = _list(item, f"{where}[{i}]", 2)
        multipliers.append((_integer(number, f"{where}[{i}][0]"), _rational(y, f"{where}[{i}][1]", nonnegative=True)))
        if multipliers[i][1] == ZERO:
            raise _malformed(f"{where}[{i}][1]", "must be positive")
        if i and multipliers[i][0] <= multipliers[i - 1][0]:
            raise _malformed(f"{where}[{i}][0]", "is not greater than the number before")
    return multipliers


# An affine form in the variables: integer coefficients over one denominator, that of the constant under CONSTANT.  A
# constraint A v <= b is kept as its slack b - A v, an affine form that is at least 0 on the class.
Affine = tuple[dict[int, int], int]
CONSTANT = -1


def _affine_sum(terms: Iterable[tuple[Rational, Affine]]) -> Affine:
    """Add up multiples of affine forms."""
    kept = [(n, d * denominator, form) for (n, d), (form, denominator) in terms if n]
    common = _common({d for _, d, _ in kept})
    count = sum(len(form) for _, _, form in kept)
    bits = max((n.bit_length() + max(map(int.bit_length, form.values()), default=0) for n, _, form in kept), default=0)
    _spend(3 * count, bits + common.bit_length(), bits)
    _keep(count, bits + common.bit_length())
    total: dict[int, int] = {}
    for n, d, form in kept:
        factor = n * (common // d)
        for j, coefficient in form.items():
            total[j] = total.get(j, 0) + factor * coefficient
    return total, common


def _minus(value: Rational) -> Rational:
    return -value[0], value[1]


def _constant(value: Rational) -> Affine:
    return {CONSTANT: value[0]}, value[1]


class Program:
    """The variables, boxes and constraints of a class of utilities on a table.

    A place is a cell, or when the class is blind a context that has cells: where g(u) can be chosen anew.  The
    variables are numbered by place and decision; those of a family are its parameters.
    """

    def __init__(self, utilities: UtilityClass, table: Table) -> None:
        header = table.header
        self.utilities, self.table = utilities, table
        self.decisions = len(header.decisions)
        self.by_context, self.by_group = table.by_context(), table.by_group()
        if utilities.metric is not None and len(utilities.metric) != len(header.groups):
            raise _malformed("subject.class.metric", f"must have {len(header.groups)} rows, one for each group")
        numbers = {label: u for u, label in enumerate(header.decisions)}
        for i, label in ((i, label) for i, pair in enumerate(utilities.order) for label in pair):
            if label not in numbers:
                raise _malformed(f"subject.class.order[{i}]", f"names a decision that the table does not have: {shown(label)}")
        self.order = [(numbers[lower], numbers[higher]) for lower, higher in utilities.order]
        self.places: dict[tuple[int, int | None], int] = {}  # by context and group
        for cell in table.cells:
            self.places.setdefault((cell.context, None if utilities.blind else cell.group), len(self.places))
        self.places_of: dict[int, list[int]] = {-1: [*self.places.values()]}  # by context; -1 stands for all of them
        for (context, _), place in self.places.items():
            self.places_of.setdefault(context, []).append(place)
        self.everywhere = _globally_compared(table)
        box = [utilities.m, utilities.gamma] * (len(self.places) * self.decisions)
        self.values: list[Affine] = [({j: 1}, 1) for j in range(len(self.places) * self.decisions)]  # g by place and decision
        if utilities.family is not None:
            self.values = self._features(utilities.family)
            box = [end for ends in zip(utilities.family.lower, utilities.family.upper, strict=True) for end in ends]
        ends, self.unit_of_box = _over_common_denominator(box)
        self.box = [*zip(ends[::2], ends[1::2], strict=True)]
        self.rows = [self._row(terms, bound, f"subject.class.rows[{i}]") for i, (terms, bound) in enumerate(utilities.rows)]
        self._means: dict[tuple[int, int], Affine] = {}
        self._differing: dict[int, list[tuple[Cell, Cell]]] = {}

    def place(self, cell: Cell) -> int:
        """Number the place of a cell."""
        return self.places[cell.context, None if self.utilities.blind else cell.group]

    def _features(self, family: Family) -> list[Affine]:
        """Write g by place and decision as forms in the parameters."""
        where = "subject.class.family.features"
        _list(family.features, where, len(self.table.cells))
        chosen: dict[int, list[list[Rational]]] = {}
        for i, (cell, features) in enumerate(zip(self.table.cells, family.features, strict=True)):
            _list(features, f"{where}[{i}]", self.decisions)
            if chosen.setdefault(self.place(cell), features) != features:
                raise _malformed(f"{where}[{i}]", "differ from those of another group, but the class is blind")
        forms: list[Affine] = []
        for phi in chain.from_iterable(chosen.values()):
            coefficients, denominator = _over_common_denominator(phi)
            forms.append((dict(enumerate(coefficients)), denominator))
        return forms

    def _row(self, terms: Sequence[tuple[int, int | None, int, Rational]], bound: Rational, where: str) -> Affine:
        """Write a further constraint as its slack."""
        parts = [(ONE, _constant(bound))]
        for i, (context, group, decision, coefficient) in enumerate(terms):
            if (context, group) not in self.places or decision >= self.decisions:
                raise _malformed(f"{where}.terms[{i}]", "names what the table does not have")
            parts.append((_minus(coefficient), self.value(self.places[context, group], decision)))
        return _affine_sum(parts)

    def value(self, place: int, decision: int) -> Affine:
        """Write g(u) at a place."""
        return self.values[place * self.decisions + decision]

    def _expectation(self, cell: Cell) -> Affine:
        weights, total = cell.law
        place = self.place(cell)
        return _affine_sum(((w, total), self.value(place, u)) for u, w in enumerate(weights))

    def mean(self, context: int, group: int) -> Affine:
        """Write E(x,a), or the mean of E(.,a) when the context is -1."""
        if (context, group) not in self._means:
            if context >= 0:
                _spend(len(self.by_context[context]))
                form = self._expectation(next(cell for cell in self.by_context[context] if cell.group == group))
            else:
                n, d = _sum(cell.mass for cell in self.by_group[group])
                form = _affine_sum(((c.mass[0] * d, c.mass[1] * n), self._expectation(c)) for c in self.by_group[group] if c.mass[0])
            self._means[context, group] = form
        return self._means[context, group]

    def compared(self) -> list[tuple[int, list[int]]]:
        """List the groups that are compared, by context; the context is -1 where the means of groups are compared."""
        if self.utilities.quantity == "global":
            return [(-1, self.everywhere)]
        return [(x, [cell.group for cell in cells]) for x, cells in enumerate(self.by_context) if len(cells) > 1]

    def groups_with_floor(self, context: int, higher: int, lower: int) -> list[int]:
        """List the groups that keep the floor where these two are compared."""
        if self.utilities.tau is None:
            return []
        if self.utilities.tau_on == "pair":
            return [higher, lower]
        _spend(len(self.everywhere if context < 0 else self.by_context[context]))
        return self.everywhere if context < 0 else [cell.group for cell in self.by_context[context]]

    def _differing_cells(self, context: int) -> list[tuple[Cell, Cell]]:
        """List the ordered pairs of different cells of a context, or of every context when it is -1."""
        if context not in self._differing:
            lists = self.by_context if context < 0 else [self.by_context[context]]
            count = sum(len(cells) ** 2 for cells in lists)
            _spend(3 * count)
            _keep(3 * count)
            self._differing[context] = [pair for cells in lists for pair in permutations(cells, 2)]
        return self._differing[context]

    def slack(self, pair: tuple[int, int, int], number: int) -> Affine | None:
        """Write the slack of a constraint by its number; the floors, and what of the table matters, depend on the pair."""
        utilities, family = self.utilities, self.utilities.family
        concerned = -1 if utilities.rows or family is not None else pair[0]
        floors = self.groups_with_floor(*pair)
        if number < len(floors):
            return _affine_sum([(ONE, self.mean(pair[0], floors[number])), (_minus(utilities.tau or ZERO), _constant(ONE))])
        number -= len(floors)

        places = self.places_of[concerned]
        if number < len(places) * len(self.order):
            lower, higher = self.order[number % len(self.order)]
            place = places[number // len(self.order)]
            return _affine_sum([(ONE, self.value(place, higher)), ((-1, 1), self.value(place, lower))])
        number -= len(places) * len(self.order)

        if utilities.lipschitz is not None:
            pairs = self._differing_cells(concerned)
            if number < len(pairs) * self.decisions:
                left, right = pairs[number // self.decisions]
                one, other = (self.value(self.place(cell), number % self.decisions) for cell in (left, right))
                return _affine_sum([(ONE, _constant(self.allowed(left, right))), ((-1, 1), one), (ONE, other)])
            number -= len(pairs) * self.decisions

        if number < len(self.rows):
            return self.rows[number]
        number -= len(self.rows)

        if family is None:
            return None
        if number < 2 * len(self.values):
            g = self.values[number // 2]
            if number % 2 == 0:
                return _affine_sum([(ONE, g), (_minus(utilities.m), _constant(ONE))])
            return _affine_sum([(utilities.gamma, _constant(ONE)), ((-1, 1), g)])
        number -= 2 * len(self.values)
        if number < len(family.rows):
            coefficients, bound = family.rows[number]
            return _affine_sum([(ONE, _constant(bound)), *((_minus(c), ({k: 1}, 1)) for k, c in enumerate(coefficients))])
        return None

    def allowed(self, left: Cell, right: Cell) -> Rational:
        """How much g may differ between two groups: L d(a,a')."""
        metric = self.utilities.metric
        distance = ONE if metric is None else metric[left.group][right.group]
        return _product([self.utilities.lipschitz or ZERO, distance])

    def greatest(self, form: Affine) -> Rational:
        """Find the greatest value of an affine form when every variable is in its box, whatever the constraints say."""
        coefficients, denominator = form
        _spend(3 * len(coefficients), max(map(int.bit_length, coefficients.values()), default=0), self.unit_of_box.bit_length())
        total = coefficients.get(CONSTANT, 0) * self.unit_of_box
        for j, coefficient in coefficients.items():
            if j != CONSTANT:
                low, high = self.box[j]
                total += coefficient * (high if coefficient > 0 else low)
        return total, denominator * self.unit_of_box


def _outside(program: Program, metric: Maximum | None, theta: Sequence[Rational] | None) -> str:
    """Say which constraint of the class the utility of the table violates; nothing if it is in the class."""
    utilities, table = program.utilities, program.table
    gamma, m = Fraction(*utilities.gamma), Fraction(*utilities.m)
    first: dict[int, list[Fraction]] = {}  # g by place
    gains: list[list[Fraction]] = []  # g by cell
    for cell in table.cells:
        where = _place(table, cell)
        own = [Fraction(*entry) for entry in cell.utility if entry is not None]
        if len(own) < program.decisions:
            return f"the utility is not given everywhere {where}"
        if not all(m <= g <= gamma for g in own):
            return f"the utility leaves [m, gamma] {where}"
        if first.setdefault(program.place(cell), own) != own:
            return f"the utility depends on the group {where}, but the class is blind"
        for (lower, higher), names in zip(program.order, utilities.order, strict=True):
            if own[lower] > own[higher]:
                return f"the utility violates the order {shown(names)} {where}"
        gains.append(own)
    if utilities.lipschitz is not None:
        by_context: list[list[tuple[Cell, list[Fraction]]]] = [[] for _ in table.header.contexts]
        for cell, own in zip(table.cells, gains, strict=True):
            by_context[cell.context].append((cell, own))
        bits = 2 * max((_bits(g) for own in gains for g in own), default=0)
        _spend(sum(len(cells) ** 2 for cells in by_context) * 15 * (1 + program.decisions), bits, bits)
        for (left, one), (right, other) in chain.from_iterable(combinations(cells, 2) for cells in by_context):
            allowed = Fraction(*program.allowed(left, right))
            if one != other and any(abs(g - h) > allowed for g, h in zip(one, other, strict=True)):
                return f"the utility violates the Lipschitz constraint between group {right.group} and the cell {_place(table, left)}"
    for i, (terms, bound) in enumerate(utilities.rows):
        bits = _bits(bound) + sum(_bits(c) + _bits(first[program.places[x, a]][u]) for x, a, u, c in terms)
        _spend(20 * len(terms), bits // max(1, len(terms)), bits)
        if sum(Fraction(*c) * first[program.places[x, a]][u] for x, a, u, c in terms) > Fraction(*bound):
            return f"the utility violates subject.class.rows[{i}]"
    if utilities.family is not None and (fault := _outside_family(utilities.family, table, gains, theta)):
        return fault
    return _below_floor(program, metric)


def _place(table: Table, cell: Cell) -> str:
    return f"in context {shown(list(table.header.contexts[cell.context]))}, group {shown(list(table.header.groups[cell.group]))}"


def _outside_family(family: Family, table: Table, gains: Sequence[Sequence[Fraction]], theta: Sequence[Rational] | None) -> str:
    """Say why theta does not show that the utility belongs to the family."""
    if theta is None:
        return "no claim by lp-dual about this quantity gives the theta of the utility"
    own = [Fraction(*parameter) for parameter in theta]
    for k, (low, high) in enumerate(zip(family.lower, family.upper, strict=True)):
        if not Fraction(*low) <= own[k] <= Fraction(*high):
            return f"theta[{k}] is not within its ends"
    widest = _bits(*own)
    for i, (coefficients, bound) in enumerate(family.rows):
        bits = widest + _bits(*coefficients)
        _spend(20 * len(own), bits // len(own), bits)
        if sum(Fraction(*c) * parameter for c, parameter in zip(coefficients, own, strict=True)) > Fraction(*bound):
            return f"theta violates subject.class.family.rows[{i}]"
    for cell, features, values in zip(table.cells, family.features, gains, strict=True):
        for phi, g in zip(features, values, strict=True):
            bits = widest + _bits(*phi)
            _spend(20 * len(own), bits // len(own), bits)
            if sum(Fraction(*f) * parameter for f, parameter in zip(phi, own, strict=True)) != g:
                return f"theta does not give the utility {_place(table, cell)}"
    return ""


def _below_floor(program: Program, metric: Maximum | None) -> str:
    tau, table = program.utilities.tau, program.table
    if tau is None or metric is None:
        return ""
    context, higher, lower = metric.place
    for group in program.groups_with_floor(-1 if context is None else context, higher, lower):
        if context is None:
            _, mean = table.figures.of_group(group)
        else:
            mean = next(cell.expectation for cell in program.by_context[context] if cell.group == group)
        if not _at_most(tau, mean):
            return f"the floor is violated by group {shown(list(table.header.groups[group]))}, whose expectation is {shown(mean)}"
    return ""


def _fault_of_worst_case(claim: Claim, rule: Rule, program: Program) -> str:
    """Judge a claim about every utility of the class."""
    utilities = program.utilities
    if rule.quantity != utilities.quantity:
        return f"the class is about the {utilities.quantity} ratio"
    if not _at_most(ONE, claim.value):
        return "the value is less than 1, the ratio of 0 to 0"
    if claim.key[2] == "T3":
        if not utilities.blind or (utilities.tau is not None and utilities.tau_on == "pair"):
            return "T3 is for blind classes in which all groups keep the floor"
        if utilities.order or utilities.rows or utilities.family is not None:
            return "T3 is for classes without further constraints"
    if claim.value == INFINITY:
        return ""
    if isinstance(claim.evidence, Dual):
        return _fault_of_dual(claim.value, claim.evidence, program)
    return _fault_of_closed_form(claim.value, claim.evidence if isinstance(claim.evidence, list) else [], program)


def _fault_of_dual(value: Rational, evidence: Dual, program: Program) -> str:
    """Look for a compared pair for which the multipliers do not prove the claim.

    E and E' being those of the two groups, slack_i >= 0 on the class and y_i > 0,
    E - value E' <= E - value E' + sum of y_i slack_i, which is an affine form.  If its greatest value on the boxes is at
    most 0, then E <= value E' for every utility of the class; in particular E = 0 if E' = 0, and 0/0 = 1 <= value.
    """
    utilities, pairs = program.utilities, dict(evidence.pairs)
    # Both settings of tau_on put the floor under the lower group of every pair: E/E' <= gamma/floor.
    bounded = utilities.floor != ZERO and _at_most(_product([utilities.gamma, (utilities.floor[1], utilities.floor[0])]), value)
    for context, groups in program.compared():
        # The expectations of a blind utility under equal laws are equal.
        alike = utilities.blind and context >= 0 and len({cell.law for cell in program.by_context[context]}) == 1
        _spend(3 * len(groups) ** 2)
        for higher, lower in permutations(groups, 2):
            pair = context, higher, lower
            named = f"{'' if context < 0 else f'context {context}, '}groups {higher} and {lower}"
            if pair not in pairs:
                if alike or bounded:
                    continue
                return f"the evidence lacks {named}"
            terms = [(ONE, program.mean(context, higher)), (_minus(value), program.mean(context, lower))]
            for number, y in pairs.pop(pair):
                slack = program.slack(pair, number)
                if slack is None:
                    return f"there is no constraint {number} for {named}"
                terms.append((y, slack))
            greatest = program.greatest(_affine_sum(terms))
            if greatest[0] > 0:
                return f"the multipliers leave {shown(_reduced(*greatest))}, more than 0, for {named}"
    for context, higher, lower in pairs:
        return f"the evidence names {'' if context < 0 else f'context {context}, '}groups {higher} and {lower}, which are not compared"
    return ""


def _fault_of_closed_form(value: Rational, multipliers: Iterable[Fraction], program: Program) -> str:
    """Look for a compared pair of rows P, Q for which no multiplier k proves the claim.

    H_k is the sum of max(0, P - k Q).  Where m <= g <= gamma, E - k E' is the sum of (P - k Q) g, which is at most
    (gamma - m) H_k + (1 - k) m.  With t, the floor of E', this gives E/E' <= k + max(0, (gamma - m) H_k - (k - 1) m) / t;
    if t = 0, hence m = 0, then H_k = 0 gives E <= k E'.

    k t + max(0, (gamma - m) H_k - (k - 1) m) is convex in k.  So where it is too great, its slope tells on which side of k
    others may do, and few of them have to be tried.
    """
    utilities = program.utilities
    (gamma, m, floor), _ = _over_common_denominator([utilities.gamma, utilities.m, utilities.floor])
    above, below = value
    ks = sorted({k for k in multipliers if k <= Fraction(*value)})
    hint = 0  # where the last multiplier that did was found

    def proved(p: Law, q: Law) -> bool:
        nonlocal hint
        common = p[1] * q[1]
        low, high = 0, len(ks)
        at = hint
        while low < high:
            n, d = _pair(ks[at])
            bits = common.bit_length()
            _spend(4 * len(p[0]) + 10, bits, d.bit_length() + n.bit_length())
            _spend(4, bits + _bits(value) + floor.bit_length(), d.bit_length() + n.bit_length() + gamma.bit_length())
            # P > k Q means p * raised > q * lowered; H_k is the sum of the differences over common * d
            raised, lowered = q[1] * d, p[1] * n
            sum_p = sum_q = 0
            for a, b in zip(p[0], q[0], strict=True):
                if a * raised > b * lowered:
                    sum_p += a
                    sum_q += b
            excess = (gamma - m) * (sum_p * raised - sum_q * lowered) - (n - d) * m * common
            if below * (n * floor * common + max(0, excess)) <= above * floor * d * common:
                hint = at
                return True
            # Since k <= value, the excess is positive here; the slope is floor - (gamma - m) * sum_q / q[1] - m.
            if (floor - m) * q[1] < (gamma - m) * sum_q:
                low = at + 1
            else:
                high = at
            at = (low + high) // 2
        return False

    for context, groups in program.compared():
        if context >= 0:
            laws = [cell.law for cell in program.by_context[context]]
        else:
            forms = [program.mean(-1, group) for group in groups]
            _spend(len(groups) * len(program.values))
            _keep(len(groups) * len(program.values) // 3)
            laws = [_law([form.get(j, 0) for j in range(len(program.values))], total) for form, total in forms]
        _spend(3 * len(groups) ** 2)
        for (higher, p), (lower, q) in permutations(zip(groups, laws, strict=True), 2):
            if p != q and not proved(p, q):
                place = "" if context < 0 else f"context {context}, "
                return f"no multiplier proves the value for {place}groups {higher} and {lower}"
    return ""


# ---------------------------------------------------------------------------------------------------------------------
# Intervals for the population behind a sample

METHODS = ("hoeffding-kl", "empirical-bernstein", "intersection")
OVER_UNITS = "mean over units"  # what an interval with units is about; without units it is the mean over rows
BETTING = "betting"  # the method of intervals that hold at every moment of a stream
SUMMED = 5000  # draws up to which binomial tails are exact sums
PRECISION = 256  # bits after the point of the enclosures here


class Unproven(Exception):
    """The evidence of an interval does not prove it."""


Ladder = list[Fraction]
Box = list[tuple[Fraction, Fraction]]
Place = tuple[int, int, int]  # a block, and the positions of two forms in it, the higher one first


@dataclass(frozen=True)
class BoxEvidence:
    """Ends of all cells, at the levels for the upper and for the lower end of the ratio."""

    levels: tuple[Fraction, Fraction]
    upper: Box
    lower: Box
    pair: Place | None


@dataclass(frozen=True)
class LadderEvidence:
    """Ladders for the upper end by block, and one for the lower end; the levels are (b, c)."""

    levels: tuple[tuple[Fraction, Fraction], tuple[Fraction, Fraction]]
    upper: list[Ladder] | None
    lower: tuple[Place, Ladder] | None


@dataclass(frozen=True)
class StreamEvidence:
    """Of a stream: the ranks of its cells and how many were expected; ends of all cells with a pair, or ladders."""

    expected: int
    order: list[int]
    ends: Box | None
    pair: Place | None
    ladders: list[Ladder] | None
    proof: tuple[Place, Ladder] | None


@dataclass(frozen=True)
class Interval:
    """An interval as the certificate states it."""

    quantity: str
    confidence: Rational
    scope: str
    independent: bool
    method: str
    limits: tuple[Fraction, Fraction] | None
    units: list[list[tuple[int, list[int]]]] | None
    measured: dict[str, object] | None  # with units, the ratio of their means in the sample
    ratio: tuple[Rational, Rational]
    evidence: BoxEvidence | LadderEvidence | StreamEvidence

    @property
    def region(self) -> str:
        """The name of the kind of evidence."""
        boxed = self.evidence.ends is not None if isinstance(self.evidence, StreamEvidence) else isinstance(self.evidence, BoxEvidence)
        return "box" if boxed else "product"


@dataclass(frozen=True)
class Proven:
    """An interval that holds but with the probability ``error``, and what claims about it have to say."""

    ratio: tuple[Rational, Rational]
    error: Fraction
    scope: str
    by: str


@dataclass(frozen=True)
class Sample:
    """Independent draws of a number between low and high that have the same mean; binary if they are low or high."""

    draws: int
    total: Fraction
    squares: Fraction
    low: Fraction
    high: Fraction
    binary: bool

    @property
    def informative(self) -> bool:
        """Whether the draws say more of the mean than the range does."""
        return self.draws > 0 and self.low < self.high

    def tail(self, mean: Fraction, below: bool) -> "Tail":
        """The lower tail, or the upper one, at a mean; for informative samples."""
        n, width = self.draws, self.high - self.low
        k, p = (self.total - n * self.low) / width, (mean - self.low) / width
        return (n, k, p, self.binary) if below else (n, n - k, 1 - p, self.binary)


@dataclass(frozen=True)
class DifferenceInterval:
    """An interval of a greatest difference of rates, with ends of all rates in use at the levels for its upper and for its lower end."""

    confidence: Fraction
    scope: str
    levels: tuple[Fraction, Fraction]
    upper: Box
    lower: Box
    difference: tuple[Rational, Rational]


def _read_difference(value: object, where: str) -> DifferenceInterval:
    members = _object(value, where, ("confidence", "levels", "upper", "lower", "difference"))
    levels = _object(members["levels"], f"{where}.levels", ("upper", "lower"))
    upper, lower = (
        [_two(item, f"{where}.{name}[{i}]") for i, item in enumerate(_list(members[name], f"{where}.{name}"))]
        for name in ("upper", "lower")
    )
    low, high = _rationals(members["difference"], f"{where}.difference", 2)
    return DifferenceInterval(
        _read_confidence(members["confidence"], f"{where}.confidence"),
        POPULATION + _string(members["confidence"], f"{where}.confidence"),
        (_level(levels["upper"], f"{where}.levels.upper"), _level(levels["lower"], f"{where}.levels.lower")),
        upper,
        lower,
        (low, high),
    )


def _prove_difference(interval: DifferenceInterval, blocks: Sequence[Sequence[Share]]) -> None:
    """Make sure that the ends of all rates prove the interval of the greatest difference of two rates of one block."""
    samples = []
    for share in chain.from_iterable(blocks):
        if share.draws.denominator != 1 or share.positives.denominator != 1:
            raise Unproven("the counts are not integers")
        samples.append(Sample(share.draws.numerator, share.positives, share.positives, Fraction(0), Fraction(1), binary=True))
    beta, other = interval.levels
    if not 0 < other <= beta < 1:
        raise Unproven("the levels must be positive and less than 1, and that for the lower end no greater")
    # The pair with the greatest difference needs one end of each of its two rates; which pair proves the lower end depends on the draws.
    spent = 2 * beta + (2 * len(samples) - 2) * other
    if spent > 1 - interval.confidence:
        raise Unproven(f"the levels add up to {shown(_pair(spent))}")
    for name, ends, level in (("upper", interval.upper, beta), ("lower", interval.lower, other)):
        if len(ends) != len(samples):
            raise Unproven(f"{name} must list the ends of {len(samples)} rates, not of {len(ends)}")
        for i, (sample, (lo, hi)) in enumerate(zip(samples, ends, strict=True)):
            if fault := _fault_of_ends(sample, lo, hi, level, METHODS[0]):
                raise Unproven(f"{name}[{i}] {fault}")
    greatest, least, first = Fraction(0), Fraction(0), 0
    for block in blocks:
        outer, inner = (ends[first : first + len(block)] for ends in (interval.upper, interval.lower))
        first += len(block)
        greatest = max(greatest, _widest_gap([hi for _, hi in outer], [lo for lo, _ in outer]))
        least = max(least, _widest_gap([lo for lo, _ in inner], [hi for _, hi in inner]))
    low, high = (Fraction(*end) for end in interval.difference)
    if high < min(greatest, Fraction(1)):
        raise Unproven("two rates can be further apart than the upper end")
    if not 0 <= low <= least:
        raise Unproven("no two rates are surely as far apart as the lower end")


def _widest_gap(tops: Sequence[Fraction], bottoms: Sequence[Fraction]) -> Fraction:
    """The greatest top less the bottom of another one, of at least two."""
    low = sorted(range(len(bottoms)), key=bottoms.__getitem__)[:2]
    return max(top - bottoms[low[0] if i != low[0] else low[1]] for i, top in enumerate(tops))


def _read_confidence(value: object, where: str) -> Fraction:
    confidence = Fraction(*_rational(value, where))
    if not 0 < confidence < 1:
        raise _malformed(where, "must have a confidence between 0 and 1")
    return confidence


def _read_intervals(
    value: object, where: str, subject: Subject, differences: Sequence[str]
) -> tuple[dict[str, Interval], dict[str, DifferenceInterval]]:
    members = _object(value, where, (), optional=("local", "global", *differences))
    if not members:
        raise _malformed(where, "must not be empty")
    ratios = {name: _read_interval(members[name], f"{where}.{name}", name, subject) for name in members if name not in differences}
    return ratios, {name: _read_difference(members[name], f"{where}.{name}") for name in members if name in differences}


def _read_interval(value: object, where: str, name: str, subject: Subject) -> Interval:
    keys = ["confidence", "side", "region", "independent", "method", "limits", "ratio", "levels", "upper", "lower"]
    of_box = isinstance(value, dict) and value.get("region") == "box"
    of_stream = isinstance(value, dict) and value.get("method") == BETTING
    if name == "local" and subject.kind == "counts" and not of_stream and isinstance(value, dict) and "units" in value:
        keys += ["units", "estimand", "measured"]
    members = _object(value, where, keys + ["pair"] * of_box)
    _one_of(members["side"], f"{where}.side", ("both",))
    _one_of(members["region"], f"{where}.region", ("box", "product"))
    levels = _object(members["levels"], f"{where}.levels", ("expected", "order") if of_stream else ("upper", "lower"))
    upper, lower = members["upper"], members["lower"]
    evidence: BoxEvidence | LadderEvidence | StreamEvidence
    if of_stream:
        evidence = _read_stream(members, levels, where, of_box)
    elif of_box:
        evidence = BoxEvidence(
            (_level(levels["upper"], f"{where}.levels.upper"), _level(levels["lower"], f"{where}.levels.lower")),
            [_two(item, f"{where}.upper[{i}]") for i, item in enumerate(_list(upper, f"{where}.upper"))],
            [_two(item, f"{where}.lower[{i}]") for i, item in enumerate(_list(lower, f"{where}.lower"))],
            None if members["pair"] is None else _read_pair(members["pair"], f"{where}.pair"),
        )
    else:
        proof = None if lower is None else _object(lower, f"{where}.lower", ("pair", "knots"))
        ladders = None if upper is None else _list(upper, f"{where}.upper")
        evidence = LadderEvidence(
            (_two(levels["upper"], f"{where}.levels.upper"), _two(levels["lower"], f"{where}.levels.lower")),
            None if ladders is None else [_read_ladder(item, f"{where}.upper[{i}]") for i, item in enumerate(ladders)],
            None if proof is None else (_read_pair(proof["pair"], f"{where}.lower.pair"), _read_ladder(proof["knots"], f"{where}.lower")),
        )
    limits = None if members["limits"] is None else _two(members["limits"], f"{where}.limits")
    if limits is not None and limits[0] > limits[1]:
        raise _malformed(f"{where}.limits", "must have the lower one first")
    ends = _list(members["ratio"], f"{where}.ratio", 2)
    confidence = _read_confidence(members["confidence"], f"{where}.confidence")
    return Interval(
        name,
        _pair(confidence),
        POPULATION + _string(members["confidence"], f"{where}.confidence"),
        _boolean(members["independent"], f"{where}.independent"),
        _one_of(members["method"], f"{where}.method", (*METHODS, BETTING)),
        limits,
        _read_units(members["units"], f"{where}.units") if "units" in members else None,
        _read_measured(members, where, subject.columns) if "units" in members else None,
        (_rational(ends[0], f"{where}.ratio[0]"), _extended(ends[1], f"{where}.ratio[1]")),
        evidence,
    )


def _read_change(value: object, where: str, subject: Subject) -> Change:
    keys = ("quantity", "window", "confidence", "stream", "table", "ratio", "assumptions")
    members = _object(value, where, keys)
    quantity = _one_of(members["quantity"], f"{where}.quantity", ("local", "global"))
    window = _integer(members["window"], f"{where}.window")
    if subject.kind != "counts" or window == 0:
        raise _malformed(where, "must be about counts, and a window with a number of at least 1")
    stream, ratio = (_read_interval(members[name], f"{where}.{name}", quantity, subject) for name in ("stream", "ratio"))
    if not isinstance(stream.evidence, StreamEvidence) or not isinstance(ratio.evidence, StreamEvidence):
        raise _malformed(where, f"must have intervals of a stream, by the method {shown(BETTING)}")
    table = _object(members["table"], f"{where}.table", ("sha256", "cells", "header", "rows"))
    return Change(
        quantity,
        window,
        _read_confidence(members["confidence"], f"{where}.confidence"),
        stream,
        _digest(table["sha256"], f"{where}.table.sha256"),
        _integer(table["cells"], f"{where}.table.cells"),
        (table["header"], *_list(table["rows"], f"{where}.table.rows")),
        ratio,
        _strings(members["assumptions"], f"{where}.assumptions"),
    )


def _read_stream(members: Mapping[str, object], levels: Mapping[str, object], where: str, of_box: bool) -> StreamEvidence:
    expected = _integer(levels["expected"], f"{where}.levels.expected")
    listed = _list(levels["order"], f"{where}.levels.order")
    order = [_integer(rank, f"{where}.levels.order[{i}]") for i, rank in enumerate(listed)]
    if expected == 0 or 0 in order or len(set(order)) != len(order):
        raise _malformed(f"{where}.levels", "must have different ranks, all numbers being at least 1")
    upper, lower = members["upper"], members["lower"]
    if of_box:
        ends, again = (
            [_two(item, f"{where}.{name}[{i}]") for i, item in enumerate(_list(members[name], f"{where}.{name}"))]
            for name in ("upper", "lower")
        )
        if ends != again:
            raise _malformed(f"{where}.lower", "must be the same as upper")
        return StreamEvidence(
            expected, order, ends, None if members["pair"] is None else _read_pair(members["pair"], f"{where}.pair"), None, None
        )
    ladders = (
        None if upper is None else [_read_ladder(item, f"{where}.upper[{i}]") for i, item in enumerate(_list(upper, f"{where}.upper"))]
    )
    proof = None
    if lower is not None:
        parts = _object(lower, f"{where}.lower", ("pair", "knots"))
        proof = _read_pair(parts["pair"], f"{where}.lower.pair"), _read_ladder(parts["knots"], f"{where}.lower")
    return StreamEvidence(expected, order, None, None, ladders, proof)


def _level(value: object, where: str) -> Fraction:
    return Fraction(*_rational(value, where, nonnegative=True))


def _two(value: object, where: str) -> tuple[Fraction, Fraction]:
    first, second = _rationals(value, where, 2)
    return Fraction(*first), Fraction(*second)


def _read_ladder(value: object, where: str) -> Ladder:
    return [Fraction(*knot) for knot in _rationals(value, where, len(_list(value, where)))]


def _read_pair(value: object, where: str) -> Place:
    block, higher, lower = (_integer(item, f"{where}[{i}]") for i, item in enumerate(_list(value, where, 3)))
    return block, higher, lower


def _read_measured(members: Mapping[str, object], where: str, columns: Columns) -> dict[str, object]:
    _one_of(members["estimand"], f"{where}.estimand", (OVER_UNITS,))
    metric = _read_metric(members["measured"], f"{where}.measured", "local", columns)
    if metric is None:
        raise _malformed(f"{where}.measured", "must not be null")
    return metric


def _read_units(value: object, where: str) -> list[list[tuple[int, list[int]]]]:
    lists: list[list[tuple[int, list[int]]]] = []
    for i, entries in enumerate(_list(value, where)):
        units: dict[tuple[int, ...], int] = {}
        for j, item in enumerate(_list(entries, f"{where}[{i}]")):
            place = f"{where}[{i}][{j}]"
            number, counts = _list(item, place, 2)
            rows = tuple(_integer(count, f"{place}[1][{u}]") for u, count in enumerate(_list(counts, f"{place}[1]")))
            if rows in units or not any(rows):
                raise _malformed(f"{place}[1]", "must not be all 0, nor what stood there before")
            units[rows] = _integer(number, f"{place}[0]")
            if units[rows] == 0:
                raise _malformed(f"{place}[0]", "must be at least 1")
        lists.append([(n, list(rows)) for rows, n in units.items()])
    return lists


@dataclass(frozen=True)
class Comparison:
    """Samples, and by block the forms that are compared: expected utilities as weighted sums of the means of the samples."""

    samples: list[Sample]
    blocks: list[list[Affine]]
    shared: bool  # whether a draw occurs in several samples


Part = tuple[Sequence[int], Sequence[Rational | None]]  # the counts of the decisions, and their utilities
Units = Sequence[tuple[int, Sequence[int]]]  # how many draws had which counts


def _sample(parts: Sequence[Part], units: Units | None, limits: tuple[Fraction, Fraction], declared: bool) -> Sample:
    """Pool counts; the units say which rows of a single part belong to one draw.

    Draws are of two values only if the utility says so of whatever could have been drawn, which a declared range and units do not.
    """
    low, high = limits
    pooled: Counter[Rational | None] = Counter()
    for counts, utility in parts:
        for count, g in zip(counts, utility, strict=True):
            pooled[g] += count
    values = {g: Fraction(*g) for g in pooled if g is not None}
    draws = [(pooled[g], value) for g, value in values.items() if pooled[g]]
    binary = units is None and not declared and None not in pooled and all(value in (low, high) for value in values.values())
    if units is not None:
        [(_, utility)] = parts
        rows = [
            (n, [(count, values[g]) for count, g in zip(counts, utility, strict=True) if count and g is not None]) for n, counts in units
        ]
        draws = [(n, _weighted(own) / sum(c for c, _ in own)) for n, own in rows]
    _spend(40 * len(draws))
    total, squares = (_weighted((n, value**power) for n, value in draws) for power in (1, 2))
    return Sample(sum(n for n, _ in draws), total, squares, low, high, binary)


def _weighted(terms: Iterable[tuple[int, Fraction]]) -> Fraction:
    """Add up multiples of fractions."""
    return Fraction(*_sum([ZERO, *((n * value.numerator, value.denominator) for n, value in terms)]))


class _Sampling:
    """What the samples of an interval are taken from."""

    def __init__(self, interval: Interval, table: Table) -> None:
        self.interval, self.table = interval, table
        self.declared = interval.limits is not None
        self.partly = any(None in cell.utility for cell in table.cells)
        given = {g for cell in table.cells for g in cell.utility} if self.partly else set()
        self.greatest = max((Fraction(*g) for g in given if g is not None), default=Fraction(0))

    def limits(self, cells: Iterable[Cell]) -> tuple[Fraction, Fraction]:
        """The range of g in some cells; if g is not given somewhere, it may be anything up to the greatest one there is."""
        if self.interval.limits is not None:
            return self.interval.limits
        if self.partly:
            return Fraction(0), self.greatest
        return Fraction(0), max(Fraction(*g) for cell in cells for g in set(cell.utility) if g is not None)

    def of_counts(self) -> Comparison:
        """Take a sample from each cell that is compared, or from each group, whose rows are pooled over the contexts."""
        table, units = self.table, self.interval.units
        by_group = table.by_group()
        blocks = [[by_group[a] for a in groups] for groups in [_globally_compared(table)] if groups]
        if self.interval.quantity == "local":
            blocks = [[[cell] for cell in cells] for cells in table.by_context() if len(cells) > 1]
        pools = [*chain.from_iterable(blocks)]
        if units is not None and len(units) != len(pools):
            raise Unproven(f"units must be listed for {len(pools)} cells, not for {len(units)}")
        samples: list[Sample] = []
        for i, cells in enumerate(pools):
            parts: list[Part] = []
            for cell in cells:
                (weights, total), (n, d) = cell.law, cell.mass
                if n % (d * total):
                    raise Unproven(f"the counts are not integers {_place(table, cell)}")
                parts.append(([weight * (n // (d * total)) for weight in weights], cell.utility))
            if units is not None:
                counts, _ = parts[0]
                rows = [[n * count for count in row] for n, row in units[i]]
                if any(len(row) != len(counts) for row in rows) or [*map(sum, zip(*rows, strict=True))] != counts:
                    raise Unproven(f"units[{i}] do not add up to the counts {_place(table, cells[0])}")
            samples.append(_sample(parts, None if units is None else units[i], self.limits(cells), self.declared))
        numbers = iter(range(len(samples)))
        return Comparison(samples, [[({next(numbers): 1}, 1) for _ in block] for block in blocks], units is not None)

    def of_policy(self, policy: Policy) -> Comparison:
        """Take a sample from each released context and group, for each true context and group if the utility depends on them."""
        table = self.table
        if not policy.draws:
            raise Unproven("the rows of the policy do not say how many decisions were drawn")
        groups, unit = policy.group.matrix()
        if policy.context is None:
            contexts, scale = [[(x, 1)] for x in range(len(policy.rows))], 1
        else:
            matrix, scale = policy.context.matrix()
            contexts = [[(x, p) for x, p in enumerate(row) if p] for row in matrix]
        by_group, by_context = constants(table)["depends_on_group"], table.header.utility is None
        pairs = sum(map(len, contexts)) * sum(map(len, groups))
        _spend(20 * pairs, (scale * unit).bit_length())
        _keep(4 * pairs, (scale * unit).bit_length())
        numbers: dict[tuple[int, int, int, int], int] = {}
        samples: list[Sample] = []
        forms: list[Affine] = []
        for cell in table.cells:
            form: dict[int, int] = {}
            own = (cell.context if by_context else -1, cell.group if by_group else -1)
            for (x, p), (a, q) in product(contexts[cell.context], enumerate(groups[cell.group])):
                if q:
                    number = numbers.setdefault((x, a, *own), len(samples))
                    form[number] = p * q
                    if number == len(samples):
                        _spend(100 + 40 * len(cell.utility))
                        _keep(40)
                        weights, total = policy.rows[x][a]
                        counts = [weight * (policy.draws[x][a] // total) for weight in weights]
                        samples.append(_sample([(counts, cell.utility)], None, self.limits([cell]), self.declared))
            forms.append((form, scale * unit))
        n = len(table.header.groups)
        blocks = [forms[i : i + n] for i in range(0, len(forms), n)]
        if self.interval.quantity == "global":
            means: list[Affine] = []
            for a in _globally_compared(table):
                masses = [cell.mass for cell in table.by_group()[a]]
                above, below = _sum(masses)
                means.append(_affine_sum(((p * below, q * above), form) for (p, q), form in zip(masses, forms[a::n], strict=True)))
            blocks = [means] if means else []
        return Comparison(samples, blocks, len({place[:2] for place in numbers}) < len(numbers))


def _proven(interval: Interval, table: Table) -> Proven:
    """Make sure that the evidence of an interval proves it."""
    if interval.limits is not None:
        low, high = interval.limits
        values = {g for utility in {cell.utility for cell in table.cells} for g in utility if g is not None}
        if not all(low <= Fraction(*g) <= high for g in values):
            raise Unproven("a utility in the table is outside the limits")
    if isinstance(interval.evidence, StreamEvidence):
        _Stream(interval, interval.evidence, table).prove()
        return Proven(interval.ratio, 1 - Fraction(*interval.confidence), interval.scope, BETTING)
    sampling = _Sampling(interval, table)
    if table.header.subject.kind == "probabilities" or (table.policy is not None and interval.units is not None):
        raise Unproven("the table is not of the stated kind")
    comparison = sampling.of_counts() if table.policy is None else sampling.of_policy(table.policy)
    samples, blocks = comparison.samples, comparison.blocks
    if not blocks:
        raise Unproven("the table does not give this quantity")
    if interval.measured is not None:
        _check_measured(interval.measured, samples, table)
    if interval.independent and comparison.shared:
        raise Unproven("samples that share draws are not independent")
    if not _at_most(ONE, interval.ratio[0]) or not _at_most(ONE, interval.ratio[1]):
        raise Unproven("no ratio is less than 1")
    supports = [[frozenset(i for i in form if samples[i].informative) for form, _ in block] for block in blocks]
    used: frozenset[int] = frozenset().union(*chain.from_iterable(supports))
    _spend(sum(len(block) * sum(4 + len(support) for support in block) for block in supports))
    if isinstance(interval.evidence, BoxEvidence):
        spanned = max(len(one | other) for block in supports for one, other in combinations(block, 2))
        _prove_by_box(interval, interval.evidence, comparison, len(used), spanned)
    else:
        _prove_by_ladders(interval, interval.evidence, comparison, len(used))
    by = "binomial" if all(samples[i].binary for i in used) else interval.method
    return Proven(interval.ratio, 1 - Fraction(*interval.confidence), interval.scope, by)


def _check_measured(stated: Mapping[str, object], samples: Sequence[Sample], table: Table) -> None:
    """Make sure that the ratio of the means over units is stated as the units of the local interval give it."""
    means = iter([_pair(sample.total / sample.draws) for sample in samples])
    found = _Greatest[Rational](_widest_ratio, lambda left, right: {"expectations": [_reduced(*left), _reduced(*right)]})
    for cells in table.by_context():
        if len(cells) > 1:
            found.offer([next(means) for _ in cells], [cell.group for cell in cells], cells[0].context)
    actual = found.maximum(table.header)
    expected = None if actual is None else {"ratio": actual.value, "log": log_enclosure(actual.value), "witness": actual.witness}
    if actual is None or stated != expected:
        raise Unproven("measured is not what the units give" + ("" if actual is None else f": {shown(actual.value)}"))


def _prove_by_box(interval: Interval, evidence: BoxEvidence, comparison: Comparison, used: int, spanned: int) -> None:
    samples, blocks = comparison.samples, comparison.blocks
    confidence = Fraction(*interval.confidence)
    beta, other = evidence.levels
    if not (0 < other <= beta < 1 if used else beta == other == 0):
        raise Unproven("the levels must be positive and less than 1, and that for the lower end no greater, or 0 where nothing was drawn")
    # One of the ends that matter is wrong with no greater probability than this.
    plain = spanned * beta + (2 * used - spanned) * other
    if plain > 1 - confidence and not (interval.independent and _all_hold(beta, other, used, spanned, confidence)):
        raise Unproven(f"the levels add up to {shown(_pair(plain))}")
    for name, ends, level in (("upper", evidence.upper, beta), ("lower", evidence.lower, other)):
        if len(ends) != len(samples):
            raise Unproven(f"{name} must list the ends of {len(samples)} cells, not of {len(ends)}")
        for i, (sample, (lo, hi)) in enumerate(zip(samples, ends, strict=True)):
            if fault := _fault_of_ends(sample, lo, hi, level, interval.method):
                raise Unproven(f"{name}[{i}] {fault}")
    low, high = interval.ratio
    if high != INFINITY:
        box = _scaled_box(evidence.upper)
        for number, block in enumerate(blocks):
            _check_block(block, number, Fraction(*high), box)
    if (low == ONE) is not (evidence.pair is None):
        raise Unproven("a pair has to be named exactly if the lower end is more than 1")
    if evidence.pair is not None:
        higher, lower = _forms(evidence.pair, blocks)
        box = _scaled_box(evidence.lower)
        nothing = not any(box[i][0] for i in {*higher[0], *lower[0]})  # 0/0 is 1
        if nothing or not _at_most_times(lower, higher, Fraction(low[1], low[0]), box):
            raise Unproven("the least quotient of the pair is less than the lower end")


def _all_hold(beta: Fraction, other: Fraction, used: int, spanned: int, confidence: Fraction) -> bool:
    """Decide whether all ends that matter are right with the probability ``confidence``, when the cells are independent."""
    pair, rest = 1 - beta - other, 1 - 2 * other
    if pair <= 0 or rest <= 0:
        return False
    if used <= 1000:
        bits = used * (_bits(pair) + _bits(rest))
        _spend(4, bits, bits + _bits(confidence))
        return pair**spanned * rest ** (used - spanned) >= confidence
    return _log_form([(Fraction(spanned), pair), (Fraction(used - spanned), rest), (Fraction(-1), confidence)]) >= 0


def _forms(place: Place, blocks: Sequence[Sequence[Affine]]) -> tuple[Affine, Affine]:
    """Find the two forms, the higher one first."""
    block, higher, lower = place
    if block >= len(blocks) or max(higher, lower) >= len(blocks[block]) or higher == lower:
        raise Unproven("the pair is not one that is compared")
    return blocks[block][higher], blocks[block][lower]


def _scaled_box(box: Box) -> list[tuple[int, int]]:
    """Multiply all ends by one number, which no quotient depends on."""
    ends, _ = _over_common_denominator([_pair(end) for ends in box for end in ends])
    return [*zip(ends[::2], ends[1::2], strict=True)]


def _at_most_times(one: Affine, other: Affine, ratio: Fraction, box: Sequence[tuple[int, int]]) -> bool:
    """Decide whether one form is at most ``ratio`` times another one everywhere in a box."""
    (w, w_unit), (v, v_unit) = one, other
    n, d = ratio.numerator * w_unit, ratio.denominator * v_unit
    units = w_unit.bit_length() + v_unit.bit_length()
    widest = max((box[i][1].bit_length() for i in w.keys() | v.keys()), default=0)
    _spend(8 * (len(w) + len(v)), _bits(ratio) + units, widest + units)
    greatest = 0
    for i in w.keys() | v.keys():
        coefficient = w.get(i, 0) * d - v.get(i, 0) * n
        greatest += coefficient * box[i][coefficient > 0]
    return greatest <= 0


def _check_block(block: Sequence[Affine], number: int, ratio: Fraction, box: Sequence[tuple[int, int]]) -> None:
    """Make sure that no form of a block can be more than ``ratio`` times another one."""
    ends = [(sum(c * box[i][side] for i, c in form.items()), unit) for side in (0, 1) for form, unit in block]
    values, unit = _over_common_denominator(ends)
    _spend(4 * len(values) + len(block) ** 2, max(map(int.bit_length, values)) + unit.bit_length(), 256 + _bits(ratio))
    least = [ratio.numerator * value for value in values[: len(block)]]
    greatest = [ratio.denominator * value for value in values[len(block) :]]
    for (i, top), (j, bottom) in product(enumerate(greatest), enumerate(least)):
        # Most pairs are far from it, even if the cells that two forms share were different ones.
        if top > bottom and i != j and not _at_most_times(block[i], block[j], ratio, box):
            raise Unproven(f"forms {i} and {j} of block {number} can have a greater quotient than the upper end")


def _fault_of_ends(sample: Sample, lo: Fraction, hi: Fraction, level: Fraction, method: str) -> str:
    if not sample.low <= lo <= hi <= sample.high:
        return "are not ends in the range of the cell"
    if not sample.informative:
        return "" if (lo, hi) == (sample.low, sample.high) else "are not the range of the cell, of which nothing else is known"
    if lo > sample.low and not _excluded(sample, lo, level, method, above=False):
        return f"has the lower end {shown(_pair(lo))}, which is not excluded from below at the level {shown(_pair(level))}"
    if hi < sample.high and not _excluded(sample, hi, level, method, above=True):
        return f"has the upper end {shown(_pair(hi))}, which is not excluded from above at the level {shown(_pair(level))}"
    return ""


def _excluded(sample: Sample, mean: Fraction, level: Fraction, method: str, above: bool) -> bool:
    """Decide whether a test at this level rejects a mean as too great, or as too small."""
    if sample.binary or method == "hoeffding-kl":
        return _tails_at_most([sample.tail(mean, above)], level)
    if method == "intersection":
        level /= 2
        return _tails_at_most([sample.tail(mean, above)], level) or _bernstein(sample, mean, level, above)
    return _bernstein(sample, mean, level, above)


def _bernstein(sample: Sample, mean: Fraction, level: Fraction, above: bool) -> bool:
    """Decide |mean - z| >= sqrt(2 V log(2/level) / n) + 7 log(2/level) / (3 (n - 1)), z being the mean of the sample and V its variance."""
    n, width = sample.draws, sample.high - sample.low
    if n < 2 or level == 0:
        return False
    logarithm = Fraction(-_log_form([(Fraction(1), level / 2)]), 1 << PRECISION)
    variance = (sample.squares - sample.total**2 / n) / (n - 1) / width**2
    distance = (mean - sample.total / n if above else sample.total / n - mean) / width - 7 * logarithm / (3 * (n - 1))
    return distance >= 0 and distance**2 >= 2 * variance * logarithm / n


# A bound of the probability that the sum of n draws from [0, 1] with mean p is at most k: n, k, p, and whether all draws
# are 0 or 1.
Tail = tuple[int, Fraction, Fraction, bool]


def _log_form(terms: Sequence[tuple[Fraction, Fraction]]) -> int:
    """Bound 2^PRECISION (the sum of c log x) from below, for terms (c, x), x > 0."""
    for c, x in terms:
        _spend(100, _bits(c), _bits(x))
    bits = PRECISION + max(int(abs(c)).bit_length() for c, _ in terms)
    total = 0
    for c, x in terms:
        n, d = x.numerator, x.denominator
        if n < d:
            n, d, c = d, n, -c
        if n > d:
            low, high = _log_bounds(n, d, bits)
            total += c.numerator * (low if c > 0 else high) // c.denominator
    return total >> (bits - PRECISION)


def _is_summed(tail: Tail) -> bool:
    """Whether the bound is the binomial sum; for k = 0 that is the other bound too, and can be compared exactly."""
    n, k, _, binary = tail
    return n <= SUMMED and (binary or k == 0)


@lru_cache(maxsize=1 << 16)
def _rarity(tail: Tail) -> int | None:
    """Bound -2^PRECISION log B from below, where B is the bound of a tail; None if B is 0."""
    n, k, p, binary = tail
    _keep(20, _bits(k) + _bits(p))
    if p <= 0 or k == n:
        return 0
    if p >= 1:
        return None
    _spend(250, _bits(k) + _bits(p), _bits(k) + _bits(p))
    if _is_summed(tail):
        terms = [(k, 1 / p), (n - k, 1 / (1 - p)), (Fraction(1), Fraction(1 << PRECISION, comb(n, int(k)) * _relative_sum(n, int(k), p)))]
        return max(0, _log_form(terms))
    if k >= n * p:
        return 0
    terms = [(n - k, (n - k) / (n * (1 - p)))]
    if k:
        terms.append((k, k / (n * p)))
        rho = k * (1 - p) / ((n - k + 1) * p)
        square = Fraction(53 * n, 333) / (k * (n - k) * (1 - rho) ** 2)
        if binary and square < 1:
            terms.append((Fraction(-1, 2), square))
    return max(0, _log_form(terms))


def _relative_sum(n: int, k: int, p: Fraction) -> int:
    """Add up the terms of a binomial tail, the one for k first, as multiples of 2^-PRECISION of that one, rounded up."""
    a, b = p.numerator, p.denominator - p.numerator
    total = term = 1 << PRECISION
    for i in range(k, 0, -1):
        if i % 64 == 0 or i == k:
            _spend(8 * min(i, 64), _bits(p))
        term = -(-term * i * b // ((n - i + 1) * a))
        total += term
        if term == 1:  # the quotients of successive terms fall: no term from here on is greater
            return total + i - 1
    return total


def _binomial(tail: Tail) -> Fraction:
    """The binomial sum itself."""
    n, k, p, _ = tail
    if p <= 0:
        return Fraction(1)
    a, b = p.numerator, p.denominator - p.numerator
    total, term = 0, 1
    bits = _bits(p)
    _spend(4 * int(k) + 4, n * bits, bits)
    _spend(2, n * bits, n * bits)
    for i in range(int(k) + 1):
        total = total * b + term
        term = term * (n - i) * a // (i + 1)
    return Fraction(total * b ** (n - int(k)), p.denominator**n)


def _tails_at_most(tails: Sequence[Tail], level: Fraction) -> bool:
    """Decide whether the product of the bounds of some tails is at most a level less than 1."""
    rarities = [_rarity(tail) for tail in tails]
    known = [rarity for rarity in rarities if rarity is not None]
    if len(known) < len(rarities) or level == 0:
        return len(known) < len(rarities)
    excess = sum(known) + _log_of_level(level)
    if excess >= 0:
        return True
    # Equality cannot be seen by logarithms.
    return excess >> (PRECISION - 64) == -1 and all(map(_is_summed, tails)) and prod(map(_binomial, tails)) <= level


@lru_cache(maxsize=64)
def _log_of_level(level: Fraction) -> int:
    return _log_form([(Fraction(1), level)])


def _prove_by_ladders(interval: Interval, evidence: LadderEvidence, comparison: Comparison, used: int) -> None:
    samples, blocks = comparison.samples, comparison.blocks
    if not interval.independent:
        raise Unproven("a product is for independent cells only")
    if any(len(form) != 1 or [*form.values()] != [unit] for block in blocks for form, unit in block):
        raise Unproven("a product is for forms of a single cell only")
    if interval.method != "hoeffding-kl" and not all(sample.binary for sample in samples if sample.informative):
        raise Unproven("a product is for binary cells or hoeffding-kl only")
    (b, c), (other_b, other_c) = evidence.levels
    if not (b * b <= c <= b < 1 and other_b * other_b <= other_c <= other_b <= b and other_c <= c):
        raise Unproven("the levels b, c must keep b^2 <= c <= b < 1, and those for the lower end must be no greater")
    pairs = sum(len(block) * (len(block) - 1) for block in blocks)
    spent = 2 * b + max(2, 2 * used - 2) * other_b + _area(b, c) + (pairs - 1) * _area(other_b, other_c)
    if spent > 1 - Fraction(*interval.confidence):
        raise Unproven("the levels add up to more than the confidence leaves")
    members = [[next(iter(form)) for form, _ in block] for block in blocks]
    low, high = interval.ratio
    if (high == INFINITY) is not (evidence.upper is None) or (low == ONE) is not (evidence.lower is None):
        raise Unproven("there must be ladders exactly for a finite upper end, and for a lower end of more than 1")
    if evidence.upper is not None:
        if len(evidence.upper) != len(blocks):
            raise Unproven(f"there must be {len(blocks)} ladders, not {len(evidence.upper)}")
        for number, (block, ladder) in enumerate(zip(members, evidence.upper, strict=True)):
            cells = {i: samples[i] for i in block}
            _check_ladder(ladder, cells, cells, Fraction(*high), b, c, f"upper[{number}]")
    if evidence.lower is not None:
        place, ladder = evidence.lower
        _forms(place, blocks)
        higher, lower = members[place[0]][place[1]], members[place[0]][place[2]]
        if higher == lower:
            raise Unproven("the forms of the pair are equal")
        one, another = {lower: samples[lower]}, {higher: samples[higher]}
        _check_ladder(ladder, one, another, Fraction(low[1], low[0]), other_b, other_c, "lower")


def _area(b: Fraction, c: Fraction) -> Fraction:
    """Bound the probability that independent uniform u and v exceed b while uv is at most c: c log(c/b^2) - c + b^2."""
    if b == 0:
        return Fraction(0)
    return c * Fraction(-_log_form([(Fraction(1), b * b / c)]), 1 << PRECISION) - c + b * b


def _check_ladder(
    knots: Ladder, tops: Mapping[int, Sample], bottoms: Mapping[int, Sample], ratio: Fraction, b: Fraction, c: Fraction, where: str
) -> None:
    """Make sure that a ladder proves of all different tops and bottoms that the mean of the top is at most ``ratio`` times the other."""
    if not knots or knots[0] <= 0 or any(q <= p for p, q in pairwise(knots)):
        raise Unproven(f"{where} is not a strictly rising list of positive knots")
    for sample in bottoms.values():
        if knots[0] > sample.low and not (sample.informative and _tails_at_most([sample.tail(knots[0], False)], b)):
            raise Unproven(f"{where} begins too high")
    for sample in tops.values():
        mean = ratio * knots[-1]
        if mean < sample.high and not (sample.informative and _tails_at_most([sample.tail(mean, True)], b)):
            raise Unproven(f"{where} ends too low")
    certain: Tail = (1, Fraction(1), Fraction(1, 2), True)
    for number, (p, q) in enumerate(pairwise(knots)):
        _spend(250 * (len(tops) + len(bottoms)), _bits(ratio), _bits(p))
        above = {i: s.tail(ratio * p, True) if s.informative else certain for i, s in tops.items() if ratio * p < s.high}
        below = {i: s.tail(q, False) if s.informative else certain for i, s in bottoms.items()}
        # For each top the likeliest bottom of another index is one of the two likeliest of all.
        likeliest = sorted((rarity, i) for i, tail in below.items() if (rarity := _rarity(tail)) is not None)[:2]
        for i, tail in above.items():
            bottom = next((j for _, j in likeliest if j != i), None)
            if bottom is not None and not _tails_at_most([tail, below[bottom]], c):
                raise Unproven(f"{where} has too wide a step after knot {number}")


# Intervals for a stream, at every moment

BETS = range(-16, 5)  # the shares that are bet are 2 to these powers, but at most CAP / mean
IDLE = Fraction(1, 32)  # of the money is never bet
CAP = Fraction(15, 16)
MANTISSA = 160  # bits of a wealth and of what it is computed from

Tally = dict[Fraction, int]  # how often each utility was drawn, scaled to [0, 1]
Wealth = tuple[int, int]  # m, e: a number of at least m 2^e
Levels = list[dict[int, Fraction]]  # by block, and by the rank of the later cell of a pair


def _share(bet: int) -> Fraction:
    """The part of the money that goes into a bet."""
    return Fraction(29, 20) / ((abs(bet + 2) + 2) * (abs(bet + 2) + 3))


def _trimmed(mantissa: int, exponent: int) -> Wealth:
    excess = max(0, mantissa.bit_length() - MANTISSA)
    return mantissa >> excess, exponent + excess


def _floored(value: Fraction) -> Wealth:
    n, d = value.numerator, value.denominator
    shift = max(0, MANTISSA + d.bit_length() - n.bit_length())
    return _trimmed((n << shift) // d, -shift)


def _power(base: Wealth, exponent: int) -> Wealth:
    """Raise to a power, every step rounded down."""
    result: Wealth = (1, 0)
    for digit in bin(exponent)[2:]:
        result = _trimmed(result[0] ** 2, 2 * result[1])
        if digit == "1":
            result = _trimmed(result[0] * base[0], result[1] + base[1])
    return result


def _wealth(tally: Tally, mean: Fraction) -> Wealth:
    """Bound from below what bets that the mean is greater than this one have won: mean > 0."""
    found = [_floored(IDLE)]
    bits = _bits(mean) + max(map(_bits, tally), default=0)
    _spend(len(BETS) * (60 + sum(60 + 8 * n.bit_length() for n in tally.values())), bits, bits)
    a, b = mean.numerator, mean.denominator
    for power in BETS:
        bet = min(Fraction(2) ** power, CAP / mean)
        m, e = _floored(_share(power))
        for value, n in tally.items():
            below = bet.denominator * value.denominator * b
            above = below + bet.numerator * (value.numerator * b - a * value.denominator)  # 1 + bet (value - mean), over below
            excess = max(0, MANTISSA + below.bit_length() - above.bit_length())
            base, shift = _power(_trimmed((above << excess) // below, -excess), n)
            m, e = _trimmed(m * base, e + shift)
        found.append((m, e))
    least = max(m.bit_length() + e for m, e in found) - 2 * MANTISSA
    return _trimmed(sum(m << e - least if e >= least else m >> least - e for m, e in found), least)


def _reach(one: Wealth, other: Wealth, level: Fraction) -> bool:
    """Decide whether the product of two wealths is at least 1/level."""
    _spend(10, _bits(level), MANTISSA)
    m, e = one[0] * other[0] * level.numerator, one[1] + other[1]
    if (excess := m.bit_length() + e - level.denominator.bit_length()) not in (0, 1):
        return excess > 0
    return m << e >= level.denominator if e >= 0 else m >= level.denominator << -e


class _Stream:
    """What the counts of a stream prove."""

    def __init__(self, interval: Interval, evidence: StreamEvidence, table: Table) -> None:
        self.interval, self.evidence = interval, evidence
        if table.header.subject.kind != "counts":
            raise Unproven("the table is not of the stated kind")
        if interval.independent or interval.limits is None or interval.limits[0] == interval.limits[1]:
            raise Unproven("a stream has a declared range with different limits, and cells that are not declared independent")
        self.low, self.high = interval.limits
        by_group = table.by_group()
        pools = [[by_group[a] for a in groups] for groups in [_globally_compared(table)] if groups]
        if interval.quantity == "local":
            pools = [[[cell] for cell in cells] for cells in table.by_context() if len(cells) > 1]
        if not pools:
            raise Unproven("the table does not give this quantity")
        self.blocks = [[self._tally(cells, table) for cells in block] for block in pools]
        if len(evidence.order) != sum(map(len, self.blocks)):
            raise Unproven(f"the ranks of {sum(map(len, self.blocks))} cells must be listed, not of {len(evidence.order)}")
        ranks = iter(evidence.order)
        self.ranks = [[next(ranks) for _ in block] for block in self.blocks]
        self.error = 1 - Fraction(*interval.confidence)
        self.known: dict[tuple[int, int, Fraction, bool], Wealth] = {}

    def _tally(self, cells: Iterable[Cell], table: Table) -> Tally:
        tally: Tally = {}
        for cell in cells:
            (weights, total), (n, d) = cell.law, cell.mass
            if n % (d * total):
                raise Unproven(f"the counts are not integers {_place(table, cell)}")
            for weight, g in zip(weights, cell.utility, strict=True):
                if weight and g is not None:
                    value = (Fraction(*g) - self.low) / (self.high - self.low)
                    tally[value] = tally.get(value, 0) + weight * (n // (d * total))
        return tally

    def _share(self, rank: int, expected: int) -> Fraction:
        """The part of the error for the cell, or pairs, of some rank: over all ranks these add up to 1."""
        return Fraction(expected, (rank + expected - 1) * (rank + expected))

    def _wealth(self, block: int, cell: int, mean: Fraction, above: bool) -> Wealth:
        """What a cell proves of its mean: that it is above, or below, another one inside the range."""
        key = block, cell, mean, above
        if key not in self.known:
            _keep(20, _bits(mean))
            tally, scaled = self.blocks[block][cell], (mean - self.low) / (self.high - self.low)
            self.known[key] = _wealth(tally, scaled) if above else _wealth({1 - value: n for value, n in tally.items()}, 1 - scaled)
        return self.known[key]

    def prove(self) -> None:
        """Make sure that the evidence proves the interval."""
        low, high = self.interval.ratio
        if not _at_most(ONE, low) or not _at_most(ONE, high):
            raise Unproven("no ratio is less than 1")
        if self.evidence.ends is not None:
            self._prove_by_box(self.evidence.ends)
        else:
            self._prove_by_ladders()

    def _prove_by_box(self, ends: Box) -> None:
        if len(ends) != len(self.evidence.order):
            raise Unproven(f"upper must list the ends of {len(self.evidence.order)} cells, not of {len(ends)}")
        remaining = iter(ends)
        box = [[next(remaining) for _ in block] for block in self.blocks]
        for b, block in enumerate(box):
            for i, (lo, hi) in enumerate(block):
                level = self.error * self._share(self.ranks[b][i], self.evidence.expected) / 2
                if not self.low <= lo <= hi <= self.high:
                    raise Unproven(f"the ends of cell {i} of block {b} are not ends in its range")
                if lo > self.low and not _reach(self._wealth(b, i, lo, True), (1, 0), level):
                    raise Unproven(f"the lower end {shown(_pair(lo))} of cell {i} of block {b} is not excluded")
                if hi < self.high and not _reach(self._wealth(b, i, hi, False), (1, 0), level):
                    raise Unproven(f"the upper end {shown(_pair(hi))} of cell {i} of block {b} is not excluded")
        low, high = (Fraction(*end) if end != INFINITY else None for end in self.interval.ratio)
        for b, block in enumerate(box):
            _spend(20 * len(block) ** 2)
            for i, j in permutations(range(len(block)), 2):
                if high is not None and block[i][1] > high * block[j][0]:
                    raise Unproven(f"cells {i} and {j} of block {b} can have a greater quotient than the upper end")
        if (low == 1) is not (self.evidence.pair is None):
            raise Unproven("a pair has to be named exactly if the lower end is more than 1")
        if self.evidence.pair is not None and low is not None:
            b, i, j = self._named(self.evidence.pair)
            if not box[b][i][0] >= low * box[b][j][1] > 0:
                raise Unproven("the least quotient of the pair is less than the lower end")

    def _named(self, place: Place) -> Place:
        block, higher, lower = place
        if block >= len(self.blocks) or max(higher, lower) >= len(self.blocks[block]) or higher == lower:
            raise Unproven("the pair is not one that is compared")
        return place

    def _levels(self) -> Levels:
        """For each block, the level of a pair, in either direction, by the rank of the later one of its cells.

        The cells that found others in their block share out the error in the order in which they came; each divides its part
        among the two directions of its pairs with those that it found.
        """
        first = [min(ranks) for ranks in self.ranks]
        later = sorted(rank for ranks, least in zip(self.ranks, first, strict=True) for rank in ranks if rank > least)
        number = {rank: i for i, rank in enumerate(later, 1)}
        expected = (self.evidence.expected + 1) // 2
        return [
            {last: self.error * self._share(number[last], expected) / (2 * found) for found, last in enumerate(sorted(ranks)) if found}
            for ranks in self.ranks
        ]

    def _prove_by_ladders(self) -> None:
        levels = self._levels()
        low, high = self.interval.ratio
        ladders, proof = self.evidence.ladders, self.evidence.proof
        if (high == INFINITY) is not (ladders is None) or (low == ONE) is not (proof is None):
            raise Unproven("there must be ladders exactly for a finite upper end, and for a lower end of more than 1")
        if ladders is not None:
            if len(ladders) != len(self.blocks):
                raise Unproven(f"there must be {len(self.blocks)} ladders, not {len(ladders)}")
            for b, ladder in enumerate(ladders):
                _keep(4 * len(self.blocks[b]) ** 2)
                pairs = [*permutations(range(len(self.blocks[b])), 2)]
                self._check_ladder(ladder, b, pairs, Fraction(*high), levels, f"upper[{b}]")
        if proof is not None:
            b, higher, lower = self._named(proof[0])
            self._check_ladder(proof[1], b, [(lower, higher)], Fraction(low[1], low[0]), levels, "lower")

    def _check_ladder(self, knots: Ladder, b: int, pairs: Sequence[tuple[int, int]], ratio: Fraction, levels: Levels, where: str) -> None:
        """Make sure that a ladder proves of pairs (top, bottom) that the mean of the top is at most ``ratio`` times the other."""
        if not knots or knots[0] <= 0 or any(q <= p for p, q in pairwise(knots)):
            raise Unproven(f"{where} is not a strictly rising list of positive knots")
        idle = _floored(IDLE)
        steps: list[tuple[Fraction | None, Fraction | None]] = [*pairwise(knots)]
        if knots[0] > self.low:
            steps.append((None, knots[0]))
        if knots[-1] < self.high:
            steps.append((knots[-1], None))
        for p, q in steps:
            # The mean of the bottom is from p to q, that of the top more than ratio p.
            if p is not None and ratio * p >= self.high:
                continue
            top = None if p is None or ratio * p <= self.low else ratio * p
            bottom = None if q is None or q <= self.low else q
            tops = {i: idle if top is None else self._wealth(b, i, top, False) for i in {i for i, _ in pairs}}
            bottoms = {j: idle if bottom is None else self._wealth(b, j, bottom, True) for j in {j for _, j in pairs}}
            for i, j in pairs:
                if not _reach(tops[i], bottoms[j], levels[b][max(self.ranks[b][i], self.ranks[b][j])]):
                    raise Unproven(f"{where} does not hold between the knots {shown(p and _pair(p))} and {shown(q and _pair(q))}")


def _is_about_population(key: tuple[str, str, str, str]) -> bool:
    quantity, relation, by, scope = key
    of_ratio = quantity in ("local_ratio", "global_ratio") and by in ("binomial", *METHODS, BETTING)
    known = (of_ratio or (quantity in DIFFERENCES and by == "binomial")) and relation in ("<=", ">=")
    return known and scope.startswith(POPULATION)


def _fault_about_population(claim: Claim, proven: Mapping[str, Proven]) -> str:
    """Judge a claim that repeats an end of an interval, or has a weaker one."""
    quantity, relation, by, scope = claim.key
    interval = proven.get(quantity.removesuffix("_ratio"))
    if interval is None:
        return "there is no interval that holds"
    if claim.evidence != quantity.removesuffix("_ratio"):
        return "the evidence is the interval of the other ratio"
    if scope != interval.scope:
        return f"the interval is for {shown(interval.scope)}"
    if by != interval.by:
        return f"the method is {shown(interval.by)}"
    low, high = interval.ratio
    least = ZERO if quantity in DIFFERENCES else ONE
    true = _at_most(high, claim.value) if relation == "<=" else _at_most(least, claim.value) and _at_most(claim.value, low)
    return "" if true else f"the interval is from {shown(low)} to {shown(high)}"


def _ends_of_population(quantity: str, facts: Facts, true_claims: Iterable[Claim]) -> tuple[Rational, Rational]:
    """Find the ends of a ratio of the population: those of the interval, and bounds that hold whatever was sampled."""
    low, high = facts.proven[quantity].ratio if quantity in facts.proven else (ONE, INFINITY)
    declared = facts.declared.keys()
    for claim in true_claims:
        _, _, by, scope = claim.key
        needed = {POLICIES: {"gamma", "m"} if by == "T4" else set(), FLOORED: {"gamma"}}.get(scope)
        holds = needed is not None and needed <= declared
        if holds and claim.key[0] == f"{quantity}_ratio" and _at_most(claim.value, high):
            high = claim.value
    return low, high


# ---------------------------------------------------------------------------------------------------------------------
# Assumptions: the sentences that a claim has to list, word by word

FRESH = (
    "the filter's draws for group and context are independent of each other and of everything else, fresh for each decision, and the "
    "decision depends on group and context only through what the filters release"
)
DECLARED_FLOOR = "every compared group's expected utility is at least {} behind the filter (declared)"
DRAWS = (
    "the draws within a cell are independent, each with the law of the cell, and how many there are does not depend on how they came out"
)
UNITS = (
    "different sampling units are independent, how many there are does not depend on how they came out, and the mean over the rows of a "
    "unit in a cell has the same expectation for all units: it is estimated by the mean over units, which is not the mean over rows"
)
ONE_ROW = "a sampling unit can have no more than one row in a cell, as is the case here"
POOLED = "the contexts of each group were drawn from its population, not set by design"
GIVEN_LABELS = (
    "given the true labels, the decisions are independent, each positive with the rate of its cell, and how many there are of a true label "
    "does not depend on how they came out"
)
CHOSEN_LABELS = "positive labels, method and confidence were chosen without looking at the draws"
RANGE = "whatever could have been drawn has a utility between {} and {}"
OWN_RANGE = "whatever could have been drawn in a cell has a utility between 0 and the greatest that a decision has there"
CHOSEN = "utility, method and confidence were chosen without looking at the draws"
CELLS = "the draws of different cells are independent of each other"
PAST = "given everything recorded before it, each decision has the expected utility of its context and group as its mean"
OWN_PAST = "given the earlier decisions that count in its context and group, each such decision has their expected utility as its mean"
MIX = "whatever came before, the context of a group's next decision has the same distribution, and so its expected utility stays the same"
WINDOWS = "window i of the stream has 1/(i(i + 1)) of the error that all windows share, and where windows begin was fixed beforehand"
ORDER = "which contexts and groups appear, and in what order they first do, does not depend on how decisions come out"
# About what was left out of the log: all claims of a certificate list the same ones.
DECISIONS_LEFT_OUT = (
    "{decisions} of {of} decisions have a missing label and were left out; they are taken to be no different from the others"
)
ROWS_LEFT_OUT = "{rows} of {of} rows have a missing label and were left out; they are taken to be no different from the others"
LINES_LEFT_OUT = (
    "{lines} lines of the log could not be counted and were left out ({reason}); they are taken to be no different from the others"
)
LEFT_OUT = re.compile(".*(?:were left out|could not be counted).*", re.DOTALL)


@dataclass(frozen=True)
class Sentences:
    """What a claim lists under ``assumptions``: all that are needed, perhaps some of those that are allowed, nothing else, none twice."""

    needed: tuple[str, ...]
    allowed: tuple[str, ...] = ()


def _sentences(claim: Claim, stated: Certificate, table: Table) -> Sentences:
    """Say what a true claim has to list."""
    if _is_about_population(claim.key) and claim.key[0] in DIFFERENCES:
        own = Sentences((GIVEN_LABELS, *((POOLED,) if claim.key[0].endswith(OVERALL) else ()), CHOSEN_LABELS))
    elif _is_about_population(claim.key):
        own = _assumed_by_interval(stated.intervals[claim.key[0].removesuffix("_ratio")], table)
    else:
        floor = (DECLARED_FLOOR.format(_written(stated.declared["tau"])),) if claim.key[3] == FLOORED else ()
        own = Sentences((*RULES[claim.key].assumes, *floor))
    return own if table.policy is None else replace(own, needed=(FRESH, *own.needed))


def _assumed_by_interval(interval: "Interval", table: Table) -> Sentences:
    """Say what the claims have to list that repeat an end of an interval, besides what all claims about a policy do."""
    gamma = constants(table)["gamma"]
    low, high = (ZERO, gamma if isinstance(gamma, tuple) else ZERO) if interval.limits is None else map(_pair, interval.limits)
    own_range = interval.limits is None and table.header.utility is None
    common = OWN_RANGE if own_range else RANGE.format(_written(low), _written(high)), CHOSEN
    overall = interval.quantity == "global"
    if isinstance(interval.evidence, StreamEvidence):
        past = OWN_PAST if interval.region == "box" else PAST
        return Sentences((past, *((MIX,) if overall else ()), ORDER, *common))
    cells = (CELLS,) if interval.independent else ()
    if table.policy is not None:
        return Sentences((DRAWS, *((STATED_POPULATION,) if overall else ()), *common, *cells))
    if overall:
        return Sentences((DRAWS, POOLED, *common, *cells))
    if interval.units is not None:
        return Sentences((UNITS, *common, *cells))
    return Sentences((DRAWS, *common, *cells), allowed=(ONE_ROW,))


def _check_listed(named: str, listed: Iterable[str], sentences: Sentences, counted: Sequence[str]) -> None:
    own = Counter(listed)
    for text in (*sentences.needed, *counted):
        if text not in own:
            raise Incomplete(printable(f"{named} lacks the assumption {json.dumps(text, ensure_ascii=False)}"))
    for text, times in (own - Counter({*sentences.needed, *sentences.allowed, *counted})).items():
        if own[text] > times:
            raise _malformed(named, f"lists the assumption {shown(text)} twice")
        if LEFT_OUT.fullmatch(text):
            raise Incomplete(printable(f"subject.preparation does not say what was left out, and {named} assumes {shown(text)}"))
        raise _malformed(named, f"lists {shown(text)}, which is no assumption of such a claim")


def _check_assumptions(stated: Certificate, table: Table) -> None:
    """Refuse a true certificate that keeps from the reader what it rests on, or lists what its claims do not rest on."""
    counted = [step.sentence for step in stated.preparation if step.sentence]
    for i, claim in enumerate(stated.claims):
        quantity, relation, by, scope = claim.key
        named = f"claims[{i}] ({quantity} {relation} by {by} for {shown(scope)[1:-1]})"
        _check_listed(named, claim.assumptions, _sentences(claim, stated, table), counted)
    if stated.change is not None:
        assumed = _assumed_by_interval(stated.change.stream, table)
        _check_listed("changed", stated.change.assumptions, replace(assumed, needed=(*assumed.needed, WINDOWS)), counted)
    for name in (*stated.intervals, *stated.differences):
        if not any(_is_about_population(claim.key) and claim.key[0] in (name, f"{name}_ratio") for claim in stated.claims):
            raise Incomplete(f"there is no claim about intervals.{name} that states what it assumes")
    if table.policy is not None and not stated.claims:
        raise Incomplete("there is no claim that states what the figures of a policy behind filters assume")


# ---------------------------------------------------------------------------------------------------------------------
# What was done to the log before it was counted, and labels that differ in spelling alone

STEPS = ("intervals", "mapped", "folded", "left out", "level")
LONGEST_SPELLING = 1000  # characters of labels that are compared with other spellings
REASONS = ("unreadable line", "missing label", "unusable value", "unknown reason")  # why lines of a log could not be counted


@dataclass(frozen=True)
class Step:
    """One entry of ``subject.preparation``."""

    step: str
    column: str = ""
    edges: tuple[Rational, ...] = ()
    label: str = ""
    former: Labels = ()
    reason: str = ""
    unit: str = ""  # of the amounts: decisions, rows (of a table of probabilities) or lines (of a log)
    amount: Rational = ZERO
    of: Rational = ZERO
    columns: tuple[tuple[str, Rational], ...] = ()
    sentence: str = ""  # what every claim has to assume


def _read_preparation(value: object, where: str, subject: Subject) -> tuple[Step, ...]:
    steps = tuple(_read_step(item, f"{where}[{i}]", subject.columns) for i, item in enumerate(_list(value, where)))
    if not steps:
        raise _malformed(where, "must not be empty")
    names = _names(subject.columns)
    places = [(STEPS.index(s.step), names.index(s.column) if s.column else -1, s.label, s.unit, _reason_rank(s)) for s in steps]
    if any(one >= other for one, other in pairwise(places)):
        raise _malformed(where, "is not in the order of steps, columns and labels, each once")
    return steps


def _names(columns: Columns) -> tuple[str, ...]:
    return (columns.decision, *columns.group, *columns.context, *([] if columns.truth is None else [columns.truth]))


def _reason_rank(step: Step) -> int:
    return REASONS.index(step.reason) if step.unit == "lines" else -1


def _read_step(value: object, where: str, columns: Columns) -> Step:
    name = _one_of(value.get("step"), f"{where}.step", STEPS) if isinstance(value, dict) else STEPS[0]
    possible = ("decisions", "rows", "lines") if name == "left out" else ("decisions", "rows")
    units = [unit for unit in possible if isinstance(value, dict) and unit in value]
    unit = units[0] if units else "decisions"
    if name == "left out":
        keys = ("step", "reason", "lines") if unit == "lines" else ("step", "reason", unit, "of", "columns")
        members = _object(value, where, keys)
        reason = _one_of(members["reason"], f"{where}.reason", REASONS if unit == "lines" else ("missing label",))
        amount = _read_amount(members[unit], f"{where}.{unit}", unit)
        template = {"decisions": DECISIONS_LEFT_OUT, "rows": ROWS_LEFT_OUT, "lines": LINES_LEFT_OUT}[unit]
        if unit == "lines":
            return Step(name, reason=reason, unit=unit, amount=amount, sentence=template.format(**members))
        of = _read_amount(members["of"], f"{where}.of", unit)
        listed = _object(members["columns"], f"{where}.columns", (), optional=_names(columns))
        by_column = tuple((column, _read_amount(item, f"{where}.columns[{shown(column)}]", unit)) for column, item in listed.items())
        return Step(name, reason=reason, unit=unit, amount=amount, of=of, columns=by_column, sentence=template.format(**members))
    shapes = {"intervals": ("step", "column", "edges"), "level": ("step", "column", "label", unit)}
    members = _object(value, where, shapes.get(name, ("step", "column", "label", "from")))
    column = _one_of(members["column"], f"{where}.column", _names(columns))
    if name == "intervals":
        edges = tuple(_rational(item, f"{where}.edges[{i}]") for i, item in enumerate(_list(members["edges"], f"{where}.edges")))
        if not edges or any(_at_most(other, one) for one, other in pairwise(edges)):
            raise _malformed(f"{where}.edges", "must rise")
        return Step(name, column, edges)
    label = _string(members["label"], f"{where}.label")
    if name == "level":
        if column == columns.truth:
            raise _malformed(where, "is about the true labels: where there is none, a decision is neither a true nor a false positive")
        return Step(name, column, label=label, unit=unit, amount=_read_amount(members[unit], f"{where}.{unit}", unit))
    former = _strings(members["from"], f"{where}.from")
    if not former or list(former) != sorted(set(former)) or label in former:
        raise _malformed(f"{where}.from", "must be other labels in the order of their code points, each once")
    return Step(name, column, label=label, former=former)


def _read_amount(value: object, where: str, unit: str) -> Rational:
    amount = _rational(value, where, nonnegative=True)
    if amount[0] == 0 or (unit != "decisions" and amount[1] != 1):
        raise _malformed(where, f"must be {'positive' if unit == 'decisions' else 'a positive integer'}, not {shown(amount)}")
    return amount


def _read_spellings(value: object, where: str) -> tuple[tuple[str, Labels], ...]:
    entries = [_object(item, f"{where}[{i}]", ("column", "labels")) for i, item in enumerate(_list(value, where))]
    if not entries:
        raise _malformed(where, "must not be empty")
    return tuple(
        (_string(e["column"], f"{where}[{i}].column"), _strings(e["labels"], f"{where}[{i}].labels")) for i, e in enumerate(entries)
    )


def _labels_by_column(header: Header) -> dict[str, list[str]]:
    columns = header.subject.columns
    found = {columns.decision: list(header.decisions)}
    for names, labels in ((columns.group, header.groups), (columns.context, header.contexts)):
        found |= {name: list(dict.fromkeys(label[i] for label in labels)) for i, name in enumerate(names)}
    return found if columns.truth is None else found | {columns.truth: list(header.truths or ())}


def _folded(text: str) -> str:
    """What labels have in common that differ in case, blanks or Unicode form alone: canonical caseless matching, single blanks."""
    decomposed = unicodedata.normalize("NFD", unicodedata.normalize("NFD", text).casefold())
    return " ".join(decomposed.split())


def _is_settled(text: str) -> bool:
    """Whether Unicode 3.2 assigns every code point, of which no later version changes the case or the normal forms.

    Longer texts are not looked at: many combining marks in a row take the square of their number of steps to put into order.
    """
    return len(text) <= LONGEST_SPELLING and all(unicodedata.ucd_3_2_0.category(character) != "Cn" for character in text)


_NUMBER = re.compile(r"([+-]?)(?:([0-9]+)(?:\.([0-9]*))?|\.([0-9]+))(?:e([+-]?[0-9]{1,4}))?")


def _spelling(text: str) -> tuple[str, ...]:
    """What spellings of one label have in common: the number that they say, or else what is folded."""
    folded = _folded(text)
    match = _NUMBER.fullmatch(folded)
    if match is None:
        return (folded,)
    sign, whole, decimals, only, power = match.groups()
    fraction = decimals or only or ""
    digits = ((whole or "") + fraction).lstrip("0")
    shortened = digits.rstrip("0")
    exponent = int(power or 0) - len(fraction) + len(digits) - len(shortened)
    return ("a number", "-" if sign == "-" else "", shortened, str(exponent)) if shortened else ("a number", "0")


def spellings(header: Header) -> Iterator[tuple[str, Labels]]:
    """List labels of one column that are spellings of one label."""
    for column, labels in _labels_by_column(header).items():
        alike: dict[tuple[str, ...], list[str]] = {}
        for label in labels:
            if _is_settled(label):
                alike.setdefault(_spelling(label), []).append(label)
        yield from sorted((column, tuple(sorted(several))) for several in alike.values() if len(several) > 1)


def _check_spellings(stated: Certificate, table: Table) -> Iterator[Finding]:
    header = table.header if table.policy is None else table.policy.header
    actual = tuple(spellings(header))
    if actual and not stated.spellings:
        column, labels = actual[0]
        raise Incomplete(
            printable(f'subject lacks the key "spellings": the labels {shown(labels)} of column {shown(column)} differ in spelling alone')
        )
    if stated.spellings:
        yield _compared("subject.spellings", stated.spellings, actual)


class _Prepared:
    """What a table shows of the preparation of its log, found once for all entries."""

    def __init__(self, steps: Sequence[Step], table: Table) -> None:
        self.table = table
        self.header = table.header if table.policy is None else table.policy.header
        self.sampled = table.header.subject.kind == "counts" or (table.policy is not None and table.policy.drawn > 0)
        self.present = {column: set(labels) for column, labels in _labels_by_column(self.header).items()}
        self.mapped = {(step.column, step.label) for step in steps if step.step == "mapped"}
        self.written = {(step.column, step.label) for step in steps if step.step != "intervals"}
        self.amounts: dict[str, Mapping[str, Rational] | None] = {}

    def amount(self, step: Step) -> Rational | None:
        """How many decisions have a label in a column; nothing where decisions are not counted by true cells."""
        if step.column not in self.amounts:
            self.amounts[step.column] = _amounts_of_labels(step.column, self.table)
        amounts = self.amounts[step.column]
        return None if amounts is None else amounts.get(step.label, ZERO)


def _check_preparation(stated: Certificate, table: Table) -> Iterator[Finding]:
    prepared = _Prepared(stated.preparation, table)
    for i, step in enumerate(stated.preparation):
        fault = _fault_of_step(step, prepared)
        what = step.sentence.partition(";")[0] or f"{step.step} {shown(step.column)} {shown(step.label or step.edges)}"
        yield _finding(f"subject.preparation[{i}]: {what}", not fault, fault)


def _fault_of_step(step: Step, prepared: _Prepared) -> str:
    """Say what in the table contradicts an entry; what the log was like before nobody can see from it."""
    if step.unit in ("decisions", "rows") and (step.unit == "decisions") != prepared.sampled:
        return f"the table is {'counted' if prepared.sampled else 'not counted'}"
    if step.step == "left out":
        return "" if step.unit == "lines" else _fault_of_left_out(step, prepared.table)
    if step.column not in prepared.present:
        return "the table has no such column"
    labels = prepared.present[step.column]
    if step.step == "intervals":
        allowed = _interval_labels(step.edges)
        other = next((x for x in sorted(labels) if x not in allowed and (step.column, x) not in prepared.written), None)
        return "" if other is None else f"the label {shown(other)} is none of these intervals"
    if step.label not in labels:
        return f"the table has no label {shown(step.label)} in this column"
    if step.step == "level":
        amount = prepared.amount(step)
        return "" if amount in (None, step.amount) else f"the table gives {shown(amount)}"
    for former in step.former:
        if former in labels and not (step.step == "mapped" and (step.column, former) in prepared.mapped):
            return f"the table still has the label {shown(former)}"
        settled = step.step == "folded" and _is_settled(former) and _is_settled(step.label)
        if settled and _folded(former) != _folded(step.label):
            return f"{shown(former)} differs in more than case, blanks or Unicode form"
    return ""


def _fault_of_left_out(step: Step, table: Table) -> str:
    amounts = [amount for _, amount in step.columns]
    if not amounts or not all(_at_most(amount, step.amount) for amount in amounts) or not _at_most(step.amount, _sum(amounts)):
        return "the amounts of the columns do not make up the whole"
    kept = _sum([step.of, (-step.amount[0], step.amount[1])])
    if step.unit == "rows":
        most = table.rows * len(table.header.decisions)
        return "" if 0 < kept[0] <= most else f"the table has at most {most} rows"
    total = _sum(table.figures.masses()) if table.policy is None else (table.policy.drawn, 1)
    return "" if kept == total else f"the table gives {shown(total)} decisions that are left"


def _interval_labels(edges: Sequence[Rational]) -> set[str]:
    """Labels of the intervals between edges, which hold their lower edge."""
    texts = [_finite_decimal(edge) for edge in edges]
    between = {f"{low} to under {high}" for low, high in pairwise(texts)}
    return {f"under {texts[0]}", *between, f"{texts[-1]} and over"}


def _finite_decimal(value: Rational) -> str:
    """Write a rational with finitely many decimals (at most 30) as these; others are in no label."""
    numerator, denominator = value
    places = next((n for n in range(31) if 10**n % denominator == 0), None)
    if places is None:
        return ""
    digits = _shown_rational(abs(numerator) * 10**places // denominator, 1).rjust(places + 1, "0")
    text = f"{digits[:-places]}.{digits[-places:]}" if places else digits
    return f"-{text}" if numerator < 0 else text


def _amounts_of_labels(column: str, table: Table) -> Mapping[str, Rational] | None:
    """Count the decisions with each label in a column; nothing where decisions are not counted by true cells."""
    header = table.header
    columns = header.subject.columns
    if header.subject.kind != "counts":
        return None
    of_group = column in columns.group
    position = 0 if column == columns.decision else (columns.group if of_group else columns.context).index(column)
    amounts: dict[str, list[Rational]] = {}
    for cell in table.cells:
        if column == columns.decision:
            for label, weight in zip(header.decisions, cell.law[0], strict=True):
                amounts.setdefault(label, []).append(_product([cell.mass, (weight, cell.law[1])]))
        else:
            labels = header.groups[cell.group] if of_group else header.contexts[cell.context]
            amounts.setdefault(labels[position], []).append(cell.mass)
    return {label: _sum(found) for label, found in amounts.items()}


# ---------------------------------------------------------------------------------------------------------------------
# Reading a certificate


def _read_constants(value: object, where: str) -> dict[str, Rational | bool | None]:
    members = _object(value, where, ("gamma", "m", "tau", "lipschitz", "depends_on_group"), optional=("burden",))
    if members.get("burden", True) is not True:  # what a utility means is stated, and nothing follows from it
        raise _malformed(f"{where}.burden", f"must be true where it is stated, not {shown(members['burden'])}")
    read: dict[str, Rational | bool | None] = {}
    for key in ("gamma", "m", "tau", "lipschitz"):
        absent = key == "tau" and members[key] is None
        read[key] = None if absent else _rational(members[key], f"{where}.{key}")
    return read | {"depends_on_group": _boolean(members["depends_on_group"], f"{where}.depends_on_group")}


def _read_privacy(value: object, where: str) -> dict[str, dict[str, object] | None]:
    members = _object(value, where, ("group", "context"))
    read: dict[str, dict[str, object] | None] = {"context": None}
    for name in ("group", "context"):
        if name == "group" or members[name] is not None:
            place = f"{where}.{name}"
            figures = _object(members[name], place, ("exp_epsilon", "attributes"))
            attributes = _list(figures["attributes"], f"{place}.attributes")
            read[name] = {
                "exp_epsilon": _extended(figures["exp_epsilon"], f"{place}.exp_epsilon"),
                "attributes": [_extended(item, f"{place}.attributes[{i}]") for i, item in enumerate(attributes)],
            }
    return read


def _read_declared(value: object, where: str) -> dict[str, Rational]:
    members = _object(value, where, (), optional=("gamma", "m", "tau", "lipschitz"))
    return {key: _rational(item, f"{where}.{key}", nonnegative=True) for key, item in members.items()}


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
        elif key == "rate":
            read[key] = _one_of(item, place, KINDS)
        elif key in ("expectations", "probabilities", "rates"):
            read[key] = [_rational(number, f"{place}[{i}]") for i, number in enumerate(_list(item, place, 2))]
        else:
            names = columns.context if key == "context" else columns.group
            labels = _object(item, place, names)
            read[key] = {name: _string(labels[name], f"{place}[{shown(name)}]") for name in names}
    return read


def _read_metric(value: object, where: str, name: str, columns: Columns) -> dict[str, object] | None:
    if value is None:
        return None
    is_ratio, names = SHAPES[name]
    members = _object(value, where, ("ratio", "log", "witness") if is_ratio else ("value", "witness"))
    read: dict[str, object] = {}
    if is_ratio:
        read["ratio"] = _extended(members["ratio"], f"{where}.ratio")
        read["log"] = _read_log(members["log"], f"{where}.log")
    else:
        read["value"] = _rational(members["value"], f"{where}.value")
    return read | {"witness": _read_witness(members["witness"], f"{where}.witness", names, columns)}


def _read_rates(value: object, where: str, columns: Columns) -> list[dict[str, object]] | None:
    if value is None:
        return None
    keys = ("group",) if where.endswith(OVERALL) else ("context", "group")
    read: list[dict[str, object]] = []
    for i, item in enumerate(_list(value, where)):
        place = f"{where}[{i}]"
        members = _object(item, place, (*keys, "rate"))
        named = _read_witness({key: members[key] for key in keys}, place, keys, columns)
        read.append(named | {"rate": _rational(members["rate"], f"{place}.rate")})
    return read


def _read_unfiltered(value: object, where: str, columns: Columns) -> dict[str, dict[str, object] | None] | None:
    if value is None:
        return None
    members = _object(value, where, ("local", "global"))
    return {name: _read_metric(members[name], f"{where}.{name}", name, columns) for name in ("local", "global")}


def _read_not_compared(value: object, where: str, columns: Columns) -> dict[str, object]:
    shapes = [("context", "groups", "reason"), ("context", "reason"), ("groups", "reason"), ("quantity", "reason")]
    if columns.truth is not None:
        shapes += [("quantity", *shape) for shape in shapes[:3]]
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


def _read_claim(value: object, where: str, parameters: int | None) -> Claim:
    keys = ("quantity", "relation", "value", "scope", "by", "assumptions", "evidence")
    members = _object(value, where, keys)
    quantity, relation, by, scope = (_string(members[key], f"{where}.{key}") for key in ("quantity", "relation", "by", "scope"))
    key = quantity, relation, by, scope
    return Claim(
        key,
        _extended(members["value"], f"{where}.value"),
        _strings(members["assumptions"], f"{where}.assumptions"),
        _read_evidence(members["evidence"], f"{where}.evidence", key, parameters),
    )


def _read_evidence(value: object, where: str, key: tuple[str, str, str, str], parameters: int | None) -> object:
    if _is_about_population(key):
        return _one_of(_object(value, where, ("interval",))["interval"], f"{where}.interval", ("local", "global", *DIFFERENCES))
    rule = RULES.get(key)
    if rule is None:  # an unknown claim is found false, whatever is offered as evidence
        return _object(value, where, (), optional=tuple(value) if isinstance(value, dict) else ())
    if rule.evidence == "pairs":
        return _read_dual(value, where, key[0] == "local_ratio", parameters)
    members = _object(value, where, (rule.evidence,) if rule.evidence else ())
    if not rule.evidence:
        return None
    item, place = members[rule.evidence], f"{where}.{rule.evidence}"
    if rule.evidence == "table":
        return _digest(item, place)
    if rule.evidence != "multipliers":
        return _extended(item, place)
    multipliers = _rationals(item, place, len(_list(item, place)))
    if not multipliers and key[3] != UTILITIES:
        raise _malformed(place, "must not be empty")
    return [Fraction(*k) for k in multipliers]


def _read_target(value: object, where: str) -> Target:
    members = _object(value, where, ("quantity", "limit", "unit", "judged", "verdict"), optional=("estimand",))
    judged = _string(members["judged"], f"{where}.judged")
    of_population = judged.startswith(POPULATION)
    target = Target(
        _one_of(members["quantity"], f"{where}.quantity", ("local", "global")),
        _rational(members["limit"], f"{where}.limit", nonnegative=True),
        _one_of(members["unit"], f"{where}.unit", ("log", "ratio")),
        judged,
        _read_confidence(judged.removeprefix(POPULATION), f"{where}.judged") if of_population else None,
        _one_of(members["verdict"], f"{where}.verdict", ("within", "exceeds", "inconclusive", "changed")),
        "estimand" in members and bool(_one_of(members["estimand"], f"{where}.estimand", (OVER_UNITS,))),
    )
    if target.unit == "ratio" and not _at_most(ONE, target.limit):
        raise _malformed(f"{where}.limit", "must be at least 1, being the limit of a ratio")
    return target


def _check_estimands(targets: Iterable[Target], intervals: "Mapping[str, Interval]") -> None:
    """Make sure that those targets say that the mean over units is judged which are judged by an interval with units."""
    for i, target in enumerate(targets):
        interval = intervals.get(target.quantity)
        of_units = target.confidence is not None and interval is not None and interval.units is not None
        if of_units and not target.of_units:
            raise _malformed(f"targets[{i}]", f"lacks the key 'estimand', being judged by an interval for the {OVER_UNITS}")
        if target.of_units and not of_units:
            raise _malformed(f"targets[{i}]", "has the key 'estimand', but is not judged by an interval with units")


def _read_certificate(raw: bytes) -> Certificate:
    keys = ("format", "subject", "metrics", "not_compared", "claims", "targets", "verdict", "versions")
    top = _object(_decoded(raw, "the certificate"), "the certificate", keys, optional=("intervals", "changed"))
    _one_of(top["format"], "format", (CERTIFICATE_FORMAT,))
    of_policy = _is_about_policy(top["subject"])
    keys_of_subject = ["kind", "columns", "population", "table", "utility"] + ["privacy", "declared"] * of_policy
    keys_of_subject += ["positive"] * _has_truth(top["subject"])
    also = ("preparation", "spellings") if of_policy else ("class", "preparation", "spellings")
    about = _object(top["subject"], "subject", keys_of_subject, optional=also)
    utilities = _read_class(about["class"], "subject.class") if "class" in about else None
    parameters = None if utilities is None or utilities.family is None else len(utilities.family.lower)
    subject = _read_subject(about, "subject")
    if "intervals" in top and (subject.kind == "probabilities" or utilities is not None):
        raise _malformed("the certificate", "has intervals, which are for counts and policies without a class of utilities")
    table = _object(about["table"], "subject.table", ("sha256", "cells"), optional=("header", "rows"))
    embedded: tuple[object, ...] | None = None
    if "header" in table or "rows" in table:
        table = _object(table, "subject.table", ("sha256", "cells", "header", "rows"))
        embedded = (table["header"], *_list(table["rows"], "subject.table.rows"))
    rates, differences = _stated_given_truth(subject.columns)
    metrics = _object(top["metrics"], "metrics", [*METRICS, *rates, *differences] + ["unfiltered"] * of_policy)
    intervals: dict[str, Interval] = {}
    of_differences: dict[str, DifferenceInterval] = {}
    if "intervals" in top:
        intervals, of_differences = _read_intervals(top["intervals"], "intervals", subject, differences)
    change = _read_change(top["changed"], "changed", subject) if "changed" in top else None
    _object_of_strings(top["versions"], "versions")
    targets = tuple(_read_target(item, f"targets[{i}]") for i, item in enumerate(_list(top["targets"], "targets")))
    _check_estimands(targets, intervals)
    read = Certificate(
        subject,
        _digest(table["sha256"], "subject.table.sha256"),
        _integer(table["cells"], "subject.table.cells"),
        embedded,
        _read_constants(about["utility"], "subject.utility"),
        utilities,
        _read_privacy(about["privacy"], "subject.privacy") if of_policy else None,
        _read_declared(about["declared"], "subject.declared") if of_policy else {},
        {name: _read_metric(metrics[name], f"metrics.{name}", name, subject.columns) for name in [*METRICS, *differences]},
        _read_unfiltered(metrics["unfiltered"], "metrics.unfiltered", subject.columns) if of_policy else None,
        [
            _read_not_compared(item, f"not_compared[{i}]", subject.columns)
            for i, item in enumerate(_list(top["not_compared"], "not_compared"))
        ],
        tuple(_read_claim(item, f"claims[{i}]", parameters) for i, item in enumerate(_list(top["claims"], "claims"))),
        targets,
        _one_of(top["verdict"], "verdict", ("none", "within", "exceeds", "inconclusive", "changed")),
        intervals,
        _read_positive(about["positive"], "subject.positive") if "positive" in about else None,
        {name: _read_rates(metrics[name], f"metrics.{name}", subject.columns) for name in rates},
        of_differences,
        _read_preparation(about["preparation"], "subject.preparation", subject) if "preparation" in about else (),
        _read_spellings(about["spellings"], "subject.spellings") if "spellings" in about else (),
        change,
    )
    if read.withdrawn & intervals.keys():
        raise _malformed("intervals", "has an interval of a ratio that changed, which must not be there")
    return read


# ---------------------------------------------------------------------------------------------------------------------
# The findings


def _check_subject(stated: Certificate, table: Table) -> Iterator[Finding]:
    yield _compared("subject.table.sha256", stated.digest, table.digest)
    yield _compared("subject.table.cells", stated.cells, table.rows * len(table.header.decisions))
    ours, theirs = stated.subject, table.header.subject
    yield _compared("subject.kind", ours.kind, theirs.kind)
    yield _compared("subject.population", ours.population, theirs.population)
    for name in ("decision", "group", "context", *(["truth"] if stated.positive or table.header.truths else [])):
        yield _compared(f"subject.columns.{name}", getattr(ours.columns, name), getattr(theirs.columns, name))
    actual = constants(table)
    for key, value in stated.constants.items():
        yield _compared(f"subject.utility.{key}", value, actual[key])
    for name, figures in (stated.privacy or {}).items():
        used = None if table.policy is None else table.policy.group if name == "group" else table.policy.context
        if figures is None or used is None:
            yield _compared(f"subject.privacy.{name}", figures, "a filter" if used else None)
        else:
            yield _compared(f"subject.privacy.{name}.exp_epsilon", figures["exp_epsilon"], used.exp_epsilon)
            attributes = [factor.exp_epsilon for factor in used.factors]
            yield _compared(f"subject.privacy.{name}.attributes", figures["attributes"], attributes)
    for key, value in stated.declared.items():
        own = actual[key]
        pair = (own, value) if key in ("gamma", "lipschitz") else (value, own)
        true = isinstance(own, tuple) and _at_most(*pair)
        yield _finding(f"subject.declared.{key} is {shown(value)}", true, "" if true else f"the table gives {shown(own)}")


def _check_metrics(stated: Mapping[str, dict[str, object] | None], metrics: Mapping[str, Maximum | None], where: str) -> Iterator[Finding]:
    for name, figures in stated.items():
        actual = metrics.get(name)
        if figures is None or actual is None:
            yield _compared(f"{where}.{name}", figures, None if actual is None else actual.value)
            continue
        expected: dict[str, object] = {"value": actual.value, "witness": actual.witness}
        if SHAPES[name][0]:
            expected |= {"ratio": actual.value, "log": log_enclosure(actual.value)}
        for key, figure in figures.items():
            yield _compared(f"{where}.{name}.{key}", figure, expected[key])


def _check_unfiltered(stated: Certificate, policy: Policy) -> Iterator[Finding]:
    if stated.unfiltered is None or policy.unfiltered is None:
        yield _compared("metrics.unfiltered", stated.unfiltered, "comparable" if policy.unfiltered else None)
    else:
        yield from _check_metrics(stated.unfiltered, measure(policy.unfiltered), "metrics.unfiltered")


def _check_not_compared(stated: Certificate, table: Table) -> Finding:
    # One entry at a time: a short table can leave out more pairs of contexts and groups than fit into memory.
    for i, (entry, actual) in enumerate(zip_longest(stated.not_compared, not_compared(table))):
        if entry != actual:
            detail = "the table gives no further entry" if actual is None else f"the table gives {shown(actual)}"
            return _finding(f"not_compared[{i}] is {'not there' if entry is None else shown(entry)}", False, detail)
    return _finding(f"not_compared is {shown(stated.not_compared)}", True)


def _check_class(stated: Certificate, program: "Program", metrics: Mapping[str, Maximum | None]) -> Finding:
    utilities = program.utilities
    key = (f"{utilities.quantity}_ratio", "<=", "lp-dual", UTILITIES)
    evidence = next((claim.evidence for claim in stated.claims if claim.key == key), None)
    fault = _outside(program, metrics[utilities.quantity], evidence.theta if isinstance(evidence, Dual) else None)
    return _finding(f"the utility is in subject.class: {utilities.described()}", not fault, fault)


def _check_intervals(stated: Certificate, table: Table) -> tuple[list[Finding], dict[str, "Proven"]]:
    findings: list[Finding] = []
    proven: dict[str, Proven] = {}
    for name, interval in stated.intervals.items():
        fault = ""
        _working_on(f"intervals.{name}")
        try:
            local = stated.intervals.get("local")
            units = [] if local is None or name == "local" else local.units or []
            if any(sum(rows) > 1 for cell in units for _, rows in cell) or (units and interval.independent):
                raise Unproven("the units of the local interval are no independent draws of the groups")
            proven[name] = _proven(interval, table)
        except Unproven as error:
            fault = str(error)
        ends = " and ".join(map(shown, interval.ratio))
        how = "independent" if interval.independent else "dependent"
        statement = f"intervals.{name}: between {ends} at confidence {shown(interval.confidence)}, by a {interval.region} of {how} cells"
        findings.append(_finding(statement, not fault, fault))
    return findings, proven


def _check_rates(stated: Certificate, table: Table) -> Iterator[Finding]:
    """Compare the rates, which stand in a certificate exactly if its table does."""
    actual = table.given.rates() if table.given is not None and stated.embedded is not None else {}
    for name, rates in stated.rates.items():
        yield _compared(f"metrics.{name}", rates, actual.get(name))


def _check_differences(stated: Certificate, table: Table) -> tuple[list[Finding], dict[str, "Proven"]]:
    findings: list[Finding] = []
    proven: dict[str, Proven] = {}
    for name, interval in stated.differences.items():
        fault = ""
        try:
            if any(other.units is not None for other in stated.intervals.values()):
                raise Unproven("the rows of one sampling unit are no independent draws given their true labels")
            lists = [] if table.given is None else [table.given.blocks(rate) for rate in DIFFERENCES[name]]
            if not lists or not all(lists):
                raise Unproven("the table does not give this quantity")
            _prove_difference(interval, [*chain.from_iterable(lists)])
            proven[name] = Proven(interval.difference, 1 - interval.confidence, interval.scope, "binomial")
        except Unproven as error:
            fault = str(error)
        ends = " and ".join(map(shown, interval.difference))
        statement = f"intervals.{name}: between {ends} at confidence {shown(_pair(interval.confidence))}"
        findings.append(_finding(statement, not fault, fault))
    return findings, proven


def _faults_of_claims(claims: Sequence[Claim], facts: Facts) -> list[str]:
    """Say of each claim what is wrong with it; nothing if it is true."""
    faults: list[str] = []
    seen: set[tuple[str, str, str, str]] = set()
    for i, claim in enumerate(claims):
        _working_on(f"claims[{i}]")
        faults.append("a claim that occurs twice" if claim.key in seen else _fault(claim, facts))
        seen.add(claim.key)
    return faults


def _check_claims(claims: Sequence[Claim], faults: Sequence[str]) -> Iterator[Finding]:
    for i, (claim, fault) in enumerate(zip(claims, faults, strict=True)):
        quantity, relation, by, scope = claim.key
        statement = f"claims[{i}]: {shown(quantity)} {shown(relation)[1:-1]} {shown(claim.value)} by {shown(by)}"
        statement += "" if scope == LAW else f" for {shown(scope)}"
        assumed = f"assuming, for the reader to judge, {shown(list(claim.assumptions))}" if claim.assumptions else ""
        yield _finding(statement, not fault, fault or assumed)


def _check_change(change: Change, table: Table) -> tuple[list[Finding], Proven | None]:
    """Check that the window contradicts the stream, and say what holds of the window."""
    _working_on("the window that contradicts the stream")
    names = chain(["changed.table.header"], (f"changed.table.rows[{i}]" for i in range(len(change.lines) - 1)))
    part = _read_table((name, value, None) for name, value in zip(names, change.lines, strict=True))
    findings = [
        _compared("changed.table.sha256", change.digest, part.digest),
        _compared("changed.table.cells", change.cells, part.rows * len(part.header.decisions)),
    ]
    fault, proven = "", None
    try:
        _check_part(part, table)
        stream, proven = _proven(change.stream, table), _proven(change.ratio, part)
        if change.stream.limits != change.ratio.limits or change.stream.region != change.ratio.region:
            raise Unproven("the window has another range, or another region, than the stream")
        if _at_most(stream.ratio[0], proven.ratio[1]) and _at_most(proven.ratio[0], stream.ratio[1]):
            raise Unproven("the two intervals have a ratio in common")
        if change.confidence > 1 - stream.error - change.window**2 * proven.error:
            raise Unproven("the intervals of the stream and of the windows do not hold together at this confidence")
    except Unproven as error:
        fault, proven = str(error), None
    ends = [" and ".join(map(shown, interval.ratio)) for interval in (change.ratio, change.stream)]
    statement = f"changed: the {change.quantity} ratio is between {ends[0]} in window {change.window}, between {ends[1]} in the stream"
    findings.append(_finding(statement, not fault, fault))
    return findings, proven


def _check_part(part: Table, whole: Table) -> None:
    """Make sure that a window is part of a stream: the same columns, decisions and utility, and in no cell more decisions."""
    one, other = part.header, whole.header
    if one.subject != other.subject or one.decisions != other.decisions or one.utility is None or one.utility != other.utility:
        raise Unproven("the window has other columns, decisions or utilities than the stream")
    counts = {(whole.header.contexts[cell.context], whole.header.groups[cell.group]): _counts(cell) for cell in whole.cells}
    for cell in part.cells:
        listed = counts.get((part.header.contexts[cell.context], part.header.groups[cell.group]))
        if listed is None or any(n > m for n, m in zip(_counts(cell), listed, strict=True)):
            raise Unproven(f"the window has more decisions than the stream {_place(part, cell)}")


def _counts(cell: Cell) -> list[Fraction]:
    weights, total = cell.law
    _spend(40 * len(weights), total.bit_length(), _bits(Fraction(*cell.mass)))
    return [Fraction(*cell.mass) * weight / total for weight in weights]


def _judge(target: Target, ends: tuple[Rational, Rational]) -> str:
    """Judge a ratio of which only ends are known."""
    decide = log_at_most if target.unit == "log" else _at_most
    if not decide(ends[0], target.limit):
        return "exceeds"
    return "within" if decide(ends[1], target.limit) else "inconclusive"


def _check_targets(stated: Certificate, facts: Facts, true_claims: Sequence[Claim], window: Proven | None) -> Iterator[Finding]:
    named = {target.quantity for target in stated.targets if target.confidence is not None}
    spent = sum((facts.proven[quantity].error for quantity in named & facts.proven.keys()), Fraction(0))
    confidences = {target.confidence for target in stated.targets} - {None}
    verdicts: list[str] = []
    seen: set[tuple[str, str]] = set()
    for i, target in enumerate(stated.targets):
        _working_on(f"targets[{i}]")
        metric = facts.metrics[target.quantity]
        ends = (ONE, INFINITY) if metric is None else (metric.value, metric.value)
        if target.confidence is not None:
            ends = _ends_of_population(target.quantity, facts, true_claims)
        verdicts.append(_judge(target, ends))
        if stated.change is not None and target.quantity in stated.withdrawn and target.confidence is not None:
            exceeded = window is not None and stated.change.quantity == target.quantity and _judge(target, window.ratio) == "exceeds"
            # Which window contradicts the stream depends on the draws: those up to it have to hold together.
            exceeded = exceeded and window is not None and stated.change.window**2 * window.error <= 1 - target.confidence
            verdicts[-1] = "exceeds" if exceeded else "changed"
        fault = "" if target.verdict == verdicts[-1] else f"the table gives {shown(verdicts[-1])}"
        if target.confidence is None and target.judged != "this table":
            fault = f'judged must be "this table" or a population at some confidence, not {shown(target.judged)}'
        if target.confidence is not None:
            if facts.table.header.subject.kind == "probabilities":
                fault = "probabilities are not a sample from a population"
            if confidences != {target.confidence}:
                fault = "another target is judged at another confidence"
            if spent > 1 - target.confidence:
                fault = f"the intervals do not hold together at this confidence, but only at {shown(_pair(1 - spent))}"
        if (target.quantity, target.unit) in seen:
            fault = "a target that occurs twice"
        seen.add((target.quantity, target.unit))
        judged = "" if target.confidence is None else f" for {shown(target.judged)}"
        statement = f"targets[{i}]: {target.quantity} {target.unit}, limit {shown(target.limit)}: {target.verdict}{judged}"
        yield _finding(statement, not fault, fault)
    order = ("exceeds", "inconclusive", "within", "none")
    overall = next(verdict for verdict in order if verdict in [*verdicts, "none"])
    if stated.withdrawn & ({target.quantity for target in stated.targets} or stated.withdrawn):
        overall = "changed"
    yield _compared("verdict", stated.verdict, overall)


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
        If the certificate or the table is not well formed; `Incomplete` if the certificate keeps back what it assumes, `TooMuch` if
        checking it takes more work than a document of its length is given.
    TableNeeded
        If the table is not embedded and not given.
    """
    token = _WORK.set(_Work())
    try:
        return _checked(certificate, table)
    finally:
        _WORK.reset(token)
        _rarity.cache_clear()


def _checked(certificate: bytes, table: Iterable[bytes] | None) -> Report:
    _granted(len(certificate))
    stated = _read_certificate(certificate)
    findings: list[Finding] = []
    _working_on("the table")
    keep = stated.change is not None or (
        stated.utilities is not None or bool(stated.intervals) or any(step.step == "level" for step in stated.preparation)
    )  # else the figures of a plain table are all that is needed of it
    if stated.embedded is not None:
        names = chain(["subject.table.header"], (f"subject.table.rows[{i}]" for i in range(len(stated.embedded) - 1)))
        law = _read_table(((name, value, None) for name, value in zip(names, stated.embedded, strict=True)), keep, stated.positive)
        if table is not None:
            digest = hashlib.sha256()
            for line in table:
                digest.update(line)
            findings.append(_compared("the digest of the table file", digest.hexdigest(), law.digest))
    elif table is not None:
        law = _read_table(_lines_of_file(table), keep, stated.positive)
    else:
        raise TableNeeded("The certificate does not embed its table; the file of the table has to be given.")
    _working_on("the class of utilities")
    program = None if stated.utilities is None else Program(stated.utilities, law)
    _working_on("the metrics")
    metrics = measure(law)
    findings += _check_subject(stated, law)
    findings += _check_spellings(stated, law)
    findings += _check_preparation(stated, law)
    if program is not None:
        _working_on("the class of utilities")
        findings.append(_check_class(stated, program, metrics))
    _working_on("the metrics")
    if law.given is not None:
        metrics |= law.given.differences()
    findings += _check_metrics(stated.metrics, metrics, "metrics")
    findings += _check_rates(stated, law)
    if law.policy is not None:
        findings += _check_unfiltered(stated, law.policy)
    findings.append(_check_not_compared(stated, law))
    of_intervals, proven = _check_intervals(stated, law)
    findings += of_intervals
    of_differences, held = _check_differences(stated, law)
    findings += of_differences
    proven |= held
    window: Proven | None = None
    if stated.change is not None:
        of_change, window = _check_change(stated.change, law)
        findings += of_change
    facts = Facts(law, metrics, stated.declared, program, proven)
    faults = _faults_of_claims(stated.claims, facts)
    findings += _check_claims(stated.claims, faults)
    findings += _check_targets(stated, facts, [claim for claim, fault in zip(stated.claims, faults, strict=True) if not fault], window)
    report = Report(tuple(findings), stated.verdict)
    if report.ok:
        _check_assumptions(stated, law)
    return report


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
    except Incomplete as error:
        return _failed(f"The certificate is incomplete: {error}.", 2)
    except TooMuch as error:
        return _failed(f"The certificate is not checked: {error}.", 2)
    except FormatError as error:
        return _failed(f"Not a certificate of the format {CERTIFICATE_FORMAT}: {error}.", 2)
    except (OSError, ValueError) as error:  # ValueError: a path with a null character
        return _failed(f"Cannot read or write: {error}.", 2)
    except (MemoryError, OverflowError):
        return _failed("The numbers in the certificate or its table need more memory than there is.", 2)
    return 1 if wrong or missing else 0


if __name__ == "__main__":
    sys.exit(main())
