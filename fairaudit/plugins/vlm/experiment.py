"""Experiment files: who stands in which slot, what is asked, through which filters, and how often."""

from __future__ import annotations

import hashlib
import itertools
import json
import os
import re
import tomllib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, fields, replace
from fractions import Fraction
from functools import cached_property
from math import factorial, inf, prod
from pathlib import Path
from typing import Any, Literal
from urllib.parse import urlsplit

import fairaudit as fa
from fairaudit.errors import InputError, naming, nearest, shown
from fairaudit.exact.rationals import at_least, exact, rational
from fairaudit.files import check_keys, read_one_of, read_section, read_text, read_toml
from fairaudit.libraries import library
from fairaudit.plugins.vlm.images import read_images

__all__ = ["Experiment", "Model", "Setting", "bundled", "fixed", "read_experiment"]

Profile = tuple[str, ...]
Slots = tuple[Profile, ...]

SECTIONS = (
    "title", "source", "answer", "context", "attributes", "people", "prompt", "sampling", "filter", "utility", "targets", "images",
    "stand-in", "minilm", "model",
)  # fmt: skip
KEYS = {
    "answer": ("options", "values", "kind"),
    "context": ("column", "values", "weights"),
    "prompt": ("system", "user"),
    "sampling": ("trials", "design", "order"),
    "filter": ("keep_probability", "context_keep_probability"),
    "utility": ("name", "chosen", "other"),
    "targets": tuple(f"max_{quantity}_{unit}" for quantity in ("local", "global") for unit in ("ratio", "log")),
}
TAKEN = ("slot", "decision", "weight", "count", "probability", "setting", "trial", "kind")
DECISIONS = ("another", "chosen", "not chosen", "unreadable", "fault", "open", "refused", "reason", "drawn at random")
OURS = ("model", "messages", "stream", "response_format", "logprobs", "top_logprobs", "n")
MAKERS = ("endpoint", "stand-in", "minilm")
GREEDY = {"temperature": 0.01, "top_p": 0.01, "top_k": 1}
MAX_SLOTS, MAX_CELLS, MAX_TRIALS = 12, 20_000, 100_000


@dataclass(frozen=True)
class Model:
    """A decision maker: an endpoint, or one that is embedded."""

    name: str
    maker: Literal["endpoint", "stand-in", "minilm"] = "endpoint"
    base_url: str = ""
    key_env: str = "OPENAI_API_KEY"
    parameters: Mapping[str, Any] = field(default_factory=dict)
    structured: bool = True
    price_input: float = 0.0
    price_output: float = 0.0
    requests_per_minute: float | None = None
    tokens_per_minute: float | None = None
    concurrency: int = 4
    timeout: float = 120.0
    retries: int = 6

    @property
    def key(self) -> str:
        """What names it in a journal."""
        return f"{self.name} at {self.base_url}" if self.maker == "endpoint" else f"{self.name} ({self.maker})"


@dataclass(frozen=True)
class Setting:
    """A point of a sweep: how often an attribute of a profile, and the context, is released as it is."""

    keep: Fraction
    context_keep: Fraction

    @property
    def filtered(self) -> bool:
        """Whether anything is filtered."""
        return self.keep < 1 or self.context_keep < 1


@dataclass(frozen=True)
class Experiment:
    """An experiment file, checked."""

    name: str
    title: str
    source: str  # what it follows
    digest: str  # SHA-256 of the file and of the images that it names
    options: tuple[str, ...]  # what an answer calls the slots, in order
    values: tuple[str, ...]  # the value that an answer gives to the chosen slot, then those that it may give to others
    answer: Literal["json", "choice", "token", "logprobs"]  # its form; the last takes probabilities of the first token instead of draws
    context_column: str
    contexts: tuple[str, ...]  # X
    context_weights: tuple[Fraction, ...]  # how often each context occurs, up to a common factor; empty if all occur alike
    attributes: Mapping[str, tuple[str, ...]]  # values of each attribute of a profile
    people: Mapping[str, Profile]  # the profile of each person, in the order of the slots
    system: str  # a template
    user: str  # a template
    trials: int  # answers per cell
    # whether every pair (x̃,ã) that can be shown is asked and filters are applied exactly afterwards, or released values are drawn
    design: Literal["table", "end-to-end", "both"]
    # whether every order of the people is asked, only those in which everybody moves up by the same number of slots, or that of the file
    order: Literal["both", "cyclic", "fixed"]
    settings: tuple[Setting, ...]  # the sweep
    utility_name: str
    chosen: Fraction  # g of the person or slot that was chosen
    other: Fraction  # g of the others
    targets: Mapping[str, str]  # limits for `certify`
    images: Mapping[tuple[str, str], Path]  # for ``(context or "", option)`` the file to show
    models: tuple[Model, ...]
    stand_in: Mapping[str, Any]  # the section of that name
    minilm: Mapping[str, Any]  # the section of that name

    @cached_property
    def first_prompts(self) -> tuple[str, ...]:
        """A prompt of each context: where examples stand that an answer may repeat."""
        return tuple(text for context in self.contexts for text in self.prompt(context, self.slots(tuple(self.people))))

    @property
    def orders(self) -> tuple[tuple[str, ...], ...]:
        """Who stands in which slot; of these one is drawn, each as likely as the others."""
        names = tuple(self.people)
        if self.order == "cyclic":
            return tuple(names[i:] + names[:i] for i in range(len(names)))
        return tuple(itertools.permutations(names)) if self.order == "both" else (names,)

    def slots(self, order: Sequence[str]) -> Slots:
        """Profiles by slot."""
        return tuple(self.people[name] for name in order)

    def profile_filter(self, setting: Setting) -> fa.Mechanism:
        """M of one profile: randomized response on each attribute."""
        return fa.Product({name: _response(values, setting.keep) for name, values in self.attributes.items()})

    def context_filter(self, setting: Setting) -> fa.Mechanism:
        """M_X."""
        return _response(self.contexts, setting.context_keep)

    def shown_contexts(self, setting: Setting, context: str) -> list[str]:
        """Contexts that can be released."""
        mechanism = self.context_filter(setting)
        return [x for x in self.contexts if mechanism.probability(context, x)]

    def shown_slots(self, setting: Setting, order: Sequence[str]) -> dict[Slots, Fraction]:
        """Profiles by slot that can be released for an order, with their probabilities."""
        mechanism = self.profile_filter(setting)
        rows = [zip(mechanism.outputs, mechanism.row(profile), strict=True) for profile in self.slots(order)]
        released = itertools.product(*([(profile, weight) for profile, weight in row if weight] for row in rows))
        whole = mechanism.denominator ** len(rows)
        return {tuple(profile for profile, _ in parts): Fraction(prod(weight for _, weight in parts), whole) for parts in released}

    def cells(self) -> list[tuple[str, Slots]]:
        """Everything that can be shown, in order."""
        found: dict[tuple[str, Slots], None] = {}
        for setting, x, order in itertools.product(self.settings, self.contexts, self.orders):
            for seen in self.shown_contexts(setting, x):
                found.update(dict.fromkeys((seen, slots) for slots in self.shown_slots(setting, order)))
        return list(found)

    def prompt(self, context: str, slots: Slots) -> tuple[str, str]:
        """Render system and user prompt for what is shown."""
        candidates = [
            {"label": label, "attributes": dict(zip(self.attributes, profile, strict=True))}
            for label, profile in zip(self.options, slots, strict=True)
        ]
        values = {"context": context, "candidates": candidates, "options": list(self.options)}
        return self.filled(self.system, values, "[prompt] system"), self.filled(self.user, values, "[prompt] user")

    @staticmethod
    def filled(template: str, values: Mapping[str, Any], name: str) -> str:
        """Fill in a template, sandboxed; a fault in it, or a field that is not there, is an error."""
        jinja2 = library("jinja2", "vlm")
        environment = library("jinja2.sandbox", "vlm").SandboxedEnvironment(undefined=jinja2.StrictUndefined, autoescape=False)
        try:
            return str(environment.from_string(template).render(values)).strip()
        except (
            jinja2.TemplateError,
            ArithmeticError,
            LookupError,
            AttributeError,
            TypeError,
            ValueError,
            RuntimeError,
            MemoryError,
        ) as error:
            raise InputError(f"the template {name} cannot be filled in: {' '.join(str(error).split())}") from None

    def pictures(self, context: str) -> list[tuple[str, Path]]:
        """Images for a context, by option."""
        found = ((option, self.images.get((context, option)) or self.images.get(("", option))) for option in self.options)
        return [(option, path) for option, path in found if path is not None]


def bundled() -> dict[str, Path]:
    """Experiment files that ship with the package, by name."""
    folder = Path(__file__).resolve().parent / "experiments"
    return {path.stem: path for path in sorted(folder.glob("*.toml"))}


def read_experiment(given: str, *, trials: int | None = None) -> Experiment:
    """Read an experiment file, or one of `bundled` by name, with `trials` answers per cell instead of the number in the file.

    Every template was then rendered once for everything that can be shown.

    Raises
    ------
    InputError
        If the file is not of the form; the message names the file and the key.
    """
    path = Path(given)
    known = bundled()
    if not path.suffix and not path.is_file():
        if given not in known:
            raise InputError(
                f"there is no experiment {shown(given)}; give a .toml file, or one that ships with fairaudit ({nearest(given, known)})"
            )
        path = known[given]
    document, data = read_toml(path)
    with naming(str(path)):
        return _experiment(path, data, document, trials)


def _experiment(path: Path, data: bytes, document: Mapping[str, Any], trials: int | None) -> Experiment:
    check_keys(document, SECTIONS, "the file")
    part = {name: read_section(document, name) for name in SECTIONS if name not in ("title", "source", "model")}
    for name in {"max_local", "max_global"} & part["targets"].keys():
        raise InputError(
            f"[targets] {name} is not accepted; give {name}_ratio, a limit on the ratio such as 5/4, or {name}_log, on its logarithm"
        )
    for section, keys in KEYS.items():
        check_keys(part[section], keys, f"[{section}]")
    options = _labels(part["answer"].get("options"), "[answer] options")
    attributes = {name: _labels(values, f"[attributes] {name}", least=1) for name, values in part["attributes"].items()}
    if not attributes:
        raise InputError('[attributes] lists no attribute; list at least one, such as name = ["Tom", "Mary"]')
    people = {name: _profile(name, given, attributes) for name, given in part["people"].items()}
    if len(people) != len(options) or not 2 <= len(options) <= MAX_SLOTS:
        raise InputError(f"there are {len(people)} people and {len(options)} options; each person has a slot, 2 to {MAX_SLOTS} of them")
    images = read_images(part["images"], path.parent, options)
    kind: Any = read_one_of(part["answer"], "kind", ("json", "choice", "token", "logprobs"), "[answer]", "json")
    asked = 1 if kind == "logprobs" else trials if trials is not None else part["sampling"].get("trials")
    if not isinstance(asked, int) or isinstance(asked, bool) or not 1 <= asked <= MAX_TRIALS:
        raise InputError(f"[sampling] trials is {shown(asked)}; a whole number from 1 to {MAX_TRIALS} is accepted")
    keeps = _probabilities(part["filter"], "keep_probability")
    context_keeps = _probabilities(part["filter"], "context_keep_probability")
    listed = document.get("model", [])
    if not isinstance(listed, list):
        raise InputError("models are sections [[model]]")
    digest = hashlib.sha256(hashlib.sha256(data).digest())
    for (context, option), picture in sorted(images.items()):
        digest.update(f"{context}\0{option}\0".encode() + hashlib.sha256(picture.read_bytes()).digest())
    found = Experiment(
        name=path.stem,
        title=read_text(document, "title", "the file", path.stem),
        source=read_text(document, "source", "the file", ""),
        digest=digest.hexdigest(),
        options=options,
        values=_values(part["answer"].get("values", ["1", "0"])),
        answer=kind,
        context_column=read_text(part["context"], "column", "[context]", "context"),
        contexts=_labels(part["context"].get("values"), "[context] values", least=1),
        context_weights=_weights(part["context"]),
        attributes=attributes,
        people=people,
        system=read_text(part["prompt"], "system", "[prompt]", ""),
        user=read_text(part["prompt"], "user", "[prompt]"),
        trials=asked,
        design=read_one_of(part["sampling"], "design", ("table", "end-to-end", "both"), "[sampling]", "table"),
        order=read_one_of(part["sampling"], "order", ("both", "cyclic", "fixed"), "[sampling]", "both"),
        settings=tuple(Setting(keep, other) for keep in keeps for other in context_keeps),
        utility_name=read_text(part["utility"], "name", "[utility]", "being chosen"),
        chosen=at_least("[utility] chosen", part["utility"].get("chosen", "1"), 0, rational),
        other=at_least("[utility] other", part["utility"].get("other", "0"), 0, rational),
        targets={name: str(value) for name, value in part["targets"].items()},
        images=images,
        models=tuple(map(_model, listed, tomllib.loads(data.decode()).get("model", ()))),
        stand_in=part["stand-in"],
        minilm=part["minilm"],
    )
    _check(found)
    return found


def _check(found: Experiment) -> None:
    if len(set(found.contexts)) > 1 and found.context_column in found.attributes:
        raise InputError(f"{shown(found.context_column)} is the name of the context and of an attribute; rename one")
    if found.answer == "logprobs" and found.design != "table":
        raise InputError('[answer] kind = "logprobs" gives probabilities, not draws; use design = "table"')
    size = len(found.contexts) * {"both": factorial(len(found.people)), "cyclic": len(found.people), "fixed": 1}[found.order]
    if any(0 < s.keep < 1 for s in found.settings):
        size *= prod(len(values) for values in found.attributes.values()) ** len(found.options)
    if size > MAX_CELLS:
        advice = 'take order = "cyclic", or leave out people' if found.order == "both" and len(found.people) > 2 else "leave out people"
        raise InputError(f"{size:,} combinations of order and profiles, more than {MAX_CELLS:,}; {advice}, attributes, values or contexts")
    columns = [*TAKEN, *(f"{option} {name}" for option in found.options for name in found.attributes)]
    if found.context_column in columns or found.context_column.startswith(("own ", "other")) or len(set(columns)) < len(columns):
        raise InputError(
            f"two columns of the tables have one name; rename the context's ({shown(found.context_column)}), an option or attribute"
        )
    if wrong := next((option for option in found.options if option in DECISIONS), None):
        raise InputError(f"[answer] options has {shown(wrong)}, which is what tables call something else; give it another name")
    cells = found.cells()
    for context, slots in cells:
        found.prompt(context, slots)
    named = {(context, *map(" ".join, slots)) for context, slots in cells}
    if len(named) < len(cells):
        raise InputError("[attributes] has values of which two profiles read alike, word for word; write them in different words")
    for model in found.models:
        if (seed := fixed(model.parameters, {})) and (found.trials > 1 or found.design != "table"):
            raise InputError(
                f"{shown(model.name)} has a seed among its parameters ({seed}), and {found.trials} answers are asked for each cell: "
                'with a seed all of them are the same answer; leave it out, or ask once (trials = 1, design = "table")'
            )
    names = [model.key for model in found.models]
    if len(set(names)) < len(names):
        raise InputError(f"two models are called {shown(next(n for n in names if names.count(n) > 1))}; give each its own name")


def fixed(given: Any, least: Mapping[str, float] = GREEDY) -> str:
    """Name a parameter, at any depth, with which all answers to a request are one answer; empty if there is none.

    Examples
    --------
    >>> fixed({"top_k": 40, "options": {"Random-Seed": 7}}), fixed({"temperature": 0}), fixed({"temperature": 0.7, "top_k": 0})
    ('Random-Seed = 7', 'temperature = 0', '')
    """
    found = []
    for key, value in given.items() if isinstance(given, Mapping) else enumerate(given) if isinstance(given, list) else ():
        name = str(key).casefold()
        one = isinstance(value, (int, float)) and name in least and (value == 1 if name == "top_k" else value < least[name])
        found.append(f"{key} = {value}" if "seed" in name or one else fixed(value, least))
    return next(filter(None, found), "")


def with_overrides(model: Model, changes: Mapping[str, Any]) -> Model:
    """A model with what the command line says instead."""
    return _checked(replace(model, **{name: value for name, value in changes.items() if value is not None}))


def _response(values: Sequence[str], keep: Fraction) -> fa.Mechanism:
    return fa.Identity(values) if keep == 1 or len(values) == 1 else fa.RandomizedResponse(values, keep_probability=keep)


def _model(given: Any, with_floats: Any) -> Model:
    if not isinstance(given, dict):
        raise InputError("models are sections [[model]]")
    check_keys(given, [entry.name for entry in fields(Model)], "[[model]]")
    values = dict(given)
    for name in ("price_input", "price_output", "requests_per_minute", "tokens_per_minute", "timeout"):
        if name in values:
            number = exact(values[name])
            values[name] = float(number) if abs(number) < 10**300 else inf
    values["parameters"] = with_floats.get("parameters", {})  # which are sent as JSON
    if not isinstance(values.get("name"), str):
        raise InputError('[[model]] needs name = "…"')
    return _checked(Model(**values))


def _checked(model: Model) -> Model:
    kinds = {"concurrency": int, "retries": int, "key_env": str, "base_url": str, "structured": bool, "parameters": dict}
    for name, kind in kinds.items():
        if type(getattr(model, name)) is not kind:
            raise InputError(f"[[model]] {name} is {shown(getattr(model, name))}, which is no {kind.__name__}")
    read_one_of(vars(model), "maker", MAKERS, "[[model]]")
    if model.maker == "endpoint" and not _is_address(model.base_url):
        raise InputError(
            f"the base URL {shown(model.base_url)} is not accepted; give base_url in the file, or --base-url with --model, such as "
            "https://host/v1, without a key or query in it"
        )
    if not re.fullmatch("[A-Za-z_][A-Za-z0-9_]*", model.key_env):
        raise InputError("key_env is the name of an environment variable, not the key itself")
    if not 1 <= model.concurrency <= 256 or not 0 <= model.retries <= 100 or not 0 < model.timeout < inf:
        raise InputError("concurrency is from 1 to 256, retries from 0 to 100, and timeout a positive number of seconds")
    if not all(limit is None or 0 < limit < inf for limit in (model.requests_per_minute, model.tokens_per_minute)):
        raise InputError("limits per minute are positive")
    if not all(0 <= price < inf for price in (model.price_input, model.price_output)):
        raise InputError("prices are numbers of at least 0, for a million tokens")
    try:
        json.dumps(dict(model.parameters), allow_nan=False)
    except (TypeError, ValueError) as error:
        raise InputError(f"[[model]] parameters are sent as JSON, and hold what it has not: {error}") from None
    if model.maker == "endpoint" and (ours := model.parameters.keys() & set(OURS)):
        raise InputError(f"[[model]] parameters has {shown(min(ours))}, which the experiment says itself; leave it out")
    return replace(model, base_url=model.base_url.rstrip("/"))


def _is_address(url: str) -> bool:
    try:
        return re.fullmatch(r"https?://[^/?#@\s]+(/[^?#@\s]*)?", url) is not None and urlsplit(url).port != 0
    except ValueError:
        return False


def _labels(given: Any, where: str, least: int = 2) -> tuple[str, ...]:
    if not isinstance(given, list) or not all(isinstance(v, str) and v.strip() for v in given) or len(given) < least:
        raise InputError(f"{where} is {shown(given)}; a list of {least} texts or more is accepted")
    if len(set(given)) < len(given):
        raise InputError(f"{where} lists a value twice")
    return tuple(given)


def _profile(name: str, given: Any, attributes: Mapping[str, tuple[str, ...]]) -> Profile:
    if not isinstance(given, dict):
        raise InputError(f"[people] {name} must be a section [people.{name}] with a value for each attribute")
    check_keys(given, tuple(attributes), f"[people.{name}]")
    return tuple(read_one_of(given, attribute, values, f"[people.{name}]") for attribute, values in attributes.items())


def _probabilities(section: Mapping[str, Any], key: str) -> tuple[Fraction, ...]:
    given = section.get(key, ["1"])
    found = tuple(exact(value, f"[filter] {key}: ") for value in (given if isinstance(given, list) else [given]))
    if not found or len(set(found)) < len(found) or not all(0 <= value <= 1 for value in found):
        raise InputError(f"[filter] {key} is {shown(given)}; different probabilities from 0 to 1 are accepted, at least one")
    return found


def _weights(section: Mapping[str, Any]) -> tuple[Fraction, ...]:
    given = section.get("weights", [])
    weights = tuple(map(exact, given)) if isinstance(given, list) else ()
    if given and (len(weights) != len(section["values"]) or min(weights) <= 0):
        raise InputError(f"[context] weights is {shown(given)}; a list of positive numbers, one for each value, is accepted")
    return weights


def _values(given: Any) -> tuple[str, ...]:
    if not isinstance(given, list) or len(given) < 2:
        raise InputError('[answer] values lists the value of the chosen option, then those of the others, such as ["1", "0"]')
    if len({exact(value, "[answer] values: ") for value in given}) < len(given):
        raise InputError("[answer] values lists a value twice")
    return tuple(map(str, given))


def environment_key(model: Model) -> str:
    """The key of an endpoint, from the environment only."""
    key = os.environ.get(model.key_env, "").strip()
    if not key:
        raise InputError(
            f"the environment variable {model.key_env} is not set; put the key of {model.base_url} there (any text if it needs none)"
        )
    return key
