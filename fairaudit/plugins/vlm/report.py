"""What an experiment leaves behind: tables, certificates, one file of figures, and a text."""

from __future__ import annotations

import json
import re
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from math import ceil, floor, inf
from pathlib import Path
from typing import Any

from fairaudit.errors import InputError
from fairaudit.exact.rationals import number
from fairaudit.files import csv_text, write_atomically
from fairaudit.plugins.vlm.analyse import TABLE, Finding, Table, certify, logarithm, questions, readings, tables
from fairaudit.plugins.vlm.answers import FAULT, OPEN, read_kept
from fairaudit.plugins.vlm.experiment import Experiment, Setting
from fairaudit.plugins.vlm.journal import Journal
from fairaudit.words import approximate, columns_of, harmless, plain

__all__ = ["Found", "ceiling", "certify_all", "figures", "filled_text", "said", "worsened"]


@dataclass(frozen=True)
class Found:
    """Everything about an experiment."""

    experiment: Experiment
    findings: tuple[tuple[str, Table, Finding], ...]  # model, table and finding, in order
    written: tuple[Path, ...]
    silent: tuple[str, ...] = ()  # models that were asked and gave no answer, of which nothing is said

    @property
    def verdict(self) -> str:
        """Of all findings: the first of exceeds, inconclusive, depends (on what answers meant) and within that one of them has."""
        found = {judged(table, finding) for _, table, finding in self.findings}
        return next((v for v in ("exceeds", "inconclusive", "depends", "within") if v in found), "none")


def judged(table: Table, finding: Finding) -> str:
    """The verdict on a finding: of a run that is not complete at most inconclusive."""
    return "inconclusive" if finding.result.verdict == "within" and not table.complete else finding.result.verdict


def _answered(table: Table) -> list[dict[str, Any]]:
    """For each cell what was shown, how many answers are expected (or 1, where they are probabilities), and how many there are."""
    cells = ((context, slots, sum(row.values()), row.get(FAULT, 0) + row.get(OPEN, 0)) for (context, slots), row in table.rows.items())
    return [
        {"context": context, "slots": [*map(list, slots)], "expected": number(whole), "answered": number(whole - lost)}
        for context, slots, whole, lost in cells
    ]


def ceiling(found: Found, question: str, setting: Setting) -> Fraction | float:
    """What bounds the local ratio of every population behind a filter: e^ε (T2; of a person T10), or T13 where g has a floor."""
    held = [f for _, _, f in found.findings if (f.question, f.setting) == (question, setting)]
    return min(min(f.exp_epsilon, f.bounds.get("T13", inf)) for f in held)


def worsened(found: Found, model: str, finding: Finding) -> list[str]:
    """Which ratios of a table are greater behind its filter than without one; not of draws, which differ by chance, nor of a position."""
    if finding.drawn or finding.question == "position":
        return []
    bare = [f for m, _, f in found.findings if (m, f.question, f.setting.filtered, f.drawn) == (model, finding.question, False, False)]
    return [q for q, (low, _) in finding.meanings.items() if bare and low > bare[0].meanings[q][1]]


def certify_all(
    experiment: Experiment, journal: Journal, models: Sequence[str], folder: Path, *, confidence: Any, targets: Mapping[str, str] | None
) -> Found:
    """Read the answers of models, answer every question at every setting, and write tables and certificates.

    Targets are judged on the person and the slot, not on the position.
    """
    if not models:
        raise InputError(
            f"the journal {journal.path} has no answers of that model; its models: {', '.join(journal.models()) or 'none yet'}"
        )
    read = {model: tables(experiment, journal, model) for model in models}
    stems = _stems(journal.models())
    silent = tuple(model for model, own in read.items() if all(table.kinds.keys() <= {OPEN, FAULT} for table in own))
    if len(silent) == len(models):
        raise InputError(f"{' and '.join(silent)} {'has' if len(silent) == 1 else 'have'} no answers yet; run the experiment first")
    findings: list[tuple[str, Table, Finding]] = []
    names: list[str] = []
    for model in (model for model in models if model not in silent):
        for table in read[model]:
            for setting in experiment.settings if table.setting == TABLE else [experiment.settings[table.setting]]:
                numbered = "" if len(experiment.settings) == 1 else f".{experiment.settings.index(setting) + 1:02d}"
                for question in questions(experiment):
                    chosen = {} if question == "position" else targets
                    finding = certify(experiment, table, setting, question, confidence=confidence, targets=chosen)
                    findings.append((model, table, finding))
                    drawn = ".drawn" if finding.drawn and experiment.design == "both" else ""
                    names.append(f"{stems[model]}.{question}{drawn}{numbered}.certificate.json")
    written = [
        path
        for model in dict.fromkeys(model for model, *_ in findings)
        for path in _exports(experiment, journal, model, read[model], folder / stems[model])
    ]
    for name, (_, _, finding) in zip(names, findings, strict=True):
        written += finding.result.certificate.save(folder / name)
    found = Found(experiment, tuple(findings), (*written, folder / "results.json"), silent)
    write_atomically(found.written[-1], [json.dumps(figures(found), ensure_ascii=True, indent=1).encode() + b"\n"])
    return found


def _stems(models: Sequence[str]) -> dict[str, str]:
    """What names of files begin with: the name of a decision maker, with where it is asked if another one has the same name."""
    short = [_spelled(re.sub(r" at https?://\S+$| \([a-z-]+\)$", "", model)) for model in models]
    stems: dict[str, str] = {}
    for model, name in zip(models, short, strict=True):
        stem = name if name and short.count(name) == 1 else _spelled(model)
        stems[model] = stem if stem not in stems.values() else f"{stem}-{len(stems) + 1}"
    return stems


def _spelled(name: str) -> str:
    return re.sub(r"[^A-Za-z0-9._-]+", "-", name).strip("-")


def said(found: Found) -> str:
    """What was found, as text."""
    asked, models = questions(found.experiment), dict.fromkeys(model for model, _, _ in found.findings)
    groups: dict[tuple[str, str], list[tuple[Table, Finding]]] = {(model, question): [] for model in models for question in asked}
    for model, table, finding in found.findings:
        groups[model, finding.question].append((table, finding))
    return filled_text(
        "certify",
        experiment=found.experiment,
        targets=dict.fromkeys(target.text for _, _, finding in found.findings for target in finding.result.targets),
        groups={key: rows for key, rows in groups.items() if rows},
        questions=asked,
        lines=_lines_of,
        sparse=_sparse,
        notes=lambda model, finding: _notes(found, model, finding),
        odd=lambda table: {kind: n for kind, n in sorted(table.kinds.items()) if kind not in ("choice", "probabilities")},
        written=found.written,
    )


def filled_text(name: str, **values: Any) -> str:
    """Fill in one of the texts for people; whatever is data in it steers no terminal."""
    from jinja2 import Environment, FileSystemLoader, StrictUndefined

    environment = Environment(  # noqa: S701
        loader=FileSystemLoader(Path(__file__).with_name("texts")),
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
        finalize=lambda value: plain(str(value)),
    )
    environment.filters["counts"] = lambda found: ", ".join(f"{n} {name}" for name, n in found.items())
    return environment.get_template(f"{name}.txt").render(values).rstrip("\n")


def _notes(found: Found, model: str, finding: Finding) -> list[str]:
    """What a figure shows that may surprise: draws above a bound, and a filter that makes things worse."""
    names = {"local": "L", "global": "L̄"}
    notes = [f"{names[quantity]} of these answers is greater than without a filter" for quantity in worsened(found, model, finding)]
    limit, lowest = ceiling(found, finding.question, finding.setting), finding.interval.get("local", (Fraction(1), inf))[0]
    if finding.drawn and finding.meanings["local"][0] > limit:
        chance = "as few draws may be: the interval reaches below it"
        odd = "and so is the interval: rare by chance; are the answers independent, and is it this filter?"
        bound = f"{_log(limit, ceil)}, which holds for what is drawn from and not for draws"
        notes.append(f"L of the draws is above the bound {bound}, {chance if lowest <= limit else odd}")
    return notes


def _sparse(table: Table) -> str:
    """How many answers there are, in all and in the cell with the fewest."""
    cells = _answered(table)
    least = min(cells, key=lambda cell: Fraction(cell["answered"]) / Fraction(cell["expected"]))
    expected, answered = (sum(Fraction(cell[name]) for cell in cells) for name in ("expected", "answered"))
    where = " | ".join(" ".join(profile) for profile in least["slots"])
    some = f"{least['answered']} of {least['expected']} of {least['context']} with {where}"
    return f"{answered} of {expected} answers are there, {some}"


HEADS = (("", "filter"), ("", "ε of A"), ("L in", "table"), ("", "L, interval"), ("L̄ in", "table"), ("bound", "(table)"), ("", "verdict"))
LEFT = (0, len(HEADS) - 1)  # the columns of texts


def _lines_of(rows: Sequence[tuple[Table, Finding]]) -> list[str]:
    """Two lines of headings and one for each finding, in columns that are as wide as what stands in them."""
    lines = [*zip(*HEADS, strict=True), *(_cells(table, finding) for table, finding in rows)]
    widths = [max(map(columns_of, column)) for column in zip(*lines, strict=True)]

    def cell(number: int, text: str) -> str:
        blank = " " * (widths[number] - columns_of(text))
        return text + blank if number in LEFT else blank + text

    return ["  ".join(cell(number, text) for number, text in enumerate(line)).rstrip() for line in lines]


def _cells(table: Table, finding: Finding) -> tuple[str, ...]:
    setting = finding.setting
    parts = [] if setting.keep == 1 else [f"keep {approximate(setting.keep)}"]
    parts += [] if setting.context_keep == 1 else [f"context {approximate(setting.context_keep)}"]
    name = (", ".join(parts) or "none") + (", drawn" if finding.drawn else "")
    low, high = finding.meanings["local"]
    local = _log(low) if low == high else f"{_log(low)}–{_log(high)}"
    wide, whole = finding.interval.get("local"), finding.meanings.get("global")
    interval = f"{_log(wide[0], floor)} to {_log(wide[1], ceil)}" if wide else "-"
    overall = "-" if whole is None else _log(whole[0]) if whole[0] == whole[1] else f"{_log(whole[0])}–{_log(whole[1])}"
    own = {name: value for name, value in finding.bounds.items() if name in ("T3", "T4", "T12") and setting.filtered}
    bound = min(own.items(), key=lambda entry: entry[1], default=("", inf))
    best = f"{_log(bound[1], ceil)} {bound[0]}" if bound[1] < inf else "-"
    verdict = judged(table, finding) if finding.result.targets else "-"
    return name, _log(finding.exp_epsilon), local, interval, overall, best, verdict


def _log(value: Fraction | float, rounding: Callable[[float], int] = round) -> str:
    """Three decimals of a logarithm, towards the outside for the ends of an interval."""
    found = logarithm(value)
    return "infinite" if found == inf else f"{rounding(found * 1000) / 1000:.3f}"


def _exports(experiment: Experiment, journal: Journal, model: str, read: Sequence[Table], stem: Path) -> Iterator[Path]:
    """Counts for `fairaudit certify`, one row per answer with the stated reason, and the same as JSON lines with the raw answer."""
    slots = [f"{option} {name}" for option in experiment.options for name in experiment.attributes]
    for table in read:
        name = f"{stem.name}.counts{'' if table.setting < 0 else f'.{table.setting + 1:02d}'}.csv"
        value = "count" if table.sampled else "probability"
        rows: list[list[Any]] = [[experiment.context_column, *slots, "decision", value]]
        for (context, shown), weights in table.rows.items():
            for decision, weight in weights.items():
                rows.append([context, *sum(shown, ()), decision, int(weight) if table.sampled else str(weight)])
        yield _write(stem.with_name(name), rows)
    log: list[list[Any]] = [["setting", experiment.context_column, *slots, "trial", "decision", "kind", "reason"]]
    for draw, reading in readings(experiment, journal, model):
        cells = [draw.setting + 1, draw.shown_context, *sum(draw.shown_slots, ()), draw.trial]
        log.append([*cells, reading.decision, reading.kind, harmless(reading.reason)])
    yield _write(stem.with_name(f"{stem.name}.answers.csv"), log)
    lines = stem.with_name(f"{stem.name}.answers.jsonl")
    write_atomically(lines, _lines(experiment, journal, model))
    yield lines


def _lines(experiment: Experiment, journal: Journal, model: str) -> Iterator[bytes]:
    for answer in journal.answers(model):
        draw, reading = answer.draw, read_kept(experiment, answer)
        text, tokens = answer.body.decode("utf-8", "backslashreplace"), [answer.input_tokens, answer.output_tokens]
        came = {"status": answer.status, "content_type": answer.content_type, "body": text, "tokens": tokens}
        entry = draw.row | vars(reading) | came | {"setting": draw.setting + 1}
        yield json.dumps(entry, ensure_ascii=True, default=number).encode() + b"\n"


def _write(path: Path, rows: Sequence[Sequence[Any]]) -> Path:
    write_atomically(path, [csv_text(rows).encode("utf-8", "backslashreplace")])
    return path


def figures(found: Found) -> dict[str, Any]:
    """All figures, as ``results.json`` holds them."""
    return {
        "experiment": found.experiment.title,
        "digest": found.experiment.digest,
        "verdict": found.verdict,
        "left_out": list(found.silent),
        "findings": [_entry(model, table, finding) for model, table, finding in found.findings],
    }


def _entry(model: str, table: Table, finding: Finding) -> dict[str, Any]:
    def both(ends: Mapping[str, tuple[Fraction | float, Fraction | float]]) -> dict[str, list[str]]:
        return {quantity: [number(low), number(high)] for quantity, (low, high) in ends.items()}

    setting = finding.setting
    return {
        "model": model,
        "question": finding.question,
        "design": "end-to-end" if finding.drawn else "table",
        "keep_probability": number(setting.keep),
        "context_keep_probability": number(setting.context_keep),
        "odds_of_truth": None if setting.keep == 1 else number(setting.keep / (1 - setting.keep)),
        "exp_epsilon": number(finding.exp_epsilon),
        "complete": table.complete,
        "kinds": dict(table.kinds),
        "note": table.note,
        "table": both(finding.meanings),
        "interval": both(finding.interval),
        "bounds": {name: number(value) for name, value in finding.bounds.items()},
        "targets": [
            {
                "target": f"max_{target.quantity}_{target.unit}",
                "limit": number(target.limit),
                "readings": target.readings,
                "verdict": target.verdict,
            }
            for target in finding.result.targets
        ],
        "verdict": judged(table, finding),
        "cells": _answered(table),
    }
