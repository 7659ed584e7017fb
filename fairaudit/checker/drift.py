"""Claims about drift: how far cells may move while a verdict stands, and the ratios within a declared drift (T16)."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from fractions import Fraction

from .claims import DRIFTING, LAW, Claim, without_objection
from .drifts import Cellwise, Move, Watch
from .figures import Maximum
from .intervals import Box, Boxed, Proven
from .json_values import Labels, read_choice, read_label_lists, read_object
from .logarithms import log_at_most
from .moved_ends import EndMove, Found, MovedEnds, Side
from .policy_evidence import Attained, read_attained
from .rationals import INFINITY, ONE, ZERO, Rational, at_most, greatest_quotient, quotient, read_rational, reduced
from .table import Table, globally_compared
from .text import malformed, shown
from .work import spend

T16 = "T16"
FORMS = ("radius", "factor")


@dataclass(frozen=True)
class About:
    """What a claim is about: a radius or factor of a verdict on a limit, or the ratio within the declared drift."""

    quantity: str
    unit: str  # of the limit; empty of a ratio
    by_factor: bool
    scope: str


@dataclass(frozen=True)
class Drifted:
    """Evidence: limit and verdict of a radius, where the verdict flips or a ratio is attained, and groups whose means are summed."""

    limit: Rational | None
    verdict: str
    place: Attained | None
    followed: tuple[Labels, ...]


def about_drift(key: tuple[str, str, str, str]) -> About | None:
    """Read the quantity and the scope of a claim; none where there is no such claim."""
    quantity, relation, by, scope = key
    about, under = without_objection(scope)
    of_population = about.startswith("population, one-sided at confidence ")
    first, _, rest = quantity.partition("_")
    unit, _, form = rest.partition("_")
    if by != T16 or first not in ("local", "global") or not (about == LAW or of_population):
        return None
    if under == DRIFTING and rest == "ratio" and relation in ("<=", ">="):
        return About(first, "", False, about)
    known = not under and unit in ("ratio", "log") and form in FORMS
    allowed = (relation == ">=" and form == "radius") if of_population else relation in ("=", ">=")
    return About(first, unit, form == "factor", about) if known and allowed else None


def read_drifted(value: object, where: str, about: About, width: int) -> Drifted:
    """Read the evidence of a claim."""
    keys = ("pair", "followed") + (("limit", "verdict") if about.unit else ())
    members = read_object(value, where, keys)
    followed = read_label_lists(members["followed"], f"{where}.followed", width) if members["followed"] != [] else ()
    limit = read_rational(members["limit"], f"{where}.limit", nonnegative=True) if about.unit else None
    if limit is not None and about.unit == "ratio" and not at_most(ONE, limit):
        raise malformed(f"{where}.limit", "must be at least 1, being the limit of a ratio")
    verdict = read_choice(members["verdict"], f"{where}.verdict", ("within", "exceeds")) if about.unit else ""
    return Drifted(limit, verdict, read_attained(members["pair"], f"{where}.pair"), followed)


def watches_of(claims: Iterable[Claim], drift: Rational | None) -> list[Watch]:
    """What has to be followed in the table, claim by claim."""
    found: list[Watch] = []
    for claim in {claim.key: claim for claim in reversed([*claims])}.values():  # one that occurs twice is false
        about, evidence = about_drift(claim.key), claim.evidence
        if about is None or about.scope != LAW or not isinstance(evidence, Drifted):
            continue
        amount = claim.value if about.unit else drift
        if amount == INFINITY and not about.by_factor:
            amount = ONE
        least, most = (ONE, INFINITY) if about.by_factor else (ZERO, ONE)
        if amount is None or not (at_most(least, amount) and at_most(amount, most)):
            continue
        worst = evidence.verdict == "within" if about.unit else claim.key[1] == "<="
        move = Move(about.by_factor, amount)
        found.append(Watch(claim.key, about.quantity == "local", move, worst, evidence.place, frozenset(evidence.followed)))
    return found


def end_move_of(claim: Claim, about: About, evidence: Drifted, drift: Rational | None) -> EndMove | None:
    """How far ends of single cells have to be moved for a claim about a population; none where they cannot."""
    amount = (claim.value if claim.value != INFINITY else ONE) if about.unit else drift or ZERO
    if not (at_most(ZERO, amount) and at_most(amount, ONE)):
        return None
    place = evidence.place
    named = None if place is None else (place.context, place.higher, place.lower)
    return EndMove(Fraction(*amount), evidence.verdict == "within" if about.unit else claim.key[1] == "<=", named)


def end_moves_of(claims: Iterable[Claim], drift: Rational | None) -> list[EndMove]:
    """All of them that are about the local ratio."""
    found: dict[EndMove, None] = {}
    for claim in claims:
        about, evidence = about_drift(claim.key), claim.evidence
        if about is not None and about.scope != LAW and about.quantity == "local" and isinstance(evidence, Drifted):
            move = end_move_of(claim, about, evidence, drift)
            found |= {} if move is None else {move: None}
    return [*found]


def fault_of_drift(
    claim: Claim,
    table: Table,
    metrics: Mapping[str, Maximum | None],
    proven: Mapping[str, Proven],
    watches: Iterable[Watch],
    drift: Rational | None,
) -> str:
    """Judge a claim about drift."""
    about, evidence = about_drift(claim.key), claim.evidence
    if about is None or not isinstance(evidence, Drifted):
        return "unknown claim"
    if table.policy is not None:
        return "a policy behind filters has other claims about drift"
    metric = metrics.get(about.quantity)
    if metric is None:
        return "the table does not give this quantity"
    if not about.unit and drift is None:
        return "no drift is declared"
    if about.scope == LAW:
        watch = next((watch for watch in watches if watch.key == claim.key), None)
        if watch is None:
            return f"no cell can move by {shown(claim.value)}"
        if watch.open_utility:
            return "a utility is not given"
        if set(evidence.followed) - ({*table.header.groups} if not watch.local else set()):
            return "what is followed is no group of means that are compared"
        found = _local(watch) if watch.local else _overall(watch, table)
        decided = metric.value
    else:
        interval = proven.get(about.quantity)
        if interval is None or interval.scope != about.scope or interval.boxed is None:
            return "no interval proves ends of single cells for this scope"
        move = end_move_of(claim, about, evidence, drift)
        if move is None:
            return f"no cell can move by {shown(claim.value if about.unit else drift or ZERO)}"
        if evidence.followed:
            return "nothing is followed where ends are known alone"
        found = _boxed(interval.boxed, table, about.quantity, move)
        decided = interval.ratio[1 if move.upper else 0]
    if not about.unit:
        return _fault_of_ratio(claim.value, evidence.place, found)
    below = _at_most_limit(decided, evidence.limit or ONE, about.unit)
    if below != (evidence.verdict == "within"):
        return f"the verdict is not {shown(evidence.verdict)}"
    return _fault_of_radius(claim, about, evidence, found)


def _at_most_limit(ratio: Rational, limit: Rational, unit: str) -> bool:
    return log_at_most(ratio, limit) if unit == "log" else at_most(ratio, limit)


def _fault_of_ratio(value: Rational, place: Attained | None, found: Found) -> str:
    """A ratio within the declared drift has to be the one that the named pair attains, and that no other exceeds."""
    if found.greatest != value:
        return f"the ends of cells give {shown(found.greatest)}"
    if (value == ONE) is not (place is None):
        return "a ratio of 1 needs no pair that attains it, and any other one does"
    if place is None:
        return ""
    if found.pair is None:
        return "the pair is not one that is compared"
    ratio = quotient(found.pair[0].end, found.pair[1].end)
    return "" if at_most(ratio, value) and at_most(value, ratio) else "the pair does not attain it"


def _fault_of_radius(claim: Claim, about: About, evidence: Drifted, found: Found) -> str:
    """*Within* has to stand for all pairs, *exceeds* for the one that is named; and beyond an exact value no longer."""
    limit, never, exact = evidence.limit or ZERO, claim.value == INFINITY, claim.key[1] == "="
    within = evidence.verdict == "within"
    bound = ONE if about.unit == "log" and limit == ZERO else None if about.unit == "log" else limit
    if evidence.place is not None and found.pair is None:
        return "the pair is not one that is compared"
    if never is not exact and never and about.scope == LAW:
        return "what no move changes is exact"
    if within and not _at_most_limit(found.greatest, limit, about.unit):
        return f"a move can make the ratio {shown(found.greatest)}, or that is not ruled out"
    if within and (never or not exact):
        ratio = found.greatest if found.pair is None else quotient(found.pair[0].end, found.pair[1].end)
        told = found.bounded or (at_most(ratio, found.greatest) and at_most(found.greatest, ratio))
        return "" if told else "another pair is further"
    if found.pair is None:
        return "the pair is not one that is compared"
    one, other = found.pair
    if not within:
        sign = _excess(one.end, other.end, limit, about.unit)
        moving = about.by_factor and not (one.constant and other.constant)
        if never:
            return "" if sign > 0 or (sign == 0 and moving) else "some move changes what the pair says"
        early = not at_most(claim.value, one.reached) and not at_most(claim.value, other.reached)
        if sign < 0 or (sign == 0 and (early if not about.by_factor else not moving)):
            return "a smaller move changes what the pair says"
        if not exact:
            return ""
    if bound is None:
        return "the radius of such a limit is not rational"
    if within:
        level = one.end[0] * other.end[1] * bound[1] == bound[0] * other.end[0] * one.end[1]
        rises = one.last[0] * other.last[1] * bound[1] > bound[0] * other.last[0] * one.last[1]
        return "" if level and rises else "the pair stands further"
    return "" if at_most(found.greatest, bound) else "another pair stands further"


def _excess(top: Rational, bottom: Rational, limit: Rational, unit: str) -> int:
    """The sign of one expectation less the limit times another one."""
    if unit == "ratio":
        above, below = top[0] * bottom[1] * limit[1], limit[0] * bottom[0] * top[1]
        return (above > below) - (above < below)
    if not bottom[0]:
        return 1 if top[0] else 0
    if at_most(top, bottom):
        return 0 if limit == ZERO and at_most(bottom, top) else -1
    return -1 if log_at_most(quotient(top, bottom), limit) else 1


def _local(watch: Watch) -> Found:
    """What was found in the contexts."""
    place = watch.place
    if place is None or place.higher == place.lower or {place.higher, place.lower} != watch.named.keys():
        return Found(watch.value, None)
    one, other = (_side(watch, watch.named[label], up) for label, up in ((place.higher, watch.worst), (place.lower, not watch.worst)))
    return Found(watch.value, (one, other))


def _side(watch: Watch, cell: Cellwise, up: bool) -> Side:
    least, most = cell.range(watch.move.by_factor)
    return Side(cell.ends(watch.move)[up], (least, most)[up], cell.reached(up), least == most)


def _overall(watch: Watch, table: Table) -> Found:
    """What the groups overall give: summed exactly where they are followed, else bounded by their means."""
    groups = globally_compared(table)
    exact = watch.means(dict(zip(table.figures.populated(), table.figures.masses(), strict=True)))
    tops: list[Rational] = []
    bottoms: list[Rational] = []
    for a in groups:
        if a in exact:
            low, high = exact[a][:2]
            tops.append(high if watch.worst else low)
            bottoms.append(low if watch.worst else high)
        else:
            mean = table.figures.of_group(a)[1]
            top, bottom = watch.bounds(mean, mean)
            tops.append(top)
            bottoms.append(bottom)
    spend(20 * len(groups), max(max(map(max, tops)), max(map(max, bottoms))).bit_length())
    greatest = reduced(*greatest_quotient(tops, bottoms))
    names, place = table.header.groups, watch.place
    if place is None or place.context is not None or place.higher == place.lower:
        return Found(greatest, None)
    sides: list[Side] = []
    for label, up in ((place.higher, watch.worst), (place.lower, not watch.worst)):
        a = names.index(label) if label in names else -1
        if a not in exact or a not in groups:
            return Found(greatest, None)
        least, most = exact[a][2:]
        sides.append(Side(exact[a][up], (least, most)[up], watch.reached[a if up else -1 - a], least == most))
    return Found(greatest, (sides[0], sides[1]), len(exact) < len(groups))


def _boxed(boxed: Boxed | Mapping[EndMove, Found], table: Table, quantity: str, move: EndMove) -> Found:
    """What the ends of cells that an interval proves give when each may move; of cells that passed, it is known."""
    if not isinstance(boxed, Boxed):
        return boxed[move]
    box: Box = boxed.upper if move.upper else boxed.lower
    header, moved, first = table.header, MovedEnds(move), 0
    cells = [cells for cells in table.by_context() if len(cells) > 1] if quantity == "local" else []
    blocks = [(header.contexts[own[0].context], [cell.group for cell in own]) for own in cells]
    for context, groups in blocks if quantity == "local" else [(None, globally_compared(table))]:
        here = slice(first, first + len(groups))
        named = move.place is not None and context == move.place[0]
        moved.take(box[here], boxed.ranges[here], [header.groups[a] for a in groups] if named else None)
        first += len(groups)
    return moved.found()
