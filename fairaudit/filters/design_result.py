"""A filter for a target with its exact figures, or why there is none."""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction

from fairaudit.errors import Infeasible, InputError
from fairaudit.exact.extended import Extended, extended_pair
from fairaudit.measures.limits import Quantity
from fairaudit.model.mechanism import Mechanism
from fairaudit.privacy.currencies import Enclosure
from fairaudit.privacy.epsilon_delta import epsilon_enclosure
from fairaudit.words import brief


@brief
@dataclass(frozen=True, repr=False)
class Design:
    """A filter for a target, or why there is none.

    Attributes
    ----------
    target : Fraction or None
        The target as a ratio R*, rounded down where it was given as a logarithm; None for a cap on ε alone.
    max_exp_epsilon : Fraction or None
        The cap e^ε, rounded down where it was given as ε; None for no cap.
    feasible : bool
        Whether a filter was found; see `reason`.
    mechanism : Mechanism or None
        The filter, exactly stochastic.
    distortion : Fraction or None
        Its expected distortion Σ P(a)·M(ã|a)·c(a,ã), exact.
    truth_kept : Fraction or None
        Σ P(a)·M(a|a), exact.
    lower_bound : Fraction or None
        No filter that meets target and cap has less distortion: from rounded dual multipliers, exact whatever their rounding. None for a
        design without a policy, where the search covers one common k only, except for a cap alone.
    achieved : Fraction or float or None
        The exact ratio of the policy behind the filter, or the ratio that is guaranteed for every policy; at most the target.
    exp_epsilon : Fraction or float
        e^ε of the filter, exact, of the whole tuple.
    multipliers : tuple of Fraction
        Without a policy, one k for every ordered pair that proves `achieved`, as in `fairaudit.theorems`.
    method : str
        How the filter was made.
    scope : str
        What `achieved` covers: "this law", or any policy behind this filter (that keeps the floor, where one is declared).
    assumptions : tuple of str
        What the reader must judge.
    response_distortion, response_truth_kept : Fraction or None
        The same two figures for the randomized response that `calibrate` or `calibrate_policy` finds for the target, held to the cap; the
        design is never worse. None if there is none.
    reason : str
        Why there is no filter, or what else is to be said.
    quantity : {"local", "global"}
        What the target limits.

    Examples
    --------
    >>> import fairaudit as fa
    >>> policy = fa.Policy.from_array([[["0.9", "0.1"], ["0.2", "0.8"]]], decisions=["hire", "pass"], groups=["f", "m"])
    >>> found = fa.design(policy, {"hire": 1}, max_ratio=2)
    >>> found.require().achieved, found.truth_kept
    (Fraction(2, 1), Fraction(23, 28))
    """

    target: Fraction | None
    max_exp_epsilon: Fraction | None
    feasible: bool
    mechanism: Mechanism | None
    distortion: Fraction | None
    truth_kept: Fraction | None
    lower_bound: Fraction | None
    achieved: Extended | None
    exp_epsilon: Extended
    multipliers: tuple[Fraction, ...]
    method: str
    scope: str
    assumptions: tuple[str, ...]
    response_distortion: Fraction | None = None
    response_truth_kept: Fraction | None = None
    reason: str = ""
    quantity: Quantity = "local"

    def require(self) -> Design:
        """Give itself back, or refuse to go on without a filter.

        Raises
        ------
        Infeasible
            If no filter was found; the message is the reason.
        """
        if not self.feasible:
            raise Infeasible(self.reason)
        return self

    @property
    def epsilon(self) -> Enclosure:
        """Enclosure of ε of the whole filter, in nats."""
        return epsilon_enclosure(extended_pair(self.exp_epsilon))


def checked_design(found: Design) -> Design:
    """Refuse to return what is not on target."""
    over = found.target is not None and found.achieved is not None and found.achieved > found.target
    if found.mechanism is not None and (over or (found.max_exp_epsilon is not None and found.exp_epsilon > found.max_exp_epsilon)):
        raise InputError("the filter that was found exceeds the target or the cap; this is a fault of the program, please report it")
    return found
