"""The house as it is told and as it is: floors, names, sizes, and where each module is tested."""

from __future__ import annotations

import re
import tomllib
from pathlib import Path

import fairaudit

ROOT = Path(__file__).resolve().parents[2]
PACKAGE = ROOT / "fairaudit"
CONTRACTS = tomllib.loads((ROOT / "pyproject.toml").read_text("utf-8"))["tool"]["importlinter"]["contracts"]
BESIDE = {"checker", "plugins", "testing", "__main__", "__init__"}


def rooms() -> set[str]:
    """Folders and modules directly under the package."""
    folders = {path.name for path in PACKAGE.iterdir() if path.is_dir() and any(path.rglob("*.py"))}
    return folders | {path.stem for path in PACKAGE.glob("*.py")}


def told() -> list[set[str]]:
    """The floors of the page, from the top down."""
    page = (ROOT / "docs" / "architecture.md").read_text("utf-8")
    table = page.split("| floor | promise |")[1].split("\n\n")[0]
    first = [line.split("|")[1] for line in table.splitlines()[2:]]
    return [{name.removesuffix(".py") for name in re.findall(r"`([\w.]+)/?`", cell)} for cell in first]


def modules() -> list[Path]:
    return sorted(path for path in PACKAGE.rglob("*.py") if path.name != "__main__.py")


def test_page_contract_and_folders_tell_one_story() -> None:
    contract = [set(re.split(r" [|:] ", layer)) for layer in CONTRACTS[0]["layers"]]
    assert contract == told()
    assert set.union(*told()) | BESIDE == rooms()


def test_the_page_names_no_file_that_is_not_there() -> None:
    page = (ROOT / "docs" / "architecture.md").read_text("utf-8")
    there = ["/" + path.relative_to(ROOT).as_posix() for path in ROOT.rglob("*.py") if ".venv" not in path.parts]
    named = {name for name in re.findall(r"`([\w./]+\.py)`", page) if "/a/" not in name}  # a stands for any package
    assert {name for name in named if not any(path.endswith(f"/{name}") for path in there)} == set()


def test_no_module_is_long() -> None:
    """500 lines in the checker, which is to be read from the top to the bottom; 800 elsewhere."""
    lengths = {path.relative_to(PACKAGE).as_posix(): len(path.read_text("utf-8").splitlines()) for path in modules()}
    assert {name: n for name, n in lengths.items() if n > (500 if name.startswith("checker/") else 800)} == {}


def test_the_navigation_plug_in_is_thin() -> None:
    """What a library does, the library does."""
    assert sum(len(path.read_text("utf-8").splitlines()) for path in (PACKAGE / "plugins" / "navigation").glob("*.py")) <= 3000


def test_no_room_hides_a_public_function() -> None:
    assert {name for name in fairaudit.__all__ if callable(getattr(fairaudit, name))} & rooms() == set()


def test_every_package_says_what_it_is_for() -> None:
    packages = list(PACKAGE.rglob("__init__.py"))
    assert [path for path in packages if not path.read_text("utf-8").startswith('"""')] == []


def test_tests_mirror_the_packages() -> None:
    """A test file bears the name of the module that it tests, or of its package; suites of the whole house have a folder of their own."""
    proved = {f"t{int(path.stem[1:]):02}" for path in (ROOT / "proofs" / "theories").glob("T*.v") if path.stem[1:].isdigit()}
    strangers = []
    for path in sorted((ROOT / "tests").rglob("test_*.py")):
        folder = path.parent.relative_to(ROOT / "tests")
        if folder.parts and folder.parts[0] in {"whole", "validity", "benchmarks", "golden"}:
            continue
        name = path.stem.removeprefix("test_")
        fits = (PACKAGE / folder / f"{name}.py").is_file() or (PACKAGE / folder / name).is_dir() or name.split("_of_")[-1] == folder.name
        if not fits and not (folder.name == "theorems" and name in proved):  # the code of some theorems stands elsewhere
            strangers.append(path.relative_to(ROOT).as_posix())
    assert strangers == []


def test_every_module_has_an_obvious_test_file() -> None:
    untested = []
    for path in modules():
        place = ROOT / "tests" / path.parent.relative_to(PACKAGE)
        if path.name != "__init__.py" and not any((place / f"test_{name}.py").is_file() for name in (path.stem, place.name)):
            untested.append(path.relative_to(ROOT).as_posix())
    assert untested == []


def test_every_room_but_the_kit_is_closed_to_plug_ins() -> None:
    """The contract names all rooms, so that a new one is closed too; of the command line plug-ins take options and output alone."""
    (contract,) = (contract for contract in CONTRACTS if contract.get("source_modules") == ["fairaudit.plugins"])
    closed = set(contract["forbidden_modules"])
    kit_of_logs = ("chat", "choices", "replies")
    assert contract["ignore_imports"] == [f"fairaudit.plugins.** -> fairaudit.tables.evaluations.{name}" for name in kit_of_logs]
    kit = {"errors", "words", "files", "libraries", "cli", "plugins", "exact", "__init__", "__main__"}
    exact = {path.stem for path in (PACKAGE / "exact").glob("*.py")} - {"__init__", "rationals"}
    assert closed == {f"fairaudit.{room}" for room in rooms() - kit} | {f"fairaudit.exact.{name}" for name in exact}
    text = "\n".join(path.read_text("utf-8") for path in (PACKAGE / "plugins").rglob("*.py"))
    assert set(re.findall(r"fairaudit\.cli[.\w]*(?= import)", text)) == {"fairaudit.cli", "fairaudit.cli.options", "fairaudit.cli.output"}
