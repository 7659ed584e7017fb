"""What a report says of a certificate, before it has a shape."""

from __future__ import annotations

import itertools
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from fractions import Fraction
from functools import cached_property, wraps
from typing import Any, Literal, get_args

from fairaudit.audits.differences import decide_difference, difference_pair, difference_sentence
from fairaudit.audits.sentences import (
    Deciding,
    Drivers,
    Sizes,
    caution,
    change_text,
    decide,
    few_of_policy,
    foremost,
    headline_pair,
    identifier_text,
    pair_text,
    sentence,
    size_text,
    sizes,
)
from fairaudit.audits.targets import Target
from fairaudit.certificates.certificate import Certificate
from fairaudit.certificates.reader import Subject, mean_difference, number, ratio, subject
from fairaudit.errors import InputError
from fairaudit.inference.anytime import stream_drivers
from fairaudit.inference.differences import difference_drivers
from fairaudit.inference.ratio_intervals import drivers as interval_drivers
from fairaudit.measures.differences import MeanDifference
from fairaudit.measures.limits import Quantity, limit_text
from fairaudit.measures.rates import KINDS, NAMES, OVERALL
from fairaudit.measures.ratios import Ratio, Witness
from fairaudit.reports.drift import Standing, standings
from fairaudit.reports.expectations import Expectations, Matrix, Panel
from fairaudit.reports.hidden_context import Strength, declared, strengths
from fairaudit.reports.ladder import Calibrated, Rung, calibration, ladder
from fairaudit.reports.lost_answers import LostAnswers, lost_answers
from fairaudit.reports.overview_parts import counted_decisions
from fairaudit.reports.undecided import MeantRange, undecided_of, undecided_ranges, undecided_said
from fairaudit.reports.unknown_groups import UnknownRange, unknown_ranges
from fairaudit.reports.verdicts import judged_targets
from fairaudit.reports.words import Value, claimed, clip, how, named, quantity, scope
from fairaudit.tables.preparation import said
from fairaudit.words import THE_INTERVAL, THIS_TABLE, Words, approximate, ends_text, noun, percent, place, plain, words_for


def refusing_other_documents(function: Callable[..., str]) -> Callable[..., str]:
    """Turn a document of the wrong shape into a sentence."""

    @wraps(function)
    def checked(certificate: Certificate | Mapping[str, Any], *, checked: str = "", **more: Any) -> str:
        try:
            return function(certificate, checked=checked, **more)
        except (KeyError, IndexError, TypeError, ValueError, AttributeError) as error:
            if isinstance(error, InputError):
                raise
            raise InputError("this is no certificate of the format; fairaudit verify says what is wrong with it") from None

    return checked


__all__ = ["Content", "Figure", "describe"]


SHOW_LEFT_OUT = 12  # what a reader looks through; the certificate has all

SHOW_RATES = 24  # what a reader looks through; the certificate has all

GIVEN_TRUTH = {
    "equal_opportunity": "How far apart are the true positive rates of two groups in the same context? 0 is alike.",
    "equalized_odds_true_label": "The same, or the false positive rates where those are further apart.",
    "equal_opportunity_overall": "How far apart are the true positive rates of two groups over all contexts?",
    "equalized_odds_true_label_overall": "The same, or the false positive rates where those are further apart.",
}

UNCHECKED = "The table was not at hand when this was made: its statements are repeated unchecked."

VERDICTS = {
    "within": ("Within the target", "Within the targets"),
    "exceeds": ("Exceeds the target", "Exceeds a target"),
    "inconclusive": ("Inconclusive", "Inconclusive"),
    "depends": ("It depends", "It depends"),
    "changed": ("The ratio changed", "The ratio changed"),
    "none": ("No target was set", "No target was set"),
}


@dataclass(frozen=True)
class Figure:
    """A metric: its name, the question that it answers, its value and who it is about."""

    key: str
    name: str
    question: str
    value: Value | None
    logs: str
    witness: str
    sure: tuple[Value, Value] | None = None
    confidence: str = ""
    each: bool = False  # whether the confidence is that of each end by itself
    over_units: Value | None = None  # with sampling units, what the interval is about

    @property
    def ends(self) -> str:
        """Both ends of the interval; empty without one."""
        return "" if self.sure is None else ends_text(self.sure[0].decimal, self.sure[1].decimal, each=self.each)


@dataclass(frozen=True, eq=False)
class Content:
    """Everything that a report says.

    Attributes
    ----------
    document : mapping
        The certificate.
    subject : Subject or None
        Its table, if the certificate holds it.
    """

    document: Mapping[str, Any]
    subject: Subject | None

    @property
    def verdict(self) -> str:
        """The verdict as the certificate has it."""
        verdict: str = self.document["verdict"]
        return verdict

    @property
    def title(self) -> str:
        """What was decided, compared between whom, within what."""
        columns = self.document["subject"]["columns"]
        within = f", within {', '.join(clip(name, 40) for name in columns['context'])}" if columns["context"] else ""
        return f"{clip(columns['decision'], 40)} by {', '.join(clip(name, 40) for name in columns['group'])}{within}"

    @property
    def headline(self) -> str:
        """The verdict in words."""
        return VERDICTS[self.verdict][len(self.document["targets"]) > 1]

    @property
    def meaning(self) -> str:
        """What the verdict means, where its word does not say it."""
        if self.verdict == "inconclusive":
            return "What was recorded does not settle whether the target is met."
        if self.verdict == "depends":
            return "Whether the target is met depends on what was not recorded: both answers are possible."
        if self.verdict == "changed":
            return "A window of the stream contradicts the rest, so nothing is claimed about one constant ratio."
        return "These are the figures, without a judgement." if self.verdict == "none" else ""

    @property
    def burden(self) -> bool:
        """Whether the utility counts a burden."""
        return "burden" in self.document["subject"]["utility"]

    @property
    def amount(self) -> str:
        """What the groups get: a utility or a burden."""
        return words_for(burden=self.burden).amount

    @cached_property
    def measured(self) -> dict[str, Ratio | None]:
        """The local and the global ratio of the table."""
        return {name: ratio(self.document["metrics"][name]) for name in ("local", "global")}

    @cached_property
    def differences(self) -> dict[Quantity, MeanDifference | None]:
        """The differences of the table; empty where they were not asked for."""
        metrics, names = self.document["metrics"], get_args(Quantity)
        return {name: mean_difference(metrics[f"{name}_difference"]) for name in names if f"{name}_difference" in metrics}

    @property
    def signed(self) -> bool:
        """Whether utilities can be negative: then ratios, which depend on the origin, are left out."""
        return number(self.document["subject"]["utility"]["m"]) < 0

    @property
    def apart(self) -> str:
        """What the number is that says how far apart groups are."""
        return "apart" if self.signed else "times"

    def _difference_drivers(self, quantity: Quantity) -> Drivers:
        """The pairs of groups that drive both ends of the interval of a difference; none without the table."""
        entry = self.document.get("intervals", {}).get(f"{quantity}_difference")
        if entry is None or self.expectations is None or quantity not in self.expectations.comparisons:
            return None, None
        return difference_drivers(self.expectations.comparisons[quantity], entry, Fraction(number(entry["difference"][1])))

    @cached_property
    def drivers(self) -> dict[str, Drivers]:
        """For each interval the pairs of groups that drive its lower and its upper end; none without the table."""
        found: dict[str, Drivers] = {}
        if self.subject is None or self.expectations is None:
            return found
        names: tuple[Literal["local", "global"], ...] = ("local", "global")
        for name in names:
            entry = self.document.get("intervals", {}).get(name)
            if entry is None:
                continue
            if entry["method"] == "betting":
                found[name] = stream_drivers(self.subject.law, self.subject.utility, name, entry)
            elif name in self.expectations.comparisons:
                found[name] = interval_drivers(
                    self.expectations.comparisons[name], entry, number(entry["ratio"][1]), Fraction(entry["ratio"][0])
                )
        return found

    @cached_property
    def deciding(self) -> tuple[Deciding | None, ...]:
        """For each target the pair of groups that decided it, or what else did; None where nothing could be compared."""
        return tuple(itertools.starmap(self._decide, judged_targets(self.document)))

    def _decide(self, target: Target, lower: Fraction | float | None) -> Deciding | None:
        if target.unit != "difference":
            return decide(target, self.measured[target.quantity], lower, self.drivers.get(target.quantity, (None, None)))
        ends = None if lower is None or target.upper is None else (Fraction(lower), Fraction(target.upper[0]))
        return decide_difference(target, self.differences[target.quantity], ends, self._difference_drivers(target.quantity))

    def sizes_of(self, witness: Witness) -> Sizes | None:
        """How much was recorded of the two groups of a pair; None where that is not known."""
        return None if self.subject is None else sizes(self.subject.law, [witness])[0]

    @cached_property
    def sentence(self) -> str:
        """Who is favoured over whom, where, and by what factor: of the pair of groups that decided the verdict."""
        return plain(self._said(words_for(burden=self.burden), place))

    @cached_property
    def lead(self) -> str:
        """The sentence, in the words of the decisions where the utility only says which decisions count."""
        counted = " or ".join(f"“{clip(label)}”" for label in self._counted)
        return plain(self._said(replace(words_for(burden=self.burden), counted=counted), named))

    def _said(self, words: Words, name: Callable[[Mapping[str, str]], str]) -> str:
        deciding = foremost([target["verdict"] for target in self.document["targets"]], self.deciding)
        local, overall = self.measured["local"], self.measured["global"]
        units = self.subject is not None and self.subject.law.units is not None and self.subject.law.units.repeated
        mean = "as mean over units" if units and deciding is not None and deciding.quantity == "local" else "in the table"
        contexts = bool(self.document["subject"]["columns"]["context"])
        options: dict[str, Any] = {"sizes_of": self.sizes_of, "name": name, "contexts": contexts, "mean": mean}
        if self.signed or (deciding is not None and deciding.unit == "difference"):
            said, pair = difference_sentence(deciding, self.differences, words, **options), difference_pair(deciding, self.differences)
        else:
            said, pair = sentence(deciding, local, overall, words, **options), headline_pair(deciding, local, overall)
        identifiers = "" if self.subject is None else identifier_text(self.subject.law, self.subject.law.columns)
        first = caution(pair, None if pair is None else self.sizes_of(pair), identifiers, name)
        few = few_of_policy(None if self.subject is None else self.subject.deployment, pair)
        return " ".join(text for text in (self.changed, first, few, said) if text)

    @property
    def changed(self) -> str:
        """What a window of the stream says against the whole of it; empty where none contradicts it."""
        if "changed" not in self.document:
            return ""
        found = self.document["changed"]
        low, high, first, last = (number(end) for key in ("stream", "ratio") for end in found[key]["ratio"])
        return change_text(found["quantity"], found["window"], (low, high), (first, last), Fraction(number(found["confidence"])))

    @cached_property
    def _counted(self) -> list[str]:
        """The decisions that count, when each of them is worth 1 and all others nothing."""
        if self.subject is None:
            return []
        listed = [plain(self.subject.law.decisions[i]) for i in counted_decisions(self.subject.utility)]
        return listed if len(listed) <= 3 else []

    @cached_property
    def targets(self) -> list[dict[str, str]]:
        """Each target with its verdict and what was judged."""
        listed = []
        for target, deciding in zip(self.document["targets"], self.deciding, strict=True):
            limit = Value(number(target["limit"]))
            name = limit_text(target["quantity"], target["unit"], Fraction(limit.value))
            listed.append(
                {
                    "verdict": target["verdict"],
                    "name": name,
                    "judged": scope(target["judged"]) + (f" ({target['estimand']})" if "estimand" in target else ""),
                    "exact": limit.exact,
                    "limit": limit.decimal,
                    "pair": "" if deciding is None else self._decided(deciding),
                }
            )
        return listed

    def _decided(self, deciding: Deciding) -> str:
        """The pair of groups that decided a target, or the theorem that did."""
        if deciding.pair is not None:
            return self._pair(deciding.pair)
        return "" if deciding.by in (THE_INTERVAL, THIS_TABLE) else f"every pair of groups, by {deciding.by}"

    def _pair(self, witness: Witness) -> str:
        return f"{pair_text(witness, named)} {size_text(self.sizes_of(witness))}".rstrip()

    @cached_property
    def facts(self) -> list[tuple[str, str]]:
        """What was audited."""
        about = self.document["subject"]
        columns = about["columns"]
        kinds = {
            "counts": "counts of decisions",
            "probabilities": "probabilities of decisions",
            "policy": "a policy behind privacy filters",
        }
        said = [("Audited", kinds[about["kind"]]), ("Decision", clip(columns["decision"]))]
        said.append(("Groups", ", ".join(map(clip, columns["group"])) + self._count("groups")))
        said.append(("Contexts", (", ".join(map(clip, columns["context"])) or "none") + self._count("contexts")))
        said.append(("Burden" if self.burden else "Utility", self._utility))
        for name in ("group", "context"):
            filtered = about.get("privacy", {}).get(name)
            if filtered:
                factor = Value(number(filtered["exp_epsilon"]), "up")
                said.append((f"{name.capitalize()} filter", f"ε = {factor.log} (e^ε = {factor.exact or factor.decimal})"))
        weights = {
            "counts": "as counted",
            "weights": "as stated with the table",
            "equal": "none was given: contexts weigh equally",
        }
        said.append(("Population", weights[about["population"]]))
        if "class" in about:
            said.append(("Class", f"the worst utility of a class, for the {about['class']['quantity']} ratio"))
        return said

    @cached_property
    def prepared(self) -> list[str]:
        """What was done to the log before it was counted."""
        of_log = () if self.lost is None else self.lost.read
        return [clip(plain(text), 600) for text in (*of_log, *said({"preparation": self.document["subject"].get("preparation", [])}))]

    @cached_property
    def lost(self) -> LostAnswers | None:
        """Of an evaluation log how it was read, and which answers decide nothing."""
        return lost_answers(self.document["subject"].get("evaluation"), None if self.subject is None else self.subject.law)

    @cached_property
    def spelt(self) -> list[str]:
        """Labels that are counted apart and look like one; the longest lists are cut."""
        entries = self.document["subject"].get("spellings", [])
        listed = [clip(plain(text), 600) for text in said({"spellings": entries[:SHOW_LEFT_OUT]})]
        more = len(entries) - SHOW_LEFT_OUT
        return [*listed, f"and {more:,} more, all of them in the certificate"] if more > 0 else listed

    def _count(self, what: Literal["groups", "contexts"]) -> str:
        if self.subject is None:
            return ""
        count = len(getattr(self.subject.law, what))
        return f" ({count:,})" if what == "groups" or self.document["subject"]["columns"]["context"] else ""

    @cached_property
    def _utility(self) -> str:
        constants = self.document["subject"]["utility"]
        low, high = (approximate(number(constants[name])) for name in ("m", "gamma"))
        span = f"from {low} to {high}"
        if self._counted:
            return "1 for " + " or ".join(f"“{clip(label)}”" for label in self._counted) + ", else 0"
        if self.subject is not None and self.subject.utility.by_decision and len(self.subject.law.decisions) <= 8:
            utility = self.subject.utility
            pairs = zip(self.subject.law.decisions, utility.values.tolist(), strict=True)
            return ", ".join(f"{approximate(Fraction(v, utility.scale))} for “{clip(label)}”" for label, v in pairs)
        return span + (", depends on the group" if constants["depends_on_group"] else "")

    @cached_property
    def figures(self) -> list[Figure]:
        """The measures that people ask for; without context columns there is no parity within contexts."""
        metrics, intervals = self.document["metrics"], self.document.get("intervals", {})
        listed = []
        most = "does the most favoured group get as the least"
        if self.burden:
            most = "of the burden falls on the most disadvantaged group as on the least"
        for key, name, question in (
            ()
            if self.signed
            else (
                ("local", "Within contexts", f"How many times as much {most}, in the same context?"),
                ("global", "Overall", "The same for the averages of the groups over all contexts."),
            )
        ):
            found = self.measured[key]
            sure, confidence, over_units = None, "", ratio(intervals.get(key, {}).get("measured"))
            if key in intervals:
                low, high = intervals[key]["ratio"]
                sure, confidence = (Value(number(low), "down"), Value(number(high), "up")), percent(number(intervals[key]["confidence"]))
            value = None if found is None else Value(found.ratio)
            who = "" if found is None else self._pair(found.witness)
            of_units = None if over_units is None else Value(over_units.ratio)
            each = key in intervals and intervals[key]["ends"] == "each"
            listed.append(Figure(key, name, question, value, "" if value is None else value.log, who, sure, confidence, each, of_units))
        listed += self._difference_figures(intervals)
        for key, name, question in (
            (
                "equalized_odds",
                "Parity within contexts (the paper's equalized odds)",
                "How far apart are the decisions of two groups in the same context? 0 is alike, 1 disjoint.",
            ),
            ("demographic_parity", "Demographic parity", "The same for the groups over all contexts."),
        ):
            if key == "equalized_odds" and not self.document["subject"]["columns"]["context"]:
                continue
            entry = metrics[key]
            who = "" if entry is None else _who(entry["witness"].get("context"), entry["witness"]["higher"], entry["witness"]["lower"])
            listed.append(Figure(key, name, question, None if entry is None else Value(number(entry["value"])), "", who))
        return listed

    def _difference_figures(self, intervals: Mapping[str, Any]) -> list[Figure]:
        """Differences of expectations, where they were asked for."""
        much = "does the most disadvantaged group bear than the least" if self.burden else "does the most favoured group get than the least"
        named_ = {
            "local": ("Difference within contexts", f"How much more {much}, in the same context?"),
            "global": ("Difference overall", "The same for the averages of the groups over all contexts."),
        }
        listed = []
        for measured, found in self.differences.items():
            (name, question), key = named_[measured], f"{measured}_difference"
            entry, sure, confidence, over_units = intervals.get(key), None, "", None
            if entry is not None:
                low, high = map(number, entry["difference"])
                sure, confidence = (Value(low, "down"), Value(high, "up")), percent(number(entry["confidence"]))
                over_units = mean_difference(entry.get("measured"))
            value = None if found is None else Value(found.value)
            who = "" if found is None else self._pair(found.witness)
            of_units = None if over_units is None else Value(over_units.value)
            each = entry is not None and entry["ends"] == "each"
            listed.append(Figure(key, name, question, value, "", who, sure, confidence, each, of_units))
        return listed

    @cached_property
    def given_truth(self) -> list[Figure]:
        """Equal opportunity and equalized odds given the true label; empty where no true labels are known."""
        metrics, intervals = self.document["metrics"], self.document.get("intervals", {})
        listed = []
        for key, question in GIVEN_TRUTH.items():
            if key not in metrics:
                continue
            entry, value, who, sure, confidence = metrics[key], None, "", None, ""
            if entry is not None:
                witness = entry["witness"]
                high, low = (approximate(number(rate)) for rate in witness["rates"])
                value = Value(number(entry["value"]))
                pair = _who(witness.get("context"), witness["higher"], witness["lower"])
                who = f"{pair}, a {NAMES[witness['rate']]} of {high} against {low}"
            if key in intervals:
                ends = (number(end) for end in intervals[key]["difference"])
                sure, confidence = (Value(next(ends), "down"), Value(next(ends), "up")), percent(number(intervals[key]["confidence"]))
            listed.append(Figure(key, f"{NAMES[key][0].upper()}{NAMES[key][1:]}", question, value, "", who, sure, confidence))
        return listed

    @cached_property
    def rates(self) -> list[tuple[str, str, str]]:
        """True and false positive rates of the groups, over all contexts; the longest lists are cut."""
        metrics, suffix = self.document["metrics"], OVERALL if self.document["subject"]["columns"]["context"] else ""
        lists = [metrics.get(kind + suffix) or [] for kind in KINDS]
        shown: dict[str, list[str]] = {}
        for i, rates in enumerate(lists):
            for entry in rates[:SHOW_RATES]:
                shown.setdefault(named(entry["group"]), ["–", "–"])[i] = approximate(number(entry["rate"]))
        return [(label, true, false) for label, (true, false) in [*shown.items()][:SHOW_RATES]]

    @cached_property
    def positive(self) -> str:
        """What counts as positive; empty where no true labels are known."""
        if "positive" not in self.document["subject"]:
            return ""
        positive, column = self.document["subject"]["positive"], self.document["subject"]["columns"]["truth"]
        decisions = " or ".join(f"“{clip(label)}”" for label in positive["decision"])
        label = f"“{clip(positive['truth'])}”"
        return f"True labels are in column {clip(column)}. Positive are the decision {decisions} and the true label {label}."

    @cached_property
    def expectations(self) -> Expectations | None:
        """What each group gets; None without a table."""
        stated = self.document.get("intervals", {})
        of_differences = {name: stated[f"{name}_difference"] for name in get_args(Quantity) if f"{name}_difference" in stated}
        ratios = {name: entry for name, entry in stated.items() if "ratio" in entry}
        return None if self.subject is None else Expectations(self.subject, {**of_differences, **ratios}, undecided_of(self.document))

    @property
    def panels(self) -> list[Panel]:
        """The most unequal contexts, with what each group gets; empty without a table."""
        return self.expectations.panels if self.expectations else []

    @property
    def overall(self) -> Panel | None:
        """Means of the groups over all contexts, where they are compared."""
        return self.expectations.overall if self.expectations else None

    @property
    def matrices(self) -> list[Matrix]:
        """Pairwise ratios within the most unequal contexts, then overall."""
        return self.expectations.matrices if self.expectations else []

    @cached_property
    def ladders(self) -> dict[str, list[Rung]]:
        """What is known of the local and of the global ratio, smallest first."""
        names: tuple[Literal["local", "global"], ...] = ("local", "global")
        return {name: rungs for name in names if (rungs := ladder(self.document, name))}

    @cached_property
    def unknown(self) -> list[UnknownRange]:
        """Between which ends the ratios lie, whoever the decisions of unknown group are."""
        groups: dict[tuple[str, ...] | None, list[tuple[str, ...]]] = {}
        if self.subject is not None:
            law = self.subject.law
            groups[None] = [law.groups[a] for a in law.global_groups]
            for x, a in zip(law.cell_context.tolist(), law.cell_group.tolist(), strict=True):
                groups.setdefault(law.contexts[x], []).append(law.groups[a])
        return unknown_ranges(self.document, groups)

    @cached_property
    def undecided(self) -> str:
        """Which decisions are undecided, how many they are, and what they count as; empty where there are none."""
        return undecided_said(self.document, self.subject)

    @cached_property
    def meant(self) -> list[MeantRange]:
        """Between which ends the ratios lie, whatever the undecided decisions meant."""
        return undecided_ranges(self.document)

    @cached_property
    def strengths(self) -> list[Strength]:
        """How strong an unrecorded factor would have to be to explain the ratios away."""
        return strengths(self.document)

    @cached_property
    def declared_factor(self) -> list[str]:
        """What a declared unrecorded factor leaves of the ratios; empty where none was declared."""
        return declared(self.document)

    @cached_property
    def drifting(self) -> list[Standing]:
        """How far verdicts stand, and between which ends the ratios are within a declared drift."""
        return standings(self.document, self.subject, self.expectations.comparisons if self.expectations else {})

    @cached_property
    def calibration(self) -> Calibrated | None:
        """How much truth a filter like this one may tell for each target; None where no filter was audited."""
        return calibration(self.document, self.subject)

    @cached_property
    def not_compared(self) -> list[str]:
        """What was left out, and why; the longest lists are cut."""
        entries = self.document["not_compared"]
        listed = [self._left_out(entry) for entry in entries[:SHOW_LEFT_OUT]]
        more = len(entries) - SHOW_LEFT_OUT
        return [*listed, f"and {more:,} more {noun(more, 'entry', 'entries')}, in the certificate"] if more > 0 else listed

    def _left_out(self, entry: Mapping[str, Any]) -> str:
        columns = self.document["subject"]["columns"]
        what = []
        if "context" in entry:
            what.append(named(dict(zip(columns["context"], entry["context"], strict=True))) or "the only context")
        if "groups" in entry:
            groups = [named(dict(zip(columns["group"], group, strict=True))) for group in entry["groups"][:5]]
            more = len(entry["groups"]) - 5
            what.append("; ".join(groups) + (f" and {more:,} more {noun(more, 'group')}" if more > 0 else ""))
        if "quantity" in entry:
            what.append(NAMES.get(entry["quantity"], f"{entry['quantity']} fairness"))
        return f"{', '.join(what)}: {plain(entry['reason'])}"

    @cached_property
    def assumptions(self) -> list[tuple[str, str]]:
        """What no checker can see, each with the claims that rest on it."""
        resting: dict[str, dict[str, None]] = {}
        for claim in self.document["claims"]:
            for text in claim["assumptions"]:
                resting.setdefault(plain(text), {})[scope(claim["scope"])] = None
        for text in self.document.get("changed", {}).get("assumptions", ()):
            resting.setdefault(plain(text), {})["the change of the ratio"] = None
        return [(clip(text, 600), _listed(list(scopes))) for text, scopes in resting.items()]

    @cached_property
    def limits(self) -> list[str]:
        """What this does not say."""
        about = self.document["subject"]
        said = []
        if self.document.get("intervals"):
            said.append("The figures describe this table; the intervals say what it tells about the decisions that were not recorded.")
        elif about["kind"] == "counts":
            said.append(
                "The figures describe this table, not the population behind it: small counts vary by chance, and no interval is claimed."
            )
        else:
            said.append("The probabilities in the table are taken as given.")
        overall = self.document["metrics"]["global"] is not None or self.differences.get("global") is not None
        if about["population"] == "equal" and overall and about["columns"]["context"]:
            said.append("No population was given: the overall figures weigh all contexts equally.")
        said.append("Nobody can see from it whether the table is genuine, complete or representative, nor why groups differ.")
        if not self.burden:
            said.append("The utility is taken for a benefit; where it counts a burden, an audit with --burden says so.")
        said.append("It is no statement about the law of any country.")
        return said

    @cached_property
    def claims(self) -> list[dict[str, Any]]:
        """Every claim, in order."""
        relations = {"=": "=", "<=": "≤", ">=": "≥"}
        return [
            {
                "quantity": quantity(claim),
                "relation": relations[claim["relation"]],
                "value": claimed(claim),
                "scope": scope(claim["scope"]),
                "by": plain(claim["by"]),
                "how": how(claim),
            }
            for claim in self.document["claims"]
        ]

    @cached_property
    def constants(self) -> list[tuple[str, Value | None]]:
        """Constants of the utility, and those that were declared."""
        about = self.document["subject"]
        what = "burden" if self.burden else "utility"
        names = {
            "gamma": f"greatest {what} γ",
            "m": f"least {what} m",
            "tau": f"least expected {what} τ",
            "lipschitz": "difference between groups L",
        }
        listed: list[tuple[str, Value | None]] = []
        for key, name in names.items():
            text = about["utility"][key]
            listed.append((name, None if text is None else Value(number(text))))
        names |= {"global_tau": f"least mean {what} of a group", "max_drift": "greatest drift of the policy, in total variation"}
        declared = dict(about.get("declared", {}))
        for entry in declared.pop("by_context", []):
            where = named(dict(zip(about["columns"]["context"], entry["context"], strict=True)))
            declared |= {f"{names[key]} in {where}": text for key, text in entry.items() if key != "context"}
        return listed + [(f"declared {names.get(key, key)}", Value(number(text))) for key, text in declared.items()]


def describe(document: Mapping[str, Any], found: Subject | None = None) -> Content:
    """Prepare what a report says of a certificate.

    Parameters
    ----------
    document : mapping
        The certificate.
    found : Subject, optional
        Its table; read from the certificate by default.

    Returns
    -------
    Content
        The content, made as it is asked for.

    Raises
    ------
    InputError
        If the document does not have the shape of a certificate.
    """
    return Content(document, subject(document) if found is None else found)


def _who(context: Mapping[str, str] | None, higher: Mapping[str, str], lower: Mapping[str, str]) -> str:
    where = f"{named(context)}: " if context else ""
    return f"{where}{named(higher)} against {named(lower)}"


def _listed(scopes: list[str]) -> str:
    more = len(scopes) - 2
    return "; ".join(scopes[:2]) + (f"; and {more} more" if more > 0 else "")
