"""Certificates of evaluation logs, what their tables were counted from, and whether a changed one may still be true."""

from __future__ import annotations

import json
import random
from collections import Counter
from collections.abc import Iterator
from dataclasses import replace
from itertools import pairwise
from typing import Any

import tiers
from certificate_changes import other_values, places, put, same, still_true, strictly, strings

import fairaudit as fa
from fairaudit.tables.evaluations.samples import Evaluation
from fairaudit.tables.tally import Tally
from fairaudit.tables.values import names

LOST = ("refused", "unreadable", "truncated", "error")
STATED = ("format", "extract", "options", "join", "recipe", "where", "each", "epochs", "question", "unit", "drawn")
ROWS_OF_SAMPLE = {None: 1, "bbq": 2, "bbq-accuracy": 1}
QUESTIONS = "questions were drawn; epochs of a question count once"
ANSWERS = "the questions are fixed; the model's answers were drawn"
UNITS = "sampling units were drawn; samples of a unit count once"
SAMPLES = "samples were drawn, each of them by itself"
NOTHING = "nothing was drawn: the questions are fixed, and the model answers each of them in one way"


def log_of(rows: list[tuple[Any, ...]], columns: tuple[str, ...] = ("answer", "race", "topic"), **said: Any) -> Tally:
    """A log as its reader hands it over: rows with how often each occurs, and how it was read."""
    tally = Tally.of("run.eval", columns, rows)
    number = dict.fromkeys(("expected", "read", "counted"), tally.rows)
    known: dict[str, Any] = {"format": "inspect", "question": "id", **number}
    return replace(tally, evaluation=Evaluation(**{**known, **said}))


def drawn_log(seed: int, **said: Any) -> Tally:
    """A log of random answers, some of which decide nothing; of some cells every one may be lost."""
    draw = random.Random(tiers.fresh(seed))
    rows: Counter[tuple[str, str, str]] = Counter()
    for topic in ("age", "home", "work")[: draw.randint(1, 3)]:
        for race in ("a", "b", "c")[: draw.randint(2, 3)]:
            chances = [draw.random() for _ in LOST]
            for _ in range(draw.randint(1, 25)):
                lost = [name for name, chance in zip(LOST, chances, strict=True) if draw.random() < chance / 4]
                rows[lost[0] if lost else draw.choice("AB"), race, topic] += 1
    rows["A", "a", "age"] += 3
    rows["B", "b", "age"] += 3
    return log_of([(*row, count) for row, count in rows.items()], **said)


def audited(log: Tally, **options: Any) -> fa.Result:
    """The certificate of a log."""
    unit = names(options.pop("unit", None))
    assert log.evaluation is not None
    log = replace(log, evaluation=replace(log.evaluation, unit=unit))
    law = fa.Law.from_log(log, decision="answer", group="race", context="topic", unit=unit)
    return fa.certify(law, options.pop("utility", {"A": 1}), **options)


def counts_of(subject: Any) -> dict[tuple[tuple[str, ...], tuple[str, ...]], Counter[str]]:
    """How often each decision occurs in each cell of an embedded table."""
    header = subject["table"]["header"]
    found = {}
    for row in subject["table"]["rows"]:
        place = tuple(header["contexts"][row["context"]]), tuple(header["groups"][row["group"]])
        found[place] = Counter(dict(zip(header["decisions"], map(int, row["weights"]), strict=True)))
    return found


def truly_read(subject: Any, of_intervals: bool) -> bool:
    """Whether what is said of the log is well formed, adds up to the embedded table, and says nothing else of it."""
    said = subject["evaluation"]
    table = counts_of(subject)
    if not isinstance(said, dict) or not {"format", "epochs", "drawn", "errors", "samples", "answers", "cells"} <= {*said}:
        return False
    if {*said} - {*STATED, "errors", "samples", "answers", "cells", "unlabelled"}:
        return False
    texts = [said[key] for key in ("format", "extract", "join", "recipe", "each", "question") if key in said]
    units = said.get("unit", ["some"])
    where = said.get("where", [{"path": "p", "value": "v"}])
    if not isinstance(units, list) or not isinstance(where, list):
        return False
    if any(not isinstance(entry, dict) or {*entry} != {"path", "value"} for entry in where):
        return False
    options = said.get("options", ["a", "b"])
    if not isinstance(options, list) or not all(isinstance(option, str) for option in options) or not 1 < len(options) == len({*options}):
        return False
    occurring = {label for counts in table.values() for label, number in counts.items() if number}
    if "options" in said and "recipe" not in said and not occurring <= {*options, *LOST[: 4 if said.get("errors") == "bound" else 3]}:
        return False
    conditions = [value for entry in where for value in (entry["path"], entry["value"])]
    if not all(
        isinstance(text, str) and not any("\ud800" <= c <= "\udfff" for c in text) for text in (*texts, *units, *options, *conditions)
    ):
        return False
    if not all(texts) or not units or len({*units}) < len(units) or not where:
        return False
    if len({(entry["path"], entry["value"]) for entry in where}) < len(where):
        return False
    answers, samples, cells = said["answers"], said["samples"], said["cells"]
    if not isinstance(answers, dict) or {*answers} != {"read", *LOST} or not isinstance(cells, list):
        return False
    if not isinstance(samples, dict) or {*samples} != {"expected", "read", "counted", "rows"}:
        return False
    numbers = [*answers.values(), *(v for k, v in samples.items() if k != "expected" or v is not None), said["epochs"]]
    numbers += [said["unlabelled"]] if "unlabelled" in said else []
    if any(type(number) is not int or not 0 <= number < 10**18 for number in numbers) or not said["epochs"]:
        return False
    if (said["epochs"] > 1 and "question" not in said) or ("each" in said and "unit" not in said):
        return False
    if "unit" in said:
        allowed = [ANSWERS, NOTHING, QUESTIONS if said.get("question") in said["unit"] else UNITS]
    elif said.get("question") in ("race", "topic"):
        allowed = [ANSWERS, NOTHING]
    else:
        allowed = [] if said["epochs"] > 1 else [QUESTIONS if "question" in said else SAMPLES]
    if said["drawn"] not in allowed or (of_intervals and said["drawn"] == NOTHING) or said["errors"] not in ("refuse", "drop", "bound"):
        return False
    kept = LOST if said["errors"] == "bound" else LOST[:3]
    total = sum(table.values(), Counter())
    wanted = {name: total[name] for name in kept}
    if {name: answers[name] for name in kept} != wanted or answers["read"] != total.total() - sum(wanted.values()):
        return False
    dropped = answers["error"] if said["errors"] == "drop" else 0
    if said["errors"] == "refuse" and answers["error"]:
        return False
    listed = {}
    for entry in cells:
        if not isinstance(entry, dict) or not {"context", "group", "read"} < {*entry} or {*entry} - {"context", "group", "read", *LOST}:
            return False
        labels = [entry["context"], [] if entry["group"] is None else entry["group"]]
        if any(not isinstance(part, list) or any(not isinstance(label, str) for label in part) for part in labels):
            return False
        if len(labels[0]) != 1 or (entry["group"] is not None and len(labels[1]) != 1):
            return False
        own = {name: entry[name] for name in ("read", *LOST) if name in entry}
        if any(type(number) is not int or number < (name != "read") for name, number in own.items()):
            return False
        listed[tuple(labels[0]), tuple(labels[1])] = own
    if list(listed) != sorted(listed) or len(listed) < len(cells):
        return False
    beside = 0
    for place, own in listed.items():
        counts = table.get(place, Counter())
        beside += own.get("error", 0) if said["errors"] == "drop" else 0
        if {name: own.get(name, 0) for name in kept} != {name: counts[name] for name in kept}:
            return False
        if own["read"] != counts.total() - sum(counts[name] for name in kept):
            return False
    if any(sum(counts[name] for name in kept) and place not in listed for place, counts in table.items()):
        return False
    unlabelled = said.get("unlabelled", 0)
    if ("unlabelled" in said and not unlabelled) or beside + unlabelled != dropped:
        return False
    if samples["rows"] != sum(answers.values()) or samples["counted"] > samples["read"]:
        return False
    if samples["expected"] is not None and samples["expected"] < samples["read"]:
        return False
    recipe = said["recipe"].partition(":")[0] if "recipe" in said else None
    if recipe not in ROWS_OF_SAMPLE:
        return False
    made = samples["counted"] * ROWS_OF_SAMPLE[recipe]
    if samples["rows"] < made or (samples["rows"] > made and "each" not in said):
        return False
    return "where" in said or samples["read"] == samples["counted"]


def assumed(said: Any) -> list[str]:
    """What every claim has to list of the answers that were left out."""
    lost = said["answers"]["error"] if said["errors"] == "drop" else 0
    absent = 0 if said["samples"]["expected"] is None else said["samples"]["expected"] - said["samples"]["read"]
    texts = [f"{lost} of {said['samples']['rows']} rows of the evaluation log ended in an error"] * bool(lost)
    texts += [f"{absent} of {said['samples']['expected']} samples are not in the evaluation log"] * bool(absent)
    return [f"{text} and were left out; they are taken to be no different from the others" for text in texts]


def may_be_true(original: Any, mutant: bytes) -> bool:
    """Whether a certificate in which what is said of its log was changed is true of its table, so far as the table can say."""
    try:
        changed = strictly(mutant)
    except ValueError:
        return False
    if not isinstance(changed, dict) or not isinstance(changed.get("subject"), dict):
        return False
    if "evaluation" not in changed["subject"]:  # which says nothing of a log, and of no answer that was left out
        left_out = assumed(original["subject"]["evaluation"])
        subject = {key: value for key, value in original["subject"].items() if key != "evaluation"}
        return not left_out and still_true(original | {"subject": subject}, mutant)
    if not truly_read(changed["subject"], "intervals" in changed) or assumed(changed["subject"]["evaluation"]) != assumed(
        original["subject"]["evaluation"]
    ):
        return False
    ours, theirs = (document["subject"]["evaluation"] for document in (original, changed))
    if ("unit" in ours) != ("unit" in theirs) and "intervals" in changed:  # units are in the assumptions, and in intervals
        return False
    put_back = json.dumps(changed | {"subject": changed["subject"] | {"evaluation": ours}}).encode()
    return still_true(original, put_back)


def changed_evaluations(document: Any, seed: int, amount: int) -> Iterator[bytes]:
    """Change what is said of the log at random: one to three values, keys or lists of it, anything in the place of anything."""
    draw, pool = (
        random.Random(tiers.fresh(seed)),
        [*strings(document)[:12], QUESTIONS, ANSWERS, UNITS, SAMPLES, NOTHING, "drop", "bound", "refuse"],
    )
    text = json.dumps(document)
    spots = [path for path, _ in places(document["subject"]["evaluation"])]
    for _ in range(amount):
        changed = document
        for _ in range(draw.choice((1, 1, 2, 3))):
            path = ("subject", "evaluation", *draw.choice(spots))
            try:
                value: Any = changed
                for step in path:
                    value = value[step]
                changed = put(json.dumps(changed) if changed is not document else text, path, draw.choice(other_values(value, pool)))
            except (KeyError, IndexError, TypeError):
                continue
        if not same(changed["subject"].get("evaluation"), document["subject"]["evaluation"]):
            yield json.dumps(changed).encode()


def traded_counts(document: Any) -> Iterator[bytes]:
    """Move answers from one kind to another and from one cell to another, so that sums stay what they are."""
    text = json.dumps(document)
    said = document["subject"]["evaluation"]
    spots = [("answers",), *(("cells", i) for i in range(len(said["cells"])))]
    for spot in spots:
        held = said["answers"] if spot == ("answers",) else said["cells"][spot[1]]
        for one in ("read", *LOST):
            for other in ("read", *LOST):
                if one != other and held.get(one):
                    moved = {**held, one: held[one] - 1, other: held.get(other, 0) + 1}
                    if spot != ("answers",):
                        moved = {key: value for key, value in moved.items() if value or key not in LOST}
                    yield json.dumps(put(text, ("subject", "evaluation", *spot), moved)).encode()
    for name in LOST:
        cells = [i for i, cell in enumerate(said["cells"]) if name in cell]
        for i, j in pairwise(cells):
            changed = json.loads(text)
            one, other = (changed["subject"]["evaluation"]["cells"][k] for k in (i, j))
            one[name], other[name] = other[name] + 1, one[name] + 1
            yield json.dumps(changed).encode()
    whole = {**said, "samples": {**said["samples"], "expected": None}}
    yield json.dumps(put(text, ("subject", "evaluation"), whole)).encode()
    nothing = {**said, "answers": {**dict.fromkeys(said["answers"], 0), "read": said["samples"]["rows"]}, "cells": []}
    yield json.dumps(put(text, ("subject", "evaluation"), nothing)).encode()
    without = json.loads(text)
    del without["subject"]["evaluation"]
    yield json.dumps(without).encode()
