"""The figures of the experiments, with intervals and bounds drawn in. Needs the extra ``plots``."""

from __future__ import annotations

import io
from collections.abc import Sequence
from fractions import Fraction
from itertools import zip_longest
from math import inf, isfinite, log, sqrt
from pathlib import Path
from typing import TYPE_CHECKING

import fairaudit as fa
from fairaudit.errors import InputError
from fairaudit.files import write_atomically
from fairaudit.libraries import library
from fairaudit.plugins.vlm.analyse import Finding, Table, logarithm
from fairaudit.plugins.vlm.experiment import Experiment, Setting
from fairaudit.plugins.vlm.report import Found, ceiling, worsened
from fairaudit.words import noun

if TYPE_CHECKING:
    from matplotlib.axes import Axes

__all__ = ["check_picture", "draw"]

COLOURS = ("#0072b2", "#d55e00", "#009e73", "#cc79a7", "#e69f00", "#56b4e9")
QUESTIONS = {"slot": "slot 1, by who stands there", "person": "a person, in any slot", "position": "the slot, whoever stands there"}
LEVEL = 0.95
NOTE = "Bands and lines are intervals at the confidence of the certificates (with a target, of each end), each for its point, not for all."
RATIOS = (1.1, 1.25, 1.5, 2, 3, 4, 6, 10, 20, 50, 100, 1_000)


def check_picture(path: Path) -> Path:
    """Refuse a path where no picture can be, before the work is done."""
    if path.suffix.lower() not in (".png", ".svg", ".pdf"):
        raise InputError(f"{path}: a picture ends in .png, .svg or .pdf")
    if path.is_dir() or not path.parent.is_dir():
        raise InputError(f"{path} cannot be written: {'it is a folder' if path.is_dir() else f'there is no folder {path.parent}'}")
    return path


def draw(experiment: Experiment, found: Found, path: Path) -> Path:
    """Draw the figure of an experiment, a PNG, SVG or PDF file: choices if nothing is filtered, else fairness over privacy."""
    swept = len(experiment.settings) > 1
    asked = list(dict.fromkeys(finding.question for _, _, finding in found.findings))
    shown = [q for q in asked if q != "position"] if swept else asked
    models = list(dict.fromkeys(model for model, _, _ in found.findings))
    slices = _slices(experiment)
    size = (7 * len(shown), 4.4 * len(slices) + 0.3 * len(models)) if swept else (9.2, 4.4)
    figure = library("matplotlib.figure", "plots").Figure(figsize=size, layout="constrained")
    figure.suptitle(_words(experiment.title))
    if swept:
        panels = figure.subplots(len(slices), len(shown), squeeze=False)
        for row, settings in zip(panels, slices, strict=True):
            for axes, question in zip(row, shown, strict=True):
                _sweep(axes, experiment, found, question, models, settings)
        named = {label: handle for axes in panels.flat for handle, label in zip(*axes.get_legend_handles_labels(), strict=True)}
        columns = [[label for label in named if label.endswith(f", {_words(_short(model))}")] for model in models]
        columns.append([label for label in named if not any(label in column for column in columns)])
        named[""] = library("matplotlib.lines", "plots").Line2D([], [], linestyle="none")
        entries = [(named[label], label) for column in zip(*zip_longest(*columns, fillvalue=""), strict=True) for label in column]
        place = {"fontsize": 7.5, "loc": "outside lower center", "ncols": len(columns), "title": NOTE, "title_fontsize": 7}
        figure.legend(*zip(*entries, strict=True), **place)
    else:
        left, right = figure.subplots(1, 2)
        _choices(left, experiment, found, models)
        _effects(right, found, models, shown)
        figure.supxlabel(f"{experiment.trials} {noun(experiment.trials, 'answer')} per cell", fontsize=8)
    picture = io.BytesIO()
    figure.savefig(picture, format=path.suffix.lower()[1:], dpi=120)
    write_atomically(path, [picture.getvalue()])
    return path


def _choices(axes: Axes, experiment: Experiment, found: Found, models: Sequence[str]) -> None:
    """Share of answers that choose each person in each context, over the orders, with Hoeffding's intervals."""
    tables = {model: table for model, table, _ in found.findings}
    people = list(experiment.people)
    step = 0.8 / (len(models) * len(people))
    for m, model in enumerate(models):
        for k, person in enumerate(people):
            at = [i - 0.4 + (m * len(people) + k + 0.5) * step for i in range(len(experiment.contexts))]
            shares, below, above = zip(*(_chance(experiment, tables[model], x, person) for x in experiment.contexts), strict=True)
            colour, alpha = COLOURS[m % len(COLOURS)], 0.85 - 0.65 * k / (len(people) - 1)
            axes.bar(
                at, shares, step * 0.92, color=colour, alpha=alpha, label=f"{_words(person)}, {_words(_short(model))}", edgecolor=colour
            )
            if tables[model].sampled:
                axes.errorbar(at, shares, yerr=[below, above], fmt="none", ecolor="black", capsize=3, linewidth=1)
    axes.axhline(1 / len(people), color="grey", linestyle=":", linewidth=1)
    axes.set_xticks(range(len(experiment.contexts)), [_words(context) for context in experiment.contexts])
    axes.set_ylim(0, 1.18)
    axes.set_ylabel("share of answers that choose the person")
    axes.legend(fontsize=8, loc="upper center", ncols=max(1, len(models)))
    orders = {"both": "every order", "cyclic": "cyclic orders", "fixed": "fixed order"}[experiment.order]
    axes.set_title(f"Who is chosen ({orders}; 95 % intervals for each bar)", fontsize=9)


def _chance(experiment: Experiment, table: Table, context: str, person: str) -> tuple[float, float, float]:
    """The share of answers that choose a person in a context, and how far the interval reaches below and above it."""
    total, count = Fraction(0), Fraction(0)
    for order in experiment.orders:
        row = table.rows.get((context, experiment.slots(order)), {})
        total += sum(row.values(), Fraction(0))
        count += row.get(experiment.options[order.index(person)], Fraction(0))
    if not total:
        return 0.0, 0.0, 0.0
    share = float(count / total)
    reach = sqrt(log(2 / (1 - LEVEL)) / (2 * float(total)))  # Hoeffding's: the draws of the two orders have different means
    return share, min(share, reach), min(1 - share, reach)


def _effects(axes: Axes, found: Found, models: Sequence[str], shown: Sequence[str]) -> None:
    """L of each question, local and global, with its interval."""
    middles, highs = [0.3], [0.5]
    for model, _, finding in found.findings:
        base = shown.index(finding.question)
        m = models.index(model)
        for quantity, marker, shift in (("local", "o", -0.12), ("global", "s", 0.12)):
            if quantity not in finding.meanings:
                continue
            at = base + shift + (m - (len(models) - 1) / 2) * 0.3 / max(1, len(models) - 1)
            low, high = (logarithm(v) for v in finding.interval.get(quantity, finding.meanings[quantity]))
            middle = logarithm(finding.meanings[quantity][1])
            label = f"{'L, worst context' if quantity == 'local' else 'L̄, over contexts'}, {_words(_short(model))}"
            colour = COLOURS[m % len(COLOURS)]
            axes.plot([at], [middle], marker=marker, color=colour, label=label, linestyle="none")
            axes.plot([at, at], [min(low, 1e3), min(high, 1e3)], color=colour, linewidth=1.6)
            _beyond(axes, [at], [middle], colour)
            middles += [middle] if middle < inf else []
            highs += [high] if high < inf else []
    axes.set_xticks(range(len(shown)), [QUESTIONS[q].replace(", ", ",\n") for q in shown], fontsize=8)
    axes.set_xlim(-0.5, len(shown) - 0.5)
    axes.set_ylim(0, 1.1 * min(max(highs), 3 * max(middles)))
    axes.set_ylabel("L (nats)")
    named = dict(zip(*reversed(axes.get_legend_handles_labels()), strict=True))
    axes.legend(named.values(), named.keys(), fontsize=8)
    axes.set_title("Profile and position effects, with intervals", fontsize=9)


def _slices(experiment: Experiment) -> list[list[Setting]]:
    """The settings of each row of panels: all, or, where both filters are swept, those of each filter of the context."""
    if len({s.keep for s in experiment.settings}) == 1:
        return [list(experiment.settings)]
    return [[s for s in experiment.settings if s.context_keep == p] for p in dict.fromkeys(s.context_keep for s in experiment.settings)]


def _sweep(axes: Axes, experiment: Experiment, found: Found, question: str, models: Sequence[str], settings: Sequence[Setting]) -> None:
    """L over ε, with bands, what was drawn end to end, and the bound that holds for every model."""
    by_context = len({s.keep for s in settings}) == 1
    scale = [(_epsilon(experiment, setting, by_context, found, question), i) for i, setting in enumerate(settings)]
    order = [settings[i] for _, i in sorted(scale)]
    epsilons = [epsilon for epsilon, _ in sorted(scale)]
    finite = [e for e in epsilons if isfinite(e)]
    beyond = (max(finite, default=1.0) or 1.0) * 1.15
    xs = [e if isfinite(e) else beyond for e in epsilons]
    top = 0.2
    for m, model in enumerate(models):
        colour, short = COLOURS[m % len(COLOURS)], _words(_short(model))
        own = [f for s in order for n, _, f in found.findings if (n, f.question, f.setting) == (model, question, s)]
        lined = [f for f in own if not (f.drawn and experiment.design == "both")]
        worse = [worsened(found, model, finding) for finding in lined]
        top = max(top, _line(axes, xs, lined, worse, colour, short, by_context=by_context))
        drawn = [f for f in own if f.drawn]
        at = [x + (m - (len(models) - 1) / 2) * 0.012 * max(xs) if len(lined) < len(own) else x for x in xs]
        if len(lined) < len(own):
            top = max(top, _points(axes, at, drawn, colour, short))
        above = [(x, f) for x, f in zip(at, drawn, strict=False) if f.meanings["local"][0] > ceiling(found, question, f.setting)]
        if above:
            label = "draws above the dashed bound, which holds\nfor what is drawn from, not for draws"
            heights = [logarithm(f.meanings["local"][1]) for _, f in above]
            axes.plot([x for x, _ in above], heights, marker="x", markersize=5, color="black", linestyle="none", label=label)
    bounds = [min(logarithm(ceiling(found, question, setting)), 1e3) for setting in order]
    if any(v < 1e3 for v in bounds):
        label = "every model: ε (T2; of a person T10),\nor T13 where g has a floor"
        axes.plot(xs, bounds, color="black", linestyle="--", linewidth=1.2, label=label)
    axes.set_ylim(-0.03 * top, 1.35 * top)
    axes.set_xlabel("ε of the context (nats)" if by_context else "ε of both profiles, all attributes together (nats)")
    axes.set_ylabel("L (nats)")
    if not all(map(isfinite, epsilons)):
        axes.axvline((max(finite, default=1.0) + beyond) / 2, color="grey", linewidth=0.6, linestyle=":")
    _ticks(axes, order, xs, epsilons, by_context)
    ratios = axes.secondary_yaxis("right")
    kept = [1.0]
    for ratio in RATIOS:
        kept += [ratio] if 0.08 * top < log(ratio / kept[-1]) and log(ratio) < 1.35 * top else []
    ratios.set_yticks([*map(log, kept)], [f"{ratio:g}" for ratio in kept], fontsize=8)
    ratios.set_ylabel("R = e^L (ratio of means)", fontsize=8)
    about = f"; context released as it is with p = {float(order[0].context_keep):.3g}" if len(_slices(experiment)) > 1 else ""
    axes.set_title(f"{_words(experiment.utility_name).capitalize()}: {QUESTIONS[question]}{about}", fontsize=10)


def _line(
    axes: Axes, xs: Sequence[float], findings: Sequence[Finding], worse: Sequence[list[str]], colour: str, short: str, *, by_context: bool
) -> float:
    """One decision maker over the sweep: L and L̄ of its answers, the interval of L, and the bound for them alone; the height needed."""
    top = 0.0
    for quantity, style, marker in (("local", "-", "o"), ("global", ":", "s")):
        values = [logarithm(f.meanings[quantity][1]) for f in findings]
        name = "L" if quantity == "local" else "L̄"
        axes.plot(xs, values, linestyle=style, marker=marker, markersize=4, color=colour, label=f"{name}, {short}")
        top = max([top, *(v for v in values if isfinite(v))])
        _beyond(axes, xs, values, colour)
        ringed = [(x, v) for x, v, quantities in zip(xs, values, worse, strict=True) if quantity in quantities]
        if ringed:
            rings = {"marker": "o", "markersize": 10, "markerfacecolor": "none", "markeredgecolor": "black", "linestyle": "none"}
            axes.plot(*zip(*ringed, strict=True), **rings, label="ringed: these answers are less fair\nthan those without a filter")  # type: ignore[arg-type]
    if all("local" in f.interval for f in findings):
        ends = [tuple(map(logarithm, f.interval["local"])) for f in findings]
        highest = [min(high, 1e3) for _, high in ends]
        axes.fill_between(xs, [low for low, _ in ends], highest, color=colour, alpha=0.14, linewidth=0, label=f"interval of L, {short}")
        top = max(top, min(2 * top, sorted(highest)[len(highest) // 2]))
    named = ("T8",) if by_context else ("T3", "T12")
    own = [min((logarithm(v) for n, v in f.bounds.items() if n in named), default=inf) for f in findings]
    if any(isfinite(v) for v in own):
        label = f"{'T8' if by_context else 'T3 or T12'} for these answers, {short}"
        axes.plot(xs, own, linestyle="-.", linewidth=1, color=colour, label=label)
    return top


def _points(axes: Axes, at: Sequence[float], findings: Sequence[Finding], colour: str, short: str) -> float:
    """What was drawn end to end: L of the draws and its interval; the height needed."""
    values = [logarithm(f.meanings["local"][1]) for f in findings]
    ends = [tuple(min(logarithm(v), 1e3) for v in f.interval.get("local", f.meanings["local"])) for f in findings]
    axes.vlines(at, [low for low, _ in ends], [high for _, high in ends], color=colour, linewidth=0.8, alpha=0.7)
    axes.plot(
        at, values, marker="D", markersize=5, markerfacecolor="white", color=colour, linestyle="none", label=f"L drawn end to end, {short}"
    )
    _beyond(axes, at, values, colour)
    return max((v for v in values if isfinite(v)), default=0.0)


def _beyond(axes: Axes, xs: Sequence[float], values: Sequence[float], colour: str) -> None:
    """Arrows at the upper edge, where a ratio is infinite."""
    at = [x for x, v in zip(xs, values, strict=True) if v == inf]
    if at:
        label = "infinite: somebody was never chosen"
        axes.plot(at, [0.98] * len(at), marker="^", color=colour, linestyle="none", transform=axes.get_xaxis_transform(), label=label)


def _ticks(axes: Axes, order: Sequence[Setting], xs: Sequence[float], epsilons: Sequence[float], by_context: bool) -> None:
    """Ticks of ε below, and above it the paper's axis, the odds p/(1−p) of one attribute."""
    kept: list[int] = []
    width = (max(xs) - min(xs)) or 1.0
    for place, x in enumerate(xs):
        if not kept or x - xs[kept[-1]] > 0.07 * width:
            kept.append(place)
    axes.set_xticks([xs[i] for i in kept], ["∞" if epsilons[i] == inf else f"{epsilons[i]:.3g}" for i in kept], fontsize=8)
    second = axes.secondary_xaxis("top")
    keeps = [setting.context_keep if by_context else setting.keep for setting in order]
    odds = ["∞" if keeps[i] == 1 else f"{float(keeps[i] / (1 - keeps[i])):.3g}" for i in kept]
    second.set_xticks([xs[i] for i in kept], odds, fontsize=8)
    second.set_xlabel("odds p/(1−p) of the truth" + ("" if by_context else ", one attribute"), fontsize=8)


def _epsilon(experiment: Experiment, setting: Setting, by_context: bool, found: Found, question: str) -> float:
    if not by_context:
        return logarithm(next(f for _, _, f in found.findings if (f.question, f.setting) == (question, setting)).exp_epsilon)
    return logarithm(fa.pure_dp(experiment.context_filter(setting)).exp_epsilon)


def _short(model: str) -> str:
    return model.partition(" at ")[0].partition(" (")[0]


def _words(text: str) -> str:
    """A label as text: no mathematical markup, nothing that steers."""
    return "".join(c if c.isprintable() else " " for c in text).replace("$", r"\$")[:80]
