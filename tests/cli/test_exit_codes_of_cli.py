"""Each command ends with each exit code that the table of docs/json.md has for it, and with no other."""

from __future__ import annotations

import json
import re
import shlex
from pathlib import Path

import pytest
from attested import statement_of

from fairaudit.cli import CORE, main

PAGE = Path(__file__).resolve().parents[2] / "docs" / "json.md"
COLUMNS = "--decision u --group g --context x --utility yes"
FILES = {
    "log.csv": "u,g,x\n" + "yes,f,a\n" * 30 + "no,f,a\n" * 10 + "yes,m,a\n" * 20 + "no,m,a\n" * 20,
    "fewer.csv": "u,g,x\n" + "yes,f,a\n" * 30 + "no,f,a\n" * 10 + "yes,m,a\n" * 20 + "no,m,a\n" * 20 + "no,z,a\nyes,z,a\n",
    "even.csv": "u,g,x\nyes,f,a\nno,f,a\nyes,m,a\nno,m,a\n",
    "filter.csv": "input,a,b\na,0.7,0.3\nb,0.3,0.7\n",
    "policy.csv": "u,n,a,x,p\n"
    + "".join(f"yes,{n},{a},{x},{p}\nno,{n},{a},{x},{q}\n" for n in "ab" for a in "cd" for x, p, q in (("s", 0.9, 0.1), ("t", 0.1, 0.9))),
    "population.csv": "n,a,x,w\na,c,s,9\na,c,t,1\na,d,s,1\na,d,t,9\nb,c,s,1\nb,c,t,9\nb,d,s,1\nb,d,t,9\n",
    "audit.toml": '[policy]\ntable = "policy.csv"\ndecision = "u"\ngroup = ["n", "a"]\ncontext = "x"\nprobability = "p"\n'
    '[population]\ntable = "population.csv"\nweight = "w"\n'
    '[filter.group]\nkind = "randomized-response"\nkeep_probability = 0.7\n[utility]\nvalues = { yes = 1 }\n',
    "worth.toml": '[policy]\ntable = "one.csv"\ndecision = "u"\ngroup = "g"\nprobability = "p"\n[filter.group]\n'
    'kind = "randomized-response"\nkeep_probability = 0.7\n[utility]\ntable = "worth.csv"\n',
    "one.csv": "u,g,p\nyes,f,0.5\nno,f,0.5\nyes,m,0.5\nno,m,0.5\n",
    "worth.csv": "u,g,utility\nyes,f,1\nyes,m,3\nno,f,1\nno,m,3\n",
    "no.json": "{}",
}

SIGNED = "certificate.json --attestation signed.json"

CASES: dict[str, tuple[str, ...]] = {
    "certify 0": (f"certify log.csv {COLUMNS}",),
    "certify 1": (
        f"certify log.csv {COLUMNS} --max-local-ratio 4/3 --confidence none",
        f"certify log.csv {COLUMNS} --claimed-exp-epsilon 1.0001 --confidence 0.6",
    ),
    "certify 2": ("certify no.csv --decision u --group g --utility yes", "certify log.csv --decison u"),
    "certify 3": (f"certify log.csv {COLUMNS} --max-local-ratio 4/3",),
    "subgroups 0": ("subgroups log.csv --decision u --attributes g --utility yes --confidence none --max-ratio 9",),
    "subgroups 1": ("subgroups log.csv --decision u --attributes g --utility yes --confidence none --max-ratio 1.1",),
    "subgroups 2": ("subgroups log.csv --decision u --attributes other --utility yes",),
    "subgroups 3": ("subgroups log.csv --decision u --attributes g --utility yes --max-ratio 1.4",),
    "worst-case 0": ("worst-case log.csv --decision u --group g --tau 0.3",),
    "worst-case 2": ("worst-case log.csv --decision u --group other",),
    "verify 0": (
        "verify certificate.json",
        "verify within.json --require within",
        "verify page.html",
        "verify certificate.json --attestation signed.json --key key.pub.pem",
    ),
    "verify 1": (
        "verify false.json",
        "verify certificate.json --require within",
        "verify certificate.json false.json apart.json",
        "verify within.json --attestation attestation.json",
    ),
    "verify 2": ("verify no.json", "verify nowhere.json", "verify"),
    "verify 3": ("verify apart.json", f"verify {SIGNED}"),
    "attest 0": ("attest --new-key new.pem", "attest attestation.json --sign-key key.pem"),
    "attest 2": ("attest", "attest --new-key key.pem", "attest no.json --sign-key key.pem"),
    "report 0": ("report certificate.json --format markdown", "report apart.json -o apart.md"),
    "report 1": ("report false.json -o false.md",),
    "report 3": ("report apart.json --small 10 -o apart.md",),
    "report 2": ("report no.json", "report certificate.json -o certificate.txt"),
    "publish 0": (
        "publish certificate.json --rule four-fifths -o published",
        "publish apart.json --table apart.table.jsonl --with-table --rule four-fifths -o apart",
        "publish certificate.json --rule air --control m -o ratios",
    ),
    "publish 1": ("publish false.json --rule four-fifths -o of-false",),
    "publish 2": ("publish no.json --rule four-fifths -o of-none", "publish certificate.json --rule four-fifths -o ."),
    "publish 3": ("publish apart.json --rule four-fifths -o without",),
    "compare 0": ("compare certificate.json certificate.json",),
    "compare 1": ("compare within.json exceeds.json", "compare within.json certificate.json"),
    "compare 2": ("compare certificate.json no.json", "compare certificate.json false.json"),
    "compare 3": ("compare fewer.json certificate.json",),
    "compare --fail-on less-fair 0": ("compare certificate.json certificate.json --fail-on less-fair --margin 1000000",),
    "compare --fail-on less-fair 1": ("compare even.json within.json --fail-on less-fair",),
    "compare --fail-on less-fair 2": (
        "compare certificate.json no.json --fail-on less-fair",
        "compare certificate.json certificate.json --global",
    ),
    "compare --fail-on less-fair 3": ("compare certificate.json certificate.json --fail-on less-fair",),
    "monitor 0": (f"monitor log.csv {COLUMNS}",),
    "monitor 1": (f"monitor log.csv {COLUMNS} --max-local-ratio 1.0001 --window 30 --confidence 0.1",),
    "monitor 2": (f"monitor filter.csv {COLUMNS}",),
    "monitor 3": (f"monitor log.csv {COLUMNS} --max-local-ratio 3/2",),
    "plan 0": ("plan --guess 0.5,0.5 --max-ratio 0.8",),
    "plan 1": ("plan --guess 0.5,0.4 --max-ratio 0.8",),
    "plan 2": ("plan --guess 0.5 --max-ratio 0.8",),
    "inspect 0": ("inspect log.csv",),
    "inspect 2": ("inspect nowhere.csv",),
    "tally 0": ("tally log.csv --decision u --group g --context x -o tally.parquet",),
    "tally 2": ("tally log.csv --decision u --group g -o tally.csv", "tally log.csv --decision u --group g", "tally log.csv -o t.parquet"),
    "privacy 0": ("privacy filter.csv", "privacy filter.csv --releases 1 --tau 0.3 --max-ratio 9"),
    "privacy 1": ("privacy filter.csv --releases 3 --tau 0.1 --max-ratio 1.1",),
    "privacy 2": ("privacy no.json",),
    "calibrate 0": ("calibrate --max-ratio 0.8 --groups 4 --tau 0.3",),
    "calibrate 1": ("calibrate --max-log 0.1 --groups 3 --lipschitz 0.5 --tau 0.2",),
    "calibrate 2": ("calibrate --max-ratio 0 --groups 4",),
    "calibrate 3": ("calibrate audit.toml --max-ratio 5/4 --bound policy --global",),
    "design 0": ("design --groups 3 --max-ratio 0.8",),
    "design 1": ("design worth.toml --max-ratio 2",),
    "design 2": ("design --groups 3 --max-ratio 0",),
    "experiment 0": ("experiment list", "experiment status package-delivery --trials 3 --folder run"),
    "experiment 1": ("experiment certify package-delivery --trials 30 --folder more --max-local-ratio 1.0001 --confidence none",),
    "experiment 2": ("experiment run other",),
    "experiment 3": ("experiment certify package-delivery --trials 30 --folder more --max-local-ratio 3",),
    "navigation 0": ("navigation office office",),
    "navigation 2": ("navigation office log.csv",),
}


def table() -> dict[str, set[int]]:
    """The exit codes of each command, as the page has them."""
    section = PAGE.read_text("utf-8").partition("## Exit codes")[2].partition("\n## ")[0]
    rows = [[cell.strip() for cell in line.strip("|").split("|")] for line in section.splitlines() if line.startswith("| `")]
    return {row[0].strip("`"): {code for code, meaning in enumerate(row[1:]) if meaning} for row in rows}


def ran(command: str) -> int:
    try:
        return main(shlex.split(command))
    except SystemExit as stop:  # of the parser
        return int(str(stop.code))


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    made: Path = tmp_path_factory.mktemp("codes")
    with pytest.MonkeyPatch.context() as patch:
        patch.chdir(made)
        for name, content in FILES.items():
            Path(name).write_text(content)
        ran(f"certify log.csv {COLUMNS} -o certificate.json -o page.html --max-local-ratio 4/3")
        ran(f"certify log.csv {COLUMNS} -o within.json --max-local-ratio 9 --confidence none")
        ran(f"certify log.csv {COLUMNS} -o exceeds.json --max-local-ratio 9/8 --confidence none")
        ran(f"certify fewer.csv {COLUMNS} -o fewer.json --max-local-ratio 4/3")
        ran(f"certify even.csv {COLUMNS} -o even.json --confidence none")
        ran(f"certify log.csv {COLUMNS} -o apart.json --no-table")
        document = json.loads(Path("certificate.json").read_text())
        document["metrics"]["local"]["ratio"] = "2"
        Path("false.json").write_text(json.dumps(document))
        Path("attestation.json").write_text(json.dumps(statement_of(Path("certificate.json"))))
        ran("attest --new-key key.pem")
        ran("attest attestation.json --sign-key key.pem -o signed.json")
        assert ran("experiment run package-delivery --trials 3 --folder run") == 0
        assert ran("experiment run package-delivery --trials 30 --folder more") == 0
    return made


@pytest.mark.parametrize(("code", "command"), [(int(name[-1]), command) for name, commands in CASES.items() for command in commands])
def test_each_command_ends_with_each_code(
    code: int, command: str, folder: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(folder)
    assert ran(command) == code
    out, err = capsys.readouterr()
    if code == 2:
        assert out == "" and err.count("\n") == 1


def test_the_table_has_these_codes_and_no_others() -> None:
    cases: dict[str, set[int]] = {}
    for name in CASES:
        command, _, code = name.rpartition(" ")
        cases.setdefault(command, set()).add(int(code))
    assert table() == cases
    commands = {name.split()[0] for name in table()}
    assert CORE.keys() <= commands and commands - CORE.keys() == {"experiment", "navigation"}


@pytest.mark.parametrize("command", sorted(table()))
def test_the_help_of_each_command_has_its_codes(command: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert ran(f"{command} --help") == 0
    said = " ".join(capsys.readouterr().out.partition("exit codes: ")[2].partition("examples:")[0].split())
    assert {int(code) for code in re.findall(r"(?:^|; )([0-9]) ", said)} == table()[command]
