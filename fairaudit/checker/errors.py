"""What keeps a document from being checked."""

from __future__ import annotations


class FormatError(ValueError):
    """The document is not a well-formed certificate (or table) of the format."""


class Incomplete(FormatError):
    """The certificate does not state what its claims assume."""


class TooMuch(FormatError):
    """Checking the certificate would take more work than a document of its length is given."""


class TableNeeded(Exception):
    """The table is not embedded in the certificate and was not given."""
