"""`fairaudit publish`: what a rule asks to be published, as a folder with a page, a table, a summary and the certificate."""

from __future__ import annotations

import argparse
import sys
from typing import TYPE_CHECKING, Any

from fairaudit.cli import CORE, publish_ll144
from fairaudit.cli.options import add_command, column_list
from fairaudit.cli.output import Answer, add_format

if TYPE_CHECKING:
    from fairaudit.publications.counts import Source
    from fairaudit.publications.publication import Publication
    from fairaudit.publications.withholding import Private

DESCRIPTION = """\
Write what a rule asks to be published about a certificate of counts: a page, a CSV, a summary as JSON, and the certificate, in one new
folder. The certificate is checked first, as `fairaudit verify` does. Figures are findings: nothing is said to comply with a law."""

EPILOG = """\
rules:
  ll144        New York City, 6 RCNY 5-300 to 5-304: selection or scoring rates and impact ratios by sex, race or ethnicity, and both
  four-fifths  29 CFR 1607.4 D: each group beside the one with the highest selection rate, with tests of the difference
  air          adverse impact ratio, in credit and insurance: each group beside a control group that --control names

exit codes: 0 written; 1 a statement of the certificate is false; 2 bad input; 3 the table is needed

examples:
  fairaudit publish certificate.json --rule ll144 --sex sex --race race --categories map.toml --unknown declined -o published
  fairaudit publish certificate.json --rule four-fifths -o published
  fairaudit publish certificate.json --rule four-fifths --by sex --by sex,race --favourable hired -o published
  fairaudit publish certificate.json --rule air --control white --favourable approved -o published
  fairaudit publish certificate.json --table certificate.table.jsonl --rule four-fifths --small 10 -o published"""

OPTIONS = {
    "ll144": publish_ll144.OPTIONS,
    "four-fifths": ("by", "unknown"),
    "air": ("by", "control", "unknown"),
}
"""The options that belong to each rule, besides those of all."""

CATEGORIES = "categories.toml"
"""What labels mean, as a file of the folder."""


def add(commands: Any) -> None:
    """Declare the options."""
    parser = add_command(commands, "publish", run, CORE["publish"], DESCRIPTION, EPILOG)
    parser.add_argument("certificate", metavar="CERTIFICATE.json", help="the certificate")
    parser.add_argument("--rule", required=True, choices=tuple(OPTIONS), help="whose figures to write")
    parser.add_argument("-o", "--output", metavar="DIR", required=True, help="the folder to make; refused where something is in it")
    parser.add_argument(
        "--table",
        metavar="FILE",
        help="the canonical table, where the certificate does not hold it; it goes into the folder, too, but for --small",
    )
    parser.add_argument(
        "--attestation",
        metavar="FILE",
        help="who made the certificate, of what: it goes into the page and the folder; refused where it does not fit; its signature is not "
        "checked (docs/attestation.md)",
    )
    parser.add_argument(
        "--favourable",
        metavar="LABEL[,LABEL]",
        action="append",
        help="the decisions that count as selected (those worth 1, where the utility is 0 or 1)",
    )
    parser.add_argument(
        "--unknown",
        metavar="LABEL[,LABEL]",
        action="append",
        help="labels that say that a group is unknown (the level of rows without a label, and an empty one, always say so)",
    )
    parser.add_argument(
        "--by",
        metavar="COLUMN[,COLUMN]",
        action="append",
        help="four-fifths, air: the group columns of a table; may be given several times (each column by itself, and all together)",
    )
    parser.add_argument(
        "--control",
        metavar="LABEL[,LABEL]",
        action="append",
        help="air: the control group, one label of each column that is compared by; COLUMN=LABEL where several columns have it",
    )
    parser.add_argument(
        "--small",
        metavar="N",
        type=int,
        help="withhold every group with a count below N, and what would tell it, and leave certificate and table out of the folder; "
        "needs a certificate that was made with --no-table, and --table",
    )
    parser.add_argument(
        "--with-table",
        action="store_true",
        default=None,
        help="publish a table that --no-table set apart, with every count and its salt; needed without --small",
    )
    publish_ll144.add_options(parser)
    add_format(parser)


def run(arguments: argparse.Namespace) -> Answer | int:
    """Do the work."""
    from fairaudit.errors import FalseCertificate, InputError, TableNeeded
    from fairaudit.publications.counts import read_source
    from fairaudit.publications.folder import check_folder, contents, write_folder
    from fairaudit.publications.ll144.categories import UnmappedError
    from fairaudit.reports.page import check_extra
    from fairaudit.words import plain

    for name in dict.fromkeys(name for names in OPTIONS.values() for name in names if name not in OPTIONS[arguments.rule]):
        if getattr(arguments, name) is not None:
            rules = " or ".join(rule for rule, names in OPTIONS.items() if name in names)
            raise InputError(f"--{name.replace('_', '-')} belongs to --rule {rules}; leave it away, or choose that rule")
    check_extra()
    check_folder(arguments.output)
    try:
        source = read_source(arguments.certificate, arguments.table, arguments.attestation)
    except (FalseCertificate, TableNeeded) as error:
        print(f"fairaudit: {plain(str(error))}", file=sys.stderr)
        return 1 if isinstance(error, FalseCertificate) else 3
    _check_table(source, arguments)
    try:
        publication, remark = _publication(source, arguments)
    except UnmappedError as error:
        print(f"fairaudit: {plain(str(error))}\n\n{error.block}", file=sys.stderr)
        return 2
    again = _again(arguments, source)
    files = contents(publication, source, again, _private(arguments, again), _beside(arguments))
    write_folder(arguments.output, files)
    return _answer(arguments.output, publication, files, [remark] if remark else [])


def _check_table(source: Source, arguments: argparse.Namespace) -> None:
    """Refuse to publish a table that was kept apart, unless that is asked for."""
    from fairaudit.errors import InputError

    if arguments.with_table and arguments.small is not None:
        raise InputError("--with-table publishes every count, and --small withholds some; leave one of them away")
    if arguments.with_table and source.table is None:
        raise InputError("--with-table goes with --table FILE: the certificate holds its table, which is published with it")
    if source.table is not None and "salt" in next(source.lines) and arguments.small is None and not arguments.with_table:
        raise InputError(
            "the table was kept out of the certificate (--no-table), and the folder would hold it, with every count and the salt; "
            "--small 10 withholds small counts and leaves the table out, --with-table publishes it whole"
        )


def _beside(arguments: argparse.Namespace) -> dict[str, bytes]:
    """Further files that are needed to make it again."""
    from pathlib import Path

    from fairaudit.errors import InputError

    if arguments.categories is None:
        return {}
    path = Path(arguments.categories)
    if not path.is_file():
        raise InputError(f"--categories {path} is a pipe or a device; name a file, which goes into the folder")
    return {CATEGORIES: path.read_bytes()}


def _private(arguments: argparse.Namespace, again: str) -> Private | None:
    """Who can check a publication that withholds small counts."""
    from fairaudit.publications.withholding import Private

    if arguments.small is None:
        return None
    return Private(arguments.small, ("fairaudit verify certificate.json --table certificate.table.jsonl", again), beside=True)


def _again(arguments: argparse.Namespace, source: Source) -> str:
    """The command that makes the same publication of the files beside it."""
    import shlex

    words = ["fairaudit", "publish", "certificate.json", "--rule", arguments.rule]
    stated = source.provenance
    beside = {"table": "certificate.table.jsonl", "attestation": stated and stated.file, "categories": CATEGORIES}
    for name in ("table", "attestation", "with_table", "favourable", *OPTIONS[arguments.rule], "small"):
        value = getattr(arguments, name)
        option = f"--{name.replace('_', '-')}"
        if value is True:
            words.append(option)
        elif value is not None:
            texts = value if isinstance(value, list) else [beside.get(name) or str(value)]
            words += [word for text in texts for word in ((f"{option}={text}",) if text.startswith("-") else (option, text))]
    return shlex.join([*words, "-o", "again"])


def _publication(source: Source, arguments: argparse.Namespace) -> tuple[Publication, str]:
    """What the rule asks for, and what to say of small counts in it."""
    from fairaudit.errors import InputError
    from fairaudit.publications.withholding import by_label, check_hidden, remark_on_small, withholding_of

    if arguments.small is not None:
        check_hidden(source, arguments.small)
    if arguments.rule == "ll144":
        return publish_ll144.publication(source, arguments)
    from dataclasses import replace

    from fairaudit.publications.comparison import sheets_by
    from fairaudit.publications.counts import check_unknown, decisions_of, favourable_of, silent_of

    decisions, unknown = decisions_of(source), column_list(arguments.unknown)
    check_unknown(decisions, unknown)
    decisions = replace(decisions, silent=silent_of(source.document, decisions, unknown))
    favourable = favourable_of(source, column_list(arguments.favourable))
    if arguments.small is not None:
        decisions, favourable = by_label(decisions), tuple(sorted(favourable))
    by = [column_list([text]) for text in arguments.by or []]
    counts = decisions.selected(favourable)
    withholding = None if arguments.small is None else withholding_of(counts, sheets_by(counts.columns, by), arguments.small)
    remark = remark_on_small(counts) if withholding is None else ""
    if arguments.rule == "air":
        from fairaudit.publications.adverse_impact import adverse_impact

        if arguments.control is None:
            raise InputError("--rule air compares with a control group; name it with --control LABEL")
        return adverse_impact(decisions, favourable, column_list(arguments.control), by, withholding), remark
    from fairaudit.publications.four_fifths import four_fifths

    return four_fifths(decisions, favourable, by, withholding), remark


def _answer(folder: str, publication: Publication, files: dict[str, bytes], notes: list[str]) -> Answer:
    import json
    from hashlib import sha256

    from fairaudit.publications.publication import AMISS
    from fairaudit.words import COLUMNS, plain, wrapped

    page, said = publication.page, f"Written to {folder}: {', '.join(files)}"
    points = [f"  {line}" for text in page.points for line in wrapped(f"- {plain(text)}", 2, COLUMNS - 2)]
    lines = [*wrapped(plain(page.lead)), *points, *wrapped(plain(said), 2)]
    return Answer(
        "publish",
        sentence=publication.page.lead.removesuffix(AMISS),
        notes=notes,
        result=lambda: {
            "folder": folder,
            "files": [{"name": name, "sha256": sha256(content).hexdigest()} for name, content in files.items()],
            "summary": json.loads(files["summary.json"]),
        },
        text=lambda: "\n".join(lines),
    )
