"""`fairaudit compare`: what moved between two certificates, and which verdict changed."""

from __future__ import annotations

import argparse
import re
from fractions import Fraction
from typing import TYPE_CHECKING, Any

from fairaudit.cli import CORE
from fairaudit.cli.options import add_command
from fairaudit.cli.output import Answer, aligned
from fairaudit.cli.two_logs import COLUMNS_OF_LOGS, add_logs, are_logs, compared_logs, is_certificate, rates_entry, rates_text

if TYPE_CHECKING:
    from collections.abc import Sequence

    from fairaudit.certificates.compare import CertificateComparison as Comparison
    from fairaudit.certificates.compare import Change, Moved
    from fairaudit.certificates.fairness import Fairness

DESCRIPTION = """\
Compare two certificates (or two logs, whose columns are named) of the same columns and utility: verdicts, targets, measures, intervals,
bounds and the groups that moved, all of them exactly; and whether the new one is less fair, from both ends of the greatest ratio in each.
Certificates are checked first, as `fairaudit verify` does."""

EPILOG = """\
exit codes: 0 no verdict got worse; 1 one did, or a target was dropped, loosened or judged with less certainty (with --fail-on rise also
when a measure rose); 2 bad input, a certificate with a false statement, or certificates that cannot be compared; 3 not comparable: a
group, context or decision of the old certificate is not there any more, or more was left out

with --fail-on less-fair, and of two logs: 0 no less fair: the greatest ratio of the new one is established to be at most --margin times
that of the old one; 1 less fair: it is established to be more; 2 bad input; 3 neither is established

examples:
  fairaudit compare last-week.json today.json
  fairaudit compare main.json branch.json --format markdown --fail-on rise
  fairaudit compare model-a.json model-b.json --fail-on less-fair --margin 1.1
  fairaudit compare a.eval b.eval --decision scores.choice.answer --group metadata.race --utility A --unit id --margin 1.1"""

SHOW_EXACT = 9  # characters of a fraction that a line has room for beside its decimals
NAMES = {
    "local": "local ratio",
    "global": "global ratio",
    "equalized_odds": "parity within contexts (the paper's equalized odds)",
    "demographic_parity": "demographic parity",
    "local_supremum": "worst local ratio over group-blind utilities",
    "global_supremum": "worst global ratio over group-blind utilities",
    "local without filters": "local ratio without filters",
    "global without filters": "global ratio without filters",
    "equal_opportunity": "equal opportunity",
    "equal_opportunity_overall": "equal opportunity, over all contexts",
    "equalized_odds_true_label": "equalized odds given the true label",
    "equalized_odds_true_label_overall": "equalized odds given the true label, over all contexts",
}


def add(commands: Any) -> None:
    """Declare the options."""
    parser = add_command(commands, "compare", run, CORE["compare"], DESCRIPTION, EPILOG)
    parser.add_argument("old", metavar="OLD", help="the certificate before; or a log, with its columns")
    parser.add_argument("new", metavar="NEW", help="the certificate after; or a log of the same columns")
    parser.add_argument("--format", choices=("text", "json", "markdown"), default="text", help="what to print")
    parser.add_argument("--top", metavar="K", type=int, default=5, help="how many of the groups that moved furthest to list (5)")
    parser.add_argument(
        "--fail-on",
        choices=("verdict", "rise", "less-fair"),
        help="what counts as worse for the exit code (verdict; of two logs less-fair)",
    )
    parser.add_argument(
        "--margin", metavar="M", default="1", help="the new one is less fair if its greatest ratio is more than M times the old one's (1)"
    )
    parser.add_argument(
        "--global", dest="overall", action="store_true", help="with --fail-on less-fair: the ratio of group means, not that within contexts"
    )
    add_logs(parser)


def run(arguments: argparse.Namespace) -> Answer:
    """Do the work."""
    from fairaudit.errors import InputError
    from fairaudit.verified.comparison import compare

    if arguments.top < 0:
        raise InputError(f"--top {arguments.top} is not accepted; a number of at least 0 is")
    logs = compared_logs(arguments) if are_logs(arguments) else None
    fail_on = arguments.fail_on or ("verdict" if logs is None else "less-fair")
    if arguments.overall and fail_on != "less-fair":
        raise InputError("--global goes with --fail-on less-fair")
    try:
        found = logs.found if logs is not None else compare(arguments.old, arguments.new, margin=arguments.margin)
    except InputError as error:
        if any(map(is_certificate, (arguments.old, arguments.new))):
            raise
        raise InputError(f"{arguments.old} is no certificate that fairaudit wrote; {COLUMNS_OF_LOGS}") from error
    asked = _asked(found, arguments) if fail_on == "less-fair" else None
    notes = (
        list(found.notes) if logs is None else [*dict.fromkeys((*found.notes, *(note for result in logs.results for note in result.notes)))]
    )
    write = _markdown if arguments.format == "markdown" else _text
    beside = "" if logs is None else rates_text(logs)
    return Answer(
        "compare",
        sentence=f"{_headline(found, asked)}.",
        # In text, notes are a part of what is printed.
        notes=notes if arguments.format == "json" else (),
        result=lambda: {**_entry(found, arguments.top), **({} if logs is None else {"by_unit": rates_entry(logs)})},
        text=lambda: write(found, notes, arguments.top, asked, beside),
        code=_code(found, fail_on, asked),
    )


def _asked(found: Comparison, arguments: argparse.Namespace) -> Fairness:
    """The answer on which the exit code rests."""
    from fairaudit.errors import InputError

    name = "global" if arguments.overall else "local"
    for entry in found.fairness:
        if entry.quantity == name:
            return entry
    raise InputError(f"the certificates do not both state a {name} ratio, so neither is less fair by it")


def _code(found: Comparison, fail_on: str, asked: Fairness | None) -> int:
    if asked is not None:
        return {"no less fair": 0, "less fair": 1, "not established": 3}[asked.verdict]
    return 1 if found.worse or (fail_on == "rise" and found.risen) else 3 if found.gone else 0


def _headline(found: Comparison, asked: Fairness | None) -> str:
    if asked is not None:
        return asked.sentence
    if found.worse:
        return "WORSE: a verdict got worse, or a target was dropped or weakened"
    if found.gone:
        return "NOT COMPARABLE: " + "; ".join(found.gone)
    changes = [found.verdict, *found.targets]
    if any(change.direction == "better" for change in changes):
        return "BETTER: a verdict improved, none got worse"
    return "UNCHANGED verdicts"


def _unsaid(found: Comparison) -> list[str]:
    """What is gone, where the headline says that something got worse."""
    return [f"not comparable: {text}" for text in found.gone] if found.worse else []


def _text(found: Comparison, notes: list[str], top: int, asked: Fairness | None, beside: str) -> str:
    from fairaudit.words import plain

    blocks = [plain(_headline(found, asked)), _rows([found.verdict, *found.targets])]
    if found.fairness:
        lines = [f"  {plain(entry.sentence)}\n    {entry.ends}" for entry in found.fairness]
        blocks.append("Is the new one less fair?\n" + "\n".join(lines))
    if beside:
        blocks.append(beside)
    for title, changes in (("Measures", found.metrics), ("Intervals for the population", found.intervals), ("Bounds", found.bounds)):
        shown = changes if title == "Measures" else tuple(c for c in changes if c.direction != "same")
        if shown:
            blocks.append(f"{title}\n{_rows(shown)}")
    if found.cells and top:
        lines = [f"  {_place(moved)}: {_approximate(moved.old)} -> {_approximate(moved.new)}" for moved in found.cells[:top]]
        more = len(found.cells) - top
        lines += [f"  … and {more} more"] if more > 0 else []
        blocks.append(f"{_moved(found)}\n" + "\n".join(lines))
    notes = [*_unsaid(found), *notes]
    if notes:
        blocks.append("Keep in mind\n" + "\n".join(f"  - {plain(note)}" for note in notes))
    return "\n\n".join(blocks)


def _rows(changes: Sequence[Change]) -> str:
    """A line for each change, and one below it with what else is to say of it."""
    from fairaudit.words import plain

    lines = aligned([_row(change) for change in changes], "  ").splitlines()
    notes = [f"\n    {plain(change.note)}" if change.note else "" for change in changes]
    return "\n".join(line + note for line, note in zip(lines, notes, strict=True))


def _row(change: Change) -> tuple[str, str, str]:
    from fairaudit.words import plain

    old, new = _both(change)
    moved = old if change.old == change.new else f"{old} -> {new}"
    return plain(_name(change)), moved, _moved_by(change)


def _moved_by(change: Change) -> str:
    """How far a figure moved, which by itself says neither that it is much nor that it is no chance; of anything else what changed."""
    from fairaudit.certificates.reader import number
    from fairaudit.words import approximate, factor_text

    values = [value for value in (change.old, change.new) if value is not None and re.fullmatch(r"-?\d+(/\d+)?|inf", value)]
    if change.direction not in ("worse", "better") or len(values) < 2:
        return "unchanged" if change.direction == "same" else change.direction
    old, new = map(number, values)
    if not (isinstance(old, Fraction) and isinstance(new, Fraction)):
        return "rose" if new > old else "fell"
    if old and ("ratio" in NAMES.get(change.what, change.what).partition(" by ")[0]):
        return f"{factor_text(new / old)} times"
    return f"{'+' if new > old else '-'}{approximate(abs(new - old))}"


def _name(change: Change) -> str:
    """What moved, in words; of a bound the quantity comes first."""
    from fairaudit.reports.words import QUANTITIES

    quantity, by, rest = change.what.partition(" by ")
    return QUANTITIES.get(quantity, quantity) + by + rest if by else NAMES.get(change.what, change.what)


def _both(change: Change) -> tuple[str, str]:
    """The two values for a person, with the fractions where both are short."""
    exact = max(len(value or "") for value in (change.old, change.new)) <= SHOW_EXACT
    return _said(change.old, exact=exact), _said(change.new, exact=exact)


def _said(value: str | None, *, exact: bool) -> str:
    """A value for a person: decimals, and the fraction if asked for."""
    from fairaudit.certificates.reader import number
    from fairaudit.words import approximate

    if value is None:
        return "none"
    if " to " in value:
        low, high = (number(end) for end in value.split(" to "))
        return f"{approximate(low, 'down')} to {approximate(high, 'up')}"
    if each := re.fullmatch("at least ([^,]+), at most (.+)", value):
        return f"at least {approximate(number(each[1]), 'down')}, at most {approximate(number(each[2]), 'up')}"
    if value == "inf":
        return "infinite"
    if not value[:1].isdigit():
        return value
    decimals = approximate(number(value))
    return f"{decimals} ({value})" if exact and "/" in value else decimals


def _moved(found: Comparison) -> str:
    return "Expected burdens that moved" if "burden" in found.amount else "Expected utilities that moved"


def _place(moved: Moved) -> str:
    from fairaudit.words import place, plain

    where = f"{place(moved.context)}: " if moved.context else ""
    return plain(f"{where}{place(moved.group)}")


def _approximate(value: Any) -> str:
    from fairaudit.words import approximate

    return "none" if value is None else approximate(value)


def _entry(found: Comparison, top: int) -> dict[str, Any]:
    def listed(changes: tuple[Change, ...]) -> list[dict[str, Any]]:
        return [
            {"what": c.what, "old": c.old, "new": c.new, "direction": c.direction, **({"note": c.note} if c.note else {})} for c in changes
        ]

    return {
        "worse": found.worse,
        "risen": found.risen,
        "amount": found.amount,
        "verdict": listed((found.verdict,))[0],
        "targets": listed(found.targets),
        "metrics": listed(found.metrics),
        "intervals": listed(found.intervals),
        "bounds": listed(found.bounds),
        "moved": [
            {
                "context": dict(m.context),
                "group": dict(m.group),
                "old": m.old,
                "new": m.new,
            }
            for m in found.cells[:top]
        ],
        "moved_in_all": len(found.cells),
        "not_comparable": list(found.gone),
        "fairness": [_fairness_entry(entry) for entry in found.fairness],
    }


def _fairness_entry(entry: Fairness) -> dict[str, Any]:
    from fairaudit.certificates.numbers import number

    ends = {name: [number(end) for end in getattr(entry, name)] for name in ("old", "new", "ratio")}
    confidence = None if entry.confidence is None else number(entry.confidence)
    said = {"verdict": entry.verdict, "why": entry.why, "assumptions": list(entry.assumptions)}
    return {"quantity": entry.quantity, "margin": number(entry.margin), **ends, "confidence": confidence, **said}


def _markdown(found: Comparison, notes: list[str], top: int, asked: Fairness | None, beside: str) -> str:
    from fairaudit.reports.markdown import code, prose, table
    from fairaudit.words import plain

    def rows(changes: tuple[Change, ...]) -> list[tuple[str, ...]]:
        return [
            (
                prose(_name(c)),
                *_both(c),
                _moved_by(c),
                prose(c.note) if c.note else "",
            )
            for c in changes
        ]

    head = ("what", "before", "now", "change", "note")
    blocks = [
        f"## Fairness: {prose(plain(_headline(found, asked)))}",
        table(head, rows((found.verdict, *found.targets))),
        *("\n".join(f"* {prose(plain(entry.sentence))}; {entry.ends}" for entry in found.fairness),) * bool(found.fairness),
        table(head, rows(found.metrics)),
    ]
    if beside:
        blocks.append(f"```text\n{beside.replace('```', chr(39) * 3)}\n```")
    others = (*found.intervals, *(c for c in found.bounds if c.direction != "same"))
    if others:
        blocks.append(f"### Intervals and bounds\n\n{table(head, rows(others))}")
    if found.cells and top:
        lines = [(code(_place(m)), _approximate(m.old), _approximate(m.new)) for m in found.cells[:top]]
        blocks.append(f"### {_moved(found)}\n\n{table(('group', 'before', 'now'), lines)}")
        if len(found.cells) > top:
            blocks.append(f"… and {len(found.cells) - top} more")
    notes = [*_unsaid(found), *notes]
    if notes:
        blocks.append("### Keep in mind\n\n" + "\n".join(f"* {prose(plain(note))}" for note in notes))
    return "\n\n".join(blocks)
