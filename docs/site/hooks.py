"""Pages and pictures of the documentation that are made from the code, when the site is built."""

from __future__ import annotations

import contextlib
import io
import os
import re
from pathlib import Path
from typing import Any

from mkdocs.structure.files import File, Files

ROOT = Path(__file__).resolve().parents[2]
FACES = ("metrics", "plots", "testing", "pytest_plugin")  # public, and imported by their own names


def on_files(files: Files, config: Any) -> Files:
    """Add the references and the pictures."""
    files.append(File.generated(config, "reference/cli.md", content=command_line()))
    files.append(File.generated(config, "reference/python.md", content=python_reference()))
    for name, content in pictures().items():
        files.append(File.generated(config, f"pictures/{name}", content=content))
    return files


def on_page_markdown(markdown: str, **_: Any) -> str:
    """Links that leave docs/ for the repository's own files lead nowhere on the site."""
    return re.sub(r"\[([^\]]*)\]\(\.\./[^)]*\)", r"\1", markdown)


def command_line() -> str:
    """Every command's own help."""
    os.environ["COLUMNS"] = "110"
    overview = _help()
    names = re.findall(r"^    ([a-z-]+)(?:\s|$)", overview, re.MULTILINE)
    parts = ["# Command line", "What `--help` says, command by command.", f"```text\n{overview}```"]
    parts += [f"## fairaudit {name}\n\n```text\n{_help(name)}```" for name in names]
    return "\n\n".join(parts) + "\n"


def _help(*command: str) -> str:
    from fairaudit.cli import main

    text = io.StringIO()
    with contextlib.redirect_stdout(text), contextlib.suppress(SystemExit):
        main([*command, "--help"])
    return text.getvalue()


def python_reference() -> str:
    """Every public name, from its docstring."""
    from fairaudit import _HOME

    parts = [
        "# Python",
        "What `import fairaudit as fa` offers lives in the modules below; names in the table are reachable as `fa.NAME`.",
        "| name | module |\n| --- | --- |\n" + "\n".join(f"| `{name}` | `{home}` |" for name, home in sorted(_HOME.items())),
    ]
    parts += [f"::: {home}" for home in dict.fromkeys(_HOME.values())]
    parts += [f"::: fairaudit.{name}" for name in FACES]
    return "\n\n".join(parts) + "\n"


def pictures() -> dict[str, bytes]:
    """Pictures that pages show, drawn afresh."""
    from fairaudit import Law, calibrate, certify, plots
    from fairaudit.tables.examples import example

    table = example("ucb-admissions").table()
    law = Law.from_counts(table, decision="Admit", group="Gender", context="Dept", count="Freq")
    result = certify(law, {"Admitted": 1}, max_local_ratio="3/2")
    found = [calibrate(max_log=t, groups=16, gamma=1, tau="0.3") for t in ("0.05", "0.1", "0.2", "0.4", "0.7", "1")]
    drawn = {
        "expectations": plots.plot_expectations(result),
        "bounds": plots.plot_bounds(result),
        "calibration": plots.plot_truth_kept(found),
    }
    contents = {}
    for name, axes in drawn.items():
        picture = io.BytesIO()
        axes.figure.savefig(picture, format="png", dpi=120, bbox_inches="tight")
        contents[f"{name}.png"] = picture.getvalue()
    return contents
