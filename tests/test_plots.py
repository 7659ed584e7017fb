"""Pictures of results: what is drawn is what was found, and labels are text."""

from __future__ import annotations

from collections.abc import Callable
from fractions import Fraction
from math import exp
from pathlib import Path
from typing import Any

import pytest
from certificate_kinds import FOUR, KINDS, admissions, infinite, never_locally, small_counts

import fairaudit as fa
from fairaudit.cli import main

pytest.importorskip("matplotlib", reason="matplotlib is not installed (it is in the extra plots)")

from matplotlib import rc_context

from fairaudit.plots import plot_bounds, plot_expectations, plot_ratios, plot_truth_kept, save_truth_kept

PLOTS: list[Callable[..., Any]] = [plot_expectations, plot_ratios, plot_bounds]


def points(axes: Any) -> list[float]:
    return [float(line.get_xdata()[0]) for line in axes.lines if len(line.get_xdata()) == 1]


def test_expectations_are_those_of_the_groups() -> None:
    drawn = points(plot_expectations(admissions()))
    frame = admissions().to_frame()
    wanted = [*frame["expectation_float"], float(Fraction(1198, 2691)), float(Fraction(557, 1835))]
    assert sorted(drawn) == sorted(wanted)


def test_a_group_has_one_colour_and_mark_that_the_legend_names() -> None:
    axes = plot_expectations(admissions())
    marks = {line.get_label(): set() for line in axes.lines if len(line.get_xdata()) == 1}
    for line in axes.lines:
        if len(line.get_xdata()) == 1:
            marks[line.get_label()].add((line.get_color(), line.get_marker()))
    assert {name: len(found) for name, found in marks.items()} == {"Gender=Female": 1, "Gender=Male": 1}
    assert marks["Gender=Female"].isdisjoint(marks["Gender=Male"])
    assert {text.get_text() for text in axes.get_legend().get_texts()} == set(marks)
    assert axes.get_xlabel() == "Admitted" and {text.get_text() for text in axes.get_xticklabels()} >= {"0 %", "20 %"}


def test_means_below_nothing_are_seen() -> None:
    table = {"u": ["gain", "loss"] * 2, "a": ["f", "f", "m", "m"], "n": [1, 9, 5, 5]}
    signed = fa.audit(table, decision="u", group="a", count="n", utility={"gain": 1, "loss": -1}, difference=True, confidence=None)
    axes = plot_expectations(signed)
    assert min(points(axes)) == -0.8 and axes.get_xlim()[0] < -0.8


def test_ratios_are_written_in_the_matrix() -> None:
    axes = plot_ratios(admissions())
    assert {text.get_text() for text in axes.texts} == {"1.328", "0.7531"}
    assert axes.get_title() == "Dept=A"
    overall = plot_ratios(admissions(), quantity="global")
    assert {text.get_text() for text in overall.texts} == {"1.467", "0.6818"}


def test_bounds_end_at_their_values() -> None:
    result = small_counts(max_local_log="0.5", confidence=None)
    axes = plot_bounds(result)
    ends = [float(line.get_xdata()[1]) for line in axes.lines if len(set(line.get_ydata())) == 1 and line.get_linewidth() == 4]
    assert ends == pytest.approx([exp(0.5), 19 / 8])


@pytest.mark.filterwarnings("ignore:Glyph")  # the font of the test has not every script
@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("plot", PLOTS)
def test_every_kind_can_be_drawn(plot: Callable[..., Any], kind: Callable[..., fa.Result]) -> None:
    result = kind(**FOUR)
    if plot is not plot_expectations and result.local is None:
        with pytest.raises(fa.InputError, match="not measured"):
            plot(result)
        return
    axes = plot(result)
    axes.figure.canvas.draw()


def test_commands_draw_what_a_result_draws(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """`certify`, and `report` of its certificate: each the same picture as `Result.plot`."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("SOURCE_DATE_EPOCH", "0")
    words = ["certify", "--example", "ucb-admissions", "-o"]
    with rc_context({"svg.hashsalt": "the same"}):
        for picture in ("expectations", "ratios", "bounds"):
            admissions().plot(f"{picture}.svg", picture=picture)
        assert main([*words, "c.json", "-o", "c.svg", "-o", "C.PNG"]) == 0
        for picture in ("expectations", "ratios", "bounds"):
            assert main(["report", "c.json", "-o", f"of-{picture}.svg", "--picture", picture]) == 0
    for picture in ("expectations", "ratios", "bounds"):
        assert Path(f"of-{picture}.svg").read_bytes() == Path(f"{picture}.svg").read_bytes()
    assert Path("c.svg").read_bytes() == Path("expectations.svg").read_bytes()
    assert Path("C.PNG").read_bytes().startswith(b"\x89PNG")


def test_a_false_certificate_has_no_picture(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = tmp_path / "c.json"
    path.write_text(admissions().certificate.text.replace('"1198"', '"1199"').replace("1198/2691", "1199/2691"))
    assert main(["report", str(path), "-o", str(tmp_path / "c.svg")]) == 1
    assert "FALSE" in capsys.readouterr().err and not (tmp_path / "c.svg").exists()


def test_an_axes_that_is_given_is_used() -> None:
    from matplotlib.figure import Figure

    for plot in PLOTS:
        given = Figure().subplots()
        assert plot(infinite(), given) is given
    with pytest.raises(fa.InputError):
        plot_ratios(never_locally())


def test_labels_are_not_mathematics() -> None:
    law = fa.Law.from_array([[3, 1], [1, 1]], kind="counts", decisions=["yes", "no"], groups=[r"$\frac{1}{0$", "m" * 500])
    result = fa.certify(law, {"yes": 1}, confidence=None)
    for plot in PLOTS:
        plot(result).figure.canvas.draw()


def test_labels_that_differ_look_different() -> None:
    """Groups of six columns that differ in the last one alone; short ones are as they were."""
    columns = [f"column {i}" for i in range(6)]
    rows = [("yes" if k % 3 else "no", *["alike"] * 5, g) for g in ("one", "other", "third") for k in range(9)]
    table = dict(zip(["u", *columns], map(list, zip(*rows, strict=True)), strict=True))
    result = fa.audit(table, decision="u", group=columns, utility="yes", confidence=None)
    for plot in (plot_expectations, plot_ratios):
        axes = plot(result)
        shown = [text.get_text().strip() for text in axes.get_yticklabels()]
        assert len({*shown}) == len(shown) and all(any(g in text for text in shown) for g in ("one", "other", "third"))
        axes.figure.canvas.draw()
        assert axes.get_window_extent().width > 300  # of the picture itself something is left beside its labels
    assert plot_expectations(admissions()).figure.get_size_inches()[0] == 8


def test_truth_kept_of_calibrations_and_designs(tmp_path: Path) -> None:
    found = [fa.calibrate(max_log=target, groups=4, tau="0.3") for target in ("0.1", "0.2")]
    axes = plot_truth_kept(found)
    assert [label.get_text() for label in axes.get_legend().get_texts()] == ["exact", "the paper's rule"]
    assert axes.lines[0].get_ydata().tolist() == [float(c.keep_probabilities[0]) for c in found]
    for name in ("a.png", "a.svg", "a.pdf"):
        save_truth_kept(found, str(tmp_path / name))
        assert (tmp_path / name).stat().st_size > 1000
    with pytest.raises(fa.InputError, match="ends in"):
        save_truth_kept(found, str(tmp_path / "a.exe"))
    with pytest.raises(fa.InputError, match="nothing to draw"):
        plot_truth_kept([])


def test_notebooks_show_a_result_with_labels_as_text() -> None:
    law = fa.Law.from_array([[3, 1], [1, 1]], kind="counts", decisions=["yes", "no"], groups=["<script>\u202e", "m"])
    shown = fa.certify(law, {"yes": 1}, max_local_ratio="5/4")._repr_html_()
    assert "<strong>inconclusive</strong>" in shown and "3/2" in shown
    assert "<script" not in shown and "&lt;script&gt;" in shown and "\u202e" not in shown
    assert "infinite" in infinite()._repr_html_() and "not compared" in never_locally()._repr_html_()


def test_a_legend_of_long_names_covers_no_point() -> None:
    groups = ["a person of whom much is said", "another person of whom as much is said"]
    table = {"u": ["yes", "no"] * 2, "g": [name for name in groups for _ in "ab"], "n": [30, 10, 20, 20]}
    axes = fa.audit(table, decision="u", group="g", count="n", utility="yes").plot()
    (legend,) = axes.figure.legends
    axes.figure.draw_without_rendering()
    assert [text.get_text() for text in legend.get_texts()] == [f"g={name}" for name in groups]
    assert legend.get_window_extent().y1 <= axes.get_window_extent().y0
    assert axes.get_legend() is None
