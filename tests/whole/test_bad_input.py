"""Bad input, end to end: exit code 2, one sentence that says what, where and what would do, and no file left behind."""

from __future__ import annotations

import gzip
import json
import os
import shlex
import subprocess
import sys
import unicodedata
from pathlib import Path

import pytest
from envelopes import result_of
from needs import POSIX

from fairaudit.cli import main

COUNTS = "d,g,x,n\nyes,f,A,3\nno,f,A,1\nyes,m,A,1\nno,m,A,1\n"
PROBABILITIES = "d,g,p\nyes,f,0.75\nno,f,0.25\nyes,m,0.5\nno,m,0.5\n"
STEERING = {"Cc", "Cf", "Cs", "Co", "Zl", "Zp"}


def options(**given: str | None) -> list[str]:
    """Options for `COUNTS`, changed as given; None leaves one out, and "" stands for an option without a value."""
    chosen: dict[str, str | None] = {"decision": "d", "group": "g", "context": "x", "count": "n", "utility": "yes", **given}
    listed = []
    for name, value in chosen.items():
        if value is not None:
            listed.append(f"--{name.replace('_', '-')}" + (f"={value}" if value else ""))
    return listed


def probability(**given: str | None) -> list[str]:
    """Options for `PROBABILITIES`, changed as given."""
    return options(**{"context": None, "count": None, "probability": "p", **given})


def run(*words: object) -> int:
    """Exit code of the command line, in this process."""
    try:
        return main([str(word) for word in words])
    except SystemExit as stop:
        assert isinstance(stop.code, int)
        return stop.code


def unharmed(text: str) -> bool:
    """Whether nothing in a text could steer a terminal or reorder it."""
    return all(c == "\n" or unicodedata.category(c) not in STEERING for c in text)


def files(folder: Path) -> dict[str, int]:
    return {str(path.relative_to(folder)): path.stat().st_size for path in folder.rglob("*")}


class Bench:
    """A folder with a table in it, and the command line to try on it."""

    def __init__(self, folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
        self.folder, self.capsys = folder, capsys
        self.table, self.output = folder / "table.csv", folder / "out.json"

    def write(self, content: str | bytes) -> Path:
        self.table.write_bytes(content if isinstance(content, bytes) else content.encode("utf-8"))
        return self.table

    def refused(self, *words: object) -> str:
        """Run a command that must be refused; the sentence."""
        before = files(self.folder)
        code = run(*words)
        out, err = self.capsys.readouterr()
        assert code == 2, (code, out, err)
        assert out == ""
        assert err.startswith("fairaudit")
        assert err.endswith("\n") and err.count("\n") == 1 and len(err.splitlines()) == 1, err
        assert "Traceback" not in err
        assert unharmed(err)
        assert len(err) < 3_000
        assert files(self.folder) == before
        return err

    def certify_refused(self, content: str | bytes, given: list[str]) -> str:
        return self.refused("certify", self.write(content), "-o", self.output, *given)

    def certify(self, content: str | bytes, given: list[str], code: int = 0) -> tuple[dict, str, str]:
        """Run a command that must succeed; the certificate, which verifies, and what was printed."""
        got = run("certify", self.write(content), "-o", self.output, *given)
        out, err = self.capsys.readouterr()
        assert got == code, (got, out, err)
        assert all(line.startswith("note: ") for line in err.splitlines()), err
        assert unharmed(out) and unharmed(err)
        assert run("verify", self.output) == 0
        said, complaints = self.capsys.readouterr()
        assert "statements are true of the table" in said and complaints == ""
        assert unharmed(said)
        return json.loads(self.output.read_text("ascii")), out, err


@pytest.fixture
def bench(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> Bench:
    return Bench(tmp_path, capsys)


def test_the_base_tables_are_good(bench: Bench) -> None:
    document, out, err = bench.certify(COUNTS, [*options(), "--verbose"])
    assert document["metrics"]["local"]["ratio"] == "3/2"
    assert "g=f is favoured over g=m" in out and err == ""
    document, _, _ = bench.certify(PROBABILITIES, probability())
    assert document["metrics"]["local"]["ratio"] == "3/2"


def counted(number: str) -> str:
    return COUNTS.replace("no,f,A,1", f"no,f,A,{number}")


def likely(text: str) -> str:
    return PROBABILITIES.replace("no,m,0.5", f"no,m,{text}")


ROLES = [
    ("missing decision", options(decision="dd"), ["table.csv", "no column 'dd'", "'d', 'g', 'x', 'n'", "did you mean 'd'?"]),
    ("missing group", options(group="Gg"), ["no column 'Gg'", "known: 'd', 'g', 'x', 'n'"]),
    ("missing context", options(context="x,y"), ["no column 'y'"]),
    ("missing count", options(count="nn"), ["no column 'nn'", "did you mean 'n'?"]),
    ("empty count", [*options(count=None), "--count", ""], ["no column ''", "known:"]),
    ("trailing comma", options(group="g,"), ["no column ''", "known:"]),
    ("no decision", options(decision=None), ["no decision column", "--decision COL"]),
    ("no group", options(group=None), ["no group column", "--group COL"]),
    ("blank group", [*options(group=None), "--group", ""], ["no group column", "--group COL"]),
    ("group with a line break", options(group="g\nx"), [r"'g\nx' is not a list of column names", "commas"]),
    ("group not closed", options(group='"g'), ["is not a list of column names", "quote"]),
    ("two roles", options(context="g"), ["column 'g' is used twice", "one role"]),
    ("group twice", options(group="g,g"), ["column 'g' is used twice"]),
    ("decision as count", options(count="d"), ["column 'd' is used twice"]),
    ("utility column as count", options(utility=None, utility_column="n"), ["column 'n' is used twice", "one role"]),
    ("utility column as group", options(utility=None, utility_column="g"), ["column 'g' is used twice", "one role"]),
    ("utility column as context", options(utility=None, utility_column="x"), ["column 'x' is used twice", "one role"]),
    ("weight without probability", options(weight="x"), ["--weight goes with --probability"]),
    ("weight of a log", options(count=None, weight="n"), ["--weight goes with --probability"]),
    ("count and probability", options(probability="n"), ["--probability", "not allowed with argument --count"]),
]

UTILITIES = [
    ("none", options(utility=None), ["no utility was given", "--utility Admitted", "--utility-column COL"]),
    ("both", options(utility_column="n"), ["--utility-column", "not allowed with argument --utility"]),
    ("unknown label", options(utility="yess=1"), ["table.csv", "'yess'", "known: 'yes', 'no'", "did you mean 'yes'?"]),
    ("far from any label", options(utility="Admitted"), ["'Admitted', which does not occur", "known: 'yes', 'no'"]),
    ("no number", options(utility="yes="), ["decision 'yes'", "'' is not a number such as 12, 0.25, 1e-3 or 1/3"]),
    ("no label", options(utility="=1"), ["--utility '=1' has an empty label"]),
    ("quoted nothing", options(utility='""=1'), ["has an empty label"]),
    ("word for a number", options(utility="yes=x"), ["decision 'yes'", "'x' is not a number such as"]),
    ("two numbers", options(utility="yes=1=2"), ["decision 'yes'", "'1=2' is not a number"]),
    ("negative", options(utility="yes=-1"), ["decision 'yes' is negative", "at least 0"]),
    ("infinite", options(utility="yes=inf"), ["'inf' is not a number"]),
    ("empty", [*options(utility=None), "--utility", ""], ["--utility is empty", "yes=1,maybe=0.5"]),
    ("blank", options(utility="  "), ["--utility is empty"]),
    ("comma in front", options(utility=",yes"), ["--utility ',yes' has an empty label"]),
    ("two commas", options(utility="yes=1,,no=1"), ["has an empty label"]),
    ("twice", options(utility="yes=1,no=1,yes=2"), ["lists 'yes' twice", "once"]),
    ("twice, quoted", options(utility='yes=1,"yes"'), ["lists 'yes' twice"]),
    ("not closed", options(utility='"yes=1'), ["has a quotation mark that is not closed"]),
    ("rest after the quote", options(utility='"yes"x=1'), ["is not of the form decision[=number],…", "near 'x=1'"]),
    ("utility column absent", options(utility=None, utility_column="worth"), ["no column 'worth'", "known:"]),
    ("utility column of words", options(utility=None, utility_column="d", decision=None), ["'d', line 2", "'yes' is not a number"]),
]

TARGETS = [
    ("below parity", options(max_local_ratio="0", confidence="none"), ["max_local_ratio is '0'", "a ratio above 0", "0.8 is 5/4"]),
    ("negative log", options(max_local_log="-1", confidence="none"), ["max_local_log is '-1'", "at least 0"]),
    ("nan", options(max_local_log="nan", confidence="none"), ["max_local_log: 'nan' is not a number such as 12, 0.25"]),
    ("inf", options(max_global_ratio="inf", confidence="none"), ["max_global_ratio: 'inf' is not a number"]),
    ("word", options(max_global_log="little", confidence="none"), ["max_global_log: 'little' is not a number"]),
    ("divided by zero", options(max_local_ratio="5/0", confidence="none"), ["'5/0' divides by zero"]),
    ("confidence", options(max_local_log="1", confidence="1"), ["--confidence '1' is not accepted", "between 0 and 1", "'none'"]),
    ("negative confidence", options(confidence="-0.5"), ["--confidence '-0.5' is not accepted", "between 0 and 1"]),
    ("confidence alone", options(confidence="nothing"), ["--confidence 'nothing' is not accepted", "'none'"]),
    ("placebo and no interval", options(confidence="none", placebo="x.csv"), ["--placebo is about the population", "--confidence none"]),
    ("no placebo", options(placebo="absent.csv"), ["the placebo: absent.csv: there is no such file"]),
    ("group of no placebo", options(placebo_group="g"), ["--placebo-group goes with --placebo"]),
    ("range", options(utility_range="1"), ["--utility-range '1' is not of the form LOW,HIGH"]),
    ("range below the utility", options(utility_range="0,0.5"), ["the declared gamma is '0.5', but the table has 1"]),
    ("claimed epsilon", options(claimed_exp_epsilon="1/2"), ["e^ε = '1/2' is not accepted", "at least 1"]),
    ("unit of counts", options(unit="g"), ["--unit goes with a log"]),
]

USAGE = [
    ("top 0", options(top="0"), ["--top", "'0' is not a whole number from 1 to 10000"]),
    ("top abc", options(top="abc"), ["--top", "'abc' is not a whole number from 1 to 10000"]),
    ("top -1", options(top="-1"), ["--top", "'-1' is not a whole number"]),
    ("top 10001", options(top="10001"), ["--top", "'10001' is not a whole number"]),
    ("top in Arabic digits", options(top="٣"), ["--top", "is not a whole number"]),
    ("top with many zeros", options(top="0" * 4 + "10000" + "1"), ["--top", "is not a whole number"]),
    ("top of 5,000 digits", options(top="0000100000" + "0" * 5000), ["--top", "is not a whole number"]),
    ("unknown option", [*options(), "--colour"], ["unrecognized arguments: --colour", "--help"]),
    ("unknown option with an escape", [*options(), "--\x1b[31mred"], ["unrecognized arguments: --\\x1b[31mred"]),
    ("abbreviation", [*options(decision=None), "--decis", "d"], ["unrecognized arguments: --decis d; did you mean --decision?"]),
    ("abbreviation of a target", options(max_local_r="2"), ["unrecognized arguments: --max-local-r=2"]),
    ("second table", [*options(), "again.csv"], ["unrecognized arguments: again.csv"]),
    ("format", options(format="xml"), ["--format", "'xml'", "'text', 'json'"]),
    ("missing", options(missing="ignore"), ["--missing", "'ignore'", "'error', 'drop', 'group'"]),
    ("option without value", [*options(), "--max-local-log"], ["--max-local-log", "expected one argument"]),
    ("table and example", [*options(), "--example", "ucb-admissions"], ["both a table and --example", "give one"]),
]


@pytest.mark.parametrize(("given", "words"), [pytest.param(g, w, id=i) for i, g, w in ROLES + UTILITIES + TARGETS + USAGE])
def test_options(bench: Bench, given: list[str], words: list[str]) -> None:
    said = bench.certify_refused(COUNTS, given)
    for word in words:
        assert word in said


NUMBERS = [
    ("-1", "'-1' is negative"),
    ("-1/3", "'-1/3' is negative"),
    ("many", "'many' is not a number such as 12, 0.25, 1e-3 or 1/3"),
    ("", "the number is missing"),
    ("  ", "the number is missing"),
    ("NaN", "'NaN' is not a number"),
    ("nan", "'nan' is not a number"),
    ("inf", "'inf' is not a number"),
    ("Infinity", "'Infinity' is not a number"),
    ("1e400000", "more than 4000 digits or an exponent beyond ±4000"),
    ("1e5000", "exponent beyond ±4000"),
    ("1e-5000", "exponent beyond ±4000"),
    ("1e9999999999999999999", "exponent beyond ±4000"),
    ("1/0", "'1/0' divides by zero"),
    ("0/0", "'0/0' divides by zero"),
    ("0x10", "'0x10' is not a number"),
    ("1_000", "'1_000' is not a number"),
    ("1 000", "'1 000' is not a number"),
    ('"1,000"', "'1,000' may have a decimal comma or a thousands separator"),
    ("٣", "'٣' is not a number"),
    ("３", "'３' is not a number"),
    ("½", "'½' is not a number"),
    ("7" * 5000, "more than 4000 digits"),
    ("1/" + "7" * 5000, "more than 4000 digits"),
    ("7" * 9000, "a number of 9000 characters is too long; at most 4000 digits"),
    ("1/2/3", "'1/2/3' is not a number"),
    ("1.5/2", "'1.5/2' is not a number"),
    ("--1", "'--1' is not a number"),
    (".", "'.' is not a number"),
    ("e5", "'e5' is not a number"),
    ("3\x1b[2J", r"'3\x1b[2J' is not a number"),
    ("3\u202e", r"'3\u202e' is not a number"),
]


@pytest.mark.parametrize(("number", "words"), NUMBERS, ids=[number[:12].encode("unicode_escape").decode() for number, _ in NUMBERS])
def test_counts(bench: Bench, number: str, words: str) -> None:
    said = bench.certify_refused(counted(number), options())
    assert "table.csv: column 'n', line 3: " in said
    assert words in said


@pytest.mark.parametrize(
    "number", ["0", "1e0", "+1", " 1 ", "1/3", ".5", "2.", "1e-4000", "1e3950", "1e4000", "9" * 4000, "1/" + "9" * 4000]
)
def test_unusual_counts_that_are_good(bench: Bench, number: str) -> None:
    document, _, err = bench.certify(counted(number), options())
    assert err == "" or err.startswith("note: no interval is claimed: ")
    assert ("no interval" in err) == ("intervals" not in document)
    assert document["verdict"] == "none"


@pytest.mark.parametrize("number", ["-0.1", "x", "nan", "1e5000"])
def test_probabilities_name_the_cell(bench: Bench, number: str) -> None:
    said = bench.certify_refused(likely(number), probability())
    assert "table.csv: column 'p', line 5: " in said
    assert number in said


@pytest.mark.parametrize(
    ("last", "total"), [("0.6", "1.1"), ("0.4", "0.9"), ("0.500002", "1.000002"), ("0.49999899", "0.99999899"), ("0", "0.5")]
)
def test_sums_that_are_off(bench: Bench, last: str, total: str) -> None:
    said = bench.certify_refused(likely(last), probability())
    assert f"the probabilities of g='m' sum to {total}; they must sum to 1 within 1e-6" in said


@pytest.mark.parametrize("last", ["0.500001", "0.499999", "0.5000003"])
def test_small_residues_are_noted(bench: Bench, last: str) -> None:
    _, _, err = bench.certify(likely(last), probability())
    assert err.startswith("note: rows were normalised exactly; the largest sum is off 1 by ")


def test_a_probability_given_twice(bench: Bench) -> None:
    said = bench.certify_refused(PROBABILITIES + "\nyes,f,0.75\n", probability())
    assert "line 7: the probability of d='yes', g='f' was given before, on line 2; each combination has one row" in said


def weighted(*weights: str) -> str:
    lines = PROBABILITIES.splitlines()
    return "\n".join(f"{line},{weight}" for line, weight in zip(lines, ("w", *weights), strict=True)) + "\n"


@pytest.mark.parametrize(
    ("weights", "words"),
    [
        (("1", "2", "1", "1"), ["column 'w', line ", "the mass '", "differs from that on other rows of the same context and group"]),
        (("0", "0", "0", "0"), ["column 'w'", "every mass is zero", "at least one must be positive"]),
        (("1", "1", "-1", "-1"), ["column 'w', line 4", "'-1' is negative"]),
        (("1", "1", "", ""), ["column 'w', line 4", "the number is missing"]),
        (("1", "1", "half", "half"), ["column 'w', line 4", "'half' is not a number"]),
    ],
)
def test_weights(bench: Bench, weights: tuple[str, ...], words: list[str]) -> None:
    said = bench.certify_refused(weighted(*weights), probability(weight="w"))
    for word in words:
        assert word in said


def test_weights_that_are_good(bench: Bench) -> None:
    document, _, _ = bench.certify(weighted("1", "2/2", "0.5", "5e-1"), probability(weight="w"))
    assert document["subject"]["population"] == "weights"


@pytest.mark.parametrize(
    ("content", "words"),
    [
        ("", ["the file is empty", "a header line and at least one row"]),
        ("\n\r\n \n", ["the file is empty"]),
        (b"\xef\xbb\xbf", ["the file is empty"]),
        ("d,g,x,n\n", ["a header line but no rows"]),
        ("d,g,x,n", ["a header line but no rows"]),
        ("d,g,x,n\n\n\n", ["a header line but no rows"]),
        ("d,g,x,n\nyes,f,A,3\nno,f,A,1\n", ["only one group", "'f'", "at least two"]),
        ("d,g,x,n\nyes,f,A,0\nno,m,A,0\n", ["every count is zero"]),
        ("d,g,d,n\nyes,f,A,3\n", ["no column 'd'", "'d (column 1)'", "'d (column 3)'"]),
        ("d,d,d (column 2),n\nyes,f,A,3\n", ["column name 'd (column 2)' occurs twice in the header line", "its own name"]),
        ("d,g,,n\nyes,f,A,3\n", ["no column 'x'", "'column 3'"]),
        ("d,g,x, \nyes,f,A,3\n", ["no column 'n'", "'column 4'"]),
        ("Decisions of 2024\n\nd,g,x,n\nyes,f,A,3\n", ["line 1 has 'Decisions of 2024'", "looks like a title", "--skip 2"]),
        ("d,g,x,n\nyes,f,A,3\nno,f,A\n", ["line 3 has 3 cells where the header has 4"]),
        ("d,g,x,n\nyes,f,A,3\n\nno,f,A,1,2\n", ["line 4 has 5 cells where the header has 4"]),
        ("d,g,x,n\nyes,f,A,3\nno\n", ["line 3 has 1 cell where the header has 4"]),
        ('d,g,x,n\n"yes\nor so",f,A,3\nno,f,A\n', ["line 4 has 3 cells where the header has 4"]),
        ('d,g,x,n\nyes,f,A,3\n"no,f,A,1\n', ["a quoted cell is not closed before the end of the file"]),
        ('d,g,x,n\nyes,f,A,3\n"no"t,f,A,1\n', ["line 3: text follows the end of a quoted cell", "double the quotation marks"]),
        (b"d,g,x,n\r\nyes,f,A,3\r\nn\xe9,f,A,1\r\n", ["line 3 is not UTF-8 (byte 0xe9)", "save the file as UTF-8"]),
        (b"d,g,x,n\ryes,f,A,3\rn\xe9,f,A,1\r", ["line 3 is not UTF-8"]),
        (b"d,g,x,n\nyes,f,A,3\nno,\xed\xa0\x80,A,1\n", ["line 3 is not UTF-8"]),
        (COUNTS.encode("utf-16")[:-1], ["begins like UTF-16 and is none", "save it as UTF-8"]),
        (b"\xfe\xff" + COUNTS.encode("utf-16-be")[:-1], ["begins like UTF-16"]),
        (COUNTS.encode("utf-16-le"), ["line 1 has a NUL character"]),
        (COUNTS.replace("no,f", "no,\x00f"), ["line 3 has a NUL character", "a text file"]),
        (gzip.compress(COUNTS.encode())[:-12], ["the compressed file is damaged"]),
        (b"PK\x03\x04" + bytes(100), ["the archive cannot be unpacked"]),
        (b"PAR1" + bytes(100), ["DuckDB cannot read it", "magic bytes"]),
        (COUNTS.replace("no,f", "n" * 10_000_000 + ",f"), ["line 3: a cell has more than 131,072 characters"]),
        ("d," + "g" * 10_000_000 + "\nyes,f\n", ["line 1: a cell has more than 131,072 characters"]),
    ],
    ids=range(31),
)
def test_files(bench: Bench, content: str | bytes, words: list[str]) -> None:
    said = bench.certify_refused(content, options())
    assert "table.csv: " in said
    for word in words:
        assert word in said


def test_nothing_to_compare(bench: Bench) -> None:
    said = bench.certify_refused("d,g,x,n\nyes,f,A,1\nyes,m,B,0\n", options())
    assert "no two groups can be compared: no context has two groups" in said


def test_inspect_suggests_a_command_that_runs(bench: Bench) -> None:
    header = ["the decision, final", 'sex "A"', " race", "-place", "n"]
    rows = [[u, a, b, x, "2"] for u in ("=yes", "no, sorry") for a in ("f", "m") for b in ("1,5", " 2") for x in ("A", "B")]
    assert run("inspect", bench.write("\n".join(",".join(map(quoted, row)) for row in (header, *rows)) + "\n")) == 0
    out, _ = bench.capsys.readouterr()
    program, command, table, *given = shlex.split(out.splitlines()[-1])
    assert (program, command, table) == ("fairaudit", "certify", str(bench.table))
    document, _, _ = bench.certify(bench.table.read_bytes(), given)
    assert document["subject"]["columns"] == {"decision": header[0], "group": header[1:3], "context": ["-place"]}
    assert document["subject"]["kind"] == "counts" and document["subject"]["table"]["header"]["utility"] == ["1", "0"]


@pytest.mark.parametrize("command", ["certify", "inspect"])
def test_no_file_or_no_regular_one(bench: Bench, command: str) -> None:
    given = options() if command == "certify" else []
    assert f"{bench.folder}: this is a directory; name a " in bench.refused(command, bench.folder, *given)
    assert "absent.csv: there is no such file" in bench.refused(command, bench.folder / "absent.csv", *given)
    assert "the name of the table is empty" in bench.refused(command, "", *given)
    assert "cannot be read" in bench.refused(command, bench.folder / ("a" * 300), *given)
    assert "cannot be read" in bench.refused(command, "a\x00b", *given)
    assert r"\x1b[31mred.csv: there is no such file" in bench.refused(command, "\x1b[31mred.csv", *given)
    bench.write("")
    assert "the file is empty" in bench.refused(command, bench.table, *given)


@pytest.mark.parametrize("column", ["d", "g", "x"])
def test_a_missing_label(bench: Bench, column: str) -> None:
    row = ",".join("" if name == column else value for name, value in zip("dgxn", ("yes", "f", "A", "7"), strict=True))
    content = COUNTS + row + "\n"
    said = bench.certify_refused(content, options())
    assert f"column '{column}', line 6: the label is missing (1 in all)" in said
    assert "missing=drop" in said and "--missing group" in said

    document, _, err = bench.certify(content, options(missing="drop"))
    by_group = "" if column == "g" else "; by group: 'f' 7 of 11"
    assert f"note: 7 of 13 decisions have a missing label and were left out ('{column}': 7{by_group})" in err
    assert document["metrics"]["local"]["ratio"] == "3/2"
    assert document["claims"]
    for claim in document["claims"]:
        assert claim["assumptions"][-1:] == [
            "7 of 13 decisions have a missing label and were left out; they are taken to be no different from the others"
        ]

    document, _, err = bench.certify(content, options(missing="group"))
    assert f"note: 7 decisions without a label in column '{column}' form the level '(missing)'" in err
    header = document["subject"]["table"]["header"]
    assert "(missing)" in json.dumps(header[{"d": "decisions", "g": "groups", "x": "contexts"}[column]])
    assert all(claim["assumptions"] == [] for claim in document["claims"] if claim["scope"] == "this law")


def test_missing_labels_everywhere(bench: Bench) -> None:
    content = "d,g,x,n\n,f,A,3\nno,,A,1\n"
    assert "every row has a missing label" in bench.certify_refused(content, options(missing="drop"))
    taken = COUNTS + "(missing),f,A,1\n,f,A,1\n"
    said = bench.certify_refused(taken, options(missing="group"))
    assert "column 'd' already has a label '(missing)'" in said


@pytest.mark.parametrize(
    "content",
    [
        b"\xef\xbb\xbf" + COUNTS.encode(),
        COUNTS.replace("\n", "\r\n").encode(),
        COUNTS.replace("\n", "\r").encode(),
        b"\n\n" + COUNTS.encode(),
        COUNTS.rstrip("\n").encode(),
        COUNTS.replace("\n", "\n\n").encode(),
        COUNTS.replace("yes", '"yes"').encode(),
    ],
    ids=["BOM", "CRLF", "CR", "blank lines first", "no last line end", "blank lines", "quoted"],
)
def test_files_that_are_good(bench: Bench, content: bytes) -> None:
    document, _, err = bench.certify(content, options())
    assert document["metrics"]["local"]["ratio"] == "3/2"
    assert document["subject"]["columns"] == {"decision": "d", "group": ["g"], "context": ["x"]}
    assert err == ""


def test_line_breaks_in_labels_keep_the_line_numbers(bench: Bench) -> None:
    content = COUNTS.replace("no,f", '"no,\nreally\r\nnot",f')
    document, _, _ = bench.certify(content, options())
    assert document["subject"]["table"]["header"]["decisions"] == ["yes", "no,\nreally\r\nnot", "no"]
    assert "column 'n', line 6: '-1' is negative" in bench.certify_refused(content.replace("yes,m,A,1", "yes,m,A,-1"), options())


def test_other_separators(bench: Bench) -> None:
    semicolons = PROBABILITIES.replace(",", ";").replace(".", ",")
    document, _, err = bench.certify(semicolons, probability())
    assert document["metrics"]["local"]["ratio"] == "3/2"
    assert "note: the columns are separated by semicolons\n" in err
    assert "note: the numbers in column 'p' have decimal commas\n" in err
    document, _, err = bench.certify(COUNTS.replace(",", "\t"), options())
    assert document["metrics"]["local"]["ratio"] == "3/2"
    assert err == "note: the columns are separated by tabs\n"
    _, _, err = bench.certify(COUNTS.replace(",", "|"), options())
    assert err == "note: the columns are separated by bars\n"


@pytest.mark.parametrize(
    ("numbers", "words"),
    [
        (
            ("1,234", "2", "3", "4"),
            ["column 'n', line 2: '1,234' may have a decimal comma or a thousands separator", "thousands=',' (--thousands ,) as 1234"],
        ),
        (("2", "1,234", "3", "12,345,678"), ["column 'n', line 3: '1,234' may have a decimal comma"]),
        (("1,5", "1.5", "3", "4"), ["column 'n', line 3: '1.5' has a decimal point", "'1,5' a comma", "use one of the two"]),
        (("1,234.5", "1", "3", "4"), ["column 'n', line 2: '1,234.5' has a dot and a comma", "--thousands ,"]),
        (("1,2,3", "1,5", "3", "4"), ["column 'n', line 2: '1,2,3' is not a number"]),
        (("1,5", "a,b", "3", "4"), ["column 'n', line 3: 'a,b' is not a number"]),
    ],
)
@pytest.mark.parametrize("separator", [";", "\t"])
def test_commas_in_numbers(bench: Bench, numbers: tuple[str, ...], words: list[str], separator: str) -> None:
    starts = ("d,g,x,n", "yes,f,A", "no,f,A", "yes,m,A", "no,m,A")
    lines = [start.replace(",", separator) for start in starts]
    content = "\n".join([lines[0], *(f"{line}{separator}{n}" for line, n in zip(lines[1:], numbers, strict=True))]) + "\n"
    said = bench.certify_refused(content, options())
    for word in words:
        assert word in said


def test_commas_in_labels_stay(bench: Bench) -> None:
    document, _, err = bench.certify(COUNTS.replace(",", ";").replace("A", "A,1"), options())
    assert document["subject"]["table"]["header"]["contexts"] == [["A,1"]]
    assert err == "note: the columns are separated by semicolons\n"


def test_utility_spec_with_quotes(bench: Bench) -> None:
    content = COUNTS.replace("no", '"no, a=b ""c"""')
    document, _, _ = bench.certify(content, options(utility=' yes = 1 , "no, a=b ""c""" = 1/4,'))
    assert document["subject"]["table"]["header"]["utility"] == ["1", "1/4"]
    document, _, _ = bench.certify(content, options(utility='"no, a=b ""c""",yes=0'))
    assert document["subject"]["table"]["header"]["utility"] == ["0", "1"]


UTILITY_COLUMN = "d,g,v\nyes,f,1\nno,f,0\nyes,m,1/2\nno,m,0.0\n"


def valued(**given: str | None) -> list[str]:
    return options(**{"context": None, "count": None, "utility": None, "utility_column": "v", **given})


def test_utility_column(bench: Bench) -> None:
    document, _, _ = bench.certify(UTILITY_COLUMN, valued())
    assert document["subject"]["utility"]["depends_on_group"] is True
    said = bench.certify_refused(UTILITY_COLUMN + "yes,m,1/3\n", valued())
    assert "column 'v', line 6: the utility '1/3' differs" in said and "leave out the decision column" in said
    assert "column 'v', line 6: '-1' is negative" in bench.certify_refused(UTILITY_COLUMN + "yes,m,-1\n", valued())
    assert "column 'v', line 6: the utility is missing" in bench.certify_refused(UTILITY_COLUMN + "yes,m,\n", valued())
    assert "column 'v', line 6: 'good' is not a number" in bench.certify_refused(UTILITY_COLUMN + "yes,m,good\n", valued())


def test_utility_column_without_decision(bench: Bench) -> None:
    document, _, _ = bench.certify(UTILITY_COLUMN, valued(decision=None))
    header = document["subject"]["table"]["header"]
    assert header["columns"]["decision"] == "v"
    assert dict(zip(header["decisions"], header["utility"], strict=True)) == {"1": "1", "0": "0", "1/2": "1/2", "0.0": "0"}
    said = bench.certify_refused(UTILITY_COLUMN + "yes,m,-1\n", valued(decision=None))
    assert "column 'v', line 6: '-1' is negative" in said


def test_examples_and_no_table(bench: Bench) -> None:
    said = bench.refused("certify", "--example", "ucb-admision", "-o", bench.output)
    assert "no example 'ucb-admision'" in said and "did you mean 'ucb-admissions'?" in said and "'hr-navigation'" in said
    assert "no example ''" in bench.refused("certify", "--example", "", "-o", bench.output)
    said = bench.refused("certify", "-o", bench.output, *options())
    assert "no table was named" in said and "--example ucb-admissions" in said
    assert "ucb-admissions.csv: there is no column 'Sex'" in bench.refused("certify", "--example", "ucb-admissions", "--group", "Sex")


@pytest.mark.parametrize(
    ("words", "said"),
    [
        ((), "COMMAND"),
        (("audit",), "there is no command 'audit'; known: 'certify', 'inspect'"),
        (("certif", "table.csv"), "did you mean 'certify'?; see fairaudit --help"),
        (("--colour",), "COMMAND"),
        (("\x1b[31m",), r"\x1b[31m"),
        (("inspect",), "TABLE"),
        (("inspect", "a.csv", "--decision", "d"), "unrecognized arguments: --decision d; see"),
        (("certify", "a.csv", "--decison", "d"), "unrecognized arguments: --decison d; did you mean --decision?"),
        (("inspect", "a.csv", "--dec\u202eision"), r"unrecognized arguments: --dec\u202eision"),
        (("verify",), "CERTIFICATE.json"),
        (("verify", "a.json", "--require", "exceeds"), "--require"),
        (("verify", "a.json", "--tab", "b"), "unrecognized arguments: --tab b"),
    ],
)
def test_usage(bench: Bench, words: tuple[str, ...], said: str) -> None:
    sentence = bench.refused(*words)
    assert said in sentence
    assert "--help" in sentence


class TestOutput:
    def test_places_that_cannot_be_written(self, bench: Bench) -> None:
        bench.write(COUNTS)
        folder = bench.folder / "taken.json"
        folder.mkdir()
        absent = bench.folder / "absent"
        for more in ((), ("--no-table",)):
            start = ("certify", bench.table, *options(), *more, "-o")
            assert "taken.json is a directory; name a file to write" in bench.refused(*start, folder)
            assert "is a directory" in bench.refused(*start, "")
            assert "/ is a directory" in bench.refused(*start, "/")
            assert f"there is no directory {absent}" in bench.refused(*start, absent / "out.json")
            assert f"there is no directory {bench.table}" in bench.refused(*start, bench.table / "out.json")
            assert "cannot be written: File name too long" in bench.refused(*start, bench.folder / ("a" * 300 + ".json"))

    @pytest.mark.skipif(not Path("/proc/self").is_dir(), reason="needs /proc")
    def test_a_folder_that_takes_no_files(self, bench: Bench) -> None:
        bench.write(COUNTS)
        said = bench.refused("certify", bench.table, *options(), "-o", "/proc/self/fairaudit.json")
        assert "/proc/self/fairaudit.json cannot be written" in said

    @POSIX
    def test_the_table_itself_and_pipes_are_spared(self, bench: Bench) -> None:
        bench.write(COUNTS)
        said = bench.refused("certify", bench.table, *options(), "-o", bench.table)
        assert "is the table itself; name another file to write" in said
        (bench.folder / "link.json").symlink_to(bench.table)
        assert "is the table itself" in bench.refused("certify", bench.table, *options(), "-o", bench.folder / "link.json")
        assert bench.table.read_text() == COUNTS
        pipe = bench.folder / "pipe"
        os.mkfifo(pipe)
        assert "is a device or a pipe" in bench.refused("certify", bench.table, *options(), "-o", pipe)

    def test_no_table_needs_an_output(self, bench: Bench) -> None:
        said = bench.refused("certify", bench.write(COUNTS), *options(), "--no-table")
        assert "--no-table needs -o FILE" in said

    def test_an_old_certificate_survives_a_failure(self, bench: Bench) -> None:
        bench.output.write_text("old")
        bench.certify_refused(counted("x"), options())
        assert bench.output.read_text() == "old"
        bench.certify(COUNTS, options())
        assert set(files(bench.folder)) == {"table.csv", "out.json"}


HOSTILE = {
    "html": "<script>alert(1)</script>&amp;<!--",
    "escape": "\x1b[31mred\x1b[0m\x1b]0;title\x07",
    "c1": "\x9b31mred\x85",
    "bidi": "a\u202eb\u2066c\u2069\u200fd",
    "line breaks": "a\nb\r\nc\u2028d\u2029e\x0bf\x0cg",
    "zero width": "a\u200bb\ufeffc\u00add",
    "tags": "a\U000e0041\U000e007f",
    "private and unassigned": "a\ue000b\U0010fffe\u0378",
    "long": "l" * 10_000,
    "long wide": "語" * 10_000,
    "quotes": "'\"`$(ls);\\",
    "formula": "=1+1",
    "percent": "%s %(prog)s {0}",
    "astral": "\U0001f469\U0001f3fd",
}


def quoted(text: str) -> str:
    return '"' + text.replace('"', '""') + '"'


@pytest.mark.parametrize("label", HOSTILE.values(), ids=HOSTILE.keys())
def test_hostile_labels(bench: Bench, label: str) -> None:
    """Labels are data: in the certificate as they are, on the terminal without what could steer it."""
    rows = [
        (f"{u}{label}", f"{a}{label}", f"{x}{label}", n)
        for u, a, x, n in [("Y", "f", "A", "3"), ("N", "f", "A", "1"), ("Y", "m", "A", "1")]
    ]
    rows += [("N" + label, "m" + label, "A" + label, "1"), ("N" + label, "m" + label, "B" + label, "1")]
    header = ("d" + label, "g" + label, "x" + label, "n" + label)
    content = "\n".join(",".join(map(quoted, row)) for row in (header, *rows)) + "\n"
    given = options(decision=header[0], group=quoted(header[1]), context=quoted(header[2]), count=header[3], utility=quoted("Y" + label))
    document, out, _ = bench.certify(content, [*given, "--top=10"])
    assert document["subject"]["table"]["header"]["groups"] == [["f" + label], ["m" + label]]
    assert document["metrics"]["local"]["ratio"] == "3/2"
    assert "favoured" in out

    assert run("certify", bench.table, *given, "--format=json") == 0
    out, err = bench.capsys.readouterr()
    assert unharmed(out) and out.isascii() and err == ""
    assert result_of(out)["metrics"] == document["metrics"]

    assert run("inspect", bench.table) == 0
    out, err = bench.capsys.readouterr()
    assert unharmed(out) and err == ""
    assert "5 rows, 4 columns" in out

    said = bench.refused("certify", bench.table, *given, "--decision", "other" + label)
    assert "there is no column 'other" in said
    said = bench.refused("certify", bench.table, *given, "--utility", quoted("other" + label))
    assert "which does not occur; known: " in said
    said = bench.certify_refused(content.replace(quoted("3"), quoted(f"-3{label}")), given)
    assert ", line " in said
    assert "is not a number" in said or "is too long" in said


class TestVerify:
    @pytest.fixture
    def good(self, bench: Bench) -> Path:
        bench.certify(COUNTS, options())
        return bench.output

    @pytest.mark.parametrize(
        ("content", "words"),
        [
            (b"", "the file is empty"),
            (b"hello", "the file holds something else"),
            (b"\x1b[31m", "the file holds something else"),
            (b"[]", "the file holds something else"),
            (b"null", "the file holds something else"),
            (b"{}", "format"),
            (b'{"a":' + b"[" * 100_000, "nested too deeply"),
            (b'{"a":' * 100_000, "nested too deeply"),
            (b'{"\xff\xfe": 1}', "not UTF-8"),
            (b"{,}", "not JSON"),
            (b"NaN", ""),
            (b"9" * 10_000, ""),
        ],
        ids=range(12),
    )
    def test_not_a_certificate(self, bench: Bench, content: bytes, words: str) -> None:
        path = bench.folder / "bad.json"
        path.write_bytes(content)
        said = bench.refused("verify", path)
        assert str(path) in said and "fairaudit-certificate/1" in said and words in said

    def test_files(self, bench: Bench, good: Path) -> None:
        assert "absent.json" in bench.refused("verify", bench.folder / "absent.json")
        assert "Is a directory" in bench.refused("verify", bench.folder)
        assert "No such file" in bench.refused("verify", "")
        assert "[31m.json" in bench.refused("verify", "\x1b[31m.json")
        assert "absent.jsonl" in bench.refused("verify", good, "--table", bench.folder / "absent.jsonl")
        assert "Is a directory" in bench.refused("verify", good, "--table", bench.folder)

    def test_tables(self, bench: Bench, good: Path) -> None:
        apart = bench.folder / "apart.json"
        assert run("certify", bench.table, *options(), "--no-table", "-o", apart) == 0
        beside = bench.folder / "apart.table.jsonl"
        bench.capsys.readouterr()

        assert run("verify", apart) == 3
        out, err = bench.capsys.readouterr()
        assert out == "" and "does not embed its table" in err and err.count("\n") == 1

        assert run("verify", apart, "--table", beside) == 0
        assert "are true" in bench.capsys.readouterr().out

        other = bench.folder / "other.table.jsonl"
        other.write_bytes(beside.read_bytes().replace(b'"weights":["3","1"]', b'"weights":["4","1"]'))
        assert run("verify", apart, "--table", other) == 1
        assert "FALSE" in bench.capsys.readouterr().out
        assert run("verify", good, "--table", beside) == 1
        assert "FALSE  the digest of the table file" in bench.capsys.readouterr().out

        for content in (b"", b"{}\n", COUNTS.encode(), b"\xff\n", beside.read_bytes()[:-1], b"[" * 100_000):
            other.write_bytes(content)
            assert "fairaudit: " in bench.refused("verify", apart, "--table", other)

    def test_require(self, bench: Bench, good: Path) -> None:
        assert run("verify", good, "--require", "within") == 1
        assert "'within' is required" in bench.capsys.readouterr().out
        bench.certify(COUNTS, options(max_local_ratio="3/2", confidence="none"))
        assert run("verify", good, "--require", "within") == 0
        bench.certify(COUNTS, options(max_local_ratio="1.499", confidence="none"), code=1)
        assert run("verify", good, "--require", "within") == 1

    def test_a_false_statement(self, bench: Bench, good: Path) -> None:
        good.write_text(good.read_text().replace('"3/2"', '"4/3"'))
        assert run("verify", good) == 1
        assert "FALSE" in bench.capsys.readouterr().out


class TestProcess:
    """The same through a real process: streams, exit codes and what the interpreter adds of its own."""

    def start(self, *words: object, **more: object) -> subprocess.CompletedProcess[bytes]:
        keywords = {"stdout": subprocess.PIPE, "stderr": subprocess.PIPE, **more}
        return subprocess.run([sys.executable, "-m", "fairaudit", *map(str, words)], timeout=60, check=False, **keywords)

    def shell(self, line: str, *words: object) -> subprocess.CompletedProcess[bytes]:
        command = ["bash", "-c", f"set -o pipefail; {line}", sys.executable, "-m", "fairaudit", *map(str, words)]
        return subprocess.run(command, timeout=60, check=False, capture_output=True)

    def test_refused(self, bench: Bench) -> None:
        bench.write(counted("x"))
        for words in (("certify", bench.table, *options()), ("inspect", bench.folder), ("verify", bench.table), ("audit",)):
            done = self.start(*words)
            assert done.returncode == 2
            assert done.stdout == b""
            assert done.stderr.startswith(b"fairaudit") and done.stderr.count(b"\n") == 1

    def test_plain_ascii_streams(self, bench: Bench) -> None:
        environment = {**os.environ, "PYTHONIOENCODING": "ascii", "PYTHONUTF8": "0"}
        done = self.start("certify", bench.write(COUNTS.replace("f,A", "é語,A")), *options(), "--verbose", env=environment)
        assert done.returncode == 0
        assert b"g=\\xe9\\u8a9e is favoured" in done.stdout
        done = self.start("certify", bench.table, *options(group="ü"), env=environment)
        assert done.returncode == 2
        assert b"no column '\\xfc'" in done.stderr

    def test_bytes_that_are_no_text(self, bench: Bench) -> None:
        bench.write(COUNTS)
        for words in ((bench.table, *options(group=None), "--group", b"g\xff"), (b"\xff.csv", *options())):
            command = [
                os.fsencode(sys.executable),
                b"-m",
                b"fairaudit",
                b"certify",
                *(w if isinstance(w, bytes) else os.fsencode(w) for w in words),
            ]
            done = subprocess.run(command, timeout=60, check=False, capture_output=True)
            assert done.returncode == 2
            assert done.stdout == b""
            assert b"\\udcff" in done.stderr and done.stderr.count(b"\n") == 1

    def test_a_reader_that_goes_away_does_not_hide_the_verdict(self, bench: Bench) -> None:
        words = ("certify", bench.write(COUNTS), *options(max_local_ratio="1", confidence="none"))
        for form in ("text", "json"):
            done = self.shell('"$0" "$@" | true', *words, f"--format={form}")
            assert done.returncode == 1
            assert done.stderr == b""

    @pytest.mark.skipif(not Path("/dev/full").exists(), reason="needs /dev/full")
    def test_a_full_disk_is_not_a_verdict(self, bench: Bench) -> None:
        bench.write(COUNTS)
        for words in (("certify", bench.table, *options()), ("inspect", bench.table), ("certify", "--list-examples")):
            done = self.shell('"$0" "$@" >/dev/full', *words)
            assert done.returncode == 2
            assert done.stderr == b"fairaudit: the output cannot be written: No space left on device\n"

    def test_without_standard_output(self, bench: Bench) -> None:
        done = self.shell('"$0" "$@" >&-', "certify", bench.write(COUNTS), *options(max_local_ratio="1", confidence="none"))
        assert done.returncode == 1
        assert done.stderr == b""
