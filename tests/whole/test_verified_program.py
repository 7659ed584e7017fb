"""The checker that is extracted from its proof says what the other says, natively and as JavaScript; none accepts forged certificates.

5,000 true and altered documents in .ci/run, half as many by hand; 100,000, and each forged one:
FAIRAUDIT_FULL=1 pytest -s tests/whole/test_verified_program.py
"""

from __future__ import annotations

import json
import os
import subprocess
from collections.abc import Callable, Iterator
from pathlib import Path
from random import Random as Pick

import pytest
from assumptions import complete
from built_proofs import PROOFS, build
from certificate_changes import put
from certificate_kinds import as_bytes
from forged_certificates import FAMILIES, Forged
from plain_certificates import make
from verified_roads import FALSE, MALFORMED, OPEN, TRUE, Tally, documents, driver, natively

import fairaudit as fa

FULL = os.environ.get("FAIRAUDIT_FULL") == "1"
BLOCKS = 10
EACH = 49
"""Alterations of each true document."""
PER_BLOCK = 100_000 // BLOCKS if FULL else 5 * int(os.environ.get("FAIRAUDIT_EXAMPLES", "50"))


@pytest.fixture(scope="module")
def program(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The program, which judges many documents in one process, where the proofs were built before or have to be."""
    if os.environ.get("FAIRAUDIT_COQ") != "1" and not (PROOFS / "checker" / "Certificate.vo").is_file():
        pytest.skip("the proofs are not built: make -C proofs, see docs/proofs.md")
    return driver(build("build/fairaudit-check") / "build", tmp_path_factory.mktemp("driver"))


@pytest.mark.parametrize("block", range(BLOCKS))
def test_the_same_verdicts(block: int, program: Path) -> None:
    tally, per_block = Tally(), -(-PER_BLOCK // (1 + EACH))
    for first in range(block * per_block, (block + 1) * per_block, 20):  # so that a process judges a thousand documents
        tally.judge(program, documents(range(first, min(first + 20, (block + 1) * per_block)), EACH))
    print(dict(tally.codes), dict(tally.open.most_common()))
    assert tally.different[:3] == []
    assert sum(tally.codes.values()) >= PER_BLOCK
    assert {code for code, _ in tally.codes} >= {TRUE, FALSE, MALFORMED}


@pytest.mark.parametrize("family", FAMILIES)
def test_no_forged_certificate_is_accepted(family: Callable[[], Iterator[Forged]], program: Path) -> None:
    """Where what was forged is not covered, that is not said to be true."""
    forged = list(family())
    step = 1 if FULL else max(1, len(forged) // 65)
    tally = Tally()
    tally.judge(program, [document for _, document in forged[::step]])
    print(family.__name__, len(forged), dict(tally.codes))
    assert tally.different[:3] == []
    assert {python for python, _ in tally.codes} <= {FALSE, MALFORMED}
    assert {verified for _, verified in tally.codes} <= {FALSE, MALFORMED, OPEN}


@pytest.mark.parametrize(
    ("document", "code"),
    [
        (b"[" * 1_000_000, 2),
        (b"[" * 300_000 + b"]" * 300_000, 2),
        (b'{"a": 1, "a": 1}', 2),
        (b'{"\\ud83d\\ude00": 1, "\xf0\x9f\x98\x80": 1}', 2),
        (b'{"format": "fairaudit-certificate/1"}', 2),
        (b"9" * 200_000, 2),
    ],
)
def test_hostile_files(document: bytes, code: int, program: Path, tmp_path: Path) -> None:
    path = tmp_path / "certificate.json"
    path.write_bytes(document)
    assert subprocess.run([str(PROOFS / "build" / "fairaudit-check"), str(path)], capture_output=True).returncode == code


@pytest.mark.slow
def test_long_numbers(program: Path) -> None:
    """Counts of 1,000 digits, and numbers of as many digits as the format has: all roads say the same, and none runs out of memory."""
    pick = Pick(0)
    weights = {(0, a): [str(pick.randrange(10**999, 10**1000)) for _ in range(2)] for a in range(2)}
    given = complete(make(weights, ["0", "1"], shape=(1, 2), limits=(("local", "ratio", "2"),)))
    [claim, *_] = given["claims"]
    altered = [put(json.dumps(given), ("claims", 0, "value"), value) for value in (f"{claim['value']}1", "9" * 100_000, "9" * 100_001)]
    altered.append(put(json.dumps(given), ("targets", 0, "limit"), "9" * 100_000))
    tally = Tally()
    tally.judge(program, [as_bytes(document) for document in (given, *altered)])
    assert tally.different == []
    assert tally.codes == {(TRUE, TRUE): 1, (FALSE, FALSE): 3, (MALFORMED, MALFORMED): 1}


@pytest.mark.parametrize(
    ("labels", "covered"),
    [(["a a", "Aa "], False), (["1", "2"], True), (["1", "1.0"], False), (["é", "b"], False), (["e", "E2"], False), (["e", "<30"], True)],
)
def test_labels_that_may_be_spellings_of_one_another_are_left_to_the_other_checker(labels: list[str], covered: bool, program: Path) -> None:
    law = fa.Law.from_array([[[3, 1], [1, 4]]] * 2, kind="counts", contexts=labels)
    [judged] = natively(program, [json.dumps(fa.certify(law, {"0": 1}).certificate.document).encode()])
    assert (("subject.spellings", None) not in judged.statements) is covered
    assert all(true is not False for _, true in judged.statements)
