"""The checker's constants beside the writer's: what one writes, the other has to take."""

from __future__ import annotations

import pytest

from fairaudit import checker
from fairaudit.certificates import certificate, reader, table
from fairaudit.cli import options
from fairaudit.exact import enclosures, rationals
from fairaudit.inference import betting, tails
from fairaudit.measures import rates
from fairaudit.streams import letters
from fairaudit.tables import labels, preparation
from fairaudit.theorems import assumptions, bound, case, registry

EQUAL = {
    "the format of certificates": (checker.certificate.CERTIFICATE_FORMAT, certificate.FORMAT),
    "the format of certificates that are read again": (checker.certificate.CERTIFICATE_FORMAT, reader.FORMAT),
    "the format of tables": (checker.header.TABLE_FORMAT, table.TABLE_FORMAT),
    "decimals of logarithms": (checker.logarithms.LOG_SCALE, 10**enclosures.LOG_DIGITS),
    "bytes of a certificate that is read again": (checker.command.MAX_BYTES, reader.MAX_BYTES),
    "characters of labels that are compared with other spellings": (checker.preparation.LONGEST_SPELLING, labels.LONGEST_SPELLING),
    "steps before counting": (checker.preparation.STEPS, preparation.STEPS),
    "reasons why lines are left out": (
        checker.preparation.REASONS,
        (letters.UNREADABLE, letters.MISSING, letters.UNUSABLE, letters.UNKNOWN),
    ),
    "methods of intervals": (checker.claims.METHODS, options.METHODS),
    "joint likelihood ratios of a group filter": (checker.filters.PAIR_ENTRIES, case.PAIR_RATIOS),
    "bets": (checker.betting.BETS, betting.BETS),
    "what is never bet": (checker.betting.IDLE, betting.IDLE),
    "what is bet at most": (checker.betting.CAP, betting.CAP),
    "shares of the bets": (tuple(map(checker.betting._share, checker.betting.BETS)), betting.SHARES),
    "kinds of rates": (checker.rates.KINDS, rates.KINDS),
    "what is pooled over contexts": (checker.rates.OVERALL, rates.OVERALL),
    "rates and their differences": (
        {*checker.rates.DIFFERENCES, *checker.rates.KINDS, *(kind + checker.rates.OVERALL for kind in checker.rates.KINDS)},
        {*rates.NAMES},
    ),
    "why a rate does not exist": (checker.rates.LACKING, rates.NO_DRAWS),
    "scope: this law": (checker.claims.LAW, bound.THIS_LAW),
    "scope: other policies": (checker.claims.POLICIES, bound.ANY_POLICY),
    "scope: policies with a floor": (checker.claims.FLOORED, bound.FLOORED),
    "scope: other group filters": (checker.claims.GROUP_FILTERS, bound.THIS_POLICY),
    "scope: other context filters": (checker.claims.CONTEXT_FILTERS, bound.ANY_CONTEXT_FILTER),
    "scope: all utilities of a class": (checker.claims.UTILITIES, registry.EVERY_UTILITY),
    "scope: the population": (checker.claims.POPULATION, registry.SAMPLED),
    "scope: the population, one-sided": (checker.claims.ONE_SIDED, registry.ONE_SIDED),
    "differences of rates": ({*checker.rates.DIFFERENCES}, {*registry.DIFFERENCES}),
    "sentence: fresh draws of the filter": (checker.sentences.FRESH, assumptions.FRESH),
    "sentence: the stated population": (checker.sentences.STATED_POPULATION, assumptions.POPULATION),
    "sentence: independent draws": (checker.sentences.DRAWS, assumptions.DRAWS),
    "sentence: independent units": (checker.sentences.UNITS, assumptions.UNITS),
    "sentence: one row of a unit in a cell": (checker.sentences.ONE_ROW, assumptions.ONE_ROW),
    "sentence: pooled contexts": (checker.sentences.POOLED, assumptions.POOLED),
    "sentence: decisions given the true labels": (checker.sentences.GIVEN_LABELS, assumptions.GIVEN_TRUTH),
    "sentence: positive labels chosen beforehand": (checker.sentences.CHOSEN_LABELS, assumptions.DECLARED_POSITIVE),
    "sentence: utility chosen beforehand": (checker.sentences.CHOSEN, assumptions.DECLARED),
    "sentence: the range of each cell": (checker.sentences.OWN_RANGE, assumptions.OWN_RANGE),
    "sentence: the range of all": (checker.sentences.RANGE.format("{low}", "{high}"), assumptions.RANGE),
    "sentence: a declared floor": (checker.sentences.DECLARED_FLOOR.format("{tau}"), assumptions.DECLARED_FLOOR),
    "sentence: independent cells": (checker.sentences.CELLS, assumptions.CELLS),
    "sentence: a stream given its past": (checker.sentences.PAST, assumptions.PAST),
    "sentence: a stream given the past of the cell": (checker.sentences.OWN_PAST, assumptions.OWN_PAST),
    "sentence: the mix of contexts": (checker.sentences.MIX, assumptions.MIX),
    "sentence: the order of cells": (checker.sentences.ORDER, assumptions.ORDER),
    "sentence: windows": (checker.sentences.WINDOWS, assumptions.WINDOWS),
}
NO_MORE = {  # than the checker takes, may the writer write
    "digits of a number that is read": (rationals.MAX_DIGITS, checker.rationals.MAX_DIGITS),
    "digits of an exact result": (rationals.MAX_OUTPUT_DIGITS, checker.rationals.MAX_DIGITS),
    # Longer sums are not formed by either; where the writer sums and the checker has a weaker bound, its end would not stand.
    "draws up to which binomial tails are exact sums": (tails.EXACT_DRAWS, checker.tails.SUMMED),
}


@pytest.mark.parametrize("name", EQUAL)
def test_equal(name: str) -> None:
    ours, theirs = EQUAL[name]
    assert ours == theirs


@pytest.mark.parametrize("name", NO_MORE)
def test_the_writer_writes_no_more_than_the_checker_takes(name: str) -> None:
    written, taken = NO_MORE[name]
    assert written <= taken
