"""Privacy filters M(ã|a): stochastic tables over finite alphabets, exact, kept as a product of factors.

A factor acts on one or more columns of a label. It is either *mixing* (identity plus rank one: every row is ``diagonal·e_a + base``,
which covers randomized response, the identity and a constant) or an arbitrary stochastic table. Products are never multiplied out.
"""

from __future__ import annotations

import hashlib
import json
import secrets
from bisect import bisect_right
from collections.abc import Container, Iterable, Mapping, MutableMapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import cached_property
from itertools import accumulate, product
from math import gcd, prod
from typing import Any, Protocol

import numpy as np

from fairaudit.arguments import answered
from fairaudit.errors import InputError, nearest, shown
from fairaudit.exact.dense import Numbers
from fairaudit.exact.enclosures import exp_enclosure
from fairaudit.exact.rationals import Number, at_least, common_denominator, option_value, rational
from fairaudit.tables.label_text import label_text
from fairaudit.tables.sources import Table
from fairaudit.tables.values import ByGroup, Label, LabelsLike, column, locator, names, numbers
from fairaudit.words import brief, noun

__all__ = ["Constant", "Factor", "Identity", "Mechanism", "Product", "RandomizedResponse", "Store"]


KEEP_BITS = 60  # significant bits of a keep probability made from an ε, which is rounded down: it loses less than a float would show


class Store(Protocol):
    """Where sticky releases are kept: a dict, a `ReleaseStore`, or anything with this one operation."""

    def setdefault(self, key: tuple[str, str, str], default: Any, /) -> Any:
        """Keep the default under the key unless something is kept there, and return what is kept: one atomic operation."""


@brief
@dataclass(frozen=True, repr=False)
class Factor:
    """A stochastic table over labels, exact.

    Attributes
    ----------
    inputs, outputs : tuple of tuple of str
        True values and released values; each label has as many parts as the factor covers columns.
    rows : tuple of tuple of int
        ``rows[i][j] / denominator`` is the probability of releasing output j for input i.
    denominator : int
        Common denominator; every row sums to it.
    """

    inputs: tuple[Label, ...]
    outputs: tuple[Label, ...]
    rows: tuple[tuple[int, ...], ...]
    denominator: int

    @cached_property
    def mixing(self) -> tuple[int, tuple[int, ...]] | None:
        """``(diagonal, base)`` with ``rows[i] = diagonal·e_i + base``, or None if the table is not of that form."""
        if self.inputs != self.outputs:
            return None
        size = len(self.inputs)
        if size == 1:
            return 0, self.rows[0]
        base = tuple(self.rows[1 if j == 0 else 0][j] for j in range(size))
        diagonal = self.rows[0][0] - base[0]
        fits = all(row[j] == base[j] + (diagonal if i == j else 0) for i, row in enumerate(self.rows) for j in range(size))
        return (diagonal, base) if fits else None

    @property
    def width(self) -> int:
        """Number of columns that the factor covers."""
        return len(self.inputs[0])

    @property
    def output_width(self) -> int:
        """Number of columns of a released value."""
        return len(self.outputs[0])


@brief
@dataclass(frozen=True, repr=False)
class Mechanism:
    """A privacy filter, the product of independent factors.

    Make one with `RandomizedResponse`, `Identity`, `Constant`, `Product`, `from_array` or `from_table`.

    Attributes
    ----------
    factors : tuple of Factor
        The factors; an input of the mechanism joins the inputs of all of them.
    columns : tuple of str
        Names of the columns that the factors cover, in order; empty if they were not named.

    Examples
    --------
    >>> coin = RandomizedResponse(["heads", "tails"], keep_probability="0.7")
    >>> coin.probability("heads", "tails")
    Fraction(3, 10)
    """

    factors: tuple[Factor, ...]
    columns: tuple[str, ...] = ()

    @staticmethod
    @answered
    def from_array(array: Numbers, inputs: Sequence[LabelsLike], outputs: Sequence[LabelsLike] | None = None) -> Mechanism:
        """Read a stochastic table from an array.

        Parameters
        ----------
        array : array_like, shape (inputs, outputs)
            Probabilities; floats are the dyadic rationals that they are. A row that is off 1 by at most 1e-6 is normalised exactly.
        inputs, outputs : sequence
            Labels (tuples for several columns); outputs are the inputs by default.

        Returns
        -------
        Mechanism
            The filter.

        Raises
        ------
        InputError
            If an entry is negative or not a number, a row does not sum to 1, or labels do not fit.
        """
        outputs = inputs if outputs is None else outputs
        rows = np.asarray(array, dtype=object)
        if rows.shape != (len(inputs), len(outputs)):
            raise InputError(f"a table of shape {rows.shape} does not have {len(inputs)} inputs and {len(outputs)} outputs")
        return _from_rows(_labels(inputs, "inputs"), _labels(outputs, "outputs"), [[rational(v) for v in row] for row in rows.tolist()])

    @staticmethod
    @answered
    def from_table(table: Table, *, input: str | Sequence[str], output: str | Sequence[str], probability: str) -> Mechanism:  # noqa: A002
        """Read a stochastic table with one row per input and output; pairs without a row have probability 0.

        Parameters
        ----------
        table : DataFrame, mapping of str to sequence, or CsvTable
            The table.
        input, output : str or sequence of str
            Columns of the true and of the released value.
        probability : str
            Column of M(output|input).

        Returns
        -------
        Mechanism
            The filter; labels are in order of first appearance, outputs in the order of the inputs where they are the same.

        Raises
        ------
        InputError
            As in `from_array`, and if a pair is repeated.
        """
        where = locator(table)
        sides = []
        for side in (names(input), names(output)):
            cells = [column(table, name) for name in side]
            sides.append([_label(parts, f"column {shown(side[0])}, {where(i)}") for i, parts in enumerate(zip(*cells, strict=True))])
        values, bottom = numbers(column(table, probability), probability, where, "share")
        pairs = [v.as_integer_ratio() for v in values.tolist()] if values.dtype.kind == "f" else [(int(v), bottom) for v in values.tolist()]
        inputs = list(dict.fromkeys(sides[0]))
        released, known = dict.fromkeys(sides[1]), set(inputs)
        outputs = [*(a for a in inputs if a in released), *(b for b in released if b not in known)]
        if known.issuperset(released):
            outputs = inputs
        rows = [[(0, 1)] * len(outputs) for _ in inputs]
        position = ({a: i for i, a in enumerate(inputs)}, {b: j for j, b in enumerate(outputs)})
        seen: set[tuple[Label, Label]] = set()
        for i, key in enumerate(zip(*sides, strict=True)):
            if key in seen:
                raise InputError(f"{where(i)}: the probability of releasing {key[1]} for {key[0]} was given before; each pair has one row")
            seen.add(key)
            rows[position[0][key[0]]][position[1][key[1]]] = pairs[i]
        return _from_rows(tuple(inputs), tuple(outputs), rows)

    @cached_property
    def inputs(self) -> tuple[Label, ...]:
        """True values, the product of the factors' inputs, the last factor varying fastest."""
        return tuple(sum(parts, ()) for parts in product(*(f.inputs for f in self.factors)))

    @cached_property
    def outputs(self) -> tuple[Label, ...]:
        """Released values, likewise."""
        return tuple(sum(parts, ()) for parts in product(*(f.outputs for f in self.factors)))

    @property
    def width(self) -> int:
        """Number of columns of a label."""
        return sum(f.width for f in self.factors)

    @property
    def denominator(self) -> int:
        """Common denominator of all probabilities of the product."""
        return prod(f.denominator for f in self.factors)

    def locate(self, value: LabelsLike) -> tuple[int, ...]:
        """Position of a true value among the inputs of each factor.

        Raises
        ------
        InputError
            If it is not in the alphabet.
        """
        return tuple(self._locate(value))

    def row(self, value: LabelsLike) -> tuple[int, ...]:
        """M(·|value) over `outputs`, as integers over `denominator`."""
        parts = [f.rows[i] for f, i in zip(self.factors, self._locate(value), strict=True)]
        return tuple(prod(entries) for entries in product(*parts))

    @answered
    def probability(self, value: LabelsLike, released: LabelsLike) -> Fraction:
        """M(released|value), exact.

        Raises
        ------
        InputError
            If either is not in the alphabet.
        """
        rows = zip(self.factors, self._locate(value), self._locate(released, outputs=True), strict=True)
        return prod((Fraction(f.rows[i][j], f.denominator) for f, i, j in rows), start=Fraction(1))

    def release(
        self, value: LabelsLike, *, subject: str | int | None = None, attribute: str | None = None, store: Store | None = None
    ) -> Any:
        """Draw a released value, exactly by its probability, from the operating system's randomness.

        A fresh draw for the same person spends ε again. With a `subject` the draw is *sticky*: the first one is kept in `store` and
        returned from then on, whatever value is passed. The store holds releases, never true values, under the filter, the attribute
        and the subject (`release_key`); another filter, or another attribute, is a draw of its own.

        Parameters
        ----------
        value : str, number or tuple
            The true value; a tuple for several columns.
        subject : str or int, optional
            Who the value belongs to; 17 and "17" are one subject.
        attribute : str, optional
            What is released, such as "sex"; needed with `subject`, except that the columns of a `Product` name it.
        store : Store, optional
            Where sticky draws are kept; needed with `subject`. A dict serves the threads of one process until it ends, a
            `ReleaseStore` many processes and for good. Of any other store, `setdefault` must be one atomic operation.

        Returns
        -------
        str or tuple of str
            The released label, a tuple for several columns.

        Raises
        ------
        InputError
            If the value is not in the alphabet (it is never passed through), a subject comes without a store or an attribute, the store
            has no atomic operation, or it has a release for the subject alone, as earlier versions kept it.

        Examples
        --------
        >>> coin = RandomizedResponse(["heads", "tails"], keep_probability="0.7")
        >>> kept = {}
        >>> first = coin.release("heads", subject="Ada", attribute="toss", store=kept)
        >>> coin.release("tails", subject="Ada", attribute="toss", store=kept) == first
        True
        """
        places = self._locate(value)
        if subject is None:
            if attribute is not None or store is not None:
                raise InputError("an attribute and a store belong to a sticky release; say whose it is with subject=")
            return self._draw(places, secrets.randbelow)
        if store is None:
            raise InputError("a sticky release needs a store; pass a dict, or a ReleaseStore for several processes")
        key = self.release_key(subject, attribute)
        _check_store(store, key[2])
        kept = store.setdefault(key, self._draw(places, secrets.randbelow))
        self._locate(kept, outputs=True)
        return kept

    def release_key(self, subject: str | int, attribute: str | None = None) -> tuple[str, str, str]:
        """The key of a sticky release: the digest of the filter, the attribute, and the subject.

        Parameters
        ----------
        subject, attribute
            As in `release`.

        Returns
        -------
        tuple of str
            The digest does not depend on the order in which labels are listed, nor on how fractions are written.

        Raises
        ------
        InputError
            If the attribute is not named, or a part is not a text that can be stored.

        Examples
        --------
        >>> coin = RandomizedResponse(["heads", "tails"], keep_probability="0.7")
        >>> coin.release_key(17, "toss")[1:]
        ('toss', '17')
        """
        if attribute is None:
            if not self.columns:
                raise InputError("a sticky release needs to know what it releases; name it, as in attribute='sex'")
            attribute = self.columns[0] if len(self.columns) == 1 else json.dumps(self.columns)
        return self.digest, _key_part("attribute", attribute), _key_part("subject", subject)

    @cached_property
    def digest(self) -> str:
        """SHA-256 of the exact table of probabilities, with its labels.

        Examples
        --------
        >>> RandomizedResponse("ab", keep_probability="0.7").digest == RandomizedResponse("ba", keep_probability="7/10").digest
        True
        """
        tables = []
        for f in self.factors:
            common = gcd(f.denominator, *(entry for row in f.rows for entry in row))
            order = sorted(range(len(f.outputs)), key=f.outputs.__getitem__)
            rows = sorted((a, [row[j] // common for j in order]) for a, row in zip(f.inputs, f.rows, strict=True))
            tables.append([[f.outputs[j] for j in order], rows, f.denominator // common])
        return hashlib.sha256(json.dumps(tables, separators=(",", ":")).encode("ascii")).hexdigest()

    def release_all(self, values: Iterable[LabelsLike]) -> list[Any]:
        """Draw a fresh released value for each of several true values, as `release` does."""
        return [self._draw(self._locate(value), secrets.randbelow) for value in values]

    def release_for_simulation(self, values: Iterable[LabelsLike], generator: np.random.Generator) -> list[Any]:
        """Draw released values from a seeded generator. For simulations only: who knows the seed undoes the filter."""

        def below(bound: int) -> int:
            return int(generator.integers(bound)) if bound < 2**63 else int.from_bytes(generator.bytes(len(f"{bound:x}") // 2 + 17)) % bound

        return [self._draw(self._locate(value), below) for value in values]

    def _draw(self, places: Sequence[int], below: Any) -> Any:
        parts: list[str] = []
        for factor, cumulative, i in zip(self.factors, self._cumulative, places, strict=True):
            parts += factor.outputs[bisect_right(cumulative[i], below(factor.denominator))]
        return parts[0] if len(parts) == 1 else tuple(parts)

    @cached_property
    def _cumulative(self) -> list[list[list[int]]]:
        return [[list(accumulate(row)) for row in f.rows] for f in self.factors]

    @cached_property
    def _index(self) -> list[tuple[dict[Label, int], dict[Label, int]]]:
        return [({a: i for i, a in enumerate(f.inputs)}, {b: j for j, b in enumerate(f.outputs)}) for f in self.factors]

    def _locate(self, value: Any, *, outputs: bool = False) -> list[int]:
        """Index in each factor of a joint label."""
        parts = value if isinstance(value, tuple) else (value,)
        texts = tuple(part if isinstance(part, str) else label_text(part) for part in parts)
        places, start = [], 0
        for factor, index in zip(self.factors, self._index, strict=True):
            width = factor.output_width if outputs else factor.width
            part = texts[start : start + width]
            place = index[outputs].get(part)  # type: ignore[arg-type]
            if place is None:
                known = [", ".join(label) for label in (factor.outputs if outputs else factor.inputs)]
                raise InputError(f"the filter does not know the value {shown(value)}; {nearest(', '.join(map(str, part)), known)}")
            places.append(place)
            start += width
        if start != len(texts):
            raise InputError(f"the value {shown(value)} has {len(texts)} {noun(len(texts), 'part')}; the filter takes {start}")
        return places


def _key_part(name: str, value: Any) -> str:
    """A part of the key of a sticky release, as text."""
    if isinstance(value, bool) or not isinstance(value, (str, int)):
        raise InputError(f"the {name} {shown(value)} is of type {type(value).__name__}; a text or a whole number is accepted")
    text = str(value)
    if not text.strip():
        raise InputError(f"the {name} is empty; a name that nothing else has is accepted")
    try:
        text.encode("utf-8")
    except UnicodeEncodeError:
        raise InputError(f"the {name} {shown(text)} is not valid Unicode") from None
    return text


def _check_store(store: Store, subject: str) -> None:
    """Refuse a store on which two draws could race, and one that has releases whose filter is not known."""
    operation = getattr(type(store), "setdefault", None)
    if operation is None or operation is MutableMapping.setdefault:
        raise InputError(
            f"a store of type {type(store).__name__} has no atomic operation, so that two draws for one subject could race; pass a dict "
            "(threads of one process), a ReleaseStore (many processes), or an object whose own setdefault(key, value) is atomic"
        )
    alone = (subject, int(subject)) if subject.isdecimal() and len(subject) < 20 else (subject,)
    if isinstance(store, Container) and any(old in store for old in alone):
        raise InputError(
            f"the store has a release for {shown(subject)} alone, as earlier versions kept it, and does not say of which filter and "
            "attribute; move it with store[filter.release_key(subject, attribute)] = store.pop(subject)"
        )


@answered
def RandomizedResponse(  # noqa: N802
    values: Sequence[LabelsLike],
    *,
    keep_probability: Number | None = None,
    epsilon: Number | None = None,
    exp_epsilon: Number | None = None,
) -> Mechanism:
    """k-ary randomized response: the truth with the keep probability, otherwise one of the other values, uniformly.

    Source: T9; Coq `T9_krr`, `T9_krr_degrades`, `T9_monotone`.

    Parameters
    ----------
    values : sequence
        The alphabet, at least two labels (tuples for several columns at once).
    keep_probability : number or str
        Probability of releasing the truth, in [0, 1].
    epsilon : number or str
        ε ≥ 0 in nats. e^ε is irrational unless ε = 0, so the keep probability is rounded towards 1/k and the filter is at most ε-DP.
    exp_epsilon : number or str
        e^ε ≥ 1; exact, such as ``"7/3"``.

    Returns
    -------
    Mechanism
        The filter. Below 1/k the truth is less likely than each lie; its ε is then log(q/p).

    Raises
    ------
    InputError
        Unless exactly one of the three is given, in range, and the values are at least two different labels.

    Examples
    --------
    >>> RandomizedResponse(["a", "b", "c"], exp_epsilon="7/3").probability("a", "a")
    Fraction(7, 13)
    """
    labels = _labels(values, "values")
    k = len(labels)
    given = [
        name for name, v in (("keep_probability", keep_probability), ("epsilon", epsilon), ("exp_epsilon", exp_epsilon)) if v is not None
    ]
    if len(given) != 1:
        raise InputError(f"{' and '.join(given) or 'nothing'} was given; give one of keep_probability, epsilon, exp_epsilon")
    if k < 2:
        raise InputError("randomized response needs at least two values")
    if epsilon is not None:
        keep = _keep_for_epsilon(at_least("epsilon", epsilon, 0), k)
    elif exp_epsilon is not None:
        factor = at_least("exp_epsilon", exp_epsilon, 1)
        keep = factor / (factor + k - 1)
    else:
        keep = at_least("keep_probability", keep_probability, 0)
        if keep > 1:
            raise InputError(f"keep_probability is {shown(keep_probability)}; a probability from 0 to 1 is accepted")
    (top, lie), bottom = common_denominator([(keep.numerator, keep.denominator), ((1 - keep) / (k - 1)).as_integer_ratio()])
    rows = tuple(tuple(top if i == j else lie for j in range(k)) for i in range(k))
    return Mechanism((Factor(labels, labels, rows, bottom),))


@answered
def Identity(values: Sequence[LabelsLike]) -> Mechanism:  # noqa: N802
    """No privacy: every value is released as it is.

    Parameters
    ----------
    values : sequence
        The alphabet.

    Returns
    -------
    Mechanism
        The filter.

    Raises
    ------
    InputError
        If the values are fewer than two, or not all different.

    Examples
    --------
    >>> Identity(["a", "b"]).release("b")
    'b'
    """
    labels = _labels(values, "values")
    k = len(labels)
    return Mechanism((Factor(labels, labels, tuple(tuple(int(i == j) for j in range(k)) for i in range(k)), 1),))


@answered
def Constant(values: Sequence[LabelsLike], output: LabelsLike | ByGroup[Number] | None = None) -> Mechanism:  # noqa: N802
    """Perfect privacy: the same value, or a draw from the same distribution, whatever the truth.

    Parameters
    ----------
    values : sequence
        The alphabet.
    output : label or mapping of label to probability, optional
        What is released; uniform over the values by default.

    Returns
    -------
    Mechanism
        The filter.

    Raises
    ------
    InputError
        If the output is not among the values, or its probabilities do not sum to 1.

    Examples
    --------
    >>> Constant(["a", "b"], "a").release("b")
    'a'
    """
    labels = _labels(values, "values")
    if output is None:
        chosen = {label: (1, len(labels)) for label in labels}
    elif isinstance(output, Mapping):
        chosen = {_label(key if isinstance(key, tuple) else (key,), "the output"): option_value(v) for key, v in output.items()}
    else:
        chosen = {_label(output if isinstance(output, tuple) else (output,), "the output"): (1, 1)}
    for label in chosen:
        if label not in labels:
            raise InputError(f"the output {shown(label)} is not among the values; {nearest(label[0], [a[0] for a in labels])}")
    return _from_rows(labels, labels, [[chosen.get(label, (0, 1)) for label in labels]] * len(labels))


@answered
def Product(parts: Mapping[str, Mechanism]) -> Mechanism:  # noqa: N802
    """Independent filters, one for each attribute, applied together.

    When the whole tuple may change, their ε add up; when one attribute changes, its own counts.

    Source: T9; Coq `T9_products`, `T9_products_monotone`.

    Parameters
    ----------
    parts : mapping of column name to Mechanism
        The filter of each column, in the order of the columns.

    Returns
    -------
    Mechanism
        The product, kept as factors.

    Raises
    ------
    InputError
        If there is no part, or one covers several columns.

    Examples
    --------
    >>> both = Product({"sex": Identity(["f", "m"]), "age": Constant(["old", "young"], "old")})
    >>> both.release(("f", "young"))
    ('f', 'old')
    """
    if not parts:
        raise InputError("a product needs at least one filter")
    for name, part in parts.items():
        if part.width != 1:
            raise InputError(f"the filter of {shown(name)} covers {part.width} columns; each filter of a product covers one")
    return Mechanism(tuple(f for part in parts.values() for f in part.factors), tuple(parts))


def _keep_for_epsilon(epsilon: Fraction, k: int) -> Fraction:
    """Greatest keep probability on a fine grid whose e^ε is not above the given one."""
    if epsilon == 0:
        return Fraction(1, k)
    low, _ = exp_enclosure((epsilon.numerator, epsilon.denominator), KEEP_BITS + 8)
    factor = Fraction(low, 1 << (KEEP_BITS + 8))
    keep = factor / (factor + k - 1)
    # Both the keep probability and its complement need that many significant bits.
    bits = KEEP_BITS + k.bit_length() + (low >> (KEEP_BITS + 8)).bit_length()
    return max(Fraction(1, k), Fraction((keep.numerator << bits) // keep.denominator, 1 << bits))


def _label(parts: Sequence[Any], where: str) -> Label:
    texts = [label_text(part) for part in parts]
    if any(text is None for text in texts):
        raise InputError(f"{where}: a label is missing")
    return tuple(text for text in texts if text is not None)


def _labels(values: Sequence[Any], what: str) -> tuple[Label, ...]:
    labels = tuple(_label(value if isinstance(value, tuple) else (value,), f"the {what}") for value in values)
    if not labels:
        raise InputError(f"there are no {what}; give at least one")
    if len(set(labels)) != len(labels):
        raise InputError(f"the {what} are not all different")
    if len({len(label) for label in labels}) > 1:
        raise InputError(f"the {what} have different numbers of parts")
    return labels


def _from_rows(inputs: tuple[Label, ...], outputs: tuple[Label, ...], rows: Sequence[Sequence[tuple[int, int]]]) -> Mechanism:
    scaled: list[tuple[list[int], int]] = []
    for label, row in zip(inputs, rows, strict=True):
        if any(n < 0 for n, _ in row):
            raise InputError(f"the filter's row of {shown(', '.join(label))} has a negative entry; probabilities are at least 0")
        whole, bottom = common_denominator(row)
        total = sum(whole)
        if abs(total - bottom) * 10**6 > bottom:
            raise InputError(f"the filter's row of {shown(', '.join(label))} sums to {float(Fraction(total, bottom)):.10g}; rows sum to 1")
        common = gcd(*whole)
        scaled.append(([v // common for v in whole], total // common))
    _, bottom = common_denominator([(1, total) for _, total in scaled])
    exact = tuple(tuple(v * (bottom // total) for v in whole) for whole, total in scaled)
    return Mechanism((Factor(inputs, outputs, exact, bottom),))
