"""`fairaudit report`: a certificate as a page that people read, or as markdown."""

from __future__ import annotations

import argparse
import sys
from pathlib import Path
from typing import Any

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
    parser = commands.add_parser(
        "report",
        help="write a certificate as a page for people",
        description=DESCRIPTION,
        epilog=EPILOG,
        formatter_class=argparse.RawDescriptionHelpFormatter,
        allow_abbrev=False,
    )
    parser.set_defaults(run=run)
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
    from fairaudit.certificates.reader import load
    from fairaudit.cli.checking import checked
    from fairaudit.cli.destinations import refuse_output
    from fairaudit.errors import InputError
    from fairaudit.files import write_atomically
    from fairaudit.reports.markdown import markdown
    from fairaudit.reports.page import html
    from fairaudit.words import plain

    document, raw = load(arguments.certificate)
    if arguments.output is not None:
        refuse_output(arguments.output, [arguments.certificate], "the certificate")
        refuse_output(arguments.output, [arguments.table] if arguments.table is not None else [])
    table = None
    if arguments.table is not None:
        try:
            table = Path(arguments.table).read_bytes().splitlines(keepends=True)
        except OSError as error:
            raise InputError(f"{arguments.table} cannot be read: {error.strerror or error}") from None
    wrong, said = checked(raw, table, arguments.certificate)
    if wrong:
        print(f"fairaudit: {plain(wrong)}; no report was written", file=sys.stderr)
        return 1
    said = "" if "not at hand" in said else said  # a report of a certificate without its table says that nobody checked it
    text = (html if arguments.format == "html" else markdown)(document, checked=said)
    if arguments.output is not None:
        write_atomically(Path(arguments.output), [text.encode("utf-8")])
        return 0
    return Answer("report", result=dict, text=lambda: text.rstrip("\n"))
