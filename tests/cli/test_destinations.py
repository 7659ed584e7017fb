"""What is written does not replace what is read, and a name that cannot be written is refused first."""

from __future__ import annotations

from pathlib import Path

import pytest

from fairaudit.cli import main

AUDIT = (
    '[policy]\ntable = "policy.csv"\ndecision = "u"\ngroup = "g"\nprobability = "p"\n[filter.group]\nkind = "identity"\n'
    "[utility]\nvalues = { yes = 1 }\n"
)


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    (tmp_path / "policy.csv").write_text("u,g,p\nyes,f,0.9\nno,f,0.1\nyes,m,0.4\nno,m,0.6\n")
    (tmp_path / "audit.toml").write_text(AUDIT)
    (tmp_path / "log.csv").write_text("u,g\nyes,f\nno,f\nyes,m\nno,m\n")
    words = ["--decision", "u", "--group", "g", "--utility", "yes", "--no-table", "-o", str(tmp_path / "c.json")]
    assert main(["certify", str(tmp_path / "log.csv"), *words]) == 0
    return tmp_path


@pytest.mark.parametrize(
    ("command", "name", "said"),
    [
        ("certify log.csv --decision u --group g --utility yes -o {}", "log.csv", "is the table itself"),
        ("worst-case log.csv --decision u --group g --tau 0.2 -o {}", "log.csv", "is the table itself"),
        ("report c.json -o {}", "c.json", "is the certificate itself"),
        ("report c.json --table c.table.jsonl -o {}", "c.table.jsonl", "is the table itself"),
        ("design audit.toml --max-ratio 5/4 -o {}", "audit.toml", "is the audit file itself"),
        ("calibrate audit.toml --max-ratio 5/4 --plot {}", "audit.toml", "is the audit file itself"),
        ("verify --export {}", "nowhere/checker.pyz", "there is no directory"),
        ("design --groups 3 --max-ratio 5/4 -o {}", ".", "is a directory"),
        ("certify log.csv --decision u --group g --utility yes -o {}", "nowhere/c.json", "there is no directory"),
    ],
)
def test_refusals(
    command: str, name: str, said: str, folder: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(folder)
    before = {path.name: path.read_bytes() for path in folder.iterdir()}
    capsys.readouterr()
    assert main(command.format(name).split()) == 2
    out, err = capsys.readouterr()
    assert out == "" and said in err and err.count("\n") == 1
    assert {path.name: path.read_bytes() for path in folder.iterdir()} == before
