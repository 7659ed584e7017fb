"""What is written to a file, by how its name ends."""

from __future__ import annotations

import os
from pathlib import Path
from typing import Literal

from fairaudit.errors import InputError, shown

__all__ = ["ENDINGS", "Form", "form_of"]

Form = Literal["json", "html", "pdf", "markdown", "model-card", "picture"]

ENDINGS: dict[str, Form] = {
    ".json": "json",
    ".html": "html",
    ".htm": "html",
    ".pdf": "pdf",
    ".md": "markdown",
    ".svg": "picture",
    ".png": "picture",
}


def form_of(path: str | os.PathLike[str]) -> Form:
    """What is written to a file of this name.

    Raises
    ------
    InputError
        If its name ends otherwise.

    Examples
    --------
    >>> form_of("certificate.json"), form_of("page.HTML"), form_of("page.pdf"), form_of("note.md"), form_of("picture.svg")
    ('json', 'html', 'pdf', 'markdown', 'picture')
    """
    ending = Path(path).suffix.lower()
    if ending not in ENDINGS:
        what = f"ends in {shown(ending)}" if ending else "has no ending"
        raise InputError(
            f"{os.fspath(path)} {what}, which does not say what to write; .json (the certificate), .html (a page), .pdf (that in print), "
            ".md (markdown), and .svg and .png (a picture) do"
        )
    return ENDINGS[ending]
