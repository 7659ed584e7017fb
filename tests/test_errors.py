"""Messages: what was given is quoted and cut, and what was probably meant is named."""

from __future__ import annotations

import time

import pytest

from fairaudit.errors import Infeasible, InputError, naming, nearest, shown, without_passwords
from fairaudit.tables.sources import source_name


def test_what_is_quoted_is_never_long() -> None:
    assert shown("a\nb") == "'a\\nb'"
    assert len(shown("x" * 1000)) == 60 and shown("x" * 1000).endswith("…")
    assert len(shown("x" * 1000, 12)) == 12


def test_a_number_with_more_digits_than_python_writes_is_described() -> None:
    assert shown(10**5000) == "a number of about 4983 digits"


@pytest.mark.parametrize(("word", "meant"), [("Depth", "'Dept'"), ("answr", "'answer'")])
def test_what_was_probably_meant_is_named(word: str, meant: str) -> None:
    assert nearest(word, ["Dept", "answer"]) == f"known: 'Dept', 'answer'; did you mean {meant}?"


def test_nothing_is_guessed_where_nothing_is_near() -> None:
    assert nearest("zzz", ["Dept"]) == "known: 'Dept'"
    assert nearest("zzz", map(str, range(25))).endswith("… (25 in all)")


def test_bad_input_is_a_value_error() -> None:
    assert issubclass(InputError, ValueError)


@pytest.mark.parametrize(("name", "said"), [("log.csv", "log.csv: no rows"), (None, "no rows")])
def test_messages_begin_with_the_name_of_the_file_where_there_is_one(name: str | None, said: str) -> None:
    with pytest.raises(InputError) as error, naming(name):
        raise InputError("no rows")
    assert str(error.value) == said


def test_no_name_repeats_a_password() -> None:
    assert "secret" not in source_name(["postgresql://me:secret@host/db", "b.csv"]) + source_name("postgresql://me:secret@host/db")


@pytest.mark.parametrize(
    "text",
    [
        "postgresql://me:hush@h/x",
        "Postgresql://me:hush@h/x",
        "postgres:/me:hush@h/x",
        "postgres:me:hush@h/x",
        "postgres:////me:hush@h/x",
        "//me:hush@h/x",
        "postgresql://me:hush/hush@h/x",
        "postgresql://me:hush@hush@h/x",
        "postgresql://me:hush hush@h/x",
        "postgresql://me:it's hush@h/x",
        "postgresql://:hush@h/x",
        "postgresql://h/db?user=me&password=hush",
        "postgresql:/h/db?password=hush&user=me",
        "host=h PASSWORD = 'hush hush' user=me",
        "mysql://h/db?user=me&pass=hush",
        "az://c/x?sv=1&sig=hush",
        "AccountName=me;AccountKey=hush==;x=y",
        "{'password': 'hush'}",
        "https://hush@h/x",
    ],
)
def test_no_message_repeats_a_password(text: str) -> None:
    for said in (str(InputError(f"{text}: there is no such file")), str(Infeasible(text)), shown(text, 300), without_passwords(text)):
        assert "hush" not in said and "…" in said
    assert "hush" not in source_name(text)


@pytest.mark.parametrize("width", range(8, 60))
def test_no_password_is_quoted_in_part(width: int) -> None:
    assert "hush" not in shown("postgresql://somebody:hushhushhushhush@host.example.org/db", width)


@pytest.mark.parametrize(
    "text",
    [
        "there is no column 'token'; known: 'pass', 'secret'",
        "--utility pass=1,fail=0: no such label",
        "https://example.org/a:b@c",
        "log.csv: line 3: a@b.org",
        "postgresql://h/db: no password was given",
        "C:\\logs\\a.csv:3: x",
    ],
)
def test_other_messages_stay_as_they_are(text: str) -> None:
    assert str(InputError(text)) == text


@pytest.mark.parametrize("part", ["/", ":/", "a:", "a:b:", "password", "password ", "token='", "http:", "x=:@"])
def test_a_long_text_is_shown_at_once(part: str) -> None:
    began = time.process_time()
    shown(part * 10**6 + "@", 60)
    InputError(part * 10**4 + "@")
    assert time.process_time() - began < 2
