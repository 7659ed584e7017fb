"""A choice read out of an answer in words: the JSON object that was asked for, an option by itself, or one of few sentences.

No choice is ever guessed: what could mean anything else is none (docs/evaluations.md, "Choices in words").
"""

from __future__ import annotations

import json
import re
import tomllib
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import lru_cache
from pathlib import Path
from typing import Any, Literal

from fairaudit.errors import InputError, shown
from fairaudit.exact.rationals import exact

__all__ = ["Asked", "Choice", "asked_of_log", "bare", "objects_in", "read_choice", "whole_number"]

LONGEST = 200_000
"""Characters of an answer that is read."""

THOUGHT = r"(?i)<{}(?:think|thinking|thought|reasoning)>"
MARKUP = re.compile(r'(?<![*`"“”])(?:(?<!\w)[*`"“”]++|[*`"“”]++(?!\w))')
"""Marks around words; one between letters or digits, as in 2*5, is part of what is said."""

WORDING = tomllib.loads(Path(__file__).with_name("wording.toml").read_text("utf-8"))
NOUN = f"(?:{'|'.join(WORDING['nouns'])})"
PARTS = ("before", "after", "doubt", "lead_ins", "tails")
BEFORE, AFTER, DOUBTED, LEAD, TAIL = ("|".join(WORDING[name]).replace("NOUN", NOUN) for name in PARTS)
STATED = r"(?:[a-z0-9à-ɏ ,'’%$€£]|(?<=\w)-(?=\w))+"
SAID = rf"(?:(?:(?:therefore|so|thus),? )?(?:{BEFORE}) )?'?@'?(?:{AFTER})?(?:,? (?:because|since) ({STATED}))?[.!]?"
DOUBT = re.compile(rf"n['’]t\b|\b(?:{DOUBTED})\b")
LEADS, TAILS = (re.compile(rf"(?i)(?:(?:{words})[:.,!]*(?: |$))*") for words in (LEAD, TAIL))
REASONS = frozenset(WORDING["reasons"])

Kind = Literal["choice", "malformed", "contradictory", "copied"]


@dataclass(frozen=True)
class Asked:
    """What a model was asked for.

    Attributes
    ----------
    options : tuple of str
        What there is to choose.
    fields : tuple of str
        Names of the field of a JSON object that holds the option, of which an answer has one.
    marks : tuple of Fraction
        What the fields of a JSON object that are called like the options hold: first the value of the option that is chosen, then the
        values of others; empty if no such object is an answer.
    one_token : bool
        Whether an option by itself counts though the answer was cut off after it.
    examples : tuple
        JSON objects that stood in the prompt: an answer that is one of them, with its reason, is a copy.
    """

    options: tuple[str, ...]
    fields: tuple[str, ...] = ()
    marks: tuple[Fraction, ...] = ()
    one_token: bool = False
    examples: tuple[Any, ...] = ()


@dataclass(frozen=True)
class Choice:
    """An answer, read.

    Attributes
    ----------
    kind : {"choice", "malformed", "contradictory", "copied"}
        What it is; ``copied`` is an example of the prompt, word for word.
    option : str
        The option that was chosen; empty if it is none.
    reason : str
        The reason that the answer states, or why it is no choice.
    """

    kind: Kind
    option: str
    reason: str


def asked_of_log(options: Sequence[str]) -> Asked:
    """What the answers of a log were to name, which does not say in what form.

    Raises
    ------
    InputError
        If there are fewer than two options, or one is there twice, blank or no text that a file can hold.

    Examples
    --------
    >>> asked_of_log(["yes", "yes"])
    Traceback (most recent call last):
    ...
    fairaudit.errors.InputError: the options 'yes', 'yes' are no choice; give two or more that differ, such as yes,no
    """
    said = ", ".join(shown(option, 40) for option in options[:10]) or "(none)"
    if len({*options}) < max(len(options), 2) or not all(option.strip() for option in options):
        raise InputError(f"the options {said} are no choice; give two or more that differ, such as yes,no")
    if any("\ud800" <= letter <= "\udfff" for option in options for letter in option):
        raise InputError(f"the options {said} hold a lone surrogate, which no text in UTF-8 has")
    return Asked(tuple(options), tuple(WORDING["fields"]), one_token=True)


def read_choice(text: str, asked: Asked, *, calls: Sequence[Any] = (), cut: bool = False) -> Choice:
    """Read what an answer chooses.

    Parameters
    ----------
    text : str
        The answer.
    asked : Asked
        What was asked for.
    calls : sequence
        Arguments of the tools that it calls, which are answers as well.
    cut : bool
        Whether it was cut off: then only a JSON object that is complete counts, or an option that begins no other one.

    Examples
    --------
    >>> asked = asked_of_log(["yes", "no"])
    >>> [read_choice(text, asked).option for text in ('{"answer": "Yes"}', "**No.**", "My answer is yes.", "yes or no", "I'd rather not.")]
    ['yes', 'no', 'yes', '', '']
    """
    if len(text) > LONGEST:
        return Choice("malformed", "", "the answer is too long")
    spoken = re.split(THOUGHT.format("/"), text)[-1]
    if re.search(THOUGHT.format(""), spoken):
        return Choice("malformed", "", "the answer breaks off in a thought")
    try:
        objects, around = _found(spoken, lenient=False)
        given = [_parse(call) if isinstance(call, str) else call for call in calls] + objects
    except InputError as error:
        return Choice("contradictory", "", str(error))
    except (ValueError, RecursionError) as error:
        return Choice("malformed", "", f"the answer is not JSON: {' '.join(str(error).split())[:120]}")
    if given:
        return _of_objects(given, around, asked)
    option = None
    if not calls and (asked.one_token or not cut):
        option = _option(asked, spoken, cut=cut) or (None if cut else _sentence(asked, spoken))
    if option is None:
        return Choice("malformed", "", "the answer has neither the JSON object that was asked for nor a single option")
    return Choice("choice", option, "")


def bare(text: str) -> str:
    """A text without marks, case, and the stop at its end.

    Examples
    --------
    >>> bare("**Yes.** "), bare("Route  1"), bare("!true"), bare("2*5")
    ('yes', 'route 1', '!true', '2*5')
    """
    return " ".join(_unmarked(text).split()).rstrip("!'").removesuffix(".").rstrip("!'").lstrip("'")


def objects_in(text: str) -> list[Any]:
    """Every JSON object in a text.

    Examples
    --------
    >>> objects_in('Answer {"choice": 1} or {so}.')
    [{'choice': 1}]
    """
    return _found(text, lenient=True)[0]


def whole_number(digits: str) -> float:
    """A whole number in JSON; one of absurd length, which Python refuses to read, is rounded, or infinite.

    Examples
    --------
    >>> whole_number("12"), whole_number("9" * 5000)
    (12, inf)
    """
    return int(digits) if len(digits) < 20 else float(digits)


def _of_objects(given: Sequence[Any], around: Sequence[str], asked: Asked) -> Choice:
    """Read the objects of an answer, which must say the same, and what stands around them."""
    if not all(_is_asked(entry, asked) for entry in given):
        return Choice("malformed", "", "the answer has an object, or a field, that was not asked for")
    read = [_object(entry, asked) for entry in given]
    first = read[0]
    if any((entry.kind, entry.option) != (first.kind, first.option) for entry in read):
        return Choice("contradictory", "", "the answer has several objects, and they differ")
    if first.kind == "choice":
        *before, after = (" ".join(_unmarked(piece).split()) for piece in around)
        if not all(map(LEADS.fullmatch, before)) or not TAILS.fullmatch(after):
            return Choice("contradictory", "", "what stands around the JSON object may refuse, or take it back")
    names = [" ".join(_unmarked(option).split()) for option in asked.options if option != first.option]
    others = "|".join(re.escape(name) if name else "(?!)" for name in names)
    other = re.compile(rf"(?:\b(?:{BEFORE}) '?(?:{others})|\b(?:{others})'?(?:{AFTER}))(?!\w)")
    stated = [value for entry in given for name, value in entry.items() if name in REASONS]
    if any(other.search(" ".join(_unmarked(said).split())) for said in _texts(stated)):
        return Choice("contradictory", "", "the stated reason chooses another option")
    return first


def _texts(value: Any) -> Iterator[str]:
    """Every text in what was read, that in an object after its name."""
    left = [("", value)]
    while left:
        name, value = left.pop()
        if isinstance(value, dict):
            left += ((f"{key.replace('_', ' ')}: ", inner) for key, inner in value.items())
        elif isinstance(value, list):
            left += ((name, inner) for inner in value)
        else:
            yield f"{name}{value}"


def _is_asked(entry: Any, asked: Asked) -> bool:
    """Whether something is an object of one of the forms that were asked for, with nothing else in it but a reason."""
    if not isinstance(entry, dict):
        return False
    keys = {*entry}
    marked = keys & {*asked.options} if asked.marks else set()
    named = keys & {*asked.fields}
    return bool(marked) != bool(named) and len(named) <= 1 and keys <= marked | named | REASONS


def _object(given: Mapping[str, Any], asked: Asked) -> Choice:
    """Read an object that was asked for."""
    reason = given.get("reason")
    said = reason if isinstance(reason, str) else ""
    if said and any(given == example for example in asked.examples):
        return Choice("copied", "", said)
    for name in asked.fields:
        if name in given:
            choice = given[name]
            named = _option(asked, str(choice)) if isinstance(choice, (str, int)) and not isinstance(choice, bool) else None
            return Choice("malformed", "", f"{shown(choice)} is no option") if named is None else Choice("choice", named, said)
    values = {}
    for option in asked.options:
        if option not in given:
            return Choice("malformed", "", f"{option} is missing")
        try:
            values[option] = exact(given[option])
        except InputError:
            return Choice("malformed", "", f"{option} has no number")
    chosen, *others = asked.marks
    picked = [option for option, value in values.items() if value == chosen]
    if len(picked) != 1 or any(value not in others for value in values.values() if value != chosen):
        return Choice("contradictory", "", said)
    return Choice("choice", picked[0], said)


def _option(asked: Asked, text: str, *, cut: bool = False) -> str | None:
    """Find the option that a text is, whatever its case and marks; never by its position, nor where a cut text may begin another one."""
    plain = bare(text)
    found = [o for o in asked.options if o == text.strip()] or [o for o in asked.options if plain and bare(o) == plain]
    begun = [o for o in asked.options if cut and o not in found and bare(o).startswith(plain)]
    return found[0] if len(found) == 1 and not begun else None


def _sentence(asked: Asked, text: str) -> str | None:
    """Find the option that a single sentence of the list names, with at most a reason that names no other and raises no doubt."""
    plain = re.sub(" +", " ", _unmarked(text).strip())
    found: dict[str, str] = {}
    named = _sentences(asked.options)
    for option, pattern, _ in named:
        sentence = pattern.fullmatch(plain)
        found |= {option: sentence[1] or ""} if sentence else {}
    if len(found) != 1:
        return None
    ((chosen, reason),) = found.items()
    return None if DOUBT.search(reason) or any(o != chosen and other.search(reason) for o, _, other in named) else chosen


@lru_cache
def _sentences(options: tuple[str, ...]) -> tuple[tuple[str, re.Pattern[str], re.Pattern[str]], ...]:
    """The sentences that choose each option, and the option itself within others."""
    names = [(option, re.escape(re.sub(" +", " ", _unmarked(option).strip())) or "(?!)") for option in options]
    return tuple((option, re.compile(SAID.replace("@", name)), re.compile(rf"(?<!\w){name}(?!\w)")) for option, name in names)


def _unmarked(text: str) -> str:
    """A text without marks around its words, and without case: Maße and MASSE are the same, as are ırk and IRK."""
    return MARKUP.sub("", text).casefold().replace("ı", "i")


def _found(text: str, *, lenient: bool) -> tuple[list[Any], list[str]]:
    """Read every JSON object in a text, and the pieces around them; unless `lenient`, a brace where none begins is an error."""
    decoder, found, around, end = json.JSONDecoder(object_pairs_hook=_pairs, parse_int=whole_number), [], [], 0
    while (start := text.find("{", end)) >= 0:
        around.append(text[end:start])
        end = start + 1
        try:
            value, end = decoder.raw_decode(text, start)
            found.append(value)
        except (ValueError, RecursionError):
            if not lenient:
                raise
    return found, [*around, text[end:]]


def _pairs(found: Sequence[tuple[str, Any]]) -> dict[str, Any]:
    keys = [key for key, _ in found]
    if len(set(keys)) < len(keys):
        raise InputError(f"the key {next(k for k in keys if keys.count(k) > 1)!r} occurs twice")
    return dict(found)


def _parse(text: str) -> Any:
    return json.loads(text, object_pairs_hook=_pairs, parse_int=whole_number)
