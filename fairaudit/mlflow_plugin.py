"""Results in MLflow: what an audit found as metrics, tags and artifacts of a run, and the evaluator of ``mlflow.models.evaluate``."""

from __future__ import annotations

import time
from collections.abc import Iterator, Mapping
from hashlib import sha256
from math import inf, isfinite, nextafter
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import TYPE_CHECKING, Any

import mlflow
from mlflow.entities import Metric, Param, RunTag
from mlflow.exceptions import MlflowException
from mlflow.models.evaluation import EvaluationArtifact, EvaluationResult, ModelEvaluator

from fairaudit import __version__
from fairaudit.errors import InputError, shown
from fairaudit.words import approximate, plain

if TYPE_CHECKING:
    from fairaudit.audits.result import Result
    from fairaudit.exact.extended import Extended

__all__ = ["FairnessEvaluator", "PageArtifact", "figures", "log"]

LONGEST = 5_000
"""Characters of a parameter or tag; MLflow keeps 6,000 and 8,000."""

DECISION = "prediction"

TRUTH = "target"

FILES = {"certificate": "certificate.json", "page": "report.html"}


def log(result: Result, *, prefix: str = "fairaudit", run_id: str | None = None) -> str:
    """Keep a result in a run of MLflow, as `fairaudit.Result.log_to_mlflow` says.

    Raises
    ------
    InputError
        If the run holds another result under that prefix, or MLflow refuses.
    """
    if run_id is None:
        active = mlflow.active_run()
        if active is not None:
            return log(result, prefix=prefix, run_id=active.info.run_id)
        with mlflow.start_run() as begun:
            return log(result, prefix=prefix, run_id=begun.info.run_id)
    _keep(result, prefix, run_id)
    return run_id


def _keep(result: Result, prefix: str, run_id: str) -> str:
    """Keep a result in a run, and give its page."""
    client, now = mlflow.MlflowClient(), int(1000 * time.time())
    with TemporaryDirectory() as folder:
        result.certificate.save(Path(folder) / FILES["certificate"])
        page = result.report(Path(folder) / FILES["page"])
        try:
            client.log_batch(run_id, params=[Param(f"{prefix}.{name}", text[:LONGEST]) for name, text in _asked(result)])
            client.log_batch(
                run_id,
                metrics=[Metric(f"{prefix}.{name}", value, now, 0) for name, value in figures(result).items()],
                tags=[RunTag(f"{prefix}.{name}", plain(text)[:LONGEST]) for name, text in _said(result)],
            )
            client.log_artifacts(run_id, folder, prefix)
        except MlflowException as error:
            said = " ".join(str(error).split())[:300]
            raise InputError(
                f"run {run_id} of MLflow does not take the result; a run holds one result under the prefix {shown(prefix)}, "
                f"and prefix= gives another: {said}"
            ) from None
    return page


def figures(result: Result) -> dict[str, float]:
    """The figures of a result as floats, ends of intervals rounded outwards; none that is infinite, which MLflow takes for a number.

    Examples
    --------
    >>> import fairaudit as fa
    >>> table = {"hired": ["yes", "no", "yes", "no"], "sex": ["f", "f", "m", "m"], "n": [300, 100, 200, 200]}
    >>> result = fa.audit(table, decision="hired", group="sex", count="n", utility="yes", max_local_ratio="5/4")
    >>> found = figures(result)
    >>> found["local_ratio"], found["demographic_parity"], found["local_ratio.at_least"] > 1.25, found["exit_code"]
    (1.5, 0.25, True, 1.0)
    """
    found = {name: value for name, value in _figures(result) if isfinite(value)}
    return {**found, "exit_code": float(result.exit_code)}


def _figures(result: Result) -> Iterator[tuple[str, float]]:
    for quantity, measured in (("local", result.local), ("global", result.global_)):
        if measured is not None and not result.utility.signed:
            yield f"{quantity}_ratio", _nearest(measured.ratio)
    for quantity, interval in result.intervals.items():
        yield f"{quantity}_ratio.at_least", _outwards(interval.lower, -inf)
        yield f"{quantity}_ratio.at_most", _outwards(interval.upper, inf)
    apart = result.differences
    for quantity, difference in (apart.measured if apart else {}).items():
        if difference is not None:
            yield f"{quantity}_difference", _nearest(difference.value)
    for quantity, ends in (apart.intervals if apart else {}).items():
        yield f"{quantity}_difference.at_least", _outwards(ends.lower, -inf)
        yield f"{quantity}_difference.at_most", _outwards(ends.upper, inf)
    for name, distance in result.distances.items():
        if distance is not None:
            yield name.replace(" ", "_"), float(distance.value)
    for name, rate in (result.given_truth.differences if result.given_truth else {}).items():
        if rate is not None:
            yield name, float(rate.value)


def _nearest(value: Extended) -> float:
    """A float; what is beyond the greatest is infinite."""
    try:
        return float(value)
    except OverflowError:
        return inf if value > 0 else -inf


def _outwards(value: Extended, towards: float) -> float:
    """A float that is not inside an interval that ends at a value."""
    rounded = _nearest(value)
    return nextafter(rounded, towards) if (rounded > value if towards < 0 else rounded < value) else rounded


def _asked(result: Result) -> Iterator[tuple[str, str]]:
    """What was audited, and against what, as texts."""
    columns = result.columns
    yield "version", __version__
    yield "certificate_sha256", sha256(result.certificate.text.encode("ascii")).hexdigest()
    for name, value in (("decision", columns.decision), ("group", ", ".join(columns.group)), ("context", ", ".join(columns.context))):
        if value:
            yield name, plain(value)
    for target in result.targets:
        place = f"max_{target.quantity}_{target.unit}"
        yield f"{place}.{target.under.replace(' ', '_')}" if target.under else place, str(target.limit)
    for quantity, interval in result.intervals.items():
        yield f"{quantity}_ratio.confidence", approximate(interval.confidence, "down", 6)


def _said(result: Result) -> Iterator[tuple[str, str]]:
    yield "verdict", result.verdict
    yield "sentence", result.sentence


class PageArtifact(EvaluationArtifact):
    """A text among the artifacts of an evaluation: the certificate, or the page."""

    def _save(self, output_artifact_path: str) -> None:
        Path(output_artifact_path).write_text(self._content, encoding="utf-8", newline="\n")

    def _load_content_from_file(self, local_artifact_path: str) -> str:
        text = Path(local_artifact_path).read_text("utf-8")
        self._content = text
        return text


class FairnessEvaluator(ModelEvaluator):
    """Audits the predictions of a model, or those of a table, for ``evaluators="fairaudit"`` of ``mlflow.models.evaluate``.

    The configuration is what `fairaudit.audit` takes besides the table and the decision, such as ``{"group": "sex", "utility": "1",
    "max_local_ratio": 1.25}``; ``"truth": True`` judges rates given the targets, too, and ``"prefix"`` is that of `log`. Without a
    ``"group"`` it does not evaluate, so that it never takes part unasked.
    """

    @classmethod
    def can_evaluate(cls, *, evaluator_config: Mapping[str, Any] | None, **_: Any) -> bool:
        """Whether a group is named."""
        return "group" in (evaluator_config or {})

    def evaluate(
        self,
        *,
        dataset: Any,
        run_id: str,
        evaluator_config: Mapping[str, Any] | None,
        model: Any = None,
        predictions: str | None = None,
        **_: Any,
    ) -> EvaluationResult:
        """Audit the predictions, and keep the result in the run.

        Raises
        ------
        InputError
            If there are no predictions, or as `fairaudit.audit` and `log`.
        """
        from fairaudit.audits.from_table import audit

        asked = dict(evaluator_config or {})
        prefix = asked.pop("prefix", "fairaudit")
        table = _table(dataset, model, predictions)
        if asked.get("truth") is True:
            asked["truth"] = TRUTH
        result = audit(table, decision=DECISION, **asked)
        texts = {"certificate": result.certificate.text, "page": _keep(result, prefix, run_id)}
        artifacts = {
            f"{prefix}_{name}": PageArtifact(mlflow.get_artifact_uri(f"{prefix}/{file}"), texts[name])  # type: ignore[no-untyped-call]
            for name, file in FILES.items()
        }
        return EvaluationResult(  # type: ignore[no-untyped-call]
            {f"{prefix}.{name}": value for name, value in figures(result).items()}, artifacts, run_id
        )


def _table(dataset: Any, model: Any, column: str | None) -> Any:
    """Features with the predictions, and the targets where there are any, as a frame."""
    import pandas as pd

    features = dataset.features_data
    if not isinstance(features, pd.DataFrame):
        features = pd.DataFrame(features, columns=list(dataset.feature_names))
    predicted = dataset.predictions_data if model is None else model.predict(features)
    if isinstance(predicted, pd.DataFrame):
        if column is None and predicted.shape[1] != 1:
            raise InputError(f"the model gives {predicted.shape[1]} columns; name that of the decision with predictions=")
        predicted = predicted[column] if column is not None else predicted.iloc[:, 0]
    if predicted is None:
        raise InputError("there are no predictions to audit; give a model, or name their column with predictions=")
    for name in (DECISION, TRUTH):
        if name in features.columns:
            raise InputError(f"the data has a column {name!r} among the features, as the audit calls its own; rename it")
    found = {DECISION: list(predicted)} | ({} if dataset.labels_data is None else {TRUTH: list(dataset.labels_data)})
    return features.reset_index(drop=True).assign(**found)
