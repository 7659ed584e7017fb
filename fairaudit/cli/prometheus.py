"""The figures of a monitor as a Prometheus text-file collector reads them."""

from __future__ import annotations

from pathlib import Path
from typing import Any

__all__ = ["write_prometheus"]


def write_prometheus(path: str, entry: dict[str, Any]) -> None:
    """Write the figures in the Prometheus text format, the whole file at once."""
    from fairaudit.files import write_atomically

    lines = []

    def metric(name: str, kind: str, help_text: str, samples: list[tuple[str, Any]]) -> None:
        lines.append(f"# HELP fairaudit_{name} {help_text}")
        lines.append(f"# TYPE fairaudit_{name} {kind}")
        for labels, value in samples:
            lines.append(f"fairaudit_{name}{labels} {'+Inf' if value == float('inf') else value}")

    metric("decisions_total", "counter", "Decisions that count.", [("", entry["decisions"])])
    metric("dead_letters_total", "counter", "Lines that could not be counted.", [("", entry["dead_letters"])])
    metric("repeats_total", "counter", "Decisions that were seen before.", [("", entry["repeats"])])
    ends = [
        (f'{{quantity="{q}",end="{side}"}}', value)
        for q, pair in entry["ratio"].items()
        for side, value in zip(("lower", "upper"), pair, strict=True)
    ]
    metric("ratio", "gauge", "Ends of the ratio R at every moment.", ends)
    ranks = {"none": 0, "within": 0, "exceeds": 1, "inconclusive": 3, "changed": 4}
    metric(
        "verdict",
        "gauge",
        "0 within, 1 exceeds, 3 inconclusive, 4 changed.",
        [(f'{{target="{t["target"]}"}}', ranks[t["verdict"]]) for t in entry["targets"]],
    )
    raised = [alarm for alarm in entry["alarms"] if "target" in alarm]
    metric("alarms_total", "counter", "Targets that were exceeded at some moment.", [("", len(raised))])
    changed = [(f'{{quantity="{q}"}}', int(any(a.get("changed") == q for a in entry["alarms"]))) for q in ("local", "global")]
    metric("changed", "gauge", "1 if a window or a detector contradicted the whole stream.", changed)
    write_atomically(Path(path), [("\n".join(lines) + "\n").encode("utf-8")])
