"""Random logs of every format, counted as a few plain lines count them while they are made."""

from __future__ import annotations

import json
import random
import zipfile
from collections import Counter
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
import tiers

import fairaudit as fa
from fairaudit.errors import InputError

SEEDS = 400 if tiers.FULL else 12
ANSWERS = ["yes", "no", "YES", "-0.0", "0", "true", "None", "null", " yes ", "é", "1e2", "nan", "", " ", "a\u2028b\n"]
CUT = ("length", "max_tokens", "model_length")
DECLINED = ("content_filter", "refusal")

Counts = Counter[tuple[str, str | None]]  # by decision and group
Made = tuple[Path, str, str, list[str], Counts]  # file, decision, group, unit, and what is to be counted


def ended(reason: str | None, answer: str) -> str:
    return "truncated" if reason in CUT else "refused" if reason in DECLINED else answer if answer.strip() else "unreadable"


def lines(path: Path, rows: list[Any], draw: random.Random) -> Path:
    """With or without a byte order mark, a line feed at the end, and carriage returns."""
    end = draw.choice(["\n", "\r\n"])
    path.write_bytes((draw.choice(["", "\ufeff"]) + end.join(map(json.dumps, rows)) + draw.choice(["", end, end * 2])).encode())
    return path


def of_inspect(folder: Path, draw: random.Random) -> Made:
    number, epochs = draw.randint(1, 12), draw.randint(1, 3)
    samples, counts = [], Counts()
    for question, epoch in [(question, epoch) for question in range(number) for epoch in range(1, epochs + 1)]:
        answer, reason = draw.choice(ANSWERS), draw.choice([*CUT, *DECLINED, None, "stop", "stop", "other"])
        failed, limited = draw.random() < 0.15, draw.random() < 0.1
        race, text = draw.choice([("a", "a"), (1, "1"), (True, "true"), (0.5, "0.5"), (None, None)])
        sample: dict[str, Any] = {"id": question if question % 2 else f"q{question}", "epoch": epoch, "metadata": {"race": race}}
        sample["output"] = {"choices": [{"stop_reason": reason}]} if draw.random() < 0.5 else {"stop_reason": reason}
        sample |= {
            "scores": {"c": {"answer": answer}},
            "events": [{"id": 1}] * draw.randint(0, 3),
            "limit": {"type": "time"} if limited else None,
        }
        if failed:
            sample |= draw.choice([{"error": {"message": "x"}, "scores": {}}, {"invalidation": {}}])
        samples.append(sample)
        found = ended(reason, answer)
        cut = limited and reason not in (*CUT, *DECLINED)
        counts["error" if failed else "truncated" if cut else found, text] += 1
    asked = {"model": "m", "task": "t", "config": {"epochs": epochs}, "dataset": {"sample_ids": [*range(number)]}}
    header = {"version": 2, "status": "success", "eval": asked}
    if draw.random() < 0.5:
        path = folder / "run.json"
        path.write_text(json.dumps({**header, "samples": samples}))
    else:
        path = folder / "run.eval"
        with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as archive:
            archive.writestr("_journal/start.json", json.dumps(header))
            for sample in samples:
                archive.writestr(f"samples/{sample['id']}_epoch_{sample['epoch']}.json", json.dumps(sample))
            archive.writestr("header.json", json.dumps(header))
    return path, "scores.c.answer", "metadata.race", ["id", "epoch"], counts


def of_batches(folder: Path, draw: random.Random) -> Made:
    rows, counts = [], Counts()
    for number in range(draw.randint(1, 30)):
        answer, reason = draw.choice(ANSWERS), draw.choice(["stop", "stop", "length", "content_filter"])
        status, declined, failed, lost = draw.choice([200, 200, 200, 429]), draw.random() < 0.1, draw.random() < 0.1, draw.random() < 0.1
        message = {"content": answer, "refusal": "no" if declined else None}
        body = {"model": "m", "choices": [{"message": message, "finish_reason": reason}]}
        response = None if lost else {"status_code": status, "body": body}
        rows.append({"custom_id": f"r{number}", "response": response, "error": {"code": "x"} if failed else None})
        counts["error" if failed or lost or status != 200 else "refused" if declined else ended(reason, answer), "m"] += 1
    draw.shuffle(rows)
    return lines(folder / "o.jsonl", rows, draw), "response.body.choices[0].message.content", "eval.model", ["custom_id"], counts


def of_every_eval_ever(folder: Path, draw: random.Random) -> Made:
    rows, counts = [], Counts()
    for number, epoch in [(number, epoch) for number in range(draw.randint(1, 20)) for epoch in range(draw.randint(1, 2))]:
        answer, reason, race = draw.choice(ANSWERS), draw.choice(["stop", None, *CUT, *DECLINED]), draw.choice("ab")
        failed, taken = draw.random() < 0.2, draw.random() < 0.9
        steps = [{"extracted_value": "not this", "is_terminal": False}, {"extracted_value": answer, "is_terminal": taken}]
        row = {"schema_version": "0.2.2", "interaction_type": "single_turn", "answer_attribution": steps, "sample_id": f"s{number}"}
        row |= {"model_id": "m", "evaluation_id": "e", "evaluation_name": "n", "error": "x" if failed else None}
        rows.append({**row, "metadata": {"race": race, "epoch": str(epoch), "stop_reason": reason}})
        counts["error" if failed else ended(reason, answer if taken else ""), race] += 1
    return lines(folder / "e_samples.jsonl", rows, draw), "answer", "metadata.race", ["sample_id", "metadata.epoch"], counts


def of_helm(folder: Path, draw: random.Random) -> Made:
    rows, counts, trials = [], Counts(), draw.randint(1, 2)
    for number, trial in [(number, trial) for number in range(draw.randint(1, 15)) for trial in range(trials)]:
        names = draw.choice([None, {"A": "yes", "0": "no"}])
        answer = draw.choice(ANSWERS if names is None else ["A", "0", " A", "Z"])
        reason, done, empty, race = (
            draw.choice(["stop", *CUT, "content_filter"]),
            draw.random() < 0.8,
            draw.random() < 0.1,
            draw.choice("ab"),
        )
        completions = [] if empty else [{"text": answer, "finish_reason": {"reason": reason}}]
        row = {"instance": {"id": f"i{number}", "split": race}, "train_trial_index": trial, "output_mapping": names}
        rows.append({**row, "result": {"success": done, "completions": completions}})
        said = answer.strip() if names is None else names.get(answer.strip(), "")
        counts["error" if empty or not done else ended(reason, said), race] += 1
    path = folder / "scenario_state.json"
    path.write_text(json.dumps({"adapter_spec": {"model": "m", "num_train_trials": trials}, "request_states": rows}))
    return path, "answer", "instance.split", ["instance.id", "train_trial_index"], counts


def of_promptfoo(folder: Path, draw: random.Random) -> Made:
    rows, counts = [], Counts()
    for number in range(draw.randint(1, 20)):
        answer, failure, race = draw.choice(ANSWERS), draw.choice([0, 0, 1, 2]), draw.choice("ab")
        declined, reason = draw.random() < 0.2, draw.choice(["stop", "length"])
        response = {"output": answer, "isRefusal": declined, "finishReason": reason}
        row = {"promptIdx": 0, "testIdx": number, "testCase": {}, "vars": {"race": race, "number": number}}
        rows.append({**row, "response": response, "failureReason": failure})
        counts["error" if failure == 2 else "refused" if declined else ended(reason, answer), race] += 1
    if draw.random() < 0.5:
        path = lines(folder / "p.jsonl", rows, draw)
    else:
        path = folder / "p.json"
        stats = {"successes": len(rows), "failures": 0, "errors": 0}
        path.write_text(json.dumps({"evalId": "x", "results": {"stats": stats, "results": rows, "prompts": []}}))
    return path, "response.output", "vars.race", ["vars.number"], counts


def of_harness(folder: Path, draw: random.Random) -> Made:
    rows, counts = [], Counts()
    for number in range(draw.randint(1, 20)):
        likelihoods, race = draw.sample(range(-50, 50), 3), draw.choice("ab")
        each = [[str(value / 10), "False"] for value in likelihoods]
        rows.append({"doc_id": number, "doc": {"race": race}, "resps": [[part] for part in each], "filtered_resps": each, "filter": "none"})
        counts[str(likelihoods.index(max(likelihoods))), race] += 1
    return lines(folder / "samples_x.jsonl", rows, draw), "argmax(filtered_resps[*][0])", "doc.race", ["doc_id"], counts


def of_records(folder: Path, draw: random.Random) -> Made:
    rows: list[dict[str, Any]] = [{"spec": {"run_id": "r", "eval_name": "e", "completion_fns": ["m"]}}]
    counts = Counts()
    for number in range(draw.randint(1, 20)):
        answer, matched = draw.choice(ANSWERS), draw.random() < 0.8
        for kind, said in (("sampling", "not this"), ("match", answer))[: 1 + matched]:
            event = {"run_id": "r", "event_id": len(rows), "sample_id": f"s{number}", "type": kind, "data": {"sampled": said}}
            rows.append(event)
        counts[ended(None, answer) if matched else "error", "m"] += 1
    return lines(folder / "oe.jsonl", rows, draw), "data.sampled", "eval.model", ["sample_id"], counts


MAKERS = (of_inspect, of_batches, of_every_eval_ever, of_helm, of_promptfoo, of_harness, of_records)


@pytest.mark.parametrize("maker", MAKERS)
def test_counts_are_those_of_plain_loops(tmp_path: Path, maker: Callable[[Path, random.Random], Made]) -> None:
    counted = 0
    for seed in range(SEEDS):
        path, decision, group, unit, expected = maker(tmp_path, random.Random(seed))
        try:
            tally = fa.read_log(path, [decision, group, *unit], decision=decision, group=group, unit=unit, errors="bound")
        except InputError as error:
            assert "there is no path" in str(error)  # of which no sample has a value
            assert all(name is None for _, name in expected) or {name for name, _ in expected} <= {"error", "refused", "truncated"}
            continue
        found: Counts = Counter()
        for answer, name, times in zip(tally[decision], tally[group], tally.counts.tolist(), strict=True):
            found[str(answer), None if name is None else "true" if name is True else str(name)] += times
        assert found == expected, seed
        counted += 1
    assert counted > SEEDS // 2
