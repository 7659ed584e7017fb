"""Two models of Inspect's mock asked the same: ``python two_model_runs.py FOLDER`` writes FIRST.eval and SECOND.eval, and their answers.

Run as a process of its own, since the library changes ``zipfile`` for everybody.
"""

from __future__ import annotations

import shutil
import sys
from pathlib import Path

FIRST, SECOND = "mockllm/first", "mockllm/second"
QUESTIONS = 96
RACES = ("black", "white")
TOPICS = ("home", "work", "study")


def race_of(question: int) -> str:
    return RACES[question % 2]


def topic_of(question: int) -> str:
    return TOPICS[question // 2 % 3]


def is_right(model: str, question: int) -> bool:
    """The first model errs with every sixth pair of people; the second one with three of four black people, and no white one."""
    pair = question // 2
    return pair % 6 != 5 if model == FIRST else race_of(question) == "white" or pair % 4 == 0


def make(folder: Path) -> None:
    from inspect_ai import Task
    from inspect_ai import eval as evaluate
    from inspect_ai.dataset import MemoryDataset, Sample
    from inspect_ai.model import GenerateConfig, ModelOutput, ModelUsage, get_model
    from inspect_ai.scorer import choice
    from inspect_ai.solver import multiple_choice

    def asked(left_out: int) -> MemoryDataset:
        return MemoryDataset(
            [
                Sample(
                    input=f"Applicant {question} asks for a loan.",
                    choices=["grant", "refuse"],
                    target="A",
                    id=question,
                    metadata={"person": {"race": race_of(question)}, "topic": topic_of(question)},
                )
                for question in range(QUESTIONS - left_out)
            ],
            name="loans",
        )

    def run(model: str, left_out: int = 0) -> None:
        def outcome(messages, tools, tool_choice, config):
            question = int(messages[-1].text.split("Applicant ")[1].split()[0])
            output = ModelOutput.from_content(model, f"ANSWER: {'A' if is_right(model, question) else 'B'}")
            output.usage = ModelUsage(input_tokens=1, output_tokens=1, total_tokens=2)
            return output

        task = Task(
            name="loans", dataset=asked(left_out), solver=multiple_choice(), scorer=choice(), config=GenerateConfig(temperature=0.7)
        )
        name = f"{model.removeprefix('mockllm/')}{'-short' if left_out else ''}"
        where = str(folder / f"logs-{name}")
        asker = get_model(model, custom_outputs=outcome, memoize=False)
        (log,) = evaluate(task, model=asker, log_dir=where, display="none")
        assert log.status == "success"
        shutil.move(log.location.removeprefix("file://"), folder / f"{name}.eval")

    run(FIRST)
    run(SECOND)
    run(SECOND, left_out=1)


if __name__ == "__main__":
    make(Path(sys.argv[1]))
