"""`fairaudit certify --slots … --winner …`: position and profile effects of a choice among candidates, apart."""

from __future__ import annotations

import argparse
import os
import shlex
from collections.abc import Sequence
from dataclasses import replace
from fractions import Fraction
from typing import TYPE_CHECKING, Any

from fairaudit.cli.output import Answer, in_colour
from fairaudit.cli.population import OF_SAMPLES
from fairaudit.words import noun

if TYPE_CHECKING:
    from fairaudit.audits.result import Result
    from fairaudit.inference.interval import Interval
    from fairaudit.measures.limits import Quantity
    from fairaudit.measures.ratios import Ratio
    from fairaudit.model.allocation import Allocation

FOREIGN = ("decision", "group", "count", "probability", "weight", "wide", "total", "utility", "utility_column")
NOT_HERE = ("in_parts", *OF_SAMPLES)


def certify_choices(arguments: argparse.Namespace) -> Answer:
    """Certify the profile and the position effect of a log of choices."""
    from fairaudit.audits.certify import certify
    from fairaudit.audits.reading import read_table
    from fairaudit.cli.destinations import check_output, write_outputs
    from fairaudit.cli.options import column_list, column_roles, confidence_option, given_limits
    from fairaudit.cli.source import access_of, option, progress
    from fairaudit.errors import InputError
    from fairaudit.model.allocation import CHOSEN, read_allocation

    _refuse_foreign(arguments)
    names = arguments.output or []
    beside = [f"{stem}.position{ending}" for stem, ending in map(os.path.splitext, names)]
    check_output(arguments, beside)
    bound = _bound(arguments.profile_exp_epsilon)
    slots, context = column_list(arguments.slots), column_roles(arguments.context)
    with progress() as told:
        wanted = (*slots, arguments.winner, *context.names)
        table = read_table(arguments.table, wanted, context.edges, {}, access_of(arguments), spelled=option, report=told)
    if getattr(table, "evaluation", None) is not None:
        raise InputError(f"{table.name}: --slots goes with a log of choices, and not with what is asked of samples of an evaluation log")
    targets = given_limits(arguments)
    judged, embed = confidence_option(arguments.confidence), False if arguments.no_table else None
    try:
        found = read_allocation(table, slots=slots, winner=arguments.winner, context=context.names)
        profile = certify(found.profile, {CHOSEN: 1}, **targets, confidence=judged, embed_table=embed, burden=arguments.burden)
        position = certify(found.position, {CHOSEN: 1}, confidence=judged, embed_table=embed, burden=arguments.burden)
        within = certify(found.profile_by_position, {CHOSEN: 1}, confidence=None, burden=arguments.burden)
    except InputError as error:
        raise InputError(f"{table.name}: {error}") from None
    written = write_outputs((profile, names), (position, beside)) if names else []
    return Answer(
        "allocation",
        verdict=profile.verdict,
        sentence=profile.sentence,
        notes=table.notes,
        result=lambda: _entry(found, profile, position, within, bound),
        text=lambda: (
            _text(found, profile, position, within, bound, [*names, *beside])
            if arguments.verbose
            else _screen(arguments, found, (profile, position, within), bound, written, beside)
        ),
        code=profile.exit_code,
    )


def _refuse_foreign(arguments: argparse.Namespace) -> None:
    """Refuse options that mean nothing for choices among candidates."""
    from fairaudit.errors import InputError

    for name in FOREIGN:
        if getattr(arguments, name):
            raise InputError(f"--{name.replace('_', '-')} does not go with --slots; the decision is who was chosen")
    for name in NOT_HERE:
        if getattr(arguments, name):
            raise InputError(f"--{name.replace('_', '-')} does not go with --slots; each row is one draw, with one winner")
    if arguments.fold_labels or arguments.map:
        raise InputError("--fold-labels and --map do not go with --slots; write the labels in one way first")
    if arguments.missing != "error":
        raise InputError("--missing does not go with --slots; a choice whose labels are missing is refused")
    if arguments.table is None or arguments.winner is None:
        raise InputError("--slots needs a table and --winner COL, the column that says who was chosen")


def _bound(profile_exp_epsilon: str | None) -> Any:
    if profile_exp_epsilon is None:
        return None
    from fairaudit.theorems.t10 import t10

    return t10(profile_exp_epsilon)


def _chances(result: Result) -> list[tuple[str, Fraction]]:
    """Chance of each slot or profile over all contexts."""
    law = result.law
    return [
        (law.groups[g][0], Fraction(row[law.decisions.index("chosen")], sum(row)))
        for g, row in zip(law.global_groups, law.mixed_rows, strict=True)
    ]


def _screen(
    arguments: argparse.Namespace,
    found: Allocation,
    results: tuple[Result, Result, Result],
    bound: Any,
    written: Sequence[str],
    beside: Sequence[str],
) -> str:
    """The first screen: the effect of the profile, and beside it that of the position and of the profile within a slot."""
    from fairaudit.cli.certified import next_step, source_of
    from fairaudit.reports.assumed import in_short
    from fairaudit.reports.overview import of_result
    from fairaudit.reports.screen import CONTEXTS, GROUPS, first_screen
    from fairaudit.words import approximate, plain

    own, position, within = (of_result(result, groups=GROUPS, contexts=CONTEXTS) for result in results)
    said = [f"Position effect: {position.sentences[0]}", f"Profile effect within one slot: {within.sentences[0]}"]
    assumed: tuple[str, ...] = ()
    if bound is not None and found.warnings:
        said.append("No bound for a random order (T10) is given, because the log speaks against one: see the warnings.")
    elif bound is not None:
        said.append(f"In a random order the chances of two persons differ by at most a factor {approximate(bound.value, 'up')} (T10).")
        assumed = in_short(bound.assumptions)
    then = next_step(results[0], written)
    if len(written) == 1:  # without a table of its own, so that both can be verified at once
        both = (written[0], *(name for given, name in zip(arguments.output, beside, strict=True) if given == written[0]))
        then = shlex.join(["fairaudit", "verify", *both])
    elif beside:
        said.append(f"Beside {', '.join(arguments.output)}, of the profile effect, stands that of the position: {', '.join(beside)}.")
    shown = replace(
        own,
        audited=f"{found.runs:,} {noun(found.runs, 'choice')} among {found.slots} {noun(found.slots, 'candidate')} each, "
        f"{own.audited.partition(', ')[2]}",
        cautions=(*(f"WARNING: {plain(warning)}." for warning in found.warnings), *own.cautions),
        assumptions=(*assumed, *own.assumptions),
    )
    return first_screen(shown, source_of(arguments), then, said, colour=in_colour())


def _text(found: Allocation, profile: Result, position: Result, within: Result, bound: Any, written: list[str]) -> str:
    from fairaudit.reports.text import verdict
    from fairaudit.words import approximate, plain

    blocks = [
        verdict(profile)
        if profile.targets
        else f"{found.runs} {noun(found.runs, 'choice')} among {found.slots} {noun(found.slots, 'candidate')} each; no target was set."
    ]
    blocks += [f"WARNING: {plain(warning)}." for warning in found.warnings]
    for title, result in (
        ("Position effect: what a slot gains, whoever stands in it", position),
        ("Profile effect, averaged over slots", profile),
    ):
        lines = [title]
        kinds: tuple[tuple[Quantity, str, Ratio | None], ...] = (
            ("local", "worst within a context", result.local),
            ("global", "over all contexts", result.global_),
        )
        for quantity, name, measured in kinds:
            if measured is not None:
                lines.append(f"  {name}: R = {approximate(measured.ratio)} ({plain(_where(measured))})")
            if measured is not None and quantity in result.intervals:
                lines.append(f"    {_ends(result.intervals[quantity])}")
        lines += [f"  {plain(label)}: chosen in {float(chance):.1%} of choices" for label, chance in _chances(result)]
        blocks.append("\n".join(lines))
    if within.local is not None:
        worst = f"R = {approximate(within.local.ratio)} ({plain(_where(within.local))})"
        blocks.append(f"Profile effect within a slot, the worst: {worst}; small counts vary by chance")
    if bound is not None and found.warnings:
        blocks.append("No bound for a random order (T10) is given, because the log speaks against one: see the warnings.")
    elif bound is not None:
        said = f"the chances of two persons differ by at most a factor {approximate(bound.value)} (T10)."
        judge = [f"  - {plain(text)}" for text in bound.assumptions]
        blocks.append("\n".join([f"If every profile passes a filter with this e^ε and the order is drawn at random, {said}", *judge]))
    if profile.intervals:
        assumed = dict.fromkeys(text for result in (profile, position) for found in result.intervals.values() for text in found.assumptions)
        blocks.append("\n".join(["The intervals assume, for you to judge", *(f"  - {plain(text)}" for text in assumed)]))
    else:
        blocks.append("It describes these choices, not the chooser behind them: small counts vary by chance, and no interval is claimed.")
    if written:
        blocks.append(f"Certificates of the profile and the position effect: {plain(', '.join(written))}")
    return "\n\n".join(blocks)


def _ends(interval: Interval) -> str:
    from fairaudit.words import approximate, ends_text, percent

    each = interval.ends == "each"
    ends = ends_text(approximate(interval.lower, "down"), approximate(interval.upper, "up"), each=each)
    return f"of the chooser behind these choices: {ends}, {'each at' if each else 'at confidence'} {percent(interval.confidence)}"


def _where(measured: Any) -> str:
    from fairaudit.words import approximate, place

    witness = measured.witness
    high, low = (approximate(v) for v in witness.expectations)
    context = f"{place(witness.context)}: " if witness.context else ""
    return f"{context}{place(witness.higher)} {high}, {place(witness.lower)} {low}"


def _entry(found: Allocation, profile: Result, position: Result, within: Result, bound: Any) -> dict[str, Any]:
    from fairaudit.certificates.entries import measure_entry
    from fairaudit.certificates.numbers import number
    from fairaudit.cli.certified import target_entries

    def effect(result: Result) -> dict[str, Any]:
        return {
            "local": measure_entry(result.local) if result.local else None,
            "global": measure_entry(result.global_) if result.global_ else None,
            "targets": target_entries(result),
            "chances": dict(_chances(result)),
            "certificate": result.certificate.document,
        }

    return {
        "runs": found.runs,
        "slots": found.slots,
        "imbalance": found.imbalance,
        "warnings": list(found.warnings),
        "position": effect(position),
        "profile": effect(profile),
        "profile_within_slot": measure_entry(within.local) if within.local else None,
        "random_order_bound": None if bound is None or found.warnings else number(bound.value),
    }
