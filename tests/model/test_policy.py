"""Policies behind filters: the induced law against nested loops, what certify makes of it, and refusals."""

from __future__ import annotations

import json
import subprocess
import sys
from fractions import Fraction
from pathlib import Path
from typing import Any

import jsonschema
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import fairaudit as fa
from fairaudit import InputError
from fairaudit.certificates.certificate import schema
from fairaudit.model.layout import Columns
from fairaudit.model.mechanism import Mechanism
from fairaudit.model.policy import Deployment, Policy

F = Fraction


@st.composite
def rows(draw: st.DrawFn, size: int, length: int) -> list[list[Fraction]]:
    table = []
    for _ in range(size):
        row = draw(st.lists(st.integers(0, 5), min_size=length, max_size=length))
        row = row if any(row) else [1] * length
        table.append([Fraction(v, sum(row)) for v in row])
    return table


@st.composite
def factors(draw: st.DrawFn, name: str) -> Mechanism:
    size = draw(st.integers(2, 3))
    values = [f"{name}{i}" for i in range(size)]
    if draw(st.booleans()):
        return fa.RandomizedResponse(values, keep_probability=Fraction(draw(st.integers(0, 10)), 10))
    return Mechanism.from_array(draw(rows(size, size)), values)


@st.composite
def deployments(draw: st.DrawFn) -> Deployment:
    group = fa.Product({"a": draw(factors("a")), "b": draw(factors("b"))})
    context = draw(factors("x")) if draw(st.booleans()) else None
    contexts = ["x0", "x1"] if context is None else [x for (x,) in context.outputs]
    decisions = ["go", "stay", "wait"]
    table = draw(rows(len(contexts) * len(group.outputs), 3))
    array = np.array(table, dtype=object).reshape(len(contexts), len(group.outputs), 3)
    law = fa.Law.from_array(array, decisions=decisions, groups=group.outputs, contexts=contexts, columns=Columns("u", ("a", "b"), ("x",)))
    shape = (len(contexts) if context is None else len(context.inputs), len(group.inputs))
    population = (
        draw(st.lists(st.integers(1, 5), min_size=shape[0] * shape[1], max_size=shape[0] * shape[1])) if draw(st.booleans()) else None
    )
    return Policy(law).behind(group=group, context=context, population=None if population is None else np.array(population).reshape(shape))


def brute_force(d: Deployment) -> dict[tuple[Any, Any], list[Fraction]]:
    """P(u|x,a) by the definition."""
    law = d.policy.law
    policy = {}
    for i, (x, a) in enumerate(zip(law.cell_context.tolist(), law.cell_group.tolist(), strict=True)):
        row = [Fraction(int(v)) for v in law.weights[i]]
        policy[law.contexts[x], law.groups[a]] = [v / sum(row) for v in row]
    induced = {}
    for x in d.contexts:
        for a in d.groups:
            total = [F(0)] * len(law.decisions)
            for seen in law.contexts if d.context_filter is None else d.context_filter.outputs:
                p = F(seen == x) if d.context_filter is None else d.context_filter.probability(x, seen)
                for b in d.group_filter.outputs:
                    q = d.group_filter.probability(a, b)
                    total = [t + p * q * v for t, v in zip(total, policy[seen, b], strict=True)]
            induced[x, a] = total
    return induced


@given(deployments())
def test_the_induced_law_equals_nested_loops(d: Deployment) -> None:
    expected = brute_force(d)
    law = d.law
    assert (law.contexts, law.groups) == (d.contexts, d.groups)
    for i, (x, a) in enumerate(zip(law.cell_context.tolist(), law.cell_group.tolist(), strict=True)):
        row = law.row(i)
        assert [Fraction(v, sum(row)) for v in row] == expected[law.contexts[x], law.groups[a]]


@given(deployments(), st.lists(st.integers(0, 4), min_size=3, max_size=3))
def test_every_bound_holds_for_the_law_it_is_about(d: Deployment, values: list[int]) -> None:
    utility = dict(zip(d.policy.law.decisions, values, strict=True))
    if not any(values):
        utility["go"] = 1
    free = fa.certify(d, utility)
    assert free.local is not None
    floor = free.tau
    result = fa.certify(d, utility, declared={"tau": floor}) if floor else free
    for bound in result.bounds:
        measured = result.local if bound.quantity == "local_ratio" else result.global_
        assert measured is not None
        assert measured.ratio <= bound.value, bound


@given(deployments())
def test_the_certificate_of_a_deployment_verifies(d: Deployment) -> None:
    from fairaudit.checker.verification import check

    text = fa.certify(d, {"go": 1, "wait": "1/3"}).certificate.text
    jsonschema.validate(json.loads(text), schema())
    report = check(text.encode())
    assert report.ok, [f for f in report.findings if not f.true]


def example() -> Policy:
    return Policy.from_array([[[F(9, 10), F(1, 10)], [F(2, 10), F(8, 10)]]], decisions=["hire", "pass"], groups=["f", "m"])


def test_before_and_after_stand_side_by_side() -> None:
    d = example().behind(group=fa.RandomizedResponse(["f", "m"], keep_probability="0.75"))
    result = fa.certify(d, {"hire": 1}, all_bounds=True)
    assert result.unfiltered is not None
    assert result.unfiltered[0].ratio == F(9, 2)
    assert result.local.ratio == F(29, 15)
    frame = result.to_frame()
    assert frame["unfiltered_expectation"].tolist() == [F(9, 10), F(2, 10)]
    assert frame["expectation"].tolist() == [F(29, 40), F(15, 40)]
    by = {(b.theorem, b.scope): b.value for b in result.bounds}
    assert by["T2", "any policy behind this filter"] == 3
    # T12 is attained by two groups: (1 + 9/2·3)/(9/2 + 3).
    assert by["T12", "this policy and context filter, any group filter at most this epsilon that releases the same values"] == F(29, 15)


def test_a_floor_of_this_table_bounds_this_law_only() -> None:
    """The policy that always hires has floor 1 and would 'prove' R ≤ 1 for every other policy."""
    always = Policy.from_array([[[1, 0], [1, 0]]], decisions=["hire", "pass"], groups=["f", "m"])
    coin = fa.RandomizedResponse(["f", "m"], keep_probability="0.75")
    result = fa.certify(always.behind(group=coin), {"hire": 1}, all_bounds=True)
    assert all(b.value >= 3 for b in (*result.bounds, *result.suprema) if b.scope.startswith("any policy"))
    assert min(b.value for b in result.bounds if b.scope == "this law") == 1


def test_an_alphabet_of_released_values_other_than_the_true_ones() -> None:
    law = fa.Law.from_array([[[1, 0], [0, 1]]], decisions=["go", "stay"], groups=["grey", "white"])
    veil = Mechanism.from_array([["0.5", "0.5"], ["0.25", "0.75"]], ["f", "m"], ["grey", "white"])
    result = fa.certify(Policy(law).behind(group=veil), {"go": 1})
    assert (result.local.ratio, result.unfiltered) == (2, None)


@pytest.mark.parametrize(
    ("build", "word"),
    [
        (lambda: example().behind(group=fa.RandomizedResponse(["f", "x"], keep_probability="0.7")), "no law"),
        (lambda: example().behind(group=fa.Product({"a": fa.Identity("fm"), "b": fa.Identity("fm")})), "covers 2 columns"),
        (lambda: example().behind(group=fa.Identity(["f"])), "only one input"),
        (lambda: example().behind(group=fa.Identity("fm"), population=[[1, 2, 3]]), "shape"),
        (lambda: example().behind(group=fa.Identity("fm"), population=[[0, 0]]), "every mass"),
        (lambda: example().behind(group=fa.Identity("fm"), population=[[1, -1]]), "negative"),
        (lambda: example().behind(group=fa.Identity("fm"), population={("", "q"): 1}), "not a true context"),
        (lambda: fa.certify(example().behind(group=fa.Identity("fm")), {"hire": 1}, declared={"tau": "0.3"}), "only 0.2"),
        (lambda: fa.certify(example().behind(group=fa.Identity("fm")), {"hire": 1}, declared={"gamma": "0.5"}), "at least that"),
        (lambda: fa.certify(example().behind(group=fa.Identity("fm")), {"hire": 1}, declared={"taw": 1}), "did you mean 'tau'"),
        (lambda: fa.certify(example().law, {"hire": 1}, declared={"tau": 0}), "policy behind filters"),
        (lambda: fa.policy_source("nothing"), "no policy plug-in"),
        (lambda: fa.sample_policy(lambda x, a: "go", [], 3), "no cell"),
        (lambda: fa.sample_policy(lambda x, a: None, [("", "f")], 3), "None"),
        (lambda: fa.sample_policy(lambda x, a: "go", [("", "f")], 0), "0 trials"),
    ],
)
def test_refusals(build: Any, word: str) -> None:
    with pytest.raises(InputError, match=word):
        build()


def test_sampling_a_black_box_counts_its_answers() -> None:
    answers = iter(["go", "stay", "go", "go", "go", "go"])
    counts = fa.sample_policy(lambda x, a: next(answers), [("hall", "f"), ("hall", "m")], trials=3)
    policy = Policy.from_counts(counts, decision="decision", group="group", context="context", count="count")
    result = fa.certify(policy.behind(group=fa.Identity(["f", "m"])), {"go": 1})
    assert result.local.ratio == F(3, 2)
    judged = fa.certify(policy.behind(group=fa.Identity(["f", "m"])), {"go": 1}, max_local_log="0.2")
    assert judged.verdict == "inconclusive"


def test_a_plug_in_is_found_by_its_entry_point(tmp_path: Path) -> None:
    """A distribution that registers a source, installed by hand into a folder on the path."""
    (tmp_path / "robot.py").write_text(
        "class Robot:\n"
        "    def cells(self):\n        return [('hall', 'f'), ('hall', 'm')]\n"
        "    def decide(self, context, group, trial):\n        return 'go' if group == 'f' or trial % 2 else 'stay'\n"
    )
    info = tmp_path / "robot-1.0.dist-info"
    info.mkdir()
    (info / "METADATA").write_text("Metadata-Version: 2.1\nName: robot\nVersion: 1.0\n")
    (info / "entry_points.txt").write_text("[fairaudit.policies]\nrobot = robot:Robot\n")
    code = (
        "import fairaudit as fa\n"
        "policy = fa.Policy.from_source(fa.policy_source('robot'), trials=10)\n"
        "print(fa.certify(policy.behind(group=fa.Identity(['f', 'm'])), {'go': 1}).local.ratio)\n"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, env={"PYTHONPATH": str(tmp_path)}, check=True)
    assert done.stdout == "2\n"


AUDIT = """
[policy]
table = "policy.csv"
decision = "u"
group = ["a", "b"]
context = "x"
probability = "p"

[filter.group]
kind = "product"
[filter.group.a]
kind = "randomized-response"
exp_epsilon = "7/3"
[filter.group.b]
kind = "randomized-response"
keep_probability = 0.7

[filter.context]
kind = "identity"

[population]
table = "people.csv"
weight = "n"

[utility]
values = { go = 1, wait = 0.5 }
tau = 0.1

[targets]
max_local_log = 2
"""


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    lines, people = ["u,a,b,x,p"], ["x,a,b,n"]
    for x in ("hall", "yard"):
        for a in ("f", "m"):
            for b in ("old", "young"):
                p = 5 + 2 * (a == "f") + (b == "old") - (x == "hall")
                lines += [f"go,{a},{b},{x},0.0{p}", f"wait,{a},{b},{x},0.5", f"stay,{a},{b},{x},0.4{10 - p}"]
                people.append(f"{x},{a},{b},{p}")
    (tmp_path / "policy.csv").write_text("\n".join(lines) + "\n")
    (tmp_path / "people.csv").write_text("\n".join(people) + "\n")
    (tmp_path / "audit.toml").write_text(AUDIT)
    return tmp_path


def test_an_audit_file_end_to_end(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    from fairaudit.cli import main

    target = folder / "c.json"
    assert main(["certify", str(folder / "audit.toml"), "-o", str(target), "--verbose"]) == 0
    out = capsys.readouterr().out
    assert "WITHIN" in out
    assert "e^ε = 49/9" in out
    assert "of single attributes e^ε is 7/3, 7/3" in out
    assert main(["verify", str(target), "--require", "within"]) == 0
    document = json.loads(target.read_text())
    assert document["subject"]["privacy"] == {
        "group": {"exp_epsilon": "49/9", "attributes": ["7/3", "7/3"]},
        "context": {"exp_epsilon": "inf", "attributes": ["inf"]},
    }
    assert document["subject"]["declared"] == {"tau": "1/10"}
    policy = fa.Policy.from_probabilities(fa.read_csv(folder / "policy.csv"), decision="u", group=["a", "b"], context="x", probability="p")
    coin = {"a": fa.RandomizedResponse("fm", exp_epsilon="7/3"), "b": fa.RandomizedResponse(["old", "young"], keep_probability="0.7")}
    by_hand = brute_force(policy.behind(group=fa.Product(coin)))
    ratios = [
        (by_hand[x, a][0] + by_hand[x, a][1] / 2) / (by_hand[x, b][0] + by_hand[x, b][1] / 2)
        for x, a in by_hand
        for y, b in by_hand
        if x == y
    ]
    assert document["metrics"]["local"]["ratio"] == str(max(ratios))


@pytest.mark.parametrize(
    ("old", "new", "word"),
    [
        ("[targets]", "[target]", "'targets'"),
        ("max_local_log", "max_locl", "'max_local_log'"),
        ('kind = "identity"', 'kind = "identical"', "'identity'"),
        ('exp_epsilon = "7/3"', 'exp_epsilon = "1/3"', "at least 1"),
        ("keep_probability = 0.7", "keep_probability = 1.7", "from 0 to 1"),
        ("keep_probability = 0.7", "keep_probability = 0.7\nepsilon = 1", "give one of"),
        ("keep_probability = 0.7", "epsilon = -1", "at least 0"),
        ("[filter.group.b]\nkind", "[filter.group.c]\nkind", "'c'"),
        ("tau = 0.1", "tau = 0.9", "declare at most"),
        ("tau = 0.1", "gamma = 0.1", "declare at least"),
        ("values = { go = 1, wait = 0.5 }", "values = { run = 1 }", "'run'"),
        ('weight = "n"', 'weight = "m"', "no column 'm'"),
        ('table = "policy.csv"', 'table = "nothing.csv"', "no such file"),
        ("[population]", "[population", "not a TOML file"),
        ('probability = "p"', 'probability = "p"\ncount = "p"', "both count and probability"),
        ('[filter.context]\nkind = "identity"', "[filter]\ncontext = 3", "TOML|section"),
    ],
)
def test_refusals_of_an_audit_file(folder: Path, capsys: pytest.CaptureFixture[str], old: str, new: str, word: str) -> None:
    import re

    from fairaudit.cli import main

    assert old in AUDIT
    (folder / "audit.toml").write_text(AUDIT.replace(old, new))
    assert main(["certify", str(folder / "audit.toml"), "-o", str(folder / "c.json")]) == 2
    out, err = capsys.readouterr()
    assert out == ""
    assert err.count("\n") == 1
    assert "audit.toml" in err
    assert re.search(word, err), err
    assert not (folder / "c.json").exists()


def test_a_deployment_says_how_many_releases_one_memory_sees() -> None:
    policy = Policy.from_array([["0.9", "0.1"], ["0.2", "0.8"]], decisions=["hire", "pass"], groups=["f", "m"])
    coin = fa.RandomizedResponse(["f", "m"], keep_probability="0.75")
    once, often = policy.behind(group=coin), policy.behind(group=coin, releases=20)
    assert (once.releases, often.releases) == (1, 20)
    assert once.law.weights.tolist() == often.law.weights.tolist()


@pytest.mark.parametrize("releases", [0, 10_001, True, 2.0, "2", None])
def test_releases_that_are_no_number_are_refused(releases: Any) -> None:
    policy = Policy.from_array([["0.9", "0.1"], ["0.2", "0.8"]], decisions=["hire", "pass"], groups=["f", "m"])
    with pytest.raises(InputError, match="a whole number"):
        policy.behind(group=fa.RandomizedResponse(["f", "m"], keep_probability="0.75"), releases=releases)
