"""Settings shared by all tests: a fixed hypothesis profile, and where the sample data are."""

from __future__ import annotations

import os
from pathlib import Path

import pytest
from hypothesis import HealthCheck, settings
from logs import files as files
from servers import postgres as postgres

settings.register_profile(
    "ci",
    max_examples=int(os.environ.get("FAIRAUDIT_EXAMPLES", "150")),
    deadline=None,
    derandomize=True,
    suppress_health_check=[HealthCheck.too_slow, HealthCheck.data_too_large],
)
settings.load_profile("ci")

DATA = Path(__file__).resolve().parents[2] / "shared" / "data"


@pytest.fixture(scope="session")
def data() -> Path:
    """Directory of the sample data; the test skips where they are absent."""
    if not DATA.is_dir():
        pytest.skip("the sample data are not on this machine (expected in shared/data beside the checkout)")
    return DATA
