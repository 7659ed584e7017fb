"""Libraries of the extras: what is missing is said, with what installs it."""

from __future__ import annotations

import json

import pytest

from fairaudit.errors import InputError
from fairaudit.libraries import library


def test_a_library_is_given_or_named_with_its_extra() -> None:
    assert library("json", "vlm") is json
    with pytest.raises(InputError, match=r"^no_such is not installed; install the extra: pip install 'fairaudit-certify\[plots\]'$"):
        library("no_such.part", "plots")
