"""A certificate as part of a model card: measures that programs read (`model-index`), and what they mean under the headings of cards."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from fractions import Fraction
from math import isinf
from typing import Any

from fairaudit.certificates.certificate import Certificate
from fairaudit.reports.content import UNCHECKED, Content, Figure, describe, refusing_other_documents
from fairaudit.reports.markdown import FIGURES, code, figure_row, groups, lead, prose, table, target_line
from fairaudit.reports.provenance import Provenance, amount_text
from fairaudit.reports.undecided import undecided_lines
from fairaudit.reports.views import Views
from fairaudit.words import WHATEVER, approximate

__all__ = ["model_card"]

FILL_IN = "FILL IN"

TYPE = "fairaudit-"

RATIOS = {"local": "Local ratio", "global": "Global ratio"}

WITHIN = ("local", "local_difference", "equalized_odds", "equal_opportunity", "equalized_odds_true_label")

DEFINITIONS = {
    "difference": "by how much the {amount} of two groups differs at most{where}; 0 is alike",
    "local": "how many times as great the {amount} of one group is as that of another, at most{where}; 1 is alike",
    "global": "how many times as great the {amount} of one group is as that of another, at most{where}; 1 is alike",
    "equal_opportunity": "how far apart the true positive rates of two groups are at most{where}; 0 is alike",
    "true_label": "the same, or the false positive rates where those are further apart{where}; 0 is alike",
    "equalized_odds": "the total variation between the decisions of two groups, at most{where}; 0 is alike, 1 disjoint",
    "demographic_parity": "the total variation between the decisions of two groups, at most{where}; 0 is alike, 1 disjoint",
}
"""What measures are; the first key that is part of the name of a measure says it."""

DIGITS = 4

MOST_DIGITS = 17  # of a float, as which numbers of YAML are read


@refusing_other_documents
def model_card(certificate: Certificate | Mapping[str, Any], *, checked: str = "", provenance: Provenance | None = None) -> str:
    """Write a certificate as the part of a model card that is about fairness: YAML in front, then markdown.

    Parameters
    ----------
    certificate : Certificate or mapping
        The certificate, or its JSON document.
    checked : str
        A sentence on who checked the certificate; without one, that of a certificate without its table says that nobody did.
    provenance : Provenance, optional
        What is attested of it: names of the system and of the audit, and when decisions were made. Without it they are left to fill in.

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
    >>> card = model_card(certify(law, {"yes": 1}, confidence=None).certificate)
    >>> next(line.strip() for line in card.splitlines() if "exactly" in line)
    'name: "Global ratio, exactly 3/2"'
    """
    page = describe(certificate.document if isinstance(certificate, Certificate) else certificate)
    views = Views(page)
    head = "\n".join(("---", *_index(page, views, provenance), "---"))
    return "\n\n".join((head, *_limits(page, views), *_data(page, views, provenance), *_results(page, views, checked, provenance))) + "\n"


def _index(page: Content, views: Views, provenance: Provenance | None) -> Iterator[str]:
    """The measures as the YAML that sites of models read."""
    stated = None if provenance is None else provenance.statement.stated
    system = " ".join(filter(None, (stated.system, stated.system_version))) if stated else ""
    title = stated.title if stated else None
    said = page.document["subject"].get("evaluation", {})
    of_texts = "extract" in said or said.get("format", "rows") != "rows"
    yield "model-index:"
    yield f"- name: {quoted(system or f'{FILL_IN}: the system and its version')}"
    yield "  results:"
    yield "  - task:"
    yield f"      type: {'text-generation' if of_texts else 'tabular-classification'}"
    yield "    dataset:"
    yield f"      type: {'evaluation-log' if of_texts else 'decision-log'}"
    yield f"      name: {quoted(title or f'{FILL_IN}: which decisions these are')}"
    yield f"      revision: {quoted(page.document['subject']['table']['sha256'])}"
    yield "    metrics:"
    for figure, value in _measured(page):
        limits = [Fraction(limit.value) for limit in views.limits.get(figure.key, ()) if not isinf(limit.value)]
        yield f"    - type: {_type(figure)}"
        yield f"      value: {yaml_number(value, limits)}"
        yield f"      name: {quoted(_name(figure, of_known=bool(page.unknown), meant=bool(page.undecided)))}"


def _measured(page: Content) -> Iterator[tuple[Figure, Fraction | float]]:
    """The measures that have a value; without contexts the ratio within them is the other one."""
    contexts = bool(page.document["subject"]["columns"]["context"])
    for figure in (*page.figures, *page.given_truth):
        if figure.value is not None and (contexts or not figure.key.startswith("local")):
            yield figure, figure.value.value


def _type(figure: Figure) -> str:
    return f"{TYPE}{figure.key.replace('_', '-')}{'-ratio' * (figure.key in RATIOS)}"


def _definition(figure: Figure, page: Content) -> str:
    """What a measure is, in a line."""
    contexts = bool(page.document["subject"]["columns"]["context"])
    where = (", in the same context" if figure.key in WITHIN else ", over all contexts") if contexts else ""
    said = next(text for key, text in DEFINITIONS.items() if key in figure.key)
    return said.format(amount=page.amount, where=where)


def _name(figure: Figure, *, of_known: bool, meant: bool) -> str:
    exact = "" if figure.value is None else figure.value.exact
    said = f"{RATIOS.get(figure.key, figure.name)}, {f'exactly {exact}' if exact else 'whose exact value is in the certificate'}"
    if of_known:
        said += ", of the decisions whose group is known"
    if figure.over_units:
        said += f"; mean over units {figure.over_units.decimal}"
    under = f", {WHATEVER}" if meant else ""
    return f"{said}; in the population {figure.ends}, {'each ' * figure.each}at {figure.confidence}{under}" if figure.ends else said


def quoted(text: str) -> str:
    r"""A text as a scalar of YAML, whatever is in it.

    Examples
    --------
    >>> print(quoted('a: "b" # é'), quoted("\n---\u202e"))
    "a: \"b\" # é" "\n---\u202E"
    """
    return '"' + "".join(c if c.isprintable() and c not in '"\\' else _escape(c) for c in text) + '"'


def _escape(character: str) -> str:
    place = ord(character)
    if character in '"\\':
        return f"\\{character}"
    return "\\n" if character == "\n" else f"\\u{place:04X}" if place < 1 << 16 else f"\\U{place:08X}"


def yaml_number(value: Fraction | float, limits: Sequence[Fraction] = ()) -> str:
    """A number of YAML: four digits, or so many that it is on the same side of 1 and of every limit as the value itself.

    Examples
    --------
    >>> yaml_number(Fraction(2198330, 1498887)), yaml_number(Fraction(100_001, 100_000)), yaml_number(Fraction(10**9 + 1, 7))
    ('1.467', '1.00001', '1.429e+08')
    """
    if not isinstance(value, Fraction):
        return quoted("inf")
    for digits in range(DIGITS, MOST_DIGITS + 1):
        text = approximate(value, digits=digits)
        shown = Fraction(text)
        if all(side == value or (shown > side, shown < side) == (value > side, value < side) for side in (Fraction(1), *limits)):
            break
    mantissa, e, exponent = text.partition("e")
    return f"{mantissa}{'' if '.' in mantissa else '.0'}e{exponent}" if e else text


def _limits(page: Content, views: Views) -> Iterator[str]:
    """What was found, and what it does not say."""
    found = views.overview
    yield "## Bias, Risks, and Limitations"
    yield lead(page, found)
    if found is not None:
        yield "\n".join(f"* Established beyond chance: {word}. {prose(f'{why[0].upper()}{why[1:]}.')}" for word, why in found.chance)
    if page.undecided:
        yield "\n".join(f"* {prose(text)}" for text in undecided_lines(page.document, page.subject))
    judged = [f"* {prose(text)} (for statements about {prose(scopes)})" for text, scopes in page.assumptions]
    yield "These figures rest on what no program can check:"
    yield "\n".join(
        [*judged, *(f"* {line}" for line in page.limits), f"* {FILL_IN}: who is affected, and what else is known of this system."]
    )


def _data(page: Content, views: Views, provenance: Provenance | None) -> Iterator[str]:
    """What was measured, on what, and between whom."""
    yield "## Evaluation"
    yield "### Testing Data, Factors & Metrics"
    yield "#### Testing Data"
    yield "\n".join(_stated(provenance))
    audited = "" if views.overview is None else f"* {prose(f'Audited: {views.overview.audited}.')}\n"
    yield f"{audited}* Digest of the table (SHA-256): {code(page.document['subject']['table']['sha256'])}."
    if views.as_read:
        yield "\n".join(f"* {prose(line)}" for line in views.as_read)
    yield "#### Factors"
    facts = dict(page.facts)
    yield "\n".join(f"* {name}: {prose(facts[name])}" for name in ("Groups", "Contexts"))
    if page.not_compared:
        yield "Not compared:\n\n" + "\n".join(f"* {prose(line)}" for line in page.not_compared)
    yield "#### Metrics"
    what = "Burden" if page.burden else "Utility"
    yield "\n".join(f"* {name}: {prose(fact)}" for name, fact in facts.items() if name not in ("Groups", "Contexts"))
    yield "\n".join(f"* `{_type(figure)}`: {_definition(figure, page)}" for figure, _ in _measured(page))
    yield f"{FILL_IN}: why these groups, this {what.lower()} and these limits."


def _stated(provenance: Provenance | None) -> Iterator[str]:
    """What is said of the decisions: by the issuer, or by nobody yet."""
    if provenance is None:
        yield f"* {FILL_IN}: which decisions these are, of which system, from when to when, and how they were collected."
        return
    statement, stated = provenance.statement, provenance.statement.stated
    said = {
        "Title": stated.title,
        "System": " ".join(filter(None, (stated.system, stated.system_version))),
        "Period": " to ".join(stated.period or ()),
        "Issuer": stated.issuer,
    }
    yield from (f"* {name}: {prose(text)}" for name, text in said.items() if text)
    for source in statement.sources:
        yield f"* Source: {code(source.name)}" + (f", SHA-256 {code(source.sha256)}" if source.sha256 else "")
    rows, unit = statement.rows, statement.rows.unit
    dropped = "".join(f", {amount_text(amount)} dropped ({prose(reason)})" for reason, amount in rows.dropped.items())
    yield f"* {amount_text(rows.read)} {unit} read, {amount_text(rows.counted)} counted{dropped}."
    yield "* This is what the issuer states; no program can check it from here."


def _results(page: Content, views: Views, checked: str, provenance: Provenance | None) -> Iterator[str]:
    """The figures, and how to check them."""
    yield "### Results"
    if page.targets:
        yield "\n".join(target_line(target) for target in page.targets)
    yield from (f"#{block}" if block.startswith("###") else block for block in groups(page, views))
    if page.unknown:
        yield "#### Decisions without a recorded group"
        yield "\n".join(f"* {prose(found.sentence)}" for found in page.unknown)
    yield "#### Figures"
    yield table(FIGURES, [figure_row(figure) for figure in (*page.figures, *page.given_truth)])
    yield "#### Summary"
    yield f"{page.headline}. {prose(page.lead)}" if page.lead else f"{page.headline}."
    beside = "" if page.subject else " --table certificate.table.jsonl"
    with_it = "" if provenance is None else f" {provenance.with_it}"
    yield f"`fairaudit verify certificate.json{beside}{with_it}` checks every figure and uses none of the code that made them."
    if provenance is not None:
        yield prose(provenance.signature)
    if checked := checked or ("" if page.subject else UNCHECKED):
        yield checked
