"""What reports say of decisions of unknown group: of every such certificate, which fits the schema."""

from __future__ import annotations

import json
import random
from fractions import Fraction

import jsonschema
import pytest
from certificates import unknown

from fairaudit.certificates.certificate import schema
from fairaudit.reports.content import describe
from fairaudit.reports.markdown import markdown
from fairaudit.reports.page import html
from fairaudit.reports.unknown_groups import unknown_ranges
from fairaudit.reports.views import Views
from fairaudit.reports.words import Value


@pytest.mark.parametrize("seed", range(6))
def test_pages_have_a_section_and_certificates_fit_the_schema(seed: int) -> None:
    document = json.loads(unknown(random.Random(seed)).text)
    jsonschema.Draft202012Validator(schema()).validate(document)
    page = html(document)
    assert "Decisions without a recorded group" in page and "Who they would have to be" in page
    assert "have no recorded group; whoever they are" in markdown(document)


def test_the_ends_are_those_of_the_claims_and_the_picture_has_the_targets() -> None:
    document = json.loads(unknown(random.Random(1)).text)
    claims = {(c["quantity"], c["relation"]): c["value"] for c in document["claims"] if c["by"] == "T15"}
    for found in unknown_ranges(document, {}):
        assert found.greatest.value == Fraction(claims[f"{found.quantity}_ratio", "<="])
        assert found.least.value == Fraction(claims[f"{found.quantity}_ratio", ">="])
        assert (
            Views(describe(document)).whoever(found)[1].count('class="limit"')
            == len(found.limits)
            == sum(t["quantity"] == found.quantity for t in document["targets"])
        )


def test_an_infinite_end_reaches_the_edge_of_the_picture() -> None:
    document = json.loads(unknown(random.Random(1)).text)
    found = unknown_ranges(document, {})[0]
    wide = type(found)(**{**vars(found), "greatest": Value(float("inf"))})
    assert 'x2="100.0%" y1="13"' in Views(describe(document)).whoever(wide)[1]
