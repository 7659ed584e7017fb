"""Logs that Inspect makes while the tests run, and the library that packs them."""

from __future__ import annotations

import subprocess
import sys
import zipfile
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import pytest

with_zstd: Any = zipfile if sys.version_info >= (3, 14) else pytest.importorskip("backports.zstd.zipfile", reason="needs backports.zstd")


def logs_of(script: str, folder: Path) -> Path:
    """Run a script of this folder that writes logs; the test skips without Inspect."""
    if find_spec("inspect_ai") is None:  # it changes zipfile for everybody, so it is imported by another process alone
        pytest.skip("needs inspect_ai")
    made = subprocess.run([sys.executable, Path(__file__).with_name(script), folder], capture_output=True, text=True)
    assert made.returncode == 0, made.stderr
    return folder
