"""Certificates from end to end: what the writer writes is accepted, and whatever is changed in it is not."""

from __future__ import annotations

import hashlib
import json
import random
import re
import unicodedata
from collections.abc import Callable, Iterator
from functools import cache
from itertools import islice, permutations
from pathlib import Path
from typing import Any

import pytest
import tiers
from certificate_changes import (
    NUMBER,
    changed_text,
    changed_values,
    other_tables,
    other_values,
    places,
    put,
    redigested,
    says_no_more,
    still_true,
    strings,
    swapped_sections,
)
from certificate_kinds import (
    FOUR,
    KINDS,
    LONG_TABLE,
    SCHEMA,
    as_bytes,
    assert_accepted,
    by_context,
    by_group,
    fractional_counts,
    huge_and_tiny,
    independent,
    infinite,
    many_columns,
    never_globally,
    never_locally,
    outcome,
    small_counts,
    true_labels,
    weighted,
)
from hypothesis import HealthCheck, assume, given, settings
from hypothesis import strategies as st
from jsonschema import Draft202012Validator

import fairaudit as fa
from fairaudit import checker
from fairaudit.certificates.certificate import schema
from fairaudit.cli import main as command
from fairaudit.tables.examples import EXAMPLES
from fairaudit.testing import laws, utilities

THIN = 1 if tiers.FULL else 7
"""One change in so many is tried. All of them: FAIRAUDIT_FULL=1 pytest tests/certificates/test_certificates.py"""

# What the writer writes is accepted


@pytest.mark.parametrize("embed", [True, False])
@pytest.mark.parametrize("options", [{}, FOUR], ids=["no target", "four targets"])
@pytest.mark.parametrize("kind", KINDS)
def test_written_certificates_are_accepted(
    kind: Callable[..., fa.Result], options: dict[str, Any], embed: bool, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    result = kind(**options, embed_table=embed)
    assert_accepted(result.certificate)
    assert ("salt" in result.certificate.text) is False and (result.certificate.table is None) is embed
    path = tmp_path / "c.json"
    arguments = [str(path)] + ([] if embed else ["--table", str(tmp_path / "c.table.jsonl")])
    assert sorted(result.certificate.save(path)) == sorted([path, *[tmp_path / "c.table.jsonl"] * (not embed)])
    assert checker.main(arguments) == 0
    assert checker.main([*arguments, "--require", "within"]) == (0 if result.verdict == "within" else 1)
    assert "FALSE" not in capsys.readouterr().out
    assert len(json.loads(result.certificate.text)["targets"]) == len(result.targets)
    assert bool(result.targets) is bool(options)


def test_the_kinds_are_as_different_as_they_should_be() -> None:
    documents = {kind.__name__: json.loads(kind(**FOUR).certificate.text) for kind in KINDS}
    assert documents["infinite"]["metrics"]["local"]["ratio"] == "inf" and documents["infinite"]["metrics"]["local"]["log"] == [
        "inf",
        "inf",
    ]
    assert documents["never_locally"]["metrics"]["local"] is None and documents["never_locally"]["metrics"]["global"] is not None
    assert documents["never_locally"]["subject"]["utility"]["tau"] is None
    assert documents["never_globally"]["metrics"]["global"] is None and documents["never_globally"]["metrics"]["local"] is not None
    assert {d["verdict"] for d in documents.values()} == {"within", "exceeds", "inconclusive"}
    assert [n for n, d in documents.items() if any(c["by"] == "T5" for c in d["claims"])] == [
        "independent",
        "by_context",
        "floats",
        "rows_dropped",
        "profiles",
    ]
    assert documents["weighted"]["not_compared"] == [{"groups": [["x"]], "reason": "no population"}]
    assert documents["rows_dropped"]["claims"][0]["assumptions"]
    assert documents["by_context"]["subject"]["utility"]["depends_on_group"] is False
    assert documents["by_context"]["subject"]["table"]["header"]["utility"] is None
    assert documents["by_group"]["subject"]["utility"]["depends_on_group"] is True
    assert any(None in row["utility"] for row in documents["by_group"]["subject"]["table"]["rows"])
    assert documents["no_context"]["metrics"]["local"]["witness"]["context"] == {}
    assert {r["reason"] for d in documents.values() for r in d["not_compared"]} == {
        "no decisions recorded",
        "fewer than two groups",
        "no population",
        "a group is missing in a context and no population was given",
        "no decisions with the positive true label",
        "no decisions with another true label",
    }
    populations = {(d["subject"]["kind"], d["subject"]["population"]) for d in documents.values()}
    assert populations == {("counts", "counts"), ("probabilities", "weights"), ("probabilities", "equal")}


def test_every_example_is_among_the_kinds() -> None:
    assert {entry.name for entry in EXAMPLES if entry.decision} == {"ucb-admissions", "hr-navigation"}


@given(data=st.data())
@settings(deadline=None, suppress_health_check=list(HealthCheck))
def test_drawn_certificates_are_accepted(data: st.DataObject) -> None:
    independence = data.draw(st.sampled_from([False, False, True]))
    law = data.draw(laws(max_contexts=3, max_groups=4, max_decisions=4, independent=independence))
    utility = data.draw(utilities(law, group_blind=data.draw(st.booleans())))
    logs, ratios = st.sampled_from([None, 0, "1/10", "0.2", "1e-300", 700]), st.sampled_from([None, 1, "5/4", "1e300", 1.5])
    limits = {
        "max_local_log": data.draw(logs),
        "max_global_log": data.draw(logs),
        "max_local_ratio": data.draw(ratios),
        "max_global_ratio": data.draw(ratios),
    }
    try:
        result = fa.certify(law, utility, **limits, confidence=None, embed_table=data.draw(st.sampled_from([True, True, False])))
    except fa.InputError as error:
        assume("no two groups can be compared" not in str(error))
        raise
    assert_accepted(result.certificate)


@cache
def mutable(kind: Callable[..., fa.Result], embed: bool = True) -> tuple[Any, tuple[bytes, ...] | None]:
    certificate = kind(**FOUR, embed_table=embed).certificate
    return json.loads(certificate.text), None if certificate.table is None else tuple(certificate.table.lines())


def assert_rejected(original: Any, mutants: Iterator[bytes], lines: list[bytes] | None, tmp_path: Path) -> int:
    """Every mutant is rejected, but for those that are demonstrably true; and so says the command. Returns how many were."""
    assert outcome(as_bytes(original), lines) == "true"
    rejected: set[bytes] = set()
    true: set[bytes] = set()
    seen = 0
    beside = tmp_path / "t.jsonl"
    beside.write_bytes(b"".join(lines or []))
    for mutant in mutants:
        if mutant in rejected or mutant in true:
            continue
        found = outcome(mutant, lines)
        seen += 1
        said = (found == "true" or seen % 5 == 0) and still_true(original, mutant)
        if said or (found == "true" and says_no_more(original, mutant)):
            assert found == "true", mutant
            assert SCHEMA.is_valid(json.loads(mutant)), mutant
            true.add(mutant)
            continue
        assert found in ("false", "malformed") or (found == "table needed" and lines is None), mutant
        rejected.add(mutant)
        if len(rejected) % 100 == 1:
            path = tmp_path / "mutant.json"
            path.write_bytes(mutant)
            code = checker.main([str(path), *(["--table", str(beside)] if lines else [])])
            assert code == {"false": 1, "malformed": 2, "table needed": 3}[found]
    return len(rejected)


@pytest.mark.parametrize(
    ("kind", "step"),  # all changes of one certificate, and every second to fifth of some more
    [
        (small_counts, 2),
        (never_globally, 1),
        (weighted, 4),
        (by_group, 4),
        (independent, 5),
        (infinite, 5),
        (never_locally, 5),
        (true_labels, 9),
    ],
)
def test_changed_values(kind: Callable[..., fa.Result], step: int, tmp_path: Path) -> None:
    document, lines = mutable(kind)
    assert assert_rejected(document, changed_values(document, step=step * THIN), None, tmp_path) > 5000 // (step * THIN)
    assert lines is None


@pytest.mark.parametrize(("kind", "step"), [(small_counts, 4), (weighted, 2), (true_labels, 9)])
def test_changed_values_beside_a_table_in_a_file(kind: Callable[..., fa.Result], step: int, tmp_path: Path) -> None:
    document, lines = mutable(kind, embed=False)
    assert lines is not None
    assert outcome(as_bytes(document)) == "table needed"
    assert assert_rejected(document, changed_values(document, step=step * THIN), list(lines), tmp_path) > 5000 // (step * THIN)


@pytest.mark.parametrize("kind", [small_counts, weighted, never_globally])
def test_changed_text(kind: Callable[..., fa.Result], tmp_path: Path) -> None:
    document, _ = mutable(kind)
    assert assert_rejected(document, islice(changed_text(document), 0, None, THIN), None, tmp_path) > 3000 // THIN


@pytest.mark.parametrize("kind", LONG_TABLE)
def test_parts_of_other_certificates(kind: Callable[..., fa.Result], tmp_path: Path) -> None:
    document, _ = mutable(kind)
    others = [mutable(other)[0] for other in [*LONG_TABLE, many_columns, huge_and_tiny] if other is not kind]
    assert assert_rejected(document, swapped_sections(document, others), None, tmp_path) > 200


@pytest.mark.parametrize("kind", [small_counts, fractional_counts, weighted, by_group, by_context, true_labels])
def test_another_table_with_its_own_digest(kind: Callable[..., fa.Result], tmp_path: Path) -> None:
    document, _ = mutable(kind)
    assert redigested(json.loads(json.dumps(document))) == as_bytes(document)
    assert assert_rejected(document, other_tables(document), None, tmp_path) > 40


def spoiled_tables(lines: list[bytes]) -> Iterator[bytes]:
    """Change the text of a table in a file."""
    whole = b"".join(lines)
    yield from (whole[:-1], whole + b"\n", b"\n" + whole, b"\xef\xbb\xbf" + whole, whole + lines[-1], b"", lines[0], whole.upper())
    yield from (
        whole.replace(b"\n", b"\r\n"),
        whole.replace(b"\n", b"\r"),
        whole.replace(b"\n", b" \n"),
        whole.replace(b",", b", "),
        whole.rstrip(),
    )
    yield from (whole.replace(b'"weights"', b'"w"'), whole.decode("ascii").encode("utf-16"), whole.replace(b"\n", b"\n\n", 1))
    for i in range(len(lines)):
        yield b"".join(lines[:i] + lines[i + 1 :])
        yield b"".join(lines[: i + 1] + lines[i:])
        yield b"".join(lines[:i] + lines[i:][::-1])
        turned = dict(reversed(json.loads(lines[i]).items()))
        yield b"".join([*lines[:i], json.dumps(turned, separators=(",", ":")).encode() + b"\n", *lines[i + 1 :]])
    for i, byte in enumerate(whole):
        yield whole[:i] + whole[i + 1 :]
        yield whole[:i] + bytes([byte ^ 1]) + whole[i + 1 :]
    for match in re.finditer(rb"[A-Za-z]", whole):
        yield whole[: match.start()] + b"\\u%04x" % ord(match[0]) + whole[match.end() :]


@pytest.mark.parametrize("kind", [small_counts, weighted, by_group, many_columns, true_labels])
def test_spoiled_tables(kind: Callable[..., fa.Result], tmp_path: Path) -> None:
    document, lines = mutable(kind, embed=False)
    assert lines is not None
    raw, whole = as_bytes(document), b"".join(lines)
    sha = document["subject"]["table"]["sha256"].encode()
    path, beside = tmp_path / "c.json", tmp_path / "t.jsonl"
    path.write_bytes(raw)
    beside.write_bytes(whole)
    assert checker.main([str(path), "--table", str(beside)]) == 0
    distinct = set(islice(spoiled_tables(list(lines)), 2500)) - {whole}
    assert len(distinct) > 700
    for i, spoiled in enumerate(sorted(distinct)):
        split = spoiled.splitlines(keepends=True) if b"\r" not in spoiled else [line + b"\n" for line in spoiled.split(b"\n")]
        assert outcome(raw, split) in ("malformed", "false"), spoiled
        if i % 50 == 0:
            beside.write_bytes(spoiled)
            assert checker.main([str(path), "--table", str(beside)]) in (1, 2)
    # The text of the table is canonical, or it is none: its own digest does not help.
    for spoiled in (
        whole[:-1],
        whole.replace(b"\n", b"\r\n"),
        whole + b"\n",
        whole.replace(b",", b", ", 1),
        whole.replace(b'"c', b'"\\u0063', 1),
    ):
        assert spoiled != whole
        path.write_bytes(raw.replace(sha, hashlib.sha256(spoiled).hexdigest().encode()))
        beside.write_bytes(spoiled)
        assert checker.main([str(path), "--table", str(beside)]) == 2


def test_table_of_another_certificate(tmp_path: Path) -> None:
    for one, other in permutations(LONG_TABLE, 2):
        document, lines = mutable(one, embed=False)
        embedded, _ = mutable(one)
        wrong = mutable(other, embed=False)[1]
        assert lines is not None and wrong is not None
        assert outcome(as_bytes(document), list(lines)) == "true"
        assert outcome(as_bytes(document), list(wrong)) == "false"
        assert outcome(as_bytes(embedded), list(wrong)) == "false"
        assert outcome(as_bytes(embedded), list(lines)) == "false"  # the same table with salt is another text


def test_random_changes(tmp_path: Path) -> None:
    """Several changes at once, at random."""
    pick = random.Random(tiers.fresh(20))
    for kind in (small_counts, weighted, by_group):
        document, _ = mutable(kind)
        pool, mutants = strings(document), []
        for _ in range(600):
            changed = json.loads(json.dumps(document))
            for _ in range(pick.choice([2, 2, 3])):
                path, value = pick.choice([(path, value) for path, value in places(changed) if path])
                changed = put(json.dumps(changed), path, pick.choice(other_values(value, pool)))
            mutants.append(as_bytes(changed))
        assert_rejected(document, iter(mutants), None, tmp_path)


def test_unicode_normal_forms_are_different_labels() -> None:
    document, _ = mutable(many_columns)
    assert document["subject"]["table"]["header"]["groups"][1:3] == [["weiblich ♀", "é"], ["weiblich ♀", "e\u0301"]]
    text, changed = json.dumps(document), 0
    for path, value in places(document):
        for form in ("NFC", "NFD", "NFKC", "NFKD"):
            if isinstance(value, str) and unicodedata.normalize(form, value) != value:
                assert outcome(as_bytes(put(text, path, unicodedata.normalize(form, value)))) in ("false", "malformed")
                changed += 1
    assert tiers.enough(changed > 20)


def test_the_judge_of_mutants_is_awake() -> None:
    """`still_true` knows true from false by itself."""
    document, _ = mutable(small_counts)
    claims, targets = document["claims"], document["targets"]
    assert still_true(document, as_bytes(document))
    assert still_true(document, json.dumps(document, indent=3).encode())
    assert still_true(document, as_bytes(document | {"claims": claims[:0:-1]}))
    assert still_true(document, as_bytes(document | {"targets": [], "verdict": "none"}))
    assert not still_true(document, as_bytes(document | {"targets": []}))
    assert not still_true(document, as_bytes(document | {"claims": [*claims, claims[0]]}))
    assert not still_true(document, as_bytes(document | {"targets": [targets[0] | {"limit": "1000"}, *targets[1:]]}))
    assert not still_true(document, as_bytes(document | {"subject": {}}))


# The schema


def test_schema_is_a_schema_of_this_format() -> None:
    Draft202012Validator.check_schema(schema())
    assert schema()["properties"]["format"] == {"const": "fairaudit-certificate/1"}
    assert schema()["$id"] == "fairaudit-certificate/1" and schema()["title"]
    objects = [value for _, value in places(schema()) if isinstance(value, dict) and value.get("type") == "object"]
    assert len(objects) > 20
    for value in objects:
        if "properties" in value:
            assert value["additionalProperties"] is False
            assert set(value.get("required", ())) <= set(value["properties"])
        elif "$ref" not in value:  # maps from column to label or amount, and versions
            refs = [{"$ref": f"#/$defs/{name}"} for name in ("label", "amount", "whole_amount")]
            assert value["additionalProperties"] in ({"type": "string"}, *refs)
    for name, value in schema()["$defs"].items():
        assert "description" in value or name in ("metrics", "population_fits_kind")


LABELLED = {"decisions", "groups", "contexts", "context", "higher", "lower", "decision"}  # "0" is a label there


@pytest.mark.parametrize("kind", [weighted, never_globally])
def test_schema_refuses_what_is_malformed(kind: Callable[..., fa.Result]) -> None:
    document, _ = mutable(kind)
    text = json.dumps(document)
    alike = {tuple("each" if isinstance(key, int) else key for key in path): (path, value) for path, value in places(document)}
    for path, value in alike.values():  # of a list the last: its items have one schema
        if path:
            assert not SCHEMA.is_valid(put(text, path, 1.5)), path
            assert not SCHEMA.is_valid(put(text, path, {"unexpected": [None]})), path
        if isinstance(value, dict):
            labels = path[-1] in ("context", "higher", "lower") if path else False
            assert SCHEMA.is_valid(put(text, path, value | {"extra": "0"}) if path else value | {"extra": "0"}) is labels, path
            for key in value:
                smaller = {k: v for k, v in value.items() if k != key}
                assert not SCHEMA.is_valid(put(text, path, smaller) if path else smaller) or path[-1:] == ("context",), (path, key)
        if isinstance(value, str) and NUMBER.fullmatch(value) and not LABELLED & set(path):
            for wrong in (f"0{value}", f"+{value}", f"{value}/1", "0.5", "-0", "nan", "", "1/0", "1/1", "1/02"):
                assert not SCHEMA.is_valid(put(text, path, wrong)), (path, wrong)
    assert not SCHEMA.is_valid(put(text, ("format",), "fairaudit-certificate/2"))
    assert not SCHEMA.is_valid(put(text, ("subject", "table", "sha256"), "A" * 64))


# The command


def test_command_verifies(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    certificate, apart = tmp_path / "ucb.json", tmp_path / "apart.json"
    assert (
        command(["certify", "--example", "ucb-admissions", "--max-local-ratio", "4/3", "--confidence", "none", "-o", str(certificate)]) == 0
    )
    assert command(["verify", str(certificate)]) == 0
    assert command(["verify", str(certificate), "--require", "within"]) == 0
    assert (
        command(["certify", "--example", "ucb-admissions", "--max-local-ratio", "5/4", "--confidence", "none", "-o", str(certificate)]) == 1
    )
    assert command(["verify", str(certificate)]) == 0
    assert command(["verify", str(certificate), "--require", "within"]) == 1
    assert command(["certify", "--example", "hr-navigation", "--no-table", "-o", str(apart)]) == 0
    capsys.readouterr()
    assert command(["verify", str(apart)]) == 3
    assert "table" in capsys.readouterr().err
    assert command(["verify", str(apart), "--table", str(tmp_path / "apart.table.jsonl")]) == 0
    assert command(["verify", str(apart), "--table", str(certificate)]) == 2
    assert command(["verify", str(tmp_path)]) == 2
    certificate.write_bytes(certificate.read_bytes().replace(b"24475/18432", b"24475/18433"))
    capsys.readouterr()
    assert command(["verify", str(certificate)]) == 1
    assert "FALSE  metrics.local.ratio is 24475/18433 (the table gives 24475/18432)" in capsys.readouterr().out
