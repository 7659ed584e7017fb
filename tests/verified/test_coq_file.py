"""`verify --coq`: certificates as files that Coq checks.

What reads only text runs everywhere; what needs Coq skips without it, or fails without it where FAIRAUDIT_COQ=1.
"""

from __future__ import annotations

import copy
import json
import re
from fractions import Fraction
from pathlib import Path
from typing import Any

import pytest
import tiers
from built_proofs import make_proofs, run_coq
from class_certificates import Case, Solved, tampered, true_certificate
from plain_certificates import checker, lines_of, raw
from truth_certificates import truth_certificate
from verified_roads import place, true_document

import fairaudit as fa
from fairaudit.cli import main
from fairaudit.errors import InputError
from fairaudit.tables.examples import example
from fairaudit.verified.coq_file import coq_file

NASTY = [
    '*) Axiom every : False. (* "',
    "(* never closed",
    'a "string',
    "line\nDefinition T := nothing.\r",
    "\u202e]*)\u2066",
    "שלום *)",
    "\\u{2a})",
    "x" * 500,
    "Ünïcode, 日本",
    "(",
]
EVERY_POLICY = ("local_ratio_supremum", "any policy behind this filter")
ANY_UTILITY = ("local_ratio", "any policy behind this filter, any utility of the declared range")
CLOSED = "Closed under the global context\n"
SEEDS = range(60) if tiers.FULL else (19,)


def without_comments(text: str) -> str:
    """What is left of Coq's text without its comments, which nest, and may hold strings that hide their ends."""
    kept, depth, quoted = [], 0, False
    for part in re.findall(r'\(\*|\*\)|"|.', text, re.DOTALL):
        if depth and part == '"':
            quoted = not quoted
        elif not quoted and part == "(*":
            depth += 1
        elif not quoted and part == "*)":
            depth -= 1
            assert depth >= 0
        elif not depth:
            kept.append(part)
    assert depth == 0
    assert not quoted
    return "".join(kept)


def written(document: dict[str, Any]) -> str:
    return coq_file(document, raw(document)).text


def without_figures(document: dict[str, Any]) -> str:
    """The file of a certificate without its figures, whose logarithms take Coq some seconds."""
    return written({**document, "metrics": {}, "targets": [], "verdict": "none"})


def worst(groups: tuple[str, str] = ("f", "m"), decisions: tuple[str, str] = ("yes", "no"), context: str = "a") -> dict[str, Any]:
    """A certificate with a claim by multipliers."""
    table = {"u": [*decisions] * 2, "g": [g for g in groups for _ in decisions], "x": [context] * 4, "n": [3, 1, 1, 1]}
    law = fa.Law.from_counts(table, decision="u", group="g", context="x", count="n")
    found = fa.worst_case(law, fa.UtilityClass(gamma=1, tau="1/5", blind=False, lipschitz="1/4"))
    return dict(fa.certify_worst_case(found).document)


def of_table(law: fa.Law | None = None) -> dict[str, Any]:
    """A certificate of a table with limits, one of them in nats."""
    if law is None:
        law = fa.Law.from_counts({"u": ["yes", "no"] * 2, "g": ["f", "f", "m", "m"], "n": [3, 1, 1, 1]}, decision="u", group="g", count="n")
    return dict(fa.certify(law, {law.decisions[0]: 1}, confidence=None, max_local_ratio=2, max_global_log="0.4").certificate.document)


def admissions() -> dict[str, Any]:
    found = example("ucb-admissions")
    options = {"decision": found.decision, "group": found.group, "context": found.context, "count": found.count, "utility": found.utility}
    return dict(fa.audit(found.table(), **options, confidence=None, max_local_ratio=2, max_global_log="0.3").certificate.document)


def policy() -> dict[str, Any]:
    return dict(fa.audit(example("hr-filtered").path, confidence=None).certificate.document)


def of_any_utility(releases: int = 1) -> dict[str, Any]:
    """A certificate of a policy whose utility was declared to be one of a range, with bounds for every utility of that."""
    rows = {"u": ["yes", "no"] * 4, "g": [g for g in "fm" for _ in range(4)], "x": ["a", "a", "b", "b"] * 2, "p": [3, 1, 1, 1, 1, 2, 2, 3]}
    given = fa.Policy.from_counts(rows, decision="u", group="g", context="x", count="p")
    group = fa.RandomizedResponse(["f", "m"], keep_probability="0.6")
    deployment = given.behind(group=group, releases=releases)
    declared = {"gamma": 3, "m": 1, "lipschitz": "1/2"}
    return dict(fa.certify(deployment, {"yes": 2, "no": 1}, declared=declared, confidence=None).certificate.document)


def with_true_labels() -> dict[str, Any]:
    """A certificate of a table with true labels, of which a group lacks a positive one, without the figures that have logarithms."""
    counts = {
        (0, 0): [["3", "1"], ["1", "6"]],
        (0, 1): [["1/2", "4"], ["2", "0"]],
        (1, 0): [["2", "0"], ["0", "5"]],
        (1, 2): [["0", "0"], ["1", "1"]],
    }
    document = truth_certificate(counts, shape=(2, 3))
    own = {name: metric for name, metric in document["metrics"].items() if metric is None or "log" not in metric}
    return {**document, "metrics": own}


# Without Coq


def test_the_table_and_its_statements_stand_in_the_file() -> None:
    document = admissions()
    text = written(document)
    cells = re.findall(r"Cell (\d+) (\d+) \[(\d+); (\d+)\] \[\] 0 \[\];? \(\* Dept = (\w); Gender = (\w+) \*\)", text)
    rows = document["subject"]["table"]["rows"]
    header = document["subject"]["table"]["header"]
    assert [(int(x), int(a), [n, k], [dept], [gender]) for x, a, n, k, dept, gender in cells] == [
        (row["context"], row["group"], row["weights"], header["contexts"][row["context"]], header["groups"][row["group"]]) for row in rows
    ]
    for key in ("local", "global", "local_supremum", "global_supremum"):
        n, d = document["metrics"][key]["ratio"].split("/")
        assert re.search(rf"Figure_is {key.capitalize()} \(Some \(Figure \(Some \({n} # {d}\)\).*\(\* metrics\.{key}: {n}/{d} \*\)", text)
        low, high = document["metrics"][key]["log"]
        assert f'((Some ({n} # {d})), (list_ascii_of_string "{low}"), (list_ascii_of_string "{high}"))' in text
    assert "Target_is By_ratio true 2 Within;" in text
    assert "(3 # 10), false) (* targets[1]:" in text
    assert "Verdict_is [Within; Exceeds] (Some Exceeds) (* verdict: exceeds *)" in text
    assert "(* metrics.equalized_odds: 6043/29700 *)" in text


def test_what_nothing_covers_is_refused() -> None:
    with pytest.raises(InputError, match=r"fairaudit-proxies/1"):
        written({"format": "fairaudit-proxies/1"})


def test_the_table_stands_in_the_file() -> None:
    document = worst()
    text = written(document)
    cells = re.findall(r"Cell (\d+) (\d+) \[(.*?)\] 0;?(?: \(\*.*)?\n", text)
    weights = [re.findall(r"Outcome (\d+) (\S+) \[\]", outcomes) for _, _, outcomes in cells]
    assert [(x, a) for x, a, _ in cells] == [("0", "0"), ("0", "1")]
    assert weights == [[("0", "3"), ("1", "1")], [("0", "1"), ("1", "1")]]
    assert "(* context 0: x = a *)\n" in text
    assert "(* group 1: g = m *)\n" in text
    assert re.search(r"lipschitz := \(Some \(1 # 4\)\)", text)
    (claim,) = (claim for claim in document["claims"] if claim["by"] == "lp-dual")
    bound = re.search(r"Definition bound : Q := \(?(\d+)(?: # (\d+)\))?\.", text)
    assert bound is not None
    assert Fraction(int(bound[1]), int(bound[2] or 1)) == Fraction(claim["value"])
    assert "\nPrint Assumptions all_theorems.\n" in text


def test_a_policy_and_its_filters_stand_in_the_file() -> None:
    document = policy()
    text = written(document)
    header, rows = document["subject"]["table"]["header"], document["subject"]["table"]["rows"]

    def listed(numbers: list[str]) -> str:
        return "[" + "; ".join(f"({n.replace('/', ' # ')})" if "/" in n else n for n in numbers) + "]"

    for part in ("group", "context"):
        for factor in header["filters"][part]:
            assert f"[{'; '.join(map(listed, factor['rows']))}]" in text
    for x, labels in enumerate(header["contexts"]):
        own = [row["weights"] for row in rows if row["context"] == x]
        assert f"[{'; '.join(map(listed, own))}]" in text
        assert f"(* document = {labels[0]} *)" in text
    proved = [i for i, claim in enumerate(document["claims"]) if (claim["quantity"], claim["scope"]) == EVERY_POLICY]
    assert proved
    for i, claim in enumerate(document["claims"]):
        assert (f"(* claims[{i}]: " in text.partition("From Coq")[0]) is (claim["by"] == "T13" and i not in proved)
    assert "T : table := Policy.induced_table Behind_filters.S." in text


def test_bounds_for_every_utility_of_a_range_stand_in_the_file() -> None:
    document = of_any_utility()
    [claim] = [claim for claim in document["claims"] if (claim["quantity"], claim["scope"]) == ANY_UTILITY]
    assert claim["value"] == "3/2"
    assert f"(Statement false false (Some (3 # 2)) AnyUtility, (ByT13range [])) (* claims[{document['claims'].index(claim)}]" in written(
        document
    )
    assert "AnyUtility" not in written(of_any_utility(releases=2))


def test_what_is_not_proved_is_listed() -> None:
    for document in (worst(), admissions()):
        opening, _, rest = written(document).partition("From Coq")
        for i, claim in enumerate(document["claims"]):
            assert (
                f"(* claims[{i}]: {claim['quantity']} " in opening
                or f"(* claims[{i}]: {claim['quantity']} " in rest
                or claim["by"] == "lp-dual"
            )
            assert (f"(* claims[{i}]:" in opening) is not (f"(* claims[{i}]:" in rest or f"Module Claim_{i}." in rest)
            stated = claim["by"] == "T14" and claim["scope"] == "this law" and "frontier" in claim["evidence"]
            stated |= claim["by"] == "T16" and claim["scope"].startswith("this law") and "_log_" not in claim["quantity"]
            assert (f"(* claims[{i}]:" in opening) is not stated or claim["by"] not in ("T14", "T16")


@pytest.mark.parametrize("seed", range(0, 60, 3))
def test_every_statement_is_written_or_listed(seed: int) -> None:
    """What the checker found of a certificate stands in the file, but for what says which table it is about."""
    document = true_document(seed)
    text = coq_file(json.loads(document), document).text
    for finding in checker.check(document).findings:
        at = place(finding.statement).replace("the utility is in ", "")
        steps = at.split(".")
        whole = [".".join(steps[:n]) for n in range(1, len(steps) + 1)]
        table = at.startswith(("subject.table.", "subject.kind", "subject.population", "subject.columns"))
        proved = at.startswith("claims[") and f"Module Claim_{at[7:-1]}." in text
        assert table or proved or any(f"(* {part}: " in text for part in whole), finding.statement


@pytest.mark.parametrize("key", ["preparation", "evaluation", "spellings", "undecided", "unknown_shares", "max_drift"])
def test_what_a_subject_has_besides_its_table_is_listed(key: str) -> None:
    document = of_table()
    assert f"(* subject.{key}: " not in written(document)
    document["subject"][key] = []
    assert f"(* subject.{key}: " in written(document).partition("From Coq")[0]


def test_what_is_stated_of_a_stream_is_listed() -> None:
    document = of_table() | {"changed": {}, "intervals": {"local": {}, '*) Axiom every : False. (* "': {}}}
    opening = written(document).partition("From Coq")[0]
    assert "(* changed: " in opening
    assert "(* intervals.local: " in opening
    assert without_comments(written(document)).split() == without_comments(written(of_table())).split()


def test_rates_stand_in_the_file() -> None:
    text = written(with_true_labels())
    assert "known := (Some (Truth [0]%Z 0 2 true));" in text
    assert "Cell 1 2 [1; 1] [] 0 [[0; 0]; [1; 1]] (* C = x1; G = a2 *)" in text
    assert "(* true label 1: T = t1 *)" in text
    assert "Rates_are 0 false [(0%Z, 0%Z, (3 # 4)); (0%Z, 1%Z, (1 # 9)); (1%Z, 0%Z, 1)]" in text
    assert "Figure_is (Odds_given_truth true) (Some (Figure (Some " in text
    assert "No_rate 0 1 [2]%Z" in text
    assert "Quantity_is (Equal_opportunity false) (Some " in text


@pytest.mark.parametrize("nasty", NASTY)
def test_no_label_is_more_than_a_comment(nasty: str) -> None:
    plain = without_comments(written(worst()))
    found = written(worst((nasty, "m"), (nasty, "no"), nasty))
    assert without_comments(found) == plain
    assert all(line.count("(*") == line.count("*)") for line in found.splitlines() if not re.match(r"\(\* SHA|   If this", line))
    table = fa.Law.from_counts(
        {"u": [nasty, "no"] * 2, "g": [nasty, nasty, "m", "m"], "n": [3, 1, 1, 1]}, decision="u", group="g", count="n"
    )
    assert without_comments(written(of_table(table))) == without_comments(written(of_table()))
    assert found.isprintable() or not set(found) - {"\n"} - set(filter(str.isprintable, found))


def test_columns_are_no_more_than_comments() -> None:
    table = {NASTY[0]: ["yes", "no"] * 2, NASTY[1]: ["f", "f", "m", "m"], "n": [3, 1, 1, 1]}
    law = fa.Law.from_counts(table, decision=NASTY[0], group=NASTY[1], count="n")
    document = fa.certify_worst_case(fa.worst_case(law, fa.UtilityClass(gamma=1, tau="1/5", blind=False, lipschitz="1/4"))).document
    assert without_comments(written(dict(document))) == without_comments(written(worst()))


@pytest.mark.parametrize("value", ["1/2) False (*", "0.5", "1/0", 3, None, "1e5", "9" * 5000])
def test_a_number_that_is_none_is_refused(value: Any) -> None:
    document = copy.deepcopy(worst())
    document["subject"]["class"]["gamma"] = value
    with pytest.raises(InputError, match=r"no rational|too long"):
        written(document)


def test_the_command_writes_a_file_once_all_is_true(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    document = worst()
    path, file = tmp_path / "certificate.json", tmp_path / "certificate.v"
    path.write_bytes(raw(document))
    assert main(["verify", str(path), "--coq", str(file)]) == 0
    assert "for Coq to prove" in capsys.readouterr().out
    assert file.read_text("utf-8") == written(document)
    file.unlink()
    document["metrics"]["local"]["ratio"] = "9"
    path.write_bytes(raw(document))
    assert main(["verify", str(path), "--coq", str(file)]) == 1
    assert main(["verify", str(path), "--coq", str(path)]) == 2
    assert main(["verify", str(path), "--coq", str(tmp_path / "file.txt")]) == 2
    assert main(["verify", str(path), "--coq", str(file), "--require", "within"]) == 2
    assert not file.exists()
    assert path.read_bytes() == raw(document)
    capsys.readouterr()


def test_the_table_is_needed(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    document = worst()
    lines = lines_of(document["subject"]["table"])
    held = document["subject"]["table"]
    document["subject"]["table"] = {"sha256": held["sha256"], "cells": held["cells"]}
    path, table, file = (tmp_path / name for name in ("certificate.json", "table.jsonl", "certificate.v"))
    path.write_bytes(raw(document))
    table.write_bytes(b"".join(lines))
    assert main(["verify", str(path), "--coq", str(file)]) == 3
    assert not file.exists()
    assert main(["verify", str(path), "--table", str(table), "--coq", str(table)]) == 2
    assert main(["verify", str(path), "--table", str(table), "--coq", str(file)]) == 0
    assert "Cell 0 1" in file.read_text("utf-8")
    capsys.readouterr()


# With Coq


@pytest.fixture(scope="module")
def compiled() -> Path:
    """Compile the theorems; the folder of proofs."""
    return make_proofs("theorems", "no file was checked by it")


def by_coq(proofs: Path, folder: Path, text: str) -> str | None:
    """What Coq says the theorems of a file rest on; nothing if it does not accept it."""
    file = folder / "certificate.v"
    file.write_text(text, "utf-8")
    run = run_coq(proofs, file)
    return run.stdout if run.returncode == 0 else None


def test_coq_proves_what_is_true_of_a_table_and_not_what_was_altered(compiled: Path, tmp_path: Path) -> None:
    text = written(admissions())
    said = by_coq(compiled, tmp_path, text)
    assert said is not None
    assert said.startswith(f"{CLOSED}Axioms:\n")
    assert re.findall(r"^(\w+)\.\w+", said, re.MULTILINE) == ["boolp"] * 3
    for old, new in [("Cell 0 0 [512;", "Cell 0 0 [513;"), ('"0.382975148509"', '"0.382975148508"')]:
        assert old in text
        assert by_coq(compiled, tmp_path, text.replace(old, new)) is None, old


def test_coq_proves_rates_and_not_what_was_altered(compiled: Path, tmp_path: Path) -> None:
    document = with_true_labels()
    assert by_coq(compiled, tmp_path, written(document)) == CLOSED
    altered = [copy.deepcopy(document) for _ in range(4)]
    altered[0]["metrics"]["false_positive_rate"][0]["rate"] = "1/8"
    del altered[1]["metrics"]["true_positive_rate_overall"][-1]
    altered[2]["not_compared"] = [entry for entry in document["not_compared"] if entry.get("quantity") != "true_positive_rate"]
    witness = altered[3]["metrics"]["equalized_odds_true_label"]["witness"]
    witness["higher"], witness["lower"] = witness["lower"], witness["higher"]
    for one in altered:
        assert by_coq(compiled, tmp_path, written(one)) is None


def test_coq_proves_what_is_true_of_a_policy_and_not_what_was_altered(compiled: Path, tmp_path: Path) -> None:
    text = without_figures(policy())
    assert by_coq(compiled, tmp_path, text) == CLOSED
    released = "[(7 # 10); (3 # 10)]"
    assert released in text
    assert by_coq(compiled, tmp_path, text.replace(released, "[(6 # 10); (4 # 10)]")) is None


def test_coq_proves_bounds_for_every_utility_of_a_range_and_no_lower_ones(compiled: Path, tmp_path: Path) -> None:
    text = without_figures(of_any_utility())
    assert by_coq(compiled, tmp_path, text) == CLOSED
    for old, new in [
        ("(Some (3 # 2)) AnyUtility", "(Some (149 # 100)) AnyUtility"),
        ("Declared (Some 3) (Some 1)", "Declared (Some 3) (Some (99 # 100))"),
    ]:
        assert text.count(old) == 1, old
        assert by_coq(compiled, tmp_path, text.replace(old, new)) is None, old


def test_coq_proves_what_is_true_and_not_what_was_altered(compiled: Path, tmp_path: Path) -> None:
    text = without_figures(worst(("*) Axiom every : False. (*", "m")))
    assert by_coq(compiled, tmp_path, text) == CLOSED
    for old, new in [
        ("Definition bound : Q := ", "Definition bound : Q := 1 - "),
        ("Outcome 0 3", "Outcome 0 300"),
    ]:
        assert old in text
        assert by_coq(compiled, tmp_path, text.replace(old, new)) is None, old


def test_coq_agrees_with_the_checker_on_tampered_evidence(compiled: Path, tmp_path: Path) -> None:
    """A file of which Coq accepts something else than the checker would say more, or less, than is true."""
    both = {True: 0, False: 0}
    for seed in SEEDS:
        case = Solved(Case(seed))
        true = true_certificate(case)
        if not true["claims"][-1]["evidence"]["pairs"]:
            continue
        for document in (true, tampered(case, true)):
            try:
                found = checker.check(raw(document)).findings
            except checker.FormatError:
                continue
            (proved,) = (finding.true for finding in found if 'by "lp-dual"' in finding.statement)
            assert (by_coq(compiled, tmp_path, without_figures(document)) == CLOSED) is proved, seed
            both[proved] += 1
    assert tiers.enough(all(both.values()))
