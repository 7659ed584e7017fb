"""A report as markdown: for pull requests, model cards, wikis."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping, Sequence
from typing import Any

from fairaudit.certificates.certificate import Certificate
from fairaudit.reports import markdown as _markdown
from fairaudit.reports.content import UNCHECKED, Content, Figure, describe, refusing_other_documents
from fairaudit.reports.hidden_context import Strength
from fairaudit.reports.ladder import Rung
from fairaudit.reports.overview import Overview
from fairaudit.reports.provenance import TITLE as PROVENANCE
from fairaudit.reports.provenance import Provenance, intro
from fairaudit.reports.rows import Row
from fairaudit.reports.views import Views
from fairaudit.reports.words import Value
from fairaudit.words import noun


@refusing_other_documents
def markdown(certificate: Certificate | Mapping[str, Any], *, checked: str = "", provenance: Provenance | None = None) -> str:
    """Write a certificate as markdown, for a pull request or a model card.

    Parameters
    ----------
    certificate : Certificate or mapping
        The certificate, or its JSON document.
    checked : str
        A sentence on who checked the certificate; without one, that of a certificate without its table says that nobody did.
    provenance : Provenance, optional
        What its attestation says.

    Returns
    -------
    str
        The text.

    Raises
    ------
    InputError
        If the document does not have the shape of a certificate.

    Examples
    --------
    >>> from fairaudit import Law, certify
    >>> law = Law.from_array([[3, 1], [1, 1]], kind="counts", decisions=["yes", "no"], groups=["f", "m"])
    >>> markdown(certify(law, {"yes": 1}, max_local_ratio=2, confidence=None).certificate).splitlines()[0]
    '## Fairness audit: within the target'
    """
    return _markdown.write(describe(certificate.document if isinstance(certificate, Certificate) else certificate), checked, provenance)


__all__ = ["code", "figure_row", "groups", "lead", "markdown", "prose", "provenance_lines", "table", "target_line", "write"]


SAFE_IN_PROSE = frozenset("()%'“”–-/·")

CONTEXTS = 3  # whose groups are listed

FIGURES = ("measure", "value", "log", "exactly", "in the population", "between")

LINK = re.compile(r"www\.|://", re.IGNORECASE)

HARMLESS = frozenset(" abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789,.=;:")


def write(page: Content, checked: str = "", provenance: Provenance | None = None) -> str:
    """Write a report."""
    checked = checked or ("" if page.subject else UNCHECKED)
    title = "Fairness audit, not checked" if checked == UNCHECKED else "Fairness audit"
    views = Views(page)
    blocks = [f"## {title}: {page.headline[0].lower()}{page.headline[1:]}", *_first(page, views)]
    blocks += groups(page, views)
    if page.unknown:
        lines = [f"* {prose(text)}" for found in page.unknown for text in (found.sentence, *found.tips)]
        lines += [f"* {title}: {prose('; '.join(given))}" for found in page.unknown for title, given in found.completions]
        blocks.append("### Decisions without a recorded group\n\n" + "\n".join(lines))
    if page.undecided:
        rows = [(found.name, "" if found.face is None else found.face.decimal, found.ends, prose(found.of)) for found in page.meant]
        heads = ("what", "at face value", "whatever they meant", "of")
        blocks += [f"### Undecided decisions\n\n{prose(page.undecided)}", table(heads, rows)]
    if views.as_read:
        blocks.append("### How the table was read\n\n" + "\n".join(f"* {prose(line)}" for line in views.as_read))
    if page.lost is not None and page.lost.groups:
        wide = bool(page.lost.cells)
        lost = [
            (*([code(one.context) if one.context else "over all"] if wide else []), code(one.label), *one.cells)
            for one in (*page.lost.groups, *page.lost.cells)
        ]
        named = (*([prose(views.context_column)] if wide else []), prose(views.group_column), *page.lost.heads)
        blocks += ["### Answers that decide nothing", prose(page.lost.caution), table(named, lost)]
        if page.lost.more:
            blocks.append(f"And {page.lost.more:,} more {noun(page.lost.more, 'context, not', 'contexts, none of them')} more unequal.")
    if page.not_compared:
        blocks.append("### What was not compared\n\n" + "\n".join(f"* {prose(line)}" for line in page.not_compared))
    judged = [f"* {prose(text)} (for statements about {prose(scopes)})" for text, scopes in page.assumptions]
    blocks.append("### What you have to judge\n\n" + "\n".join([*judged, *(f"* {line}" for line in page.limits)]))
    digest = page.document["subject"]["table"]["sha256"]
    beside = "" if page.subject else " --table certificate.table.jsonl"
    blocks.append(
        f"### What to do next: verify it\n\n`fairaudit verify certificate.json{beside}` checks every statement and uses none of the code "
        f"that made them. Digest of the table: {code(digest)}."
    )
    blocks += provenance_lines(provenance)
    blocks += _figures(page, views)
    if checked:
        blocks.append(checked)
    return "\n\n".join(blocks) + "\n"


def lead(page: Content, found: Overview | None) -> str:
    """The sentences with which a report begins."""
    return prose(page.lead) if found is None else "\n\n".join(prose(line) for line in (*found.cautions, *found.sentences))


def _first(page: Content, views: Views) -> Iterator[str]:
    """What was audited, the verdict from the pair that decided it, and whether it is more than chance."""
    yield prose(page.title)
    found = views.overview
    if found is not None:
        yield prose(f"Audited: {found.audited}.")
    elif page.spelt:
        yield "\n".join(f"* **Spellings**: {prose(line)}" for line in page.spelt)
    yield lead(page, found)
    if page.targets:
        yield "\n".join(target_line(t) for t in page.targets)
    if found is not None:
        yield "\n".join(f"**Established beyond chance: {word}.** {prose(f'{why[0].upper()}{why[1:]}.')}" for word, why in found.chance)


def groups(page: Content, views: Views) -> Iterator[str]:
    """What each group gets, and the most unequal contexts."""
    gets = "bears" if page.burden else "gets"
    named = (prose(views.group_column), "recorded", prose(views.amount_name))
    heads = (*named, "exactly", "in the population", "mean over units", views.apart_name.lower())
    if views.overall is not None:
        yield f"### What each group {gets}"
        ends = views.overall.rows
        amount = f"{views.amount_name}, mean over units" if views.over_units else views.amount_name
        yield table(
            (*heads[:2], prose(amount), *heads[3:]), [_row(row, views) for row, _ in (*ends[:-1], *views.overall.folded, *ends[-1:])]
        )
    if views.ranking:
        yield "### Contexts, the most unequal first"
        listed = [
            (code(one.title), one.apart.decimal, *(f"{code(row.group)} {views.amount(row.value)}" for row in (one.higher, one.lower)))
            for one, _ in views.first
        ]
        yield table(("context", "difference" if page.signed else "ratio", "highest", "lowest"), listed)
        if more := len(views.others) + views.unranked:
            yield f"and {more:,} more {noun(more, 'context, not', 'contexts, none of them')} more unequal."
    for one in views.contexts[:CONTEXTS]:
        yield f"### What each group {gets}: {code(one.title)}"
        yield table(heads, [_row(row, views) for row, _ in one.rows])
    if (more := len(views.contexts) - CONTEXTS) > 0:
        yield f"What groups get in {more:,} more {noun(more, 'context')} stands on the page (.html)."


def _row(row: Row, views: Views) -> tuple[str, ...]:
    between = views.between(row.ends) if row.ends else ""
    units = views.amount(row.over_units) if row.over_units else ""
    return (code(row.group), row.of, views.amount(row.value), _exact(row.value), between, units, "best" if row.best else row.apart.decimal)


def _figures(page: Content, views: Views) -> Iterator[str]:
    """The exact figures, and what is known of them."""
    yield "### The figures, exactly"
    if views.overview is not None:
        yield prose(page.lead)
    yield table(FIGURES, [figure_row(figure) for figure in page.figures])
    if page.given_truth:
        yield f"### Given the true label\n\n{prose(page.positive)}"
        rows = [figure_row(figure) for figure in page.given_truth]
        yield table(FIGURES, rows)
        listed = [(code(label), true, false) for label, true, false in page.rates]
        if listed:
            yield table(("group", "true positive rate", "false positive rate"), listed)
    for name, rungs in page.ladders.items():
        yield f"### What is known of the ratio {'within contexts' if name == 'local' else 'overall'}"
        yield table(("value", "exactly", "what", "about"), [_rung(rung) for rung in rungs])
    if page.strengths or page.declared_factor:
        yield "### Could something unrecorded explain it?"
        yield from page.declared_factor
    if page.strengths:
        yield (
            "It would have to be k times as common in one group as in another and change what they get m times: with k and m both below "
            "the number under k = m it is too weak, and with one of the k of the last column it needs the m beside it."
        )
        yield table(("ratio", "of", "to be left", "k = m", "or k and m"), [_strength(found) for found in page.strengths])
    if page.drifting:
        yield "### How much may change before this verdict falls"
        yield "\n".join(f"* {prose(text)}" for found in page.drifting for text in (found.title, *found.lines))


def code(text: str) -> str:
    """A text from the input as code, in which markdown sees neither markup, links nor mentions.

    Examples
    --------
    >>> code("a|b <i> @you")
    '<code>a&#124;b &#60;i&#62; &#64;you</code>'
    """
    return "<code>" + "".join(c if c in HARMLESS or c.isalpha() else f"&#{ord(c)};" for c in text) + "</code>"


def prose(text: str) -> str:
    """A sentence that may hold text from the input: as it is where nothing in it could be markup, a link or a mention, else as code.

    Examples
    --------
    >>> prose("In Dept=A, Female is favoured"), prose("#1 www.example.com")
    ('In Dept=A, Female is favoured', '<code>&#35;1 www.example.com</code>')
    """
    harmless = all(c in HARMLESS or c in SAFE_IN_PROSE or c.isalpha() for c in text) and text[:1].isalpha() and not LINK.search(text)
    return text if harmless else code(text)


def table(head: Sequence[str], rows: Sequence[Sequence[str]]) -> str:
    """A table, without the columns that are empty in every row."""
    kept = [i for i in range(len(head)) if any(row[i] for row in rows)]
    lines = [[head[i] for i in kept], ["---"] * len(kept), *([row[i] for i in kept] for row in rows)]
    return "\n".join(f"| {' | '.join(line)} |" for line in lines)


def provenance_lines(found: Provenance | None) -> list[str]:
    """What an attestation says, as blocks; none without one."""
    if found is None:
        return []
    rows = [(code(name), count, size, code(digest)) for name, count, size, digest in found.sources]
    more = [f"and {found.more:,} more sources, which the attestation lists."] if found.more else []
    return [
        f"### {PROVENANCE}",
        intro(),
        "**Checked when this was made:**",
        "\n".join(f"* {prose(text)}" for text in (*found.checked, found.signature)),
        "**Only stated, and nobody can check it here:**",
        "\n".join([*(f"* {name}: {code(text)}" for name, text in found.stated), *([f"* {found.unstated}"] if found.unstated else [])]),
        "**To be checked by whoever has the files, who can take their digests and count them again:**",
        table(("source", "rows", "bytes", "SHA-256"), rows),
        *more,
        f"Whoever has certificate and attestation checks both: `fairaudit verify certificate.json {found.with_it}`",
    ]


def target_line(target: dict[str, str]) -> str:
    """A target, its verdict and the pair of groups that decided it."""
    said = f"* **{target['verdict']}**: {target['name']}, judged for {target['judged']}"
    return f"{said}: {prose(target['pair'])}" if target["pair"] else said


def _exact(value: Value) -> str:
    return value.exact or ("(in the certificate)" if value.rational else "")


def figure_row(figure: Figure) -> tuple[str, ...]:
    """A measure as a row under `FIGURES`."""
    if figure.value is None:
        return (figure.name, "not compared", "", "", "", "")
    sure = f"{figure.ends}, each at {figure.confidence}" if figure.each else figure.ends
    if figure.over_units:
        sure += f" (mean over units, {figure.over_units.decimal} in the table)"
    return (figure.name, figure.value.decimal, figure.logs, _exact(figure.value), sure, prose(figure.witness))


def _strength(found: Strength) -> tuple[str, ...]:
    pairs = ", ".join(f"{k.decimal} and {m.decimal}" for k, m in found.pairs)
    return (f"{found.name}, {found.ratio.decimal}", found.about, found.to.decimal, found.balanced.decimal, pairs)


def _rung(rung: Rung) -> tuple[str, ...]:
    return (rung.value.decimal, _exact(rung.value), rung.name, prose(rung.scope))
