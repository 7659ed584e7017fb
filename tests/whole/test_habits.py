"""Makefile, CI, hooks and the pages about them say the same, and do what they say."""

from __future__ import annotations

import os
import re
import shutil
import subprocess
import sys
import tomllib
from pathlib import Path

import needs
import parts
import pytest
import tiers

ROOT = Path(__file__).resolve().parents[2]
MAKEFILE = (ROOT / "Makefile").read_text("utf-8")
CONTRIBUTING = (ROOT / "CONTRIBUTING.md").read_text("utf-8")
README = (ROOT / "README.md").read_text("utf-8")
PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text("utf-8"))["project"]
TARGETS = re.findall(r"^([a-z]+):.*## ", MAKEFILE, re.MULTILINE)
TRIED = {"numpy": "2.0", "scipy": "1.13", "pandas": "2.2.2", "cvxpy": "1.5.2", "clarabel": "0.9", "duckdb": "1.1", "narwhals": "2.0"}
"""Lowest releases of what every installation has, on which the suite was run."""


def would_run(target: str) -> list[str]:
    """Commands that ``make`` would run for a target."""
    if shutil.which("make") is None:
        pytest.skip("make is not on this machine")
    done = subprocess.run(["make", "-n", "--no-print-directory", target], cwd=ROOT, capture_output=True, text=True, check=True)
    return done.stdout.splitlines()


def test_the_targets_of_the_makefile_are_those_of_contributing() -> None:
    phony = re.search(r"^\.PHONY: (.*)$", MAKEFILE, re.MULTILINE)
    assert phony is not None and phony[1].split() == TARGETS
    told = re.findall(r"^\| `make ([a-z]+)` \|", CONTRIBUTING, re.MULTILINE)
    assert sorted(told) == sorted(TARGETS)
    assert set(re.findall(r"`make ([a-z]+)[^`]*`", README)) <= set(TARGETS)


def test_ci_and_the_makefile_are_no_copies_of_each_other() -> None:
    run = (ROOT / ".ci" / "run").read_text("utf-8")
    assert would_run("all") == [".ci/run"]
    assert re.findall(r"^make ([a-z]+)(?:$| >)", run, re.MULTILINE) == ["test", "lint", "docs"]
    assert re.search(r"^make deep PART=.* SEED=", run, re.MULTILINE)
    assert not re.search(r"\b(ruff|mypy|lint-imports|mkdocs|pip)\b", run)


def test_make_test_is_the_test_command_of_the_readme() -> None:
    command = re.search(r"^## Test it\n\n```sh\n(.+)\n```", README, re.MULTILINE)
    assert command is not None and command[1].startswith("python3 -m venv .venv && ") and command[1].endswith(".venv/bin/pytest")
    (line,) = would_run("test")
    shown = subprocess.run(["bash", "-c", line.removesuffix('bash -c "$command"')], cwd=ROOT, capture_output=True, text=True, check=True)
    assert shown.stdout == f"+ {command[1]}\n"


def test_lower_bounds_are_those_that_were_tried() -> None:
    assert dict(each.split(">=") for each in PROJECT["dependencies"]) == TRIED
    lowest = subprocess.run([sys.executable, ROOT / ".ci" / "lowest.py"], capture_output=True, text=True, check=True).stdout.splitlines()
    assert {f"{name}=={version}" for name, version in TRIED.items()} <= set(lowest)
    extras = PROJECT["optional-dependencies"]
    run = {each for name in extras if name not in ("lint", "docs", "dev") for each in extras[name] if not each.startswith(PROJECT["name"])}
    assert {re.sub(r"\[.*\]|;.*", "", each).replace(">=", "==") for each in run} | {f"{a}=={b}" for a, b in TRIED.items()} == set(lowest)
    assert any("lowest.py" in line for line in would_run("minimum"))


def test_pythons_are_the_same_everywhere() -> None:
    versions = re.search(r"for version in ([\d. ]+);", MAKEFILE)
    assert versions is not None
    named = [each.rpartition(" ")[2] for each in PROJECT["classifiers"] if re.search(r":: 3\.\d+$", each)]
    assert versions[1].split() == named
    assert PROJECT["requires-python"] == f">={named[0]}"
    yaml = pytest.importorskip("yaml")
    jobs = yaml.safe_load((ROOT / ".github" / "workflows" / "ci.yml").read_text("utf-8"))["jobs"]
    run = [jobs["all"]["container"]["image"].removeprefix("python:"), *jobs["check"]["strategy"]["matrix"]["python"]]
    assert [".".join(str(each).split(".")[:2]) for each in run] == named
    assert f"Python {named[0]} or later" in README and f"Python {named[0]} or later" in CONTRIBUTING


def test_the_head_of_a_run_names_what_is_absent(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    assert f"less than {needs.MINUTES} minutes" in README and f"less than {needs.MINUTES} minutes" in CONTRIBUTING
    for name, need in needs.NEEDS.items():
        assert needs.files(need), f"no test uses {name}"
    monkeypatch.setenv("PATH", str(tmp_path))
    head = "\n".join(needs.report())
    for name, file in {"browser": "test_browser_of_reports.py", "Coq": "test_proofs.py", "Java": "test_servers_of_engines.py"}.items():
        assert re.search(rf"without.*{name}.*{file}", head)
    environment = {**os.environ, "PATH": str(tmp_path), "PYTHONPATH": str(ROOT)}
    command = [sys.executable, "-m", "pytest", "-n", "0", "--collect-only", str(Path(__file__).relative_to(ROOT))]
    shown = subprocess.run(command, cwd=ROOT, env=environment, capture_output=True, text=True).stdout
    assert head in shown


# Tiers


def test_every_part_of_the_mission_is_tested_by_default(cases: list[parts.Case]) -> None:
    by_default = {part: default for part, _, default, _ in parts.table(cases)}
    assert by_default == {part: count for part, count in by_default.items() if count >= 1}


def test_quick_tests_reach_every_package_and_start_nothing_heavy(cases: list[parts.Case]) -> None:
    quick = [case for case in cases if case.tier == "quick"]
    folders = {path.parent.name for path in (ROOT / "fairaudit").glob("*/__init__.py")} - {"plugins", "verified"}
    assert folders - {case.name.split("/")[1] for case in quick} == set()
    assert [case.name for case in quick if case.needs] == []


@pytest.mark.parametrize(
    "name",
    [
        "test_readme_shows_the_first_result",  # exact values of a published table
        "test_a_difference_below_float_resolution_is_found",
        "test_false_is_found_where_it_stands",  # tampered certificates
        "test_the_judge_of_mutants_is_awake",
    ],
)
def test_quick_tests_are_no_formality(name: str, cases: list[parts.Case]) -> None:
    assert any(tiers.function(case.name) == name for case in cases if case.tier == "quick")


def test_a_record_that_was_not_timed_is_refused(tmp_path: Path) -> None:
    times = [
        ("a", "test_x[1.5-[y]]", 0.1),
        ("a", "test_x[2]", 0.2),
        ("b", "test_x", 0.1),
        ("b", "test_y", 0.05),
        ("m", "fairaudit.m.doc", 3),
    ]
    lines = "".join(f'<testcase classname="{where}" name="{name}" time="{seconds}"/>' for where, name, seconds in times)
    report, record = tmp_path / "report.xml", tmp_path / "times.txt"
    report.write_text(f"<testsuites><testsuite>{lines}</testsuite></testsuites>")
    tiers.write(tiers.measured(report), record)
    assert tiers.recorded(record) == {"test_x": (0.3, 2), "doc": (3.0, 1)}
    record.write_text(record.read_text().replace("3.00", "0.20"))
    with pytest.raises(ValueError, match="is not as `make durations` wrote it"):
        tiers.recorded(record)


@pytest.mark.parametrize(
    ("timed", "core", "cases", "kept"),
    [
        (None, False, 3, {0, 1, 2}),
        (tiers.Timed(0.45, 3), False, 3, {0, 1, 2}),
        (tiers.Timed(2, 8), False, 8, {0, 4}),
        (tiers.Timed(24, 20), False, 20, {0}),
        (tiers.Timed(60, 20), False, 20, set()),
        (tiers.Timed(60, 20), True, 20, {0}),
    ],
)
def test_a_function_runs_by_default_as_long_as_its_budget(timed: tiers.Timed, core: bool, cases: int, kept: set[int]) -> None:
    assert tiers.kept(timed, core, cases) == kept


def test_the_record_knows_only_tests_that_there_are() -> None:
    text = "\n".join(path.read_text("utf-8") for folder in ("tests", "fairaudit") for path in (ROOT / folder).rglob("*.py"))
    defined = set(re.findall(r"^\s*(?:def|class) (\w+)", text, re.MULTILINE)) | {path.stem for path in (ROOT / "fairaudit").rglob("*.py")}
    assert tiers.recorded().keys() <= defined


def test_a_quick_test_that_starts_something_heavy_fails(tmp_path: Path) -> None:
    (tmp_path / "conftest.py").write_text((ROOT / "tests" / "conftest.py").read_text("utf-8"))
    program = tmp_path / "coqc"
    program.write_text("#!/bin/sh\n")
    program.chmod(0o755)
    (tmp_path / "test_x.py").write_text(f"import subprocess\ndef test_x(): subprocess.run([{str(program)!r}], check=True)\n")
    environment = {**os.environ, "FAIRAUDIT_DEEP": "0", "PYTHONPATH": os.pathsep.join([str(ROOT / "tests"), str(ROOT)])}
    command = [sys.executable, "-m", "pytest", "-q", "-c", str(ROOT / "pyproject.toml"), "--rootdir", str(tmp_path), "-n0", str(tmp_path)]
    for tier, outcome in (("quick", "a quick test starts coqc"), ("not deep", "1 passed")):
        shown = subprocess.run([*command, "-m", tier], cwd=tmp_path, env=environment, capture_output=True, text=True).stdout
        assert outcome in shown, shown


def test_parts_of_the_deep_tier_are_its_cases_once() -> None:
    names = [f"tests/test_a.py::test_x[{i}]" for i in range(400)]
    counts = [sum(tiers.part_of(name, 4) == part for name in names) for part in range(4)]
    assert sum(counts) == 400 and min(counts) >= 60


# Hooks and workflows


def test_hooks_fetch_nothing_and_refuse_large_files(tmp_path: Path) -> None:
    yaml = pytest.importorskip("yaml")
    (repository,) = yaml.safe_load((ROOT / ".pre-commit-config.yaml").read_text("utf-8"))["repos"]
    assert repository["repo"] == "local"
    hooks = {hook["id"]: hook for hook in repository["hooks"]}
    assert {hook["language"] for hook in hooks.values()} == {"system"}
    assert all(hook["entry"].startswith(".venv/bin/") for name, hook in hooks.items() if name != "large-files")
    large, small = tmp_path / "large", tmp_path / "a small one"
    large.write_bytes(bytes(512 * 1024))
    small.write_bytes(bytes(512 * 1024 - 1))
    command = [*hooks["large-files"]["entry"].split(" '")[0].split(), hooks["large-files"]["entry"].split("'")[1], "--"]
    assert subprocess.run([*command, small]).returncode == 0
    refused = subprocess.run([*command, large, small], capture_output=True, text=True)
    assert refused.returncode == 1 and refused.stdout == f"{large} has 512 KiB or more\n"


def test_workflows_pin_what_they_use_and_release_only_tags() -> None:
    yaml = pytest.importorskip("yaml")
    for path in (ROOT / ".github" / "workflows").iterdir():
        text = path.read_text("utf-8")
        workflow = yaml.safe_load(text)
        jobs = workflow["jobs"].values()
        systems = [each for job in jobs for each in job.get("strategy", {}).get("matrix", {}).get("system", [job["runs-on"]])]
        assert all(re.fullmatch(r"[a-z]+-[\d.]+", system) for system in systems), path.name
        assert workflow["permissions"] == {"contents": "read"}
        steps = [step for job in jobs for step in job["steps"] if "actions/checkout@" in step.get("uses", "")]
        assert all(step["with"] == {"persist-credentials": False} for step in steps)
    for path in (*(ROOT / ".github" / "workflows").iterdir(), ROOT / "action.yml"):
        for used in re.findall(r"uses: (.+)", path.read_text("utf-8")):
            assert used == "./" or re.fullmatch(r"[\w-]+/[\w-]+@[0-9a-f]{40} # v\d+\.\d+\.\d+", used), (path.name, used)
    release = yaml.safe_load((ROOT / ".github" / "workflows" / "release.yml").read_text("utf-8"))
    assert release[True] == {"push": {"tags": ["v*"]}}  # YAML 1.1 reads the key `on` as true
    assert {"run": "FAIRAUDIT_RELEASE=1 make all"} in release["jobs"]["build"]["steps"]
    assert release["jobs"]["publish"]["permissions"] == {"id-token": "write"}
