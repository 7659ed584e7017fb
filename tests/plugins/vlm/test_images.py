"""Experiments that show the pictures of a candidate set: the two plug-ins meet in files."""

import json
from pathlib import Path

import pytest

from fairaudit import InputError
from fairaudit.cli import main
from fairaudit.plugins.vlm.experiment import read_experiment

pytest.importorskip("scipy")


@pytest.fixture(scope="module")
def office(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("office") / "example"
    assert main(["navigation", "office", str(folder)]) == 0
    return folder


@pytest.mark.parametrize("name", ["documents", "parcels"])
def test_a_rendered_office_is_asked_about_with_pictures(office: Path, name: str, capsys: pytest.CaptureFixture[str]) -> None:
    experiment = office / f"{name}-experiment.toml"
    assert main(["experiment", "render", str(experiment)]) == 0
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
