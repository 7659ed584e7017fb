"""Intervals for the ratios of a population from which a table was drawn, and the pairs that drive their ends."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from fractions import Fraction
from math import inf
from typing import Any, get_args

from fairaudit.errors import InputError, nearest, shown
from fairaudit.exact.extended import Extended, extended_text
from fairaudit.exact.rationals import rational
from fairaudit.inference.box import box_interval
from fairaudit.inference.cells import cell_entries
from fairaudit.inference.comparisons import Comparison, witness_of
from fairaudit.inference.ends import Method
from fairaudit.inference.interval import Interval, Region, Selection
from fairaudit.inference.levels import Holding, confidence_level
from fairaudit.inference.paired_region import fits_units, paired_assumptions, paired_drivers, paired_interval, read_profiles
from fairaudit.inference.plain_ends import ends_of_evidence, greatest_of, vanishing_of
from fairaudit.inference.quotients import sample_ratio
from fairaudit.measures.ratios import Witness
from fairaudit.theorems.assumptions import CELLS, SPLIT

BY_REGION = {"pairs": "pair-exact", "contrasts": "symmetric-betting", "paired": "paired-betting"}
"""How claims name the method of a region that has one of its own, whatever the cells are."""

TIGHT_CELLS = 500  # so many have their ladders in a few seconds

LISTED = 10_000  # cells that evidence lists; of more, only the comparison itself has them

NO_SPLIT = (
    "the half-split needs cells that were declared independent, draws that are 0 or one positive number, at most 1,000,000 of them in all, "
    "and not too many pairs, or draws of a cell, for the exact pair bound; without it all pairs share the error"
)


def ratio_interval(
    comparison: Comparison,
    confidence: Any = "0.95",
    *,
    method: Method = "hoeffding-kl",
    region: Region = "box",
    independent: bool = False,
    ends: Holding = "together",
    select: Selection = "bonferroni",
) -> Interval:
    """Bound the greatest quotient of two compared forms at a confidence, for finite samples.

    Parameters
    ----------
    comparison : Comparison
        What is compared.
    confidence : number or str
        The probability with which the ends are to hold.
    method : {"hoeffding-kl", "empirical-bernstein", "intersection"}
        For cells whose draws are not binary; to be chosen before looking.
    region : {"box", "product", "pairs", "contrasts", "paired"}
        "product" is narrower where the two cells of a pair are about equally uncertain (by about a fifth on the logarithmic scale); it
        needs independent cells, forms of one cell each, and not the empirical Bernstein method. "pairs" and "contrasts" bound each pair
        of independent cells by itself, by the exact test of two-valued draws or by bets on the contrast of draws of several values.
        "paired" compares groups within the units that were seen in both.
    independent : bool
        Whether the draws of different cells are independent, which the reader must then accept.
    ends : {"together", "each", "lower", "upper"}
        What the confidence is of: both ends at once; each end by itself, as a verdict on a limit needs it, which rests on one of them; or
        one end alone, the other being trivial.
    select : {"bonferroni", "half-split"}
        How the lower end of the region "pairs" finds its pair: all pairs share the error; or one half of the draws chooses a pair, which
        the other half tests at the full error.

    Returns
    -------
    Interval
        Both ends with evidence.

    Raises
    ------
    InputError
        If the confidence is not in (0, 1), the method or the selection is not known, nothing is compared, or the region does not fit.

    Examples
    --------
    >>> from fairaudit.inference.table_comparisons import local_comparison
    >>> from fairaudit.model.law import Law
    >>> from fairaudit.model.utility import Utility
    >>> law = Law.from_array([[90, 10], [30, 70]], kind="counts", decisions=["yes", "no"], groups=["f", "m"])
    >>> found = ratio_interval(local_comparison(law, Utility({"yes": 1}).on(law)), "0.95")
    >>> round(float(found.lower), 2), found.estimate, round(float(found.upper), 2)
    (1.96, Fraction(3, 1), 4.74)
    >>> found = ratio_interval(local_comparison(law, Utility({"yes": 1}).on(law)), "0.95", ends="each")
    >>> round(float(found.lower), 2), round(float(found.upper), 2)
    (1.96, 4.48)
    """
    level = confidence_level(confidence)
    if method not in get_args(Method):
        raise InputError(f"the method {shown(method)} is not known; {nearest(str(method), get_args(Method))}")
    if select not in get_args(Selection):
        raise InputError(f"the selection {shown(select)} is not known; {nearest(str(select), get_args(Selection))}")
    if not any(len(block) > 1 for block in comparison.blocks):
        raise InputError("nothing is compared: no context has two groups")
    if any(cell.low.numerator < 0 for cell in comparison.cells):
        raise InputError("ratios depend on the origin of the utility, which may be negative here; bound differences instead")
    if independent and comparison.dependent:
        raise InputError("cells share draws or sampling units, so they are not independent")
    if comparison.meanings and region != "box":
        raise InputError(f"the region {shown(region)} compares draws of known meaning; with undecided decisions use the box")
    alpha = 1 - level
    _refuse_unfit(comparison, region, method, alpha, select, independent=independent)
    used = comparison.used
    region = region if used else "box"
    if region == "pairs":
        from fairaudit.inference.pair_region import pairs_interval

        lower, upper, evidence = pairs_interval(comparison, alpha, ends, select)
    elif region == "contrasts":
        from fairaudit.inference.contrast_region import contrasts_interval

        lower, upper, evidence = contrasts_interval(comparison, alpha, ends)
    elif region == "paired":
        lower, upper, evidence = paired_interval(comparison, alpha, ends)
    elif region == "product":
        from fairaudit.inference.product_region import product_interval

        lower, upper, evidence = product_interval(comparison, alpha, ends)
    else:
        lower, upper, evidence = box_interval(comparison, alpha, method, independent, ends)
    drawn = [cells[i] for cells in comparison.valued for i in used]
    kinds = {BY_REGION[region]} if region in BY_REGION else {"binomial" if cell.binary else method for cell in drawn}
    split = (SPLIT,) if select == "half-split" else ()
    assumptions = (*comparison.assumptions, *((CELLS,) if independent else ()), *split)
    if region == "paired":
        assumptions = paired_assumptions(comparison)
    evidence = {
        "confidence": extended_text(level),
        "ends": ends,
        "region": region,
        "independent": independent,
        "method": method,
        **evidence,
    }
    if len(comparison.cells) <= LISTED:
        evidence["cells"] = cell_entries(comparison.cells)
        evidence["blocks"] = [[[[i, extended_text(w)] for i, w in form] for form in block] for block in comparison.blocks]
    made = Interval(lower, upper, sample_ratio(comparison), level, region, tuple(sorted(kinds)), assumptions, evidence)
    return replace(made, estimand=comparison.estimand, of_units=comparison.of_units, ends=ends)


def _refuse_unfit(comparison: Comparison, region: Region, method: Method, alpha: Fraction, select: Selection, *, independent: bool) -> None:
    """Refuse a region, or a way to choose a pair, that does not fit what is compared."""
    if select == "half-split":
        from fairaudit.inference.pair_region import fits_pairs

        if not (region == "pairs" and comparison.labels and fits_pairs(comparison, alpha, select)):
            raise InputError(NO_SPLIT)
    if region == "product" and not (independent and comparison.single and method == "hoeffding-kl"):
        raise InputError(
            "the product region needs independent cells, expected utilities that are the mean of one cell each, and binary utilities or "
            "the method hoeffding-kl; use the box"
        )
    if region == "pairs":
        from fairaudit.inference.pair_region import fits_pairs

        if not (independent and fits_pairs(comparison, alpha)):
            raise InputError(
                "the exact pair bound needs independent cells of draws that are 0 or one positive number, not too many pairs, and a "
                "confidence between 10 and 100 %; use the box"
            )
    if region == "contrasts":
        from fairaudit.inference.contrast_region import fits_contrasts

        if not (independent and fits_contrasts(comparison)):
            raise InputError(
                "contrasts of draws need independent cells, each with draws and an expected utility of its own, some of them of more than "
                "two values, and not too many pairs or values; use the box"
            )
    if region == "paired" and not fits_units(comparison):
        raise InputError("contrasts within units need units of which enough were seen in both groups of every pair; use the box")


def drivers(
    comparison: Comparison, evidence: Mapping[str, Any], end: Extended | None = None, least: Fraction = Fraction(1)
) -> tuple[Witness | None, Witness | None]:
    """Name the pairs that drive the lower and the upper end of an interval, with the means of their draws.

    Parameters
    ----------
    comparison : Comparison
        What was compared, with labels.
    evidence : mapping
        The evidence of the interval, as it has it or as a certificate stores it.
    end : Fraction or float, optional
        The upper end, by which the driver of the regions of pairs is found.
    least : Fraction
        The lower end, by which that of contrasts within units is found.

    Returns
    -------
    pair of Witness or None
        The pair that proves the lower end, and the one that attains the upper end: the greatest quotient over the box, or, for the product
        region, the greatest upper end of a pair by itself. Of pairs without an upper end it is the one that is most unequal in the draws,
        other ties go to input order; None for an end of 1 and for one that was not asked for.

    Examples
    --------
    >>> from fairaudit.inference.table_comparisons import local_comparison
    >>> from fairaudit.model.law import Law
    >>> from fairaudit.model.utility import Utility
    >>> law = Law.from_array([[90, 10], [30, 70]], kind="counts", decisions=["yes", "no"], groups=["f", "m"])
    >>> compared = local_comparison(law, Utility({"yes": 1}).on(law))
    >>> [found.higher for found in drivers(compared, ratio_interval(compared).evidence)]
    [{'group': 'f'}, {'group': 'f'}]
    """
    from fairaudit.inference.contrast_region import contrasts_driver
    from fairaudit.inference.pair_region import pairs_driver
    from fairaudit.inference.product_region import product_driver

    upper: tuple[int, int, int] | None = None
    if evidence["region"] == "contrasts":
        lower = evidence["pair"]
        alpha = 1 - Fraction(*rational(evidence["confidence"]))
        upper = contrasts_driver(comparison, alpha, evidence["ends"], inf if end is None else end)
    elif evidence["region"] == "pairs":
        lower = None if evidence["lower"] is None else evidence["lower"]["pair"]
        alpha = 1 - Fraction(*rational(evidence["confidence"]))
        upper = pairs_driver(comparison, alpha, evidence["ends"], inf if end is None else end)
    elif evidence["region"] == "paired":
        seen = replace(comparison, profiles=read_profiles(evidence["profiles"]), missing=evidence["missing"])
        lower, upper = paired_drivers(seen, least, inf if end is None else end)
    elif evidence["region"] == "box":
        lower = evidence["pair"]
        if evidence["upper"] is not None:
            boxed = ends_of_evidence(comparison, evidence, "upper")
            greatest, upper = greatest_of(comparison, boxed)
            upper = vanishing_of(comparison, boxed) if greatest == inf else upper if greatest > 1 else None
    else:
        lower = None if evidence["lower"] is None else evidence["lower"]["pair"]
        levels = evidence["levels"]["upper"]
        if levels is not None:
            upper = product_driver(comparison, Fraction(*rational(levels[0])), Fraction(*rational(levels[1])))
    return witness_of(comparison, lower), witness_of(comparison, upper)


def default_region(comparison: Comparison, method: Method | None = None, *, independent: bool, alpha: Fraction = Fraction(1, 20)) -> Region:
    """Choose a region by what is known before the draws.

    Of independent cells with draws of two values every pair by itself, by the exact pair bound; with draws of more values, unless a method
    was asked for, by bets on their contrast. Unless a method was asked for, of units that were seen in several groups the
    contrast within the unit, by bets. Else the product for three or more
    independent cells of similar size. With two cells the product is usually a fifth narrower than the box, but some per cent wider where
    one of the two is much the more uncertain, which is not known beforehand; there the box is taken, whose levels are then those of
    Bonferroni or better. Where decisions may have meant anything it is the box, whose ends hold whatever they did.
    """
    if comparison.meanings:
        return "box"
    if independent:
        from fairaudit.inference.contrast_region import fits_contrasts
        from fairaudit.inference.pair_region import fits_pairs

        if fits_pairs(comparison, alpha):
            return "pairs"
        if method is None and fits_contrasts(comparison):
            return "contrasts"
    if method is None and fits_units(comparison):
        return "paired"
    sizes = [comparison.cells[i].draws for i in comparison.used]
    fits = independent and not comparison.dependent and comparison.single and method in (None, "hoeffding-kl")
    return "product" if fits and 2 < len(sizes) <= TIGHT_CELLS and max(sizes) <= 100 * min(sizes) else "box"
