"""What labels of a certificate mean to the rule."""

from __future__ import annotations

from pathlib import Path

import pytest

from fairaudit.errors import InputError
from fairaudit.publications.ll144.categories import RACES, SEXES, Attribute, attributes

COLUMNS = {"gender": SEXES, "race": RACES}


def written(folder: Path, text: str) -> Path:
    file = folder / "map.toml"
    file.write_text(text, "utf-8")
    return file


def test_there_are_two_sexes_and_seven_races_or_ethnicities() -> None:
    assert (len(SEXES), len(RACES), len(set(RACES))) == (2, 7, 7)


def test_labels_mean_what_the_map_says_and_otherwise_themselves(tmp_path: Path) -> None:
    file = written(tmp_path, '[gender]\n"w" = "Female"\n"m" = "Male"\n[race]\n"BLK" = "Black or African American"\n"unused" = "White"\n')
    gender, race = attributes(COLUMNS, file, {"gender": {"", "x"}, "race": {""}})
    assert [gender.category(label) for label in ("w", "m", "Male", "x", "")] == ["Female", "Male", "Male", None, None]
    assert [race.category(label) for label in ("BLK", "White", "")] == ["Black or African American", "White", None]
    assert race.renamed(["BLK", "White", ""]) == {"Black or African American": ["BLK"]}


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ('[gender]\n"w" = "Woman"\n', "no category of the rule"),
        ('[gender]\n"w" = "female"\n', "did you mean 'Female'"),
        ('[sex]\n"w" = "Female"\n', "no column of sex or race"),
        ('[race]\n"x" = "White"\n', "says that the category is unknown"),
        ('gender = "w"\n', "no table"),
        ("[gender\n", "not a TOML file"),
        ('[gender]\n"w" = 1\n', "a text"),
    ],
)
def test_a_map_that_cannot_be_is_refused(tmp_path: Path, text: str, said: str) -> None:
    with pytest.raises(InputError, match=said):
        attributes(COLUMNS, written(tmp_path, text), {"race": {"x"}})


def test_a_map_that_is_not_there_is_refused(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="no such file"):
        attributes(COLUMNS, tmp_path / "no.toml", {})


@pytest.mark.parametrize("label", ["white", "White ", "wh\u202eite", "=1+1", "\x1b[31m", "Hispanic", "nonbinary"])
def test_a_label_that_means_nothing_is_an_error_with_a_way_out(label: str) -> None:
    with pytest.raises(InputError, match=r"no category of the rule.*--categories.*--unknown") as caught:
        Attribute("race", RACES).category(label)
    assert str(caught.value).isprintable()
