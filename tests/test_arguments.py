"""Arguments: which values are of a type, and what is said of those that are not."""

from __future__ import annotations

import ast
import importlib
import inspect
import pkgutil
from collections.abc import Callable, Iterable, Mapping, Sequence
from fractions import Fraction
from os import PathLike
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal, get_args

import numpy as np
import pytest

import fairaudit
from fairaudit.arguments import accepted, answered, answered_class, fits, hints
from fairaudit.errors import InputError, kind_of
from fairaudit.exact.rationals import Number
from fairaudit.tables.sources import Source, Table
from fairaudit.tables.values import LabelLike

if TYPE_CHECKING:
    from fairaudit.model.policy import Deployment


@pytest.mark.parametrize(
    ("hint", "good", "bad"),
    [
        (int, [1, -1, np.int64(3)], [True, 1.0, "1", None]),
        (float, [1, 0.5, Fraction(1, 2), np.float32(1)], [True, "0.5", None]),
        (bool, [True, np.False_], [0, "no", None]),
        (str, ["", "x", np.str_("x")], [b"x", 1, None]),
        (Number, [1, "5/4", Fraction(1, 2), 0.5, np.float64(2), np.int8(2)], [None, [1], {}, 1j]),
        (LabelLike, ["f", 1, True, None], [["f"], {"f": 1}]),
        (
            str | Sequence[str] | None,
            ["sex", ["sex"], ("a", "b"), np.array(["sex"]), {"sex": 1}.keys(), None],
            [3, ["a", 3], [["a"]], b"sex"],
        ),
        (Mapping[str, int], [{}, {"a": 1}], [[], {"a": "1"}, None]),
        (Iterable[int], [[1], (1,), iter([1]), {1}], [1, None, [[1]]]),
        (Callable[[int], int], [len, lambda x: x], [1, "len"]),
        (str | PathLike[str], ["x", Path("x")], [1, None, b"x"]),
        (Literal["a", "b"], ["a", "c"], [1, None, True]),  # who reads it says which texts are known
        (tuple[int, str], [(1, "a"), [1, "a"]], [(1,), 1]),
        (Table, [{"a": [1]}], [None, 3, "x.csv", [1]]),
        (Source, [None, 3, "x.csv"], []),  # who reads tables says what is none
        (Any, [None, 3], []),
        (list[int] | None, [[1], (1,), None], [1, "1"]),
    ],
)
def test_values_of_a_type(hint: Any, good: list[Any], bad: list[Any]) -> None:
    assert [value for value in good if not fits(value, hint)] == []
    assert [value for value in bad if fits(value, hint)] == []


@pytest.mark.parametrize(
    ("hint", "words"),
    [
        (Number | None, "a number such as 0.95 or '5/4'"),
        (LabelLike | None, "a label"),
        (Sequence[Number] | Sequence[Sequence[Number]], "a list of numbers or a list of lists"),
        (str | PathLike[str] | None, "a path"),
        (None, "None"),
        (Mapping[str, int] | Callable[[str], int], "a dict or a function"),
        (Fraction | list[int], "a Fraction or a list of whole numbers"),
    ],
)
def test_what_a_type_accepts(hint: Any, words: str) -> None:
    assert accepted(hint) == words


@answered
def told(first: int, /, second: Sequence[str] = (), *rest: int, third: bool = False, **more: int) -> tuple[Any, ...]:
    return first, second, rest, third, more


def test_calls_that_fit_are_made() -> None:
    assert told(1) == (1, (), (), False, {})
    assert told(1, ["a"], 5, 6, third=True, fourth=4) == (1, ["a"], (5, 6), True, {"fourth": 4})
    assert told(1, None, third=None) == (1, None, (), None, {})  # type: ignore[arg-type]  # nothing is the default


class Kept:
    @answered
    def method(self, name: str) -> str:
        return name

    @classmethod
    @answered
    def made(cls, name: str) -> str:
        return name


@answered_class(size=Number)
class Sized:
    def __init__(self, size: str) -> None:
        self.size = size


WRONG: Any = Kept()


@pytest.mark.parametrize(
    ("call", "said"),
    [
        (lambda: WRONG.method(), "method needs name, which was not given"),
        (lambda: WRONG.method("a", "b"), "method takes name without a name; a text came after: leave it out"),
        (lambda: WRONG.method("a", name="b"), "method was given name twice; give it once"),
        (lambda: WRONG.method(nmae="a"), "method has no argument nmae; did you mean name?"),
        (lambda: WRONG.method(3), "name is 3, an int; a text is accepted"),
        (lambda: WRONG.made(None), "name is None; a text is accepted"),
        (lambda: WRONG.made(zzz=1), "Kept.made has no argument zzz; known: 'name'"),
        (lambda: Sized([]), "size is [], a list; a number such as 0.95 or '5/4' is accepted"),  # type: ignore[arg-type]
        (lambda: Sized(), "Sized needs size, which was not given"),  # type: ignore[call-arg]
        (lambda: told("x"), "first is 'x', a text; a whole number is accepted"),  # type: ignore[arg-type]
    ],
)
def test_calls_that_do_not_fit_are_answered(call: Callable[[], object], said: str) -> None:
    with pytest.raises(InputError) as error:
        call()
    assert str(error.value) == said


def test_errors_of_the_function_itself_are_its_own() -> None:
    @answered
    def fails(number: int) -> float:
        raise TypeError("its own")

    with pytest.raises(TypeError, match="its own"):
        fails(1)


@pytest.mark.parametrize(
    ("value", "said"), [(None, "None"), (True, "a truth value"), ("x", "a text"), (1, "an int"), (Path, "the class Path"), ({}, "a dict")]
)
def test_what_a_value_is(value: object, said: str) -> None:
    assert kind_of(value) == said


def test_names_that_are_imported_for_annotations_alone_are_those_of_classes() -> None:
    """What is not loaded is known by the name of its class, so that no other type may be imported that way where a call is looked at."""
    looked_at = 0
    for found in pkgutil.walk_packages(fairaudit.__path__, "fairaudit."):
        if ".checker" in found.name or "__main__" in found.name or "plugins" in found.name:
            continue
        module = importlib.import_module(found.name)
        members = [module, *(kind for _, kind in inspect.getmembers(module, inspect.isclass) if kind.__module__ == found.name)]
        functions = {
            inspect.unwrap(one) for of in members for one in vars(of).values() if inspect.isfunction(one) and hasattr(one, "__wrapped__")
        }
        names = {word for one in functions for hint in hints(one).values() for word in by_name(hint)}
        tree = ast.parse(inspect.getsource(module)) if names else ast.Module([], [])
        for node in (node for node in ast.walk(tree) if isinstance(node, ast.ImportFrom)):
            for name in names & {alias.name for alias in node.names}:
                assert inspect.isclass(getattr(importlib.import_module(str(node.module)), name)), (found.name, name)
                looked_at += 1
    assert looked_at


def by_name(hint: Any) -> set[str]:
    own = {hint.__name__} if type(hint).__name__ == "_ByName" else set()
    return own.union(*map(by_name, get_args(hint)))


def test_what_is_not_loaded_is_known_by_its_name() -> None:
    @answered
    def halve(whole: Deployment | None, at: int = 0) -> None:
        pass

    pie = type("Deployment", (), {})
    halve(pie())
    halve(type("ApplePie", (pie,), {})())
    with pytest.raises(InputError, match=r"^whole is 'pie', a text; a Deployment is accepted$"):
        halve("pie")  # type: ignore[arg-type]
