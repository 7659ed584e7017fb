"""What is written does not replace what is read, and a name that cannot be written is refused first."""

from __future__ import annotations

import json
import os
import sqlite3
import subprocess
import sys
import time
from pathlib import Path

import needs
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
    (tmp_path / "audit_of_json.toml").write_text(
        '[law]\ntable = "c.table.json"\nmap = "names.json"\ndecision = "u"\ngroup = "g"\n[utility]\nvalues = { yes = 1 }\n'
    )
    (tmp_path / "log.csv").write_text("u,g\nyes,f\nno,f\nyes,m\nno,m\n")
    for name in ("c.table.json", "rows.table.jsonl"):
        (tmp_path / name).write_text('{"u": "yes", "g": "f"}\n{"u": "no", "g": "m"}\n')
    (tmp_path / "names.json").write_text('[u]\n"no" = "nein"\n')
    words = ["--decision", "u", "--group", "g", "--utility", "yes", "--no-table", "-o", str(tmp_path / "c.json")]
    assert main(["certify", str(tmp_path / "log.csv"), *words]) == 0
    return tmp_path


@pytest.mark.parametrize(
    ("command", "name", "said"),
    [
        ("certify log.csv --decision u --group g --utility yes -o {}", "log.csv", "is the table itself"),
        ("worst-case log.csv --decision u --group g --tau 0.2 -o {}", "log.csv", "is the table itself"),
        ("certify audit_of_json.toml -o {}", "c.table.json", "is a file that the audit file names, itself"),
        ("certify audit_of_json.toml -o {}", "names.json", "is a file that the audit file names, itself"),
        ("design audit.toml --max-ratio 5/4 -o {}", "policy.csv", "is a file that the audit file names, itself"),
        ("certify log.csv --decision u --group g --utility yes --placebo c.table.json -o {}", "c.table.json", "is the table of --placebo"),
        ("report c.json -o {}", "c.json", "is the certificate itself"),
        ("report c.json --table c.table.jsonl -o {}", "c.table.jsonl", "is the table itself"),
        ("certify c.table.json --decision u --group g --utility yes -o {}", "c.table.json", "is the table itself"),
        ("certify rows.table.jsonl --decision u --group g --utility yes --no-table -o {}", "rows.json", "rows.table.jsonl is the table"),
        ("certify log.csv --decision u --group g --utility yes --map names.json -o {}", "names.json", "is the file of --map itself"),
        ("certify log.csv --decision u --group g --utility yes -o {}", "c.txt", ".json (the certificate), .html (a page)"),
        ("certify log.csv --decision u --group g --utility yes -o x.html --report {}", "c.docx", "(markdown), and .svg and .png"),
        ("certify log.csv --decision u --group g --utility yes --no-table -o x.json -o {}", "x.svg", "which --no-table keeps back"),
        ("subgroups log.csv --decision u --attributes g --utility yes -o {}", "c.svg", "there is no picture of subgroups"),
        ("report c.json -o x.html --picture {}", "bounds", "--picture bounds goes with -o FILE.svg"),
        ("report c.json --table c.table.jsonl -o {}", "x.svg", "does not hold its table"),
        ("report c.json --format markdown -o {}", "x.svg", "--format markdown does not go with x.svg"),
        ("report c.json --table c.table.jsonl --small 10 -o {}", "x.png", "a picture of the exact figures, which --small withholds"),
        ("report c.json --table c.table.jsonl -o {}", "nowhere/x.png", "there is no directory"),
        ("certify log.csv --decision u --group g --utility yes -o x.json -o x.html --report {}", "./x.html", "is named twice"),
        ("certify log.csv --decision u --group g --utility yes --no-table -o {}", "x.html", "--no-table needs -o FILE.json"),
        ("subgroups log.csv --decision u --attributes g --utility yes -o {}", "c", "has no ending, which does not say what to write"),
        ("worst-case log.csv --decision u --group g --tau 0.2 -o {}", "c.csv", "which does not say what to write"),
        ("report c.json -o {}", "x.json.gz", "ends in '.gz', which does not say what to write"),
        ("report c.json --format markdown -o {}", "x.html", "--format markdown does not go with x.html"),
        ("report c.json -o x.md -o {}", "x.md", "is named twice"),
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


OUTPUTS = ("c.json", "c.html", "c.md", "c.pdf")
AUDIT_LOG = ["certify", "log.csv", "--decision", "u", "--group", "g", "--utility", "yes"]


def files(folder: Path) -> dict[str, bytes]:
    return {path.name: path.read_bytes() for path in folder.iterdir()}


@pytest.fixture
def log(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    if not needs.pango():
        pytest.skip("Pango is not installed")
    pytest.importorskip("weasyprint")
    (tmp_path / "log.csv").write_text("u,g\nyes,f\nno,f\nyes,m\nno,m\n")
    monkeypatch.chdir(tmp_path)
    return tmp_path


def test_each_output_is_what_its_name_ends_in(log: Path) -> None:
    """From one command, from `report` on its certificate, and by `--report`; the certificate comes back from its page."""
    assert main([*AUDIT_LOG, *(word for name in OUTPUTS for word in ("-o", name))]) == 0
    made = files(log)
    assert json.loads(made["c.json"])["verdict"] == "none" and made["c.html"].startswith(b"<!DOCTYPE html>")
    assert made["c.md"].startswith(b"## Fairness audit") and made["c.pdf"].startswith(b"%PDF-")
    assert main(["report", "c.json", *(word for name in ("d.html", "d.md", "d.pdf") for word in ("-o", name))]) == 0
    assert main(["report", "c.html", "-o", "d.json"]) == 0
    assert main([*AUDIT_LOG, "--report", "e.md", "--report", "e.html"]) == 0
    after = files(log)
    assert all(after[name.replace("c", "d", 1)] == made[name] for name in OUTPUTS)
    assert (after["e.md"], after["e.html"]) == (made["c.md"], made["c.html"])


def test_subgroups_choices_and_classes_write_them_too(log: Path) -> None:
    words = [word for name in OUTPUTS for word in ("-o", name)]
    assert main(["subgroups", "log.csv", "--decision", "u", "--attributes", "g", "--utility", "yes", "--min-rows", "1", *words]) == 0
    assert set(OUTPUTS) <= files(log).keys()
    assert main(["worst-case", "log.csv", "--decision", "u", "--group", "g", "--tau", "0.2", *words]) == 0
    (log / "choices.csv").write_text("a,b,won\n" + "x,y,x\ny,x,y\nx,y,y\n" * 5)
    assert main(["certify", "choices.csv", "--slots", "a,b", "--winner", "won", *(word.replace("c.", "w.") for word in words)]) == 0
    assert {"w.json", "w.position.json", "w.position.html", "w.position.md", "w.position.pdf"} <= files(log).keys()
    assert main(["verify", "w.position.html", "--quiet"]) == 0


def test_what_can_be_verified_is_named(log: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main([*AUDIT_LOG, "-o", "page.html", "-o", "certificate.json", "--no-table"]) == 0
    said = " ".join(capsys.readouterr().out.split())
    assert "fairaudit verify certificate.json --table certificate.table.jsonl" in said
    assert main([*AUDIT_LOG, "-o", "page.html"]) == 0
    assert "fairaudit verify page.html" in " ".join(capsys.readouterr().out.split())


def test_files_that_are_there_are_replaced_whole(log: Path) -> None:
    for name in OUTPUTS:
        (log / name).write_text("old")
    (log / "link.json").symlink_to("c.json")
    assert main([*AUDIT_LOG, *(word for name in OUTPUTS[1:] for word in ("-o", name)), "-o", "link.json"]) == 0
    assert (log / "link.json").is_symlink() and not [name for name, content in files(log).items() if content == b"old"]


LIMITED = """
import resource, signal, sys
sys.dont_write_bytecode = True  # a file of it would be cut off, too
from fairaudit.cli import main
signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
resource.setrlimit(resource.RLIMIT_FSIZE, (int(sys.argv[1]), resource.RLIM_INFINITY))
sys.exit(main(sys.argv[2:]))
"""


@needs.POSIX
def test_a_full_disc_leaves_what_was_there(log: Path) -> None:
    """The first file fits, the second does not: neither is written."""
    (log / "c.json").write_text("old")
    before = files(log)
    for limit, outputs in ((20_000, ("-o", "c.json", "-o", "c.html")), (1000, ("-o", "c.json")), (20_000, ("-o", "c.md", "-o", "c.pdf"))):
        done = subprocess.run(
            [sys.executable, "-c", LIMITED, str(limit), *AUDIT_LOG, *outputs], capture_output=True, text=True, check=False
        )
        assert done.returncode == 2 and "cannot be written: " in done.stderr and done.stderr.count("\n") == 1 and not done.stdout
        assert files(log) == before


def test_killed_at_any_moment_leaves_old_files_or_new_ones(log: Path) -> None:
    assert main([*AUDIT_LOG, "-o", "c.json", "-o", "c.html"]) == 0
    whole = files(log)
    run = [sys.executable, "-c", "from fairaudit.cli import main\nwhile True: main(__import__('sys').argv[1:])", *AUDIT_LOG]
    for delay in (0.8, 1.1, 1.37, 1.6):
        with subprocess.Popen([*run, "-o", "c.json", "-o", "c.html"], stdout=subprocess.DEVNULL) as process:
            time.sleep(delay)
            process.kill()
        assert {name: content for name, content in files(log).items() if not name.endswith(".part")} == whole


def test_a_folder_that_cannot_be_written_is_refused_before_the_work(
    log: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    (log / "closed").mkdir()
    monkeypatch.setattr(os, "access", lambda path, _: str(path) != "closed")  # the superuser may write anywhere
    before = files(log / "closed"), {path.name for path in log.iterdir()}
    assert main([*AUDIT_LOG, "-o", "c.html", "-o", "closed/c.json"]) == 2
    assert "closed/c.json cannot be written: nothing may be written in closed" in capsys.readouterr().err
    assert (files(log / "closed"), {path.name for path in log.iterdir()}) == before


def test_two_certificates_are_not_written_into_one_file(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    Path("choices.csv").write_text("a,b,won\nx,y,x\ny,x,x\nx,y,y\ny,x,y\n")
    command = ["certify", "choices.csv", "--slots", "a,b", "--winner", "won", "-o", "c.json"]
    assert main([*command, "-o", "c.position.json"]) == 2
    assert set(files(tmp_path)) == {"choices.csv"}
    assert main(command) == 0 and {"c.json", "c.position.json"} <= set(files(tmp_path))


def test_a_part_of_a_name_in_a_query_names_no_file(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    with sqlite3.connect("log.db") as database:
        database.execute("create table log (u, g)")
        database.executemany("insert into log values (?, ?)", [("yes", "f"), ("no", "f"), ("yes", "m"), ("no", "m")])
    database.close()
    query = "select u, g from log where u <> 'config.json' and u <> 'folder/kept.json'"
    words = ["certify", "sqlite:log.db", "--query", query, "--decision", "u", "--group", "g", "--utility", "yes", "-o"]
    for _ in range(2):
        assert main([*words, "fig.json"]) == 0
    for name in ("config.json", "kept.json"):
        Path(name).write_text("{}")
        assert main([*words, name]) == 2 and Path(name).read_text() == "{}"
        assert "is a file that the query names, itself" in capsys.readouterr().err
