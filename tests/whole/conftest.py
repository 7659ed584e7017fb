"""What several tests of the whole share."""

from __future__ import annotations

import os
from pathlib import Path

import pytest
from built_proofs import PROOFS, build
from verified_roads import driver


@pytest.fixture(scope="module")
def program(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The verified program, which judges many documents in one process, where the proofs were built before or have to be."""
    if os.environ.get("FAIRAUDIT_COQ") != "1" and not (PROOFS / "checker" / "Certificate.vo").is_file():
        pytest.skip("the proofs are not built: make -C proofs, see docs/proofs.md")
    return driver(build("build/fairaudit-check") / "build", tmp_path_factory.mktemp("driver"))
