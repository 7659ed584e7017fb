"""Labels that look undecided: whole labels in some languages, however they are spelt, and no others."""

from __future__ import annotations

from pathlib import Path

import pytest

from fairaudit.errors import InputError
from fairaudit.tables.label_meaning import looking_undecided, read_lexicon

OPEN = (
    "pending|OPEN|Not Applicable|n/a|N/A|withdrawn|under review|on_hold|Offen|noch nicht entschieden|zurückgezogen|ZURUCKGEZOGEN|k. A.|"
    "En  attente|en délibéré|sans objet|en trámite|EN TRAMITE|pendiente|no aplica|in attesa|in corso|ritirato|em análise|em-andamento|"
    "não se aplica|in behandeling|ingetrokken|n.v.t.|w toku|W TRAKCIE|nie dotyczy|-| pending |?"
)

DECIDED = (
    "yes|no|granted|refused|denied|Bewilligt|Abgelehnt|suspended|spending|opened|open-ended|reopened|pending appeal denied|openly|national|"
    "approved|rejected|none|0|1|hired|waitress|offensiv|Offenbach|encours|dismissed|released|failed|suspenso|state|defense"
)


@pytest.mark.parametrize("label", OPEN.split("|"))
def test_a_label_that_decides_nothing_is_found(label: str) -> None:
    assert looking_undecided([label]) == (label,)


@pytest.mark.parametrize("label", DECIDED.split("|"))
def test_a_label_that_only_contains_one_is_not(label: str) -> None:
    assert looking_undecided([label]) == ()


def test_a_file_adds_labels(tmp_path: Path) -> None:
    path = tmp_path / "own.txt"
    path.write_text("# of this office\n\nParked  with Legal\nå vurdere\n", encoding="utf-8-sig")
    assert read_lexicon(path) == ("Parked  with Legal", "å vurdere")
    assert looking_undecided(["parked with legal", "A VURDERE", "legal"], read_lexicon(path)) == ("parked with legal", "A VURDERE")


@pytest.mark.parametrize(
    ("content", "said"),
    [(b"# nothing\n\n", "has no label"), (b"\xff\xfe\x00", "is not a text in UTF-8"), (b"x" * 1_000_001, "more than 1,000,000 bytes")],
)
def test_what_is_no_lexicon_is_a_sentence(content: bytes, said: str, tmp_path: Path) -> None:
    (tmp_path / "own.txt").write_bytes(content)
    with pytest.raises(InputError, match=said):
        read_lexicon(tmp_path / "own.txt")
    with pytest.raises(InputError, match="cannot be read"):
        read_lexicon(tmp_path / "absent.txt")
