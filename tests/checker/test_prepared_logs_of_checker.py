"""What was done to a log before it was counted is under the digest of the table: no alteration that keeps it is true."""

from __future__ import annotations

import hashlib
import json
from collections import Counter
from random import Random as Pick
from typing import Any

import pytest
import tiers
from certificate_changes import canonical, named_anew
from certificate_kinds import outcome
from prepared_logs import PREPARED, alterations, prepared

import fairaudit as fa
from fairaudit import checker

ALTERATIONS = 1000 if tiers.FULL else 100


def as_bytes(document: Any) -> bytes:
    return json.dumps(document).encode()


def test_no_alteration_that_keeps_the_digest_is_true() -> None:
    found = Counter(outcome(as_bytes(changed)) for changed in alterations(ALTERATIONS))
    assert found.total() == ALTERATIONS
    assert set(found) == {"false", "malformed"}
    assert found["false"] > ALTERATIONS / 2


def test_some_of_these_alterations_are_told_by_the_digest_alone() -> None:
    """With digests made anew they are true of the table: only an attestation of the log tells."""
    assert Counter(outcome(named_anew(as_bytes(changed))) for changed in alterations(ALTERATIONS))["true"] > ALTERATIONS / 20


@pytest.mark.parametrize("seed", range(PREPARED))
def test_the_header_names_the_preparation(seed: int) -> None:
    document = prepared(seed)
    assert outcome(as_bytes(document)) == "true"
    named = document["subject"]["table"]["header"]["preparation"]
    assert named == hashlib.sha256(canonical(document["subject"]["preparation"])).hexdigest()


def test_without_the_digest_it_is_refused_and_the_sentence_says_what_lacks() -> None:
    """Certificates of earlier versions are neither true nor false."""
    old = prepared(1)
    del old["subject"]["table"]["header"]["preparation"]
    with pytest.raises(checker.Incomplete, match=r'lacks the key "preparation", the SHA-256 of subject\.preparation'):
        checker.check(as_bytes(old))


def test_what_the_header_names_has_to_be_there() -> None:
    log = {"u": ["y", "n", "y", "n"], "a": ["f", "f", "m", "m"]}
    document = json.loads(fa.audit(log, decision="u", group="a", utility="y").certificate.text)
    assert "preparation" not in document["subject"]["table"]["header"]
    document["subject"]["table"]["header"]["preparation"] = "0" * 64
    assert outcome(named_anew(as_bytes(document))) == "true"  # without it again
    assert outcome(as_bytes(document)) == "false"
    document["subject"]["table"]["header"]["preparation"] = "0" * 63
    assert outcome(as_bytes(document)) == "malformed"


def test_of_subgroups_it_is_the_same() -> None:
    pick = Pick(3)
    log = {name: [pick.choice(labels) for _ in range(200)] for name, labels in {"u": "yn", "a": ["f", "m", ""], "b": "st"}.items()}
    document = json.loads(fa.subgroups(log, decision="u", attributes=["a", "b"], utility="y", missing="drop").certificate.text)
    assert outcome(as_bytes(document)) == "true"
    changed = json.loads(as_bytes(document))
    del changed["subject"]["preparation"]
    for claim in changed["claims"]:
        claim["assumptions"] = [text for text in claim["assumptions"] if "left out" not in text]
    assert outcome(as_bytes(changed)) == "false"
    del document["subject"]["table"]["header"]["preparation"]
    with pytest.raises(checker.Incomplete, match="lacks the key"):
        checker.check(as_bytes(document))
