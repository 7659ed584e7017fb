"""The notebooks of the documentation run in a real kernel, beside the gallery and nothing else, and print what they say that they print."""

from __future__ import annotations

import os
import re
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
NOTEBOOKS = sorted((ROOT / "docs" / "notebooks").glob("*.ipynb"))

nbformat = pytest.importorskip("nbformat", reason="nbformat is not installed (it is in the extra test)")
nbclient = pytest.importorskip("nbclient", reason="nbclient is not installed (it is in the extra test)")
pytest.importorskip("ipykernel", reason="ipykernel is not installed (it is in the extra test)")


def test_there_is_one_for_each_reader_and_the_site_shows_it() -> None:
    assert [path.stem for path in NOTEBOOKS] == ["benchmark", "engineer", "journalist", "names", "rankings", "regulator"]
    nav = (ROOT / "mkdocs.yml").read_text("utf-8")
    assert all(f"notebooks/{path.stem}.md" in nav for path in NOTEBOOKS)


@pytest.mark.parametrize("path", NOTEBOOKS, ids=lambda path: path.stem)
def test_notebooks_hold_no_outputs(path: Path) -> None:
    notebook = nbformat.read(path, as_version=4)
    nbformat.validate(notebook)
    cells = [cell for cell in notebook.cells if cell.cell_type == "code"]
    assert [cell for cell in cells if cell.outputs or cell.execution_count is not None] == []


@pytest.mark.filterwarnings("default::DeprecationWarning", "default::RuntimeWarning")  # those of the client are not ours
@pytest.mark.parametrize("path", NOTEBOOKS, ids=lambda path: path.stem)
def test_notebooks_run(path: Path, tmp_path: Path) -> None:
    """Nothing goes to stderr; a comment ``# …`` after a print is what it prints, as on the pages."""
    notebook = nbformat.read(path, as_version=4)
    (tmp_path / "gallery").symlink_to(ROOT / "docs" / "gallery")
    (here := tmp_path / "notebooks").mkdir()
    client = nbclient.NotebookClient(notebook, timeout=120, resources={"metadata": {"path": str(here)}})
    commands = f"{Path(sys.executable).parent}{os.pathsep}{os.environ.get('PATH', '')}"
    client.execute(env={**os.environ, "PYTHONPATH": str(ROOT), "PATH": commands})
    told = 0
    for cell in notebook.cells:
        streams = [each for each in cell.get("outputs", ()) if each.output_type == "stream"]
        assert "".join(each.text for each in streams if each.name == "stderr") == ""
        printed = "".join(each.text for each in streams)
        for expected in re.findall(r"^print\(.*\)\s+# (.+)$", cell.source, re.MULTILINE):
            assert expected in printed.splitlines()
            told += 1
    assert told >= 3
