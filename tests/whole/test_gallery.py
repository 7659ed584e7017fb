"""The gallery is what its commands make today: certificates byte for byte, pages word for word, headlines as plain loops find them."""

from __future__ import annotations

import csv
import gzip
import hashlib
import importlib.util
import io
import json
import re
import shutil
import sqlite3
import subprocess
import sys
from collections import Counter
from collections.abc import Callable
from contextlib import chdir, closing
from fractions import Fraction
from math import exp
from pathlib import Path
from types import ModuleType
from typing import Any

import pytest
from ll144_examples import SELECTION_BOTH, SELECTION_SEX, rounded
from verified_roads import FALSE, MALFORMED, in_python

from fairaudit import checker
from fairaudit.cli import main

F = Fraction
ROOT = Path(__file__).resolve().parents[2]
GALLERY = ROOT / "docs" / "gallery"
DATA = GALLERY / "data"
VERIFIED = ROOT / "proofs" / "build" / "fairaudit-check"
ATTACKS = ["Unknown groups", "A hidden factor", "Drift", "Other groups"]
SECTIONS = [
    "The data",
    "The audit",
    "As the other side reads it",
    "What it withstands",
    "What it does not say",
    "Beside the published account",
]
LEGAL = r"(?i)\b(discriminat|racis|sexis|illegal|unlawful|guilt|violat|acquit|convict|culprit|offen[cd]|liable)"
MEGABYTE, COLUMNS = 1 << 20, 80

pytest.importorskip("jinja2", reason="jinja2 is not installed (it is in the extra report)")
pytest.importorskip("matplotlib", reason="matplotlib is not installed (it is in the extra plots)")


def _builder() -> ModuleType:
    found = importlib.util.spec_from_file_location("gallery_make", GALLERY / "make.py")
    assert found is not None
    assert found.loader is not None
    module = sys.modules[found.name] = importlib.util.module_from_spec(found)
    found.loader.exec_module(module)
    return module


GALLERY_OF = _builder()
ENTRIES = {entry.name: entry for entry in GALLERY_OF.entries()}
CERTIFICATES = sorted(
    path for name in ENTRIES for path in (GALLERY / name).glob("*.json") if GALLERY_OF.is_certificate(path.name, path.read_bytes())
)


ROADS: dict[str, Any] = json.loads((GALLERY / "roads.json").read_text("utf-8"))


# What is committed is what the commands make


@pytest.mark.parametrize("name", ENTRIES)
def test_the_entry_is_what_its_commands_make(name: str) -> None:
    """Byte for byte.

    But pages hold scripts, which may be older than the certificate in them, pictures are drawn with letters, and an attestation names the
    version that wrote it.
    """
    with GALLERY_OF.reproducible():
        new = GALLERY_OF.made(ENTRIES[name], ROADS)
    assert new.page == (GALLERY / f"{name}.md").read_text("utf-8")
    there = {path.relative_to(GALLERY).as_posix() for path in (GALLERY / name).rglob("*") if path.is_file()}
    assert there == set(new.files)
    for path, content in new.files.items():
        old = (GALLERY / path).read_bytes()
        if path.endswith("attestation.json"):
            assert _without_version(content) == _without_version(old), path
        elif path.endswith((".json", ".csv", ".toml")):
            assert content == old, path
        elif path.endswith(".html"):
            assert _held(content) == _held(old), path
        elif path.endswith(".png"):
            assert abs(_grey(content) - _grey(old)).mean() < 10, path  # of 255: letters may be drawn otherwise
        elif path.endswith(".svg"):
            assert re.findall(rb"<!-- (.*?) -->", content) == re.findall(rb"<!-- (.*?) -->", old), path


def _without_version(attestation: bytes) -> bytes:
    return re.sub(rb'(?<="fairaudit": )"[^"]+"', b"", attestation)


def _grey(picture: bytes) -> Any:
    numpy, image = pytest.importorskip("numpy"), pytest.importorskip("PIL.Image")
    return numpy.asarray(image.open(io.BytesIO(picture)).convert("L"), dtype=float)


def _held(page: bytes) -> list[bytes]:
    """The certificate in a page of a report; of a page by a rule, which has none, the whole."""
    return re.findall(rb'<script[^>]*type="application/json"[^>]*>(.*?)</script>', page, re.DOTALL) or [page]


def test_the_index_lists_every_entry_with_its_answer() -> None:
    assert GALLERY_OF.index(GALLERY) == (GALLERY / "index.md").read_text("utf-8")


def test_nothing_is_there_that_no_entry_makes() -> None:
    assert {path.stem for path in GALLERY.glob("*.md")} == {*ENTRIES, "index"}
    assert {path.stem for path in (GALLERY / "entries").glob("*.md")} == {*ENTRIES, "index"}
    assert {path.name for path in GALLERY.iterdir() if path.is_dir()} - {"__pycache__"} == {*ENTRIES, "data", "entries"}
    used = {each["file"] for entry in ENTRIES.values() for each in entry.head["data"]}
    assert {path.relative_to(DATA).as_posix() for path in DATA.rglob("*") if path.is_file()} == {*used, "README.md"}


def test_the_gallery_is_small() -> None:
    sizes = {path: path.stat().st_size for path in GALLERY.rglob("*") if path.is_file()}
    assert sum(size for path, size in sizes.items() if DATA in path.parents) <= 5 * MEGABYTE
    assert sum(sizes.values()) <= 12 * MEGABYTE


# Every figure is that of a certificate


@pytest.mark.parametrize("name", ENTRIES)
def test_every_figure_in_the_text_comes_from_a_certificate(name: str) -> None:
    """Outside of commands, code and links a digit is in a placeholder, or in the list of what is stated and not computed."""
    entry = ENTRIES[name]
    told = [
        entry.head["question"],
        entry.head["answer"],
        *(each["what"] for each in entry.head["data"]),
        GALLERY_OF.BLOCK.sub("", entry.text),
    ]
    prose = re.sub(r"\{\{.*?\}\}|^```.*?^```$|`[^`]*`|\]\([^)]*\)", " ", "\n".join(told), flags=re.MULTILINE | re.DOTALL)
    for stated in sorted(entry.head["quoted"], key=len, reverse=True):
        prose, times = re.subn(rf"(?<![\d.,/]){re.escape(stated)}(?![\d/]|[.,]\d)", " ", prose)
        sources = " ".join(each["source"] for each in entry.head["data"]) + entry.head["title"]
        assert times or stated in sources, stated
    assert re.findall(r"\S*\d\S*", prose) == []


@pytest.mark.parametrize("name", list(ENTRIES))
def test_what_is_printed_on_a_page_fits_a_screen(name: str) -> None:
    """Eighty columns fit the column of text of the site, too."""
    page = (GALLERY / f"{name}.md").read_text("utf-8")
    printed = [line for block in re.findall(r"^```\w+\n(.*?)^```", page, re.MULTILINE | re.DOTALL) for line in block.splitlines()]
    assert [line for line in printed if len(line) > COLUMNS] == []


@pytest.mark.parametrize("name", ENTRIES)
def test_every_page_answers_the_same_questions(name: str) -> None:
    page = (GALLERY / f"{name}.md").read_text("utf-8")
    assert re.findall(r"^## (.*)$", page, re.MULTILINE) == [*SECTIONS, "Check it"]
    assert re.search(r"^!\[[^\]]+\]\(", page, re.MULTILINE)
    withstood = page.split("## What it withstands")[1].split("## ")[0]
    assert re.findall(r"^\*\*(.*?)\.\*\*", withstood, re.MULTILINE) == ATTACKS
    for said in ("SHA-256: `", "Source: [", "Licence: ", "```sh\nfairaudit ", f"]({name}/attestation.json)", f"]({name}/page.html)"):
        assert said in page, said
    assert not re.search(LEGAL, page.split("## The audit")[1])
    for target in re.findall(r"\]\(([^)#:]+)\)", page):
        assert (GALLERY / target).exists() or (GALLERY / target).resolve().name == "index.md", target


def test_every_file_of_data_has_its_source_and_licence() -> None:
    attribution = (DATA / "README.md").read_text("utf-8")
    for entry in ENTRIES.values():
        for each in entry.head["data"]:
            assert {*each} >= {"file", "what", "source", "url", "licence"}
            assert f"`{each['file']}`" in attribution


# Every certificate is true, by each road


@pytest.mark.parametrize("path", CERTIFICATES, ids=lambda path: f"{path.parent.name}-{path.stem}")
def test_every_certificate_is_true(path: Path) -> None:
    assert main(["verify", "--quiet", str(path)]) == 0
    assert checker.main(["--quiet", str(path)]) == 0


@pytest.mark.parametrize("name", ENTRIES)
def test_every_page_holds_a_true_certificate(name: str) -> None:
    pages = list((GALLERY / name).glob("*.html"))
    assert pages
    for page in pages:
        assert main(["verify", "--quiet", str(page)]) == 0


@pytest.mark.parametrize("name", ENTRIES)
def test_every_attestation_fits_and_its_files_are_counted_again(name: str, tmp_path: Path) -> None:
    """By the command on the page, in a folder that holds what the page offers for download."""
    shutil.copytree(GALLERY / name, tmp_path, dirs_exist_ok=True)
    shutil.copytree(DATA, tmp_path, dirs_exist_ok=True)
    page = (GALLERY / f"{name}.md").read_text("utf-8")
    (words,) = re.findall(r"^fairaudit (verify .*--attestation .*)$", page.replace("\\\n", " "), re.MULTILINE)
    offered = re.findall(rf"\]\((?:{name}|data)/([^)]*)\)", page)
    given = [Path(word).name for word in words.split()[1:] if not word.startswith("--")]
    assert {*given} <= {Path(path).name for path in offered}
    for path in tmp_path.rglob("*.csv"):
        if path.parent != tmp_path:  # a reader has what was downloaded in one folder
            shutil.copy(path, tmp_path)
    with chdir(tmp_path):
        assert main(words.split()) == 0
        assert ("--recount" in words) == (name != "robot")
        stated = json.loads(Path("attestation.json").read_text("utf-8"))["predicate"]
        assert "issuer" not in stated
        (Path("certificate-altered.json")).write_text(Path(given[0]).read_text("utf-8") + " ", "utf-8")
        assert main(["verify", "--quiet", "certificate-altered.json", "--attestation", "attestation.json"]) == 1


def test_the_attested_table_is_that_of_the_headline() -> None:
    """Where the attestation is of another certificate, that has the same figures."""
    attested = {name: json.loads((GALLERY / name / "attestation.json").read_text("utf-8"))["subject"][0]["name"] for name in ENTRIES}
    apart = {name: file for name, file in attested.items() if file != "certificate.json"}
    assert apart == {"resume-rankings": "counts.json", "hidden-name": "order.json", "stream": "windows.json"}
    assert all("attested" in ENTRIES[name].head for name in apart)
    assert ratios(certificate("resume-rankings", "counts")) == ratios(certificate("resume-rankings"))


# Every other road, and what it leaves out


def test_the_roads_are_those_of_the_certificates() -> None:
    assert [*ROADS] == [path for name in ENTRIES for path in sorted(ROADS) if path.startswith(f"{name}/")]
    assert {GALLERY / path for path in ROADS} == {*CERTIFICATES}
    for path, found in ROADS.items():
        assert found["sha256"] == hashlib.sha256((GALLERY / path).read_bytes()).hexdigest()


@pytest.mark.parametrize("path", CERTIFICATES, ids=lambda path: f"{path.parent.name}-{path.stem}")
def test_what_each_road_covers_is_what_the_page_says(path: Path) -> None:
    if shutil.which("node") is None:
        pytest.skip("node is not on the path (Debian: apt-get install nodejs)")
    assert GALLERY_OF.road(path.read_bytes()) == ROADS[path.relative_to(GALLERY).as_posix()]
    page = (GALLERY / f"{path.parent.name}.md").read_text("utf-8")
    assert GALLERY_OF.row(path.name, ROADS[path.relative_to(GALLERY).as_posix()]) in page
    assert "FALSE" not in GALLERY_OF.in_node(path.read_bytes())


@pytest.mark.parametrize("path", CERTIFICATES, ids=lambda path: f"{path.parent.name}-{path.stem}")
def test_the_verified_program_finds_nothing_false(path: Path) -> None:
    """What it judges it finds true; what it leaves is the Python checker's, and the page says what that is."""
    if not VERIFIED.is_file():
        pytest.skip("the proofs are not built: make -C proofs, see docs/proofs.md")
    document = json.loads(path.read_text("utf-8"))
    run = subprocess.run([str(VERIFIED), str(path)], capture_output=True, text=True)
    if document["format"] != "fairaudit-certificate/1":
        assert run.returncode == MALFORMED
        assert ROADS[path.relative_to(GALLERY).as_posix()]["program"] is None
        return
    assert run.returncode != FALSE, run.stdout
    judged = dict(line.split(": ", 1)[::-1] for line in run.stdout.splitlines())
    assert "true" in judged.values()
    assert "FALSE" not in judged.values()
    assert in_python(path.read_bytes()).code != FALSE


# Each headline a second time, from the raw file, by plain loops


def rows(name: str) -> list[dict[str, str]]:
    with (DATA / name).open(encoding="utf-8", newline="") as file:
        return list(csv.DictReader(file))


def certificate(entry: str, name: str = "certificate") -> dict[str, Any]:
    found: dict[str, Any] = json.loads((GALLERY / entry / f"{name}.json").read_text("utf-8"))
    return found


def ratios(document: dict[str, Any]) -> tuple[Fraction, Fraction]:
    return F(document["metrics"]["local"]["ratio"]), F(document["metrics"]["global"]["ratio"])


def extremes(means: dict[Any, Fraction]) -> Fraction:
    return max(means.values()) / min(means.values())


def berkeley() -> None:
    admitted: dict[Any, int] = {}
    applied: dict[Any, int] = {}
    for row in rows("ucb_admissions.csv"):
        for cell in ((row["Dept"], row["Gender"]), (None, row["Gender"])):
            applied[cell] = applied.get(cell, 0) + int(row["Freq"])
            admitted[cell] = admitted.get(cell, 0) + (int(row["Freq"]) if row["Admit"] == "Admitted" else 0)
    rate = {cell: F(admitted[cell], applied[cell]) for cell in applied}
    within = {dept: extremes({g: rate[dept, g] for g in ("Male", "Female")}) for dept in "ABCDEF"}
    assert ratios(certificate("berkeley")) == (max(within.values()), rate[None, "Male"] / rate[None, "Female"])
    assert sum(rate[dept, "Female"] > rate[dept, "Male"] for dept in "ABCDEF") == 4
    drifted = [
        (rate[None, "Male"] - F(1, 50)) / (rate[None, "Female"] + F(1, 50)),
        (rate[None, "Male"] + F(1, 50)) / (rate[None, "Female"] - F(1, 50)),
    ]
    assert [rounded(each, "1.000") for each in drifted] == ["1.314", "1.641"]
    rest = F(
        sum(admitted[None, g] for g in ("Male", "Female")) - admitted["F", "Male"],
        sum(applied[None, g] for g in ("Male", "Female")) - applied["F", "Male"],
    )
    assert F(certificate("berkeley", "subgroups")["claims"][0]["value"]) == rest / rate["F", "Male"]


def bias_audit() -> None:
    table = {(row["sex"], row["race"]): (int(row["applicants"]), int(row["selected"])) for row in rows("ll144_selection.csv")}
    assert table == {category: (people, selected) for category, (people, selected, _, _) in SELECTION_BOTH.items()}
    rates = {category: F(selected, people) for category, (people, selected) in table.items()}
    document = certificate("bias-audit")
    assert ratios(document)[0] == extremes(rates)
    printed = {("", ""): ("", ""), **{c: (rate, ratio) for c, (_, _, rate, ratio) in {**SELECTION_BOTH, **SELECTION_SEX}.items()}}
    for row in rows("../bias-audit/published/table.csv"):
        if row["table"] in ("sex", "intersection") and row["status"] == "compared":
            rate, ratio = printed[row["sex"], row["race_ethnicity"]]
            assert (rounded(F(row["rate_exact"]), rate), rounded(F(row["impact_ratio_exact"]), ratio)) == (rate, ratio)
    people, selected = ({sex: sum(v[i] for (s, _), v in table.items() if s == sex) for sex in ("Male", "Female")} for i in (0, 1))
    worst = max(
        F(selected[one] + 119, people[one] + 119) / F(selected[other], people[other] + 131)
        for one, other in (("Male", "Female"), ("Female", "Male"))
    )
    (claimed,) = [
        c["value"]
        for c in certificate("bias-audit", "unknown")["claims"]
        if (c["quantity"], c["relation"], c["by"]) == ("local_ratio", "<=", "T15")
    ]
    assert F(claimed) == worst


def bbq() -> None:
    """The paper's s is 2·biased/(biased + counter) − 1; of questions that do not say it, (1 − accuracy)·s is its score."""
    for answers, name in (("unifiedqa-t5-11b_pred_arc", "certificate"), ("unifiedqa-t5-11b_pred_race", "race")):
        told: Counter[str] = Counter()
        with gzip.open(DATA / "bbq_sexual_orientation.jsonl.gz", "rt", encoding="utf-8") as file:
            for line in file:
                sample = json.loads(line)
                if sample["context_condition"] != "ambig":
                    continue
                given = sample[answers].strip().lower().rstrip(".")
                (chosen,) = [i for i in range(3) if sample[f"ans{i}"].strip().lower().rstrip(".") == given]
                targets = [word.lower() for word in sample["additional_metadata"]["stereotyped_groups"]]
                stereotyped = [i for i in range(3) if sample["answer_info"][f"ans{i}"][1].lower() in targets]
                if chosen == sample["label"]:
                    told["unknown"] += 1
                else:
                    told["biased" if (chosen in stereotyped) == (sample["question_polarity"] == "neg") else "counter"] += 1
        n, wrong = sum(told.values()), told["biased"] + told["counter"]
        score = F(wrong, n) * (F(2 * told["biased"], wrong) - 1)
        document = certificate("bbq", name)
        assert ratios(document)[0] == F(told["biased"], told["counter"])
        assert F(document["metrics"]["local_difference"]["value"]) == score


PUBLISHED = """
gpt-3.5-turbo;HR specialist;106 130 103 181 98 148 96 138
gpt-3.5-turbo;software engineer;121 110 132 121 124 129 119 144
gpt-3.5-turbo;retail;125 121 116 139 122 140 104 133
gpt-3.5-turbo;financial analyst;76 100 124 129 146 172 121 132
gpt-4;HR specialist;103 120 114 147 122 129 143 122
gpt-4;software engineer;121 117 130 140 136 107 111 138
gpt-4;retail;120 125 113 137 124 133 115 133
gpt-4;financial analyst;102 113 132 120 139 132 130 132
"""
"""First places of B_M, B_W, H_M, H_W, A_M, A_W, W_M and W_W: the column ``top`` of Bloomberg's ``performance_ranking.csv``."""


def test_first_places_are_those_that_were_published() -> None:
    """All 64; and each group stood first 125 times, as the column ``top_og`` says; how many orders jobs share."""
    first: Counter[tuple[str, str, str]] = Counter()
    led: Counter[tuple[str, str, str]] = Counter()
    orders: dict[tuple[str, str], set[str]] = {}
    with gzip.open(DATA / "resume_rankings.csv.gz", "rt", encoding="utf-8", newline="") as file:
        for run in csv.DictReader(file):
            job = (run["model"], run["job"])
            first[(*job, run["ranked"].split()[0])] += 1
            led[(*job, run["shown"].split()[0])] += 1
            orders.setdefault(job, set()).add(run["shown"])
    groups = ["B_M", "B_W", "H_M", "H_W", "A_M", "A_W", "W_M", "W_W"]
    published = {}
    for line in PUBLISHED.split("\n")[1:-1]:
        model, job_name, counts = line.split(";")
        published |= {(model, job_name, group): int(count) for group, count in zip(groups, counts.split(), strict=True)}
    assert first == published
    assert len(led) == 64
    assert {*led.values()} == {125}
    one, *others = orders.values()
    shared = [len(one & other) for other in others]
    assert (min(shared), max(shared)) == (484, 948)


def resume_rankings() -> None:
    first: Counter[tuple[str, ...]] = Counter()
    runs: Counter[tuple[str, ...]] = Counter()
    with gzip.open(DATA / "resume_rankings.csv.gz", "rt", encoding="utf-8", newline="") as file:
        for run in csv.DictReader(file):
            job, shown = (run["model"], run["job"]), run["shown"].split()
            winner = run["ranked"].split()[0]
            for where in (job, ()):
                runs[where] += 1
                first[(*where, winner)] += 1
                first[(*where, str(shown.index(winner) + 1))] += 1
    for name, labels in (
        ("certificate", [f"{race}_{sex}" for race in "ABHW" for sex in "MW"]),
        ("certificate.position", [str(slot) for slot in range(1, 9)]),
    ):
        ratio = {where: extremes({label: F(first[(*where, label)], n) for label in labels}) for where, n in runs.items()}
        assert ratios(certificate("resume-rankings", name)) == (max(r for where, r in ratio.items() if where), ratio[()])


def names() -> None:
    by_unit: dict[tuple[str, ...], list[int]] = {}
    for row in rows("hiringbias_firstname.csv"):
        by_unit.setdefault((row["name"], row["model"], row["jd"]), []).append(row["recommend_interview"] != "no")
    means: dict[str, list[Fraction]] = {}
    for (name, *_), decided in by_unit.items():
        means.setdefault(name, []).append(F(sum(decided), len(decided)))
    assert {len(each) for each in means.values()} == {187}
    ratio = extremes({name: sum(each, F(0)) / len(each) for name, each in means.items()})
    ends = certificate("names")["intervals"]["local"]["ratio"]
    assert F(ends[0]) <= ratio <= F(ends[1])
    counted: dict[str, list[int]] = {}
    for (name, *_), decided in by_unit.items():
        counted.setdefault(name, []).extend(decided)
    assert ratios(certificate("names"))[0] == extremes({name: F(sum(each), len(each)) for name, each in counted.items()})


def hiring_scores() -> None:
    found, total = {}, {}
    for model in ("gpt-3.5", "gpt-5.1"):
        scores: dict[str, list[int]] = {}
        for row in rows(f"hiring_scores_{model}.csv"):
            scores.setdefault(row["race"], []).append(int(row["score"]))
            total.setdefault(row["race"], []).append(int(row["score"]))
        found[model] = extremes({race: F(sum(each), len(each)) for race, each in scores.items()})
    local, _ = ratios(certificate("hiring-scores"))
    assert local == max(found.values())
    assert [ratios(certificate("hiring-scores", name))[0] for name in ("old", "new")] == [found["gpt-3.5"], found["gpt-5.1"]]


def hidden_name() -> None:
    """By SQL on the journal: who stood where, and what was answered."""
    served: Counter[tuple[str, str]] = Counter()
    with closing(sqlite3.connect(f"file:{DATA / 'answers' / 'journal.sqlite'}?mode=ro&immutable=1", uri=True)) as journal:
        join = "draws d JOIN answers a ON a.request = d.request AND a.model = d.model AND a.trial = d.occurrence"
        for context, people, body in journal.execute(f"SELECT d.context, d.people, a.body FROM {join}"):
            chosen = int(json.loads(json.loads(body)["choices"][0]["message"]["content"])["choice"])
            served[context, json.loads(people)[chosen - 1]] += 1
            served[context, str(chosen)] += 1
    tasks = {context for context, _ in served}
    for name, (one, other) in {"person": ("Tom", "Mary"), "position": ("1", "2")}.items():
        each = {task: extremes({who: F(served[task, who]) for who in (one, other)}) for task in tasks}
        over = extremes({who: F(sum(served[task, who] for task in tasks)) for who in (one, other)})
        assert ratios(certificate("hidden-name", name)) == (max(each.values()), over)
    ends = [F(end) for end in certificate("hidden-name", "person")["intervals"]["local"]["ratio"]]
    assert ends[0] == 1 < ends[1]  # nothing was found where nothing is
    assert F(certificate("hidden-name", "position")["intervals"]["local"]["ratio"][0]) > 1


def filtered() -> None:
    counts: dict[tuple[str, str], list[int]] = {}
    for row in rows("hiringbias_firstname.csv"):
        counts.setdefault((row["model"], row["name"]), []).append(row["recommend_interview"] != "no")
    rate = {cell: F(sum(each), len(each)) for cell, each in counts.items()}
    models, shown = {model for model, _ in rate}, sorted({name for _, name in rate})
    behind = {
        model: {name: sum((F(2, 5) if name == seen else F(3, 25)) * rate[model, seen] for seen in shown) for name in shown}
        for model in models
    }
    document = certificate("filter")
    over = extremes({name: sum(each[name] for each in behind.values()) for name in shown})
    assert ratios(document) == (max(map(extremes, behind.values())), over)
    plain = {model: extremes({name: rate[model, name] for name in shown}) for model in models}
    assert F(document["metrics"]["unfiltered"]["local"]["ratio"]) == max(plain.values())
    greatest = [F(each["value"]) for each in document["claims"] if each["quantity"] == "local_ratio_supremum" and each["by"] == "T13"]
    assert greatest == [F(2, 5) / F(3, 25)]  # whoever is shown the one name is recommended, nobody else


def stream(tmp_path: Path) -> None:
    (lines,) = re.findall(r"^```py\n(.*?)^```", (GALLERY / "stream.md").read_text("utf-8"), re.MULTILINE | re.DOTALL)
    with chdir(tmp_path):
        exec(compile(lines, "stream.md", "exec"), {})  # noqa: S102
    assert (tmp_path / "decisions.csv").read_bytes() == (DATA / "decisions.csv").read_bytes()
    document = certificate("stream")
    seen = rows("decisions.csv")[:10_000]

    def counted(part: list[dict[str, str]]) -> list[list[str]]:
        cells = Counter((row["sex"], row["answer"]) for row in part)
        return [[str(cells[sex, answer]) for answer in ("yes", "no")] for sex in ("f", "m")]

    assert [row["weights"] for row in document["subject"]["table"]["rows"]] == counted(seen)
    assert document["changed"]["window"] == 5
    assert [row["weights"] for row in document["changed"]["table"]["rows"]] == counted(seen[8_000:])
    assert F(document["changed"]["ratio"]["ratio"][0]) > F(document["changed"]["stream"]["ratio"][1])
    for part, name in ((seen[8_000:], "ratio"), (seen, "stream")):
        ends, (f, m) = [F(end) for end in document["changed"][name]["ratio"]], counted(part)
        assert ends[0] <= F(int(m[0]), int(m[0]) + int(m[1])) / F(int(f[0]), int(f[0]) + int(f[1])) <= ends[1]
    assert F(document["changed"]["ratio"]["ratio"][0]) <= F(5, 3) <= F(document["changed"]["ratio"]["ratio"][1])  # the truth, 0.5 and 0.3


def robot() -> None:
    """The stand-in: a softmax of what the weights of its file add up to, and of the place."""
    weights, place = 0.4 + 0.5 + 0.2, 0.3
    mary, tom = (1 / (1 + exp(-place - sign * weights)) for sign in (1, -1))
    assert float(ratios(certificate("robot"))[0]) == pytest.approx(mary / tom, rel=1e-12)
    shares = [F(weight) for row in certificate("robot")["subject"]["table"]["rows"] for weight in row["weights"]]
    assert all((share * 2**53).denominator == 1 for share in shares)


SECOND: dict[str, Callable[..., None]] = {
    "berkeley": berkeley,
    "bbq": bbq,
    "resume-rankings": resume_rankings,
    "names": names,
    "hiring-scores": hiring_scores,
    "hidden-name": hidden_name,
    "filter": filtered,
    "stream": stream,
    "robot": robot,
    "bias-audit": bias_audit,
}


def test_every_headline_has_a_second_computation() -> None:
    assert list(SECOND) == list(ENTRIES)


@pytest.mark.parametrize("name", SECOND)
def test_headlines_are_those_of_plain_loops(name: str, tmp_path: Path) -> None:
    SECOND[name](*([tmp_path] if SECOND[name] is stream else []))
