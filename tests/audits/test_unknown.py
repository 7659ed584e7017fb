"""Decisions of unknown group from the log to the verdict: every assignment gone through by hand, and the checker believes nothing."""

from __future__ import annotations

import itertools
import json
import os
import random
from fractions import Fraction
from math import inf
from pathlib import Path
from typing import Any

import pytest

import fairaudit as fa
from fairaudit import checker
from fairaudit.errors import InputError

F = Fraction
TABLES = int(os.environ.get("FAIRAUDIT_UNKNOWN", "60"))
WORTH = {"yes": F(1), "maybe": F(1, 2), "no": F(0)}
TABLE: dict[str, list[Any]] = {
    "hired": ["yes", "no", "yes", "no", "yes", "no", "no"],
    "sex": ["f", "f", "m", "m", "n/a", "n/a", "declined"],
    "n": [30, 20, 35, 15, 3, 4, 2],
}

Rows = list[tuple[str, str, str]]  # decision, group or "?", context


def ratio(cells: dict[str, list[Fraction]]) -> Fraction | float | None:
    means = [sum(own, F(0)) / len(own) for own in cells.values() if own]
    if len(means) < 2:
        return None
    return max(means) / min(means) if min(means) else (inf if max(means) else F(1))


def both(rows: Rows, compared: dict[str | None, list[str]]) -> tuple[Any, Any]:
    """The local and the global ratio of rows that all have a group or go to nobody (""), among the groups that are compared."""
    found: list[Any] = []
    for x, groups in compared.items():
        cells: dict[str, list[Fraction]] = {a: [WORTH[u] for u, b, y in rows if b == a and x in (y, None)] for a in groups}
        found.append((x, ratio(cells)))
    local = [r for x, r in found if x is not None and r is not None]
    return max(local, default=None), dict(found).get(None)


def everything(rows: Rows, limits: dict[str, tuple[Fraction, Fraction]]) -> tuple[list[Any], list[Any]]:
    """Both ratios for all assignments of the unknown rows; limits hold in each context for the local ratio, over all for the other."""
    names = sorted({a for _, a, _ in rows} - {"?"})
    contexts = sorted({x for _, _, x in rows})
    compared: dict[str | None, list[str]] = {x: sorted({a for _, a, y in rows if y == x} - {"?"}) for x in contexts}
    compared[None] = names
    known, unknown = [row for row in rows if row[1] != "?"], [row for row in rows if row[1] == "?"]
    local, overall = [], []

    def kept(some: Rows) -> bool:
        total = len(some)
        return all(
            (low * total).__floor__() <= sum(a == name for _, a, _ in some) <= (high * total).__ceil__()
            for name, (low, high) in limits.items()
        )

    for given in itertools.product([*names, ""], repeat=len(unknown)):
        some = [(u, a, x) for (u, _, x), a in zip(unknown, given, strict=True)]
        one, other = both([*known, *some], compared)
        if one is not None and all(kept([row for row in some if row[2] == x]) for x in contexts):
            local.append(one)
        if other is not None and kept(some):
            overall.append(other)
    return local, overall


def random_rows(pick: random.Random) -> Rows:
    groups, contexts = "fmn"[: pick.randint(2, 3)], "st"[: pick.randint(1, 2)]
    kinds = pick.choice([["yes", "no"], ["yes", "maybe", "no"]])
    rows = [(pick.choice(kinds), a, x) for a in groups for x in contexts for _ in range(pick.choice([0, 1, 2, 4, 7]))]
    rows += [("yes", "f", "s"), *((pick.choice(kinds), a, "s") for a in groups)]
    return rows + [(pick.choice(kinds), "?", pick.choice(contexts)) for _ in range(pick.randint(1, 6 if len(groups) == 2 else 4))]


def certified(rows: Rows, **options: Any) -> fa.Result:
    table = dict(zip(("u", "a", "x"), map(list, zip(*rows, strict=True)), strict=True))
    return fa.audit(
        table, decision="u", group="a", context="x", utility={"yes": 1, "maybe": "1/2"}, unknown=["?"], confidence=None, **options
    )


@pytest.mark.parametrize("half", [0, 1])
def test_certificates_are_true_and_say_what_all_assignments_say(half: int) -> None:
    pick = random.Random(half)
    verdicts = set()
    for _ in range(TABLES // 2):
        rows = random_rows(pick)
        shares = {"f": (F(1, 5), F(3, 5)), "": (F(0), F(1, 3))} if pick.random() < 0.4 else {}
        limit = pick.choice([F(1), F(5, 4), F(2), F(4)])
        declared = {a or "*": ends for a, ends in shares.items()}
        result = certified(rows, unknown_share=declared, max_local_ratio=limit, max_global_ratio=limit)
        report = checker.check(result.certificate.text.encode())
        assert report.ok, [finding for finding in report.findings if not finding.true]
        found = dict(zip(("local", "global"), everything(rows, shares), strict=True))
        for own, target in zip(result.whoever, result.targets, strict=False):
            ratios = found[own.quantity]
            assert own.greatest == max(ratios) and own.least <= min(ratios), rows
            assert own.reached is not None and own.reached.ratio >= min(ratios)
            if own.quantity == "global":
                assert own.least == min(ratios) == own.reached.ratio
            true = "within" if max(ratios) <= limit else "exceeds" if min(ratios) > limit else "depends"
            assert target.verdict in (true, "inconclusive")
            verdicts.add(target.verdict)
    assert {"within", "exceeds", "depends"} <= verdicts


def test_the_command_of_the_readme(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    from fairaudit.cli import main

    log, certificate = tmp_path / "log.csv", tmp_path / "cert.json"
    log.write_text("hired,sex\n" + "".join(f"{u},{a}\n" * n for u, a, n in zip(*TABLE.values(), strict=True)), "utf-8")
    asked = ["--decision", "hired", "--group", "sex", "--utility", "yes", "--unknown", "n/a,declined", "-o", str(certificate)]
    assert main(["certify", str(log), *asked, "--max-local-ratio", "5/4", "--show-completions"]) == 3
    said = capsys.readouterr().out
    assert "DEPENDS" in said and "Of 109 decisions, 9 have no recorded group; whoever they are" in said
    assert "for the greatest ratio" in said
    document = json.loads(certificate.read_text("utf-8"))
    assert document["verdict"] == "depends" and document["targets"][0]["judged"] == "this table, whoever the unknown are"
    assert document["subject"]["table"]["rows"][-1] == {"context": 0, "unknown": ["6", "3"]}
    assert main(["verify", str(certificate)]) == 0


STARRED = {**TABLE, "sex": ["*" if sex == "f" else sex for sex in TABLE["sex"]]}


def audit(table: dict[str, Any] = TABLE, **options: Any) -> fa.Result:
    given: dict[str, Any] = {"unknown": ["n/a", "declined"], "count": "n", "utility": "yes", **options}
    return fa.audit(table, decision="hired", group="sex", **given)


def test_figures_are_those_without_the_unknown_rows() -> None:
    rest = {name: values[:4] for name, values in TABLE.items()}
    with_, without = audit(confidence=None), audit(rest, unknown=(), confidence=None)
    assert (with_.local, with_.global_, with_.tau) == (without.local, without.global_, without.tau)
    assert with_.law.groups == without.law.groups == (("f",), ("m",))
    assert [claim.quantity for claim in with_.claims if claim.by == "T15"] == ["local_ratio"] * 2 + ["global_ratio"] * 2


def test_all_targets_are_of_the_table_whoever_they_are_and_intervals_decide_nothing() -> None:
    result = audit(max_local_ratio=2, max_global_log="0.9")
    assert result.intervals and {target.under for target in result.targets} == {"whoever the unknown are"}
    assert {target.confidence for target in result.targets} == {None} and result.verdict == "within"


def test_empty_labels_can_be_unknown_and_other_columns_must_not_be_empty() -> None:
    table = {**TABLE, "sex": ["f", "f", "m", "m", "", "", None]}
    assert audit(table, missing="unknown", unknown=()).whoever == audit().whoever
    with pytest.raises(InputError, match="the label is missing"):
        audit({**table, "hired": ["yes", "no", "yes", "no", "yes", "no", ""]}, missing="unknown")


def test_a_row_of_which_one_column_is_unknown_is_wholly_unknown_after_labels_were_merged() -> None:
    table = {
        "u": ["yes", "no", "yes", "no", "yes", "yes"],
        "sex": ["f", "f", "m", "m", "F", "N/A"],
        "race": ["b", "b", "b", "b", "n/a", "w"],
    }
    result = fa.audit(table, decision="u", group=["sex", "race"], utility="yes", unknown=["n/a"], fold_labels=True, confidence=None)
    assert result.law.groups == (("f", "b"), ("m", "b")) and result.whoever[0].unknown == 2
    entry = result.preparation[-1]
    assert entry["step"] == "unknown" and entry["columns"] == {"sex": "1", "race": "1"} and entry["decisions"] == "2"
    assert checker.check(result.certificate.text.encode()).ok


def test_a_utility_column_must_not_depend_on_the_group_where_rows_are_unknown() -> None:
    rows: dict[str, list[Any]] = {"u": ["a", "b", "a", "b", "a"], "sex": ["f", "f", "m", "m", "?"], "g": [2, 1, 2, "1/2", 2]}
    result = fa.audit(rows, decision="u", group="sex", utility_column="g", unknown=["?"], confidence=None)
    assert result.whoever[0].greatest == F(5, 3) / F(5, 4) and checker.check(result.certificate.text.encode()).ok
    with pytest.raises(InputError, match="depends on the group"):
        fa.audit(
            {**rows, "sex": ["f", "f", "m", "m", "?"], "g": [2, 1, 3, 1, 2]}, decision="u", group="sex", utility_column="g", unknown=["?"]
        )


@pytest.mark.parametrize(
    ("options", "said"),
    [
        ({"unit": "n", "count": None}, "does not go with unit"),
        ({"truth": "n", "count": None}, "does not go with truth"),
        ({"probability": "n", "count": None}, "probabilities do not say how many"),
        ({"difference": True}, "go with ratios"),
        ({"max_drift": "0.1", "max_local_ratio": 2}, "one objection at a time"),
        ({"unknown_share": {"x": (0, 1)}}, "which is no group"),
        ({"unknown_share": {"f": (0.6, 0.4)}}, "must rise"),
        ({"table": STARRED, "unknown_share": {"*": (0, 1)}}, "has this label"),
        ({"unknown_share": {"f": (0.6, 1), "m": (0.5, 1)}}, "more than 1"),
        ({"unknown_share": {"f": (0, 0.4), "m": (0, 0.4), "*": (0, 0.1)}}, "less than 1"),
        ({"unknown": (), "unknown_share": {"f": (0, 1)}}, "goes with unknown"),
        ({"unknown": ["f", "m", "n/a", "declined"]}, "the group of every row is unknown"),
        ({"in_parts": True, "count": None}, "in_parts does not go with"),
    ],
)
def test_what_makes_no_sense_is_refused_in_one_sentence(options: dict[str, Any], said: str) -> None:
    with pytest.raises(InputError, match=said):
        audit(**options)


def test_weights_and_policies_are_refused() -> None:
    with pytest.raises(InputError, match="whole counts"):
        audit({**TABLE, "n": [30, 20, 35, 15, "0.5", 4, 2]}, confidence=None)
    law = fa.Law.from_counts(TABLE, decision="hired", group="sex", count="n", unknown=["n/a", "declined"])
    with pytest.raises(InputError, match="do not go with a policy"):
        fa.Policy(law)


def test_shares_limit_who_they_are_and_stand_in_the_claims() -> None:
    free, bound = audit(confidence=None), audit(confidence=None, unknown_share={"f": (0, 0), "*": (0, 0)})
    assert bound.whoever[0].greatest < free.whoever[0].greatest
    claims = [claim for claim in bound.claims if claim.by == "T15"]
    assert all(len(claim.assumptions) == 2 and "in every context" in claim.assumptions[0] for claim in claims[:2])
    assert checker.check(bound.certificate.text.encode()).ok


def test_an_audit_file_says_the_same(tmp_path: Path) -> None:
    (tmp_path / "t.csv").write_text("hired,sex,n\n" + "".join(f"{u},{a},{n}\n" for u, a, n in zip(*TABLE.values(), strict=True)), "utf-8")
    text = '[law]\ntable = "t.csv"\ndecision = "hired"\ngroup = "sex"\ncount = "n"\nunknown = ["n/a", "declined"]\n'
    text += 'unknown_share = { f = ["0.2", "0.6"] }\n[utility]\nvalues = { yes = 1 }\n[targets]\nmax_local_ratio = "5/4"\n'
    (tmp_path / "audit.toml").write_text(text, "utf-8")
    result = fa.audit(str(tmp_path / "audit.toml"))
    assert result.whoever == audit(unknown_share={"f": ("0.2", "0.6")}).whoever and result.targets[0].under


def test_labels_that_do_not_occur_change_nothing() -> None:
    rest = {name: values[:4] for name, values in TABLE.items()}
    assert audit(rest).certificate.text == audit(rest, unknown=()).certificate.text
