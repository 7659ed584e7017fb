"""The figures of the experiments, with intervals and bounds drawn in. Needs the extra ``plots``."""

from __future__ import annotations

import io
from collections.abc import Sequence
from fractions import Fraction
from math import inf, isfinite, log
from pathlib import Path
from typing import TYPE_CHECKING

from fairaudit.errors import InputError
from fairaudit.files import write_atomically
from fairaudit.inference.cells import Cell
from fairaudit.inference.ends import cell_ends
from fairaudit.plugins.vlm.analyse import Finding, Table, logarithm
from fairaudit.plugins.vlm.experiment import Experiment, Setting
from fairaudit.plugins.vlm.report import Found

if TYPE_CHECKING:
    from matplotlib.axes import Axes

__all__ = ["draw"]

COLOURS = ("#0072b2", "#d55e00", "#009e73", "#cc79a7", "#e69f00", "#56b4e9")
QUESTIONS = {"slot": "slot 1, by who stands there", "person": "a person, in any slot", "position": "the slot, whoever stands there"}
LEVEL = Fraction(95, 100)
NOTE = "Bands are intervals at the confidence of the certificates (with a target, of each end); each holds for its point, not for all."


def draw(experiment: Experiment, found: Found, path: Path) -> Path:
    """Draw the figure of an experiment: choices if nothing is filtered, else fairness over privacy.

    Parameters
    ----------
    experiment : Experiment
        The experiment.
    found : Found
        What was certified.
    path : Path
        A PNG file.

    Returns
    -------
    Path
        The file.

    Raises
    ------
    InputError
        If matplotlib is missing, or the file cannot be written.
    """
    try:
        from matplotlib.backends.backend_agg import FigureCanvasAgg
        from matplotlib.figure import Figure
    except ImportError:
        raise InputError("pictures need matplotlib; install the extra: pip install 'fairaudit-certify[plots]'") from None
    swept = len(experiment.settings) > 1
    asked = list(dict.fromkeys(finding.question for _, _, finding in found.findings))
    shown = [q for q in asked if q != "position"] if swept else asked
    figure = Figure(figsize=(6.2 * len(shown), 4.8) if swept else (12.4, 4.8), layout="constrained")
    FigureCanvasAgg(figure)
    figure.suptitle(_words(experiment.title))
    models = list(dict.fromkeys(model for model, _, _ in found.findings))
    if swept:
        panels = figure.subplots(1, len(shown), squeeze=False)[0]
        for axes, question in zip(panels, shown, strict=True):
            _sweep(axes, experiment, found, question, models)
        handles, labels = panels[0].get_legend_handles_labels()
        figure.legend(handles, labels, fontsize=8, loc="outside lower center", ncols=3, title=NOTE, title_fontsize=7)
    else:
        left, right = figure.subplots(1, 2)
        _choices(left, experiment, found, models)
        _effects(right, found, models, shown)
        figure.supxlabel(f"{experiment.trials} answers per cell", fontsize=8)
    picture = io.BytesIO()
    figure.savefig(picture, format="png", dpi=120)
    write_atomically(path, [picture.getvalue()])
    return path


def _choices(axes: Axes, experiment: Experiment, found: Found, models: Sequence[str]) -> None:
    """Chance of each person to be chosen in each context, over both orders, with exact binomial intervals."""
    tables = {model: table for model, table, _ in found.findings}
    people = list(experiment.people)
    step = 0.8 / (len(models) * len(people))
    for m, model in enumerate(models):
        for k, person in enumerate(people):
            at = [i - 0.4 + (m * len(people) + k + 0.5) * step for i in range(len(experiment.contexts))]
            ends = [_chance(experiment, tables[model], context, person) for context in experiment.contexts]
            middles = [middle for _, middle, _ in ends]
            colour = COLOURS[m % len(COLOURS)]
            axes.bar(
                at,
                middles,
                step * 0.92,
                color=colour,
                alpha=(0.85, 0.4)[k % 2],
                label=f"{_words(person)}, {_words(_short(model))}",
                edgecolor=colour,
            )
            if tables[model].sampled:
                low = [middle - lower for lower, middle, _ in ends]
                high = [upper - middle for _, middle, upper in ends]
                axes.errorbar(at, middles, yerr=[low, high], fmt="none", ecolor="black", capsize=3, linewidth=1)
    axes.axhline(1 / len(people), color="grey", linestyle=":", linewidth=1)
    axes.set_xticks(range(len(experiment.contexts)), [_words(context) for context in experiment.contexts])
    axes.set_ylim(0, 1.18)
    axes.set_ylabel("share of answers that choose the person")
    axes.legend(fontsize=8, loc="upper center", ncols=max(1, len(models)))
    orders = "both orders" if experiment.order == "both" else "fixed order"
    axes.set_title(f"Who is chosen ({orders}; 95 % intervals for each bar)", fontsize=10)


def _chance(experiment: Experiment, table: Table, context: str, person: str) -> tuple[float, float, float]:
    total, count = Fraction(0), Fraction(0)
    for order in experiment.orders:
        row = table.rows.get((context, experiment.slots(order)), {})
        total += sum(row.values(), Fraction(0))
        count += row.get(experiment.options[order.index(person)], Fraction(0))
    if not total:
        return 0.0, 0.0, 0.0
    share = float(count / total)
    if not table.sampled:
        return share, share, share
    # The draws of the two orders have different means. Chernoff's bound, which `binary=False` asks for, holds for their average all the
    # same: the logarithm of 1 − μ + μe^t is concave in μ.
    lower, upper = cell_ends(Cell(int(total), count, None, Fraction(0), Fraction(1), binary=False), (1 - LEVEL) / 2)
    return float(lower), share, float(upper)


def _effects(axes: Axes, found: Found, models: Sequence[str], shown: Sequence[str]) -> None:
    """L of each question, local and global, with its interval."""
    offset = 0.0
    drawn: set[str] = set()
    for model, _, finding in found.findings:
        base = shown.index(finding.question)
        m = models.index(model)
        for quantity, marker, shift in (("local", "o", -0.12), ("global", "s", 0.12)):
            if quantity not in finding.meanings:
                continue
            at = base + shift + (m - (len(models) - 1) / 2) * 0.3 / max(1, len(models) - 1) + offset
            low, high = (logarithm(v) for v in finding.interval.get(quantity, finding.meanings[quantity]))
            middle = logarithm(finding.meanings[quantity][1])
            label = f"{'L, worst context' if quantity == 'local' else 'L̄, over contexts'}, {_words(_short(model))}"
            colour = COLOURS[m % len(COLOURS)]
            axes.plot([at], [min(middle, 6.0)], marker=marker, color=colour, label=None if label in drawn else label, linestyle="none")
            axes.plot([at, at], [low, min(high, 6.0)], color=colour, linewidth=1.6)
            drawn.add(label)
    axes.set_xticks(range(len(shown)), [QUESTIONS[q] for q in shown], fontsize=8)
    axes.set_xlim(-0.5, len(shown) - 0.5)
    axes.set_ylim(bottom=0)
    axes.set_ylabel("L (nats)")
    axes.legend(fontsize=8)
    axes.set_title("Profile and position effects, with intervals", fontsize=10)


def _sweep(axes: Axes, experiment: Experiment, found: Found, question: str, models: Sequence[str]) -> None:
    """L over ε, with bands, and the bound that holds for every model."""
    by_context = len({s.keep for s in experiment.settings}) == 1
    order = sorted(range(len(experiment.settings)), key=lambda i: _epsilon(experiment, experiment.settings[i], by_context, found, question))
    epsilons = [_epsilon(experiment, experiment.settings[i], by_context, found, question) for i in order]
    finite = [e for e in epsilons if isfinite(e)]
    beyond = (max(finite, default=1.0) or 1.0) * 1.15
    xs = [e if isfinite(e) else beyond for e in epsilons]
    top = 0.2
    for m, model in enumerate(models):
        findings = [
            next(f for n, _, f in found.findings if n == model and f.question == question and f.setting == experiment.settings[i])
            for i in order
        ]
        colour = COLOURS[m % len(COLOURS)]
        for quantity, style, marker in (("local", "-", "o"), ("global", ":", "s")):
            values = [logarithm(f.meanings[quantity][1]) for f in findings]
            name = "L" if quantity == "local" else "L̄"
            axes.plot(xs, values, linestyle=style, marker=marker, markersize=4, color=colour, label=f"{name}, {_words(_short(model))}")
            top = max([top, *(v for v in values if isfinite(v))])
        if all("local" in f.interval for f in findings):
            ends = [tuple(map(logarithm, f.interval["local"])) for f in findings]
            highest = [min(high, 1e3) for _, high in ends]
            axes.fill_between(
                xs,
                [low for low, _ in ends],
                highest,
                color=colour,
                alpha=0.16,
                linewidth=0,
                label=f"interval of L, {_words(_short(model))}",
            )
            top = max(top, sorted(highest)[len(highest) // 2])
        named = ("T8",) if by_context else ("T3", "T12")
        own = [min((logarithm(v) for n, v in f.bounds.items() if n in named), default=inf) for f in findings]
        if any(isfinite(v) for v in own):
            axes.plot(
                xs,
                own,
                linestyle="-.",
                linewidth=1,
                color=colour,
                label=f"{'T8' if by_context else 'least of T3, T12'}, these answers of {_words(_short(model))}",
            )
    first = [_first(found, question, experiment.settings[i]) for i in order]
    bounds = [min(logarithm(min(f.exp_epsilon, f.bounds.get("T4", inf))), 1e3) for f in first]
    floor = any("T4" in f.bounds for f in first)
    if any(v < 1e3 for v in bounds):
        axes.plot(
            xs,
            bounds,
            color="black",
            linestyle="--",
            linewidth=1.2,
            label="every model: T4, as g has a floor" if floor else "every model: ε (T2; of a person T10)",
        )
    axes.set_ylim(-0.03 * top, 1.35 * top)
    axes.set_xlabel("ε of the context (nats)" if by_context else "ε of both profiles, all attributes together (nats)")
    axes.set_ylabel("L (nats)")
    if not all(map(isfinite, epsilons)):
        axes.axvline((max(finite, default=1.0) + beyond) / 2, color="grey", linewidth=0.6, linestyle=":")
    _ticks(axes, experiment, order, xs, epsilons, by_context)
    axes.set_title(f"{_words(experiment.utility_name).capitalize()}: {QUESTIONS[question]}", fontsize=10)


def _ticks(
    axes: Axes, experiment: Experiment, order: Sequence[int], xs: Sequence[float], epsilons: Sequence[float], by_context: bool
) -> None:
    """Ticks of ε below, and above it the paper's axis, the odds p/(1−p) of one attribute."""
    marked = [(x, e) for x, e in zip(xs, epsilons, strict=True)]
    kept: list[int] = []
    width = (max(xs) - min(xs)) or 1.0
    for place in range(len(marked)):
        if not kept or marked[place][0] - marked[kept[-1]][0] > 0.07 * width:
            kept.append(place)
    axes.set_xticks([xs[i] for i in kept], ["∞" if epsilons[i] == inf else f"{epsilons[i]:.3g}" for i in kept], fontsize=8)
    second = axes.secondary_xaxis("top")
    keeps = [experiment.settings[i].context_keep if by_context else experiment.settings[i].keep for i in order]
    odds = ["∞" if keeps[i] == 1 else f"{float(keeps[i] / (1 - keeps[i])):.3g}" for i in kept]
    second.set_xticks([xs[i] for i in kept], odds, fontsize=8)
    second.set_xlabel("odds p/(1−p) of the truth" + ("" if by_context else ", one attribute"), fontsize=8)


def _epsilon(experiment: Experiment, setting: Setting, by_context: bool, found: Found, question: str) -> float:
    if not by_context:
        return logarithm(_first(found, question, setting).exp_epsilon)
    lie = (1 - setting.context_keep) / (len(experiment.contexts) - 1) if len(experiment.contexts) > 1 else Fraction(0)
    return abs(log(setting.context_keep / lie)) if lie and setting.context_keep else inf


def _first(found: Found, question: str, setting: Setting) -> Finding:
    return next(f for _, _, f in found.findings if f.question == question and f.setting == setting)


def _short(model: str) -> str:
    return model.partition(" at ")[0].partition(" (")[0]


def _words(text: str) -> str:
    """A label as text: no mathematical markup, nothing that steers."""
    return "".join(c if c.isprintable() else " " for c in text).replace("$", r"\$")[:80]
