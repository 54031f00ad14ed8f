# Both main targets set everything up themselves: a Python >= 3.11, git and make are enough.

PYTHON ?= python3
VENV := .venv
BIN := $(VENV)/bin
INSTALLED := $(VENV)/.installed

# The tests start hundreds of processes, which would each compile the package's sources.
unexport PYTHONDONTWRITEBYTECODE

# Tests run on all cores: more threads in each would wait for each other.
test nightly: export OPENBLAS_NUM_THREADS = 1

LINTERS := mypy pyright ruff format codespell prose imports derivation
LINT := $(LINTERS:%=lint-%)

.PHONY: report paper docs test nightly coverage lint $(LINT) bench mutants planted clean

report: $(INSTALLED)  ## write report/README.md with its tables and figures
	$(BIN)/python -m analysis

paper: $(INSTALLED)  ## write report/paper.md, the paper reproduced
	$(BIN)/python -m analysis paper

docs: $(VENV)/.documented  ## write the documentation to docs/_build/html; no network is needed
	$(BIN)/python -m sphinx -q -W --keep-going -b html docs docs/_build/html

test: $(INSTALLED)  ## run the tests on all cores
	$(BIN)/python -m pytest -n auto --dist worksteal

nightly: $(INSTALLED)  ## compare all engines and the golden data with the tests' oracle, and run all tests whole
	$(BIN)/python -m tests.nightly --scenes 5000
	$(BIN)/python -m tests.oracle_check --sample 5 --seed $$(date +%j)
	$(BIN)/python -m pytest -n auto --dist worksteal --nightly

coverage: $(INSTALLED)  ## run the tests, and print what they do not reach
	$(BIN)/python -m pytest -n auto --cov --cov-report=term

lint: $(INSTALLED)  ## run the linters, several at once
	$(MAKE) --jobs=4 $(LINT)

lint-mypy lint-pyright: lint-%: $(INSTALLED)
	$(BIN)/python -m tests.snippets $*

lint-ruff: $(INSTALLED)
	$(BIN)/ruff check

lint-format: $(INSTALLED)
	$(BIN)/ruff format --check

lint-codespell: $(INSTALLED)
	$(BIN)/codespell

lint-prose: $(INSTALLED)
	$(BIN)/python -m tests.prose

lint-imports: $(INSTALLED)
	$(BIN)/lint-imports

lint-derivation: $(INSTALLED)
	$(BIN)/python -m longball.model.derivation --check

mutants: $(INSTALLED)  ## plant small faults at random and count those that the tests notice; takes hours
	$(BIN)/python tests/mutants.py --sample 300

planted: $(INSTALLED)  ## measure how often the judge names a mistake rightly; takes hours
	$(BIN)/python -m tests.planted.measure --jobs 2

bench: $(INSTALLED)  ## time the engines side by side, with the peers that are installed
	$(BIN)/python -m analysis.bench

# pip compiles file by file; here all cores do, and leave out the libraries' own tests.
$(INSTALLED): pyproject.toml constraints.txt
	$(PYTHON) -m venv $(VENV)
	$(BIN)/python -m pip install --quiet --disable-pip-version-check --no-compile --constraint constraints.txt --editable '.[test,lint]'
	-$(BIN)/python -m compileall -qq -j 0 -x '/tests?/' $(VENV)/lib
	touch $@

$(VENV)/.documented: $(INSTALLED)
	$(BIN)/python -m pip install --quiet --disable-pip-version-check --constraint constraints.txt --editable '.[docs]'
	touch $@

clean:  ## remove what the other targets made
	rm -rf $(VENV) docs/_build docs/report .pytest_cache .mypy_cache .ruff_cache .hypothesis
