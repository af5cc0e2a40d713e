# make run    set up a fresh machine and bring the robot up   (ARGS="--headless --duration 5")
# make test   every test          make check   format, lint, types, layers, unit tests
# make bench  the measurements    make clean   remove what was made

VENV ?= .venv
ARGS ?=
BIN  := $(VENV)/bin
RUN  := $(VENV)/.stamp-run
DEV  := $(VENV)/.stamp-dev

.DEFAULT_GOAL := help
.PHONY: help run setup dev check lint format unit test bench clean

help:
	@sed -n 's/^# //p' Makefile

run: $(RUN)
	@$(BIN)/tool0 bringup $(ARGS)

setup: $(RUN)

dev: $(DEV)

check: lint unit

lint: $(DEV)
	$(BIN)/ruff format --check .
	$(BIN)/ruff check .
	$(BIN)/mypy
	$(BIN)/lint-imports

format: $(DEV)
	$(BIN)/ruff check --fix .
	$(BIN)/ruff format .

unit: $(DEV)
	$(BIN)/python -m pytest tests/unit $(ARGS)

test: $(DEV)
	$(BIN)/python -m pytest $(ARGS)

bench: $(DEV)
	$(BIN)/python benchmarks/run.py $(ARGS)

clean:
	rm -rf $(VENV) build dist .mypy_cache .ruff_cache .pytest_cache .import_linter_cache .hypothesis

# The stamps: what they depend on is newer, so install again; otherwise do nothing.
$(RUN): pyproject.toml tools/setup-venv
	@tools/setup-venv $(VENV)
	$(BIN)/python -m pip install --quiet --disable-pip-version-check --editable .
	@touch $@

# `pip install --group` came with pip 25.1; a distribution's pip is older.
$(DEV): $(RUN)
	$(BIN)/python -m pip install --quiet --disable-pip-version-check 'pip>=25.1'
	$(BIN)/python -m pip install --quiet --disable-pip-version-check --group dev
	@touch $@
