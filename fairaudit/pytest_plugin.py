"""A pytest fixture that fails a test when a fairness target is not met. It is there as soon as fairaudit and pytest are installed."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator
from typing import TYPE_CHECKING, Any

import pytest

if TYPE_CHECKING:
    from fairaudit.audits.result import Result

__all__ = ["fairness_gate"]


def pytest_addoption(parser: pytest.Parser) -> None:
    """Declare the setting for readers of JUnit files that refuse properties of a test."""
    help_ = (
        "whether fairness_gate leaves properties in the file of --junitxml; false for readers that hold it against a schema without them"
    )
    parser.addini("fairness_properties", help_, type="bool", default=True)


@pytest.fixture
def fairness_gate(request: pytest.FixtureRequest) -> Callable[..., Result]:
    """Give a function that fails the test unless every target is kept.

    With ``pytest --junitxml=FILE``, each gate leaves its verdict, sentence, ratios, their ends and the path of its certificate as
    properties of the test, and what was kept in its standard output; a gate that is not kept says the same in its failure.

    Returns
    -------
    callable
        Takes the `Result` of `fairaudit.audit` or what `fairaudit.certify` takes, with at least one target, and ``save``, where to write
        the certificate; returns the `Result`. The test fails when a target is exceeded, and also when the draws do not decide: too few
        decisions are no evidence of fairness. The certificate is written before that.
    """
    gates = 0

    def gate(subject: Any, *utility: Any, save: str | os.PathLike[str] | None = None, **options: Any) -> Result:
        from fairaudit.audits.certify import certify
        from fairaudit.audits.result import Result
        from fairaudit.reports.overview import of_result
        from fairaudit.words import plain

        nonlocal gates
        gates += 1
        judged = isinstance(subject, Result) and not utility and not options
        result: Result = subject if judged else certify(subject, *utility, **options)
        written = "" if save is None else str(result.certificate.save(save)[0])
        found = of_result(result)
        sentence = " ".join((*found.cautions, *found.sentences))
        if request.config.getini("fairness_properties"):
            prefix = f"fairness{gates if gates > 1 else ''}"
            request.node.user_properties += [(f"{prefix}.{name}", plain(value)) for name, value in _properties(result, sentence, written)]
        if result.verdict == "none":
            pytest.fail("the fairness gate has no target; give one, such as max_local_ratio='5/4'", pytrace=False)
        said = [
            *(f"{verdict.upper()} {limit}" for verdict, limit in found.targets),
            sentence,
            *(f"Established beyond chance: {answer} ({why})" for answer, why in found.chance),
            *([f"Certificate: {written}"] if written else []),
        ]
        if result.verdict != "within":
            pytest.fail("\n".join(map(plain, said)), pytrace=False)
        print("\n".join(map(plain, said)))  # noqa: T201 - pytest keeps it with the test
        return result

    return gate


def _properties(result: Result, sentence: str, written: str) -> Iterator[tuple[str, str]]:
    """What a gate found: ratios exactly, ends of intervals rounded outwards."""
    from fairaudit.certificates.numbers import number
    from fairaudit.words import approximate

    yield "verdict", result.verdict
    yield "sentence", sentence
    for name, measured in (("local", result.local), ("global", result.global_)):
        if measured is not None:
            yield f"{name}.ratio", number(measured.ratio)
    for name, interval in result.intervals.items():
        yield f"{name}.at_least", approximate(interval.lower, "down")
        yield f"{name}.at_most", approximate(interval.upper, "up")
        yield f"{name}.confidence", number(interval.confidence)
    if written:
        yield "certificate", written
