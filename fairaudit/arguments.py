"""Calls that cannot be meant, answered in one sentence: an argument that is unknown, absent, one too many, or of a wrong type."""

from __future__ import annotations

import builtins
import typing
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import suppress
from decimal import Decimal
from fractions import Fraction
from functools import cache, wraps
from inspect import Parameter, Signature, signature
from itertools import islice
from numbers import Integral, Real
from os import PathLike
from types import NoneType, SimpleNamespace, UnionType
from typing import Any, Literal, ParamSpec, TypeVar, Union, get_args, get_origin
from uuid import UUID

from fairaudit.errors import InputError, kind_of, nearest, shown

__all__ = ["accepted", "answered", "answered_class", "fits", "hints"]

P = ParamSpec("P")

R = TypeVar("R")

C = TypeVar("C")

LOOKED_AT = 1_000
"""How many values of a list or mapping are looked at; whoever reads the rest says what is wrong with it."""

NUMBER = "a number such as 0.95 or '5/4'"

WORDS: dict[Any, str] = {bool: "True or False", int: "a whole number", float: "a number", PathLike: "a path"}

MANY = {
    "a text": "texts",
    "the name of a column": "such names",
    NUMBER: "numbers",
    "a whole number": "whole numbers",
    "a label": "labels",
    "a path": "paths",
}

COLUMNS = frozenset(
    {"decision", "group", "context", "truth", "count", "probability", "weight", "unit", "score"}
    | {"utility_column", "attributes", "slots", "winner"}
)
"""Arguments whose texts are names of columns."""

REMEDIES = {"utility": ", such as {'hired': 1}", "subject": "; give a table to audit"}
"""What else is said of some arguments."""

SHOWN = (str, int, float, complex, list, tuple, dict, set)


def answered(function: Callable[P, R], **types: Any) -> Callable[P, R]:
    """Let a function say in one sentence what is wrong with a call, and what would be accepted.

    Values are only looked at as far as their types, those of the function's own arguments or the given; whoever reads them says the rest.

    Examples
    --------
    >>> @answered
    ... def halve(number: int, *, exactly: bool = False) -> float:
    ...     return number / 2
    >>> for wrong in (lambda: halve("2"), lambda: halve(2, exact=True), lambda: halve()):
    ...     try:
    ...         wrong()
    ...     except InputError as error:
    ...         print(error)
    number is '2', a text; a whole number is accepted
    halve has no argument exact; did you mean exactly?
    halve needs number, which was not given
    """

    @wraps(function)
    def call(*args: P.args, **kwargs: P.kwargs) -> R:
        known = _signature(function)
        try:
            given = known.bind(*args, **kwargs).arguments
        except TypeError:
            raise InputError(_misfit(function, args, kwargs)) from None
        wanted = {**hints(function), **types}
        for name, value in given.items():
            default = known.parameters[name].default
            if name in wanted and value is not default and not (value is None and not default) and not fits(value, wanted[name]):
                raise InputError(_unfit(name, value, wanted[name]))
        return function(*args, **kwargs)

    return call


def answered_class(**types: Any) -> Callable[[type[C]], type[C]]:
    """Let a class answer calls of its constructor as `answered` does; of types that differ from those that it keeps, the ones given."""

    def decorate(made: type[C]) -> type[C]:
        made.__init__ = answered(made.__init__, **types)  # type: ignore[method-assign]
        return made

    return decorate


@cache
def _signature(function: Callable[..., Any]) -> Signature:
    return signature(function)


@cache
def hints(function: Callable[..., Any]) -> dict[str, Any]:
    """Types of the arguments of a function by name, without those of variable arguments and of libraries that are not loaded."""
    found: dict[str, Any] = {}
    known = _Known(getattr(function, "__globals__", {}))
    for name, parameter in _signature(function).parameters.items():
        if parameter.annotation is not Parameter.empty and parameter.kind not in (Parameter.VAR_POSITIONAL, Parameter.VAR_KEYWORD):
            named = SimpleNamespace(__annotations__={name: parameter.annotation})
            with suppress(AttributeError):
                found |= typing.get_type_hints(named, globalns={}, localns=known)
    return found


class _ByName(type):
    """The type of a class whose module was not loaded for its function: its instances are known by the name of their class."""

    def __instancecheck__(cls, value: object) -> bool:
        return any(base.__name__ == cls.__name__ for base in type(value).__mro__)


class _Known(dict[str, Any]):
    """What a module knows by name; a name that it imports for annotations alone is that of a class."""

    def __missing__(self, name: str) -> Any:
        return vars(builtins)[name] if name in vars(builtins) else _ByName(name, (), {})


def fits(value: object, hint: Any) -> bool:
    """Whether a value is of a type, as far as that can be told without reading all of it.

    Examples
    --------
    >>> fits("sex", str | Sequence[str]), fits(["sex", 3], str | Sequence[str]), fits(True, int), fits(True, bool)
    (True, False, False, True)
    """
    origin, parts = get_origin(hint), get_args(hint)
    if hint is Any:
        return True
    if origin in (Union, UnionType):
        return _left(value, parts) or any(fits(value, part) for part in parts)
    if origin is Literal:
        return isinstance(value, str)
    if origin is not None:
        return _contains(value, origin, parts)
    if hint in (None, NoneType):
        return value is None
    if hint is bool:
        return type(value).__name__ in ("bool", "bool_")  # numpy has its own
    if hint in (int, float):
        return isinstance(value, Integral if hint is int else Real) and not isinstance(value, bool)
    if getattr(hint, "_is_protocol", False):
        own = getattr(value, "__dict__", {})  # of a value only its type is asked, because a lazy frame would have to work for the answer
        return all(name in own or hasattr(type(value), name) for name in vars(hint) if not name.startswith("_"))
    return isinstance(value, hint) if isinstance(hint, type) else True


def _left(value: object, parts: Sequence[Any]) -> bool:
    """Whether who reads a value says what is accepted: of labels, and of tables and certificates, which have more forms than types name."""
    if UUID in parts:
        return not isinstance(value, (list, dict, set))
    return str in parts and any(getattr(part, "_is_protocol", False) for part in parts)


def _contains(value: Any, origin: Any, parts: Sequence[Any]) -> bool:
    """Whether a value is a container of that kind, and of those types."""
    if not isinstance(origin, type):
        return True
    if origin.__name__ == "Callable":
        return callable(value)
    if issubclass(origin, Mapping):
        return isinstance(value, Mapping) and all(fits(one, parts[1]) for one in islice(value.values(), LOOKED_AT))
    if origin is tuple:
        return isinstance(value, (tuple, list)) and (Ellipsis in parts or len(value) == len(parts))
    if issubclass(origin, Sequence) or (origin is Iterable and isinstance(value, (str, list, tuple))):
        return _is_list(value, parts) and all(fits(one, parts[0]) for one in _few(value, parts[0]))
    return isinstance(value, origin)


def _is_list(value: Any, parts: Sequence[Any]) -> bool:
    """Whether a value is a list of some kind; a column of a frame is none of texts, because it may be meant for its name."""
    if isinstance(value, str):
        return fits(value, parts[0])  # the letters of a text can be labels
    if isinstance(value, (Sequence, typing.KeysView, typing.ValuesView)):
        return not isinstance(value, (bytes, bytearray))
    array = hasattr(value, "__array__") and hasattr(value, "__len__") and not hasattr(value, "columns")
    return array and not (parts == (str,) and hasattr(value, "index"))


def _few(value: Any, of: Any) -> Iterator[Any]:
    """The first values of a list; none of numbers, whose reader says which is none."""
    return islice(value, LOOKED_AT) if isinstance(value, (list, tuple)) and Fraction not in get_args(of) else iter(())


def _unfit(name: str, value: Any, hint: Any, where: str = "") -> str:
    """Say what an argument is, or what in it does not fit, and what it may be."""
    parts = get_args(hint) if get_origin(hint) in (Union, UnionType) else (hint,)
    for part in parts:
        of = get_args(part)
        if isinstance(value, Mapping) and _is_kind(part, Mapping):
            key, one = next(item for item in value.items() if not fits(item[1], of[1]))
            return _unfit(name, one, of[1], f"{where}[{shown(key)}]")
        if isinstance(value, (list, tuple)) and _is_kind(part, Sequence) and not all(fits(one, of[0]) for one in _few(value, of[0])):
            at, one = next(item for item in enumerate(value) if not fits(item[1], of[0]))
            return _unfit(name, one, of[0], f"{where}[{at}]")
    own = getattr(value, "name", None)
    meant = f"; did you mean its name, {shown(own)}?" if isinstance(own, str) and fits(own, hint) else ""
    text = f"{shown(value)}, {kind_of(value)}" if isinstance(value, SHOWN) else kind_of(value)
    return (
        f"{name}{where} is {text}; {accepted(hint, named=name in COLUMNS)} is accepted{meant or ('' if where else REMEDIES.get(name, ''))}"
    )


def _is_kind(hint: Any, kind: type) -> bool:
    origin = get_origin(hint)
    return isinstance(origin, type) and issubclass(origin, kind) and bool(get_args(hint))


def accepted(hint: Any, *, named: bool = False) -> str:
    """Say what a type accepts; `named` says that texts are names of columns.

    Examples
    --------
    >>> accepted(int | None), accepted(str | Sequence[str]), accepted(Literal["error", "drop"])
    ('a whole number', 'a text or a list of texts', "'error' or 'drop'")
    """
    words = list(dict.fromkeys(_accepted(hint, "the name of a column" if named else "a text")))
    words = [word for word in words if word != "None"] or words
    if any(word.startswith("a list of") for word in words):
        words = [word for word in words if word != "a list"]
    return " or ".join(part for part in (", ".join(words[:-1]), words[-1]) if part)


def _accepted(hint: Any, text: str) -> Iterator[str]:
    origin, parts = get_origin(hint), get_args(hint)
    if origin in (Union, UnionType):
        yield from _one_of(parts, text)
    elif origin is Literal:
        yield from map(repr, parts)
    elif hint in (None, NoneType):
        yield "None"
    elif hint is str:
        yield text
    elif (origin or hint) in WORDS:
        yield WORDS[origin or hint]
    elif _is_kind(hint, Mapping):
        yield "a dict"
    elif _is_kind(hint, Iterable):
        of = " or ".join(word for word in _accepted(parts[0], text) if word != "None")
        many = "lists" if of.startswith("a list") else MANY.get(of, "")
        yield f"a list of {many}" if many else "a list"
    elif getattr(origin or hint, "__name__", "") == "Callable":
        yield "a function"
    else:
        name = getattr(origin or hint, "__name__", str(hint)).replace("Frame", "frame")
        yield f"{'an' if name[0] in 'AEIO' else 'a'} {name}"


def _one_of(parts: Sequence[Any], text: str) -> Iterator[str]:
    """What each part of a union accepts, with one word for what stands for a label, a number or a path."""
    rest = list(parts)
    if UUID in rest:
        yield "a label"
        rest = [part for part in rest if not isinstance(part, type) or part is NoneType]
    elif Fraction in rest and str in rest:
        yield NUMBER
        rest = [part for part in rest if part not in (int, str, Fraction, Decimal, float)]
    if any((get_origin(part) or part) is PathLike for part in rest):
        rest.remove(str)
    for part in rest:
        yield from _accepted(part, text)


def _misfit(function: Callable[..., Any], args: Sequence[Any], kwargs: Mapping[str, Any]) -> str:
    """Say which argument a function does not have, or which it lacks."""
    from difflib import get_close_matches

    name = _name(function)
    parameters = list(_signature(function).parameters.values())
    if parameters and parameters[0].name in ("self", "cls"):
        parameters, args = parameters[1:], args[1:]
    names = [p.name for p in parameters]
    in_order = [p.name for p in parameters if p.kind in (Parameter.POSITIONAL_ONLY, Parameter.POSITIONAL_OR_KEYWORD)]
    for word in kwargs:
        if word not in names:
            close = get_close_matches(word, names, n=1, cutoff=0.6)
            return f"{name} has no argument {word}; {f'did you mean {close[0]}?' if close else nearest(word, names)}"
    if len(args) > len(in_order):
        rest = [n for n in names if n not in in_order and n not in kwargs]
        taken = " and ".join(in_order) or "no argument"
        remedy = f"name it, as in {rest[0]}=…" if rest else "leave it out"
        return f"{name} takes {taken} without a name; {kind_of(args[len(in_order)])} came after: {remedy}"
    given = {*in_order[: len(args)], *kwargs}
    absent = [p.name for p in parameters if p.default is Parameter.empty and p.name not in given]
    if absent:
        listed = " and ".join(part for part in (", ".join(absent[:-1]), absent[-1]) if part)
        return f"{name} needs {listed}, which {'was' if len(absent) == 1 else 'were'} not given"
    twice = next(word for word in kwargs if word in in_order[: len(args)])
    return f"{name} was given {twice} twice; give it once"


def _name(function: Callable[..., Any]) -> str:
    """What a user calls a function by."""
    of, _, name = function.__qualname__.rpartition(".")
    if name == "__init__":
        return of
    bound = next(iter(_signature(function).parameters), "") == "self"
    return name if bound or of.endswith("<locals>") else function.__qualname__
