"""Tables that other libraries hand over: streams, datasets and records give the certificate of the rows."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest
from logs import log

import fairaudit as fa
from fairaudit import InputError
from fairaudit.tables.arriving import as_table

pa = pytest.importorskip("pyarrow")

ASKED: dict[str, Any] = {"decision": "answer", "group": "sex", "context": "dept", "utility": "yes"}


class Exported:
    """What only exports a stream of Arrow, as tables of Delta, Iceberg and many other libraries do."""

    def __init__(self, table: Any) -> None:
        self.table = table

    def __arrow_c_stream__(self, requested_schema: Any = None) -> Any:
        return self.table.__arrow_c_stream__(requested_schema)


def _forms(folder: Path) -> dict[str, Any]:
    import pyarrow.dataset as ds

    table = pa.Table.from_pylist(log())
    ds.write_dataset(table, folder / "parts", format="parquet", max_rows_per_group=90, max_rows_per_file=90)
    dataset = ds.dataset(folder / "parts", format="parquet")
    return {
        "stream": Exported(table),
        "reader": pa.RecordBatchReader.from_batches(table.schema, table.to_batches(max_chunksize=50)),
        "dataset": dataset,
        "scanner": dataset.scanner(),
        "batch": table.to_batches()[0],
        "records": log(),
        "tuple of records": tuple(log()),
    }


FORMS = ("stream", "reader", "dataset", "scanner", "batch", "records", "tuple of records")


@pytest.mark.parametrize("form", FORMS)
def test_every_form_gives_the_certificate_of_the_rows(tmp_path: Path, form: str) -> None:
    rows = log()
    plain = fa.audit({name: [row[name] for row in rows] for name in rows[0]}, **ASKED)
    found = fa.audit(_forms(tmp_path)[form], **ASKED)
    assert found.certificate.document == plain.certificate.document


@pytest.mark.parametrize("form", FORMS)
def test_counts_arrive_alike(tmp_path: Path, form: str) -> None:
    found = fa.audit(_forms(tmp_path)[form], **ASKED, count="run", confidence=None)
    counted = fa.audit(pa.Table.from_pylist(log()), **ASKED, count="run", confidence=None)
    assert found.local == counted.local


@pytest.mark.parametrize("form", FORMS)
def test_a_column_that_is_not_there_is_named(tmp_path: Path, form: str) -> None:
    with pytest.raises(InputError, match=r"no column 'sexx'.*did you mean 'sex'"):
        fa.audit(_forms(tmp_path)[form], **{**ASKED, "group": "sexx"})


def test_records_without_a_key_have_no_label_there() -> None:
    records = [{"answer": "yes", "sex": "f"}, {"answer": "no"}]
    assert as_table(records, ["answer", "sex"]) == {"answer": ["yes", "no"], "sex": ["f", None]}
    with pytest.raises(InputError, match="the label is missing"):
        fa.audit(records, decision="answer", group="sex", utility="yes")
    assert as_table(records[:1], ["answer"]) == {"answer": ["yes"], "sex": ["f"]}


def test_what_is_no_table_is_refused() -> None:
    for odd in (5, object(), [1, 2], {1, 2}):
        with pytest.raises(InputError, match=r"use a file, a database, a frame|cannot be read"):
            fa.audit(odd, **ASKED)  # type: ignore[arg-type]
