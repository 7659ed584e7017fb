"""Metrics with the signature of scikit-learn and Fairlearn, beside the libraries that compute the same numbers."""

from __future__ import annotations

import csv
import logging
import math
import warnings
from fractions import Fraction
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from fairaudit import InputError, metrics

WITHIN = [metrics.parity_within_contexts, metrics.equalized_odds, metrics.equal_opportunity]
METRICS = [metrics.local_g_fairness, metrics.global_g_fairness, metrics.demographic_parity, *WITHIN]


@pytest.fixture(scope="module")
def aif360() -> Any:
    logging.disable(logging.WARNING)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        import aif360.sklearn.metrics as found
    logging.disable(logging.NOTSET)
    return found


@pytest.fixture
def berkeley(data: Path) -> pd.DataFrame:
    """Each applicant of 1973 a row: admitted or not."""
    table = pd.read_csv(data / "ucb_admissions.csv")
    table["admitted"] = (table["Admit"] == "Admitted").astype(int)
    return table.loc[table.index.repeat(table["Freq"]), ["admitted", "Gender", "Dept"]].reset_index(drop=True)


@pytest.fixture
def names(data: Path) -> pd.DataFrame:
    """Recommendations of language models for the same résumé under different names."""
    table = pd.read_csv(data / "hiringbias_firstname.csv")
    table["invited"] = (table["recommend_interview"] != "no").astype(int)
    return table


def tables(berkeley: pd.DataFrame, names: pd.DataFrame) -> list[tuple[pd.Series, pd.Series, pd.Series]]:
    return [(berkeley["admitted"], berkeley["Gender"], berkeley["Dept"]), (names["invited"], names["name"], names["jd"])]


def test_fairlearn_agrees(berkeley: pd.DataFrame, names: pd.DataFrame) -> None:
    from fairlearn.metrics import demographic_parity_difference, demographic_parity_ratio, equalized_odds_difference

    for y, groups, context in tables(berkeley, names):
        ratio = demographic_parity_ratio(y, y, sensitive_features=groups)
        assert math.exp(-metrics.global_g_fairness(None, y, sensitive_features=groups)) == pytest.approx(ratio, rel=1e-12)
        difference = demographic_parity_difference(y, y, sensitive_features=groups)
        assert metrics.demographic_parity(None, y, sensitive_features=groups) == pytest.approx(difference, rel=1e-12)
        truth = (context == context.iloc[0]).astype(int)
        odds = equalized_odds_difference(truth, y, sensitive_features=groups)
        assert metrics.equalized_odds(truth, y, sensitive_features=groups) == pytest.approx(odds, rel=1e-12)


SAMPLES = st.lists(st.tuples(st.integers(0, 1), st.integers(0, 1), st.sampled_from("abc"), st.sampled_from("xy")), min_size=4, max_size=60)


@given(samples=SAMPLES, weights=st.lists(st.integers(1, 5), min_size=60, max_size=60), weighted=st.booleans())
def test_fairlearn_agrees_given_the_true_label(samples: list[tuple[int, int, str, str]], weights: list[int], *, weighted: bool) -> None:
    """Wherever every group has samples of both true labels; elsewhere Fairlearn takes 0 for a rate that does not exist."""
    from fairlearn.metrics import equal_opportunity_difference, equalized_odds_difference, equalized_odds_ratio

    truth, predicted, groups, levels = map(list, zip(*samples, strict=True))
    assume(len(set(groups)) > 1 and len(set(zip(truth, groups, strict=True))) == 2 * len(set(groups)))
    more = {"sample_weight": weights[: len(samples)]} if weighted else {}
    given_ = {"sensitive_features": groups, **more}
    found = metrics.equalized_odds(truth, predicted, **given_)
    assert found == pytest.approx(equalized_odds_difference(truth, predicted, **given_), abs=1e-12)
    chance = metrics.equal_opportunity(truth, predicted, **given_)
    assert chance == pytest.approx(equal_opportunity_difference(truth, predicted, **given_), abs=1e-12)
    ratio = equalized_odds_ratio(truth, predicted, **given_)
    if not math.isnan(ratio) and all(any(u for t, u, *_ in samples if t == label) for label in (0, 1)):
        assert math.exp(-metrics.local_g_fairness(None, predicted, **given_, control_features=truth)) == pytest.approx(ratio, abs=1e-12)
    each = []
    for level in set(levels):
        part = [i for i, found_level in enumerate(levels) if found_level == level]
        some = [truth[i] for i in part], [predicted[i] for i in part]
        among = {name: [column[i] for i in part] for name, column in given_.items()}
        if len(set(zip(some[0], among["sensitive_features"], strict=True))) != 2 * len(set(groups)):
            return
        each.append(equalized_odds_difference(*some, **among))
    assert metrics.equalized_odds(truth, predicted, **given_, control_features=levels) == pytest.approx(max(each), abs=1e-12)


def test_a_rate_that_nobody_has_is_not_called_equal() -> None:
    """Fairlearn takes 0 for the true positive rate of a group without a true positive."""
    from fairlearn.metrics import equalized_odds_difference

    truth, predicted, groups = [1, 1, 0, 0, 0, 0], [0, 0, 1, 0, 0, 1], list("aaabbb")
    assert equalized_odds_difference(truth, predicted, sensitive_features=groups) == pytest.approx(2 / 3)
    assert equalized_odds_difference(truth, [0, 0, 1, 1, 1, 1], sensitive_features=groups) == 0
    for answers in (predicted, [0, 0, 1, 1, 1, 1]):
        with pytest.raises(InputError, match="true label is '1'"):
            metrics.equalized_odds(truth, answers, sensitive_features=groups)
        with pytest.raises(InputError, match="true label is 1"):
            metrics.equal_opportunity(truth, answers, sensitive_features=groups)
    among_two = metrics.equalized_odds([*truth, 1, 0], [*predicted, 1, 1], sensitive_features=[*groups, "c", "c"])
    assert among_two == 1
    assert metrics.equal_opportunity([2, 2, 3, 2], ["u", "v", "w", "v"], sensitive_features=list("aabb"), pos_label=2.0) == 0.5


def test_fairlearn_agrees_on_weighted_samples(berkeley: pd.DataFrame) -> None:
    from fairlearn.metrics import demographic_parity_difference, demographic_parity_ratio

    few = berkeley.groupby(["admitted", "Gender", "Dept"]).size().reset_index(name="n")
    weights = {"sensitive_features": few["Gender"], "sample_weight": few["n"]}
    ratio = demographic_parity_ratio(few["admitted"], few["admitted"], **weights)
    assert math.exp(-metrics.global_g_fairness(None, few["admitted"], **weights)) == pytest.approx(ratio, rel=1e-12)
    difference = demographic_parity_difference(few["admitted"], few["admitted"], **weights)
    assert metrics.demographic_parity(None, few["admitted"], **weights) == pytest.approx(difference, rel=1e-12)


def test_inside_a_metric_frame(berkeley: pd.DataFrame) -> None:
    """Local g-fairness is the greatest of the global ones by department, which a MetricFrame lists."""
    from fairlearn.metrics import MetricFrame

    frame = MetricFrame(
        metrics=metrics.global_g_fairness,
        y_true=berkeley["admitted"],
        y_pred=berkeley["admitted"],
        sensitive_features=berkeley["Dept"],
        sample_params={"sensitive_features": berkeley["Gender"]},
    )
    local = metrics.local_g_fairness(None, berkeley["admitted"], sensitive_features=berkeley["Gender"], control_features=berkeley["Dept"])
    assert frame.by_group.max() == pytest.approx(local, rel=1e-12)
    assert math.exp(local) == pytest.approx(24475 / 18432, rel=1e-11)
    assert frame.by_group.idxmax() == "A"
    assert frame.overall == pytest.approx(math.log(2198330 / 1498887), rel=1e-11)


def test_as_a_scikit_learn_scorer() -> None:
    from sklearn import config_context
    from sklearn.linear_model import LogisticRegression
    from sklearn.metrics import make_scorer
    from sklearn.model_selection import cross_validate

    generator = np.random.default_rng(0)
    groups = generator.integers(0, 2, 400)
    x = np.column_stack((groups, generator.normal(size=400)))
    y = (x.sum(axis=1) + generator.normal(size=400) > 0.5).astype(int)
    with config_context(enable_metadata_routing=True):
        scorer = make_scorer(metrics.demographic_parity, greater_is_better=False).set_score_request(sensitive_features=True)
        scores = cross_validate(LogisticRegression(), x, y, scoring=scorer, params={"sensitive_features": groups}, cv=2)["test_score"]
        model = LogisticRegression().fit(x, y)
        alone = scorer(model, x, y, sensitive_features=groups)
    rates = [model.predict(x)[groups == a].mean() for a in (0, 1)]
    assert alone == pytest.approx(-abs(rates[0] - rates[1]))
    assert (scores < -0.1).all()


def people() -> tuple[pd.DataFrame, list[int]]:
    """Those with many years are mostly men, and half of what decides is years."""
    frame = pd.DataFrame({"test": [i % 11 for i in range(440)], "years": [i % 8 for i in range(440)]})
    fit = [int(2 * test + years > 17) for test, years in zip(frame["test"], frame["years"], strict=True)]
    return frame.assign(sex=["m" if years > 4 else "f" for years in frame["years"]]), fit


def tree(depth: int) -> Any:
    from sklearn.compose import make_column_transformer
    from sklearn.pipeline import make_pipeline
    from sklearn.tree import DecisionTreeClassifier

    return make_pipeline(make_column_transformer(("passthrough", ["test", "years"])), DecisionTreeClassifier(max_depth=depth))


def parity(estimator: Any, frame: pd.DataFrame, fit: Any) -> float:
    return -metrics.demographic_parity(fit, estimator.predict(frame), sensitive_features=frame["sex"])


def test_scores_of_folds_are_differences_of_selection_rates() -> None:
    """With the group among the columns or routed to the scorer, each score is what plain loops over the fold give."""
    from sklearn import config_context
    from sklearn.metrics import make_scorer
    from sklearn.model_selection import KFold, cross_val_score

    frame, fit = people()
    folds = KFold(5)
    scores = cross_val_score(tree(3), frame, fit, scoring=parity, cv=folds)
    with config_context(enable_metadata_routing=True):
        scorer = make_scorer(metrics.demographic_parity, greater_is_better=False).set_score_request(sensitive_features=True)
        routed = cross_val_score(tree(3), frame, fit, scoring=scorer, cv=folds, params={"sensitive_features": frame["sex"]})
    for (train, test), score in zip(folds.split(frame), scores, strict=True):
        hired = tree(3).fit(frame.iloc[train], np.array(fit)[train]).predict(frame.iloc[test])
        women, men = (hired[(frame["sex"].iloc[test] == sex).to_numpy()] for sex in "fm")
        assert score == pytest.approx(-abs(women.mean() - men.mean()), abs=1e-12)
    assert routed.tolist() == scores.tolist() and scores.min() < -0.15


def test_a_search_takes_the_most_accurate_that_keeps_a_limit() -> None:
    from sklearn.model_selection import GridSearchCV

    def choose(found: Any) -> int:
        kept = [i for i, score in enumerate(found["mean_test_parity"]) if -score <= 0.1]
        return max(kept, key=lambda i: float(found["mean_test_accuracy"][i]))

    frame, fit = people()
    depths = {"decisiontreeclassifier__max_depth": [1, 3]}
    scoring = {"accuracy": "accuracy", "parity": parity}
    search = GridSearchCV(tree(1), depths, scoring=scoring, refit=choose).fit(frame, fit)
    assert search.best_params_ == {"decisiontreeclassifier__max_depth": 1}
    assert search.cv_results_["mean_test_accuracy"][1] > search.cv_results_["mean_test_accuracy"][0]


def test_a_fold_without_a_group_has_no_score() -> None:
    from sklearn.model_selection import PredefinedSplit, cross_val_score

    frame, fit = people()
    folds = PredefinedSplit((frame["sex"] == "f").astype(int))
    with pytest.warns(UserWarning, match="there is only one group") as seen:
        scores = cross_val_score(tree(1), frame, fit, scoring=parity, cv=folds)
    assert np.isnan(scores).all()
    for warning, sex in zip(seen, "mf", strict=True):
        assert f"there is only one group, '{sex}'; fairness compares at least two" in str(warning.message)


def test_the_difference_of_a_metric_frame_is_parity() -> None:
    from fairlearn.metrics import MetricFrame, selection_rate

    frame, fit = people()
    found = MetricFrame(metrics=selection_rate, y_true=fit, y_pred=fit, sensitive_features=frame["sex"])
    assert found.difference() == pytest.approx(metrics.demographic_parity(fit, fit, sensitive_features=frame["sex"]), abs=1e-12)


def test_metrics_come_with_the_package() -> None:
    import fairaudit as fa

    assert fa.metrics is metrics


def test_aif360_agrees(aif360: Any, berkeley: pd.DataFrame, data: Path) -> None:
    indexed = berkeley.set_index("Gender")["admitted"]
    given = {"prot_attr": "Gender", "priv_group": "Male", "pos_label": 1}
    ratio = aif360.disparate_impact_ratio(indexed, indexed, **given)
    assert math.exp(-metrics.global_g_fairness(None, berkeley["admitted"], sensitive_features=berkeley["Gender"])) == pytest.approx(ratio)
    difference = aif360.statistical_parity_difference(indexed, indexed, **given)
    assert metrics.demographic_parity(None, berkeley["admitted"], sensitive_features=berkeley["Gender"]) == pytest.approx(-difference)
    # Differential fairness of binary outcomes is the greater of the two log-ratios; AIF360 smooths, less and less here.
    both = max(
        metrics.global_g_fairness(None, berkeley["admitted"], sensitive_features=berkeley["Gender"], utility={decision: 1})
        for decision in (0, 1)
    )
    assert aif360.smoothed_edf(indexed, prot_attr="Gender", pos_label=1, concentration=1e-9) == pytest.approx(both, rel=1e-6)


def test_zero_cells_have_one_documented_meaning(aif360: Any) -> None:
    from fairlearn.metrics import demographic_parity_ratio

    nobody = {"y": [0, 0, 0, 0], "a": ["f", "f", "m", "m"]}
    some = {"y": [0, 0, 1, 0], "a": ["f", "f", "m", "m"]}
    assert metrics.global_g_fairness(None, nobody["y"], sensitive_features=nobody["a"]) == 0
    assert metrics.global_g_fairness(None, some["y"], sensitive_features=some["a"]) == math.inf
    assert metrics.local_g_fairness(None, some["y"], sensitive_features=some["a"]) == math.inf
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        assert math.isnan(demographic_parity_ratio(nobody["y"], nobody["y"], sensitive_features=nobody["a"]))
        assert demographic_parity_ratio(some["y"], some["y"], sensitive_features=some["a"]) == 0
        for table in (nobody, some):
            indexed = pd.Series(table["y"], index=pd.Index(table["a"], name="a"))
            found = aif360.disparate_impact_ratio(indexed, indexed, prot_attr="a", priv_group="m", pos_label=1)
            assert found == 0 or math.isnan(found)


def test_several_features_make_intersections() -> None:
    y = [1, 0, 1, 1, 0, 0, 1, 0]
    sex, age = list("ffffmmmm"), list("ooyyooyy")
    frame = pd.DataFrame({"sex": sex, "age": age})
    columns = np.array([sex, age]).T
    numbers = {
        metrics.demographic_parity(None, y, sensitive_features=features)
        for features in (frame, columns, columns.tolist(), {"sex": sex, "age": age}, [f"{s}{o}" for s, o in zip(sex, age, strict=True)])
    }
    assert numbers == {1.0}
    assert metrics.parity_within_contexts(None, y, sensitive_features=sex, control_features=frame[["age"]]) == 0.5


def test_utilities() -> None:
    y, groups = ["yes", "maybe", "no", "no"], list("aabb")
    assert metrics.global_g_fairness(None, y, sensitive_features=groups, utility={"yes": 1, "no": "0.5"}) == 0
    assert metrics.global_g_fairness(None, y, sensitive_features=groups, utility={"yes": 3, "no": 0.5, "never seen": 9}) == pytest.approx(
        math.log(3)
    )
    numbers = metrics.global_g_fairness(None, [0.5, 1.5, 1.0, 3.0], sensitive_features=groups)
    assert numbers == pytest.approx(math.log(2))
    assert metrics.global_g_fairness(None, np.array([True, False, True, True]), sensitive_features=groups) == pytest.approx(math.log(2))


@pytest.mark.parametrize("decisions", [[1, 0, 1, 1], [1.0, 0.0, 1.0, 1.0], [True, False, True, True], ["1", "0", "1", "1"]])
@pytest.mark.parametrize("listed", [1, 1.0, True, "1", "1.0"])
def test_a_number_is_one_decision_however_it_is_written(decisions: list[Any], listed: Any) -> None:
    """A utility whose label is not found would be worth 0 to everybody, which looks perfectly fair."""
    found = metrics.global_g_fairness(None, decisions, sensitive_features=list("aabb"), utility={listed: 1})
    assert found == math.log(2)


def test_a_truth_value_is_the_positive_label() -> None:
    """As in scikit-learn and Fairlearn, the default positive label 1 is `True` in an array of truth values."""
    truth, predicted, groups = np.array([1, 1, 0, 1, 1, 0]), np.array([1, 0, 0, 1, 1, 1]), list("aaabbb")
    for one, other in ((truth, predicted), (truth == 1, predicted), (truth == 1, predicted == 1), (truth * 1.0, predicted == 1)):
        assert metrics.equal_opportunity(one, other, sensitive_features=groups) == 0.5
        assert metrics.equal_opportunity(one, other, sensitive_features=groups, pos_label=True) == 0.5


def test_the_last_step_rounds_to_the_nearest_float() -> None:
    """R = 1 + 2^-51, whose logarithm is 2^-51 - 2^-103 + 2^-153/3 - ..., and a few logarithms of small numbers."""
    worth = {"no": 1, "yes": 1 + Fraction(1, 2**51)}
    assert metrics.local_g_fairness(None, ["no", "yes"], sensitive_features=list("ab"), utility=worth) == 2.0**-51 - 2.0**-103
    for n in range(2, 50):
        assert metrics.local_g_fairness(None, [1, n], sensitive_features=list("ab")) == pytest.approx(math.log(n), rel=2.3e-16, abs=0)


def test_a_masked_decision_is_missing() -> None:
    masked = np.ma.masked_array([1, 0, 1, 0], mask=[False, False, True, False])
    with pytest.raises(InputError, match="the label is missing"):
        metrics.global_g_fairness(None, masked, sensitive_features=list("aabb"))


@pytest.mark.parametrize("metric", METRICS)
@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"sensitive_features": None}, "sensitive_features is None"),
        ({"sensitive_features": ["a", "a", "a", "a"]}, "only one group"),
        ({"sensitive_features": ["a", "b"]}, "equally long"),
        ({"sensitive_features": ["a", None, "b", "b"]}, "missing"),
        ({"control_features": [1, 2, 3, 4]}, "nobody is compared"),
        ({"y_true": None}, "y_true is None"),
        ({"y_true": [1, 1]}, "equally long"),
        ({"y_true": [0, 0, 1, 0]}, "whose true label is '?1"),
        ({"sample_weight": [1, 1, -1, 1]}, "-1"),
        ({"y_pred": [[1, 2], [1, 2], [1, 2], [1, 2]]}, "shape"),
        ({"y_pred": ["yes", "no", "yes", "no"]}, "give utility="),
    ],
)
def test_bad_input(metric: Any, changes: dict[str, Any], message: str) -> None:
    call = {"y_true": [1, 1, 1, 1], "y_pred": [1, 0, 1, 0], "sensitive_features": ["a", "a", "b", "b"]} | changes
    parity = metric in (metrics.demographic_parity, *WITHIN)
    if "y_true" in changes and metric not in (metrics.equalized_odds, metrics.equal_opportunity):
        assert metric(**call) == 0
        return
    if message == "give utility=" and parity:
        assert metric(**call) == 0
        return
    if message == "nobody is compared" and metric in (metrics.demographic_parity, metrics.global_g_fairness):
        assert metric(**call) == 0
        return
    with pytest.raises(InputError, match=message):
        metric(**call)


def test_a_log_of_many_rows_is_read_as_it_stands(data: Path) -> None:
    """The same number as counting by hand, on a file that nobody prepared."""
    with (data / "hiringbias_firstname.csv").open(newline="") as file:
        rows = list(csv.DictReader(file))
    tally: dict[str, list[int]] = {}
    for row in rows:
        entry = tally.setdefault(row["name"], [0, 0])
        entry[0] += row["recommend_interview"] == "yes"
        entry[1] += 1
    rates = [yes / n for yes, n in tally.values()]
    found = metrics.global_g_fairness(
        None, [r["recommend_interview"] for r in rows], sensitive_features=[r["name"] for r in rows], utility={"yes": 1}
    )
    assert found == pytest.approx(math.log(max(rates) / min(rates)) if min(rates) else math.inf)
