"""P(group | cell) read from tables."""

from __future__ import annotations

from fractions import Fraction
from pathlib import Path

import pytest

from fairaudit.errors import InputError
from fairaudit.tables.group_probabilities import read_group_probabilities

GOOD = "surname,zip,race,probability\nLee,1,a,0.3\nLee,1,b,7/10\nMay,2,a,1\nMay,2,b,0\n"


def written(folder: Path, text: str) -> Path:
    path = folder / "given.csv"
    path.write_text(text, "utf-8")
    return path


def test_probabilities_are_the_rationals_that_are_written(tmp_path: Path) -> None:
    found = read_group_probabilities(written(tmp_path, GOOD), ["race"])
    assert found.keys == ("surname", "zip")
    assert found.groups == (("a",), ("b",))
    assert found.ends["Lee", "1"] == ((Fraction(3, 10), Fraction(7, 10)),) * 2
    assert found.notes == ()


def test_intervals_are_tightened_by_the_sum(tmp_path: Path) -> None:
    text = "zip,race,low,high\n1,a,0.1,0.9\n1,b,0.2,0.3\n1,c,0.1,0.2\n"
    [(low, high)] = read_group_probabilities(written(tmp_path, text), ["race"]).ends.values()
    assert low == (Fraction(1, 2), Fraction(1, 5), Fraction(1, 10))
    assert high == (Fraction(7, 10), Fraction(3, 10), Fraction(1, 5))


def test_a_residue_goes_to_the_most_probable_group_and_is_said(tmp_path: Path) -> None:
    text = "zip,race,probability\n1,a,0.6666667\n1,b,0.3333334\n2,a,0.5\n2,b,0.5\n"
    found = read_group_probabilities(written(tmp_path, text), ["race"])
    assert found.ends["1",][0] == (Fraction(6666666, 10**7), Fraction(3333334, 10**7))
    assert found.notes == (
        "the probabilities of 1 cell do not sum to 1 exactly, by less than 1e-6; the difference was added to the most probable group of it",
    )


def test_frames_and_parquet_are_read(tmp_path: Path) -> None:
    import duckdb
    import pandas as pd

    frame = pd.DataFrame({"zip": ["1", "1", "2", "2"], "race": ["a", "b", "a", "b"], "probability": [0.25, 0.75, 0.5, 0.5]})
    path = tmp_path / "given.parquet"
    duckdb.from_df(frame).write_parquet(str(path))
    half = Fraction(1, 2)
    expected = {("1",): {("a",): Fraction(1, 4), ("b",): Fraction(3, 4)}, ("2",): {("a",): half, ("b",): half}}
    for source in (frame, path, {name: frame[name].tolist() for name in frame}):
        found = read_group_probabilities(source, ["race"])  # groups are in the order in which a library gives the rows
        assert {key: dict(zip(found.groups, low, strict=True)) for key, (low, _) in found.ends.items()} == expected


@pytest.mark.parametrize(
    ("text", "says"),
    [
        (GOOD.replace("race", "group"), "there is no column 'race', which --group names"),
        (GOOD.replace("probability", "p"), "a column 'probability' is needed"),
        (GOOD.replace("probability", "low"), "'low' and 'high'; found 'low'"),
        ("race,probability\na,1\nb,0\n", "no column that says which cell"),
        (GOOD.replace("0.3", "0.4"), "line 2: surname='Lee', zip='1': the probabilities sum to 1.1"),
        (GOOD.replace("May,2,b,0\n", ""), "line 4: surname='May', zip='2' lacks the group race='b'"),
        (GOOD + "May,2,b,0\n", "line 6: surname='May', zip='2' has the group race='b' twice"),
        (GOOD.replace("7/10", "much"), "line 3: 'much'"),
        (GOOD.replace("7/10", "1.7"), "line 3: 17/10 is no probability"),
        (GOOD.replace("7/10", "-1"), "line 3: '-1' is negative"),
        (GOOD.replace("Lee,1,b", ",1,b"), "column 'surname', line 3: the label is empty"),
        ("zip,race,low,high\n1,a,0.5,0.2\n1,b,0,1\n", "line 2: low is 1/2 and high is 1/5"),
        ("zip,race,low,high\n1,a,0.1,0.2\n1,b,0,0.5\n", "line 2: zip='1': no probabilities in these intervals sum to 1"),
        ("zip,race,probability\n1,a,1\n2,a,1\n", "there is one group only"),
        ("zip,race,probability\n", "given.csv"),
    ],
)
def test_what_is_no_such_table_is_refused_in_one_sentence_with_the_line(tmp_path: Path, text: str, says: str) -> None:
    with pytest.raises(InputError) as refused:
        read_group_probabilities(written(tmp_path, text), ["race"])
    assert says in str(refused.value)
    assert "\n" not in str(refused.value)
