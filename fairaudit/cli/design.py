"""`fairaudit design`: the filter that keeps most truth for a target."""

from __future__ import annotations

import argparse
from fractions import Fraction
from typing import TYPE_CHECKING, Any

from fairaudit.cli import CORE
from fairaudit.cli.destinations import named_in, refuse_output
from fairaudit.cli.options import add_command, add_limit, given_limit
from fairaudit.cli.output import Answer, add_format, aligned

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping, Sequence

    from fairaudit.filters.design_result import Design
    from fairaudit.model.mechanism import Mechanism
    from fairaudit.model.utility import UtilityTable

DESCRIPTION = """\
Find the filter of least expected distortion (the probability that a lie is released, or costs of your own) for a fairness target, a cap on
epsilon, or both: for the known policy of an audit file, for every policy behind the filter and the utility of that file (--bound exact), or
for every policy and every utility of a range (--groups; with a declared floor every policy that keeps it). With several attributes the
filter acts on them jointly. The answer names its scope."""

EPILOG = """\
exit codes: 0 found; 1 infeasible (the reason says why); 2 bad input

examples:
  fairaudit design audit.toml --max-ratio 0.8 -o filter.csv
  fairaudit design audit.toml --max-ratio 5/4 --max-epsilon 2 --distortion costs.csv -o filter.csv
  fairaudit design audit.toml --max-log 0.05,0.1,0.2,0.5 --plot frontier.png
  fairaudit design audit.toml --max-ratio 5/4 --bound exact
  fairaudit design --groups 16 --max-ratio 0.8 --tau 0.3
  fairaudit design --groups 16 --max-ratio 5/4 --g-min 0.1
  fairaudit privacy filter.csv

The file written is a table of exact fractions that fairaudit privacy reads, and AUDIT.toml with [filter.group] kind = "table". The file of
costs has one row per pair: columns input…, output…, distortion; rows for a release of the truth may be left out and cost nothing."""

BOUNDS = ("policy", "exact")

SHOWN_GROUPS = 8


def add(commands: Any) -> None:
    """Declare the options."""
    parser = add_command(commands, "design", run, CORE["design"], DESCRIPTION, EPILOG)
    parser.add_argument(
        "audit", metavar="AUDIT.toml", nargs="?", help="policy, utility and population; its filters and targets are passed over"
    )
    add_limit(parser, several=True)
    cap = parser.add_mutually_exclusive_group()
    cap.add_argument("--max-epsilon", metavar="E", help="cap on epsilon of the whole filter, in nats")
    cap.add_argument("--max-exp-epsilon", metavar="Q", help="the same as e^ε, such as 7/3")
    parser.add_argument("--distortion", metavar="FILE.csv", help="what each release costs (1 for a lie)")
    parser.add_argument(
        "--bound", choices=BOUNDS, help="whom to guard: this policy, that of the audit file (policy, its default), or any policy (exact)"
    )
    parser.add_argument("--global", dest="overall", action="store_true", help="the limit is on the global ratio (with --bound exact)")
    free = parser.add_argument_group("for every policy and every utility of a range, instead of the utility of an audit file")
    free.add_argument("--groups", metavar="K", help="number of groups, or name=2,age=5,… for joint attributes; without an audit file")
    free.add_argument("--tau", metavar="T", help="declared floor of every group's expected utility behind the filter (0: none)")
    free.add_argument("--gamma", metavar="G", help="greatest utility (1, or that of the audit file)")
    free.add_argument("--g-min", metavar="M", help="least utility, which every policy pays (0)")
    free.add_argument("--lipschitz", metavar="K", help="most by which utility differs between groups for the same decision and context (0)")
    parser.add_argument("-o", "--output", metavar="FILE.csv", help="write the filter here")
    parser.add_argument("--plot", metavar="FILE", help="draw the truth kept over the targets (PNG, SVG or PDF)")
    add_format(parser)


def run(arguments: argparse.Namespace) -> Answer:
    """Do the work."""
    from fairaudit.errors import InputError

    given = given_limit(arguments)
    targets = given or [{}]
    if len(targets) > 1 and arguments.output is not None:
        raise InputError("-o writes one filter; give one target")
    if arguments.plot is not None and not given:
        raise InputError("--plot draws over targets; give at least one")
    named = named_in(arguments.audit or "")
    for path in (arguments.output, arguments.plot):
        if path is not None:
            refuse_output(path, [arguments.audit] if arguments.audit is not None else [], "the audit file")
            refuse_output(path, named, "a file that the audit file names,")
            refuse_output(path, [arguments.distortion] if arguments.distortion is not None else [], "the file of costs")
    solve = _solver(arguments)
    found = []
    for target in targets:
        try:
            found.append(solve(target))
        except InputError as error:
            raise InputError(_as_options(str(error))) from None
    if arguments.plot is not None:
        from fairaudit.plots import save_truth_kept

        save_truth_kept(found, arguments.plot)
    if arguments.output is not None and found[0].mechanism is not None:
        write_filter(found[0].mechanism, arguments.output)
    return Answer(
        "design",
        sentence=" ".join(f"{_headline(d)}." for d in found),
        result=lambda: {"found": [_entry(d) for d in found]},
        text=lambda: _table(found) if len(found) > 1 else _text(found[0], arguments.output),
        code=0 if all(d.feasible for d in found) else 1,
    )


def write_filter(mechanism: Mechanism, path: str) -> None:
    """Write a filter as a text file of exact fractions, whole or not at all.

    A filter of one column is a table whose corner names the column, where that cannot be mistaken; one of several columns has one row per
    input and output, without those of probability 0.

    Raises
    ------
    InputError
        If the file cannot be written, or the labels do not survive in a text file.
    """
    from pathlib import Path

    from fairaudit.certificates.numbers import number
    from fairaudit.files import csv_text, write_atomically

    def cell(value: int) -> str:
        return number(Fraction(value, mechanism.denominator))

    if mechanism.width == 1:
        released = [label[0] for label in mechanism.outputs]
        corner = mechanism.columns[0] if mechanism.columns else ""
        header = ["" if corner in released or corner.lower().startswith("input") else corner, *released]
        rows = [[label[0], *map(cell, mechanism.row(label))] for label in mechanism.inputs]
    else:
        columns = mechanism.columns or tuple(str(i + 1) for i in range(mechanism.width))
        header = [*(f"input_{c}" for c in columns), *(f"output_{c}" for c in columns), "probability"]
        rows = [
            [*label, *output, cell(v)]
            for label in mechanism.inputs
            for output, v in zip(mechanism.outputs, mechanism.row(label), strict=True)
            if v
        ]
    write_atomically(Path(path), [csv_text([header, *rows]).encode("utf-8")])
    _read_back(mechanism, path)


def _read_back(mechanism: Mechanism, path: str) -> None:
    """Refuse a file that reads back as another filter than was written."""
    from fairaudit.errors import InputError
    from fairaudit.model.mechanism_file import read_mechanism

    try:
        again = read_mechanism(path)
        same = all(
            again.probability(label, output) * mechanism.denominator == v
            for label in mechanism.inputs
            for output, v in zip(mechanism.outputs, mechanism.row(label), strict=True)
            if v
        )
    except InputError as error:
        raise InputError(f"the filter was written but cannot be read back, because of its labels: {error}") from None
    if not same:
        raise InputError(f"{path}: the filter was written but reads back differently, because of its labels; rename them")


def _solver(arguments: argparse.Namespace) -> Callable[[Mapping[str, Any]], Design]:
    from fairaudit.audits.audit_file import read_policy
    from fairaudit.cli.options import groups_option
    from fairaudit.errors import InputError
    from fairaudit.filters.model_free import design_model_free
    from fairaudit.filters.with_policy import design
    from fairaudit.filters.with_utility import design_utility

    options: dict[str, Any] = {"max_epsilon": arguments.max_epsilon, "max_exp_epsilon": arguments.max_exp_epsilon}
    constants = {name: getattr(arguments, name) for name in ("tau", "gamma", "g_min", "lipschitz")}
    if arguments.overall and (arguments.audit is None or arguments.bound != "exact"):
        raise InputError("--global goes with an audit file and --bound exact")
    if arguments.audit is None:
        if arguments.bound == "policy":
            raise InputError("--bound policy needs an audit file with [policy] and [utility]")
        if arguments.groups is None:
            raise InputError("neither an audit file nor --groups was given; name the file of a policy, or give the number of groups")
        groups: Any = groups_option(arguments.groups)
        width = len(groups) if isinstance(groups, dict) else 1
        options["distortion"] = _costs(arguments.distortion, width)
        options.update({name: value for name, value in constants.items() if value is not None})
        return lambda target: design_model_free(groups, **target, **options)
    if arguments.groups is not None:
        raise InputError("--groups goes without an audit file; the policy has its own groups")
    ranged = [name for name in ("tau", "g_min", "lipschitz") if constants[name] is not None]
    if ranged and (arguments.bound == "policy" or arguments.overall):
        kept = "--global" if arguments.overall else "--bound policy"
        raise InputError(f"--{ranged[0].replace('_', '-')} does not go with {kept}: it asks for every utility of a range, locally")
    if arguments.gamma is not None and not ranged:
        raise InputError("--gamma goes with --tau, --g-min or --lipschitz; the utility of the audit file needs none of them")
    policy, utility, population = read_policy(arguments.audit)
    columns = policy.law.columns.group
    options["distortion"] = _costs(arguments.distortion, len(columns))
    if not ranged:
        options["population"] = population
        if arguments.bound == "exact":
            options["quantity"] = "global" if arguments.overall else "local"
            return lambda target: design_utility(policy, utility, **target, **options)
        return lambda target: design(policy, utility, **target, **options)
    table = utility.on(policy.law)
    if table.depends_on_group and arguments.lipschitz is None:
        raise InputError(
            "--tau and --g-min ask for a guarantee for every utility of a range, and this one depends on the group; say by how much with "
            "--lipschitz, or leave them out and use --bound exact"
        )
    given = {name: value for name, value in constants.items() if value is not None}
    _refuse_contradictions(given, table)
    return _free(policy, population, {"gamma": table.gamma, **given, **options})


def _refuse_contradictions(given: Mapping[str, str], table: UtilityTable) -> None:
    """Refuse a range in which the utility of the audit file is not."""
    from fairaudit.errors import InputError
    from fairaudit.exact.rationals import at_least
    from fairaudit.words import approximate

    numbers = {name: at_least(name, value, 0) for name, value in given.items()}
    least, greatest, gap = numbers.get("g_min", table.m), numbers.get("gamma", table.gamma), numbers.get("lipschitz", table.lipschitz())
    for name, wrong, own in (
        ("g_min", least > table.m, table.m),
        ("gamma", greatest < table.gamma, table.gamma),
        ("lipschitz", gap < table.lipschitz(), table.lipschitz()),
    ):
        if wrong:
            option = f"--{name.replace('_', '-')}"
            raise InputError(
                f"{option} is {given[name]}, but the utility of the audit file has {approximate(own)}; a range around it is accepted"
            )


def _free(policy: Any, population: Any, options: Mapping[str, Any]) -> Callable[[Mapping[str, Any]], Design]:
    """A design without the policy, for its groups and their frequencies."""
    from dataclasses import replace

    from fairaudit.filters.model_free import design_model_free
    from fairaudit.model.mechanism import Identity

    law = policy.law
    mass = policy.behind(group=Identity(law.groups), population=population).mass
    count = len(law.groups)
    weights = [1] * count if mass is None else [sum(mass[i::count]) for i in range(count)]

    def solve(target: Mapping[str, Any]) -> Design:
        found = design_model_free(law.groups, population=weights, **target, **options)
        return found if found.mechanism is None else replace(found, mechanism=replace(found.mechanism, columns=law.columns.group))

    return solve


def _costs(path: str | None, width: int) -> dict[Any, Any] | None:
    """Read a file of costs: columns input…, output…, distortion."""
    from fairaudit.errors import InputError
    from fairaudit.tables.csv import read_csv

    if path is None:
        return None
    table = read_csv(path)
    sides = [[c for c in table.columns if c.strip().lower().startswith(word)] for word in ("input", "output")]
    for word, side in zip(("input", "output"), sides, strict=True):
        if len(side) != width:
            raise InputError(f"{path}: {len(side)} columns have names that start with {word}; the groups have {width}")
    if "distortion" not in table.columns:
        raise InputError(f"{path}: there is no column 'distortion'; the columns input…, output…, distortion are needed")
    table = table.with_numbers(["distortion"])
    costs: dict[Any, Any] = {}
    for i in range(len(table)):
        pair = (tuple(table[c][i] for c in sides[0]), tuple(table[c][i] for c in sides[1]))
        if pair in costs:
            raise InputError(f"{path}, {table.locate(i)}: the pair occurs a second time; each pair has one row")
        costs[pair] = table["distortion"][i]
    return costs


def _as_options(message: str) -> str:
    """Name options instead of arguments."""
    for name in ("max_ratio", "max_log", "max_exp_epsilon", "max_epsilon", "tau", "gamma", "g_min", "lipschitz"):
        option = "--" + name.replace("_", "-")
        for ending in (" is ", ":"):
            if message.startswith(name + ending):
                return option + message[len(name) :]
    return message


def _goal(found: Design) -> str:
    from fairaudit.measures.limits import limit_text
    from fairaudit.words import approximate

    parts = [] if found.target is None else [limit_text(found.quantity, "ratio", found.target)]
    parts += [] if found.max_exp_epsilon is None else [f"e^ε at most {approximate(found.max_exp_epsilon)}"]
    return " and ".join(parts)


def _headline(found: Design, width: int = 0) -> str:
    headline = "INFEASIBLE" if found.mechanism is None else "FOUND"
    return f"{headline.ljust(width) if width else headline + ':'} {_goal(found)}"


def _text(found: Design, written: str | None) -> str:
    from fairaudit.words import approximate, plain

    if found.mechanism is None or found.distortion is None or found.truth_kept is None:
        return f"{_headline(found, 12)}\n\n{found.reason[:1].upper()}{found.reason[1:]}."
    low, _ = found.epsilon
    epsilon = "infinite" if low.is_infinite() else f"{float(low):.6g}   (e^ε = {approximate(found.exp_epsilon)})"
    lines = [_headline(found, 12), ""]
    lines.append(f"Truth kept             {_percent(found.truth_kept)}")
    lines.append(f"Expected distortion    {approximate(found.distortion)}")
    if found.response_distortion is not None and found.response_truth_kept is not None:
        kept = f"{_percent(found.response_truth_kept)} kept, distortion {approximate(found.response_distortion)}"
        lines.append(f"Randomized response    {kept}")
    if found.lower_bound is not None:
        lines.append(f"No filter distorts less than {approximate(found.lower_bound)} (proved exactly)")
    if found.achieved is not None:
        lines.append(f"Ratio R, exact         {approximate(found.achieved)}")
    lines += [f"epsilon                {epsilon}", f"Found by               {found.method}", f"Scope                  {found.scope}"]
    if found.reason:
        lines.append(f"Note                   {found.reason}")
    if found.assumptions:
        lines += ["", "For you to judge", *(f"  - {plain(text)}" for text in found.assumptions)]
    lines += ["", _filter(found.mechanism)]
    if written is not None:
        lines += ["", f"Filter: {plain(written)}", f"Measure it: fairaudit privacy {plain(written)}"]
    return "\n".join(lines)


def _filter(mechanism: Mechanism) -> str:
    """The table, if it is small."""
    from fairaudit.words import plain

    size = len(mechanism.inputs)
    if size > SHOWN_GROUPS:
        return f"The filter has {size} inputs and outputs; its exact probabilities are in the file that -o writes, and in --format json."
    rows = [["released for", *(plain(", ".join(label)) for label in mechanism.outputs)]]
    rows += [[plain(", ".join(a)), *(f"{v / mechanism.denominator:.6f}" for v in mechanism.row(a))] for a in mechanism.inputs]
    return aligned(rows) + "\nThe exact probabilities are in the file that -o writes, and in --format json."


def _table(found: Sequence[Design]) -> str:
    from fairaudit.measures.limits import limit_cells
    from fairaudit.words import approximate

    rows = [["ratio at most", "least/greatest", "log", "truth kept", "distortion", "randomized response keeps", "R, exact", "epsilon"]]
    for d in found:
        target = ("none", "-", "-") if d.target is None else limit_cells("ratio", d.target)
        if d.distortion is None or d.truth_kept is None:
            rows.append([*target, "infeasible", "-", "-", "-", "-"])
            continue
        low, _ = d.epsilon
        response = "-" if d.response_truth_kept is None else _percent(d.response_truth_kept)
        achieved = "-" if d.achieved is None else approximate(d.achieved)
        epsilon = "infinite" if low.is_infinite() else f"{float(low):.6g}"
        rows.append([*target, _percent(d.truth_kept), approximate(d.distortion), response, achieved, epsilon])
    said = [f"Scope: {scope}" for scope in sorted({d.scope for d in found if d.feasible})]
    said += sorted({f"Infeasible: {d.reason}" for d in found if not d.feasible})
    return "\n\n".join([aligned(rows), *said])


def _percent(value: Fraction) -> str:
    return f"{float(value):.4%}"


def _entry(found: Design) -> dict[str, Any]:
    from fairaudit.certificates.numbers import number
    from fairaudit.measures.limits import limit_readings

    def exact(value: Fraction | float | None) -> str | None:
        return None if value is None else number(value)

    return {
        "quantity": found.quantity,
        "max_ratio": exact(found.target),
        "readings": None if found.target is None else limit_readings("ratio", found.target),
        "max_exp_epsilon": exact(found.max_exp_epsilon),
        "feasible": found.feasible,
        "truth_kept": exact(found.truth_kept),
        "distortion": exact(found.distortion),
        "lower_bound": exact(found.lower_bound),
        "achieved_ratio": exact(found.achieved),
        "exp_epsilon": exact(found.exp_epsilon) if found.feasible else None,
        "epsilon": found.epsilon if found.feasible else None,
        "multipliers": [number(k) for k in found.multipliers],
        "randomized_response": {"truth_kept": exact(found.response_truth_kept), "distortion": exact(found.response_distortion)},
        "method": found.method,
        "scope": found.scope,
        "assumptions": found.assumptions,
        "reason": found.reason,
        "mechanism": None if found.mechanism is None else _probabilities(found.mechanism),
    }


def _probabilities(mechanism: Mechanism) -> dict[str, Any]:
    return {
        "columns": mechanism.columns,
        "labels": mechanism.inputs,
        "rows": [[Fraction(v, mechanism.denominator) for v in mechanism.row(label)] for label in mechanism.inputs],
    }
