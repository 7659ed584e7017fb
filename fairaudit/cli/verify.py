"""`fairaudit verify`: check a certificate with the independent checker, and nothing else; or write that checker as one file."""

from __future__ import annotations

import argparse
import sys
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from fairaudit.cli import CORE
from fairaudit.cli.output import Answer, add_format, tell
from fairaudit.cli.recounting import add_recount, as_json, as_text, check_recount, recount_of

if TYPE_CHECKING:
    from fairaudit.cli.checking import Attested, Finding, Signed

FALSE_ALREADY = "nothing was recounted, because what the log would be compared with is false already"

UNSEEN = ", which was not looked at here: "
UNCHECKED = ": nothing here checks it."


def add(commands: Any) -> None:
    """Declare the options."""
    parser = commands.add_parser(
        "verify",
        help=CORE["verify"],
        description="Check every statement of a certificate, in exact integer arithmetic and with none of the code that wrote it, and say "
        "in one paragraph what is true and what is assumed.",
        epilog="exit codes: 0 all true; 1 a statement is false, or the required verdict is not there; 2 bad input; 3 the table is needed, "
        "or the signature of the attestation was not checked, or a log is not there",
        usage="%(prog)s CERTIFICATE… [--table FILE] [--attestation FILE [--key PUB.pem] [--recount LOG… [--query SQL]]]\n"
        "                        [--require within] [--verbose | --quiet] [--format text|json]\n"
        "       %(prog)s CERTIFICATE [--table FILE] --coq FILE.v [--quiet] [--format text|json]\n"
        "       %(prog)s --export FILE.pyz",
        allow_abbrev=False,
    )
    parser.set_defaults(run=run)
    parser.add_argument("certificates", metavar="CERTIFICATE", nargs="*", help="the certificate, or a page that shows one; or several")
    parser.add_argument("--table", metavar="FILE", help="the canonical table, when the certificate does not hold it")
    parser.add_argument(
        "--attestation",
        metavar="FILE",
        help="also check who is said to have made it, of which files, so far as that can be checked (docs/attestation.md)",
    )
    parser.add_argument("--key", metavar="PUB.pem", help="the signer's public key, by which the attestation must be signed")
    add_recount(parser)
    parser.add_argument("--require", choices=("within",), help="also fail unless the verdict is 'within'")
    parser.add_argument(
        "--export",
        metavar="FILE.pyz",
        help="write the checker as one file, which runs as `python -I -S FILE.pyz CERTIFICATE.json`, and print its SHA-256",
    )
    parser.add_argument(
        "--coq",
        metavar="FILE.v",
        help="of a true certificate, also write the table and what is stated of it as a file that Coq checks (docs/trust.md compares what "
        "the ways to check take on trust)",
    )
    more = parser.add_mutually_exclusive_group()
    more.add_argument("--verbose", action="store_true", help="print every statement and every assumption, too")
    more.add_argument("--quiet", action="store_true", help="print nothing; the exit code tells")
    add_format(parser)


def run(arguments: argparse.Namespace) -> Answer | int:
    """Hand over to the checker, or write it as one file."""
    from fairaudit.errors import InputError

    check_recount(arguments)
    if arguments.export is not None:
        others = (arguments.table, arguments.attestation, arguments.key, arguments.require)
        if arguments.certificates or any(other is not None for other in others):
            raise InputError(
                "--export writes the checker and checks nothing; leave the certificate, its table and attestation, and --require away"
            )
        return _export(arguments.export)
    if arguments.coq is not None:
        return _for_coq(arguments)
    if not arguments.certificates and arguments.recount is not None:
        raise InputError(
            "no certificate is named before --recount, which takes all names that follow it; write fairaudit verify CERTIFICATE.json "
            "--attestation FILE --recount LOG"
        )
    if not arguments.certificates:
        raise InputError(
            "no certificate is named; give CERTIFICATE.json, or --export FILE.pyz to write the checker; see fairaudit verify --help"
        )
    if arguments.key is not None and arguments.attestation is None:
        raise InputError("--key is that of the signer of an attestation; add --attestation FILE, or leave --key away")
    if len(arguments.certificates) == 1:
        return _check(arguments, arguments.certificates[0])
    for given, what in ((arguments.table, "--table is the table"), (arguments.attestation, "--attestation is that")):
        if given is not None:
            raise InputError(f"{what} of one certificate; name one, or leave {what.split()[0]} away")
    return min(filter(None, [_check_one_of(arguments, name) for name in arguments.certificates]), default=0)


def _for_coq(arguments: argparse.Namespace) -> Answer | int:
    """Check a certificate and write it for Coq; nothing is written unless every statement is true."""
    from fairaudit.cli.checking import printable
    from fairaudit.cli.destinations import refuse_output
    from fairaudit.errors import FalseCertificate, InputError, TableNeeded
    from fairaudit.files import write_atomically
    from fairaudit.verified.coq_file import coq_file
    from fairaudit.verified.verification import checked, opened

    others = (arguments.attestation, arguments.key, arguments.recount, arguments.require)
    if len(arguments.certificates) != 1 or any(other is not None for other in others) or arguments.verbose:
        raise InputError("--coq writes one certificate for Coq: give that, --table FILE if it does not hold its table, and no other option")
    name, path = arguments.certificates[0], arguments.coq
    if not path.endswith(".v"):
        raise InputError(f"--coq {path} does not end in .v, as files of Coq do; name a file FILE.v")
    refuse_output(path, [one for one in (name, arguments.table) if one is not None], "what is checked")
    try:
        found = opened(name, arguments.table)
        found = replace(found, lines=None if found.lines is None else list(found.lines))
        said = checked(found)
        if not said:
            raise TableNeeded(f"{name} does not hold its table; give the file of the table by --table")
        made = coq_file(found.document, found.raw, found.lines)
    except (FalseCertificate, TableNeeded) as error:
        if not arguments.quiet:
            print(f"fairaudit: {printable(str(error))}", file=sys.stderr)
        return 1 if isinstance(error, FalseCertificate) else 3
    write_atomically(Path(path), [made.text.encode()])
    if arguments.quiet:
        return 0
    rest = f"; it names the other {made.left}" if made.left else ""
    sentence = printable(f"Every statement of the certificate is true, and {path} has {made.proved} of them for Coq to prove{rest}.")
    return Answer(
        "coq",
        sentence=sentence,
        result=lambda: {"file": path, "proved": made.proved, "left_out": made.left},
        text=lambda: sentence,
    )


def _check_one_of(arguments: argparse.Namespace, name: str) -> int:
    """Check one of several certificates and print what was found."""
    from fairaudit.cli.checking import printable
    from fairaudit.errors import without_passwords

    if not arguments.quiet and arguments.format == "text":
        print(f"{printable(without_passwords(name))}:")
    return tell(_check(arguments, name), arguments.format)


def _check(arguments: argparse.Namespace, name: str) -> Answer | int:
    from fairaudit.cli.checking import Refusal, attested_paragraph, examine, exit_code, lines, paragraph, printable, summary_line
    from fairaudit.errors import InputError, without_passwords

    try:
        attestation = _attestation(arguments)
    except InputError:
        if arguments.quiet:
            return 2
        raise
    found = examine(name, arguments.table, attestation)
    if isinstance(found, Refusal):
        if not arguments.quiet:
            print(f"fairaudit: {printable(without_passwords(f'{name}: {found.message}'))}", file=sys.stderr)
        return found.code
    # What is recounted is byte for byte what was checked; nothing is, where that is false, or not the signer's.
    payload = attestation if attestation is None or isinstance(attestation, bytes) else attestation.payload
    recount = None if payload is None or exit_code(found) == 1 else recount_of(arguments, name, payload)
    refused, again, counted = "", "", 0
    if isinstance(recount, InputError):
        refused, again, counted = str(recount), f" Nothing was recounted: {recount}.", 2
    elif recount is not None:
        again, counted = f" {recount.sentence}", recount.exit_code
    if isinstance(recount, InputError) or recount is None:
        compared = False
    else:
        compared = any(one.what == "how answers were read" and one.equal is not None for one in recount.findings)
    if compared:
        found = replace(found, outline=replace(found.outline, log=tuple(map(_counted_again, found.outline.log))))
    codes = exit_code(found, arguments.require), counted
    code = next(code for code in (1, 2, 3, 0) if code in codes)
    if arguments.quiet:
        return code
    said, attested = summary_line(found, arguments.require), found.attested
    true = exit_code(found) != 1 and counted != 1
    answer = Answer(
        "verify",
        # What is stated is no verdict where something is false: of the certificate, of its attestation, or of its log.
        verdict=found.verdict if true else "none",
        sentence=printable(f"{said[0].upper()}{said[1:]}.{again}"),
        notes=[FALSE_ALREADY] if arguments.recount is not None and recount is None else [],
        result=lambda: {
            "true": true,
            "stated_verdict": found.verdict,
            "required_verdict": arguments.require,
            "paragraph": paragraph(found, arguments.require),
            "assumptions": [{"assumption": text, "about": list(about)} for text, about in found.outline.assumptions],
            "statements": [_finding(finding) for finding in found.findings],
            **({} if attested is None else {"attestation": _attested(attested, attested_paragraph(found))}),
            **({} if recount is None else {"recount": as_json(recount)}),
        },
        text=lambda: "\n".join(
            map(printable, [*lines(found, arguments.require, verbose=arguments.verbose), *([] if recount is None else as_text(recount))])
        ),
        code=code,
    )
    if not refused:
        return answer
    tell(answer, arguments.format)
    print(f"fairaudit: {printable(refused)}", file=sys.stderr)
    return code


def _counted_again(text: str) -> str:
    """What the checker by itself says of a log, without that it was not looked at."""
    return text.replace(UNSEEN, ", which was counted again, as is said below: ").replace(UNCHECKED, ".")


def _attested(found: Attested, said: str) -> dict[str, Any]:
    """What was found of an attestation, for programs."""
    return {
        "true": found.ok,
        "signature": found.signature,
        "key": found.key or None,
        "paragraph": said,
        "statements": [_finding(finding) for finding in found.findings],
    }


def _attestation(arguments: argparse.Namespace) -> bytes | Signed | None:
    """Read the file of the attestation, once; of one whose signature is to be checked, say what was found of that."""
    if arguments.attestation is None:
        return None
    from fairaudit.attestations.verification import read_attestation, signed_by

    raw = read_attestation(arguments.attestation)
    return raw if arguments.key is None else signed_by(raw, arguments.key, arguments.attestation)


def _finding(found: Finding) -> dict[str, Any]:
    return {"statement": found.statement, "true": found.true, "detail": found.detail, "assumptions": list(found.assumes)}


def _export(path: str) -> Answer:
    from hashlib import sha256

    from fairaudit.cli.checking import zipped_checker
    from fairaudit.cli.destinations import refuse_output
    from fairaudit.files import write_atomically

    refuse_output(path, [])
    content = zipped_checker()
    write_atomically(Path(path), [content])
    digest = sha256(content).hexdigest()
    return Answer(
        "export",
        sentence=f"The checker was written to {path}.",
        result=lambda: {"file": path, "sha256": digest},
        text=lambda: f"{digest}  {path}",
    )
