"""The recipes of docs/gates.md, each run or checked as it stands there; and the hooks, by pre-commit itself."""

from __future__ import annotations

import json
import os
import re
import shutil
import subprocess
import sys
from pathlib import Path

import pytest
import yaml

from fairaudit import verify

ROOT = Path(__file__).resolve().parents[2]
PAGE = (ROOT / "docs" / "gates.md").read_text("utf-8")
BLOCKS = re.findall(r"^```(\w+)\n(.*?)^```", PAGE, re.MULTILINE | re.DOTALL)
ACTION = yaml.safe_load((ROOT / "action.yml").read_text("utf-8"))
HOOKS = yaml.safe_load((ROOT / ".pre-commit-hooks.yaml").read_text("utf-8"))


def block(language: str, start: str = "") -> str:
    """The one block of the page in a language that begins with a text."""
    (found,) = [text for name, text in BLOCKS if name == language and text.startswith(start)]
    return found


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """What the page has made by the time that the pipelines come: table and audit file; `fairaudit` is that of this tree."""
    monkeypatch.chdir(tmp_path)
    exec(compile(block("python", "import pandas"), "gates.md", "exec"), {})  # noqa: S102
    (tmp_path / "audit.toml").write_text(block("toml"))
    (tmp_path / "bin").mkdir()
    tool = tmp_path / "bin" / "fairaudit"
    tool.write_text(f'#!/bin/sh\nPYTHONPATH={ROOT} exec {sys.executable} -m fairaudit "$@"\n')
    tool.chmod(0o755)
    monkeypatch.setenv("PATH", f"{tool.parent}{os.pathsep}{os.environ['PATH']}")
    return tmp_path


def bash(script: str) -> subprocess.CompletedProcess[str]:
    return subprocess.run(["bash", "-c", script], stdout=subprocess.PIPE, stderr=subprocess.STDOUT, encoding="utf-8", check=False)


def test_the_command_of_the_page(folder: Path) -> None:
    done = bash(next(text for name, text in BLOCKS if name == "sh" and "audit.toml" in text))
    assert done.stdout.rstrip().endswith("exit code 1")
    judged = verify("certificate.json")
    assert (judged.ok, judged.verdict) == (True, "exceeds")
    document = json.loads(Path("certificate.json").read_text("utf-8"))
    assert document["metrics"]["local"]["ratio"] == "25/17"  # 2500 to 1700
    assert "1.471 times as often" in PAGE


def test_a_repaired_model_passes(folder: Path) -> None:
    exec(compile(block("python", "import pandas").replace("1700", "2450"), "gates.md", "exec"), {})  # noqa: S102
    assert bash("fairaudit certify audit.toml").returncode == 0


def test_make_and_shell(folder: Path) -> None:
    if shutil.which("make") is None:
        pytest.skip("make is not on this machine")
    Path("Makefile").write_text(block("make"))
    assert bash("make -s fairness").returncode == 2
    assert bash(block("bash")).returncode == 1
    Path("audit.toml").write_text(block("toml").replace("5/4", "7/5"))  # 1.361 to 1.563: not settled
    done = bash(block("bash"))
    assert (done.returncode, done.stdout.splitlines()[-1]) == (0, "fairness is not settled by these decisions")


def test_the_test_of_the_page(folder: Path) -> None:
    Path("test_fairness.py").write_text(block("python", "# test_fairness.py"))
    words = [sys.executable, "-m", "pytest", "-q", "-p", "no:cacheprovider", "-c", "/dev/null", "--rootdir", ".", "--junitxml=gates.xml"]
    done = subprocess.run([*words, "test_fairness.py"], capture_output=True, encoding="utf-8", check=False)
    assert "1 failed" in done.stdout
    assert verify("certificate.json").verdict == "exceeds"
    properties = re.findall(r'property name="(fairness[\w.]+)"', Path("gates.xml").read_text("utf-8"))
    assert set(re.findall(r"`(fairness\.[\w.]+)`", PAGE)) <= set(properties)


@pytest.mark.parametrize(
    ("name", "schema", "start"),
    [("fairness.yml", "vendor.github-workflows", "# .github/"), (".gitlab-ci.yml", "vendor.gitlab-ci", "# .gitlab-ci")],
)
def test_files_for_services_keep_their_schemas(tmp_path: Path, name: str, schema: str, start: str) -> None:
    check = Path(sys.executable).with_name("check-jsonschema")
    if not check.exists():
        pytest.skip("check-jsonschema is not installed")
    (tmp_path / name).write_text(block("yaml", start))
    done = subprocess.run([str(check), "--builtin-schema", schema, str(tmp_path / name)], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stdout


def test_the_script_of_gitlab_runs(folder: Path) -> None:
    job = yaml.safe_load(block("yaml", "# .gitlab-ci"))["fairness"]
    done = bash("set -e\n" + "\n".join(line for line in job["script"] if not line.startswith("pip ")))
    assert done.returncode == 1
    assert all((folder / path).is_file() for path in job["artifacts"]["paths"])


def test_the_action_is_used_as_it_is_declared() -> None:
    used = [yaml.safe_load(block("yaml", "# .github/"))["jobs"]["gate"]["steps"][1], yaml.safe_load(block("yaml", "# a step"))]
    for step in used:
        assert set(step["with"]) <= set(ACTION["inputs"])
    table = PAGE.split("| input | default | |")[1].split("\n\n")[0]
    named = {name for line in table.splitlines()[2:] for name in re.findall(r"`([\w-]+)`", line.split("|")[1])}
    assert named == set(ACTION["inputs"])
    outputs = PAGE.split("Outputs, for later steps")[1].split("No input")[0]
    assert all(f"`{name}`" in outputs for name in ACTION["outputs"])


def git(*words: str, cwd: Path) -> str:
    identity = ["-c", "user.name=a", "-c", "user.email=a@example.org", "-c", "commit.gpgsign=false", "-c", "core.hooksPath=.git/hooks"]
    done = subprocess.run(
        ["git", *identity, *words], cwd=cwd, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, encoding="utf-8", check=False
    )
    assert done.returncode == 0 or "hook id" in done.stdout, done.stdout
    return done.stdout


@pytest.fixture
def released(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The package and its hooks as a repository that others refer to."""
    clone = tmp_path_factory.mktemp("released")
    shutil.copytree(ROOT / "fairaudit", clone / "fairaudit", ignore=shutil.ignore_patterns("__pycache__"))
    for name in ("pyproject.toml", "README.md", "LICENSE", ".pre-commit-hooks.yaml"):
        shutil.copy(ROOT / name, clone / name)
    git("init", "-q", cwd=clone)
    git("add", "-A", cwd=clone)
    git("commit", "-qm", "release", cwd=clone)
    git("tag", "v0.1.0", cwd=clone)
    return clone


def test_a_commit_is_stopped_until_the_gate_is_kept(folder: Path, released: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """The recipe of the page, by pre-commit itself, in real commits; it installs the hooks and asks the package index."""
    monkeypatch.setenv("PRE_COMMIT_HOME", str(folder.parent / "hooks"))
    tool = Path(sys.executable).with_name("pre-commit")
    if not tool.exists():
        pytest.skip("pre-commit is not installed")
    recipe = block("yaml", "# .pre-commit").replace("https://github.com/OWNER/fairaudit", str(released))
    home = folder / "repository"
    home.mkdir()
    for name in ("audit.toml", "decisions.csv"):
        shutil.copy(folder / name, home / name)
    (home / ".pre-commit-config.yaml").write_text(recipe)
    git("init", "-q", cwd=home)
    done = subprocess.run(
        [str(tool), "install", "--install-hooks"], cwd=home, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, check=False
    )
    if done.returncode and "No matching distribution" in done.stdout:
        pytest.skip("the package index cannot be asked from here")
    assert done.returncode == 0, done.stdout
    git("add", "-A", cwd=home)
    refused = git("commit", "-m", "first", cwd=home)
    assert "exit code: 1" in refused
    assert "EXCEEDS" in refused.upper()
    (home / "audit.toml").write_text((home / "audit.toml").read_text().replace("5/4", "8/5"))
    git("add", "-A", cwd=home)
    assert "files were modified by this hook" in git("commit", "-m", "second", cwd=home)
    git("add", "-A", cwd=home)
    git("commit", "-m", "third", cwd=home)
    assert git("log", "--format=%s", cwd=home).split() == ["third"]
    assert verify(home / "certificate.json").verdict == "within"
    (home / "old.certificate.json").write_text((home / "certificate.json").read_text("utf-8").replace('"25/17"', '"24/17"'))
    git("add", "-A", cwd=home)
    stopped = git("commit", "-m", "fourth", cwd=home)
    assert "certificates are true" in stopped
    assert "FALSE" in stopped
