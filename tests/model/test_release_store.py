"""Sticky releases: one draw for each filter, attribute and subject, however many threads and processes ask at once."""

from __future__ import annotations

import multiprocessing
import shelve
import sqlite3
import subprocess
import sys
import time
from collections import UserDict
from collections.abc import Iterator, MutableMapping
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from threading import Barrier
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from fairaudit.errors import InputError
from fairaudit.model.mechanism import Identity, Mechanism, Product, RandomizedResponse
from fairaudit.model.release_store import ReleaseStore

RACES = 60
WIDE = RandomizedResponse(range(1000), keep_probability="0.001")


class Slow(MutableMapping[Any, Any]):
    """A mapping over a slow line, as Python's mixin makes it: `setdefault` looks first and writes later."""

    def __init__(self) -> None:
        self.kept: dict[Any, Any] = {}

    def __getitem__(self, key: Any) -> Any:
        time.sleep(0.01)
        return self.kept[key]

    def __setitem__(self, key: Any, value: Any) -> None:
        time.sleep(0.01)
        self.kept[key] = value

    def __delitem__(self, key: Any) -> None:
        del self.kept[key]

    def __iter__(self) -> Iterator[Any]:
        return iter(self.kept)

    def __len__(self) -> int:
        return len(self.kept)


def race(store: Any, subject: str) -> set[Any]:
    """What two threads are shown that ask for one subject at once."""
    barrier = Barrier(2)

    def ask(value: int) -> Any:
        barrier.wait()
        return WIDE.release(value, subject=subject, attribute="place", store=store)

    with ThreadPoolExecutor(2) as pool:
        return set(pool.map(ask, (1, 2)))


def test_a_mapping_on_which_draws_could_race_is_refused(tmp_path: Path) -> None:
    with shelve.open(str(tmp_path / "shelf")) as shelf:  # noqa: S301
        for store in (Slow(), UserDict(), shelf, object()):
            with pytest.raises(InputError, match="has no atomic operation"):
                WIDE.release(1, subject="Ada", attribute="place", store=store)  # type: ignore[arg-type]


@pytest.mark.parametrize("kind", ["dict", "file", "manager"])
def test_two_threads_that_race_are_shown_one_draw(kind: str, tmp_path: Path) -> None:
    manager = multiprocessing.get_context("spawn").Manager() if kind == "manager" else None
    store: Any = manager.dict() if manager else {} if kind == "dict" else ReleaseStore(tmp_path / "releases.db")
    assert [len(race(store, f"person {n}")) for n in range(RACES)] == [1] * RACES
    if manager:
        manager.shutdown()


def test_processes_that_race_are_shown_one_draw_each(tmp_path: Path) -> None:
    """Six processes open a file that does not exist yet, and release for the same 60 subjects, in both orders."""
    code = (
        "import sys; from fairaudit import RandomizedResponse as R, ReleaseStore as S\n"
        "f = R(range(1000), keep_probability='0.001'); n = int(sys.argv[2]); s = S(sys.argv[1])\n"
        "found = {k: f.release(n, subject=k, attribute='place', store=s) for k in list(range(60))[:: 1 if n % 2 else -1]}\n"
        "print(sorted(found.items()))"
    )
    path = str(tmp_path / "releases.db")
    asked = [subprocess.Popen([sys.executable, "-c", code, path, str(n)], stdout=subprocess.PIPE, text=True) for n in range(6)]
    said = [process.communicate(timeout=120)[0] for process in asked]
    assert [process.returncode for process in asked] == [0] * 6
    assert len(set(said)) == 1 and said[0].count("(") == RACES


def test_attributes_and_filters_that_share_a_store_do_not_copy_each_other(tmp_path: Path) -> None:
    """Two attributes with the same answers: the second once returned the draw of the first."""
    coin, other = Identity(["yes", "no"]), RandomizedResponse(["yes", "no"], keep_probability=0)
    for store in ({}, ReleaseStore(tmp_path / "releases.db")):
        assert coin.release("yes", subject="Ada", attribute="member", store=store) == "yes"
        assert coin.release("no", subject="Ada", attribute="married", store=store) == "no"
        assert other.release("yes", subject="Ada", attribute="member", store=store) == "no"
        assert coin.release("no", subject="Ada", attribute="member", store=store) == "yes"
        assert coin.release("no", subject="Bob", attribute="member", store=store) == "no"


def test_a_store_outlives_its_process_and_keeps_tuples(tmp_path: Path) -> None:
    both = Product({"sex": Identity(["f", "m"]), "age": RandomizedResponse(range(1000), keep_probability="0.5")})
    shown = both.release(("f", 3), subject=17, store=ReleaseStore(tmp_path / "r.db"))
    assert both.release(("m", 5), subject="17", store=ReleaseStore(str(tmp_path / "r.db"))) == shown
    assert isinstance(shown, tuple) and shown[0] == "f"
    assert both.release_key(17)[1:] == ('["sex", "age"]', "17")


def test_releases_of_earlier_versions_are_refused_and_can_be_moved() -> None:
    coin = RandomizedResponse("ab", keep_probability="0.7")
    for old, subject in (("Ada", "Ada"), (17, 17), (17, "17"), ("17", 17)):
        store: dict[Any, Any] = {old: "b"}
        with pytest.raises(InputError, match="as earlier versions kept it"):
            coin.release("a", subject=subject, attribute="letter", store=store)
        store[coin.release_key(subject, "letter")] = store.pop(old)
        assert coin.release("a", subject=subject, attribute="letter", store=store) == "b"


def test_a_file_that_is_something_else_is_refused(tmp_path: Path) -> None:
    (tmp_path / "text").write_text("no database at all, but long enough to be read as one")
    with sqlite3.connect(tmp_path / "other.db") as db:
        db.execute("CREATE TABLE releases (a)")
    db.close()
    for path in (tmp_path / "text", tmp_path / "other.db", tmp_path, tmp_path / "absent" / "r.db", ""):
        with pytest.raises(InputError, match="store of releases"):
            ReleaseStore(path)


ROW = st.lists(st.integers(0, 5), min_size=3, max_size=3).filter(any)


@given(st.lists(ROW, min_size=3, max_size=3), st.permutations([0, 1, 2]))
def test_the_digest_is_that_of_the_probabilities(rows: list[list[int]], order: list[int]) -> None:
    """It does not follow the order of labels; it tells any two tables apart."""

    def made(rows: list[list[int]], labels: str) -> Mechanism:
        return Mechanism.from_array([[f"{w}/{sum(row)}" for w in row] for row in rows], labels)

    first = made(rows, "abc")
    moved = made([[rows[i][j] for j in order] for i in order], "".join("abc"[i] for i in order))
    assert first.digest == moved.digest
    turned = made(rows[1:] + rows[:1], "abc")
    same = all(first.probability(a, b) == turned.probability(a, b) for a in "abc" for b in "abc")
    assert (first.digest == turned.digest) == same
