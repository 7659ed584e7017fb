"""What a certificate says of its table is read back as it was."""

from __future__ import annotations

import json
from copy import deepcopy
from typing import Any

import jsonschema
import pytest

import fairaudit as fa
from fairaudit.certificates.certificate import schema
from fairaudit.certificates.reader import subject
from fairaudit.certificates.table import Table
from fairaudit.model.policy import Deployment


def table_of(releases: int) -> Table:
    policy = fa.Policy.from_array([["0.9", "0.1"], ["0.2", "0.8"]], decisions=["hire", "pass"], groups=["f", "m"])
    deployment = policy.behind(group=fa.RandomizedResponse(["f", "m"], keep_probability="0.75"), releases=releases)
    return Table(deployment.policy.law, fa.Utility({"hire": 1}).on(deployment.law), deployment)


def document(table: Table) -> dict[str, Any]:
    made: dict[str, Any] = json.loads(json.dumps({"subject": {"table": {"header": table.header, "rows": list(table.rows())}}}))
    return made


@pytest.mark.parametrize("releases", [1, 2, 10_000])
def test_releases_are_read_back(releases: int) -> None:
    table = table_of(releases)
    found = subject(document(table))
    assert found is not None and isinstance(found.deployment, Deployment)
    assert found.deployment.releases == releases
    assert Table(found.deployment.policy.law, found.utility, found.deployment).sha256 == table.sha256


def test_only_several_releases_are_written() -> None:
    assert "releases" not in table_of(1).header["filters"]
    assert table_of(2).header["filters"]["releases"] == 2
    assert table_of(1).sha256 != table_of(2).sha256


@pytest.mark.parametrize("releases", [0, -1, 10_001, "2", 2.5, True, None])
def test_releases_that_are_no_number_are_refused(releases: object) -> None:
    damaged = document(table_of(2))
    damaged["subject"]["table"]["header"]["filters"]["releases"] = releases
    with pytest.raises(fa.InputError, match="whole number from 1 to 10000"):
        subject(damaged)


def test_the_schema_knows_the_key() -> None:
    definitions = schema()
    filters = {"$defs": definitions["$defs"], **definitions["$defs"]["filters"]}
    good = document(table_of(2))["subject"]["table"]["header"]["filters"]
    jsonschema.validate(good, filters)
    for wrong in (1, 10_001, "2", 2.5):
        with pytest.raises(jsonschema.ValidationError):
            jsonschema.validate(deepcopy(good) | {"releases": wrong}, filters)
