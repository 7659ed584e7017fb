"""Whether a new table is still within the radius of a verdict on an old one."""

from __future__ import annotations

from typing import Any

import pytest

import fairaudit as fa


def made(hired: int, **options: Any) -> fa.Result:
    table = {"hired": ["yes", "no", "yes", "no"], "sex": ["f", "f", "m", "m"], "n": [hired, 100 - hired, 40, 60]}
    return fa.audit(table, decision="hired", group="sex", count="n", utility="yes", confidence=None, **options)


@pytest.mark.parametrize(
    ("hired", "said"),
    [
        (52, "no cell moved by more than 2 %, within the 10 % for which the old verdict within (local ratio at most 2 "),
        (60, "no cell moved by more than 10 %, within the 10 % for which the old verdict within (local ratio at most 2 "),
        (61, "cell sex=f moved by 11 %, beyond the 10 % for which the old verdict within (local ratio at most 2 "),
    ],
)
def test_a_table_is_within_the_radius_of_the_old_verdict_or_beyond(hired: int, said: str) -> None:
    found = fa.compare(made(50, max_local_ratio=2), made(hired, max_local_ratio=2))
    assert any(note.startswith(said) for note in found.notes), found.notes


def test_an_exceeded_limit_stands_below_its_radius() -> None:
    old = made(50, max_local_ratio="8/7")
    assert old.drift_radii[0] is not None and str(old.drift_radii[0].radius) == "1/50"
    assert any("moved by 2 %, beyond the 2 %" in note for note in fa.compare(old, made(52)).notes)


def test_nothing_is_said_where_no_verdict_has_a_radius() -> None:
    assert not any("moved" in note for note in fa.compare(made(50), made(52)).notes)


def test_means_are_compared_only_where_contexts_stay_as_they_were() -> None:
    def table(n: int) -> fa.Result:
        rows = {"d": ["y", "n"] * 4, "sex": ["f", "f", "m", "m"] * 2, "x": ["p"] * 4 + ["q"] * 4, "n": [5 * n, 5 * n, 4, 6, 5, 5, 4, 6]}
        return fa.audit(rows, decision="d", group="sex", context="x", count="n", utility="y", confidence=None, max_global_ratio=2)

    assert any("stay distributed as they were, and they did not" in note for note in fa.compare(table(1), table(2)).notes)
    assert any("no cell moved by more than 0 %" in note for note in fa.compare(table(1), table(1)).notes)
