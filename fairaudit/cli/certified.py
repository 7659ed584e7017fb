"""What `certify` says of a result, whatever it was made from, and where it writes certificate and page."""

from __future__ import annotations

import argparse
import shlex
from collections.abc import Sequence
from fractions import Fraction
from pathlib import PurePath
from typing import TYPE_CHECKING, Any

from fairaudit.cli.destinations import write_outputs
from fairaudit.cli.output import Answer, in_colour, is_json

if TYPE_CHECKING:
    from fairaudit.audits.drift import TableRadius
    from fairaudit.audits.proxies import ProxyAudit
    from fairaudit.audits.result import Result
    from fairaudit.audits.sentences import Deciding, Sizes
    from fairaudit.cli.attesting import Attesting
    from fairaudit.cli.keeping import Kept
    from fairaudit.cli.population import Finding
    from fairaudit.inference.differences import DifferenceInterval
    from fairaudit.inference.interval import Interval
    from fairaudit.measures.distances import Distance
    from fairaudit.measures.ratios import Ratio, Witness
    from fairaudit.theorems.t13_near import DriftRadius

__all__ = ["TOP", "certified", "next_step", "source_of", "target_entries", "write_attested"]


TOP = 3  # most unequal pairs that are listed, unless more are asked for


def certified(
    arguments: argparse.Namespace,
    result: Result,
    findings: list[Finding],
    notes: Sequence[str] = (),
    attesting: Attesting | None = None,
    kept: Kept | None = None,
) -> Answer:
    """Write the certificate, its page and its statement where the options say so, and answer with what was found."""
    written = write_attested(arguments, result, attesting, kept)
    return Answer(
        "certify",
        verdict=result.verdict,
        sentence=result.sentence,
        notes=(
            *(() if _is_first_screen(arguments, findings) else result.warnings),
            *result.notes,
            *notes,
            *(() if kept is None else kept.notes),
        ),
        result=lambda: result.certificate.document,
        details=lambda: _details(result, arguments.top or TOP, findings, two_sided=arguments.two_sided),
        text=lambda: _text(arguments, result, findings, written),
        code=1 if any(finding.refuted for finding in findings) else result.exit_code,
    )


def write_attested(
    arguments: argparse.Namespace, result: Result | ProxyAudit, attesting: Attesting | None, kept: Kept | None = None
) -> list[str]:
    """Write what the options name, with the statement where one is asked for, and counts that are kept; what can be verified of it."""
    if not arguments.output and kept is None:
        return []
    stated = None if attesting is None else (attesting.path, attesting.text(result, arguments.output).encode("ascii"))
    before = [] if kept is None else [(kept.path, kept.blocks())]
    return write_outputs((result, arguments.output or []), attestation=stated, before=before)


def _text(arguments: argparse.Namespace, result: Result, findings: list[Finding], written: Sequence[str]) -> str:
    """The first screen, or, where it or a part of it was asked for, everything that was found."""
    from fairaudit.words import plain

    if not _is_first_screen(arguments, findings):
        from fairaudit.reports.text import summary

        said = [plain(line) for found in findings for line in (found.sentence, *found.lines)]
        options = {"two_sided": arguments.two_sided, "completions": arguments.show_completions}
        return summary(result, arguments.top or TOP, written, said, **options)
    from fairaudit.reports.overview import of_result
    from fairaudit.reports.screen import CONTEXTS, GROUPS, first_screen

    found = of_result(result, groups=GROUPS, contexts=CONTEXTS)
    said = [finding.sentence for finding in findings]
    return first_screen(found, source_of(arguments), next_step(result, written, arguments.attest), said, colour=in_colour())


def _is_first_screen(arguments: argparse.Namespace, findings: Sequence[Finding]) -> bool:
    """Whether the first screen is printed, which says itself what to know first, and neither everything nor JSON."""
    asked = arguments.two_sided or arguments.show_completions or arguments.verbose or arguments.top is not None
    return not (asked or any(finding.lines for finding in findings) or is_json(arguments.format))


def source_of(arguments: argparse.Namespace) -> str:
    """What was read: of a file its name."""
    from fairaudit.tables.sources import source_name

    if arguments.example is not None:
        return f"example {arguments.example}"
    name = source_name(arguments.from_monitor or arguments.table)
    return name if "://" in name else PurePath(name).name or name


def next_step(result: Result, written: Sequence[str], attestation: str | None = None) -> str:
    """What to do next: check the certificate, plan a sample that decides, or write a certificate."""
    if written:
        beside = {"--table": written[1] if len(written) > 1 else None, "--attestation": attestation}
        words = ["fairaudit", "verify", written[0], *(word for name, file in beside.items() if file is not None for word in (name, file))]
        return shlex.join(words)
    planned = _plan(result) if result.verdict == "inconclusive" else ""
    return planned or "the same command with -o certificate.json, for a certificate that anybody can check"


def _plan(result: Result) -> str:
    """The command that says how many draws would decide the pair that leaves a target open; empty where it has none."""
    from fairaudit.exact.rationals import rational_text
    from fairaudit.words import approximate

    binary = result.utility.by_decision and set(result.utility.values.tolist()) <= {0, result.utility.scale}
    for target, deciding in zip(result.targets, result.deciding, strict=True):
        if target.verdict != "inconclusive" or target.confidence is None or target.unit == "difference" or target.under or not binary:
            continue
        if deciding is None or deciding.pair is None or result.law.units is not None or min(deciding.pair.expectations) <= 0:
            continue
        guesses = ",".join(approximate(value) for value in deciding.pair.expectations)
        limit = rational_text((target.limit.numerator, target.limit.denominator))
        sure = (
            ""
            if target.confidence == Fraction(19, 20)
            else f" --confidence {rational_text((target.confidence.numerator, target.confidence.denominator))}"
        )
        return f"fairaudit plan --guess {guesses} --max-{target.unit} {limit}{sure}"
    return ""


def target_entries(result: Result) -> list[dict[str, Any]]:
    """The limits that were given, as a ratio, as least over greatest and as a logarithm, with their verdicts."""
    from fairaudit.measures.limits import limit_readings

    return [
        {
            "quantity": target.quantity,
            "unit": target.unit,
            "limit": target.limit,
            "readings": limit_readings(target.unit, target.limit),
            **({"estimand": target.estimand} if result.law.units else {}),
            "verdict": target.verdict,
        }
        for target in result.targets
    ]


def _details(result: Result, top: int, findings: list[Finding], *, two_sided: bool) -> dict[str, Any]:
    """What stands beside the certificate: targets, what decided them, the most unequal pairs, tests, and draws still needed."""
    from fairaudit.certificates.entries import measure_entry

    return {
        "targets": target_entries(result),
        "drift_radii": [None if radius is None else _radius(radius) for radius in result.drift_radii],
        "decided_by": [None if deciding is None else _decided(deciding, result) for deciding in result.deciding],
        "most_unequal": {
            name: [measure_entry(m) | _sizes(m, result) for m in measures] for name, measures in result.most_unequal(top).items()
        },
        "findings": [{"test": found.test, "sentence": found.sentence, **found.figures} for found in findings],
        "further_draws": [
            {
                "quantity": target.quantity,
                "unit": target.unit,
                "draws": planned.draws,
                "decides": planned.decides,
                "total": planned.total,
                "total_if_equal": planned.total_if_equal,
                "expected_power": None if planned.power is None else Fraction(round(1000 * planned.power), 1000),
                "method": planned.method,
                "pair": _labels(planned.pair),
                "pair_draws": planned.pair_draws,
                "sentence": planned.sentence,
            }
            for target, planned in result.further_draws
        ],
        **({"two_sided": _two_sided(result)} if two_sided else {}),
    }


def _two_sided(result: Result) -> dict[str, Any]:
    """The intervals with half of the error on each side."""
    from fairaudit.certificates.numbers import number

    def entry(found: Interval | DifferenceInterval, name: str) -> dict[str, Any]:
        return {"confidence": number(found.confidence), name: [number(found.lower), number(found.upper)]}

    apart = result.differences.two_sided if result.differences else {}
    of_ratios: dict[str, Any] = {quantity: entry(found, "ratio") for quantity, found in result.two_sided.items()}
    return {**of_ratios, **{f"{quantity}_difference": entry(found, "difference") for quantity, found in apart.items()}}


def _radius(found: DriftRadius | TableRadius) -> dict[str, Any]:
    """How far cells may move, or policies may be from this one, while a verdict stands."""
    from fairaudit.audits.drift import TableRadius
    from fairaudit.certificates.numbers import number

    if not isinstance(found, TableRadius):
        return {"radius": found.radius, "always": found.always, "exact": found.exact}
    own = {"radius": Fraction(1) if found.always else found.radius, "always": found.always, "exact": found.exact}
    return own if found.factor is None else {**own, "factor": number(found.factor), "exact_factor": found.exact_factor}


def _decided(deciding: Deciding, result: Result) -> dict[str, Any]:
    """What decided a target: the pair of groups with its sizes, the end or ratio that was compared with the limit, and where it is from."""
    from fairaudit.certificates.numbers import number

    pair = deciding.pair
    labels = _labels(pair)
    sized = {} if pair is None else _sized(result.sizes_of(pair))
    unit = {"unit": deciding.unit} if deciding.unit == "difference" else {}
    return {
        "quantity": deciding.quantity,
        **unit,
        "end": deciding.end,
        "value": number(deciding.value),
        "by": deciding.by,
        "pair": labels,
        **sized,
    }


def _labels(pair: Witness | None) -> dict[str, Any] | None:
    return None if pair is None else {"context": pair.context, "higher": pair.higher, "lower": pair.lower}


def _sizes(measured: Ratio | Distance, result: Result) -> dict[str, Any]:
    from fairaudit.measures.ratios import Ratio

    return _sized(result.sizes_of(measured.witness)) if isinstance(measured, Ratio) else {}


def _sized(found: Sizes | None) -> dict[str, Any]:
    """How many decisions, and sampling units, were recorded of a pair."""
    if found is None:
        return {}
    units = {} if found[0].units is None else {"units": [size.units for size in found]}
    return {"decisions": [size.decisions for size in found], **units}
