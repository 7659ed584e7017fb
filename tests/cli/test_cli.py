"""Every command: its envelope against the schema, its text, its exit code, and what it prints on bad input."""

from __future__ import annotations

import json
import re
import shlex
from collections.abc import Iterator
from contextlib import redirect_stdout
from fractions import Fraction
from io import StringIO
from pathlib import Path

import pytest
from attested import statement_of
from envelopes import ENVELOPE, SCHEMA, envelope, envelopes, result_of
from hypothesis import given
from hypothesis import strategies as st
from jsonschema import Draft202012Validator

from fairaudit.cli import CORE, main, plugins
from fairaudit.words import approximate

ALARM = "--decision u --group g --context x --utility yes --max-local-ratio 1.0001 --window 30 --confidence 0.1"
AUDIT = """
[policy]
table = "policy.csv"
decision = "u"
group = "g"
context = "x"
probability = "p"
[filter.group]
kind = "randomized-response"
keep_probability = 0.7
[utility]
values = { yes = 1 }
[targets]
max_local_ratio = "5/4"
"""
COLUMNS = "--decision u --group g --context x --utility yes"
LINES = {"monitor", "experiment"}
SEVERAL = {"certify": {"allocation", "certify", "examples", "query"}, "verify": {"verify", "export", "coq"}, "attest": {"attest", "key"}}


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Files that commands read, under names that the cases below use."""
    made: Path = tmp_path_factory.mktemp("commands")
    rows = [(u, g, "a") for u, g, n in (("yes", "f", 30), ("no", "f", 10), ("yes", "m", 20), ("no", "m", 20)) for _ in range(n)]
    (made / "log.csv").write_text("u,g,x\n" + "".join(f"{u},{g},{x}\n" for u, g, x in rows))
    (made / "log.jsonl").write_text("".join(json.dumps({"u": u, "g": g, "x": x}) + "\n" for u, g, x in rows))
    (made / "choices.csv").write_text("shown,won\n" + "f m,f\nm f,m\nf m,f\nm f,f\n" * 10)
    (made / "policy.csv").write_text("u,g,x,p\nyes,f,a,0.9\nno,f,a,0.1\nyes,m,a,0.4\nno,m,a,0.6\n")
    (made / "audit.toml").write_text(AUDIT)
    (made / "filter.csv").write_text("input,a,b\na,0.7,0.3\nb,0.3,0.7\n")
    (made / "none.csv").write_text("input,a,b\na,1,0\nb,0,1\n")
    (made / "empty.csv").write_text("")
    (made / "false.json").write_text("{}")
    assert main(["certify", str(made / "log.csv"), *shlex.split(COLUMNS), "-o", str(made / "certificate.json")]) == 0
    assert main(["certify", str(made / "log.csv"), *shlex.split(COLUMNS), "--max-local-ratio", "4/3", "-o", str(made / "new.json")]) == 3
    worst = "--decision u --group g --context x --tau 0.3 --not-blind --lipschitz 0.2"
    assert main(["worst-case", str(made / "log.csv"), *shlex.split(worst), "-o", str(made / "worst.json")]) == 0
    assert main(["attest", "--new-key", str(made / "key.pem")]) == 0
    (made / "attestation.json").write_text(json.dumps(statement_of(made / "certificate.json")))
    text = (made / "certificate.json").read_text()
    (made / "altered.json").write_text(text.replace('"ratio":"3/2"', '"ratio":"2"').replace('"ratio": "3/2"', '"ratio": "2"'))
    assert main(["experiment", "run", "package-delivery", "--trials", "3", "--folder", str(made / "run")]) == 0
    assert main(["navigation", "office", str(made / "office")]) == 0
    return made


GOOD = {
    "certify": (f"certify log.csv {COLUMNS}", 0),
    "certify with targets": (f"certify log.csv {COLUMNS} --max-local-ratio 4/3 --max-global-log 9 --top 1", 3),
    "certify the table": (f"certify log.csv {COLUMNS} --max-local-ratio 4/3 --confidence none", 1),
    "certify a policy": ("certify audit.toml --confidence none", 1),
    "certify with tests": (f"certify log.csv {COLUMNS} --placebo log.csv --claimed-exp-epsilon 9", 0),
    "allocation": ("certify choices.csv --slots shown --winner won --profile-exp-epsilon 7/3", 0),
    "examples": ("certify --list-examples", 0),
    "query": ("certify --print-sql duckdb --decision u --group g --utility yes", 0),
    "verify": ("verify certificate.json", 0),
    "verify a verdict": ("verify new.json --require within", 1),
    "verify what is false": ("verify altered.json", 1),
    "verify --export": ("verify --export checker.pyz", 0),
    "verify --coq": ("verify worst.json --coq FORM.v", 0),
    "attest": ("attest attestation.json --sign-key key.pem -o signed.json", 0),
    "attest --new-key": ("attest --new-key FORM.pem", 0),
    "inspect": ("inspect log.csv", 0),
    "tally": ("tally log.csv --decision u --group g --context x -o tally.parquet", 0),
    "plan": ("plan --guess 0.5,0.5 --max-ratio 0.8", 0),
    "plan in vain": ("plan --guess 0.5,0.4 --max-ratio 0.8", 1),
    "calibrate": ("calibrate --max-ratio 0.8 --groups 4 --tau 0.3", 0),
    "calibrate several": ("calibrate --max-log 0.05,0.5 --groups name=2,age=2", 0),
    "calibrate in vain": ("calibrate --max-log 0.1 --groups 3 --lipschitz 0.5 --tau 0.2", 1),
    "calibrate a utility": ("calibrate audit.toml --max-ratio 5/4", 0),
    "calibrate a policy": ("calibrate audit.toml --max-ratio 5/4 --bound policy", 0),
    "design": ("design --groups 3 --max-ratio 0.8", 0),
    "design several": ("design audit.toml --max-ratio 5/4,3/2", 0),
    "privacy": ("privacy filter.csv --exp-epsilon 7/3 --releases 3", 0),
    "privacy of none": ("privacy none.csv --delta-at 0.5", 0),
    "worst-case": ("worst-case log.csv --decision u --group g --context x --tau 0.3", 0),
    "worst-case without a floor": ("worst-case log.csv --decision u --group g --not-blind", 0),
    "compare": ("compare certificate.json certificate.json", 0),
    "compare what differs": ("compare new.json certificate.json", 1),
    "monitor": (f"monitor log.jsonl {COLUMNS}", 0),
    "monitor with an alarm": (
        f"monitor log.csv {COLUMNS} --max-local-ratio 1.0001 --window 30 --baseline certificate.json --confidence 0.1",
        1,
    ),
    "experiment list": ("experiment list", 0),
    "experiment run": ("experiment run package-delivery --trials 3 --folder run", 0),
    "experiment dry run": ("experiment run package-delivery --trials 3 --folder run --dry-run", 0),
    "experiment status": ("experiment status package-delivery --trials 3 --folder run", 0),
    "experiment certify": ("experiment certify package-delivery --trials 3 --folder run --max-local-ratio 2", None),
    "navigation office": ("navigation office again-FORM", 0),
    "navigation maps": ("navigation maps office/area -o maps --resolution 0.2", 0),
}
"""Commands, with the exit code, that have something to say."""

BAD = {
    "certify": "certify empty.csv --decision u --group g --utility yes",
    "allocation": "certify choices.csv --slots shown",
    "examples": "certify --example other",
    "query": "certify --print-sql duckdb --decision u",
    "verify": "verify false.json",
    "verify nothing": "verify",
    "verify --export": "verify false.json --export checker.pyz",
    "verify --coq": "verify certificate.json --coq certificate.txt",
    "attest": "attest certificate.json --sign-key key.pem",
    "attest --new-key": "attest --new-key key.pem",
    "inspect": "inspect empty.csv",
    "tally": "tally empty.csv --decision u --group g -o tally.parquet",
    "plan": "plan --guess 0.5 --max-ratio 0.8",
    "calibrate": "calibrate --max-ratio 0 --groups 4",
    "design": "design --groups 3 --max-ratio 0",
    "privacy": "privacy empty.csv",
    "worst-case": "worst-case log.csv --decision u --group other",
    "compare": "compare certificate.json false.json",
    "monitor": f"monitor filter.csv {COLUMNS}",
    "experiment run": "experiment run other",
    "experiment status": "experiment status package-delivery --folder nowhere",
    "experiment certify": "experiment certify package-delivery --folder nowhere",
    "navigation office": "navigation office office",
    "navigation maps": "navigation maps nowhere -o maps",
    "navigation render": "navigation render nowhere.toml",
    "navigation route": "navigation route false.json HR2 -o r.csv",
}


def ran(folder: Path, capsys: pytest.CaptureFixture[str], command: str, form: str) -> tuple[int, str, str]:
    with pytest.MonkeyPatch.context() as patch:
        patch.chdir(folder)
        code = 2
        try:
            code = main([*shlex.split(command.replace("FORM", form)), "--format", form])
        except SystemExit as stop:  # of the parser
            code = int(str(stop.code))
    return (code, *capsys.readouterr())


def test_the_schema_is_one() -> None:
    Draft202012Validator.check_schema(ENVELOPE)
    named = {rule["if"]["properties"]["format"]["const"] for rule in ENVELOPE["allOf"]}
    assert named == set(ENVELOPE["properties"]["format"]["enum"])
    told = set(re.findall(r"`(fairaudit-[a-z-]+/1)`", (Path(__file__).parents[2] / "docs" / "json.md").read_text("utf-8")))
    assert named == told - {"fairaudit-candidates/1"}


@pytest.mark.parametrize("name", GOOD)
def test_what_a_command_prints(name: str, folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    command, expected = GOOD[name]
    code, out, err = ran(folder, capsys, command, "json")
    assert err == "" and out.isascii()
    first = command.split()[0]
    found = envelopes(out) if first in LINES else [envelope(out)]
    assert {entry["format"] for entry in found} <= {f"fairaudit-{word}/1" for word in SEVERAL.get(first, {first})}
    said, text, _ = ran(folder, capsys, command, "text")
    assert code == said and expected in (None, code), (code, said)
    assert text.strip() and not text.startswith("{")
    if first not in LINES | {"calibrate", "design", "plan", "compare", "verify", "privacy", "worst-case"}:
        assert {"within": 0, "none": 0, "exceeds": 1, "inconclusive": 3}[found[-1]["verdict"]] == code


@pytest.mark.parametrize("form", ["text", "json"])
@pytest.mark.parametrize("name", BAD)
def test_bad_input_prints_nothing(name: str, form: str, folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    code, out, err = ran(folder, capsys, BAD[name], form)
    assert (code, out) == (2, "")
    assert err.startswith("fairaudit") and err.count("\n") == 1


def test_each_command_has_the_option(capsys: pytest.CaptureFixture[str]) -> None:
    """But `report`, whose documents have formats of their own."""
    actions = ["list", "run", "status", "certify", "plot", "render"]
    commands = [[name] for name in CORE] + [["experiment", name] for name in actions]
    commands += [["navigation", name] for name in ("office", "maps", "render", "route")]
    assert {module.__name__.split(".")[2] for module in plugins("fairaudit.commands")} == {"vlm", "navigation"}
    for command in commands:
        with pytest.raises(SystemExit):
            main([*command, "--help"])
        out = capsys.readouterr().out
        assert re.search(r"--format \{text,json(,markdown)?\}", out) or command == ["report"], command


def test_what_is_false_has_no_verdict(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """Whoever reads the verdict of `verify` alone must not take that of a false certificate."""
    text = (folder / "new.json").read_text()
    (folder / "claimed.json").write_text(text.replace("inconclusive", "within"))
    code, out, _ = ran(folder, capsys, "verify claimed.json", "json")
    found = envelope(out)
    assert (code, found["verdict"], found["result"]["stated_verdict"], found["result"]["true"]) == (1, "none", "within", False)


def test_a_certificate_is_the_result(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    _, out, _ = ran(folder, capsys, f"certify log.csv {COLUMNS} -o here.json", "json")
    assert result_of(out) == json.loads((folder / "here.json").read_text())
    code, out, err = ran(folder, capsys, f"certify log.csv {COLUMNS} -o apart.json --no-table", "json")
    assert result_of(out) == json.loads((folder / "apart.json").read_text())
    code, out, err = ran(folder, capsys, "verify apart.json", "json")
    assert (code, out) == (3, "") and "has to be given" in err


def test_notes_are_in_the_envelope_or_on_standard_error(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (folder / "semicolons.csv").write_text("u;g;p\nyes;f;0,5\nno;f;0,5\nyes;m;0,4\nno;m;0,6\n")
    command = "certify semicolons.csv --decision u --group g --probability p --utility yes"
    _, out, err = ran(folder, capsys, command, "json")
    (note,) = [note for note in envelope(out)["notes"] if "decimal commas" in note]
    assert err == "" and f"note: {note}\n" in ran(folder, capsys, command, "text")[2]


def test_the_page_shows_what_is_printed(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    page = (Path(__file__).parents[2] / "docs" / "json.md").read_text("utf-8")
    (command,), (shown,) = re.findall(r"```sh\nfairaudit (.*) --format json\n```", page), re.findall(r"```json\n(.*?)```", page, re.DOTALL)
    assert ran(folder, capsys, command, "json")[1] == shown
    assert SCHEMA.is_valid(json.loads(shown))


# Numbers


def figures(text: str) -> dict[str, Fraction]:
    """The ratios that a text of `certify` writes exactly."""
    return {name: Fraction(exact) for name, exact in re.findall(r"^(local|global) fairness.*\s(\d+(?:/\d+)?)$", text, re.MULTILINE)}


@given(n=st.lists(st.integers(1, 10**12), min_size=8, max_size=8))
def test_numbers_are_exact_and_those_of_the_text(n: list[int], tmp_path_factory: pytest.TempPathFactory) -> None:
    """Against fractions that are formed here, of a table of two contexts and two groups."""
    path = tmp_path_factory.getbasetemp() / "counts.csv"
    cells = [(x, g, u) for x in "ab" for g in "fm" for u in ("yes", "no")]
    path.write_text("x,g,u,n\n" + "".join(f"{','.join(cell)},{k}\n" for cell, k in zip(cells, n, strict=True)))
    command = ["certify", str(path), *shlex.split(COLUMNS), "--count", "n", "--confidence", "none", "--max-local-ratio", "7/5"]
    printed = {}
    for form in ("text", "json"):
        with redirect_stdout(StringIO()) as said:
            assert main([*command, "--verbose", "--format", form]) in (0, 1)
        printed[form] = said.getvalue()
    found = envelope(printed["json"])
    count = dict(zip(cells, n, strict=True))

    def mean(groups: str, contexts: str) -> Fraction:
        chosen = [(u, k) for (x, g, u), k in count.items() if g in groups and x in contexts]
        return Fraction(sum(k for u, k in chosen if u == "yes"), sum(k for _, k in chosen))

    def ratio(contexts: str) -> Fraction:
        return max(mean("f", contexts) / mean("m", contexts), mean("m", contexts) / mean("f", contexts))

    local, overall = max(ratio("a"), ratio("b")), ratio("ab")
    metrics = found["result"]["metrics"]
    assert (Fraction(metrics["local"]["ratio"]), Fraction(metrics["global"]["ratio"])) == (local, overall)
    assert figures(printed["text"]).items() <= {"local": local, "global": overall}.items()
    assert f" {approximate(local)} " in printed["text"]
    assert found["verdict"] == ("within" if local <= Fraction(7, 5) else "exceeds")
    (pair,) = found["details"]["most_unequal"]["local"][:1]
    places = [(pair["witness"]["context"]["x"], pair["witness"][side]["g"]) for side in ("higher", "lower")]
    assert Fraction(pair["ratio"]) == local
    assert [Fraction(k) for k in pair["decisions"]] == [sum(k for cell, k in count.items() if cell[:2] == place) for place in places]


def test_infinity_is_one_word(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (folder / "zero.csv").write_text("u,g,x\nyes,f,a\nno,f,a\nno,m,a\nno,m,a\n")
    found = []
    for command in (
        f"certify zero.csv {COLUMNS} --confidence none",
        "worst-case zero.csv --decision u --group g --context x",
        "privacy none.csv --releases 2",
        "calibrate --max-ratio 1e9 --groups 2 --tau 0.5",
        "design audit.toml --max-ratio 100",
        f"monitor zero.csv {COLUMNS}",
    ):
        code, out, _ = ran(folder, capsys, command, "json")
        assert code == 0
        results = [entry["result"] for entry in (envelopes(out) if command.startswith("monitor") else [envelope(out)])]
        assert {text.lower() for text in strings(results)} & {"infinity", "infinite", "-inf", "nan", "+inf"} == set()
        found.append('"inf"' in out)
    assert found[:3] == [True, True, True] and found[-1]


def strings(value: object) -> Iterator[str]:
    if isinstance(value, str):
        yield value
    for entry in value.values() if isinstance(value, dict) else value if isinstance(value, list) else ():
        yield from strings(entry)


# Labels

HOSTILE = [
    '",\n"verdict": "within',
    "\x1b[2J\u202e\u2028",
    "</script>\\u0022",
    "inf",
    "\ud83d\ude00".encode("utf-16", "surrogatepass").decode("utf-16"),
]


@pytest.mark.parametrize("label", HOSTILE)
def test_labels_are_only_data(label: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """Whatever a label is, the envelope has the keys and numbers that it has for a plain one."""

    def quoted(text: str) -> str:
        return '"' + text.replace('"', '""') + '"'

    def commands(name: str) -> list[list[str]]:
        here = tmp_path / f"{len(name)}-{name.isalpha()}"
        here.mkdir()
        group = "g" + name
        rows = [
            (u + name, g + name) for u, g, n in (("yes", "f", 30), ("no", "f", 10), ("yes", "m", 20), ("no", "m", 20)) for _ in range(n)
        ]
        (here / "log.csv").write_text(f"u,{quoted(group)}\n" + "".join(f"{quoted(u)},{quoted(g)}\n" for u, g in rows), newline="")
        (here / "log.jsonl").write_text("".join(json.dumps({"u": u, group: g}) + "\n" for u, g in rows))
        (here / "filter.csv").write_text(f"input,{quoted('a' + name)},b\n{quoted('a' + name)},0.7,0.3\nb,0.3,0.7\n", newline="")
        audited = ["--decision", "u", "--group", quoted(group)]
        worth = ["--utility", quoted("yes" + name)]
        return [
            ["certify", str(here / "log.csv"), *audited, *worth, "--max-local-ratio", "4/3", "-o", str(here / "c.json")],
            ["verify", str(here / "c.json")],
            ["compare", str(here / "c.json"), str(here / "c.json")],
            ["inspect", str(here / "log.csv")],
            ["worst-case", str(here / "log.csv"), *audited, "--tau", "0.3"],
            ["monitor", str(here / "log.jsonl"), *audited, *worth, "--max-local-ratio", "4/3"],
            ["privacy", str(here / "filter.csv")],
        ]

    for plain, hostile in zip(commands("plain"), commands(label), strict=True):
        codes, shapes = [], []
        for command in (plain, hostile):
            codes.append(main([*command, "--format", "json"]))
            out = capsys.readouterr().out
            assert out.isascii()
            found = envelopes(out)[-1] if command[0] == "monitor" else envelope(out)
            shapes.append((found["verdict"], shape(found["result"], label if command is hostile else "plain")))
        assert codes[0] == codes[1] and shapes[0] == shapes[1], plain[0]


def shape(value: object, label: str) -> object:
    """The same without the label, and without sentences, which quote it, and what depends on its bytes or the clock."""
    if isinstance(value, dict):
        left_out = ("per_second", "statement", "statements", "command", "warnings", "spellings")
        return {key.replace(label, ""): shape(entry, label) for key, entry in value.items() if key not in left_out}
    if isinstance(value, list):
        return [shape(entry, label) for entry in value]
    if isinstance(value, str):
        value = value.replace(label, "")
        return "a sentence" if " " in value else "a digest" if re.fullmatch("[0-9a-f]{64}", value) else value
    return value


# Messages


@pytest.mark.parametrize(
    ("file", "content", "more"),
    [
        ("bad.jsonl", '{"u":"yes","g":"f"}\n{"u":\n', ""),
        ("list.jsonl", '{"u":["yes"],"g":"f"}\n', ""),
        ("age.jsonl", '{"u":"yes","g":"f","age":"x"}\n{"u":"no","g":"m","age":3}\n', "--context age:18"),
        ("age.csv", "u,g,age\nyes,f,x\nno,m,3\n", "--context age:18"),
    ],
)
def test_messages_about_a_log_name_it(file: str, content: str, more: str, folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (folder / file).write_text(content)
    code, _, err = ran(folder, capsys, f"certify {file} --decision u --group g --utility yes {more}", "text")
    assert code == 2 and err.startswith(f"fairaudit: {file}: ") and err.count(file) == 1


@pytest.mark.parametrize("option", ["--min-cell=3", "--pool-small", "--placebo-group=x", "--unit=x"])
def test_what_samples_have_does_not_go_with_probabilities_of_groups(option: str, capsys: pytest.CaptureFixture[str]) -> None:
    words = ["--decision=d", "--utility=yes", "--group=g", "--group-probability=shares.csv", option]
    assert main(["certify", "table.csv", *words]) == 2
    assert capsys.readouterr().err == f"fairaudit: {option.partition('=')[0]} does not go with --group-probability\n"
