"""Where a filter makes things worse, and more people than two: exact numbers by hand, and the definitions as plain loops."""

from __future__ import annotations

import itertools
import json
from dataclasses import replace
from fractions import Fraction
from math import e
from pathlib import Path

import pytest

import fairaudit as fa
from fairaudit import checker
from fairaudit.cli import main
from fairaudit.errors import InputError
from fairaudit.plugins.vlm.analyse import certify, exact_table, questions
from fairaudit.plugins.vlm.experiment import Experiment, Setting, bundled, read_experiment
from fairaudit.plugins.vlm.makers import StandIn
from fairaudit.plugins.vlm.report import _stems

HALF, ONE = Fraction(1, 2), Fraction(1)


def test_privacy_of_the_context_worsens_the_whole_by_the_papers_example() -> None:
    """Supporting Information C: parity on the whole without a filter, R̄ = 4 behind (9/10, 1/10; 7/10, 3/10), whose ε is log 3."""
    table = [[[1, 0], [0, 1]], [[0, 1], [1, 0]]]
    policy = fa.Policy.from_array(table, decisions=["1", "0"], groups=["0", "1"], contexts=["0", "1"])
    blur = fa.Mechanism.from_array([["0.9", "0.1"], ["0.7", "0.3"]], ["0", "1"], ["0", "1"])
    assert fa.pure_dp(blur).exp_epsilon == 3
    shown = fa.Identity(["0", "1"])
    before = fa.certify(policy.behind(group=shown, context=fa.Identity(["0", "1"])), {"1": 1})
    after = fa.certify(policy.behind(group=shown, context=blur), {"1": 1})
    assert (before.global_.ratio, after.global_.ratio) == (1, 4)
    assert after.local.ratio == 9 < before.local.ratio


def test_privacy_of_the_group_may_worsen_every_measure() -> None:
    """The paper's own A, three attributes of two values: the people who exist are treated alike, those whom a filter makes up are not.

    f = 1/2 for both true profiles, 1 for those that differ from the first in one attribute, 0 for the rest. With p = 7/10 the first one's
    mean is (p³+q³)/2 + 3p²q = 626/1000, the other's (p³+q³)/2 + 3pq² = 374/1000. Unfiltered R = 1; e^ε = (7/3)³ holds all the same.
    """
    values = ("a", "b")
    cells = list(itertools.product(values, repeat=3))
    chance = {0: HALF, 1: ONE, 2: Fraction(0), 3: HALF}
    rows = [[[chance[cell.count("b")], 1 - chance[cell.count("b")]] for cell in cells]]
    policy = fa.Policy.from_array(rows, decisions=["chosen", "not"], groups=cells)
    coin = fa.Product({str(i): fa.RandomizedResponse(values, keep_probability="0.7") for i in range(3)})
    two = fa.Mechanism.from_array(
        [[Fraction(n, coin.denominator) for n in coin.row(label)] for label in (cells[0], cells[-1])], [cells[0], cells[-1]], cells
    )
    result = fa.certify(policy.behind(group=two), {"chosen": 1})
    assert [found.ratio for found in result.unfiltered] == [1, 1]
    assert result.local.ratio == result.global_.ratio == Fraction(626, 374)
    assert result.local.ratio < fa.pure_dp(two).exp_epsilon == Fraction(7, 3) ** 3


def test_the_file_that_shows_it(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """By hand: s = e²/(1+e²), m = k/2 + (1−k)/4 of what is shown is maternity leave, and slot 1 gets m·s + (1−m)(1−s) or the rest."""
    experiment = read_experiment("worse-x")
    table = exact_table(experiment, StandIn(experiment).probabilities)
    share = e**2 / (1 + e**2)
    found = {s.context_keep: certify(experiment, table, s, "slot").result for s in experiment.settings}
    assert found[ONE].global_.ratio == 1
    for keep, result in found.items():
        m = float(keep / 2 + (1 - keep) / 4)
        higher = m * (1 - share) + (1 - m) * share
        assert float(result.global_.ratio) == pytest.approx(higher / (1 - higher))
    ordered = [found[keep] for keep in sorted(found)]
    assert all(a.global_.ratio > b.global_.ratio for a, b in itertools.pairwise(ordered))
    assert all(a.local.ratio < b.local.ratio for a, b in itertools.pairwise(ordered))
    assert main(["experiment", "plot", "worse-x", "--folder", str(tmp_path)]) == 0
    capsys.readouterr()
    assert main(["experiment", "certify", "worse-x", "--folder", str(tmp_path)]) == 0
    assert capsys.readouterr().out.count("L̄ of these answers is greater than without a filter") >= 7
    certificate = json.loads((tmp_path / "stand-in.slot.01.certificate.json").read_text())
    assert certificate["subject"]["population"] == "weights"


def people(order: str, number: int = 5) -> Experiment:
    """Five people of one attribute with two values; slot 1 has an advantage."""
    base = read_experiment("worse-x")
    names = "ABCDE"[:number]
    values = ("Tom", "Mary")
    section = {"position": "0.7", "weights": {"name": {"Mary": "1.1"}, "office": {"3": "0.4"}}}
    return replace(
        base,
        options=tuple(f"HR{i + 1}" for i in range(number)),
        attributes={"name": values, "office": tuple("12345"[:number])},
        people={name: (values[i % 2], str(i + 1)) for i, name in enumerate(names)},
        contexts=("sick leave",),
        context_weights=(),
        settings=(Setting(ONE, ONE),),
        order=order,
        stand_in=section,
    )


def test_five_people_in_cyclic_orders() -> None:
    """Everybody stands in every slot once; the means of people are those of a plain loop over the five orders."""
    experiment = people("cyclic")
    orders = experiment.orders
    assert len(orders) == 5
    assert all({order[slot] for order in orders} == set(experiment.people) for slot in range(5))
    maker = StandIn(experiment)
    table = exact_table(experiment, maker.probabilities)
    assert len(table.rows) == 5
    assert questions(experiment) == ("slot", "person", "position")
    means = [
        sum(maker.probabilities("sick leave", experiment.slots(order))[order.index(name)] for order in orders) / 5
        for name in experiment.people
    ]
    assert sum(means) == 1
    assert certify(experiment, table, Setting(ONE, ONE), "person").result.local.ratio == max(means) / min(means)
    slots = [sum(maker.probabilities("sick leave", experiment.slots(order))[slot] for order in orders) / 5 for slot in range(5)]
    assert certify(experiment, table, Setting(ONE, ONE), "position").result.local.ratio == max(slots) / min(slots)


def test_cyclic_orders_hide_less_of_a_person_than_all_orders() -> None:
    """Of three people with one attribute each: exchanging two costs (p/q)² where every order may be drawn; a rotation moves everybody."""
    base = replace(people("both", 3), attributes={"name": ("Tom", "Mary", "Ann")}, stand_in={"weights": {"name": {"Mary": "1"}}})
    base = replace(base, people={name: (name,) for name in ("Tom", "Mary", "Ann")})
    setting = Setting(Fraction(4, 5), ONE)
    found = {}
    for order in ("both", "cyclic"):
        experiment = replace(base, order=order, settings=(setting,))
        table = exact_table(experiment, StandIn(experiment).probabilities)
        found[order] = certify(experiment, table, setting, "person")
        assert found[order].result.local.ratio <= found[order].exp_epsilon
    assert found["both"].exp_epsilon == 8**2  # p/q with three values: 0.8 to 0.1
    assert found["cyclic"].exp_epsilon == 8**3


def test_a_limit_on_what_is_asked(tmp_path: Path) -> None:
    """Twelve people in cyclic orders are 36 prompts; in every order they would be 12! and are refused before anything is laid out."""
    text = bundled()["worse-x"].read_text("utf-8")
    names = [f"P{i}" for i in range(12)]
    text = text.replace('options = ["HR1", "HR2"]', f"options = {json.dumps([f'HR{i}' for i in range(12)])}")
    text = text.replace('name = ["Tom", "Mary"]', f"name = {json.dumps(names)}")
    start, end = text.index("[people.Tom]"), text.index("[prompt]")
    text = text[:start] + "".join(f'[people.{n}]\nname = "{n}"\n' for n in names) + text[end:]
    text = text[: text.index("[stand-in.contexts")] + '[stand-in.weights.name]\nP3 = "1"\n'
    path = tmp_path / "e.toml"
    path.write_text(text.replace("trials = 400", 'trials = 2\norder = "cyclic"'))
    assert len(read_experiment(str(path)).cells()) == 36
    path.write_text(text)
    with pytest.raises(InputError, match='1,437,004,800 combinations of order and profiles, more than 20,000; take order = "cyclic"'):
        read_experiment(str(path))
    path.write_text(text.replace("trials = 400", 'trials = 2\norder = "cyclic"').replace('"1/3"', '"1/3"]\nkeep_probability = ["0.95"'))
    with pytest.raises(InputError, match="more than 20,000; leave out people"):
        read_experiment(str(path))
    path.write_text(text.replace('weights = ["2", "1", "1"]', 'weights = ["2", "1"]'))
    with pytest.raises(InputError, match="one for each value"):
        read_experiment(str(path))


@pytest.mark.parametrize(
    ("name", "setting"), [("epsilon-x", Setting(ONE, Fraction(7, 10))), ("waiting-time", Setting(Fraction(4, 5), ONE))]
)
@pytest.mark.parametrize("confidence", [None, "0.95"])
def test_certificates_with_unreadable_answers_are_true(name: str, setting: Setting, confidence: str | None, tmp_path: Path) -> None:
    """Of draws and of known probabilities, in both questions: the checker finds every statement true, and every meaning is in the range."""
    base = read_experiment(name)
    experiment = replace(base, settings=(setting,), stand_in={**base.stand_in, "unreadable": "0.2"})
    exact = exact_table(experiment, StandIn(experiment).probabilities)
    counts = {cell: {option: Fraction(int(40 * share)) for option, share in row.items()} for cell, row in exact.rows.items()}
    for table in (exact, replace(exact, rows=counts, sampled=True)):
        for question in ("slot", "person"):
            found = certify(experiment, table, setting, question, confidence=confidence, targets={"max_local_ratio": "11/10"})
            place = tmp_path / f"{question}.json"
            found.result.certificate.save(place)
            assert checker.main([str(place)]) == 0
            assert found.result.undecided.decisions == ("unreadable",)
            for option in experiment.options:
                rows = {
                    key: {u: row[u] + (row["unreadable"] if u == option else 0) for u in experiment.options}
                    for key, row in table.rows.items()
                }
                one = certify(experiment, replace(table, rows=rows), setting, question, confidence=None).result
                for quantity, ratio in (("local", one.local.ratio), ("global", one.global_.ratio)):
                    assert found.meanings[quantity][0] <= ratio <= found.meanings[quantity][1]


def test_no_reading_of_unreadable_answers_exceeds_the_filter() -> None:
    """At ε = 0 everybody is treated alike, whatever anybody meant; the ranges of the figure say so."""
    base = read_experiment("waiting-time")
    setting = Setting(HALF, ONE)
    experiment = replace(base, settings=(setting,), stand_in={**base.stand_in, "unreadable": "0.3"})
    table = exact_table(experiment, StandIn(experiment).probabilities)
    for question in ("slot", "person"):
        assert certify(experiment, table, setting, question).meanings == {"local": (1, 1), "global": (1, 1)}


def test_files_go_where_they_are_asked_for(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    folder, apart = tmp_path / "answers", tmp_path / "a" / "figures"
    words = ["experiment", "plot", "document-delivery", "--folder", str(folder), "--maker", "stand-in", "--trials", "2"]
    assert main([*words, "-o", str(tmp_path / "fairness.svg")]) == 0
    assert (tmp_path / "fairness.svg").read_bytes().startswith(b"<?xml")
    assert not (folder / "figure.png").exists()
    assert main(["experiment", "certify", *words[2:5], "--trials", "2", "-o", str(apart)]) in (0, 1, 3)
    assert {"results.json", "stand-in.person.certificate.json", "stand-in.counts.csv"} <= {path.name for path in apart.iterdir()}
    capsys.readouterr()
    for wrong, why in (
        ("figure.bmp", "ends in .png, .svg or .pdf"),
        ("none/figure.png", "there is no folder"),
        ("x.png", "it is a folder"),
    ):
        (tmp_path / "x.png").mkdir(exist_ok=True)
        assert main([*words, "-o", str(tmp_path / wrong)]) == 2
        assert why in capsys.readouterr().err


@pytest.mark.parametrize(
    ("models", "stems"),
    [
        (["gpt-4o at https://a/v1"], ["gpt-4o"]),
        (["org/m at http://127.0.0.1:80/v1", "stand-in (stand-in)"], ["org-m", "stand-in"]),
        (["m at http://a/v1", "m at http://b/v1"], ["m-at-http-a-v1", "m-at-http-b-v1"]),
        (["m (stand-in)", "m at http://b/v1", "m-stand-in at http://c/v1"], ["m-stand-in", "m-at-http-b-v1", "m-stand-in-3"]),
        (["模型 at http://a/v1"], ["at-http-a-v1"]),
        (["a?b (stand-in)", "a!b (stand-in)"], ["a-b-stand-in", "a-b-stand-in-2"]),
    ],
)
def test_files_are_named_after_the_decision_maker(models: list[str], stems: list[str]) -> None:
    assert list(_stems(models).values()) == stems
