"""What `certify` says of the population behind counts and logs: intervals, verdicts, units, placebo, the filter's claim, planning."""

from __future__ import annotations

import json
import random
from collections.abc import Callable
from fractions import Fraction
from itertools import permutations
from pathlib import Path
from typing import Any

import pytest
from envelopes import envelope, result_of
from hypothesis import given
from hypothesis import strategies as st
from scipy import stats

import fairaudit as fa
from fairaudit import checker
from fairaudit.cli import main
from fairaudit.errors import InputError
from fairaudit.inference.ends import cell_ends

F = Fraction
YES = {"yes": 1}


def table(*cells: tuple[str, int, int], context: str | None = None) -> dict[str, list[Any]]:
    """Counts of yes and no for each group."""
    rows: dict[str, list[Any]] = {"u": [], "a": [], "n": []}
    for group, yes, no in cells:
        for decision, n in (("yes", yes), ("no", no)):
            for name, value in zip("uan", (decision, group, n), strict=True):
                rows[name].append(value)
    return rows


def counts(*cells: tuple[str, int, int]) -> fa.Law:
    return fa.Law.from_counts(table(*cells), decision="u", group="a", count="n")


def verified(result: fa.Result) -> dict[str, Any]:
    """The document of a certificate, after the checker has accepted every statement of it."""
    certificate = result.certificate
    report = checker.check(certificate.text.encode(), certificate.table.lines() if certificate.table else None)
    assert report.ok, [finding for finding in report.findings if not finding.true]
    return certificate.document


def clopper_pearson(n: int, k: int, level: float) -> tuple[float, float]:
    return (stats.beta.ppf(level, k, n - k + 1) if k else 0.0), (stats.beta.ppf(1 - level, k + 1, n - k) if k < n else 1.0)


@given(st.integers(1, 60), st.integers(1, 60), st.data())
def test_two_groups_are_bounded_by_their_binomial_ends(n: int, m: int, data: st.DataObject) -> None:
    """Two cells: every end has an eighth of the error (two cells, two sides, two ends of the ratio), as scipy computes it."""
    k, j = data.draw(st.integers(0, n)), data.draw(st.integers(0, m))
    result = fa.certify(counts(("f", k, n - k), ("m", j, m - j)), YES, confidence="0.9")
    found = result.intervals["local"]
    (f_lo, f_hi), (m_lo, m_hi) = clopper_pearson(n, k, 0.025), clopper_pearson(m, j, 0.025)
    upper = max(f_hi / m_lo if m_lo else float("inf"), m_hi / f_lo if f_lo else float("inf"))
    lower = max(1.0, f_lo / m_hi, m_lo / f_hi)
    assert float(found.upper) == pytest.approx(upper, rel=1e-4)
    assert float(found.lower) == pytest.approx(lower, rel=1e-4)
    assert float(found.upper) >= upper * (1 - 1e-12) and float(found.lower) <= lower * (1 + 1e-12)
    verified(result)


def test_verdicts_admit_ignorance() -> None:
    few, many = counts(("f", 3, 1), ("m", 1, 3)), counts(("f", 3000, 1000), ("m", 1000, 3000))
    assert fa.certify(few, YES, max_local_ratio="5/4").verdict == "inconclusive"
    assert fa.certify(many, YES, max_local_ratio="5/4").verdict == "exceeds"
    assert fa.certify(counts(("f", 1, 1), ("m", 1, 1)), YES, max_local_ratio="5/4").verdict == "inconclusive"
    alike = fa.certify(counts(("f", 9000, 9000), ("m", 9000, 9000)), YES, max_local_ratio="5/4")
    assert alike.verdict == "within"
    for result in (fa.certify(few, YES, max_local_log="0.2"), alike):
        document = verified(result)
        assert {target["judged"] for target in document["targets"]} == {"population at confidence 19/20"}


def test_targets_share_the_error() -> None:
    """The verdicts on two targets hold together, be they on one quantity or on two: each then has half of the error."""
    law = counts(("f", 60, 40), ("m", 50, 50))
    both = fa.certify(law, YES, max_local_ratio=3, max_global_ratio=3, confidence="0.9")
    assert {i.confidence for i in both.intervals.values()} == {F(19, 20)}
    assert {t.confidence for t in both.targets} == {F(9, 10)}
    one = fa.certify(law, YES, max_local_ratio=3, max_local_log="1", confidence="0.9")
    assert {quantity: (i.confidence, i.ends) for quantity, i in one.intervals.items()} == {
        "local": (F(19, 20), "each"),
        "global": (F(9, 10), "together"),
    }
    verified(both)
    verified(one)


def test_targets_rest_on_one_sided_ends() -> None:
    """Clopper and Pearson's ends at the full error: α/2 for the two that bound a ratio from above, α/4 for the four below it."""
    law = counts(("f", 60, 40), ("m", 30, 70))
    found = fa.certify(law, YES, max_local_ratio=3)
    high = stats.beta.ppf(1 - 0.025, 61, 40) / stats.beta.ppf(0.025, 30, 71)
    low = stats.beta.ppf(0.0125, 60, 41) / stats.beta.ppf(1 - 0.0125, 31, 70)
    assert ends(found.intervals["local"]) == pytest.approx((low, high), rel=1e-6)
    together, each = "population at confidence 19/20", "population, one-sided at confidence 19/20"
    scopes = {(claim.quantity, claim.relation, claim.scope) for claim in found.claims if claim.by == "binomial"}
    wanted = {"local_ratio": each, "global_ratio": together}
    assert scopes == {(quantity, relation, scope) for quantity, scope in wanted.items() for relation in (">=", "<=")}
    assert {i.ends for i in fa.certify(law, YES).intervals.values()} == {"together"}
    verified(found)


def test_the_two_sided_interval_is_that_without_a_target() -> None:
    law = counts(("f", 60, 40), ("m", 50, 50))
    judged, plain = fa.certify(law, YES, max_local_ratio=3), fa.certify(law, YES)
    assert list(judged.two_sided) == ["local"] and not plain.two_sided
    two_sided, own = judged.two_sided["local"], judged.intervals["local"]
    assert ends(two_sided) == ends(plain.intervals["local"]) and two_sided.ends == "together"
    assert two_sided.lower <= own.lower <= own.upper < two_sided.upper


def test_zero_cells_and_lonely_groups() -> None:
    """A count of zero is not a chance of zero; a context with one group compares nobody."""
    result = fa.certify(counts(("f", 0, 30), ("m", 20, 10)), YES, max_local_ratio=2)
    assert result.local.ratio == float("inf") and result.intervals["local"].upper == float("inf")
    assert result.intervals["local"].lower > 2 and result.verdict == "exceeds"
    verified(result)
    rows = {"u": ["yes", "no", "yes"], "a": ["f", "m", "f"], "x": ["p", "q", "q"]}
    law = fa.Law.from_log(rows, decision="u", group="a", context="x")
    assert {"context": {"x": "p"}, "reason": "fewer than two groups"} in fa.certify(law, YES).not_compared
    verified(fa.certify(law, YES))


def test_weighted_counts_carry_no_sample_size() -> None:
    law = fa.Law.from_counts({"u": ["yes", "no"] * 2, "a": list("ffmm"), "n": ["1.5", 1, 1, 1]}, decision="u", group="a", count="n")
    result = fa.certify(law, YES)
    assert not result.intervals and any("whole counts" in note for note in result.notes)
    verified(result)
    with pytest.raises(InputError, match=r"'yes' at .* is not whole; an interval needs whole counts"):
        fa.certify(law, YES, max_local_log=1)
    assert fa.certify(law, YES, max_local_log=1, confidence=None).verdict == "within"


def test_more_draws_than_there_can_be() -> None:
    law = counts(("f", 10**19, 1), ("m", 1, 1))
    with pytest.raises(InputError, match="at most 10\\^18"):
        fa.certify(law, YES, max_local_log=1)
    assert not fa.certify(law, YES).intervals


def test_a_hundred_million_draws() -> None:
    result = fa.certify(counts(("f", 30_000_000, 20_000_000), ("m", 29_990_000, 20_010_000)), YES, max_local_ratio="101/100")
    assert result.verdict == "within"
    verified(result)


def test_many_cells_have_the_ratio_of_few() -> None:
    """With many cells only those that decide get narrow ends; the ratio is that of narrow ends everywhere."""
    pick = random.Random(3)
    array = [[[pick.randint(0, 60), pick.randint(1, 60)] for _ in range(2)] for _ in range(300)]
    law = fa.Law.from_array(array, kind="counts")
    result = fa.certify(law, {"0": 1})
    found = result.intervals["local"]
    verified(result)
    assert len(result.comparisons["local"].used) > 500
    cells, levels = result.comparisons["local"].cells, found.evidence["levels"]
    upper, lower = ([cell_ends(cell, F(levels[side])) for cell in cells] for side in ("upper", "lower"))
    pairs = [(i, i + 1) for i in range(0, 600, 2)] + [(i + 1, i) for i in range(0, 600, 2)]
    assert found.upper == max(upper[i][1] / upper[j][0] if upper[j][0] else float("inf") for i, j in pairs)
    assert found.lower == max(F(1), *(lower[i][0] / lower[j][1] for i, j in pairs))


def test_a_column_of_utilities_needs_a_range() -> None:
    rows = {"minutes": [3, 4, 5, 6], "a": list("ffmm")}
    law = fa.Law.from_log(rows, decision="minutes", group="a")
    utility = fa.Utility.from_table(rows, utility="minutes", decision="minutes", group="a")
    assert not fa.certify(law, utility).intervals
    with pytest.raises(InputError, match="greatest value seen there does not bound"):
        fa.certify(law, utility, max_local_log=1)
    result = fa.certify(law, utility, max_local_log=4, declared={"gamma": 60, "m": 1})
    assert result.intervals["local"].evidence["method"] == "hoeffding-kl"
    assert "a utility between 1 and 60" in " ".join(result.intervals["local"].assumptions)
    assert verified(result)["intervals"]["local"]["limits"] == ["1", "60"]


@pytest.mark.parametrize("method", ["hoeffding-kl", "empirical-bernstein", "intersection"])
@pytest.mark.parametrize("independent", [False, True])
def test_methods_for_many_values(method: Any, independent: bool) -> None:
    rows = {"u": list("abcabcbbbc") * 20, "a": list("ffffmmmmmm") * 20, "x": list("pqpqpqpqpq") * 20}
    law = fa.Law.from_log(rows, decision="u", group="a", context="x")
    result = fa.certify(law, {"a": 1, "b": "1/2"}, max_local_ratio=50, interval=method, independent=independent)
    document = verified(result)
    assert {claim["by"] for claim in document["claims"] if claim["relation"] == ">="} - {"T14", "T16"} == {method}
    assert result.intervals["local"].lower <= result.local.ratio <= result.intervals["local"].upper


# Sampling units


def test_units_that_were_asked_several_times() -> None:
    """Six answers of a profile are one draw, and the certificate shows how the units came out."""
    rows: dict[str, list[Any]] = {"u": [], "a": [], "profile": []}
    for i in range(40):
        for j in range(6):
            for name, value in (("u", "yes" if (i * 7 + j) % 3 else "no"), ("a", "fm"[i % 2]), ("profile", i)):
                rows[name].append(value)
    naive = fa.certify(fa.Law.from_log(rows, decision="u", group="a"), YES)
    law = fa.Law.from_log(rows, decision="u", group="a", unit="profile")
    result = fa.certify(law, YES, max_local_ratio=10)
    assert [cell.draws for cell in result.comparisons["local"].cells] == [20, 20]
    assert result.intervals["local"].upper > naive.intervals["local"].upper
    assert "global" not in result.intervals and any("no independent draws" in note for note in result.notes)
    stored = verified(result)["intervals"]["local"]["units"]
    assert [sum(n for n, _ in cell) for cell in stored] == [20, 20]
    with pytest.raises(InputError, match=r"no independent draws of it.*confidence none"):
        fa.certify(law, YES, max_global_log=1)


def test_runs_that_rank_one_candidate_of_each_group() -> None:
    """Each run has a row for each group: the rows of a group are independent, those of a run are not."""
    rows: dict[str, list[Any]] = {"u": [], "a": [], "run": []}
    for run in range(90):
        for a in "fmo":
            for name, value in (("u", "first" if "fmo"[run % 3] == a else "not"), ("a", a), ("run", run)):
                rows[name].append(value)
    result = fa.certify(fa.Law.from_log(rows, decision="u", group="a", unit="run"), {"first": 1}, max_global_ratio=5)
    assert set(result.intervals) == {"local", "global"}
    assert "units" not in verified(result)["intervals"]["local"]
    with pytest.raises(InputError, match="not independent"):
        fa.certify(fa.Law.from_log(rows, decision="u", group="a", unit="run"), {"first": 1}, independent=True)


# Policies that were sampled


def sampled(draws: int = 200, *, share: tuple[int, int] = (60, 30)) -> fa.Policy:
    rows = table(
        ("f", share[0] * draws // 100, draws - share[0] * draws // 100), ("m", share[1] * draws // 100, draws - share[1] * draws // 100)
    )
    return fa.Policy.from_counts(rows, decision="u", group="a", count="n")


def test_privacy_alone_bounds_what_few_draws_do_not() -> None:
    """Behind a filter with e^ε = 6/5 no ratio is above 6/5 (T2), and the interval knows it; without a filter these draws settle nothing."""
    coin = fa.RandomizedResponse(["f", "m"], exp_epsilon="6/5")
    result = fa.certify(sampled(20).behind(group=coin), YES, max_local_ratio="6/5")
    assert 1 < result.targets[0].upper[0] <= F(6, 5) and result.verdict == "within"
    verified(result)
    few = fa.certify(sampled(20).behind(group=fa.Identity(["f", "m"])), YES, max_local_ratio="6/5")
    assert few.verdict == "inconclusive" and few.targets[0].upper[1] == "the interval"
    verified(few)


def test_bounds_of_the_table_do_not_decide_about_the_population() -> None:
    """T3 at the floor that the drawn table has is about that table; only a declared floor counts."""
    deployed = sampled(10, share=(90, 80)).behind(group=fa.RandomizedResponse(["f", "m"], exp_epsilon=4))
    result = fa.certify(deployed, YES, max_local_ratio="3/2", all_bounds=True)
    assert [bound for bound in result.bounds if bound.scope == "this law" and bound.value <= F(3, 2)]
    assert result.verdict == "inconclusive"
    verified(result)
    declared = fa.certify(deployed, YES, max_local_ratio="3/2", declared={"tau": "0.8", "gamma": 1})
    assert declared.verdict == "within" and declared.targets[0].upper[1] in ("T1", "T3")
    assert declared.targets[0].upper[0] < declared.intervals["local"].upper
    verified(declared)


def test_a_policy_from_counts_with_contexts_and_a_population() -> None:
    rows = {
        "u": ["yes", "no"] * 4,
        "a": list("ffmmffmm"),
        "x": list("ppppqqqq"),
        "n": [30, 70, 50, 50, 45, 55, 60, 40],
    }
    policy = fa.Policy.from_counts(rows, decision="u", group="a", context="x", count="n")
    groups, contexts = fa.RandomizedResponse(["f", "m"], keep_probability="0.7"), fa.RandomizedResponse(["p", "q"], keep_probability="0.9")
    deployed = policy.behind(group=groups, context=contexts, population=[[1, 2], [3, 4]])
    for utility in (
        fa.Utility(YES),
        fa.Utility.from_function(lambda u, x, a: (u == "yes") * (1 + (x == ("q",)) + (a == ("m",))), deployed.law),
    ):
        result = fa.certify(deployed, utility, max_local_log=1, max_global_log=1, confidence="0.99")
        for quantity, measured in (("local", result.local), ("global", result.global_)):
            found = result.intervals[quantity]
            assert found.lower <= measured.ratio <= found.upper
        verified(result)


# The command line


@pytest.fixture
def run(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> Callable[..., tuple[int, str, str]]:
    path = tmp_path / "log.csv"
    path.write_text("u,a\n" + "yes,f\n" * 90 + "no,f\n" * 10 + "yes,m\n" * 30 + "no,m\n" * 70)

    def command(*options: str, verb: str = "certify") -> tuple[int, str, str]:
        start = [str(path), "--decision", "u", "--group", "a", "--utility", "yes"] if verb == "certify" else []
        code = main([verb, *start, *options])
        out, err = capsys.readouterr()
        return code, out, err

    return command


def test_certify_says_it_in_words(run: Callable[..., tuple[int, str, str]], tmp_path: Path) -> None:
    certificate = tmp_path / "c.json"
    code, out, _ = run("--max-local-ratio", "5/4", "-o", str(certificate), "--verbose")
    assert code == 1 and out.startswith("EXCEEDS")
    assert ", each at 95 % (3 in the table)" in out and "Two-sided" not in out
    assert "In the population from which these decisions were drawn" in out
    assert main(["verify", str(certificate)]) == 0
    code, out, _ = run("--max-local-ratio", "3", "--verbose")
    assert code == 3 and "Planning estimate" in out
    code, out, _ = run("--max-local-ratio", "3", "--confidence", "none", "--verbose")
    assert code == 0 and "this table, decided exactly" in out
    code, out, _ = run("--max-local-ratio", "3", "--max-local-log", "1", "--verbose")
    assert ", each at 97.5 % (3 in the table)" in out and "The verdicts on all targets hold together at confidence 95 %." in out


def test_the_two_sided_interval_is_printed_where_it_is_asked_for(run: Callable[..., tuple[int, str, str]]) -> None:
    plain = run("--verbose")[1]
    shown = next(line for line in plain.splitlines() if line.startswith("  local ratio R "))
    code, out, _ = run("--max-local-ratio", "5/4", "--two-sided")
    heading = "Two-sided (half the error on each side; may straddle a limit that the one-sided end decides)"
    assert code == 1 and out.split(f"{heading}\n")[1].splitlines()[0].split() == shown.split()
    found = envelope(run("--max-local-ratio", "5/4", "--two-sided", "--format", "json")[1])
    together = fa.certify(counts(("f", 90, 10), ("m", 30, 70)), YES).intervals["local"]
    assert found["details"]["two_sided"] == {"local": {"confidence": "19/20", "ratio": [str(together.lower), str(together.upper)]}}
    assert "two_sided" not in envelope(run("--max-local-ratio", "5/4", "--format", "json")[1])["details"]
    assert run("--two-sided", "--confidence", "none")[0] == 2


def joined(text: str) -> str:
    """A text without its line ends."""
    return " ".join(text.split())


def test_the_claim_of_a_filter_is_tested(run: Callable[..., tuple[int, str, str]]) -> None:
    """R = 3 in 200 draws: it refutes e^ε = 3/2, and not 5."""
    code, out, _ = run("--claimed-exp-epsilon", "3/2")
    assert code == 1 and "the filter is not what it claims" in joined(out)
    code, out, _ = run("--claimed-exp-epsilon", "5", "--format", "json")
    found = envelope(out)["details"]["findings"][0]
    assert code == 0 and found["refuted"] is False and any("fresh for each decision" in text for text in found["assumptions"])
    assert "if some shared a release, name it as the sampling unit (--unit)" in found["sentence"]


def test_a_utility_of_the_group_refutes_no_filter(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """Decisions alike, worth 1 to one group and 1/5 to the other: R = 5 says nothing of a filter (T11), for all that both share a range."""
    path = tmp_path / "log.csv"
    path.write_text("u,a,g\n" + "yes,f,1\nno,f,0\nyes,m,0.2\nno,m,0\n" * 100)
    columns = ["--decision", "u", "--group", "a", "--utility-column", "g", "--utility-range", "0,1"]
    assert main(["certify", str(path), *columns, "--claimed-exp-epsilon", "3/2"]) == 2
    out, err = capsys.readouterr()
    assert out == "" and "a utility that is the same for all groups" in err


def test_a_placebo_that_compares_nobody_within_contexts(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    effect, placebo = tmp_path / "effect.csv", tmp_path / "placebo.csv"
    effect.write_text("u,a,x\n" + "yes,f,1\nno,f,1\nyes,m,1\nno,m,1\n" * 20)
    placebo.write_text("u,e,x\n" + "yes,one,1\nno,one,1\nyes,two,2\nno,two,2\n" * 20)
    command = ["certify", str(effect), "--decision", "u", "--group", "a", "--context", "x", "--utility", "yes", "--format", "json"]
    assert main([*command, "--placebo", str(placebo), "--placebo-group", "e"]) == 0
    local, overall = envelope(capsys.readouterr().out)["details"]["findings"]
    assert local["rises"] is None and "nothing to compare" in local["sentence"]
    assert overall["rises"] is False


def test_a_placebo_is_a_noise_floor(run: Callable[..., tuple[int, str, str]], tmp_path: Path) -> None:
    quiet, loud, other = (tmp_path / f"{name}.csv" for name in ("quiet", "loud", "other"))
    quiet.write_text("u,edit\n" + "yes,one\nno,one\nyes,two\nno,two\n" * 200)
    loud.write_text("u,edit\n" + "yes,one\n" * 90 + "no,one\n" * 10 + "yes,two\n" * 30 + "no,two\n" * 70)
    other.write_text("v,edit\nyes,one\nno,two\n")
    code, out, _ = run("--placebo", str(quiet), "--placebo-group", "edit")
    assert code == 0 and "the effect rises above the noise floor" in joined(out)
    code, out, _ = run("--placebo", str(loud), "--placebo-group", "edit")
    assert code == 0 and "does not rise above the noise floor" in joined(out)
    code, _, err = run("--placebo", str(other), "--placebo-group", "edit")
    assert code == 2 and "the placebo: " in err and "other.csv: there is no column 'u'" in err
    code, _, err = run("--placebo", str(quiet))
    assert code == 2 and "quiet.csv: there is no column 'a'" in err


def test_options_that_do_not_fit(run: Callable[..., tuple[int, str, str]], tmp_path: Path) -> None:
    for options, words in (
        (["--confidence", "1.5"], "between 0 and 1"),
        (["--confidence", "0"], "between 0 and 1"),
        (["--unit", "run"], "no column 'run'"),
        (["--no-table", "--max-local-log", "1", "-o", str(tmp_path / "c.json")], "disclose the counts"),
    ):
        code, out, err = run(*options)
        assert (code, out) == (2, "") and words in err
    assert not (tmp_path / "c.json").exists()
    path = tmp_path / "p.csv"
    path.write_text("u,a,p\nyes,f,0.5\nno,f,0.5\nyes,m,0.4\nno,m,0.6\n")
    start = ["certify", str(path), "--decision", "u", "--group", "a", "--probability", "p", "--utility", "yes"]
    assert main([*start, "--max-local-log", "1"]) == 0
    assert main([*start, "--max-local-log", "1", "--confidence", "0.9"]) == 2
    assert main([*start, "--placebo", str(path)]) == 2


def test_an_audit_file_says_it_too(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (tmp_path / "log.csv").write_text("u,a,run\n" + "".join(f"{'yes' if i % 2 else 'no'},{'fm'[i % 3 == 0]},{i // 2}\n" for i in range(60)))
    audit = tmp_path / "audit.toml"
    head = '[law]\ntable = "log.csv"\ndecision = "u"\ngroup = "a"\nunit = "run"\n[utility]\nvalues = { yes = 1 }\n[targets]\n'
    head += "max_local_log = 9\n"
    audit.write_text(head + '[confidence]\nlevel = "0.9"\ninterval = "intersection"\n')
    assert main(["certify", str(audit), "-o", str(tmp_path / "c.json")]) in (0, 3)
    stored = json.loads((tmp_path / "c.json").read_text())["intervals"]["local"]
    assert (stored["confidence"], stored["method"]) == ("9/10", "intersection")
    assert main(["verify", str(tmp_path / "c.json")]) == 0
    for wrong, words in (
        ('interval = "bootstrap"', "interval is 'bootstrap'"),
        ("independent_cells = 1", "true or false"),
        ("level = 2", "between 0 and 1"),
        ("unit = 3", "unknown key 'unit'"),
    ):
        audit.write_text(head + f"[confidence]\n{wrong}\n")
        capsys.readouterr()
        assert main(["certify", str(audit)]) == 2
        assert words in capsys.readouterr().err


def test_planning(run: Callable[..., tuple[int, str, str]]) -> None:
    code, out, _ = run("--guess", "0.5,0.5", "--max-log", "0.2", verb="plan")
    assert code == 0 and "Planning estimate, not a guarantee" in out and "In all cells together" in out
    code, out, _ = run("--guess", "0.5,0.4", "--guess", "0.2,0.2", "--max-ratio", "5/4", verb="plan")
    assert code == 1 and "no number of draws" in out
    code, out, _ = run("--guess", "0.5,0.4", "--guess", "0.2,0.2", "--max-ratio", "2", "--format", "json", verb="plan")
    found = result_of(out)
    assert code == 0 and len(found["draws"]) == 4 and found["method"] == "the box of the ends of cells"
    assert found["by_context"] == found["by_group"] == [2 * found["draws"][0]] * 2 and F(4, 5) <= F(found["expected_power"]) < 1
    code, out, _ = run(
        *("--guess", "0.5", "--groups", "3", "--contexts", "2", "--shares", "1,1,2", "--max-ratio", "2", "--independent-cells"),
        *("--format", "json"),
        verb="plan",
    )
    few = result_of(out)
    assert code == 0 and few["by_group"][2] == 2 * few["by_group"][0] and few["draws"][:3] == few["draws"][3:]
    assert few["method"] == "the exact pair bound" and few["decides"] == "within"
    code, out, _ = run("--guess", "0.5,0.5", "--guess", "0.8,0.8", "--max-ratio", "3/2", "--independent-cells", verb="plan")
    assert code == 0 and "The verdict hangs on context 1, groups 1 and 2." in out and "About as good: in contexts 1, 2" in out
    code, out, _ = run("--guess", "0.5,0.5", "--units", "--max-ratio", "3/2", verb="plan")
    assert code == 0 and "units per cell" in out and "In all cells together" in out
    for options, words in (
        (["--guess", "0.5", "--max-log", "1"], "names one group"),
        (["--guess", "0.5", "--groups", "1", "--max-log", "1"], "--groups 1 is not accepted"),
        (["--guess", "0.5,0.5", "--groups", "2", "--max-log", "1"], "one guess for all groups"),
        (["--guess", "0.5,0.5", "--guess", "0.5,0.5", "--contexts", "2", "--max-log", "1"], "--guess once"),
        (["--guess", "0.5,0.5", "--shares", "1,0", "--max-log", "1"], "shares are needed for every group"),
        (["--guess", "0.5,2", "--max-log", "1"], "between 0 and 1"),
        (["--guess", "0.5,x", "--max-log", "1"], "'x' is not a number"),
        (["--guess", "0.5,0.5", "--max-log", "-1"], "at least 0"),
        (["--guess", "0.5,0.5", "--max-log", "1", "--power", "0.2"], "between 0.5 and 1"),
        (["--guess", "0.5,0.5", "--max-log", "1", "--confidence", "7"], "between 0 and 1"),
    ):
        code, _, err = run(*options, verb="plan")
        assert code == 2 and words in err, (options, err)


# Real data: what docs/sampling.md says of three audits


def ends(interval: Any) -> tuple[float, float]:
    return float(interval.lower), float(interval.upper)


def test_first_places(data: Path) -> None:
    law = fa.Law.from_counts(
        fa.read_csv(data / "gpt_resume_first_counts.csv"), decision="decision", group="group", context=["model", "job"], count="n"
    )
    result = fa.certify(law, {"first": 1}, max_local_ratio="5/4")
    assert result.local.ratio == F(43, 19) and result.verdict == "inconclusive"
    # An upper end rests on two ends of cells, a lower one on both of all 64.
    drawn = {(x, a): law.row(i) for i, (x, a) in enumerate(zip(law.cell_context.tolist(), law.cell_group.tolist(), strict=True))}
    pairs = [(drawn[x, a], drawn[x, b]) for (x, a), (y, b) in permutations(drawn, 2) if x == y]
    above, below = ([[clopper_pearson(sum(row), row[0], level) for row in pair] for pair in pairs] for level in (0.05 / 2, 0.05 / 128))
    assert law.decisions[0] == "first" and len(drawn) == 64
    low, high = max(one[0] / other[1] for one, other in below), max(one[1] / other[0] for one, other in above)
    assert ends(result.intervals["local"]) == pytest.approx((low, high), rel=1e-5)
    assert fa.certify(law, {"first": 1}, max_local_ratio="6/5").verdict == "exceeds"
    verified(result)


def test_rankings_with_the_run_as_unit(data: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    lines = (data / "bloomberg_gpt_rankings.csv").read_text("utf-8").splitlines(keepends=True)
    shown = {"gpt-3.5-turbo": (1, "at least 1.283, at most 3.263, each at 95 %"), "gpt-4": (3, "at least 1, at most 2.010, each at 95 %")}
    for model, (code, words) in shown.items():
        path = tmp_path / "runs.csv"
        path.write_text("".join([lines[0], *(line for line in lines[1:] if line.startswith(f"{model},") and "oversampled" not in line)]))
        command = ["certify", str(path), "--slots", "shown_order", "--winner", "ranked_order", "--context", "job"]
        assert main([*command, "--max-local-ratio", "5/4", "--verbose", "-o", str(tmp_path / "c.json")]) == code
        out = capsys.readouterr().out
        assert words in out, out
        assert main(["verify", str(tmp_path / "c.json")]) == 0
        assert main(["verify", str(tmp_path / "c.position.json")]) == 0
        capsys.readouterr()


def test_names_and_placebo(data: Path, capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    command = ["certify", str(data / "hiringbias_firstname.csv"), "--decision", "recommend_interview", "--group", "name"]
    command += ["--context", "model", "--utility", "maybe=1,yes=1", "--max-local-ratio", "5/4"]
    placebo = ["--placebo", str(data / "hiringbias_placebo.csv"), "--placebo-group", "placebo", "--format", "json"]
    assert main([*command, *placebo]) == 3
    printed = envelope(capsys.readouterr().out)
    assert [finding["rises"] for finding in printed["details"]["findings"]] == [False, False]
    assert printed["result"]["metrics"]["local"]["ratio"] == "3/2"
    assert main([*command, "--unit", "model,jd,name", "-o", str(tmp_path / "c.json")]) == 3
    captured = capsys.readouterr()
    assert "1122 draws" in captured.err
    assert main(["verify", str(tmp_path / "c.json")]) == 0


@pytest.mark.parametrize("worth", [1, {"yes": 1, "maybe": "0.5"}])
def test_a_method_that_nobody_knows(worth: Any) -> None:
    """It would stand in the certificate, which no checker accepts then, though binary utilities need none of the three."""
    decisions = ["yes", "no", "maybe", "yes"] if isinstance(worth, dict) else ["yes", "no", "no", "yes"]
    law = fa.Law.from_log({"a": list("ffmm"), "u": decisions}, decision="u", group="a")
    with pytest.raises(InputError, match=r"the method 'hoeffding' is not known; .*hoeffding-kl"):
        fa.certify(law, worth if isinstance(worth, dict) else {"yes": worth}, interval="hoeffding")  # type: ignore[arg-type]


# Certificates that somebody wrote by hand


def of_one(law: fa.Law, quantities: list[str], interval: dict[str, Any]) -> dict[str, Any]:
    """A certificate of a law with the given intervals, and the claims and the verdict that would follow from them."""
    document: dict[str, Any] = fa.certify(law, {"yes": 1}, max_local_ratio="5/4").certificate.document
    document["intervals"] = dict.fromkeys(quantities, interval)
    document["claims"] = [
        claim | ({"value": "1", "by": "binomial"} if claim["scope"].startswith("population") else {})
        for claim in document["claims"]
        if not claim["scope"].startswith("population") or claim["evidence"]["interval"] in quantities
    ]
    document["targets"][0]["verdict"] = document["verdict"] = "within"
    return document


@pytest.mark.parametrize("elsewhere", [False, True])
def test_a_range_that_the_table_contradicts_proves_nothing(elsewhere: bool) -> None:
    """Everybody who is compared was hired, so that a range from 1 to 1 leaves nothing to be estimated; but "no" is worth 0."""
    log = {"hired": ["yes"] * 6, "sex": list("fffmmm"), "job": ["A"] * 6}
    if elsewhere:
        log = {"hired": [*log["hired"], "no"], "sex": [*log["sex"], "f"], "job": [*log["job"], "B"]}
    law = fa.Law.from_log(log, decision="hired", group="sex", context="job")
    if not elsewhere:
        counts = {"hired": ["yes", "no"] * 2, "sex": list("ffmm"), "n": [3, 0, 3, 0]}
        law = fa.Law.from_counts(counts, decision="hired", group="sex", count="n")
    certain = [["1", "1"], ["1", "1"]]
    interval = {
        "confidence": "19/20",
        "ends": "together",
        "region": "box",
        "independent": False,
        "method": "hoeffding-kl",
        "limits": ["1", "1"],
        "ratio": ["1", "1"],
        "levels": {"upper": "0", "lower": "0"},
        "upper": certain,
        "lower": certain,
        "pair": None,
    }
    report = checker.check(json.dumps(of_one(law, ["local"], interval)).encode())
    assert any("a utility in the table is outside the limits" in finding.detail for finding in report.findings if not finding.true)


def test_units_of_one_interval_hold_for_the_other() -> None:
    """Twenty runs of two rows each are no forty draws of a group, whichever ratio is asked for."""
    log = {"sex": list("ffmm") * 20, "hired": ["yes", "no"] * 40, "run": [i // 2 for i in range(80)]}
    rows, runs = (fa.Law.from_log(log, decision="hired", group="sex", unit=unit) for unit in (None, "run"))
    document: dict[str, Any] = fa.certify(rows, {"yes": 1}).certificate.document
    assert all(f.true for f in checker.check(json.dumps(document).encode()).findings)
    units = fa.certify(runs, {"yes": 1}).certificate.document
    document["intervals"]["local"] = units["intervals"]["local"]
    of_local = {"evidence": {"interval": "local"}}
    document["claims"] = [c for c in document["claims"] if c["evidence"] != of_local["evidence"]]
    document["claims"] += [c for c in units["claims"] if c["evidence"] == of_local["evidence"]]
    false = [finding.detail for finding in checker.check(json.dumps(document).encode()).findings if not finding.true]
    assert false[0] == "the units of the local interval are no independent draws of the groups"


def test_only_units_that_could_not_be_compared_with_themselves_are_explained() -> None:
    """Too many units that lack a group are a reason; a method that was asked for is not."""
    seen = [(i, a, "yes" if (i + (a == "f")) % 3 else "no") for i in range(40) for a in "fm" if a == "f" or i % 2]
    run, group, said = zip(*seen, strict=True)
    law = fa.Law.from_log({"run": list(run), "a": list(group), "u": list(said)}, decision="u", group="a", unit="run")
    reason = "the local ratio does not compare groups within the units of column 'run': 20 of 40 were not seen in all groups"
    assert [note.startswith(reason) for note in fa.certify(law, {"yes": 1}).notes].count(True) == 1
    assert not any("within the units" in note for note in fa.certify(law, {"yes": 1}, interval="hoeffding-kl").notes)


def test_units_that_plainly_do_not_lack_a_group_by_design_are_pointed_out() -> None:
    """Those in both groups are the tenth that got something."""
    seen = [(i, "f", "yes" if i >= 900 else "no") for i in range(1000)] + [(i, "m", "yes" if i % 2 else "no") for i in range(900, 1000)]
    run, group, said = zip(*seen, strict=True)
    law = fa.Law.from_log({"run": list(run), "a": list(group), "u": list(said)}, decision="u", group="a", unit="run")
    notes = fa.certify(law, {"yes": 1}, missing_units="drop").notes
    assert sum("do not seem to be like the others" in note for note in notes) == 1
    assert not any("do not seem" in note for note in fa.certify(law, {"yes": 1}).notes)


def test_answers_that_were_not_drawn_have_no_population() -> None:
    """A log that states a fixed seed: epochs of fixed questions repeat one answer, so only drawn questions leave an interval."""
    from dataclasses import replace

    from fairaudit.tables.evaluations.samples import Drawn, Evaluation, Run
    from fairaudit.tables.tally import Tally

    cells = [(["yes", "no"][n % 2], "fm"[n % 4 // 2], n, e, 1) for n in range(40) for e in (1, 2)]
    tally = Tally.of("log", ("u", "a", "id", "epoch"), cells)

    def law(drawn: Drawn, fixed: str, unit: tuple[str, ...]) -> fa.Law:
        run = Run("inspect", epochs=2, fixed=fixed)
        asked = Evaluation("inspect", epochs=2, question="id", unit=unit, drawn=drawn, runs=(("log", run),))
        evaluation = replace(asked, expected=80, read=80, counted=80)
        return fa.Law.from_log(replace(tally, evaluation=evaluation), decision="u", group="a", unit=unit)

    with pytest.raises(InputError, match=r"the log says seed 7: .* nothing was drawn; confidence none judges"):
        fa.audit(law("answers", "seed 7", ("id", "epoch")), utility=YES)
    assert not fa.audit(law("answers", "seed 7", ("id", "epoch")), utility=YES, confidence=None).intervals
    assert fa.audit(law("answers", "", ("id", "epoch")), utility=YES).intervals
    assert fa.audit(law("questions", "seed 7", ("id",)), utility=YES).intervals


@pytest.mark.parametrize(
    ("groups", "contexts", "said"),
    [
        ("ab", "xy", ""),
        ("cd", "xy", ""),
        ("abc", "xy", "The placebo has 3 groups against 2 of the table: the greatest ratio of more of them is greater by chance alone."),
        ("ab", "x", "The placebo has 1 context against 2 of the table: the greatest ratio of more of them is greater by chance alone."),
        ("ab", "xz", "The placebo has no context 'y': chance may be another one there."),
    ],
)
def test_a_placebo_of_other_groups_or_contexts(
    groups: str, contexts: str, said: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    for name, its_groups, its_contexts in (("effect.csv", "ab", "xy"), ("placebo.csv", groups, contexts)):
        rows = [f"{u},{a},{x},{n}" for a in its_groups for x in its_contexts for u, n in (("yes", 30), ("no", 40))]
        (tmp_path / name).write_text("\n".join(["u,a,x,n", *rows]))
    command = [
        "certify",
        str(tmp_path / "effect.csv"),
        "--decision",
        "u",
        "--group",
        "a",
        "--context",
        "x",
        "--count",
        "n",
        "--utility",
        "yes",
    ]
    assert main([*command, "--placebo", str(tmp_path / "placebo.csv")]) == 0
    out = " ".join(capsys.readouterr().out.split())
    assert said in out and ("The placebo has" in out) == bool(said)
