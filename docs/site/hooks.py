"""Pages of the documentation that are made from the code and from notebooks, when the site is built."""

from __future__ import annotations

import ast
import base64
import contextlib
import functools
import io
import os
import re
import sys
import tempfile
from pathlib import Path
from typing import Any

from mkdocs.exceptions import PluginError
from mkdocs.structure.files import File, Files

ROOT = Path(__file__).resolve().parents[2]
REFERENCE = {
    "audit": ("Audit", ("audits", "measures", "theorems")),
    "certificates": ("Verify, compare, report", ("attestations", "verified", "checker", "certificates", "reports")),
    "tables": ("Tables", ("tables",)),
    "models": ("Laws, utilities, policies, filters", ("model",)),
    "filters": ("Calibrate and design", ("filters",)),
    "privacy": ("Privacy", ("privacy",)),
    "samples": ("Intervals and planning", ("inference",)),
    "worst-case": ("Worst utility", ("worst",)),
    "streams": ("Monitor", ("streams",)),
    "errors": ("Numbers and errors", ("exact", "errors")),
}
"""Pages of the reference: title, and the packages whose public names they hold."""
FACES = {
    "metrics": "Metrics",
    "plots": "Pictures",
    "pytest_plugin": "Fixture for pytest",
    "mlflow_plugin": "Evaluator for MLflow",
    "testing": "Strategies for tests",
}
"""Public modules that are imported by their own names."""
OPTION = r'<span class="option">\1</span>'
PHONE = 44
"""Letters that stand beside each other in a table on a phone."""
GOLDEN = ROOT / "tests" / "golden"
"""Pages as a browser draws them."""


def on_files(files: Files, config: Any) -> Files:
    """Add the references and the notebooks."""
    pages = {"reference/cli.md": command_line(), **python_reference()}
    for notebook in sorted((ROOT / "docs" / "notebooks").glob("*.ipynb")):
        text, pictures = executed(notebook.stem, notebook.read_text("utf-8"))
        pages[f"notebooks/{notebook.stem}.md"] = text
        for name, content in pictures.items():
            files.append(File.generated(config, f"notebooks/{name}", content=content))
    for name, text in pages.items():
        files.append(File.generated(config, name, content=text))
    for picture in GOLDEN.glob("*-desktop.png"):
        files.append(File.generated(config, f"pictures/{picture.name}", abs_src_path=str(picture)))
    return files


def on_page_markdown(markdown: str, page: Any, **_: Any) -> str:
    """Links to the repository's own files lead nowhere on the site and become text; those that bear the name of a page get its title."""
    markdown = re.sub(r"(?<=\]\()\.\./tests/golden/", "pictures/", markdown)
    markdown = re.sub(r"(?<=\]\()(notebooks/\w+)\.ipynb", r"\1.md", markdown)
    if "/" not in page.file.src_uri:
        markdown = re.sub(r"\[([^\]]*)\]\(\.\./[^)]*\)", r"\1", markdown)
    return re.sub(r"\[([\w-]+\.md)\](?=\(\1)", lambda named: f"[{_title(named[1])}]", markdown)


def _title(name: str) -> str:
    return (ROOT / "docs" / name).read_text("utf-8").split("\n", 1)[0].removeprefix("# ")


def on_page_content(html: str, page: Any, **_: Any) -> str:
    """Pictures open by themselves, options are not broken, and cells of tables know their columns, which stand before them on a phone."""
    html = re.sub(r'<img [^>]*src="([^"]*pictures/[^"]+)"[^>]*>', r'<a href="\1">\g<0></a>', html)
    html = re.sub(r"(?<!<span></span>)<code>[^<\n]*</code>", lambda code: re.sub(r"(?<![\w-])(--?\w[\w-]*)", OPTION, code[0]), html)
    html = re.sub(r"(?<!`)\bdocs/([\w-]+)\.md", r'<a href="../\1.html">\1</a>', html) if "/" in page.file.src_uri else html
    return re.sub(r"<table>.*?</thead>.*?</table>", lambda table: _with_columns(table[0]), html, flags=re.DOTALL)


def _with_columns(table: str) -> str:
    """Cells know their columns, and a table whether its words fit beside each other: not on a phone (``wide``), or nowhere (``many``)."""
    head, _, body = table.partition("</thead>")
    columns = [_text(each).replace('"', "&quot;") for each in re.findall(r"<th\b[^>]*>(.*?)</th>", head, re.DOTALL)]
    longest = [max(map(len, column.split()), default=0) for column in columns]
    rows = []
    for row in body.split("</tr>"):
        before, *cells = row.split("<td")
        start = row.count("<th")
        for at, cell in enumerate(cells, start):
            if at < len(longest):
                longest[at] = max([longest[at], *map(len, _text(cell.partition(">")[2]).split())])
        names = [*columns[start:], *[""] * len(cells)]
        rows.append("<td".join([before, *(_labelled(cell, name) for cell, name in zip(cells, names, strict=False))]))
    kind = "many" if len(columns) > 6 else "wide" if sum(longest) + 3 * len(columns) > PHONE else ""
    opened = head.replace("<table>", f'<table data-columns="{kind}">', 1) if kind else head
    return f"{opened}</thead>{'</tr>'.join(rows)}"


def _text(html: str) -> str:
    return re.sub(r"<[^>]*>", "", html).strip()


def _labelled(cell: str, column: str) -> str:
    return f' data-column="{column}"{cell}' if column else cell


def on_post_build(config: Any) -> None:
    """Stop at links that lead nowhere, in references and notebooks, too."""
    sys.path.insert(0, str(Path(__file__).parent))
    from links import broken

    found = broken(Path(config.site_dir))
    if found:
        raise PluginError("links that lead nowhere:\n" + "\n".join(found))


def command_line() -> str:
    """Every command's own help."""
    os.environ["COLUMNS"] = "80"
    overview = _help()
    names = re.findall(r"^    ([a-z-]+)(?:\s|$)", overview, re.MULTILINE)
    parts = ["# Command line", "What `--help` says, command by command.", f"``` {{ .text .help }}\n{overview}```"]
    parts += [f"## fairaudit {name}\n\n``` {{ .text .help }}\n{_help(name)}```" for name in names]
    return "\n\n".join(parts) + "\n"


def _help(*command: str) -> str:
    from fairaudit.cli import main

    text = io.StringIO()
    with contextlib.redirect_stdout(text), contextlib.suppress(SystemExit):
        main([*command, "--help"])
    return text.getvalue()


def python_reference() -> dict[str, str]:
    """A page for each group of public names and each public module, and one that lists all names."""
    import fairaudit

    names = [name for name in fairaudit.__all__ if name in fairaudit._HOME]
    packages = {name: fairaudit._HOME[name].split(".")[1] for name in names}
    where = {package: page for page, (_, held) in REFERENCE.items() for package in held}
    pages = {}
    for page, (title, held) in REFERENCE.items():
        here = sorted((name for name in names if packages[name] in held), key=lambda name: (name[0].isupper(), held.index(packages[name])))
        parts = [f"::: fairaudit.{name}" for name in here]
        pages[f"reference/{page}.md"] = "\n\n".join([f"# {title}", *parts]) + "\n"
    for name, title in FACES.items():
        pages[f"reference/{name.replace('_', '-')}.md"] = f"# {title}\n\n::: fairaudit.{name}\n    options:\n      filters: public\n"
    about = {name: getattr(fairaudit, name).__doc__ for name in names}
    about["Number"] = "A number: exact, but for a float, which is read as the decimal that it is printed as."
    rows = [_row(f"fa.{name}", f"{where[packages[name]]}.md#fairaudit.{name}", about[name]) for name in sorted(names)]
    told = {name: ast.get_docstring(ast.parse((ROOT / "fairaudit" / f"{name}.py").read_text("utf-8"))) for name in FACES}
    faces = [_row(f"fairaudit.{name}", f"{name.replace('_', '-')}.md", told[name]) for name in sorted(FACES)]
    index = [
        "# Python",
        "Every public name and what it is for; [Python, task by task](../python.md) shows them at work. `import fairaudit as fa` offers:",
        "| name | what it is |\n| --- | --- |\n" + "\n".join(rows),
        "These modules are imported by their own names:",
        "| module | what it is |\n| --- | --- |\n" + "\n".join(faces),
    ]
    return {**pages, "reference/python.md": "\n\n".join(index) + "\n"}


def _row(name: str, where: str, docstring: str | None) -> str:
    summary = (docstring or "").strip().split("\n\n")[0].replace("\n", " ").replace("``", "`").replace("|", "\\|")
    return f"| [`{name}`]({where}) | {summary} |"


@functools.cache
def executed(name: str, source: str) -> tuple[str, dict[str, bytes]]:
    """A notebook as a page, with what its cells print and draw today, and its pictures by name."""
    import nbformat
    from nbclient import NotebookClient

    notebook = nbformat.reads(source, as_version=4)
    environment = {**os.environ, "PYTHONPATH": str(ROOT), "PATH": f"{Path(sys.executable).parent}{os.pathsep}{os.environ.get('PATH', '')}"}
    with tempfile.TemporaryDirectory() as folder:
        (Path(folder) / "gallery").symlink_to(ROOT / "docs" / "gallery")
        (here := Path(folder) / "notebooks").mkdir()
        NotebookClient(notebook, timeout=120, resources={"metadata": {"path": str(here)}}).execute(env=environment)
    title, *cells = notebook.cells
    needs = "`pip install 'fairaudit-certify[plots,report]' jupyterlab pytest`"
    parts = [title.source, f"This page is a notebook: [download it]({name}.ipynb). It needs {needs}."]
    pictures: dict[str, bytes] = {}
    for cell in cells:
        parts.append(cell.source if cell.cell_type == "markdown" else f"```python\n{cell.source}\n```")
        outputs = cell.get("outputs", ())
        printed = "".join(each.text for each in outputs if each.output_type == "stream").rstrip()
        printed = re.sub(r"\x1b\[[\d;]*m", "", printed)  # colours of a terminal
        parts += [f"``` {{ .text .printed }}\n{printed}\n```"] if printed else []
        parts += [_shown(each.data, f"{name}-{len(parts)}.png", pictures) for each in outputs if each.output_type != "stream"]
    return "\n\n".join(parts) + "\n", pictures


def _shown(data: Any, name: str, pictures: dict[str, bytes]) -> str:
    """What a cell gives: HTML, a picture, or text."""
    if "text/html" in data:
        html = re.sub(r'<style scoped>.*?</style>| border="1" class="dataframe"', "", data["text/html"], flags=re.DOTALL)
        return f'<div class="output">{html}</div>'
    if "image/png" in data:
        pictures[name] = base64.b64decode(data["image/png"])
        return f"![What the cell draws]({name})"
    return f"```text\n{data['text/plain']}\n```"
