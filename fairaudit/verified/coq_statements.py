"""A table and what a certificate states of it, in a Coq file: in the words of proofs/checker/Table.v and Statements.v."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from fairaudit.verified.coq_text import boolean, comment, entries, integer, items, label, named, option, pair, rational

__all__ = ["Statement", "definitions", "induced_table", "stated_table", "statements", "theorem"]

_POPULATIONS = {"counts": "Counted", "weights": "Given", "equal": "Alike"}

_FIGURES = {
    "local": "Local",
    "global": "Global",
    "demographic_parity": "Demographic_parity",
    "equalized_odds": "Equalized_odds",
    "local_supremum": "Local_supremum",
    "global_supremum": "Global_supremum",
    "local_difference": "Local_difference",
    "global_difference": "Global_difference",
    "equal_opportunity": "(Equal_opportunity false)",
    "equal_opportunity_overall": "(Equal_opportunity true)",
    "equalized_odds_true_label": "(Odds_given_truth false)",
    "equalized_odds_true_label_overall": "(Odds_given_truth true)",
}
_RATES = {"true_positive_rate": 0, "false_positive_rate": 1}

_APART = {
    "class": "that the utility of the table is one of the class",
    "privacy": "what the filters let through",
    "declared": "that what was declared holds of the policy and its utility",
    "preparation": "what was done to the log before it was counted",
    "evaluation": "the log of a model's evaluation that was counted, and which of its answers decide nothing",
    "spellings": "labels that differ in spelling alone",
    "undecided": "decisions that may have meant anything",
    "unknown_shares": "the shares of decisions of unknown group",
    "max_drift": "how far the laws may have moved",
}
"""What a subject can hold besides its table, and what is said by it."""


@dataclass(frozen=True)
class Statement:
    """A statement of a certificate: its place in the document, its kind, and how Coq says it (nothing, if Coq cannot)."""

    place: str
    said: str
    term: str = ""

    @property
    def covered(self) -> bool:
        """Whether Coq can say it: all that it can say of a table, `is_true_of` of proofs/checker/Checker.v decides."""
        return bool(self.term)


def definitions(table: Sequence[str], proved: Sequence[Statement]) -> list[str]:
    """The table, and the list of the statements that are proved of it.

    Parameters
    ----------
    table : sequence of str
        The lines that define it as T.
    proved : sequence of Statement
        What is to be proved.
    """
    return [
        "Module Table_and_statements.",
        "Import Table Statements.",
        "",
        *table,
        "",
        comment("What each of them says of the table stands in checker/Meaning.v, as holds. The number of what does not apply is -1."),
        f"Definition all_statements : list statement := {entries([(one.term, f'{one.place}: {one.said}') for one in proved])}.",
        "End Table_and_statements.",
    ]


def induced_table() -> list[str]:
    """The table of the law that a policy and its filters induce, as Coq computes it."""
    return [
        comment("The law that policy and filters induce, by true context and true group"),
        "Definition T : table := Policy.induced_table Behind_filters.S.",
    ]


def stated_table(header: Mapping[str, Any], rows: Sequence[Mapping[str, Any]], subject: Mapping[str, Any]) -> list[str]:
    """The table as a certificate states it.

    Parameters
    ----------
    header, subject : mapping
        The header of the table and the subject of the certificate.
    rows : sequence of mapping
        The lines of the table.
    """
    columns = header["columns"]

    def cell(row: Mapping[str, Any]) -> tuple[str, str]:
        of = named(columns["context"], header["contexts"][row["context"]]), named(columns["group"], header["groups"][row["group"]])
        gains = [option(None if gain is None else rational(gain)) for gain in row.get("utility", [])]
        truth = [items(map(rational, counts)) for counts in row.get("truth", [])]
        numbers = f"{items(map(rational, row['weights']))} {items(gains)} {rational(row.get('mass', '0'))} {items(truth)}"
        return f"Cell {integer(row['context'])} {integer(row['group'])} {numbers}", "; ".join(of)

    known = "None"
    if "truths" in header:
        positive, truths = subject["positive"], header["truths"]
        decisions = items(str(header["decisions"].index(text)) for text in positive["decision"])
        known = option(f"(Truth {decisions}%Z {truths.index(positive['truth'])} {len(truths)} {boolean(columns['context'] != [])})")
    utility = None if header["utility"] is None else items(map(rational, header["utility"]))
    return [
        comment("A cell has its context, its group, the weights of the decisions, their utilities where these depend on more"),
        comment("than the decision, its mass where masses are given, and the weights by true label where that is known."),
        *(
            [
                comment(
                    "Known are the positive decisions, the positive true label, how many labels there are, and whether contexts are pooled."
                )
            ]
            if "truths" in header
            else []
        ),
        "Definition T : table := {|",
        f"  contexts := {len(header['contexts'])};",
        f"  groups := {len(header['groups'])};",
        f"  decisions := {len(header['decisions'])};",
        f"  population := {_POPULATIONS[header['population']]};",
        f"  utility := {option(utility)};",
        f"  known := {known};",
        f"  cells := {entries([cell(row) for row in rows], '    ')}",
        "|}.",
    ]


def theorem() -> list[str]:
    """The theorem that all of them hold."""
    return [
        "Module Proved_of_the_table.",
        "Import Table Statements Table_and_statements.",
        "Theorem all_hold (R : realFieldType) : forall s, In s all_statements -> Meaning.holds R T s.",
        "Proof. apply: AllTrue.all_true_hold; vm_compute; reflexivity. Qed.",
        "End Proved_of_the_table.",
    ]


class _Numbers:
    """The numbers of labels."""

    def __init__(self, header: Mapping[str, Any]) -> None:
        self.columns = header["columns"]
        self.decisions = {text: i for i, text in enumerate(header["decisions"])}
        self.groups = {tuple(labels): i for i, labels in enumerate(header["groups"])}
        self.contexts = {tuple(labels): i for i, labels in enumerate(header["contexts"])}

    def group(self, labels: Mapping[str, str] | Sequence[str]) -> int:
        return self.groups[tuple(labels[column] for column in self.columns["group"]) if isinstance(labels, Mapping) else tuple(labels)]

    def context(self, labels: Mapping[str, str] | Sequence[str] | None) -> str:
        if labels is None:
            return "(-1)"
        found = tuple(labels[column] for column in self.columns["context"]) if isinstance(labels, Mapping) else tuple(labels)
        return str(self.contexts[found])


def _value(text: str | None) -> str:
    return option(None if text is None or text == "inf" else rational(text))


def _figure(metric: Mapping[str, Any] | None, number: _Numbers) -> str:
    if metric is None:
        return "None"
    witness = metric["witness"]
    rate = _RATES[witness["rate"]] if "rate" in witness else "(-1)"
    decision = number.decisions[witness["decision"]] if "decision" in witness else "(-1)"
    groups = f"{number.group(witness['higher'])} {number.group(witness['lower'])}"
    place = f"(Place {rate} {number.context(witness.get('context'))} {decision} {groups})"
    two = next((witness[key] for key in ("expectations", "probabilities", "rates") if key in witness), None)
    raised = items(str(number.decisions[text]) for text in witness.get("decisions", []))
    both = option(None if two is None else pair(*map(rational, two)))
    return option(f"(Figure {_value(metric.get('ratio', metric.get('value')))} {place} {both} {raised}%Z)")


def _of_utility(utility: Mapping[str, Any]) -> Iterator[Statement]:
    for key, term in (
        ("gamma", f"Gamma_is {rational(utility['gamma'])}"),
        ("m", f"Least_is {rational(utility['m'])}"),
        ("tau", f"Tau_is {_value(utility['tau'])}"),
        ("lipschitz", f"Lipschitz_is {rational(utility['lipschitz'])}"),
        ("depends_on_group", f"Depends_on_group_is {boolean(utility['depends_on_group'])}"),
    ):
        stated = utility[key]
        yield Statement(f"subject.utility.{key}", label("none" if stated is None else str(stated)), term)


def _of_subject(subject: Mapping[str, Any]) -> Iterator[Statement]:
    """What is stated of more than the table, none of which Coq can say."""
    for key, said in _APART.items():
        if key in subject:
            yield Statement(f"subject.{key}", said)


def _of_draws(document: Mapping[str, Any]) -> Iterator[Statement]:
    """What is stated of a population, or of a stream."""
    for key in document.get("intervals", {}):
        yield Statement(f"intervals.{label(key)}", "not written out")
    if "changed" in document:
        yield Statement("changed", "that a window of the stream contradicts what is stated of all of it")


def _of_metrics(metrics: Mapping[str, Any], number: _Numbers) -> Iterator[Statement]:
    for key, quantity in _FIGURES.items():
        if key in metrics:
            stated = metrics[key]
            said = "nobody is compared" if stated is None else label(stated.get("ratio", stated.get("value")))
            yield Statement(f"metrics.{key}", said, f"Figure_is {quantity} {_figure(stated, number)}")
    for key, stated in metrics.items():
        if key.removesuffix("_overall") in _RATES and stated is not None:
            overall = key.endswith("_overall")
            rates = items(
                pair(f"{number.context(None if overall else one['context'])}%Z", f"{number.group(one['group'])}%Z", rational(one["rate"]))
                for one in stated
            )
            term = f"Rates_are {_RATES[key.removesuffix('_overall')]} {boolean(overall)} {rates}"
            yield Statement(f"metrics.{label(key)}", "the rates", term)
        elif key not in _FIGURES:
            yield Statement(f"metrics.{label(key)}", "not written out")


def _left_out(entry: Mapping[str, Any], number: _Numbers) -> str:
    reason, groups = entry["reason"], items(str(number.group(labels)) for labels in entry.get("groups", []))
    kind = entry.get("quantity", "")
    if kind.removesuffix("_overall") in _RATES:
        x = number.context(None if kind.endswith("_overall") else entry["context"])
        rate = _RATES[kind.removesuffix("_overall")]
        return f"No_rate {rate} {x} {groups}%Z" if "groups" in entry else f"Rate_alone {rate} {x}"
    if kind:
        return "No_means_alone" if reason == "fewer than two groups" else "No_means_missing"
    if reason == "no population":
        return f"No_population {groups}%Z"
    x = number.context(entry["context"])
    return f"No_decisions {x} {groups}%Z" if "groups" in entry else f"Alone {x}"


def _level(level: Mapping[str, Any]) -> str:
    pairs = items(pair(rational(k), rational(m)) for k, m in level["pairs"])
    return f"Level {rational(level['to'])} {_value(level['balanced'])} {pairs}"


_MOVES = {"radius": "By_variation", "factor": "By_factor"}


def _of_drift(claim: Mapping[str, Any], number: _Numbers, drift: str | None) -> str:
    """How Coq says a claim by T16 about the table; nothing of logarithms, and where a bound takes the place of a mean."""
    evidence, local = claim["evidence"], claim["quantity"].startswith("local")
    _, unit, *form = claim["quantity"].split("_")
    followed = [number.group(labels) for labels in evidence["followed"]]
    if unit == "log" or (not local and {*followed} != {*number.groups.values()}):
        return ""
    pair = evidence["pair"]
    place = (
        None
        if pair is None
        else f"(Place (-1) {number.context(pair['context'])} (-1) {number.group(pair['higher'])} {number.group(pair['lower'])})"
    )
    shown = f"{option(place)} {items(map(str, followed))}%Z"
    if form and claim["scope"] == "this law":
        within, exact = boolean(evidence["verdict"] == "within"), boolean(claim["relation"] == "=")
        stand = f"Stand {_MOVES[form[0]]} {boolean(local)} {within} {_value(claim['value'])} {exact} {shown}"
        return f"Stands ({stand}) {rational(evidence['limit'])}"
    if not form and claim["scope"] == "this law, within the declared drift" and drift is not None:
        greatest = boolean(claim["relation"] == "<=")
        return f"Ratio_under_drift {boolean(local)} {greatest} {rational(drift)} {_value(claim['value'])} {shown}"
    return ""


def _of_claims(claims: Sequence[Mapping[str, Any]], number: _Numbers, drift: str | None) -> Iterator[Statement]:
    for i, claim in enumerate(claims):
        quantity, by, term = claim["quantity"], claim["by"], ""
        if claim["scope"] == "this law":
            ratio = quantity.removesuffix("_ratio")
            name = _FIGURES.get(ratio if ratio in ("local", "global") and ratio != quantity else quantity)
            if by == "enumeration" and claim["relation"] == "=" and name is not None:
                term = f"Quantity_is {name} {_value(claim['value'])}"
            elif by == "T6" and claim["relation"] == "=":
                term = f"Supremum_is {boolean(quantity == 'local_ratio_supremum')} {_value(claim['value'])}"
            elif by in ("T5", "T7") and claim["relation"] == "<=" and name is not None:
                term = f"Quantity_at_most By_{by} {name} {_value(claim['value'])}"
            elif by == "T14" and quantity in ("local_hidden_context", "global_hidden_context"):
                levels = items(map(_level, claim["evidence"]["frontier"]))
                term = f"Hidden_needs {boolean(quantity == 'local_hidden_context')} {_value(claim['value'])} {levels}"
        if by == "T16" and claim["scope"].startswith("this law"):
            term = _of_drift(claim, number, drift)
        said = label(f"{quantity} {claim['relation']} {claim['value']} by {by}, of {claim['scope']}")
        yield Statement(f"claims[{i}]", said, term)


def _of_targets(targets: Sequence[Mapping[str, Any]]) -> Iterator[Statement]:
    for i, target in enumerate(targets):
        term, unit = "", target["unit"]
        if target["judged"] == "this table" and unit in ("ratio", "difference"):
            local, limit = boolean(target["quantity"] == "local"), rational(target["limit"])
            term = f"Target_is By_{unit} {local} {limit} {target['verdict'].capitalize()}"
        said = f"{target['quantity']} {unit} at most {target['limit']}, {target['judged']}: {target['verdict']}"
        yield Statement(f"targets[{i}]", label(said), term)


def statements(document: Mapping[str, Any], header: Mapping[str, Any]) -> list[Statement]:
    """List what a certificate of a table of decisions states, in the order of the document.

    Parameters
    ----------
    document : mapping
        The certificate.
    header : mapping
        The header of its table.
    """
    number = _Numbers(header)
    subject, judgements = document["subject"], ("within", "exceeds", "inconclusive", "depends")
    cells = integer(subject["table"]["cells"])  # of a policy: of its rows, not of the law that it induces
    found = [Statement("subject.table.cells", cells, f"Entries_are {cells}" if subject["kind"] != "policy" else "")]
    found += _of_utility(subject["utility"])
    found += _of_subject(subject)
    found += _of_metrics(document["metrics"], number)
    left_out = items(_left_out(entry, number) for entry in document["not_compared"])
    found.append(Statement("not_compared", f"{len(document['not_compared'])} entries", f"Not_compared_is {left_out}"))
    found += _of_claims(document["claims"], number, subject.get("max_drift"))
    found += _of_targets(document["targets"])
    verdicts = [target["verdict"] for target in document["targets"]]
    verdict = document["verdict"]
    if {verdict, *verdicts} <= {*judgements, "none"}:
        stated = option(None if verdict == "none" else verdict.capitalize())
        found.append(Statement("verdict", label(verdict), f"Verdict_is {items(text.capitalize() for text in verdicts)} {stated}"))
    else:
        found.append(Statement("verdict", label(verdict)))
    found += _of_draws(document)
    return found
