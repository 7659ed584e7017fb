"""A pytest fixture that fails a test when a fairness target is not met. It is there as soon as fairaudit and pytest are installed."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Any

import pytest

if TYPE_CHECKING:
    from fairaudit.audits.result import Result

__all__ = ["fairness_gate"]


@pytest.fixture
def fairness_gate() -> Callable[..., Result]:
    """Give a function with the arguments of `fairaudit.certify` that fails the test unless every target is kept.

    Returns
    -------
    callable
        Takes what `fairaudit.certify` takes, at least one target among them, and returns its `Result`. The test fails when a target is
        exceeded, and also when the draws do not decide: too few decisions are no evidence of fairness.
    """

    def gate(subject: Any, utility: Any, **options: Any) -> Result:
        from fairaudit.audits.certify import certify
        from fairaudit.reports.text import verdict
        from fairaudit.words import plain

        result = certify(subject, utility, **options)
        if result.verdict == "none":
            pytest.fail("the fairness gate has no target; give one, such as max_local_ratio='5/4'", pytrace=False)
        if result.verdict != "within":
            planned = [planned.sentence for _, planned in result.further_draws]
            pytest.fail("\n".join([verdict(result), plain(result.sentence), *planned]), pytrace=False)
        return result

    return gate
