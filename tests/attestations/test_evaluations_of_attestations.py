"""Evaluation logs attested and counted again: what was lost in them, what they say of themselves, and the file that was joined."""

from __future__ import annotations

import json
import shutil
from pathlib import Path
from typing import Any

import pytest

import fairaudit as fa
from fairaudit.cli import main

ROLES = ["--decision", "scores.choice.answer", "--group", "metadata.race", "--context", "metadata.topic", "--utility", "A=1"]
HOW = [*ROLES, "--unit", "id", "--errors", "drop", "--missing-samples", "accept"]


def inspect_log(path: Path, **said: Any) -> Path:
    """A log of 20 questions asked twice, of which the last three samples were never taken: of every seventh there is an error."""
    samples = []
    for place in range(37):
        question, epoch = place // 2, place % 2 + 1
        sample: dict[str, Any] = {
            "id": f"q{question}",
            "epoch": epoch,
            "metadata": {"race": "ab"[question % 2], "topic": ["age", "home"][question // 2 % 2]},
            "output": {"stop_reason": "content_filter" if place % 5 == 0 else "stop"},
            "scores": {"choice": {"value": "C", "answer": "A" if (place * 7) % 3 else "B"}},
        }
        if place % 7 == 0:
            sample |= {"error": {"message": "timed out"}, "scores": {}}
        samples.append(sample)
    header = {
        "model": "mockllm/model",
        "task": "loans",
        "config": {"epochs": 2},
        "dataset": {"sample_ids": [f"q{place}" for place in range(20)]},
        "packages": {"inspect_ai": "0.3.285"},
        **said,
    }
    path.write_text(json.dumps({"version": 2, "status": "error", "eval": header, "samples": samples}))
    return path


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    inspect_log(tmp_path / "run.json")
    assert main(["certify", "run.json", *HOW, "-o", "c.json", "--attest", "a.json"]) == 0
    return tmp_path


def recounted(capsys: pytest.CaptureFixture[str], *logs: str) -> tuple[int, str]:
    capsys.readouterr()
    code = main(["verify", "c.json", "--attestation", "a.json", "--recount", *logs])
    return code, " ".join(capsys.readouterr().out.split())


def test_what_a_log_says_of_itself_is_attested_and_what_was_lost_adds_up(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    predicate = json.loads((folder / "a.json").read_text())["predicate"]
    run = {"format": "inspect", "producer": "inspect_ai 0.3.285", "model": "mockllm/model", "task": "loans", "status": "error"}
    assert predicate["sources"][0]["run"] == run and predicate["sources"][0]["rows"] == 37
    assert predicate["rows"] == {"unit": "decisions", "read": 37, "counted": 31, "dropped": {"error": 6}}
    assert predicate["options"]["errors"] == "drop" and predicate["options"]["missing_samples"] == "accept"
    code, said = recounted(capsys, "run.json")
    assert code == 0 and "equal how answers were read" in said and "equal what 'run.json' says of its run" in said
    assert "which was counted again, as is said below: 25 of 37 answers were read, 6 were refused, 6 ended in an error and were" in said
    assert "not looked at" not in said and "nothing here checks it" not in said and "The log was counted again" in said
    assert "3 of 40 samples are not in it. Of what was drawn it says: questions were drawn; epochs of a question count once (" in said
    assert 'count once (a question is told by "id", a sampling unit is told by "id").' in said
    assert 'Runs of evaluations, as their logs are said to name them: "run.json" (format "inspect", producer "inspect_ai 0.3.285"' in said
    assert fa.recount("c.json", "a.json", "run.json").ok


def test_a_log_that_was_not_counted_again_is_said_so(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """Because nobody asked, because it is not there, or because the attestation is false."""
    unseen = "which was not looked at here: 25 of 37 answers were read"
    capsys.readouterr()
    assert main(["verify", "c.json", "--attestation", "a.json"]) == 0
    assert unseen in " ".join(capsys.readouterr().out.split())
    code, said = recounted(capsys, "elsewhere.json")
    assert code != 0 and ("counted again, as is said below" not in said)


def test_another_number_of_errors_is_false(folder: Path) -> None:
    statement = json.loads((folder / "a.json").read_text())
    statement["predicate"]["rows"] |= {"dropped": {"error": 5}, "read": 36}
    (folder / "a.json").write_text(json.dumps(statement))
    assert main(["verify", "c.json", "--attestation", "a.json"]) == 1


@pytest.mark.parametrize(
    ("change", "said"),
    [
        ({"model": "other/model"}, "differs what 'run.json' says of its run"),
        ({"dataset": {"sample_ids": [*range(21)]}}, "differs how answers were read: the certificate says of samples"),
    ],
)
def test_another_run_differs(folder: Path, capsys: pytest.CaptureFixture[str], change: dict[str, Any], said: str) -> None:
    inspect_log(folder / "run.json", **change)
    code, text = recounted(capsys, "run.json")
    assert code == 1 and said in text


def test_python_attests_the_same(folder: Path) -> None:
    columns: dict[str, Any] = {"decision": "scores.choice.answer", "group": "metadata.race", "context": "metadata.topic", "unit": "id"}
    result = fa.audit("run.json", **columns, utility="A", errors="drop", missing_samples="accept")
    result.attest("p.json", "pa.json")
    ours, theirs = (json.loads((folder / name).read_text())["predicate"] for name in ("pa.json", "a.json"))
    assert all(ours[key] == theirs[key] for key in ("table", "sources", "rows", "options"))
    assert (folder / "p.json").read_bytes() == (folder / "c.json").read_bytes()


def test_rows_that_were_joined_are_given_beside_the_log(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    answers = ["yes, I would.", "no", "maybe", "I say yes. Or no?"]
    (tmp_path / "run.jsonl").write_text(
        "".join(json.dumps({"id": f"q{i}", "out": {"text": answers[i % 3 + i % 2]}, "of": "ab"[i % 7 == 0]}) + "\n" for i in range(40))
    )
    (tmp_path / "rows").mkdir()
    people = tmp_path / "rows" / "people.csv"
    people.write_text("id,sex\n" + "".join(f"q{place},{'fm'[place % 2]}\n" for place in range(40)))
    words = ["run.jsonl", "--decision", "out.text", "--group", "sex", "--utility", "yes", "--extract", r"(?i)\b(yes|no)\b"]
    words += ["--join", "rows/people.csv:id", "--where", "of=a", "--fold-labels"]
    assert main(["certify", *words, "-o", "c.json", "--attest", "a.json"]) == 0
    predicate = json.loads((tmp_path / "a.json").read_text())["predicate"]
    assert [(source["name"], source["rows"]) for source in predicate["sources"]] == [("run.jsonl", 40), ("people.csv", None)]
    assert "rows/" not in json.dumps(predicate) and "run" not in predicate["sources"][0]
    assert predicate["options"]["join"] == {"file": "people.csv", "column": "id"}
    assert predicate["options"]["where"] == [{"path": "of", "value": "a"}] and predicate["rows"]["read"] == 34
    code, said = recounted(capsys, "run.jsonl", "rows/people.csv")
    assert code == 0 and "equal the source 'people.csv'" in said and "equal how answers were read" in said
    assert recounted(capsys, "run.jsonl", "--recount", "rows/people.csv") == (code, said)
    assert recounted(capsys, "run.jsonl")[0] == 3
    people.write_text(people.read_text().replace("q1,m", "q1,f"))
    code, said = recounted(capsys, "run.jsonl", "rows/people.csv")
    assert code == 1 and "differs the source 'people.csv'" in said and "differs the table" in said
    assert main(["certify", *words, "-o", "rows/people.csv"]) == 2


@pytest.mark.parametrize(("asked", "other"), [({"extract": "^(yes|no)$"}, "^(yes|no)"), ({"options": ["yes", "no"]}, ["yes", "x"])])
def test_another_reading_of_the_answers_differs(
    asked: dict[str, Any], other: Any, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    ((name, value),) = asked.items()
    rows = [{"text": answer, "who": who} for who in "ab" for answer in ("yes", "no", "neither", "yes") * 3]
    (tmp_path / "run.jsonl").write_text("".join(json.dumps(row) + "\n" for row in rows))
    words = ["run.jsonl", "--decision", "text", "--group", "who", "--utility", "yes=1", "--confidence", "none"]
    words += [f"--{name}", value if isinstance(value, str) else ",".join(value)]
    assert main(["certify", *words, "-o", "c.json", "--attest", "a.json"]) == 0
    assert recounted(capsys, "run.jsonl")[0] == 0
    statement = json.loads((tmp_path / "a.json").read_text())
    assert statement["predicate"]["options"][name] == value
    statement["predicate"]["options"][name] = other
    (tmp_path / "a.json").write_text(json.dumps(statement))
    code, said = recounted(capsys, "run.jsonl")
    assert code == 1 and f"differs how answers were read: the certificate says of {name}" in said


def test_an_audit_file_says_the_same_and_reads_nothing_but_what_is_given(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (folder / "people.csv").write_text("id,sex\n" + "".join(f"q{place},{'fm'[place % 2]}\n" for place in range(20)))
    law = {"table": "run.json", "decision": "scores.choice.answer", "group": "sex", "unit": "id", "join": "people.csv:id", "errors": "drop"}
    said = "".join(f'{key} = "{value}"\n' for key, value in {**law, "missing_samples": "accept"}.items())
    (folder / "audit.toml").write_text(f"[law]\n{said}[utility]\nvalues = {{ A = 1 }}\n")
    assert main(["certify", "audit.toml", "-o", "c.json", "--attest", "a.json"]) == 0
    statement = json.loads((folder / "a.json").read_text())
    names = [source["name"] for source in statement["predicate"]["sources"]]
    assert sorted(names) == ["audit.toml", "people.csv", "run.json"]
    assert [source["name"] for source in statement["predicate"]["sources"] if "run" in source] == ["run.json"]
    code, text = recounted(capsys, "audit.toml", "run.json", "people.csv")
    assert code == 0 and "equal how answers were read" in text and "equal what 'run.json' says of its run" in text
    (folder / "secret.csv").write_text((folder / "people.csv").read_text())
    statement["predicate"]["options"]["audit"]["law"]["join"] = "secret.csv:id"
    (folder / "a.json").write_text(json.dumps(statement))
    assert recounted(capsys, "audit.toml", "run.json", "people.csv")[0] != 0


LOGS = Path(__file__).resolve().parents[1] / "tables" / "evaluations" / "logs"


@pytest.mark.parametrize(("given", "beside"), [("helm/published", "per_instance_stats.json"), ("lm-eval", "results_")])
def test_files_that_are_read_beside_a_log_are_sources(
    given: str, beside: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    shutil.copytree(LOGS / given, "logs")
    log = "logs" if given.startswith("helm") else str(next(Path("logs").glob("samples_loan_choice_*.jsonl")))
    of_helm = ["--decision", "answer", "--group", "instance.split", "--utility-column", "stats.exact_match"]
    of_harness = ["--decision", "argmax(filtered_resps[*][0])", "--group", "doc.region", "--utility", "1", "--unit", "doc_id"]
    assert main(["certify", log, *(of_helm if log == "logs" else of_harness), "-o", "c.json", "--attest", "a.json"]) == 0
    sources = json.loads(Path("a.json").read_text())["predicate"]["sources"]
    assert ["run" in source for source in sources] == [True, *[False] * (len(sources) - 1)]
    assert any(source["name"].startswith(beside) for source in sources[1:])
    code, said = recounted(capsys, log)
    assert code == 0 and "unknown" not in said
    changed = next(Path("logs").glob(f"{beside}*{Path(log).stem.rpartition('_')[2]}*" if log != "logs" else beside))
    changed.write_text(changed.read_text() + "\n")
    code, said = recounted(capsys, log)
    assert code == 1 and f"differs the source '{changed.name}'" in said
