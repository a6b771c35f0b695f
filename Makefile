# On a fresh machine with Python 3.11 or newer and a network:
#   make demo    set up, then run the main job on the demo measurements
#   make view    the same, opened in the browser
#   make test    set up, then run all tests
# Before a commit: make lint types test

PYTHON ?= python3
VENV ?= .venv
WORKERS ?= 2

BIN := $(VENV)/bin
READY := $(VENV)/.installed

# One thread per process: the tests run side by side.
ONE_THREAD := OMP_NUM_THREADS=1 OPENBLAS_NUM_THREADS=1

.PHONY: help setup demo view test lint types format clean
.DEFAULT_GOAL := help

help:
	@sed -n '2,5s/^# *//p' Makefile

setup: $(READY)

$(READY): pyproject.toml
	@$(PYTHON) -c 'import sys; sys.exit(None if sys.version_info >= (3, 11) else "brdfit needs Python 3.11 or newer but $(PYTHON) is " + sys.version.split()[0] + ". Name another one: make PYTHON=python3.12 ...")'
	$(PYTHON) -m venv $(VENV)
	$(BIN)/python -m pip install --quiet --disable-pip-version-check --editable '.[dev,all]'
	@touch $@

demo: $(READY)
	$(BIN)/python -m brdfit demo --output demo-output

view: demo
	$(BIN)/python -m brdfit view demo-output/demo.binary

test: $(READY)
	$(ONE_THREAD) $(BIN)/python -m pytest -n $(WORKERS)

lint: $(READY)
	$(BIN)/python -m ruff check .
	$(BIN)/python -m ruff format --check .

format: $(READY)
	$(BIN)/python -m ruff check --fix .
	$(BIN)/python -m ruff format .

types: $(READY)
	$(BIN)/python -m mypy --strict src

clean:
	rm -rf $(VENV) demo-output build dist .mypy_cache .pytest_cache .ruff_cache .hypothesis
	find . -name __pycache__ -type d -prune -exec rm -rf {} +
