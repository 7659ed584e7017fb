"""`fairaudit report`: a certificate as a page that people read, or as markdown."""

from __future__ import annotations

import argparse
import sys
from typing import Any

from fairaudit.cli.options import add_command
from fairaudit.cli.output import Answer

DESCRIPTION = """\
Write a certificate as one self-contained HTML page, or as markdown. Every statement is checked first, as `fairaudit verify` does; a false
certificate gets no report, and one whose table is in another file that --table does not name, a report marked as not checked. The page
loads nothing, embeds the certificate, and recomputes its figures in the reader's browser."""


EPILOG = """\
exit codes: 0 written; 1 a statement of the certificate is false; 2 bad input

examples:
  fairaudit report certificate.json -o page.html
  fairaudit report certificate.json --format markdown
  fairaudit report certificate.json --table certificate.table.jsonl -o page.html"""


def add(commands: Any) -> None:
    """Declare the options."""
    parser = add_command(commands, "report", run, "write a certificate as a page for people", DESCRIPTION, EPILOG)
    parser.add_argument("certificate", metavar="CERTIFICATE.json", help="the certificate")
    parser.add_argument("-o", "--output", metavar="FILE", help="where to write (standard output by default)")
    parser.add_argument("--format", choices=("html", "markdown"), default="html", help="what to write (html)")
    parser.add_argument(
        "--table",
        metavar="FILE",
        help="the canonical table, to check a certificate that does not hold it; nothing of it goes into the report",
    )


def run(arguments: argparse.Namespace) -> Answer | int:
    """Do the work."""
    from fairaudit.cli.destinations import refuse_output
    from fairaudit.errors import FalseCertificate
    from fairaudit.reports.report import report
    from fairaudit.words import plain

    if arguments.output is not None:
        refuse_output(arguments.output, [arguments.certificate], "the certificate")
        refuse_output(arguments.output, [arguments.table] if arguments.table is not None else [])
    try:
        text = report(arguments.certificate, arguments.output, format=arguments.format, table=arguments.table)
    except FalseCertificate as error:
        print(f"fairaudit: {plain(str(error))}", file=sys.stderr)
        return 1
    return 0 if arguments.output is not None else Answer("report", result=dict, text=lambda: text.rstrip("\n"))
