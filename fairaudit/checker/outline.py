"""What a certificate says in short: where its table is, its targets, what is known of each ratio, and what only a reader can judge."""

from __future__ import annotations

from collections.abc import Iterator, Mapping

from .certificate import Certificate
from .claims import LAW, Claim, without_objection
from .drift import T16
from .figures import EXPECTED_DIFFERENCES
from .judgement import Facts
from .left_out import left_out_by_group
from .rationals import Rational
from .summary import NAMES, assumed_for, percent, rounded, said_of_figure, said_of_table, said_of_target
from .text import Outline

OVER_TIME = "the change over time"
UPDATES = "later updates"
OF_ITS_UTILITY = "A class of utilities is stated; what is said of the table is said of the one utility that the certificate holds."


def outline_of(stated: Certificate, facts: Facts) -> Outline:
    """Say in short what a certificate says of which every statement is true."""
    assumed = [(_rests(claim), claim.assumptions) for claim in stated.claims]
    if stated.change is not None:
        assumed.append((OVER_TIME, stated.change.assumptions))
    left_out = ((own, step.unit) for step in stated.preparation for own in step.groups or ())
    return Outline(
        said_of_table(stated.cells, embedded=stated.embedded is not None),
        tuple(
            said_of_target(
                _name(target.quantity, stated), target.unit, target.limit, target.judged, target.verdict, of_units=target.of_units
            )
            for target in stated.targets
        ),
        tuple(filter(None, _figures(stated, {name: found.value for name, found in facts.metrics.items() if found is not None}))),
        assumed_for(assumed),
        tuple(text for text in ("" if stated.evaluation is None else stated.evaluation.words, left_out_by_group(left_out)) if text),
    )


def _rests(claim: Claim) -> str:
    """Say what an assumption of a claim is about: its scope, but where the claim is about changes of that."""
    return UPDATES if claim.key[2] == T16 and not without_objection(claim.key[3])[1] else claim.key[3]


def _name(quantity: str, stated: Certificate) -> str:
    """Name a ratio or difference; without contexts there is nothing within which to compare."""
    named, _, difference = quantity.partition("_")
    name = NAMES[named]
    if not stated.subject.columns.context:
        name = "the worst ratio" if named == "local" else "the worst ratio of group means"
    return name.replace("ratio", "difference") if difference else name


def _figures(stated: Certificate, measured: Mapping[str, Rational]) -> Iterator[str]:
    """Say of each quantity what the table gives, and the best of what is claimed of anything else."""
    said: list[tuple[Rational | None, list[tuple[str, str, Rational]]]] = []
    for quantity in ("local", "global", *EXPECTED_DIFFERENCES):
        bounds = [(claim.key[3], claim.key[1], claim.value) for claim in stated.claims if _bounds(claim, quantity)]
        value = measured.get(quantity)
        if (value, bounds) in said and not stated.subject.columns.context:
            continue  # without contexts, group means are what was compared already
        said.append((value, bounds))
        yield said_of_figure(_name(quantity, stated), value, bounds)
    if stated.utilities is not None:
        yield OF_ITS_UTILITY
    if stated.change is not None:
        change = stated.change
        window, stream = (
            f"between {rounded(interval.ratio[0], 'down')} and {rounded(interval.ratio[1], 'up')}"
            for interval in (change.ratio, change.stream)
        )
        yield (
            f"Over time {_name(change.quantity, stated)} did not stay the same: it was {window} in window {change.window}, and {stream} if "
            f"all decisions until then are taken together, at confidence {percent(change.confidence)}."
        )


def _bounds(claim: Claim, quantity: str) -> bool:
    """Whether a claim says what a quantity can be beyond what was counted."""
    name, _, _, scope = claim.key
    return scope != LAW and name in (
        (quantity,) if quantity in EXPECTED_DIFFERENCES else (f"{quantity}_ratio", f"{quantity}_ratio_supremum")
    )
