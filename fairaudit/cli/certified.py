"""What `certify` says of a result, whatever it was made from, and where it writes certificate and page."""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from fractions import Fraction
from typing import TYPE_CHECKING, Any

from fairaudit.cli.output import Answer

if TYPE_CHECKING:
    from fairaudit.audits.drift import TableRadius
    from fairaudit.audits.result import Result
    from fairaudit.audits.sentences import Deciding, Sizes
    from fairaudit.certificates.certificate import Certificate
    from fairaudit.cli.population import Finding
    from fairaudit.inference.differences import DifferenceInterval
    from fairaudit.inference.interval import Interval
    from fairaudit.measures.distances import Distance
    from fairaudit.measures.ratios import Ratio, Witness
    from fairaudit.theorems.t13_near import DriftRadius

__all__ = ["certified", "target_entries"]


def certified(arguments: argparse.Namespace, result: Result, findings: list[Finding], notes: Sequence[str] = ()) -> Answer:
    """Write the certificate and its page where the options say so, and answer with what was found."""
    from fairaudit.reports.text import summary
    from fairaudit.words import plain

    written = result.certificate.save(arguments.output) if arguments.output is not None else []
    if arguments.report is not None:
        _write_page(result.certificate, arguments.report)
    return Answer(
        "certify",
        verdict=result.verdict,
        sentence=result.sentence,
        notes=(*result.notes, *notes),
        result=lambda: result.certificate.document,
        details=lambda: _details(result, arguments.top, findings, two_sided=arguments.two_sided),
        text=lambda: summary(
            result,
            arguments.top,
            [str(path) for path in written],
            [plain(line) for found in findings for line in (found.sentence, *found.lines)],
            two_sided=arguments.two_sided,
            completions=arguments.show_completions,
        ),
        code=1 if any(finding.refuted for finding in findings) else result.exit_code,
    )


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


def _write_page(certificate: Certificate, path: str) -> None:
    """Write the page of a certificate that was just made, after checking it like any other.

    Raises
    ------
    InputError
        If the page cannot be written.
    """
    from fairaudit.errors import FalseCertificate
    from fairaudit.reports.report import report

    try:
        report(certificate, path)
    except FalseCertificate as error:
        raise RuntimeError(str(error)) from None
