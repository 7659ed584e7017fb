"""`fairaudit verify`: check a certificate with the independent checker, and nothing else."""

from __future__ import annotations

import argparse
import contextlib
import io
import sys
from pathlib import Path
from typing import Any

_MAIN = '''"""Run the checker, whose files are in the folder beside this one."""

import sys

from checker import main

sys.exit(main())
'''

_DATE = (1980, 1, 1, 0, 0, 0)  # the first that an archive can hold


def add(commands: Any) -> None:
    """Declare the options."""
    parser = commands.add_parser(
        "verify",
        help="check a certificate",
        description="Check every statement of a certificate, in exact integer arithmetic and with none of the code that wrote it.",
        epilog="exit codes: 0 all true; 1 a statement is false, or the required verdict is not there; 2 bad input; 3 the table is needed",
        usage="%(prog)s CERTIFICATE.json [--table FILE] [--require within]\n       %(prog)s --export FILE.pyz",
        allow_abbrev=False,
    )
    parser.set_defaults(run=run)
    parser.add_argument("certificate", metavar="CERTIFICATE.json", nargs="?", help="the certificate")
    parser.add_argument("--table", metavar="FILE", help="the canonical table, when the certificate does not hold it")
    parser.add_argument("--require", choices=("within",), help="also fail unless the verdict is 'within'")
    parser.add_argument(
        "--export",
        metavar="FILE.pyz",
        help="write the checker as one file, which runs as `python -I -S FILE.pyz CERTIFICATE.json`, and print its SHA-256",
    )


def run(arguments: argparse.Namespace) -> int:
    """Hand over to the checker, or write it as one file."""
    from fairaudit import checker
    from fairaudit.errors import InputError

    if arguments.export is not None:
        if (arguments.certificate, arguments.table, arguments.require) != (None, None, None):
            raise InputError("--export writes the checker and checks nothing; leave the certificate, --table and --require away")
        return _export(Path(arguments.export))
    if arguments.certificate is None:
        raise InputError("no certificate is named; give its file, or --export FILE.pyz to write the checker")
    options = [f"--table={arguments.table}"] if arguments.table is not None else []
    options += [f"--require={arguments.require}"] if arguments.require is not None else []
    said = io.StringIO()
    with contextlib.redirect_stderr(said):
        code = checker.main([*options, "--", arguments.certificate])
    for line in said.getvalue().splitlines():
        print(f"fairaudit: {checker.printable(arguments.certificate)}: {line}", file=sys.stderr)
    return code


def _export(path: Path) -> int:
    from hashlib import sha256

    from fairaudit.files import write_atomically

    content = zipped_checker()
    write_atomically(path, [content])
    print(f"{sha256(content).hexdigest()}  {path}")
    return 0


def zipped_checker() -> bytes:
    """Put the files of the checker into one file that Python runs.

    The bytes depend on the text of the files alone: they are in the order of their names, stored as they are, with one date and one
    mode, whatever machine and Python write them.
    """
    import zipfile

    import fairaudit.checker

    sources = sorted(Path(fairaudit.checker.__path__[0]).glob("*.py"))
    texts = {"__main__.py": _MAIN} | {f"checker/{path.name}": path.read_text("utf-8") for path in sources}
    content = io.BytesIO()
    with zipfile.ZipFile(content, "w", zipfile.ZIP_STORED) as archive:
        for name, text in texts.items():
            entry = zipfile.ZipInfo(name, _DATE)
            entry.create_system, entry.external_attr = 3, 0o100644 << 16
            archive.writestr(entry, text.encode("utf-8"))
    return content.getvalue()
