"""Logs of sampling units that are independent of each other, of many shapes; no unit is a copy of another."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

__all__ = ["SHAPES", "Rows", "items", "persons", "runs", "winners"]

Rows = list[tuple[int, int, int, int]]  # unit, context, group, answer
Pick = np.random.Generator


def _answer(pick: Pick, leaning: np.ndarray) -> int:
    weights = np.exp(leaning - leaning.max())
    return int(pick.choice(len(weights), p=weights / weights.sum()))


def persons(pick: Pick, count: int = 60, contexts: int = 6, times: int = 1, answers: int = 2, tendency: float = 0.0) -> Rows:
    """Each of one group, and in most contexts; some tend to one answer."""
    base = pick.normal(0, 1, (contexts, 2, answers))
    rows: Rows = []
    for unit in range(count):
        group, own = unit if unit < 2 else int(pick.integers(2)), tendency * pick.normal(0, 1, answers)
        for context in range(contexts):
            if context and pick.random() < 0.15:
                continue
            rows += [(unit, context, group, _answer(pick, base[context, group] + own)) for _ in range(times)]
    return rows


def runs(
    pick: Pick,
    count: int = 20,
    contexts: int = 5,
    groups: int = 4,
    answers: int = 2,
    times: int = 1,
    tendency: float = 0.0,
    extreme: float = 1.0,
) -> Rows:
    """Each with all groups in all contexts; some are in a mood that changes with the context."""
    base = extreme * pick.normal(0, 1, (contexts, groups, answers))
    rows: Rows = []
    for unit in range(count):
        for context in range(contexts):
            own = tendency * pick.normal(0, 1, answers)
            rows += [(unit, context, a, _answer(pick, base[context, a] + own)) for a in range(groups) for _ in range(times)]
    return rows


def winners(pick: Pick, count: int = 200, contexts: int = 1, groups: int = 8) -> Rows:
    """One winner among the groups for each run and context."""
    chances = pick.dirichlet(np.ones(groups), contexts)
    rows: Rows = []
    for unit in range(count):
        for context in range(contexts):
            first = int(pick.choice(groups, p=chances[context]))
            rows += [(unit, context, a, int(a == first)) for a in range(groups)]
    return rows


def items(pick: Pick, count: int = 30, contexts: int = 2, groups: int = 3, within: int = 8) -> Rows:
    """Each run answers the same items of each context and group, which no column names, and hardly varies in any of them."""
    leaning = 4.0 * pick.normal(0, 1, (contexts, groups, within, 2))
    places = [(x, a, i) for x in range(contexts) for a in range(groups) for i in range(within)]
    return [(unit, x, a, _answer(pick, leaning[x, a, i])) for unit in range(count) for x, a, i in places]


SHAPES: dict[str, Callable[[Pick], Rows]] = {
    "persons who answer once": persons,
    "persons who answer thrice": lambda pick: persons(pick, 300, 2, 3),
    "persons who tend to an answer": lambda pick: persons(pick, 80, 5, 2, 3, 2.0),
    "persons with many answers": lambda pick: persons(pick, 40, 8, 1, 5),
    "few persons": lambda pick: persons(pick, 6, 3, 2),
    "runs": runs,
    "runs with moods": lambda pick: runs(pick, 30, 3, 6, 3, tendency=1.5),
    "runs that hardly vary": lambda pick: runs(pick, 12, 6, extreme=6.0),
    "runs that answer the same items": items,
    "one winner": winners,
    "one winner for each job": lambda pick: winners(pick, 60, 4, 5),
}
