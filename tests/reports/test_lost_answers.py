"""What reports say of an evaluation log: the answers that decide nothing, by group, in words."""

from __future__ import annotations

import json
from typing import Any

import pytest
from evaluation_changes import audited, log_of

import fairaudit as fa
from fairaudit.reports.lost_answers import lost_answers, lost_text
from fairaudit.reports.overview import of_result
from fairaudit.reports.screen import first_screen

ROWS = [("A", "a", "age", 6), ("B", "a", "home", 4), ("refused", "a", "age", 3), ("truncated", "a", "age", 2), ("error", "a", "home", 1)]
OTHERS = [("A", "b", "age", 9), ("B", "b", "home", 9), ("unreadable", "b", "home", 1), ("error", "c", "home", 2)]
SAID = (
    "Lost answers: 9 of 37 decide nothing: 3 were refused, 1 could not be understood, 2 were cut off, 3 ended in an error and were "
    "left out. "
    "By group: c 2 of 2 (100 %), a 6 of 16 (37.5 %), b 1 of 19 (5.26 %). Missing: 3 of 40 samples are not in the log."
)


def result(**options: Any) -> fa.Result:
    said: dict[str, Any] = {"errors": "drop", "expected": 40, "where": (("filter", "first"),), "read": 37}
    return audited(log_of([*ROWS, *OTHERS], **{**said, **options}), confidence=None)


def test_the_first_screen_names_lost_answers() -> None:
    words = " ".join(first_screen(of_result(result()), "run.eval", "fairaudit verify c.json").split())
    assert SAID in words and words.index("Lost answers") < words.index("topic=")
    assert "As read: an evaluation log (inspect) with 37 of 40 samples: questions were drawn; epochs of a question count once" in words
    assert "epochs of a question count once, so that an interval is about other questions like these" in words


def test_a_log_in_which_every_answer_decides_has_no_caution() -> None:
    found = audited(log_of([("A", "a", "age", 6), ("B", "b", "age", 3)]), confidence=None)
    assert of_result(found).cautions == of_result(audited(log_of([("A", "a", "age", 6), ("B", "b", "age", 3)]), confidence=None)).cautions
    said = json.loads(found.certificate.text)["subject"]["evaluation"]
    lost = lost_answers(said, found.law)
    assert lost is not None and (lost.caution, lost.groups) == ("", ())


@pytest.mark.parametrize("ending", ["html", "md", "txt"])
def test_reports_say_what_was_read_and_lost_by_group(ending: str, tmp_path: Any) -> None:
    path = tmp_path / f"report.{ending}"
    if ending == "txt":
        text = lost_text(json.loads(result().certificate.text)["subject"]["evaluation"], result().law)
    else:
        result().report(path)
        text = path.read_text()
    text = text.replace("<bdi>", "").replace("</bdi>", "")
    assert SAID in text
    assert "only the 37 samples count in which filter is" in text
    assert "epochs of a question count once" in text
    if ending == "html":
        cells = ["16", "3", "0", "2", "1", "6 (37.5 %)"]
        row = text.partition('id="lost"')[2].partition(">a</th>")[2].partition("</tr>")[0]
        assert [cell.partition("<")[0] for cell in row.split('">')[1:]] == cells
    if ending == "md":
        assert "| <code>a</code> | 16 | 3 | 0 | 2 | 1 | 6 (37.5 %) |" in text


def test_a_loss_that_contexts_have_in_opposite_directions_is_named() -> None:
    """Each group lost 4 of 12; within one context it is 4 of 6 of one and none of the other."""
    rows = [("refused", "a", "age", 4), ("A", "a", "age", 2), ("A", "a", "home", 6), ("B", "b", "age", 6), ("error", "b", "home", 4)]
    found = audited(log_of([*rows, ("B", "b", "home", 2)], errors="drop"), confidence=None)
    lost = lost_answers(json.loads(found.certificate.text)["subject"]["evaluation"], found.law)
    assert lost is not None and "By group: a 4 of 12 (33.3 %), b 4 of 12 (33.3 %)." in lost.caution
    assert "Most unequal within topic=age: a 4 of 6 (66.7 %), b 0 of 6 (0 %)." in lost.caution
    assert [(one.context, one.label, one.lost, one.asked) for one in lost.cells] == [
        ("topic=age", "a", 4, 6),
        ("topic=age", "b", 0, 6),
        ("topic=home", "b", 4, 6),
        ("topic=home", "a", 0, 6),
    ]
    assert " ".join(first_screen(of_result(found), "run.eval", "").split()).count("Most unequal within topic=age: a 4 of 6") == 1


def test_errors_that_were_left_out_are_told_from_those_that_were_kept(tmp_path: Any) -> None:
    for errors, head, said in (
        ("drop", "Error, left out", "were left out"),
        ("bound", "Error, kept", "are kept as decisions of their own"),
    ):
        found = result(errors=errors)
        found.report(tmp_path / "report.html")
        page = (tmp_path / "report.html").read_text().partition('id="lost"')[2].partition("</table>")[0]
        assert f">{head}<" in page and ">topic<" in page and "topic=home" in page
        assert f"3 ended in an error and {said}." in of_result(found).cautions[0]


def test_of_many_contexts_the_most_unequal_are_listed() -> None:
    """In context i, i of 20 answers of one group are lost, and none of the other."""
    rows = [(*row, f"c{i:02}") for i in range(1, 15) for row in (("refused", "a"), ("A", "a"), ("A", "b"))]
    counts = [n for i in range(1, 15) for n in (i, 20 - i, 20)]
    found = audited(log_of([(*row, n) for row, n in zip(rows, counts, strict=True)]), confidence=None)
    said = json.loads(found.certificate.text)["subject"]["evaluation"]
    lost = lost_answers(said, found.law)
    assert lost is not None and (lost.more, len(lost.cells), lost.cells[0].context) == (4, 20, "topic=c14")
    assert "and 4 more contexts, none of them more unequal" in lost_text(said, found.law)


def test_a_certificate_without_its_table_says_what_it_has() -> None:
    said = json.loads(result().certificate.text)["subject"]["evaluation"]
    without = lost_answers(said, None)
    assert without is not None and "By group: a 6, c 2, b 1." in without.caution
    undisclosed = lost_answers({**said, "cells": None}, None)
    assert undisclosed is not None and undisclosed.groups == () and "By group" not in undisclosed.caution


def test_labels_do_no_harm() -> None:
    rows = [("A", "<b>\x1b[31m", "age", 6), ("refused", "<b>\x1b[31m", "age", 3), ("B", "\u202eb", "age", 3)]
    said = {"format": "ev\x07il\n", "extract": "(<script>)\x1b", "options": ("A", "\x1b[31m")}
    found = audited(log_of(rows, **said), confidence=None)
    shown = first_screen(of_result(found), "run.eval", "fairaudit verify c.json") + lost_text(
        json.loads(found.certificate.text)["subject"]["evaluation"], found.law
    )
    assert not any(c in shown for c in "\x1b\x07\u202e")
