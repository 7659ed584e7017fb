"""Decisions of unknown meaning in audits: ranges, intervals that hold whatever they meant, targets, and what is refused."""

from __future__ import annotations

import csv
import json
import os
import random
from collections.abc import Sequence
from fractions import Fraction
from itertools import product
from math import inf
from pathlib import Path
from typing import Any

import pytest
from certificate_kinds import outcome
from evaluation_changes import audited, log_of

import fairaudit as fa
from fairaudit import checker
from fairaudit.audits.undecided import Undecided
from fairaudit.cli import main
from fairaudit.inference.by_context import contexts_by_themselves

F = Fraction
RUNS = int(os.environ.get("FAIRAUDIT_UNDECIDED_RUNS", "120"))
"""Simulated audits; 2,000 in the measurement that docs/undecided.md names."""

LOG = {"u": ["yes", "no", "refused"] * 2, "a": ["f"] * 3 + ["m"] * 3, "n": [300, 100, 4, 200, 180, 20]}


def counted(table: dict[str, list[Any]], **columns: str) -> fa.Law:
    return fa.Law.from_counts(table, decision="u", group="a", count="n", **columns)


def true(result: fa.Result) -> bool:
    return checker.check(json.dumps(result.certificate.document).encode()).ok


def test_the_range_of_a_table_and_what_is_judged_by_it() -> None:
    """Of 404 women 300 to 304 may have been hired, of 400 men 200 to 220."""
    found = fa.certify(counted(LOG), {"yes": 1}, undecided="refused", confidence=None, max_local_ratio="3/2")
    own = found.whatever[0]
    assert (own.quantity, own.least, own.greatest) == ("local", F(300, 404) / F(220, 400), F(304, 404) / F(200, 400))
    assert own.greatest_at == ({}, {"a": "f"}, {"a": "m"}) == own.least_at
    assert found.local is not None and found.local.ratio == F(300, 404) / F(1, 2) < F(3, 2)  # at face value within
    assert [(target.verdict, target.under) for target in found.targets] == [("depends", "whatever the undecided meant")]
    assert (found.verdict, found.exit_code) == ("depends", 3)
    for limit, verdict in ((own.greatest, "within"), (own.least, "depends"), (own.least - F(1, 10**6), "exceeds")):
        assert fa.certify(counted(LOG), {"yes": 1}, undecided="refused", confidence=None, max_local_ratio=limit).verdict == verdict
    assert true(found)


def test_logarithms_and_both_quantities() -> None:
    table = {**{key: value * 2 for key, value in LOG.items()}, "x": ["p"] * 6 + ["q"] * 6}
    found = fa.certify(
        counted(table, context="x"), {"yes": 1}, undecided=["refused"], confidence=None, max_local_log="0.41", max_global_log="0.2"
    )
    assert [target.verdict for target in found.targets] == ["within", "exceeds"]
    assert [own.quantity for own in found.whatever] == ["local", "global"]
    assert true(found)


def brute(rows: Sequence[tuple[str, str, str, int]], undecided: set[str], worth: dict[str, Fraction]) -> tuple[set[Any], set[Any]]:
    """The local and the global ratio for every meaning of every single row among the least and the greatest value."""
    ends = min(worth.values()), max(worth.values())
    listed = [(x, a, u) for u, a, x, n in rows for _ in range(n)]
    places = [i for i, (_, _, u) in enumerate(listed) if u in undecided]
    local, overall = set(), set()
    for meanings in product(ends, repeat=len(places)):
        values = [worth[u] for _, _, u in listed]
        for place, value in zip(places, meanings, strict=True):
            values[place] = value
        for found, key in ((local, lambda row: row[:2]), (overall, lambda row: (None, row[1]))):
            cells: dict[Any, list[Fraction]] = {}
            for row, value in zip(listed, values, strict=True):
                cells.setdefault(key(row), []).append(value)
            means = {cell: sum(own) / len(own) for cell, own in cells.items()}
            found.add(max(quotient(means[one], means[other]) for one, other in product(means, means) if one[0] == other[0]))
    return local, overall


def quotient(top: Fraction, bottom: Fraction) -> Any:
    return (inf if top else F(1)) if not bottom else top / bottom


@pytest.mark.parametrize("seed", range(12))
def test_random_tables_against_all_meanings(seed: int) -> None:
    pick = random.Random(seed)
    worth = pick.choice([{"yes": F(1), "no": F(0)}, {"yes": F(3), "no": F(1)}])
    rows = [(u, a, x, pick.randint(0 if a == "f" else 1, 3)) for u in ("yes", "no") for a in "fm" for x in "pq"]
    rows += [(u, a, x, 1) for u, a, x in (("lost", "f", "p"), ("lost", "m", "p"), ("cut", "f", "q"), ("lost", "m", "q"))]
    rows = [row for row in rows if row[3]]
    table = dict(zip("uaxn", map(list, zip(*rows, strict=True)), strict=True))
    found = fa.certify(
        counted(table, context="x"), {**worth, "lost": worth["no"], "cut": worth["no"]}, undecided=("lost", "cut"), confidence=None
    )
    of_rows = brute(rows, {"lost", "cut"}, {**worth, "lost": worth["no"], "cut": worth["no"]})
    for own, every in zip(found.whatever, of_rows, strict=True):
        assert own.greatest == max(every) and own.least <= min(every)
        if found.local is not None and found.global_ is not None:
            face = found.local.ratio if own.quantity == "local" else found.global_.ratio
            assert own.least <= face <= own.greatest
    assert true(found)


def test_the_range_is_that_of_the_utility_or_what_is_declared() -> None:
    """A decision that never occurred counts if the utility names it; so does the face value of the undecided themselves."""
    table = {"u": ["yes", "refused", "yes", "refused"], "a": ["f", "f", "m", "m"], "n": [3, 1, 2, 2]}
    law = counted(table)
    found = fa.certify(law, {"yes": 1}, undecided="refused", confidence=None)
    assert found.undecided == Undecided(("refused",), F(0), F(1))
    assert (found.whatever[0].least, found.whatever[0].greatest) == (1, 2)
    found = fa.certify(law, {"yes": 1, "more": 2}, undecided="refused", confidence=None)
    assert (found.undecided.most, found.whatever[0].greatest) == (2, F(5, 2))  # type: ignore[union-attr]
    found = fa.certify(law, {"yes": 1}, undecided="refused", confidence=None, declared={"gamma": 3})
    assert (found.undecided.most, found.whatever[0].greatest) == (3, 3)  # type: ignore[union-attr]
    found = fa.certify(law, {"yes": 2, "refused": 1}, undecided="refused", confidence=None, declared={"m": 1})
    assert (found.whatever[0].least, found.whatever[0].greatest) == (1, F(4, 3))
    assert true(found)


def test_a_utility_of_each_cell() -> None:
    law = counted({"u": ["yes", "no", "?"] * 2, "a": ["f"] * 3 + ["m"] * 3, "n": [3, 1, 1, 2, 1, 0]})
    utility = fa.Utility.from_function(lambda u, x, a: {"yes": 2 if a == ("f",) else 1, "no": 0, "?": 0}[u], law)
    found = fa.certify(law, utility, undecided="?", max_local_ratio=2)
    own = found.whatever[0]  # f: 6/5 to 8/5; m: 2/3
    assert (own.least, own.greatest) == (F(6, 5) / F(2, 3), F(8, 5) / F(2, 3))
    assert true(found)


def test_probabilities_and_a_policy_behind_a_filter() -> None:
    law = fa.Law.from_array([["1/2", "1/4", "1/4"], ["1/2", "1/2", "0"]], decisions=["yes", "no", "refused"])
    found = fa.certify(law, {"yes": 1}, undecided="refused", max_local_ratio="5/4")
    assert [(own.least, own.greatest) for own in found.whatever] == [(1, F(3, 2))] * 2
    assert found.verdict == "depends" and true(found)
    counts = fa.Law.from_array([[50, 25, 25], [50, 50, 0]], kind="counts", decisions=["yes", "no", "refused"], groups=["f", "m"])
    behind = fa.Policy(counts).behind(group=fa.RandomizedResponse(["f", "m"], keep_probability="3/4"))
    found = fa.certify(behind, {"yes": 1}, undecided="refused", max_local_ratio=2)
    assert found.whatever[0].greatest == F(11, 16) / F(1, 2)
    listed = [text for claim in found.claims if claim.by == "T19" for text in claim.assumptions]
    assert "what an undecided decision meant depends on group and context only through what the filters release" in listed
    assert true(found)


# The population


def test_the_interval_is_the_box_of_the_outer_draws() -> None:
    """Lower ends are those of a log in which the undecided were worth the least, upper ends of one in which they were worth the most."""
    found = fa.certify(counted(LOG), {"yes": 1}, undecided="refused", max_local_ratio=2)
    own = found.intervals["local"].evidence
    low, high = (
        fa.certify(
            counted({**LOG, "u": [meant if u == "refused" else u for u in LOG["u"]]}),
            {"yes": 1},
            max_local_ratio=2,
            interval="hoeffding-kl",
        )
        for meant in ("no", "yes")
    )
    for side in ("upper", "lower"):
        below, above = (one.intervals["local"].evidence[side] for one in (low, high))
        assert own[side] == [[a, b] for (a, _), (_, b) in zip(below, above, strict=True)]
    assert found.intervals["local"].lower <= low.intervals["local"].lower and found.targets[0].confidence == F(19, 20)
    assert true(found)


def test_it_holds_whatever_was_meant() -> None:
    """Coverage with meanings that are as bad as they can be, given what was drawn: the true ratio of the population stays inside."""
    pick, missed = random.Random(20), {"upper": 0, "lower": 0}
    chances = {"f": (F(1, 2), F(1, 10)), "m": (F(3, 10), F(1, 5))}  # yes, undecided
    worst = (F(1, 2) + F(1, 10)) / F(3, 10)  # every undecided woman meant yes, every undecided man no
    best = F(1, 2) / (F(3, 10) + F(1, 5))
    for _ in range(RUNS):
        rows = []
        for a, (yes, lost) in chances.items():
            drawn = [pick.random() for _ in range(100)]
            counts = [sum(v < yes for v in drawn), sum(yes <= v < yes + lost for v in drawn)]
            rows += [("yes", a, counts[0]), ("?", a, counts[1]), ("no", a, 100 - sum(counts))]
        table = dict(zip("uan", map(list, zip(*rows, strict=True)), strict=True))
        found = fa.certify(counted(table), {"yes": 1}, undecided="?", max_local_ratio=3, confidence="0.8").intervals["local"]
        missed["upper"] += found.upper < worst
        missed["lower"] += found.lower > best
    assert missed["upper"] <= 0.2 * RUNS and missed["lower"] <= 0.2 * RUNS


def test_units_are_means_over_their_rows() -> None:
    pick = random.Random(3)
    rows = [(pick.choice(["yes", "no", "no", "?"]), pick.choice("fm"), str(pick.randrange(60))) for _ in range(300)]
    law = fa.Law.from_log(dict(zip("uap", map(list, zip(*rows, strict=True)), strict=True)), decision="u", group="a", unit="p")
    found = fa.certify(law, {"yes": 1}, undecided="?", max_local_ratio=3)
    assert found.intervals["local"].region == "box" and found.targets[0].estimand == "mean over units"
    assert true(found)


@pytest.mark.parametrize("utility", [{"yes": 1}, {"yes": 1, "maybe": "1/2"}])
def test_many_cells(utility: dict[str, Any]) -> None:
    pick = random.Random(4)
    rows = [(u, a, str(x), pick.randint(1, 40)) for u in ("yes", "maybe", "no", "?") for a in "fm" for x in range(90)]
    table = dict(zip("uaxn", map(list, zip(*rows, strict=True)), strict=True))
    found = fa.certify(counted(table, context="x"), utility, undecided="?", max_local_ratio=3)
    assert len(found.comparisons["local"].cells) == 180 and true(found)


def test_no_bound_of_a_theorem_stands_for_the_interval() -> None:
    """Theorems about policies are about the utility at face value; whatever refusals meant, only the draws decide."""
    counts = fa.Law.from_array([[5, 2, 3], [5, 5, 1]], kind="counts", decisions=["yes", "no", "?"], groups=["f", "m"])
    behind = fa.Policy(counts).behind(group=fa.RandomizedResponse(["f", "m"], keep_probability="3/5"))
    found = fa.certify(behind, {"yes": 1}, undecided="?", max_local_ratio="3/2", declared={"gamma": 1, "m": 0})
    assert found.targets[0].upper is not None and found.targets[0].upper[1] == "the interval" and true(found)


# Real data


def test_scores_that_are_missing(data: Path) -> None:
    """The table of docs/undecided.md: 1,458 scores for each race would be complete."""
    path = data / "hiring_scores" / "gpt-3.5-turbo.csv"
    scores = [(row["race"], int(row["Total"])) for row in csv.DictReader(path.read_text("utf-8").splitlines())]
    for cut, upper, verdict in ((65, "1.2199", "within"), (70, "1.2629", "inconclusive"), (75, "1.4430", "inconclusive")):
        counts = [[sum(a == race and (n > cut) is above for a, n in scores) for above in (True, False)] for race in ("White_US", "AA_US")]
        rows = [[above, below, 1458 - above - below] for above, below in counts]
        assert [row[2] for row in rows] == [71, 84]
        law = fa.Law.from_array(rows, kind="counts", decisions=["above", "not above", "missing"], groups=["White", "Black"])
        table = fa.certify(law, {"above": 1}, undecided="missing", confidence=None, max_local_ratio="5/4")
        least, most = ([F(row[0] + extra * row[2], 1458) for row in rows] for extra in (0, 1))
        assert table.whatever[0].greatest == max(most[0] / least[1], most[1] / least[0]) and table.whatever[0].least == 1
        of_population = fa.certify(law, {"above": 1}, undecided="missing", max_local_ratio="5/4")
        assert (table.verdict, of_population.verdict) == ("within", verdict)
        assert abs(float(of_population.intervals["local"].upper) - float(upper)) < 1e-4


# What is refused


@pytest.mark.parametrize(
    ("options", "said"),
    [
        (
            {"undecided": "refusd"},
            "undecided names the decision 'refusd', which does not occur; known: 'yes', 'no', 'refused'; did you mean 'refused'?",
        ),
        ({"undecided": ["refused", "refused"]}, "undecided names the decision 'refused' twice"),
        ({"undecided": ["yes", "no", "refused"]}, "every decision is undecided"),
        ({"undecided": "refused", "difference": True}, "do not go with differences"),
        ({"undecided": "refused", "max_drift": "0.1"}, "do not go with max_drift"),
        ({"undecided": "refused", "hidden_context": "2,2"}, "do not go with hidden_context"),
        ({"undecided": "refused", "select": "half-split", "independent": True}, "do not go with a way to choose a pair"),
        ({"undecided": "refused", "missing_units": "drop"}, "missing_units"),
    ],
)
def test_refusals(options: dict[str, Any], said: str) -> None:
    with pytest.raises(fa.InputError, match=said.replace("(", r"\(").replace("?", r"\?")):
        fa.certify(counted(LOG), {"yes": 1}, **options)


def test_unknown_groups_and_true_labels_are_refused() -> None:
    columns: dict[str, Any] = {"decision": "u", "group": "a", "count": "n", "utility": "yes", "undecided": "refused"}
    with pytest.raises(fa.InputError, match="do not go with decisions of unknown group"):
        fa.audit({**LOG, "a": ["f", "f", "?", "m", "m", "m"]}, **columns, unknown="?")
    with pytest.raises(fa.InputError, match="do not go with true labels"):
        fa.audit({**LOG, "t": ["1"] * 6}, **columns, truth="t", positive="1")


LOST = [("A", "a", "age", 30), ("B", "a", "age", 10), ("A", "b", "age", 20), ("B", "b", "age", 10), ("refused", "b", "age", 10)]


def test_answers_of_an_evaluation_log_that_decide_nothing_may_have_meant_anything() -> None:
    result = audited(log_of(LOST), confidence=None, max_local_ratio="5/4")
    assert result.undecided is not None and result.undecided.decisions == ("refused",)
    assert [(one.quantity, one.least, one.greatest) for one in result.whatever] == [
        ("local", 1, Fraction(3, 2)),
        ("global", 1, Fraction(3, 2)),
    ]
    assert result.verdict == "depends"


def test_what_the_utility_says_of_them_is_known() -> None:
    law = fa.Law.from_log(log_of(LOST), decision="answer", group="race", context="topic")
    assert fa.certify(law, {"A": 1, "refused": 0}).undecided is None


def test_what_cannot_be_bounded_is_said_or_refused() -> None:
    rows = [*LOST, ("error", "a", "age", 3)]
    result = audited(log_of(rows, errors="drop"), difference=True)
    assert result.undecided is None and any("'refused': what these answers may have meant is not bounded" in note for note in result.notes)
    with pytest.raises(fa.InputError, match="so that targets are judged whatever they meant, and that does not go with differences"):
        audited(log_of(rows, errors="drop"), max_difference="0.1")
    with pytest.raises(fa.InputError, match="errors that are bounded are decisions of unknown meaning, which do not go with differences"):
        audited(log_of(rows, errors="bound"), difference=True)
    bound = audited(log_of(rows, errors="bound"), undecided="refused", confidence=None)
    assert bound.undecided is not None and bound.undecided.decisions == ("error", "refused")


def test_further_decisions_are_undecided_beside_those_of_the_log() -> None:
    """Else a refusal would count as worth nothing as soon as another answer is named."""
    rows = [*LOST, ("unsure", "a", "age", 5), ("truncated", "a", "age", 2)]
    found = audited(log_of(rows), undecided="unsure", confidence=None).undecided
    assert found is not None and found.decisions == ("refused", "truncated", "unsure")
    found = audited(log_of(rows), utility={"A": 1, "refused": 0}, undecided="unsure", confidence=None).undecided
    assert found is not None and found.decisions == ("truncated", "unsure")


def test_errors_that_are_said_to_be_bounded_are_undecided() -> None:
    rows = [*LOST, ("error", "a", "age", 3)]
    document = json.loads(audited(log_of(rows, errors="bound"), confidence=None).certificate.text)
    assert outcome(json.dumps(document).encode()) == "true"
    document["subject"]["undecided"]["decisions"] = ["refused"]
    assert outcome(json.dumps(document).encode()) == "malformed"
    del document["subject"]["undecided"]
    document["claims"] = [claim for claim in document["claims"] if claim["by"] != "T19"]
    assert outcome(json.dumps(document).encode()) == "malformed"


def test_what_is_tested_beside_holds_whatever_they_meant(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """A refutation rests on the interval that does; contexts by themselves are refused."""
    table = {**{key: value * 2 for key, value in LOG.items()}, "x": ["p"] * 6 + ["q"] * 6}
    found = fa.certify(counted(table, context="x"), {"yes": 1}, undecided="refused", independent=True, max_local_ratio=2)
    tested = fa.refute_epsilon(found.comparisons["local"], "1.01", confidence="0.95", independent=True)
    assert tested.interval.region == "box" and tested.interval.upper == inf
    plain = fa.certify(counted(table, context="x"), {"yes": 1}, independent=True, max_local_ratio=2)
    assert tested.interval.lower <= fa.refute_epsilon(plain.comparisons["local"], "1.01", independent=True).interval.lower
    with pytest.raises(fa.InputError, match="need decisions of known meaning"):
        contexts_by_themselves(found.comparisons["local"], 2)
    rows = ["u,a,x,n", *(",".join(map(str, row)) for row in zip(*(table[name] for name in "uaxn"), strict=True))]
    (tmp_path / "log.csv").write_text("\n".join(rows) + "\n", "utf-8")
    asked = ["certify", str(tmp_path / "log.csv"), "--decision", "u", "--group", "a", "--context", "x", "--count", "n", "--utility", "yes"]
    asked += ["--undecided", "refused", "--independent-cells", "--max-local-ratio", "2"]
    assert main([*asked, "--claimed-exp-epsilon", "1.01"]) in (0, 1)
    assert "the filter is not what it claims" in " ".join(capsys.readouterr().out.split())
    assert main([*asked, "--by-context", "0.1"]) == 2
    assert "need decisions of known meaning" in capsys.readouterr().err


def test_a_range_of_which_one_end_is_declared() -> None:
    """The undecided decisions are worth more at face value than all others, and are worth less in one of the two extremes."""
    law = counted(LOG)
    for declared in ({"m": 0}, {"gamma": 2}, {"gamma": 3}):
        found = fa.certify(law, {"yes": 1, "refused": 2}, undecided="refused", declared=declared, max_local_ratio=2)
        assert "local" in found.intervals and true(found), declared


def test_a_utility_that_was_read_from_a_column() -> None:
    """Decisions that do not occur in a cell have no utility there, and the range has to be declared."""
    table = {"u": ["yes", "no", "?", "yes", "no"], "a": ["f", "f", "f", "m", "m"], "g": [2, 0, 0, 1, 0], "n": [30, 10, 5, 20, 20]}
    columns: dict[str, Any] = {"decision": "u", "group": "a", "count": "n", "utility_column": "g", "undecided": "?"}
    found = fa.audit(table, **columns, max_local_ratio=9, declared={"gamma": 2, "m": 0})
    own = found.whatever[0]
    assert (own.least, own.greatest) == (F(60, 45) / F(1, 2), F(70, 45) / F(1, 2))
    assert found.intervals["local"].region == "box" and true(found)
    assert true(fa.audit(table, **columns, confidence=None, max_local_ratio=9))


def test_the_sentence_says_what_was_lost_and_the_range() -> None:
    """Of a 3 to 4 of 5, of b 2 of 4: the ratio is from 6/5 to 8/5."""
    rows = [("A", "a", "age", 3), ("B", "a", "age", 1), ("refused", "a", "age", 1), ("A", "b", "age", 2), ("B", "b", "age", 2)]
    found = audited(log_of([*rows, ("error", "b", "age", 1)], errors="drop", expected=12, read=10), confidence=None)
    lost = "Of 10 answers of the evaluation log 2 decide nothing. Of 12 samples 2 are not in the log."
    ends = "the ratio within contexts is from 1.2 to 1.6 and the ratio over all is from 1.2 to 1.6, in the table."
    assert found.sentence.startswith(lost) and found.sentence.endswith(f"Whatever the undecided decisions meant, {ends}")
    table = {"u": ["yes", "no", "refused", "yes", "no"], "a": ["f"] * 3 + ["m"] * 2, "n": [3, 1, 1, 2, 2]}
    own = fa.audit(table, decision="u", group="a", count="n", utility="yes", undecided="refused", confidence=None)
    assert own.sentence.endswith("Whatever the undecided decisions meant, the ratio is from 1.2 to 1.6, in the table.")
    plain = fa.audit(table, decision="u", group="a", count="n", utility="yes", confidence=None)
    assert "undecided" not in plain.sentence and "evaluation log" not in plain.sentence
