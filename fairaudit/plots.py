"""Pictures of results with matplotlib, the ones of the report. Needs the extra ``plots``."""

from __future__ import annotations

import os
from collections.abc import Iterable, Mapping, Sequence
from math import inf, isfinite, log
from pathlib import Path
from textwrap import wrap
from typing import TYPE_CHECKING, Any, Literal

import numpy as np

from fairaudit.audits.faces import Picture
from fairaudit.audits.result import Result
from fairaudit.certificates.reader import Subject
from fairaudit.errors import InputError, nearest, shown
from fairaudit.filters.calibration import Calibration
from fairaudit.filters.design_result import Design
from fairaudit.filters.frontiers import Frontier
from fairaudit.reports.content import Content, describe
from fairaudit.reports.expectations import Panel
from fairaudit.reports.overview_parts import amount_name, counted_decisions

if TYPE_CHECKING:
    from matplotlib.axes import Axes

__all__ = ["check_extra", "draw", "drawn", "plot_bounds", "plot_expectations", "plot_ratios", "plot_truth_kept", "save_truth_kept"]

HIGH, LOW, MID, ALARM = "#1f5f8b", "#b0561b", "#7c8593", "#a32f2a"
MARKS = tuple(zip(("#0072b2", "#d55e00", "#009e73", "#cc79a7", "#e69f00", "#56b4e9", "#000000"), "osD^vPX", strict=True))
SHOW_TEXT, BESIDE = 40, 56
BESIDE_POINTS = 24  # longer names in a legend stand below the picture, where they cover no point
BEYOND = 1e12  # ratios above this are drawn up to the edge, as infinite ones are


def plot_expectations(result: Result | Content, ax: Axes | None = None) -> Axes:
    """Draw what each group gets, in the most unequal contexts and overall, with intervals where decisions were drawn.

    Parameters
    ----------
    result : Result or Content
        What `certify` found, or what a report says of its certificate.
    ax : Axes, optional
        Where to draw; a new figure by default.

    Returns
    -------
    Axes
        Expected utility on the horizontal axis, a rate where decisions count 1 or nothing; one line for each group, contexts one below
        the other. A group has one colour and mark throughout; of more than seven the most and least favoured of each context have one.
        Intervals hold each by itself, at the confidence of the result.

    Raises
    ------
    InputError
        If matplotlib is missing.
    """
    content = _content(result)
    subject = content.subject
    if subject is None:
        raise InputError("the certificate does not hold its table, whose groups the picture shows")
    panels = _panels(content)
    lines = sum(len(panel.members) + 1 for panel in panels)
    wide = _apart(member.label for panel in panels for member in panel.members)
    figure, (axes, *_) = (None, (ax,)) if ax is not None else _figure(1, width=_width(wide), height=1.2 + 0.24 * lines)
    labels: list[str] = []
    groups = list(dict.fromkeys(sorted(member.label for panel in panels for member in panel.members)))
    own = dict(zip(groups, MARKS, strict=False)) if len(groups) <= len(MARKS) else {}
    for panel in panels:
        labels.append(panel.title)
        for i, member in enumerate(panel.members):
            y = len(labels)
            labels.append("  " + member.label)
            if member.ends:
                axes.plot([float(end) for end in member.ends], [y, y], color=MID, linewidth=3, alpha=0.6, solid_capstyle="round")
            if member.before:
                axes.plot(
                    [float(member.before)],
                    [y],
                    marker="o",
                    color=MID,
                    fillstyle="none",
                    markersize=11,
                    linestyle="none",
                    label="without filter",
                )
            name, most = ("most favoured", HIGH) if i == 0 else ("least favoured", LOW)
            extreme = most if i in (0, len(panel.members) - 1) else MID
            colour, mark = own.get(member.label, (extreme, "o"))
            said = _shown(member.label if own else name if extreme != MID else "between", wide)
            axes.plot([float(member.value)], [y], marker=mark, color=colour, linestyle="none", label=said)
    axes.set_yticks(range(len(labels)), [_shown(label, wide + 2) for label in labels])
    for label, text in zip(labels, axes.get_yticklabels(), strict=True):
        text.set_fontweight("normal" if label.startswith("  ") else "bold")
    axes.set_ylim(len(labels) - 0.5, -0.5)
    if not content.signed:
        axes.set_xlim(left=0)
    counted = counted_decisions(subject.utility)
    axes.set_xlabel(_shown(amount_name(subject.law, counted, burden=content.burden)))
    if counted:
        axes.xaxis.set_major_formatter(lambda value, _: f"{100 * value:.0f} %")
    lines_of = dict(zip(*axes.get_legend_handles_labels()[::-1], strict=True))
    if figure is not None and max(map(len, lines_of), default=0) > BESIDE_POINTS:
        figure.set_figheight(figure.get_figheight() + 0.22 * len(lines_of))
        figure.legend(lines_of.values(), lines_of.keys(), loc="outside lower right", frameon=False)
    else:
        axes.legend(lines_of.values(), lines_of.keys(), loc="best", frameon=False)
    return axes


def plot_ratios(result: Result | Content, ax: Axes | None = None, *, quantity: Literal["local", "global"] = "local") -> Axes:
    """Draw the matrix of pairwise ratios, in the most unequal context or overall.

    Parameters
    ----------
    result : Result or Content
        What `certify` found, or what a report says of its certificate.
    ax : Axes, optional
        Where to draw; a new figure by default.
    quantity : {"local", "global"}
        Whether to compare the groups in the most unequal context, or their means over all contexts.

    Returns
    -------
    Axes
        How many times as much the group of the row gets as the group of the column; infinite ratios are written and not coloured.

    Raises
    ------
    InputError
        If matplotlib is missing, or the quantity was not measured.
    """
    content = _content(result)
    if not content.matrices or content.measured[quantity] is None:
        raise InputError(f"the {quantity} ratio was not measured; there is nothing to draw")
    matrix = content.matrices[-1 if quantity == "global" else 0]
    size = len(matrix.rows)
    wide = _apart(matrix.rows)
    axes = ax if ax is not None else _figure(1, width=_width(wide), height=1.6 + 0.42 * size)[1][0]
    values = [[1.0 if v is None else float(v) for v in row] for row in matrix.ratios]
    heat = [[abs(log(v)) if v > 0 and isfinite(v) else float("nan") for v in row] for row in values]
    axes.imshow(heat, cmap="YlOrBr", vmin=0, vmax=max(1.2, *(h for row in heat for h in row if h == h)), aspect="auto")
    for i, row in enumerate(matrix.ratios):
        for j, value in enumerate(row):
            if value is not None:
                axes.text(j, i, value.decimal, ha="center", va="center", color="white" if heat[i][j] > 0.9 else "black")
    axes.set_xticks(range(size), [str(i + 1) for i in range(size)])
    axes.set_yticks(range(size), [f"{i + 1} {_shown(name, wide)}" for i, name in enumerate(matrix.rows)])
    axes.set_title(_shown(matrix.title))
    axes.set_xlabel(f"{'bears' if content.burden else 'gets'} … times as much as group")
    return axes


def plot_bounds(result: Result | Content, ax: Axes | None = None, *, quantity: Literal["local", "global"] = "local") -> Axes:
    """Draw the ladder of what is known of a ratio: measured, bounded, asked for.

    Parameters
    ----------
    result : Result or Content
        What `certify` found, or what a report says of its certificate.
    ax : Axes, optional
        Where to draw; a new figure by default.
    quantity : {"local", "global"}
        Which ratio.

    Returns
    -------
    Axes
        The ratio on a logarithmic horizontal axis; a line for each statement, with what it is about; dashed lines at the targets. Infinite
        and enormous values reach the right edge.

    Raises
    ------
    InputError
        If matplotlib is missing, or the quantity was not measured.
    """
    rungs = _content(result).ladders.get(quantity)
    if not rungs:
        raise InputError(f"the {quantity} ratio was not measured; there is nothing to draw")
    said = [
        "\n".join([*wrap(f"{rung.value.decimal}  {rung.name}", BESIDE), *wrap(rung.scope, BESIDE)]).replace("$", r"\$") for rung in rungs
    ]
    lines = max(text.count("\n") for text in said) + 1
    axes = ax if ax is not None else _figure(1, height=1.2 + (0.1 + 0.14 * lines) * len(rungs), width=9.0)[1][0]
    from matplotlib.ticker import MaxNLocator, NullLocator

    edge = 1.15 * max((float(rung.value) for rung in rungs if float(rung.value) <= BEYOND), default=1.0)
    colours = {"measured": HIGH, "least": HIGH, "unfiltered": LOW, "bound": MID, "target": ALARM}
    for y, rung in enumerate(rungs):
        value = float(rung.value)
        axes.plot([1.0, min(value, edge)], [y, y], color=colours[rung.kind], linewidth=4, solid_capstyle="butt")
        if rung.kind == "target" and value <= edge:
            axes.axvline(value, color=ALARM, linestyle="--", linewidth=1)
    axes.set_xscale("log")
    axes.set_xlim(1.0, max(edge, 1.01))
    axes.set_yticks(range(len(rungs)), said, fontsize=9)
    axes.set_ylim(len(rungs) - 0.5, -0.5)
    if max(edge, 1.01) < 20:
        axes.xaxis.set_major_locator(MaxNLocator(6, steps=[1, 2, 2.5, 5, 10]))
        axes.xaxis.set_major_formatter("{x:g}")
        axes.xaxis.set_minor_locator(NullLocator())
    axes.set_xlabel(f"{quantity} ratio")
    return axes


def plot_truth_kept(found: Sequence[Calibration] | Sequence[Design] | Frontier, ax: Axes | None = None) -> Axes:
    """Draw how much truth a filter may tell over the target, beside the rule that it improves on.

    Parameters
    ----------
    found : sequence of Calibration, sequence of Design, or Frontier
        Answers to the same question for several targets. Calibrations are drawn beside the paper's rule, designs beside calibrated
        randomized response.
    ax : Axes, optional
        Where to draw; a new figure by default.

    Returns
    -------
    Axes
        With the targets on the horizontal axis, as logarithms below and as ratios above; of calibrations of several attributes, the
        probability of the first.

    Raises
    ------
    InputError
        If matplotlib is missing, or nothing is feasible.
    """
    axes = ax if ax is not None else _figure(1)[1][0]
    name, kept, beside, known = _truth(found.designs if isinstance(found, Frontier) else found)
    if not kept:
        raise InputError("no target is feasible; there is nothing to draw")
    axes.plot([x for x, _ in kept], [y for _, y in kept], marker="o", color=HIGH, label=name)
    if known:
        axes.plot([x for x, _ in known], [y for _, y in known], marker="s", linestyle="--", color=LOW, label=beside)
    _label_targets(axes)
    axes.set_ylabel("probability of keeping the truth")
    axes.set_ylim(bottom=0)
    axes.legend()
    return axes


def save_truth_kept(found: Sequence[Calibration] | Sequence[Design] | Frontier, path: str) -> None:
    """Draw the truth kept over the targets into a file; for calibrations also ε and the guarantee.

    Parameters
    ----------
    found : sequence of Calibration, sequence of Design, or Frontier
        As in `plot_truth_kept`.
    path : str
        A PNG, SVG or PDF file.

    Raises
    ------
    InputError
        If matplotlib is missing, nothing is feasible, or the file cannot be written.
    """
    calibrations = [] if isinstance(found, Frontier) else [c for c in found if isinstance(c, Calibration) and c.feasible]
    figure, panels = _figure(3 if calibrations else 1)
    plot_truth_kept(found, panels[0])
    if calibrations:
        _, epsilon, guarantee = panels
        targets = [log(c.target) for c in calibrations]
        finite = [(t, float(c.epsilon[0])) for t, c in zip(targets, calibrations, strict=True) if c.exp_epsilon != inf]
        epsilon.plot([t for t, _ in finite], [e for _, e in finite], marker="o", color=HIGH)
        _label_targets(epsilon)
        epsilon.set_ylabel("ε of the whole filter (nats)")
        epsilon.set_ylim(bottom=0)
        guarantee.plot(targets, targets, linestyle=":", color=MID, label="target")
        guarantee.plot(targets, [log(c.achieved or 1) for c in calibrations], marker="o", linestyle="none", color=HIGH, label="guaranteed")
        _label_targets(guarantee)
        guarantee.set_ylabel("L (nats)")
        guarantee.legend()
    _save(figure, path)


def draw(result: Result, picture: Picture, path: str | os.PathLike[str] | None = None) -> Axes:
    """Draw one of the pictures of a result, into a file if one is named.

    Raises
    ------
    InputError
        If there is no such picture, matplotlib is missing, or the file cannot be written.
    """
    if picture not in PICTURES:
        raise InputError(f"there is no picture {shown(picture)}; {nearest(str(picture), PICTURES)}")
    axes = PICTURES[picture](result)
    if path is not None:
        _save(axes.figure, os.fspath(path))
    return axes


PICTURES = {"expectations": plot_expectations, "ratios": plot_ratios, "bounds": plot_bounds}


def drawn(found: Result | Mapping[str, Any], path: str, picture: Picture = "expectations") -> bytes:
    """The bytes of a picture of a result, or of the document of a certificate, for a file of this name.

    Raises
    ------
    InputError
        If matplotlib is missing, or there is nothing to draw: the certificate does not hold its table, or no ratio was measured.
    """
    from fairaudit.certificates.reader import FORMAT

    if not isinstance(found, Result) and found.get("format") != FORMAT:
        raise InputError(f"{path}: a picture is drawn of a certificate of ratios, and this one is {shown(found.get('format'))}")
    try:
        return _bytes(PICTURES[picture](found if isinstance(found, Result) else describe(found)).figure, path)
    except InputError as error:
        raise InputError(f"{path}: {error}") from None


def _label_targets(axes: Axes) -> None:
    """Name a horizontal axis of targets in both readings: the logarithm below, the ratio above."""
    axes.set_xlabel("target: natural logarithm of the ratio")
    above = axes.secondary_xaxis("top", functions=(np.exp, lambda ratio: np.log(np.maximum(ratio, 1e-9))))
    above.set_xlabel("target: ratio")


Points = list[tuple[float, float]]


def _truth(found: Sequence[Calibration] | Sequence[Design]) -> tuple[str, Points, str, Points]:
    """Truth over target, by what was found and by what it stands beside, each with its name."""
    calibrations = [c for c in found if isinstance(c, Calibration) and c.feasible]
    if calibrations:
        rule = calibrations[0].rule
        kept = [(log(c.target), float(c.keep_probabilities[0])) for c in calibrations]
        paper = [(log(c.target), float(c.paper_keep_probabilities[0])) for c in calibrations if c.paper_keep_probabilities]
        return rule, kept, "the paper's rule", paper if rule != "paper" else []
    designs = [d for d in found if isinstance(d, Design) and d.target is not None and d.truth_kept is not None]
    designs.sort(key=lambda d: d.target or 0)
    kept = [(log(d.target), float(d.truth_kept)) for d in designs if d.target is not None and d.truth_kept is not None]
    known = [(log(d.target), float(d.response_truth_kept)) for d in designs if d.target is not None and d.response_truth_kept is not None]
    return "design", kept, "randomized response", known


def _content(result: Result | Content) -> Content:
    return (
        result
        if isinstance(result, Content)
        else describe(result.certificate.document, Subject(result.law, result.utility, result.deployment))
    )


def _panels(content: Content) -> list[Panel]:
    return [*content.panels, *([content.overall] if content.overall else [])]


def _apart(labels: Iterable[str]) -> int:
    """To how many characters labels are cut, so that those that differ look different."""
    different = {*labels}
    return SHOW_TEXT if len({*map(_shown, different)}) == len(different) else max(map(len, different))


def _width(letters: int) -> float:
    """How wide a picture with labels of so many letters is, in inches."""
    return 8.0 + 0.075 * max(0, letters - SHOW_TEXT)


def _shown(text: str, width: int = SHOW_TEXT) -> str:
    """A label for a picture: short, and without the dollar signs that matplotlib would read as mathematics."""
    cut = text if len(text) <= width else text[: width - 1] + "…"
    return cut.replace("$", r"\$")


def _save(figure: Any, path: str) -> None:
    from fairaudit.files import write_atomically

    write_atomically(Path(path), [_bytes(figure, path)])


def _bytes(figure: Any, path: str) -> bytes:
    import io

    ending = Path(path).suffix.lower().lstrip(".") or "png"
    if ending not in ("png", "svg", "pdf"):
        raise InputError(f"{path}: a picture ends in .png, .svg or .pdf")
    picture = io.BytesIO()
    figure.savefig(picture, format=ending, dpi=120)
    return picture.getvalue()


def check_extra() -> None:
    """Refuse to go on where matplotlib is missing.

    Raises
    ------
    InputError
        If it is.
    """
    try:
        import matplotlib.figure  # noqa: F401
    except ImportError:
        raise InputError("pictures need matplotlib; install the extra: pip install 'fairaudit-certify[plots]'") from None


def _figure(panels: int, *, width: float = 4.6, height: float = 3.6) -> tuple[Any, Any]:
    check_extra()
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    figure = Figure(figsize=(width * panels, height), layout="constrained")
    FigureCanvasAgg(figure)
    return figure, figure.subplots(1, panels, squeeze=False)[0]
