"""What tests build of proofs/, and Coq on what was built."""

from __future__ import annotations

import os
import subprocess
from pathlib import Path

import pytest
import tiers
from needs import coq

PROOFS = Path(__file__).resolve().parents[1] / "proofs"
FOLDERS = {"theories": "Fairaudit", "kernel": "FairauditKernel", "checker": "FairauditChecker"}


def make_proofs(target: str, so_that: str) -> Path:
    """Make a target of the proofs; their folder. Without Coq, say so and skip, or fail where FAIRAUDIT_COQ=1.

    The default tier does not wait for proofs that were never compiled here.
    """
    if not coq():
        what = f"Coq with mathcomp, OCaml or zarith is not on this machine, so that {so_that}: see docs/proofs.md"
        if os.environ.get("FAIRAUDIT_COQ") == "1":
            pytest.fail(what)
        pytest.skip(what)
    if not (tiers.DEEP or os.environ.get("FAIRAUDIT_COQ") == "1" or any(PROOFS.glob("checker/*.vo"))):
        pytest.skip(f"the proofs are not compiled (make -C proofs), so that {so_that}")
    return build(target)


def build(target: str) -> Path:
    """Make a target of the proofs, in one process at a time; their folder."""
    fcntl = pytest.importorskip("fcntl")
    (PROOFS / "build").mkdir(exist_ok=True)
    with (PROOFS / "build" / "lock").open("w") as lock:  # tests may run in several processes
        fcntl.flock(lock, fcntl.LOCK_EX)
        made = subprocess.run(["make", "-C", str(PROOFS), target], capture_output=True, text=True)
    assert made.returncode == 0, made.stdout[-3000:] + made.stderr[-3000:]
    return PROOFS


def run_coq(proofs: Path, file: Path) -> subprocess.CompletedProcess[str]:
    """Compile a file that uses the proofs."""
    paths = [word for part, name in FOLDERS.items() for word in ("-R", str(proofs / part), name)]
    return subprocess.run(["coqc", "-q", *paths, "-w", "none", str(file)], capture_output=True, text=True)
