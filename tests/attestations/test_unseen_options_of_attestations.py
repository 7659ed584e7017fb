"""What options say that no table shows: the positive label and the sampling units are those of the certificate, or a recount differs."""

from __future__ import annotations

import random
from pathlib import Path
from typing import Any

import pytest

import fairaudit as fa
from fairaudit.attestations.making import stated_of, statement_of
from fairaudit.attestations.options import options_of
from fairaudit.attestations.sources import take
from fairaudit.audits.reading import Reading
from fairaudit.model.utility import Utility

ROLES: dict[str, Any] = {"decision": "hired", "group": "sex", "utility": "yes"}


def log_of(units: str) -> dict[str, list[str]]:
    """People of whom each has one row, one row for each sex, or six rows."""
    source = random.Random(3)
    places = range(240)
    held = {"single": lambda place: place, "pairs": lambda place: place // 2, "several": lambda place: place // 12 * 2 + place % 2}[units]
    return {
        "hired": [source.choice(["yes", "no"]) for _ in places],
        "sex": ["fm"[place % 2] for place in places],
        "fit": [source.choice(["yes", "no"]) for _ in places],
        "who": [f"p{held(place)}" for place in places],
    }


def recounted(log: dict[str, list[str]], made_with: dict[str, Any], said: dict[str, Any], tmp_path: Path) -> dict[str, bool | None]:
    """Whether each thing is equal in the recount of a certificate, of which an attestation says that it was made another way."""
    result = fa.audit(log, **ROLES, **made_with)
    positive = said.pop("positive", None)
    lists = {name: (value,) if name == "unit" else value for name, value in said.items()}
    options = options_of(Reading("hired", ("sex",), **lists), Utility({"yes": 1}), positive=positive)
    made = statement_of(result, ["c.json"], take(log), options=options, command=["certify"], stated=stated_of({}))
    return {finding.what: finding.equal for finding in fa.recount(result, made.text.encode(), log).findings}


@pytest.mark.parametrize(
    ("made_with", "said", "equal"),
    [
        ({}, {"unit": "who"}, {"single": None, "pairs": None, "several": False}),
        ({"unit": "who"}, {"unit": "who"}, {"single": None, "pairs": None, "several": True}),
        ({"unit": "who"}, {}, {"single": None, "pairs": None, "several": False}),
        ({"confidence": None}, {"unit": "who"}, {"single": None, "pairs": None, "several": None}),
        ({"independent": True}, {"unit": "who"}, {"single": None, "pairs": False, "several": False}),
        ({"max_difference": "1/2"}, {"unit": "who"}, {"single": None, "pairs": None, "several": False}),
        ({"max_difference": "1/2", "unit": "who"}, {"unit": "who"}, {"single": None, "pairs": None, "several": True}),
    ],
)
@pytest.mark.parametrize("units", ["single", "pairs", "several"])
def test_intervals_of_rows_are_none_of_units(
    tmp_path: Path, units: str, made_with: dict[str, Any], said: dict[str, Any], equal: dict[str, bool | None]
) -> None:
    found = recounted(log_of(units), made_with, dict(said), tmp_path)
    assert found.get("the sampling units") is equal[units]
    if units == "pairs" and "unit" in made_with:
        assert found["the table"] is ("unit" in said)  # which holds the digest of what the pairs got


@pytest.mark.parametrize(
    ("made_with", "said", "equal"),
    [
        ({"truth": "fit"}, {"truth": "fit"}, True),
        ({"truth": "fit", "positive": "yes"}, {"truth": "fit", "positive": "yes"}, True),
        ({"truth": "fit"}, {"truth": "fit", "positive": "yes"}, True),
        ({"truth": "fit", "positive": "no"}, {"truth": "fit", "positive": "yes"}, False),
        ({"truth": "fit", "positive": "no"}, {"truth": "fit"}, False),
        ({"truth": "fit"}, {"truth": "fit", "positive": "maybe"}, False),
        ({}, {"positive": "yes"}, False),
        ({}, {}, None),
    ],
)
def test_what_is_positive_is_what_the_certificate_has(
    tmp_path: Path, made_with: dict[str, Any], said: dict[str, Any], equal: bool | None
) -> None:
    found = recounted(log_of("single"), made_with | {"confidence": None}, dict(said), tmp_path)
    assert found["the table"] is True
    assert found.get("what is positive") is equal
