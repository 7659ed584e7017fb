"""Print the lowest releases that pyproject.toml allows, as constraints for pip; ``make minimum`` runs the tests on them."""

from __future__ import annotations

import re
import sys
import tomllib
from pathlib import Path

PROJECT = Path(__file__).resolve().parents[1] / "pyproject.toml"
NOT_RUN = ("lint", "docs", "dev")
"""Extras whose tools no test uses."""


def lowest(text: str) -> list[str]:
    """Return ``name==lower bound`` of what the package and its extras require; a requirement without one bound is an error."""
    project = tomllib.loads(text)["project"]
    extras = project["optional-dependencies"]
    required = [*project["dependencies"], *(each for name in extras if name not in NOT_RUN for each in extras[name])]
    bounds: dict[str, str] = {}
    for requirement in required:
        found = re.fullmatch(r"([A-Za-z0-9._-]+)(?:\[[\w,]+\])?(?:>=([\w.]+))?(?:; \w+ [<=]+ '[\w.]+')?", requirement)
        if found is None or (found[2] is None) != (found[1] == project["name"]):
            raise ValueError(f"pyproject.toml requires {requirement!r}, and NAME>=VERSION is expected")
        if found[2] is not None and bounds.setdefault(found[1], found[2]) != found[2]:
            raise ValueError(f"pyproject.toml has two lower bounds of {found[1]}, {bounds[found[1]]} and {found[2]}; one is expected")
    return sorted(f"{name}=={version}" for name, version in bounds.items())


if __name__ == "__main__":
    sys.stdout.write("\n".join(lowest(PROJECT.read_text("utf-8"))) + "\n")
