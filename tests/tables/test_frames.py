"""Frames count their own rows: every library, eager or lazy, gives the law of the plain columns."""

from __future__ import annotations

import datetime as dt
from collections import Counter
from collections.abc import Callable, Iterator
from decimal import Decimal
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st
from logs import counts, log

from fairaudit import InputError, Law, certify
from fairaudit.tables import coded
from fairaudit.tables.engines.logs import read_log
from fairaudit.tables.frames import tally_frame
from fairaudit.tables.label_text import label_text

ROWS = [
    {
        **row,
        "score": row["age"] / 4,
        "senior": row["age"] > 40,
        "day": dt.date(2026, 1, 1 + row["age"] % 3),
        "price": Decimal(row["age"]) / 10,
    }
    for row in log()
]
PLAIN = {name: [row[name] for row in ROWS] for name in ROWS[0]}


def pandas_frame() -> Any:
    import pandas as pd

    return pd.DataFrame(PLAIN)


def pandas_objects() -> Any:
    return pandas_frame().astype(object)


def pandas_categories() -> Any:
    return pandas_frame().astype({"answer": "category", "sex": "category"})


def polars_frame() -> Any:
    import polars as pl

    return pl.DataFrame(PLAIN)


def polars_lazy() -> Any:
    import polars as pl

    return pl.LazyFrame(PLAIN).with_columns(pl.col("sex").cast(pl.Categorical))


def arrow_table() -> Any:
    import pyarrow as pa

    return pa.table(PLAIN)


def duckdb_relation() -> Any:
    import duckdb

    arrow = arrow_table()
    return duckdb.from_arrow(arrow)


FRAMES = [pandas_frame, pandas_objects, pandas_categories, polars_frame, polars_lazy, arrow_table, duckdb_relation]


@pytest.mark.parametrize("make", FRAMES, ids=lambda make: make.__name__)
@pytest.mark.parametrize(
    ("group", "context"), [("sex", "dept"), ("senior", ["day", "dept"]), ("score", None), ("price", "sex"), (["sex", "dept"], "age")]
)
def test_a_frame_is_the_log_of_its_rows(make: Callable[[], Any], group: Any, context: Any) -> None:
    one, two = (Law.from_log(table, decision="answer", group=group, context=context, unit="run") for table in (make(), PLAIN))
    assert certify(one, {"yes": 1}).certificate.text == certify(two, {"yes": 1}).certificate.text
    assert one.units == two.units


@pytest.mark.parametrize("make", FRAMES, ids=lambda make: make.__name__)
def test_a_frame_is_cut_into_intervals(make: Callable[[], Any]) -> None:
    found = read_log(make(), ["dept", "age", "score"], bins={"age": [18, 40], "score": [5.25, "10"]})
    assert found.rows == len(ROWS)
    labels = [
        (
            "under 18" if r["age"] < 18 else "18 to under 40" if r["age"] < 40 else "40 and over",
            "under 5.25" if r["score"] < 5.25 else "5.25 to under 10" if r["score"] < 10 else "10 and over",
            r["dept"],
        )
        for r in ROWS
    ]
    assert counts(found) == {(x, age, score): labels.count((age, score, x)) for age, score, x in labels}


def missing_frames() -> Iterator[Any]:
    import numpy as np
    import pandas as pd
    import polars as pl
    import pyarrow as pa

    columns: dict[str, Any] = {"u": ["y", "n", "y", "n", "y"], "a": ["f", "m", "f", None, "m"], "x": [1.5, 2.5, 1.5, 1.5, None]}
    yield columns
    yield pd.DataFrame(columns)
    yield pd.DataFrame(columns).convert_dtypes()
    yield pd.DataFrame({**columns, "a": np.array(columns["a"], dtype=object)})
    yield pl.DataFrame(columns)
    yield pl.LazyFrame(columns).with_columns(pl.col("x").fill_null(float("nan")))
    yield pa.table(columns)


@pytest.mark.parametrize("frame", list(missing_frames()), ids=range(7))
def test_missing_labels_are_missing_in_every_library(frame: Any) -> None:
    names = {"decision": "u", "group": "a", "context": "x"}
    with pytest.raises(InputError, match=r"the label is missing \(1 in all\)"):
        Law.from_log(frame, **names)
    dropped = Law.from_log(frame, **names, missing="drop")
    assert dropped.notes == ("2 of 5 decisions have a missing label and were left out ('a': 1, 'x': 1; by group: 'm' 1 of 2)",)
    assert dropped.weights.tolist() == [[0, 2], [1, 0]]
    assert Law.from_log(frame, **names, missing="group").groups == (("(missing)",), ("f",), ("m",))


def test_values_that_libraries_take_for_equal_stay_apart() -> None:
    """1, 1.0 and True are equal in Python and different labels here."""
    import pandas as pd

    columns = {"u": ["y", "n", "y"], "a": [1, True, "x"]}
    frame = pd.DataFrame(columns, dtype=object)
    assert tally_frame(frame, ["u", "a"]) is None
    assert Law.from_log(frame, decision="u", group="a").groups == (("1",), ("true",), ("x",))
    with pytest.raises(InputError, match="different values with the same text"):
        Law.from_log(pd.DataFrame({"u": ["y", "n"], "a": [1, "1"]}, dtype=object), decision="u", group="a")


def test_frames_say_what_is_wrong_with_them() -> None:
    import pandas as pd
    import polars as pl
    import pyarrow as pa

    with pytest.raises(InputError, match="there is no column 'b'; known: 'u', 'a'"):
        Law.from_log(pl.LazyFrame({"u": ["y"], "a": ["f"]}), decision="u", group="b")
    with pytest.raises(InputError, match="occurs more than once"):
        Law.from_log(pd.DataFrame([["y", "f", "m"]], columns=["u", "a", "a"]), decision="u", group="a")
    with pytest.raises(InputError, match=r"column 'a' is of type List.*; cast the column"):
        Law.from_log(pl.DataFrame({"u": ["y", "n"], "a": [[1], [2]]}), decision="u", group="a")
    with pytest.raises(InputError, match="no rows"):
        Law.from_log(pa.table({"u": pa.array([], pa.string()), "a": pa.array([], pa.string())}), decision="u", group="a")
    with pytest.raises(InputError, match=r"cannot be (counted|read)"):
        Law.from_log(pl.scan_csv("/nowhere/at/all.csv"), decision="u", group="a")
    with pytest.raises(InputError, match="cannot be read from a dict"):
        read_log({"u": ["y"]}, ["u"])
    with pytest.raises(InputError, match="goes with a database"):
        read_log(pl.DataFrame({"u": ["y"]}), ["u"], table="t")


def test_a_count_column_of_that_name_is_no_trouble() -> None:
    import polars as pl

    found = read_log(pl.DataFrame({"row_count": ["y", "y"], "a": [1, 2]}), ["row_count"])
    assert counts(found) == {("y",): 2}


def test_repeated_use_of_a_frame_does_not_change_it() -> None:
    import pandas as pd

    frame = pandas_frame()
    before = frame.copy()
    read_log(frame, ["age", "sex"], bins={"age": [18]})
    pd.testing.assert_frame_equal(frame, before)


@given(st.data())
def test_every_way_to_count_a_frame_agrees(data: st.DataObject) -> None:
    """Small integers, categories with unused levels, truth values and texts, with and without missing cells."""
    import pandas as pd
    import polars as pl

    rows = data.draw(st.integers(1, 12))

    def column(cells: st.SearchStrategy[Any]) -> list[Any]:
        return data.draw(st.lists(cells, min_size=rows, max_size=rows))

    whole = st.sampled_from((-3, -1, 0, 2, 7, 2**40, 2**62)) if data.draw(st.booleans()) else st.integers(-2, 5)
    columns = {
        "u": column(st.booleans()),
        "a": column(st.sampled_from(("f", "m", None))),
        "x": column(whole),
        "y": column(st.one_of(st.none(), st.sampled_from((0.5, 2.0)))),
    }
    pandas = pd.DataFrame(columns)
    categories = pandas.assign(a=pd.Categorical(columns["a"], categories=["unused", "m", "f"]), x=pandas.x.astype("category"))
    names = ["u", "a", "x", "y"][: data.draw(st.integers(1, 4))]
    found = [
        Counter({tuple(None if v is None else label_text(v) for v in row): n for row, n in counts(tally).items()})
        for frame in (pandas, categories, pandas.astype(object), pl.DataFrame(columns), pl.LazyFrame(columns))
        for tally in (read_log(frame, names),)
    ]
    expected = Counter(
        tuple(None if v is None else label_text(v) for v in row) for row in zip(*(columns[name] for name in names), strict=True)
    )
    assert all(one == expected for one in found)


TEXTS = st.one_of(
    st.lists(st.sampled_from("fm"), min_size=1, max_size=30),
    st.lists(st.sampled_from(["f", "m", None, "x"]), min_size=1, max_size=30),
    st.lists(st.sampled_from(["f", "", "ff", "m"]), min_size=1, max_size=30),
    st.lists(st.sampled_from(["young", "old", "\u00e4", "a\u0308", "\x00", None]), min_size=1, max_size=30),
)


@given(st.data())
def test_texts_and_numbers_that_the_first_rows_do_not_have_are_counted(data: st.DataObject) -> None:
    """Whatever the sample, the blocks and the threads; for slices and parts of frames, and for texts that are one object or many."""
    import numpy as np
    import pandas as pd

    texts = data.draw(TEXTS)
    numbers = data.draw(st.lists(st.sampled_from([0, 1, 5, 2**63 - 1]), min_size=len(texts), max_size=len(texts)))
    kind = data.draw(st.sampled_from([np.int64, np.uint64, np.int8, np.bool_]))
    whole = np.array(numbers, dtype=np.uint64).astype(kind)
    first = data.draw(st.integers(0, len(texts) - 1))
    shared = pd.DataFrame({"a": np.array(texts, dtype=object), "n": whole}).astype({"a": object})
    parted = pd.DataFrame({"a": pd.array(texts, dtype=pd.StringDtype("pyarrow")), "n": whole})
    many = shared.assign(a=pd.Series([None if text is None else "".join([*text, " "])[:-1] for text in texts], dtype=object))
    python = shared.astype({"a": pd.StringDtype("python")})
    frames = [
        shared,
        many,
        python,
        parted,
        pd.concat([parted.iloc[: first + 1], parted.iloc[first + 1 :]]),
        parted.astype({"a": "category"}),
    ]
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(coded, "SAMPLE", data.draw(st.sampled_from([1, 2, 100])))
        patch.setattr(coded, "FEW", data.draw(st.sampled_from([1, 2, 100])))
        patch.setattr(coded, "BLOCK_ROWS", data.draw(st.sampled_from([1, 2, 5, 100])))
        patch.setattr(coded, "PART_ROWS", data.draw(st.sampled_from([1, 3, 100])))
        for frame in frames:
            expected = Counter(zip(texts[first:], whole[first:].tolist(), strict=True))
            assert counts(read_log(frame.iloc[first:], ["a", "n"])) == expected
            assert counts(read_log(frame.iloc[first:], ["n"])) == Counter((n,) for n in whole[first:].tolist())


def test_texts_of_other_lengths_are_not_taken_for_letters(monkeypatch: pytest.MonkeyPatch) -> None:
    """As many bytes as rows do not make every text a letter."""
    import pandas as pd

    monkeypatch.setattr(coded, "SAMPLE", 1)
    frame = pd.DataFrame({"a": pd.array(["f", "", "ff", "f"], dtype=pd.StringDtype("pyarrow"))})
    assert counts(read_log(frame, ["a"])) == Counter({("f",): 2, ("",): 1, ("ff",): 1})
