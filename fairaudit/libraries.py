"""Libraries of the extras, imported where they are needed."""

from __future__ import annotations

import importlib
from typing import Any

from fairaudit.errors import InputError

__all__ = ["library"]


def library(module: str, extra: str) -> Any:
    """Import a library of an extra.

    Raises
    ------
    InputError
        If it is not installed; the message says how to install it.

    Examples
    --------
    >>> library("no_such_library", "vlm")
    Traceback (most recent call last):
    fairaudit.errors.InputError: no_such_library is not installed; install the extra: pip install 'fairaudit-certify[vlm]'
    """
    try:
        return importlib.import_module(module)
    except ImportError:
        name = module.partition(".")[0]
        raise InputError(f"{name} is not installed; install the extra: pip install 'fairaudit-certify[{extra}]'") from None
