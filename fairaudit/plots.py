"""Pictures of results. Needs the extra ``plots``."""

from __future__ import annotations

from collections.abc import Sequence
from math import inf, log
from pathlib import Path
from typing import TYPE_CHECKING, Any

from fairaudit.calibration import Calibration
from fairaudit.exact import InputError
from fairaudit.filter_design import Design, Frontier

if TYPE_CHECKING:
    from matplotlib.axes import Axes

__all__ = ["plot_calibration", "plot_frontier", "save_calibration", "save_frontier"]


def plot_calibration(found: Sequence[Calibration], ax: Axes | None = None) -> Axes:
    """Draw the keep probability over the target, beside that of the paper's rule.

    Parameters
    ----------
    found : sequence of Calibration
        Calibrations of the same setting for several targets.
    ax : Axes, optional
        Where to draw; a new figure by default.

    Returns
    -------
    Axes
        With the targets as log-ratios on the horizontal axis.

    Raises
    ------
    InputError
        If matplotlib is missing, or nothing is feasible.
    """
    axes = ax if ax is not None else _figure(1)[1][0]
    feasible = _feasible(found)
    targets = [log(c.target) for c in feasible]
    axes.plot(targets, [float(c.keep_probabilities[0]) for c in feasible], marker="o", label=feasible[0].rule)
    paper = [(log(c.target), float(c.paper_keep_probabilities[0])) for c in feasible if c.paper_keep_probabilities]
    if paper and feasible[0].rule != "paper":
        axes.plot([x for x, _ in paper], [y for _, y in paper], marker="s", linestyle="--", label="the paper's rule")
    axes.set_xlabel("target L (nats)")
    axes.set_ylabel("probability of keeping the truth")
    axes.set_ylim(bottom=0)
    axes.legend()
    return axes


def save_calibration(found: Sequence[Calibration], path: str) -> None:
    """Draw keep probability, ε and guarantee over the targets into a file.

    Parameters
    ----------
    found : sequence of Calibration
        Calibrations of the same setting for several targets.
    path : str
        A PNG, SVG or PDF file.

    Raises
    ------
    InputError
        If matplotlib is missing, nothing is feasible, or the file cannot be written.
    """
    feasible = _feasible(found)
    figure, (keep, epsilon, guarantee) = _figure(3)
    plot_calibration(found, keep)
    targets = [log(c.target) for c in feasible]
    finite = [(t, float(c.epsilon[0])) for t, c in zip(targets, feasible, strict=True) if c.exp_epsilon != inf]
    epsilon.plot([t for t, _ in finite], [e for _, e in finite], marker="o")
    epsilon.set_xlabel("target L (nats)")
    epsilon.set_ylabel("ε of the whole filter (nats)")
    epsilon.set_ylim(bottom=0)
    guarantee.plot(targets, targets, linestyle=":", color="grey", label="target")
    guarantee.plot(targets, [log(c.achieved or 1) for c in feasible], marker="o", linestyle="none", label="guaranteed")
    guarantee.set_xlabel("target L (nats)")
    guarantee.set_ylabel("L (nats)")
    guarantee.legend()
    _save(figure, path)


def plot_frontier(found: Frontier | Sequence[Design], ax: Axes | None = None) -> Axes:
    """Draw the truth kept over the target, beside that of calibrated randomized response.

    Parameters
    ----------
    found : Frontier or sequence of Design
        Designs of the same setting for several targets.
    ax : Axes, optional
        Where to draw; a new figure by default.

    Returns
    -------
    Axes
        With the targets as log-ratios on the horizontal axis.

    Raises
    ------
    InputError
        If matplotlib is missing, or nothing is feasible.
    """
    axes = ax if ax is not None else _figure(1)[1][0]
    kept = [
        (log(d.target), d.truth_kept, d.response_truth_kept)
        for d in (found.designs if isinstance(found, Frontier) else found)
        if d.target is not None and d.truth_kept is not None
    ]
    if not kept:
        raise InputError("no target is feasible; there is nothing to draw")
    kept.sort(key=lambda entry: entry[0])
    axes.plot([x for x, _, _ in kept], [float(y) for _, y, _ in kept], marker="o", label="design")
    response = [(x, float(y)) for x, _, y in kept if y is not None]
    axes.plot([x for x, _ in response], [y for _, y in response], marker="s", linestyle="--", label="randomized response")
    axes.set_xlabel("target L (nats)")
    axes.set_ylabel("probability of keeping the truth")
    axes.set_ylim(0, 1.02)
    axes.legend()
    return axes


def save_frontier(found: Frontier | Sequence[Design], path: str) -> None:
    """Draw the truth kept over the target into a file.

    Parameters
    ----------
    found : Frontier or sequence of Design
        Designs of the same setting for several targets.
    path : str
        A PNG, SVG or PDF file.

    Raises
    ------
    InputError
        If matplotlib is missing, nothing is feasible, or the file cannot be written.
    """
    figure, (axes,) = _figure(1)
    plot_frontier(found, axes)
    _save(figure, path)


def _save(figure: Any, path: str) -> None:
    import io

    from fairaudit.certificate import write_atomically

    ending = Path(path).suffix.lower().lstrip(".") or "png"
    if ending not in ("png", "svg", "pdf"):
        raise InputError(f"{path}: a picture ends in .png, .svg or .pdf")
    picture = io.BytesIO()
    figure.savefig(picture, format=ending, dpi=120)
    write_atomically(Path(path), [picture.getvalue()])


def _feasible(found: Sequence[Calibration]) -> list[Calibration]:
    feasible = [c for c in found if c.feasible]
    if not feasible:
        raise InputError("no target is feasible; there is nothing to draw")
    return feasible


def _figure(panels: int) -> tuple[Any, Any]:
    try:
        from matplotlib.backends.backend_agg import FigureCanvasAgg
        from matplotlib.figure import Figure
    except ImportError:
        raise InputError("pictures need matplotlib; install the extra: pip install 'fairaudit-certify[plots]'") from None
    figure = Figure(figsize=(4.6 * panels, 3.6), layout="constrained")
    FigureCanvasAgg(figure)
    return figure, figure.subplots(1, panels, squeeze=False)[0]
