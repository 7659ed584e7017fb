"""Applicants and selected, read off certificates."""

from __future__ import annotations

import json
from pathlib import Path
from random import Random

import pytest
import tiers

import fairaudit as fa
from fairaudit.errors import FalseCertificate, InputError, TableNeeded
from fairaudit.publications.counts import Counts, decisions_of, favourable_of, read_source, silent_of

LOG = {
    "out": ["hired", "no", "later", "hired", "no", "hired", "no"],
    "sex": ["f", "f", "f", "m", "m", "m", "f"],
    "race": ["a", "a", "b", "a", "b", "b", "b"],
    "dept": ["x", "x", "x", "x", "y", "y", "y"],
    "n": [3, 5, 2, 7, 1, 4, 6],
}


def written(folder: Path, table: object = LOG, utility: object = "hired", **options: object) -> Path:
    path = folder / "certificate.json"
    asked = {"decision": "out", "group": ["sex", "race"], "context": "dept", "count": "n", "confidence": None} | options
    fa.audit(table, utility=utility, **asked).save(path)  # type: ignore[arg-type]
    return path


def test_people_are_counted_over_all_contexts(tmp_path: Path) -> None:
    source = read_source(written(tmp_path))
    counts = decisions_of(source).selected(favourable_of(source))
    by_hand = {("f", "a"): (8, 3), ("f", "b"): (8, 0), ("m", "a"): (7, 7), ("m", "b"): (5, 4)}
    found = zip(counts.applicants, counts.selected, strict=True)
    assert dict(zip(counts.groups, found, strict=True)) == by_hand
    assert counts.by("sex") == Counts(("sex",), (("f",), ("m",)), (16, 12), (3, 11))
    assert set(counts.by("race", "sex").groups) == {(race, sex) for sex, race in by_hand}
    either = decisions_of(source).selected(favourable_of(source, ["later", "hired"]))
    assert sum(either.selected) == sum(counts.selected) + 2


def test_random_logs_are_counted_as_a_loop_counts_them(tmp_path: Path) -> None:
    rng = Random(tiers.fresh("logs"))
    for _ in range(15):
        rows = [(rng.choice("yn"), rng.choice("fm"), rng.choice("abc"), rng.choice("xyz")) for _ in range(rng.randint(20, 200))]
        table = dict(zip(("out", "sex", "race", "dept"), map(list, zip(*rows, strict=True)), strict=True))
        source = read_source(written(tmp_path, table, "y", count=None))
        counts = decisions_of(source).selected(favourable_of(source))
        for group, applied, taken in zip(counts.groups, counts.applicants, counts.selected, strict=True):
            mine = [row for row in rows if row[1:3] == group]
            assert (applied, taken) == (len(mine), sum(row[0] == "y" for row in mine))
        assert sum(counts.applicants) == len(rows)


def test_people_of_unknown_group_are_kept_apart(tmp_path: Path) -> None:
    table = {**LOG, "sex": ["f", "f", "f", "m", "m", "?", "f"]}
    source = read_source(written(tmp_path, table, unknown=["?"]))
    counts = decisions_of(source).selected(["hired"])
    assert counts.unknown == (4, 4)
    assert sum(counts.applicants) == sum(LOG["n"]) - 4  # type: ignore[arg-type]


def test_a_level_of_people_without_a_label_in_which_nobody_is_names_no_group(tmp_path: Path) -> None:
    table = {"out": ["hired", "no"] * 3, "sex": ["f", "f", "m", "m", "", ""], "n": [3, 5, 2, 7, 0, 0]}
    source = read_source(written(tmp_path, table, group="sex", context=[], missing="group"))
    decisions = decisions_of(source)
    assert ("(missing)",) in decisions.groups
    assert silent_of(source.document, decisions) == {("sex", "(missing)")}
    peopled = table | {"n": [3, 5, 2, 7, 1, 0]}
    source = read_source(written(tmp_path, peopled, group="sex", context=[], missing="group"))
    assert silent_of(source.document, decisions_of(source)) == {("sex", "(missing)")}


def test_a_table_beside_the_certificate_is_read_and_checked(tmp_path: Path) -> None:
    path = tmp_path / "c.json"
    law = fa.Law.from_counts(
        {"out": ["y", "n"] * 2, "sex": ["f", "f", "m", "m"], "n": [1, 2, 3, 4]}, decision="out", group="sex", count="n"
    )
    made = fa.certify(law, {"y": 1}, embed_table=False)
    made.certificate.save(path)
    with pytest.raises(TableNeeded, match="--table"):
        read_source(path)
    beside = tmp_path / "c.table.jsonl"
    source = read_source(path, beside)
    assert decisions_of(source).counts == ((1, 2), (3, 4))
    assert source.table == beside.read_bytes()
    beside.write_bytes(beside.read_bytes().replace(b'["3","4"]', b'["4","3"]'))
    with pytest.raises(FalseCertificate, match="nothing was published"):
        read_source(path, beside)
    with pytest.raises(InputError, match="cannot be read"):
        read_source(path, tmp_path / "nowhere")


def test_false_certificates_and_other_documents_are_refused(tmp_path: Path) -> None:
    path = written(tmp_path)
    document = json.loads(path.read_text())
    document["metrics"]["local"]["ratio"] = "9"
    (tmp_path / "false.json").write_text(json.dumps(document))
    with pytest.raises(FalseCertificate, match="nothing was published"):
        read_source(tmp_path / "false.json")
    (tmp_path / "page.html").write_text(fa.report(path))
    with pytest.raises(InputError, match="give the certificate itself"):
        read_source(tmp_path / "page.html")
    (tmp_path / "log.csv").write_text("out,sex\ny,f\n")
    (tmp_path / "summary.json").write_text('{"format": "fairaudit-publication/1"}')
    (tmp_path / "a.json").write_text('{"predicateType": "x"}')
    for name, said in (
        ("log.csv", "give the .json that fairaudit certify wrote, and of a log run that first"),
        ("summary.json", "is not a certificate of the format fairaudit-certificate/1, but of 'fairaudit-publication/1'"),
        ("a.json", "is not a certificate of the format fairaudit-certificate/1, but an attestation of one"),
        ("", "Is a directory; give certificate.json in it"),
    ):
        with pytest.raises(InputError, match=said):
            read_source(tmp_path / name)
    rates = {"out": ["y", "n"] * 2, "sex": ["f", "f", "m", "m"], "p": ["1/3", "2/3", "1/2", "1/2"]}
    fa.audit(rates, decision="out", group="sex", probability="p", utility="y").save(tmp_path / "rates.json")
    with pytest.raises(InputError, match="counts nobody"):
        read_source(tmp_path / "rates.json")
    found = fa.subgroups({k: LOG[k] for k in ("out", "sex", "n")}, decision="out", attributes="sex", count="n", utility="hired")
    found.certificate.save(tmp_path / "subgroups.json")
    with pytest.raises(InputError, match="fairaudit-subgroups/1"):
        read_source(tmp_path / "subgroups.json")


def test_halves_of_people_are_refused(tmp_path: Path) -> None:
    table = {**LOG, "n": ["5/2", 5, 2, 7, 1, 4, 6]}
    source = read_source(written(tmp_path, table))
    with pytest.raises(InputError, match="'5/2' decisions 'hired'"):
        decisions_of(source)


def test_more_people_than_there_ever_were_are_refused(tmp_path: Path) -> None:
    for n, said in ((10**18, "no number of people"), (10**12, "counts 1,000,000,000,025 decisions")):
        source = read_source(written(tmp_path, {**LOG, "n": [n, 5, 2, 7, 1, 4, 6]}))
        with pytest.raises(InputError, match=said):
            decisions_of(source)


@pytest.mark.parametrize(
    ("utility", "options", "why"),
    [
        ({"hired": 2}, {}, "does not say it by 0 and 1"),
        ({"hired": 1, "later": "1/2"}, {}, "does not say it by 0 and 1"),
        ({"no": 1}, {"burden": True}, "counts a burden"),
    ],
)
def test_who_is_selected_is_asked_where_the_utility_does_not_say_it(
    utility: object, options: dict[str, object], why: str, tmp_path: Path
) -> None:
    source = read_source(written(tmp_path, LOG, utility, **options))
    with pytest.raises(InputError, match=rf"{why}; name them with --favourable \(known: .*'hired'"):
        favourable_of(source)
    assert favourable_of(source, ["later"]) == ("later",)
    for bad, said in ((["hirred"], "did you mean 'hired'"), (["no", "no"], "twice")):
        with pytest.raises(InputError, match=said):
            favourable_of(source, bad)
