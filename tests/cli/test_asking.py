"""`certify TABLE` alone: questions on a terminal, a command to try elsewhere; both give the certificate of that command."""

from __future__ import annotations

import os
import re
import shlex
import signal
import subprocess
import sys
from pathlib import Path

import pytest

from fairaudit.cli import main

TABLE = "Dept,Gender,Admit,Freq\n" + "".join(
    f"{x},{a},{u},{n}\n"
    for x, a, u, n in (
        ("A", "f", "yes", 89), ("A", "f", "no", 19), ("A", "m", "yes", 512), ("A", "m", "no", 313),
        ("B", "f", "yes", 17), ("B", "f", "no", 8), ("B", "m", "yes", 353), ("B", "m", "no", 207),
    )
)  # fmt: skip


END, INTERRUPT = "\x04", "\x03"


def on_terminal(words: list[str], answers: list[str]) -> tuple[str, int]:
    """Run the command on a terminal, and give its answers as soon as it asks."""
    master, terminal = pytest.importorskip("pty").openpty()
    child = subprocess.Popen([sys.executable, "-m", "fairaudit", *words], stdin=terminal, stdout=terminal, stderr=terminal)
    os.close(terminal)
    said, left = b"", list(answers)
    while True:
        try:
            part = os.read(master, 1 << 16)
        except OSError:
            break
        if not part:
            break
        said += part
        if said.rstrip(b" ").endswith(b"]"):
            answer = left.pop(0) if left else END
            if answer == INTERRUPT:
                child.send_signal(signal.SIGINT)  # as the terminal of a session does at Ctrl-C
            else:
                os.write(master, answer.encode() + b"\n")
    os.close(master)
    return said.decode().replace("\r", ""), child.wait(60)


@pytest.fixture
def table(tmp_path: Path) -> Path:
    path = tmp_path / "admissions.csv"
    path.write_text(TABLE)
    return path


def command_in(said: str) -> list[str]:
    return shlex.split(next(line for line in said.splitlines() if line.strip().startswith("fairaudit certify")))[1:]


def test_enter_takes_what_was_guessed(table: Path, tmp_path: Path) -> None:
    said, code = on_terminal(["certify", str(table), "-o", str(tmp_path / "asked.json")], [""] * 5)
    assert code == 0, said
    command = command_in(said)
    assert command[2:] == ["--decision", "Admit", "--group", "Gender", "--context", "Dept", "--count", "Freq", "--utility", "yes"]
    assert main([*command, "-o", str(tmp_path / "named.json")]) == 0
    assert (tmp_path / "asked.json").read_bytes() == (tmp_path / "named.json").read_bytes()


def test_answers_are_corrected_and_asked_again(table: Path, tmp_path: Path) -> None:
    answers = ["Admitt", "Admit,Dept", "Admit", "maybe", "no", "bad", "harm", "Sex", "-", "Gender,Gender", "Gender", '"', "-"]
    said, code = on_terminal(["certify", str(table), "-o", str(tmp_path / "asked.json")], answers)
    assert code == 0, said
    for expected in (
        "did you mean 'Admit'?",
        "One column is needed",
        "'maybe' is none of them",
        "known: 'good', 'harm'",
        "no column 'Sex'",
    ):
        assert expected in said
    command = command_in(said)
    assert command[2:] == ["--decision", "Admit", "--group", "Gender", "--count", "Freq", "--utility", "no", "--burden"]
    assert main([*command, "-o", str(tmp_path / "named.json")]) == 0
    assert (tmp_path / "asked.json").read_bytes() == (tmp_path / "named.json").read_bytes()


def test_where_nobody_can_be_asked_a_command_is_proposed(table: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["certify", str(table)]) == 2
    out, err = capsys.readouterr()
    assert out == ""
    assert err.startswith("fairaudit: no column was named")
    command = shlex.split(err.partition("to try: ")[2])[1:]
    assert main(command) == 0


def test_numbers_answer_and_questions_are_gone_back_to(table: Path, tmp_path: Path) -> None:
    """Dept is taken back for Admit, by its number; labels have numbers, too."""
    said, code = on_terminal(
        ["certify", str(table), "-o", str(tmp_path / "asked.json")], ["1", "<", "3", "1", "good", "<", "HARM", "2", "1"]
    )
    assert code == 0, said
    assert said.count("1. Which column") == 2 and said.count("3. Is") == 2
    command = command_in(said)
    assert command[2:] == [
        "--decision",
        "Admit",
        "--group",
        "Gender",
        "--context",
        "Dept",
        "--count",
        "Freq",
        "--utility",
        "no",
        "--burden",
    ]
    assert main([*command, "-o", str(tmp_path / "named.json")]) == 0
    assert (tmp_path / "asked.json").read_bytes() == (tmp_path / "named.json").read_bytes()


def test_answers_that_cannot_be_are_a_sentence(tmp_path: Path) -> None:
    path = tmp_path / "log.csv"
    rows = [f"{i % 61 + 18},{i * 7},{i % 3 - 1},{'yes' if i % 3 else 'no'},x{i}" for i in range(300)]
    path.write_text("age,points,change,hired,name\n" + "\n".join(rows) + "\n")
    answers = ["name", "change", "9", "hired", "yes", "good", "hired", "age", "45,25", "x", "30,50", "-"]
    said, code = on_terminal(["certify", str(path)], answers)
    assert code == 0, said
    for expected in (
        "It has 300 different labels, which are no decisions",
        "It has negative numbers",
        "There is no column '9'",
        "hired is something else already",
        "Numbers that grow, separated by commas",
    ):
        assert expected in said
    assert command_in(said)[2:] == ["--decision", "hired", "--group", "age:30,50", "--utility", "yes"]


def test_numbers_are_compared_as_they_stand(tmp_path: Path) -> None:
    path = tmp_path / "wages.csv"
    path.write_text("sex,wage\n" + "".join(f"{'fm'[i % 2]},{10 + i % 37}\n" for i in range(200)))
    said, code = on_terminal(["certify", str(path)], [""] * 4)
    assert code == 0, said
    assert "2. Is more of wage good for the person, or a harm?" in said
    assert command_in(said)[2:] == ["--utility-column", "wage", "--group", "sex"]


WIDE = "dept,men_in,men_out,women_in,women_out\nA,512,313,89,19\nB,353,207,17,8\nTotal,865,520,106,27\n"


def test_columns_of_counts_are_asked_about_and_may_be_something_else(tmp_path: Path) -> None:
    path = tmp_path / "wide.csv"
    path.write_text("Admissions 1973\n\n" + WIDE.replace("in,", "hired,").replace("out", "rejected"))
    said, code = on_terminal(["certify", str(path), "-o", str(tmp_path / "asked.json")], [""] * 4)
    assert code == 0, said
    assert "the first 2 lines look like a title ('Admissions 1973') and are skipped" in said
    assert "is the total of others ('Total')" in said
    command = command_in(said)
    assert command[2:4] == ["--skip", "2"] and command[4] == "--wide"
    assert main([*command, "-o", str(tmp_path / "named.json")]) == 0
    assert (tmp_path / "asked.json").read_bytes() == (tmp_path / "named.json").read_bytes()
    said, code = on_terminal(["certify", str(path)], ["no", END])
    assert code == 130 and "2. Which column says what was decided" in said


def test_choices_among_candidates_are_asked_about(tmp_path: Path) -> None:
    path = tmp_path / "runs.csv"
    orders = ("ann bob cem", "bob cem ann", "cem ann bob")
    path.write_text("model,shown,winner\n" + "".join(f"m{i % 2},{orders[i % 3]},{('ann', 'bob')[i % 2]}\n" for i in range(60)))
    said, code = on_terminal(["certify", str(path), "-o", str(tmp_path / "asked.json")], [""] * 3)
    assert code == 0, said
    command = command_in(said)
    assert command[2:] == ["--slots", "shown", "--winner", "winner", "--context", "model"]
    assert main([*command, "-o", str(tmp_path / "named.json")]) == 0
    assert (tmp_path / "asked.json").read_bytes() == (tmp_path / "named.json").read_bytes()


def test_an_interrupt_leaves_without_a_word_too_many(table: Path, tmp_path: Path) -> None:
    said, code = on_terminal(["certify", str(table), "-o", str(tmp_path / "asked.json")], ["Admit", INTERRUPT])
    assert code == 130, said
    assert "Traceback" not in said
    assert not (tmp_path / "asked.json").exists()


def test_labels_with_commas_and_names_with_dashes(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = tmp_path / "odd.csv"
    path.write_text('-decision,"sex, given",n\n"yes, at once",f,3\nno,f,4\n"yes, at once",m,5\nno,m,1\n')
    said, code = on_terminal(["certify", str(path)], [""] * 5)
    assert code == 0, said
    assert main(command_in(said)) == 0
    capsys.readouterr()


def test_a_file_that_cannot_be_read_is_one_sentence(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    for name, content in (("gone.csv", None), ("empty.csv", ""), ("odd.xlsx", "PK\x03\x04")):
        path = tmp_path / name
        if content is not None:
            path.write_text(content)
        assert main(["certify", str(path)]) == 2
        out, err = capsys.readouterr()
        assert out == ""
        assert err.count("\n") == 1
        assert name in err


def test_the_end_of_the_input_interrupts(table: Path) -> None:
    said, code = on_terminal(["certify", str(table)], ["\x04"])
    assert code == 130, said


def test_what_may_be_a_row_of_totals_is_remarked_beside_the_questions(tmp_path: Path) -> None:
    path = tmp_path / "jobs.csv"
    path.write_text("sex,hired\n" + "f,yes\nf,no\nm,yes\nm,no\n" * 5 + "Total,10\n")
    said, _ = on_terminal(["certify", str(path)], [INTERRUPT])
    assert "! 'Total' may be a row of totals, which would count everybody twice" in said.split("1. ")[0]


def test_of_a_log_of_an_evaluation_a_few_paths_are_shown(tmp_path: Path) -> None:
    """The proposed ones among them; others may be named, and errors and conditions go into the command."""
    log = Path(__file__).parents[1] / "tables" / "evaluations" / "logs" / "promptfoo" / "loans.json"
    answers = ["", "", "", "metadata.race", "testCase.vars.person"]
    said, code = on_terminal(["certify", str(log), "-o", str(tmp_path / "asked.json")], answers)
    assert code == 0, said
    shown = said.partition("Answer with")[0]
    assert "metadata.race" in shown and "response.output" in shown
    assert "tokenUsage.total" not in shown and "more paths, which may be named, too" in shown
    command = command_in(said)
    assert command[command.index("--context") + 1] == "testCase.vars.person"
    assert command[-4:] == ["--where", "promptIdx=0", "--errors", "bound"]
    assert main([*command, "-o", str(tmp_path / "named.json")]) == 0
    assert (tmp_path / "asked.json").read_bytes() == (tmp_path / "named.json").read_bytes()


@pytest.mark.parametrize(
    ("answer", "words"),
    [("", ["--utility", "granted", "--undecided", "pending"]), ("refused", ["--utility", "granted,pending=0"])],
)
def test_a_label_that_looks_undecided_is_asked_about(answer: str, words: list[str], tmp_path: Path) -> None:
    path = tmp_path / "pend.csv"
    path.write_text("grp,dec,n\nA,pending,100\nA,granted,300\nA,refused,100\nB,pending,200\nB,granted,250\nB,refused,50\n")
    said, code = on_terminal(["certify", str(path)], ["", "", "", answer, "", ""])
    assert code == 0, said
    assert "Does 'pending' mean refused, or is it undecided? [undecided]" in said
    command = command_in(said)
    assert command[2:] == ["--decision", "dec", "--group", "grp", "--count", "n", *words]
    assert "looks undecided" not in said and main(command) == 0


@pytest.mark.parametrize("table", ["sex,hired\n" + "f,parked\nm,on ice\n" * 40, "sex,granted,total\nf,12,30\nm,15,40\n"])
def test_where_all_labels_look_undecided_none_is_proposed(table: str, tmp_path: Path) -> None:
    path, lexicon = tmp_path / "all.csv", tmp_path / "lexicon.txt"
    path.write_text(table)
    lexicon.write_text("parked\non ice\ngranted\n")
    said, code = on_terminal(["certify", str(path), "--lexicon", str(lexicon)], ["", "", "", INTERRUPT])
    assert re.findall(r"is counted: [^?]*\? \[(.*)\]", said) == [""] * said.count("is counted") != [], said
    assert code not in (0, 1)
