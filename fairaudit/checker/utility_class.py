"""A class of utilities as the certificate states it, and the multipliers of a claim about every utility in it."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import chain
from operator import add

from .json_values import check_distinct, read_boolean, read_choice, read_integer, read_list, read_object, read_strings
from .rationals import ONE, ZERO, Rational, at_most, over_common_denominator, read_rational, read_rationals, read_signed
from .text import malformed, shown
from .work import spend


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
        return self.m if self.tau is None or at_most(self.tau, self.m) else self.tau

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


def read_class(value: object, where: str) -> UtilityClass:
    """Read a class so far as no table is needed; that it fits the table is made sure of by ``Program``."""
    keys = ("quantity", "gamma", "m", "tau", "tau_on", "blind", "lipschitz", "metric", "order", "rows", "family")
    members = read_object(value, where, keys)

    def nonnegative(key: str) -> Rational:
        return read_rational(members[key], f"{where}.{key}", nonnegative=True)

    def entries(key: str) -> list[tuple[str, object]]:
        return [(f"{where}.{key}[{i}]", item) for i, item in enumerate(read_list(members[key], f"{where}.{key}"))]

    blind = read_boolean(members["blind"], f"{where}.blind")
    gamma, m = nonnegative("gamma"), nonnegative("m")
    tau = None if members["tau"] is None else nonnegative("tau")
    lipschitz = None if members["lipschitz"] is None else nonnegative("lipschitz")
    if gamma == ZERO or not at_most(m, gamma):
        raise malformed(f"{where}.gamma", "must be positive and at least m")
    if tau is not None and not at_most(tau, gamma):
        raise malformed(f"{where}.tau", "must be at most gamma")
    if blind and lipschitz is not None:
        raise malformed(f"{where}.lipschitz", "must be null when the class is blind")
    order = [read_strings(item, place, 2) for place, item in entries("order")]
    return UtilityClass(
        read_choice(members["quantity"], f"{where}.quantity", ("local", "global")),
        gamma,
        m,
        tau,
        read_choice(members["tau_on"], f"{where}.tau_on", ("pair", "all")),
        blind,
        lipschitz,
        None if members["metric"] is None else _read_distances(members["metric"], f"{where}.metric"),
        [(lower, higher) for lower, higher in order],
        [_read_constraint(item, place, blind) for place, item in entries("rows")],
        None if members["family"] is None else _read_family(members["family"], f"{where}.family"),
    )


def _read_distances(value: object, where: str) -> list[list[Rational]]:
    """Read a metric, and make sure that it is one."""
    n = len(read_list(value, where))
    distances = [read_rationals(row, f"{where}[{i}]", n) for i, row in enumerate(read_list(value, where))]
    flat, unit = over_common_denominator([ONE, *chain.from_iterable(distances)])
    spend(n * n * (n + 5) // 2, unit.bit_length())
    rows = [flat[i : i + n] for i in range(1, n * n + 1, n or 1)]
    for i, row in enumerate(rows):
        for j, distance in enumerate(row):
            if (distance == 0) != (i == j):
                raise malformed(f"{where}[{i}][{j}]", "must be zero on the diagonal and positive elsewhere")
            if distance != rows[j][i]:
                raise malformed(f"{where}[{i}][{j}]", "must be symmetric")
            if distance > min(map(add, row, rows[j])):
                raise malformed(f"{where}[{i}][{j}]", "violates the triangle inequality")
    return distances


def _read_constraint(value: object, where: str, blind: bool) -> tuple[list[tuple[int, int | None, int, Rational]], Rational]:
    members = read_object(value, where, ("terms", "bound"))
    terms: list[tuple[int, int | None, int, Rational]] = []
    for i, item in enumerate(read_list(members["terms"], f"{where}.terms")):
        place = f"{where}.terms[{i}]"
        context, group, decision, coefficient = read_list(item, place, 4)
        if blind and group is not None:
            raise malformed(f"{place}[1]", "must be null when the class is blind")
        terms.append(
            (
                read_integer(context, f"{place}[0]"),
                None if blind else read_integer(group, f"{place}[1]"),
                read_integer(decision, f"{place}[2]"),
                read_rational(coefficient, f"{place}[3]"),
            )
        )
    return terms, read_rational(members["bound"], f"{where}.bound")


def _read_family(value: object, where: str) -> Family:
    members = read_object(value, where, ("names", "lower", "upper", "features", "rows"))
    names = read_strings(members["names"], f"{where}.names")
    check_distinct(names, f"{where}.names")
    lower, upper = (read_signed(members[key], f"{where}.{key}", len(names)) for key in ("lower", "upper"))
    for k, (low, high) in enumerate(zip(lower, upper, strict=True)):
        if not at_most(low, high):
            raise malformed(f"{where}.lower[{k}]", "is greater than the upper end")
    features = [
        [read_signed(phi, f"{where}.features[{i}][{u}]", len(names)) for u, phi in enumerate(read_list(cell, f"{where}.features[{i}]"))]
        for i, cell in enumerate(read_list(members["features"], f"{where}.features"))
    ]
    rows: list[tuple[list[Rational], Rational]] = []
    for i, item in enumerate(read_list(members["rows"], f"{where}.rows")):
        row = read_object(item, f"{where}.rows[{i}]", ("coefficients", "bound"))
        coefficients = read_signed(row["coefficients"], f"{where}.rows[{i}].coefficients", len(names))
        rows.append((coefficients, read_rational(row["bound"], f"{where}.rows[{i}].bound")))
    return Family(lower, upper, features, rows)


def read_dual(value: object, where: str, local: bool, parameters: int | None) -> Dual:
    """Read the multipliers of a claim by ``lp-dual``, and the parameters of the utility where the class is a family."""
    members = read_object(value, where, ["pairs"] if parameters is None else ["pairs", "theta"])
    pairs: dict[tuple[int, int, int], list[tuple[int, Rational]]] = {}
    last = (-1, -1, -1)
    for i, item in enumerate(read_list(members["pairs"], f"{where}.pairs")):
        place = f"{where}.pairs[{i}]"
        entry = read_object(item, place, ["context"] * local + ["higher", "lower", "multipliers"])
        context = read_integer(entry["context"], f"{place}.context") if local else -1
        pair = context, read_integer(entry["higher"], f"{place}.higher"), read_integer(entry["lower"], f"{place}.lower")
        if pair <= last:
            raise malformed(place, "is not in increasing order of context, higher and lower")
        last = pair
        pairs[pair] = _read_multipliers(entry["multipliers"], f"{place}.multipliers")
    return Dual(pairs, None if parameters is None else read_signed(members["theta"], f"{where}.theta", parameters))


def _read_multipliers(value: object, where: str) -> list[tuple[int, Rational]]:
    multipliers: list[tuple[int, Rational]] = []
    for i, item in enumerate(read_list(value, where)):
        number, y = read_list(item, f"{where}[{i}]", 2)
        multipliers.append((read_integer(number, f"{where}[{i}][0]"), read_rational(y, f"{where}[{i}][1]", nonnegative=True)))
        if multipliers[i][1] == ZERO:
            raise malformed(f"{where}[{i}][1]", "must be positive")
        if i and multipliers[i][0] <= multipliers[i - 1][0]:
            raise malformed(f"{where}[{i}][0]", "is not greater than the number before")
    return multipliers
