"""Certificates of logs that were prepared before they were counted, and alterations of what they say of it, digests kept."""

from __future__ import annotations

import copy
import json
from collections.abc import Iterator
from pathlib import Path
from random import Random as Pick
from tempfile import TemporaryDirectory
from typing import Any

from certificate_changes import put, same

import fairaudit as fa

PREPARED = 20
"""Certificates that are altered."""

LEFT_OUT = "were left out; they are taken to be no different from the others"


def prepared(seed: int) -> dict[str, Any]:
    """The certificate of a small log with labels to merge, missing ones and ages, read in one of several ways."""
    pick = Pick(seed)
    rows = [(u, a, age) for u in ("yes", "no") for a in ("f", "F ", "m", "man", "n") for age in (20, 30, 50)]
    log: dict[str, list[Any]] = {"u": [], "a": [], "x": [], "n": []}
    for u, a, age in rows:
        for name, value in {"u": u, "a": a, "x": age, "n": pick.randint(3, 30)}.items():
            log[name].append(value)
    for u, a in (("", "m"), ("yes", ""), ("", ""), ("no", "f")):
        for name, value in {"u": u, "a": a, "x": 30, "n": pick.randint(1, 9)}.items():
            log[name].append(value)
    options: dict[str, Any] = {"missing": pick.choice(["drop", "group"])}
    if pick.random() < 0.6:
        options["fold_labels"] = True
    if pick.random() < 0.6:
        options["label_map"] = {"a": {"man": "m"}}
    context = {"context": "x", "bins": {"x": [25, 40]}} if pick.random() < 0.5 else {}
    confidence = "0.95" if pick.random() < 0.2 else None
    with TemporaryDirectory() as folder:
        path = Path(folder, "log.jsonl")
        path.write_text("".join(json.dumps(dict(zip(log, row, strict=True))) + "\n" for row in zip(*log.values(), strict=True)))
        made = fa.audit(path, decision="u", group="a", count="n", utility="yes", confidence=confidence, **context, **options)
    document: dict[str, Any] = json.loads(made.certificate.text)
    return document


def altered(document: dict[str, Any], pick: Pick) -> dict[str, Any] | None:
    """The same with another preparation, and with what claims then have to assume; nothing where it came out as it was."""
    own = copy.deepcopy(document["subject"]["preparation"])
    other = pick.choice([_without, _counted_otherwise, _merged_otherwise, _labels_moved, _added, _step_exchanged])(own, pick)
    if other is None or same(other, own):
        return None
    changed = put(json.dumps(document), ("subject", "preparation"), other)
    if not other:
        del changed["subject"]["preparation"]
    for claim in changed["claims"]:
        kept = [text for text in claim["assumptions"] if LEFT_OUT not in text]
        claim["assumptions"] = [*_assumed(other), *kept]
    return dict(changed)


def alterations(number: int) -> Iterator[dict[str, Any]]:
    """So many alterations, of certificates that are true as they are."""
    documents = [prepared(seed) for seed in range(PREPARED)]
    seed = 0
    while number > 0:
        seed += 1
        changed = altered(documents[seed % PREPARED], Pick(seed))
        if changed is not None:
            number -= 1
            yield changed


def _assumed(entries: list[Any]) -> list[str]:
    found = []
    for entry in entries:
        if entry.get("step") == "left out":
            said = (
                f"{entry['lines']} lines of the log could not be counted and were left out ({entry['reason']})"
                if "lines" in entry
                else f"{entry.get('decisions')} of {entry.get('of')} decisions have a missing label and were left out"
            )
            found.append(f"{said}; they are taken to be no different from the others")
    return found


def _without(entries: list[Any], pick: Pick) -> list[Any]:
    """Deleted, in all or in part."""
    return [] if pick.random() < 0.5 else [entry for entry in entries if pick.random() < 0.5]


def _amounts(value: Any, at: tuple[Any, ...] = ()) -> Iterator[tuple[Any, ...]]:
    if isinstance(value, dict):
        for key, item in value.items():
            yield from _amounts(item, (*at, key))
    elif isinstance(value, list):
        for i, item in enumerate(value):
            yield from _amounts(item, (*at, i))
    elif isinstance(value, str) and value.isdecimal():
        yield at


def _counted_otherwise(entries: list[Any], pick: Pick) -> list[Any] | None:
    places = [*_amounts(entries)]
    for place in pick.sample(places, min(len(places), pick.randint(1, 3))):
        holder = entries
        for step in place[:-1]:
            holder = holder[step]
        holder[place[-1]] = str(max(1, int(holder[place[-1]]) + pick.choice([-2, -1, 1, 100])))
    return entries if places else None


def _merged_otherwise(entries: list[Any], pick: Pick) -> list[Any] | None:
    merged = [entry for entry in entries if "from" in entry]
    if not merged:
        return None
    entry = pick.choice(merged)
    entry["from"] = sorted({*(entry["from"] if pick.random() < 0.7 else []), pick.choice(["woman", "M", "mann", "x"])})
    return entries


def _labels_moved(entries: list[Any], pick: Pick) -> list[Any] | None:
    labelled = [entry for entry in entries if "label" in entry]
    if not labelled:
        return None
    entry = pick.choice(labelled)
    if pick.random() < 0.5:
        entry["column"] = pick.choice(["u", "a", "x"])
    else:
        entry["label"] = pick.choice(["f", "m", "n", "yes", "no", "(missing)"])
    return entries


def _added(entries: list[Any], pick: Pick) -> list[Any]:
    steps = ["above", "above median", "intervals", "mapped", "folded", "left out", "level", "unknown"]
    more = pick.choice(
        [
            {"step": "mapped", "column": "a", "label": "n", "from": ["nobody"]},
            {"step": "folded", "column": "a", "label": "n", "from": ["N"]},
            {"step": "left out", "reason": "unreadable line", "lines": str(pick.randint(1, 9))},
        ]
    )
    return sorted([*entries, more], key=lambda entry: (steps.index(entry["step"]), entry.get("column", ""), entry.get("label", "")))


def _step_exchanged(entries: list[Any], pick: Pick) -> list[Any] | None:
    merged = [entry for entry in entries if "from" in entry]
    if not merged:
        return entries[::-1]
    entry = pick.choice(merged)
    entry["step"] = "mapped" if entry["step"] == "folded" else "folded"
    return entries
