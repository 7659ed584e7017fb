"""Calls that cannot be meant, in Python and on the command line: each is answered in one sentence with what, where, and what to give."""

from __future__ import annotations

import inspect
from collections.abc import Callable
from pathlib import Path
from typing import Any

import duckdb
import numpy as np
import pandas as pd
import polars as pl
import pytest

import fairaudit as fa
from fairaudit import metrics
from fairaudit.arguments import hints
from fairaudit.cli import main

FRAME = pd.DataFrame({"hired": [1, 0, 1, 1] * 20, "sex": ["f", "f", "m", "m"] * 20, "age": [20, 30, 40, 50] * 20})
COUNTS = {"hired": ["yes", "no", "yes", "no"], "sex": ["f", "f", "m", "m"], "n": [300, 100, 200, 200]}
TRUE, PREDICTED, SEX = [1, 1, 0, 0, 1, 1, 0, 0], [1, 0, 0, 0, 1, 1, 1, 0], ["f"] * 4 + ["m"] * 4
LEVELS = pd.DataFrame([["y", "f"], ["n", "m"]], columns=pd.MultiIndex.from_tuples([("a", "hired"), ("b", "sex")]))
TWICE = pd.DataFrame([["y", "f", "m"], ["n", "m", "f"]], columns=["hired", "sex", "sex"])


def audit(source: Any = FRAME, /, **given: Any) -> Any:
    """An audit that would be true, changed as given."""
    return fa.audit(source, **{"decision": "hired", "group": "sex", "utility": "1", **given})


def law() -> fa.Law:
    return fa.Law.from_counts(COUNTS, decision="hired", group="sex", count="n")


def result() -> fa.Result:
    return fa.audit(COUNTS, decision="hired", group="sex", count="n", utility="yes")


def closed() -> Any:
    connection = duckdb.connect()
    relation = connection.sql("select 'yes' as hired, 'f' as sex")
    connection.close()
    return relation


def parity(y_pred: Any = PREDICTED, **given: Any) -> Any:
    return metrics.demographic_parity(TRUE, y_pred, **{"sensitive_features": SEX, **given})


ANY: Any = fa

PYTHON: dict[str, tuple[Callable[[], object], str]] = {
    "nothing": (lambda: ANY.audit(), "audit needs source, which was not given"),
    "None": (lambda: audit(None), "a table cannot be read from None; use a file, a database, a frame"),
    "a number": (lambda: audit(3), "a table cannot be read from an int; use a file"),
    "a table alone": (lambda: fa.audit(FRAME), "no decision column was named; give decision, the name of the column"),
    "no group": (lambda: audit(group=()), "no group column was named; give group"),
    "no utility": (lambda: audit(utility=None), "no utility was given; give utility, such as {'yes': 1}"),
    "by position": (
        lambda: ANY.audit(FRAME, "hired", "sex"),
        "audit takes source without a name; a text came after: name it, as in decision=…",
    ),
    "a misspelt keyword": (lambda: audit(descision="hired"), "audit has no argument descision; did you mean decision?"),
    "another misspelt keyword": (lambda: audit(groups="sex"), "audit has no argument groups; did you mean group?"),
    "an unknown keyword": (lambda: audit(zzz=1), "audit has no argument zzz; known: 'source', 'decision'"),
    "a limit without its place": (lambda: audit(max_ratio=2), "audit has no argument max_ratio; did you mean max_local_ratio?"),
    "a limit of two meanings": (lambda: audit(max_local=2), "max_local is not accepted; give max_local_ratio"),
    "a misspelt column": (lambda: audit(group="sexx"), "there is no column 'sexx'; known: 'hired', 'sex', 'age'; did you mean 'sex'?"),
    "a column as a series": (
        lambda: audit(decision=FRAME.hired),
        "decision is a Series; the name of a column is accepted; did you mean its name, 'hired'?",
    ),
    "a column in a list": (lambda: audit(decision=["hired"]), "decision is ['hired'], a list; the name of a column is accepted"),
    "group 3": (lambda: audit(group=3), "group is 3, an int; the name of a column or a list of such names is accepted"),
    "3 among groups": (lambda: audit(group=["sex", 3]), "group[1] is 3, an int; the name of a column is accepted"),
    "a list in a list": (lambda: audit(group=[["sex"]]), "group[0] is ['sex'], a list; the name of a column is accepted"),
    "the values of a group": (
        lambda: audit(group=FRAME.sex),
        "group is a Series; the name of a column or a list of such names is accepted; did you mean its name, 'sex'?",
    ),
    "count as a number": (lambda: audit(count=3), "count is 3, an int; the name of a column is accepted"),
    "a utility that does not occur": (
        lambda: audit(utility="yes"),
        "the utility names the decision 'yes', which does not occur; known: '0', '1'",
    ),
    "the column in the place of its label": (
        lambda: audit(utility="hired"),
        "which does not occur: that is the column; give one of its labels, such as 1 (--utility 1); known: '0', '1'",
    ),
    "a misspelt utility": (lambda: fa.certify(law(), {"yess": 1}), "which does not occur; known: 'yes', 'no'; did you mean 'yes'?"),
    "utility nan": (lambda: audit(utility={1: float("nan")}), "the utility of decision '1': nan is not a finite number"),
    "utility None": (lambda: audit(utility={1: None}), "utility[1] is None; a number such as 0.95 or '5/4' is accepted"),
    "a negative utility": (lambda: audit(utility={1: -1}), "the utility of decision '1' is negative; utilities are at least 0"),
    "utility 1": (lambda: audit(utility=1), "utility is 1, an int; a Utility, a dict or a text is accepted, such as {'hired': 1}"),
    "a list of utilities": (
        lambda: audit(utility=["1"]),
        "utility is ['1'], a list; a Utility, a dict or a text is accepted, such as {'hired': 1}",
    ),
    "a function": (lambda: audit(utility=len), "a Utility, a dict or a text is accepted"),
    "a series": (
        lambda: audit(FRAME.hired),
        "a table cannot be read from a Series, which is one column; give the frame that it is a column of",
    ),
    "an array without names": (
        lambda: audit(FRAME.to_numpy()),
        "a table cannot be read from a ndarray, whose columns have no names; give a frame of it, such as",
    ),
    "a list of lists": (
        lambda: audit([[1, "f"], [0, "m"]]),
        "a table cannot be read from a list whose values have no names; give a list of dicts",
    ),
    "an empty list": (lambda: audit([]), "a table cannot be read from a list without a row; give a list of dicts"),
    "an empty dict": (lambda: audit({}), "there is no column 'hired'; the table has no columns"),
    "unequal columns": (
        lambda: audit({"hired": [1, 0], "sex": ["f"]}),
        "column 'sex' has 1 value and column 'hired' 2; they must be equally long",
    ),
    "numbers for columns": (
        lambda: audit({"hired": 1, "sex": 2}),
        "column 'hired' is 1, an int; a list of values, one for each row, is accepted",
    ),
    "texts for columns": (
        lambda: audit({"hired": "yn", "sex": "fm"}),
        "column 'hired' is 'yn', a text; a list of values, one for each row, is accepted",
    ),
    "a column of lists": (
        lambda: audit({"hired": [[1], [0]], "sex": ["f", "m"]}),
        "column 'hired', row 1: a label of type list is not accepted",
    ),
    "a matrix for a column": (
        lambda: audit({"hired": np.ones((2, 2)), "sex": ["f", "m"]}),
        "column 'hired' has shape (2, 2); a list of values",
    ),
    "a relation that is closed": (
        lambda: audit(closed()),
        "the DuckDBPyRelation cannot be read: Connection Error: Connection has already been closed",
    ),
    "an empty frame": (lambda: audit(FRAME.iloc[:0]), "the table has no rows"),
    "columns of two levels": (lambda: audit(LEVELS), "the names of its columns are tuples such as ('a', 'hired'); make one text of each"),
    "a column twice": (lambda: audit(TWICE), "the column name 'sex' occurs more than once; give each column its own name"),
    "columns without names": (
        lambda: audit(pd.DataFrame([[1, "f"]])),
        "the names of its columns are no texts, but such as 0; give each column a name",
    ),
    "truth values": (
        lambda: audit(FRAME.assign(hired=FRAME.hired == 1)),
        "the utility names the decision '1', which does not occur; known: 'false', 'true'",
    ),
    "moments as decisions": (lambda: audit(FRAME.assign(hired=pd.Timestamp("2020-01-01"))), "known: '2020-01-01T00:00:00'"),
    "a generator": (
        lambda: audit(row for row in [{"hired": 1}]),
        "a table cannot be read from a generator; give a list of records, such as list(…)",
    ),
    "a class": (lambda: audit(pd.DataFrame), "a table cannot be read from the class DataFrame"),
    "a styled frame": (lambda: audit(FRAME.groupby("sex")), "a table cannot be read from a DataFrameGroupBy; use a file"),
    "a result": (lambda: audit(result()), "a Result is of an audit that was made already; give the table"),
    "two utilities": (lambda: audit(utility_column="age"), "utility and utility_column do not go together; give one of them"),
    "two utilities of subgroups": (
        lambda: fa.subgroups(FRAME, decision="hired", attributes="sex", utility="1", utility_column="age"),
        "utility and utility_column do not go together; give one of them",
    ),
    "names in one text": (
        lambda: audit(group="sex, age"),
        "there is no column 'sex, age'; did you mean the columns 'sex' and 'age', a list of names?",
    ),
    "the index": (lambda: audit(FRAME.set_index("sex")), "'sex' is the index of the frame, and no column; give frame.reset_index()"),
    "a constant without a name": (lambda: audit(declared={1: 2}), "1 cannot be declared; known: 'gamma'"),
    "a series of polars": (lambda: audit(pl.Series([1])), "a table cannot be read from a Series, which is one column"),
    "a connection": (lambda: audit(duckdb.connect()), "a table cannot be read from a DuckDBPyConnection; use a file"),
    "a set of names": (lambda: audit(group={"sex"}), "group is {'sex'}, a set; the name of a column or a list of such names is accepted"),
    "a file of the net": (
        lambda: audit("https://example.org/log.csv"),
        "https://example.org/log.csv is not on this machine; fetch the file",
    ),
    "no file": (lambda: audit("nothing.csv"), "nothing.csv: there is no such file"),
    "an empty name": (lambda: audit(""), "the name of the table is empty; name a CSV file"),
    "a target in letters": (lambda: audit(max_local_ratio="a"), "max_local_ratio: 'a' is not a number such as 12, 0.25, 1e-3 or 1/3"),
    "a target of 0": (lambda: audit(max_local_ratio=0), "max_local_ratio is 0; a ratio above 0 is accepted"),
    "a negative target": (lambda: audit(max_local_ratio=-1), "max_local_ratio is -1; a ratio above 0 is accepted"),
    "a target in percent": (lambda: audit(max_local_ratio="80%"), "'80%' is not a number such as 12, 0.25, 1e-3 or 1/3; '80%' is 0.8"),
    "two targets": (lambda: audit(max_local_ratio=[1, 2]), "max_local_ratio is [1, 2], a list; a number such as 0.95 or '5/4' is accepted"),
    "a target that is true": (lambda: audit(max_local_ratio=True), "max_local_ratio is True, a truth value; a number such as"),
    "confidence 95": (lambda: audit(confidence=95), "a confidence of 95 is not accepted; it lies between 0 and 1, such as 0.95"),
    "confidence 1.5": (lambda: audit(confidence=1.5), "a confidence of 1.5 is not accepted; it lies between 0 and 1"),
    "confidence 95%": (lambda: audit(confidence="95%"), "confidence: '95%' is not a number such as 12, 0.25, 1e-3 or 1/3; '95%' is 0.95"),
    "burden no": (lambda: audit(burden="no"), "burden is 'no', a text; True or False is accepted"),
    "difference false": (lambda: audit(difference="false"), "difference is 'false', a text; True or False is accepted"),
    "a misspelt choice": (
        lambda: audit(missing="drpo"),
        "missing='drpo' is not accepted; use 'error', 'drop', 'group', 'unknown' or 'undecided'",
    ),
    "a choice that is true": (
        lambda: audit(missing=True),
        "missing is True, a truth value; 'error', 'drop', 'group', 'unknown' or 'undecided' is accepted",
    ),
    "an engine 4": (lambda: audit(engine=4), "engine is 4, an int; 'auto', 'duckdb', 'python', 'spark' or a SparkSession is accepted"),
    "one edge": (lambda: audit(context="age", bins={"age": 5}), "bins['age'] is 5, an int; a list of numbers or a Bins is accepted"),
    "a misspelt constant": (lambda: audit(declared={"gama": 3}), "'gama' cannot be declared; known: 'gamma'"),
    "a filter in words": (lambda: audit(group_filter="coin"), "group_filter is 'coin', a text; a Mechanism is accepted"),
    "a probability of groups": (lambda: audit(group_probability=3), "a table cannot be read from an int; use a file"),
    "verify None": (
        lambda: ANY.verify(None),
        "None is no certificate; give a Certificate, a Result, the document, or the path of the file",
    ),
    "verify nothing": (lambda: fa.verify(""), "'' is no file name; name the file of the certificate"),
    "verify an empty dict": (
        lambda: fa.verify({}),
        "is not a certificate of the format fairaudit-certificate/1: the certificate lacks the key",
    ),
    "verify the text": (lambda: fa.verify(result().certificate.text), "the text is a document and no file name; give json.loads(text)"),
    "verify what is no JSON": (lambda: fa.verify({"x": object()}), "the document cannot be written as JSON, as a certificate is: "),
    "verify a frame": (lambda: ANY.verify(FRAME), "a DataFrame is no certificate; give a Certificate, a Result"),
    "verify with a table 3": (lambda: ANY.verify(result(), 3), "table is 3, an int; a path is accepted"),
    "verify with a misspelt keyword": (lambda: ANY.verify(result(), tabel="x"), "verify has no argument tabel; did you mean table?"),
    "certify a frame": (
        lambda: ANY.certify(FRAME, {"1": 1}),
        "subject is a DataFrame; a Law or a Deployment is accepted; give a table to audit",
    ),
    "certify without a utility": (lambda: ANY.certify(law()), "certify needs utility, which was not given"),
    "certify with a text": (
        lambda: ANY.certify(law(), "yes"),
        "utility is 'yes', a text; a Utility or a dict is accepted, such as {'hired': 1}",
    ),
    "a law of None": (lambda: ANY.Law.from_log(None, decision="a", group="b"), "table is None; a frame or a dict is accepted"),
    "a law of a path": (
        lambda: ANY.Law.from_log("x.csv", decision="a", group="b"),
        "table is 'x.csv', a text; a frame or a dict is accepted",
    ),
    "a law without counts": (
        lambda: ANY.Law.from_counts(COUNTS, decision="hired", group="sex"),
        "Law.from_counts needs count, which was not given",
    ),
    "an array of one axis": (lambda: fa.Law.from_array([1, 2, 3]), "an array of shape (3,) is not indexed [context, group, decision]"),
    "a ragged array": (
        lambda: fa.Law.from_array([[1, 2], [3]]),
        "the rows of the array are not equally long; it is indexed [context, group, decision]",
    ),
    "a policy of a frame": (lambda: ANY.Policy(FRAME), "law is a DataFrame; a Law is accepted"),
    "a filter of a number": (lambda: ANY.RandomizedResponse(2, keep_probability=0.75), "values is 2, an int; a list is accepted"),
    "a filter without a word": (lambda: ANY.RandomizedResponse(["f", "m"], eps=1), "RandomizedResponse has no argument eps; did you mean"),
    "a product of 3": (lambda: ANY.Product({"sex": 3}), "parts['sex'] is 3, an int; a Mechanism is accepted"),
    "a utility of a list": (lambda: ANY.Utility(["yes"]), "values is ['yes'], a list; a dict is accepted"),
    "a class of 3": (lambda: ANY.UtilityClass(rows=[3]), "rows[0] is 3, an int; a LinearRow or a list is accepted"),
    "worst of a dict": (lambda: ANY.worst_case(law(), {"yes": 1}), "utility_class is {'yes': 1}, a dict; a UtilityClass is accepted"),
    "plan in words": (lambda: fa.plan(["a", "b"], max_ratio=2), "'a' is not a number such as 12, 0.25, 1e-3 or 1/3"),
    "plan of None": (lambda: ANY.plan(None, max_ratio=2), "guesses is None; a Comparison"),
    "plan without a limit": (lambda: fa.plan([0.5, 0.4]), "no limit was given; give one of max_ratio"),
    "power in percent": (lambda: ANY.plan([0.5, 0.4], max_ratio=2, power="80%"), "power is '80%', a text; a number is accepted"),
    "compare one": (lambda: ANY.compare(result()), "compare needs after, which was not given"),
    "compare a frame": (lambda: ANY.compare(result(), FRAME), "a DataFrame is no certificate"),
    "report None": (lambda: ANY.report(None), "None is no certificate"),
    "report as docx": (lambda: ANY.report(result(), format="docx"), "format='docx' is not accepted; known: 'json', 'html'"),
    "save a text": (
        lambda: result().save("x.txt"),
        "x.txt ends in '.txt', and a certificate in '.json'; report() writes pages and markdown",
    ),
    "report a text": (lambda: result().report("x.txt"), "x.txt ends in '.txt', which does not say what to write; .json (the certificate)"),
    "save nowhere": (
        lambda: ANY.audit(COUNTS, decision="hired", group="sex", count="n", utility="yes").save(),
        "save needs path, which was not given",
    ),
    "save to 3": (lambda: result().save(3), "path is 3, an int; a path is accepted"),  # type: ignore[arg-type]
    "plot bars": (lambda: result().plot(picture="bars"), "there is no picture 'bars'; known: 'expectations', 'ratios', 'bounds'"),  # type: ignore[arg-type]
    "most unequal x": (lambda: result().most_unequal("x"), "count is 'x', a text; a whole number is accepted"),  # type: ignore[arg-type]
    "monitor a frame": (lambda: ANY.monitor(FRAME, decision="hired"), "log is a DataFrame; a path is accepted"),
    "monitor without an audit": (
        lambda: fa.monitor("log.csv"),
        "no state was named, and no audit was described; name the columns and the utility",
    ),
    "monitor in no folder": (
        lambda: fa.monitor("log.csv", state="/absent/watch.db", decision="hired", group="sex", utility="yes", max_local_ratio=2),
        "/absent/watch.db cannot be used as the state of a monitor: unable to open database file",
    ),
    "calibrate by position": (
        lambda: ANY.calibrate(2),
        "calibrate takes no argument without a name; an int came after: name it, as in max_ratio=…",
    ),
    "design for a law": (lambda: ANY.design(law(), {"yes": 1}, max_ratio=2), "policy is a Law; a Policy is accepted"),
    "epsilon of a result": (lambda: ANY.refute_epsilon(result(), 2), "comparison is a Result; a Comparison is accepted"),
    "an unknown example": (lambda: fa.example("ucb"), "there is no example 'ucb'; known: 'ucb-admissions'"),
    "a utility of no metric": (
        lambda: metrics.local_g_fairness(None, PREDICTED, sensitive_features=SEX, utility={1: None}),  # type: ignore[dict-item]
        "utility[1] is None; a number such as 0.95 or '5/4' is accepted",
    ),
    "an empty utility": (
        lambda: metrics.local_g_fairness(None, PREDICTED, sensitive_features=SEX, utility={}),
        "the utility lists no decision; list at least one, such as {1: 1}",
    ),
    "a metric without groups": (
        lambda: ANY.metrics.demographic_parity(TRUE, PREDICTED),
        "demographic_parity needs sensitive_features, which was not given",
    ),
    "a metric by position": (lambda: ANY.metrics.demographic_parity(TRUE, PREDICTED, SEX), "name it, as in sensitive_features=…"),
    "a metric of unequal length": (
        lambda: parity(sensitive_features=SEX[:4]),
        "column 'sensitive feature' has 4 values and column 'decision' 8",
    ),
    "a metric of a matrix": (lambda: parity(np.ones((8, 2))), "y_pred has shape (8, 2); one value for each sample is accepted"),
    "a metric of ragged rows": (
        lambda: parity([[1], [2, 3]] * 4),
        "y_pred has rows of different lengths; one value for each sample is accepted",
    ),
    "a misspelt feature": (lambda: parity(sensitive_feature=SEX), "has no argument sensitive_feature; did you mean sensitive_features?"),
    "a metric of one group": (lambda: parity(sensitive_features=["f"] * 8), "there is only one group, 'f'; fairness compares at least two"),
    "a metric without a true label": (
        lambda: metrics.equalized_odds(None, PREDICTED, sensitive_features=SEX),
        "y_true is None; give the true label of every sample",
    ),
    "a utility that no metric finds": (
        lambda: metrics.local_g_fairness(None, ["yes", "no"] * 4, sensitive_features=SEX, utility={"yess": 1}),
        "none of the decisions that the utility lists occurs in y_pred, such as 'yess'; known: 'no', 'yes'; did you mean 'yes'?",
    ),
}


@pytest.mark.parametrize("name", PYTHON)
def test_wrong_calls_in_python(name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    call, words = PYTHON[name]
    with pytest.raises(fa.FairauditError) as error:
        call()
    said = str(error.value)
    assert words in said
    assert "\n" not in said and len(said) < 600 and said.isprintable()
    assert error.value.__cause__ is None and error.value.__suppress_context__ == (error.value.__context__ is not None)
    assert list(tmp_path.iterdir()) == []


ASKED = "certify log.csv --decision hired --group sex --utility yes"

COMMANDS: dict[str, str] = {
    "certif log.csv": "there is no command 'certif'; known: 'certify', 'inspect'",
    "nonsense": "there is no command 'nonsense'; known: 'certify'",
    "certify lgo.csv --decision hired --group sex --utility yes": "lgo.csv: there is no such file",
    "certify folder --decision hired --group sex --utility yes": "folder: this is a directory; name a file, or a pattern such as",
    "certify binary.csv --decision hired --group sex --utility yes": "binary.csv: line 1 is not UTF-8 (byte 0xff); save the file as UTF-8",
    "certify empty.csv --decision hired --group sex --utility yes": "empty.csv: the file has a header line but no rows",
    "certify nothing.csv --decision hired --group sex --utility yes": "nothing.csv: the file is empty; a header line and at least one row",
    "certify report.pdf --decision hired --group sex --utility yes": "report.pdf is a PDF; save the table in it as CSV or as a spreadsheet",
    "inspect report.pdf": "report.pdf is a PDF; save the table in it as CSV or as a spreadsheet, and name that file",
    "certify page.html --decision hired --group sex --utility yes": "page.html is a web page; save the table in it as CSV",
    "certify c.json --decision hired --group sex --utility yes": "c.json is a certificate; fairaudit verify checks it",
    "tally log.csv --decision hired --group sex -o n.csv": "n.csv does not end in .parquet, as a tally does; name a file FILE.parquet",
    "tally log.csv --decision hired --group sex --unit sex -o n.parquet": "--unit does not go with tally: rows of one sampling unit may",
    "tally log.csv --decision hird --group sex -o n.parquet": "there is no column 'hird'; known: 'hired', 'sex'; did you mean 'hired'?",
    f"{ASKED} --descision hired": "unrecognized arguments: --descision hired; did you mean --decision?",
    "certify log.csv --decision hird --group sex --utility yes": "there is no column 'hird'; known: 'hired', 'sex'; did you mean 'hired'?",
    "certify log.csv --decision hired --group sex --utility yess": "'yess', which does not occur; known: 'no', 'yes'; did you mean 'yes'?",
    "certify log.csv --decision hired --group sex --utility yes=one": "the utility of decision 'yes': 'one' is not a number such as 12",
    "certify log.csv --decision hired --group hired --utility yes": "the column 'hired' is used twice; each column has one role",
    "certify log.csv --decision hired --group sex": "no utility was given; use --utility, such as --utility Admitted",
    f"{ASKED} --max-local-ratio 80%": "max_local_ratio: '80%' is not a number such as 12, 0.25, 1e-3 or 1/3; '80%' is 0.8",
    f"{ASKED} --max-local-ratio": "--max-local-ratio: expected one argument",
    f"{ASKED} --max-local-ratio=": "max_local_ratio: '' is not a number such as 12",
    f"{ASKED} --max-local 1.25": "--max-local is not accepted; give --max-local-ratio, a limit on the ratio such as 5/4",
    f"{ASKED} --max-ratio 1.25": "did you mean --max-local-ratio?",
    f"{ASKED} --confidence 95": "--confidence '95' is not accepted; a number between 0 and 1 such as 0.95 is, or 'none'",
    f"{ASKED} --format xml": "--format: invalid choice: 'xml'",
    f"{ASKED} --missing ignore": "--missing: invalid choice: 'ignore'",
    f"{ASKED} -o absent/c.json": "absent/c.json cannot be written: there is no directory",
    "certify": "no table was named; give a CSV file, or --example ucb-admissions",
    "certify log.csv log.csv --decision hired --group sex --utility yes": "log.csv is named twice; each file is read once",
    "verify log.csv": "log.csv: Not a certificate of the format fairaudit-certificate/1",
    "verify c.json --require exceeds": "--require: invalid choice: 'exceeds'",
    "compare c.json": "the following arguments are required: NEW",
    "compare c.json log.csv": "log.csv: the file holds something else; give the .json that fairaudit wrote, or its page (.html)",
    "report log.csv": "log.csv: the file holds something else; give the .json that fairaudit wrote, or its page (.html)",
    "plan --guess 50%,40% --max-ratio 1.25": "'50%' is not a number such as 12, 0.25, 1e-3 or 1/3; '50%' is 0.5",
    "plan --guess 0.5,0.4": "one of the arguments --max-ratio --max-log is required",
    "monitor log.csv": "no state was named, and no audit was described; name the columns and the utility",
    "calibrate --max-ratio 2 --groups two": "--groups 'two': 'two' is not a number of values from 2 to 10000",
    "design --max-ratio 2": "neither an audit file nor --groups was given; name the file of a policy, or give the number of groups",
    "subgroups log.csv --decision hired --attributes sexx --utility yes": "no column 'sexx'; known: 'hired', 'sex'; did you mean 'sex'?",
}


@pytest.fixture(scope="module")
def bench(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with a table, and with what is none."""
    folder = tmp_path_factory.mktemp("bench")
    (folder / "log.csv").write_text("hired,sex\nyes,f\nno,f\nyes,m\nyes,m\n")
    (folder / "empty.csv").write_text("hired,sex\n")
    (folder / "nothing.csv").write_text("")
    (folder / "binary.csv").write_bytes(b"\xff\x00\x01" * 1000)
    (folder / "report.pdf").write_bytes(b"%PDF-1.4\n1 0 obj\n")
    (folder / "folder").mkdir()
    made = result()
    made.save(folder / "c.json")
    made.report(folder / "page.html")
    return folder


@pytest.mark.parametrize("words", COMMANDS)
def test_wrong_calls_on_the_command_line(
    words: str, bench: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(bench)
    before = sorted(bench.iterdir())
    try:
        code = main(words.split())
    except SystemExit as stop:
        code = stop.code  # type: ignore[assignment]
    out, err = capsys.readouterr()
    assert (code, out) == (2, "")
    assert COMMANDS[words] in err
    assert err.startswith("fairaudit") and err.endswith("\n") and err.count("\n") == 1 and len(err) < 600
    assert sorted(bench.iterdir()) == before


def test_true_calls_of_unusual_types_are_no_wrong_calls() -> None:
    table = audit(max_local_ratio=np.float64(1.25), confidence=np.float32(0.5), context=None, bins=None, group=pd.Index(["sex"]))
    assert table.targets[0].limit == fa.audit(FRAME, decision="hired", group="sex", utility={1: 1}, max_local_ratio="5/4").targets[0].limit
    assert audit(FRAME.astype({"sex": "category"}), burden=np.True_, releases=np.int64(1)).burden
    assert fa.read_log(FRAME, "sex").counts.tolist() == [40, 40]
    assert ANY.plan(np.array([0.5, 0.4]), max_ratio=2).draws == fa.plan([0.5, 0.4], max_ratio=2).draws


def public_functions() -> list[tuple[str, Any]]:
    found = [(name, getattr(fa, name)) for name in fa.__all__ if inspect.isfunction(getattr(fa, name))]
    return found + [(f"metrics.{name}", getattr(metrics, name)) for name in metrics.__all__]


@pytest.mark.parametrize(("name", "function"), public_functions())
def test_every_public_function_answers_wrong_calls(name: str, function: Any) -> None:
    own = inspect.unwrap(function)
    named = {key for key, parameter in inspect.signature(own).parameters.items() if parameter.kind != parameter.VAR_KEYWORD}
    assert set(hints(own)) == named
    if len(named) == len(inspect.signature(own).parameters):
        with pytest.raises(fa.InputError, match=rf"^{name.removeprefix('metrics.')} has no argument no_such_argument; "):
            function(no_such_argument=1)
    else:
        assert own is not function
