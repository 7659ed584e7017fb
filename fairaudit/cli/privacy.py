"""`fairaudit privacy`: what a filter guarantees, exactly."""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from decimal import Decimal
from fractions import Fraction
from math import inf
from typing import TYPE_CHECKING, Any

from fairaudit.cli import CORE
from fairaudit.cli.options import add_command
from fairaudit.cli.output import Answer, add_format
from fairaudit.cli.repeated_releases import add_utility, guarantee_sentence, guarantee_text, guaranteed, read_wanted

if TYPE_CHECKING:
    from fairaudit.model.mechanism import Mechanism
    from fairaudit.privacy.currencies import PureDP

DESCRIPTION = """\
Measure the privacy of a filter, a table of probabilities of releasing each output for each input: pure ε, the privacy profile δ(ε), the
trade-off curve, Rényi and zero-concentrated privacy, and the most distinguishable ordered pairs. Any two inputs are adjacent (local
privacy). The CSV file has one row per input and output (columns input…, output…, probability), or is a table with the inputs in its first
column and the outputs in its first row."""

EPILOG = """\
exit codes: 0 done; 1 the releases break a target; 2 bad input

examples:
  fairaudit privacy filter.csv
  fairaudit privacy filter.csv --delta-at 0.5,1 --releases 10
  fairaudit privacy filter.csv --releases 20 --tau 0.3 --max-ratio 3/2,2
  fairaudit privacy filter.csv --input name,age --output name_shown,age_shown --probability p --exp-epsilon 7/3"""

ORDERS = (2, 4, 16)
PAIRS = 5
VERTICES = 8
LONGEST = 60


def add(commands: Any) -> None:
    """Declare the options."""
    parser = add_command(commands, "privacy", run, CORE["privacy"], DESCRIPTION, EPILOG)
    parser.add_argument("mechanism", metavar="MECHANISM.csv", help="the filter")
    columns = parser.add_argument_group("columns, for one row per input and output (several: separate with commas, or repeat the option)")
    columns.add_argument("--input", metavar="COL", action="append", help="true value; by default the columns whose names start with input")
    columns.add_argument("--output", metavar="COL", action="append", help="released value; likewise output")
    columns.add_argument("--probability", metavar="COL", help="probability of the output for the input; by default probability")
    rest = parser.add_argument_group("what to report")
    where = rest.add_mutually_exclusive_group()
    where.add_argument(
        "--delta-at", metavar="EPS", action="append", help="report δ at these ε, in nats (δ is rounded up, by less than 1e-17)"
    )
    where.add_argument("--exp-epsilon", metavar="Q", action="append", help="report δ at these e^ε, such as 7/3 (δ is exact)")
    rest.add_argument("--releases", metavar="N", help="also report N releases of the same value with fresh randomness")
    add_utility(parser)
    add_format(rest)


def run(arguments: argparse.Namespace) -> Answer:
    """Do the work."""
    from fairaudit.cli.options import column_list
    from fairaudit.model.mechanism_file import read_mechanism_with_notes

    releases = _releases(arguments.releases)
    asked, wanted = _asked(arguments), read_wanted(arguments, releases)
    mechanism, notes = read_mechanism_with_notes(
        arguments.mechanism,
        input=column_list(arguments.input) or None,
        output=column_list(arguments.output) or None,
        probability=arguments.probability,
    )
    found = _measured(mechanism, asked, releases)
    verdict = "none"
    if wanted is not None:
        found["fairness"] = guaranteed(mechanism, wanted)
        verdicts = [target["verdict"] for target in found["fairness"]["targets"]]
        verdict = "exceeds" if "exceeds" in verdicts else "within" if verdicts else "none"
    return Answer(
        "privacy",
        verdict=verdict,
        sentence=" ".join([_about_filter(found), *([guarantee_sentence(found["fairness"])] if "fairness" in found else [])]),
        notes=notes,
        result=lambda: _stored(found),
        text=lambda: _text(found),
        code=int(verdict == "exceeds"),
    )


def _releases(text: str | None) -> int | None:
    from fairaudit.errors import InputError, shown

    if text is None:
        return None
    if not (text.isascii() and text.isdigit() and len(text) <= 6 and 1 <= int(text) <= 100_000):
        raise InputError(f"--releases {shown(text)} is not a whole number from 1 to 100000")
    return int(text)


def _asked(arguments: argparse.Namespace) -> list[tuple[str, str]]:
    """The ε or e^ε to report δ at, with which of the two each is."""
    from fairaudit.errors import InputError, shown
    from fairaudit.exact.rationals import parse_rational

    asked = []
    for kind, given, least in (("epsilon", arguments.delta_at, 0), ("exp_epsilon", arguments.exp_epsilon, 1)):
        option = "--delta-at" if kind == "epsilon" else "--exp-epsilon"
        for text in (part.strip() for group in given or [] for part in group.split(",")):
            try:
                top, bottom = parse_rational(text)
            except InputError as error:
                raise InputError(f"{option}: {error}") from None
            if top < least * bottom or (kind == "epsilon" and top > 10_000 * bottom):
                accepted = "numbers from 0 to 10,000" if kind == "epsilon" else "numbers of at least 1"
                raise InputError(f"{option}: {shown(text)} is out of range; {accepted} are accepted")
            asked.append((kind, text))
    return asked


def _measured(mechanism: Mechanism, asked: Sequence[tuple[str, str]], releases: int | None) -> dict[str, Any]:
    """Everything that is reported."""
    from fairaudit.privacy.composition import compose
    from fairaudit.privacy.epsilon_delta import pure_dp
    from fairaudit.privacy.pair_table import per_pair
    from fairaudit.privacy.renyi_divergences import renyi, zcdp
    from fairaudit.privacy.trade_offs import trade_off

    pure = pure_dp(mechanism)
    chosen = list(asked) or _default_epsilons(pure)
    curve = trade_off(mechanism)
    profile = curve.profile()
    found: dict[str, Any] = {
        "inputs": len(mechanism.inputs),
        "outputs": len(mechanism.outputs),
        "exp_epsilon": pure.exp_epsilon,
        "epsilon": pure.epsilon,
        "pair": list(pure.pair or ()),
        "attributes": [
            {
                "column": a.column,
                "exp_epsilon": a.exp_epsilon,
                "epsilon": a.epsilon,
                "pair": [list(label) for label in a.pair or ()],
            }
            for a in pure.attributes
        ],
        "delta": [_delta(kind, text, profile.delta) for kind, text in chosen],
        "trade_off": curve.vertices,
        "profile": profile.vertices,
        "renyi": [{"order": str(order), "epsilon": renyi(mechanism, order).epsilon} for order in ORDERS],
        "zcdp": {"rho": zcdp(mechanism).rho},
        "gdp": {"mu": curve.gdp().mu, "certified": False},
        "pairs": [
            {"first": list(p.first), "second": list(p.second), "exp_epsilon": p.exp_epsilon, "total_variation": p.delta}
            for p in per_pair(mechanism).top(PAIRS)
        ],
    }
    if releases is not None:
        together = compose(mechanism, releases)
        found["releases"] = {
            "number": releases,
            "exp_epsilon": together.exp_epsilon,
            "epsilon": together.epsilon,
            "exact": together.exact,
            "delta": [_delta(kind, text, together.delta) for kind, text in chosen],
        }
    return found


def _default_epsilons(pure: PureDP) -> list[tuple[str, str]]:
    """0 and a half of ε, rounded; where ε is infinite 0, 1 and 2."""
    if not isinstance(pure.exp_epsilon, Fraction):
        return [("epsilon", "0"), ("epsilon", "1"), ("epsilon", "2")]
    half = f"{float(pure.epsilon[0]) / 2:.3g}"
    return [("epsilon", "0"), *([("epsilon", half)] if float(half) else [])]


def _delta(kind: str, text: str, of: Any) -> dict[str, Any]:
    """δ at an ε, rounded up to 20 places, or at an e^ε, exactly."""
    from fairaudit.exact.enclosures import exp_enclosure
    from fairaudit.exact.rationals import parse_rational

    if kind == "exp_epsilon":
        return {"exp_epsilon": text, "delta": of(text)}
    top, bottom = parse_rational(text)
    if top == 0:
        return {"epsilon": text, "delta": of(1)}
    value: Fraction = of(max(Fraction(1), Fraction(exp_enclosure((top, bottom), 64)[0], 1 << 64)))
    scale = 10**20
    return {"epsilon": text, "delta": Fraction(-(-value.numerator * scale // value.denominator), scale), "rounded_up": True}


def _stored(value: Any) -> Any:
    """What JSON says: infinity is a word, and null stands for a rational of more than 90,000 digits."""
    from fairaudit.certificates.numbers import number
    from fairaudit.errors import InputError

    if isinstance(value, dict):
        return {key: _stored(entry) for key, entry in value.items()}
    if isinstance(value, (list, tuple)):
        return [_stored(entry) for entry in value]
    if isinstance(value, Fraction) or value == inf:
        try:
            return number(value)
        except InputError:
            return None
    return value


def _about_filter(found: dict[str, Any]) -> str:
    return (
        f"A filter with {found['inputs']} inputs and {found['outputs']} outputs; any two inputs are adjacent, ordered pairs are compared."
    )


def _text(found: dict[str, Any]) -> str:
    blocks = [
        _about_filter(found),
        _pure(found),
        _deltas(found["delta"], "δ, the least with (ε, δ)-differential privacy"),
    ]
    if "releases" in found:
        blocks.append(_together(found["releases"]))
    if "fairness" in found:
        blocks.append(guarantee_text(found["fairness"]))
    several = "Where no number of releases is named, the" if len(blocks) > 3 else "The"
    blocks += [_others(found), _curve(found["trade_off"]), _worst(found["pairs"])]
    blocks.append(
        f"What this does not say\n  {several} figures hold for one fresh release for each value, by a filter that draws with exactly these "
        "probabilities.\n  When two people's values are both randomized, both count: ε doubles."
    )
    return "\n\n".join(blocks)


def _pure(found: dict[str, Any]) -> str:
    from fairaudit.words import plain

    lines = [f"ε = {_log(found['epsilon'])}   e^ε = {_short(found['exp_epsilon'])}   (whole tuple)"]
    if not isinstance(found["exp_epsilon"], Fraction):
        lines = ["ε is infinite: an output has probability 0 for one input and not for another   (whole tuple)"]
    if found["pair"]:
        lines.append(f"  most distinguishable: {_name(found['pair'][0])} from {_name(found['pair'][1])}")
    if len(found["attributes"]) > 1:
        for attribute in found["attributes"]:
            name = plain(attribute["column"])
            lines.append(f"  when only {name} changes: ε = {_log(attribute['epsilon'])}, e^ε = {_short(attribute['exp_epsilon'])}")
    return "\n".join(lines)


def _deltas(entries: Sequence[dict[str, Any]], title: str, *, least: bool = True) -> str:
    lines = [title]
    for entry in entries:
        where = f"ε = {entry['epsilon']}" if "epsilon" in entry else f"e^ε = {entry['exp_epsilon']}"
        exact = "" if "rounded_up" in entry or not least else f"   exactly {_short(entry['delta'])}"
        lines.append(f"  {where:<12}  δ = {_about(entry['delta'])}{exact}")
    return "\n".join(lines)


def _together(found: dict[str, Any]) -> str:
    kind = "exact" if found["exact"] else "an upper bound"
    title = f"{found['number']} releases of the same value, fresh randomness each: ε = {_log(found['epsilon'])}; δ ({kind})"
    return _deltas(found["delta"], title, least=found["exact"])


def _others(found: dict[str, Any]) -> str:
    lines = ["Other measures"]
    lines += [f"  Rényi, order {entry['order']:<4}  ε = {_log(entry['epsilon'])}" for entry in found["renyi"]]
    low, high = found["zcdp"]["rho"]
    lines.append(f"  zCDP            ρ {'= infinite' if low.is_infinite() else f'between {_about(low)} and {_about(high)}'}")
    mu = found["gdp"]["mu"]
    lines.append(f"  GDP             μ {'= infinite' if mu == inf else f'about {mu:.4g} (floating point, not certified)'}")
    return "\n".join(lines)


def _curve(vertices: Sequence[tuple[Fraction, Fraction]]) -> str:
    lines = ["Trade-off curve: the least false-negative rate of any test at a false-positive rate (vertices)"]
    lines += [f"  {_about(alpha):>9}  {_about(beta):>9}   {_short(alpha)}, {_short(beta)}" for alpha, beta in vertices[:VERTICES]]
    if len(vertices) > VERTICES:
        lines.append(f"  … and {len(vertices) - VERTICES} more (--format json)")
    return "\n".join(lines)


def _worst(pairs: Sequence[dict[str, Any]]) -> str:
    def line(pair: dict[str, Any]) -> str:
        names = f"{_name(pair['first'])} from {_name(pair['second'])}"
        return f"  {_about(pair['exp_epsilon']):>9}  {_about(pair['total_variation']):>9}   {names}"

    title = "Most distinguishable ordered pairs: e^ε, total variation (one for each kind of pair)"
    return "\n".join([title, *map(line, pairs)])


def _name(parts: Sequence[str]) -> str:
    from fairaudit.words import plain

    return plain(", ".join(parts))


def _log(ends: Sequence[Decimal]) -> str:
    return _about(ends[1])


def _about(value: Fraction | Decimal | float) -> str:
    """Four significant digits."""
    from fairaudit.words import approximate

    return "infinite" if value == inf else approximate(Fraction(value))


def _short(value: Fraction | float) -> str:
    """Write an exact value, unless it is long."""
    from fairaudit.exact.rationals import integer_text

    if not isinstance(value, Fraction):
        return "infinite"
    digits = (value.numerator.bit_length() + value.denominator.bit_length()) * 3 // 10
    if digits > LONGEST:
        return f"(a fraction of about {digits} digits)"
    return integer_text(value.numerator) + (f"/{integer_text(value.denominator)}" if value.denominator > 1 else "")
