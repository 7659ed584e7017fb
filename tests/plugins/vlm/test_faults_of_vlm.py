"""What a real server that misbehaves leaves in the journal, as the table of the documentation says; and what cannot be told by a word."""

from __future__ import annotations

import base64
import json
import sqlite3
import time
from collections import Counter
from collections.abc import Callable
from math import inf
from pathlib import Path
from typing import Any

import pytest
from asking import asked, key, outcomes, written
from hypothesis import given
from hypothesis import strategies as st
from language_server import KEY, Handler, completion, serving

from fairaudit.cli import main
from fairaudit.errors import InputError
from fairaudit.plugins.vlm.analyse import certify, tables
from fairaudit.plugins.vlm.answers import read_answer
from fairaudit.plugins.vlm.client import key_pattern
from fairaudit.plugins.vlm.experiment import read_experiment
from fairaudit.plugins.vlm.journal import Journal
from fairaudit.plugins.vlm.run import Budget

__all__ = ["key"]

PAGE = (Path(__file__).resolve().parents[3] / "docs" / "experiments.md").read_text("utf-8")
JSON = "application/json"
AZURE = {
    "error": {
        "message": "The response was filtered due to the prompt triggering a content management policy.",
        "param": "prompt", "code": "content_filter", "status": 400,
        "innererror": {"code": "ResponsibleAIPolicyViolation", "content_filter_result": {"violence": {"filtered": True}}},
    }
}  # fmt: skip


def sends(body: Any, status: int = 200, kind: str = JSON, **headers: str) -> Callable[[Handler, str], None]:
    data = body if isinstance(body, bytes) else json.dumps(body).encode()
    return lambda handler, good: handler.reply(status, data, {name.replace("_", "-"): value for name, value in headers.items()}, kind=kind)


def answers(**more: Any) -> Callable[[Handler, str], None]:
    return lambda handler, good: handler.reply(200, completion(**{"content": good, **more}))


def counts(usage: str) -> Callable[[Handler, str], None]:
    """A good answer with other text in place of its usage."""

    def send(handler: Handler, good: str) -> None:
        whole = completion(good)
        handler.reply(200, whole[: whole.index(b', "usage"')] + usage.encode() + b"}")

    return send


def sleeps(handler: Handler, good: str) -> None:
    time.sleep(0.9)
    handler.reply(200, completion(good))


def breaks(handler: Handler, good: str, sent: int = 100) -> None:
    if sent:
        handler.send_response(200)
        handler.send_header("Content-Type", JSON)
        handler.send_header("Content-Length", "5000")
        handler.end_headers()
        handler.wfile.write(completion(good)[:sent])
    handler.close_connection = True


def pieces(handler: Handler, good: str) -> None:
    """The key in two parts of a content, which no search for the key finds."""
    half = len(KEY) // 2
    parts = [{"type": "text", "text": part} for part in (good, KEY[:half], KEY[half:])]
    handler.reply(200, completion(None, message={"content": parts}))


BEHAVIOURS: dict[str, Callable[[Handler, str], None]] = {
    "an empty reply": sends(b""),
    "JSON that breaks off": lambda handler, good: handler.reply(200, completion(good)[:-20]),
    "a web page with status 200": sends(b"<html><title>Please sign in</title></html>", kind="text/html"),
    "an error with status 200": sends({"error": {"message": "upstream is busy", "code": 502}}),
    "an empty list of `choices`": sends({"choices": []}),
    "`choices` that is a number": sends({"choices": 3}),
    "a choice without a message": sends({"choices": [{"delta": {"content": "1"}}]}),
    "a JSON list": sends([{"choices": []}]),
    "a stream of events": sends(b'data: {"choices": [{"delta": {"content": "1"}}]}\n\ndata: [DONE]\n\n', kind="text/event-stream"),
    "UTF-16, or another encoding than UTF-8": lambda handler, good: handler.reply(200, completion(good).decode().encode("utf-16")),
    "JSON that is called text/plain": lambda handler, good: handler.reply(200, completion(good), kind="text/plain"),
    "status 204": sends(b"", 204),
    "`finish_reason` error": answers(finish_reason="error"),
    "the key, in pieces": pieces,
    "status 429 with `Retry-After`": sends({"error": {"message": "slow down"}}, 429, Retry_After="0.1"),
    "status 500": sends(b"oops", 500, kind="text/plain"),
    "status 503 with a web page": sends(b"<h1>Service Unavailable</h1>", 503, kind="text/html"),
    "nothing until the timeout": sleeps,
    "a connection that breaks half-way": breaks,
    "a connection that closes without a word": lambda handler, good: breaks(handler, good, 0),
    "a reply that is not the gzip that it says": sends(b"no gzip at all", Content_Encoding="gzip"),
    "more than 10 MB": sends(b" " * 10_000_100),
    "status 400 with the code `content_filter`": sends(AZURE, 400),
    "`refusal` in the message": answers(content=None, message={"refusal": "I cannot help with that."}),
    "`finish_reason` content_filter": answers(finish_reason="content_filter"),
    "status 200 with an error of the code `content_filter`": sends(AZURE),
    "usage of 5,000 digits": counts(f', "usage": {{"prompt_tokens": {"9" * 5000}, "completion_tokens": 1e999}}'),
    "usage below 0, as text, or true": counts(', "usage": {"prompt_tokens": -1, "completion_tokens": "7", "total_tokens": true}'),
    "no usage": counts(""),
    "a reply in small pieces": lambda handler, good: handler.slow(completion(good)),
    "the key, in the stated reason": lambda handler, good: handler.reply(200, completion(good.replace("=cmd()", f"Bearer {KEY}"))),
    "an answer that the output cap cut off": lambda handler, good: handler.reply(200, completion(good[:-12], finish_reason="length")),
    "status 401": sends({"error": {"message": f"Incorrect API key provided: {KEY}"}}, 401),
    "status 403 of a firewall that says “safety”": sends(b"<h1>Blocked for your safety: content_filter</h1>", 403, kind="text/html"),
    "status 404": sends({"error": {"message": "The model m does not exist"}}, 404),
    "status 400 with another code": sends({"error": {"message": "temperature is out of range", "code": "invalid_value"}}, 400),
    "status 429 with the code `insufficient_quota`": sends({"error": {"code": "insufficient_quota", "message": "no credit"}}, 429),
    "a redirect": sends(b"", 307, Location="http://127.0.0.1:9/"),
    "`Retry-After` of a day": sends(b"", 503, Retry_After="86400"),
}

TABLE = {
    cells[0]: (cells[1], cells[2])
    for cells in (
        [cell.strip() for cell in line.strip("| ").split(" | ")]
        for line in PAGE.split("| the server sends | asked again | outcome |")[1].split("\n\n")[0].splitlines()[2:]
    )
}


def test_the_table_tells_of_each_behaviour() -> None:
    assert list(TABLE) == list(BEHAVIOURS)
    assert len(TABLE) >= 25


def test_each_behaviour_leaves_what_the_table_says(tmp_path: Path) -> None:
    """All that do not stop the run in one run, each for one question and each time that it is asked; then the server is well again."""
    lasting = [name for name, (_, outcome) in TABLE.items() if not outcome.startswith("the run stops")]
    written(tmp_path, trials=-(-len(lasting) // 4) + 1)
    named: dict[str, str] = {}

    def wrong(key: str, attempt: int) -> Any:
        name = named.setdefault(key, lasting[len(named) - 1] if 0 < len(named) <= len(lasting) else "")
        return BEHAVIOURS.get(name, "")

    with serving(fault=wrong) as server:
        experiment, model, report = asked(tmp_path, server, concurrency=8, retries=1, timeout=0.6, max_unreadable=0)
        kinds = outcomes(tmp_path, experiment, model)
        found = {name: key for key, name in named.items() if name}
        assert set(found) == set(lasting)
        faults = {name for name in lasting if TABLE[name][1].startswith("fault")}
        unanswered = {name for name in lasting if TABLE[name][1].startswith(("fault", "open"))}
        for name in lasting:
            again, outcome = TABLE[name]
            key = found[name]
            assert (name, server.attempts[key]) == (name, 2 if again == "yes" else 1)
            assert (name, kinds.get(key)) == (name, outcome.split(",")[0])
        database = sqlite3.connect(tmp_path / "journal.sqlite")
        used = {
            f"{request[:32]}-{trial}": (into, out)
            for table in ("faults", "answers")
            for request, trial, into, out in database.execute(f"SELECT request, trial, input_tokens, output_tokens FROM {table}")
        }
        database.close()
        for name in lasting:
            outcome = TABLE[name][1]
            if not outcome.startswith("open"):
                into, out = used[found[name]]
                counted = outcome.endswith("counted as spent") or "counted as spent;" in outcome
                sent = "what was sent" in outcome
                assert (name, out) == (name, 0 if sent else 1000 if counted else 30)
                assert (name, into > 120) == (name, counted)
        assert (report.answered, report.faults) == (report.total - len(unanswered), len(faults))
        assert not report.complete
        with Journal(tmp_path / "journal.sqlite", experiment.digest, experiment.trials, create=False) as journal:
            lost = {f"{entry['request'][:32]}-{entry['trial']}" for entry in journal.unknown_fate()}
        assert lost == {found[name] for name in lasting if TABLE[name][1] == "open, counted as spent"}
        said = "\n".join(report.unanswered)
        assert all(words in said for words in ("upstream is busy", "Please sign in", "slow down", "oops", "Service Unavailable"))
        # A later run asks what is open by itself, and faults only if it is told to; nothing with an answer is asked again.
        named.update(dict.fromkeys(named, ""))
        before = dict(server.attempts)
        _, _, report = asked(tmp_path, server, max_unreadable=0)
        asked_now = {key for key, n in server.attempts.items() if n > before[key]}
        assert asked_now == {found[name] for name in unanswered - faults}
        assert report.faults == len(faults)
        _, _, report = asked(tmp_path, server, max_unreadable=0, ask_again=True)
        assert report.complete
        assert {key for key, n in server.attempts.items() if n > before[key]} == {found[name] for name in unanswered}
        everything = sum(server.attempts.values())
        # A server that repeats its reply to an idempotency key must not repeat a fault; what may have been answered keeps its key.
        for name in unanswered:
            used = [sent for sent, key in zip(server.names, server.keys, strict=True) if key == found[name]]
            assert (name, len(set(used))) == (name, 3 if name in faults else 1)
    for path in tmp_path.iterdir():
        assert KEY.encode() not in path.read_bytes(), path.name
        assert KEY[: len(KEY) // 2].encode() not in path.read_bytes(), path.name
    database = sqlite3.connect(tmp_path / "journal.sqlite")
    assert database.execute("SELECT count(*) FROM attempts").fetchone() == (everything,)
    database.close()


@pytest.mark.parametrize("name", [name for name, (_, outcome) in TABLE.items() if outcome.startswith("the run stops")])
def test_what_stops_a_run(name: str, tmp_path: Path) -> None:
    """At once, with the server's words, and nothing is recorded as an answer."""
    written(tmp_path)
    words = {
        "status 401": "Incorrect API key provided: [key]",
        "status 403 of a firewall that says “safety”": "Blocked for your safety",
        "status 404": "The model m does not exist",
        "status 400 with another code": "temperature is out of range",
        "status 429 with the code `insufficient_quota`": "no credit",
        "a redirect": "status 307; it redirects to 'http://127.0.0.1:9/'",
        "`Retry-After` of a day": "asks to wait 86400 s",
    }[name]
    with serving(fault=lambda key, attempt: BEHAVIOURS[name]) as server:
        if TABLE[name][1].endswith("exit code 3"):
            report = asked(tmp_path, server)[2]
            said = report.stopped
        else:
            with pytest.raises(InputError) as error:
                asked(tmp_path, server)
            said = str(error.value)
        assert words in said
        assert KEY not in said
        assert len(server.keys) == 1
        server.fault = lambda key, attempt: ""
        assert asked(tmp_path, server)[2].complete


def test_faults_may_have_meant_anything(tmp_path: Path) -> None:
    """A firewall that lets one order of the people through only: what is certified holds whatever the answers would have been."""
    path = written(tmp_path, trials=8)
    experiment = read_experiment(str(path))
    page = sends(b"<p>blocked", kind="text/html")

    def wrong(key: str, attempt: int) -> Any:
        text = server.bodies[-1]["messages"][-1]["content"]
        return page if "sick leave" in text and "HR1 Tom" in text else answers(content='{"HR1": "1.0", "HR2": "0.0"}')

    with serving(fault=wrong) as server:
        experiment, model, report = asked(tmp_path, server, concurrency=1, retries=0)
    assert report.faults == 8
    with Journal(tmp_path / "journal.sqlite", experiment.digest, experiment.trials, create=False) as journal:
        (table,) = tables(experiment, journal, model.key)
        assert table.kinds == {"choice": 24, "fault": 8}
        assert table.complete
        found = certify(experiment, table, experiment.settings[0], "slot", targets={"max_local_ratio": "2"})
    assert found.meanings["local"] == (1, inf)
    assert found.interval["local"][1] == inf
    assert {target.verdict for target in found.result.targets} <= {"depends", "inconclusive"}
    assert found.result.targets


def certified(path: Path, out: Path, capsys: pytest.CaptureFixture[str]) -> tuple[int, str, dict[str, Any]]:
    capsys.readouterr()
    code = main(["experiment", "certify", str(path), "--folder", str(out)])
    return code, capsys.readouterr().out, json.loads((out / "results.json").read_text())


@pytest.mark.parametrize("stops", ["budget", "500s for one cell", "fault of 200 kB that begins with an answer"])
def test_an_unfinished_run_never_passes(stops: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """What has no answer is a decision of unknown meaning, counted by cell: a gate that looks at the exit code stays shut."""
    path = written(tmp_path, trials=10, more='[targets]\nmax_local_ratio = "5/4"')
    body = completion('{"HR1": "1.0", "HR2": "0.0"}')
    seen = Counter[str]()

    def wrong(key: str, attempt: int) -> Any:
        text = server.bodies[-1]["messages"][-1]["content"]
        seen[text] += 1
        if "sick leave" in text and "HR1 Tom" in text and seen[text] > 1 and stops != "budget":
            return sends(b"{}", 500) if "500" in stops else sends(body + b" " * 200_000 + b"cut")
        return sends(body)

    budget = ["--max-tokens", "4000"] if stops == "budget" else []
    options = ["--folder", str(tmp_path), "--model", "m", "--concurrency", "1", "--retries", "0", *budget]
    with serving(fault=wrong) as server:
        assert main(["experiment", "run", str(path), "--base-url", server.url, *options]) == 3
    code, said, found = certified(path, tmp_path, capsys)
    assert code == 3
    assert found["verdict"] in ("depends", "inconclusive")
    cells = {(cell["context"], cell["slots"][0][0]): (cell["expected"], cell["answered"]) for cell in found["findings"][0]["cells"]}
    if stops == "budget":
        assert sum(int(n) for _, n in cells.values()) == len(server.keys) < 40
        assert f"the run is not complete: {len(server.keys)} of 40 answers are there, " in said
    else:
        assert cells == dict.fromkeys(cells, ("10", "10")) | {("sick leave", "Tom"): ("10", "1")}
    document = json.loads(next(tmp_path.glob("*slot.certificate.json")).read_text())
    assert document["subject"]["undecided"]["decisions"] == (["fault"] if "fault" in stops else ["open"])


def test_a_certificate_of_an_unfinished_run_holds_whatever_is_missing(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """It says within only of what no missing answer can exceed, here a ratio of 2/1, and lists these; the run itself is inconclusive."""
    path = written(tmp_path, trials=10, more='[utility]\nchosen = "2"\nother = "1"\n[targets]\nmax_local_ratio = "2"')
    options = ["--folder", str(tmp_path), "--model", "m", "--concurrency", "1", "--max-tokens", "4000"]
    with serving() as server:
        assert main(["experiment", "run", str(path), "--base-url", server.url, *options]) == 3
    code, _, found = certified(path, tmp_path, capsys)
    assert (code, found["verdict"]) == (3, "inconclusive")
    documents = [json.loads(one.read_text()) for one in tmp_path.glob("*.certificate.json")]
    judged = [target["verdict"] for document in documents for target in document["targets"]]
    assert judged and set(judged) == {"within"}
    assert all("open" in document["subject"]["undecided"]["decisions"] for document in documents)


@pytest.mark.parametrize("way", ["temperature = 0", "top_k = 1", "", "chatcmpl-0123456789abcdef"])
def test_answers_that_are_one_answer_give_no_interval(way: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    parameters = f"{{ options = {{ {way} }} }}" if "=" in way else "{}"
    reply = json.loads(completion('{"HR1": "1.0", "HR2": "0.0"}')) | ({"id": way} if "-" in way else {})
    with serving(fault=lambda key, attempt: sends(reply)) as server:
        model = f'[[model]]\nname = "m"\nbase_url = "{server.url}"\nparameters = {parameters}'
        path = written(tmp_path, trials=10, more=model)
        assert main(["experiment", "run", str(path), "--folder", str(tmp_path)]) == 0
    _, said, found = certified(path, tmp_path, capsys)
    assert ("no interval is claimed" in said) == bool(way)
    assert [bool(finding["interval"]) for finding in found["findings"]] == [not way] * 3
    for certificate in tmp_path.glob("*.certificate.json"):
        assert ("population" in [c.get("scope") for c in json.loads(certificate.read_text())["claims"]]) <= (not way)


def test_another_journal_is_answered_anew(tmp_path: Path) -> None:
    """A server that repeats what it said to an idempotency key replicates nothing: each journal has keys of its own."""
    with serving() as server:
        for name in ("a", "b"):
            (tmp_path / name).mkdir()
            written(tmp_path / name, trials=2)
            asked(tmp_path / name, server)
    assert len(set(server.names)) == 16
    assert len(set(server.keys)) == 8


def test_a_limit_on_the_cost_counts_what_was_spent_without_prices(tmp_path: Path) -> None:
    """What answers used at no price is priced at the prices now given: the limit then allows no other request."""
    written(tmp_path, trials=10)
    with serving() as server:
        asked(tmp_path, server, Budget(tokens=16 * 150 + 1500), concurrency=1)
        before = len(server.keys)
        priced = {"price_input": 1000.0, "price_output": 1000.0}
        assert "budget" in asked(tmp_path, server, Budget(money=before * 0.15), **priced)[2].stopped
        assert len(server.keys) == before


def test_the_cap_goes_under_the_name_that_the_server_takes(tmp_path: Path) -> None:
    """The refusal costs nothing, is written down, and is not repeated; the plan keeps the name of the file."""
    refuses = sends(
        {"error": {"message": "Unsupported parameter: 'max_tokens'. Use 'max_completion_tokens' instead.", "param": "max_tokens"}}, 400
    )
    written(tmp_path)
    with serving(fault=lambda key, attempt: refuses if "max_tokens" in server.bodies[-1] else "") as server:
        _, _, report = asked(tmp_path, server, concurrency=1, retries=0)
        assert report.complete
        assert [("max_tokens" in body, body.get("max_completion_tokens")) for body in server.bodies] == [(True, None)] + [
            (False, 1000)
        ] * 16
    with serving(fault=lambda key, attempt: refuses) as server, pytest.raises(InputError, match="Unsupported parameter"):
        asked((tmp_path / "again", (tmp_path / "again").mkdir(), written(tmp_path / "again"))[0], server)
    assert len(server.keys) == 2


@pytest.mark.parametrize("words", ["max_tokens is too large: at most 500", "max_completion_tokens must be at least 16"])
def test_a_cap_that_is_refused_for_its_number_keeps_its_name(words: str, tmp_path: Path) -> None:
    written(tmp_path)
    with serving(fault=lambda key, attempt: sends({"error": {"message": words}}, 400)) as server:
        with pytest.raises(InputError, match=words):
            asked(tmp_path, server)
        assert len(server.keys) == 1


@given(st.text("abcXYZ019-_/+.~=%", min_size=8, max_size=60), st.integers(0, 9), st.text(max_size=20), st.integers(0, 2))
def test_a_key_is_found_however_it_is_written(secret: str, form: int, around: str, before: int) -> None:
    broken = secret[:5] + "\r\n\t" + secret[5:]
    text = [
        secret,
        secret.replace("/", "\\/"),
        "".join(f"\\u{ord(c):04x}" for c in secret),
        "".join(f"\\\\u{ord(c):04X}" for c in secret),
        "".join(f"%{ord(c):02X}" for c in secret),
        "".join(f"&#{ord(c)};" for c in secret),
        secret.encode().hex(),
        broken,
        base64.b64encode(b"B" * before + secret.encode()).decode(),
        "\0".join(secret),
    ][form]
    found = key_pattern(secret)
    assert found is not None
    left = found.sub(b"[key]", (around + text + around).encode("utf-8", "replace")).decode("utf-8", "replace")
    assert "[key]" in left
    assert text not in left


@pytest.mark.parametrize("secret", ["none", "EMPTY", "1.0", "HR1"])
def test_a_short_key_changes_no_answer(secret: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """What is no secret is not looked for: an answer that contains the word stays as it came."""
    monkeypatch.setenv("OPENAI_API_KEY", secret)
    written(tmp_path, trials=1)
    with serving(
        key=secret, fault=lambda key, attempt: answers(content=json.dumps({"HR1": "1.0", "HR2": "0.0", "reason": secret}))
    ) as server:
        experiment, model, report = asked(tmp_path, server)
    assert report.complete
    assert set(outcomes(tmp_path, experiment, model).values()) == {"choice"}


def test_a_key_that_is_part_of_the_choice_is_a_fault(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Neither is the key kept, nor is the answer changed by cutting it out."""
    secret = '"HR1": "1.0"'  # noqa: S105
    monkeypatch.setenv("OPENAI_API_KEY", secret)
    written(tmp_path, trials=1)
    with serving(key=secret, fault=lambda key, attempt: answers(content='{"HR1": "1.0", "HR2": "0.0"}')) as server:
        with pytest.raises(InputError, match="cannot be cut out"):
            asked(tmp_path, server, retries=0)
        assert len(server.keys) == 1


def test_a_key_in_a_header_or_in_utf_16_is_not_kept(tmp_path: Path) -> None:
    written(tmp_path, trials=1)
    replies = [sends(b"x", kind=f"text/{KEY}"), sends(f"your key {KEY}".encode("utf-16"))]
    with serving(fault=lambda key, attempt: replies[attempt % 2] if attempt < 3 else "") as server:
        assert asked(tmp_path, server)[2].complete
        assert len(server.keys) == 4 * 3
    for path in tmp_path.iterdir():
        assert KEY.encode() not in path.read_bytes().replace(b"\0", b"")


def test_a_content_filter_is_a_refusal() -> None:
    for status, document in ((400, AZURE), (400, [AZURE]), (200, AZURE)):
        assert read_answer(read_experiment("document-delivery"), status, JSON, json.dumps(document).encode()).kind == "refused"


def test_a_journal_of_another_version_is_refused_and_left_as_it_is(tmp_path: Path) -> None:
    written(tmp_path)
    with serving() as server:
        experiment, model, _ = asked(tmp_path, server)
        path = tmp_path / "journal.sqlite"
        for version, expected in (("fairaudit-journal/1", "not a journal of the version that is read"), ("fairaudit-journal/2", "")):
            with sqlite3.connect(path) as database:
                database.execute("UPDATE meta SET value = ? WHERE key = 'version'", (version,))
            database.close()
            if expected:
                with pytest.raises(InputError, match=expected):
                    asked(tmp_path, server)
        assert len(server.keys) == 16
        assert set(outcomes(tmp_path, experiment, model).values()) == {"choice"}


def test_an_endpoint_that_never_answered_is_left_out(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """One that refuses every request, and one where nobody listens, block neither figures nor certificates of the one that answers."""
    path, folder = written(tmp_path), tmp_path / "out"
    whole = ["experiment", "run", str(path), "--folder", str(folder), "--model", "m"]

    def gone(handler: Handler, good: str) -> None:
        handler.reply(404, b"no such page")

    with serving(fault=lambda key, attempt: gone) as wrong:
        assert main([*whole, "--base-url", wrong.url]) == 2
    assert main([*whole, "--base-url", wrong.url.replace("/v1", "/v2"), "--retries", "0"]) == 2
    before = {one.name for one in folder.iterdir()}
    asked_of = ["experiment", "certify", str(path), "--folder", str(folder)]
    assert main(asked_of) == 2 and "have no answers yet" in capsys.readouterr().err
    assert {one.name for one in folder.iterdir()} == before
    with serving() as server:
        assert main([*whole, "--base-url", server.url]) == 0
    capsys.readouterr()
    assert main([*asked_of, "--confidence", "none"]) in (0, 1, 3)
    said = capsys.readouterr()
    assert said.err.count("has no answers and is left out; run with its --model and --base-url asks again") == 2
    results = json.loads((folder / "results.json").read_text())
    assert {entry["model"] for entry in results["findings"]} == {f"m at {server.url}"}
    assert results["left_out"] == [f"m at {wrong.url}", f"m at {wrong.url.replace('/v1', '/v2')}"]
