"""What is declared besides the table: read exactly, of all contexts or of one, and never against the table."""

from __future__ import annotations

import json
from fractions import Fraction
from pathlib import Path
from typing import Any

import pytest

import fairaudit as fa
from fairaudit.cli import main
from fairaudit.errors import InputError

F = Fraction

# Behind a coin of 3/4: in x f gets 29/40 and m 3/8, in y f 19/40 and m 17/40; f has the mean 3/5 and m 2/5.
POLICY = [[["9/10", "1/10"], ["1/5", "4/5"]], [["1/2", "1/2"], ["2/5", "3/5"]]]


def behind(**options: Any) -> fa.Result:
    policy = fa.Policy.from_array(POLICY, decisions=["hire", "pass"], groups=["f", "m"], contexts=["x", "y"])
    coin = fa.RandomizedResponse(["f", "m"], keep_probability="3/4")
    return fa.certify(policy.behind(group=coin, population=[[1, 1], [1, 1]]), {"hire": 1}, **options)


def test_constants_are_exact_and_stand_in_the_certificate() -> None:
    single: Any = {"y": {"m": 0, "tau": 0.4}, "x": {"gamma": "1e0"}}
    found = behind(declared={"tau": "0.1", "global_tau": "2/5"}, declared_in=single, max_drift="5e-2")
    assert found.declared == {"tau": F(1, 10), "global_tau": F(2, 5), "max_drift": F(1, 20)}
    assert list(found.declared_in.items()) == [(("x",), {"gamma": F(1)}), (("y",), {"m": F(0), "tau": F(2, 5)})]
    stated = found.certificate.document["subject"]["declared"]
    assert stated["by_context"] == [{"context": ["x"], "gamma": "1"}, {"context": ["y"], "m": "0", "tau": "2/5"}]
    assert (stated["tau"], stated["global_tau"], stated["max_drift"]) == ("1/10", "2/5", "1/20")


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"declared": {"global_tau": "0.41"}}, "the declared global_tau is '0.41', but the table has only 0.4; declare at most that"),
        (
            {"declared": {"taus": 1}},
            "'taus' cannot be declared; known: 'gamma', 'm', 'tau', 'global_tau', 'lipschitz'; did you mean 'tau'?",
        ),
        ({"declared": {"tau": "x"}}, "the declared tau: 'x' is not a number"),
        ({"declared": {"m": -1}}, "the declared m is -1; it must be at least 0"),
        (
            {"declared_in": {"x": {"tau": "0.38"}}},
            "the declared tau in context 'x' is '0.38', but the table has only 0.375",
        ),
        (
            {"declared_in": {"y": {"gamma": "1/2"}}},
            "the declared gamma in context 'y' is '1/2', but the table has 1",
        ),
        ({"declared_in": {"z": {"tau": 0}}}, "there is no context 'z' for which to declare constants; name one of the table"),
        ({"declared_in": {"x": {}}}, "nothing is declared in context 'x'; declare gamma, m or tau"),
        ({"declared_in": {"x": {"lipschitz": 0}}}, "'lipschitz' cannot be declared in context 'x'; known: 'gamma', 'm', 'tau'"),
        ({"max_drift": 2}, "max_drift is 2; a total variation distance from 0 to 1 is accepted"),
        ({"max_drift": "half"}, "max_drift: 'half' is not a number"),
    ],
)
def test_what_is_refused(options: dict[str, Any], message: str) -> None:
    with pytest.raises(InputError) as error:
        behind(**options)
    assert str(error.value).startswith(message)


@pytest.mark.parametrize("options", [{"declared": {"tau": 0}}, {"declared": {"global_tau": 0}}, {"declared_in": {"x": {"tau": 0}}}])
def test_a_plain_table_has_no_policies_to_speak_of(options: dict[str, Any]) -> None:
    law = fa.Law.from_array(POLICY, decisions=["hire", "pass"], contexts=["x", "y"])
    with pytest.raises(InputError, match="declared for a policy behind filters"):
        fa.certify(law, {"hire": 1}, **options)


def test_a_floor_of_means_needs_means() -> None:
    policy = fa.Policy.from_array(POLICY, decisions=["hire", "pass"], groups=["f", "m"], contexts=["x", "y"])
    alone = policy.behind(group=fa.Identity(["f", "m"]), population=[[1, 0], [1, 0]])
    with pytest.raises(InputError, match="no two groups have a population"):
        fa.certify(alone, {"hire": 1}, declared={"global_tau": 0})


def test_a_drift_is_about_one_release() -> None:
    policy = fa.Policy.from_array(POLICY[0], decisions=["hire", "pass"], groups=["f", "m"])
    often = policy.behind(group=fa.RandomizedResponse(["f", "m"], keep_probability="3/4"), releases=3)
    with pytest.raises(InputError, match="here one memory sees 3"):
        fa.certify(often, {"hire": 1}, max_drift="1/10")


TABLE = "u,g,x,p\nhire,f,x,0.9\npass,f,x,0.1\nhire,m,x,0.2\npass,m,x,0.8\nhire,f,y,0.5\npass,f,y,0.5\nhire,m,y,0.4\npass,m,y,0.6\n"
AUDIT = """
[policy]
table = "policy.csv"
decision = "u"
group = "g"
context = "x"
probability = "p"
{policy}
[filter.group]
kind = "randomized-response"
keep_probability = "0.75"

[utility]
values = {{ hire = 1 }}
{utility}
"""


def audit_file(folder: Path, policy: str = "", utility: str = "") -> str:
    (folder / "policy.csv").write_text(TABLE)
    (folder / "audit.toml").write_text(AUDIT.format(policy=policy, utility=utility))
    return str(folder / "audit.toml")


def test_an_audit_file_declares_the_same(tmp_path: Path) -> None:
    utility = 'tau = 0.1\nglobal_tau = "2/5"\n[[utility.by_context]]\ncontext = "y"\ntau = "0.4"\nm = 0\n'
    path = audit_file(tmp_path, "max_drift = 0.05", utility)
    found = fa.audit(path)
    same = behind(declared={"tau": "0.1", "global_tau": "2/5"}, declared_in={"y": {"tau": "0.4", "m": 0}}, max_drift="0.05")
    assert (found.declared, found.declared_in) == (same.declared, same.declared_in)
    assert main(["certify", path, "-o", str(tmp_path / "file.json")]) == 0
    assert json.loads((tmp_path / "file.json").read_text())["subject"]["declared"] == found.certificate.document["subject"]["declared"]
    assert fa.audit(path, max_drift="1/2").declared["max_drift"] == F(1, 2)  # what is asked for comes before what the file says


@pytest.mark.parametrize(
    ("utility", "message"),
    [
        ("by_context = 3", "sections [[utility.by_context]]"),
        ("[[utility.by_context]]\ntau = 1", "needs context"),
        ("[[utility.by_context]]\ncontext = 7\ntau = 1", 'context must be a label in quotes, such as "7", or a list of them, not 7'),
        ('[[utility.by_context]]\ncontext = "y"\ntaus = 1', "unknown key 'taus'"),
        ('[[utility.by_context]]\ncontext = "y"\ntau = 0\n[[utility.by_context]]\ncontext = ["y"]\ntau = 0', "has the context 'y' twice"),
        ('[[utility.by_context]]\ncontext = "z"\ntau = 0', "no context 'z'"),
    ],
)
def test_an_audit_file_is_refused_in_one_sentence(tmp_path: Path, capsys: pytest.CaptureFixture[str], utility: str, message: str) -> None:
    assert main(["certify", audit_file(tmp_path, utility=utility)]) == 2
    said = capsys.readouterr().err
    assert message in said and said.count("\n") == 1 and "audit.toml" in said


def test_all_bounds_need_filters(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (tmp_path / "policy.csv").write_text(TABLE)
    words = ["--decision", "u", "--group", "g", "--context", "x", "--probability", "p", "--utility", "hire"]
    assert main(["certify", str(tmp_path / "policy.csv"), *words, "--all-bounds"]) == 2
    assert "--all-bounds is about a policy behind filters" in capsys.readouterr().err


def test_what_a_message_says_may_be_declared_is_accepted() -> None:
    policy = fa.Policy.from_array([[["2/3", "1/3"], ["1", "0"]]], decisions=["hire", "pass"], groups=["f", "m"])
    deployment = policy.behind(group=fa.Identity(["f", "m"]))
    with pytest.raises(fa.InputError, match=r"the table has only 0\.6666; declare at most that"):
        fa.certify(deployment, {"hire": 1}, declared={"tau": "0.67"})
    assert fa.certify(deployment, {"hire": 1}, declared={"tau": "0.6666"}).declared == {"tau": F(3333, 5000)}
    with pytest.raises(fa.InputError, match=r"the table has 0\.6667; declare at least that"):
        fa.certify(deployment, {"hire": "2/3"}, declared={"gamma": "0.5"})
    assert fa.certify(deployment, {"hire": "2/3"}, declared={"gamma": "0.6667"}).declared == {"gamma": F(6667, 10000)}
