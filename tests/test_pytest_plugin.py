"""The fixture that users' tests take: a gate that is kept, exceeded, not settled, or has no target."""

from __future__ import annotations

from pathlib import Path


def test_the_pytest_fixture(tmp_path: Path) -> None:
    """A real pytest run, with one gate that is kept, one that is exceeded, one that is not settled and one without a target."""
    import subprocess
    import sys

    (tmp_path / "test_gate.py").write_text(
        "import fairaudit as fa\n"
        "def law(f, m):\n"
        "    table = {'u': ['yes', 'no'] * 2, 'a': ['f', 'f', 'm', 'm'], 'n': [f, 4000 - f, m, 4000 - m]}\n"
        "    return fa.Law.from_counts(table, decision='u', group='a', count='n')\n"
        "def test_kept(fairness_gate):\n"
        "    assert fairness_gate(law(2000, 2000), {'yes': 1}, max_local_ratio='5/4').verdict == 'within'\n"
        "def test_exceeded(fairness_gate):\n    fairness_gate(law(2000, 1000), {'yes': 1}, max_local_ratio='5/4')\n"
        "def test_open(fairness_gate):\n    fairness_gate(law(2000, 1650), {'yes': 1}, max_local_ratio='5/4')\n"
        "def test_none(fairness_gate):\n    fairness_gate(law(2000, 2000), {'yes': 1})\n"
    )
    words = [sys.executable, "-m", "pytest", "-p", "no:cacheprovider", "-q", "-rf", str(tmp_path), "-c", "/dev/null"]
    done = subprocess.run(words, capture_output=True, text=True, cwd=tmp_path, check=False)
    assert "3 failed, 1 passed" in done.stdout
    for words_said in ("EXCEEDS", "INCONCLUSIVE", "the fairness gate has no target"):
        assert words_said in done.stdout
