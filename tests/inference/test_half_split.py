"""The half-split: it follows from the table alone, errs no more than it says, and is refused where it does not apply.

All 2,000 altered certificates, and 2,000 simulated tables: FAIRAUDIT_FULL=1 pytest -n0 tests/inference/test_half_split.py
"""

from __future__ import annotations

import copy
import json
from collections.abc import Callable
from fractions import Fraction
from math import comb
from random import Random
from typing import Any

import numpy as np
import pytest
import split_oracle
import tiers
from certificates import outcome
from hypothesis import assume, given
from hypothesis import strategies as st

import fairaudit as fa
from fairaudit.cli import main
from fairaudit.errors import InputError
from fairaudit.inference.cells import Cell
from fairaudit.inference.comparisons import Comparison, unit_form
from fairaudit.inference.half_split import HalfSplit
from fairaudit.inference.pair_exact import Pair, order_scale, pair_excludes
from fairaudit.inference.pair_region import pairs_interval
from fairaudit.inference.ratio_intervals import ratio_interval
from fairaudit.inference.table_comparisons import global_comparison, local_comparison
from fairaudit.reports.text import verdict

F = Fraction
ALTERED, TABLES = (2000, 2000) if tiers.FULL else (120, 250)
LABEL = st.one_of(st.sampled_from("fmo"), st.text(st.characters(exclude_categories=("Cs",)), max_size=4).map("l{}l".format))


def compared(counts: np.ndarray[Any, Any], draws: int) -> Comparison:
    """A context for each row of successes, a group for each column."""
    contexts, groups = counts.shape
    cells = tuple(Cell(draws, F(int(k)), None, F(0), F(1), True) for k in counts.ravel())
    blocks = tuple(tuple(unit_form(x * groups + a) for a in range(groups)) for x in range(contexts))
    labels = tuple(({"shop": f"s{x}"}, tuple({"sex": f"g{a}"} for a in range(groups))) for x in range(contexts))
    return Comparison(cells, blocks, labels)


def law(rows: list[tuple[str, str, int, int]]) -> fa.Law:
    """Context, group, successes, draws."""
    table: dict[str, list[Any]] = {"shop": [], "sex": [], "hired": [], "n": []}
    for x, a, k, n in rows:
        for u, count in (("yes", k), ("no", n - k)):
            for column, value in zip(table, (x, a, u, count), strict=True):
                table[column].append(value)
    return fa.Law.from_counts(table, decision="hired", group="sex", context="shop", count="n")


def certified(of: fa.Law, **options: Any) -> fa.Result:
    return fa.certify(of, {"yes": 1}, independent=True, select="half-split", **options)


ROWS = [("x", "f", 30, 41), ("x", "m", 12, 40), ("x", "o", 9, 17), ("y", "f", 21, 40), ("y", "m", 22, 40)]


@given(
    st.dictionaries(
        st.tuples(LABEL, LABEL), st.integers(1, 25).flatmap(lambda n: st.tuples(st.integers(0, n), st.just(n))), min_size=2, max_size=8
    )
)
def test_the_split_is_that_of_the_page(cells: dict[tuple[str, str], tuple[int, int]]) -> None:
    assume(len({x for x, _ in cells}) < len(cells))  # some context has two groups
    own = law([(x, a, k, n) for (x, a), (k, n) in cells.items()])
    split = HalfSplit(local_comparison(own, fa.Utility({"yes": 1}).on(own)))
    blocks: dict[str, dict[bytes, tuple[int, int]]] = {}
    for (x, a), counts in cells.items():
        blocks.setdefault(x, {})[split_oracle.name(({"shop": x}, {"sex": a}))] = counts
    used = [block for block in blocks.values() if len(block) > 1]
    everything = {own_name: counts for block in used for own_name, counts in block.items()}
    assert split.seed == split_oracle.seed(everything)
    halves = {own_name: split_oracle.first_half(split.seed, own_name, *counts) for own_name, counts in everything.items()}
    for i, own_name in enumerate(split.names):
        first, second = split.halves(i)
        assert first == halves[own_name] and tuple(np.add(first, second)) == everything[own_name]
    chosen = []
    for b, *pair in split.chosen:
        one, other = (split.comparison.blocks[b][i][0][0] for i in pair)
        chosen.append((split.names[one], split.names[other]))
    assert (chosen or [None]) == [split_oracle.choice(used, halves)]


def test_the_global_ratio_has_cells_without_context() -> None:
    own = law(ROWS[:2] + ROWS[3:])
    split = HalfSplit(global_comparison(own, fa.Utility({"yes": 1}).on(own)))
    assert split.seed == split_oracle.seed(
        {split_oracle.name((None, {"sex": a})): counts for a, counts in (("f", (51, 81)), ("m", (34, 80)))}
    )


def _sorted_by_outcome(log: list[tuple[str, str, str]]) -> list[tuple[str, str, str]]:
    return sorted(log, key=lambda row: row[2])


@pytest.mark.parametrize(
    "order",
    [
        _sorted_by_outcome,
        lambda log: _sorted_by_outcome(log)[::-1],
        lambda log: sorted(log, reverse=True),
        lambda log: sorted(log, key=lambda row: (row[1], row[2] == "yes", row[0])),
        lambda log: Random(3).sample(log, len(log)),
    ],
)
def test_the_order_of_rows_changes_nothing(order: Callable[[list[Any]], list[Any]]) -> None:
    log = [(x, a, u) for x, a, k, n in ROWS for u in ["yes"] * k + ["no"] * (n - k)]
    found = []
    for rows in (log, order(log)):
        table = dict(zip(("shop", "sex", "hired"), map(list, zip(*rows, strict=True)), strict=True))
        result = fa.audit(
            table, decision="hired", group="sex", context="shop", utility="yes", independent=True, select="half-split", max_local_ratio=2
        )
        interval = result.intervals["local"]
        lower, _ = result.drivers["local"]
        found.append((interval.lower, interval.upper, interval.evidence["split"], lower, result.verdict))
        assert outcome(json.loads(result.certificate.text)) == "true"
    assert found[0] == found[1] and found[0][0] > 1


def test_halves_are_drawn_without_regard_to_the_values() -> None:
    """Over tables that differ in a label alone, the successes of the first half have the hypergeometric law."""
    seen = np.zeros(5)
    for table in range(1500):
        counts = np.array([[4, 2]])
        own = compared(counts, 9)
        own = Comparison(own.cells, own.blocks, (({"shop": str(table)}, own.labels[0][1]),))
        seen[HalfSplit(own).halves(0)[0][0]] += 1
    expected = np.array([1500 * comb(4, i) * comb(5, 4 - i) / comb(9, 4) for i in range(5)])
    assert ((seen - expected) ** 2 / expected).sum() < 18.5  # one in a thousand


@pytest.mark.parametrize("low", [[0.4], [0.4, 0.4, 0.4], [0.5, 0.4, 0.4]])
def test_it_errs_no_more_than_it_says(low: list[float]) -> None:
    """At a ratio that just keeps the limit, `exceeds` is as rare as the error, and at an error of 40 % it is seen."""
    pick, wrong = np.random.default_rng(len(low) + int(10 * low[0])), 0
    means = np.full((3, 4), 0.5)
    means[: len(low), 0] = low
    for _ in range(TABLES):
        own = compared(pick.binomial(60, means), 60)
        lower, _, _ = pairs_interval(own, F(2, 5), "lower", "half-split")
        wrong += lower > F(5, 4)
    assert wrong <= 0.4 * TABLES + 3 * (0.24 * TABLES) ** 0.5
    assert wrong > 0.02 * TABLES


def found_by(own: Comparison, select: Any) -> bool:
    """Whether a lower end of more than 5/4 is proved at 95 %, which is less work than to find it."""
    if select == "half-split":
        split = HalfSplit(own)
        ((b, i, j),) = split.chosen
        ((n,), (m,)) = ([own.blocks[b][at][0][0]] for at in (i, j))
        (k, draws), (other, size) = split.halves(m)[1], split.halves(n)[1]
        return pair_excludes(Pair(k, draws, other, size, order_scale(F(1, 20))), F(4, 5), F(1, 20)) is not None
    level = F(1, 20) / own.pairs
    least = min((int(cell.successes), i) for i, cell in enumerate(own.cells))[1]
    block = own.blocks[least // len(own.blocks[0])]
    most = max((int(own.cells[form[0][0]].successes), form[0][0]) for form in block)[1]
    one, other_cell = own.cells[least], own.cells[most]
    pair = Pair(int(one.successes), one.draws, int(other_cell.successes), other_cell.draws, order_scale(level))
    return pair_excludes(pair, F(4, 5), level) is not None


def test_one_of_many_contexts_is_found() -> None:
    """Of 50 contexts with 8 groups of 200 draws each, one group has half of the chance of the others."""
    pick, found = np.random.default_rng(4), {"bonferroni": 0, "half-split": 0}
    means = np.full((50, 8), 0.5)
    means[7, 3] = 0.25
    tables = 300 if tiers.FULL else 40
    for _ in range(tables):
        own = compared(pick.binomial(200, means), 200)
        for select in found:
            found[select] += found_by(own, select)
    assert found["bonferroni"] >= 0.5 * tables - 1.7 * (0.25 * tables) ** 0.5
    assert found["half-split"] >= 0.7 * tables - 1.7 * (0.21 * tables) ** 0.5


def test_many_contexts_have_a_certificate() -> None:
    means = np.full((50, 8), 0.5)
    means[7, 3] = 0.25
    counts = np.random.default_rng(2).binomial(200, means)
    own = fa.Law.from_array(np.stack([counts, 200 - counts], axis=-1), kind="counts", decisions=["yes", "no"])
    result = certified(own, max_local_ratio="5/4")
    assert result.verdict == "exceeds" and result.comparisons["local"].pairs == 2800
    assert outcome(json.loads(result.certificate.text)) == "true"


def test_utilities_of_groups_scale_the_ratio() -> None:
    """A success that is worth three times as much in one group makes three times the ratio, and another choice."""
    plain = compared(np.array([[30, 30, 10]]), 40)
    worth = Comparison((plain.cells[0], Cell(40, F(90), None, F(0), F(3), True), plain.cells[2]), plain.blocks, plain.labels)
    assert HalfSplit(worth).seed == HalfSplit(plain).seed and HalfSplit(worth).chosen == [(0, 1, 2)]
    alone = Comparison((plain.cells[2], plain.cells[1]), (plain.blocks[0][:2],), ((plain.labels[0][0], plain.labels[0][1][:2]),))
    scaled = Comparison((alone.cells[0], worth.cells[1]), alone.blocks, alone.labels)
    lower, tripled = (pairs_interval(each, F(1, 20), "each", "half-split")[0] for each in (alone, scaled))
    assert tripled == 3 * lower > 3


def test_ends_are_nested_in_the_confidence() -> None:
    own = compared(np.array([[30, 15, 20], [22, 21, 20]]), 40)
    ends = [
        ratio_interval(own, level, region="pairs", independent=True, ends=how, select="half-split")  # type: ignore[arg-type]
        for level in ("0.8", "0.95", "0.99")
        for how in ("each", "together")
    ]
    lower = [found.lower for found in ends]
    assert lower[::2] == sorted(lower[::2], reverse=True) and all(one >= other for one, other in zip(lower[::2], lower[1::2], strict=True))


def test_no_lower_end_without_draws_in_both_halves() -> None:
    own = compared(np.array([[1, 0]]), 1)
    assert HalfSplit(own).chosen == []
    assert pairs_interval(own, F(1, 2), "each", "half-split")[0] == 1


def test_ends_that_cross_decide_nothing() -> None:
    """At a confidence of 50 % the half that tests is often above what all draws leave."""
    crossed = 0
    for extra in range(40):
        own = law([("x", "f", 60, 100), ("x", "m", 45, 100), (f"y{extra}", "f", 50, 100), (f"y{extra}", "m", 50, 100)])
        interval = certified(own, confidence="0.3", max_local_ratio=2).intervals["local"]
        if interval.lower <= interval.upper:
            continue
        crossed += 1
        limit = (interval.lower + F(interval.upper)) / 2
        result = certified(own, confidence="0.3", max_local_ratio=limit)
        assert result.verdict == "inconclusive" and "the ends cross" in verdict(result)
        assert outcome(json.loads(result.certificate.text)) == "true"
        break
    assert crossed


TWO = [("x", "f", 30, 40), ("x", "m", 20, 40)]


@pytest.mark.parametrize(
    "refused",
    [
        lambda: fa.certify(law(TWO), {"yes": 1}, select="half-split"),  # dependent
        lambda: certified(law([("x", "f", 30, 40), ("x", "m", 5 * 10**5, 10**6)])),  # too many draws
        lambda: fa.certify(law(TWO), {"yes": 1, "no": "1/2"}, independent=True, select="half-split"),  # nobody gets nothing
        lambda: certified(law(TWO), declared={"gamma": 2}),  # only the range is known
        lambda: certified(law([("x", "f", 0, 0), *TWO])) and certified(law(TWO), confidence="0.0001"),
    ],
)
def test_it_is_refused_where_it_does_not_apply(refused: Callable[[], Any]) -> None:
    with pytest.raises(InputError, match="the half-split needs cells that were declared independent, draws that are 0 or one positive"):
        refused()


def test_it_is_for_samples() -> None:
    with pytest.raises(InputError, match="select 'half-split' is for the population behind a table or log of counts"):
        certified(law(TWO), confidence=None)
    shares = fa.Law.from_array([[0.5, 0.5], [0.25, 0.75]], decisions=["yes", "no"])
    with pytest.raises(InputError, match="select 'half-split' is for the population behind a table or log of counts"):
        certified(shares)
    with pytest.raises(InputError, match="the selection 'thirds' is not known"):
        fa.certify(law(TWO), {"yes": 1}, independent=True, select="thirds")  # type: ignore[arg-type]
    with pytest.raises(InputError, match="in_parts does not go with select"):
        fa.audit("no.csv", decision="u", group="a", context="x", utility="yes", in_parts=True, select="half-split")


def test_the_command_and_the_audit_file_take_it(tmp_path: Any, capsys: pytest.CaptureFixture[str]) -> None:
    (tmp_path / "log.csv").write_text(
        "shop,sex,hired,n\n" + "".join(f"{x},{a},yes,{k}\n{x},{a},no,{n - k}\n" for x, a, k, n in ROWS), "utf-8"
    )
    columns = ["--decision", "hired", "--group", "sex", "--context", "shop", "--count", "n", "--utility", "yes", "--max-local-ratio", "2"]
    main(["certify", str(tmp_path / "log.csv"), *columns, "--independent-cells", "--select", "half-split", "--two-sided"])
    by_option = capsys.readouterr().out
    assert "each at 95 % (pair-exact, half-split)" in by_option and "at confidence 95 % (pair-exact, half-split)" in by_option
    assert "the hash SHA-256, by which draws are split" in by_option
    (tmp_path / "AUDIT.toml").write_text(
        '[law]\ntable = "log.csv"\ndecision = "hired"\ngroup = "sex"\ncontext = "shop"\ncount = "n"\n[utility]\nvalues = { yes = 1 }\n'
        '[targets]\nmax_local_ratio = 2\n[confidence]\nindependent_cells = true\nselect = "half-split"\n',
        "utf-8",
    )
    main(["certify", str(tmp_path / "AUDIT.toml"), "--two-sided"])
    assert capsys.readouterr().out.splitlines()[0] == by_option.splitlines()[0]
    assert fa.audit(tmp_path / "AUDIT.toml").intervals["local"].evidence["split"]
    (tmp_path / "AUDIT.toml").write_text((tmp_path / "AUDIT.toml").read_text("utf-8").replace("half-split", "half"), "utf-8")
    with pytest.raises(InputError, match=r"\[confidence\] select is 'half'"):
        fa.audit(tmp_path / "AUDIT.toml")


FAR = [("x", "f", 90, 120), ("x", "m", 25, 120), ("x", "o", 40, 90), ("y", "f", 61, 120), ("y", "m", 62, 120)]
HONEST: dict[str | None, str] = {}


def honest(target: str | None) -> Any:
    if target not in HONEST:
        result = certified(law(FAR), **({} if target is None else {"max_local_ratio": target}))
        assert result.intervals["local"].lower > 1
        HONEST[target] = result.certificate.text
    return json.loads(HONEST[target])


def _without_split(interval: Any, document: Any) -> None:
    del interval["split"]
    for claim in document["claims"]:
        claim["assumptions"] = [text for text in claim["assumptions"] if "SHA-256" not in text]


def _more(interval: Any, random: Random) -> None:
    """A lower end that no knots prove: those that prove a step of the search are not many."""
    lower = F(interval["ratio"][0]) * F(random.randint(1_005, 2_000), 1_000)
    interval["ratio"][0] = str(lower)


def _other_pair(interval: Any, random: Random) -> None:
    places = [[b, i, j] for b, size in ((0, 3), (1, 2)) for i in range(size) for j in range(size) if i != j]
    interval["lower"]["pair"] = random.choice([place for place in places if place != interval["lower"]["pair"]])


def _other_seed(interval: Any, random: Random) -> None:
    seed, at = interval["split"]["seed"], random.randrange(64)
    interval["split"]["seed"] = seed[:at] + random.choice([digit for digit in "0123456789abcdef" if digit != seed[at]]) + seed[at + 1 :]


def _other_level(interval: Any, random: Random) -> None:
    name, factor = random.choice(["upper", "lower"]), F(random.choice([n for n in range(1, 40) if n != 20]), 20)
    interval["levels"][name] = str(F(interval["levels"][name]) * factor)


def _fewer_knots(interval: Any, random: Random) -> None:
    knots = interval["lower"]["knots"]
    del knots[random.randrange(len(knots))]


def _other_order(interval: Any, random: Random) -> None:
    knots = interval["lower"]["knots"]
    i, j = random.sample(range(len(knots)), 2)
    knots[i], knots[j] = knots[j], knots[i]


def _of_all_draws(interval: Any, _: Random) -> None:
    """The pair and the knots of the lower end that all draws would prove."""
    own = law(FAR)
    lower, _, evidence = pairs_interval(local_comparison(own, fa.Utility({"yes": 1}).on(own)), F(1, 20) * 8, "each")
    interval["ratio"][0], interval["lower"] = str(lower), evidence["lower"]


FORGERIES: list[Callable[[Any, Random], None]] = [_more, _other_pair, _other_seed, _other_level, _fewer_knots, _other_order, _of_all_draws]


def test_no_altered_evidence_is_accepted() -> None:
    random = Random(9)
    for target in (None, "3/2"):
        assert outcome(honest(target)) == "true"
    for number in range(ALTERED):
        document = honest(random.choice([None, "3/2"]))
        before = copy.deepcopy(document["intervals"]["local"])
        FORGERIES[number % len(FORGERIES)](document["intervals"]["local"], random)
        assert document["intervals"]["local"] != before
        assert outcome(document) != "true", (number, document["intervals"]["local"])


def test_what_the_split_rests_on_is_listed() -> None:
    document = honest(None)
    _without_split(document["intervals"]["local"], document)
    assert outcome(document) != "true"
    document = honest(None)
    for claim in document["claims"]:
        claim["assumptions"] = [text for text in claim["assumptions"] if "SHA-256" not in text]
    assert outcome(document).startswith("incomplete")
    document = honest(None)
    document["intervals"]["local"]["split"]["seed"] = "0" * 63
    assert outcome(document).startswith("malformed")
    document = honest(None)
    document["intervals"]["local"]["split"]["rule"] = "any"
    assert outcome(document).startswith("malformed")
