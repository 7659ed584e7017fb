"""An audit of groups that nobody recorded, as text for a terminal, in which labels from the input are data."""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction

from fairaudit.audits.proxies import ProxyAudit, ProxyRange, ProxyTarget
from fairaudit.exact.extended import Extended
from fairaudit.measures.limits import limit_text
from fairaudit.reports.proxy_content import SAMPLING
from fairaudit.reports.text import written_text
from fairaudit.words import approximate, noun, plain

__all__ = ["proxy_text"]


def proxy_text(result: ProxyAudit, top: int, written: Sequence[str], *, completions: bool = False) -> str:
    """Describe an audit: the verdict, one sentence, what groups get, their ratios, the targets, and what is taken as given."""
    sentence = result.sentence
    judged = "\n".join(_target(result, target) for target in result.targets)
    blocks = [judged or "NO TARGET was set; these are the exact ranges.", sentence[0].upper() + sentence[1:]]
    shown = sorted(result.local, key=lambda found: -found.ends.greatest.value)[:top]
    blocks += [_range_text(result, found) for found in shown]
    if more := len(result.local) - len(shown):
        blocks.append(f"{more} more {noun(more, 'context is', 'contexts are')} in the certificate.")
    if result.context and result.global_ is not None:
        blocks.append(_range_text(result, result.global_))
    if completions:
        found = [*shown, *([result.global_] if result.context and result.global_ is not None else [])]
        blocks += [_completion_text(result, one, which) for one in found for which in ("low", "high")]
    blocks.append("Taken as given:\n" + "\n".join(f"  {text}" for text in result.assumptions))
    blocks.append(SAMPLING)
    if written:
        blocks.append(written_text(written))
    return "\n\n".join(plain(line) if "\n" not in line else "\n".join(map(plain, line.split("\n"))) for line in blocks)


def _target(result: ProxyAudit, target: ProxyTarget) -> str:
    """The verdict on a target, and what it rests on."""
    proved, reached = result.proved(target.quantity), result.reached(target.quantity)
    if proved is None or reached is None:
        why = "fewer than two groups are there"
    elif target.verdict == "depends":
        why = f"{approximate(reached[0])} is possible, and so is {approximate(reached[1])}"
    elif target.verdict == "inconclusive":
        why = f"proved is {_range(proved)}, and known to be possible {_range(reached)}"
    else:
        why = f"it is {'' if proved[0] == proved[1] else 'from '}{_range(proved)}"
    return f"{target.verdict.upper():<13}{limit_text(target.quantity, target.unit, target.limit)}: {why}"


def _range(ends: tuple[Extended, Extended]) -> str:
    return approximate(ends[0]) if ends[0] == ends[1] else f"{approximate(ends[0], 'down')} to {approximate(ends[1], 'up')}"


def _name(result: ProxyAudit, found: ProxyRange, a: int) -> str:
    return ", ".join(result.groups[found.groups[a]])


def _where(result: ProxyAudit, found: ProxyRange) -> str:
    if found.context is None:
        return "All contexts together" if result.context else "All cells"
    return ", ".join(f"{name}={label}" for name, label in zip(result.context, found.context, strict=True)) or "All cells"


def _range_text(result: ProxyAudit, found: ProxyRange) -> str:
    names = [_name(result, found, a) for a in range(len(found.groups))]
    width = max(len(f"{one} / {other}") for one in names for other in names if one is not other)
    lines = [_where(result, found)]
    lines += [f"  {name:<{width}}  mean {_range(ends)}" for name, ends in zip(names, found.ends.means, strict=True)]
    for (a, b), ((low, low_sharp), (high, high_sharp)) in found.ends.pairs.items():
        loose = "" if low_sharp and high_sharp else " at most"
        lines.append(f"  {f'{names[a]} / {names[b]}':<{width}}  ratio {_range((low, high))}{loose}")
    return "\n".join(lines)


def _completion_text(result: ProxyAudit, found: ProxyRange, which: str) -> str:
    ends = found.ends.low if which == "low" else found.ends.high
    names = [_name(result, found, a) for a in range(len(found.groups))]
    head = (
        f"{_where(result, found)}: a constructed witness with the ratio {approximate(ends.ratio)} (rows by group; parts of rows are shares)"
    )
    lines = [head]
    for label, decision, rows in result.completion(found, "low" if which == "low" else "high"):
        said = ", ".join(f"{name} {_rows(count)}" for name, count in zip(names, rows, strict=True))
        lines.append(f"  {', '.join(label)}: {decision}: {said}")
    return "\n".join(lines)


def _rows(count: Fraction) -> str:
    return str(count.numerator) if count.denominator == 1 else f"{float(count):.2f}"
