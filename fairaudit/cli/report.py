"""`fairaudit report`: a certificate as a page that people read, in print, or as markdown."""

from __future__ import annotations

import argparse
import sys
from typing import Any

from fairaudit.cli import CORE
from fairaudit.cli.options import add_command
from fairaudit.cli.output import Answer

DESCRIPTION = """\
Write a certificate as one self-contained HTML page, as that in print (PDF), as markdown, as a picture, or as part of a model card. Every
statement is checked first, as `fairaudit verify` does; a false certificate gets no report, and one whose table is in another file that
--table does not name, a report marked as not checked. With an attestation it says who made this, of what: what was checked of that apart
from what is only stated. The page loads nothing, embeds the certificate, and checks it in the reader's browser."""


EPILOG = """\
exit codes: 0 written; 1 a statement of the certificate is false; 2 bad input; 3 the table is needed, with --small

examples:
  fairaudit report certificate.json -o page.html -o page.pdf
  fairaudit report certificate.json -o picture.svg
  fairaudit report certificate.json --format markdown
  fairaudit report certificate.json --format model-card -o card.md
  fairaudit report certificate.json --attestation attestation.json -o page.html
  fairaudit report certificate.json --table certificate.table.jsonl -o page.html
  fairaudit report certificate.json --table certificate.table.jsonl --small 10 -o public.html"""


def add(commands: Any) -> None:
    """Declare the options."""
    parser = add_command(commands, "report", run, CORE["report"], DESCRIPTION, EPILOG)
    parser.add_argument("certificate", metavar="CERTIFICATE.json", help="the certificate")
    parser.add_argument(
        "-o",
        "--output",
        metavar="FILE",
        action="append",
        help="where to write: a page (.html), that in print (.pdf), markdown (.md), a picture (.svg, .png), the certificate (.json); "
        "may be given several times (standard output by default)",
    )
    parser.add_argument(
        "--format",
        choices=("html", "markdown", "model-card"),
        help="what to write to standard output (html); a model card may also be written to a file that ends in .md",
    )
    parser.add_argument(
        "--picture",
        choices=("expectations", "ratios", "bounds"),
        help="what a picture shows: what each group gets (expectations, as by default), the ratio of each pair of groups in the most "
        "unequal context, or what is known of the ratio within contexts",
    )
    parser.add_argument(
        "--table",
        metavar="FILE",
        help="the canonical table, to check a certificate that does not hold it; nothing of it goes into the report, but with --small the "
        "counts of the groups that are shown",
    )
    parser.add_argument(
        "--small",
        metavar="N",
        type=int,
        help="write a page for the public, which withholds every group with a count below N and does not hold the certificate; needs one "
        "that was made with --no-table, and --table",
    )
    parser.add_argument(
        "--attestation",
        metavar="FILE",
        help="who made the certificate, of what: refused where it does not fit; its signature is not checked (docs/attestation.md)",
    )


def run(arguments: argparse.Namespace) -> Answer | int:
    """Do the work."""
    from fairaudit.attestations.verification import read_attestation
    from fairaudit.cli.destinations import check_forms, drawing, refuse_output, refuse_twice
    from fairaudit.errors import FalseCertificate, InputError
    from fairaudit.files import write_together
    from fairaudit.reports.endings import form_of
    from fairaudit.reports.report import files_of, report
    from fairaudit.words import plain

    names: list[str] = arguments.output or []
    for name in names:
        refuse_output(name, [arguments.certificate], "the certificate")
        refuse_output(name, [arguments.table] if arguments.table is not None else [])
        refuse_output(name, [arguments.attestation] if arguments.attestation is not None else [], "the attestation")
        written = "model-card" if arguments.format == "model-card" and form_of(name) == "markdown" else form_of(name)
        if arguments.format not in (None, written):
            raise InputError(f"--format {arguments.format} does not go with {name}, whose ending says what is written; leave one away")
    refuse_twice(names)
    check_forms(names)
    draw = drawing(names, arguments.picture or "expectations")
    if arguments.picture is not None and draw is None:
        raise InputError(f"--picture {arguments.picture} goes with -o FILE.svg or -o FILE.png, which a picture is written to")
    if arguments.small is not None and arguments.format == "model-card":
        raise InputError("--small does not go with --format model-card, which has the exact figures of all groups")
    try:
        if arguments.small is not None:
            if arguments.attestation is not None:
                raise InputError("--attestation does not go with --small: it states exactly how many decisions were counted and left out")
            return _public(arguments, names)
        if names:
            stated = None if arguments.attestation is None else read_attestation(arguments.attestation)
            cards = arguments.format == "model-card"
            write_together(files_of(arguments.certificate, names, arguments.table, cards=cards, attestation=stated, draw=draw))
            return 0
        text = report(arguments.certificate, format=arguments.format, table=arguments.table, attestation=arguments.attestation)
    except FalseCertificate as error:
        print(f"fairaudit: {plain(str(error))}", file=sys.stderr)
        return 1
    return Answer("report", result=dict, text=lambda: text.rstrip("\n"))


def _public(arguments: argparse.Namespace, names: list[str]) -> Answer | int:
    """Write the report that withholds small counts."""
    from fairaudit.errors import TableNeeded
    from fairaudit.files import write_together
    from fairaudit.publications.counts import read_source
    from fairaudit.publications.public_report import public_files, text_of
    from fairaudit.words import plain

    try:
        source = read_source(arguments.certificate, arguments.table)
    except TableNeeded as error:
        print(f"fairaudit: {plain(str(error))}", file=sys.stderr)
        return 3
    if names:
        write_together(public_files(source, arguments.small, names))
        return 0
    text = text_of(source, arguments.small, arguments.format or "html")
    return Answer("report", result=dict, text=lambda: text.rstrip("\n"))
