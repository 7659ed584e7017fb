"""What each claim of a certificate has to list under `assumptions`, read from the pages of the format a second time."""

from __future__ import annotations

import contextlib
import re
from functools import cache
from pathlib import Path
from typing import Any

DOCS = Path(__file__).parent.parent / "docs"
PAGES = ("certificate", "certificate-policy", "certificate-samples", "certificate-monitor", "certificate-worst-case")
BY_RATIO = {"local_ratio": "local", "global_ratio": "global"}


@cache
def sentences() -> dict[str, str]:
    """The sentences by name, from the tables under the headings "Assumptions"."""
    found: dict[str, str] = {}
    for page in PAGES:
        text = (DOCS / f"{page}.md").read_text("utf-8")
        for part in re.findall(r"^#+ Assumptions\n(.*?)(?=^#|\Z)", text, re.MULTILINE | re.DOTALL):
            found |= dict(re.findall(r"^\| `([a-z-]+)` \| (.+?) \|", part, re.MULTILINE))
    return found


def needed(claim: dict[str, Any], document: dict[str, Any]) -> list[str]:
    """The names of what a claim needs, with the numbers for the places left open."""
    said = sentences()
    names = ["fresh"] if document["subject"]["kind"] == "policy" else []
    if claim["scope"].startswith("population at confidence "):
        return [said[name] for name in names] + _of_interval(claim, document)
    if claim["by"] in ("T5", "T5-decision") and claim["scope"] == "any policy behind this filter":
        names.append("stated-population")
    found = [said[name] for name in names]
    if claim["scope"].endswith("that keeps the declared floor") and "tau" in document["subject"].get("declared", {}):
        found.append(said["declared-floor"].replace("{τ_d}", document["subject"]["declared"]["tau"]))
    return found


def _of_interval(claim: dict[str, Any], document: dict[str, Any]) -> list[str]:
    said, name = sentences(), BY_RATIO[claim["quantity"]]
    interval = document["intervals"].get(name)
    if interval is None:
        return []
    low, high = interval["limits"] or ("0", document["subject"]["utility"]["gamma"])
    limits = said["range"].replace("{low}", low).replace("{high}", high)
    if interval["limits"] is None and document["subject"]["table"].get("header", {"utility": ()})["utility"] is None:
        limits = said["own-range"]
    if interval["method"] == "betting":
        names = ["own-past" if interval["region"] == "box" else "past", "order", *(["mix"] if name == "global" else [])]
    elif name == "global":
        names = ["draws", "stated-population" if document["subject"]["kind"] == "policy" else "pooled"]
    else:
        names = ["units" if "units" in interval else "draws"]
    names += ["chosen", *(["cells"] if interval["independent"] else [])]
    return [limits, *(said[name] for name in names)]


def complete(document: dict[str, Any]) -> dict[str, Any]:
    """Write what each claim has to list into a document, as far as that has the shape of a certificate."""
    with contextlib.suppress(KeyError, TypeError, ValueError, AttributeError):
        for claim in document["claims"]:
            claim["assumptions"] = needed(claim, document)
    return document
