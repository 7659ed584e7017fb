"""How long a log of a million samples takes, as a multiple of what Python's own JSON parser takes for its text. Not a test.

Run: python tests/benchmarks/evaluations.py [SAMPLES [FORMAT ...]], where the formats are those of `FORMATS`.
"""

from __future__ import annotations

import json
import random
import sys
import tempfile
import time
import tracemalloc
import zipfile
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import fairaudit as fa

QUESTION = "some words of a question, "

LENGTHS = {"short rows": 1, "long rows": 60}
"""How often the words of a question are repeated."""

Row = dict[str, Any]


def drawn(samples: int, words: int) -> Iterator[tuple[int, random.Random, Row]]:
    """Numbers of samples, and what is known of who is asked about."""
    draw = random.Random(1)
    for number in range(samples):
        yield number, draw, {"race": draw.choice("bw"), "category": draw.choice("abcd"), "question": QUESTION * words}


def rows(samples: int, words: int) -> Iterator[Row]:
    for number, draw, known in drawn(samples, words):
        scores = {"choice": {"answer": draw.choice("AB"), "value": "C", "p": draw.random()}}
        likely = [[str(draw.random()), "False"], [str(draw.random()), "True"]]
        yield {"id": number, "doc": known, "answer": draw.choice(["I say yes.", "I say no."]), "scores": scores, "likely": likely}


def lm_eval(samples: int, words: int) -> Iterator[Row]:
    for number, draw, known in drawn(samples, words):
        likely = [[str(-9 * draw.random()), "False"], [str(-9 * draw.random()), "True"]]
        asked = {f"gen_args_{choice}": {"arg_0": known["question"], "arg_1": f" {'AB'[choice]}"} for choice in (0, 1)}
        yield {
            "doc_id": number,
            "doc": known,
            "target": "0",
            "arguments": asked,
            "resps": [[each] for each in likely],
            "filtered_resps": likely,
            "filter": "none",
            "metrics": ["acc"],
            "acc": draw.random() < 0.5,
            "doc_hash": f"{draw.getrandbits(256):064x}",
            "prompt_hash": f"{draw.getrandbits(256):064x}",
        }


def every_eval_ever(samples: int, words: int) -> Iterator[Row]:
    for number, draw, known in drawn(samples, words):
        answer = draw.choice("AB")
        taken = {"turn_idx": 0, "source": "output.raw", "extracted_value": answer, "extraction_method": "exact", "is_terminal": True}
        yield {
            "schema_version": "0.3.0",
            "evaluation_id": "task/m/1",
            "model_id": "m",
            "evaluation_name": "task",
            "evaluation_result_id": None,
            "sample_id": str(number),
            "sample_hash": f"{draw.getrandbits(256):064x}",
            "interaction_type": "single_turn",
            "input": {"raw": known["question"], "formatted": None, "reference": ["A"]},
            "output": {"raw": [answer]},
            "messages": None,
            "answer_attribution": [taken],
            "error": None,
            "evaluation": {"score": float(answer == "A"), "is_correct": answer == "A", "num_turns": 1, "tool_calls_count": 0},
            "token_usage": {"input_tokens": 129, "output_tokens": draw.randrange(999), "total_tokens": 485, "reasoning_tokens": None},
            "metadata": {"stop_reason": "stop", "epoch": "1", "race": known["race"]},
        }


def inspect(samples: int, words: int) -> Iterator[Row]:
    for number, draw, known in drawn(samples, words):
        answer = draw.choice("AB")
        said = {"id": f"m{number}", "content": answer, "source": "generate", "role": "assistant", "model": "m"}
        yield {
            "id": number,
            "epoch": 1,
            "input": known["question"],
            "choices": ["yes", "no"],
            "target": "A",
            "metadata": known,
            "messages": [said],
            "output": {"model": "m", "choices": [{"message": said, "stop_reason": "stop"}]},
            "scores": {"choice": {"value": "C" if answer == "A" else "I", "answer": answer}},
            "store": {},
            "total_time": draw.random(),
        }


def helm(samples: int, words: int) -> Iterator[Row]:
    for number, draw, known in drawn(samples, words):
        answer = draw.choice("AB")
        references = [{"output": {"text": text}, "tags": ["correct"] if text == "yes" else []} for text in ("yes", "no")]
        said = {"text": f" {answer}", "logprob": -draw.random(), "tokens": [], "finish_reason": {"reason": "stop"}}
        yield {
            "instance": {
                "id": f"id{number}",
                "split": "test",
                "input": {"text": known["question"]},
                "references": references,
                "extra_data": known,
            },
            "train_trial_index": 0,
            "output_mapping": {"A": "yes", "B": "no"},
            "request": {"model": "m", "prompt": known["question"]},
            "result": {"success": True, "cached": False, "completions": [said]},
            "num_train_instances": 5,
            "prompt_truncated": False,
        }


def promptfoo(samples: int, words: int) -> Iterator[Row]:
    for number, draw, known in drawn(samples, words):
        yield {
            "promptIdx": 0,
            "testIdx": number,
            "testCase": {"vars": known, "metadata": {"person": number}},
            "vars": known,
            "metadata": {"person": number, "race": known["race"]},
            "provider": {"id": "m", "label": "m"},
            "success": True,
            "response": {"output": draw.choice(["yes", "no"]), "tokenUsage": {"total": 20}},
            "failureReason": 0,
            "score": draw.random(),
        }


def openai(samples: int, words: int) -> Iterator[Row]:
    for number, draw, known in drawn(samples, words):
        said = {"role": "assistant", "content": draw.choice(["yes", "no"]) + ", for " + known["question"], "refusal": None}
        usage = {"prompt_tokens": 53, "completion_tokens": draw.randrange(99), "prompt_tokens_details": {"cached_tokens": 0}}
        body = {
            "id": f"chatcmpl-{draw.getrandbits(128):032x}",
            "object": "chat.completion",
            "created": 1795431516,
            "model": "m",
            "choices": [{"index": 0, "message": said, "finish_reason": "stop", "logprobs": None}],
            "usage": usage,
            "system_fingerprint": "b0-unknown",
        }
        response = {"status_code": 200, "request_id": f"req_{number}", "body": body}
        yield {"id": f"batch_req_{number}", "custom_id": f"s{number}", "response": response, "error": None}


def evals(samples: int, words: int) -> Iterator[Row]:
    for number, draw, known in drawn(samples, words):
        event = {"run_id": "r", "event_id": number, "sample_id": f"s{number}", "created_by": "", "created_at": "2026-01-31"}
        yield {**event, "type": "match", "data": {**known, "sampled": draw.choice("AB"), "p": draw.random()}}


def lines(path: Path, found: Iterator[Row]) -> None:
    with path.open("w") as file:
        file.writelines(json.dumps(row) + "\n" for row in found)


def inside(before: str, after: str = "]}") -> Callable[[Path, Iterator[Row]], None]:
    """Make a writer of one document, in which samples are a list."""

    def write(path: Path, found: Iterator[Row]) -> None:
        with path.open("w") as file:
            file.write(before)
            file.writelines((",\n" if place else "") + json.dumps(row) for place, row in enumerate(found))
            file.write(after)

    return write


RUN = '{"task": "task", "model": "m", "dataset": {}, "config": {"epochs": 1}}'

HEADER = f'"version": 2, "status": "success", "eval": {RUN}, "plan": {{"steps": []}}'


def archive(path: Path, found: Iterator[Row]) -> None:
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as file:
        file.writestr("header.json", f"{{{HEADER}}}")
        for row in found:
            file.writestr(f"samples/{row['id']}_epoch_1.json", json.dumps(row))


@dataclass(frozen=True)
class Kind:
    """A format: how its samples look, how they are written, and what is asked of them.

    Attributes
    ----------
    rows : callable
        Makes samples.
    name : str
        What a file is called.
    columns : list of str
        The decision and the group.
    unit : str
        The path of the unit.
    write : callable
        Writes samples to a file.
    asked : mapping
        What else is asked, by what it is called here.
    """

    rows: Callable[[int, int], Iterator[Row]]
    name: str
    columns: list[str]
    unit: str
    write: Callable[[Path, Iterator[Row]], None] = lines
    asked: dict[str, tuple[list[str], dict[str, Any]]] = field(default_factory=dict)


ANSWERS = "response.body.choices[0].message.content"

FORMATS = {
    "rows": Kind(
        *(rows, "log.jsonl", ["scores.choice.answer", "doc.race"], "id"),
        asked={
            "the greatest of a list": (["argmax(likely[*][0])", "doc.race"], {}),
            "an expression": (["answer", "doc.race"], {"decision": "answer", "extract": "(yes|no)"}),
            "a condition": (["scores.choice.answer", "doc.race"], {"where": {"scores.choice.value": "C"}}),
        },
    ),
    "lm-eval": Kind(lm_eval, "samples.jsonl", ["argmax(filtered_resps[*][0])", "doc.race"], "doc_id"),
    "eee": Kind(every_eval_ever, "task_samples.jsonl", ["answer", "metadata.race"], "sample_id"),
    "inspect .json": Kind(inspect, "log.json", ["scores.choice.answer", "metadata.race"], "id", inside(f'{{{HEADER}, "samples": [')),
    "inspect .eval": Kind(inspect, "log.eval", ["scores.choice.answer", "metadata.race"], "id", archive),
    "helm": Kind(
        *(helm, "scenario_state.json", ["answer", "instance.extra_data.race"], "instance.id"),
        inside('{"adapter_spec": {"method": "multiple_choice_joint", "model": "m"}, "request_states": ['),
    ),
    "promptfoo": Kind(promptfoo, "results.jsonl", ["response.output", "metadata.race"], "metadata.person"),
    "promptfoo .json": Kind(
        *(promptfoo, "results.json", ["response.output", "metadata.race"], "metadata.person"),
        inside('{"evalId": "e", "results": {"version": 3, "prompts": [], "results": [', "]}}"),
    ),
    "openai": Kind(
        *(openai, "output.jsonl", [ANSWERS, "response.body.model"], "custom_id"),
        asked={"an expression": ([ANSWERS, "eval.model"], {"extract": "^(yes|no)"})},
    ),
    "openai-evals": Kind(evals, "events.jsonl", ["data.sampled", "data.race"], "sample_id"),
}


def timed(read: Any) -> float:
    started = time.process_time()  # of this process alone, whatever else the machine does
    read()
    return time.process_time() - started


def texts(path: Path) -> Iterator[str]:
    """The texts that a log consists of."""
    if path.suffix == ".eval":
        with zipfile.ZipFile(path) as file:
            yield from (file.read(member).decode() for member in file.infolist())
    elif path.suffix == ".jsonl":
        with path.open() as file:
            yield from file
    else:
        yield path.read_text()


def parsed(path: Path) -> None:
    for text in texts(path):
        json.loads(text)


def compared(path: Path, columns: list[str], asked: dict[str, Any]) -> tuple[float, float]:
    """The least times of the parser and of reading, by turns."""
    pairs = [
        (timed(lambda: parsed(path)), timed(lambda: fa.read_log(path, columns, **{"decision": columns[0], **asked}))) for _ in range(3)
    ]
    return min(alone for alone, _ in pairs), min(took for _, took in pairs)


def join(folder: Path, samples: int) -> str:
    """Write a CSV file with a row for each sample of a batch, and say how it is joined."""
    with (folder / "people.csv").open("w") as file:
        file.write("custom_id,race\n")
        file.writelines(f"s{number},{'bw'[number % 2]}\n" for number in range(samples))
    return f"{folder / 'people.csv'}:custom_id"


def main() -> None:
    samples = int(sys.argv[1]) if len(sys.argv) > 1 else 1_000_000
    for name in sys.argv[2:] or FORMATS:
        kind = FORMATS[name]
        for length, words in LENGTHS.items():
            with tempfile.TemporaryDirectory() as folder:
                path = Path(folder) / kind.name
                kind.write(path, kind.rows(samples, words))
                asked = {
                    "": (kind.columns, {}),
                    "a unit": ([*kind.columns, kind.unit], {"unit": [kind.unit]}),
                    **kind.asked,
                }
                if kind.rows is promptfoo:
                    del asked[""]  # which it needs
                if name == "openai":
                    joined = {"join": join(Path(folder), samples), "extract": "^(yes|no)"}
                    asked |= {"rows of a CSV": ([ANSWERS, "race"], joined)}
                for case, (columns, more) in asked.items():
                    alone, took = compared(path, columns, more)
                    size = path.stat().st_size / samples
                    print(
                        f"{name:<15} {length:<11} {size:7.0f} bytes {case:<23} {took:6.2f} s  {took / alone:5.2f} x the parser (at most 5)"
                    )
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "log.jsonl"
        lines(path, rows(samples, 1))
        tracemalloc.start()
        fa.read_log(path, ["answer", "doc.race"])
        print(f"memory without a unit: {tracemalloc.get_traced_memory()[1] / 1e6:.1f} MB at the most")


if __name__ == "__main__":
    main()
