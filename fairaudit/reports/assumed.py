"""What certificates take for granted, each in one short line: the full sentences are in the certificate and on its page."""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping

from fairaudit.theorems.assumptions import SENTENCES
from fairaudit.words import plain

__all__ = ["in_short"]


SHORT: Mapping[str, str] = {
    "fresh": "a decision sees group and context only as the filters release them, afresh",
    "declared-floor": "every compared group gets at least {tau} behind the filter (declared)",
    "declared-floor-in": "every compared group gets at least {tau} in {context} (declared)",
    "declared-mean-floor": "every compared group gets at least {tau} on average (declared)",
    "declared-range": "utilities are from {m} to {gamma}, groups {lipschitz} apart (declared)",
    "declared-range-in": "utilities are from {m} to {gamma} in {context} (declared)",
    "drift": "the policy moves by a total variation of at most {drift} (declared)",
    "releases": "one memory sees at most {releases} releases of a group (declared)",
    "same-range": "an update brings no utility outside the range that its cell has here",
    "held-shares": "the contexts of each group stay distributed as they are here",
    "cell-drift": "each cell moves by a total variation of at most {drift} (declared)",
    "stated-population": "the contexts of each group are as in the stated population",
    "draws": "the decisions on a group in a context were drawn independently",
    "units": "different units are independent, and alike in what they get on average",
    "one-row": "a unit has at most one row for a group in a context",
    "paired": "different units are independent; what one gets in two groups need not be",
    "by-design": "in which groups a unit was seen does not depend on what it got",
    "pooled": "the contexts of each group were drawn from its population, not set by design",
    "range": "whatever could have been drawn has a utility from {low} to {high}",
    "own-range": "no utility is below 0, or above the greatest that was seen in its cell",
    "chosen": "utility, method and confidence were chosen without looking at the draws",
    "cells": "the draws of different contexts and groups are independent of each other",
    "split": "the hash that splits the draws into halves behaves as random",
    "hidden-both": "an unrecorded factor is {k} times as common and changes {m} times, at most",
    "hidden-higher": "an unrecorded factor is {k} times as common and changes {m} times, at most",
    "hidden-lower": "an unrecorded factor is {k} times as common and changes {m} times, at most",
    "given-labels": "given the true labels, decisions are independent, at the rate of their cell",
    "chosen-labels": "positive labels and confidence were chosen without looking at the draws",
    "past": "each decision has the mean of its context and group, whatever came before",
    "own-past": "each decision that counts has the mean of its cell, whatever came before",
    "mix": "the contexts of a group's next decision do not depend on the past",
    "order": "which groups appear, and when, does not depend on how decisions come out",
    "unknown-compared": "in each context only groups that are recorded there are compared",
    "unknown-share": "of those without a group {low} to {high} are of {group} (declared)",
    "unknown-others": "of those without a group {low} to {high} are of none (declared)",
    "undecided": "each undecided decision is worth something from {least} to {most}",
    "undecided-released": "what an undecided decision meant depends on what is released alone",
}
"""By the names of `SENTENCES`; what stands in braces is filled in from the sentence."""

LEFT_OUT = "; they are taken to be no different from the others"


def in_short(assumptions: Iterable[str]) -> tuple[str, ...]:
    """Say assumptions in one short line each, those that come to the same once.

    Examples
    --------
    >>> in_short(["whatever could have been drawn has a utility between 0 and 1"])
    ('whatever could have been drawn has a utility from 0 to 1',)
    """
    return tuple(dict.fromkeys(map(_shortened, assumptions)))


def _shortened(text: str) -> str:
    if text.endswith(LEFT_OUT):
        return "what was left out is no different from the rest"
    for name, short in SHORT.items():
        if found := _filled_in(SENTENCES[name], text):
            return plain(short.format(**found.groupdict()))
    return plain(text)


def _filled_in(sentence: str, text: str) -> re.Match[str] | None:
    """What stands for the names in braces, if the text is the sentence with them filled in."""
    parts = re.split(r"\{(\w+)\}", sentence)
    if not text.startswith(parts[0]):
        return None
    filled = [re.escape(part) if i % 2 == 0 else f"(?P<{part}>.*)" for i, part in enumerate(parts)]
    return re.fullmatch("".join(filled), text, re.DOTALL)
