"""`AUDIT.toml`: a table or a policy with its filters, population, utility, declared constants and targets, in one file."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any, get_args

from fairaudit.audits.reading import Access, read_table, read_text_table
from fairaudit.audits.sections import ATTESTATION_KEYS, check_targets
from fairaudit.errors import InputError, naming, nearest, shown
from fairaudit.exact.rationals import Number
from fairaudit.files import check_keys, read_one_of, read_section, read_text, read_toml
from fairaudit.inference.comparisons import MissingUnits
from fairaudit.inference.ends import Method
from fairaudit.inference.interval import Selection
from fairaudit.measures.limits import DIFFERENCE_LIMITS
from fairaudit.model.law import Law
from fairaudit.model.mechanism import Constant, Identity, Mechanism, Product, RandomizedResponse
from fairaudit.model.policy import Deployment, Policy, policy_source
from fairaudit.model.releases import check_releases
from fairaudit.model.utility import Utility
from fairaudit.tables.columns import Missing
from fairaudit.tables.csv import CsvTable, read_csv
from fairaudit.tables.engines.logs import read_log
from fairaudit.tables.engines.paths import form
from fairaudit.tables.evaluations.extraction import NAMES
from fairaudit.tables.labels import merge_labels, read_label_map, spelt_alike
from fairaudit.tables.number_form import TEXT_FORM, NumberKind, number_form
from fairaudit.tables.sources import Table
from fairaudit.tables.tally import Tally
from fairaudit.tables.values import Label, LabelLike, column, names

__all__ = ["SAID_THERE", "Audit", "audit_of", "read_audit", "read_policy", "refuse_beside"]

SECTIONS = ("law", "policy", "filter", "population", "utility", "targets", "confidence", "attestation")
TABLE_KEYS = ("table", "decision", "group", "context", "count", "probability", "weight", "missing", "fold_labels", "map", *TEXT_FORM)
PLUGIN_KEYS = ("plugin", "files", "options", "trials", "max_drift")
LAW_KEYS = (*TABLE_KEYS, "unit", "truth", "positive", "unknown", "unknown_share", "hidden_context", *NAMES)
FILTER_KEYS = ("kind", "values", "keep_probability", "epsilon", "exp_epsilon", "table", "output")
METHODS: tuple[Method, ...] = get_args(Method)
SELECTIONS: tuple[Selection, ...] = get_args(Selection)
MISSING: tuple[Missing, ...] = get_args(Missing)
MISSING_UNITS: tuple[MissingUnits, ...] = get_args(MissingUnits)
KINDS = ("randomized-response", "table", "identity", "constant", "product")
DECLARED = ("gamma", "m", "tau", "global_tau", "lipschitz")
UTILITY_KEYS = ("values", "column", "table", *DECLARED, "by_context", "burden", "difference", "undecided")


@dataclass(frozen=True)
class Audit:
    """What an audit file asks for."""

    subject: Law | Deployment
    utility: Utility
    declared: dict[str, Any]
    targets: dict[str, Any]
    sampling: dict[str, Any]
    positive: str | None = None
    burden: bool = False
    declared_in: dict[Label, dict[str, Any]] = field(default_factory=dict)
    max_drift: Any = None
    difference: bool = False
    unknown_share: Mapping[LabelLike | Label, Sequence[Number]] = field(default_factory=dict)
    hidden_context: Any = None
    undecided: tuple[str, ...] = ()


SAID_THERE = (
    "decision",
    "score",
    "above",
    "group",
    "context",
    "truth",
    "count",
    "probability",
    "weight",
    "wide",
    "total",
    "utility",
    "utility_column",
    "positive",
    "unit",
)
"""Options that an audit file takes the place of."""


def refuse_beside(path: str, given: Mapping[str, object], spelled: Callable[[str], str] = str) -> None:
    """Refuse options that an audit file takes the place of.

    Parameters
    ----------
    path : str
        The audit file.
    given : mapping of str to object
        Options by name; None, false or empty if they were not given.
    spelled : callable
        How options are written, for messages.

    Raises
    ------
    InputError
        If one was given.
    """
    for name, value in given.items():
        if value:
            why = "the audit file has missing in [law] or [policy]" if name == "missing" else f"the audit file {path} says it itself"
            raise InputError(f"{spelled(name)} goes with a table; {why}")


def read_audit(path: str, *, signed: bool = False) -> Audit:
    """Read an audit file; paths in it are relative to it, and numbers are exact as written.

    Parameters
    ----------
    path : str
        The file.
    signed : bool
        Whether differences are asked for besides what the file says, so that utilities may be negative.

    Raises
    ------
    InputError
        If the file is not of the form; the message names the file and the key.
    """
    document = read_toml(Path(path))[0]
    try:
        return _audit(document, Path(path).parent, signed=signed)
    except InputError as error:
        raise InputError(f"{path}: {error}") from None


def audit_of(document: Mapping[str, Any], *, signed: bool = False) -> Audit:
    """Read the sections of an audit file that are there already; paths in them are as they stand.

    Raises
    ------
    InputError
        As in `read_audit`, and if a plug-in supplies the policy: what another has written runs no code here.
    """
    if "plugin" in read_section(document, "policy"):
        raise InputError("[policy] plugin: what a plug-in supplies is no table that is counted again; certify the audit file anew")
    return _audit(document, Path(), signed=signed)


def read_policy(path: str) -> tuple[Policy, Utility, Any]:
    """Read policy, utility and population of an audit file whose filter is yet to be found; filters and targets in it are passed over.

    Raises
    ------
    InputError
        As in `read_audit`, and if it has no policy.
    """
    document = read_toml(Path(path))[0]
    folder = Path(path).parent
    try:
        check_keys(document, SECTIONS, "the file")
        if "policy" not in document:
            raise InputError("a section [policy] is needed")
        source = read_section(document, "policy")
        releases = _releases(read_section(read_section(document, "filter"), "group"))[1]
        if releases > 1:
            raise InputError(
                f"[filter.group] releases is {releases}, and a filter is looked for that is released once; "
                "leave it out, or see with fairaudit privacy --releases what several releases of a filter let a policy do"
            )
        table, law = _source(source, "policy", folder)
        utility = _utility(read_section(document, "utility"), table, law, folder, _missing(source, "policy"))
        return Policy(law), utility, _population(read_section(document, "population"), law, folder)
    except InputError as error:
        raise InputError(f"{path}: {error}") from None


def _audit(document: Mapping[str, Any], folder: Path, *, signed: bool) -> Audit:
    check_keys(document, SECTIONS, "the file")
    sections = {name: read_section(document, name) for name in SECTIONS}
    check_keys(sections["attestation"], ATTESTATION_KEYS, "[attestation]")
    if ("law" in document) == ("policy" in document):
        raise InputError("exactly one of the sections [law] and [policy] is needed")
    about = "law" if "law" in document else "policy"
    source = sections[about]
    table, law = _source(source, about, folder, _columns(sections["utility"], "column", "utility"))
    subject: Law | Deployment = law
    if about == "policy":
        filters = sections["filter"]
        check_keys(filters, ("group", "context"), "[filter]")
        if "group" not in filters:
            raise InputError('a policy needs a section [filter.group]; kind = "identity" if there is no filter')
        section, releases = _releases(filters["group"])
        group = _filter(section, "filter.group", law.columns.group, law.groups, folder)
        context = _filter(filters["context"], "filter.context", law.columns.context, law.contexts, folder) if "context" in filters else None
        population = _population(sections["population"], law, folder)
        subject = Policy(law).behind(group=group, context=context, population=population, releases=releases)
    else:
        for name in ("filter", "population"):
            if sections[name]:
                raise InputError(f"[{name}] goes with [policy]; [law] is the law after any filter")
    wanted = sections["utility"]
    check_keys(wanted, UTILITY_KEYS, "[utility]")
    targets = sections["targets"]
    check_targets(targets, differences=True)
    difference = signed or _truth(wanted, "difference", "utility") or bool(targets.keys() & DIFFERENCE_LIMITS.keys())
    utility = _utility(wanted, table, law, folder, _missing(source, about), signed=difference)
    declared = {name: wanted[name] for name in DECLARED if name in wanted}
    positive = _text(source, "positive", about) if "positive" in source else None
    return Audit(
        subject,
        utility,
        declared,
        dict(targets),
        _sampling(sections["confidence"]),
        positive,
        _truth(wanted, "burden", "utility"),
        _declared_in(wanted.get("by_context", [])),
        source.get("max_drift"),
        difference,
        _unknown_share(source, about),
        source.get("hidden_context"),
        _texts(wanted, "undecided", "utility", "a label"),
    )


def _declared_in(entries: Any) -> dict[Label, dict[str, Any]]:
    """Constants of single contexts: sections [[utility.by_context]]."""
    if not isinstance(entries, list) or not all(isinstance(entry, dict) for entry in entries):
        raise InputError(f"[utility] by_context is {shown(entries)}; sections [[utility.by_context]] with context, and gamma, m or tau")
    found: dict[Label, dict[str, Any]] = {}
    for entry in entries:
        check_keys(entry, ("context", "gamma", "m", "tau"), "[[utility.by_context]]")
        label = _texts(entry, "context", "[utility.by_context]", 'a label in quotes, such as "7",')
        if not label:
            raise InputError('[[utility.by_context]] needs context = "…", or a list where there are several columns')
        if label in found:
            raise InputError(f"[[utility.by_context]] has the context {shown(', '.join(label))} twice")
        found[label] = {name: value for name, value in entry.items() if name != "context"}
    return found


def _sampling(section: Mapping[str, Any]) -> dict[str, Any]:
    """What [confidence] says of the population behind counts."""
    check_keys(section, ("level", "interval", "independent_cells", "select", "missing_units"), "[confidence]")
    found: dict[str, Any] = {"confidence": section["level"]} if "level" in section else {}
    if "interval" in section:
        found["interval"] = read_one_of(section, "interval", METHODS, "[confidence]")
    if "independent_cells" in section:
        found["independent"] = _truth(section, "independent_cells", "confidence")
    if "select" in section:
        found["select"] = read_one_of(section, "select", SELECTIONS, "[confidence]")
    if "missing_units" in section:
        found["missing_units"] = read_one_of(section, "missing_units", MISSING_UNITS, "[confidence]")
    return found


def _truth(section: Mapping[str, Any], key: str, where: str) -> bool:
    value = section.get(key, False)
    if not isinstance(value, bool):
        raise InputError(f"[{where}] {key} is {shown(value)}; true or false is accepted")
    return value


def _text(section: Mapping[str, Any], key: str, where: str) -> str:
    return read_text(section, key, f"[{where}]")


def _columns(section: Mapping[str, Any], key: str, where: str) -> tuple[str, ...]:
    return _texts(section, key, where, "a column name")


def _texts(section: Mapping[str, Any], key: str, where: str, accepted: str) -> tuple[str, ...]:
    value = section.get(key, ())
    listed = [value] if isinstance(value, str) else list(value) if isinstance(value, (list, tuple)) else [None]
    if not all(isinstance(name, str) for name in listed):
        raise InputError(f"[{where}] {key} must be {accepted} or a list of them, not {shown(value)}")
    return tuple(listed)


def _source(section: Mapping[str, Any], where: str, folder: Path, valued: tuple[str, ...] = ()) -> tuple[Table | None, Law]:
    """The law of [law] or [policy], with the table from which it was read; of a policy that a plug-in supplies there is none."""
    if where == "policy" and "plugin" in section:
        check_keys(section, PLUGIN_KEYS, "[policy] with plugin")
        files, options, trials = read_section(section, "files"), read_section(section, "options"), section.get("trials", 50)
        if not isinstance(trials, int) or isinstance(trials, bool) or trials < 1:
            raise InputError(f"[policy] trials is {shown(trials)}; a whole number of at least 1 is accepted")
        named = {key: str(folder / _text(files, key, "policy.files")) for key in files}
        return None, Policy.from_source(policy_source(_text(section, "plugin", "policy"), **{**options, **named}), trials).law
    check_keys(section, (*(LAW_KEYS if where == "law" else TABLE_KEYS), "max_drift"), f"[{where}]")
    table = _table(section, where, folder, valued)
    return table, _law(section, where, table)


def _table(section: Mapping[str, Any], where: str, folder: Path, valued: tuple[str, ...] = ()) -> Table:
    fold = section.get("fold_labels", False)
    if not isinstance(fold, bool):
        raise InputError(f"[{where}] fold_labels is {shown(fold)}; true or false is accepted")
    table, label_map = _read_table(section, where, folder, valued), None
    if "map" in section:
        label_map = read_label_map(folder / _text(section, "map", where))
    labelled = [name for key in ("decision", "group", "context", "truth") for name in _columns(section, key, where)]
    return merge_labels(table, labelled, fold=fold, label_map=label_map) if fold or label_map else table


def _read_table(section: Mapping[str, Any], where: str, folder: Path, valued: tuple[str, ...]) -> CsvTable | Tally:
    path = folder / _text(section, "table", where)
    samples = _samples(section, where, folder)
    keys = ("decision", "group", "context", "truth", "unit", "count", "probability", "weight")
    if any(key in section for key in TEXT_FORM):
        written: CsvTable | Tally = _as_written(path, section, where, keys, valued)
        return written
    if (path.is_file() or path.is_dir()) and (samples or form(str(path)) != "csv"):
        roles: dict[str, Any] = {key: _columns(section, key, where) for key in ("group", "unit")} | {"count": section.get("count")}
        wanted = [*(name for key in keys for name in _columns(section, key, where)), *valued]
        return read_log(path, wanted, decision=_text(section, "decision", where), **roles, **samples)
    numeric = [str(section[key]) for key in ("count", "probability", "weight") if key in section]
    if "count" not in section and "probability" not in section:
        return read_csv(path).with_numbers(numeric)
    wanted = [*(name for key in keys[:5] for name in _columns(section, key, where)), *numeric, *valued]
    found = read_text_table(path, list(dict.fromkeys(wanted)), numeric, count=section.get("count"))
    with naming(found.name):
        for name in wanted:
            column(dict.fromkeys(found.columns, ()), name)
        return found.with_numbers(numeric)


def _as_written(path: Path, section: Mapping[str, Any], where: str, keys: tuple[str, ...], valued: tuple[str, ...]) -> Any:
    """A table of which the file says how its characters or numbers are written."""
    extracted = next((key for key in NAMES if key in section), None)
    if extracted is not None:
        raise InputError(f"[{where}] {extracted} is of an evaluation log, whose texts and numbers need none of {', '.join(TEXT_FORM)}")
    texts = {key: _text(section, key, where) for key in TEXT_FORM[:3] if key in section}
    signs = _texts(section, "number_sign", where, "a sign such as %")
    form = number_form(texts.get("decimal"), texts.get("thousands"), signs, spelled=lambda key: f"[{where}] {key}")
    amounts: dict[str, NumberKind] = {name: "amount" for key in ("count", "weight") for name in _columns(section, key, where)}
    shares: dict[str, NumberKind] = dict.fromkeys(_columns(section, "probability", where), "share")
    wanted = list(dict.fromkeys((*(name for key in keys for name in _columns(section, key, where)), *valued)))
    numbers: dict[str, NumberKind] = dict.fromkeys((name for name in valued if name != section.get("decision")), "label")
    access = Access(encoding=texts.get("encoding"), form=form)
    plain = "count" in section or "probability" in section
    return read_table(str(path), wanted, {}, {**numbers, **amounts, **shares}, access, plain=plain)


def _samples(section: Mapping[str, Any], where: str, folder: Path) -> dict[str, Any]:
    """What is asked of an evaluation log."""
    found: dict[str, Any] = {key: _text(section, key, where) for key in NAMES if key in section and key not in ("where", "options")}
    if "options" in section:
        given = section["options"]
        found["options"] = given if isinstance(given, str) else _texts(section, "options", where, "texts such as yes,no")
    if "where" in section:
        conditions = section["where"]
        if not isinstance(conditions, dict) or not all(isinstance(text, str) for text in conditions.values()):
            raise InputError(
                f'[{where}] where is {shown(conditions)}; a table of paths and texts such as {{"filter" = "first"}} is accepted'
            )
        found["where"] = conditions
    if "join" in found:
        found["join"] = str(folder / found["join"])
    return found


def _law(section: Mapping[str, Any], where: str, table: Table) -> Law:
    columns: dict[str, Any] = {
        "decision": _text(section, "decision", where),
        "group": _columns(section, "group", where),
        "context": _columns(section, "context", where),
    }
    if "count" in section and "probability" in section:
        raise InputError(f"[{where}] has both count and probability; give one, or neither for a log")
    if "weight" in section and ("probability" not in section or where == "policy"):
        raise InputError(f"[{where}] has weight, which goes with probability in [law]; the population of a policy is in [population]")
    unit = _columns(section, "unit", where)
    if unit and ("count" in section or "probability" in section):
        raise InputError(f"[{where}] has unit, which goes with a log; counts do not say which rows belong together")
    if "truth" in section and "probability" in section:
        raise InputError(f"[{where}] has truth, which goes with counts and logs; probabilities do not say what should have been decided")
    truth = _text(section, "truth", where) if "truth" in section else None
    missing, unknown = _missing(section, where), _texts(section, "unknown", where, "a label")
    if section.get("fold_labels"):
        unknown = spelt_alike(table, columns["group"], unknown)
    if "count" in section:
        count = _text(section, "count", where)
        return Law.from_counts(table, **columns, count=count, truth=truth, missing=missing, unknown=unknown)
    if "probability" in section:
        weight = _text(section, "weight", where) if "weight" in section else None
        probability = _text(section, "probability", where)
        return Law.from_probabilities(table, **columns, probability=probability, weight=weight, missing=missing)
    return Law.from_log(table, **columns, unit=unit, truth=truth, missing=missing, unknown=unknown)


def _unknown_share(section: Mapping[str, Any], where: str) -> Mapping[LabelLike | Label, Sequence[Number]]:
    """Declared shares of rows of unknown group: a table of label and two numbers; labels of several columns are joined by "/"."""
    value = section.get("unknown_share", {})
    if not isinstance(value, dict) or not all(isinstance(ends, list) and len(ends) == 2 for ends in value.values()):
        raise InputError(f'[{where}] unknown_share is {shown(value)}; a table such as {{f = ["0.4", "0.6"]}} is accepted')
    return {label: tuple(ends) for label, ends in value.items()}


def _missing(section: Mapping[str, Any], where: str) -> Missing:
    """What becomes of rows with empty labels; they are refused unless the section says otherwise."""
    return read_one_of(section, "missing", MISSING, f"[{where}]", "error")


def _filter(section: Any, where: str, columns: tuple[str, ...], labels: tuple[Label, ...], folder: Path) -> Mechanism:
    if not isinstance(section, dict):
        raise InputError(f"{where} must be a section [{where}], not {shown(section)}")
    kind = read_one_of({"kind": _text(section, "kind", where)}, "kind", KINDS, f"[{where}]")
    if kind == "product":
        check_keys(section, ("kind", *columns), f"[{where}]")
        lost = [name for name in columns if name not in section]
        if lost:
            raise InputError(f"[{where}] needs a section [{where}.{lost[0]}], one for each column")
        alphabets = {name: tuple((text,) for text in dict.fromkeys(label[i] for label in labels)) for i, name in enumerate(columns)}
        return Product({name: _filter(section[name], f"{where}.{name}", (name,), alphabets[name], folder) for name in columns})
    check_keys(section, FILTER_KEYS, f"[{where}]")
    values = _values(section["values"], where) if "values" in section else list(labels)
    try:
        return _simple_filter(kind, section, where, values, folder)
    except InputError as error:
        raise InputError(f"[{where}]: {error}") from None


def _releases(section: Any) -> tuple[Any, int]:
    """The section of a group filter without the key that says how many releases one memory sees, and their number."""
    if not isinstance(section, dict) or isinstance(section.get("releases", {}), dict):  # a column may have that name
        return section, 1
    rest = {name: value for name, value in section.items() if name != "releases"}
    try:
        return rest, check_releases(section["releases"])
    except InputError as error:
        raise InputError(f"[filter.group]: {error}") from None


def _values(value: Any, where: str) -> list[Label]:
    if not isinstance(value, list):
        raise InputError(f"[{where}] values must be a list, not {shown(value)}")
    return [names(part) if isinstance(part, str) else tuple(map(str, part)) if isinstance(part, list) else (str(part),) for part in value]


def _simple_filter(kind: str, section: Mapping[str, Any], where: str, values: list[Label], folder: Path) -> Mechanism:
    if kind == "table":
        from fairaudit.model.mechanism_file import read_mechanism

        # The columns of the file are named after what it holds, input and output; the policy's own names count.
        return replace(read_mechanism(folder / _text(section, "table", where)), columns=())
    if kind == "identity":
        return Identity(values)
    if kind == "constant":
        return Constant(values, section.get("output"))
    given = {name: section[name] for name in ("keep_probability", "epsilon", "exp_epsilon") if name in section}
    return RandomizedResponse(values, **given)


def _population(section: Mapping[str, Any], law: Law, folder: Path) -> dict[tuple[Label, Label], Any] | None:
    if not section:
        return None
    check_keys(section, ("table", "group", "context", "weight"), "[population]")
    table = read_csv(folder / _text(section, "table", "population"))
    weight = _text(section, "weight", "population")
    table = table.with_numbers([weight])
    groups = _columns(section, "group", "population") or law.columns.group
    contexts = _columns(section, "context", "population") or law.columns.context
    for name in (*groups, *contexts, weight):
        if name not in table.columns:
            raise InputError(f"[population]: there is no column {shown(name)}; {nearest(name, table.columns)}")
    masses: dict[tuple[Label, Label], Any] = {}
    for position in range(len(table)):
        key = (tuple(table[name][position] for name in contexts), tuple(table[name][position] for name in groups))
        if key in masses:
            raise InputError(f"[population] {table.locate(position)}: context and group occur a second time; each pair has one row")
        masses[key] = table[weight][position]
    return masses


def _utility(section: Mapping[str, Any], table: Table | None, law: Law, folder: Path, missing: Missing, *, signed: bool = False) -> Utility:
    given = [key for key in ("values", "column", "table") if key in section]
    if len(given) != 1:
        raise InputError("[utility] needs exactly one of values, column and table")
    if given == ["values"]:
        values = section["values"]
        if not isinstance(values, dict):
            raise InputError("[utility] values must be a table such as {Admitted = 1}")
        return Utility(values, signed=signed)
    columns = law.columns
    if given == ["column"]:
        if table is None:
            raise InputError("[utility] column goes with a table; a policy that a plug-in supplies has none: give values, or a table")
        return Utility.from_table(
            table.with_numbers([section["column"]]) if isinstance(table, CsvTable) else table,
            utility=_text(section, "column", "utility"),
            decision=columns.decision,
            group=columns.group,
            context=columns.context,
            missing=missing,
            signed=signed,
        )
    values_table = read_csv(folder / _text(section, "table", "utility"))
    for name in (columns.decision, *columns.group, *columns.context, "utility"):
        if name not in values_table.columns:
            raise InputError(f"[utility]: its table has no column {shown(name)}; {nearest(name, values_table.columns)}")
    values_table = values_table.with_numbers(["utility"])
    return Utility.from_table(
        values_table, utility="utility", decision=columns.decision, group=columns.group, context=columns.context, signed=signed
    )
