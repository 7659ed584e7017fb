"""What moved between two certificates, and which verdict changed. Rationals are compared exactly."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from math import inf
from typing import Any, Literal

from fairaudit.certificates.evaluation import left_out_of_log
from fairaudit.certificates.fairness import Fairness, drawn_otherwise, fairness
from fairaudit.certificates.moved_laws import radius_notes
from fairaudit.certificates.reader import Subject, number, subject
from fairaudit.errors import InputError, shown
from fairaudit.inference.verdicts import SEVERITY
from fairaudit.measures.expectations import cell_expectation
from fairaudit.measures.limits import limit_text
from fairaudit.model.law import Law
from fairaudit.tables.preparation import said
from fairaudit.theorems.registry import without_objection
from fairaudit.words import BENEFIT, WHATEVER, WHOEVER, brief, ends_text, noun, words_for

__all__ = ["CertificateComparison", "Change", "Moved", "compare_documents"]


Direction = Literal["better", "worse", "same", "changed", "not comparable"]


GIVEN_TRUTH = ("equal_opportunity", "equalized_odds_true_label", "equal_opportunity_overall", "equalized_odds_true_label_overall")

METRICS = ("local", "global", "equalized_odds", "demographic_parity", "local_supremum", "global_supremum")

CONSTANTS = ("gamma", "m", "tau", "lipschitz", "global_tau", "max_drift", "by_context")


@brief
@dataclass(frozen=True, repr=False)
class Change:
    """A statement of the certificates, before and after.

    Attributes
    ----------
    what : str
        What it is about.
    old, new : str or None
        Its exact value or verdict; None where a certificate does not have it.
    direction : {"better", "worse", "same", "changed", "not comparable"}
        "changed" where neither is better; "not comparable" where it looks better, but something that was compared is gone.
    note : str
        What else there is to say.
    """

    what: str
    old: str | None
    new: str | None
    direction: Direction
    note: str = ""


@brief
@dataclass(frozen=True, repr=False)
class Moved:
    """The expected utility of a group in a context (none for a cell that is in one table only).

    Attributes
    ----------
    context, group : dict of str to str
        Which one.
    old, new : Fraction or None
        The expected utility before and after.
    """

    context: Mapping[str, str]
    group: Mapping[str, str]
    old: Fraction | None
    new: Fraction | None


@brief
@dataclass(frozen=True, repr=False)
class CertificateComparison:
    """What moved between two certificates.

    Attributes
    ----------
    verdict : Change
        The overall verdict.
    targets, metrics, intervals, bounds : tuple of Change
        What both certificates, or one of them, say.
    cells : tuple of Moved
        Expected utilities that moved, furthest first; empty when a table is missing.
    amount : str
        What they are: an expected utility, or an expected burden.
    notes : tuple of str
        What to keep in mind: assumptions that came or went, figures that describe different things.
    gone : tuple of str
        Why the new certificate may look better without being so: groups, contexts or decisions that are not there any more, labels that
        count as another one in one of the two, decisions that were left out.
    fairness : tuple of Fairness
        Of the local and of the global ratio: whether the new certificate is less fair than the old one, as far as that is established.

    Examples
    --------
    >>> import fairaudit as fa
    >>> def made(hired):
    ...     table = {"hired": ["yes", "no", "yes", "no"], "sex": ["f", "f", "m", "m"], "n": [hired, 10, 10, 10]}
    ...     return fa.audit(table, decision="hired", group="sex", count="n", utility="yes")
    >>> found = fa.compare(made(10), made(40))
    >>> found.worse, found.risen, [(moved.group, str(moved.old), str(moved.new)) for moved in found.cells]
    (False, True, [({'sex': 'f'}, '1/2', '4/5')])
    """

    verdict: Change
    targets: tuple[Change, ...]
    metrics: tuple[Change, ...]
    intervals: tuple[Change, ...]
    bounds: tuple[Change, ...]
    cells: tuple[Moved, ...]
    notes: tuple[str, ...]
    amount: str = BENEFIT.amount
    gone: tuple[str, ...] = ()
    fairness: tuple[Fairness, ...] = ()

    @property
    def worse(self) -> bool:
        """Whether a verdict got worse, or a target was dropped or weakened."""
        return any(change.direction == "worse" for change in (self.verdict, *self.targets))

    @property
    def risen(self) -> bool:
        """Whether a ratio or distance of the table rose, however little."""
        return any(change.direction == "worse" for change in self.metrics if change.what in (*METRICS[:4], *GIVEN_TRUTH))


def compare_documents(old: Mapping[str, Any], new: Mapping[str, Any], margin: Fraction = Fraction(1)) -> CertificateComparison:
    """Compare two certificates of the same columns and utility.

    Certificates are believed here; `fairaudit.compare` checks both first.

    Parameters
    ----------
    old, new : mapping
        The JSON documents.
    margin : Fraction
        From 1: how many times the old greatest ratio the new one may be before it is less fair.

    Returns
    -------
    CertificateComparison
        What moved.

    Raises
    ------
    InputError
        If the certificates have other columns or another utility, so that their figures do not mean the same.

    Examples
    --------
    >>> from fairaudit import Law, certify
    >>> def made(count):
    ...     law = Law.from_array([[count, 1], [1, 1]], kind="counts", decisions=["yes", "no"], groups=["f", "m"])
    ...     return certify(law, {"yes": 1}, max_local_ratio="8/5", confidence=None).certificate.document
    >>> found = compare_documents(made(3), made(5))
    >>> found.verdict.old, found.verdict.new, found.worse
    ('within', 'exceeds', True)
    >>> found.metrics[0].old, found.metrics[0].new
    ('3/2', '5/3')
    """
    try:
        subjects = subject(old), subject(new)
        _refuse_other_questions(old, new, *subjects)
        found = CertificateComparison(
            _verdict("verdict", old["verdict"], new["verdict"]),
            tuple(_targets(old, new)),
            tuple(
                c for c in _metrics(old["metrics"], new["metrics"]) if c.what != "equalized_odds" or old["subject"]["columns"]["context"]
            ),
            tuple(_intervals(old, new)),
            tuple(_bounds(old, new)),
            tuple(_cells(*subjects)),
            (*radius_notes(old, *subjects), *_notes(old, new, *subjects)),
            words_for(burden="burden" in new["subject"]["utility"]).amount,
            fairness=_fairness(old, new, *subjects, margin),
        )
        otherwise = drawn_otherwise(old, new) if old.get("intervals") and new.get("intervals") else ""
        gone = (*((otherwise,) if otherwise else ()), *_gone(old["subject"], new["subject"], *subjects))
        return _without_false_progress(found, gone, *subjects)
    except (KeyError, IndexError, TypeError, ValueError, AttributeError) as error:
        if isinstance(error, InputError):
            raise
        raise InputError("one of the two is no certificate of the format; fairaudit verify says which, and what is wrong") from None


def _refuse_other_questions(old: Mapping[str, Any], new: Mapping[str, Any], before: Subject | None, after: Subject | None) -> None:
    """Refuse certificates whose figures answer different questions."""
    one, other = old["subject"], new["subject"]
    if one["columns"] != other["columns"]:
        names = ("decision", "group", "context", "truth")
        role, was, now = next(
            (n, one["columns"].get(n), other["columns"].get(n)) for n in names if one["columns"].get(n) != other["columns"].get(n)
        )
        raise InputError(f"the certificates cannot be compared: the {role} column is {shown(was)} in one and {shown(now)} in the other")
    if one.get("positive") != other.get("positive"):
        was, now = shown(one.get("positive"), 200), shown(other.get("positive"), 200)
        raise InputError(f"the certificates cannot be compared: positive is {was} in one and {now} in the other")
    if ("class" in one) != ("class" in other):
        raise InputError("the certificates cannot be compared: one is about the worst utility of a class, the other about one utility")
    if "class" in one:
        if {**one["class"], "rows": 0} != {**other["class"], "rows": 0}:
            raise InputError("the certificates cannot be compared: they are about different classes of utilities")
        return
    if before is None or after is None:
        return
    for label, value in _worth(before).items():
        now = _worth(after).get(label, value)
        if now != value:
            one_worth, other_worth = f"{value} in one", f"{now} in the other"
            raise InputError(f"the certificates cannot be compared: the utility of {shown(label)} is {one_worth} and {other_worth}")
    if before.utility.by_decision != after.utility.by_decision:
        raise InputError("the certificates cannot be compared: the utility depends on the decision alone in one of them only")


def _without_false_progress(
    found: CertificateComparison, gone: tuple[str, ...], before: Subject | None, after: Subject | None
) -> CertificateComparison:
    """The same, but nothing is better if part of what was compared is gone, or nobody knows whether it is."""
    judged = (found.verdict, *found.targets, *found.metrics, *found.intervals)
    if (before is None or after is None) and any(change.direction == "better" for change in judged):
        gone = (*gone, UNSEEN)
    if not gone:
        return found

    def told(change: Change) -> Change:
        return replace(change, direction="not comparable") if change.direction == "better" else change

    kinds = ("targets", "metrics", "intervals", "bounds")
    changes: dict[str, Any] = {name: tuple(map(told, getattr(found, name))) for name in kinds}
    return replace(found, verdict=told(found.verdict), gone=gone, **changes)


def _fairness(
    old: Mapping[str, Any], new: Mapping[str, Any], before: Subject | None, after: Subject | None, margin: Fraction
) -> tuple[Fairness, ...]:
    """Whether the new certificate is less fair; a decision that nobody got takes nothing away from what is compared."""
    if before is None or after is None:
        objections = tuple(WHATEVER if "undecided" in document["subject"] else "" for document in (old, new))
        return fairness(old, new, margin, ((UNSEEN,), (UNSEEN,)), objections)
    kinds = ("group", "context")
    more = (
        tuple(_gone(old["subject"], new["subject"], before, after, kinds)),
        tuple(_gone(new["subject"], old["subject"], after, before, kinds, "is only in the new one")),
    )
    objections = tuple(
        WHATEVER if "undecided" in document["subject"] else WHOEVER if found.law.unknown is not None else ""
        for document, found in ((old, before), (new, after))
    )
    return fairness(old, new, margin, more, objections, "" if _worth_alike(before, after) else UNRELATED)


UNRELATED = "the utility varies with context or group, and it is not the same in both"

UNSEEN = "a certificate does not hold its table, so nobody can see whether every group and context is still there"


def _gone(
    one: Mapping[str, Any],
    other: Mapping[str, Any],
    before: Subject | None,
    after: Subject | None,
    kinds: Sequence[str] = ("group", "context", "decision"),
    said: str = "is not there any more",
) -> Iterator[str]:
    """What the old certificate compared, and the new one does not, or not by itself."""
    yield from _left_out(*([*about.get("preparation", ()), *left_out_of_log(about)] for about in (one, other)))
    if before is None or after is None:
        return
    was, now = before.law, after.law
    for what in kinds:
        first, second = (dict.fromkeys(getattr(law, f"{what}s")) for law in (was, now))
        yield from _listed((f"{what} {shown(label)}" for label in map(_label, first.keys() - second.keys())), said)
    meant = [set(about.get("undecided", {}).get("decisions", ())) for about in (one, other)]
    for label in sorted((meant[0] ^ meant[1]) & {*was.decisions} & {*now.decisions}):
        yield f"the decision {shown(label)} may have meant anything in one and counts at face value in the other"
    old, new = _expectations(before), _expectations(after)
    cells = [(x, a) for x, a in old if (x, a) not in new and x in now.contexts and a in now.groups]
    yield from _listed((f"group {shown(_label(a))} in context {shown(_label(x))}" for x, a in cells), said)
    for about, law in ((one, now), (other, was)):
        for entry in about.get("preparation", ()):
            if entry["step"] in ("mapped", "folded"):
                own = {label for label in entry["from"] if label in _labels_of(law, entry["column"])}
                for label in sorted(own - {entry["label"]}):
                    into = f"counts as {shown(entry['label'])} in one and as a label of its own in the other"
                    yield f"in column {shown(entry['column'])}, {shown(label)} {into}"


def _listed(parts: Iterable[str], said: str, most: int = 3) -> Iterator[str]:
    (*rest,) = sorted(parts)
    yield from (f"{part} {said}" for part in rest[:most])
    if len(rest) > most:
        yield f"{len(rest) - most} more like it {said.replace('is', 'are', 1)}"


def _label(label: str | tuple[str, ...]) -> str:
    return label if isinstance(label, str) else ", ".join(label)


def _labels_of(law: Law, column: str) -> set[str]:
    """Labels of a column, whatever its role."""
    columns = law.columns
    if column == columns.decision:
        return set(law.decisions)
    for names, labels in ((columns.group, law.groups), (columns.context, law.contexts)):
        if column in names:
            return {label[names.index(column)] for label in labels}
    return set()


def _left_out(one: Sequence[Mapping[str, Any]], other: Sequence[Mapping[str, Any]]) -> Iterator[str]:
    """More decisions were left out of the new log than of the old one, in proportion, or by number where there is no proportion."""
    shares = []
    for entries in (one, other):
        found: dict[tuple[str, str], tuple[Fraction, str]] = {}
        for entry in entries:
            unit = next((unit for unit in ("decisions", "rows", "lines") if unit in entry), "")
            if entry["step"] == "left out" and unit:
                amount, of = Fraction(entry[unit]), Fraction(entry.get("of", 1))
                text = f"{entry[unit]} of {entry['of']} {unit}" if "of" in entry else f"{entry[unit]} {unit}"
                found[entry["reason"], unit] = (amount / of, f"{text} left out ({entry['reason']})")
        shares.append(found)
    for key, (share, text) in shares[1].items():
        before, told = shares[0].get(key, (Fraction(0), "none before"))
        if share > before:
            yield f"{text}, {told}"


def _worth(found: Subject) -> dict[str, Fraction]:
    """g(u), where g depends on the decision alone."""
    utility = found.utility
    if not utility.by_decision:
        return {}
    return {u: Fraction(int(v), utility.scale) for u, v in zip(found.law.decisions, utility.values.tolist(), strict=True)}


def _worth_alike(before: Subject, after: Subject) -> bool:
    """Whether each decision that both tables have of a group in a context is worth the same in both."""
    if before.utility.by_decision and after.utility.by_decision:  # or they would have been refused
        return True
    one, other = _worth_by_cell(before), _worth_by_cell(after)
    return all(one[key] == other[key] for key in one.keys() & other.keys())


def _worth_by_cell(found: Subject) -> dict[tuple[Any, ...], Fraction]:
    """g(u, x, a) of the decisions that occur."""
    law, utility = found.law, found.utility
    values: dict[tuple[Any, ...], Fraction] = {}
    for cell, (x, a) in enumerate(zip(law.cell_context.tolist(), law.cell_group.tolist(), strict=True)):
        for u, (weight, value) in enumerate(zip(law.weights[cell].tolist(), utility.row(cell), strict=True)):
            if weight:
                values[law.contexts[x], law.groups[a], law.decisions[u]] = Fraction(value, utility.scale)
    return values


def _severity(verdict: str) -> int:
    """How severe a verdict is beside another certificate's: a ratio that changed is as open as one that the draws do not decide."""
    return SEVERITY["inconclusive" if verdict == "changed" else verdict]


def _verdict(what: str, old: str | None, new: str | None, note: str = "") -> Change:
    direction: Direction = "same"
    if old is None:
        direction = "worse" if new in ("exceeds", "inconclusive") else "changed"
    elif new is None or (new == "none" and old != "none"):
        direction = "worse"
    elif _severity(new) != _severity(old):
        judged = old != "none" or new in ("exceeds", "inconclusive")
        direction = ("worse" if _severity(new) > _severity(old) else "better") if judged else "changed"
    return Change(what, old, new, direction, note)


def _targets(old: Mapping[str, Any], new: Mapping[str, Any]) -> Iterator[Change]:
    before, after = ({(t["quantity"], t["unit"]): t for t in document["targets"]} for document in (old, new))
    for key in dict.fromkeys([*before, *after]):
        was, now = before.get(key), after.get(key)
        if was is None or now is None:
            note = "the target is new" if was is None else "the target was dropped: this is no longer judged"
            yield _verdict(_said(was or now or {}), was and was["verdict"], now and now["verdict"], note)
            continue
        notes, weaker = [], False
        if was["limit"] != now["limit"]:
            looser = number(now["limit"]) > number(was["limit"])
            weaker |= looser
            notes.append(
                f"the limit was {'loosened' if looser else 'tightened'} from {was['limit']} to {now['limit']}; it was: {_said(was)}"
            )
        if _estimand(was) != _estimand(now):
            weaker = True
            notes.append(f"judged by the {_estimand(now)} instead of the {_estimand(was)}")
        if was["judged"] != now["judged"]:
            weaker |= _weaker(was["judged"], now["judged"])
            notes.append(f"judged for {now['judged']} instead of {was['judged']}")
        change = _verdict(_said(now), was["verdict"], now["verdict"], "; ".join(notes))
        yield Change(change.what, change.old, change.new, "worse" if weaker else change.direction, change.note)


def _said(target: Mapping[str, Any]) -> str:
    return limit_text(target["quantity"], target["unit"], Fraction(number(target["limit"])))


def _estimand(entry: Mapping[str, Any]) -> str:
    """What an interval or a target is about."""
    said: str = entry.get("estimand", "mean over rows")
    return said


def _weaker(was: str, now: str) -> bool:
    """Whether the new target is judged with less certainty than the old one."""
    about = [without_objection(text)[0] for text in (was, now)]
    sure = [number(text.rpartition(" ")[2]) if text.startswith("population") else Fraction(-1) for text in about]
    return sure[1] < sure[0]


def _metrics(old: Mapping[str, Any], new: Mapping[str, Any]) -> Iterator[Change]:
    for name in (*METRICS, *(name for name in GIVEN_TRUTH if name in old and name in new)):
        was, now = old[name], new[name]
        first, second = (None if m is None else m.get("ratio", m.get("value")) for m in (was, now))
        note = ""
        if was is not None and now is not None and {**was["witness"], **VALUES} != {**now["witness"], **VALUES}:
            note = "the pair behind it changed"
        yield Change(name, first, second, _direction(first, second), note)
    before, after = (m.get("unfiltered") or {} for m in (old, new))
    for name in ("local", "global"):
        first, second = ((m.get(name) or {}).get("ratio") for m in (before, after))
        if first is not None or second is not None:
            yield Change(f"{name} without filters", first, second, _direction(first, second))


VALUES = {"expectations": 0, "probabilities": 0, "rates": 0}


def _direction(old: str | None, new: str | None) -> Direction:
    if old == new:
        return "same"
    if old is None or new is None:
        return "changed"
    return "worse" if number(new) > number(old) else "better"


def _intervals(old: Mapping[str, Any], new: Mapping[str, Any]) -> Iterator[Change]:
    before, after = old.get("intervals", {}), new.get("intervals", {})
    for name in ("local", "global"):
        was, now = before.get(name), after.get(name)
        if was is None and now is None:
            continue
        texts = [None if i is None else ends_text(*i["ratio"], each=i["ends"] == "each") for i in (was, now)]
        direction: Direction = "same" if was and now and was["ratio"] == now["ratio"] else "changed"
        note = ""
        if was is not None and now is not None:
            ends = [[number(end) for end in i["ratio"]] for i in (was, now)]
            if _estimand(was) != _estimand(now):
                direction, note = "changed", f"about the {_estimand(now)} instead of the {_estimand(was)}"
            elif drawn_otherwise(old, new):
                direction, note = "changed", drawn_otherwise(old, new)
            elif ends[1][0] > ends[0][1]:
                direction, note = "worse", "the intervals do not overlap"
            elif ends[1][1] < ends[0][0]:
                direction, note = "better", "the intervals do not overlap"
            elif direction == "changed":
                note = "the intervals overlap: the difference may be chance"
            if was["confidence"] != now["confidence"]:
                note += f"{'; ' if note else ''}confidence {now['confidence']} instead of {was['confidence']}"
            if was["ends"] != now["ends"]:
                note += f"{'; ' if note else ''}the confidence is that of {CONFIDENT[now['ends']]}, before of {CONFIDENT[was['ends']]}"
        yield Change(name, texts[0], texts[1], direction, note)


CONFIDENT = {"each": "each end by itself", "together": "both ends together"}


def _bounds(old: Mapping[str, Any], new: Mapping[str, Any]) -> Iterator[Change]:
    """What policies can do at most, matched by quantity, theorem and scope; ends of a population stand with the intervals."""

    def listed(document: Mapping[str, Any]) -> dict[tuple[str, str, str], str]:
        claims = (c for c in document["claims"] if c["relation"] == "<=" or c["by"] == "T13")
        return {(c["quantity"], c["by"], c["scope"]): c["value"] for c in claims if not c["scope"].startswith("population")}

    before, after = listed(old), listed(new)
    for key in dict.fromkeys([*before, *after]):
        was, now = before.get(key), after.get(key)
        yield Change(f"{key[0]} by {key[1]}, about {key[2]}", was, now, _direction(was, now))


def _cells(before: Subject | None, after: Subject | None) -> list[Moved]:
    if before is None or after is None:
        return []
    was, now = _expectations(before), _expectations(after)
    group, context = before.law.columns.group, before.law.columns.context
    moved = []
    for key in dict.fromkeys([*was, *now]):
        first, second = was.get(key), now.get(key)
        if first != second:
            moved.append(Moved(dict(zip(context, key[0], strict=True)), dict(zip(group, key[1], strict=True)), first, second))
    return sorted(moved, key=lambda m: inf if m.old is None or m.new is None else abs(m.new - m.old), reverse=True)


def _expectations(found: Subject) -> dict[tuple[tuple[str, ...], tuple[str, ...]], Fraction]:
    law = found.law
    places = enumerate(zip(law.cell_context.tolist(), law.cell_group.tolist(), strict=True))
    return {(law.contexts[x], law.groups[a]): Fraction(*cell_expectation(law, found.utility, cell)) for cell, (x, a) in places}


def _notes(old: Mapping[str, Any], new: Mapping[str, Any], before: Subject | None, after: Subject | None) -> Iterator[str]:
    one, other = old["subject"], new["subject"]
    if ("burden" in one["utility"]) != ("burden" in other["utility"]):
        which, else_ = ("old", "new") if "burden" in one["utility"] else ("new", "old")
        yield f"in the {which} certificate the utility counts a burden, in the {else_} one a benefit: who is called favoured is reversed"
    if one["kind"] != other["kind"]:
        yield f"one is about {KINDS[one['kind']]}, the other about {KINDS[other['kind']]}: their figures describe different things"
    if one["population"] != other["population"]:
        yield "the populations come from different places, so the global figures may differ for that reason alone"
    if before is None or after is None:
        yield "a certificate does not hold its table: single groups, and whether the utilities are the same, could not be compared"
        if any(one["utility"][name] != other["utility"][name] for name in ("gamma", "m")):
            yield "the utilities have different ranges, so the figures may not mean the same"
    else:
        for what in ("groups", "contexts", "decisions"):
            first, second = getattr(before.law, what), getattr(after.law, what)
            gone, come = len(set(first) - set(second)), len(set(second) - set(first))
            if gone or come:
                yield f"{what}: {gone} only in the old table, {come} only in the new one; what is compared is not the same"
        if not before.utility.by_decision:
            alike = "it is the same in both for all decisions that both have of a group in a context"
            yield f"the utility varies with context or group; {alike}" if _worth_alike(before, after) else UNRELATED
    if one["table"]["sha256"] == other["table"]["sha256"]:
        yield "both are about the same table"
    for name in CONSTANTS:
        if one.get("declared", {}).get(name) != other.get("declared", {}).get(name):
            yield f"declared {name}: {one.get('declared', {}).get(name, 'none')} before, {other.get('declared', {}).get(name, 'none')} now"
    if one.get("privacy") != other.get("privacy") and "privacy" in one and "privacy" in other:
        first, second = (about["privacy"]["group"]["exp_epsilon"] for about in (one, other))
        yield f"e^epsilon of the group filter: {first} before, {second} now"
    told = [dict.fromkeys(said(about)) for about in (one, other)]
    yield from (f"only now: {text}" for text in told[1] if text not in told[0])
    yield from (f"no longer: {text}" for text in told[0] if text not in told[1])
    if old["not_compared"] != new["not_compared"]:
        yield (
            f"what was not compared differs: {len(old['not_compared'])} "
            f"{noun(len(old['not_compared']), 'entry', 'entries')} before, {len(new['not_compared'])} now"
        )
    resting = [[*document["claims"], *([document["changed"]] if "changed" in document else [])] for document in (old, new)]
    assumed = [{text for statement in statements for text in statement["assumptions"]} for statements in resting]
    yield from (f"assumed only now: {text}" for text in sorted(assumed[1] - assumed[0]))
    yield from (f"no longer assumed: {text}" for text in sorted(assumed[0] - assumed[1]))


KINDS = {"counts": "counts", "probabilities": "probabilities", "policy": "a policy behind filters"}
