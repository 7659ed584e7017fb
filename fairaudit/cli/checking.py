"""The door of the command line to the checker, which shares no code with what wrote a certificate."""

from __future__ import annotations

import io
from pathlib import Path

from fairaudit import checker
from fairaudit.checker import (
    Attested,
    Finding,
    Refusal,
    Signed,
    attested_paragraph,
    examine,
    exit_code,
    lines,
    paragraph,
    printable,
    summary_line,
)

__all__ = [
    "Attested",
    "Finding",
    "Refusal",
    "Signed",
    "attested_paragraph",
    "examine",
    "exit_code",
    "lines",
    "paragraph",
    "printable",
    "summary_line",
    "zipped_checker",
]

_MAIN = '''"""Run the checker, whose files are in the folder beside this one."""

import sys

if sys.version_info < (3, 10):
    sys.stderr.write("The checker needs Python 3.10 or later, and this is %d.%d.\\n" % sys.version_info[:2])
    sys.exit(2)

from checker import main

sys.exit(main())
'''

_DATE = (1980, 1, 1, 0, 0, 0)  # the first that an archive can hold


def zipped_checker() -> bytes:
    """Put the files of the checker into one file that Python runs.

    The bytes depend on the text of the files alone: they are in the order of their names, stored as they are, with one date and one
    mode, whatever machine and Python write them.
    """
    import zipfile

    sources = sorted(Path(checker.__path__[0]).glob("*.py"))
    texts = {"__main__.py": _MAIN} | {f"checker/{path.name}": path.read_text("utf-8") for path in sources}
    content = io.BytesIO()
    with zipfile.ZipFile(content, "w", zipfile.ZIP_STORED) as archive:
        for name, text in texts.items():
            entry = zipfile.ZipInfo(name, _DATE)
            entry.create_system, entry.external_attr = 3, 0o100644 << 16
            archive.writestr(entry, text.encode("utf-8"))
    return content.getvalue()
