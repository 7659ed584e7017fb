"""`fairaudit certify --group-probability`: groups that nobody recorded, of which a table says how probable they are in each cell."""

from __future__ import annotations

import argparse
from typing import Any

from fairaudit.cli.attesting import attesting
from fairaudit.cli.certified import TOP, write_attested
from fairaudit.cli.destinations import check_output
from fairaudit.cli.options import given_limits
from fairaudit.cli.output import Answer
from fairaudit.cli.population import OF_SAMPLES
from fairaudit.cli.source import option, progress, reading_of

__all__ = ["certify_by_proxies"]

ELSEWHERE = (
    "from_monitor",
    "at_alarm",
    "slots",
    "score",
    "above",
    "wide",
    "total",
    "truth",
    "positive",
    "difference",
    "max_difference",
    "max_global_difference",
    "burden",
    "max_drift",
    "unknown",
    "hidden_context",
    "undecided",
    "all_bounds",
    "in_parts",
    "print_sql",
    "winner",
    "profile_exp_epsilon",
    *OF_SAMPLES,
)
"""Options that have no meaning for such an audit."""


def certify_by_proxies(arguments: argparse.Namespace) -> Answer:
    """Audit a log without groups, and write its certificate and page where the options say so."""
    from fairaudit.audits.proxies import audit_proxies
    from fairaudit.errors import InputError
    from fairaudit.model.utility import Utility, utility_values
    from fairaudit.reports.proxy_text import proxy_text
    from fairaudit.tables.group_probabilities import read_group_probabilities
    from fairaudit.tables.sources import is_audit_file

    given: dict[str, Any] = vars(arguments)
    for name in ELSEWHERE:
        if given.get(name):
            raise InputError(f"{option(name)} does not go with --group-probability")
    if arguments.confidence not in (None, "none"):
        raise InputError("--confidence does not go with --group-probability, which judges the table; sampling error comes on top")
    if is_audit_file(arguments.table):
        raise InputError("--group-probability goes with a log or a table of counts, not with an audit file")
    if arguments.utility is None and arguments.utility_column is None:
        raise InputError("no utility was given; use --utility, such as --utility Admitted, or --utility-column COL")
    check_output(arguments, undrawn="groups that are known by probabilities alone")
    stated = attesting(arguments, again=False)
    reading = reading_of(arguments)
    utility = None if arguments.utility is None else Utility(utility_values(arguments.utility, "--utility"))
    probabilities = read_group_probabilities(arguments.group_probability, reading.group)
    with progress() as told:
        result = audit_proxies(
            arguments.table,
            reading,
            utility,
            probabilities,
            limits=given_limits(arguments),
            embed=False if arguments.no_table else None,
            report=told,
        )
    written = write_attested(arguments, result, stated)
    return Answer(
        "certify-proxies",
        verdict=result.verdict,
        sentence=result.sentence,
        notes=result.notes,
        result=lambda: result.certificate.document,
        text=lambda: proxy_text(result, arguments.top or TOP, written, completions=arguments.show_completions),
        code=result.exit_code,
    )
