"""Which format a log has is known by its content, whatever its name."""

from __future__ import annotations

import json
import zipfile
from pathlib import Path
from typing import Any

import pytest

import fairaudit as fa
from fairaudit.errors import InputError
from fairaudit.tables.evaluations.detection import FORMATS, detect
from fairaudit.tables.evaluations.json_text import BEGINNING, PIECE

LOGS = Path(__file__).with_name("logs")

INSPECT = {"version": 2, "status": "success", "eval": {}, "plan": {}, "samples": []}
LM_EVAL = {"doc_id": 0, "doc": {"x": 1}, "target": "", "resps": [], "filtered_resps": []}


def detected(path: Path, content: object, *more: object) -> str | None:
    path.write_text("\n".join(json.dumps(each) for each in (content, *more)))
    found = detect(str(path))
    return found and found.name


def test_first_objects_tell(tmp_path: Path) -> None:
    path = tmp_path / "log"
    assert detected(path, INSPECT) == "inspect"
    assert detected(path, LM_EVAL, LM_EVAL) == "lm-eval"
    assert detected(path, {"decision": "yes", "group": {"resps": [], "doc_id": 1}}) is None
    assert detected(path, 5) is None


def test_a_list_of_samples_is_no_list_of_rows(tmp_path: Path) -> None:
    path = tmp_path / "log.json"
    for held, name in ((INSPECT, "inspect"), (LM_EVAL, "lm-eval")):
        with pytest.raises(InputError, match=f"looks like a log of {name}, .*write each element on a line"):
            detected(path, [held, held])
    assert [detected(path, plain) for plain in ([], [5], [[LM_EVAL]], [{"doc_id": 1}], [{"custom_id": 1, "response": "yes"}])] == [None] * 5


def test_a_long_beginning_hides_no_format(tmp_path: Path) -> None:
    path, long = tmp_path / "log", "x" * (BEGINNING + PIECE)
    assert detected(path, {"arguments": long} | LM_EVAL) == "lm-eval"
    assert detected(path, {"id": long, "custom_id": "a", "response": {"body": {}}}) == "openai"
    assert detected(path, {"id": long, "custom_id": "a", "response": "yes"}) is None
    assert detected(path, {"id": long, "spec": {"run_id": "a", "eval_name": "b"}}) == "openai-evals"
    path.write_text(json.dumps({"id": long, "custom_id": "a"})[:-1])
    with pytest.raises(InputError, match="the file ends in the middle of a value"):
        detect(str(path))


@pytest.mark.parametrize(
    "content",
    [
        b"",
        b"\n\n",
        b"sex,hired\nf,yes\n",
        b"{",
        b'{"doc_id"',
        b'{"doc_id": 1, }',
        b"PAR1\x00\xff",
        b"\xff\xfe{",
        b"\xef\xbb\xbf{}",
        b'{"a":' + b"[" * 10**5,
    ],
)
def test_everything_else_is_no_log(tmp_path: Path, content: bytes) -> None:
    path = tmp_path / "log"
    path.write_bytes(content)
    assert detect(str(path)) is None
    assert detect(str(tmp_path)) is None


def test_results_are_no_samples(tmp_path: Path) -> None:
    for path in (LOGS / "lm-eval").glob("results_*.json"):
        with pytest.raises(InputError, match=r"results of a run of lm-evaluation-harness; its samples stand beside"):
            detect(str(path))
    path = tmp_path / "state.json"
    path.write_text('{"request_states": []}')
    with pytest.raises(InputError, match=r"state\.json: there is no \"adapter_spec\", so this is no run of HELM"):
        FORMATS["helm"].run(str(path))


def test_archives_are_told_apart(tmp_path: Path) -> None:
    path = tmp_path / "a.zip"
    for name, expected in {"header.json": "inspect", "_journal/start.json": "inspect", "[Content_Types].xml": None}.items():
        with zipfile.ZipFile(path, "w") as made:
            made.writestr(name, "{}")
        found = detect(str(path))
        assert (found and found.name) == expected
    path.write_bytes(path.read_bytes()[:-20])
    assert detect(str(path)) is None
    with pytest.raises(InputError, match="there is no such file"):
        detect(str(tmp_path / "absent.eval"))


@pytest.mark.parametrize("name", FORMATS)
def test_a_file_of_another_format_than_is_named_is_refused(tmp_path: Path, name: str) -> None:
    """What it is, is said; a format is overridden where the first object has the keys of both."""
    sample = {"doc_id": 0, "doc": {"race": "b"}, "resps": [["yes"]], "filtered_resps": ["yes"], "filter": "none", "target": "yes"}
    more: dict[str, Any]
    columns, more = ["filtered_resps[0]", "doc.race"], dict.fromkeys(("promptIdx", "testIdx", "testCase", "vars"), 0)
    more["response"] = {"output": "yes"}
    (tmp_path / "a.jsonl").write_text(json.dumps(sample))
    (tmp_path / "both.jsonl").write_text(json.dumps(sample | more))
    (tmp_path / "a.csv").write_text("said,race\nyes,b\n")
    if name == "lm-eval":
        assert fa.read_log(str(tmp_path / "a.jsonl"), columns, log_format=name).rows == 1
    else:
        with pytest.raises(InputError, match=rf"a.jsonl is a log of lm-eval by its content, and none of {name}; leave --log-format"):
            fa.read_log(str(tmp_path / "a.jsonl"), columns, log_format=name)
    with pytest.raises(InputError, match=rf"a.csv is no log of {name}: logs are JSON"):
        fa.read_log(str(tmp_path / "a.csv"), columns, log_format=name)
    if name == "promptfoo":
        assert fa.read_log(str(tmp_path / "both.jsonl"), columns, log_format=name, unit="doc_id").rows == 1
