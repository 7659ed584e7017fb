"""What is read of a log, and of what a statement says of it; whole recounts are in test_recount.py."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

from fairaudit.attestations.options import reading_of
from fairaudit.attestations.recounted_log import audit_in, check_query, count_audit, count_log
from fairaudit.errors import InputError

LOG = {"hired": ["yes", "no", "yes", "no"], "sex": ["f", "f", "m", "m"]}
LAW = {"table": "log.csv", "decision": "hired", "group": "sex"}


def test_the_salt_of_the_certificate_is_put_into_the_table() -> None:
    counted = count_log(LOG, *reading_of({"decision": "hired", "group": ["sex"], "utility": {"yes": "1"}}), None)
    assert counted.law.totals.sum() == 4
    digests = {counted.table(header, {}).sha256 for header in ({}, {"salt": "0" * 64}, {"salt": "1" * 64})}
    assert len(digests) == 3


@pytest.mark.parametrize("database", ["sqlite:log.db", "duckdb:log.db", "postgresql://host/log", "postgres://host/log"])
def test_a_query_is_run_where_nothing_can_be_written(database: str) -> None:
    check_query("select 1", "select 1", database, str)
    for given in (None, "select 2"):
        with pytest.raises(InputError, match="select 1"):
            check_query("select 1", given, database, str)
    with pytest.raises(InputError, match="mysql is none of these"):
        check_query("select 1", "select 1", "mysql://host/log", str)


@pytest.mark.parametrize(
    ("options", "said"),
    [
        ({"audit": {"law": LAW}, "decision": "hired"}, "'decision' beside an audit file"),
        ({"audit": "law"}, "the sections of an audit file are accepted"),
        ({"audit": {"law": LAW, "targets": {}}}, "the section 'targets'"),
        ({"audit": {"law": {**LAW, "max_drift": "1"}}}, "'max_drift' in the section 'law'"),
    ],
)
def test_an_audit_says_what_makes_the_table_and_nothing_else(options: dict[str, Any], said: str) -> None:
    with pytest.raises(InputError, match=said):
        audit_in(options)
    assert audit_in({"decision": "hired"}) is None


def test_an_audit_reads_what_was_given_and_no_other_file(tmp_path: Path) -> None:
    (tmp_path / "given.csv").write_text("hired,sex\nyes,f\nno,f\nyes,m\nno,m\n")
    audit = {"law": LAW, "utility": {"values": {"yes": "1"}}}
    assert count_audit(audit, {"log.csv": str(tmp_path / "given.csv")}).law.totals.sum() == 4
    with pytest.raises(InputError, match=r"the file 'log\.csv', which is none of the logs"):
        count_audit(audit, {"other.csv": str(tmp_path / "given.csv")})
