"""Metrics, witnesses, rates and what was not compared: as the certificate states them, and against the table."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping, Sequence
from itertools import zip_longest

from .figures import EXPECTED_DIFFERENCES, Maximum
from .header import Columns
from .json_values import read_choice, read_list, read_object, read_string, read_strings
from .logarithms import log_enclosure
from .rates import DIFFERENCES, KINDS, OVERALL
from .rationals import read_extended, read_rational
from .table import Policy, Table, measure, not_compared
from .text import Finding, compared, finding_of, malformed, shown

Metrics = Mapping[str, dict[str, object] | None]  # as stated, by name; null where nobody was compared
Rates = Mapping[str, list[dict[str, object]] | None]  # as stated, by kind

# What a witness of each metric has to name, and whether the metric is a ratio (with a logarithm) or a distance.
METRICS: dict[str, tuple[bool, tuple[str, ...]]] = {
    "local": (True, ("context", "higher", "lower", "expectations")),
    "global": (True, ("higher", "lower", "expectations")),
    "demographic_parity": (False, ("higher", "lower", "decisions")),
    "equalized_odds": (False, ("context", "higher", "lower", "decisions")),
    "local_supremum": (True, ("context", "decision", "higher", "lower", "probabilities")),
    "global_supremum": (True, ("decision", "higher", "lower", "probabilities")),
}

SHAPES = (
    METRICS
    | {name: (False, ("context",) * name.startswith("local") + ("higher", "lower", "expectations")) for name in EXPECTED_DIFFERENCES}
    | {name: (False, ("context",) * (not name.endswith(OVERALL)) + ("rate", "higher", "lower", "rates")) for name in DIFFERENCES}
)

_LOG = re.compile(r"0|inf|(?:0|[1-9][0-9]*)\.[0-9]{12}")


def _read_log(value: object, where: str) -> tuple[str, ...]:
    pair = read_strings(value, where, 2)
    for i, text in enumerate(pair):
        if not _LOG.fullmatch(text):
            raise malformed(f"{where}[{i}]", f'must be "0", "inf" or have twelve decimals, not {shown(text)}')
    return pair


def _read_witness(value: object, where: str, keys: Sequence[str], columns: Columns) -> dict[str, object]:
    members = read_object(value, where, keys)
    read: dict[str, object] = {}
    for key in keys:
        item, place = members[key], f"{where}.{key}"
        if key == "decision":
            read[key] = read_string(item, place)
        elif key == "decisions":
            read[key] = list(read_strings(item, place))
        elif key == "rate":
            read[key] = read_choice(item, place, KINDS)
        elif key in ("expectations", "probabilities", "rates"):
            read[key] = [read_rational(number, f"{place}[{i}]") for i, number in enumerate(read_list(item, place, 2))]
        else:
            names = columns.context if key == "context" else columns.group
            labels = read_object(item, place, names)
            read[key] = {name: read_string(labels[name], f"{place}[{shown(name)}]") for name in names}
    return read


def read_metric(value: object, where: str, name: str, columns: Columns) -> dict[str, object] | None:
    """Read a metric with its witness; null where nobody was compared."""
    if value is None:
        return None
    is_ratio, names = SHAPES[name]
    members = read_object(value, where, ("ratio", "log", "witness") if is_ratio else ("value", "witness"))
    read: dict[str, object] = {}
    if is_ratio:
        read["ratio"] = read_extended(members["ratio"], f"{where}.ratio")
        read["log"] = _read_log(members["log"], f"{where}.log")
    else:
        read["value"] = read_rational(members["value"], f"{where}.value")
    return read | {"witness": _read_witness(members["witness"], f"{where}.witness", names, columns)}


def read_rates(value: object, where: str, columns: Columns) -> list[dict[str, object]] | None:
    """Read the rates of one kind, by context and group; null where the table is not embedded."""
    if value is None:
        return None
    keys = ("group",) if where.endswith(OVERALL) else ("context", "group")
    read: list[dict[str, object]] = []
    for i, item in enumerate(read_list(value, where)):
        place = f"{where}[{i}]"
        members = read_object(item, place, (*keys, "rate"))
        named = _read_witness({key: members[key] for key in keys}, place, keys, columns)
        read.append(named | {"rate": read_rational(members["rate"], f"{place}.rate")})
    return read


def read_unfiltered(value: object, where: str, columns: Columns) -> Metrics | None:
    """Read the two ratios of a policy without its filters; null where its labels are not the true ones."""
    if value is None:
        return None
    members = read_object(value, where, ("local", "global"))
    return {name: read_metric(members[name], f"{where}.{name}", name, columns) for name in ("local", "global")}


def read_not_compared(value: object, where: str, columns: Columns) -> dict[str, object]:
    """Read an entry of what was not compared."""
    shapes = [("context", "groups", "reason"), ("context", "reason"), ("groups", "reason"), ("quantity", "reason")]
    if columns.truth is not None:
        shapes += [("quantity", *shape) for shape in shapes[:3]]
    shape = next((keys for keys in shapes if isinstance(value, dict) and value.keys() == set(keys)), None)
    if shape is None or not isinstance(value, dict):
        raise malformed(where, f"must be an object with the keys {', or '.join(map(shown, shapes))}")
    for key in shape:
        if key == "groups":
            for i, group in enumerate(read_list(value[key], f"{where}.groups")):
                read_strings(group, f"{where}.groups[{i}]", len(columns.group))
        elif key == "context":
            read_strings(value[key], f"{where}.context", len(columns.context))
        else:
            read_string(value[key], f"{where}.{key}")
    return value


def check_metrics(stated: Metrics, metrics: Mapping[str, Maximum | None], where: str) -> Iterator[Finding]:
    """Compare each metric, its logarithm and its witness."""
    for name, figures in stated.items():
        actual = metrics.get(name)
        if figures is None or actual is None:
            yield compared(f"{where}.{name}", figures, None if actual is None else actual.value)
            continue
        expected: dict[str, object] = {"value": actual.value, "witness": actual.witness}
        if SHAPES[name][0]:
            expected |= {"ratio": actual.value, "log": log_enclosure(actual.value)}
        for key, figure in figures.items():
            yield compared(f"{where}.{name}.{key}", figure, expected[key])


def check_unfiltered(stated: Metrics | None, policy: Policy) -> Iterator[Finding]:
    """Compare the metrics of a policy without its filters, which exist where its own labels are the true ones."""
    if stated is None or policy.unfiltered is None:
        yield compared("metrics.unfiltered", stated, "comparable" if policy.unfiltered else None)
    else:
        yield from check_metrics(stated, measure(policy.unfiltered), "metrics.unfiltered")


def check_not_compared(stated: Sequence[Mapping[str, object]], table: Table) -> Finding:
    """Compare what the metrics leave out, and why."""
    # One entry at a time: a short table can leave out more pairs of contexts and groups than fit into memory.
    for i, (entry, actual) in enumerate(zip_longest(stated, not_compared(table))):
        if entry != actual:
            detail = "the table gives no further entry" if actual is None else f"the table gives {shown(actual)}"
            return finding_of(f"not_compared[{i}] is {'not there' if entry is None else shown(entry)}", False, detail)
    return finding_of(f"not_compared is {shown(stated)}", True)


def check_rates(stated: Rates, embedded: bool, table: Table) -> Iterator[Finding]:
    """Compare the rates, which stand in a certificate exactly if its table does."""
    actual = table.given.rates() if table.given is not None and embedded else {}
    for name, rates in stated.items():
        yield compared(f"metrics.{name}", rates, actual.get(name))
