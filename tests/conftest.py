"""Settings shared by all tests: a fixed hypothesis profile, where the sample data are, which tests are slow, what a machine lacks."""

from __future__ import annotations

import os
from pathlib import Path

import durations
import needs
import pytest
from hypothesis import HealthCheck, settings
from logs import files as files
from servers import postgres as postgres

settings.register_profile(
    "ci",
    max_examples=int(os.environ.get("FAIRAUDIT_EXAMPLES", "50")),
    deadline=None,
    derandomize=True,
    suppress_health_check=[HealthCheck.too_slow, HealthCheck.data_too_large],
)
settings.load_profile("ci")


def pytest_report_header() -> list[str]:
    """Say at the start how long it takes and what is skipped."""
    return needs.report()


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Mark the tests that ``tests/slow.txt`` lists as ``slow``."""
    slow = durations.recorded()
    for item in items:
        if durations.function(item.name) in slow:
            item.add_marker("slow")


@pytest.fixture(scope="session")
def data() -> Path:
    """Directory of the sample data; the test skips where they are absent."""
    if not needs.DATA.is_dir():
        pytest.skip("the sample data are not on this machine (expected in shared/data beside the checkout)")
    return needs.DATA
