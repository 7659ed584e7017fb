"""Libraries of the extra, imported where they are needed."""

from __future__ import annotations

import importlib
from typing import Any

from fairaudit.errors import InputError

__all__ = ["library"]


def library(module: str) -> Any:
    """Import a library of the extra ``navigation``.

    Raises
    ------
    InputError
        If it is not installed; the message says how to install it.
    """
    try:
        return importlib.import_module(module)
    except ImportError:
        raise InputError(f"{module} is not installed; install the extra: pip install 'fairaudit-certify[navigation]'") from None
