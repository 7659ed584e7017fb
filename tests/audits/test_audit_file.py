"""Audit files say what the options of a table say."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from fairaudit.cli import main

LAW = '[law]\ntable = "log.csv"\ndecision = "u"\ngroup = "g"\n{more}\n[utility]\nvalues = {{ yes = 1 }}\n'
POLICY = (
    '[policy]\ntable = "policy.csv"\ndecision = "u"\ngroup = "g"\ncount = "n"\n{more}\n[filter.group]\nkind = "identity"\n'
    "[utility]\nvalues = {{ yes = 1 }}\n"
)
TABLE = "u,g\nyes,f\nno,f\nyes,m\nno,m\nyes,\nyes,m\n"


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    (tmp_path / "log.csv").write_text(TABLE)
    (tmp_path / "policy.csv").write_text("u,g,n\nyes,f,3\nno,f,1\nyes,m,2\nno,m,2\nyes,,1\nno,,1\n")
    return tmp_path


@pytest.mark.parametrize("missing", ["drop", "group"])
def test_missing_labels_become_what_the_option_makes_of_them(folder: Path, missing: str) -> None:
    (folder / "audit.toml").write_text(LAW.format(more=f'missing = "{missing}"'))
    words = ["--decision", "u", "--group", "g", "--utility", "yes", "--missing", missing]
    assert main(["certify", str(folder / "log.csv"), *words, "-o", str(folder / "option.json")]) == 0
    assert main(["certify", str(folder / "audit.toml"), "-o", str(folder / "key.json")]) == 0
    found = json.loads((folder / "key.json").read_text())
    assert found == json.loads((folder / "option.json").read_text())
    assert len(found["subject"]["table"]["header"]["groups"]) == {"drop": 2, "group": 3}[missing]


def test_missing_labels_of_a_policy(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    for missing, groups in (("drop", 2), ("group", 3)):
        (folder / "audit.toml").write_text(POLICY.format(more=f'missing = "{missing}"'))
        assert main(["certify", str(folder / "audit.toml"), "--confidence", "none", "-o", str(folder / "c.json")]) == 0
        assert main(["verify", str(folder / "c.json")]) == 0
        assert len(json.loads((folder / "c.json").read_text())["subject"]["table"]["header"]["groups"]) == groups
        assert main(["design", str(folder / "audit.toml"), "--max-ratio", "5/4"]) == 0
    capsys.readouterr()


@pytest.mark.parametrize("text", [LAW, POLICY])
def test_missing_labels_are_refused_unless_the_file_says_otherwise(folder: Path, text: str, capsys: pytest.CaptureFixture[str]) -> None:
    for more, said in (("", "missing=drop"), ('missing = "drpo"', "did you mean 'drop'?"), ("missing = 1", "missing is 1")):
        (folder / "audit.toml").write_text(text.format(more=more))
        assert main(["certify", str(folder / "audit.toml")]) == 2
        out, err = capsys.readouterr()
        assert out == "" and said in err and "audit.toml" in err
    (folder / "audit.toml").write_text(text.format(more=""))
    assert main(["certify", str(folder / "audit.toml"), "--missing", "drop"]) == 2
    assert "the audit file has missing in [law] or [policy]" in capsys.readouterr().err
