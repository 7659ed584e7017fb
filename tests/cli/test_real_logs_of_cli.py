"""Logs as their producers write them, by the commands a reader of logs uses: two models, certificates, attestations, counted again."""

from __future__ import annotations

import json
import zipfile
from collections import Counter
from collections.abc import Callable
from fractions import Fraction
from pathlib import Path

import pytest
from made_by_inspect import logs_of, with_zstd
from two_model_runs import FIRST, QUESTIONS, RACES, SECOND, is_right, race_of, topic_of

from fairaudit.cli import main

TESTS = Path(__file__).resolve().parents[1]
LOGS = TESTS / "tables" / "evaluations" / "logs"

VALUE = ["--decision", "scores.choice.value", "--utility", "C=1", "--unit", "id"]
ZSTD = 93


@pytest.fixture(scope="module")
def runs(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = logs_of("two_model_runs.py", tmp_path_factory.mktemp("two-models"))
    with zipfile.ZipFile(folder / "first.eval") as archive:
        assert {member.compress_type for member in archive.infolist() if member.filename.startswith("samples/")} == {ZSTD}
    return folder


def right(model: str, race: str) -> Fraction:
    people = [question for question in range(QUESTIONS) if race_of(question) == race]
    return Fraction(sum(is_right(model, question) for question in people), len(people))


def greatest(rates: list[Fraction]) -> Fraction:
    return max(rates) / min(rates)


def test_which_of_two_models_serves_people_better(runs: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    logs = [str(runs / "first.eval"), str(runs / "second.eval")]
    made, attested = str(tmp_path / "c.json"), str(tmp_path / "a.json")
    words = [*logs, *VALUE, "--group", "eval.model", "--context", "metadata.person.race"]
    assert main(["certify", *words, "-o", made, "--attest", attested]) == 0
    document = json.loads(Path(made).read_text())
    said = document["subject"]["evaluation"]
    assert said["samples"] == dict.fromkeys(("expected", "read", "counted", "rows"), 2 * QUESTIONS)
    assert (said["question"], said["unit"], said["drawn"]) == ("id", ["id"], "questions were drawn; epochs of a question count once")
    header = document["subject"]["table"]["header"]
    found: Counter[tuple[str, str, str]] = Counter()
    for row in document["subject"]["table"]["rows"]:
        (race,), (model,) = header["contexts"][row["context"]], header["groups"][row["group"]]
        found.update({(race, model, value): int(n) for value, n in zip(header["decisions"], row["weights"], strict=True)})
    asked = [(model, question) for model in (FIRST, SECOND) for question in range(QUESTIONS)]
    assert +found == Counter((race_of(question), model, "CI"[not is_right(model, question)]) for model, question in asked)
    local = greatest([right(FIRST, "black"), right(SECOND, "black")])
    assert local > greatest([right(FIRST, "white"), right(SECOND, "white")])
    assert Fraction(document["metrics"]["local"]["ratio"]) == local
    interval = document["intervals"]["local"]
    assert interval["region"] == "paired" and Fraction(interval["ratio"][0]) <= local <= Fraction(interval["ratio"][1])
    runs_said = [source["run"] for source in json.loads(Path(attested).read_text())["predicate"]["sources"]]
    assert [(run["model"], run["status"], run["format"]) for run in runs_said] == [(m, "success", "inspect") for m in (FIRST, SECOND)]
    capsys.readouterr()
    assert main(["verify", made, "--attestation", attested, "--recount", *logs]) == 0
    short = [logs[0], str(runs / "second-short.eval")]
    assert main(["certify", *short, *words[2:], "-o", str(tmp_path / "short.json")]) == 2
    assert f"not all were asked the same: eval.model='{SECOND}' lacks id {QUESTIONS - 1} of {QUESTIONS}" in capsys.readouterr().err


def test_which_of_two_models_is_less_fair(runs: Path, capsys: pytest.CaptureFixture[str]) -> None:
    logs = [str(runs / "first.eval"), str(runs / "second.eval")]
    words = [*VALUE, "--group", "metadata.person.race", "--format", "json"]
    old, new = (greatest([right(model, race) for race in RACES]) for model in (FIRST, SECOND))
    assert (old, new) == (1, 4)
    for given, expected, verdict in (logs, 1, "less fair"), (logs[::-1], 0, "no less fair"):
        capsys.readouterr()
        assert main(["compare", *given, *words]) == expected
        result = json.loads(capsys.readouterr().out)["result"]
        local = next(entry for entry in result["fairness"] if entry["quantity"] == "local")
        assert local["verdict"] == verdict and local["confidence"] == "19/20"
        models, quotient = ((FIRST, SECOND), new / old) if given is logs else ((SECOND, FIRST), old / new)
        low, high = map(Fraction, local["ratio"])
        assert low <= quotient <= high
        rates = {tuple(rate["group"].values()): rate for rate in result["by_unit"]["rates"]}
        assert sorted(rates) == [(race,) for race in RACES]
        for (race,), rate in rates.items():
            means = [right(model, race) for model in models]
            assert rate["units"] == QUESTIONS // 2 and [Fraction(rate["old"]), Fraction(rate["new"])] == means
            assert Fraction(rate["difference"][0]) <= means[1] - means[0] <= Fraction(rate["difference"][1])
            assert Fraction(rate["ratio"][0]) <= means[1] / means[0] <= Fraction(rate["ratio"][1])


def with_another_answer(archive: Path, changed: Path, question: int) -> None:
    """The same archive, compressed in the same way, in which one question got the other letter."""
    with with_zstd.ZipFile(archive) as given, with_zstd.ZipFile(changed, "w") as written:
        for member in given.infolist():
            content = given.read(member)
            if member.filename == f"samples/{question}_epoch_1.json":
                sample = json.loads(content)
                answer = sample["scores"]["choice"]["answer"]
                sample["scores"]["choice"]["answer"] = {"A": "B", "B": "A"}[answer]
                content = json.dumps(sample).encode()
            written.writestr(member.filename, content, compress_type=member.compress_type)


def there_and_back(words: list[str], logs: list[str], change: Callable[[], object], capsys: pytest.CaptureFixture[str]) -> str:
    """Certify, attest, count again; change one answer, and say what is found then."""
    assert main(["certify", *words, "-o", "c.json", "--attest", "a.json"]) == 0
    again = ["verify", "c.json", "--attestation", "a.json", "--recount", *logs]
    capsys.readouterr()
    assert main(again) == 0
    said = " ".join(capsys.readouterr().out.split())
    assert "equal the table" in said and "equal how answers were read" in said and "differs" not in said
    change()
    assert main(again) == 1
    return " ".join(capsys.readouterr().out.split())


@pytest.mark.deep
def test_an_archive_there_and_back(runs: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    monkeypatch.chdir(tmp_path)
    Path("run.eval").write_bytes((runs / "first.eval").read_bytes())
    question = 11
    assert is_right(FIRST, question) is False
    roles = ["--decision", "scores.choice.answer", "--group", "metadata.person.race", "--context", "metadata.topic", "--utility", "A"]
    change = lambda: with_another_answer(runs / "first.eval", Path("run.eval"), question)  # noqa: E731
    said = there_and_back(["run.eval", *roles, "--unit", "id"], ["run.eval"], change, capsys)
    cell = [q for q in range(QUESTIONS) if (race_of(q), topic_of(q)) == (race_of(question), topic_of(question))]
    granted = sum(is_right(FIRST, q) for q in cell)
    assert "differs the source 'run.eval'" in said and "equal what 'run.eval' says of its run" in said
    assert (
        f"the first differing cell is metadata.topic='{topic_of(question)}', metadata.person.race='{race_of(question)}': "
        f"decision 'A' {granted} in the certificate, {granted + 1} in the log; decision 'B' {len(cell) - granted} in the certificate, "
        f"{len(cell) - granted - 1} in the log; 1 cell differs"
    ) in said


def test_every_eval_ever_there_and_back(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    """Lines as the converter of Every Eval Ever wrote them, for other samples."""
    monkeypatch.chdir(tmp_path)
    line = json.loads((LOGS / "eee" / "mmlu_samples.jsonl").read_text().splitlines()[0])

    def write(answers: str) -> None:
        rows = []
        for number, answer in enumerate(answers):
            steps = [{**step, "extracted_value": answer} for step in line["answer_attribution"]]
            metadata = {"region": ["north", "south"][number % 2]}
            rows.append({**line, "sample_id": f"id{number}", "answer_attribution": steps, "metadata": metadata})
        Path("mmlu_samples.jsonl").write_text("".join(json.dumps(row) + "\n" for row in rows))

    given = "AABBC" * 8
    write(given)
    words = ["mmlu_samples.jsonl", "--decision", "answer", "--group", "metadata.region", "--utility", "A", "--unit", "sample_id"]
    words += ["--where", f"evaluation_result_id={line['evaluation_result_id']}"]
    said = there_and_back(words, ["mmlu_samples.jsonl"], lambda: write("B" + given[1:]), capsys)
    given = given[::2]
    assert (
        f"the first differing cell is metadata.region='north': decision 'A' {given.count('A')} in the certificate, "
        f"{given.count('A') - 1} in the log; decision 'B' {given.count('B')} in the certificate, {given.count('B') + 1} in the log; "
        "1 cell differs"
    ) in said


def test_a_batch_there_and_back(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    monkeypatch.chdir(tmp_path)
    for name in ("output.jsonl", "prompts.csv"):
        Path(name).write_bytes((LOGS / "openai" / name).read_bytes())
    words = ["output.jsonl", "--join", "prompts.csv:custom_id", "--decision", "response.body.choices[0].message.content"]
    words += ["--extract", "(?i)(yes|no)", "--group", "region", "--utility", "Yes", "--errors", "drop", "--missing-samples", "accept"]
    text = Path("output.jsonl").read_text()
    lines = [json.loads(line) for line in text.splitlines()]
    regions = dict(line.split(",") for line in Path("prompts.csv").read_text().splitlines()[1:])
    bodies = {line["custom_id"]: (line["response"] or {}).get("body", {}) for line in lines}
    content = {name: body["choices"][0]["message"]["content"] for name, body in bodies.items() if "choices" in body}
    assert content["request-4"] == "No" and regions["request-4"] == "south"
    counts = Counter(said for name, said in content.items() if regions[name] == "south")

    def change() -> None:
        asked = next(line for line in lines if line["custom_id"] == "request-4")
        asked["response"]["body"]["choices"][0]["message"]["content"] = "Yes"
        Path("output.jsonl").write_text("".join(json.dumps(line) + "\n" for line in lines))

    said = there_and_back(words, ["output.jsonl", "prompts.csv"], change, capsys)
    assert "equal the source 'prompts.csv'" in said and "differs the source 'output.jsonl'" in said
    assert (
        f"the first differing cell is region='south': decision 'No' {counts['No']} in the certificate, {counts['No'] - 1} in the log; "
        f"decision 'Yes' {counts['Yes']} in the certificate, {counts['Yes'] + 1} in the log; 1 cell differs"
    ) in said
