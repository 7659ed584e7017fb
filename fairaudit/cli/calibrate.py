"""`fairaudit calibrate`: which ε and which keep probability guarantee a target."""

from __future__ import annotations

import argparse
from typing import TYPE_CHECKING, Any

from fairaudit.cli import CORE
from fairaudit.cli.destinations import named_in, refuse_output
from fairaudit.cli.options import add_command, add_limit, given_limit, groups_option, limits_as_options
from fairaudit.cli.output import Answer, add_format, aligned

if TYPE_CHECKING:
    from fairaudit.filters.calibration import Calibration


DESCRIPTION = """\
Find the randomized response that tells the truth as often as possible and still guarantees a fairness target: for every policy
behind it, and every utility of a range (--groups) or the utility of an audit file; or for the policy of that file alone
(--bound policy). The answer names its scope."""


EPILOG = """\
exit codes: 0 found; 1 infeasible (the reason says what would be feasible); 2 bad input; 3 none was found, but none was ruled out

--bound says what is guaranteed, and to whom:
  exact           the greatest ratio behind the very filter (T13), of any policy: with AUDIT.toml for its utility, whatever it depends on,
                  else for every utility of the range that --gamma, --g-min and --lipschitz name; with --tau of any policy that keeps it
  policy          the ratio of this policy, that of AUDIT.toml, behind the filter; another policy may do worse
  sharp, tight, paper, contraction
                  for a filter of which epsilon and delta alone are known, and for comparison with the paper

examples:
  fairaudit calibrate --max-ratio 0.8 --groups 16 --tau 0.3
  fairaudit calibrate --max-ratio 5/4 --groups name=2,age=2,race=2 --tau 0.3 --split most-truth
  fairaudit calibrate --max-log 0.05,0.1,0.2,0.5 --groups 16 --tau 0.3 --plot calibration.png
  fairaudit calibrate --max-ratio 1.6 audit.toml
  fairaudit calibrate --max-ratio 1.6 --bound policy audit.toml"""


BOUNDS = ("exact", "sharp", "tight", "paper", "contraction", "policy")

NUMBERS = ("gamma", "tau", "g_min", "delta", "lipschitz", "diameter")


def add(commands: Any) -> None:
    """Declare the options."""
    parser = add_command(commands, "calibrate", run, CORE["calibrate"], DESCRIPTION, EPILOG)
    parser.add_argument(
        "audit",
        metavar="AUDIT.toml",
        nargs="?",
        help="groups, utility and population; its policy counts for --bound policy and contraction",
    )
    add_limit(parser, required=True, several=True)
    parser.add_argument(
        "--global", dest="overall", action="store_true", help="the limit is on the global ratio (needs independence, but for an audit file)"
    )
    parser.add_argument("--groups", metavar="K", help="number of groups, or name=2,age=5,… for attributes that are filtered independently")
    parser.add_argument("--bound", choices=BOUNDS, default=None, help="which guarantee, for whom (exact: any policy)")
    parser.add_argument("--split", choices=("equal-epsilon", "equal-keep", "most-truth"), default="equal-epsilon")
    numbers = parser.add_argument_group("what is known about the utility and the policy (exact numbers)")
    numbers.add_argument("--gamma", metavar="G", help="greatest utility (1)")
    numbers.add_argument("--tau", metavar="T", help="declared floor of every group's expected utility (0: none)")
    numbers.add_argument("--g-min", metavar="M", help="least utility (0)")
    numbers.add_argument("--delta", metavar="D", help="delta of the privacy asked for, for sharp, tight and paper (0)")
    numbers.add_argument("--lipschitz", metavar="L", help="L_A of the utility (0: it does not depend on the group)")
    numbers.add_argument("--diameter", metavar="D", help="diameter of the metric on groups (1)")
    numbers.add_argument("--raw-ratio", metavar="Q", help="the policy's own worst ratio without the filter, for --bound contraction")
    parser.add_argument("--plot", metavar="FILE", help="draw keep probability, epsilon and guarantee over the targets (PNG, SVG or PDF)")
    add_format(parser)


def run(arguments: argparse.Namespace) -> Answer:
    """Do the work."""
    from fairaudit.errors import InputError

    of_file = arguments.bound == "policy" or (arguments.audit is not None and arguments.bound in (None, "exact"))
    solve = _audit_solver(arguments) if of_file else _solver(arguments)
    try:
        found = [solve({"quantity": "global" if arguments.overall else "local", **limit}) for limit in given_limit(arguments)]
    except InputError as error:
        raise InputError(limits_as_options(str(error))) from None
    if arguments.plot is not None:
        refuse_output(arguments.plot, [arguments.audit] if arguments.audit else [], "the audit file")
        refuse_output(arguments.plot, named_in(arguments.audit or ""), "a file that the audit file names,")
        from fairaudit.plots import save_truth_kept

        save_truth_kept(found, arguments.plot)
    missed = [c for c in found if not c.feasible]
    return Answer(
        "calibrate",
        sentence=" ".join(f"{_headline(c)}." for c in found),
        result=lambda: {"found": [_entry(c) for c in found]},
        text=lambda: _table(found) if len(found) > 1 else _text(found[0], compared=not of_file),
        code=(1 if any(c.settled for c in missed) else 3) if missed else 0,
    )


def _solver(arguments: argparse.Namespace) -> Any:
    from fairaudit.errors import InputError
    from fairaudit.filters.calibration import calibrate
    from fairaudit.filters.responses import alphabets

    options: dict[str, Any] = {name: getattr(arguments, name) for name in NUMBERS if getattr(arguments, name) is not None}
    groups: Any = None if arguments.groups is None else groups_option(arguments.groups)
    raw = arguments.raw_ratio
    if arguments.audit is not None:
        if arguments.bound != "contraction":
            raise InputError(f"an audit file goes with --bound exact, policy or contraction, not {arguments.bound}")
        policy, utility, _ = _policy(arguments.audit)
        raw, groups = raw or _own_ratio(policy, utility), groups or alphabets(policy)
    if groups is None:
        raise InputError("--groups is missing; give the number of groups, or name=number for every attribute")
    return lambda target: calibrate(
        **target, groups=groups, bound=arguments.bound or "exact", split=arguments.split, raw_ratio=raw, **options
    )


def _audit_solver(arguments: argparse.Namespace) -> Any:
    """For the utility of an audit file: every policy, or its own."""
    from fairaudit.errors import InputError
    from fairaudit.filters.calibration_with_policy import calibrate_policy
    from fairaudit.filters.calibration_with_utility import calibrate_utility

    if arguments.audit is None:
        raise InputError("--bound policy needs an audit file with [policy] and [utility]")
    if arguments.groups is not None:
        raise InputError("--groups goes without an audit file; the policy has its own groups")
    for name in (*NUMBERS, "raw_ratio"):
        if getattr(arguments, name) is not None:
            raise InputError(
                f"--{name.replace('_', '-')} does not go with --bound exact or policy for an audit file, which read the utility "
                "itself; give --groups and constants without the file for every utility of a range"
            )
    policy, utility, population = _policy(arguments.audit)
    calibrated = calibrate_policy if arguments.bound == "policy" else calibrate_utility
    return lambda target: calibrated(policy, utility, **target, population=population, split=arguments.split)


def _policy(path: str) -> tuple[Any, Any, Any]:
    from fairaudit.audits.audit_file import read_policy

    return read_policy(path)


def _own_ratio(policy: Any, utility: Any) -> Any:
    from math import inf

    from fairaudit.measures.ratios import local_fairness

    table = utility.on(policy.law)
    found = local_fairness(table.law, table)
    return "inf" if found is None or found.ratio == inf else found.ratio


def _names(found: Calibration) -> tuple[str, ...]:
    columns = found.mechanism.columns if found.mechanism else ()
    return columns or ("",) * len(found.keep_probabilities)


def _kept(found: Calibration) -> str:
    return ", ".join(f"{name + ' ' if name else ''}{float(p):.6g}" for name, p in zip(_names(found), found.keep_probabilities, strict=True))


def _headline(found: Calibration, width: int = 0) -> str:
    from fairaudit.measures.limits import limit_text

    headline = "FOUND" if found.feasible else "INFEASIBLE" if found.settled else "NOT FOUND"
    goal = limit_text(found.quantity, "ratio", found.target)
    return f"{headline.ljust(width) if width else headline + ':'} {goal}, by the rule {found.rule}"


def _text(found: Calibration, *, compared: bool) -> str:
    from fairaudit.words import approximate, plain

    headline = _headline(found, 12)
    if not found.feasible:
        return f"{headline}\n\n{found.reason[0].upper()}{found.reason[1:]}."
    lines = [headline, ""]
    if found.reason:
        lines.append(f"{found.reason[0].upper()}{found.reason[1:]}.")
    else:
        low, _ = found.epsilon
        several = " of the whole tuple" if len(found.keep_probabilities) > 1 else ""
        lines.append(f"Keep the truth with probability   {plain(_kept(found))}")
        lines.append(f"epsilon{several}".ljust(34) + f"{float(low):.6g}   (e^ε = {approximate(found.exp_epsilon)})")
    if found.achieved is not None:
        lines.append(f"Guaranteed, exactly computed      R at most {approximate(found.achieved)}")
    lines.append(f"Scope                             {found.scope}")
    if compared and found.rule != "paper" and not found.reason:
        paper = ", ".join(f"{float(p):.6g}" for p in found.paper_keep_probabilities) or "finds no filter"
        lines.append(f"The paper's rule would keep       {paper}")
    if found.assumptions:
        lines += ["", "For you to judge", *(f"  - {plain(text)}" for text in found.assumptions)]
    lines += ["", "The exact keep probabilities are in --format json."]
    return "\n".join(lines)


def _table(found: list[Calibration]) -> str:
    from fairaudit.measures.limits import limit_cells
    from fairaudit.words import approximate

    rows = [("ratio at most", "least/greatest", "log", "epsilon", "keep probability", "guaranteed R", "paper keeps")]
    for c in found:
        if not c.feasible:
            rows.append((*limit_cells("ratio", c.target), "-", "infeasible" if c.settled else "not found", "-", "-"))
            continue
        low, _ = c.epsilon
        epsilon = "none needed" if low.is_infinite() else f"{float(low):.6g}"
        paper = ", ".join(f"{float(p):.4g}" for p in c.paper_keep_probabilities) or "-"
        rows.append((*limit_cells("ratio", c.target), epsilon, _kept(c), approximate(c.achieved or c.target), paper))
    scopes = {c.scope for c in found if c.feasible}
    return aligned(rows) + "".join(f"\n\nScope: {scope}" for scope in sorted(scopes))


def _entry(found: Calibration) -> dict[str, Any]:
    from fairaudit.certificates.numbers import number
    from fairaudit.measures.limits import limit_readings

    return {
        "quantity": found.quantity,
        "max_ratio": found.target,
        "readings": limit_readings("ratio", found.target),
        "rule": found.rule,
        "feasible": found.feasible,
        "settled": found.settled,
        "keep_probabilities": found.keep_probabilities,
        "attributes": _names(found),
        "exp_epsilon": number(found.exp_epsilon) if found.feasible else None,
        "epsilon": found.epsilon if found.feasible else None,
        "achieved_ratio": None if found.achieved is None else number(found.achieved),
        "scope": found.scope,
        "assumptions": found.assumptions,
        "paper_keep_probabilities": found.paper_keep_probabilities,
        "reason": found.reason,
    }
