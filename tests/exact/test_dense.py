"""Dense laws from float arrays: the quick passes must find what brute force over fractions finds, witness included."""

from fractions import Fraction
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from fairaudit import InputError, Law, Utility
from fairaudit.exact import dense
from fairaudit.measures.distances import demographic_parity, equalized_odds
from fairaudit.measures.ratios import global_fairness, local_fairness, local_supremum

F = Fraction


@st.composite
def arrays(draw: st.DrawFn) -> Any:
    """Rows of probabilities that are nearly equal, far apart, zero in places or tiny in places, in either precision."""
    kind = draw(st.sampled_from([np.float64, np.float32]))
    shape = draw(st.tuples(st.integers(1, 3), st.integers(2, 4), st.integers(2, 5)))
    generator = np.random.default_rng(draw(st.integers(0, 2**32)))
    style = draw(st.sampled_from(["any", "near", "same", "tiny", "zero"]))
    table = generator.random(shape)
    if style in ("near", "same"):
        table = np.broadcast_to(table[:1, :1], shape).copy()
    table /= table.sum(axis=2, keepdims=True)
    table = table.astype(kind)
    if style == "near":
        table[..., 0] = np.where(generator.random(shape[:2]) < 0.5, table[..., 0], np.nextafter(table[..., 0], kind(1)))
    if style == "tiny":
        table[..., 0] = generator.integers(0, 4, shape[:2]) * np.finfo(kind).smallest_subnormal
        table[..., 1:] = kind(1) / kind(shape[2] - 1)
    if style == "zero":
        table[..., :-1] *= generator.random((*shape[:2], shape[2] - 1)) < 0.5
        table[..., -1] = (1 - table[..., :-1].astype(np.float64).sum(axis=2)).astype(kind)
    return table


def brute(values: list[tuple[Any, int, Fraction]]) -> tuple[Any, Any]:
    """The worst ratio among members of one block, and its first pair."""
    best: Any = (F(1), None)
    for block in sorted({b for b, _, _ in values}):
        members = [(i, v) for b, i, v in values if b == block]
        for i, v in members:
            for j, w in members:
                ratio: Any = float("inf") if w == 0 < v else F(1) if w == 0 else v / w
                if ratio > best[0]:
                    best = (ratio, (block, i, j))
    return best


@settings(max_examples=150, deadline=None)
@given(arrays(), st.lists(st.integers(0, 3), min_size=5, max_size=5), st.booleans())
def test_local_and_global_ratios_are_those_of_brute_force(table: Any, g: list[int], first_only: bool) -> None:
    law = Law.from_array(table)
    n = table.shape[2]
    values = [1] + [0] * (n - 1) if first_only else g[:n]
    utility = Utility({u: v for u, v in zip(law.decisions, values, strict=True) if v} or {"0": 0}).on(law)
    rows = [[[F(float(v)) for v in row] for row in block] for block in table]
    means = [[sum((v * w for v, w in zip(values, row, strict=True)), F(0)) / sum(row) for row in block] for block in rows]
    found = local_fairness(law, utility)
    assert found is not None
    ratio, place = brute([(x, a, e) for x, block in enumerate(means) for a, e in enumerate(block)])
    assert found.ratio == ratio
    if place is not None:
        x, i, j = place
        context = {} if table.shape[0] == 1 and not law.columns.context else {"context": str(x)}
        assert (found.witness.context, found.witness.higher, found.witness.lower) == (context, {"group": str(i)}, {"group": str(j)})
    over = global_fairness(law, utility)
    averages = [sum((block[a] for block in means), F(0)) / len(means) for a in range(table.shape[1])]
    ratio, place = brute([(0, a, e) for a, e in enumerate(averages)])
    assert over is not None and over.ratio == ratio
    assert over.witness.expectations[0] in averages
    if place is not None:
        assert (over.witness.higher, over.witness.lower) == ({"group": str(place[1])}, {"group": str(place[2])})


@settings(max_examples=60, deadline=None)
@given(arrays())
def test_distances_and_suprema_of_either_precision(table: Any) -> None:
    law = Law.from_array(table)
    rows = [[[F(float(v)) / sum(F(float(w)) for w in row) for v in row] for row in block] for block in table]
    gaps = [sum((max(F(0), v - w) for v, w in zip(p, q, strict=True)), F(0)) for block in rows for p in block for q in block]
    found = equalized_odds(law)
    assert found is not None and found.value == max(gaps)
    ratio = brute([((x, k), a, row[k]) for x, block in enumerate(rows) for a, row in enumerate(block) for k in range(len(row))])[0]
    top = local_supremum(law)
    assert top is not None and top.ratio == ratio
    averages = [[sum(column, F(0)) / len(rows) for column in zip(*(b[a] for b in rows), strict=True)] for a in range(len(rows[0]))]
    parity = demographic_parity(law)
    assert parity is not None
    assert parity.value == max(sum((max(F(0), v - w) for v, w in zip(p, q, strict=True)), F(0)) for p in averages for q in averages)


@pytest.mark.parametrize("kind", [np.float64, np.float32])
def test_many_small_blocks_on_all_cores(kind: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(dense, "BLOCK_BYTES", 500)
    generator = np.random.default_rng(3)
    table = generator.dirichlet(np.ones(7), (40, 6)).astype(kind)
    table[11, 2] = np.roll(table[11, 2], 1)
    law = Law.from_array(table)
    utility = Utility({str(i): i for i in range(7)}).on(law)
    exact = [[sum(i * F(float(v)) for i, v in enumerate(row)) / sum(F(float(v)) for v in row) for row in block] for block in table]
    found = local_fairness(law, utility)
    assert found is not None and found.ratio == max(max(block) / min(block) for block in exact)
    equal = Law.from_array(np.broadcast_to(table[:1, :1], table.shape).copy())
    same = local_fairness(equal, Utility({str(i): i for i in range(7)}).on(equal))
    assert same is not None and same.ratio == 1


@pytest.mark.parametrize("kind", [np.float64, np.float32])
def test_memory_mapped_files_are_not_copied(kind: Any, tmp_path: Path) -> None:
    table = np.random.default_rng(0).dirichlet(np.ones(5), (20, 4)).astype(kind)
    table.tofile(tmp_path / "law.bin")
    mapped = np.memmap(tmp_path / "law.bin", dtype=kind, mode="r", shape=table.shape)
    law = Law.from_array(mapped)
    assert np.shares_memory(law.weights, mapped) and law.weights.dtype == kind
    utility = Utility({"0": 1})
    there, here = local_fairness(law, utility.on(law)), local_fairness(Law.from_array(table), utility.on(law))
    assert there is not None and here is not None and there.ratio == here.ratio


@pytest.mark.parametrize("kind", [np.float64, np.float32])
@pytest.mark.parametrize("bad", [np.nan, np.inf, -0.25])
def test_entries_that_are_no_probabilities_are_refused(kind: Any, bad: float) -> None:
    table = np.full((2, 3, 4), 0.25, dtype=kind)
    table[1, 2, 3] = bad
    with pytest.raises(InputError, match=r"not a finite number|negative"):
        Law.from_array(table)


def test_float32_counts_are_whole_numbers() -> None:
    law = Law.from_array(np.array([[3, 1], [1, 1]], dtype=np.float32), kind="counts")
    assert law.weights.dtype == np.int64 and law.whole
