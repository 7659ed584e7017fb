"""Settings shared by all tests: a fixed hypothesis profile, where the sample data are, which cases run when, what a machine lacks."""

from __future__ import annotations

import inspect
import os
import re
import sys
from collections import defaultdict
from functools import cache
from pathlib import Path

import needs
import parts
import pytest
import tiers
from browser import browser as browser
from hypothesis import HealthCheck, settings
from logs import files as files
from servers import postgres as postgres

settings.register_profile(
    "ci",
    max_examples=int(os.environ.get("FAIRAUDIT_EXAMPLES", tiers.size(20, 50))),
    deadline=None,
    derandomize=not tiers.SEED,
    database=None,
    print_blob=True,
    suppress_health_check=[HealthCheck.too_slow, HealthCheck.data_too_large],
)
settings.load_profile("ci")

# Tests start our command hundreds of times: it is compiled once, whatever the environment says of bytecode.
os.environ.pop("PYTHONDONTWRITEBYTECODE", None)
sys.dont_write_bytecode = False


CASES = pytest.StashKey[list[parts.Case]]()


def pytest_addoption(parser: pytest.Parser) -> None:
    """Options of the Makefile's targets."""
    parser.addoption("--part", help="run one part of the cases only, such as 2/4: by their names, so that each stays where it is")
    parser.addoption("--parts", action="store_true", help="print how many cases of each tier test each part of the mission")


def pytest_configure(config: pytest.Config) -> None:
    """In the deep tier whatever is named runs; the quick one starts nothing heavy."""
    if tiers.DEEP and config.option.markexpr == "not deep":
        config.option.markexpr = "" if tiers.FULL else "deep or again"
    if tiers.SEED and config.getoption("hypothesis_seed", None) is None:
        config.option.hypothesis_seed = str(tiers.SEED)
    if config.option.markexpr == "quick":
        sys.addaudithook(_nothing_heavy)


def pytest_report_header(config: pytest.Config) -> list[str]:
    """Say at the start how long it takes, what is skipped, and how to repeat a run."""
    return needs.report() + tiers.repeat(config.getoption("part"))


@pytest.hookimpl(tryfirst=True)
def pytest_collection_modifyitems(config: pytest.Config, items: list[pytest.Item]) -> None:
    """Give each case its tier, and leave out what is in another part."""
    record, functions = tiers.recorded(), defaultdict(list)
    for item in items:
        functions[item.nodeid.partition("[")[0]].append(item)
    cases = config.stash[CASES] = []
    for same in functions.values():
        wanted = _needs(same[0])
        core = same[0].get_closest_marker("core") is not None
        kept = tiers.kept(record.get(tiers.function(same[0].name)), core, len(same))
        for number, item in enumerate(same):
            if number not in kept or item.get_closest_marker("deep"):
                tier = "deep"
            else:
                tier = "default" if wanted or tiers.function(item.name) in record else "quick"
            if tier != "default":
                item.add_marker(tier)
            if getattr(getattr(item, "obj", None), "is_hypothesis_test", False):
                item.add_marker("again")
            cases.append(parts.Case(item.nodeid, tier, wanted))
    if config.getoption("part"):
        number, of = map(int, config.getoption("part").split("/"))
        elsewhere = [item for item in items if tiers.part_of(item.nodeid, of) != number % of]
        config.hook.pytest_deselected(items=elsewhere)
        items[:] = [item for item in items if tiers.part_of(item.nodeid, of) == number % of]


def pytest_report_collectionfinish(config: pytest.Config) -> list[str]:
    """The table of ``make parts``."""
    return parts.markdown(config.stash[CASES]) if config.getoption("parts") else []


@cache
def _text(path: Path) -> str:
    return path.read_text("utf-8")


def _needs(item: pytest.Item) -> frozenset[str]:
    """Heavy programs that a case, or a fixture that it asks for, starts."""
    wanted = [(name, need.used) for name, need in needs.HEAVY.items() if isinstance(item, pytest.Function)]
    wanted = [(name, used) for name, used in wanted if re.search(used, _text(item.path))]
    if not wanted:
        return frozenset()
    fixtures = [each[-1].func for each in item._fixtureinfo.name2fixturedefs.values()]  # type: ignore[attr-defined]
    text = "".join(inspect.getsource(each) for each in (item.function, *fixtures))  # type: ignore[attr-defined]
    return frozenset(name for name, used in wanted if re.search(used, text))


def _nothing_heavy(event: str, arguments: tuple[object, ...]) -> None:
    """Refuse a heavy program in the quick tier."""
    if event == "subprocess.Popen":
        program = Path(os.fsdecode(arguments[0])).name  # type: ignore[arg-type]
        if program in needs.HEAVY_PROGRAMS:
            raise RuntimeError(f"a quick test starts {program}: mark it with @pytest.mark.deep or @pytest.mark.core")


@pytest.fixture(scope="session")
def cases(request: pytest.FixtureRequest) -> list[parts.Case]:
    """All cases with their tiers; the test skips where not all of them were collected."""
    found = request.config.stash[CASES]
    if len({case.name.partition("::")[0] for case in found}) < len(list(needs.TESTS.rglob("test_*.py"))):
        pytest.skip("only some of the tests were collected")
    return found


@pytest.fixture(scope="session")
def data() -> Path:
    """Directory of the sample data; the test skips where they are absent."""
    if not needs.DATA.is_dir():
        pytest.skip("the sample data are not on this machine (expected in shared/data beside the checkout)")
    return needs.DATA
