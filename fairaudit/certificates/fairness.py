"""Whether the second of two certificates is less fair than the first: both ends of the quotient of their greatest ratios.

Let R be the greatest ratio of the first and R' that of the second. If R' is at most U' and R at least L, R'/R is at most U'/L; if R' is at
least L' and R at most U, it is at least L'/U. Each of the two fails only where one of the ends that it rests on does: with at most the sum
of their errors, whatever the draws of the two have to do with each other. Of the sentences R' > m·R and R' ≤ m·R one is true, and only the
other one is wrong to say: so the same sum limits the chance of a wrong answer.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from fractions import Fraction
from math import inf
from typing import Any, Literal

from fairaudit.certificates.reader import number
from fairaudit.errors import shown
from fairaudit.exact.extended import Extended
from fairaudit.measures.limits import Quantity
from fairaudit.tables.evaluations.lost import UNITS
from fairaudit.theorems.bound import THIS_LAW
from fairaudit.theorems.registry import ONE_SIDED, SAMPLED, without_objection
from fairaudit.words import WHATEVER, WHOEVER, approximate, brief, factor_text, percent

__all__ = ["Fairness", "FairnessVerdict", "drawn_otherwise", "fairness", "sharpened"]

FairnessVerdict = Literal["less fair", "no less fair", "not established"]

QUANTITIES: tuple[Quantity, ...] = ("local", "global")

ROWS = "mean over rows"

OPEN = {WHATEVER: "what undecided decisions meant leaves it open", WHOEVER: "who those of unknown group are leaves it open"}

Beyond = tuple[Sequence[str], Sequence[str]]


@brief
@dataclass(frozen=True, repr=False)
class Fairness:
    """What is established of the greatest ratio of the new certificate as a multiple of the old one's.

    Attributes
    ----------
    quantity : {"local", "global"}
        Which ratio: within contexts, or of group means.
    margin : Fraction
        The new one is less fair if its ratio is more than so many times the old one's.
    old, new : tuple of Fraction or float
        The least and the greatest that each ratio can be.
    ratio : tuple of Fraction or float
        The least and the greatest that the quotient can be.
    confidence : Fraction or None
        At which each end of the quotient holds; None where the tables themselves are compared.
    verdict : {"less fair", "no less fair", "not established"}
        What follows.
    why : str
        Why nothing is established, where the ends alone do not say so.
    assumptions : tuple of str
        What the reader must accept of the ends.
    lost : tuple of str
        What the old certificate compares and the new one does not, which is in the way of "no less fair".
    """

    quantity: Quantity
    margin: Fraction
    old: tuple[Extended, Extended]
    new: tuple[Extended, Extended]
    ratio: tuple[Extended, Extended]
    confidence: Fraction | None
    verdict: FairnessVerdict
    why: str = ""
    assumptions: tuple[str, ...] = ()
    lost: tuple[str, ...] = field(default=(), repr=False)

    @property
    def sentence(self) -> str:
        """The verdict in words."""
        times = "" if self.margin == 1 else f"{approximate(self.margin)} times "
        one, other = f"the {self.quantity} ratio of the new one", f"{times}that of the old one"
        if self.verdict == "not established":
            because = f": {self.why}" if self.why else ""
            return f"NOT ESTABLISHED whether {one} is more than {other}{because}"
        if self.verdict == "no less fair":
            return f"NO LESS FAIR: {one} is at most {other}"
        exact = self.ratio[0] == self.ratio[1]
        size = f"{'' if exact else 'at least '}{factor_text(self.ratio[0], 'nearest' if exact else 'down')} times as much"
        size += " in the tables alone" if self.confidence is None else ""
        return f"LESS FAIR: {one} is more than {other}" + (f", {size}" if self.ratio[0] < inf else "")

    @property
    def ends(self) -> str:
        """What is known of the quotient, and how surely."""
        low, high = factor_text(self.ratio[0], "down"), factor_text(self.ratio[1], "up")
        if self.confidence is None:
            said = factor_text(self.ratio[0]) if self.ratio[0] == self.ratio[1] else f"at least {low}, at most {high}"
            return f"new/old is {said}, of what the two certificates are about; nothing is said of a population from which it was drawn"
        sure = f"each at {percent(self.confidence)}, whatever the draws of the two have to do with each other"
        return f"new/old is at least {low}, at most {high}, {sure}"


@dataclass(frozen=True)
class _Known:
    """What a certificate claims of a ratio: both ends, the chance that one of them is wrong, and what it assumes."""

    ends: tuple[Extended, Extended]
    error: Fraction | None
    estimand: str
    assumptions: tuple[str, ...]


def fairness(
    old: Mapping[str, Any], new: Mapping[str, Any], margin: Fraction, more: Beyond, objections: Sequence[str] = ("", ""), barred: str = ""
) -> tuple[Fairness, ...]:
    """Compare the greatest ratios of two certificates that were checked, those that both of them state.

    Parameters
    ----------
    old, new : mapping
        The JSON documents.
    margin : Fraction
        From 1: how many times the old ratio the new one may be before it is less fair.
    more : pair of sequence of str
        What the old certificate compares and the new one does not, and the other way round.
    objections : pair of str
        Of each certificate, whoever or whatever was not recorded: the claims that hold nevertheless are taken.
    barred : str
        Why nothing is established, whatever the ends are.
    """
    found = (_compared(name, old, new, margin, more, objections, barred) for name in QUANTITIES)
    return tuple(made for made in found if made is not None)


def _compared(
    name: Quantity, old: Mapping[str, Any], new: Mapping[str, Any], margin: Fraction, more: Beyond, objections: Sequence[str], barred: str
) -> Fairness | None:
    was, now = (_known(document, name, objection) for document, objection in zip((old, new), objections, strict=True))
    if was is None or now is None:
        return None
    ratio = _quotient(now.ends[0], was.ends[1], Fraction(0)), _quotient(now.ends[1], was.ends[0], inf)
    less, no_less = now.ends[0] > margin * was.ends[1], now.ends[1] <= margin * was.ends[0]
    confidence = None if was.error is None or now.error is None else max(Fraction(0), 1 - was.error - now.error)
    one, other = old["subject"], new["subject"]
    why = ""
    if barred:
        why = barred
    elif one["kind"] != other["kind"] or (name == "global" and one["population"] != other["population"]):
        why = "the two describe different things"
    elif (was.error is None) != (now.error is None):
        why = "only one of the two says something of a population"
    elif was.estimand != now.estimand:
        why = f"one is about the {was.estimand}, the other about the {now.estimand}"
    elif was.error is not None and (other_draws := drawn_otherwise(old, new)):
        why = other_draws
    elif confidence == 0:
        why = "the errors of the two intervals add up to 1 or more"
    elif less and no_less:
        why = "the ends cross"
    elif beyond := (more[1] if less else more[0] if no_less else ()):
        why = _more_than("the first" if no_less else "the second", beyond)
    elif confidence is None and not (less or no_less):
        why = "; ".join(dict.fromkeys(OPEN[objection] for objection in objections if objection in OPEN))
    verdict: FairnessVerdict = "less fair" if less else "no less fair"
    if why or not (less or no_less):
        verdict = "not established"
    assumed = tuple(dict.fromkeys((*was.assumptions, *now.assumptions)))
    return Fairness(name, margin, was.ends, now.ends, ratio, confidence, verdict, why, assumed, tuple(more[0]))


def drawn_otherwise(old: Mapping[str, Any], new: Mapping[str, Any]) -> str:
    """Say that what is drawn in one evaluation log is not what is drawn in the other, so that their populations differ; else nothing."""
    one, other = (_drawn(document["subject"].get("evaluation")) for document in (old, new))
    return "" if one == other else f"the two describe different things: in the old one {one}, in the new one {other}"


def _drawn(said: Mapping[str, Any] | None) -> str:
    """What was drawn, with the columns of units that are no questions."""
    if said is None:
        return "it is not said what was drawn"
    unit = f" ({', '.join(shown(name, 60) for name in said.get('unit', ()))})" if said["drawn"] == UNITS else ""
    return f"{said['drawn']}{unit}"


def sharpened(found: Fairness, closer: Fairness, change: Extended, assumed: Sequence[str]) -> Fairness:
    """The same, with two ways to an end from above: both ratios with half of the error, and what R'/R is at most with the other half.

    Parameters
    ----------
    found, closer : Fairness
        The comparison with all of the error, from which the end from below is taken, and with half of it.
    change : Fraction or float
        What the quotient is at most by the change of rates.
    assumed : sequence of str
        What that rests on.
    """
    ratio = found.ratio[0], min(closer.ratio[1], change)
    less, no_less = found.verdict == "less fair", ratio[1] <= found.margin
    why = found.why
    if not why and less and no_less:
        why = "the ends cross"
    elif not why and no_less and found.lost:
        why = _more_than("the first", found.lost)
    assumptions = tuple(dict.fromkeys((*found.assumptions, *assumed)))
    verdict: FairnessVerdict = "less fair" if less else "no less fair"
    found = replace(found, assumptions=assumptions)
    return replace(found, ratio=ratio, why=why, verdict="not established" if why or not (less or no_less) else verdict)


def _more_than(which: str, beyond: Sequence[str]) -> str:
    return f"{which} compares more than the other: {beyond[0]}"


def _quotient(one: Extended, other: Extended, unknown: Extended) -> Extended:
    """one/other for numbers from 1; `unknown` where both are infinite."""
    if other == inf:
        return unknown if one == inf else Fraction(0)
    return inf if one == inf else Fraction(one) / Fraction(other)


def _known(document: Mapping[str, Any], name: str, objection: str) -> _Known | None:
    """What is claimed of a ratio under an objection: of the population if there is such a claim, else of the table."""
    kinds = (SAMPLED, ONE_SIDED, THIS_LAW)
    stated = [(claim, *without_objection(claim["scope"])) for claim in document["claims"] if claim["quantity"] == f"{name}_ratio"]
    claims = [(claim, scope, own) for claim, scope, own in stated if scope == THIS_LAW or scope.startswith(kinds[:2])]
    for opening in kinds:
        about = [claim for claim, scope, own in claims if own == objection and scope.startswith(opening)]
        lower = [claim for claim in about if claim["relation"] in (">=", "=")]
        upper = [claim for claim in about if claim["relation"] in ("<=", "=")]
        if not (lower and upper):
            continue
        error = None
        if opening == THIS_LAW:
            low, high = max(lower, key=_value), min(upper, key=_value)
        else:
            low, high = lower[0], upper[0]
            said = [without_objection(claim["scope"])[0].removeprefix(opening) for claim in (low, high)]
            error = max(1 - Fraction(number(text)) for text in said)
        estimand = document.get("intervals", {}).get(name, {}).get("estimand", ROWS) if error is not None else ROWS
        assumed = tuple(dict.fromkeys((*low["assumptions"], *high["assumptions"])))
        return _Known((_value(low), _value(high)), error, estimand, assumed)
    return None


def _value(claim: Mapping[str, Any]) -> Extended:
    return number(claim["value"])
