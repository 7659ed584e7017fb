"""Hostile documents: no document of less than a megabyte keeps the checker busy for long, or fills the memory.

All 1,000 of them: FAIRAUDIT_FULL=1 pytest -n0 tests/checker/test_work.py
"""

from __future__ import annotations

import json
import os
import sys
import time
from fractions import Fraction
from pathlib import Path

import numpy as np
import pytest
import tiers
from hostile import FAMILIES, hostile

import fairaudit as fa
from fairaudit import checker
from fairaudit.model.layout import Columns
from fairaudit.model.mechanism import Mechanism
from fairaudit.model.policy import Policy

F = Fraction

DOCUMENTS = 1000 if tiers.FULL else 2 * len(FAMILIES)
SECONDS, MEGABYTES = 10, 800


def measured(document: bytes) -> tuple[str, float, float]:
    """What the checker says of a document in a process of its own, its seconds of work, and its megabytes of memory beyond ours."""
    resource = pytest.importorskip("resource")
    reading, writing = os.pipe()
    statm = Path("/proc/self/statm")
    before = int(statm.read_text().split()[1]) * resource.getpagesize() / 2**20 if statm.exists() else 0  # which the child begins with
    child = os.fork()
    if child == 0:
        resource.setrlimit(resource.RLIMIT_CPU, (60, 60))
        try:
            said = "true" if checker.check(document).ok else "false"
        except checker.TooMuch as error:
            said = f"too much: {error}"
        except checker.FormatError:
            said = "malformed"
        except BaseException as error:
            said = f"crash: {error!r}"
        os.write(writing, said.encode()[:4000])
        os._exit(0)
    os.close(writing)
    with os.fdopen(reading, "rb") as stream:
        said = stream.read().decode()
    _, _, usage = os.wait4(child, 0)
    return said, usage.ru_utime + usage.ru_stime, usage.ru_maxrss / 1024 - before


@pytest.mark.parametrize("seeds", [range(start, start + 20) for start in range(0, DOCUMENTS, 20)], ids=str)
def test_hostile_documents_are_done_with_soon(seeds: range) -> None:
    for seed in seeds:
        document = hostile(seed)
        assert len(document) < 1_000_000
        said, seconds, megabytes = measured(document)
        name = FAMILIES[seed % len(FAMILIES)].__name__
        print(f"{seed} {name} {len(document)} bytes: {seconds:.1f} s, {megabytes:.0f} MB, {said[:60]}", file=sys.stderr)
        assert said in ("false", "malformed", "true") or said.startswith("too much"), (seed, name, said)
        assert seconds < SECONDS and megabytes < MEGABYTES, (seed, name, said)


def _generic(size: int, seed: int) -> Mechanism:
    numbers = np.random.default_rng(seed).integers(1, 20, (size, size)).tolist()
    return Mechanism.from_array([[F(v, sum(row)) for v in row] for row in numbers], [f"v{seed}-{i}" for i in range(size)])


def _behind(*factors: Mechanism) -> fa.Result:
    group = fa.Product({f"c{i}": factor for i, factor in enumerate(factors)})
    shares = np.random.default_rng(5).integers(1, 100, (2, len(group.outputs))).tolist()
    array = np.array([[[F(v, 100), F(100 - v, 100)] for v in row] for row in shares], dtype=object)
    columns = Columns("u", tuple(f"c{i}" for i in range(len(factors))), ("x",))
    law = fa.Law.from_array(array, decisions=["yes", "no"], groups=group.outputs, contexts=["p", "q"], columns=columns)
    return fa.certify(Policy(law).behind(group=group), {"yes": 1, "no": "1/3"}, all_bounds=True)


def test_two_generic_filters_are_certified_and_checked_in_seconds() -> None:
    start = time.process_time()
    result = _behind(_generic(9, 1), _generic(9, 2))
    assert {"T1", "T3", "T4"} <= {claim.by for claim in result.claims}
    assert checker.check(result.certificate.text.encode()).ok
    assert time.process_time() - start < 20


def test_the_writer_leaves_out_what_the_checker_would_refuse() -> None:
    result = _behind(_generic(24, 1), _generic(24, 2))
    assert not {"T1", "T4"} & {claim.by for claim in result.claims}
    assert any("joint likelihood ratios" in note for note in result.notes)
    document = result.certificate.document
    report = checker.check(result.certificate.text.encode())
    assert report.ok
    floored = {"quantity": "local_ratio", "relation": "<=", "value": "99", "scope": "this law", "by": "T1"}
    fresh = next(claim["assumptions"] for claim in document["claims"])
    document["claims"].append(floored | {"assumptions": fresh, "evidence": {"multipliers": ["1"]}})
    said, seconds, megabytes = measured(result.certificate.text.encode())
    assert said.startswith("too much") and "500000 joint likelihood ratios" in said
    assert seconds < SECONDS and megabytes < MEGABYTES


def test_a_refusal_names_the_limit_and_the_part() -> None:
    said, _, _ = measured(hostile(next(i for i, family in enumerate(FAMILIES) if family.__name__ == "streams")))
    assert said == "too much: intervals.local takes more than the steps of a document of 1 MB"


def test_thousands_of_groups_in_one_context_are_within_the_work() -> None:
    """Of means of single cells the outermost ends decide; nobody compares all pairs."""
    yes = np.random.default_rng(3).binomial(200, 0.5, 5_000)
    law = fa.Law.from_array(np.stack([200 - yes, yes], axis=-1)[None], kind="counts", decisions=["no", "yes"])
    certificate = fa.certify(law, {"yes": 1}).certificate
    document = json.loads(certificate.text)
    assert document["intervals"]["local"]["ratio"][1] != "inf"
    assert checker.check(certificate.text.encode()).ok
    numerator, _, denominator = document["intervals"]["local"]["ratio"][1].partition("/")
    document["intervals"]["local"]["ratio"][1] = str(F(int(numerator) * 999, int(denominator or 1) * 1000))
    assert not checker.check(json.dumps(document).encode()).ok
