"""Audit files say what the options of a table say."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from fairaudit.audits.audit_file import read_audit
from fairaudit.cli import main
from fairaudit.errors import InputError
from fairaudit.model.policy import Deployment

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


FILTERED = (
    '[policy]\ntable = "policy.csv"\ndecision = "u"\ngroup = "g"\ncount = "n"\nmissing = "drop"\n[filter.group]\n{filter}\n'
    "[utility]\nvalues = {{ yes = 1 }}\n"
)
RESPONSE = 'kind = "randomized-response"\nkeep_probability = "3/4"\n'
PRODUCT = f'kind = "product"\n{{more}}\n[filter.group.g]\n{RESPONSE}'


@pytest.mark.parametrize("filters", [RESPONSE + "{more}", PRODUCT])
@pytest.mark.parametrize(("more", "releases"), [("", 1), ("releases = 1", 1), ("releases = 20", 20), ("releases = 10000", 10_000)])
def test_how_many_releases_one_memory_sees(folder: Path, filters: str, more: str, releases: int) -> None:
    (folder / "audit.toml").write_text(FILTERED.format(filter=filters.format(more=more)))
    subject = read_audit(str(folder / "audit.toml")).subject
    assert isinstance(subject, Deployment) and subject.releases == releases


@pytest.mark.parametrize("value", ["0", "-3", "10001", "2.0", '"20"', "true", "[2]"])
def test_a_number_of_releases_that_is_none_is_refused(folder: Path, value: str) -> None:
    (folder / "audit.toml").write_text(FILTERED.format(filter=f"{RESPONSE}releases = {value}"))
    with pytest.raises(
        InputError, match=r"audit.toml: \[filter.group\]: the number of releases is .*; a whole number from 1 to 10000 is acc"
    ):
        read_audit(str(folder / "audit.toml"))


def test_releases_of_the_context_are_not_counted(folder: Path) -> None:
    context = '[filter.context]\nkind = "identity"\nreleases = 2\n'
    (folder / "audit.toml").write_text(FILTERED.format(filter=RESPONSE) + context)
    with pytest.raises(InputError, match=r"\[filter.context\]"):
        read_audit(str(folder / "audit.toml"))


def test_a_column_may_be_named_like_the_key(folder: Path) -> None:
    (folder / "policy.csv").write_text("u,releases,n\nyes,f,3\nno,f,1\nyes,m,2\nno,m,2\n")
    text = FILTERED.replace('"g"', '"releases"').format(filter=PRODUCT.format(more="").replace("group.g", "group.releases"))
    (folder / "audit.toml").write_text(text)
    subject = read_audit(str(folder / "audit.toml")).subject
    assert isinstance(subject, Deployment) and subject.releases == 1 and subject.groups == (("f",), ("m",))


def test_a_filter_is_looked_for_that_is_released_once(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (folder / "audit.toml").write_text(
        POLICY.format(more='missing = "drop"').replace('kind = "identity"', 'kind = "identity"\nreleases = 20')
    )
    assert main(["calibrate", str(folder / "audit.toml"), "--max-ratio", "2"]) == 2
    assert "[filter.group] releases is 20" in capsys.readouterr().err


def test_a_utility_table_names_every_column_that_the_policy_has(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    text = POLICY.format(more='missing = "drop"').replace("values = { yes = 1 }", 'table = "worth.csv"')
    (folder / "audit.toml").write_text(text)
    (folder / "worth.csv").write_text("u,utility\nyes,1\nno,0\n")
    assert main(["certify", str(folder / "audit.toml")]) == 2
    assert "[utility]: its table has no column 'g'; known: 'u', 'utility'" in capsys.readouterr().err
    (folder / "worth.csv").write_text("u,g,utility\nyes,f,1\nno,f,0\nyes,m,2\nno,m,0\n")
    assert main(["certify", str(folder / "audit.toml")]) == 0


def test_groups_that_the_filter_does_not_know_are_said_to_be_left_out(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    text = POLICY.format(more='missing = "group"').replace('"identity"', '"identity"\nvalues = ["f", "m"]')
    (folder / "audit.toml").write_text(text)
    assert main(["certify", str(folder / "audit.toml"), "--confidence", "none"]) == 0
    assert "of the policy: no value of the group filter, and left out of all figures" in capsys.readouterr().err
    (folder / "audit.toml").write_text(POLICY.format(more='missing = "group"'))
    assert main(["certify", str(folder / "audit.toml"), "--confidence", "none"]) == 0
    assert "left out of all figures" not in capsys.readouterr().err
