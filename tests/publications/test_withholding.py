"""What `publish --small` writes is attacked as its reader would: from the CSV, by an integer solver that knows nothing else."""

from __future__ import annotations

import csv
import html
import io
import json
import random
import re
from itertools import product
from pathlib import Path
from typing import Any

import pytest
import tiers
from attacker import agreeing, inside

import fairaudit as fa
from fairaudit.cli import main
from fairaudit.errors import InputError
from fairaudit.publications.adverse_impact import adverse_impact
from fairaudit.publications.counts import Counts, Decisions
from fairaudit.publications.four_fifths import four_fifths
from fairaudit.publications.publication import Publication
from fairaudit.publications.withholding import withholding_of

TABLES = 300 if tiers.FULL else 60

BOTH = [("sex",), ("race",), ("sex", "race")]

Cells = dict[tuple[str, str], tuple[int, int]]
"""For each sex and race those selected and those not."""


def decisions_of(cells: Cells) -> Decisions:
    return Decisions(("sex", "race"), tuple(cells), ("yes", "no"), tuple(cells.values()), (0, 0))


def random_cells(rng: random.Random) -> Cells:
    sexes, races = ("f", "m", "x")[: rng.randint(2, 3)], ("a", "b", "c", "d")[: rng.randint(2, 4)]
    return {
        (sex, race): (rng.randint(0, most), rng.randint(0, most))
        for sex, race in product(sexes, races)
        for most in [rng.choice((3, 20, 60, 200))]
    }


def published(cells: Cells, least: int, tables: list[tuple[str, ...]]) -> Publication:
    decisions = decisions_of(cells)
    return four_fifths(decisions, ["yes"], tables, withholding_of(decisions.selected(["yes"]), tables, least))


def rows_of(found: Publication) -> dict[tuple[str, str], tuple[int, int] | None]:
    """What the CSV says: by sex and race, empty for all, those selected and those not; None for a group that is withheld."""
    written = [dict(zip(found.header, row, strict=True)) for row in found.rows]
    read: dict[tuple[str, str], tuple[int, int] | None] = {}
    for row in written:
        place = row["group: sex"], row["group: race"]
        if row["status"] == "withheld":
            assert not any(row[name] for name in found.header[3:] if name != "status")
            read[place] = None
        else:
            read[place] = int(row["selected"]), int(row["applicants"]) - int(row["selected"])
    return read


def can_be(
    cells: Cells, rows: dict[tuple[str, str], tuple[int, int] | None], place: tuple[str, str], kind: int, value: int
) -> Cells | None:
    """A table that agrees with every published row and has this count there; None if there is none."""
    known = [(inside(at, cells), row[kind]) for at, row in rows.items() if row]
    found = agreeing([*cells], [*known, (inside(place, cells), value)])
    return found and {name: (found[name], pair[1]) if kind == 0 else (pair[0], found[name]) for name, pair in cells.items()}


def count_at(cells: Cells, place: tuple[str, str], kind: int) -> int:
    return sum(cells[name][kind] for name in inside(place, cells))


def test_linked_tables_leave_every_small_count_open_and_say_nothing_but_what_is_shown() -> None:
    """Besides, the whole publication is the same for any other table that has the same counts where they are shown."""
    rng = random.Random(tiers.fresh(0))
    attacked = hidden = 0
    for _ in range(TABLES):
        cells, least = random_cells(rng), rng.choice((2, 5, 10))
        decisions = decisions_of(cells)
        withholding = withholding_of(decisions.selected(["yes"]), BOTH, least)
        found = four_fifths(decisions, ["yes"], BOTH, withholding)
        rows = rows_of(found)
        assert len(rows) == len(cells) + len({s for s, _ in cells}) + len({r for _, r in cells})
        hidden += sum(pair is None for pair in rows.values())
        for place, kind in product(rows, (0, 1)):
            true, pair = count_at(cells, place, kind), rows[place]
            if pair is not None:
                assert pair[kind] == true >= least
            elif true < least and attacked < 60 * TABLES // 10:
                attacked += 1
                for value in {0, least - 1}:
                    other = can_be(cells, rows, place, kind, value)
                    assert other is not None and count_at(other, place, kind) == value
                    assert four_fifths(decisions_of(other), ["yes"], BOTH, withholding) == found
    assert tiers.enough(attacked > 3 * TABLES and hidden < 10 * TABLES)


def test_margins_are_worth_more_than_cells() -> None:
    """One small cell of a table leaves all margins, and takes three cells with it."""
    cells = {
        ("f", "a"): (60, 40),
        ("f", "b"): (4, 30),
        ("f", "c"): (50, 50),
        ("m", "a"): (70, 50),
        ("m", "b"): (40, 30),
        ("m", "c"): (90, 70),
    }
    rows = rows_of(published(cells, 10, BOTH))
    assert {place for place, pair in rows.items() if pair is None} == {("f", "b"), ("m", "b"), ("f", "a"), ("m", "a")}
    assert {place for place, pair in rows_of(published(cells, 10, BOTH[2:])).items() if pair is None} == {("f", "b")}


def test_one_table_is_the_same_whatever_the_withheld_counts_are() -> None:
    rng = random.Random(tiers.fresh(1))
    for _ in range(TABLES):
        cells, least = random_cells(rng), rng.choice((2, 5, 10))
        small = [name for name, pair in cells.items() if min(pair) < least]
        altered = cells | {name: (rng.randrange(least), rng.randint(0, 99)) for name in small}
        assert published(altered, least, [("sex", "race")]) == published(cells, least, [("sex", "race")])


def test_tables_by_three_columns_are_refused() -> None:
    counts = Counts(("a", "b", "c"), (("1", "1", "1"), ("2", "2", "2")), (50, 50), (20, 20))
    with pytest.raises(InputError, match="tables by a, b, c"):
        withholding_of(counts, [("a",), ("b",), ("a", "b", "c")], 10)
    assert not withholding_of(counts, [("a", "b", "c")], 10).kept["a", "b", "c"]


def test_a_control_group_that_is_withheld_is_refused() -> None:
    decisions = decisions_of({("f", "a"): (60, 40), ("m", "a"): (4, 30)})
    withholding = withholding_of(decisions.selected(["yes"]), [("sex",)], 10)
    with pytest.raises(InputError, match="is withheld, so that nothing"):
        adverse_impact(decisions, ["yes"], ["m"], [["sex"]], withholding)
    found = adverse_impact(decisions, ["yes"], ["f"], [["sex"]], withholding)
    assert [row[1] for row in found.page.sections[0].tables[0].rows] == ["100", "withheld"]


@pytest.fixture
def private(tmp_path: Path) -> list[str]:
    """A certificate with its salted table, and the options that name them."""
    table = {
        "out": ["y", "n"] * 4,
        "sex": ["f", "f", "f", "f", "m", "m", "m", "m"],
        "n": [613, 701, 4, 31, 811, 407, 83, 97],
        "race": ["a", "a", "b", "b", "a", "a", "b", "b"],
    }
    chosen: dict[str, Any] = {"confidence": None, "embed_table": False, "utility": "y"}
    fa.audit(table, decision="out", group=["sex", "race"], count="n", **chosen).save(tmp_path / "c.json")
    return [str(tmp_path / "c.json"), "--table", str(tmp_path / "c.table.jsonl")]


def test_the_folder_holds_neither_certificate_nor_anything_that_tells_it(
    private: list[str], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    out = tmp_path / "out"
    assert main(["publish", *private, "--rule", "four-fifths", "--by", "sex,race", "--small", "10", "-o", str(out)]) == 0
    assert "note" not in capsys.readouterr().err
    assert sorted(path.name for path in out.iterdir()) == ["index.html", "summary.json", "table.csv"]
    files = {path.name: path.read_text("utf-8") for path in out.iterdir()}
    digest = json.loads(Path(private[0]).read_text())["subject"]["table"]["sha256"]
    summary = json.loads(files["summary.json"])
    assert summary["certificate"] == {"table_sha256": digest} and summary["small"] == 10
    assert "cannot recompute" in files["index.html"] and "certificate.json</a>" not in files["index.html"]
    assert "1 of 4 groups is withheld" in files["index.html"]
    rows = [row for row in csv.DictReader(io.StringIO(files["table.csv"])) if row["status"] == "withheld"]
    assert [(row["group: sex"], row["group: race"], row["applicants"]) for row in rows] == [("f", "b", "")]
    totals = {"2747", "2,747", "1511", "1,511", "35", "31"}  # everybody, everybody selected, and the group itself
    for text in files.values():
        said = text.replace(digest, "").rpartition("</style>")[2]
        assert sorted(totals & {*re.findall(r"(?<![0-9.,])[0-9][0-9,]*(?![0-9.])", said)}) == []


def test_without_the_option_everything_is_published_and_small_counts_are_remarked(
    private: list[str], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["publish", *private, "--with-table", "--rule", "four-fifths", "-o", str(tmp_path / "out")]) == 0
    assert "--small 10 withholds such groups" in capsys.readouterr().err
    assert (tmp_path / "out" / "certificate.json").exists()


def test_whatever_tells_more_is_refused(private: list[str], tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    out = ["-o", str(tmp_path / "out")]
    embedded = tmp_path / "e.json"
    fa.audit({"out": ["y", "n"], "sex": ["f", "m"]}, decision="out", group="sex", utility="y").save(embedded)
    for given, said in (
        ([*private, "--rule", "four-fifths", "--small", "1"], "withholds nothing"),
        ([str(embedded), "--rule", "four-fifths", "--small", "10"], "--no-table"),
        ([*private, "--rule", "air", "--control", "f,b", "--by", "sex,race", "--small", "10"], "is withheld"),
    ):
        assert main(["publish", *given, *out]) == 2
        assert said in capsys.readouterr().err
        assert not (tmp_path / "out").exists()


def test_scores_above_their_median_are_refused(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """Half of all are above it: an equation between what is shown and what is withheld."""
    log = tmp_path / "scores.csv"
    log.write_text("points,sex\n" + "".join(f"{i},{'fm'[i % 2]}\n" for i in range(60)))
    made = ["certify", str(log), "--score", "points", "--above-median", "--group", "sex", "--confidence", "none", "--no-table"]
    assert main([*made, "-o", str(tmp_path / "c.json")]) == 0
    given = [str(tmp_path / "c.json"), "--table", str(tmp_path / "c.table.jsonl"), "--small", "10"]
    capsys.readouterr()
    for command in (["publish", *given, "--rule", "four-fifths", "-o", str(tmp_path / "out")], ["report", *given]):
        assert main(command) == 2
        assert "half of all are" in capsys.readouterr().err


def test_an_attestation_is_refused_beside_withheld_counts(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """It states how many rows were counted: the total."""
    log, certificate, attestation = (str(tmp_path / name) for name in ("log.csv", "c.json", "a.json"))
    Path(log).write_text("out,sex\n" + "y,f\nn,f\ny,m\nn,m\n" * 20)
    options = ["--decision", "out", "--group", "sex", "--utility", "y", "--confidence", "none", "--no-table"]
    assert main(["certify", log, *options, "-o", certificate, "--attest", attestation]) == 0
    given = ["publish", certificate, "--table", str(tmp_path / "c.table.jsonl"), "--rule", "four-fifths", "-o", str(tmp_path / "out")]
    capsys.readouterr()
    assert main([*given, "--small", "10", "--attestation", attestation]) == 2
    assert "tells counts that are withheld" in capsys.readouterr().err and not (tmp_path / "out").exists()
    assert main([*given, "--small", "10"]) == 0


def test_what_was_done_to_decisions_is_said_where_it_tells_no_number(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    log, names, certificate, out = (tmp_path / name for name in ("scores.csv", "map.toml", "c.json", "out"))
    rows = [f"{points},{sex}\n" for points in (60, 70, 80, 90) for sex in ("w", "Female", "m")] * 15 + ["81,\n"] * 17
    log.write_text("points,sex\n" + "".join(rows))
    names.write_text('[sex]\nw = "Female"\nm = "Male"\n')
    made = ["certify", str(log), "--score", "points", "--above", "70", "--group", "sex", "--map", str(names), "--missing", "drop"]
    assert main([*made, "--confidence", "none", "--no-table", "-o", str(certificate)]) == 0
    given = [str(certificate), "--table", str(tmp_path / "c.table.jsonl"), "--small", "10"]
    out.mkdir()
    pages = []
    for rule in (["four-fifths"], ["ll144", "--sex", "sex"]):
        assert main(["publish", *given, "--rule", *rule, "-o", str(out / rule[0])]) == 0
        pages.append((out / rule[0] / "index.html").read_text("utf-8"))
    capsys.readouterr()
    for form in ("html", "markdown"):
        assert main(["report", *given, "--format", form]) == 0
        pages.append(capsys.readouterr().out)
    assert "Scores were cut at 70." in pages[1]
    for page in pages:
        assert "'points' above 70 counts as 'above', any other as 'not above'" in html.unescape(page)
        assert "'w' counts as 'Female'" in html.unescape(page)
        assert (
            "How many decisions were left out, if any, is not said" in page
            and "17" not in page.rpartition("</style>")[2].split("SHA-256")[0]
        )
