"""The tie between the machine-checked theorems in proofs/ and the code that cites them, and the verified checker.

What reads only text runs everywhere; what needs Coq skips without it, or fails without it where FAIRAUDIT_COQ=1.
"""

from __future__ import annotations

import json
import random
import re
import shutil
import subprocess
import sys
import tomllib
from collections import Counter
from collections.abc import Iterator
from fractions import Fraction
from pathlib import Path
from typing import Any

import pytest
import tiers
from built_proofs import PROOFS, make_proofs
from class_certificates import TINY, Case, Solved, tampered, true_certificate
from plain_certificates import checker, detached, raw

import fairaudit as fa
from fairaudit.certificates.certificate import schema
from fairaudit.cli import main
from fairaudit.tables.examples import example
from fairaudit.theorems.registry import BY_ID

ROOT = Path(__file__).resolve().parents[2]
BLOCKS = 10
PER_BLOCK = 50 if tiers.FULL else 6

Index = dict[str, dict[str, dict[str, Any]]]
STATED = re.compile(r"^(?:Theorem|Corollary) (\w+)", re.MULTILINE)
FORBIDDEN = re.compile(r"\b(Admitted|Axioms?|admit|Parameters?|Conjectures?|give_up|bypass_check)\b")
# Real exponentials and logarithms rest on the axioms of the reals of mathcomp-analysis.
WITH_AXIOMS = ("theories/Instances.v", "checker/NatsSound.v", "checker/CertificateSound.v")


def read_index(proofs: Path) -> Index:
    return tomllib.loads((proofs / "index.toml").read_text("utf-8"))


def statements(index: Index) -> Iterator[tuple[str, str, str]]:
    """List (id, name of a statement, its file)."""
    for entries in index.values():
        for name, entry in entries.items():
            if entry["statements"] != "none":
                yield from ((name, statement, file) for statement, file in entry["statements"].items())


def missing_statements(proofs: Path) -> list[str]:
    """List the statements that the index names and that are not in the file that it names."""
    return [
        f"{name}: {statement} in {file}"
        for name, statement, file in statements(read_index(proofs))
        if not (proofs / file).is_file() or statement not in STATED.findall((proofs / file).read_text("utf-8"))
    ]


def sources() -> list[Path]:
    return sorted([*PROOFS.glob("theories/*.v"), *PROOFS.glob("kernel/*.v"), *PROOFS.glob("checker/*.v")])


def module(file: str) -> str:
    folder, name = file.removesuffix(".v").split("/")
    return f"{ {'theories': 'Fairaudit', 'kernel': 'FairauditKernel', 'checker': 'FairauditChecker'}[folder] }.{name}"


def rests_on(text: str) -> dict[str, str]:
    """Read what Coq printed: after the theorems of a file, what they rest on together."""
    found: dict[str, str] = {}
    for names, verdict in re.findall(r"((?:^Constant \S+\n)+)((?:^(?!Constant ).*\n)+)", text, re.MULTILINE):
        found |= dict.fromkeys(re.findall(r"Constant (\S+)", names), verdict.strip())
    return found


# Without Coq


def test_every_id_has_an_entry() -> None:
    index = read_index(PROOFS)
    accepted = {key[2] for key in checker.claims.RULES} | {
        "binomial",
        checker.claims.PAIR_EXACT,
        checker.claims.CONTRASTS,
        checker.claims.PAIRED_BETTING,
        *checker.claims.METHODS,
        checker.claims.BETTING,
        checker.drift.T16,
    }
    assert set(index["cited"]) == accepted
    assert set(schema()["$defs"]["claim"]["properties"]["by"]["enum"]) == accepted
    code = "".join(path.read_text("utf-8") for path in (ROOT / "fairaudit").rglob("*.py") if path.parent.name != "checker")
    written = set(re.findall(r'"(T\d+(?:-[a-z]+)?)"', code))
    assert {"T1", "T1-paper", "T5-decision", "T10", "T11", "T12"} <= written
    assert written <= {*index["cited"], *index["further"], *BY_ID}


@pytest.mark.parametrize("example", ["ucb-admissions", "hr-navigation", "hr-filtered"])
def test_claims_of_the_examples_have_entries(example: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = tmp_path / "certificate.json"
    main(["certify", "--example", example, "-o", str(path)])
    capsys.readouterr()
    cited = {claim["by"] for claim in json.loads(path.read_text("utf-8"))["claims"]}
    assert len(cited) >= 4
    assert cited <= set(read_index(PROOFS)["cited"])


def test_entries_are_complete() -> None:
    for kind, entries in read_index(PROOFS).items():
        assert kind in ("cited", "further")
        for name, entry in entries.items():
            assert entry["says"].endswith("."), name
            assert entry["tests"], name
            for file in entry["tests"]:
                assert "def test_" in (ROOT / file).read_text("utf-8"), (name, file)
            if entry["statements"] == "none":
                assert kind == "cited", name
                assert len(entry["reason"]) > 40, name
            else:
                assert entry["statements"], name
                assert "reason" not in entry, name


def test_the_page_says_what_the_index_says() -> None:
    page = (ROOT / "docs" / "proofs.md").read_text("utf-8")
    for entries in read_index(PROOFS).values():
        for name, entry in entries.items():
            (row,) = (line for line in page.splitlines() if line.startswith(f"| `{name}` |"))
            assert entry["says"] in row
            if entry["statements"] == "none":
                assert entry["reason"] in row
            else:
                assert set(re.findall(r"`proofs/(.*?)`", row)) == set(entry["statements"].values())


def test_every_statement_is_where_the_index_says() -> None:
    assert missing_statements(PROOFS) == []


def test_every_theorem_is_in_the_index() -> None:
    listed = [(file, statement) for _, statement, file in statements(read_index(PROOFS))]
    there = [(f"{path.parent.name}/{path.name}", name) for path in sources() for name in STATED.findall(path.read_text("utf-8"))]
    assert sorted(set(listed)) == sorted(there)


def test_every_loop_is_proved_to_be_the_function_that_it_replaces() -> None:
    replaced = re.findall(
        r'^Extract Inlined Constant ([\w.]+) => "\(?(loop_\w+)', (PROOFS / "checker" / "Extract.v").read_text("utf-8"), re.M
    )
    proved = re.findall(
        r"^Theorem \w+ [^=]*?: (loop_\w+)[^=]* = (?:[A-Z]\w*\.)*(\w+(?:\.sort)?) ",
        (PROOFS / "checker" / "LoopsSound.v").read_text("utf-8"),
        re.M,
    )
    assert {(loop, name.rpartition(".")[2]) for name, loop in replaced} == {(loop, name) for loop, name in proved}
    assert len(replaced) == len(proved) > 20


@pytest.mark.parametrize("name", ["T2_pure", "worst_case_local"])
def test_renaming_a_theorem_breaks_the_index(name: str, tmp_path: Path) -> None:
    proofs = tmp_path
    for path in [PROOFS / "index.toml", *sources()]:
        copy = proofs / path.relative_to(PROOFS)
        copy.parent.mkdir(exist_ok=True)
        shutil.copy(path, copy)
    assert missing_statements(proofs) == []
    for path in proofs.rglob("*.v"):
        text = path.read_text("utf-8")
        path.write_text(re.sub(rf"\b{name}\b", f"{name}_renamed", text), "utf-8")
    missing = missing_statements(proofs)
    assert missing
    assert all(f": {name} in " in line for line in missing)


def applied(proofs: Path) -> dict[str, tuple[str, str]]:
    """Read the theorems that are applied to objects which meet their hypotheses: by name, what is then said, and its proof."""
    found = {}
    for path in sorted(proofs.glob("*/Witnesses*.v")):
        text = re.sub(r"\(\*.*?\*\)", "", path.read_text("utf-8"), flags=re.DOTALL)
        assert not re.search(r"\b(Section|Variables?|Hypothes[ie]s|Context)\b", text), path
        for name, said, proof in re.findall(r"^Example (\w+)_applies\b(.*?)\.\s+Proof\.(.*?)\bQed\.", text, re.DOTALL | re.MULTILINE):
            found[name] = re.sub(r"\b(bool|unit) -> (?=(bool|unit|rat)\b)", "", said), proof  # no hypotheses, but types of functions
    return found


FURTHER = ("DP", "bets", "one-k", *(f"T{n}" for n in range(1, 19)), "products", "sampler", "verdicts")
"""Further theorems that have an example as well: what their ids begin with."""


def without_instance(proofs: Path) -> set[str]:
    """List the statements that claims cite, and further ones, that are not applied to anything, or only under a hypothesis."""
    instances = applied(proofs)
    index = read_index(proofs)
    asked = [*index["cited"].values(), *(entry for name, entry in index["further"].items() if name.startswith(FURTHER))]
    names = {name for entry in asked if entry["statements"] != "none" for name in entry["statements"]}
    return {
        name
        for name in names
        if "example" not in name  # those have no hypotheses
        and (name not in instances or "->" in instances[name][0] or not re.search(rf"\b{name}\b", instances[name][1]))
    }


def test_hypotheses_can_be_met() -> None:
    """Each is applied to an example; the statement that comes out has no hypothesis left."""
    assert without_instance(PROOFS) == set()


@pytest.mark.parametrize(
    ("old", "new"),
    [
        ("Example T4_any_policy_applies", "Example T4_any_applies"),
        ("T4_any_policy kX", "T4_one_k kX"),
        ("T4_any_policy_applies", "T4_any_policy_applies : 0 = 1 ->"),
    ],
)
def test_a_theorem_without_an_example_is_found(old: str, new: str, tmp_path: Path) -> None:
    for path in [PROOFS / "index.toml", *PROOFS.glob("*/Witnesses*.v")]:
        copy = tmp_path / path.relative_to(PROOFS)
        copy.parent.mkdir(exist_ok=True)
        text = path.read_text("utf-8")
        copy.write_text(text.replace(old, new), "utf-8")
    assert without_instance(tmp_path) == {"T4_any_policy"}


def test_every_statement_is_closed_in_the_reviewed_list() -> None:
    """Coq's list of what each theorem rests on, as it was reviewed; with Coq it is compared with what Coq says now."""
    reviewed = rests_on((PROOFS / "assumptions.golden").read_text("utf-8"))
    assert set(reviewed) == {f"{module(file)}.{statement}" for _, statement, file in statements(read_index(PROOFS))}, (
        "written by: make -C proofs golden"
    )
    for name, assumed in reviewed.items():
        if not name.startswith(tuple(f"{module(file)}." for file in WITH_AXIOMS)):
            assert assumed == "Closed under the global context", name


def stated(proofs: Path) -> list[str]:
    """List what has to be read of the proofs: theorems as they are stated, and definitions."""
    run = subprocess.run([sys.executable, str(proofs / "statements.py")], capture_output=True, text=True, encoding="utf-8")
    if run.returncode:
        raise ValueError(run.stderr.splitlines()[-1])
    return run.stdout.splitlines()


def test_every_statement_and_definition_is_as_reviewed() -> None:
    assert stated(PROOFS) == (PROOFS / "statements.golden").read_text("utf-8").splitlines(), "after a review: make -C proofs golden"


EXAMPLE = """(* Words (of "every *)" kind). *)
Section S.
Variable a : nat.
Hypothesis small : a < 2. (* a comment *)
Notation "f .. g" := (f, .. (g) ..).
Local Notation b := (S.a  a).
Lemma step : a < 3.
Proof. by rewrite (ltnW small). Qed.
Let c : nat. Proof. exact: 0. Defined.
Record pair := Pair {
  first : nat; second : nat }.
Theorem bound (x : nat) :
  x < a -> x = 0.
Proof.
by case: x.
Qed.
End S.
"""


def test_what_is_stated_and_defined_is_listed(tmp_path: Path) -> None:
    def listed(text: str) -> list[str]:
        (tmp_path / "theories" / "E.v").write_text(text, "utf-8")
        return stated(tmp_path)

    (tmp_path / "theories").mkdir()
    shutil.copy(PROOFS / "statements.py", tmp_path)
    reviewed = listed(EXAMPLE)
    assert reviewed == [
        "==== theories/E.v",
        "Section S.",
        "Variable a : nat.",
        "Hypothesis small : a < 2.",
        'Notation "f .. g" := (f, .. (g) ..).',
        "Local Notation b := (S.a a).",
        "Let c : nat.",
        "Proof.",
        "exact: 0.",
        "Defined.",
        "Record pair := Pair { first : nat; second : nat }.",
        "Theorem bound (x : nat) : x < a -> x = 0.",
        "End S.",
    ]
    for old, new in [("by case: x", "by case: x => [|y]"), ("(* a comment *)", ""), ("a < 3", "a < 4"), ("  x < a", "x <  a")]:
        assert listed(EXAMPLE.replace(old, new)) == reviewed, old
    for old, new in [("a < 2", "a < 1"), ("x = 0", "x <= 0"), ("second", "third"), ("exact: 0", "exact: 1"), ("S.a  a", "S.a 0")]:
        assert listed(EXAMPLE.replace(old, new)) != reviewed, old
    for old, new in [
        ("Proof.\nby case: x.", "Proof (f x)."),
        ("by case: x.\nQed.", "by case: x."),
        ("Proof.\nby", "by"),
        ("End S.", "End S"),
    ]:
        with pytest.raises(ValueError, match=r"has to|ends within"):
            listed(EXAMPLE.replace(old, new))


def test_nothing_is_assumed_instead_of_proved() -> None:
    for path in sources():
        assert FORBIDDEN.findall(path.read_text("utf-8")) == [], path


@pytest.mark.parametrize("line", ["Admitted.", "Axiom every : False.", "Parameter every : False.", "admit."])
def test_the_build_refuses_assumptions(line: str, tmp_path: Path) -> None:
    if shutil.which("make") is None:
        pytest.skip("make is not on this machine")
    for path in [PROOFS / "Makefile", PROOFS / "_CoqProject", *sources()]:
        copy = tmp_path / path.relative_to(PROOFS)
        copy.parent.mkdir(exist_ok=True)
        shutil.copy(path, copy)
    gates = ["make", "-s", "-C", str(tmp_path), "gates"]
    assert subprocess.run(gates, capture_output=True).returncode == 0
    with (tmp_path / "theories" / "T1.v").open("a") as file:
        file.write(line + "\n")
    refused = subprocess.run(gates, capture_output=True, text=True)
    assert refused.returncode != 0
    assert line in refused.stdout


# With Coq


@pytest.fixture(scope="module")
def built() -> Path:
    """Build the proofs and check them; the folder of the build."""
    return make_proofs("all", "no proof was checked") / "build"


def test_every_statement_is_closed_now(built: Path) -> None:
    assert (built / "assumptions.txt").read_text("utf-8") == (PROOFS / "assumptions.golden").read_text("utf-8")


def verdict_in_python(document: dict[str, Any], table: list[bytes] | None = None) -> int:
    """Decide as the checker does: 0 the claims by lp-dual are true, 1 one is not or there is none, 2 malformed."""
    try:
        report = checker.check(raw(document), table)
    except checker.FormatError:
        return 2
    found = [finding for finding in report.findings if re.match(r'claims\[\d+\]: .* by "lp-dual"', finding.statement)]
    return 0 if found and all(finding.true for finding in found) else 1


def run_verified(built: Path, *arguments: str) -> subprocess.CompletedProcess[str]:
    run = subprocess.run([str(built / "fairaudit-check"), *arguments], capture_output=True, text=True)
    assert run.returncode in (0, 1, 2, 3), run
    return run


def verdict_of_proof(built: Path, folder: Path, document: dict[str, Any], *further: str) -> int:
    """Decide by the verified checker as the other does."""
    path = folder / "certificate.json"
    path.write_bytes(raw(document))
    run = run_verified(built, str(path), *further)
    if run.returncode == 2:
        return 2
    found = [line for line in run.stdout.splitlines() if line.endswith(' by "lp-dual"')]
    return 0 if found and all(line.startswith("true: ") for line in found) else 1


OTHER = [
    "0",
    "1",
    "-1",
    "1/2",
    "2/4",
    "3/1",
    "-0",
    "00",
    "+1",
    "1/0",
    "inf",
    "",
    "1.5",
    "local",
    "global",
    "u0",
    "all",
    None,
    True,
    0,
    1,
    -1,
    1.5,
    10**18,
    [],
]


def places(node: Any, path: tuple[Any, ...] = ()) -> Iterator[tuple[Any, ...]]:
    yield path
    for key, item in node.items() if isinstance(node, dict) else enumerate(node) if isinstance(node, list) else ():
        yield from places(item, (*path, key))


def value_at(node: Any, path: tuple[Any, ...]) -> Any:
    for key in path:
        node = node[key]
    return node


def altered(pick: random.Random, document: dict[str, Any]) -> dict[str, Any]:
    """Change one thing in the class, the table, the claim or its evidence: a number most of the time, else the form."""
    document = json.loads(json.dumps(document))
    claim = ("claims", len(document["claims"]) - 1)
    roots: list[tuple[Any, ...]] = [
        ("subject", "class"),
        ("subject", "table", "header"),
        ("subject", "table", "rows"),
        claim,
        (*claim, "evidence"),
    ]
    root = pick.choice(roots)
    paths = [(*root, *path) for path in places(value_at(document, root)) if path]
    if pick.random() < 0.7:
        paths = [
            path for path in paths if isinstance(value_at(document, path), int) or re.fullmatch(r"[-0-9/]+", str(value_at(document, path)))
        ] or paths
    path = pick.choice([path for path in paths if path[-1] != "by"])
    parent, key = value_at(document, path[:-1]), path[-1]
    node = parent[key]
    kind = pick.choice(["number"] * 6 + ["other", "drop", "twice", "order"])
    if kind == "number" and type(node) is int:
        parent[key] = node + pick.choice([-1, 1, 100])
    elif kind == "number" and isinstance(node, str) and re.fullmatch(r"-?[0-9]+(/[1-9][0-9]*)?", node):
        parent[key] = str(Fraction(node) * pick.choice([Fraction(1, 2), 2, 1 + TINY, 1 - TINY, -1]) + pick.choice([0, 0, TINY, 1]))
    elif kind == "drop":
        del parent[key]
    elif kind == "twice" and isinstance(parent, list):
        parent.insert(key, node)
    elif kind == "order" and isinstance(node, list):
        pick.shuffle(node)
    else:
        parent[key] = pick.choice(OTHER)
    return document


@pytest.mark.parametrize("block", range(BLOCKS))
def test_equal_verdicts(block: int, built: Path, tmp_path: Path) -> None:
    """The extracted checker and fairaudit.checker agree on the least value of random linear programs and on altered evidence."""
    seen: Counter[tuple[str, int]] = Counter()
    for seed in range(20_000 + block * PER_BLOCK, 20_000 + (block + 1) * PER_BLOCK):
        solved = Solved(Case(seed))
        document = true_certificate(solved)
        less = json.loads(json.dumps(document))
        if less["claims"][-1]["value"] != "inf":
            less["claims"][-1]["value"] = str(Fraction(less["claims"][-1]["value"]) - TINY)
        has_evidence = bool(document["claims"][-1]["evidence"]["pairs"])
        pick = random.Random(seed)
        changed = [tampered(solved, document) for _ in range(2 * has_evidence)] + [altered(pick, document) for _ in range(3)]
        for kind, one in [("true", document), ("true", less), *(("tampered", c) for c in changed)]:
            expected = verdict_in_python(one)
            assert verdict_of_proof(built, tmp_path, one) == expected, (seed, json.dumps(one))
            seen[kind, expected] += 1
    print(dict(seen))
    assert seen["true", 0] >= PER_BLOCK * 3 // 4
    assert seen["true", 1] >= PER_BLOCK // 4
    assert min(seen["tampered", verdict] for verdict in (0, 1, 2)) >= PER_BLOCK // 4
    assert sum(count for (kind, _), count in seen.items() if kind == "tampered") >= PER_BLOCK


@pytest.mark.deep  # pays for what tests that are slow share
@pytest.mark.parametrize("quantity", ["local", "global"])
@pytest.mark.parametrize(
    "keys",
    [
        {"tau": "0.2", "tau_on": "pair"},
        {"tau": "0.2", "blind": False, "lipschitz": "0.1"},
        {"tau": "0.1", "m": "0.05", "order": ["Rejected", "Admitted"]},
    ],
)
def test_equal_verdicts_on_what_the_writer_writes(keys: dict[str, Any], quantity: str, built: Path, tmp_path: Path) -> None:
    """Certificates of the package, with an embedded table and without."""
    law = fa.Law.from_counts(example("ucb-admissions").table(), decision="Admit", group="Gender", context="Dept", count="Freq")
    document = json.loads(json.dumps(fa.certify_worst_case(fa.worst_case(law, fa.UtilityClass(**keys), quantity=quantity)).document))
    assert document["claims"][-1]["by"] == "lp-dual"
    alone, lines = detached(json.loads(json.dumps(document)))
    table = tmp_path / "table.jsonl"
    table.write_bytes(b"".join(lines))
    assert verdict_in_python(document) == verdict_of_proof(built, tmp_path, document) == 0
    assert verdict_in_python(alone, lines) == verdict_of_proof(built, tmp_path, alone, "--table", str(table)) == 0
    document["claims"][-1]["value"] = "101/100"
    assert verdict_in_python(document) == verdict_of_proof(built, tmp_path, document) == 1


@pytest.mark.parametrize(
    "document",
    [
        b"",
        b"{",
        b"[1,]",
        b'{"a":1,"a":2}',
        b'"\xff"',
        b"[" * 100_000,
        b'{"format":"fairaudit-certificate/1"}',
        b"\xef\xbb\xbf{}",
        b"nul",
        b"{} {}",
        b'"\t"',
        b"[01]",
        b"NaN",
    ],
)
def test_what_is_no_certificate(document: bytes, built: Path, tmp_path: Path) -> None:
    path = tmp_path / "certificate.json"
    path.write_bytes(document)
    with pytest.raises(checker.FormatError):
        checker.check(document)
    run = run_verified(built, str(path))
    assert run.returncode == 2
    assert run.stderr.startswith("fairaudit-check: malformed: ")
