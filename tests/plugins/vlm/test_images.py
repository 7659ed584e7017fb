"""Experiments that show the pictures of a candidate set: the two plug-ins meet in files."""

import csv
import json
from pathlib import Path

import pytest
from language_server import KEY, serving

from fairaudit import InputError, checker
from fairaudit.cli import main
from fairaudit.plugins.vlm.experiment import bundled, read_experiment

pytest.importorskip("scipy")


@pytest.fixture(scope="module")
def office(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("office") / "example"
    assert main(["navigation", "office", str(folder)]) == 0
    return folder


@pytest.mark.parametrize("name", ["documents", "parcels"])
def test_a_rendered_office_is_asked_about_with_pictures(office: Path, name: str, capsys: pytest.CaptureFixture[str]) -> None:
    experiment = office / f"{name}-experiment.toml"
    assert main(["experiment", "render", str(office / f"{name}.toml")]) == 0
    found = read_experiment(experiment)
    assert {option for _, option in found.images} == set(found.options)
    assert main(["experiment", "run", str(experiment), "--trials", "2", "--folder", str(office / f"{name}-run")]) == 0
    assert main(["experiment", "certify", str(experiment), "--trials", "2", "--folder", str(office / f"{name}-run")]) in (0, 3)
    certificates = list((office / f"{name}-run").rglob("*.json"))
    assert any("fairaudit-certificate/1" in path.read_text("utf-8") for path in certificates)


def test_other_pictures_or_candidates_are_refused(office: Path) -> None:
    experiment = office / "documents-experiment.toml"
    assert main(["experiment", "render", str(office / "documents.toml")]) == 0
    place = office / "documents-candidates" / "candidates.json"
    good = place.read_bytes()
    before = read_experiment(experiment).digest
    picture = office / "documents-candidates" / "candidate-1.png"
    kept = picture.read_bytes()
    picture.write_bytes(kept + b" ")
    with pytest.raises(InputError, match="render the scenario again"):
        read_experiment(experiment)
    picture.write_bytes(kept)
    changed = json.loads(good)
    changed["candidates"][0]["label"] = "HR9"
    for content, message in ((json.dumps(changed), "must be the options"), ("{}", "no candidate set"), ("[", "no candidate set")):
        place.write_text(content, "utf-8")
        with pytest.raises(InputError, match=message):
            read_experiment(experiment)
    place.unlink()
    with pytest.raises(InputError, match="cannot be read"):
        read_experiment(experiment)
    place.write_bytes(good)
    assert read_experiment(experiment).digest == before


def test_a_journal_of_other_pictures_is_refused_in_a_sentence(office: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    run = ["experiment", "run", str(office / "documents-experiment.toml"), "--trials", "1", "--folder", str(tmp_path / "run")]
    scenario = office / "documents.toml"
    text = scenario.read_text("utf-8")
    assert main(["experiment", "render", str(scenario)]) == 0 and main(run) == 0
    scenario.write_text(text + "\n[pictures]\nscale = 2\n", "utf-8")
    assert main(["experiment", "render", str(scenario)]) == 0
    capsys.readouterr()
    assert main(run) == 2
    said = capsys.readouterr().err
    assert "belongs to another experiment file or to other pictures" in said and said.count("\n") == 1
    scenario.write_text(text, "utf-8")
    assert main(["experiment", "render", str(scenario)]) == 0 and main(run) == 0


def test_a_server_that_looks_at_pictures(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """The whole road with pictures: what is chosen follows from the bytes of the picture by option and context, and from nothing else."""
    monkeypatch.setenv("OPENAI_API_KEY", KEY)
    monkeypatch.setenv("NO_PROXY", "127.0.0.1")
    for name, size in (("short", 100), ("long", 3_000)):
        (tmp_path / f"{name}.png").write_bytes(b"\x89PNG\r\n\x1a\n" + bytes(size))
    longer = {"maternity leave": "HR2", "holiday leave": "HR1", "sick leave": "HR1"}
    sections = [
        f'[images."{context}"]\n' + "".join(f'{o} = "{"long" if o == option else "short"}.png"\n' for o in ("HR1", "HR2"))
        for context, option in longer.items()
    ]
    path = tmp_path / "pictures.toml"
    path.write_text(bundled()["document-delivery"].read_text("utf-8") + "\n" + "\n".join(sections))
    out = tmp_path / "out"
    with serving(fault=lambda *_: "longest picture") as server:
        command = [str(path), "--folder", str(out), "--trials", "3", "--base-url", server.url, "--model", "m"]
        for action in ("run", "certify", "plot"):
            assert main(["experiment", action, *command]) == 0
        assert len(server.keys) == 3 * 2 * 3
    (counts,) = out.glob("*.counts.csv")
    chosen = {
        (row["document"], row["decision"], row["count"]) for row in csv.DictReader(counts.read_text().splitlines()) if row["count"] != "0"
    }
    assert chosen == {(context, option, "3") for context, option in longer.items()}
    certificates = sorted(out.glob("*.certificate.json"))
    assert [checker.main([str(certificate)]) for certificate in certificates] == [0, 0, 0]
