"""The gate of the GitHub Action (``action.yml``): certify, write summary, outputs and files, and fail where ``fail-on`` says so.

Everything that a workflow gives arrives in the environment and is passed on as arguments of a process: no shell sees it. While it is
printed, the runner is told to take no line for a command.
"""

from __future__ import annotations

import json
import os
import secrets
import shlex
import subprocess
import sys
import tempfile
from collections.abc import Mapping
from pathlib import Path
from typing import Any, NamedTuple

from fairaudit.certificates.certificate import FORMAT
from fairaudit.reports.content import describe
from fairaudit.reports.markdown import prose
from fairaudit.reports.overview import of_content
from fairaudit.words import plain

FAILS = {"exceeds": (1,), "inconclusive": (1, 3), "never": ()}
"""Exit codes of `fairaudit certify` at which the job stops."""

OURS = ("-o", "--output", "--report", "--format")
LONGEST_SUMMARY = 1_000_000
"""Bytes; the runner refuses summaries of more than a mebibyte."""


class Found(NamedTuple):
    """What the gate found."""

    code: int
    verdict: str
    sentence: str
    notes: tuple[str, ...] = ()


def main(given: Mapping[str, str]) -> int:
    """Do the work and give the exit code of the step."""
    folder = Path(tempfile.mkdtemp(prefix="fairness-", dir=given["RUNNER_TEMP"]))
    fail_on = given.get("GATE_FAIL_ON", "") or "inconclusive"
    if fail_on not in FAILS:
        found = Found(2, "error", f"fail-on is {fail_on!r}; exceeds, inconclusive or never is expected")
    else:
        found = certify(given, folder)
    text = report(folder) if found.verdict != "error" else ""
    summary = folder.with_name(f"{folder.name}.md")
    said = summarised(given.get("GATE_NAME", ""), found, text)
    summary.write_text(said, "utf-8")
    with Path(given["GITHUB_STEP_SUMMARY"]).open("a", encoding="utf-8") as file:
        file.write(cut(said, LONGEST_SUMMARY))
    written = {name: str(folder / name) if (folder / name).is_file() else "" for name in ("certificate.json", "page.html")}
    put_outputs(
        Path(given["GITHUB_OUTPUT"]),
        verdict=found.verdict,
        sentence=plain(found.sentence),
        certificate=written["certificate.json"],
        page=written["page.html"],
        folder=str(folder),
        summary=str(summary),
    )
    stops = found.verdict == "error" or found.code in FAILS[fail_on]
    tell(found, stops=stops)
    return found.code if stops else 0


def certify(given: Mapping[str, str], folder: Path) -> Found:
    """Run `fairaudit certify`; whatever leaves no answer is an error, with what it said."""
    files = [line.strip() for line in given.get("GATE_FILE", "").splitlines() if line.strip()]
    try:
        arguments = shlex.split(given.get("GATE_ARGUMENTS", ""))
    except ValueError as error:
        return Found(2, "error", f"arguments cannot be read: {error}")
    taken = next((word for word in arguments if word.partition("=")[0] in OURS or word.startswith("-o")), None)
    if taken is not None:
        return Found(2, "error", f"arguments has {taken}, which the action sets itself; its outputs name certificate and page")
    for name in ("max-local-ratio", "max-global-ratio"):
        limit = given.get(f"GATE_{name.upper().replace('-', '_')}", "").strip()
        arguments += [f"--{name}={limit}"] if limit else []
    named = [f"./{name}" if name.startswith("-") else name for name in files]
    done = run("certify", *named, *arguments, "-o", str(folder / "certificate.json"), "--format", "json")
    if done.stdout and (folder / "certificate.json").is_file():
        answer = json.loads(done.stdout)
        return Found(done.returncode, answer["verdict"], sentence(answer), tuple(answer["notes"]))
    said = done.stderr.strip().splitlines()
    return Found(2, "error", said[-1].removeprefix("fairaudit: ") if said else "these arguments make no certificate")


def sentence(answer: Mapping[str, Any]) -> str:
    """The answer as the summary has it: the verdict from the pair that decided; of other documents, and without the table, their own."""
    document = answer["result"]
    found = of_content(describe(document)) if document.get("format") == FORMAT else None
    return answer["sentence"] if found is None else " ".join((*found.cautions, *found.sentences))


def report(folder: Path) -> str:
    """Write the page, and give the same as markdown; each is checked first."""
    certificate, table = folder / "certificate.json", folder / "certificate.table.jsonl"
    beside = ["--table", str(table)] if table.exists() else []
    run("report", str(certificate), *beside, "-o", str(folder / "page.html"))
    return run("report", str(certificate), *beside, "--format", "markdown").stdout


def run(*words: str) -> subprocess.CompletedProcess[str]:
    """Run a command of the fairaudit that this Python has, whatever lies in the folder that is worked in."""
    return subprocess.run(
        [sys.executable, "-P", "-X", "utf8", "-m", "fairaudit", *words], capture_output=True, encoding="utf-8", check=False
    )


def summarised(name: str, found: Found, text: str) -> str:
    """The summary: the name, what stands first in the report, and the rest folded."""
    title = f"**{prose(plain(name) or 'Fairness gate')}**\n\n"
    if not text:
        return f"{title}## Fairness audit: {found.verdict}\n\n{prose(plain(found.sentence))}\n"
    first, *sections = text.split("\n### ")
    shown = "\n### ".join([first, *sections[:1]])
    rest = "".join(f"### {section}\n" for section in sections[1:])
    folded = f"\n<details><summary>All figures, what they rest on, and how to verify them</summary>\n\n{rest}\n</details>\n" if rest else ""
    return f"{title}{shown}\n{folded}"


def cut(text: str, most: int) -> str:
    """The lines that fit."""
    if len(text.encode("utf-8")) <= most:
        return text
    kept = text.encode("utf-8")[:most].decode("utf-8", "ignore").rpartition("\n")[0]
    return f"{kept}\n\n{'</details>' if '<details>' in kept else ''}\n\nThe rest stands on the page, which is kept with the certificate.\n"


def put_outputs(path: Path, **outputs: str) -> None:
    """Write the outputs of the step; no value can end its own."""
    with path.open("a", encoding="utf-8") as file:
        for name, value in outputs.items():
            end = secrets.token_hex(16)
            file.write(f"{name}<<{end}\n{value}\n{end}\n")


def tell(found: Found, *, stops: bool) -> None:
    """Print what was found; only the annotation is a command."""
    token = secrets.token_hex(16)
    print(f"::stop-commands::{token}")
    for line in (f"{found.verdict}: {found.sentence}", *(f"note: {note}" for note in found.notes)):
        print(plain(line))
    print(f"::{token}::")
    sentence = found.sentence
    if found.verdict == "none":
        sentence = f"No target was set, so that this gate stops nothing. {sentence}"
    if stops or found.verdict != "within":
        said = plain(sentence).replace("%", "%25")
        print(f"::{'error' if stops else 'warning'} title=Fairness gate, {found.verdict}::{said}")


if __name__ == "__main__":
    sys.exit(main(os.environ))
