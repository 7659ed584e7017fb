"""No small count can be computed from what is published: an integer solver attacks it, told nothing but the published counts."""

from __future__ import annotations

import random
from collections.abc import Collection, Iterator
from itertools import product

import numpy as np
import pytest
import tiers
from attacker import agreeing

from fairaudit.publications.circulation import Arc, is_small, published

TABLES = 3_000 if tiers.FULL else 60

SHAPES = ((2, 2), (2, 3), (3, 3), (2, 7), (3, 8), (4, 4))


def two_ways(rng: random.Random, rows: int, columns: int, scale: int) -> dict[str, Arc]:
    """A table of random counts with its margins, some cells small and some empty."""
    cells = {}
    for r, c in product(range(rows), range(columns)):
        most = rng.choice((0, 3, scale, scale, 10 * scale if scale > 3 else scale))
        cells[f"cell {r} {c}"] = Arc(("row", r), ("column", c), (rng.randint(0, most), rng.randint(0, most)))
    return cells | margins(cells)


def margins(cells: dict[str, Arc]) -> dict[str, Arc]:
    made = {}
    for node in dict.fromkeys(end for arc in cells.values() for end in (arc.tail, arc.head)):
        summed = [arc.parts for arc in cells.values() if node in (arc.tail, arc.head)]
        parts = tuple(map(sum, zip(*summed, strict=True)))
        made[f"{node[0]} {node[1]}"] = Arc("all", node, parts) if node[0] == "row" else Arc(node, "all", parts)
    return made


def order_of(arcs: dict[str, Arc]) -> list[str]:
    return sorted(arcs, key=lambda name: (name.startswith("cell"), -min(arcs[name].parts)))


def possible(arcs: dict[str, Arc], known: Collection[str], name: str, kind: int, value: int) -> bool:
    """Whether a count can be so much for whoever knows the published ones."""
    cells = [of for of in arcs if of.startswith("cell")]

    def inside(of: str) -> list[str]:
        ends = {arcs[of].tail, arcs[of].head} - {"all"}
        return [cell for cell in cells if ends <= {arcs[cell].tail, arcs[cell].head}]

    return agreeing(cells, [*((inside(of), arcs[of].parts[kind]) for of in known), (inside(name), value)]) is not None


def told(arcs: dict[str, Arc], known: Collection[str], least: int) -> Iterator[tuple[str, int]]:
    """The counts that are withheld, of whose small values what is known rules out some: no small one is among them, says the promise.

    The values that a count can have are an interval.
    """
    for name, kind in product([name for name in arcs if name not in known], (0, 1)):
        if possible(arcs, known, name, kind, least - 1):
            if not possible(arcs, known, name, kind, 0):
                yield name, kind
        elif arcs[name].parts[kind] < least:
            yield name, kind


def test_every_small_count_can_be_anything_below_the_least_one_on_random_tables() -> None:
    rng = random.Random(tiers.fresh(0))
    small = hidden = 0
    for i in range(TABLES):
        least = rng.choice((2, 3, 5, 10))
        arcs = two_ways(rng, *SHAPES[i % len(SHAPES)], scale=rng.choice((5, 15, 60)))
        chosen = published(arcs, order_of(arcs), least)
        assert not any(is_small(arcs[name].parts, least) for name in chosen)
        hidden += len(arcs) - len(chosen)
        for kind in (0, 1):
            found = [name for name, arc in arcs.items() if arc.parts[kind] < least]
            for name in found if tiers.FULL else rng.sample(found, min(2, len(found))):
                small += 1
                for value in {0, least - 1, rng.randrange(least)}:
                    assert possible(arcs, chosen, name, kind, value)
    assert tiers.enough(small > 2 * TABLES and hidden < 0.9 * sum(2 * r * c for r, c in SHAPES) * TABLES / len(SHAPES))


def test_who_was_promised_that_small_counts_are_open_learns_no_more() -> None:
    """Else a count that must be 4 or more were known not to be small, and so to be 10 or more, and others to be the less."""
    rng = random.Random(tiers.fresh(6))
    hidden = 0
    for i in range(TABLES // 2):
        least = rng.choice((2, 5, 10))
        arcs = two_ways(rng, *SHAPES[i % 3], scale=rng.choice((15, 60)))
        chosen = published(arcs, order_of(arcs), least)
        hidden += len(arcs) - len(chosen)
        assert not any(told(arcs, chosen, least))
    assert tiers.enough(hidden > TABLES)


def test_a_cell_that_its_margins_and_the_promise_would_tell_is_open() -> None:
    """Margins leave 2 to 14 and 6 to 18 of the men: were these known not to be small, at most 4 and at least 4 women were left of 14."""
    cells = {("f", "a"): (4, 30), ("f", "b"): (8, 30), ("m", "a"): (10, 30), ("m", "b"): (10, 30)}
    arcs = {f"cell {s} {r}": Arc(("row", s), ("column", r), parts) for (s, r), parts in cells.items()}
    arcs |= margins(arcs)
    sums = [name for name in arcs if not name.startswith("cell")]
    assert [*told(arcs, sums, 10)] == [("cell m a", 0), ("cell m b", 0)]
    assert [value for value in range(20) if possible(arcs, [*sums], "cell m a", 0, value)] == [*range(2, 15)]
    assert not any(told(arcs, published(arcs, order_of(arcs), 10), 10))


def test_the_attack_succeeds_where_only_what_is_small_itself_is_withheld() -> None:
    """Otherwise the attack above would show nothing."""
    rng = random.Random(tiers.fresh(1))
    broken = 0
    for i in range(60):
        arcs = two_ways(rng, *SHAPES[i % len(SHAPES)], scale=15)
        known = [name for name, arc in arcs.items() if not is_small(arc.parts, 5)]
        for kind in (0, 1):
            broken += not all(possible(arcs, known, name, kind, 4) for name, arc in arcs.items() if arc.parts[kind] < 5)
    assert tiers.enough(broken > 20)


def test_nothing_is_withheld_without_need() -> None:
    """Of a group that is not small itself, after those before it: one more would tell a small count."""
    rng = random.Random(tiers.fresh(2))
    needed = 0
    for i in range(18):
        least = rng.choice((2, 5))
        arcs = two_ways(rng, *SHAPES[i % len(SHAPES)], scale=15)
        order = order_of(arcs)
        chosen = published(arcs, order, least)
        for place, name in enumerate(order):
            if name not in chosen and not is_small(arcs[name].parts, least):
                needed += 1
                assert any(told(arcs, [*chosen.intersection(order[:place]), name], least))
    assert tiers.enough(needed > 12)


def test_every_value_between_the_ends_occurs_by_enumeration() -> None:
    """All tables of two rows and three columns of counts up to 9 that agree with what is published, no margin of which is above 9."""
    rng = random.Random(tiers.fresh(3))
    every = np.indices((10,) * 6).reshape(6, -1)
    of = {"row 0": [0, 1, 2], "row 1": [3, 4, 5], "column 0": [0, 3], "column 1": [1, 4], "column 2": [2, 5]}
    withheld = 0
    for _ in range(12):
        least = 3
        arcs = two_ways(rng, 2, 3, scale=3)
        chosen = published(arcs, order_of(arcs), least)
        counts = {name: every[i] for i, name in enumerate(name for name in arcs if name.startswith("cell"))}
        counts |= {name: every[places].sum(axis=0) for name, places in of.items()}
        agree = np.all([counts[name] == arcs[name].parts[0] for name in chosen] + [every[0] >= 0], axis=0)
        for name, arc in arcs.items():
            if arc.parts[0] < least:
                withheld += 1
                assert {*range(least)} <= {*counts[name][agree].tolist()}
    assert tiers.enough(withheld > 50)


def test_the_worked_example_of_the_rule_loses_four_cells_of_its_intersections() -> None:
    """6 RCNY 5-301: seven selected Native American women are hidden by one more cell of their row and two of another column."""
    men = {"Hispanic": (205, 90), "White": (412, 215), "Black": (226, 95), "Pacific": (87, 37), "Asian": (321, 167), "Native": (24, 11)}
    women = {"Hispanic": (190, 82), "White": (385, 197), "Black": (164, 75), "Pacific": (32, 15), "Asian": (295, 135), "Native": (17, 7)}
    cells = {
        f"cell {sex} {race}": Arc(("row", sex), ("column", race), (s, n - s))
        for sex, of in (("m", men), ("f", women))
        for race, (n, s) in of.items()
    }
    arcs = cells | margins(cells)
    chosen = published(arcs, order_of(arcs), 10)
    assert {*arcs} - chosen == {"cell f Native", "cell m Native", "cell f Hispanic", "cell m Hispanic"}


def test_nothing_is_withheld_where_nothing_is_small() -> None:
    arcs = {
        name: Arc(arc.tail, arc.head, (20, 20))
        for name, arc in two_ways(random.Random(tiers.fresh(4)), 2, 2, 5).items()
        if name.startswith("cell")
    }
    arcs |= margins(arcs)
    assert published(arcs, order_of(arcs), 10) == {*arcs}


def test_margins_that_are_absent_are_refused() -> None:
    with pytest.raises(ValueError, match="does not flow out"):
        published({"a": Arc("f", "g", (3, 4))}, ["a"], 10)
