# Set-up, tests and the first map. Everything lives in .venv; no other state is kept outside the checkout.
PYTHON ?= $(shell for p in python3.11 python3; do $$p -c '' 2>/dev/null && echo $$p && break; done)
SHELL := /bin/bash
BIN := .venv/bin
STAMP := .venv/.installed
PYTEST := $(BIN)/python -m pytest -n 2 --dist loadfile
COVERED ?=

# One thread a process: two solves or two test workers must not fight for the same cores.
export OMP_NUM_THREADS := 1
export PIP_NO_INPUT := 1
export PIP_DISABLE_PIP_VERSION_CHECK := 1

.DEFAULT_GOAL := help
.PHONY: help venv run lint test slow-tests slurm-tests all-tests constraints clean

help:  ## this list
	@grep -E '^[a-z-]+:.*## ' $(MAKEFILE_LIST) | sed -E 's/^([a-z-]+):.*## /\1\t/' | expand -t 14

venv: $(STAMP)  ## create .venv with everything, or reuse it

$(STAMP): pyproject.toml constraints.txt
	@$(or $(PYTHON),false) -c 'import sys; sys.exit(sys.version_info < (3, 11))' || \
	  { echo "gaitflow needs Python 3.11 or newer; name one with: make PYTHON=/path/to/python3.11"; exit 1; }
	test -x $(BIN)/pip || $(PYTHON) -m venv --clear .venv
	$(BIN)/pip install --quiet --constraint constraints.txt --editable ".[all,mlp,dev]"
	@touch $@

run: $(STAMP)  ## map the quickstart scenario, train, publish, answer a query, draw the map
	$(BIN)/gaitflow run quickstart

lint: $(STAMP)  ## style, types and import rules
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/mypy
	$(BIN)/lint-imports
	$(BIN)/hadolint container/Dockerfile

test: lint  ## lint and the fast tests, with Slurm's when it is installed; COVERED=96 wants 96 % of the package run
	$(PYTEST) -m "not slow" $(if $(COVERED),--cov --cov-report=term:skip-covered --cov-fail-under=$(COVERED))

slow-tests: $(STAMP)  ## the slow tests only
	$(PYTEST) -m "slow and not slurm" --timeout=600

# They mostly wait, so three run at once, each worker in a Slurm of its own.
slurm-tests: $(STAMP)  ## every test on a real Slurm (apt-get install slurm-wlm munge slurmdbd mariadb-server)
	$(BIN)/python -m pytest -n 3 --dist load -m slurm --durations=5

all-tests: lint  ## lint and every test, fast and slow
	$(PYTEST) -m "not slurm" --timeout=600

constraints: $(STAMP)  ## write constraints.txt from what is installed now
	$(BIN)/pip freeze --exclude-editable | sed 's/+[a-z0-9.]*$$//' > constraints.txt

clean:  ## delete .venv and caches; keeps runs/, datasets/ and models/
	rm -rf .venv build dist *.egg-info .coverage* .pytest_cache .mypy_cache .ruff_cache .import_linter_cache .hypothesis .snakemake
	find . -name __pycache__ -not -path './.git/*' -prune -exec rm -rf {} +
