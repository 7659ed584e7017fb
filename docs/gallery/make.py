"""Make the gallery: every page from its entry, by running the commands that it shows on the committed data.

``python docs/gallery/make.py`` writes pages, certificates and pictures beside this file; with a folder as argument it writes them there.
An entry, ``entries/NAME.md``, is a page in Jinja with a head in TOML between lines of ``+++``. Blocks ``sh`` and ``python`` are run in
order, in a folder that holds the data of the entry and nothing else; figures in the text are taken from the certificates that they write.
"""

from __future__ import annotations

import contextlib
import hashlib
import io
import json
import os
import re
import shlex
import shutil
import subprocess
import sys
import tempfile
import textwrap
import tomllib
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from fractions import Fraction
from pathlib import Path
from typing import Any

HERE = Path(__file__).resolve().parent
ORDER = HERE / "entries" / "order.txt"
"""Names of the entries, one a line, as the index shows them."""
WIDTH = 80
"""Signs in a line of a page of the site."""
COLUMNS = re.compile(r"\S {2,}\S.*\S {2,}\S")
ACCEPTED = {0, 1, 3}
"""Exit codes of an answer, whatever its verdict."""
BLOCK = re.compile(r"^```(sh|python)\n(.*?)^```$", re.MULTILINE | re.DOTALL)
FORMATS = ("fairaudit-certificate/1", "fairaudit-subgroups/1")
"""Those of certificates."""
ATTESTATION = "attestation.json"
MADE = 1795478400
"""The moment that attestations state, 2026-11-24, so that they are the same bytes each time."""
ROADS = HERE / "roads.json"
"""Of each certificate what each road covers."""
UNREAD = "2"
"""What the verified program ends with where it does not read a certificate."""
UNKNOWN = "?"
KEPT = (".json", ".html", ".svg", ".png", ".csv", ".toml")
"""Endings of what a reader can download."""


@dataclass(frozen=True)
class Entry:
    """An entry as it is written: its head and its page in Jinja."""

    name: str
    head: Mapping[str, Any]
    text: str

    @property
    def commands(self) -> list[list[str]]:
        """The commands of its blocks, as words."""
        blocks = [text for language, text in BLOCK.findall(self.text) if language == "sh"]
        return [shlex.split(line) for text in blocks for line in text.replace("\\\n", " ").splitlines() if line.strip()]


@dataclass(frozen=True)
class Made:
    """What an entry became: the page, and the files beside it."""

    page: str
    files: Mapping[str, bytes]
    roads: Mapping[str, Any]


def entries() -> list[Entry]:
    """All entries, in the order of the index."""
    return [read(name) for name in ORDER.read_text("utf-8").split()]


def read(name: str) -> Entry:
    """One entry."""
    _, head, text = (HERE / "entries" / f"{name}.md").read_text("utf-8").split("+++\n", 2)
    return Entry(name, tomllib.loads(head), text.strip() + "\n")


def made(entry: Entry, known: Mapping[str, Any]) -> Made:
    """Run an entry in a fresh folder, and write its page; what is known of the roads of a certificate is not found out again."""
    with tempfile.TemporaryDirectory() as folder:
        given = {Path(each["file"]) for each in entry.head["data"]}
        for name in sorted(given):
            (Path(folder) / name).parent.mkdir(exist_ok=True)
            shutil.copy(HERE / "data" / name, Path(folder) / name)
        with contextlib.chdir(folder):
            screens = run(entry)
            found = {path for pattern in ("*", *entry.head.get("keep", ())) for path in Path().glob(pattern) if path.suffix in KEPT}
            written = {path.as_posix(): path.read_bytes() for path in sorted(found - given)}
    values = {**figures(written), "screen": lambda number, first="", last="": part(screens[number], first, last)}
    certificates = {f"{entry.name}/{name}": text for name, text in written.items() if is_certificate(name, text)}
    roads = {name: road(text, known.get(name)) for name, text in certificates.items()}
    page = rendered(head_of(entry) + entry.text + foot_of(entry, written, roads), values)
    return Made(page, {f"{entry.name}/{name}": text for name, text in written.items()}, roads)


def figures(written: Mapping[str, bytes]) -> dict[str, Figures]:
    """What a page takes figures from: its certificates, by their names without the ending, with ``_`` for other dots."""
    return {Path(name).stem.replace(".", "_"): Figures(json.loads(text)) for name, text in written.items() if is_certificate(name, text)}


def is_certificate(name: str, text: bytes) -> bool:
    """Whether a file is a certificate that the entry itself wrote; folders of publications hold copies."""
    return "/" not in name and name.endswith(".json") and json.loads(text).get("format") in FORMATS


def run(entry: Entry) -> list[str]:
    """What each command printed; Python shares one namespace."""
    from fairaudit.cli import main

    screens: list[str] = []
    namespace: dict[str, Any] = {}
    for language, text in BLOCK.findall(entry.text):
        if language == "python":
            exec(compile(text, entry.name, "exec"), namespace)  # noqa: S102
            continue
        for line in text.replace("\\\n", " ").splitlines():
            program, *words = shlex.split(line)
            if program != "fairaudit":
                raise ValueError(f"{entry.name}: {program} is not run here; write such a line in a block of another kind")
            said, noted = io.StringIO(), io.StringIO()
            with contextlib.redirect_stdout(said), contextlib.redirect_stderr(noted):
                code = main(words)
            if code not in ACCEPTED:
                raise ValueError(f"{entry.name}: {line}\nended with {code}: {noted.getvalue()}")
            screens.append(said.getvalue().rstrip())
    return screens


def part(screen: str, first: str, last: str) -> str:
    """Lines of a screen, from the one that begins with `first` to the one before that which begins with `last`; long ones are folded."""
    lines = screen.splitlines()
    start = next(number for number, line in enumerate(lines) if line.startswith(first))
    stop = next((number for number, line in enumerate(lines) if last and number > start and line.startswith(last)), len(lines))
    shown = "\n".join(map(folded, lines[start:stop])).rstrip()
    return f"```text\n{'…' + chr(10) if start else ''}{shown}{chr(10) + '…' if stop < len(lines) else ''}\n```"


def folded(line: str, end: str = "") -> str:
    """A line in parts that are no longer than a page of the site is wide; a row of columns stays one."""
    if len(line) <= WIDTH or COLUMNS.search(line):
        return line
    indent = " " * (len(line) - len(line.lstrip()) + 4)
    parts = textwrap.wrap(line, WIDTH, subsequent_indent=indent, break_long_words=False, break_on_hyphens=False)
    return f"{end}\n".join(parts)


def rendered(text: str, values: Mapping[str, Any]) -> str:
    """A text with its figures."""
    from jinja2 import Environment, StrictUndefined

    frame = Environment(undefined=StrictUndefined, autoescape=False, keep_trailing_newline=True)  # noqa: S701 (markdown)
    frame.filters.update(FILTERS)
    return frame.from_string(text).render(values)


def head_of(entry: Entry) -> str:
    """Title, question, and where the data are from."""
    head = entry.head
    lines = [f"# {head['title']}\n", f"{head['question']}\n", "## The data\n"]
    for each in head["data"]:
        source = HERE / "data" / each["file"]
        lines.append(f"* [`{each['file']}`](data/{each['file']}): {each['what']}")
        lines.append(f"    * Source: [{each['source']}]({each['url']})")
        lines.append(f"    * Licence: {each['licence']}")
        lines.append(f"    * SHA-256: `{hashlib.sha256(source.read_bytes()).hexdigest()}`")
    return "\n".join(lines) + "\n\n"


def foot_of(entry: Entry, written: Mapping[str, bytes], roads: Mapping[str, Any]) -> str:
    """What can be downloaded, how it is checked, and what each road leaves out."""
    certificates = [name for name, text in written.items() if is_certificate(name, text)]
    statement = json.loads(written[ATTESTATION])
    predicate = statement["predicate"]
    again = "" if "plugin" in predicate["options"].get("audit", {}).get("policy", {}) else " --recount"
    logs = [source["name"] for source in predicate["sources"]] if again else []
    return FOOT.format(
        links=", ".join(f"[{name}]({entry.name}/{name})" for name in written),
        certificates=folded(" ".join(["fairaudit verify", *certificates]), " \\"),
        attested=folded(
            " ".join(["fairaudit verify", statement["subject"][0]["name"], "--attestation", f"{ATTESTATION}{again}", *logs]), " \\"
        ),
        recounted=entry.head.get("attested", RECOUNTED if again else SUPPLIED),
        roads="\n".join(row(Path(name).name, found) for name, found in roads.items()),
    )


FOOT = """
## Check it

Download {links}. A page opens in a browser and checks itself there.

```console
{certificates}
{attested}
```

The first line computes every figure again with none of the code that wrote it ([more](../verify.md)).
The second also checks the [attestation](../attestation.md), which says of which files and how the certificate was made. {recounted}
The attestation is not signed: whoever has the certificate could have written it.

Two more roads take [less on trust](../trust.md), and leave some statements to the first.
Each counts statements in its own way. The file for Coq looks at no digest and at no list of assumptions either:

| certificate | `verify` finds true | the verified program | a file for Coq |
| --- | --- | --- | --- |
{roads}
"""
RECOUNTED = "It counts the data again, too, and finds the same table."
SUPPLIED = "What a plug-in supplied cannot be counted again: certify the audit file anew."


# What each road covers

SCRIPT = """
const fs = require("fs");
(0, eval)(fs.readFileSync(process.argv[1], "utf-8"));
fs.writeSync(1, globalThis.fairauditVerified(fs.readFileSync(0, "latin1")));
"""
INTERVALS = ("binomial", "hoeffding-kl", "paired-betting")
"""Methods of intervals: what is left out is told by the quantity."""
LEFT = {
    **dict.fromkeys(("local_ratio", "intervals.local"), "the interval within contexts"),
    **dict.fromkeys(("global_ratio", "intervals.global"), "the interval over all contexts"),
    **dict.fromkeys(
        ("local_difference", "global_difference", "intervals.local_difference", "intervals.global_difference"), "intervals of differences"
    ),
    "T13": "the greatest ratio over many policies (T13)",
    "T14": "hidden factors (T14)",
    **dict.fromkeys(("T15", "subject.unknown_shares"), "people of unknown groups (T15)"),
    **dict.fromkeys(("subject.max_drift", "T16"), "drift (T16)"),
    "changed": "the change",
    "subject.evaluation": "how the log was read",
    "subject.preparation": "what was left out",
    "subject.spellings": "spellings of labels",
    "subject.undecided": "undecided decisions",
    "subject.class": "whether the utility is in the class",
    "subject.privacy": "the privacy of the filters",
    "subject.declared": "what was declared",
    "subject.table.cells": "the size of the table",
    "metrics.unfiltered": "the figures without the filter",
    "the assumptions of the claims": "the assumptions",
    **dict.fromkeys(("targets", "verdict"), "the verdict"),
}
"""What a road leaves out, by the place of a statement, the method of a claim or, of an interval, its quantity."""


def road(raw: bytes, known: Mapping[str, Any] | None = None) -> Mapping[str, Any]:
    """How many statements of a certificate each road finds true, and what it leaves out; nothing where it does not read the certificate."""
    import fairaudit as fa
    from fairaudit.errors import InputError
    from fairaudit.verified.coq_file import coq_file

    digest = hashlib.sha256(raw).hexdigest()
    if known and known["sha256"] == digest:
        return known
    document = json.loads(raw)
    found: dict[str, Any] = {"sha256": digest, "verify": len(fa.verify(document).findings), "program": None, "coq": None}
    code, *lines = in_node(raw).splitlines()
    if code != UNREAD:
        open_ = [line.split(": ", 1)[1] for line in lines if line.startswith("not covered: ")]
        found["program"] = {"true": sum(line.startswith("true: ") for line in lines), "left": kinds(open_, document)}
    try:
        file = coq_file(document, raw)
    except InputError:
        return found
    _, _, after = file.text.partition("(* The certificate also states what is not proved here: *)\n")
    listed = [line.removeprefix("(* ") for line in after.partition("\n\n")[0].splitlines()]
    found["coq"] = {"true": file.proved, "left": kinds(listed, document)}
    return found


def in_node(raw: bytes) -> str:
    """What the verified program, as JavaScript in the page of a report, says of a certificate."""
    import fairaudit.reports

    page = Path(fairaudit.reports.__file__).with_name("verified.js")
    return subprocess.run(["node", "-e", SCRIPT, str(page)], input=raw, capture_output=True, check=True).stdout.decode("ascii")


def kinds(statements: list[str], document: Mapping[str, Any]) -> list[str]:
    """Kinds of statements, each once, in the order of `LEFT`."""
    found = set()
    for statement in statements:
        place = re.split(r"[\[:]", statement)[0]
        if place == "claims":
            claim = document["claims"][int(statement.removeprefix("claims[").split("]")[0])]
            place = claim["quantity"] if claim["by"] in INTERVALS else claim["by"]
        if place != "intervals":  # of which the claims about them say more
            found.add(LEFT[place])
    return [kind for kind in dict.fromkeys(LEFT.values()) if kind in found]


def row(name: str, found: Mapping[str, Any]) -> str:
    """A certificate in the table of roads."""
    cells = [f"`{name}`", f"all {found['verify']}"]
    for each in (found["program"], found["coq"]):
        left = "" if each is None or not each["left"] else f"; not {', '.join(each['left'])}"
        cells.append("does not read it" if each is None else f"{each['true']}{left}")
    return f"| {' | '.join(cells)} |"


# Figures


class Figures:
    """Figures of a certificate, by their paths."""

    def __init__(self, document: Mapping[str, Any]) -> None:
        self.document = document

    def __call__(self, path: str) -> Any:
        """What stands at a path such as ``metrics.local.ratio``; text that is a number becomes one."""
        found: Any = self.document
        for name in path.split("."):
            found = found[int(name) if name.isdigit() else name]
        return exact(found)

    def cell(self, *labels: str) -> Cell:
        """The decisions of all rows that bear these labels of contexts and groups, in any order; ``?`` is the group of those without."""
        table = self.document["subject"]["table"]
        header = table["header"]
        worth = [Fraction(value) for value in header["utility"]]
        chosen: list[list[str]] = []
        for row in table["rows"]:
            held = [*(header["groups"][row["group"]] if "group" in row else [UNKNOWN]), *header["contexts"][row["context"]]]
            if all(label in held for label in labels) and (UNKNOWN in labels or UNKNOWN not in held):
                chosen.append(row["weights"] if "group" in row else row["unknown"])
        if not chosen:
            raise KeyError(labels)
        counts = [sum(map(Fraction, column), Fraction()) for column in zip(*chosen, strict=True)]
        return Cell(sum(counts, Fraction()), sum((count * value for count, value in zip(counts, worth, strict=True)), Fraction()))

    def claim(self, quantity: str, relation: str, number: int = 0) -> Any:
        """The value of a claim of a quantity, by its relation; of several the one with this number."""
        found = [each for each in self.document["claims"] if (each["quantity"], each["relation"]) == (quantity, relation)]
        return exact(found[number]["value"])


@dataclass(frozen=True)
class Cell:
    """Decisions, and what they are worth together."""

    n: Fraction
    good: Fraction

    @property
    def rate(self) -> Fraction:
        """What one of them is worth in the mean."""
        return self.good / self.n


def exact(found: Any) -> Any:
    """A number where a text is one."""
    return Fraction(found) if isinstance(found, str) and re.fullmatch(r"-?\d+(/\d+)?", found) else found


def figure(value: Fraction, digits: int = 3) -> str:
    """Some digits of a number, as screens print them."""
    from fairaudit.words import approximate

    return approximate(Fraction(value), digits=digits)


def down(value: Fraction, digits: int = 4) -> str:
    """Some digits of a lower end."""
    from fairaudit.words import approximate

    return approximate(Fraction(value), "down", digits)


def up(value: Fraction, digits: int = 4) -> str:
    """Some digits of an upper end."""
    from fairaudit.words import approximate

    return approximate(Fraction(value), "up", digits)


FILTERS = {
    "figure": figure,
    "down": down,
    "up": up,
    "percent": lambda value, digits=3: f"{figure(100 * value, digits)} %",
    "whole": lambda value: f"{int(value):,}",
}


# All of them


def index(folder: Path) -> str:
    """The page that lists the entries, with their answers, of which the files stand in a folder."""
    rows = ["| audit | what came out | what it shows |", "| --- | --- | --- |"]
    for entry in entries():
        written = {path.name: path.read_bytes() for path in (folder / entry.name).glob("*.json")}
        answer = rendered(entry.head["answer"], figures(written))
        rows.append(f"| [{entry.head['title']}]({entry.name}.md) | {answer} | {entry.head['kind']} |")
    return (HERE / "entries" / "index.md").read_text("utf-8").replace("<!-- entries -->", "\n".join(rows))


@contextlib.contextmanager
def reproducible() -> Iterator[None]:
    """Attestations and pictures with the same moment, and pictures with the same names inside, each time."""
    import matplotlib

    before = os.environ.get("SOURCE_DATE_EPOCH")
    os.environ["SOURCE_DATE_EPOCH"] = str(MADE)
    try:
        with matplotlib.rc_context({"svg.hashsalt": "fairaudit"}):
            yield
    finally:
        os.environ.pop("SOURCE_DATE_EPOCH")
        if before is not None:
            os.environ["SOURCE_DATE_EPOCH"] = before


def make(target: Path) -> None:
    """Write all pages with their files into a folder."""
    roads: dict[str, Any] = {}
    with reproducible():
        for entry in entries():
            print(entry.name, flush=True)
            one = made(entry, {})
            roads |= one.roads
            shutil.rmtree(target / entry.name, ignore_errors=True)
            target.mkdir(parents=True, exist_ok=True)
            (target / f"{entry.name}.md").write_text(one.page, "utf-8")
            for name, content in one.files.items():
                (target / name).parent.mkdir(parents=True, exist_ok=True)
                (target / name).write_bytes(content)
    (target / "index.md").write_text(index(target), "utf-8")
    (target / ROADS.name).write_text(json.dumps(roads, indent=1) + "\n", "utf-8")


if __name__ == "__main__":
    make(Path(sys.argv[1]) if len(sys.argv) > 1 else HERE)
