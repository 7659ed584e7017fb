"""What the figures show: read off the drawing itself, from runs with a seeded maker and with a server that looks at pictures."""

from __future__ import annotations

import base64
import json
import random
import sys
import threading
from collections.abc import Iterator
from dataclasses import replace
from fractions import Fraction
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from math import exp, inf, log
from pathlib import Path
from typing import Any

import pytest

from fairaudit.cli import main
from fairaudit.plugins.vlm import plot
from fairaudit.plugins.vlm.analyse import Table, certify
from fairaudit.plugins.vlm.experiment import bundled, read_experiment
from fairaudit.plugins.vlm.journal import Journal
from fairaudit.plugins.vlm.plot import draw
from fairaudit.plugins.vlm.report import Found, ceiling, certify_all, said
from fairaudit.plugins.vlm.run import run

pytest.importorskip("matplotlib")
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

TWO = """
[[model]]
name = "stand-in"
maker = "stand-in"

[[model]]
name = "contrary"
maker = "stand-in"
parameters = { weights = { complaints = { "often complains" = "-3" } } }
"""
PICTURES = Path(plot.__file__).parent / "experiments" / "pictures"


@pytest.fixture
def figures(monkeypatch: pytest.MonkeyPatch) -> list[Figure]:
    """The figures that are saved, as matplotlib has them."""
    kept: list[Figure] = []
    save = Figure.savefig

    def seen(figure: Figure, *given: Any, **named: Any) -> None:
        kept.append(figure)
        save(figure, *given, **named)

    monkeypatch.setattr(Figure, "savefig", seen)
    return kept


def labels(figure: Figure) -> list[str]:
    return [text.get_text() for text in figure.legends[0].get_texts() if text.get_text()]


def found_by(text: str, folder: Path, seed: int) -> Found:
    folder.mkdir(exist_ok=True)
    (folder / "e.toml").write_text(text, "utf-8")
    experiment = read_experiment(str(folder / "e.toml"))
    with Journal(folder / "journal.sqlite", experiment.digest, experiment.trials, create=True) as journal:
        for model in experiment.models:
            run(experiment, model, journal, below=random.Random(seed).randrange)
        return certify_all(experiment, journal, journal.models(), folder, confidence="0.95", targets=None)


@pytest.fixture(scope="module")
def swept(tmp_path_factory: pytest.TempPathFactory) -> Found:
    """Two makers, the table of answers and draws beside it."""
    text = bundled()["waiting-time"].read_text("utf-8")
    text = text[: text.index("[[model]]")].replace("trials = 100", 'trials = 8\ndesign = "both"') + TWO
    return found_by(text, tmp_path_factory.mktemp("swept"), 3)


def test_several_makers_and_two_axes(swept: Found, figures: list[Figure], tmp_path: Path) -> None:
    """A column of the legend for each maker, R beside L, and nothing that leaves the page."""
    draw(swept.experiment, swept, tmp_path / "f.png")
    (figure,) = figures
    named = labels(figure)
    for model in ("stand-in", "contrary"):
        assert {f"L, {model}", f"L̄, {model}", f"interval of L, {model}", f"L drawn end to end, {model}"} <= set(named)
    assert [name.rpartition(", ")[2] for name in named[:10]] == ["stand-in"] * 5 + ["contrary"] * 5
    ratios = figure.axes[0].child_axes[1]
    assert len(ratios.get_yticks()) > 3
    for tick, text in zip(ratios.get_yticks(), ratios.get_yticklabels(), strict=True):
        assert exp(tick) == pytest.approx(float(text.get_text()))
    renderer = FigureCanvasAgg(figure).get_renderer()
    page, boxes = figure.bbox, [entry.get_window_extent(renderer) for entry in (*figure.legends, *figure.axes)]
    assert all(page.x0 <= box.x0 and box.x1 <= page.x1 and page.y0 <= box.y0 and box.y1 <= page.y1 for box in boxes)


def test_draws_above_a_bound_are_marked_and_explained(swept: Found, figures: list[Figure], tmp_path: Path) -> None:
    """A point is above what bounds every maker if and only if it is crossed; the text says why that is no contradiction."""
    draw(swept.experiment, swept, tmp_path / "f.png")
    above = [f for _, _, f in swept.findings if f.drawn and f.meanings["local"][0] > ceiling(swept, f.question, f.setting)]
    slots = [f for f in above if f.question == "slot"]
    assert slots  # with ε = 0 every two shares that differ are
    crosses = [line for line in figures[0].axes[0].lines if str(line.get_label()).startswith("draws above")]
    crossed = [float(y) for line in crosses for y in line.get_ydata()]
    assert sorted(crossed) == pytest.approx(sorted(log(f.meanings["local"][1]) for f in slots))
    text = said(swept)
    assert text.count("which holds for what is drawn from and not for draws") == len(above)
    assert text.count("the interval reaches below it") == sum(
        f.interval["local"][0] <= ceiling(swept, f.question, f.setting) for f in above
    )
    for model, _, finding in swept.findings:  # of the table no point is above the bound, whatever the maker
        assert finding.drawn or finding.meanings["local"][1] <= ceiling(swept, finding.question, finding.setting), model


def test_an_interval_above_a_bound_is_no_chance(swept: Found) -> None:
    """Draws such as no maker behind this filter gives, but once in a great many times: the text doubts the draws, not the bound."""
    experiment = swept.experiment
    setting = experiment.settings[3]  # keep 3/5, three trips against one: R ≤ 43/33 by T13
    assert ceiling(swept, "slot", setting) == Fraction(43, 33)
    first, second = (("package delivery", experiment.slots(order)) for order in experiment.orders)
    rows = {first: {"Recipient1": Fraction(300)}, second: {"Recipient2": Fraction(300)}}
    table = Table(3, rows, sampled=True, complete=True, kinds=swept.findings[0][1].kinds)
    odd = certify(experiment, table, setting, "slot")
    kept = tuple(entry for entry in swept.findings if not entry[2].drawn)
    assert "rare by chance; are the answers independent" in said(replace(swept, findings=(*kept, (kept[0][0], table, odd))))


def test_what_is_infinite_stands_at_the_edge(figures: list[Figure], tmp_path: Path) -> None:
    """A maker that never serves one recipient first: without a filter L is infinite, and an arrow says so."""
    text = bundled()["package-delivery"].read_text("utf-8").replace('"1.1"', '"40"').replace("trials = 100", "trials = 5")
    found = found_by(text.replace("[utility]", '[filter]\nkeep_probability = ["0.7", "1"]\n\n[utility]'), tmp_path, 1)
    assert any(f.meanings["local"][1] == inf for _, _, f in found.findings)
    draw(found.experiment, found, tmp_path / "f.png")
    assert any(name.startswith("infinite") for name in labels(figures[0]))


def test_an_infinite_effect_is_no_number(figures: list[Figure], tmp_path: Path) -> None:
    """Without a filter, too: an arrow at the edge, no point at a height, and an interval that leaves the panel."""
    text = bundled()["package-delivery"].read_text("utf-8").replace('"1.1"', '"40"').replace("trials = 100", "trials = 5")
    found = found_by(text, tmp_path, 1)
    draw(found.experiment, found, tmp_path / "f.png")
    right = figures[0].axes[1]
    arrows = [line for line in right.lines if str(line.get_label()).startswith("infinite")]
    assert len(arrows) == sum(f.meanings[q][1] == inf for _, _, f in found.findings for q in ("local", "global")) > 0
    assert max(float(line.get_ydata()[-1]) for line in right.lines if len(line.get_ydata()) == 2) > right.get_ylim()[1]


def test_filters_of_both_have_a_row_of_panels_each(figures: list[Figure], tmp_path: Path) -> None:
    text = bundled()["worse-x"].read_text("utf-8")
    start, end = text.index("context_keep_probability"), text.index("\n\n[utility]")
    text = text[:start] + 'context_keep_probability = ["0.6", "1"]\nkeep_probability = ["0.6", "0.8", "1"]' + text[end:]
    found = found_by(text.replace("trials = 400", "trials = 3"), tmp_path, 2)
    draw(found.experiment, found, tmp_path / "f.png")
    (figure,) = figures
    assert len(figure.axes) == 4
    for axes in figure.axes:
        (line,) = (line for line in axes.lines if line.get_label() == "L, stand-in")
        assert len(line.get_xdata()) == 3
        assert list(line.get_xdata()) == sorted(line.get_xdata())


def test_bars_of_many_people(figures: list[Figure], tmp_path: Path) -> None:
    """Shares with Hoeffding's interval by hand, and a shade of its own for each of five people."""
    text = bundled()["worse-x"].read_text("utf-8")
    text = text.replace('["HR1", "HR2"]', json.dumps([f"HR{i}" for i in range(1, 6)])).replace(
        '["Tom", "Mary"]', '["A", "B", "C", "D", "E"]'
    )
    parts = [text.index(name) for name in ("[people.Tom]", "[prompt]", "[filter]", "[utility]", "[stand-in")]
    people = "".join(f'[people.{name}]\nname = "{name}"\n' for name in "ABCDE")
    text = text[: parts[0]] + people + text[parts[1] : parts[2]] + text[parts[3] : parts[4]]
    text = text.replace("trials = 400", 'trials = 20\norder = "cyclic"') + '[[model]]\nname = "s"\nmaker = "stand-in"\n'
    found = found_by(text, tmp_path, 5)
    draw(found.experiment, found, tmp_path / "f.png")
    bars = [bar.patches[0].get_alpha() for bar in figures[0].axes[0].containers if getattr(bar, "patches", None)]
    assert len(set(bars)) == 5
    experiment, table = found.experiment, found.findings[0][1]
    share, below, above = plot._chance(experiment, table, "sick leave", "C")
    answers = [table.rows["sick leave", experiment.slots(order)] for order in experiment.orders]
    chosen = sum(row.get(f"HR{order.index('C') + 1}", 0) for row, order in zip(answers, experiment.orders, strict=True))
    reach = (log(2 / 0.05) / (2 * 100)) ** 0.5
    assert (share - below, share, share + above) == pytest.approx((max(0, chosen / 100 - reach), chosen / 100, chosen / 100 + reach))


class Looking(BaseHTTPRequestHandler):
    """An endpoint that notes what it is shown, and chooses Mary."""

    def do_POST(self) -> None:
        body = json.loads(self.rfile.read(int(self.headers["Content-Length"])))
        parts = [part for message in body["messages"] for part in (message["content"] if isinstance(message["content"], list) else [])]
        pictures = tuple(base64.b64decode(part["image_url"]["url"].partition(",")[2]) for part in parts if part["type"] == "image_url")
        text = " ".join(part["text"] for part in parts if part["type"] == "text")
        self.server.seen.append((text, pictures))  # type: ignore[attr-defined]
        first = "HR1: Mary" in text
        content = json.dumps({"HR1": "1.0" if first else "0.0", "HR2": "0.0" if first else "1.0", "reason": "seen"})
        choice = {"message": {"role": "assistant", "content": content}, "finish_reason": "stop"}
        answer = json.dumps({"choices": [choice], "usage": {"prompt_tokens": 9, "completion_tokens": 9}}).encode()
        self.send_response(200)
        self.send_header("Content-Type", "application/json")
        self.send_header("Content-Length", str(len(answer)))
        self.end_headers()
        self.wfile.write(answer)

    def log_message(self, *_: object) -> None:
        """Say nothing."""


@pytest.fixture
def server() -> Iterator[ThreadingHTTPServer]:
    found = ThreadingHTTPServer(("127.0.0.1", 0), Looking)
    found.seen = []  # type: ignore[attr-defined]
    threading.Thread(target=found.serve_forever, daemon=True).start()
    yield found
    found.shutdown()
    found.server_close()


def test_an_endpoint_is_shown_pictures_behind_a_filter(
    server: ThreadingHTTPServer, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, figures: list[Figure], capsys: pytest.CaptureFixture[str]
) -> None:
    """The pictures that ship arrive as they are, with profiles that the filter made up: both together, in one figure with a maker."""
    monkeypatch.setenv("OPENAI_API_KEY", "none")
    text = bundled()["pictures-a"].read_text("utf-8").replace("pictures/documents", str(PICTURES / "documents"))
    start, end = text.index("keep_probability"), text.index("\n\n[utility]")
    (tmp_path / "e.toml").write_text(text[:start] + 'keep_probability = ["0.6", "1"]' + text[end:], "utf-8")
    command = [str(tmp_path / "e.toml"), "--folder", str(tmp_path / "run"), "--trials", "1"]
    url = f"http://127.0.0.1:{server.server_port}/v1"
    assert main(["experiment", "run", *command, "--base-url", url, "--model", "seer"]) == 0
    assert main(["experiment", "run", *command, "--maker", "stand-in"]) == 0
    assert main(["experiment", "plot", *command]) == 0
    capsys.readouterr()
    seen = server.seen  # type: ignore[attr-defined]
    assert {pictures for _, pictures in seen} == {tuple((PICTURES / "documents" / f"candidate-{i}.png").read_bytes() for i in (1, 2))}
    assert any("HR1: Tom, 55 years old, American" in text for text, _ in seen)  # a profile that nobody has
    assert len({text for text, _ in seen}) == 3 * 64
    assert {"L, seer", "L, stand-in"} <= set(labels(figures[0]))


def test_the_pictures_are_those_of_the_navigation_plug_in(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """Drawn anew from the office of the examples, every pixel is the same."""
    pytest.importorskip("PIL")
    assert main(["navigation", "office", str(tmp_path / "o")]) == 0
    for name in ("documents", "parcels"):
        assert main(["experiment", "render", str(tmp_path / "o" / f"{name}.toml")]) == 0
        sets = [folder / "candidates.json" for folder in (tmp_path / "o" / f"{name}-candidates", PICTURES / name)]
        fresh, shipped = (json.loads(path.read_text("utf-8"))["candidates"] for path in sets)
        assert [entry["pixels_sha256"] for entry in fresh] == [entry["pixels_sha256"] for entry in shipped]
    capsys.readouterr()


def test_an_encoder_that_is_not_installed_is_left_out_and_named(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path, capsys: pytest.CaptureFixture[str], figures: list[Figure]
) -> None:
    from fairaudit.plugins.vlm import minilm

    minilm.weights.cache_clear()
    monkeypatch.setitem(sys.modules, "tokenizers", None)
    assert main(["experiment", "plot", "pictures-waiting", "--trials", "1", "--folder", str(tmp_path / "run")]) == 0
    assert "the figure leaves sentence encoder out: tokenizers is not installed" in capsys.readouterr().err
    assert {"L, stand-in", "L, contrary stand-in"} <= set(labels(figures[0]))
    assert main(["experiment", "plot", "pictures-waiting", "--maker", "minilm", "--trials", "1", "--folder", str(tmp_path / "other")]) == 2
