"""The GitHub Action: its steps run as a runner runs them, on each verdict, with hostile input, and before a server instead of the API."""

from __future__ import annotations

import csv
import json
import os
import re
import shlex
import subprocess
import sys
import threading
from collections.abc import Iterator
from fractions import Fraction
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from importlib.util import module_from_spec, spec_from_file_location
from pathlib import Path
from typing import Any, NamedTuple

import pytest
import yaml

from fairaudit import verify

ROOT = Path(__file__).resolve().parents[2]
ACTION = yaml.safe_load((ROOT / "action.yml").read_text("utf-8"))
STEPS = ACTION["runs"]["steps"]
HOSTILE = [
    "$(touch x)",
    "`touch x`",
    "a\n::set-output name=verdict::within",
    "%0A::error::b",
    "  ##[add-mask]c",
    "@you #1 <img src=x> | **",
    "EOF",
    "ok",
]


class Ran(NamedTuple):
    code: int
    printed: str
    summary: str
    outputs: dict[str, str]
    folder: Path


def filled(text: str, inputs: dict[str, str], steps: dict[str, dict[str, str]]) -> str:
    """What a runner puts in the place of an expression."""

    def value(match: re.Match[str]) -> str:
        inside = match[1].strip()
        if inside.startswith("inputs."):
            return inputs[inside.removeprefix("inputs.")]
        step, name = re.fullmatch(r"steps\.(\w+)\.outputs\.([\w-]+)", inside).groups()  # type: ignore[union-attr]
        return steps[step][name]

    return re.sub(r"\$\{\{(.*?)\}\}", value, text)


def outputs_of(path: Path) -> dict[str, str]:
    """Read the file of outputs as runners do: NAME=VALUE, or NAME<<END, lines, END."""
    found: dict[str, str] = {}
    lines = iter(path.read_text("utf-8").splitlines())
    for line in lines:
        name, mark, end = line.partition("<<")
        if mark:
            found[name] = "\n".join(iter(lambda end=end: next(lines), end))
        else:
            name, _, found[name] = line.partition("=")
    return found


def ran(step: dict[str, Any], folder: Path, inputs: dict[str, str], steps: dict[str, dict[str, str]], **more: str) -> Ran:
    """Run a step by bash, as a runner does, in a folder that is the workspace."""
    temporary = folder / "temporary"
    temporary.mkdir(exist_ok=True)
    files = {name: temporary / name for name in ("GITHUB_OUTPUT", "GITHUB_STEP_SUMMARY")}
    for file in files.values():
        file.write_text("")
    given = {name: default.get("default", "") for name, default in ACTION["inputs"].items()} | inputs
    runner = {"GITHUB_ACTION_PATH": str(ROOT), "RUNNER_TEMP": str(temporary), **{name: str(path) for name, path in files.items()}}
    own = {name: filled(text, given, steps) for name, text in step["env"].items()}
    script = temporary / "script.sh"
    script.write_text(step["run"], "utf-8")
    environment = {**os.environ, **runner, **own, **({} if "install" in step.get("id", "") else {"PYTHONPATH": str(ROOT)}), **more}
    words = ["bash", "--noprofile", "--norc", "-e", "-o", "pipefail", str(script)]
    done = subprocess.run(
        words, cwd=folder, env=environment, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, encoding="utf-8", check=False
    )
    summary = files["GITHUB_STEP_SUMMARY"].read_text("utf-8")
    return Ran(done.returncode, done.stdout, summary, outputs_of(files["GITHUB_OUTPUT"]), folder)


def step(name: str) -> dict[str, Any]:
    return next(found for found in STEPS if found.get("id") == name or name in found.get("run", ""))


PYTHON = {"install": {"python": sys.executable}}


def gate(folder: Path, **inputs: str) -> Ran:
    return ran(step("gate"), folder, {name.replace("_", "-"): text for name, text in inputs.items()}, PYTHON)


def table(folder: Path, f: int, m: int) -> None:
    """2,000 decisions on either group, of which some are yes."""
    rows = [("answer", "sex", "n"), ("yes", "f", f), ("no", "f", 2000 - f), ("yes", "m", m), ("no", "m", 2000 - m)]
    with (folder / "decisions.csv").open("w", newline="") as file:
        csv.writer(file).writerows(rows)


@pytest.fixture
def modules() -> tuple[Any, Any]:
    """The two scripts as modules."""
    found = []
    for name in ("gate", "comment"):
        spec = spec_from_file_location(f"action_{name}", ROOT / "action" / f"{name}.py")
        assert spec is not None and spec.loader is not None
        found.append(module_from_spec(spec))
        spec.loader.exec_module(found[-1])
    return found[0], found[1]


OPTIONS = "--decision answer --group sex --count n --utility yes"
VERDICTS = {"within": (1000, 1000), "exceeds": (1000, 500), "inconclusive": (1000, 820)}


@pytest.mark.parametrize(
    ("verdict", "fail_on", "code"),
    [
        ("within", "inconclusive", 0),
        ("exceeds", "exceeds", 1),
        ("exceeds", "never", 0),
        ("inconclusive", "", 3),
        ("inconclusive", "exceeds", 0),
    ],
)
def test_each_verdict_stops_what_was_asked(tmp_path: Path, verdict: str, fail_on: str, code: int) -> None:
    table(tmp_path, *VERDICTS[verdict])
    found = gate(tmp_path, file="decisions.csv", arguments=OPTIONS, max_local_ratio="5/4", fail_on=fail_on)
    assert (found.code, found.outputs["verdict"]) == (code, verdict), found.printed
    assert found.outputs["sentence"] in found.printed
    assert [line.split()[0] for line in commands(found.printed)] == [] if verdict == "within" else ["::error" if code else "::warning"]
    certificate = Path(found.outputs["certificate"])
    assert verify(certificate).ok
    assert json.loads(certificate.read_text("utf-8"))["verdict"] == verdict
    assert Path(found.outputs["page"]).read_text("utf-8").startswith("<!DOCTYPE html>")
    assert found.summary.startswith("**Fairness gate**\n\n## Fairness audit: ")
    assert found.summary.count("<details>") == found.summary.count("</details>") == 1
    assert {path.name for path in Path(found.outputs["folder"]).iterdir()} == {"certificate.json", "page.html"}


@pytest.mark.parametrize(
    ("limit", "verdict", "code"), [("max_local_ratio", "inconclusive", 3), ("max_global_ratio", "exceeds", 1)], ids=["local", "global"]
)
def test_the_admissions_of_1973(tmp_path: Path, limit: str, verdict: str, code: int) -> None:
    """1198 of 2691 men and 557 of 1835 women: 1.467 times; in the departments, where women fare better, too few to tell."""
    found = gate(tmp_path, arguments="--example ucb-admissions", **{limit: "5/4"})
    assert (found.code, found.outputs["verdict"]) == (code, verdict), found.printed
    document = json.loads(Path(found.outputs["certificate"]).read_text("utf-8"))
    assert Fraction(document["metrics"]["global"]["ratio"]) == Fraction(1198, 2691) / Fraction(557, 1835)


def test_other_documents_have_a_gate_too(tmp_path: Path) -> None:
    """Who of several candidates was chosen, and groups that nobody recorded."""
    (tmp_path / "choices.csv").write_text("order,chosen\n" + "a b,a\nb a,a\n" * 300)
    found = gate(tmp_path, file="choices.csv", arguments="--slots order --winner chosen", max_local_ratio="5/4")
    assert (found.code, found.outputs["verdict"]) == (1, "exceeds"), found.printed
    (tmp_path / "log.csv").write_text("answer,place\n" + "yes,x\nno,x\nyes,y\nyes,y\n" * 300)
    (tmp_path / "places.csv").write_text("place,sex,probability\nx,f,0.9\nx,m,0.1\ny,f,0.1\ny,m,0.9\n")
    options = "--decision answer --utility yes --group sex --group-probability places.csv"
    found = gate(tmp_path, file="log.csv", arguments=options, max_global_ratio="11/10", fail_on="never")
    assert (found.code, found.outputs["verdict"] == "error") == (0, False), found.printed
    assert verify(found.outputs["certificate"]).ok


def test_each_run_has_a_folder_of_its_own(tmp_path: Path) -> None:
    table(tmp_path, 1000, 1000)
    two = [gate(tmp_path, file="decisions.csv", arguments=OPTIONS).outputs for _ in range(2)]
    assert len({outputs["certificate"] for outputs in two}) == 2


def test_a_table_that_stands_apart_is_not_kept(tmp_path: Path) -> None:
    """Artifacts of a public repository are public."""
    table(tmp_path, 1000, 500)
    found = gate(tmp_path, file="decisions.csv", arguments=f"{OPTIONS} --no-table --confidence none", max_local_ratio="5/4")
    assert (found.code, found.outputs["verdict"]) == (1, "exceeds"), found.printed
    folder = found.outputs["folder"]
    assert {path.name for path in Path(folder).iterdir()} == {"certificate.json", "certificate.table.jsonl", "page.html"}
    kept = next(step["with"]["path"] for step in STEPS if step.get("uses", "").startswith("actions/upload-artifact"))
    assert filled(kept, {}, {"gate": found.outputs}).split() == [folder, f"!{folder}/*.table.jsonl"]


def test_without_a_target_nothing_is_stopped_and_that_is_said(tmp_path: Path) -> None:
    table(tmp_path, 1000, 500)
    found = gate(tmp_path, file="decisions.csv", arguments=OPTIONS)
    assert (found.code, found.outputs["verdict"]) == (0, "none")
    assert "::warning title=Fairness gate, none::No target was set" in found.printed


@pytest.mark.parametrize(
    ("inputs", "said"),
    [
        ({"file": "absent.csv", "arguments": OPTIONS}, "absent.csv"),
        ({"file": "decisions.csv", "arguments": "--decision 'answer"}, "arguments cannot be read"),
        ({"file": "decisions.csv", "arguments": f"{OPTIONS} -o elsewhere.json"}, "which the action sets itself"),
        ({"file": "decisions.csv", "arguments": f"{OPTIONS} --output=elsewhere.json"}, "which the action sets itself"),
        ({"file": "decisions.csv", "arguments": f"{OPTIONS} -oelsewhere.json"}, "which the action sets itself"),
        ({"file": "decisions.csv", "arguments": OPTIONS, "fail_on": "always"}, "exceeds, inconclusive or never is expected"),
        ({"file": "decisions.csv", "arguments": OPTIONS, "max_local_ratio": "five"}, "five"),
        ({"file": "decisions.csv", "arguments": "--decision nothing --group sex --count n --utility yes"}, "nothing"),
        ({"file": "decisions.csv"}, "--decision answer"),
        ({"arguments": "--list-examples"}, "these arguments make no certificate"),
        ({"file": "--version", "arguments": OPTIONS}, "--version"),
    ],
)
def test_bad_input_stops_the_job_whatever_fail_on_says(tmp_path: Path, inputs: dict[str, str], said: str) -> None:
    table(tmp_path, 1000, 1000)
    found = gate(tmp_path, **{"fail_on": "never", **inputs})
    assert found.code == 2
    assert found.outputs["verdict"] == "error"
    assert found.outputs["certificate"] == found.outputs["page"] == ""
    assert said in found.outputs["sentence"]
    assert "::error title=Fairness gate, error::" in found.printed
    assert "Traceback" not in found.printed + found.summary
    assert found.summary.startswith("**Fairness gate**\n\n## Fairness audit: error\n")


def commands(printed: str) -> list[str]:
    """Lines that a runner takes for commands: those with :: after blanks, or ##[ anywhere, while commands are not stopped."""
    found, until = [], None
    for line in printed.splitlines():
        if until is not None:
            until = None if line.strip() == f"::{until}::" else until
        elif line.strip().startswith("::stop-commands::"):
            until = line.strip().removeprefix("::stop-commands::")
        elif line.strip().startswith("::") or "##[" in line:
            found.append(line)
    assert until is None
    return found


@pytest.mark.parametrize("label", HOSTILE)
def test_hostile_labels_stay_text(tmp_path: Path, label: str) -> None:
    """As label of a group, column and name of the file, and as arguments and name of the gate."""
    column = f"c{label}".replace("\n", "")  # a name of a column is one line
    file = f"{column}.csv"
    with (tmp_path / file).open("w", newline="") as opened:
        csv.writer(opened).writerows([("answer", column), *[("yes", label), ("no", "m")] * 300])
    arguments = f"--decision answer --group {shlex.quote(column)} --utility yes"
    found = gate(tmp_path, file=file, arguments=arguments, max_local_ratio="5/4", name=label)
    assert (found.code, found.outputs["verdict"]) == (1, "exceeds"), found.printed
    assert set(found.outputs) == {"verdict", "sentence", "certificate", "page", "folder", "summary"}
    assert "\n" not in found.outputs["sentence"]
    assert [line.partition("::")[2].partition(" ")[0] for line in commands(found.printed)] == ["error"]
    assert not {"x", "script.sh"} & {path.name for path in tmp_path.iterdir()}
    assert verify(found.outputs["certificate"]).ok
    assert "@you" not in found.summary
    assert "<img" not in found.summary
    assert "\n::" not in found.summary
    assert found.summary.splitlines()[2].startswith("## Fairness audit: ")


def test_a_broken_tool_is_no_verdict(tmp_path: Path, modules: tuple[Any, Any], monkeypatch: pytest.MonkeyPatch) -> None:
    """Python ends with 1 where it fails, as `certify` does where a target is exceeded."""
    broken = subprocess.CompletedProcess([], 1, "", "Traceback (most recent call last):\nZeroDivisionError: division by zero\n")
    monkeypatch.setattr(modules[0], "run", lambda *_: broken)
    (tmp_path / "certificate.json").write_text("{}")
    assert modules[0].certify({}, tmp_path) == (2, "error", "ZeroDivisionError: division by zero", ())


def test_modules_in_the_workspace_are_not_run(tmp_path: Path) -> None:
    table(tmp_path, 1000, 1000)
    for name in ("json", "fairaudit", "argparse"):
        (tmp_path / f"{name}.py").write_text("raise SystemExit(7)\n")
    assert gate(tmp_path, file="decisions.csv", arguments=OPTIONS).code == 0


def test_a_summary_has_at_most_a_mebibyte(modules: tuple[Any, Any]) -> None:
    """Beyond it the runner keeps nothing; a comment has at most 65,536 characters."""
    module, comment = modules
    text = "<details>\n" + "| é | ü |\n" * 200_000
    short = module.cut(text, module.LONGEST_SUMMARY)
    assert len(short.encode()) < 2**20
    assert short.count("</details>") == 1
    assert module.cut("short", module.LONGEST_SUMMARY) == "short"
    assert len(comment.fitted(text, "end")) < 65_536


def test_no_expression_stands_in_a_script() -> None:
    assert not [found for found in STEPS if "${{" in found.get("run", "")]
    uses = [found["uses"] for found in STEPS if "uses" in found]
    assert all(re.fullmatch(r"actions/[\w-]+@[0-9a-f]{40}", used) for used in uses)
    assert [found["env"].get("GITHUB_TOKEN") for found in STEPS if "run" in found] == [None, None, "${{ inputs.token }}"]


@pytest.mark.parametrize(("schema", "files"), [("actions", "action.yml"), ("issue-forms", ".github/ISSUE_TEMPLATE/*.yml")])
def test_the_metadata_keep_the_schema(schema: str, files: str) -> None:
    check = Path(sys.executable).with_name("check-jsonschema")
    if not check.exists():
        pytest.skip("check-jsonschema is not installed")
    words = [str(check), "--builtin-schema", f"vendor.github-{schema}", *map(str, sorted(ROOT.glob(files)))]
    done = subprocess.run(words, capture_output=True, text=True, check=False)
    if f"'vendor.github-{schema}' is not one of" in done.stderr:
        pytest.skip(f"check-jsonschema 0.34 or later, which has the schema of {schema}, is not installed")
    assert done.returncode == 0, done.stdout + done.stderr


class Api(BaseHTTPRequestHandler):
    """Comments of one pull request, as the interface has them, with pages."""

    server: Server

    def do_GET(self) -> None:
        path, _, query = self.path.partition("?")
        if path == "/user":
            return self.answer(200 if self.server.login else 403, {"login": self.server.login})
        given = dict(part.split("=") for part in query.split("&"))
        first = (int(given["page"]) - 1) * int(given["per_page"])
        return self.answer(200, self.server.comments[first : first + int(given["per_page"])])

    def do_POST(self) -> None:
        body = self.said()["body"]
        self.server.comments.append(
            {"id": 5000 + len(self.server.comments), "user": {"type": "Bot", "login": "github-actions[bot]"}, "body": body}
        )
        self.answer(self.server.code or 201, {})

    def do_PATCH(self) -> None:
        found = next(one for one in self.server.comments if one["id"] == int(self.path.rpartition("/")[2]))
        found["body"] = self.said()["body"]
        self.answer(self.server.code or 200, {})

    def said(self) -> Any:
        return json.loads(self.rfile.read(int(self.headers["Content-Length"])))

    def answer(self, code: int, what: Any) -> None:
        self.server.asked.append((self.command, self.path, self.headers["Authorization"]))
        content = json.dumps(what).encode()
        self.send_response(code)
        self.send_header("Content-Length", str(len(content)))
        self.end_headers()
        self.wfile.write(content)

    def log_message(self, *_: Any) -> None:
        """Say nothing."""


class Server(ThreadingHTTPServer):
    comments: list[dict[str, Any]]
    asked: list[tuple[str, str, str]]
    login = ""
    code = 0


@pytest.fixture
def api() -> Iterator[Server]:
    with Server(("127.0.0.1", 0), Api) as server:
        server.comments, server.asked = [], []
        thread = threading.Thread(target=server.serve_forever)
        thread.start()
        yield server
        server.shutdown()
        thread.join()


def commented(folder: Path, api: Server, summary: str, *, name: str = "", event: Any = None) -> Ran:
    """Run the step that comments."""
    (folder / "event.json").write_text(json.dumps({"pull_request": {"number": 7}} if event is None else event))
    (folder / "summary.md").write_text(summary, "utf-8")
    given = {
        "GITHUB_API_URL": f"http://127.0.0.1:{api.server_address[1]}",
        "GITHUB_SERVER_URL": "https://example.org",
        "GITHUB_REPOSITORY": "some/where",
        "GITHUB_RUN_ID": "99",
        "GITHUB_EVENT_PATH": str(folder / "event.json"),
        "no_proxy": "127.0.0.1",
    }
    steps = {**PYTHON, "gate": {"summary": str(folder / "summary.md")}}
    return ran(step("comment.py"), folder, {"token": "secret", "name": name}, steps, **given)


def test_a_pull_request_has_one_comment_for_each_name(tmp_path: Path, api: Server) -> None:
    other = {"id": 1, "user": {"type": "User", "login": "you"}, "body": "nice"}
    api.comments = [dict(other) for _ in range(150)]
    for number, name in enumerate(("", "", "hiring", "hiring", "")):
        found = commented(tmp_path, api, f"text {number}", name=name)
        assert (found.code, "::" in found.printed) == (0, False), found.printed
    made = api.comments[150:]
    assert [one["body"].splitlines()[1] for one in made] == ["text 4", "text 3"]
    assert all("https://example.org/some/where/actions/runs/99" in one["body"] for one in made)
    changes = [(method, path) for method, path, _ in api.asked if method != "GET"]
    issue = "/repos/some/where/issues"
    assert changes == [
        ("POST", f"{issue}/7/comments"),
        ("PATCH", f"{issue}/comments/5150"),
        ("POST", f"{issue}/7/comments"),
        ("PATCH", f"{issue}/comments/5151"),
        ("PATCH", f"{issue}/comments/5150"),
    ]
    assert {token for _, _, token in api.asked} == {"Bearer secret"}


def test_nobody_elses_comment_is_changed(tmp_path: Path, api: Server) -> None:
    """A comment that quotes ours is another's."""
    commented(tmp_path, api, "first")
    api.comments[0]["user"] = {"type": "User", "login": "you"}
    assert "made" in commented(tmp_path, api, "second").printed
    api.login = "you"
    assert "updated" in commented(tmp_path, api, "third").printed
    assert [one["body"].splitlines()[1] for one in api.comments] == ["third", "second"]


def test_a_comment_that_is_refused_stops_nothing(tmp_path: Path, api: Server) -> None:
    api.code = 403
    found = commented(tmp_path, api, "text")
    assert found.code == 0
    assert "::warning title=Fairness gate::The comment could not be written: HTTP 403; it needs `pull-requests: write`" in found.printed
    assert "secret" not in found.printed


def test_without_a_pull_request_nothing_is_asked(tmp_path: Path, api: Server) -> None:
    found = commented(tmp_path, api, "text", event={"ref": "refs/heads/main"})
    assert (found.code, api.asked) == (0, [])


def test_the_action_installs_what_it_runs(tmp_path: Path) -> None:
    """From its own checkout, into an environment of its own; this asks the package index."""
    own = {"python": {"python-path": sys.executable}}
    found = ran(step("install"), tmp_path, {}, own)
    if found.code and "No matching distribution" in found.printed:
        pytest.skip("the package index cannot be asked from here")
    assert found.code == 0, found.printed
    python = found.outputs["python"]
    table(tmp_path, 1000, 500)
    inputs = {"file": "decisions.csv", "arguments": OPTIONS, "max-local-ratio": "0.8"}
    judged = ran(step("gate"), tmp_path, inputs, {"install": {"python": python}}, PYTHONPATH="")
    assert (judged.code, judged.outputs["verdict"]) == (1, "exceeds"), judged.printed
