"""MLflow: what a run keeps of a result, and the evaluator, with a store of MLflow's own in an empty folder."""

from __future__ import annotations

import hashlib
import json
import os
import subprocess
import sys
import tomllib
from collections.abc import Callable
from fractions import Fraction
from math import inf, isfinite
from pathlib import Path
from typing import Any

import pytest

import fairaudit as fa

ROOT = Path(__file__).resolve().parents[1]
TABLE = {"hired": ["yes", "no", "yes", "no"], "sex": ["f", "f", "m", "m"], "n": [300, 100, 200, 200]}

SCRIPT = r"""
import json, sys
import mlflow, pandas as pd
import fairaudit as fa

mlflow.set_tracking_uri("sqlite:///runs.db")
mlflow.set_experiment("fairness")
client = mlflow.MlflowClient()

def kept(run):
    data = client.get_run(run).data
    tags = {name: text for name, text in data.tags.items() if not name.startswith("mlflow.")}
    files = sorted(entry.path for entry in client.list_artifacts(run, "fairaudit"))
    return {"metrics": data.metrics, "params": data.params, "tags": tags, "files": files}

def refused(call):
    try:
        call()
    except fa.InputError as error:
        return str(error)

table = {"hired": ["yes", "no", "yes", "no"], "sex": ["f", "f", "m", "m"], "n": [300, 100, 200, 200]}
asked = {"decision": "hired", "group": "sex", "count": "n", "utility": "yes"}
result = fa.audit(table, **asked, max_local_ratio="5/4")
never = fa.audit({**table, "n": [300, 100, 0, 200]}, **asked, difference=True)
told = {}

run = result.log_to_mlflow()
told["ended"] = client.get_run(run).info.status, mlflow.active_run() is None
told["alone"] = kept(run)
folder = mlflow.artifacts.download_artifacts(run_id=run, artifact_path="fairaudit")
told["verified"] = fa.verify(folder + "/certificate.json").ok, fa.verify(folder + "/report.html").ok
told["again"] = result.log_to_mlflow(run_id=run) == run
told["other"] = refused(lambda: never.log_to_mlflow(run_id=run))
told["absent"] = refused(lambda: result.log_to_mlflow(run_id="0" * 32))
with mlflow.start_run() as active:
    told["active"] = never.log_to_mlflow(prefix="before") == result.log_to_mlflow() == active.info.run_id
    told["both"] = kept(active.info.run_id)

frame = pd.DataFrame({"sex": ["f", "m"] * 200, "score": range(400), "fit": [1, 0, 0, 1] * 100})
hired = (frame["score"] % 4 < 2) & ((frame["sex"] == "f") | (frame["score"] % 3 > 0))
asked = {"group": "sex", "utility": "1", "max_local_ratio": 1.25, "truth": True}
with mlflow.start_run() as active:
    found = mlflow.models.evaluate(
        lambda rows: hired[rows.index].astype(int), frame, targets="fit", model_type="classifier",
        evaluators="fairaudit", evaluator_config=asked,
    )
    told["model"] = {"metrics": found.metrics, "run": kept(active.info.run_id), "artifacts": sorted(found.artifacts)}
    told["read"] = json.loads(found.artifacts["fairaudit_certificate"].content)["verdict"]
same = fa.audit(frame.assign(hired=hired.astype(int)), decision="hired", group="sex", utility="1", truth="fit", max_local_ratio=1.25)
told["same"] = [str(same.local.ratio), same.verdict, float(same.given_truth.differences["equal_opportunity"].value)]

static = frame.assign(hired=hired.astype(int))
found = mlflow.models.evaluate(
    data=static, predictions="hired", targets="fit", model_type="classifier",
    evaluators=["fairaudit"], evaluator_config={"fairaudit": {**asked, "prefix": "gate"}},
)
told["static"] = found.metrics
told["typo"] = refused(lambda: mlflow.models.evaluate(
    data=static, predictions="hired", targets="fit", model_type="classifier", evaluators="fairaudit",
    evaluator_config={"group": "sex", "utilty": "1"}))
told["none"] = refused(lambda: mlflow.models.evaluate(
    data=static, targets="fit", model_type="classifier", evaluators="fairaudit", evaluator_config=asked))
print(json.dumps(told))
"""


@pytest.fixture(scope="module")
def told(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Any]:
    """What a program with MLflow finds, which knows of the evaluator by its entry point alone."""
    pytest.importorskip("mlflow", reason="mlflow is not installed (extra mlflow)")
    pytest.importorskip("sqlalchemy", reason="SQLAlchemy is not installed (it is in the extra test)")
    folder = tmp_path_factory.mktemp("mlflow")
    points = tomllib.loads((ROOT / "pyproject.toml").read_text("utf-8"))["project"]["entry-points"]["mlflow.model_evaluator"]
    installed = folder / "site" / "fairaudit_evaluator-1.dist-info"
    installed.mkdir(parents=True)
    (installed / "METADATA").write_text("Metadata-Version: 2.1\nName: fairaudit-evaluator\nVersion: 1\n")
    (installed / "entry_points.txt").write_text("[mlflow.model_evaluator]\n" + "".join(f"{name} = {at}\n" for name, at in points.items()))
    env = {**os.environ, "PYTHONPATH": os.pathsep.join([str(ROOT), str(installed.parent)]), "MLFLOW_DISABLE_TELEMETRY": "true"}
    done = subprocess.run([sys.executable, "-W", "ignore", "-c", SCRIPT], cwd=folder, env=env, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    found: dict[str, Any] = json.loads(done.stdout.splitlines()[-1])
    return found


def result(**given: Any) -> fa.Result:
    return fa.audit({**TABLE, **given.pop("table", {})}, decision="hired", group="sex", count="n", utility="yes", **given)


def test_a_run_keeps_a_result(told: dict[str, Any]) -> None:
    alone, made = told["alone"], result(max_local_ratio="5/4")
    interval = made.intervals["local"]
    assert told["ended"] == ["FINISHED", True]
    assert alone["metrics"]["fairaudit.local_ratio"] == 1.5 and alone["metrics"]["fairaudit.demographic_parity"] == 0.25
    assert Fraction(alone["metrics"]["fairaudit.local_ratio.at_least"]) <= interval.lower
    assert Fraction(alone["metrics"]["fairaudit.local_ratio.at_most"]) >= interval.upper
    assert alone["metrics"]["fairaudit.exit_code"] == 1
    assert alone["params"] == {
        "fairaudit.version": fa.__version__,
        "fairaudit.certificate_sha256": hashlib.sha256(made.certificate.text.encode()).hexdigest(),
        "fairaudit.decision": "hired",
        "fairaudit.group": "sex",
        "fairaudit.max_local_ratio": "5/4",
        "fairaudit.local_ratio.confidence": "0.95",
        "fairaudit.global_ratio.confidence": "0.95",
    }
    assert alone["tags"] == {"fairaudit.verdict": "exceeds", "fairaudit.sentence": made.sentence}
    assert alone["files"] == ["fairaudit/certificate.json", "fairaudit/report.html"]
    assert told["verified"] == [True, True]


@pytest.mark.deep
def test_a_run_holds_one_result_under_a_prefix(told: dict[str, Any]) -> None:
    assert told["again"] and told["active"]
    assert "a run holds one result under the prefix 'fairaudit', and prefix= gives another" in told["other"]
    assert "0" * 32 in told["absent"] and "\n" not in told["absent"]
    both = told["both"]
    assert (both["metrics"]["fairaudit.local_ratio"], both["metrics"]["before.local_difference"]) == (1.5, 0.75)
    assert "before.local_ratio" not in both["metrics"]  # it is infinite
    assert both["tags"]["before.verdict"] == "none"


@pytest.mark.deep
def test_the_evaluator_audits_a_model(told: dict[str, Any]) -> None:
    model = told["model"]
    ratio, verdict, opportunity = told["same"]
    assert model["metrics"]["fairaudit.local_ratio"] == float(Fraction(ratio)) == model["run"]["metrics"]["fairaudit.local_ratio"]
    assert model["metrics"]["fairaudit.equal_opportunity"] == opportunity
    assert model["run"]["tags"]["fairaudit.verdict"] == verdict == told["read"]
    assert model["artifacts"] == ["fairaudit_certificate", "fairaudit_page"]
    assert model["run"]["params"]["fairaudit.decision"] == "prediction"


@pytest.mark.deep
def test_the_evaluator_audits_predictions_that_are_there(told: dict[str, Any]) -> None:
    assert told["static"] == {name.replace("fairaudit.", "gate."): value for name, value in told["model"]["metrics"].items()}


@pytest.mark.deep
def test_the_evaluator_answers_in_one_sentence(told: dict[str, Any]) -> None:
    assert told["typo"] == "audit has no argument utilty; did you mean utility?"
    assert told["none"] == "there are no predictions to audit; give a model, or name their column with predictions="


def test_the_evaluator_takes_no_part_unasked() -> None:
    pytest.importorskip("mlflow", reason="mlflow is not installed (extra mlflow)")
    from fairaudit.mlflow_plugin import FairnessEvaluator

    assert FairnessEvaluator.can_evaluate(evaluator_config={"group": "sex"}, model_type="classifier")
    assert not FairnessEvaluator.can_evaluate(evaluator_config={}, model_type="classifier")
    assert not FairnessEvaluator.can_evaluate(evaluator_config=None, model_type="classifier", later="argument")


@pytest.mark.parametrize("value", [Fraction(1, 3), Fraction(2, 3), Fraction(5, 4), Fraction(10**30 + 1, 10**30), Fraction(1, 10**400)])
def test_ends_are_rounded_outwards(value: Fraction) -> None:
    pytest.importorskip("mlflow", reason="mlflow is not installed (extra mlflow)")
    from fairaudit.mlflow_plugin import _outwards

    assert Fraction(_outwards(value, -inf)) <= value <= Fraction(_outwards(value, inf))
    assert _outwards(inf, inf) == inf


@pytest.mark.parametrize("least", ["1e-400", "1e400"])
def test_what_no_float_holds_is_no_metric(least: str) -> None:
    pytest.importorskip("mlflow", reason="mlflow is not installed (extra mlflow)")
    from fairaudit.mlflow_plugin import _asked, figures

    utility = {"yes": 1, "no": least} if least != "1e-400" else {"yes": least}
    table = {**TABLE, "hired": ["yes", "no", "yes", "no"], "n": [300, 100, 0, 200]}
    made = fa.audit(table, decision="hired", group="sex", count="n", utility=utility, difference=True, confidence=1 - Fraction(1, 10**8))
    found = figures(made)
    assert all(isfinite(value) for value in found.values())
    assert found["local_difference.at_least"] <= made.differences.intervals["local"].lower
    assert dict(_asked(made))["local_ratio.confidence"] == "0.999999"


def test_without_mlflow_it_says_what_to_install(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "mlflow", None)
    monkeypatch.delitem(sys.modules, "fairaudit.mlflow_plugin", raising=False)
    call: Callable[[], str] = result().log_to_mlflow
    with pytest.raises(fa.InputError, match=r"this needs the library mlflow: pip install 'fairaudit-certify\[mlflow\]'"):
        call()
