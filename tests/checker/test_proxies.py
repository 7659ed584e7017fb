"""The checker of certificates about groups that nobody recorded: it takes what is true, and nothing that was altered.

All alterations: FAIRAUDIT_FULL=1 pytest -n0 tests/checker/test_proxies.py
"""

from __future__ import annotations

import contextlib
import copy
import hashlib
import json
import random
from time import process_time
from typing import Any

import pytest
import tiers
from proxy_certificates import alterations, every_kind, proxied, stated

from fairaudit import checker
from fairaudit.audits.proxies import audit_proxies
from fairaudit.audits.reading import Reading
from fairaudit.certificates.certificate import Certificate
from fairaudit.checker import proxies
from fairaudit.checker.proxy_ranges import Cell
from fairaudit.model.utility import Utility

ENOUGH = 10**9 if tiers.FULL else 250


def check(document: dict[str, Any]) -> bool:
    """Whether the checker takes a document."""
    try:
        return checker.check(Certificate(document).text.encode("ascii")).ok
    except checker.FormatError:
        return False


def test_certificates_of_every_kind_are_true() -> None:
    for made in every_kind():
        report = checker.check(made.certificate.text.encode("ascii"))
        assert report.ok, [finding for finding in report.findings if not finding.true]
        assert report.verdict == made.verdict


def test_no_alteration_passes() -> None:
    """What the checker takes nonetheless states the same: other evidence, another name of a group, a limit with the same verdict."""
    tried = 0
    for seed, made in enumerate(every_kind()):
        document = made.certificate.document
        changes = list(alterations(document))
        for path, changed in random.Random(tiers.fresh(seed)).sample(changes, min(ENOUGH, len(changes))):
            tried += 1
            if check(changed):
                assert stated(changed) == stated(document), path
                free = {"versions", "assumptions", "limit", "higher", "lower", "mixture", "order", "rows"}
                named = path[:2] in {("subject", "groups")} or path[:3] == ("subject", "columns", "group")
                unused = path[:2] == ("subject", "cells")
                assert named or unused or free & set(path), path
    assert tiers.enough(tried >= 1_000)


@pytest.mark.parametrize(
    ("change", "says"),
    [
        (lambda d: d["assumptions"].pop(), "lacks the assumption"),
        (lambda d: d["assumptions"].append("all is well"), "is no assumption"),
        (lambda d: d["subject"]["cells"].pop(), "lacks the cell"),
        (lambda d: d["subject"]["cells"][0].update(probability=["1/2", "1/3"]), "does not sum to 1"),
        (lambda d: d.update(format="fairaudit-proxies/2"), "lacks the key"),
        (lambda d: d.update(claims=[]), "unknown key"),
        (lambda d: d["local"][0]["low"].update(rows=[]), "must list the rows"),
        (lambda d: d["subject"]["table"]["header"].update(population="equal"), "population"),
    ],
)
def test_what_is_no_such_certificate_is_refused_with_a_reason(change: Any, says: str) -> None:
    document = copy.deepcopy(proxied(random.Random(tiers.fresh(0)), 2).certificate.document)
    change(document)
    with pytest.raises(checker.FormatError, match=says):
        checker.check(Certificate(document).text.encode("ascii"))


def test_a_table_beside_the_certificate_is_the_same() -> None:
    made = proxied(random.Random(tiers.fresh(1)), 3, embed=False)
    certificate = made.certificate
    assert certificate.table is not None
    raw = certificate.text.encode("ascii")
    with pytest.raises(checker.TableNeeded):
        checker.check(raw)
    assert checker.check(raw, certificate.table.lines()).ok
    other = proxied(random.Random(tiers.fresh(2)), 3, embed=False).certificate.table
    assert other is not None
    with contextlib.suppress(checker.FormatError):
        assert not checker.check(raw, other.lines()).ok


def test_a_short_document_cannot_keep_the_checker_busy() -> None:
    document = copy.deepcopy(proxied(random.Random(tiers.fresh(0)), 2).certificate.document)
    digits = 90_000
    document["local"][0]["low"]["mixture"] = [
        {"share": f"1/{10**400 + i}".replace("e", ""), "order": [0, 1] if i % 2 else [1, 0]} for i in range(2)
    ]
    assert not check(document)
    document["subject"]["cells"][0]["probability"] = [f"1/{'7' * digits}", f"{'7' * (digits - 1)}6/{'7' * digits}"]
    assert not check(document)


def test_the_exported_checker_takes_them(tmp_path: Any) -> None:
    import subprocess
    import sys

    from fairaudit.cli.checking import zipped_checker

    (tmp_path / "checker.pyz").write_bytes(zipped_checker())
    [path] = proxied(random.Random(tiers.fresh(0)), 3).save(tmp_path / "c.json")
    done = subprocess.run(
        [sys.executable, "-I", "-S", str(tmp_path / "checker.pyz"), str(path)], capture_output=True, text=True, check=False, timeout=60
    )
    assert done.returncode == 0, done.stderr
    document = json.loads(path.read_text("utf-8"))
    document["local"][0]["greatest"]["ratio"] = "1"
    path.write_text(json.dumps(document), "utf-8")
    done = subprocess.run(
        [sys.executable, "-I", "-S", str(tmp_path / "checker.pyz"), str(path)], capture_output=True, text=True, check=False, timeout=60
    )
    assert done.returncode == 1, done.stderr


SMALL = {"place": ["p", "p", "q", "q"], "out": ["y", "n", "y", "n"], "n": [1, 1, 2, 4]}
SHARES = {"place": ["p", "p", "q", "q"], "race": ["b", "w", "b", "w"], "probability": ["1/2", "1/2", "1/3", "2/3"]}


def small() -> dict[str, Any]:
    """Two cells with known shares."""
    made = audit_proxies(SMALL, Reading("out", ("race",), (), count="n"), Utility({"y": 1}), SHARES, limits={})
    return copy.deepcopy(made.certificate.document)


def redigested(document: dict[str, Any]) -> bytes:
    """The same with the digest of its table as it now is."""
    table = document["subject"]["table"]
    lines = [checker.json_values.canonical_text(line) for line in (table["header"], *table["rows"])]
    table["sha256"] = hashlib.sha256(b"".join(lines)).hexdigest()
    return json.dumps(document).encode()


def test_rows_of_no_cell_are_refused() -> None:
    """Ranges say nothing of rows that stand in the table by themselves, however many these are."""
    document = small()
    table = document["subject"]["table"]
    table["header"]["unknown"] = True
    table["rows"].append({"context": 0, "unknown": ["1000000", "0"]})
    with pytest.raises(checker.FormatError, match="must be one of counts"):
        checker.check(redigested(document))


def test_counts_are_whole_one_by_one() -> None:
    """Three halves and three halves are three rows, of which the certificate for one and one says something else."""
    document = small()
    assert checker.check(redigested(document)).ok
    document["subject"]["table"]["rows"][0]["weights"] = ["3/2", "3/2"]
    with pytest.raises(checker.FormatError, match="not whole"):
        checker.check(redigested(document))


def test_a_file_beside_a_table_in_the_certificate_is_that_table() -> None:
    document = small()
    table = document["subject"]["table"]
    lines = [checker.json_values.canonical_text(line) for line in (table["header"], *table["rows"])]
    assert checker.check(json.dumps(document).encode(), lines).ok
    assert not checker.check(json.dumps(document).encode(), lines[:-1]).ok


def test_a_pair_of_very_many_groups_takes_no_longer() -> None:
    """What all others have is known from what all have together."""
    many = 5_000
    cell = Cell(((0, 1), (1, 1)), 10 * many, (1,) * many, (20,) * many)
    started = process_time()
    assert {cell.limits((a, a + 1)) for a in range(many - 1)} == {(2, 40)}
    assert cell.limits(range(1, many)) == (10 * many - 20, 10 * many - 1)
    assert process_time() - started < 2


def test_ranges_are_gone_through_once_for_all_targets(monkeypatch: pytest.MonkeyPatch) -> None:
    times = 0
    greatest = proxies._greatest

    def counted(ratios: Any) -> Any:
        nonlocal times
        times += 1
        return greatest(ratios)

    monkeypatch.setattr(proxies, "_greatest", counted)
    document = small()
    judged = {"quantity": "local", "unit": "ratio", "judged": proxies.JUDGED, "verdict": "depends"}
    document["targets"] = [{**judged, "limit": str(limit)} for limit in range(2, 50)]
    assert not checker.check(json.dumps(document).encode()).ok
    assert 0 < times <= 8
