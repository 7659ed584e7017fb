"""Decisions that are missing may have been any: missing="undecided" bounds the ratio whatever they were, for every known group."""

from __future__ import annotations

import json
import random
from collections import Counter
from fractions import Fraction
from pathlib import Path
from typing import Any

import pytest
from certificate_kinds import outcome

import fairaudit as fa
from fairaudit.cli import main


def drawn(seed: int) -> list[tuple[str, str]]:
    pick = random.Random(seed)
    rows = [(d, g) for d in ("yes", "no", "yes") for g in "fm"]
    return rows + [(pick.choice(["yes", "no", "yes", "no", ""]), pick.choice("fm")) for _ in range(40)]


def ends(rows: list[tuple[str, str]]) -> tuple[Fraction, Fraction]:
    """The least and the greatest ratio of two rates, each of which is anything from no missing decision a yes to all of them."""
    counts = Counter(rows)
    of = {g: sum(n for (_, group), n in counts.items() if group == g) for g in "fm"}
    low = {g: Fraction(counts["yes", g], of[g]) for g in "fm"}
    high = {g: Fraction(counts["yes", g] + counts["", g], of[g]) for g in "fm"}
    apart = [low["f"] / high["m"], low["m"] / high["f"]]
    return max(Fraction(1), *apart), max(high["f"] / low["m"], high["m"] / low["f"])


@pytest.mark.parametrize("seed", range(8))
def test_the_ends_are_those_of_all_meanings(seed: int) -> None:
    rows = drawn(seed)
    log = {"d": [d for d, _ in rows], "g": [g for _, g in rows]}
    made = fa.audit(log, decision="d", group="g", utility="yes", missing="undecided", confidence=None)
    assert made.undecided is not None and made.undecided.decisions == ("(missing)",)
    least, greatest = ends(rows)
    assert (made.whatever[0].least, made.whatever[0].greatest) == (least, greatest)
    document = json.loads(made.certificate.text)
    assert outcome(made.certificate.text.encode()) == "true"
    missing = str(sum(not d for d, _ in rows))
    assert document["subject"]["preparation"] == [{"step": "level", "column": "d", "label": "(missing)", "decisions": missing}]


@pytest.mark.parametrize("reader", ["csv", "jsonl", "parquet", "counts"])
def test_every_reader_bounds_them(reader: str, tmp_path: Path) -> None:
    import pandas as pd

    rows = drawn(3)
    frame = pd.DataFrame(rows, columns=["d", "g"])
    path = tmp_path / f"log.{'csv' if reader == 'counts' else reader}"
    count: dict[str, Any] = {}
    if reader == "counts":
        counted = Counter(rows)
        frame, count = pd.DataFrame([(*key, n) for key, n in counted.items()], columns=["d", "g", "n"]), {"count": "n"}
    if reader == "jsonl":
        frame.to_json(path, orient="records", lines=True)
    elif reader == "parquet":
        frame.to_parquet(path)
    else:
        frame.to_csv(path, index=False)
    made = fa.audit(path, decision="d", group="g", utility="yes", missing="undecided", confidence=None, **count)
    assert (made.whatever[0].least, made.whatever[0].greatest) == ends(rows)


def test_the_field_s_log_leaves_it_open(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """Of 500 decisions on one group 480 are missing: its rate may be anything from 4 to 100 per cent."""
    rows = ["yes,asian"] * 480 + ["no,asian"] * 520 + ["yes,white"] * 500 + ["no,white"] * 500 + ["yes,black"] * 20 + [",black"] * 480
    path = tmp_path / "log.csv"
    path.write_text("\n".join(["d,g", *rows]) + "\n")
    words = [
        "certify",
        str(path),
        "--decision",
        "d",
        "--group",
        "g",
        "--utility",
        "yes",
        "--missing",
        "undecided",
        "--max-global-ratio",
        "1.3",
    ]
    assert main([*words, "--confidence", "none", "-o", str(path.with_suffix(".json"))]) == 3
    text = " ".join(capsys.readouterr().out.split())
    assert "Undecided: 480 of the 500 decisions on 'black' (96 %), and none on other groups." in text
    document = json.loads(path.with_suffix(".json").read_text())
    assert document["verdict"] == "depends"
    bounds = {c["relation"]: c["value"] for c in document["claims"] if c["by"] == "T19" and c["quantity"] == "global_ratio"}
    assert bounds == {">=": "25/24", "<=": "25/2"}  # 50 over 48 per cent, whatever black is; 50 over 4
    saved, attested = str(path.with_suffix(".json")), str(tmp_path / "attestation.json")
    assert main(["verify", saved]) == 0
    assert main([*words, "--confidence", "none", "-o", saved, "--attest", attested]) == 3
    assert main(["verify", saved, "--attestation", attested, "--recount", str(path)]) == 0


def test_with_named_labels_both_are_undecided() -> None:
    log = {"d": ["yes", "no", "maybe", "", "yes", "no"], "g": ["f", "f", "f", "m", "m", "m"]}
    made = fa.audit(log, decision="d", group="g", utility="yes", missing="undecided", undecided="maybe", confidence=None)
    assert made.undecided is not None and set(made.undecided.decisions) == {"maybe", "(missing)"}


def test_without_a_missing_decision_nothing_is_undecided() -> None:
    log = {"d": ["yes", "no", "yes", "no"], "g": ["f", "f", "m", "m"]}
    assert fa.audit(log, decision="d", group="g", utility="yes", missing="undecided").undecided is None


LOG = {"d": ["yes", "no", "", "yes", "no"], "g": ["f", "f", "f", "m", "m"], "p": [3, 2, None, 3, 1]}


@pytest.mark.parametrize(
    ("log", "options", "why"),
    [
        ({**LOG, "g": ["f", "f", "f", "m", ""]}, {"decision": "d"}, "column 'g'.*the label is missing"),
        (LOG, {"decision": "d", "difference": True}, "missing decisions that are undecided do not go with"),
        (LOG, {"score": "p", "above": 2, "utility": None}, "the score is missing"),
    ],
)
def test_what_it_does_not_go_with(log: Any, options: dict[str, Any], why: str) -> None:
    with pytest.raises(fa.InputError, match=why):
        fa.audit(log, group="g", missing="undecided", **{"utility": "yes", **options})
