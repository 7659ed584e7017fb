"""The program of proofs/checker/Chance.v, which is proved right, and the checker decide alike of boxes of ends of means."""

from __future__ import annotations

import random
from fractions import Fraction
from pathlib import Path
from typing import Any

import pytest
import tiers
from built_proofs import make_proofs, run_coq
from plain_certificates import checker

from fairaudit.inference.cells import Cell
from fairaudit.inference.comparisons import Comparison
from fairaudit.inference.ratio_intervals import ratio_interval

F = Fraction
CASES = 1000 if tiers.FULL else 10
"""FAIRAUDIT_FULL=1 pytest tests/whole/test_chance.py: 1,000 boxes and four alterations of each"""
TINY = F(1, 10**9)

Box = dict[str, Any]


@pytest.fixture(scope="module")
def program() -> Path:
    """Compile the program with all proofs; their folder."""
    return make_proofs("theorems", "the program was not run")


def box_of(pick: random.Random) -> Box:
    """A box of two to six cells in blocks, as the package writes it."""
    blocks = [[pick.choice([0, 1, 3, pick.randint(2, 40)]) for _ in range(pick.randint(2, 3))] for _ in range(pick.randint(1, 2))]
    worth = pick.choice([F(1), F(5, 3)])
    cells = [Cell(n, worth * k, worth**2 * k, F(0), worth, True) for block in blocks for n in block for k in [pick.randint(0, n)]]
    numbers = iter(range(len(cells)))
    comparison = Comparison(tuple(cells), tuple(tuple(((next(numbers), F(1)),) for _ in block) for block in blocks))
    confidence, independent, ends = pick.choice(["0.5", "0.9", "0.99"]), pick.random() < 0.5, pick.choice(["together", "each"])
    found = ratio_interval(comparison, confidence, independent=independent, ends=ends)
    evidence = found.evidence
    return {
        "blocks": [len(block) for block in blocks],
        "cells": [(cell.draws, int(cell.total / worth)) for cell in cells],
        "worth": worth,
        "confidence": F(confidence),
        "each": ends == "each",
        "independent": independent,
        "levels": [F(evidence["levels"][side]) for side in ("upper", "lower")],
        "upper": [[F(end) for end in two] for two in evidence["upper"]],
        "lower": [[F(end) for end in two] for two in evidence["lower"]],
        "pair": evidence["pair"],
        "ratio": [None if end == float("inf") else F(end) for end in (found.lower, found.upper)],
    }


def altered(pick: random.Random, box: Box) -> Box:
    """Change one number, most of the time by little."""
    box = {key: [*map(list, value)] if key in ("upper", "lower") else value for key, value in box.items()}
    factor = pick.choice([1 + TINY, 1 - TINY, F(1, 2), F(2), F(0)])
    what = pick.choice(["upper", "lower", "upper", "lower", "levels", "confidence", "ratio", "pair", "independent", "cells"])
    if what in ("upper", "lower"):
        place, side = pick.randrange(len(box[what])), pick.randrange(2)
        box[what][place][side] *= factor
    elif what == "levels":
        sides = pick.choice([(0,), (1,), (0, 1)])
        box["levels"] = [level * factor if i in sides else level for i, level in enumerate(box["levels"])]
    elif what == "confidence":
        box["confidence"] = min(box["confidence"] * (1 + TINY), 1 - TINY)
    elif what == "ratio":
        side = pick.randrange(2)
        box["ratio"] = [end * factor if i == side and end is not None else end for i, end in enumerate(box["ratio"])]
    elif what == "pair":
        box["pair"] = pick.choice([None, [0, 0, 1], [0, 1, 0], [0, 1, 1], [5, 0, 1]])
    elif what == "independent":
        box["independent"] = not box["independent"]
    else:
        place, (n, k) = max(enumerate(box["cells"]), key=lambda cell: cell[1])
        box["cells"] = [(n, max(0, k - 1)) if i == place else cell for i, cell in enumerate(box["cells"])]
    return box


def rational(number: Fraction) -> tuple[int, int]:
    return number.numerator, number.denominator


def by_checker(box: Box) -> bool:
    """What fairaudit.checker decides."""
    worth, n = box["worth"], len(box["cells"])
    unit = worth.denominator
    high = int(worth * unit)
    samples = [checker.tails.Sample(m, k * high, k * high**2, 0, high, unit, True) for m, k in box["cells"]]
    numbers = iter(range(n))
    blocks: list[Any] = [[({next(numbers): 1}, 1) for _ in range(size)] for size in box["blocks"]]
    ends = [[(rational(a), rational(b)) for a, b in box[side]] for side in ("upper", "lower")]
    evidence = checker.intervals.BoxEvidence(tuple(box["levels"]), *ends, None if box["pair"] is None else tuple(box["pair"]))
    infinity = checker.rationals.INFINITY
    low, most = (infinity if end is None else rational(end) for end in box["ratio"])
    interval = checker.intervals.Interval(
        "local", rational(box["confidence"]), box["each"], "", box["independent"], "hoeffding-kl", None, None, None, (low, most), evidence
    )
    said = [sample.informative for sample in samples]
    starts = [sum(box["blocks"][:i]) for i in range(len(box["blocks"]))]
    spanned = max(min(2, sum(said[start : start + size])) for start, size in zip(starts, box["blocks"], strict=True))
    if min(low[0] - low[1], most[0] - most[1]) < 0:
        return False  # no ratio is less than 1
    try:
        checker.regions.prove_by_box(interval, evidence, checker.samples.Comparison(samples, blocks, False, []), sum(said), spanned)
    except checker.intervals.Unproven:
        return False
    return True


def in_coq(number: Fraction | None) -> str:
    return "None" if number is None else f"(Some {quotient(number)})"


def quotient(number: Fraction) -> str:
    return f"(Qmake ({number.numerator}) {number.denominator})"


def boolean(value: bool) -> str:
    return "true" if value else "false"


def applied(box: Box) -> str:
    """The program, applied to a box; -1 is the number of no cell."""
    starts = [sum(box["blocks"][:i]) for i in range(len(box["blocks"]))]
    of_block = [b for b, size in enumerate(box["blocks"]) for _ in range(size)]
    samples = "; ".join(f"Sample {b} {n} {k} {quotient(box['worth'])}" for b, (n, k) in zip(of_block, box["cells"], strict=True))
    upper, lower = ("; ".join(f"({quotient(a)}, {quotient(b)})" for a, b in box[side]) for side in ("upper", "lower"))
    pair = "None"
    if box["pair"] is not None:
        block, *two = box["pair"]
        inside = block < len(starts) and max(two) < box["blocks"][block]
        higher, less = (starts[block] + i for i in two) if inside else (-1, -1)
        pair = f"(Some (({higher})%Z, ({less})%Z))"
    flags = f"{boolean(box['each'])} {boolean(box['independent'])}"
    levels = " ".join(map(quotient, box["levels"]))
    ends = " ".join(map(in_coq, box["ratio"]))
    interval = f"(Interval {quotient(box['confidence'])} {flags} {levels} [{upper}] [{lower}] {pair} {ends})"
    return f"(let ss := [{samples}] in let i := {interval} in andb (in_proportion i ss) (box_accepted i ss))"


def by_program(program: Path, folder: Path, boxes: list[Box]) -> list[bool]:
    """What the program decides, computed by Coq itself."""
    lines = ["From Coq Require Import ZArith QArith List.", "From FairauditChecker Require Import Chance.", "Import ListNotations."]
    lines += ["Local Open Scope Z_scope.", *(f"Eval vm_compute in {applied(box)}." for box in boxes)]
    file = folder / "boxes.v"
    file.write_text("\n".join(lines) + "\n", "utf-8")
    run = run_coq(program, file)
    assert run.returncode == 0, run.stderr[-2000:]
    return [line.strip() == "= true" for line in run.stdout.splitlines() if line.strip().startswith("= ")]


def test_equal_verdicts_on_boxes_and_altered_ones(program: Path, tmp_path: Path) -> None:
    pick = random.Random(26)
    true = [box_of(pick) for _ in range(CASES)]
    boxes = true + [altered(pick, box) for box in true for _ in range(4)]
    expected = [by_checker(box) for box in boxes]
    assert all(expected[:CASES])
    assert CASES // 2 < sum(expected[CASES:]) < 4 * CASES
    found = by_program(program, tmp_path, boxes)
    assert len(found) == len(boxes)
    different = [(box, one) for box, one, other in zip(boxes, expected, found, strict=True) if one is not other]
    assert different == []
