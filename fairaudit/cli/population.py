"""What `certify` says of the population behind counts and logs: its options, a placebo beside the effect, a test of a filter."""

from __future__ import annotations

import argparse
from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

from fairaudit.cli.options import METHODS, SELECTIONS, confidence_option, utility_range
from fairaudit.cli.source import option

if TYPE_CHECKING:
    from fairaudit.audits.result import Result
    from fairaudit.inference.comparisons import Comparison
    from fairaudit.inference.interval import Interval
    from fairaudit.model.law import Law
    from fairaudit.model.policy import Deployment
    from fairaudit.model.utility import Utility


@dataclass(frozen=True)
class Finding:
    """What a test beside the targets found: its name, a sentence, whether a claim was refuted, and the figures."""

    test: str
    sentence: str
    refuted: bool
    figures: dict[str, Any]
    lines: tuple[str, ...] = ()


OF_SAMPLES = (
    "unit",
    "missing_units",
    "interval",
    "two_sided",
    "utility_range",
    "independent_cells",
    "select",
    "placebo",
    "placebo_group",
    "by_context",
    "min_cell",
    "pool_small",
    "claimed_exp_epsilon",
)
"""Options about the population behind counts and logs, besides the confidence; what is settled otherwise refuses them."""


def add_population(parser: argparse.ArgumentParser) -> None:
    """Declare the options."""
    sampling = parser.add_argument_group("the population behind counts and logs (choose before looking at the decisions)")
    sampling.add_argument(
        "--confidence",
        metavar="C",
        default=None,
        help="confidence at which targets on counts and logs are judged (default 0.95); 'none' judges the table itself",
    )
    sampling.add_argument(
        "--unit", metavar="COL", action="append", help="of a log: rows with the same label are one draw (a run, a profile asked often)"
    )
    sampling.add_argument(
        "--missing-units",
        choices=("worst", "drop"),
        default=None,
        help="units of --unit not seen in one of two groups: count as what is worst for each claim (default), or are missing by design",
    )
    sampling.add_argument(
        "--interval",
        choices=METHODS,
        default=None,
        help="for utilities of more than two values (default: contrasts of the draws with --independent-cells, else hoeffding-kl); others "
        "have exact intervals",
    )
    sampling.add_argument(
        "--two-sided",
        action="store_true",
        help="print, beside the one-sided ends that decide targets, the interval with half of the error on each side",
    )
    sampling.add_argument("--utility-range", metavar="LOW,HIGH", help="least and greatest utility of anything that could be drawn")
    sampling.add_argument(
        "--independent-cells",
        action="store_true",
        help="decisions in different cells were drawn independently (not the same profiles with the group exchanged): narrower intervals",
    )
    sampling.add_argument(
        "--select",
        choices=SELECTIONS,
        default=None,
        help="how the lower end finds its pair of groups: all pairs share the error (default), or, of independent cells, one half of the "
        "decisions chooses a pair for the other half to test",
    )
    sampling.add_argument(
        "--placebo", metavar="TABLE", help="the same columns under edits that should not matter: is the effect above that?"
    )
    sampling.add_argument("--placebo-group", metavar="COL", action="append", help="the column of the edits there (default: as --group)")
    sampling.add_argument(
        "--by-context",
        metavar="Q",
        help="list each context by itself, and flag those above the limit of the local ratio (or above 1) at the false discovery rate Q, "
        "such as 0.1; needs independent cells",
    )
    sampling.add_argument("--min-cell", metavar="N", type=int, help="with --by-context: leave contexts out that have a smaller cell")
    sampling.add_argument("--pool-small", action="store_true", help="with --min-cell: pool them into one context instead, group by group")
    sampling.add_argument(
        "--claimed-exp-epsilon",
        metavar="Q",
        help="e^epsilon that a filter claims: do decisions, each through a fresh release of it, refute that? (T11; a release that several "
        "decisions share is named with --unit)",
    )


def population_options(arguments: argparse.Namespace, subject: Law | Deployment, given: Mapping[str, Any]) -> dict[str, Any]:
    """Confidence, method and independence for `certify`: from the command line, else from an audit file, else the defaults."""
    from fairaudit.audits.population import confidence_for

    asked = arguments.confidence if arguments.confidence is not None else given.get("confidence")
    others = {name: getattr(arguments, name) for name in ONLY_SAMPLES}
    chosen = confidence_for(subject, confidence_option(asked), asked, others, option)
    return {
        "confidence": chosen,
        "interval": arguments.interval or given.get("interval"),
        "independent": arguments.independent_cells or given.get("independent", False),
        "select": arguments.select or given.get("select", SELECTIONS[0]),
        "missing_units": arguments.missing_units or given.get("missing_units", "worst"),
    }


ONLY_SAMPLES = ("interval", "independent_cells", "select", "missing_units", "two_sided", "placebo", "claimed_exp_epsilon", "by_context")


def findings_beside(arguments: argparse.Namespace, result: Result, utility: Utility, chosen: Mapping[str, Any]) -> list[Finding]:
    """Run the tests that were asked for."""
    from fairaudit.errors import InputError
    from fairaudit.inference.levels import confidence_level
    from fairaudit.inference.ratio_intervals import default_region

    found: list[Finding] = []
    made = {"confidence": chosen["confidence"], "method": chosen["interval"] or METHODS[0], "independent": chosen["independent"]}
    if arguments.claimed_exp_epsilon is not None:
        from fairaudit.inference.hypothesis_tests import refute_epsilon

        if "local" not in result.comparisons:
            raise InputError("--claimed-exp-epsilon needs an interval for the local ratio, and there is none")
        if result.utility.depends_on_group:
            raise InputError("--claimed-exp-epsilon needs a utility that is the same for all groups; one that is not refutes nothing")
        comparison = result.comparisons["local"]
        alpha = 1 - confidence_level(chosen["confidence"])
        region = default_region(comparison, chosen["interval"], independent=chosen["independent"], alpha=alpha)
        tested = refute_epsilon(comparison, arguments.claimed_exp_epsilon, region=region, **made)
        figures = {"refuted": tested.refuted, "interval": _ends(tested.interval), "assumptions": list(tested.assumptions)}
        found.append(Finding("T11", tested.sentence, tested.refuted, figures))
    if arguments.by_context is not None:
        found.append(_by_context(arguments, result, chosen))
    elif arguments.min_cell is not None or arguments.pool_small:
        raise InputError("--min-cell and --pool-small go with --by-context")
    if arguments.placebo is not None:
        found += _placebo(arguments, result, utility, made)
    elif arguments.placebo_group is not None:
        raise InputError("--placebo-group goes with --placebo")
    return found


def _by_context(arguments: argparse.Namespace, result: Result, chosen: Mapping[str, Any]) -> Finding:
    """Each context by itself, with the false discovery rate of those that are flagged."""
    from fairaudit.certificates.numbers import number
    from fairaudit.errors import InputError
    from fairaudit.inference.by_context import by_context_text, contexts_by_themselves
    from fairaudit.measures.limits import ratio_above

    if "local" not in result.comparisons or result.law.contexts == ((),):
        raise InputError("--by-context needs contexts, and an interval for their ratio")
    if not chosen["independent"]:
        raise InputError("--by-context needs cells that were declared independent (--independent-cells)")
    if arguments.pool_small and arguments.min_cell is None:
        raise InputError("--pool-small goes with --min-cell")
    limit = max((ratio_above(target.unit, target.limit) for target in result.targets if target.quantity == "local"), default=1)
    small = {"min_cell": 1 if arguments.min_cell is None else arguments.min_cell, "pool": arguments.pool_small}
    made = contexts_by_themselves(result.comparisons["local"], limit, rate=arguments.by_context, confidence=chosen["confidence"], **small)
    sentence, lines = by_context_text(made)
    table = [
        {
            "context": own.context,
            "draws": own.draws,
            "interval": _ends(own.interval),
            "e_value": number(own.e_value),
            "flagged": own.flagged,
        }
        for own in made.findings
    ]
    figures = {
        "limit": number(made.limit),
        "rate": number(made.rate),
        "confidence": number(made.confidence),
        "min_cell": made.min_cell,
        "contexts": table,
        "not_judged": list(made.not_judged),
        "pooled": list(made.pooled),
        "assumptions": list(made.assumptions),
    }
    return Finding("by context", sentence, False, figures, lines)


def _placebo(arguments: argparse.Namespace, result: Result, utility: Utility, made: Mapping[str, Any]) -> list[Finding]:
    from fairaudit.errors import InputError
    from fairaudit.inference.hypothesis_tests import noise_floor

    try:
        law, compared = _placebo_comparisons(arguments, utility)
    except InputError as error:
        raise InputError(f"the placebo: {error}") from None
    found = []
    for quantity, effect in result.comparisons.items():
        if quantity not in compared:
            sentence = f"{quantity.capitalize()}: the placebo gives no interval, so there is nothing to compare the effect with."
            found.append(Finding(f"noise floor, {quantity}", sentence, False, {"rises": None}))
            continue
        floor = noise_floor(effect, compared[quantity], **made)
        found.append(
            Finding(
                f"noise floor, {quantity}",
                f"{quantity.capitalize()}: {floor.sentence[0].lower()}{floor.sentence[1:]}",
                False,
                {"rises": floor.rises, "effect": _ends(floor.effect), "placebo": _ends(floor.placebo)},
            )
        )
    if not found:
        raise InputError("--placebo needs intervals of the effect, and there are none")
    return [*found[:-1], replace(found[-1], sentence=f"{found[-1].sentence}{_unlike(result.law, law)}")]


def _placebo_comparisons(arguments: argparse.Namespace, utility: Utility) -> tuple[Law, dict[Any, Comparison]]:
    """Read the placebo with the columns of the table, and set up its ratios."""
    from fairaudit.audits.certify import certify
    from fairaudit.audits.reading import read_law
    from fairaudit.cli.options import column_roles
    from fairaudit.cli.source import progress, reading_of

    reading = replace(reading_of(arguments), truth=None, utility_column=None)
    if arguments.placebo_group:
        group, context = column_roles(arguments.placebo_group), column_roles(arguments.context)
        reading = replace(reading, group=group.names, bins={**group.edges, **context.edges})
    with progress() as report:
        law = read_law(arguments.placebo, reading, report=report)
    return law, dict(certify(law, utility, declared=utility_range(arguments.utility_range)).comparisons)


def _unlike(law: Law, placebo: Law) -> str:
    """What makes the noise of a placebo another one than that of the table: more or fewer groups, or other contexts."""
    from fairaudit.errors import shown

    sizes = {name: (len(getattr(placebo, f"{name}s")), len(getattr(law, f"{name}s"))) for name in ("group", "context")}
    said = [f"{theirs} {name}{'s' * (theirs != 1)} against {ours} of the table" for name, (theirs, ours) in sizes.items() if theirs != ours]
    why = "the greatest ratio of more of them is greater by chance alone"
    if not said and (apart := [", ".join(context) for context in law.contexts if context not in placebo.contexts]):
        said, why = [f"no context {shown(apart[0])}"], "chance may be another one there"
    return f" The placebo has {' and '.join(said)}: {why}." if said else ""


def _ends(interval: Interval) -> list[str]:
    from fairaudit.certificates.numbers import number

    return [number(interval.lower), number(interval.upper)]
