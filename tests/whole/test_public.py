"""What `import fairaudit` offers: every name is there, is called, is documented, and what it returns can be kept and shown."""

from __future__ import annotations

import ast
import importlib
import inspect
import os
import pickle
import pkgutil
import re
import subprocess
import sys
import types
import typing
from collections.abc import Callable
from fractions import Fraction
from pathlib import Path
from typing import Any

import pytest

import fairaudit as fa
from fairaudit.attestations.making import stated_of, statement_of
from fairaudit.attestations.sources import take

TABLE = {"hired": ["yes", "no", "yes", "no"], "sex": ["f", "f", "m", "m"], "n": [300, 100, 200, 200]}
ASKED: dict[str, Any] = {"decision": "hired", "group": "sex", "count": "n", "utility": "yes"}
LOG = "hired,sex\n" + "yes,f\nyes,m\nno,m\n" * 200
FILTER = "true,f,m\nf,0.75,0.25\nm,0.25,0.75\n"
DOCUMENTS = {
    "Certificate.document",
    "Claim.evidence",
    "Interval.evidence",
    "Law.preparation",
    "Result.not_compared",
}  # JSON, which has no one type
WITHIN = {"Tally.levels", "Tally.of.cells", "WorstCase.proof", "WorstCase.setting"}  # nobody but readers and searches makes one
OPTIONAL = {"UtilityClass.tau", "UtilityClass.lipschitz"}  # rationals wherever they are read, None only where that is asked first


def policy() -> fa.Policy:
    return fa.Policy.from_array([[["0.9", "0.1"], ["0.2", "0.8"]]], decisions=["hire", "pass"], groups=["f", "m"])


def coin() -> fa.Mechanism:
    return fa.RandomizedResponse(["f", "m"], keep_probability="0.75")


def law() -> fa.Law:
    return fa.Law.from_counts(TABLE, decision="hired", group="sex", count="n")


def draws() -> fa.Comparison:
    return fa.audit(TABLE, **ASKED).comparisons["local"]


def calls(folder: Path) -> dict[str, Callable[[], Any]]:
    """A true call of each public function, and one that makes an object of each public class."""
    (folder / "log.csv").write_text(LOG)
    (folder / "filter.csv").write_text(FILTER)
    made = fa.audit(TABLE, **ASKED, max_local_ratio="5/4")
    behind = policy().behind(group=coin())

    def watched() -> fa.Monitor:
        return fa.monitor(folder / "log.csv", decision="hired", group="sex", utility="yes", max_local_ratio="5/4")

    def look() -> fa.Look:
        with watched() as found:
            return found.catch_up()

    def closed() -> fa.Monitor:
        with watched() as found:
            return found

    def recounted() -> fa.Recount:
        options = {"decision": "hired", "group": ["sex"], "utility": {"yes": "1"}, "count": "n"}
        said = statement_of(made, ["c.json"], take(TABLE), options=options, command=["certify"], stated=stated_of({}))
        return fa.recount(made, said.text.encode(), TABLE)

    def subgroups() -> fa.Subgroups:
        return fa.subgroups(TABLE, decision="hired", attributes="sex", count="n", utility="yes")

    def worst() -> fa.WorstCase:
        return fa.worst_case(law(), fa.UtilityClass(tau="1/4"))

    return {
        "Allocation": lambda: fa.read_allocation({"shown": ["ann bob", "bob ann"], "won": ["ann", "bob"]}, slots="shown", winner="won"),
        "ApproxDP": lambda: fa.ApproxDP(Fraction(2), Fraction(1, 4), None),
        "Ball": lambda: fa.Ball({"yes": 1, "no": "1/2"}, "0.1"),
        "Bins": lambda: fa.Bins.of("age", [18, 65]),
        "Bound": lambda: fa.certify(behind, {"hire": 1}).bounds[0],
        "Calibration": lambda: fa.calibrate(max_ratio="5/4", groups=2, tau="0.5"),
        "Certificate": lambda: made.certificate,
        "CertificateComparison": lambda: fa.compare(made, made.certificate),
        "Claim": lambda: made.claims[0],
        "Columns": lambda: made.columns,
        "Comparison": draws,
        "Composition": lambda: fa.compose(coin(), 2),
        "Constant": lambda: fa.Constant(["f", "m"]),
        "CsvTable": lambda: fa.read_csv(folder / "log.csv"),
        "Deployment": lambda: behind,
        "Design": lambda: fa.design(policy(), {"hire": 1}, max_ratio=2),
        "Distance": lambda: made.demographic_parity,
        "EpsilonRefutation": lambda: fa.refute_epsilon(draws(), 2),
        "Example": lambda: fa.example("hr-navigation"),
        "FairauditError": lambda: fa.FairauditError("x"),
        "FalseCertificate": lambda: fa.FalseCertificate("x"),
        "Family": lambda: fa.Family({"speed": {"yes": 1, "no": 0}}),
        "Finding": lambda: fa.verify(made).findings[0],
        "Frontier": lambda: fa.frontier(max_ratio=["1.2", "1.4"], groups=2, tau="0.5"),
        "Identity": lambda: fa.Identity(["f", "m"]),
        "Infeasible": lambda: fa.Infeasible("x"),
        "InputError": lambda: fa.InputError("x"),
        "Interval": lambda: made.intervals["local"],
        "Law": law,
        "LinearRow": lambda: fa.LinearRow({"no": 1, "yes": "-1/2"}, 0),
        "Look": look,
        "ManyRowsError": lambda: fa.ManyRowsError("x"),
        "RowsLost": lambda: fa.RowsLost("x"),
        "Mechanism": coin,
        "Monitor": closed,
        "NoiseFloor": lambda: fa.noise_floor(draws(), draws()),
        "Planning": lambda: fa.plan(["0.5", "0.5"], max_ratio="5/4"),
        "Policy": policy,
        "Product": lambda: fa.Product({"sex": coin(), "age": fa.Identity(["old", "young"])}),
        "Profile": lambda: fa.trade_off(coin()).profile(),
        "PureDP": lambda: fa.pure_dp(coin()),
        "RandomizedResponse": coin,
        "Ratio": lambda: made.local,
        "Recount": recounted,
        "ReleaseStore": lambda: fa.ReleaseStore(folder / "releases.db"),
        "Result": lambda: made,
        "TableNeeded": lambda: fa.TableNeeded("x"),
        "Tally": lambda: fa.read_log(folder / "log.csv", ["hired", "sex"]),
        "Target": lambda: made.targets[0],
        "TradeOff": lambda: fa.trade_off(coin()),
        "Utility": lambda: fa.Utility({"yes": 1, "no": "0.5"}),
        "UtilityClass": lambda: fa.UtilityClass(tau="0.3", order=["no", "yes"], rows=[({"yes": 1}, 1)]),
        "UtilityTable": lambda: made.utility,
        "Subgroup": lambda: subgroups().found[0],
        "Subgroups": subgroups,
        "Verification": lambda: fa.verify(made),
        "Witness": lambda: made.local.witness if made.local else None,
        "WorstCase": worst,
        "audit": lambda: fa.audit(folder / "log.csv", decision="hired", group="sex", utility="yes"),
        "calibrate": lambda: fa.calibrate(max_log="0.2", groups=2, tau="0.5"),
        "calibrate_policy": lambda: fa.calibrate_policy(policy(), {"hire": 1}, max_ratio=2),
        "calibrate_utility": lambda: fa.calibrate_utility(policy(), {"hire": 1}, max_ratio=2),
        "certify": lambda: fa.certify(law(), {"yes": 1}),
        "certify_worst_case": lambda: fa.certify_worst_case(worst()),
        "compare": lambda: fa.compare(made, fa.audit({**TABLE, "n": [300, 100, 200, 300]}, **ASKED, max_local_ratio="5/4")),
        "compose": lambda: fa.compose(coin(), 3),
        "delta": lambda: fa.delta(coin(), 2),
        "design": lambda: fa.design(policy(), {"hire": 1}, max_ratio=2),
        "design_model_free": lambda: fa.design_model_free(2, max_ratio="1.4", tau="0.5"),
        "design_utility": lambda: fa.design_utility(policy(), {"hire": 1}, max_ratio=2),
        "example": lambda: fa.example("ucb-admissions"),
        "frontier": lambda: fa.frontier(max_ratio=[2], policy=policy(), utility={"hire": 1}),
        "merge_labels": lambda: fa.merge_labels({"sex": ["f", "F "], "hired": ["yes", "no"]}, "sex", fold=True),
        "monitor": closed,
        "noise_floor": lambda: fa.noise_floor(draws(), draws()),
        "plan": lambda: fa.plan([["0.5", "0.45"], ["0.2", "0.2"]], max_ratio=2),
        "policy_source": lambda: fa.policy_source("stand-in"),
        "pure_dp": lambda: fa.pure_dp(coin()),
        "read_allocation": lambda: fa.read_allocation(
            {"shown": ["ann bob", "bob ann"], "won": ["ann", "ann"]}, slots="shown", winner="won"
        ),
        "read_csv": lambda: fa.read_csv(folder / "log.csv"),
        "read_log": lambda: fa.read_log(folder / "log.csv", ["sex"]),
        "read_mechanism": lambda: fa.read_mechanism(folder / "filter.csv"),
        "recount": recounted,
        "refute_epsilon": lambda: fa.refute_epsilon(draws(), "1.01"),
        "report": lambda: fa.report(made, folder / "report.md", format="markdown"),
        "sample_policy": lambda: fa.sample_policy(lambda x, a: "go" if a == "f" else "stay", [("lobby", "f"), ("lobby", "m")], trials=5),
        "subgroups": subgroups,
        "tally": lambda: fa.tally(folder / "log.csv", folder / "log.parquet", ["hired", "sex"]),
        "trade_off": lambda: fa.trade_off(coin()),
        "verify": lambda: fa.verify(made.certificate, require="within"),
        "worst_case": worst,
    }


PUBLIC = sorted(name for name in fa.__all__ if name not in ("__version__", "Number"))
CLASSES = [name for name in PUBLIC if inspect.isclass(getattr(fa, name))]


def main(folder: Path) -> None:
    """Import every module, as a program that uses all of them might; then call every public name."""
    for module in pkgutil.walk_packages(fa.__path__, "fairaudit."):
        if not module.name.endswith("__main__"):
            importlib.import_module(module.name)
    for name in fa.__all__:
        assert not isinstance(getattr(fa, name), types.ModuleType), name
    for name, call in calls(folder).items():
        assert call() is not None, name
        print(name)


def test_every_name_is_called_after_every_module_was_imported(tmp_path: Path) -> None:
    env = {**os.environ, "PYTHONPATH": str(Path(fa.__file__).parents[1])}
    found = subprocess.run([sys.executable, __file__, str(tmp_path)], capture_output=True, text=True, check=False, env=env)
    assert (found.returncode, found.stderr) == (0, "")
    assert sorted(found.stdout.split()) == PUBLIC


def test_no_module_directly_under_the_package_bears_a_public_name() -> None:
    assert not {module.name for module in pkgutil.iter_modules(fa.__path__)} & {*fa.__all__}


def test_type_checkers_and_python_see_the_same_names() -> None:
    tree = ast.parse(Path(fa.__file__).read_text("utf-8"))
    (block,) = [node for node in tree.body if isinstance(node, ast.If)]
    seen = {(node.module, alias.name) for node in block.body if isinstance(node, ast.ImportFrom) for alias in node.names}
    assert seen == {(home, name) for name, home in fa._HOME.items()}


@pytest.mark.parametrize("name", PUBLIC)
def test_every_name_is_documented_with_an_example_that_runs(name: str) -> None:
    thing = getattr(fa, name)
    text = inspect.getdoc(thing) or ""
    assert text.split("\n")[0].strip().endswith((".", ":"))
    if name != "Finding":  # the checker's, which imports nothing
        assert "Examples\n--------\n>>> " in text
    if inspect.isfunction(thing):
        assert "Parameters\n----------\n" in text
        assert "Returns\n-------\n" in text
    for key, value in vars(thing).items() if inspect.isclass(thing) else ():
        of = getattr(value, "__func__", getattr(value, "fget", getattr(value, "func", value)))
        if not key.startswith("_") and inspect.isfunction(of):
            assert inspect.getdoc(of), f"{name}.{key}"


def parameters(thing: Any, label: str) -> dict[str, Any]:
    return {f"{label}.{name}": p.annotation for name, p in inspect.signature(thing).parameters.items() if name != "self"}


def test_public_parameters_name_what_they_take() -> None:
    taken: dict[str, Any] = {}
    for name in PUBLIC:
        thing = getattr(fa, name)
        if not (inspect.isclass(thing) and issubclass(thing, Exception)):
            taken |= parameters(thing, name)
        if inspect.isclass(thing):
            for key, value in inspect.getmembers_static(thing):
                method = value.__func__ if isinstance(value, (staticmethod, classmethod)) else value
                if inspect.isfunction(method) and not key.startswith("_") and method.__module__.startswith("fairaudit"):
                    taken |= parameters(method, f"{name}.{key}")
    loose = {label for label, annotation in taken.items() if re.search(r"\bAny\b", str(annotation))}
    assert loose <= DOCUMENTS | OPTIONAL | WITHIN


def test_numbers_of_every_form_are_accepted() -> None:
    forms = typing.get_args(fa.Number)
    assert {form.__name__ for form in forms} == {"int", "str", "Fraction", "Decimal", "float"}
    for form, text in ((int, "2"), (str, "2"), (Fraction, "2"), (forms[3], "2"), (float, "2")):
        assert fa.audit(TABLE, **ASKED, max_local_ratio=form(text)).targets[0].limit == 2


def kept(value: Any) -> Any:
    """What two objects that are the same thing have in common, where objects of their class are never equal."""
    if isinstance(value, fa.Result):
        return value.certificate.text, value.sentence, value.verdict
    return repr(value), sorted(vars(value)) if hasattr(value, "__dict__") else None


@pytest.mark.parametrize("name", [name for name in CLASSES if name not in ("Monitor", "ReleaseStore")])
def test_objects_are_pickled(name: str, tmp_path: Path) -> None:
    made = calls(tmp_path)[name]()
    again = pickle.loads(pickle.dumps(made))  # noqa: S301
    assert type(again) is type(made)
    assert again == made or kept(again) == kept(made)


def test_results_of_every_kind_are_pickled_and_go_on_working(tmp_path: Path) -> None:
    (tmp_path / "log.csv").write_text(LOG)
    import duckdb

    log = f"read_csv('{tmp_path}/log.csv', all_varchar = true)"
    duckdb.sql(f"copy (select *, 'a' as dept from {log}) to '{tmp_path}/log.parquet' (format parquet)")
    columns: dict[str, Any] = {"decision": "hired", "group": "sex"}
    for made in (
        fa.audit(TABLE, **ASKED, max_local_ratio="5/4"),
        fa.audit(tmp_path / "log.csv", **columns, utility="yes", truth=None),
        fa.audit(policy().behind(group=coin()), utility="hire", max_local_ratio=2),
        fa.audit(tmp_path / "log.parquet", **columns, context="dept", utility="yes", in_parts=True),
        fa.audit({**TABLE, "deserved": ["yes", "no", "no", "yes"]}, **ASKED, truth="deserved"),
    ):
        again = pickle.loads(pickle.dumps(made))  # noqa: S301
        assert again.certificate.text == made.certificate.text
        assert again.verify().ok
        assert again.most_unequal() == made.most_unequal()
    composed = fa.compose(coin(), 3)
    assert pickle.loads(pickle.dumps(composed)).delta(2) == composed.delta(2)  # noqa: S301


HOSTILE = "\x1b[31m\u202eevil\n\x00" + "very long " * 30


@pytest.mark.parametrize("name", CLASSES)
def test_objects_are_shown_on_a_screen(name: str, tmp_path: Path) -> None:
    text = repr(calls(tmp_path)[name]())
    assert len(text) < 600
    assert text.isprintable()


def test_big_results_with_hostile_labels_are_shown_on_a_screen() -> None:
    contexts = [f"{HOSTILE}{i}" for i in range(25_000)]
    counts = [[[3 + i % 5, 1], [2, 2]] for i in range(len(contexts))]
    big = fa.Law.from_array(counts, kind="counts", decisions=[HOSTILE, "no"], groups=[HOSTILE, "m"], contexts=contexts)
    assert big.weights.size == 100_000
    found = fa.certify(big, {HOSTILE: 1}, confidence=None, max_local_ratio=2)
    things = [found, big, found.utility, found.local, found.local.witness, found.demographic_parity, found.targets[0], found.claims[0]]
    things += [found.certificate, found.columns, fa.Policy(big), fa.Policy(big).behind(group=fa.Identity([HOSTILE, "m"]))]
    things += [fa.RandomizedResponse(contexts[:1000], keep_probability="1/3"), fa.Utility(dict.fromkeys(contexts, 10**5000))]
    checked = fa.verify(found)
    assert checked.ok
    for thing in (*things, checked):
        text = repr(thing)
        assert len(text) < 600, type(thing)
        assert text.isprintable(), type(thing)


def test_exceptions_are_one_family() -> None:
    own: set[type] = set()
    for module in pkgutil.walk_packages(fa.__path__, "fairaudit."):
        if not re.search(r"__main__|\.plugins|\.checker", module.name):
            found = vars(importlib.import_module(module.name)).values()
            own |= {thing for thing in found if inspect.isclass(thing) and issubclass(thing, Exception)}
    own = {thing for thing in own if thing.__module__.startswith("fairaudit") and ".checker" not in thing.__module__}
    assert own
    assert all(issubclass(thing, fa.FairauditError) for thing in own)
    assert {thing.__name__ for thing in own if thing.__module__ == "fairaudit.errors"} <= {*fa.__all__}
    assert issubclass(fa.InputError, ValueError)


def test_the_command_says_every_error_of_the_family_in_one_sentence(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    from fairaudit.cli import certify, main

    for kind in (fa.FairauditError, fa.Infeasible, fa.TableNeeded, fa.ManyRowsError):

        def fail(_: Any, kind: type[Exception] = kind) -> int:
            raise kind("what \x1b[31m went wrong")

        monkeypatch.setattr(certify, "run", fail)
        assert main(["certify", "x.csv"]) == 2
        assert capsys.readouterr().err == "fairaudit: what \\x1b[31m went wrong\n"


def test_infeasible_is_said_by_those_who_require_a_filter() -> None:
    found = fa.calibrate(max_ratio="5/4", groups=2, lipschitz=1)
    assert not found.feasible
    with pytest.raises(fa.Infeasible) as error:
        found.require()
    assert str(error.value) == found.reason
    assert fa.calibrate(max_ratio="5/4", groups=2, tau="0.5").require().mechanism is not None
    with pytest.raises(fa.Infeasible):
        fa.worst_case(law(), fa.UtilityClass(tau="1", rows=[({"yes": 1}, "0.1"), ({"no": 1}, "0.1")]))


if __name__ == "__main__":
    main(Path(sys.argv[1]))
