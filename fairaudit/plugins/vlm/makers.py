"""Embedded decision makers: no key, no network. They see what an endpoint would be shown, as labels."""

from __future__ import annotations

import json
from collections.abc import Mapping
from fractions import Fraction
from typing import Any

from fairaudit.errors import InputError
from fairaudit.exact.rationals import exact
from fairaudit.files import check_keys
from fairaudit.plugins.vlm.experiment import Experiment, Model, Slots
from fairaudit.plugins.vlm.shares import Maker, softmax

__all__ = ["StandIn", "embedded"]

PROSE = "I would rather talk to both of them first."


class StandIn(Maker):
    """A softmax over stated weights, with a bias for the first slot: the documented stand-in for a model.

    The score of a slot is the sum of the weights of its profile's values, of those that the context adds, and for slot 1 of ``position``.
    The probability of a slot is its share of the sum of e^score, rounded to a multiple of 2^-53. A share ``unreadable`` of all answers is
    prose. The weights are the sections ``[stand-in.weights.ATTRIBUTE]`` and ``[stand-in.contexts.CONTEXT.ATTRIBUTE]`` of a file.

    Examples
    --------
    >>> maker = StandIn()
    >>> sum(maker.probabilities("sick leave", maker.experiment.slots(("Tom", "Mary"))))
    Fraction(1, 1)
    """

    def __init__(self, experiment: Experiment | str = "document-delivery", parameters: Mapping[str, Any] | None = None) -> None:
        super().__init__(experiment)
        section = parameters or self.experiment.stand_in
        check_keys(section, ("position", "unreadable", "weights", "contexts"), "[stand-in]")
        self._position = float(exact(section.get("position", "0")))
        self._unreadable = exact(section.get("unreadable", "0"))
        if not 0 <= self._unreadable <= 1:
            raise InputError("[stand-in] unreadable is a share from 0 to 1")
        self._weights = self._read(section.get("weights", {}), "weights")
        contexts = section.get("contexts", {})
        check_keys(contexts, self.experiment.contexts, "[stand-in.contexts]")
        self._contexts = {context: self._read(part, f"contexts.{context}") for context, part in contexts.items()}

    def probabilities(self, context: str, slots: Slots) -> tuple[Fraction, ...]:
        """Of each slot, exact."""
        extra = self._contexts.get(context, {})
        scores = [self._position] + [0.0] * (len(slots) - 1)
        for i, profile in enumerate(slots):
            for key in zip(self.experiment.attributes, profile, strict=True):
                scores[i] += self._weights.get(key, 0.0) + extra.get(key, 0.0)
        return tuple(share * (1 - self._unreadable) for share in softmax(scores))

    def _read(self, section: Any, where: str) -> dict[tuple[str, str], float]:
        if not isinstance(section, Mapping) or not all(isinstance(part, Mapping) for part in section.values()):
            raise InputError(f"[stand-in.{where}] needs a table of weights for each attribute")
        check_keys(section, tuple(self.experiment.attributes), f"[stand-in.{where}]")
        for name, part in section.items():
            check_keys(part, self.experiment.attributes[name], f"[stand-in.{where}.{name}]")
        return {(name, value): float(exact(weight)) for name, part in section.items() for value, weight in part.items()}


def embedded(experiment: Experiment, model: Model) -> Maker:
    """The decision maker that a model names, with the model's own parameters in the place of those of the file."""
    if model.maker == "minilm":
        from fairaudit.plugins.vlm.minilm import SentenceMaker

        return SentenceMaker(experiment, model.parameters)
    return StandIn(experiment, model.parameters)


def answer_text(experiment: Experiment, place: int | None) -> bytes:
    """What a model would have written."""
    if place is None:
        return PROSE.encode()
    option = experiment.options[place]
    if experiment.answer == "token":
        return option.encode()
    chosen, other, *_ = experiment.values
    values = {name: chosen if name == option else other for name in experiment.options} | {"reason": "drawn by its probability"}
    return json.dumps({"choice": option} if experiment.answer == "choice" else values).encode()
