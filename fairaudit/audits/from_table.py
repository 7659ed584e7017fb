"""`audit`: from a table to a result in one call, as `fairaudit certify` does on the command line."""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from pathlib import Path
from typing import Any, Literal

from fairaudit.audits.audit_file import Audit, read_audit, refuse_beside
from fairaudit.audits.certify import certify
from fairaudit.audits.declared import ByContext
from fairaudit.audits.in_parts import certify_in_parts
from fairaudit.audits.origin import origin_of
from fairaudit.audits.population import confidence_for
from fairaudit.audits.proxies import audit_proxies
from fairaudit.audits.reading import (
    MOST_ROWS,
    Access,
    Reading,
    read_table_of,
    refuse_half_a_score,
    refuse_two_utilities,
    unfit_for_parts,
)
from fairaudit.audits.result import Result
from fairaudit.audits.warned import columns_warned, warned
from fairaudit.certificates.certificate import Certificate
from fairaudit.errors import InputError, ManyRowsError, naming
from fairaudit.exact.collecting import uncollected
from fairaudit.exact.rationals import Number
from fairaudit.inference.comparisons import MissingUnits
from fairaudit.inference.ends import Method
from fairaudit.inference.interval import Selection
from fairaudit.inference.levels import confidence_level
from fairaudit.measures.limits import MEASURED, without_bare_limits
from fairaudit.model.law import Law
from fairaudit.model.mechanism import Mechanism
from fairaudit.model.policy import Deployment, Policy, Population
from fairaudit.model.utility import Utility, Values, utility_values
from fairaudit.tables.binning import Bins
from fairaudit.tables.columns import Missing
from fairaudit.tables.engines.logs import Engine
from fairaudit.tables.evaluations.extraction import Errors, MissingSamples, extraction_of
from fairaudit.tables.evaluations.recipes.known import recipe_of
from fairaudit.tables.labels import LabelMap, read_label_map
from fairaudit.tables.number_form import number_form
from fairaudit.tables.scores import ABOVE, score_cut
from fairaudit.tables.sources import SameContent, Source, is_audit_file, source_name
from fairaudit.tables.values import Label, LabelLike, names
from fairaudit.tables.wide import Columns, Totals, wide_of
from fairaudit.theorems.t14 import HiddenContext
from fairaudit.words import approximate

__all__ = ["audit"]

DEFAULT_CONFIDENCE: Number = 0.95
"""Recognised by its identity, so that the same number given by the caller is one that was asked for."""

DEFAULT_SELECTION: Selection = "bonferroni"


@without_bare_limits(MEASURED)
def audit(
    source: Source | Law | Deployment,
    *,
    decision: str | None = None,
    score: str | None = None,
    above: Number | Literal["median"] | None = None,
    group: str | Sequence[str] = (),
    context: str | Sequence[str] = (),
    utility: Utility | Values | str | None = None,
    utility_column: str | None = None,
    truth: str | None = None,
    positive: LabelLike | None = None,
    count: str | None = None,
    probability: str | None = None,
    weight: str | None = None,
    wide: Columns | None = None,
    total: Totals | None = None,
    unit: str | Sequence[str] = (),
    bins: Mapping[str, Sequence[Number] | Bins] | None = None,
    missing: Missing = "error",
    unknown: str | Sequence[str] = (),
    unknown_share: Mapping[LabelLike | Label, Sequence[Number]] | None = None,
    fold_labels: bool = False,
    label_map: LabelMap | str | os.PathLike[str] | None = None,
    group_filter: Mechanism | None = None,
    context_filter: Mechanism | None = None,
    population: Population | None = None,
    releases: int = 1,
    max_local_ratio: Number | None = None,
    max_global_ratio: Number | None = None,
    max_local_log: Number | None = None,
    max_global_log: Number | None = None,
    difference: bool = False,
    max_difference: Number | None = None,
    max_global_difference: Number | None = None,
    confidence: Number | None = DEFAULT_CONFIDENCE,
    interval: Method | None = None,
    independent: bool = False,
    select: Selection = DEFAULT_SELECTION,
    missing_units: MissingUnits = "worst",
    declared: Mapping[str, Number] | None = None,
    declared_in: ByContext | None = None,
    max_drift: Number | None = None,
    hidden_context: HiddenContext | str | Sequence[Number] | None = None,
    undecided: str | Sequence[str] = (),
    all_bounds: bool = False,
    burden: bool = False,
    embed_table: bool | None = None,
    engine: Engine = "auto",
    table: str | None = None,
    query: str | None = None,
    memory: str | None = None,
    skip: int = 0,
    encoding: str | None = None,
    decimal: str | None = None,
    thousands: str | None = None,
    number_sign: str | Sequence[str] = (),
    in_parts: bool = False,
    group_probability: Source | None = None,
    log_format: str | None = None,
    extract: str | None = None,
    options: str | Sequence[str] = (),
    join: str | None = None,
    where: Mapping[str, str] | Sequence[str] = (),
    errors: Errors = "refuse",
    missing_samples: MissingSamples = "refuse",
    recipe: str | None = None,
    same_content: SameContent = "refuse",
) -> Result:
    """Audit a table: read it, measure it exactly, judge it against targets, and prepare a certificate, as `fairaudit certify` does.

    Parameters
    ----------
    source : path, paths, URL, frame, mapping, Law or Deployment
        A file or folder (CSV, Parquet, JSON lines; patterns), several of them, a database (``sqlite:FILE``, ``duckdb:FILE``,
        ``delta:FOLDER``, ``postgresql://…``), or an audit file (``.toml``), which says the rest itself; a frame of pandas, polars, pyarrow,
        DuckDB or PySpark; a mapping of column to list; or what `certify` takes.
    decision : str
        Column of what was decided; with `utility_column` it may be left out.
    score, above : str and number, optional
        Instead of `decision`: a column of numbers, and what one has to be above, ``"median"`` or a number. The decisions are ``above``,
        which is worth 1 unless `utility` says otherwise, and ``not above``; the median is that of all rows that are counted, and of it
        nothing is said of a population.
    group, context : str or sequence of str
        Columns of the sensitive attributes, several of which form intersections, and of what may legitimately matter.
    utility : mapping, str or Utility
        What a decision is worth to the person: ``{"yes": 1, "maybe": "0.5"}``, or the same as a text, ``"yes,maybe=0.5"``. Decisions that
        are not listed are worth 0.
    utility_column : str, optional
        Column of the utility of each row, instead of `utility`.
    truth, positive : str, optional
        Column of the true label, for rates of true and false positives, and which label is positive.
    count, probability, weight : str, optional
        Column of how often the row occurred; or of P(decision | context, group) and, with that, of P(context, group) up to a factor.
        Without `count`, `probability` and `wide` each row is one decision.
    wide : mapping or sequence of str, optional
        Where a row has a column of counts for each decision: the columns by decision, ``{"yes": "admitted", "no": "rejected"}``; where the
        header says the group, too, by decision and group, ``{("yes", "men"): "men_yes", …}``, and `group` says what the groups are.
    total : str, mapping of str to str, or number, optional
        With `wide`: the column of all decisions, or one for each group, so that the others are what is left; or what shares are of, 1, or
        100 for percentages, of rows that stand for `weight` decisions.
    unit : str or sequence of str
        Of a log: rows with the same label are one draw (a run, a person).
    bins : mapping of str to sequence of number, optional
        Of a log: numeric columns to cut into intervals at these edges.
    missing : {"error", "drop", "group", "unknown", "undecided"}
        What an empty label means: an error, a row to leave out, a level of its own, in a group column that the group is unknown, or of the
        decision that it may have been any, as with `undecided`.
    unknown : str or sequence of str
        Labels of group columns that name no group, such as ``["n/a", "declined"]``: of such rows the group is unknown, and targets are
        judged of this table, whoever they are.
    unknown_share : mapping of label to (number, number), optional
        Between which shares of the unknown rows are of a group, as for `certify`.
    fold_labels : bool
        Whether labels that differ in case, blanks or Unicode form alone are merged.
    label_map : mapping or path, optional
        For columns the new labels of old ones, or a TOML file that says so (`merge_labels`).
    group_filter, context_filter : Mechanism, optional
        The table is a policy behind these filters (`Policy.behind`): what decides sees what they release.
    population : array_like, mapping or Law, optional
        With `group_filter`: P(context, group).
    releases : int
        With `group_filter`: how many fresh releases of a group one memory sees.
    max_local_ratio, max_global_ratio, max_local_log, max_global_log, max_difference, max_global_difference
        Targets, as for `certify`.
    difference : bool
        Whether to state differences of expected utilities, too, which may then be negative, as for `certify`.
    confidence, interval, independent, select, missing_units, declared, declared_in, max_drift, hidden_context, undecided
        As for `certify`.
    all_bounds, burden, embed_table
        As for `certify`. A confidence that is given needs counts; without one, a table that has none is judged as it stands.
    engine, table, query, memory, skip, same_content, encoding
        As for `read_log`.
    decimal, thousands : str, optional
        The decimal mark of numbers in texts, ``"."`` or ``","``, and what separates groups of three digits, ``"."``, ``","``, ``"'"`` or
        ``" "``. Numbers such as ``1.306`` and ``1,306`` are refused where nothing says which of the two a mark is.
    number_sign : str or sequence of str
        Signs that numbers bear: ``"%"`` for hundredths, or a currency such as ``"€"``.
    in_parts : bool
        Whether to read some contexts at a time, in little memory; done anyway beyond 20 million different rows.
    group_probability : Source, optional
        Where no row has its group: P(group | cell), a table with columns of the cell, as `source` has them, of the group, and
        ``probability``, or ``low`` and ``high`` (docs/proxies.md).
    log_format : str, optional
        The format of an evaluation log, where its content does not say it: ``"inspect"``, ``"lm-eval"`` and so on (docs/evaluations.md).
    extract : str, optional
        A regular expression: the decision is the first group of exactly one match in the answer.
    options : str or sequence of str, optional
        What there was to choose: the decision is the option that an answer in words (or what `extract` takes out of it) clearly chooses,
        and otherwise ``unreadable``. A text names options between commas: ``"yes,no"``.
    join : str, optional
        Rows of another file that belong to samples, ``"FILE:COLUMN"``.
    where : mapping of str to str, or sequence of str
        The samples that count: paths with the text that each must have, or texts ``"PATH=VALUE"``.
    errors : {"refuse", "drop", "bound"}
        What becomes of samples without an answer: an error, left out and stated, or decisions that may have meant anything.
    missing_samples : {"refuse", "accept"}
        What becomes of a log that holds fewer samples than it should.
    recipe : str, optional
        A known data set, whose rows are made as its authors count them, and after a colon the path of the answers: ``"bbq:answer"``. Its
        columns take their roles unless others are named (docs/benchmarks.md).

    Returns
    -------
    Result
        What `certify` returns: exact measures with witnesses, intervals, claims, verdict and certificate. With `group_probability` a
        `fairaudit.audits.proxies.ProxyAudit`: ranges with witnesses, verdict and certificate.

    Raises
    ------
    InputError
        If the table cannot be read, columns do not fit their roles, or as `certify`.

    Examples
    --------
    >>> table = {"hired": ["yes", "no", "yes", "no"], "sex": ["f", "f", "m", "m"], "n": [300, 100, 200, 200]}
    >>> result = audit(table, decision="hired", group="sex", count="n", utility="yes", max_local_ratio="5/4")
    >>> result.local.ratio, result.verdict
    (Fraction(3, 2), 'exceeds')

    References
    ----------
    docs/theory.md; the certificate is docs/certificate.md.
    """
    limits = {
        "max_local_ratio": max_local_ratio,
        "max_global_ratio": max_global_ratio,
        "max_local_log": max_local_log,
        "max_global_log": max_global_log,
        "max_difference": max_difference,
        "max_global_difference": max_global_difference,
    }
    signed = difference or max_difference is not None or max_global_difference is not None
    if recipe is not None:
        made = recipe_of(recipe)
        decision, group, context, unit = decision or made.decision, group or made.group, context or made.context, unit or made.unit
        utility = made.utility if utility is None and utility_column is None else utility
    roles: dict[str, Any] = {
        "decision": decision,
        "group": names(group),
        "context": names(context),
        "bins": bins or {},
        "truth": truth,
        "count": count,
        "probability": probability,
        "weight": weight,
        "wide": wide_of(wide, total),
        "unit": names(unit),
        "utility_column": utility_column,
        "above": None if above is None else score_cut(above),
        "fold_labels": fold_labels,
        "label_map": read_label_map(Path(label_map)) if isinstance(label_map, (str, os.PathLike)) else label_map,
    }
    filters: dict[str, Any] = {
        "group_filter": group_filter,
        "context_filter": context_filter,
        "population": population,
        "releases": releases,
    }
    refuse_half_a_score(score, above, decision)
    utility = {ABOVE: 1} if score is not None and utility is None and utility_column is None else utility
    values = utility_values(utility) if isinstance(utility, str) else utility
    given = Utility(values, signed=signed) if isinstance(values, Mapping) else values
    asked = _Asked(
        targets={name: limit for name, limit in limits.items() if limit is not None},
        confidence=None if confidence is None else confidence_level(confidence),
        default=confidence is DEFAULT_CONFIDENCE,  # the object itself: whoever gives 0.95 asks for it
        interval=interval,
        independent=independent,
        select=select,
        missing_units=missing_units,
        declared=declared or {},
        declared_in={names(label): constants for label, constants in (declared_in or {}).items()},
        max_drift=max_drift,
        hidden_context=hidden_context,
        undecided=names(undecided),
        all_bounds=all_bounds,
        positive=positive,
        burden=burden,
        embed_table=embed_table,
        difference=difference,
        unknown_share=unknown_share,
    )
    beside = {**roles, "missing": missing != "error", "table": table, "query": query, "in_parts": in_parts, "skip": skip}
    beside |= {"same_content": same_content != "refuse"}
    beside |= {"encoding": encoding, "decimal": decimal, "thousands": thousands, "number_sign": number_sign}
    beside |= {"group_probability": group_probability is not None, "unknown": bool(unknown)}
    extraction = extraction_of(
        log_format=log_format,
        extract=extract,
        options=options,
        join=join,
        where=where,
        errors=errors,
        missing_samples=missing_samples,
        recipe=recipe,
    )
    beside |= extraction.asked
    if isinstance(source, (Law, Deployment)):
        for name, value in beside.items():
            if value:
                raise InputError(f"{name} goes with a table; a {type(source).__name__} has been read already")
        return asked.certify(_behind(source, **filters), _needed(given))
    if isinstance(source, (str, os.PathLike)) and is_audit_file(source):
        refuse_beside(os.fspath(source), {**beside, **filters, "releases": releases != 1, "utility": utility, "positive": positive})
        origin = origin_of(source)
        described = read_audit(os.fspath(source), signed=signed)
        result = _from_audit_file(described, asked)
        return replace(result, origin=origin, warnings=warned(result, described.utility))
    named = decision or score or utility_column or (None if wide is None else "decision")
    _refuse_unnamed(source, named, roles["group"])
    refuse_two_utilities(utility, utility_column)
    roles["decision"] = named
    _refuse_shares_of_nobody(unknown_share, unknown=bool(unknown) or missing == "unknown")
    form = number_form(decimal, thousands, number_sign)
    reached = Access(engine, table, query, memory, skip, extraction, same_content=same_content, encoding=encoding, form=form)
    reading = Reading(**roles, missing=missing, unknown=names(unknown), signed=signed, access=reached)
    if utility_column is None:
        _needed(given)
    if group_probability is not None:
        others_ = {
            "wide": wide,
            "score": score,
            **filters,
            "releases": releases != 1,
            "difference": signed,
            "declared_in": declared_in,
            "in_parts": in_parts,
        }
        proxied: Result = asked.certify_by_proxies(source, reading, given, group_probability, others_)
        return proxied
    of_policies = {"declared_in": declared_in, "max_drift": max_drift, "all_bounds": all_bounds, **filters, "releases": releases != 1}
    others: dict[str, object] = {
        "declared": declared,
        "hidden_context": hidden_context,
        "undecided": bool(undecided),
        "difference": signed,
        "select": select != DEFAULT_SELECTION,
        "missing_units": missing_units != "worst",
    }
    unfit = unfit_for_parts(reading, {"positive": positive, **others, **of_policies})
    if not isinstance(source, (str, os.PathLike, list, tuple)):
        unfit = "a table in memory"
    if in_parts and unfit:
        raise InputError(f"in_parts does not go with {unfit}")
    origin = origin_of(source, reading, given, positive=positive, again=group_filter is None)
    with uncollected():
        if not in_parts:
            try:
                table_, law, read = read_table_of(source, reading, given, most=None if unfit else MOST_ROWS)
                of_columns = columns_warned(source, reading, table_, law)
                del table_
            except ManyRowsError:
                pass
            else:
                with naming(_name(source)):
                    result = asked.certify(_behind(law, **filters), read)
                    return replace(result, origin=origin, warnings=warned(result, read, of_columns=of_columns))
        with naming(_name(source)):
            result = asked.certify_in_parts(source, _needed(given), reading)
            return replace(result, origin=origin, warnings=warned(result, _needed(given)))


def _refuse_unnamed(source: object, decision: str | None, group: Sequence[str]) -> None:
    """Refuse what is no table, and a table of which no decision or no group is named."""
    if isinstance(source, (Result, Certificate)):
        kind = type(source).__name__
        raise InputError(f"a {kind} is of an audit that was made already; give the table, or verify, compare and report what there is")
    if decision is None:
        raise InputError("no decision column was named; give decision, the name of the column")
    if not group:
        raise InputError("no group column was named; give group, the name of one column or of several")


def _refuse_shares_of_nobody(shares: Mapping[Any, Any] | None, *, unknown: bool) -> None:
    """Refuse shares where no label names no group."""
    if shares and not unknown:
        raise InputError("unknown_share goes with unknown, the labels that name no group, or missing='unknown'")


@dataclass(frozen=True)
class _Asked:
    """What is asked of a law."""

    targets: Mapping[str, Any]
    confidence: Fraction | None
    default: bool
    interval: Method | None
    independent: bool
    select: Selection
    missing_units: MissingUnits
    declared: Mapping[str, Number]
    declared_in: Mapping[Label, Mapping[str, Number]]
    max_drift: Number | None
    hidden_context: HiddenContext | str | Sequence[Number] | None
    undecided: Sequence[str]
    all_bounds: bool
    positive: LabelLike | None
    burden: bool
    embed_table: bool | None
    difference: bool = False
    unknown_share: Mapping[LabelLike | Label, Sequence[Number]] | None = None

    def certify(self, subject: Law | Deployment, utility: Utility) -> Result:
        """Certify what is held in memory."""
        asked = None if self.default or self.confidence is None else approximate(self.confidence)
        others = {
            "interval": self.interval is not None,
            "independent": self.independent,
            "select": self.select != DEFAULT_SELECTION,
            "missing_units": self.missing_units != "worst",
        }
        confidence = confidence_for(subject, self.confidence, asked, others)
        return certify(
            subject,
            utility,
            **self.targets,
            confidence=confidence,
            interval=self.interval,
            independent=self.independent,
            select=self.select,
            missing_units=self.missing_units,
            declared=self.declared,
            declared_in=self.declared_in,
            max_drift=self.max_drift,
            hidden_context=self.hidden_context,
            undecided=self.undecided,
            all_bounds=self.all_bounds,
            positive=self.positive,
            burden=self.burden,
            embed_table=self.embed_table,
            difference=self.difference,
            unknown_share=self.unknown_share,
        )

    def certify_by_proxies(
        self, source: Source, reading: Reading, utility: Utility | None, probabilities: Source, others: Mapping[str, object]
    ) -> Any:
        """Certify what groups can get that no row names."""
        given = {
            **others,
            "confidence": not self.default and self.confidence is not None,
            "interval": self.interval,
            "independent": self.independent,
            "select": self.select != DEFAULT_SELECTION,
            "missing_units": self.missing_units != "worst",
            "declared": self.declared,
            "max_drift": self.max_drift,
            "undecided": self.undecided,
            "all_bounds": self.all_bounds,
            "positive": self.positive,
            "burden": self.burden,
            "unknown": bool(reading.unknown) or reading.missing == "unknown",
            "unknown_share": self.unknown_share,
        }
        for name, value in given.items():
            if value:
                raise InputError(f"{name} does not go with group_probability")
        return audit_proxies(source, reading, utility, probabilities, limits=self.targets, embed=self.embed_table)

    def certify_in_parts(self, source: Any, utility: Utility, reading: Reading) -> Result:
        """Certify a log some contexts at a time."""
        return certify_in_parts(
            source,
            utility,
            decision=reading.decision,
            group=reading.group,
            context=reading.context,
            bins=reading.bins,
            table=reading.access.table,
            memory=reading.access.memory,
            **self.targets,
            confidence=self.confidence,
            interval=self.interval,
            independent=self.independent,
            embed_table=self.embed_table,
            burden=self.burden,
            count=reading.count,
            missing=reading.missing if reading.missing in ("drop", "group") else "error",
        )


def _from_audit_file(audit: Audit, asked: _Asked) -> Result:
    """Certify what an audit file describes; what was asked for in the call comes before what it says."""
    sampling = dict(audit.sampling)
    level = sampling.get("confidence")
    if asked.default and level is not None:
        asked = replace(asked, confidence=None if level == "none" else confidence_level(level), default=False)
    said: dict[str, Any] = {
        "targets": {**audit.targets, **asked.targets},
        "interval": sampling.get("interval") if asked.interval is None else asked.interval,
        "independent": asked.independent or sampling.get("independent", False),
        "select": sampling.get("select", DEFAULT_SELECTION) if asked.select == DEFAULT_SELECTION else asked.select,
        "missing_units": sampling.get("missing_units", "worst") if asked.missing_units == "worst" else asked.missing_units,
        "declared": {**audit.declared, **asked.declared},
        "declared_in": {**audit.declared_in, **asked.declared_in},
        "max_drift": audit.max_drift if asked.max_drift is None else asked.max_drift,
        "hidden_context": audit.hidden_context if asked.hidden_context is None else asked.hidden_context,
        "undecided": asked.undecided or audit.undecided,
        "positive": audit.positive,
        "burden": asked.burden or audit.burden,
        "difference": asked.difference or audit.difference,
        "unknown_share": asked.unknown_share or audit.unknown_share,
    }
    return replace(asked, **said).certify(audit.subject, audit.utility)


def _behind(
    subject: Law | Deployment,
    group_filter: Mechanism | None,
    context_filter: Mechanism | None,
    population: Population | None,
    releases: int,
) -> Law | Deployment:
    """Put a law behind filters, as the policy that it is."""
    if group_filter is None:
        if context_filter is not None or population is not None or releases != 1:
            raise InputError("context_filter, population and releases go with group_filter; give an Identity if groups are not filtered")
        return subject
    if isinstance(subject, Deployment):
        raise InputError("group_filter goes with a table or a law; a Deployment has its filters")
    return Policy(subject).behind(group=group_filter, context=context_filter, population=population, releases=releases)


def _needed(utility: Utility | None) -> Utility:
    if utility is None:
        raise InputError("no utility was given; give utility, such as {'yes': 1}, or utility_column")
    return utility


def _name(source: object) -> str | None:
    """Name of a file or database; tables in memory have none."""
    return source_name(source) if isinstance(source, (str, os.PathLike, list, tuple)) else None
