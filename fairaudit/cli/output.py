"""What commands do with what they found: see where it may be written, print it, write it and its page."""

from __future__ import annotations

import argparse
import json
import os
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from fairaudit.tables.sources import is_database

if TYPE_CHECKING:
    from fairaudit.audits.result import Result
    from fairaudit.audits.sentences import Deciding, Sizes
    from fairaudit.certificates.certificate import Certificate
    from fairaudit.cli.population import Finding
    from fairaudit.measures.distances import Distance
    from fairaudit.measures.ratios import Ratio

__all__ = ["put", "silence"]


def put(text: str) -> None:
    """Print a text; where nobody reads on (a closed pager, say) the exit code still tells."""
    try:
        print(text, flush=True)
    except BrokenPipeError:
        silence()


def silence() -> None:
    """Send what is still to be printed nowhere, so that the interpreter does not fail on it when it exits."""
    os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())


def report(arguments: argparse.Namespace, result: Result, findings: list[Finding], notes: Sequence[str] = ()) -> int:
    """Write the certificate, print what was found, and give the exit code."""
    from fairaudit.reports.text import summary
    from fairaudit.words import plain

    said = json.dumps(_json(result, arguments.top, findings), ensure_ascii=True, indent=1) if arguments.format == "json" else ""
    written = result.certificate.save(arguments.output) if arguments.output is not None else []
    if arguments.report is not None:
        write_page(result.certificate, arguments.report)
    if arguments.format == "json":
        put(said)
    else:
        for note in (*result.notes, *notes):
            print(f"note: {plain(note)}", file=sys.stderr)
        put(summary(result, arguments.top, [str(path) for path in written], [plain(finding.sentence) for finding in findings]))
    return 1 if any(finding.refuted for finding in findings) else result.exit_code


def check_output(arguments: argparse.Namespace) -> None:
    """Refuse an output that cannot be written, or must not be, before the work is done."""
    from fairaudit.errors import InputError

    if getattr(arguments, "report", None) is not None:
        _check_page(arguments)
    if arguments.output is None:
        if arguments.no_table:
            raise InputError("--no-table needs -o FILE, to write the certificate and its table separately")
        return
    refuse_output(arguments.output, _tables(arguments))


def refuse_output(name: str, tables: list[str]) -> None:
    """Refuse a file that cannot be written, or is a table.

    Raises
    ------
    InputError
        If it is one of these.
    """
    from fairaudit.errors import InputError

    path = Path(name)
    try:
        fault = _fault(path, tables)
    except (OSError, ValueError) as error:
        fault = f"cannot be written: {getattr(error, 'strerror', None) or error}"
    if fault:
        raise InputError(f"{path} {fault}")


def _check_page(arguments: argparse.Namespace) -> None:
    """Refuse a page that cannot be written, before the work is done."""
    from fairaudit.errors import InputError
    from fairaudit.reports.page import check_extra

    refuse_output(arguments.report, _tables(arguments))
    if arguments.output is not None and os.path.realpath(arguments.output) == os.path.realpath(arguments.report):
        raise InputError("-o and --report name the same file; the certificate and its page need one each")
    check_extra()


def _tables(arguments: argparse.Namespace) -> list[str]:
    """Files that are read."""
    tables = arguments.table if isinstance(arguments.table, list) else [arguments.table]
    return [table for table in tables if isinstance(table, str) and not is_database(table)]


def _fault(path: Path, tables: list[str]) -> str:
    """Why a file must not be written; empty if nothing is wrong."""
    if path.is_dir():
        return "is a directory; name a file to write"
    if not path.parent.is_dir():
        return f"cannot be written: there is no directory {path.parent}"
    try:
        found = path.stat()
    except FileNotFoundError:
        return ""
    if not path.is_file():
        return "is a device or a pipe; name a file to write"
    same = any(os.path.samestat(found, Path(table).stat()) for table in tables if Path(table).exists())
    return "is the table itself; name another file to write" if same else ""


def _json(result: Result, top: int, findings: list[Finding]) -> dict[str, Any]:
    """What `--format json` prints: the certificate, the sentence, the most unequal pairs, findings of tests, and the notes."""
    from fairaudit.certificates.entries import measure_entry
    from fairaudit.exact.rationals import rational_text
    from fairaudit.measures.limits import limit_readings

    return {
        "verdict": result.verdict,
        "sentence": result.sentence,
        "targets": [
            {
                "quantity": target.quantity,
                "unit": target.unit,
                "limit": rational_text((target.limit.numerator, target.limit.denominator)),
                "readings": limit_readings(target.unit, target.limit),
                **({"estimand": target.estimand} if result.law.units else {}),
                "verdict": target.verdict,
            }
            for target in result.targets
        ],
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
                "sentence": planned.sentence,
            }
            for target, planned in result.further_draws
        ],
        "notes": list(result.notes),
        "certificate": result.certificate.document,
    }


def _decided(deciding: Deciding, result: Result) -> dict[str, Any]:
    """What decided a target: the pair of groups with its sizes, the end or ratio that was compared with the limit, and where it is from."""
    from fairaudit.certificates.numbers import number

    pair = deciding.pair
    labels = None if pair is None else {"context": pair.context, "higher": pair.higher, "lower": pair.lower}
    sized = {} if pair is None else _sized(result.sizes_of(pair))
    return {"quantity": deciding.quantity, "end": deciding.end, "value": number(deciding.value), "by": deciding.by, "pair": labels, **sized}


def _sizes(measured: Ratio | Distance, result: Result) -> dict[str, Any]:
    from fairaudit.measures.ratios import Ratio

    return _sized(result.sizes_of(measured.witness)) if isinstance(measured, Ratio) else {}


def _sized(found: Sizes | None) -> dict[str, Any]:
    """How many decisions, and sampling units, were recorded of a pair."""
    from fairaudit.certificates.numbers import number

    if found is None:
        return {}
    units = {} if found[0].units is None else {"units": [size.units for size in found]}
    return {"decisions": [number(size.decisions) for size in found], **units}


def write_page(certificate: Certificate, path: str) -> Path:
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
    return Path(path)
