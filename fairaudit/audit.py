"""`certify`: the one place that decides what is measured, bounded and claimed for an input."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from decimal import Context, Decimal, localcontext
from fractions import Fraction
from functools import cached_property
from typing import TYPE_CHECKING, Any, Literal

from fairaudit import __version__
from fairaudit.certificate import FORMAT, Certificate, Table, columns, number, with_table
from fairaudit.exact import InputError, compare_log, rational, rational_text, shown
from fairaudit.fairness import (
    Distance,
    Ratio,
    cell_expectation,
    demographic_parity,
    equalized_odds,
    global_fairness,
    global_supremum,
    least_expectation,
    local_fairness,
    local_supremum,
    most_unequal_distances,
    most_unequal_ratios,
)
from fairaudit.law import Law
from fairaudit.utility import Utility, UtilityTable

if TYPE_CHECKING:
    import pandas as pd

__all__ = ["Claim", "Result", "Target", "certify"]

Verdict = Literal["none", "within", "exceeds", "inconclusive"]
Quantity = Literal["local", "global"]
RANK: dict[Verdict, int] = {"none": 0, "within": 1, "inconclusive": 2, "exceeds": 3}


@dataclass(frozen=True)
class Claim:
    """A statement with its scope and evidence, as docs/certificate.md lists them."""

    quantity: str
    relation: Literal["=", "<="]
    value: Fraction | float
    by: str
    evidence: Mapping[str, str]
    scope: str = "this law"
    assumptions: tuple[str, ...] = ()


@dataclass(frozen=True)
class Target:
    """A limit on the local or global measure, and how it was judged.

    Attributes
    ----------
    quantity : {"local", "global"}
        What is limited.
    limit : Fraction
        The limit: on L or L̄ (``unit="log"``, nats) or on R or R̄ (``unit="ratio"``).
    unit : {"log", "ratio"}
        Which of the two.
    verdict : {"within", "exceeds", "inconclusive"}
        Decided exactly; inconclusive when nothing was compared.
    """

    quantity: Quantity
    limit: Fraction
    unit: Literal["log", "ratio"]
    verdict: Verdict


@dataclass(frozen=True, eq=False)
class Result:
    """What `certify` found. Ratios and distances are exact.

    Attributes
    ----------
    law : Law
        What was audited.
    utility : UtilityTable
        The utility on it, with its constants ``gamma``, ``m`` and ``lipschitz()``.
    local, global_ : Ratio or None
        Local and global g-fairness with witness; None where nothing can be compared.
    demographic_parity, equalized_odds : Distance or None
        Greatest total variation distances with witness.
    local_supremum, global_supremum : Ratio or None
        Suprema over utilities that do not depend on the group (T6).
    tau : Fraction or None
        Least expected utility over the compared cells.
    not_compared : tuple of dict
        What was left out, and why.
    targets : tuple of Target
        The limits that were asked for.
    verdict : {"none", "within", "exceeds", "inconclusive"}
        "exceeds" before "inconclusive" before "within"; "none" without targets.
    notes : tuple of str
        What was noticed while reading.
    """

    law: Law
    utility: UtilityTable
    local: Ratio | None
    global_: Ratio | None
    demographic_parity: Distance | None
    equalized_odds: Distance | None
    local_supremum: Ratio | None
    global_supremum: Ratio | None
    tau: Fraction | None
    not_compared: tuple[dict[str, Any], ...]
    targets: tuple[Target, ...]
    verdict: Verdict
    notes: tuple[str, ...]
    embed: bool | None = field(default=None, repr=False)

    @property
    def sentence(self) -> str:
        """Who is favoured over whom, where, and by what factor, in one sentence. Labels in it are as in the input, unescaped."""
        if self.local is None:
            opening = "No context has two groups, so nobody is compared within a context; "
            return opening + (_sentence(self.global_, "over all contexts") if self.global_ else "nothing else can be compared either.")
        if self.local.ratio == 1:
            if self.global_ is None or self.global_.ratio == 1:
                return "All groups that are compared have the same expected utility in every context."
            return "In every context all compared groups have the same expected utility, but " + _sentence(
                self.global_, "over all contexts, because groups are spread differently over them,"
            )
        context = place(self.local.witness.context or {})
        return _sentence(self.local, f"in {context}" if context else "")

    def most_unequal(self, count: int = 3) -> dict[str, tuple[Ratio, ...] | tuple[Distance, ...]]:
        """Rank the most unequal pairs of groups, by measure.

        Parameters
        ----------
        count : int
            How many at the most for each measure.

        Returns
        -------
        dict
            ``local``, ``global``, ``equalized_odds`` and ``demographic_parity``, most unequal first.
        """
        if count < 1:
            raise InputError(f"{count} most unequal pairs cannot be listed; ask for at least 1")
        law, utility = self.law, self.utility
        return {
            "local": most_unequal_ratios(law, utility, count, within_context=True),
            "global": most_unequal_ratios(law, utility, count, within_context=False),
            "equalized_odds": most_unequal_distances(law, count, within_context=True),
            "demographic_parity": most_unequal_distances(law, count, within_context=False),
        }

    def to_frame(self) -> pd.DataFrame:
        """Tabulate the cells: labels, weight (count or mass), exact expected utility, and the same as a float.

        Returns
        -------
        pandas.DataFrame
            One row per context and group that has a law.
        """
        import pandas as pd

        law = self.law
        records = []
        masses = law.cell_mass
        total = law.scale if law.kind == "counts" else sum(masses)
        for cell, (x, a) in enumerate(zip(law.cell_context.tolist(), law.cell_group.tolist(), strict=True)):
            value = Fraction(*cell_expectation(law, self.utility, cell))
            labels = {**law.context_label(x), **law.group_label(a)}
            weight = Fraction(masses[cell], total) if law.population != "equal" else None
            records.append({**labels, "weight": weight, "expectation": value, "expectation_float": float(value)})
        return pd.DataFrame.from_records(records)

    @cached_property
    def claims(self) -> tuple[Claim, ...]:
        """The statements that the certificate makes."""
        return tuple(_claims(self))

    @cached_property
    def certificate(self) -> Certificate:
        """The certificate, ready to be saved."""
        law = self.law
        document: dict[str, Any] = {
            "format": FORMAT,
            "subject": {
                "kind": law.kind,
                "columns": columns(law),
                "population": law.population,
                "table": {},
                "utility": {
                    "gamma": number(self.utility.gamma),
                    "m": number(self.utility.m),
                    "tau": None if self.tau is None else number(self.tau),
                    "lipschitz": number(self.utility.lipschitz()),
                    "depends_on_group": self.utility.depends_on_group,
                },
            },
            "metrics": {
                "local": _ratio_entry(self.local),
                "global": _ratio_entry(self.global_),
                "demographic_parity": _distance_entry(self.demographic_parity),
                "equalized_odds": _distance_entry(self.equalized_odds),
                "local_supremum": _ratio_entry(self.local_supremum),
                "global_supremum": _ratio_entry(self.global_supremum),
            },
            "not_compared": [_left_out(entry) for entry in self.not_compared],
            "claims": [
                {
                    "quantity": claim.quantity,
                    "relation": claim.relation,
                    "value": number(claim.value),
                    "scope": claim.scope,
                    "by": claim.by,
                    "assumptions": list(claim.assumptions),
                    "evidence": dict(claim.evidence),
                }
                for claim in self.claims
            ],
            "targets": [
                {"quantity": t.quantity, "limit": number(t.limit), "unit": t.unit, "judged": "this table", "verdict": t.verdict}
                for t in self.targets
            ],
            "verdict": self.verdict,
            "versions": {"fairaudit": __version__},
        }
        return with_table(document, Table(law, self.utility), embed=self.embed)


def certify(
    law: Law,
    utility: Utility | Mapping[Any, Any],
    *,
    max_local: Any = None,
    max_global: Any = None,
    max_local_ratio: Any = None,
    max_global_ratio: Any = None,
    confidence: Any = 0.95,
    embed_table: bool | None = None,
) -> Result:
    """Measure a law exactly, judge it against targets, and prepare a certificate.

    Parameters
    ----------
    law : Law
        What to audit.
    utility : Utility or mapping
        g; a mapping from decision to value is taken as `Utility(mapping)`.
    max_local, max_global : number or str, optional
        Targets for L and L̄, in nats; a text such as ``"0.2"`` is the decimal that it says.
    max_local_ratio, max_global_ratio : number or str, optional
        Targets for R and R̄, such as ``"5/4"``.
    confidence : float or None
        None judges the table itself. Claims about the population behind counts do not exist yet, so a target on counts needs None.
    embed_table : bool, optional
        Whether the certificate holds the table; by default if it has at most 100,000 entries. False leaves only a salted digest.

    Returns
    -------
    Result
        Exact measures with witnesses, claims, verdict and certificate.

    Raises
    ------
    InputError
        If the utility does not fit the law, a target is not sensible, or nothing at all can be compared.

    Examples
    --------
    >>> law = Law.from_counts(
    ...     {"hired": ["yes", "no", "yes", "no"], "sex": ["f", "f", "m", "m"], "n": [3, 1, 1, 1]},
    ...     decision="hired", group="sex", count="n")
    >>> result = certify(law, {"yes": 1}, max_local_ratio="5/4", confidence=None)
    >>> result.local.ratio, result.verdict
    (Fraction(3, 2), 'exceeds')
    """
    asked = [
        _limit("local", "log", max_local),
        _limit("local", "ratio", max_local_ratio),
        _limit("global", "log", max_global),
        _limit("global", "ratio", max_global_ratio),
    ]
    limits = [limit for limit in asked if limit is not None]
    if limits and law.kind == "counts" and confidence is not None:
        raise InputError(
            "a target on counts would be judged at a confidence for the population behind them, and such claims do not exist yet; "
            "confidence none judges the table itself"
        )
    table = (utility if isinstance(utility, Utility) else Utility(utility)).on(law)
    local, overall = local_fairness(law, table), global_fairness(law, table)
    if local is None and overall is None:
        raise InputError("no two groups can be compared: no context has two groups, and no two groups have a population")
    measured: dict[Quantity, Ratio | None] = {"local": local, "global": overall}
    targets = tuple(Target(q, limit, unit, _judge(measured[q], limit, unit)) for q, unit, limit in limits)
    verdict: Verdict = max((t.verdict for t in targets), key=RANK.__getitem__, default="none")
    return Result(
        law=law,
        utility=table,
        local=local,
        global_=overall,
        demographic_parity=demographic_parity(law),
        equalized_odds=equalized_odds(law),
        local_supremum=local_supremum(law),
        global_supremum=global_supremum(law),
        tau=least_expectation(law, table),
        not_compared=tuple(_not_compared(law)),
        targets=targets,
        verdict=verdict,
        notes=law.notes,
        embed=embed_table,
    )


def measure_entry(measured: Ratio | Distance) -> dict[str, Any]:
    """Write a measure as a certificate stores it."""
    entry = _ratio_entry(measured) if isinstance(measured, Ratio) else _distance_entry(measured)
    return entry or {}


def place(labels: Mapping[str, str]) -> str:
    """Name a group or context.

    Examples
    --------
    >>> place({"Dept": "A", "Year": "1973"})
    'Dept=A, Year=1973'
    """
    return ", ".join(f"{column}={label}" for column, label in labels.items())


def approximate(value: Fraction | float) -> str:
    """Four significant digits of an exact value, for a person.

    Examples
    --------
    >>> approximate(Fraction(24475, 18432)), approximate(Fraction(10**400, 3)), approximate(float("inf"))
    ('1.328', '3.333e+399', 'infinite')
    """
    if not isinstance(value, Fraction):
        return "infinite"
    if value == 0 or Fraction(1, 10**300) < value < 10**300:
        return f"{float(value):.4g}"
    with localcontext(Context(prec=4, Emin=-999_999, Emax=999_999)) as context:
        return format(context.divide(Decimal(value.numerator), Decimal(value.denominator)), ".4g")


def _sentence(measured: Ratio, where: str) -> str:
    witness = measured.witness
    higher, lower = place(witness.higher), place(witness.lower)
    high, low = (approximate(v) for v in witness.expectations)
    start = f"{where}{' ' if where.endswith(',') else ', '}" if where else ""
    if measured.ratio == 1:
        text = f"{start}all compared groups have the same expected utility."
    elif not isinstance(measured.ratio, Fraction):
        text = f"{start}{higher} is favoured over {lower}: an expected utility of {high} against exactly 0, so R and log R are infinite."
    else:
        factor = approximate(measured.ratio)
        text = f"{start}{higher} is favoured over {lower}: an expected utility of {high} against {low}, {factor} times as much."
    return text[:1].upper() + text[1:] if where.startswith("in ") else text


def _limit(quantity: Quantity, unit: Literal["log", "ratio"], value: Any) -> tuple[Quantity, Literal["log", "ratio"], Fraction] | None:
    if value is None:
        return None
    name = f"max_{quantity}" + ("_ratio" if unit == "ratio" else "")
    try:
        limit = Fraction(*rational(value))
    except InputError as error:
        raise InputError(f"{name}: {error}") from None
    least = 1 if unit == "ratio" else 0
    if limit < least:
        raise InputError(f"{name} is {shown(value)}; it must be at least {least}, which is perfect parity")
    return quantity, unit, limit


def _judge(measured: Ratio | None, limit: Fraction, unit: str) -> Verdict:
    if measured is None:
        return "inconclusive"
    if unit == "ratio":
        return "within" if measured.ratio <= limit else "exceeds"
    return "within" if compare_log(measured.pair, (limit.numerator, limit.denominator)) <= 0 else "exceeds"


def _not_compared(law: Law) -> list[dict[str, Any]]:
    present: list[list[int]] = [[] for _ in law.contexts]
    for x, a in zip(law.cell_context.tolist(), law.cell_group.tolist(), strict=True):
        present[x].append(a)
    left_out: list[dict[str, Any]] = []
    for x, groups in enumerate(present):
        if len(groups) < len(law.groups):
            absent = sorted(set(range(len(law.groups))) - set(groups))
            left_out.append(
                {"context": law.context_label(x), "groups": [law.group_label(a) for a in absent], "reason": "no decisions recorded"}
            )
    left_out += [
        {"context": law.context_label(x), "reason": "fewer than two groups"} for x, groups in enumerate(present) if len(groups) < 2
    ]
    positive = {a for a, m in zip(law.cell_group.tolist(), law.cell_mass, strict=True) if m > 0}
    weightless = sorted(set(law.cell_group.tolist()) - positive)
    if weightless:
        left_out.append({"groups": [law.group_label(a) for a in weightless], "reason": "no population"})
    if not law.global_groups:
        incomplete = law.population == "equal" and not law.complete
        reason = "a group is missing in a context and no population was given" if incomplete else "fewer than two groups"
        left_out.append({"quantity": "global", "reason": reason})
    return left_out


def _left_out(entry: Mapping[str, Any]) -> dict[str, Any]:
    """An entry of `not_compared` as a certificate stores it: labels as lists."""
    stored = dict(entry)
    if "context" in entry:
        stored["context"] = list(entry["context"].values())
    if "groups" in entry:
        stored["groups"] = [list(group.values()) for group in entry["groups"]]
    return stored


def _claims(result: Result) -> list[Claim]:
    law = result.law
    claims: list[Claim] = []

    def add(
        quantity: str, value: Fraction | float, by: str, *, relation: Literal["=", "<="] = "=", evidence: Mapping[str, str] | None = None
    ) -> None:
        # The digest is filled in when the table is put into the certificate.
        claims.append(Claim(quantity, relation, value, by, evidence or {"table": ""}, assumptions=law.assumptions))

    if result.local:
        add("local_ratio", result.local.ratio, "enumeration")
    if result.global_:
        add("global_ratio", result.global_.ratio, "enumeration")
    if result.demographic_parity:
        add("demographic_parity", result.demographic_parity.value, "enumeration")
    if result.equalized_odds:
        add("equalized_odds", result.equalized_odds.value, "enumeration")
    for quantity, distance, supremum in (
        ("local_ratio_supremum", "equalized_odds", result.local_supremum),
        ("global_ratio_supremum", "demographic_parity", result.global_supremum),
    ):
        if supremum:
            r = supremum.ratio
            add(quantity, r, "T6")
            bound = Fraction(r - 1, r + 1) if isinstance(r, Fraction) else Fraction(1)
            add(distance, bound, "T7", relation="<=", evidence={"supremum": number(r)})
    if result.local and result.global_ and law.independent:
        add("global_ratio", result.local.ratio, "T5", relation="<=")
    return claims


def _ratio_entry(measured: Ratio | None) -> dict[str, Any] | None:
    if measured is None:
        return None
    witness = measured.witness
    entry: dict[str, Any] = {}
    if witness.context is not None:
        entry["context"] = witness.context
    if witness.decision is not None:
        entry["decision"] = witness.decision
    entry |= {"higher": witness.higher, "lower": witness.lower}
    entry["expectations" if witness.decision is None else "probabilities"] = [number(v) for v in witness.expectations]
    lo, hi = measured.log
    return {"ratio": number(measured.ratio), "log": [_log_text(lo), _log_text(hi)], "witness": entry}


def _log_text(value: Decimal) -> str:
    return "inf" if value.is_infinite() else format(value, "f")


def _distance_entry(measured: Distance | None) -> dict[str, Any] | None:
    if measured is None:
        return None
    witness = measured.witness
    entry: dict[str, Any] = {} if witness.context is None else {"context": witness.context}
    entry |= {"higher": witness.higher, "lower": witness.lower, "decisions": list(witness.decisions)}
    return {"value": rational_text((measured.value.numerator, measured.value.denominator)), "witness": entry}
