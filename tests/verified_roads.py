"""The same documents judged on three roads: the Python checker, the verified program, and its JavaScript; what may differ is said here.

The verified program judges many documents in one process: a loop around the files that ship, in `DRIVER` and in `SCRIPT`.
"""

from __future__ import annotations

import json
import re
import subprocess
from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass
from fractions import Fraction
from itertools import product
from pathlib import Path
from random import Random as Pick
from typing import Any

import over_policies
import tiers
from assumptions import complete
from certificate_changes import other_values, places, put, redigested
from certificate_kinds import FOUR, KINDS, as_bytes
from certificates import random_certificate
from class_certificates import Case, Solved, true_certificate
from evaluation_changes import audited, drawn_log
from paired_certificates import honest
from plain_certificates import make
from policy_certificates import Policy, write
from truth_certificates import random_truth_certificate

import fairaudit as fa
from fairaudit import checker

DRIVER = """
let () =
  set_binary_mode_in stdin true;
  try
    while true do
      let file = really_input_string stdin (int_of_string (input_line stdin)) in
      let lines, code = Report.of_files file None in
      Printf.printf "%d %d\\n" code (List.length lines);
      List.iter print_endline lines;
      flush stdout
    done
  with End_of_file -> ()
"""
SCRIPT = """
const fs = require("fs");
(0, eval)(fs.readFileSync(process.argv[1], "utf-8"));
const input = fs.readFileSync(0, "latin1");
const found = [];
for (let at = 0; at < input.length; ) {
  const end = input.indexOf("\\n", at);
  const next = end + 1 + Number(input.slice(at, end));
  const [code, ...lines] = globalThis.fairauditVerified(input.slice(end + 1, next)).split("\\n");
  found.push(code + " " + lines.length, ...lines);
  at = next;
}
fs.writeSync(1, found.join("\\n") + "\\n");
"""

PAGE = Path(__file__).resolve().parents[1] / "fairaudit" / "reports" / "verified.js"
TRUE, FALSE, MALFORMED, OPEN = range(4)


@dataclass(frozen=True)
class Judged:
    """An exit code, and the statements with their outcomes: true, false, or nothing where not covered."""

    code: int
    statements: tuple[tuple[str, bool | None], ...] = ()
    why: str = ""


def driver(built: Path, folder: Path) -> Path:
    """Compile the loop around the verified program."""
    (folder / "many.ml").write_text(DRIVER, "utf-8")
    program = folder / "many"
    parts = [str(built / f"{name}.cmx") for name in ("sha256", "verified", "report")]
    command = [
        "ocamlfind",
        "ocamlopt",
        "-I",
        str(built),
        "-package",
        "zarith",
        "-linkpkg",
        *parts,
        str(folder / "many.ml"),
        "-o",
        str(program),
    ]
    made = subprocess.run(command, capture_output=True, text=True)
    assert made.returncode == 0, made.stderr
    return program


def _read(output: bytes) -> Iterator[Judged]:
    lines = iter(output.decode("ascii").splitlines())
    for line in lines:
        code, count = map(int, line.split())
        found = [next(lines) for _ in range(count)]
        if code == MALFORMED or (found and found[0].startswith("nothing was judged")):
            yield Judged(code, why=found[0])
            continue
        outcomes = {"true": True, "FALSE": False, "not covered": None}
        yield Judged(code, tuple((label, outcomes[word]) for word, _, label in (each.partition(": ") for each in found)))


def _many(command: Sequence[str], documents: Sequence[bytes]) -> list[Judged]:
    framed = b"".join(b"%d\n%s" % (len(document), document) for document in documents)
    run = subprocess.run(command, input=framed, capture_output=True)
    assert run.returncode == 0, run.stderr[-2000:]
    judged = list(_read(run.stdout))
    assert len(judged) == len(documents)
    return judged


def natively(program: Path, documents: Sequence[bytes]) -> list[Judged]:
    """What the verified program says of each document."""
    return _many([str(program)], documents)


def in_script(documents: Sequence[bytes]) -> list[Judged]:
    """What its JavaScript says, which stands in the page of a report."""
    return _many(["node", "-e", SCRIPT, str(PAGE)], documents)


def in_python(document: bytes) -> Judged:
    """What the Python checker says."""
    try:
        report = checker.check(document)
    except checker.TableNeeded:
        return Judged(OPEN)
    except checker.TooMuch as error:
        return Judged(MALFORMED, why=f"too much: {error}")
    except checker.Incomplete as error:
        return Judged(MALFORMED, why=f"incomplete: {error}")
    except checker.FormatError as error:
        return Judged(MALFORMED, why=str(error))
    return Judged(FALSE if not report.ok else TRUE, tuple((finding.statement, finding.true) for finding in report.findings))


def place(statement: str) -> str:
    """Where a statement stands in the document: claims[3], metrics.local, verdict; a sentence is a place of its own."""
    found = re.match(
        r"subject\.declared\.by_context\[\d+\]|(subject|metrics|intervals|changed)[.\w]*|not_compared|verdict"
        r"|(claims|targets)\[\d+\]|the utility is in subject.class",
        statement,
    )
    return found[0] if found else statement


def about(own: str, other: str) -> bool:
    """Whether a statement of the Python checker is part of one of the verified program."""
    inner, outer = place(own), place(other)
    return inner == outer or inner.startswith((f"{outer}.", f"{outer}["))


UNREAD = re.compile(
    r"(incomplete: )?(subject lacks the key .spellings|claims\[\d+\]|intervals|changed|there is no claim about"
    r"|the table of the certificate has counts"
    r"|subject\.table\.rows\[\d+\]\.unknown"
    r"|targets\[\d+\](\.estimand|\.judged| (has|lacks) the key 'estimand'|\.tips)"
    r"|subject\.(undecided|unknown_shares|max_drift|preparation|spellings|evaluation|privacy|declared))"
)
"""Where the verified program does not read what it does not cover: it leaves that open, as it does policies and rows of unknown groups."""
UNASKED = "assumptions that it does not rest on"


def explained(verified: Judged, label: str) -> bool:
    """Whether a statement may be false on the verified road alone, which is so only beside another one that is false on both."""
    false = {place(own) for own, true in verified.statements if true is False}
    if label.startswith("targets["):  # a limit in nats is judged by the ratio that is stated, one of a population by an interval
        if "population at confidence" in label:
            return not {"intervals.local", "intervals.global"}.isdisjoint(false)
        return " log, limit " in label and not {"metrics.local", "metrics.global"}.isdisjoint(false)
    if label.startswith("metrics."):  # all that names columns is false where the columns are
        return "subject.columns" in false
    if label.startswith(("claims[", "subject.declared")) and any(own.startswith("subject.privacy") for own, _ in verified.statements):
        # of a policy: all that is claimed rests on its privacy, on what was declared and on the figures
        resting = ("subject.", "metrics.")
        return any(own.startswith(resting) and not label.startswith(own) for own in false)
    return label == "verdict" and any(own.startswith("targets[") for own in false)


def differences(python: Judged, verified: Judged) -> Iterator[str]:
    """What is not as it has to be; a line that begins with UNSOUND says more than is true."""
    if python.why.startswith("too much: "):  # the verified program counts no work
        return
    if verified.code == TRUE and python.code in (FALSE, MALFORMED):
        yield f"UNSOUND: exit code 0 for {python.code} ({python.why})"
    if (
        python.code == MALFORMED
        and verified.code in (FALSE, OPEN)
        and (UNREAD.match(python.why) or not {("subject", None), ("verdict", None)}.isdisjoint(verified.statements))
    ):
        return
    if verified.code == MALFORMED and python.code == FALSE and UNASKED in verified.why:
        return
    if MALFORMED in (python.code, verified.code) or (OPEN in (python.code, verified.code) and not verified.statements):
        if python.code != verified.code:
            yield f"{python.code} {verified.code}: {python.why or verified.why}"
        return
    false = [statement for statement, true in python.statements if not true]
    for label, outcome in verified.statements:
        wrong = [statement for statement in false if about(statement, label)]
        if outcome and wrong:
            yield f"UNSOUND: {label} is true, {wrong[0]} is false"
        if outcome is False and not wrong and not explained(verified, label):
            yield f"{label} is false, and not in Python"
    for statement in false:
        if not any(about(statement, label) and outcome is not True for label, outcome in verified.statements):
            yield f"nothing is said of {statement}"


class Tally:
    """How many documents were judged on all roads, with which codes, and what differed."""

    def __init__(self) -> None:
        self.codes: Counter[tuple[int, int]] = Counter()
        self.open: Counter[str] = Counter()
        self.different: list[tuple[str, bytes]] = []

    def judge(self, program: Path, documents: Iterable[bytes]) -> None:
        """Judge documents on the three roads and compare."""
        given = list(documents)
        native, script = natively(program, given), in_script(given)
        for document, one, other in zip(given, native, script, strict=True):
            python = in_python(document)
            self.codes[python.code, one.code] += 1
            self.open.update(kind(label) for label, outcome in one.statements if outcome is None)
            if one != other:
                self.different.append(("native and JavaScript differ", document))
            self.different += [(what, document) for what in differences(python, one)]


def kind(label: str) -> str:
    """The kind of a statement: by which method a claim, else where it stands."""
    by = re.search(r' by ("[^"]*")$', label)
    return f"claims by {by[1]}" if by else re.sub(r"\[\d+\].*", "", label)


# True documents of every kind, and alterations of them


def random_table(seed: int) -> bytes:
    """A certificate of a small table, written by definition: counts or probabilities, whole or partial, every population, any utility."""
    pick = Pick(tiers.fresh(seed))
    contexts, groups, decisions = pick.choice([1, 2, 2, 3]), pick.choice([2, 2, 3]), pick.choice([1, 2, 2, 3])
    population = pick.choice(["counts", "counts", "weights", "equal"])
    cells = [cell for cell in product(range(contexts), range(groups)) if pick.random() < 0.9]
    weights: dict[tuple[int, int], list[str]] = {}
    for cell in cells or [(0, 0)]:
        row = [Fraction(pick.choice([0, 1, 1, 2, 5, 10**19]), pick.choice([1, 1, 1, 3])) for _ in range(decisions)]
        row[pick.randrange(decisions)] += 1
        weights[cell] = [str(w if population == "counts" else w / sum(row)) for w in row]
    masses = None
    if population == "weights":
        drawn = {cell: pick.choice([0, 1, 1, 3]) for cell in weights}
        drawn[pick.choice([*weights])] += 1
        masses = {cell: str(Fraction(mass, sum(drawn.values()))) for cell, mass in drawn.items()}
    values = ["0", "0", "1", "1", "1/2", "7/3"]
    one = [pick.choice(values) for _ in range(decisions)]
    utility: Any = one if pick.random() < 0.6 else {cell: [pick.choice(values) for _ in range(decisions)] for cell in weights}
    limits = [(q, u, pick.choice(["1", "5/4", "2", "11/10", "10"])) for q in ("local", "global") for u in ("ratio", "log")]
    shape = contexts, groups
    given = make(weights, utility, population=population, masses=masses, shape=shape, limits=tuple(pick.sample(limits, pick.randint(0, 4))))
    return as_bytes(complete(given))


def of_evaluation(seed: int) -> bytes:
    return audited(drawn_log(seed), confidence=None).certificate.text.encode()


def of_class(seed: int) -> bytes:
    return as_bytes(true_certificate(Solved(Case(seed))))


def of_policy(seed: int) -> bytes:
    return as_bytes(write(Policy(tiers.fresh(seed))))


def of_other_policies(seed: int) -> bytes:
    return as_bytes(over_policies.certificate(tiers.fresh(seed)))


def of_writer(seed: int) -> bytes:
    return random_certificate(seed).text.encode()


def of_draws(seed: int) -> bytes:
    """Counts of independent draws, with intervals of both ratios: a utility of two values, sometimes another one, or a declared range."""
    pick = Pick(tiers.fresh(f"draws {seed}"))
    shape = pick.choice([1, 2, 3]), pick.choice([2, 2, 3]), pick.choice([2, 3])
    most = pick.choice([6, 40, 400])
    counts = [[[pick.randint(0, most) for _ in range(shape[2])] for _ in range(shape[1])] for _ in range(shape[0])]
    for row in counts:
        for cell in row:
            cell[pick.randrange(shape[2])] += pick.choice([0, 1, 1, most])
    law = fa.Law.from_array(counts, kind="counts")
    values = [pick.choice(["1", "1", "1", "7/3", "0"]) for _ in range(shape[2])] if pick.random() < 0.2 else ["1"] + ["0"] * (shape[2] - 1)
    utility: Any = {str(u): value for u, value in enumerate(values)}
    if pick.random() < 0.2:
        worth = {x: pick.choice([1, 2]) for x in law.contexts}
        utility = fa.Utility.from_function(lambda u, x, a: worth[x] * (u == "0"), law)
    options: dict[str, Any] = {"confidence": pick.choice(["0.95", "0.5", "99/100"]), "independent": pick.random() < 0.3}
    if pick.random() < 0.4:
        limits = {
            "max_local_ratio": pick.choice(["1", "3/2", "10"]),
            "max_local_log": pick.choice(["0", "1/3", "3"]),
            "max_global_ratio": pick.choice(["11/10", "2"]),
            "max_global_log": pick.choice(["0.2", "1"]),
        }
        options |= {name: limits[name] for name in pick.sample([*limits], pick.randint(1, 4))}
    if pick.random() < 0.1:
        options["declared"] = {"gamma": 3, "m": 0}
    return fa.certify(law, utility, **options).certificate.text.encode()


STRANGE = ["yes", "no", "*) False (*", '"', "\\u0041", "é", "e\u0301", "\u202eright", "-1", "line\n"]
"""Labels of which some stand for nothing but themselves."""


def of_true_labels(seed: int) -> bytes:
    """Counts with true labels, by definition or as they are written: positive true labels missing, with columns of contexts or without."""
    pick = Pick(tiers.fresh(f"true labels {seed}"))
    if pick.random() < 0.5:
        return as_bytes(complete(random_truth_certificate(seed)))
    names = pick.sample(STRANGE, len(STRANGE)) if pick.random() < 0.4 else ["one", "two", "three"]
    contexts = names[: pick.choice([0, 1, 2, 3])]
    groups, decisions, truths = (names[: pick.choice([least, 2, 3])] for least in (2, 1, 1))
    counts, density = [0, 1, 1, 2, 5, 60], pick.choice([1, 0.8, 0.5])
    rows = [[*row, pick.choice(counts)] for row in product(decisions, truths, groups, contexts or [""]) if pick.random() < density]
    rows += [[decisions[0], pick.choice(truths), group, (contexts or [""])[0], 1] for group in groups[:2]]
    data = {name: list(values) for name, values in zip("utaxn", zip(*rows, strict=True), strict=True)}
    columns: dict[str, Any] = {"decision": "u", "group": "a", "count": "n", "truth": "t"} | ({"context": "x"} if contexts else {})
    law = fa.Law.from_counts(data, **columns)
    utility = dict.fromkeys(pick.sample(law.decisions, pick.randint(1, len(law.decisions))), 1)
    options: dict[str, Any] = {"confidence": pick.choice([None, None, "0.9"])} | ({"max_local_ratio": 2} if pick.random() < 0.3 else {})
    if options["confidence"] is None and pick.random() < 0.3:
        options["difference"] = True
    return fa.certify(law, utility, positive=pick.choice(sorted(set(data["t"]))), **options).certificate.text.encode()


def of_units(seed: int) -> bytes:
    """Groups that were seen in the same units, with one row or several each."""
    return as_bytes(honest(Pick(tiers.fresh(f"units {seed}"))))


def of_kind(seed: int) -> bytes:
    """One of the tables that were made to be difficult, with limits or without, and within a drift where there can be one."""
    made = KINDS[seed % len(KINDS)]
    drift = {"max_drift": "1/50"} if seed % 6 == 0 and made.__name__ not in NO_DRIFT else {}
    return made(**({**FOUR, **drift} if seed % 3 == 0 else {})).certificate.text.encode()


NO_DRIFT = ("by_group", "both_contrasts", "signed", "signed_by_cell")
"""Tables without a utility for each decision, or with differences."""


SOURCES: tuple[tuple[Callable[[int], bytes], int], ...] = (
    (random_table, 8),
    (of_kind, 4),
    (of_writer, 4),
    (of_policy, 3),
    (of_other_policies, 2),
    (of_class, 2),
    (of_evaluation, 1),
    (of_draws, 4),
    (of_true_labels, 4),
    (of_units, 2),
)
"""What writes true documents, and how often."""


def true_document(seed: int) -> bytes:
    pick = Pick(tiers.fresh(f"document {seed}"))
    [write_one] = pick.choices([source for source, _ in SOURCES], [often for _, often in SOURCES])
    return write_one(seed)


def reworded(pick: Pick, document: Any) -> bytes:
    """The same document in other words: blanks, escapes, another order of keys; claims left out; other versions."""

    def shuffled(value: Any) -> Any:
        if isinstance(value, dict):
            return {key: shuffled(value[key]) for key in pick.sample([*value], len(value))}
        return [shuffled(item) for item in value] if isinstance(value, list) else value

    document = shuffled(document)
    document["claims"] = [claim for claim in document["claims"] if pick.random() < 0.9]
    for claim in document["claims"]:
        pick.shuffle(claim["assumptions"])
    text = json.dumps(document, ensure_ascii=pick.random() < 0.5, indent=pick.choice([None, 1, "\t"]))
    if pick.random() < 0.5:
        text = re.sub(r"(?<=[ \"a-z])[a-z](?=[a-z])", lambda m: f"\\u{ord(m[0]):04x}" if pick.random() < 0.1 else m[0], text)
    return pick.choice(["", " ", "\r\n"]).encode() + text.encode() + pick.choice([b"", b"\n\t"])


def other_bytes(pick: Pick, raw: bytes) -> bytes:
    """One byte more, one less, another one, or a piece twice."""
    at = pick.randrange(len(raw))
    other = pick.choice([bytes([pick.randrange(256)]), pick.choice([b'"', b",", b"}", b"0", b"9", b"\\", b"-", b"/", b".", b"e"])])
    to = min(len(raw), at + pick.choice([1, 1, 1, 2, 30]))
    return pick.choice([raw[:at] + other + raw[at + 1 :], raw[:at] + raw[to:], raw[:at] + other + raw[at:], raw[:to] + raw[at:]])


def twin_keys(pick: Pick, raw: bytes) -> bytes:
    found = pick.choice([*re.finditer(rb'"[^"\\]*": ?', raw)])
    return raw[: found.start()] + found[0] + pick.choice([b"null", b"0", b'"1"', b"[]"]) + b", " + raw[found.start() :]


def _others(value: Any) -> list[Any]:
    try:
        return other_values(value, POOL)
    except (OverflowError, TypeError, ValueError):  # of a number that is no float, or too long, or of a float
        return ["1", 0]


def altered(pick: Pick, raw: bytes) -> bytes:
    """Change one thing: a value most of the time, with the digests brought in line with the table or not."""
    how = pick.random()
    if how < 0.08:
        return reworded(pick, json.loads(raw))
    if how < 0.16:
        return other_bytes(pick, raw)
    if how < 0.18:
        return twin_keys(pick, raw)
    document = json.loads(raw)
    for _ in range(pick.choice([1, 1, 1, 2])):
        section = pick.choice(
            [key for key in ("subject", "metrics", "not_compared", "claims", "targets", "verdict", "intervals") if document.get(key)]
        )
        try:
            rows = document["subject"]["table"]["rows"]
        except (TypeError, KeyError):  # after another change
            rows = None
        of_rows = section == "subject" and rows and pick.random() < 0.6
        at: tuple[Any, ...] = ("subject", "table", "rows") if of_rows else (section,)
        inside = rows if of_rows else document[section]
        found = [path for path, value in places(inside) if path and (pick.random() < 0.2 or not isinstance(value, (dict, list)))]
        path = (*at, *pick.choice(found)) if found else at
        value = document
        for step in path:
            value = value[step]
        others = _others(value)
        numbers = [other for other in others if isinstance(other, str) and re.fullmatch(r"(0|[1-9][0-9]*)(/[1-9][0-9]*)?", other)]
        other = pick.choice(numbers if numbers and pick.random() < 0.6 else others)
        document = put(json.dumps(document), path, other)
    if pick.random() < 0.4:
        return as_bytes(document)
    try:
        return redigested(document)
    except (TypeError, KeyError, AttributeError, UnicodeEncodeError):  # a table, or its digest, that was changed to something else
        return as_bytes(document)


POOL = [
    "local",
    "global",
    "within",
    "exceeds",
    "inconclusive",
    "=",
    "<=",
    ">=",
    "enumeration",
    "T5",
    "T6",
    "T7",
    "T14",
    "T16",
    "this law",
    "this law, within the declared drift",
    "counts",
    "equal",
    "each",
    "together",
    "binomial",
    "population at confidence 9/10",
]


def documents(seeds: Iterable[int], each: int) -> Iterator[bytes]:
    """True documents, and alterations of each."""
    for seed in seeds:
        document, pick = true_document(seed), Pick(tiers.fresh(seed))
        yield document
        for _ in range(each):
            yield altered(pick, document)
